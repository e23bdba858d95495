/*
 * cgal_holes.cpp -- hole filling by minimal triangulations (Liepa 2003; CGAL Polygon Mesh Processing).
 */
#include "cgal_surface.hpp"

#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>

namespace PMP = CGAL::Polygon_mesh_processing;
using namespace sinew;

namespace {

/* Above this many edges only the Delaunay search is tried: the full one takes time with the cube of the edges. */
constexpr sn_index CUBIC_LIMIT = 300;

sn_index cycle_length(const Surface &surface, Halfedge start) {
    sn_index length = 0;
    Halfedge h = start;
    do {
        length++;
        h = surface.next(h);
    } while (h != start);
    return length;
}

/* A border of three around one face alone: filling it would double the face. */
bool is_lone_face(const Surface &surface, Halfedge border) {
    return surface.face(surface.opposite(border)) == surface.face(surface.opposite(surface.next(border)));
}

/* True = the caller wants to stop. */
bool fill_cycle(Surface &surface, Halfedge border, sn_index max_edges, sn_bridge_hole_function filled, void *user) {
    sn_index edges = cycle_length(surface, border);
    if (edges > max_edges || (edges == 3 && is_lone_face(surface, border))) return false;
    std::vector<Face> patch;
    PMP::triangulate_hole(surface, border, std::back_inserter(patch),
                          CGAL::parameters::use_delaunay_triangulation(true).do_not_use_cubic_algorithm(edges > CUBIC_LIMIT));
    return !patch.empty() && filled != nullptr && filled(user, edges, sn_index(patch.size()));
}

} // namespace

sn_status sn_bridge_fill_holes(const sn_bridge_mesh *in, sn_index max_edges, sn_bridge_hole_function filled, void *user,
                               sn_bridge_mesh *out, sn_error *error) {
    return guarded("filling holes", error, [&] {
        Surface surface;
        to_surface(in, surface);
        std::vector<Halfedge> borders;
        PMP::extract_boundary_cycles(surface, std::back_inserter(borders));
        bool stopped = false;
        for (Halfedge border : borders) {
            stopped = fill_cycle(surface, border, max_edges, filled, user);
            if (stopped) break;
        }
        from_surface(surface, in, out);
        return stopped ? SN_STOPPED : SN_OK;
    });
}
