/*
 * row_table.c -- the kinds of rows, one entry each: the only place that knows which there are.
 */
#include "rows.h"

const sn_row_ops *sn_row_ops_of(sn_row_kind kind) {
    static const sn_row_ops *const TABLE[SN_ROW_KINDS] = {
#define ENTRY(id, name) &sn_rows_##name,
        SN_ROW_LIST(ENTRY)
#undef ENTRY
    };
    return TABLE[kind];
}

const sn_row_info *sn_row_info_of(sn_row_kind kind) { return &sn_row_ops_of(kind)->info; }

const char *sn_row_kind_name(sn_row_kind kind) { return sn_row_info_of(kind)->name; }

/* ---- what walks the whole table --------------------------------------------------------------------------------------------- */

double sn_row_stiffness(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind) {
    const sn_row_ops *ops = sn_row_ops_of(kind);
    double k = ops->factor != NULL ? s->inputs->stiffness * ops->factor(m->source) : s->inputs->stiffness;
    return ops->per_volume ? k / fabs(m->rest_volume) : k;
}

double sn_rows_energy(const sn_model_muscle *m, const sn_muscle_state *s, sn_row_kind kind, const sn_point *points, sn_forces gradient) {
    const sn_row_ops *ops = sn_row_ops_of(kind);
    if (ops->count(m, kind) == 0) return 0.0;
    return ops->energy(m, s, kind, points, sn_row_stiffness(m, s, kind), gradient);
}

void sn_rows_goals(const sn_model_muscle *m, sn_muscle_state *s) {
    if (s->inputs->goal_contraction == s->inputs->contraction && s->inputs->goal_ratio == s->inputs->volume_goal) return;
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        const sn_row_ops *ops = sn_row_ops_of((sn_row_kind)kind);
        if (ops->goals != NULL) ops->goals(m, s, (sn_row_kind)kind);
    }
    s->inputs->goal_contraction = s->inputs->contraction;
    s->inputs->goal_ratio = s->inputs->volume_goal;
}

bool sn_rows_at(const sn_model_muscle *m, const sn_vec3 *positions, sn_rest_visit visit, void *user) {
    bool going = true;
    for (int kind = 0; kind < SN_ROW_KINDS && going; kind++) {
        const sn_row_ops *ops = sn_row_ops_of((sn_row_kind)kind);
        if (ops->linearise != NULL) going = ops->linearise(m, (sn_row_kind)kind, positions, visit, user);
    }
    return going;
}

sn_status sn_rows_build(const sn_build *build, sn_error *error) {
    sn_status status = SN_OK;
    for (int kind = 0; kind < SN_ROW_KINDS && status == SN_OK; kind++) {
        const sn_row_ops *ops = sn_row_ops_of((sn_row_kind)kind);
        if (ops->build != NULL) status = ops->build(build, (sn_row_kind)kind, error);
    }
    return status;
}

void sn_rows_destroy(sn_model_muscle *m) {
    for (int kind = 0; kind < SN_ROW_KINDS; kind++) {
        const sn_row_ops *ops = sn_row_ops_of((sn_row_kind)kind);
        if (ops->destroy != NULL) ops->destroy(m, (sn_row_kind)kind);
    }
}
