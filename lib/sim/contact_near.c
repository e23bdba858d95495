/*
 * contact_near.c -- what may come near a bone or a surface in a step, and what passes by too far.
 *
 * Both ends of the step are looked at, once with the muscle's mean motion and once where a point's own velocity takes it. In the frame of a
 * bone phi changes no faster than a point moves, so that along the way phi is at least its mean at the ends less half of the way. Of a
 * surface that changes its shape the way is the one beside the nearest points before and after: what is between them is taken to move
 * alike; a row that is overlooked so is still put out at the end of the step.
 */
#include "contact.h"

#include <math.h>

sn_approach sn_approach_of(const sn_model_muscle *m, const sn_muscle_state *s, sn_index c) {
    sn_approach a = {.collider = &sn_contacts_of(m)->colliders[c]};
    const sn_patch *patch = a.collider->patch;
    if (patch != NULL) {
        a.was = sn_patch_shape_before(patch, s);
        a.is = sn_patch_shape(patch, s);
        a.feet = s->inputs->feet + patch->first_foot;
        return a;
    }
    a.before = sn_rigid_inverse(s->inputs->collider_placed[c]);
    a.after = sn_rigid_inverse(s->inputs->collider_poses[c]);
    sn_quat by = sn_rigid_compose(a.after, sn_rigid_inverse(a.before)).rotation;
    a.turn = 2.0 * sn_norm(sn_v3(by.x, by.y, by.z));
    return a;
}

/* ---- bones ------------------------------------------------------------------------------------------------------------------------- */

/* Is phi sure to stay above `reach` on a point's way from `from` before the step to `to` after it? phi: at `from`, in the bone's frame at
 * p. */
static bool bone_passes_by(const sn_approach *a, sn_vec3 p, double phi, sn_vec3 to, double reach) {
    sn_vec3 q = sn_rigid_apply(a->after, to);
    double way = sn_distance(p, q);
    return phi - way >= reach || phi + sn_distance_field_at(a->collider->field, q, NULL) - way >= 2.0 * reach;
}

static bool row_nears_bone(const sn_approach *a, const sn_contact_start *at, double reach) {
    sn_vec3 p = sn_rigid_apply(a->before, at->from);
    double phi = sn_distance_field_at(a->collider->field, p, NULL);
    return !bone_passes_by(a, p, phi, at->along, reach) || !bone_passes_by(a, p, phi, at->flying, reach);
}

/* Phi at each point of the block is at most the radius from that at the middle, and a turn carries them by so much more. */
static bool block_nears_bone(const sn_approach *a, const sn_contact_block *b, const sn_contact_whole *w, double reach) {
    const sn_distance_field *field = a->collider->field;
    sn_vec3 p = sn_rigid_apply(a->before, b->middle), q = sn_rigid_apply(a->after, sn_add(b->middle, w->way));
    double phi = 0.5 * (sn_distance_field_at(field, p, NULL) + sn_distance_field_at(field, q, NULL));
    return !(phi - 0.5 * (sn_distance(p, q) + b->radius * a->turn) - b->radius - w->flies >= reach); /* what is not finite is looked at */
}

static bool bone_passes(const sn_approach *a, sn_vec3 from, sn_vec3 to, double margin) {
    sn_vec3 p = sn_rigid_apply(a->before, from);
    if (sn_distance(p, sn_rigid_apply(a->after, to)) <= a->collider->limit) return false;
    return !bone_passes_by(a, p, sn_distance_field_at(a->collider->field, p, NULL), to, margin);
}

/* ---- patches ----------------------------------------------------------------------------------------------------------------------- */

/* A point and the nearest one of a patch, before a step and after it. */
typedef struct sighting {
    double before, after; /* signed distances */
    double way;           /* of the point beside the surface, m */
} sighting;

static sighting sight(const sn_approach *a, sn_index hint, sn_vec3 from, sn_vec3 to) {
    sn_closest was = sn_moving_closest(&a->was, hint, from), is = sn_moving_closest(&a->is, was.triangle, to);
    sn_vec3 way = sn_sub(to, from);
    double first = sn_distance(way, sn_sub(sn_moving_point(&a->is, &was), was.point)),
           last = sn_distance(way, sn_sub(is.point, sn_moving_point(&a->was, &is)));
    return (sighting){sn_moving_side(&a->was, &was, from, NULL), sn_moving_side(&a->is, &is, to, NULL), fmax(first, last)};
}

static bool patch_passes_by(const sighting *s, double reach) {
    return s->before - s->way >= reach || s->before + s->after - s->way >= 2.0 * reach;
}

static bool row_nears_patch(const sn_approach *a, sn_index r, const sn_contact_start *at, double reach) {
    sn_index *hint = &a->feet[r - a->collider->begin];
    sighting along = sight(a, *hint, at->from, at->along), flying = sight(a, *hint, at->from, at->flying);
    return !patch_passes_by(&along, reach) || !patch_passes_by(&flying, reach);
}

static bool block_nears_patch(const sn_approach *a, const sn_contact_block *b, const sn_contact_whole *w, double reach) {
    sighting s = sight(a, a->feet[b->begin - a->collider->begin], b->middle, sn_add(b->middle, w->way));
    return !(0.5 * (s.before + s.after - s.way) - b->radius - w->flies >= reach);
}

static bool patch_passes(const sn_approach *a, sn_index r, sn_vec3 from, sn_vec3 to, double margin) {
    sighting s = sight(a, a->feet[r - a->collider->begin], from, to);
    return s.way > a->collider->limit && !patch_passes_by(&s, margin);
}

/* ---- either ------------------------------------------------------------------------------------------------------------------------ */

/* How far from a box a point is. */
static double distance_from(const sn_box *box, sn_vec3 p) {
    return sn_norm(sn_max3(sn_max3(sn_sub(box->low, p), sn_sub(p, box->high)), sn_v3(0, 0, 0)));
}

static sn_vec3 middle_of(const sn_box *box) { return sn_scale(sn_add(box->low, box->high), 0.5); }

bool sn_approach_whole(const sn_approach *a, const sn_contact_whole *w, double margin) {
    sn_vec3 middle = middle_of(&w->box), to = sn_add(middle, w->way);
    double radius = 0.5 * sn_box_diagonal(w->box), nearest, way;
    if (a->collider->patch != NULL) { /* its whole box is the first of the tree */
        const sn_box *was = &a->was.boxes[1], *is = &a->is.boxes[1];
        nearest = fmin(distance_from(was, middle), distance_from(is, to));
        way = sn_distance(w->way, sn_sub(middle_of(is), middle_of(was)));
    } else {
        sn_vec3 before = sn_rigid_apply(a->before, middle), after = sn_rigid_apply(a->after, to);
        nearest = fmin(distance_from(&a->collider->field->box, before), distance_from(&a->collider->field->box, after));
        way = sn_distance(before, after);
    }
    double turn = radius * a->turn; /* at the ball's rim */
    return nearest <= radius + margin + w->reach + w->flies + way + turn;
}

bool sn_approach_block(const sn_approach *a, const sn_contact_block *b, const sn_contact_whole *w, double reach) {
    return a->collider->patch != NULL ? block_nears_patch(a, b, w, reach) : block_nears_bone(a, b, w, reach);
}

bool sn_approach_row(const sn_approach *a, sn_index r, const sn_contact_start *at, double reach) {
    return a->collider->patch != NULL ? row_nears_patch(a, r, at, reach) : row_nears_bone(a, at, reach);
}

bool sn_approach_passes(const sn_approach *a, sn_index r, sn_vec3 from, sn_vec3 to, double margin) {
    return a->collider->patch != NULL ? patch_passes(a, r, from, to, margin) : bone_passes(a, from, to, margin);
}

bool sn_approach_is_near(const sn_approach *a, const sn_contact_block *b, double reach) {
    double phi;
    if (a->collider->patch != NULL) {
        sn_closest foot = sn_moving_closest(&a->is, a->feet[b->begin - a->collider->begin], b->middle);
        phi = sn_moving_side(&a->is, &foot, b->middle, NULL);
    } else
        phi = sn_distance_field_at(a->collider->field, sn_rigid_apply(a->after, b->middle), NULL);
    return !(phi - b->radius >= reach); /* what is not finite is looked at */
}
