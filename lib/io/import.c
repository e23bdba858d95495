/*
 * import.c -- other formats: mesh-import reads them in a child process, which may crash, hang or eat memory in our stead.
 *
 * The child gets the file's bytes as its standard input and answers with a binary PLY file whose comments say the rest (the
 * statements are those of tools/mesh-import.c): "comment metersPerUnit 0.01", "comment up y", "comment mesh TRIANGLES NAME". It is
 * parsed like any file: nothing that the child says is believed.
 */
#include "import.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "bytes.h"
#include "mesh_reader.h"
#include "nodes.h"
#include "sinew/watch.h"

#ifndef SN_PREFIX
#define SN_PREFIX "/usr/local"
#endif

/* What a child may take. The times are those that libraries.md's hangs went far beyond, and real files far below. */
#define CPU_SECONDS 20                  /* or as many in which it hardly works: sn_watch */
#define MEMORY_BASE ((uint64_t)2 << 30) /* address space, in bytes: this, and MEMORY_SHARE for each byte of the file */
#define MEMORY_SHARE 16
#define ANSWER_BASE ((uint64_t)256 << 20) /* likewise of what it may answer */
#define ANSWER_SHARE 32

enum { CHUNK = 1 << 16, MESSAGE_SIZE = 2048, LOOK_EVERY = 50 /* milliseconds */ };

typedef struct child {
    const sn_blob *blob;
    const char *name;     /* of the format */
    const char *question; /* an option of mesh-import; NULL = the meshes */
    const char *first;    /* what its answer begins with */
    const char *noun;     /* what it is, for messages: "mesh" */
    char path[PATH_MAX + 64];
    pid_t pid, parent;
    int input, output, messages; /* its stdin, its stdout and its stderr; -1 = closed */
    sn_watch watch;
    char *answer;
    size_t answer_size, answer_capacity;
    char message[MESSAGE_SIZE]; /* the beginning of what it wrote to stderr, and a 0 */
    size_t message_size;
} child;

static void close_descriptor(int *fd) {
    if (*fd >= 0) close(*fd);
    *fd = -1;
}

/* ---- start ------------------------------------------------------------------------------------------------------------ */

/* $SINEW_LIBEXEC, else beside the folder of the running program, else where sinew was built to be installed. */
static sn_status find_program(child *c, sn_error *error) {
    const char *folder = getenv("SINEW_LIBEXEC");
    if (folder != NULL && *folder != '\0') {
        snprintf(c->path, sizeof c->path, "%s/mesh-import", folder);
    } else {
        char self[PATH_MAX];
        ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
        self[length > 0 ? length : 0] = '\0';
        char *slash = strrchr(self, '/');
        if (slash != NULL) *slash = '\0';
        snprintf(c->path, sizeof c->path, "%s/../libexec/sinew/mesh-import", self);
        if (slash == NULL || access(c->path, X_OK) != 0) snprintf(c->path, sizeof c->path, "%s", SN_PREFIX "/libexec/sinew/mesh-import");
    }
    if (access(c->path, X_OK) == 0) return SN_OK;
    return sn_fail_at(
        error, SN_ERROR_IO, c->blob->name, 0,
        "is a %s file, and what reads these, %s, is not there; install it, name its folder in SINEW_LIBEXEC, or convert the file "
        "to OBJ or PLY",
        c->name, c->path);
}

/* The file's bytes as a descriptor to read from. */
static sn_status open_input(child *c, sn_error *error) {
    c->input = memfd_create("sinew-import", MFD_CLOEXEC);
    size_t done = 0;
    while (c->input >= 0 && done < c->blob->size) {
        ssize_t put = write(c->input, c->blob->data + done, c->blob->size - done);
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) close_descriptor(&c->input);
        if (put > 0) done += (size_t)put;
    }
    if (c->input >= 0 && lseek(c->input, 0, SEEK_SET) == 0) return SN_OK;
    return sn_fail_at(error, SN_ERROR_IO, c->blob->name, 0, "cannot be handed to %s: %s", c->path, strerror(errno));
}

static void limit(int resource, uint64_t most) {
    struct rlimit r;
    if (getrlimit(resource, &r) != 0) return;
    if (r.rlim_max == RLIM_INFINITY || r.rlim_max > most) r.rlim_max = most;
    if (r.rlim_cur == RLIM_INFINITY || r.rlim_cur > r.rlim_max) r.rlim_cur = r.rlim_max;
    setrlimit(resource, &r);
}

/* In the child, between fork and exec: only what is safe there. It leads a group, so that what it starts dies with it, and dies with
 * its parent. */
static _Noreturn void become_program(const child *c, int output, int messages, char *const *argv) {
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != c->parent) _exit(127);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) /* these reserve terabytes */
    limit(RLIMIT_AS, MEMORY_BASE + MEMORY_SHARE * (uint64_t)c->blob->size);
#endif
    limit(RLIMIT_CPU, CPU_SECONDS + 1); /* behind the watch: where the parent gets no processor */
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_FSIZE, 0); /* it writes to pipes only */
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    if (c->input == STDIN_FILENO)
        fcntl(STDIN_FILENO, F_SETFD, 0); /* of a program that was started without one: dup2 would leave it closed */
    if (dup2(c->input, STDIN_FILENO) >= 0 && dup2(output, STDOUT_FILENO) >= 0 && dup2(messages, STDERR_FILENO) >= 0) execv(c->path, argv);
    _exit(127);
}

static sn_status start(child *c, sn_error *error) {
    int output[2] = {-1, -1}, messages[2] = {-1, -1};
    char *argv[] = {c->path, "--name", c->blob->name, (char *)(uintptr_t)c->question, NULL};
    sn_status status = open_input(c, error);
    if (status != SN_OK) return status;
    if (pipe2(output, O_CLOEXEC) == 0 && pipe2(messages, O_CLOEXEC) == 0) c->pid = fork();
    int reason = errno;
    if (c->pid == 0) become_program(c, output[1], messages[1], argv);
    close_descriptor(&c->input);
    close_descriptor(&output[1]);
    close_descriptor(&messages[1]);
    c->output = output[0];
    c->messages = messages[0];
    c->watch = sn_watch_begin(c->pid, CPU_SECONDS);
    if (c->pid > 0) return SN_OK;
    return sn_fail_at(error, SN_ERROR_IO, c->blob->name, 0, "cannot be imported, as %s cannot be started: %s", c->path, strerror(reason));
}

/* ---- listen ----------------------------------------------------------------------------------------------------------- */

/* An answer that does not begin as it should is none. */
static bool is_answer(const child *c) {
    size_t length = strlen(c->first), known = c->answer_size < length ? c->answer_size : length;
    return memcmp(c->answer, c->first, known) == 0;
}

static sn_status no_answer(const child *c, sn_error *error) {
    return sn_fail_at(error, SN_ERROR_INTERNAL, c->blob->name, 0,
                      "cannot be imported as %s: %s answers with something that is no %s; is it of the same version of sinew?", c->name,
                      c->path, c->noun);
}

static sn_status take_answer(child *c, sn_error *error) {
    uint64_t most = ANSWER_BASE + ANSWER_SHARE * (uint64_t)c->blob->size;
    if (c->answer_size >= most) {
        return sn_fail_at(error, SN_ERROR_INPUT, c->blob->name, 0, "holds more than %llu MB of %s, too much for one %s file of its size",
                          (unsigned long long)(most >> 20), c->question != NULL ? "keys" : "meshes", c->name);
    }
    if (!sn_grow((void **)&c->answer, &c->answer_capacity, c->answer_size + CHUNK, 1)) return sn_fail_memory(error, c->blob->name);
    ssize_t got = read(c->output, c->answer + c->answer_size, CHUNK);
    if (got < 0 && (errno == EINTR || errno == EAGAIN)) return SN_OK;
    if (got <= 0) close_descriptor(&c->output);
    if (got > 0) c->answer_size += (size_t)got;
    return c->answer_size == 0 || is_answer(c) ? SN_OK : no_answer(c, error);
}

/* What does not fit is read and forgotten, so that it can go on talking. */
static void take_message(child *c) {
    char rest[CHUNK / 16];
    bool full = c->message_size + 1 >= sizeof c->message;
    ssize_t got =
        read(c->messages, full ? rest : c->message + c->message_size, full ? sizeof rest : sizeof c->message - 1 - c->message_size);
    if (got < 0 && (errno == EINTR || errno == EAGAIN)) return;
    if (got <= 0) close_descriptor(&c->messages);
    if (got > 0 && !full) c->message_size += (size_t)got;
}

static sn_status too_slow(const child *c, sn_error *error) {
    return sn_fail_at(
        error, SN_ERROR_INPUT, c->blob->name, 0,
        "takes longer than %d s to be imported as %s, so that was given up; the file may be damaged: export it again, or as OBJ or "
        "PLY",
        CPU_SECONDS, c->name);
}

/* Until it has closed both pipes or its time is over. */
static sn_status listen_to(child *c, sn_error *error) {
    sn_status status = SN_OK;
    while (status == SN_OK && (c->output >= 0 || c->messages >= 0)) {
        if (sn_watch_is_late(&c->watch)) return too_slow(c, error);
        struct pollfd ready[2] = {{.fd = c->output, .events = POLLIN}, {.fd = c->messages, .events = POLLIN}};
        if (poll(ready, 2, LOOK_EVERY) < 0 && errno != EINTR)
            return sn_fail_at(error, SN_ERROR_IO, c->blob->name, 0, "cannot be imported: %s", strerror(errno));
        if (ready[1].revents != 0) take_message(c);
        if (ready[0].revents != 0) status = take_answer(c, error);
    }
    return status;
}

/* ---- end -------------------------------------------------------------------------------------------------------------- */

/* It has closed its pipes and should be gone any moment; true once it is. It stays to be reaped. */
static bool is_gone(child *c) {
    for (;;) {
        siginfo_t info = {0};
        if (waitid(P_PID, (id_t)c->pid, &info, WEXITED | WNOHANG | WNOWAIT) != 0 && errno != EINTR) return true;
        if (info.si_pid != 0) return true;
        if (sn_watch_is_late(&c->watch)) return false;
        nanosleep(&(struct timespec){.tv_nsec = 500000}, NULL);
    }
}

/* Kill what is left of it and of what it started; returns its wait status, 0 where somebody else has reaped it. */
static int reap(child *c) {
    int wait_status = 0;
    kill(-c->pid, SIGKILL);
    kill(c->pid, SIGKILL); /* it may not lead its group yet */
    while (waitpid(c->pid, &wait_status, 0) < 0) {
        if (errno != EINTR) return 0;
    }
    return wait_status;
}

/* The last line that it said, without its own name and the file's in front; "" = nothing. */
static const char *last_words(child *c) {
    while (c->message_size > 0 && strchr("\r\n ", c->message[c->message_size - 1]) != NULL) c->message[--c->message_size] = '\0';
    const char *newline = memrchr(c->message, '\n', c->message_size);
    char *text = newline != NULL ? c->message + (newline - c->message) + 1 : c->message;
    const char *const prefixes[] = {"mesh-import", c->blob->name};
    for (int i = 0; i < 2; i++) {
        size_t length = strlen(prefixes[i]);
        if (strncmp(text, prefixes[i], length) == 0 && text[length] == ':') text += length + 1;
        while (*text == ' ') text++;
    }
    for (char *at = text; *at != '\0'; at++) {
        if ((unsigned char)*at < ' ' || *at == 0x7f) *at = ' ';
    }
    return text;
}

static sn_status out_of_memory(const child *c, sn_error *error) {
    return sn_fail_at(error, SN_ERROR_INPUT, c->blob->name, 0,
                      "needs more than %llu MB of memory to be imported as %s; the file may be damaged: export it again, or as OBJ or PLY",
                      (unsigned long long)((MEMORY_BASE + MEMORY_SHARE * (uint64_t)c->blob->size) >> 20), c->name);
}

static sn_status judge_signal(child *c, int number, sn_error *error) {
    if (number == SIGXCPU) return too_slow(c, error);
    if (number == SIGKILL)
        return sn_fail_at(error, SN_ERROR_INPUT, c->blob->name, 0, "cannot be imported as %s: %s was killed from outside", c->name,
                          c->path);
    if (strstr(c->message, "bad_alloc") != NULL) return out_of_memory(c, error);
    return sn_fail_at(error, SN_ERROR_INPUT, c->blob->name, 0,
                      "makes the importer of %s crash (%s); the file is damaged or of an unusual kind: export it again, or as OBJ or PLY",
                      c->name, strsignal(number));
}

/* Its exit status: 0 is an answer, 1 a sentence on stderr. */
static sn_status judge(child *c, int wait_status, sn_error *error) {
    if (WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == 0) return SN_OK;
    const char *words = last_words(c);
    if (WIFSIGNALED(wait_status)) return judge_signal(c, WTERMSIG(wait_status), error);
    if (strstr(words, "bad_alloc") != NULL || strstr(words, "out of memory") != NULL) return out_of_memory(c, error);
    if (WEXITSTATUS(wait_status) == 1 && *words != '\0') return sn_fail_at(error, SN_ERROR_INPUT, c->blob->name, 0, "%s", words);
    return sn_fail_at(error, SN_ERROR_INTERNAL, c->blob->name, 0, "cannot be imported as %s: %s failed with status %d", c->name, c->path,
                      WEXITSTATUS(wait_status));
}

/* ---- the answer ------------------------------------------------------------------------------------------------------- */

/* A group of `triangles` triangles, the next ones in the file. */
static sn_status add_group(sn_mesh *mesh, sn_index *filled, int64_t triangles, sn_span name, sn_error *error) {
    char **names = sn_realloc(mesh->group_names, (size_t)mesh->group_count + 1, sizeof *names);
    if (names == NULL) return sn_fail_memory(error, "the names of meshes");
    mesh->group_names = names;
    if ((names[mesh->group_count] = sn_strndup(name.text, name.length)) == NULL) return sn_fail_memory(error, "the names of meshes");
    for (int64_t i = 0; i < triangles; i++) mesh->triangle_group[(*filled)++] = mesh->group_count;
    mesh->group_count++;
    return SN_OK;
}

/* One comment of the header; false = it makes no sense. */
static bool take_comment(sn_reader *line, sn_mesh *mesh, sn_index *filled, sn_mesh_frame *frame, sn_error *error) {
    sn_span key = sn_reader_word(line);
    if (sn_span_is(key, "metersPerUnit")) return sn_reader_number(line, &frame->meters_per_unit) && frame->meters_per_unit > 0.0;
    if (sn_span_is(key, "up")) {
        frame->up = sn_span_is(sn_reader_word(line), "y") ? SN_UP_Y : SN_UP_Z;
        return true;
    }
    if (!sn_span_is(key, "mesh")) return true;
    int64_t triangles;
    if (!sn_reader_integer(line, &triangles) || triangles < 0 || triangles > mesh->triangle_count - *filled) return false;
    return add_group(mesh, filled, triangles, sn_reader_rest(line), error) == SN_OK;
}

static sn_status take_header(const child *c, const sn_blob *answer, sn_mesh *mesh, sn_mesh_frame *frame, sn_error *error) {
    sn_reader reader = {.blob = answer, .at = answer->data, .end = answer->data + answer->size, .line = 1, .highest_corner = -1};
    sn_index filled = 0;
    mesh->triangle_group = SN_NEW(sn_index, mesh->triangle_count);
    if (mesh->triangle_group == NULL) return sn_fail_memory(error, "the names of meshes");
    for (bool more = true; more && sn_reader_next_line(&reader);) {
        sn_span word = sn_reader_word(&reader);
        more = !sn_span_is(word, "end_header");
        if (sn_span_is(word, "comment") && !take_comment(&reader, mesh, &filled, frame, error)) return no_answer(c, error);
    }
    return filled == mesh->triangle_count ? SN_OK : no_answer(c, error);
}

static sn_status check_finite(const sn_mesh *mesh, const char *name, sn_error *error) {
    for (sn_index v = 0; v < mesh->vertex_count; v++) {
        if (!sn_finite3(mesh->positions[v]))
            return sn_fail_at(error, SN_ERROR_INPUT, name, 0,
                              "vertex %d has a coordinate that is not a finite number; mesh-clean --repair-nonfinite drops such vertices",
                              (int)v);
    }
    return SN_OK;
}

static sn_status read_answer(const child *c, bool allow_nonfinite, sn_mesh *out, sn_mesh_frame *frame, sn_error *error) {
    sn_blob answer = {c->blob->name, c->answer, c->answer_size};
    sn_error detail = {0};
    if (answer.size == 0 || sn_mesh_parse(&answer, true, out, &detail) != SN_OK)
        return detail.code == SN_ERROR_MEMORY ? sn_fail_memory(error, c->blob->name) : no_answer(c, error);
    sn_status status = take_header(c, &answer, out, frame, error);
    if (status == SN_OK && !allow_nonfinite) status = check_finite(out, c->blob->name, error);
    if (status != SN_OK) sn_mesh_free(out);
    return status;
}

/* Its warnings go to the log as ours. What else it says while it succeeds is of no interest. */
static void pass_warnings(child *c) {
    static const char prefix[] = "mesh-import: warning: ";
    char *line = c->message;
    while (line != NULL && *line != '\0') {
        char *end = strchr(line, '\n');
        if (end != NULL) *end++ = '\0';
        if (strncmp(line, prefix, sizeof prefix - 1) == 0) sn_log(SN_LOG_WARNING, "%s: %s", c->blob->name, line + sizeof prefix - 1);
        line = end;
    }
}

/* Ask the child, and judge how it ended; its answer is in c, also on failure. */
static sn_status ask(child *c, sn_error *error) {
    c->parent = getpid();
    c->pid = c->input = c->output = c->messages = -1;
    sn_status status = find_program(c, error);
    if (status == SN_OK) status = start(c, error);
    if (c->pid > 0) {
        if (status == SN_OK) status = listen_to(c, error);
        if (status == SN_OK && !is_gone(c)) status = too_slow(c, error);
        int wait_status = reap(c);
        if (status == SN_OK) status = judge(c, wait_status, error);
        if (status == SN_OK) pass_warnings(c);
    }
    close_descriptor(&c->output);
    close_descriptor(&c->messages);
    return status;
}

/* glTF in binary and 3DS say how long they are; what stands behind that would be lost without a word. */
static sn_status expect_end(const sn_blob *blob, const char *kind, sn_error *error) {
    size_t at = strcmp(kind, "glb") == 0 ? 8 : strcmp(kind, "3ds") == 0 ? 2 : 0, end = blob->size;
    if (at == 0 || blob->size < at + 4) return SN_OK;
    uint32_t told = sn_get_u32((const unsigned char *)blob->data + at);
    while (end > told && (blob->data[end - 1] == '\0' || strchr(" \r\n", blob->data[end - 1]) != NULL)) end--;
    if (end <= told) return SN_OK;
    return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0,
                      "the header counts %lu bytes, but the file has %zu; are these two files in one?", (unsigned long)told, blob->size);
}

sn_status sn_import_parse(const sn_blob *blob, bool allow_nonfinite, sn_mesh *out, sn_mesh_frame *frame, sn_error *error) {
    const char *kind = sn_import_detect(blob);
    if (kind == NULL) return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "is in no format that can be imported");
    child c = {.blob = blob, .name = sn_import_format_name(kind), .first = "ply\n", .noun = "mesh"};
    sn_status status = expect_end(blob, kind, error);
    if (status == SN_OK) status = ask(&c, error);
    if (status == SN_OK) status = read_answer(&c, allow_nonfinite, out, frame, error);
    free(c.answer);
    return status;
}

sn_status sn_import_nodes(const sn_blob *blob, sn_nodes *out, sn_error *error) {
    const char *kind = sn_import_detect(blob);
    *out = (sn_nodes){0};
    if (kind == NULL) return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "is in no format that can be imported");
    child c = {.blob = blob, .name = sn_import_format_name(kind), .question = "--motion", .first = "sinew-nodes 1\n", .noun = "motion"};
    sn_status status = expect_end(blob, kind, error);
    if (status == SN_OK) status = ask(&c, error);
    sn_blob answer = {blob->name, c.answer, c.answer_size};
    sn_error detail = {0};
    if (status == SN_OK && sn_nodes_parse(&answer, out, &detail) != SN_OK)
        status = detail.code == SN_ERROR_INTERNAL ? no_answer(&c, error) : sn_fail_at(error, detail.code, blob->name, 0, "%s", detail.text);
    free(c.answer);
    return status;
}
