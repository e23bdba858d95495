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

/* A turn carries the points of a block by so much more than its middle. */
static double block_to_bone(const sn_approach *a, const sn_contact_block *b, const sn_contact_whole *w) {
    const sn_distance_field *field = a->collider->field;
    sn_vec3 p = sn_rigid_apply(a->before, b->middle), q = sn_rigid_apply(a->after, sn_add(b->middle, w->way));
    double phi = 0.5 * (sn_distance_field_at(field, p, NULL) + sn_distance_field_at(field, q, NULL));
    return phi - 0.5 * (sn_distance(p, q) + b->radius * a->turn) - w->flies;
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

/* was and is: the nearest points to `from` before the step and to `to` after it. */
static sighting sight(const sn_approach *a, const sn_closest *was, const sn_closest *is, sn_vec3 from, sn_vec3 to) {
    sn_vec3 way = sn_sub(to, from);
    double first = sn_distance(way, sn_sub(sn_moving_point(&a->is, was), was->point)),
           last = sn_distance(way, sn_sub(is->point, sn_moving_point(&a->was, is)));
    return (sighting){sn_moving_side(&a->was, was, from, NULL), sn_moving_side(&a->is, is, to, NULL), fmax(first, last)};
}

static bool patch_passes_by(const sighting *s, double reach) {
    return s->before - s->way >= reach || s->before + s->after - s->way >= 2.0 * reach;
}

static bool row_nears_patch(const sn_approach *a, sn_index r, const sn_contact_start *at, double reach) {
    sn_index *foot = &a->feet[r - a->collider->begin];
    sn_closest is = sn_moving_closest(&a->is, *foot, at->along), was = sn_moving_walk(&a->was, is.triangle, at->from),
               then = sn_moving_walk(&a->is, is.triangle, at->flying);
    sighting along = sight(a, &was, &is, at->from, at->along), flying = sight(a, &was, &then, at->from, at->flying);
    *foot = is.triangle;
    return !patch_passes_by(&along, reach) || !patch_passes_by(&flying, reach);
}

static double block_to_patch(const sn_approach *a, const sn_contact_block *b, const sn_contact_whole *w) {
    sn_vec3 to = sn_add(b->middle, w->way);
    sn_closest is = sn_moving_closest(&a->is, a->feet[b->begin - a->collider->begin], to),
               was = sn_moving_closest(&a->was, is.triangle, b->middle);
    sighting s = sight(a, &was, &is, b->middle, to);
    return 0.5 * (s.before + s.after - s.way) - w->flies;
}

static bool patch_passes(const sn_approach *a, sn_index r, sn_vec3 from, sn_vec3 to, double margin) {
    sn_closest was = sn_moving_closest(&a->was, a->feet[r - a->collider->begin], from), is = sn_moving_closest(&a->is, was.triangle, to);
    sighting s = sight(a, &was, &is, from, to);
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

double sn_approach_block(const sn_approach *a, const sn_contact_block *b, const sn_contact_whole *w, double reach) {
    return (a->collider->patch != NULL ? block_to_patch(a, b, w) : block_to_bone(a, b, w)) - reach;
}

bool sn_approach_may(const sn_approach *a, const sn_contact_block *b, double far, sn_vec3 from) {
    return a->collider->patch == NULL || !(far >= sn_distance(from, b->middle));
}

bool sn_approach_row(const sn_approach *a, sn_index r, const sn_contact_start *at, double reach) {
    return a->collider->patch != NULL ? row_nears_patch(a, r, at, reach) : row_nears_bone(a, at, reach);
}

bool sn_approach_passes(const sn_approach *a, sn_index r, sn_vec3 from, sn_vec3 to, double margin) {
    return a->collider->patch != NULL ? patch_passes(a, r, from, to, margin) : bone_passes(a, from, to, margin);
}

/* The farthest way, in the step, of a point of the muscle's ball beside a bone, or beside any vertex of a patch. */
static double most_way(const sn_approach *a, const sn_contact_whole *w) {
    const sn_patch *patch = a->collider->patch;
    double most = 0.0;
    if (patch == NULL) {
        sn_vec3 middle = middle_of(&w->box);
        double way = sn_distance(sn_rigid_apply(a->before, middle), sn_rigid_apply(a->after, sn_add(middle, w->way)));
        return way + 0.5 * sn_box_diagonal(w->box) * a->turn + w->flies;
    }
    for (sn_index v = 0; v < patch->moving.vertex_count; v++)
        most = fmax(most, sn_norm2(sn_sub(sn_sub(a->is.positions[v], a->was.positions[v]), w->way)));
    return sqrt(most) + w->flies;
}

bool sn_approach_is_slow(const sn_approach *a, const sn_contact_whole *w) {
    static const double rounding = 1.0 + 1e-9;
    return rounding * most_way(a, w) < a->collider->limit;
}

double sn_approach_distance(const sn_approach *a, const sn_contact_block *b) {
    if (a->collider->patch == NULL) return sn_distance_field_at(a->collider->field, sn_rigid_apply(a->after, b->middle), NULL);
    sn_closest foot = sn_moving_closest(&a->is, a->feet[b->begin - a->collider->begin], b->middle);
    return sn_moving_side(&a->is, &foot, b->middle, NULL);
}

bool sn_approach_block_is_near(const sn_contact_block *b, double distance, double reach) {
    return !(distance - b->radius >= reach); /* what is not finite is looked at */
}

bool sn_approach_row_is_near(const sn_approach *a, const sn_contact_block *b, double distance, sn_vec3 p, double reach) {
    return a->collider->patch == NULL || !(distance - sn_distance(p, b->middle) >= reach);
}
