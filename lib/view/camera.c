/* camera.c -- where to look from. */
#include "sinew/view.h"

#include "sinew/numeric.h"

static const sn_box EMPTY = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static double radians(double degrees) { return degrees * SN_PI / 180.0; }

sn_camera sn_camera_from(double azimuth, double elevation) {
    double a = radians(azimuth), e = radians(elevation);
    sn_vec3 back = sn_v3(sn_sin(a) * sn_cos(e), -sn_cos(a) * sn_cos(e), sn_sin(e));
    sn_vec3 right = sn_v3(sn_cos(a), sn_sin(a), 0.0);
    return (sn_camera){.right = right, .up = sn_cross(back, right), .back = back, .extent = EMPTY, .zoom = 1.0};
}

/* Does the camera look at all there is, or only at some of its meshes? */
static bool is_focused(const sn_view *view) {
    for (size_t m = 0; m < view->mesh_count; m++)
        if (view->meshes[m].focus) return true;
    return false;
}

static sn_box view_box(const sn_view *view) {
    sn_box box = EMPTY;
    bool focused = is_focused(view);
    for (size_t m = 0; m < view->mesh_count; m++)
        for (sn_index i = 0; i < view->meshes[m].vertex_count && view->meshes[m].focus == focused; i++) {
            box.low = sn_min3(box.low, view->meshes[m].positions[i]);
            box.high = sn_max3(box.high, view->meshes[m].positions[i]);
        }
    return box;
}

/* Second moments of the surface about its centroid, a triangle's weight at its centre; lengths in units of `size`. */
static sn_mat3 second_moments(const sn_view *view, sn_vec3 origin, double size) {
    bool focused = is_focused(view);
    double weight = 0.0, first[3] = {0}, second[3][3] = {{0}};
    for (size_t m = 0; m < view->mesh_count; m++) {
        const sn_view_mesh *mesh = &view->meshes[m];
        for (sn_index t = 0; t < mesh->triangle_count && mesh->focus == focused; t++) {
            const sn_index *v = mesh->triangles[t].v;
            sn_vec3 a = sn_scale(sn_sub(mesh->positions[v[0]], origin), 1.0 / size);
            sn_vec3 b = sn_scale(sn_sub(mesh->positions[v[1]], origin), 1.0 / size);
            sn_vec3 c = sn_scale(sn_sub(mesh->positions[v[2]], origin), 1.0 / size);
            sn_vec3 p = sn_scale(sn_add(sn_add(a, b), c), 1.0 / 3.0);
            const double area = sn_norm(sn_area_vector(a, b, c)), x[3] = {p.x, p.y, p.z};
            weight += area;
            for (int i = 0; i < 3; i++) {
                first[i] += area * x[i];
                for (int j = 0; j < 3; j++) second[i][j] += area * x[i] * x[j];
            }
        }
    }
    sn_mat3 moments = {{{0}}};
    for (int i = 0; i < 3 && weight > 0.0; i++)
        for (int j = 0; j < 3; j++) moments.m[i][j] = second[i][j] / weight - first[i] * first[j] / (weight * weight);
    return moments;
}

static sn_vec3 column(const sn_mat3 *m, int c) { return sn_v3(m->m[0][c], m->m[1][c], m->m[2][c]); }

/* The one of axis and -axis that points along `wish`, or where that is undecided along `second`. */
static sn_vec3 towards(sn_vec3 axis, sn_vec3 wish, sn_vec3 second) {
    double d = sn_dot(axis, wish);
    if (fabs(d) < 0.05) d = sn_dot(axis, second);
    return d < 0.0 ? sn_neg(axis) : axis;
}

sn_camera sn_camera_auto(const sn_view *view, bool portrait, double spin) {
    sn_box box = view_box(view);
    double size = sn_box_diagonal(box), values[3];
    sn_mat3 axes;
    if (!(size > 0.0) || !isfinite(size)) return sn_camera_from(spin, 0.0);
    sn_mat3 moments = second_moments(view, sn_lerp(box.low, box.high, 0.5), size);
    if (!sn_eigen_symmetric3(&moments, values, &axes) || !(values[2] > 0.0)) return sn_camera_from(spin, 0.0);
    sn_camera camera = {.extent = EMPTY, .zoom = 1.0};
    sn_vec3 length = column(&axes, 2);
    camera.back = towards(column(&axes, 0), sn_v3(0, -1, 0), sn_v3(1, 0.1, 0.01));
    length = portrait ? towards(length, sn_v3(0, 0, 1), sn_v3(0, -1, 0)) : towards(length, sn_v3(0, 0, -1), sn_v3(1, 0.1, 0));
    camera.back = sn_quat_rotate(sn_quat_axis_angle(length, radians(spin)), camera.back);
    sn_vec3 across = portrait ? sn_cross(length, camera.back) : sn_cross(camera.back, length);
    camera.right = portrait ? across : length;
    camera.up = portrait ? length : across;
    return camera;
}

static void include_point(sn_camera *camera, sn_vec3 p) {
    sn_vec3 q = sn_v3(sn_dot(p, camera->right), sn_dot(p, camera->up), sn_dot(p, camera->back));
    camera->extent.low = sn_min3(camera->extent.low, q);
    camera->extent.high = sn_max3(camera->extent.high, q);
}

void sn_camera_include(sn_camera *camera, const sn_view *view) {
    bool focused = is_focused(view);
    for (size_t m = 0; m < view->mesh_count; m++)
        for (sn_index i = 0; i < view->meshes[m].vertex_count && view->meshes[m].focus == focused; i++)
            include_point(camera, view->meshes[m].positions[i]);
    for (size_t t = 0; t < view->tube_count && !focused; t++) {
        include_point(camera, view->tubes[t].a);
        include_point(camera, view->tubes[t].b);
    }
}
