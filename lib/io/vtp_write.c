/*
 * vtp_write.c -- VTK XML PolyData as ParaView and VTK read it: one piece, attributes as point data, double precision.
 *
 * The same mesh gives the same bytes. Numbers are text, or raw bytes appended behind the elements (64-bit sizes, both byte orders).
 */
#include "mesh_reader.h"
#include "scalar.h"

#include <stdlib.h>
#include <string.h>

/* One array: its number i is value(source, i). */
typedef struct column {
    const char *name;
    sn_scalar type;
    size_t components, count;
    double (*value)(const void *source, size_t i);
    const void *source;
} column;

typedef struct vtp_output {
    sn_output *output;
    sn_mesh_encoding encoding;
    column *columns; /* (column_count) points, connectivity, offsets, then the attributes */
    size_t column_count;
    uint64_t offset; /* of the next array among the appended data */
} vtp_output;

enum { POINTS, CONNECTIVITY, OFFSETS, ATTRIBUTES };

/* ---- the columns ---------------------------------------------------------------------------------------------------- */

static double coordinate_of(const void *mesh, size_t i) {
    sn_vec3 p = ((const sn_mesh *)mesh)->positions[i / 3];
    return i % 3 == 0 ? p.x : i % 3 == 1 ? p.y : p.z;
}

static double corner_of(const void *mesh, size_t i) { return (double)((const sn_mesh *)mesh)->triangles[i / 3].v[i % 3]; }

static double end_of(const void *mesh, size_t i) {
    (void)mesh;
    return 3.0 * (double)(i + 1);
}

static double attribute_of(const void *attribute, size_t i) { return ((const sn_attribute *)attribute)->values[i]; }

static bool make_columns(vtp_output *vtp, const sn_mesh *mesh, sn_name_list *names) {
    size_t vertices = (size_t)mesh->vertex_count, triangles = (size_t)mesh->triangle_count;
    sn_scalar end_type = 3.0 * (double)triangles > SN_INDEX_MAX ? SN_INT64 : SN_INT32;
    vtp->column_count = ATTRIBUTES + (size_t)mesh->attribute_count;
    vtp->columns = SN_NEW(column, vtp->column_count);
    if (vtp->columns == NULL) return false;
    vtp->columns[POINTS] = (column){"Points", SN_FLOAT64, 3, 3 * vertices, coordinate_of, mesh};
    vtp->columns[CONNECTIVITY] = (column){"connectivity", SN_INT32, 1, 3 * triangles, corner_of, mesh};
    vtp->columns[OFFSETS] = (column){"offsets", end_type, 1, triangles, end_of, mesh};
    for (size_t i = 0; i < (size_t)mesh->attribute_count; i++) {
        const sn_attribute *attribute = &mesh->attributes[i];
        size_t components = (size_t)attribute->components;
        if (!sn_name_list_add(names, attribute->name, true)) return false;
        sn_scalar type = sn_scalar_of_attribute(attribute, mesh->vertex_count);
        vtp->columns[ATTRIBUTES + i] = (column){names->items[i], type, components, components * vertices, attribute_of, attribute};
    }
    return true;
}

/* ---- elements ------------------------------------------------------------------------------------------------------- */

static void write_escaped(sn_output *output, const char *text) {
    for (; *text != '\0'; text++) {
        const char *entity = *text == '&' ? "&amp;" : *text == '<' ? "&lt;" : *text == '>' ? "&gt;" : *text == '"' ? "&quot;" : NULL;
        sn_output_write(output, entity != NULL ? entity : text, entity != NULL ? strlen(entity) : 1, NULL);
    }
}

static const char *type_name(sn_scalar type) {
    return type == SN_UINT8 ? "UInt8" : type == SN_INT32 ? "Int32" : type == SN_INT64 ? "Int64" : "Float64";
}

static void write_text_values(const vtp_output *vtp, const column *c) {
    for (size_t i = 0; i < c->count; i++) sn_write_number(vtp->output, i % c->components == 0 ? '\n' : ' ', c->value(c->source, i));
    sn_output_print(vtp->output, "\n");
}

static void write_array(vtp_output *vtp, const column *c) {
    sn_output_print(vtp->output, "        <DataArray type=\"%s\" Name=\"", type_name(c->type));
    write_escaped(vtp->output, c->name);
    sn_output_print(vtp->output, "\" NumberOfComponents=\"%zu\" ", c->components);
    if (vtp->encoding == SN_ENCODING_ASCII) {
        sn_output_print(vtp->output, "format=\"ascii\">");
        write_text_values(vtp, c);
        sn_output_print(vtp->output, "        </DataArray>\n");
        return;
    }
    sn_output_print(vtp->output, "format=\"appended\" offset=\"%llu\"/>\n", (unsigned long long)vtp->offset);
    vtp->offset += 8 + c->count * sn_scalar_size(c->type);
}

/* What the values of an attribute stand for, as strings of field data: the codes of their characters, each ended by 0. */
static void write_labels(sn_output *output, const sn_attribute *attribute, const char *name) {
    sn_output_print(output, "      <Array type=\"String\" Name=\"");
    write_escaped(output, name);
    sn_output_print(output, "_names\" NumberOfTuples=\"%d\" format=\"ascii\">\n", (int)attribute->label_count);
    for (sn_index i = 0; i < attribute->label_count; i++) {
        for (const char *at = attribute->labels[i]; *at != '\0'; at++) sn_output_print(output, "%d ", (int)(unsigned char)*at);
        sn_output_print(output, "0\n");
    }
    sn_output_print(output, "      </Array>\n");
}

static void write_field_data(const sn_mesh *mesh, const sn_name_list *names, sn_output *output) {
    bool labelled = false;
    for (sn_index i = 0; i < mesh->attribute_count; i++) labelled = labelled || mesh->attributes[i].label_count > 0;
    if (!labelled) return;
    sn_output_print(output, "    <FieldData>\n");
    for (sn_index i = 0; i < mesh->attribute_count; i++) {
        if (mesh->attributes[i].label_count > 0) write_labels(output, &mesh->attributes[i], names->items[i]);
    }
    sn_output_print(output, "    </FieldData>\n");
}

static void write_piece(vtp_output *vtp, const sn_mesh *mesh) {
    sn_output *output = vtp->output;
    sn_output_print(output,
                    "    <Piece NumberOfPoints=\"%d\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"%d\">\n",
                    (int)mesh->vertex_count, (int)mesh->triangle_count);
    sn_output_print(output, "      <PointData>\n");
    for (size_t i = ATTRIBUTES; i < vtp->column_count; i++) write_array(vtp, &vtp->columns[i]);
    sn_output_print(output, "      </PointData>\n      <Points>\n");
    write_array(vtp, &vtp->columns[POINTS]);
    sn_output_print(output, "      </Points>\n      <Polys>\n");
    write_array(vtp, &vtp->columns[CONNECTIVITY]);
    write_array(vtp, &vtp->columns[OFFSETS]);
    sn_output_print(output, "      </Polys>\n    </Piece>\n  </PolyData>\n");
}

static void write_bytes(const vtp_output *vtp, const column *c) {
    bool big = vtp->encoding == SN_ENCODING_BIG;
    unsigned char bytes[8];
    size_t width = sn_scalar_size(c->type);
    sn_scalar_encode((double)(c->count * width), SN_INT64, big, bytes);
    sn_output_write(vtp->output, bytes, 8, NULL);
    for (size_t i = 0; i < c->count; i++) {
        sn_scalar_encode(c->value(c->source, i), c->type, big, bytes);
        sn_output_write(vtp->output, bytes, width, NULL);
    }
}

/* In the order in which write_piece has given offsets. */
static void write_appended(const vtp_output *vtp) {
    sn_output_print(vtp->output, "  <AppendedData encoding=\"raw\">\n_");
    for (size_t i = ATTRIBUTES; i < vtp->column_count; i++) write_bytes(vtp, &vtp->columns[i]);
    for (size_t i = POINTS; i < ATTRIBUTES; i++) write_bytes(vtp, &vtp->columns[i]);
    sn_output_print(vtp->output, "\n  </AppendedData>\n");
}

sn_status sn_vtp_write(const sn_mesh *mesh, sn_mesh_encoding encoding, sn_output *output, sn_error *error) {
    vtp_output vtp = {.output = output, .encoding = encoding};
    sn_name_list names = {0};
    bool good = make_columns(&vtp, mesh, &names);
    if (good) {
        sn_output_print(output,
                        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"%s\" header_type=\"UInt64\">\n",
                        encoding == SN_ENCODING_BIG ? "BigEndian" : "LittleEndian");
        sn_output_print(output, "  <PolyData>\n");
        write_field_data(mesh, &names, output);
        write_piece(&vtp, mesh);
        if (encoding != SN_ENCODING_ASCII) write_appended(&vtp);
        sn_output_print(output, "</VTKFile>\n");
    }
    free(vtp.columns);
    sn_name_list_free(&names);
    return good ? SN_OK : sn_fail_memory(error, "the arrays of a VTP file");
}
