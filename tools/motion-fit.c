/* motion-fit.c -- a recorded motion on a body's own bones. */
#include "bones.h"
#include "clip.h"
#include "sinew/thread.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double DEGREES = 180.0 / SN_PI;

/* More bones, rows or joints than this are counted in a warning, not named. */
enum { NAMES_TOLD = 6 };

static const char *table_file, *skeleton;
static cli_list bone_texts, bone_lists;
static double scale, stance_height = 0.02, stance_speed = SN_FIT_STANCE_SPEED, tolerance = 0.1;
static int align;
static int64_t gap_every;
static bool ground = true, list;

static const char *const align_names[] = {"segments", "none", NULL};

static const cli_option options[] = {
    {0, "body", "TABLE", CLI_TEXT, &table_file, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "the table that binds bones to joints and tells the joints' centres"},
    {'b', "bone", "[NAME=]FILE", CLI_LIST, &bone_texts, CLI_RESULT | CLI_FILE, 0, 0, NULL, "a bone; may be given again and again"},
    {0, "bones", "LIST", CLI_LIST, &bone_lists, CLI_RESULT | CLI_FILES, 0, 0, NULL,
     "bones: every mesh of a folder, or a file with a bone a line (default: the folder that the table names)"},
    {0, "skeleton", "FILE", CLI_TEXT, &skeleton, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "the joints of a motion that tells none, as for motion-import"},
    {0, "align", "HOW", CLI_CHOICE, &align, CLI_RESULT, 0, 0, align_names,
     "segments: turn the source's rest pose onto the body's as the table says (default); none: the two agree"},
    {0, "scale", "X", CLI_NUMBER, &scale, CLI_RESULT, 1e-3, 1e3, NULL,
     "scale the way of the root by X (default: the ratio of the lengths of the legs)"},
    {0, "no-ground", NULL, CLI_CLEAR, &ground, CLI_RESULT, 0, 0, NULL,
     "leave the motion as it comes; otherwise the floor that standing feet tell is levelled and put to z = 0"},
    {0, "list", NULL, CLI_FLAG, &list, 0, 0, 0, NULL, "print joints with source, centre and spheres, and do nothing else"},
    {0, "gap-every", "N", CLI_AUTO, &gap_every, 0, 1, 1e9, NULL,
     "of the report: distances of bones at every Nth frame (default: auto, about 24 a second)"},
    {0, "gap-tolerance", "MM", CLI_NUMBER, &tolerance, 0, 1e-3, 100, NULL, "of the report: distances are exact to MM mm (default 0.1)"},
    {0, "stance-height", "M", CLI_NUMBER, &stance_height, 0, 0, 10, NULL,
     "of the report: a foot that stands is less than M m above the floor (default 0.02), and ..."},
    {0, "stance-speed", "M/S", CLI_NUMBER, &stance_speed, 0, 0, 1e6, NULL, "... the source's goes slower than this (default 0.5)"},
};

static const cli_tool tool = {"motion-fit",
                              "fit a recorded motion to a body's own bones",
                              CLI_TAKES_INPUT | CLI_HAS_OUTPUT | CLI_HAS_STRICT | CLI_HAS_TRACE | CLI_HAS_REPORT | CLI_HAS_HISTORY |
                                  CLI_HAS_THREADS | CLI_HAS_SPACE,
                              options,
                              sizeof options / sizeof *options,
                              "The motion is a motion document, or what motion-import reads.",
                              ".json"};

/* What one run holds. */
typedef struct job {
    cli c;
    sn_blob motion, skeleton, table_text;
    sn_clip source;
    sn_fit_table table;
    bone_list bones;
    double *units; /* (bones.count) metres per unit of each file */
    sn_fit_body body;
    sn_fit_result fit;
    bool *idle; /* (source.joint_count) turns and drives nothing */
    sn_fit_gap *gaps;
    sn_index gap_count;
    sn_fit_foot *feet;
} job;

/* ---- reading --------------------------------------------------------------------------------------------------------------------- */

static sn_status load_motion(job *j, sn_error *error) {
    const sn_clip_options by_format = {0};
    sn_status status = sn_blob_read(j->c.inputs.items[0], &j->motion, error);
    if (status == SN_OK && skeleton != NULL) status = sn_blob_read(skeleton, &j->skeleton, error);
    if (status != SN_OK) return status;
    sn_hash(j->motion.data, j->motion.size, j->c.input_hash);
    status = sn_clip_parse(&j->motion, skeleton != NULL ? &j->skeleton : NULL, &by_format, &j->source, error);
    if (status == SN_OK && j->source.rate_assumed)
        cli_tell(&j->c, "%s tells no rate: taken as %g Hz; motion-import --source-rate tells another", j->motion.name, j->source.rate);
    if (status == SN_OK && j->source.begin < 0.0)
        cli_warn(&j->c, "%s: its first key is at %g s, which is frame 0 and 0 s of what is written: all of it comes later by as much",
                 j->motion.name, j->source.begin);
    return status;
}

/* In metres: by what the file says, or the row that binds the bone, or the table. */
static sn_status convert_bones(job *j, sn_error *error) {
    j->units = SN_NEW(double, j->bones.count);
    if (j->units == NULL) return sn_fail_memory(error, "the bones");
    for (size_t i = 0; i < j->bones.count; i++) {
        bone *b = &j->bones.items[i];
        sn_index row = sn_fit_table_row(&j->table, b->name);
        double told = row != SN_NONE ? j->table.bones[row].meters_per_unit : 0.0;
        j->units[i] = told > 0.0 ? told : b->own_unit > 0.0 ? b->own_unit : j->table.meters_per_unit;
        sn_mesh_convert(&b->mesh, j->units[i], false);
        b->used = row != SN_NONE;
        sn_index unused;
        sn_status status = sn_drop_unused_vertices(&b->mesh, &unused, error); /* they are no part of the bone: no foot stands on them */
        if (status != SN_OK) return status;
    }
    return SN_OK;
}

static sn_status load_bones(job *j, sn_error *error) {
    const char *folder = j->table.folder;
    cli_list own = {1, &folder};
    bool given = bone_texts.count + bone_lists.count > 0;
    if (!given && folder == NULL) cli_usage_error(&j->c, "name the bones with --bones, or their folder in the table");
    sn_status status = bones_name(&j->c, &bone_texts, given ? &bone_lists : &own, &j->bones, error);
    if (status == SN_OK) status = bones_load(&j->bones, j->c.threads, error);
    if (status == SN_OK) status = bones_check_spaces(&j->bones, NULL, error);
    return status == SN_OK ? convert_bones(j, error) : status;
}

static sn_status make_body(job *j, sn_error *error) {
    sn_fit_bone *bones = SN_NEW(sn_fit_bone, j->bones.count);
    if (bones == NULL) return sn_fail_memory(error, "the bones");
    for (size_t i = 0; i < j->bones.count; i++) {
        const bone *b = &j->bones.items[i];
        bones[i] = (sn_fit_bone){.name = b->name, .path = b->file, .meters_per_unit = j->units[i], .mesh = &b->mesh};
    }
    sn_status status = sn_fit_body_create(&j->table, (sn_index)j->bones.count, bones, &j->body, error);
    free(bones);
    return status;
}

static sn_status load(job *j, sn_error *error) {
    sn_status status = load_motion(j, error);
    if (status == SN_OK) status = sn_blob_read(table_file, &j->table_text, error);
    if (status == SN_OK) status = sn_fit_table_parse(&j->table_text, &j->table, error);
    if (status == SN_OK) status = load_bones(j, error);
    return status == SN_OK ? make_body(j, error) : status;
}

/* ---- warnings --------------------------------------------------------------------------------------------------------------------- */

/* "a, b, c and 4 more" of those of count that are wanted; returns how many there are. */
typedef const char *(*name_function)(const job *j, sn_index i); /* NULL = not wanted */
static sn_index tell_names(const job *j, sn_index count, name_function name, char *out, size_t size) {
    sn_index found = 0;
    size_t used = 0;
    *out = '\0';
    for (sn_index i = 0; i < count; i++) {
        const char *text = name(j, i);
        if (text == NULL || found++ >= NAMES_TOLD) continue;
        int more = snprintf(out + used, size - used, "%s%s", found > 1 ? ", " : "", text);
        used = more < 0 || used + (size_t)more >= size ? size - 1 : used + (size_t)more;
    }
    if (found > NAMES_TOLD) snprintf(out + used, size - used, " and %d more", found - NAMES_TOLD);
    return found;
}

static const char *unbound_bone(const job *j, sn_index i) { return j->body.bones[i].row == SN_NONE ? j->body.bones[i].name : NULL; }

static const char *idle_row(const job *j, sn_index i) {
    for (sn_index b = 0; b < j->body.bone_count; b++)
        if (j->body.bones[b].row == i) return NULL;
    return j->table.bones[i].pattern;
}

static const char *bare_joint(const job *j, sn_index i) {
    for (sn_index b = 0; b < j->body.bone_count; b++)
        if (j->body.bones[b].joint != SN_NONE && sn_fit_below(&j->table, j->body.bones[b].joint, i)) return NULL;
    return j->table.points[i].name;
}

static const char *idle_source(const job *j, sn_index i) { return j->idle[i] ? j->source.joints[i].name : NULL; }

static sn_status warn(job *j, sn_error *error) {
    char names[512];
    sn_index count = tell_names(j, j->body.bone_count, unbound_bone, names, sizeof names);
    if (count > 0) cli_warn(&j->c, "%s: no row binds %d of %d bones, which are left out: %s", table_file, count, j->body.bone_count, names);
    count = tell_names(j, j->table.bone_count, idle_row, names, sizeof names);
    if (count > 0) cli_warn(&j->c, "%s: rows that bind no bone: %s", table_file, names);
    count = tell_names(j, j->table.joint_count, bare_joint, names, sizeof names);
    if (count > 0) cli_warn(&j->c, "%s: joints that carry no bone: %s", table_file, names);
    j->idle = SN_NEW(bool, j->source.joint_count);
    if (j->idle == NULL) return sn_fail_memory(error, "the joints");
    sn_status status = sn_fit_idle_sources(&j->fit, &j->source, j->idle, error);
    count = status == SN_OK ? tell_names(j, j->source.joint_count, idle_source, names, sizeof names) : 0;
    if (count > 0) cli_warn(&j->c, "%s: joints that turn and drive nothing: %s", j->motion.name, names);
    if (align == 0 && j->table.joints[0].along.given && !j->table.joints[0].along.level && !j->table.joints[0].aside.given)
        cli_warn(&j->c, "%s: nothing tells which way \"%s\" faces; give it a direction aside, or a level one", table_file,
                 j->table.points[0].name);
    return status;
}

/* ---- list ------------------------------------------------------------------------------------------------------------------------------
 */

static void print_number(sn_output *output, double value) {
    char text[32];
    sn_format_number(value, text);
    sn_output_print(output, "\t%s", text);
}

static void print_place(sn_output *output, const job *j, sn_index p) {
    const sn_fit_point *point = &j->table.points[p];
    const sn_fit_place *place = &j->body.places[p];
    bool joint = p < j->table.joint_count;
    sn_index parent = joint ? j->table.joints[p].parent : SN_NONE;
    sn_output_print(output, "%s\t%s\t%s\t%s\t%s", joint ? "joint" : "place", point->name,
                    parent != SN_NONE ? j->table.points[parent].name : "-", point->source != NULL ? point->source : "-",
                    sn_fit_rule_names[point->rule.kind]);
    print_number(output, place->centre.x);
    print_number(output, place->centre.y);
    print_number(output, place->centre.z);
    for (sn_index s = 0; s < place->sphere_count; s++) {
        const sn_fit_sphere *sphere = &place->spheres[s];
        sn_output_print(output, "\tradius %.5f rms %.5f coverage %.3f vertices %d of %d", sphere->radius, sphere->rms, sphere->coverage,
                        sphere->used, sphere->selected);
    }
    sn_output_print(output, "\n");
}

static sn_status print_list(const job *j, sn_error *error) {
    sn_output *output;
    sn_status status = sn_output_open("-", false, &output, error);
    if (status != SN_OK) return status;
    for (sn_index p = 0; p < j->table.point_count; p++) print_place(output, j, p);
    status = sn_output_commit(output, error);
    return status == SN_OK ? SN_STOPPED : status;
}

/* ---- report ----------------------------------------------------------------------------------------------------------------------------
 */

static void write_range(sn_json *json, const char *name, const sn_fit_range *range, int k) {
    const double ends[2] = {range->low[k] * DEGREES, range->high[k] * DEGREES};
    sn_json_numbers(json, name, ends, 2);
}

static void write_spheres(sn_json *json, const sn_fit_place *place) {
    if (place->sphere_count == 0) return;
    sn_json_array(json, "spheres");
    for (sn_index s = 0; s < place->sphere_count; s++) {
        const sn_fit_sphere *sphere = &place->spheres[s];
        sn_json_object(json, NULL);
        sn_json_vec3(json, "centre", sphere->centre);
        sn_json_number(json, "radius", sphere->radius);
        sn_json_number(json, "rms", sphere->rms);
        sn_json_number(json, "coverage", sphere->coverage);
        sn_json_integer(json, "selected", sphere->selected);
        sn_json_integer(json, "used", sphere->used);
        sn_json_close(json);
    }
    sn_json_close(json);
}

static void write_gap(sn_json *json, const job *j, const sn_fit_gap *gap) {
    sn_json_object(json, "gap");
    sn_json_array(json, "bones");
    for (int k = 0; k < 2; k++) sn_json_text(json, NULL, j->body.bones[gap->bones[k]].name);
    sn_json_close(json);
    sn_json_number(json, "rest", gap->rest);
    sn_json_number(json, "least", gap->least);
    sn_json_integer(json, "leastFrame", gap->least_frame);
    sn_json_number(json, "greatest", gap->greatest);
    sn_json_integer(json, "greatestFrame", gap->greatest_frame);
    sn_json_number(json, "change", fmax(gap->greatest - gap->rest, gap->rest - gap->least));
    sn_json_close(json);
}

static void write_joint(sn_json *json, const job *j, sn_index i) {
    sn_fit_range range = sn_fit_joint_range(&j->fit.clip, i);
    sn_quat turn = j->fit.alignment[i];
    sn_json_object(json, NULL);
    sn_json_text(json, "name", j->table.points[i].name);
    sn_json_text(json, "source", j->fit.sources[i] != SN_NONE ? j->source.joints[j->fit.sources[i]].name : NULL);
    sn_json_vec3(json, "centre", j->body.places[i].centre);
    write_spheres(json, &j->body.places[i]);
    sn_json_number(json, "alignedBy", 2.0 * sn_atan2(sn_norm(sn_v3(turn.x, turn.y, turn.z)), fabs(turn.w)) * DEGREES);
    write_range(json, "degrees", &range, 0);
    write_range(json, "degreesX", &range, 1);
    write_range(json, "degreesY", &range, 2);
    write_range(json, "degreesZ", &range, 3);
    for (sn_index g = 0; g < j->gap_count; g++)
        if (j->gaps[g].joint == i) write_gap(json, j, &j->gaps[g]);
    sn_json_close(json);
}

static void write_foot(sn_json *json, const job *j, const sn_fit_foot *foot) {
    sn_json_object(json, NULL);
    sn_json_text(json, "joint", j->table.points[foot->joint].name);
    sn_json_number(json, "lowest", foot->lowest);
    sn_json_integer(json, "lowestFrame", foot->lowest_frame);
    sn_json_array(json, "stances");
    for (sn_index s = 0; s < foot->stance_count; s++) {
        sn_json_object(json, NULL);
        sn_json_integer(json, "first", foot->stances[s].first);
        sn_json_integer(json, "last", foot->stances[s].last);
        sn_json_number(json, "travel", foot->stances[s].travel);
        sn_json_number(json, "path", foot->stances[s].path);
        sn_json_number(json, "sourceTravel", foot->stances[s].source_travel);
        sn_json_close(json);
    }
    sn_json_close(json);
    sn_json_close(json);
}

static void write_report(sn_json *json, const void *data) {
    const job *j = data;
    sn_json_integer(json, "frames", j->fit.clip.frame_count);
    sn_json_number(json, "rate", j->fit.clip.rate);
    sn_json_integer(json, "bones", j->fit.clip.bone_count);
    sn_json_number(json, "scale", j->fit.scale);
    sn_json_number(json, "leg", j->fit.leg);
    sn_json_number(json, "sourceLeg", j->fit.source_leg);
    sn_json_bool(json, "floor", j->fit.floor);
    sn_json_number(json, "slope", j->fit.slope * DEGREES);
    sn_json_bool(json, "levelled", j->fit.levelled);
    sn_json_number(json, "raised", j->fit.raised);
    sn_json_number(json, "gapTolerance", 1e-3 * tolerance);
    sn_json_integer(json, "gapEvery", gap_every);
    sn_json_array(json, "joints");
    for (sn_index i = 0; i < j->table.joint_count; i++) write_joint(json, j, i);
    sn_json_close(json);
    sn_json_array(json, "feet");
    for (sn_index k = 0; k < j->table.foot_count; k++) write_foot(json, j, &j->feet[k]);
    sn_json_close(json);
}

static sn_status measure(job *j, sn_error *error) {
    const sn_fit_foot_params foot = {stance_height, stance_speed};
    if (gap_every == 0) gap_every = (int64_t)fmax(1.0, round(j->source.rate / 24.0));
    sn_fit_gap_params gap = {1e-3 * tolerance, (sn_index)gap_every, NULL, &j->c.trace};
    sn_status status = sn_fit_feet(&j->body, &j->fit, &j->source, &foot, &j->feet, error);
    if (status != SN_OK) return status;
    gap.pool = sn_pool_create(j->c.threads);
    status = sn_fit_gaps(&j->body, &j->fit.clip, &gap, &j->gaps, &j->gap_count, error);
    sn_pool_destroy(gap.pool);
    return status == SN_STOPPED ? SN_OK : status;
}

/* ---- work -------------------------------------------------------------------------------------------------------------------------------
 */

static sn_status save(job *j, sn_error *error) {
    bool document = strcmp(j->source.format, "motion document") == 0;
    j->c.hash_files = bones_hash;
    j->c.hash_user = &j->bones;
    sn_status status = cli_save_clip(&j->c, &j->fit.clip, document ? &j->motion : NULL, error);
    return status == SN_OK ? cli_report(&j->c, write_report, j, error) : status;
}

static bool trace_body(job *j) {
    for (sn_index p = 0; p < j->table.joint_count; p++) {
        sn_vec3 centre = j->body.places[p].centre;
        if (SN_TRACE(&j->c.trace, "joint", sn_trace_text("name", j->table.points[p].name), sn_trace_number("x", centre.x),
                     sn_trace_number("y", centre.y), sn_trace_number("z", centre.z)))
            return true;
    }
    return false;
}

static void tell(const job *j) {
    const char *how = cli_given(&j->c, "scale") ? "as told" : j->fit.leg > 0.0 ? "by the length of the legs" : "as the table names no leg";
    if (j->fit.slope > 0.0 && ground)
        cli_tell(&j->c, "the floor that standing feet tell rises by %.2f degrees along their way%s", j->fit.slope * DEGREES,
                 j->fit.levelled ? "; the motion is turned to level it" : ": a slope, which is left");
    cli_tell(&j->c, "%d bones on %d joints, %d frames; the way of the root is scaled by %.4f, %s", j->fit.clip.bone_count,
             j->fit.clip.joint_count, j->fit.clip.frame_count, j->fit.scale, how);
}

static sn_status fit_motion(job *j, sn_error *error) {
    const sn_fit_params params = {.align = align == 0, .scale = scale, .ground = ground};
    if (table_file == NULL) cli_usage_error(&j->c, "name the body's table with --body");
    sn_status status = load(j, error);
    if (status != SN_OK) return status;
    if (list) return print_list(j, error);
    bool stopped = trace_body(j);
    status = sn_motion_fit(&j->body, &j->source, &params, &j->fit, error);
    if (status == SN_OK) status = warn(j, error);
    if (status != SN_OK) return status;
    tell(j);
    if (j->c.report != NULL && !stopped) status = measure(j, error);
    return status == SN_OK ? save(j, error) : status;
}

int main(int argc, char **argv) {
    job j = {0};
    sn_error error = {0};
    cli_start(&j.c, &tool, argc, argv);
    sn_status status = fit_motion(&j, &error);
    if (j.feet != NULL) sn_fit_feet_free(j.feet, j.table.foot_count);
    free(j.gaps);
    free(j.idle);
    sn_fit_result_free(&j.fit);
    sn_fit_body_free(&j.body);
    free(j.units);
    bones_free(&j.bones);
    sn_fit_table_free(&j.table);
    sn_clip_free(&j.source);
    sn_blob_free(&j.table_text);
    sn_blob_free(&j.motion);
    sn_blob_free(&j.skeleton);
    return cli_finish(&j.c, status, &error);
}
