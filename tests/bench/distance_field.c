/*
 * distance_field.c -- what the distance fields of the leg's bones cost at cells of 2 mm: seconds of the processor and of the clock to build
 * them, on one thread and on all; megabytes; nanoseconds for a query of value and gradient at random points within three cells of the
 * surface, one by one and many at once; and of the cheap reject at points in rows through the box. make field-time; prints a table.
 */
#include "../numerics/field_bones.h"

enum { QUERIES = 1 << 20 };

static const bone bones[] = {
#define LEG(name)                                                                                                                          \
    { "leg-vhf/meshes/VHF_Left_Bone_" name "_smooth.ply", 1e-3, 2e-3 }
    LEG("Calcaneous"),
    LEG("Coccyx"),
    LEG("Cuboid"),
    LEG("Fibula"),
    LEG("IntermediateCuneiform"),
    LEG("LateralCuneiform"),
    LEG("MedialCuneiform"),
    LEG("Navicular"),
    LEG("Patella"),
    LEG("Sacrum"),
    LEG("Talus"),
    LEG("Tibia"),
};

typedef struct times {
    double one, many, farther; /* ns a query */
    double far_share;          /* of points in the box that are rejected at 6 mm */
} times;

static double nanoseconds(double started) { return 1e9 * (seconds(CLOCK_PROCESS_CPUTIME_ID) - started) / QUERIES; }

static times time_queries(const sn_distance_field *f, const sn_mesh *mesh) {
    sn_vec3 *points = malloc(QUERIES * sizeof *points), *gradients = malloc(QUERIES * sizeof *gradients), g;
    double *values = malloc(QUERIES * sizeof *values), sum = 0.0;
    uint64_t state = 1;
    times t;
    sn_box box = sn_distance_field_box(f);
    if (points == NULL || gradients == NULL || values == NULL) exit(1);
    for (sn_index i = 0; i < QUERIES; i++) {
        points[i] = point_near(mesh, 3.0 * f->cell, &state);
        gradients[i] = points[i];
        values[i] = 0.0;
    }
    double started = seconds(CLOCK_PROCESS_CPUTIME_ID);
    for (sn_index i = 0; i < QUERIES; i++) sum += sn_distance_field_at(f, points[i], &g) + g.x;
    t.one = nanoseconds(started);
    started = seconds(CLOCK_PROCESS_CPUTIME_ID);
    sn_distance_field_at_all(f, QUERIES, points, values, gradients);
    t.many = nanoseconds(started);
    sn_vec3 size = sn_sub(box.high, box.low);
    for (sn_index i = 0; i < QUERIES; i++) { /* rows, as vertices of a mesh lie beside each other: at random it takes 20 to 35 ns */
        sn_vec3 share = sn_v3((i % 1024) / 1024.0, (i / 1024 % 32) / 32.0, (i / 32768) / 32.0);
        points[i] = sn_add(box.low, sn_v3(size.x * share.x, size.y * share.y, size.z * share.z));
    }
    sn_index far = 0;
    started = seconds(CLOCK_PROCESS_CPUTIME_ID);
    for (sn_index i = 0; i < QUERIES; i++) far += sn_distance_field_farther(f, points[i], 6e-3);
    t.farther = nanoseconds(started);
    t.far_share = (double)far / QUERIES;
    if (!isfinite(sum)) printf("not finite\n");
    free(points);
    free(gradients);
    free(values);
    return t;
}

static void build(const sn_mesh *mesh, double cell, sn_pool *pool, sn_distance_field *out) {
    sn_distance_field_params params = sn_distance_field_defaults(cell);
    sn_error error = {0};
    params.pool = pool;
    if (sn_distance_field_create(mesh, &params, out, &error) == SN_OK) return;
    fprintf(stderr, "%s\n", error.text);
    exit(1);
}

static void print_row(const char *data, const bone *b, sn_pool *pool) {
    sn_mesh mesh;
    sn_distance_field field;
    if (!bone_read(data, b, &mesh)) exit(0);
    double work = seconds(CLOCK_PROCESS_CPUTIME_ID);
    build(&mesh, b->cell, NULL, &field);
    work = seconds(CLOCK_PROCESS_CPUTIME_ID) - work;
    sn_distance_field_free(&field);
    double wall = seconds(CLOCK_MONOTONIC);
    build(&mesh, b->cell, pool, &field);
    wall = seconds(CLOCK_MONOTONIC) - wall;
    times t = time_queries(&field, &mesh);
    printf("%-58s %9d %6d %7.2f %8.2f %8.2f %7.1f %7.1f %7.1f %5.0f\n", b->file, mesh.triangle_count, field.brick_count,
           1e-6 * (double)sn_distance_field_bytes(&field), work, wall, t.one, t.many, t.farther, 100.0 * t.far_share);
    sn_distance_field_free(&field);
    sn_mesh_free(&mesh);
}

int main(int argc, char **argv) {
    const char *data = getenv("DATA") != NULL ? getenv("DATA") : "../shared/data";
    double cell = argc > 1 ? strtod(argv[1], NULL) : 0.0;
    sn_pool *pool = sn_pool_create(0);
    printf("%-58s %9s %6s %7s %8s %8s %7s %7s %7s %5s\n", "bone", "triangles", "bricks", "MB", "1 core s", "wall s", "ns one", "ns many",
           "ns far", "far %");
    for (size_t i = 0; i < sizeof bones / sizeof *bones; i++) {
        bone b = bones[i];
        if (cell > 0.0) b.cell = cell;
        print_row(data, &b, pool);
    }
    sn_pool_destroy(pool);
    return 0;
}
