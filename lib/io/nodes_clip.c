/*
 * nodes_clip.c -- one animation of a tree of nodes as a clip: joints are the nodes that it moves and the bones of meshes, sampled at one
 * rate.
 *
 * Nodes have scales, joints have none. The pose of a joint is what takes its world frame at rest to that of the moment, M_now M_rest^-1: a
 * rotation where the scales on the way to it stay as they are. Where they do not, the nearest rotation is taken, and a warning says so.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "nodes.h"

static const double FALLBACK_RATE = 30.0, LOWEST_TICKS = 10.0, HIGHEST_TICKS = 240.0;
/* Rates that animations are made at; the first one whose frames all keys are on is theirs. */
static const double usual_rates[] = {30, 24, 25, 60, 50, 48, 90, 100, 120, 240};
/* Times this part of a frame off a frame are on it: they come from single precision. */
static const double ON_FRAME = 1e-3;
/* A scale this far from that at rest changes; numbers are of single precision. */
static const double SCALE_CHANGES = 1e-3;
/* Of all frames: bytes of poses, beside ten times those of the file, and nodes. */
static const double MOST_BYTES = 32e6, MOST_NODES = 2e8;
/* Of the nodes that FBX's importer makes for the parts of a transform. */
static const char PIVOT[] = "_$AssimpFbx$_";

typedef struct sampler {
    const sn_nodes *nodes;
    const sn_animation *animation; /* NULL = none */
    sn_index *channel;             /* (node_count) SN_NONE = none */
    sn_index *base;                /* (node_count) the node that its moving transform is relative to */
    sn_index *joint;               /* (node_count) SN_NONE = no joint */
    sn_index *joint_node;          /* (joint_count) */
    sn_index *joint_frame;         /* (joint_count) the node whose frame is the joint's */
    sn_index joint_count;
    sn_affine *rest, *now; /* (node_count) world */
    sn_affine *inverse;    /* (joint_count) of a joint's frame at rest */
    double begin, end;
    double worst_scale; /* how far a joint's scale leaves that at rest, and where */
    sn_index worst_joint, scaled;
    double gap; /* seconds, the longest between two keys that differ */
} sampler;

/* ---- affine maps
 * -------------------------------------------------------------------------------------------------------------------------- */

static sn_affine compose(const sn_affine *a, const sn_affine *b) {
    sn_affine c;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            c.m[i][j] = a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] + a->m[i][2] * b->m[2][j] + (j == 3 ? a->m[i][3] : 0.0);
    return c;
}

static double cofactor(const sn_affine *t, int i, int j) {
    int a = (i + 1) % 3, b = (i + 2) % 3, u = (j + 1) % 3, v = (j + 2) % 3;
    return t->m[a][u] * t->m[b][v] - t->m[a][v] * t->m[b][u];
}

static double determinant(const sn_affine *t) {
    return t->m[0][0] * cofactor(t, 0, 0) + t->m[0][1] * cofactor(t, 0, 1) + t->m[0][2] * cofactor(t, 0, 2);
}

static sn_affine invert(const sn_affine *t, double d) {
    sn_affine out;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) out.m[i][j] = cofactor(t, j, i) / d;
    for (int i = 0; i < 3; i++) out.m[i][3] = -(out.m[i][0] * t->m[0][3] + out.m[i][1] * t->m[1][3] + out.m[i][2] * t->m[2][3]);
    return out;
}

static sn_vec3 place_of(const sn_affine *t) { return sn_v3(t->m[0][3], t->m[1][3], t->m[2][3]); }
static sn_vec3 column(const sn_affine *t, int j) { return sn_v3(t->m[0][j], t->m[1][j], t->m[2][j]); }

static sn_quat quat_of_rotation(const sn_affine *t) {
    const double(*m)[4] = t->m;
    double trace = m[0][0] + m[1][1] + m[2][2];
    int i = m[1][1] > m[0][0] ? 1 : 0;
    if (m[2][2] > m[i][i]) i = 2;
    if (trace > m[i][i]) return sn_quat_normalize((sn_quat){1.0 + trace, m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]});
    int j = (i + 1) % 3, k = (i + 2) % 3;
    double q[4] = {m[k][j] - m[j][k], 0, 0, 0};
    q[1 + i] = 1.0 + m[i][i] - m[j][j] - m[k][k];
    q[1 + j] = m[i][j] + m[j][i];
    q[1 + k] = m[i][k] + m[k][i];
    return sn_quat_normalize((sn_quat){q[0], q[1], q[2], q[3]});
}

/* The nearest rotation: Newton's iteration for the polar decomposition (Higham 1986), Q <- (Q + Q^-T) / 2 from Q scaled to a determinant
 * of 1. false: there is none, as the map is flat or mirrors. */
static bool nearest_rotation(const sn_affine *t, sn_quat *out) {
    sn_affine q = *t;
    double size = sn_norm(column(t, 0)) + sn_norm(column(t, 1)) + sn_norm(column(t, 2));
    if (!(size > 0.0) || !isfinite(size) || !(determinant(t) > 1e-12 * size * size * size)) return false;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) q.m[i][j] *= 3.0 / size;
    for (int round = 0; round < 60; round++) {
        double d = determinant(&q), change = 0.0;
        sn_affine next = q;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                next.m[i][j] = 0.5 * (q.m[i][j] + cofactor(&q, i, j) / d);
                change = fmax(change, fabs(next.m[i][j] - q.m[i][j]));
            }
        q = next;
        if (change < 1e-14) break;
    }
    *out = quat_of_rotation(&q);
    return true;
}

/* How far a map is from keeping lengths and angles: the largest of |M^T M - I|, halved, as a stretch is. */
static double stretch_of(const sn_affine *t) {
    double worst = 0.0;
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++) worst = fmax(worst, 0.5 * fabs(sn_dot(column(t, i), column(t, j)) - (i == j)));
    return worst;
}

static sn_affine from_parts(sn_vec3 place, sn_quat q, sn_vec3 scale) {
    sn_vec3 x = sn_scale(sn_quat_rotate(q, sn_v3(1, 0, 0)), scale.x), y = sn_scale(sn_quat_rotate(q, sn_v3(0, 1, 0)), scale.y),
            z = sn_scale(sn_quat_rotate(q, sn_v3(0, 0, 1)), scale.z);
    return (sn_affine){{{x.x, y.x, z.x, place.x}, {x.y, y.y, z.y, place.y}, {x.z, y.z, z.z, place.z}}};
}

/* ---- keys
 * --------------------------------------------------------------------------------------------------------------------------------- */

/* The key at or before a time, and how far it is to the next. */
static sn_index find_key(const sn_track *track, double time, double slack, double *part) {
    sn_index low = 0, high = track->count - 1;
    while (low < high) {
        sn_index middle = low + (high - low + 1) / 2;
        if (track->times[middle] <= time + slack)
            low = middle;
        else
            high = middle - 1;
    }
    *part = 0.0;
    if (low + 1 < track->count && !track->step && time > track->times[low])
        *part = fmin((time - track->times[low]) / (track->times[low + 1] - track->times[low]), 1.0);
    return low;
}

static sn_vec3 vector_at(const sn_track *track, double time, double slack) {
    double part;
    sn_index k = find_key(track, time, slack, &part);
    const double *v = &track->values[3 * (size_t)k];
    sn_vec3 a = sn_v3(v[0], v[1], v[2]);
    return part > 0.0 ? sn_lerp(a, sn_v3(v[3], v[4], v[5]), part) : a;
}

static sn_quat turn_at(const sn_track *track, double time, double slack) {
    double part;
    sn_index k = find_key(track, time, slack, &part);
    const double *v = &track->values[4 * (size_t)k];
    sn_quat a = sn_quat_normalize((sn_quat){v[0], v[1], v[2], v[3]});
    return part > 0.0 ? sn_quat_slerp(a, sn_quat_normalize((sn_quat){v[4], v[5], v[6], v[7]}), part) : a;
}

/* What a channel leaves out stays as it is at rest. */
static sn_affine channel_at(const sn_node_channel *c, const sn_node *node, double time, double slack) {
    const sn_track *t = c->tracks;
    sn_quat turn = sn_quat_identity();
    sn_vec3 place = place_of(&node->local);
    sn_vec3 scale = sn_v3(sn_norm(column(&node->local, 0)), sn_norm(column(&node->local, 1)), sn_norm(column(&node->local, 2)));
    if (t[SN_TRACK_TURN].count == 0) nearest_rotation(&node->local, &turn);
    if (t[SN_TRACK_POSITION].count > 0) place = vector_at(&t[SN_TRACK_POSITION], time, slack);
    if (t[SN_TRACK_TURN].count > 0) turn = turn_at(&t[SN_TRACK_TURN], time, slack);
    if (t[SN_TRACK_SCALE].count > 0) scale = vector_at(&t[SN_TRACK_SCALE], time, slack);
    return from_parts(place, turn, scale);
}

static bool same_values(const double *a, const double *b, sn_index width) {
    for (sn_index i = 0; i < width; i++)
        if (fabs(a[i] - b[i]) > 1e-6 * (1.0 + fabs(a[i]))) return false;
    return true;
}

/* A single key is what a track is at all times: assimp makes some, at 0, for what an animation leaves alone. */
static void scan_track(sampler *s, const sn_track *track, sn_index width) {
    if (track->count < 2) return;
    for (sn_index k = 0; k < track->count; k++) {
        s->begin = fmin(s->begin, track->times[k]);
        s->end = fmax(s->end, track->times[k]);
        const double *v = &track->values[(size_t)k * (size_t)width];
        if (k > 0 && !same_values(v - width, v, width)) s->gap = fmax(s->gap, track->times[k] - track->times[k - 1]);
    }
}

/* Is each key on a frame? */
static bool fits_rate(const sampler *s, double rate) {
    for (sn_index c = 0; c < s->animation->channel_count; c++)
        for (int t = 0; t < SN_TRACK_COUNT; t++) {
            const sn_track *track = &s->animation->channels[c].tracks[t];
            for (sn_index k = 0; track->count > 1 && k < track->count; k++) {
                double frame = (track->times[k] - s->begin) * rate;
                if (fabs(frame - floor(frame + 0.5)) > ON_FRAME * (1.0 + 1e-3 * frame)) return false;
            }
        }
    return true;
}

static double choose_rate(const sampler *s, const sn_nodes_clip_options *options, bool *assumed) {
    *assumed = false;
    if (options->rate > 0.0) return options->rate;
    if (s->animation == NULL) return 1.0;
    double ticks = s->animation->ticks;
    if (ticks >= LOWEST_TICKS && ticks <= HIGHEST_TICKS) return ticks;
    for (size_t i = 0; i < sizeof usual_rates / sizeof *usual_rates; i++)
        if (s->end > s->begin && fits_rate(s, usual_rates[i])) return usual_rates[i];
    *assumed = s->end > s->begin;
    return FALLBACK_RATE;
}

/* ---- which nodes
 * -------------------------------------------------------------------------------------------------------------------------- */

/* Is this a node that the importer made for a part of the transform of the node called `name` (NULL: of any)? */
static bool is_pivot(const sn_node *node, const char *name) {
    const char *mark = strstr(node->name, PIVOT);
    if (mark == NULL) return false;
    return name == NULL || (strlen(name) == (size_t)(mark - node->name) && memcmp(name, node->name, strlen(name)) == 0);
}

/* Parts of a transform that a channel of the whole has in it, as assimp makes it. A post-rotation it applies the wrong way round (5.2). */
static bool is_plain_pivot(const sn_node *node) {
    static const char *const parts[] = {"Translation", "Rotation", "PreRotation", "Scaling"};
    const char *part = strstr(node->name, PIVOT) + sizeof PIVOT - 1;
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++)
        if (strcmp(part, parts[k]) == 0) return true;
    return false;
}

static bool is_whole(const sn_node_channel *c) {
    return c->tracks[SN_TRACK_POSITION].count > 0 && c->tracks[SN_TRACK_TURN].count > 0 && c->tracks[SN_TRACK_SCALE].count > 0;
}

/* Assimp tells the motion of an FBX node by channels of its pivots, or by one of the node itself, which then is the whole transform to the
 * parent of the first pivot. */
static sn_status find_base(sampler *s, sn_index i, sn_error *error) {
    const sn_nodes *n = s->nodes;
    sn_index top = n->nodes[i].parent;
    s->base[i] = top;
    if (s->channel[i] == SN_NONE || is_pivot(&n->nodes[i], NULL)) return SN_OK;
    bool good = true;
    for (; top != SN_NONE && is_pivot(&n->nodes[top], n->nodes[i].name); top = n->nodes[top].parent) {
        if (s->channel[top] != SN_NONE) return SN_OK;
        good = good && is_plain_pivot(&n->nodes[top]) && is_whole(&s->animation->channels[s->channel[i]]);
    }
    s->base[i] = top;
    if (good) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT,
                   "the node \"%.100s\" has a post-rotation or another pivot that is not read where it is animated; bake it",
                   n->nodes[i].name);
}

/* Whose frame is a joint's: of FBX without the geometric transform of its mesh, which is no part of the node's. */
static sn_index frame_of(const sn_nodes *n, sn_index i) {
    const char *name = n->nodes[i].name;
    while (n->nodes[i].parent != SN_NONE && is_pivot(&n->nodes[n->nodes[i].parent], name) &&
           strstr(n->nodes[n->nodes[i].parent].name, "_$AssimpFbx$_Geometric") != NULL)
        i = n->nodes[i].parent;
    sn_index above = n->nodes[i].parent;
    return strstr(n->nodes[i].name, "_$AssimpFbx$_Geometric") != NULL && above != SN_NONE ? above : i;
}

static sn_status find_channels(sampler *s, sn_error *error) {
    const sn_nodes *n = s->nodes;
    sn_index lost = 0;
    for (sn_index i = 0; i < n->node_count; i++) s->channel[i] = SN_NONE;
    for (sn_index c = 0; s->animation != NULL && c < s->animation->channel_count; c++) {
        const sn_node_channel *channel = &s->animation->channels[c];
        lost += channel->node == SN_NONE;
        if (channel->node != SN_NONE && s->channel[channel->node] != SN_NONE)
            return sn_fail(error, SN_ERROR_INPUT, "the animation \"%.100s\" moves the node \"%.100s\" twice; export it again",
                           s->animation->name, n->nodes[channel->node].name);
        if (channel->node != SN_NONE) s->channel[channel->node] = c;
        for (int t = 0; t < SN_TRACK_COUNT; t++) scan_track(s, &channel->tracks[t], sn_track_width(t));
    }
    if (lost > 0)
        return sn_fail(error, SN_ERROR_INPUT, "%d of the %d channels of the animation \"%.100s\" move nodes that are not in the scene",
                       (int)lost, (int)s->animation->channel_count, s->animation->name);
    sn_status status = SN_OK;
    for (sn_index i = 0; i < n->node_count && status == SN_OK; i++) status = find_base(s, i, error);
    return status;
}

/* Joints: what is animated, also by its pivots, and bones. */
static sn_status find_joints(sampler *s, sn_error *error) {
    const sn_nodes *n = s->nodes;
    bool *moved = SN_NEW(bool, n->node_count);
    if (moved == NULL) return sn_fail_memory(error, "joints");
    for (sn_index i = 0; i < n->node_count; i++) {
        const sn_node *node = &n->nodes[i];
        bool pivot = is_pivot(node, NULL),
             above = node->parent != SN_NONE && is_pivot(&n->nodes[node->parent], NULL) && moved[node->parent];
        moved[i] = s->channel[i] != SN_NONE || node->bound || above;
        s->joint[i] = SN_NONE;
        if (!moved[i] || pivot) continue;
        s->joint_node[s->joint_count] = i;
        s->joint_frame[s->joint_count] = frame_of(n, i);
        s->joint[i] = s->joint_count++;
    }
    free(moved);
    if (s->joint_count > 0) return SN_OK;
    return sn_fail(error, SN_ERROR_INPUT, "holds no animation of a node and no bones; an animation of shapes or cameras is no motion");
}

/* ---- poses
 * ---------------------------------------------------------------------------------------------------------------------------------- */

static void find_worlds(const sampler *s, double time, double slack, bool at_rest, sn_affine *world) {
    const sn_nodes *n = s->nodes;
    for (sn_index i = 0; i < n->node_count; i++) {
        bool moves = !at_rest && s->channel[i] != SN_NONE;
        sn_index base = moves ? s->base[i] : n->nodes[i].parent;
        sn_affine local = moves ? channel_at(&s->animation->channels[s->channel[i]], &n->nodes[i], time, slack) : n->nodes[i].local;
        world[i] = base != SN_NONE ? compose(&world[base], &local) : local;
    }
}

/* A bone rests where its mesh was bound: that is where mesh-import has the mesh. */
static sn_status set_rest(sampler *s, sn_clip *out, sn_error *error) {
    const sn_nodes *n = s->nodes;
    find_worlds(s, 0.0, 0.0, true, s->rest);
    for (sn_index j = 0; j < s->joint_count; j++) {
        sn_index i = s->joint_node[j], frame = s->joint_frame[j], parent = n->nodes[i].parent;
        const sn_node *node = &n->nodes[i];
        char spare[32];
        sn_clip_joint *joint = &out->joints[j];
        sn_affine rest = node->bound ? node->bind : s->rest[frame];
        double d = determinant(&rest);
        if (d == 0.0 || !isfinite(d)) return sn_fail(error, SN_ERROR_INPUT, "the node \"%.100s\" has a scale of 0 at rest", node->name);
        s->inverse[j] = invert(&rest, d);
        while (parent != SN_NONE && s->joint[parent] == SN_NONE) parent = n->nodes[parent].parent;
        joint->parent = parent != SN_NONE ? s->joint[parent] : SN_NONE;
        joint->rest = place_of(&rest);
        joint->rest_rotation = sn_quat_identity();
        sn_affine turned = rest;
        for (int a = 0; a < 3 && d < 0.0; a++) turned.m[a][0] = -turned.m[a][0]; /* mirrored: of the frame with its x the other way */
        nearest_rotation(&turned, &joint->rest_rotation);
        snprintf(spare, sizeof spare, "node_%d", (int)i + 1);
        if ((joint->name = sn_strdup(*node->name != '\0' ? node->name : spare)) == NULL) return sn_fail_memory(error, "a name");
    }
    return SN_OK;
}

static sn_status set_pose(sampler *s, sn_index j, sn_clip_joint *joint, sn_index frame, sn_error *error) {
    const sn_affine *now = &s->now[s->joint_frame[j]];
    sn_affine away = compose(now, &s->inverse[j]);
    sn_rigid *pose = &joint->poses[frame];
    double stretch = stretch_of(&away);
    if (!nearest_rotation(&away, &pose->rotation) || !isfinite(stretch) || !sn_finite3(place_of(now)))
        return sn_fail(error, SN_ERROR_INPUT,
                       "the node \"%.100s\" is flat, mirrored or too large in frame %d, which no motion of a bone is",
                       s->nodes->nodes[s->joint_node[j]].name, (int)frame);
    pose->translation = sn_sub(place_of(now), sn_quat_rotate(pose->rotation, joint->rest));
    if (stretch > s->worst_scale) {
        s->worst_scale = stretch;
        s->worst_joint = j;
    }
    return SN_OK;
}

static void say_what_is_left_out(const sampler *s, const sn_nodes_clip_options *options, const sn_clip *clip) {
    sn_index apart = 0;
    for (sn_index i = 0; i < s->nodes->node_count; i++) apart += s->nodes->nodes[i].bound_apart;
    if (s->worst_scale > SCALE_CHANGES)
        sn_log(SN_LOG_WARNING,
               "%s: sizes change, which bones do not: joints keep their places and turns alone; \"%s\" does most, by %.3g %%",
               options->name, clip->joints[s->worst_joint].name, 100.0 * (sqrt(1.0 + 2.0 * s->worst_scale) - 1.0));
    if (apart > 0)
        sn_log(SN_LOG_WARNING, "%s: %d bones have meshes that were bound in different poses; they rest in the first one's", options->name,
               (int)apart);
    if (options->curves && s->gap * clip->rate > 1.5)
        sn_log(
            SN_LOG_WARNING,
            "%s: keys are up to %.3g s apart; between them straight lines and the shortest turns are taken, whatever curves the file has: "
            "bake or sample the animation before it is exported",
            options->name, s->gap);
}

static sn_status make_clip(sampler *s, const sn_nodes_clip_options *options, sn_clip *out, sn_error *error) {
    bool assumed;
    double rate = choose_rate(s, options, &assumed), seconds = s->end > s->begin ? s->end - s->begin : 0.0;
    double frames = floor(seconds * rate + 0.01) + 1.0, slack = ON_FRAME / rate;
    if (!(frames * s->joint_count * (double)sizeof(sn_rigid) < MOST_BYTES + 10.0 * (double)options->file_size) ||
        !(frames * s->nodes->node_count < MOST_NODES))
        return sn_fail(error, SN_ERROR_INPUT, "%.0f frames of %d joints are too many; name a lower rate with --source-rate", frames,
                       (int)s->joint_count);
    sn_status status = sn_clip_create((sn_index)frames, s->joint_count, 0, out, error);
    if (status != SN_OK) return status;
    out->rate = rate;
    out->rate_assumed = assumed;
    status = set_rest(s, out, error);
    for (sn_index f = 0; f < out->frame_count && status == SN_OK; f++) {
        find_worlds(s, s->begin + f / rate, slack, false, s->now);
        for (sn_index j = 0; j < s->joint_count && status == SN_OK; j++) status = set_pose(s, j, &out->joints[j], f, error);
    }
    if (status == SN_OK) say_what_is_left_out(s, options, out);
    return status;
}

static void scale_clip(sn_clip *clip, double scale) {
    clip->meters_per_unit_of_source = scale;
    for (sn_index j = 0; j < clip->joint_count && scale != 1.0; j++) {
        clip->joints[j].rest = sn_scale(clip->joints[j].rest, scale);
        for (sn_index f = 0; f < clip->frame_count; f++)
            clip->joints[j].poses[f].translation = sn_scale(clip->joints[j].poses[f].translation, scale);
    }
}

sn_status sn_nodes_clip(const sn_nodes *nodes, const sn_nodes_clip_options *options, sn_clip *out, sn_error *error) {
    sn_index count = nodes->node_count;
    sampler s = {.nodes = nodes, .begin = INFINITY, .end = -INFINITY};
    s.animation = options->animation != SN_NONE ? &nodes->animations[options->animation] : NULL;
    *out = (sn_clip){0};
    sn_status status = SN_OK;
    if (!(s.channel = SN_NEW(sn_index, count)) || !(s.base = SN_NEW(sn_index, count)) || !(s.joint = SN_NEW(sn_index, count)) ||
        !(s.joint_node = SN_NEW(sn_index, count)) || !(s.joint_frame = SN_NEW(sn_index, count)) || !(s.rest = SN_NEW(sn_affine, count)) ||
        !(s.now = SN_NEW(sn_affine, count)) || !(s.inverse = SN_NEW(sn_affine, count)))
        status = sn_fail_memory(error, "a motion");
    if (status == SN_OK) status = find_channels(&s, error);
    if (status == SN_OK) status = find_joints(&s, error);
    if (status == SN_OK) status = make_clip(&s, options, out, error);
    if (status == SN_OK) scale_clip(out, options->meters_per_unit);
    if (status != SN_OK) sn_clip_free(out);
    free(s.channel);
    free(s.base);
    free(s.joint);
    free(s.joint_node);
    free(s.joint_frame);
    free(s.rest);
    free(s.now);
    free(s.inverse);
    return status;
}
