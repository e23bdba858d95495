/* scene_document.c -- the scene document: bones, muscles, motion and solver settings, read and written. */
#include "scene_build.h"
#include "scene_contact.h"
#include "scene_externals.h"
#include "scene_surfaces.h"

#include <stdlib.h>
#include <string.h>

#define FORMAT "sinew-scene"
enum { NEWEST_VERSION = 1, COUNT_LIMIT = 1000000 };

/* What the parts of a scene need of the whole. */
typedef struct reader {
    sn_scene *scene;
    sn_clock clock;
    bool load_bones;
    sn_muscle *rigs; /* (muscles of the document) those that have been read; nullable: read them from their files */
} reader;

/* ---- reading: the whole ----------------------------------------------------------------------------------------------- */

static sn_status parse_frames(const sn_json_value *value, sn_scene *scene, sn_error *error) {
    double frames[2] = {scene->first_frame, scene->last_frame};
    sn_status status = sn_json_get_fixed(value, 2, frames, error);
    if (status != SN_OK) return status;
    for (int i = 0; i < 2; i++)
        if (frames[i] != floor(frames[i]) || fabs(frames[i]) > SN_FRAME_LIMIT)
            return sn_json_complain(value, error, "expected two whole frame numbers [first,last], found %g", frames[i]);
    if (frames[1] < frames[0]) return sn_json_complain(value, error, "the last frame comes before the first");
    scene->first_frame = (sn_index)frames[0];
    scene->last_frame = (sn_index)frames[1];
    return SN_OK;
}

/* A number, or "auto". */
static sn_status parse_substeps(const sn_json_value *value, sn_solver_settings *out, sn_error *error) {
    static const char *const automatic[] = {"auto", NULL};
    int choice = 0;
    if (!sn_json_is_text(value)) return sn_json_get_index(value, 1, COUNT_LIMIT, &out->substeps, error);
    out->substeps = SN_SUBSTEPS_AUTO;
    return sn_json_get_choice(value, automatic, &choice, error);
}

static sn_status parse_solver(const sn_json_value *value, sn_solver_settings *out, sn_error *error) {
    static const char *const known[] = {"method",    "scheme",         "hinges",  "precision", "substeps", "iterations",
                                        "tolerance", "preconditioner", "threads", "sleep",     NULL};
    if (!sn_json_has(value)) return SN_OK;
    sn_json_value scheme_name = sn_json_member(value, "scheme"), sleep = sn_json_member(value, "sleep");
    sn_json_value precision_name = sn_json_member(value, "precision"), hinge_name = sn_json_member(value, "hinges");
    sn_json_value method = sn_json_member(value, "method"), substeps = sn_json_member(value, "substeps"),
                  iterations = sn_json_member(value, "iterations"), tolerance = sn_json_member(value, "tolerance"),
                  threads = sn_json_member(value, "threads"), matrix = sn_json_member(value, "preconditioner");
    int choice = (int)out->method, scheme = (int)out->scheme, preconditioner = SN_PRECONDITION_SCALAR, precision = (int)out->precision;
    int hinges = (int)out->hinges;
    sn_index thread_count = out->threads;
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_get_choice(&method, sn_solver_method_names, &choice, error);
    if (status == SN_OK) status = sn_json_get_choice(&scheme_name, sn_scheme_names, &scheme, error);
    if (status == SN_OK) status = sn_json_get_choice(&hinge_name, sn_hinge_rule_names, &hinges, error);
    if (status == SN_OK) status = sn_json_get_choice(&precision_name, sn_precision_names, &precision, error);
    bool papers = scheme != SN_SCHEME_GUARDED || precision != SN_PRECISION_DOUBLE; /* which xpbd alone has */
    if (papers && !sn_json_has(&method)) choice = SN_SOLVER_XPBD;
    *out = sn_solver_defaults((sn_solver_method)choice);
    if (status == SN_OK) status = parse_substeps(&substeps, out, error);
    if (status == SN_OK) status = sn_json_get_index(&iterations, 1, COUNT_LIMIT, &out->iterations, error);
    if (status == SN_OK) status = sn_json_get_number(&tolerance, 0.0, 1.0, &out->tolerance, error);
    if (status == SN_OK) status = sn_json_get_choice(&matrix, sn_preconditioning_names, &preconditioner, error);
    if (status == SN_OK) status = sn_json_get_index(&threads, 0, 1024, &thread_count, error);
    if (status == SN_OK) status = sn_json_get_bool(&sleep, &out->sleep, error);
    if (status != SN_OK) return status;
    out->scheme = (sn_scheme)scheme;
    out->hinges = (sn_hinge_rule)hinges;
    out->precision = (sn_precision)precision;
    out->preconditioner = (sn_preconditioning)preconditioner;
    out->threads = thread_count;
    return sn_json_check_members(value, known, error);
}

static sn_status parse_globals(const sn_json_value *top, sn_scene *scene, sn_error *error) {
    sn_json_value name = sn_json_member(top, "name"), unit = sn_json_member(top, "metersPerUnit"), rate = sn_json_member(top, "rate"),
                  frames = sn_json_member(top, "frames"), preroll = sn_json_member(top, "preroll"), run_in = sn_json_member(top, "runIn"),
                  gravity = sn_json_member(top, "gravity"), solver = sn_json_member(top, "solver"),
                  contact = sn_json_member(top, "contact"), externals = sn_json_member(top, "externals");
    sn_status status = sn_json_get_text(&name, &scene->name, error);
    if (status == SN_OK) status = sn_json_get_number(&unit, SN_JSON_POSITIVE, INFINITY, &scene->meters_per_unit, error);
    if (status == SN_OK) status = sn_json_get_number(&rate, SN_JSON_POSITIVE, INFINITY, &scene->rate, error);
    if (status == SN_OK) status = parse_frames(&frames, scene, error);
    if (status == SN_OK) status = sn_json_get_number(&preroll, 0.0, INFINITY, &scene->preroll, error);
    if (status == SN_OK) status = sn_json_get_number(&run_in, 0.0, INFINITY, &scene->run_in, error);
    if (status == SN_OK) status = sn_json_get_vec3(&gravity, &scene->gravity, error);
    if (status == SN_OK) status = sn_contact_parse(&contact, &scene->contact, error);
    if (status == SN_OK) status = sn_scene_externals_parse(&externals, &scene->externals, error);
    return status == SN_OK ? parse_solver(&solver, &scene->solver, error) : status;
}

/* ---- reading: bones --------------------------------------------------------------------------------------------------- */

/* What the file says of its unit holds where the scene says nothing; what it says of its axis always does. */
static sn_status load_bone(const sn_json_value *mesh, bool has_units, sn_scene_bone *out, sn_error *error) {
    char *path = sn_path_beside(sn_json_name(mesh->tree), out->uri);
    if (path == NULL) return sn_fail_memory(error, "a path");
    sn_mesh_frame frame;
    sn_status status = sn_file_check(path, error);
    if (status == SN_OK) status = sn_mesh_read(path, &out->mesh, &frame, error);
    free(path);
    if (status != SN_OK) return status;
    sn_mesh_convert(&out->mesh, 1.0, frame.up == SN_UP_Y);
    out->space = frame.space;
    if (!has_units && frame.meters_per_unit > 0.0) out->meters_per_unit = frame.meters_per_unit;
    return SN_OK;
}

/* The bone of that name in the scene's motion document; NULL = none. */
static const sn_motion_bone *find_motion_bone(const sn_motion *motion, const char *name) {
    for (sn_index i = 0; i < motion->bone_count; i++)
        if (strcmp(motion->bones[i].name, name) == 0) return &motion->bones[i];
    return NULL;
}

/* In the place of one of the motion document's, where that has one of its name: on its joint, unless it names another. */
static sn_status parse_bone(const sn_json_value *value, const reader *in, sn_scene_bone *out, sn_error *error) {
    static const char *const known[] = {"name", "mesh", "units", "joint", "contact", NULL};
    sn_motion_bone bone;
    sn_status status = sn_bone_parse(value, known, &in->scene->motion, &bone, error);
    const sn_motion_bone *replaced = status == SN_OK ? find_motion_bone(&in->scene->motion, bone.name) : NULL;
    out->name = bone.name;
    out->uri = bone.path;
    out->joint = bone.joint == SN_NONE && replaced != NULL ? replaced->joint : bone.joint;
    out->meters_per_unit = bone.meters_per_unit > 0.0 ? bone.meters_per_unit : in->scene->meters_per_unit;
    out->unit_certain = bone.meters_per_unit > 0.0 || in->load_bones;
    if (status == SN_OK) status = sn_contact_left_out_parse(value, &out->passable, error);
    if (status != SN_OK || !in->load_bones) return status;
    sn_json_value mesh = sn_json_member(value, "mesh");
    return load_bone(&mesh, bone.meters_per_unit > 0.0, out, error);
}

static bool has_bone(const sn_scene *scene, const char *name) {
    for (sn_index i = 0; i < scene->bone_count; i++)
        if (strcmp(scene->bones[i].name, name) == 0) return true;
    return false;
}

/* A bone of the motion document, its mesh named from the scene. */
static sn_status take_bone(const sn_motion_bone *bone, const char *scene, bool load, sn_scene_bone *out, sn_error *error) {
    out->name = sn_strdup(bone->name);
    out->uri = sn_path_from(scene, bone->path);
    out->joint = bone->joint;
    out->meters_per_unit = bone->meters_per_unit > 0.0 ? bone->meters_per_unit : 1.0;
    out->unit_certain = bone->meters_per_unit > 0.0 || load;
    if (out->name == NULL || out->uri == NULL) return sn_fail_memory(error, "a bone");
    if (!load) return SN_OK;
    sn_mesh_frame frame;
    sn_status status = sn_motion_bone_load(bone, 1.0, &out->mesh, &frame, error);
    out->meters_per_unit = frame.meters_per_unit;
    out->space = frame.space;
    return status;
}

/* Those of the motion document that the scene does not replace, behind its own. */
static sn_status take_motion_bones(const reader *in, const char *name, sn_error *error) {
    const sn_motion *motion = &in->scene->motion;
    sn_index own = in->scene->bone_count;
    sn_status status = SN_OK;
    for (sn_index i = 0; i < motion->bone_count && status == SN_OK; i++) {
        bool twice = i > 0 && find_motion_bone(motion, motion->bones[i].name) != &motion->bones[i];
        if (!twice && has_bone(in->scene, motion->bones[i].name)) continue; /* of two alike, validation tells */
        sn_scene_bone *out = &in->scene->bones[in->scene->bone_count++];
        status = take_bone(&motion->bones[i], name, in->load_bones, out, error);
    }
    if (status == SN_OK && in->scene->bone_count > own)
        sn_log(SN_LOG_INFO, "%d bones of the motion document are the scene's", (int)(in->scene->bone_count - own));
    return status;
}

static sn_status parse_bones(const sn_json_value *value, const reader *in, sn_error *error) {
    sn_index count = 0;
    sn_status status = sn_json_has(value) ? sn_json_expect_list(value, SN_LIST_LIMIT, &count, error) : SN_OK;
    if (status != SN_OK) return status;
    if ((in->scene->bones = SN_NEW(sn_scene_bone, count + in->scene->motion.bone_count)) == NULL) return sn_fail_memory(error, "bones");
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value bone = sn_json_element(value, i);
        in->scene->bone_count = i + 1;
        status = parse_bone(&bone, in, &in->scene->bones[i], error);
    }
    return status == SN_OK ? take_motion_bones(in, sn_json_name(value->tree), error) : status;
}

/* ---- reading: muscles ------------------------------------------------------------------------------------------------- */

static sn_status alloc_knots(sn_index count, sn_knots *out, sn_error *error) {
    out->x = SN_NEW(double, count);
    out->y = SN_NEW(double, count);
    if (out->x == NULL || out->y == NULL) return sn_fail_memory(error, "a curve");
    out->count = count;
    return SN_OK;
}

/* [[activation, value], ...] with activations ascending in [0,1] and values above 0. */
static sn_status parse_curve(const sn_json_value *value, sn_knots *out, sn_error *error) {
    sn_index count = sn_json_length(value);
    sn_status status = count > 0 ? alloc_knots(count, out, error) : sn_json_complain(value, error, "there is no [activation, value]");
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value knot = sn_json_element(value, i);
        double pair[2] = {0};
        status = sn_json_get_fixed(&knot, 2, pair, error);
        out->x[i] = pair[0];
        out->y[i] = pair[1];
        if (status == SN_OK && (pair[0] < 0.0 || pair[0] > 1.0 || pair[1] <= 0.0))
            status = sn_json_complain(&knot, error, "expected [activation in [0,1], value above 0], found [%g,%g]", pair[0], pair[1]);
        if (status == SN_OK && i > 0 && pair[0] <= out->x[i - 1]) status = sn_json_complain(&knot, error, "the activations do not ascend");
    }
    return status;
}

/* A number is the ratio at full activation, reached in a straight line from 1 at rest. */
static sn_status parse_full_ratio(const sn_json_value *value, sn_knots *out, sn_error *error) {
    double ratio = 1.0;
    sn_status status = sn_json_get_number(value, SN_JSON_POSITIVE, INFINITY, &ratio, error);
    if (status != SN_OK || ratio == 1.0) return status; /* 1 is what no knots mean */
    if ((status = alloc_knots(2, out, error)) != SN_OK) return status;
    out->x[1] = 1.0;
    out->y[0] = 1.0;
    out->y[1] = ratio;
    return SN_OK;
}

static sn_status parse_volume_ratio(const sn_json_value *value, sn_knots *out, sn_error *error) {
    if (!sn_json_has(value)) return SN_OK;
    if (sn_json_is_number(value)) return parse_full_ratio(value, out, error);
    if (!sn_json_is_array(value)) return sn_json_mismatch(value, error, "a number above 0, or [[activation, ratio], ...]");
    return parse_curve(value, out, error);
}

static sn_status parse_stiffness_curve(const sn_json_value *value, sn_knots *out, sn_error *error) {
    if (!sn_json_has(value)) return SN_OK;
    if (!sn_json_is_array(value)) return sn_json_mismatch(value, error, "[[activation, stiffness], ...]");
    return parse_curve(value, out, error);
}

static sn_status parse_stiffness(const sn_json_value *value, sn_scene_muscle *out, sn_error *error) {
    static const char *const known[] = {"relaxed", "active", "internal", "dihedral", "volume", "areaScaled", "curve", NULL};
    if (!sn_json_has(value)) return SN_OK;
    sn_json_value relaxed = sn_json_member(value, "relaxed"), active = sn_json_member(value, "active"),
                  internal = sn_json_member(value, "internal"), dihedral = sn_json_member(value, "dihedral"),
                  volume = sn_json_member(value, "volume"), scaled = sn_json_member(value, "areaScaled"),
                  curve = sn_json_member(value, "curve");
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_get_bool(&scaled, &out->stiffness_scaled, error);
    if (status == SN_OK) status = parse_stiffness_curve(&curve, &out->stiffness_curve, error);
    if (status == SN_OK) status = sn_json_get_number(&relaxed, 0.0, INFINITY, &out->stiffness_relaxed, error);
    if (status == SN_OK) status = sn_json_get_number(&active, 0.0, INFINITY, &out->stiffness_active, error);
    if (status == SN_OK) status = sn_json_get_number(&internal, 0.0, INFINITY, &out->stiffness_internal, error);
    if (status == SN_OK) status = sn_json_get_number(&dihedral, 0.0, INFINITY, &out->stiffness_dihedral, error);
    if (status == SN_OK) status = sn_json_get_number(&volume, 0.0, INFINITY, &out->stiffness_volume, error);
    if (status == SN_OK) status = sn_json_check_members(value, known, error);
    return status;
}

/* "maps": { "activation": ATTRIBUTE, "tendon": ATTRIBUTE, "stiffness": ATTRIBUTE } */
static sn_status parse_maps(const sn_json_value *value, sn_scene_muscle *out, sn_error *error) {
    static const char *const known[] = {"activation", "tendon", "stiffness", NULL};
    if (!sn_json_has(value)) return SN_OK;
    sn_json_value activation = sn_json_member(value, "activation"), stiffness = sn_json_member(value, "stiffness"),
                  tendon = sn_json_member(value, "tendon");
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_get_text(&activation, &out->activation_map, error);
    if (status == SN_OK) status = sn_json_get_text(&tendon, &out->tendon_map, error);
    if (status == SN_OK) status = sn_json_get_text(&stiffness, &out->stiffness_map, error);
    if (status == SN_OK) status = sn_json_check_members(value, known, error);
    return status;
}

static sn_status parse_muscle_choices(const sn_json_value *value, sn_scene_muscle *out, sn_error *error) {
    static const char *const masses[] = {"density", "unit", NULL};
    sn_json_value law = sn_json_member(value, "law"), anisotropy = sn_json_member(value, "anisotropy"),
                  stretch = sn_json_member(value, "stretch"), mass = sn_json_member(value, "mass"), maps = sn_json_member(value, "maps");
    int stretching = (int)out->stretch, fiber_law = (int)out->law, yielding = (int)out->anisotropy, unit = out->unit_mass;
    sn_status status = sn_json_get_choice(&law, sn_fiber_law_names, &fiber_law, error);
    if (status == SN_OK) status = sn_json_get_choice(&anisotropy, sn_anisotropy_names, &yielding, error);
    if (status == SN_OK) status = sn_json_get_choice(&stretch, sn_stretch_names, &stretching, error);
    if (status == SN_OK) status = sn_json_get_choice(&mass, masses, &unit, error);
    out->law = (sn_fiber_law)fiber_law;
    out->stretch = (sn_stretch)stretching;
    out->anisotropy = (sn_anisotropy)yielding;
    out->unit_mass = unit == 1;
    return status == SN_OK ? parse_maps(&maps, out, error) : status;
}

static sn_status parse_muscle_numbers(const sn_json_value *value, sn_scene_muscle *out, sn_error *error) {
    sn_json_value contraction = sn_json_member(value, "contraction"), rest = sn_json_member(value, "restActivation"),
                  tone = sn_json_member(value, "tone"), rest_length = sn_json_member(value, "restLength"),
                  least_area = sn_json_member(value, "leastArea"), density = sn_json_member(value, "density"),
                  damping = sn_json_member(value, "damping"), iterations = sn_json_member(value, "iterations"),
                  stiffness = sn_json_member(value, "stiffness"), ratio = sn_json_member(value, "volumeRatio");
    sn_status status = sn_json_get_number(&contraction, 0.0, 0.99, &out->contraction, error);
    if (status == SN_OK) status = sn_json_get_number(&rest, 0.0, 1.0, &out->rest_activation, error);
    if (status == SN_OK) status = sn_json_get_number(&tone, 0.0, 1.0, &out->tone, error);
    if (status == SN_OK) status = sn_json_get_number(&rest_length, 0.1, 1.0, &out->rest_length, error);
    if (status == SN_OK) status = sn_json_get_number(&least_area, 0.0, 0.99, &out->least_area, error);
    if (status == SN_OK) status = sn_json_get_number(&density, SN_JSON_POSITIVE, INFINITY, &out->density, error);
    if (status == SN_OK) status = sn_json_get_number(&damping, 0.0, INFINITY, &out->damping, error);
    if (status == SN_OK) status = sn_json_get_index(&iterations, 0, COUNT_LIMIT, &out->iterations, error);
    if (status == SN_OK) status = parse_stiffness(&stiffness, out, error);
    return status == SN_OK ? parse_volume_ratio(&ratio, &out->volume_ratio, error) : status;
}

static sn_status load_rig(const sn_json_value *rig, sn_scene_muscle *out, const reader *in, sn_error *error) {
    const sn_read_options options = {.meters_per_unit = in->scene->meters_per_unit};
    sn_blob blob = {0};
    sn_document *document = NULL;
    char *path = sn_path_beside(sn_json_name(rig->tree), out->uri);
    sn_status status = path != NULL ? sn_blob_read_named(path, &blob, error) : sn_fail_memory(error, "a path");
    if (status == SN_OK) status = sn_muscle_parse(&blob, &options, &out->rig, &document, error);
    sn_document_free(document);
    sn_blob_free(&blob);
    free(path);
    return status;
}

static sn_status take_rig(const sn_json_value *rig, sn_scene_muscle *out, const reader *in, sn_error *error) {
    if (in->rigs == NULL) return load_rig(rig, out, in, error);
    sn_muscle *read = &in->rigs[rig->parent->element];
    out->rig = *read;
    *read = (sn_muscle){0};
    return SN_OK;
}

/* A muscle without a name of its own has that of its rig, or of the rig's file. */
static sn_status name_muscle(sn_scene_muscle *out, sn_error *error) {
    if (out->name == NULL) out->name = sn_muscle_call(&out->rig, out->uri);
    return out->name != NULL ? SN_OK : sn_fail_memory(error, "a name");
}

static sn_status parse_muscle(const sn_json_value *value, const reader *in, sn_scene_muscle *out, sn_error *error) {
    static const char *const known[] = {"name",    "rig",        "enabled",   "activation", "contraction", "restActivation",
                                        "tone",    "restLength", "law",       "stiffness",  "volumeRatio", "density",
                                        "damping", "iterations", "leastArea", "anisotropy", "mass",        "maps",
                                        "stretch", "contact",    "externals", NULL};
    sn_json_value name = sn_json_member(value, "name"), rig = sn_json_member(value, "rig"), enabled = sn_json_member(value, "enabled"),
                  activation = sn_json_member(value, "activation");
    sn_scene_muscle_defaults(out);
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_get_text(&name, &out->name, error);
    if (status == SN_OK) status = sn_json_require(&rig, "the file of the muscle document", error);
    if (status == SN_OK) status = sn_json_get_text(&rig, &out->uri, error);
    if (status == SN_OK) status = sn_json_get_bool(&enabled, &out->enabled, error);
    if (status == SN_OK) status = sn_contact_left_out_parse(value, &out->untouched, error);
    if (status == SN_OK) status = sn_scene_externals_left_out(value, &out->unbound, error);
    if (status == SN_OK) status = parse_muscle_numbers(value, out, error);
    if (status == SN_OK) status = parse_muscle_choices(value, out, error);
    if (status == SN_OK && out->enabled) status = take_rig(&rig, out, in, error);
    if (status == SN_OK) status = name_muscle(out, error);
    if (status == SN_OK) status = sn_activation_parse(&activation, in->clock, out->name, &out->activation, error);
    if (status == SN_OK) status = sn_json_check_members(value, known, error);
    return status;
}

static sn_status parse_muscles(const sn_json_value *value, const reader *in, sn_error *error) {
    if (!sn_json_has(value)) return SN_OK;
    sn_index count;
    sn_status status = sn_json_expect_list(value, SN_LIST_LIMIT, &count, error);
    if (status != SN_OK) return status;
    if ((in->scene->muscles = SN_NEW(sn_scene_muscle, count)) == NULL) return sn_fail_memory(error, "muscles");
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value muscle = sn_json_element(value, i);
        in->scene->muscle_count = i + 1;
        status = parse_muscle(&muscle, in, &in->scene->muscles[i], error);
    }
    return status;
}

/* ---- reading: the document ----------------------------------------------------------------------------------------------- */

/* in: without its clock. */
static sn_status parse_scene(const sn_json_value *top, reader in, sn_error *error) {
    static const char *const known[] = {"format",  "version",  "name",    "metersPerUnit", "rate",    "frames",
                                        "preroll", "runIn",    "gravity", "solver",        "motion",  "bones",
                                        "muscles", "surfaces", "contact", "externals",     "history", NULL};
    sn_json_value motion = sn_json_member(top, "motion"), bones = sn_json_member(top, "bones"), muscles = sn_json_member(top, "muscles"),
                  surfaces = sn_json_member(top, "surfaces");
    sn_scene *scene = in.scene;
    sn_status status = sn_json_expect_format(top, FORMAT, NEWEST_VERSION, error);
    if (status == SN_OK) status = parse_globals(top, scene, error);
    in.load_bones = in.load_bones || scene->contact.enabled || scene->externals.enabled; /* which may tie muscles to them */
    in.clock = (sn_clock){scene->rate, scene->meters_per_unit, scene->first_frame, scene->last_frame, scene->rate};
    if (status == SN_OK) status = sn_motion_parse(&motion, in.clock, &scene->motion, error);
    if (status == SN_OK) status = parse_bones(&bones, &in, error);
    if (status == SN_OK) status = sn_scene_surfaces_parse(&surfaces, scene, error);
    if (status == SN_OK) status = parse_muscles(&muscles, &in, error);
    if (status == SN_OK) status = sn_scene_surfaces_load(sn_json_name(top->tree), in.load_bones, scene, error);
    if (status == SN_OK) status = sn_json_check_members(top, known, error);
    if (status != SN_OK) return status;
    return sn_scene_validate(scene, error);
}

/* As far as they have been loaded. */
static sn_status check_spaces(const sn_scene *scene, sn_error *error) {
    sn_space_seen seen = sn_space_begin();
    sn_status status = SN_OK;
    for (sn_index i = 0; i < scene->muscle_count && status == SN_OK; i++)
        status = sn_space_take(&seen, scene->muscles[i].rig.space, scene->muscles[i].name, error);
    for (sn_index i = 0; i < scene->bone_count && status == SN_OK; i++)
        status = sn_space_take(&seen, scene->bones[i].space, scene->bones[i].name, error);
    for (sn_index i = 0; i < scene->surface_count && status == SN_OK; i++)
        status = sn_space_take(&seen, scene->surfaces[i].space, scene->surfaces[i].name, error);
    return status;
}

static sn_status parse(const sn_blob *blob, reader in, sn_error *error) {
    sn_json_tree *tree = NULL;
    sn_scene_defaults(in.scene);
    sn_status status = sn_json_parse(blob, &tree, error);
    if (status == SN_OK) {
        sn_json_value top = sn_json_top(tree);
        status = parse_scene(&top, in, error);
        if (status == SN_OK) status = check_spaces(in.scene, error);
    }
    sn_json_tree_free(tree);
    if (status == SN_OK) return SN_OK;
    sn_error_set_file(error, blob->name);
    sn_scene_free(in.scene);
    return status;
}

sn_status sn_scene_check_bones(const char *document, const sn_scene *scene, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; i < scene->bone_count && status == SN_OK; i++) {
        sn_error why = {0};
        char *path = sn_path_beside(document, scene->bones[i].uri);
        status = path != NULL ? sn_file_check(path, &why) : sn_fail_memory(&why, "a path");
        if (status == SN_ERROR_IO) {
            sn_log(SN_LOG_WARNING, "%s: bone \"%s\": %s; this run does without its surface", path, scene->bones[i].name, why.text);
            status = SN_OK;
        }
        if (status != SN_OK)
            sn_fail_at(error, status, path != NULL ? path : document, 0, "bone \"%s\": %s", scene->bones[i].name, why.text);
        free(path);
    }
    return status;
}

sn_status sn_scene_parse(const sn_blob *blob, bool load_bones, sn_scene *out, sn_error *error) {
    return parse(blob, (reader){.scene = out, .load_bones = load_bones}, error);
}

sn_status sn_scene_parse_around(const sn_blob *blob, sn_muscle *rigs, sn_scene *out, sn_error *error) {
    return parse(blob, (reader){.scene = out, .load_bones = true, .rigs = rigs}, error);
}

/* ---- writing ------------------------------------------------------------------------------------------------------------- */

static void write_solver(const sn_solver_settings *solver, sn_json *json) {
    sn_json_object(json, "solver");
    sn_json_text(json, "method", sn_solver_method_names[solver->method]);
    sn_json_text(json, "scheme", sn_scheme_names[solver->scheme]);
    if (solver->scheme == SN_SCHEME_KOHOUT)
        sn_json_text(json, "hinges", sn_hinge_rule_names[solver->hinges == SN_HINGES_PRINTED ? SN_HINGES_PRINTED : SN_HINGES_PUBLISHED]);
    if (solver->method == SN_SOLVER_XPBD) sn_json_text(json, "precision", sn_precision_names[solver->precision]);
    if (solver->substeps == SN_SUBSTEPS_AUTO)
        sn_json_text(json, "substeps", "auto");
    else
        sn_json_integer(json, "substeps", solver->substeps);
    sn_json_integer(json, "iterations", solver->iterations);
    if (solver->method == SN_SOLVER_QN) sn_json_number(json, "tolerance", solver->tolerance);
    if (solver->method == SN_SOLVER_QN) sn_json_text(json, "preconditioner", sn_preconditioning_names[solver->preconditioner]);
    sn_json_integer(json, "threads", solver->threads);
    sn_json_bool(json, "sleep", solver->sleep);
    sn_json_close(json);
}

static void write_bone(const sn_scene *scene, const sn_scene_bone *bone, sn_json *json) {
    sn_json_object_line(json, NULL);
    sn_json_text(json, "name", bone->name);
    sn_json_text(json, "mesh", bone->uri);
    if (bone->unit_certain || bone->meters_per_unit != scene->meters_per_unit) sn_json_number(json, "units", bone->meters_per_unit);
    if (bone->joint != SN_NONE) sn_json_text(json, "joint", scene->motion.joints[bone->joint].name);
    if (bone->passable) sn_json_bool(json, "contact", false);
    sn_json_close(json);
}

static void write_curve(const char *key, const sn_knots *knots, sn_json *json) {
    sn_json_array(json, key);
    for (sn_index i = 0; i < knots->count; i++) sn_json_numbers(json, NULL, (const double[2]){knots->x[i], knots->y[i]}, 2);
    sn_json_close(json);
}

static void write_maps(const sn_scene_muscle *muscle, sn_json *json) {
    if (muscle->activation_map == NULL && muscle->tendon_map == NULL && muscle->stiffness_map == NULL) return;
    sn_json_object(json, "maps");
    if (muscle->activation_map != NULL) sn_json_text(json, "activation", muscle->activation_map);
    if (muscle->tendon_map != NULL) sn_json_text(json, "tendon", muscle->tendon_map);
    if (muscle->stiffness_map != NULL) sn_json_text(json, "stiffness", muscle->stiffness_map);
    sn_json_close(json);
}

static void write_stiffness(const sn_scene_muscle *muscle, sn_json *json) {
    sn_json_object(json, "stiffness");
    sn_json_number(json, "relaxed", muscle->stiffness_relaxed);
    sn_json_number(json, "active", muscle->stiffness_active);
    sn_json_number(json, "internal", muscle->stiffness_internal);
    sn_json_number(json, "dihedral", muscle->stiffness_dihedral);
    sn_json_number(json, "volume", muscle->stiffness_volume);
    sn_json_bool(json, "areaScaled", muscle->stiffness_scaled);
    if (muscle->stiffness_curve.count > 0) write_curve("curve", &muscle->stiffness_curve, json);
    sn_json_close(json);
}

static void write_muscle(const sn_scene_muscle *muscle, sn_json *json) {
    sn_json_object(json, NULL);
    sn_json_text(json, "name", muscle->name);
    sn_json_text(json, "rig", muscle->uri);
    sn_json_bool(json, "enabled", muscle->enabled);
    if (muscle->untouched) sn_json_bool(json, "contact", false);
    if (muscle->unbound) sn_json_bool(json, "externals", false);
    sn_activation_write(&muscle->activation, json);
    sn_json_number(json, "contraction", muscle->contraction);
    sn_json_number(json, "restActivation", muscle->rest_activation);
    sn_json_number(json, "tone", muscle->tone);
    sn_json_number(json, "restLength", muscle->rest_length);
    sn_json_text(json, "law", sn_fiber_law_names[muscle->law]);
    sn_json_text(json, "stretch", sn_stretch_names[muscle->stretch]);
    write_stiffness(muscle, json);
    sn_json_text(json, "anisotropy", sn_anisotropy_names[muscle->anisotropy]);
    sn_json_number(json, "leastArea", muscle->least_area);
    if (muscle->volume_ratio.count > 0)
        write_curve("volumeRatio", &muscle->volume_ratio, json);
    else
        sn_json_number(json, "volumeRatio", 1.0);
    write_maps(muscle, json);
    sn_json_text(json, "mass", muscle->unit_mass ? "unit" : "density");
    sn_json_number(json, "density", muscle->density);
    sn_json_number(json, "damping", muscle->damping);
    sn_json_integer(json, "iterations", muscle->iterations);
    sn_json_close(json);
}

void sn_scene_write(const sn_scene *scene, sn_json *json) {
    sn_json_text(json, "format", FORMAT);
    sn_json_integer(json, "version", NEWEST_VERSION);
    if (scene->name != NULL) sn_json_text(json, "name", scene->name);
    sn_json_number(json, "metersPerUnit", scene->meters_per_unit);
    sn_json_number(json, "rate", scene->rate);
    sn_json_indices(json, "frames", (const sn_index[2]){scene->first_frame, scene->last_frame}, 2);
    sn_json_number(json, "preroll", scene->preroll);
    sn_json_number(json, "runIn", scene->run_in);
    sn_json_vec3(json, "gravity", scene->gravity);
    sn_contact_write(scene, json);
    sn_scene_externals_write(scene, json);
    write_solver(&scene->solver, json);
    sn_motion_write(&scene->motion, scene->meters_per_unit, json);
    sn_json_array(json, "bones");
    for (sn_index i = 0; i < scene->bone_count; i++) write_bone(scene, &scene->bones[i], json);
    sn_json_close(json);
    sn_scene_surfaces_write(scene, json);
    sn_json_array(json, "muscles");
    for (sn_index i = 0; i < scene->muscle_count; i++) write_muscle(&scene->muscles[i], json);
    sn_json_close(json);
}
