/*
 * cgal_manifold.cpp -- orientation of a triangle soup, cutting where it is not manifold, stitching of coincident borders
 * (CGAL Polygon Mesh Processing).
 */
#include "cgal_surface.hpp"

#include <array>

#include <CGAL/Polygon_mesh_processing/manifoldness.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>

namespace PMP = CGAL::Polygon_mesh_processing;

using namespace sinew;

namespace {

using Triangle = std::array<std::size_t, 3>;

/* The soup, and for each of its points the input vertex that it is a copy of. */
struct Soup {
    std::vector<Point> points;
    std::vector<Triangle> triangles;
    std::vector<sn_index> origin;
};

struct Remember_origin : PMP::Default_orientation_visitor {
    std::vector<sn_index> *origin = nullptr;
    void duplicated_vertex(std::size_t old_vertex, std::size_t new_vertex) {
        if (origin->size() <= new_vertex) origin->resize(new_vertex + 1, SN_NONE);
        (*origin)[new_vertex] = (*origin)[old_vertex];
    }
};

Soup to_soup(const sn_bridge_mesh *in) {
    Soup soup;
    for (sn_index i = 0; i < in->vertex_count; i++) {
        const double *p = in->points + 3 * i;
        soup.points.emplace_back(p[0], p[1], p[2]);
        soup.origin.push_back(i);
    }
    for (sn_index t = 0; t < in->triangle_count; t++) {
        const sn_index *v = in->triangles + 3 * t;
        soup.triangles.push_back({std::size_t(v[0]), std::size_t(v[1]), std::size_t(v[2])});
    }
    return soup;
}

/* Vertices get the numbers of the soup's points. Adding face by face checks as it goes; CGAL's conversion of a soup as a whole checks
 * nothing, and the check before it takes as long as all the rest. */
void build_surface(const Soup &soup, Surface &surface) {
    surface.reserve(Surface::size_type(soup.points.size()), Surface::size_type(3 * soup.triangles.size()),
                    Surface::size_type(soup.triangles.size()));
    for (const Point &p : soup.points) surface.add_vertex(p);
    for (const Triangle &t : soup.triangles) {
        Face face = surface.add_face(Vertex(Surface::size_type(t[0])), Vertex(Surface::size_type(t[1])), Vertex(Surface::size_type(t[2])));
        if (face == Surface::null_face()) throw std::runtime_error("its triangles cannot be oriented");
    }
}

void from_stitched(const Surface &surface, const std::vector<sn_index> &origin, const sn_bridge_mesh *in, sn_bridge_mesh *out) {
    sinew::allocate_mesh(surface.number_of_vertices(), surface.number_of_faces(), out);
    std::vector<sn_index> place(surface.num_vertices(), SN_NONE);
    sn_index count = 0;
    for (Vertex v : surface.vertices()) {
        for (int k = 0; k < 3; k++) out->points[3 * count + k] = surface.point(v)[k];
        out->vertex_origin[count] = origin[v.idx()];
        place[v.idx()] = count++;
    }
    sn_index t = 0;
    for (Face face : surface.faces()) {
        Halfedge h = surface.halfedge(face);
        for (int turn = 0; turn < 3; turn++) { /* start where the triangle started, turned over or not */
            if (origin[surface.source(h).idx()] == in->triangles[3 * face.idx()]) break;
            h = surface.next(h);
        }
        for (int k = 0; k < 3; k++, h = surface.next(h)) out->triangles[3 * t + k] = place[surface.source(h).idx()];
        out->triangle_origin[t] = sn_index(face.idx());
        t++;
    }
}

} // namespace

sn_status sn_bridge_make_manifold(const sn_bridge_mesh *in, sn_bridge_mesh *out, sn_bridge_orientation *report, sn_error *error) {
    return guarded("making the surface a manifold", error, [&] {
        Soup soup = to_soup(in);
        Remember_origin visitor;
        visitor.origin = &soup.origin;
        PMP::orient_polygon_soup(soup.points, soup.triangles, CGAL::parameters::visitor(visitor));
        soup.origin.resize(soup.points.size(), SN_NONE);
        Surface surface;
        build_surface(soup, surface);
        report->stitched_edges = sn_index(PMP::stitch_borders(surface));
        std::vector<sn_index> origin = soup.origin; /* vertices of the soup keep their numbers in the surface */
        std::vector<std::vector<Vertex>> copies;
        PMP::duplicate_non_manifold_vertices(surface, CGAL::parameters::output_iterator(std::back_inserter(copies)));
        origin.resize(surface.num_vertices(), SN_NONE);
        for (const std::vector<Vertex> &same : copies) {
            for (Vertex copy : same) origin[copy.idx()] = origin[same.front().idx()];
        }
        from_stitched(surface, origin, in, out);
        report->split_vertices = out->vertex_count > in->vertex_count ? out->vertex_count - in->vertex_count : 0;
        return SN_OK;
    });
}
