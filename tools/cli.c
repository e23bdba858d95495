/* cli.c -- the shared command line: one parser, one help printer, one way to fail. */
#include "cli_given.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <locale.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* ---- shared options --------------------------------------------------------------------------------------------------- */

const char *const cli_unit_names[] = {"m", "cm", "mm", NULL};
const double cli_unit_meters[] = {1.0, 0.01, 0.001};
const char *const cli_up_names[] = {"z", "y", NULL};
const char *const cli_space_names[] = {"LPS", "RAS", NULL};

/* Targets of the shared options. */
typedef struct shared_values {
    const char *output, *report, *trace, *stop_after, *mesh;
    int units, up, space;
    bool list, no_history, strict, quiet, help, usage, version;
    int64_t threads;
} shared_values;

static shared_values shared;
static bool verbose_once, verbose_twice; /* -v, -vv */

enum { SHARED_ALWAYS = 1 << 30 };

typedef struct shared_option {
    unsigned needs; /* the CLI_HAS_ bit that brings it, or SHARED_ALWAYS */
    cli_option option;
} shared_option;

static const shared_option shared_options[] = {
    {CLI_HAS_OUTPUT,
     {'o', "output", "FILE", CLI_TEXT, &shared.output, CLI_WRITES | CLI_FOLDER, 0, 0, NULL, "write to FILE instead of standard output"}},
    {CLI_HAS_UNITS,
     {0, "units", "UNIT", CLI_CHOICE, &shared.units, CLI_RESULT, 0, 0, cli_unit_names,
      "unit of a bare mesh: m, cm or mm (default: as its file says, else m)"}},
    {CLI_HAS_UNITS,
     {0, "up", "AXIS", CLI_CHOICE, &shared.up, CLI_RESULT, 0, 0, cli_up_names,
      "up axis of a bare mesh: z, or y, turned to z (default: as its file says, else z)"}},
    {CLI_HAS_SPACE,
     {0, "space", "SPACE", CLI_CHOICE, &shared.space, CLI_RESULT, 0, 0, cli_space_names,
      "anatomical space of what is read: LPS or RAS; goes before what headers of meshes say (default: as they say)"}},
    {CLI_HAS_UNITS,
     {0, "mesh", "NAME|N", CLI_TEXT, &shared.mesh, CLI_RESULT, 0, 0, NULL,
      "of a file with several meshes, the one to read (default: all)"}},
    {CLI_HAS_LIST,
     {0, "list", NULL, CLI_FLAG, &shared.list, 0, 0, 0, NULL,
      "print number, name, vertices and triangles of each mesh, and do nothing else"}},
    {CLI_HAS_HISTORY, {0, "no-history", NULL, CLI_FLAG, &shared.no_history, 0, 0, 0, NULL, "leave the history out of the document"}},
    {CLI_HAS_STRICT,
     {0, "strict", NULL, CLI_FLAG, &shared.strict, 0, 0, 0, NULL, "refuse documents with members that sinew does not know"}},
    {CLI_HAS_REPORT, {0, "report", "FILE", CLI_TEXT, &shared.report, CLI_WRITES, 0, 0, NULL, "write figures and timings as JSON to FILE"}},
    {CLI_HAS_TRACE, {0, "trace", "FILE", CLI_TEXT, &shared.trace, CLI_WRITES, 0, 0, NULL, "write every inner step as a JSON line to FILE"}},
    {CLI_HAS_TRACE,
     {0, "stop-after", "N", CLI_TEXT, &shared.stop_after, CLI_RESULT, 0, 0, NULL, "stop after N inner steps and write the partial result"}},
    {CLI_HAS_THREADS,
     {0, "threads", "N", CLI_INTEGER, &shared.threads, 0, 1, 1024, NULL, "use N threads (default: every processor); results are the same"}},
    {SHARED_ALWAYS, {'v', "verbose", NULL, CLI_FLAG, &verbose_once, 0, 0, 0, NULL, "say more on standard error; -vv says everything"}},
    {SHARED_ALWAYS, {'q', "quiet", NULL, CLI_FLAG, &shared.quiet, 0, 0, 0, NULL, "say nothing but errors"}},
    {SHARED_ALWAYS, {'h', "help", NULL, CLI_FLAG, &shared.help, 0, 0, 0, NULL, "print this help"}},
    {SHARED_ALWAYS, {0, "usage", NULL, CLI_FLAG, &shared.usage, 0, 0, 0, NULL, "print a one-line synopsis"}},
    {SHARED_ALWAYS, {0, "version", NULL, CLI_FLAG, &shared.version, 0, 0, 0, NULL, "print the version"}},
};
enum { SHARED_COUNT = sizeof shared_options / sizeof *shared_options };

static bool brings(const cli_tool *tool, const shared_option *s) { return s->needs == SHARED_ALWAYS || (tool->shared & s->needs) != 0; }

/* ---- help ---------------------------------------------------------------------------------------------------------------- */

static const char *input_word(const cli_tool *tool) {
    if (tool->shared & CLI_TAKES_INPUTS) return " INPUT...";
    return tool->shared & CLI_TAKES_INPUT ? " [INPUT]" : "";
}

static void print_usage(FILE *out, const cli_tool *tool) {
    fprintf(out, "usage: %s [OPTION]...%s%s\n", tool->name, input_word(tool), tool->shared & CLI_HAS_OUTPUT ? " [-o OUTPUT]" : "");
}

static void print_option(const cli_option *option) {
    if (option->kind == CLI_HEADING) {
        printf("\n%s\n", option->help);
        return;
    }
    char left[64];
    snprintf(left, sizeof left, "%c%c%s --%s%s%s", option->letter ? '-' : ' ', option->letter ? option->letter : ' ',
             option->letter ? "," : " ", option->name, option->argument ? " " : "", option->argument ? option->argument : "");
    if (strlen(left) > 28)
        printf("  %s\n  %-28s  %s\n", left, "", option->help);
    else
        printf("  %-28s  %s\n", left, option->help);
}

/* The words that may be its value, or some of them; NULL = it has none. */
static const char *const *words_of(const cli_option *option) {
    static const char *const automatic[] = {"auto", NULL};
    return option->kind == CLI_AUTO ? automatic : option->choices;
}

/* A line "--option  word, word, ..." for each that has some: completions are made of it. */
static void print_values(const cli_tool *tool) {
    const cli_option *option;
    bool any = false;
    for (int i = 0; (option = cli_option_at(tool, i)) != NULL; i++) {
        const char *const *words = words_of(option);
        if (words == NULL) continue;
        printf("%s  --%-26s  ", any ? "" : "\nValues:\n", option->name);
        for (int k = 0; words[k] != NULL; k++) printf("%s%s", k > 0 ? ", " : "", words[k]);
        printf("\n");
        any = true;
    }
}

static void print_help(const cli_tool *tool) {
    print_usage(stdout, tool);
    printf("%s\n", tool->summary);
    if (tool->option_count > 0) printf("\nOptions:\n");
    for (int i = 0; i < tool->option_count; i++) print_option(&tool->options[i]);
    printf("\nShared options:\n");
    for (int i = 0; i < SHARED_COUNT; i++)
        if (brings(tool, &shared_options[i])) print_option(&shared_options[i].option);
    print_values(tool);
    if (tool->notes != NULL) printf("\n%s\n", tool->notes);
    printf("\nExit status: 0 done; 1 bad input or failed work; 2 wrong usage; 3 done, but short of what was asked.\n"
           "Lengths take a unit: 6mm, 0.5cm, 0.006m; a bare number is in the document's unit. See %s(1).\n",
           tool->name);
}

/* ---- a closed pipe ------------------------------------------------------------------------------------------------------- */

static bool pipe_ignored; /* by whoever started us: then it is an error like others */

/* Meanwhile a closed pipe is an error of the writer: files are left whole. */
static void hold_pipe_signal(void) { pipe_ignored = signal(SIGPIPE, SIG_IGN) == SIG_IGN; }

/* Has whoever read our standard output gone, as head(1) does when it has enough? */
static bool is_reader_gone(void) {
    struct pollfd out = {.fd = STDOUT_FILENO};
    return !pipe_ignored && poll(&out, 1, 0) == 1 && (out.revents & POLLERR) != 0;
}

/* What other tools do then: end by the signal, without a word. */
static void end_by_pipe(void) {
    signal(SIGPIPE, SIG_DFL);
    raise(SIGPIPE);
}

/* What was asked for on stdout must have got there. */
static _Noreturn void exit_printed(const cli_tool *tool) {
    if ((fflush(stdout) != 0 || ferror(stdout)) && is_reader_gone()) end_by_pipe();
    if (fflush(stdout) != 0 || ferror(stdout) || fclose(stdout) != 0) {
        fprintf(stderr, "%s: cannot write to standard output: %s\n", tool->name, strerror(errno));
        exit(CLI_FAILED);
    }
    exit(CLI_DONE);
}

/* Names of files and of what is in them may hold anything: no control character of theirs reaches the terminal, nor a second line. */
static void put_text(const char *text) {
    for (; *text != '\0'; text++) fputc((unsigned char)*text < ' ' || *text == 0x7f ? '?' : *text, stderr);
}

static void put(const char *format, va_list arguments) {
    char text[8192];
    int length = vsnprintf(text, sizeof text, format, arguments);
    put_text(text);
    if (length >= (int)sizeof text) put_text(" ...");
}

void cli_usage_error(const cli *c, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "%s: ", c->tool->name);
    put(format, arguments);
    fprintf(stderr, "; see %s --help\n", c->tool->name);
    va_end(arguments);
    exit(CLI_USAGE);
}

/* ---- parsing ------------------------------------------------------------------------------------------------------------- */

const cli_option *cli_option_at(const cli_tool *tool, int index) {
    if (index < tool->option_count) return &tool->options[index];
    index -= tool->option_count;
    for (int i = 0; i < SHARED_COUNT; i++)
        if (brings(tool, &shared_options[i]) && index-- == 0) return &shared_options[i].option;
    return NULL;
}

static const cli_option *find_letter(const cli_tool *tool, char letter) {
    const cli_option *option;
    for (int i = 0; (option = cli_option_at(tool, i)) != NULL; i++)
        if (option->kind != CLI_HEADING && option->letter == letter) return option;
    return NULL;
}

static _Noreturn void no_such_option(const cli *c, const char *name, size_t length) {
    const cli_option *option;
    const char *meant = NULL;
    int best = INT_MAX;
    for (int i = 0; (option = cli_option_at(c->tool, i)) != NULL; i++) {
        int distance = option->kind != CLI_HEADING ? sn_word_distance(name, length, option->name) : INT_MAX;
        if (distance >= best) continue;
        best = distance;
        meant = option->name;
    }
    cli_usage_error(c, "there is no option --%.*s%s%s%s", (int)length, name, meant != NULL ? "; did you mean --" : "",
                    meant != NULL ? meant : "", meant != NULL ? "?" : "");
}

static const cli_option *find_whole_name(const cli *c, const char *name, size_t length) {
    const cli_option *option;
    for (int i = 0; (option = cli_option_at(c->tool, i)) != NULL; i++)
        if (option->kind != CLI_HEADING && strlen(option->name) == length && strncmp(option->name, name, length) == 0) return option;
    return NULL;
}

/* Exact name, or the only one that starts so. */
static const cli_option *find_name(const cli *c, const char *name, size_t length) {
    const cli_option *option, *found = find_whole_name(c, name, length);
    if (found != NULL) return found;
    for (int i = 0; (option = cli_option_at(c->tool, i)) != NULL; i++) {
        if (option->kind == CLI_HEADING || strncmp(option->name, name, length) != 0) continue;
        if (found != NULL) cli_usage_error(c, "option --%.*s could be --%s or --%s", (int)length, name, found->name, option->name);
        found = option;
    }
    if (found == NULL) no_such_option(c, name, length);
    return found;
}

static void *grow_list(void *items, int count, size_t size) {
    void *grown = sn_realloc(items, (size_t)count + 1, size);
    if (grown != NULL) return grown;
    fprintf(stderr, "out of memory for the command line\n");
    exit(CLI_FAILED);
}

static void append(cli_list *list, const char *item) {
    list->items = grow_list(list->items, list->count, sizeof *list->items);
    list->items[list->count++] = item;
}

void cli_no_such_value(const cli *c, const char *option, const char *value, size_t length, const char *const *known) {
    const char *meant = sn_nearest_word(value, length, known);
    char list[256] = "";
    for (size_t used = 0; *known != NULL && used < sizeof list; known++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", used > 0 ? ", " : "", *known);
    cli_usage_error(c, "--%s %.*s: not one of %s%s%s%s", option, (int)length, value, list, meant != NULL ? "; did you mean " : "",
                    meant != NULL ? meant : "", meant != NULL ? "?" : "");
}

static void set_choice(const cli *c, const cli_option *option, const char *value) {
    for (int i = 0; option->choices[i] != NULL; i++) {
        if (strcmp(option->choices[i], value) != 0) continue;
        *(int *)option->target = i;
        return;
    }
    cli_no_such_value(c, option->name, value, strlen(value), option->choices);
}

static void set_number(const cli *c, const cli_option *option, const char *value) {
    sn_error error = {0};
    double number;
    if (sn_parse_number(value, &number, &error) != SN_OK) cli_usage_error(c, "--%s: %s", option->name, error.text);
    bool bounded = option->low != 0.0 || option->high != 0.0;
    if (bounded && (number < option->low || number > option->high))
        cli_usage_error(c, "--%s: %s is not within %g to %g", option->name, value, option->low, option->high);
    *(double *)option->target = number;
}

static void set_integer(const cli *c, const cli_option *option, const char *value) {
    sn_error error = {0};
    if (sn_parse_integer(value, (int64_t)option->low, (int64_t)option->high, option->target, &error) != SN_OK)
        cli_usage_error(c, "--%s: %s", option->name, error.text);
}

static void set_length(const cli *c, const cli_option *option, const char *value) {
    sn_error error = {0};
    sn_length length;
    if (sn_parse_length(value, &length, &error) != SN_OK) cli_usage_error(c, "--%s: %s", option->name, error.text);
    if (length.value < 0.0) cli_usage_error(c, "--%s: %s is negative", option->name, value);
    *(sn_length *)option->target = length;
}

static void set_value(const cli *c, const cli_option *option, const char *value) {
    switch (option->kind) {
    case CLI_FLAG:
        *(bool *)option->target = true;
        break;
    case CLI_CLEAR:
        *(bool *)option->target = false;
        break;
    case CLI_AUTO:
        *(int64_t *)option->target = 0;
        if (strcmp(value, "auto") != 0) set_integer(c, option, value);
        break;
    case CLI_INTEGER:
        set_integer(c, option, value);
        break;
    case CLI_NUMBER:
        set_number(c, option, value);
        break;
    case CLI_LENGTH:
        set_length(c, option, value);
        break;
    case CLI_TEXT:
        *(const char **)option->target = value;
        break;
    case CLI_LIST:
        append(option->target, value);
        break;
    case CLI_CHOICE:
        set_choice(c, option, value);
        break;
    case CLI_HEADING:
        break;
    }
}

static bool takes_value(const cli_option *option) { return option->kind != CLI_FLAG && option->kind != CLI_CLEAR; }

static void take(cli *c, const cli_option *option, const char *value) {
    if (option->target == &verbose_once && verbose_once) verbose_twice = true;
    set_value(c, option, value);
    c->given = grow_list(c->given, c->given_count, sizeof *c->given);
    c->given[c->given_count++] = (cli_given_option){option, value};
}

/* --name, --name=value, --name value; returns how many further words were used. */
static int take_long(cli *c, const char *word, const char *next) {
    const char *equals = strchr(word, '=');
    size_t length = equals != NULL ? (size_t)(equals - word) : strlen(word);
    const cli_option *option = find_name(c, word, length);
    if (!takes_value(option)) {
        if (equals != NULL) cli_usage_error(c, "--%s takes no value", option->name);
        take(c, option, NULL);
        return 0;
    }
    if (equals == NULL && next == NULL) cli_usage_error(c, "--%s needs a value", option->name);
    take(c, option, equals != NULL ? equals + 1 : next);
    return equals != NULL ? 0 : 1;
}

/* -x, -xVALUE, -x VALUE, -xyz of flags. */
static int take_letters(cli *c, const char *word, const char *next) {
    for (; *word != '\0'; word++) {
        const cli_option *option = find_letter(c->tool, *word);
        if (option == NULL) cli_usage_error(c, "there is no option -%c", *word);
        if (!takes_value(option)) {
            take(c, option, NULL);
            continue;
        }
        if (word[1] == '\0' && next == NULL) cli_usage_error(c, "-%c needs a value", *word);
        take(c, option, word[1] != '\0' ? word + 1 : next);
        return word[1] != '\0' ? 0 : 1;
    }
    return 0;
}

static void take_words(cli *c, int argc, char **argv) {
    bool options_end = false;
    for (int i = 1; i < argc; i++) {
        const char *word = argv[i], *next = i + 1 < argc ? argv[i + 1] : NULL;
        if (options_end || word[0] != '-' || word[1] == '\0')
            append(&c->inputs, word);
        else if (strcmp(word, "--") == 0)
            options_end = true;
        else
            i += word[1] == '-' ? take_long(c, word + 2, next) : take_letters(c, word + 1, next);
    }
}

static void check_inputs(cli *c) {
    if (c->tool->shared & CLI_TAKES_INPUTS) return;
    int most = c->tool->shared & CLI_TAKES_INPUT ? 1 : 0;
    if (c->inputs.count > most) cli_usage_error(c, "one input too many: %s", c->inputs.items[most]);
    if (most == 1 && c->inputs.count == 0) append(&c->inputs, "-");
}

/* A step count; tools with a form of their own (simulate) read c->stop_after themselves. */
static void take_stop_after(cli *c) {
    sn_error error = {0};
    int64_t steps;
    c->trace.stop_after = -1;
    if (shared.stop_after == NULL) return;
    c->stop_after = shared.stop_after;
    if (c->tool->shared & CLI_OWN_STOP) return;
    if (sn_parse_integer(shared.stop_after, 0, INT64_MAX, &steps, &error) != SN_OK) cli_usage_error(c, "--stop-after: %s", error.text);
    c->trace.stop_after = steps;
}

/* Documents that many parts of a scene name are read for each of them: a warning is not said again behind itself. */
static void warn_once(const cli *c, const char *text) {
    static char last[1024];
    if (strcmp(text, last) == 0) return;
    snprintf(last, sizeof last, "%s", text);
    cli_warn(c, "%s", text);
}

static void receive_log(void *user, sn_log_level level, const char *text) {
    const cli *c = user;
    if (level == SN_LOG_WARNING)
        warn_once(c, text);
    else if (level == SN_LOG_INFO)
        cli_say(c, "%s", text);
    else if (c->verbosity > 1)
        cli_say(c, "%s", text);
}

/* Is it one of those in the list, with commas? */
static bool is_listed(const char *ending, const char *list) {
    size_t length = strlen(ending);
    for (const char *word = list; *word != '\0'; word += strspn(word, ", ")) {
        size_t end = strcspn(word, ", ");
        if (end == length && strncasecmp(word, ending, length) == 0) return true;
        word += end;
    }
    return false;
}

/* An ending that says a format which is not written: a host would read the file as what it is not. Others say nothing. */
static void check_ending(const cli *c, const char *option, const char *path, const char *writes) {
    static const char known[] =
        ".json, .jsonl, .obj, .ply, .stl, .off, .vtk, .vtp, .vtu, .pvd, .glb, .gltf, .fbx, .dae, .abc, .usd, .usda, .usdc, "
        ".usdz, .3ds, .3mf, .x3d, .wrl, .blend, .ma, .mb, .max, .c4d, .bvh, .asf, .amc, .c3d, .trc, .pc2, .mdd, .osim, "
        ".png, .jpg, .jpeg, .svg, .pdf, .gif, .tif, .tiff, .bmp, .webp, .eps, .ps, .exr, .mp4, .mov, .avi, .csv, .tsv, "
        ".xlsx, .sto, .mot, .mat, .npy, .npz, .gz, .zip";
    const char *slash = path != NULL ? strrchr(path, '/') : NULL, *dot = path != NULL ? strrchr(slash != NULL ? slash : path, '.') : NULL;
    if (dot == NULL || writes == NULL || !is_listed(dot, known) || is_listed(dot, writes)) return;
    cli_usage_error(c, "--%s %s: that is not written; an ending may be %s", option, path, writes);
}

static void check_endings(const cli *c) {
    if (c->tool->shared & CLI_HAS_OUTPUT) check_ending(c, "output", shared.output, c->tool->writes);
    if (c->tool->shared & CLI_HAS_REPORT) check_ending(c, "report", shared.report, ".json");
    if (c->tool->shared & CLI_HAS_TRACE) check_ending(c, "trace", shared.trace, ".jsonl, .json");
}

static void take_shared(cli *c) {
    check_endings(c);
    c->output = shared.output != NULL ? shared.output : "-";
    c->report = shared.report;
    c->read.meters_per_unit = cli_given(c, "units") ? cli_unit_meters[shared.units] : 0.0;
    c->read.up_y = shared.up == 1;
    c->read.up_given = cli_given(c, "up");
    c->read.mesh = shared.mesh;
    c->read.asked = true;
    c->list = shared.list;
    c->history = !shared.no_history;
    sn_documents_strict(shared.strict);
    if (cli_given(c, "space")) sn_space_tell(sn_space_from_name(cli_space_names[shared.space]));
    c->threads = (int)shared.threads;
    c->verbosity = shared.quiet ? -1 : verbose_twice ? 2 : verbose_once ? 1 : 0;
    take_stop_after(c);
}

/* ---- trace ------------------------------------------------------------------------------------------------------------------ */

static void receive_trace(void *user, int64_t number, const char *stage, const sn_trace_value *values, int value_count) {
    cli *c = user;
    sn_json *json = sn_json_begin(c->trace_output, false);
    if (json == NULL) return;
    sn_json_object(json, NULL);
    sn_json_integer(json, "step", number);
    sn_json_text(json, "stage", stage);
    for (int i = 0; i < value_count; i++) {
        const sn_trace_value *v = &values[i];
        if (v->kind == SN_TRACE_NUMBER)
            sn_json_number(json, v->name, v->number);
        else if (v->kind == SN_TRACE_TEXT)
            sn_json_text(json, v->name, v->text);
        else
            sn_json_indices(json, v->name, v->indices, (size_t)v->count);
    }
    sn_json_close(json);
    if (sn_json_end(json, NULL) != SN_OK) return; /* the output keeps the first failure: cli_finish reports it */
}

static void open_trace(cli *c) {
    if (shared.trace == NULL) return;
    sn_error error = {0};
    if (sn_output_open(shared.trace, false, &c->trace_output, &error) != SN_OK) exit(cli_finish(c, error.code, &error));
    c->trace.receive = receive_trace;
    c->trace.user = c;
}

/* A standard descriptor that is closed would be given to the next file that is opened, which what talks there would then read or write. It
 * becomes one that cannot be used so: that is as much an error as before. */
static void fill_standard(void) {
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY) < 0) exit(CLI_FAILED);
}

void cli_start(cli *c, const cli_tool *tool, int argc, char **argv) {
    *c = (cli){.tool = tool, .started = cli_seconds()};
    fill_standard();
    hold_pipe_signal();
    take_words(c, argc, argv);
    if (shared.help)
        print_help(tool);
    else if (shared.usage)
        print_usage(stdout, tool);
    else if (shared.version)
        printf("%s (sinew) %s\n", tool->name, SN_VERSION);
    if (shared.help || shared.usage || shared.version) exit_printed(tool);
    check_inputs(c);
    take_shared(c);
    sn_log_set(receive_log, c);
    sn_error error = {0};
    if (cli_check_files(c, &error) != SN_OK) exit(cli_finish(c, error.code, &error));
    open_trace(c);
}

bool cli_given(const cli *c, const char *name) {
    for (int i = 0; i < c->given_count; i++)
        if (strcmp(c->given[i].option->name, name) == 0) return true;
    return false;
}

/* ---- messages --------------------------------------------------------------------------------------------------------------- */

static void clear_progress(const cli *c) {
    if (c->progress_shown) fprintf(stderr, "\r\033[K");
}

static void message(const cli *c, const char *kind, const char *format, va_list arguments) {
    clear_progress(c);
    fprintf(stderr, "%s: %s", c->tool->name, kind);
    put(format, arguments);
    fputc('\n', stderr);
}

void cli_warn(const cli *c, const char *format, ...) {
    if (c->verbosity < 0) return;
    va_list arguments;
    va_start(arguments, format);
    message(c, "warning: ", format, arguments);
    va_end(arguments);
}

void cli_say(const cli *c, const char *format, ...) {
    if (c->verbosity < 1) return;
    va_list arguments;
    va_start(arguments, format);
    message(c, "", format, arguments);
    va_end(arguments);
}

void cli_tell(const cli *c, const char *format, ...) {
    if (c->verbosity < 0) return;
    va_list arguments;
    va_start(arguments, format);
    message(c, "", format, arguments);
    va_end(arguments);
}

void cli_shortfall(cli *c, const char *format, ...) {
    c->is_short = true;
    va_list arguments;
    va_start(arguments, format);
    message(c, "", format, arguments);
    va_end(arguments);
}

void cli_progress(cli *c, int64_t done, int64_t total, const char *unit) {
    static double last;
    if (c->verbosity < 0 || !isatty(STDERR_FILENO)) return;
    double now = cli_seconds();
    if (now - last < 0.1 && done < total) return;
    last = now;
    c->progress_shown = true;
    fprintf(stderr, "\r%s: %s %lld of %lld\033[K", c->tool->name, unit, (long long)done, (long long)total);
}

/* "tool: FILE:LINE:COLUMN: sentence" with what of it is known. */
static void print_error(const cli *c, const sn_error *error) {
    fprintf(stderr, "%s: ", c->tool->name);
    if (error->file[0] != '\0') {
        put_text(error->file);
        fputc(':', stderr);
        if (error->line > 0) fprintf(stderr, "%lld:", (long long)error->line);
        if (error->line > 0 && error->column > 0) fprintf(stderr, "%lld:", (long long)error->column);
        fputc(' ', stderr);
    }
    put_text(error->text[0] != '\0' ? error->text : "failed");
    fputc('\n', stderr);
}

static int close_trace(cli *c) {
    if (c->trace_output == NULL) return CLI_DONE;
    sn_error error = {0};
    sn_status status = sn_output_commit(c->trace_output, &error);
    c->trace_output = NULL;
    if (status == SN_OK) return CLI_DONE;
    print_error(c, &error);
    return CLI_FAILED;
}

int cli_finish(cli *c, sn_status status, const sn_error *error) {
    clear_progress(c);
    int code = c->is_short ? CLI_SHORT : CLI_DONE;
    bool piped = status == SN_ERROR_IO && strcmp(error->file, "<stdout>") == 0 && is_reader_gone();
    if (status != SN_OK && status != SN_STOPPED) {
        if (!piped) print_error(c, error);
        code = status == SN_ERROR_USAGE ? CLI_USAGE : CLI_FAILED;
    }
    int trace_code = close_trace(c); /* also after a failure: the trace shows the way there */
    if (trace_code != CLI_DONE) code = trace_code;
    if (fflush(stdout) != 0 || ferror(stdout)) {
        piped = piped || is_reader_gone();
        if (!piped) fprintf(stderr, "%s: cannot write to standard output: %s\n", c->tool->name, strerror(errno));
        code = CLI_FAILED;
    }
    if (piped) end_by_pipe();
    sn_log_set(NULL, NULL);
    free(c->inputs.items);
    free(c->given);
    return code;
}

double cli_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double cli_length(sn_length length, double meters_per_unit) {
    if (length.value < 0.0) return length.value; /* not given */
    return sn_length_meters(length, meters_per_unit) / meters_per_unit;
}

bool cli_split(const char *text, char **name, const char **file) {
    const char *equals = strchr(text, '=');
    *name = NULL;
    if (equals == NULL || equals == text || equals[1] == '\0') return false;
    *name = sn_strndup(text, (size_t)(equals - text));
    *file = equals + 1;
    return *name != NULL;
}
