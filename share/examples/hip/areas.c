/*
 * areas.c -- attachment areas grown on a muscle's surface around single sites, as landmarks for attach-detect.   [K21] section 3.3
 *
 *   areas SURFACE SITES.tsv RADIUS [LANDMARKS]
 *
 * SURFACE is closed. SITES.tsv has lines of bone, area, x, y, z with tabs between them, in its unit; lines that begin with # and a first
 * line of names are passed over. An area is what lies within RADIUS of its site along the surface: a length in that unit, a share of the
 * muscle's length as 8%, or both as 8%,0.01, of which the lesser counts. It is less where another site is nearer than twice that (0.45 of
 * the way between them), and where the area would close around the muscle, so that its boundary had two pieces. Printed are LANDMARKS (12)
 * points for each area, evenly along its boundary, in the form that attach-detect --landmarks reads, and on the standard error what each
 * area has become. Status: 0 done; 1 bad input, such as a site farther from the surface than a tenth of the muscle's length; 2 wrong usage.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sinew/geom.h"
#include "sinew/io.h"

#define SITE_REACH 0.1 /* of the muscle's length: a site farther away is another muscle's */
#define APART 0.45     /* of the way to the next site */
#define SHRINK 0.9     /* a radius whose boundary is in pieces is tried again times this */
#define LEAST 0.2      /* of the radius asked for */

enum { MOST_SITES = 256, LANDMARKS = 12 };

typedef struct site {
    char bone[128], area[128];
    sn_vec3 place;
    sn_index vertex;  /* nearest */
    double *distance; /* (vertices) from it, along the surface */
} site;

typedef struct muscle {
    sn_mesh mesh;
    sn_topology topology;
    double length; /* of the longest way along the surface from the farthest point */
    site sites[MOST_SITES];
    int count;
} muscle;

/* A closed line of points. */
typedef struct loop {
    sn_vec3 *points; /* (count) */
    sn_index count;
} loop;

/* ---- reading -------------------------------------------------------------------------------------------------------------------- */

static sn_status read_line(char *line, site *s, sn_error *error) {
    char *field[5] = {0};
    double p[3];
    for (int k = 0; k < 5; k++) field[k] = strsep(&line, "\t");
    if (field[4] == NULL) return sn_fail(error, SN_ERROR_INPUT, "a site has bone, area, x, y and z, with tabs between them");
    for (int k = 0; k < 3; k++)
        if (sn_parse_number(field[k + 2], &p[k], error)) return SN_ERROR_INPUT;
    snprintf(s->bone, sizeof s->bone, "%s", field[0]);
    snprintf(s->area, sizeof s->area, "%s", field[1]);
    s->place = sn_v3(p[0], p[1], p[2]);
    return SN_OK;
}

static sn_status read_sites(const char *path, muscle *m, sn_error *error) {
    char line[1024];
    int number = 0;
    FILE *file = fopen(path, "r");
    sn_status status = file ? SN_OK : sn_fail(error, SN_ERROR_INPUT, "it cannot be opened");
    while (!status && fgets(line, sizeof line, file)) {
        line[strcspn(line, "\r\n")] = '\0';
        if (number++ == 0 && strncmp(line, "bone\t", 5) == 0) continue;
        if (line[0] == '#' || line[0] == '\0') continue;
        if (m->count == MOST_SITES) status = sn_fail(error, SN_ERROR_INPUT, "it has more than %d sites", MOST_SITES);
        if (!status) status = read_line(line, &m->sites[m->count++], error);
    }
    if (!status && m->count == 0) status = sn_fail(error, SN_ERROR_INPUT, "it has no site");
    if (file) fclose(file);
    if (status) sn_error_set_file(error, path);
    return status;
}

/* ---- distances ------------------------------------------------------------------------------------------------------------------ */

static sn_index nearest_vertex(const sn_mesh *mesh, sn_vec3 p) {
    sn_index nearest = 0;
    for (sn_index v = 1; v < mesh->vertex_count; v++)
        if (sn_distance(mesh->positions[v], p) < sn_distance(mesh->positions[nearest], p)) nearest = v;
    return nearest;
}

static sn_index farthest(const muscle *m, const double *distance) {
    sn_index far = 0;
    for (sn_index v = 1; v < m->mesh.vertex_count; v++)
        if (isfinite(distance[v]) && distance[v] > distance[far]) far = v;
    return far;
}

/* The muscle's length: from the point farthest from the first site to the one farthest from there. */
static sn_status measure_length(muscle *m, sn_error *error) {
    double *distance = SN_NEW(double, m->mesh.vertex_count);
    if (!distance) return sn_fail_memory(error, "distances");
    sn_index tip = farthest(m, m->sites[0].distance);
    sn_status status = sn_geodesic_distance(&m->mesh, &m->topology, 1, &tip, distance, error);
    if (!status) m->length = distance[farthest(m, distance)];
    free(distance);
    return status;
}

static sn_status measure_sites(muscle *m, sn_error *error) {
    sn_status status = SN_OK;
    for (int i = 0; i < m->count && !status; i++) {
        site *s = &m->sites[i];
        s->vertex = nearest_vertex(&m->mesh, s->place);
        s->distance = SN_NEW(double, m->mesh.vertex_count);
        status = s->distance ? sn_geodesic_distance(&m->mesh, &m->topology, 1, &s->vertex, s->distance, error)
                             : sn_fail_memory(error, "distances");
    }
    if (!status) status = measure_length(m, error);
    for (int i = 0; i < m->count && !status; i++) {
        double away = sn_distance(m->mesh.positions[m->sites[i].vertex], m->sites[i].place);
        if (away > SITE_REACH * m->length)
            status = sn_fail(error, SN_ERROR_INPUT,
                             "the site %s on %s is %g from the muscle, which is %g long: it is another's, or in another unit",
                             m->sites[i].area, m->sites[i].bone, away, m->length);
    }
    return status;
}

static double free_radius(const muscle *m, int which, double radius) {
    const site *s = &m->sites[which];
    for (int i = 0; i < m->count; i++)
        if (i != which) radius = fmin(radius, APART * s->distance[m->sites[i].vertex]);
    return radius;
}

/* ---- boundaries ----------------------------------------------------------------------------------------------------------------- */

/* The corner from which the edge to the next one runs from farther than r to nearer; -1 = the line does not pass the triangle. */
static int exit_corner(const muscle *m, const double *d, double r, sn_index t) {
    const sn_index *v = m->mesh.triangles[t].v;
    for (int c = 0; c < 3; c++)
        if (d[v[c]] >= r && d[v[(c + 1) % 3]] < r) return c;
    return -1;
}

static sn_vec3 crossing_point(const muscle *m, const double *d, double r, const sn_index *v) {
    return sn_lerp(m->mesh.positions[v[0]], m->mesh.positions[v[1]], (r - d[v[0]]) / (d[v[1]] - d[v[0]]));
}

/* Follow the line where the distance is r from triangle t on, with what is nearer on the left, until it closes. */
static sn_status follow(const muscle *m, const double *d, double r, sn_index t, bool *seen, loop *out) {
    for (out->count = 0; !seen[t];) {
        seen[t] = true;
        int c = exit_corner(m, d, r, t);
        const sn_index ends[2] = {m->mesh.triangles[t].v[c], m->mesh.triangles[t].v[(c + 1) % 3]};
        const sn_edge *edge = &m->topology.edges[sn_topology_edge(&m->topology, ends[0], ends[1])];
        if (edge->triangle_count != 2) return SN_ERROR_INPUT;
        out->points[out->count++] = crossing_point(m, d, r, ends);
        t = edge->triangle[0] == t ? edge->triangle[1] : edge->triangle[0];
    }
    return SN_OK;
}

/* *pieces of the line where the distance is r; out->points has room for a point a triangle, and holds the last piece. */
static sn_status boundary(const muscle *m, const double *d, double r, int *pieces, loop *out) {
    bool *seen = SN_NEW(bool, m->mesh.triangle_count);
    sn_status status = seen ? SN_OK : SN_ERROR_MEMORY;
    *pieces = 0;
    for (sn_index t = 0; t < m->mesh.triangle_count && !status; t++) {
        if (seen[t] || exit_corner(m, d, r, t) < 0) continue;
        ++*pieces;
        status = follow(m, d, r, t, seen, out);
    }
    free(seen);
    return status;
}

static void print_landmarks(const site *s, const loop *line, int count) {
    double whole = 0.0, passed = 0.0;
    for (sn_index i = 0; i < line->count; i++) whole += sn_distance(line->points[i], line->points[(i + 1) % line->count]);
    int printed = 0;
    for (sn_index i = 0; i < line->count; i++) {
        sn_vec3 a = line->points[i], b = line->points[(i + 1) % line->count];
        double step = sn_distance(a, b);
        for (; printed < count && whole * printed <= count * (passed + step); printed++) {
            sn_vec3 p = sn_lerp(a, b, step > 0.0 ? (whole * printed / count - passed) / step : 0.0);
            printf("%s\t%s\t%.9g\t%.9g\t%.9g\n", s->bone, s->area, p.x, p.y, p.z);
        }
        passed += step;
    }
}

static sn_status grow(const muscle *m, int which, double radius, int count, sn_error *error) {
    const site *s = &m->sites[which];
    loop line = {SN_NEW(sn_vec3, m->mesh.triangle_count), 0};
    int pieces = 0;
    double r = free_radius(m, which, radius);
    sn_status status = line.points ? SN_OK : sn_fail_memory(error, "a boundary");
    for (; !status; r *= SHRINK) {
        if (r < LEAST * radius)
            status = sn_fail(error, SN_ERROR_INPUT, "%s on %s: no radius above %g leaves a boundary of one piece, apart from other sites",
                             s->area, s->bone, LEAST * radius);
        else if (boundary(m, s->distance, r, &pieces, &line))
            status = sn_fail(error, SN_ERROR_INPUT, "the surface is not closed near %s on %s; mesh-clean closes it", s->area, s->bone);
        if (!status && pieces == 1 && line.count >= 3) break;
    }
    if (!status) {
        print_landmarks(s, &line, count);
        fprintf(stderr, "areas: %s on %s: radius %.4g\n", s->area, s->bone, r);
    }
    free(line.points);
    return status;
}

/* ---- the program ---------------------------------------------------------------------------------------------------------------- */

/* A length; a share of the muscle's length, "8%"; or that and what it is at most, "8%,0.01". */
static sn_status parse_radius(const char *text, double length, double *radius, sn_error *error) {
    char number[64];
    double most = INFINITY;
    const char *share = strchr(text, '%');
    snprintf(number, sizeof number, "%.*s", (int)(share ? share - text : (long)strlen(text)), text);
    if (sn_parse_number(number, radius, error)) return SN_ERROR_INPUT;
    if (share && share[1] == ',' && sn_parse_number(share + 2, &most, error)) return SN_ERROR_INPUT;
    if (share && share[1] != ',' && share[1] != '\0')
        return sn_fail(error, SN_ERROR_INPUT, "the radius %s: write 0.01, 8%% or 8%%,0.01", text);
    if (share) *radius = fmin(most, 0.01 * *radius * length);
    return *radius > 0.0 ? SN_OK : sn_fail(error, SN_ERROR_INPUT, "the radius %s must be above 0", text);
}

int main(int argc, char **argv) {
    static muscle m;
    sn_error error = {0};
    int64_t landmarks = LANDMARKS;
    double radius = 0.0;
    if ((argc != 4 && argc != 5) || (argc == 5 && sn_parse_integer(argv[4], 3, 1000, &landmarks, &error))) {
        fprintf(stderr, "Usage: areas SURFACE SITES.tsv RADIUS [LANDMARKS]\n");
        return 2;
    }
    sn_status status = sn_mesh_read(argv[1], &m.mesh, NULL, &error);
    if (status) sn_error_set_file(&error, argv[1]);
    if (!status) status = read_sites(argv[2], &m, &error);
    if (!status) status = sn_topology_build(&m.mesh, &m.topology, &error);
    if (!status) status = measure_sites(&m, &error);
    if (!status) status = parse_radius(argv[3], m.length, &radius, &error);
    for (int i = 0; i < m.count && !status; i++) status = grow(&m, i, radius, (int)landmarks, &error);
    if (status) fprintf(stderr, "areas: %s%s%s\n", error.file, error.file[0] ? ": " : "", error.text);
    for (int i = 0; i < m.count; i++) free(m.sites[i].distance);
    sn_topology_free(&m.topology);
    sn_mesh_free(&m.mesh);
    return status ? 1 : fflush(stdout) == 0 ? 0 : 1;
}
