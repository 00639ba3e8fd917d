//! Vertices and triangles of a growing mesh, and the splitting that makes its count exact.
//!
//! A surface is added as quads. A quad becomes two triangles, or four around a vertex in its middle
//! that lies on the surface. The split quads are spread evenly, so the count is exact and the mesh
//! stays closed: a split quad keeps its four edges.

use geometry::DVec3;

/// Spreads `extra` splits evenly over `quads` quads.
#[derive(Clone, Copy, Debug)]
pub(super) struct Splits {
    quads: u64,
    extra: u64,
    seen: u64,
}

impl Splits {
    /// `extra` must be at most `quads`.
    pub(super) fn new(quads: u64, extra: u64) -> Self {
        Self { quads, extra, seen: 0 }
    }

    /// Whether the next quad is split.
    fn next(&mut self) -> bool {
        let before = self.seen * self.extra / self.quads;
        self.seen += 1;
        self.seen * self.extra / self.quads > before
    }
}

/// Vertices and triangles of all components so far.
#[derive(Debug)]
pub(super) struct Soup {
    /// Vertices (m).
    pub(super) vertices: Vec<DVec3>,
    /// Triangles: three vertices, counter-clockwise seen from outside.
    pub(super) triangles: Vec<[u32; 3]>,
    splits: Splits,
}

/// The quality of a triangle: 1 if equilateral, towards 0 for slivers; dimensionless.
fn shape(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let edges = ab.length_squared() + bc.length_squared() + ca.length_squared();
    if edges > 0.0 { ab.cross(ca).length() * 3.464_101_615_137_754_6 / edges } else { 0.0 }
}

impl Soup {
    /// Creates an empty soup.
    pub(super) fn new(splits: Splits) -> Self {
        Self { vertices: Vec::new(), triangles: Vec::new(), splits }
    }

    /// Adds a vertex and returns its number.
    pub(super) fn vertex(&mut self, point: DVec3) -> u32 {
        self.vertices.push(point);
        self.vertices.len() as u32 - 1
    }

    fn at(&self, vertex: u32) -> DVec3 {
        self.vertices[vertex as usize]
    }

    /// Adds a quad; `middle` gives the point of the surface in its middle, or `None` for the mean
    /// of the corners.
    pub(super) fn quad(&mut self, corners: [u32; 4], middle: impl FnOnce() -> Option<DVec3>) {
        let [a, b, c, d] = corners;
        let [pa, pb, pc, pd] = corners.map(|v| self.at(v));
        if self.splits.next() {
            let mean = || (pa + pb + pc + pd) * 0.25;
            let m = middle().unwrap_or_else(mean);
            let m = self.vertex(m);
            self.triangles.extend([[a, b, m], [b, c, m], [c, d, m], [d, a, m]]);
            return;
        }
        // The diagonal whose worse triangle is better: at the corner of a round cap only one of the
        // two avoids a sliver. The first wins ties, so flat quads are cut alike.
        let first = shape(pa, pb, pc).min(shape(pa, pc, pd));
        let second = shape(pb, pc, pd).min(shape(pb, pd, pa));
        if second > first + 1e-9 {
            self.triangles.extend([[b, c, d], [b, d, a]]);
        } else {
            self.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }

    /// Flips the triangles from number `first` on if they enclose a negative volume.
    pub(super) fn turn_outward(&mut self, first: usize) {
        let Some(origin) = self.triangles.get(first).map(|t| self.at(t[0])) else { return };
        let volume: f64 = self.triangles[first..]
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| self.at(v) - origin);
                a.dot(b.cross(c))
            })
            .sum();
        if volume < 0.0 {
            for triangle in &mut self.triangles[first..] {
                triangle.swap(1, 2);
            }
        }
    }
}
