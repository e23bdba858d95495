/*
 * fit_gap.c -- how near the surfaces of bones come to each other at a joint, over a motion.
 */
#include <stdlib.h>
#include <string.h>

#include "sinew/motion_fit.h"

enum { GRAIN = 4 }; /* frames a thread takes at once */

typedef struct gap_bone {
    sn_surface *surface; /* NULL until somebody asks */
    sn_box box;
    sn_vec3 centre; /* of a ball around the mesh */
    double radius;
} gap_bone;

typedef struct gap_pair {
    sn_index bones[2];
} gap_pair;

typedef struct gap_work {
    const sn_fit_body *body;
    const sn_clip *clip;
    double tolerance;
    gap_bone *bones; /* (bone_count) */
    size_t pair_count, pair_capacity;
    gap_pair *pairs; /* of the joint at hand: of the joint, of its parent */
    sn_index frame_count;
    sn_index *frames;  /* (frame_count) that are looked at; the first entry, -1, is the rest pose */
    double *least;     /* (frame_count) */
    gap_pair *nearest; /* (frame_count) */
    bool *torn;        /* (chunks of frames) there was no memory */
} gap_work;

/* ---- the least signed distance of two surfaces --------------------------------------------------------------------------------------- */

/* Part of a triangle; no point of it has a distance below `bound`. */
typedef struct gap_cell {
    double bound;
    sn_vec3 corners[3];
} gap_cell;

/* Of points of one mesh, carried by `pose`, from the surface of another. */
typedef struct gap_query {
    const sn_mesh *mesh;
    const sn_surface *surface;
    sn_box box; /* of the surface */
    sn_rigid pose;
    double tolerance, least;
    size_t count, capacity;
    gap_cell *cells; /* (count) a heap: the least bound first */
    bool torn;       /* no memory */
} gap_query;

static double box_distance(const sn_box *box, sn_vec3 p) {
    sn_vec3 beyond = sn_max3(sn_max3(sn_sub(box->low, p), sn_sub(p, box->high)), sn_v3(0, 0, 0));
    return sn_norm(beyond);
}

static void push_cell(gap_query *q, gap_cell cell) {
    void *cells = q->cells;
    if (!sn_grow(&cells, &q->capacity, q->count + 1, sizeof *q->cells)) {
        q->torn = true;
        return;
    }
    q->cells = cells;
    size_t i = q->count++;
    for (; i > 0 && q->cells[(i - 1) / 2].bound > cell.bound; i = (i - 1) / 2) q->cells[i] = q->cells[(i - 1) / 2];
    q->cells[i] = cell;
}

static gap_cell pop_cell(gap_query *q) {
    gap_cell top = q->cells[0], last = q->cells[--q->count];
    size_t i = 0;
    for (size_t child = 1; child < q->count; child = 2 * i + 1) {
        if (child + 1 < q->count && q->cells[child + 1].bound < q->cells[child].bound) child++;
        if (!(q->cells[child].bound < last.bound)) break;
        q->cells[i] = q->cells[child];
        i = child;
    }
    q->cells[i] = last;
    return top;
}

/* A signed distance changes by no more than the way: within a triangle none is less than at its middle, less the distance from there to the
 * farthest corner. */
static void look_at(gap_query *q, sn_vec3 a, sn_vec3 b, sn_vec3 c) {
    sn_vec3 middle = sn_scale(sn_add(sn_add(a, b), c), 1.0 / 3.0);
    double reach = fmax(fmax(sn_distance(middle, a), sn_distance(middle, b)), sn_distance(middle, c));
    if (box_distance(&q->box, middle) - reach >= fmax(q->least - q->tolerance, 0.0)) return;
    double distance = sn_surface_signed_distance(q->surface, middle, NULL);
    q->least = fmin(q->least, distance);
    if (distance - reach < q->least - q->tolerance) push_cell(q, (gap_cell){distance - reach, {a, b, c}});
}

/* What may hold less than the least is cut into four, the most promising first, until nothing can be less by more than the tolerance. */
static void search_mesh(gap_query *q) {
    for (sn_index t = 0; t < q->mesh->triangle_count; t++) {
        const sn_index *v = q->mesh->triangles[t].v;
        look_at(q, sn_rigid_apply(q->pose, q->mesh->positions[v[0]]), sn_rigid_apply(q->pose, q->mesh->positions[v[1]]),
                sn_rigid_apply(q->pose, q->mesh->positions[v[2]]));
    }
    while (q->count > 0 && !q->torn) {
        gap_cell cell = pop_cell(q);
        if (!(cell.bound < q->least - q->tolerance)) break;
        sn_vec3 a = cell.corners[0], b = cell.corners[1], c = cell.corners[2];
        sn_vec3 ab = sn_lerp(a, b, 0.5), bc = sn_lerp(b, c, 0.5), ca = sn_lerp(c, a, 0.5);
        look_at(q, ab, bc, ca);
        look_at(q, a, ab, ca);
        look_at(q, ab, b, bc);
        look_at(q, ca, bc, c);
    }
    q->count = 0;
}

static sn_rigid bone_pose(const gap_work *w, sn_index bone, sn_index frame) {
    return frame < 0 ? sn_rigid_identity() : w->clip->joints[w->body->bones[bone].joint].poses[frame];
}

/* Of a pair, where it is below `least`; else least. Both ways round where one lies in the other: each sees its own points alone. */
static double pair_distance(const gap_work *w, const gap_pair *pair, sn_index frame, double least, gap_query *q) {
    const gap_bone *bones[2] = {&w->bones[pair->bones[0]], &w->bones[pair->bones[1]]};
    sn_rigid poses[2] = {bone_pose(w, pair->bones[0], frame), bone_pose(w, pair->bones[1], frame)};
    sn_vec3 centres[2] = {sn_rigid_apply(poses[0], bones[0]->centre), sn_rigid_apply(poses[1], bones[1]->centre)};
    if (sn_distance(centres[0], centres[1]) - bones[0]->radius - bones[1]->radius >= least) return least;
    for (int k = 0; k < 2 && (k == 0 || least < 0.0); k++) {
        q->mesh = w->body->bones[pair->bones[k]].mesh;
        q->surface = bones[1 - k]->surface;
        q->box = bones[1 - k]->box;
        q->pose = sn_rigid_compose(sn_rigid_inverse(poses[1 - k]), poses[k]);
        q->least = least;
        search_mesh(q);
        least = q->least;
    }
    return least;
}

static void measure_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    gap_work *w = user;
    gap_query q = {.tolerance = w->tolerance};
    for (sn_index i = begin; i < end; i++) {
        w->least[i] = INFINITY;
        for (size_t p = 0; p < w->pair_count; p++) {
            double distance = pair_distance(w, &w->pairs[p], w->frames[i], w->least[i], &q);
            if (distance < w->least[i]) w->nearest[i] = w->pairs[p];
            w->least[i] = distance;
        }
    }
    w->torn[chunk] = q.torn;
    free(q.cells);
}

/* ---- pairs ------------------------------------------------------------------------------------------------------------------------------
 */

static bool has_meet(const sn_fit_table *table, sn_index joint) {
    for (sn_index m = 0; m < table->meet_count; m++)
        if (table->meets[m].joint == joint) return true;
    return false;
}

static bool is_met(const sn_fit_body *body, sn_index joint, const sn_fit_bone *a, const sn_fit_bone *b) {
    for (sn_index m = 0; m < body->table->meet_count; m++) {
        const sn_fit_meet *meet = &body->table->meets[m];
        if (meet->joint == joint && sn_pattern_matches(meet->patterns[0], a->name) && sn_pattern_matches(meet->patterns[1], b->name))
            return true;
    }
    return false;
}

/* The nearer by their balls come first, so that the others are passed over. */
static sn_status add_pair(gap_work *w, sn_index a, sn_index b, sn_error *error) {
    void *pairs = w->pairs;
    if (!sn_grow(&pairs, &w->pair_capacity, w->pair_count + 1, sizeof *w->pairs)) return sn_fail_memory(error, "pairs of bones");
    w->pairs = pairs;
    w->pairs[w->pair_count++] = (gap_pair){{a, b}};
    sn_status status = SN_OK;
    for (int k = 0; k < 2 && status == SN_OK; k++) {
        sn_index bone = k == 0 ? a : b;
        if (w->bones[bone].surface == NULL) status = sn_surface_create(w->body->bones[bone].mesh, &w->bones[bone].surface, error);
    }
    return status;
}

static sn_status find_pairs(gap_work *w, sn_index joint, sn_error *error) {
    const sn_fit_body *body = w->body;
    sn_index parent = body->table->joints[joint].parent;
    bool met = has_meet(body->table, joint);
    sn_status status = SN_OK;
    w->pair_count = 0;
    for (sn_index a = 0; a < body->bone_count; a++)
        for (sn_index b = 0; b < body->bone_count && status == SN_OK; b++) {
            const sn_fit_bone *one = &body->bones[a], *other = &body->bones[b];
            if (a == b || one->joint == SN_NONE || other->joint == SN_NONE) continue;
            if (met ? is_met(body, joint, one, other) : one->joint == joint && other->joint == parent) status = add_pair(w, a, b, error);
        }
    return status;
}

static double ball_distance(const gap_work *w, const gap_pair *pair) {
    const gap_bone *a = &w->bones[pair->bones[0]], *b = &w->bones[pair->bones[1]];
    return sn_distance(a->centre, b->centre) - a->radius - b->radius;
}

/* The pair that is nearest at rest first: it most often stays so, and lets the others be passed over. */
static void put_nearest_first(gap_work *w, gap_query *q) {
    double least = INFINITY;
    size_t nearest = 0;
    for (size_t p = 0; p < w->pair_count; p++) {
        if (!(ball_distance(w, &w->pairs[p]) < least)) continue;
        double distance = pair_distance(w, &w->pairs[p], -1, least, q);
        if (distance < least) nearest = p;
        least = distance;
    }
    gap_pair first = w->pairs[nearest];
    w->pairs[nearest] = w->pairs[0];
    w->pairs[0] = first;
}

/* ---- joints
 * ------------------------------------------------------------------------------------------------------------------------------ */

static sn_fit_gap reduce(const gap_work *w, sn_index joint) {
    sn_fit_gap gap = {.joint = joint,
                      .bones = {w->nearest[0].bones[0], w->nearest[0].bones[1]},
                      .rest = w->least[0],
                      .least = INFINITY,
                      .greatest = -INFINITY};
    for (sn_index i = 1; i < w->frame_count; i++) {
        if (w->least[i] < gap.least) {
            gap.least = w->least[i];
            gap.least_frame = w->frames[i];
        }
        if (w->least[i] > gap.greatest) {
            gap.greatest = w->least[i];
            gap.greatest_frame = w->frames[i];
        }
    }
    return gap;
}

/* false: there is no memory. */
static bool measure_frames(gap_work *w, sn_pool *pool) {
    gap_query q = {.tolerance = w->tolerance};
    put_nearest_first(w, &q);
    sn_parallel_for(pool, w->frame_count, GRAIN, measure_range, w);
    bool whole = !q.torn;
    for (sn_index i = 0; i < sn_chunk_count(w->frame_count, GRAIN); i++) whole = whole && !w->torn[i];
    free(q.cells);
    return whole;
}

static sn_status measure_joints(gap_work *w, const sn_fit_gap_params *params, sn_fit_gap *out, sn_index *count, sn_error *error) {
    const sn_fit_table *table = w->body->table;
    for (sn_index j = 0; j < table->joint_count; j++) {
        sn_status status = find_pairs(w, j, error);
        if (status != SN_OK) return status;
        if (w->pair_count == 0) continue;
        if (!measure_frames(w, params->pool)) return sn_fail_memory(error, "the distances");
        out[(*count)++] = reduce(w, j);
        if (SN_TRACE(params->trace, "gap", sn_trace_text("joint", table->points[j].name), sn_trace_number("rest", out[*count - 1].rest),
                     sn_trace_number("least", out[*count - 1].least), sn_trace_number("greatest", out[*count - 1].greatest)))
            return SN_STOPPED;
    }
    return SN_OK;
}

static void find_balls(gap_work *w) {
    for (sn_index b = 0; b < w->body->bone_count; b++) {
        const sn_mesh *mesh = w->body->bones[b].mesh;
        w->bones[b].box = sn_mesh_box(mesh);
        w->bones[b].centre = sn_lerp(w->bones[b].box.low, w->bones[b].box.high, 0.5);
        for (sn_index v = 0; v < mesh->vertex_count; v++)
            w->bones[b].radius = fmax(w->bones[b].radius, sn_distance(mesh->positions[v], w->bones[b].centre));
    }
}

static void choose_frames(gap_work *w, sn_index every) {
    w->frames[w->frame_count++] = -1;
    for (sn_index f = 0; f < w->clip->frame_count; f += every) w->frames[w->frame_count++] = f;
    if (w->frames[w->frame_count - 1] != w->clip->frame_count - 1) w->frames[w->frame_count++] = w->clip->frame_count - 1;
}

sn_status sn_fit_gaps(const sn_fit_body *body, const sn_clip *fitted, const sn_fit_gap_params *params, sn_fit_gap **out, sn_index *count,
                      sn_error *error) {
    size_t frames = (size_t)fitted->frame_count + 2;
    gap_work w = {.body = body,
                  .clip = fitted,
                  .tolerance = params->tolerance,
                  .bones = SN_NEW(gap_bone, body->bone_count),
                  .frames = SN_NEW(sn_index, frames),
                  .least = SN_NEW(double, frames),
                  .nearest = SN_NEW(gap_pair, frames),
                  .torn = SN_NEW(bool, frames)};
    *out = SN_NEW(sn_fit_gap, body->table->joint_count);
    *count = 0;
    bool room = w.bones != NULL && w.frames != NULL && w.least != NULL && w.nearest != NULL && w.torn != NULL && *out != NULL;
    sn_status status = room ? SN_OK : sn_fail_memory(error, "the distances");
    if (status == SN_OK) {
        find_balls(&w);
        choose_frames(&w, params->every);
        status = measure_joints(&w, params, *out, count, error);
    }
    for (sn_index b = 0; b < body->bone_count && w.bones != NULL; b++) sn_surface_destroy(w.bones[b].surface);
    free(w.bones);
    free(w.pairs);
    free(w.frames);
    free(w.least);
    free(w.nearest);
    free(w.torn);
    return status;
}
