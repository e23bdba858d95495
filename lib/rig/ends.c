/* ends.c -- where a muscle begins and ends: what a harmonic field runs between. */
#include "ends.h"

#include <stdlib.h>
#include <string.h>

#define PATCH_SHARE 0.05 /* patches around sites and tips, as a share of L */
#define SITE_REACH 0.10  /* a site may lie this share of L off the surface */

sn_status ends_alloc(sn_index vertex_count, ends *out, sn_error *error) {
    *out = (ends){.vertices = SN_NEW(sn_index, vertex_count), .values = SN_NEW(double, vertex_count)};
    return out->vertices && out->values ? SN_OK : sn_fail_memory(error, "the ends of the muscle");
}

void ends_free(ends *e) {
    free(e->vertices);
    free(e->values);
    *e = (ends){0};
}

const char *const sn_ends_source_names[] = {"tips", "eigenfunction", "attachments", "sites", NULL};

static void ends_add(ends *e, sn_index vertex, double value) {
    e->vertices[e->count] = vertex;
    e->values[e->count++] = value;
}

/* What the patches of both ends grow from. */
typedef struct seeds {
    sn_index count[2];
    sn_index *vertices[2]; /* (count) of each end */
} seeds;

/* Around each end's seeds all vertices within 5 % of L; what is near to both belongs to the nearer. */
static sn_status grow_patches(const ends_surface *surface, const seeds *from, ends *out, sn_error *error) {
    const sn_mesh *mesh = surface->mesh;
    double *distance[2] = {SN_NEW(double, mesh->vertex_count), SN_NEW(double, mesh->vertex_count)};
    sn_status status = distance[0] && distance[1] ? SN_OK : sn_fail_memory(error, "the distances from the muscle's ends");
    for (int end = 0; end < 2 && !status; end++)
        status = sn_geodesic_distance(mesh, surface->topology, from->count[end], from->vertices[end], distance[end], error);
    out->count = 0;
    for (sn_index v = 0; !status && v < mesh->vertex_count; v++) {
        int end = distance[1][v] < distance[0][v];
        if (distance[end][v] <= PATCH_SHARE * surface->shape->length) ends_add(out, v, end);
    }
    free(distance[0]);
    free(distance[1]);
    return status;
}

/* ---- sites -------------------------------------------------------------------------------------------------------------- */

static sn_index nearest_vertex(const sn_mesh *mesh, const sn_topology *topology, sn_vec3 point) {
    sn_index best = SN_NONE;
    double least = INFINITY;
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        double d = sn_norm2(sn_sub(mesh->positions[v], point));
        if (!(d < least) || topology->corner_start[v] == topology->corner_start[v + 1]) continue;
        best = v;
        least = d;
    }
    return best;
}

static sn_status find_seeds(const ends_surface *surface, sn_index site_count, const sn_end_site *sites, seeds *out, sn_error *error) {
    double length = surface->shape->length;
    for (sn_index i = 0; i < site_count; i++) {
        sn_index v = nearest_vertex(surface->mesh, surface->topology, sites[i].point);
        double off = v == SN_NONE ? INFINITY : sn_distance(surface->mesh->positions[v], sites[i].point);
        if (!(off <= SITE_REACH * length)) {
            sn_fail(
                error, SN_ERROR_INPUT,
                "site %d is %.3g off the surface, more than a tenth of the muscle's length (%.3g); give sites of this muscle, in its unit",
                (int)i + 1, off, length);
            if (error) error->element = i;
            return SN_ERROR_INPUT;
        }
        int end = sites[i].end != 0;
        out->vertices[end][out->count[end]++] = v;
    }
    for (int end = 0; end < 2; end++)
        if (out->count[end] == 0)
            return sn_fail(error, SN_ERROR_INPUT, "no site is given for the %s; a muscle needs sites at both of its ends",
                           end == 0 ? "origin" : "insertion");
    return SN_OK;
}

static bool has_both(const ends *e) {
    double sum = 0.0;
    for (sn_index i = 0; i < e->count; i++) sum += e->values[i];
    return sum > 0.0 && sum < (double)e->count;
}

sn_status ends_from_sites(const ends_surface *surface, sn_index count, const sn_end_site *sites, ends *out, sn_error *error) {
    seeds from = {.vertices = {SN_NEW(sn_index, count), SN_NEW(sn_index, count)}};
    sn_status status = from.vertices[0] && from.vertices[1] ? SN_OK : sn_fail_memory(error, "the sites of the muscle");
    if (!status) status = find_seeds(surface, count, sites, &from, error);
    if (!status) status = grow_patches(surface, &from, out, error);
    if (!status && !has_both(out))
        status =
            sn_fail(error, SN_ERROR_INPUT, "the sites of origin and insertion lie on the same vertices; give sites that are farther apart");
    out->source = SN_ENDS_SITES;
    free(from.vertices[0]);
    free(from.vertices[1]);
    return status;
}

/* ---- attachments -------------------------------------------------------------------------------------------------------- */

static bool counts(const sn_attachment *a, bool areas_only) {
    return a->count > 0 && (!areas_only || (a->method && strcmp(a->method, "area") == 0));
}

static sn_vec3 attachment_mean(const sn_muscle *muscle, const sn_attachment *a) {
    sn_vec3 sum = {0, 0, 0};
    for (sn_index i = 0; i < a->count; i++) sum = sn_add(sum, muscle->mesh.positions[a->vertices[i]]);
    return sn_scale(sum, 1.0 / (double)a->count);
}

static bool farthest_attachments(const sn_muscle *muscle, bool areas_only, sn_index pair[2]) {
    double best = 0.0;
    for (sn_index i = 0; i < muscle->attachment_count; i++)
        for (sn_index j = i + 1; j < muscle->attachment_count; j++) {
            const sn_attachment *a = &muscle->attachments[i], *b = &muscle->attachments[j];
            if (!counts(a, areas_only) || !counts(b, areas_only)) continue;
            double apart = sn_distance(attachment_mean(muscle, a), attachment_mean(muscle, b));
            if (!(apart > best)) continue;
            best = apart;
            pair[0] = i;
            pair[1] = j;
        }
    return best > 0.0;
}

bool ends_from_attachments(const sn_muscle *muscle, bool areas_only, ends *out) {
    sn_index pair[2];
    if (!farthest_attachments(muscle, areas_only, pair)) return false;
    out->count = 0;
    out->source = SN_ENDS_ATTACHMENTS;
    for (int side = 0; side < 2; side++) {
        const sn_attachment *a = &muscle->attachments[pair[side]];
        for (sn_index i = 0; i < a->count; i++) ends_add(out, a->vertices[i], side);
    }
    return true;
}

/* ---- tips ----------------------------------------------------------------------------------------------------------------- */

sn_status ends_from_tips(const ends_surface *surface, ends *out, sn_error *error) {
    sn_index first = surface->shape->end[0], last = surface->shape->end[1];
    const seeds from = {.count = {1, 1}, .vertices = {&first, &last}};
    out->source = surface->shape->eigen ? SN_ENDS_EIGEN : SN_ENDS_TIPS;
    return grow_patches(surface, &from, out, error);
}
