/*
 * fill_judge.c -- how much of a muscle's volume lies far from every fibre, how much of the fibres lies outside, and which of them bend more
 * than it does.
 *
 * The points are those of a lattice along z that lie inside: columns as far apart as points would be that share the volume evenly, cut by
 * the surface, and points at equal steps along the parts of them that are inside, one column after the other. They do not rest on the field
 * or its slices: what these leave out counts.
 */
#include <stdlib.h>

#include "fill.h"
#include "sinew/exact.h"
#include "tips.h"
#include "tree.h"

enum { POINTS = 2000, MOST_COLUMNS = 1 << 16 };

/* Where a column meets the surface. */
typedef struct crossing {
    double height;
    int facing; /* 1: the surface faces up there; -1: down */
} crossing;

typedef struct lattice {
    const sn_mesh *mesh;
    sn_vec3 low;     /* of the box */
    double width[2]; /* from column to column, across and along */
    double inside;   /* length of all columns' parts that are inside */
    sn_index across, along;
    sn_index *first; /* (across x along + 1) crossings of each column */
    crossing *crossings;
} lattice;

/* ---- the lattice ----------------------------------------------------------------------------------------------------------------- */

static sn_index columns_in(double extent, double width) { return (sn_index)fmin(fmax(floor(extent / width + 0.5), 1.0), MOST_COLUMNS); }

/* Columns stand in the middles of cells that fill the box. */
static void lay_lattice(lattice *l, double volume) {
    sn_box box = sn_mesh_box(l->mesh);
    sn_vec3 size = sn_sub(box.high, box.low);
    double width = fmax(sn_pow(volume / POINTS, 1.0 / 3.0), sqrt(size.x * size.y / MOST_COLUMNS));
    l->low = box.low;
    l->across = columns_in(size.x, width);
    l->along = columns_in(size.y, width);
    l->width[0] = size.x / l->across;
    l->width[1] = size.y / l->along;
}

static sn_vec3 column_at(const lattice *l, sn_index x, sn_index y) {
    return sn_v3(l->low.x + ((double)x + 0.5) * l->width[0], l->low.y + ((double)y + 0.5) * l->width[1], 0.0);
}

/* Columns from the first at or above `low` to the last at or below `high`; out[0] > out[1] where there is none. */
static void column_range(double origin, double width, sn_index count, double low, double high, sn_index out[2]) {
    out[0] = (sn_index)fmax(ceil((low - origin) / width - 0.5), 0.0);
    out[1] = (sn_index)fmin(floor((high - origin) / width - 0.5), count - 1);
}

static double height_at(const sn_vec3 p[3], sn_vec3 q) {
    sn_vec3 normal = sn_area_vector(p[0], p[1], p[2]);
    if (normal.z == 0.0) return p[0].z;
    double height = p[0].z - (normal.x * (q.x - p[0].x) + normal.y * (q.y - p[0].y)) / normal.z;
    return fmin(fmax(height, fmin(p[0].z, fmin(p[1].z, p[2].z))), fmax(p[0].z, fmax(p[1].z, p[2].z)));
}

/* Counts a triangle's crossings in at[column], or puts them there and counts. */
static void cross_triangle(lattice *l, sn_index t, sn_index *at) {
    sn_triangle triangle = l->mesh->triangles[t];
    const sn_vec3 *v = l->mesh->positions, p[3] = {v[triangle.v[0]], v[triangle.v[1]], v[triangle.v[2]]};
    sn_vec3 low = sn_min3(p[0], sn_min3(p[1], p[2])), high = sn_max3(p[0], sn_max3(p[1], p[2]));
    sn_index xs[2], ys[2];
    column_range(l->low.x, l->width[0], l->across, low.x, high.x, xs);
    column_range(l->low.y, l->width[1], l->along, low.y, high.y, ys);
    for (sn_index y = ys[0]; y <= ys[1]; y++)
        for (sn_index x = xs[0]; x <= xs[1]; x++) {
            sn_vec3 q = column_at(l, x, y);
            int facing = triangle_over(l->mesh, triangle, q);
            if (facing == 0) continue;
            sn_index *here = &at[y * l->across + x];
            if (l->crossings) l->crossings[*here] = (crossing){height_at(p, q), facing};
            (*here)++;
        }
}

static int compare_crossings(const void *left, const void *right) {
    const crossing *a = left, *b = right;
    if (a->height != b->height) return a->height < b->height ? -1 : 1;
    return a->facing - b->facing;
}

static sn_status cut_columns(lattice *l, sn_error *error) {
    sn_index columns = l->across * l->along;
    sn_index *at = SN_NEW(sn_index, columns);
    l->first = SN_NEW(sn_index, columns + 1);
    if (at && l->first) {
        for (sn_index t = 0; t < l->mesh->triangle_count; t++) cross_triangle(l, t, at);
        for (sn_index i = 0; i < columns; i++) {
            l->first[i + 1] = l->first[i] + at[i];
            at[i] = l->first[i];
        }
        l->crossings = SN_NEW(crossing, l->first[columns]);
        for (sn_index t = 0; l->crossings && t < l->mesh->triangle_count; t++) cross_triangle(l, t, at);
    }
    free(at);
    if (!l->crossings) return sn_fail_memory(error, "the points inside the muscle");
    for (sn_index i = 0; i < columns; i++)
        qsort(l->crossings + l->first[i], (size_t)(l->first[i + 1] - l->first[i]), sizeof *l->crossings, compare_crossings);
    return SN_OK;
}

/* ---- near a fibre ----------------------------------------------------------------------------------------------------------------- */

typedef struct nearby {
    sn_index count;
    const sn_polyline *lines;
    sn_box *boxes; /* (count) of the lines, wider by the reach */
    double reach;
    sn_index line, at; /* the segment found last */
} nearby;

static bool in_box(const sn_box *box, sn_vec3 p) {
    return p.x >= box->low.x && p.y >= box->low.y && p.z >= box->low.z && p.x <= box->high.x && p.y <= box->high.y && p.z <= box->high.z;
}

static bool near_segment(const nearby *n, sn_index line, sn_index at, sn_vec3 p) {
    sn_vec3 from = n->lines[line].points[at], d = sn_sub(n->lines[line].points[at + 1], from);
    double square = sn_norm2(d), t = square > 0.0 ? fmin(fmax(sn_dot(sn_sub(p, from), d) / square, 0.0), 1.0) : 0.0;
    return sn_norm2(sn_sub(p, sn_add_scaled(from, d, t))) <= n->reach * n->reach;
}

/* The next point is near the last: the segment that was near that one comes first. */
static bool is_near(nearby *n, sn_vec3 p) {
    if (n->line < n->count && near_segment(n, n->line, n->at, p)) return true;
    for (sn_index i = 0; i < n->count; i++) {
        if (!in_box(&n->boxes[i], p)) continue;
        for (sn_index k = 0; k + 1 < n->lines[i].count; k++) {
            if (!near_segment(n, i, k, p)) continue;
            n->line = i;
            n->at = k;
            return true;
        }
    }
    return false;
}

static bool nearby_create(sn_index count, const sn_polyline *lines, double reach, nearby *out) {
    *out = (nearby){.count = count, .lines = lines, .boxes = SN_NEW(sn_box, (size_t)count), .reach = reach, .line = count};
    for (sn_index i = 0; out->boxes && i < count; i++) {
        sn_vec3 low = lines[i].points[0], high = low, wider = sn_v3(reach, reach, reach);
        for (sn_index k = 1; k < lines[i].count; k++) {
            low = sn_min3(low, lines[i].points[k]);
            high = sn_max3(high, lines[i].points[k]);
        }
        out->boxes[i] = (sn_box){sn_sub(low, wider), sn_add(high, wider)};
    }
    return out->boxes != NULL;
}

/* ---- the share -------------------------------------------------------------------------------------------------------------------- */

/* What is done with the parts of columns that are inside, one after the other. */
typedef void part_visitor(void *user, sn_vec3 low, double length);

static void visit_column(const lattice *l, sn_index x, sn_index y, part_visitor *visit, void *user) {
    sn_vec3 low = column_at(l, x, y);
    sn_index column = y * l->across + x;
    int winding = 0;
    for (sn_index i = l->first[column]; i + 1 < l->first[column + 1]; i++) {
        winding -= l->crossings[i].facing; /* from below, a surface that faces down is the way in */
        low.z = l->crossings[i].height;
        if (winding != 0) visit(user, low, l->crossings[i + 1].height - low.z);
    }
}

static void visit_columns(const lattice *l, part_visitor *visit, void *user) {
    for (sn_index y = 0; y < l->along; y++)
        for (sn_index x = 0; x < l->across; x++) visit_column(l, x, y, visit, user);
}

static void add_length(void *user, sn_vec3 low, double length) {
    (void)low;
    *(double *)user += length;
}

typedef struct counting {
    nearby near;
    double step, ahead; /* from point to point; from the part's beginning to its first point */
    sn_index points, far;
} counting;

static void count_part(void *user, sn_vec3 low, double length) {
    counting *c = user;
    double at = c->ahead;
    for (; at < length; at += c->step) {
        c->points++;
        c->far += !is_near(&c->near, sn_v3(low.x, low.y, low.z + at));
    }
    c->ahead = at - length;
}

static sn_status count_far(const lattice *l, const sn_fibers *fibers, sn_fill_report *report, sn_error *error) {
    counting c = {.step = l->inside / POINTS, .ahead = 0.5 * l->inside / POINTS};
    /* so that more fibres along the same ways do not make the same muscle emptier */
    double crowd = fmax(1.0, (double)fibers->polyline_count / SN_FILL_FIBERS), reach = SN_FILL_FAR * report->spacing * sqrt(crowd);
    if (!nearby_create(fibers->polyline_count, fibers->polylines, reach, &c.near)) return sn_fail_memory(error, "the fibres");
    visit_columns(l, count_part, &c);
    report->empty = c.points > 0 ? (double)c.far / c.points : 0.0;
    free(c.near.boxes);
    return SN_OK;
}

static sn_status measure_empty(const sn_mesh *mesh, const sn_fibers *fibers, sn_fill_report *report, sn_error *error) {
    lattice l = {.mesh = mesh};
    double volume = fabs(sn_mesh_volume(mesh)), length = 0.0;
    for (sn_index i = 0; i < fibers->polyline_count; i++) length += fibers->polylines[i].length;
    if (!(volume > 0.0) || !(length > 0.0)) return SN_OK;
    lay_lattice(&l, volume);
    sn_status status = cut_columns(&l, error);
    if (!status) visit_columns(&l, add_length, &l.inside);
    if (l.inside > 0.0) {
        report->spacing = sqrt(l.width[0] * l.width[1] * l.inside / length);
        status = count_far(&l, fibers, report, error);
    }
    free(l.first);
    free(l.crossings);
    return status;
}

/* ---- bends ------------------------------------------------------------------------------------------------------------------------ */

/* A length over a distance that may be none. */
static double bend_of(double length, double distance) { return length / fmax(distance, 1e-6 * length); }

static double fiber_bend(const sn_polyline *line) {
    return bend_of(line->length, sn_distance(line->points[0], line->points[line->count - 1]));
}

static sn_status measure_muscle(const sn_mesh *mesh, const sn_topology *topology, double *bend, sn_error *error) {
    surface_survey survey;
    tips far;
    sn_status status = survey_surface(mesh, topology, &survey, error);
    if (!status) status = find_tips(mesh, topology, survey.main_vertex, NULL, &far, error);
    if (!status) *bend = far.length / sn_box_diagonal(sn_mesh_box(mesh));
    return status;
}

static sn_status measure_bends(const sn_mesh *mesh, const sn_topology *topology, const sn_fibers *fibers, sn_fill_report *report,
                               sn_error *error) {
    for (sn_index i = 0; i < fibers->polyline_count; i++)
        report->greatest_bend = fmax(report->greatest_bend, fiber_bend(&fibers->polylines[i]));
    if (report->greatest_bend <= SN_FILL_BENT) return SN_OK;
    sn_status status = measure_muscle(mesh, topology, &report->muscle_bend, error);
    for (sn_index i = 0; i < fibers->polyline_count && !status; i++)
        report->bent += fiber_bend(&fibers->polylines[i]) > SN_FILL_BENT * fmax(report->muscle_bend, 1.0);
    return status;
}

/* ---- outside ---------------------------------------------------------------------------------------------------------------------- */

/* A segment whose middle is farther out than this share of the box diagonal leaves the muscle; nearer, it cuts a corner of the surface. */
static const double CORNER = 0.01;

static sn_index middles_of(const sn_fibers *fibers, sn_vec3 *out) {
    sn_index count = 0;
    for (sn_index i = 0; i < fibers->polyline_count; i++)
        for (sn_index k = 0; k + 1 < fibers->polylines[i].count; k++, count++)
            if (out) out[count] = sn_lerp(fibers->polylines[i].points[k], fibers->polylines[i].points[k + 1], 0.5);
    return count;
}

static double length_outside(const sn_mesh *mesh, const sn_surface *surface, const sn_fibers *fibers, const sn_vec3 *middles,
                             const int *winding) {
    double corner = CORNER * sn_box_diagonal(sn_mesh_box(mesh)), outside = 0.0;
    sn_index n = 0;
    for (sn_index i = 0; i < fibers->polyline_count; i++)
        for (sn_index k = 0; k + 1 < fibers->polylines[i].count; k++, n++)
            if (winding[n] == 0 && sn_surface_signed_distance(surface, middles[n], NULL) > corner)
                outside += sn_distance(fibers->polylines[i].points[k], fibers->polylines[i].points[k + 1]);
    return outside;
}

/* Vertices inside say nothing of what is between them. Of a closed surface. */
static sn_status measure_outside(const sn_mesh *mesh, const sn_fibers *fibers, sn_fill_report *report, sn_error *error) {
    sn_index count = middles_of(fibers, NULL), suspects = 0;
    sn_vec3 *middles = SN_NEW(sn_vec3, count);
    int *winding = SN_NEW(int, count);
    sn_surface *surface = NULL;
    double length = 0.0;
    sn_status status = middles && winding ? SN_OK : sn_fail_memory(error, "the fibres");
    if (!status) middles_of(fibers, middles);
    if (!status) status = count_windings(mesh, count, middles, winding, error);
    for (sn_index i = 0; i < count && !status; i++) suspects += winding[i] == 0;
    if (suspects > 0) status = sn_surface_create(mesh, &surface, error);
    for (sn_index i = 0; i < fibers->polyline_count; i++) length += fibers->polylines[i].length;
    if (surface && length > 0.0) report->outside = length_outside(mesh, surface, fibers, middles, winding) / length;
    sn_surface_destroy(surface);
    free(middles);
    free(winding);
    return status;
}

sn_status fill_judge(const sn_mesh *mesh, const sn_topology *topology, const sn_fibers *fibers, sn_fill_report *report, sn_error *error) {
    sn_status status = measure_empty(mesh, fibers, report, error);
    if (!status && report->closed) status = measure_outside(mesh, fibers, report, error);
    return status ? status : measure_bends(mesh, topology, fibers, report, error);
}
