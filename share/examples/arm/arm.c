/*
 * arm.c -- generate the sample arm: scapula (the part around the shoulder joint), humerus, ulna, radius; biceps, brachialis, triceps.
 *
 * Every body is a smooth union of tubes (anatomy.h, shape.h), polygonised (polygonise.h) and remeshed to the edge length asked for
 * (remesh.h): closed, clean, outward, of genus 0. Metres, z up. The same options give the same bytes.
 */
#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "polygonise.h"
#include "remesh.h"
#include "sinew/io.h"

static const char *const usage =
    "Usage: arm --out DIR [OPTION]...\n"
    "Generate a sample arm: scapula, humerus, ulna, radius, biceps, brachialis and triceps as DIR/NAME.ply.\n\n"
    "  -o, --out DIR            the folder to write to; made if it is not there\n"
    "  -t, --triangles N        about N triangles for the biceps, the others in proportion (1000 to 2000000; default 4000)\n"
    "  -r, --resolution LENGTH  edge length of all surfaces instead: 3mm, 0.003, ...\n"
    "  -d, --dirty              write DIR/biceps-dirty.obj too: the biceps with cracks, duplicate and flipped\n"
    "                           triangles, a hole and a loose shell\n"
    "  -h, --help               print this and exit\n"
    "      --version            print the version and exit\n";

typedef struct options {
    const char *folder;
    int64_t triangles;
    double resolution; /* m; 0 = from triangles */
    bool dirty;
} options;

/* ---- surfaces ------------------------------------------------------------------------------------------------------- */

/* Fine enough for the thinnest tendon (8 mm); finer surfaces are split out of this one. */
static const double polygonise_step = 2.5e-3; /* m */
static const double shortest_edge = 1e-4, longest_edge = 1.2e-2;

/* How many triangles remeshing to `edge` gives: the area over that of equilateral triangles whose edges are a little longer than aimed
 * at (a measured ratio). */
static double expected_triangles(const shape *s, const sn_mesh *mesh, double edge) {
    const double mean_over_aim = 1.04;
    double count = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        double local = mean_over_aim * fmin(edge, shape_edge_limit(s, mesh->positions[v[0]]));
        double area = 0.5 * sn_norm(sn_area_vector(mesh->positions[v[0]], mesh->positions[v[1]], mesh->positions[v[2]]));
        count += area / (0.25 * sqrt(3.0) * local * local);
    }
    return count;
}

/* Edge length for about `triangles` triangles, by bisection. */
static double edge_for_triangles(const shape *s, const sn_mesh *mesh, double triangles) {
    double low = shortest_edge, high = longest_edge;
    for (int i = 0; i < 24; i++) {
        double middle = 0.5 * (low + high);
        if (expected_triangles(s, mesh, middle) > triangles)
            low = middle;
        else
            high = middle;
    }
    return high;
}

/* A surface finer than the lattice is made from a good one as coarse as the lattice: slivers would fold when they are refined. */
static sn_status make_surface(const arm_body *body, double edge, sn_mesh *out, sn_error *error) {
    shape s;
    shape_build(body, &s);
    sn_status status = polygonise(&s, polygonise_step, out, error);
    if (status == SN_OK && edge < polygonise_step) status = remesh(&s, polygonise_step, out, error);
    return status == SN_OK ? remesh(&s, edge, out, error) : status;
}

static const arm_body *find_body(const char *name) {
    const arm_body *body = arm_bodies;
    while (strcmp(body->name, name) != 0) body++;
    return body;
}

static sn_status choose_edge(const options *o, double *edge, sn_error *error) {
    shape s;
    sn_mesh biceps = {0};
    *edge = o->resolution;
    if (*edge > 0.0) return SN_OK;
    shape_build(find_body("biceps"), &s);
    sn_status status = polygonise(&s, polygonise_step, &biceps, error);
    if (status == SN_OK) *edge = edge_for_triangles(&s, &biceps, (double)o->triangles);
    sn_mesh_free(&biceps);
    return status;
}

static sn_status write_mesh(const char *folder, const char *name, const sn_mesh *mesh, sn_error *error) {
    char path[4096];
    sn_output *output = NULL;
    if (snprintf(path, sizeof path, "%s/%s", folder, name) >= (int)sizeof path)
        return sn_fail(error, SN_ERROR_USAGE, "the name of the folder is too long; choose a shorter one");
    sn_status status = sn_output_open(path, false, &output, error);
    if (status == SN_OK) status = sn_mesh_write(mesh, sn_mesh_format_from_name(path), SN_ENCODING_DEFAULT, output, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

/* ---- the dirty copy --------------------------------------------------------------------------------------------------- */

/* A mesh that grows. */
typedef struct soup {
    sn_vec3 *positions;
    sn_triangle *triangles;
    size_t vertex_count, vertex_capacity, triangle_count, triangle_capacity;
} soup;

static bool soup_vertex(soup *s, sn_vec3 p, sn_index *index) {
    if (!sn_grow((void **)&s->positions, &s->vertex_capacity, s->vertex_count + 1, sizeof *s->positions)) return false;
    *index = (sn_index)s->vertex_count;
    s->positions[s->vertex_count++] = p;
    return true;
}

static bool soup_triangle(soup *s, sn_index a, sn_index b, sn_index c) {
    if (!sn_grow((void **)&s->triangles, &s->triangle_capacity, s->triangle_count + 1, sizeof *s->triangles)) return false;
    s->triangles[s->triangle_count++] = (sn_triangle){{a, b, c}};
    return true;
}

static bool above(const sn_mesh *mesh, sn_index t, double z) {
    const sn_index *v = mesh->triangles[t].v;
    return mesh->positions[v[0]].z + mesh->positions[v[1]].z + mesh->positions[v[2]].z > 3.0 * z;
}

/* Cracks: the triangles of the upper half get vertices of their own along the seam (copy[old], SN_NONE = none yet), off by 1e-7 of the
 * size: open until they are welded. */
static bool add_cracked_surface(soup *s, const sn_mesh *mesh, sn_index *copy) {
    sn_box box = sn_mesh_box(mesh);
    double middle = 0.5 * (box.low.z + box.high.z), gap = 1e-7 * sn_box_diagonal(box);
    uint64_t random = 1;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        sn_index corner[3], side = above(mesh, t, middle) ? mesh->vertex_count : 0;
        for (int i = 0; i < 3; i++) {
            sn_index *index = &copy[mesh->triangles[t].v[i] + side];
            sn_vec3 off = sn_v3(sn_random(&random) - 0.5, sn_random(&random) - 0.5, sn_random(&random) - 0.5);
            sn_vec3 position = sn_add_scaled(mesh->positions[mesh->triangles[t].v[i]], off, side ? gap : 0.0);
            if (*index == SN_NONE && !soup_vertex(s, position, index)) return false;
            corner[i] = *index;
        }
        if (!soup_triangle(s, corner[0], corner[1], corner[2])) return false;
    }
    return true;
}

/* A hole: the triangles around one vertex go. */
static void cut_hole(soup *s, sn_index vertex) {
    size_t kept = 0;
    for (size_t t = 0; t < s->triangle_count; t++) {
        const sn_index *v = s->triangles[t].v;
        if (v[0] != vertex && v[1] != vertex && v[2] != vertex) s->triangles[kept++] = s->triangles[t];
    }
    s->triangle_count = kept;
}

/* Every 40th triangle turned over, every 50th there twice. */
static bool flip_and_repeat(soup *s) {
    size_t count = s->triangle_count;
    for (size_t t = 0; t < count; t++) {
        sn_index *v = s->triangles[t].v, first = v[0];
        if (t % 40 == 7) { v[0] = v[1], v[1] = first; }
        if (t % 50 == 11 && !soup_triangle(s, s->triangles[t].v[0], s->triangles[t].v[1], s->triangles[t].v[2])) return false;
    }
    return true;
}

/* A loose shell: an octahedron of 2 mm beside the muscle, as a scan leaves them. */
static bool add_loose_shell(soup *s, sn_vec3 centre) {
    static const int faces[8][3] = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    const double radius = 2e-3;
    const sn_vec3 axes[3] = {{radius, 0, 0}, {0, radius, 0}, {0, 0, radius}};
    sn_index corner[6];
    for (int i = 0; i < 6; i++)
        if (!soup_vertex(s, sn_add_scaled(centre, axes[i / 2], i % 2 ? -1.0 : 1.0), &corner[i])) return false;
    for (int i = 0; i < 8; i++)
        if (!soup_triangle(s, corner[faces[i][0]], corner[faces[i][1]], corner[faces[i][2]])) return false;
    return true;
}

/* The vertex farthest forward: in the middle of the belly. */
static sn_index front_vertex(const soup *s) {
    sn_index best = 0;
    for (sn_index i = 1; i < (sn_index)s->vertex_count; i++)
        if (s->positions[i].x > s->positions[best].x) best = i;
    return best;
}

static bool make_dirty(soup *s, const sn_mesh *clean, sn_index *copy) {
    for (sn_index i = 0; i < 2 * clean->vertex_count; i++) copy[i] = SN_NONE;
    if (!add_cracked_surface(s, clean, copy)) return false;
    sn_index front = front_vertex(s);
    cut_hole(s, front);
    return flip_and_repeat(s) && add_loose_shell(s, sn_add(s->positions[front], sn_v3(0.02, 0, 0)));
}

static sn_status write_dirty(const char *folder, const char *name, const sn_mesh *clean, sn_error *error) {
    soup s = {0};
    sn_index *copy = SN_NEW(sn_index, 2 * (size_t)clean->vertex_count);
    sn_status status = copy && make_dirty(&s, clean, copy) ? SN_OK : sn_fail_memory(error, "the dirty copy");
    sn_mesh dirty = {.vertex_count = (sn_index)s.vertex_count,
                     .triangle_count = (sn_index)s.triangle_count,
                     .positions = s.positions,
                     .triangles = s.triangles};
    if (status == SN_OK) status = write_mesh(folder, name, &dirty, error);
    free(copy);
    sn_mesh_free(&dirty);
    return status;
}

/* ---- the command -------------------------------------------------------------------------------------------------------- */

static sn_status generate_body(const options *o, const arm_body *body, double edge, sn_error *error) {
    char file[64];
    sn_mesh mesh = {0};
    snprintf(file, sizeof file, "%s.ply", body->name);
    sn_status status = make_surface(body, edge, &mesh, error);
    if (status == SN_OK) status = write_mesh(o->folder, file, &mesh, error);
    if (status == SN_OK && o->dirty && strcmp(body->name, "biceps") == 0) status = write_dirty(o->folder, "biceps-dirty.obj", &mesh, error);
    sn_mesh_free(&mesh);
    return status;
}

static sn_status generate(const options *o, sn_error *error) {
    double edge;
    if (mkdir(o->folder, 0777) != 0 && errno != EEXIST)
        return sn_fail_at(error, SN_ERROR_IO, o->folder, 0, "cannot make this folder: %s", strerror(errno));
    sn_status status = choose_edge(o, &edge, error);
    for (int i = 0; i < ARM_BODY_COUNT && status == SN_OK; i++) status = generate_body(o, &arm_bodies[i], edge, error);
    return status;
}

_Noreturn static void wrong_usage(const sn_error *error) {
    if (error)
        fprintf(stderr, "arm: %s; see arm --help\n", error->text);
    else
        fputs("arm: wrong usage; see arm --help\n", stderr);
    exit(2);
}

static double parse_resolution(const char *text) {
    sn_error error = {0};
    sn_length length;
    if (sn_parse_length(text, &length, &error) != SN_OK) wrong_usage(&error);
    double meters = sn_length_meters(length, 1.0);
    if (!(meters >= shortest_edge && meters <= longest_edge)) {
        (void)sn_fail(&error, SN_ERROR_USAGE, "--resolution %s is not between 0.1mm and 12mm", text);
        wrong_usage(&error);
    }
    return meters;
}

static options parse(int argc, char **argv) {
    static const struct option known[] = {{"out", required_argument, NULL, 'o'},
                                          {"triangles", required_argument, NULL, 't'},
                                          {"resolution", required_argument, NULL, 'r'},
                                          {"dirty", no_argument, NULL, 'd'},
                                          {"help", no_argument, NULL, 'h'},
                                          {"version", no_argument, NULL, 'V'},
                                          {0}};
    options o = {.triangles = 4000};
    sn_error error = {0};
    for (int c; (c = getopt_long(argc, argv, "o:t:r:dh", known, NULL)) != -1;) {
        if (c == 'o')
            o.folder = optarg;
        else if (c == 't' && sn_parse_integer(optarg, 1000, 2000000, &o.triangles, &error) != SN_OK)
            wrong_usage(&error);
        else if (c == 'r')
            o.resolution = parse_resolution(optarg);
        else if (c == 'd')
            o.dirty = true;
        else if (c == 'h')
            exit(fputs(usage, stdout) < 0 || fclose(stdout) != 0);
        else if (c == 'V')
            exit(puts("arm (sinew) " SN_VERSION) < 0 || fclose(stdout) != 0);
        else if (c == '?')
            exit(2);
    }
    if (!o.folder)
        (void)sn_fail(&error, SN_ERROR_USAGE, "where to? name a folder with --out");
    else if (optind < argc)
        (void)sn_fail(&error, SN_ERROR_USAGE, "'%s' is not an option", argv[optind]);
    if (!o.folder || optind < argc) wrong_usage(&error);
    return o;
}

int main(int argc, char **argv) {
    options o = parse(argc, argv);
    sn_error error = {0};
    if (generate(&o, &error) == SN_OK) return 0;
    fprintf(stderr, "arm: %s%s%s\n", error.file, error.file[0] ? ": " : "", error.text);
    return 1;
}
