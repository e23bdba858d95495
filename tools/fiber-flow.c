/* fiber-flow.c -- a fibre direction at every surface vertex of a muscle. */
#include "cli.h"

#include <stdlib.h>

#include "sinew/rig.h"

static sn_flow_params params;
static int field, weights;
static const char *ends, *from_fibers;
static int64_t smooth = -1;

static const char *const weight_names[] = {"inverse-square", "paper", NULL}; /* in the order of sn_flow_weights */

static const cli_option options[] = {
    {0, "field", "NAME", CLI_CHOICE, &field, CLI_RESULT, 0, 0, sn_flow_field_names,
     "where directions come from: tree, the internal structure; harmonic, a field from end to end; fibers, those of --from-fibers; auto "
     "(default), harmonic where the ends are known by --ends, attachment areas or pins, else tree"},
    {0, "ends", "FILE", CLI_TEXT, &ends, CLI_RESULT | CLI_FILE, 0, 0, cli_ends_words,
     "known sites of both ends: lines \"origin X Y Z\" and \"insertion X Y Z\", or fibres from end to end; auto (default): the best known "
     "attachments, else the tips"},
    {0, "from-fibers", "FILE", CLI_TEXT, &from_fibers, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "take each direction from the nearest of these fibres: lines of an OBJ, VTP or VTK file, or those of a document"},
    {0, "weights", "NAME", CLI_CHOICE, &weights, CLI_RESULT, 0, 0, weight_names,
     "how samples at distance d weigh: inverse-square, 1/(d^2 + eps^2) (default), or paper, d"},
    {0, "smooth", "N", CLI_INTEGER, &smooth, CLI_RESULT, 0, 10000, NULL, "steps of diffusion along the surface (default 3)"},
    {0, "no-align", NULL, CLI_CLEAR, &params.align, CLI_RESULT, 0, 0, NULL,
     "average directions as vectors, as the paper does, not as axes without a sign"},
};

static const cli_tool tool = {
    "fiber-flow",     "give every surface vertex a fibre direction", CLI_CHAIN, options, sizeof options / sizeof *options, NULL,
    CLI_WRITES_MUSCLE};

/* ---- report --------------------------------------------------------------------------------------------------------------- */

#define DEGREES (180.0 / SN_PI)

static void write_report(sn_json *json, const void *data) {
    const sn_flow_report *r = data;
    sn_json_integer(json, "vertices", r->vertices);
    sn_json_text(json, "field", sn_flow_field_names[r->field]);
    if (r->ends.from != NULL) cli_report_ends(json, &r->ends);
    sn_json_integer(json, "byField", r->by_field);
    sn_json_integer(json, "byNeighbours", r->by_neighbours);
    sn_json_integer(json, "byConvention", r->by_convention);
    sn_json_number(json, "maxNormalDot", r->max_normal_dot);
    sn_json_number(json, "meanAngleDegrees", r->mean_angle * DEGREES);
    sn_json_number(json, "percentile95AngleDegrees", r->percentile95_angle * DEGREES);
    if (isfinite(r->roots_angle)) sn_json_number(json, "rootsAngleDegrees", r->roots_angle * DEGREES);
    sn_json_number(json, "meanConfidence", r->mean_confidence);
    sn_json_integer(json, "lowConfidence", r->low_confidence);
    if (r->field == SN_FIELD_FIBERS) sn_json_number(json, "farthestFiber", r->farthest_fiber);
}

static void comment(const cli *c, const sn_flow_report *r) {
    cli_say(c,
            "%d directions by the field %s: %d from it, %d from neighbours, %d by convention; between neighbours %.1f degrees on average, "
            "95 %% "
            "below %.1f",
            r->vertices, sn_flow_field_names[r->field], r->by_field, r->by_neighbours, r->by_convention, r->mean_angle * DEGREES,
            r->percentile95_angle * DEGREES);
    if (r->ends.from != NULL) cli_say_ends(c, &r->ends);
    if (r->by_convention > 0)
        cli_warn(c, "%d vertices have an arbitrary direction: neither the field nor their neighbours gave one", r->by_convention);
}

/* A field from end to end means little where nobody knows the ends. */
static void comment_ends(const cli *c, const sn_flow_report *r) {
    if (r->field == SN_FIELD_HARMONIC && (r->ends.source == SN_ENDS_TIPS || r->ends.source == SN_ENDS_EIGEN))
        cli_warn(c, "the harmonic field runs between the tips of the shape; give sites with --ends, or attachment areas with attach-detect "
                    "--method area, for the muscle's true ends");
}

/* ---- work ----------------------------------------------------------------------------------------------------------------- */

static sn_status read_extras(const sn_muscle *muscle, sn_end_site **sites, sn_fibers *given, sn_error *error) {
    sn_space of_ends = SN_SPACE_UNKNOWN, of_fibers = SN_SPACE_UNKNOWN;
    sn_status status = ends != NULL ? sn_sites_read(ends, &params.site_count, sites, &of_ends, error) : SN_OK;
    if (status == SN_OK && from_fibers != NULL) status = sn_polylines_read(from_fibers, given, &of_fibers, error);
    if (status == SN_OK) status = cli_check_space(muscle, of_ends, ends, error);
    if (status == SN_OK) status = cli_check_space(muscle, of_fibers, from_fibers, error);
    params.sites = *sites;
    params.polyline_count = given->polyline_count;
    params.polylines = given->polylines;
    return status;
}

static void take_options(const cli *c) {
    params.weights = (sn_flow_weights)weights;
    params.field = from_fibers != NULL ? SN_FIELD_FIBERS : (sn_flow_field)field;
    if (smooth >= 0) params.smooth = (sn_index)smooth;
    if (from_fibers != NULL && (field == SN_FIELD_TREE || field == SN_FIELD_HARMONIC))
        cli_usage_error(c, "--from-fibers and --field %s exclude each other", sn_flow_field_names[field]);
    if (from_fibers == NULL && field == SN_FIELD_FIBERS) cli_usage_error(c, "--field fibers needs --from-fibers FILE");
    if (ends != NULL && params.field != SN_FIELD_AUTO && params.field != SN_FIELD_HARMONIC)
        cli_usage_error(c, "--ends is for the harmonic field, not for %s", sn_flow_field_names[params.field]);
}

/* Fibres through the volume are not this tool's: they stay. */
static void take_directions(sn_muscle *muscle, sn_fibers *fibers) {
    fibers->polylines = muscle->fibers.polylines;
    fibers->polyline_count = muscle->fibers.polyline_count;
    muscle->fibers.polylines = NULL;
    muscle->fibers.polyline_count = 0;
    sn_fibers_free(&muscle->fibers);
    muscle->fibers = *fibers;
}

static sn_status flow(cli *c, cli_muscle *muscle, sn_error *error) {
    sn_fibers fibers = {0};
    sn_flow_report report;
    sn_status status = sn_flow_fibers(&muscle->muscle, &params, &c->trace, &fibers, &report, error);
    if (status != SN_OK && status != SN_STOPPED) {
        sn_error_set_file(error, c->inputs.items[0]);
        return status;
    }
    take_directions(&muscle->muscle, &fibers);
    comment(c, &report);
    comment_ends(c, &report);
    sn_status saved = cli_save(c, muscle, SN_SECTION_FIBERS, error);
    return saved == SN_OK ? cli_report(c, write_report, &report, error) : saved;
}

int main(int argc, char **argv) {
    cli c;
    cli_muscle muscle = {0};
    sn_end_site *sites = NULL;
    sn_fibers given = {0};
    sn_error error = {0};
    params = sn_flow_defaults();
    cli_start(&c, &tool, argc, argv);
    cli_take_ends(&ends);
    take_options(&c);
    sn_status status = cli_load(&c, &muscle, &error);
    if (status == SN_OK) status = read_extras(&muscle.muscle, &sites, &given, &error);
    if (status == SN_OK) status = flow(&c, &muscle, &error);
    cli_free(&muscle);
    sn_fibers_free(&given);
    free(sites);
    return cli_finish(&c, status, &error);
}
