/*
 * mesh_reader.h -- what the mesh formats share: a cursor over the file, a mesh that grows, errors that name the place.
 *
 * Our own readers because order, precision and bad files matter: libraries that read these formats reorder vertices, round to float, or
 * crash.
 */
#ifndef SN_IO_MESH_READER_H
#define SN_IO_MESH_READER_H

#include "sinew/io.h"

/* A piece of the file's text. */
typedef struct sn_span {
    const char *text;
    size_t length;
} sn_span;
bool sn_span_is(sn_span span, const char *text);
bool sn_span_is_like(sn_span span, const char *text); /* upper or lower case */
static inline bool sn_is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
sn_span sn_span_trim(sn_span span); /* without blanks around it */
/* SN_ERROR_INPUT at a line of a text; what is quoted of it stands on one line. */
sn_status sn_text_complain(sn_error *error, const sn_blob *blob, int64_t line, const char *format, va_list arguments) SN_PRINTF(4, 0);

/* Finds equal things among numbered ones: open addressing over their indices. All zeros is an empty table. */
typedef struct sn_index_table {
    sn_index *slots;
    size_t size; /* a power of two */
    size_t count;
} sn_index_table;
typedef uint64_t (*sn_hash_function)(const void *things, sn_index i);
typedef bool (*sn_equal_function)(const void *things, sn_index i, sn_index j);
/* The entry equal to candidate, or candidate, which then is in the table; SN_NONE = out of memory. */
sn_index sn_index_table_intern(sn_index_table *table, sn_index candidate, const void *things, sn_hash_function hash,
                               sn_equal_function equal);
uint64_t sn_hash_bytes(const void *data, size_t size);

/* A face of more than three corners: its fan's triangles, to be cut anew at the end where the polygon is not convex. */
typedef struct sn_polygon {
    sn_index first_triangle, corner_count;
} sn_polygon;

/* Lines as numbers of vertices, one behind the other. */
typedef struct sn_line_set {
    sn_index line_count, *starts; /* (line_count + 1) of each line among the corners */
    sn_index corner_count, *corners;
    size_t start_capacity, corner_capacity;
    sn_index thin; /* lines of fewer than two vertices, left out */
} sn_line_set;

typedef struct sn_reader {
    const sn_blob *blob;
    sn_error *error;
    bool allow_nonfinite;

    /* the cursor */
    const char *at, *end;
    int64_t line;   /* line of `at`, from 1; 0 in binary data, whose places are byte offsets */
    bool continues; /* a backslash at the end of a line joins the next one (OBJ) */
    bool commas;    /* a comma is a blank (sites) */

    /* the mesh so far; its counts are true, its arrays have room for the capacities */
    sn_mesh mesh;
    size_t vertex_capacity, triangle_capacity, group_capacity, triangle_group_capacity;
    sn_index_table group_table;
    sn_polygon *polygons;
    size_t polygon_count, polygon_capacity;
    sn_index *corners; /* of the face being read */
    size_t corner_count, corner_capacity;
    double *colours; /* (colour_count x 4): up to the last vertex that has a colour */
    size_t colour_count, colour_capacity;
    bool has_alpha;

    /* indices may point forward in a file: the largest is checked at the end */
    int64_t first_index; /* what the file calls the first vertex */
    int64_t highest_corner, highest_place;
    int64_t thin_faces; /* faces of fewer than three corners, left out */

    sn_line_set *lines; /* where lines go; NULL = they are passed over, and so are data of points where they are not */
} sn_reader;

/* ---- places and errors ---------------------------------------------------------------------------------------------- */

/* SN_ERROR_INPUT at the cursor's line, or at its byte offset in binary data; element as in sn_error, SN_NONE = none. */
sn_status sn_reader_fail(const sn_reader *reader, sn_index element, const char *format, ...) SN_PRINTF(3, 4);
/* The next word for a message, quoted, or "the end of the line"; room for 48 bytes. */
const char *sn_reader_found(sn_reader *reader, char *buffer);

/* ---- text ----------------------------------------------------------------------------------------------------------- */

/* A cursor at the start of a text, behind a byte order mark. */
sn_reader sn_reader_of(const sn_blob *blob, sn_error *error);
/* May a number or a word end here? '#' begins a comment only where a token begins: in "1.#QNAN" it is part of one. */
bool sn_reader_ends_token(const sn_reader *reader, const char *at);
/* Behind the current line, however it ends; false at the end of the file. */
bool sn_reader_next_line(sn_reader *reader);
/* To the first line from here on that holds more than blanks and comments; false = none. */
bool sn_reader_find_line(sn_reader *reader);
/* Nothing but blanks or a comment is left on the line. */
bool sn_reader_at_line_end(sn_reader *reader);
sn_span sn_reader_word(sn_reader *reader); /* empty at the end of the line */
sn_span sn_reader_rest(sn_reader *reader); /* of the line, without blanks around it; the cursor goes to its end */
bool sn_reader_number(sn_reader *reader, double *out);
bool sn_reader_integer(sn_reader *reader, int64_t *out);
/* Three numbers, or an error that names what was found. */
SN_MUST_CHECK sn_status sn_reader_position(sn_reader *reader, sn_vec3 *out);

/* ---- binary --------------------------------------------------------------------------------------------------------- */

/* `size` bytes at the cursor, which moves behind them; NULL = the file is too short, the cursor stays. */
static inline const unsigned char *sn_reader_take(sn_reader *reader, size_t size) {
    if ((size_t)(reader->end - reader->at) < size) return NULL;
    const unsigned char *bytes = (const unsigned char *)reader->at;
    reader->at += size;
    return bytes;
}

static inline size_t sn_reader_left(const sn_reader *reader) { return (size_t)(reader->end - reader->at); }

/* Nothing may stand behind what a header counted: in text but for comments, in binary but for zeros and blanks. `what` is what was counted
 * ("faces"). The one place where a count that is too small is refused. */
SN_MUST_CHECK sn_status sn_reader_expect_end(sn_reader *reader, int64_t counted, const char *what);

/* ---- the mesh ------------------------------------------------------------------------------------------------------- */

/* Room for what a header promises; check it against the file's size first. */
SN_MUST_CHECK sn_status sn_reader_reserve(sn_reader *reader, int64_t vertices, int64_t triangles);
/* Add a vertex; an error where a coordinate is not finite, unless that is allowed. */
SN_MUST_CHECK sn_status sn_reader_add_vertex(sn_reader *reader, sn_vec3 position);
/* Give the last vertex a colour: red, green, blue and, where count is 4, alpha. The vertices before it that have none get room. */
SN_MUST_CHECK sn_status sn_reader_add_colour(sn_reader *reader, const double *colour, int count);
/* Add a corner to the face being read, counted from 0. */
SN_MUST_CHECK sn_status sn_reader_add_corner(sn_reader *reader, int64_t vertex);
/* The corners read make a face of this group (SN_NONE = of none). */
SN_MUST_CHECK sn_status sn_reader_add_face(sn_reader *reader, sn_index group);
/* The corners read make a triangle strip: every other triangle is turned over; those of two equal corners are left out. */
SN_MUST_CHECK sn_status sn_reader_add_strip(sn_reader *reader);
/* The corners read make a line. */
SN_MUST_CHECK sn_status sn_reader_add_line(sn_reader *reader);
/* A new attribute of vertex_count rows, for the vertices of a mesh that are known. A name that is taken, or an attribute larger than the
 * file's share of memory, is left out with a warning: then *out is NULL. */
SN_MUST_CHECK sn_status sn_reader_add_attribute(sn_reader *reader, const char *name, int64_t components, bool integer, sn_attribute **out);
/* May `more` bytes be taken beside the file and the mesh so far? 10 times the file and 48 MB are its share: what a packed file unpacks to
 * must not fill the machine. */
bool sn_reader_may_take(const sn_reader *reader, double more);
/* The group of this name, a new one if need be. */
SN_MUST_CHECK sn_status sn_reader_group(sn_reader *reader, sn_span name, sn_index *out);

/* Cut the polygons that are not convex anew, once every vertex is known (polygon.c). */
void sn_reader_cut_polygons(sn_reader *reader);

/* ---- the formats: each fills reader->mesh; mesh_io.c checks and hands it over ----------------------------------------- */

SN_MUST_CHECK sn_status sn_obj_parse(sn_reader *reader);
SN_MUST_CHECK sn_status sn_ply_parse(sn_reader *reader);
SN_MUST_CHECK sn_status sn_stl_parse(sn_reader *reader);
SN_MUST_CHECK sn_status sn_off_parse(sn_reader *reader);
SN_MUST_CHECK sn_status sn_vtk_parse(sn_reader *reader);
SN_MUST_CHECK sn_status sn_vtp_parse(sn_reader *reader);
bool sn_off_keyword(sn_span word);
bool sn_vtk_is(const sn_blob *blob);
bool sn_vtp_is(const sn_blob *blob); /* any VTKFile, also of other data sets, which are refused with a clear word */

/* Writers ignore the status of single writes: the output keeps the first failure, mesh_io.c asks for it. */
void sn_obj_write(const sn_mesh *mesh, sn_output *output);
SN_MUST_CHECK sn_status sn_ply_write(const sn_mesh *mesh, sn_mesh_encoding encoding, sn_output *output, sn_error *error);
void sn_stl_write(const sn_mesh *mesh, sn_mesh_encoding encoding, sn_output *output);
void sn_off_write(const sn_mesh *mesh, sn_output *output);
SN_MUST_CHECK sn_status sn_vtp_write(const sn_mesh *mesh, sn_mesh_encoding encoding, sn_output *output, sn_error *error);

/* " x y z" shortest and exact; separator is what stands before the first, 0 = nothing. */
void sn_write_vec3(sn_output *output, char separator, sn_vec3 value);
void sn_write_number(sn_output *output, char separator, double value);
/* A name as one line of text: control characters and backslashes become '_', blanks too where spaces is false; "" becomes "_". */
void sn_write_name(sn_output *output, const char *name, bool spaces);

/* Names as a file holds them: clean as sn_write_name writes them, UTF-8, no two alike. All zeros is an empty list. */
typedef struct sn_name_list {
    char **items; /* (count), each owned */
    size_t count, capacity;
} sn_name_list;
/* Add name; underscores behind it tell it from those before. false = out of memory. */
bool sn_name_list_add(sn_name_list *list, const char *name, bool spaces);
void sn_name_list_free(sn_name_list *list);

/* red, green, blue of the mesh, if it has all three as single numbers. */
bool sn_mesh_colours(const sn_mesh *mesh, const sn_attribute *channels[3]);

#endif
