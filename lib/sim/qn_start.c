/*
 * qn_start.c -- how a step of the back end `qn` starts, in five stages: look at how the muscles stand; aim, where inertia and the bones
 * take the points; the matrix; the predictor; the points to begin with, and others where those are no good (qn_fallback.c).   numerics.md
 * 2, 7
 */
#include "contact.h"
#include "external.h"
#include "qn.h"

/* Bones that move a point farther than so many mean edges in a step, or did in the last, tear the rings next to them: there a smaller
 * stretch counts. */
static const double FAST_EDGES = 4.0;
/* Where a point's way from one step to the next changes by so many mean edges (bones set out, or stop), no predictor knows of it, and the
 * strain of the first rings takes longer to spread: 20 iterations for what else takes 10. */
static const double ABRUPT_EDGES = 2.0;

/* ---- look ----------------------------------------------------------------------------------------------------------------------- */

/* The corotated and the two-level matrix are of use near the rest shape only: no collapsed triangle, no edge that is half a mean edge off
 * (numerics.md 7). */
static bool may_turn(const sn_group *g, const sn_condition *now) {
    return (g->corotated || g->two_level) && now->collapsed == 0 && now->stretch.max <= 0.5;
}

static void look_around(const sn_group *g, sn_group_state *s, double h) {
    sn_qn *qn = sn_qn_of(s);
    sn_condition now = sn_qn_look(g, s, h);
    qn->stretch_before = now.collapsed == 0 && !sn_qn_is_stretched(&now.stretch, false) ? now.stretch.max : INFINITY;
    qn->turned = may_turn(g, &now);
}

/* ---- aim ------------------------------------------------------------------------------------------------------------------------ */

/* y = x + h (u + (v - u) e^(-c h)) + h^2 g for the free points, u the velocity of the bones there; previous = x. target (point_count). */
static void aim_member(const sn_model_muscle *m, sn_muscle_state *s, sn_vec3 *target, const sn_substep *substep) {
    double h = substep->h, keep = sn_exp(-m->source->damping * h);
    for (sn_index i = 0; i < m->point_count; i++) {
        target[i] = s->previous[i] = sn_point_position(&s->points[i]);
        if (s->points[i].w == 0.0) continue;
        sn_vec3 v = sn_add_scaled(sn_damped_velocity(s, i, keep), substep->gravity, h);
        target[i] = sn_add_scaled(s->previous[i], v, h);
    }
}

/* Speed of the fastest carried point over the last step, m/s. */
static double fastest_carried(const sn_model_muscle *m, const sn_muscle_state *s) {
    double most = 0.0;
    for (sn_index k = 0; k < m->kinematic_count; k++) most = fmax(most, sn_norm2(s->velocities[m->kinematic_points[k]]));
    return sqrt(most);
}

/* Put the carried points at their places; jump (point_count) is how far they came. Returns the longest way. */
static double place_carried(const sn_model_muscle *m, sn_muscle_state *s, sn_vec3 *jump) {
    sn_kinematics_place(m, s);
    double most = 0.0;
    for (sn_index i = 0; i < m->point_count; i++) {
        jump[i] = s->points[i].w == 0.0 ? sn_sub(sn_point_position(&s->points[i]), s->previous[i]) : sn_v3(0, 0, 0);
        most = fmax(most, sn_norm2(jump[i]));
    }
    return sqrt(most);
}

/* How much farther or less far than in the last step a carried point comes: 0 where bones go on as they did. */
static double change_of_motion(const sn_model_muscle *m, const sn_muscle_state *s, const sn_vec3 *jump, double h) {
    double change = 0.0;
    for (sn_index k = 0; k < m->kinematic_count; k++) {
        sn_index i = m->kinematic_points[k];
        change = fmax(change, sn_distance(jump[i], sn_scale(s->velocities[i], h)));
    }
    return change;
}

/* What the bones do in a step, of all members. */
typedef struct bone_way {
    bool moves;   /* any of them */
    bool carries; /* points are attached to them */
    bool smooth;  /* they go on as in the last step, to within an edge */
    bool fast, abrupt, jumped;
    bool meets; /* one may be touched: also where they have just stopped, inertia alone would throw the muscle on it, or off it */
    bool far;   /* by more than a muscle's diagonal */
} bone_way;

static void add_way(const sn_model_muscle *m, sn_muscle_state *s, sn_vec3 *jump, double h, bone_way *way) {
    double most = place_carried(m, s, jump), change = change_of_motion(m, s, jump, h);
    way->moves = way->moves || most > 0.0;
    way->carries = way->carries || m->kinematic_count > 0;
    way->smooth = way->smooth && change <= m->mean_edge;
    way->fast = way->fast || fmax(most, h * fastest_carried(m, s)) > FAST_EDGES * m->mean_edge;
    way->abrupt = way->abrupt || change > ABRUPT_EDGES * m->mean_edge;
    way->jumped = way->jumped || change > SN_QN_FAR * m->diagonal;
    way->far = way->far || !(most <= m->diagonal);
}

static bone_way aim(const sn_group *g, sn_group_state *s, const sn_substep *substep) {
    sn_qn *qn = sn_qn_of(s);
    bone_way way = {.smooth = true};
    for (sn_index i = 0; i < g->count; i++) {
        aim_member(g->members[i], s->members[i], qn->target + g->first[i], substep);
        add_way(g->members[i], s->members[i], qn->jump + g->first[i], substep->h, &way);
        sn_contacts_gather(g->members[i], s->members[i], substep);
        way.meets = way.meets || s->members[i]->inputs->near_count > 0;
    }
    sn_externals_find(g, s);
    qn->abrupt = way.abrupt;
    return way;
}

/* ---- the matrix, for h and the stiffness now ------------------------------------------------------------------------------------ */

static void take_matrix(const sn_group *g, sn_group_state *s, double h) {
    sn_qn *qn = sn_qn_of(s);
    bool changed = false;
    if (qn->turned && !sn_qn_go_by(g, s, h, &changed)) qn->turned = false; /* free and stiff: to rounding it is singular */
    if (!qn->turned && !sn_qn_go_by(g, s, h, &changed)) sn_qn_stop(s, g, SN_STOP_FAILED);
    if (changed || (qn->turned && g->corotated)) sn_qn_forget_pairs(qn); /* pairs from other frames mislead the corotated matrix */
    for (sn_index i = 0; i < g->count; i++) s->members[i]->statistics.refactorisations += changed;
}

/* ---- the predictor -------------------------------------------------------------------------------------------------------------- */

/* Where the predictor starts: everything where it was; or, where the carried points go on smoothly, the free points where their velocity
 * takes them (without the weight, which the muscle bears already or will). trial and jump are then base and what is left of the way. */
static void choose_base(const sn_group *g, sn_group_state *s, double h, sn_vec3 weight, bool smooth) {
    sn_qn *qn = sn_qn_of(s);
    for (sn_index i = 0; i < g->point_count; i++) {
        bool carried = s->points[i].w == 0.0;
        sn_vec3 jump = qn->jump[i], before = carried ? sn_scale(s->velocities[i], h) : sn_v3(0, 0, 0);
        sn_vec3 base = !smooth ? s->previous[i] : carried ? sn_add(s->previous[i], before) : sn_sub(qn->target[i], weight);
        qn->trial[i] = s->points[i];
        sn_put(&qn->trial[i], base);
        qn->jump[i] = smooth ? sn_sub(jump, before) : jump;
    }
}

/* d = -(A_ff + k_V g_f g_fT)^-1 (grad_f Phi(base) + A_fk jump + k_V g_f (g_k . jump)) takes the place of a first iteration: without it
 * fast bones crush the first ring of triangles (numerics.md 7). Leaves the predicted points in trial; false: no direction. */
static bool predict(const sn_group *g, sn_group_state *s, double h, sn_vec3 weight, bool smooth) {
    sn_qn *qn = sn_qn_of(s);
    choose_base(g, s, h, weight, smooth);
    sn_objective_evaluate(&(sn_objective){g, s, h}, qn->trial, qn->gradient);
    sn_qn_find_volume_gradient(g, s);
    sn_preconditioner_turn(qn->preconditioner, qn->trial);
    sn_preconditioner_add_jump(qn->preconditioner, qn->jump, qn->volume_gradient, qn->volume_stiffness, qn->gradient);
    sn_qn_set_volume_rows(qn, qn->volume_gradient);
    if (!sn_preconditioner_apply(qn->preconditioner, qn->gradient, qn->direction)) return false;
    for (sn_index i = 0; i < g->point_count; i++) {
        sn_vec3 base = sn_point_position(&qn->trial[i]);
        sn_put(&qn->trial[i], s->points[i].w == 0.0 ? sn_point_position(&s->points[i]) : sn_sub(base, qn->direction[i]));
    }
    return true;
}

/* ---- the points to begin with ----------------------------------------------------------------------------------------------------- */

/* What lies on a bone slides on, without the weight that the bone bears. */
static void try_coasting(const sn_group *g, sn_group_state *s, double h, sn_vec3 weight) {
    sn_qn *qn = sn_qn_of(s);
    if (!(sn_norm2(weight) > 0.0)) return; /* that is where inertia takes it */
    for (sn_index i = 0; i < g->point_count; i++) {
        qn->trial[i] = s->points[i];
        if (s->points[i].w > 0.0) sn_put(&qn->trial[i], sn_sub(qn->target[i], weight));
    }
    sn_qn_prefer_trial(g, s, h);
}

/* Points that inertia or a bone has put inside a bone start at its surface, or where they were, if that is better: a matrix that knows
 * nothing of bones would throw the muscle off them. */
static void clear_start(const sn_group *g, sn_group_state *s, double h, sn_vec3 weight) {
    sn_point *trial = sn_qn_of(s)->trial;
    bool moved = false;
    memcpy(trial, s->points, (size_t)g->point_count * sizeof *trial);
    for (sn_index i = 0; i < g->count; i++) moved = sn_contacts_clear(g->members[i], s->members[i], trial + g->first[i]) || moved;
    if (moved) sn_qn_prefer_trial(g, s, h);
    try_coasting(g, s, h, weight);
    sn_qn_try_staying(g, s, h, NULL);
}

/* Where inertia takes the points, or the predictor (in trial). */
static void choose_start(const sn_group *g, sn_group_state *s, double h, bool predicted) {
    sn_qn *qn = sn_qn_of(s);
    for (sn_index i = 0; i < g->point_count; i++)
        if (s->points[i].w > 0.0) sn_put(&s->points[i], qn->target[i]);
    qn->energy = sn_objective_evaluate(&(sn_objective){g, s, h}, s->points, qn->gradient);
    if (predicted) sn_qn_prefer_trial(g, s, h);
}

/* The coarse space of the two-level matrix, at these points from here to the end of the step. */
static void place_sections(const sn_group *g, sn_group_state *s, double h) {
    sn_qn *qn = sn_qn_of(s);
    if (!g->two_level) return;
    for (sn_index i = 0; i < g->point_count; i++) qn->section_points[i] = sn_point_position(&s->points[i]);
    sn_preconditioner_correct(qn->preconditioner, qn->turned ? qn->section_points : NULL, h, qn->stiffness);
}

/* The matrix goes with the points from here on. */
static void settle_matrix(const sn_group *g, sn_group_state *s, double h) {
    sn_qn *qn = sn_qn_of(s);
    qn->turned = qn->turned && !qn->torn;
    sn_preconditioner_turn(qn->preconditioner, s->points);
    place_sections(g, s, h);
    sn_qn_take_volume_gradient(g, s);
}

bool sn_qn_start(const sn_group *g, sn_group_state *s, const sn_substep *substep) {
    sn_qn *qn = sn_qn_of(s);
    double h = substep->h;
    sn_vec3 weight = sn_scale(substep->gravity, h * h); /* how far it alone moves a free point */
    sn_qn_stop(s, g, SN_STOP_ITERATIONS);
    sn_qn_take_stiffness(g, s);
    sn_preconditioner_correct(qn->preconditioner, NULL, h, qn->stiffness); /* the predictor goes by the scalar matrix */
    look_around(g, s, h);
    bone_way way = aim(g, s, substep);
    take_matrix(g, s, h);
    bool pushed = way.moves || way.meets || (way.carries && sn_norm2(weight) > 0.0);
    bool predicted = pushed && qn->stopped != SN_STOP_FAILED && predict(g, s, h, weight, way.smooth);
    choose_start(g, s, h, predicted);
    if (way.meets) clear_start(g, s, h, weight);
    qn->torn = sn_qn_mend_start(g, s, h, way.jumped, way.fast);
    bool jumps = way.jumped && qn->stretch_before < INFINITY;
    if (qn->torn && substep->may_halve && !way.far && (jumps || sn_qn_tears(g, s))) return false;
    settle_matrix(g, s, h);
    return true;
}

void sn_qn_resume(const sn_group *g, sn_group_state *s, const sn_substep *substep) {
    double h = substep->h;
    sn_qn *qn = sn_qn_of(s);
    bool changed;
    for (sn_index i = 0; i < g->count; i++) sn_contacts_gather(g->members[i], s->members[i], substep);
    sn_externals_find(g, s);
    sn_qn_take_stiffness(g, s);
    qn->energy = sn_objective_evaluate(&(sn_objective){g, s, h}, s->points, qn->gradient); /* the residual needs it, iterations or not */
    if (qn->stopped != SN_STOP_ITERATIONS) return;
    if (!sn_qn_go_by(g, s, h, &changed)) sn_qn_stop(s, g, SN_STOP_FAILED);
    if (g->two_level) sn_preconditioner_correct(qn->preconditioner, qn->turned ? qn->section_points : NULL, h, qn->stiffness);
    sn_qn_set_volume_rows(qn, qn->row_gradient);
}
