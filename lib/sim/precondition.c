/*
 * precondition.c -- what the quasi-Newton back end knows of the stiffness: mass and the rest shape, factored once.   numerics.md 2, 7
 *
 *   scalar     A = M/h^2 + k sum scale K KT, one n x n matrix for x, y and z: blind to rotations, and safe at any shape
 *   corotated  A = R (M/h^2 + k sum scale g gT) RT, 3n x 3n: the Hessian of the rest shape, turned with the muscle by the frames of its
 *              sections. It knows directions, and is no good where triangles have collapsed or edges are far from their length
 *   two-level  A^-1 + 0.8 Z (ZT H Z)^-1 ZT with the scalar A: rigid motions of sections are solved for where the muscle is (two_level.c)
 *
 * One factor for a group of muscles that are solved together, a muscle alone being a group of one: their points are numbered one member
 * after the other. External constraints are in the scalar matrix alone, each with the k of the softer of its muscles (couplings). The
 * volume row of a muscle alone is added by the formula of Sherman and Morrison, those of a group by deflation (deflate.h).
 *
 * Which of them a substep goes by is decided at its start; a matrix that is never asked for is never made.
 */
#include "blocks.h"
#include "deflate.h"
#include "external.h"
#include "frames.h"
#include "qn.h"
#include "two_level.h"

#include <stdlib.h>
#include <string.h>

/* Sections of the frames: as many as it takes to follow a bend around the thickness of a muscle. */
enum { SECTIONS = 24 };

/* The matrix of one kind. A column of free_count + c couples a free point with the carried point c. */
typedef struct rest_matrix {
    sn_blocks blocks;         /* of the members, over their stiffness */
    sn_sparse *factor;        /* NULL = none yet */
    double factor_h;          /* 0 = none that holds */
    bool elsewhere;           /* the blocks are those of another shape than the rest shape */
    double *factor_stiffness; /* (count) */
    sn_deflation *deflation;  /* of a group whose volumes are kept; NULL = none yet */
} rest_matrix;

/* An external constraint's share of the scalar matrix, over the k of the softer of its muscles. */
typedef struct coupling {
    sn_index row, column;   /* numbers of points; a column of free_count or more is a carried one */
    sn_index entry;         /* of the matrix, where it is in it */
    sn_index member, other; /* the same one where the target moves by itself */
    double value;
} coupling;

static double coupling_stiffness(const coupling *c, const double *stiffness) { return fmin(stiffness[c->member], stiffness[c->other]); }

struct sn_preconditioner {
    sn_index count;                  /* members of the group */
    const sn_model_muscle **members; /* (count) */
    sn_index *first, *first_free;    /* (count + 1) where the points of a member begin, and its free points among all free ones */
    sn_index point_count, free_count;
    sn_index *number_of; /* (point_count) free points from 0, then the carried ones */
    sn_index *point_of;  /* (point_count) the reverse */
    double *mass;        /* (free_count) kg / h^2 of the last factor */
    rest_matrix scalar, corotated;
    double whole_h; /* s: of a large group, for which all factors are made, however long the step is; 0 = for that of the step */
    sn_index coupling_count;
    size_t coupling_capacity;
    coupling *couplings;      /* (coupling_count) */
    sn_frames *frames;        /* (count) none until they are asked for */
    sn_quat *turns;           /* (point_count) frames of the points; NULL = this substep goes by the scalar matrix */
    sn_two_level *coarse;     /* (count) NULL but under the two-level matrix */
    bool corrects;            /* this substep goes by it */
    sn_vec3 *positions;       /* (point_count) where the scalar matrix was made last, if ever elsewhere than at rest */
    double *right, *solution; /* (6 free_count) of a volume row behind those of the caller */
    sn_vec3 *volume_gradient; /* (point_count) g of each member's volume on its free points, zero elsewhere */
    sn_vec3 *volume_solved;   /* (point_count) A^-1 g of a muscle alone; of a group, room */
    double *volume_stiffness; /* (count) k_V of rows that are still to be solved for, by the next solve; 0 = nothing to find */
    double volume_scale;      /* k_V / (1 + k_V gT A^-1 g) of a muscle alone; 0 = no volume row */
    bool volumes_set;         /* to be given to the deflation of a group by the next solve */
};

/* ---- the rest shape's matrices ------------------------------------------------------------------------------------------------ */

typedef struct builder {
    const sn_preconditioner *p;
    sn_blocks *blocks;
    sn_index first; /* point of the group that is the rows' point 0 */
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
        sn_index at = to->p->number_of[to->first + row->point[i]];
        if (at >= to->p->free_count) continue;
        for (int j = 0; j < row->count; j++) {
            sn_index column = to->p->number_of[to->first + row->point[j]];
            if (column > at && column < to->p->free_count) continue; /* the upper triangle */
            double *block = sn_blocks_at(to->blocks, at, column);
            if (block == NULL) return false;
            add_product(block, to->blocks->size, row, i, j);
        }
    }
    return true;
}

/* The rows of all members at positions (point_count); NULL: at rest. */
static bool add_members(const sn_preconditioner *p, sn_blocks *blocks, const sn_vec3 *positions) {
    bool made = true;
    for (sn_index i = 0; i < p->count && made; i++) {
        builder to = {p, blocks, p->first[i]};
        made = sn_rows_at(p->members[i], positions != NULL ? positions + p->first[i] : p->members[i]->rest, add_row, &to);
    }
    return made;
}

/* What is at hand is made anew elsewhere, or again at rest (NULL). */
static bool move_matrix(sn_preconditioner *p, rest_matrix *matrix, const sn_vec3 *positions) {
    matrix->factor_h = 0.0;
    matrix->elsewhere = positions != NULL;
    sn_blocks_clear(&matrix->blocks);
    return add_members(p, &matrix->blocks, positions);
}

/* Room for the couplings in the scalar matrix. */
static bool make_couplings_room(const sn_preconditioner *p, sn_blocks *blocks) {
    bool made = true;
    for (sn_index i = 0; i < p->coupling_count && made; i++)
        if (p->couplings[i].column < p->free_count) made = sn_blocks_at(blocks, p->couplings[i].row, p->couplings[i].column) != NULL;
    return made;
}

/* Which entry each coupling is in: blocks of one number have one, in their order, but for those of carried points. */
static bool place_couplings(sn_preconditioner *p, const sn_blocks *blocks) {
    sn_index *entries = SN_NEW(sn_index, blocks->count), next = 0;
    if (entries == NULL) return false;
    for (sn_index i = 0; i < blocks->count; i++) entries[i] = blocks->blocks[i].column < blocks->rows ? next++ : SN_NONE;
    for (sn_index i = 0; i < p->coupling_count; i++) {
        coupling *c = &p->couplings[i];
        if (c->column < p->free_count) c->entry = entries[sn_blocks_find(blocks, c->row, c->column)];
    }
    free(entries);
    return true;
}

static bool build_members(sn_preconditioner *p, sn_blocks *blocks, int size) {
    bool couples = size == 1 && p->coupling_count > 0;
    return sn_blocks_create(blocks, size, p->free_count) && add_members(p, blocks, NULL) && (!couples || make_couplings_room(p, blocks)) &&
           sn_blocks_close(blocks) && (!couples || place_couplings(p, blocks));
}

static void free_matrix(rest_matrix *matrix) {
    sn_blocks_free(&matrix->blocks);
    sn_sparse_destroy(matrix->factor);
    free(matrix->factor_stiffness);
    sn_deflation_destroy(matrix->deflation);
    *matrix = (rest_matrix){.factor = NULL};
}

static bool build_matrix(sn_preconditioner *p, rest_matrix *matrix, int size) {
    if (matrix->blocks.last != NULL) return !matrix->elsewhere || move_matrix(p, matrix, NULL);
    matrix->factor_stiffness = SN_NEW(double, p->count);
    bool made = matrix->factor_stiffness != NULL && build_members(p, &matrix->blocks, size);
    if (!made) free_matrix(matrix);
    return made;
}

static bool is_factored_for(const sn_preconditioner *p, const rest_matrix *matrix, double h, const double *stiffness) {
    if (matrix->factor == NULL || matrix->factor_h != h) return false;
    return memcmp(matrix->factor_stiffness, stiffness, (size_t)p->count * sizeof *stiffness) == 0;
}

/* What the volumes of a group go by; nothing for a muscle alone. */
static bool split_members(const sn_preconditioner *p, rest_matrix *matrix) {
    const sn_blocks *b = &matrix->blocks;
    bool keeps = false;
    for (sn_index k = 0; k < p->count; k++) keeps = keeps || p->members[k]->keeps_volume;
    if (p->count == 1 || !keeps) return true;
    if (matrix->deflation == NULL) matrix->deflation = sn_deflation_create(p->count, p->first_free, b->size, b->entry_count, b->entries);
    return matrix->deflation != NULL && sn_deflation_factor(matrix->deflation, b->entries);
}

static bool factor(sn_preconditioner *p, rest_matrix *matrix, double h, const double *stiffness) {
    if (p->whole_h > 0.0) h = p->whole_h;
    if (is_factored_for(p, matrix, h, stiffness)) return true;
    for (sn_index k = 0; k < p->count; k++)
        for (sn_index i = p->first_free[k]; i < p->first_free[k + 1]; i++)
            p->mass[i] = 1.0 / (p->members[k]->inverse_mass[p->point_of[i] - p->first[k]] * h * h);
    sn_blocks *b = &matrix->blocks;
    sn_blocks_entries(b, p->count, p->first_free, stiffness, p->mass);
    for (sn_index i = 0; i < p->coupling_count && b->size == 1; i++) {
        const coupling *c = &p->couplings[i];
        if (c->column < p->free_count) b->entries[c->entry].value += coupling_stiffness(c, stiffness) * c->value;
    }
    if (!split_members(p, matrix)) return false;
    sn_status status = matrix->factor == NULL ? sn_sparse_factor(b->size * p->free_count, b->entry_count, b->entries, &matrix->factor, NULL)
                                              : sn_sparse_refactor(matrix->factor, b->entries, NULL);
    matrix->factor_h = status == SN_OK ? h : 0.0;
    memcpy(matrix->factor_stiffness, stiffness, (size_t)p->count * sizeof *stiffness);
    return status == SN_OK;
}

/* ---- made and unmade -------------------------------------------------------------------------------------------------------- */

static bool take_members(sn_preconditioner *p, const sn_model_muscle *const *members) {
    p->members = sn_alloc((size_t)p->count, sizeof *p->members);
    p->first = SN_NEW(sn_index, p->count + 1);
    p->first_free = SN_NEW(sn_index, p->count + 1);
    if (p->members == NULL || p->first == NULL || p->first_free == NULL) return false;
    for (sn_index i = 0; i < p->count; i++) {
        p->members[i] = members[i];
        if (members[i]->point_count > SN_INDEX_MAX - p->first[i]) return false;
        p->first[i + 1] = p->first[i] + members[i]->point_count;
    }
    p->point_count = p->first[p->count];
    return true;
}

static bool number_points(sn_preconditioner *p) {
    p->number_of = SN_NEW(sn_index, p->point_count);
    p->point_of = SN_NEW(sn_index, p->point_count);
    if (p->number_of == NULL || p->point_of == NULL) return false;
    sn_index next = 0;
    for (int carried = 0; carried < 2; carried++) {
        for (sn_index k = 0; k < p->count; k++) {
            if (carried == 0) p->first_free[k] = next;
            for (sn_index i = 0; i < p->members[k]->point_count; i++) {
                if ((p->members[k]->inverse_mass[i] == 0.0) != (carried == 1)) continue;
                p->number_of[p->first[k] + i] = next;
                p->point_of[next++] = p->first[k] + i;
            }
        }
        if (carried == 0) p->free_count = p->first_free[p->count] = next;
    }
    return true;
}

static bool make_scratch(sn_preconditioner *p) {
    p->mass = SN_NEW(double, p->free_count);
    p->right = SN_NEW(double, 6 * (size_t)p->free_count);
    p->solution = SN_NEW(double, 6 * (size_t)p->free_count);
    p->volume_gradient = SN_NEW(sn_vec3, p->point_count);
    p->volume_solved = SN_NEW(sn_vec3, p->point_count);
    p->volume_stiffness = SN_NEW(double, p->count);
    return p->mass != NULL && p->right != NULL && p->solution != NULL && p->volume_gradient != NULL && p->volume_solved != NULL &&
           p->volume_stiffness != NULL;
}

static bool make_coarse(sn_preconditioner *p) {
    bool made = true;
    for (sn_index i = 0; i < p->count && made; i++) {
        if (!p->members[i]->two_level) continue;
        if (p->coarse == NULL) p->coarse = SN_NEW(sn_two_level, p->count);
        made = p->coarse != NULL && sn_two_level_create(p->members[i], &p->coarse[i]);
    }
    return made;
}

sn_status sn_preconditioner_create(sn_index count, const sn_model_muscle *const *members, sn_preconditioner **out, sn_error *error) {
    *out = NULL;
    sn_preconditioner *p = SN_NEW(sn_preconditioner, 1);
    if (p == NULL) return sn_fail_memory(error, "the preconditioner");
    *p = (sn_preconditioner){.count = count};
    if (!take_members(p, members) || !number_points(p) || !make_scratch(p) || !make_coarse(p)) {
        sn_preconditioner_destroy(p);
        return sn_fail_memory(error, "the preconditioner");
    }
    *out = p;
    return SN_OK;
}

/* Who couples, and its member at hand. */
typedef struct coupler {
    sn_preconditioner *p;
    sn_index member;
} coupler;

/* Whose point of the group it is. */
static sn_index member_of(const sn_preconditioner *p, sn_index point) {
    sn_index member = 0;
    while (point >= p->first[member + 1]) member++;
    return member;
}

static bool add_coupling(void *user, const sn_rest_row *row) {
    const coupler *of = user;
    sn_preconditioner *p = of->p;
    sn_index other = row->count > 1 ? member_of(p, p->first[of->member] + row->point[1]) : of->member;
    for (int i = 0; i < row->count; i++) {
        sn_index at = p->number_of[p->first[of->member] + row->point[i]];
        if (at >= p->free_count) continue;
        for (int j = 0; j < row->count; j++) {
            sn_index column = p->number_of[p->first[of->member] + row->point[j]];
            if (column > at && column < p->free_count) continue; /* the upper triangle */
            if (!sn_grow((void **)&p->couplings, &p->coupling_capacity, (size_t)p->coupling_count + 1, sizeof *p->couplings)) return false;
            double value = row->scale * row->weight[i] * row->weight[j];
            p->couplings[p->coupling_count++] =
                (coupling){.row = at, .column = column, .member = of->member, .other = other, .value = value};
        }
    }
    return true;
}

sn_status sn_preconditioner_couple(sn_preconditioner *p, const sn_group *g, sn_error *error) {
    p->whole_h = g->large ? g->substep_duration : 0.0;
    for (sn_index i = 0; i < g->count; i++)
        if (!sn_externals_at_bind(g, i, add_coupling, &(coupler){p, i})) return sn_fail_memory(error, "the preconditioner");
    return SN_OK;
}

void sn_preconditioner_destroy(sn_preconditioner *p) {
    if (p == NULL) return;
    free(p->couplings);
    free_matrix(&p->scalar);
    free_matrix(&p->corotated);
    for (sn_index i = 0; i < p->count && p->frames != NULL; i++) sn_frames_free(&p->frames[i]);
    for (sn_index i = 0; i < p->count && p->coarse != NULL; i++) sn_two_level_free(&p->coarse[i]);
    free(p->frames);
    free(p->coarse);
    free(p->members);
    free(p->first);
    free(p->first_free);
    free(p->number_of);
    free(p->point_of);
    free(p->positions);
    free(p->mass);
    free(p->right);
    free(p->solution);
    free(p->volume_gradient);
    free(p->volume_solved);
    free(p->volume_stiffness);
    free(p);
}

/* ---- the start of a substep ----------------------------------------------------------------------------------------------- */

static const double REFACTOR_RATIO = 2.0;

static bool within_ratio(double a, double b) { return fmax(a, b) <= REFACTOR_RATIO * fmin(a, b); }

static bool make_frames(sn_preconditioner *p) {
    bool made = p->frames != NULL || (p->frames = SN_NEW(sn_frames, p->count)) != NULL;
    for (sn_index i = 0; i < p->count && made; i++)
        made = p->frames[i].model != NULL || sn_frames_create(p->members[i], SECTIONS, &p->frames[i]);
    return made;
}

bool sn_preconditioner_update(sn_preconditioner *p, double h, const double *stiffness, sn_quat *turns, double *factored_for,
                              bool *changed) {
    rest_matrix *matrix = turns != NULL ? &p->corotated : &p->scalar;
    *changed = false;
    p->turns = turns;
    if (p->free_count == 0) return true;
    for (sn_index i = 0; i < p->count; i++) {
        if (!isnan(factored_for[i]) && within_ratio(factored_for[i], stiffness[i])) continue;
        factored_for[i] = stiffness[i];
        *changed = true;
    }
    if (turns != NULL && !make_frames(p)) return false;
    return build_matrix(p, matrix, turns != NULL ? 3 : 1) && factor(p, matrix, h, factored_for);
}

void sn_preconditioner_correct(sn_preconditioner *p, const sn_vec3 *positions, double h, const double *stiffness) {
    p->corrects = positions != NULL && p->coarse != NULL;
    for (sn_index i = 0; i < p->count && p->corrects; i++)
        if (p->coarse[i].model != NULL) sn_two_level_update(&p->coarse[i], positions + p->first[i], h, stiffness[i]);
}

bool sn_preconditioner_stand(sn_preconditioner *p, const sn_point *points, double h, const double *stiffness) {
    p->turns = NULL;
    p->corrects = false;
    if (p->free_count == 0) return true;
    if (p->scalar.blocks.last == NULL && !build_matrix(p, &p->scalar, 1)) return false; /* so far it went by the corotated one */
    if (p->positions == NULL && (p->positions = SN_NEW(sn_vec3, p->point_count)) == NULL) return false;
    for (sn_index i = 0; i < p->point_count; i++) p->positions[i] = sn_point_position(&points[i]);
    if (move_matrix(p, &p->scalar, p->positions) && factor(p, &p->scalar, h, stiffness)) return true;
    return move_matrix(p, &p->scalar, NULL) && factor(p, &p->scalar, h, stiffness);
}

void sn_preconditioner_turn(sn_preconditioner *p, const sn_point *points) {
    for (sn_index i = 0; i < p->count && p->turns != NULL && p->free_count > 0; i++)
        sn_frames_turn(&p->frames[i], points + p->first[i], p->turns + p->first[i]);
}

/* The scalar matrix already makes a part of the motion that the coarse space finds whole: of 20 muscles at 5 iterations the worst error is
 * 2.9e-4 L with this share, 4.7e-4 with 1 and 3.2e-4 with 0.6 (tests/bench/sim_body.c). */
static const double COARSE_SHARE = 0.8;

/* What the sections of one member make of in (point_count); sn_two_level_solve leaves it in the member's coarse space. */
static void find_coarse(sn_preconditioner *p, sn_index member, const sn_vec3 *in) {
    if (p->corrects && p->coarse[member].model != NULL) sn_two_level_solve(&p->coarse[member], in + p->first[member]);
}

static void add_coarse(sn_preconditioner *p, sn_index member, sn_vec3 *out) {
    if (p->corrects && p->coarse[member].model != NULL) sn_two_level_add(&p->coarse[member], COARSE_SHARE, out + p->first[member]);
}

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

void sn_preconditioner_set_volume(sn_preconditioner *p, const sn_vec3 *volume_gradient, const double *volume_stiffness) {
    p->volume_scale = 0.0;
    p->volumes_set = true;
    for (sn_index k = 0; k < p->count; k++) {
        p->volume_stiffness[k] = p->free_count > 0 && volume_stiffness != NULL ? volume_stiffness[k] : 0.0;
        if (!(p->volume_stiffness[k] > 0.0)) continue;
        for (sn_index i = p->first[k]; i < p->first[k] + p->members[k]->vertex_count; i++)
            p->volume_gradient[i] = p->number_of[i] >= p->free_count ? sn_v3(0, 0, 0) : volume_gradient[i];
    }
}

/* ---- a muscle alone */

/* A^-1 g has come: with it the row's scale. */
static void take_volume(sn_preconditioner *p, const double *solution) {
    const sn_vec3 *gradient = p->volume_gradient;
    double product = 0.0;
    find_coarse(p, 0, gradient);
    scatter(p, solution, p->volume_solved);
    add_coarse(p, 0, p->volume_solved);
    for (sn_index i = 0; i < p->members[0]->vertex_count; i++) product += sn_dot(gradient[i], p->volume_solved[i]);
    p->volume_scale = p->volume_stiffness[0] / (1.0 + p->volume_stiffness[0] * product);
    p->volume_stiffness[0] = 0.0;
}

/* The volume row's share of what it does, A^-1 in - scale A^-1 g (A^-1 g . in); in . A^-1 g came first, as out may be in. */
static double along_volume(const sn_preconditioner *p, const sn_vec3 *in) {
    double along = 0.0;
    for (sn_index i = 0; i < p->point_count; i++) along += sn_dot(p->volume_solved[i], in[i]); /* samples too: A^-1 g reaches them */
    return along;
}

static bool apply_alone(sn_preconditioner *p, sn_sparse *matrix, const sn_vec3 *in, sn_vec3 *out) {
    sn_index columns = p->turns != NULL ? 1 : 3;
    bool both = p->volume_stiffness[0] > 0.0; /* one pass over the factor for the two of them */
    gather(p, in, p->right);
    if (both) gather(p, p->volume_gradient, p->right + 3 * (size_t)p->free_count);
    if (sn_sparse_solve(matrix, both ? 2 * columns : columns, p->right, p->solution, NULL) != SN_OK) return false;
    if (both) take_volume(p, p->solution + 3 * (size_t)p->free_count);
    double along = p->volume_scale > 0.0 ? along_volume(p, in) : 0.0;
    find_coarse(p, 0, in);
    scatter(p, p->solution, out);
    add_coarse(p, 0, out);
    for (sn_index i = 0; i < p->point_count && p->volume_scale > 0.0; i++)
        out[i] = sn_add_scaled(out[i], p->volume_solved[i], -p->volume_scale * along);
    return true;
}

/* ---- a group */

static bool settle_volumes(sn_preconditioner *p, sn_deflation *deflation) {
    if (deflation == NULL || !p->volumes_set) return true;
    p->volumes_set = false;
    gather(p, p->volume_gradient, p->right);
    return sn_deflation_set(deflation, p->right, p->volume_stiffness);
}

/* What the sections of all members make of the right side, to the solution. */
static void correct_solution(sn_preconditioner *p) {
    sn_vec3 *room = p->volume_solved;
    scatter(p, p->right, room);
    for (sn_index k = 0; k < p->count; k++) find_coarse(p, k, room);
    scatter(p, p->solution, room);
    for (sn_index k = 0; k < p->count; k++) add_coarse(p, k, room);
    gather(p, room, p->solution);
}

static bool apply_group(sn_preconditioner *p, const rest_matrix *matrix, const sn_vec3 *in, sn_vec3 *out) {
    sn_deflation *d = matrix->deflation;
    if (!settle_volumes(p, d)) return false;
    bool deflates = d != NULL && sn_deflation_acts(d);
    gather(p, in, p->right);
    if (deflates && !sn_deflation_before(d, p->right)) return false;
    if (sn_sparse_solve(matrix->factor, p->turns != NULL ? 1 : 3, p->right, p->solution, NULL) != SN_OK) return false;
    if (p->corrects) correct_solution(p);
    if (deflates && !sn_deflation_after(d, p->solution)) return false;
    scatter(p, p->solution, out);
    return true;
}

int64_t sn_preconditioner_entries(const sn_preconditioner *p) {
    const rest_matrix *matrix = p->turns != NULL ? &p->corotated : &p->scalar;
    return matrix->factor != NULL ? sn_sparse_entries(matrix->factor) : 0;
}

static size_t matrix_bytes(const sn_preconditioner *p, const rest_matrix *matrix) {
    const sn_blocks *b = &matrix->blocks;
    if (b->blocks == NULL) return 0;
    size_t bytes = b->capacity * sizeof *b->blocks + (size_t)b->rows * sizeof *b->last + (size_t)b->entry_count * sizeof *b->entries;
    int64_t entries = matrix->factor != NULL ? sn_sparse_entries(matrix->factor) : 0;
    return bytes + (size_t)p->count * sizeof(double) + (size_t)entries * (sizeof(double) + sizeof(int)); /* each with its row */
}

static size_t coarse_bytes(const sn_two_level *t, sn_index points) {
    if (t->model == NULL) return 0;
    size_t each = sizeof *t->member + sizeof *t->weight + sizeof *t->at, size = (size_t)t->size;
    return (size_t)points * each + (size_t)t->count * (sizeof *t->total + sizeof *t->middle) + (size * size + 2 * size) * sizeof(double);
}

size_t sn_preconditioner_bytes(const sn_preconditioner *p) {
    const size_t points = (size_t)p->point_count, members = (size_t)p->count, numbers = (size_t)p->free_count;
    size_t bytes = sizeof *p + members * (sizeof *p->members + sizeof *p->volume_stiffness) + 2 * (members + 1) * sizeof *p->first +
                   points * (2 * sizeof *p->number_of + 2 * sizeof *p->volume_gradient) +
                   numbers * (sizeof *p->mass + 6 * (sizeof *p->right + sizeof *p->solution));
    bytes += p->coupling_capacity * sizeof *p->couplings + (p->positions != NULL ? points * sizeof *p->positions : 0);
    for (sn_index i = 0; p->coarse != NULL && i < p->count; i++)
        bytes += sizeof *p->coarse + coarse_bytes(&p->coarse[i], p->members[i]->point_count);
    return bytes + matrix_bytes(p, &p->scalar) + matrix_bytes(p, &p->corotated);
}

bool sn_preconditioner_apply(sn_preconditioner *p, const sn_vec3 *in, sn_vec3 *out) {
    if (p->free_count == 0) {
        memset(out, 0, (size_t)p->point_count * sizeof *out);
        return true;
    }
    const rest_matrix *matrix = p->turns != NULL ? &p->corotated : &p->scalar;
    if (matrix->factor == NULL) return false;
    return p->count == 1 ? apply_alone(p, matrix->factor, in, out) : apply_group(p, matrix, in, out);
}

/* The block times v, in the frames of its points. */
static sn_vec3 block_times(const sn_preconditioner *p, const sn_block *block, sn_vec3 v) {
    const double *b = block->value;
    if (p->turns == NULL) return sn_scale(v, *b);
    v = turned_back(p, p->point_of[block->column], v);
    v = sn_v3(b[0] * v.x + b[1] * v.y + b[2] * v.z, b[3] * v.x + b[4] * v.y + b[5] * v.z, b[6] * v.x + b[7] * v.y + b[8] * v.z);
    return sn_quat_rotate(p->turns[p->point_of[block->row]], v);
}

/* in += the columns of carried points times their jump. */
static void add_carried(const sn_preconditioner *p, const rest_matrix *matrix, const sn_vec3 *jump, sn_vec3 *in) {
    const sn_blocks *blocks = &matrix->blocks;
    for (sn_index i = p->free_count; i < blocks->count; i++) {
        const sn_block *block = &blocks->blocks[i];
        if (block->column < p->free_count) continue;
        sn_index to = p->point_of[block->row];
        double k = sn_blocks_stiffness(p->count, p->first_free, matrix->factor_stiffness, block->row);
        in[to] = sn_add_scaled(in[to], block_times(p, block, jump[p->point_of[block->column]]), k);
    }
    for (sn_index i = 0; i < p->coupling_count; i++) {
        const coupling *c = &p->couplings[i];
        if (c->column < p->free_count) continue;
        sn_index to = p->point_of[c->row];
        in[to] = sn_add_scaled(in[to], jump[p->point_of[c->column]], coupling_stiffness(c, matrix->factor_stiffness) * c->value);
    }
}

/* in += k_V g_f (g_k . jump) of one member. */
static void add_volume_jump(const sn_preconditioner *p, sn_index member, const sn_vec3 *jump, const sn_vec3 *gradient, double stiffness,
                            sn_vec3 *in) {
    sn_index begin = p->first[member], end = begin + p->members[member]->vertex_count;
    double along = 0.0;
    for (sn_index i = begin; i < end; i++)
        if (p->number_of[i] >= p->free_count) along += sn_dot(gradient[i], jump[i]);
    for (sn_index i = begin; i < end; i++)
        if (p->number_of[i] < p->free_count) in[i] = sn_add_scaled(in[i], gradient[i], stiffness * along);
}

void sn_preconditioner_add_jump(const sn_preconditioner *p, const sn_vec3 *jump, const sn_vec3 *volume_gradient,
                                const double *volume_stiffness, sn_vec3 *in) {
    const rest_matrix *matrix = p->turns != NULL ? &p->corotated : &p->scalar;
    add_carried(p, matrix, jump, in);
    for (sn_index k = 0; k < p->count; k++)
        if (volume_stiffness[k] > 0.0) add_volume_jump(p, k, jump, volume_gradient, volume_stiffness[k], in);
}
