/*
 * contact_step.c -- what a step does with contacts beside projecting them: where bones are, which rows may act, what passes by too far.
 *
 * A row is near where its point could reach the bone in the step (contact_near.c). Everything here depends on what a state keeps, so that
 * a run that goes on in the middle of a step finds the same rows.
 */
#include "contact.h"

#include <string.h>

/* Points move beside where they are looked for, by so many mean edges, or such a share of the muscle's diagonal: whichever is more. */
static const double SLACK_EDGES = 2.0, SLACK_SHARE = 0.025;
/* The last look: bones close to each other push a point to and fro. */
enum { LAST_SWEEPS = 4 };

/* ---- where the bones are ----------------------------------------------------------------------------------------------------------------
 */

/* How far margins have grown at a time of the scene's, in [0,1]. */
static double share_resolved(const sn_contacts *contacts, const sn_muscle_state *s, double time) {
    return fmin(fmax((time - s->inputs->resolve_begin) / contacts->resolve, 0.0), 1.0);
}

void sn_contacts_begin(const sn_model_muscle *m, sn_muscle_state *s) {
    s->inputs->resolve_begin = m->collider_count > 0 ? sn_contacts_of(m)->begin : 0.0;
}

void sn_contacts_aim(const sn_model_muscle *m, sn_muscle_state *s, const sn_scene *scene, const sn_surface_moment *at) {
    const sn_contacts *contacts = sn_contacts_of(m);
    for (sn_index c = 0; c < m->collider_count; c++) {
        sn_index joint = contacts->colliders[c].joint; /* patches have none, and no use for a pose */
        s->inputs->collider_poses[c] = joint == SN_NONE    ? sn_rigid_identity()
                                       : at->poses != NULL ? at->poses[joint]
                                                           : sn_motion_run_in_pose(&scene->motion, joint, at->time, at->share);
    }
    sn_patches_aim(m, s, scene, at);
    if (m->collider_count == 0 || !(contacts->resolve > 0.0)) return;
    s->inputs->resolved = share_resolved(contacts, s, at->time);
}

static void keep_poses(const sn_model_muscle *m, sn_muscle_state *s) {
    if (m->collider_count > 0)
        memcpy(s->inputs->collider_placed, s->inputs->collider_poses, (size_t)m->collider_count * sizeof *s->inputs->collider_placed);
    sn_patches_keep(m, s);
}

void sn_contacts_reset(const sn_model_muscle *m, sn_muscle_state *s) {
    s->inputs->near_count = 0;
    keep_poses(m, s);
    for (sn_index r = 0; m->quasi_newton && r < m->contact_count; r++) s->inputs->multipliers[r] = 0.0;
}

void sn_contacts_sleep(const sn_model_muscle *m, sn_muscle_state *s) { keep_poses(m, s); }

/* ---- the muscle as a whole
 * ---------------------------------------------------------------------------------------------------------------- */

/* before (point_count): the points before the step; targets: those of the attached ones after it, by sn_kinematics_target. */
static sn_contact_whole see_whole(const sn_model_muscle *m, const sn_muscle_state *s, const sn_vec3 *before) {
    sn_contact_whole w = {.box = SN_EMPTY_BOX, .reach = fmax(SLACK_EDGES * m->mean_edge, SLACK_SHARE * m->diagonal)};
    for (sn_index i = 0; i < m->vertex_count; i++) sn_box_add(&w.box, before != NULL ? before[i] : sn_point_position(&s->points[i]));
    sn_index k = 0;
    for (sn_index site = 0; site < m->site_count; site++)
        for (; k < m->sites[site].end; k++) {
            sn_index v = m->kinematic_points[k];
            sn_vec3 from = before != NULL ? before[v] : sn_point_position(&s->points[v]);
            w.way = sn_add_scaled(w.way, sn_sub(sn_kinematics_target(m, s, site, k), from), 1.0 / m->kinematic_count);
        }
    return w;
}

/* What it does in a step in which its points may fly; a back end that has put the weight into the velocities gives none. */
static sn_contact_whole see_flying(const sn_model_muscle *m, const sn_muscle_state *s, const sn_vec3 *before, double h, sn_vec3 gravity) {
    sn_contact_whole w = see_whole(m, s, before);
    double farthest = 0.0;
    w.h = h;
    w.pull = sn_scale(gravity, h * h);
    sn_vec3 beside = sn_sub(w.pull, w.way);
    for (sn_index i = 0; i < m->vertex_count; i++) farthest = fmax(farthest, sn_norm2(sn_add_scaled(beside, s->velocities[i], h)));
    w.flies = sqrt(farthest);
    return w;
}

/* before (point_count): the points before the step, NULL: the state's are. pull: what the weight adds to the way, m. */
static sn_contact_start start_of(const sn_contact_row *row, const sn_muscle_state *s, const sn_vec3 *before, const sn_contact_whole *w) {
    sn_vec3 from = before == NULL ? sn_contact_point(row, s->points) : sn_contact_mean(row, before);
    return (sn_contact_start){from, sn_add(from, w->way), sn_add_scaled(sn_add(from, w->pull), sn_contact_mean(row, s->velocities), w->h)};
}

/* ---- before a step
 * -------------------------------------------------------------------------------------------------------------------------- */

static bool any_comes_near(const sn_contacts *contacts, const sn_muscle_state *s, const sn_approach *a, const sn_contact_whole *w) {
    const sn_collider *collider = a->collider;
    double reach = contacts->margin + w->reach;
    if (!sn_approach_whole(a, w, contacts->margin)) return false;
    for (sn_index begin = collider->begin; begin < collider->end; begin += SN_CONTACT_BLOCK) {
        sn_contact_block b = sn_contact_block_at(contacts, collider, begin, s->points, NULL);
        double far = sn_approach_block(a, &b, w, reach);
        if (far >= b.radius) continue;
        for (sn_index r = b.begin; r < b.end; r++) {
            sn_contact_start at = start_of(&contacts->rows[r], s, NULL, w);
            if (sn_approach_may(a, &b, far, at.from) && sn_approach_row(a, r, &at, reach)) return true;
        }
    }
    return false;
}

static bool collider_moved(const sn_contacts *contacts, const sn_muscle_state *s, sn_index c) {
    const sn_patch *patch = contacts->colliders[c].patch;
    const sn_inputs *in = s->inputs;
    return patch != NULL ? sn_patch_moved(patch, s)
                         : memcmp(&in->collider_poses[c], &in->collider_placed[c], sizeof *in->collider_poses) != 0;
}

bool sn_contacts_moved(const sn_model_muscle *m, const sn_muscle_state *s, double since) {
    const sn_contacts *contacts = sn_contacts_of(m);
    if (m->collider_count == 0) return false;
    sn_contact_whole w = see_whole(m, s, NULL);
    for (sn_index c = 0; c < m->collider_count; c++) {
        if (!collider_moved(contacts, s, c)) continue;
        sn_approach a = sn_approach_of(m, s, c);
        if (any_comes_near(contacts, s, &a, &w)) return true;
    }
    return s->inputs->resolved > 0.0 && share_resolved(contacts, s, since) < 1.0;
}

static bool passes_too_far(const sn_contacts *contacts, const sn_muscle_state *s, const sn_approach *a, const sn_contact_whole *w) {
    const sn_collider *collider = a->collider;
    double margin = contacts->margin;
    if (sn_approach_is_slow(a, w) || !sn_approach_whole(a, w, margin)) return false;
    for (sn_index begin = collider->begin; begin < collider->end; begin += SN_CONTACT_BLOCK) {
        sn_contact_block b = sn_contact_block_at(contacts, collider, begin, s->points, NULL);
        double far = sn_approach_block(a, &b, w, margin);
        if (far >= b.radius) continue;
        for (sn_index r = b.begin; r < b.end; r++) {
            sn_contact_start at = start_of(&contacts->rows[r], s, NULL, w);
            if (!sn_approach_may(a, &b, far, at.from)) continue;
            if (sn_approach_passes(a, r, at.from, at.along, margin) || sn_approach_passes(a, r, at.from, at.flying, margin)) return true;
        }
    }
    return false;
}

bool sn_contacts_too_far(const sn_model_muscle *m, const sn_muscle_state *s, const sn_substep *substep) {
    const sn_contacts *contacts = sn_contacts_of(m);
    if (m->collider_count == 0 || contacts->by_voxels) return false; /* [K21] looks at the end of the step alone */
    sn_contact_whole w = see_flying(m, s, NULL, substep->h, substep->gravity);
    for (sn_index c = 0; c < m->collider_count; c++) {
        sn_approach a = sn_approach_of(m, s, c);
        if (passes_too_far(contacts, s, &a, &w)) return true;
    }
    return false;
}

/* Row r may act in the step, or it pushes no more. */
static void take_row(const sn_model_muscle *m, sn_muscle_state *s, sn_index r, bool near) {
    sn_inputs *in = s->inputs;
    if (near)
        in->near[in->near_count++] = r;
    else if (m->quasi_newton)
        in->multipliers[r] = 0.0;
}

static void gather_from(const sn_contacts *contacts, const sn_model_muscle *m, sn_muscle_state *s, sn_index c, const sn_contact_whole *w) {
    const sn_collider *collider = &contacts->colliders[c];
    sn_approach a = sn_approach_of(m, s, c);
    double reach = contacts->margin + w->reach;
    bool comes = sn_approach_whole(&a, w, contacts->margin);
    for (sn_index begin = collider->begin; begin < collider->end; begin += SN_CONTACT_BLOCK) {
        sn_contact_block b = sn_contact_block_at(contacts, collider, begin, s->points, s->previous);
        double far = comes ? sn_approach_block(&a, &b, w, reach) : INFINITY;
        for (sn_index r = b.begin; r < b.end; r++) {
            bool near = !(far >= b.radius);
            if (near) {
                sn_contact_start at = start_of(&contacts->rows[r], s, s->previous, w);
                near = sn_approach_may(&a, &b, far, at.from) && sn_approach_row(&a, r, &at, reach);
            }
            take_row(m, s, r, near);
        }
    }
}

void sn_contacts_gather(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep) {
    const sn_contacts *contacts = sn_contacts_of(m);
    s->inputs->near_count = 0;
    if (m->collider_count == 0) return;
    for (sn_index r = 0; contacts->by_voxels && r < m->contact_count; r++) s->inputs->near[s->inputs->near_count++] = r;
    if (contacts->by_voxels) return;
    sn_contact_whole w = see_flying(m, s, s->previous, substep->h, m->quasi_newton ? substep->gravity : sn_v3(0, 0, 0));
    for (sn_index c = 0; c < m->collider_count; c++) gather_from(contacts, m, s, c, &w);
}

/* ---- after a step
 * ----------------------------------------------------------------------------------------------------------------------------- */

/* Rows of one collider that are beyond their margin; false: there were none. */
static bool project_collider(const sn_model_muscle *m, sn_muscle_state *s, sn_index c, const sn_contact_whole *w) {
    const sn_contacts *contacts = sn_contacts_of(m);
    sn_approach a = sn_approach_of(m, s, c);
    bool moved = false;
    if (!sn_approach_whole(&a, w, contacts->margin)) return false;
    for (sn_index begin = a.collider->begin; begin < a.collider->end; begin += SN_CONTACT_BLOCK) {
        sn_contact_block b = sn_contact_block_at(contacts, a.collider, begin, s->points, NULL);
        double distance = sn_approach_distance(&a, &b);
        if (!sn_approach_block_is_near(&b, distance, contacts->margin)) continue;
        for (sn_index r = b.begin; r < b.end; r++) {
            sn_vec3 p = sn_contact_point(&contacts->rows[r], s->points);
            if (!sn_approach_row_is_near(&a, &b, distance, p, contacts->margin)) continue;
            sn_patch_find(a.collider, s, r, p);
            moved = sn_contact_project(m, s, a.collider, r, false) || moved;
        }
    }
    return moved;
}

void sn_contacts_finish(const sn_model_muscle *m, sn_muscle_state *s) {
    if (m->collider_count == 0) return;
    if (sn_contacts_of(m)->by_voxels) {
        sn_contact_voxels_finish(m, s);
        keep_poses(m, s);
        return;
    }
    sn_contact_whole w = see_whole(m, s, NULL);
    bool moved = true;
    for (int i = 0; i < LAST_SWEEPS && moved; i++) {
        moved = false;
        for (sn_index c = 0; c < m->collider_count; c++) moved = project_collider(m, s, c, &w) || moved;
    }
    keep_poses(m, s);
}
