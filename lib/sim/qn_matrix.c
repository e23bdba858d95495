/*
 * qn_matrix.c -- the matrix that a step of the back end `qn` goes by, from the state; and what all of its parts tell each other.
 */
#include "qn.h"
#include "skin.h"

void sn_qn_forget_pairs(sn_qn *qn) { qn->pair_count = qn->pair_next = 0; }

void sn_qn_stop(sn_group_state *s, const sn_group *g, sn_stop_reason reason) {
    sn_qn_of(s)->stopped = reason;
    for (sn_index i = 0; i < g->count; i++) s->members[i]->statistics.stop_reason = reason;
}

double sn_qn_double_area(const sn_point *points, const sn_index *v) {
    sn_vec3 a = sn_point_position(&points[v[0]]), b = sn_point_position(&points[v[1]]), c = sn_point_position(&points[v[2]]);
    return sn_norm(sn_area_vector(a, b, c));
}

/* ---- the matrix ------------------------------------------------------------------------------------------------------------- */

void sn_qn_take_stiffness(const sn_group *g, sn_group_state *s) {
    sn_qn *qn = sn_qn_of(s);
    for (sn_index i = 0; i < g->count; i++) {
        qn->stiffness[i] = s->members[i]->inputs->stiffness;
        qn->volume_stiffness[i] = g->members[i]->keeps_volume ? sn_row_stiffness(g->members[i], s->members[i], SN_ROWS_VOLUME) : 0.0;
    }
}

bool sn_qn_go_by(const sn_group *g, sn_group_state *s, double h, bool *changed) {
    sn_qn *qn = sn_qn_of(s);
    sn_quat *turns = qn->turned && g->corotated ? qn->turns : NULL;
    return sn_preconditioner_update(qn->preconditioner, h, qn->stiffness, turns, qn->factor_stiffness, changed);
}

void sn_qn_set_volume_rows(sn_qn *qn, const sn_vec3 *gradient) {
    sn_preconditioner_set_volume(qn->preconditioner, gradient, qn->volume_stiffness);
}

void sn_qn_find_volume_gradient(const sn_group *g, sn_group_state *s) {
    for (sn_index i = 0; i < g->count && g->keeps_volume; i++)
        if (g->members[i]->skin_edge_count > 0) sn_skin_volume_gradient(g->members[i], s->members[i]);
}

void sn_qn_take_volume_gradient(const sn_group *g, sn_group_state *s) {
    sn_qn *qn = sn_qn_of(s);
    sn_qn_find_volume_gradient(g, s);
    if (g->keeps_volume) memcpy(qn->row_gradient, qn->volume_gradient, (size_t)g->point_count * sizeof *qn->row_gradient);
    sn_qn_set_volume_rows(qn, qn->row_gradient);
}

void sn_qn_take_matrix_here(const sn_group *g, sn_group_state *s, double h) {
    sn_qn *qn = sn_qn_of(s);
    if (!sn_preconditioner_stand(qn->preconditioner, s->points, h, qn->stiffness)) sn_qn_stop(s, g, SN_STOP_FAILED);
    for (sn_index i = 0; i < g->count; i++) s->members[i]->statistics.refactorisations++;
    sn_qn_take_volume_gradient(g, s);
}
