/*
 * embedding.c -- 3-D mean value coordinates (Ju, Schaefer and Warren 2005), made exact on affine maps.
 *
 * For a point x let u_j be the unit vectors to the vertices and d_j the distances. A triangle adds to the weight of its corner i
 *     w_i = N_i . m / (d_i det(u_0,u_1,u_2)),   N_i = u_{i+1} x u_{i-1},   m = 1/2 sum_k (theta_k / sin theta_k) N_k:
 * their w_i = (n_i . m) / (n_i . p_i) with the normals' lengths cancelled, which leaves one angle per edge and no square root but |N|.
 */
#include "sinew/embedding.h"

#include <stdlib.h>
#include <string.h>

#include "sinew/geom.h"

enum { GRAIN = 8 }; /* points a chunk */
/* A triangle seen edge-on from x spans no solid angle: its weight is 0 as the determinant goes to 0 (Ju et al.: "x lies outside t on the
 * same plane"). Below this share of its longest sides rounding is all there is. */
#define EDGE_ON 1e-10

/* Four vertices wide apart; rows[i] . e is the weight by which vertex i holds an offset e, the last one holds minus their sum. */
typedef struct frame {
    sn_index vertices[4];
    sn_vec3 rows[3];
} frame;

/* What a build works on, and scratch for one chunk of points. */
typedef struct binding {
    const sn_mesh *mesh;
    const sn_vec3 *points;
    const sn_surface *surface;
    double near, cut, diagonal;
    frame frame;
    sn_embedding_row *rows;
    sn_embedding_report *reports; /* (chunks) */
    sn_error *errors;             /* (chunks) */
} binding;

typedef struct scratch {
    sn_vec3 *toward;  /* (vertex_count) unit vectors u */
    double *distance; /* (vertex_count) */
    double *weights;  /* (vertex_count) */
    sn_index *kept;   /* (vertex_count) */
} scratch;

static bool scratch_alloc(scratch *s, sn_index vertices) {
    s->toward = SN_NEW(sn_vec3, vertices);
    s->distance = SN_NEW(double, vertices);
    s->weights = SN_NEW(double, vertices);
    s->kept = SN_NEW(sn_index, vertices);
    return s->toward && s->distance && s->weights && s->kept;
}

static void scratch_free(scratch *s) {
    free(s->toward);
    free(s->distance);
    free(s->weights);
    free(s->kept);
}

/* ---- frame -------------------------------------------------------------------------------------------------------------- */

/* How far p is from a point, a line or a plane, as an area or volume grows: of the vertices chosen so far, count of them. */
static double spread(const sn_vec3 chosen[3], int count, sn_vec3 p) {
    sn_vec3 d = sn_sub(p, chosen[0]);
    if (count == 1) return sn_norm(d);
    sn_vec3 e = sn_sub(chosen[1], chosen[0]);
    if (count == 2) return sn_norm(sn_cross(e, d));
    return fabs(sn_dot(sn_cross(e, sn_sub(chosen[2], chosen[0])), d));
}

/* Each vertex the farthest from what the ones before it span. false: all lie in a plane. */
static bool choose_frame(const sn_mesh *mesh, double diagonal, frame *out) {
    sn_vec3 chosen[4] = {mesh->positions[0]};
    *out = (frame){.vertices = {0}};
    double farthest = 0.0;
    for (int k = 1; k < 4; k++) {
        farthest = -1.0;
        for (sn_index v = 0; v < mesh->vertex_count; v++) {
            double here = spread(chosen, k, mesh->positions[v]);
            if (here <= farthest) continue;
            farthest = here;
            out->vertices[k] = v;
        }
        chosen[k] = mesh->positions[out->vertices[k]];
    }
    if (!(farthest > 1e-12 * diagonal * diagonal * diagonal)) return false;
    sn_vec3 e[3];
    for (int k = 0; k < 3; k++) e[k] = sn_sub(chosen[k], chosen[3]);
    double determinant = sn_dot(e[0], sn_cross(e[1], e[2]));
    for (int k = 0; k < 3; k++) out->rows[k] = sn_scale(sn_cross(e[(k + 1) % 3], e[(k + 2) % 3]), 1.0 / determinant);
    return true;
}

/* ---- mean value weights ------------------------------------------------------------------------------------------------ */

/* theta / sin theta of unit vectors with cross product of squared length s2 and dot product c; its series where the angle is small. */
static inline double angle_over_sine(double s2, double c) {
    if (c > 0.0 && s2 < 0.01)
        return 1.0 +
               s2 * (1.0 / 6.0 +
                     s2 * (3.0 / 40.0 + s2 * (15.0 / 336.0 + s2 * (105.0 / 3456.0 + s2 * (945.0 / 42240.0 + s2 * (10395.0 / 599040.0))))));
    double s = sqrt(s2);
    return s > 0.0 ? sn_quick_atan2(s, c) / s : 1.0;
}

/* 2 m of the triangle's edge from a to b. */
static inline sn_vec3 edge_term(sn_vec3 cross, sn_vec3 a, sn_vec3 b) {
    return sn_scale(cross, angle_over_sine(sn_norm2(cross), sn_dot(a, b)));
}

static void add_triangle(const scratch *s, const sn_index v[3]) {
    sn_vec3 a = s->toward[v[0]], b = s->toward[v[1]], c = s->toward[v[2]];
    sn_vec3 na = sn_cross(b, c), nb = sn_cross(c, a), nc = sn_cross(a, b);
    double determinant = sn_dot(a, na), size = fmax(sn_norm2(na), fmax(sn_norm2(nb), sn_norm2(nc)));
    if (!(fabs(determinant) > EDGE_ON * size)) return;
    sn_vec3 m = sn_add(edge_term(na, b, c), sn_add(edge_term(nb, c, a), edge_term(nc, a, b)));
    double share = 0.5 / determinant;
    s->weights[v[0]] += sn_dot(na, m) * share;
    s->weights[v[1]] += sn_dot(nb, m) * share;
    s->weights[v[2]] += sn_dot(nc, m) * share;
}

/* Weights of x, their sum 1; false where they cancel out. */
static bool mean_value_weights(const sn_mesh *mesh, sn_vec3 x, const scratch *s) {
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        sn_vec3 d = sn_sub(mesh->positions[v], x);
        s->distance[v] = sn_norm(d);
        s->toward[v] = sn_scale(d, 1.0 / s->distance[v]);
        s->weights[v] = 0.0;
    }
    for (sn_index t = 0; t < mesh->triangle_count; t++) add_triangle(s, mesh->triangles[t].v);
    double sum = 0.0, size = 0.0;
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        s->weights[v] /= s->distance[v];
        sum += s->weights[v];
        size += fabs(s->weights[v]);
    }
    if (!(fabs(sum) > 1e-9 * size)) return false;
    for (sn_index v = 0; v < mesh->vertex_count; v++) s->weights[v] /= sum;
    return true;
}

/* ---- moment correction --------------------------------------------------------------------------------------------------- */

/* [1, (p - x) / size]: the four functions whose sums the weights must reproduce as [1, 0, 0, 0]. */
static void moments_of(sn_vec3 p, sn_vec3 x, double size, double out[4]) {
    out[0] = 1.0;
    out[1] = (p.x - x.x) / size;
    out[2] = (p.y - x.y) / size;
    out[3] = (p.z - x.z) / size;
}

/* Solve the symmetric positive definite A y = b by Cholesky, in place; false where it is singular to rounding. */
static bool solve4(double a[4][4], double b[4]) {
    double largest = fmax(fmax(a[0][0], a[1][1]), fmax(a[2][2], a[3][3]));
    for (int j = 0; j < 4; j++) {
        for (int k = 0; k < j; k++) a[j][j] -= a[j][k] * a[j][k];
        if (!(a[j][j] > 1e-14 * largest)) return false;
        a[j][j] = sqrt(a[j][j]);
        for (int i = j + 1; i < 4; i++) {
            for (int k = 0; k < j; k++) a[i][j] -= a[i][k] * a[j][k];
            a[i][j] /= a[j][j];
        }
    }
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < i; k++) b[i] -= a[i][k] * b[k];
        b[i] /= a[i][i];
    }
    for (int i = 3; i >= 0; i--) {
        for (int k = i + 1; k < 4; k++) b[i] -= a[k][i] * b[k];
        b[i] /= a[i][i];
    }
    return true;
}

/* What the weights lack: [1, 0, 0, 0] - sum w [1, (p - x) / size]; returns its largest entry. */
static double residual(const binding *b, sn_vec3 x, const sn_embedding_row *row, double out[4]) {
    double sum[4] = {1.0, 0.0, 0.0, 0.0}, f[4], largest = 0.0;
    for (sn_index i = 0; i < row->count; i++) {
        moments_of(b->mesh->positions[row->vertices ? row->vertices[i] : i], x, b->diagonal, f);
        for (int k = 0; k < 4; k++) sum[k] -= row->weights[i] * f[k];
    }
    for (int k = 0; k < 4; k++) {
        out[k] = sum[k];
        largest = fmax(largest, fabs(sum[k]));
    }
    return largest;
}

/* The least change of the weights, relative to their sizes, that restores the moments: w += |w| f . y, (sum |w| f f^T) y = residual. */
static bool correct(const binding *b, sn_vec3 x, sn_embedding_row *row, double missing[4]) {
    double a[4][4] = {{0}}, f[4];
    for (sn_index i = 0; i < row->count; i++) {
        moments_of(b->mesh->positions[row->vertices ? row->vertices[i] : i], x, b->diagonal, f);
        for (int r = 0; r < 4; r++)
            for (int c = 0; c <= r; c++) a[r][c] += fabs(row->weights[i]) * f[r] * f[c];
    }
    if (!solve4(a, missing)) return false;
    for (sn_index i = 0; i < row->count; i++) {
        moments_of(b->mesh->positions[row->vertices ? row->vertices[i] : i], x, b->diagonal, f);
        row->weights[i] += fabs(row->weights[i]) * (f[0] * missing[0] + f[1] * missing[1] + f[2] * missing[2] + f[3] * missing[3]);
    }
    return true;
}

/* Twice: the second time takes up the rounding of the first. */
static bool correct_moments(const binding *b, sn_vec3 x, sn_embedding_row *row, sn_embedding_report *report) {
    double missing[4];
    report->correction = fmax(report->correction, residual(b, x, row, missing));
    for (int pass = 0; pass < 2; pass++) {
        if (!correct(b, x, row, missing)) return false;
        residual(b, x, row, missing);
    }
    report->error = fmax(report->error, residual(b, x, row, missing));
    return true;
}

/* ---- rows ---------------------------------------------------------------------------------------------------------------- */

static bool row_alloc(sn_embedding_row *row, sn_index count, bool sparse) {
    row->count = count;
    row->weights = SN_NEW(double, count);
    if (sparse) row->vertices = SN_NEW(sn_index, count);
    return row->weights && (!sparse || row->vertices);
}

static void row_free(sn_embedding_row *row) {
    free(row->vertices);
    free(row->weights);
    *row = (sn_embedding_row){0};
}

/* A point on the surface: barycentric in its closest triangle, and its offset from that, at most `near`, in the frame of four vertices
 * wide apart: a thin triangle could not hold it. */
static sn_status bind_near(const binding *b, sn_vec3 x, const sn_closest *at, sn_embedding_row *row, sn_embedding_report *report,
                           sn_error *error) {
    if (!row_alloc(row, 7, true)) return sn_fail_memory(error, "an embedding");
    const sn_index *v = b->mesh->triangles[at->triangle].v;
    sn_vec3 offset = sn_sub(x, at->point);
    double sum = 0.0;
    for (int c = 0; c < 3; c++) {
        row->vertices[c] = v[c];
        row->weights[c] = at->barycentric[c];
        row->vertices[3 + c] = b->frame.vertices[c];
        row->weights[3 + c] = sn_dot(b->frame.rows[c], offset);
        sum += row->weights[3 + c];
    }
    row->vertices[6] = b->frame.vertices[3];
    row->weights[6] = -sum;
    double missing[4], left = residual(b, x, row, missing);
    report->correction = fmax(report->correction, left);
    report->error = fmax(report->error, left);
    report->near_points++;
    return SN_OK;
}

static bool keep_all(const binding *b, const scratch *s, sn_embedding_row *row) {
    if (!row_alloc(row, b->mesh->vertex_count, false)) return false;
    memcpy(row->weights, s->weights, (size_t)row->count * sizeof *row->weights);
    return true;
}

static bool keep_large(const binding *b, const scratch *s, sn_embedding_row *row, double *dropped) {
    sn_index count = 0;
    *dropped = 0.0;
    for (sn_index v = 0; v < b->mesh->vertex_count; v++)
        if (fabs(s->weights[v]) >= b->cut)
            s->kept[count++] = v;
        else
            *dropped += fabs(s->weights[v]);
    if (!row_alloc(row, count, true)) return false;
    for (sn_index i = 0; i < count; i++) {
        row->vertices[i] = s->kept[i];
        row->weights[i] = s->weights[s->kept[i]];
    }
    return true;
}

static sn_status bind_inside(const binding *b, sn_index point, const scratch *s, sn_embedding_report *report, sn_error *error) {
    sn_vec3 x = b->points[point];
    sn_embedding_row *row = &b->rows[point];
    if (!mean_value_weights(b->mesh, x, s)) {
        if (error) error->element = point;
        return sn_fail(error, SN_ERROR_INPUT, "point %d is so far outside the surface that it cannot follow it; pull it inside", point);
    }
    double dropped = 0.0;
    bool kept = b->cut > 0.0 ? keep_large(b, s, row, &dropped) : keep_all(b, s, row);
    if (!kept) return sn_fail_memory(error, "an embedding");
    if (row->count >= 4 && correct_moments(b, x, row, report)) {
        report->dropped_mean += dropped;
        report->dropped_worst = fmax(report->dropped_worst, dropped);
        return SN_OK;
    }
    row_free(row); /* what the cut leaves lies in a plane: all are needed */
    if (!keep_all(b, s, row)) return sn_fail_memory(error, "an embedding");
    if (correct_moments(b, x, row, report)) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT, "the surface is flat: it has no inside to bind point %d to", point);
}

/* ---- building ------------------------------------------------------------------------------------------------------------- */

static void bind_chunk(void *user, sn_index begin, sn_index end, sn_index chunk) {
    binding *b = user;
    sn_embedding_report *report = &b->reports[chunk];
    sn_error *error = &b->errors[chunk];
    scratch s = {0};
    sn_status status = scratch_alloc(&s, b->mesh->vertex_count) ? SN_OK : sn_fail_memory(error, "an embedding");
    for (sn_index i = begin; i < end && !status; i++) {
        sn_closest at = sn_surface_closest(b->surface, b->points[i], b->near);
        if (at.triangle != SN_NONE)
            status = bind_near(b, b->points[i], &at, &b->rows[i], report, error);
        else
            status = bind_inside(b, i, &s, report, error);
    }
    scratch_free(&s);
}

static sn_status check_points(const sn_mesh *mesh, sn_index count, const sn_vec3 *points, const sn_embedding_params *params,
                              sn_error *error) {
    if (!(params->near >= 0.0 && params->near < 0.1) || !(params->cut >= 0.0 && params->cut < 0.1))
        return sn_fail(error, SN_ERROR_USAGE, "the distance and the cut of an embedding must be in [0, 0.1)");
    for (sn_index i = 0; i < count; i++)
        if (!sn_finite3(points[i])) return sn_fail(error, SN_ERROR_INPUT, "point %d to embed is not finite", i);
    return sn_mesh_validate(mesh, error);
}

/* Chunks in order: the same sums for any number of threads. */
static sn_status gather(const binding *b, sn_index chunks, sn_index count, sn_embedding_report *out, sn_error *error) {
    *out = (sn_embedding_report){0};
    for (sn_index c = 0; c < chunks; c++) {
        const sn_embedding_report *r = &b->reports[c];
        if (b->errors[c].code != SN_OK) {
            if (error) *error = b->errors[c];
            return b->errors[c].code;
        }
        out->near_points += r->near_points;
        out->correction = fmax(out->correction, r->correction);
        out->error = fmax(out->error, r->error);
        out->dropped_mean += r->dropped_mean / (double)count;
        out->dropped_worst = fmax(out->dropped_worst, r->dropped_worst);
    }
    for (sn_index i = 0; i < count; i++) out->weights += b->rows[i].count;
    return SN_OK;
}

sn_embedding_params sn_embedding_defaults(void) { return (sn_embedding_params){.near = 1e-7}; }

sn_status sn_embedding_build(const sn_mesh *mesh, sn_index count, const sn_vec3 *points, const sn_embedding_params *params,
                             sn_embedding *out, sn_error *error) {
    sn_surface *surface = NULL;
    *out = (sn_embedding){.point_count = count, .vertex_count = mesh->vertex_count};
    sn_status status = check_points(mesh, count, points, params, error);
    if (status) return status;
    double diagonal = sn_box_diagonal(sn_mesh_box(mesh));
    binding b = {.mesh = mesh, .points = points, .near = params->near * diagonal, .cut = params->cut, .diagonal = diagonal};
    if (!choose_frame(mesh, diagonal, &b.frame))
        return sn_fail(error, SN_ERROR_INPUT, "the surface is flat: it has no inside to bind points to");
    if ((status = sn_surface_create_plain(mesh, &surface, error)) != SN_OK) return status;
    b.surface = surface;
    sn_index chunks = sn_chunk_count(count, GRAIN);
    b.rows = out->rows = SN_NEW(sn_embedding_row, count);
    b.reports = SN_NEW(sn_embedding_report, chunks);
    b.errors = SN_NEW(sn_error, chunks);
    if (b.rows && b.reports && b.errors) {
        sn_parallel_for(params->pool, count, GRAIN, bind_chunk, &b);
        status = gather(&b, chunks, count, &out->report, error);
    } else {
        status = sn_fail_memory(error, "an embedding");
    }
    free(b.reports);
    free(b.errors);
    sn_surface_destroy(surface);
    if (status) sn_embedding_free(out);
    return status;
}

void sn_embedding_free(sn_embedding *embedding) {
    for (sn_index i = 0; embedding->rows && i < embedding->point_count; i++) row_free(&embedding->rows[i]);
    free(embedding->rows);
    *embedding = (sn_embedding){0};
}

/* ---- its name ---------------------------------------------------------------------------------------------------- */

sn_status sn_embedding_hash(const sn_mesh *mesh, sn_index count, const sn_vec3 *points, const sn_embedding_params *params,
                            char out[SN_HASH_LENGTH], sn_error *error) {
    const double numbers[5] = {1.0 /* version of the method */, (double)mesh->vertex_count, (double)count, params->near, params->cut};
    size_t vertices = (size_t)mesh->vertex_count * sizeof *mesh->positions,
           triangles = (size_t)mesh->triangle_count * sizeof *mesh->triangles;
    size_t bound = (size_t)count * sizeof *points;
    char *bytes = sn_alloc(sizeof numbers + vertices + triangles + bound, 1);
    if (!bytes) return sn_fail_memory(error, "the name of an embedding");
    memcpy(bytes, numbers, sizeof numbers);
    memcpy(bytes + sizeof numbers, mesh->positions, vertices);
    memcpy(bytes + sizeof numbers + vertices, mesh->triangles, triangles);
    memcpy(bytes + sizeof numbers + vertices + triangles, points, bound);
    sn_hash(bytes, sizeof numbers + vertices + triangles + bound, out);
    free(bytes);
    return SN_OK;
}
