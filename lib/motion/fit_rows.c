/*
 * fit_rows.c -- the table that binds a motion to a body: what its names mean, and the order of its joints.
 */
#include "sinew/motion_fit.h"

#include <stdlib.h>
#include <string.h>

const char *const sn_fit_rule_names[] = {"point", "mean", "sphere", "middle", "axis", NULL};

sn_index sn_fit_rule_selections(sn_fit_rule_kind kind) {
    static const sn_index counts[] = {0, 1, 1, 2, 2};
    return counts[kind];
}

/* One star at a time: behind the last one everything else has been matched as early as it can be. */
bool sn_fit_matches(const char *pattern, const char *name) {
    const char *star = NULL, *taken = NULL;
    while (*name != '\0') {
        if (*pattern == '*') {
            star = ++pattern;
            taken = name;
        } else if (*pattern == *name || *pattern == '?') {
            pattern++;
            name++;
        } else if (star != NULL) {
            pattern = star;
            name = ++taken;
        } else {
            return false;
        }
    }
    while (*pattern == '*') pattern++;
    return *pattern == '\0';
}

/* ---- freeing -------------------------------------------------------------------------------------------------------------------- */

static void free_point(sn_fit_point *point) {
    free(point->name);
    free(point->source);
    for (int i = 0; i < 2; i++) free(point->rule.selections[i].bones);
}

static void free_joint(sn_fit_joint *joint) {
    free(joint->parent_name);
    for (int i = 0; i < 2; i++) {
        free(joint->along.names[i]);
        free(joint->aside.names[i]);
    }
}

void sn_fit_table_free(sn_fit_table *table) {
    for (sn_index i = 0; i < table->point_count; i++) free_point(&table->points[i]);
    for (sn_index i = 0; i < table->joint_count; i++) free_joint(&table->joints[i]);
    for (sn_index i = 0; i < table->bone_count; i++) {
        free(table->bones[i].pattern);
        free(table->bones[i].joint_name);
    }
    for (sn_index i = 0; i < table->leg_count; i++)
        for (int k = 0; k < 3; k++) free(table->legs[i].names[k]);
    for (sn_index i = 0; i < table->foot_count; i++) free(table->feet[i].name);
    for (sn_index i = 0; i < table->meet_count; i++) {
        free(table->meets[i].joint_name);
        for (int k = 0; k < 2; k++) free(table->meets[i].patterns[k]);
    }
    free(table->name);
    free(table->folder);
    free(table->points);
    free(table->joints);
    free(table->bones);
    free(table->legs);
    free(table->feet);
    free(table->meets);
    *table = (sn_fit_table){0};
}

/* ---- names ---------------------------------------------------------------------------------------------------------------------- */

static sn_index find_point(const sn_fit_table *table, sn_index count, const char *name) {
    for (sn_index i = 0; i < count; i++)
        if (strcmp(table->points[i].name, name) == 0) return i;
    return SN_NONE;
}

static sn_status find_named(const sn_fit_table *table, bool joints, const char *name, int64_t line, sn_index *out, sn_error *error) {
    *out = find_point(table, joints ? table->joint_count : table->point_count, name);
    if (*out != SN_NONE) return SN_OK;
    return sn_fail_at(error, SN_ERROR_INPUT, table->name, line, "no row names the %s \"%s\"", joints ? "joint" : "joint or place", name);
}

static sn_status check_twins(const sn_fit_table *table, sn_error *error) {
    for (sn_index i = 1; i < table->point_count; i++) {
        sn_index twin = find_point(table, i, table->points[i].name);
        if (twin != SN_NONE)
            return sn_fail_at(error, SN_ERROR_INPUT, table->name, table->points[i].line, "\"%s\" is already the name of line %lld",
                              table->points[i].name, (long long)table->points[twin].line);
    }
    return SN_OK;
}

/* ---- the order of joints ----------------------------------------------------------------------------------------------------------- */

/* Parents by their places in the file; exactly one joint has none. */
static sn_status find_parents(sn_fit_table *table, sn_error *error) {
    sn_index root = SN_NONE;
    for (sn_index j = 0; j < table->joint_count; j++) {
        sn_fit_joint *joint = &table->joints[j];
        int64_t line = table->points[j].line;
        joint->parent = SN_NONE;
        if (joint->parent_name != NULL) {
            sn_status status = find_named(table, true, joint->parent_name, line, &joint->parent, error);
            if (status != SN_OK) return status;
        } else if (root != SN_NONE) {
            return sn_fail_at(error, SN_ERROR_INPUT, table->name, line,
                              "joint \"%s\" has no parent, and neither has \"%s\"; one of them carries the other", table->points[j].name,
                              table->points[root].name);
        } else {
            root = j;
        }
    }
    return SN_OK;
}

/* order (joint_count): joints, parents before children, else as in the file; returns how many could be placed. */
static sn_index order_joints(const sn_fit_table *table, sn_index *order, sn_index *place) {
    sn_index placed = 0, before = -1;
    for (sn_index j = 0; j < table->joint_count; j++) place[j] = SN_NONE;
    while (placed > before) {
        before = placed;
        for (sn_index j = 0; j < table->joint_count; j++) {
            sn_index parent = table->joints[j].parent;
            if (place[j] != SN_NONE || (parent != SN_NONE && place[parent] == SN_NONE)) continue;
            place[j] = placed;
            order[placed++] = j;
        }
    }
    return placed;
}

static sn_status apply_order(sn_fit_table *table, const sn_index *order, const sn_index *place, sn_error *error) {
    sn_fit_joint *joints = SN_NEW(sn_fit_joint, table->joint_count);
    sn_fit_point *points = SN_NEW(sn_fit_point, table->joint_count);
    if (joints == NULL || points == NULL) {
        free(joints);
        free(points);
        return sn_fail_memory(error, "the joints");
    }
    for (sn_index i = 0; i < table->joint_count; i++) {
        joints[i] = table->joints[order[i]];
        points[i] = table->points[order[i]];
        if (joints[i].parent != SN_NONE) joints[i].parent = place[joints[i].parent];
    }
    memcpy(table->joints, joints, (size_t)table->joint_count * sizeof *joints);
    memcpy(table->points, points, (size_t)table->joint_count * sizeof *points);
    free(joints);
    free(points);
    return SN_OK;
}

static sn_status sort_joints(sn_fit_table *table, sn_error *error) {
    sn_index *order = SN_NEW(sn_index, table->joint_count), *place = SN_NEW(sn_index, table->joint_count);
    sn_status status = order != NULL && place != NULL ? SN_OK : sn_fail_memory(error, "the joints");
    if (status == SN_OK && order_joints(table, order, place) < table->joint_count) {
        sn_index j = 0;
        while (place[j] != SN_NONE) j++;
        status = sn_fail_at(error, SN_ERROR_INPUT, table->name, table->points[j].line,
                            "joint \"%s\" hangs on itself: its parents go round in a circle", table->points[j].name);
    }
    if (status == SN_OK) status = apply_order(table, order, place, error);
    free(order);
    free(place);
    return status;
}

/* ---- linking --------------------------------------------------------------------------------------------------------------------- */

static sn_index only_child(const sn_fit_table *table, sn_index j) {
    sn_index found = SN_NONE, count = 0;
    for (sn_index i = j + 1; i < table->joint_count; i++)
        if (table->joints[i].parent == j) {
            found = i;
            count++;
        }
    return count == 1 ? found : SN_NONE;
}

static sn_status link_direction(const sn_fit_table *table, sn_index j, sn_fit_direction *direction, sn_error *error) {
    direction->from = j;
    if (!direction->given) return SN_OK;
    int64_t line = table->points[j].line;
    sn_status status = find_named(table, false, direction->names[1], line, &direction->to, error);
    if (status == SN_OK && direction->names[0] != NULL)
        status = find_named(table, false, direction->names[0], line, &direction->from, error);
    if (status == SN_OK && direction->from == direction->to)
        status = sn_fail_at(error, SN_ERROR_INPUT, table->name, line, "a direction from \"%s\" to itself", direction->names[1]);
    for (int i = 0; i < 2 && status == SN_OK; i++) {
        const sn_fit_point *point = &table->points[i == 0 ? direction->from : direction->to];
        if (point->source == NULL)
            status = sn_fail_at(error, SN_ERROR_INPUT, table->name, line, "\"%s\" is nowhere in the source: no direction leads there",
                                point->name);
    }
    return status;
}

static sn_status link_joint(sn_fit_table *table, sn_index j, sn_error *error) {
    sn_fit_joint *joint = &table->joints[j];
    sn_index child = only_child(table, j);
    if (joint->parent == SN_NONE && table->points[j].source == NULL)
        return sn_fail_at(error, SN_ERROR_INPUT, table->name, table->points[j].line, "joint \"%s\" has neither a parent nor a source",
                          table->points[j].name);
    sn_status status = link_direction(table, j, &joint->along, error);
    if (status == SN_OK) status = link_direction(table, j, &joint->aside, error);
    if (status != SN_OK || joint->along.given || joint->inherits) return status;
    if (child == SN_NONE || table->points[child].source == NULL || table->points[j].source == NULL) {
        joint->inherits = true;
        return SN_OK;
    }
    joint->along = (sn_fit_direction){.given = true, .names = {NULL, sn_strdup(table->points[child].name)}, .from = j, .to = child};
    return joint->along.names[1] != NULL ? SN_OK : sn_fail_memory(error, "a direction");
}

static sn_status link_rows(sn_fit_table *table, sn_error *error) {
    sn_status status = SN_OK;
    for (sn_index i = 0; i < table->bone_count && status == SN_OK; i++)
        status = find_named(table, true, table->bones[i].joint_name, table->bones[i].line, &table->bones[i].joint, error);
    for (sn_index i = 0; i < table->foot_count && status == SN_OK; i++)
        status = find_named(table, true, table->feet[i].name, table->feet[i].line, &table->feet[i].joint, error);
    for (sn_index i = 0; i < table->meet_count && status == SN_OK; i++)
        status = find_named(table, true, table->meets[i].joint_name, table->meets[i].line, &table->meets[i].joint, error);
    for (sn_index i = 0; i < 3 * table->leg_count && status == SN_OK; i++) {
        sn_fit_leg *leg = &table->legs[i / 3];
        status = find_named(table, true, leg->names[i % 3], leg->line, &leg->joints[i % 3], error);
        if (status == SN_OK && table->points[leg->joints[i % 3]].source == NULL)
            status = sn_fail_at(error, SN_ERROR_INPUT, table->name, leg->line, "joint \"%s\" of a leg has no source", leg->names[i % 3]);
    }
    return status;
}

sn_status sn_fit_table_link(sn_fit_table *table, sn_error *error) {
    if (table->joint_count == 0) return sn_fail_at(error, SN_ERROR_INPUT, table->name, 0, "there is no row \"joint\"");
    if (table->bone_count == 0) return sn_fail_at(error, SN_ERROR_INPUT, table->name, 0, "there is no row \"bone\"");
    sn_status status = check_twins(table, error);
    if (status == SN_OK) status = find_parents(table, error);
    if (status == SN_OK) status = sort_joints(table, error);
    for (sn_index j = 0; j < table->joint_count && status == SN_OK; j++) status = link_joint(table, j, error);
    return status == SN_OK ? link_rows(table, error) : status;
}

sn_index sn_fit_table_row(const sn_fit_table *table, const char *bone) {
    for (sn_index i = 0; i < table->bone_count; i++)
        if (sn_fit_matches(table->bones[i].pattern, bone)) return i;
    return SN_NONE;
}

bool sn_fit_below(const sn_fit_table *table, sn_index j, sn_index top) {
    while (j != SN_NONE && j != top) j = table->joints[j].parent;
    return j == top;
}
