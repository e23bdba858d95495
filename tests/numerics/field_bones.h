/*
 * field_bones.h -- bones of the real anatomy in metres, for the distance field's tests and times.
 */
#ifndef TESTS_FIELD_BONES_H
#define TESTS_FIELD_BONES_H

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "sinew/distance_field.h"
#include "sinew/io.h"

typedef struct bone {
    const char *file; /* in the folder of the anatomy */
    double scale;     /* metres per unit */
    double cell;      /* metres */
} bone;

static inline double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* False, with a word, where there is no such bone; ends the program where it cannot be read. */
static inline bool bone_read(const char *data, const bone *b, sn_mesh *mesh) {
    char path[1024];
    sn_error error = {0};
    snprintf(path, sizeof path, "%s/%s", data, b->file);
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        printf("no real anatomy at %s: skipped\n", path);
        return false;
    }
    fclose(file);
    if (sn_mesh_read(path, mesh, NULL, &error) != SN_OK) {
        fprintf(stderr, "%s: %s\n", path, error.text);
        exit(1);
    }
    sn_mesh_convert(mesh, b->scale, false);
    return true;
}

/* A random point within `reach` of a random point of a random triangle. */
static inline sn_vec3 point_near(const sn_mesh *mesh, double reach, uint64_t *state) {
    const sn_index *v = mesh->triangles[(sn_index)(sn_random(state) * mesh->triangle_count)].v;
    double a = sn_random(state), b = sn_random(state);
    if (a + b > 1.0) a = 1.0 - a, b = 1.0 - b;
    sn_vec3 p = mesh->positions[v[0]];
    p = sn_add_scaled(p, sn_sub(mesh->positions[v[1]], mesh->positions[v[0]]), a);
    p = sn_add_scaled(p, sn_sub(mesh->positions[v[2]], mesh->positions[v[0]]), b);
    sn_vec3 d;
    do { d = sn_v3(2.0 * sn_random(state) - 1.0, 2.0 * sn_random(state) - 1.0, 2.0 * sn_random(state) - 1.0); } while (sn_norm2(d) > 1.0);
    return sn_add_scaled(p, d, reach);
}

#endif
