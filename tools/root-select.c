/* root-select.c -- where fibres start: a ring of vertices around the middle of a muscle. */
#include "cli.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "selector.h"
#include "sinew/rig.h"

/* A ring farther than this share of L from the volume centroid is worth a look. */
#define FAR_FROM_CENTROID 0.10

static const char *indices, *near, *sphere, *box, *plane, *painted, *ends;
static int tips;

static const char *const tip_names[] = {"sweeps", "eigenfunction", NULL};

static const cli_option options[] = {
    {0, "indices", "I,J,K", CLI_TEXT, &indices, CLI_RESULT, 0, 0, NULL, "these vertices"},
    {0, "near", "X,Y,Z[,N]", CLI_TEXT, &near, CLI_RESULT, 0, 0, NULL, "the N (default 1) vertices nearest to a point"},
    {0, "sphere", "X,Y,Z,R", CLI_TEXT, &sphere, CLI_RESULT, 0, 0, NULL, "the vertices within R of a point"},
    {0, "box", "X,Y,Z,X,Y,Z", CLI_TEXT, &box, CLI_RESULT, 0, 0, NULL, "the vertices in the box between two corners"},
    {0, "plane", "X,Y,Z,NX,NY,NZ", CLI_TEXT, &plane, CLI_RESULT, 0, 0, NULL,
     "the ring of vertices along the section nearest to a point of this plane"},
    {0, "painted", "NAME[>T]", CLI_TEXT, &painted, CLI_RESULT, 0, 0, NULL,
     "the vertices whose PLY attribute NAME is greater than T (default 0)"},
    {0, "ends", "FILE", CLI_TEXT, &ends, CLI_RESULT | CLI_FILE, 0, 0, cli_ends_words,
     "known sites of both ends: lines \"origin X Y Z\" and \"insertion X Y Z\", or fibres from end to end; auto (default): the best known "
     "attachments, else the tips"},
    {0, "tips", "HOW", CLI_CHOICE, &tips, CLI_RESULT, 0, 0, tip_names,
     "what the ends are without sites or attachments: sweeps, the points farthest from each other (default), or eigenfunction, the "
     "extremes of the surface's slowest vibration"},
};

static const cli_tool tool = {"root-select",
                              "choose the vertices where a muscle's fibres start",
                              CLI_CHAIN,
                              options,
                              sizeof options / sizeof *options,
                              "Without a selection the roots are the ring of vertices around the middle, found from the muscle's shape.",
                              CLI_WRITES_MUSCLE};

/* ---- options -------------------------------------------------------------------------------------------------------------- */

/* The one selection that was asked for; NULL text = automatic. */
static const char *chosen_selection(const cli *c, const char **kind) {
    const struct {
        const char *kind, *text;
    } given[] = {{"indices", indices}, {"near", near}, {"sphere", sphere}, {"box", box}, {"plane", plane}, {"painted", painted}};
    const char *text = NULL;
    for (size_t i = 0; i < sizeof given / sizeof *given; i++) {
        if (given[i].text == NULL) continue;
        if (text != NULL) cli_usage_error(c, "--%s and --%s exclude each other", *kind, given[i].kind);
        *kind = given[i].kind;
        text = given[i].text;
    }
    return text;
}

/* The selector parser wants "KIND:ARGUMENTS". */
static sn_status parse_selection(const char *kind, const char *text, selector *chosen, sn_error *error) {
    size_t size = strlen(kind) + strlen(text) + 2;
    char *whole = sn_alloc(size, 1);
    if (whole == NULL) return sn_fail_memory(error, "a selector");
    snprintf(whole, size, "%s:%s", kind, text);
    sn_status status = selector_parse(whole, chosen, error);
    free(whole);
    return status;
}

static void take_selection(const cli *c, sn_roots_params *params, selector *chosen) {
    const char *kind = NULL, *text = chosen_selection(c, &kind);
    sn_error error = {0};
    if (text == NULL) return;
    if (parse_selection(kind, text, chosen, &error) != SN_OK) cli_usage_error(c, "%s", error.text);
    if (ends != NULL) cli_usage_error(c, "--ends is for the automatic choice: it and --%s exclude each other", kind);
    params->automatic = false;
    params->selector = chosen->rule;
}

/* ---- report --------------------------------------------------------------------------------------------------------------- */

static void write_report(sn_json *json, const void *data) {
    const sn_roots_report *r = data;
    sn_json_integer(json, "count", r->count);
    sn_json_bool(json, "ring", r->ring);
    sn_json_integer(json, "parts", r->parts);
    sn_json_number(json, "centroidOffset", r->centroid_offset);
    sn_json_number(json, "length", r->length);
    sn_json_number(json, "level", r->level);
    sn_json_number(json, "genus", r->genus);
    sn_json_integer(json, "components", r->components);
    if (r->ends.from != NULL) cli_report_ends(json, &r->ends);
    if (isfinite(r->span)) sn_json_number(json, "span", r->span);
    if (r->ends.from != NULL) sn_json_bool(json, "right", r->right);
    if (r->ends.from != NULL) sn_json_bool(json, "section", r->section);
    if (r->ends.from != NULL) sn_json_bool(json, "betweenTips", r->between_tips);
    sn_json_bool(json, "fallback", r->fallback);
}

static void comment(const cli *c, const sn_roots_report *r) {
    double share = r->length > 0.0 ? r->centroid_offset / r->length : 0.0;
    cli_say(c, "%d roots, %s, %d part%s beside them, %.1f %% of the length from the centroid", r->count,
            r->ring ? "a closed ring" : "no ring", r->parts, r->parts == 1 ? "" : "s", 100.0 * share);
    if (r->ends.from != NULL && ends == NULL) cli_say_ends(c, &r->ends);
    if (r->components > 1) cli_warn(c, "the surface has %d components; mesh-clean --keep largest leaves one", r->components);
    if (r->genus > 0.0)
        cli_warn(c, "the surface has handles (genus %g): a ring need not separate it, and branches are not to be trusted", r->genus);
    if (r->count == 0) return;
    if (r->between_tips && ends != NULL)
        cli_warn(c, "the sites of %s lead to no ring around the muscle: they lie side by side, or all along it; took the tips", ends);
    if (r->between_tips && ends == NULL)
        cli_warn(c, "the ring is between the tips; fiber-flow and fiber-fill go by the better known ends all the same");
    if (r->section) cli_say(c, "no contour between the ends has such a ring: took a section across the line between them");
    if (r->fallback)
        cli_warn(
            c,
            "no ring runs around the muscle between its ends: took the next best, which spans %.0f %% of the way; look at the result, or "
            "choose the roots with --plane or --indices",
            100.0 * r->span);
    if (r->parts != 2)
        cli_warn(c, "the roots do not separate the surface in two (parts beside them: %d): fibres may run past them", r->parts);
    if (share > FAR_FROM_CENTROID) cli_warn(c, "the roots are %.0f %% of the muscle's length from its centroid", 100.0 * share);
}

/* ---- work ----------------------------------------------------------------------------------------------------------------- */

static sn_status select_roots(cli *c, const sn_roots_params *params, cli_muscle *muscle, sn_error *error) {
    sn_roots roots = {0};
    sn_roots_report report;
    sn_status status = sn_roots_select(&muscle->muscle, params, &c->trace, &roots, &report, error);
    if (status != SN_OK && status != SN_STOPPED) {
        sn_error_set_file(error, c->inputs.items[0]);
        return status;
    }
    sn_roots_free(&muscle->muscle.roots);
    muscle->muscle.roots = roots;
    comment(c, &report);
    sn_status saved = cli_save(c, muscle, SN_SECTION_ROOTS, error);
    return saved == SN_OK ? cli_report(c, write_report, &report, error) : saved;
}

int main(int argc, char **argv) {
    cli c;
    cli_muscle muscle = {0};
    selector chosen = {0};
    sn_end_site *sites = NULL;
    sn_error error = {0};
    sn_roots_params params = sn_roots_defaults();
    cli_start(&c, &tool, argc, argv);
    cli_take_ends(&ends);
    take_selection(&c, &params, &chosen);
    params.eigenfunction = tips == 1;
    sn_space space = SN_SPACE_UNKNOWN;
    sn_status status = ends != NULL ? sn_sites_read(ends, &params.site_count, &sites, &space, &error) : SN_OK;
    params.sites = sites;
    if (status == SN_OK) status = cli_load(&c, &muscle, &error);
    if (status == SN_OK) status = cli_check_space(&muscle.muscle, space, ends, &error);
    if (status == SN_OK) status = select_roots(&c, &params, &muscle, &error);
    cli_free(&muscle);
    selector_free(&chosen);
    free(sites);
    return cli_finish(&c, status, &error);
}
