/*
 * cgal_decimate.cpp -- quadric edge collapse (Garland, Heckbert 1997; CGAL Surface Mesh Simplification).
 */
/* gcc 12 takes the unset diagonal matrices of a fresh property map for a mistake */
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"

#include "cgal_surface.hpp"

#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_placement.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Constrained_placement.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

namespace SMS = CGAL::Surface_mesh_simplification;
using namespace sinew;

namespace {

/* Stops once at most `target` faces are left. */
struct Face_stop {
    std::size_t target;
    template <class Cost, class Profile> bool operator()(const Cost &, const Profile &profile, std::size_t, std::size_t) const {
        return profile.surface_mesh().number_of_faces() <= target;
    }
};

using Policies = SMS::GarlandHeckbert_plane_policies<Surface, Kernel>;
using Bounded = SMS::Bounded_normal_change_placement<Policies::Get_placement>;
using Is_held = Surface::Property_map<Surface::Edge_index, bool>;

void collapse_free(Surface &surface, const bool *held, const Face_stop &stop, Policies &policies) {
    Is_held kept = surface.add_property_map<Surface::Edge_index, bool>("e:held", false).first;
    for (Surface::Edge_index e : surface.edges()) kept[e] = held[surface.vertex(e, 0).idx()] || held[surface.vertex(e, 1).idx()];
    SMS::Constrained_placement<Bounded, Is_held> placement(kept, Bounded(policies.get_placement()));
    SMS::edge_collapse(surface, stop,
                       CGAL::parameters::edge_is_constrained_map(kept).get_cost(policies.get_cost()).get_placement(placement));
}

} // namespace

sn_status sn_bridge_decimate(const sn_bridge_mesh *in, sn_index target, bool bounded, const bool *held, sn_bridge_mesh *out,
                             sn_error *error) {
    return guarded("decimation", error, [&] {
        Surface surface;
        to_surface(in, surface);
        Policies policies(surface);
        Face_stop stop{std::size_t(target)};
        auto cost = CGAL::parameters::get_cost(policies.get_cost());
        if (bounded && held != nullptr)
            collapse_free(surface, held, stop, policies);
        else if (bounded)
            SMS::edge_collapse(surface, stop, cost.get_placement(Bounded(policies.get_placement())));
        else
            SMS::edge_collapse(surface, stop, cost.get_placement(policies.get_placement()));
        from_surface(surface, in, out);
        return SN_OK;
    });
}
