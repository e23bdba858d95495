/*
 * intersections.c -- pairs of triangles that cross: counted, and removed on request.
 */
#include "sinew/geom.h"

#include <stdlib.h>
#include <string.h>

#include "bridge.h"
#include "child.h"
#include "edit.h"

/* The mesh as exact predicates see it: scaled by a power of two, so that no coordinate is rounded, and with one vertex for each place. Else
 * the count would change with the box, and with cuts and joins that move nothing. */
static sn_status to_exact(const sn_mesh *mesh, sn_bridge_mesh *out, sn_error *error) {
    size_t vertices = (size_t)mesh->vertex_count, triangles = (size_t)mesh->triangle_count;
    sn_status status = sn_mesh_validate(mesh, error);
    if (status != SN_OK) return status;
    sn_index *place = SN_NEW(sn_index, vertices);
    *out = (sn_bridge_mesh){
        mesh->vertex_count, mesh->triangle_count, SN_NEW(double, 3 * vertices), SN_NEW(sn_index, 3 * triangles), NULL, NULL};
    if (place == NULL || out->points == NULL || out->triangles == NULL) status = sn_fail_memory(error, "counting self-intersections");
    if (status == SN_OK) status = sn_find_representatives(mesh, 0.0, place, error);
    double greatest = 0.0;
    for (size_t i = 0; status == SN_OK && i < vertices; i++) {
        sn_vec3 p = mesh->positions[i];
        greatest = fmax(greatest, fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))));
    }
    int exponent = greatest > 0.0 ? -ilogb(greatest) : 0;
    for (size_t i = 0; status == SN_OK && i < vertices; i++) {
        sn_vec3 p = mesh->positions[i];
        memcpy(out->points + 3 * i, (double[]){ldexp(p.x, exponent), ldexp(p.y, exponent), ldexp(p.z, exponent)}, 3 * sizeof(double));
    }
    for (size_t i = 0; status == SN_OK && i < 3 * triangles; i++) out->triangles[i] = place[mesh->triangles[i / 3].v[i % 3]];
    free(place);
    return status;
}

sn_status sn_find_self_intersections(const sn_mesh *mesh, int64_t most_tests, const bool *made, bool *crosses, sn_index *pairs,
                                     sn_error *error) {
    *pairs = 0;
    sn_bridge_mesh in = {0};
    sn_status status = to_exact(mesh, &in, error);
    if (status == SN_OK) status = sn_bridge_find_intersections(&in, most_tests, made, crosses, pairs, error);
    sn_bridge_free(&in);
    return status;
}

sn_status sn_count_self_intersections(const sn_mesh *mesh, sn_index *pairs, sn_error *error) {
    return sn_find_self_intersections(mesh, 0, NULL, NULL, pairs, error);
}

/* ---- removal, in a child ------------------------------------------------------------------------------------------------ */

/* What the library needs for a triangle, generously, and to start with. */
#define BYTES_EACH 20000
#define BYTES_FIRST ((size_t)1 << 30)
/* The answer has about as many triangles as the question. */
#define MOST_GROWTH 8

/* The child's answer: the counts, the points, the corners. */
static bool remove_and_tell(void *user, int out) {
    const sn_bridge_mesh *in = user;
    sn_bridge_mesh done = {0};
    sn_error error = {0};
    if (sn_bridge_remove_intersections(in, &done, &error) != SN_OK) return false;
    sn_index counts[2] = {done.vertex_count, done.triangle_count};
    return sn_child_write(out, counts, sizeof counts) && sn_child_write(out, done.points, (size_t)counts[0] * 3 * sizeof *done.points) &&
           sn_child_write(out, done.triangles, (size_t)counts[1] * 3 * sizeof *done.triangles);
}

/* What a child says is looked at like a file: every count and size. */
static sn_status read_told(const char *answer, size_t size, sn_bridge_mesh *out, sn_error *error) {
    sn_index counts[2] = {0, 0};
    if (size >= sizeof counts) memcpy(counts, answer, sizeof counts);
    size_t vertices = counts[0] > 0 ? (size_t)counts[0] : 0, triangles = counts[1] > 0 ? (size_t)counts[1] : 0;
    size_t points = vertices * 3 * sizeof(double), corners = triangles * 3 * sizeof(sn_index);
    if (vertices == 0 || triangles == 0 || size != sizeof counts + points + corners) {
        return sn_fail(error, SN_ERROR_INTERNAL, "the child process gave no surface");
    }
    *out = (sn_bridge_mesh){
        counts[0], counts[1], sn_alloc(points, 1), sn_alloc(corners, 1), SN_NEW(sn_index, vertices), SN_NEW(sn_index, triangles)};
    if (!out->points || !out->triangles || !out->vertex_origin || !out->triangle_origin)
        return sn_fail_memory(error, "removing self-intersections");
    memcpy(out->points, answer + sizeof counts, points);
    memcpy(out->triangles, answer + sizeof counts + points, corners);
    memset(out->vertex_origin, 0xff, vertices * sizeof(sn_index)); /* SN_NONE */
    memset(out->triangle_origin, 0xff, triangles * sizeof(sn_index));
    return SN_OK;
}

static sn_status remove_in_child(const sn_mesh *mesh, double seconds, sn_mesh *after, bool *ended_early, sn_error *error) {
    sn_bridge_mesh in = {0}, out = {0};
    sn_bridge_frame where;
    sn_child_answer answer = {0};
    size_t count = (size_t)mesh->triangle_count;
    sn_child_limits limits = {seconds, BYTES_FIRST + count * BYTES_EACH, 4096 + MOST_GROWTH * count * sizeof(sn_bridge_mesh)};
    sn_status status = sn_to_bridge(mesh, &in, &where, error);
    if (status == SN_OK) status = sn_bridge_check_indices(mesh, error);
    if (status == SN_OK) status = sn_child_run(remove_and_tell, &in, &limits, &answer, error);
    if (status == SN_OK) status = read_told(answer.bytes, answer.size, &out, error);
    if (status == SN_OK) status = sn_from_bridge(mesh, &in, &out, where, after, error);
    *ended_early = answer.ended_early;
    free(answer.bytes);
    sn_bridge_free(&in);
    sn_bridge_free(&out);
    return status;
}

/* A result that is worth having: as whole as before, with fewer crossings. */
static sn_status judge(const sn_mesh *after, sn_index before, sn_index *now, bool *better, sn_error *error) {
    sn_mesh_report found = {0};
    *better = false;
    sn_status status = sn_mesh_inspect(after, &found, error);
    if (status != SN_OK || !found.closed || !found.manifold || !found.oriented) return status;
    status = sn_count_self_intersections(after, now, error);
    *better = status == SN_OK && *now < before;
    return status;
}

sn_status sn_remove_self_intersections(sn_mesh *mesh, double seconds, sn_index *left, bool *ended_early, sn_error *error) {
    *ended_early = false;
    sn_mesh_report found;
    sn_mesh after = {0};
    sn_index now = 0;
    bool better = false;
    sn_status status = sn_count_self_intersections(mesh, left, error);
    if (status == SN_OK) status = sn_mesh_inspect(mesh, &found, error);
    if (status != SN_OK || *left == 0 || !found.closed || !found.manifold || !found.oriented) return status;
    sn_error why = {0};
    if (remove_in_child(mesh, seconds, &after, ended_early, &why) == SN_OK) status = judge(&after, *left, &now, &better, error);
    if (status == SN_OK && better) status = sn_carry_attributes(mesh, &after, error);
    if (status == SN_OK && better) {
        sn_mesh_replace(mesh, &after);
        *left = now;
    }
    sn_mesh_free(&after);
    return status;
}
