/*
 * fit_table.c -- the table that binds a motion to a body: rows of cells with tabs between them, a row a line.
 *
 *   units   UNIT
 *   folder  PATH
 *   joint   NAME  PARENT|-  SOURCE|-  RULE  [ALONG|-  [ASIDE|-]]
 *   place   NAME  SOURCE  RULE
 *   bone    PATTERN  JOINT  [UNIT]
 *   leg     HIP  KNEE  ANKLE
 *   foot    JOINT
 *   meet    JOINT  PATTERN  PATTERN
 *
 * A row with {side}, {Side}, {s}, {S}, {+} or {-} in it stands for two: left and right, Left and Right, l and r, L and R, + and -, - and +.
 */
#include <stdlib.h>
#include <string.h>

#include "document.h"
#include "sinew/motion_fit.h"

enum { CELL_LIMIT = 8, LINE_LIMIT = 4096 };

typedef struct cells {
    int count;
    char *items[CELL_LIMIT]; /* of one line, cut in place */
} cells;

typedef struct fit_reader {
    sn_fit_table *table;
    sn_error *error;
    int64_t line;
    size_t joint_capacity, joint_point_capacity, place_capacity, bone_capacity, leg_capacity, foot_capacity, meet_capacity;
    sn_index place_count;
    sn_fit_point *places; /* behind the joints' points, once all are read */
} fit_reader;

#define COMPLAIN(r, ...) sn_fail_at((r)->error, SN_ERROR_INPUT, (r)->table->name, (r)->line, __VA_ARGS__)

/* ---- words ------------------------------------------------------------------------------------------------------------------------ */

static sn_status keep_text(char **out, const char *text, sn_error *error) {
    *out = sn_strdup(text);
    return *out != NULL ? SN_OK : sn_fail_memory(error, "a name");
}

static bool is_none(const char *text) { return strcmp(text, "-") == 0; }

/* count finite numbers, commas between them, and nothing else. */
static bool parse_numbers(const char *text, int count, double *out) {
    const char *end = text + strlen(text);
    for (int i = 0; i < count; i++) {
        if (i > 0 && *text++ != ',') return false;
        if (!sn_scan_number(text, end, &text, &out[i]) || !isfinite(out[i])) return false;
    }
    return text == end;
}

static sn_status parse_unit(const fit_reader *r, const char *text, double *out) {
    static const char *const names[] = {"m", "cm", "mm", "um", "in", "ft"};
    static const double meters[] = {1.0, 0.01, 0.001, 1e-6, 0.0254, 0.3048};
    for (size_t i = 0; i < sizeof meters / sizeof *meters; i++)
        if (strcmp(text, names[i]) == 0) *out = meters[i];
    if (*out > 0.0) return SN_OK;
    if (parse_numbers(text, 1, out) && *out > 0.0) return SN_OK;
    return COMPLAIN(r, "'%.40s' is no unit; write m, cm, mm, um, in, ft, or metres per unit", text);
}

/* ---- rules ------------------------------------------------------------------------------------------------------------------------- */

/* "ball:X,Y,Z,R" or "far:X,Y,Z,L" */
static sn_status parse_region(const fit_reader *r, const char *text, sn_fit_region *out) {
    double n[4];
    bool ball = strncmp(text, "ball:", 5) == 0;
    if ((!ball && strncmp(text, "far:", 4) != 0) || !parse_numbers(text + (ball ? 5 : 4), 4, n) || !(n[3] > 0.0))
        return COMPLAIN(r, "'%.60s' is no region; write ball:X,Y,Z,RADIUS or far:X,Y,Z,LENGTH", text);
    *out = (sn_fit_region){ball ? SN_FIT_BALL : SN_FIT_FAR, sn_v3(n[0], n[1], n[2]), n[3]};
    if (!ball) out->vector = sn_normalize(out->vector);
    if (!ball && !(sn_norm2(out->vector) > 0.0)) return COMPLAIN(r, "'%.60s': a direction of no length", text);
    return SN_OK;
}

/* "PATTERN[@REGION]..." */
static sn_status parse_selection(const fit_reader *r, char *text, sn_fit_selection *out) {
    char *next = strchr(text, '@');
    if (next != NULL) *next++ = '\0';
    if (*text == '\0') return COMPLAIN(r, "a selection begins with the name of a bone, or a pattern of names");
    sn_status status = keep_text(&out->bones, text, r->error);
    while (next != NULL && status == SN_OK) {
        char *region = next;
        next = strchr(region, '@');
        if (next != NULL) *next++ = '\0';
        if (out->region_count == SN_FIT_REGIONS) return COMPLAIN(r, "a selection has at most %d regions", SN_FIT_REGIONS);
        status = parse_region(r, region, &out->regions[out->region_count++]);
    }
    return status;
}

static int find_rule(const char *word) {
    for (int i = 0; sn_fit_rule_names[i] != NULL; i++)
        if (strcmp(sn_fit_rule_names[i], word) == 0) return i;
    return -1;
}

static char *cut_word(char **text) {
    char *word = *text + strspn(*text, " ");
    char *end = word + strcspn(word, " ");
    *text = *end != '\0' ? end + 1 : end;
    *end = '\0';
    return word;
}

/* "point X,Y,Z", "mean SELECTION", "sphere SELECTION", "middle SELECTION SELECTION", "axis SELECTION SELECTION" */
static sn_status parse_rule(const fit_reader *r, char *text, sn_fit_rule *out) {
    double n[3];
    char *word = cut_word(&text);
    int kind = find_rule(word);
    if (kind < 0) return COMPLAIN(r, "'%.40s' is no rule; known are point, mean, sphere, middle and axis", word);
    out->kind = (sn_fit_rule_kind)kind;
    if (out->kind == SN_FIT_POINT) {
        word = cut_word(&text);
        if (!parse_numbers(word, 3, n)) return COMPLAIN(r, "'%.60s' is no point; write point X,Y,Z", word);
        out->point = sn_v3(n[0], n[1], n[2]);
    }
    for (sn_index i = 0; i < sn_fit_rule_selections(out->kind); i++) {
        word = cut_word(&text);
        if (*word == '\0') return COMPLAIN(r, "a rule \"%s\" needs %s", sn_fit_rule_names[kind], i == 0 ? "a selection" : "two selections");
        sn_status status = parse_selection(r, word, &out->selections[i]);
        if (status != SN_OK) return status;
    }
    word = cut_word(&text);
    return *word == '\0' ? SN_OK : COMPLAIN(r, "'%.40s' is too much for a rule \"%s\"", word, sn_fit_rule_names[kind]);
}

/* "[level ][FROM>]TO" */
static sn_status parse_direction(const fit_reader *r, char *text, bool may_level, sn_fit_direction *out) {
    *out = (sn_fit_direction){.given = true};
    if (may_level && strncmp(text, "level ", 6) == 0) {
        out->level = true;
        text += 6;
    }
    char *behind = strchr(text, '>');
    sn_status status = SN_OK;
    if (behind != NULL) *behind++ = '\0';
    if (behind != NULL) status = keep_text(&out->names[0], text, r->error);
    if (status == SN_OK) status = keep_text(&out->names[1], behind != NULL ? behind : text, r->error);
    if (status == SN_OK && (*out->names[1] == '\0' || (behind != NULL && *text == '\0')))
        status = COMPLAIN(r, "a direction is TO or FROM>TO, names of joints or places");
    return status;
}

/* ---- rows -------------------------------------------------------------------------------------------------------------------------- */

/* One more element, all zeros, of an array of the table. */
static sn_status add_row(const fit_reader *r, void **array, sn_index *count, size_t *capacity, size_t size) {
    if (*count >= LINE_LIMIT) return COMPLAIN(r, "a table has at most %d rows of a kind", LINE_LIMIT);
    if (!sn_grow(array, capacity, (size_t)*count + 1, size)) return sn_fail_memory(r->error, "the rows");
    memset((char *)*array + (size_t)*count * size, 0, size);
    (*count)++;
    return SN_OK;
}
#define ADD(r, array, count, capacity) add_row(r, (void **)&(array), &(count), &(r)->capacity, sizeof *(array))

static sn_status parse_point(const fit_reader *r, char *name, char *source, char *rule, sn_fit_point *out) {
    out->line = r->line;
    sn_status status = keep_text(&out->name, name, r->error);
    if (status == SN_OK && (*name == '\0' || is_none(name))) status = COMPLAIN(r, "the name is missing");
    if (status == SN_OK && !is_none(source)) status = keep_text(&out->source, source, r->error);
    if (status == SN_OK && *source == '\0') status = COMPLAIN(r, "the joint of the source is missing; - stands for none");
    return status == SN_OK ? parse_rule(r, rule, &out->rule) : status;
}

static sn_status parse_joint(fit_reader *r, const cells *c) {
    sn_fit_table *t = r->table;
    sn_status status = ADD(r, t->joints, t->joint_count, joint_capacity);
    if (status != SN_OK) return status;
    status = ADD(r, t->points, t->point_count, joint_point_capacity);
    if (status != SN_OK) {
        t->joint_count--;
        return status;
    }
    sn_fit_joint *joint = &t->joints[t->joint_count - 1];
    if (!is_none(c->items[2])) status = keep_text(&joint->parent_name, c->items[2], r->error);
    if (status == SN_OK) status = parse_point(r, c->items[1], c->items[3], c->items[4], &t->points[t->point_count - 1]);
    bool along = c->count > 5 && *c->items[5] != '\0', aside = c->count > 6 && *c->items[6] != '\0' && !is_none(c->items[6]);
    joint->inherits = along && is_none(c->items[5]);
    if (status == SN_OK && along && !joint->inherits) status = parse_direction(r, c->items[5], true, &joint->along);
    if (status == SN_OK && aside && (!joint->along.given || joint->along.level))
        return COMPLAIN(r, "a direction aside only settles the turn about one along; give that too, not level");
    if (status == SN_OK && aside) status = parse_direction(r, c->items[6], false, &joint->aside);
    return status;
}

static sn_status parse_place(fit_reader *r, const cells *c) {
    sn_status status = ADD(r, r->places, r->place_count, place_capacity);
    return status == SN_OK ? parse_point(r, c->items[1], c->items[2], c->items[3], &r->places[r->place_count - 1]) : status;
}

static sn_status parse_bone(fit_reader *r, const cells *c) {
    sn_fit_table *t = r->table;
    sn_status status = ADD(r, t->bones, t->bone_count, bone_capacity);
    if (status != SN_OK) return status;
    sn_fit_bone_row *row = &t->bones[t->bone_count - 1];
    row->line = r->line;
    status = keep_text(&row->pattern, c->items[1], r->error);
    if (status == SN_OK) status = keep_text(&row->joint_name, c->items[2], r->error);
    return status == SN_OK && c->count > 3 ? parse_unit(r, c->items[3], &row->meters_per_unit) : status;
}

static sn_status parse_leg(fit_reader *r, const cells *c) {
    sn_fit_table *t = r->table;
    sn_status status = ADD(r, t->legs, t->leg_count, leg_capacity);
    if (status == SN_OK) t->legs[t->leg_count - 1].line = r->line;
    for (int i = 0; i < 3 && status == SN_OK; i++) status = keep_text(&t->legs[t->leg_count - 1].names[i], c->items[i + 1], r->error);
    return status;
}

static sn_status parse_foot(fit_reader *r, const cells *c) {
    sn_fit_table *t = r->table;
    sn_status status = ADD(r, t->feet, t->foot_count, foot_capacity);
    if (status == SN_OK) t->feet[t->foot_count - 1].line = r->line;
    return status == SN_OK ? keep_text(&t->feet[t->foot_count - 1].name, c->items[1], r->error) : status;
}

static sn_status parse_meet(fit_reader *r, const cells *c) {
    sn_fit_table *t = r->table;
    sn_status status = ADD(r, t->meets, t->meet_count, meet_capacity);
    if (status != SN_OK) return status;
    sn_fit_meet *meet = &t->meets[t->meet_count - 1];
    meet->line = r->line;
    status = keep_text(&meet->joint_name, c->items[1], r->error);
    for (int i = 0; i < 2 && status == SN_OK; i++) status = keep_text(&meet->patterns[i], c->items[i + 2], r->error);
    return status;
}

static sn_status parse_units(fit_reader *r, const cells *c) {
    if (r->table->meters_per_unit > 0.0) return COMPLAIN(r, "the unit has been told before");
    return parse_unit(r, c->items[1], &r->table->meters_per_unit);
}

static sn_status parse_folder(fit_reader *r, const cells *c) {
    if (r->table->folder != NULL) return COMPLAIN(r, "the folder has been told before");
    r->table->folder = sn_path_beside(r->table->name, c->items[1]);
    return r->table->folder != NULL ? SN_OK : sn_fail_memory(r->error, "a path");
}

static sn_status parse_row(fit_reader *r, const cells *c) {
    static const struct {
        const char *name;
        int least, most; /* cells */
        sn_status (*parse)(fit_reader *r, const cells *c);
        const char *form;
    } kinds[] = {{"units", 2, 2, parse_units, "UNIT"},
                 {"folder", 2, 2, parse_folder, "PATH"},
                 {"joint", 5, 7, parse_joint, "NAME, PARENT or -, SOURCE or -, RULE, and perhaps ALONG and ASIDE"},
                 {"place", 4, 4, parse_place, "NAME, SOURCE, RULE"},
                 {"bone", 3, 4, parse_bone, "PATTERN, JOINT, and perhaps UNIT"},
                 {"leg", 4, 4, parse_leg, "HIP, KNEE, ANKLE"},
                 {"foot", 2, 2, parse_foot, "JOINT"},
                 {"meet", 4, 4, parse_meet, "JOINT, PATTERN, PATTERN"}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        if (strcmp(c->items[0], kinds[i].name) != 0) continue;
        if (c->count < kinds[i].least || c->count > kinds[i].most)
            return COMPLAIN(r, "a row \"%s\" has, with tabs between them: %s", kinds[i].name, kinds[i].form);
        for (int k = 1; k < kinds[i].least; k++)
            if (*c->items[k] == '\0') return COMPLAIN(r, "cell %d of the row is empty; it has: %s", k + 1, kinds[i].form);
        return kinds[i].parse(r, c);
    }
    return COMPLAIN(r, "'%.40s' is no kind of row; known are units, folder, joint, place, bone, leg, foot and meet", c->items[0]);
}

/* ---- lines -------------------------------------------------------------------------------------------------------------------------- */

static char *trim(char *text) {
    text += strspn(text, " \r");
    size_t length = strlen(text);
    while (length > 0 && strchr(" \r", text[length - 1]) != NULL) length--;
    text[length] = '\0';
    return text;
}

/* Cut at tabs; empty cells at the end do not count. */
static sn_status parse_cells(fit_reader *r, char *text) {
    cells c = {0};
    for (char *next = text; next != NULL;) {
        char *cell = next;
        next = strchr(cell, '\t');
        if (next != NULL) *next++ = '\0';
        cell = trim(cell);
        if (c.count < CELL_LIMIT)
            c.items[c.count++] = cell;
        else if (*cell != '\0')
            return COMPLAIN(r, "no row has more than %d cells", CELL_LIMIT - 1);
    }
    while (c.count > 1 && *c.items[c.count - 1] == '\0') c.count--;
    return parse_row(r, &c);
}

/* What stands for a word in braces on a side; NULL = it is none. */
static const char *side_word(const char *text, size_t length, int side) {
    static const char *const words[][3] = {{"{side}", "left", "right"}, {"{Side}", "Left", "Right"}, {"{s}", "l", "r"},
                                           {"{S}", "L", "R"},           {"{+}", "+", "-"},           {"{-}", "-", "+"}};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strlen(words[i][0]) == length && strncmp(words[i][0], text, length) == 0) return words[i][side + 1];
    return NULL;
}

/* text (size) with the words of one side put in; no word is longer than what it stands for. */
static sn_status parse_side(fit_reader *r, const char *text, size_t size, int side) {
    char *row = sn_alloc(size + 1, 1), *to = row;
    if (row == NULL) return sn_fail_memory(r->error, "a row");
    sn_status status = SN_OK;
    for (const char *at = text; at < text + size && status == SN_OK;) {
        const char *close = *at == '{' ? memchr(at, '}', (size_t)(text + size - at)) : NULL;
        const char *word = close != NULL ? side_word(at, (size_t)(close + 1 - at), side) : NULL;
        if (*at == '{' && word == NULL) {
            status = COMPLAIN(r, "what is in braces is none of {side} {Side} {s} {S} {+} {-}");
        } else if (word != NULL) {
            to = memcpy(to, word, strlen(word));
            to += strlen(word);
            at = close + 1;
        } else {
            *to++ = *at++;
        }
    }
    if (status == SN_OK) status = parse_cells(r, row);
    free(row);
    return status;
}

static sn_status parse_line(fit_reader *r, const char *text, size_t size) {
    size_t blanks = 0;
    while (blanks < size && memchr(" \t\r", text[blanks], 3) != NULL) blanks++;
    if (blanks == size || text[blanks] == '#') return SN_OK;
    if (memchr(text, '\0', size) != NULL) return COMPLAIN(r, "the line has a byte of zero in it; is this a table?");
    if (size > LINE_LIMIT) return COMPLAIN(r, "the line is longer than %d characters; is this a table?", LINE_LIMIT);
    bool two = memchr(text, '{', size) != NULL;
    sn_status status = parse_side(r, text, size, 0);
    return status == SN_OK && two ? parse_side(r, text, size, 1) : status;
}

static sn_status parse_lines(fit_reader *r, const sn_blob *blob) {
    sn_text_lines lines = sn_text_lines_of(blob->data, blob->size);
    sn_status status = SN_OK;
    for (const char *text, *end; status == SN_OK && sn_text_next_line(&lines, &text, &end);) {
        r->line = lines.line;
        status = parse_line(r, text, (size_t)(end - text));
    }
    return status;
}

/* ---- the table ------------------------------------------------------------------------------------------------------------------------
 */

/* Places behind the joints' points, which they belong to from here on also where this fails. */
static sn_status append_places(fit_reader *r) {
    sn_fit_table *t = r->table;
    void *points = t->points;
    size_t capacity = r->joint_point_capacity;
    bool room = sn_grow(&points, &capacity, (size_t)t->point_count + (size_t)r->place_count, sizeof *t->points);
    t->points = points;
    if (room && r->place_count > 0) {
        memcpy(t->points + t->point_count, r->places, (size_t)r->place_count * sizeof *r->places);
        t->point_count += r->place_count;
        r->place_count = 0;
    }
    sn_fit_table rest = {.point_count = r->place_count, .points = r->places};
    sn_fit_table_free(&rest);
    return room ? SN_OK : sn_fail_memory(r->error, "the places");
}

static void scale_lengths(sn_fit_table *table) {
    double scale = table->meters_per_unit;
    for (sn_index i = 0; i < table->point_count; i++) {
        sn_fit_rule *rule = &table->points[i].rule;
        rule->point = sn_scale(rule->point, scale);
        for (sn_index s = 0; s < 2; s++)
            for (sn_index k = 0; k < rule->selections[s].region_count; k++) {
                sn_fit_region *region = &rule->selections[s].regions[k];
                region->length *= scale;
                if (region->kind == SN_FIT_BALL) region->vector = sn_scale(region->vector, scale);
            }
    }
}

sn_status sn_fit_table_parse(const sn_blob *blob, sn_fit_table *out, sn_error *error) {
    fit_reader r = {.table = out, .error = error};
    *out = (sn_fit_table){.name = sn_strdup(blob->name)};
    if (out->name == NULL) return sn_fail_memory(error, "a name");
    sn_status status = parse_lines(&r, blob), more = append_places(&r);
    if (status == SN_OK) status = more;
    if (!(out->meters_per_unit > 0.0)) out->meters_per_unit = 1.0;
    if (status == SN_OK) {
        scale_lengths(out);
        status = sn_fit_table_link(out, error);
    }
    if (status != SN_OK) {
        sn_error_set_file(error, blob->name);
        sn_fit_table_free(out);
    }
    return status;
}
