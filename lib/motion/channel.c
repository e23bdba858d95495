/*
 * channel.c -- a scalar over time: the value between two keys.
 */
#include "sinew/motion.h"

#include <stdlib.h>

#include "interpolate.h"

const char *const sn_interpolation_names[] = {"linear", "smooth", NULL};

double sn_channel_at(const sn_channel *channel, double time) {
    if (channel->count <= 0) return channel->constant;
    sn_index last = channel->count - 1;
    if (!(time > channel->times[0])) return channel->values[0];
    if (time >= channel->times[last]) return channel->values[last];
    sn_index low = 0;
    for (sn_index high = last; high - low > 1;) {
        sn_index middle = low + (high - low) / 2;
        if (channel->times[middle] <= time)
            low = middle;
        else
            high = middle;
    }
    double t = sn_ease(channel->interpolation, channel->times[low], channel->times[low + 1], time);
    return channel->values[low] + t * (channel->values[low + 1] - channel->values[low]);
}

void sn_channel_free(sn_channel *channel) {
    if (channel == NULL) return;
    free(channel->times);
    free(channel->values);
    *channel = (sn_channel){0};
}
