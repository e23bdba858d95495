/*
 * contact.c -- bones and surfaces are not entered: a unilateral row for each point and one of them, C = phi(x) - m >= 0.   bodies.md 2,
 * numerics.md 7
 *
 * Under `qn` by an augmented Lagrangian, energy max(0, lambda - k C)^2 / (2 k), force max(0, lambda - k C) grad phi; lambda is kept from
 * step to step, and the rows are in no matrix. Under `xpbd` by projection, with Coulomb's friction. Phi and its gradient are those of one
 * interpolant, so that energy and force agree.
 */
#include "contact.h"
#include "xpbd.h"

#include <stdlib.h>

/* Over the edges' stiffness (bodies.md 2: 100 stalls, k of all vertices in the matrix is worse by ten times). */
static const double STIFFNESS = 10.0;
/* A gradient of phi shorter than this points nowhere: deep inside of a bone, half way between its sides. */
static const double LEAST_GRADIENT = 1e-3;

/* ---- one row ------------------------------------------------------------------------------------------------------------------------- */

double sn_contact_margin(const sn_contacts *contacts, const sn_muscle_state *s, const sn_contact_row *row) {
    double margin = (double)row->margin;
    return s->inputs->resolved > 0.0 ? margin + s->inputs->resolved * (contacts->margin - margin) : margin;
}

/* Phi of a row at `at`, and its gradient in the world (nullable). */
static double distance_of(const sn_contacts *contacts, const sn_muscle_state *s, const sn_collider *collider, sn_index r, sn_vec3 at,
                          sn_vec3 *gradient) {
    if (collider->patch != NULL) return sn_patch_distance(collider, s, r, at, gradient);
    const sn_rigid *pose = &s->inputs->collider_poses[collider - contacts->colliders];
    sn_vec3 local = sn_quat_rotate(sn_quat_conjugate(pose->rotation), sn_sub(at, pose->translation));
    double phi = sn_distance_field_at(collider->field, local, gradient);
    if (gradient != NULL) *gradient = sn_quat_rotate(pose->rotation, *gradient);
    return phi;
}

/* C of a row at these points, and grad phi in the world (nullable). */
static double value_of(const sn_contacts *contacts, const sn_muscle_state *s, const sn_collider *collider, const sn_contact_row *row,
                       const sn_point *points, sn_vec3 *gradient) {
    double phi = distance_of(contacts, s, collider, (sn_index)(row - contacts->rows), sn_contact_point(row, points), gradient);
    return phi - sn_contact_margin(contacts, s, row);
}

double sn_contact_distance(const sn_model_muscle *m, const sn_muscle_state *s, const sn_collider *collider, sn_index r) {
    const sn_contacts *contacts = sn_contacts_of(m);
    sn_vec3 at = sn_contact_point(&contacts->rows[r], s->points);
    return collider->patch != NULL ? sn_patch_distance_exact(collider, s, r, at) : distance_of(contacts, s, collider, r, at, NULL);
}

/* ---- near rows, one collider after the other -------------------------------------------------------------------------------------------
 */

/* The collider of a row, looked for from the one of a row before it. */
static const sn_collider *collider_at(const sn_collider *from, sn_index row) {
    while (row >= from->end) from++;
    return from;
}

static double energy(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, const sn_point *points, double k,
                     sn_forces gradient) {
    const sn_contacts *contacts = m->own[kind];
    const sn_collider *collider = contacts != NULL ? contacts->colliders : NULL;
    double sum = 0.0;
    for (sn_index i = 0; i < s->inputs->near_count && k > 0.0; i++) {
        sn_index r = s->inputs->near[i];
        const sn_contact_row *row = &contacts->rows[r];
        sn_vec3 normal;
        collider = collider_at(collider, r);
        double c = value_of(contacts, s, collider, row, points, gradient.values != NULL ? &normal : NULL);
        double push = fmax(0.0, s->inputs->multipliers[r] - k * c);
        if (!(push > 0.0)) continue;
        sum += push * push / (2.0 * k);
        for (int p = 0; gradient.values != NULL && p < 3 && row->weight[p] > 0.0f; p++) {
            double *to = gradient.values + (size_t)gradient.stride * (size_t)row->point[p], force = push * (double)row->weight[p];
            to[0] -= force * normal.x, to[1] -= force * normal.y, to[2] -= force * normal.z;
        }
    }
    return sum;
}

double sn_contacts_update(const sn_model_muscle *m, sn_muscle_state *s, double k) {
    const sn_contacts *contacts = sn_contacts_of(m);
    sn_index changed = 0, active = 0;
    if (m->contact_count == 0 || !(k > 0.0)) return 0.0;
    const sn_collider *collider = contacts->colliders;
    for (sn_index i = 0; i < s->inputs->near_count; i++) {
        sn_index r = s->inputs->near[i];
        double before = s->inputs->multipliers[r];
        collider = collider_at(collider, r);
        double c = value_of(contacts, s, collider, &contacts->rows[r], s->points, NULL);
        double after = s->inputs->multipliers[r] = fmax(0.0, before - STIFFNESS * k * c);
        changed += (before > 0.0) != (after > 0.0);
        active += before > 0.0 || after > 0.0;
    }
    return active > 0 ? (double)changed / active : 0.0;
}

/* ---- projection
 * -------------------------------------------------------------------------------------------------------------------------- */

/* What a row is looked at with. */
typedef struct pressed {
    const sn_contacts *contacts;
    const sn_muscle_state *s;
    const sn_collider *collider;
} pressed;

/* How a row moves its points: by `way` x weight x inverse mass. */
static void move_points(sn_point *points, const sn_contact_row *row, sn_vec3 way) {
    for (int i = 0; i < 3 && row->weight[i] > 0.0f; i++) {
        sn_point *p = &points[row->point[i]];
        double share = (double)row->weight[i] * p->w;
        p->x += share * way.x, p->y += share * way.y, p->z += share * way.z;
    }
}

static double mobility_of(const sn_point *points, const sn_contact_row *row) {
    double sum = 0.0;
    for (int i = 0; i < 3 && row->weight[i] > 0.0f; i++) sum += (double)row->weight[i] * (double)row->weight[i] * points[row->point[i]].w;
    return sum;
}

/* Coulomb: what slides along the bone since the step began, beside the bone's own motion, is taken back as far as the push allows. */
static void rub(const sn_contacts *contacts, const sn_muscle_state *s, const sn_collider *collider, const sn_contact_row *row,
                sn_vec3 normal, double push) {
    sn_index c = (sn_index)(collider - contacts->colliders);
    sn_vec3 before = sn_v3(0, 0, 0), at = sn_contact_point(row, s->points);
    for (int i = 0; i < 3 && row->weight[i] > 0.0f; i++) before = sn_add_scaled(before, s->previous[row->point[i]], (double)row->weight[i]);
    sn_vec3 stuck =
        collider->patch != NULL
            ? sn_add(before, sn_patch_way(collider, s, (sn_index)(row - contacts->rows), at))
            : sn_rigid_apply(sn_rigid_compose(s->inputs->collider_poses[c], sn_rigid_inverse(s->inputs->collider_placed[c])), before);
    sn_vec3 slip = sn_sub(at, stuck);
    slip = sn_add_scaled(slip, normal, -sn_dot(slip, normal));
    double length = sn_norm(slip), mobility = mobility_of(s->points, row);
    if (!(length > 0.0) || !(mobility > 0.0)) return;
    move_points(s->points, row, sn_scale(slip, -fmin(1.0, contacts->friction * push / length) / mobility));
}

/* Out by the way along the gradient; *normal is its unit vector. How far beyond its margin it was; 0: it was not, or there is no way out.
 */
static double push_out(const pressed *at, const sn_contact_row *row, sn_point *points, sn_vec3 *normal) {
    sn_vec3 gradient;
    double c = value_of(at->contacts, at->s, at->collider, row, points, &gradient);
    if (!(c < 0.0)) return 0.0;
    double mobility = mobility_of(points, row), steep = sn_norm2(gradient);
    if (!(steep > LEAST_GRADIENT * LEAST_GRADIENT) || !(mobility > 0.0)) return 0.0;
    move_points(points, row, sn_scale(gradient, -c / (steep * mobility)));
    *normal = sn_scale(gradient, 1.0 / sqrt(steep));
    return -c;
}

bool sn_contact_project(const sn_model_muscle *m, sn_muscle_state *s, const sn_collider *collider, sn_index r, bool rubs) {
    const sn_contacts *contacts = sn_contacts_of(m);
    const sn_contact_row *row = &contacts->rows[r];
    sn_vec3 normal;
    double deep = push_out(&(pressed){contacts, s, collider}, row, s->points, &normal);
    if (deep > 0.0 && rubs && contacts->friction > 0.0) rub(contacts, s, collider, row, normal, deep);
    return deep > 0.0;
}

bool sn_contacts_clear(const sn_model_muscle *m, const sn_muscle_state *s, sn_point *points) {
    const sn_contacts *contacts = sn_contacts_of(m);
    pressed at = {.contacts = contacts, .s = s, .collider = m->contact_count > 0 ? contacts->colliders : NULL};
    bool moved = false;
    for (sn_index i = 0; i < s->inputs->near_count; i++) {
        sn_index r = s->inputs->near[i];
        sn_vec3 normal;
        at.collider = collider_at(at.collider, r);
        moved = push_out(&at, &contacts->rows[r], points, &normal) > 0.0 || moved;
    }
    return moved;
}

static void sweep(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *how) {
    const sn_contacts *contacts = m->own[kind];
    const sn_collider *collider = contacts->colliders;
    (void)how;
    if (contacts->by_voxels) {
        sn_contact_voxels_sweep(m, s);
        return;
    }
    for (sn_index i = 0; i < s->inputs->near_count; i++) {
        collider = collider_at(collider, s->inputs->near[i]);
        sn_contact_project(m, s, collider, s->inputs->near[i], true);
    }
}

/* The few points of contact are projected in double, and put back. */
static void sweep_single(const sn_model_muscle *m, sn_muscle_state *s, sn_row_kind kind, const sn_sweep *how) {
    const sn_contacts *contacts = m->own[kind];
    sn_xpbd *xpbd = sn_xpbd_of(s);
    sn_vec3 origin = *xpbd->origin;
    for (sn_index i = 0; i < s->inputs->near_count; i++)
        for (int p = 0; p < 3; p++) {
            sn_index v = contacts->rows[s->inputs->near[i]].point[p];
            const sn_single_point *from = &xpbd->single_points[v];
            if (s->points[v].w == 0.0) continue;
            s->points[v].x = origin.x + (double)from->x, s->points[v].y = origin.y + (double)from->y,
            s->points[v].z = origin.z + (double)from->z;
        }
    sweep(m, s, kind, how);
    for (sn_index i = 0; i < s->inputs->near_count; i++)
        for (int p = 0; p < 3; p++) {
            sn_index v = contacts->rows[s->inputs->near[i]].point[p];
            sn_single_point *to = &xpbd->single_points[v];
            if (s->points[v].w == 0.0) continue;
            to->x = (float)(s->points[v].x - origin.x), to->y = (float)(s->points[v].y - origin.y),
            to->z = (float)(s->points[v].z - origin.z);
        }
}

/* ---- what there is to say ---------------------------------------------------------------------------------------------------------------
 */

static sn_index count(const sn_model_muscle *m, sn_row_kind kind) {
    (void)kind;
    return m->contact_count;
}

static const sn_index *points_of(const sn_model_muscle *m, sn_row_kind kind, sn_index row) {
    const sn_contacts *contacts = m->own[kind];
    return contacts->rows[row].point;
}

/* How far row r is beyond its margin, m. */
static double error_of(const sn_model_muscle *m, const sn_muscle_state *s, const sn_collider *collider, sn_index r) {
    const sn_contacts *contacts = sn_contacts_of(m);
    return fmax(0.0, sn_contact_margin(contacts, s, &contacts->rows[r]) - sn_contact_distance(m, s, collider, r));
}

/* In mean edges. */
static void errors(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, sn_index begin, sn_index end, double *out) {
    const sn_contacts *contacts = m->own[kind];
    const sn_collider *collider = contacts != NULL ? contacts->colliders : NULL;
    for (sn_index r = begin; r < end;) {
        collider = collider_at(collider, r);
        sn_approach a = sn_approach_of(m, s, (sn_index)(collider - contacts->colliders));
        sn_contact_block b = sn_contact_block_at(contacts, collider, r, s->points, NULL);
        double distance = sn_approach_distance(&a, &b);
        bool block_near = sn_approach_block_is_near(&b, distance, contacts->margin);
        for (; r < b.end && r < end; r++) {
            sn_vec3 p = sn_contact_point(&contacts->rows[r], s->points);
            bool near = block_near && sn_approach_row_is_near(&a, &b, distance, p, contacts->margin);
            out[r - begin] = near ? error_of(m, s, collider, r) / m->mean_edge : 0.0;
        }
    }
}

/* Margins are floats: a vertex is not deeper than at rest by less than this share of the diagonal. */
static const double DEPTH_NOISE = 1e-7;

static void measure_row(const sn_model_muscle *m, const sn_muscle_state *s, const sn_collider *collider, sn_index r, sn_statistics *out) {
    const sn_contacts *contacts = sn_contacts_of(m);
    const sn_contact_row *row = &contacts->rows[r];
    double phi = sn_contact_distance(m, s, collider, r), value = phi - sn_contact_margin(contacts, s, row);
    double depth = fmin(0.0, (double)row->margin) - phi;
    out->overlap = fmax(out->overlap, -phi);
    if (contacts->by_voxels)
        out->contacts +=
            sn_contact_voxels_touch(collider, &s->inputs->collider_poses[collider - contacts->colliders], sn_contact_point(row, s->points));
    else
        out->contacts += m->quasi_newton ? s->inputs->multipliers[r] > 0.0 : value <= 1e-9 * m->diagonal;
    if (!(depth > out->penetration) || !(depth > DEPTH_NOISE * m->diagonal)) return;
    out->penetration = depth;
    out->penetration_vertex = row->point[0];
    out->penetration_bone = collider->bone;
}

void sn_contacts_measure(const sn_model_muscle *m, const sn_muscle_state *s, sn_statistics *out) {
    const sn_contacts *contacts = sn_contacts_of(m);
    out->contacts = 0;
    out->penetration = out->overlap = 0.0;
    out->penetration_vertex = out->penetration_bone = SN_NONE;
    for (sn_index c = 0; c < m->collider_count; c++) {
        const sn_collider *collider = &contacts->colliders[c];
        sn_approach a = sn_approach_of(m, s, c);
        double reach = contacts->margin + 1e-9 * m->diagonal;
        for (sn_index begin = collider->begin; begin < collider->end; begin += SN_CONTACT_BLOCK) {
            sn_contact_block b = sn_contact_block_at(contacts, collider, begin, s->points, NULL);
            double distance = contacts->by_voxels ? -INFINITY : sn_approach_distance(&a, &b); /* these ask every vertex */
            bool near = sn_approach_block_is_near(&b, distance, reach);
            for (sn_index r = b.begin; near && r < b.end; r++)
                if (sn_approach_row_is_near(&a, &b, distance, sn_contact_point(&contacts->rows[r], s->points), reach))
                    measure_row(m, s, collider, r, out);
        }
    }
}

static double factor(const sn_scene_muscle *source) {
    (void)source;
    return STIFFNESS;
}

static size_t row_bytes(const sn_model_muscle *m) {
    return sizeof(sn_contact_row) + sizeof(sn_index) + (m->quasi_newton ? sizeof(double) : 0);
}

static size_t own_bytes(const sn_model_muscle *m, sn_row_kind kind) {
    if (m->own[kind] == NULL) return 0;
    const sn_contacts *contacts = m->own[kind];
    size_t bytes =
        sizeof(sn_contacts) + (size_t)m->collider_count * sizeof(sn_collider) + (size_t)m->contact_count * sizeof(sn_contact_row);
    for (sn_index c = 0; c < m->collider_count; c++) {
        const sn_patch *patch = contacts->colliders[c].patch;
        if (patch != NULL) bytes += sizeof *patch + sn_moving_bytes(&patch->moving) + (size_t)patch->moving.vertex_count * sizeof(sn_index);
    }
    return bytes;
}

const sn_row_ops sn_rows_contact = {
    .info = {.name = "contact", .errors = "depth beyond the margin of contact, mean edges", .lacks = "", .points = 3},
    .rigid = true,
    .reason = sn_contacts_reason,
    .factor = factor,
    .build = sn_contacts_build,
    .destroy = sn_contacts_destroy,
    .own_bytes = own_bytes,
    .count = count,
    .points = points_of,
    .bytes = row_bytes,
    .sweep = sweep,
    .sweep_single = sweep_single,
    .energy = energy,
    .errors = errors,
};
