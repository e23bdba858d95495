/* fiber-flow.c -- a fibre direction at every surface vertex of a muscle. */
#include "cli.h"

#include "sinew/rig.h"

static sn_flow_params params;
static int field, weights;
static int64_t smooth = -1;

static const char *const field_names[] = {"tree", NULL};
static const char *const weight_names[] = {"inverse-square", "paper", NULL}; /* in the order of sn_flow_weights */

static const cli_option options[] = {
    {0, "field", "NAME", CLI_CHOICE, &field, CLI_RESULT, 0, 0, field_names,
     "where directions come from: tree, the internal structure (default)"},
    {0, "weights", "NAME", CLI_CHOICE, &weights, CLI_RESULT, 0, 0, weight_names,
     "how samples at distance d weigh: inverse-square, 1/(d^2 + eps^2) (default), or paper, d"},
    {0, "smooth", "N", CLI_INTEGER, &smooth, CLI_RESULT, 0, 10000, NULL, "steps of diffusion along the surface (default 3)"},
    {0, "no-align", NULL, CLI_CLEAR, &params.align, CLI_RESULT, 0, 0, NULL,
     "average directions as vectors, as the paper does, not as axes without a sign"},
};

static const cli_tool tool = {
    "fiber-flow", "give every surface vertex a fibre direction", CLI_CHAIN, options, sizeof options / sizeof *options, NULL};

/* ---- report --------------------------------------------------------------------------------------------------------------- */

#define DEGREES (180.0 / SN_PI)

static void write_report(sn_json *json, const void *data) {
    const sn_flow_report *r = data;
    sn_json_integer(json, "vertices", r->vertices);
    sn_json_integer(json, "byTree", r->by_tree);
    sn_json_integer(json, "byNeighbours", r->by_neighbours);
    sn_json_integer(json, "byConvention", r->by_convention);
    sn_json_number(json, "maxNormalDot", r->max_normal_dot);
    sn_json_number(json, "meanAngleDegrees", r->mean_angle * DEGREES);
    sn_json_number(json, "percentile95AngleDegrees", r->percentile95_angle * DEGREES);
}

static void comment(const cli *c, const sn_flow_report *r) {
    cli_say(c,
            "%d directions: %d from the structure, %d from neighbours, %d by convention; between neighbours %.1f degrees on average, 95 %% "
            "below %.1f",
            r->vertices, r->by_tree, r->by_neighbours, r->by_convention, r->mean_angle * DEGREES, r->percentile95_angle * DEGREES);
    if (r->by_convention > 0)
        cli_warn(c, "%d vertices have an arbitrary direction: neither the structure nor their neighbours gave one", r->by_convention);
}

/* ---- work ----------------------------------------------------------------------------------------------------------------- */

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
    sn_status saved = cli_save(c, muscle, SN_SECTION_FIBERS, error);
    return saved == SN_OK ? cli_report(c, write_report, &report, error) : saved;
}

int main(int argc, char **argv) {
    cli c;
    cli_muscle muscle = {0};
    sn_error error = {0};
    params = sn_flow_defaults();
    cli_start(&c, &tool, argc, argv);
    params.weights = (sn_flow_weights)weights;
    if (smooth >= 0) params.smooth = (sn_index)smooth;
    sn_status status = cli_load(&c, &muscle, &error);
    if (status == SN_OK) status = flow(&c, &muscle, &error);
    cli_free(&muscle);
    return cli_finish(&c, status, &error);
}
