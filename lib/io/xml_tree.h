/*
 * xml_tree.h -- a small XML document as a tree: what a model is read from.
 *
 * An element knows where it stands in the file; names, attributes and text are read from there, so that the tree is small beside the file.
 */
#ifndef SN_IO_XML_TREE_H
#define SN_IO_XML_TREE_H

#include "mesh_reader.h"
#include "xml.h"

typedef struct sn_xml_element {
    size_t begin, text, close; /* bytes of the file: its '<', what is behind its start tag, its end tag */
    int32_t line;
    sn_index parent, child, next; /* SN_NONE = none */
} sn_xml_element;

typedef struct sn_xml_tree {
    const sn_blob *blob;
    sn_xml_element *elements; /* element 0 is the root */
    sn_index count;
    size_t capacity;
    sn_index open, last; /* while it is built: the innermost open element; the last child of it so far */
} sn_xml_tree;

/* The blob must outlive the tree. *out is empty on failure; free with sn_xml_tree_free. */
SN_MUST_CHECK sn_status sn_xml_tree_parse(const sn_blob *blob, sn_xml_tree *out, sn_error *error);
void sn_xml_tree_free(sn_xml_tree *tree);

/* SN_ERROR_INPUT at the element's line. */
sn_status sn_xml_fail(const sn_xml_tree *tree, sn_index element, sn_error *error, const char *format, ...) SN_PRINTF(4, 5);

sn_span sn_xml_name(const sn_xml_tree *tree, sn_index element); /* empty for SN_NONE */
bool sn_xml_is(const sn_xml_tree *tree, sn_index element, const char *name);
/* The first child of that name (NULL = any), and the next sibling of one; SN_NONE = none, also where the element is SN_NONE. */
sn_index sn_xml_child(const sn_xml_tree *tree, sn_index element, const char *name);
sn_index sn_xml_next(const sn_xml_tree *tree, sn_index element, const char *name);
/* The first element of that name inside of `within`, at any depth, behind `after` (SN_NONE = the first of all). */
sn_index sn_xml_find(const sn_xml_tree *tree, sn_index within, sn_index after, const char *name);

/* Text of the element up to its first child, without blanks and comments before it; and an attribute's. As they are written in the file:
 * text NULL = there is none. */
sn_span sn_xml_text(const sn_xml_tree *tree, sn_index element);
sn_span sn_xml_attribute_text(const sn_xml_tree *tree, sn_index element, const char *name);
sn_span sn_xml_child_text(const sn_xml_tree *tree, sn_index element, const char *name);
/* A copy with XML's own entities replaced; NULL = out of memory. */
char *sn_xml_copy(sn_span span);
/* The next word; it is taken off the span. Empty at the end. */
sn_span sn_xml_word(sn_span *span);

/* A value as it is written, and what messages about it say: the element's line, and its name. */
typedef struct sn_xml_value {
    const sn_xml_tree *tree;
    sn_index element;
    const char *name;
    sn_span text; /* empty: there is none */
} sn_xml_value;
/* The text of an element's child of that name; its attribute. */
sn_xml_value sn_xml_child_value(const sn_xml_tree *tree, sn_index element, const char *name);
sn_xml_value sn_xml_attribute_value(const sn_xml_tree *tree, sn_index element, const char *name);

/* Exactly `count` finite numbers; an empty text leaves out alone. */
SN_MUST_CHECK sn_status sn_xml_numbers(sn_xml_value value, sn_index count, double *out, sn_error *error);
/* As many as there are; *out is allocated. */
SN_MUST_CHECK sn_status sn_xml_all_numbers(sn_xml_value value, sn_index *count, double **out, sn_error *error);
/* "true" or "false" in any case, 1 or 0; an empty text leaves *out alone. */
SN_MUST_CHECK sn_status sn_xml_bool(sn_xml_value value, bool *out, sn_error *error);

#endif
