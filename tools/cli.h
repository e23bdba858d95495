/*
 * cli.h -- what every tool shares: options, help, exit statuses, input and output, report, trace, history.
 *
 * A tool's main is: defaults, cli_start, one function that works, cli_finish. Exit status: 0 done; 1 bad input or failed work;
 * 2 wrong usage; 3 done and written, but short of what was asked.
 */
#ifndef SINEW_CLI_H
#define SINEW_CLI_H

#include "sinew/io.h"
#include "sinew/trace.h"

enum { CLI_DONE = 0, CLI_FAILED = 1, CLI_USAGE = 2, CLI_SHORT = 3 };

typedef enum cli_kind {
    CLI_FLAG,    /* bool *; an option "--no-x" for a flag that starts true is written as its own entry with CLI_CLEAR */
    CLI_CLEAR,   /* bool *: sets it false */
    CLI_INTEGER, /* int64_t *, within low..high */
    CLI_AUTO,    /* int64_t *, within low..high; 0 for "auto" */
    CLI_NUMBER,  /* double *, within low..high (low = high = 0: any finite) */
    CLI_LENGTH,  /* sn_length *, >= 0 */
    CLI_TEXT,    /* const char ** */
    CLI_LIST,    /* cli_list *: may be given again and again */
    CLI_CHOICE,  /* int *: index into choices */
    CLI_HEADING  /* help text only */
} cli_kind;

typedef struct cli_list {
    int count;
    const char **items;
} cli_list;

enum {
    CLI_RESULT = 1, /* changes the result: it is part of the history */
    CLI_FILE = 2,   /* its value, or what follows the first '=' in it, names a file: the history holds the file's hash instead */
    CLI_FILES = 4,  /* its value names a list of files: the history holds what cli.hash_files makes of it instead */
    /* for cli_start, which refuses one file under two of these, and outputs that cannot be written: */
    CLI_READS = 8,     /* its value names a file that is read, as those of CLI_FILE do */
    CLI_WRITES = 16,   /* its value names a file that is written */
    CLI_FOLDER = 32,   /* beside CLI_WRITES: or a folder, which is made where it is missing */
    CLI_IN_PLACE = 64, /* beside CLI_WRITES: written in place, line by line */
    CLI_CACHE = 256,   /* beside CLI_WRITES and CLI_FOLDER: a folder, and nothing else */
    CLI_STATE = 128    /* a state: one that is written may take the place of one that is read */
};

/* The hash of all that stands behind the value of a CLI_FILES option. */
typedef sn_status (*cli_hash_function)(const void *user, const char *value, char out[SN_HASH_LENGTH], sn_error *error);

typedef struct cli_option {
    char letter;          /* 0 = none */
    const char *name;     /* long name without "--" */
    const char *argument; /* name of its value in the help; NULL for flags */
    cli_kind kind;
    void *target;
    unsigned flags;
    double low, high;           /* CLI_INTEGER, CLI_NUMBER */
    const char *const *choices; /* NULL-terminated. CLI_CHOICE: the words that it may be; others, nullable: words to tell in the help */
    const char *help;           /* one sentence; default in it where there is one */
} cli_option;

/* Of --units and --up, and of options like them; NULL at the end. */
extern const char *const cli_unit_names[];  /* "m", "cm", "mm" */
extern const double cli_unit_meters[];      /* in their order, m */
extern const char *const cli_up_names[];    /* "z", "y" */
extern const char *const cli_space_names[]; /* "LPS", "RAS" */

/* What the tools of the chain may write. */
#define CLI_WRITES_MUSCLE ".json, .obj, .ply, .stl, .off, .vtp"

/* Which of the shared options a tool takes. */
enum {
    CLI_TAKES_INPUT = 1,   /* one positional INPUT; "-" or nothing = stdin */
    CLI_TAKES_INPUTS = 2,  /* any number of positional inputs */
    CLI_HAS_OUTPUT = 4,    /* -o, --output */
    CLI_HAS_TRACE = 8,     /* --trace, --stop-after N */
    CLI_HAS_REPORT = 16,   /* --report */
    CLI_HAS_UNITS = 32,    /* --units, --up, --mesh for bare meshes */
    CLI_HAS_HISTORY = 64,  /* --no-history */
    CLI_HAS_THREADS = 128, /* --threads */
    CLI_HAS_LIST = 256,    /* --list: cli_load obeys it */
    CLI_HAS_STRICT = 1024, /* --strict: what reads documents */
    CLI_HAS_SPACE = 2048,  /* --space: what reads meshes */
    CLI_OWN_STOP = 512,    /* beside CLI_HAS_TRACE: --stop-after has a form of the tool's own, which the tool reads */
    CLI_CHAIN = 4 | 8 | 16 | 32 | 64 | 256 | 1024 | 2048 | 1 /* what every tool of the rig chain takes */
};

typedef struct cli_tool {
    const char *name;
    const char *summary; /* one line for --help */
    unsigned shared;     /* CLI_TAKES_... and CLI_HAS_... */
    const cli_option *options;
    int option_count;
    const char *notes;  /* nullable: further lines for --help */
    const char *writes; /* nullable: what --output may end in, as ".json, .obj"; other endings that say a format are wrong usage */
} cli_tool;

typedef struct cli {
    const cli_tool *tool;
    cli_list inputs;        /* positional; for CLI_TAKES_INPUT exactly one, "-" when none was given */
    const char *output;     /* "-" when none was given */
    const char *report;     /* NULL = none */
    const char *stop_after; /* text as given; NULL = none. trace.stop_after holds it where it is a plain number */
    sn_trace trace;         /* hand &cli.trace to the library */
    sn_read_options read;   /* --units, --up, --mesh */
    bool list;              /* --list */
    bool history;           /* false under --no-history */
    int threads;            /* 0 = all */
    int verbosity;          /* -1 quiet, 0, 1, 2 */
    bool is_short;          /* cli_shortfall was called: exit status 3 */
    char input_hash[SN_HASH_LENGTH];
    cli_hash_function hash_files; /* set by a tool with CLI_FILES options, before cli_save */
    const void *hash_user;
    /* private */
    unsigned stale; /* what cli_save found to be older than the attachments */
    sn_output *trace_output;
    double started; /* monotonic seconds at cli_start */
    int given_count;
    struct cli_given *given;
    bool progress_shown;
} cli;

/* Parse the command line. On --help, --usage, --version and on wrong usage this prints and exits the process (0 or 2). */
void cli_start(cli *c, const cli_tool *tool, int argc, char **argv);
/* Was this option (long name) on the command line? */
bool cli_given(const cli *c, const char *name);
/* Wrong usage found later than parsing: prints "tool: text; see tool --help" and exits with 2. */
_Noreturn void cli_usage_error(const cli *c, const char *format, ...) SN_PRINTF(2, 3);
/* The same for the first `length` characters of an option's value, which is none of the known ones (NULL at the end): lists them, and names
 * the one that was meant. */
_Noreturn void cli_no_such_value(const cli *c, const char *option, const char *value, size_t length, const char *const *known);
/* A warning on stderr: "tool: warning: text" (not under -q). */
void cli_warn(const cli *c, const char *format, ...) SN_PRINTF(2, 3);
/* Information on stderr under -v. */
void cli_say(const cli *c, const char *format, ...) SN_PRINTF(2, 3);
/* What a run came to, on stderr: "tool: text" (not under -q). */
void cli_tell(const cli *c, const char *format, ...) SN_PRINTF(2, 3);
/* Done, but short of what was asked: says so (also under -q) and makes the exit status 3. */
void cli_shortfall(cli *c, const char *format, ...) SN_PRINTF(2, 3);
/* Progress line on stderr if it is a terminal and not -q; at most ten a second; cleared by cli_finish. */
void cli_progress(cli *c, int64_t done, int64_t total, const char *unit);
/* Print the error if status is one, close the trace, free, check stdout; returns the process's exit status. SN_STOPPED is success. */
int cli_finish(cli *c, sn_status status, const sn_error *error);

/* ---- the chain: one document in, one document out ------------------------------------------------------------------- */

/* What one bone holds, as a number. */
typedef struct cli_held {
    char *bone;
    uint64_t hash;
} cli_held;

/* A muscle document as a tool of the chain holds it. */
typedef struct cli_muscle {
    sn_muscle muscle;
    sn_document *document;
    size_t held_count;
    cli_held *held_before; /* (held_count) what cli_load found attached */
} cli_muscle;
/* Read inputs.items[0] (document or bare mesh), keeping its hash for the history. Under --list: cli_list_meshes instead. */
SN_MUST_CHECK sn_status cli_load(cli *c, cli_muscle *out, sn_error *error);
/* Write the document to the output: the sections in `changed` from muscle, history appended. An output whose extension is a mesh
 * format's (.ply .vtp .obj .stl .off) gets the bare mesh; in .ply and .vtp with the sections painted on it (sn_muscle_paint). Attachments
 * that have changed leave the automatic roots, the structure and the fibres as they are, but these were made from other ends: a warning
 * says which bones hold something new or other, or nothing any more, and which tools to run again, and the report "stale" and "runAgain".
 */
SN_MUST_CHECK sn_status cli_save(cli *c, const cli_muscle *muscle, unsigned changed, sn_error *error);
/* Is a file that goes with it (NULL: none) in its space, as far as both are told? */
SN_MUST_CHECK sn_status cli_check_space(const sn_muscle *muscle, sn_space space, const char *file, sn_error *error);
void cli_free(cli_muscle *muscle);
/* What --list asks for: a line "number, name, vertices, triangles", parted by tabs, for each mesh of a bare mesh's file to stdout.
 * Returns SN_STOPPED, as nothing is left to be done. */
SN_MUST_CHECK sn_status cli_list_meshes(const sn_blob *blob, sn_error *error);

/* This run's entry for a history: options that change the result in canonical form, files by their hash, c->input_hash. */
typedef struct cli_history {
    sn_history_entry entry;
    char **args; /* (entry.arg_count) owned */
} cli_history;
SN_MUST_CHECK sn_status cli_history_make(const cli *c, cli_history *out, sn_error *error);
void cli_history_free(cli_history *history); /* all zeros is fine */

/* Write --report FILE, if asked: { "tool", "version", "seconds", ...members written by write(json, data) }. */
typedef void (*cli_report_writer)(sn_json *json, const void *data);
SN_MUST_CHECK sn_status cli_report(cli *c, cli_report_writer write, const void *data, sn_error *error);
/* One mesh report as members of the open object. */
void cli_report_mesh(sn_json *json, const sn_mesh_report *report);

/* How a muscle's ends were chosen, as members of the open object: "ends", "endsKnown" and, where something better was not used, "endsWhy";
 * and on stderr under -v, or as a warning where what was given for an end is not used or one end is not known. */
struct sn_ends_choice;
extern const char *const cli_ends_words[]; /* "auto" */
void cli_take_ends(const char **ends);     /* the value of --ends: NULL where it is "auto" */
void cli_report_ends(sn_json *json, const struct sn_ends_choice *choice);
void cli_say_ends(const cli *c, const struct sn_ends_choice *choice);

/* A length option in document units; fallback where it was not given (value < 0 before parsing). */
double cli_length(sn_length length, double meters_per_unit);
/* Parse a selector as text: "indices:3,4,5" "near:x,y,z[,n]" "sphere:x,y,z,r" "box:x,y,z,x,y,z" "plane:px,py,pz,nx,ny,nz"
 * "half:px,py,pz,nx,ny,nz" "painted:NAME[>T]"; in document units. Lives in tools/selector.c. */
struct sn_selector;
/* Split "NAME=FILE": *name is allocated; false if there is no '=' or an empty side. */
bool cli_split(const char *text, char **name, const char **file);
double cli_seconds(void); /* monotonic clock */

#endif
