/* clip.c -- a clip to the output, as a motion document with its history: what the tools that make motions share. */
#include "clip.h"

static sn_status write_motion(const cli *c, const sn_motion *motion, const sn_motion_head *head, sn_error *error) {
    sn_output *output = NULL;
    sn_status status = sn_output_open(c->output, false, &output, error);
    if (status != SN_OK) return status;
    status = sn_motion_document_write(motion, head, output, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

sn_status cli_save_clip(const cli *c, const sn_clip *clip, const sn_blob *source, sn_error *error) {
    sn_motion motion = {0};
    cli_history history = {0};
    sn_motion_head head = {.name = clip->name, .path = c->output, .rate = clip->rate};
    sn_status status = sn_clip_to_motion(clip, &motion, error);
    if (status == SN_OK && c->history) {
        status = cli_history_make(c, &history, error);
        head.entry = &history.entry;
        head.history_from = source;
    }
    if (status == SN_OK) status = write_motion(c, &motion, &head, error);
    cli_history_free(&history);
    sn_motion_free(&motion);
    return status;
}
