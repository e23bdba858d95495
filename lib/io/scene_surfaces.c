/*
 * scene_surfaces.c -- the surfaces of a scene document: { "name", "contact", "envelope" }, or { "name", "contact", "mesh", "frames",
 * "units", "up", "rate" }.
 */
#include "scene_surfaces.h"

#include <stdlib.h>
#include <string.h>

static const char *const up_names[] = {"y", "z", NULL};

/* ---- reading: what the document says --------------------------------------------------------------------------------------------- */

static sn_status get_file(const sn_json_value *value, char **out, sn_error *error) {
    sn_status status = sn_json_get_text(value, out, error);
    return status == SN_OK && *out != NULL && **out == '\0' ? sn_json_complain(value, error, "expected the name of a file, found none")
                                                            : status;
}

static sn_status parse_envelope(const sn_json_value *value, sn_scene_surface *out, sn_error *error) {
    static const char *const known[] = {"name", "contact", "envelope", NULL};
    sn_json_value envelope = sn_json_member(value, "envelope");
    sn_status status = get_file(&envelope, &out->uri, error);
    if (status == SN_OK) status = sn_json_check_members(value, known, error);
    return status;
}

static sn_status parse_driven(const sn_json_value *value, sn_scene_surface *out, sn_error *error) {
    static const char *const known[] = {"name", "contact", "mesh", "frames", "units", "up", "rate", NULL};
    sn_json_value mesh = sn_json_member(value, "mesh"), frames = sn_json_member(value, "frames"), units = sn_json_member(value, "units"),
                  up = sn_json_member(value, "up"), rate = sn_json_member(value, "rate");
    int axis = -1;
    out->kind = SN_SURFACE_DRIVEN;
    sn_status status = sn_json_require(&mesh, "the file of the mesh at rest, or of an envelope (\"envelope\")", error);
    if (status == SN_OK) status = get_file(&mesh, &out->uri, error);
    if (status == SN_OK) status = sn_json_require(&frames, "the file of the frames: a PC2 or MDD cache, or meshes numbered by '#'", error);
    if (status == SN_OK) status = get_file(&frames, &out->frames, error);
    if (status == SN_OK) status = sn_units_parse(&units, &out->meters_per_unit, error);
    if (status == SN_OK) status = sn_json_get_choice(&up, up_names, &axis, error);
    if (status == SN_OK) status = sn_json_get_number(&rate, SN_JSON_POSITIVE, INFINITY, &out->rate, error);
    out->up = axis < 0 ? SN_UP_UNKNOWN : axis == 0 ? SN_UP_Y : SN_UP_Z;
    if (status == SN_OK) status = sn_json_check_members(value, known, error);
    return status;
}

static sn_status parse_surface(const sn_json_value *value, sn_scene_surface *out, sn_error *error) {
    sn_json_value name = sn_json_member(value, "name"), envelope = sn_json_member(value, "envelope"),
                  contact = sn_json_member(value, "contact");
    sn_status status = sn_json_expect_object(value, error);
    if (status == SN_OK) status = sn_json_require(&name, "the name of the surface", error);
    if (status == SN_OK) status = sn_json_get_text(&name, &out->name, error);
    if (status == SN_OK) status = sn_json_get_bool(&contact, &out->solid, error);
    if (status != SN_OK) return status;
    return sn_json_has(&envelope) ? parse_envelope(value, out, error) : parse_driven(value, out, error);
}

sn_status sn_scene_surfaces_parse(const sn_json_value *value, sn_scene *scene, sn_error *error) {
    if (!sn_json_has(value)) return SN_OK;
    sn_index count;
    sn_status status = sn_json_expect_list(value, SN_LIST_LIMIT, &count, error);
    if (status != SN_OK) return status;
    if ((scene->surfaces = SN_NEW(sn_scene_surface, count)) == NULL) return sn_fail_memory(error, "surfaces");
    for (sn_index i = 0; i < count && status == SN_OK; i++) {
        sn_json_value surface = sn_json_element(value, i);
        scene->surface_count = i + 1;
        status = parse_surface(&surface, &scene->surfaces[i], error);
    }
    return status;
}

/* ---- reading: the files ------------------------------------------------------------------------------------------------------------ */

/* Its bones are the scene's, by name: a bone that the scene lacks is a joint of its name, or nothing that could be asked for. */
static sn_status find_joints(const sn_scene *scene, sn_scene_surface *surface, sn_error *error) {
    const sn_envelope *envelope = &surface->envelope;
    if ((surface->joints = SN_NEW(sn_index, envelope->bone_count)) == NULL) return sn_fail_memory(error, "an envelope");
    for (sn_index b = 0; b < envelope->bone_count; b++) {
        sn_carrier carrier = sn_scene_carrier(scene, envelope->bones[b]);
        if (carrier.kind != SN_CARRIER_BONE && carrier.kind != SN_CARRIER_JOINT)
            return sn_fail(error, SN_ERROR_INPUT,
                           "surface \"%s\": its envelope is bound to the bone \"%s\", which the scene does not have; add it to \"bones\"",
                           surface->name, envelope->bones[b]);
        surface->joints[b] = carrier.kind == SN_CARRIER_BONE ? scene->bones[carrier.index].joint : carrier.index;
    }
    return SN_OK;
}

static sn_status load_envelope(const char *path, const sn_scene *scene, sn_scene_surface *surface, sn_error *error) {
    sn_blob blob;
    sn_status status = sn_blob_read_named(path, &blob, error);
    if (status != SN_OK) return status;
    status = sn_envelope_parse(&blob, &surface->envelope, error);
    sn_blob_free(&blob);
    return status == SN_OK ? find_joints(scene, surface, error) : status;
}

/* Frames of another size than the mesh are most likely in another unit; of longer edges alone, of another order of vertices. */
static const double MOST_GROWN = 3.0;

static void warn_of_size(const char *name, const sn_mesh *rest, const sn_mesh *first) {
    double size = sn_box_diagonal(sn_mesh_box(rest)), now = sn_box_diagonal(sn_mesh_box(first));
    double side = sn_mesh_mean_side(rest), side_now = sn_mesh_mean_side(first);
    if (now > MOST_GROWN * size || size > MOST_GROWN * now)
        sn_log(SN_LOG_WARNING, "surface \"%s\": it is %.3g m across at rest and %.3g m in its first frame; are both in one unit?", name,
               size, now);
    else if (side_now > MOST_GROWN * side)
        sn_log(SN_LOG_WARNING,
               "surface \"%s\": its edges are %.3g times as long in its first frame as at rest; are the vertices of both in one order?",
               name, side_now / side);
}

/* How far the vertices of a frame are from rest, on average, if they are turned by a quarter about x (+1, -1), or not (0). */
static double mean_distance(const sn_mesh *rest, const sn_mesh *first, int turn) {
    double sum = 0.0;
    for (sn_index v = 0; v < rest->vertex_count; v++) {
        sn_vec3 p = first->positions[v];
        if (turn != 0) p = sn_v3(p.x, -turn * p.z, turn * p.y);
        sum += sn_distance(p, rest->positions[v]);
    }
    return sum / rest->vertex_count;
}

/* Frames that would lie at the rest place if they were turned upright have been written with another axis up. */
static void warn_of_axis(const char *name, const sn_mesh *rest, const sn_mesh *first) {
    double away = mean_distance(rest, first, 0), turned = fmin(mean_distance(rest, first, 1), mean_distance(rest, first, -1));
    if (away > 0.1 * sn_box_diagonal(sn_mesh_box(rest)) && turned < 0.1 * away)
        sn_log(
            SN_LOG_WARNING,
            "surface \"%s\": its first frame is %.3g m away from rest, and %.3g m if y and z are exchanged; have mesh and frames the same "
            "axis up?",
            name, away, turned);
}

static sn_status warn_of_first_frame(const sn_scene_surface *surface, sn_error *error) {
    const sn_mesh *rest = &surface->envelope.mesh;
    sn_mesh first = *rest; /* lends all but its places */
    if ((first.positions = SN_NEW(sn_vec3, rest->vertex_count)) == NULL) return sn_fail_memory(error, "a surface");
    for (sn_index v = 0; v < rest->vertex_count; v++) first.positions[v] = sn_vertex_track_at(&surface->track, surface->track.times[0], v);
    warn_of_size(surface->name, rest, &first);
    warn_of_axis(surface->name, rest, &first);
    free(first.positions);
    return SN_OK;
}

/* Nobody keeps frames that are farther apart, s: they are numbers in the place of times. */
static const double MOST_APART = 0.75;

static void warn_of_spacing(const sn_scene_surface *surface) {
    const sn_vertex_track *track = &surface->track;
    double apart = (track->times[track->sample_count - 1] - track->times[0]) / fmax(1.0, track->sample_count - 1.0);
    if (track->sample_count > 2 && apart > MOST_APART)
        sn_log(SN_LOG_WARNING, "surface \"%s\": its frames are %.3g s apart; \"rate\" tells how many there are in a second", surface->name,
               apart);
}

static sn_status load_frames(const char *document, const sn_scene *scene, bool up_y, sn_scene_surface *surface, sn_error *error) {
    const sn_track_options options = {.vertex_count = surface->envelope.mesh.vertex_count,
                                      .rate = surface->rate > 0.0 ? surface->rate : scene->rate,
                                      .rate_told = surface->rate > 0.0,
                                      .meters_per_unit = surface->meters_per_unit,
                                      .up_y = up_y};
    char *path = sn_path_beside(document, surface->frames);
    if (path == NULL) return sn_fail_memory(error, "a path");
    sn_status status = sn_vertex_track_read(path, &options, &surface->track, error);
    free(path);
    if (status != SN_OK) return status;
    warn_of_spacing(surface);
    return warn_of_first_frame(surface, error);
}

static sn_status load_driven(const char *document, const sn_scene *scene, const char *path, sn_scene_surface *surface, sn_error *error) {
    sn_mesh_frame frame;
    sn_status status = sn_file_check(path, error);
    if (status == SN_OK) status = sn_mesh_read(path, &surface->envelope.mesh, &frame, error);
    if (status != SN_OK) return status;
    if (surface->envelope.mesh.vertex_count < 1) return sn_fail_at(error, SN_ERROR_INPUT, path, 0, "has no vertices");
    if (!(surface->meters_per_unit > 0.0))
        surface->meters_per_unit = frame.meters_per_unit > 0.0 ? frame.meters_per_unit : scene->meters_per_unit;
    if (surface->up == SN_UP_UNKNOWN) surface->up = frame.up == SN_UP_Y ? SN_UP_Y : SN_UP_Z;
    bool up_y = surface->up == SN_UP_Y;
    surface->space = frame.space;
    sn_mesh_convert(&surface->envelope.mesh, surface->meters_per_unit, up_y);
    return load_frames(document, scene, up_y, surface, error);
}

static sn_status load_surface(const char *document, const sn_scene *scene, sn_scene_surface *surface, sn_error *error) {
    char *path = sn_path_beside(document, surface->uri);
    if (path == NULL) return sn_fail_memory(error, "a path");
    sn_status status = surface->kind == SN_SURFACE_ENVELOPE ? load_envelope(path, scene, surface, error)
                                                            : load_driven(document, scene, path, surface, error);
    free(path);
    surface->loaded = status == SN_OK;
    return status;
}

sn_status sn_scene_surfaces_load(const char *document, bool all, sn_scene *scene, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; i < scene->surface_count && status == SN_OK; i++)
        if (all || sn_scene_surface_carries(scene, i)) status = load_surface(document, scene, &scene->surfaces[i], error);
    if (status == SN_OK) sn_scene_warn_of_times(scene);
    return status;
}

/* ---- writing ----------------------------------------------------------------------------------------------------------------------- */

static void write_driven(const sn_scene_surface *surface, sn_json *json) {
    sn_json_text(json, "mesh", surface->uri);
    sn_json_text(json, "frames", surface->frames);
    if (surface->meters_per_unit > 0.0) sn_json_number(json, "units", surface->meters_per_unit);
    if (surface->up != SN_UP_UNKNOWN) sn_json_text(json, "up", surface->up == SN_UP_Y ? "y" : "z");
    if (surface->rate > 0.0) sn_json_number(json, "rate", surface->rate);
}

void sn_scene_surfaces_write(const sn_scene *scene, sn_json *json) {
    if (scene->surface_count == 0) return;
    sn_json_array(json, "surfaces");
    for (sn_index i = 0; i < scene->surface_count; i++) {
        const sn_scene_surface *surface = &scene->surfaces[i];
        sn_json_object_line(json, NULL);
        sn_json_text(json, "name", surface->name);
        if (surface->solid) sn_json_bool(json, "contact", true);
        if (surface->kind == SN_SURFACE_ENVELOPE)
            sn_json_text(json, "envelope", surface->uri);
        else
            write_driven(surface, json);
        sn_json_close(json);
    }
    sn_json_close(json);
}
