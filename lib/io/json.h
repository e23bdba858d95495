/*
 * json.h -- JSON in: a parsed text, and values in it that know their path. Private to lib/io; json.c is the only user of jansson.
 *
 * Long arrays of numbers are what documents are made of, and what a general parser is slow at. So the text is folded first: every
 * array that holds only numbers becomes "[k]", the k-th of a table of spans of the text; jansson then sees and checks a small text.
 * The numbers are scanned straight from the text when they are asked for, and an array that is only passed on is never scanned.
 */
#ifndef SINEW_IO_JSON_H
#define SINEW_IO_JSON_H

#include "sinew/io.h"

struct json_t;
typedef struct sn_json_tree sn_json_tree;

/* One value, and how one got to it (for the path in errors). `parent` points to the caller's value: it must outlive this one. */
typedef struct sn_json_value {
    const sn_json_tree *tree;
    const struct json_t *node;          /* NULL = there is no such member */
    const struct sn_json_value *parent; /* NULL = the top */
    const char *key;                    /* member of parent; NULL = element */
    sn_index element;                   /* of parent */
} sn_json_value;

/* Does the blob hold JSON (an object), not a mesh? */
bool sn_json_detect(const sn_blob *blob);
/* Parse a whole text whose top is an object; it is copied. Errors name file, line and column. */
SN_MUST_CHECK sn_status sn_json_parse(const sn_blob *blob, sn_json_tree **out, sn_error *error);
void sn_json_tree_free(sn_json_tree *tree);         /* NULL is fine */
const char *sn_json_name(const sn_json_tree *tree); /* of the file */
sn_json_value sn_json_top(const sn_json_tree *tree);

/* ---- walking: an absent value has only absent members ----------------------------------------------------------------- */

bool sn_json_has(const sn_json_value *value); /* it is there; null counts as absent */
sn_json_value sn_json_member(const sn_json_value *object, const char *key);
sn_json_value sn_json_element(const sn_json_value *array, sn_index i); /* of an array of objects, arrays or texts */
sn_index sn_json_length(const sn_json_value *array);
/* The member after *member in file order; the first where it is zeroed; false = no more. */
bool sn_json_next(const sn_json_value *object, sn_json_value *member);
bool sn_json_is_bool(const sn_json_value *value);
bool sn_json_is_number(const sn_json_value *value);
bool sn_json_is_text(const sn_json_value *value);
bool sn_json_is_array(const sn_json_value *value);

/* ---- typed access ----------------------------------------------------------------------------------------------------- */

/* "muscles[2].contraction: expected a number in [0,1], found "abc"" with the document's name. */
sn_status sn_json_mismatch(const sn_json_value *value, sn_error *error, const char *expected, ...) SN_PRINTF(3, 4);
/* Any other complaint, with the path before it. */
sn_status sn_json_complain(const sn_json_value *value, sn_error *error, const char *format, ...) SN_PRINTF(3, 4);

SN_MUST_CHECK sn_status sn_json_expect_object(const sn_json_value *value, sn_error *error);
SN_MUST_CHECK sn_status sn_json_expect_array(const sn_json_value *value, sn_error *error);
/* An array of at most `most` entries, and how many they are: for lists whose names are compared with each other. */
SN_MUST_CHECK sn_status sn_json_expect_list(const sn_json_value *value, sn_index most, sn_index *count, sn_error *error);

/* As `low`: the number must be above 0. */
#define SN_JSON_POSITIVE 2.2250738585072014e-308

/* These leave *out alone where the value is absent: fill it with the default first, or ask sn_json_require. */
SN_MUST_CHECK sn_status sn_json_require(const sn_json_value *value, const char *expected, sn_error *error);
SN_MUST_CHECK sn_status sn_json_get_number(const sn_json_value *value, double low, double high, double *out, sn_error *error);
SN_MUST_CHECK sn_status sn_json_get_integer(const sn_json_value *value, int64_t low, int64_t high, int64_t *out, sn_error *error);
SN_MUST_CHECK sn_status sn_json_get_index(const sn_json_value *value, sn_index low, sn_index high, sn_index *out, sn_error *error);
SN_MUST_CHECK sn_status sn_json_get_bool(const sn_json_value *value, bool *out, sn_error *error);
/* *out is freed and replaced by an allocated copy. */
SN_MUST_CHECK sn_status sn_json_get_text(const sn_json_value *value, char **out, sn_error *error);
/* Index into a NULL-terminated list of words. */
SN_MUST_CHECK sn_status sn_json_get_choice(const sn_json_value *value, const char *const *choices, int *out, sn_error *error);
SN_MUST_CHECK sn_status sn_json_get_vec3(const sn_json_value *value, sn_vec3 *out, sn_error *error);
/* Exactly count numbers into the caller's array (left alone, too, where the value is absent). */
SN_MUST_CHECK sn_status sn_json_get_fixed(const sn_json_value *value, sn_index count, double *out, sn_error *error);
/* An allocated array: a multiple of `multiple` numbers, or exactly `count` where count >= 0. Required: absent is an error. */
SN_MUST_CHECK sn_status sn_json_get_numbers(const sn_json_value *value, sn_index multiple, sn_index count, sn_index *out_count,
                                            double **out, sn_error *error);
/* What a list of whole numbers must be: as many as above, each within low..high. */
typedef struct sn_index_rule {
    sn_index multiple, count;
    sn_index low, high;
} sn_index_rule;
/* The same for whole numbers. */
SN_MUST_CHECK sn_status sn_json_get_indices(const sn_json_value *value, sn_index_rule rule, sn_index *out_count, sn_index **out,
                                            sn_error *error);

/* The members "format" and "version" of a document: the right format, and no version newer than we know. */
SN_MUST_CHECK sn_status sn_json_expect_format(const sn_json_value *top, const char *format, sn_index newest, sn_error *error);

/* Members that are not in the NULL-terminated list, most often mistyped ones: a warning that names them, and those that were meant; an
 * error under sn_documents_strict. Names that begin with '_' or "x-" are a user's own. */
SN_MUST_CHECK sn_status sn_json_check_members(const sn_json_value *object, const char *const *known, sn_error *error);
/* The same where tools pass on what they do not know: the warning is only of those that seem mistyped. */
SN_MUST_CHECK sn_status sn_json_check_passed(const sn_json_value *object, const char *const *known, sn_error *error);

/* ---- passing on ------------------------------------------------------------------------------------------------------- */

/* Write a value as it was read: same members in the same order, arrays of numbers as they were written. */
void sn_json_pass(sn_json *json, const char *key, const sn_json_value *value);

/* ---- more of the writer (json_write.c) -------------------------------------------------------------------------------- */

/* An object all of whose members go on one line also in pretty layout: for what is listed by the hundred. */
void sn_json_object_line(sn_json *json, const char *key);
/* An array of numbers, or one number, that is already JSON text: written as it is, without its blanks. */
void sn_json_number_text(sn_json *json, const char *key, const char *text, size_t size);

#endif
