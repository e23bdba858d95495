/*
 * cgal_intersections.cpp -- pairs of triangles that cross: boxes sorted out by CGAL's box intersection, then exact predicates.
 */
#include "cgal_common.hpp"

#include <vector>

#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

using namespace sinew;

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, sn_index, CGAL::Box_intersection_d::ID_FROM_BOX_ADDRESS>;

struct Soup {
    const sn_bridge_mesh *mesh;
    const sn_index *corners(sn_index t) const { return mesh->triangles + 3 * t; }
    Point point(sn_index v) const {
        const double *p = mesh->points + 3 * v;
        return Point(p[0], p[1], p[2]);
    }
    Kernel::Triangle_3 triangle(sn_index t) const {
        const sn_index *v = corners(t);
        return Kernel::Triangle_3(point(v[0]), point(v[1]), point(v[2]));
    }
};

/* Which corners of t are corners of other; bits 0..2. */
unsigned shared_corners(const sn_index *t, const sn_index *other) {
    unsigned shared = 0;
    for (unsigned k = 0; k < 3; k++) {
        if (t[k] == other[0] || t[k] == other[1] || t[k] == other[2]) shared |= 1u << k;
    }
    return shared;
}

/* Two triangles on a common edge cross only where they are coplanar and on the same side of it: one folded onto the other. */
bool folded(const Soup &soup, const sn_index *a, const sn_index *b, unsigned shared) {
    int free_corner = shared == 3u ? 2 : shared == 5u ? 1 : 0;
    Point p = soup.point(a[(free_corner + 1) % 3]), q = soup.point(a[(free_corner + 2) % 3]), r = soup.point(a[free_corner]);
    for (int k = 0; k < 3; k++) {
        if (b[k] == a[0] || b[k] == a[1] || b[k] == a[2]) continue;
        Point s = soup.point(b[k]);
        return CGAL::coplanar(p, q, r, s) && CGAL::coplanar_orientation(p, q, r, s) == CGAL::POSITIVE;
    }
    return true; /* all corners shared */
}

/* Two triangles with one common corner cross where the edge opposite to it in one meets the other. */
bool crossed_at_corner(const Soup &soup, sn_index t, sn_index other, unsigned shared) {
    const sn_index *v = soup.corners(t);
    int corner = shared == 1u ? 0 : shared == 2u ? 1 : 2;
    Kernel::Segment_3 opposite(soup.point(v[(corner + 1) % 3]), soup.point(v[(corner + 2) % 3]));
    return CGAL::do_intersect(opposite, soup.triangle(other));
}

bool crosses(const Soup &soup, sn_index a, sn_index b) {
    const sn_index *va = soup.corners(a), *vb = soup.corners(b);
    unsigned shared = shared_corners(va, vb);
    if (shared == 0) return CGAL::do_intersect(soup.triangle(a), soup.triangle(b));
    bool one = (shared & (shared - 1)) == 0;
    if (!one) return folded(soup, va, vb, shared);
    return crossed_at_corner(soup, a, b, shared) || crossed_at_corner(soup, b, a, shared_corners(vb, va));
}

/* Triangles without area have no inside to cross, and are counted elsewhere. */
std::vector<Box> boxes_of(const Soup &soup) {
    std::vector<Box> boxes;
    for (sn_index t = 0; t < soup.mesh->triangle_count; t++) {
        Kernel::Triangle_3 triangle = soup.triangle(t);
        if (!triangle.is_degenerate()) boxes.emplace_back(triangle.bbox(), t);
    }
    return boxes;
}

/* Thrown to end a search that takes too long. */
struct Too_many {};

} // namespace

sn_status sn_bridge_find_intersections(const sn_bridge_mesh *in, int64_t most_tests, const bool *made, bool *crosses_other, sn_index *pairs,
                                       sn_error *error) {
    return guarded("counting self-intersections", error, [&] {
        Soup soup{in};
        std::vector<Box> boxes = boxes_of(soup);
        std::vector<const Box *> pointers;
        for (const Box &box : boxes) pointers.push_back(&box);
        int64_t count = 0, tests = 0;
        auto test = [&](const Box *a, const Box *b) {
            if (most_tests > 0 && ++tests > most_tests) throw Too_many();
            if (!crosses(soup, a->info(), b->info())) return;
            count++;
            if (crosses_other != nullptr && (made == nullptr || made[a->info()] || made[b->info()]))
                crosses_other[a->info()] = crosses_other[b->info()] = true;
        };
        try {
            CGAL::box_self_intersection_d(pointers.begin(), pointers.end(), test, std::ptrdiff_t(2000));
            *pairs = count > SN_INDEX_MAX ? SN_INDEX_MAX : sn_index(count);
        } catch (const Too_many &) { *pairs = SN_NONE; }
        return SN_OK;
    });
}
