/* sites.c -- known sites of a muscle's ends: lines "origin X Y Z" and "insertion X Y Z", or where fibres begin and end. */
#include "json.h"
#include "mesh_reader.h"

#include <stdlib.h>
#include <string.h>

typedef struct site_list {
    size_t capacity;
    sn_index count;
    sn_end_site *sites;
} site_list;

/* One line: a word and three numbers. */
static sn_status read_site(sn_reader *r, site_list *list) {
    sn_span word = sn_reader_word(r);
    bool insertion = sn_span_is(word, "insertion"), good = insertion || sn_span_is(word, "origin");
    double point[3];
    for (int i = 0; i < 3 && good; i++) good = sn_reader_number(r, &point[i]) && isfinite(point[i]);
    if (!good || !sn_reader_at_line_end(r))
        return sn_reader_fail(r, SN_NONE, "a site must be \"origin X Y Z\" or \"insertion X Y Z\", of finite numbers in the muscle's unit");
    if (list->count == SN_INDEX_MAX || !sn_grow((void **)&list->sites, &list->capacity, (size_t)list->count + 1, sizeof *list->sites))
        return sn_fail_memory(r->error, "the sites");
    list->sites[list->count++] = (sn_end_site){sn_v3(point[0], point[1], point[2]), insertion};
    return SN_OK;
}

static sn_status read_lines(sn_reader *r, site_list *list) {
    while (sn_reader_find_line(r)) {
        sn_status status = read_site(r, list);
        if (status != SN_OK) return status;
    }
    if (list->count > 0) return SN_OK;
    return sn_fail_at(r->error, SN_ERROR_INPUT, r->blob->name, 0, "the file holds no site: no line \"origin X Y Z\"");
}

/* ---- fibres ---------------------------------------------------------------------------------------------------------------- */

static bool add_site(site_list *list, sn_vec3 point, bool insertion) {
    if (list->count == SN_INDEX_MAX || !sn_grow((void **)&list->sites, &list->capacity, (size_t)list->count + 1, sizeof *list->sites))
        return false;
    list->sites[list->count++] = (sn_end_site){point, insertion};
    return true;
}

static sn_status take_ends(const sn_blob *blob, site_list *list, sn_error *error) {
    sn_fibers fibers;
    sn_status status = sn_polylines_parse(blob, &fibers, error);
    for (sn_index i = 0; i < fibers.polyline_count && status == SN_OK; i++) {
        const sn_polyline *line = &fibers.polylines[i];
        bool enough = add_site(list, line->points[0], false) && add_site(list, line->points[line->count - 1], true);
        if (!enough) status = sn_fail_memory(error, "the sites");
    }
    sn_fibers_free(&fibers);
    return status;
}

sn_status sn_sites_read(const char *path, sn_index *count, sn_end_site **sites, sn_space *space, sn_error *error) {
    sn_blob blob = {0};
    *count = 0;
    *sites = NULL;
    sn_status status = sn_blob_read(path, &blob, error);
    if (status) return status;
    sn_reader r = sn_reader_of(&blob, error);
    site_list list = {0};
    *space = sn_blob_space(&blob);
    r.commas = true;
    status = sn_json_detect(&blob) || sn_polylines_detect(&blob) ? take_ends(&blob, &list, error) : read_lines(&r, &list);
    sn_blob_free(&blob);
    if (status) {
        free(list.sites);
        return status;
    }
    *count = list.count;
    *sites = list.sites;
    return SN_OK;
}
