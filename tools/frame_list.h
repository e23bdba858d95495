/* frame_list.h -- the frames that a tool is to draw: --frame LIST and --frame-count N. */
#ifndef SINEW_TOOLS_FRAME_LIST_H
#define SINEW_TOOLS_FRAME_LIST_H

#include "cli.h"

enum { FRAMES_MAX = 256 };
typedef struct frame_list {
    sn_index count;
    int64_t items[FRAMES_MAX];
} frame_list;

/* "0,12,24", "0:90:15", or both mixed; NULL = empty. Wrong usage exits. */
frame_list frames_parse(const cli *c, const char *text);
/* `count` frames from the first to the last, as evenly as whole numbers are; fewer where there are fewer. */
frame_list frames_spread(int64_t count, int64_t first, int64_t last);

#endif
