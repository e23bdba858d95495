/* others.c -- simulate's work on some muscles of many. */
#include "others.h"
#include "frame_files.h"

#include <stdlib.h>
#include <unistd.h>

static void check_usage(const cli *c, const other_choices *with) {
    if (with->frozen != NULL && with->muscles.count == 0)
        cli_usage_error(c, "--freeze-others needs --muscle NAME: the muscles that are to be simulated");
    if (with->frozen != NULL && !frame_folder_is(with->frozen))
        cli_usage_error(c, "--freeze-others %s: write the folder of an earlier run's frames (-o)", with->frozen);
}

/* wanted (muscle_count): those that some name matches. */
static void find_wanted(const cli *c, const cli_list *names, const sn_scene *scene, bool *wanted) {
    for (int n = 0; n < names->count; n++) {
        bool found = false, off = false;
        for (sn_index i = 0; i < scene->muscle_count; i++) {
            if (scene->muscles[i].name == NULL || !sn_pattern_matches(names->items[n], scene->muscles[i].name)) continue;
            if (scene->muscles[i].enabled)
                found = wanted[i] = true;
            else
                off = true;
        }
        if (!found && off) cli_usage_error(c, "--muscle %s: the scene has it, and does not enable it", names->items[n]);
        if (!found) cli_usage_error(c, "--muscle %s: no muscle of the scene has such a name", names->items[n]);
    }
}

/* An earlier run's frames of a muscle: its cache, or its sequence ("FOLDER/NAME.#.ply"). */
static sn_status read_frames(const cli *c, const char *folder, const sn_scene *scene, const sn_scene_muscle *muscle, sn_vertex_track *out,
                             sn_error *error) {
    const sn_track_options options = {
        .vertex_count = muscle->rig.mesh.vertex_count, .rate = scene->rate, .meters_per_unit = muscle->rig.meters_per_unit};
    char *cache = frame_path(folder, muscle->name, ".pc2"), *prefix = frame_path(folder, muscle->name, ""),
         *sequence = frame_path(folder, muscle->name, ".#.ply");
    frame_sequence there = {0};
    sn_status status = cache != NULL && prefix != NULL && sequence != NULL ? SN_OK : sn_fail_memory(error, "the frames");
    bool cached = status == SN_OK && access(cache, F_OK) == 0;
    if (status == SN_OK && !cached) status = frame_sequence_find(prefix, ".ply", &there, error);
    if (status == SN_OK && !cached && there.count == 0)
        status = sn_fail_at(error, SN_ERROR_INPUT, folder, 0, "has no frames of the muscle \"%s\", which is tied to what is asked for",
                            muscle->name);
    if (status == SN_OK && cached && frame_sequence_find(prefix, ".ply", &there, NULL) == SN_OK && there.count > 0)
        cli_warn(c, "%s has a cache and a sequence of \"%s\"; the cache is taken", folder, muscle->name);
    if (status == SN_OK) status = sn_vertex_track_read(cached ? cache : sequence, &options, out, error);
    free(cache);
    free(prefix);
    free(sequence);
    return status;
}

static sn_status freeze(const cli *c, const char *folder, sn_scene *scene, sn_index muscle, sn_error *error) {
    sn_vertex_track track = {0};
    sn_status status = read_frames(c, folder, scene, &scene->muscles[muscle], &track, error);
    if (status == SN_OK) status = sn_scene_freeze(scene, muscle, &track, error);
    sn_vertex_track_free(&track);
    return status;
}

static sn_status take(const cli *c, const other_choices *with, sn_scene *scene, bool *wanted, bool *needed, sn_error *error) {
    find_wanted(c, &with->muscles, scene, wanted);
    sn_index tied = 0;
    sn_status status = sn_scene_choose(scene, wanted, with->frozen != NULL, needed, error);
    for (sn_index i = 0; i < scene->muscle_count && status == SN_OK; i++) {
        sn_scene_muscle *muscle = &scene->muscles[i];
        if (wanted[i] || !muscle->enabled) continue;
        muscle->enabled = needed[i], muscle->unseen = true;
        tied += needed[i];
        if (needed[i] && with->frozen != NULL) status = freeze(c, with->frozen, scene, i, error);
    }
    if (status == SN_OK)
        cli_say(c, "%d other muscles are tied to these, and %s", (int)tied, with->frozen != NULL ? "frozen" : "stepped, too");
    return status;
}

sn_status others_apply(const cli *c, const other_choices *with, sn_scene *scene, sn_error *error) {
    check_usage(c, with);
    if (with->muscles.count == 0) return SN_OK;
    if (with->frozen != NULL && !scene->externals.enabled)
        cli_warn(
            c, "--freeze-others has no effect: external constraints are off, and nothing is tied to anything (--externals turns them on)");
    bool *wanted = SN_NEW(bool, scene->muscle_count), *needed = SN_NEW(bool, scene->muscle_count);
    sn_status status =
        wanted != NULL && needed != NULL ? take(c, with, scene, wanted, needed, error) : sn_fail_memory(error, "the muscles");
    free(wanted);
    free(needed);
    return status;
}

sn_status others_leave_out(const cli *c, const cli_list *names, sn_scene *scene, sn_error *error) {
    if (names->count == 0) return SN_OK;
    bool *wanted = SN_NEW(bool, scene->muscle_count);
    if (wanted == NULL) return sn_fail_memory(error, "the muscles");
    find_wanted(c, names, scene, wanted);
    for (sn_index i = 0; i < scene->muscle_count; i++) scene->muscles[i].enabled = wanted[i];
    free(wanted);
    return SN_OK;
}
