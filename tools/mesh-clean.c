/* mesh-clean.c -- from any surface to a closed, oriented 2-manifold. */
#include "cli.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sinew/rig.h"

static sn_clean_params params;
static sn_length edge_length = {-1.0, 0.0};
static int64_t max_hole = -1, triangles, smooth;
static const char *const keep_names[] = {"largest", "all", NULL}, *const repair_names[] = {"exact", "full", NULL};
static const char *keep = "largest", *weld = "auto", *repair = "exact";
static bool check;

static const cli_option options[] = {
    {0, "weld", "SHARE", CLI_TEXT, &weld, CLI_RESULT, 0, 0, NULL,
     "join vertices, and close cracks, up to this share of the box diagonal; auto (default): 1e-6, and cracks as wide as the mesh says"},
    {0, "repair-nonfinite", NULL, CLI_FLAG, &params.repair_nonfinite, CLI_RESULT, 0, 0, NULL,
     "drop vertices with NaN or infinity and their triangles, instead of failing"},
    {0, "no-manifold", NULL, CLI_CLEAR, &params.make_manifold, CLI_RESULT, 0, 0, NULL,
     "leave orientation and non-manifold edges as they are"},
    {0, "keep", "WHICH", CLI_TEXT, &keep, CLI_RESULT, 0, 0, keep_names, "components to keep, by area: largest (default), all, or how many"},
    {0, "max-hole", "N", CLI_INTEGER, &max_hole, CLI_RESULT, 0, SN_INDEX_MAX, NULL, "fill holes of up to N edges (default: any; 0 = none)"},
    {0, "no-outward", NULL, CLI_CLEAR, &params.outward, CLI_RESULT, 0, 0, NULL, "leave components that are inside out"},
    {0, "most-lost", "SHARE", CLI_NUMBER, &params.most_lost, CLI_RESULT, 0.0, 1.0, NULL,
     "the share of the area that may be lost before it is a shortfall (default 0.05; not asked with --keep)"},
    {0, "repair", "HOW", CLI_TEXT, &repair, CLI_RESULT, 0, 0, repair_names,
     "exact (default): vertices stay where they are; full: wrap what that cannot close, or would lose too much of"},
    {0, "wrap", "OFFSET", CLI_NUMBER, &params.wrap, CLI_RESULT, 1e-4, 0.1, NULL,
     "build a new surface around the old, this share of the diagonal away (--repair full: 0.002 where it must)"},
    {0, "remove-intersections", NULL, CLI_FLAG, &params.remove_intersections, CLI_RESULT, 0, 0, NULL,
     "replace triangles that cross, within 30 s of processor time"},
    {0, "edge-length", "LENGTH", CLI_LENGTH, &edge_length, CLI_RESULT, 0, 0, NULL, "remesh to edges of about this length"},
    {0, "triangles", "N", CLI_INTEGER, &triangles, CLI_RESULT, 4, SN_INDEX_MAX, NULL, "decimate to at most N triangles (default: leave)"},
    {0, "smooth", "N", CLI_INTEGER, &smooth, CLI_RESULT, 0, 1000, NULL, "N rounds of smoothing that keep the volume"},
    {0, "flip-slivers", NULL, CLI_FLAG, &params.flip_slivers, CLI_RESULT, 0, 0, NULL,
     "flip edges of triangles that are thin, where the surface is flat"},
    {0, "self-intersections", NULL, CLI_FLAG, &params.count_intersections, 0, 0, 0, NULL, "count pairs of triangles that cross"},
    {0, "check", NULL, CLI_FLAG, &check, 0, 0, 0, NULL, "say what is wrong with the input and write nothing; exit status 3 if anything is"},
};

static const cli_tool tool = {
    "mesh-clean",     "make a closed, oriented manifold of a surface mesh", CLI_CHAIN, options, sizeof options / sizeof *options, NULL,
    CLI_WRITES_MUSCLE};

/* ---- options ------------------------------------------------------------------------------------------------------------ */

static void take_keep(const cli *c) {
    int64_t count = 1;
    sn_error error = {0};
    if (strcmp(keep, "all") == 0)
        count = 0;
    else if (strcmp(keep, "largest") != 0 && sn_parse_integer(keep, 1, SN_INDEX_MAX, &count, &error) != SN_OK) {
        cli_usage_error(c, "--keep takes largest, all, or a number from 1, not '%s'", keep);
    }
    params.keep = (sn_index)count;
}

/* A share of the diagonal is for vertices and cracks alike; with 0 only equal vertices are joined. */
static void take_weld(const cli *c) {
    sn_error error = {0};
    if (strcmp(weld, "auto") == 0) return;
    if (sn_parse_number(weld, &params.weld, &error) != SN_OK || params.weld < 0.0 || params.weld > 0.1) {
        cli_usage_error(c, "--weld takes auto, or a share of the diagonal from 0 to 0.1, not '%s'", weld);
    }
    params.crack = params.weld;
    params.close_cracks = params.weld > 0.0;
}

static void take_options(cli *c) {
    take_keep(c);
    take_weld(c);
    params.full = strcmp(repair, "full") == 0;
    if (!params.full && strcmp(repair, "exact") != 0) cli_no_such_value(c, "repair", repair, strlen(repair), repair_names);
    if (cli_given(c, "keep") && !cli_given(c, "most-lost")) params.most_lost = 1.0; /* what goes was asked for */
    if (!params.make_manifold && (params.full || params.wrap > 0.0))
        cli_usage_error(c, "--no-manifold goes without --repair full and --wrap");
    if (edge_length.value == 0.0) cli_usage_error(c, "--edge-length: no edge has a length of 0");
    params.smooth = (sn_index)smooth;
    if (max_hole >= 0) params.max_hole = (sn_index)max_hole;
    params.triangles = (sn_index)triangles;
    c->read.allow_nonfinite = params.repair_nonfinite; /* else the reader says in which line it stands */
    if (check && cli_given(c, "output")) cli_usage_error(c, "--check writes nothing: it goes without --output");
}

/* ---- timings of the steps ------------------------------------------------------------------------------------------------ */

#define MOST_STAGES 24

/* Stands between the library and the tool's trace, and looks at the clock. */
typedef struct stopwatch {
    cli *c;
    double last;
    int count;
    const char *stages[MOST_STAGES]; /* names are literals of the library */
    double seconds[MOST_STAGES];
} stopwatch;

static void receive(void *user, int64_t number, const char *stage, const sn_trace_value *values, int value_count) {
    stopwatch *w = user;
    double now = cli_seconds();
    int i = 0;
    while (i < w->count && strcmp(w->stages[i], stage) != 0) i++;
    if (i < MOST_STAGES) {
        w->stages[i] = stage;
        w->seconds[i] += now - w->last;
        if (i == w->count) w->count++;
    }
    if (sn_trace_wanted(&w->c->trace)) w->c->trace.receive(w->c->trace.user, number, stage, values, value_count);
    w->last = cli_seconds();
}

/* ---- what is wrong -------------------------------------------------------------------------------------------------------- */

typedef struct sentence {
    char text[512];
    size_t used;
} sentence;

static void add_defect(sentence *s, sn_index count, const char *one, const char *many) {
    if (count <= 0) return;
    int written = snprintf(s->text + s->used, sizeof s->text - s->used, "%s%d %s", s->used > 0 ? ", " : "", count, count == 1 ? one : many);
    if (written > 0 && (size_t)written < sizeof s->text - s->used) s->used += (size_t)written;
}

/* Everything that keeps a surface from being the closed, oriented manifold that the other tools want; "" = nothing. */
static sentence list_defects(const sn_mesh_report *r, sn_index most_components) {
    sentence s = {0};
    bool sound = r->closed && r->manifold && r->oriented;
    add_defect(&s, r->boundary_edges, "boundary edge", "boundary edges");
    add_defect(&s, r->nonmanifold_edges, "non-manifold edge", "non-manifold edges");
    add_defect(&s, r->nonmanifold_vertices, "non-manifold vertex", "non-manifold vertices");
    add_defect(&s, r->inconsistent_edges, "edge between opposite orientations", "edges between opposite orientations");
    add_defect(&s, r->degenerate_triangles, "degenerate triangle", "degenerate triangles");
    add_defect(&s, r->duplicate_triangles, "duplicate triangle", "duplicate triangles");
    add_defect(&s, sound ? 0 : r->duplicate_vertices, "duplicate vertex", "duplicate vertices");
    add_defect(&s, r->unused_vertices, "unused vertex", "unused vertices");
    add_defect(&s, r->self_intersections, "pair of triangles that cross", "pairs of triangles that cross");
    if (most_components > 0 && r->components > most_components) add_defect(&s, r->components, "component", "components");
    if (sound && !r->outward) add_defect(&s, 1, "surface inside out", "");
    return s;
}

/* ---- report --------------------------------------------------------------------------------------------------------------- */

typedef struct result {
    const sn_clean_report *report;
    const stopwatch *watch;
    double meters_per_unit;
} result;

static void write_dropped(sn_json *json, const sn_clean_report *r) {
    sn_json_array(json, "dropped");
    for (sn_index i = 0; i < r->dropped_count; i++) {
        sn_json_object(json, NULL);
        sn_json_integer(json, "triangles", r->dropped[i].triangles);
        sn_json_number(json, "area", r->dropped[i].area);
        sn_json_number(json, "volume", r->dropped[i].volume);
        sn_json_vec3(json, "centre", r->dropped[i].centre);
        sn_json_close(json);
    }
    sn_json_close(json);
}

static void write_counts(sn_json *json, const sn_clean_report *r) {
    sn_json_integer(json, "nonfiniteVertices", r->nonfinite_vertices);
    sn_json_number(json, "weldTolerance", r->weld_tolerance);
    sn_json_integer(json, "welded", r->welded);
    sn_json_integer(json, "crackVertices", r->crack_vertices);
    sn_json_number(json, "crackWidth", r->crack_width);
    sn_json_integer(json, "degenerate", r->degenerate);
    sn_json_integer(json, "duplicate", r->duplicate);
    sn_json_integer(json, "unused", r->unused);
    sn_json_integer(json, "wallTriangles", r->wall_triangles);
    sn_json_integer(json, "flippedTriangles", r->flipped_triangles);
    sn_json_integer(json, "splitVertices", r->split_vertices);
    sn_json_integer(json, "stitchedEdges", r->stitched_edges);
    sn_json_integer(json, "holesFilled", r->holes_filled);
    sn_json_integer(json, "flippedComponents", r->flipped_components);
    sn_json_integer(json, "decimatedTriangles", r->decimated_triangles);
    sn_json_integer(json, "flippedSlivers", r->flipped_slivers);
    sn_json_integer(json, "crossingsMade", r->crossings_made);
    sn_json_bool(json, "crossingsUncounted", r->crossings_uncounted);
    sn_json_integer(json, "undoneCrossings", r->undone_crossings);
    sn_json_number(json, "lostArea", r->lost_area);
    sn_json_number(json, "lostShare", r->lost_share);
    sn_json_bool(json, "wrapped", r->wrapped);
    sn_json_number(json, "wrapOffset", r->wrap_offset);
    sn_json_number(json, "wrapAlpha", r->wrap_alpha);
    sn_json_number(json, "volumeChange", r->volume_change);
    sn_json_bool(json, "orientable", r->orientable);
    sn_json_bool(json, "unchanged", r->unchanged);
    sn_json_number(json, "moved", r->moved);
    sn_json_number(json, "hausdorff", r->hausdorff);
}

static void write_report(sn_json *json, const void *data) {
    const result *all = data;
    sn_json_number(json, "metersPerUnit", all->meters_per_unit);
    sn_json_object(json, "before");
    cli_report_mesh(json, &all->report->before);
    sn_json_close(json);
    if (check) return;
    sn_json_object(json, "after");
    cli_report_mesh(json, &all->report->after);
    sn_json_close(json);
    write_counts(json, all->report);
    write_dropped(json, all->report);
    sn_json_object(json, "stageSeconds");
    for (int i = 0; i < all->watch->count; i++) sn_json_number(json, all->watch->stages[i], all->watch->seconds[i]);
    sn_json_close(json);
}

static void say_row(const cli *c, const char *name, double before, double after) { cli_say(c, "%-22s %14.7g %14.7g", name, before, after); }

static void say_table(const cli *c, const sn_mesh_report *b, const sn_mesh_report *a) {
    cli_say(c, "%-22s %14s %14s", "", "before", "after");
    say_row(c, "vertices", b->vertices, a->vertices);
    say_row(c, "triangles", b->triangles, a->triangles);
    say_row(c, "components", b->components, a->components);
    say_row(c, "boundary edges", b->boundary_edges, a->boundary_edges);
    say_row(c, "non-manifold edges", b->nonmanifold_edges, a->nonmanifold_edges);
    say_row(c, "non-manifold vertices", b->nonmanifold_vertices, a->nonmanifold_vertices);
    say_row(c, "inconsistent edges", b->inconsistent_edges, a->inconsistent_edges);
    say_row(c, "duplicate vertices", b->duplicate_vertices, a->duplicate_vertices);
    say_row(c, "duplicate triangles", b->duplicate_triangles, a->duplicate_triangles);
    say_row(c, "degenerate triangles", b->degenerate_triangles, a->degenerate_triangles);
    say_row(c, "slivers", b->sliver_triangles, a->sliver_triangles);
    if (b->self_intersections >= 0) say_row(c, "self-intersections", b->self_intersections, a->self_intersections);
    say_row(c, "genus", b->genus, a->genus);
    say_row(c, "area", b->area, a->area);
    say_row(c, "volume", b->volume, a->volume);
    say_row(c, "edge min", b->edge_min, a->edge_min);
    say_row(c, "edge mean", b->edge_mean, a->edge_mean);
    say_row(c, "edge max", b->edge_max, a->edge_max);
    say_row(c, "worst quality", b->worst_quality, a->worst_quality);
}

/* ---- work ----------------------------------------------------------------------------------------------------------------- */

/* More pieces than this are counted, not named: the report has them all. */
#define MOST_NAMED 5

static void warn_of_losses(const cli *c, const sn_clean_report *r) {
    double area = 0.0;
    for (sn_index i = 0; i < r->dropped_count; i++) area += r->dropped[i].area;
    if (r->dropped_count > 0) {
        cli_warn(c, "dropped %d component%s with %.3g %% of the area; --keep all keeps everything", r->dropped_count,
                 r->dropped_count == 1 ? "" : "s", 100.0 * area / (area + r->after.area));
    }
    for (sn_index i = 0; i < r->dropped_count && i < MOST_NAMED; i++) {
        const sn_dropped_component *d = &r->dropped[i];
        cli_warn(c, "dropped: %d triangle%s, area %.4g, volume %.4g, at %.5g %.5g %.5g", d->triangles, d->triangles == 1 ? "" : "s",
                 d->area, d->volume, d->centre.x, d->centre.y, d->centre.z);
    }
    if (r->dropped_count > MOST_NAMED) cli_warn(c, "and %d smaller ones; --report lists them", r->dropped_count - MOST_NAMED);
    if (r->nonfinite_vertices > 0) cli_warn(c, "dropped %d vertices that are not finite", r->nonfinite_vertices);
}

static void warn_of_changes(const cli *c, const sn_clean_report *r) {
    if (r->crack_vertices > 0) {
        cli_warn(c, "closed cracks up to %.3g wide (%.2g of the diagonal) at %d vertices", r->crack_width,
                 r->crack_width / r->before.diagonal, r->crack_vertices);
    }
    if (r->wrapped) {
        cli_warn(c, "wrapped: a new surface, %.3g away from the old (alpha %.3g), moved by %.3g at most (%.2g %% of the diagonal)",
                 r->wrap_offset, r->wrap_alpha, r->moved, 100.0 * r->moved / r->before.diagonal);
    }
    if (fabs(r->volume_change) > 0.01) cli_warn(c, "the volume has changed by %.2g %%", 100.0 * r->volume_change);
}

static void warn_of_crossings(const cli *c, const sn_clean_report *r) {
    const char *help = r->wrapped || !params.full
                           ? "--repair full wraps such a surface, --remove-intersections replaces triangles that cross"
                           : "--wrap builds a new surface without any";
    if (r->undone_crossings > 0) {
        cli_say(c, "taken back: %d pairs of triangles that crossed after a step and not before it", r->undone_crossings);
    }
    if (r->crossings_made > 0) {
        cli_warn(c, "%d pairs of triangles cross, %d more than the %d of the input; %s", r->after.self_intersections, r->crossings_made,
                 r->before.self_intersections, help);
    }
    if (r->crossings_uncounted) {
        cli_warn(c, "too many triangles lie on one another to count how many cross, before or after; --self-intersections counts however "
                    "long it takes");
    }
}

static void judge(cli *c, const sn_clean_report *r) {
    sn_mesh_report after = r->after;
    if (!params.remove_intersections) after.self_intersections = 0; /* counted on request, not asked to be none */
    if (!params.outward) after.outward = true;
    sentence left = list_defects(&after, 0);
    if (!r->orientable)
        cli_shortfall(c,
                      "the surface is one-sided, like a Moebius strip: it was cut to be oriented; look at the input, or try --repair full");
    else if (left.used > 0)
        cli_shortfall(c, "written, but the surface still has %s", left.text);
    else if (r->flat)
        cli_shortfall(c, "written, but the surface encloses no volume");
    else if (r->lost_share > params.most_lost)
        cli_shortfall(c, "written, but %.3g %% of the area is lost; %s--keep all keeps every piece", 100.0 * r->lost_share,
                      params.full ? "" : "--repair full keeps it, ");
    else if (triangles > 0 && after.triangles > triangles) {
        cli_shortfall(c, "written, but with %d triangles: no more edges can go", after.triangles);
    }
}

static sn_status clean(cli *c, cli_muscle *muscle, sn_error *error) {
    stopwatch watch = {.c = c, .last = cli_seconds()};
    sn_trace trace = {.receive = receive, .user = &watch, .stop_after = c->trace.stop_after};
    sn_clean_report report;
    sn_mesh cleaned = {0};
    params.edge_length = fmax(cli_length(edge_length, muscle->muscle.meters_per_unit), 0.0);
    sn_status status = sn_clean(&muscle->muscle.mesh, &params, &trace, &cleaned, &report, error);
    if (status != SN_OK && status != SN_STOPPED) {
        sn_error_set_file(error, c->inputs.items[0]);
        return status;
    }
    sn_mesh_free(&muscle->muscle.mesh);
    muscle->muscle.mesh = cleaned;
    say_table(c, &report.before, &report.after);
    warn_of_losses(c, &report);
    warn_of_changes(c, &report);
    warn_of_crossings(c, &report);
    sn_status saved = cli_save(c, muscle, report.unchanged ? 0 : SN_SECTION_MESH, error);
    result all = {&report, &watch, muscle->muscle.meters_per_unit};
    if (saved == SN_OK) saved = cli_report(c, write_report, &all, error);
    if (saved == SN_OK && status != SN_STOPPED) judge(c, &report);
    sn_clean_report_free(&report);
    return saved;
}

static sn_status examine(cli *c, const cli_muscle *muscle, sn_error *error) {
    sn_clean_report report = {0};
    const sn_mesh *mesh = &muscle->muscle.mesh;
    sn_status status = sn_mesh_validate(mesh, error);
    if (status == SN_OK) status = sn_mesh_inspect(mesh, &report.before, error);
    if (status == SN_OK && params.count_intersections) {
        status = sn_count_self_intersections(mesh, &report.before.self_intersections, error);
    }
    sn_error_set_file(error, c->inputs.items[0]);
    result all = {&report, NULL, muscle->muscle.meters_per_unit};
    if (status == SN_OK) status = cli_report(c, write_report, &all, error);
    if (status != SN_OK) return status;
    sentence wrong = list_defects(&report.before, params.keep);
    if (wrong.used > 0) cli_shortfall(c, "%s: %s", c->inputs.items[0], wrong.text);
    return SN_OK;
}

int main(int argc, char **argv) {
    cli c;
    cli_muscle muscle = {0};
    sn_error error = {0};
    params = sn_clean_defaults();
    cli_start(&c, &tool, argc, argv);
    take_options(&c);
    sn_status status = cli_load(&c, &muscle, &error);
    if (status == SN_OK) status = check ? examine(&c, &muscle, &error) : clean(&c, &muscle, &error);
    cli_free(&muscle);
    return cli_finish(&c, status, &error);
}
