/*
 * xpbd.c -- back end `xpbd`: one substep of one muscle.   [R18] alg. 1, methods.md 8.7, numerics.md 2
 *
 * v <- (v + h g) e^(-c h), x <- x + h v; attached vertices to their bones; per iteration every group of rows in order, volume last;
 * v <- (x - x_before) / h. Lambda starts at 0 in each substep (never in each iteration).
 */
#include "rows.h"

/* Where each point would be without constraints. Damping is a rate: exact for any h. */
static void predict(const sn_model_muscle *m, sn_muscle_state *s, sn_vec3 gravity, double h) {
    double keep = exp(-m->source->damping * h);
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_point *p = &s->points[i];
        s->previous[i] = sn_point_position(p);
        if (p->w == 0.0) continue;
        sn_vec3 v = s->velocities[i] = sn_scale(sn_add_scaled(s->velocities[i], gravity, h), keep);
        p->x += h * v.x, p->y += h * v.y, p->z += h * v.z;
    }
}

static void project(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep) {
    double compliance[SN_ROW_KINDS];
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) compliance[kind] = sn_row_compliance(m, s, (sn_row_kind)kind, substep->h);
    for (sn_index i = substep->begin; i < substep->end; i++) {
        bool first = i == 0;
        for (int kind = 0; kind < SN_DISTANCE_KINDS; kind++)
            if (compliance[kind] >= 0.0) sn_distance_sweep(m, s, (sn_row_kind)kind, compliance[kind], first);
        if (compliance[SN_ROWS_DIHEDRAL] >= 0.0) sn_hinge_sweep(m, s, compliance[SN_ROWS_DIHEDRAL], first);
        if (m->keeps_volume && compliance[SN_ROWS_VOLUME] >= 0.0) sn_volume_sweep(m, s, compliance[SN_ROWS_VOLUME], first);
    }
}

static void update_velocities(const sn_model_muscle *m, sn_muscle_state *s, double h) {
    for (sn_index i = 0; i < m->point_count; i++)
        s->velocities[i] = sn_scale(sn_sub(sn_point_position(&s->points[i]), s->previous[i]), 1.0 / h);
}

static void xpbd_substep(const sn_model_muscle *m, sn_muscle_state *s, const sn_substep *substep) {
    if (substep->begin == 0) {
        predict(m, s, substep->gravity, substep->h);
        sn_kinematics_place(m, s, substep->poses);
    }
    project(m, s, substep);
    update_velocities(m, s, substep->h);
}

const sn_backend sn_backend_xpbd = {.name = "xpbd", .substep = xpbd_substep};
