/* ends.c -- where a muscle begins and ends: what a harmonic field runs between. */
#include "ends.h"

#include <stdarg.h>
#include <stdio.h>
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

const char *const sn_ends_source_names[] = {"tips", "eigenfunction", "attachments", "pins", "areas", "sites", NULL};

void ends_source(ends *e, sn_ends_source source, bool first, bool second) {
    e->choice.source = source;
    e->choice.from = sn_ends_source_names[source];
    e->choice.known[0] = first;
    e->choice.known[1] = second;
}

bool ends_known(const sn_ends_choice *choice) { return choice->source >= SN_ENDS_PINS && choice->known[0] && choice->known[1]; }

void ends_say(sn_ends_choice *choice, const char *format, ...) {
    size_t used = strlen(choice->why);
    va_list args;
    if (used > 0 && used + 2 < sizeof choice->why) {
        memcpy(choice->why + used, "; ", 3);
        used += 2;
    }
    va_start(args, format);
    vsnprintf(choice->why + used, sizeof choice->why - used, format, args);
    va_end(args);
}

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
    ends_source(out, SN_ENDS_SITES, true, true);
    free(from.vertices[0]);
    free(from.vertices[1]);
    return status;
}

/* ---- tips ----------------------------------------------------------------------------------------------------------------- */

sn_status ends_from_tips(const ends_surface *surface, ends *out, sn_error *error) {
    sn_index first = surface->shape->end[0], last = surface->shape->end[1];
    const seeds from = {.count = {1, 1}, .vertices = {&first, &last}};
    ends_source(out, surface->shape->eigen ? SN_ENDS_EIGEN : SN_ENDS_TIPS, false, false);
    return grow_patches(surface, &from, out, error);
}
