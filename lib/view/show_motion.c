/* show_motion.c -- a motion at a time: its joints as a stick figure, the bones that hang on them, and the ground. */
#include "show.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { GROUND_LINES = 100 };
static const double JOINT_RADIUS = 0.0050, STICK_RADIUS = 0.0026, GROUND_RADIUS = 0.0005;
static const double SHEER = 0.55; /* opacity of bones with sticks inside */
static const sn_color COLOR_LEFT = {0.16, 0.42, 0.92}, COLOR_RIGHT = {0.86, 0.26, 0.16}, COLOR_MIDDLE = {0.24, 0.25, 0.28};
static const sn_color COLOR_GROUND = {0.66, 0.68, 0.66};

/* ---- joints ---------------------------------------------------------------------------------------------------------------- */

typedef enum side { SIDE_NONE, SIDE_LEFT, SIDE_RIGHT } side;

/* "LeftFoot", "left_femur", "hip_l", "femur_L", "finger_R_1". */
static side side_of_word(const char *name) {
    size_t length = strlen(name);
    if (strncasecmp(name, "left", 4) == 0) return SIDE_LEFT;
    if (strncasecmp(name, "right", 5) == 0) return SIDE_RIGHT;
    for (size_t i = 0; i + 1 < length; i++) {
        char letter = name[i + 1], after = name[i + 2];
        if (name[i] != '_' || (after != '\0' && after != '_' && after != '.')) continue;
        if (letter == 'l' || letter == 'L') return SIDE_LEFT;
        if (letter == 'r' || letter == 'R') return SIDE_RIGHT;
    }
    return SIDE_NONE;
}

/* What motion files call the sides; "lfemur" is left where there is an "rfemur". */
static side side_of(const sn_motion *motion, sn_index j) {
    static const char letters[] = "lrLR";
    const char *name = motion->joints[j].name, *letter = *name != '\0' ? strchr(letters, *name) : NULL;
    side s = side_of_word(name);
    if (s != SIDE_NONE || !letter) return s;
    char other = letters[(letter - letters) ^ 1];
    for (sn_index k = 0; k < motion->joint_count; k++)
        if (motion->joints[k].name[0] == other && strcmp(motion->joints[k].name + 1, name + 1) == 0)
            return (letter - letters) % 2 == 0 ? SIDE_LEFT : SIDE_RIGHT;
    return SIDE_NONE;
}

static sn_color color_of(side s) { return s == SIDE_LEFT ? COLOR_LEFT : s == SIDE_RIGHT ? COLOR_RIGHT : COLOR_MIDDLE; }

static bool has_place(const sn_joint *joint) { return joint->has_rest || joint->kind == SN_JOINT_HINGE; }

static sn_vec3 place_of(const sn_joint *joint) { return joint->has_rest ? joint->rest : joint->point; }

sn_index sn_motion_placeless(const sn_motion *motion) {
    sn_index count = 0;
    for (sn_index j = 0; j < motion->joint_count; j++) count += !has_place(&motion->joints[j]);
    return count;
}

/* The nearest joint above that has a place. */
static sn_index parent_shown(const sn_motion *motion, sn_index j) {
    sn_index parent = motion->joints[j].parent;
    while (parent != SN_NONE && !has_place(&motion->joints[parent])) parent = motion->joints[parent].parent;
    return parent;
}

static sn_status show_joint(sn_view *view, const sn_motion *motion, sn_index j, const sn_rigid *poses, sn_error *error) {
    const sn_joint *joint = &motion->joints[j];
    sn_color color = color_of(side_of(motion, j));
    sn_vec3 at = sn_rigid_apply(poses[j], place_of(joint)), end = sn_rigid_apply(poses[j], joint->end);
    sn_index parent = parent_shown(motion, j);
    sn_status status = sn_view_add_tube(view, (sn_view_tube){at, at, JOINT_RADIUS, color}, error);
    if (!status && parent != SN_NONE) {
        sn_vec3 from = sn_rigid_apply(poses[parent], place_of(&motion->joints[parent]));
        status = sn_view_add_tube(view, (sn_view_tube){from, at, STICK_RADIUS, color}, error);
    }
    if (!status && joint->has_end) status = sn_view_add_tube(view, (sn_view_tube){at, end, STICK_RADIUS, color}, error);
    return status;
}

static sn_status explain_joints(sn_view *view, const sn_motion *motion, sn_error *error) {
    static const char *const words[] = {"joints", "left", "right"};
    bool shown[3] = {false};
    sn_status status = SN_OK;
    for (sn_index j = 0; j < motion->joint_count; j++)
        if (has_place(&motion->joints[j])) shown[side_of(motion, j)] = true;
    for (int s = SIDE_NONE; s <= SIDE_RIGHT && !status; s++)
        if (shown[s]) status = sn_view_add_entry(view, SN_MARK_LINE, color_of((side)s), words[s], error);
    return status;
}

static sn_status show_joints(sn_view *view, const sn_motion *motion, const sn_rigid *poses, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index j = 0; j < motion->joint_count && !status; j++)
        if (has_place(&motion->joints[j])) status = show_joint(view, motion, j, poses, error);
    return status ? status : explain_joints(view, motion, error);
}

sn_status sn_motion_extend(const sn_motion *motion, double time, sn_box *box, sn_error *error) {
    sn_rigid *poses = SN_NEW(sn_rigid, motion->joint_count);
    if (!poses) return sn_fail_memory(error, "the joints' poses");
    sn_motion_poses(motion, time, poses);
    for (sn_index j = 0; j < motion->joint_count; j++) {
        const sn_joint *joint = &motion->joints[j];
        if (!has_place(joint)) continue;
        const sn_vec3 points[2] = {place_of(joint), joint->end};
        for (int i = 0; i < 1 + joint->has_end; i++) {
            sn_vec3 p = sn_rigid_apply(poses[j], points[i]);
            *box = (sn_box){sn_min3(box->low, p), sn_max3(box->high, p)};
        }
    }
    free(poses);
    return SN_OK;
}

/* ---- bones ------------------------------------------------------------------------------------------------------------------- */

static sn_status show_surfaces(sn_view *view, const sn_motion *motion, const sn_mesh *meshes, const sn_rigid *poses, unsigned show,
                               sn_error *error) {
    bool any = false;
    sn_status status = SN_OK;
    for (sn_index b = 0; b < motion->bone_count && !status; b++) {
        sn_index joint = motion->bones[b].joint;
        if (meshes[b].triangle_count == 0) continue;
        status = sn_view_add_bone(view, NULL, &meshes[b], (sn_placement){1.0, joint == SN_NONE ? NULL : &poses[joint]}, error);
        if (!status) status = name_mesh(view, motion->bones[b].name, error);
        if (status) break;
        view->meshes[view->mesh_count - 1].opacity = show & SN_SHOW_JOINTS ? SHEER : 1.0;
        view->meshes[view->mesh_count - 1].wire = (show & SN_SHOW_WIRE) != 0;
        any = true;
    }
    return status || !any ? status : sn_view_add_entry(view, SN_MARK_AREA, COLOR_BONE, "bones", error);
}

sn_status sn_view_add_motion(sn_view *view, const sn_motion *motion, const sn_mesh *meshes, double time, unsigned show, sn_error *error) {
    if (show & SN_SHOW_AUTO) show |= SN_SHOW_JOINTS | SN_SHOW_BONES;
    sn_rigid *poses = SN_NEW(sn_rigid, motion->joint_count);
    if (!poses) return sn_fail_memory(error, "the joints' poses");
    sn_motion_poses(motion, time, poses);
    sn_status status = meshes && show & SN_SHOW_BONES ? show_surfaces(view, motion, meshes, poses, show, error) : SN_OK;
    if (!status && show & SN_SHOW_JOINTS) status = show_joints(view, motion, poses, error);
    free(poses);
    return status;
}

/* ---- the ground -------------------------------------------------------------------------------------------------------------- */

sn_box sn_view_box(const sn_view *view) {
    sn_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t m = 0; m < view->mesh_count; m++)
        for (sn_index i = 0; i < view->meshes[m].vertex_count; i++) {
            sn_vec3 p = view->meshes[m].positions[i];
            box = (sn_box){sn_min3(box.low, p), sn_max3(box.high, p)};
        }
    for (size_t t = 0; t < view->tube_count; t++) {
        const sn_view_tube *tube = &view->tubes[t];
        box = (sn_box){sn_min3(box.low, sn_min3(tube->a, tube->b)), sn_max3(box.high, sn_max3(tube->a, tube->b))};
    }
    return box;
}

/* The greatest of 1, 2, 5 x 10^k that is not above a positive number. */
static double round_down(double x) {
    double power = sn_pow(10.0, floor(sn_log10(x) + 1e-9));
    return power * (x >= 5.0 * power ? 5.0 : x >= 2.0 * power ? 2.0 : 1.0);
}

/* Lines along y a step apart from low.x to high.x, multiples of it; along x where `turned`. */
static sn_status add_lines(sn_view *view, sn_box box, double step, bool turned, sn_error *error) {
    double from = turned ? box.low.y : box.low.x, to = turned ? box.high.y : box.high.x, z = box.low.z;
    int count = (int)fmin(round((to - from) / step), GROUND_LINES);
    sn_status status = SN_OK;
    for (int i = 0; i <= count && !status; i++) {
        double at = from + i * step;
        sn_view_tube line = {sn_v3(at, box.low.y, z), sn_v3(at, box.high.y, z), GROUND_RADIUS, COLOR_GROUND};
        if (turned) {
            line.a = sn_v3(box.low.x, at, z);
            line.b = sn_v3(box.high.x, at, z);
        }
        status = sn_view_add_tube(view, line, error);
    }
    return status;
}

sn_status sn_view_add_ground(sn_view *view, sn_box box, sn_error *error) {
    double size = sn_box_diagonal(box);
    if (!(size > 0.0) || !isfinite(size)) return SN_OK;
    double step = round_down(0.15 * size);
    sn_box floor_box = {sn_v3(step * floor(box.low.x / step), step * floor(box.low.y / step), box.low.z),
                        sn_v3(step * ceil(box.high.x / step), step * ceil(box.high.y / step), box.low.z)};
    sn_status status = add_lines(view, floor_box, step, false, error);
    if (!status) status = add_lines(view, floor_box, step, true, error);
    char text[96];
    snprintf(text, sizeof text, "floor of the motion: z = %.3f m, lines %g m apart", box.low.z, step);
    return status ? status : sn_view_add_entry(view, SN_MARK_LINE, COLOR_GROUND, text, error);
}
