/*
 * setting.c -- solver settings in text, by one table of keys.
 */
#include "sinew/setting.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* How a value is written and kept: a whole number, one or "auto" (0), any number, or one of some words. */
typedef enum key_kind { WHOLE, AUTO, NUMBER, WORD } key_kind;

enum { XPBD = 1 << SN_SOLVER_XPBD, QN = 1 << SN_SOLVER_QN };

typedef struct setting_key {
    const char *name;
    unsigned methods; /* that have it */
    key_kind kind;
    double low, high;
    const char *const *words; /* WORD: in the order of its enumeration, NULL at the end; the first is the default */
    size_t offset;            /* in sn_solver_settings: of a sn_index, a double or an enumeration */
} setting_key;

#define SOLVER(member) offsetof(sn_solver_settings, member)

static const setting_key KEYS[] = {
    {"substeps", XPBD | QN, AUTO, 1, 1e6, NULL, SOLVER(substeps)},
    {"iterations", XPBD | QN, WHOLE, 1, 1e6, NULL, SOLVER(iterations)},
    {"tolerance", QN, NUMBER, 0, 1, NULL, SOLVER(tolerance)},
    {"scheme", XPBD, WORD, 0, 0, sn_scheme_names, SOLVER(scheme)},
    {"hinges", XPBD, WORD, 0, 0, sn_hinge_rule_names, SOLVER(hinges)},
    {"precision", XPBD, WORD, 0, 0, sn_precision_names, SOLVER(precision)},
    {"preconditioner", QN, WORD, 0, 0, sn_preconditioning_names, SOLVER(preconditioner)},
};
enum { KEY_COUNT = sizeof KEYS / sizeof *KEYS };

_Static_assert(KEY_COUNT <= SN_SETTING_KEYS, "every key has a place in a setting");
_Static_assert(sizeof(sn_scheme) == sizeof(int) && sizeof(sn_precision) == sizeof(int) && sizeof(sn_hinge_rule) == sizeof(int) &&
                   sizeof(sn_preconditioning) == sizeof(int),
               "a word is kept as an int");

/* ---- text in ---------------------------------------------------------------------------------------------------------------- */

static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

static bool equals(const char *word, const char *text, size_t length) { return strlen(word) == length && memcmp(word, text, length) == 0; }

/* Place of the text among the words; -1 = it is none of them. */
static int find_word(const char *const *words, const char *text, size_t length) {
    for (int i = 0; words[i] != NULL; i++)
        if (equals(words[i], text, length)) return i;
    return -1;
}

/* "a, b or c". */
static void list_words(const char *const *words, char *out, size_t size) {
    size_t used = 0;
    for (int i = 0; words[i] != NULL && used < size; i++) {
        const char *before = i == 0 ? "" : words[i + 1] != NULL ? ", " : " or ";
        used += (size_t)snprintf(out + used, size - used, "%s%s", before, words[i]);
    }
}

/* "; did you mean WORD?", or nothing. */
static const char *guess(const char *const *words, const char *text, size_t length, char *out, size_t size) {
    const char *meant = sn_nearest_word(text, length, words);
    snprintf(out, size, "%s%s%s", meant != NULL ? "; did you mean " : "", meant != NULL ? meant : "", meant != NULL ? "?" : "");
    return out;
}

static sn_status unknown_key(sn_solver_method method, const char *text, size_t length, sn_error *error) {
    const char *names[KEY_COUNT + 1] = {NULL};
    char list[256], meant[64];
    int count = 0;
    for (int i = 0; i < KEY_COUNT; i++)
        if (KEYS[i].methods & (1U << method)) names[count++] = KEYS[i].name;
    list_words(names, list, sizeof list);
    return sn_fail(error, SN_ERROR_INPUT, "%s has no \"%.*s\"; it has %s%s", sn_solver_method_names[method],
                   (int)(length < 64 ? length : 64), text, list, guess(names, text, length, meant, sizeof meant));
}

static sn_status parse_word(const setting_key *key, const char *text, size_t length, double *out, sn_error *error) {
    char list[256], meant[64];
    int place = find_word(key->words, text, length);
    *out = place;
    if (place >= 0) return SN_OK;
    list_words(key->words, list, sizeof list);
    return sn_fail(error, SN_ERROR_INPUT, "%s=%.*s: it is %s%s", key->name, (int)(length < 64 ? length : 64), text, list,
                   guess(key->words, text, length, meant, sizeof meant));
}

static sn_status parse_value(sn_solver_method method, const setting_key *key, const char *text, size_t length, double *out,
                             sn_error *error) {
    if (key->kind == WORD) return parse_word(key, text, length, out, error);
    const char *end = text + length, *next = text;
    if (key->kind == AUTO && method == SN_SOLVER_QN && equals("auto", text, length)) {
        *out = SN_SUBSTEPS_AUTO;
        return SN_OK;
    }
    bool good = sn_scan_number(text, end, &next, out) && next == end && *out >= key->low && *out <= key->high;
    if (good) *out += 0.0; /* -0 is 0 */
    if (good && (key->kind == NUMBER || *out == floor(*out))) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT, "%s=%.*s: it is a %snumber from %g to %g", key->name, (int)(length < 64 ? length : 64), text,
                   key->kind == NUMBER ? "" : "whole ", key->low, key->high);
}

/* One "KEY=VALUE". */
static sn_status parse_item(const char *text, size_t length, sn_setting *out, sn_error *error) {
    const char *sign = memchr(text, '=', length);
    if (sign == NULL)
        return sn_fail(error, SN_ERROR_INPUT, "cannot read \"%.*s\": write METHOD KEY=VALUE ...", (int)(length < 64 ? length : 64), text);
    size_t name = (size_t)(sign - text);
    for (int i = 0; i < KEY_COUNT; i++) {
        if (!equals(KEYS[i].name, text, name) || !(KEYS[i].methods & (1U << out->method))) continue;
        if (out->given & (1U << i)) return sn_fail(error, SN_ERROR_INPUT, "%s is given twice", KEYS[i].name);
        out->given |= 1U << i;
        return parse_value(out->method, &KEYS[i], sign + 1, length - name - 1, &out->values[i], error);
    }
    return unknown_key(out->method, text, name, error);
}

static sn_status parse_method(const char *text, size_t length, sn_setting *out, sn_error *error) {
    int place = find_word(sn_solver_method_names, text, length);
    if (place < 0)
        return sn_fail(error, SN_ERROR_INPUT, "a setting begins with its method, xpbd or qn, not with \"%.*s\"",
                       (int)(length < 64 ? length : 64), text);
    out->method = (sn_solver_method)place;
    return SN_OK;
}

static sn_status parse_words(const char *text, const char *end, sn_setting *out, sn_error *error) {
    sn_status status = SN_OK;
    int count = 0;
    *out = (sn_setting){0};
    for (const char *word = text; status == SN_OK; word = text) {
        while (word < end && is_blank(*word)) word++;
        for (text = word; text < end && !is_blank(*text);) text++;
        if (word == text) break;
        size_t length = (size_t)(text - word);
        status = count++ == 0 ? parse_method(word, length, out, error) : parse_item(word, length, out, error);
    }
    if (status == SN_OK && count == 0) status = sn_fail(error, SN_ERROR_INPUT, "a setting begins with its method, xpbd or qn");
    return status;
}

sn_status sn_setting_parse(const char *text, sn_setting *out, sn_error *error) {
    return parse_words(text, text + strlen(text), out, error);
}

/* ---- many of them ------------------------------------------------------------------------------------------------------------- */

static bool has_words(const char *text, const char *end) {
    while (text < end && is_blank(*text)) text++;
    return text < end;
}

static sn_status add_line(const char *text, const char *end, sn_setting **list, size_t *capacity, sn_index *count, sn_error *error) {
    if (!has_words(text, end)) return SN_OK;
    if (*count == SN_INDEX_MAX || !sn_grow((void **)list, capacity, (size_t)*count + 1, sizeof **list))
        return sn_fail_memory(error, "the settings");
    return parse_words(text, end, &(*list)[(*count)++], error);
}

sn_status sn_settings_parse(const char *text, size_t size, sn_setting **out, sn_index *count, sn_error *error) {
    sn_text_lines lines = sn_text_lines_of(text, size);
    size_t capacity = 0;
    sn_status status = SN_OK;
    *out = NULL;
    *count = 0;
    for (const char *from, *to; status == SN_OK && sn_text_next_line(&lines, &from, &to);) {
        const char *comment = memchr(from, '#', (size_t)(to - from));
        status = add_line(from, comment != NULL ? comment : to, out, &capacity, count, error);
        if (status != SN_OK && error != NULL) error->line = lines.line;
    }
    if (status == SN_OK && *count == 0) status = sn_fail(error, SN_ERROR_INPUT, "there is no setting: write one a line");
    if (status == SN_OK) return SN_OK;
    free(*out);
    *out = NULL;
    *count = 0;
    return status;
}

/* ---- text out, and into a scene ------------------------------------------------------------------------------------------------- */

static void format_key(int i, double value, char *out, size_t size) {
    char number[48];
    if (KEYS[i].kind == AUTO && value == SN_SUBSTEPS_AUTO)
        snprintf(number, sizeof number, "auto");
    else
        sn_format_number(value, number);
    snprintf(out, size, " %s=%s", KEYS[i].name, KEYS[i].kind == WORD ? KEYS[i].words[(int)value] : number);
}

static void format_keys(const sn_setting *setting, bool family, char out[SN_SETTING_LENGTH]) {
    size_t used = (size_t)snprintf(out, SN_SETTING_LENGTH, "%s", sn_solver_method_names[setting->method]);
    for (int i = 0; i < KEY_COUNT && used < SN_SETTING_LENGTH; i++) {
        if (!(setting->given & (1U << i))) continue;
        if (family && (KEYS[i].kind != WORD || setting->values[i] == 0.0)) continue;
        format_key(i, setting->values[i], out + used, SN_SETTING_LENGTH - used);
        used += strlen(out + used);
    }
}

void sn_setting_format(const sn_setting *setting, char out[SN_SETTING_LENGTH]) { format_keys(setting, false, out); }

void sn_setting_family(const sn_setting *setting, char out[SN_SETTING_LENGTH]) { format_keys(setting, true, out); }

static void put(const setting_key *key, double value, char *base) {
    if (key->kind == WHOLE || key->kind == AUTO) memcpy(base + key->offset, &(sn_index){(sn_index)value}, sizeof(sn_index));
    if (key->kind == NUMBER) memcpy(base + key->offset, &value, sizeof value);
    if (key->kind == WORD) memcpy(base + key->offset, &(int){(int)value}, sizeof(int));
}

void sn_setting_apply(const sn_setting *setting, sn_scene *scene) {
    sn_solver_settings solver = sn_solver_defaults(setting->method);
    solver.threads = scene->solver.threads;
    solver.sleep = scene->solver.sleep;
    for (int i = 0; i < KEY_COUNT; i++)
        if (setting->given & (1U << i)) put(&KEYS[i], setting->values[i], (char *)&solver);
    scene->solver = solver;
    for (sn_index i = 0; i < scene->muscle_count; i++) scene->muscles[i].iterations = 0;
}
