/*
 * attach_area.c -- the patch of a muscle that landmarks go around ([K21] 3.3).
 *
 * The landmarks are projected on the muscle and joined, in their order, by geodesic paths. The paths run between the vertices, never
 * through one, so the closed boundary parts the vertices in two: walking from vertex to vertex, every crossing changes the side. The
 * patch is the smaller side. Where the boundary crosses itself the landmarks are put into the order of the shortest tour first.
 * Landmarks in a row are joined from the first to the last; their patch is a band (attach_line.c).
 */
#include "attach.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_LANDMARKS = 1024, MOST_BY_PATHS = 48 };

/* One area under way. */
typedef struct outline {
    const sn_area_ground *ground;
    const sn_landmark_area *area;
    sn_trace *trace;
    bool *inside;          /* the caller's */
    sn_closest *landmark;  /* (area->count) on the muscle, a little inside a triangle */
    sn_index projected;    /* landmarks done */
    sn_index *order;       /* (area->count) of the landmarks along the boundary */
    sn_surface_path *path; /* (area->count) from landmark order[i] to the one after it */
    sn_index walked;       /* paths done */
    bool line;             /* no path from the last landmark to the first */
    char name[160];        /* for messages */
} outline;

static const sn_mesh *mesh_of(const outline *o) { return &o->ground->muscle->mesh; }

/* ---- projection ------------------------------------------------------------------------------------------------------- */

static void give_name(outline *o) {
    if (o->area->name != NULL)
        snprintf(o->name, sizeof o->name, "area \"%.60s\" on bone \"%.60s\"", o->area->name, o->area->bone);
    else
        snprintf(o->name, sizeof o->name, "the area on bone \"%.60s\"", o->area->bone);
}

/* The corner of the triangle that a point in it is nearest to. */
static sn_index corner_near(const sn_mesh *mesh, sn_index triangle, sn_vec3 point) {
    const sn_index *v = mesh->triangles[triangle].v;
    int best = 0;
    for (int k = 1; k < 3; k++)
        if (sn_distance(point, mesh->positions[v[k]]) < sn_distance(point, mesh->positions[v[best]])) best = k;
    return v[best];
}

/* Off the sides and corners: a path that starts on one would run along it. */
static void move_inside(const sn_mesh *mesh, sn_closest *c) {
    const sn_index *v = mesh->triangles[c->triangle].v;
    c->point = sn_v3(0, 0, 0);
    for (int k = 0; k < 3; k++) {
        c->barycentric[k] = 0.97 * c->barycentric[k] + 0.01;
        c->point = sn_add_scaled(c->point, mesh->positions[v[k]], c->barycentric[k]);
    }
}

/* The landmarks' feet on the muscle; says which is farthest, and whether that is too far. */
static sn_status find_feet(outline *o, sn_attach_area *report, sn_error *error) {
    for (sn_index i = 0; i < o->area->count; i++) {
        if (!sn_finite3(o->area->landmarks[i])) return sn_fail(error, SN_ERROR_INPUT, "%s: landmark %d is not finite", o->name, (int)i + 1);
        o->landmark[i] = sn_surface_closest(o->ground->surface, o->area->landmarks[i], INFINITY);
        if (o->landmark[i].triangle == SN_NONE) return sn_fail(error, SN_ERROR_INPUT, "%s: the muscle has no surface", o->name);
        if (i > 0 && !(o->landmark[i].distance > report->farthest)) continue;
        report->farthest = o->landmark[i].distance;
        report->far = i;
    }
    report->left_out = report->farthest > o->ground->reach;
    return SN_OK;
}

static sn_status project(outline *o) {
    for (sn_index i = 0; i < o->area->count; i++) {
        sn_closest *c = &o->landmark[i];
        double distance = c->distance;
        move_inside(mesh_of(o), c);
        o->order[i] = i;
        o->projected = i + 1;
        sn_index vertex = corner_near(mesh_of(o), c->triangle, c->point);
        if (SN_TRACE(o->trace, "landmark", sn_trace_text("bone", o->area->bone), sn_trace_text("area", o->area->name),
                     sn_trace_number("landmark", i + 1), sn_trace_number("distance", distance), sn_trace_number("triangle", c->triangle),
                     sn_trace_indices("vertices", &vertex, 1)))
            return SN_STOPPED;
    }
    return SN_OK;
}

/* ---- boundary or line? ------------------------------------------------------------------------------------------------ */

static double mean_distance(const outline *o) {
    double sum = 0.0;
    for (sn_index i = 0; i < o->area->count; i++) sum += o->landmark[i].distance;
    return sum / o->area->count;
}

static void choose_kind(outline *o, sn_attach_area *report) {
    sn_landmark_walk walk;
    bool in_line = sn_landmarks_in_line(o->area, &walk), automatic = o->ground->kind == SN_AREA_AUTO;
    o->line = report->line = automatic ? in_line : o->ground->kind == SN_AREA_LINE;
    bool bends = walk.closing<0.8 * walk.length, gapes = o->area->count> 3 && walk.closing > 2.0 * walk.longest;
    report->doubtful = automatic && (in_line ? bends && gapes : gapes);
    if (o->line) report->width = o->ground->line_width >= 0.0 ? o->ground->line_width : mean_distance(o);
}

/* ---- the boundary ----------------------------------------------------------------------------------------------------- */

static void forget_paths(outline *o) {
    for (sn_index i = 0; i < o->walked; i++) sn_surface_path_free(&o->path[i]);
    o->walked = 0;
}

/* The vertices that a path passes, in list (path->count): the nearer end of every edge that it crosses. */
static sn_index passed_vertices(const outline *o, const sn_surface_path *path, sn_index *list) {
    sn_index count = 0;
    for (sn_index i = 0; i < path->count; i++) {
        sn_index v = corner_near(mesh_of(o), path->segments[i].triangle, path->segments[i].to);
        if (count == 0 || list[count - 1] != v) list[count++] = v;
    }
    return count;
}

static sn_status trace_path(const outline *o, sn_index i, sn_error *error) {
    const sn_surface_path *path = &o->path[i];
    sn_index *list = SN_NEW(sn_index, path->count);
    if (list == NULL) return sn_fail_memory(error, "a path over a surface");
    sn_index count = sn_trace_wanted(o->trace) ? passed_vertices(o, path, list) : 0;
    bool stop = SN_TRACE(o->trace, "geodesic", sn_trace_text("bone", o->area->bone), sn_trace_text("area", o->area->name),
                         sn_trace_number("from", o->order[i] + 1), sn_trace_number("to", o->order[(i + 1) % o->area->count] + 1),
                         sn_trace_number("length", path->length), sn_trace_indices("vertices", list, count));
    free(list);
    return stop ? SN_STOPPED : SN_OK;
}

static sn_status walk(outline *o, sn_error *error) {
    forget_paths(o);
    sn_index count = o->area->count;
    for (sn_index i = 0; i < (o->line ? count - 1 : count); i++) {
        sn_index a = o->order[i], b = o->order[(i + 1) % count];
        sn_error reason = {0};
        sn_status status = sn_path_find(o->ground->finder, &o->landmark[a], &o->landmark[b], i, &o->path[i], &reason);
        if (status == SN_ERROR_INPUT)
            return sn_fail(error, status, "%s: its %s: landmarks %d and %d lie on parts of the muscle that are not connected", o->name,
                           o->line ? "line breaks" : "boundary does not close", (int)a + 1, (int)b + 1);
        if (status != SN_OK) return sn_fail(error, status, "%s", reason.text);
        o->walked = i + 1;
        if ((status = trace_path(o, i, error)) != SN_OK) return status;
    }
    return SN_OK;
}

/* ---- does it cross itself? -------------------------------------------------------------------------------------------- */

typedef struct piece {
    sn_index triangle, path;
    sn_vec3 from, to;
} piece;

static int by_triangle(const void *a, const void *b) {
    const piece *p = a, *q = b;
    if (p->triangle != q->triangle) return p->triangle < q->triangle ? -1 : 1;
    return (p->path > q->path) - (p->path < q->path);
}

/* Twice the area of (a,b,c), signed as seen along n. */
static double turn(sn_vec3 a, sn_vec3 b, sn_vec3 c, sn_vec3 n) { return sn_dot(sn_area_vector(a, b, c), n); }

static bool pieces_cross(const sn_mesh *mesh, const piece *p, const piece *q) {
    const sn_index *v = mesh->triangles[p->triangle].v;
    sn_vec3 n = sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]);
    return turn(p->from, p->to, q->from, n) * turn(p->from, p->to, q->to, n) < 0.0 &&
           turn(q->from, q->to, p->from, n) * turn(q->from, q->to, p->to, n) < 0.0;
}

/* Paths that share a landmark do not count: from it they go apart. */
static bool are_neighbours(const outline *o, sn_index a, sn_index b) {
    sn_index count = o->area->count;
    return a == b || (a + 1) % count == b || (b + 1) % count == a;
}

/* The landmarks that the first two crossing paths start from, in paths[2]. */
static sn_status find_crossing(const outline *o, bool *crosses, sn_index paths[2], sn_error *error) {
    sn_index total = 0, filled = 0;
    *crosses = false;
    for (sn_index i = 0; i < o->walked; i++) total += o->path[i].count;
    piece *pieces = SN_NEW(piece, total);
    if (pieces == NULL) return sn_fail_memory(error, "the boundary of an area");
    for (sn_index i = 0; i < o->walked; i++)
        for (sn_index k = 0; k < o->path[i].count; k++) {
            const sn_path_segment *s = &o->path[i].segments[k];
            pieces[filled++] = (piece){s->triangle, i, s->from, s->to};
        }
    qsort(pieces, (size_t)total, sizeof *pieces, by_triangle);
    for (sn_index a = 0; a < total && !*crosses; a++)
        for (sn_index b = a + 1; b < total && pieces[b].triangle == pieces[a].triangle && !*crosses; b++) {
            if (are_neighbours(o, pieces[a].path, pieces[b].path) || !pieces_cross(mesh_of(o), &pieces[a], &pieces[b])) continue;
            *crosses = true;
            paths[0] = pieces[a].path;
            paths[1] = pieces[b].path;
        }
    free(pieces);
    return SN_OK;
}

/* ---- the shortest tour ------------------------------------------------------------------------------------------------ */

/* Distances between all landmarks, (count x count), filled in by one of two ways. */
typedef struct between {
    sn_index count;
    double *length;
} between;

static double *pair_length(const between *b, sn_index i, sn_index j) { return &b->length[(size_t)i * (size_t)b->count + (size_t)j]; }

/* The lengths of the paths themselves: in a tour that is short in these no two paths cross. */
static sn_status measure_by_paths(const outline *o, between *b, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; i < b->count; i++)
        for (sn_index j = i + 1; j < b->count && status == SN_OK; j++) {
            sn_surface_path path;
            status = sn_path_find(o->ground->finder, &o->landmark[i], &o->landmark[j], 0, &path, error);
            *pair_length(b, i, j) = *pair_length(b, j, i) = path.length;
            sn_surface_path_free(&path);
        }
    return status;
}

/* For many landmarks: along edges between their nearest vertices, and no shorter than straight. */
static sn_status measure_by_edges(const outline *o, between *b, sn_error *error) {
    const sn_mesh *mesh = mesh_of(o);
    double *distance = SN_NEW(double, mesh->vertex_count);
    if (distance == NULL) return sn_fail_memory(error, "the order of landmarks");
    sn_status status = SN_OK;
    for (sn_index i = 0; i < b->count && status == SN_OK; i++) {
        sn_index start = corner_near(mesh, o->landmark[i].triangle, o->landmark[i].point);
        status = sn_edge_distance(mesh, o->ground->topology, 1, &start, distance, error);
        for (sn_index j = 0; j < b->count && status == SN_OK; j++) {
            sn_index end = corner_near(mesh, o->landmark[j].triangle, o->landmark[j].point);
            *pair_length(b, i, j) = fmax(distance[end], sn_distance(o->landmark[i].point, o->landmark[j].point));
        }
    }
    free(distance);
    return status;
}

typedef struct tour {
    sn_index count, *order;
    const between *between;
} tour;

static double apart(const tour *t, sn_index i, sn_index j) {
    return *pair_length(t->between, t->order[i % t->count], t->order[j % t->count]);
}

/* From the first landmark always to the nearest that is left. */
static void start_tour(tour *t) {
    for (sn_index i = 0; i < t->count; i++) t->order[i] = i;
    for (sn_index i = 0; i + 1 < t->count; i++) {
        sn_index nearest = i + 1;
        for (sn_index j = i + 2; j < t->count; j++)
            if (apart(t, i, j) < apart(t, i, nearest)) nearest = j;
        sn_index next = t->order[nearest];
        t->order[nearest] = t->order[i + 1];
        t->order[i + 1] = next;
    }
}

/* Turn a stretch round where that makes the tour shorter (2-opt): in the plane this ends without crossings. */
static bool improve_tour(tour *t, double slack) {
    for (sn_index i = 0; i + 2 < t->count; i++)
        for (sn_index j = i + 2; j < t->count; j++) {
            if (i == 0 && j == t->count - 1) continue; /* the same edge of the tour */
            double before = apart(t, i, i + 1) + apart(t, j, j + 1), after = apart(t, i, j) + apart(t, i + 1, j + 1);
            if (!(after < before - slack)) continue;
            for (sn_index a = i + 1, b = j; a < b; a++, b--) {
                sn_index swap = t->order[a];
                t->order[a] = t->order[b];
                t->order[b] = swap;
            }
            return true;
        }
    return false;
}

static sn_status reorder(outline *o, sn_error *error) {
    sn_index count = o->area->count;
    between all = {count, SN_NEW(double, (size_t)count *(size_t)count)};
    if (all.length == NULL) return sn_fail_memory(error, "the order of landmarks");
    sn_status status = count <= MOST_BY_PATHS ? measure_by_paths(o, &all, error) : measure_by_edges(o, &all, error);
    if (status == SN_OK) {
        tour t = {count, o->order, &all};
        double slack = 1e-9 * sn_box_diagonal(sn_mesh_box(mesh_of(o)));
        start_tour(&t);
        while (improve_tour(&t, slack)) {}
        if (SN_TRACE(o->trace, "tour", sn_trace_text("bone", o->area->bone), sn_trace_text("area", o->area->name),
                     sn_trace_indices("order", o->order, count)))
            status = SN_STOPPED;
    }
    free(all.length);
    return status;
}

static sn_status close_boundary(outline *o, bool *reordered, sn_error *error) {
    sn_index crossing[2];
    bool crosses = false;
    *reordered = o->line && sn_line_order(o->area, o->order);
    sn_status status = walk(o, error);
    if (o->line) return status;
    if (status == SN_OK) status = find_crossing(o, &crosses, crossing, error);
    if (status != SN_OK || !crosses) return status;
    *reordered = true;
    status = reorder(o, error);
    if (status == SN_OK) status = walk(o, error);
    if (status == SN_OK) status = find_crossing(o, &crosses, crossing, error);
    if (status != SN_OK || !crosses) return status;
    return sn_fail(
        error, SN_ERROR_INPUT,
        "%s: its boundary crosses itself in every order that was tried, as after landmarks %d and %d; give them in order along the "
        "boundary, and more of them",
        o->name, (int)o->order[crossing[0]] + 1, (int)o->order[crossing[1]] + 1);
}

/* ---- the patch -------------------------------------------------------------------------------------------------------- */

/* Edges that the boundary crosses an odd number of times: their ends are on different sides. */
static void mark_crossed(const outline *o, bool *crossed) {
    for (sn_index i = 0; i < o->walked; i++)
        for (sn_index k = 0; k < o->path[i].count; k++) {
            sn_index e = o->path[i].segments[k].edge;
            if (e != SN_NONE) crossed[e] = !crossed[e];
        }
}

enum { UNSEEN = -1 };

/* Sides 0 and 1 of all vertices that can be reached from the first landmark, by area; UNSEEN elsewhere. */
static sn_status find_sides(const outline *o, const bool *crossed, signed char *side, sn_index *stack, double area[2], sn_error *error) {
    const sn_topology *t = o->ground->topology;
    sn_index size = 0, start = mesh_of(o)->triangles[o->landmark[0].triangle].v[0];
    memset(side, UNSEEN, (size_t)t->vertex_count);
    side[start] = 0;
    stack[size++] = start;
    while (size > 0) {
        sn_index v = stack[--size];
        area[side[v]] += o->ground->vertex_area[v];
        for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++) {
            sn_index w = t->neighbours[k];
            signed char expected = (signed char)(side[v] ^ (int)crossed[t->vertex_edges[k]]);
            if (side[w] == UNSEEN) {
                side[w] = expected;
                stack[size++] = w;
            } else if (side[w] != expected) {
                return sn_fail(
                    error, SN_ERROR_INPUT,
                    "%s: its boundary runs around a handle of the muscle and encloses nothing; move the landmarks, or clean the mesh",
                    o->name);
            }
        }
    }
    return SN_OK;
}

/* The smaller side; where that holds no vertex, the nearest vertex of each landmark. */
static bool take_side(const outline *o, const signed char *side, const double area[2]) {
    int smaller = area[1] < area[0];
    if (area[smaller] > 0.0) {
        for (sn_index v = 0; v < mesh_of(o)->vertex_count; v++) o->inside[v] = side[v] == smaller;
        return true;
    }
    for (sn_index i = 0; i < o->projected; i++) o->inside[corner_near(mesh_of(o), o->landmark[i].triangle, o->landmark[i].point)] = true;
    return false;
}

static sn_status fill(const outline *o, sn_attach_area *report, sn_error *error) {
    bool *crossed = SN_NEW(bool, o->ground->topology->edge_count);
    signed char *side = SN_NEW(signed char, mesh_of(o)->vertex_count);
    sn_index *stack = SN_NEW(sn_index, mesh_of(o)->vertex_count);
    double area[2] = {0.0, 0.0};
    sn_status status = SN_OK;
    if (crossed == NULL || side == NULL || stack == NULL) status = sn_fail_memory(error, "the patch of an area");
    if (status == SN_OK) {
        mark_crossed(o, crossed);
        status = find_sides(o, crossed, side, stack, area, error);
    }
    if (status == SN_OK) {
        report->coarse = !take_side(o, side, area);
        report->area_share = o->ground->total_area > 0.0 ? fmin(area[0], area[1]) / o->ground->total_area : 0.0;
    }
    free(crossed);
    free(side);
    free(stack);
    return status;
}

/* What was drawn before the trace stopped: the vertices at the landmarks, and those along the paths. */
static void show_unfinished(const outline *o) {
    for (sn_index i = 0; i < o->projected; i++) o->inside[corner_near(mesh_of(o), o->landmark[i].triangle, o->landmark[i].point)] = true;
    for (sn_index i = 0; i < o->walked; i++)
        for (sn_index k = 0; k < o->path[i].count; k++)
            o->inside[corner_near(mesh_of(o), o->path[i].segments[k].triangle, o->path[i].segments[k].to)] = true;
}

static sn_status trace_patch(const outline *o, sn_attach_area *report, sn_error *error) {
    sn_index *list = SN_NEW(sn_index, mesh_of(o)->vertex_count), count = 0;
    if (list == NULL) return sn_fail_memory(error, "the patch of an area");
    for (sn_index v = 0; v < mesh_of(o)->vertex_count; v++)
        if (o->inside[v]) list[count++] = v;
    report->vertices = count;
    bool stop = SN_TRACE(o->trace, "patch", sn_trace_text("bone", o->area->bone), sn_trace_text("area", o->area->name),
                         sn_trace_number("areaShare", report->area_share), sn_trace_indices("vertices", list, count));
    free(list);
    return stop ? SN_STOPPED : SN_OK;
}

static sn_status fill_band(const outline *o, sn_attach_area *report, sn_error *error) {
    sn_line line = {.count = o->walked, .paths = o->path, .width = report->width};
    double area = 0.0;
    sn_status status = sn_line_band(o->ground, &line, o->inside, &area, error);
    report->area_share = o->ground->total_area > 0.0 ? area / o->ground->total_area : 0.0;
    report->mean_width = report->boundary > 0.0 ? area / report->boundary : 0.0;
    report->coarse = report->width > 0.0 && report->mean_width > 2.0 * report->width;
    return status;
}

static sn_status draw(outline *o, sn_attach_area *report, sn_error *error) {
    sn_status status = find_feet(o, report, error);
    if (status != SN_OK || report->left_out) return status;
    choose_kind(o, report);
    status = project(o);
    if (status == SN_OK) status = close_boundary(o, &report->reordered, error);
    for (sn_index i = 0; i < o->walked; i++) report->boundary += o->path[i].length;
    if (status == SN_STOPPED) show_unfinished(o);
    if (status == SN_OK) status = o->line ? fill_band(o, report, error) : fill(o, report, error);
    return status == SN_OK ? trace_patch(o, report, error) : status;
}

const char *const sn_area_kind_names[] = {"auto", "boundary", "line", NULL};

sn_status sn_area_patch(const sn_area_ground *ground, const sn_landmark_area *area, sn_trace *trace, bool *inside, sn_attach_area *report,
                        sn_error *error) {
    outline o = {.ground = ground, .area = area, .trace = trace, .inside = inside};
    give_name(&o);
    memset(inside, 0, (size_t)ground->muscle->mesh.vertex_count * sizeof *inside);
    int least = ground->kind == SN_AREA_BOUNDARY ? 3 : 2;
    if (area->count < least)
        return sn_fail(error, SN_ERROR_INPUT, "%s has %d landmark%s; a boundary needs at least 3, a line 2", o.name, (int)area->count,
                       area->count == 1 ? "" : "s");
    if (area->count > MOST_LANDMARKS)
        return sn_fail(error, SN_ERROR_INPUT, "%s has %d landmarks; %d are the most", o.name, (int)area->count, MOST_LANDMARKS);
    o.landmark = SN_NEW(sn_closest, area->count);
    o.order = SN_NEW(sn_index, area->count);
    o.path = SN_NEW(sn_surface_path, area->count);
    sn_status status = o.landmark != NULL && o.order != NULL && o.path != NULL ? draw(&o, report, error) : sn_fail_memory(error, "an area");
    if (o.path != NULL) forget_paths(&o);
    free(o.landmark);
    free(o.order);
    free(o.path);
    return status;
}

/* ---- the ground ------------------------------------------------------------------------------------------------------- */

static void share_areas(sn_area_ground *g) {
    const sn_mesh *mesh = &g->muscle->mesh;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        double area = 0.5 * sn_norm(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]));
        for (int k = 0; k < 3; k++) g->vertex_area[v[k]] += area / 3.0;
        g->total_area += area;
    }
}

sn_status sn_area_ground_create(const sn_muscle *muscle, const sn_topology *topology, sn_area_ground *out, sn_error *error) {
    *out = (sn_area_ground){.muscle = muscle, .topology = topology};
    out->vertex_area = SN_NEW(double, muscle->mesh.vertex_count);
    if (out->vertex_area == NULL) return sn_fail_memory(error, "the areas of a muscle");
    share_areas(out);
    sn_status status = sn_surface_create_plain(&muscle->mesh, &out->surface, error);
    return status == SN_OK ? sn_path_finder_create(&muscle->mesh, topology, &out->finder, error) : status;
}

void sn_area_ground_free(sn_area_ground *ground) {
    sn_surface_destroy(ground->surface);
    sn_path_finder_destroy(ground->finder);
    free(ground->vertex_area);
    *ground = (sn_area_ground){0};
}
