/*
 * cgal_remesh.cpp -- isotropic remeshing by splits, collapses, flips and relaxation (Botsch, Kobbelt 2004; CGAL Polygon Mesh Processing).
 */
#include "cgal_surface.hpp"

#include <CGAL/Polygon_mesh_processing/remesh.h>

namespace PMP = CGAL::Polygon_mesh_processing;
using namespace sinew;

namespace {

std::vector<Face> free_faces(const Surface &surface, const bool *held) {
    std::vector<Face> faces;
    for (Face face : surface.faces()) {
        bool free = true;
        for (Vertex v : surface.vertices_around_face(surface.halfedge(face))) free = free && !held[v.idx()];
        if (free) faces.push_back(face);
    }
    return faces;
}

} // namespace

sn_status sn_bridge_remesh(const sn_bridge_mesh *in, double edge_length, unsigned iterations, const bool *held, sn_bridge_mesh *out,
                           sn_error *error) {
    return guarded("remeshing", error, [&] {
        Surface surface;
        to_surface(in, surface);
        if (held == nullptr) {
            PMP::isotropic_remeshing(surface.faces(), edge_length, surface, CGAL::parameters::number_of_iterations(iterations));
        } else {
            PMP::isotropic_remeshing(free_faces(surface, held), edge_length, surface, CGAL::parameters::number_of_iterations(iterations));
        }
        surface.collect_garbage();
        const sn_bridge_mesh nothing = {}; /* no vertex or triangle is where it was */
        from_surface(surface, &nothing, out);
        return SN_OK;
    });
}
