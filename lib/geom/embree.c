/*
 * embree.c -- closest points, signed distances and rays on a surface; the only user of Embree.
 *
 * Embree works in single precision, with instructions that differ between processors. It sees the mesh centred and scaled to about the
 * unit box, so that a mesh a kilometre from the origin works as well as one at it, and knows of every triangle only its box: it serves to
 * find candidates. The distance to each is computed here in double, on the mesh's own coordinates, and all that it prunes with is enlarged
 * by what rounding may have moved. So results do not depend on what Embree rounds how.
 */
#include "sinew/geom.h"

#include <stdlib.h>
#include <string.h>

#include <embree3/rtcore.h>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include "winding_tree.h"

/* A piece of the surface whose nearest point tells inside from outside: every edge has two triangles that run through it in opposite
 * directions, and it does not cross itself. */
typedef struct part {
    int winding; /* of a point inside: 1, -1 where the piece is inside out, 0 where it encloses nothing */
    sn_box box;
} part;

struct sn_surface {
    const sn_mesh *mesh;
    sn_topology topology;
    sn_box box;
    sn_vec3 centre; /* of the box */
    double scale;   /* a power of two: (p - centre) scale is within the cube of half size 2 */
    sn_index part_count;
    part *parts;       /* (part_count) */
    sn_index *part_of; /* (triangle_count) SN_NONE: of no such piece */
    sn_mesh open;      /* the triangles of no such piece; shares the positions of mesh, owns its triangles */
    sn_box open_box;
    sn_winding_tree winding; /* of open */
    bool has_inside;         /* the fields above are filled: distances have a sign */
    RTCDevice device;
    RTCScene scene;
};

/* ---- floating-point mode -------------------------------------------------------------------------------------------------- */

/* Embree is slow on denormals: they are flushed to zero while it runs, and the caller's mode comes back after it. */
#if defined(__SSE__)
static unsigned flush_denormals(void) {
    unsigned mode = _mm_getcsr();
    _mm_setcsr(mode | 0x8040u); /* FTZ | DAZ */
    return mode;
}
static void restore_mode(unsigned mode) { _mm_setcsr(mode); }
#else
static unsigned flush_denormals(void) { return 0; }
static void restore_mode(unsigned mode) { (void)mode; }
#endif

/* ---- boxes ------------------------------------------------------------------------------------------------------------------ */

static bool box_holds(sn_box box, sn_vec3 p) {
    return p.x >= box.low.x && p.y >= box.low.y && p.z >= box.low.z && p.x <= box.high.x && p.y <= box.high.y && p.z <= box.high.z;
}

static void box_add_triangle(sn_box *box, const sn_mesh *mesh, sn_index t) {
    for (int k = 0; k < 3; k++) sn_box_add(box, mesh->positions[mesh->triangles[t].v[k]]);
}

/* ---- Embree's copy ------------------------------------------------------------------------------------------------------------ */

static sn_status embree_status(RTCDevice device, sn_error *error) {
    enum RTCError code = rtcGetDeviceError(device);
    if (code == RTC_ERROR_NONE) return SN_OK;
    if (code == RTC_ERROR_OUT_OF_MEMORY) return sn_fail_memory(error, "a search structure");
    return sn_fail(error, SN_ERROR_INTERNAL, "Embree failed to build a search structure (error %d)", (int)code);
}

static void store_scaled(const sn_surface *s, sn_vec3 p, float out[3]) {
    sn_vec3 q = sn_scale(sn_sub(p, s->centre), s->scale);
    out[0] = (float)q.x;
    out[1] = (float)q.y;
    out[2] = (float)q.z;
}

/* Boxes are wider than their triangles by this, in Embree's scale: some 30 units in the last place of the largest coordinate. */
static const float box_margin = 4e-6f;

static void bound_triangle(const struct RTCBoundsFunctionArguments *arguments) {
    const sn_surface *s = arguments->geometryUserPtr;
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, p[3];
    for (int k = 0; k < 3; k++) {
        store_scaled(s, s->mesh->positions[s->mesh->triangles[arguments->primID].v[k]], p);
        for (int i = 0; i < 3; i++) {
            low[i] = fminf(low[i], p[i]);
            high[i] = fmaxf(high[i], p[i]);
        }
    }
    struct RTCBounds *box = arguments->bounds_o;
    box->lower_x = low[0] - box_margin, box->lower_y = low[1] - box_margin, box->lower_z = low[2] - box_margin;
    box->upper_x = high[0] + box_margin, box->upper_y = high[1] + box_margin, box->upper_z = high[2] + box_margin;
}

static void meet_triangle(const struct RTCIntersectFunctionNArguments *arguments);
static void meet_edge(const struct RTCOccludedFunctionNArguments *arguments);

static void fill_scene(sn_surface *s) {
    s->scene = rtcNewScene(s->device);
    if (s->scene == NULL) return;
    rtcSetSceneFlags(s->scene, RTC_SCENE_FLAG_ROBUST); /* no ray slips by a box that it meets */
    rtcSetSceneBuildQuality(s->scene, RTC_BUILD_QUALITY_MEDIUM);
    RTCGeometry geometry = rtcNewGeometry(s->device, RTC_GEOMETRY_TYPE_USER);
    if (geometry == NULL) return;
    rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)s->mesh->triangle_count);
    rtcSetGeometryUserData(geometry, s);
    rtcSetGeometryBoundsFunction(geometry, bound_triangle, NULL);
    rtcSetGeometryIntersectFunction(geometry, meet_triangle);
    rtcSetGeometryOccludedFunction(geometry, meet_edge);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(s->scene, geometry);
    rtcCommitScene(s->scene);
    rtcReleaseGeometry(geometry);
}

static sn_status build_scene(sn_surface *s, sn_error *error) {
    unsigned mode = flush_denormals();
    s->device = rtcNewDevice("threads=1,set_affinity=0");
    if (s->device != NULL) fill_scene(s);
    restore_mode(mode);
    return embree_status(s->device, error); /* NULL asks for the error of rtcNewDevice */
}

/* ---- a line and a triangle --------------------------------------------------------------------------------------------------------- */

/* p(t) = origin + t direction, seen along itself: x and y are what is left of a point when the line is sheared onto the axis that it
 * follows most. */
typedef struct sight {
    sn_vec3 origin;
    int axis[3]; /* x, y, z of the line's frame */
    double shear[3];
} sight;

static double component(sn_vec3 a, int axis) { return axis == 0 ? a.x : axis == 1 ? a.y : a.z; }

static sight sight_along(sn_vec3 origin, sn_vec3 direction) {
    double x = fabs(direction.x), y = fabs(direction.y), z = fabs(direction.z);
    int most = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    sight line = {.origin = origin, .axis = {(most + 1) % 3, (most + 2) % 3, most}};
    double along = component(direction, most);
    for (int k = 0; k < 2; k++) line.shear[k] = component(direction, line.axis[k]) / along;
    line.shear[2] = 1.0 / along;
    return line;
}

/* Where the line meets triangle t of the mesh, as t and the weights of the corners 1 and 2; false where it does not, or lies in its plane.
 * Watertight: the two triangles of an edge see the same sign (Woop, Benthin, Wald 2013). */
static bool meets(const sight *line, const sn_mesh *mesh, sn_index triangle, double *t, double weight[2]) {
    const sn_index *v = mesh->triangles[triangle].v;
    double x[3], y[3], z[3];
    for (int k = 0; k < 3; k++) {
        sn_vec3 d = sn_sub(mesh->positions[v[k]], line->origin);
        const double p[3] = {d.x, d.y, d.z};
        z[k] = p[line->axis[2]];
        x[k] = p[line->axis[0]] - line->shear[0] * z[k];
        y[k] = p[line->axis[1]] - line->shear[1] * z[k];
    }
    double a = x[2] * y[1] - y[2] * x[1], b = x[0] * y[2] - y[0] * x[2], c = x[1] * y[0] - y[1] * x[0], sum = a + b + c;
    if (((a < 0.0) | (b < 0.0) | (c < 0.0)) == ((a > 0.0) | (b > 0.0) | (c > 0.0)) || sum == 0.0) return false; /* beside it, or edge-on */
    *t = line->shear[2] * (a * z[0] + b * z[1] + c * z[2]) / sum;
    weight[0] = b / sum;
    weight[1] = c / sum;
    return true;
}

/* ---- the closed pieces of the surface ---------------------------------------------------------------------------------------- */

/* The triangle on the other side of the edge opposite to corner k; SN_NONE where the edge is a border, non-manifold or badly wound. */
static sn_index across(const sn_surface *s, sn_index t, int k) {
    sn_index e = s->topology.triangle_edges[t][k];
    if (e == SN_NONE) return SN_NONE;
    const sn_edge *edge = &s->topology.edges[e];
    if (edge->triangle_count != 2) return SN_NONE;
    const sn_triangle *triangles = s->mesh->triangles;
    bool first = sn_triangle_runs(&triangles[edge->triangle[0]], edge->v[0], edge->v[1]);
    bool second = sn_triangle_runs(&triangles[edge->triangle[1]], edge->v[0], edge->v[1]);
    if (first == second) return SN_NONE;
    return edge->triangle[edge->triangle[0] == t];
}

/* Triangles reached from seed over good edges, listed in piece; true if they close. label holds SN_NONE where not yet reached. */
static bool flood(const sn_surface *s, sn_index seed, sn_index *label, sn_index *piece, sn_index *size) {
    bool closed = true;
    *size = 0;
    piece[(*size)++] = seed;
    label[seed] = seed;
    for (sn_index i = 0; i < *size; i++) {
        for (int k = 0; k < 3; k++) {
            sn_index next = across(s, piece[i], k);
            if (next == SN_NONE) closed = false;
            if (next == SN_NONE || label[next] != SN_NONE) continue;
            label[next] = seed;
            piece[(*size)++] = next;
        }
    }
    return closed;
}

/* An edge sent as a ray through the piece that is labelled like it. */
typedef struct edge_ray {
    struct RTCIntersectContext context; /* first: Embree hands out its address */
    const sn_edge *edge;
    const sn_index *label;
    sight line;
} edge_ray;

/* Does it go through a triangle of its piece that it does not end in? Embree sends one ray at a time. */
static void meet_edge(const struct RTCOccludedFunctionNArguments *arguments) {
    const edge_ray *ray = (const edge_ray *)arguments->context;
    const sn_surface *s = arguments->geometryUserPtr;
    sn_index t = (sn_index)arguments->primID;
    const sn_index *v = s->mesh->triangles[t].v, *end = ray->edge->v;
    bool touches = v[0] == end[0] || v[1] == end[0] || v[2] == end[0] || v[0] == end[1] || v[1] == end[1] || v[2] == end[1];
    if (touches || ray->label[t] != ray->label[ray->edge->triangle[0]]) return;
    double at, weight[2];
    if (meets(&ray->line, s->mesh, t, &at, weight) && at >= 0.0 && at <= 1.0) ((struct RTCRay *)arguments->ray)->tfar = -INFINITY;
}

static bool edge_crosses(const sn_surface *s, const sn_edge *edge, const sn_index *label) {
    edge_ray ray = {.edge = edge, .label = label};
    rtcInitIntersectContext(&ray.context);
    sn_vec3 from = s->mesh->positions[edge->v[0]], to = s->mesh->positions[edge->v[1]];
    ray.line = sight_along(from, sn_sub(to, from));
    float a[3], b[3];
    store_scaled(s, from, a);
    store_scaled(s, to, b);
    struct RTCRay segment = {.org_x = a[0], .org_y = a[1], .org_z = a[2], .tfar = 1.0f, .mask = UINT32_MAX};
    segment.dir_x = b[0] - a[0];
    segment.dir_y = b[1] - a[1];
    segment.dir_z = b[2] - a[2];
    rtcOccluded1(s->scene, &ray.context, &segment);
    return segment.tfar < 0.0f;
}

/* Two triangles that cross have an edge of one going through the other. A touch counts as a crossing, which costs time only: the winding
 * number then tells inside from outside. */
static bool crosses_itself(const sn_surface *s, const sn_index *label, const sn_index *piece, sn_index size) {
    bool crosses = false;
    unsigned mode = flush_denormals();
    for (sn_index i = 0; i < size && !crosses; i++) {
        for (int k = 0; k < 3 && !crosses; k++) {
            const sn_edge *edge = &s->topology.edges[s->topology.triangle_edges[piece[i]][k]];
            if (edge->triangle[0] == piece[i]) crosses = edge_crosses(s, edge, label);
        }
    }
    restore_mode(mode);
    return crosses;
}

/* Box and orientation of a closed piece, from the sign of the volume that it encloses; a sheet folded on itself encloses none. */
static part measure_part(const sn_surface *s, const sn_index *piece, sn_index size) {
    part p = {.box = SN_EMPTY_BOX};
    double volume = 0.0, size3 = 0.0; /* six times the volume, and the sum of its terms' sizes for rounding */
    sn_vec3 origin = s->mesh->positions[s->mesh->triangles[piece[0]].v[0]];
    for (sn_index i = 0; i < size; i++) {
        const sn_index *v = s->mesh->triangles[piece[i]].v;
        sn_vec3 a = sn_sub(s->mesh->positions[v[0]], origin), b = sn_sub(s->mesh->positions[v[1]], origin);
        sn_vec3 c = sn_sub(s->mesh->positions[v[2]], origin);
        double term = sn_dot(a, sn_cross(b, c));
        volume += term;
        size3 += fabs(term);
        box_add_triangle(&p.box, s->mesh, piece[i]);
    }
    if (fabs(volume) > 1e-9 * size3) p.winding = volume > 0.0 ? 1 : -1;
    return p;
}

static sn_status add_part(sn_surface *s, size_t *capacity, const sn_index *piece, sn_index size, sn_error *error) {
    void *parts = s->parts;
    if (!sn_grow(&parts, capacity, (size_t)s->part_count + 1, sizeof *s->parts)) return sn_fail_memory(error, "a search structure");
    s->parts = parts;
    s->parts[s->part_count] = measure_part(s, piece, size);
    for (sn_index i = 0; i < size; i++) s->part_of[piece[i]] = s->part_count;
    s->part_count++;
    return SN_OK;
}

static void add_open(sn_surface *s, const sn_index *piece, sn_index size) {
    for (sn_index i = 0; i < size; i++) {
        s->part_of[piece[i]] = SN_NONE;
        s->open.triangles[s->open.triangle_count++] = s->mesh->triangles[piece[i]];
        box_add_triangle(&s->open_box, s->mesh, piece[i]);
    }
}

/* Split the surface into pieces that the pseudonormals are good for, and the rest. */
static sn_status find_parts(sn_surface *s, sn_error *error) {
    sn_index count = s->mesh->triangle_count, size;
    sn_status status = SN_OK;
    size_t capacity = 0;
    sn_index *label = SN_NEW(sn_index, count), *piece = SN_NEW(sn_index, count);
    s->part_of = SN_NEW(sn_index, count);
    s->open = (sn_mesh){.vertex_count = s->mesh->vertex_count, .positions = s->mesh->positions, .triangles = SN_NEW(sn_triangle, count)};
    s->open_box = SN_EMPTY_BOX;
    if (label == NULL || piece == NULL || s->part_of == NULL || s->open.triangles == NULL) {
        status = sn_fail_memory(error, "a search structure");
        goto cleanup;
    }
    for (sn_index t = 0; t < count; t++) label[t] = SN_NONE;
    for (sn_index t = 0; t < count && status == SN_OK; t++) {
        if (label[t] != SN_NONE) continue;
        bool closed = flood(s, t, label, piece, &size);
        if (closed && !crosses_itself(s, label, piece, size))
            status = add_part(s, &capacity, piece, size, error);
        else
            add_open(s, piece, size);
    }
cleanup:
    free(label);
    free(piece);
    return status;
}

/* ---- create and destroy --------------------------------------------------------------------------------------------------------- */

static void set_frame(sn_surface *s) {
    s->box = sn_mesh_box(s->mesh);
    s->centre = sn_lerp(s->box.low, s->box.high, 0.5);
    sn_vec3 half = sn_sub(s->box.high, s->centre);
    double size = fmax(half.x, fmax(half.y, half.z));
    s->scale = size > 0.0 ? ldexp(1.0, -ilogb(size)) : 1.0;
}

/* What the sign of a distance needs. */
static sn_status find_inside(sn_surface *s, sn_error *error) {
    sn_status status = sn_topology_build(s->mesh, &s->topology, error);
    if (status == SN_OK) status = find_parts(s, error);
    if (status == SN_OK) status = sn_winding_tree_build(&s->open, &s->winding, error);
    s->has_inside = status == SN_OK;
    return status;
}

static sn_status create(const sn_mesh *mesh, bool with_inside, sn_surface **out, sn_error *error) {
    *out = NULL;
    sn_status status = sn_mesh_validate(mesh, error);
    if (status != SN_OK) return status;
    sn_surface *s = SN_NEW(sn_surface, 1);
    if (s == NULL) return sn_fail_memory(error, "a search structure");
    s->mesh = mesh;
    set_frame(s);
    status = build_scene(s, error);
    if (status == SN_OK && with_inside) status = find_inside(s, error);
    if (status != SN_OK) {
        sn_surface_destroy(s);
        return status;
    }
    *out = s;
    return SN_OK;
}

sn_status sn_surface_create(const sn_mesh *mesh, sn_surface **out, sn_error *error) { return create(mesh, true, out, error); }

sn_status sn_surface_create_plain(const sn_mesh *mesh, sn_surface **out, sn_error *error) { return create(mesh, false, out, error); }

void sn_surface_destroy(sn_surface *surface) {
    if (surface == NULL) return;
    if (surface->scene != NULL) rtcReleaseScene(surface->scene);
    if (surface->device != NULL) rtcReleaseDevice(surface->device);
    sn_topology_free(&surface->topology);
    free(surface->parts);
    free(surface->part_of);
    free(surface->open.triangles);
    sn_winding_tree_free(&surface->winding);
    free(surface);
}

/* ---- closest point ---------------------------------------------------------------------------------------------------------------- */

typedef struct search {
    const sn_surface *surface;
    sn_vec3 point;
    sn_index only_part; /* SN_NONE = the whole surface */
    double best2;       /* square of the distance to beat, or to match with a lower triangle */
    sn_closest closest;
    double slack; /* in Embree's scale: how far rounding to float may move the point, a triangle and their distance */
} search;

/* Try one triangle; true if it is the closest so far. */
static bool try_triangle(search *q, sn_index t) {
    const sn_mesh *mesh = q->surface->mesh;
    if (q->only_part != SN_NONE && q->surface->part_of[t] != q->only_part) return false;
    const sn_index *v = mesh->triangles[t].v;
    double barycentric[3];
    sn_vec3 p = sn_closest_on_triangle(q->point, mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]], barycentric);
    double distance2 = sn_norm2(sn_sub(p, q->point));
    bool tie_won = distance2 == q->best2 && (q->closest.triangle == SN_NONE || t < q->closest.triangle);
    if (!(distance2 < q->best2 || tie_won)) return false;
    q->best2 = distance2;
    q->closest.triangle = t;
    q->closest.point = p;
    memcpy(q->closest.barycentric, barycentric, sizeof barycentric);
    return true;
}

/* What Embree must not prune: the best distance, rounded up, plus the slack. */
static float search_radius(const search *q) { return (float)((sqrt(q->best2) * q->surface->scale + q->slack) * (1.0 + 1e-6)); }

static bool visit(struct RTCPointQueryFunctionArguments *arguments) {
    search *q = arguments->userPtr;
    if (!try_triangle(q, (sn_index)arguments->primID)) return false;
    arguments->query->radius = search_radius(q);
    return true;
}

/* Farther away than this (in sizes of the mesh) single precision cannot tell its triangles apart: look at all of them. */
static const double far_away = 1e5;

static void search_tree(search *q, const float at[3]) {
    struct RTCPointQuery query = {.x = at[0], .y = at[1], .z = at[2], .radius = search_radius(q)};
    struct RTCPointQueryContext context;
    unsigned mode = flush_denormals();
    rtcInitPointQueryContext(&context);
    rtcPointQuery(q->surface->scene, &query, &context, visit, q);
    restore_mode(mode);
}

static sn_closest find_closest(const sn_surface *s, sn_vec3 point, double max_distance, sn_index only_part) {
    search q = {.surface = s, .point = point, .only_part = only_part, .best2 = max_distance * max_distance};
    q.closest = (sn_closest){.triangle = SN_NONE, .distance = INFINITY};
    if (!sn_finite3(point) || !(max_distance >= 0.0)) return q.closest;
    double away = sn_distance(point, s->centre) * s->scale;
    if (away < far_away) {
        float at[3];
        store_scaled(s, point, at);
        q.slack = 2e-6 * (4.0 + away); /* some 30 units in the last place of the largest coordinate */
        search_tree(&q, at);
    } else {
        for (sn_index t = 0; t < s->mesh->triangle_count; t++) try_triangle(&q, t);
    }
    if (q.closest.triangle != SN_NONE) q.closest.distance = sqrt(q.best2);
    return q.closest;
}

sn_closest sn_surface_closest(const sn_surface *surface, sn_vec3 point, double max_distance) {
    return find_closest(surface, point, max_distance, SN_NONE);
}

/* ---- signed distance ----------------------------------------------------------------------------------------------------- */

static sn_vec3 unit_normal(const sn_mesh *mesh, sn_index t) {
    const sn_index *v = mesh->triangles[t].v;
    return sn_normalize(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]));
}

/* Angle of triangle t at its vertex v. */
static double corner_angle(const sn_mesh *mesh, sn_index t, sn_index v) {
    const sn_index *corner = mesh->triangles[t].v;
    int k = corner[0] == v ? 0 : corner[1] == v ? 1 : 2;
    sn_vec3 a = sn_sub(mesh->positions[corner[(k + 1) % 3]], mesh->positions[v]);
    sn_vec3 b = sn_sub(mesh->positions[corner[(k + 2) % 3]], mesh->positions[v]);
    return sn_quick_atan2(sn_norm(sn_cross(a, b)), sn_dot(a, b));
}

static sn_vec3 vertex_pseudonormal(const sn_surface *s, sn_index v, sn_index piece) {
    sn_vec3 sum = {0, 0, 0};
    for (sn_index i = s->topology.corner_start[v]; i < s->topology.corner_start[v + 1]; i++) {
        sn_index t = s->topology.vertex_triangles[i];
        if (s->part_of[t] == piece) sum = sn_add_scaled(sum, unit_normal(s->mesh, t), corner_angle(s->mesh, t, v));
    }
    return sum;
}

/* Angle-weighted pseudonormal of the feature that the closest point lies on (Baerentzen & Aanaes 2005): a corner, a side, the face. */
static sn_vec3 pseudonormal(const sn_surface *s, const sn_closest *c) {
    sn_index t = c->triangle;
    int zeros = 0, zero = 0, positive = 0;
    for (int k = 0; k < 3; k++) {
        if (c->barycentric[k] > 0.0)
            positive = k;
        else
            zeros++, zero = k;
    }
    if (zeros == 2) return vertex_pseudonormal(s, s->mesh->triangles[t].v[positive], s->part_of[t]);
    if (zeros == 0) return unit_normal(s->mesh, t);
    const sn_edge *edge = &s->topology.edges[s->topology.triangle_edges[t][zero]];
    return sn_add(unit_normal(s->mesh, edge->triangle[0]), unit_normal(s->mesh, edge->triangle[1]));
}

/* Greater than 0 outside, less inside the closed piece that c is the closest point on, 0 where it cannot be told. */
static double side_of(const sn_surface *s, sn_vec3 point, const sn_closest *c) {
    return sn_dot(sn_sub(point, c->point), pseudonormal(s, c));
}

/* Winding number not zero: pieces add up, so overlapping pieces are one body, a piece turned inwards is a cavity in the one around it,
 * and a body that is inside out still has its inside inside. */
static bool is_inside(const sn_surface *s, sn_vec3 point, const sn_closest *closest) {
    if (!box_holds(s->box, point)) return false;
    double winding = box_holds(s->open_box, point) ? sn_winding_tree_number(&s->winding, point) : 0.0;
    for (sn_index i = 0; i < s->part_count; i++) {
        const part *p = &s->parts[i];
        if (p->winding == 0 || !box_holds(p->box, point)) continue;
        sn_closest c = s->part_of[closest->triangle] == i ? *closest : find_closest(s, point, INFINITY, i);
        double side = side_of(s, point, &c);
        if (side == 0.0) return fabs(sn_winding_number(s->mesh, point)) > 0.5;
        if (side * p->winding < 0.0) winding += p->winding;
    }
    return fabs(winding) > 0.5;
}

double sn_surface_signed_distance(const sn_surface *surface, sn_vec3 point, sn_closest *closest) {
    sn_closest c = find_closest(surface, point, INFINITY, SN_NONE);
    if (closest != NULL) *closest = c;
    if (c.triangle == SN_NONE || c.distance == 0.0 || !surface->has_inside) return c.distance;
    return is_inside(surface, point, &c) ? -c.distance : c.distance;
}

/* ---- rays ---------------------------------------------------------------------------------------------------------------- */

typedef struct ray_search {
    struct RTCIntersectContext context; /* first: Embree hands out its address */
    sight line;
    double start, near, far; /* the line begins at `start` along the ray; a hit is in (near, far) */
    sn_ray_hit best;
    float slack;
} ray_search;

static float ray_end(const sn_surface *s, const ray_search *q, double distance) {
    return (float)((distance - q->start) * s->scale * (1.0 + 1e-6)) + q->slack;
}

/* Ties go to the lowest triangle. */
static void meet_triangle(const struct RTCIntersectFunctionNArguments *arguments) {
    ray_search *q = (ray_search *)arguments->context;
    const sn_surface *s = arguments->geometryUserPtr;
    sn_index t = (sn_index)arguments->primID;
    double at, weight[2];
    if (!meets(&q->line, s->mesh, t, &at, weight)) return;
    double distance = q->start + at;
    if (!(distance > q->near && distance < q->far)) return;
    if (distance > q->best.distance || (distance == q->best.distance && t > q->best.triangle)) return;
    q->best = (sn_ray_hit){t, weight[0], weight[1], distance};
    ((struct RTCRayHit *)arguments->rayhit)->ray.tfar = ray_end(s, q, distance);
}

sn_ray_hit sn_surface_ray(const sn_surface *surface, sn_vec3 origin, sn_vec3 direction, double near, double far) {
    ray_search q = {.near = near, .far = far, .best = {.triangle = SN_NONE, .distance = INFINITY}, .slack = 4e-6f};
    sn_vec3 d = sn_normalize(direction);
    if (!(sn_norm2(d) > 0.0) || !sn_finite3(origin) || !(near < far)) return q.best;
    /* start just before the mesh: an origin far away would cost the digits that tell its triangles apart */
    double before = sn_dot(sn_sub(surface->centre, origin), d) - 4.0 / surface->scale;
    q.start = fmax(near, before);
    q.line = sight_along(sn_add_scaled(origin, d, q.start), d);
    float at[3];
    store_scaled(surface, q.line.origin, at);
    if (!isfinite(at[0]) || !isfinite(at[1]) || !isfinite(at[2])) return q.best;
    struct RTCRayHit ray = {
        .ray = {.org_x = at[0], .org_y = at[1], .org_z = at[2], .dir_x = (float)d.x, .dir_y = (float)d.y, .dir_z = (float)d.z},
        .hit = {.geomID = RTC_INVALID_GEOMETRY_ID},
    };
    ray.ray.tfar = ray_end(surface, &q, far);
    ray.ray.mask = UINT32_MAX;
    unsigned mode = flush_denormals();
    rtcInitIntersectContext(&q.context);
    rtcIntersect1(surface->scene, &q.context, &ray);
    restore_mode(mode);
    return q.best;
}
