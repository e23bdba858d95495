/*
 * fill_areas.c -- do fibres begin and end in the attachment areas, and are they spread over them? One TSV line a muscle, then percentiles.
 *
 *   fill_areas                 generated muscles at three densities, and with DATA every 8th of the dog's clean muscles (make check)
 *   DATA=FOLDER fill_areas all     all of them (make anatomy)
 *   fill_areas ... before          with fibres that ignore the areas' spread: what it was before
 *   OUT=FOLDER                     keep the rigs as documents there, for pictures
 *
 * The dog's clean muscles are those whose sites are compact at both ends; an area is what lies within 5 % of L of the site, along the
 * surface, at each of the two sites farthest apart. 49 fibres each. Measured: the share of fibres that begin in an area of one end and end
 * in one of the other; of each area the share of its surface that lies within 1.5 mean spacings (the root of area over fibres) of a
 * fibre's end; and the greatest length of a fibre over the path along the surface between its own two ends.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "dog_sites.h"
#include "sinew/io.h"
#include "sinew/rig.h"

#define PATCH 0.05     /* of L */
#define SITE_REACH 0.1 /* of L: sites farther from the surface are another muscle's */

enum { FIBERS = 49, EVERY = 8, MOST_AREAS = 4 };

static bool before;
static const char *out_folder;
static int passed, failed;

static void verdict(bool good, const char *what) {
    if (good)
        passed++;
    else
        failed++;
    if (!good) printf("NOT REACHED: %s\n", what);
}

static void die(const char *what) {
    printf("%s\n%d passed, %d failed\n", what, passed, failed + 1);
    exit(1);
}

static void *must(void *made) {
    if (made == NULL) die("out of memory");
    return made;
}

/* ---- a muscle with areas -------------------------------------------------------------------------------------------------------- */

/* Areas with the end that each is on. */
typedef struct sample {
    const char *name;
    sn_muscle muscle;
    char *side; /* (vertex_count) 0 = free, 1 = an origin, 2 = an insertion */
} sample;

static char bone_names[MOST_AREAS][2] = {"a", "b", "c", "d"};

/* bone (vertex_count): 0 = none, k = area k - 1. sides (areas): 1 or 2. */
static void attach(sample *s, const char *bone, int areas, const char *sides) {
    sn_muscle *m = &s->muscle;
    m->attachments = must(SN_NEW(sn_attachment, areas));
    m->attachment_count = areas;
    m->has_attachments = true;
    s->side = must(SN_NEW(char, m->mesh.vertex_count));
    for (int k = 0; k < areas; k++) {
        sn_attachment *a = &m->attachments[k];
        a->bone = must(sn_strdup(bone_names[k]));
        a->method = must(sn_strdup("area"));
        a->end = sides[k] == 1 ? SN_END_ORIGIN : SN_END_INSERTION;
        a->vertices = must(SN_NEW(sn_index, m->mesh.vertex_count));
        for (sn_index v = 0; v < m->mesh.vertex_count; v++) {
            if (bone[v] != k + 1) continue;
            a->vertices[a->count++] = v;
            s->side[v] = sides[k];
        }
    }
}

static void sample_free(sample *s) {
    sn_muscle_free(&s->muscle);
    free(s->side);
}

/* ---- measures ------------------------------------------------------------------------------------------------------------------- */

typedef struct measures {
    double in_areas, coverage[MOST_AREAS], ratio, mean, longest, seconds;
    int areas;
    sn_fill_report report;
} measures;

/* Numbers of all muscles. */
typedef struct numbers {
    size_t count, capacity;
    double *items;
} numbers;

static void add_number(numbers *n, double value) {
    if (!sn_grow((void **)&n->items, &n->capacity, n->count + 1, sizeof *n->items)) die("out of memory");
    n->items[n->count++] = value;
}

static int compare_numbers(const void *left, const void *right) {
    double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

static double percentile(numbers *n, double share) {
    if (n->count == 0) return NAN;
    qsort(n->items, n->count, sizeof *n->items, compare_numbers);
    return n->items[(size_t)(share * (double)(n->count - 1) + 0.5)];
}

/* The side that a point on the surface is on: of the corners of its triangle the nearest decides; any of them that is as near. */
static char side_at(const sample *s, const sn_surface *surface, sn_vec3 p) {
    sn_closest at = sn_surface_closest(surface, p, INFINITY);
    if (at.triangle == SN_NONE || at.distance > 1e-3 * sn_box_diagonal(sn_mesh_box(&s->muscle.mesh))) return 0;
    const sn_index *v = s->muscle.mesh.triangles[at.triangle].v;
    double most = fmax(at.barycentric[0], fmax(at.barycentric[1], at.barycentric[2]));
    for (int c = 0; c < 3; c++)
        if (at.barycentric[c] >= most - 1e-6 && s->side[v[c]]) return s->side[v[c]];
    return 0;
}

static double area_at(const sn_mesh *mesh, sn_index t) {
    const sn_index *v = mesh->triangles[t].v;
    return 0.5 * sn_norm(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]));
}

/* A third of the triangle belongs to each corner. */
static double area_of_side(const sample *s, char side) {
    double sum = 0.0;
    for (sn_index t = 0; t < s->muscle.mesh.triangle_count; t++)
        for (int c = 0; c < 3; c++)
            if (s->side[s->muscle.mesh.triangles[t].v[c]] == side) sum += area_at(&s->muscle.mesh, t) / 3.0;
    return sum;
}

static double nearest_end(const sn_fibers *f, sn_vec3 p) {
    double least = INFINITY;
    for (sn_index i = 0; i < f->polyline_count; i++) {
        const sn_polyline *line = &f->polylines[i];
        least = fmin(least, fmin(sn_distance(line->points[0], p), sn_distance(line->points[line->count - 1], p)));
    }
    return least;
}

/* By the kites of triangles, each seen from its middle, that belong to the area's vertices. */
static double coverage_of(const sample *s, int area, double reach) {
    const sn_mesh *mesh = &s->muscle.mesh;
    const sn_attachment *a = &s->muscle.attachments[area];
    char *member = must(SN_NEW(char, mesh->vertex_count));
    double covered = 0.0, all = 0.0;
    for (sn_index i = 0; i < a->count; i++) member[a->vertices[i]] = 1;
    for (sn_index t = 0; t < mesh->triangle_count; t++)
        for (int c = 0; c < 3; c++) {
            const sn_index *v = mesh->triangles[t].v;
            if (!member[v[c]]) continue;
            const sn_vec3 *p = mesh->positions;
            sn_vec3 others = sn_add(p[v[(c + 1) % 3]], p[v[(c + 2) % 3]]);
            sn_vec3 middle = sn_add_scaled(sn_scale(others, 7.0 / 36.0), p[v[c]], 22.0 / 36.0);
            double share = area_at(mesh, t) / 3.0;
            all += share;
            if (nearest_end(&s->muscle.fibers, middle) <= reach) covered += share;
        }
    free(member);
    return all > 0.0 ? covered / all : 0.0;
}

/* Greatest length over the path between the ends; the path is looked for only where the straight line does not do. */
static double worst_ratio(const sample *s, const sn_surface *surface) {
    sn_topology topology = {0};
    sn_path_finder *finder = NULL;
    double worst = 0.0;
    if (sn_topology_build(&s->muscle.mesh, &topology, NULL) || sn_path_finder_create(&s->muscle.mesh, &topology, &finder, NULL))
        die("no paths");
    for (sn_index i = 0; i < s->muscle.fibers.polyline_count; i++) {
        const sn_polyline *line = &s->muscle.fibers.polylines[i];
        sn_vec3 first = line->points[0], last = line->points[line->count - 1];
        double path = sn_distance(first, last);
        sn_surface_path found = {0};
        if (line->length > 1.3 * path) {
            sn_closest from = sn_surface_closest(surface, first, INFINITY), to = sn_surface_closest(surface, last, INFINITY);
            if (sn_path_find(finder, &from, &to, 0, &found, NULL) == SN_OK) path = fmax(path, found.length);
            sn_surface_path_free(&found);
        }
        worst = fmax(worst, line->length / path);
    }
    sn_path_finder_destroy(finder);
    sn_topology_free(&topology);
    return worst;
}

static void measure(const sample *s, measures *m) {
    sn_surface *surface = NULL;
    const sn_fibers *f = &s->muscle.fibers;
    if (sn_surface_create_plain(&s->muscle.mesh, &surface, NULL)) die("no surface");
    double area[2] = {area_of_side(s, 1), area_of_side(s, 2)};
    int good = 0;
    for (sn_index i = 0; i < f->polyline_count; i++) {
        char a = side_at(s, surface, f->polylines[i].points[0]);
        char b = side_at(s, surface, f->polylines[i].points[f->polylines[i].count - 1]);
        good += a && b && a != b;
        m->longest = fmax(m->longest, f->polylines[i].length);
    }
    m->in_areas = (double)good / FIBERS;
    m->areas = s->muscle.attachment_count;
    for (int k = 0; k < m->areas; k++) {
        const sn_attachment *a = &s->muscle.attachments[k];
        m->coverage[k] = coverage_of(s, k, 1.5 * sqrt(area[s->side[a->vertices[0]] - 1] / FIBERS));
    }
    m->ratio = worst_ratio(s, surface);
    m->mean = m->report.mean_length;
    sn_surface_destroy(surface);
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void keep(const sample *s) {
    char path[4096];
    sn_output *output = NULL;
    if (out_folder == NULL) return;
    snprintf(path, sizeof path, "%s/%s.muscle.json", out_folder, s->name);
    sn_write_options options = {0};
    if (sn_output_open(path, false, &output, NULL) || sn_muscle_write(&s->muscle, NULL, &options, output, NULL) ||
        sn_output_commit(output, NULL))
        die("the rigs cannot be kept");
}

/* What is known of a set. */
typedef struct totals {
    numbers coverage, ratio, in_areas;
    double slowest;
    int outside;
    int unknown; /* muscles whose areas were not both taken for ends: where fibres end is not for the filling to say */
} totals;

static bool fill(sample *s, measures *m, totals *t) {
    sn_fill_params params = sn_fill_defaults();
    sn_error error = {0};
    params.fibers = FIBERS;
    params.spread = !before;
    double start = now();
    sn_status status = sn_fill_fibers(&s->muscle, &params, NULL, &s->muscle.fibers, &m->report, &error);
    m->seconds = now() - start;
    if (status) {
        printf("%s\t%d\t%s\n", s->name, s->muscle.mesh.triangle_count, error.text);
        add_number(&t->in_areas, 0.0);
        add_number(&t->coverage, 0.0);
        return false;
    }
    measure(s, m);
    keep(s);
    double least = INFINITY;
    for (int k = 0; k < m->areas; k++) {
        add_number(&t->coverage, m->coverage[k]);
        least = fmin(least, m->coverage[k]);
    }
    bool known = m->report.chosen.known[0] && m->report.chosen.known[1];
    if (known) add_number(&t->in_areas, m->in_areas);
    t->unknown += !known;
    add_number(&t->ratio, m->ratio);
    t->slowest = fmax(t->slowest, m->seconds);
    t->outside += m->report.outside_after;
    if (!known) printf("  %s: %s\n", s->name, m->report.chosen.why);
    printf("%s\t%d\t%s\t%.3f\t%.3f\t%.3f\t%.4g\t%.4g\t%.4g\t%d\t%.0f\n", s->name, s->muscle.mesh.triangle_count,
           m->report.chosen.from != NULL ? m->report.chosen.from : "-", m->in_areas, least, m->ratio, m->mean, m->report.length_deviation,
           m->longest, m->report.outside_before, 1e3 * m->seconds);
    return true;
}

static void print_header(void) {
    printf("muscle\ttriangles\tends\tin_areas\tleast_coverage\tlength_over_path\tmean\tdeviation\tlongest\toutside_before\tms\n");
}

static void judge(const char *name, totals *t) {
    double inside = 0.0;
    for (size_t i = 0; i < t->in_areas.count; i++) inside += t->in_areas.items[i] / (double)t->in_areas.count;
    double median = percentile(&t->coverage, 0.5), low = percentile(&t->coverage, 0.05), worst = percentile(&t->ratio, 1.0);
    printf("%s: %zu muscles, and %d whose areas were not taken for ends; fibres from area to area %.2f %%; coverage: median %.3f, 5th "
           "percentile %.3f, least %.3f; length over path: "
           "median %.3f, 95th percentile %.3f, greatest %.3f; slowest %.0f ms; vertices left outside %d\n",
           name, t->in_areas.count, t->unknown, 100.0 * inside, median, low, percentile(&t->coverage, 0.0), percentile(&t->ratio, 0.5),
           percentile(&t->ratio, 0.95), worst, 1e3 * t->slowest, t->outside);
    verdict(t->unknown == 0, "the areas are taken for ends");
    verdict(inside >= 0.99, "99 % of the fibres from area to area");
    verdict(median >= 0.8, "coverage of 0.8 in the median");
    verdict(low >= 0.6, "coverage of 0.6 at the 5th percentile");
    verdict(worst <= 1.3, "no fibre longer than 1.3 times the path between its ends");
    verdict(t->outside == 0, "no vertex outside");
    free(t->coverage.items);
    free(t->ratio.items);
    free(t->in_areas.items);
}

/* ---- generated muscles ---------------------------------------------------------------------------------------------------------- */

/* Units of a lattice that are filled, their corners in space, and the area of a corner: 0 = none. */
typedef struct shape {
    const char *name;
    int size[3];
    bool (*filled)(const int p[3]);
    sn_vec3 (*place)(double x, double y, double z); /* of the unscaled lattice */
    int (*area)(double x, double y, double z);
    int areas;
    const char *sides;
} shape;

static bool whole(const int p[3]) { return (void)p, true; }
static bool prongs(const int p[3]) { return p[2] < 24 || p[0] < 4 || p[0] >= 8; }

/* The sheet of the fan: 120 mm wide at z = 0, 20 at z = -80, 10 thick; its areas lie on the face y = 0. */
static sn_vec3 fan_place(double x, double y, double z) {
    double u = x / 20.0, t = z / 16.0;
    return sn_v3(120.0 * u + (40.0 + 20.0 * u - 120.0 * u) * t, 5.0 * y, -80.0 * t);
}
static int fan_area(double x, double y, double z) {
    double depth = 5.0 * z;
    if (y > 0.0 || x < 0.4 || x > 19.6) return 0;
    return depth >= 2.0 && depth <= 25.0 ? 1 : depth >= 70.0 && depth <= 78.0 ? 2 : 0;
}
/* A strap of 12 x 24 x about 160, bent by a right angle; areas at both ends of its inner face. */
static sn_vec3 strap_place(double x, double y, double z) {
    double turn = 0.5 * SN_PI * z / 40.0, r = 90.0 + 4.0 * y;
    return sn_v3(4.0 * x, r * cos(turn), r * sin(turn));
}
static int strap_area(double x, double y, double z) { return (void)x, y > 0.0 ? 0 : z <= 5.0 ? 1 : z >= 35.0 ? 2 : 0; }
static int two_bones_area(double x, double y, double z) {
    return y > 0.0 ? 0 : z >= 35.0 ? 3 : z > 6.0 ? 0 : x <= 2.0 ? 1 : x >= 4.0 ? 2 : 0;
}
/* A plate of 30 x 12 x 120: origins on both its edges, the insertion on the lower part of its middle, in front. */
static sn_vec3 plate_place(double x, double y, double z) { return sn_v3(1.5 * x, 4.0 * y, 4.0 * z); }
static int bipennate_area(double x, double y, double z) {
    if (x <= 0.0 && z >= 17.0 && z <= 29.0) return 1;
    if (x >= 20.0 && z >= 17.0 && z <= 29.0) return 2;
    return y <= 0.0 && fabs(x - 10.0) <= 1.5 && z >= 1.0 && z <= 13.0 ? 3 : 0;
}
static sn_vec3 cube_place(double x, double y, double z) { return sn_v3(4.0 * x, 4.0 * y, 4.0 * z); }
static int heads_area(double x, double y, double z) {
    if (z <= 0.0) return 3;
    return (void)y, z < 29.0 ? 0 : x <= 4.0 ? 1 : 2;
}

static const shape shapes[] = {
    {"fan", {20, 2, 16}, whole, fan_place, fan_area, 2, "\1\2"},
    {"strap", {6, 3, 40}, whole, strap_place, strap_area, 2, "\1\2"},
    {"bipennate", {20, 3, 30}, whole, plate_place, bipennate_area, 3, "\1\1\2"},
    {"two-heads", {12, 4, 32}, prongs, cube_place, heads_area, 3, "\1\1\2"},
    {"two-bones", {6, 3, 40}, whole, strap_place, two_bones_area, 3, "\1\1\2"},
};

/* A shape at `scale` times its density, as it grows. */
typedef struct growing {
    const shape *shape;
    int scale, counts[3];
    sn_index *number; /* of each corner, from 1 */
    char *bone;
    sn_mesh mesh;
} growing;

static bool is_filled(const growing *g, const int p[3]) {
    int q[3];
    for (int a = 0; a < 3; a++) {
        if (p[a] < 0 || p[a] >= g->counts[a]) return false;
        q[a] = p[a] / g->scale;
    }
    return g->shape->filled(q);
}

static sn_index corner(growing *g, const int p[3]) {
    sn_index *n = &g->number[(p[0] * (g->counts[1] + 1) + p[1]) * (g->counts[2] + 1) + p[2]];
    if (*n > 0) return *n - 1;
    double x = (double)p[0] / g->scale, y = (double)p[1] / g->scale, z = (double)p[2] / g->scale;
    g->bone[g->mesh.vertex_count] = (char)g->shape->area(x, y, z);
    g->mesh.positions[g->mesh.vertex_count++] = g->shape->place(x, y, z);
    return (*n = g->mesh.vertex_count) - 1;
}

static void add_side(growing *g, const int p[3], int axis, int up) {
    sn_index c[4];
    for (int k = 0; k < 4; k++) {
        int q[3] = {p[0], p[1], p[2]};
        q[axis] += up;
        q[(axis + 1) % 3] += k == 1 || k == 2;
        q[(axis + 2) % 3] += k >= 2;
        c[k] = corner(g, q);
    }
    int second = up ? 1 : 3, fourth = up ? 3 : 1;
    g->mesh.triangles[g->mesh.triangle_count++] = (sn_triangle){{c[0], c[second], c[2]}};
    g->mesh.triangles[g->mesh.triangle_count++] = (sn_triangle){{c[0], c[2], c[fourth]}};
}

static void grow(growing *g) {
    int corners = 1;
    for (int a = 0; a < 3; a++) {
        g->counts[a] = g->shape->size[a] * g->scale;
        corners *= g->counts[a] + 1;
    }
    g->number = must(SN_NEW(sn_index, corners));
    g->bone = must(SN_NEW(char, corners));
    if (sn_mesh_alloc(&g->mesh, corners, 12 * corners, NULL)) die("out of memory");
    g->mesh.vertex_count = g->mesh.triangle_count = 0;
    for (int x = 0; x < g->counts[0]; x++)
        for (int y = 0; y < g->counts[1]; y++)
            for (int z = 0; z < g->counts[2]; z++)
                for (int side = 0; side < 6; side++) {
                    int p[3] = {x, y, z}, beside[3] = {x, y, z}, axis = side / 2, up = side % 2;
                    beside[axis] += up ? 1 : -1;
                    if (is_filled(g, p) && !is_filled(g, beside)) add_side(g, p, axis, up);
                }
}

static void process_shape(const shape *which, int scale, totals *t) {
    char name[64];
    growing g = {.shape = which, .scale = scale};
    measures m = {0};
    grow(&g);
    snprintf(name, sizeof name, "%s-%d", which->name, scale);
    sample s = {.name = name, .muscle = {.meters_per_unit = 1e-3, .mesh = g.mesh}};
    /* the strips' turned sides make it inside out where `place` mirrors */
    sn_index flipped = 0;
    if (sn_orient_outward(&s.muscle.mesh, &flipped, NULL)) die("a generated muscle is not closed");
    attach(&s, g.bone, which->areas, which->sides);
    bool filled = fill(&s, &m, t);
    if (strcmp(which->name, "fan") == 0 && !before) {
        verdict(filled && fabs(m.mean - 65.0) <= 4.0, "the fan's mean length 65 +- 4 mm");
        verdict(filled && m.longest <= 96.0, "no fibre of the fan longer than 96 mm");
    }
    sample_free(&s);
    free(g.number);
    free(g.bone);
}

/* ---- the dog ---------------------------------------------------------------------------------------------------------------------- */

static sn_index nearest_vertex(const sn_mesh *mesh, sn_vec3 p) {
    sn_index best = 0;
    for (sn_index v = 1; v < mesh->vertex_count; v++)
        if (sn_distance(mesh->positions[v], p) < sn_distance(mesh->positions[best], p)) best = v;
    return best;
}

/* What lies within 5 % of L of each site; false where they overlap or the surface does not join them. */
static bool grow_areas(sample *s, const site_list *sites) {
    const sn_mesh *mesh = &s->muscle.mesh;
    sn_topology topology = {0};
    char *bone = must(SN_NEW(char, mesh->vertex_count));
    double *distance = must(SN_NEW(double, 2 * mesh->vertex_count)), length = 0.0;
    if (sn_topology_build(mesh, &topology, NULL)) die("a muscle without topology");
    for (int e = 0; e < 2; e++) {
        sn_index v = nearest_vertex(mesh, sites->points[sites->far[e]]);
        if (sn_geodesic_distance(mesh, &topology, 1, &v, distance + e * mesh->vertex_count, NULL)) die("no distances");
    }
    for (sn_index v = 0; v < mesh->vertex_count; v++)
        if (isfinite(distance[v])) length = fmax(length, distance[v]);
    bool apart = isfinite(length) && length > 0.0;
    for (sn_index i = 0; i < sites->count; i++) { /* as sn_flow_fibers has it: others are not this muscle's */
        sn_index v = nearest_vertex(mesh, sites->points[i]);
        apart = apart && sn_distance(mesh->positions[v], sites->points[i]) <= SITE_REACH * length;
    }
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        bool in[2] = {distance[v] <= PATCH * length, distance[mesh->vertex_count + v] <= PATCH * length};
        apart = apart && !(in[0] && in[1]);
        bone[v] = in[0] ? 1 : in[1] ? 2 : 0;
    }
    if (apart) attach(s, bone, 2, "\1\2");
    sn_topology_free(&topology);
    free(distance);
    free(bone);
    return apart;
}

static void process_muscle(const char *path, const char *file, const site_list *sites, totals *t) {
    sn_error error = {0};
    measures m = {0};
    sample s = {.name = file, .muscle = {.meters_per_unit = 1.0}};
    if (sn_mesh_read(path, &s.muscle.mesh, NULL, &error)) die(error.text);
    if (grow_areas(&s, sites))
        (void)fill(&s, &m, t);
    else
        printf("%s\t%d\tthe sites are not this muscle's, or their areas meet\n", file, s.muscle.mesh.triangle_count);
    sample_free(&s);
}

static void process_dog(const char *data, bool all, totals *t) {
    char path[4096], file[512];
    sn_blob manifest = {0}, table = {0};
    int clean = 0;
    snprintf(path, sizeof path, "%s/dog-dmcontrol/manifest.tsv", data);
    if (sn_blob_read(path, &manifest, NULL)) die("no manifest");
    snprintf(path, sizeof path, "%s/dog-dmcontrol/attachments.tsv", data);
    if (sn_blob_read(path, &table, NULL)) die("no table of sites");
    for (const char *line = manifest.data; line && *line; line = strchr(line, '\n'), line += line != NULL) {
        const char *kind = column(line, 1);
        site_list sites;
        if (!kind || strncmp(kind, "muscle\t", 7) != 0) continue;
        snprintf(file, sizeof file, "%.*s", (int)(kind - 1 - line), line);
        find_sites(&table, file, &sites);
        if (!group_sites(&sites) || (clean++ % EVERY != 0 && !all)) continue;
        snprintf(path, sizeof path, "%s/dog-dmcontrol/meshes/%s", data, file);
        process_muscle(path, file, &sites, t);
    }
    sn_blob_free(&manifest);
    sn_blob_free(&table);
}

static bool exists(const char *data) {
    char path[4096];
    snprintf(path, sizeof path, "%s/dog-dmcontrol/manifest.tsv", data);
    FILE *file = fopen(path, "r");
    if (file != NULL) fclose(file);
    return file != NULL;
}

int main(int argc, char **argv) {
    const char *data = getenv("DATA");
    bool all = false;
    totals generated = {0}, dog = {0};
    out_folder = getenv("OUT");
    for (int i = 1; i < argc; i++) {
        all |= strcmp(argv[i], "all") == 0;
        before |= strcmp(argv[i], "before") == 0;
    }
    print_header();
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++)
        for (int scale = 1; scale <= 4; scale *= 2) process_shape(&shapes[i], scale, &generated);
    judge("generated", &generated);
    if (data != NULL && exists(data)) {
        process_dog(data, all, &dog);
        verdict(!all || dog.in_areas.count + (size_t)dog.unknown >= 128, "128 muscles of the dog with compact sites");
        judge("dog", &dog);
    } else {
        printf("no real anatomy at %s: skipped\n", data ? data : "$DATA");
    }
    printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}
