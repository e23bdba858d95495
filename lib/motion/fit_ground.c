/*
 * fit_ground.c -- the floor that standing feet tell.
 */
#include <stdlib.h>
#include <string.h>

#include "fit_align.h"
#include "sinew/numeric.h"

/* Contacts closer than this together, over their main direction, tell no slope, metres; a floor is found from this many at least. */
static const double SHORTEST_WAY = 1.0;
enum { FEWEST_CONTACTS = 10 };

/* ---- the floor ------------------------------------------------------------------------------------------------------------------------
 */

typedef struct floor_work {
    sn_index frames, count;
    sn_fit_contact *contacts; /* (frames) of one foot */
    bool *stands;             /* (frames) */
    sn_vec3 *points;          /* (count) of all feet that stand; room for all */
    double *x, *y;            /* (count) */
    double lowest;            /* of all feet and frames */
} floor_work;

static void gather_contacts(const sn_fit_body *body, const sn_fit_result *fit, const sn_clip *source, floor_work *w) {
    w->lowest = INFINITY;
    for (sn_index k = 0; k < body->table->foot_count; k++) {
        sn_index top = body->table->feet[k].joint;
        if (!sn_fit_contacts(body, &fit->clip, top, w->contacts)) continue;
        sn_fit_stands(body, fit, source, top, SN_FIT_STANCE_SPEED, w->stands);
        for (sn_index f = 0; f < w->frames; f++) {
            w->lowest = fmin(w->lowest, w->contacts[f].at.z);
            if (w->stands[f]) w->points[w->count++] = w->contacts[f].at;
        }
    }
}

/* The horizontal direction along which the contacts spread most, and their mean. */
static bool main_direction(const floor_work *w, sn_vec3 *mean, sn_vec3 *direction) {
    sn_mat3 spread = {{{0}}}, vectors;
    double values[3];
    *mean = sn_v3(0, 0, 0);
    for (sn_index i = 0; i < w->count; i++) *mean = sn_add_scaled(*mean, w->points[i], 1.0 / w->count);
    for (sn_index i = 0; i < w->count; i++) {
        double x = w->points[i].x - mean->x, y = w->points[i].y - mean->y;
        spread.m[0][0] += x * x;
        spread.m[0][1] += x * y;
        spread.m[1][0] += x * y;
        spread.m[1][1] += y * y;
    }
    if (!sn_eigen_symmetric3(&spread, values, &vectors)) return false;
    *direction = sn_normalize(sn_v3(vectors.m[0][2], vectors.m[1][2], 0.0));
    return sn_norm2(*direction) > 0.0;
}

/* The rise of the floor along a direction, by a robust line through the contacts. False: they do not tell it. */
static bool find_rise(floor_work *w, sn_vec3 mean, sn_vec3 direction, double *slope) {
    double low = INFINITY, high = -INFINITY, height;
    for (sn_index i = 0; i < w->count; i++) {
        w->x[i] = sn_dot(direction, sn_sub(w->points[i], mean));
        w->y[i] = w->points[i].z - mean.z;
        low = fmin(low, w->x[i]);
        high = fmax(high, w->x[i]);
    }
    return high - low >= SHORTEST_WAY && sn_fit_line_robust(w->count, w->x, w->y, &height, slope);
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The height of the floor, once `turn` has levelled it: the median of the contacts. */
static double floor_height(floor_work *w, sn_rigid turn) {
    for (sn_index i = 0; i < w->count; i++) w->y[i] = sn_rigid_apply(turn, w->points[i]).z;
    qsort(w->y, (size_t)w->count, sizeof *w->y, compare);
    return w->y[w->count / 2];
}

/* What takes the floor to z = 0. */
static sn_rigid find_floor(floor_work *w, sn_fit_result *fit) {
    sn_rigid turn = sn_rigid_identity();
    sn_vec3 mean, direction;
    double slope;
    if (w->count < FEWEST_CONTACTS) {
        fit->raised = isfinite(w->lowest) ? 0.0 - w->lowest : 0.0;
        turn.translation.z = fit->raised;
        return turn;
    }
    fit->floor = true;
    if (main_direction(w, &mean, &direction) && find_rise(w, mean, direction, &slope)) {
        fit->slope = sn_atan2(fabs(slope), 1.0);
        fit->uphill = slope < 0.0 ? sn_neg(direction) : direction;
        if (fit->slope <= SN_FIT_SLOPE_LIMIT) {
            turn.rotation = sn_quat_axis_angle(sn_cross(fit->uphill, sn_v3(0, 0, 1)), -fit->slope);
            turn.translation = sn_sub(mean, sn_quat_rotate(turn.rotation, mean));
            fit->levelled = true;
        }
    }
    fit->raised = 0.0 - floor_height(w, turn);
    turn.translation.z += fit->raised;
    return turn;
}

static void move_clip(sn_clip *clip, sn_rigid by) {
    for (sn_index j = 0; j < clip->joint_count; j++)
        for (sn_index f = 0; f < clip->frame_count; f++) {
            sn_rigid pose = sn_rigid_compose(by, clip->joints[j].poses[f]);
            clip->joints[j].poses[f] = (sn_rigid){sn_quat_normalize(pose.rotation), pose.translation};
        }
}

sn_status sn_fit_put_on_floor(const sn_fit_body *body, const sn_clip *source, sn_fit_result *fit, sn_error *error) {
    size_t frames = (size_t)source->frame_count, all = frames * (size_t)body->table->foot_count;
    floor_work w = {.frames = source->frame_count,
                    .contacts = SN_NEW(sn_fit_contact, frames),
                    .stands = SN_NEW(bool, frames),
                    .points = SN_NEW(sn_vec3, all),
                    .x = SN_NEW(double, all),
                    .y = SN_NEW(double, all)};
    bool room = w.contacts != NULL && w.stands != NULL && w.points != NULL && w.x != NULL && w.y != NULL;
    sn_status status = room && all < SN_INDEX_MAX ? SN_OK : sn_fail_memory(error, "the floor");
    if (status == SN_OK) {
        gather_contacts(body, fit, source, &w);
        sn_rigid by = find_floor(&w, fit);
        move_clip(&fit->clip, by);
    }
    free(w.contacts);
    free(w.stands);
    free(w.points);
    free(w.x);
    free(w.y);
    return status;
}
