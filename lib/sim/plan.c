/*
 * plan.c -- what a muscle needs: groups of rows that run, the others with the reason why not, and the bytes.
 *
 * A group that is off must leave no trace: no rows, no points, no memory. So everything is decided here, before anything is allocated.
 */
#include "rows.h"

const char *sn_stop_reason_name(sn_stop_reason reason) {
    static const char *const names[] = {"iterations", "tolerance", "stalled", "failed"};
    return names[reason];
}

const char *sn_left_out_text(sn_left_out reason) {
    switch (reason) {
    case SN_RUNS:
        return "";
    case SN_OUT_NO_STIFFNESS:
        return "its stiffness is 0";
    case SN_OUT_SETTING:
        return "the scene switches it off";
    case SN_OUT_SCHEME:
        return "the scheme has no such constraint";
    case SN_OUT_MEMBRANE:
        return "the membrane takes its place";
    case SN_OUT_NO_STRUCTURE:
        return "the document has no internal structure (build-structure makes one)";
    case SN_OUT_OPEN_SURFACE:
        return "the surface is open and encloses no volume (mesh-clean closes it)";
    case SN_OUT_FLAT:
        return "the rest volume is 0";
    case SN_OUT_NO_BONE:
        return "no bone comes near it over the motion";
    case SN_OUT_NO_TARGET:
        return "no candidate of the document ties it to what takes part (attach-detect --glue finds them)";
    case SN_OUT_NOTHING:
        return "no row is left: every point of it is carried by a bone, or degenerate";
    }
    return "";
}

void sn_plan_decide(const sn_build *build) {
    const sn_scene_muscle *source = build->source;
    bool projects = build->scene->solver.method == SN_SOLVER_XPBD;
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        sn_left_out *reason = &build->plan->groups[kind].reason;
        const sn_row_ops *ops = sn_row_ops_of((sn_row_kind)kind);
        bool swept = sn_scheme_sweeps(&build->scene->solver, (sn_row_kind)kind) > 0 && (!build->model->single || ops->sweep_single != NULL);
        *reason = ops->reason(build);
        if (projects && !swept) *reason = SN_OUT_SCHEME;
    }
    build->plan->samples = build->plan->groups[SN_ROWS_INTERNAL].reason == SN_RUNS ? source->rig.structure.sample_count : 0;
    build->plan->fibers = source->rig.fibers.directions != NULL;
}

/* Bytes of the arrays of a model, by the list that allocates them, without the curves. */
static size_t model_bytes(const sn_model_muscle *m) {
    size_t bytes = sizeof(*m);
#define ADD(type, name, count, nullable, fitted) bytes += nullable && m->name == NULL ? 0 : (size_t)(count) * sizeof(type);
    SN_MODEL_ARRAYS(ADD)
#undef ADD
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        const sn_row_ops *ops = sn_row_ops_of((sn_row_kind)kind);
        if (ops->own_bytes != NULL) bytes += ops->own_bytes(m, (sn_row_kind)kind);
    }
    return bytes;
}

/* XPBD feels a stiffness only where k h^2 w is not far above 1 (numerics.md 1). */
static void measure_rigidity(const sn_build *build, sn_row_kind kind) {
    const sn_scene_muscle *source = build->source;
    const sn_row_ops *ops = sn_row_ops_of(kind);
    double h = 1.0 / (build->scene->rate * sn_solver_substeps(&build->scene->solver));
    double factor = (ops->factor != NULL ? ops->factor(source) : 1.0) * h * h * build->model->point_count / build->model->mass;
    build->plan->groups[kind].rigidity[0] = factor * source->stiffness_relaxed;
    build->plan->groups[kind].rigidity[1] = factor * source->stiffness_active;
}

void sn_plan_count(const sn_build *build) {
    const sn_model_muscle *m = build->model;
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        sn_plan_group *group = &build->plan->groups[kind];
        const sn_row_ops *ops = sn_row_ops_of((sn_row_kind)kind);
        if (group->reason == SN_RUNS && group->rows == 0 && !ops->shared) group->reason = SN_OUT_NOTHING; /* shared: still to be built */
        group->sweeps = sn_scheme_sweeps(&build->scene->solver, (sn_row_kind)kind);
        group->bytes = (size_t)group->rows * ops->bytes(m);
        if (ops->info.spring && group->rows > 0) measure_rigidity(build, (sn_row_kind)kind);
    }
    build->plan->model_bytes = model_bytes(m);
}
