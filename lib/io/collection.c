/* collection.c -- a PVD collection: which file of a sequence belongs to which time. */
#include "collection.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SUFFIX = 32 }; /* room for ".0000.vtp" of any frame, or ".pvd" */
static const char head[] =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n";
static const char tail[] = "</Collection>\n</VTKFile>\n";

sn_status sn_collection_open(sn_collection *collection, const char *prefix, sn_error *error) {
    size_t size = strlen(prefix) + SUFFIX;
    *collection = (sn_collection){.prefix = sn_strdup(prefix), .path = sn_alloc(size, 1), .path_size = size};
    if (collection->prefix == NULL || collection->path == NULL) return sn_fail_memory(error, "a collection of frames");
    snprintf(collection->path, size, "%s.pvd", prefix);
    sn_status status = sn_output_open(collection->path, false, &collection->output, error);
    if (status != SN_OK) return status;
    return sn_output_write(collection->output, head, strlen(head), error);
}

const char *sn_collection_frame(sn_collection *collection, sn_index frame) {
    snprintf(collection->path, collection->path_size, "%s.%04d.vtp", collection->prefix, (int)frame);
    return collection->path;
}

/* A file name as an attribute of XML. */
static void write_escaped(sn_output *output, const char *text) {
    for (; *text != '\0'; text++) {
        const char *entity = *text == '&' ? "&amp;" : *text == '<' ? "&lt;" : *text == '>' ? "&gt;" : *text == '"' ? "&quot;" : NULL;
        sn_output_write(output, entity != NULL ? entity : text, entity != NULL ? strlen(entity) : 1, NULL);
    }
}

static sn_status list(sn_collection *collection, sn_output *output, double time) {
    char number[40];
    const char *slash = strrchr(collection->path, '/');
    sn_format_number(time, number);
    sn_output_print(output, "<DataSet timestep=\"%s\" part=\"0\" file=\"", number);
    write_escaped(output, slash != NULL ? slash + 1 : collection->path);
    return sn_output_print(output, "\"/>\n");
}

sn_status sn_collection_list(sn_collection *collection, double time, sn_error *error) {
    list(collection, collection->output, time);
    return sn_output_publish(collection->output, tail, error);
}

/* ---- going on with one ------------------------------------------------------------------------------------------------------ */

/* The number of the frame that the first line of a collection names, and how many lines it has. */
static bool scan(const char *text, int64_t *first, int64_t *lines) {
    static const char part[] = "part=\"0\" file=\"";
    const char *end = strstr(text, ".vtp\"/>"), *dot = end, *after;
    if (strncmp(text, head, strlen(head)) != 0) return false;
    *lines = 0;
    for (const char *at = text; (at = strstr(at, part)) != NULL; at++) ++*lines;
    while (dot != NULL && dot > text && dot[-1] != '.') dot--;
    return *lines == 0 || (dot != NULL && dot > text && sn_scan_integer(dot, end, &after, first) && after == end);
}

/* The head and the lines of the frames from `first` on, before the one that is written next: as they must be in what is there. */
static sn_status expect(sn_collection *collection, int64_t first, const sn_resume *resume, sn_blob *out, sn_error *error) {
    sn_output *memory = NULL;
    sn_status status = sn_output_open_memory(&memory, error);
    if (status != SN_OK) return status;
    sn_output_write(memory, head, strlen(head), NULL);
    for (int64_t frame = first; frame < resume->next; frame++) {
        (void)sn_collection_frame(collection, (sn_index)frame);
        list(collection, memory, (double)frame / resume->rate);
    }
    return sn_output_take(memory, collection->prefix, out, error);
}

/* The lines that are there are written again, before those that follow. */
static sn_status take_lines(sn_collection *collection, const char *path, const sn_blob *there, int64_t first, const sn_resume *resume,
                            sn_error *error) {
    sn_blob expected = {0};
    sn_status status = expect(collection, first, resume, &expected, error);
    if (status != SN_OK) return status;
    if (there->size < expected.size || memcmp(there->data, expected.data, expected.size) != 0)
        status = sn_resume_differs(resume, path, error);
    else
        status = sn_output_write(collection->output, expected.data + strlen(head), expected.size - strlen(head), error);
    sn_blob_free(&expected);
    return status;
}

sn_status sn_collection_resume(sn_collection *collection, sn_resume *resume, bool *goes_on, sn_error *error) {
    sn_blob there = {0};
    int64_t first = 0, lines = 0;
    *goes_on = false;
    snprintf(collection->path, collection->path_size, "%s.pvd", collection->prefix);
    if (!sn_resume_exists(collection->path)) return SN_OK;
    char *path = sn_strdup(collection->path);
    sn_status status = path != NULL ? sn_blob_read_bytes(path, &there, error) : sn_fail_memory(error, "a collection of frames");
    if (status == SN_OK && !scan(there.data, &first, &lines))
        status = sn_fail_at(error, SN_ERROR_USAGE, path, 0, "is no collection of frames of an earlier run; name another file or folder");
    if (status == SN_OK) status = sn_resume_take(resume, path, first, first + lines - 1, goes_on, error);
    if (status == SN_OK && *goes_on) status = take_lines(collection, path, &there, first, resume, error);
    sn_blob_free(&there);
    free(path);
    return status;
}

/* ---- the end ---------------------------------------------------------------------------------------------------------------- */

sn_status sn_collection_close(sn_collection *collection, sn_error *error) {
    sn_output_print(collection->output, "%s", tail);
    sn_status status = sn_output_commit(collection->output, error);
    collection->output = NULL;
    sn_collection_drop(collection);
    return status;
}

void sn_collection_drop(sn_collection *collection) {
    sn_output_abort(collection->output);
    free(collection->prefix);
    free(collection->path);
    *collection = (sn_collection){0};
}
