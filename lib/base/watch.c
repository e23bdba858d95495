/* watch.c -- has a child process had its time? Judged by its processor's, so that a loaded machine changes no result. */
#include "sinew/watch.h"

#include <time.h>

/* What works has more than this share of one processor, however loaded the machine is; what waits for something has less. */
static const double LEAST_SHARE = 0.01;

static double seconds_of(clockid_t clock, double otherwise) {
    struct timespec t;
    return clock_gettime(clock, &t) == 0 ? (double)t.tv_sec + 1e-9 * (double)t.tv_nsec : otherwise;
}

static double processor_time(int child, double otherwise) {
    clockid_t clock;
    return clock_getcpuclockid(child, &clock) == 0 ? seconds_of(clock, otherwise) : otherwise;
}

sn_watch sn_watch_begin(int child, double seconds) {
    return (sn_watch){.child = child, .seconds = seconds, .began = seconds_of(CLOCK_MONOTONIC, 0.0)};
}

bool sn_watch_is_late(sn_watch *watch) {
    double used = processor_time(watch->child, watch->used), now = seconds_of(CLOCK_MONOTONIC, watch->began);
    if (used >= watch->seconds) return true;
    if (now - watch->began < watch->seconds) return false;
    if (used - watch->used < LEAST_SHARE * watch->seconds) return true;
    watch->began = now;
    watch->used = used;
    return false;
}
