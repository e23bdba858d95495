/* collection.c -- a PVD collection: which file of a sequence belongs to which time. */
#include "collection.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SUFFIX = 32 }; /* room for ".0000.vtp" of any frame, or ".pvd" */

sn_status sn_collection_open(sn_collection *collection, const char *prefix, sn_error *error) {
    size_t size = strlen(prefix) + SUFFIX;
    *collection = (sn_collection){.prefix = sn_strdup(prefix), .path = sn_alloc(size, 1), .path_size = size};
    if (collection->prefix == NULL || collection->path == NULL) return sn_fail_memory(error, "a collection of frames");
    snprintf(collection->path, size, "%s.pvd", prefix);
    sn_status status = sn_output_open(collection->path, false, &collection->output, error);
    if (status != SN_OK) return status;
    sn_output_print(collection->output, "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" "
                                        "byte_order=\"LittleEndian\">\n<Collection>\n");
    return SN_OK;
}

const char *sn_collection_frame(sn_collection *collection, sn_index frame) {
    snprintf(collection->path, collection->path_size, "%s.%04d.vtp", collection->prefix, (int)frame);
    return collection->path;
}

/* A file name as an attribute of XML. */
static void write_escaped(sn_output *output, const char *text) {
    for (; *text != '\0'; text++) {
        const char *entity = *text == '&' ? "&amp;" : *text == '<' ? "&lt;" : *text == '>' ? "&gt;" : *text == '"' ? "&quot;" : NULL;
        sn_output_write(output, entity != NULL ? entity : text, entity != NULL ? strlen(entity) : 1, NULL);
    }
}

void sn_collection_list(sn_collection *collection, double time) {
    char number[40];
    const char *slash = strrchr(collection->path, '/');
    sn_format_number(time, number);
    sn_output_print(collection->output, "<DataSet timestep=\"%s\" part=\"0\" file=\"", number);
    write_escaped(collection->output, slash != NULL ? slash + 1 : collection->path);
    sn_output_print(collection->output, "\"/>\n");
}

sn_status sn_collection_close(sn_collection *collection, sn_error *error) {
    sn_output_print(collection->output, "</Collection>\n</VTKFile>\n");
    sn_status status = sn_output_commit(collection->output, error);
    collection->output = NULL;
    sn_collection_drop(collection);
    return status;
}

void sn_collection_drop(sn_collection *collection) {
    sn_output_abort(collection->output);
    free(collection->prefix);
    free(collection->path);
    *collection = (sn_collection){0};
}
