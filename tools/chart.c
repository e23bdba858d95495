/* chart.c -- charts by gnuplot, run as a child. */
#include "chart.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

enum { MOST_ARGUMENTS = 16, MESSAGE_SIZE = 512 };

/* Beside an installed program, or in the tree that a program was built in. */
static bool find_script(const char *script, char path[PATH_MAX + 128]) {
    static const char *const folders[] = {"../share/sinew/plots", "../../../share/plots"};
    char self[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
    self[length > 0 ? length : 0] = '\0';
    char *slash = strrchr(self, '/');
    if (slash == NULL) return false;
    *slash = '\0';
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++) {
        snprintf(path, PATH_MAX + 128, "%s/%s/%s", self, folders[i], script);
        if (access(path, R_OK) == 0) return true;
    }
    return false;
}

/* In the child, between fork and exec: only what is safe there. It dies with its parent. */
static _Noreturn void become_gnuplot(const char *const *argv, int out, pid_t parent) {
    int nothing = open("/dev/null", O_RDONLY);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() == parent && nothing >= 0 && dup2(nothing, STDIN_FILENO) >= 0 && dup2(out, STDOUT_FILENO) >= 0 &&
        dup2(out, STDERR_FILENO) >= 0)
        execvp(argv[0], (char *const *)(uintptr_t)argv); /* POSIX leaves the const out for old programs; arguments are only read */
    _exit(127);
}

/* Start it with its standard output and error going to `out`; 0, or what errno says. */
static int start(const char *const *argv, int out, pid_t *child) {
    pid_t parent = getpid();
    if ((*child = fork()) == 0) become_gnuplot(argv, out, parent);
    return *child < 0 ? errno : 0;
}

/* All that it says, of which the beginning is kept; its exit status, or -1. */
static int listen_and_wait(pid_t child, int in, char message[MESSAGE_SIZE]) {
    char chunk[4096];
    size_t used = 0;
    int status = 0;
    for (ssize_t got; (got = read(in, chunk, sizeof chunk)) != 0;) {
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) break;
        size_t room = MESSAGE_SIZE - 1 - used, take = (size_t)got < room ? (size_t)got : room;
        memcpy(message + used, chunk, take);
        used += take;
    }
    message[used] = '\0';
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/* The last line that is not empty: gnuplot shows the place first, then says what is wrong. */
static const char *last_line(char *message) {
    size_t length = strlen(message);
    while (length > 0 && (message[length - 1] == '\n' || message[length - 1] == ' ')) message[--length] = '\0';
    const char *line = strrchr(message, '\n');
    return line != NULL ? line + 1 : message;
}

bool chart_draw(cli *c, const char *script, const char *const *arguments) {
    char path[PATH_MAX + 128], message[MESSAGE_SIZE];
    const char *argv[MOST_ARGUMENTS + 4] = {"gnuplot", "-c", path};
    int ends[2], count = 3, failed;
    pid_t child;
    while (*arguments != NULL && count < MOST_ARGUMENTS + 3) argv[count++] = *arguments++;
    if (!find_script(script, path)) {
        cli_shortfall(c, "no chart: share/plots/%s is not there", script);
        return false;
    }
    if (pipe2(ends, O_CLOEXEC) != 0) {
        cli_shortfall(c, "no chart: no pipe to gnuplot: %s", strerror(errno));
        return false;
    }
    failed = start(argv, ends[1], &child);
    close(ends[1]);
    int status = failed == 0 ? listen_and_wait(child, ends[0], message) : 127;
    close(ends[0]);
    if (failed == 0 && status == 127)
        cli_shortfall(c, "no chart: gnuplot is not installed (Debian package gnuplot-nox)");
    else if (failed != 0)
        cli_shortfall(c, "no chart: gnuplot cannot be started: %s", strerror(failed));
    else if (status != 0)
        cli_shortfall(c, "no chart: gnuplot failed: %s", last_line(message));
    return failed == 0 && status == 0;
}
