/* fiber-fill.c -- decompose a muscle's volume into fibres. */
#include "cli.h"
#include "fiber_architecture.h"

#include <stdlib.h>

#include "sinew/rig.h"

#define DEGREES (180.0 / SN_PI)
#define MOST_EMPTY 0.1    /* share of the volume far from every fibre beyond which the muscle is not filled */
#define MOST_OUTSIDE 0.05 /* of their length */
#define ANGLE_OFF 2.0     /* degrees off --angle that are worth a warning */

static sn_fill_params params;
static int64_t fibers = -1, segments = -1, smooth = -1;
static int template, map;
static double angle = -1.0, narrow = -1.0, bow = NAN, turn = 0.0, mvc_cut = 0.0;
static const char *template_file, *ends_file, *embedding_file, *bend_file, *tendon;

/* In the order of sn_fill_template and sn_fill_map. */
static const char *const template_names[] = {"parallel", "pennate", "bipennate", "fan", "curved", NULL};
static const char *const map_names[] = {"harmonic", "mvc", NULL};

static const cli_option options[] = {
    {'n', "fibers", "N", CLI_INTEGER, &fibers, CLI_RESULT, 1, 1000000, NULL, "how many fibres (default 100)"},
    {0, "segments", "M", CLI_INTEGER, &segments, CLI_RESULT, 1, 1000, NULL, "straight segments of each (default 15)"},
    {0, "template", "NAME", CLI_CHOICE, &template, CLI_RESULT, 0, 0, template_names,
     "how they run: parallel (default), pennate, bipennate, fan, curved"},
    {0, "template-file", "FILE", CLI_TEXT, &template_file, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "how they run: Bezier curves in the unit cube, as JSON"},
    {0, "angle", "DEGREES", CLI_NUMBER, &angle, CLI_RESULT, 0.1, 89.9, NULL,
     "pennate, bipennate: angle against the line of action (default 20)"},
    {0, "narrow", "SHARE", CLI_NUMBER, &narrow, CLI_RESULT, 0.001, 1, NULL,
     "fan: width of the narrow end against the wide one (default 0.25)"},
    {0, "bow", "B", CLI_NUMBER, &bow, CLI_RESULT, -1, 1, NULL, "curved: how far fibres bow aside, -1 to 1 (default 0.5)"},
    {0, "turn", "DEGREES", CLI_NUMBER, &turn, CLI_RESULT, -360, 360, NULL,
     "turn the template about the line of action; at 0 its x lies along the widest way of the section (default 0)"},
    {0, "bend-to", "FILE", CLI_TEXT, &bend_file, CLI_RESULT | CLI_FILE, 0, 0, NULL,
     "bend the template to superficial fibres: lines of an OBJ, VTP or VTK file, or a document's"},
    {0, "map", "NAME", CLI_CHOICE, &map, CLI_RESULT, 0, 0, map_names,
     "from the template to a slice: harmonic (default), or mvc, planar mean value coordinates"},
    {0, "ends", "FILE", CLI_TEXT, &ends_file, CLI_RESULT | CLI_FILE, 0, 0, cli_ends_words,
     "where fibres begin and end: vertices as JSON, or fibres as --bend-to takes them; auto (default): the best known attachments, else "
     "the tips"},
    {0, "tips", NULL, CLI_CLEAR, &params.use_attachments, CLI_RESULT, 0, 0, NULL, "let fibres end at the tips, not at the attachments"},
    {0, "smooth", "N", CLI_INTEGER, &smooth, CLI_RESULT, 0, 10000, NULL, "rounds of smoothing along each fibre (default 0)"},
    {0, "no-pull", NULL, CLI_CLEAR, &params.pull, CLI_RESULT, 0, 0, NULL, "leave fibre vertices outside the volume where they are"},
    {0, "tendon", "HOW", CLI_TEXT, &tendon, CLI_RESULT, 0, 0, NULL,
     "paint what is tendon on the mesh: thickness, painted (a map), none, or ORIGIN,INSERTION: lengths, or shares as 5%"},
    {0, "embedding", "FILE", CLI_TEXT, &embedding_file, CLI_WRITES, 0, 0, NULL,
     "also write the weights that bind the fibres to the surface: 3-D mean value coordinates"},
    {0, "mvc-cut", "W", CLI_NUMBER, &mvc_cut, 0, 0, 0.09, NULL,
     "in that file drop weights below W and correct the rest (default 0, keep all)"},
};

static const cli_tool tool = {"fiber-fill",
                              "decompose a muscle's volume into fibres",
                              CLI_CHAIN | CLI_HAS_THREADS,
                              options,
                              sizeof options / sizeof *options,
                              "The document gets the fibres; an output that ends in .vtp or .obj gets them as bare lines.",
                              CLI_WRITES_MUSCLE};

/* ---- report --------------------------------------------------------------------------------------------------------------- */

typedef struct outcome {
    const sn_fibers *fibers;
    sn_fill_report fill;
    sn_embedding_report embedding;
    bool embedded;
    fiber_architecture architecture;
} outcome;

static bool is_oblique(void) { return params.template == SN_FILL_PENNATE || params.template == SN_FILL_BIPENNATE; }

static void write_each(sn_json *json, const sn_fibers *lines) {
    sn_json_array(json, "each");
    for (sn_index i = 0; i < lines->polyline_count; i++) {
        sn_json_object(json, NULL);
        sn_json_number(json, "length", lines->polylines[i].length);
        sn_json_number(json, "pennationDegrees", lines->polylines[i].pennation * DEGREES);
        sn_json_close(json);
    }
    sn_json_close(json);
}

static void write_embedding(sn_json *json, const sn_embedding_report *r) {
    sn_json_object(json, "embedding");
    sn_json_integer(json, "weights", r->weights);
    sn_json_integer(json, "pointsOnSurface", r->near_points);
    sn_json_number(json, "error", r->error);
    sn_json_number(json, "droppedMean", r->dropped_mean);
    sn_json_number(json, "droppedWorst", r->dropped_worst);
    sn_json_close(json);
}

static void write_lengths(sn_json *json, const sn_fill_report *r) {
    sn_json_number(json, "meanLength", r->mean_length);
    sn_json_number(json, "leastLength", r->least_length);
    sn_json_number(json, "greatestLength", r->greatest_length);
    sn_json_number(json, "lengthDeviation", r->length_deviation);
    sn_json_number(json, "lengthVariation", r->mean_length > 0.0 ? r->length_deviation / r->mean_length : 0.0);
    if (r->spread) {
        sn_json_number(json, "originArea", r->areas[0]);
        sn_json_number(json, "insertionArea", r->areas[1]);
    }
}

/* How well they fill the muscle. */
static void write_filling(sn_json *json, const sn_fill_report *r) {
    sn_json_text(json, "slices", r->flux ? "flux" : "length");
    sn_json_number(json, "spacing", r->spacing);
    sn_json_number(json, "emptyShare", r->empty);
    if (r->closed) sn_json_number(json, "outsideShare", r->outside);
    sn_json_number(json, "lengthOverChord", r->greatest_bend);
    sn_json_integer(json, "bentFibers", r->bent);
}

static void write_report(sn_json *json, const void *data) {
    const outcome *o = data;
    const sn_fill_report *r = &o->fill;
    sn_json_integer(json, "fibers", r->fibers);
    sn_json_integer(json, "vertices", r->vertices);
    if (r->chosen.from != NULL) cli_report_ends(json, &r->chosen);
    sn_json_integer(json, "leaves", r->leaves);
    sn_json_integer(json, "levels", r->levels);
    sn_json_integer(json, "loops", r->loops);
    sn_json_integer(json, "mostLoops", r->most_loops);
    sn_json_integer(json, "endLoops", r->leaf_loops);
    sn_json_integer(json, "endLoopsReached", r->leaves_reached);
    sn_json_integer(json, "outsideBefore", r->outside_before);
    sn_json_integer(json, "outsideAfter", r->outside_after);
    sn_json_number(json, "farthestOutside", r->farthest);
    write_lengths(json, r);
    sn_json_number(json, "lineOfAction", r->action_length);
    if (is_oblique()) sn_json_number(json, "angleAskedDegrees", params.angle * DEGREES);
    sn_json_number(json, "meanPennationDegrees", r->mean_pennation * DEGREES);
    sn_json_number(json, "greatestPennationDegrees", r->greatest_pennation * DEGREES);
    sn_json_number(json, "sectionArea", r->area);
    sn_json_number(json, "density", r->density);
    write_filling(json, r);
    if (params.bend_count > 0) {
        sn_json_object(json, "bend");
        sn_json_integer(json, "superficialFibers", params.bend_count);
        sn_json_number(json, "farthest", r->bend_farthest);
        sn_json_close(json);
    }
    if (o->embedded) write_embedding(json, &o->embedding);
    fiber_architecture_write(json, &o->architecture);
    write_each(json, o->fibers);
}

/* Fewer segments than by default cut corners because someone wants them to. */
static void comment_outside(cli *c, const sn_fill_report *r, const char *from) {
    static const char *const text = "%.0f %% of the fibres' length is outside of the muscle: from %s they run straight where it bends; "
                                    "--segments N gives finer ones, --template parallel and --tips follow it";
    if (r->outside > MOST_OUTSIDE && params.segments >= SN_FILL_SEGMENTS)
        cli_shortfall(c, text, 100.0 * r->outside, from);
    else if (r->outside > MOST_OUTSIDE)
        cli_warn(c, text, 100.0 * r->outside, from);
}

/* Most of them bent, and some by far, says that the ends are not the muscle's. */
static void comment_bends(cli *c, const sn_fill_report *r, const char *from) {
    static const char *const text =
        "%d of %d fibres bend more than the muscle does: one is %.1f times as long as its ends are apart; do the "
        "ends, %s, lie where fibres begin and end?";
    if (2 * r->bent > r->fibers && r->greatest_bend > 2.0 * SN_FILL_BENT)
        cli_shortfall(c, text, r->bent, r->fibers, r->greatest_bend, from);
    else if (r->bent > 0)
        cli_warn(c, text, r->bent, r->fibers, r->greatest_bend, from);
}

/* A template of one's own may leave out what it likes. */
static void comment_filling(cli *c, const sn_fill_report *r) {
    static const char *const text =
        "%.0f %% of the muscle is farther than %g mean spacings (of %.3g) from every fibre: the ends from which "
        "they run, %s, leave it aside; --ends or areas by attach-detect --landmarks say better ones";
    const char *from = r->chosen.from != NULL ? r->chosen.from : "nowhere";
    if (r->empty > MOST_EMPTY && params.template != SN_FILL_USER)
        cli_shortfall(c, text, 100.0 * r->empty, SN_FILL_FAR, r->spacing, from);
    else if (r->empty > MOST_EMPTY)
        cli_warn(c, "%.0f %% of the muscle is farther than %g mean spacings (of %.3g) from every fibre", 100.0 * r->empty, SN_FILL_FAR,
                 r->spacing);
    comment_outside(c, r, from);
    comment_bends(c, r, from);
}

static void comment(cli *c, const sn_fill_report *r, bool stopped) {
    cli_say(c, "%d fibres from %s, %d slices on %d levels; mean length %.4g, pennation %.1f degrees; %d of %d vertices were outside",
            r->fibers, r->chosen.from != NULL ? r->chosen.from : "nowhere", r->loops, r->levels, r->mean_length,
            r->mean_pennation * DEGREES, r->outside_before, r->vertices);
    if (r->chosen.from != NULL) cli_say_ends(c, &r->chosen);
    if (!r->closed) cli_warn(c, "the surface is not closed: fibres end at its gaps, and inside is a guess; mesh-clean fills holes");
    if (stopped) return;
    if (r->fibers < params.fibers) cli_shortfall(c, "only %d of %d fibres found their way between the ends", r->fibers, params.fibers);
    if (r->outside_after > 0 && params.pull) cli_shortfall(c, "%d fibre vertices stay outside the volume", r->outside_after);
    comment_filling(c, r);
    if (r->spread && r->leaves_reached < r->leaf_loops)
        cli_warn(c, "%d of %d ends of the muscle get no fibre: no attachment area lies there, or one too small for a fibre",
                 r->leaf_loops - r->leaves_reached, r->leaf_loops);
    if (is_oblique() && fabs(r->mean_pennation - params.angle) > ANGLE_OFF / DEGREES)
        cli_warn(
            c,
            "the fibres' mean angle against the line of action is %.1f degrees, not the %.1f asked for: the muscle bends, or its sides "
            "run more obliquely than the fibres would",
            r->mean_pennation * DEGREES, params.angle * DEGREES);
    if (!r->spread && r->leaves_reached < r->leaf_loops && params.template != SN_FILL_USER)
        cli_warn(c, "%d of %d ends of the muscle get no fibre: more fibres would reach them", r->leaf_loops - r->leaves_reached,
                 r->leaf_loops);
}

/* ---- what is given ---------------------------------------------------------------------------------------------------------- */

static sn_status read_template(sn_fibers *lines, sn_fill_curve **curves, sn_error *error) {
    if (template_file == NULL) return SN_OK;
    sn_blob blob = {0};
    sn_status status = sn_blob_read(template_file, &blob, error);
    if (status == SN_OK) status = sn_fiber_template_parse(&blob, lines, error);
    sn_blob_free(&blob);
    if (status == SN_OK && (*curves = SN_NEW(sn_fill_curve, lines->polyline_count)) == NULL) status = sn_fail_memory(error, "the template");
    for (sn_index i = 0; status == SN_OK && i < lines->polyline_count; i++)
        (*curves)[i] = (sn_fill_curve){lines->polylines[i].count, lines->polylines[i].points};
    params.template = SN_FILL_USER;
    params.curve_count = lines->polyline_count;
    params.curves = *curves;
    return status;
}

static sn_status read_ends(const sn_muscle *muscle, sn_fiber_ends *ends, sn_error *error) {
    if (ends_file == NULL) return SN_OK;
    sn_blob blob = {0};
    sn_status status = sn_blob_read(ends_file, &blob, error);
    if (status == SN_OK) status = cli_check_space(muscle, sn_blob_space(&blob), ends_file, error);
    if (status == SN_OK) status = sn_fiber_ends_parse(&blob, &muscle->mesh, ends, error);
    sn_blob_free(&blob);
    params.origin = ends->origin;
    params.origin_count = ends->origin_count;
    params.insertion = ends->insertion;
    params.insertion_count = ends->insertion_count;
    return status;
}

static sn_status read_superficial(const sn_muscle *muscle, sn_fibers *lines, sn_error *error) {
    if (bend_file == NULL) return SN_OK;
    sn_space space;
    sn_status status = sn_polylines_read(bend_file, lines, &space, error);
    if (status == SN_OK) status = cli_check_space(muscle, space, bend_file, error);
    params.bend_count = lines->polyline_count;
    params.bend_lines = lines->polylines;
    return status;
}

static void take_options(const cli *c) {
    if (fibers > 0) params.fibers = (sn_index)fibers;
    if (segments > 0) params.segments = (sn_index)segments;
    if (smooth >= 0) params.smooth = (sn_index)smooth;
    if (angle > 0.0) params.angle = angle / DEGREES;
    if (narrow > 0.0) params.narrow = narrow;
    if (!isnan(bow)) params.bow = bow;
    params.turn = turn / DEGREES;
    params.template = (sn_fill_template) template;
    params.map = (sn_fill_map)map;
    params.spread = template_file == NULL && !cli_given(c, "template");
    if (template_file != NULL && cli_given(c, "template")) cli_usage_error(c, "--template and --template-file exclude each other");
    if (cli_given(c, "angle") && template != SN_FILL_PENNATE && template != SN_FILL_BIPENNATE)
        cli_usage_error(c, "--angle is for --template pennate or bipennate");
    if (cli_given(c, "narrow") && template != SN_FILL_FAN) cli_usage_error(c, "--narrow is for --template fan");
    if (cli_given(c, "bow") && template != SN_FILL_CURVED) cli_usage_error(c, "--bow is for --template curved");
    if (bend_file != NULL && (template_file != NULL || template == SN_FILL_PENNATE || template == SN_FILL_BIPENNATE))
        cli_usage_error(c, "--bend-to is for --template parallel, fan or curved");
    if (cli_given(c, "mvc-cut") && embedding_file == NULL) cli_usage_error(c, "--mvc-cut is for --embedding FILE");
}

/* ---- output ------------------------------------------------------------------------------------------------------------------ */

/* Fibre directions on the surface are not this tool's: they stay. */
static void take_polylines(sn_muscle *muscle, sn_fibers *lines) {
    sn_fibers old = {.polylines = muscle->fibers.polylines, .polyline_count = muscle->fibers.polyline_count};
    muscle->fibers.polylines = lines->polylines;
    muscle->fibers.polyline_count = lines->polyline_count;
    sn_fibers_free(&old);
    *lines = (sn_fibers){0};
}

static sn_status save_lines(const cli *c, const sn_muscle *muscle, sn_lines_format format, sn_error *error) {
    sn_output *output = NULL;
    sn_status status = sn_output_open(c->output, false, &output, error);
    if (status == SN_OK) status = sn_lines_write(&muscle->fibers, format, output, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

static sn_vec3 *all_points(const sn_fibers *lines, sn_index *count) {
    *count = 0;
    for (sn_index i = 0; i < lines->polyline_count; i++) *count += lines->polylines[i].count;
    sn_vec3 *points = SN_NEW(sn_vec3, *count);
    for (sn_index i = 0, n = 0; points != NULL && i < lines->polyline_count; i++)
        for (sn_index k = 0; k < lines->polylines[i].count; k++) points[n++] = lines->polylines[i].points[k];
    return points;
}

static sn_status write_weights(const sn_embedding *embedding, const char *hash, sn_error *error) {
    sn_output *output = NULL;
    sn_status status = sn_output_open(embedding_file, false, &output, error);
    if (status == SN_OK) status = sn_embedding_save(embedding, hash, output, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

static sn_status save_embedding(const sn_muscle *muscle, outcome *o, sn_error *error) {
    if (embedding_file == NULL || muscle->fibers.polyline_count == 0) return SN_OK;
    sn_index count;
    sn_vec3 *points = all_points(&muscle->fibers, &count);
    sn_embedding_params with = sn_embedding_defaults();
    sn_embedding embedding = {0};
    char hash[SN_HASH_LENGTH];
    with.cut = mvc_cut;
    with.pool = params.pool;
    sn_status status = points != NULL ? SN_OK : sn_fail_memory(error, "the fibres");
    if (status == SN_OK) status = sn_embedding_hash(&muscle->mesh, count, points, &with, hash, error);
    if (status == SN_OK) status = sn_embedding_build(&muscle->mesh, count, points, &with, &embedding, error);
    if (status == SN_OK) status = write_weights(&embedding, hash, error);
    o->embedded = status == SN_OK;
    o->embedding = embedding.report;
    sn_embedding_free(&embedding);
    free(points);
    return status;
}

/* ---- work --------------------------------------------------------------------------------------------------------------------- */

static sn_status save(cli *c, cli_muscle *muscle, outcome *o, sn_error *error) {
    sn_lines_format format = sn_lines_format_from_name(c->output);
    o->fibers = &muscle->muscle.fibers;
    sn_status status = fiber_architecture_measure(c, tendon, &muscle->muscle, &o->architecture, error);
    if (status == SN_OK) status = save_embedding(&muscle->muscle, o, error);
    if (status != SN_OK) return status;
    if (o->architecture.paints && format != SN_LINES_UNKNOWN)
        cli_warn(c, "bare lines have no surface to paint: the map of tendons is lost");
    unsigned changed = SN_SECTION_FIBERS | fiber_architecture_changes(&o->architecture);
    status = format != SN_LINES_UNKNOWN ? save_lines(c, &muscle->muscle, format, error) : cli_save(c, muscle, changed, error);
    return status == SN_OK ? cli_report(c, write_report, o, error) : status;
}

static sn_status fill(cli *c, cli_muscle *muscle, sn_error *error) {
    sn_fibers template_lines = {0}, superficial = {0}, lines = {0};
    sn_fill_curve *curves = NULL;
    sn_fiber_ends ends = {0};
    outcome o = {0};
    bool stopped = false;
    sn_status status = read_template(&template_lines, &curves, error);
    if (status == SN_OK) status = read_superficial(&muscle->muscle, &superficial, error);
    if (status == SN_OK) status = read_ends(&muscle->muscle, &ends, error);
    if (status == SN_OK) {
        status = sn_fill_fibers(&muscle->muscle, &params, &c->trace, &lines, &o.fill, error);
        if (status != SN_OK && status != SN_STOPPED && status != SN_ERROR_USAGE) sn_error_set_file(error, c->inputs.items[0]);
        stopped = status == SN_STOPPED;
    }
    if (status == SN_OK || stopped) {
        take_polylines(&muscle->muscle, &lines);
        comment(c, &o.fill, stopped);
        status = save(c, muscle, &o, error);
    }
    fiber_architecture_free(&o.architecture);
    sn_fibers_free(&template_lines);
    sn_fibers_free(&superficial);
    sn_fibers_free(&lines);
    sn_fiber_ends_free(&ends);
    free(curves);
    return status;
}

int main(int argc, char **argv) {
    cli c;
    cli_muscle muscle = {0};
    sn_error error = {0};
    params = sn_fill_defaults();
    cli_start(&c, &tool, argc, argv);
    cli_take_ends(&ends_file);
    take_options(&c);
    params.pool = sn_pool_create(c.threads);
    sn_status status = params.pool != NULL ? cli_load(&c, &muscle, &error) : sn_fail_memory(&error, "threads");
    if (status == SN_OK) status = fill(&c, &muscle, &error);
    cli_free(&muscle);
    sn_pool_destroy(params.pool);
    return cli_finish(&c, status, &error);
}
