//! A shot as a PNG, drawn here: triangles with a depth buffer, flat shading, perspective.
//!
//! Four samples a pixel. Hit triangles are red and shine through what hides them, since the bodies
//! overlap there; the patch is a yellow frame in front of everything, and a ring of a least size
//! marks it however small it is. The ground has a grid of metres; a bar on it says how long some
//! metres are there.

use crate::glb::COLOURS;
use crate::shot::{Shot, ShotBody};
use canvas::Canvas;
use geometry::DVec3;

mod canvas;

/// The viewpoint of a shot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Camera {
    /// From ahead and left, above.
    Corner,
    /// From above, forward up.
    Above,
}

/// Samples along each side of a pixel.
const FINE: usize = 2;
/// The background, and lines of the grid on the ground.
const SKY: [f64; 3] = [250.0, 250.0, 248.0];
const GRID: [f64; 3] = [214.0, 216.0, 212.0];
/// Least radius of the ring around what touches, in pixels of a small picture.
const RING: f64 = 22.0;
/// Letters and bars.
const INK: [f64; 3] = [29.0, 33.0, 38.0];
/// The ring, and what is said about it.
const ALARM: [f64; 3] = [178.0, 24.0, 43.0];
/// The room beside the bodies in which the bar lies (m).
const BESIDE_M: f64 = 0.5;

/// The picture cannot be encoded as PNG.
#[derive(Debug, thiserror::Error)]
#[error("cannot encode the picture: {0}")]
pub struct StillError(String);

impl diagnostic::Diagnostic for StillError {
    fn kind(&self) -> diagnostic::FailureKind {
        diagnostic::FailureKind::Internal
    }
}

/// Draws a shot, `width` by `height` pixels.
///
/// # Errors
///
/// If the picture has no pixels, or cannot be encoded.
pub fn still(
    shot: &Shot,
    bodies: &[ShotBody],
    camera: Camera,
    [width, height]: [usize; 2],
) -> Result<Vec<u8>, StillError> {
    let wrong = |error: png::EncodingError| StillError(error.to_string());
    let (colours, depths) = draw(shot, bodies, camera, [width * FINE, height * FINE]);
    let mut pixels = Vec::with_capacity(width * height);
    let mut is_body = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let mut sum = [0.0; 3];
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let sample = colours[(y * FINE + j) * width * FINE + x * FINE + i];
                (0..3).for_each(|c| sum[c] += sample[c] / 4.0);
            }
            pixels.push(sum);
            is_body.push(depths[y * FINE * width * FINE + x * FINE].is_finite());
        }
    }
    let mut canvas = Canvas::new([width, height], pixels, is_body);
    let view = View::of(shot, bodies, camera, [width, height]);
    annotate(&mut canvas, shot, bodies, &view);
    let data = canvas.bytes();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(wrong)?;
    writer.write_image_data(&data).map_err(wrong)?;
    writer.finish().map_err(wrong)?;
    Ok(file)
}

/// The projection onto the picture.
struct View {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    ahead: DVec3,
    /// Pixels for a slope of 1.
    focal: f64,
    middle: [f64; 2],
}

impl View {
    fn of(shot: &Shot, bodies: &[ShotBody], camera: Camera, [width, height]: [usize; 2]) -> Self {
        let [low, mut high] = shot.focus(bodies).map(DVec3::from_array);
        // Room for the bar, which lies on the side of the eye.
        high.y += BESIDE_M;
        let centre = 0.5 * (low + high);
        let reach = (0.5 * (high - low).length()).max(0.5);
        let (from, top) = match camera {
            Camera::Corner => (DVec3::new(0.75, 1.0, 0.7).normalize(), DVec3::Z),
            Camera::Above => (DVec3::Z, DVec3::X),
        };
        let eye = centre + from * (3.2 * reach);
        let ahead = -from;
        let right = ahead.cross(top).normalize();
        let up = right.cross(ahead);
        // The bounding box of the scene fills the picture, whichever side is longer.
        let mut slopes = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for corner in 0..8_u8 {
            let end = |axis: usize| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] };
            let to = DVec3::new(end(0), end(1), end(2)) - eye;
            for (range, side) in slopes.iter_mut().zip([right, -up]) {
                let slope = to.dot(side) / to.dot(ahead);
                *range = [range[0].min(slope), range[1].max(slope)];
            }
        }
        let size = [width as f64, height as f64];
        // Room for the names above the bodies.
        let fits = |axis: usize| {
            let [least, most] = slopes[axis];
            [0.94, 0.84][axis] * size[axis] / (most - least).max(1e-6)
        };
        let focal = fits(0).min(fits(1));
        let mut middle = [0, 1].map(|i| 0.5 * (size[i] - focal * (slopes[i][0] + slopes[i][1])));
        middle[1] += 0.03 * size[1];
        Self { eye, right, up, ahead, focal, middle }
    }

    /// Where the ray through a pixel meets a height (m), and its distance.
    fn on_level(&self, [x, y]: [f64; 2], level_m: f64) -> Option<(DVec3, f64)> {
        let slopes = [x - self.middle[0], self.middle[1] - y].map(|by| by / self.focal);
        let ray = self.ahead + self.right * slopes[0] + self.up * slopes[1];
        let depth = (level_m - self.eye.z) / ray.z;
        (depth > 0.05).then(|| (self.eye + ray * depth, depth))
    }

    /// Pixel and distance of a point; `None` if it is behind the eye.
    fn pixel(&self, point: DVec3) -> Option<[f64; 3]> {
        let to = point - self.eye;
        let depth = to.dot(self.ahead);
        (depth > 0.05).then(|| {
            let k = self.focal / depth;
            let [x, y] = self.middle;
            [x + k * to.dot(self.right), y - k * to.dot(self.up), depth]
        })
    }
}

/// The colour of every sample, and how far away the body is that it shows; infinite: none.
fn draw(
    shot: &Shot,
    bodies: &[ShotBody],
    camera: Camera,
    size: [usize; 2],
) -> (Vec<[f64; 3]>, Vec<f64>) {
    let [width, height] = size;
    let view = View::of(shot, bodies, camera, size);
    let mut colours = vec![SKY; width * height];
    ground(&view, shot.focus(bodies), size, &mut colours);
    let mut depths = vec![f64::INFINITY; width * height];
    let light = DVec3::new(0.35, 0.55, 0.9).normalize();
    let mut through = vec![false; width * height];
    for (side, number) in shot.bodies.into_iter().enumerate() {
        let Some(body) = bodies.get(number) else { continue };
        let mut is_hit = vec![false; body.corners.len()];
        for hit in &shot.hits[side] {
            if let Some(mark) = is_hit.get_mut(*hit as usize) {
                *mark = true;
            }
        }
        for (corners, is_hit) in body.corners.iter().zip(is_hit) {
            let points = corners.map(|corner| DVec3::from_array(shot.place(corner, side == 1)));
            let normal = (points[1] - points[0]).cross(points[2] - points[0]);
            if !(normal.length() > 0.0) {
                continue;
            }
            let shade = 0.45 + 0.55 * normal.normalize().dot(light).abs();
            let colour = [0, 1, 2].map(|c| f64::from(COLOURS[side][c]) * shade);
            let Some(corners) = all(points.map(|point| view.pixel(point))) else { continue };
            fill(corners, size, |at, depth| {
                if depth < depths[at] {
                    depths[at] = depth;
                    colours[at] = colour;
                }
                through[at] |= is_hit;
            });
        }
    }
    for (colour, _) in colours.iter_mut().zip(&through).filter(|(_, through)| **through) {
        *colour = [0, 1, 2].map(|c| 0.25 * colour[c] + 0.75 * f64::from(COLOURS[2][c]));
    }
    if let Some(patch) = shot.patch {
        let corners = patch.corners().map(|corner| view.pixel(DVec3::from_array(corner)));
        for (a, b) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            if let (Some(a), Some(b)) = (corners[a], corners[b]) {
                line(a, b, size, |at| {
                    colours[at] = [0, 1, 2].map(|c| f64::from(COLOURS[3][c]));
                });
            }
        }
    }
    (colours, depths)
}

/// A line each metre on the ground, fading out around what is shown. The ground is where the lower
/// of both bodies ends.
fn ground(
    view: &View,
    [low, high]: [[f64; 3]; 2],
    [width, height]: [usize; 2],
    colours: &mut [[f64; 3]],
) {
    let centre = [0, 1].map(|axis| 0.5 * (low[axis] + high[axis]));
    let reach_m = 0.5 * f64::hypot(high[0] - low[0], high[1] - low[1]);
    if !reach_m.is_finite() {
        return;
    }
    for (at, colour) in colours.iter_mut().enumerate() {
        let pixel = [(at % width) as f64 + 0.5, (at / width) as f64 + 0.5];
        let Some((point, depth)) = view.on_level(pixel, low[2]) else { continue };
        let far_m = f64::hypot(point.x - centre[0], point.y - centre[1]);
        let strength = (1.0 - (far_m - reach_m) / (0.8 * reach_m + 1.0)).clamp(0.0, 1.0);
        // As wide as three samples where it is seen from the front.
        let half_m = 1.5 * depth / view.focal;
        let is_line = |metres: f64| (metres - metres.round()).abs() < half_m;
        if strength > 0.0 && (is_line(point.x) || is_line(point.y)) {
            *colour = [0, 1, 2].map(|c| SKY[c] + strength * (GRID[c] - SKY[c]));
        }
    }
    debug_assert_eq!(colours.len(), width * height);
}

/// Names, the ring around what touches, and the bar.
fn annotate(canvas: &mut Canvas, shot: &Shot, bodies: &[ShotBody], view: &View) {
    let patch = shot.patch.map(|patch| {
        let corners = patch.corners().map(DVec3::from_array);
        let centre = DVec3::from_array(patch.centre_m);
        let pixels = corners.iter().filter_map(|corner| view.pixel(*corner));
        (view.pixel(centre), pixels.collect::<Vec<_>>())
    });
    let mut ring = None;
    if let Some((Some([x, y, _]), corners)) = patch {
        let reach = corners.iter().map(|[p, q, _]| f64::hypot(p - x, q - y)).fold(0.0, f64::max);
        let radius = (1.25 * reach).max(RING * canvas.scale());
        canvas.circle([x, y], radius, ALARM);
        ring = Some(([x, y], radius));
    }
    bar(canvas, shot.focus(bodies), view);
    for (side, number) in shot.bodies.into_iter().enumerate() {
        let Some([low, high]) = bodies.get(number).and_then(|body| shot.bounds(body, side)) else {
            continue;
        };
        let top = DVec3::new(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), high[2]);
        if let Some([x, y, _]) = view.pixel(top) {
            canvas.label([x, y], 14.0, &shot.parties[side], INK);
        }
    }
    if let Some((at, radius)) = ring {
        canvas.label(at, radius + 8.0, "contact", ALARM);
    }
}

/// A bar of 1, 2 or 5 times a power of ten metres on the ground, beside the bodies.
fn bar(canvas: &mut Canvas, [low, high]: [[f64; 3]; 2], view: &View) {
    let most_m = (0.5 * (high[0] - low[0])).max(0.1);
    let sizes = [10.0, 5.0, 2.0, 1.0, 0.5, 0.2];
    let size_m: f64 = sizes.into_iter().find(|size| *size <= most_m).unwrap_or(0.1);
    let y = high[1] + 0.6 * BESIDE_M;
    let end = |x: f64, by: f64| view.pixel(DVec3::new(x, y + by, low[2]));
    let middle = 0.5 * (low[0] + high[0]);
    let ends = [middle - 0.5 * size_m, middle + 0.5 * size_m];
    let tick = 0.12 * BESIDE_M;
    for [from, to] in [
        [end(ends[0], 0.0), end(ends[1], 0.0)],
        [end(ends[0], -tick), end(ends[0], tick)],
        [end(ends[1], -tick), end(ends[1], tick)],
    ] {
        if let (Some(from), Some(to)) = (from, to) {
            canvas.line(from, to, INK);
            canvas.keep_clear(from, to);
        }
    }
    if let Some([x, y, _]) = end(middle, 0.0) {
        canvas.label([x, y], 10.0, &format!("{size_m} m; grid 1 m"), INK);
    }
}

fn all([a, b, c]: [Option<[f64; 3]>; 3]) -> Option<[[f64; 3]; 3]> {
    Some([a?, b?, c?])
}

/// Calls `put` with every sample inside of a triangle and its depth.
fn fill([a, b, c]: [[f64; 3]; 3], [width, height]: [usize; 2], mut put: impl FnMut(usize, f64)) {
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if area == 0.0 {
        return;
    }
    let range = |axis: usize, most: usize| {
        let low = a[axis].min(b[axis]).min(c[axis]).floor().max(0.0);
        let high = a[axis].max(b[axis]).max(c[axis]).ceil().min(most as f64);
        (low as usize)..(high.max(low) as usize)
    };
    for y in range(1, height) {
        for x in range(0, width) {
            let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
            let weight = |p: [f64; 3], q: [f64; 3]| {
                ((p[0] - px) * (q[1] - py) - (p[1] - py) * (q[0] - px)) / area
            };
            let (u, v, w) = (weight(b, c), weight(c, a), weight(a, b));
            if u < 0.0 || v < 0.0 || w < 0.0 {
                continue;
            }
            // Inverse distances are linear on the picture.
            let depth = 1.0 / (u / a[2] + v / b[2] + w / c[2]);
            put(y * width + x, depth);
        }
    }
}

/// Calls `put` with every sample of a line, three samples wide.
fn line(a: [f64; 3], b: [f64; 3], [width, height]: [usize; 2], mut put: impl FnMut(usize)) {
    let steps = (b[0] - a[0]).abs().max((b[1] - a[1]).abs()).ceil().clamp(1.0, 20_000.0);
    for step in 0..=steps as u32 {
        let share = f64::from(step) / steps;
        let (x, y) = (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]));
        for (i, j) in [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1)] {
            let (x, y) = (x.floor() as i64 + i, y.floor() as i64 + j);
            if (0..width as i64).contains(&x) && (0..height as i64).contains(&y) {
                put(y as usize * width + x as usize);
            }
        }
    }
}

#[cfg(test)]
mod tests;
