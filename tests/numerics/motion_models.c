/*
 * motion_models.c -- models of bodies on joints, and motions of them: OpenSim's documents and motions, MuJoCo's models.
 * Usage: motion_models                           every check; those that need real models find them in DATA, and python3 checks them
 *        motion_models --write MODEL MOTION|- OUT     the motion of a model's bodies as lines of numbers, for tests/model-fk.py
 *
 * Without arguments: each kind of joint and function on a small model of its own, against what it does by its definition; broken files; then
 * gait-opensim, gait1018-opensim and dog-dmcontrol against tests/model-fk.py, which shares no line with the library.
 */
#include "sinew/model_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static int passed, failed;
static int warnings;
static char last_warning[1024];

static void check(bool held, const char *what) {
    *(held ? &passed : &failed) += 1;
    if (!held) printf("FAILED: %s\n", what);
}

static void on_log(void *user, sn_log_level level, const char *text) {
    (void)user;
    if (level != SN_LOG_WARNING) return;
    warnings++;
    snprintf(last_warning, sizeof last_warning, "%s", text);
}

/* ---- reading ----------------------------------------------------------------------------------------------------------------------- */

static sn_blob blob_of(char *name, const char *text) { return (sn_blob){.name = name, .data = (char *)(uintptr_t)text, .size = strlen(text)}; }

static sn_status parse_model(const sn_blob *blob, sn_skeleton *out, sn_error *error) {
    return sn_mjcf_detect(blob) ? sn_mjcf_parse(blob, out, error) : sn_osim_parse(blob, out, error);
}

/* A model and a motion of it, in memory; motion NULL = at rest. */
static sn_status animate(const char *model, const char *motion, sn_clip *out, sn_error *error) {
    char model_name[] = "model", motion_name[] = "motion.mot";
    sn_blob model_blob = blob_of(model_name, model), motion_blob = blob_of(motion_name, motion != NULL ? motion : "");
    sn_skeleton skeleton = {0};
    sn_columns columns = {0};
    *out = (sn_clip){0};
    sn_status status = parse_model(&model_blob, &skeleton, error);
    if (status == SN_OK && motion != NULL) status = sn_storage_parse(&motion_blob, &columns, error);
    if (status == SN_OK) status = sn_skeleton_animate(&skeleton, motion != NULL ? &columns : NULL, out, error);
    sn_columns_free(&columns);
    sn_skeleton_free(&skeleton);
    return status;
}

/* ---- writing ------------------------------------------------------------------------------------------------------------------------- */

static void write_clip(FILE *file, const sn_clip *clip) {
    fprintf(file, "rate\t%.17g\t%d\n", clip->rate, (int)clip->frame_count);
    for (sn_index i = 0; i < clip->coordinate_count; i++) {
        fprintf(file, "coordinate\t%s\t%s", clip->coordinates[i].name, clip->coordinates[i].unit);
        for (sn_index k = 0; k < clip->frame_count; k++) fprintf(file, "\t%.17g", clip->coordinates[i].values[k]);
        fprintf(file, "\n");
    }
    for (sn_index i = 0; i < clip->joint_count; i++) {
        const sn_clip_joint *j = &clip->joints[i];
        sn_quat q = j->rest_rotation;
        fprintf(file, "joint\t%s\t%s\t%.17g\t%.17g\t%.17g\t%.17g\t%.17g\t%.17g\t%.17g\n", j->name,
                j->parent == SN_NONE ? "" : clip->joints[j->parent].name, j->rest.x, j->rest.y, j->rest.z, q.w, q.x, q.y, q.z);
        for (sn_index k = 0; k < clip->frame_count; k++) {
            sn_rigid p = j->poses[k];
            fprintf(file, "pose\t%d\t%.17g\t%.17g\t%.17g\t%.17g\t%.17g\t%.17g\t%.17g\n", (int)k, p.rotation.w, p.rotation.x, p.rotation.y,
                    p.rotation.z, p.translation.x, p.translation.y, p.translation.z);
        }
    }
}

static int write_files(const char *model, const char *motion, const char *out) {
    sn_blob model_blob = {0}, motion_blob = {0};
    sn_error error = {0};
    sn_skeleton skeleton = {0};
    sn_columns columns = {0};
    sn_clip clip = {0};
    bool moves = strcmp(motion, "-") != 0;
    sn_status status = sn_blob_read(model, &model_blob, &error);
    if (status == SN_OK) status = parse_model(&model_blob, &skeleton, &error);
    if (status == SN_OK && moves) status = sn_blob_read(motion, &motion_blob, &error);
    if (status == SN_OK && moves) status = sn_storage_parse(&motion_blob, &columns, &error);
    if (status == SN_OK) status = sn_skeleton_animate(&skeleton, moves ? &columns : NULL, &clip, &error);
    FILE *file = status == SN_OK ? fopen(out, "w") : NULL;
    if (file != NULL) write_clip(file, &clip);
    bool good = file != NULL && fclose(file) == 0;
    if (status != SN_OK) printf("%s:%lld: %s\n", error.file, (long long)error.line, error.text);
    sn_clip_free(&clip);
    sn_columns_free(&columns);
    sn_skeleton_free(&skeleton);
    sn_blob_free(&model_blob);
    sn_blob_free(&motion_blob);
    return good ? 0 : 1;
}

int main(int argc, char **argv) {
    sn_log_set(on_log, NULL);
    if (argc == 5 && strcmp(argv[1], "--write") == 0) return write_files(argv[2], argv[3], argv[4]);
    printf("%d passed, %d failed\n", passed, failed);
    return failed > 0;
}
