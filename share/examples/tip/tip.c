/*
 * tip.c -- generate the moving-tip problem, the yardstick by which solvers are compared: a fusiform muscle, one end of it held, the
 * other carried along an arc to 90 degrees.
 *
 * The muscle is a closed shell of staggered rings around the z axis, radius R sin(pi s)^0.8, L = 0.2 m, R = 0.03 m, with fibre
 * directions along its meridians and attachments at s < 0.08 and s > 0.92. The upper bone moves so that a centre line of constant length L
 * bends into a circular arc. With --bone a third bone, a capsule across the muscle's middle, comes 10 mm into it from the inner side of the
 * bend, and contact is on. Metres. The same options give the same bytes.
 */
#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "sinew/io.h"

static const char *const usage =
    "Usage: tip [OPTION]... FOLDER\n"
    "Write the moving-tip problem to FOLDER: fusiform.muscle.json, lower.ply, upper.ply and tip.scene.json.\n\n"
    "  -t, --triangles N         about N triangles (100 to 2000000; default 1000)\n"
    "      --fast                the tip turns by 19 degrees a frame, then keeps still\n"
    "      --static              the tip turns by 2 degrees a frame, 45 frames long: for the equilibrium at its end\n"
    "      --activation[=A]      activation from 0 to A (default 0.5) in a second, smoothly\n"
    "      --stiffness K         relaxed and active stiffness, N/m (default 500)\n"
    "      --stiffness-active K  active stiffness, N/m (default: the relaxed one)\n"
    "      --volume-gain G       goal volume over rest volume at full activation (default 1)\n"
    "      --least-area A        no triangle below this share of its rest area (default 0.5; 0: no such constraint, and under\n"
    "                            qn no barrier: edges, angles and volume alone, the same energy for both solvers)\n"
    "      --bone                a capsule of 20 mm radius comes 10 mm into the muscle's middle in ten frames, and is felt: contact is on\n"
    "  -h, --help                print this and exit\n"
    "      --version             print the version and exit\n";

typedef enum motion { SMOOTH, FAST, STATIC } motion;

typedef struct options {
    const char *folder;
    int64_t triangles;
    motion motion;
    double activation, stiffness, stiffness_active, volume_gain;
    double least_area; /* negative: the scene's default */
    bool bone;
} options;

static const double length = 0.2, radius = 0.03, pinned = 0.08; /* m, m, share of the length at each end */
static const double rate = 24.0;                                /* frames per second */
static const double full_bend = 0.5 * SN_PI;
/* The capsule: its radius, half of its axis, how far it is from the muscle at first, how deep it comes, m; when it is there, s. */
static const double bone_radius = 0.02, bone_half = 0.06, bone_gap = 0.0011, bone_depth = 0.01, bone_seconds = 10.0 / 24.0;

/* ---- the muscle --------------------------------------------------------------------------------------------------------- */

/* Rings of `sectors` vertices between the two tip vertices. */
typedef struct shell {
    sn_index rings, sectors;
} shell;

/* Two triangles per ring and sector, three rings for every two sectors: about equilateral ones at the belly. */
static shell shell_for(int64_t triangles) {
    shell s = {.sectors = (sn_index)lround(sqrt((double)triangles / 3.0))};
    if (s.sectors < 3) s.sectors = 3;
    s.rings = (sn_index)lround((double)triangles / (2.0 * s.sectors));
    return s;
}

static double ring_radius(double s) { return radius * sn_pow(sn_sin(SN_PI * s), 0.8); }

static void place_vertices(shell f, sn_vec3 *positions) {
    for (sn_index r = 0; r < f.rings; r++) {
        double s = (r + 1.0) / (f.rings + 1.0), around = ring_radius(s);
        for (sn_index k = 0; k < f.sectors; k++) {
            double angle = 2.0 * SN_PI * (k + 0.5 * (r % 2)) / f.sectors;
            positions[r * f.sectors + k] = sn_v3(around * sn_cos(angle), around * sn_sin(angle), s * length);
        }
    }
    positions[f.rings * f.sectors] = sn_v3(0, 0, 0);
    positions[f.rings * f.sectors + 1] = sn_v3(0, 0, length);
}

/* The two triangles between ring vertices a, b and, one ring up, c, d; the diagonal follows the stagger. */
static sn_triangle *add_pair(sn_triangle *t, bool even, sn_index a, sn_index b, sn_index c, sn_index d) {
    *t++ = even ? (sn_triangle){{a, b, c}} : (sn_triangle){{a, b, d}};
    *t++ = even ? (sn_triangle){{b, d, c}} : (sn_triangle){{a, d, c}};
    return t;
}

static void place_triangles(shell f, sn_triangle *t) {
    sn_index bottom = f.rings * f.sectors, top = bottom + 1, last = (f.rings - 1) * f.sectors;
    for (sn_index k = 0; k < f.sectors; k++) {
        sn_index next = (k + 1) % f.sectors;
        *t++ = (sn_triangle){{bottom, next, k}};
        *t++ = (sn_triangle){{top, last + k, last + next}};
        for (sn_index r = 0; r + 1 < f.rings; r++) {
            sn_index below = r * f.sectors, above = below + f.sectors;
            t = add_pair(t, r % 2 == 0, below + k, below + next, above + k, above + next);
        }
    }
}

/* The meridian's direction; at the tips, where it has none, x. */
static sn_vec3 fiber_at(sn_vec3 p) {
    double s = p.z / length, out = sn_length2(p.x, p.y);
    if (!(out > 0.0)) return sn_v3(1, 0, 0);
    double slope = 0.8 * radius * sn_pow(sn_sin(SN_PI * s), -0.2) * sn_cos(SN_PI * s) * SN_PI / length;
    return sn_normalize(sn_v3(slope * p.x / out, slope * p.y / out, 1.0));
}

static bool attach(const sn_mesh *mesh, const char *bone, bool upper, sn_attachment *a) {
    *a = (sn_attachment){.bone = sn_strdup(bone), .method = sn_strdup("pin"), .vertices = SN_NEW(sn_index, mesh->vertex_count)};
    if (a->bone == NULL || a->method == NULL || a->vertices == NULL) return false;
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        double s = mesh->positions[v].z / length;
        if (upper ? s > 1.0 - pinned : s < pinned) a->vertices[a->count++] = v;
    }
    return true;
}

static sn_status make_muscle(int64_t triangles, sn_muscle *muscle, sn_error *error) {
    shell f = shell_for(triangles);
    sn_index vertices = f.rings * f.sectors + 2;
    *muscle = (sn_muscle){.name = sn_strdup("fusiform"), .meters_per_unit = 1.0, .has_attachments = true};
    sn_status status = sn_mesh_alloc(&muscle->mesh, vertices, 2 * f.rings * f.sectors, error);
    if (status != SN_OK) return status;
    place_vertices(f, muscle->mesh.positions);
    place_triangles(f, muscle->mesh.triangles);
    muscle->fibers.directions = SN_NEW(sn_vec3, vertices);
    muscle->attachments = SN_NEW(sn_attachment, 2);
    if (muscle->name == NULL || muscle->fibers.directions == NULL || muscle->attachments == NULL)
        return sn_fail_memory(error, "the muscle");
    for (sn_index v = 0; v < vertices; v++) muscle->fibers.directions[v] = fiber_at(muscle->mesh.positions[v]);
    muscle->attachment_count = 2;
    bool made = attach(&muscle->mesh, "upper", true, &muscle->attachments[0]);
    return attach(&muscle->mesh, "lower", false, &muscle->attachments[1]) && made ? SN_OK : sn_fail_memory(error, "the attachments");
}

/* ---- the scene ------------------------------------------------------------------------------------------------------------ */

/* Bend angle of the centre line, rad. */
static double bend_at(motion m, double time) {
    if (m == FAST) return fmin(full_bend, 19.0 / 180.0 * SN_PI * rate * time);
    if (m == STATIC) return fmin(full_bend, 2.0 / 180.0 * SN_PI * rate * time);
    double t = fmin(time, 1.0); /* a second long */
    return full_bend * t * t * (3.0 - 2.0 * t);
}

/* The upper end of an arc of length L that leaves the origin along z and bends towards y by `bend`: (0, L (1 - cos b) / b, L sin b / b).
 * The bone turns by -b about x, which takes z to the arc's tangent, and its point (0, 0, L) to the arc's end. */
static void write_key(sn_json *json, double time, double bend) {
    double chord = bend > 0.0 ? sn_sin(0.5 * bend) / (0.5 * bend) : 1.0; /* over L; it stands at half the angle */
    sn_vec3 end = sn_v3(0, length * chord * sn_sin(0.5 * bend), length * chord * sn_cos(0.5 * bend));
    sn_json_object(json, NULL);
    sn_json_number(json, "time", time);
    sn_json_numbers(json, "rotation", (const double[]){sn_cos(0.5 * bend), -sn_sin(0.5 * bend), 0.0, 0.0}, 4);
    sn_json_vec3(json, "translation", sn_sub(end, sn_v3(0, length * sn_sin(bend), length * sn_cos(bend))));
    sn_json_close(json);
}

/* So dense that it does not matter how a program goes from key to key: the chord of 1/480 s is off the arc by less than 2e-8 m. */
static void write_keys(sn_json *json, motion m, double seconds) {
    const double keys_per_second = 480.0;
    sn_json_array(json, "keys");
    for (int i = 0; i <= (int)lround(seconds * keys_per_second); i++) write_key(json, i / keys_per_second, bend_at(m, i / keys_per_second));
    sn_json_close(json);
}

static void write_bone_key(sn_json *json, double time, double way) {
    sn_json_object(json, NULL);
    sn_json_number(json, "time", time);
    sn_json_vec3(json, "translation", sn_v3(0, way, 0));
    sn_json_close(json);
}

static void write_bone_motion(sn_json *json) {
    sn_json_object(json, NULL);
    sn_json_text(json, "name", "bone");
    sn_json_text(json, "type", "pose");
    sn_json_array(json, "keys");
    write_bone_key(json, 0.0, 0.0);
    write_bone_key(json, bone_seconds, -(bone_gap + bone_depth));
    sn_json_close(json);
    sn_json_close(json);
}

static void write_motion(sn_json *json, motion m, double seconds, bool bone) {
    sn_json_object(json, "motion");
    sn_json_array(json, "joints");
    sn_json_object(json, NULL);
    sn_json_text(json, "name", "tip");
    sn_json_text(json, "type", "pose");
    write_keys(json, m, seconds);
    sn_json_close(json);
    if (bone) write_bone_motion(json);
    sn_json_close(json);
    sn_json_close(json);
}

static void write_bones(sn_json *json, bool bone) {
    sn_json_array(json, "bones");
    for (int upper = 0; upper < 2; upper++) {
        sn_json_object(json, NULL);
        sn_json_text(json, "name", upper ? "upper" : "lower");
        sn_json_text(json, "mesh", upper ? "upper.ply" : "lower.ply");
        if (upper) sn_json_text(json, "joint", "tip");
        if (bone) sn_json_bool(json, "contact", false); /* where the muscle hangs on, there is nothing to feel */
        sn_json_close(json);
    }
    if (bone) {
        sn_json_object(json, NULL);
        sn_json_text(json, "name", "bone");
        sn_json_text(json, "mesh", "bone.ply");
        sn_json_text(json, "joint", "bone");
        sn_json_close(json);
    }
    sn_json_close(json);
}

static void write_activation(sn_json *json, double activation) {
    if (!(activation > 0.0)) return;
    sn_json_object(json, "activation");
    sn_json_text(json, "interpolation", "smooth");
    sn_json_array(json, "keys");
    sn_json_numbers(json, NULL, (const double[]){0.0, 0.0}, 2);
    sn_json_numbers(json, NULL, (const double[]){1.0, activation}, 2);
    sn_json_close(json);
    sn_json_close(json);
}

static void write_muscle_members(sn_json *json, const options *o) {
    sn_json_array(json, "muscles");
    sn_json_object(json, NULL);
    sn_json_text(json, "name", "fusiform");
    sn_json_text(json, "rig", "fusiform.muscle.json");
    sn_json_object(json, "stiffness");
    sn_json_number(json, "relaxed", o->stiffness);
    sn_json_number(json, "active", o->stiffness_active);
    sn_json_close(json);
    if (o->volume_gain != 1.0) sn_json_number(json, "volumeRatio", o->volume_gain);
    if (o->least_area >= 0.0) sn_json_number(json, "leastArea", o->least_area);
    write_activation(json, o->activation);
    sn_json_close(json);
    sn_json_close(json);
}

static void write_scene_members(sn_json *json, const options *o) {
    int last = o->motion == STATIC ? 45 : 24;
    sn_json_text(json, "format", "sinew-scene");
    sn_json_integer(json, "version", 1);
    sn_json_text(json, "name", "tip");
    sn_json_number(json, "metersPerUnit", 1.0);
    sn_json_number(json, "rate", rate);
    sn_json_indices(json, "frames", (const sn_index[]){0, last}, 2);
    if (o->bone) sn_json_bool(json, "contact", true);
    write_motion(json, o->motion, last / rate, o->bone);
    write_bones(json, o->bone);
    write_muscle_members(json, o);
}

/* ---- files ------------------------------------------------------------------------------------------------------------------ */

static sn_status open_in(const options *o, const char *name, sn_output **output, sn_error *error) {
    char path[4096];
    if (snprintf(path, sizeof path, "%s/%s", o->folder, name) >= (int)sizeof path)
        return sn_fail(error, SN_ERROR_USAGE, "the name of the folder is too long; choose a shorter one");
    return sn_output_open(path, false, output, error);
}

static sn_status close_output(sn_output *output, sn_status status, sn_error *error) {
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

/* An octahedron of 1 cm about `centre`: something to look at where the muscle hangs on. */
static sn_status write_bone(const options *o, const char *name, sn_vec3 centre, sn_error *error) {
    static const sn_index faces[8][3] = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    const double reach = 0.01;
    const sn_vec3 axes[3] = {{reach, 0, 0}, {0, reach, 0}, {0, 0, reach}};
    sn_mesh mesh = {0};
    sn_output *output = NULL;
    sn_status status = sn_mesh_alloc(&mesh, 6, 8, error);
    for (int i = 0; status == SN_OK && i < 6; i++) mesh.positions[i] = sn_add_scaled(centre, axes[i / 2], i % 2 ? -1.0 : 1.0);
    for (int i = 0; status == SN_OK && i < 8; i++) mesh.triangles[i] = (sn_triangle){{faces[i][0], faces[i][1], faces[i][2]}};
    if (status == SN_OK) status = open_in(o, name, &output, error);
    if (status == SN_OK) status = sn_mesh_write(&mesh, SN_MESH_PLY, SN_ENCODING_DEFAULT, output, error);
    sn_mesh_free(&mesh);
    return close_output(output, status, error);
}

/* Point k of ring r, of `around` points each: half as many rings, those of the one half ball, then those of the other. */
static sn_vec3 capsule_point(int around, int ring, int k) {
    int upper = 2 * ring >= around / 2, step = ring + !upper; /* the poles have points of their own, the rim has two rings */
    double polar = 2.0 * SN_PI * step / around, turn = 2.0 * SN_PI * k / around;
    double out = bone_radius * sn_sin(polar), along = (upper ? bone_half : -bone_half) - bone_radius * sn_cos(polar);
    return sn_v3(along, radius + bone_radius + bone_gap + out * sn_cos(turn), 0.5 * length + out * sn_sin(turn));
}

static sn_status make_capsule(int around, sn_mesh *mesh, sn_error *error) {
    int rings = around / 2, pole = rings * around;
    sn_status status = sn_mesh_alloc(mesh, pole + 2, 2 * pole, error);
    if (status != SN_OK) return status;
    for (int i = 0; i < pole; i++) mesh->positions[i] = capsule_point(around, i / around, i % around);
    for (int upper = 0; upper < 2; upper++)
        mesh->positions[pole + upper] =
            sn_v3((upper ? 1.0 : -1.0) * (bone_half + bone_radius), radius + bone_radius + bone_gap, 0.5 * length);
    sn_triangle *t = mesh->triangles;
    for (int k = 0; k < around; k++) {
        int next = (k + 1) % around, last = pole - around;
        *t++ = (sn_triangle){{pole, next, k}};
        *t++ = (sn_triangle){{pole + 1, last + k, last + next}};
        for (int below = 0; below < last; below += around) {
            *t++ = (sn_triangle){{below + k, below + next, below + around + k}};
            *t++ = (sn_triangle){{below + next, below + around + next, below + around + k}};
        }
    }
    return SN_OK;
}

static sn_status write_capsule(const options *o, sn_error *error) {
    sn_mesh mesh = {0};
    sn_output *output = NULL;
    sn_status status = make_capsule(64, &mesh, error);
    if (status == SN_OK) status = open_in(o, "bone.ply", &output, error);
    if (status == SN_OK) status = sn_mesh_write(&mesh, SN_MESH_PLY, SN_ENCODING_DEFAULT, output, error);
    sn_mesh_free(&mesh);
    return close_output(output, status, error);
}

static sn_status write_muscle(const options *o, sn_error *error) {
    const sn_write_options how = {.changed = SN_SECTION_MESH | SN_SECTION_FIBERS | SN_SECTION_ATTACHMENTS, .drop_history = true};
    sn_muscle muscle = {0};
    sn_output *output = NULL;
    sn_status status = make_muscle(o->triangles, &muscle, error);
    if (status == SN_OK) status = open_in(o, "fusiform.muscle.json", &output, error);
    if (status == SN_OK) status = sn_muscle_write(&muscle, NULL, &how, output, error);
    sn_muscle_free(&muscle);
    return close_output(output, status, error);
}

static sn_status write_scene(const options *o, sn_error *error) {
    sn_output *output = NULL;
    sn_status status = open_in(o, "tip.scene.json", &output, error);
    if (status != SN_OK) return status;
    sn_json *json = sn_json_begin(output, true);
    if (json == NULL) return close_output(output, sn_fail_memory(error, "the scene"), error);
    sn_json_object(json, NULL);
    write_scene_members(json, o);
    sn_json_close(json);
    return close_output(output, sn_json_end(json, error), error);
}

static sn_status generate(const options *o, sn_error *error) {
    if (mkdir(o->folder, 0777) != 0 && errno != EEXIST)
        return sn_fail_at(error, SN_ERROR_IO, o->folder, 0, "cannot make this folder: %s", strerror(errno));
    sn_status status = write_muscle(o, error);
    if (status == SN_OK) status = write_bone(o, "lower.ply", sn_v3(0, 0, 0), error);
    if (status == SN_OK) status = write_bone(o, "upper.ply", sn_v3(0, 0, length), error);
    if (status == SN_OK && o->bone) status = write_capsule(o, error);
    return status == SN_OK ? write_scene(o, error) : status;
}

/* ---- the command -------------------------------------------------------------------------------------------------------------- */

_Noreturn static void wrong_usage(const sn_error *error) {
    fprintf(stderr, "tip: %s; see tip --help\n", error->text);
    exit(2);
}

static double parse_number(const char *name, const char *text, double low, double high) {
    sn_error error = {0};
    double value;
    if (sn_parse_number(text, &value, &error) != SN_OK) wrong_usage(&error);
    if (value >= low && value <= high) return value;
    (void)sn_fail(&error, SN_ERROR_USAGE, "--%s %s is not between %g and %g", name, text, low, high);
    wrong_usage(&error);
}

static void parse_option(int c, options *o) {
    sn_error error = {0};
    switch (c) {
    case 't':
        if (sn_parse_integer(optarg, 100, 2000000, &o->triangles, &error) != SN_OK) wrong_usage(&error);
        break;
    case 'f':
        o->motion = FAST;
        break;
    case 's':
        o->motion = STATIC;
        break;
    case 'a':
        o->activation = optarg != NULL ? parse_number("activation", optarg, 0.0, 1.0) : 0.5;
        break;
    case 'k':
        o->stiffness = parse_number("stiffness", optarg, 0.0, 1e15);
        break;
    case 'K':
        o->stiffness_active = parse_number("stiffness-active", optarg, 0.0, 1e15);
        break;
    case 'g':
        o->volume_gain = parse_number("volume-gain", optarg, 0.01, 100.0);
        break;
    case 'l':
        o->least_area = parse_number("least-area", optarg, 0.0, 0.99);
        break;
    case 'b':
        o->bone = true;
        break;
    case 'h':
        exit(fputs(usage, stdout) < 0 || fclose(stdout) != 0);
    case 'V':
        exit(puts("tip (sinew) " SN_VERSION) < 0 || fclose(stdout) != 0);
    default:
        exit(2);
    }
}

static options parse(int argc, char **argv) {
    static const struct option known[] = {{"triangles", required_argument, NULL, 't'},
                                          {"fast", no_argument, NULL, 'f'},
                                          {"static", no_argument, NULL, 's'},
                                          {"activation", optional_argument, NULL, 'a'},
                                          {"stiffness", required_argument, NULL, 'k'},
                                          {"stiffness-active", required_argument, NULL, 'K'},
                                          {"volume-gain", required_argument, NULL, 'g'},
                                          {"least-area", required_argument, NULL, 'l'},
                                          {"bone", no_argument, NULL, 'b'},
                                          {"help", no_argument, NULL, 'h'},
                                          {"version", no_argument, NULL, 'V'},
                                          {0}};
    options o = {.triangles = 1000, .stiffness = 500.0, .stiffness_active = -1.0, .volume_gain = 1.0, .least_area = -1.0};
    sn_error error = {0};
    for (int c; (c = getopt_long(argc, argv, "t:h", known, NULL)) != -1;) parse_option(c, &o);
    if (o.stiffness_active < 0.0) o.stiffness_active = o.stiffness;
    if (optind + 1 == argc) {
        o.folder = argv[optind];
        return o;
    }
    if (optind == argc)
        (void)sn_fail(&error, SN_ERROR_USAGE, "where to? name a folder");
    else
        (void)sn_fail(&error, SN_ERROR_USAGE, "'%s': one folder is enough", argv[optind + 1]);
    wrong_usage(&error);
}

int main(int argc, char **argv) {
    options o = parse(argc, argv);
    sn_error error = {0};
    if (generate(&o, &error) == SN_OK) return 0;
    fprintf(stderr, "tip: %s%s%s\n", error.file, error.file[0] ? ": " : "", error.text);
    return 1;
}
