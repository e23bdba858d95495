/* sensors_document.h -- sides, patterns and names of sensors documents. Private to lib/io. */
#ifndef SINEW_IO_SENSORS_DOCUMENT_H
#define SINEW_IO_SENSORS_DOCUMENT_H

#include "document.h"

enum { SN_SIDE_WORDS = 8, SN_SIDES = 16, SN_NAME_LENGTH = 255 };

/* What stands in braces in names, and what it is replaced by on each side: { "side": ["l", "r"], ... }. */
typedef struct sn_sides {
    sn_index word_count, count; /* 0 words: the document tells no sides */
    char *words[SN_SIDE_WORDS];
    char *values[SN_SIDE_WORDS][SN_SIDES];
} sn_sides;

/* "sides": ["l", "r"], which means { "side": ["l", "r"] }, or such an object of lists of one length. */
SN_MUST_CHECK sn_status sn_sides_parse(const sn_json_value *value, sn_sides *out, sn_error *error);
void sn_sides_free(sn_sides *sides);

/* A text with something in braces is one of each side; side SN_NONE: of none, so that braces are an error. */
typedef struct sn_side {
    const sn_sides *sides;
    sn_index side;
} sn_side;
bool sn_text_has_side(const char *text);
/* A text with its words replaced; *out is freed first and left alone where the value is absent. */
SN_MUST_CHECK sn_status sn_side_text(const sn_json_value *value, sn_side side, char **out, sn_error *error);
/* What holds on this side: of an object { "l": ..., "r": ... } the member of the side by its first word, else the value itself. */
SN_MUST_CHECK sn_status sn_side_value(const sn_json_value *value, sn_side side, sn_json_value *out, sn_error *error);

/* Names in order, to find one and those that stand twice. */
typedef struct sn_name_index {
    sn_index count;
    struct sn_indexed_name {
        const char *name; /* not owned */
        sn_index at;
    } * names;
} sn_name_index;
/* name_of(data, i) for i < count. */
SN_MUST_CHECK sn_status sn_name_index_create(sn_index count, const char *(*name_of)(const void *data, sn_index i), const void *data,
                                             sn_name_index *out, sn_error *error);
void sn_name_index_free(sn_name_index *index);
sn_index sn_name_index_find(const sn_name_index *index, const char *name); /* SN_NONE = it is not there */
const char *sn_name_index_twin(const sn_name_index *index);                /* one that stands twice; NULL = none */

/* Names for a message, of which a few are written out: "a, b, c and 5 more". */
typedef struct sn_naming {
    sn_index count;
    char text[320];
} sn_naming;
void sn_naming_add(sn_naming *naming, const char *name);
/* The end of the list; the text. */
const char *sn_naming_text(sn_naming *naming);

#endif
