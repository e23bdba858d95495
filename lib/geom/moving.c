/*
 * moving.c -- a surface whose vertices move: neighbours, a tree of boxes that is fitted anew, nearest points and their sides.
 */
#include "sinew/moving.h"

#include <stdlib.h>
#include <string.h>

#include "sinew/exact.h"
#include "curve.h"

enum { LEAF = 4 }; /* triangles of a leaf, at most */

/* ---- triangles and their neighbours ------------------------------------------------------------------------------------------------ */

static bool make_room(sn_moving *m, sn_index vertices, sn_index triangles) {
    *m = (sn_moving){.vertex_count = vertices, .triangle_count = triangles};
    while (triangles >> m->depth > LEAF || ((triangles - 1) >> m->depth) + 1 > LEAF) m->depth++;
    return (m->triangles = SN_NEW(sn_triangle, triangles)) && (m->sources = SN_NEW(sn_index, triangles)) &&
           (m->across = sn_alloc((size_t)triangles, sizeof *m->across)) && (m->rim = SN_NEW(bool, vertices)) &&
           (m->corner_start = SN_NEW(sn_index, (size_t)vertices + 1)) && (m->corners = SN_NEW(sn_index, 3 * (size_t)triangles));
}

/* Triangles by vertex, in their order, and the vertices of the rim. */
static void list_corners(sn_moving *m) {
    for (sn_index t = 0; t < m->triangle_count; t++)
        for (int k = 0; k < 3; k++) m->corner_start[m->triangles[t].v[k] + 1]++;
    for (sn_index v = 0; v < m->vertex_count; v++) m->corner_start[v + 1] += m->corner_start[v];
    for (sn_index t = m->triangle_count; t-- > 0;)
        for (int k = 0; k < 3; k++) m->corners[--m->corner_start[m->triangles[t].v[k] + 1]] = t;
    memmove(m->corner_start, m->corner_start + 1, (size_t)m->vertex_count * sizeof *m->corner_start);
    m->corner_start[m->vertex_count] = 3 * m->triangle_count;
    for (sn_index t = 0; t < m->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            if (m->across[t][k] == SN_NONE) m->rim[m->triangles[t].v[(k + 1) % 3]] = m->rim[m->triangles[t].v[(k + 2) % 3]] = true;
}

static bool runs_along(sn_triangle t, sn_index a, sn_index b) {
    return (t.v[0] == a && t.v[1] == b) || (t.v[1] == a && t.v[2] == b) || (t.v[2] == a && t.v[0] == b);
}

static bool has_two_sides(const sn_mesh *mesh, const sn_edge *edge) {
    return edge->triangle_count == 2 && runs_along(mesh->triangles[edge->triangle[0]], edge->v[0], edge->v[1]) !=
                                            runs_along(mesh->triangles[edge->triangle[1]], edge->v[0], edge->v[1]);
}

static sn_status check_edge(const sn_mesh *mesh, const sn_edge *edge, sn_error *error) {
    if (edge->triangle_count > 2)
        return sn_fail(error, SN_ERROR_INPUT, "the edge between the vertices %ld and %ld has %ld triangles, so that it has no two sides",
                       (long)edge->v[0], (long)edge->v[1], (long)edge->triangle_count);
    if (edge->triangle_count == 2 && !has_two_sides(mesh, edge))
        return sn_fail(error, SN_ERROR_INPUT, "the triangles %ld and %ld turn opposite sides outwards", (long)edge->triangle[0],
                       (long)edge->triangle[1]);
    return SN_OK;
}

/* places (triangle_count): where each of the mesh's triangles is in the new order. */
static void link_triangles(const sn_mesh *mesh, const sn_topology *t, const sn_index *places, sn_moving *m) {
    for (sn_index i = 0; i < m->triangle_count; i++)
        for (int k = 0; k < 3; k++) {
            sn_index source = m->sources[i], e = t->triangle_edges[source][k];
            bool good = e != SN_NONE && has_two_sides(mesh, &t->edges[e]);
            m->across[i][k] = good ? places[t->edges[e].triangle[t->edges[e].triangle[0] == source]] : SN_NONE;
        }
}

static sn_status fill(const sn_mesh *mesh, bool any, sn_moving *m, sn_index *places, sn_error *error) {
    sn_topology topology;
    sn_status status = sn_curve_order(mesh, m->sources, error);
    if (status != SN_OK) return status;
    for (sn_index i = 0; i < m->triangle_count; i++) {
        m->triangles[i] = mesh->triangles[m->sources[i]];
        places[m->sources[i]] = i;
    }
    status = sn_topology_build(mesh, &topology, error);
    if (status != SN_OK) return status;
    for (sn_index e = 0; e < topology.edge_count && !any && status == SN_OK; e++) status = check_edge(mesh, &topology.edges[e], error);
    link_triangles(mesh, &topology, places, m);
    sn_topology_free(&topology);
    if (status == SN_OK) list_corners(m);
    return status;
}

static sn_status create(const sn_mesh *mesh, bool any, sn_moving *out, sn_error *error) {
    *out = (sn_moving){0};
    sn_status status = sn_mesh_validate(mesh, error);
    if (status != SN_OK) return status;
    sn_index *places = SN_NEW(sn_index, mesh->triangle_count);
    if (!make_room(out, mesh->vertex_count, mesh->triangle_count) || places == NULL)
        status = sn_fail_memory(error, "a moving surface");
    else
        status = fill(mesh, any, out, places, error);
    free(places);
    if (status != SN_OK) sn_moving_free(out);
    return status;
}

sn_status sn_moving_create(const sn_mesh *mesh, sn_moving *out, sn_error *error) { return create(mesh, false, out, error); }

sn_status sn_moving_create_any(const sn_mesh *mesh, sn_moving *out, sn_error *error) { return create(mesh, true, out, error); }

void sn_moving_free(sn_moving *moving) {
    free(moving->triangles);
    free(moving->sources);
    free(moving->across);
    free(moving->rim);
    free(moving->corner_start);
    free(moving->corners);
    *moving = (sn_moving){0};
}

size_t sn_moving_bytes(const sn_moving *m) {
    size_t triangle = sizeof *m->triangles + sizeof *m->sources + sizeof *m->across + 3 * sizeof *m->corners;
    return (size_t)m->triangle_count * triangle + (size_t)m->vertex_count * (sizeof *m->rim + sizeof *m->corner_start);
}

/* ---- a part of it ------------------------------------------------------------------------------------------------------------------ */

/* New numbers, in the order of the old ones; SN_NONE = left out. Returns how many there are. */
static sn_index number_triangles(const sn_moving *whole, const bool *keep, sn_index *numbers) {
    sn_index count = 0;
    for (sn_index t = 0; t < whole->triangle_count; t++) numbers[t] = keep[t] ? count++ : SN_NONE;
    return count;
}

static sn_index number_vertices(const sn_moving *whole, const bool *keep, sn_index *numbers, sn_index *vertices) {
    sn_index count = 0;
    for (sn_index v = 0; v < whole->vertex_count; v++) numbers[v] = SN_NONE;
    for (sn_index t = 0; t < whole->triangle_count; t++)
        for (int k = 0; k < 3 && keep[t]; k++) {
            sn_index v = whole->triangles[t].v[k];
            if (numbers[v] != SN_NONE) continue;
            vertices[count] = v;
            numbers[v] = count++;
        }
    return count;
}

static void copy_part(const sn_moving *whole, const sn_index *triangles, const sn_index *vertices, sn_moving *out) {
    for (sn_index t = 0; t < whole->triangle_count; t++) {
        sn_index i = triangles[t];
        if (i == SN_NONE) continue;
        out->sources[i] = whole->sources[t];
        for (int k = 0; k < 3; k++) {
            out->triangles[i].v[k] = vertices[whole->triangles[t].v[k]];
            out->across[i][k] = whole->across[t][k] == SN_NONE ? SN_NONE : triangles[whole->across[t][k]];
        }
    }
    list_corners(out);
}

sn_status sn_moving_part(const sn_moving *whole, const bool *keep, sn_moving *out, sn_index *vertices, sn_error *error) {
    sn_index *triangle_numbers = SN_NEW(sn_index, whole->triangle_count), *vertex_numbers = SN_NEW(sn_index, whole->vertex_count);
    *out = (sn_moving){0};
    bool made = triangle_numbers != NULL && vertex_numbers != NULL;
    if (made) {
        sn_index triangle_count = number_triangles(whole, keep, triangle_numbers);
        made = make_room(out, number_vertices(whole, keep, vertex_numbers, vertices), triangle_count);
    }
    if (made)
        copy_part(whole, triangle_numbers, vertex_numbers, out);
    else
        sn_moving_free(out);
    free(triangle_numbers);
    free(vertex_numbers);
    return made ? SN_OK : sn_fail_memory(error, "a part of a moving surface");
}

/* ---- boxes ------------------------------------------------------------------------------------------------------------------------- */

/* Consecutive triangles, and the box that holds them. */
typedef struct node {
    sn_index box, begin, end;
    int level;
} node;

static node root_of(const sn_moving *m) { return (node){1, 0, m->triangle_count, 0}; }

static node half_of(const node *n, int side) {
    sn_index middle = n->begin + (n->end - n->begin) / 2;
    return (node){2 * n->box + side, side == 0 ? n->begin : middle, side == 0 ? middle : n->end, n->level + 1};
}

sn_index sn_moving_leaf_count(const sn_moving *moving) { return (sn_index)1 << moving->depth; }

sn_index sn_moving_box_count(const sn_moving *moving) { return 2 * sn_moving_leaf_count(moving); }

sn_index sn_moving_leaf(const sn_moving *moving, sn_index triangle) {
    node n = root_of(moving);
    while (n.level < moving->depth) n = half_of(&n, triangle >= n.begin + (n.end - n.begin) / 2);
    return n.box - sn_moving_leaf_count(moving);
}

static sn_box box_of(const sn_moving *m, const sn_vec3 *positions, const node *n) {
    sn_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (sn_index t = n->begin; t < n->end; t++)
        for (int k = 0; k < 3; k++) {
            sn_vec3 p = positions[m->triangles[t].v[k]];
            box.low = sn_min3(box.low, p);
            box.high = sn_max3(box.high, p);
        }
    return box;
}

/* The tree is 28 levels deep at most. */
static void fit_node(const sn_moving *m, const sn_vec3 *positions, const node *n, sn_box *boxes) { /* NOLINT(misc-no-recursion) */
    if (n->level == m->depth) {
        boxes[n->box] = box_of(m, positions, n);
        return;
    }
    for (int side = 0; side < 2; side++) {
        node half = half_of(n, side);
        fit_node(m, positions, &half, boxes);
    }
    const sn_box *a = &boxes[2 * n->box], *b = a + 1;
    boxes[n->box] = (sn_box){sn_min3(a->low, b->low), sn_max3(a->high, b->high)};
}

void sn_moving_fit(const sn_moving *moving, const sn_vec3 *positions, sn_box *boxes) {
    node root = root_of(moving);
    fit_node(moving, positions, &root, boxes);
}

static bool meet(const sn_box *a, const sn_box *b) {
    return a->low.x <= b->high.x && b->low.x <= a->high.x && a->low.y <= b->high.y && b->low.y <= a->high.y && a->low.z <= b->high.z &&
           b->low.z <= a->high.z;
}

/* The nodes still to be looked at: one for each level, and its sibling. */
enum { MOST_WAITING = 64 };

void sn_moving_touch(const sn_moving *moving, const sn_box *boxes, const sn_box *box, bool *touched) {
    sn_index waiting[MOST_WAITING], count = 0, leaves = sn_moving_leaf_count(moving);
    waiting[count++] = 1;
    while (count > 0) {
        sn_index n = waiting[--count];
        if (!meet(&boxes[n], box)) continue;
        if (n >= leaves)
            touched[n - leaves] = true;
        else
            waiting[count++] = 2 * n, waiting[count++] = 2 * n + 1;
    }
}

/* ---- nearest points ------------------------------------------------------------------------------------------------------------------ */

static sn_closest nearest_of(const sn_moving_shape *s, sn_index t, sn_vec3 p) {
    const sn_index *v = s->moving->triangles[t].v;
    sn_closest c = {.triangle = t};
    c.point = sn_closest_on_triangle(p, s->positions[v[0]], s->positions[v[1]], s->positions[v[2]], c.barycentric);
    c.distance = sn_norm2(sn_sub(p, c.point)); /* squared until it is handed out */
    return c;
}

/* The corners of its triangle that a point lies on: bits. */
static unsigned corners_of(const sn_closest *c) {
    return (unsigned)(c->barycentric[0] > 0.0) | (unsigned)(c->barycentric[1] > 0.0) << 1 | (unsigned)(c->barycentric[2] > 0.0) << 2;
}

/* Of a corner's bit, or of the bits of the two ends of an edge, the corner, or the one opposite: 0, 1 or 2; SN_NONE = inside. */
static int feature_of(unsigned corners, bool *is_vertex) {
    static const int numbers[8] = {SN_NONE, 0, 1, 2, 2, 1, 0, SN_NONE};
    *is_vertex = corners == 1 || corners == 2 || corners == 4;
    return *is_vertex ? (corners == 4 ? 2 : (int)corners - 1) : numbers[corners];
}

static bool take_nearer(const sn_moving_shape *s, sn_index t, sn_vec3 p, sn_closest *best) {
    if (t == SN_NONE) return false;
    sn_closest other = nearest_of(s, t, p);
    if (!(other.distance < best->distance)) return false;
    *best = other;
    return true;
}

/* The nearest of the triangles that share the edge or the corner on which the point lies; false: it is nearer than all of them. */
static bool step(const sn_moving_shape *s, sn_vec3 p, sn_closest *best) {
    const sn_moving *m = s->moving;
    bool is_vertex, moved = false;
    sn_index t = best->triangle;
    int k = feature_of(corners_of(best), &is_vertex);
    if (k == SN_NONE) return false;
    if (!is_vertex) return take_nearer(s, m->across[t][k], p, best);
    sn_index v = m->triangles[t].v[k];
    for (sn_index i = m->corner_start[v]; i < m->corner_start[v + 1]; i++) moved = take_nearer(s, m->corners[i], p, best) || moved;
    return moved;
}

static sn_closest walk(const sn_moving_shape *s, sn_index from, sn_vec3 p) {
    sn_closest best = nearest_of(s, from < 0 || from >= s->moving->triangle_count ? 0 : from, p);
    while (step(s, p, &best)) continue; /* each is strictly nearer: it ends */
    return best;
}

sn_closest sn_moving_walk(const sn_moving_shape *shape, sn_index from, sn_vec3 p) {
    sn_closest best = walk(shape, from, p);
    best.distance = sqrt(best.distance);
    return best;
}

/* How far beside an interval; not fmax, which is a call. */
static double beside(double p, double low, double high) { return p < low ? low - p : p > high ? p - high : 0.0; }

/* The square of how far from a box a point is. */
static double away_from(const sn_box *box, sn_vec3 p) {
    double x = beside(p.x, box->low.x, box->high.x), y = beside(p.y, box->low.y, box->high.y), z = beside(p.z, box->low.z, box->high.z);
    return x * x + y * y + z * z;
}

static void search_leaf(const sn_moving_shape *s, const node *n, sn_vec3 p, sn_closest *best) {
    for (sn_index t = n->begin; t < n->end; t++) {
        sn_closest other = nearest_of(s, t, p);
        if (other.distance < best->distance || (other.distance == best->distance && t < best->triangle)) *best = other;
    }
}

sn_closest sn_moving_closest(const sn_moving_shape *shape, sn_index from, sn_vec3 p) {
    sn_closest best = walk(shape, from, p);
    node waiting[MOST_WAITING];
    int count = 0;
    waiting[count++] = root_of(shape->moving);
    while (count > 0) {
        node n = waiting[--count];
        if (away_from(&shape->boxes[n.box], p) > best.distance) continue;
        if (n.level == shape->moving->depth) {
            search_leaf(shape, &n, p, &best);
            continue;
        }
        node halves[2] = {half_of(&n, 0), half_of(&n, 1)};
        bool second = away_from(&shape->boxes[halves[1].box], p) < away_from(&shape->boxes[halves[0].box], p);
        waiting[count++] = halves[!second];
        waiting[count++] = halves[second]; /* the nearer one first */
    }
    best.distance = sqrt(best.distance);
    return best;
}

sn_vec3 sn_moving_point(const sn_moving_shape *shape, const sn_closest *foot) {
    const sn_index *v = shape->moving->triangles[foot->triangle].v;
    sn_vec3 p = sn_scale(shape->positions[v[0]], foot->barycentric[0]);
    for (int k = 1; k < 3; k++) p = sn_add_scaled(p, shape->positions[v[k]], foot->barycentric[k]);
    return p;
}

/* ---- sides ------------------------------------------------------------------------------------------------------------------------- */

static sn_vec3 unit_normal(const sn_moving_shape *s, sn_index t) {
    const sn_index *v = s->moving->triangles[t].v;
    return sn_normalize(sn_area_vector(s->positions[v[0]], s->positions[v[1]], s->positions[v[2]]));
}

static double corner_angle(const sn_moving_shape *s, sn_index t, sn_index vertex) {
    const sn_index *v = s->moving->triangles[t].v;
    int k = v[0] == vertex ? 0 : v[1] == vertex ? 1 : 2;
    sn_vec3 at = s->positions[vertex], a = sn_sub(s->positions[v[(k + 1) % 3]], at), b = sn_sub(s->positions[v[(k + 2) % 3]], at);
    return sn_quick_atan2(sn_norm(sn_cross(a, b)), sn_dot(a, b));
}

/* Of the corner, the edge or the face that the point lies on, of any length; *on_rim: it has one side alone. */
static sn_vec3 pseudonormal(const sn_moving_shape *s, const sn_closest *foot, bool *on_rim) {
    const sn_moving *m = s->moving;
    sn_index t = foot->triangle;
    bool is_vertex;
    int k = feature_of(corners_of(foot), &is_vertex);
    *on_rim = false;
    if (k == SN_NONE) return unit_normal(s, t);
    sn_index v = m->triangles[t].v[k];
    *on_rim = is_vertex ? m->rim[v] : m->across[t][k] == SN_NONE;
    if (*on_rim) return unit_normal(s, t);
    if (!is_vertex) return sn_add(unit_normal(s, t), unit_normal(s, m->across[t][k]));
    sn_vec3 sum = {0, 0, 0};
    for (sn_index i = m->corner_start[v]; i < m->corner_start[v + 1]; i++)
        sum = sn_add_scaled(sum, unit_normal(s, m->corners[i]), corner_angle(s, m->corners[i], v));
    return sum;
}

double sn_moving_side(const sn_moving_shape *shape, const sn_closest *foot, sn_vec3 p, sn_vec3 *gradient) {
    bool on_rim;
    sn_vec3 normal = pseudonormal(shape, foot, &on_rim), away = sn_sub(p, foot->point);
    double sign = !on_rim && sn_dot(away, normal) < 0.0 ? -1.0 : 1.0;
    if (gradient != NULL) *gradient = foot->distance > 0.0 ? sn_scale(away, sign / foot->distance) : sn_normalize(normal);
    return sign * foot->distance;
}
