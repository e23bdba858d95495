/*
 * asf.c -- Acclaim's skeleton file: bones with direction, length, axes and degrees of freedom, and which hangs on which.
 *
 * A bone turns about its start, the end of its parent. With C the rotation of its `axis` and M that of a motion's angles, its frame moves
 * by C M C^-1 against its parent (J. Lander: Working with motion capture file formats, Game Developer 1998; Acclaim's own notes).
 */
#include "asf.h"

#include <stdlib.h>
#include <string.h>

#include "document.h"

const char *const sn_asf_freedom_names[SN_ASF_FREEDOMS] = {"tx", "ty", "tz", "rx", "ry", "rz"};

typedef struct parser {
    sn_reader reader;
    sn_asf *asf;
} parser;

/* Both formats begin with remarks, then a keyword; those of a motion are few. */
static bool is_motion_keyword(sn_span word) {
    return sn_span_is_like(word, ":FULLY-SPECIFIED") || sn_span_is_like(word, ":DEGREES") || sn_span_is_like(word, ":RADIANS") ||
           sn_span_is_like(word, ":SAMPLES-PER-SECOND");
}

bool sn_asf_is(const sn_blob *blob) {
    static const char *const keywords[] = {":version", ":name", ":units", ":documentation", ":root", ":bonedata", ":hierarchy"};
    sn_span word = sn_clip_first_word(blob);
    for (size_t i = 0; i < sizeof keywords / sizeof *keywords; i++)
        if (sn_span_is_like(word, keywords[i])) return true;
    return false;
}

bool sn_amc_is(const sn_blob *blob) {
    sn_reader reader = sn_clip_open(blob, NULL);
    int64_t number;
    if (is_motion_keyword(sn_clip_first_word(blob))) return true;
    return sn_reader_find_line(&reader) && sn_reader_integer(&reader, &number) && sn_reader_at_line_end(&reader) &&
           sn_span_is_like(sn_clip_word(&reader), "root");
}

void sn_asf_free(sn_asf *asf) {
    for (sn_index i = 0; i < asf->count; i++) free(asf->bones[i].name);
    free(asf->bones);
    free(asf->order);
    free(asf->by_name);
    *asf = (sn_asf){0};
}

/* ---- words --------------------------------------------------------------------------------------------------------------------------- */

static int shown(sn_span word) { return (int)(word.length < 40 ? word.length : 40); }

static sn_status unexpected(const parser *p, sn_span word, const char *what) {
    if (word.length == 0) return sn_reader_fail(&p->reader, SN_NONE, "expected %s, found the end of the file", what);
    return sn_reader_fail(&p->reader, SN_NONE, "expected %s, found '%.*s'", what, shown(word), word.text);
}

/* The next word of a section; false at the next section's keyword, which stays, and at the end of the file. */
static bool section_word(parser *p, sn_span *word) {
    sn_reader before = p->reader;
    *word = sn_clip_word(&p->reader);
    if (word->length > 0 && word->text[0] != ':') return true;
    if (word->length > 0) p->reader = before;
    return false;
}

static sn_status read_vector(parser *p, const char *what, double out[3]) {
    sn_status status = SN_OK;
    for (int k = 0; k < 3 && status == SN_OK; k++) status = sn_clip_number(&p->reader, what, &out[k]);
    return status;
}

/* "XYZ": axes in the order in which they are turned about; order is left alone where that is not what stands there. */
static sn_status read_axes(parser *p, int order[3]) {
    sn_span word = sn_reader_word(&p->reader);
    int read[3] = {-1, -1, -1};
    unsigned seen = 0;
    for (size_t i = 0; i < word.length && i < 3; i++) {
        read[i] = (word.text[i] | 0x20) - 'x';
        if (read[i] >= 0 && read[i] < 3) seen |= 1U << read[i];
    }
    if (word.length != 3 || seen != 7) return unexpected(p, word, "an order of axes such as XYZ");
    for (int k = 0; k < 3; k++) order[k] = read[k];
    return SN_OK;
}

/* Turn about the axes in their order, each by its own angle. */
static sn_quat turn_in_order(const double angles[3], const int order[3], double unit) {
    sn_quat q = sn_quat_identity();
    for (int k = 0; k < 3; k++) q = sn_quat_multiply(sn_clip_turn(order[k], angles[order[k]] * unit), q);
    return sn_quat_normalize(q);
}

/* Degrees of freedom up to the end of the line. */
static sn_status read_freedoms(parser *p, sn_asf_bone *bone) {
    while (!sn_reader_at_line_end(&p->reader)) {
        sn_span word = sn_reader_word(&p->reader);
        int kind = 0;
        while (kind < SN_ASF_FREEDOMS && !sn_span_is_like(word, sn_asf_freedom_names[kind])) kind++;
        if (sn_span_is_like(word, "l"))
            return sn_reader_fail(&p->reader, SN_NONE, "bones that stretch (dof l) cannot be read; bones are rigid");
        if (kind == SN_ASF_FREEDOMS) return unexpected(p, word, "a degree of freedom: tx ty tz rx ry rz");
        for (int i = 0; i < bone->freedom_count; i++)
            if (bone->freedoms[i] == kind) return sn_reader_fail(&p->reader, SN_NONE, "%s stands twice", sn_asf_freedom_names[kind]);
        bone->freedoms[bone->freedom_count++] = (unsigned char)kind;
    }
    return SN_OK;
}

/* ---- units and root -------------------------------------------------------------------------------------------------------------------
 */

static sn_status read_units(parser *p) {
    sn_span word;
    sn_status status = SN_OK;
    while (status == SN_OK && section_word(p, &word)) {
        if (sn_span_is_like(word, "length")) {
            status = sn_clip_number(&p->reader, "the unit of length", &p->asf->length);
            if (status == SN_OK && !(p->asf->length >= 1e-9 && p->asf->length <= 1e9))
                status = sn_reader_fail(&p->reader, SN_NONE, "a unit of length of %g is not within 1e-9 to 1e9", p->asf->length);
        } else if (sn_span_is_like(word, "angle")) {
            sn_span unit = sn_reader_word(&p->reader);
            if (!sn_span_is_like(unit, "deg") && !sn_span_is_like(unit, "rad")) return unexpected(p, unit, "deg or rad");
            p->asf->angle = sn_span_is_like(unit, "deg") ? SN_DEGREE : 1.0;
        } else {
            sn_reader_rest(&p->reader);
        }
    }
    return status;
}

static sn_status read_root(parser *p) {
    sn_asf_bone *root = &p->asf->bones[0];
    double position[3] = {0}, orientation[3] = {0};
    int axes[3] = {0, 1, 2};
    sn_span word;
    sn_status status = SN_OK;
    root->freedom_count = 0;
    while (status == SN_OK && section_word(p, &word)) {
        if (sn_span_is_like(word, "order"))
            status = read_freedoms(p, root);
        else if (sn_span_is_like(word, "axis"))
            status = read_axes(p, axes);
        else if (sn_span_is_like(word, "position"))
            status = read_vector(p, "the root's position", position);
        else if (sn_span_is_like(word, "orientation"))
            status = read_vector(p, "the root's orientation", orientation);
        else
            status = unexpected(p, word, "order, axis, position or orientation");
    }
    if (status != SN_OK) return status;
    root->axis = turn_in_order(orientation, axes, p->asf->angle);
    p->asf->position = sn_v3(position[0], position[1], position[2]);
    return SN_OK;
}

/* ---- bones ----------------------------------------------------------------------------------------------------------------------------
 */

static bool take_sign(parser *p, char sign) {
    if (!sn_reader_find_line(&p->reader) || *p->reader.at != sign) return false;
    p->reader.at++;
    return true;
}

/* "(low high)"; either may be inf. */
static bool read_limit(parser *p, double limit[2]) {
    sn_reader *r = &p->reader;
    if (!take_sign(p, '(')) return false;
    for (int k = 0; k < 2; k++) {
        const char *next;
        if (!sn_reader_find_line(r) || !sn_scan_number(r->at, r->end, &next, &limit[k]) || isnan(limit[k])) return false;
        if (!sn_reader_ends_token(r, next) && *next != ')') return false;
        r->at = next;
    }
    return take_sign(p, ')');
}

static sn_status read_limits(parser *p, sn_asf_bone *bone) {
    for (int k = 0; k < bone->freedom_count; k++)
        if (!read_limit(p, bone->limits[k]))
            return sn_reader_fail(&p->reader, SN_NONE, "expected the limits (low high) of %s", sn_asf_freedom_names[bone->freedoms[k]]);
    bone->limited = true;
    return SN_OK;
}

static sn_status read_bone_name(parser *p, sn_asf_bone *bone) {
    sn_span word = sn_reader_word(&p->reader);
    if (word.length == 0 || bone->name != NULL) return sn_reader_fail(&p->reader, SN_NONE, "expected one name for the bone");
    return (bone->name = sn_strndup(word.text, word.length)) != NULL ? SN_OK : sn_fail_memory(p->reader.error, "a name");
}

static sn_status read_axis(parser *p, sn_asf_bone *bone) {
    double angles[3] = {0};
    int order[3] = {0, 1, 2};
    sn_status status = read_vector(p, "an angle of the axis", angles);
    if (status == SN_OK) status = read_axes(p, order);
    if (status == SN_OK) bone->axis = turn_in_order(angles, order, p->asf->angle);
    return status;
}

static sn_status read_bone_member(parser *p, sn_span word, sn_asf_bone *bone) {
    double direction[3] = {0};
    sn_status status = SN_OK;
    if (sn_span_is_like(word, "name")) return read_bone_name(p, bone);
    if (sn_span_is_like(word, "length")) return sn_clip_number(&p->reader, "the bone's length", &bone->length);
    if (sn_span_is_like(word, "axis")) return read_axis(p, bone);
    if (sn_span_is_like(word, "dof")) return read_freedoms(p, bone);
    if (sn_span_is_like(word, "limits")) return read_limits(p, bone);
    if (!sn_span_is_like(word, "direction")) { /* id, bodymass, cofmass, ... */
        sn_reader_rest(&p->reader);
        return SN_OK;
    }
    status = read_vector(p, "the bone's direction", direction);
    if (status == SN_OK) bone->direction = sn_v3(direction[0], direction[1], direction[2]);
    return status;
}

/* A new bone; NULL = *status tells why not. */
static sn_asf_bone *add_bone(parser *p, sn_status *status) {
    sn_asf *asf = p->asf;
    *status = SN_OK;
    if (asf->count == SN_LIST_LIMIT)
        *status = sn_reader_fail(&p->reader, SN_NONE, "there are more than %d bones", SN_LIST_LIMIT);
    else if (!sn_grow((void **)&asf->bones, &asf->capacity, (size_t)asf->count + 1, sizeof *asf->bones))
        *status = sn_fail_memory(p->reader.error, "bones");
    if (*status != SN_OK) return NULL;
    sn_asf_bone *bone = &asf->bones[asf->count++];
    *bone = (sn_asf_bone){.parent = SN_NONE, .axis = sn_quat_identity(), .line = p->reader.line};
    return bone;
}

static sn_status read_bone(parser *p) {
    sn_span word = {0};
    sn_status status;
    sn_asf_bone *bone = add_bone(p, &status);
    if (bone == NULL) return status;
    while (status == SN_OK) {
        if (!section_word(p, &word)) return sn_reader_fail(&p->reader, SN_NONE, "a bone's 'begin' has no 'end'; the file is cut off");
        if (sn_span_is_like(word, "end")) break;
        status = read_bone_member(p, word, bone);
    }
    if (status == SN_OK && bone->name == NULL) return sn_reader_fail(&p->reader, SN_NONE, "the bone that ends here has no name");
    return status;
}

static sn_status read_bones(parser *p) {
    sn_span word;
    sn_status status = SN_OK;
    while (status == SN_OK && section_word(p, &word)) status = sn_span_is_like(word, "begin") ? read_bone(p) : unexpected(p, word, "begin");
    return status;
}

/* ---- the hierarchy --------------------------------------------------------------------------------------------------------------------
 */

static int compare_span(sn_span a, const char *b) {
    size_t length = strlen(b), common = a.length < length ? a.length : length;
    int order = memcmp(a.text, b, common);
    return order != 0 ? order : a.length < length ? -1 : a.length > length;
}

sn_index sn_asf_find(const sn_asf *asf, sn_span name) {
    for (sn_index low = 0, high = asf->count; low < high;) {
        sn_index middle = low + (high - low) / 2, bone = asf->by_name[middle];
        int order = compare_span(name, asf->bones[bone].name);
        if (order == 0) return bone;
        if (order < 0)
            high = middle;
        else
            low = middle + 1;
    }
    return SN_NONE;
}

static int compare_bones(const void *a, const void *b, void *asf) {
    const sn_asf_bone *bones = ((const sn_asf *)asf)->bones;
    return strcmp(bones[*(const sn_index *)a].name, bones[*(const sn_index *)b].name);
}

static sn_status sort_bones(parser *p) {
    sn_asf *asf = p->asf;
    free(asf->by_name);
    asf->by_name = SN_NEW(sn_index, asf->count);
    if (asf->by_name == NULL) return sn_fail_memory(p->reader.error, "bones");
    for (sn_index i = 0; i < asf->count; i++) asf->by_name[i] = i;
    qsort_r(asf->by_name, (size_t)asf->count, sizeof *asf->by_name, compare_bones, asf);
    for (sn_index i = 1; i < asf->count; i++)
        if (strcmp(asf->bones[asf->by_name[i - 1]].name, asf->bones[asf->by_name[i]].name) == 0)
            return sn_reader_fail(&p->reader, SN_NONE, "two bones have the name '%.80s'", asf->bones[asf->by_name[i]].name);
    return SN_OK;
}

static sn_status find_word(parser *p, sn_span word, sn_index *out) {
    *out = sn_asf_find(p->asf, word);
    return *out != SN_NONE ? SN_OK : sn_reader_fail(&p->reader, SN_NONE, "there is no bone '%.*s'", shown(word), word.text);
}

/* A parent and its children. */
static sn_status read_children(parser *p, sn_span word) {
    sn_index parent, child;
    sn_status status = find_word(p, word, &parent);
    while (status == SN_OK && !sn_reader_at_line_end(&p->reader)) {
        status = find_word(p, sn_reader_word(&p->reader), &child);
        if (status == SN_OK && (child == 0 || p->asf->bones[child].parent != SN_NONE))
            status = sn_reader_fail(&p->reader, SN_NONE, "'%.80s' cannot hang on '%.80s': it has a parent, or is the root",
                                    p->asf->bones[child].name, p->asf->bones[parent].name);
        if (status == SN_OK) p->asf->bones[child].parent = parent;
    }
    return status;
}

static sn_status read_hierarchy(parser *p) {
    sn_span word;
    sn_status status = sort_bones(p);
    while (status == SN_OK && section_word(p, &word))
        if (!sn_span_is_like(word, "begin") && !sn_span_is_like(word, "end")) status = read_children(p, word);
    return status;
}

/* The bones in the order of the file, but for parents first. */
static sn_status order_bones(parser *p) {
    sn_asf *asf = p->asf;
    bool *placed = SN_NEW(bool, asf->count);
    sn_index count = 1, before = 0;
    asf->order = SN_NEW(sn_index, asf->count);
    if (placed == NULL || asf->order == NULL) {
        free(placed);
        return sn_fail_memory(p->reader.error, "bones");
    }
    placed[0] = true;
    while (count > before) { /* until a round places none */
        before = count;
        for (sn_index i = 1; i < asf->count; i++) {
            if (placed[i] || asf->bones[i].parent == SN_NONE || !placed[asf->bones[i].parent]) continue;
            placed[i] = true;
            asf->order[count++] = i;
        }
    }
    sn_index lost = 1;
    while (lost < asf->count && placed[lost]) lost++;
    free(placed);
    if (lost == asf->count) return SN_OK;
    return sn_fail_at(p->reader.error, SN_ERROR_INPUT, p->reader.blob->name, asf->bones[lost].line,
                      "the bone '%.80s' hangs on no chain of :hierarchy from the root", asf->bones[lost].name);
}

/* ---- the file --------------------------------------------------------------------------------------------------------------------------
 */

static sn_status read_section(parser *p, sn_span keyword, bool *hierarchy) {
    sn_span word;
    if (sn_span_is_like(keyword, ":units")) return read_units(p);
    if (sn_span_is_like(keyword, ":root")) return read_root(p);
    if (sn_span_is_like(keyword, ":bonedata")) return read_bones(p);
    if (sn_span_is_like(keyword, ":hierarchy")) {
        *hierarchy = true;
        return read_hierarchy(p);
    }
    sn_reader_rest(&p->reader); /* :version, :name, :documentation, :skin */
    while (section_word(p, &word)) sn_reader_rest(&p->reader);
    return SN_OK;
}

static sn_status read_file(parser *p) {
    bool hierarchy = false;
    sn_status status;
    sn_asf_bone *root = add_bone(p, &status);
    if (root == NULL) return status;
    if ((root->name = sn_strdup("root")) == NULL) status = sn_fail_memory(p->reader.error, "a name");
    while (status == SN_OK) {
        sn_span word = sn_clip_word(&p->reader);
        if (word.length == 0) break;
        status = word.text[0] == ':' ? read_section(p, word, &hierarchy) : unexpected(p, word, "a keyword such as :bonedata");
    }
    if (status == SN_OK && !hierarchy) status = sn_reader_fail(&p->reader, SN_NONE, "there is no :hierarchy; the file is cut off");
    if (status == SN_OK) status = sort_bones(p); /* also of bones behind the hierarchy */
    return status == SN_OK ? order_bones(p) : status;
}

sn_status sn_asf_parse(const sn_blob *blob, sn_asf *out, sn_error *error) {
    parser p = {.reader = sn_clip_open(blob, error), .asf = out};
    *out = (sn_asf){.length = 1.0, .angle = SN_DEGREE};
    if (!sn_asf_is(blob)) return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "is no skeleton of Acclaim's (.asf)");
    sn_status status = read_file(&p);
    if (status != SN_OK) sn_asf_free(out);
    return status;
}

/* ---- the clip --------------------------------------------------------------------------------------------------------------------------
 */

static bool describe_bone(const sn_asf *asf, sn_index i, const sn_index *joint_of, double scale, sn_clip *clip) {
    const sn_asf_bone *bone = &asf->bones[asf->order[i]];
    sn_clip_joint *joint = &clip->joints[i];
    joint->rest = sn_scale(asf->position, scale);
    joint->rest_rotation = bone->axis;
    if (i > 0) {
        const sn_asf_bone *parent = &asf->bones[bone->parent];
        joint->parent = joint_of[bone->parent];
        joint->rest = sn_add_scaled(clip->joints[joint->parent].rest, parent->direction, parent->length * scale);
        joint->has_end = true;
        joint->end = sn_add_scaled(joint->rest, bone->direction, bone->length * scale);
    }
    return (joint->name = sn_strdup(bone->name)) != NULL;
}

static bool describe_freedoms(const sn_asf_bone *bone, sn_clip_coordinate *out) {
    for (int k = 0; k < bone->freedom_count; k++) {
        out[k].name = sn_clip_channel_name(bone->name, sn_asf_freedom_names[bone->freedoms[k]]);
        out[k].unit = sn_strdup(bone->freedoms[k] < 3 ? "m" : "rad");
        if (out[k].name == NULL || out[k].unit == NULL) return false;
    }
    return true;
}

sn_status sn_asf_make_clip(const sn_asf *asf, double meters_per_unit, sn_reader *reader, int64_t frames, sn_index *first_coordinate,
                           sn_clip *out) {
    sn_index coordinates = 0, *joint_of = SN_NEW(sn_index, asf->count);
    *out = (sn_clip){0};
    if (joint_of == NULL) return sn_fail_memory(reader->error, "joints");
    for (sn_index i = 0; i < asf->count; i++) {
        joint_of[asf->order[i]] = i;
        first_coordinate[asf->order[i]] = coordinates;
        coordinates += asf->bones[asf->order[i]].freedom_count;
    }
    sn_status status = sn_clip_reserve(reader, frames, asf->count, coordinates, out);
    bool enough = true;
    for (sn_index i = 0; i < asf->count && status == SN_OK && enough; i++)
        enough = describe_bone(asf, i, joint_of, meters_per_unit / asf->length, out) &&
                 describe_freedoms(&asf->bones[asf->order[i]], out->coordinates + first_coordinate[asf->order[i]]);
    free(joint_of);
    if (status != SN_OK) return status;
    out->meters_per_unit_of_source = meters_per_unit / asf->length;
    if (enough) return SN_OK;
    sn_clip_free(out);
    return sn_fail_memory(reader->error, "joints");
}

sn_status sn_asf_read(const sn_clip_source *source, sn_clip *out, sn_error *error) {
    sn_asf asf;
    *out = (sn_clip){0};
    sn_status status = sn_asf_parse(source->motion, &asf, error);
    if (status != SN_OK) return status;
    sn_reader reader = sn_clip_open(source->motion, error);
    sn_index *first = SN_NEW(sn_index, asf.count);
    status =
        first != NULL ? sn_asf_make_clip(&asf, source->options.meters_per_unit, &reader, 1, first, out) : sn_fail_memory(error, "joints");
    out->rate = source->options.rate > 0.0 ? source->options.rate : 1.0; /* of one frame */
    free(first);
    sn_asf_free(&asf);
    return status;
}
