/* lines.c -- fibres as polylines: VTP PolyData for ParaView and VTK, with length and pennation for each line, and OBJ lines. */
#include <string.h>

#include "sinew/io.h"

static bool ends_with(const char *text, const char *ending) {
    size_t length = strlen(text), tail = strlen(ending);
    return length > tail && strcasecmp(text + length - tail, ending) == 0;
}

sn_lines_format sn_lines_format_from_name(const char *path) {
    if (path == NULL) return SN_LINES_UNKNOWN;
    return ends_with(path, ".vtp") ? SN_LINES_VTP : ends_with(path, ".obj") ? SN_LINES_OBJ : SN_LINES_UNKNOWN;
}

static void write_number(sn_output *output, double value, char after) {
    char text[40];
    int length = sn_format_number(value, text);
    text[length] = after;
    (void)sn_output_write(output, text, (size_t)length + 1, NULL);
}

static void write_point(sn_output *output, sn_vec3 p) {
    write_number(output, p.x, ' ');
    write_number(output, p.y, ' ');
    write_number(output, p.z, '\n');
}

static void write_points(sn_output *output, const sn_fibers *fibers, const char *before) {
    for (sn_index i = 0; i < fibers->polyline_count; i++)
        for (sn_index k = 0; k < fibers->polylines[i].count; k++) {
            (void)sn_output_write(output, before, strlen(before), NULL);
            write_point(output, fibers->polylines[i].points[k]);
        }
}

static int64_t count_points(const sn_fibers *fibers) {
    int64_t count = 0;
    for (sn_index i = 0; i < fibers->polyline_count; i++) count += fibers->polylines[i].count;
    return count;
}

/* ---- OBJ ---------------------------------------------------------------------------------------------------------------------- */

static void write_obj(sn_output *output, const sn_fibers *fibers) {
    int64_t next = 1;
    write_points(output, fibers, "v ");
    for (sn_index i = 0; i < fibers->polyline_count; i++) {
        sn_output_print(output, "l");
        for (sn_index k = 0; k < fibers->polylines[i].count; k++) sn_output_print(output, " %lld", (long long)next++);
        sn_output_print(output, "\n");
    }
}

/* ---- VTP ---------------------------------------------------------------------------------------------------------------------- */

static void open_array(sn_output *output, const char *type, const char *name, int components) {
    sn_output_print(output, "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"ascii\">\n", type, name, components);
}

static void close_array(sn_output *output) { sn_output_print(output, "</DataArray>\n"); }

static void write_measures(sn_output *output, const sn_fibers *fibers) {
    sn_output_print(output, "<CellData>\n");
    open_array(output, "Float64", "length", 1);
    for (sn_index i = 0; i < fibers->polyline_count; i++) write_number(output, fibers->polylines[i].length, '\n');
    close_array(output);
    open_array(output, "Float64", "pennation", 1);
    for (sn_index i = 0; i < fibers->polyline_count; i++) write_number(output, fibers->polylines[i].pennation, '\n');
    close_array(output);
    sn_output_print(output, "</CellData>\n");
}

static void write_lines(sn_output *output, const sn_fibers *fibers, int64_t points) {
    sn_output_print(output, "<Lines>\n");
    open_array(output, "Int64", "connectivity", 1);
    for (int64_t k = 0; k < points; k++) sn_output_print(output, "%lld\n", (long long)k);
    close_array(output);
    open_array(output, "Int64", "offsets", 1);
    int64_t end = 0;
    for (sn_index i = 0; i < fibers->polyline_count; i++) sn_output_print(output, "%lld\n", (long long)(end += fibers->polylines[i].count));
    close_array(output);
    sn_output_print(output, "</Lines>\n");
}

static void write_vtp(sn_output *output, const sn_fibers *fibers) {
    int64_t points = count_points(fibers);
    sn_output_print(output, "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
                            "header_type=\"UInt64\">\n<PolyData>\n");
    sn_output_print(output,
                    "<Piece NumberOfPoints=\"%lld\" NumberOfVerts=\"0\" NumberOfLines=\"%d\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n",
                    (long long)points, fibers->polyline_count);
    sn_output_print(output, "<Points>\n");
    open_array(output, "Float64", "Points", 3);
    write_points(output, fibers, "");
    close_array(output);
    sn_output_print(output, "</Points>\n");
    write_lines(output, fibers, points);
    write_measures(output, fibers);
    sn_output_print(output, "</Piece>\n</PolyData>\n</VTKFile>\n");
}

sn_status sn_lines_write(const sn_fibers *fibers, sn_lines_format format, sn_output *output, sn_error *error) {
    if (format == SN_LINES_VTP)
        write_vtp(output, fibers);
    else if (format == SN_LINES_OBJ)
        write_obj(output, fibers);
    else
        return sn_fail(error, SN_ERROR_USAGE, "lines can be written as .vtp or .obj");
    return SN_OK; /* a failed write is kept by the output and comes out of its commit */
}
