//! Shapes in plan, and whether two of them share a point.
//!
//! An outline is a set of simple polygons and circles in the frame of its body. Polygons may be
//! concave; two share a point if edges meet or one lies inside the other, a circle and a polygon if
//! the centre lies inside or an edge is within the radius. Touching counts.

/// One piece of an outline, in the frame of the body (m).
#[derive(Clone, Debug, PartialEq)]
pub enum OutlinePart {
    /// Corners in order, either way round.
    Polygon(Vec<[f64; 2]>),
    /// Centre and radius.
    Circle([f64; 2], f64),
}

/// What a body covers in plan, in its own frame: x forward, y left (m).
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// At least one.
    pub parts: Vec<OutlinePart>,
}

/// Where an outline lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Origin of the body (m).
    pub at: [f64; 2],
    /// From x towards y (rad).
    pub yaw: f64,
}

impl Placed {
    /// A point of the body in the world.
    #[must_use]
    pub fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = (libm::sin(self.yaw), libm::cos(self.yaw));
        [self.at[0] + x * cos - y * sin, self.at[1] + x * sin + y * cos]
    }
}

impl Outline {
    /// A rectangle around the origin, length by width (m).
    #[must_use]
    pub fn rectangle(length: f64, width: f64) -> Self {
        Self { parts: vec![OutlinePart::Polygon(corners(length, width, [0.0; 2], 0.0))] }
    }

    /// Least and greatest corner (m).
    #[must_use]
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for part in &self.parts {
            let (points, more) = match part {
                OutlinePart::Polygon(points) => (points.as_slice(), 0.0),
                OutlinePart::Circle(centre, radius) => (std::slice::from_ref(centre), *radius),
            };
            for point in points {
                for axis in 0..2 {
                    low[axis] = low[axis].min(point[axis] - more);
                    high[axis] = high[axis].max(point[axis] + more);
                }
            }
        }
        [low, high]
    }

    /// Length and width (m).
    #[must_use]
    pub fn size(&self) -> [f64; 2] {
        let [low, high] = self.bounds();
        [high[0] - low[0], high[1] - low[1]]
    }

    /// The middle of its bounds, in its own frame (m).
    #[must_use]
    pub fn middle(&self) -> [f64; 2] {
        let [low, high] = self.bounds();
        [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])]
    }

    /// Whether it is one circle.
    #[must_use]
    pub fn is_round(&self) -> bool {
        matches!(self.parts.as_slice(), [OutlinePart::Circle(..)])
    }

    /// The greatest distance of any of its points from the origin (m).
    pub(crate) fn reach(&self) -> f64 {
        let [low, high] = self.bounds();
        libm::hypot(low[0].abs().max(high[0].abs()), low[1].abs().max(high[1].abs()))
    }

    /// The same, turned around the origin (rad).
    pub(crate) fn turned(&self, by: f64) -> Self {
        Self { parts: self.placed(Placed { at: [0.0; 2], yaw: by }) }
    }

    fn placed(&self, place: Placed) -> Vec<OutlinePart> {
        let part = |part: &OutlinePart| match part {
            OutlinePart::Polygon(points) => {
                OutlinePart::Polygon(points.iter().map(|point| place.point(*point)).collect())
            }
            OutlinePart::Circle(centre, radius) => {
                OutlinePart::Circle(place.point(*centre), *radius)
            }
        };
        self.parts.iter().map(part).collect()
    }
}

/// The corners of a rectangle with this middle, turned by `yaw` (rad).
pub(crate) fn corners(length: f64, width: f64, middle: [f64; 2], yaw: f64) -> Vec<[f64; 2]> {
    let place = Placed { at: middle, yaw };
    [[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]]
        .map(|[i, j]| place.point([i * length, j * width]))
        .to_vec()
}

/// Whether two outlines share a point.
#[must_use]
pub fn overlap(a: &Outline, at: Placed, b: &Outline, bt: Placed) -> bool {
    let apart = libm::hypot(bt.at[0] - at.at[0], bt.at[1] - at.at[1]);
    // A thousandth more than they reach together: rounding cannot hide a touch.
    if apart > (a.reach() + b.reach()) * 1.001 {
        return false;
    }
    let (a, b) = (a.placed(at), b.placed(bt));
    a.iter().any(|p| b.iter().any(|q| meet(p, q)))
}

fn meet(p: &OutlinePart, q: &OutlinePart) -> bool {
    match (p, q) {
        (OutlinePart::Circle(a, r), OutlinePart::Circle(b, s)) => {
            libm::hypot(b[0] - a[0], b[1] - a[1]) <= r + s
        }
        (OutlinePart::Circle(centre, radius), OutlinePart::Polygon(polygon))
        | (OutlinePart::Polygon(polygon), OutlinePart::Circle(centre, radius)) => {
            inside(*centre, polygon)
                || edges(polygon).any(|edge| distance(*centre, edge) <= *radius)
        }
        (OutlinePart::Polygon(p), OutlinePart::Polygon(q)) => {
            edges(p).any(|e| edges(q).any(|f| cross(e, f)))
                || p.first().is_some_and(|point| inside(*point, q))
                || q.first().is_some_and(|point| inside(*point, p))
        }
    }
}

fn edges(polygon: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(a, b)| [*a, *b])
}

/// Whether a point lies inside a polygon: crossings of a ray to the right are odd.
fn inside(point: [f64; 2], polygon: &[[f64; 2]]) -> bool {
    let crosses = |[a, b]: [[f64; 2]; 2]| {
        (a[1] > point[1]) != (b[1] > point[1])
            && point[0] < a[0] + (b[0] - a[0]) * (point[1] - a[1]) / (b[1] - a[1])
    };
    edges(polygon).filter(|edge| crosses(*edge)).count() % 2 == 1
}

/// Distance of a point from a segment (m).
pub(crate) fn distance(point: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let (u, v) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
    let squared = u[0] * u[0] + u[1] * u[1];
    let share =
        if squared > 0.0 { ((u[0] * v[0] + u[1] * v[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    libm::hypot(v[0] - share * u[0], v[1] - share * u[1])
}

/// Twice the signed area of a triangle (m²).
pub(crate) fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether two segments share a point.
fn cross([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let within = |p: [f64; 2], [a, b]: [[f64; 2]; 2]| {
        (0..2).all(|i| p[i] >= a[i].min(b[i]) && p[i] <= a[i].max(b[i]))
    };
    let (p, q) = (turn(a, b, c), turn(a, b, d));
    let (r, s) = (turn(c, d, a), turn(c, d, b));
    let proper = (p > 0.0) != (q > 0.0) && (r > 0.0) != (s > 0.0);
    let sides = p != 0.0 && q != 0.0 && r != 0.0 && s != 0.0;
    if sides {
        return proper;
    }
    (p == 0.0 && within(c, [a, b]))
        || (q == 0.0 && within(d, [a, b]))
        || (r == 0.0 && within(a, [c, d]))
        || (s == 0.0 && within(b, [c, d]))
        || (proper && (p != 0.0 || q != 0.0) && (r != 0.0 || s != 0.0))
}

#[cfg(test)]
mod tests;
