/*
 * voxels.c -- the voxels of bones as a mesh to look at, and what they take.   [K21] 3.2, figure 3
 *
 *   voxels BONE N|total:N OUT.obj
 *
 * N cells along each axis of the bone's box, or about N in all, as simulate --voxels has them. OUT.obj has the faces between cells of the
 * bone (those that its surface runs through, and those that these enclose) and others. Printed is a line with tabs: cells along x, y and z;
 * cells in all; those that the surface runs through; those inside; faces; KB with a byte a cell, as the paper counts; KB with a bit a cell.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sinew/io.h"
#include "sinew/voxels.h"

/* The corners of a cell's six faces, counter-clockwise seen from outside; the axis and side that each looks to. */
static const struct face {
    int step[3];
    int corner[4][3];
} FACES[6] = {
    {{-1, 0, 0}, {{0, 0, 0}, {0, 0, 1}, {0, 1, 1}, {0, 1, 0}}}, {{1, 0, 0}, {{1, 0, 0}, {1, 1, 0}, {1, 1, 1}, {1, 0, 1}}},
    {{0, -1, 0}, {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}}}, {{0, 1, 0}, {{0, 1, 0}, {0, 1, 1}, {1, 1, 1}, {1, 1, 0}}},
    {{0, 0, -1}, {{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}}}, {{0, 0, 1}, {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}},
};

static bool marked(const sn_voxels *v, const int cell[3]) {
    for (int k = 0; k < 3; k++)
        if (cell[k] < 0 || cell[k] >= v->size[k]) return false;
    size_t at = ((size_t)cell[2] * (size_t)v->size[1] + (size_t)cell[1]) * (size_t)v->size[0] + (size_t)cell[0];
    return v->marked[at / 8] >> at % 8 & 1;
}

static int64_t corner_number(const sn_voxels *v, const int cell[3], const int corner[3]) {
    return ((int64_t)(cell[2] + corner[2]) * (v->size[1] + 1) + cell[1] + corner[1]) * (v->size[0] + 1) + cell[0] + corner[0];
}

/* numbers (corners): 0 = not yet written, else the number of the vertex. */
typedef struct writer {
    FILE *file;
    int32_t *numbers;
    int32_t vertices;
    int64_t faces;
} writer;

static void write_face(writer *w, const sn_voxels *v, const int cell[3], const struct face *face) {
    int32_t corners[4];
    for (int c = 0; c < 4; c++) {
        int64_t number = corner_number(v, cell, face->corner[c]);
        if (w->numbers[number] == 0) {
            const int *o = face->corner[c];
            w->numbers[number] = ++w->vertices;
            fprintf(w->file, "v %.9g %.9g %.9g\n", v->box.low.x + (cell[0] + o[0]) * v->cell.x, v->box.low.y + (cell[1] + o[1]) * v->cell.y,
                    v->box.low.z + (cell[2] + o[2]) * v->cell.z);
        }
        corners[c] = w->numbers[number];
    }
    fprintf(w->file, "f %d %d %d\nf %d %d %d\n", corners[0], corners[1], corners[2], corners[0], corners[2], corners[3]);
    w->faces++;
}

static void write_cells(writer *w, const sn_voxels *v) {
    int cell[3];
    for (cell[2] = 0; cell[2] < v->size[2]; cell[2]++)
        for (cell[1] = 0; cell[1] < v->size[1]; cell[1]++)
            for (cell[0] = 0; cell[0] < v->size[0]; cell[0]++) {
                if (!marked(v, cell)) continue;
                for (int f = 0; f < 6; f++) {
                    const int next[3] = {cell[0] + FACES[f].step[0], cell[1] + FACES[f].step[1], cell[2] + FACES[f].step[2]};
                    if (!marked(v, next)) write_face(w, v, cell, &FACES[f]);
                }
            }
}

static sn_status write_mesh(const sn_voxels *v, const char *path, int64_t *faces, sn_error *error) {
    size_t corners = (size_t)(v->size[0] + 1) * (size_t)(v->size[1] + 1) * (size_t)(v->size[2] + 1);
    writer w = {fopen(path, "w"), SN_NEW(int32_t, corners), 0, 0};
    sn_status status = SN_OK;
    if (!w.numbers) status = sn_fail_memory(error, "the corners");
    if (!status && !w.file) status = sn_fail(error, SN_ERROR_IO, "%s cannot be written", path);
    if (!status) write_cells(&w, v);
    bool failed = w.file && ferror(w.file);
    if (w.file && (fclose(w.file) != 0 || failed) && !status) status = sn_fail(error, SN_ERROR_IO, "%s could not be written", path);
    *faces = w.faces;
    free(w.numbers);
    return status;
}

static sn_status set_size(const char *text, sn_box box, sn_index size[3], sn_error *error) {
    bool total = strncmp(text, "total:", 6) == 0;
    int64_t count = 0;
    if (sn_parse_integer(total ? text + 6 : text, 1, total ? SN_MOST_VOXELS : SN_MOST_VOXELS_ALONG, &count, error)) return SN_ERROR_USAGE;
    if (total)
        sn_voxels_in_all(box, (sn_index)count, size);
    else
        sn_voxels_along(box, (sn_index)count, size);
    return SN_OK;
}

int main(int argc, char **argv) {
    if (argc != 4) {
        fprintf(stderr, "Usage: voxels BONE N|total:N OUT.obj\n");
        return 2;
    }
    sn_mesh mesh = {0};
    sn_voxels v = {0};
    sn_error error = {0};
    sn_index size[3];
    int64_t faces = 0;
    sn_status status = sn_mesh_read(argv[1], &mesh, NULL, &error);
    if (!status) status = set_size(argv[2], sn_mesh_box(&mesh), size, &error);
    if (!status) status = sn_voxels_create(&mesh, size, &v, &error);
    if (!status) status = sn_voxels_fill(&v, &error);
    if (!status) status = write_mesh(&v, argv[3], &faces, &error);
    if (!status)
        printf("%d\t%d\t%d\t%lld\t%d\t%d\t%lld\t%.0f\t%.0f\n", size[0], size[1], size[2], (long long)sn_voxels_count(&v), v.boundary,
               v.inside, (long long)faces, (double)sn_voxels_count(&v) / 1024.0, (double)sn_voxels_bytes(&v) / 1024.0);
    else
        fprintf(stderr, "voxels: %s: %s\n", argv[1], error.text);
    sn_voxels_free(&v);
    sn_mesh_free(&mesh);
    return status == SN_ERROR_USAGE ? 2 : status ? 1 : fflush(stdout) == 0 ? 0 : 1;
}
