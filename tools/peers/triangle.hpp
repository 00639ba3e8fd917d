// Whether two closed triangles meet, in plain doubles: no error bounds, so a sign within rounding
// of zero may be wrong. For libraries that find candidate pairs and leave the test to their user.
//
// P. Guigue, O. Devillers, Fast and Robust Triangle-Triangle Overlap Test Using Orientation
// Predicates, Journal of Graphics Tools 8(1), 2003.
#pragma once

#include "case.hpp"

#include <cmath>

namespace peers {

inline int sign(double x) { return (x > 0) - (x < 0); }

// On which side of the plane of a, b, c the point d lies.
inline double side(const Point& a, const Point& b, const Point& c, const Point& d) {
    return dot(d - a, cross(b - a, c - a));
}

namespace flat {

struct Point2 {
    double x, y;
};

inline double turn(const Point2& a, const Point2& b, const Point2& c) {
    return (a.x - c.x) * (b.y - c.y) - (a.y - c.y) * (b.x - c.x);
}

// Whether c, known to be on the line of a and b, lies between them.
inline bool between(const Point2& a, const Point2& b, const Point2& c) {
    return std::min(a.x, b.x) <= c.x && c.x <= std::max(a.x, b.x) &&
           std::min(a.y, b.y) <= c.y && c.y <= std::max(a.y, b.y);
}

inline bool segments_meet(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
    int abc = sign(turn(a, b, c)), abd = sign(turn(a, b, d));
    int cda = sign(turn(c, d, a)), cdb = sign(turn(c, d, b));
    if (abc * abd < 0 && cda * cdb < 0) return true;
    return (abc == 0 && between(a, b, c)) || (abd == 0 && between(a, b, d)) ||
           (cda == 0 && between(c, d, a)) || (cdb == 0 && between(c, d, b));
}

inline bool inside(const Point2 (&t)[3], const Point2& p) {
    int s[3];
    for (int i = 0; i < 3; i++) s[i] = sign(turn(t[i], t[(i + 1) % 3], p));
    return (s[0] >= 0 && s[1] >= 0 && s[2] >= 0) || (s[0] <= 0 && s[1] <= 0 && s[2] <= 0);
}

// Two triangles in one plane with this normal: seen along the axis nearest to it.
inline bool meet(const Triangle& p, const Triangle& q, const Point& normal) {
    double x = std::fabs(normal.x), y = std::fabs(normal.y), z = std::fabs(normal.z);
    auto seen = [&](const Point& v) -> Point2 {
        if (x >= y && x >= z) return {v.y, v.z};
        return y >= z ? Point2{v.z, v.x} : Point2{v.x, v.y};
    };
    Point2 a[3], b[3];
    for (int i = 0; i < 3; i++) a[i] = seen(p[i]), b[i] = seen(q[i]);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            if (segments_meet(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3])) return true;
        }
    }
    return inside(a, b[0]) || inside(b, a[0]);
}

}  // namespace flat

// The corner that has one side of a plane to itself, and which side that is. The other two may lie
// in the plane; a corner in the plane counts as opposite to two that lie on one side.
struct Apex {
    int corner;
    bool above;

    static Apex of(const int (&s)[3]) {
        for (int i = 0; i < 3; i++) {
            int j = s[(i + 1) % 3], k = s[(i + 2) % 3];
            if (s[i] > 0 && j <= 0 && k <= 0) return {i, true};
            if (s[i] < 0 && j >= 0 && k >= 0) return {i, false};
        }
        int i = s[0] == 0 ? 0 : s[1] == 0 ? 1 : 2;
        return {i, s[(i + 1) % 3] < 0};
    }
};

inline bool meet(const Triangle& p, const Triangle& q) {
    auto apart = [](const int (&s)[3]) { return s[0] != 0 && s[0] == s[1] && s[0] == s[2]; };
    auto in_plane = [](const int (&s)[3]) { return s[0] == 0 && s[1] == 0 && s[2] == 0; };

    Point normal_q = cross(q[1] - q[0], q[2] - q[0]);
    int sides_p[3];
    for (int i = 0; i < 3; i++) sides_p[i] = sign(dot(normal_q, p[i] - q[0]));
    if (apart(sides_p)) return false;

    Point normal_p = cross(p[1] - p[0], p[2] - p[0]);
    int sides_q[3];
    for (int i = 0; i < 3; i++) sides_q[i] = sign(dot(normal_p, q[i] - p[0]));
    if (apart(sides_q)) return false;

    if (in_plane(sides_p)) return flat::meet(p, q, normal_q);
    if (in_plane(sides_q)) return flat::meet(p, q, normal_p);

    // Turned so that corner 0 is the apex, and mirrored so that it lies above the other's plane:
    // then the two intervals on the common line overlap unless one of these two signs is positive.
    Apex apex_p = Apex::of(sides_p), apex_q = Apex::of(sides_q);
    int i = apex_p.corner, j = apex_q.corner;
    const Point &p0 = p[i], &q0 = q[j];
    const Point *p1 = &p[(i + 1) % 3], *p2 = &p[(i + 2) % 3];
    const Point *q1 = &q[(j + 1) % 3], *q2 = &q[(j + 2) % 3];
    if (!apex_p.above) std::swap(q1, q2);
    if (!apex_q.above) std::swap(p1, p2);
    return side(p0, *p1, q0, *q1) <= 0 && side(p0, *p2, *q2, q0) <= 0;
}

}  // namespace peers
