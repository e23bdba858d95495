/*
 * watch.h -- has a child process had its time?   rank 0
 */
#ifndef SINEW_WATCH_H
#define SINEW_WATCH_H

#include "sinew/base.h"

/* Has a child process had its time? It is late once it has used `seconds` of the processor, or has hardly worked (less than a hundredth of
 * one processor) for as long: how loaded the machine is makes no difference. */
typedef struct sn_watch {
    int child; /* process id */
    double seconds, began, used;
} sn_watch;
sn_watch sn_watch_begin(int child, double seconds);
bool sn_watch_is_late(sn_watch *watch);

#endif
