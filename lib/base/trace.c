/* trace.c -- count steps, hand them to the receiver, say when to stop. */
#include "sinew/trace.h"

bool sn_trace_stopped(const sn_trace *trace) { return trace != NULL && trace->stop_after >= 0 && trace->steps >= trace->stop_after; }

bool sn_trace_step(sn_trace *trace, const char *stage, const sn_trace_value *values, int value_count) {
    if (trace == NULL) return false;
    trace->steps++;
    if (trace->receive != NULL) trace->receive(trace->user, trace->steps, stage, values, value_count);
    return sn_trace_stopped(trace);
}
