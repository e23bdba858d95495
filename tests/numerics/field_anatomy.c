/*
 * field_anatomy.c -- distance fields of real bones against distances by brute force: field_anatomy [POINTS]
 *
 * Bones that are clean, of many pieces that overlap, doubled, open, inside out, badly wound and crossing themselves. At POINTS (default
 * 300; make field-anatomy takes 12,000) random points within three cells of the surface of each, value and sign are compared with the least
 * distance over all triangles in double, by a closest point of its own, and with a winding number that adds up arc tangents of the C
 * library. For a clean bone both are taken of the mesh as it is in the file. For the others "the distance" needs a word on what is solid:
 * it is that to the boundary of sn_solid_surface, whose triangles are held against the file's, and the signs are compared with the winding
 * number of the file's own triangles besides.
 *
 * Nine in ten values must be within 0.1 cells, all within 0.5; at most 1 % of the signs may be wrong (3 % of few points), all of these
 * within 0.3 cells of the surface. Where the side that a point is on is thin, at edges like knives and in crevices, no table of distances
 * at corners shows it: no point within a cell is 0.75 cells from the surface there. These are counted apart, and held to 0.5 cells. Points
 * deep inside must come out by steps of value along gradient. Thin bones get smaller cells.
 */
#include "field_bones.h"

#include <math.h>
#include <string.h>

enum { SHORT = 1000 }; /* points of a short form: fewer than this */

typedef struct subject {
    bone bone;
    bool clean; /* closed, oriented, one piece that does not cross itself, by the data's manifest */
    bool large; /* left out of the short form */
} subject;

#define LEG(name) "leg-vhf/meshes/VHF_Left_Bone_" name "_smooth.ply"
#define DOG(name) "dog-dmcontrol/meshes/BONE" name ".stl"
#define LOW(name) "body-bp3d-low/meshes/" name ".obj"
#define GAIT(name) "gait-opensim/meshes/" name ".vtp"
static const subject subjects[] = {
    {{LEG("Tibia"), 1e-3, 2e-3}, true, false},
    {{LEG("Fibula"), 1e-3, 2e-3}, true, false},
    {{LEG("Sacrum"), 1e-3, 2e-3}, true, false},
    {{LEG("Calcaneous"), 1e-3, 2e-3}, true, false},
    {{LEG("Patella"), 1e-3, 2e-3}, true, false},
    {{DOG("Pelvis"), 1.0, 1e-3}, true, false},
    {{DOG("Scapula_L"), 1.0, 1e-3}, true, false},
    {{DOG("Femoris_L"), 1.0, 1e-3}, true, false},
    {{LOW("FJ40_Right_femur"), 1e-3, 2e-3}, true, false},
    {{LOW("FJ30_Left_hip_bone"), 1e-3, 2e-3}, true, false},
    {{LOW("FJ27_Left_scapula"), 1e-3, 1e-3}, true, false},
    {{GAIT("femur_r"), 1.0, 2e-3}, true, false},
    {{DOG("Ribcage"), 1.0, 1e-3}, false, false},               /* 74 pieces, 3396 triangles twice */
    {{DOG("MergedSkull"), 1.0, 4e-4}, false, true},            /* 23 pieces, crossing */
    {{DOG("Jaw"), 1.0, 5e-4}, false, true},                    /* 23 pieces, crossing */
    {{DOG("Xiphoid_cartilage"), 1.0, 2.5e-4}, false, false},   /* every triangle twice */
    {{LOW("FJ495_Right_scapula"), 1e-3, 1e-3}, false, false},  /* crosses itself */
    {{LOW("FJ607_Frontal_bone"), 1e-3, 1e-3}, false, false},   /* open, crossing */
    {{LOW("FJ803_Occipital_bone"), 1e-3, 5e-4}, false, false}, /* not manifold, crossing */
    {{GAIT("hat_ribs"), 1.0, 1e-3}, false, false},             /* 25 pieces, crossing */
    {{GAIT("hat_skull"), 1.0, 1e-3}, false, false},            /* 6 holes, badly wound edges, 473 crossings */
    {{GAIT("arm_r_humerus"), 1.0, 2e-3}, false, false},        /* 6 holes */
    {{GAIT("arm_r_radius"), 1.0, 1e-3}, false, false},         /* 3 holes, inside out */
    {{GAIT("ground_r_scapula"), 1.0, 1e-3}, false, false},     /* 5 holes */
    {{GAIT("pelvis"), 1.0, 2e-3}, false, false},               /* 4 holes */
};

/* ---- by brute force ------------------------------------------------------------------------------------------------------------ */

static double segment_distance(sn_vec3 p, sn_vec3 a, sn_vec3 b) {
    sn_vec3 ab = sn_sub(b, a);
    double t = sn_dot(sn_sub(p, a), ab) / fmax(sn_dot(ab, ab), 1e-300);
    return sn_distance(p, sn_add_scaled(a, ab, fmin(1.0, fmax(0.0, t))));
}

/* The height over the triangle where the foot is in it, else the distance to the nearest side. */
static double triangle_distance(sn_vec3 p, sn_vec3 a, sn_vec3 b, sn_vec3 c) {
    sn_vec3 n = sn_area_vector(a, b, c);
    double area2 = sn_norm2(n);
    if (area2 > 0.0 && sn_dot(n, sn_cross(sn_sub(b, a), sn_sub(p, a))) > 0.0 && sn_dot(n, sn_cross(sn_sub(c, b), sn_sub(p, b))) > 0.0 &&
        sn_dot(n, sn_cross(sn_sub(a, c), sn_sub(p, c))) > 0.0)
        return fabs(sn_dot(sn_sub(p, a), n)) / sqrt(area2);
    return fmin(segment_distance(p, a, b), fmin(segment_distance(p, b, c), segment_distance(p, c, a)));
}

static double brute_distance(const sn_mesh *mesh, sn_index count, sn_vec3 p) {
    double best = INFINITY;
    for (sn_index t = 0; t < count; t++) {
        const sn_vec3 *q = mesh->positions;
        const sn_index *v = mesh->triangles[t].v;
        sn_vec3 a = q[v[0]], low = sn_min3(a, sn_min3(q[v[1]], q[v[2]])), high = sn_max3(a, sn_max3(q[v[1]], q[v[2]]));
        if (low.x - p.x > best || p.x - high.x > best || low.y - p.y > best || p.y - high.y > best) continue;
        best = fmin(best, triangle_distance(p, a, q[v[1]], q[v[2]]));
    }
    return best;
}

static double brute_winding(const sn_mesh *mesh, sn_vec3 p) {
    double sum = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) {
        const sn_index *v = mesh->triangles[t].v;
        sn_vec3 a = sn_sub(mesh->positions[v[0]], p), b = sn_sub(mesh->positions[v[1]], p), c = sn_sub(mesh->positions[v[2]], p);
        double x = sn_norm(a), y = sn_norm(b), z = sn_norm(c);
        sum += 2.0 * atan2(sn_dot(a, sn_cross(b, c)), x * y * z + sn_dot(a, b) * z + sn_dot(b, c) * x + sn_dot(c, a) * y);
    }
    return sum / (4.0 * SN_PI);
}

/* ---- one bone -------------------------------------------------------------------------------------------------------------------- */

typedef struct outcome {
    double error90, worst;        /* cells: nine in ten points are below it; the largest */
    double wrong_share, wrong_at; /* of signs; the farthest of these from the surface, in cells */
    double thin_at;               /* the same of those on a side that is thin */
    double agree;                 /* share of signs that are those of the file's own triangles */
    double stuck, unexplained;    /* share of deep points that do not come out; of the file's triangles that the solid lost */
    sn_index near, deep;          /* points that were looked at */
} outcome;

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

typedef struct trial {
    const sn_distance_field *field;
    const sn_mesh *file, *solid; /* as read; the closed one */
    sn_index boundary;           /* triangles of solid that bound it */
    bool clean;
    uint64_t random;
} trial;

/* A random point of the bricks, all of their volume alike. */
static sn_vec3 point_in_bricks(trial *t) {
    const sn_distance_field *f = t->field;
    sn_index brick;
    do { brick = (sn_index)(sn_random(&t->random) * f->bricks[0] * f->bricks[1] * f->bricks[2]); } while (f->brick[brick] == SN_NONE);
    const sn_index *n = f->bricks, at[3] = {brick % n[0], brick / n[0] % n[1], brick / n[0] / n[1]};
    double width = SN_BRICK_CELLS * f->cell, x = at[0] + sn_random(&t->random), y = at[1] + sn_random(&t->random);
    return sn_add(f->origin, sn_scale(sn_v3(x, y, at[2] + sn_random(&t->random)), width));
}

static double true_distance(const trial *t, sn_vec3 p) {
    return t->clean ? brute_distance(t->file, t->file->triangle_count, p) : brute_distance(t->solid, t->boundary, p);
}

/* Distance to the boundary, negative inside. */
static double truth(const trial *t, sn_vec3 p) {
    double distance = true_distance(t, p);
    return fabs(brute_winding(t->clean ? t->file : t->solid, p)) > 0.5 ? -distance : distance;
}

/* Is no point within a cell of p 0.75 cells or more from the surface on the same side? */
static bool is_thin(const trial *t, sn_vec3 p, bool inside) {
    double cell = t->field->cell;
    uint64_t random = 1;
    for (int i = 0; i < 300; i++) {
        sn_vec3 d = sn_v3(2.0 * sn_random(&random) - 1.0, 2.0 * sn_random(&random) - 1.0, 2.0 * sn_random(&random) - 1.0);
        if (sn_norm2(d) > 1.0) continue;
        double exact = truth(t, sn_add_scaled(p, d, cell));
        if ((inside ? -exact : exact) >= 0.75 * cell) return false;
    }
    return true;
}

static void compare_near(trial *t, sn_index points, outcome *out) {
    double cell = t->field->cell, *errors = calloc((size_t)points, sizeof *errors);
    sn_index wrong = 0, agree = 0;
    if (errors == NULL) exit(1);
    while (out->near < points) {
        sn_vec3 p = point_in_bricks(t);
        if (true_distance(t, p) > 3.0 * cell) continue;
        double exact = truth(t, p), depth = fabs(exact) / cell, phi = sn_distance_field_at(t->field, p, NULL);
        errors[out->near++] = fabs(phi - exact) / cell;
        agree += (phi < 0.0) == (t->clean ? exact < 0.0 : fabs(brute_winding(t->file, p)) > 0.5);
        if ((phi < 0.0) == (exact < 0.0)) continue;
        wrong++;
        double *at = depth > 0.3 && is_thin(t, p, exact < 0.0) ? &out->thin_at : &out->wrong_at;
        *at = fmax(*at, depth);
    }
    qsort(errors, (size_t)points, sizeof *errors, by_size);
    out->error90 = errors[points * 9 / 10];
    out->worst = errors[points - 1];
    out->wrong_share = (double)wrong / points;
    out->agree = (double)agree / points;
    free(errors);
}

/* Steps of phi along the gradient, as a solver makes them: each no longer than |phi|. Crevices narrower than a cell are not seen: what
 * comes to the surface there, to the 0.3 cells that signs may be wrong by, has come out. */
static bool comes_out(const trial *t, sn_vec3 p) {
    const sn_distance_field *f = t->field;
    for (int i = 0; i < 100; i++) {
        sn_vec3 g;
        double phi = sn_distance_field_at(f, p, &g), slope = fmax(sn_norm(g), 1.0);
        if (phi > -0.01 * f->cell) return true;
        p = sn_add_scaled(p, g, (0.01 * f->cell - phi) / (slope * slope));
    }
    return brute_distance(t->solid, t->boundary, p) <= 0.3 * f->cell;
}

static void try_deep(trial *t, sn_index points, outcome *out) {
    sn_box box = t->field->box;
    sn_vec3 size = sn_sub(box.high, box.low);
    sn_index stuck = 0;
    for (sn_index i = 0; i < 1000 * points && out->deep < points; i++) {
        sn_vec3 p = sn_v3(size.x * sn_random(&t->random), size.y * sn_random(&t->random), size.z * sn_random(&t->random));
        p = sn_add(box.low, p);
        if (sn_distance_field_at(t->field, p, NULL) > -t->field->cell) continue;
        out->deep++;
        stuck += !comes_out(t, p);
    }
    out->stuck = out->deep > 0 ? (double)stuck / out->deep : 0.0;
}

/* A triangle of the file that is not on the boundary of the solid must be within it. */
static void explain_triangles(trial *t, sn_index points, outcome *out) {
    sn_index lost = 0;
    double tiny = 1e-6 * sn_box_diagonal(t->field->box);
    for (sn_index i = 0; i < points; i++) {
        const sn_index *v = t->file->triangles[(sn_index)(sn_random(&t->random) * t->file->triangle_count)].v;
        sn_vec3 sum = sn_add(t->file->positions[v[0]], sn_add(t->file->positions[v[1]], t->file->positions[v[2]]));
        sn_vec3 centre = sn_scale(sum, 1.0 / 3.0);
        if (brute_distance(t->solid, t->boundary, centre) <= tiny) continue;
        sn_vec3 area = sn_area_vector(t->file->positions[v[0]], t->file->positions[v[1]], t->file->positions[v[2]]);
        sn_vec3 side = sn_scale(sn_normalize(area), 1e-3 * sqrt(0.5 * sn_norm(area))); /* crevices narrower than that are solid */
        lost += fabs(brute_winding(t->solid, sn_add(centre, side))) < 0.5 || fabs(brute_winding(t->solid, sn_sub(centre, side))) < 0.5;
    }
    out->unexplained = (double)lost / points;
}

/* Signs that may be wrong: of few points chance takes its share. */
static const double WRONG = 0.01, WRONG_OF_FEW = 0.03;
enum { FEW = 10000 };

static bool judge(const subject *s, const outcome *o, sn_index points) {
    double most = points < FEW ? WRONG_OF_FEW : WRONG;
    bool good =
        o->near == points && o->error90 <= 0.1 && o->worst <= 0.5 && o->wrong_share <= most && o->wrong_at <= 0.3 && o->thin_at <= 0.5;
    good = good && o->stuck <= 0.01 && o->unexplained <= 0.002;
    return good && (!s->clean || o->agree >= 1.0 - most);
}

static bool try_bone(const char *data, const subject *s, sn_index points, sn_pool *pool) {
    sn_mesh file, solid;
    sn_distance_field field;
    sn_solid_report report;
    sn_error error = {0};
    sn_distance_field_params params = sn_distance_field_defaults(s->bone.cell);
    outcome o = {0};
    if (!bone_read(data, &s->bone, &file)) return true;
    params.pool = pool;
    double started = seconds(CLOCK_PROCESS_CPUTIME_ID);
    if (sn_distance_field_create(&file, &params, &field, &error) != SN_OK ||
        sn_solid_surface(&file, pool, &solid, &report, &error) != SN_OK) {
        printf("%s: %s\n", s->bone.file, error.text);
        return false;
    }
    started = seconds(CLOCK_PROCESS_CPUTIME_ID) - started;
    trial t = {&field, &file, &solid, report.boundary_triangles, s->clean, 1};
    compare_near(&t, points, &o);
    try_deep(&t, points, &o);
    explain_triangles(&t, points < SHORT ? points : SHORT, &o);
    bool good = judge(s, &o, points);
    printf("%-48s %4.1f %6d %5.1f %4d %5d %3d%s %6.3f %6.3f %6.2f %5.2f %5.2f %6.2f %6.2f %6.2f%s\n", s->bone.file, 1e3 * s->bone.cell,
           file.triangle_count, started, report.caps, report.inner_triangles, report.turned, report.inside_out ? "*" : " ", o.error90,
           o.worst, 100 * o.wrong_share, o.wrong_at, o.thin_at, 100 * o.agree, 100 * o.stuck, 100 * o.unexplained, good ? "" : "  FAILED");
    sn_distance_field_free(&field);
    sn_mesh_free(&solid);
    sn_mesh_free(&file);
    return good;
}

int main(int argc, char **argv) {
    const char *data = getenv("DATA") != NULL ? getenv("DATA") : "../shared/data";
    sn_index points = argc > 1 ? (sn_index)strtol(argv[1], NULL, 10) : 200;
    const char *only = argc > 2 ? argv[2] : "";
    int passed = 0, failed = 0;
    sn_pool *pool = sn_pool_create(0);
    setvbuf(stdout, NULL, _IOLBF, 0);
    if (points < 10) points = 10;
    printf("%-48s %4s %6s %5s %4s %5s %4s %6s %6s %6s %5s %5s %6s %6s %6s\n", "bone", "mm", "tris", "cpu s", "caps", "inner", "turn",
           "err90", "worst", "sign%", "at", "thin", "file%", "stuck%", "lost%");
    for (size_t i = 0; i < sizeof subjects / sizeof *subjects; i++) {
        if (strstr(subjects[i].bone.file, only) == NULL || (subjects[i].large && points < SHORT)) continue;
        if (try_bone(data, &subjects[i], points, pool))
            passed++;
        else
            failed++;
    }
    sn_pool_destroy(pool);
    printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}
