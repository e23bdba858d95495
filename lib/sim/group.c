/*
 * group.c -- which muscles are solved together, and what that comes to.
 */
#include "external.h"

#include <stdlib.h>
#include <string.h>

/* Points of a large group. Of the 251 of a dog that are tied a factor of 75,000 free points takes 2.2 s, and a frame of 20 iterations 2.0
 * s. */
enum { LARGE_GROUP = 20000 };

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
    out->large = count > 1 && out->point_count >= LARGE_GROUP;
    out->halves = model->halves && !out->large;
    return SN_OK;
}

void sn_group_free(sn_group *group) {
    free(group->muscles);
    free((void *)group->members);
    free(group->first);
    sn_external_targets_free(group);
    *group = (sn_group){.count = 0};
}

/* ---- of a model ------------------------------------------------------------------------------------------------------------------ */

/* Members of one group by name, so that they are solved in one order whatever the scene's is. */
typedef struct named {
    const char *name;
    sn_index muscle;
} named;

static int compare_names(const void *a, const void *b) {
    const named *p = a, *q = b;
    int order = p->name != NULL && q->name != NULL ? strcmp(p->name, q->name) : 0;
    return order != 0 ? order : (p->muscle > q->muscle) - (p->muscle < q->muscle);
}

static void tell_members(sn_model *model, sn_index number) {
    const sn_group *g = &model->groups[number];
    for (sn_index i = 0; i < g->count; i++) {
        sn_model_muscle *m = &model->muscles[g->muscles[i]];
        m->group = number;
        m->member = i;
        m->coupled = g->row_count > 0;
    }
    if (g->target_points > 0) model->muscles[g->muscles[0]].pose_count = model->scene->motion.joint_count;
}

/* The group of all muscles whose parent is `first`; room (muscle_count) is scratch. */
static sn_status add_group(sn_model *model, const sn_index *parents, sn_index first, named *room, sn_index *muscles, sn_error *error) {
    sn_index count = 0;
    for (sn_index i = 0; i < model->muscle_count; i++)
        if (parents[i] == first) room[count++] = (named){model->muscles[i].source->name, i};
    qsort(room, (size_t)count, sizeof *room, compare_names);
    for (sn_index i = 0; i < count; i++) muscles[i] = room[i].muscle;
    sn_group *g = &model->groups[model->group_count];
    sn_status status = sn_group_create(model, count, muscles, g, error);
    if (status != SN_OK) return status;
    model->group_count++;
    status = sn_externals_build(model, g, error);
    g->one_way = g->row_count > 0 && sn_scheme_rules_of(&model->scene->solver)->one_way;
    g->corotated = g->corotated && g->row_count == 0; /* it knows nothing of other muscles */
    tell_members(model, model->group_count - 1);
    return status;
}

sn_status sn_groups_build(sn_model *model, sn_error *error) {
    sn_index n = model->muscle_count, *parents = SN_NEW(sn_index, n), *muscles = SN_NEW(sn_index, n);
    named *room = SN_NEW(named, n);
    model->groups = SN_NEW(sn_group, n);
    bool enough = parents != NULL && muscles != NULL && room != NULL && model->groups != NULL;
    sn_status status = enough ? SN_OK : sn_fail_memory(error, "groups of muscles");
    for (sn_index i = 0; i < n && enough; i++) parents[i] = i;
    if (status == SN_OK) status = sn_externals_join(model, parents, error);
    for (sn_index i = 0; i < n && status == SN_OK; i++) parents[i] = sn_set_of(parents, i);
    for (sn_index i = 0; i < n && status == SN_OK; i++)
        if (parents[i] == i) status = add_group(model, parents, i, room, muscles, error);
    free(parents);
    free(muscles);
    free(room);
    return status;
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
