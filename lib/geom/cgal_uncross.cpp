/*
 * cgal_uncross.cpp -- removal of self-intersections by local remeshing, smoothing and filling (CGAL Polygon Mesh Processing, where it is
 * experimental: it may not come to an end, so intersections.c calls it in a child process).
 */
#include "cgal_surface.hpp"

#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>

namespace PMP = CGAL::Polygon_mesh_processing;
using namespace sinew;

sn_status sn_bridge_remove_intersections(const sn_bridge_mesh *in, sn_bridge_mesh *out, sn_error *error) {
    return guarded("removing self-intersections", error, [&] {
        Surface surface;
        to_surface(in, surface);
        PMP::experimental::remove_self_intersections(surface, CGAL::parameters::preserve_genus(false));
        surface.collect_garbage();
        const sn_bridge_mesh nothing = {};
        from_surface(surface, &nothing, out);
        return SN_OK;
    });
}
