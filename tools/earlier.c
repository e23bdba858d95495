/* earlier.c -- logs and sequences that simulate --from goes on with; the library does that for caches, tables and collections. */
#include "earlier.h"
#include "frame_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

sn_status earlier_whole(const char *path, sn_index continued, sn_index count, sn_error *error) {
    if (continued == 0 || continued == count) return SN_OK;
    return sn_fail_at(error, SN_ERROR_USAGE, path, 0,
                      "holds %ld of %ld outputs of the earlier run: those that are missing would begin in the middle; name another folder",
                      (long)continued, (long)count);
}

/* ---- the log ---------------------------------------------------------------------------------------------------------------- */

/* How the line of a muscle begins, without the newline; data NULL = out of memory. */
static sn_blob line_head(sn_index frame, double rate, const char *muscle) {
    sn_output *memory = NULL;
    sn_blob blob = {0};
    if (sn_output_open_memory(&memory, NULL) != SN_OK) return blob;
    sn_json *json = sn_json_begin(memory, false);
    if (json != NULL) {
        sn_json_object(json, NULL);
        sn_json_integer(json, "frame", frame);
        sn_json_number(json, "time", frame / rate);
        sn_json_text(json, "muscle", muscle);
        sn_json_close(json);
    }
    if (json == NULL || sn_json_end(json, NULL) != SN_OK || sn_output_take(memory, "", &blob, NULL) != SN_OK) return (sn_blob){0};
    blob.size -= strlen("}\n");
    return blob;
}

/* The frame that a line tells. */
static bool frame_of(const char *line, int64_t *frame) {
    static const char head[] = "{\"frame\":";
    const char *next;
    return strncmp(line, head, strlen(head)) == 0 && sn_scan_integer(line + strlen(head), line + strlen(line), &next, frame);
}

/* Past the lines of one frame, where each is its muscle's; NULL = they are not. inside: of a frame that was stopped in. */
static const char *pass_frame(const char *at, const sn_model *model, sn_index frame, double rate, bool inside) {
    for (sn_index i = 0; i < model->muscle_count; i++) {
        int64_t told;
        if (model->muscles[i].source->unseen) continue;
        sn_blob head = line_head(frame, rate, model->muscles[i].source->name);
        bool same = head.data != NULL && (inside ? frame_of(at, &told) && told == frame : strncmp(at, head.data, head.size) == 0);
        const char *newline = strchr(at, '\n');
        sn_blob_free(&head);
        if (!same || newline == NULL) return NULL;
        at = newline + 1;
    }
    return at;
}

/* The frame of the last whole line. */
static int64_t last_frame(const char *text, int64_t first) {
    int64_t last = first;
    for (const char *newline; (newline = strchr(text, '\n')) != NULL; text = newline + 1) (void)frame_of(text, &last);
    return last;
}

/* *keep: bytes that stay; 0 = the log is to be written anew. */
static sn_status check_log(const sn_blob *log, const sn_model *model, sn_resume *resume, uint64_t *keep, sn_error *error) {
    int64_t first;
    bool goes_on;
    const char *at = log->data;
    if (!frame_of(at, &first))
        return sn_fail_at(error, SN_ERROR_USAGE, log->name, 0, "is not the log of an earlier run; name another file");
    sn_status status = sn_resume_take(resume, log->name, first, last_frame(at, first), &goes_on, error);
    if (status != SN_OK || !goes_on) return status;
    for (int64_t frame = first; frame < resume->next && at != NULL; frame++)
        at = pass_frame(at, model, (sn_index)frame, resume->rate, false);
    bool inside = resume->next == resume->frame;
    *keep = at != NULL ? (uint64_t)(at - log->data) : 0;
    if (at == NULL || (inside && pass_frame(at, model, resume->frame, resume->rate, true) == NULL))
        return sn_fail_at(error, SN_ERROR_USAGE, log->name, 0,
                          "does not hold every frame and muscle of the run until frame %ld; name another file", (long)resume->frame);
    return SN_OK;
}

sn_status earlier_log(const char *path, const sn_model *model, sn_resume *resume, sn_output **out, sn_error *error) {
    sn_blob log = {0};
    uint64_t keep = 0;
    *out = NULL;
    if (path == NULL || strcmp(path, "-") == 0 || !sn_resume_exists(path)) return SN_OK;
    sn_status status = sn_blob_read_bytes(path, &log, error);
    if (status == SN_OK) status = check_log(&log, model, resume, &keep, error);
    sn_blob_free(&log);
    return status == SN_OK && keep > 0 ? sn_output_open_behind(path, keep, true, out, error) : status;
}

/* ---- sequences of meshes ------------------------------------------------------------------------------------------------------ */

/* Does the file of the state's frame hold the mesh, byte for byte? */
static sn_status compare(const char *path, const sn_mesh *mesh, const sn_resume *resume, sn_error *error) {
    sn_output *memory = NULL;
    sn_blob made = {0}, there = {0};
    sn_status status = sn_output_open_memory(&memory, error);
    if (status != SN_OK) return status;
    status = sn_mesh_write(mesh, SN_MESH_PLY, SN_ENCODING_LITTLE, memory, error);
    if (status != SN_OK)
        sn_output_abort(memory);
    else
        status = sn_output_take(memory, path, &made, error);
    if (status == SN_OK) status = sn_blob_read_bytes(path, &there, error);
    if (status == SN_OK && (there.size != made.size || memcmp(there.data, made.data, made.size) != 0))
        status = sn_resume_differs(resume, path, error);
    sn_blob_free(&made);
    sn_blob_free(&there);
    return status;
}

sn_status earlier_sequence(const char *prefix, const sn_mesh *mesh, sn_resume *resume, bool *goes_on, sn_error *error) {
    frame_sequence there;
    *goes_on = false;
    sn_status status = frame_sequence_find(prefix, ".ply", &there, error);
    if (status != SN_OK || there.count == 0) return status;
    char *path = frame_number(prefix, resume->frame, ".ply");
    if (path == NULL) return sn_fail_memory(error, "the frames");
    status = sn_resume_take(resume, path, there.first, there.last, goes_on, error);
    if (status == SN_OK && *goes_on && there.count != (int64_t)there.last - there.first + 1)
        status =
            sn_fail_at(error, SN_ERROR_USAGE, path, 0, "of the frames %ld to %ld of this sequence some are missing; name another folder",
                       (long)there.first, (long)there.last);
    if (status == SN_OK && *goes_on) status = compare(path, mesh, resume, error);
    free(path);
    return status;
}
