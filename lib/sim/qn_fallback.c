/*
 * qn_fallback.c -- what the back end `qn` does where a muscle or a step is beyond what it is for: a wreck is given up; a torn start stays
 * where it was, or is carried along with the bones; a step that tears a muscle is refused.   numerics.md 5, 7
 */
#include "external.h"
#include "qn.h"

/* A smaller stretch than SN_QN_FAR_STRETCHED counts where bones are fast. */
static const double FAST_STRETCHED = 1.0;
/* A triangle that starts a step below this share of its rest area goes through it without barrier and area limit (numerics.md 7). */
static const double UNGUARDED = 0.05;
/* One that the barrier held in the last step is given up later: where much else presses on it, it comes as low as this. */
static const double STILL_GUARDED = 1e-3;

/* ---- how the members stand ---------------------------------------------------------------------------------------------------- */

static double area_ratio(const sn_model_muscle *m, const sn_muscle_state *s, sn_index row) {
    return sn_qn_double_area(s->points, m->areas[row].point) * m->area_scales[row];
}

static sn_residual stretch_of(const sn_model_muscle *m, const sn_muscle_state *s) {
    return sn_rows_residual(m, s, sn_stretch_kind(m), NULL);
}

static sn_condition condition_of(const sn_model_muscle *m, const sn_muscle_state *s) {
    sn_condition now = {.stretch = stretch_of(m, s)};
    for (sn_index r = 0; r < m->area_count; r++) now.collapsed += !(area_ratio(m, s, r) >= UNGUARDED);
    return now;
}

/* What is not a number stays so. */
static double greater(double a, double b) { return isnan(a) || b <= a ? a : b; }

static void add_condition(const sn_condition *member, sn_condition *sum) {
    sum->collapsed += member->collapsed;
    sum->stretch.max = greater(sum->stretch.max, member->stretch.max);
    sum->stretch.rms = greater(sum->stretch.rms, member->stretch.rms);
}

static sn_condition condition_of_all(const sn_group *g, const sn_group_state *s) {
    sn_condition now = {.collapsed = 0};
    for (sn_index i = 0; i < g->count; i++) {
        sn_condition member = condition_of(g->members[i], s->members[i]);
        add_condition(&member, &now);
    }
    return now;
}

bool sn_qn_is_stretched(const sn_residual *stretch, bool fast) {
    return stretch->max > (fast ? FAST_STRETCHED : SN_QN_FAR_STRETCHED) || stretch->rms > SN_QN_FAR_IN_THE_MEAN;
}

/* Marks the triangles that have a barrier: those that are not collapsed, and those whose barrier has held them so far. */
static void guard_triangles(const sn_model_muscle *m, sn_muscle_state *s) {
    bool *guarded = s->inputs->guarded;
    for (sn_index r = 0; r < m->area_count; r++) guarded[r] = area_ratio(m, s, r) >= (guarded[r] ? STILL_GUARDED : UNGUARDED);
}

/* May this be no shape that the muscle came to by moving: a tenth of it collapsed, half a mean edge off in the mean, or half of its volume
 * gone? */
static bool is_wrecked(const sn_model_muscle *m, const sn_muscle_state *s, const sn_condition *now) {
    if (now->collapsed > m->area_count / 10 || now->stretch.rms > SN_QN_FAR_IN_THE_MEAN) return true;
    if (!m->keeps_volume) return false;
    double volume = sn_volume_constraint(m->vertex_count, s->points, m->triangle_count, m->triangles, NULL);
    return !(fabs(volume / (s->inputs->volume_goal * m->rest_volume) - 1.0) <= 0.5);
}

/* ---- a wreck is given up ------------------------------------------------------------------------------------------------------ */

/* Phi at the state's points if they stood still. */
static double energy_at_rest(const sn_group *g, sn_group_state *s, double h) {
    sn_qn *qn = sn_qn_of(s);
    for (sn_index i = 0; i < g->point_count; i++) qn->target[i] = sn_point_position(&s->points[i]);
    return sn_objective_evaluate(&(sn_objective){g, s, h}, s->points, qn->gradient);
}

/* A wreck (coincident, flattened, random or mirrored points, a bone that has jumped far away) that holds more energy than the rest pose
 * carried along with the bones is given up for that, at rest: the way back from it is no motion, and it may lead into another wreck. */
static void restart(const sn_group *g, sn_group_state *s, sn_index member, double h) {
    const sn_model_muscle *m = g->members[member];
    sn_muscle_state *muscle = s->members[member];
    sn_point *wreck = sn_qn_of(s)->trial + g->first[member];
    size_t bytes = (size_t)m->point_count * sizeof *wreck;
    for (sn_index i = 0; i < g->point_count && g->row_count > 0; i++) s->previous[i] = sn_point_position(&s->points[i]);
    sn_externals_find(g, s);
    double wrecked = energy_at_rest(g, s, h);
    memcpy(wreck, muscle->points, bytes);
    sn_kinematics_carry(m, muscle, muscle->points);
    if (energy_at_rest(g, s, h) < wrecked) {
        memset(muscle->velocities, 0, (size_t)m->point_count * sizeof *muscle->velocities);
        muscle->inputs->bones = (sn_bone_motion){.rate = 0.0};
        sn_qn_forget_pairs(sn_qn_of(s));
        muscle->statistics.restarts++;
    } else {
        memcpy(muscle->points, wreck, bytes);
    }
}

sn_condition sn_qn_look(const sn_group *g, sn_group_state *s, double h) {
    sn_condition all = {.collapsed = 0};
    for (sn_index i = 0; i < g->count; i++) {
        const sn_model_muscle *m = g->members[i];
        sn_condition now = condition_of(m, s->members[i]);
        guard_triangles(m, s->members[i]);
        if (is_wrecked(m, s->members[i], &now)) {
            restart(g, s, i, h);
            now = condition_of(m, s->members[i]);
            guard_triangles(m, s->members[i]);
        }
        add_condition(&now, &all);
    }
    return all;
}

/* ---- other starts --------------------------------------------------------------------------------------------------------------- */

void sn_qn_prefer_trial(const sn_group *g, sn_group_state *s, double h) {
    sn_qn *qn = sn_qn_of(s);
    const sn_objective objective = {g, s, h};
    double energy = sn_objective_evaluate(&objective, qn->trial, qn->trial_gradient);
    if (energy <= qn->energy) {
        qn->energy = energy;
        memcpy(s->points, qn->trial, (size_t)g->point_count * sizeof *s->points);
        memcpy(qn->gradient, qn->trial_gradient, (size_t)g->point_count * sizeof *qn->gradient);
    } else {
        sn_objective_evaluate(&objective, s->points, qn->gradient); /* for the gradient of the volume there */
    }
}

void sn_qn_try_staying(const sn_group *g, sn_group_state *s, double h, const bool *stays) {
    sn_point *trial = sn_qn_of(s)->trial;
    for (sn_index k = 0; k < g->count; k++)
        for (sn_index i = g->first[k]; i < g->first[k + 1]; i++) {
            trial[i] = s->points[i];
            if (s->points[i].w > 0.0 && (stays == NULL || stays[k])) sn_put(&trial[i], s->previous[i]);
        }
    sn_qn_prefer_trial(g, s, h);
}

/* Bones that have gone far in one step leave all of them torn: the rest pose carried along with them may be better. */
static void try_carried(const sn_group *g, sn_group_state *s, double h) {
    sn_point *trial = sn_qn_of(s)->trial;
    memcpy(trial, s->points, (size_t)g->point_count * sizeof *s->points);
    for (sn_index i = 0; i < g->count; i++) sn_kinematics_carry(g->members[i], s->members[i], trial + g->first[i]);
    sn_qn_prefer_trial(g, s, h);
}

bool sn_qn_is_torn(const sn_group *g, const sn_group_state *s, sn_index member, bool fast) {
    sn_residual stretch = stretch_of(g->members[member], s->members[member]);
    return sn_qn_is_stretched(&stretch, fast);
}

/* Which members are: torn (count). */
static bool find_torn(const sn_group *g, const sn_group_state *s, bool fast, bool *torn) {
    bool any = false;
    for (sn_index i = 0; i < g->count; i++) {
        torn[i] = sn_qn_is_torn(g, s, i, fast);
        any = any || torn[i];
    }
    return any;
}

bool sn_qn_mend_start(const sn_group *g, sn_group_state *s, double h, bool jumped, bool fast) {
    bool *torn = sn_qn_of(s)->torn_members, any = find_torn(g, s, fast, torn);
    if (any || jumped) sn_qn_try_staying(g, s, h, jumped ? NULL : torn);
    if (jumped) try_carried(g, s, h);
    return jumped || (any && find_torn(g, s, fast, torn));
}

/* ---- a step that is too long ------------------------------------------------------------------------------------------------------ */

bool sn_qn_tears(const sn_group *g, const sn_group_state *s) {
    double before = sn_qn_of(s)->stretch_before;
    if (before == INFINITY) return false;
    sn_condition now = condition_of_all(g, s);
    bool stretches = now.stretch.max > FAST_STRETCHED && now.stretch.max > 2.0 * before;
    return now.collapsed > 0 || stretches || now.stretch.rms > SN_QN_FAR_IN_THE_MEAN;
}

void sn_qn_go_back(const sn_group *g, sn_group_state *s) {
    for (sn_index i = 0; i < g->point_count; i++) sn_put(&s->points[i], s->previous[i]);
    sn_qn_forget_pairs(sn_qn_of(s));
}
