/*
 * base.h -- scalar and index types, status and error, log, memory, numbers in text.   rank 0
 *
 * Everything in the library is in metres, kilograms, seconds and radians. Indices are sn_index (32 bit); -1 means "none".
 * A function that can fail returns sn_status and, where the caller passes an sn_error (nullable), fills it with one sentence:
 * what is wrong, where, and what would help. The library never exits, never prints and never touches stdout.
 */
#ifndef SINEW_BASE_H
#define SINEW_BASE_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SN_VERSION "0.1.0"

typedef int32_t sn_index;
#define SN_NONE ((sn_index)-1)
#define SN_INDEX_MAX INT32_MAX

typedef enum sn_status {
    SN_OK = 0,
    SN_ERROR_INPUT,    /* the data is bad: malformed, out of range, impossible to work with */
    SN_ERROR_IO,       /* a file or stream could not be opened, read, written or closed */
    SN_ERROR_MEMORY,   /* out of memory, or more than sn_index can count */
    SN_ERROR_USAGE,    /* the request makes no sense: an option out of range, options that exclude each other */
    SN_ERROR_INTERNAL, /* a library beneath us failed on input that we had validated */
    SN_STOPPED         /* not an error: the trace asked to stop; the result is a valid partial one */
} sn_status;

#if defined(__GNUC__)
#define SN_MUST_CHECK __attribute__((warn_unused_result))
#define SN_PRINTF(format_index, first) __attribute__((format(printf, format_index, first)))
#else
#define SN_MUST_CHECK
#define SN_PRINTF(format_index, first)
#endif

/* What went wrong. Plain data, no ownership: copy it freely. */
typedef struct sn_error {
    sn_status code;
    int64_t line;    /* line in `file`, from 1; 0 = not known */
    int64_t column;  /* column in that line, from 1; 0 = not known */
    int64_t element; /* vertex, triangle, row or frame index; -1 = none */
    char file[512];  /* file name as the user gave it; "" = none */
    char text[768];  /* one sentence */
} sn_error;

/* Fill *error (nullable) with a formatted sentence and return code, so that a failing line reads `return sn_fail(...)`.
 * sn_fail keeps error->file if it is already set. */
sn_status sn_fail(sn_error *error, sn_status code, const char *format, ...) SN_PRINTF(3, 4);
/* The same, naming file (nullable) and line (0 = none). */
sn_status sn_fail_at(sn_error *error, sn_status code, const char *file, int64_t line, const char *format, ...) SN_PRINTF(5, 6);
/* Out of memory, for `what`. */
sn_status sn_fail_memory(sn_error *error, const char *what);
/* Name the file in *error if none is named yet. */
void sn_error_set_file(sn_error *error, const char *file);

/* ---- log ---------------------------------------------------------------------------------------------------------- */

typedef enum sn_log_level { SN_LOG_WARNING, SN_LOG_INFO, SN_LOG_DEBUG } sn_log_level;
typedef void (*sn_log_function)(void *user, sn_log_level level, const char *text);

/* One process-wide receiver; NULL (the start) drops every message. Set it before other threads start. */
void sn_log_set(sn_log_function function, void *user);
void sn_log(sn_log_level level, const char *format, ...) SN_PRINTF(2, 3);

/* ---- memory ------------------------------------------------------------------------------------------------------- */

/* count x size bytes, zeroed; NULL when out of memory or when the product overflows. count 0 gives a valid pointer. */
void *sn_alloc(size_t count, size_t size);
/* Resize to count x size; NULL on failure, the old block stays. New bytes are not initialised. */
void *sn_realloc(void *block, size_t count, size_t size);
/* Make room for `needed` elements in a growing array (doubling); *capacity is updated. false = out of memory, nothing changed. */
bool sn_grow(void **block, size_t *capacity, size_t needed, size_t size);
/* A copy of text (NULL stays NULL); NULL when out of memory. */
char *sn_strdup(const char *text);
char *sn_strndup(const char *text, size_t length);
#define SN_NEW(type, count) ((type *)sn_alloc((size_t)(count), sizeof(type)))

/* ---- numbers in text: strict, whole string, independent of the locale --------------------------------------------- */

/* A length as a user writes it: "6mm", "0.5cm", "0.006m", or "6" in the document's unit. */
typedef struct sn_length {
    double value;
    double meters; /* metres per unit of `value`; 0 = the document's unit */
} sn_length;

SN_MUST_CHECK sn_status sn_parse_number(const char *text, double *out, sn_error *error); /* finite only */
SN_MUST_CHECK sn_status sn_parse_integer(const char *text, int64_t low, int64_t high, int64_t *out, sn_error *error);
SN_MUST_CHECK sn_status sn_parse_numbers(const char *text, size_t count, double *out, sn_error *error); /* "x,y,z": exactly count */
SN_MUST_CHECK sn_status sn_parse_length(const char *text, sn_length *out, sn_error *error);
/* metres of length in a document whose coordinates have meters_per_unit. */
double sn_length_meters(sn_length length, double meters_per_unit);
/* A decimal of at most 12 places if that reads back as the same double, else %.17g; buffer of at least 32 bytes; returns the length.
 * -0 is "0". Always reads back as the same double. */
int sn_format_number(double value, char *buffer);

/* Parse one decimal number starting at text, not reading at or past end; *next is set behind it. Locale-free, correctly rounded.
 * false = no number here. "nan" and "inf" in any case, also as
 * "nan(ind)", "1.#QNAN", "-1.#IND" and "1.#INF" of Windows, are read as such, so that a reader can name the place. What follows the number
 * is the reader's: a number is a whole token, and '#' begins a comment only where a token may begin. */
bool sn_scan_number(const char *text, const char *end, const char **next, double *out);
/* The same for a signed integer; false also on overflow. */
bool sn_scan_integer(const char *text, const char *end, const char **next, int64_t *out);
/* Does text match the pattern: '*' is any run of characters, '?' any one, all else itself? */
bool sn_pattern_matches(const char *pattern, const char *text);
/* Letters to change, insert, leave out or swap with their neighbour until the first `length` characters of word (SIZE_MAX: all) are
 * `known`, whatever the case and without '_', '-' and blanks. INT_MAX where it takes more than a third of the letters: then nobody mistyped
 * the one for the other. */
int sn_word_distance(const char *word, size_t length, const char *known);
/* The word of a NULL-terminated list that such a word was meant to be, the first of those that are equally near; NULL = none of them. */
const char *sn_nearest_word(const char *word, size_t length, const char *const *known);

/* The size of the byte order mark of UTF-8 that a text begins with: 3 or 0. */
size_t sn_byte_order_mark(const char *text, size_t size);
/* The lines of a text, which end in LF, CR LF or CR; a byte order mark before the first is passed over. */
typedef struct sn_text_lines {
    const char *at, *end; /* what is not read yet */
    int64_t line;         /* of the line that was read last, from 1 */
} sn_text_lines;
sn_text_lines sn_text_lines_of(const char *text, size_t size);
/* The next line, from *text up to *end, without its line end; false = there is none. */
bool sn_text_next_line(sn_text_lines *lines, const char **text, const char **end);

/* ---- content hash ------------------------------------------------------------------------------------------------- */

/* "sha256:" and 64 hex digits of size bytes. */
#define SN_HASH_LENGTH 72
void sn_hash(const void *data, size_t size, char out[SN_HASH_LENGTH]);

/* Deterministic random numbers in [0,1) for sampling and tests: splitmix64; the same on every machine. */
double sn_random(uint64_t *state);

#ifdef __cplusplus
}
#endif
#endif
