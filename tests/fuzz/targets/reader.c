/*
 * reader.c -- one reader under libFuzzer, coverage-guided: built once for each format, with -DTARGET_obj, _ply, _stl, _off, _vtk, _vtp,
 * _muscle, _scene, _pc2, _bvh, _amc, _asf, _motion, _osim, _mjcf, _mot, _nodes, _sensors, _body, _envelope, _field, _lines
 * or _gltf (make fuzz).
 *
 * Whatever the bytes, the reader must give a valid result or one line that names the file; the sanitizers and libFuzzer's limits of time
 * and memory watch over the rest.
 */
#include "sinew/model_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A fault of the reader's: libFuzzer keeps the input. */
static void demand(bool held, const char *what) {
    if (held) return;
    fprintf(stderr, "reader: %s\n", what);
    abort();
}

static void judge(sn_status status, const sn_error *error) {
    if (status == SN_OK) return;
    demand(status == SN_ERROR_INPUT || status == SN_ERROR_IO, "the status is none of bad input");
    demand(error->text[0] != '\0' && error->file[0] != '\0', "the error names no file or says nothing");
    demand(strpbrk(error->text, "\r\n") == NULL, "the error is more than one line");
}

#if defined(TARGET_muscle)

static int try_bytes(const sn_blob *blob, sn_error *error) {
    const sn_read_options options = {.meters_per_unit = 1.0};
    sn_muscle muscle;
    sn_document *document = NULL;
    if (sn_import_detect(blob) != NULL || sn_mesh_detect(blob) != SN_MESH_UNKNOWN) return -1; /* other readers' business */
    sn_status status = sn_muscle_parse(blob, &options, &muscle, &document, error);
    judge(status, error);
    if (status != SN_OK) return 0;
    demand(sn_muscle_validate(&muscle, error) == SN_OK, "the muscle is not valid");
    sn_output *output;
    demand(sn_output_open("/dev/null", false, &output, error) == SN_OK, "/dev/null cannot be opened");
    demand(sn_muscle_write(&muscle, document, &(sn_write_options){0}, output, error) == SN_OK, "the muscle cannot be written");
    sn_output_abort(output);
    sn_document_free(document);
    sn_muscle_free(&muscle);
    return 0;
}

#elif defined(TARGET_scene)

static int try_bytes(const sn_blob *blob, sn_error *error) {
    sn_scene scene;
    sn_scene_detect(blob);
    sn_status status = sn_scene_parse(blob, false, &scene, error);
    judge(status, error);
    if (status != SN_OK) return 0;
    demand(sn_scene_validate(&scene, error) == SN_OK, "the scene is not valid");
    sn_scene_free(&scene);
    return 0;
}

#elif defined(TARGET_bvh) || defined(TARGET_amc) || defined(TARGET_asf) || defined(TARGET_motion) || defined(TARGET_nodes)

#if defined(TARGET_bvh)
static const char FORMAT[] = "BVH";
#elif defined(TARGET_amc)
static const char FORMAT[] = "AMC";
#elif defined(TARGET_asf)
static const char FORMAT[] = "ASF";
#elif defined(TARGET_nodes)
static const char FORMAT[] = "nodes";
#else
static const char FORMAT[] = "motion document";
#endif

static const char bones_asf[] =
    ":units\nlength 0.45\nangle deg\n:root\norder TX TY TZ RX RY RZ\n:bonedata\nbegin\nname arm\ndirection 1 0 0\n"
    "length 4\naxis 0 0 90 XYZ\ndof rx tz\nend\nbegin\nname hand\ndof rz\nend\nbegin\nname nail\nend\n:hierarchy\n"
    "root arm\narm hand\nhand nail\n";

/* What was read is valid, also after a filter and at another rate, and can be written. */
static int try_bytes(const sn_blob *blob, sn_error *error) {
    static char name[] = "good.asf", text[sizeof bones_asf];
    const sn_clip_options options = {0};
    const char *format = sn_clip_detect(blob);
    sn_clip clip;
    sn_motion motion;
    sn_output *output;
    if (format == NULL || strcmp(format, FORMAT) != 0) return -1; /* other readers' business */
    memcpy(text, bones_asf, sizeof text);
    sn_blob bones = {.name = name, .data = text, .size = sizeof text - 1};
    sn_status status = sn_clip_parse(blob, strcmp(format, "AMC") == 0 ? &bones : NULL, &options, &clip, error);
    judge(status, error);
    if (status != SN_OK) return 0;
    demand(sn_clip_validate(&clip, error) == SN_OK, "the motion is not valid");
    demand(sn_clip_filter(&clip, 0.2 * clip.rate, NULL, error) == SN_OK, "the motion cannot be filtered");
    demand(sn_clip_resample(&clip, 1.5 * clip.rate, error) == SN_OK, "the motion cannot be resampled");
    demand(sn_clip_validate(&clip, error) == SN_OK && sn_clip_to_motion(&clip, &motion, error) == SN_OK,
           "the motion is not valid any more");
    demand(sn_output_open("/dev/null", false, &output, error) == SN_OK, "/dev/null cannot be opened");
    demand(sn_motion_document_write(&motion, &(sn_motion_head){.rate = clip.rate}, output, error) == SN_OK, "the motion cannot be written");
    sn_output_abort(output);
    sn_motion_free(&motion);
    sn_clip_free(&clip);
    return 0;
}

#elif defined(TARGET_pc2)

static int try_bytes(const sn_blob *blob, sn_error *error) {
    int fd = memfd_create("cache", MFD_CLOEXEC);
    char path[64];
    const sn_track_options options = {.vertex_count = 3, .rate = 24.0, .meters_per_unit = 0.01, .up_y = true};
    sn_vertex_track track;
    demand(fd >= 0 && write(fd, blob->data, blob->size) == (ssize_t)blob->size, "no file in memory");
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    sn_status status = sn_vertex_track_read(path, &options, &track, error); /* PC2, MDD */
    close(fd);
    judge(status, error);
    if (status == SN_OK) sn_vertex_track_free(&track);
    return 0;
}

#elif defined(TARGET_osim) || defined(TARGET_mjcf)

static int try_bytes(const sn_blob *blob, sn_error *error) {
    sn_skeleton skeleton;
    sn_clip clip;
#if defined(TARGET_osim)
    if (!sn_osim_detect(blob)) return -1; /* other readers' business */
    sn_status status = sn_osim_parse(blob, &skeleton, error);
#else
    if (!sn_mjcf_detect(blob)) return -1;
    sn_status status = sn_mjcf_parse(blob, &skeleton, error);
#endif
    judge(status, error);
    if (status != SN_OK) return 0;
    demand(sn_skeleton_animate(&skeleton, NULL, &clip, error) == SN_OK, "the model cannot be put at rest");
    sn_clip_free(&clip);
    sn_skeleton_free(&skeleton);
    return 0;
}

#elif defined(TARGET_mot)

static int try_bytes(const sn_blob *blob, sn_error *error) {
    sn_columns columns;
    if (!sn_storage_detect(blob)) return -1; /* other readers' business */
    sn_status status = sn_storage_parse(blob, &columns, error);
    judge(status, error);
    if (status != SN_OK) return 0;
    demand(columns.row_count > 0 && columns.times != NULL, "a motion without a row");
    sn_columns_free(&columns);
    return 0;
}

#elif defined(TARGET_sensors)

static int try_bytes(const sn_blob *blob, sn_error *error) {
    sn_sensors sensors;
    sn_muscle_names names;
    sn_status status = sn_sensors_parse(blob, NULL, &sensors, error);
    judge(status, error);
    if (status == SN_OK) {
        demand(sensors.sensor_count > 0 && sensors.channel_count > 0, "there is no sensor, or no channel");
        sn_sensors_free(&sensors);
    }
    *error = (sn_error){0};
    status = sn_muscle_names_parse(blob, &names, error);
    judge(status, error);
    if (status == SN_OK) sn_muscle_names_free(&names);
    *error = (sn_error){0};
    status = sn_activation_names_parse(blob, &names, error);
    judge(status, error);
    if (status == SN_OK) sn_muscle_names_free(&names);
    return 0;
}

#elif defined(TARGET_lines)

static int try_bytes(const sn_blob *blob, sn_error *error) {
    sn_fibers fibers;
    sn_polylines_detect(blob);
    sn_status status = sn_polylines_parse(blob, &fibers, error);
    judge(status, error);
    if (status != SN_OK) return 0;
    demand(fibers.polyline_count > 0, "no fibre is none");
    sn_fibers_free(&fibers);
    return 0;
}

#elif defined(TARGET_gltf)

static sn_status take_part(void *context, const sn_gltf_part *part, sn_error *error) {
    (void)context, (void)error;
    for (sn_index i = 0; i < part->corner_count; i++)
        demand(part->corners[i] >= 0 && part->corners[i] < part->vertex_count, "a corner is out of range");
    return SN_OK;
}

static int try_bytes(const sn_blob *blob, sn_error *error) {
    const sn_gltf_source source = {.file = blob};
    sn_status status = sn_gltf_read(&source, take_part, NULL, error);
    sn_error_set_file(error, blob->name);
    judge(status, error);
    return 0;
}

#elif defined(TARGET_envelope)

static int try_bytes(const sn_blob *blob, sn_error *error) {
    sn_envelope envelope;
    if (!sn_envelope_detect(blob)) return -1; /* other readers' business */
    sn_status status = sn_envelope_parse(blob, &envelope, error);
    judge(status, error);
    if (status != SN_OK) return 0;
    demand(sn_envelope_validate(&envelope, error) == SN_OK, "the envelope is not valid");
    sn_output *output;
    demand(sn_output_open("/dev/null", false, &output, error) == SN_OK, "/dev/null cannot be opened");
    demand(sn_envelope_write(&envelope, NULL, blob, output, error) == SN_OK, "the envelope cannot be written");
    sn_output_abort(output);
    sn_envelope_free(&envelope);
    return 0;
}

#elif defined(TARGET_field)

#include "../fields.h"

/* Under right hashes: else nothing but these would be tried. */
static int try_bytes(const sn_blob *blob, sn_error *error) {
    sn_distance_field field;
    field_forge(blob);
    sn_status status = sn_distance_field_load(blob, FIELD_HASH, &field, error);
    judge(status, error);
    if (status != SN_OK) return 0;
    demand(field_fault(&field) == NULL, "the field is not valid");
    sn_distance_field_free(&field);
    return 0;
}

#elif defined(TARGET_body)

static int try_bytes(const sn_blob *blob, sn_error *error) {
    sn_fit_table table;
    sn_status status = sn_fit_table_parse(blob, &table, error);
    judge(status, error);
    if (status != SN_OK) return 0;
    for (sn_index j = 0; j < table.joint_count; j++) demand(table.joints[j].parent < j, "a parent comes after its child");
    sn_fit_table_free(&table);
    return 0;
}

#else

#if defined(TARGET_obj)
enum { FORMAT = SN_MESH_OBJ };
#elif defined(TARGET_ply)
enum { FORMAT = SN_MESH_PLY };
#elif defined(TARGET_stl)
enum { FORMAT = SN_MESH_STL };
#elif defined(TARGET_off)
enum { FORMAT = SN_MESH_OFF };
#elif defined(TARGET_vtk)
enum { FORMAT = SN_MESH_VTK };
#elif defined(TARGET_vtp)
enum { FORMAT = SN_MESH_VTP };
#endif

/* What was read can be written as VTP and comes back the same. */
static void demand_round_trip(const sn_mesh *mesh, sn_error *error) {
    char path[64];
    int fd = memfd_create("mesh", MFD_CLOEXEC);
    sn_output *output;
    sn_mesh back;
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    demand(fd >= 0 && sn_output_open(path, true, &output, error) == SN_OK, "no file in memory");
    demand(sn_mesh_write(mesh, SN_MESH_VTP, SN_ENCODING_DEFAULT, output, error) == SN_OK, "the mesh cannot be written");
    demand(sn_output_commit(output, error) == SN_OK && sn_mesh_read(path, &back, NULL, error) == SN_OK, "what is written cannot be read");
    demand(back.vertex_count == mesh->vertex_count && back.triangle_count == mesh->triangle_count, "the mesh that comes back is another");
    demand(back.attribute_count == mesh->attribute_count, "the mesh comes back with other attributes");
    close(fd);
    sn_mesh_free(&back);
}

static int try_bytes(const sn_blob *blob, sn_error *error) {
    sn_mesh mesh;
    bool imported = FORMAT != SN_MESH_VTK && FORMAT != SN_MESH_VTP && sn_import_detect(blob) != NULL;
    if (imported || sn_mesh_detect(blob) != FORMAT) return -1; /* other readers' business */
    sn_status status = sn_mesh_parse(blob, false, &mesh, error);
    judge(status, error);
    if (status != SN_OK) return 0;
    demand(sn_mesh_validate(&mesh, error) == SN_OK, "the mesh is not valid");
    demand_round_trip(&mesh, error);
    sn_mesh_free(&mesh);
    return 0;
}

#endif

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static char name[] = "input";
    sn_error error = {0};
    sn_blob blob = {.name = name, .data = malloc(size + 1), .size = size};
    if (blob.data == NULL) return 0;
    if (size > 0) memcpy(blob.data, data, size);
    blob.data[size] = '\0';
    int kept = try_bytes(&blob, &error);
    free(blob.data);
    return kept;
}
