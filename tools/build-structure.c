/* build-structure.c -- the internal structure of a muscle: a tree of samples from the roots to the tips. */
#include "cli.h"

#include "sinew/rig.h"

static sn_length spacing = {-1.0, 0.0};
static sn_structure_params params;
static int metric;

static const char *const metric_names[] = {"slabs", "hops", NULL}; /* in the order of sn_structure_metric */

static const cli_option options[] = {
    {0, "spacing", "LENGTH", CLI_LENGTH, &spacing, CLI_RESULT, 0, 0, NULL,
     "largest distance between neighbouring samples, such as 6mm (default: twice the mean edge length)"},
    {0, "metric", "NAME", CLI_CHOICE, &metric, CLI_RESULT, 0, 0, metric_names,
     "how the surface is traversed: slabs of equal distance from the roots (default), the same at any mesh density; or hops from vertex to "
     "vertex, as in the paper"},
    {0, "no-inside", NULL, CLI_FLAG, &params.keep_outside, CLI_RESULT, 0, 0, NULL,
     "leave samples that lie outside the volume, as happens on arched muscles, where they are"},
    {0, "prune", "SHARE", CLI_NUMBER, &params.prune, CLI_RESULT, 0.0, 1.0, NULL,
     "take away branches lower than this share of the muscle's length, or than the radius at their split (default 0.03; 0 = keep all)"},
};

static const cli_tool tool = {
    "build-structure", "grow the internal structure of a muscle from its roots", CLI_CHAIN, options, sizeof options / sizeof *options, NULL,
    CLI_WRITES_MUSCLE};

/* ---- report --------------------------------------------------------------------------------------------------------------- */

static void write_report(sn_json *json, const void *data) {
    const sn_structure_report *r = data;
    sn_json_integer(json, "samples", r->samples);
    sn_json_integer(json, "branches", r->branches);
    sn_json_integer(json, "leaves", r->leaves);
    sn_json_integer(json, "pruned", r->pruned);
    sn_json_integer(json, "vertices", r->vertices);
    sn_json_integer(json, "unconnected", r->unconnected);
    if (r->outside >= 0) sn_json_integer(json, "outside", r->outside);
    sn_json_integer(json, "moved", r->moved);
    sn_json_number(json, "spacing", r->spacing);
    sn_json_number(json, "longestLink", r->longest_link);
    sn_json_number(json, "length", r->length);
    sn_json_number(json, "genus", r->genus);
}

static void comment(const cli *c, const sn_structure_report *r) {
    cli_say(c, "%d samples on %d branches, %d leaves, %d branches pruned, longest link %g", r->samples, r->branches, r->leaves, r->pruned,
            r->longest_link);
    if (r->genus > 0.0) cli_warn(c, "the surface has handles (genus %g): its branches are not to be trusted", r->genus);
    if (r->moved > 0) cli_say(c, "samples moved from outside the volume to its middle, as arched muscles need: %d", r->moved);
    if (r->outside > 0) cli_say(c, "%d of %d samples are outside the volume", r->outside, r->samples);
}

/* ---- work ----------------------------------------------------------------------------------------------------------------- */

static sn_status build(cli *c, cli_muscle *muscle, sn_error *error) {
    sn_structure structure = {0};
    sn_structure_report report;
    double unit = muscle->muscle.meters_per_unit;
    if (cli_given(c, "spacing")) params.spacing = cli_length(spacing, unit);
    sn_status status = sn_structure_build(&muscle->muscle, &params, &c->trace, &structure, &report, error);
    if (status != SN_OK && status != SN_STOPPED) {
        sn_error_set_file(error, c->inputs.items[0]);
        return status;
    }
    sn_structure_free(&muscle->muscle.structure);
    muscle->muscle.structure = structure;
    comment(c, &report);
    sn_status saved = cli_save(c, muscle, SN_SECTION_STRUCTURE, error);
    return saved == SN_OK ? cli_report(c, write_report, &report, error) : saved;
}

int main(int argc, char **argv) {
    cli c;
    cli_muscle muscle = {0};
    sn_error error = {0};
    params = sn_structure_defaults();
    cli_start(&c, &tool, argc, argv);
    params.metric = (sn_structure_metric)metric;
    if (cli_given(&c, "spacing") && !(spacing.value > 0.0)) cli_usage_error(&c, "--spacing must be greater than 0");
    sn_status status = cli_load(&c, &muscle, &error);
    if (status == SN_OK) status = build(&c, &muscle, &error);
    cli_free(&muscle);
    return cli_finish(&c, status, &error);
}
