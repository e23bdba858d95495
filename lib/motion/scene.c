/* scene.c -- the scene as data: its defaults, whether it can run, and its end. */
#include "sinew/scene.h"
#include "sinew/voxels.h"

#include <stdlib.h>
#include <string.h>

const char *const sn_fiber_law_names[] = {"projected", "paper", "isochoric", NULL};
const char *const sn_anisotropy_names[] = {"scheme", "none", "pbd", "xpbd", NULL};
const char *const sn_stretch_names[] = {"springs", "membrane", NULL};
const char *const sn_solver_method_names[] = {"xpbd", "qn", NULL};
const char *const sn_scheme_names[] = {"guarded", "romeo", "kohout", NULL};
const char *const sn_hinge_rule_names[] = {"scheme", "published", "printed", NULL};
const char *const sn_collision_names[] = {"scheme", "field", "voxel", NULL};
const char *const sn_bone_hits_names[] = {"follow", "stop", "ignore", NULL};
const char *const sn_preconditioning_names[] = {"scalar", "corotated", "two-level", NULL};
const char *const sn_precision_names[] = {"double", "single", NULL};

/* ---- defaults --------------------------------------------------------------------------------------------------------- */

double sn_muscle_activation(const sn_scene_muscle *muscle, double time) {
    return fmax(sn_channel_at(&muscle->activation, time), muscle->tone);
}

double sn_muscle_contraction(const sn_scene_muscle *muscle, double activation) {
    double a = muscle->contraction * activation;
    return muscle->rest_length == 1.0 ? a : 1.0 - muscle->rest_length * (1.0 - a); /* 1 - (1 - a) is not a to the last bit */
}

void sn_scene_muscle_defaults(sn_scene_muscle *muscle) {
    muscle->contraction = 0.5;
    muscle->rest_activation = 0.0;
    muscle->rest_length = 1.0;
    muscle->law = SN_LAW_PROJECTED;
    muscle->stiffness_relaxed = 5e5;
    muscle->stiffness_active = 5e7;
    muscle->stiffness_internal = 1.0;
    muscle->stiffness_dihedral = 7.5e-5;
    muscle->stiffness_volume = 4000.0;
    muscle->stiffness_scaled = true;
    muscle->least_area = 0.5;
    muscle->density = 1060.0;
    muscle->damping = 5.0;
    muscle->iterations = 0;
    muscle->enabled = true;
}

sn_solver_settings sn_solver_defaults(sn_solver_method method) {
    bool newton = method == SN_SOLVER_QN;
    return (sn_solver_settings){
        .method = method, .substeps = newton ? SN_SUBSTEPS_AUTO : 16, .iterations = newton ? 10 : 2, .tolerance = 1e-5, .sleep = true};
}

sn_index sn_solver_substeps(const sn_solver_settings *settings) { return settings->substeps == SN_SUBSTEPS_AUTO ? 1 : settings->substeps; }

void sn_solver_change(sn_solver_settings *settings, sn_solver_method method) {
    const sn_solver_settings before = *settings;
    if (method == before.method) return;
    *settings = sn_solver_defaults(method);
    settings->threads = before.threads;
    settings->sleep = before.sleep;
}

void sn_scene_defaults(sn_scene *scene) {
    *scene = (sn_scene){0};
    scene->meters_per_unit = 1.0;
    scene->rate = 24.0;
    scene->solver = sn_solver_defaults(SN_SOLVER_QN);
    scene->externals.stiffness = SN_EXTERNAL_STIFFNESS;
}

/* ---- the end ---------------------------------------------------------------------------------------------------------- */

static void free_bone(sn_scene_bone *bone) {
    free(bone->name);
    free(bone->uri);
    sn_mesh_free(&bone->mesh);
}

static sn_index find_bone(const sn_scene *scene, const char *name) {
    for (sn_index i = 0; i < scene->bone_count; i++)
        if (scene->bones[i].name != NULL && strcmp(scene->bones[i].name, name) == 0) return i;
    return SN_NONE;
}

static sn_index find_surface(const sn_scene *scene, const char *name) {
    for (sn_index i = 0; i < scene->surface_count; i++)
        if (scene->surfaces[i].name != NULL && strcmp(scene->surfaces[i].name, name) == 0) return i;
    return SN_NONE;
}

static sn_index find_joint(const sn_scene *scene, const char *name) {
    for (sn_index i = 0; i < scene->motion.joint_count; i++)
        if (scene->motion.joints[i].name != NULL && strcmp(scene->motion.joints[i].name, name) == 0) return i;
    return SN_NONE;
}

sn_carrier sn_scene_carrier(const sn_scene *scene, const char *name) {
    sn_index bone = name != NULL ? find_bone(scene, name) : SN_NONE;
    if (bone != SN_NONE) return (sn_carrier){SN_CARRIER_BONE, bone};
    sn_index surface = name != NULL ? find_surface(scene, name) : SN_NONE;
    if (surface != SN_NONE) return (sn_carrier){SN_CARRIER_SURFACE, surface};
    sn_index joint = name != NULL ? find_joint(scene, name) : SN_NONE;
    return joint != SN_NONE ? (sn_carrier){SN_CARRIER_JOINT, joint} : (sn_carrier){SN_CARRIER_NONE, SN_NONE};
}

static bool hangs_on(const sn_scene *scene, const sn_muscle *rig, sn_index surface) {
    for (sn_index i = 0; i < rig->attachment_count; i++) {
        sn_carrier carrier = sn_scene_carrier(scene, rig->attachments[i].bone);
        if (carrier.kind == SN_CARRIER_SURFACE && carrier.index == surface && rig->attachments[i].count > 0) return true;
    }
    return false;
}

/* Do external constraints tie it to the surface? */
static bool is_tied_to(const sn_scene *scene, const sn_muscle *rig, sn_index surface) {
    for (sn_index i = 0; i < rig->external_count; i++) {
        sn_carrier carrier = sn_scene_carrier(scene, rig->externals[i].target);
        if (carrier.kind == SN_CARRIER_SURFACE && carrier.index == surface && rig->externals[i].count > 0) return true;
    }
    return false;
}

bool sn_scene_surface_carries(const sn_scene *scene, sn_index surface) {
    for (sn_index i = 0; i < scene->muscle_count; i++) {
        const sn_scene_muscle *muscle = &scene->muscles[i];
        bool bound = scene->externals.enabled && !muscle->unbound;
        if (!muscle->enabled) continue;
        if (hangs_on(scene, &muscle->rig, surface) || (bound && is_tied_to(scene, &muscle->rig, surface))) return true;
    }
    return false;
}

const char *sn_scene_touched_name(const sn_scene *scene, sn_index touched) {
    return touched < scene->bone_count ? scene->bones[touched].name : scene->surfaces[touched - scene->bone_count].name;
}

void sn_scene_warn_of_times(const sn_scene *scene) {
    double first = scene->first_frame / scene->rate, last = scene->last_frame / scene->rate, slack = 1e-6;
    for (sn_index i = 0; i < scene->surface_count; i++) {
        const sn_scene_surface *surface = &scene->surfaces[i];
        const sn_vertex_track *track = &surface->track;
        if (!surface->loaded || surface->kind != SN_SURFACE_DRIVEN) continue;
        if (first < track->times[0] - slack || last > track->times[track->sample_count - 1] + slack)
            sn_log(SN_LOG_WARNING,
                   "surface \"%s\": its frames are from %g s to %g s, the scene's from %g s to %g s; outside of its own it stands still",
                   surface->name, track->times[0], track->times[track->sample_count - 1], first, last);
    }
}

static void free_knots(sn_knots *knots) {
    free(knots->x);
    free(knots->y);
}

static void free_muscle(sn_scene_muscle *muscle) {
    free(muscle->name);
    free(muscle->uri);
    sn_muscle_free(&muscle->rig);
    sn_channel_free(&muscle->activation);
    free_knots(&muscle->stiffness_curve);
    free_knots(&muscle->volume_ratio);
    free(muscle->activation_map);
    free(muscle->tendon_map);
    free(muscle->stiffness_map);
    sn_vertex_track_free(&muscle->frozen);
}

void sn_scene_free(sn_scene *scene) {
    if (scene == NULL) return;
    for (sn_index i = 0; i < scene->bone_count; i++) free_bone(&scene->bones[i]);
    for (sn_index i = 0; i < scene->surface_count; i++) sn_scene_surface_free(&scene->surfaces[i]);
    for (sn_index i = 0; i < scene->muscle_count; i++) free_muscle(&scene->muscles[i]);
    free(scene->bones);
    free(scene->surfaces);
    free(scene->muscles);
    sn_motion_free(&scene->motion);
    free(scene->name);
    *scene = (sn_scene){0};
}

/* ---- validation ------------------------------------------------------------------------------------------------------- */

static bool within(double value, double low, double high) { return isfinite(value) && value >= low && value <= high; }

static const char *name_of(const char *name) { return name != NULL ? name : "(unnamed)"; }

static sn_status check_bone(const sn_scene *scene, sn_index i, sn_error *error) {
    const sn_scene_bone *bone = &scene->bones[i];
    if (bone->name == NULL || *bone->name == '\0') return sn_fail(error, SN_ERROR_INPUT, "bone %ld has no name", (long)i);
    if (!(bone->meters_per_unit > 0.0) || !isfinite(bone->meters_per_unit))
        return sn_fail(error, SN_ERROR_INPUT, "bone \"%s\": its unit is not a length above 0", bone->name);
    if (bone->joint != SN_NONE && (bone->joint < 0 || bone->joint >= scene->motion.joint_count))
        return sn_fail(error, SN_ERROR_INPUT, "bone \"%s\": it hangs on joint %ld, but there are %ld joints", bone->name, (long)bone->joint,
                       (long)scene->motion.joint_count);
    for (sn_index k = 0; k < i; k++)
        if (strcmp(scene->bones[k].name, bone->name) == 0)
            return sn_fail(error, SN_ERROR_INPUT, "two bones have the name \"%s\"; attachments could not tell them apart", bone->name);
    return SN_OK;
}

static sn_status check_joints(const sn_scene *scene, const sn_scene_surface *surface, sn_error *error) {
    for (sn_index b = 0; b < surface->envelope.bone_count; b++)
        if (surface->joints[b] != SN_NONE && (surface->joints[b] < 0 || surface->joints[b] >= scene->motion.joint_count))
            return sn_fail(error, SN_ERROR_INPUT, "surface \"%s\": bone \"%s\" hangs on joint %ld, but there are %ld joints", surface->name,
                           surface->envelope.bones[b], (long)surface->joints[b], (long)scene->motion.joint_count);
    return SN_OK;
}

static sn_status check_track(const sn_scene_surface *surface, sn_error *error) {
    const sn_vertex_track *track = &surface->track;
    if (track->sample_count < 1) return sn_fail(error, SN_ERROR_INPUT, "surface \"%s\": it has no frames", surface->name);
    if (track->vertex_count != surface->envelope.mesh.vertex_count)
        return sn_fail(error, SN_ERROR_INPUT, "surface \"%s\": its frames have %ld vertices, its mesh has %ld", surface->name,
                       (long)track->vertex_count, (long)surface->envelope.mesh.vertex_count);
    for (sn_index i = 0; i < track->sample_count; i++)
        if (!isfinite(track->times[i]) || (i > 0 && !(track->times[i] > track->times[i - 1])))
            return sn_fail(error, SN_ERROR_INPUT, "surface \"%s\": the time of its frame %ld is not later than that of the one before",
                           surface->name, (long)i);
    return SN_OK;
}

static sn_status check_surface(const sn_scene *scene, sn_index i, sn_error *error) {
    const sn_scene_surface *surface = &scene->surfaces[i];
    if (surface->name == NULL || *surface->name == '\0') return sn_fail(error, SN_ERROR_INPUT, "surface %ld has no name", (long)i);
    if (find_bone(scene, surface->name) != SN_NONE)
        return sn_fail(error, SN_ERROR_INPUT, "a bone and a surface have the name \"%s\"; attachments could not tell them apart",
                       surface->name);
    if (find_surface(scene, surface->name) != i)
        return sn_fail(error, SN_ERROR_INPUT, "two surfaces have the name \"%s\"; attachments could not tell them apart", surface->name);
    if (!surface->loaded) return SN_OK;
    if (surface->kind == SN_SURFACE_DRIVEN) return check_track(surface, error);
    sn_status status = sn_envelope_validate(&surface->envelope, error);
    return status == SN_OK ? check_joints(scene, surface, error) : status;
}

static sn_status check_activation(const sn_scene_muscle *muscle, sn_error *error) {
    const sn_channel *activation = &muscle->activation;
    const char *name = name_of(muscle->name);
    if (!within(activation->constant, 0.0, 1.0))
        return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": activation is %g; it must be in [0,1]", name, activation->constant);
    for (sn_index i = 0; i < activation->count; i++) {
        if (!within(activation->values[i], 0.0, 1.0))
            return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": activation is %g at %g s; it must be in [0,1]", name,
                           activation->values[i], activation->times[i]);
        if (!isfinite(activation->times[i]) || (i > 0 && activation->times[i] <= activation->times[i - 1]))
            return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": key %ld of its activation is not later than the one before", name,
                           (long)i);
    }
    return SN_OK;
}

/* Activations ascending in [0,1], values above 0. */
static sn_status check_curve(const sn_scene_muscle *muscle, const char *what, const sn_knots *knots, sn_error *error) {
    for (sn_index i = 0; i < knots->count; i++) {
        if (!within(knots->x[i], 0.0, 1.0) || (i > 0 && knots->x[i] <= knots->x[i - 1]))
            return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": the activations of its %s must ascend within [0,1]",
                           name_of(muscle->name), what);
        if (!isfinite(knots->y[i]) || knots->y[i] <= 0.0)
            return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": %s is %g; it must be above 0", name_of(muscle->name), what, knots->y[i]);
    }
    return SN_OK;
}

/* The painted map that a muscle names: one number per vertex, finite, in [low, high]. */
static sn_status check_map(const sn_scene_muscle *muscle, const char *attribute, double low, double high, sn_error *error) {
    if (attribute == NULL) return SN_OK;
    const sn_mesh *mesh = &muscle->rig.mesh;
    const sn_attribute *map = sn_mesh_attribute(mesh, attribute);
    if (map == NULL || map->components != 1)
        return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": its mesh has no attribute \"%s\" of one number per vertex",
                       name_of(muscle->name), attribute);
    for (sn_index v = 0; v < mesh->vertex_count; v++)
        if (!within(map->values[v], low, high))
            return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": attribute \"%s\" is %g at vertex %ld; it must be in [%g,%g]",
                           name_of(muscle->name), attribute, map->values[v], (long)v, low, high);
    return SN_OK;
}

/* The numbers of a muscle, and where each may be. */
static sn_status check_settings(const sn_scene_muscle *muscle, sn_error *error) {
    const struct {
        const char *name;
        double value, low, high;
    } ranges[] = {
        {"contraction", muscle->contraction, 0.0, 0.99},
        {"restActivation", muscle->rest_activation, 0.0, 1.0},
        {"tone", muscle->tone, 0.0, 1.0},
        {"restLength", muscle->rest_length, 0.1, 1.0},
        {"stiffness.relaxed", muscle->stiffness_relaxed, 0.0, HUGE_VAL},
        {"stiffness.active", muscle->stiffness_active, 0.0, HUGE_VAL},
        {"stiffness.internal", muscle->stiffness_internal, 0.0, HUGE_VAL},
        {"stiffness.dihedral", muscle->stiffness_dihedral, 0.0, HUGE_VAL},
        {"stiffness.volume", muscle->stiffness_volume, 0.0, HUGE_VAL},
        {"leastArea", muscle->least_area, 0.0, 0.99},
        {"damping", muscle->damping, 0.0, HUGE_VAL},
        {"iterations", muscle->iterations, 0.0, SN_INDEX_MAX},
    };
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++)
        if (!within(ranges[i].value, ranges[i].low, ranges[i].high))
            return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": %s is %g; it must be in [%g,%g]", name_of(muscle->name), ranges[i].name,
                           ranges[i].value, ranges[i].low, ranges[i].high);
    if (!isfinite(muscle->density) || muscle->density <= 0.0)
        return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": density is %g; it must be above 0", name_of(muscle->name), muscle->density);
    return SN_OK;
}

static sn_status check_attachment(const sn_scene *scene, const sn_scene_muscle *muscle, const sn_attachment *attachment, sn_error *error) {
    sn_carrier carrier = sn_scene_carrier(scene, attachment->bone);
    if (carrier.kind == SN_CARRIER_NONE)
        return sn_fail(
            error, SN_ERROR_INPUT,
            "muscle \"%s\" is attached to the bone \"%s\", which the scene does not have, neither among its bones nor as a surface "
            "or a joint; add it to \"bones\" (attach-detect names bones with --bone NAME=FILE)",
            name_of(muscle->name), attachment->bone);
    if (carrier.kind == SN_CARRIER_SURFACE && attachment->count > 0 && !scene->surfaces[carrier.index].loaded)
        return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\" is attached to the surface \"%s\", which has not been loaded",
                       name_of(muscle->name), attachment->bone);
    return SN_OK;
}

static sn_status check_rig(const sn_scene *scene, const sn_scene_muscle *muscle, sn_error *error) {
    sn_status status = sn_muscle_validate(&muscle->rig, error);
    if (status == SN_OK) status = check_map(muscle, muscle->activation_map, 0.0, 1.0, error);
    if (status == SN_OK) status = check_map(muscle, muscle->tendon_map, 0.0, 1.0, error);
    if (status == SN_OK) status = check_map(muscle, muscle->stiffness_map, 1e-6, 1e6, error);
    for (sn_index i = 0; i < muscle->rig.attachment_count && status == SN_OK; i++)
        status = check_attachment(scene, muscle, &muscle->rig.attachments[i], error);
    return status;
}

static sn_status check_anisotropy(const sn_scene *scene, const sn_scene_muscle *muscle, sn_error *error) {
    if (muscle->anisotropy != SN_ANISOTROPY_PBD || scene->solver.method == SN_SOLVER_XPBD) return SN_OK;
    return sn_fail(
        error, SN_ERROR_INPUT,
        "muscle \"%s\": the form pbd of anisotropy is a factor on corrections, which only the solver method xpbd makes; choose that, "
        "or the form xpbd",
        name_of(muscle->name));
}

static sn_status check_stretch(const sn_scene *scene, const sn_scene_muscle *muscle, sn_error *error) {
    if (muscle->stretch != SN_STRETCH_MEMBRANE) return SN_OK;
    if (scene->solver.method != SN_SOLVER_QN)
        return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": a membrane needs the solver method qn; choose that, or the stretch springs",
                       name_of(muscle->name));
    if (muscle->law == SN_LAW_PAPER)
        return sn_fail(error, SN_ERROR_INPUT,
                       "muscle \"%s\": the law paper is one of edges, and a membrane has none; choose projected or isochoric",
                       name_of(muscle->name));
    return SN_OK;
}

static sn_status check_muscle(const sn_scene *scene, sn_index i, sn_error *error) {
    const sn_scene_muscle *muscle = &scene->muscles[i];
    for (sn_index k = 0; k < i && muscle->name != NULL; k++)
        if (scene->muscles[k].name != NULL && strcmp(scene->muscles[k].name, muscle->name) == 0)
            return sn_fail(error, SN_ERROR_INPUT, "two muscles have the name \"%s\"; give one another \"name\"", muscle->name);
    if (muscle->law < SN_LAW_PROJECTED || muscle->law > SN_LAW_ISOCHORIC)
        return sn_fail(error, SN_ERROR_INPUT, "muscle \"%s\": its fibre law is not known", name_of(muscle->name));
    sn_status status = check_settings(muscle, error);
    if (status == SN_OK) status = check_anisotropy(scene, muscle, error);
    if (status == SN_OK) status = check_stretch(scene, muscle, error);
    if (status == SN_OK) status = check_activation(muscle, error);
    if (status == SN_OK) status = check_curve(muscle, "volume ratio", &muscle->volume_ratio, error);
    if (status == SN_OK) status = check_curve(muscle, "stiffness", &muscle->stiffness_curve, error);
    return status == SN_OK && muscle->enabled ? check_rig(scene, muscle, error) : status;
}

sn_collision sn_scene_collision(const sn_scene *scene) {
    if (scene->contact.collision != SN_COLLISION_SCHEME) return scene->contact.collision;
    return scene->solver.scheme == SN_SCHEME_KOHOUT ? SN_COLLISION_VOXEL : SN_COLLISION_FIELD;
}

static sn_status check_voxels(const sn_scene *scene, sn_error *error) {
    const sn_contact_settings *contact = &scene->contact;
    if (contact->voxels < 0 || contact->voxels > SN_MOST_VOXELS_ALONG)
        return sn_fail(error, SN_ERROR_INPUT, "contact: voxels is %ld; there may be 1 to %d along an axis", (long)contact->voxels,
                       SN_MOST_VOXELS_ALONG);
    if (contact->voxels_total < 0 || contact->voxels_total > SN_MOST_VOXELS)
        return sn_fail(error, SN_ERROR_INPUT, "contact: voxelsTotal is %ld; there may be 1 to %d", (long)contact->voxels_total,
                       SN_MOST_VOXELS);
    if (contact->voxels > 0 && contact->voxels_total > 0)
        return sn_fail(error, SN_ERROR_INPUT, "contact: voxels and voxelsTotal exclude each other; leave one of them out");
    if (contact->enabled && contact->collision == SN_COLLISION_VOXEL && scene->solver.method != SN_SOLVER_XPBD)
        return sn_fail(error, SN_ERROR_INPUT,
                       "contact: the collision voxel is for the method xpbd; choose that method, or the collision field");
    return SN_OK;
}

static sn_status check_contact(const sn_scene *scene, sn_error *error) {
    const sn_contact_settings *contact = &scene->contact;
    if (!within(contact->margin, 0.0, HUGE_VAL) || !within(contact->cell, 0.0, HUGE_VAL) || !within(contact->friction, 0.0, HUGE_VAL) ||
        !within(contact->resolve, 0.0, HUGE_VAL))
        return sn_fail(error, SN_ERROR_INPUT, "contact: margin, cell, friction and resolve must be at least 0");
    if (contact->samples != 0 && contact->samples != 1 && contact->samples != 3)
        return sn_fail(error, SN_ERROR_INPUT, "contact: samples is %ld; it must be 0, 1 or 3", (long)contact->samples);
    return SN_OK;
}

static sn_status check_externals(const sn_scene *scene, sn_error *error) {
    if (!within(scene->externals.stiffness, 0.0, 1e12))
        return sn_fail(error, SN_ERROR_INPUT, "externals: stiffness is %g; it must be within 0 and 1e12", scene->externals.stiffness);
    if (!within(scene->externals.resolve, 0.0, 1e6))
        return sn_fail(error, SN_ERROR_INPUT, "externals: resolve is %g; it must be within 0 and 1e6", scene->externals.resolve);
    return SN_OK;
}

static sn_status check_solver(const sn_scene *scene, sn_error *error) {
    const sn_solver_settings *solver = &scene->solver;
    if (solver->substeps == SN_SUBSTEPS_AUTO && solver->method != SN_SOLVER_QN)
        return sn_fail(error, SN_ERROR_INPUT, "solver.substeps auto is for the method qn; give a number or choose that method");
    if (solver->substeps < 0)
        return sn_fail(error, SN_ERROR_INPUT, "solver.substeps is %ld; it must be at least 1", (long)solver->substeps);
    if (solver->iterations < 1)
        return sn_fail(error, SN_ERROR_INPUT, "solver.iterations is %ld; it must be at least 1", (long)solver->iterations);
    if (solver->method != SN_SOLVER_XPBD && solver->scheme != SN_SCHEME_GUARDED)
        return sn_fail(error, SN_ERROR_INPUT, "solver.scheme is a scheme of xpbd; leave it out or choose the method xpbd");
    if (solver->scheme != SN_SCHEME_KOHOUT && solver->hinges != SN_HINGES_SCHEME)
        return sn_fail(error, SN_ERROR_INPUT, "solver.hinges is a choice of the scheme kohout; leave it out or choose that scheme");
    if (solver->method != SN_SOLVER_QN && solver->preconditioner != SN_PRECONDITION_SCALAR)
        return sn_fail(error, SN_ERROR_INPUT, "solver.preconditioner is for the method qn; leave it out or choose that method");
    if (solver->method != SN_SOLVER_XPBD && solver->precision != SN_PRECISION_DOUBLE)
        return sn_fail(error, SN_ERROR_INPUT, "solver.precision single is for xpbd; leave it out or choose the method xpbd");
    if (!within(solver->tolerance, 0.0, 1.0))
        return sn_fail(error, SN_ERROR_INPUT, "solver.tolerance is %g; it must be within [0,1]", solver->tolerance);
    if (solver->threads < 0) return sn_fail(error, SN_ERROR_INPUT, "solver.threads is %d; it must be at least 0", solver->threads);
    return SN_OK;
}

static sn_status check_clock(const sn_scene *scene, sn_error *error) {
    if (!isfinite(scene->meters_per_unit) || scene->meters_per_unit <= 0.0)
        return sn_fail(error, SN_ERROR_INPUT, "metersPerUnit is %g; it must be above 0", scene->meters_per_unit);
    if (!isfinite(scene->rate) || scene->rate <= 0.0)
        return sn_fail(error, SN_ERROR_INPUT, "rate is %g frames per second; it must be above 0", scene->rate);
    if (scene->first_frame < -SN_FRAME_LIMIT || scene->last_frame > SN_FRAME_LIMIT)
        return sn_fail(error, SN_ERROR_INPUT, "frames %ld to %ld: they must be within %d and %d", (long)scene->first_frame,
                       (long)scene->last_frame, -SN_FRAME_LIMIT, SN_FRAME_LIMIT);
    if (scene->last_frame < scene->first_frame)
        return sn_fail(error, SN_ERROR_INPUT, "frames end at %ld, before they begin at %ld", (long)scene->last_frame,
                       (long)scene->first_frame);
    if (!within(scene->preroll, 0.0, HUGE_VAL))
        return sn_fail(error, SN_ERROR_INPUT, "preroll is %g s; it must be at least 0", scene->preroll);
    if (!within(scene->run_in, 0.0, scene->preroll))
        return sn_fail(error, SN_ERROR_INPUT, "runIn is %g s; it is a part of the preroll, which is %g s: make that as long at least",
                       scene->run_in, scene->preroll);
    if (!sn_finite3(scene->gravity)) return sn_fail(error, SN_ERROR_INPUT, "gravity is not finite");
    return SN_OK;
}

sn_status sn_scene_validate(const sn_scene *scene, sn_error *error) {
    sn_status status = check_clock(scene, error);
    if (status == SN_OK) status = check_contact(scene, error);
    if (status == SN_OK) status = check_externals(scene, error);
    if (status == SN_OK) status = check_solver(scene, error);
    if (status == SN_OK) status = check_voxels(scene, error);
    if (status == SN_OK) status = sn_motion_validate(&scene->motion, error);
    for (sn_index i = 0; i < scene->bone_count && status == SN_OK; i++) status = check_bone(scene, i, error);
    for (sn_index i = 0; i < scene->surface_count && status == SN_OK; i++) status = check_surface(scene, i, error);
    for (sn_index i = 0; i < scene->muscle_count && status == SN_OK; i++) status = check_muscle(scene, i, error);
    return status;
}
