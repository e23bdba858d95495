/*
 * fit_align.c -- joints of a source, and turning its rest pose onto that of a body.
 */
#include "fit_align.h"

#include <math.h>
#include <string.h>

/* ---- joints of the source ------------------------------------------------------------------------------------------------------------ */

static sn_index find_joint(const sn_clip *source, const char *name, size_t length) {
    for (sn_index j = 0; j < source->joint_count; j++)
        if (strncmp(source->joints[j].name, name, length) == 0 && source->joints[j].name[length] == '\0') return j;
    return SN_NONE;
}

sn_index sn_fit_find_source(const sn_clip *source, const char *names, bool *end) {
    *end = false;
    while (names != NULL) {
        const char *bar = strchr(names, '|');
        size_t length = bar != NULL ? (size_t)(bar - names) : strlen(names);
        sn_index found = find_joint(source, names, length);
        if (found != SN_NONE) return found;
        if (length > 4 && strncmp(names + length - 4, ".end", 4) == 0) found = find_joint(source, names, length - 4);
        if (found != SN_NONE && source->joints[found].has_end) {
            *end = true;
            return found;
        }
        names = bar != NULL ? bar + 1 : NULL;
    }
    return SN_NONE;
}

/* Directions shorter than this have none, metres; and so have cosines of two that are almost opposite. */
static const double SHORTEST = 1e-6, OPPOSITE = 1e-6;

sn_quat sn_fit_least_turn(sn_vec3 from, sn_vec3 to) {
    double w = 1.0 + sn_dot(from, to);
    if (w < OPPOSITE) { /* half a turn about any axis across */
        sn_vec3 across = fabs(from.x) < 0.6 ? sn_v3(1, 0, 0) : sn_v3(0, 1, 0);
        sn_vec3 axis = sn_normalize(sn_cross(from, across));
        return (sn_quat){0, axis.x, axis.y, axis.z};
    }
    sn_vec3 axis = sn_cross(from, to);
    return sn_quat_normalize((sn_quat){w, axis.x, axis.y, axis.z});
}

/* The joint that is aligned. */
typedef struct subject {
    const sn_fit_body *body;
    const sn_clip *source;
    sn_index joint;
} subject;

typedef struct place_pair {
    sn_vec3 body, source; /* unit directions */
} place_pair;

static sn_vec3 source_place(const sn_clip *source, const sn_fit_point *point) {
    bool end;
    sn_index j = sn_fit_find_source(source, point->source, &end);
    return end ? source->joints[j].end : source->joints[j].rest;
}

static sn_vec3 without(sn_vec3 v, sn_vec3 axis) { return sn_add_scaled(v, axis, -sn_dot(v, axis)); }

/* The direction on the body and in the source, what lies along their axes taken out (zero vectors: nothing is). */
static sn_status find_pair(const subject *s, const sn_fit_direction *d, const place_pair *axes, place_pair *out, sn_error *error) {
    const sn_fit_table *table = s->body->table;
    sn_index joint = s->joint;
    const sn_fit_point *from = &table->points[d->from], *to = &table->points[d->to];
    sn_vec3 on_body = without(sn_sub(s->body->places[d->to].centre, s->body->places[d->from].centre), axes->body);
    sn_vec3 in_source = without(sn_sub(source_place(s->source, to), source_place(s->source, from)), axes->source);
    bool short_body = !(sn_norm(on_body) > SHORTEST);
    if (short_body || !(sn_norm(in_source) > SHORTEST))
        return sn_fail_at(error, SN_ERROR_INPUT, table->name, table->points[joint].line,
                          "joint \"%s\": the direction from \"%s\" to \"%s\" has no length %s", table->points[joint].name, from->name,
                          to->name, short_body ? "on the body" : "in the source's rest pose");
    *out = (place_pair){sn_normalize(on_body), sn_normalize(in_source)};
    return SN_OK;
}

/* A turn about a unit axis that takes one direction across it to another. */
static sn_quat turn_about(sn_vec3 axis, sn_vec3 from, sn_vec3 to) {
    return sn_quat_axis_angle(axis, sn_atan2(sn_dot(axis, sn_cross(from, to)), sn_dot(from, to)));
}

/* What the parent's alignment has made upright stays so; headings agree. */
static sn_status align_heading(const subject *s, sn_quat parent, sn_quat *out, sn_error *error) {
    const sn_vec3 up = {0, 0, 1};
    const place_pair axes = {up, sn_quat_rotate(sn_quat_conjugate(parent), up)};
    place_pair heading;
    sn_status status = find_pair(s, &s->body->table->joints[s->joint].along, &axes, &heading, error);
    if (status == SN_OK)
        *out = sn_quat_normalize(sn_quat_multiply(turn_about(up, sn_quat_rotate(parent, heading.source), heading.body), parent));
    return status;
}

sn_status sn_fit_align_joint(const sn_fit_body *body, const sn_clip *source, sn_index joint, sn_quat parent, sn_quat *out,
                             sn_error *error) {
    const sn_fit_joint *j = &body->table->joints[joint];
    const subject s = {body, source, joint};
    place_pair along, aside;
    *out = parent;
    if (j->inherits) return SN_OK;
    if (j->along.level) return align_heading(&s, parent, out, error);
    const place_pair none = {{0, 0, 0}, {0, 0, 0}};
    sn_status status = find_pair(&s, &j->along, &none, &along, error);
    if (status != SN_OK) return status;
    *out = sn_quat_normalize(sn_quat_multiply(sn_fit_least_turn(sn_quat_rotate(parent, along.source), along.body), parent));
    if (!j->aside.given) return SN_OK;
    status = find_pair(&s, &j->aside, &along, &aside, error);
    if (status != SN_OK) return status;
    sn_quat turn = turn_about(along.body, sn_quat_rotate(*out, aside.source), aside.body);
    *out = sn_quat_normalize(sn_quat_multiply(turn, *out));
    return SN_OK;
}
