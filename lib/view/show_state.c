/* show_state.c -- a simulation stopped anywhere: the muscles at its points, coloured by how far their rows are from what they ask for. */
#include "show.h"

#include <stdio.h>
#include <stdlib.h>

enum { RADIAL_SHOWN = 1500 };
static const double INTERNAL_RADIUS = 0.0042, RADIAL_RADIUS = 0.0011, WORST_RADIUS = 0.0055;
static const double SHEER = 0.20; /* opacity of a surface whose inside is meant */
static const sn_color COLOR_SHEER = {0.72, 0.72, 0.74}, COLOR_WORST = {0.10, 0.10, 0.12};

/* ---- errors of one muscle --------------------------------------------------------------------------------------------------------- */

/* Of its rows of one kind; of a row of all points (the volume) at its vertices. */
typedef struct field {
    sn_index muscle;
    sn_state_figure figure;
    sn_index count, worst; /* worst: SN_NONE = none */
    double *errors;        /* (count) NaN: a row without a value */
} field;

static bool is_kind(sn_state_figure figure) { return (int)figure < SN_ROW_KINDS; }

const char *sn_state_figure_name(sn_state_figure figure) {
    if (is_kind(figure)) return sn_row_kind_name((sn_row_kind)figure);
    return figure == SN_FIGURE_PRESSURE ? "pressure" : "penetration";
}

/* What the scale says of it. */
static const char *scale_text(sn_state_figure figure) {
    if (is_kind(figure)) return sn_row_info_of((sn_row_kind)figure)->errors;
    return figure == SN_FIGURE_PRESSURE ? "pressure of bones, kPa" : "depth in bones beyond that at rest, mm";
}

static bool has_all_points(sn_state_figure figure) { return !is_kind(figure) || sn_row_info_of((sn_row_kind)figure)->points == 0; }

static sn_index field_size(const sn_model *model, sn_index muscle, sn_state_figure figure) {
    return has_all_points(figure) ? model->muscles[muscle].vertex_count : sn_row_count(model, muscle, (sn_row_kind)figure);
}

static sn_status measure_volume(const sn_model *model, const sn_state *state, sn_index muscle, double *errors, sn_error *error) {
    sn_vec3 *gradients = SN_NEW(sn_vec3, model->muscles[muscle].vertex_count);
    if (!gradients) return sn_fail_memory(error, "the volume's gradient");
    sn_volume_moves(model, state, muscle, gradients, errors);
    free(gradients);
    return SN_OK;
}

/* In kPa, or mm. */
static sn_status measure_contact(const sn_model *model, const sn_state *state, const field *f, sn_error *error) {
    sn_status status = SN_OK;
    if (f->figure == SN_FIGURE_PRESSURE)
        status = sn_contact_pressures(model, state, f->muscle, f->errors, error);
    else
        sn_contact_depths(model, state, f->muscle, f->errors);
    for (sn_index i = 0; i < f->count; i++) f->errors[i] *= f->figure == SN_FIGURE_PRESSURE ? 1e-3 : 1e3;
    return status;
}

/* The greatest; a row without a value (a hinge between collapsed triangles) is worse than any. */
static sn_index worst_of(sn_index count, const double *errors) {
    sn_index worst = SN_NONE;
    for (sn_index i = 0; i < count; i++) {
        if (isnan(errors[i])) return i;
        if (worst == SN_NONE || errors[i] > errors[worst]) worst = i;
    }
    return worst;
}

/* The caller frees field->errors. */
static sn_status field_measure(const sn_model *model, const sn_state *state, sn_index muscle, sn_state_figure figure, field *f,
                               sn_error *error) {
    *f = (field){.muscle = muscle, .figure = figure, .count = field_size(model, muscle, figure), .worst = SN_NONE};
    f->errors = SN_NEW(double, f->count);
    if (!f->errors) return sn_fail_memory(error, "the errors of a muscle");
    sn_status status = SN_OK;
    if (!is_kind(figure))
        status = measure_contact(model, state, f, error);
    else if (has_all_points(figure))
        status = measure_volume(model, state, muscle, f->errors, error);
    else
        sn_row_errors(model, state, muscle, (sn_row_kind)figure, f->errors);
    f->worst = worst_of(f->count, f->errors);
    return status;
}

static int field_points(const sn_model *model, sn_index muscle, sn_state_figure figure, sn_index item, sn_index points[4]) {
    if (!has_all_points(figure)) return sn_row_points(model, muscle, (sn_row_kind)figure, item, points);
    points[0] = item;
    return 1;
}

static sn_vec3 point_at(const sn_state *state, sn_index muscle, sn_index point) {
    return sn_point_position(&state->muscles[muscle].points[point]);
}

static sn_vec3 middle_of(const sn_model *model, const sn_state *state, sn_index muscle, sn_state_figure figure, sn_index item) {
    sn_index points[4];
    int count = field_points(model, muscle, figure, item, points);
    sn_vec3 sum = sn_v3(0, 0, 0);
    for (int i = 0; i < count; i++) sum = sn_add_scaled(sum, point_at(state, muscle, points[i]), 1.0 / count);
    return sum;
}

/* ---- the range ----------------------------------------------------------------------------------------------------------- */

static int compare_numbers(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The least of 1, 2, 5 x 10^k that is not below a number. */
static double round_up(double x) {
    double power = sn_pow(10.0, floor(sn_log10(x)));
    for (int i = 0; i < 4; i++) {
        static const double steps[4] = {1.0, 2.0, 5.0, 10.0};
        if (steps[i] * power >= x * (1.0 - 1e-9)) return steps[i] * power;
    }
    return x;
}

sn_status sn_view_state_range(const sn_model *model, const sn_state *state, sn_state_figure figure, double *range, sn_error *error) {
    size_t room = 0, count = 0;
    for (sn_index m = 0; m < model->muscle_count; m++) room += (size_t)field_size(model, m, figure);
    double *all = SN_NEW(double, room);
    sn_status status = all ? SN_OK : sn_fail_memory(error, "the errors");
    for (sn_index m = 0; m < model->muscle_count && !status; m++) {
        field f;
        status = field_measure(model, state, m, figure, &f, error);
        for (sn_index i = 0; i < f.count && !status; i++)
            if (isfinite(f.errors[i]) && (is_kind(figure) || f.errors[i] > 0.0)) all[count++] = f.errors[i]; /* most touch nothing */
        free(f.errors);
    }
    if (!status && count > 0) qsort(all, count, sizeof *all, compare_numbers);
    double most = count > 0 ? all[(size_t)(0.98 * (double)(count - 1))] : 0.0;
    if (count > 0 && !(most > 0.0)) most = all[count - 1];
    *range = most > 1e-300 ? round_up(most) : 1.0;
    free(all);
    return status;
}

/* ---- what is drawn --------------------------------------------------------------------------------------------------------- */

typedef struct scene_view {
    sn_view *view;
    const sn_model *model;
    const sn_state *state;
    sn_state_look look;
    sn_index worst_muscle, worst_row; /* of all so far; SN_NONE = none */
    double worst;
} scene_view;

/* ---- the surface --------------------------------------------------------------------------------------------------------- */

/* At each vertex the greatest error of its rows; NaN, the colour of the scale's end, stays. */
static void spread_errors(const sn_model *model, const field *f, double *at) {
    sn_index points[4], vertices = model->muscles[f->muscle].vertex_count;
    for (sn_index i = 0; i < f->count; i++) {
        int count = field_points(model, f->muscle, f->figure, i, points);
        for (int k = 0; k < count; k++)
            if (points[k] < vertices && (isnan(f->errors[i]) || at[points[k]] < f->errors[i])) at[points[k]] = f->errors[i];
    }
}

static sn_status color_surface(const scene_view *s, const field *f, sn_view_mesh *mesh, sn_error *error) {
    double *at = SN_NEW(double, mesh->vertex_count);
    mesh->colors = SN_NEW(sn_color, mesh->vertex_count);
    if (!at || !mesh->colors) {
        free(at);
        return sn_fail_memory(error, "the colours of a muscle");
    }
    spread_errors(s->model, f, at);
    for (sn_index i = 0; i < mesh->vertex_count; i++) mesh->colors[i] = sn_scale_color(at[i] / s->look.range);
    free(at);
    return SN_OK;
}

/* The surface at the state's points, without colours. */
static sn_status add_surface(const scene_view *s, sn_index muscle, sn_view_mesh **out, sn_error *error) {
    const sn_model_muscle *m = &s->model->muscles[muscle];
    sn_vec3 *positions = SN_NEW(sn_vec3, m->vertex_count);
    if (!positions) return sn_fail_memory(error, "the points of a muscle");
    for (sn_index i = 0; i < m->vertex_count; i++) positions[i] = point_at(s->state, muscle, i);
    const sn_mesh mesh = {
        .vertex_count = m->vertex_count, .triangle_count = m->triangle_count, .positions = positions, .triangles = m->triangles};
    sn_status status = sn_view_add_mesh(s->view, &mesh, (sn_placement){1.0, NULL}, COLOR_SHEER, out, error);
    free(positions);
    return status ? status : name_mesh(s->view, m->source->name, error);
}

/* ---- the inside ---------------------------------------------------------------------------------------------------------- */

/* Distance rows as lines: every `step`-th, and the worst. */
static sn_status add_lines(const scene_view *s, const field *f, sn_index step, double radius, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; i < f->count && !status; i++) {
        sn_index p[4];
        if (i % step != 0 && i != f->worst) continue;
        sn_row_points(s->model, f->muscle, (sn_row_kind)f->figure, i, p);
        const sn_view_tube tube = {point_at(s->state, f->muscle, p[0]), point_at(s->state, f->muscle, p[1]), radius,
                                   sn_scale_color(f->errors[i] / s->look.range)};
        status = sn_view_add_tube(s->view, tube, error);
    }
    return status;
}

/* The internal edges, with their own errors. */
static sn_status add_internal(const scene_view *s, sn_index muscle, sn_error *error) {
    field f;
    sn_status status = field_measure(s->model, s->state, muscle, (sn_state_figure)SN_ROWS_INTERNAL, &f, error);
    if (!status) status = add_lines(s, &f, 1, INTERNAL_RADIUS, error);
    free(f.errors);
    return status;
}

/* ---- a muscle ------------------------------------------------------------------------------------------------------------ */

static sn_status show_field(const scene_view *s, const field *f, sn_error *error) {
    sn_view_mesh *mesh;
    bool inside = is_kind(f->figure) && sn_row_info_of((sn_row_kind)f->figure)->inside,
         both = (int)f->figure == SN_ROWS_MESH && s->look.show & SN_SHOW_STRUCTURE;
    both = both && sn_row_count(s->model, f->muscle, SN_ROWS_INTERNAL) > 0;
    sn_status status = add_surface(s, f->muscle, &mesh, error);
    if (status) return status;
    mesh->gloss = 0.3;
    mesh->wire = (s->look.show & SN_SHOW_WIRE) != 0;
    mesh->opacity = inside || both ? SHEER : 1.0;
    if (!inside) status = color_surface(s, f, mesh, error);
    if (!status && both) status = add_internal(s, f->muscle, error);
    bool radial = (int)f->figure == SN_ROWS_RADIAL; /* there are many of them */
    sn_index step = radial ? f->count / RADIAL_SHOWN + 1 : 1;
    double radius = radial ? RADIAL_RADIUS : INTERNAL_RADIUS;
    if (!status && inside) status = add_lines(s, f, step, radius, error);
    return status;
}

static sn_status show_muscle_state(scene_view *s, sn_index muscle, sn_error *error) {
    field f;
    sn_status status = field_measure(s->model, s->state, muscle, s->look.figure, &f, error);
    if (!status) status = show_field(s, &f, error);
    bool worse = f.worst != SN_NONE && (s->worst_row == SN_NONE || isnan(f.errors[f.worst]) || f.errors[f.worst] > s->worst);
    if (!status && worse) {
        s->worst_muscle = muscle;
        s->worst_row = f.worst;
        s->worst = f.errors[f.worst];
    }
    free(f.errors);
    return status;
}

/* ---- words --------------------------------------------------------------------------------------------------------------- */

/* "vertices 3, 17", "samples 4, 5" or "sample 4, vertex 17": the points of the worst row. */
static void worst_points(const scene_view *s, char *text, size_t room) {
    const sn_model_muscle *muscle = &s->model->muscles[s->worst_muscle];
    sn_index points[4], vertices = muscle->vertex_count;
    int count = field_points(s->model, s->worst_muscle, s->look.figure, s->worst_row, points), length = 0;
    bool mixed = count > 1 && (points[0] >= vertices) != (points[1] >= vertices);
    for (int i = 0; i < count && length < (int)room; i++) {
        bool sample = points[i] >= vertices;
        const char *one = sample ? "sample " : "vertex ", *many = sample ? "samples " : "vertices ";
        length += snprintf(text + length, room - (size_t)length, "%s%s%d", i > 0 ? ", " : "",
                           mixed || count == 1 ? one
                           : i == 0            ? many
                                               : "",
                           sample ? muscle->samples[points[i] - vertices] : points[i]);
    }
}

static sn_status write_subtitle(const scene_view *s, sn_error *error) {
    char text[320], points[128] = "";
    if (s->worst_row == SN_NONE) {
        snprintf(text, sizeof text, "no rows: %s", sn_state_figure_name(s->look.figure));
    } else if (!(s->worst > 0.0 || isnan(s->worst))) {
        snprintf(text, sizeof text, "%s: no error", sn_state_figure_name(s->look.figure));
    } else {
        const char *muscle = s->model->muscle_count > 1 ? s->model->muscles[s->worst_muscle].source->name : "";
        char value[32];
        snprintf(value, sizeof value, "%s", is_kind(s->look.figure) ? sn_row_info_of((sn_row_kind)s->look.figure)->lacks : "");
        if (!isnan(s->worst)) snprintf(value, sizeof value, "%.3g", s->worst);
        worst_points(s, points, sizeof points);
        snprintf(text, sizeof text, "%s: worst %s, %s%s%s", sn_state_figure_name(s->look.figure), value, muscle, *muscle ? ", " : "",
                 points);
    }
    s->view->subtitle = sn_strdup(text);
    return s->view->subtitle ? SN_OK : sn_fail_memory(error, "the subtitle");
}

static sn_status write_scale(const scene_view *s, sn_error *error) {
    s->view->scale =
        (sn_view_scale){sn_strdup(scale_text(s->look.figure)), s->look.range, !(s->worst <= s->look.range) && s->worst_row != SN_NONE};
    return s->view->scale.text ? SN_OK : sn_fail_memory(error, "the scale");
}

static sn_status mark_worst(const scene_view *s, sn_error *error) {
    if (s->worst_row == SN_NONE || !(s->worst > 0.0 || isnan(s->worst))) return SN_OK;
    sn_vec3 at = middle_of(s->model, s->state, s->worst_muscle, s->look.figure, s->worst_row);
    sn_status status = sn_view_add_ring(s->view, at, error);
    if (!status) status = sn_view_add_tube(s->view, (sn_view_tube){at, at, WORST_RADIUS, COLOR_WORST}, error);
    return status ? status
                  : sn_view_add_entry(s->view, SN_MARK_RING, COLOR_WORST, "worst row; behind the muscle where the ring is empty", error);
}

/* ---- the whole ----------------------------------------------------------------------------------------------------------- */

/* A substep in which iterations are done has the inputs of its end. */
double sn_view_state_frame(const sn_model *model, const sn_state *state) {
    double substeps = sn_solver_substeps(&model->scene->solver);
    if (state->substep == 0 && state->iteration == 0) return state->frame;
    return (double)state->frame - 1.0 + (state->substep + (state->iteration > 0 ? 1 : 0)) / substeps;
}

sn_status sn_view_add_state(sn_view *view, const sn_model *model, const sn_state *state, const sn_state_look *look, sn_error *error) {
    const sn_scene *scene = model->scene;
    scene_view s = {.view = view, .model = model, .state = state, .look = *look, .worst_muscle = SN_NONE, .worst_row = SN_NONE};
    sn_status status = SN_OK;
    if (isnan(look->range)) status = sn_view_state_range(model, state, look->figure, &s.look.range, error);
    if (!status && !view->title && scene->name && !(view->title = sn_strdup(scene->name))) status = sn_fail_memory(error, "the title");
    double time = sn_view_state_frame(model, state) / scene->rate;
    if (!status && look->show & SN_SHOW_BONES) status = show_bones(view, scene, time, look->show, error);
    if (!status && look->show & SN_SHOW_ENVELOPES) status = show_envelopes(view, scene, time, false, error);
    for (sn_index m = 0; m < model->muscle_count && !status; m++) status = show_muscle_state(&s, m, error);
    if (!status) status = write_scale(&s, error);
    if (!status) status = mark_worst(&s, error);
    return status || view->subtitle ? status : write_subtitle(&s, error);
}
