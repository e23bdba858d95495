/*
 * precondition.c -- what the quasi-Newton back end knows of the stiffness: mass and the rest shape, factored once.   numerics.md 2, 7
 *
 *   scalar     A = M/h^2 + k sum scale K KT, one n x n matrix for x, y and z: blind to rotations, and safe at any shape
 *   corotated  A = R (M/h^2 + k sum scale g gT) RT, 3n x 3n: the Hessian of the rest shape, turned with the muscle by the frames of its
 *              sections. It knows directions, and is no good where triangles have collapsed or edges are far from their length
 *   two-level  A^-1 + 0.8 Z (ZT H Z)^-1 ZT with the scalar A: rigid motions of sections are solved for where the muscle is (two_level.c)
 *
 * Which of them a substep goes by is decided at its start; a matrix that is never asked for is never made.
 */
#include "blocks.h"
#include "frames.h"
#include "qn.h"
#include "rest_rows.h"
#include "two_level.h"

#include <stdlib.h>
#include <string.h>

/* Sections of the frames: as many as it takes to follow a bend around the thickness of a muscle. */
enum { SECTIONS = 24 };

/* The matrix of one kind. A column of free_count + c couples a free point with the carried point c. */
typedef struct rest_matrix {
    sn_blocks blocks;
    sn_sparse *factor; /* NULL = none yet */
    double factor_h, factor_stiffness;
} rest_matrix;

struct sn_preconditioner {
    const sn_model_muscle *model;
    sn_index point_count, vertex_count, free_count;
    sn_index *number_of; /* (point_count) free points from 0, then the carried ones */
    sn_index *point_of;  /* (point_count) the reverse */
    double *mass;        /* (free_count) kg / h^2 of the last factor */
    rest_matrix scalar, corotated;
    sn_frames frames;         /* none until they are asked for */
    sn_quat *turns;           /* (point_count) frames of the points; NULL = this substep goes by the scalar matrix */
    sn_two_level coarse;      /* none but under the two-level matrix */
    bool corrects;            /* this substep goes by it */
    double *right, *solution; /* (6 free_count) of the volume row behind those of the caller */
    sn_vec3 *volume_gradient; /* (point_count) g on free points, zero elsewhere */
    sn_vec3 *volume_solved;   /* (point_count) A^-1 g */
    double volume_stiffness;  /* k_V where A^-1 g is still to be found, by the next solve; 0 = nothing to find */
    double volume_scale;      /* k_V / (1 + k_V gT A^-1 g); 0 = no volume row */
};

/* ---- the rest shape's matrices ------------------------------------------------------------------------------------------------ */

typedef struct builder {
    const sn_preconditioner *p;
    sn_blocks *blocks;
} builder;

/* What a hinge of the corotated matrix resists in all directions, as a share of what it resists along its gradient. A hinge away from its
 * rest angle is stiff beside its gradient too (k_b C ddC), and a matrix softer than the energy makes steps that are rejected: without this
 * share 3 iterations a frame tear a muscle of 4k triangles apart (strain 5), with 0.1 it comes to 7e-5 L, but not while it contracts; with
 * 0.5 it does. */
static const double HINGE_ALL_ROUND = 0.5;

static void add_product(double *block, int size, const sn_rest_row *row, int i, int j) {
    const sn_vec3 a = row->gradient[i], b = row->gradient[j];
    double all_round = row->scale * row->weight[i] * row->weight[j];
    if (size == 1) {
        *block += all_round;
        return;
    }
    const double left[3] = {row->scale * a.x, row->scale * a.y, row->scale * a.z}, right[3] = {b.x, b.y, b.z};
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            block[3 * r + c] += left[r] * right[c] + (r == c && row->count == 4 ? HINGE_ALL_ROUND * all_round : 0.0);
}

static bool add_row(void *user, const sn_rest_row *row) {
    const builder *to = user;
    for (int i = 0; i < row->count; i++) {
        sn_index at = to->p->number_of[row->point[i]];
        if (at >= to->p->free_count) continue;
        for (int j = 0; j < row->count; j++) {
            sn_index column = to->p->number_of[row->point[j]];
            if (column > at && column < to->p->free_count) continue; /* the upper triangle */
            double *block = sn_blocks_at(to->blocks, at, column);
            if (block == NULL) return false;
            add_product(block, to->blocks->size, row, i, j);
        }
    }
    return true;
}

static bool build_matrix(sn_preconditioner *p, rest_matrix *matrix, int size) {
    builder to = {p, &matrix->blocks};
    if (matrix->blocks.last != NULL) return true;
    bool made = sn_blocks_create(to.blocks, size, p->free_count) && sn_rest_rows(p->model, add_row, &to) && sn_blocks_close(to.blocks);
    if (!made) sn_blocks_free(to.blocks);
    return made;
}

static bool factor(sn_preconditioner *p, rest_matrix *matrix, double h, double stiffness) {
    if (matrix->factor != NULL && matrix->factor_h == h && matrix->factor_stiffness == stiffness) return true;
    sn_blocks *blocks = &matrix->blocks;
    for (sn_index i = 0; i < p->free_count; i++) p->mass[i] = 1.0 / (p->model->inverse_mass[p->point_of[i]] * h * h);
    sn_blocks_entries(blocks, stiffness, p->mass);
    sn_status status = matrix->factor == NULL
                           ? sn_sparse_factor(blocks->size * p->free_count, blocks->entry_count, blocks->entries, &matrix->factor, NULL)
                           : sn_sparse_refactor(matrix->factor, blocks->entries, NULL);
    matrix->factor_h = status == SN_OK ? h : 0.0;
    matrix->factor_stiffness = stiffness;
    return status == SN_OK;
}

/* ---- made and unmade -------------------------------------------------------------------------------------------------------- */

static bool number_points(sn_preconditioner *p, const sn_model_muscle *m) {
    p->number_of = SN_NEW(sn_index, m->point_count);
    p->point_of = SN_NEW(sn_index, m->point_count);
    if (p->number_of == NULL || p->point_of == NULL) return false;
    sn_index next = 0;
    for (int carried = 0; carried < 2; carried++) {
        for (sn_index i = 0; i < m->point_count; i++) {
            if ((m->inverse_mass[i] == 0.0) != (carried == 1)) continue;
            p->number_of[i] = next;
            p->point_of[next++] = i;
        }
        if (carried == 0) p->free_count = next;
    }
    return true;
}

static bool make_scratch(sn_preconditioner *p) {
    p->mass = SN_NEW(double, p->free_count);
    p->right = SN_NEW(double, 6 * (size_t)p->free_count);
    p->solution = SN_NEW(double, 6 * (size_t)p->free_count);
    p->volume_gradient = SN_NEW(sn_vec3, p->point_count);
    p->volume_solved = SN_NEW(sn_vec3, p->point_count);
    return p->mass != NULL && p->right != NULL && p->solution != NULL && p->volume_gradient != NULL && p->volume_solved != NULL;
}

sn_status sn_preconditioner_create(const sn_model_muscle *m, sn_preconditioner **out, sn_error *error) {
    *out = NULL;
    sn_preconditioner *p = SN_NEW(sn_preconditioner, 1);
    if (p == NULL) return sn_fail_memory(error, "the preconditioner");
    *p = (sn_preconditioner){.model = m, .point_count = m->point_count, .vertex_count = m->vertex_count};
    if (!number_points(p, m) || !make_scratch(p) || (m->two_level && !sn_two_level_create(m, &p->coarse))) {
        sn_preconditioner_destroy(p);
        return sn_fail_memory(error, "the preconditioner");
    }
    *out = p;
    return SN_OK;
}

static void free_matrix(rest_matrix *matrix) {
    sn_blocks_free(&matrix->blocks);
    sn_sparse_destroy(matrix->factor);
}

void sn_preconditioner_destroy(sn_preconditioner *p) {
    if (p == NULL) return;
    free_matrix(&p->scalar);
    free_matrix(&p->corotated);
    sn_frames_free(&p->frames);
    sn_two_level_free(&p->coarse);
    free(p->number_of);
    free(p->point_of);
    free(p->mass);
    free(p->right);
    free(p->solution);
    free(p->volume_gradient);
    free(p->volume_solved);
    free(p);
}

/* ---- the start of a substep ----------------------------------------------------------------------------------------------- */

static const double REFACTOR_RATIO = 2.0;

static bool within_ratio(double a, double b) { return fmax(a, b) <= REFACTOR_RATIO * fmin(a, b); }

static bool make_frames(sn_preconditioner *p) { return p->frames.model != NULL || sn_frames_create(p->model, SECTIONS, &p->frames); }

bool sn_preconditioner_update(sn_preconditioner *p, double h, double stiffness, sn_quat *turns, double *factored_for, bool *changed) {
    rest_matrix *matrix = turns != NULL ? &p->corotated : &p->scalar;
    *changed = false;
    p->turns = turns;
    if (p->free_count == 0) return true;
    *changed = isnan(*factored_for) || !within_ratio(*factored_for, stiffness);
    if (*changed) *factored_for = stiffness;
    if (turns != NULL && !make_frames(p)) return false;
    return build_matrix(p, matrix, turns != NULL ? 3 : 1) && factor(p, matrix, h, *factored_for);
}

void sn_preconditioner_correct(sn_preconditioner *p, const sn_vec3 *positions, double h, double stiffness) {
    p->corrects = positions != NULL && p->coarse.model != NULL;
    if (p->corrects) sn_two_level_update(&p->coarse, positions, h, stiffness);
}

void sn_preconditioner_turn(sn_preconditioner *p, const sn_point *points) {
    if (p->turns != NULL && p->free_count > 0) sn_frames_turn(&p->frames, points, p->turns);
}

/* The scalar matrix already makes a part of the motion that the coarse space finds whole: of 20 muscles at 5 iterations the worst error is
 * 2.9e-4 L with this share, 4.7e-4 with 1 and 3.2e-4 with 0.6 (tests/bench/sim_body.c). */
static const double COARSE_SHARE = 0.8;

/* ---- apply ------------------------------------------------------------------------------------------------------------------ */

static sn_vec3 turned_back(const sn_preconditioner *p, sn_index point, sn_vec3 v) {
    return sn_quat_rotate(sn_quat_conjugate(p->turns[point]), v);
}

/* Numbers of the free points as the matrix orders them: scalar one axis after the other, corotated point after point in their frames. */
static void gather(const sn_preconditioner *p, const sn_vec3 *in, double *out) {
    size_t n = (size_t)p->free_count, across = p->turns != NULL ? 1 : n, along = p->turns != NULL ? 3 : 1;
    for (size_t i = 0; i < n; i++) {
        sn_index point = p->point_of[i];
        sn_vec3 value = p->turns != NULL ? turned_back(p, point, in[point]) : in[point];
        double *to = out + along * i;
        to[0] = value.x, to[across] = value.y, to[2 * across] = value.z;
    }
}

/* And back; zero elsewhere. */
static void scatter(const sn_preconditioner *p, const double *in, sn_vec3 *out) {
    size_t n = (size_t)p->free_count, across = p->turns != NULL ? 1 : n, along = p->turns != NULL ? 3 : 1;
    for (size_t i = 0; i < n; i++) {
        const double *from = in + along * i;
        sn_vec3 value = sn_v3(from[0], from[across], from[2 * across]);
        out[p->point_of[i]] = p->turns != NULL ? sn_quat_rotate(p->turns[p->point_of[i]], value) : value;
    }
    for (sn_index i = p->free_count; i < p->point_count; i++) out[p->point_of[i]] = sn_v3(0, 0, 0);
}

void sn_preconditioner_set_volume(sn_preconditioner *p, const sn_vec3 *volume_gradient, double volume_stiffness) {
    p->volume_scale = 0.0;
    p->volume_stiffness = p->free_count > 0 ? volume_stiffness : 0.0;
    if (!(p->volume_stiffness > 0.0)) return;
    for (sn_index i = 0; i < p->vertex_count; i++)
        p->volume_gradient[i] = p->number_of[i] >= p->free_count ? sn_v3(0, 0, 0) : volume_gradient[i];
}

/* A^-1 g has come: with it the row's scale. */
static void take_volume(sn_preconditioner *p, const double *solution) {
    double product = 0.0;
    if (p->corrects) sn_two_level_solve(&p->coarse, p->volume_gradient);
    scatter(p, solution, p->volume_solved);
    if (p->corrects) sn_two_level_add(&p->coarse, COARSE_SHARE, p->volume_solved);
    for (sn_index i = 0; i < p->vertex_count; i++) product += sn_dot(p->volume_gradient[i], p->volume_solved[i]);
    p->volume_scale = p->volume_stiffness / (1.0 + p->volume_stiffness * product);
    p->volume_stiffness = 0.0;
}

bool sn_preconditioner_apply(sn_preconditioner *p, const sn_vec3 *in, sn_vec3 *out) {
    const rest_matrix *matrix = p->turns != NULL ? &p->corotated : &p->scalar;
    sn_index columns = p->turns != NULL ? 1 : 3;
    size_t numbers = 3 * (size_t)p->free_count;
    bool both = p->volume_stiffness > 0.0; /* one pass over the factor for the two of them */
    gather(p, in, p->right);
    if (both) gather(p, p->volume_gradient, p->right + numbers);
    if (matrix->factor == NULL || sn_sparse_solve(matrix->factor, both ? 2 * columns : columns, p->right, p->solution, NULL) != SN_OK)
        return false;
    if (both) take_volume(p, p->solution + numbers);
    double along = 0.0;
    for (sn_index i = 0; p->volume_scale > 0.0 && i < p->vertex_count; i++) along += sn_dot(p->volume_solved[i], in[i]);
    if (p->corrects) sn_two_level_solve(&p->coarse, in);
    scatter(p, p->solution, out);
    if (p->corrects) sn_two_level_add(&p->coarse, COARSE_SHARE, out);
    double scale = -p->volume_scale * along;
    for (sn_index i = 0; p->volume_scale > 0.0 && i < p->point_count; i++) out[i] = sn_add_scaled(out[i], p->volume_solved[i], scale);
    return true;
}

/* The block times v, in the frames of its points. */
static sn_vec3 block_times(const sn_preconditioner *p, const sn_block *block, sn_vec3 v) {
    const double *b = block->value;
    if (p->turns == NULL) return sn_scale(v, *b);
    v = turned_back(p, p->point_of[block->column], v);
    v = sn_v3(b[0] * v.x + b[1] * v.y + b[2] * v.z, b[3] * v.x + b[4] * v.y + b[5] * v.z, b[6] * v.x + b[7] * v.y + b[8] * v.z);
    return sn_quat_rotate(p->turns[p->point_of[block->row]], v);
}

void sn_preconditioner_add_jump(const sn_preconditioner *p, const sn_vec3 *jump, const sn_vec3 *volume_gradient, double volume_stiffness,
                                sn_vec3 *in) {
    const rest_matrix *matrix = p->turns != NULL ? &p->corotated : &p->scalar;
    for (sn_index i = p->free_count; i < matrix->blocks.count; i++) {
        const sn_block *block = &matrix->blocks.blocks[i];
        if (block->column < p->free_count) continue;
        sn_index to = p->point_of[block->row];
        in[to] = sn_add_scaled(in[to], block_times(p, block, jump[p->point_of[block->column]]), matrix->factor_stiffness);
    }
    if (!(volume_stiffness > 0.0)) return;
    double along = 0.0;
    for (sn_index i = p->free_count; i < p->point_count; i++)
        if (p->point_of[i] < p->vertex_count) along += sn_dot(volume_gradient[p->point_of[i]], jump[p->point_of[i]]);
    for (sn_index i = 0; i < p->free_count && p->point_of[i] < p->vertex_count; i++) {
        sn_index v = p->point_of[i];
        in[v] = sn_add_scaled(in[v], volume_gradient[v], volume_stiffness * along);
    }
}
