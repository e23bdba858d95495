/*
 * group.c -- which muscles are solved together, and what that comes to.
 */
#include "group.h"

#include <stdlib.h>

static bool allocate(sn_index count, sn_group *out) {
    *out = (sn_group){.count = count,
                      .muscles = SN_NEW(sn_index, count),
                      .members = SN_NEW(const sn_model_muscle *, count),
                      .first = SN_NEW(sn_index, (size_t)count + 1),
                      .corotated = true};
    return out->muscles != NULL && out->members != NULL && out->first != NULL;
}

static void add_member(const sn_model *model, sn_index member, sn_index muscle, sn_group *out) {
    const sn_model_muscle *m = &model->muscles[muscle];
    out->muscles[member] = muscle;
    out->members[member] = m;
    out->first[member + 1] = out->point_count += m->point_count;
    if (m->iterations > out->iterations) out->iterations = m->iterations;
    out->keeps_volume = out->keeps_volume || m->keeps_volume;
    out->corotated = out->corotated && m->corotated;
    out->two_level = out->two_level || m->two_level;
}

sn_status sn_group_create(const sn_model *model, sn_index count, const sn_index *muscles, sn_group *out, sn_error *error) {
    if (!allocate(count, out)) {
        sn_group_free(out);
        return sn_fail_memory(error, "a group of muscles");
    }
    for (sn_index i = 0; i < count; i++) add_member(model, i, muscles[i], out);
    out->substeps = sn_solver_substeps(&model->scene->solver);
    out->substep_duration = model->substep_duration;
    out->halves = model->halves;
    return SN_OK;
}

void sn_group_free(sn_group *group) {
    free(group->muscles);
    free((void *)group->members);
    free(group->first);
    *group = (sn_group){.count = 0};
}

sn_status sn_groups_build(sn_model *model, sn_error *error) {
    if ((model->groups = SN_NEW(sn_group, model->muscle_count)) == NULL) return sn_fail_memory(error, "groups of muscles");
    for (sn_index i = 0; i < model->muscle_count; i++) {
        sn_status status = sn_group_create(model, 1, &i, &model->groups[i], error);
        if (status != SN_OK) return status;
        model->group_count = i + 1;
        model->muscles[i].group = i;
        model->muscles[i].member = 0;
    }
    return SN_OK;
}

void sn_groups_free(sn_model *model) {
    for (sn_index i = 0; i < model->group_count; i++) sn_group_free(&model->groups[i]);
    free(model->groups);
}

sn_index sn_most_substeps(const sn_model *model) {
    sn_index most = model->group_count > 0 ? 0 : sn_solver_substeps(&model->scene->solver);
    for (sn_index i = 0; i < model->group_count; i++)
        if (model->groups[i].substeps > most) most = model->groups[i].substeps;
    return most;
}
