/*
 * grips.c -- warnings of bones that hold a muscle badly, in words.
 */
#include "grips.h"

#include <stdio.h>
#include <stdlib.h>

/* Names of the bones whose grip is of this quality, as many as there is room for; returns how many there are. */
static int list_bones(const sn_muscle *muscle, const sn_grip *grips, sn_grip_quality quality, size_t size, char *names) {
    size_t used = 0;
    int count = 0;
    names[0] = '\0';
    for (sn_index i = 0; i < muscle->attachment_count; i++) {
        if (sn_grip_judge(&muscle->attachments[i], &grips[i]) != quality) continue;
        const char *bone = muscle->attachments[i].bone;
        int length = used < size ? snprintf(names + used, size - used, "%s%s", count > 0 ? ", " : "", bone) : 0;
        used += (size_t)length;
        count++;
    }
    if (used >= size) snprintf(names + size - sizeof "...", sizeof "...", "...");
    return count;
}

static void warn_of_grips(const cli *c, const char *name, const sn_muscle *muscle, const sn_grip *grips) {
    char bones[256];
    int slight = list_bones(muscle, grips, SN_GRIP_SLIGHT, sizeof bones, bones);
    if (slight > 0)
        cli_warn(c,
                 "muscle \"%s\": %s hold%s less than 1 %% of the end that is there; a larger --distance of attach-detect, or --landmarks "
                 "around the area, takes more; where nothing attaches, leave the bone out",
                 name, bones, slight == 1 ? "s" : "");
    int speckled = list_bones(muscle, grips, SN_GRIP_SPECKLED, sizeof bones, bones);
    if (speckled > 0)
        cli_warn(
            c,
            "muscle \"%s\": %s hold%s scattered vertices, not an area; a larger --distance of attach-detect, or --landmarks around the "
            "area, joins them",
            name, bones, speckled == 1 ? "s" : "");
}

sn_status grips_warn(const cli *c, const char *name, const sn_muscle *muscle, sn_error *error) {
    const char *only = sn_muscle_only_bone(muscle), *known = name != NULL ? name : "(no name)";
    sn_grip *grips = SN_NEW(sn_grip, muscle->attachment_count);
    if (grips == NULL) return sn_fail_memory(error, "the attachments");
    sn_status status = sn_muscle_grips(muscle, grips, error);
    if (status == SN_OK && only != NULL)
        cli_warn(
            c,
            "muscle \"%s\" is held by one bone only, %s, and moves with it alone; attach-detect holds it by others named with --bone, or "
            "with a larger --distance",
            known, only);
    if (status == SN_OK) warn_of_grips(c, known, muscle, grips);
    free(grips);
    return status;
}
