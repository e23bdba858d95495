/*
 * voxels.h -- a surface as voxels: its box in equal cells, those marked that a triangle runs through, and those that these enclose.
 * [K21] 3.2   rank 1
 *
 * A cell takes a bit. All lengths are in the unit of the mesh. Cells beyond the box are marked by nothing.
 */
#ifndef SINEW_VOXELS_H
#define SINEW_VOXELS_H

#include "sinew/mesh.h"

#define SN_MOST_VOXELS 134217728 /* 512^3, 16 MB */
#define SN_MOST_VOXELS_ALONG 512

typedef struct sn_voxels {
    sn_box box;                /* of the surface */
    sn_index size[3];          /* cells along x, y, z, each >= 1 */
    sn_vec3 cell;              /* width of one; 0 along an axis on which the surface is flat */
    sn_index boundary, inside; /* cells that a triangle touches; cells that those enclose (sn_voxels_fill) */
    unsigned char *marked;     /* a bit a cell, x runs fastest */
} sn_voxels;

/* As many cells along each axis; one along an axis without extent. count in [1, SN_MOST_VOXELS_ALONG]. */
void sn_voxels_along(sn_box box, sn_index count, sn_index size[3]);
/* About `count` cells in all, in [1, SN_MOST_VOXELS]: cubes of which the box would hold `count`, along each axis as many whole ones as
 * fit, and one layer where the box is thinner than a cube; then stretched to fill the box. [K21] does not tell how it rounds: down gives
 * the sizes of its fig. 3 (262144 are 47 x 64 x 85 of its pelvis, and 8 times as many 95 x 128 x 171), and to the nearest cannot. */
void sn_voxels_in_all(sn_box box, sn_index count, sn_index size[3]);
/* The cells that a triangle runs through or touches. SN_ERROR_INPUT: no triangle, or a box that is not finite; SN_ERROR_USAGE: a size below
 * 1, or more than SN_MOST_VOXELS cells. */
SN_MUST_CHECK sn_status sn_voxels_create(const sn_mesh *mesh, const sn_index size[3], sn_voxels *out, sn_error *error);
/* Marks also the cells that the marked ones enclose: what a fill from the faces of the box, to all 26 neighbours of a cell (in a plane the
 * 8 of [K21]), does not reach. A surface with a hole wider than a cell encloses nothing. */
SN_MUST_CHECK sn_status sn_voxels_fill(sn_voxels *voxels, sn_error *error);
void sn_voxels_free(sn_voxels *voxels);           /* frees what it owns and zeroes it */
size_t sn_voxels_bytes(const sn_voxels *voxels);  /* of memory */
int64_t sn_voxels_count(const sn_voxels *voxels); /* cells in all */
/* Is p in a marked cell? false for voxels that are all zeros, and where p is not finite. */
bool sn_voxels_at(const sn_voxels *voxels, sn_vec3 p);
/* Is p's cell marked, or one that has a face in common with it? */
bool sn_voxels_touch(const sn_voxels *voxels, sn_vec3 p);
/* [K21] 3.2: from `from`, in a marked cell, along the segment to `to`, which is in none, cell by cell to the first that is not marked. *out
 * is where the segment enters that cell, a thousandth of a cell's width within it (half of the segment's part in it, where that is less),
 * so that rounding does not put it back; cells that the segment only grazes are passed over. false: it is the cell of `to`, and *out is
 * `to`. */
bool sn_voxels_walk(const sn_voxels *voxels, sn_vec3 from, sn_vec3 to, sn_vec3 *out);

#endif
