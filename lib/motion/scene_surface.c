/*
 * scene_surface.c -- surfaces of a scene over time, and the points that follow them.   [R18] 4.2
 */
#include "sinew/scene_surface.h"

#include <stdlib.h>

/* ---- vertices that a host has moved ------------------------------------------------------------------------------------------------ */

static sn_vec3 sample_at(const sn_vertex_track *track, sn_index sample, sn_index vertex) {
    const float *p = track->positions + 3 * ((size_t)sample * (size_t)track->vertex_count + (size_t)vertex);
    return sn_v3((double)p[0], (double)p[1], (double)p[2]);
}

sn_vec3 sn_vertex_track_at(const sn_vertex_track *track, double time, sn_index vertex) {
    sn_index low = 0, high = track->sample_count - 1;
    if (!(time > track->times[0])) return sample_at(track, 0, vertex);
    if (time >= track->times[high]) return sample_at(track, high, vertex);
    while (high - low > 1) {
        sn_index middle = low + (high - low) / 2;
        if (track->times[middle] <= time)
            low = middle;
        else
            high = middle;
    }
    double part = (time - track->times[low]) / (track->times[high] - track->times[low]);
    return sn_lerp(sample_at(track, low, vertex), sample_at(track, high, vertex), part);
}

void sn_vertex_track_free(sn_vertex_track *track) {
    free(track->times);
    free(track->positions);
    *track = (sn_vertex_track){0};
}

/* ---- a surface --------------------------------------------------------------------------------------------------------------------- */

void sn_scene_surface_free(sn_scene_surface *surface) {
    free(surface->name);
    free(surface->uri);
    free(surface->frames);
    free(surface->joints);
    sn_envelope_free(&surface->envelope);
    sn_vertex_track_free(&surface->track);
    *surface = (sn_scene_surface){0};
}

sn_vec3 sn_scene_surface_vertex(const sn_scene_surface *surface, const sn_surface_moment *at, sn_index vertex) {
    if (surface->kind == SN_SURFACE_DRIVEN) {
        sn_vec3 there = sn_vertex_track_at(&surface->track, at->time, vertex);
        return at->share >= 1.0 ? there : sn_lerp(surface->envelope.mesh.positions[vertex], there, at->share);
    }
    const sn_influence *influence = &surface->envelope.influences[vertex];
    sn_rigid poses[SN_INFLUENCE_LIMIT];
    for (sn_index k = 0; k < influence->count; k++) {
        sn_index joint = surface->joints[influence->bones[k]];
        poses[k] = joint == SN_NONE ? sn_rigid_identity() : at->poses[joint];
    }
    return sn_envelope_vertex(&surface->envelope, vertex, poses);
}

enum { GRAIN = 1024 }; /* vertices a thread takes at once */

typedef struct positions_work {
    const sn_scene_surface *surface;
    const sn_surface_moment *at;
    sn_vec3 *positions;
} positions_work;

static void place_range(void *user, sn_index begin, sn_index end, sn_index chunk) {
    const positions_work *w = user;
    (void)chunk;
    for (sn_index v = begin; v < end; v++) w->positions[v] = sn_scene_surface_vertex(w->surface, w->at, v);
}

void sn_scene_surface_positions(const sn_scene_surface *surface, const sn_surface_moment *at, sn_pool *pool, sn_vec3 *positions) {
    positions_work work = {surface, at, positions};
    sn_parallel_for(pool, surface->envelope.mesh.vertex_count, GRAIN, place_range, &work);
}

/* ---- what follows it --------------------------------------------------------------------------------------------------------------- */

/* A triangle's tangent frame: unit axes along the first edge, across it, and along the normal. */
typedef struct tangent_frame {
    sn_vec3 origin, along, across, normal;
    bool flat; /* it has no area, and so no frame */
} tangent_frame;

static tangent_frame frame_of(const sn_vec3 p[3], const double barycentric[3]) {
    tangent_frame frame = {.normal = sn_normalize(sn_area_vector(p[0], p[1], p[2])), .along = sn_normalize(sn_sub(p[1], p[0]))};
    for (int i = 0; i < 3; i++) frame.origin = sn_add_scaled(frame.origin, p[i], barycentric[i]);
    frame.across = sn_cross(frame.normal, frame.along);
    frame.flat = !(sn_norm2(frame.normal) > 0.0);
    return frame;
}

static tangent_frame rest_frame(const sn_mesh *mesh, const sn_follower *follower) {
    const sn_index *v = mesh->triangles[follower->triangle].v;
    const sn_vec3 p[3] = {mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]};
    return frame_of(p, follower->barycentric);
}

/* The frame at that moment; a triangle without area keeps its axes of rest. */
static tangent_frame frame_at(const sn_scene_surface *surface, const sn_surface_moment *at, const sn_follower *follower) {
    const sn_index *v = surface->envelope.mesh.triangles[follower->triangle].v;
    sn_vec3 p[3];
    for (int i = 0; i < 3; i++) p[i] = sn_scene_surface_vertex(surface, at, v[i]);
    tangent_frame frame = frame_of(p, follower->barycentric);
    if (!frame.flat) return frame;
    tangent_frame rest = rest_frame(&surface->envelope.mesh, follower);
    rest.origin = frame.origin;
    return rest;
}

static sn_vec3 point_in(const tangent_frame *frame, sn_vec3 offset) {
    sn_vec3 point = sn_add_scaled(frame->origin, frame->along, offset.x);
    return sn_add_scaled(sn_add_scaled(point, frame->across, offset.y), frame->normal, offset.z);
}

/* The unit quaternion of the rotation whose columns are x, y, z, by its largest component (Shepperd 1978). */
static sn_quat quat_of_axes(sn_vec3 x, sn_vec3 y, sn_vec3 z) {
    double w2 = 1.0 + x.x + y.y + z.z, x2 = 1.0 + x.x - y.y - z.z, y2 = 1.0 - x.x + y.y - z.z, z2 = 1.0 - x.x - y.y + z.z;
    sn_quat q = {w2, y.z - z.y, z.x - x.z, x.y - y.x};
    if (x2 > w2 && x2 >= y2 && x2 >= z2)
        q = (sn_quat){y.z - z.y, x2, x.y + y.x, z.x + x.z};
    else if (y2 > w2 && y2 >= z2)
        q = (sn_quat){z.x - x.z, x.y + y.x, y2, y.z + z.y};
    else if (z2 > w2)
        q = (sn_quat){x.y - y.x, z.x + x.z, y.z + z.y, z2};
    return sn_quat_normalize(q);
}

static sn_rigid placement(const tangent_frame *frame) {
    return (sn_rigid){quat_of_axes(frame->along, frame->across, frame->normal), frame->origin};
}

sn_vec3 sn_follower_place(const sn_scene_surface *surface, const sn_surface_moment *at, const sn_follower *follower) {
    tangent_frame frame = frame_at(surface, at, follower);
    return point_in(&frame, follower->offset);
}

sn_rigid sn_follower_pose(const sn_scene_surface *surface, const sn_surface_moment *at, const sn_follower *follower) {
    tangent_frame now = frame_at(surface, at, follower), rest = rest_frame(&surface->envelope.mesh, follower);
    return sn_rigid_compose(placement(&now), sn_rigid_inverse(placement(&rest)));
}

/* ---- binding ----------------------------------------------------------------------------------------------------------------------- */

/* Triangles of a mesh that a follower may hang on, over the same vertices, and a search among them. */
typedef struct choice {
    sn_mesh mesh;
    sn_index *triangles; /* which of the whole mesh each is */
    sn_surface *search;
} choice;

static void free_choice(choice *c) {
    sn_surface_destroy(c->search);
    free(c->mesh.triangles);
    free(c->triangles);
}

/* A needle's normal is noise, above all in the floats of a host's frames: a triangle lower than this share of its longest edge is one. */
static const double LEAST_HEIGHT = 0.1;

/* Height over longest edge. */
static double shape_of(const sn_mesh *mesh, sn_index t) {
    const sn_index *v = mesh->triangles[t].v;
    const sn_vec3 a = mesh->positions[v[0]], b = mesh->positions[v[1]], c = mesh->positions[v[2]];
    double longest = fmax(sn_norm2(sn_sub(b, a)), fmax(sn_norm2(sn_sub(c, b)), sn_norm2(sn_sub(a, c))));
    return sn_norm2(sn_normalize(sn_area_vector(a, b, c))) > 0.0 ? sn_norm(sn_area_vector(a, b, c)) / longest : 0.0;
}

/* Those of a shape above `least`; without a search where there are none. */
static sn_status choose(const sn_mesh *mesh, double least, choice *out, sn_error *error) {
    out->mesh = *mesh;
    out->mesh.triangle_count = 0;
    out->mesh.triangles = SN_NEW(sn_triangle, mesh->triangle_count);
    out->triangles = SN_NEW(sn_index, mesh->triangle_count);
    if (out->mesh.triangles == NULL || out->triangles == NULL) return sn_fail_memory(error, "the triangles of a surface");
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        if (!(shape_of(mesh, t) > least)) continue;
        out->triangles[out->mesh.triangle_count] = t;
        out->mesh.triangles[out->mesh.triangle_count++] = mesh->triangles[t];
    }
    return out->mesh.triangle_count > 0 ? sn_surface_create_plain(&out->mesh, &out->search, error) : SN_OK;
}

static void bind_point(const sn_mesh *mesh, const sn_closest *nearest, sn_index triangle, sn_vec3 point, sn_follower *out) {
    *out = (sn_follower){.triangle = triangle};
    for (int i = 0; i < 3; i++) out->barycentric[i] = nearest->barycentric[i];
    tangent_frame frame = rest_frame(mesh, out);
    sn_vec3 away = sn_sub(point, frame.origin);
    out->offset = sn_v3(sn_dot(away, frame.along), sn_dot(away, frame.across), sn_dot(away, frame.normal));
}

/* The nearest triangle; a well-shaped one in its place where that is hardly farther. */
static void bind_to_best(const sn_mesh *mesh, const choice *any, const choice *good, double slack, sn_vec3 point, sn_follower *out) {
    sn_closest nearest = sn_surface_closest(any->search, point, INFINITY);
    sn_closest better = {.triangle = SN_NONE};
    if (good->search != NULL) better = sn_surface_closest(good->search, point, nearest.distance + slack);
    if (better.triangle != SN_NONE)
        bind_point(mesh, &better, good->triangles[better.triangle], point, out);
    else
        bind_point(mesh, &nearest, any->triangles[nearest.triangle], point, out);
}

sn_status sn_followers_bind(const sn_scene_surface *surface, sn_index count, const sn_vec3 *points, sn_follower *followers,
                            double *farthest, sn_error *error) {
    const sn_mesh *mesh = &surface->envelope.mesh;
    choice any = {0}, good = {0};
    double most = 0.0, slack = sn_mesh_mean_side(mesh);
    sn_status status = choose(mesh, 0.0, &any, error);
    if (status == SN_OK && any.search == NULL)
        status = sn_fail(error, SN_ERROR_INPUT, "surface \"%s\" has no triangle that has an area", surface->name);
    if (status == SN_OK) status = choose(mesh, LEAST_HEIGHT, &good, error);
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        bind_to_best(mesh, &any, &good, slack, points[i], &followers[i]);
        most = fmax(most, sn_norm(followers[i].offset));
    }
    if (farthest != NULL) *farthest = most;
    free_choice(&any);
    free_choice(&good);
    return status;
}
