/* motion-import.c -- a motion as it was recorded, from the files of other programs, as a motion document. */
#include "clip.h"
#include "model_bones.h"

#include <stdlib.h>
#include <string.h>

/* More jumps than this are counted, not told one by one. */
enum { JUMPS_TOLD = 5 };

static const char *skeleton, *frames, *bones, *animation;
static cli_list bone_paths;
static double rate, cutoff, source_rate;
static int units, up, positions;
static bool list;

static const char *const unit_names[] = {"m", "cm", "mm", "in", NULL};
static const double unit_meters[] = {1.0, 0.01, 0.001, 0.0254};
static const char *const up_names[] = {"z", "y", NULL};
static const char *const position_names[] = {"auto", "add", "replace", NULL}; /* in the order of sn_clip_positions */

static const cli_option options[] = {
    {0, "skeleton", "FILE", CLI_TEXT, &skeleton, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "the joints of a motion that tells none: the .asf of an .amc, the model of a .mot or .sto"},
    {0, "frames", "A:B", CLI_TEXT, &frames, CLI_RESULT, 0, 0, NULL, "keep the source's frames A to B, counted from 0 (default: all)"},
    {0, "rate", "HZ", CLI_NUMBER, &rate, CLI_RESULT, 1e-3, 1e5, NULL, "resample to HZ frames a second (default: the source's rate)"},
    {0, "filter", "HZ", CLI_NUMBER, &cutoff, CLI_RESULT, 1e-6, 1e5, NULL,
     "low-pass without lag: what is faster than HZ goes (default: no filter)"},
    {0, "units", "UNIT", CLI_CHOICE, &units, CLI_RESULT, 0, 0, unit_names,
     "unit of the source: m, cm, mm or in (default: as the file or its format says; BVH cm, AMC in)"},
    {0, "up", "AXIS", CLI_CHOICE, &up, CLI_RESULT, 0, 0, up_names,
     "up axis of the source: z, or y, turned to z (default: as its format says; BVH, AMC and OSIM y)"},
    {0, "source-rate", "HZ", CLI_NUMBER, &source_rate, CLI_RESULT, 1e-3, 1e5, NULL,
     "frames a second of the source (default: as the file says, else 120; of glTF, FBX and Collada as their keys suggest, else 30)"},
    {0, "animation", "NAME|N", CLI_TEXT, &animation, CLI_RESULT, 0, 0, NULL,
     "of a file with several animations (glTF, FBX, Collada), the one to read (default: the first)"},
    {0, "positions", "HOW", CLI_CHOICE, &positions, CLI_RESULT, 0, 0, position_names,
     "position channels of BVH: add to the OFFSET, replace it, or auto, whatever moves the joint less in the first frame (default)"},
    {0, "bones", "DIR", CLI_TEXT, &bones, CLI_RESULT, 0, 0, NULL,
     "write the model's own bones into DIR, a PLY file each, and name them in the document (OSIM, MJCF)"},
    {0, "bone-path", "DIR", CLI_LIST, &bone_paths, 0, 0, 0, NULL,
     "look for the model's mesh files in DIR first (default: beside the model, and in Geometry there)"},
    {0, "list", NULL, CLI_FLAG, &list, 0, 0, 0, NULL, "print frames, rate, joints with their parents and coordinates, and do nothing else"},
};

static const cli_tool tool = {"motion-import",
                              "read a recorded motion: BVH, ASF and AMC, MOT and STO with OSIM, MJCF, glTF, FBX, Collada, motion documents",
                              CLI_TAKES_INPUT | CLI_HAS_OUTPUT | CLI_HAS_STRICT | CLI_HAS_TRACE | CLI_HAS_REPORT | CLI_HAS_HISTORY,
                              options,
                              sizeof options / sizeof *options,
                              "The document is in metres, z up. Filter, then frames, then rate.",
                              ".json"};

/* What one run holds. */
typedef struct job {
    cli c;
    sn_blob motion, skeleton;
    sn_clip clip;
    sn_model_bones bones;
    sn_clip_jump *jumps;
    sn_index jump_count, source_frames;
    double source_rate;
} job;

/* ---- options -------------------------------------------------------------------------------------------------------------- */

/* "A:B"; either may be left out. false = it is not of that form. */
static bool parse_frames(const char *text, int64_t *first, int64_t *last) {
    const char *end = text + strlen(text), *next = text;
    if (*next != ':' && !sn_scan_integer(text, end, &next, first)) return false;
    if (*next++ != ':') return false;
    return next == end || (sn_scan_integer(next, end, &next, last) && next == end);
}

static sn_status crop(job *j, sn_error *error) {
    int64_t first = 0, last = j->clip.frame_count - 1;
    if (frames == NULL) return SN_OK;
    if (!parse_frames(frames, &first, &last)) cli_usage_error(&j->c, "--frames: '%s' is not A:B, two frames", frames);
    if (first < 0 || last < first || last >= j->clip.frame_count)
        cli_usage_error(&j->c, "--frames: %s is not within the source's frames, 0:%d", frames, j->clip.frame_count - 1);
    return sn_clip_crop(&j->clip, (sn_index)first, (sn_index)last, error);
}

static sn_clip_options chosen_options(const cli *c) {
    return (sn_clip_options){.meters_per_unit = cli_given(c, "units") ? unit_meters[units] : 0.0,
                             .up = !cli_given(c, "up") ? SN_UP_UNKNOWN
                                   : up == 1           ? SN_UP_Y
                                                       : SN_UP_Z,
                             .rate = source_rate,
                             .animation = animation,
                             .positions = (sn_clip_positions)positions};
}

/* ---- reading --------------------------------------------------------------------------------------------------------------- */

static sn_status load(job *j, sn_error *error) {
    sn_clip_options chosen = chosen_options(&j->c);
    sn_bone_search search = {.folders = bone_paths.items, .folder_count = bone_paths.count, .found = &j->bones};
    if (bones != NULL && !list) chosen.bones = &search;
    sn_status status = sn_blob_read(j->c.inputs.items[0], &j->motion, error);
    if (status == SN_OK && skeleton != NULL) status = sn_blob_read(skeleton, &j->skeleton, error);
    if (status != SN_OK) return status;
    sn_hash(j->motion.data, j->motion.size, j->c.input_hash);
    status = sn_clip_parse(&j->motion, skeleton != NULL ? &j->skeleton : NULL, &chosen, &j->clip, error);
    if (status != SN_OK) return status;
    j->source_frames = j->clip.frame_count;
    j->source_rate = j->clip.rate;
    if (j->clip.rate_assumed)
        cli_tell(&j->c, "%s tells no rate: taken as %g Hz; --source-rate tells another", j->motion.name, j->clip.rate);
    if (j->clip.begin < 0.0)
        cli_warn(&j->c, "%s: its first key is at %g s, which is frame 0 and 0 s of what is written: all of it comes later by as much",
                 j->motion.name, j->clip.begin);
    return sn_clip_jumps(&j->clip, &j->jumps, &j->jump_count, error);
}

static bool trace_source(job *j) {
    if (SN_TRACE(&j->c.trace, "read", sn_trace_text("format", j->clip.format), sn_trace_number("frames", j->clip.frame_count),
                 sn_trace_number("joints", j->clip.joint_count), sn_trace_number("coordinates", j->clip.coordinate_count)))
        return true;
    for (sn_index i = 0; i < j->jump_count; i++) {
        const sn_clip_jump *jump = &j->jumps[i];
        if (SN_TRACE(&j->c.trace, "jump", sn_trace_text("joint", j->clip.joints[jump->joint].name), sn_trace_number("frame", jump->frame),
                     sn_trace_number("degrees", jump->angle * (180.0 / SN_PI))))
            return true;
    }
    return false;
}

static void warn_of_jumps(const job *j) {
    for (sn_index i = 0; i < j->jump_count && i < JUMPS_TOLD; i++) {
        const sn_clip_jump *jump = &j->jumps[i];
        cli_warn(&j->c, "%s: '%s' turns by %.0f degrees from frame %d to %d; left as it is", j->motion.name,
                 j->clip.joints[jump->joint].name, jump->angle * (180.0 / SN_PI), jump->frame - 1, jump->frame);
    }
    if (j->jump_count > JUMPS_TOLD)
        cli_warn(&j->c, "%s: and %d more such jumps; --report lists them all", j->motion.name, j->jump_count - JUMPS_TOLD);
}

/* ---- list ------------------------------------------------------------------------------------------------------------------ */

/* One field of a line of fields parted by tabs. */
static void print_field(sn_output *output, const char *text) {
    sn_output_write(output, "\t", 1, NULL);
    for (; *text != '\0'; text++) sn_output_write(output, (unsigned char)*text < ' ' ? " " : text, 1, NULL);
}

static void print_number(sn_output *output, double value) {
    char text[32];
    sn_format_number(value, text);
    print_field(output, text);
}

static void print_joint(sn_output *output, const sn_clip *clip, sn_index i) {
    const sn_clip_joint *joint = &clip->joints[i];
    sn_output_print(output, "joint\t%d", i + 1);
    print_field(output, joint->name);
    print_field(output, joint->parent != SN_NONE ? clip->joints[joint->parent].name : "-");
    const double rest[3] = {joint->rest.x, joint->rest.y, joint->rest.z};
    for (int k = 0; k < 3; k++) {
        if (joint->placeless)
            print_field(output, "-");
        else
            print_number(output, rest[k]);
    }
    sn_output_print(output, "\n");
}

static void print_coordinate(sn_output *output, const sn_clip *clip, sn_index i) {
    const sn_clip_coordinate *coordinate = &clip->coordinates[i];
    double low = coordinate->values[0], high = low;
    for (sn_index f = 1; f < clip->frame_count; f++) {
        low = fmin(low, coordinate->values[f]);
        high = fmax(high, coordinate->values[f]);
    }
    sn_output_print(output, "coordinate\t%d", i + 1);
    print_field(output, coordinate->name);
    print_field(output, coordinate->unit);
    print_number(output, low);
    print_number(output, high);
    sn_output_print(output, "\n");
}

static sn_status print_list(const sn_clip *clip, sn_error *error) {
    sn_output *output;
    sn_status status = sn_output_open("-", false, &output, error);
    if (status != SN_OK) return status;
    sn_output_print(output, "format\t%s\nframes\t%d\nrate", clip->format, clip->frame_count);
    print_number(output, clip->rate);
    sn_output_print(output, "\nseconds");
    print_number(output, (clip->frame_count - 1) / clip->rate);
    sn_output_print(output, "\n");
    for (sn_index i = 0; i < clip->animation_count; i++) {
        sn_output_print(output, "animation\t%d", i + 1);
        print_field(output, clip->animations[i].name);
        print_number(output, clip->animations[i].seconds);
        sn_output_print(output, "\n");
    }
    for (sn_index i = 0; i < clip->joint_count; i++) print_joint(output, clip, i);
    for (sn_index i = 0; i < clip->coordinate_count; i++) print_coordinate(output, clip, i);
    status = sn_output_commit(output, error);
    return status == SN_OK ? SN_STOPPED : status;
}

/* ---- report ----------------------------------------------------------------------------------------------------------------- */

/* Length of the first joint's way, metres. */
static double way_of_root(const sn_clip *clip) {
    const sn_clip_joint *root = &clip->joints[0];
    double way = 0.0;
    for (sn_index f = 1; f < clip->frame_count; f++)
        way += sn_distance(sn_rigid_apply(root->poses[f - 1], root->rest), sn_rigid_apply(root->poses[f], root->rest));
    return way;
}

static void write_report(sn_json *json, const void *data) {
    const job *j = data;
    const sn_clip *clip = &j->clip;
    double seconds = (clip->frame_count - 1) / clip->rate, way = way_of_root(clip);
    sn_json_text(json, "source", clip->format);
    sn_json_number(json, "metersPerUnit", clip->meters_per_unit_of_source);
    sn_json_integer(json, "sourceFrames", j->source_frames);
    sn_json_number(json, "sourceRate", j->source_rate);
    sn_json_integer(json, "frames", clip->frame_count);
    sn_json_number(json, "rate", clip->rate);
    sn_json_number(json, "duration", seconds);
    sn_json_integer(json, "joints", clip->joint_count);
    sn_json_integer(json, "coordinates", clip->coordinate_count);
    sn_json_integer(json, "bones", clip->bone_count);
    sn_json_integer(json, "bonesMissing", j->bones.missing);
    sn_json_text(json, "root", clip->joints[0].name);
    sn_json_number(json, "rootWay", way);
    sn_json_number(json, "rootSpeed", seconds > 0.0 ? way / seconds : 0.0);
    sn_json_array(json, "jumps");
    for (sn_index i = 0; i < j->jump_count; i++) {
        sn_json_object(json, NULL);
        sn_json_text(json, "joint", clip->joints[j->jumps[i].joint].name);
        sn_json_integer(json, "frame", j->jumps[i].frame);
        sn_json_number(json, "degrees", j->jumps[i].angle * (180.0 / SN_PI));
        sn_json_close(json);
    }
    sn_json_close(json);
}

/* ---- work ------------------------------------------------------------------------------------------------------------------- */

/* SN_STOPPED where the trace stops: what was not reached is left undone. */
static sn_status process(job *j, sn_error *error) {
    if (cutoff > 0.0 && cutoff >= 0.5 * j->clip.rate)
        cli_usage_error(&j->c, "--filter: %g Hz is not below half of the source's rate, %g Hz", cutoff, j->clip.rate);
    if (trace_source(j)) return SN_STOPPED;
    sn_status status = cutoff > 0.0 ? sn_clip_filter(&j->clip, cutoff, &j->c.trace, error) : SN_OK;
    if (status == SN_OK) status = crop(j, error);
    if (status == SN_OK && rate > 0.0 && rate != j->clip.rate) {
        status = sn_clip_resample(&j->clip, rate, error);
        if (status == SN_OK && SN_TRACE(&j->c.trace, "resample", sn_trace_number("frames", j->clip.frame_count))) return SN_STOPPED;
    }
    return status == SN_OK && bones != NULL ? model_bones_save(&j->c, &j->bones, bones, &j->clip, error) : status;
}

static sn_status save(job *j, sn_error *error) {
    bool document = strcmp(j->clip.format, "motion document") == 0;
    sn_status status = cli_save_clip(&j->c, &j->clip, document ? &j->motion : NULL, error);
    return status == SN_OK ? cli_report(&j->c, write_report, j, error) : status;
}

static sn_status import_motion(job *j, sn_error *error) {
    if (bones == NULL && bone_paths.count > 0) cli_usage_error(&j->c, "--bone-path is for --bones, which was not given");
    if (bones != NULL && *bones == '\0') cli_usage_error(&j->c, "--bones names no folder");
    sn_status status = load(j, error);
    if (status != SN_OK) return status;
    if (list) return print_list(&j->clip, error);
    warn_of_jumps(j);
    status = process(j, error);
    if (status != SN_OK && status != SN_STOPPED) return status;
    cli_say(&j->c, "%s: %d joints, %d frames at %g Hz, %d coordinates", j->clip.format, j->clip.joint_count, j->clip.frame_count,
            j->clip.rate, j->clip.coordinate_count);
    return save(j, error);
}

int main(int argc, char **argv) {
    job j = {0};
    sn_error error = {0};
    cli_start(&j.c, &tool, argc, argv);
    sn_status status = import_motion(&j, &error);
    sn_clip_free(&j.clip);
    sn_model_bones_free(&j.bones);
    sn_blob_free(&j.motion);
    sn_blob_free(&j.skeleton);
    free(j.jumps);
    return cli_finish(&j.c, status, &error);
}
