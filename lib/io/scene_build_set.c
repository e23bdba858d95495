/* scene_build_set.c -- members of muscles by pattern: "biceps*.restLength=0.9". */
#include "scene_build.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Members of one object stand together. */
const char *const sn_draft_members[SN_DRAFT_MEMBERS + 1] = {"enabled",
                                                            "activation",
                                                            "contraction",
                                                            "restActivation",
                                                            "tone",
                                                            "restLength",
                                                            "law",
                                                            "stretch",
                                                            "stiffness.relaxed",
                                                            "stiffness.active",
                                                            "stiffness.internal",
                                                            "stiffness.dihedral",
                                                            "stiffness.volume",
                                                            "stiffness.areaScaled",
                                                            "stiffness.curve",
                                                            "anisotropy",
                                                            "leastArea",
                                                            "volumeRatio",
                                                            "maps.activation",
                                                            "maps.tendon",
                                                            "maps.stiffness",
                                                            "mass",
                                                            "density",
                                                            "damping",
                                                            "iterations",
                                                            NULL};

/* ---- values -------------------------------------------------------------------------------------------------------------- */

/* A word, which stands for the JSON string of it: it begins with a letter, and needs no escapes. */
static bool is_word(const char *text) {
    bool letter = (*text >= 'a' && *text <= 'z') || (*text >= 'A' && *text <= 'Z') || *text == '_';
    for (const char *c = text; *c != '\0'; c++)
        if ((unsigned char)*c < ' ' || *c == '"' || *c == '\\') return false;
    return letter;
}

static sn_status parse_wrapped(const char *text, const char *quote, sn_json_tree **out, sn_error *error) {
    size_t size = strlen(text) + 32;
    sn_blob blob = {.data = sn_alloc(size, 1), .name = sn_strdup("value")};
    sn_status status = blob.data != NULL && blob.name != NULL ? SN_OK : sn_fail_memory(error, "a value");
    if (status == SN_OK) {
        blob.size = (size_t)snprintf(blob.data, size, "{\"value\": %s%s%s}", quote, text, quote);
        status = sn_json_parse(&blob, out, error);
    }
    sn_blob_free(&blob);
    return status;
}

/* One value, not more of them: {"value": 1, "more": 2} is an object too. */
static bool holds_one_value(const sn_json_tree *tree) {
    sn_json_value top = sn_json_top(tree), value = sn_json_member(&top, "value"), member = {0};
    int count = 0;
    while (sn_json_next(&top, &member)) count++;
    return count == 1 && sn_json_has(&value);
}

sn_status sn_draft_value_parse(const char *text, sn_json_tree **out, sn_error *error) {
    *out = NULL;
    if (parse_wrapped(text, "", out, NULL) == SN_OK && holds_one_value(*out)) return SN_OK;
    sn_json_tree_free(*out);
    *out = NULL;
    if (is_word(text) && strcmp(text, "null") != 0) return parse_wrapped(text, "\"", out, error);
    return sn_fail(error, SN_ERROR_USAGE, "'%s' is no value: write a number, true, false, a word, or JSON", text);
}

/* ---- judging ------------------------------------------------------------------------------------------------------------- */

/* "muscles[0].restLength: expected ..." without its beginning, which is the probe's. */
static const char *without_place(const char *text) {
    static const char place[] = "muscles[0].";
    return strncmp(text, place, sizeof place - 1) == 0 ? text + sizeof place - 1 : text;
}

/* Does the reader of scenes take the value? */
static sn_status judge(const sn_scene_draft *draft, const sn_draft_muscle *muscle, int member, const char *setting, sn_error *error) {
    sn_blob blob = {0};
    sn_scene scene = {0};
    sn_error why = {0};
    const char *value = muscle->settings[member];
    if (strcmp(sn_draft_members[member], "enabled") == 0 && strcmp(value, "true") != 0 && strcmp(value, "false") != 0)
        return sn_fail(error, SN_ERROR_USAGE, "'%s': a muscle is enabled, true or false", setting);
    sn_status status = sn_draft_probe(draft, muscle, member, &blob, error);
    if (status != SN_OK) return status;
    status = sn_scene_parse(&blob, false, &scene, &why);
    if (status == SN_OK) sn_scene_free(&scene);
    bool other = why.file[0] != '\0' && strcmp(why.file, blob.name) != 0; /* a file that the value names */
    sn_blob_free(&blob);
    if (status == SN_OK) return SN_OK;
    status = status == SN_ERROR_INPUT && !other ? SN_ERROR_USAGE : status;
    return sn_fail(error, status, "'%s': %s%s%s", setting, other ? why.file : "", other ? ": " : "", without_place(why.text));
}

/* ---- settings ------------------------------------------------------------------------------------------------------------ */

typedef struct setting {
    char *pattern;     /* owned */
    int member;        /* of sn_draft_members */
    const char *value; /* in the text */
} setting;

static int find_member(const char *name, size_t length) {
    for (int i = 0; i < SN_DRAFT_MEMBERS; i++)
        if (strlen(sn_draft_members[i]) == length && memcmp(sn_draft_members[i], name, length) == 0) return i;
    return -1;
}

static sn_status no_such_member(const char *text, sn_error *error) {
    const char *name = strchr(text, '.') + 1, *meant = sn_nearest_word(name, strcspn(name, "="), sn_draft_members);
    if (meant != NULL) return sn_fail(error, SN_ERROR_USAGE, "'%s': a muscle has no such member; did you mean %s?", text, meant);
    return sn_fail(error, SN_ERROR_USAGE,
                   "'%s': a muscle has no such member; it has activation, restLength, tone, contraction, stiffness.relaxed and others "
                   "of a scene's muscle",
                   text);
}

/* The pattern ends at the first dot that has a member behind it. */
static sn_status split(const char *text, setting *out, sn_error *error) {
    const char *equals = strchr(text, '='), *dot = equals != NULL ? memchr(text, '.', (size_t)(equals - text)) : NULL;
    if (equals == NULL || dot == NULL || equals[1] == '\0')
        return sn_fail(error, SN_ERROR_USAGE, "'%s' is not PATTERN.MEMBER=VALUE, as in '*.activation=0.1'", text);
    out->member = -1;
    out->value = equals + 1;
    while (dot != NULL && (out->member = find_member(dot + 1, (size_t)(equals - dot - 1))) < 0)
        dot = memchr(dot + 1, '.', (size_t)(equals - dot - 1));
    if (dot == NULL) return no_such_member(text, error);
    out->pattern = sn_strndup(text, (size_t)(dot - text));
    return out->pattern != NULL ? SN_OK : sn_fail_memory(error, "a pattern");
}

static sn_status apply(sn_scene_draft *draft, const setting *s, const char *text, sn_error *error) {
    sn_index count = 0;
    for (sn_index i = 0; i < draft->muscle_count; i++) {
        sn_draft_muscle *muscle = &draft->muscles[i];
        if (!sn_pattern_matches(s->pattern, muscle->name)) continue;
        char *value = sn_strdup(s->value);
        if (value == NULL) return sn_fail_memory(error, "a setting");
        free(muscle->settings[s->member]);
        muscle->settings[s->member] = value;
        sn_status status = count++ == 0 ? judge(draft, muscle, s->member, text, error) : SN_OK;
        if (status != SN_OK) return status;
    }
    return count > 0 ? SN_OK : sn_fail(error, SN_ERROR_INPUT, "'%s': no muscle has a name of this pattern", text);
}

sn_status sn_draft_set(sn_scene_draft *draft, const char *text, sn_error *error) {
    setting s = {0};
    sn_error why = {0};
    sn_json_tree *tree = NULL;
    sn_status status = split(text, &s, error);
    if (status == SN_OK && (status = sn_draft_value_parse(s.value, &tree, &why)) != SN_OK)
        sn_fail(error, status, "'%s': %s", text, why.text);
    sn_json_tree_free(tree);
    if (status == SN_OK) status = apply(draft, &s, text, error);
    free(s.pattern);
    return status;
}
