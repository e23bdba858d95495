/*
 * model.c -- from a scene to the model: points, masses, and the constraint table, built once.
 */
#include "contact.h"
#include "skin.h"

#include <stdlib.h>

/* ---- points --------------------------------------------------------------------------------------------------------------- */

static sn_status copy_points(const sn_build *build, sn_error *error) {
    const sn_muscle *rig = &build->source->rig;
    sn_model_muscle *m = build->model;
    m->point_count = m->vertex_count + build->plan->samples;
    m->rest = SN_NEW(sn_vec3, m->point_count);
    m->inverse_mass = SN_NEW(double, m->point_count);
    if (m->rest == NULL || m->inverse_mass == NULL) return sn_fail_memory(error, "points");
    for (sn_index i = 0; i < m->vertex_count; i++) m->rest[i] = sn_scale(rig->mesh.positions[i], rig->meters_per_unit);
    for (sn_index i = m->vertex_count; i < m->point_count; i++)
        m->rest[i] = sn_scale(rig->structure.positions[m->samples[i - m->vertex_count]], rig->meters_per_unit);
    return SN_OK;
}

static sn_status copy_triangles(const sn_build *build, sn_error *error) {
    const sn_mesh *mesh = &build->source->rig.mesh;
    sn_model_muscle *m = build->model;
    m->triangle_count = mesh->triangle_count;
    m->triangles = SN_NEW(sn_triangle, m->triangle_count);
    m->rest_area = SN_NEW(double, m->triangle_count);
    if (m->triangles == NULL || m->rest_area == NULL) return sn_fail_memory(error, "triangles");
    for (sn_index t = 0; t < m->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        m->triangles[t] = mesh->triangles[t];
        m->rest_area[t] = 0.5 * sn_norm(sn_area_vector(m->rest[v[0]], m->rest[v[1]], m->rest[v[2]]));
    }
    return SN_OK;
}

static void measure_size(const sn_build *build) {
    const sn_muscle *rig = &build->source->rig;
    sn_model_muscle *m = build->model;
    double unit = rig->meters_per_unit;
    m->diagonal = sn_box_diagonal(sn_mesh_box(&rig->mesh)) * unit;
    m->mean_edge = sn_mesh_mean_edge(&rig->mesh, build->topology) * unit;
    m->rest_volume = sn_mesh_volume(&rig->mesh) * unit * unit * unit;
}

/* ---- masses --------------------------------------------------------------------------------------------------------------- */

/* A vertex with less than this share of the mean mass is given it: an unused vertex would have none. */
static const double LEAST_MASS = 1e-2;

/* Density times volume; a sheet without volume is taken as a layer of a thousandth of its mean edge. */
static double total_mass(const sn_model_muscle *m, double density) {
    double area = 0.0;
    for (sn_index t = 0; t < m->triangle_count; t++) area += m->rest_area[t];
    return density * fmax(fabs(m->rest_volume), 1e-3 * m->mean_edge * area);
}

/* The mass is lumped on the vertices, each by a third of its triangles' area. A vertex that hangs on a sample keeps half of its mass and
 * gives the other half to the sample: it stands for the flesh between the two. Leaves 1/m in inverse_mass. */
static void lump_masses(const sn_build *build) {
    sn_model_muscle *m = build->model;
    const sn_scene_muscle *source = build->source;
    double *mass = m->inverse_mass, area = 0.0, sum = 0.0;
    for (sn_index t = 0; t < m->triangle_count; t++) {
        area += m->rest_area[t];
        for (int i = 0; i < 3; i++) mass[m->triangles[t].v[i]] += m->rest_area[t] / 3.0;
    }
    double least = LEAST_MASS * area / m->vertex_count;
    for (sn_index v = 0; v < m->vertex_count; v++) {
        sn_index sample = m->point_count > m->vertex_count ? source->rig.structure.vertex_sample[v] : SN_NONE;
        mass[v] = fmax(mass[v], least);
        if (sample == SN_NONE) continue;
        mass[v] *= 0.5;
        mass[build->sample_points[sample]] += mass[v];
    }
    for (sn_index i = 0; i < m->point_count; i++) sum += mass[i] = fmax(mass[i], 0.5 * least);
    m->mass = total_mass(m, source->density);
    for (sn_index i = 0; i < m->point_count; i++) m->inverse_mass[i] = sum / (mass[i] * m->mass);
}

/* Each point 1 kg. */
static void give_unit_masses(sn_model_muscle *m) {
    for (sn_index i = 0; i < m->point_count; i++) m->inverse_mass[i] = 1.0;
    m->mass = m->point_count;
}

/* ---- one muscle ----------------------------------------------------------------------------------------------------------- */

static sn_status make_volume_ratio(const sn_build *build, sn_error *error) {
    const sn_knots *knots = &build->source->volume_ratio;
    sn_model_muscle *m = build->model;
    m->rest_ratio = 1.0;
    if (knots->count == 0) return SN_OK;
    sn_status status = sn_curve_create(knots->count, knots->x, knots->y, &m->volume_ratio, error);
    if (status != SN_OK) return status;
    m->rest_ratio = sn_curve_at(m->volume_ratio, build->source->rest_activation);
    return SN_OK;
}

/* Knots of ln k: between two of them the stiffness runs in log scale, as it does from relaxed to active. */
static sn_status make_stiffness_curve(const sn_build *build, sn_error *error) {
    const sn_knots *knots = &build->source->stiffness_curve;
    if (knots->count == 0) return SN_OK;
    double *logarithms = SN_NEW(double, knots->count);
    if (logarithms == NULL) return sn_fail_memory(error, "the stiffness curve");
    for (sn_index i = 0; i < knots->count; i++) logarithms[i] = sn_ln(knots->y[i]);
    sn_status status = sn_curve_create(knots->count, knots->x, logarithms, &build->model->stiffness_curve, error);
    free(logarithms);
    return status;
}

/* Builders allocate for as many rows as there may be; what none of them took goes back. */
static void fit_arrays(sn_model_muscle *m) {
    void *fitted;
#define FIT(type, name, count, nullable, fits)                                                                                             \
    if (m->name != NULL && (fitted = sn_realloc(m->name, (size_t)(count), sizeof(type))) != NULL) m->name = fitted;
    SN_MODEL_ARRAYS(FIT)
#undef FIT
}

static sn_status build_muscle(sn_build *build, sn_error *error) {
    sn_model_muscle *m = build->model;
    const sn_scheme_rules *rules = sn_scheme_rules_of(&build->scene->solver);
    sn_status status;
    m->contracts = rules->contracts;
    m->source = build->source;
    m->vertex_count = build->source->rig.mesh.vertex_count;
    m->quasi_newton = build->scene->solver.method == SN_SOLVER_QN;
    m->single = build->scene->solver.method == SN_SOLVER_XPBD && build->scene->solver.precision == SN_PRECISION_SINGLE;
    m->tolerance = build->scene->solver.tolerance;
    m->iterations = build->source->iterations > 0 ? build->source->iterations : build->scene->solver.iterations;
    measure_size(build);
    sn_plan_decide(build);
    if ((status = sn_samples_build(build, error)) != SN_OK) return status;
    if ((status = copy_points(build, error)) != SN_OK) return status;
    if ((status = copy_triangles(build, error)) != SN_OK) return status;
    if (!(m->mean_edge > 0.0) || !isfinite(m->mean_edge))
        return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": all edges of its mesh have zero length", build->source->name);
    if (build->source->unit_mass || rules->unit_mass)
        give_unit_masses(m);
    else
        lump_masses(build);
    if ((status = make_volume_ratio(build, error)) != SN_OK) return status;
    if ((status = make_stiffness_curve(build, error)) != SN_OK) return status;
    if ((status = sn_kinematics_build(build, error)) != SN_OK) return status;
    /* of a free muscle the rest shape's Hessian is singular to rounding: nothing but its mass holds it */
    m->corotated = m->quasi_newton && m->kinematic_count > 0 && build->scene->solver.preconditioner == SN_PRECONDITION_COROTATED;
    m->two_level = m->quasi_newton && m->kinematic_count > 0 && build->scene->solver.preconditioner == SN_PRECONDITION_TWO_LEVEL;
    if ((status = sn_tendons_of_points(build, error)) != SN_OK) return status;
    if ((status = sn_rows_build(build, error)) != SN_OK) return status;
    if ((status = sn_skin_build(build, error)) != SN_OK) return status;
    fit_arrays(m);
    sn_plan_count(build);
    return SN_OK;
}

/* Without fibres there is nothing to yield along. */
static sn_anisotropy anisotropy_of(const sn_scheme_rules *rules, const sn_scene_muscle *source) {
    if (source->rig.fibers.directions == NULL) return SN_ANISOTROPY_NONE;
    if (source->anisotropy != SN_ANISOTROPY_SCHEME) return source->anisotropy;
    return rules->yields ? SN_ANISOTROPY_PBD : SN_ANISOTROPY_NONE;
}

static sn_status add_muscle(sn_model *model, const sn_scene_muscle *source, sn_plan_muscle *plan, sn_error *error) {
    *plan = (sn_plan_muscle){.name = source->name, .enabled = source->enabled};
    if (!source->enabled) return SN_OK;
    sn_topology topology = {0};
    const sn_scheme_rules *rules = sn_scheme_rules_of(&model->scene->solver);
    sn_build build = {.scene = model->scene,
                      .source = source,
                      .topology = &topology,
                      .model = &model->muscles[model->muscle_count++],
                      .plan = plan,
                      .scaled = rules->scales && source->stiffness_scaled,
                      .anisotropy = anisotropy_of(rules, source),
                      .contact = model->contact};
    plan->vertices = source->rig.mesh.vertex_count;
    plan->triangles = source->rig.mesh.triangle_count;
    sn_status status = sn_topology_build(&source->rig.mesh, &topology, error);
    if (status == SN_OK) status = build_muscle(&build, error);
    plan->iterations = build.model->iterations;
    sn_samples_release(&build);
    free(build.tendon);
    sn_topology_free(&topology);
    return status;
}

static sn_model *make_model(const sn_scene *scene) {
    sn_model *model = SN_NEW(sn_model, 1);
    if (model == NULL) return NULL;
    *model = (sn_model){.scene = scene,
                        .plan = {scene->muscle_count, SN_NEW(sn_plan_muscle, scene->muscle_count)},
                        .muscles = SN_NEW(sn_model_muscle, scene->muscle_count),
                        .frame_duration = 1.0 / scene->rate,
                        .substep_duration = 1.0 / (scene->rate * sn_solver_substeps(&scene->solver)),
                        .halves = scene->solver.substeps == SN_SUBSTEPS_AUTO};
    if (model->muscles != NULL && model->plan.muscles != NULL) return model;
    sn_model_destroy(model);
    return NULL;
}

/* Bytes of a group's state, each muscle's share by its points. */
static void count_states(const sn_model *model) {
    for (sn_index i = 0; i < model->muscle_count; i++) {
        const sn_model_muscle *m = &model->muscles[i];
        const sn_group *g = &model->groups[m->group];
        double share = (double)m->point_count / g->point_count;
        model->plan.muscles[m->source - model->scene->muscles].state_bytes = (size_t)(share * (double)sn_group_state_bytes(model, g));
    }
}

sn_status sn_model_create(const sn_scene *scene, sn_model **out, sn_error *error) {
    return sn_model_create_with(scene, &(sn_model_options){.pool = NULL}, out, error);
}

sn_status sn_model_create_with(const sn_scene *scene, const sn_model_options *options, sn_model **out, sn_error *error) {
    *out = NULL;
    sn_status status = sn_scene_validate(scene, error);
    if (status != SN_OK) return status;
    sn_model *model = make_model(scene);
    if (model == NULL) return sn_fail_memory(error, "the model");
    status = sn_contact_plan_create(scene, options, &model->contact, error);
    for (sn_index i = 0; status == SN_OK && i < scene->muscle_count; i++)
        status = add_muscle(model, &scene->muscles[i], &model->plan.muscles[i], error);
    if (status == SN_OK) status = sn_groups_build(model, error);
    if (status == SN_OK) count_states(model);
    if (status != SN_OK)
        sn_model_destroy(model);
    else
        *out = model;
    return status;
}

static void free_muscle(sn_model_muscle *m) {
#define FREE(type, name, count, nullable, fitted) free(m->name);
    SN_MODEL_ARRAYS(FREE)
#undef FREE
    sn_rows_destroy(m);
    sn_curve_destroy(m->stiffness_curve);
    sn_curve_destroy(m->volume_ratio);
}

void sn_model_destroy(sn_model *model) {
    if (model == NULL) return;
    sn_groups_free(model);
    sn_contact_plan_destroy(model->contact);
    for (sn_index i = 0; model->plan.muscles != NULL && i < model->plan.muscle_count; i++) free(model->plan.muscles[i].bones);
    for (sn_index i = 0; i < model->muscle_count; i++) free_muscle(&model->muscles[i]);
    free(model->muscles);
    free(model->plan.muscles);
    free(model);
}
