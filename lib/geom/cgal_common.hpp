/*
 * cgal_common.hpp -- what the bridge's sources share: the guard against exceptions, and arrays in and out of a Surface_mesh.
 */
#ifndef SINEW_GEOM_CGAL_COMMON_HPP
#define SINEW_GEOM_CGAL_COMMON_HPP

#include <cstdlib>
#include <exception>
#include <new>

#include "cgal_bridge.h"

namespace sinew {

/* Run work(); whatever it throws becomes a status. */
template <class Work> sn_status guarded(const char *what, sn_error *error, Work work) noexcept {
    try {
        return work();
    } catch (const std::bad_alloc &) { return sn_fail_memory(error, what); } catch (const std::exception &exception) {
        return sn_fail(error, SN_ERROR_INTERNAL, "%s failed on this surface: %s", what, exception.what());
    } catch (...) { return sn_fail(error, SN_ERROR_INTERNAL, "%s failed on this surface", what); }
}

inline void free_mesh(sn_bridge_mesh *mesh) {
    std::free(mesh->points);
    std::free(mesh->triangles);
    std::free(mesh->vertex_origin);
    std::free(mesh->triangle_origin);
    *mesh = sn_bridge_mesh{};
}

/* Arrays for the counts; throws std::bad_alloc. */
inline void allocate_mesh(std::size_t vertices, std::size_t triangles, sn_bridge_mesh *out) {
    *out = sn_bridge_mesh{};
    if (vertices > SN_INDEX_MAX / 3 || triangles > SN_INDEX_MAX / 6) throw std::bad_alloc();
    out->points = static_cast<double *>(sn_alloc(vertices, 3 * sizeof(double)));
    out->triangles = static_cast<sn_index *>(sn_alloc(triangles, 3 * sizeof(sn_index)));
    out->vertex_origin = static_cast<sn_index *>(sn_alloc(vertices, sizeof(sn_index)));
    out->triangle_origin = static_cast<sn_index *>(sn_alloc(triangles, sizeof(sn_index)));
    if (!out->points || !out->triangles || !out->vertex_origin || !out->triangle_origin) {
        free_mesh(out);
        throw std::bad_alloc();
    }
    out->vertex_count = static_cast<sn_index>(vertices);
    out->triangle_count = static_cast<sn_index>(triangles);
}

} // namespace sinew
#endif
