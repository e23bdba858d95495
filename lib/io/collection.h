/* collection.h -- files numbered by frame, and a PVD collection that gives each its time. Private to lib/io. */
#ifndef SINEW_IO_COLLECTION_H
#define SINEW_IO_COLLECTION_H

#include "sinew/io.h"

typedef struct sn_collection {
    char *prefix;
    char *path; /* of the frame at hand: room for the longest */
    size_t path_size;
    sn_output *output;
} sn_collection;

/* PREFIX.pvd; the caller closes or drops it, also where this fails. */
SN_MUST_CHECK sn_status sn_collection_open(sn_collection *collection, const char *prefix, sn_error *error);
/* PREFIX.0000.vtp: the path of a frame, good until the next call. */
const char *sn_collection_frame(sn_collection *collection, sn_index frame);
/* The frame at hand is in it, at a time in seconds; the collection until now is seen at its path. */
SN_MUST_CHECK sn_status sn_collection_list(sn_collection *collection, double time, sn_error *error);
/* Begin with the lines of the collection that is there. */
SN_MUST_CHECK sn_status sn_collection_resume(sn_collection *collection, sn_resume *resume, bool *goes_on, sn_error *error);
SN_MUST_CHECK sn_status sn_collection_close(sn_collection *collection, sn_error *error);
void sn_collection_drop(sn_collection *collection); /* one that is closed, or all zeros, is fine */

#endif
