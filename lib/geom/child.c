/*
 * child.c -- work that may crash or never end, done in a child process with limits.
 */
#include "child.h"

#include "sinew/watch.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

enum { LOOK_EVERY = 50 }; /* milliseconds */

/* An address sanitizer reserves more than any limit. */
#ifdef __SANITIZE_ADDRESS__
#define CAN_LIMIT_MEMORY false
#else
#define CAN_LIMIT_MEMORY true
#endif

/* The kernel's limit is whole seconds, and stands behind the watch: it holds where this process is gone or gets no processor. */
static void set_limits(const sn_child_limits *limits) {
    struct rlimit none = {0, 0}, time = {(rlim_t)ceil(limits->seconds) + 1, (rlim_t)ceil(limits->seconds) + 2};
    struct rlimit memory = {limits->memory, limits->memory};
    setrlimit(RLIMIT_CORE, &none);
    setrlimit(RLIMIT_CPU, &time);
    if (limits->memory > 0 && CAN_LIMIT_MEMORY) setrlimit(RLIMIT_AS, &memory);
}

bool sn_child_write(int out, const void *bytes, size_t count) {
    const char *next = bytes;
    while (count > 0) {
        ssize_t written = write(out, next, count);
        if (written < 0 && errno != EINTR) return false;
        if (written <= 0) continue;
        next += written;
        count -= (size_t)written;
    }
    return true;
}

typedef enum reading { READ_ALL, READ_LATE, READ_FAILED } reading;

/* Read until the child closes its end, within the limits. */
static reading read_answer(int in, sn_watch *watch, const sn_child_limits *limits, char **answer, size_t *count) {
    size_t capacity = 0;
    for (;;) {
        struct pollfd watched = {.fd = in, .events = POLLIN};
        int ready = poll(&watched, 1, LOOK_EVERY);
        if (ready < 0 && errno != EINTR) return READ_FAILED;
        if (ready <= 0 && sn_watch_is_late(watch)) return READ_LATE;
        if (ready <= 0) continue;
        if (*count > limits->most_answer || !sn_grow((void **)answer, &capacity, *count + 65536, 1)) return READ_FAILED;
        ssize_t got = read(in, *answer + *count, 65536);
        if (got == 0) return READ_ALL;
        if (got < 0 && errno != EINTR) return READ_FAILED;
        if (got > 0) *count += (size_t)got;
    }
}

/* The child's exit status; minus the signal that ended it. */
static int reap(pid_t child) {
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

/* A handler of this process has no business in the child's death. */
static void die_plainly(void) {
    const int signals[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGPIPE, SIGXCPU};
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) signal(signals[i], SIG_DFL);
}

/* A parent that was killed leaves no child at work; one that is gone already sends no signal. */
static void die_with(pid_t parent) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);
}

static void be_child(sn_child_work work, void *user, const sn_child_limits *limits, int out) {
    die_plainly();
    set_limits(limits);
    _exit(work(user, out) ? 0 : 1);
}

sn_status sn_child_run(sn_child_work work, void *user, const sn_child_limits *limits, sn_child_answer *answer, sn_error *error) {
    int ends[2];
    char *bytes = NULL;
    size_t size = 0;
    *answer = (sn_child_answer){0};
    if (pipe(ends) != 0) return sn_fail(error, SN_ERROR_INTERNAL, "no pipe to a child process could be made");
    pid_t parent = getpid(), child = fork();
    if (child == 0) {
        die_with(parent);
        close(ends[0]);
        be_child(work, user, limits, ends[1]);
    }
    close(ends[1]);
    sn_watch watch = sn_watch_begin(child, limits->seconds);
    reading how = child > 0 ? read_answer(ends[0], &watch, limits, &bytes, &size) : READ_FAILED;
    close(ends[0]);
    if (child > 0 && how != READ_ALL) kill(child, SIGKILL);
    int code = child > 0 ? reap(child) : -1;
    if (code == -SIGXCPU) how = READ_LATE;
    answer->ended_early = how == READ_LATE;
    if (how == READ_ALL && code == 0) {
        answer->bytes = bytes;
        answer->size = size;
        return SN_OK;
    }
    free(bytes);
    if (child < 0) return sn_fail(error, SN_ERROR_INTERNAL, "no child process could be started");
    if (how == READ_LATE) return sn_fail(error, SN_ERROR_INTERNAL, "the work was not done after %g s of processor time", limits->seconds);
    return sn_fail(error, SN_ERROR_INTERNAL, "the child process failed");
}
