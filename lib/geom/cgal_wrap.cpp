/*
 * cgal_wrap.cpp -- a closed manifold around any triangles, however broken (Portaneri et al. 2022, Alpha wrapping with an offset;
 * CGAL Alpha_wrap_3).
 */
#include "cgal_surface.hpp"

#include <array>

#include <CGAL/alpha_wrap_3.h>

using namespace sinew;

sn_status sn_bridge_wrap(const sn_bridge_mesh *in, double alpha, double offset, sn_bridge_mesh *out, sn_error *error) {
    return guarded("wrapping", error, [&] {
        std::vector<Point> points;
        std::vector<std::array<std::size_t, 3>> triangles;
        for (sn_index i = 0; i < in->vertex_count; i++) {
            const double *p = in->points + 3 * i;
            points.emplace_back(p[0], p[1], p[2]);
        }
        for (sn_index t = 0; t < in->triangle_count; t++) {
            const sn_index *v = in->triangles + 3 * t;
            triangles.push_back({std::size_t(v[0]), std::size_t(v[1]), std::size_t(v[2])});
        }
        Surface wrap;
        CGAL::alpha_wrap_3(points, triangles, alpha, offset, wrap);
        const sn_bridge_mesh nothing = {};
        from_surface(wrap, &nothing, out);
        return SN_OK;
    });
}
