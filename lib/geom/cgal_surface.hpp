/*
 * cgal_surface.hpp -- a CGAL Surface_mesh from the bridge's arrays and back, remembering where each vertex and triangle came from.
 */
#ifndef SINEW_GEOM_CGAL_SURFACE_HPP
#define SINEW_GEOM_CGAL_SURFACE_HPP

#include <stdexcept>
#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include "cgal_common.hpp"

namespace sinew {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Surface = CGAL::Surface_mesh<Point>;
using Vertex = Surface::Vertex_index;
using Face = Surface::Face_index;
using Halfedge = Surface::Halfedge_index;

/* Vertices and faces get the indices of the arrays; throws where the triangles are no oriented manifold. */
inline void to_surface(const sn_bridge_mesh *in, Surface &surface) {
    surface.reserve(Surface::size_type(in->vertex_count), Surface::size_type(3 * in->triangle_count),
                    Surface::size_type(in->triangle_count));
    for (sn_index i = 0; i < in->vertex_count; i++) {
        const double *p = in->points + 3 * i;
        surface.add_vertex(Point(p[0], p[1], p[2]));
    }
    for (sn_index t = 0; t < in->triangle_count; t++) {
        const sn_index *v = in->triangles + 3 * t;
        Face face = surface.add_face(Vertex(Surface::size_type(v[0])), Vertex(Surface::size_type(v[1])), Vertex(Surface::size_type(v[2])));
        if (face == Surface::null_face()) throw std::runtime_error("its triangles are not an oriented manifold");
    }
}

/* Faces below old_faces and vertices below old_vertices are the input's. Each triangle starts at the corner it had, so that an
 * untouched triangle comes back as it went in. */
inline void from_surface(const Surface &surface, const sn_bridge_mesh *in, sn_bridge_mesh *out) {
    allocate_mesh(surface.number_of_vertices(), surface.number_of_faces(), out);
    std::vector<sn_index> place(surface.num_vertices(), SN_NONE);
    sn_index count = 0;
    for (Vertex v : surface.vertices()) {
        const Point &p = surface.point(v);
        for (int k = 0; k < 3; k++) out->points[3 * count + k] = p[k];
        out->vertex_origin[count] = v.idx() < Surface::size_type(in->vertex_count) ? sn_index(v.idx()) : SN_NONE;
        place[v.idx()] = count++;
    }
    sn_index t = 0;
    for (Face face : surface.faces()) {
        bool old = face.idx() < Surface::size_type(in->triangle_count);
        out->triangle_origin[t] = old ? sn_index(face.idx()) : SN_NONE;
        Halfedge h = surface.halfedge(face);
        for (int turn = 0; old && turn < 3; turn++) {
            if (sn_index(surface.source(h).idx()) == in->triangles[3 * face.idx()]) break;
            h = surface.next(h);
        }
        for (int k = 0; k < 3; k++, h = surface.next(h)) out->triangles[3 * t + k] = place[surface.source(h).idx()];
        t++;
    }
}

} // namespace sinew
#endif
