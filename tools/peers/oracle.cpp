// The exact answer, by CGAL: box_intersection_d finds the pairs of triangles whose boxes overlap,
// exact predicates decide them. Closed triangles; a degenerate one is the segment or point that it
// is. It has no tree: build_ms is making boxes and triangles of both bodies, for this pose. It is
// asked once, whatever the options say: that takes seconds on large bodies.
//
// Beside the pairs it says which triangles they touch: their numbers, and the wrapping sums of
// splitmix64 over them.
#include "case.hpp"

#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>

#include <variant>

namespace {

using namespace peers;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Solid = Kernel::Triangle_3;
using Segment = Kernel::Segment_3;
using Dot = Kernel::Point_3;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, uint32_t>;

// What a degenerate triangle is.
std::variant<Dot, Segment, Solid> shape_of(const Solid& t) {
    if (!t.is_degenerate()) return t;
    auto [low, high] = std::minmax({t[0], t[1], t[2]}, [](const Dot& p, const Dot& q) {
        return CGAL::lexicographically_xyz_smaller(p, q);
    });
    if (low == high) return low;
    return Segment(low, high);
}

struct Meet {
    bool operator()(const Dot& p, const Dot& q) const { return p == q; }
    bool operator()(const Dot& p, const Segment& s) const { return s.has_on(p); }
    bool operator()(const Dot& p, const Solid& t) const { return t.has_on(p); }
    bool operator()(const Segment& s, const Segment& t) const { return CGAL::do_intersect(s, t); }
    bool operator()(const Segment& s, const Solid& t) const { return CGAL::do_intersect(s, t); }
    bool operator()(const Solid& t, const Solid& u) const { return CGAL::do_intersect(t, u); }
    template <class Larger, class Smaller>
    bool operator()(const Larger& large, const Smaller& small) const {
        return (*this)(small, large);
    }
};

struct Body {
    std::vector<Solid> triangles;
    std::vector<bool> degenerate;
    std::vector<Box> boxes;

    Body(const Mesh& mesh, const std::vector<Point>& points) {
        auto dot = [&](uint32_t i) { return Dot(points[i].x, points[i].y, points[i].z); };
        for (const auto& t : mesh.triangles) {
            triangles.emplace_back(dot(t[0]), dot(t[1]), dot(t[2]));
            degenerate.push_back(triangles.back().is_degenerate());
            boxes.emplace_back(triangles.back().bbox(), uint32_t(boxes.size()));
        }
    }
};

bool meet(const Body& a, uint32_t i, const Body& b, uint32_t j) {
    const Solid &t = a.triangles[i], &u = b.triangles[j];
    if (!a.degenerate[i] && !b.degenerate[j]) return CGAL::do_intersect(t, u);
    return std::visit(Meet(), shape_of(t), shape_of(u));
}

// How many triangles of one body are in `hit`, and the hash of their numbers, as JSON fields.
std::string set_fields(const char* body, const std::vector<bool>& hit) {
    uint64_t count = 0, sum = 0;
    for (uint32_t i = 0; i < hit.size(); i++) {
        if (hit[i]) count++, sum += splitmix64(i);
    }
    char text[96];
    std::snprintf(text, sizeof text, ",\"hits_%s\":%llu,\"hash_%s\":\"%016llx\"", body,
                  (unsigned long long)count, body, (unsigned long long)sum);
    return text;
}

Result drive(const Case& c, const Options&) {
    Result result{"cgal"};
    double start = now_ms();
    Body a(c.a, c.a.points), b(c.b, c.placed_b());
    result.build_ms = now_ms() - start;

    start = now_ms();
    CGAL::box_intersection_d(a.boxes.begin(), a.boxes.end(), b.boxes.begin(), b.boxes.end(),
                             [&](const Box& box_a, const Box& box_b) {
                                 uint32_t i = box_a.info(), j = box_b.info();
                                 result.np++;
                                 if (meet(a, i, b, j)) result.pairs.emplace_back(i, j);
                             });
    result.times.query_ms = now_ms() - start;

    std::vector<bool> hit_a(c.a.triangles.size()), hit_b(c.b.triangles.size());
    for (auto [i, j] : result.pairs) hit_a[i] = hit_b[j] = true;
    result.more = set_fields("a", hit_a) + set_fields("b", hit_b);
    return result;
}

}  // namespace

int main(int count, char** words) { return peers::run(count, words, drive); }
