/* trigger.c -- an activation that rises when a threshold is crossed, holds, and decays. */
#include <math.h>
#include <stdlib.h>

#include "sense.h"

/* Where a trigger is: it rises from `from` since `since`, and has been below its threshold again since `released`. */
typedef struct envelope {
    const sn_trigger *trigger;
    bool ever, on;
    double since, from, released;
} envelope;

static double level_at(const envelope *e, double time) {
    const sn_trigger *t = e->trigger;
    double risen = e->since + t->attack, fall = e->on ? INFINITY : fmax(risen + t->hold, e->released);
    if (!e->ever) return 0.0;
    if (time < risen) return e->from + (t->level - e->from) * (time - e->since) / t->attack;
    if (time <= fall) return t->level;
    return t->decay > 0.0 ? t->level * sn_quick_exp((fall - time) / t->decay) : 0.0;
}

/* When a straight line from a at `before` to b, a step later, is at c. */
static double crossing(double before, double step, double a, double b, double c) {
    double share = (c - a) / (b - a);
    return before + step * fmin(fmax(share, 0.0), 1.0);
}

static sn_status fire(envelope *e, double time, sn_firings *firings, size_t *capacity, sn_error *error) {
    e->from = level_at(e, time);
    e->ever = e->on = true;
    e->since = time;
    if (!sn_grow((void **)&firings->times, capacity, (size_t)firings->count + 1, sizeof(double))) return sn_fail_memory(error, "a trigger");
    firings->times[firings->count++] = time;
    return SN_OK;
}

sn_status sn_trigger_run(const sn_trigger *t, const sn_series *series, double *out, sn_firings *firings, sn_error *error) {
    const double *values = series->values;
    const double sign = t->below ? -1.0 : 1.0, threshold = sign * t->threshold, release = threshold - t->hysteresis;
    envelope e = {.trigger = t};
    size_t capacity = 0;
    sn_status status = SN_OK;
    *firings = (sn_firings){0};
    if (series->count > 0 && sign * values[0] > threshold) {
        e.ever = e.on = firings->from_start = true;
        e.since = -INFINITY;
    }
    for (sn_index k = 0; k < series->count && status == SN_OK; k++) {
        double now = series->begin + k / series->rate, before = series->begin + (k - 1) / series->rate, here = sign * values[k];
        if (k > 0 && !e.on && here > threshold) {
            status = fire(&e, crossing(before, now - before, sign * values[k - 1], here, threshold), firings, &capacity, error);
        } else if (e.on && here < release) {
            e.released = crossing(before, now - before, sign * values[k - 1], here, release);
            e.on = false;
        }
        out[k] = level_at(&e, now);
    }
    return status;
}
