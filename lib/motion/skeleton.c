/* skeleton.c -- a skeleton: put together, checked, and its bodies' frames from its coordinates. */
#include "sinew/skeleton.h"

#include <stdlib.h>
#include <string.h>

/* ---- put together ---------------------------------------------------------------------------------------------------------------- */

sn_status sn_skeleton_add_move(sn_skeleton_body *body, sn_move move, sn_error *error) {
    sn_index count = body->move_count;
    bool full = count == 0 || (count >= 8 && (count & (count - 1)) == 0); /* room doubles from 8 */
    sn_move *more = full ? sn_realloc(body->moves, count == 0 ? 8 : 2 * (size_t)count, sizeof *more) : body->moves;
    if (more == NULL) {
        sn_function_free(move.function);
        return sn_fail_memory(error, "the moves of a joint");
    }
    body->moves = more;
    body->moves[body->move_count++] = move;
    return SN_OK;
}

void sn_skeleton_reverse_moves(sn_skeleton_body *body, sn_index first, sn_index end) {
    for (sn_index i = first; i < end; i++) body->moves[i].inverse = !body->moves[i].inverse;
    for (sn_index i = first, j = end - 1; i < j; i++, j--) {
        sn_move swapped = body->moves[i];
        body->moves[i] = body->moves[j];
        body->moves[j] = swapped;
    }
}

void sn_skeleton_free_body(sn_skeleton_body *body) {
    for (sn_index i = 0; i < body->move_count; i++) sn_function_free(body->moves[i].function);
    free(body->moves);
    free(body->name);
    *body = (sn_skeleton_body){0};
}

void sn_skeleton_free(sn_skeleton *s) {
    for (sn_index i = 0; i < s->body_count; i++) sn_skeleton_free_body(&s->bodies[i]);
    for (sn_index i = 0; i < s->coordinate_count; i++) {
        free(s->coordinates[i].name);
        free(s->coordinates[i].joint);
    }
    for (sn_index i = 0; i < s->coupler_count; i++) sn_function_free(s->couplers[i].function);
    for (sn_index i = 0; i < s->mesh_count; i++) {
        free(s->meshes[i].name);
        free(s->meshes[i].file);
    }
    free(s->bodies);
    free(s->coordinates);
    free(s->couplers);
    free(s->meshes);
    free(s->name);
    *s = (sn_skeleton){0};
}

/* ---- checks -------------------------------------------------------------------------------------------------------------------------- */

static bool finite_rigid(const sn_rigid *t) {
    return isfinite(t->rotation.w) && isfinite(t->rotation.x) && isfinite(t->rotation.y) && isfinite(t->rotation.z) &&
           sn_finite3(t->translation);
}

static bool good_move(const sn_skeleton *s, const sn_move *move) {
    sn_index used = move->kind == SN_MOVE_FIXED ? 0 : move->kind == SN_MOVE_SPIN ? 3 : 1;
    for (sn_index i = 0; i < used; i++)
        if (move->coordinates[i] < 0 || move->coordinates[i] >= s->coordinate_count) return false;
    return move->kind == SN_MOVE_FIXED ? finite_rigid(&move->fixed) : sn_finite3(move->axis);
}

static sn_status check_body(const sn_skeleton *s, sn_index index, sn_error *error) {
    const sn_skeleton_body *body = &s->bodies[index];
    if (body->name == NULL || *body->name == '\0') return sn_fail(error, SN_ERROR_INPUT, "body %d has no name", (int)index + 1);
    for (sn_index i = 0; i < index; i++)
        if (strcmp(s->bodies[i].name, body->name) == 0)
            return sn_fail(error, SN_ERROR_INPUT, "two bodies are called \"%.100s\"; rename one", body->name);
    bool good = body->parent >= SN_NONE && body->parent < index && sn_finite3(body->centre);
    for (sn_index i = 0; i < body->move_count && good; i++) good = good_move(s, &body->moves[i]);
    return good ? SN_OK : sn_fail(error, SN_ERROR_INPUT, "body \"%.100s\": a number of its joint is not finite", body->name);
}

static bool same_text(const char *a, const char *b) { return a == NULL || b == NULL ? a == b : strcmp(a, b) == 0; }

static sn_status check_coordinate(const sn_skeleton *s, sn_index index, sn_error *error) {
    const sn_skeleton_coordinate *c = &s->coordinates[index];
    if (c->name == NULL || *c->name == '\0') return sn_fail(error, SN_ERROR_INPUT, "coordinate %d has no name", (int)index + 1);
    if (!isfinite(c->rest) || isnan(c->low) || isnan(c->high) || c->low > c->high)
        return sn_fail(error, SN_ERROR_INPUT, "coordinate \"%.100s\": its default or its range is no number or upside down", c->name);
    for (sn_index i = 0; i < index; i++)
        if (strcmp(s->coordinates[i].name, c->name) == 0 && same_text(s->coordinates[i].joint, c->joint))
            return sn_fail(error, SN_ERROR_INPUT, "two coordinates are called \"%.100s\"; rename one", c->name);
    return SN_OK;
}

/* Is this coordinate what a coupler from `first` on determines? */
static bool still_dependent(const sn_skeleton *s, sn_index first, sn_index coordinate) {
    for (sn_index i = first; i < s->coupler_count; i++)
        if (s->couplers[i].dependent == coordinate) return true;
    return false;
}

static sn_status order_couplers(sn_skeleton *s, sn_error *error) {
    for (sn_index placed = 0; placed < s->coupler_count; placed++) {
        sn_index next = placed;
        while (next < s->coupler_count && still_dependent(s, placed, s->couplers[next].independent)) next++;
        if (next == s->coupler_count)
            return sn_fail(error, SN_ERROR_INPUT, "coordinate \"%.100s\" depends on itself by its couplers; take one of them out",
                           s->coordinates[s->couplers[placed].dependent].name);
        sn_skeleton_coupler chosen = s->couplers[next];
        memmove(&s->couplers[placed + 1], &s->couplers[placed], (size_t)(next - placed) * sizeof chosen);
        s->couplers[placed] = chosen;
        if (still_dependent(s, placed + 1, chosen.dependent))
            return sn_fail(error, SN_ERROR_INPUT, "two couplers determine the coordinate \"%.100s\"; take one of them out",
                           s->coordinates[chosen.dependent].name);
    }
    return SN_OK;
}

sn_status sn_skeleton_finish(sn_skeleton *s, sn_error *error) {
    sn_status status = s->body_count > 0 ? SN_OK : sn_fail(error, SN_ERROR_INPUT, "the model has no body");
    for (sn_index i = 0; i < s->coordinate_count && status == SN_OK; i++) status = check_coordinate(s, i, error);
    for (sn_index i = 0; i < s->body_count && status == SN_OK; i++) status = check_body(s, i, error);
    return status == SN_OK ? order_couplers(s, error) : status;
}

/* ---- coordinates ----------------------------------------------------------------------------------------------------------------------
 */

/* The last but `back`-th part of a path; NULL = there is none. */
static const char *path_part(const char *path, int back, size_t *length) {
    const char *end = path + strlen(path);
    while (true) {
        const char *start = end;
        while (start > path && start[-1] != '/') start--;
        *length = (size_t)(end - start);
        if (back-- == 0) return start;
        if (start == path) return NULL;
        end = start - 1;
    }
}

static bool part_is(const char *part, size_t length, const char *name) {
    return part != NULL && name != NULL && strlen(name) == length && memcmp(part, name, length) == 0;
}

sn_index sn_skeleton_find_coordinate(const sn_skeleton *s, const char *column) {
    size_t last_length, name_length = 0, joint_length = 0;
    const char *last = path_part(column, 0, &last_length), *name = path_part(column, 1, &name_length),
               *joint = path_part(column, 2, &joint_length);
    bool path = name != NULL && part_is(last, last_length, "value");
    for (sn_index i = 0; i < s->coordinate_count; i++) {
        const sn_skeleton_coordinate *c = &s->coordinates[i];
        if (!path && strcmp(c->name, column) == 0) return i;
        if (path && part_is(name, name_length, c->name) && (joint_length == 0 || part_is(joint, joint_length, c->joint))) return i;
    }
    return SN_NONE;
}

void sn_skeleton_couple(const sn_skeleton *s, double *values) {
    for (sn_index i = 0; i < s->coupler_count; i++) {
        const sn_skeleton_coupler *c = &s->couplers[i];
        values[c->dependent] = sn_function_at(c->function, values[c->independent]);
    }
}

void sn_skeleton_rest(const sn_skeleton *s, double *values) {
    for (sn_index i = 0; i < s->coordinate_count; i++) {
        const sn_skeleton_coordinate *c = &s->coordinates[i];
        values[i] = c->clamped ? fmin(fmax(c->rest, c->low), c->high) : c->rest;
    }
    sn_skeleton_couple(s, values);
}

/* ---- frames
 * ------------------------------------------------------------------------------------------------------------------------------ */

static sn_rigid spin(const sn_move *move, const double *values) {
    sn_vec3 vector = sn_v3(values[move->coordinates[0]], values[move->coordinates[1]], values[move->coordinates[2]]);
    double angle = sn_norm(vector);
    if (!(angle > 0.0)) return sn_rigid_identity();
    return (sn_rigid){sn_quat_axis_angle(sn_scale(vector, 1.0 / angle), angle), {0, 0, 0}};
}

static sn_rigid evaluate(const sn_move *move, const double *values) {
    sn_rigid out = sn_rigid_identity();
    if (move->kind == SN_MOVE_FIXED) {
        out = move->fixed;
    } else if (move->kind == SN_MOVE_SPIN) {
        out = spin(move, values);
    } else {
        double by = values[move->coordinates[0]];
        if (move->function != NULL) by = sn_function_at(move->function, by);
        if (move->kind == SN_MOVE_SHIFT)
            out.translation = sn_scale(move->axis, by);
        else if (by != 0.0)
            out.rotation = sn_quat_axis_angle(move->axis, by);
    }
    return move->inverse ? sn_rigid_inverse(out) : out;
}

void sn_skeleton_frames(const sn_skeleton *s, const double *values, sn_rigid *frames) {
    for (sn_index i = 0; i < s->body_count; i++) {
        const sn_skeleton_body *body = &s->bodies[i];
        sn_rigid frame = body->parent == SN_NONE ? sn_rigid_identity() : frames[body->parent];
        for (sn_index k = 0; k < body->move_count; k++) frame = sn_rigid_compose(frame, evaluate(&body->moves[k], values));
        frame.rotation = sn_quat_normalize(frame.rotation);
        frames[i] = frame;
    }
}
