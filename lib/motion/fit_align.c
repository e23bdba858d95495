/*
 * fit_align.c -- turning the rest pose of a source onto that of a body.
 */
#include "fit_align.h"

#include <math.h>

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
static sn_status find_pair(const sn_fit_body *body, const sn_clip *source, const sn_fit_direction *d, sn_index joint,
                           const place_pair *axes, place_pair *out, sn_error *error) {
    const sn_fit_table *table = body->table;
    const sn_fit_point *from = &table->points[d->from], *to = &table->points[d->to];
    sn_vec3 on_body = without(sn_sub(body->places[d->to].centre, body->places[d->from].centre), axes->body);
    sn_vec3 in_source = without(sn_sub(source_place(source, to), source_place(source, from)), axes->source);
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
static sn_status align_heading(const sn_fit_body *body, const sn_clip *source, sn_index joint, sn_quat parent, sn_quat *out,
                               sn_error *error) {
    const sn_vec3 up = {0, 0, 1};
    const place_pair axes = {up, sn_quat_rotate(sn_quat_conjugate(parent), up)};
    place_pair heading;
    sn_status status = find_pair(body, source, &body->table->joints[joint].along, joint, &axes, &heading, error);
    if (status == SN_OK)
        *out = sn_quat_normalize(sn_quat_multiply(turn_about(up, sn_quat_rotate(parent, heading.source), heading.body), parent));
    return status;
}

sn_status sn_fit_align_joint(const sn_fit_body *body, const sn_clip *source, sn_index joint, sn_quat parent, sn_quat *out,
                             sn_error *error) {
    const sn_fit_joint *j = &body->table->joints[joint];
    place_pair along, aside;
    *out = parent;
    if (j->inherits) return SN_OK;
    if (j->along.level) return align_heading(body, source, joint, parent, out, error);
    const place_pair none = {{0, 0, 0}, {0, 0, 0}};
    sn_status status = find_pair(body, source, &j->along, joint, &none, &along, error);
    if (status != SN_OK) return status;
    *out = sn_quat_normalize(sn_quat_multiply(sn_fit_least_turn(sn_quat_rotate(parent, along.source), along.body), parent));
    if (!j->aside.given) return SN_OK;
    status = find_pair(body, source, &j->aside, joint, &along, &aside, error);
    if (status != SN_OK) return status;
    sn_quat turn = turn_about(along.body, sn_quat_rotate(*out, aside.source), aside.body);
    *out = sn_quat_normalize(sn_quat_multiply(turn, *out));
    return SN_OK;
}
