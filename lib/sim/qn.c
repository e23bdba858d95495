/*
 * qn.c -- back end `qn`: implicit Euler by quasi-Newton.   Liu, Bouaziz, Kavan 2017; numerics.md 2, 7
 *
 * A substep minimises Phi(x) (energy.c) from a predictor: L-BFGS on top of a factored matrix of the rest shape (precondition.c) gives a
 * direction, Armijo's rule its length. Pairs are kept from substep to substep, but not under the corotated matrix. A substep ends when a
 * whole step would move no point by more than the tolerance, when no step lowers the energy any more, or after its iterations.
 */
#include "qn.h"

#include <stdlib.h>
#include <string.h>

static const double ARMIJO = 1e-4;
static const int MOST_HALVINGS = 30;
/* What energies differ by for no other reason than rounding, as a share of them; there the slope decides (Hager and Zhang 2005). */
static const double ENERGY_NOISE = 1e-13;
/* A whole step that moves no point by more than this share of the diagonal is rounding. */
static const double STEP_NOISE = 1e-14;
/* No point moves further than this share of the muscle's size in one iteration: of its diagonal, or of how far its bones are apart. */
static const double STEP_CAP = 0.1;
/* An edge as far as the first from its goal, in mean edges (or such a strain), all of them as far as the second in the mean, or a bone that
 * has jumped: the matrix of the rest shape says little then, and each iteration that the scene allows stands for several. */
static const double FAR_STRETCHED = SN_FAR_STRETCHED, FAR_IN_THE_MEAN = SN_FAR_IN_THE_MEAN;
enum { TORN_EFFORT = 10 };
/* Bones that move a point farther than so many mean edges in a substep, or did in the last, tear the rings next to them: there a smaller
 * stretch counts. */
static const double FAST_EDGES = 4.0, FAST_STRETCHED = 1.0;
/* Where a point's way from one substep to the next changes by so many mean edges (bones set out, or stop), no predictor knows of it, and
 * the strain of the first rings takes longer to spread: 20 iterations for what else takes 10. */
static const double ABRUPT_EDGES = 2.0;
enum { ABRUPT_EFFORT = 2 };
/* A bone that moves a point by this share of the diagonal more or less than in the substep before has jumped. */
static const double FAR = 0.2;
/* No triangle shrinks below this share of its area in one step: hinges have no barrier against collapse. */
static const double AREA_LIMIT = 0.3;
/* A triangle that starts a substep below this share of its rest area goes through it without barrier and area limit (numerics.md 7). */
static const double UNGUARDED = 0.05;
/* One that the barrier held in the last substep is given up later: where much else presses on it, it comes as low as this. */
static const double STILL_GUARDED = 1e-3;
/* Iterations after which the volume row of the matrix is made for the points at hand: L-BFGS learns how it turns, up to a point. */
enum { VOLUME_REFRESH = 8 };
/* One iteration alone may fall into a wrong basin. */
enum { LEAST_ITERATIONS = 3 };
/* A pair whose step and change are nearly orthogonal says nothing about curvature. */
static const double LEAST_CURVATURE = 1e-10;

/* ---- vectors of points ---------------------------------------------------------------------------------------------------- */

static double dot(sn_index n, const sn_vec3 *a, const sn_vec3 *b) {
    double sum = 0.0;
    for (sn_index i = 0; i < n; i++) sum += sn_dot(a[i], b[i]);
    return sum;
}

static void add_scaled(sn_index n, sn_vec3 *sum, const sn_vec3 *a, double scale) {
    for (sn_index i = 0; i < n; i++) sum[i] = sn_add_scaled(sum[i], a[i], scale);
}

static double longest(sn_index n, const sn_vec3 *a) {
    double most = 0.0;
    for (sn_index i = 0; i < n; i++) most = fmax(most, sn_norm2(a[i]));
    return sqrt(most);
}

static void set_position(sn_point *p, sn_vec3 position) { p->x = position.x, p->y = position.y, p->z = position.z; }

/* ---- L-BFGS ----------------------------------------------------------------------------------------------------------------- */

/* The slot of the pair `age` pairs ago; 0 is the latest. */
static size_t slot_of(const sn_muscle_state *s, sn_index age) { return (size_t)((s->pair_next + SN_QN_MEMORY - 1 - age) % SN_QN_MEMORY); }

static void forget_pairs(sn_muscle_state *s) { s->pair_count = s->pair_next = 0; }

static void remember_pair(const sn_model_muscle *m, sn_muscle_state *s, double length) {
    size_t n = (size_t)m->point_count, slot = (size_t)s->pair_next;
    sn_vec3 *step = s->pair_steps + slot * n, *change = s->pair_changes + slot * n;
    for (size_t i = 0; i < n; i++) {
        step[i] = sn_scale(s->qn->direction[i], length);
        change[i] = sn_sub(s->qn->trial_gradient[i], s->qn->gradient[i]);
    }
    double product = dot(m->point_count, step, change);
    double size = sqrt(dot(m->point_count, step, step) * dot(m->point_count, change, change));
    if (!(product > LEAST_CURVATURE * size)) return;
    s->pair_products[slot] = product;
    s->pair_next = (s->pair_next + 1) % SN_QN_MEMORY;
    if (s->pair_count < SN_QN_MEMORY) s->pair_count++;
}

/* direction = -H gradient by the two-loop recursion; false where the matrix could not be solved. */
static bool find_direction(const sn_model_muscle *m, sn_muscle_state *s) {
    sn_index n = m->point_count;
    sn_vec3 *d = s->qn->direction;
    double weight[SN_QN_MEMORY];
    for (sn_index i = 0; i < n; i++) d[i] = sn_neg(s->qn->gradient[i]);
    for (sn_index age = 0; age < s->pair_count; age++) {
        size_t slot = slot_of(s, age);
        weight[age] = dot(n, s->pair_steps + slot * (size_t)n, d) / s->pair_products[slot];
        add_scaled(n, d, s->pair_changes + slot * (size_t)n, -weight[age]);
    }
    if (!sn_preconditioner_apply(s->qn->preconditioner, d, d)) return false;
    for (sn_index age = s->pair_count; age-- > 0;) {
        size_t slot = slot_of(s, age);
        double along = dot(n, s->pair_changes + slot * (size_t)n, d) / s->pair_products[slot];
        add_scaled(n, d, s->pair_steps + slot * (size_t)n, weight[age] - along);
    }
    return true;
}

/* ---- one iteration ------------------------------------------------------------------------------------------------------------ */

static sn_objective objective_of(const sn_model_muscle *m, const sn_muscle_state *s, double h) {
    return (sn_objective){.model = m, .state = s, .h = h};
}

static double volume_stiffness(const sn_model_muscle *m, const sn_muscle_state *s) {
    return m->keeps_volume ? sn_row_stiffness(m, s, SN_ROWS_VOLUME) : 0.0;
}

/* From here on the matrix has the volume row with this gradient (vertex_count). */
static void set_volume_row(const sn_model_muscle *m, sn_muscle_state *s, const sn_vec3 *gradient) {
    double k = volume_stiffness(m, s);
    sn_preconditioner_set_volume(s->qn->preconditioner, gradient, &k);
}

static double double_area(const sn_point *points, const sn_index *v) {
    sn_vec3 a = sn_point_position(&points[v[0]]), b = sn_point_position(&points[v[1]]), c = sn_point_position(&points[v[2]]);
    return sn_norm(sn_area_vector(a, b, c));
}

/* Does no triangle shrink too much from the state's points to the trial's? */
static bool keeps_areas(const sn_model_muscle *m, const sn_muscle_state *s) {
    for (sn_index r = 0; r < m->area_count; r++) {
        const sn_index *v = m->areas[r].point;
        if (s->guarded[r] && double_area(s->qn->trial, v) < AREA_LIMIT * double_area(s->points, v)) return false;
    }
    return true;
}

static void place_trial(const sn_model_muscle *m, sn_muscle_state *s, double length) {
    for (sn_index i = 0; i < m->point_count; i++) {
        s->qn->trial[i] = s->points[i];
        if (s->points[i].w > 0.0)
            set_position(&s->qn->trial[i], sn_add_scaled(sn_point_position(&s->points[i]), s->qn->direction[i], length));
    }
}

/* A length of the direction that lowers the energy enough; 0 = none. The trial and its gradient are there, s->energy is the new one. */
static double search(const sn_model_muscle *m, sn_muscle_state *s, double h, double slope) {
    sn_objective objective = objective_of(m, s, h);
    double length = 1.0, noise = ENERGY_NOISE * fabs(s->energy);
    for (int i = 0; i < MOST_HALVINGS; i++, length *= 0.5) {
        place_trial(m, s, length);
        if (keeps_areas(m, s)) {
            double energy = sn_objective_evaluate(&objective, s->qn->trial, s->qn->trial_gradient);
            bool lower = energy <= s->energy + ARMIJO * length * slope;
            bool flatter =
                energy <= s->energy + noise && fabs(dot(m->point_count, s->qn->trial_gradient, s->qn->direction)) <= 0.9 * -slope;
            if (lower || flatter) {
                s->energy = energy;
                return length;
            }
        }
        s->statistics.rejected_steps++;
    }
    return 0.0;
}

/* Of the muscle now, as far as its bones say, m. */
static double size_of(const sn_model_muscle *m, const sn_muscle_state *s) {
    if (m->kinematic_count == 0) return m->diagonal;
    sn_vec3 low = sn_point_position(&s->points[m->kinematic_points[0]]), high = low;
    for (sn_index k = 1; k < m->kinematic_count; k++) {
        sn_vec3 p = sn_point_position(&s->points[m->kinematic_points[k]]);
        low = sn_min3(low, p), high = sn_max3(high, p);
    }
    return fmax(m->diagonal, sn_distance(low, high));
}

/* A descent direction, not too long; the uncapped length of its longest step; negative = there is none. */
static double make_direction(const sn_model_muscle *m, sn_muscle_state *s, double *slope) {
    sn_vec3 *d = s->qn->direction;
    bool with_volume = true;
    for (int attempt = 0; attempt < 3; attempt++) {
        if (!find_direction(m, s)) return -1.0;
        *slope = dot(m->point_count, s->qn->gradient, d);
        if (*slope <= 0.0) break;
        forget_pairs(s); /* pairs from elsewhere mislead; and of a gradient that is all pressure the volume row leaves rounding */
        if (attempt == 1) sn_preconditioner_set_volume(s->qn->preconditioner, NULL, NULL);
        with_volume = attempt == 0;
    }
    if (!with_volume) set_volume_row(m, s, s->row_gradient);
    double most = longest(m->point_count, d), cap = STEP_CAP * size_of(m, s);
    if (!isfinite(most) || !(*slope <= 0.0)) return -1.0;
    if (most > cap) {
        for (sn_index i = 0; i < m->point_count; i++) d[i] = sn_scale(d[i], cap / most);
        *slope *= cap / most;
    }
    return most;
}

static void accept(const sn_model_muscle *m, sn_muscle_state *s, double length) {
    remember_pair(m, s, length);
    memcpy(s->points, s->qn->trial, (size_t)m->point_count * sizeof *s->points);
    memcpy(s->qn->gradient, s->qn->trial_gradient, (size_t)m->point_count * sizeof *s->qn->gradient);
}

static void stop(sn_muscle_state *s, sn_stop_reason reason) { s->statistics.stop_reason = s->stopped = reason; }

/* From here on the matrix has the volume row of these points. */
static void take_volume_gradient(const sn_model_muscle *m, sn_muscle_state *s) {
    if (m->keeps_volume) memcpy(s->row_gradient, s->volume_gradient, (size_t)m->vertex_count * sizeof *s->row_gradient);
    set_volume_row(m, s, s->row_gradient);
}

/* From here on the matrix is that of the muscle as it is torn: near a collapsed triangle the rest shape's is too soft by orders of
 * magnitude, and a step that is too long for one hinge is cut short for all of the muscle. */
static void take_matrix_here(const sn_model_muscle *m, sn_muscle_state *s, double h) {
    if (!sn_preconditioner_stand(s->qn->preconditioner, s->points, h, &s->stiffness)) stop(s, SN_STOP_FAILED);
    s->statistics.refactorisations++;
    take_volume_gradient(m, s);
}

/* The gradient is up to date before and after. */
static void iterate(const sn_model_muscle *m, sn_muscle_state *s, double h, sn_index iteration) {
    double slope = 0.0;
    s->statistics.iterations++;
    if (iteration > 0 && iteration % VOLUME_REFRESH == 0) take_volume_gradient(m, s);
    double most = make_direction(m, s, &slope);
    if (most < STEP_NOISE * m->diagonal) {
        stop(s, most < 0.0 ? SN_STOP_FAILED : SN_STOP_STALLED);
        return;
    }
    bool small = most <= m->tolerance * m->diagonal && iteration + 1 >= LEAST_ITERATIONS;
    double length = search(m, s, h, slope);
    if (length > 0.0) {
        accept(m, s, length);
        if (small) stop(s, SN_STOP_TOLERANCE);
    } else if (s->pair_count > 0) {
        forget_pairs(s); /* try again without them */
        sn_objective objective = objective_of(m, s, h);
        s->energy = sn_objective_evaluate(&objective, s->points, s->qn->gradient);
    } else {
        stop(s, SN_STOP_STALLED);
    }
}

/* ---- the start of a substep --------------------------------------------------------------------------------------------------- */

/* y = x + h (u + (v - u) e^(-c h)) + h^2 g for the free points, u the velocity of the bones there; previous = x. */
static void aim(const sn_model_muscle *m, sn_muscle_state *s, sn_vec3 gravity, double h) {
    double keep = sn_exp(-m->source->damping * h);
    for (sn_index i = 0; i < m->point_count; i++) {
        s->target[i] = s->previous[i] = sn_point_position(&s->points[i]);
        if (s->points[i].w == 0.0) continue;
        sn_vec3 v = sn_add_scaled(sn_damped_velocity(s, i, keep), gravity, h);
        s->target[i] = sn_add_scaled(s->previous[i], v, h);
    }
}

/* Speed of the fastest carried point over the last step, m/s. */
static double fastest_carried(const sn_model_muscle *m, const sn_muscle_state *s) {
    double most = 0.0;
    for (sn_index k = 0; k < m->kinematic_count; k++) most = fmax(most, sn_norm2(s->velocities[m->kinematic_points[k]]));
    return sqrt(most);
}

/* Put the carried points at their places; jump (point_count) is how far they came. Returns the longest way. */
static double place_carried(const sn_model_muscle *m, sn_muscle_state *s) {
    sn_kinematics_place(m, s);
    double most = 0.0;
    for (sn_index i = 0; i < m->point_count; i++) {
        s->qn->jump[i] = s->points[i].w == 0.0 ? sn_sub(sn_point_position(&s->points[i]), s->previous[i]) : sn_v3(0, 0, 0);
        most = fmax(most, sn_norm2(s->qn->jump[i]));
    }
    return sqrt(most);
}

/* How much farther or less far than in the last step a carried point comes: 0 where bones go on as they did. */
static double change_of_motion(const sn_model_muscle *m, const sn_muscle_state *s, double h) {
    double change = 0.0;
    for (sn_index k = 0; k < m->kinematic_count; k++) {
        sn_index i = m->kinematic_points[k];
        change = fmax(change, sn_distance(s->qn->jump[i], sn_scale(s->velocities[i], h)));
    }
    return change;
}

/* Where the predictor starts: everything where it was; or, where the carried points go on smoothly (as in the last step, to within an
 * edge), the free points where their velocity takes them (without the weight, which the muscle bears already or will). trial and jump are
 * then base and what is left of the way. */
static void choose_base(const sn_model_muscle *m, sn_muscle_state *s, double h, sn_vec3 weight, bool smooth) {
    for (sn_index i = 0; i < m->point_count; i++) {
        bool carried = s->points[i].w == 0.0;
        sn_vec3 jump = s->qn->jump[i], before = carried ? sn_scale(s->velocities[i], h) : sn_v3(0, 0, 0);
        sn_vec3 base = !smooth ? s->previous[i] : carried ? sn_add(s->previous[i], before) : sn_sub(s->target[i], weight);
        s->qn->trial[i] = s->points[i];
        set_position(&s->qn->trial[i], base);
        s->qn->jump[i] = smooth ? sn_sub(jump, before) : jump;
    }
}

/* d = -(A_ff + k_V g_f g_fT)^-1 (grad_f Phi(base) + A_fk jump + k_V g_f (g_k . jump)) takes the place of a first iteration: without it
 * fast bones crush the first ring of triangles (numerics.md 7). Leaves the predicted points in trial; false: no direction. */
static bool predict(const sn_model_muscle *m, sn_muscle_state *s, double h, sn_vec3 weight, bool smooth) {
    sn_qn *qn = s->qn;
    sn_objective objective = objective_of(m, s, h);
    double k_volume = volume_stiffness(m, s);
    choose_base(m, s, h, weight, smooth);
    sn_objective_evaluate(&objective, qn->trial, qn->gradient);
    sn_preconditioner_turn(qn->preconditioner, qn->trial);
    sn_preconditioner_add_jump(qn->preconditioner, qn->jump, s->volume_gradient, &k_volume, qn->gradient);
    set_volume_row(m, s, s->volume_gradient);
    if (!sn_preconditioner_apply(qn->preconditioner, qn->gradient, qn->direction)) return false;
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_vec3 base = sn_point_position(&qn->trial[i]);
        set_position(&qn->trial[i], s->points[i].w == 0.0 ? sn_point_position(&s->points[i]) : sn_sub(base, qn->direction[i]));
    }
    return true;
}

/* How the muscle stands where a step begins or ends. */
typedef struct condition {
    sn_index collapsed;  /* triangles below UNGUARDED of their rest area */
    sn_residual stretch; /* of the surface from its goal shape: edges over the mean edge, or strains */
} condition;

static sn_residual stretch_of(const sn_model_muscle *m, const sn_muscle_state *s) {
    return sn_rows_residual(m, s, sn_stretch_kind(m), NULL);
}

static condition condition_of(const sn_model_muscle *m, const sn_muscle_state *s) {
    condition now = {.stretch = stretch_of(m, s)};
    for (sn_index r = 0; r < m->area_count; r++)
        now.collapsed += !(double_area(s->points, m->areas[r].point) * m->area_scales[r] >= UNGUARDED);
    return now;
}

static bool is_stretched(const sn_residual *stretch, bool fast) {
    return stretch->max > (fast ? FAST_STRETCHED : FAR_STRETCHED) || stretch->rms > FAR_IN_THE_MEAN;
}

/* Marks the triangles that have a barrier: those that are not collapsed, and those whose barrier has held them so far. */
static void guard_triangles(const sn_model_muscle *m, sn_muscle_state *s) {
    for (sn_index r = 0; r < m->area_count; r++) {
        double ratio = double_area(s->points, m->areas[r].point) * m->area_scales[r];
        s->guarded[r] = ratio >= (s->guarded[r] ? STILL_GUARDED : UNGUARDED);
    }
}

/* May this be no shape that the muscle came to by moving: a tenth of it collapsed, half a mean edge off in the mean, or half of its volume
 * gone? */
static bool is_wrecked(const sn_model_muscle *m, const sn_muscle_state *s, const condition *now) {
    if (now->collapsed > m->area_count / 10 || now->stretch.rms > FAR_IN_THE_MEAN) return true;
    if (!m->keeps_volume) return false;
    double volume = sn_volume_constraint(m->vertex_count, s->points, m->triangle_count, m->triangles, NULL);
    return !(fabs(volume / (s->volume_goal * m->rest_volume) - 1.0) <= 0.5);
}

static void set_velocities(const sn_model_muscle *m, sn_muscle_state *s, double rate) {
    for (sn_index i = 0; i < m->point_count; i++)
        s->velocities[i] = sn_scale(sn_sub(sn_point_position(&s->points[i]), s->previous[i]), rate);
}

/* Phi at the state's points if they stood still. */
static double energy_at_rest(const sn_model_muscle *m, sn_muscle_state *s, double h) {
    sn_objective objective = objective_of(m, s, h);
    for (sn_index i = 0; i < m->point_count; i++) s->target[i] = sn_point_position(&s->points[i]);
    return sn_objective_evaluate(&objective, s->points, s->qn->gradient);
}

/* A wreck (coincident, flattened, random or mirrored points, a bone that has jumped far away) that holds more energy than the rest pose
 * carried along with the bones is given up for that, at rest: the way back from it is no motion, and it may lead into another wreck. */
static void restart(const sn_model_muscle *m, sn_muscle_state *s, double h) {
    size_t bytes = (size_t)m->point_count * sizeof *s->points;
    double wrecked = energy_at_rest(m, s, h);
    memcpy(s->qn->trial, s->points, bytes);
    sn_kinematics_carry(m, s, s->points);
    if (energy_at_rest(m, s, h) < wrecked) {
        memset(s->velocities, 0, (size_t)m->point_count * sizeof *s->velocities);
        s->bones = (sn_bone_motion){.rate = 0.0};
        forget_pairs(s);
        s->statistics.restarts++;
    } else {
        memcpy(s->points, s->qn->trial, bytes);
    }
}

/* Begin at the trial's points instead where the energy is lower there: energy and gradients are those of the state's points then. */
static void prefer_trial(const sn_model_muscle *m, sn_muscle_state *s, double h) {
    sn_qn *qn = s->qn;
    sn_objective objective = objective_of(m, s, h);
    double energy = sn_objective_evaluate(&objective, qn->trial, qn->trial_gradient);
    if (energy <= s->energy) {
        s->energy = energy;
        memcpy(s->points, qn->trial, (size_t)m->point_count * sizeof *s->points);
        memcpy(qn->gradient, qn->trial_gradient, (size_t)m->point_count * sizeof *qn->gradient);
    } else {
        sn_objective_evaluate(&objective, s->points, qn->gradient); /* for the gradient of the volume there */
    }
}

/* Begin where inertia takes the points, or at the predictor (in trial). */
static void choose_start(const sn_model_muscle *m, sn_muscle_state *s, double h, bool predicted) {
    sn_objective objective = objective_of(m, s, h);
    for (sn_index i = 0; i < m->point_count; i++)
        if (s->points[i].w > 0.0) set_position(&s->points[i], s->target[i]);
    s->energy = sn_objective_evaluate(&objective, s->points, s->qn->gradient);
    if (predicted) prefer_trial(m, s, h);
}

/* Of a muscle that is torn, inertia and the predictor may make a worse wreck: where it was may be better. */
static void try_staying(const sn_model_muscle *m, sn_muscle_state *s, double h) {
    for (sn_index i = 0; i < m->point_count; i++) {
        s->qn->trial[i] = s->points[i];
        if (s->points[i].w > 0.0) set_position(&s->qn->trial[i], s->previous[i]);
    }
    prefer_trial(m, s, h);
}

/* Bones that have gone far in one substep leave all of them torn: the rest pose carried along with them may be better. */
static void try_carried(const sn_model_muscle *m, sn_muscle_state *s, double h) {
    memcpy(s->qn->trial, s->points, (size_t)m->point_count * sizeof *s->points);
    sn_kinematics_carry(m, s, s->qn->trial);
    prefer_trial(m, s, h);
}

static bool is_torn(const sn_model_muscle *m, const sn_muscle_state *s, bool fast) {
    sn_residual stretch = stretch_of(m, s);
    return is_stretched(&stretch, fast);
}

/* Is the muscle torn at its start, or has a bone jumped? Then other starts are tried. */
static bool mend_start(const sn_model_muscle *m, sn_muscle_state *s, double h, double change, bool fast) {
    bool jumped = change > FAR * m->diagonal, torn = is_torn(m, s, fast);
    if (torn || jumped) try_staying(m, s, h);
    if (jumped) try_carried(m, s, h);
    return jumped || (torn && is_torn(m, s, fast));
}

/* The corotated and the two-level matrix are of use near the rest shape only: no collapsed triangle, no edge that is half a mean edge off
 * (numerics.md 7). */
static bool may_turn(const sn_model_muscle *m, const condition *now) {
    return (m->corotated || m->two_level) && now->collapsed == 0 && now->stretch.max <= 0.5;
}

/* The matrix that the substep goes by. */
static bool go_by(const sn_model_muscle *m, sn_muscle_state *s, double h, bool *changed) {
    sn_quat *turns = s->turned && m->corotated ? s->turns : NULL;
    return sn_preconditioner_update(s->qn->preconditioner, h, &s->stiffness, turns, &s->factor_stiffness, changed);
}

/* The coarse space of the two-level matrix, at these points from here to the end of the substep. */
static void place_sections(const sn_model_muscle *m, sn_muscle_state *s, double h) {
    if (!m->two_level) return;
    for (sn_index i = 0; i < m->point_count; i++) s->section_points[i] = sn_point_position(&s->points[i]);
    sn_preconditioner_correct(s->qn->preconditioner, s->turned ? s->section_points : NULL, h, &s->stiffness);
}

/* How the step begins: a wreck is given up; which matrix is at hand. */
static void look_around(const sn_model_muscle *m, sn_muscle_state *s, double h) {
    condition now = condition_of(m, s);
    guard_triangles(m, s);
    if (is_wrecked(m, s, &now)) {
        restart(m, s, h);
        now = condition_of(m, s);
        guard_triangles(m, s);
    }
    s->stretch_before = now.collapsed == 0 && !is_stretched(&now.stretch, false) ? now.stretch.max : INFINITY;
    s->turned = may_turn(m, &now);
}

/* The matrix for h and the stiffness now. */
static void take_matrix(const sn_model_muscle *m, sn_muscle_state *s, double h) {
    bool changed = false;
    if (s->turned && !go_by(m, s, h, &changed)) s->turned = false; /* free and stiff: to rounding it is singular */
    if (!s->turned && !go_by(m, s, h, &changed)) stop(s, SN_STOP_FAILED);
    if (changed || (s->turned && m->corotated)) forget_pairs(s); /* pairs from other frames mislead the corotated matrix */
    s->statistics.refactorisations += changed;
}

/* Does the step, as far as it has come, tear a muscle that was whole? */
static bool tears(const sn_model_muscle *m, const sn_muscle_state *s) {
    if (s->stretch_before == INFINITY) return false;
    condition now = condition_of(m, s);
    bool stretches = now.stretch.max > FAST_STRETCHED && now.stretch.max > 2.0 * s->stretch_before;
    return now.collapsed > 0 || stretches || now.stretch.rms > FAR_IN_THE_MEAN;
}

/* false: the step is too long. */
static bool begin(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep) {
    double h = substep->h;
    stop(s, SN_STOP_ITERATIONS);
    sn_preconditioner_correct(s->qn->preconditioner, NULL, h, &s->stiffness); /* the predictor goes by the scalar matrix */
    look_around(m, s, h);
    aim(m, s, substep->gravity, h);
    double jump = place_carried(m, s), change = change_of_motion(m, s, h);
    bool fast = fmax(jump, h * fastest_carried(m, s)) > FAST_EDGES * m->mean_edge;
    take_matrix(m, s, h);
    sn_vec3 weight = sn_scale(substep->gravity, h * h); /* how far it alone moves a free point */
    bool pushed = jump > 0.0 || (m->kinematic_count > 0 && sn_norm2(weight) > 0.0);
    bool predicted = pushed && s->stopped != SN_STOP_FAILED && predict(m, s, h, weight, change <= m->mean_edge);
    choose_start(m, s, h, predicted);
    s->abrupt = change > ABRUPT_EDGES * m->mean_edge;
    s->torn = mend_start(m, s, h, change, fast);
    bool far = change > FAR * m->diagonal && s->stretch_before < INFINITY;
    if (s->torn && substep->may_halve && jump <= m->diagonal && (far || tears(m, s))) return false;
    s->turned = s->turned && !s->torn;
    sn_preconditioner_turn(s->qn->preconditioner, s->points);
    place_sections(m, s, h);
    take_volume_gradient(m, s);
    return true;
}

/* In the middle of a substep: what `begin` has left, made again from the state. */
static void resume(const sn_model_muscle *m, sn_muscle_state *s, double h) {
    sn_objective objective = objective_of(m, s, h);
    bool changed;
    s->energy = sn_objective_evaluate(&objective, s->points, s->qn->gradient); /* the residual needs it, further iterations or not */
    if (s->stopped != SN_STOP_ITERATIONS) return;
    if (!go_by(m, s, h, &changed)) stop(s, SN_STOP_FAILED);
    if (m->two_level) sn_preconditioner_correct(s->qn->preconditioner, s->turned ? s->section_points : NULL, h, &s->stiffness);
    set_volume_row(m, s, s->row_gradient);
}

/* Velocities, until then those before the step: nor farther than once its length in a step. */
static void finish(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep) {
    double most = fmin(substep->rules->most_speed, 1.0 / substep->h) * m->diagonal;
    set_velocities(m, s, 1.0 / substep->h);
    sn_kinematics_watch_bones(m, s, substep->h, most);
    sn_kinematics_limit_speed(m, s, most);
}

/* ---- the back end ------------------------------------------------------------------------------------------------------------- */

/* As it was before the step; the velocities are still those. */
static void go_back(const sn_model_muscle *m, sn_muscle_state *s) {
    for (sn_index i = 0; i < m->point_count; i++) set_position(&s->points[i], s->previous[i]);
    forget_pairs(s);
}

static sn_verdict qn_substep(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep) {
    if (substep->begin > 0) {
        resume(m, s, substep->h);
    } else if (!begin(m, s, substep)) {
        go_back(m, s);
        return SN_STEP_REFUSED;
    }
    bool mends = s->torn && !substep->halved; /* of a step that was halved, that is to help */
    sn_index each = mends ? TORN_EFFORT : s->torn || s->abrupt ? ABRUPT_EFFORT : 1;
    for (sn_index i = each * substep->begin; i < each * substep->end && s->stopped == SN_STOP_ITERATIONS; i++) {
        if (mends && i % TORN_EFFORT == 0) take_matrix_here(m, s, substep->h);
        if (s->stopped == SN_STOP_ITERATIONS) iterate(m, s, substep->h, i);
    }
    double force = sqrt(dot(m->point_count, s->qn->gradient, s->qn->gradient));
    s->statistics.residual = s->stiffness > 0.0 ? force / (s->stiffness * m->diagonal) : NAN;
    if (substep->end < m->iterations) return SN_STEP_HOLDS;
    if (substep->may_halve && s->stopped == SN_STOP_ITERATIONS && tears(m, s)) {
        go_back(m, s);
        return SN_STEP_GIVEN_UP;
    }
    s->statistics.torn_substeps += s->torn;
    finish(m, s, substep);
    return SN_STEP_HOLDS;
}

static void qn_destroy(sn_muscle_state *s) {
    if (s->qn == NULL) return;
    sn_preconditioner_destroy(s->qn->preconditioner);
    free(s->qn->trial);
    free(s->qn->forces);
    free(s->qn->gradient);
    free(s->qn->trial_gradient);
    free(s->qn->direction);
    free(s->qn->jump);
    free(s->qn);
    s->qn = NULL;
}

static sn_status qn_create(const sn_model_muscle *m, sn_muscle_state *s, sn_error *error) {
    sn_qn *qn = s->qn = SN_NEW(sn_qn, 1);
    if (qn == NULL) return sn_fail_memory(error, "the quasi-Newton solver");
    qn->trial = SN_NEW(sn_point, m->point_count);
    qn->forces = SN_NEW(sn_point, m->point_count);
    qn->gradient = SN_NEW(sn_vec3, m->point_count);
    qn->trial_gradient = SN_NEW(sn_vec3, m->point_count);
    qn->direction = SN_NEW(sn_vec3, m->point_count);
    qn->jump = SN_NEW(sn_vec3, m->point_count);
    bool made = qn->trial != NULL && qn->gradient != NULL && qn->trial_gradient != NULL && qn->direction != NULL && qn->jump != NULL;
    made = made && qn->forces != NULL;
    return made ? sn_preconditioner_create(1, &m, &qn->preconditioner, error) : sn_fail_memory(error, "the quasi-Newton solver");
}

const sn_backend sn_backend_qn = {.name = "qn", .substep = qn_substep, .create = qn_create, .destroy = qn_destroy};
