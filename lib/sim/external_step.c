/*
 * external_step.c -- external constraints in a step: where targets are that move by themselves, and what each row holds on to from its
 * start to its end.   bodies.md 3
 *
 * The point that a vertex slides on is looked for where the step begins. Beside a member of the group it stays the same mean of that
 * member's points, with its normal as it was; beside what moves by itself the search goes on from there with the vertex carried along.
 */
#include "external.h"

#include <string.h>

#include "sinew/geom.h"

/* ---- what moves by itself ------------------------------------------------------------------------------------------------------------ */

static sn_vec3 place_of(const sn_scene *scene, const sn_external_target *t, const sn_surface_moment *at, sn_index v) {
    if (t->touched >= scene->bone_count)
        return sn_scene_surface_vertex(&scene->surfaces[t->touched - scene->bone_count], at, t->vertices[v]);
    const sn_scene_bone *bone = &scene->bones[t->touched];
    sn_vec3 rest = sn_scale(bone->mesh.positions[t->vertices[v]], bone->meters_per_unit);
    return bone->joint == SN_NONE ? rest : sn_rigid_apply(at->poses[bone->joint], rest);
}

/* How far members have come apart at a time of the scene's, in [0,1]. */
static void part_members(const sn_group *g, sn_group_state *s, const sn_scene *scene, double time) {
    double resolve = scene->externals.resolve;
    for (sn_index i = 0; i < g->count && resolve > 0.0; i++) {
        sn_inputs *in = s->members[i]->inputs;
        in->parted = fmin(fmax((time - in->resolve_begin) / resolve, 0.0), 1.0);
    }
}

void sn_externals_aim(const sn_group *g, sn_group_state *s, const sn_scene *scene, const sn_surface_moment *at) {
    if (g->row_count > 0) part_members(g, s, scene, at->time);
    if (g->target_points == 0) return;
    sn_surface_moment all = sn_kinematics_moment(s->members[0], scene, at);
    for (sn_index i = 0; i < g->target_count; i++) {
        const sn_external_target *t = &g->targets[i];
        for (sn_index v = 0; t->member == SN_NONE && v < t->moving.vertex_count; v++)
            s->target_points[t->first_point + v] = place_of(scene, t, &all, v);
    }
}

void sn_externals_keep(const sn_group *g, sn_group_state *s) {
    if (g->target_points > 0) memcpy(s->target_points_placed, s->target_points, (size_t)g->target_points * sizeof *s->target_points);
}

static bool parts(const sn_group *g, const sn_group_state *s) {
    double parted = s->members[0]->inputs->parted;
    return g->row_count > 0 && parted > 0.0 && parted < 1.0;
}

bool sn_externals_moved(const sn_group *g, const sn_group_state *s) {
    if (parts(g, s)) return true;
    return g->target_points > 0 &&
           memcmp(s->target_points, s->target_points_placed, (size_t)g->target_points * sizeof *s->target_points) != 0;
}

/* ---- shapes ------------------------------------------------------------------------------------------------------------------------- */

/* Where what a row holds on to is looked for. */
typedef struct look {
    const sn_group *g;
    const sn_group_state *s;
    sn_vec3 *points;        /* of the group */
    const sn_vec3 *targets; /* of those that move by themselves */
    double much_nearer;
} look;

/* Another target must be so much nearer than the one that a vertex slides on: where two are as near, it would go from one to the other and
 * back, and with it what it is pulled by. */
static const double MUCH_NEARER = 1.5;

/* For a step; of a group that goes one way, to the letter of [R18], the nearest is the nearest. */
static look look_from(const sn_group *g, const sn_group_state *s) {
    if (g->one_way) return (look){g, s, s->previous, s->target_points, 1.0};
    return (look){g, s, s->previous, s->target_points_placed, MUCH_NEARER};
}

static look look_here(const sn_group *g, const sn_group_state *s) { return (look){g, s, s->here, s->target_points, 1.0}; }

static const sn_vec3 *positions_of(const look *from, const sn_external_target *t) {
    return t->member != SN_NONE ? from->points + from->g->first[t->member] : from->targets + t->first_point;
}

static sn_moving_shape shape_of(const look *from, const sn_external_target *t) {
    return (sn_moving_shape){&t->moving, positions_of(from, t), from->s->target_boxes + t->first_box};
}

static sn_moving_shape shape_after(const sn_group_state *s, const sn_external_target *t) {
    return (sn_moving_shape){&t->moving, s->target_points + t->first_point, NULL};
}

static void fit(const look *from, const sn_external_target *t) {
    sn_moving_fit(&t->moving, positions_of(from, t), from->s->target_boxes + t->first_box);
}

static void fit_all(const look *from) {
    for (sn_index i = 0; i < from->g->target_count; i++) fit(from, &from->g->targets[i]);
}

/* ---- rows ---------------------------------------------------------------------------------------------------------------------------- */

static double stiffness_share(const sn_group_state *s, sn_index member, sn_index target) {
    double own = s->members[member]->inputs->stiffness, other = s->members[target]->inputs->stiffness;
    return own > other ? other / own : 1.0;
}

/* A point of a target over the step, for a row of that member. */
static sn_external_foot foot_of(const look *from, const sn_external_target *t, const sn_closest *at, sn_index member) {
    const sn_group *g = from->g;
    sn_external_foot foot = {.weight = {0}, .share = 1.0};
    if (t->member == SN_NONE) {
        sn_moving_shape after = shape_after(from->s, t);
        foot.place = sn_moving_point(&after, at);
        return foot;
    }
    const sn_index *v = t->moving.triangles[at->triangle].v;
    for (int k = 0; k < 3; k++) foot.point[k] = g->first[t->member] + v[k] - g->first[member], foot.weight[k] = at->barycentric[k];
    foot.share = stiffness_share(from->s, member, t->member);
    return foot;
}

/* Where a row slides: a target of the group, and a triangle of its moving mesh. */
typedef struct sliding {
    sn_index *on, *at;
} sliding;

static sliding seat_of(const sn_muscle_state *s, sn_index row) { return (sliding){&s->inputs->slides_on[row], &s->inputs->slides_at[row]}; }

/* No turns around a vertex: it is outside of that member, to the last digits. O(triangles). */
static const double NO_TURN = 1e-3;

static bool is_outside(const look *from, sn_index target, sn_vec3 at) {
    const sn_external_target *t = &from->g->targets[target];
    if (t->member == SN_NONE) return false;
    const sn_model_muscle *m = from->g->members[t->member];
    sn_mesh mesh = {.vertex_count = m->vertex_count,
                    .triangle_count = m->triangle_count,
                    .positions = from->points + from->g->first[t->member],
                    .triangles = m->triangles};
    return fabs(sn_winding_number(&mesh, at)) < NO_TURN;
}

/* Is a vertex within a target that it was outside of at rest? The nearest point tells the side of a surface that does not cross itself.
 * Where a muscle has folded over, a vertex outside may see the back of a fold; no turns around it tell so. */
static bool has_entered(const look *from, const sn_externals *all, sn_index candidate, double side, sn_vec3 at) {
    const sn_external_target *t = &from->g->targets[all->candidates[candidate]];
    if (from->g->one_way || !t->closed || !(side < 0.0) || all->rest_sides[candidate] < 0.0) return false;
    return !is_outside(from, all->candidates[candidate], at);
}

/* What a vertex may slide on. */
typedef struct choice {
    sn_index candidate; /* of its muscle's; SN_NONE = none yet */
    sn_closest foot;
    double side;     /* signed distance */
    double nearness; /* the one with the least is taken: the distance; of one that was entered, less than 0, by how deep */
    sn_vec3 normal;
} choice;

static choice look_at(const look *from, const sn_externals *all, const sn_external_row *row, sn_index candidate, sliding seat, sn_vec3 at) {
    sn_moving_shape shape = shape_of(from, &from->g->targets[all->candidates[candidate]]);
    bool known = *seat.on == all->candidates[candidate];
    choice c = {.candidate = candidate, .foot = sn_moving_closest(&shape, known ? *seat.at : row->triangle, at)};
    c.side = sn_moving_side(&shape, &c.foot, at, &c.normal);
    c.nearness = known ? c.foot.distance / from->much_nearer : c.foot.distance;
    if (has_entered(from, all, candidate, c.side, at)) c.nearness = known ? c.side * from->much_nearer : c.side;
    return c;
}

/* Where a vertex slides: on the nearest of its targets, or out of one that it has entered. */
static choice find_slide(const look *from, const sn_externals *all, const sn_external_row *row, sn_index member, sliding seat,
                         sn_external_hold *hold) {
    sn_vec3 at = from->points[from->g->first[member] + row->point];
    choice best = {.candidate = SN_NONE, .nearness = INFINITY};
    for (sn_index c = row->begin; c < row->end; c++) {
        choice next = look_at(from, all, row, c, seat, at);
        if (next.nearness < best.nearness) best = next;
    }
    if (best.candidate == SN_NONE) return best;
    const sn_external_target *on = &from->g->targets[all->candidates[best.candidate]];
    *seat.on = all->candidates[best.candidate], *seat.at = best.foot.triangle;
    hold->normal = best.normal;
    hold->slide = foot_of(from, on, &best.foot, member);
    if (on->member != SN_NONE || from->g->one_way) return best;
    sn_moving_shape before = shape_of(from, on), after = shape_after(from->s, on); /* the vertex is carried along, and will look again */
    hold->slide.place = sn_add(at, sn_sub(sn_moving_point(&after, &best.foot), sn_moving_point(&before, &best.foot)));
    return best;
}

/* Where it slides at the end of the step, beside what moves by itself, in the boxes of that moment; `place` says where the vertex is then.
 */
static void find_ahead(const look *from, sliding seat, sn_external_hold *hold) {
    const sn_external_target *on = &from->g->targets[*seat.on];
    sn_moving_shape after = {&on->moving, from->s->target_points + on->first_point, from->s->target_boxes + on->first_box};
    sn_vec3 at = hold->slide.place;
    sn_closest best = sn_moving_closest(&after, *seat.at, at);
    sn_moving_side(&after, &best, at, &hold->normal);
    hold->slide.place = sn_moving_point(&after, &best);
}

void sn_externals_reset(const sn_group *g, sn_group_state *s) {
    for (sn_index i = 0; i < g->count; i++) {
        const sn_externals *all = sn_externals_of(g->members[i]);
        for (sn_index r = 0; r < g->members[i]->external_count; r++) {
            sliding seat = seat_of(s->members[i], r);
            *seat.on = all->candidates[all->rows[r].begin], *seat.at = all->rows[r].triangle;
        }
    }
}

static bool sits(const sn_group *g, const sn_externals *all, const sn_external_row *row, sliding seat) {
    bool found = false;
    for (sn_index c = row->begin; c < row->end; c++) found = found || all->candidates[c] == *seat.on;
    return found && *seat.at >= 0 && *seat.at < g->targets[*seat.on].moving.triangle_count;
}

bool sn_externals_sound(const sn_group *g, const sn_group_state *s) {
    bool sound = true;
    for (sn_index i = 0; i < g->count; i++) {
        const sn_externals *all = sn_externals_of(g->members[i]);
        for (sn_index r = 0; r < g->members[i]->external_count && sound; r++)
            sound = sits(g, all, &all->rows[r], seat_of(s->members[i], r));
    }
    return sound;
}

/* The point that it was bound to, and where its tangent frame puts the vertex. */
static void find_bound(const look *from, const sn_externals *all, const sn_external_row *row, sn_index member, sn_external_hold *hold) {
    const sn_external_target *t = &from->g->targets[all->candidates[row->begin]];
    sn_moving_shape shape = t->member != SN_NONE ? shape_of(from, t) : shape_after(from->s, t);
    sn_closest at = {.triangle = row->triangle, .barycentric = {row->barycentric[0], row->barycentric[1], row->barycentric[2]}};
    sn_vec3 axes[3];
    sn_external_frame(&shape, row->triangle, axes);
    hold->bound = foot_of(from, t, &at, member);
    hold->offset = sn_add_scaled(sn_add_scaled(sn_scale(axes[0], row->offset.x), axes[1], row->offset.y), axes[2], row->offset.z);
}

static void find_member(const look *from, sn_index member) {
    const sn_model_muscle *m = from->g->members[member];
    const sn_muscle_state *s = from->s->members[member];
    const sn_externals *all = sn_externals_of(m);
    sn_external_hold *holds = sn_external_holds_of(s);
    for (sn_index r = 0; r < m->external_count; r++) {
        const sn_external_row *row = &all->rows[r];
        bool slides = row->weights[SN_EXTERNAL_SLIDE] > 0.0 || row->least > -INFINITY;
        holds[r].normal = sn_v3(0, 0, 0);
        if (slides) find_slide(from, all, row, member, seat_of(s, r), &holds[r]);
        if (row->weights[SN_EXTERNAL_SOFT] > 0.0 || row->weights[SN_EXTERNAL_HARD] > 0.0) find_bound(from, all, row, member, &holds[r]);
    }
}

static void find_member_ahead(const look *from, sn_index member) {
    const sn_muscle_state *s = from->s->members[member];
    sn_external_hold *holds = sn_external_holds_of(s);
    for (sn_index r = 0; r < from->g->members[member]->external_count; r++) {
        bool slides = sn_norm2(holds[r].normal) > 0.0;
        if (slides && from->g->targets[s->inputs->slides_on[r]].member == SN_NONE) find_ahead(from, seat_of(s, r), &holds[r]);
    }
}

void sn_externals_find(const sn_group *g, sn_group_state *s) {
    if (g->row_count == 0) return;
    const look from = look_from(g, s);
    fit_all(&from);
    for (sn_index i = 0; i < g->count; i++) find_member(&from, i);
    if (g->target_points == 0 || g->one_way) return;
    for (sn_index i = 0; i < g->target_count; i++) {
        const sn_external_target *t = &g->targets[i];
        if (t->member == SN_NONE) sn_moving_fit(&t->moving, s->target_points + t->first_point, s->target_boxes + t->first_box);
    }
    for (sn_index i = 0; i < g->count; i++) find_member_ahead(&from, i);
}

/* ---- one way, in each iteration -------------------------------------------------------------------------------------------------------
 */

static void take_points(sn_group_state *s, sn_index begin, sn_index end) {
    for (sn_index i = begin; i < end; i++) s->here[i] = sn_point_position(&s->points[i]);
}

void sn_externals_begin(const sn_group *g, sn_group_state *s) {
    const look from = look_here(g, s);
    take_points(s, 0, g->point_count);
    fit_all(&from);
}

void sn_externals_update(const sn_group *g, sn_group_state *s, sn_index member) {
    const look from = look_here(g, s);
    find_member(&from, member);
}

void sn_externals_went(const sn_group *g, sn_group_state *s, sn_index member) {
    const look from = look_here(g, s);
    take_points(s, g->first[member], g->first[member + 1]);
    for (sn_index i = 0; i < g->target_count; i++)
        if (g->targets[i].member == member) fit(&from, &g->targets[i]);
}

/* ---- where a frame ends ---------------------------------------------------------------------------------------------------------------
 */

/* Beside this share of the diagonal a vertex is as deep as at rest. */
static const double DEPTH_NOISE = 1e-7;

static bool is_finite(const sn_group *g, const sn_group_state *s) {
    for (sn_index i = 0; i < g->point_count; i++)
        if (!sn_finite3(s->here[i])) return false;
    return true;
}

static void measure_row(const look *from, sn_index member, sn_index r, sn_statistics *out) {
    const sn_model_muscle *m = from->g->members[member];
    const sn_externals *all = sn_externals_of(m);
    const sn_external_row *row = &all->rows[r];
    sn_index on = *seat_of(from->s->members[member], r).on, at = *seat_of(from->s->members[member], r).at; /* as they are */
    sn_external_hold hold = {.normal = {0, 0, 0}};
    choice found = find_slide(from, all, row, member, (sliding){&on, &at}, &hold);
    if (found.candidate == SN_NONE) return;
    double depth = fmin(0.0, all->rest_sides[found.candidate]) - found.side;
    if (!(sn_norm2(hold.normal) > 0.0) || !(depth > out->entered) || !(depth > DEPTH_NOISE * m->diagonal)) return;
    if (is_outside(from, on, from->points[from->g->first[member] + row->point])) return;
    out->entered = depth;
    out->entered_vertex = row->point;
    out->entered_target = on;
}

void sn_externals_measure(const sn_group *g, sn_group_state *s) {
    for (sn_index i = 0; i < g->count; i++) {
        sn_statistics *out = &s->members[i]->statistics;
        out->entered = 0.0;
        out->entered_vertex = out->entered_target = SN_NONE;
    }
    if (g->row_count == 0) return;
    const look from = look_here(g, s);
    take_points(s, 0, g->point_count);
    if (!is_finite(g, s)) return;
    fit_all(&from);
    for (sn_index i = 0; i < g->count; i++) {
        const sn_externals *all = sn_externals_of(g->members[i]);
        const sn_external_hold *holds = sn_external_holds_of(s->members[i]);
        for (sn_index r = 0; all != NULL && r < g->members[i]->external_count; r++)
            if (sn_norm2(holds[r].normal) > 0.0) measure_row(&from, i, r, &s->members[i]->statistics);
    }
}
