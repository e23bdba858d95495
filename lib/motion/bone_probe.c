/* bone_probe.c -- which points lie inside the bones of a scene, and how deep. */
#include "sinew/fibers.h"
#include "sinew/geom.h"

#include <math.h>
#include <stdlib.h>

/* A place in a bone's rest frame, in its mesh's unit, and its signed distance there; 0 = not looked yet. */
typedef struct probe_look {
    sn_vec3 from;
    double distance;
} probe_look;

typedef struct probe_bone {
    sn_surface *surface;
    sn_box box;             /* of its mesh */
    double meters_per_unit; /* of its mesh */
    sn_index joint;         /* SN_NONE = it never moves */
    bool closed;            /* nothing comes from its outside to its inside but through its surface */
    sn_rigid to_rest;       /* of the call at hand */
    probe_look last;        /* in that */
    double side;            /* of the cells of its box */
    sn_index cells[3];      /* along each axis */
    float *far;             /* (cells[0] x cells[1] x cells[2]) signed distance from a cell's centre; 0 = not looked yet; NULL = none yet */
} probe_bone;

/* Most cells of a bone: those that fibres come through are looked at once, and tell of all points in them in any frame. */
enum { MOST_CELLS = 1 << 17 };

/* Less than a distance that was measured, by more than rounding. */
static const double SAFELY = 1.0 - 1e-9, SAFELY_SINGLE = 1.0 - 1e-6, SAFELY_DEEP = 1.0 - 3e-6; /* the cells' are single */

struct sn_bone_probe {
    sn_index bone_count;
    probe_bone *bones; /* (bone_count) */
};

/* Cubes, as many as there may be. */
static void cut_box(probe_bone *bone) {
    sn_vec3 size = sn_sub(bone->box.high, bone->box.low);
    double longest = fmax(size.x, fmax(size.y, size.z)), volume = size.x * size.y * size.z;
    if (!bone->closed || !(longest > 0.0) || !(volume > 0.0)) return;
    const double extent[3] = {size.x, size.y, size.z};
    bone->side = longest / 4096.0;
    for (double all = INFINITY; all > MOST_CELLS;) {
        bone->side *= 1.05;
        all = 1.0;
        for (int k = 0; k < 3; k++) {
            bone->cells[k] = (sn_index)(extent[k] / bone->side) + 1;
            all *= bone->cells[k];
        }
    }
}

sn_status sn_bone_probe_create(const sn_scene *scene, sn_bone_probe **out, sn_error *error) {
    sn_bone_probe *probe = *out = SN_NEW(sn_bone_probe, 1);
    if (probe == NULL || (probe->bones = SN_NEW(probe_bone, scene->bone_count)) == NULL) {
        sn_bone_probe_destroy(probe);
        *out = NULL;
        return sn_fail_memory(error, "the bones");
    }
    sn_status status = SN_OK;
    for (sn_index i = 0; i < scene->bone_count && status == SN_OK; i++) {
        const sn_scene_bone *from = &scene->bones[i];
        probe_bone *to = &probe->bones[probe->bone_count++];
        *to = (probe_bone){.box = sn_mesh_box(&from->mesh), .meters_per_unit = from->meters_per_unit, .joint = from->joint};
        sn_mesh_report report = {0};
        status = sn_mesh_inspect(&from->mesh, &report, error);
        to->closed = report.closed && report.manifold && report.oriented;
        cut_box(to);
        if (status == SN_OK) status = sn_surface_create(&from->mesh, &to->surface, error);
        if (status != SN_OK) sn_error_set_file(error, from->uri);
    }
    if (status == SN_OK) return SN_OK;
    sn_bone_probe_destroy(probe);
    *out = NULL;
    return status;
}

void sn_bone_probe_destroy(sn_bone_probe *probe) {
    if (probe == NULL) return;
    for (sn_index i = 0; i < probe->bone_count; i++) {
        sn_surface_destroy(probe->bones[i].surface);
        free(probe->bones[i].far);
    }
    free(probe->bones);
    free(probe);
}

static bool in_box(sn_box box, sn_vec3 p) {
    return p.x >= box.low.x && p.y >= box.low.y && p.z >= box.low.z && p.x <= box.high.x && p.y <= box.high.y && p.z <= box.high.z;
}

static sn_index cell_along(const probe_bone *bone, int axis, double from_low) {
    sn_index cell = (sn_index)(from_low / bone->side);
    return cell < bone->cells[axis] ? cell : bone->cells[axis] - 1;
}

/* The signed distance from the centre of the cell that p, in the box, is in; 0 = not known, for want of memory or of an inside. */
static double look_from_cell(probe_bone *bone, sn_vec3 p, sn_vec3 *centre) {
    if (!(bone->side > 0.0)) return 0.0;
    if (bone->far == NULL) bone->far = SN_NEW(float, (size_t)bone->cells[0] * (size_t)bone->cells[1] * (size_t)bone->cells[2]);
    if (bone->far == NULL) return 0.0;
    sn_vec3 d = sn_sub(p, bone->box.low);
    sn_index i = cell_along(bone, 0, d.x), j = cell_along(bone, 1, d.y), k = cell_along(bone, 2, d.z);
    float *far = &bone->far[((size_t)i * (size_t)bone->cells[1] + (size_t)j) * (size_t)bone->cells[2] + (size_t)k];
    *centre = sn_add(bone->box.low, sn_scale(sn_v3(i + 0.5, j + 0.5, k + 0.5), bone->side));
    if (*far == 0.0f) *far = (float)(sn_surface_signed_distance(bone->surface, *centre, NULL) * SAFELY_SINGLE);
    return (double)*far;
}

/* Points of a fibre are near each other: one that is nearer to the last look than the surface was from there is on the same side. Sets
 * *depth to 0 outside, inside to what it is at least, and is true where no more needs to be known, as it is no deeper than `least`. */
static bool is_told(const probe_bone *bone, sn_vec3 p, const probe_look *look, double least, double *depth) {
    double step = sn_distance(p, look->from), reach = fabs(look->distance);
    *depth = 0.0;
    if (!bone->closed || !(step < reach * SAFELY)) return false;
    if (look->distance > 0.0) return true;
    *depth = (reach - step) * bone->meters_per_unit;
    return (reach + step) * bone->meters_per_unit < least * SAFELY_DEEP;
}

/* Metres below the bone's surface, at its place at rest; 0 or less outside; a lesser one where the true one is below `least`. p in metres,
 * where the bone is. */
static double depth_in(probe_bone *bone, sn_vec3 p, double least) {
    double depth;
    if (bone->joint != SN_NONE) p = sn_rigid_apply(bone->to_rest, p);
    p = sn_scale(p, 1.0 / bone->meters_per_unit);
    if (!in_box(bone->box, p)) return 0.0;
    if (is_told(bone, p, &bone->last, least, &depth)) return depth;
    probe_look cell = {.from = p};
    cell.distance = look_from_cell(bone, p, &cell.from);
    if (is_told(bone, p, &cell, least, &depth)) return depth;
    bone->last = (probe_look){p, sn_surface_signed_distance(bone->surface, p, NULL)};
    return -bone->last.distance * bone->meters_per_unit;
}

sn_penetration sn_bone_probe_points(sn_bone_probe *probe, const sn_rigid *poses, sn_index count, const sn_vec3 *points,
                                    double meters_per_unit) {
    sn_penetration found = {.bone = SN_NONE};
    for (sn_index b = 0; b < probe->bone_count; b++) {
        probe_bone *bone = &probe->bones[b];
        bone->last.distance = 0.0;
        if (bone->joint != SN_NONE) bone->to_rest = sn_rigid_inverse(poses[bone->joint]);
    }
    for (sn_index i = 0; i < count; i++) {
        double deepest = 0.0;
        for (sn_index b = 0; b < probe->bone_count; b++) {
            double depth = depth_in(&probe->bones[b], sn_scale(points[i], meters_per_unit), found.deepest);
            if (!(depth > deepest)) continue;
            deepest = depth;
            if (depth <= found.deepest) continue;
            found.deepest = depth;
            found.bone = b;
        }
        found.inside += deepest > 0.0;
    }
    return found;
}
