/* envelope-bind.c -- a surface of one piece bound to the bones beneath it, and what a motion makes of it. */
#include "bones.h"
#include "frame_files.h"
#include "sinew/thread.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* More bones or vertices than this are counted in a warning or report, not told one by one. */
enum { NAMES_TOLD = 6, VERTICES_TOLD = 100 };

static const char *motion_file, *frames_to, *bones_to;
static int method;
static sn_length reach = {SN_ENVELOPE_REACH, 1.0}, far_from = {0.1, 1.0}, grow = {0.0, 1.0};
static int64_t every;

static const cli_option options[] = {
    {0, "bones", "MOTION", CLI_TEXT, &motion_file, CLI_RESULT | CLI_FILES, 0, 0, NULL,
     "the motion document that names the bones and moves them, as motion-fit writes it"},
    {0, "method", "HOW", CLI_CHOICE, &method, CLI_RESULT, 0, 0, sn_envelope_method_names,
     "blend: poses of bones are blended as dual quaternions (default); wrap: where each bone carries a vertex is averaged"},
    {0, "reach", "LENGTH", CLI_LENGTH, &reach, CLI_RESULT, 0, 0, NULL,
     "a bone that is farther than the nearest by this or more carries nothing (default 40mm)"},
    {0, "grow", "LENGTH", CLI_LENGTH, &grow, CLI_RESULT, 0, 0, NULL,
     "move the surface outwards by this along its normals first (default 0)"},
    {0, "far", "LENGTH", CLI_LENGTH, &far_from, 0, 0, 0, NULL, "warn of vertices farther than this from every bone (default 100mm)"},
    {0, "frames", "FILE", CLI_TEXT, &frames_to, CLI_WRITES | CLI_FOLDER, 0, 0, NULL,
     "write the envelope under the motion: NAME.pc2, or NAME.ply or NAME.vtp for NAME.0000.ply and so on"},
    {0, "every", "N", CLI_AUTO, &every, 0, 1, 1e9, NULL,
     "of --frames and --report: every Nth frame of the motion (default: auto, about 24 a second)"},
    {0, "write-bones", "FILE", CLI_TEXT, &bones_to, CLI_WRITES, 0, 0, NULL,
     "write the bones at rest as one mesh, to make an envelope of, and do nothing else"},
};

static const cli_tool tool = {"envelope-bind",
                              "bind a surface to the bones beneath it",
                              CLI_TAKES_INPUT | CLI_HAS_OUTPUT | CLI_HAS_STRICT | CLI_HAS_TRACE | CLI_HAS_REPORT | CLI_HAS_UNITS |
                                  CLI_HAS_HISTORY | CLI_HAS_THREADS | CLI_HAS_SPACE,
                              options,
                              sizeof options / sizeof *options,
                              "INPUT is a mesh, or an envelope document, which is taken as it is bound.",
                              ".json"};

/* What a motion has made of the envelope. */
typedef struct course {
    sn_index measured;
    sn_envelope_frame rest, least, deepest, worst; /* frames of the least area, the deepest vertex, the most deep vertices */
    sn_index least_at, deepest_at, worst_at;
    int64_t small, outside, deep; /* over all frames */
} course;

/* What one run holds. */
typedef struct job {
    cli c;
    sn_blob input, motion;
    sn_clip clip;
    bone_list bones;
    sn_envelope_bone *bound; /* (bones.count) */
    sn_muscle surface;       /* the mesh that is to be bound */
    sn_document *document;
    bool given; /* the input is an envelope document */
    sn_envelope envelope;
    sn_index *driver;  /* (envelope.bone_count) which of bones is that of the envelope */
    sn_rigid *poses;   /* (envelope.bone_count) of the frame at hand */
    double *clearance; /* (vertices) NULL = not known */
    sn_pool *pool;
    course course;
} job;

/* ---- bones ---------------------------------------------------------------------------------------------------------------------- */

static sn_status name_bones(job *j, sn_error *error) {
    j->bones.items = SN_NEW(bone, j->clip.bone_count);
    if (j->bones.items == NULL) return sn_fail_memory(error, "the bones");
    j->bones.count = (size_t)j->clip.bone_count;
    for (sn_index b = 0; b < j->clip.bone_count; b++) {
        bone *item = &j->bones.items[b];
        *item =
            (bone){.name = sn_strdup(j->clip.bones[b].name), .file = sn_strdup(j->clip.bones[b].path), .list = motion_file, .used = true};
        if (item->name == NULL || item->file == NULL) return sn_fail_memory(error, "the bones");
    }
    return SN_OK;
}

/* In metres: by what the motion tells, or the file, which is in metres otherwise. */
static void convert_bones(job *j) {
    for (size_t i = 0; i < j->bones.count; i++) {
        bone *b = &j->bones.items[i];
        double told = j->clip.bones[i].meters_per_unit;
        sn_mesh_convert(&b->mesh, told > 0.0 ? told : b->own_unit > 0.0 ? b->own_unit : 1.0, false);
        j->bound[i] = (sn_envelope_bone){b->name, &b->mesh, j->clip.bones[i].joint};
    }
}

static sn_status load_bones(job *j, sn_error *error) {
    const sn_clip_options by_format = {0};
    sn_status status = sn_blob_read(motion_file, &j->motion, error);
    if (status == SN_OK) status = sn_clip_parse(&j->motion, NULL, &by_format, &j->clip, error);
    if (status != SN_OK) return status;
    if (j->clip.bone_count == 0)
        return sn_fail_at(error, SN_ERROR_INPUT, j->motion.name, 0, "names no bones; motion-fit binds the bones of a body to a motion");
    j->bound = SN_NEW(sn_envelope_bone, j->clip.bone_count);
    if (j->bound == NULL) return sn_fail_memory(error, "the bones");
    status = name_bones(j, error);
    if (status == SN_OK) status = bones_load(&j->bones, j->c.threads, error);
    if (status == SN_OK) status = bones_check_spaces(&j->bones, j->given ? NULL : &j->surface, error);
    if (status == SN_OK) convert_bones(j);
    return status;
}

/* For the history: the motion and the bones that it names. */
static sn_status hash_motion(const void *user, const char *value, char out[SN_HASH_LENGTH], sn_error *error) {
    const job *j = user;
    char both[2 * SN_HASH_LENGTH] = "";
    sn_hash(j->motion.data, j->motion.size, both);
    size_t used = strlen(both);
    sn_status status = bones_hash(&j->bones, value, both + used, error);
    if (status == SN_OK) sn_hash(both, strlen(both), out);
    return status;
}

/* ---- the bones as one mesh ------------------------------------------------------------------------------------------------------- */

static sn_status join_bones(const job *j, sn_mesh *out, sn_error *error) {
    int64_t vertices = 0, triangles = 0;
    for (size_t i = 0; i < j->bones.count; i++) {
        vertices += j->bones.items[i].mesh.vertex_count;
        triangles += j->bones.items[i].mesh.triangle_count;
    }
    if (vertices > SN_INDEX_MAX || triangles > SN_INDEX_MAX / 3)
        return sn_fail(error, SN_ERROR_INPUT, "the bones are too large for one mesh");
    sn_status status = sn_mesh_alloc(out, (sn_index)vertices, (sn_index)triangles, error);
    if (status != SN_OK) return status;
    sn_index v = 0, t = 0;
    for (size_t i = 0; i < j->bones.count; i++) {
        const sn_mesh *mesh = &j->bones.items[i].mesh;
        memcpy(out->positions + v, mesh->positions, (size_t)mesh->vertex_count * sizeof *mesh->positions);
        for (sn_index k = 0; k < mesh->triangle_count; k++, t++)
            for (int corner = 0; corner < 3; corner++) out->triangles[t].v[corner] = mesh->triangles[k].v[corner] + v;
        v += mesh->vertex_count;
    }
    return SN_OK;
}

static sn_status write_mesh(const sn_mesh *mesh, const char *path, sn_error *error) {
    sn_output *output = NULL;
    sn_mesh_format format = sn_mesh_format_from_name(path);
    sn_status status = sn_output_open(path, false, &output, error);
    if (status != SN_OK) return status;
    status = sn_mesh_write(mesh, format != SN_MESH_UNKNOWN ? format : SN_MESH_PLY, SN_ENCODING_DEFAULT, output, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

static sn_status write_bones(const job *j, sn_error *error) {
    sn_mesh all = {0};
    sn_status status = join_bones(j, &all, error);
    if (status == SN_OK) status = write_mesh(&all, bones_to, error);
    sn_mesh_free(&all);
    return status;
}

/* ---- the envelope ---------------------------------------------------------------------------------------------------------------- */

static sn_status load_surface(job *j, sn_error *error) {
    sn_status status = sn_blob_read(j->c.inputs.items[0], &j->input, error);
    if (status != SN_OK) return status;
    sn_hash(j->input.data, j->input.size, j->c.input_hash);
    j->given = sn_envelope_detect(&j->input);
    if (j->given && (cli_given(&j->c, "units") || cli_given(&j->c, "up") || cli_given(&j->c, "mesh")))
        return sn_fail_at(error, SN_ERROR_USAGE, j->input.name, 0,
                          "an envelope document says its units; --units, --up and --mesh are for bare meshes");
    status = j->given ? sn_envelope_parse(&j->input, &j->envelope, error)
                      : sn_muscle_parse(&j->input, &j->c.read, &j->surface, &j->document, error);
    if (status != SN_OK) sn_error_set_file(error, j->input.name);
    return status;
}

/* Outwards along the vertices' normals. */
static sn_status grow_surface(sn_mesh *mesh, double by, sn_error *error) {
    if (by == 0.0) return SN_OK;
    sn_vec3 *normals = SN_NEW(sn_vec3, mesh->vertex_count);
    if (normals == NULL) return sn_fail_memory(error, "an envelope");
    sn_mesh_vertex_normals(mesh, normals);
    for (sn_index v = 0; v < mesh->vertex_count; v++) mesh->positions[v] = sn_add_scaled(mesh->positions[v], normals[v], by);
    free(normals);
    return SN_OK;
}

static sn_status bind(job *j, sn_error *error) {
    sn_mesh *mesh = &j->surface.mesh;
    sn_envelope_params params = {
        .method = (sn_envelope_method)method, .reach = sn_length_meters(reach, 1.0), .pool = j->pool, .trace = &j->c.trace};
    if (!(params.reach > 0.0)) cli_usage_error(&j->c, "--reach is a length above 0");
    sn_mesh_convert(mesh, j->surface.meters_per_unit, false);
    params.clearance = j->clearance = SN_NEW(double, mesh->vertex_count);
    if (j->clearance == NULL) return sn_fail_memory(error, "an envelope");
    sn_status status = grow_surface(mesh, sn_length_meters(grow, 1.0), error);
    if (status == SN_OK) status = sn_envelope_bind(mesh, (sn_index)j->bones.count, j->bound, &params, &j->envelope, error);
    if (status == SN_OK && j->surface.name != NULL && (j->envelope.name = sn_strdup(j->surface.name)) == NULL)
        status = sn_fail_memory(error, "an envelope");
    return status;
}

/* An envelope that was bound before: what would bind it makes no sense. */
static void take_bound(job *j) {
    static const char *const binding[] = {"reach", "grow", "units", "up", "mesh"};
    for (size_t i = 0; i < sizeof binding / sizeof *binding; i++)
        if (cli_given(&j->c, binding[i])) cli_usage_error(&j->c, "--%s is for a mesh; %s is bound already", binding[i], j->input.name);
    if (cli_given(&j->c, "method")) j->envelope.method = (sn_envelope_method)method;
}

static sn_status find_drivers(job *j, sn_error *error) {
    j->driver = SN_NEW(sn_index, j->envelope.bone_count);
    j->poses = SN_NEW(sn_rigid, j->envelope.bone_count);
    sn_envelope_bone *bound = SN_NEW(sn_envelope_bone, j->envelope.bone_count);
    if (j->driver == NULL || j->poses == NULL || bound == NULL) {
        free(bound);
        return sn_fail_memory(error, "the bones");
    }
    for (sn_index b = 0; b < j->envelope.bone_count; b++) {
        size_t i = 0;
        while (i < j->bones.count && strcmp(j->bones.items[i].name, j->envelope.bones[b]) != 0) i++;
        if (i == j->bones.count) {
            free(bound);
            return sn_fail_at(error, SN_ERROR_INPUT, j->input.name, 0, "is bound to a bone \"%s\", which %s does not name",
                              j->envelope.bones[b], j->motion.name);
        }
        j->driver[b] = (sn_index)i;
        bound[b] = j->bound[i];
    }
    free(j->bound);
    j->bound = bound;
    return SN_OK;
}

/* Distances of the vertices of an envelope that was bound before from the bones that carry them most: is it over these bones? */
static sn_status measure_bone(job *j, sn_index b, sn_error *error) {
    sn_surface *surface = NULL;
    if (j->bound[b].mesh->triangle_count == 0) return SN_OK;
    sn_status status = sn_surface_create_plain(j->bound[b].mesh, &surface, error);
    for (sn_index v = 0; v < j->envelope.mesh.vertex_count && status == SN_OK; v++)
        if (j->envelope.influences[v].bones[0] == b)
            j->clearance[v] = sn_surface_closest(surface, j->envelope.mesh.positions[v], INFINITY).distance;
    sn_surface_destroy(surface);
    return status;
}

static sn_status measure_clearance(job *j, sn_error *error) {
    if ((j->clearance = SN_NEW(double, j->envelope.mesh.vertex_count)) == NULL) return sn_fail_memory(error, "an envelope");
    sn_status status = SN_OK;
    for (sn_index b = 0; b < j->envelope.bone_count && status == SN_OK; b++) status = measure_bone(j, b, error);
    return status;
}

/* ---- what is odd about it -------------------------------------------------------------------------------------------------------- */

static bool carries(const job *j, sn_index wanted) {
    for (sn_index v = 0; v < j->envelope.mesh.vertex_count; v++)
        for (sn_index k = 0; k < j->envelope.influences[v].count; k++)
            if (j->envelope.influences[v].bones[k] == wanted) return true;
    return false;
}

static sn_index count_alone(const job *j) {
    sn_index alone = 0;
    for (sn_index v = 0; v < j->envelope.mesh.vertex_count; v++) alone += j->envelope.influences[v].count == 1;
    return alone;
}

static bool is_far(const job *j, sn_index v) { return j->clearance[v] > sn_length_meters(far_from, 1.0); }

static void warn_of_idle_bones(const job *j) {
    sn_index idle = 0;
    for (sn_index b = 0; b < j->envelope.bone_count; b++) {
        if (carries(j, b)) continue;
        if (idle++ < NAMES_TOLD) cli_say(&j->c, "no vertex is carried by '%s'", j->envelope.bones[b]);
    }
    if (idle > 0)
        cli_tell(&j->c, "%d of %d bones carry no vertex: others of their joints are nearer; --report names them", idle,
                 j->envelope.bone_count);
}

static void warn_of_far_vertices(const job *j) {
    sn_index count = 0, farthest = 0;
    for (sn_index v = 0; j->clearance != NULL && v < j->envelope.mesh.vertex_count; v++) {
        count += is_far(j, v);
        if (j->clearance[v] > j->clearance[farthest]) farthest = v;
    }
    if (count > 0)
        cli_warn(&j->c, "%d vertices are farther than %g m from %s, vertex %d by %.4g m: are units and places those of the bones?", count,
                 sn_length_meters(far_from, 1.0), j->given ? "the bone that carries them most" : "every bone", farthest,
                 j->clearance[farthest]);
}

/* ---- the motion ------------------------------------------------------------------------------------------------------------------ */

/* Where the frames go. */
typedef struct target {
    sn_pc2 *cache;     /* NULL for a sequence */
    char *path;        /* of the frame at hand */
    size_t stem, size; /* length of the path before ".0000.ply"; room */
    sn_mesh moved;     /* lends the envelope's triangles */
} target;

/* The number of the motion's first frame, of those that a scene counts from 0 s: below 0 where its keys begin earlier. */
static double first_number(const job *j) {
    double first = j->clip.begin * j->clip.rate, whole = round(first);
    return fabs(first - whole) < 1e-6 ? whole : first; /* times are multiples of 1/rate only to rounding */
}

/* Of the frame at hand; a file's is whole. */
static sn_index number_of(const job *j, sn_index frame) { return (sn_index)floor(first_number(j)) + frame; }

static void warn_of_fractions(const job *j) {
    double first = first_number(j);
    if (first != floor(first))
        cli_warn(&j->c, "%s begins at %g s, which is frame %g: files are numbered from %.0f on; a point cache (.pc2) tells the fraction",
                 j->motion.name, j->clip.begin, first, floor(first));
}

static void pose_bones(job *j, sn_index frame) {
    for (sn_index b = 0; b < j->envelope.bone_count; b++) {
        sn_index joint = j->clip.bones[j->driver[b]].joint;
        j->poses[b] = joint != SN_NONE ? j->clip.joints[joint].poses[frame] : sn_rigid_identity();
    }
}

static bool is_cache(const char *path) {
    const char *dot = strrchr(path, '.');
    return dot != NULL && strcmp(dot, ".pc2") == 0;
}

/* Before anything is written. */
static void check_frames(const job *j) {
    const char *slash = bones_to != NULL ? strrchr(bones_to, '/') : NULL, *name = slash != NULL ? slash + 1 : bones_to;
    if (name != NULL && strchr(name, '.') != NULL && sn_mesh_format_from_name(name) == SN_MESH_UNKNOWN)
        cli_usage_error(&j->c, "--write-bones %s: no mesh format has this ending; name a file .ply, .obj, .stl, .off or .vtp", bones_to);
    if (frames_to == NULL || is_cache(frames_to)) return;
    sn_mesh_format format = sn_mesh_format_from_name(frames_to);
    if (format != SN_MESH_PLY && format != SN_MESH_VTP) cli_usage_error(&j->c, "--frames %s: name a file .pc2, .ply or .vtp", frames_to);
}

/* An older, longer sequence would mix with this one. */
static sn_status check_sequence(const job *j, sn_error *error) {
    if (frames_to == NULL || is_cache(frames_to)) return SN_OK;
    size_t stem = (size_t)(strrchr(frames_to, '.') - frames_to);
    const frame_range range = {.first = number_of(j, 0), .last = number_of(j, (sn_index)((j->clip.frame_count - 1) / every * every))};
    char *prefix = sn_strndup(frames_to, stem);
    sn_status status = prefix != NULL ? frame_sequence_check(prefix, frames_to + stem, &range, error) : sn_fail_memory(error, "the frames");
    free(prefix);
    return status;
}

static sn_status open_target(const job *j, target *t, sn_error *error) {
    t->moved = (sn_mesh){.vertex_count = j->envelope.mesh.vertex_count,
                         .triangle_count = j->envelope.mesh.triangle_count,
                         .triangles = j->envelope.mesh.triangles,
                         .positions = SN_NEW(sn_vec3, j->envelope.mesh.vertex_count)};
    if (t->moved.positions == NULL) return sn_fail_memory(error, "the frames");
    if (is_cache(frames_to)) return sn_pc2_create(frames_to, t->moved.vertex_count, first_number(j), (double)every, &t->cache, error);
    warn_of_fractions(j);
    t->stem = (size_t)(strrchr(frames_to, '.') - frames_to);
    t->size = strlen(frames_to) + 16;
    t->path = sn_alloc(t->size, 1);
    return t->path != NULL ? SN_OK : sn_fail_memory(error, "the frames");
}

static sn_status write_frame(const job *j, target *t, sn_index frame, sn_error *error) {
    sn_envelope_deform(&j->envelope, j->poses, j->pool, t->moved.positions);
    if (t->cache != NULL) return sn_pc2_append(t->cache, t->moved.positions, error);
    snprintf(t->path, t->size, "%.*s.%04d%s", (int)t->stem, frames_to, (int)number_of(j, frame), frames_to + t->stem);
    return write_mesh(&t->moved, t->path, error);
}

static sn_status write_frames(job *j, sn_error *error) {
    target t = {0};
    sn_status status = open_target(j, &t, error);
    for (int64_t f = 0; f < j->clip.frame_count && status == SN_OK; f += every) {
        pose_bones(j, (sn_index)f);
        status = write_frame(j, &t, (sn_index)f, error);
    }
    if (status == SN_OK && t.cache != NULL) {
        status = sn_pc2_commit(t.cache, error);
        t.cache = NULL;
    }
    sn_pc2_abort(t.cache);
    free(t.path);
    free(t.moved.positions);
    return status;
}

static void note(course *all, const sn_envelope_frame *frame, sn_index at) {
    if (all->measured == 0 || frame->least_area < all->least.least_area) {
        all->least = *frame;
        all->least_at = at;
    }
    if (all->measured == 0 || frame->deepest > all->deepest.deepest) {
        all->deepest = *frame;
        all->deepest_at = at;
    }
    if (all->measured == 0 || frame->deep > all->worst.deep) {
        all->worst = *frame;
        all->worst_at = at;
    }
    all->small += frame->small;
    all->outside += frame->outside;
    all->deep += frame->deep;
    all->measured++;
}

static sn_status measure(job *j, sn_error *error) {
    sn_envelope_frame frame;
    sn_status status = sn_envelope_measure(&j->envelope, j->bound, NULL, j->pool, &j->course.rest, error);
    for (int64_t f = 0; f < j->clip.frame_count && status == SN_OK; f += every) {
        pose_bones(j, (sn_index)f);
        status = sn_envelope_measure(&j->envelope, j->bound, j->poses, j->pool, &frame, error);
        if (status == SN_OK) note(&j->course, &frame, number_of(j, (sn_index)f));
        cli_progress(&j->c, f, j->clip.frame_count, "frames");
    }
    return status;
}

/* ---- report ---------------------------------------------------------------------------------------------------------------------- */

static int64_t count_bone_vertices(const job *j) {
    int64_t total = 0;
    for (sn_index b = 0; b < j->envelope.bone_count; b++) total += j->bound[b].mesh->vertex_count;
    return total;
}

static void write_area(sn_json *json, const sn_envelope_frame *frame, sn_index at) {
    sn_json_object(json, "leastArea");
    sn_json_number(json, "ratio", frame->least_area);
    sn_json_integer(json, "triangle", frame->triangle);
    if (at != SN_NONE) sn_json_integer(json, "frame", at);
    sn_json_close(json);
}

static void write_deepest(sn_json *json, const job *j, const sn_envelope_frame *frame, sn_index at) {
    sn_json_object(json, "deepest");
    sn_json_number(json, "distance", frame->deepest);
    sn_json_text(json, "bone", j->envelope.bones[frame->bone]);
    sn_json_integer(json, "vertex", frame->vertex);
    if (at != SN_NONE) sn_json_integer(json, "frame", at);
    sn_json_close(json);
}

static void write_idle_bones(sn_json *json, const job *j) {
    sn_json_array(json, "idleBones");
    for (sn_index b = 0; b < j->envelope.bone_count; b++)
        if (!carries(j, b)) sn_json_text(json, NULL, j->envelope.bones[b]);
    sn_json_close(json);
}

static void write_clearance(sn_json *json, const job *j) {
    double least = INFINITY, greatest = 0.0, sum = 0.0;
    sn_index far_count = 0, told[VERTICES_TOLD];
    for (sn_index v = 0; v < j->envelope.mesh.vertex_count; v++) {
        least = fmin(least, j->clearance[v]);
        greatest = fmax(greatest, j->clearance[v]);
        sum += j->clearance[v];
        if (!is_far(j, v)) continue;
        if (far_count < VERTICES_TOLD) told[far_count] = v;
        far_count++;
    }
    sn_json_object(json, "clearance");
    sn_json_number(json, "least", least);
    sn_json_number(json, "mean", sum / j->envelope.mesh.vertex_count);
    sn_json_number(json, "greatest", greatest);
    sn_json_number(json, "far", sn_length_meters(far_from, 1.0));
    sn_json_integer(json, "farVertices", far_count);
    sn_json_indices(json, "vertices", told, (size_t)(far_count < VERTICES_TOLD ? far_count : VERTICES_TOLD));
    sn_json_close(json);
}

static void write_motion(sn_json *json, const job *j) {
    const course *all = &j->course;
    double total = (double)count_bone_vertices(j);
    sn_json_object(json, "motion");
    sn_json_integer(json, "frames", all->measured);
    sn_json_integer(json, "every", every);
    write_area(json, &all->least, all->least_at);
    sn_json_integer(json, "smallTriangles", all->small);
    write_deepest(json, j, &all->deepest, all->deepest_at);
    sn_json_number(json, "outsideShare", (double)all->outside / (total * all->measured));
    sn_json_number(json, "deepShare", (double)all->deep / (total * all->measured));
    sn_json_number(json, "worstDeepShare", all->worst.deep / total);
    sn_json_integer(json, "worstFrame", all->worst_at);
    sn_json_close(json);
}

static void write_report(sn_json *json, const void *data) {
    const job *j = data;
    sn_json_integer(json, "vertices", j->envelope.mesh.vertex_count);
    sn_json_integer(json, "triangles", j->envelope.mesh.triangle_count);
    sn_json_integer(json, "bones", j->envelope.bone_count);
    sn_json_integer(json, "boneVertices", count_bone_vertices(j));
    sn_json_text(json, "method", sn_envelope_method_names[j->envelope.method]);
    sn_json_number(json, "reach", j->envelope.reach);
    sn_json_integer(json, "rigidVertices", count_alone(j));
    write_idle_bones(json, j);
    if (j->clearance != NULL) write_clearance(json, j);
    sn_json_number(json, "deep", SN_ENVELOPE_DEEP);
    sn_json_number(json, "small", SN_ENVELOPE_SMALL);
    sn_json_object(json, "rest");
    write_deepest(json, j, &j->course.rest, SN_NONE);
    sn_json_number(json, "outsideShare", j->course.rest.outside / (double)count_bone_vertices(j));
    sn_json_number(json, "deepShare", j->course.rest.deep / (double)count_bone_vertices(j));
    sn_json_close(json);
    write_motion(json, j);
}

/* ---- work ------------------------------------------------------------------------------------------------------------------------ */

static sn_status write_document(const job *j, const sn_history_entry *entry, sn_error *error) {
    sn_output *output = NULL;
    bool document = j->given || j->input.data[0] == '{';
    sn_status status = sn_output_open(j->c.output, false, &output, error);
    if (status != SN_OK) return status;
    status = sn_envelope_write(&j->envelope, j->c.history ? entry : NULL, j->c.history && document ? &j->input : NULL, output, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

static sn_status save(job *j, sn_error *error) {
    cli_history history = {0};
    j->c.hash_files = hash_motion;
    j->c.hash_user = j;
    sn_status status = j->c.history ? cli_history_make(&j->c, &history, error) : SN_OK;
    if (status == SN_OK) status = write_document(j, &history.entry, error);
    cli_history_free(&history);
    return status;
}

static sn_status bind_envelope(job *j, sn_error *error) {
    if (motion_file == NULL) cli_usage_error(&j->c, "name the motion document that names the bones, with --bones");
    check_frames(j);
    sn_status status = bones_to == NULL ? load_surface(j, error) : SN_OK;
    if (status == SN_OK) status = load_bones(j, error);
    if (status != SN_OK) return status;
    if (bones_to != NULL) return write_bones(j, error);
    if (every == 0) every = (int64_t)fmax(1.0, round(j->clip.rate / 24.0));
    status = check_sequence(j, error);
    if (status != SN_OK) return status;
    j->pool = sn_pool_create(j->c.threads);
    if (j->given)
        take_bound(j);
    else
        status = bind(j, error);
    if (status == SN_OK) status = find_drivers(j, error);
    if (status == SN_OK && j->given) status = measure_clearance(j, error);
    if (status != SN_OK) return status;
    warn_of_idle_bones(j);
    warn_of_far_vertices(j);
    status = save(j, error);
    if (status == SN_OK && frames_to != NULL) status = write_frames(j, error);
    if (status == SN_OK && j->c.report != NULL) status = measure(j, error);
    return status == SN_OK ? cli_report(&j->c, write_report, j, error) : status;
}

int main(int argc, char **argv) {
    job j = {0};
    sn_error error = {0};
    cli_start(&j.c, &tool, argc, argv);
    sn_status status = bind_envelope(&j, &error);
    sn_pool_destroy(j.pool);
    free(j.clearance);
    free(j.poses);
    free(j.driver);
    sn_envelope_free(&j.envelope);
    sn_document_free(j.document);
    sn_muscle_free(&j.surface);
    free(j.bound);
    bones_free(&j.bones);
    sn_clip_free(&j.clip);
    sn_blob_free(&j.motion);
    sn_blob_free(&j.input);
    return cli_finish(&j.c, status, &error);
}
