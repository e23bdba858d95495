/*
 * frames.c -- the rotation of every point since rest.   numerics.md 7
 *
 * The muscle is divided into overlapping sections around centres that are far from each other (farthest point sampling). A point belongs to
 * its nearest centres with weights (1 - d / d_next)^2, d_next the distance of the first centre that it does not belong to: they change
 * smoothly along the muscle. A section's rotation is the least squares one (Horn 1987: the eigenvector of the largest eigenvalue of a 4 x 4
 * matrix), a point's the normalised mean of its sections' quaternions. Vertices then turn on, the shortest way, until their normals are
 * right: hinges are a hundred times stiffer along the normal than springs are beside it, so that a normal that is off by a few degrees
 * makes a matrix of the rest shape useless.
 */
#include "frames.h"

#include <stdlib.h>

/* ---- making them ---------------------------------------------------------------------------------------------------------- */

/* The centres: the first vertex, then always the vertex farthest from those before. distance (vertices) is scratch. */
static void choose_centres(sn_frames *f, sn_index most, double *distance) {
    const sn_model_muscle *m = f->model;
    for (sn_index i = 0; i < m->vertex_count; i++) distance[i] = INFINITY;
    for (sn_index next = 0; f->count < most && distance[next] > 0.0; f->count++) {
        sn_vec3 centre = m->rest[f->centres[f->count] = next];
        for (sn_index i = 0; i < m->vertex_count; i++) distance[i] = fmin(distance[i], sn_norm2(sn_sub(m->rest[i], centre)));
        for (sn_index i = next = 0; i < m->vertex_count; i++)
            if (distance[i] > distance[next]) next = i;
    }
}

/* A centre and its distance from a point. */
typedef struct neighbour {
    sn_index centre;
    double distance;
} neighbour;

/* The nearest centres of a point, the nearest first; returns how many there are, one more than the overlap at most. */
static int find_nearest(const sn_frames *f, sn_vec3 point, neighbour near[SN_SECTION_OVERLAP + 1]) {
    int found = 0;
    for (sn_index c = 0; c < f->count; c++) {
        neighbour next = {c, sn_distance(point, f->model->rest[f->centres[c]])};
        for (int i = 0; i <= SN_SECTION_OVERLAP && next.centre != SN_NONE; i++) {
            if (i < found && near[i].distance <= next.distance) continue;
            neighbour pushed_out = i < found ? near[i] : (neighbour){SN_NONE, 0.0};
            if (i == found) found++;
            near[i] = next;
            next = pushed_out;
        }
    }
    return found;
}

static void weigh(sn_frames *f, sn_index point) {
    neighbour near[SN_SECTION_OVERLAP + 1];
    int found = find_nearest(f, f->model->rest[point], near), used = found > SN_SECTION_OVERLAP ? SN_SECTION_OVERLAP : found;
    double reach = found > SN_SECTION_OVERLAP ? near[SN_SECTION_OVERLAP].distance : 2.0 * near[used - 1].distance, sum = 0.0;
    for (int k = 0; k < SN_SECTION_OVERLAP; k++) {
        double share = k < used && reach > 0.0 ? 1.0 - near[k].distance / reach : 0.0;
        f->member[point][k] = k < used ? near[k].centre : SN_NONE;
        f->weight[point][k] = share * share + (k == 0 ? 1e-6 : 0.0); /* equally far from all of them: with the first */
        sum += f->weight[point][k];
    }
    for (int k = 0; k < used; k++) f->total[near[k].centre] += f->weight[point][k] /= sum;
}

/* Weighted means of the sections' positions, middle (count): at rest, or at these points. */
static void find_middles(const sn_frames *f, const sn_point *points, sn_vec3 *middle) {
    const sn_model_muscle *m = f->model;
    for (sn_index c = 0; c < f->count; c++) middle[c] = sn_v3(0, 0, 0);
    for (sn_index i = 0; i < m->point_count; i++) {
        sn_vec3 p = points != NULL ? sn_point_position(&points[i]) : m->rest[i];
        for (int k = 0; k < SN_SECTION_OVERLAP && f->member[i][k] != SN_NONE; k++) {
            sn_index c = f->member[i][k];
            middle[c] = sn_add_scaled(middle[c], p, f->weight[i][k] / f->total[c]);
        }
    }
}

/* Sums of area vectors around the vertices, at rest or at these points. */
static void find_normals(const sn_model_muscle *m, const sn_point *points, sn_vec3 *normals) {
    for (sn_index i = 0; i < m->vertex_count; i++) normals[i] = sn_v3(0, 0, 0);
    for (sn_index t = 0; t < m->triangle_count; t++) {
        const sn_index *v = m->triangles[t].v;
        sn_vec3 p[3];
        for (int k = 0; k < 3; k++) p[k] = points != NULL ? sn_point_position(&points[v[k]]) : m->rest[v[k]];
        sn_vec3 normal = sn_area_vector(p[0], p[1], p[2]);
        for (int k = 0; k < 3; k++) normals[v[k]] = sn_add(normals[v[k]], normal);
    }
}

static bool alloc_frames(sn_frames *f, sn_index most) {
    const sn_model_muscle *m = f->model;
    f->centres = SN_NEW(sn_index, most);
    f->member = sn_alloc((size_t)m->point_count, sizeof *f->member);
    f->weight = sn_alloc((size_t)m->point_count, sizeof *f->weight);
    f->total = SN_NEW(double, most);
    f->rest_middle = SN_NEW(sn_vec3, most);
    f->middle = SN_NEW(sn_vec3, most);
    f->spread = SN_NEW(sn_mat3, most);
    f->turn = SN_NEW(sn_quat, most);
    f->rest_normals = SN_NEW(sn_vec3, m->vertex_count);
    f->normals = SN_NEW(sn_vec3, m->vertex_count);
    return f->centres != NULL && f->member != NULL && f->weight != NULL && f->total != NULL && f->rest_middle != NULL &&
           f->middle != NULL && f->spread != NULL && f->turn != NULL && f->rest_normals != NULL && f->normals != NULL;
}

bool sn_frames_create(const sn_model_muscle *m, sn_index most, sn_frames *f) {
    *f = (sn_frames){.model = m};
    double *distance = SN_NEW(double, m->vertex_count);
    bool made = alloc_frames(f, most) && distance != NULL;
    if (made) choose_centres(f, most, distance);
    free(distance);
    if (!made) {
        sn_frames_free(f);
        return false;
    }
    for (sn_index i = 0; i < m->point_count; i++) weigh(f, i);
    find_middles(f, NULL, f->rest_middle);
    find_normals(m, NULL, f->rest_normals);
    return true;
}

void sn_frames_free(sn_frames *f) {
    free(f->centres);
    free(f->member);
    free(f->weight);
    free(f->total);
    free(f->rest_middle);
    free(f->middle);
    free(f->spread);
    free(f->turn);
    free(f->rest_normals);
    free(f->normals);
    *f = (sn_frames){0};
}

/* ---- turning with the muscle ------------------------------------------------------------------------------------------------ */

/* One Jacobi rotation that takes away a[p][q] of a symmetric 4 x 4 matrix; v collects the eigenvectors in its columns. */
static void rotate_away(double a[4][4], double v[4][4], int p, int q) {
    if (a[p][q] == 0.0) return;
    double ratio = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    double t = copysign(1.0, ratio) / (fabs(ratio) + sqrt(ratio * ratio + 1.0)), c = 1.0 / sqrt(t * t + 1.0), s = t * c;
    for (int k = 0; k < 4; k++) {
        double kp = a[k][p], kq = a[k][q];
        a[k][p] = c * kp - s * kq, a[k][q] = s * kp + c * kq;
    }
    for (int k = 0; k < 4; k++) {
        double pk = a[p][k], qk = a[q][k], vp = v[k][p], vq = v[k][q];
        a[p][k] = c * pk - s * qk, a[q][k] = s * pk + c * qk;
        v[k][p] = c * vp - s * vq, v[k][q] = s * vp + c * vq;
    }
}

/* The rotation R that makes the sum of (R a) . b largest, m = the sum of a bT; the identity where m says nothing. */
static sn_quat best_rotation(const sn_mat3 *spread) {
    enum { SWEEPS = 8 };
    const double(*m)[3] = spread->m;
    double a[4][4] = {{m[0][0] + m[1][1] + m[2][2], m[1][2] - m[2][1], m[2][0] - m[0][2], m[0][1] - m[1][0]},
                      {m[1][2] - m[2][1], m[0][0] - m[1][1] - m[2][2], m[0][1] + m[1][0], m[2][0] + m[0][2]},
                      {m[2][0] - m[0][2], m[0][1] + m[1][0], m[1][1] - m[0][0] - m[2][2], m[1][2] + m[2][1]},
                      {m[0][1] - m[1][0], m[2][0] + m[0][2], m[1][2] + m[2][1], m[2][2] - m[0][0] - m[1][1]}};
    double v[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    for (int sweep = 0; sweep < SWEEPS; sweep++)
        for (int p = 0; p < 3; p++)
            for (int q = p + 1; q < 4; q++) rotate_away(a, v, p, q);
    int best = 0;
    for (int k = 1; k < 4; k++)
        if (a[k][k] > a[best][best]) best = k;
    sn_quat q = {v[0][best], v[1][best], v[2][best], v[3][best]};
    double size = sn_quat_dot(q, q);
    return size > 0.5 && size < 2.0 ? sn_quat_normalize(q) : sn_quat_identity();
}

static void add_spread(sn_mat3 *sum, sn_vec3 a, sn_vec3 b, double weight) {
    const double left[3] = {weight * a.x, weight * a.y, weight * a.z}, right[3] = {b.x, b.y, b.z};
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) sum->m[r][c] += left[r] * right[c];
}

static void turn_sections(sn_frames *f, const sn_point *points) {
    const sn_model_muscle *m = f->model;
    find_middles(f, points, f->middle);
    for (sn_index c = 0; c < f->count; c++) f->spread[c] = (sn_mat3){0};
    for (sn_index i = 0; i < m->point_count; i++) {
        for (int k = 0; k < SN_SECTION_OVERLAP && f->member[i][k] != SN_NONE; k++) {
            sn_index c = f->member[i][k];
            sn_vec3 now = sn_sub(sn_point_position(&points[i]), f->middle[c]);
            add_spread(&f->spread[c], sn_sub(m->rest[i], f->rest_middle[c]), now, f->weight[i][k]);
        }
    }
    for (sn_index c = 0; c < f->count; c++) f->turn[c] = best_rotation(&f->spread[c]);
}

static sn_quat blend_turns(const sn_frames *f, sn_index point) {
    sn_quat first = f->turn[f->member[point][0]], sum = {0, 0, 0, 0};
    for (int k = 0; k < SN_SECTION_OVERLAP && f->member[point][k] != SN_NONE; k++) {
        sn_quat q = f->turn[f->member[point][k]];
        double w = f->weight[point][k] * (sn_quat_dot(q, first) < 0.0 ? -1.0 : 1.0);
        sum = (sn_quat){sum.w + w * q.w, sum.x + w * q.x, sum.y + w * q.y, sum.z + w * q.z};
    }
    return sn_quat_normalize(sum);
}

/* On from `turn`, the shortest way, until `from` points along `to`; no further where that is nearly backwards. */
static sn_quat turn_on(sn_quat turn, sn_vec3 from, sn_vec3 to) {
    sn_vec3 a = sn_quat_rotate(turn, sn_normalize(from)), b = sn_normalize(to), axis = sn_cross(a, b);
    double cosine = sn_dot(a, b);
    if (!(cosine > -0.9)) return turn;
    return sn_quat_multiply(sn_quat_normalize((sn_quat){1.0 + cosine, axis.x, axis.y, axis.z}), turn);
}

void sn_frames_turn(sn_frames *f, const sn_point *points, sn_quat *turns) {
    const sn_model_muscle *m = f->model;
    turn_sections(f, points);
    find_normals(m, points, f->normals);
    for (sn_index i = 0; i < m->point_count; i++) {
        turns[i] = blend_turns(f, i);
        if (i < m->vertex_count) turns[i] = turn_on(turns[i], f->rest_normals[i], f->normals[i]);
    }
}
