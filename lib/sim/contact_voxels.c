/*
 * contact_voxels.c -- the collision of [K21] 3.2: each bone as voxels in its own frame, and two rules for a vertex whose cell is one of
 * them.
 *
 * x is where the vertex was when the step began, p where it is; both are looked at in the frame of the bone at the end of the step.
 *   x outside:  the vertex has moved into the bone. p goes back along the segment to x, to the first cell that is outside; to x, where it
 * is that of x. x inside:   the bone has moved onto the vertex. p = x carried by the bone's motion in the step (`follow`); the same, and
 * its velocity is 0
 *               (`stop`: 5); nothing (`ignore`: fig. 10).
 * Only p's own cell is asked: a bone thinner than a vertex's way is passed through, as in the paper. Of two bones that hold a vertex, the
 * later one in the scene has the last word: it sees what the one before has made of p. Every vertex that no bone carries is asked about
 * every bone, around attachments too. Which vertices are held is told by positions and poses alone, and so there is nothing to be kept.
 */
#include "contact.h"

#include <string.h>

/* Points in single precision are as near to where they were put as this share of the muscle's diagonal. */
static const double ROUNDING = 1e-6;

sn_status sn_contact_voxels_make(const sn_scene *scene, const sn_mesh *mesh, sn_voxels *out, sn_error *error) {
    const sn_contact_settings *contact = &scene->contact;
    sn_index size[3];
    if (contact->voxels_total > 0)
        sn_voxels_in_all(sn_mesh_box(mesh), contact->voxels_total, size);
    else
        sn_voxels_along(sn_mesh_box(mesh), contact->voxels > 0 ? contact->voxels : SN_DEFAULT_VOXELS, size);
    sn_status status = sn_voxels_create(mesh, size, out, error);
    return status == SN_OK ? sn_voxels_fill(out, error) : status;
}

/* A bone in a step. */
typedef struct bone_step {
    const sn_voxels *voxels;
    sn_rigid pose, inverse; /* at its end */
    sn_rigid motion;        /* in it; exactly none where it stands still */
} bone_step;

static bone_step bone_step_of(const sn_inputs *in, const sn_collider *collider, sn_index c) {
    const sn_rigid *placed = &in->collider_placed[c];
    bone_step b = {.voxels = collider->voxels, .pose = in->collider_poses[c], .motion = sn_rigid_identity()};
    b.inverse = sn_rigid_inverse(b.pose);
    if (memcmp(placed, &in->collider_poses[c], sizeof *placed) != 0) b.motion = sn_rigid_compose(b.pose, sn_rigid_inverse(*placed));
    return b;
}

/* Where the rules put a vertex. */
static sn_vec3 put(const bone_step *b, sn_bone_hits hits, sn_vec3 before, sn_vec3 now) {
    sn_vec3 at = sn_rigid_apply(b->inverse, now), from, out;
    if (!sn_voxels_at(b->voxels, at)) return now;
    from = sn_rigid_apply(b->inverse, before);
    if (!sn_voxels_at(b->voxels, from)) return sn_voxels_walk(b->voxels, at, from, &out) ? sn_rigid_apply(b->pose, out) : before;
    return hits == SN_BONE_HITS_IGNORE ? now : sn_rigid_apply(b->motion, before);
}

void sn_contact_voxels_sweep(const sn_model_muscle *m, sn_muscle_state *s) {
    const sn_contacts *contacts = sn_contacts_of(m);
    for (sn_index c = 0; c < m->collider_count; c++) {
        const sn_collider *collider = &contacts->colliders[c];
        const bone_step b = bone_step_of(s->inputs, collider, c);
        for (sn_index r = collider->begin; r < collider->end; r++) {
            sn_index v = contacts->rows[r].point[0];
            sn_point *p = &s->points[v];
            sn_vec3 to = put(&b, contacts->bone_hits, s->previous[v], sn_point_position(p));
            p->x = to.x, p->y = to.y, p->z = to.z;
        }
    }
}

/* Has the bone moved onto the vertex, and carried it to where it is now? */
static bool is_carried(const bone_step *b, sn_vec3 before, sn_vec3 now, double within) {
    return sn_voxels_at(b->voxels, sn_rigid_apply(b->inverse, before)) && sn_distance(sn_rigid_apply(b->motion, before), now) <= within;
}

/* A vertex that ends where its step began has no velocity. */
void sn_contact_voxels_finish(const sn_model_muscle *m, sn_muscle_state *s) {
    const sn_contacts *contacts = sn_contacts_of(m);
    for (sn_index c = 0; contacts->bone_hits == SN_BONE_HITS_STOP && c < m->collider_count; c++) {
        const sn_collider *collider = &contacts->colliders[c];
        const bone_step b = bone_step_of(s->inputs, collider, c);
        for (sn_index r = collider->begin; r < collider->end; r++) {
            sn_index v = contacts->rows[r].point[0];
            sn_vec3 now = sn_point_position(&s->points[v]);
            if (is_carried(&b, s->previous[v], now, ROUNDING * m->diagonal)) s->previous[v] = now;
        }
    }
}

bool sn_contact_voxels_touch(const sn_collider *collider, const sn_rigid *pose, sn_vec3 at) {
    return sn_voxels_touch(collider->voxels, sn_rigid_apply(sn_rigid_inverse(*pose), at));
}
