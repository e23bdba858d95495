/*
 * plan.c -- what a muscle needs: groups of rows that run, the others with the reason why not, and the bytes.
 *
 * A group that is off must leave no trace: no rows, no points, no memory. So everything is decided here, before anything is allocated.
 */
#include "rows.h"

const char *sn_row_kind_name(sn_row_kind kind) {
    static const char *const NAMES[SN_ROW_KINDS] = {"internal", "radial", "mesh", "dihedral", "area", "membrane", "volume"};
    return NAMES[kind];
}

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
    case SN_OUT_NOTHING:
        return "no row is left: every point of it is carried by a bone, or degenerate";
    }
    return "";
}

static bool has_stiffness(const sn_scene_muscle *source, double factor) {
    return factor > 0.0 && (source->stiffness_relaxed > 0.0 || source->stiffness_active > 0.0);
}

static bool closed(const sn_topology *topology) {
    for (sn_index i = 0; i < topology->edge_count; i++)
        if (topology->edges[i].triangle_count != 2) return false;
    return topology->edge_count > 0;
}

static sn_left_out volume_reason(const sn_build *build) {
    double size = build->model->diagonal, volume = build->model->rest_volume;
    if (!closed(build->topology)) return SN_OUT_OPEN_SURFACE;
    if (!(fabs(volume) > 1e-12 * size * size * size)) return SN_OUT_FLAT;
    return has_stiffness(build->source, build->source->stiffness_volume) ? SN_RUNS : SN_OUT_NO_STIFFNESS;
}

void sn_plan_decide(const sn_build *build) {
    const sn_scene_muscle *source = build->source;
    sn_plan_group *groups = build->plan->groups;
    bool projects = build->scene->solver.method == SN_SOLVER_XPBD, membrane = source->stretch == SN_STRETCH_MEMBRANE;
    sn_left_out inside = source->rig.structure.sample_count == 0              ? SN_OUT_NO_STRUCTURE
                         : !has_stiffness(source, source->stiffness_internal) ? SN_OUT_NO_STIFFNESS
                                                                              : SN_RUNS;
    groups[SN_ROWS_INTERNAL].reason = groups[SN_ROWS_RADIAL].reason = inside;
    groups[SN_ROWS_MESH].reason = has_stiffness(source, 1.0) ? SN_RUNS : SN_OUT_NO_STIFFNESS;
    groups[SN_ROWS_DIHEDRAL].reason = has_stiffness(source, source->stiffness_dihedral) ? SN_RUNS : SN_OUT_NO_STIFFNESS;
    groups[SN_ROWS_AREA].reason = !(source->least_area > 0.0) ? SN_OUT_SETTING : groups[SN_ROWS_MESH].reason;
    groups[SN_ROWS_MEMBRANE].reason = membrane ? groups[SN_ROWS_MESH].reason : SN_OUT_SETTING;
    if (membrane && groups[SN_ROWS_MESH].reason == SN_RUNS) groups[SN_ROWS_MESH].reason = SN_OUT_MEMBRANE;
    groups[SN_ROWS_VOLUME].reason = volume_reason(build);
    for (int kind = 0; kind < SN_ROW_KINDS; kind++)
        if ((projects || kind != SN_ROWS_MEMBRANE) && sn_scheme_sweeps(build->scene->solver.scheme, (sn_row_kind)kind) == 0)
            groups[kind].reason = SN_OUT_SCHEME;
    inside = groups[SN_ROWS_INTERNAL].reason;
    build->plan->samples = inside == SN_RUNS ? source->rig.structure.sample_count : 0;
    build->plan->fibers = source->rig.fibers.directions != NULL;
}

/* Bytes of the arrays of a state, by the list that allocates them. */
static size_t state_bytes(const sn_model_muscle *m) {
    size_t bytes = sizeof(sn_muscle_state);
#define ADD(type, name, count, kept) bytes += (size_t)(count) * sizeof(type);
    SN_STATE_ARRAYS(ADD)
#undef ADD
    return bytes;
}

/* And of a model, without the curves. */
static size_t model_bytes(const sn_model_muscle *m) {
    size_t bytes = sizeof(*m);
#define ADD(type, name, count, nullable, fitted) bytes += nullable && m->name == NULL ? 0 : (size_t)(count) * sizeof(type);
    SN_MODEL_ARRAYS(ADD)
#undef ADD
    return bytes;
}

/* Bytes of one row of a kind in the model; of an array that is NULL there are none. */
static size_t row_bytes(const sn_model_muscle *m, sn_row_kind kind) {
    const void *extra[] = {m->distance_softness, m->distance_gain, m->distance_share};
    size_t bytes = 0;
    switch (kind) {
    case SN_ROWS_DIHEDRAL:
        return sizeof(sn_hinge_row) + (m->hinge_softness != NULL ? 2 : 1) * sizeof(double);
    case SN_ROWS_AREA:
        return sizeof(sn_area_row) + sizeof(double);
    case SN_ROWS_MEMBRANE:
        return sizeof(sn_area_row) + sizeof(sn_membrane_row);
    case SN_ROWS_VOLUME:
        return 0;
    default:
        for (int i = 0; i < 3; i++) bytes += extra[i] != NULL ? sizeof(double) : 0;
        return bytes + sizeof(sn_distance_row) + sizeof(*m->distance_terms);
    }
}

/* And in the state: goal and lambda; the gradient of the volume. */
static size_t row_state_bytes(const sn_model_muscle *m, sn_row_kind kind) {
    if (kind < SN_DISTANCE_KINDS) return 2 * sizeof(double);
    if (kind == SN_ROWS_DIHEDRAL) return sizeof(double);
    if (kind == SN_ROWS_MEMBRANE) return SN_MEMBRANE_GOALS * sizeof(double);
    return kind == SN_ROWS_VOLUME ? (size_t)m->vertex_count * sizeof(sn_vec3) : 0;
}

/* XPBD feels a stiffness only where k h^2 w is not far above 1 (numerics.md 1). */
static void measure_rigidity(const sn_build *build, sn_row_kind kind) {
    const sn_scene_muscle *source = build->source;
    double h = 1.0 / (build->scene->rate * sn_solver_substeps(&build->scene->solver));
    double factor = (kind == SN_ROWS_MESH ? 1.0 : source->stiffness_internal) * h * h * build->model->point_count / build->model->mass;
    build->plan->groups[kind].rigidity[0] = factor * source->stiffness_relaxed;
    build->plan->groups[kind].rigidity[1] = factor * source->stiffness_active;
}

void sn_plan_count(const sn_build *build) {
    const sn_model_muscle *m = build->model;
    sn_plan_group *groups = build->plan->groups;
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        if (groups[kind].reason == SN_RUNS && groups[kind].rows == 0) groups[kind].reason = SN_OUT_NOTHING;
        groups[kind].sweeps = sn_scheme_sweeps(build->scene->solver.scheme, (sn_row_kind)kind);
        size_t row = row_bytes(m, (sn_row_kind)kind) + row_state_bytes(m, (sn_row_kind)kind);
        groups[kind].bytes = (size_t)groups[kind].rows * row;
        if (kind < SN_DISTANCE_KINDS && groups[kind].rows > 0) measure_rigidity(build, (sn_row_kind)kind);
    }
    build->plan->model_bytes = model_bytes(m);
    build->plan->state_bytes = state_bytes(m);
}
