//! Polygons to triangles, concave ones too.
//!
//! A polygon that its first corner sees whole is a fan, so that convex faces give the n − 2
//! triangles, in the order, that every other reader gives. Any other is cut by ears (crate
//! `earcut`) in the plane of the two axes that it fills most: a coordinate is dropped, nothing is
//! rotated, so nothing is rounded.

use earcut::Earcut;

/// Greatest number of corners of one polygon: cutting ears is quadratic at worst.
pub(super) const CORNERS_MAX: usize = 16_384;

/// Cuts polygons, one after the other, without allocating for each.
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

    /// Triangles as numbers of corners. At least 3 and at most [`CORNERS_MAX`] corners, all finite.
    ///
    /// A polygon without area gives its fan: it is the segment or point that it is.
    pub(super) fn cut(&mut self, corners: &[[f64; 3]]) -> &[[usize; 3]] {
        self.triangles.clear();
        self.flatten(corners);
        if corners.len() > 3 && !self.first_corner_sees_all() {
            self.earcut.earcut_slice(&self.flat, &[], &mut self.ears);
            let ears = self.ears.chunks_exact(3);
            self.triangles.extend(ears.map(|t| [t[0] as usize, t[1] as usize, t[2] as usize]));
        }
        if self.triangles.is_empty() {
            self.triangles.extend((2..corners.len()).map(|i| [0, i - 1, i]));
        }
        &self.triangles
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

    /// Whether the fan from corner 0 covers the polygon without overlap: its triangles all turn the
    /// same way and lie within half a turn round corner 0.
    fn first_corner_sees_all(&self) -> bool {
        let [a, b] = [self.flat[0], self.flat[1]];
        let turn = |p: [f64; 2], q: [f64; 2]| {
            (p[0] - a[0]) * (q[1] - a[1]) - (p[1] - a[1]) * (q[0] - a[0])
        };
        self.flat[1..]
            .windows(2)
            .all(|pair| turn(pair[0], pair[1]) >= 0.0 && turn(b, pair[1]) >= 0.0)
    }
}

#[cfg(test)]
mod tests;
