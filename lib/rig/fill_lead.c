/*
 * fill_lead.c -- smooth fibres from area to area: each follows its way through the slices as far as these are sections of the muscle.
 *
 * Near an area the slices are lids over it: a fibre that followed them would run across the area before it leaves. There it is led by its
 * end and its bending alone; towards the middle the slices have their say. The fibre is the least sum of squared second differences and of
 * squared distances from the way, weighted by how far both areas are (a smoothing spline; Reinsch 1967). Where that leaves the volume the
 * fibre is drawn in from the surface beside it, as deep as its way runs there in the muscle's thickness.
 */
#include <stdlib.h>

#include "fill.h"
#include "tree.h"

enum { NODES = 49, BATCH = 512, ROUNDS = 4, FIBERS_A_CHUNK = 8, TURN = 16 };
#define BENDING 81.0    /* of a second difference against a distance: waves shorter than about 2 pi x 3 nodes go */
#define LID 1.5         /* radii of the slice beside the area within which slices are lids over it; at twice that they are none */
#define OWN_LID 1.0     /* the same in radii of the slice at hand: it grows across the muscle before it moves along it */
#define LEAST_SAY 1e-6  /* of a way: beside an area */
#define FIRST_SAY 0.125 /* of a goal where the fibre first leaves the volume; then eight times as much each round */
#define DETOUR 1.15     /* a fibre may be so many times as long as one that its way has no say in */
#define LEAST_DEPTH 0.1 /* of the thickness: of such a goal, from both sides */

/* Fibres by number, and those of them that are at work by place in a list. */
typedef struct batch {
    const fill_leading *lead;
    sn_surface *surface; /* made when a fibre first leaves the volume */
    sn_index first, count;
    sn_vec3 *ways;                /* (BATCH x NODES) */
    double *shares, *z;           /* (BATCH x NODES) share: of a way's say at its nodes, by how far the areas are */
    sn_vec3 *fibers;              /* (BATCH x NODES) results */
    double *least;                /* (BATCH) length of a fibre that its way has no say in */
    double scale;                 /* of the ways' says */
    double radii[TEMPLATE_NODES]; /* by level, of a disc as large as its slices are on average */
    sn_index listed, *list;       /* (BATCH) */
    sn_vec3 *goals, *nodes;       /* (BATCH x NODES) from here on by place in the list */
    double *says;                 /* (BATCH x NODES) */
    int *winding;                 /* (BATCH x NODES) */
} batch;

/* ---- the way ------------------------------------------------------------------------------------------------------------------- */

static double smoothstep(double t) {
    t = fmin(fmax(t, 0.0), 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/* End, a point a level, end. From the origin's way to the insertion's by degrees, by the heads of the one before the trunk and of the
 * other after it. */
static sn_index trace_way(const fill_levels *l, const fill_path *path, sn_vec3 *points, double *z) {
    sn_index count = 0;
    points[count] = path->end[0];
    z[count++] = 0.0;
    for (sn_index i = 0; i < l->level_count; i++) {
        double t = smoothstep(l->z[i]);
        fill_uv a = path->way[0], b = path->way[1], at = {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)};
        if (fill_place(l, SN_FILL_HARMONIC, i, i <= l->trunk ? a : b, at, &points[count])) z[count++] = l->z[i];
    }
    points[count] = path->end[1];
    z[count++] = 1.0;
    return count;
}

static void find_radii(batch *b) {
    const fill_levels *l = b->lead->levels;
    for (sn_index i = 0; i < l->level_count; i++) {
        double area = 0.0, loops = 0.0;
        for (sn_index k = l->first[i]; k < l->first[i + 1]; k++) {
            if (!l->loops[k].reached) continue;
            area += l->loops[k].area;
            loops += 1.0;
        }
        b->radii[i] = loops > 0.0 ? sqrt(area / loops / SN_PI) : 0.0;
    }
}

static double radius_at(const batch *b, double z) {
    const fill_levels *l = b->lead->levels;
    sn_index i = 0;
    while (i + 1 < l->level_count && l->z[i + 1] <= z) i++;
    return b->radii[i];
}

static void trace_fiber(batch *b, sn_index i) {
    const fill_path *path = &b->lead->paths[b->first + i];
    sn_vec3 points[TEMPLATE_NODES + 2], *way = b->ways + (size_t)i * NODES;
    double z[TEMPLATE_NODES + 2];
    sn_index count = trace_way(b->lead->levels, path, points, z);
    (void)fill_divide(&(fill_line){count, points, z}, NODES - 1, way, b->z + (size_t)i * NODES);
    for (int k = 0; k < NODES; k++) {
        double *share = b->shares + (size_t)i * NODES + k;
        *share = 1.0;
        for (int side = 0; side < 2; side++) {
            double lid = fmax(LID * path->radius[side], OWN_LID * radius_at(b, b->z[(size_t)i * NODES + (size_t)k]));
            if (lid > 0.0) *share *= smoothstep(sn_distance(way[k], path->end[side]) / lid - 1.0);
        }
    }
}

/* ---- the least sum ---------------------------------------------------------------------------------------------------------------- */

/* Symmetric with two bands: L D L^T in place. */
typedef struct banded {
    double diagonal[NODES], one[NODES], two[NODES]; /* one, two: to the unknown before and the one before that */
    sn_vec3 right[NODES];
} banded;

static void add_node(banded *m, const sn_vec3 *x, int row, int column, double value) {
    if (row < 1 || row > NODES - 2) return;
    if (column < 1 || column > NODES - 2)
        m->right[row] = sn_add_scaled(m->right[row], x[column], -value);
    else if (column == row)
        m->diagonal[row] += value;
    else if (column == row - 1)
        m->one[row] += value;
    else if (column == row - 2)
        m->two[row] += value;
}

static void assemble(const sn_vec3 *goal, const double *say, banded *m) {
    static const double difference[3] = {1.0, -2.0, 1.0};
    for (int k = 0; k < NODES; k++) {
        m->diagonal[k] = say[k];
        m->one[k] = m->two[k] = 0.0;
        m->right[k] = sn_scale(goal[k], say[k]);
    }
    for (int k = 1; k < NODES - 1; k++)
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) add_node(m, goal, k - 1 + i, k - 1 + j, BENDING * difference[i] * difference[j]);
}

static void solve(banded *m, sn_vec3 *x) {
    for (int k = 1; k < NODES - 1; k++) {
        double two = k > 2 ? m->two[k] / m->diagonal[k - 2] : 0.0;
        double between = k > 2 ? m->two[k] * m->one[k - 1] : 0.0; /* one[k - 1] is already over the diagonal */
        double one = k > 1 ? (m->one[k] - between) / m->diagonal[k - 1] : 0.0;
        if (k > 1) m->diagonal[k] -= one * one * m->diagonal[k - 1];
        if (k > 2) m->diagonal[k] -= two * two * m->diagonal[k - 2];
        m->one[k] = one;
        m->two[k] = two;
        if (k > 1) m->right[k] = sn_add_scaled(m->right[k], m->right[k - 1], -one);
        if (k > 2) m->right[k] = sn_add_scaled(m->right[k], m->right[k - 2], -two);
    }
    for (int k = NODES - 2; k >= 1; k--) {
        x[k] = sn_scale(m->right[k], 1.0 / m->diagonal[k]);
        if (k < NODES - 2) x[k] = sn_add_scaled(x[k], x[k + 1], -m->one[k + 1]);
        if (k < NODES - 3) x[k] = sn_add_scaled(x[k], x[k + 2], -m->two[k + 2]);
    }
}

static void settle_fiber(batch *b, sn_index place) {
    const sn_vec3 *goal = b->goals + (size_t)place * NODES;
    sn_vec3 *x = b->nodes + (size_t)place * NODES;
    banded m;
    assemble(goal, b->says + (size_t)place * NODES, &m);
    solve(&m, x);
    x[0] = goal[0];
    x[NODES - 1] = goal[NODES - 1];
}

static void begin_fiber(batch *b, sn_index place) {
    size_t from = (size_t)b->list[place] * NODES, to = (size_t)place * NODES;
    for (size_t k = 0; k < NODES; k++) {
        b->goals[to + k] = b->ways[from + k];
        b->says[to + k] = fmax(b->scale * b->shares[from + k], LEAST_SAY);
    }
    settle_fiber(b, place);
}

/* ---- inside ------------------------------------------------------------------------------------------------------------------------- */

/* From the closest point of the surface inwards, as deep as the way runs there; the way itself where nothing lies beyond. */
static sn_vec3 drawn_in(const batch *b, sn_vec3 at, sn_vec3 way) {
    const sn_mesh *mesh = b->lead->mesh;
    sn_closest closest = sn_surface_closest(b->surface, at, INFINITY);
    if (closest.triangle == SN_NONE) return way;
    const sn_index *v = mesh->triangles[closest.triangle].v;
    sn_vec3 normal = sn_normalize(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]));
    sn_vec3 inwards = sn_scale(normal, -1.0);
    double near = 1e-6 * b->lead->diagonal;
    sn_ray_hit hit = sn_surface_ray(b->surface, closest.point, inwards, near, b->lead->diagonal);
    if (hit.triangle == SN_NONE || !(sn_norm2(normal) > 0.0)) return way;
    double depth = sn_dot(sn_sub(way, closest.point), inwards) / hit.distance;
    return sn_add_scaled(closest.point, inwards, hit.distance * fmin(fmax(depth, LEAST_DEPTH), 1.0 - LEAST_DEPTH));
}

/* Goals inside, of more and more weight, for nodes that are outside. */
static void draw_in(batch *b, sn_index place) {
    size_t way = (size_t)b->list[place] * NODES, first = (size_t)place * NODES;
    bool moved = false;
    for (size_t k = 1; k < NODES - 1; k++) {
        if (b->winding[first + k] != 0) continue;
        moved = true;
        b->goals[first + k] = drawn_in(b, b->nodes[first + k], b->ways[way + k]);
        b->says[first + k] = fmax(8.0 * b->says[first + k], FIRST_SAY);
    }
    if (moved) settle_fiber(b, place);
}

static void trace_fibers(void *user, sn_index begin, sn_index end, sn_index chunk) {
    (void)chunk;
    for (sn_index i = begin; i < end; i++) trace_fiber(user, i);
}

static void begin_fibers(void *user, sn_index begin, sn_index end, sn_index chunk) {
    (void)chunk;
    for (sn_index i = begin; i < end; i++) begin_fiber(user, i);
}

static void mend_fibers(void *user, sn_index begin, sn_index end, sn_index chunk) {
    (void)chunk;
    for (sn_index i = begin; i < end; i++) draw_in(user, i);
}

static sn_status settle_listed(batch *b, double scale, sn_error *error) {
    const fill_leading *lead = b->lead;
    sn_status status = SN_OK;
    b->scale = scale;
    sn_parallel_for(lead->pool, b->listed, FIBERS_A_CHUNK, begin_fibers, b);
    for (int round = 0; lead->closed && round < ROUNDS && !status; round++) {
        status = count_windings(lead->mesh, b->listed * NODES, b->nodes, b->winding, error);
        if (!status && !b->surface) status = sn_surface_create_plain(lead->mesh, &b->surface, error);
        if (!status) sn_parallel_for(lead->pool, b->listed, FIBERS_A_CHUNK, mend_fibers, b);
    }
    return status;
}

/* ---- no detours --------------------------------------------------------------------------------------------------------------------- */

static double length_of(const sn_vec3 *x) {
    double sum = 0.0;
    for (int k = 1; k < NODES; k++) sum += sn_distance(x[k - 1], x[k]);
    return sum;
}

static void take_fiber(batch *b, sn_index place) {
    for (size_t k = 0; k < NODES; k++) b->fibers[(size_t)b->list[place] * NODES + k] = b->nodes[(size_t)place * NODES + k];
}

/* The node that lies `way` along the fibre from node k, in steps of 1 or -1, or its last one. */
static int node_along(const sn_vec3 *x, int k, int step, double way) {
    for (double gone = 0.0; k + step >= 0 && k + step < NODES && gone < way; k += step) gone += sn_distance(x[k], x[k + step]);
    return k;
}

/* Somewhere a sixteenth of the fibre turns by more than a right angle from the sixteenth before: it runs past its end and returns. */
static bool turns_back(const sn_vec3 *x) {
    double way = length_of(x) / TURN;
    for (int k = 1; k + 1 < NODES; k++) {
        sn_vec3 before = sn_sub(x[k], x[node_along(x, k, -1, way)]), after = sn_sub(x[node_along(x, k, 1, way)], x[k]);
        if (sn_dot(before, after) < 0.0) return true;
    }
    return false;
}

static bool goes_astray(const sn_vec3 *x, double least) { return length_of(x) > DETOUR * least || turns_back(x); }

/* Fibres that are much longer than they would be without their ways, or turn back: these have less say, down to none. */
static sn_status shorten(batch *b, sn_error *error) {
    static const double scales[] = {0.1, 0.01, 0.001};
    sn_index all = b->listed;
    b->listed = 0;
    for (sn_index i = 0; i < all; i++) {
        const sn_vec3 *x = b->fibers + (size_t)i * NODES;
        if (goes_astray(x, sn_distance(x[0], x[NODES - 1]))) b->list[b->listed++] = i;
    }
    if (b->listed == 0) return SN_OK;
    sn_status status = settle_listed(b, 0.0, error);
    sn_index kept = 0;
    for (sn_index k = 0; k < b->listed && !status; k++) {
        sn_index i = b->list[k];
        b->least[i] = length_of(b->nodes + (size_t)k * NODES);
        if (!goes_astray(b->fibers + (size_t)i * NODES, b->least[i])) continue;
        take_fiber(b, k);
        b->list[kept++] = i;
    }
    b->listed = kept;
    for (size_t s = 0; s < sizeof scales / sizeof *scales && b->listed > 0 && !status; s++) {
        status = settle_listed(b, scales[s], error);
        kept = 0;
        for (sn_index k = 0; k < b->listed && !status; k++) {
            if (goes_astray(b->nodes + (size_t)k * NODES, b->least[b->list[k]]))
                b->list[kept++] = b->list[k];
            else
                take_fiber(b, k);
        }
        b->listed = kept;
    }
    return status;
}

/* ---- the whole ------------------------------------------------------------------------------------------------------------------------
 */

static void end_fibers(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const batch *b = user;
    const fill_leading *lead = b->lead;
    (void)chunk;
    for (sn_index i = begin; i < end; i++) {
        sn_vec3 *x = b->fibers + (size_t)i * NODES;
        size_t at = (size_t)(b->first + i) * (size_t)(lead->segments + 1);
        fill_smooth(NODES, x, lead->smooth);
        (void)fill_divide(&(fill_line){NODES, x, b->z + (size_t)i * NODES}, lead->segments, lead->lines[b->first + i].points, lead->z + at);
    }
}

static sn_status lead_batch(batch *b, sn_error *error) {
    sn_pool *pool = b->lead->pool;
    sn_parallel_for(pool, b->count, FIBERS_A_CHUNK, trace_fibers, b);
    b->listed = b->count;
    for (sn_index i = 0; i < b->count; i++) b->list[i] = i;
    sn_status status = settle_listed(b, 1.0, error);
    for (sn_index i = 0; i < b->count && !status; i++) take_fiber(b, i);
    if (!status) status = shorten(b, error);
    if (!status) sn_parallel_for(pool, b->count, FIBERS_A_CHUNK, end_fibers, b);
    return status;
}

static bool batch_alloc(batch *b) {
    b->ways = SN_NEW(sn_vec3, BATCH * NODES);
    b->fibers = SN_NEW(sn_vec3, BATCH * NODES);
    b->goals = SN_NEW(sn_vec3, BATCH * NODES);
    b->nodes = SN_NEW(sn_vec3, BATCH * NODES);
    b->shares = SN_NEW(double, BATCH *NODES);
    b->says = SN_NEW(double, BATCH *NODES);
    b->z = SN_NEW(double, BATCH *NODES);
    b->winding = SN_NEW(int, BATCH *NODES);
    b->least = SN_NEW(double, BATCH);
    b->list = SN_NEW(sn_index, BATCH);
    return b->ways && b->fibers && b->goals && b->nodes && b->shares && b->says && b->z && b->winding && b->least && b->list;
}

static void batch_free(batch *b) {
    free(b->ways);
    free(b->fibers);
    free(b->goals);
    free(b->nodes);
    free(b->shares);
    free(b->says);
    free(b->z);
    free(b->winding);
    free(b->least);
    free(b->list);
    sn_surface_destroy(b->surface);
}

sn_status fill_lead_paths(const fill_leading *lead, sn_error *error) {
    batch b = {.lead = lead};
    sn_status status = batch_alloc(&b) ? SN_OK : sn_fail_memory(error, "the fibres");
    find_radii(&b);
    for (; b.first < lead->fibers && !status; b.first += BATCH) {
        b.count = lead->fibers - b.first < BATCH ? lead->fibers - b.first : BATCH;
        status = lead_batch(&b, error);
    }
    batch_free(&b);
    return status;
}
