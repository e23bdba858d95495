/* scene_list.c -- what would be in a scene, a line each. */
#include "scene_list.h"

#include <string.h>

/* One field of a line of fields parted by tabs. */
static void print_field(sn_output *output, const char *text) {
    sn_output_write(output, "\t", 1, NULL);
    for (; *text != '\0'; text++) sn_output_write(output, (unsigned char)*text < ' ' ? " " : text, 1, NULL);
}

static void print_number(sn_output *output, const char *name, double value) {
    char text[32];
    sn_format_number(value, text);
    sn_output_print(output, "%s\t%s\n", name, text);
}

/* How many muscles a bone holds. */
static sn_index count_muscles(const sn_scene_draft *draft, const char *bone) {
    sn_index count = 0;
    for (sn_index i = 0; i < draft->muscle_count; i++) {
        const sn_draft_muscle *m = &draft->muscles[i];
        bool holds = false;
        for (sn_index a = 0; a < m->rig.attachment_count && !m->left_out; a++) holds |= strcmp(m->rig.attachments[a].bone, bone) == 0;
        count += holds;
    }
    return count;
}

static void print_bone(sn_output *output, const sn_scene_draft *draft, sn_index i) {
    const sn_motion_bone *bone = &draft->bones[i].bone;
    sn_output_print(output, "bone\t%d", i + 1);
    print_field(output, bone->name);
    print_field(output, bone->joint != SN_NONE ? draft->motion.joints[bone->joint].name : "-");
    sn_output_print(output, "\t%d", count_muscles(draft, bone->name));
    print_field(output, bone->path);
    sn_output_print(output, "\n");
}

static void print_envelope(sn_output *output, const sn_scene_draft *draft, sn_index i) {
    sn_output_print(output, "envelope\t%d", i + 1);
    print_field(output, draft->envelopes[i].name);
    sn_output_print(output, "\t%d", count_muscles(draft, draft->envelopes[i].name));
    print_field(output, draft->envelopes[i].path);
    sn_output_print(output, "\n");
}

static void print_bones_of(sn_output *output, const sn_draft_muscle *muscle) {
    sn_output_print(output, "\t");
    if (muscle->rig.attachment_count == 0) sn_output_print(output, "-");
    for (sn_index a = 0; a < muscle->rig.attachment_count; a++)
        sn_output_print(output, "%s%s", a > 0 ? "," : "", muscle->rig.attachments[a].bone);
}

static void print_muscle(sn_output *output, const sn_draft_muscle *muscle, sn_index number) {
    sn_output_print(output, "muscle\t%d", number);
    print_field(output, muscle->name);
    sn_output_print(output, "\t%d", muscle->rig.mesh.triangle_count);
    print_bones_of(output, muscle);
    print_field(output, muscle->has_channel ? "channel" : "-");
    print_field(output, muscle->path);
    sn_output_print(output, "\n");
    for (int i = 0; i < SN_DRAFT_MEMBERS; i++) {
        if (muscle->settings[i] == NULL) continue;
        sn_output_print(output, "set\t%d", number);
        print_field(output, muscle->name);
        print_field(output, sn_draft_members[i]);
        print_field(output, muscle->settings[i]);
        sn_output_print(output, "\n");
    }
}

static void print_head(sn_output *output, const sn_scene_draft *draft) {
    sn_output_print(output, "name");
    print_field(output, draft->name != NULL ? draft->name : "-");
    sn_output_print(output, "\nmotion");
    print_field(output, draft->motion_path != NULL ? draft->motion_path : "-");
    sn_output_print(output, "\njoints\t%d\nframes\t%d\t%d\n", draft->motion.joint_count, draft->first_frame, draft->last_frame);
    print_number(output, "rate", draft->rate);
    print_number(output, "preroll", draft->preroll);
    print_number(output, "runIn", draft->run_in);
    sn_output_print(output, "solver\t%s\n", sn_solver_method_names[draft->method]);
}

sn_status scene_list_print(const sn_scene_draft *draft, sn_error *error) {
    sn_output *output;
    sn_index number = 0;
    sn_status status = sn_output_open("-", false, &output, error);
    if (status != SN_OK) return status;
    print_head(output, draft);
    for (sn_index i = 0; i < draft->bone_count; i++) print_bone(output, draft, i);
    for (sn_index i = 0; i < draft->envelope_count; i++) print_envelope(output, draft, i);
    for (sn_index i = 0; i < draft->muscle_count; i++)
        if (!draft->muscles[i].left_out) print_muscle(output, &draft->muscles[i], ++number);
    status = sn_output_commit(output, error);
    return status == SN_OK ? SN_STOPPED : status;
}
