//! Closed components: a tube with two caps, a torus, or a pad that lies on another surface.
//!
//! None has a pole: a cap is a grid whose rim is the tube's last ring, so no vertex collects
//! slivers, at any fineness. Invariant: every edge of a component is shared by exactly two of its
//! triangles, in opposite directions.

use super::net::Net;
use super::ruler::{Along, Ruler, stretch};
use super::soup::Soup;
use geometry::DVec3;

/// A closed surface.
#[derive(Clone, Debug)]
pub(super) enum Surface {
    /// A tube whose two ends are capped. `corners` are the four columns, ascending, where the
    /// corners of the caps lie.
    Tube { net: Net, corners: [f64; 4] },
    /// A net that closes in both directions.
    Torus { net: Net },
    /// A sheet of even thickness on a patch of another net.
    Pad(Pad),
}

/// A sheet on a patch of a surface: a window, a lamp.
#[derive(Clone, Debug)]
pub(super) struct Pad {
    /// The surface it lies on.
    pub(super) net: Net,
    /// Corners of the patch as (row, column) parameters of `net`, around.
    pub(super) corners: [(f64, f64); 4],
    /// How far the corners are rounded: 0 square, 1 elliptic.
    pub(super) round: f64,
    /// How far it protrudes from the surface, and how far it reaches in (m).
    pub(super) height: [f64; 2],
}

impl Pad {
    /// The point at (a, b) in [0, 1]², `height` above the surface.
    fn point(&self, a: f64, b: f64, height: f64) -> DVec3 {
        let (x, y) = (2.0 * a - 1.0, 2.0 * b - 1.0);
        let squeeze = |other: f64| (1.0 - 0.5 * self.round * other * other).sqrt();
        let (a, b) = (0.5 + 0.5 * x * squeeze(y), 0.5 + 0.5 * y * squeeze(x));
        let [p, q, r, s] = self.corners;
        let mix = |p: f64, q: f64, r: f64, s: f64| {
            (1.0 - b) * ((1.0 - a) * p + a * q) + b * ((1.0 - a) * s + a * r)
        };
        let (point, normal) = self.net.frame(mix(p.0, q.0, r.0, s.0), mix(p.1, q.1, r.1, s.1));
        point + normal * height
    }
}

/// The rulers of a surface: its cost in each direction.
#[derive(Clone, Debug)]
pub(super) enum Rulers {
    /// Along the tube, and around it from corner to corner.
    Tube { along: Ruler, around: [Ruler; 4] },
    /// Both ways around.
    Torus { rows: Ruler, cols: Ruler },
    /// Cost of width and height of the patch (m); its lines are evenly spaced.
    Pad { width: f64, height: f64 },
}

/// The number of cells of a surface in each direction: along and two sides of a cap; both ways
/// around a torus; across a pad. Unused ones are 1.
pub(super) type Cells = [usize; 3];

impl Surface {
    /// Measures the surface.
    pub(super) fn rulers(&self) -> Rulers {
        match self {
            Self::Tube { net, corners: [a, b, c, d] } => {
                let around = |from: f64, to: f64| Ruler::new(net, Along::Cols, from, to);
                let wrap = a + net.cols.end();
                Rulers::Tube {
                    along: Ruler::new(net, Along::Rows, 0.0, net.rows.end()),
                    around: [around(*a, *b), around(*b, *c), around(*c, *d), around(*d, wrap)],
                }
            }
            Self::Torus { net } => Rulers::Torus {
                rows: Ruler::new(net, Along::Rows, 0.0, net.rows.end()),
                cols: Ruler::new(net, Along::Cols, 0.0, net.cols.end()),
            },
            Self::Pad(pad) => {
                let cost = |point: &dyn Fn(f64) -> DVec3| {
                    let steps: Vec<DVec3> = (0..16)
                        .map(|k| point(f64::from(k + 1) / 16.0) - point(f64::from(k) / 16.0))
                        .collect();
                    let length: f64 = steps.iter().map(|step| step.length()).sum();
                    let turn = |pair: &[DVec3]| {
                        (pair[1].normalize_or_zero() - pair[0].normalize_or_zero()).length()
                    };
                    stretch(length, steps.windows(2).map(turn).sum())
                };
                Rulers::Pad {
                    width: cost(&|x| pad.point(x, 0.5, 0.0)),
                    height: cost(&|x| pad.point(0.5, x, 0.0)),
                }
            }
        }
    }

    /// Returns the surface with its control points moved.
    pub(super) fn map(&self, move_to: impl Fn(DVec3) -> DVec3) -> Self {
        match self {
            Self::Tube { net, corners } => Self::Tube { net: net.map(move_to), corners: *corners },
            Self::Torus { net } => Self::Torus { net: net.map(move_to) },
            Self::Pad(pad) => Self::Pad(Pad { net: pad.net.map(move_to), ..pad.clone() }),
        }
    }

    /// Middle of the box of the control points.
    pub(super) fn centre(&self) -> DVec3 {
        match self {
            Self::Tube { net, .. } | Self::Torus { net } => net.extent().0,
            Self::Pad(pad) => pad.net.extent().0,
        }
    }

    /// Adds the surface to `soup`, cut into `cells`.
    pub(super) fn sample(&self, rulers: &Rulers, cells: Cells, soup: &mut Soup) {
        let first = soup.triangles.len();
        match (self, rulers) {
            (Self::Tube { net, .. }, Rulers::Tube { along, around }) => {
                sample_tube(net, along, around, cells, soup);
            }
            (Self::Torus { net }, Rulers::Torus { rows, cols }) => {
                sample_torus(net, rows, cols, cells, soup);
            }
            (Self::Pad(pad), _) => sample_pad(pad, cells, soup),
            (Self::Tube { .. } | Self::Torus { .. }, _) => {
                debug_assert!(false, "rulers of another surface");
            }
        }
        soup.turn_outward(first);
    }
}

impl Rulers {
    /// Cells at `fineness` cells per metre of cost, at least `least` each.
    pub(super) fn cells(&self, fineness: f64, least: Cells) -> Cells {
        let count = |cost: f64, least: usize| ((fineness * cost).ceil() as usize).max(least);
        match self {
            Self::Tube { along, around: [a, b, c, d] } => [
                count(along.total(), least[0]),
                count(0.5 * (a.total() + c.total()), least[1]),
                count(0.5 * (b.total() + d.total()), least[2]),
            ],
            Self::Torus { rows, cols } => {
                [count(rows.total(), least[0]), count(cols.total(), least[1]), 1]
            }
            Self::Pad { width, height } => [count(*width, least[0]), count(*height, least[1]), 1],
        }
    }

    /// The resulting number of quads.
    pub(super) fn quads(&self, cells: Cells) -> u64 {
        let [m, n, k] = cells.map(|cells| cells as u64);
        match self {
            Self::Tube { .. } => 2 * m * (n + k) + 2 * n * k,
            Self::Torus { .. } => m * n,
            Self::Pad { .. } => 2 * m * n + 2 * (m + n),
        }
    }
}

/// Middles of the cells between these ends.
fn middles(ends: &[f64]) -> Vec<f64> {
    ends.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect()
}

fn sample_tube(net: &Net, along: &Ruler, around: &[Ruler; 4], cells: Cells, soup: &mut Soup) {
    let [rows, wide, high] = cells;
    let mut ring: Vec<f64> = Vec::new();
    for (side, count) in around.iter().zip([wide, high, wide, high]) {
        ring.pop();
        ring.extend(side.ends(count));
    }
    let stations = along.ends(rows);
    let grid = Grid::of_net(net, &stations, &ring, soup);
    grid.quads(net, soup);
    // The caps: the rim is a ring, the inside a Coons patch of it (S. Coons, 1967).
    let last = grid.rows() - 1;
    for (row, outward) in [(0, false), (last, true)] {
        cap(&grid.vertices[row * grid.cols..(row + 1) * grid.cols], wide, high, outward, soup);
    }
}

fn sample_torus(net: &Net, rows: &Ruler, cols: &Ruler, cells: Cells, soup: &mut Soup) {
    let grid = Grid::of_net(net, &rows.ends(cells[0]), &cols.ends(cells[1]), soup);
    grid.quads(net, soup);
}

/// Vertices of a net, columns closed, rows as the net says.
struct Grid {
    vertices: Vec<u32>,
    cols: usize,
    stations: Vec<f64>,
    ring: Vec<f64>,
}

impl Grid {
    fn of_net(net: &Net, stations: &[f64], ring: &[f64], soup: &mut Soup) -> Self {
        let cols = ring.len() - 1;
        let across: Vec<_> = ring[..cols].iter().map(|t| net.cols.weights(*t)).collect();
        let rows = stations.len() - usize::from(net.rows.is_closed());
        let mut vertices = Vec::with_capacity(rows * cols);
        for s in &stations[..rows] {
            let s = net.rows.weights(*s);
            vertices.extend(across.iter().map(|t| soup.vertex(net.point(&s, t))));
        }
        Self { vertices, cols, stations: stations.to_vec(), ring: ring.to_vec() }
    }

    fn rows(&self) -> usize {
        self.vertices.len() / self.cols
    }

    fn quads(&self, net: &Net, soup: &mut Soup) {
        let (s, t) = (middles(&self.stations), middles(&self.ring));
        let rows = self.rows();
        let vertex_at = |i: usize, j: usize| self.vertices[i % rows * self.cols + j % self.cols];
        for (i, s) in s.iter().enumerate() {
            for (j, t) in t.iter().enumerate() {
                let corners = [
                    vertex_at(i, j),
                    vertex_at(i, j + 1),
                    vertex_at(i + 1, j + 1),
                    vertex_at(i + 1, j),
                ];
                soup.quad(corners, || Some(net.at(*s, *t)));
            }
        }
    }
}

/// Closes a ring of `2 (wide + high)` vertices with a grid.
fn cap(ring: &[u32], wide: usize, high: usize, outward: bool, soup: &mut Soup) {
    let bottom = |a: usize| ring[a];
    let right = |b: usize| ring[wide + b];
    let top = |a: usize| ring[2 * wide + high - a];
    let left = |b: usize| ring[(2 * (wide + high) - b) % ring.len()];
    // Shares of length along each side, for the rim's vertices are not evenly spaced: with even
    // parameters the patch of a narrow profile folds over its own rim.
    let shares = |vertex: &dyn Fn(usize) -> u32, count: usize| -> Vec<f64> {
        let position = |k: usize| soup.vertices[vertex(k) as usize];
        let mut sum = 0.0;
        let run = (0..count).map(|k| {
            sum += position(k).distance(position(k + 1));
            sum
        });
        let run: Vec<f64> = core::iter::once(0.0).chain(run).collect();
        run.iter().map(|length| length / sum).collect()
    };
    let (bottom_at, top_at) = (shares(&bottom, wide), shares(&top, wide));
    let (left_at, right_at) = (shares(&left, high), shares(&right, high));
    let mut vertices = Vec::with_capacity((wide + 1) * (high + 1));
    for b in 0..=high {
        for a in 0..=wide {
            let known = match (a, b) {
                (a, 0) => Some(bottom(a)),
                (a, b) if b == high => Some(top(a)),
                (0, b) => Some(left(b)),
                (a, b) if a == wide => Some(right(b)),
                _ => None,
            };
            vertices.push(known.unwrap_or_else(|| {
                let position = |vertex: u32| soup.vertices[vertex as usize];
                let y = 0.5 * (left_at[b] + right_at[b]);
                let x = (1.0 - y) * bottom_at[a] + y * top_at[a];
                let sides = position(bottom(a)) * (1.0 - y)
                    + position(top(a)) * y
                    + position(left(b)) * (1.0 - x)
                    + position(right(b)) * x;
                let corners = (position(bottom(0)) * (1.0 - x) + position(bottom(wide)) * x)
                    * (1.0 - y)
                    + (position(top(0)) * (1.0 - x) + position(top(wide)) * x) * y;
                soup.vertex(sides - corners)
            }));
        }
    }
    for b in 0..high {
        for a in 0..wide {
            let vertex_at = |a: usize, b: usize| vertices[b * (wide + 1) + a];
            let quad = [
                vertex_at(a, b),
                vertex_at(a + 1, b),
                vertex_at(a + 1, b + 1),
                vertex_at(a, b + 1),
            ];
            let [p, q, r, s] = quad;
            soup.quad(if outward { quad } else { [s, r, q, p] }, || None);
        }
    }
}

fn sample_pad(pad: &Pad, cells: Cells, soup: &mut Soup) {
    let [wide, high, _] = cells;
    let mut sheet = |height: f64| -> Vec<u32> {
        (0..(wide + 1) * (high + 1))
            .map(|k| {
                let (a, b) = (k % (wide + 1), k / (wide + 1));
                let (a, b) = (a as f64 / wide as f64, b as f64 / high as f64);
                soup.vertex(pad.point(a, b, height))
            })
            .collect()
    };
    let [above, below] = [sheet(pad.height[0]), sheet(-pad.height[1])];
    let index = |a: usize, b: usize| b * (wide + 1) + a;
    for b in 0..high {
        for a in 0..wide {
            let quad = [index(a, b), index(a + 1, b), index(a + 1, b + 1), index(a, b + 1)];
            let (x, y) = ((a as f64 + 0.5) / wide as f64, (b as f64 + 0.5) / high as f64);
            soup.quad(quad.map(|k| above[k]), || Some(pad.point(x, y, pad.height[0])));
            let [p, q, r, s] = quad.map(|k| below[k]);
            soup.quad([s, r, q, p], || Some(pad.point(x, y, -pad.height[1])));
        }
    }
    let rim = (0..wide)
        .map(|a| index(a, 0))
        .chain((0..high).map(|b| index(wide, b)))
        .chain((0..wide).map(|a| index(wide - a, high)))
        .chain((0..high).map(|b| index(0, high - b)));
    let rim: Vec<usize> = rim.collect();
    for (k, p) in rim.iter().enumerate() {
        let q = rim[(k + 1) % rim.len()];
        soup.quad([above[q], above[*p], below[*p], below[q]], || None);
    }
}
