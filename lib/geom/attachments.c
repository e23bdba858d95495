/*
 * attachments.c -- how well bones grip a muscle: in how many patches, and how much of the end they are at.
 */
#include "sinew/muscle.h"

#include <stdlib.h>
#include <string.h>

/* The surface around an attachment counts as its end up to this share of the muscle's length from the attachment's middle. */
static const double END_REACH = 0.1;

typedef struct surface {
    const sn_mesh *mesh;
    sn_topology topology;
    double *area;    /* (vertices) a third of the triangles at it */
    double reach;    /* of an end, document units */
    sn_index *seen;  /* (vertices) the stamp of the last walk that came here; 0 = none */
    sn_index *stack; /* (vertices) */
    sn_index stamp;
} surface;

static void weigh_vertices(surface *s) {
    const sn_vec3 *p = s->mesh->positions;
    for (sn_index t = 0; t < s->mesh->triangle_count; t++) {
        const sn_index *v = s->mesh->triangles[t].v;
        double third = sn_norm(sn_area_vector(p[v[0]], p[v[1]], p[v[2]])) / 6.0;
        for (int i = 0; i < 3; i++) s->area[v[i]] += third;
    }
}

/* Of the vertices on the surface the one farthest from a point. */
static sn_vec3 farthest(const surface *s, sn_vec3 from) {
    sn_vec3 best = from;
    double most = 0.0;
    for (sn_index v = 0; v < s->mesh->vertex_count; v++) {
        double distance = s->area[v] > 0.0 ? sn_distance(s->mesh->positions[v], from) : 0.0;
        if (distance > most) most = distance, best = s->mesh->positions[v];
    }
    return best;
}

static sn_status open_surface(const sn_mesh *mesh, surface *s, sn_error *error) {
    *s = (surface){.mesh = mesh};
    s->area = SN_NEW(double, mesh->vertex_count);
    s->seen = SN_NEW(sn_index, mesh->vertex_count);
    s->stack = SN_NEW(sn_index, mesh->vertex_count);
    if (s->area == NULL || s->seen == NULL || s->stack == NULL) return sn_fail_memory(error, "judging attachments");
    sn_status status = sn_topology_build(mesh, &s->topology, error);
    if (status != SN_OK) return status;
    weigh_vertices(s);
    sn_vec3 tip = farthest(s, mesh->positions[0]);
    s->reach = END_REACH * sn_distance(tip, farthest(s, tip));
    return SN_OK;
}

static void close_surface(surface *s) {
    sn_topology_free(&s->topology);
    free(s->area);
    free(s->seen);
    free(s->stack);
}

/* Patches of a set of vertices: marked with `member` in seen, they are walked over and marked with `member` + 1. */
static void count_patches(surface *s, const sn_attachment *a, sn_grip *grip) {
    const sn_topology *t = &s->topology;
    sn_index member = s->stamp + 1, walked = s->stamp += 2;
    for (sn_index i = 0; i < a->count; i++) s->seen[a->vertices[i]] = member;
    for (sn_index i = 0; i < a->count; i++) {
        sn_index height = 0, size = 0;
        if (s->seen[a->vertices[i]] == walked) continue;
        s->seen[a->vertices[i]] = walked;
        for (s->stack[height++] = a->vertices[i]; height > 0; size++) {
            sn_index v = s->stack[--height];
            for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++) {
                sn_index next = t->neighbours[k];
                if (s->seen[next] != member) continue;
                s->seen[next] = walked;
                s->stack[height++] = next;
            }
        }
        grip->patches++;
        if (size > grip->largest) grip->largest = size;
    }
}

static sn_vec3 middle(const surface *s, const sn_attachment *a, double area) {
    sn_vec3 sum = sn_v3(0, 0, 0);
    for (sn_index i = 0; i < a->count; i++) sum = sn_add_scaled(sum, s->mesh->positions[a->vertices[i]], s->area[a->vertices[i]] / area);
    return sum;
}

/* Area of what the attachment holds and of all that is joined to it over vertices within reach of its middle. */
static double area_of_end(surface *s, const sn_attachment *a, sn_vec3 centre) {
    const sn_topology *t = &s->topology;
    sn_index height = 0, stamp = ++s->stamp;
    double area = 0.0;
    for (sn_index i = 0; i < a->count; i++) s->seen[s->stack[height++] = a->vertices[i]] = stamp;
    while (height > 0) {
        sn_index v = s->stack[--height];
        area += s->area[v];
        for (sn_index k = t->vertex_start[v]; k < t->vertex_start[v + 1]; k++) {
            sn_index next = t->neighbours[k];
            if (s->seen[next] == stamp || sn_distance(s->mesh->positions[next], centre) > s->reach) continue;
            s->seen[next] = stamp;
            s->stack[height++] = next;
        }
    }
    return area;
}

static void judge(surface *s, const sn_attachment *a, sn_grip *grip) {
    double area = 0.0;
    *grip = (sn_grip){.share = NAN};
    for (sn_index i = 0; i < a->count; i++) area += s->area[a->vertices[i]];
    count_patches(s, a, grip);
    if (area > 0.0) grip->share = area / area_of_end(s, a, middle(s, a, area));
}

sn_status sn_muscle_grips(const sn_muscle *muscle, sn_grip *grips, sn_error *error) {
    surface s;
    sn_status status = open_surface(&muscle->mesh, &s, error);
    for (sn_index i = 0; status == SN_OK && i < muscle->attachment_count; i++) judge(&s, &muscle->attachments[i], &grips[i]);
    close_surface(&s);
    return status;
}

sn_grip_quality sn_grip_judge(const sn_attachment *attachment, const sn_grip *grip) {
    enum { FEW_PATCHES = 4, SMALL_PATCH = 6 };
    if (attachment->count == 0) return SN_GRIP_GOOD; /* nothing is held, and nothing is asked */
    if (!(grip->share >= 0.01)) return SN_GRIP_SLIGHT;
    bool scattered = grip->patches >= FEW_PATCHES && 2 * grip->largest <= attachment->count;
    return scattered && attachment->count < SMALL_PATCH * grip->patches ? SN_GRIP_SPECKLED : SN_GRIP_GOOD;
}

const char *sn_muscle_only_bone(const sn_muscle *muscle) {
    const char *only = NULL;
    for (sn_index i = 0; i < muscle->attachment_count; i++) {
        const sn_attachment *a = &muscle->attachments[i];
        if (a->count == 0) continue;
        if (only != NULL && strcmp(only, a->bone) != 0) return NULL;
        only = a->bone;
    }
    return only;
}
