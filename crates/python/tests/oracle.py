"""Exact intersection of two closed triangles, in whole and rational numbers, without any tree."""

from fractions import Fraction
from itertools import combinations

import numpy


def _minus(p, q):
    return [x - y for x, y in zip(p, q)]


def _dot(p, q):
    return sum(x * y for x, y in zip(p, q))


def _cross(p, q):
    return [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]


def _on_segment(x, p, q):
    d, e = _minus(q, p), _minus(x, p)
    if not any(d):
        return not any(e)
    return not any(_cross(d, e)) and 0 <= _dot(d, e) <= _dot(d, d)


def _segments_meet(p, q, r, s):
    """Whether two segments, of which either may be a point, have a point in common."""
    if any(_on_segment(x, r, s) for x in (p, q)) or any(_on_segment(x, p, q) for x in (r, s)):
        return True
    d, e, w = _minus(q, p), _minus(s, r), _minus(r, p)
    n = _cross(d, e)
    if not any(n) or _dot(n, w) != 0:
        return False
    t = Fraction(_dot(_cross(w, e), n), _dot(n, n))
    u = Fraction(_dot(_cross(w, d), n), _dot(n, n))
    return 0 <= t <= 1 and 0 <= u <= 1


def _in_triangle(x, triangle, n):
    """Whether a point of its plane lies in a triangle of normal n."""
    a, b, c = triangle
    sides = [_dot(n, _cross(_minus(q, p), _minus(x, p))) for p, q in ((a, b), (b, c), (c, a))]
    return all(side >= 0 for side in sides)


def _segment_meets(p, q, triangle):
    a, b, c = triangle
    n = _cross(_minus(b, a), _minus(c, a))
    edges = list(combinations(triangle, 2))
    if not any(n):
        return any(_segments_meet(p, q, r, s) for r, s in edges)
    dp, dq = _dot(n, _minus(p, a)), _dot(n, _minus(q, a))
    if dp * dq > 0:
        return False
    if dp == dq == 0:
        inside = _in_triangle(p, triangle, n) or _in_triangle(q, triangle, n)
        return inside or any(_segments_meet(p, q, r, s) for r, s in edges)
    t = Fraction(dp, dp - dq)
    return _in_triangle([x + t * (y - x) for x, y in zip(p, q)], triangle, n)


def _whole(triangles):
    """Coordinates as whole numbers of their common unit, a power of two."""
    ratios = [[[float(x).as_integer_ratio() for x in corner] for corner in t] for t in triangles]
    unit = max(below for triangle in ratios for corner in triangle for _, below in corner)
    return [[[above * (unit // below) for above, below in p] for p in t] for t in ratios]


def _on_one_side(triangle, other):
    """Whether a triangle lies strictly on one side of the plane of another."""
    a, b, c = other
    n = _cross(_minus(b, a), _minus(c, a))
    sides = [_dot(n, _minus(p, a)) for p in triangle]
    return all(side > 0 for side in sides) or all(side < 0 for side in sides)


def intersect(a, b):
    """Whether two triangles of float64 corners have a point in common."""
    a, b = _whole((a, b))
    if _on_one_side(a, b) or _on_one_side(b, a):
        return False
    for axis in range(3):
        if max(p[axis] for p in a) < min(p[axis] for p in b):
            return False
        if max(p[axis] for p in b) < min(p[axis] for p in a):
            return False
    return any(_segment_meets(p, q, b) for p, q in combinations(a, 2)) or any(
        _segment_meets(p, q, a) for p, q in combinations(b, 2)
    )


def transformed(triangles, pose):
    """Corners of B in A's frame, as the library defines them: ((R0 x + R1 y) + R2 z) + t."""
    x, y, z = (triangles[..., i].astype(float) for i in range(3))
    rows = [((r[0] * x + r[1] * y) + r[2] * z) + r[3] for r in pose[:3]]
    return numpy.stack(rows, axis=-1)


def pairs(a, b, pose, every=1):
    """All pairs of intersecting triangles of two bodies, of A's numbers 0, `every`, 2 `every`, …

    Each is compared with each: those whose boxes are apart are left out by a comparison of
    coordinates, which is exact.
    """
    moved = transformed(b, pose)
    low, high = moved.min(axis=1), moved.max(axis=1)
    found = []
    for i in range(0, len(a), every):
        p = a[i]
        meet = (p.min(axis=0) <= high).all(axis=1) & (low <= p.max(axis=0)).all(axis=1)
        found += [[i, int(j)] for j in numpy.flatnonzero(meet) if intersect(p, moved[j])]
    return found
