//! Triangulates polygons, including concave ones.
//!
//! If a polygon is entirely visible from a corner, it becomes the fan from the first such corner:
//! so convex faces give the same n − 2 triangles, in the same order, as in every other reader. Any
//! other polygon is cut by ears (crate `earcut`) in the plane of the two axes in which it is
//! largest: a coordinate is dropped and nothing is rotated, so nothing is rounded.

use earcut::Earcut;

/// Maximum number of corners of one polygon: ear cutting is quadratic at worst.
pub(super) const CORNERS_MAX: usize = 16_384;

/// Polygons with at most this many corners are tried as a fan from each: the trial is quadratic.
const HUBS_MAX: usize = 8;

/// Triangulates polygons one after the other, without allocating for each.
pub(super) struct Triangulator {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    ears: Vec<u32>,
    triangles: Vec<[usize; 3]>,
}

impl Triangulator {
    pub(super) fn new() -> Self {
        Self { earcut: Earcut::new(), flat: Vec::new(), ears: Vec::new(), triangles: Vec::new() }
    }

    /// Returns triangles as indices of corners. Requires 3 to [`CORNERS_MAX`] corners, all finite.
    ///
    /// A polygon without area, or one that crosses itself so that ears do not cover it, gives the
    /// fan from corner 0, so nothing is lost: every corner is one of a triangle, or lies on a side
    /// of one.
    pub(super) fn cut(&mut self, corners: &[[f64; 3]]) -> &[[usize; 3]] {
        self.triangles.clear();
        self.flatten(corners);
        let count = corners.len();
        let hubs = if count <= HUBS_MAX { count } else { 1 };
        if let Some(hub) = (0..hubs).find(|hub| self.sees_all(*hub)) {
            self.fan(hub, count);
            return &self.triangles;
        }
        self.earcut.earcut_slice(&self.flat, &[], &mut self.ears);
        let ears = self.ears.chunks_exact(3);
        self.triangles.extend(ears.map(|t| [t[0] as usize, t[1] as usize, t[2] as usize]));
        let covered: f64 = self.triangles.iter().map(|t| self.turn(*t).abs()).sum();
        let whole: f64 = (2..count).map(|i| self.turn([0, i - 1, i])).sum();
        // Sums of rounded areas: a missing ear differs by far more.
        if (covered - whole.abs()).abs() > 1e-6 * covered {
            self.triangles.clear();
            self.fan(0, count);
        }
        self.keep_all(corners);
        &self.triangles
    }

    /// Adds a triangle for each corner that no ear has and that lies on no side of one: ears leave
    /// out the tip of a spike, and loops of equal area the other way round.
    fn keep_all(&mut self, corners: &[[f64; 3]]) {
        let count = corners.len();
        let mut is_kept = vec![false; count];
        self.triangles.iter().flatten().for_each(|corner| is_kept[*corner] = true);
        for at in (0..count).filter(|at| !is_kept[*at]) {
            let sides = |t: &[usize; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
            let is_on = |side: [usize; 2]| is_between(corners[at], side.map(|end| corners[end]));
            if self.triangles.iter().flat_map(sides).any(is_on) {
                continue;
            }
            // Corners in one place have the same neighbours.
            let elsewhere = |other: &usize| corners[*other] != corners[at];
            let before = (1..count).map(|steps| (at + count - steps) % count).find(elsewhere);
            let after = (1..count).map(|steps| (at + steps) % count).find(elsewhere);
            if let Some((before, after)) = before.zip(after) {
                self.triangles.push([before, at, after]);
            }
        }
    }

    fn fan(&mut self, hub: usize, count: usize) {
        let after = |steps: usize| (hub + steps) % count;
        self.triangles.extend((2..count).map(|i| [hub, after(i - 1), after(i)]));
    }

    /// Drops the coordinate along which the polygon's normal (Newell's) is greatest.
    fn flatten(&mut self, corners: &[[f64; 3]]) {
        let mut normal = [0.0_f64; 3];
        let next = corners.iter().cycle().skip(1);
        for (a, b) in corners.iter().zip(next) {
            for (axis, sum) in normal.iter_mut().enumerate() {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                *sum += (a[u] - b[u]) * (a[v] + b[v]);
            }
        }
        // Newell: n_x = Σ (a_y − b_y)(a_z + b_z), and cyclically; the sign is that of the ring.
        let mut drop = 0;
        for axis in 1..3 {
            if normal[axis].abs() > normal[drop].abs() {
                drop = axis;
            }
        }
        let (mut u, mut v) = ((drop + 1) % 3, (drop + 2) % 3);
        if normal[drop] < 0.0 {
            core::mem::swap(&mut u, &mut v);
        }
        self.flat.clear();
        self.flat.extend(corners.iter().map(|corner| [corner[u], corner[v]]));
    }

    /// Twice the signed area of a flat triangle.
    fn turn(&self, corners: [usize; 3]) -> f64 {
        let [a, p, q] = corners.map(|corner| self.flat[corner]);
        (p[0] - a[0]) * (q[1] - a[1]) - (p[1] - a[1]) * (q[0] - a[0])
    }

    /// Whether the fan from a corner covers the polygon without overlap: its triangles all have the
    /// same orientation and lie within half a turn around that corner.
    fn sees_all(&self, hub: usize) -> bool {
        let count = self.flat.len();
        let after = |steps: usize| (hub + steps) % count;
        (2..count).all(|i| {
            self.turn([hub, after(i - 1), after(i)]) >= 0.0
                && self.turn([hub, after(1), after(i)]) >= 0.0
        })
    }
}

/// Whether a point lies on the segment between two others, but for rounding.
fn is_between(point: [f64; 3], [a, b]: [[f64; 3]; 2]) -> bool {
    let minus = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let (along, to) = (minus(b, a), minus(point, a));
    let length2 = dot(along, along);
    let share = if length2 > 0.0 { (dot(to, along) / length2).clamp(0.0, 1.0) } else { 0.0 };
    let off = minus(to, along.map(|x| x * share));
    // Stored positions are f32.
    dot(off, off) <= 1e-12 * length2
}

#[cfg(test)]
mod tests;
