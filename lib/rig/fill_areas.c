/*
 * fill_areas.c -- points spread evenly over attachment areas: the area is cut into cells of equal area, by halves across its longest way,
 * and the point of a cell is the one nearest to its middle.
 *
 * A point of the surface belongs to the area where the nearest corner of its triangle does, so that vertices without a whole triangle count
 * for what they stand for.
 */
#include <stdlib.h>

#include "fill.h"

enum { PLACES_A_POINT = 32, LEAST_PLACES = 2048, ROUNDS = 4, MOST_ROUNDED = 1024 };

/* A place of the area; key: what it is sorted by. */
typedef struct area_place {
    double key;
    sn_index number;
    sn_vec3 at;
} area_place;

static int compare_places(const void *left, const void *right) {
    const area_place *a = left, *b = right;
    if (a->key != b->key) return a->key < b->key ? -1 : 1;
    return (a->number > b->number) - (a->number < b->number);
}

/* ---- places of equal area ---------------------------------------------------------------------------------------------------- */

static double area_of(const sn_mesh *mesh, sn_index t, const char *member) {
    const sn_index *v = mesh->triangles[t].v;
    int corners = member[v[0]] + member[v[1]] + member[v[2]];
    if (corners == 0) return 0.0;
    const sn_vec3 *p = mesh->positions;
    return 0.5 * sn_norm(sn_area_vector(p[v[0]], p[v[1]], p[v[2]])) * corners / 3.0;
}

double fill_area(const sn_mesh *mesh, const char *member) {
    double sum = 0.0;
    for (sn_index t = 0; t < mesh->triangle_count; t++) sum += area_of(mesh, t, member);
    return sum;
}

/* A place in the triangle whose nearest corner is a member: where it is not, the weights of that corner and of a member change places. */
static sn_vec3 place_in(const sn_mesh *mesh, sn_index t, const char *member, const double at[2]) {
    const sn_index *v = mesh->triangles[t].v;
    double root = sqrt(at[0]), w[3] = {1.0 - root, root * (1.0 - at[1]), root * at[1]};
    int nearest = w[0] >= w[1] && w[0] >= w[2] ? 0 : w[1] >= w[2] ? 1 : 2;
    if (!member[v[nearest]]) {
        int a = (nearest + 1) % 3, b = (nearest + 2) % 3;
        int other = !member[v[b]] || (member[v[a]] && w[a] >= w[b]) ? a : b;
        double swapped = w[nearest];
        w[nearest] = w[other];
        w[other] = swapped;
    }
    sn_vec3 p = sn_scale(mesh->positions[v[0]], w[0]);
    return sn_add_scaled(sn_add_scaled(p, mesh->positions[v[1]], w[1]), mesh->positions[v[2]], w[2]);
}

/* Places at equal steps of area from triangle to triangle; in each by the two-dimensional golden ratio, which is even over any run. */
static void put_places(const sn_mesh *mesh, const char *member, double step, sn_index count, area_place *out) {
    double before = 0.0;
    sn_index n = 0;
    for (sn_index t = 0; t < mesh->triangle_count && n < count; t++) {
        double area = area_of(mesh, t, member);
        for (; n < count && ((double)n + 0.5) * step <= before + area; n++) {
            double at[2] = {0.7548776662466927 * (n + 1), 0.5698402909980532 * (n + 1)};
            for (int i = 0; i < 2; i++) at[i] -= floor(at[i]);
            out[n] = (area_place){0.0, n, place_in(mesh, t, member, at)};
        }
        before += area;
    }
    for (; n < count; n++) out[n] = (area_place){0.0, n, n > 0 ? out[n - 1].at : sn_v3(0, 0, 0)}; /* rounding of the sum */
}

/* ---- cells of equal area --------------------------------------------------------------------------------------------------------- */

static double coordinate(sn_vec3 p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

static int longest_axis(const area_place *places, sn_index count) {
    sn_vec3 low = places[0].at, high = low;
    for (sn_index i = 1; i < count; i++) {
        low = sn_min3(low, places[i].at);
        high = sn_max3(high, places[i].at);
    }
    sn_vec3 d = sn_sub(high, low);
    return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
}

static sn_vec3 middle_of(const area_place *places, sn_index count) {
    sn_vec3 sum = {0, 0, 0};
    for (sn_index i = 0; i < count; i++) sum = sn_add(sum, places[i].at);
    return sn_scale(sum, 1.0 / (double)count);
}

static sn_vec3 nearest_place(const area_place *places, sn_index count, sn_vec3 to) {
    sn_index best = 0;
    double least = INFINITY;
    for (sn_index i = 0; i < count; i++) {
        double d = sn_norm2(sn_sub(places[i].at, to));
        if (d >= least) continue;
        least = d;
        best = i;
    }
    return places[best].at;
}

/* Depth is the logarithm of `cells`. */
static void cut_cells(area_place *places, sn_index count, sn_index cells, sn_vec3 *out) {
    if (cells == 1) {
        out[0] = nearest_place(places, count, middle_of(places, count));
        return;
    }
    int axis = longest_axis(places, count);
    for (sn_index i = 0; i < count; i++) places[i].key = coordinate(places[i].at, axis);
    qsort(places, (size_t)count, sizeof *places, compare_places);
    sn_index first = cells / 2, here = (sn_index)((int64_t)count * first / cells);
    cut_cells(places, here, first, out);
    cut_cells(places + here, count - here, cells - first, out + first);
}

/* Rounds of Lloyd: each point to the middle of the places that are nearest to it. It evens out what the halves leave. */
static bool relax(const area_place *places, sn_index count, sn_index points, sn_vec3 *out) {
    sn_vec3 *sums = SN_NEW(sn_vec3, points);
    sn_index *counts = SN_NEW(sn_index, points);
    for (int round = 0; sums && counts && round < ROUNDS; round++) {
        for (sn_index k = 0; k < points; k++) {
            sums[k] = sn_v3(0, 0, 0);
            counts[k] = 0;
        }
        for (sn_index i = 0; i < count; i++) {
            sn_index best = 0;
            double least = INFINITY;
            for (sn_index k = 0; k < points; k++) {
                double d = sn_norm2(sn_sub(places[i].at, out[k]));
                if (d < least) best = k;
                least = fmin(least, d);
            }
            sums[best] = sn_add(sums[best], places[i].at);
            counts[best]++;
        }
        for (sn_index k = 0; k < points; k++)
            if (counts[k] > 0) out[k] = nearest_place(places, count, sn_scale(sums[k], 1.0 / (double)counts[k]));
    }
    bool made = sums && counts;
    free(sums);
    free(counts);
    return made;
}

sn_status fill_sample_area(const sn_mesh *mesh, const char *member, sn_index count, sn_vec3 *out, sn_error *error) {
    int64_t wanted = count > 10000 ? 8 * (int64_t)count : PLACES_A_POINT * (int64_t)count;
    sn_index place_count = (sn_index)(wanted < LEAST_PLACES ? LEAST_PLACES : wanted);
    double area = fill_area(mesh, member);
    if (!(area > 0.0)) return sn_fail(error, SN_ERROR_INPUT, "an attachment has no area: no triangle at its vertices has any");
    area_place *places = SN_NEW(area_place, place_count);
    if (!places) return sn_fail_memory(error, "the ends of the fibres");
    put_places(mesh, member, area / (double)place_count, place_count, places);
    cut_cells(places, place_count, count, out);
    bool good = count > MOST_ROUNDED || relax(places, place_count, count, out);
    free(places);
    return good ? SN_OK : sn_fail_memory(error, "the ends of the fibres");
}
