/*
 * io.h -- meshes and documents in, frames and reports out.   rank 3
 *
 * Input is read whole into a blob and parsed from memory; output is all or nothing: written beside its target, flushed, renamed.
 * A path "-" (or NULL) is stdin or stdout.
 */
#ifndef SINEW_IO_H
#define SINEW_IO_H

#include "sinew/distance_field.h"
#include "sinew/embedding.h"
#include "sinew/envelope.h"
#include "sinew/motion_clip.h"
#include "sinew/motion_fit.h"
#include "sinew/muscle.h"
#include "sinew/rig.h"
#include "sinew/scene.h"
#include "sinew/sense.h"

/* ---- documents (lib/io/json.c) ---------------------------------------------------------------------------------------- */

/* Whether a member that no reader knows makes a document an error, in the whole process; by default it only draws a warning. Members whose
 * names begin with '_' or "x-" are the user's own under both. Set it before anything is read. */
void sn_documents_strict(bool strict);

/* ---- bytes (lib/io/stream.c) ---------------------------------------------------------------------------------------- */

typedef struct sn_blob {
    char *name; /* as the user gave it; "<stdin>" for "-" */
    char *data; /* size bytes and a terminating 0 */
    size_t size;
} sn_blob;
/* Files and pipes; a directory is an error. A file packed by gzip is unpacked (at most 64 MB and 64 times its size), a byte order mark
 * of UTF-8 taken off, UTF-16 refused. */
SN_MUST_CHECK sn_status sn_blob_read(const char *path, sn_blob *out, sn_error *error);
/* The bytes as they are: data without a signature, whose first bytes may look like anything. */
SN_MUST_CHECK sn_status sn_blob_read_bytes(const char *path, sn_blob *out, sn_error *error);
/* Is it a regular file, as what documents name must be? A device or a pipe may never end. */
SN_MUST_CHECK sn_status sn_file_check(const char *path, sn_error *error);
/* sn_blob_read of a file that a document names. */
SN_MUST_CHECK sn_status sn_blob_read_named(const char *path, sn_blob *out, sn_error *error);
void sn_blob_free(sn_blob *blob);

typedef struct sn_output sn_output;
/* Open for writing; nothing is seen at path before commit. stream = true: whole lines go out as they are written (logs). */
SN_MUST_CHECK sn_status sn_output_open(const char *path, bool stream, sn_output **out, sn_error *error);
/* Go on behind the first `keep` bytes of a regular file that is there: what is behind them goes with the first write, nothing before. */
SN_MUST_CHECK sn_status sn_output_open_behind(const char *path, uint64_t keep, bool stream, sn_output **out, sn_error *error);
/* What was written until now is seen at path, whatever happens from here on; no flush to the disk. tail (nullable): is behind it until the
 * next write. What is held in memory stays there. */
sn_status sn_output_publish(sn_output *output, const char *tail, sn_error *error);
/* One that stays in memory, until sn_output_take makes a blob of what was written, of that name ("-", NULL: "<stdout>"), and frees it. */
SN_MUST_CHECK sn_status sn_output_open_memory(sn_output **out, sn_error *error);
SN_MUST_CHECK sn_status sn_output_take(sn_output *output, const char *name, sn_blob *out, sn_error *error);
/* The first failure is kept and returned by commit too: a writer may ignore those in between. */
sn_status sn_output_write(sn_output *output, const void *data, size_t size, sn_error *error);
sn_status sn_output_print(sn_output *output, const char *format, ...) SN_PRINTF(2, 3);
/* Patch bytes already written (a count in a header); not for stdout streams. */
sn_status sn_output_patch(sn_output *output, uint64_t offset, const void *data, size_t size, sn_error *error);
bool sn_output_is_terminal(const sn_output *output);
SN_MUST_CHECK sn_status sn_output_commit(sn_output *output, sn_error *error); /* flush, close checked, rename; frees output */
void sn_output_abort(sn_output *output);                                      /* nothing appears; frees output; NULL is fine */

/* ---- JSON out (lib/io/json_write.c): a streaming writer over an output ------------------------------------------------ */

typedef struct sn_json sn_json;
sn_json *sn_json_begin(sn_output *output, bool pretty); /* NULL = out of memory; pretty: a member a line, arrays of numbers in one */
/* key is NULL inside arrays and at the top. */
void sn_json_object(sn_json *json, const char *key);
void sn_json_array(sn_json *json, const char *key);
void sn_json_close(sn_json *json);                                 /* the innermost object or array */
void sn_json_number(sn_json *json, const char *key, double value); /* NaN and infinity become null */
void sn_json_integer(sn_json *json, const char *key, int64_t value);
void sn_json_text(sn_json *json, const char *key, const char *text); /* NULL becomes null; bytes that are not UTF-8 become U+FFFD */
void sn_json_bool(sn_json *json, const char *key, bool value);
void sn_json_null(sn_json *json, const char *key);
void sn_json_numbers(sn_json *json, const char *key, const double *values, size_t count);
void sn_json_vec3(sn_json *json, const char *key, sn_vec3 value); /* [x,y,z] */
void sn_json_indices(sn_json *json, const char *key, const sn_index *values, size_t count);
/* All closed, a final newline; frees json (not the output). The first write error is returned. */
SN_MUST_CHECK sn_status sn_json_end(sn_json *json, sn_error *error);

/* ---- meshes (lib/io/mesh_io.c and one file per format) ----------------------------------------------------------------- */

typedef enum sn_mesh_format {
    SN_MESH_UNKNOWN,
    SN_MESH_OBJ,
    SN_MESH_PLY,
    SN_MESH_STL,
    SN_MESH_OFF,
    SN_MESH_VTK, /* legacy VTK PolyData: read only */
    SN_MESH_VTP  /* VTK XML PolyData */
} sn_mesh_format;
typedef enum sn_mesh_encoding { SN_ENCODING_DEFAULT, SN_ENCODING_ASCII, SN_ENCODING_LITTLE, SN_ENCODING_BIG } sn_mesh_encoding;

sn_mesh_format sn_mesh_detect(const sn_blob *blob);        /* from content; the name decides only where content cannot */
sn_mesh_format sn_mesh_format_from_name(const char *path); /* from the extension */
const char *sn_mesh_format_name(sn_mesh_format format);
bool sn_mesh_format_has_attributes(sn_mesh_format format); /* any: PLY and VTP. OBJ and OFF have colours alone */
/* Parse any known format; *out is a mesh with indices in range (polygons fanned); coordinates may be non-finite only if
 * allow_nonfinite. Errors name line (text) or byte offset (binary). */
SN_MUST_CHECK sn_status sn_mesh_parse(const sn_blob *blob, bool allow_nonfinite, sn_mesh *out, sn_error *error);

/* What a file says of its own coordinates: glTF, FBX and Collada do, most formats say nothing. */
typedef struct sn_mesh_frame {
    double meters_per_unit; /* 0 = not said */
    sn_up up;
    sn_space space;
} sn_mesh_frame;
/* As sn_mesh_parse, and what the file says of unit and axis; coordinates stay as they are in the file. */
SN_MUST_CHECK sn_status sn_mesh_parse_frame(const sn_blob *blob, bool allow_nonfinite, sn_mesh *out, sn_mesh_frame *frame, sn_error *error);
/* The anatomical space of any file: what was told (sn_space_tell), else what its first comments say. */
sn_space sn_blob_space(const sn_blob *blob);
/* A file; finite coordinates only. frame is nullable. */
SN_MUST_CHECK sn_status sn_mesh_read(const char *path, sn_mesh *out, sn_mesh_frame *frame, sn_error *error);
/* Turn y up to z up, where up_y: (x, y, z) becomes (x, -z, y); and scale. */
void sn_mesh_convert(sn_mesh *mesh, double scale, bool up_y);

/* Frames of a mesh that a host deforms (lib/io/vertex_track.c). */
typedef struct sn_track_options {
    sn_index vertex_count; /* that every frame must have */
    double rate;           /* frames a second: where the frames' numbers become times */
    bool rate_told;        /* by the user: it goes before the times of a cache that has some */
    double meters_per_unit;
    bool up_y; /* else z */
} sn_track_options;
/* Read them from path: a PC2 or an MDD point cache, or meshes of any format numbered in place of its '#' ("skin.####.ply"). Finite, in
 * metres, z up, times ascending, at least one. A PC2's frame f (start + k times its rate) and a mesh's number f are at f / rate; an MDD has
 * times. A warning in the log: frames of a sequence that are missing. Errors name the file. */
SN_MUST_CHECK sn_status sn_vertex_track_read(const char *path, const sn_track_options *options, sn_vertex_track *out, sn_error *error);

/* Which of the formats that mesh-import(1) reads this is ("glb", "fbx", "dae", ...), from content alone; NULL = none of them
 * (lib/io/import_detect.c). sn_mesh_parse has it read by that program, in a child with limits of memory and time (lib/io/import.c). */
const char *sn_import_detect(const sn_blob *blob);
const char *sn_import_format_name(const char *kind); /* "FBX", "glTF", ... for messages */

/* ---- the surfaces of a glTF file (lib/io/gltf*.c): for mesh-import, which has the limits that a hostile file needs ------------- */

typedef struct sn_gltf_source {
    const sn_blob *file; /* JSON or GLB, of version 2 */
    /* A buffer by its uri, no data: uri; false = there is none. Nullable. */
    bool (*read_buffer)(const void *context, const char *uri, sn_blob *out);
    const void *context;
} sn_gltf_source;

/* What hangs on one node, or one instance of it, in the world: in metres, y up. Morph targets have their default weights; a skinned mesh is
 * as it was bound, where its joints have it (glTF 2.0, 3.7.3.3: its node does not move it). */
typedef struct sn_gltf_part {
    const char *node_name, *mesh_name; /* "" = none */
    sn_index node, mesh;
    sn_index instance; /* of the node, from 0; SN_NONE = it has none (EXT_mesh_gpu_instancing) */
    sn_index vertex_count, corner_count;
    double *positions; /* (3 x vertex_count) may be no finite numbers */
    float *colours;    /* (4 x vertex_count) 0 to 1; NULL = none */
    sn_index *corners; /* (corner_count) by threes, in range, turned where the node mirrors */
} sn_gltf_part;
typedef sn_status (*sn_gltf_sink)(void *context, const sn_gltf_part *part, sn_error *error);
/* Parts one by one, in the order of the scene; lines and points are passed over. An extension that is required and not known, packed
 * meshes, numbers that are not there are errors; a warning in the log where what is used but not required may move something. */
SN_MUST_CHECK sn_status sn_gltf_read(const sn_gltf_source *source, sn_gltf_sink sink, void *context, sn_error *error);
/* The required extensions alone; *unbound: a skin has no inverse bind matrices, on which assimp 5.2 dies. */
SN_MUST_CHECK sn_status sn_gltf_check(const sn_blob *file, bool *unbound, sn_error *error);
/* Of version 1, which is another format. */
bool sn_gltf_is_old(const sn_blob *file);
/* Is there something in a Collada file that assimp 5.2 misreads in silence? shapes: surfaces matter too. SN_OK also where it is no XML.
 * (lib/io/collada.c) */
SN_MUST_CHECK sn_status sn_collada_check(const sn_blob *file, bool shapes, sn_error *error);

/* ---- the meshes of one file: objects of a scene, groups of an OBJ file (lib/io/mesh_part.c) ------------------------------ */

typedef struct sn_mesh_part {
    const char *name; /* "" = it has none; lives as long as the mesh */
    sn_index vertices, triangles;
} sn_mesh_part;
/* The parts in the order of the file; triangles of no group are the last one. At least one; *out is freed by the caller. */
SN_MUST_CHECK sn_status sn_mesh_parts(const sn_mesh *mesh, sn_mesh_part **out, sn_index *count, sn_error *error);
/* Keep one part, by its name or its number from 1 (a name that is a number comes first), and the vertices that it uses, in their
 * order; it is the only group then. SN_ERROR_INPUT: there is none, or more than one of that name, or it is empty. */
SN_MUST_CHECK sn_status sn_mesh_select(sn_mesh *mesh, const char *which, sn_error *error);
/* Attributes that the format cannot hold are left out, said by one warning in the log. VTP in SN_ENCODING_LITTLE (the default) and
 * SN_ENCODING_BIG has its numbers as appended raw bytes. */
SN_MUST_CHECK sn_status sn_mesh_write(const sn_mesh *mesh, sn_mesh_format format, sn_mesh_encoding encoding, sn_output *output,
                                      sn_error *error);

/* ---- the muscle document (lib/io/document.c) ----------------------------------------------------------------------------- */

/* Everything a document holds that sn_muscle does not: members unknown to this version, sections as they were written, history. */
typedef struct sn_document sn_document;

typedef struct sn_read_options {
    double meters_per_unit; /* for bare meshes; 0 = what the file says, else metres, with a warning where the size says otherwise */
    bool up_y;              /* bare mesh has y up: turn it to z up */
    bool up_given;          /* up_y holds even where the file says otherwise */
    bool asked;             /* these were asked for: a muscle document for which unit or axis do not hold is refused, not read as it is */
    bool allow_nonfinite;   /* bare meshes only */
    const char *mesh;       /* of a bare mesh's parts, the one to read (sn_mesh_select); NULL = all */
} sn_read_options;

/* One entry of a document's history. */
typedef struct sn_history_entry {
    const char *tool;
    int arg_count;
    const char *const *args; /* canonical: long option, value, ...; files as sha256:... */
    const char *input;       /* "sha256:..." of the tool's input */
} sn_history_entry;

/* Parse a muscle document, or a bare mesh (then *document is a fresh one). Errors carry line and column. A mesh given by uri is read
 * relative to the document and its hash checked. */
SN_MUST_CHECK sn_status sn_muscle_parse(const sn_blob *blob, const sn_read_options *options, sn_muscle *out, sn_document **document,
                                        sn_error *error);
typedef struct sn_write_options {
    unsigned changed;              /* bits of sn_section: these from the muscle, the others and unknown members as they were */
    const sn_history_entry *entry; /* nullable: appended to the history */
    bool drop_history;             /* leave all of it out */
} sn_write_options;

/* Write. A changed mesh drops roots, structure, fibers, attachments; changed roots drop structure and fibers; a changed structure drops
 * fibers (each said by the log as a warning). */
SN_MUST_CHECK sn_status sn_muscle_write(const sn_muscle *muscle, const sn_document *document, const sn_write_options *options,
                                        sn_output *output, sn_error *error);
void sn_document_free(sn_document *document);

/* ---- what a user adds to a muscle (lib/io/sites.c polylines.c) ----------------------------------------------------------------- */

/* Lines "origin X Y Z" and "insertion X Y Z" (blanks, tabs or commas between; # begins a comment), or fibres as sn_polylines_read takes
 * them: each has a site of the origin where it begins and one of the insertion where it ends. space: as sn_blob_space. *sites is freed by
 * the caller. */
SN_MUST_CHECK sn_status sn_sites_read(const char *path, sn_index *count, sn_end_site **sites, sn_space *space, sn_error *error);
/* Fibres: the lines (l) of an OBJ file or those of VTK PolyData (VTP or legacy), or the polylines of a muscle document or of any JSON
 * object
 * {"polylines": [{"points": [x,y,z,...]}]}; at least one. Lines of two points are joined where they meet end to end. Free with
 * sn_fibers_free. space, nullable: as sn_blob_space. */
SN_MUST_CHECK sn_status sn_polylines_read(const char *path, sn_fibers *out, sn_space *space, sn_error *error);
SN_MUST_CHECK sn_status sn_polylines_parse(const sn_blob *blob, sn_fibers *out, sn_error *error);
/* Is it a file of fibres by its first words: VTK, or an OBJ file? JSON may be one. (lib/io/polylines.c) */
bool sn_polylines_detect(const sn_blob *blob);

/* ---- the scene document (lib/io/scene_document.c) -------------------------------------------------------------------------- */

/* Look at the files of the bones, where a run does not read them: one that is not there draws a warning, one that is no file is an error.
 * document: the name of the scene's. */
SN_MUST_CHECK sn_status sn_scene_check_bones(const char *document, const sn_scene *scene, sn_error *error);
/* Is this a scene document, by its "format" member? false for anything else, also for what is malformed (lib/io/detect.c). */
bool sn_scene_detect(const sn_blob *blob);
/* Parse a scene and load the rigs of its enabled muscles; bone meshes only if load_bones. Relative paths are relative to the scene. */
SN_MUST_CHECK sn_status sn_scene_parse(const sn_blob *blob, bool load_bones, sn_scene *out, sn_error *error);
/* The scene with every default filled in, as JSON members of the open object of json. */
void sn_scene_write(const sn_scene *scene, sn_json *json);

/* ---- what error-time measured (lib/io/error_time_document.c) ----------------------------------------------------------------- */

struct sn_error_time; /* sinew/error_time.h */
/* A row per point, tabs between the columns, their names in the first line. */
SN_MUST_CHECK sn_status sn_error_time_write_table(const struct sn_error_time *report, sn_output *output);
/* The JSON report: share/schema/error-time.schema.json. */
SN_MUST_CHECK sn_status sn_error_time_write(const struct sn_error_time *report, sn_output *output, sn_error *error);
/* Blocks for share/plots/error-time.gp, each a quoted title and lines of seconds, total error, solver error: for each family all of its
 * points, its front of total errors, its front of solver errors; then the front of all, and the points that are not claimed. */
SN_MUST_CHECK sn_status sn_error_time_write_chart(const struct sn_error_time *report, sn_output *output, sn_index *family_count,
                                                  sn_error *error);
/* Settings, their points, the floor, and the names of what they were measured on; judged. Free with sn_error_time_free. */
SN_MUST_CHECK sn_status sn_error_time_parse(const sn_blob *blob, struct sn_error_time *out, sn_error *error);

/* ---- landmarks around attachment areas (lib/io/landmarks.c) ---------------------------------------------------------------- */

typedef struct sn_landmarks {
    sn_index count;
    sn_landmark_area *areas; /* (count) in the order of the file, in the file's unit */
    double meters_per_unit;  /* 0 = the file does not say */
    sn_space space;          /* as sn_blob_space */
} sn_landmarks;
/* JSON: { "areas": [ { "bone", "name", "landmarks": [[x,y,z], ...] }, ... ] }, optionally "metersPerUnit"; or lines of bone, area, x, y, z
 * with tabs between them: lines with the same bone and area make one area. Errors name line or member. */
SN_MUST_CHECK sn_status sn_landmarks_read(const char *path, sn_landmarks *out, sn_error *error);
void sn_landmarks_free(sn_landmarks *landmarks);

/* ---- outputs that a run goes on with (lib/io/resume.c) ------------------------------------------------------------------------ */

/* The state that a run goes on from, and what the outputs that it goes on with came to. */
typedef struct sn_resume {
    sn_index frame; /* that the state has reached, or is in the middle of */
    sn_index next;  /* the first one that will be written: the one after, or `frame` where the state is in the middle of it */
    double rate;    /* frames a second */
    /* out: */
    sn_index continued; /* how many outputs are gone on with */
    sn_index first;     /* the frame that they begin with */
    sn_index reached;   /* the last frame that one of them holds */
    char name[128];     /* of the first of them, for messages */
} sn_resume;

/* Is there an output that could be gone on with: a regular file that is not empty? */
bool sn_resume_exists(const char *path);
/* An output at path holds the frames `first` to `last`. *goes_on: false = it begins with the first one that will be written, or has none:
 * it is to be written anew. SN_ERROR_USAGE: it is not the earlier part of this run. */
SN_MUST_CHECK sn_status sn_resume_take(sn_resume *resume, const char *path, int64_t first, int64_t last, bool *goes_on, sn_error *error);
/* SN_ERROR_USAGE: what an output at path holds for the state's frame is not what the state says. */
sn_status sn_resume_differs(const sn_resume *resume, const char *path, sn_error *error);

/* ---- frames (lib/io/frames_pc2.c) -------------------------------------------------------------------------------------------- */

typedef struct sn_pc2 sn_pc2;
/* A PC2 point cache: float32 positions of point_count points per sample. The count of samples is patched in at the end, and by publish. */
SN_MUST_CHECK sn_status sn_pc2_create(const char *path, sn_index point_count, double start_frame, double sample_rate, sn_pc2 **out,
                                      sn_error *error);
SN_MUST_CHECK sn_status sn_pc2_append(sn_pc2 *cache, const sn_vec3 *positions, sn_error *error);
/* The samples until now are a cache at path, whatever happens from here on: its header never counts more than it holds. */
SN_MUST_CHECK sn_status sn_pc2_publish(sn_pc2 *cache, sn_error *error);
/* Go on with a cache of one sample a frame. positions (point_count): those of the state, which the cache must have for its frame. *out
 * NULL: there is none to go on with (sn_resume_exists, sn_resume_take). Nothing changes before the first append. */
SN_MUST_CHECK sn_status sn_pc2_resume(const char *path, sn_index point_count, sn_resume *resume, const sn_vec3 *positions, sn_pc2 **out,
                                      sn_error *error);
SN_MUST_CHECK sn_status sn_pc2_commit(sn_pc2 *cache, sn_error *error); /* frees cache */
void sn_pc2_abort(sn_pc2 *cache);                                      /* frees cache; NULL is fine */

typedef struct sn_pc2_data {
    sn_index point_count, sample_count;
    double start_frame, sample_rate;
    float *positions; /* (sample_count x point_count x 3) */
} sn_pc2_data;
/* Of a file that was cut short the whole samples that are there, with a warning in the log; at least one. */
SN_MUST_CHECK sn_status sn_pc2_read(const char *path, sn_pc2_data *out, sn_error *error);
void sn_pc2_free(sn_pc2_data *data);

/* ---- weights of an embedding, kept in a binary file beside a document (lib/io/embedding_file.c) -------------------------------- */

/* hash: sn_embedding_hash of what the weights were made from. */
SN_MUST_CHECK sn_status sn_embedding_save(const sn_embedding *embedding, const char *hash, sn_output *output, sn_error *error);
/* SN_ERROR_INPUT where the file is damaged or was made for something else: make the weights anew then. */
SN_MUST_CHECK sn_status sn_embedding_load(const sn_blob *blob, const char *hash, sn_embedding *out, sn_error *error);

/* ---- distance fields, kept in binary files (lib/io/distance_field_file.c distance_field_cache.c) -------------------------------- */

/* hash: sn_distance_field_hash of what the field was built from. */
SN_MUST_CHECK sn_status sn_distance_field_save(const sn_distance_field *field, const char *hash, sn_output *output, sn_error *error);
/* What sn_distance_field_is_valid holds of; its report is that of the build. SN_ERROR_INPUT where the file is damaged or was made for
 * something else: build it anew then. */
SN_MUST_CHECK sn_status sn_distance_field_load(const sn_blob *blob, const char *hash, sn_distance_field *out, sn_error *error);
/* sn_distance_field_create, or the same from FOLDER/HASH.field where a run before left it there (*was_read). The folder is made where it is
 * missing (its last part), and fields are written by renaming. A file that is damaged is made anew, one that cannot be written is not kept,
 * each with a warning in the log. folder NULL = just build. */
SN_MUST_CHECK sn_status sn_distance_field_cached(const char *folder, const sn_mesh *mesh, const sn_distance_field_params *params,
                                                 sn_distance_field *out, bool *was_read, sn_error *error);

/* ---- fibres through the volume ------------------------------------------------------------------------------------------------- */

/* Polylines as lines (lib/io/lines.c): VTP carries length and pennation of each, in the document's unit and radians. */
typedef enum sn_lines_format { SN_LINES_UNKNOWN, SN_LINES_VTP, SN_LINES_OBJ } sn_lines_format;
sn_lines_format sn_lines_format_from_name(const char *path); /* .vtp, .obj */
SN_MUST_CHECK sn_status sn_lines_write(const sn_fibers *fibers, sn_lines_format format, sn_output *output, sn_error *error);

/* Lines that move (lib/io/frames_vtp.c): PREFIX.0000.vtp, numbered by frame, with `length` and `stretch` (over the rest length) of each
 * line; and PREFIX.pvd, a collection with the time of each. A frame's file appears whole with its append, and so does the collection.
 * start (line_count + 1): line i has the points start[i] .. start[i + 1] - 1; it and rest_lengths (line_count) are copied. */
typedef struct sn_line_frames sn_line_frames;
SN_MUST_CHECK sn_status sn_line_frames_create(const char *prefix, sn_index line_count, const sn_index *start, const double *rest_lengths,
                                              sn_line_frames **out, sn_error *error);
SN_MUST_CHECK sn_status sn_line_frames_append(sn_line_frames *frames, sn_index frame, double time, const sn_vec3 *points,
                                              const double *lengths, sn_error *error);
/* Go on with the collection that is there, before anything is appended; *goes_on: there was one. */
SN_MUST_CHECK sn_status sn_line_frames_resume(sn_line_frames *frames, sn_resume *resume, bool *goes_on, sn_error *error);
SN_MUST_CHECK sn_status sn_line_frames_commit(sn_line_frames *frames, sn_error *error); /* frees frames */
void sn_line_frames_abort(sn_line_frames *frames);                                      /* frees frames; NULL is fine */

/* Meshes that move (lib/io/frames_mesh.c): PREFIX.0000.vtp, numbered by frame, attributes as point data, labels as strings of field data;
 * and PREFIX.pvd, a collection with the time of each, s. A frame's file appears whole with its append, and so does the collection. */
typedef struct sn_mesh_frames sn_mesh_frames;
SN_MUST_CHECK sn_status sn_mesh_frames_create(const char *prefix, sn_mesh_frames **out, sn_error *error);
SN_MUST_CHECK sn_status sn_mesh_frames_append(sn_mesh_frames *frames, sn_index frame, double time, const sn_mesh *mesh, sn_error *error);
/* Go on with the collection that is there, before anything is appended; *goes_on: there was one. */
SN_MUST_CHECK sn_status sn_mesh_frames_resume(sn_mesh_frames *frames, sn_resume *resume, bool *goes_on, sn_error *error);
SN_MUST_CHECK sn_status sn_mesh_frames_commit(sn_mesh_frames *frames, sn_error *error); /* frees frames */
void sn_mesh_frames_abort(sn_mesh_frames *frames);                                      /* frees frames; NULL is fine */

/* ---- motions as they were recorded (lib/io/clip_formats.c and one file per format) -------------------------------------------- */

/* What position channels of a BVH are to the joint's OFFSET. AUTO: whatever moves the joint less in the first frame. */
typedef enum sn_clip_positions { SN_POSITIONS_AUTO, SN_POSITIONS_ADD, SN_POSITIONS_REPLACE } sn_clip_positions;
typedef struct sn_clip_options {
    double meters_per_unit; /* 0 = what the file or its format says: BVH centimetres; AMC inches over the skeleton's `length` */
    sn_up up;               /* SN_UP_UNKNOWN = what the format says: BVH and AMC y */
    double rate;            /* 0 = what the file says; AMC, which says nothing, 120 Hz */
    const char *animation;  /* of glTF, FBX and Collada: name or number from 1; NULL = the first, with a warning where there are more */
    sn_clip_positions positions;        /* BVH alone */
    const struct sn_bone_search *bones; /* sinew/model_files.h; nullable: find the meshes that show a model's bodies too */
} sn_clip_options;

/* Which of the motion formats this is ("BVH", "AMC", ...), from content alone; NULL = none. */
const char *sn_clip_detect(const sn_blob *blob);
/* Parse a motion file of any known format into a valid clip in metres, z up. skeleton: the file that tells the joints where the motion
 * does not (AMC); else NULL. Errors name file and line. */
SN_MUST_CHECK sn_status sn_clip_parse(const sn_blob *motion, const sn_blob *skeleton, const sn_clip_options *options, sn_clip *out,
                                      sn_error *error);

/* A motion document (lib/io/motion_document.c), in metres. A key at frame / rate tells its frame, any other its time. */
typedef struct sn_motion_head {
    const char *name;              /* nullable */
    const char *path;              /* where it will be: bones' meshes are named from there; nullable, "-" = standard output */
    double rate;                   /* frames a second */
    const sn_history_entry *entry; /* nullable; behind those of history_from */
    const sn_blob *history_from;   /* nullable: the motion document that this one was made from */
} sn_motion_head;
SN_MUST_CHECK sn_status sn_motion_document_write(const sn_motion *motion, const sn_motion_head *head, sn_output *output, sn_error *error);
/* Is this a motion document, by its "format" member? (lib/io/detect.c) */
bool sn_motion_document_detect(const sn_blob *blob);
/* Read one as it stands: hinges, keys, coordinates, and bones with paths from the working directory; valid. *name (owned by the caller) is
 * NULL where it has none; *rate is 24 where it tells none. Errors name file, line and column. */
SN_MUST_CHECK sn_status sn_motion_document_parse(const sn_blob *blob, sn_motion *out, char **name, double *rate, sn_error *error);
/* The surface of a motion's bone, z up and valid, in the unit and space of *frame; the unit is the bone's, else what the file says, else
 * `fallback`. Errors name bone and file (lib/io/bone_document.c). */
SN_MUST_CHECK sn_status sn_motion_bone_load(const sn_motion_bone *bone, double fallback, sn_mesh *out, sn_mesh_frame *frame,
                                            sn_error *error);

/* An envelope document (lib/io/envelope_document.c): share/schema/envelope.schema.json. */
bool sn_envelope_detect(const sn_blob *blob); /* by its "format" member; false for anything else, also for what is malformed */
/* Valid, in metres. Errors name file, line and member. */
SN_MUST_CHECK sn_status sn_envelope_parse(const sn_blob *blob, sn_envelope *out, sn_error *error);
/* In metres. entry (nullable) goes behind the history of history_from (nullable), a JSON document that this one was made from. */
SN_MUST_CHECK sn_status sn_envelope_write(const sn_envelope *envelope, const sn_history_entry *entry, const sn_blob *history_from,
                                          sn_output *output, sn_error *error);

/* The table that binds a motion to a body (lib/io/fit_table.c; its rows: motion-fit(1)), linked, in metres. Errors name file and line. */
SN_MUST_CHECK sn_status sn_fit_table_parse(const sn_blob *blob, sn_fit_table *out, sn_error *error);

/* Numbers over time (lib/io/table.c): a row of names, then rows of numbers, with tabs between them; a path that ends in .sto or .mot gets
 * OpenSim's storage header before them. Smoothing is [K21] 4.4's: `rounds` times x'_i = (x_{i-1} + 4 x_i + x_{i+1}) / 6 over the rows;
 * the first and the last row keep their values. Nothing is seen at path before commit or publish. */
typedef struct sn_table_params {
    const char *title;        /* first line of a storage file */
    int64_t rows;             /* that will be appended, at most: a storage file's header tells how many there are */
    sn_index columns;         /* at least 1 */
    const char *const *names; /* (columns) white space in them becomes '_' */
    sn_index smoothed_from;   /* columns before this stay as they are */
    int rounds;               /* 0 = no smoothing */
    /* to go on with the table that is there, its first column a frame's time, not smoothed; rows are those behind it */
    sn_resume *resume;    /* nullable */
    const double *at_row; /* (columns) of the state's frame, which the table must have */
} sn_table_params;
typedef struct sn_table sn_table;
SN_MUST_CHECK sn_status sn_table_create(const char *path, const sn_table_params *params, sn_table **out, sn_error *error);
SN_MUST_CHECK sn_status sn_table_append(sn_table *table, const double *row, sn_error *error); /* row (columns) */
/* The rows until now are a table at path, whatever happens from here on. */
SN_MUST_CHECK sn_status sn_table_publish(sn_table *table, sn_error *error);
SN_MUST_CHECK sn_status sn_table_commit(sn_table *table, sn_error *error); /* frees table */
void sn_table_abort(sn_table *table);                                      /* frees table; NULL is fine */

/* ---- sensors and the activations that they give ------------------------------------------------------------------------------------- */

typedef struct sn_muscle_names {
    sn_index count;
    char **names; /* (count) owned */
} sn_muscle_names;
/* The muscles' names of a scene document, or one a line (# begins a comment); at least one. */
SN_MUST_CHECK sn_status sn_muscle_names_parse(const sn_blob *blob, sn_muscle_names *out, sn_error *error);
void sn_muscle_names_free(sn_muscle_names *list); /* leaves all zeros */

/* A sensors document (lib/io/sensors_document.c; share/schema/sensors.schema.json), sides and patterns written out: patterns match
 * `muscles`, else (NULL) the document's own list. Warnings in the log: sensors that no channel takes, muscles without a channel, names and
 * patterns that are no muscle's. */
SN_MUST_CHECK sn_status sn_sensors_parse(const sn_blob *blob, const sn_muscle_names *muscles, sn_sensors *out, sn_error *error);
/* An activation document (lib/io/activation_document.c; share/schema/activation.schema.json): a scene takes a channel of it by {"uri",
 * "channel"}. entry is nullable. */
SN_MUST_CHECK sn_status sn_activation_document_write(const sn_sensors *sensors, const sn_sense *sense, const sn_history_entry *entry,
                                                     sn_output *output, sn_error *error);
/* The names of the channels of an activation document, in its order. */
SN_MUST_CHECK sn_status sn_activation_names_parse(const sn_blob *blob, sn_muscle_names *out, sn_error *error);

/* A fibre template (lib/io/fill_document.c): {"format": "sinew-fiber-template", "version": 1, "curves": [{"points": [x,y,z, ...]}, ...]},
 * the control points of Bezier curves; they become out->polylines. */
SN_MUST_CHECK sn_status sn_fiber_template_parse(const sn_blob *blob, sn_fibers *out, sn_error *error);

/* Vertices where fibres begin and end: {"format": "sinew-fiber-ends", "version": 1, "origin": [vertex, ...], "insertion": [...]}, or fibres
 * as sn_polylines_read takes them: the vertices that are nearest to where these begin (origin) and end (insertion), each once, ascending.
 */
typedef struct sn_fiber_ends {
    sn_index origin_count, insertion_count;
    sn_index *origin, *insertion;
} sn_fiber_ends;
SN_MUST_CHECK sn_status sn_fiber_ends_parse(const sn_blob *blob, const sn_mesh *mesh, sn_fiber_ends *out, sn_error *error);
void sn_fiber_ends_free(sn_fiber_ends *ends);

#endif
