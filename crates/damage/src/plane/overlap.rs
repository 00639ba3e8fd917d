//! The overlap of two outlines in plan: its chord, its centre, and the edges that bound it.

use super::CHORDS;
use super::footprint::PlacedBand;
use beside::{Beside, Neighbour};
use geometry::plan::distance_m;
use smallvec::SmallVec;

mod beside;

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
    /// Its area.
    pub(super) area_m2: f64,
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
        || edges(rings).any(|(_, edge)| distance_m(p, edge) <= near_m)
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

/// Whether two edges are, within rounding.
fn are_parallel(d: [f64; 2], e: [f64; 2]) -> bool {
    let (across, squares) = (cross(d, e), dot(d, d) * dot(e, e));
    // Most are far from it: then no root decides.
    let is_crossing = across * across > 1e-20 * squares || across.abs() > 1e-12 * squares.sqrt();
    !is_crossing
}

/// Where an edge `d` is crossed by an edge `e` that begins at `w` from its begin: as a share of it,
/// if that lies within.
fn crossing(d: [f64; 2], e: [f64; 2], w: [f64; 2]) -> Option<f64> {
    let (across, along) = (cross(d, e), cross(w, e));
    // The quotient would be 0 or less, or 1 or more: most edges end before.
    if along.abs() >= across.abs() || (along > 0.0) != (across > 0.0) {
        return None;
    }
    let (s, t) = (along / across, cross(w, d) / across);
    ((-1e-9..=1.0 + 1e-9).contains(&t) && s > 0.0 && s < 1.0).then_some(s)
}

/// An edge that may take part in an overlap.
#[derive(Clone, Copy)]
struct Edge {
    number: (usize, usize),
    ends: [[f64; 2]; 2],
    low: [f64; 2],
    high: [f64; 2],
}

/// The edges of one outline that lie beside an edge of the other: nothing else can cross it, or be
/// met by a ray along u from a point on it.
#[derive(Clone, Copy)]
struct Side<'e> {
    edges: &'e [Edge],
    beside: &'e [Neighbour],
    /// How far they have moved along u (m), and the depth at which they have.
    moved_m: f64,
    depth: usize,
    /// Whether all edges in this direction along u are there: what is inside is told by them.
    is_ahead: bool,
}

impl Edge {
    fn new(number: (usize, usize), ends: [[f64; 2]; 2]) -> Self {
        let [p, q] = ends;
        let low = [p[0].min(q[0]), p[1].min(q[1])];
        Self { number, ends, low, high: [p[0].max(q[0]), p[1].max(q[1])] }
    }

    /// All of it, inside of the other outline.
    fn whole(&self) -> Option<Piece> {
        let [from, q] = self.ends;
        let d = sub(q, from);
        let to = [from[0] + d[0], from[1] + d[1]];
        (from != to).then_some(Piece { from, to, place: Place::Inside })
    }

    fn moved(&self, by_m: f64) -> Self {
        let shift = |p: [f64; 2]| [p[0] + by_m, p[1]];
        let ends = self.ends.map(shift);
        Self { ends, low: shift(self.low), high: shift(self.high), ..*self }
    }
}

impl Side<'_> {
    /// How the middle of a piece lies to the outline.
    fn place(&self, piece: [[f64; 2]; 2]) -> Place {
        let middle =
            [0.5 * (piece[0][0] + piece[1][0]) - self.moved_m, 0.5 * (piece[0][1] + piece[1][1])];
        let way = sub(piece[1], piece[0]);
        let mut is_in = false;
        for neighbour in self.beside {
            let edge = &self.edges[usize::from(neighbour.number)];
            if edge.high[1] < middle[1] - SAME_M || edge.low[1] > middle[1] + SAME_M {
                continue;
            }
            let [a, b] = edge.ends;
            let is_near = edge.low[0] - SAME_M <= middle[0] && middle[0] <= edge.high[0] + SAME_M;
            if is_near {
                let other = sub(b, a);
                let (along, across) = (dot(way, other), cross(way, other));
                // Edges that only cross here are no coincidence.
                let is_parallel = across.abs() <= 1e-3 * along.abs();
                if is_parallel && distance_m(middle, edge.ends) <= SAME_M {
                    return if along > 0.0 { Place::SameWay } else { Place::OtherWay };
                }
            }
            // Even-odd, by a ray along u or against it.
            let is_left = (cross(sub(b, a), sub(middle, a)) > 0.0) == (b[1] > a[1]);
            is_in ^= (a[1] > middle[1]) != (b[1] > middle[1]) && is_left == self.is_ahead;
        }
        if is_in { Place::Inside } else { Place::Outside }
    }

    /// The pieces of an edge between its crossings with the outline.
    fn pieces(&self, edge: &Edge, found: &mut SmallVec<[Piece; 8]>) {
        let [p, q] = edge.ends;
        let d = sub(q, p);
        let mut cuts: SmallVec<[f64; 8]> = SmallVec::new();
        cuts.push(0.0);
        let square = dot(d, d);
        for neighbour in self.beside.iter().filter(|other| other.may_meet(self.depth)) {
            let other = &self.edges[usize::from(neighbour.number)];
            let is_apart = other.high[0] + self.moved_m < edge.low[0] - SAME_M
                || other.low[0] + self.moved_m > edge.high[0] + SAME_M;
            if is_apart {
                continue;
            }
            let [a, b] = other.ends.map(|end| [end[0] + self.moved_m, end[1]]);
            let e = sub(b, a);
            if !are_parallel(d, e) {
                cuts.extend(crossing(d, e, sub(a, p)));
            } else if square > 0.0 {
                // Parallel edges may coincide in part.
                for end in [a, b] {
                    let s = dot(sub(end, p), d) / square;
                    if s > 0.0 && s < 1.0 && distance_m(end, edge.ends) <= SAME_M {
                        cuts.push(s);
                    }
                }
            }
        }
        cuts.push(1.0);
        if cuts.len() > 2 {
            cuts.sort_by(f64::total_cmp);
        }
        for pair in cuts.windows(2) {
            let point = |s: f64| [p[0] + s * d[0], p[1] + s * d[1]];
            let (from, to) = (point(pair[0]), point(pair[1]));
            if from != to {
                found.push(Piece { from, to, place: self.place([from, to]) });
            }
        }
    }
}

/// Two outlines that face each other: the edges of either that the other may reach.
pub(super) struct Facing {
    edges: [Vec<Edge>; 2],
    /// For each edge of A, and each of B, which of the other's lie beside it.
    beside: [Beside; 2],
    slabs: [f64; 2],
    /// For each edge of A, and of B: its place among those that are struck, once it is.
    struck: [Vec<Option<u32>>; 2],
    /// By how much B comes nearer at most (m).
    most_m: f64,
    /// Where A's edges end along u, and where B's begin (m).
    last_of_a: f64,
    first_of_b: f64,
}

impl Facing {
    /// The edges that may take part while B comes nearer by up to a travel, in [`CHORDS`] steps;
    /// `None` if there are none.
    pub(super) fn of(a: &PlacedBand, b: &PlacedBand, most_m: f64) -> Option<Self> {
        let [low_a, high_a] = a.bounds;
        let [low_b, high_b] = b.bounds;
        let across = [low_a[1].max(low_b[1]) - SAME_M, high_a[1].min(high_b[1]) + SAME_M];
        let nearest = low_b[0] - most_m - SAME_M;
        let furthest = high_a[0] + most_m + SAME_M;
        if across[0] > across[1] || nearest > high_a[0] || furthest < low_b[0] {
            return None;
        }
        let all = |band: &PlacedBand, is_within: &dyn Fn(&Edge) -> bool| {
            let is_beside = |edge: &Edge| edge.high[1] >= across[0] && edge.low[1] <= across[1];
            let edges = edges(&band.rings).map(|(number, ends)| Edge::new(number, ends));
            let mut all = Vec::with_capacity(band.rings.iter().map(Vec::len).sum());
            all.extend(edges.filter(|edge| is_beside(edge) && is_within(edge)));
            all
        };
        let of_a = all(a, &|edge| edge.high[0] >= nearest);
        let of_b = all(b, &|edge| edge.low[0] <= furthest);
        let step_m = most_m / CHORDS as f64;
        let beside = [Beside::of(0, &of_a, &of_b, step_m), Beside::of(1, &of_b, &of_a, step_m)];
        let slabs = [a.height_m[0], b.height_m[0]];
        let struck = [&of_a, &of_b].map(|edges| vec![None; edges.len()]);
        let last_of_a = of_a.iter().map(|edge| edge.high[0]).fold(f64::NEG_INFINITY, f64::max);
        let first_of_b = of_b.iter().map(|edge| edge.low[0]).fold(f64::INFINITY, f64::min);
        Some(Self { edges: [of_a, of_b], beside, slabs, struck, most_m, last_of_a, first_of_b })
    }

    /// By how much B has come nearer at a depth (m).
    pub(super) fn travel_m(&self, depth: usize) -> f64 {
        self.most_m * (depth as f64 + 0.5) / CHORDS as f64
    }

    /// The overlap at a depth, below [`CHORDS`]; `None` if there is none. Adds to how much of each
    /// edge is struck; it is always the same list.
    pub(super) fn overlap(
        &mut self,
        depth: usize,
        struck: &mut [SmallVec<[Struck; 16]>; 2],
    ) -> Option<Overlap> {
        let travel_m = self.travel_m(depth);
        // Only between B's first edge and A's last one along u is there anything.
        let (low, high) = (self.first_of_b - travel_m - SAME_M, self.last_of_a + SAME_M);
        if low > high {
            return None;
        }
        let origin = [0.5 * (low + high), self.edges[0].first().map_or(0.0, |edge| edge.low[1])];
        let mut sums = Sums::at(origin);
        let mut found: SmallVec<[Piece; 8]> = SmallVec::new();
        let moves = [0.0, -travel_m];
        for side in 0..2 {
            let (own_moved_m, other) = (moves[side], &self.edges[1 - side]);
            for (number, edge) in self.edges[side].iter().enumerate() {
                let (beside, row) = self.beside[side].of_edge(number);
                let is_met = row.meets >> depth & 1 == 1;
                let is_away = edge.high[0] + own_moved_m < low || edge.low[0] + own_moved_m > high;
                if is_away || !is_met && row.is_inside >> depth & 1 == 0 {
                    continue;
                }
                let edge = edge.moved(own_moved_m);
                found.clear();
                if is_met {
                    let (moved_m, is_ahead) = (moves[1 - side], side == 1);
                    let other = Side { edges: other, beside, moved_m, depth, is_ahead };
                    other.pieces(&edge, &mut found);
                } else {
                    found.extend(edge.whole());
                }
                let mut inside = 0.0;
                for piece in &found {
                    let is_inside = piece.place == Place::Inside;
                    if !is_inside && (piece.place != Place::SameWay || side == 1) {
                        continue;
                    }
                    let way = sub(piece.to, piece.from);
                    let length = dot(way, way).sqrt();
                    if is_inside {
                        sums.add_normal(side, [way[1], -way[0]]);
                        inside += length;
                    }
                    sums.add_area([piece.from, piece.to], length);
                }
                if inside > 0.0 {
                    let (slab, struck) = (self.slabs[side], &mut struck[side]);
                    let place = *self.struck[side][number].get_or_insert_with(|| {
                        place_of(struck, (edge.number, slab), edge.moved(-own_moved_m).ends)
                    });
                    struck[place as usize].length += inside;
                }
            }
        }
        sums.overlap()
    }
}

/// The place of an edge, by its number and the height of its band, among those that are struck.
fn place_of(
    struck: &mut SmallVec<[Struck; 16]>,
    (edge, slab): ((usize, usize), f64),
    ends: [[f64; 2]; 2],
) -> u32 {
    let is_same = |s: &Struck| s.edge == edge && s.slab.to_bits() == slab.to_bits();
    let place = struck.iter().position(is_same).unwrap_or_else(|| {
        struck.push(Struck { edge, slab, ends, length: 0.0 });
        struck.len() - 1
    });
    place as u32
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

    /// Adds a piece of the border, and its length.
    fn add_area(&mut self, ends: [[f64; 2]; 2], length: f64) {
        let [p, q] = ends.map(|end| sub(end, self.origin));
        let twice = cross(p, q);
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
            area_m2: self.area.max(0.0),
        })
    }
}

#[cfg(test)]
mod tests;
