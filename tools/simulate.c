/*
 * simulate -- move the bones of a scene, contract its muscles, write the frames and what there is to know about them.
 */
#include "bone_frames.h"
#include "cli.h"
#include "contacts.h"
#include "earlier.h"
#include "fibers.h"
#include "frame_files.h"
#include "grips.h"
#include "others.h"
#include "outcome.h"
#include "sinew/error_time.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- options -------------------------------------------------------------------------------------------------------------- */

enum { FORMAT_PC2, FORMAT_PLY };
static const char *const FORMATS[] = {"pc2", "ply", NULL};

typedef struct choices {
    const char *frames, *log, *fail_on, *state, *from, *choose, *bone_frames;
    double rate, preroll, run_in, tolerance, target_error;
    int64_t substeps, iterations, save_every;
    int format, law, solver, scheme, hinges, anisotropy, stretch, preconditioner, precision;
    bool plan, no_sleep, externals, no_externals;
    double external_stiffness;
    fiber_choices fibers;
    contact_choices contact;
    other_choices others;
} choices;

static choices given = {.fibers = {.cut = FIBERS_CUT}};

static const cli_option OPTIONS[] = {
    {0, "frames", "A:B", CLI_TEXT, &given.frames, 0, 0, 0, NULL, "simulate frames A to B instead of the scene's"},
    {0, "rate", "N", CLI_NUMBER, &given.rate, 0, 1e-6, 1e6, NULL, "frames per second instead of the scene's"},
    {0, "preroll", "SECONDS", CLI_NUMBER, &given.preroll, 0, 0, 1e6, NULL, "let it settle this long at the first frame's inputs"},
    {0, "run-in", "SECONDS", CLI_NUMBER, &given.run_in, 0, 0, 1e6, NULL,
     "of the preroll: take the bones from rest to the first frame in this time, then hold"},
    {0, "muscle", "NAME", CLI_LIST, &given.others.muscles, 0, 0, 0, NULL,
     "log and write this muscle alone (* and ? match); others are left out, but for those tied to it; may be given again"},
    {0, "freeze-others", "FOLDER", CLI_TEXT, &given.others.frozen, 0, 0, 0, NULL,
     "with --muscle: those go as an earlier run's frames have them, and are not stepped"},
    {0, "law", "LAW", CLI_CHOICE, &given.law, 0, 0, 0, sn_fiber_law_names, "fibre law of all muscles: projected, paper or isochoric"},
    {0, "anisotropy", "FORM", CLI_CHOICE, &given.anisotropy, 0, 0, 0, sn_anisotropy_names,
     "surface edges along the fibres yield: scheme, none, pbd or xpbd"},
    {0, "stretch", "MODEL", CLI_CHOICE, &given.stretch, 0, 0, 0, sn_stretch_names,
     "what resists the stretching of all surfaces: springs, or (qn) a membrane"},
    {0, NULL, NULL, CLI_HEADING, NULL, 0, 0, 0, NULL, "Solver:"},
    {0, "scheme", "SCHEME", CLI_CHOICE, &given.scheme, 0, 0, 0, sn_scheme_names, "guarded, or a paper to the letter: romeo, kohout"},
    {0, "hinges", "RULE", CLI_CHOICE, &given.hinges, 0, 0, 0, sn_hinge_rule_names,
     "kohout: angles as its program does (published), or as printed"},
    {0, "solver", "METHOD", CLI_CHOICE, &given.solver, 0, 0, 0, sn_solver_method_names,
     "qn or xpbd, with its own defaults, instead of the scene's"},
    {0, "precision", "PRECISION", CLI_CHOICE, &given.precision, 0, 0, 0, sn_precision_names,
     "xpbd: project in double, or in single: faster"},
    {0, "substeps", "N", CLI_AUTO, &given.substeps, 0, 1, 1e6, NULL,
     "substeps per frame instead of the scene's; auto (qn): one, and halves where that is too long"},
    {0, "iterations", "N", CLI_INTEGER, &given.iterations, 0, 1, 1e6, NULL,
     "iterations per substep, where a muscle has no number of its own"},
    {0, "no-sleep", NULL, CLI_FLAG, &given.no_sleep, 0, 0, 0, NULL, "step muscles at rest too"},
    {0, "tolerance", "SHARE", CLI_NUMBER, &given.tolerance, 0, 0, 1, NULL,
     "qn: a substep ends when a whole step moves no point by more than this share of the diagonal"},
    {0, "preconditioner", "MATRIX", CLI_CHOICE, &given.preconditioner, 0, 0, 0, sn_preconditioning_names,
     "qn: scalar, corotated or two-level"},
    {0, "target-error", "E", CLI_NUMBER, &given.target_error, 0, 1e-12, 10, NULL,
     "with --choose: stay within this RMS distance to the true motion, as a share of the diagonal"},
    {0, "choose", "REPORT", CLI_TEXT, &given.choose, CLI_READS, 0, 0, NULL,
     "take the solver setting of error-time's report that reaches --target-error in the least time"},
    {0, NULL, NULL, CLI_HEADING, NULL, 0, 0, 0, NULL, "Output:"},
    {0, "format", "FORMAT", CLI_CHOICE, &given.format, 0, 0, 0, FORMATS, "frames in a folder: pc2 (default) or ply, one file per frame"},
    {0, "bone-frames", "PATH", CLI_TEXT, &given.bone_frames, CLI_WRITES | CLI_FOLDER, 0, 0, NULL,
     "the posed bones: a folder with --format's files for each, or NAME.pvd for all of them as NAME.0000.vtp"},
    {0, "log", "FILE", CLI_TEXT, &given.log, CLI_WRITES | CLI_IN_PLACE, 0, 0, NULL, "write the log to FILE instead of standard output"},
    {0, "state", "FILE", CLI_TEXT, &given.state, CLI_WRITES | CLI_STATE, 0, 0, NULL,
     "write the state to FILE at the end, or where --stop-after stops"},
    {0, "save-every", "N", CLI_INTEGER, &given.save_every, 0, 1, 1e9, NULL, "and after every N frames on the way"},
    {0, "from", "FILE", CLI_TEXT, &given.from, CLI_READS | CLI_STATE, 0, 0, NULL, "go on from the state in FILE: to the same bytes"},
    {0, "plan", NULL, CLI_FLAG, &given.plan, 0, 0, 0, NULL, "print the scene with every default, and what would run; run nothing"},
    {0, "fail-on", "LIST", CLI_TEXT, &given.fail_on, 0, 0, 0, NULL,
     "exit with 3 where a frame breaks one of these: 'volume>0.01,triangle<0.1'"},
    {0, NULL, NULL, CLI_HEADING, NULL, 0, 0, 0, NULL, "Contact with bones, absent unless asked for:"},
    {0, "contact", NULL, CLI_FLAG, &given.contact.on, 0, 0, 0, NULL, "muscles do not enter bones, whatever the scene says"},
    {0, "no-contact", NULL, CLI_FLAG, &given.contact.off, 0, 0, 0, NULL, "they do, whatever it says"},
    {0, "margin", "LENGTH", CLI_LENGTH, &given.contact.margin, 0, 0, 0, NULL,
     "what vertices keep from bones (default: a tenth of the muscle's mean edge)"},
    {0, "resolve", "SECONDS", CLI_NUMBER, &given.contact.resolve, 0, 0, 1e6, NULL,
     "take apart in this time what overlaps at rest (default 0: it stays)"},
    {0, "friction", "F", CLI_NUMBER, &given.contact.friction, 0, 0, 1e6, NULL, "xpbd: Coulomb's coefficient (default 0)"},
    {0, "contact-samples", "N", CLI_INTEGER, &given.contact.samples, 0, 0, 3, NULL, "hold 1 or 3 points inside each triangle out, too"},
    {0, "grid-cell", "LENGTH", CLI_LENGTH, &given.contact.cell, 0, 0, 0, NULL,
     "of the bones' distance fields (default: a third of the finest mean edge in reach, or a sixth of the bone's thickness)"},
    {0, "grid-cache", "FOLDER", CLI_TEXT, &given.contact.cache, CLI_WRITES | CLI_FOLDER | CLI_CACHE, 0, 0, NULL,
     "keep these fields in FOLDER for the next run"},
    {0, "collision", "HOW", CLI_CHOICE, &given.contact.collision, 0, 0, 0, sn_collision_names,
     "scheme (default), field or, under xpbd, voxel: Kohout and Cervenka's, which the scheme kohout means"},
    {0, "voxels", "N", CLI_TEXT, &given.contact.voxels, 0, 0, 0, NULL,
     "voxel: N along each axis of a bone (default 64); total:N for about N in all, as near to cubes as that goes"},
    {0, "bone-hits", "WHAT", CLI_CHOICE, &given.contact.bone_hits, 0, 0, 0, sn_bone_hits_names,
     "voxel: vertices onto which a bone moves follow it (default), follow it and stop, or are ignored"},
    {0, NULL, NULL, CLI_HEADING, NULL, 0, 0, 0, NULL, "External constraints, absent unless asked for:"},
    {0, "externals", NULL, CLI_FLAG, &given.externals, 0, 0, 0, NULL,
     "the candidates of attach-detect --glue tie muscles to each other and to surfaces, whatever the scene says"},
    {0, "no-externals", NULL, CLI_FLAG, &given.no_externals, 0, 0, 0, NULL, "they do not, whatever it says"},
    {0, "external-stiffness", "FACTOR", CLI_NUMBER, &given.external_stiffness, 0, 0, 1e12, NULL,
     "over that of the muscle's edges (default 10)"},
    {0, NULL, NULL, CLI_HEADING, NULL, 0, 0, 0, NULL, "Fibres through the volume, absent unless asked for:"},
    {0, "fibers", NULL, CLI_FLAG, &given.fibers.frames, 0, 0, 0, NULL, "with -o: their frames too, as VTP, PVD and PC2"},
    {0, "lengths", "FILE", CLI_TEXT, &given.fibers.lengths, CLI_WRITES, 0, 0, NULL,
     "the length of every fibre over time, m: FILE.sto for OpenSim, else tab-separated"},
    {0, "smooth-lengths", NULL, CLI_FLAG, &given.fibers.smooth, 0, 0, 0, NULL, "smooth them: five times (l-1 + 4 l + l+1) / 6"},
    {0, "blend", "EXPONENT", CLI_NUMBER, &given.fibers.blend, 0, 1e-3, 1e3, NULL,
     "compare with fibres that are blended between the bones at their ends"},
    {0, "penetration", NULL, CLI_FLAG, &given.fibers.penetration, 0, 0, 0, NULL, "log the fibre vertices inside bones, and the deepest"},
    {0, "mvc-cut", "W", CLI_NUMBER, &given.fibers.cut, 0, 0, 0.09, NULL,
     "drop weights that bind them below W and correct the rest (default 3e-4); 0 keeps all"},
    {0, "embedding-cache", "FOLDER", CLI_TEXT, &given.fibers.cache, CLI_WRITES | CLI_FOLDER | CLI_CACHE, 0, 0, NULL,
     "keep these weights in FOLDER for the next run"},
};

static const cli_tool TOOL = {
    .name = "simulate",
    .summary = "Simulate the muscles of a scene; the log goes to standard output, the frames where -o says.",
    .shared =
        CLI_TAKES_INPUT | CLI_HAS_OUTPUT | CLI_HAS_STRICT | CLI_HAS_TRACE | CLI_OWN_STOP | CLI_HAS_REPORT | CLI_HAS_THREADS | CLI_HAS_SPACE,
    .options = OPTIONS,
    .option_count = sizeof OPTIONS / sizeof *OPTIONS,
    .notes = "-o is NAME.pc2 for one muscle, or a folder with one cache per muscle. --stop-after takes FRAME[:SUBSTEP[:ITERATION]].\n"
             "--fail-on knows volume, nan, triangle, edge, torn, penetration, entered, internal, radial, mesh, dihedral, area, "
             "membrane, external, contact, energy,\n"
             "elastic, residual, skipped and clamped; '<' and '>' compare.",
};

/* "A:B" or "A" into whole numbers; unset parts keep their value. Returns how many there were; 0 = not of this form. */
static int parse_parts(const char *text, int most, sn_index *parts) {
    const char *end = text + strlen(text);
    for (int count = 0; count < most;) {
        int64_t value;
        if (!sn_scan_integer(text, end, &text, &value) || value < -SN_INDEX_MAX || value > SN_INDEX_MAX) return 0;
        parts[count++] = (sn_index)value;
        if (text == end) return count;
        if (*text++ != ':') return 0;
    }
    return 0;
}

/* ---- the run -------------------------------------------------------------------------------------------------------------- */

/* Where one muscle's frames go. */
typedef struct target {
    char *path;    /* the cache; or "FOLDER/NAME" for a sequence */
    sn_pc2 *cache; /* NULL for a sequence */
    sn_mesh mesh;  /* of a sequence: triangles as in the document */
    sn_vec3 *positions;
} target;

typedef struct job {
    cli c;
    sn_scene scene;
    sn_model *model;
    sn_state *state;
    sn_pool *pool;
    sn_output *log;
    target *targets; /* (muscle_count); NULL = no frames */
    fiber_run fibers;
    contact_run contact;
    bone_run bones;
    outcome outcome;
    sn_index stop[3];     /* frame, substep, iteration */
    int stop_parts;       /* how many of them were given */
    sn_index continued;   /* targets that go on with what is there */
    sn_resume resume;     /* with --from */
    sn_index first, last; /* frames that the run writes: the scene's, or what is left of them after a state's (choose_range) */
    double setup_seconds;
    bool exploded; /* the run ended at a frame that is not finite, which is not written */
} job;

/* The method asked for, with its own defaults; a paper's scheme and single precision ask for xpbd. */
static void choose_method(job *j) {
    sn_solver_settings *solver = &j->scene.solver;
    bool papers = (cli_given(&j->c, "scheme") && given.scheme != SN_SCHEME_GUARDED) ||
                  (cli_given(&j->c, "precision") && given.precision != SN_PRECISION_DOUBLE) ||
                  (cli_given(&j->c, "anisotropy") && given.anisotropy == SN_ANISOTROPY_PBD);
    if (cli_given(&j->c, "solver"))
        sn_solver_change(solver, (sn_solver_method)given.solver);
    else if (papers)
        sn_solver_change(solver, SN_SOLVER_XPBD);
}

static void apply_externals(job *j) {
    sn_external_settings *externals = &j->scene.externals;
    if (given.externals && given.no_externals) cli_usage_error(&j->c, "--externals and --no-externals exclude each other");
    if (given.externals) externals->enabled = true;
    if (given.no_externals) externals->enabled = false;
    if (cli_given(&j->c, "external-stiffness")) externals->stiffness = given.external_stiffness;
    if (cli_given(&j->c, "external-stiffness") && !externals->enabled)
        cli_warn(&j->c, "--external-stiffness has no effect: external constraints are off (--externals turns them on)");
    if (externals->enabled && j->scene.solver.method == SN_SOLVER_XPBD &&
        (j->scene.solver.scheme == SN_SCHEME_KOHOUT || j->scene.solver.precision == SN_PRECISION_SINGLE))
        cli_warn(&j->c, "external constraints are left out: they run under qn, and under xpbd in double by the schemes guarded and romeo");
}

static void apply_options(job *j) {
    sn_scene *scene = &j->scene;
    sn_index range[2];
    if (given.frames != NULL) {
        if (parse_parts(given.frames, 2, range) != 2 || range[0] > range[1])
            cli_usage_error(&j->c, "--frames %s: write A:B with A not greater than B", given.frames);
        if (range[0] < -SN_FRAME_LIMIT || range[1] > SN_FRAME_LIMIT)
            cli_usage_error(&j->c, "--frames %s: frames go from %d to %d", given.frames, -SN_FRAME_LIMIT, SN_FRAME_LIMIT);
        scene->first_frame = range[0];
        scene->last_frame = range[1];
    }
    if (cli_given(&j->c, "rate")) scene->rate = given.rate;
    if (cli_given(&j->c, "preroll")) scene->preroll = given.preroll;
    if (cli_given(&j->c, "run-in")) scene->run_in = given.run_in;
    choose_method(j);
    if (cli_given(&j->c, "tolerance")) scene->solver.tolerance = given.tolerance;
    if (cli_given(&j->c, "substeps")) scene->solver.substeps = (sn_index)given.substeps;
    if (cli_given(&j->c, "substeps") && given.substeps == SN_SUBSTEPS_AUTO && scene->solver.method != SN_SOLVER_QN)
        cli_usage_error(&j->c, "--substeps auto is for the solver qn; give a number, or choose that solver");
    if (cli_given(&j->c, "iterations")) scene->solver.iterations = (sn_index)given.iterations;
    for (sn_index i = 0; cli_given(&j->c, "law") && i < scene->muscle_count; i++) scene->muscles[i].law = (sn_fiber_law)given.law;
    for (sn_index i = 0; cli_given(&j->c, "anisotropy") && i < scene->muscle_count; i++)
        scene->muscles[i].anisotropy = (sn_anisotropy)given.anisotropy;
    for (sn_index i = 0; cli_given(&j->c, "stretch") && i < scene->muscle_count; i++) scene->muscles[i].stretch = (sn_stretch)given.stretch;
    if (cli_given(&j->c, "preconditioner")) scene->solver.preconditioner = (sn_preconditioning)given.preconditioner;
    if (given.no_sleep) scene->solver.sleep = false;
    if (cli_given(&j->c, "scheme")) scene->solver.scheme = (sn_scheme)given.scheme;
    if (cli_given(&j->c, "hinges")) scene->solver.hinges = (sn_hinge_rule)given.hinges;
    if (cli_given(&j->c, "precision")) scene->solver.precision = (sn_precision)given.precision;
    if (j->c.threads > 0) scene->solver.threads = j->c.threads;
    apply_externals(j);
    contacts_apply(&j->c, &given.contact, scene);
}

static void parse_stop(job *j) {
    const char *text = j->c.stop_after;
    if (text == NULL) return;
    j->stop_parts = parse_parts(text, 3, j->stop);
    bool good = j->stop_parts > 0 && (j->stop_parts < 2 || j->stop[1] > 0) && (j->stop_parts < 3 || j->stop[2] > 0);
    if (!good) cli_usage_error(&j->c, "--stop-after %s: write FRAME[:SUBSTEP[:ITERATION]], the last two from 1", text);
}

/* A run starts with the scene's first frame, which has no substeps, or goes on in or after the frame of a state. */
static void check_stop(const job *j, sn_index first, bool whole) {
    if (j->stop_parts == 0) return;
    if (j->stop[0] < first || (whole && j->stop_parts > 1 && j->stop[0] == first))
        cli_usage_error(&j->c, "--stop-after %s: the run starts at frame %d%s", j->c.stop_after, (int)first,
                        whole && j->stop_parts > 1 ? ", which has no substeps" : "");
    if (j->stop[0] > j->last) cli_usage_error(&j->c, "--stop-after %s: the run ends with frame %d", j->c.stop_after, (int)j->last);
    if (j->stop_parts > 1 && j->stop[1] > sn_solver_substeps(&j->scene.solver))
        cli_usage_error(&j->c, "--stop-after %s: a frame has %d substeps", j->c.stop_after, (int)sn_solver_substeps(&j->scene.solver));
}

/* ---- --choose ------------------------------------------------------------------------------------------------------------- */

static void check_choice(const job *j) {
    static const char *const excluded[] = {"solver",         "scheme",   "hinges",     "precision",
                                           "preconditioner", "substeps", "iterations", "tolerance"};
    if (cli_given(&j->c, "choose") != cli_given(&j->c, "target-error"))
        cli_usage_error(&j->c, "--choose REPORT and --target-error E go together");
    for (size_t i = 0; given.choose != NULL && i < sizeof excluded / sizeof *excluded; i++)
        if (cli_given(&j->c, excluded[i])) cli_usage_error(&j->c, "--choose and --%s exclude each other", excluded[i]);
}

/* Has the report the scene's enabled muscles, in their order? */
static bool same_muscles(const sn_error_time *report, const sn_scene *scene) {
    sn_index n = 0;
    for (sn_index i = 0; i < scene->muscle_count; i++) {
        const sn_scene_muscle *m = &scene->muscles[i];
        if (!m->enabled) continue;
        if (n == report->muscle_count || m->name == NULL || strcmp(m->name, report->muscle_names[n]) != 0) return false;
        if (m->rig.mesh.vertex_count != report->muscle_vertices[n++]) return false;
    }
    return n == report->muscle_count;
}

static sn_status take_setting(job *j, const sn_error_time *report, const char *hash, sn_error *error) {
    char words[SN_SETTING_LENGTH + 128];
    if (!same_muscles(report, &j->scene))
        return sn_fail(error, SN_ERROR_INPUT, "is the report of another scene: its muscles are not those of this one");
    if (strcmp(report->scene_hash, hash) != 0) cli_warn(&j->c, "the scene has changed since %s was made", given.choose);
    const sn_error_point *point = sn_error_time_cheapest(report, given.target_error, NULL);
    if (point == NULL)
        return sn_fail(error, SN_ERROR_INPUT,
                       "no setting reaches an error of %g (with the floor of %.2g on top); measure more with error-time",
                       given.target_error, report->reference.floor);
    sn_error_time_words(report, point, sizeof words, words);
    cli_say(&j->c, "chosen for an error of %g: %s", given.target_error, words);
    sn_setting_apply(&report->settings[point->setting].setting, &j->scene);
    return SN_OK;
}

static sn_status choose_setting(job *j, const sn_blob *scene, sn_error *error) {
    sn_error_time report = {0};
    sn_blob blob = {0};
    char hash[SN_HASH_LENGTH];
    if (given.choose == NULL) return SN_OK;
    sn_hash(scene->data, scene->size, hash);
    sn_status status = sn_blob_read(given.choose, &blob, error);
    if (status == SN_OK) status = sn_error_time_parse(&blob, &report, error);
    if (status == SN_OK) status = take_setting(j, &report, hash, error);
    if (status != SN_OK) sn_error_set_file(error, given.choose);
    sn_error_time_free(&report);
    sn_blob_free(&blob);
    return status;
}

static sn_status make_model(job *j, sn_error *error) {
    if ((j->pool = sn_pool_create(j->scene.solver.threads)) == NULL) return sn_fail_memory(error, "the run");
    j->contact = (contact_run){.c = &j->c, .cache = given.contact.cache};
    return contacts_model(&j->contact, &j->scene, j->pool, &j->model, error);
}

static sn_status load_scene(job *j, sn_error *error) {
    sn_blob blob = {0};
    sn_status status = sn_blob_read(j->c.inputs.items[0], &blob, error);
    if (status != SN_OK) return status;
    bool bones = given.fibers.penetration || given.bone_frames != NULL || contacts_wanted(&j->c, &given.contact) || given.externals;
    status = sn_scene_parse(&blob, bones, &j->scene, error);
    if (status == SN_OK && !bones) status = sn_scene_check_bones(blob.name, &j->scene, error);
    if (status == SN_OK) status = choose_setting(j, &blob, error);
    if (status == SN_OK) {
        apply_options(j);
        if (given.frames != NULL || cli_given(&j->c, "rate")) sn_scene_warn_of_times(&j->scene);
        j->first = j->scene.first_frame, j->last = j->scene.last_frame;
        if (given.from == NULL) check_stop(j, j->first, true);
        status = others_apply(&j->c, &given.others, &j->scene, error);
    }
    if (status == SN_OK) { status = make_model(j, error); }
    if (status != SN_OK) sn_error_set_file(error, blob.name);
    sn_blob_free(&blob);
    return status;
}

/* ---- the state ------------------------------------------------------------------------------------------------------------ */

/* What is left of the frames after a state's. --frames says which they are: from the state's frame, or the one that comes next. */
static void choose_range(job *j) {
    sn_index frame = j->state->frame, next = sn_state_next_frame(j->state), first = j->scene.first_frame, last = j->scene.last_frame;
    const char *at = next == frame ? "stopped in the middle of" : "is at";
    if (next > last)
        cli_usage_error(&j->c, "--from %s: the state %s frame %d, and the run ends at %d; write --frames %d:B with B from %d on",
                        given.from, at, (int)frame, (int)last, (int)next, (int)next);
    if (given.frames != NULL && first != frame && first != next)
        cli_usage_error(&j->c, "--frames %s: the state in %s %s frame %d; to go on from there write --frames %d:%d", given.frames,
                        given.from, at, (int)frame, (int)next, (int)last);
    if (first > frame && first != next)
        cli_usage_error(&j->c, "--from %s: the state %s frame %d, before the scene's first, %d; to go on from there write --frames %d:%d",
                        given.from, at, (int)frame, (int)first, (int)next, (int)last);
    j->first = next;
    j->resume = (sn_resume){.frame = frame, .next = next, .rate = j->scene.rate, .reached = frame};
    check_stop(j, next, false);
}

static sn_status read_state(job *j, sn_error *error) {
    sn_blob blob = {0};
    sn_status status = sn_blob_read(given.from, &blob, error);
    if (status == SN_OK) status = sn_state_unpack(j->model, blob.data, blob.size, j->state, error);
    if (status != SN_OK) sn_error_set_file(error, given.from);
    sn_blob_free(&blob);
    if (status == SN_OK) choose_range(j);
    return status;
}

static sn_status write_state(const job *j, sn_error *error) {
    char *bytes = NULL;
    size_t size = 0;
    sn_output *output = NULL;
    sn_status status = sn_state_pack(j->model, j->state, &bytes, &size, error);
    if (status == SN_OK) status = sn_output_open(given.state, false, &output, error);
    if (status == SN_OK) status = sn_output_write(output, bytes, size, error);
    free(bytes);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

static sn_status save_now_and_then(const job *j, sn_error *error) {
    if (!cli_given(&j->c, "save-every") || ((int64_t)j->state->frame - j->first) % given.save_every != 0) return SN_OK;
    return write_state(j, error);
}

/* ---- muscles that are seen ---------------------------------------------------------------------------------------------------- */

static bool is_seen(const job *j, sn_index muscle) { return !j->model->muscles[muscle].source->unseen; }

static sn_index seen_count(const job *j) {
    sn_index count = 0;
    for (sn_index i = 0; i < j->model->muscle_count; i++) count += is_seen(j, i);
    return count;
}

/* ---- frames --------------------------------------------------------------------------------------------------------------- */

static const char *extension(const char *path) {
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash != NULL ? slash : path, '.');
    return dot != NULL ? dot : "";
}

/* One cache in a file of its own, or one or several in a folder? Says why where neither fits. */
static bool one_file(const job *j) {
    const char *output = j->c.output;
    if (strcmp(output, "-") == 0) cli_usage_error(&j->c, "frames cannot go to standard output; name a file or a folder with -o");
    if (frame_folder_is(output) || extension(output)[0] == '\0' || output[strlen(output) - 1] == '/') return false;
    if (given.format == FORMAT_PLY || strcmp(extension(output), ".ply") == 0)
        cli_usage_error(&j->c, "a PLY sequence needs a folder: -o FOLDER --format ply");
    if (strcmp(extension(output), ".pc2") != 0) cli_usage_error(&j->c, "-o %s: frames are written as NAME.pc2 or into a folder", output);
    if (seen_count(j) > 1) cli_usage_error(&j->c, "%d muscles do not fit into one cache: give -o a folder", (int)seen_count(j));
    return true;
}

/* Frames that will be written, as far as --stop-after lets the run go. */
static frame_range range_of(const job *j) {
    sn_index last = j->stop_parts > 0 && j->stop[0] < j->last ? j->stop[0] : j->last;
    return (frame_range){.first = j->first, .last = last, .goes_on = given.from != NULL};
}

static sn_resume *resume_of(job *j) { return given.from != NULL ? &j->resume : NULL; }

/* Is there one to go on with? */
static sn_status resume_target(job *j, sn_index muscle, sn_error *error) {
    target *t = &j->targets[muscle];
    bool goes_on = false;
    sn_vec3 *positions = given.format == FORMAT_PC2 ? t->positions : t->mesh.positions;
    sn_state_positions(j->model, j->state, muscle, positions);
    sn_status status = given.format == FORMAT_PLY
                           ? earlier_sequence(t->path, &t->mesh, &j->resume, &goes_on, error)
                           : sn_pc2_resume(t->path, j->model->muscles[muscle].vertex_count, &j->resume, positions, &t->cache, error);
    j->continued += goes_on || t->cache != NULL;
    return status;
}

static sn_status open_target(job *j, sn_index muscle, bool file, sn_error *error) {
    const sn_model_muscle *m = &j->model->muscles[muscle];
    target *t = &j->targets[muscle];
    const char *suffix = given.format == FORMAT_PC2 ? ".pc2" : "";
    t->path = file ? sn_strdup(j->c.output) : frame_path(j->c.output, m->source->name, suffix);
    t->positions = SN_NEW(sn_vec3, m->vertex_count);
    if (t->path == NULL || t->positions == NULL) return sn_fail_memory(error, "the frames");
    const fiber_start start = {.range = range_of(j), .resume = resume_of(j)};
    sn_status status = SN_OK;
    if (given.format == FORMAT_PLY) status = frame_sequence_check(t->path, ".ply", &start.range, error);
    if (given.format == FORMAT_PLY && status == SN_OK) status = sn_mesh_copy(&m->source->rig.mesh, &t->mesh, error);
    if (status == SN_OK && given.from != NULL) status = resume_target(j, muscle, error);
    if (status == SN_OK) status = fibers_open_frames(&j->fibers, muscle, t->path, &start, error);
    if (status != SN_OK || given.format == FORMAT_PLY || t->cache != NULL) return status;
    return sn_pc2_create(t->path, m->vertex_count, j->first, 1.0, &t->cache, error);
}

/* Would two of them be one file in the folder? That of b's fibres is named after b's. */
static bool files_clash(const char *a, const char *b) {
    return frame_names_clash(a, b, "") || (given.fibers.frames && frame_names_clash(a, b, FIBERS_SUFFIX));
}

static sn_status check_names(const job *j, sn_error *error) {
    for (sn_index i = 0; i < j->model->muscle_count; i++)
        for (sn_index k = 0; k < j->model->muscle_count; k++) {
            const char *a = j->model->muscles[i].source->name, *b = j->model->muscles[k].source->name;
            if (k != i && is_seen(j, i) && is_seen(j, k) && files_clash(a, b))
                return sn_fail(error, SN_ERROR_INPUT, "the muscles \"%s\" and \"%s\" would share a file of frames; rename one", a, b);
        }
    return SN_OK;
}

static sn_status open_targets(job *j, sn_error *error) {
    if (!cli_given(&j->c, "output")) return SN_OK;
    bool file = one_file(j);
    sn_status status = check_names(j, error);
    if (status == SN_OK && !file) status = frame_folder_make(j->c.output, error);
    if (status == SN_OK && (j->targets = SN_NEW(target, j->model->muscle_count)) == NULL) status = sn_fail_memory(error, "the frames");
    for (sn_index i = 0; status == SN_OK && i < j->model->muscle_count; i++)
        if (is_seen(j, i)) status = open_target(j, i, file, error);
    return status == SN_OK ? earlier_whole(j->c.output, j->continued, seen_count(j), error) : status;
}

static sn_status open_bones(job *j, sn_error *error) {
    const bone_request request = {.path = given.bone_frames,
                                  .ply = given.format == FORMAT_PLY,
                                  .output = cli_given(&j->c, "output") ? j->c.output : NULL,
                                  .range = range_of(j),
                                  .resume = resume_of(j),
                                  .at = j->state};
    return bone_frames_open(&j->bones, &j->c, &request, &j->scene, error);
}

static sn_status write_frames(job *j, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; j->targets != NULL && status == SN_OK && i < j->model->muscle_count; i++) {
        target *t = &j->targets[i];
        if (!is_seen(j, i)) continue;
        sn_state_positions(j->model, j->state, i, t->cache != NULL ? t->positions : t->mesh.positions);
        status =
            t->cache != NULL ? sn_pc2_append(t->cache, t->positions, error) : frame_write_ply(t->path, j->state->frame, &t->mesh, error);
        if (status == SN_OK && t->cache != NULL) status = sn_pc2_publish(t->cache, error);
    }
    return status;
}

/* The first failure is kept, and what comes after it is done all the same. */
static void keep_first(sn_status *status, sn_status next) {
    if (*status == SN_OK) *status = next;
}

static sn_status commit_targets(job *j, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; j->targets != NULL && i < j->model->muscle_count; i++) {
        sn_pc2 *cache = j->targets[i].cache;
        j->targets[i].cache = NULL;
        if (cache != NULL) keep_first(&status, sn_pc2_commit(cache, status == SN_OK ? error : NULL));
    }
    keep_first(&status, bone_frames_commit(&j->bones, status == SN_OK ? error : NULL));
    keep_first(&status, fibers_commit(&j->fibers, status == SN_OK ? error : NULL));
    return status;
}

static void free_targets(job *j) {
    for (sn_index i = 0; j->targets != NULL && i < j->model->muscle_count; i++) {
        sn_pc2_abort(j->targets[i].cache);
        sn_mesh_free(&j->targets[i].mesh);
        free(j->targets[i].positions);
        free(j->targets[i].path);
    }
    free(j->targets);
}

/* ---- the log -------------------------------------------------------------------------------------------------------------- */

static void write_errors(sn_json *json, const sn_statistics *s, const sn_plan_muscle *plan) {
    sn_json_object(json, "errors");
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        if (plan->groups[kind].rows == 0 || sn_row_info_of((sn_row_kind)kind)->points == 0) continue;
        sn_json_object(json, sn_row_kind_name((sn_row_kind)kind));
        sn_json_number(json, "rms", s->residuals[kind].rms);
        sn_json_number(json, "max", s->residuals[kind].max);
        sn_json_close(json);
    }
    sn_json_close(json);
}

static void write_quasi_newton(sn_json *json, const sn_statistics *s) {
    sn_json_integer(json, "substeps", s->steps);
    sn_json_integer(json, "iterations", s->iterations);
    if (s->halvings > 0) sn_json_integer(json, "halvings", s->halvings);
    sn_json_integer(json, "rejected_steps", s->rejected_steps);
    sn_json_integer(json, "refactorisations", s->refactorisations);
    sn_json_integer(json, "restarts", s->restarts);
    sn_json_text(json, "stopped_by", sn_stop_reason_name(s->stop_reason));
}

static void write_entered(const job *j, sn_index muscle, const sn_plan_muscle *plan, sn_json *json) {
    const sn_statistics *s = &j->state->muscles[muscle].statistics;
    if (plan->groups[SN_ROWS_EXTERNAL].rows == 0) return;
    sn_json_number(json, "entered", s->entered);
    if (s->entered_vertex == SN_NONE) return;
    sn_json_integer(json, "entered_vertex", s->entered_vertex);
    sn_json_text(json, "entered_target", sn_model_target_name(j->model, muscle, s->entered_target));
}

/* ---- groups of muscles ------------------------------------------------------------------------------------------------------ */

static sn_index members_of(const sn_model *model, sn_index group) {
    sn_index members = 0;
    for (sn_index i = 0; i < model->muscle_count; i++) members += model->muscles[i].group == group;
    return members;
}

/* Farther from its end; of two that are as far the one whose name comes first, whatever their order in the scene. */
static bool is_worse(const job *j, sn_index muscle, sn_index other) {
    double a = j->state->muscles[muscle].statistics.residual, b = j->state->muscles[other].statistics.residual;
    return a > b || (a == b && strcmp(j->model->muscles[muscle].source->name, j->model->muscles[other].source->name) < 0);
}

/* Of the group of a muscle that is tied to others: who keeps it from its end. */
static void write_group_of(const job *j, sn_index muscle, sn_json *json) {
    const sn_model *model = j->model;
    sn_index group = model->muscles[muscle].group, worst = muscle;
    if (members_of(model, group) < 2) return;
    for (sn_index i = 0; i < model->muscle_count; i++)
        if (model->muscles[i].group == group && is_worse(j, i, worst)) worst = i;
    sn_json_text(json, "group_worst", model->muscles[worst].source->name);
    sn_json_number(json, "group_residual", j->state->muscles[worst].statistics.residual);
}

/* What the scalar matrix of a group costs: the best of a few factors and solves. */
static void write_matrix(const job *j, sn_json *json, sn_index group) {
    double factor = INFINITY, solve = INFINITY;
    sn_trial_matrix *trial = NULL;
    if (j->scene.solver.method != SN_SOLVER_QN) return;
    bool works = sn_trial_matrix_create(j->model, group, &trial, NULL) == SN_OK && sn_trial_matrix_factor(trial, NULL) == SN_OK;
    for (int k = 0; k < 3 && works; k++) {
        double started = cli_seconds();
        works = sn_trial_matrix_factor(trial, NULL) == SN_OK;
        factor = fmin(factor, cli_seconds() - started), started = cli_seconds();
        works = works && sn_trial_matrix_solve(trial, NULL) == SN_OK;
        solve = fmin(solve, cli_seconds() - started);
    }
    if (works) {
        sn_json_object(json, "matrix");
        sn_json_integer(json, "entries", sn_trial_matrix_entries(trial));
        sn_json_integer(json, "bytes", (int64_t)sn_trial_matrix_bytes(trial));
        sn_json_number(json, "factorMilliseconds", 1e3 * factor);
        sn_json_number(json, "solveMilliseconds", 1e3 * solve);
        sn_json_close(json);
    }
    sn_trial_matrix_destroy(trial);
}

static void write_statistics(const job *j, sn_json *json, sn_index muscle, const sn_plan_muscle *plan, bool stopped) {
    const sn_statistics *s = &j->state->muscles[muscle].statistics;
    sn_json_object(json, NULL);
    sn_json_integer(json, "frame", j->state->frame);
    if (stopped) sn_json_integer(json, "substep", j->stop[1]);
    if (stopped && j->stop_parts > 2) sn_json_integer(json, "iteration", j->stop[2]);
    sn_json_number(json, "time", j->state->frame / j->scene.rate);
    sn_json_text(json, "muscle", plan->name);
    sn_json_number(json, "activation", s->activation);
    sn_json_number(json, "volume_ratio", s->volume_ratio);
    sn_json_number(json, "volume_goal", s->volume_goal);
    sn_json_number(json, "volume_error", s->volume_error);
    write_errors(json, s, plan);
    sn_json_number(json, "smallest_triangle", s->smallest_triangle);
    sn_json_number(json, "largest_edge_ratio", s->largest_edge_ratio);
    sn_json_bool(json, "torn", s->torn);
    sn_json_number(json, "residual", s->residual);
    sn_json_number(json, "kinetic_energy", s->kinetic_energy);
    sn_json_number(json, "elastic_energy", s->elastic_energy);
    sn_json_integer(json, "nan", s->nan_points);
    sn_json_bool(json, "asleep", s->asleep);
    sn_json_integer(json, "skipped_edges", s->skipped_edges);
    sn_json_integer(json, "skipped_hinges", s->skipped_hinges);
    sn_json_integer(json, "clamped_hinges", s->clamped_hinges);
    sn_json_integer(json, "held_triangles", s->held_triangles);
    sn_json_integer(json, "skipped_triangles", s->skipped_triangles);
    if (j->scene.solver.method == SN_SOLVER_QN) write_quasi_newton(json, s);
    contacts_log(j->model, s, plan, json);
    write_entered(j, muscle, plan, json);
    write_group_of(j, muscle, json);
    fibers_log(&j->fibers, muscle, json);
    sn_json_close(json);
}

static const sn_plan_muscle *plan_of(const job *j, sn_index muscle) {
    return &j->model->plan.muscles[j->model->muscles[muscle].source - j->scene.muscles];
}

static sn_status write_log(job *j, bool stopped, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; status == SN_OK && i < j->model->muscle_count; i++) {
        if (!is_seen(j, i)) continue;
        sn_json *json = sn_json_begin(j->log, false);
        if (json == NULL) return sn_fail_memory(error, "the log");
        write_statistics(j, json, i, plan_of(j, i), stopped);
        status = sn_json_end(json, error);
    }
    return status;
}

/* ---- frame after frame ------------------------------------------------------------------------------------------------------ */

/* Do the caches hold every coordinate? */
static sn_status check_caches(job *j, sn_error *error) {
    for (sn_index i = 0; j->targets != NULL && given.format == FORMAT_PC2 && i < j->model->muscle_count; i++) {
        const sn_vec3 *p = j->targets[i].positions;
        if (!is_seen(j, i)) continue;
        sn_state_positions(j->model, j->state, i, j->targets[i].positions);
        for (sn_index k = 0; k < j->model->muscles[i].vertex_count; k++)
            if (fmax(fabs(p[k].x), fmax(fabs(p[k].y), fabs(p[k].z))) > (double)FLT_MAX)
                return outcome_overflows(&j->outcome, j->state, i, given.state != NULL, error);
    }
    return SN_OK;
}

/* seconds: of its step; NaN where the run begins with it. SN_STOPPED: it is not finite, and the run ends with the one before. */
static sn_status finish_frame(job *j, bool stopped, double seconds, sn_error *error) {
    fibers_move(&j->fibers, j->state);
    sn_status status = write_log(j, stopped, error);
    if (status == SN_OK) status = outcome_check(&j->outcome, j->state, given.state != NULL, error);
    if (status == SN_OK) status = check_caches(j, error);
    j->exploded = status == SN_STOPPED;
    if (status == SN_OK) status = write_frames(j, error);
    if (status == SN_OK) status = bone_frames_write(&j->bones, j->state, error);
    if (status == SN_OK) status = fibers_write(&j->fibers, j->state->frame, error);
    if (status == SN_OK && !stopped) status = save_now_and_then(j, error);
    if (status == SN_OK) status = outcome_take(&j->outcome, j->state, seconds, error);
    cli_progress(&j->c, (int64_t)j->state->frame - j->first, (int64_t)j->last - j->first, "frame");
    return status;
}

static sn_status next_frame(job *j, sn_error *error) {
    bool last = j->stop_parts > 0 && sn_state_next_frame(j->state) == j->stop[0];
    sn_step_options options = {.pool = j->pool, .trace = &j->c.trace};
    if (last && j->stop_parts > 1) options.stop_substep = j->stop[1];
    if (last && j->stop_parts > 2) options.stop_iteration = j->stop[2];
    double started = cli_seconds();
    sn_status status = sn_step(j->model, j->state, &options, error);
    double seconds = cli_seconds() - started;
    if (status != SN_OK && status != SN_STOPPED) return status;
    sn_status finished = finish_frame(j, status == SN_STOPPED, seconds, error);
    return finished != SN_OK ? finished : last ? SN_STOPPED : status;
}

static sn_status run_frames(job *j, sn_error *error) {
    sn_step_options options = {.pool = j->pool, .trace = &j->c.trace, .watch = outcome_run_in, .user = &j->outcome};
    sn_status status = given.from != NULL ? SN_OK : sn_settle(j->model, j->state, &options, error);
    if (status == SN_OK && given.from == NULL) {
        status = finish_frame(j, false, NAN, error);
        if (status == SN_OK && j->stop_parts > 0 && j->stop[0] == j->first) return SN_STOPPED;
    }
    while (status == SN_OK && sn_state_next_frame(j->state) <= j->last) status = next_frame(j, error);
    return status;
}

static sn_status open_log(job *j, sn_error *error) {
    if (given.from != NULL) {
        sn_status status = earlier_log(given.log, j->model, &j->resume, &j->log, error);
        if (status != SN_OK || j->log != NULL) return status;
    }
    return sn_output_open(given.log, true, &j->log, error);
}

static void say_resumed(const job *j) {
    const sn_resume *r = &j->resume;
    if (r->continued > 0) cli_say(&j->c, "goes on with %d outputs behind frame %d", (int)r->continued, (int)r->next - 1);
    if (r->reached > r->frame)
        cli_tell(&j->c, "%s and what belongs to it go to frame %d, beyond the state's, %d: what is behind that is cut off and made anew",
                 r->name, (int)r->reached, (int)r->frame);
}

static sn_status prepare(job *j, sn_error *error) {
    sn_status status = outcome_start(&j->outcome, j->model, error);
    if (status == SN_OK) status = sn_state_create(j->model, &j->state, error);
    if (status == SN_OK && given.from != NULL) status = read_state(j, error);
    if (status == SN_OK) status = fibers_bind(&j->fibers, &j->c, &given.fibers, j->model, j->pool, error);
    frame_range range = range_of(j);
    if (status == SN_OK && given.from != NULL) fibers_move(&j->fibers, j->state);
    if (status == SN_OK) status = fibers_open_lengths(&j->fibers, (int64_t)range.last - range.first + 1, resume_of(j), error);
    if (status == SN_OK) status = open_targets(j, error);
    if (status == SN_OK) status = open_bones(j, error);
    if (status == SN_OK) status = open_log(j, error);
    if (status == SN_OK) say_resumed(j);
    j->setup_seconds = cli_seconds() - j->c.started;
    return status;
}

static sn_status simulate(job *j, sn_error *error) {
    sn_status status = prepare(j, error);
    if (status == SN_OK) status = run_frames(j, error);
    bool done = status == SN_OK || status == SN_STOPPED;
    sn_status kept = SN_OK;
    if (j->log != NULL) kept = sn_output_commit(j->log, done ? error : NULL); /* its lines stay, whatever happened */
    if (!done) return status;
    keep_first(&kept, commit_targets(j, kept == SN_OK ? error : NULL));
    if (given.state != NULL && !j->exploded) keep_first(&kept, write_state(j, kept == SN_OK ? error : NULL));
    return kept != SN_OK ? kept : status;
}

/* ---- plan and report -------------------------------------------------------------------------------------------------------- */

/* Milliseconds of a frame that the rows of one kind take, measured at the rest pose: 0 where there is no state to measure with. */
static double measure_cost(const job *j, sn_index muscle, sn_row_kind kind, int sweeps) {
    enum { LEAST_RUNS = 3, MOST_RUNS = 1000 };
    const double enough = 2e-3;
    double started = cli_seconds(), spent = 0.0;
    int runs = 0;
    while (runs < LEAST_RUNS || (runs < MOST_RUNS && spent < enough)) {
        sn_project(j->model, j->state, muscle, kind);
        spent = cli_seconds() - started;
        runs++;
    }
    bool newton = j->scene.solver.method == SN_SOLVER_QN; /* a row is evaluated once an iteration, and three times where a substep begins */
    sn_index iterations = j->model->muscles[muscle].iterations, times = newton ? iterations + 3 : sweeps * iterations;
    return 1e3 * spent / runs * times * sn_solver_substeps(&j->scene.solver);
}

static void write_group(sn_json *json, sn_row_kind kind, const sn_plan_group *group, double milliseconds) {
    sn_json_object(json, NULL);
    sn_json_text(json, "kind", sn_row_kind_name(kind));
    sn_json_integer(json, "rows", group->rows);
    sn_json_integer(json, "bytes", (int64_t)group->bytes);
    if (milliseconds > 0.0) sn_json_number(json, "millisecondsPerFrame", milliseconds);
    if (sn_row_info_of(kind)->spring && group->rows > 0) sn_json_numbers(json, "rigidity", group->rigidity, 2);
    if (group->reason != SN_RUNS) sn_json_text(json, "leftOut", sn_left_out_text(group->reason));
    if (group->kinematic > 0) sn_json_integer(json, "carriedByBones", group->kinematic);
    if (group->degenerate > 0) sn_json_integer(json, "degenerate", group->degenerate);
    sn_json_close(json);
}

/* muscle: in the model; SN_NONE where costs are not wanted. */
static void write_groups(const job *j, sn_json *json, const sn_plan_muscle *plan, sn_index muscle) {
    sn_json_array(json, "groups");
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        const sn_plan_group *group = &plan->groups[kind];
        double cost = muscle != SN_NONE && group->rows > 0 ? measure_cost(j, muscle, (sn_row_kind)kind, group->sweeps) : 0.0;
        write_group(json, (sn_row_kind)kind, group, cost);
    }
    sn_json_close(json);
}

static void write_muscle_plan(const job *j, sn_json *json, const sn_plan_muscle *plan, sn_index muscle, bool costs) {
    sn_json_object(json, NULL);
    sn_json_text(json, "name", plan->name);
    if (!plan->enabled) {
        bool asked = j->scene.muscles[plan - j->model->plan.muscles].unseen;
        sn_json_text(json, "leftOut", asked ? "--muscle asks for others, to which it is not tied" : "it is not enabled");
        sn_json_close(json);
        return;
    }
    sn_json_integer(json, "vertices", plan->vertices);
    sn_json_integer(json, "triangles", plan->triangles);
    sn_json_integer(json, "samples", plan->samples);
    if (plan->bare_samples > 0) sn_json_integer(json, "samplesLeftOut", plan->bare_samples); /* no vertex hangs on them */
    sn_json_integer(json, "carriedByBones", plan->kinematic);
    sn_json_integer(json, "iterations", plan->iterations);
    if (!plan->fibers)
        sn_json_text(json, "contraction", "surface edges keep their length: the document has no fibre directions (fiber-flow makes them)");
    sn_json_integer(json, "modelBytes", (int64_t)plan->model_bytes);
    sn_json_integer(json, "stateBytes", (int64_t)plan->state_bytes);
    write_groups(j, json, plan, costs ? muscle : SN_NONE);
    if (costs && muscle != SN_NONE && members_of(j->model, j->model->muscles[muscle].group) == 1)
        write_matrix(j, json, j->model->muscles[muscle].group);
    contacts_plan_muscle(j->model, plan, json);
    fibers_plan(&j->fibers, costs ? j->state : NULL, muscle, json);
    sn_json_close(json);
}

/* Of a group: what lies in its target at rest. */
static void write_ties_inside(const job *j, sn_json *json, sn_index group) {
    sn_index inside = 0;
    double deepest = 0.0;
    for (sn_index i = 0; i < j->model->muscle_count; i++) {
        if (j->model->muscles[i].group != group) continue;
        inside += plan_of(j, i)->ties_inside;
        deepest = fmax(deepest, plan_of(j, i)->deepest_tie);
    }
    sn_json_integer(json, "overlapsAtRest", inside);
    sn_json_number(json, "deepestAtRest", deepest);
}

/* Muscles that are solved together. */
static void write_coupled(const job *j, sn_json *json, bool costs) {
    const sn_model *model = j->model;
    if (!j->scene.externals.enabled) return;
    sn_json_array(json, "coupled");
    for (sn_index g = 0; g < model->group_count; g++) {
        sn_index rows = 0, members = 0;
        for (sn_index i = 0; i < model->muscle_count; i++)
            if (model->muscles[i].group == g) members++, rows += sn_row_count(model, i, SN_ROWS_EXTERNAL);
        if (members < 2) continue;
        sn_json_object(json, NULL);
        sn_json_array(json, "muscles");
        for (sn_index i = 0; i < model->muscle_count; i++)
            if (model->muscles[i].group == g) sn_json_text(json, NULL, model->muscles[i].source->name);
        sn_json_close(json);
        sn_json_integer(json, "rows", rows);
        write_ties_inside(j, json, g);
        if (costs) write_matrix(j, json, g);
        sn_json_close(json);
    }
    sn_json_close(json);
}

static void write_plan_members(const job *j, sn_json *json, bool costs) {
    const sn_plan *plan = &j->model->plan;
    sn_index running = 0;
    sn_json_text(json, "solver", sn_solver_method_names[j->scene.solver.method]);
    sn_json_text(json, "scheme", sn_scheme_names[j->scene.solver.scheme]);
    sn_json_number(json, "substepDuration", j->model->substep_duration);
    sn_json_array(json, "muscles");
    for (sn_index i = 0; i < plan->muscle_count; i++) {
        sn_index muscle = plan->muscles[i].enabled ? running++ : SN_NONE; /* in the model */
        write_muscle_plan(j, json, &plan->muscles[i], muscle, costs);
    }
    sn_json_close(json);
    contacts_plan(&j->contact, j->model, json);
    write_coupled(j, json, costs);
}

static sn_status print_plan(job *j, sn_error *error) {
    sn_output *output = NULL;
    sn_status status = sn_state_create(j->model, &j->state, error);
    if (status == SN_OK) status = fibers_bind(&j->fibers, &j->c, &given.fibers, j->model, j->pool, error);
    if (status == SN_OK) status = sn_output_open("-", false, &output, error);
    if (status != SN_OK) return status;
    sn_json *json = sn_json_begin(output, true);
    if (json == NULL) {
        sn_output_abort(output);
        return sn_fail_memory(error, "the plan");
    }
    sn_json_object(json, NULL);
    sn_json_object(json, "scene");
    sn_scene_write(&j->scene, json);
    sn_json_close(json);
    sn_json_object(json, "plan");
    write_plan_members(j, json, true);
    sn_json_close(json);
    sn_json_close(json);
    status = sn_json_end(json, error);
    if (status == SN_OK) return sn_output_commit(output, error);
    sn_output_abort(output);
    return status;
}

static void write_report(sn_json *json, const void *data) {
    const job *j = data;
    sn_json_number(json, "setupSeconds", j->setup_seconds);
    sn_json_integer(json, "threads", sn_pool_threads(j->pool));
    outcome_report(&j->outcome, json);
    fibers_report(&j->fibers, json);
    write_plan_members(j, json, false);
}

/* What its scene says, and is not felt. */
static void warn_of_idle_tone(const job *j, const sn_model_muscle *m) {
    const sn_scene_muscle *source = m->source;
    bool fibers = plan_of(j, (sn_index)(m - j->model->muscles))->fibers, shorter = source->rest_length != 1.0;
    if (!m->contracts && (shorter || source->tone > 0.0))
        cli_warn(&j->c, "muscle \"%s\": restLength and tone have no effect under the scheme %s, which knows no contraction", source->name,
                 sn_scheme_names[j->scene.solver.scheme]);
    else if (shorter && !fibers)
        cli_warn(&j->c,
                 "muscle \"%s\": restLength shortens nothing on its surface: the document has no fibre directions (fiber-flow makes them)",
                 source->name);
}

static void warn_of_idle_tendon(const job *j, const sn_scene_muscle *source) {
    bool idle = source->tendon_map == NULL && source->activation_map == NULL && sn_mesh_attribute(&source->rig.mesh, "tendon") != NULL;
    if (idle)
        cli_warn(&j->c,
                 "muscle \"%s\": its tendon map is not used, all of it contracts; name it in the scene: \"maps\": {\"tendon\": \"tendon\"}",
                 source->name);
}

static sn_status warn_of_loose_muscles(const job *j, sn_error *error) {
    sn_status status = SN_OK;
    if (j->model->muscle_count == 0) cli_warn(&j->c, "the scene has no muscle that is enabled: there is nothing to simulate");
    for (sn_index i = 0; status == SN_OK && i < j->model->muscle_count; i++) {
        const sn_model_muscle *m = &j->model->muscles[i];
        if (!is_seen(j, i)) continue;
        warn_of_idle_tone(j, m);
        warn_of_idle_tendon(j, m->source);
        if (m->kinematic_count == 0)
            cli_warn(&j->c, "muscle \"%s\" is attached to no bone and moves freely (attach-detect attaches it)", plan_of(j, i)->name);
        else
            status = grips_warn(&j->c, m->source->name, &m->source->rig, error);
    }
    return status;
}

static sn_status work(job *j, sn_error *error) {
    sn_status status = load_scene(j, error);
    if (status != SN_OK) return status;
    if (given.plan) return print_plan(j, error);
    status = warn_of_loose_muscles(j, error);
    if (status == SN_OK) status = simulate(j, error);
    if (status != SN_OK && status != SN_STOPPED) return status;
    outcome_say(&j->outcome);
    contacts_say(&j->c, j->model, j->state);
    sn_status reported = cli_report(&j->c, write_report, j, error);
    return reported != SN_OK ? reported : status;
}

int main(int argc, char **argv) {
    job j = {0};
    sn_error error = {0};
    cli_start(&j.c, &TOOL, argc, argv);
    outcome_parse_limits(&j.outcome, &j.c, given.fail_on);
    parse_stop(&j);
    check_choice(&j);
    if (cli_given(&j.c, "save-every") && given.state == NULL) cli_usage_error(&j.c, "--save-every needs --state FILE");
    (void)fibers_wanted(&j.c, &given.fibers);
    sn_status status = work(&j, &error);
    free_targets(&j);
    bone_frames_free(&j.bones);
    fibers_free(&j.fibers);
    outcome_free(&j.outcome);
    sn_pool_destroy(j.pool);
    sn_state_destroy(j.model, j.state);
    sn_model_destroy(j.model);
    sn_scene_free(&j.scene);
    return cli_finish(&j.c, status, &error);
}
