/*
 * qn.c -- back end `qn`: implicit Euler by quasi-Newton.   Liu, Bouaziz, Kavan 2017; numerics.md 2, 7
 *
 * A step minimises Phi(x) (energy.c) from a predictor (qn_start.c): L-BFGS on top of a factored matrix of the rest shapes (precondition.c)
 * gives a direction, Armijo's rule its length. Pairs are kept from step to step, but not under the corotated matrix. A step ends when a
 * whole step of the search would move no point by more than the tolerance, when no step lowers the energy any more, or after its
 * iterations.
 */
#include "contact.h"
#include "external.h"
#include "qn.h"
#include "skin.h"

static const double ARMIJO = 1e-4;
static const int MOST_HALVINGS = 30;
/* What energies differ by for no other reason than rounding, as a share of them; there the slope decides (Hager and Zhang 2005). */
static const double ENERGY_NOISE = 1e-13;
/* A whole step that moves no point by more than this share of the diagonal is rounding. */
static const double STEP_NOISE = 1e-14;
/* No point moves further than this share of the muscle's size in one iteration: of its diagonal, or of how far its bones are apart. */
static const double STEP_CAP = 0.1;
/* Iterations of a torn step, and of one whose bones set out or stop, for each that the scene allows; and of muscles that are tied to each
 * other, whose matrix knows nothing of the way that a constraint leaves free: of twelve muscles of a dog's hind leg the median error over a
 * motion is 1.3e-3 L after 10 iterations and 6e-4 after 20. */
enum { TORN_EFFORT = 10, ABRUPT_EFFORT = 2 };
/* No triangle shrinks below this share of its area in one step: hinges have no barrier against collapse. */
static const double AREA_LIMIT = 0.3;
/* Iterations after which the volume row of the matrix is made for the points at hand: L-BFGS learns how it turns, up to a point. */
enum { VOLUME_REFRESH = 8 };
/* One iteration alone may fall into a wrong basin. */
enum { LEAST_ITERATIONS = 3 };
/* A pair whose step and change are nearly orthogonal says nothing about curvature. */
static const double LEAST_CURVATURE = 1e-10;

/* ---- vectors of points ---------------------------------------------------------------------------------------------------- */

/* In four sums, so that none waits for the one before it. */
static double dot(sn_index n, const sn_vec3 *a, const sn_vec3 *b) {
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    sn_index i = 0;
    for (; i + 4 <= n; i += 4)
        for (sn_index lane = 0; lane < 4; lane++) sum[lane] += sn_dot(a[i + lane], b[i + lane]);
    for (; i < n; i++) sum[0] += sn_dot(a[i], b[i]);
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

static void add_scaled(sn_index n, sn_vec3 *sum, const sn_vec3 *a, double scale) {
    for (sn_index i = 0; i < n; i++) sum[i] = sn_add_scaled(sum[i], a[i], scale);
}

static double longest(sn_index n, const sn_vec3 *a) {
    double most = 0.0;
    for (sn_index i = 0; i < n; i++) most = fmax(most, sn_norm2(a[i]));
    return sqrt(most);
}

/* ---- L-BFGS ----------------------------------------------------------------------------------------------------------------- */

/* The slot of the pair `age` pairs ago; 0 is the latest. */
static size_t slot_of(const sn_qn *qn, sn_index age) { return (size_t)((qn->pair_next + SN_QN_MEMORY - 1 - age) % SN_QN_MEMORY); }

static void remember_pair(sn_index count, sn_qn *qn, double length) {
    size_t n = (size_t)count, slot = (size_t)qn->pair_next;
    sn_vec3 *step = qn->pair_steps + slot * n, *change = qn->pair_changes + slot * n;
    for (size_t i = 0; i < n; i++) {
        step[i] = sn_scale(qn->direction[i], length);
        change[i] = sn_sub(qn->trial_gradient[i], qn->gradient[i]);
    }
    double product = dot(count, step, change);
    double size = sqrt(dot(count, step, step) * dot(count, change, change));
    if (!(product > LEAST_CURVATURE * size)) return;
    qn->pair_products[slot] = product;
    qn->pair_next = (qn->pair_next + 1) % SN_QN_MEMORY;
    if (qn->pair_count < SN_QN_MEMORY) qn->pair_count++;
}

/* direction = -H gradient by the two-loop recursion; false where the matrix could not be solved. */
static bool find_direction(sn_index n, sn_qn *qn) {
    sn_vec3 *d = qn->direction;
    double weight[SN_QN_MEMORY];
    for (sn_index i = 0; i < n; i++) d[i] = sn_neg(qn->gradient[i]);
    for (sn_index age = 0; age < qn->pair_count; age++) {
        size_t slot = slot_of(qn, age);
        weight[age] = dot(n, qn->pair_steps + slot * (size_t)n, d) / qn->pair_products[slot];
        add_scaled(n, d, qn->pair_changes + slot * (size_t)n, -weight[age]);
    }
    if (!sn_preconditioner_apply(qn->preconditioner, d, d)) return false;
    for (sn_index age = qn->pair_count; age-- > 0;) {
        size_t slot = slot_of(qn, age);
        double along = dot(n, qn->pair_changes + slot * (size_t)n, d) / qn->pair_products[slot];
        add_scaled(n, d, qn->pair_steps + slot * (size_t)n, weight[age] - along);
    }
    return true;
}

/* ---- one iteration ------------------------------------------------------------------------------------------------------------ */

/* Does no triangle of a member shrink too much from its points to those of the trial? */
static bool keeps_areas(const sn_model_muscle *m, const sn_muscle_state *s, const sn_point *trial) {
    const bool *guarded = s->inputs->guarded;
    for (sn_index r = 0; r < m->area_count; r++) {
        const sn_index *v = m->areas[r].point;
        if (guarded[r] && sn_qn_double_area(trial, v) < AREA_LIMIT * sn_qn_double_area(s->points, v)) return false;
    }
    return true;
}

/* Members without a skin, whose areas are looked at before the trial is evaluated; those with one know them afterwards. */
static bool others_keep_areas(const sn_group *g, const sn_group_state *s) {
    bool keep = true;
    for (sn_index i = 0; keep && i < g->count; i++)
        if (g->members[i]->skin_edge_count == 0) keep = keeps_areas(g->members[i], s->members[i], sn_qn_of(s)->trial + g->first[i]);
    return keep;
}

static bool skins_keep_areas(const sn_group *g, const sn_group_state *s) {
    bool keep = true;
    for (sn_index i = 0; keep && i < g->count; i++)
        if (g->members[i]->skin_edge_count > 0) keep = sn_skin_keeps_areas(g->members[i], s->members[i], AREA_LIMIT);
    return keep;
}

static void place_trial(const sn_group *g, const sn_group_state *s, double length) {
    const sn_qn *qn = sn_qn_of(s);
    for (sn_index i = 0; i < g->point_count; i++) {
        qn->trial[i] = s->points[i];
        if (s->points[i].w > 0.0) sn_put(&qn->trial[i], sn_add_scaled(sn_point_position(&s->points[i]), qn->direction[i], length));
    }
}

/* Is the energy of the trial low enough, or is it the same to rounding and the slope there less? */
static bool is_lower(const sn_group *g, const sn_qn *qn, double energy, double length, double slope) {
    if (energy <= qn->energy + ARMIJO * length * slope) return true;
    return energy <= qn->energy + ENERGY_NOISE * fabs(qn->energy) &&
           fabs(dot(g->point_count, qn->trial_gradient, qn->direction)) <= 0.9 * -slope;
}

/* A length of the direction that lowers the energy enough; 0 = none. The trial and its gradient are there, the energy is the new one. */
static double search(const sn_group *g, sn_group_state *s, double h, double slope) {
    sn_qn *qn = sn_qn_of(s);
    const sn_objective objective = {g, s, h};
    double length = 1.0;
    for (sn_index k = 0; k < g->count; k++) sn_skin_keep(g->members[k], s->members[k]); /* the points were evaluated last */
    for (int i = 0; i < MOST_HALVINGS; i++, length *= 0.5) {
        place_trial(g, s, length);
        if (others_keep_areas(g, s)) {
            double energy = sn_objective_evaluate(&objective, qn->trial, qn->trial_gradient);
            if (skins_keep_areas(g, s) && is_lower(g, qn, energy, length, slope)) {
                qn->energy = energy;
                return length;
            }
        }
        for (sn_index k = 0; k < g->count; k++) s->members[k]->statistics.rejected_steps++;
    }
    return 0.0;
}

/* Of a muscle now, as far as its bones say, m. */
static double size_of(const sn_model_muscle *m, const sn_muscle_state *s) {
    if (m->kinematic_count == 0) return m->diagonal;
    sn_vec3 low = sn_point_position(&s->points[m->kinematic_points[0]]), high = low;
    for (sn_index k = 1; k < m->kinematic_count; k++) {
        sn_vec3 p = sn_point_position(&s->points[m->kinematic_points[k]]);
        low = sn_min3(low, p), high = sn_max3(high, p);
    }
    return fmax(m->diagonal, sn_distance(low, high));
}

/* The way of each member's point that goes farthest, and by how much the direction is to be shortened for all of them. Not finite: there is
 * no direction. */
static double measure_direction(const sn_group *g, sn_group_state *s) {
    sn_qn *qn = sn_qn_of(s);
    double share = 1.0;
    for (sn_index i = 0; i < g->count; i++) {
        const sn_model_muscle *m = g->members[i];
        double most = qn->longest[i] = longest(m->point_count, qn->direction + g->first[i]), cap = STEP_CAP * size_of(m, s->members[i]);
        if (!isfinite(most)) return NAN;
        if (most > cap) share = fmin(share, cap / most);
    }
    return share;
}

/* Does a whole step move no point of any member by more than its tolerance? */
static bool is_small(const sn_group *g, const sn_qn *qn) {
    bool small = true;
    for (sn_index i = 0; i < g->count; i++) small = small && qn->longest[i] <= g->members[i]->tolerance * g->members[i]->diagonal;
    return small;
}

static bool is_noise(const sn_group *g, const sn_qn *qn) {
    bool noise = true;
    for (sn_index i = 0; i < g->count; i++) noise = noise && qn->longest[i] < STEP_NOISE * g->members[i]->diagonal;
    return noise;
}

/* A descent direction, not too long; false = there is none. */
static bool make_direction(const sn_group *g, sn_group_state *s, double *slope) {
    sn_qn *qn = sn_qn_of(s);
    bool with_volume = true;
    for (int attempt = 0; attempt < 3; attempt++) {
        if (!find_direction(g->point_count, qn)) return false;
        *slope = dot(g->point_count, qn->gradient, qn->direction);
        if (*slope <= 0.0) break;
        sn_qn_forget_pairs(qn); /* pairs from elsewhere mislead; and of a gradient that is all pressure the volume row leaves rounding */
        if (attempt == 1) sn_preconditioner_set_volume(qn->preconditioner, NULL, NULL);
        with_volume = attempt == 0;
    }
    if (!with_volume) sn_qn_set_volume_rows(qn, qn->row_gradient);
    double share = measure_direction(g, s);
    if (!isfinite(share) || !(*slope <= 0.0)) return false;
    for (sn_index i = 0; share < 1.0 && i < g->point_count; i++) qn->direction[i] = sn_scale(qn->direction[i], share);
    *slope *= share;
    return true;
}

static void accept(const sn_group *g, sn_group_state *s, double length) {
    sn_qn *qn = sn_qn_of(s);
    remember_pair(g->point_count, qn, length);
    memcpy(s->points, qn->trial, (size_t)g->point_count * sizeof *s->points);
    memcpy(qn->gradient, qn->trial_gradient, (size_t)g->point_count * sizeof *qn->gradient);
}

/* The gradient is up to date before and after. */
static void search_once(const sn_group *g, sn_group_state *s, double h, sn_index iteration) {
    sn_qn *qn = sn_qn_of(s);
    double slope = 0.0;
    for (sn_index i = 0; i < g->count; i++) s->members[i]->statistics.iterations++;
    if (iteration > 0 && iteration % VOLUME_REFRESH == 0) sn_qn_take_volume_gradient(g, s);
    bool descends = make_direction(g, s, &slope);
    if (!descends || is_noise(g, qn)) {
        sn_qn_stop(s, g, descends ? SN_STOP_STALLED : SN_STOP_FAILED);
        return;
    }
    bool small = is_small(g, qn) && iteration + 1 >= LEAST_ITERATIONS;
    double length = search(g, s, h, slope);
    if (length > 0.0) {
        accept(g, s, length);
        if (small) sn_qn_stop(s, g, SN_STOP_TOLERANCE);
    } else if (qn->pair_count > 0) {
        sn_qn_forget_pairs(qn); /* try again without them */
        qn->energy = sn_objective_evaluate(&(sn_objective){g, s, h}, s->points, qn->gradient);
    } else {
        sn_qn_stop(s, g, SN_STOP_STALLED);
    }
}

/* ---- the stages of a step --------------------------------------------------------------------------------------------------------- */

static sn_verdict start(const sn_group *g, sn_group_state *s, const sn_substep *substep) {
    if (sn_qn_start(g, s, substep)) return SN_STEP_HOLDS;
    sn_qn_go_back(g, s);
    return SN_STEP_REFUSED;
}

static void resume(const sn_group *g, sn_group_state *s, const sn_substep *substep) { sn_qn_resume(g, s, substep); }

/* |dPhi/dx| / (k L) of each member. */
static void leave_residuals(const sn_group *g, sn_group_state *s) {
    const sn_vec3 *gradient = sn_qn_of(s)->gradient;
    for (sn_index i = 0; i < g->count; i++) {
        sn_muscle_state *muscle = s->members[i];
        double k = muscle->inputs->stiffness;
        sn_index n = g->members[i]->point_count;
        double force = sqrt(dot(n, gradient + g->first[i], gradient + g->first[i]));
        muscle->statistics.residual = k > 0.0 ? force / (k * g->members[i]->diagonal) : NAN;
    }
}

static void iterate(const sn_group *g, sn_group_state *s, const sn_substep *substep) {
    sn_qn *qn = sn_qn_of(s);
    bool mends = qn->torn && !substep->halved && !g->large; /* of a step that was halved, that is to help */
    sn_index each = mends ? TORN_EFFORT : qn->torn || qn->abrupt || g->count > 1 ? ABRUPT_EFFORT : 1;
    for (sn_index i = each * substep->begin; i < each * substep->end && qn->stopped == SN_STOP_ITERATIONS; i++) {
        if (mends && i % TORN_EFFORT == 0) sn_qn_take_matrix_here(g, s, substep->h);
        if (qn->stopped == SN_STOP_ITERATIONS) search_once(g, s, substep->h, i);
    }
    leave_residuals(g, s);
}

/* Until here the velocities are those before the step: nor farther than once its length in a step. */
static void update_velocities(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep) {
    double rate = 1.0 / substep->h, most = fmin(substep->rules->most_speed, rate) * m->diagonal;
    for (sn_index i = 0; i < m->point_count; i++)
        s->velocities[i] = sn_scale(sn_sub(sn_point_position(&s->points[i]), s->previous[i]), rate);
    sn_kinematics_watch_bones(m, s, substep->h, most);
    sn_kinematics_limit_speed(m, s, most);
}

/* Pairs of another set of contacts mislead. */
static const double MOST_CHANGED = 0.1;

static void settle_contacts(const sn_model_muscle *m, sn_muscle_state *s, sn_qn *qn) {
    if (sn_contacts_update(m, s, s->inputs->stiffness) > MOST_CHANGED) sn_qn_forget_pairs(qn);
    sn_contacts_finish(m, s);
}

static sn_verdict finish(const sn_group *g, sn_group_state *s, const sn_substep *substep) {
    const sn_qn *qn = sn_qn_of(s);
    if (substep->may_halve && qn->stopped == SN_STOP_ITERATIONS && sn_qn_tears(g, s)) {
        sn_qn_go_back(g, s);
        return SN_STEP_GIVEN_UP;
    }
    for (sn_index i = 0; i < g->count; i++) {
        s->members[i]->statistics.torn_substeps += qn->torn && (g->count == 1 || sn_qn_is_torn(g, s, i, false));
        settle_contacts(g->members[i], s->members[i], sn_qn_of(s));
        update_velocities(g->members[i], s->members[i], substep);
    }
    sn_externals_keep(g, s);
    return SN_STEP_HOLDS;
}

static void rest(sn_group_state *s) { sn_qn_forget_pairs(sn_qn_of(s)); }

/* ---- memory --------------------------------------------------------------------------------------------------------------------- */

static sn_status create(const sn_group *g, sn_group_state *s, bool kept_only, sn_error *error) {
    sn_qn *part = s->memory = SN_NEW(sn_qn, 1);
    bool made = part != NULL;
    if (!made) return sn_fail_memory(error, "the quasi-Newton solver");
    SN_QN_ARRAYS(SN_MAKE_ARRAY)
    SN_QN_PAIR_ARRAYS(SN_MAKE_ARRAY)
    if (!made) return sn_fail_memory(error, "the quasi-Newton solver");
    if (kept_only) return SN_OK;
    for (sn_index i = 0; g->keeps_volume && i < g->count; i++) s->members[i]->inputs->volume_gradient = part->volume_gradient + g->first[i];
    sn_status status = sn_preconditioner_create(g->count, g->members, &part->preconditioner, error);
    return status == SN_OK ? sn_preconditioner_couple(part->preconditioner, g, error) : status;
}

static void destroy(const sn_group *g, sn_group_state *s) {
    sn_qn *part = sn_qn_of(s);
    (void)g;
    if (part == NULL) return;
    sn_preconditioner_destroy(part->preconditioner);
    SN_QN_ARRAYS(SN_FREE_ARRAY)
    SN_QN_PAIR_ARRAYS(SN_FREE_ARRAY)
    free(part);
}

static void reset(const sn_group *g, sn_group_state *s) {
    sn_qn *qn = sn_qn_of(s);
    sn_qn_forget_pairs(qn);
    for (sn_index i = 0; i < g->count; i++) qn->factor_stiffness[i] = NAN;
    qn->stopped = SN_STOP_ITERATIONS;
    qn->turned = qn->torn = qn->abrupt = false;
    qn->stretch_before = 0.0;
}

static size_t bytes_of(const sn_group *g) {
    size_t bytes = sizeof(sn_qn);
    SN_QN_ARRAYS(SN_ADD_BYTES)
    SN_QN_PAIR_ARRAYS(SN_ADD_BYTES)
    return bytes;
}

#define KEPT_NUMBERS(X)                                                                                                                    \
    X(energy, true)                                /* found anew before it is read */                                                      \
    X(stretch_before, part->stretch_before >= 0.0) /* infinite: torn already */                                                            \
    X(abrupt, sn_sound_flag(&part->abrupt))                                                                                                \
    X(pair_count, part->pair_count >= 0 && part->pair_count <= SN_QN_MEMORY)                                                               \
    X(pair_next,                                                                                                                           \
      part->pair_count < SN_QN_MEMORY ? part->pair_next == part->pair_count : part->pair_next >= 0 && part->pair_next < SN_QN_MEMORY)      \
    X(stopped, part->stopped >= SN_STOP_ITERATIONS && part->stopped <= SN_STOP_FAILED)                                                     \
    X(turned, sn_sound_flag(&part->turned) && (g->corotated || g->two_level || !part->turned))                                             \
    X(torn, sn_sound_flag(&part->torn) && (!part->torn || !part->turned))

static void pass_numbers(sn_cursor *c, const sn_group *g, sn_group_state *s) {
    sn_qn *part = sn_qn_of(s);
    (void)g;
    KEPT_NUMBERS(SN_PASS_NUMBER)
}

static void pass_arrays(sn_cursor *c, const sn_group *g, sn_group_state *s) {
    sn_qn *part = sn_qn_of(s);
    SN_QN_ARRAYS(SN_PASS_ARRAY)
    SN_QN_PAIR_ARRAYS(SN_PASS_ARRAY)
}

/* Pairs at hand are finite, and L-BFGS divides by their products. */
static const char *pairs_fault(const sn_group *g, const sn_qn *qn) {
    size_t n = (size_t)g->point_count * (size_t)qn->pair_count;
    if (!sn_sound_vectors(qn->pair_steps, n)) return "pair_steps";
    if (!sn_sound_vectors(qn->pair_changes, n)) return "pair_changes";
    for (sn_index i = 0; i < qn->pair_count; i++)
        if (!(qn->pair_products[i] > 0.0) || !isfinite(qn->pair_products[i])) return "pair_products";
    for (sn_index i = 0; i < g->count; i++)
        if (!isnan(qn->factor_stiffness[i]) && !(qn->factor_stiffness[i] >= 0.0 && isfinite(qn->factor_stiffness[i])))
            return "factor_stiffness";
    return NULL;
}

/* A matrix that turns with a muscle has frames; none where no point of it is free. */
static bool has_turned(const sn_group *g, const sn_qn *qn) {
    for (sn_index k = 0; qn->turned && g->corotated && k < g->count; k++) {
        if (g->members[k]->kinematic_count >= g->members[k]->point_count) continue;
        for (sn_index i = g->first[k]; i < g->first[k + 1]; i++)
            if (!sn_sound_unit(qn->turns[i])) return false;
    }
    return true;
}

static const char *fault(const sn_group *g, const sn_group_state *s) {
    const sn_qn *part = sn_qn_of(s);
    KEPT_NUMBERS(SN_CHECK_NUMBER)
    SN_QN_ARRAYS(SN_CHECK_ARRAY)
    const char *pairs = pairs_fault(g, part);
    return pairs != NULL ? pairs : has_turned(g, part) ? NULL : "turns";
}

static void take(const sn_group *g, const sn_group_state *from, sn_group_state *s) {
    const sn_qn *read = sn_qn_of(from);
    sn_qn *part = sn_qn_of(s);
    KEPT_NUMBERS(SN_TAKE_NUMBER)
    SN_QN_ARRAYS(SN_TAKE_ARRAY)
    SN_QN_PAIR_ARRAYS(SN_TAKE_ARRAY)
    sn_qn_stop(s, g, part->stopped);
}

const sn_backend sn_backend_qn = {.name = "qn",
                                  .start = start,
                                  .resume = resume,
                                  .iterate = iterate,
                                  .finish = finish,
                                  .rest = rest,
                                  .create = create,
                                  .destroy = destroy,
                                  .reset = reset,
                                  .bytes = bytes_of,
                                  .pass_numbers = pass_numbers,
                                  .pass_arrays = pass_arrays,
                                  .fault = fault,
                                  .take = take};
