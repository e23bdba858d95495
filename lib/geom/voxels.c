/*
 * voxels.c -- the voxels of a bone, as [K21] 3.2 collides with them.
 *
 * A triangle and a cell overlap unless one of 13 axes separates them (Akenine-Moeller 2001). Cells are closed sets: with every cell marked
 * that the surface touches, no step between neighbours, over a face, an edge or a corner, gets from one side of a closed surface to the
 * other.
 */
#include "sinew/voxels.h"

#include <stdlib.h>

/* Cells reach farther than they are by this share of the box's diagonal: rounding must not part them from a face of the box. */
static const double REACH = 1e-12;
/* Counts of cubes within this share of a whole number are that number. */
static const double WHOLE = 1e-9;
/* A segment enters a cell by this share of its width, and passes over one in which it is shorter than the second. */
static const double ENTRY = 1e-3, GRAZED = 1e-6;

/* ---- cells ------------------------------------------------------------------------------------------------------------------------ */

static size_t cell_number(const sn_voxels *v, const sn_index cell[3]) {
    return ((size_t)cell[2] * (size_t)v->size[1] + (size_t)cell[1]) * (size_t)v->size[0] + (size_t)cell[0];
}

static bool bit_of(const unsigned char *bits, size_t cell) { return bits[cell / 8] >> cell % 8 & 1; }

static void set_bit(unsigned char *bits, size_t cell) { bits[cell / 8] |= (unsigned char)(1u << cell % 8); }

static bool has_cell(const sn_voxels *v, const sn_index cell[3]) {
    for (int k = 0; k < 3; k++)
        if (cell[k] < 0 || cell[k] >= v->size[k]) return false;
    return true;
}

static bool is_marked(const sn_voxels *v, const sn_index cell[3]) { return has_cell(v, cell) && bit_of(v->marked, cell_number(v, cell)); }

/* The cell of a coordinate along one axis; the far face of the box belongs to the last cell. */
static sn_index cell_along(double x, double low, double size, sn_index count) {
    double cell = size > 0.0 ? floor((x - low) / size) : 0.0;
    return (sn_index)fmin(fmax(cell, 0.0), count - 1);
}

static void cell_of(const sn_voxels *v, sn_vec3 p, sn_index cell[3]) {
    sn_vec3 low = v->box.low;
    cell[0] = cell_along(p.x, low.x, v->cell.x, v->size[0]);
    cell[1] = cell_along(p.y, low.y, v->cell.y, v->size[1]);
    cell[2] = cell_along(p.z, low.z, v->cell.z, v->size[2]);
}

static bool in_box(const sn_box *box, sn_vec3 p) {
    return p.x >= box->low.x && p.x <= box->high.x && p.y >= box->low.y && p.y <= box->high.y && p.z >= box->low.z && p.z <= box->high.z;
}

bool sn_voxels_at(const sn_voxels *v, sn_vec3 p) {
    sn_index cell[3];
    if (v->marked == NULL || !in_box(&v->box, p)) return false;
    cell_of(v, p, cell);
    return bit_of(v->marked, cell_number(v, cell));
}

bool sn_voxels_touch(const sn_voxels *v, sn_vec3 p) {
    sn_index cell[3];
    const sn_box around = {sn_sub(v->box.low, v->cell), sn_add(v->box.high, v->cell)};
    if (v->marked == NULL || !in_box(&around, p)) return false;
    if (sn_voxels_at(v, p)) return true;
    const double at[3] = {p.x, p.y, p.z}, low[3] = {v->box.low.x, v->box.low.y, v->box.low.z},
                 high[3] = {v->box.high.x, v->box.high.y, v->box.high.z};
    cell_of(v, p, cell);
    for (int k = 0; k < 3; k++) cell[k] = at[k] < low[k] ? -1 : at[k] > high[k] ? v->size[k] : cell[k];
    for (int side = 0; side < 6; side++) {
        sn_index beside[3] = {cell[0], cell[1], cell[2]};
        beside[side / 2] += side % 2 == 0 ? -1 : 1;
        if (is_marked(v, beside)) return true;
    }
    return false;
}

size_t sn_voxels_bytes(const sn_voxels *v) { return v->marked != NULL ? (size_t)sn_voxels_count(v) / 8 + 1 : 0; }

int64_t sn_voxels_count(const sn_voxels *v) { return (int64_t)v->size[0] * v->size[1] * v->size[2]; }

/* ---- how many of them ------------------------------------------------------------------------------------------------------------- */

static void sides_of(sn_box box, double side[3]) {
    side[0] = box.high.x - box.low.x;
    side[1] = box.high.y - box.low.y;
    side[2] = box.high.z - box.low.z;
}

void sn_voxels_along(sn_box box, sn_index count, sn_index size[3]) {
    double side[3];
    sides_of(box, side);
    for (int k = 0; k < 3; k++) size[k] = side[k] > 0.0 ? count : 1;
}

/* The width of the cubes of which the axes in `along` would hold so many. */
static double cube_of(const double side[3], const bool along[3], sn_index count) {
    double content = 1.0;
    int axes = 0;
    for (int k = 0; k < 3; k++)
        if (along[k]) content *= side[k], axes++;
    return axes > 0 ? sn_quick_pow(content / count, 1.0 / axes) : 1.0;
}

void sn_voxels_in_all(sn_box box, sn_index count, sn_index size[3]) {
    double side[3], cube = 1.0;
    bool along[3], thin = true;
    sides_of(box, side);
    for (int k = 0; k < 3; k++) along[k] = side[k] > 0.0;
    while (thin) { /* an axis thinner than a cube has one layer, and the others share the cells */
        thin = false;
        cube = cube_of(side, along, count);
        for (int k = 0; k < 3; k++)
            if (along[k] && side[k] < cube * (1.0 - WHOLE)) along[k] = false, thin = true;
    }
    for (int k = 0; k < 3; k++) size[k] = along[k] ? (sn_index)fmin(floor(side[k] / cube * (1.0 + WHOLE)), count) : 1;
}

/* ---- the surface's cells ---------------------------------------------------------------------------------------------------------- */

/* Does the plane across axis keep the triangle (relative to the cell's centre) apart from the cell of half size h? */
static bool separates(sn_vec3 axis, const sn_vec3 corner[3], sn_vec3 h) {
    double a = sn_dot(axis, corner[0]), b = sn_dot(axis, corner[1]), c = sn_dot(axis, corner[2]);
    double radius = h.x * fabs(axis.x) + h.y * fabs(axis.y) + h.z * fabs(axis.z);
    return fmin(a, fmin(b, c)) > radius || fmax(a, fmax(b, c)) < -radius;
}

static bool overlaps(const sn_vec3 triangle[3], sn_vec3 centre, sn_vec3 h) {
    static const sn_vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    sn_vec3 corner[3];
    for (int k = 0; k < 3; k++) corner[k] = sn_sub(triangle[k], centre);
    for (int k = 0; k < 3; k++) {
        if (separates(axes[k], corner, h)) return false;
        sn_vec3 side = sn_sub(corner[(k + 1) % 3], corner[k]);
        for (int a = 0; a < 3; a++)
            if (separates(sn_cross(axes[a], side), corner, h)) return false;
    }
    return !separates(sn_area_vector(corner[0], corner[1], corner[2]), corner, h);
}

static void mark(sn_voxels *v, const sn_index cell[3]) {
    size_t number = cell_number(v, cell);
    v->boundary += !bit_of(v->marked, number);
    set_bit(v->marked, number);
}

/* reach: by which cells are larger, on each side. */
static void mark_triangle(sn_voxels *v, const sn_vec3 corner[3], sn_vec3 reach) {
    sn_vec3 low = sn_min3(corner[0], sn_min3(corner[1], corner[2])), high = sn_max3(corner[0], sn_max3(corner[1], corner[2]));
    sn_vec3 size = v->cell, h = sn_add(sn_scale(size, 0.5), reach);
    sn_index first[3], last[3], c[3];
    cell_of(v, sn_sub(low, reach), first);
    cell_of(v, sn_add(high, reach), last);
    for (c[2] = first[2]; c[2] <= last[2]; c[2]++)
        for (c[1] = first[1]; c[1] <= last[1]; c[1]++)
            for (c[0] = first[0]; c[0] <= last[0]; c[0]++) {
                sn_vec3 centre = sn_add(v->box.low, sn_v3((c[0] + 0.5) * size.x, (c[1] + 0.5) * size.y, (c[2] + 0.5) * size.z));
                if (overlaps(corner, centre, h)) mark(v, c);
            }
}

static sn_status check_size(const sn_mesh *mesh, const sn_voxels *v, sn_error *error) {
    double cells = 1.0;
    for (int k = 0; k < 3; k++) {
        if (v->size[k] < 1) return sn_fail(error, SN_ERROR_USAGE, "there is at least one voxel along each axis");
        cells *= v->size[k];
    }
    if (cells > SN_MOST_VOXELS)
        return sn_fail(error, SN_ERROR_USAGE, "%.0f voxels are more than there may be, %d; take fewer", cells, SN_MOST_VOXELS);
    if (mesh->triangle_count == 0) return sn_fail(error, SN_ERROR_INPUT, "a surface without triangles has no voxels");
    if (!sn_finite3(v->box.low) || !sn_finite3(v->box.high))
        return sn_fail(error, SN_ERROR_INPUT, "a surface with a coordinate that is not finite has no voxels (mesh-clean drops it)");
    return SN_OK;
}

sn_status sn_voxels_create(const sn_mesh *mesh, const sn_index size[3], sn_voxels *out, sn_error *error) {
    *out = (sn_voxels){.box = sn_mesh_box(mesh), .size = {size[0], size[1], size[2]}};
    sn_status status = check_size(mesh, out, error);
    if (status != SN_OK) return status;
    sn_vec3 all = sn_sub(out->box.high, out->box.low);
    out->cell = sn_v3(all.x / size[0], all.y / size[1], all.z / size[2]);
    if ((out->marked = sn_alloc((size_t)sn_voxels_count(out) / 8 + 1, 1)) == NULL) return sn_fail_memory(error, "the voxels of a bone");
    double reach = REACH * (sn_box_diagonal(out->box) + sn_norm(out->box.low));
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        sn_vec3 corner[3];
        for (int k = 0; k < 3; k++) corner[k] = mesh->positions[mesh->triangles[t].v[k]];
        mark_triangle(out, corner, sn_v3(reach, reach, reach));
    }
    return SN_OK;
}

void sn_voxels_free(sn_voxels *v) {
    free(v->marked);
    *v = (sn_voxels){0};
}

/* ---- what they enclose ------------------------------------------------------------------------------------------------------------ */

/* Cells that a fill has come to: all of them as bits, the latest as a list. */
typedef struct front {
    sn_voxels *v;
    unsigned char *reached;
    sn_index *cells;
    size_t count, capacity;
} front;

/* false: no memory. */
static bool reach_cell(front *f, const sn_index cell[3]) {
    if (!has_cell(f->v, cell)) return true;
    size_t number = cell_number(f->v, cell);
    if (bit_of(f->v->marked, number) || bit_of(f->reached, number)) return true;
    if (!sn_grow((void **)&f->cells, &f->capacity, f->count + 1, sizeof *f->cells)) return false;
    set_bit(f->reached, number);
    f->cells[f->count++] = (sn_index)number;
    return true;
}

static bool reach_neighbours(front *f, sn_index number) {
    const sn_index *size = f->v->size;
    const sn_index at[3] = {number % size[0], number / size[0] % size[1], number / size[0] / size[1]};
    for (sn_index k = 0; k < 27; k++) {
        const sn_index beside[3] = {at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1};
        if (!reach_cell(f, beside)) return false;
    }
    return true;
}

/* Those of the faces of the box. */
static bool reach_faces(front *f) {
    const sn_index *size = f->v->size;
    for (int axis = 0; axis < 3; axis++) {
        int a = (axis + 1) % 3, b = (axis + 2) % 3;
        for (sn_index i = 0; i < size[a]; i++)
            for (sn_index j = 0; j < size[b]; j++) {
                sn_index cell[3];
                cell[a] = i, cell[b] = j;
                cell[axis] = 0;
                if (!reach_cell(f, cell)) return false;
                cell[axis] = size[axis] - 1;
                if (!reach_cell(f, cell)) return false;
            }
    }
    return true;
}

/* Ring by ring: what was reached last is followed, and gives way to what it reaches. */
static bool flood(front *f) {
    front last = {0};
    bool room = reach_faces(f);
    while (room && f->count > 0) {
        front spare = last;
        last = *f;
        f->cells = spare.cells, f->capacity = spare.capacity, f->count = 0;
        for (size_t i = 0; i < last.count && room; i++) room = reach_neighbours(f, last.cells[i]);
    }
    free(last.cells);
    return room;
}

sn_status sn_voxels_fill(sn_voxels *v, sn_error *error) {
    size_t cells = (size_t)sn_voxels_count(v);
    front f = {.v = v, .reached = sn_alloc(cells / 8 + 1, 1)};
    bool done = f.reached != NULL && flood(&f);
    for (size_t cell = 0; done && cell < cells; cell++) {
        if (bit_of(f.reached, cell) || bit_of(v->marked, cell)) continue;
        set_bit(v->marked, cell);
        v->inside++;
    }
    free(f.reached);
    free(f.cells);
    return done ? SN_OK : sn_fail_memory(error, "the voxels of a bone");
}

/* ---- along a segment (Amanatides, Woo 1987) --------------------------------------------------------------------------------------- */

/* Where a walk from one point to another is: t runs from 0 to 1 over the segment. */
typedef struct walk {
    double start[3], way[3]; /* in cells */
    sn_index cell[3], end[3];
    double length; /* in cells */
} walk;

static void to_cells(const sn_voxels *v, sn_vec3 p, double at[3]) {
    sn_vec3 away = sn_sub(p, v->box.low);
    at[0] = v->cell.x > 0.0 ? away.x / v->cell.x : 0.0;
    at[1] = v->cell.y > 0.0 ? away.y / v->cell.y : 0.0;
    at[2] = v->cell.z > 0.0 ? away.z / v->cell.z : 0.0;
}

/* The cell of a coordinate in cells, in a grid without end. */
static sn_index endless_cell(double x, sn_index count) {
    if (x == (double)count) return count - 1;
    return (sn_index)fmin(fmax(floor(x), -1e9), 1e9);
}

static walk begin_walk(const sn_voxels *v, sn_vec3 from, sn_vec3 to) {
    walk w;
    double goal[3], sum = 0.0;
    to_cells(v, from, w.start);
    to_cells(v, to, goal);
    cell_of(v, from, w.cell);
    for (int k = 0; k < 3; k++) {
        w.way[k] = goal[k] - w.start[k];
        w.end[k] = endless_cell(goal[k], v->size[k]);
        sum += w.way[k] * w.way[k];
    }
    w.length = sqrt(sum);
    return w;
}

/* Where the segment leaves the cell at hand, and by which axis. */
static double leaves_at(const walk *w, int *axis) {
    double first = INFINITY;
    for (int k = 0; k < 3; k++) {
        if (w->way[k] == 0.0) continue;
        double face = w->way[k] > 0.0 ? w->cell[k] + 1.0 : w->cell[k], t = (face - w->start[k]) / w->way[k];
        if (t < first) first = t, *axis = k;
    }
    return first;
}

static bool arrived(const walk *w) { return w->cell[0] == w->end[0] && w->cell[1] == w->end[1] && w->cell[2] == w->end[2]; }

bool sn_voxels_walk(const sn_voxels *v, sn_vec3 from, sn_vec3 to, sn_vec3 *out) {
    walk w = begin_walk(v, from, to);
    int axis = 0;
    *out = to;
    if (!(w.length > 0.0) || !isfinite(w.length)) return false;
    double entered = leaves_at(&w, &axis);
    while (entered < 1.0) {
        w.cell[axis] += w.way[axis] > 0.0 ? 1 : -1;
        if (arrived(&w)) return false;
        double left = leaves_at(&w, &axis), within = (fmin(left, 1.0) - entered) * w.length;
        if (within > GRAZED && !is_marked(v, w.cell)) {
            *out = sn_lerp(from, to, entered + fmin(ENTRY, 0.5 * within) / w.length);
            return true;
        }
        entered = left;
    }
    return false;
}
