/*
 * contact_surface.c -- surfaces that change their shape, as a muscle meets them in a step: where the vertices of its patches are, and how
 * far its points are from them.   bodies.md 2
 *
 * Before the iterations of a step and after them the nearest point is looked for on all of the patch; in them it is walked to from there,
 * so that energy and force are functions of the points alone.
 */
#include "contact.h"

#include <string.h>

static const sn_patch *next_patch(const sn_model_muscle *m, sn_index *c) {
    const sn_contacts *contacts = sn_contacts_of(m);
    while (*c < m->collider_count && contacts->colliders[*c].patch == NULL) ++*c;
    return *c < m->collider_count ? contacts->colliders[(*c)++].patch : NULL;
}

void sn_patches_fit(const sn_model_muscle *m, sn_muscle_state *s) {
    sn_inputs *in = s->inputs;
    sn_index c = 0;
    for (const sn_patch *p; m->patch_points > 0 && (p = next_patch(m, &c)) != NULL;) {
        sn_moving_fit(&p->moving, in->patches + p->first_point, in->patch_boxes + p->first_box);
        sn_moving_fit(&p->moving, in->patches_placed + p->first_point, in->patch_boxes_placed + p->first_box);
    }
}

void sn_patches_aim(const sn_model_muscle *m, sn_muscle_state *s, const sn_scene *scene, const sn_surface_moment *at) {
    if (m->patch_points == 0) return;
    sn_surface_moment all = sn_kinematics_moment(s, scene, at);
    sn_index c = 0;
    for (const sn_patch *p; (p = next_patch(m, &c)) != NULL;)
        for (sn_index v = 0; v < p->moving.vertex_count; v++)
            s->inputs->patches[p->first_point + v] = sn_scene_surface_vertex(p->surface, &all, p->vertices[v]);
    sn_patches_fit(m, s);
}

void sn_patches_keep(const sn_model_muscle *m, sn_muscle_state *s) {
    sn_inputs *in = s->inputs;
    if (m->patch_points == 0) return;
    memcpy(in->patches_placed, in->patches, (size_t)m->patch_points * sizeof *in->patches);
    memcpy(in->patch_boxes_placed, in->patch_boxes, (size_t)m->patch_boxes * sizeof *in->patch_boxes);
}

sn_moving_shape sn_patch_shape(const sn_patch *patch, const sn_muscle_state *s) {
    return (sn_moving_shape){&patch->moving, s->inputs->patches + patch->first_point, s->inputs->patch_boxes + patch->first_box};
}

sn_moving_shape sn_patch_shape_before(const sn_patch *patch, const sn_muscle_state *s) {
    return (sn_moving_shape){&patch->moving, s->inputs->patches_placed + patch->first_point,
                             s->inputs->patch_boxes_placed + patch->first_box};
}

bool sn_patch_moved(const sn_patch *patch, const sn_muscle_state *s) {
    sn_moving_shape is = sn_patch_shape(patch, s), was = sn_patch_shape_before(patch, s);
    return memcmp(is.positions, was.positions, (size_t)patch->moving.vertex_count * sizeof *is.positions) != 0;
}

/* Of row r. */
static sn_index *foot_of(const sn_collider *collider, const sn_muscle_state *s, sn_index r) {
    return &s->inputs->feet[collider->patch->first_foot + r - collider->begin];
}

void sn_patch_find(const sn_collider *collider, const sn_muscle_state *s, sn_index r, sn_vec3 p) {
    if (collider->patch == NULL) return;
    sn_moving_shape shape = sn_patch_shape(collider->patch, s);
    sn_index *foot = foot_of(collider, s, r);
    *foot = sn_moving_closest(&shape, *foot, p).triangle;
}

double sn_patch_distance(const sn_collider *collider, const sn_muscle_state *s, sn_index r, sn_vec3 p, sn_vec3 *gradient) {
    sn_moving_shape shape = sn_patch_shape(collider->patch, s);
    sn_closest nearest = sn_moving_walk(&shape, *foot_of(collider, s, r), p);
    return sn_moving_side(&shape, &nearest, p, gradient);
}

double sn_patch_distance_exact(const sn_collider *collider, const sn_muscle_state *s, sn_index r, sn_vec3 p) {
    sn_moving_shape shape = sn_patch_shape(collider->patch, s);
    sn_closest nearest = sn_moving_closest(&shape, *foot_of(collider, s, r), p);
    return sn_moving_side(&shape, &nearest, p, NULL);
}

sn_vec3 sn_patch_way(const sn_collider *collider, const sn_muscle_state *s, sn_index r, sn_vec3 p) {
    sn_moving_shape is = sn_patch_shape(collider->patch, s), was = sn_patch_shape_before(collider->patch, s);
    sn_closest nearest = sn_moving_walk(&is, *foot_of(collider, s, r), p);
    return sn_sub(nearest.point, sn_moving_point(&was, &nearest));
}
