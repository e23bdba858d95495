/* ends_choose.c -- which ends of a muscle are best known, and attachments by place, whatever the order and number of their bones. */
#include <stdlib.h>
#include <string.h>

#include "ends.h"

#define MOST_BEYOND 0.10  /* of the surface that lies beyond found attachments at most */
#define MOST_FLAT 0.30    /* of the surface on which no way leads on between found attachments at most */
#define TRUSTED_REACH 0.6 /* of found attachments: how far the surface may lie from them, over how far apart the ends are */
#define MIDDLE 0.1        /* found attachments this near to the middle of the field lie along the belly: ends of neither side */
#define FLAT 0.1          /* where the field rises by less than this share of its mean slope there is no way on: the tip of a head */
#define HEAD 0.33         /* of found attachments: patches of at least this share of the bone's largest are heads like it */
#define HEAD_VERTICES 6   /* and have as many vertices: the digitations of a serratus have 11 and more, speckles of contact 5 and fewer */
#define CRUMB 0.1         /* of found attachments: smaller patches than this share of the bone's largest are left out */
#define PIN_SHARE 0.01    /* a pin is a cap of this share of L at least: at a single vertex the field is singular */
#define TIP_PATCH 0.05    /* around the point that is farthest from the one known end, as a share of L */
#define GROWTH 1e-3       /* a pair that lies farther apart by less is no better */
enum { MOST_SWEEPS = 16 };

static const char *const kinds[] = {[SN_ENDS_ATTACHMENTS] = "attachments", [SN_ENDS_PINS] = "pins", [SN_ENDS_AREAS] = "areas"};

/* A connected set of vertices that one bone holds for one kind of reason. */
typedef struct patch {
    sn_index first, count; /* in the list */
    sn_index attachment;
    sn_ends_source source;
    bool found; /* by contact or proximity */
    int side;   /* 0 or 1; -1 = left out */
} patch;

typedef struct grouping {
    const ends_surface *surface;
    const sn_muscle *muscle;
    sn_index *holder;      /* (vertex_count) attachment; SN_NONE = none */
    unsigned char *source; /* (vertex_count) sn_ends_source of held vertices */
    bool *found;           /* (vertex_count) of held vertices: by contact or proximity */
    unsigned char *seen;   /* (vertex_count) scratch */
    sn_index *list;        /* (vertex_count) vertices by patch */
    sn_index *sources;     /* (vertex_count) scratch */
    double *field;         /* (vertex_count) scratch */
    double *values;        /* (vertex_count) scratch */
    sn_grip *grips;        /* (attachment_count) */
    bool *trusted;         /* (attachment_count) */
    bool told;             /* which end is which, by what attachments are called */
    size_t patch_capacity;
    sn_index patch_count;
    patch *patches; /* by their lowest vertex */
} grouping;

/* ---- patches ------------------------------------------------------------------------------------------------------------------ */

static sn_ends_source reason_of(const sn_attachment *a, sn_index i) {
    if (a->reasons != NULL)
        return a->reasons[i] == SN_REASON_PIN ? SN_ENDS_PINS : a->reasons[i] == SN_REASON_AREA ? SN_ENDS_AREAS : SN_ENDS_ATTACHMENTS;
    if (a->method != NULL && strcmp(a->method, "area") == 0) return SN_ENDS_AREAS;
    return a->method != NULL && strcmp(a->method, "pin") == 0 ? SN_ENDS_PINS : SN_ENDS_ATTACHMENTS;
}

/* Where somebody has told at which end an attachment is, it is as well known as an area. */
static void mark_held(grouping *g) {
    for (sn_index v = 0; v < g->surface->mesh->vertex_count; v++) g->holder[v] = SN_NONE;
    for (sn_index k = 0; k < g->muscle->attachment_count; k++) {
        const sn_attachment *a = &g->muscle->attachments[k];
        for (sn_index i = 0; i < a->count; i++) {
            sn_ends_source reason = reason_of(a, i);
            g->holder[a->vertices[i]] = k;
            g->found[a->vertices[i]] = reason == SN_ENDS_ATTACHMENTS;
            g->source[a->vertices[i]] = (unsigned char)(a->end != SN_END_UNKNOWN ? SN_ENDS_AREAS : reason);
        }
    }
}

/* The vertices joined to `seed` that are held alike, onto the end of the list. */
static sn_index flood(grouping *g, sn_index seed, sn_index first) {
    const sn_topology *t = g->surface->topology;
    sn_index end = first;
    g->list[end++] = seed;
    g->seen[seed] = 1;
    for (sn_index i = first; i < end; i++)
        for (sn_index k = t->vertex_start[g->list[i]]; k < t->vertex_start[g->list[i] + 1]; k++) {
            sn_index w = t->neighbours[k];
            if (g->seen[w] || g->holder[w] != g->holder[seed] || g->source[w] != g->source[seed]) continue;
            g->seen[w] = 1;
            g->list[end++] = w;
        }
    return end - first;
}

static sn_status find_patches(grouping *g, sn_error *error) {
    sn_index first = 0;
    for (sn_index v = 0; v < g->surface->mesh->vertex_count; v++) {
        if (g->holder[v] == SN_NONE || g->seen[v]) continue;
        if (!sn_grow((void **)&g->patches, &g->patch_capacity, (size_t)g->patch_count + 1, sizeof *g->patches))
            return sn_fail_memory(error, "the patches of the attachments");
        patch *p = &g->patches[g->patch_count++];
        *p = (patch){first, flood(g, v, first), g->holder[v], (sn_ends_source)g->source[v], g->found[v], -1};
        first += p->count;
    }
    return SN_OK;
}

/* ---- trust in what was found -------------------------------------------------------------------------------------------------- */

static bool found(const grouping *g, sn_index attachment) {
    for (sn_index i = 0; i < g->patch_count; i++)
        if (g->patches[i].attachment == attachment && g->patches[i].source == SN_ENDS_ATTACHMENTS) return true;
    return false;
}

/* Is the half of a bone's vertices or more in one patch, or in compact ones of like size, as those of several heads are? */
static bool is_compact(const grouping *g, sn_index attachment) {
    const sn_grip *grip = &g->grips[attachment];
    sn_index all = g->muscle->attachments[attachment].count, heads = 0;
    if (2 * grip->largest >= all) return true;
    for (sn_index i = 0; i < g->patch_count; i++) {
        const patch *p = &g->patches[i];
        if (p->attachment == attachment && p->count >= HEAD_VERTICES && p->count >= HEAD * grip->largest) heads += p->count;
    }
    return 2 * heads >= all;
}

/* Area and compactness of each bone's attachment. */
static void judge_found(grouping *g, sn_ends_choice *choice) {
    for (sn_index k = 0; k < g->muscle->attachment_count; k++) {
        const sn_attachment *a = &g->muscle->attachments[k];
        bool slight = sn_grip_judge(a, &g->grips[k]) == SN_GRIP_SLIGHT;
        g->trusted[k] = !slight && is_compact(g, k);
        if (g->trusted[k] || !found(g, k)) continue;
        if (slight)
            ends_say(choice, "%s holds less than 1 %% of its end", a->bone);
        else
            ends_say(choice, "%s holds %d scattered patches", a->bone, (int)g->grips[k].patches);
    }
}

/* Of what was found, crumbs beside the bone's largest patch do not count. */
static bool counts(const grouping *g, const patch *p, sn_ends_source least) {
    if (p->source < least) return false;
    if (p->found && p->count < CRUMB * g->grips[p->attachment].largest) return false;
    return p->source > SN_ENDS_ATTACHMENTS || g->trusted[p->attachment];
}

/* ---- two groups --------------------------------------------------------------------------------------------------------------- */

/* A patch's vertices behind the `count` that are in g->sources; returns how many there are then. */
static sn_index add_source(grouping *g, const patch *p, sn_index count) {
    memcpy(g->sources + count, g->list + p->first, (size_t)p->count * sizeof *g->sources);
    return count + p->count;
}

/* Into g->field. */
static sn_status distances_from_sources(grouping *g, sn_index count, sn_error *error) {
    return sn_geodesic_distance(g->surface->mesh, g->surface->topology, count, g->sources, g->field, error);
}

/* Distances from the patches that count, or from one of them; false where there is none. */
static sn_status measure(grouping *g, sn_index only, sn_ends_source least, sn_error *error) {
    sn_index count = 0;
    for (sn_index i = 0; i < g->patch_count; i++) {
        const patch *p = &g->patches[i];
        if (only == SN_NONE ? !counts(g, p, least) : i != only) continue;
        count = add_source(g, p, count);
    }
    return distances_from_sources(g, count, error);
}

static double mean_over(const grouping *g, const patch *p) {
    double sum = 0.0;
    for (sn_index i = 0; i < p->count; i++) sum += g->field[g->list[p->first + i]];
    return sum / (double)p->count;
}

/* The two patches that lie farthest apart: from the largest to the one farthest from it, and so on. *apart is 0 where there is one only. */
static sn_status find_pair(grouping *g, sn_ends_source least, sn_index pair[2], double *apart, sn_error *error) {
    sn_index here = SN_NONE;
    for (sn_index i = 0; i < g->patch_count; i++)
        if (counts(g, &g->patches[i], least) && (here == SN_NONE || g->patches[i].count > g->patches[here].count)) here = i;
    pair[0] = pair[1] = here;
    *apart = 0.0;
    for (int sweep = 0; sweep < MOST_SWEEPS && here != SN_NONE; sweep++) {
        sn_status status = measure(g, here, least, error);
        if (status) return status;
        sn_index there = SN_NONE;
        double reach = 0.0;
        for (sn_index i = 0; i < g->patch_count; i++) {
            double d = i != here && counts(g, &g->patches[i], least) ? mean_over(g, &g->patches[i]) : 0.0;
            if (!isfinite(d) || !(d > reach)) continue;
            reach = d;
            there = i;
        }
        if (there == SN_NONE || !(reach > *apart * (1.0 + GROWTH))) return SN_OK;
        pair[0] = here;
        pair[1] = there;
        *apart = reach;
        here = there;
    }
    return SN_OK;
}

static sn_index farthest_point(const grouping *g) {
    sn_index best = SN_NONE;
    for (sn_index v = 0; v < g->surface->mesh->vertex_count; v++)
        if (isfinite(g->field[v]) && (best == SN_NONE || g->field[v] > g->field[best])) best = v;
    return best;
}

/* The field between the patches that have a side, in g->field. */
static sn_status field_between(grouping *g, sn_error *error) {
    sn_index count = 0;
    for (sn_index i = 0; i < g->patch_count; i++) {
        const patch *p = &g->patches[i];
        for (sn_index k = 0; k < p->count && p->side >= 0; k++) {
            g->sources[count] = g->list[p->first + k];
            g->values[count++] = p->side;
        }
    }
    return sn_harmonic_field(g->surface->mesh, g->surface->topology, &(sn_fixed_values){count, g->sources, g->values}, g->field, error);
}

/* The attachments that are told to be origin or insertion are at that end: how many ends are told; *one: the end, where it is
 * one only. */
static int take_told_sides(grouping *g, int *one) {
    bool there[2] = {false, false};
    for (sn_index i = 0; i < g->patch_count; i++) {
        patch *p = &g->patches[i];
        sn_attachment_end end = g->muscle->attachments[p->attachment].end;
        p->side = end == SN_END_UNKNOWN || !counts(g, p, SN_ENDS_AREAS) ? -1 : end == SN_END_INSERTION;
        if (p->side >= 0) there[p->side] = true;
    }
    *one = there[1] && !there[0];
    return there[0] + there[1];
}

/* The mean slope of the field along the edges at a patch. */
static double slope_at(const grouping *g, const patch *p) {
    const sn_topology *t = g->surface->topology;
    const sn_vec3 *positions = g->surface->mesh->positions;
    double rise = 0.0, way = 0.0;
    for (sn_index i = p->first; i < p->first + p->count; i++)
        for (sn_index k = t->vertex_start[g->list[i]]; k < t->vertex_start[g->list[i] + 1]; k++) {
            sn_index w = t->neighbours[k];
            rise += fabs(g->field[w] - g->field[g->list[i]]);
            way += sn_distance(positions[w], positions[g->list[i]]);
        }
    return way > 0.0 ? rise / way : INFINITY;
}

/* The one side that a bone's patches have so far; -1 = none, or both. */
static int side_of_bone(const grouping *g, sn_index attachment, const int *sides) {
    bool there[2] = {false, false};
    for (sn_index i = 0; i < g->patch_count; i++)
        if (g->patches[i].attachment == attachment && sides[i] >= 0) there[sides[i]] = true;
    return there[0] == there[1] ? -1 : there[1];
}

/* The side of a patch that has none yet, -1 = neither. Where a head ends the field is that of the fork, which may lie anywhere: its bone
 * tells more, where that holds one end. What else was found on that bone on the way to the other end, a tendon passes. */
static int judge_side(const grouping *g, const patch *p, double apart, const int *sides) {
    double u = mean_over(g, p);
    int side = u >= 0.5, bone = side_of_bone(g, p->attachment, sides);
    if (slope_at(g, p) < FLAT / apart) return bone >= 0 ? bone : side;
    bool passed = fabs(u - 0.5) < MIDDLE || (bone >= 0 && bone != side);
    return p->source == SN_ENDS_ATTACHMENTS && passed ? -1 : side;
}

/* Which side each other patch is on, by the field between those that have one, `apart` from each other. */
static sn_status take_sides(grouping *g, sn_ends_source least, double apart, sn_error *error) {
    sn_status status = field_between(g, error);
    int *sides = SN_NEW(int, g->patch_count); /* so far: whatever the order of patches */
    if (sides == NULL) status = sn_fail_memory(error, "the ends of the muscle");
    for (sn_index i = 0; i < g->patch_count && !status; i++) sides[i] = g->patches[i].side;
    for (sn_index i = 0; i < g->patch_count && !status; i++) {
        patch *p = &g->patches[i];
        if (p->side < 0 && counts(g, p, least)) p->side = judge_side(g, p, apart, sides);
    }
    free(sides);
    return status;
}

/* The end at 0 is the one with the lowest vertex. */
static void order_sides(grouping *g) {
    for (sn_index i = 0; i < g->patch_count; i++) {
        if (g->patches[i].side < 0) continue;
        if (g->patches[i].side == 1)
            for (sn_index k = i; k < g->patch_count; k++)
                if (g->patches[k].side >= 0) g->patches[k].side = 1 - g->patches[k].side;
        return;
    }
}

/* ---- the ends ----------------------------------------------------------------------------------------------------------------- */

static void write_ends(const grouping *g, ends *out) {
    unsigned char *side = g->seen; /* 0 = none */
    memset(g->seen, 0, (size_t)g->surface->mesh->vertex_count * sizeof *g->seen);
    for (sn_index i = 0; i < g->patch_count; i++) {
        const patch *p = &g->patches[i];
        if (p->side < 0) continue;
        out->choice.patches[p->side]++;
        for (sn_index k = 0; k < p->count; k++) side[g->list[p->first + k]] = (unsigned char)(p->side + 1);
    }
    out->count = 0;
    for (sn_index v = 0; v < g->surface->mesh->vertex_count; v++) {
        if (side[v] == 0) continue;
        out->vertices[out->count] = v;
        out->values[out->count++] = side[v] - 1;
    }
}

/* What lies within `reach` of the vertices of one end (of the pins among them), and on none, becomes that end's too. */
static sn_status grow_pins(grouping *g, ends *out, sn_error *error) {
    double reach = PIN_SHARE * g->surface->shape->length;
    for (int side = 0; side < 2; side++) {
        sn_index count = 0;
        for (sn_index i = 0; i < g->patch_count; i++) {
            const patch *p = &g->patches[i];
            if (p->side != side || p->source != SN_ENDS_PINS) continue;
            count = add_source(g, p, count);
        }
        if (count == 0) continue;
        sn_status status = distances_from_sources(g, count, error);
        if (status) return status;
        memset(g->seen, 0, (size_t)g->surface->mesh->vertex_count * sizeof *g->seen);
        for (sn_index i = 0; i < out->count; i++) g->seen[out->vertices[i]] = 1;
        for (sn_index v = 0; v < g->surface->mesh->vertex_count; v++) {
            if (g->seen[v] || !(g->field[v] <= reach)) continue;
            out->vertices[out->count] = v;
            out->values[out->count++] = side;
        }
    }
    return SN_OK;
}

/* Do found attachments leave so much of the muscle out that they are not its ends? Says why. */
static sn_status judge_cover(const grouping *g, ends *out, bool *bad, sn_error *error) {
    ends_cover cover = {0};
    sn_status status = ends_measure_cover(g->surface, out, &cover, error);
    const char *name = kinds[SN_ENDS_ATTACHMENTS];
    *bad = true;
    if (status) return status;
    if (cover.beyond > MOST_BEYOND)
        ends_say(&out->choice, "%s: %.0f %% of the surface lies beyond them", name, 100.0 * cover.beyond);
    else if (cover.flat > MOST_FLAT)
        ends_say(&out->choice, "%s: over %.0f %% of the surface no way leads from one end to the other", name, 100.0 * cover.flat);
    else
        *bad = false;
    return SN_OK;
}

/* Both ends, of patches among which some of each have a side, `apart` from each other. */
static sn_status take_both(grouping *g, sn_ends_source least, double apart, ends *out, bool *made, sn_error *error) {
    bool bad = false;
    sn_status status = take_sides(g, least, apart, error);
    if (status) return status;
    if (!g->told) order_sides(g);
    write_ends(g, out);
    if (least == SN_ENDS_ATTACHMENTS) status = judge_cover(g, out, &bad, error);
    if (status) return status;
    if (bad) {
        out->count = 0;
        memset(out->choice.patches, 0, sizeof out->choice.patches);
        return SN_OK;
    }
    *made = true;
    ends_source(out, least, true, true);
    return grow_pins(g, out, error);
}

/* Where the areas tell of one end, `one`, the other is the patch that they do not tell of and that lies farthest from them. */
static sn_status find_other(grouping *g, sn_ends_source least, int one, sn_index *other, double *apart, sn_error *error) {
    sn_index count = 0;
    *other = SN_NONE;
    *apart = 0.0;
    for (sn_index i = 0; i < g->patch_count; i++) {
        const patch *p = &g->patches[i];
        if (p->side != one) continue;
        count = add_source(g, p, count);
    }
    sn_status status = distances_from_sources(g, count, error);
    for (sn_index i = 0; i < g->patch_count && !status; i++) {
        const patch *p = &g->patches[i];
        double d = p->side < 0 && counts(g, p, least) ? mean_over(g, p) : 0.0;
        if (!isfinite(d) || !(d > *apart)) continue;
        *apart = d;
        *other = i;
    }
    return status;
}

/* The known patches are so far apart that they are both ends; leaves the distances from all of them in g->field. */
static sn_status reach_both(grouping *g, sn_ends_source least, double apart, bool *both, sn_error *error) {
    double most = least == SN_ENDS_ATTACHMENTS ? TRUSTED_REACH : 1.0;
    sn_status status = measure(g, SN_NONE, least, error);
    *both = !status && !(g->field[farthest_point(g)] > most * apart);
    return status;
}

/* Both ends, of which the areas tell one. */
static sn_status make_told(grouping *g, sn_ends_source least, int one, ends *out, bool *made, sn_error *error) {
    sn_index other;
    double apart;
    bool both = false;
    sn_status status = find_other(g, least, one, &other, &apart, error);
    if (!status && other != SN_NONE) status = reach_both(g, least, apart, &both, error);
    if (status) return status;
    if (!both) {
        ends_say(&out->choice, other == SN_NONE ? "%s: no %s is among them" : "%s: all lie at one end or along the belly: no %s is known",
                 kinds[least], sn_attachment_end_names[one ? SN_END_ORIGIN : SN_END_INSERTION]);
        return SN_OK;
    }
    g->patches[other].side = 1 - one;
    return take_both(g, least, apart, out, made, error);
}

/* What was found on one bone alone is where the muscle lies on it: patches of a belly that runs along it are no two ends. */
static bool on_one_bone(const grouping *g, sn_ends_source least) {
    sn_index bone = SN_NONE;
    for (sn_index i = 0; i < g->patch_count; i++) {
        if (!counts(g, &g->patches[i], least)) continue;
        if (bone != SN_NONE && g->patches[i].attachment != bone) return false;
        bone = g->patches[i].attachment;
    }
    return true;
}

/* Both ends from what is at least so good. */
static sn_status make_both(grouping *g, sn_ends_source least, ends *out, bool *made, sn_error *error) {
    sn_index pair[2];
    double apart = 0.0;
    bool both;
    int one, told = take_told_sides(g, &one);
    g->told = told > 0;
    if (told == 2) return take_both(g, least, g->surface->shape->length, out, made, error);
    if (told == 1) return make_told(g, least, one, out, made, error);
    sn_status status = find_pair(g, least, pair, &apart, error);
    if (status || pair[0] == SN_NONE) return status;
    if (pair[0] == pair[1]) {
        ends_say(&out->choice, "%s: there is one only, on %s", kinds[least], g->muscle->attachments[g->patches[pair[0]].attachment].bone);
        return SN_OK;
    }
    if (least == SN_ENDS_ATTACHMENTS && on_one_bone(g, least)) {
        ends_say(&out->choice, "%s: all are on one bone, %s", kinds[least], g->muscle->attachments[g->patches[pair[0]].attachment].bone);
        return SN_OK;
    }
    status = reach_both(g, least, apart, &both, error);
    if (status) return status;
    if (!both) {
        ends_say(&out->choice, "%s: all lie at one end or along the belly", kinds[least]);
        return SN_OK;
    }
    for (int side = 0; side < 2; side++) g->patches[pair[side]].side = side;
    return take_both(g, least, apart, out, made, error);
}

/* The point farthest from all that is known is the other end. */
static sn_status make_one(grouping *g, sn_ends_source least, ends *out, bool *made, sn_error *error) {
    const sn_mesh *mesh = g->surface->mesh;
    sn_status status = measure(g, SN_NONE, least, error);
    if (status) return status;
    sn_index tip = farthest_point(g);
    int one, told = take_told_sides(g, &one), known = told == 1 ? one : 0;
    for (sn_index i = 0; i < g->patch_count; i++) g->patches[i].side = counts(g, &g->patches[i], least) ? known : -1;
    write_ends(g, out);
    sn_index held = out->count;
    memset(g->seen, 0, (size_t)mesh->vertex_count * sizeof *g->seen);
    for (sn_index i = 0; i < held; i++) g->seen[out->vertices[i]] = 1;
    status = sn_geodesic_distance(mesh, g->surface->topology, 1, &tip, g->field, error);
    for (sn_index v = 0; v < mesh->vertex_count && !status; v++) {
        if (g->seen[v] || !(g->field[v] <= TIP_PATCH * g->surface->shape->length)) continue;
        out->vertices[out->count] = v;
        out->values[out->count++] = 1 - known;
    }
    if (status || out->count == held) return status; /* all of the surface is held */
    *made = true;
    ends_source(out, least, known == 0, known == 1);
    ends_say(&out->choice, "the end that is not known is the tip farthest from the other");
    return SN_OK;
}

static bool any(const grouping *g, sn_ends_source source) {
    for (sn_index i = 0; i < g->patch_count; i++)
        if (g->patches[i].source == source) return true;
    return false;
}

static sn_status make_ends(grouping *g, ends *out, bool *made, sn_error *error) {
    sn_status status = SN_OK;
    for (int least = SN_ENDS_AREAS; least >= SN_ENDS_ATTACHMENTS && !status && !*made; least--) {
        if (!any(g, (sn_ends_source)least)) continue;
        if (least == SN_ENDS_ATTACHMENTS) judge_found(g, &out->choice);
        status = make_both(g, (sn_ends_source)least, out, made, error);
    }
    if (status) return status;
    out->choice.unused = out->choice.source < SN_ENDS_PINS && (any(g, SN_ENDS_AREAS) || any(g, SN_ENDS_PINS));
    out->choice.refused = out->choice.source < SN_ENDS_ATTACHMENTS && any(g, SN_ENDS_ATTACHMENTS);
    if (*made) return SN_OK;
    if (any(g, SN_ENDS_AREAS) || any(g, SN_ENDS_PINS))
        return make_one(g, any(g, SN_ENDS_PINS) ? SN_ENDS_PINS : SN_ENDS_AREAS, out, made, error);
    return SN_OK;
}

/* ---- the whole ---------------------------------------------------------------------------------------------------------------- */

static bool grouping_alloc(grouping *g) {
    sn_index vertices = g->surface->mesh->vertex_count, attachments = g->muscle->attachment_count;
    g->holder = SN_NEW(sn_index, vertices);
    g->source = SN_NEW(unsigned char, vertices);
    g->found = SN_NEW(bool, vertices);
    g->seen = SN_NEW(unsigned char, vertices);
    g->list = SN_NEW(sn_index, vertices);
    g->sources = SN_NEW(sn_index, vertices);
    g->field = SN_NEW(double, vertices);
    g->values = SN_NEW(double, vertices);
    g->grips = SN_NEW(sn_grip, attachments);
    g->trusted = SN_NEW(bool, attachments);
    return g->holder && g->source && g->found && g->seen && g->list && g->sources && g->field && g->values && g->grips && g->trusted;
}

static void grouping_free(grouping *g) {
    free(g->holder);
    free(g->source);
    free(g->found);
    free(g->seen);
    free(g->list);
    free(g->sources);
    free(g->field);
    free(g->values);
    free(g->grips);
    free(g->trusted);
    free(g->patches);
}

static sn_status from_attachments(const ends_surface *surface, const sn_muscle *muscle, ends *out, bool *made, sn_error *error) {
    grouping g = {.surface = surface, .muscle = muscle};
    sn_status status = grouping_alloc(&g) ? SN_OK : sn_fail_memory(error, "the ends of the muscle");
    if (!status) {
        mark_held(&g);
        status = find_patches(&g, error);
    }
    if (!status) status = sn_muscle_grips(muscle, g.grips, error);
    if (!status) status = make_ends(&g, out, made, error);
    grouping_free(&g);
    return status;
}

sn_status ends_choose(const ends_surface *surface, const sn_muscle *muscle, sn_index site_count, const sn_end_site *sites, ends *out,
                      sn_error *error) {
    out->count = 0;
    out->choice = (sn_ends_choice){.from = ""};
    if (site_count > 0) return ends_from_sites(surface, site_count, sites, out, error);
    bool made = false, attached = false;
    for (sn_index i = 0; i < muscle->attachment_count; i++) attached |= muscle->attachments[i].count > 0;
    sn_status status = attached ? from_attachments(surface, muscle, out, &made, error) : SN_OK;
    if (status || made) return status;
    if (!attached) ends_say(&out->choice, "no attachments are known");
    return ends_from_tips(surface, out, error);
}
