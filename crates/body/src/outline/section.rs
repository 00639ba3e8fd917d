//! What a body covers between two heights: horizontal cross-sections, and what they miss.

use super::region::{Grid, Point, Region};
use super::{GAP_M, SECTIONS};
use std::collections::BTreeMap;

/// Half of the width that a surface without an inside is given (m).
const SHEET_M: f64 = 0.001;

/// What lies this near to a section is not missed by it (m).
const NEAR_M: f64 = 0.002;

/// Most pieces that a union is made of, in one band. The crossings of a cloud of triangles grow
/// with the square of their number; where there are more, squares around their corners stand for
/// them.
const PIECES_MAX: usize = 4000;

/// Most segments of a cross-section that are put together to lines.
const SEGMENTS_MAX: usize = 200_000;

type Triangle = [[f64; 3]; 3];

/// The region of a band.
pub(super) fn of(corners: &[Triangle], band: [f64; 2], grid: &Grid) -> Region {
    let spans = || corners.iter().map(|triangle| (triangle, span(triangle)));
    let height = |k: usize| band[0] + (band[1] - band[0]) * (k as f64 + 0.5) / SECTIONS as f64;
    let heights: [f64; SECTIONS] = core::array::from_fn(height);
    let mut cuts: [Vec<[Point; 2]>; SECTIONS] = Default::default();
    for (triangle, (low, high)) in spans() {
        let from = heights.partition_point(|z| *z <= low);
        for (z, cut) in heights.iter().zip(&mut cuts).skip(from).take_while(|(z, _)| **z <= high) {
            cut.extend(crossing(triangle, *z, grid));
        }
    }
    let pieces: Vec<_> = cuts.iter().flat_map(|cut| rings(cut, grid)).collect();
    let region = Region::union(fewer(pieces, grid), grid);
    let inside = region.inside(grid, NEAR_M);
    let is_in = |p: &[f64; 3]| inside.holds(grid.cell(p[0], p[1]));
    let mut missed: Vec<Vec<Point>> = Vec::new();
    for (triangle, (low, high)) in spans() {
        // Most triangles of the band lie inside of its sections.
        if high < band[0] || low > band[1] || triangle.iter().all(is_in) {
            continue;
        }
        let part = between(triangle, band);
        if !part.iter().all(is_in) {
            missed.push(part.iter().map(|p| grid.cell(p[0], p[1])).collect());
        }
    }
    if missed.is_empty() { region } else { region.and(fewer(missed, grid), grid) }
}

/// The same pieces, or squares that stand for too many of them.
fn fewer(pieces: Vec<Vec<Point>>, grid: &Grid) -> Vec<Vec<Point>> {
    if pieces.len() <= PIECES_MAX {
        return pieces;
    }
    Region::squares(&pieces.concat(), grid, PIECES_MAX)
}

fn span(triangle: &Triangle) -> (f64, f64) {
    let z = triangle.map(|p| p[2]);
    (z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]))
}

/// Where a triangle crosses a height. A corner at that height counts as above.
fn crossing(triangle: &Triangle, z: f64, grid: &Grid) -> Option<[Point; 2]> {
    let mut points = (0..3).filter_map(|k| {
        let (mut a, mut b) = (triangle[k], triangle[(k + 1) % 3]);
        if (a[2] < z) == (b[2] < z) {
            return None;
        }
        // From below, so that both triangles of an edge compute the same point.
        if a[2] > b[2] {
            core::mem::swap(&mut a, &mut b);
        }
        let share = (z - a[2]) / (b[2] - a[2]);
        Some(grid.cell(a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])))
    });
    let (p, q) = (points.next()?, points.next()?);
    (p != q).then_some([p, q])
}

/// The part of a triangle between two heights: a convex polygon of at most five corners.
fn between(triangle: &Triangle, [low, high]: [f64; 2]) -> Vec<[f64; 3]> {
    let above = clipped(triangle, |p| p[2] - low);
    clipped(&above, |p| high - p[2])
}

/// The part of a convex polygon where a linear function is not negative.
fn clipped(polygon: &[[f64; 3]], of: impl Fn(&[f64; 3]) -> f64) -> Vec<[f64; 3]> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, p) in polygon.iter().enumerate() {
        let q = &polygon[(k + 1) % polygon.len()];
        let (f, g) = (of(p), of(q));
        if f >= 0.0 {
            kept.push(*p);
        }
        if (f < 0.0) != (g < 0.0) {
            let share = f / (f - g);
            kept.push([0, 1, 2].map(|i| p[i] + share * (q[i] - p[i])));
        }
    }
    kept
}

/// Segments put together to rings. Lines that do not close are closed if their ends are near, else
/// they are thin sheets.
fn rings(cut: &[[Point; 2]], grid: &Grid) -> Vec<Vec<Point>> {
    if cut.len() > SEGMENTS_MAX {
        return cut.iter().map(|segment| segment.to_vec()).collect();
    }
    let key = |p: &Point| (p.x, p.y);
    let ordered = |[p, q]: &[Point; 2]| if key(p) <= key(q) { [*p, *q] } else { [*q, *p] };
    let mut segments: Vec<[Point; 2]> = cut.iter().map(ordered).collect();
    segments.sort_by_key(|[p, q]| (key(p), key(q)));
    segments.dedup();
    let mut at: BTreeMap<(i32, i32), Vec<usize>> = BTreeMap::new();
    for (number, segment) in segments.iter().enumerate() {
        for p in segment {
            at.entry(key(p)).or_default().push(number);
        }
    }
    let mut used = vec![false; segments.len()];
    let mut found = Vec::new();
    // Ends first, so that a line that does not close is one line.
    let ends = at.iter().filter(|(_, beside)| beside.len() % 2 == 1).map(|(p, _)| *p);
    let starts: Vec<(i32, i32)> = ends.chain(segments.iter().map(|[p, _]| key(p))).collect();
    for start in starts {
        let mut line = vec![Point::new(start.0, start.1)];
        // Every turn uses a segment.
        while let Some(number) = line
            .last()
            .and_then(|p| at.get(&key(p)))
            .and_then(|beside| beside.iter().copied().find(|number| !used[*number]))
        {
            used[number] = true;
            let [p, q] = segments[number];
            let here = line[line.len() - 1];
            line.push(if p == here { q } else { p });
            if line.len() > 3 && key(&line[line.len() - 1]) == start {
                break;
            }
        }
        if line.len() < 2 {
            continue;
        }
        let (first, last) = (grid.metres(line[0]), grid.metres(line[line.len() - 1]));
        let gap_m = ((last[0] - first[0]).abs()).max((last[1] - first[1]).abs());
        if gap_m <= GAP_M && line.len() > 3 {
            found.push(line);
        } else {
            found.extend(line.windows(2).map(|pair| sheet([pair[0], pair[1]], grid)));
        }
    }
    found
}

/// A thin rectangle around a segment.
fn sheet([p, q]: [Point; 2], grid: &Grid) -> Vec<Point> {
    let ([px, py], [qx, qy]) = (grid.metres(p), grid.metres(q));
    let (dx, dy) = (qx - px, qy - py);
    let length = (dx * dx + dy * dy).sqrt();
    let (nx, ny) = (-dy / length * SHEET_M, dx / length * SHEET_M);
    vec![
        grid.cell(px - nx, py - ny),
        grid.cell(qx - nx, qy - ny),
        grid.cell(qx + nx, qy + ny),
        grid.cell(px + nx, py + ny),
    ]
}
