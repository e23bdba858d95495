/*
 * pareto.c -- which settings are worth their time.   numerics.md 4
 */
#include "sinew/error_time.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool beats(double seconds, double error, double other_seconds, double other_error, bool earlier) {
    if (!(seconds <= other_seconds && error <= other_error)) return false;
    return seconds < other_seconds || error < other_error || earlier;
}

void sn_pareto_front(sn_index count, const double *seconds, const double *errors, bool *front) {
    for (sn_index i = 0; i < count; i++) {
        front[i] = isfinite(seconds[i]) && isfinite(errors[i]);
        for (sn_index k = 0; front[i] && k < count; k++)
            if (k != i && beats(seconds[k], errors[k], seconds[i], errors[i], k < i)) front[i] = false;
    }
}

/* Is there a point that claims nothing, yet is surely better? Its error is at most the floor above what was measured. */
static bool is_surely_beaten(const sn_error_time *report, const sn_error_point *p) {
    for (sn_index i = 0; i < report->point_count; i++) {
        const sn_error_point *q = &report->points[i];
        if (!q->claimed && q->cpu <= p->cpu && q->total.worst + report->reference.floor < p->total.worst) return true;
    }
    return false;
}

sn_status sn_error_time_judge(sn_error_time *report, sn_error *error) {
    sn_index count = report->point_count;
    double *seconds = SN_NEW(double, count), *errors = SN_NEW(double, count);
    bool *front = SN_NEW(bool, count);
    sn_status status = seconds != NULL && errors != NULL && front != NULL ? SN_OK : sn_fail_memory(error, "the front");
    for (sn_index i = 0; status == SN_OK && i < count; i++) {
        sn_error_point *p = &report->points[i];
        p->claimed = p->total.worst >= SN_CLAIM_FLOORS * report->reference.floor;
        seconds[i] = p->cpu;
        errors[i] = p->claimed ? p->total.worst : INFINITY;
    }
    if (status == SN_OK) sn_pareto_front(count, seconds, errors, front);
    for (sn_index i = 0; status == SN_OK && i < count; i++)
        report->points[i].front = front[i] && !is_surely_beaten(report, &report->points[i]);
    free(seconds);
    free(errors);
    free(front);
    return status;
}

const sn_error_point *sn_error_time_cheapest(const sn_error_time *report, double error, const char *family) {
    const sn_error_point *best = NULL;
    char name[SN_SETTING_LENGTH];
    for (sn_index i = 0; i < report->point_count; i++) {
        const sn_error_point *p = &report->points[i];
        if (!(p->total.worst + report->reference.floor <= error) || (best != NULL && !(p->cpu < best->cpu))) continue;
        sn_setting_family(&report->settings[p->setting].setting, name);
        if (family == NULL || strcmp(name, family) == 0) best = p;
    }
    return best;
}

void sn_error_time_words(const sn_error_time *report, const sn_error_point *point, size_t size, char *out) {
    char setting[SN_SETTING_LENGTH], held[48] = "";
    sn_setting_format(&report->settings[point->setting].setting, setting);
    if (report->equilibrium) snprintf(held, sizeof held, " after %d held frames", (int)point->held);
    snprintf(out, size, "%s: %.2g L%s in %.3g s", setting, point->total.worst, held, point->cpu);
}

void sn_error_time_free(sn_error_time *report) {
    for (sn_index i = 0; report->muscle_names != NULL && i < report->muscle_count; i++) free(report->muscle_names[i]);
    for (sn_index i = 0; report->settings != NULL && i < report->setting_count; i++) free(report->settings[i].muscle_errors);
    free(report->scene_name);
    free(report->muscle_names);
    free(report->muscle_vertices);
    free(report->moments);
    free(report->settings);
    free(report->points);
    sn_reference_free(&report->reference);
    *report = (sn_error_time){0};
}
