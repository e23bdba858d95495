/*
 * trial_matrix.c -- the matrix of a group beside any run, to say what it costs.
 */
#include "qn.h"

#include <stdlib.h>

struct sn_trial_matrix {
    const sn_group *group;
    sn_preconditioner *preconditioner;
    double *stiffness, *factored_for; /* (group.count) */
    sn_vec3 *direction;               /* (group.point_count) */
    double h;                         /* s: of the last factor; each is made for a little longer step, or it would be the last one's */
};

static const double OTHER_STEP = 1.0 + 1e-9;

sn_status sn_trial_matrix_create(const sn_model *model, sn_index group, sn_trial_matrix **out, sn_error *error) {
    const sn_group *g = &model->groups[group];
    sn_trial_matrix *t = *out = SN_NEW(sn_trial_matrix, 1);
    if (t == NULL) return sn_fail_memory(error, "a matrix on trial");
    *t = (sn_trial_matrix){.group = g,
                           .stiffness = SN_NEW(double, g->count),
                           .factored_for = SN_NEW(double, g->count),
                           .direction = SN_NEW(sn_vec3, g->point_count),
                           .h = g->substep_duration};
    bool made = t->stiffness != NULL && t->factored_for != NULL && t->direction != NULL;
    for (sn_index i = 0; i < g->count && made; i++) t->stiffness[i] = sn_stiffness_at(g->members[i], 0.0);
    sn_status status = made ? SN_OK : sn_fail_memory(error, "a matrix on trial");
    if (status == SN_OK) status = sn_preconditioner_create(g->count, g->members, &t->preconditioner, error);
    if (status == SN_OK) status = sn_preconditioner_couple(t->preconditioner, g, error);
    if (status == SN_OK) return SN_OK;
    sn_trial_matrix_destroy(t);
    *out = NULL;
    return status;
}

sn_status sn_trial_matrix_factor(sn_trial_matrix *t, sn_error *error) {
    bool changed;
    t->h *= OTHER_STEP;
    for (sn_index i = 0; i < t->group->count; i++)
        t->stiffness[i] *= OTHER_STEP, t->factored_for[i] = NAN; /* a large one asks for these alone */
    if (sn_preconditioner_update(t->preconditioner, t->h, t->stiffness, NULL, t->factored_for, &changed)) return SN_OK;
    return sn_fail(error, SN_ERROR_INTERNAL, "the matrix of muscle \"%s\" has no factor", t->group->members[0]->source->name);
}

sn_status sn_trial_matrix_solve(sn_trial_matrix *t, sn_error *error) {
    for (sn_index i = 0; i < t->group->point_count; i++) t->direction[i] = sn_v3(1.0, -1.0, 0.5);
    if (sn_preconditioner_apply(t->preconditioner, t->direction, t->direction)) return SN_OK;
    return sn_fail(error, SN_ERROR_INTERNAL, "the matrix of muscle \"%s\" cannot be solved with", t->group->members[0]->source->name);
}

int64_t sn_trial_matrix_entries(const sn_trial_matrix *t) { return sn_preconditioner_entries(t->preconditioner); }

size_t sn_trial_matrix_bytes(const sn_trial_matrix *t) { return sn_preconditioner_bytes(t->preconditioner); }

void sn_trial_matrix_destroy(sn_trial_matrix *t) {
    if (t == NULL) return;
    sn_preconditioner_destroy(t->preconditioner);
    free(t->stiffness);
    free(t->factored_for);
    free(t->direction);
    free(t);
}
