/*
 * child.h -- work that may crash or never end, done in a child process. Private to lib/geom.
 */
#ifndef SINEW_GEOM_CHILD_H
#define SINEW_GEOM_CHILD_H

#include "sinew/base.h"

typedef struct sn_child_limits {
    double seconds;     /* of processor time; or as many in which it hardly works (sn_watch) */
    size_t memory;      /* bytes of address space; 0 = no limit */
    size_t most_answer; /* bytes that the answer may have */
} sn_child_limits;

/* Runs in the child: do the work and write the answer to the descriptor `out`; false = failed. */
typedef bool (*sn_child_work)(void *user, int out);

typedef struct sn_child_answer {
    void *bytes; /* (size) owned: free() */
    size_t size;
    bool ended_early; /* there is none: the time was up */
} sn_child_answer;

/* Fork, let the child work, and read its answer. A child that dies, fails, or takes more than the limits is ended and gives
 * SN_ERROR_INTERNAL and no bytes. The child shares nothing with this process but what it writes, and runs none of its exit handlers. */
SN_MUST_CHECK sn_status sn_child_run(sn_child_work work, void *user, const sn_child_limits *limits, sn_child_answer *answer,
                                     sn_error *error);
/* Write all of it; false = the reader is gone. */
bool sn_child_write(int out, const void *bytes, size_t count);

#endif
