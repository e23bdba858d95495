/*
 * xml.h -- a walk over the elements of an XML file.
 *
 * Hides the parser. Text is not handed out: an element's place in the file is, and what lies between two tags is read from the file itself.
 * Document types are refused, and so are entities of a file's own: nothing expands.
 */
#ifndef SN_IO_XML_H
#define SN_IO_XML_H

#include "sinew/io.h"

/* One tag. Valid during the call. */
typedef struct sn_xml_tag {
    const char *name;
    const char *const *attributes; /* name, value, name, value, ..., NULL; NULL at an end tag */
    int depth;                     /* 0 = the root */
    size_t begin, end;             /* bytes of the file: from '<' to behind '>'; an empty element's end tag is empty */
    int64_t line;                  /* in which it ends */
} sn_xml_tag;

/* The value of an attribute, or NULL. */
const char *sn_xml_attribute(const sn_xml_tag *tag, const char *name);

/* SN_OK goes on; SN_STOPPED ends the walk, what follows need not be XML; anything else is an error, which the function has filled. */
typedef sn_status (*sn_xml_visit)(void *user, const sn_xml_tag *tag);
/* Visit every start and end tag in order. Errors name the line. Returns SN_OK also where a visit has stopped it. */
SN_MUST_CHECK sn_status sn_xml_walk(const sn_blob *blob, sn_xml_visit start, sn_xml_visit end, void *user, sn_error *error);

#endif
