/* flow_harmonic.c -- fibres along the gradient of a harmonic field from one end of the muscle to the other. */
#include <stdlib.h>

#include "flow.h"

sn_status flow_find_ends(const sn_muscle *muscle, const sn_topology *topology, const sn_flow_params *params, ends *out, sn_error *error) {
    surface_survey survey;
    tips shape;
    sn_status status = ends_alloc(muscle->mesh.vertex_count, out, error);
    if (!status) status = survey_surface(&muscle->mesh, topology, &survey, error);
    if (!status) status = find_tips(&muscle->mesh, topology, survey.main_vertex, NULL, &shape, error);
    const ends_surface surface = {&muscle->mesh, topology, &shape};
    return status ? status : ends_choose(&surface, muscle, params->site_count, params->sites, out, error);
}

/* grad u = sum_i u_i (n x e_i) / 2A, e_i opposite to corner i, and its weight A: with the doubled area vector N the sum of u_i (N x e_i) is
 * 4 A^2 grad u. */
static void add_gradient(const sn_mesh *mesh, sn_triangle t, const double *u, sn_vec3 *sum) {
    const sn_vec3 *p = mesh->positions;
    sn_vec3 normal = sn_area_vector(p[t.v[0]], p[t.v[1]], p[t.v[2]]), turned = {0, 0, 0};
    double doubled = sn_norm(normal);
    if (!(doubled > 0.0)) return;
    for (int i = 0; i < 3; i++) {
        sn_vec3 edge = sn_sub(p[t.v[(i + 2) % 3]], p[t.v[(i + 1) % 3]]);
        turned = sn_add_scaled(turned, sn_cross(normal, edge), u[t.v[i]]);
    }
    if (!sn_finite3(turned)) return; /* a component that no end is on */
    for (int i = 0; i < 3; i++) sum[t.v[i]] = sn_add_scaled(sum[t.v[i]], turned, 1.0 / doubled);
}

sn_status harmonic_directions(const flow_input *in, const ends *e, sn_vec3 *directions, sn_error *error) {
    const sn_mesh *mesh = &in->muscle->mesh;
    double *u = SN_NEW(double, mesh->vertex_count);
    if (!u) return sn_fail_memory(error, "the field between the muscle's ends");
    sn_status status = sn_harmonic_field(mesh, in->topology, &(sn_fixed_values){e->count, e->vertices, e->values}, u, error);
    for (sn_index v = 0; v < mesh->vertex_count; v++) directions[v] = sn_v3(0, 0, 0);
    for (sn_index t = 0; !status && t < mesh->triangle_count; t++) add_gradient(mesh, mesh->triangles[t], u, directions);
    if (!status &&
        SN_TRACE(in->trace, "field", sn_trace_text("ends", e->choice.from), sn_trace_indices("fixed", e->vertices, e->count)))
        status = SN_STOPPED;
    free(u);
    return status;
}
