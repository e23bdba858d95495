/*
 * precondition.c -- the constant matrix of the quasi-Newton back end: mass and the rest shape's stiffness, factored once.   numerics.md 2
 *
 * A spring between two points bounds its Hessian by k (e_i - e_j)(e_i - e_j)T on each axis; a hinge its by k_b K KT with the rest weights
 *   K_c = |e|/|n1|, K_d = |e|/|n2|, K_a = -(b-c).e/|n1| - (b-d).e/|n2|, K_b = (a-c).e/|n1| + (a-d).e/|n2|   (e a unit vector here)
 */
#include "qn.h"

#include <stdlib.h>
#include <string.h>

/* One entry of S or of M; row and column are free points of the matrix, or, in a coupling, a free and a carried point of the muscle. */
typedef struct coupling {
    sn_index free_point, carried_point;
    double value; /* of S */
} coupling;

struct sn_preconditioner {
    sn_index point_count, vertex_count, free_count;
    sn_index *free_of;  /* (point_count) index in the matrix, or SN_NONE */
    sn_index *point_of; /* (free_count) */
    double *mass;       /* (free_count) kg */
    size_t entry_count, entry_capacity, coupling_count, coupling_capacity;
    sn_entry *entries;   /* (entry_count) of S; the first free_count are the diagonal, where M/h^2 goes too */
    sn_entry *values;    /* (entry_count) of A, made for the factor */
    coupling *couplings; /* (coupling_count) */
    sn_sparse *factor;   /* NULL = none yet */
    double factor_h, factor_stiffness;
    double *right, *solution; /* (6 free_count) one axis after the other; of the volume row behind those of the caller */
    sn_vec3 *volume_gradient; /* (point_count) g on free points, zero elsewhere */
    sn_vec3 *volume_solved;   /* (point_count) A^-1 g */
    double volume_stiffness;  /* k_V where A^-1 g is still to be found, by the next solve; 0 = nothing to find */
    double volume_scale;      /* k_V / (1 + k_V gT A^-1 g); 0 = no volume row */
};

/* ---- building S --------------------------------------------------------------------------------------------------------- */

static bool add_entry(sn_preconditioner *p, sn_index row, sn_index column, double value) {
    if (!sn_grow((void **)&p->entries, &p->entry_capacity, p->entry_count + 1, sizeof *p->entries)) return false;
    p->entries[p->entry_count++] = (sn_entry){row, column, value};
    return true;
}

static bool add_coupling(sn_preconditioner *p, sn_index free_point, sn_index carried_point, double value) {
    if (!sn_grow((void **)&p->couplings, &p->coupling_capacity, p->coupling_count + 1, sizeof *p->couplings)) return false;
    p->couplings[p->coupling_count++] = (coupling){free_point, carried_point, value};
    return true;
}

/* S += scale K KT for the row K of `count` weights at these points. */
static bool add_row(sn_preconditioner *p, int count, const sn_index *point, const double *weight, double scale) {
    bool added = true;
    for (int i = 0; i < count; i++) {
        sn_index row = p->free_of[point[i]];
        if (row == SN_NONE) continue;
        p->entries[row].value += scale * weight[i] * weight[i];
        for (int j = 0; j < count && added; j++) {
            sn_index column = p->free_of[point[j]];
            double value = scale * weight[i] * weight[j];
            if (column == SN_NONE)
                added = add_coupling(p, point[i], point[j], value);
            else if (j < i)
                added = add_entry(p, row, column, value);
        }
    }
    return added;
}

static bool add_distances(sn_preconditioner *p, const sn_model_muscle *m) {
    static const double weight[2] = {1.0, -1.0};
    for (int kind = 0; kind < SN_DISTANCE_KINDS; kind++) {
        double scale = kind == SN_ROWS_MESH ? 1.0 : m->source->stiffness_internal;
        for (sn_index r = m->distance_start[kind]; r < m->distance_start[kind + 1]; r++) {
            double softness = m->distance_softness != NULL ? m->distance_softness[r] : 1.0;
            if (!add_row(p, 2, m->distances[r].point, weight, scale / softness)) return false;
        }
    }
    return true;
}

/* The weights of a hinge at rest; the rows were built from hinges that have them. */
static void hinge_weights(const sn_model_muscle *m, const sn_hinge_row *row, double weight[4]) {
    sn_vec3 a = m->rest[row->point[0]], b = m->rest[row->point[1]], c = m->rest[row->point[2]], d = m->rest[row->point[3]];
    sn_vec3 e = sn_sub(b, a), ac = sn_sub(a, c), bc = sn_sub(b, c), ad = sn_sub(a, d), bd = sn_sub(b, d);
    double length = sn_norm(e), n1 = sn_norm(sn_cross(ac, bc)), n2 = sn_norm(sn_cross(bd, ad));
    sn_vec3 unit = sn_scale(e, 1.0 / length);
    weight[0] = -sn_dot(bc, unit) / n1 - sn_dot(bd, unit) / n2;
    weight[1] = sn_dot(ac, unit) / n1 + sn_dot(ad, unit) / n2;
    weight[2] = length / n1;
    weight[3] = length / n2;
}

static bool add_hinges(sn_preconditioner *p, const sn_model_muscle *m) {
    for (sn_index r = 0; r < m->hinge_count; r++) {
        double weight[4], softness = m->hinge_softness != NULL ? m->hinge_softness[r] : 1.0;
        hinge_weights(m, &m->hinges[r], weight);
        if (!add_row(p, 4, m->hinges[r].point, weight, m->source->stiffness_dihedral / softness)) return false;
    }
    return true;
}

static bool number_points(sn_preconditioner *p, const sn_model_muscle *m) {
    p->point_count = m->point_count;
    p->vertex_count = m->vertex_count;
    p->free_of = SN_NEW(sn_index, m->point_count);
    p->point_of = SN_NEW(sn_index, m->point_count);
    p->mass = SN_NEW(double, m->point_count);
    if (p->free_of == NULL || p->point_of == NULL || p->mass == NULL) return false;
    for (sn_index i = 0; i < m->point_count; i++) {
        p->free_of[i] = SN_NONE;
        if (m->inverse_mass[i] == 0.0) continue;
        p->free_of[i] = p->free_count;
        p->mass[p->free_count] = 1.0 / m->inverse_mass[i];
        p->point_of[p->free_count++] = i;
    }
    for (sn_index i = 0; i < p->free_count; i++)
        if (!add_entry(p, i, i, 0.0)) return false;
    return true;
}

static bool make_scratch(sn_preconditioner *p) {
    p->values = SN_NEW(sn_entry, p->entry_count);
    p->right = SN_NEW(double, 6 * (size_t)p->free_count);
    p->solution = SN_NEW(double, 6 * (size_t)p->free_count);
    p->volume_gradient = SN_NEW(sn_vec3, p->point_count);
    p->volume_solved = SN_NEW(sn_vec3, p->point_count);
    return p->values != NULL && p->right != NULL && p->solution != NULL && p->volume_gradient != NULL && p->volume_solved != NULL;
}

sn_status sn_preconditioner_create(const sn_model_muscle *m, sn_preconditioner **out, sn_error *error) {
    *out = NULL;
    sn_preconditioner *p = SN_NEW(sn_preconditioner, 1);
    if (p == NULL) return sn_fail_memory(error, "the preconditioner");
    bool made = number_points(p, m) && add_distances(p, m) && add_hinges(p, m) && p->entry_count <= (size_t)SN_INDEX_MAX && make_scratch(p);
    if (!made) {
        sn_preconditioner_destroy(p);
        return sn_fail_memory(error, "the preconditioner");
    }
    *out = p;
    return SN_OK;
}

void sn_preconditioner_destroy(sn_preconditioner *p) {
    if (p == NULL) return;
    sn_sparse_destroy(p->factor);
    free(p->free_of);
    free(p->point_of);
    free(p->mass);
    free(p->entries);
    free(p->values);
    free(p->couplings);
    free(p->right);
    free(p->solution);
    free(p->volume_gradient);
    free(p->volume_solved);
    free(p);
}

/* ---- factor --------------------------------------------------------------------------------------------------------------- */

static const double REFACTOR_RATIO = 2.0;

static bool within_ratio(double a, double b) { return fmax(a, b) <= REFACTOR_RATIO * fmin(a, b); }

static bool factor(sn_preconditioner *p, double h, double stiffness) {
    if (p->factor != NULL && p->factor_h == h && p->factor_stiffness == stiffness) return true;
    for (size_t i = 0; i < p->entry_count; i++) {
        p->values[i] = p->entries[i];
        p->values[i].value *= stiffness;
    }
    for (sn_index i = 0; i < p->free_count; i++) p->values[i].value += p->mass[i] / (h * h);
    sn_status status = p->factor == NULL ? sn_sparse_factor(p->free_count, (sn_index)p->entry_count, p->values, &p->factor, NULL)
                                         : sn_sparse_refactor(p->factor, p->values, NULL);
    p->factor_h = status == SN_OK ? h : 0.0;
    p->factor_stiffness = stiffness;
    return status == SN_OK;
}

bool sn_preconditioner_update(sn_preconditioner *p, double h, double stiffness, double *factored_for, bool *changed) {
    *changed = false;
    if (p->free_count == 0) return true;
    bool kept = !isnan(*factored_for) && within_ratio(*factored_for, stiffness);
    if (!kept) *factored_for = stiffness;
    *changed = !kept;
    return factor(p, h, *factored_for);
}

/* ---- apply ------------------------------------------------------------------------------------------------------------------ */

/* Numbers of the free points, one axis after the other; and back, zero elsewhere. */
static void gather(const sn_preconditioner *p, const sn_vec3 *in, double *out) {
    size_t n = (size_t)p->free_count;
    for (size_t i = 0; i < n; i++) {
        sn_vec3 value = in[p->point_of[i]];
        out[i] = value.x, out[n + i] = value.y, out[2 * n + i] = value.z;
    }
}

static void scatter(const sn_preconditioner *p, const double *in, sn_vec3 *out) {
    size_t n = (size_t)p->free_count;
    memset(out, 0, (size_t)p->point_count * sizeof *out);
    for (size_t i = 0; i < n; i++) out[p->point_of[i]] = sn_v3(in[i], in[n + i], in[2 * n + i]);
}

void sn_preconditioner_set_volume(sn_preconditioner *p, const sn_vec3 *volume_gradient, double volume_stiffness) {
    p->volume_scale = 0.0;
    p->volume_stiffness = p->free_count > 0 ? volume_stiffness : 0.0;
    if (!(p->volume_stiffness > 0.0)) return;
    for (sn_index i = 0; i < p->vertex_count; i++) p->volume_gradient[i] = p->free_of[i] == SN_NONE ? sn_v3(0, 0, 0) : volume_gradient[i];
}

/* A^-1 g has come: with it the row's scale. */
static void take_volume(sn_preconditioner *p, const double *solution) {
    double product = 0.0;
    scatter(p, solution, p->volume_solved);
    for (sn_index i = 0; i < p->vertex_count; i++) product += sn_dot(p->volume_gradient[i], p->volume_solved[i]);
    p->volume_scale = p->volume_stiffness / (1.0 + p->volume_stiffness * product);
    p->volume_stiffness = 0.0;
}

bool sn_preconditioner_apply(sn_preconditioner *p, const sn_vec3 *in, sn_vec3 *out) {
    size_t n = (size_t)p->free_count;
    bool both = p->volume_stiffness > 0.0; /* one pass over the factor for the two of them */
    gather(p, in, p->right);
    if (both) gather(p, p->volume_gradient, p->right + 3 * n);
    if (p->factor == NULL || sn_sparse_solve(p->factor, both ? 6 : 3, p->right, p->solution, NULL) != SN_OK) return false;
    if (both) take_volume(p, p->solution + 3 * n);
    double along = 0.0;
    for (sn_index i = 0; p->volume_scale > 0.0 && i < p->vertex_count; i++) along += sn_dot(p->volume_solved[i], in[i]);
    scatter(p, p->solution, out);
    double scale = -p->volume_scale * along;
    for (sn_index i = 0; p->volume_scale > 0.0 && i < p->point_count; i++) out[i] = sn_add_scaled(out[i], p->volume_solved[i], scale);
    return true;
}

void sn_preconditioner_add_jump(const sn_preconditioner *p, const sn_vec3 *jump, const sn_vec3 *volume_gradient, double volume_stiffness,
                                sn_vec3 *in) {
    for (size_t i = 0; i < p->coupling_count; i++) {
        const coupling *c = &p->couplings[i];
        in[c->free_point] = sn_add_scaled(in[c->free_point], jump[c->carried_point], p->factor_stiffness * c->value);
    }
    if (!(volume_stiffness > 0.0)) return;
    double along = 0.0;
    for (sn_index i = 0; i < p->vertex_count; i++)
        if (p->free_of[i] == SN_NONE) along += sn_dot(volume_gradient[i], jump[i]);
    for (sn_index i = 0; i < p->free_count && p->point_of[i] < p->vertex_count; i++) {
        sn_index v = p->point_of[i];
        in[v] = sn_add_scaled(in[v], volume_gradient[v], volume_stiffness * along);
    }
}
