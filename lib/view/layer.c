/* layer.c -- the meshes of a view as one searchable surface, with normals, paint and ambient occlusion at its vertices. */
#include "render.h"

#include <stdlib.h>

void layer_free(layer *l) {
    sn_surface_destroy(l->surface);
    sn_mesh_free(&l->mesh);
    free(l->normals);
    free(l->open);
    free(l->paint);
    free(l->part);
    free(l->parts);
    free(l->paints);
    free(l->tints);
    *l = (layer){0};
}

static bool belongs(const sn_view_mesh *mesh, bool solid) { return mesh->triangle_count > 0 && (mesh->opacity >= 1.0) == solid; }

static sn_status layer_alloc(layer *l, const sn_view *view, bool solid, sn_error *error) {
    int64_t vertices = 0, triangles = 0, parts = 0, paints = 0;
    bool graded = false;
    for (size_t i = 0; i < view->mesh_count; i++) {
        const sn_view_mesh *mesh = &view->meshes[i];
        if (!belongs(mesh, solid)) continue;
        vertices += mesh->vertex_count;
        triangles += mesh->triangle_count;
        paints += mesh->paint_count;
        graded = graded || mesh->colors;
        parts++;
    }
    if (vertices > SN_INDEX_MAX || triangles > SN_INDEX_MAX / 3)
        return sn_fail(error, SN_ERROR_MEMORY, "the picture holds more triangles than can be counted");
    sn_status status = sn_mesh_alloc(&l->mesh, (sn_index)vertices, (sn_index)triangles, error);
    if (status) return status;
    l->normals = SN_NEW(sn_vec3, vertices);
    l->open = SN_NEW(float, vertices);
    l->paint = SN_NEW(sn_index, vertices);
    l->part = SN_NEW(sn_index, triangles);
    l->parts = SN_NEW(layer_part, parts);
    l->paints = SN_NEW(tint, paints);
    if (graded && !(l->tints = SN_NEW(tint, vertices))) return sn_fail_memory(error, "the picture's colours");
    if (!l->normals || !l->open || !l->paint || !l->part || !l->parts || !l->paints) return sn_fail_memory(error, "the picture's meshes");
    return SN_OK;
}

/* Copy one mesh behind what is there; vertex and triangle are where it starts. */
static void append_mesh(layer *l, const sn_view_mesh *mesh, const frame *f, sn_index id, sn_index vertex, sn_index triangle) {
    for (sn_index i = 0; i < mesh->vertex_count; i++) {
        l->mesh.positions[vertex + i] = frame_apply(f, mesh->positions[i]);
        bool painted = mesh->paint && mesh->paint[i] != SN_NONE;
        l->paint[vertex + i] = painted ? (sn_index)l->paint_count + mesh->paint[i] : SN_NONE;
        l->open[vertex + i] = 1.0f;
        if (mesh->colors) l->tints[vertex + i] = tint_from(mesh->colors[i]);
    }
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        for (int c = 0; c < 3; c++) l->mesh.triangles[triangle + t].v[c] = vertex + mesh->triangles[t].v[c];
        l->part[triangle + t] = (sn_index)l->part_count;
    }
    l->parts[l->part_count++] =
        (layer_part){tint_from(mesh->color), (float)mesh->opacity, (float)mesh->gloss, mesh->wire, mesh->colors != NULL, id};
    for (sn_index p = 0; p < mesh->paint_count; p++) l->paints[l->paint_count++] = tint_from(mesh->paints[p]);
}

sn_status layer_build(layer *l, const sn_view *view, const frame *f, bool solid, sn_error *error) {
    *l = (layer){0};
    sn_status status = layer_alloc(l, view, solid, error);
    if (status || l->mesh.triangle_count == 0) return status;
    sn_index vertex = 0, triangle = 0;
    for (size_t i = 0; i < view->mesh_count; i++) {
        const sn_view_mesh *mesh = &view->meshes[i];
        if (!belongs(mesh, solid)) continue;
        append_mesh(l, mesh, f, (sn_index)i, vertex, triangle);
        vertex += mesh->vertex_count;
        triangle += mesh->triangle_count;
    }
    l->box = sn_mesh_box(&l->mesh);
    if (!isfinite(sn_box_diagonal(l->box)))
        return sn_fail(error, SN_ERROR_INPUT, "the subject is too large to draw: its coordinates overflow");
    sn_mesh_vertex_normals(&l->mesh, l->normals);
    return sn_surface_create_plain(&l->mesh, &l->surface, error);
}

/* ---- ambient occlusion ---------------------------------------------------------------------------------------------------- */

enum { DIRECTIONS_MAX = 96 };

typedef struct occlusion {
    layer *l;
    const layer *other;
    int count;
    sn_vec3 directions[DIRECTIONS_MAX];
    double reach, bias;
} occlusion;

/* Evenly spread directions, the same for all vertices: neighbours get like errors, so that there is no grain. */
static void spread_directions(occlusion *o) {
    const double golden = SN_PI * (3.0 - sqrt(5.0));
    for (int i = 0; i < o->count; i++) {
        double z = 1.0 - (2.0 * i + 1.0) / o->count, r = sqrt(1.0 - z * z);
        o->directions[i] = sn_v3(r * sn_cos(golden * i), r * sn_sin(golden * i), z);
    }
}

static double blocked(const layer *l, sn_vec3 origin, sn_vec3 direction, double reach) {
    if (!l || !l->surface) return 0.0;
    sn_ray_hit hit = sn_surface_ray(l->surface, origin, direction, 0.0, reach);
    return hit.triangle == SN_NONE ? 0.0 : 1.0 - hit.distance / reach;
}

static void occlude_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    (void)chunk;
    occlusion *o = user;
    for (sn_index i = begin; i < end; i++) {
        sn_vec3 n = o->l->normals[i], origin = sn_add_scaled(o->l->mesh.positions[i], n, o->bias);
        double all = 0.0, lost = 0.0;
        for (int d = 0; d < o->count; d++) {
            double cosine = sn_dot(n, o->directions[d]);
            if (!(cosine > 0.05)) continue;
            all += cosine;
            lost += cosine * fmax(blocked(o->l, origin, o->directions[d], o->reach), blocked(o->other, origin, o->directions[d], o->reach));
        }
        o->l->open[i] = all > 0.0 ? (float)(1.0 - lost / all) : 1.0f;
    }
}

sn_status layer_occlude(layer *l, const layer *other, sn_pool *pool, sn_error *error) {
    if (!l->surface) return SN_OK;
    const double ray_budget = 3e6; /* keeps a whole body within seconds */
    occlusion *o = SN_NEW(occlusion, 1);
    if (!o) return sn_fail_memory(error, "ambient occlusion");
    double size = sn_box_diagonal(l->box);
    *o = (occlusion){.l = l, .other = other, .reach = 0.3 * size, .bias = 1e-4 * size};
    o->count = (int)fmin(fmax(ray_budget / l->mesh.vertex_count, 24.0), DIRECTIONS_MAX);
    spread_directions(o);
    sn_parallel_for(pool, l->mesh.vertex_count, 256, occlude_range, o);
    free(o);
    return SN_OK;
}

/* ---- rays ------------------------------------------------------------------------------------------------------------------- */

static double line_distance(double x, double y, sn_vec3 a, sn_vec3 b) {
    double dx = b.x - a.x, dy = b.y - a.y, length = sn_length2(dx, dy);
    return length > 0.0 ? fabs((x - a.x) * dy - (y - a.y) * dx) / length : sn_length2(x - a.x, y - a.y);
}

static bool on_wire(const layer *l, const sn_index *v, double x, double y) {
    const double half_width = 0.35; /* pixels */
    const sn_vec3 *p = l->mesh.positions;
    for (int c = 0; c < 3; c++)
        if (line_distance(x, y, p[v[c]], p[v[(c + 1) % 3]]) < half_width) return true;
    return false;
}

/* The paint with most weight among the three corners. */
static sn_index paint_at(const layer *l, const sn_index *v, const double weight[3]) {
    sn_index best = SN_NONE;
    double most = -1.0;
    for (int c = 0; c < 3; c++) {
        double sum = 0.0;
        for (int d = 0; d < 3; d++) sum += l->paint[v[d]] == l->paint[v[c]] ? weight[d] : 0.0;
        if (sum > most) {
            most = sum;
            best = l->paint[v[c]];
        }
    }
    return best;
}

/* The mean of the corners' own colours. */
static tint graded_at(const layer *l, const sn_index *v, const double weight[3]) {
    tint sum = {0, 0, 0};
    for (int c = 0; c < 3; c++) {
        tint corner = tint_scale(l->tints[v[c]], (float)weight[c]);
        sum = (tint){sum.r + corner.r, sum.g + corner.g, sum.b + corner.b};
    }
    return sum;
}

bool layer_cast(const layer *l, double x, double y, double near, double far, layer_hit *hit) {
    if (!l->surface || x < l->box.low.x || x > l->box.high.x || y < l->box.low.y || y > l->box.high.y) return false;
    double start = fmin(near, l->box.high.z + 1.0), reach = start - fmax(far, l->box.low.z - 1.0);
    if (!(reach > 0.0)) return false;
    sn_ray_hit ray = sn_surface_ray(l->surface, sn_v3(x, y, start), sn_v3(0, 0, -1), 0.0, reach);
    if (ray.triangle == SN_NONE) return false;
    const sn_index *v = l->mesh.triangles[ray.triangle].v;
    const sn_vec3 *p = l->mesh.positions;
    const double weight[3] = {1.0 - ray.u - ray.v, ray.u, ray.v};
    sn_vec3 flat = sn_normalize(sn_area_vector(p[v[0]], p[v[1]], p[v[2]])), smooth = {0, 0, 0};
    float open = 0.0f;
    for (int c = 0; c < 3; c++) {
        smooth = sn_add_scaled(smooth, l->normals[v[c]], weight[c]);
        open += (float)weight[c] * l->open[v[c]];
    }
    smooth = sn_normalize(smooth);
    if (sn_dot(smooth, flat) < 0.2) smooth = flat; /* flipped neighbours, creases */
    const layer_part *part = &l->parts[l->part[ray.triangle]];
    sn_index paint = paint_at(l, v, weight);
    bool behind = flat.z < 0.0;
    *hit = (layer_hit){.z = (float)(start - ray.distance),
                       .albedo = part->graded       ? graded_at(l, v, weight)
                                 : paint == SN_NONE ? part->color
                                                    : l->paints[paint],
                       .open = open,
                       .gloss = part->gloss,
                       .opacity = part->opacity,
                       .behind = behind,
                       .painted = part->graded || paint != SN_NONE,
                       .id = part->id};
    hit->normal = behind ? sn_neg(smooth) : smooth;
    if (behind) hit->open = 0.8f;
    hit->wired = part->wire && on_wire(l, v, x, y);
    if (hit->wired) hit->albedo = tint_scale(hit->albedo, 0.35f);
    return true;
}
