//! The overlap of two outlines in plan: its chord, its centre, and the edges that bound it.

use super::Slab;
use smallvec::SmallVec;

/// Edges nearer than this (m) coincide.
const SAME_M: f64 = 1e-7;

/// An edge of an outline that lies inside of the other body at some depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Struck {
    /// Its number in its outline.
    edge: (usize, usize),
    /// Height of its slab, to tell slabs apart.
    slab: f64,
    /// Its ends at first contact.
    pub(super) ends: [[f64; 2]; 2],
    /// How much of it lies inside, summed over depths (m).
    pub(super) length: f64,
}

/// The overlap of two outlines.
pub(super) struct Overlap {
    /// The integral of the normal of the outline of A inside B, or of the negative one of B inside
    /// A, along u and to its left (m): the chord between the crossings, turned to point from A to
    /// B.
    pub(super) chord: [f64; 2],
    /// Its centroid (m), A's frame.
    pub(super) centre: [f64; 2],
}

type Ring = [[f64; 2]];

/// A piece of an edge, and how it lies to the other outline.
struct Piece {
    from: [f64; 2],
    to: [f64; 2],
    place: Place,
}

#[derive(Clone, Copy, PartialEq)]
enum Place {
    Inside,
    Outside,
    /// On an edge of the other outline that runs the same way.
    SameWay,
    /// On an edge that runs the other way.
    OtherWay,
}

/// Edges of rings, each with the numbers of its ring and of itself.
fn edges(rings: &[Vec<[f64; 2]>]) -> impl Iterator<Item = ((usize, usize), [[f64; 2]; 2])> {
    rings.iter().enumerate().flat_map(|(r, ring)| {
        (0..ring.len()).map(move |k| ((r, k), [ring[k], ring[(k + 1) % ring.len()]]))
    })
}

fn sub(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Whether a point lies in rings or within a distance of them (m).
pub(super) fn holds(rings: &[Vec<[f64; 2]>], p: [f64; 2], near_m: f64) -> bool {
    rings.iter().any(|ring| winds(ring, p))
        || edges(rings).any(|(_, [a, b])| distance(p, a, b) <= near_m)
}

/// Even-odd test.
fn winds(ring: &Ring, p: [f64; 2]) -> bool {
    let mut is_in = false;
    for (k, a) in ring.iter().enumerate() {
        let b = ring[(k + 1) % ring.len()];
        if (a[1] > p[1]) != (b[1] > p[1]) && (cross(sub(b, *a), sub(p, *a)) > 0.0) == (b[1] > a[1])
        {
            is_in = !is_in;
        }
    }
    is_in
}

/// Distance of a point from a segment.
fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (d, w) = (sub(b, a), sub(p, a));
    let square = dot(d, d);
    let along = if square > 0.0 { (dot(w, d) / square).clamp(0.0, 1.0) } else { 0.0 };
    let off = [w[0] - along * d[0], w[1] - along * d[1]];
    dot(off, off).sqrt()
}

/// How the middle of a piece lies to rings.
fn place(piece: [[f64; 2]; 2], rings: &[Vec<[f64; 2]>]) -> Place {
    let middle = [0, 1].map(|axis| 0.5 * (piece[0][axis] + piece[1][axis]));
    let way = sub(piece[1], piece[0]);
    for (_, [a, b]) in edges(rings) {
        let is_near = (0..2).all(|axis| {
            a[axis].min(b[axis]) - SAME_M <= middle[axis]
                && middle[axis] <= a[axis].max(b[axis]) + SAME_M
        });
        if is_near && distance(middle, a, b) <= SAME_M {
            let other = sub(b, a);
            let (along, across) = (dot(way, other), cross(way, other));
            // Edges that only cross here are no coincidence.
            if across.abs() <= 1e-3 * along.abs() {
                return if along > 0.0 { Place::SameWay } else { Place::OtherWay };
            }
        }
    }
    if rings.iter().any(|ring| winds(ring, middle)) { Place::Inside } else { Place::Outside }
}

/// The pieces of an edge between its crossings with rings.
fn pieces([p, q]: [[f64; 2]; 2], rings: &[Vec<[f64; 2]>], found: &mut SmallVec<[Piece; 8]>) {
    let d = sub(q, p);
    let mut cuts: SmallVec<[f64; 8]> = SmallVec::new();
    cuts.push(0.0);
    let (low, high) = ([p[0].min(q[0]), p[1].min(q[1])], [p[0].max(q[0]), p[1].max(q[1])]);
    let square = dot(d, d);
    for (_, [a, b]) in edges(rings) {
        let is_apart = (0..2).any(|axis| {
            a[axis].max(b[axis]) < low[axis] - SAME_M || a[axis].min(b[axis]) > high[axis] + SAME_M
        });
        if is_apart {
            continue;
        }
        let e = sub(b, a);
        let across = cross(d, e);
        let parallel = 1e-12 * (square * dot(e, e)).sqrt();
        if across.abs() > parallel {
            let w = sub(a, p);
            let (s, t) = (cross(w, e) / across, cross(w, d) / across);
            if (-1e-9..=1.0 + 1e-9).contains(&t) && s > 0.0 && s < 1.0 {
                cuts.push(s);
            }
        } else if square > 0.0 {
            // Parallel edges may coincide in part.
            for end in [a, b] {
                let s = dot(sub(end, p), d) / square;
                if s > 0.0 && s < 1.0 && distance(end, p, q) <= SAME_M {
                    cuts.push(s);
                }
            }
        }
    }
    cuts.push(1.0);
    cuts.sort_by(f64::total_cmp);
    for pair in cuts.windows(2) {
        let at = |s: f64| [p[0] + s * d[0], p[1] + s * d[1]];
        let (from, to) = (at(pair[0]), at(pair[1]));
        if from != to {
            found.push(Piece { from, to, place: place([from, to], rings) });
        }
    }
}

impl Overlap {
    /// The overlap of two outlines after B has come nearer by a travel; `None` if there is none.
    pub(super) fn of(
        a: &Slab,
        b: &Slab,
        travel_m: f64,
        struck: &mut [SmallVec<[Struck; 16]>; 2],
    ) -> Option<Self> {
        let box_b = b.bounds.map(|p| [p[0] - travel_m, p[1]]);
        let low = [0, 1].map(|k| a.bounds[0][k].max(box_b[0][k]) - SAME_M);
        let high = [0, 1].map(|k| a.bounds[1][k].min(box_b[1][k]) + SAME_M);
        if low[0] > high[0] || low[1] > high[1] {
            return None;
        }
        let moved = |p: &[f64; 2]| [p[0] - travel_m, p[1]];
        let rings_b: Vec<Vec<[f64; 2]>> =
            b.rings.iter().map(|ring| ring.iter().map(moved).collect()).collect();
        let mut sums = Sums::at([0, 1].map(|k| 0.5 * (low[k] + high[k])));
        let mut found: SmallVec<[Piece; 8]> = SmallVec::new();
        for (side, (rings, others)) in
            [(&a.rings, &rings_b), (&rings_b, &a.rings)].into_iter().enumerate()
        {
            let slab = [a, b][side].height_m[0];
            for (number, edge) in edges(rings) {
                let is_near = (0..2).all(|k| {
                    edge[0][k].max(edge[1][k]) >= low[k] && edge[0][k].min(edge[1][k]) <= high[k]
                });
                if !is_near {
                    continue;
                }
                found.clear();
                pieces(edge, others, &mut found);
                let mut inside = 0.0;
                for piece in &found {
                    let way = sub(piece.to, piece.from);
                    let normal = [way[1], -way[0]];
                    let bounds = match piece.place {
                        Place::Inside => {
                            sums.add_normal(side, normal);
                            inside += dot(way, way).sqrt();
                            true
                        }
                        Place::SameWay => side == 0,
                        Place::Outside | Place::OtherWay => false,
                    };
                    if bounds {
                        sums.add_area(piece.from, piece.to);
                    }
                }
                if inside > 0.0 {
                    note(&mut struck[side], number, slab, (edge, side, travel_m), inside);
                }
            }
        }
        sums.overlap()
    }
}

/// Adds to how much of an edge is struck.
fn note(
    struck: &mut SmallVec<[Struck; 16]>,
    edge: (usize, usize),
    slab: f64,
    (ends, side, travel_m): ([[f64; 2]; 2], usize, f64),
    length: f64,
) {
    let is_same = |s: &&mut Struck| s.edge == edge && s.slab.to_bits() == slab.to_bits();
    match struck.iter_mut().find(is_same) {
        Some(known) => known.length += length,
        None => {
            let back = if side == 1 { travel_m } else { 0.0 };
            let ends = ends.map(|[x, y]| [x + back, y]);
            struck.push(Struck { edge, slab, ends, length });
        }
    }
}

/// Integrals along the border of an overlap, about a point near it.
struct Sums {
    origin: [f64; 2],
    normals: [[f64; 2]; 2],
    area: f64,
    moment: [f64; 2],
    length: f64,
    middle: [f64; 2],
}

impl Sums {
    fn at(origin: [f64; 2]) -> Self {
        let zero = [0.0; 2];
        Self { origin, normals: [zero; 2], area: 0.0, moment: zero, length: 0.0, middle: zero }
    }

    fn add_normal(&mut self, side: usize, normal: [f64; 2]) {
        for (sum, more) in self.normals[side].iter_mut().zip(normal) {
            *sum += more;
        }
    }

    fn add_area(&mut self, from: [f64; 2], to: [f64; 2]) {
        let (p, q) = (sub(from, self.origin), sub(to, self.origin));
        let twice = cross(p, q);
        let way = sub(q, p);
        let length = dot(way, way).sqrt();
        self.area += 0.5 * twice;
        self.length += length;
        for axis in 0..2 {
            self.moment[axis] += twice * (p[axis] + q[axis]) / 6.0;
            self.middle[axis] += length * 0.5 * (p[axis] + q[axis]);
        }
    }

    fn overlap(&self) -> Option<Overlap> {
        if !(self.length > 0.0) {
            return None;
        }
        // A sliver's area is rounding; the middle of its border is not.
        let centre = if self.area > 1e-9 * self.length {
            self.moment.map(|m| m / self.area)
        } else {
            self.middle.map(|m| m / self.length)
        };
        Some(Overlap {
            chord: [0, 1].map(|k| 0.5 * (self.normals[0][k] - self.normals[1][k])),
            centre: [0, 1].map(|k| self.origin[k] + centre[k]),
        })
    }
}
