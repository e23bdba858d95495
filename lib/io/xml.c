/* xml.c -- expat behind xml.h: the only user of it. */
#include "xml.h"

#include <expat.h>
#include <string.h>

enum { DEEPEST = 64, PIECE = 1 << 24 };

typedef struct walk {
    const sn_blob *blob;
    sn_error *error;
    XML_Parser parser;
    sn_xml_visit start, end;
    void *user;
    int depth;
    sn_status status; /* of a visit, or of ours */
} walk;

const char *sn_xml_attribute(const sn_xml_tag *tag, const char *name) {
    for (const char *const *a = tag->attributes; a != NULL && a[0] != NULL; a += 2) {
        if (strcmp(a[0], name) == 0) return a[1];
    }
    return NULL;
}

static sn_status fail_here(const walk *w, const char *text) {
    return sn_fail_at(w->error, SN_ERROR_INPUT, w->blob->name, (int64_t)XML_GetCurrentLineNumber(w->parser), "%s", text);
}

static void stop(walk *w, sn_status status) {
    w->status = status;
    XML_StopParser(w->parser, XML_FALSE);
}

/* The tag that the parser is at. */
static sn_xml_tag current_tag(const walk *w, const char *name, const char *const *attributes) {
    sn_xml_tag tag = {.name = name, .attributes = attributes, .depth = w->depth};
    tag.begin = (size_t)XML_GetCurrentByteIndex(w->parser);
    tag.end = tag.begin + (size_t)XML_GetCurrentByteCount(w->parser);
    tag.line = (int64_t)XML_GetCurrentLineNumber(w->parser);
    for (size_t i = tag.begin; i < tag.end; i++) tag.line += w->blob->data[i] == '\n';
    return tag;
}

static void XMLCALL on_start(void *user, const char *name, const char **attributes) {
    walk *w = user;
    if (w->status != SN_OK) return;
    if (w->depth == DEEPEST) {
        stop(w, fail_here(w, "the elements are nested too deep; nothing that is read here needs that"));
        return;
    }
    sn_xml_tag tag = current_tag(w, name, attributes);
    w->depth++;
    sn_status status = w->start(w->user, &tag);
    if (status != SN_OK) stop(w, status);
}

static void XMLCALL on_end(void *user, const char *name) {
    walk *w = user;
    if (w->status != SN_OK) return;
    w->depth--;
    sn_xml_tag tag = current_tag(w, name, NULL);
    sn_status status = w->end(w->user, &tag);
    if (status != SN_OK) stop(w, status);
}

/* Without a document type there are no entities but the five of XML itself. */
static void XMLCALL on_doctype(void *user, const char *name, const char *system_id, const char *public_id, int has_internal) {
    walk *w = user;
    (void)name, (void)system_id, (void)public_id, (void)has_internal;
    stop(w, fail_here(w, "the file declares a document type, which is not read; remove the line <!DOCTYPE ...>"));
}

static sn_status fail_parse(const walk *w) {
    enum XML_Error code = XML_GetErrorCode(w->parser);
    if (code == XML_ERROR_NO_MEMORY) return sn_fail_memory(w->error, "the XML parser");
    return sn_fail_at(w->error, SN_ERROR_INPUT, w->blob->name, (int64_t)XML_GetCurrentLineNumber(w->parser), "the XML is broken: %s",
                      XML_ErrorString(code));
}

/* In pieces: a length of the parser is an int. */
static sn_status parse_pieces(walk *w) {
    for (size_t at = 0;;) {
        size_t left = w->blob->size - at, size = left < PIECE ? left : PIECE;
        enum XML_Status parsed = XML_Parse(w->parser, w->blob->data + at, (int)size, size == left);
        if (w->status != SN_OK) return w->status == SN_STOPPED ? SN_OK : w->status;
        if (parsed != XML_STATUS_OK) return fail_parse(w);
        if (size == left) return SN_OK;
        at += size;
    }
}

sn_status sn_xml_walk(const sn_blob *blob, sn_xml_visit start, sn_xml_visit end, void *user, sn_error *error) {
    walk w = {.blob = blob, .error = error, .start = start, .end = end, .user = user};
    w.parser = XML_ParserCreate(NULL);
    if (w.parser == NULL) return sn_fail_memory(error, "the XML parser");
    XML_SetUserData(w.parser, &w);
    XML_SetElementHandler(w.parser, on_start, on_end);
    XML_SetStartDoctypeDeclHandler(w.parser, on_doctype);
    sn_status status = parse_pieces(&w);
    XML_ParserFree(w.parser);
    return status;
}
