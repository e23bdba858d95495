/*
 * fibers.c -- the volume fibres of simulate's muscles: bound to the surfaces once, then carried along, measured and written.
 */
#include "fibers.h"
#include "earlier.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { SMOOTHING_ROUNDS = 5 }; /* [K21] 4.4 */
#define DEGREES (180.0 / SN_PI)

/* ---- what is asked for -------------------------------------------------------------------------------------------------------- */

bool fibers_wanted(const cli *c, const fiber_choices *with) {
    bool wanted = with->frames || with->lengths != NULL || with->penetration;
    if (with->frames && !cli_given(c, "output")) cli_usage_error(c, "--fibers writes frames: say with -o where");
    if (with->lengths != NULL && strcmp(with->lengths, "-") == 0)
        cli_usage_error(c, "--lengths needs a file: the log is on the standard output");
    if (with->smooth && with->lengths == NULL) cli_usage_error(c, "--smooth-lengths needs --lengths FILE");
    if (cli_given(c, "blend") && with->lengths == NULL && !with->penetration)
        cli_usage_error(c, "--blend needs --lengths FILE or --penetration");
    if (!wanted && (cli_given(c, "mvc-cut") || with->cache != NULL))
        cli_usage_error(c, "--%s is for --fibers, --lengths and --penetration", with->cache != NULL ? "embedding-cache" : "mvc-cut");
    return wanted;
}

/* ---- the cache of weights ------------------------------------------------------------------------------------------------------- */

/* FOLDER/HEX.embedding for the hash "sha256:HEX". */
static char *cache_path(const char *folder, const char *hash) {
    const char *colon = strchr(hash, ':'), *name = colon != NULL ? colon + 1 : hash;
    size_t size = strlen(folder) + strlen(name) + sizeof "/.embedding";
    char *path = sn_alloc(size, 1);
    if (path != NULL) snprintf(path, size, "%s/%s.embedding", folder, name);
    return path;
}

/* Do the weights put every fibre vertex where it is at rest? No one else's do, and none that were damaged. */
static bool fits(const sn_embedding *embedding, const sn_mesh *mesh, const sn_fiber_bundle *bundle) {
    if (embedding->point_count != bundle->point_count || embedding->vertex_count != mesh->vertex_count) return false;
    sn_vec3 *points = SN_NEW(sn_vec3, bundle->point_count);
    if (points == NULL) return false;
    double tolerance = 1e-9 * sn_box_diagonal(sn_mesh_box(mesh));
    bool good = true;
    sn_embedding_apply(embedding, mesh->positions, NULL, points);
    for (sn_index i = 0; i < bundle->point_count && good; i++) good = sn_distance(points[i], bundle->points[i]) <= tolerance;
    free(points);
    return good;
}

/* true where the weights came out of the file; a file that is damaged is made anew. */
static bool load_weights(const cli *c, const char *path, const char *hash, const sn_mesh *mesh, const sn_fiber_bundle *bundle,
                         sn_embedding *out) {
    struct stat there;
    sn_blob blob = {0};
    sn_error error = {0};
    if (stat(path, &there) != 0) return false;
    sn_status status = sn_blob_read(path, &blob, &error);
    if (status == SN_OK) status = sn_embedding_load(&blob, hash, out, &error);
    sn_blob_free(&blob);
    if (status == SN_OK && !fits(out, mesh, bundle)) {
        sn_embedding_free(out);
        status = sn_fail(&error, SN_ERROR_INPUT, "these weights do not fit the fibres; they are made anew");
    }
    if (status != SN_OK) cli_warn(c, "%s: %s", path, error.text);
    return status == SN_OK;
}

static sn_status save_weights(const char *path, const char *hash, const sn_embedding *embedding, sn_error *error) {
    sn_output *output = NULL;
    sn_status status = sn_output_open(path, false, &output, error);
    if (status == SN_OK) status = sn_embedding_save(embedding, hash, output, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

static sn_status make_cache_folder(const char *folder, sn_error *error) {
    if (mkdir(folder, 0777) == 0 || errno == EEXIST) return SN_OK;
    return sn_fail_at(error, SN_ERROR_IO, folder, 0, "cannot make this folder: %s", strerror(errno));
}

/* ---- binding ---------------------------------------------------------------------------------------------------------------------- */

static sn_status build_weights(const fiber_run *run, const sn_mesh *mesh, fiber_muscle *f, sn_error *error) {
    sn_embedding_params params = sn_embedding_defaults();
    params.cut = run->with.cut;
    params.pool = run->pool;
    return sn_embedding_build(mesh, f->bundle.point_count, f->bundle.points, &params, &f->embedding, error);
}

static sn_status find_weights(const fiber_run *run, const cli *c, const sn_mesh *mesh, fiber_muscle *f, sn_error *error) {
    if (run->with.cache == NULL) return build_weights(run, mesh, f, error);
    sn_embedding_params params = sn_embedding_defaults();
    params.cut = run->with.cut;
    char hash[SN_HASH_LENGTH];
    sn_status status = sn_embedding_hash(mesh, f->bundle.point_count, f->bundle.points, &params, hash, error);
    if (status != SN_OK) return status;
    char *path = cache_path(run->with.cache, hash);
    if (path == NULL) return sn_fail_memory(error, "a path");
    f->cached = load_weights(c, path, hash, mesh, &f->bundle, &f->embedding);
    if (!f->cached) {
        status = build_weights(run, mesh, f, error);
        if (status == SN_OK) status = save_weights(path, hash, &f->embedding, error);
    }
    free(path);
    return status;
}

static sn_status add_blend(const fiber_run *run, const sn_muscle *rig, fiber_muscle *f, sn_error *error) {
    f->blend_points = SN_NEW(sn_vec3, f->bundle.point_count);
    f->blend_lengths = SN_NEW(double, f->bundle.fiber_count);
    if (f->blend_points == NULL || f->blend_lengths == NULL) return sn_fail_memory(error, "the blend of the fibres");
    return sn_fiber_blend_create(run->scene, rig, &f->bundle, run->with.blend, &f->blend, error);
}

static sn_status bind_muscle(fiber_run *run, const cli *c, sn_index muscle, sn_error *error) {
    const sn_scene_muscle *source = run->model->muscles[muscle].source;
    fiber_muscle *f = &run->muscles[muscle];
    if (source->unseen) return SN_OK;
    if (source->rig.fibers.polyline_count == 0) {
        cli_warn(c, "muscle \"%s\" has no fibres to carry (fiber-fill makes them)", source->name);
        return SN_OK;
    }
    sn_status status = sn_fiber_bundle_create(&source->rig.fibers, &f->bundle, error);
    if (status == SN_OK) status = find_weights(run, c, &source->rig.mesh, f, error);
    if (status == SN_OK && run->with.blend > 0.0) status = add_blend(run, &source->rig, f, error);
    if (status != SN_OK) {
        sn_error_set_file(error, source->uri);
        return status;
    }
    f->positions = SN_NEW(sn_vec3, source->rig.mesh.vertex_count);
    f->points = SN_NEW(sn_vec3, f->bundle.point_count);
    f->lengths = SN_NEW(double, f->bundle.fiber_count);
    return f->positions && f->points && f->lengths ? SN_OK : sn_fail_memory(error, "the fibres");
}

/* Some muscle must have fibres, before anything else is done. */
static sn_status look_for_fibers(const sn_model *model, sn_error *error) {
    for (sn_index i = 0; i < model->muscle_count; i++)
        if (!model->muscles[i].source->unseen && model->muscles[i].source->rig.fibers.polyline_count > 0) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT, "no muscle of the scene has fibres to carry; fiber-fill makes them");
}

sn_status fibers_bind(fiber_run *run, const cli *c, const fiber_choices *with, const sn_model *model, sn_pool *pool, sn_error *error) {
    if (!fibers_wanted(c, with)) return SN_OK;
    double started = cli_seconds();
    *run = (fiber_run){.with = *with, .scene = model->scene, .model = model, .pool = pool};
    sn_status status = look_for_fibers(model, error);
    if (status == SN_OK && with->cache != NULL) status = make_cache_folder(with->cache, error);
    if (status != SN_OK) return status;
    run->muscles = SN_NEW(fiber_muscle, model->muscle_count);
    run->poses = SN_NEW(sn_rigid, run->scene->motion.joint_count);
    if (run->muscles == NULL || run->poses == NULL) return sn_fail_memory(error, "the fibres");
    if (with->penetration) status = sn_bone_probe_create(run->scene, &run->probe, error);
    for (sn_index i = 0; i < model->muscle_count && status == SN_OK; i++) status = bind_muscle(run, c, i, error);
    run->bind_seconds = cli_seconds() - started;
    return status;
}

/* ---- lengths ---------------------------------------------------------------------------------------------------------------------- */

static sn_index angle_count(const sn_motion *motion) {
    sn_index count = 0;
    for (sn_index i = 0; i < motion->joint_count; i++) count += motion->joints[i].kind == SN_JOINT_HINGE;
    return count;
}

/* Columns before those of the fibres: time, hinges, coordinates. */
static sn_index input_count(const sn_motion *motion) { return 1 + angle_count(motion) + motion->coordinate_count; }

static int64_t column_count(const fiber_run *run) {
    int64_t count = input_count(&run->scene->motion);
    for (sn_index i = 0; i < run->model->muscle_count; i++)
        count += (run->with.blend > 0.0 ? 2 : 1) * (int64_t)run->muscles[i].bundle.fiber_count;
    return count;
}

/* "NAME.SUFFIX", "NAME.blend.7": NULL = out of memory. */
static char *column_name(const char *name, const char *middle, sn_index number) {
    size_t size = strlen(name) + strlen(middle) + 16;
    char *text = sn_alloc(size, 1);
    if (text == NULL) return NULL;
    if (number == SN_NONE)
        snprintf(text, size, "%s%s", name, middle);
    else
        snprintf(text, size, "%s%s%d", name, middle, (int)number);
    return text;
}

/* "NAME.rad", "NAME.m", or "NAME" of what has no unit. */
static char *unit_name(const char *name, const char *unit) {
    size_t size = strlen(name) + strlen(unit) + 2;
    char *text = sn_alloc(size, 1);
    if (text != NULL) snprintf(text, size, "%s%s%s", name, *unit != '\0' ? "." : "", unit);
    return text;
}

static bool name_columns(const fiber_run *run, char **names) {
    const sn_motion *motion = &run->scene->motion;
    sn_index n = 0;
    bool enough = (names[n++] = sn_strdup("time")) != NULL;
    for (sn_index i = 0; i < motion->joint_count; i++)
        if (motion->joints[i].kind == SN_JOINT_HINGE)
            enough &= (names[n++] = column_name(motion->joints[i].name, ".angle", SN_NONE)) != NULL;
    for (sn_index i = 0; i < motion->coordinate_count; i++) {
        const sn_coordinate *coordinate = &motion->coordinates[i];
        enough &= (names[n++] = unit_name(coordinate->name, coordinate->unit)) != NULL;
    }
    for (sn_index i = 0; i < run->model->muscle_count; i++) {
        const char *muscle = run->model->muscles[i].source->name;
        sn_index count = run->muscles[i].bundle.fiber_count;
        for (sn_index k = 0; k < count; k++) enough &= (names[n++] = column_name(muscle, ".", k + 1)) != NULL;
        for (sn_index k = 0; k < count && run->with.blend > 0.0; k++)
            enough &= (names[n++] = column_name(muscle, ".blend.", k + 1)) != NULL;
    }
    return enough;
}

/* The row at hand: the lengths as the fibres are. */
static void fill_row(fiber_run *run, double time) {
    const sn_motion *motion = &run->scene->motion;
    double *to = run->row;
    *to++ = time;
    for (sn_index i = 0; i < motion->joint_count; i++)
        if (motion->joints[i].kind == SN_JOINT_HINGE) *to++ = sn_channel_at(&motion->joints[i].angle, time) * DEGREES;
    for (sn_index i = 0; i < motion->coordinate_count; i++) *to++ = sn_coordinate_at(&motion->coordinates[i], time);
    for (sn_index i = 0; i < run->model->muscle_count; i++) {
        const fiber_muscle *f = &run->muscles[i];
        double unit = run->model->muscles[i].source->rig.meters_per_unit;
        for (sn_index k = 0; k < f->bundle.fiber_count; k++) *to++ = f->lengths[k] * unit;
        for (sn_index k = 0; f->blend_lengths != NULL && k < f->bundle.fiber_count; k++) *to++ = f->blend_lengths[k] * unit;
    }
}

/* resume: nullable; then the row at hand is that of the state's frame. */
static sn_status create_table(fiber_run *run, const sn_table_params *size, char **names, sn_error *error) {
    const sn_table_params params = {.title = run->scene->name != NULL ? run->scene->name : "fiber_lengths",
                                    .rows = size->rows,
                                    .columns = size->columns,
                                    .resume = size->resume,
                                    .at_row = run->row,
                                    .names = (const char *const *)names,
                                    .smoothed_from = input_count(&run->scene->motion),
                                    .rounds = run->with.smooth ? SMOOTHING_ROUNDS : 0};
    return sn_table_create(run->with.lengths, &params, &run->table, error);
}

sn_status fibers_open_lengths(fiber_run *run, int64_t rows, sn_resume *resume, sn_error *error) {
    if (run->muscles == NULL || run->with.lengths == NULL) return SN_OK;
    int64_t columns = column_count(run);
    if (columns > SN_INDEX_MAX) return sn_fail(error, SN_ERROR_MEMORY, "more fibres than a table of lengths can count");
    char **names = SN_NEW(char *, columns);
    run->row = SN_NEW(double, columns);
    bool enough = names != NULL && run->row != NULL && name_columns(run, names);
    if (enough && resume != NULL) fill_row(run, resume->frame / resume->rate);
    const sn_table_params size = {.rows = rows, .columns = (sn_index)columns, .resume = resume};
    sn_status status = enough ? create_table(run, &size, names, error) : sn_fail_memory(error, "the lengths of the fibres");
    for (int64_t i = 0; names != NULL && i < columns; i++) free(names[i]);
    free(names);
    return status;
}

static sn_status write_lengths(fiber_run *run, double time, sn_error *error) {
    fill_row(run, time);
    sn_status status = sn_table_append(run->table, run->row, error);
    return status == SN_OK ? sn_table_publish(run->table, error) : status;
}

/* ---- frames ----------------------------------------------------------------------------------------------------------------------- */

/* "path without .pc2" + suffix. */
static char *beside(const char *path, const char *suffix) {
    size_t length = strlen(path), tail = strlen(".pc2");
    if (length > tail && strcmp(path + length - tail, ".pc2") == 0) length -= tail;
    char *text = sn_alloc(length + strlen(suffix) + 1, 1);
    if (text == NULL) return NULL;
    memcpy(text, path, length);
    memcpy(text + length, suffix, strlen(suffix) + 1);
    return text;
}

/* Both of them go on with what is there, or neither does. */
static sn_status resume_frames(fiber_muscle *f, const char *path, sn_resume *resume, sn_error *error) {
    bool goes_on = false;
    sn_status status = sn_pc2_resume(path, f->bundle.point_count, resume, f->points, &f->cache, error);
    if (status == SN_OK) status = sn_line_frames_resume(f->lines, resume, &goes_on, error);
    return status == SN_OK ? earlier_whole(path, (f->cache != NULL) + goes_on, 2, error) : status;
}

sn_status fibers_open_frames(fiber_run *run, sn_index muscle, const char *path, const fiber_start *start, sn_error *error) {
    if (run->muscles == NULL || !run->with.frames || run->muscles[muscle].bundle.fiber_count == 0) return SN_OK;
    fiber_muscle *f = &run->muscles[muscle];
    const sn_fiber_bundle *b = &f->bundle;
    char *cache = beside(path, FIBERS_SUFFIX ".pc2"), *prefix = beside(path, FIBERS_SUFFIX);
    sn_status status = cache != NULL && prefix != NULL ? SN_OK : sn_fail_memory(error, "the frames of the fibres");
    if (status == SN_OK) status = frame_sequence_check(prefix, ".vtp", &start->range, error);
    if (status == SN_OK) status = sn_line_frames_create(prefix, b->fiber_count, b->start, b->rest_length, &f->lines, error);
    if (status == SN_OK && start->resume != NULL) status = resume_frames(f, cache, start->resume, error);
    if (status == SN_OK && f->cache == NULL) status = sn_pc2_create(cache, b->point_count, start->range.first, 1.0, &f->cache, error);
    free(cache);
    free(prefix);
    return status;
}

sn_status fibers_write(fiber_run *run, sn_index frame, sn_error *error) {
    if (run->muscles == NULL) return SN_OK;
    double time = frame / run->scene->rate;
    sn_status status = run->table != NULL ? write_lengths(run, time, error) : SN_OK;
    for (sn_index i = 0; i < run->model->muscle_count && status == SN_OK; i++) {
        fiber_muscle *f = &run->muscles[i];
        if (f->cache == NULL) continue;
        status = sn_pc2_append(f->cache, f->points, error);
        if (status == SN_OK) status = sn_pc2_publish(f->cache, error);
        if (status == SN_OK) status = sn_line_frames_append(f->lines, frame, time, f->points, f->lengths, error);
    }
    return status;
}

static sn_status commit_frames(fiber_muscle *f, sn_error *error) {
    if (f->cache == NULL) return SN_OK;
    sn_status status = sn_pc2_commit(f->cache, error);
    f->cache = NULL;
    sn_status listed = sn_line_frames_commit(f->lines, status == SN_OK ? error : NULL);
    f->lines = NULL;
    return status == SN_OK ? listed : status;
}

/* What is done is kept, whatever becomes of the others: the first failure is told. */
sn_status fibers_commit(fiber_run *run, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; run->muscles != NULL && i < run->model->muscle_count; i++) {
        sn_status committed = commit_frames(&run->muscles[i], status == SN_OK ? error : NULL);
        if (status == SN_OK) status = committed;
    }
    if (run->table == NULL) return status;
    sn_status committed = sn_table_commit(run->table, status == SN_OK ? error : NULL);
    run->table = NULL;
    return status == SN_OK ? committed : status;
}

/* ---- moving ----------------------------------------------------------------------------------------------------------------------- */

static void move_muscle(const fiber_run *run, const sn_state *state, sn_index muscle) {
    fiber_muscle *f = &run->muscles[muscle];
    if (f->bundle.fiber_count == 0) return;
    sn_state_positions(run->model, state, muscle, f->positions);
    sn_embedding_apply(&f->embedding, f->positions, run->pool, f->points);
    sn_fiber_lengths(&f->bundle, f->points, f->lengths);
}

static void compare_muscle(const fiber_run *run, sn_index muscle) {
    fiber_muscle *f = &run->muscles[muscle];
    double unit = run->model->muscles[muscle].source->rig.meters_per_unit;
    sn_index count = f->bundle.point_count;
    if (f->blend_points != NULL) {
        sn_fiber_blend_apply(&f->blend, &f->bundle, run->poses, f->blend_points);
        sn_fiber_lengths(&f->bundle, f->blend_points, f->blend_lengths);
    }
    if (run->probe == NULL) return;
    f->in_bones = sn_bone_probe_points(run->probe, run->poses, count, f->points, unit);
    if (f->blend_points != NULL) f->blend_in_bones = sn_bone_probe_points(run->probe, run->poses, count, f->blend_points, unit);
}

/* Seconds; in the middle of a frame the time that its substeps have come to. */
static double time_of(const fiber_run *run, const sn_state *state) {
    double frame = state->frame;
    if (state->substep > 0) frame += (double)state->substep / sn_solver_substeps(&run->scene->solver) - 1.0;
    return frame / run->scene->rate;
}

void fibers_move(fiber_run *run, const sn_state *state) {
    if (run->muscles == NULL) return;
    double started = cli_seconds();
    for (sn_index i = 0; i < run->model->muscle_count; i++) move_muscle(run, state, i);
    run->move_seconds += cli_seconds() - started;
    run->moves++;
    if (run->probe == NULL && !(run->with.blend > 0.0)) return;
    sn_motion_poses(&run->scene->motion, time_of(run, state), run->poses);
    for (sn_index i = 0; i < run->model->muscle_count; i++) compare_muscle(run, i);
}

/* ---- figures ---------------------------------------------------------------------------------------------------------------------- */

static void log_lengths(sn_json *json, const double *lengths, sn_index count, double unit) {
    double sum = 0.0, least = INFINITY, greatest = 0.0;
    for (sn_index i = 0; i < count; i++) {
        sum += lengths[i];
        least = fmin(least, lengths[i]);
        greatest = fmax(greatest, lengths[i]);
    }
    sn_json_number(json, "mean_length", sum / count * unit);
    sn_json_number(json, "least_length", least * unit);
    sn_json_number(json, "greatest_length", greatest * unit);
}

static void log_penetration(const fiber_run *run, sn_json *json, const sn_penetration *p) {
    if (run->probe == NULL) return;
    sn_json_integer(json, "inside_bones", p->inside);
    sn_json_number(json, "deepest", p->deepest);
    sn_json_text(json, "deepest_bone", p->bone != SN_NONE ? run->scene->bones[p->bone].name : NULL);
}

void fibers_log(const fiber_run *run, sn_index muscle, sn_json *json) {
    if (run->muscles == NULL || run->muscles[muscle].bundle.fiber_count == 0) return;
    const fiber_muscle *f = &run->muscles[muscle];
    double unit = run->model->muscles[muscle].source->rig.meters_per_unit;
    sn_json_object(json, "fibers");
    log_lengths(json, f->lengths, f->bundle.fiber_count, unit);
    log_penetration(run, json, &f->in_bones);
    if (f->blend_lengths != NULL) {
        sn_json_object(json, "blend");
        log_lengths(json, f->blend_lengths, f->bundle.fiber_count, unit);
        log_penetration(run, json, &f->blend_in_bones);
        sn_json_close(json);
    }
    sn_json_close(json);
}

void fibers_report(const fiber_run *run, sn_json *json) {
    if (run->muscles == NULL) return;
    sn_json_object(json, "fibers");
    sn_json_number(json, "bindSeconds", run->bind_seconds);
    if (run->moves > 0) sn_json_number(json, "meanFrameSeconds", run->move_seconds / (double)run->moves);
    sn_json_close(json);
}

/* Weights that are kept, and bytes of all that the fibres of a muscle need. */
static int64_t count_weights(const sn_embedding *e, int64_t *bytes) {
    int64_t weights = 0;
    *bytes = (int64_t)e->point_count * (int64_t)sizeof *e->rows;
    for (sn_index i = 0; i < e->point_count; i++) {
        weights += e->rows[i].count;
        *bytes += (int64_t)e->rows[i].count * (int64_t)(sizeof(double) + (e->rows[i].vertices != NULL ? sizeof(sn_index) : 0));
    }
    return weights;
}

/* Milliseconds that the fibres of a muscle take in a frame. */
static double measure_move(const fiber_run *run, const sn_state *state, sn_index muscle) {
    enum { LEAST_RUNS = 3, MOST_RUNS = 100 };
    const double enough = 2e-2;
    double started = cli_seconds(), spent = 0.0;
    int runs = 0;
    while (runs < LEAST_RUNS || (runs < MOST_RUNS && spent < enough)) {
        move_muscle(run, state, muscle);
        spent = cli_seconds() - started;
        runs++;
    }
    return 1e3 * spent / runs;
}

static void plan_weights(const fiber_run *run, const fiber_muscle *f, sn_json *json) {
    int64_t bytes, weights = count_weights(&f->embedding, &bytes);
    sn_json_integer(json, "weights", weights);
    sn_json_integer(json, "bytes", bytes);
    sn_json_number(json, "cut", run->with.cut);
    if (f->cached) sn_json_bool(json, "cached", true);
    if (f->cached) return; /* what was dropped was known when they were made */
    sn_json_number(json, "droppedMean", f->embedding.report.dropped_mean);
    sn_json_number(json, "droppedWorst", f->embedding.report.dropped_worst);
    sn_json_number(json, "affineError", f->embedding.report.error);
}

void fibers_plan(const fiber_run *run, const sn_state *state, sn_index muscle, sn_json *json) {
    sn_json_object(json, "fibers");
    if (run->muscles == NULL) {
        sn_json_bool(json, "carried", false);
        sn_json_text(json, "why", "none of --fibers, --lengths and --penetration asks for them");
    } else if (run->muscles[muscle].bundle.fiber_count == 0) {
        sn_json_bool(json, "carried", false);
        sn_json_text(json, "why", "the document has none (fiber-fill makes them)");
    } else {
        const fiber_muscle *f = &run->muscles[muscle];
        sn_json_bool(json, "carried", true);
        sn_json_integer(json, "fibers", f->bundle.fiber_count);
        sn_json_integer(json, "points", f->bundle.point_count);
        plan_weights(run, f, json);
        if (state != NULL) sn_json_number(json, "millisecondsPerFrame", measure_move(run, state, muscle));
    }
    sn_json_close(json);
}

/* ---- the end ---------------------------------------------------------------------------------------------------------------------- */

static void free_muscle(fiber_muscle *f) {
    sn_pc2_abort(f->cache);
    sn_line_frames_abort(f->lines);
    sn_fiber_bundle_free(&f->bundle);
    sn_embedding_free(&f->embedding);
    sn_fiber_blend_free(&f->blend);
    free(f->positions);
    free(f->points);
    free(f->lengths);
    free(f->blend_points);
    free(f->blend_lengths);
}

void fibers_free(fiber_run *run) {
    for (sn_index i = 0; run->muscles != NULL && i < run->model->muscle_count; i++) free_muscle(&run->muscles[i]);
    sn_table_abort(run->table);
    sn_bone_probe_destroy(run->probe);
    free(run->muscles);
    free(run->poses);
    free(run->row);
    *run = (fiber_run){0};
}
