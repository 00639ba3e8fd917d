//! Regions of the plane in whole numbers, so that unions are exact and the same on all machines.

use super::{Ring, TOLERANCE_M};
use geometry::plan;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::Overlay;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::i_float::int::angle::Angle;
use i_overlay::i_float::int::point::IntPoint;
use i_overlay::mesh::int::outline::offset::IntOutlineOffset;
use i_overlay::mesh::int::style::{IntLineJoin, IntOutlineStyle};
use std::collections::{BTreeMap, BTreeSet};

/// A point of the grid.
pub(super) type Point = IntPoint<i32>;

/// What lies this near to each other is the same in a union (m): a twentieth of what outlines may
/// leave out.
const SAME_M: f64 = 0.05 * TOLERANCE_M;

/// Corners sharper than 20° are cut when a region grows; in 2⁻³² of a turn.
const SHARPEST: Angle = Angle::from_bits(((1_u64 << 32) * 20 / 360) as u32);

/// A grid that holds a body: cells of a power of two, as fine as 32 bits allow and at least 2⁻²⁰ m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    cells_per_m: f64,
}

/// A set of points in plan: counter-clockwise rings without holes.
#[derive(Clone, Debug, Default)]
pub(super) struct Region {
    contours: Vec<Vec<Point>>,
}

impl Grid {
    pub(super) fn over(corners: &[[[f64; 3]; 3]]) -> Self {
        let most = corners.iter().flatten().fold(1.0_f64, |m, p| m.max(p[0].abs().max(p[1].abs())));
        let mut cells_per_m = f64::from(1 << 20);
        // Growing needs room besides.
        while (most + 1.0) * cells_per_m > f64::from(1 << 28) {
            cells_per_m *= 0.5;
        }
        Self { cells_per_m }
    }

    pub(super) fn cell(&self, x: f64, y: f64) -> Point {
        let [x, y] = [x, y].map(|x| (x * self.cells_per_m).round() as i32);
        Point::new(x, y)
    }

    pub(super) fn metres(&self, p: Point) -> [f64; 2] {
        [p.x, p.y].map(|x| f64::from(x) / self.cells_per_m)
    }

    fn cells(&self, length_m: f64) -> i32 {
        (length_m * self.cells_per_m).round() as i32
    }
}

/// Twice the area of a ring, positive if it is counter-clockwise.
fn area_2(ring: &[Point]) -> i128 {
    let next = ring.iter().cycle().skip(1);
    let cross = |(p, q): (&Point, &Point)| {
        i128::from(p.x) * i128::from(q.y) - i128::from(q.x) * i128::from(p.y)
    };
    ring.iter().zip(next).map(cross).sum()
}

impl Region {
    /// The union of rings, whichever way round, each filled.
    ///
    /// Cross-sections of one wall are the same lines but for rounding and the points on them. Lines
    /// that nearly coincide cross at very many points of the grid, so what is nearer than
    /// [`SAME_M`] is made the same first.
    pub(super) fn union(rings: Vec<Vec<Point>>, grid: &Grid) -> Self {
        let within = grid.cells(SAME_M);
        let mut rings: Vec<_> = rings.iter().map(|ring| straightened(ring, within)).collect();
        merge_near(&mut rings, within);
        rings.retain(|ring| ring.len() >= 3);
        for ring in &mut rings {
            if area_2(ring) < 0 {
                ring.reverse();
            }
        }
        Self { contours: rings }.with(&Self::default(), OverlayRule::Subject)
    }

    fn with(&self, other: &Self, rule: OverlayRule) -> Self {
        let mut overlay = Overlay::from_subj_and_clip(&self.contours, &other.contours);
        Self::without_holes(overlay.overlay(rule, FillRule::NonZero))
    }

    /// Of each shape its first ring, the outer one.
    fn without_holes(shapes: Vec<Vec<Vec<Point>>>) -> Self {
        Self { contours: shapes.into_iter().filter_map(|shape| shape.into_iter().next()).collect() }
    }

    /// This region with others.
    pub(super) fn and(&self, rings: Vec<Vec<Point>>, grid: &Grid) -> Self {
        self.with(&Self::union(rings, grid), OverlayRule::Union)
    }

    /// Squares of one size that hold all points: as small as there are at most `most` of them, and
    /// at least of 5 mm.
    pub(super) fn squares(points: &[Point], grid: &Grid, most: usize) -> Vec<Vec<Point>> {
        let mut side = grid.cells(0.005).max(1);
        loop {
            let cell = |p: &Point| (p.x.div_euclid(side), p.y.div_euclid(side));
            let cells: BTreeSet<(i32, i32)> = points.iter().map(cell).collect();
            if cells.len() <= most || side > i32::MAX / 8 {
                let corner = |x: i32, y: i32| Point::new(x * side, y * side);
                let square = |(x, y): (i32, i32)| {
                    vec![corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)]
                };
                return cells.into_iter().map(square).collect();
            }
            side *= 2;
        }
    }

    /// Grown, or shrunk if negative, by a distance; corners stay corners.
    fn grown(&self, grid: &Grid, by_m: f64) -> Self {
        let join = IntLineJoin::Miter(SHARPEST);
        let style = IntOutlineStyle::new(grid.cells(by_m)).line_join(join);
        // It fails for coordinates beyond the grid's room, which `Grid::over` excludes.
        self.contours.outline(&style).map_or_else(|_| self.clone(), Self::without_holes)
    }

    /// Without gaps narrower than twice a distance (a morphological closing), and without holes.
    pub(super) fn closed(&self, grid: &Grid, by_m: f64) -> Self {
        let closed = self.grown(grid, by_m).grown(grid, -by_m);
        // Sharp corners are cut on the way out and prolonged on the way back; no closing leaves the
        // convex hull.
        let closed = closed.with(&self.hull(), OverlayRule::Intersect);
        self.with(&closed, OverlayRule::Union)
    }

    fn hull(&self) -> Self {
        let mut points: Vec<Point> = self.contours.iter().flatten().copied().collect();
        points.sort_by_key(|p| (p.x, p.y));
        points.dedup();
        let hull = plan::hull(&points, |a, b, p| turn(a, b, p) > 0);
        Self { contours: if hull.len() < 3 { Vec::new() } else { vec![hull] } }
    }

    /// Without what is narrower than twice a distance (a morphological opening).
    pub(super) fn opened(&self, grid: &Grid, by_m: f64) -> Self {
        if by_m <= 0.0 {
            return self.clone();
        }
        self.with(&self.grown(grid, -by_m).grown(grid, by_m), OverlayRule::Intersect)
    }

    /// Without points that lie within a tolerance of the line without them: growing takes time by
    /// the point.
    pub(super) fn thinned(&self, grid: &Grid, tolerance_m: f64) -> Self {
        let rings = self.rings(grid, tolerance_m);
        let contour = |ring: Ring| ring.into_iter().map(|[x, y]| grid.cell(x, y)).collect();
        Self { contours: rings.into_iter().map(contour).collect() }
    }

    /// A look-up of points that lie inside, or no further outside than a distance.
    pub(super) fn inside(&self, grid: &Grid, by_m: f64) -> Inside {
        Inside::of(&self.grown(grid, by_m))
    }

    /// Its rings in metres, without points that lie within a tolerance of the line without them.
    pub(super) fn rings(&self, grid: &Grid, tolerance_m: f64) -> Vec<Ring> {
        let ring = |contour: &Vec<Point>| {
            let points: Vec<_> = contour.iter().map(|p| grid.metres(*p)).collect();
            simplified(&points, tolerance_m)
        };
        let mut rings: Vec<Ring> =
            self.contours.iter().map(ring).filter(|ring| ring.len() >= 3).collect();
        rings.sort_by(|a, b| a.partial_cmp(b).unwrap_or(core::cmp::Ordering::Equal));
        rings
    }
}

/// A ring without points that lie within a distance of the line without them.
fn straightened(ring: &[Point], within: i32) -> Vec<Point> {
    let points: Vec<_> = ring.iter().map(|p| [p.x, p.y].map(f64::from)).collect();
    let point = |[x, y]: [f64; 2]| Point::new(x as i32, y as i32);
    simplified(&points, f64::from(within)).into_iter().map(point).collect()
}

/// Makes points one that lie within a distance of each other along both axes: each becomes the
/// first such point in the order of x, then y.
fn merge_near(rings: &mut [Vec<Point>], within: i32) {
    let key = |p: &Point| (p.x, p.y);
    let mut points: Vec<Point> = rings.iter().flatten().copied().collect();
    points.sort_by_key(key);
    points.dedup();
    let cell = |p: &Point| (p.x.div_euclid(within.max(1)), p.y.div_euclid(within.max(1)));
    let mut kept: BTreeMap<(i32, i32), Vec<Point>> = BTreeMap::new();
    let mut becomes: BTreeMap<(i32, i32), Point> = BTreeMap::new();
    for p in &points {
        let (column, row) = cell(p);
        let is_near = |q: &&Point| (p.x - q.x).abs() <= within && (p.y - q.y).abs() <= within;
        let first = (column - 1..=column)
            .flat_map(|column| (row - 1..=row + 1).map(move |row| (column, row)))
            .filter_map(|cell| kept.get(&cell))
            .flatten()
            .filter(is_near)
            .min_by_key(|q| key(q))
            .copied();
        if first.is_none() {
            kept.entry((column, row)).or_default().push(*p);
        }
        becomes.insert(key(p), first.unwrap_or(*p));
    }
    for ring in rings {
        for p in ring.iter_mut() {
            *p = becomes.get(&key(p)).copied().unwrap_or(*p);
        }
        ring.dedup();
        if ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
    }
}

/// Twice the area of a triangle, positive if it is counter-clockwise.
fn turn(a: Point, b: Point, p: Point) -> i128 {
    let [ax, ay, bx, by, px, py] = [a.x, a.y, b.x, b.y, p.x, p.y].map(i128::from);
    (bx - ax) * (py - ay) - (by - ay) * (px - ax)
}

/// The edges of a region in rows, so that a point is held against few of them.
#[derive(Debug)]
pub(super) struct Inside {
    low: i64,
    height: i64,
    rows: Vec<Vec<[Point; 2]>>,
}

impl Inside {
    const ROWS: i64 = 512;

    fn of(region: &Region) -> Self {
        let heights = || region.contours.iter().flatten().map(|p| i64::from(p.y));
        let low = heights().min().unwrap_or(0);
        let height = (heights().max().unwrap_or(0) - low) / Self::ROWS + 1;
        let mut rows = vec![Vec::new(); Self::ROWS as usize];
        for ring in &region.contours {
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                let row = |y: i32| ((i64::from(y) - low) / height) as usize;
                for edges in &mut rows[row(a.y.min(b.y))..=row(a.y.max(b.y))] {
                    edges.push([*a, *b]);
                }
            }
        }
        Self { low, height, rows }
    }

    /// Even-odd test in whole numbers; the border belongs to one side or the other.
    pub(super) fn holds(&self, p: Point) -> bool {
        let row = (i64::from(p.y) - self.low).div_euclid(self.height);
        let edges = usize::try_from(row).ok().and_then(|row| self.rows.get(row));
        let crosses = |[a, b]: &&[Point; 2]| {
            (a.y > p.y) != (b.y > p.y) && (turn(*a, *b, p) > 0) == (b.y > a.y)
        };
        edges.is_some_and(|edges| edges.iter().filter(crosses).count() % 2 == 1)
    }
}

/// A ring without points that lie within a tolerance of it (Douglas and Peucker 1973), begun at
/// its two ends along x.
fn simplified(ring: &[[f64; 2]], tolerance_m: f64) -> Ring {
    let by = |a: &&usize, b: &&usize| ring[**a].partial_cmp(&ring[**b]);
    let order: Vec<usize> = (0..ring.len()).collect();
    let compare = |a: &&usize, b: &&usize| by(a, b).unwrap_or(core::cmp::Ordering::Equal);
    let (Some(&first), Some(&last)) = (order.iter().min_by(compare), order.iter().max_by(compare))
    else {
        return Ring::new();
    };
    let n = ring.len();
    let turned: Vec<[f64; 2]> = (0..=n).map(|k| ring[(first + k) % n]).collect();
    let middle = (last + n - first) % n;
    let mut keep = vec![false; n + 1];
    keep[0] = true;
    keep[middle] = true;
    let mut open = vec![(0, middle), (middle, n)];
    // Each turn keeps one more point or closes one piece.
    while let Some((from, to)) = open.pop() {
        let far = |k: usize| (k, plan::distance_m(turned[k], [turned[from], turned[to]]));
        let furthest = (from + 1..to).map(far).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((k, _)) = furthest.filter(|(_, far_m)| *far_m > tolerance_m) {
            keep[k] = true;
            open.extend([(from, k), (k, to)]);
        }
    }
    turned.iter().zip(&keep).take(n).filter(|(_, keep)| **keep).map(|(point, _)| *point).collect()
}
