/*
 * contact_block.c -- rows of contact that stand together, so that those far from a bone are passed over at once.
 *
 * Rows are in the order of a space-filling curve at rest (contact_build.c), and stay together while a muscle moves.
 */
#include "contact.h"

sn_vec3 sn_contact_mean(const sn_contact_row *row, const sn_vec3 *of_points) {
    if (row->weight[0] == 1.0f) return of_points[row->point[0]];
    sn_vec3 sum = sn_v3(0, 0, 0);
    for (int i = 0; i < 3 && row->weight[i] > 0.0f; i++) sum = sn_add_scaled(sum, of_points[row->point[i]], (double)row->weight[i]);
    return sum;
}

sn_vec3 sn_contact_point(const sn_contact_row *row, const sn_point *points) {
    if (row->weight[0] == 1.0f) return sn_point_position(&points[row->point[0]]);
    sn_vec3 at = sn_v3(0, 0, 0);
    for (int i = 0; i < 3; i++) at = sn_add_scaled(at, sn_point_position(&points[row->point[i]]), (double)row->weight[i]);
    return at;
}

/* Not fmin and fmax: points are finite here, or nothing is known of them. */
static void extend(double *low, double *high, double value) {
    if (value < *low) *low = value;
    if (value > *high) *high = value;
}

sn_contact_block sn_contact_block_at(const sn_contacts *contacts, const sn_collider *collider, sn_index begin, const sn_point *points,
                                     const sn_vec3 *before) {
    sn_contact_block b = {.begin = begin, .end = begin + SN_CONTACT_BLOCK < collider->end ? begin + SN_CONTACT_BLOCK : collider->end};
    sn_vec3 low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
    for (sn_index r = begin; r < b.end; r++) {
        const sn_contact_row *row = &contacts->rows[r];
        sn_vec3 p = before == NULL ? sn_contact_point(row, points) : sn_contact_mean(row, before);
        extend(&low.x, &high.x, p.x), extend(&low.y, &high.y, p.y), extend(&low.z, &high.z, p.z);
    }
    b.middle = sn_scale(sn_add(low, high), 0.5);
    b.radius = 0.5 * sn_distance(low, high);
    return b;
}
