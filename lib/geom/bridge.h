/*
 * bridge.h -- meshes to the arrays of the CGAL bridge and back; private to lib/geom.
 */
#ifndef SINEW_GEOM_BRIDGE_H
#define SINEW_GEOM_BRIDGE_H

#include "sinew/mesh.h"

#include "cgal_bridge.h"

/* The unit box's place in the mesh's coordinates: p = centre + size q. */
typedef struct sn_bridge_frame {
    sn_vec3 centre;
    double size;
} sn_bridge_frame;

/* The mesh in the unit box. SN_ERROR_INPUT where it is not valid or has no extent. Free *out with sn_bridge_free. */
SN_MUST_CHECK sn_status sn_to_bridge(const sn_mesh *mesh, sn_bridge_mesh *out, sn_bridge_frame *where, sn_error *error);
/* SN_ERROR_INPUT where a triangle has a repeated index: CGAL does not expect them. */
SN_MUST_CHECK sn_status sn_bridge_check_indices(const sn_mesh *mesh, sn_error *error);
/* *after is the mesh that came back, checked, with the attributes and groups of the vertices and triangles that it came from; a vertex
 * that was not moved has the very coordinates it had. */
SN_MUST_CHECK sn_status sn_from_bridge(const sn_mesh *before, const sn_bridge_mesh *in, const sn_bridge_mesh *out, sn_bridge_frame where,
                                       sn_mesh *after, sn_error *error);
void sn_bridge_free(sn_bridge_mesh *mesh);
/* Put *by in place of *mesh; *by is empty then. */
void sn_mesh_replace(sn_mesh *mesh, sn_mesh *by);

#endif
