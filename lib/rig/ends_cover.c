/* ends_cover.c -- how much of a muscle its two ends leave out: what lies beyond them, and where no way leads on between them. */
#include "ends.h"

#include <stdlib.h>

/* Where the field rises along no edge by this share of what it rises on average between the ends, no way leads on. */
#define FLAT_SLOPE 0.1
#define BEYOND_MARGIN 0.05 /* farther from the other end than all of this one, by this share of L */

typedef struct cover_work {
    const ends_surface *surface;
    const ends *ends;
    double *area;        /* (vertex_count) a third of the triangles around it */
    double *field;       /* (vertex_count) harmonic between the ends */
    double *distance[2]; /* (vertex_count) along the surface from each end */
    bool *held;          /* (vertex_count) of either end */
    sn_index *list;      /* (vertex_count) scratch */
    double most[2];      /* of each end, the greatest distance from the other */
} cover_work;

static bool open_work(cover_work *w) {
    sn_index n = w->surface->mesh->vertex_count;
    w->area = SN_NEW(double, n);
    w->field = SN_NEW(double, n);
    w->distance[0] = SN_NEW(double, n);
    w->distance[1] = SN_NEW(double, n);
    w->held = SN_NEW(bool, n);
    w->list = SN_NEW(sn_index, n);
    return w->area && w->field && w->distance[0] && w->distance[1] && w->held && w->list;
}

static void close_work(cover_work *w) {
    free(w->area);
    free(w->field);
    free(w->distance[0]);
    free(w->distance[1]);
    free(w->held);
    free(w->list);
}

static sn_status measure_from_ends(cover_work *w, sn_error *error) {
    const ends *e = w->ends;
    const sn_mesh *m = w->surface->mesh;
    sn_status status = SN_OK;
    for (int k = 0; k < 2 && !status; k++) {
        sn_index count = 0;
        for (sn_index i = 0; i < e->count; i++)
            if ((e->values[i] != 0.0) == k) w->list[count++] = e->vertices[i];
        status = sn_geodesic_distance(m, w->surface->topology, count, w->list, w->distance[k], error);
    }
    const sn_fixed_values fixed = {e->count, e->vertices, e->values};
    return status ? status : sn_harmonic_field(m, w->surface->topology, &fixed, w->field, error);
}

static void place_ends(cover_work *w) {
    for (sn_index i = 0; i < w->ends->count; i++) {
        sn_index v = w->ends->vertices[i];
        int end = w->ends->values[i] != 0.0;
        double d = w->distance[1 - end][v];
        w->held[v] = true;
        if (isfinite(d)) w->most[end] = fmax(w->most[end], d);
    }
}

static bool is_flat(const cover_work *w, sn_index v) {
    const sn_topology *t = w->surface->topology;
    const sn_vec3 *p = w->surface->mesh->positions;
    double apart = fmax(w->most[0], w->most[1]);
    for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++) {
        sn_index n = t->neighbours[k];
        if (fabs(w->field[n] - w->field[v]) * apart >= FLAT_SLOPE * sn_distance(p[n], p[v])) return false;
    }
    return true;
}

static bool is_beyond(const cover_work *w, sn_index v) {
    int end = w->distance[1][v] < w->distance[0][v];
    return w->distance[1 - end][v] > w->most[end] + BEYOND_MARGIN * w->surface->shape->length;
}

static ends_cover add_up(const cover_work *w) {
    ends_cover c = {0.0, 0.0};
    double all = 0.0;
    for (sn_index v = 0; v < w->surface->mesh->vertex_count; v++) {
        if (!isfinite(w->distance[0][v]) || !isfinite(w->distance[1][v])) continue; /* of another component */
        all += w->area[v];
        if (w->held[v]) continue;
        c.flat += is_flat(w, v) ? w->area[v] : 0.0;
        c.beyond += is_beyond(w, v) ? w->area[v] : 0.0;
    }
    double scale = all > 0.0 ? 1.0 / all : 0.0;
    return (ends_cover){c.flat * scale, c.beyond * scale};
}

sn_status ends_measure_cover(const ends_surface *surface, const ends *e, ends_cover *out, sn_error *error) {
    cover_work w = {.surface = surface, .ends = e};
    sn_status status = open_work(&w) ? measure_from_ends(&w, error) : sn_fail_memory(error, "the ends of the muscle");
    if (!status) {
        sn_mesh_vertex_areas(surface->mesh, w.area);
        place_ends(&w);
        *out = add_up(&w);
    }
    close_work(&w);
    return status;
}
