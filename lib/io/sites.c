/* sites.c -- known sites of a muscle's ends: lines "origin X Y Z" and "insertion X Y Z". */
#include "sinew/io.h"

#include <stdlib.h>
#include <string.h>

typedef struct site_reader {
    const char *name, *at, *end;
    int64_t line;
    size_t capacity;
    sn_index count;
    sn_end_site *sites;
} site_reader;

static bool is_space(char c) { return c == ' ' || c == '\t' || c == ',' || c == '\r'; }

static void skip_spaces(site_reader *r) {
    while (r->at < r->end && is_space(*r->at)) r->at++;
}

static bool take_word(site_reader *r, const char *word) {
    size_t length = strlen(word);
    if ((size_t)(r->end - r->at) <= length || memcmp(r->at, word, length) != 0 || !is_space(r->at[length])) return false;
    r->at += length;
    return true;
}

/* The rest of a line: three numbers. */
static bool take_point(site_reader *r, double point[3]) {
    for (int i = 0; i < 3; i++) {
        skip_spaces(r);
        if (!sn_scan_number(r->at, r->end, &r->at, &point[i]) || !isfinite(point[i])) return false;
    }
    skip_spaces(r);
    return r->at == r->end || *r->at == '\n' || *r->at == '#';
}

static sn_status read_site(site_reader *r, sn_error *error) {
    bool insertion = take_word(r, "insertion");
    double point[3];
    if ((!insertion && !take_word(r, "origin")) || !take_point(r, point))
        return sn_fail_at(error, SN_ERROR_INPUT, r->name, r->line,
                          "a site must be \"origin X Y Z\" or \"insertion X Y Z\", in the muscle's unit");
    if (r->count == SN_INDEX_MAX || !sn_grow((void **)&r->sites, &r->capacity, (size_t)r->count + 1, sizeof *r->sites))
        return sn_fail_memory(error, "the sites");
    r->sites[r->count++] = (sn_end_site){sn_v3(point[0], point[1], point[2]), insertion};
    return SN_OK;
}

static sn_status read_lines(site_reader *r, sn_error *error) {
    for (r->line = 1; r->at < r->end; r->line++) {
        skip_spaces(r);
        if (r->at < r->end && *r->at != '\n' && *r->at != '#') {
            sn_status status = read_site(r, error);
            if (status) return status;
        }
        while (r->at < r->end && *r->at != '\n') r->at++;
        if (r->at < r->end) r->at++;
    }
    if (r->count == 0) return sn_fail_at(error, SN_ERROR_INPUT, r->name, 0, "the file holds no site: no line \"origin X Y Z\"");
    return SN_OK;
}

sn_status sn_sites_read(const char *path, sn_index *count, sn_end_site **sites, sn_error *error) {
    sn_blob blob = {0};
    *count = 0;
    *sites = NULL;
    sn_status status = sn_blob_read(path, &blob, error);
    if (status) return status;
    site_reader r = {.name = blob.name, .at = blob.data, .end = blob.data + blob.size};
    status = read_lines(&r, error);
    sn_blob_free(&blob);
    if (status) {
        free(r.sites);
        return status;
    }
    *count = r.count;
    *sites = r.sites;
    return SN_OK;
}
