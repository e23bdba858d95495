/* animate.c -- a skeleton moved by columns of numbers over time: coordinates to bodies' poses. */
#include "sinew/skeleton.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double RADIANS_PER_DEGREE = SN_PI / 180.0;
/* Times this part of a step off an even spacing are even ones that were rounded when they were written. */
static const double EVEN_WITHIN = 0.05;
/* A rate this near to a whole number is that number: it comes from rounded times. */
static const double WHOLE_WITHIN = 1e-4;
/* A file's digits: a locked coordinate that differs by less from its default is there. */
static const double LOCKED_WITHIN = 1e-6;
/* Lengths and angles past this are none: products of some of them must stay finite. */
static const double FARTHEST = 1e60;

typedef struct animation {
    const sn_skeleton *skeleton;
    const sn_columns *columns;  /* nullable */
    sn_index *source;           /* (coordinate_count) column of a coordinate; SN_NONE = it stays at rest */
    double *rest, *values;      /* (coordinate_count) */
    sn_rigid *at_rest, *frames; /* (body_count) */
    bool even;                  /* rows are the frames */
    double rate;
    int64_t clamped; /* values that were out of their range */
} animation;

void sn_columns_free(sn_columns *columns) {
    for (sn_index i = 0; columns->names != NULL && i < columns->column_count; i++) free(columns->names[i]);
    free(columns->names);
    free(columns->times);
    free(columns->values);
    free(columns->name);
    *columns = (sn_columns){0};
}

static sn_status fail_row(const sn_columns *c, sn_index row, sn_error *error, const char *what, const char *name) {
    int64_t line = c->first_line > 0 && row >= 0 ? c->first_line + row : 0;
    return sn_fail_at(error, SN_ERROR_INPUT, c->name != NULL ? c->name : "", line, what, name);
}

/* The row of names. */
static sn_status fail_names(const sn_columns *c, sn_error *error, const char *what, const char *name) {
    return sn_fail_at(error, SN_ERROR_INPUT, c->name != NULL ? c->name : "", c->names_line, what, name);
}

/* ---- which column moves what ------------------------------------------------------------------------------------------------------- */

/* Names of what is left out, as many as fit. */
typedef struct leftover {
    int64_t count;
    char names[256];
} leftover;

static void leave_out(leftover *left, const char *name) {
    size_t used = strlen(left->names);
    if (left->count < 6) snprintf(left->names + used, sizeof left->names - used, "%s%.32s", left->count > 0 ? ", " : "", name);
    if (left->count == 6) snprintf(left->names + used, sizeof left->names - used, ", ...");
    left->count++;
}

static sn_status find_sources(animation *a, sn_error *error) {
    const sn_columns *c = a->columns;
    leftover left = {0};
    for (sn_index i = 0; i < a->skeleton->coordinate_count; i++) a->source[i] = SN_NONE;
    for (sn_index k = 0; c != NULL && k < c->column_count; k++) {
        sn_index found = sn_skeleton_find_coordinate(a->skeleton, c->names[k]);
        if (found == SN_NONE)
            leave_out(&left, c->names[k]);
        else if (a->source[found] != SN_NONE)
            return fail_names(c, error, "two columns speak of the coordinate \"%.100s\"; take one of them out",
                              a->skeleton->coordinates[found].name);
        else
            a->source[found] = k;
    }
    if (c != NULL && left.count == c->column_count)
        return fail_names(c, error, "no column is a coordinate of the model (%.200s); is the model the right one?", left.names);
    if (left.count > 0)
        sn_log(SN_LOG_WARNING, "%s: %lld of %d columns are no coordinates of the model and are left out: %s", c->name,
               (long long)left.count, (int)c->column_count, left.names);
    return SN_OK;
}

/* Locked coordinates that their column would move. */
static void warn_of_locked(const animation *a) {
    const sn_columns *c = a->columns;
    leftover left = {0};
    for (sn_index i = 0; i < a->skeleton->coordinate_count; i++) {
        const sn_skeleton_coordinate *coordinate = &a->skeleton->coordinates[i];
        double unit = coordinate->degrees && c->degrees ? RADIANS_PER_DEGREE : 1.0;
        bool moves = false;
        if (!coordinate->locked || a->source[i] == SN_NONE) continue;
        for (sn_index row = 0; row < c->row_count && !moves; row++) {
            double value = c->values[(size_t)row * (size_t)c->column_count + (size_t)a->source[i]] * unit;
            moves = fabs(value - a->rest[i]) > LOCKED_WITHIN;
        }
        if (moves) leave_out(&left, coordinate->name);
    }
    if (left.count > 0)
        sn_log(SN_LOG_WARNING, "%s: the model locks coordinates that the file moves; they stay at their default: %s", c->name, left.names);
}

/* ---- when ------------------------------------------------------------------------------------------------------------------------------
 */

static sn_status check_times(const sn_columns *c, sn_error *error) {
    if (c->row_count < 1) return fail_row(c, -1, error, "there is no row%s", "");
    for (sn_index i = 0; i < c->row_count; i++) {
        if (!isfinite(c->times[i])) return fail_row(c, i, error, "the time is not finite%s", "");
        if (i > 0 && !(c->times[i] > c->times[i - 1]))
            return fail_row(c, i, error, "the time is not later than that of the row before%s; sort the rows by time, each time once", "");
    }
    return SN_OK;
}

static sn_status find_rate(animation *a, sn_error *error) {
    const sn_columns *c = a->columns;
    a->even = true;
    a->rate = 1.0;
    sn_status status = c != NULL ? check_times(c, error) : SN_OK;
    if (status != SN_OK || c == NULL || c->row_count == 1) return status;
    a->rate = (c->row_count - 1) / (c->times[c->row_count - 1] - c->times[0]);
    if (!isfinite(a->rate) || !(a->rate > 0.0)) return fail_row(c, 1, error, "the times are too near or too far apart%s", "");
    double whole = floor(a->rate + 0.5);
    if (fabs(a->rate - whole) <= WHOLE_WITHIN * a->rate) a->rate = whole;
    for (sn_index i = 0; i < c->row_count; i++) a->even = a->even && fabs((c->times[i] - c->times[0]) * a->rate - i) <= EVEN_WITHIN;
    if (!a->even) sn_log(SN_LOG_WARNING, "%s: the times are uneven; the rows are resampled to %g a second", c->name, a->rate);
    return SN_OK;
}

/* ---- coordinates of a frame ------------------------------------------------------------------------------------------------------------
 */

/* The rows before and after the time of a frame, and how far it is between them. */
typedef struct moment {
    sn_index row, next;
    double part;
} moment;

static moment find_moment(const animation *a, sn_index frame, sn_index from) {
    const sn_columns *c = a->columns;
    if (a->even) return (moment){frame, frame, 0.0};
    double time = c->times[0] + frame / a->rate;
    while (from + 2 < c->row_count && c->times[from + 1] <= time) from++;
    double part = (time - c->times[from]) / (c->times[from + 1] - c->times[from]);
    return (moment){from, from + 1, fmin(fmax(part, 0.0), 1.0)};
}

static double column_at(const sn_columns *c, sn_index column, moment m) {
    double before = c->values[(size_t)m.row * (size_t)c->column_count + (size_t)column];
    double after = c->values[(size_t)m.next * (size_t)c->column_count + (size_t)column];
    return before + m.part * (after - before);
}

static sn_status set_coordinate(animation *a, sn_index i, moment m, sn_error *error) {
    const sn_skeleton_coordinate *c = &a->skeleton->coordinates[i];
    double value = a->rest[i];
    if (a->source[i] != SN_NONE && !c->locked) {
        value = column_at(a->columns, a->source[i], m);
        if (!isfinite(value)) return fail_row(a->columns, m.row, error, "column \"%.100s\" is not finite", c->name);
        if (c->degrees && a->columns->degrees) value *= RADIANS_PER_DEGREE;
    }
    a->values[i] = c->clamped ? fmin(fmax(value, c->low), c->high) : value;
    a->clamped += a->values[i] != value;
    return SN_OK;
}

/* ---- the clip
 * ---------------------------------------------------------------------------------------------------------------------------- */

/* Coordinates of the same name in two joints get the joint's before it. */
static char *coordinate_name(const sn_skeleton *s, sn_index index) {
    const sn_skeleton_coordinate *c = &s->coordinates[index];
    bool alone = true;
    for (sn_index i = 0; i < s->coordinate_count; i++) alone = alone && (i == index || strcmp(s->coordinates[i].name, c->name) != 0);
    if (alone || c->joint == NULL) return sn_strdup(c->name);
    size_t size = strlen(c->joint) + strlen(c->name) + 2;
    char *name = sn_alloc(size, 1);
    if (name != NULL) snprintf(name, size, "%s/%s", c->joint, c->name);
    return name;
}

static sn_status set_names(const animation *a, sn_clip *out, sn_error *error) {
    const sn_skeleton *s = a->skeleton;
    bool enough = s->name == NULL || (out->name = sn_strdup(s->name)) != NULL;
    for (sn_index i = 0; i < s->body_count && enough; i++) {
        sn_clip_joint *joint = &out->joints[i];
        enough = (joint->name = sn_strdup(s->bodies[i].name)) != NULL;
        joint->parent = s->bodies[i].parent;
        joint->rest = sn_rigid_apply(a->at_rest[i], s->bodies[i].centre);
        joint->rest_rotation = a->at_rest[i].rotation;
    }
    for (sn_index i = 0; i < s->coordinate_count && enough; i++) {
        sn_clip_coordinate *c = &out->coordinates[i];
        enough = (c->name = coordinate_name(s, i)) != NULL && (c->unit = sn_strdup(s->coordinates[i].angular ? "rad" : "m")) != NULL;
    }
    return enough ? SN_OK : sn_fail_memory(error, "a motion");
}

static sn_rigid away_from(sn_rigid rest, sn_rigid now) {
    sn_rigid pose = sn_rigid_compose(now, sn_rigid_inverse(rest));
    pose.rotation = sn_quat_normalize(pose.rotation);
    return pose;
}

static bool in_reach(double value) { return fabs(value) <= FARTHEST; }

/* Coordinates and bodies of one row: what is too large cannot be reckoned with. */
static sn_status check_sizes(const animation *a, const double *values, const sn_rigid *frames, sn_index row, sn_error *error) {
    const sn_skeleton *s = a->skeleton;
    const char *what = "\"%.100s\": its numbers are too large", *name = NULL;
    for (sn_index i = 0; i < s->coordinate_count && name == NULL; i++)
        if (!in_reach(values[i])) name = s->coordinates[i].name;
    for (sn_index i = 0; i < s->body_count && name == NULL; i++) {
        sn_vec3 t = frames[i].translation;
        if (!in_reach(t.x) || !in_reach(t.y) || !in_reach(t.z) || !in_reach(frames[i].rotation.w)) name = s->bodies[i].name;
    }
    if (name == NULL) return SN_OK;
    return a->columns != NULL ? fail_row(a->columns, row, error, what, name) : sn_fail(error, SN_ERROR_INPUT, what, name);
}

static sn_status fill_frames(animation *a, sn_clip *out, sn_error *error) {
    moment m = {0};
    for (sn_index frame = 0; frame < out->frame_count; frame++) {
        m = find_moment(a, frame, m.row);
        for (sn_index i = 0; i < out->coordinate_count; i++) {
            sn_status status = set_coordinate(a, i, m, error);
            if (status != SN_OK) return status;
        }
        sn_skeleton_couple(a->skeleton, a->values);
        sn_skeleton_frames(a->skeleton, a->values, a->frames);
        sn_status status = check_sizes(a, a->values, a->frames, m.row, error);
        if (status != SN_OK) return status;
        for (sn_index i = 0; i < out->coordinate_count; i++) out->coordinates[i].values[frame] = a->values[i];
        for (sn_index i = 0; i < out->joint_count; i++) out->joints[i].poses[frame] = away_from(a->at_rest[i], a->frames[i]);
    }
    if (a->clamped > 0)
        sn_log(SN_LOG_WARNING, "%s: %lld values of clamped coordinates are out of their range and are set to its end",
               a->columns != NULL ? a->columns->name : "the model", (long long)a->clamped);
    return SN_OK;
}

static sn_status prepare(animation *a, sn_error *error) {
    const sn_skeleton *s = a->skeleton;
    if (!(a->source = SN_NEW(sn_index, s->coordinate_count)) || !(a->rest = SN_NEW(double, s->coordinate_count)) ||
        !(a->values = SN_NEW(double, s->coordinate_count)) || !(a->at_rest = SN_NEW(sn_rigid, s->body_count)) ||
        !(a->frames = SN_NEW(sn_rigid, s->body_count)))
        return sn_fail_memory(error, "a motion");
    sn_skeleton_rest(s, a->rest);
    sn_skeleton_frames(s, a->rest, a->at_rest);
    sn_status status = check_sizes(a, a->rest, a->at_rest, -1, error);
    if (status == SN_OK) status = find_sources(a, error);
    if (status == SN_OK && a->columns != NULL) warn_of_locked(a);
    return status == SN_OK ? find_rate(a, error) : status;
}

sn_status sn_skeleton_animate(const sn_skeleton *skeleton, const sn_columns *columns, sn_clip *out, sn_error *error) {
    animation a = {.skeleton = skeleton, .columns = columns};
    *out = (sn_clip){0};
    sn_status status = prepare(&a, error);
    sn_index frames = columns != NULL ? columns->row_count : 1;
    if (status == SN_OK) status = sn_clip_create(frames, skeleton->body_count, skeleton->coordinate_count, out, error);
    if (status == SN_OK) status = set_names(&a, out, error);
    if (status == SN_OK) {
        out->rate = a.rate;
        status = fill_frames(&a, out, error);
    }
    if (status != SN_OK) sn_clip_free(out);
    free(a.source);
    free(a.rest);
    free(a.values);
    free(a.at_rest);
    free(a.frames);
    return status;
}
