/* bone_probe.c -- which points lie inside the bones of a scene, and how deep. */
#include "sinew/fibers.h"
#include "sinew/geom.h"

#include <stdlib.h>

typedef struct probe_bone {
    sn_surface *surface;
    sn_box box;             /* of its mesh */
    double meters_per_unit; /* of its mesh */
    sn_index joint;         /* SN_NONE = it never moves */
    bool closed;            /* nothing comes from its outside to its inside but through its surface */
    sn_rigid to_rest;       /* of the call at hand */
    sn_vec3 looked_at;      /* where its distance was measured last in that, in its mesh's unit */
    double distance;        /* what it was there; 0 = nowhere yet */
} probe_bone;

/* Less than a distance that was measured, by more than rounding. */
static const double SAFELY = 1.0 - 1e-9;

struct sn_bone_probe {
    sn_index bone_count;
    probe_bone *bones; /* (bone_count) */
};

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
    for (sn_index i = 0; i < probe->bone_count; i++) sn_surface_destroy(probe->bones[i].surface);
    free(probe->bones);
    free(probe);
}

static bool in_box(sn_box box, sn_vec3 p) {
    return p.x >= box.low.x && p.y >= box.low.y && p.z >= box.low.z && p.x <= box.high.x && p.y <= box.high.y && p.z <= box.high.z;
}

/* Points of a fibre are near each other: one that is nearer to the last look than the surface was from there is on the same side. Sets
 * *depth to 0 outside, inside to what it is at least, and is true where no more needs to be known, as it is no deeper than `least`. */
static bool is_told(const probe_bone *bone, sn_vec3 p, double least, double *depth) {
    double step = sn_distance(p, bone->looked_at), reach = fabs(bone->distance);
    *depth = 0.0;
    if (!bone->closed || !(step < reach * SAFELY)) return false;
    if (bone->distance > 0.0) return true;
    *depth = (reach - step) * bone->meters_per_unit;
    return (reach + step) * bone->meters_per_unit < least * SAFELY;
}

/* Metres below the bone's surface, at its place at rest; 0 or less outside; a lesser one where the true one is below `least`. p in metres,
 * where the bone is. */
static double depth_in(probe_bone *bone, sn_vec3 p, double least) {
    double depth;
    if (bone->joint != SN_NONE) p = sn_rigid_apply(bone->to_rest, p);
    p = sn_scale(p, 1.0 / bone->meters_per_unit);
    if (!in_box(bone->box, p)) return 0.0;
    if (is_told(bone, p, least, &depth)) return depth;
    bone->looked_at = p;
    bone->distance = sn_surface_signed_distance(bone->surface, p, NULL);
    return -bone->distance * bone->meters_per_unit;
}

sn_penetration sn_bone_probe_points(sn_bone_probe *probe, const sn_rigid *poses, sn_index count, const sn_vec3 *points,
                                    double meters_per_unit) {
    sn_penetration found = {.bone = SN_NONE};
    for (sn_index b = 0; b < probe->bone_count; b++) {
        probe_bone *bone = &probe->bones[b];
        bone->distance = 0.0;
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
