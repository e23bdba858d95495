/* sweep.c -- where a coordinate turns: the ways up and down of a motion. */
#include "sinew/moment_arm.h"

#include <stdlib.h>

typedef struct turns {
    sn_index count;
    sn_index *rows; /* where the ways begin and end, in order */
} turns;

/* The turns of a zigzag: an end counts once the coordinate has come back from it by `back`. rows (count + 2) at most. */
static turns find_turns(sn_index count, const double *x, double back, sn_index *rows) {
    turns t = {0, rows};
    sn_index lowest = SN_NONE, highest = SN_NONE;
    int way = 0; /* 1 up, -1 down, 0 not known */
    for (sn_index i = 0; i < count; i++) {
        if (isnan(x[i])) continue;
        if (lowest == SN_NONE) lowest = highest = i;
        if (x[i] < x[lowest]) lowest = i;
        if (x[i] > x[highest]) highest = i;
        if (way <= 0 && x[i] - x[lowest] >= back) {
            t.rows[t.count++] = lowest;
            way = 1;
            highest = i;
        } else if (way >= 0 && x[highest] - x[i] >= back) {
            t.rows[t.count++] = highest;
            way = -1;
            lowest = i;
        }
    }
    if (way != 0) t.rows[t.count++] = way > 0 ? highest : lowest;
    return t;
}

/* From a turn on while x stays within `still` of it: the last such row before `limit`. */
static sn_index end_of_rest(const double *x, sn_index turn, sn_index limit, double still) {
    sn_index last = turn;
    for (sn_index i = turn + 1; i <= limit && !(fabs(x[i] - x[turn]) > still); i++)
        if (!isnan(x[i])) last = i;
    return last;
}

static sn_sweeps part(const double *x, const turns *t, double still, sn_sweep *items) {
    sn_sweeps sweeps = {0, items};
    for (sn_index i = 0; i + 1 < t->count; i++) {
        sn_index last = t->rows[i + 1];
        items[sweeps.count++] = (sn_sweep){.first = end_of_rest(x, t->rows[i], last, still), .last = last, .up = x[last] > x[t->rows[i]]};
    }
    return sweeps;
}

sn_status sn_sweeps_find(sn_index count, const double *x, sn_sweeps *out, sn_error *error) {
    double low = INFINITY, high = -INFINITY;
    *out = (sn_sweeps){0};
    for (sn_index i = 0; i < count; i++) {
        if (x[i] < low) low = x[i];
        if (x[i] > high) high = x[i];
    }
    if (!(low < high)) return SN_OK;
    sn_index *rows = SN_NEW(sn_index, (size_t)count + 2);
    sn_sweep *items = SN_NEW(sn_sweep, (size_t)count + 2);
    if (rows == NULL || items == NULL) {
        free(rows);
        free(items);
        return sn_fail_memory(error, "the sweeps of a coordinate");
    }
    turns t = find_turns(count, x, SN_SWEEP_TURN * (high - low), rows);
    *out = part(x, &t, SN_SWEEP_STILL * (high - low), items);
    free(rows);
    return SN_OK;
}

void sn_sweeps_free(sn_sweeps *sweeps) {
    free(sweeps->items);
    *sweeps = (sn_sweeps){0};
}
