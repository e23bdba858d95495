/*
 * vec.h -- inline vec3, mat3, quaternion, rigid transform; no state.   rank 0
 */
#ifndef SINEW_VEC_H
#define SINEW_VEC_H

#include <math.h>

#include "sinew/exact.h"

typedef struct sn_vec3 { double x, y, z; } sn_vec3;
typedef struct sn_mat3 { double m[3][3]; } sn_mat3;        /* row-major: m[row][column] */
typedef struct sn_quat { double w, x, y, z; } sn_quat;
typedef struct sn_rigid { sn_quat rotation; sn_vec3 translation; } sn_rigid; /* p -> R p + t */

#define SN_PI 3.14159265358979323846

static inline sn_vec3 sn_v3(double x, double y, double z) { return (sn_vec3){x, y, z}; }
static inline sn_vec3 sn_add(sn_vec3 a, sn_vec3 b) { return sn_v3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline sn_vec3 sn_sub(sn_vec3 a, sn_vec3 b) { return sn_v3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline sn_vec3 sn_scale(sn_vec3 a, double s) { return sn_v3(a.x * s, a.y * s, a.z * s); }
static inline sn_vec3 sn_add_scaled(sn_vec3 a, sn_vec3 b, double s) { return sn_v3(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s); }
static inline sn_vec3 sn_neg(sn_vec3 a) { return sn_v3(-a.x, -a.y, -a.z); }
static inline double sn_dot(sn_vec3 a, sn_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline sn_vec3 sn_cross(sn_vec3 a, sn_vec3 b) {
    return sn_v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline double sn_norm2(sn_vec3 a) { return sn_dot(a, a); }
static inline double sn_norm(sn_vec3 a) { return sqrt(sn_dot(a, a)); }
static inline double sn_distance(sn_vec3 a, sn_vec3 b) { return sn_norm(sn_sub(a, b)); }
/* Length of (x, y), for sizes whose squares are normal numbers. */
static inline double sn_length2(double x, double y) { return sqrt(x * x + y * y); }
static inline sn_vec3 sn_lerp(sn_vec3 a, sn_vec3 b, double t) { return sn_add_scaled(a, sn_sub(b, a), t); }
static inline sn_vec3 sn_min3(sn_vec3 a, sn_vec3 b) { return sn_v3(fmin(a.x, b.x), fmin(a.y, b.y), fmin(a.z, b.z)); }
static inline sn_vec3 sn_max3(sn_vec3 a, sn_vec3 b) { return sn_v3(fmax(a.x, b.x), fmax(a.y, b.y), fmax(a.z, b.z)); }
static inline bool sn_finite3(sn_vec3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }
/* a/|a|, or the zero vector where |a| is zero or not finite: test the result with sn_norm2() > 0. */
static inline sn_vec3 sn_normalize(sn_vec3 a) {
    double scale = fmax(fmax(fabs(a.x), fabs(a.y)), fabs(a.z));
    if (!(scale > 0.0) || !isfinite(scale)) return sn_v3(0, 0, 0);
    sn_vec3 b = sn_v3(a.x / scale, a.y / scale, a.z / scale);
    double length = sn_norm(b);
    return sn_v3(b.x / length, b.y / length, b.z / length);
}
/* Twice the area vector of triangle (a,b,c), outwards for counter-clockwise order seen from outside. */
static inline sn_vec3 sn_area_vector(sn_vec3 a, sn_vec3 b, sn_vec3 c) { return sn_cross(sn_sub(b, a), sn_sub(c, a)); }

static inline sn_mat3 sn_mat3_identity(void) { return (sn_mat3){{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; }
static inline sn_vec3 sn_mat3_apply(const sn_mat3 *a, sn_vec3 v) {
    return sn_v3(a->m[0][0] * v.x + a->m[0][1] * v.y + a->m[0][2] * v.z, a->m[1][0] * v.x + a->m[1][1] * v.y + a->m[1][2] * v.z,
                 a->m[2][0] * v.x + a->m[2][1] * v.y + a->m[2][2] * v.z);
}

static inline sn_quat sn_quat_identity(void) { return (sn_quat){1, 0, 0, 0}; }
static inline sn_quat sn_quat_multiply(sn_quat a, sn_quat b) {
    return (sn_quat){a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                     a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
static inline sn_quat sn_quat_conjugate(sn_quat q) { return (sn_quat){q.w, -q.x, -q.y, -q.z}; }
static inline double sn_quat_dot(sn_quat a, sn_quat b) { return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z; }
/* Unit quaternion; the identity where q is zero. */
static inline sn_quat sn_quat_normalize(sn_quat q) {
    double n = sqrt(sn_quat_dot(q, q));
    return n > 0.0 ? (sn_quat){q.w / n, q.x / n, q.y / n, q.z / n} : sn_quat_identity();
}
/* Rotation by angle (rad) about a unit axis. */
static inline sn_quat sn_quat_axis_angle(sn_vec3 axis, double angle) {
    double s = sn_sin(0.5 * angle);
    return (sn_quat){sn_cos(0.5 * angle), s * axis.x, s * axis.y, s * axis.z};
}
/* R(q) v for a unit quaternion. */
static inline sn_vec3 sn_quat_rotate(sn_quat q, sn_vec3 v) {
    sn_vec3 u = sn_v3(q.x, q.y, q.z);
    sn_vec3 t = sn_scale(sn_cross(u, v), 2.0);
    return sn_add(sn_add(v, sn_scale(t, q.w)), sn_cross(u, t));
}
/* Spherical interpolation along the shorter way, t in [0,1]; q and -q are the same rotation. */
static inline sn_quat sn_quat_slerp(sn_quat a, sn_quat b, double t) {
    double d = sn_quat_dot(a, b);
    if (d < 0.0) { b = (sn_quat){-b.w, -b.x, -b.y, -b.z}; d = -d; }
    double wa = 1.0 - t, wb = t;
    if (d < 0.9995) {
        double angle = sn_acos(d), s = sn_sin(angle);
        wa = sn_sin((1.0 - t) * angle) / s;
        wb = sn_sin(t * angle) / s;
    }
    return sn_quat_normalize((sn_quat){wa * a.w + wb * b.w, wa * a.x + wb * b.x, wa * a.y + wb * b.y, wa * a.z + wb * b.z});
}

static inline sn_rigid sn_rigid_identity(void) { return (sn_rigid){{1, 0, 0, 0}, {0, 0, 0}}; }
static inline sn_vec3 sn_rigid_apply(sn_rigid t, sn_vec3 p) { return sn_add(sn_quat_rotate(t.rotation, p), t.translation); }
/* a after b: p -> a(b(p)). */
static inline sn_rigid sn_rigid_compose(sn_rigid a, sn_rigid b) {
    return (sn_rigid){sn_quat_multiply(a.rotation, b.rotation), sn_rigid_apply(a, b.translation)};
}
static inline sn_rigid sn_rigid_inverse(sn_rigid t) {
    sn_quat q = sn_quat_conjugate(t.rotation);
    return (sn_rigid){q, sn_neg(sn_quat_rotate(q, t.translation))};
}

#endif
