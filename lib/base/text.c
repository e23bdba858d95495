/* text.c -- numbers in text: strict, whole string, whatever the locale. */
#include "sinew/base.h"

#include <ctype.h>
#include <errno.h>
#include <float.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static locale_t c_locale;
static pthread_once_t c_locale_once = PTHREAD_ONCE_INIT;
static void make_c_locale(void) { c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0); }

static double strtod_c(const char *text) {
    pthread_once(&c_locale_once, make_c_locale);
    return c_locale != (locale_t)0 ? strtod_l(text, NULL, c_locale) : strtod(text, NULL);
}

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

/* ---- scanning numbers out of a buffer -------------------------------------------------------------------------------- */

/* 10^k is exact in double for k <= 22. */
static const double exact_power[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                     1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

/* What stands in the text of a decimal number. */
typedef struct decimal {
    const char *end;     /* behind the number */
    uint64_t mantissa;   /* its digits without the point, while they fit */
    int exponent;        /* power of ten that goes with them */
    bool negative, fits; /* fits: mantissa holds every digit */
} decimal;

static bool scan_digits(const char **text, const char *end, decimal *d, bool fraction) {
    const char *at = *text;
    for (; at < end && is_digit(*at); at++) {
        if (d->mantissa > (UINT64_MAX - 9) / 10) {
            d->fits = false;
            continue;
        }
        d->mantissa = d->mantissa * 10 + (uint64_t)(*at - '0');
        if (fraction) d->exponent--;
    }
    bool any = at > *text;
    *text = at;
    return any;
}

static bool scan_exponent(const char **text, const char *end, decimal *d) {
    const char *at = *text;
    if (at >= end || (*at != 'e' && *at != 'E')) return true;
    at++;
    bool negative = at < end && *at == '-';
    if (at < end && (*at == '-' || *at == '+')) at++;
    if (at >= end || !is_digit(*at)) return true; /* "1e" is 1 followed by e */
    int value = 0;
    for (; at < end && is_digit(*at); at++)
        if (value < 100000) value = value * 10 + (*at - '0');
    d->exponent += negative ? -value : value;
    *text = at;
    return true;
}

static bool scan_decimal(const char *text, const char *end, decimal *d) {
    *d = (decimal){.fits = true};
    if (text < end && (*text == '-' || *text == '+')) d->negative = *text++ == '-';
    bool digits = scan_digits(&text, end, d, false);
    if (text < end && *text == '.') {
        text++;
        digits = scan_digits(&text, end, d, true) || digits;
    }
    if (!digits) return false;
    scan_exponent(&text, end, d);
    d->end = text;
    return true;
}

/* The number by strtod on a terminated copy: the rare cases (more than 19 digits, large exponents). */
static double slow_number(const char *text, const char *end) {
    char small[64], *copy = small;
    size_t length = (size_t)(end - text);
    if (length >= sizeof small && (copy = sn_alloc(length + 1, 1)) == NULL) return NAN;
    memcpy(copy, text, length);
    copy[length] = '\0';
    double value = strtod_c(copy);
    if (copy != small) free(copy);
    return value;
}

/* What the C library of Windows wrote before 2015, behind a number "1.": "#INF", "#IND", "#QNAN", "#SNAN", padded with zeros. */
static bool scan_windows_special(const char *text, const char *end, bool negative, const char **next, double *out) {
    static const struct {
        const char *name;
        double value;
    } special[] = {{"#INF", INFINITY}, {"#IND", NAN}, {"#QNAN", NAN}, {"#SNAN", NAN}};
    for (size_t i = 0; i < sizeof special / sizeof *special; i++) {
        size_t length = strlen(special[i].name);
        if ((size_t)(end - text) < length || strncasecmp(text, special[i].name, length) != 0) continue;
        for (text += length; text < end && *text == '0'; text++) {}
        *next = text;
        *out = negative ? -special[i].value : special[i].value;
        return true;
    }
    return false;
}

/* Behind "(ind)", "(snan)" or any such word in brackets that may follow "nan". */
static const char *skip_payload(const char *text, const char *end) {
    const char *at = text;
    if (at == end || *at++ != '(') return text;
    while (at < end && (is_digit(*at) || (*at >= 'a' && *at <= 'z') || (*at >= 'A' && *at <= 'Z') || *at == '_')) at++;
    return at < end && *at == ')' ? at + 1 : text;
}

/* "nan", "inf", "infinity" in any case, with a sign. */
static bool scan_special(const char *text, const char *end, const char **next, double *out) {
    static const struct {
        const char *name;
        double value;
    } special[] = {{"nan", NAN}, {"infinity", INFINITY}, {"inf", INFINITY}};
    bool negative = text < end && *text == '-';
    if (text < end && (*text == '-' || *text == '+')) text++;
    for (size_t i = 0; i < sizeof special / sizeof *special; i++) {
        size_t length = strlen(special[i].name);
        if ((size_t)(end - text) < length || strncasecmp(text, special[i].name, length) != 0) continue;
        *next = isnan(special[i].value) ? skip_payload(text + length, end) : text + length;
        *out = negative ? -special[i].value : special[i].value;
        return true;
    }
    return false;
}

bool sn_scan_number(const char *text, const char *end, const char **next, double *out) {
    decimal d;
    if (!scan_decimal(text, end, &d)) return scan_special(text, end, next, out);
    bool special = d.end < end && *d.end == '#' && d.end[-1] == '.' && d.mantissa == 1;
    if (special && scan_windows_special(d.end, end, d.negative, next, out)) return true;
    *next = d.end;
    /* mantissa < 2^53 and |exponent| <= 22: one exact operand each, one rounding (Clinger's fast path) */
    if (d.fits && d.mantissa <= (1ULL << 53) && d.exponent >= -22 && d.exponent <= 22) {
        double m = (double)d.mantissa;
        m = d.exponent < 0 ? m / exact_power[-d.exponent] : m * exact_power[d.exponent];
        *out = d.negative ? -m : m;
        return true;
    }
    *out = slow_number(text, d.end);
    return true;
}

bool sn_scan_integer(const char *text, const char *end, const char **next, int64_t *out) {
    bool negative = text < end && *text == '-';
    if (text < end && (*text == '-' || *text == '+')) text++;
    const char *start = text;
    int64_t value = 0;
    for (; text < end && is_digit(*text); text++) {
        if (__builtin_mul_overflow(value, 10, &value) || __builtin_sub_overflow(value, *text - '0', &value)) return false;
    }
    if (text == start) return false;
    if (!negative && value == INT64_MIN) return false;
    *out = negative ? value : -value; /* collected as a negative number, so that INT64_MIN fits */
    *next = text;
    return true;
}

/* ---- lines ------------------------------------------------------------------------------------------------------------ */

size_t sn_byte_order_mark(const char *text, size_t size) { return size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0; }

sn_text_lines sn_text_lines_of(const char *text, size_t size) {
    return (sn_text_lines){.at = text + sn_byte_order_mark(text, size), .end = text + size};
}

bool sn_text_next_line(sn_text_lines *lines, const char **text, const char **end) {
    const char *at = lines->at;
    if (at == lines->end) return false;
    *text = at;
    while (at < lines->end && *at != '\n' && *at != '\r') at++;
    *end = at;
    if (at < lines->end) at += at[0] == '\r' && at + 1 < lines->end && at[1] == '\n' ? 2 : 1;
    lines->at = at;
    lines->line++;
    return true;
}

/* ---- strict parsing of option values ---------------------------------------------------------------------------------- */

sn_status sn_parse_number(const char *text, double *out, sn_error *error) {
    const char *end = text + strlen(text), *next;
    double value;
    if (!sn_scan_number(text, end, &next, &value) || next != end) return sn_fail(error, SN_ERROR_USAGE, "'%s' is not a number", text);
    if (!isfinite(value)) return sn_fail(error, SN_ERROR_USAGE, "'%s' is not a finite number", text);
    *out = value;
    return SN_OK;
}

sn_status sn_parse_integer(const char *text, int64_t low, int64_t high, int64_t *out, sn_error *error) {
    const char *end = text + strlen(text), *next;
    int64_t value;
    if (!sn_scan_integer(text, end, &next, &value) || next != end)
        return sn_fail(error, SN_ERROR_USAGE, "'%s' is not a whole number", text);
    if (value < low || value > high)
        return sn_fail(error, SN_ERROR_USAGE, "%s is not within %lld to %lld", text, (long long)low, (long long)high);
    *out = value;
    return SN_OK;
}

sn_status sn_parse_numbers(const char *text, size_t count, double *out, sn_error *error) {
    const char *at = text, *end = text + strlen(text);
    for (size_t i = 0; i < count; i++) {
        bool good = sn_scan_number(at, end, &at, &out[i]) && isfinite(out[i]);
        bool last = i + 1 == count;
        if (!good || (last ? at != end : (at >= end || *at != ',')))
            return sn_fail(error, SN_ERROR_USAGE, "'%s' is not %zu numbers separated by commas", text, count);
        at++;
    }
    return SN_OK;
}

sn_status sn_parse_length(const char *text, sn_length *out, sn_error *error) {
    static const struct {
        const char *name;
        double meters;
    } units[] = {{"", 0.0}, {"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}, {"um", 1e-6}, {"in", 0.0254}, {"ft", 0.3048}};
    const char *end = text + strlen(text), *next;
    double value;
    if (sn_scan_number(text, end, &next, &value) && isfinite(value)) {
        for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
            if (strcmp(next, units[i].name) != 0) continue;
            *out = (sn_length){value, units[i].meters};
            return SN_OK;
        }
    }
    return sn_fail(error, SN_ERROR_USAGE, "'%s' is not a length; write for example 6mm, 0.5cm, 0.006m, or 6 in the document's unit", text);
}

double sn_length_meters(sn_length length, double meters_per_unit) {
    return length.value * (length.meters > 0.0 ? length.meters : meters_per_unit);
}

/* ---- writing ------------------------------------------------------------------------------------------------------------ */

/* The decimal digits / 10^places without trailing zeros, with at least one digit before the point. */
static int format_decimal(uint64_t digits, int places, bool negative, char *buffer) {
    char reversed[40];
    int count = 0, length = 0;
    for (; places > 0 && digits % 10 == 0; places--) digits /= 10;
    int place = 0;
    do {
        if (place == places && places > 0) reversed[count++] = '.';
        reversed[count++] = (char)('0' + digits % 10);
        digits /= 10;
    } while (++place <= places || digits > 0);
    if (negative) buffer[length++] = '-';
    while (count > 0) buffer[length++] = reversed[--count];
    buffer[length] = '\0';
    return length;
}

/* n / 10^places rounds correctly where both are exact (Clinger), so a decimal found this way reads back as the same double; whatever has
 * more places gets 17 digits. Fast, since documents are mostly numbers. */
int sn_format_number(double value, char *buffer) {
    static const int tried[] = {0, 3, 6, 9, 12};
    double size = fabs(value);
    for (size_t i = 0; i < sizeof tried / sizeof *tried; i++) {
        double scaled = rint(size * exact_power[tried[i]]);
        if (!(scaled < 0x1p53)) break;
        if (scaled / exact_power[tried[i]] == size) return format_decimal((uint64_t)scaled, tried[i], value < 0.0, buffer);
    }
    pthread_once(&c_locale_once, make_c_locale);
    locale_t before = c_locale != (locale_t)0 ? uselocale(c_locale) : (locale_t)0;
    int length = snprintf(buffer, 32, "%.17g", value);
    if (c_locale != (locale_t)0) uselocale(before);
    return length;
}

double sn_random(uint64_t *state) {
    uint64_t z = (*state += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}
