/*
 * contact_step.c -- what a step does with contacts beside projecting them: where bones are, which rows may act, what passes by too far.
 *
 * A row is near where its point could reach the bone in the step. Both are looked at in the bone's frame, before the step and after it,
 * once with the muscle's mean motion and once where the point's own velocity takes it: phi changes no faster than a point moves, so that
 * along the way between the two phi is at least their mean less half of the way. Everything here depends on what a state keeps, so that a
 * run that goes on in the middle of a step finds the same rows.
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
static double share_resolved(const sn_contacts *contacts, double time) {
    return fmin(fmax((time - contacts->begin) / contacts->resolve, 0.0), 1.0);
}

void sn_contacts_aim(const sn_model_muscle *m, sn_muscle_state *s, const sn_scene *scene, const sn_surface_moment *at) {
    const sn_contacts *contacts = sn_contacts_of(m);
    for (sn_index c = 0; c < m->collider_count; c++) {
        sn_index joint = contacts->colliders[c].joint;
        s->inputs->collider_poses[c] = joint == SN_NONE    ? sn_rigid_identity()
                                       : at->poses != NULL ? at->poses[joint]
                                                           : sn_motion_run_in_pose(&scene->motion, joint, at->time, at->share);
    }
    if (m->collider_count == 0 || !(contacts->resolve > 0.0)) return;
    s->inputs->resolved = share_resolved(contacts, at->time);
}

static void keep_poses(const sn_model_muscle *m, sn_muscle_state *s) {
    if (m->collider_count > 0)
        memcpy(s->inputs->collider_placed, s->inputs->collider_poses, (size_t)m->collider_count * sizeof *s->inputs->collider_placed);
}

void sn_contacts_reset(const sn_model_muscle *m, sn_muscle_state *s) {
    s->inputs->near_count = 0;
    keep_poses(m, s);
    for (sn_index r = 0; m->quasi_newton && r < m->contact_count; r++) s->inputs->multipliers[r] = 0.0;
}

void sn_contacts_sleep(const sn_model_muscle *m, sn_muscle_state *s) { keep_poses(m, s); }

/* ---- the muscle as a whole
 * ---------------------------------------------------------------------------------------------------------------- */

typedef struct whole {
    sn_box box;   /* of its points before the step */
    sn_vec3 way;  /* mean way of its attached points in the step */
    double reach; /* how far beside that way a point may come, m */
    sn_vec3 pull; /* what the weight adds to the way of a point that flies, m */
    double h;     /* s */
    double flies; /* how far beside the mean way a point comes that does, at most, m */
} whole;

static void extend(sn_box *box, sn_vec3 p) {
    box->low = sn_min3(box->low, p);
    box->high = sn_max3(box->high, p);
}

/* before (point_count): the points before the step; targets: those of the attached ones after it, by sn_kinematics_target. */
static whole see_whole(const sn_model_muscle *m, const sn_muscle_state *s, const sn_vec3 *before) {
    whole w = {.box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}},
               .reach = fmax(SLACK_EDGES * m->mean_edge, SLACK_SHARE * m->diagonal)};
    for (sn_index i = 0; i < m->vertex_count; i++) extend(&w.box, before != NULL ? before[i] : sn_point_position(&s->points[i]));
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
static whole see_flying(const sn_model_muscle *m, const sn_muscle_state *s, const sn_vec3 *before, double h, sn_vec3 gravity) {
    whole w = see_whole(m, s, before);
    double farthest = 0.0;
    w.h = h;
    w.pull = sn_scale(gravity, h * h);
    sn_vec3 beside = sn_sub(w.pull, w.way);
    for (sn_index i = 0; i < m->vertex_count; i++) farthest = fmax(farthest, sn_norm2(sn_add_scaled(beside, s->velocities[i], h)));
    w.flies = sqrt(farthest);
    return w;
}

/* A collider's poses the other way, before the step and after it: from the world into its frame. */
typedef struct frames {
    sn_rigid before, after;
    double turn; /* how far the step's turn carries a point that is 1 m off its axis, m */
} frames;

static frames frames_of(const sn_muscle_state *s, sn_index c) {
    frames f = {.before = sn_rigid_inverse(s->inputs->collider_placed[c]), .after = sn_rigid_inverse(s->inputs->collider_poses[c])};
    sn_quat by = sn_rigid_compose(f.after, sn_rigid_inverse(f.before)).rotation;
    f.turn = 2.0 * sn_norm(sn_v3(by.x, by.y, by.z));
    return f;
}

/* How far from a box a point is. */
static double distance_from(const sn_box *box, sn_vec3 p) {
    sn_vec3 out = sn_max3(sn_max3(sn_sub(box->low, p), sn_sub(p, box->high)), sn_v3(0, 0, 0));
    return sn_norm(out);
}

/* Could any point of the muscle come to this collider in the step? By the ball around the muscle's box. */
static bool whole_comes_near(const sn_collider *collider, const whole *w, const frames *f, double margin) {
    sn_vec3 middle = sn_scale(sn_add(w->box.low, w->box.high), 0.5);
    double radius = 0.5 * sn_box_diagonal(w->box);
    sn_vec3 before = sn_rigid_apply(f->before, middle), after = sn_rigid_apply(f->after, sn_add(middle, w->way));
    double way = sn_distance(before, after), turn = radius * f->turn; /* at the ball's rim */
    double nearest = fmin(distance_from(&collider->field->box, before), distance_from(&collider->field->box, after));
    return nearest <= radius + margin + w->reach + w->flies + way + turn;
}

/* Is phi sure to stay above `reach` on a point's way from `from` before the step to `to` after it? phi: at `from`, in the bone's frame at
 * p. */
static bool passes_by(const sn_collider *collider, const frames *f, sn_vec3 p, double phi, sn_vec3 to, double reach) {
    sn_vec3 q = sn_rigid_apply(f->after, to);
    double way = sn_distance(p, q);
    return phi - way >= reach || phi + sn_distance_field_at(collider->field, q, NULL) - way >= 2.0 * reach;
}

/* Where a row's point starts and the two ways that it may take: along with the muscle, and where it flies. */
typedef struct start {
    sn_vec3 from, along, flying;
} start;

/* before (point_count): the points before the step, NULL: the state's are. pull: what the weight adds to the way, m. */
static start start_of(const sn_contact_row *row, const sn_muscle_state *s, const sn_vec3 *before, const whole *w) {
    sn_vec3 from = before == NULL ? sn_contact_point(row, s->points) : sn_contact_mean(row, before);
    return (start){from, sn_add(from, w->way), sn_add_scaled(sn_add(from, w->pull), sn_contact_mean(row, s->velocities), w->h)};
}

/* Could a row's point come to its bone? */
static bool comes_near(const sn_collider *collider, const frames *f, const start *at, double reach) {
    sn_vec3 p = sn_rigid_apply(f->before, at->from);
    double phi = sn_distance_field_at(collider->field, p, NULL);
    return !passes_by(collider, f, p, phi, at->along, reach) || !passes_by(collider, f, p, phi, at->flying, reach);
}

/* ---- blocks of rows that stand together ------------------------------------------------------------------------------------------------
 */

/* Could any of its points come as near to the bone as `reach`, on one of the two ways? Phi at each is at most the radius from that at the
 * middle, and a turn carries them by so much more. */
static bool block_comes_near(const sn_collider *collider, const frames *f, const sn_contact_block *b, const whole *w, double reach) {
    sn_vec3 p = sn_rigid_apply(f->before, b->middle), q = sn_rigid_apply(f->after, sn_add(b->middle, w->way));
    double phi = 0.5 * (sn_distance_field_at(collider->field, p, NULL) + sn_distance_field_at(collider->field, q, NULL));
    return !(phi - 0.5 * (sn_distance(p, q) + b->radius * f->turn) - b->radius - w->flies >= reach); /* what is not finite is looked at */
}

/* ---- before a step
 * -------------------------------------------------------------------------------------------------------------------------- */

static bool any_comes_near(const sn_contacts *contacts, const sn_muscle_state *s, const sn_collider *collider, const frames *f,
                           const whole *w) {
    double reach = contacts->margin + w->reach;
    if (!whole_comes_near(collider, w, f, contacts->margin)) return false;
    for (sn_index begin = collider->begin; begin < collider->end; begin += SN_CONTACT_BLOCK) {
        sn_contact_block b = sn_contact_block_at(contacts, collider, begin, s->points, NULL);
        if (!block_comes_near(collider, f, &b, w, reach)) continue;
        for (sn_index r = b.begin; r < b.end; r++) {
            start at = start_of(&contacts->rows[r], s, NULL, w);
            if (comes_near(collider, f, &at, reach)) return true;
        }
    }
    return false;
}

bool sn_contacts_moved(const sn_model_muscle *m, const sn_muscle_state *s, double since) {
    const sn_contacts *contacts = sn_contacts_of(m);
    if (m->collider_count == 0) return false;
    whole w = see_whole(m, s, NULL);
    for (sn_index c = 0; c < m->collider_count; c++) {
        frames f = frames_of(s, c);
        bool still = memcmp(&s->inputs->collider_poses[c], &s->inputs->collider_placed[c], sizeof *s->inputs->collider_poses) == 0;
        if (!still && any_comes_near(contacts, s, &contacts->colliders[c], &f, &w)) return true;
    }
    return s->inputs->resolved > 0.0 && share_resolved(contacts, since) < 1.0;
}

/* Is a point carried by its bone farther than is safe, and near it? */
static bool passes(const sn_collider *collider, const frames *f, sn_vec3 from, sn_vec3 to, double margin) {
    sn_vec3 p = sn_rigid_apply(f->before, from);
    if (sn_distance(p, sn_rigid_apply(f->after, to)) <= collider->limit) return false;
    return !passes_by(collider, f, p, sn_distance_field_at(collider->field, p, NULL), to, margin);
}

static bool passes_too_far(const sn_contacts *contacts, const sn_muscle_state *s, sn_index c, const whole *w) {
    const sn_collider *collider = &contacts->colliders[c];
    frames f = frames_of(s, c);
    if (!whole_comes_near(collider, w, &f, contacts->margin)) return false;
    for (sn_index begin = collider->begin; begin < collider->end; begin += SN_CONTACT_BLOCK) {
        sn_contact_block b = sn_contact_block_at(contacts, collider, begin, s->points, NULL);
        if (!block_comes_near(collider, &f, &b, w, contacts->margin)) continue;
        for (sn_index r = b.begin; r < b.end; r++) {
            start at = start_of(&contacts->rows[r], s, NULL, w);
            if (passes(collider, &f, at.from, at.along, contacts->margin) || passes(collider, &f, at.from, at.flying, contacts->margin))
                return true;
        }
    }
    return false;
}

bool sn_contacts_too_far(const sn_model_muscle *m, const sn_muscle_state *s, const sn_substep *substep) {
    const sn_contacts *contacts = sn_contacts_of(m);
    if (m->collider_count == 0 || contacts->by_voxels) return false; /* [K21] looks at the end of the step alone */
    whole w = see_flying(m, s, NULL, substep->h, substep->gravity);
    for (sn_index c = 0; c < m->collider_count; c++)
        if (passes_too_far(contacts, s, c, &w)) return true;
    return false;
}

static void gather_from(const sn_contacts *contacts, const sn_model_muscle *m, sn_muscle_state *s, sn_index c, const whole *w) {
    const sn_collider *collider = &contacts->colliders[c];
    sn_inputs *in = s->inputs;
    frames f = frames_of(s, c);
    double reach = contacts->margin + w->reach;
    bool comes = whole_comes_near(collider, w, &f, contacts->margin);
    for (sn_index begin = collider->begin; begin < collider->end; begin += SN_CONTACT_BLOCK) {
        sn_contact_block b = sn_contact_block_at(contacts, collider, begin, s->points, s->previous);
        bool block_comes = comes && block_comes_near(collider, &f, &b, w, reach);
        for (sn_index r = b.begin; r < b.end; r++) {
            bool near = block_comes;
            if (near) {
                start at = start_of(&contacts->rows[r], s, s->previous, w);
                near = comes_near(collider, &f, &at, reach);
            }
            if (near)
                in->near[in->near_count++] = r;
            else if (m->quasi_newton)
                in->multipliers[r] = 0.0;
        }
    }
}

void sn_contacts_gather(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep) {
    const sn_contacts *contacts = sn_contacts_of(m);
    s->inputs->near_count = 0;
    if (m->collider_count == 0) return;
    for (sn_index r = 0; contacts->by_voxels && r < m->contact_count; r++) s->inputs->near[s->inputs->near_count++] = r;
    if (contacts->by_voxels) return;
    whole w = see_flying(m, s, s->previous, substep->h, m->quasi_newton ? substep->gravity : sn_v3(0, 0, 0));
    for (sn_index c = 0; c < m->collider_count; c++) gather_from(contacts, m, s, c, &w);
}

/* ---- after a step
 * ----------------------------------------------------------------------------------------------------------------------------- */

/* Rows of one collider that are beyond their margin; false: there were none. */
static bool project_collider(const sn_model_muscle *m, sn_muscle_state *s, sn_index c, const whole *w) {
    const sn_contacts *contacts = sn_contacts_of(m);
    const sn_collider *collider = &contacts->colliders[c];
    frames f = frames_of(s, c);
    bool moved = false;
    if (!whole_comes_near(collider, w, &f, contacts->margin)) return false;
    for (sn_index begin = collider->begin; begin < collider->end; begin += SN_CONTACT_BLOCK) {
        sn_contact_block b = sn_contact_block_at(contacts, collider, begin, s->points, NULL);
        if (!sn_contact_block_is_near(collider, f.after, &b, contacts->margin)) continue;
        for (sn_index r = b.begin; r < b.end; r++) moved = sn_contact_project(m, s, collider, r, false) || moved;
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
    whole w = see_whole(m, s, NULL);
    bool moved = true;
    for (int i = 0; i < LAST_SWEEPS && moved; i++) {
        moved = false;
        for (sn_index c = 0; c < m->collider_count; c++) moved = project_collider(m, s, c, &w) || moved;
    }
    keep_poses(m, s);
}
