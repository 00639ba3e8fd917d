//! Motions: two cars that drive and turn for three seconds, known every tenth of a second.
//!
//! - `far`: B, on an arc of its own, is at some time 12 to 25 m beside A.
//! - `contact`: at some time both would stand within each other.
//! - `near`: an oncoming car on an arc of its own is for a moment some decimetres beside A.
//! - `slide`: B is beside A all the time, turned by 7 degrees, centimetres from its flank, and
//!   gains or loses little on it.
//!
//! Whether they touch is not known beforehand.

use super::scene::Scene;
use core::f64::consts::PI;
use geometry::Corners;
use geometry::motion::{MotionPath, Orientation, RelativeMotion, State};
use geometry::rng::Rng;

/// The kinds, and how many motions there are of each.
pub(crate) const KINDS: &[&str] = &["far", "contact", "near", "slide"];
const OF_EACH: u64 = 16;

const LASTS_S: f64 = 3.0;
const STATES: u32 = 30;

/// Two cars, and how they move.
pub(crate) struct Cars {
    pub(crate) a: Vec<Corners>,
    pub(crate) b: Vec<Corners>,
    pub(crate) motions: Vec<Motion>,
}

/// Two paths that cover the same time.
pub(crate) struct Motion {
    pub(crate) kind: &'static str,
    paths: [MotionPath; 2],
}

impl Cars {
    /// Of so many triangles each, by a name of a [`Scene`].
    pub(crate) fn named(name: &str) -> Self {
        let Scene { a, b, .. } = Scene::named(name);
        let half_m = [&a, &b].map(|body| {
            let corners = body.iter().flatten();
            corners.map(|corner| f64::from(corner[1]).abs()).fold(0.0, f64::max)
        });
        let mut rng = Rng::new(7);
        let kinds = KINDS.iter().flat_map(|kind| (0..OF_EACH).map(move |_| *kind));
        let motions = kinds.map(|kind| Motion::of(kind, &mut rng, half_m[0] + half_m[1])).collect();
        Self { a, b, motions }
    }
}

impl Motion {
    /// A motion of cars whose flanks touch where their middles are `widths_m` apart.
    fn of(kind: &'static str, rng: &mut Rng, widths_m: f64) -> Self {
        let a = Arc { at: [0.0; 3], speed: rng.between(5.0, 20.0), rate: rng.between(-0.3, 0.3) };
        let meet_s = rng.between(0.5, 2.5);
        let (x, y, yaw) = match kind {
            "far" => (rng.between(-30.0, 30.0), rng.between(12.0, 25.0), rng.between(-3.1, 3.1)),
            "contact" => (rng.between(-2.0, 2.0), rng.between(-0.8, 0.8), rng.between(-3.1, 3.1)),
            "near" => (
                rng.between(-1.0, 1.0),
                widths_m + rng.between(0.0, 0.4),
                PI + rng.between(-0.15, 0.15),
            ),
            _ => (rng.between(-1.0, 1.0), widths_m + rng.between(-0.05, 0.1), 0.12),
        };
        let gains_m_s = rng.between(-2.0, 2.0);
        let b = Arc { speed: rng.between(5.0, 20.0), rate: rng.between(-0.3, 0.3), at: [0.0; 3] };
        let of_b = |time_s: f64| match kind {
            // Both turn about the same centre: what is beside the other one stays there.
            "slide" => beside(a.at(time_s), [x + gains_m_s * (time_s - meet_s), y, yaw]),
            _ => Arc { at: beside(a.at(meet_s), [x, y, yaw]), ..b }.at(time_s - meet_s),
        };
        Self { kind, paths: [path(|time_s| a.at(time_s)), path(of_b)] }
    }

    pub(crate) fn relative(&self) -> RelativeMotion<'_> {
        let [a, b] = &self.paths;
        RelativeMotion::new(a, b).expect("both cover the same time")
    }
}

/// A steady drive on an arc: where it is at time 0 (x, y, yaw), m/s and rad/s.
#[derive(Clone, Copy)]
struct Arc {
    at: [f64; 3],
    speed: f64,
    rate: f64,
}

impl Arc {
    fn at(&self, time_s: f64) -> [f64; 3] {
        let [x, y, yaw] = self.at;
        let (radius, then) = (self.speed / self.rate, yaw + self.rate * time_s);
        let (sin, cos) = yaw.sin_cos();
        let (sin_then, cos_then) = then.sin_cos();
        [x + radius * (sin_then - sin), y - radius * (cos_then - cos), then]
    }
}

/// What is at `at` in a frame that is at `frame`: x, y (m), yaw (rad).
fn beside([x, y, yaw]: [f64; 3], at: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = yaw.sin_cos();
    [x + cos * at[0] - sin * at[1], y + sin * at[0] + cos * at[1], yaw + at[2]]
}

fn path(at: impl Fn(f64) -> [f64; 3]) -> MotionPath {
    let state = |number: u32| {
        let time_s = LASTS_S * f64::from(number) / f64::from(STATES);
        let [x, y, yaw] = at(time_s);
        let orientation = Orientation::from_degrees(yaw.to_degrees(), 0.0, 0.0);
        State { time_s, position_m: [x, y, 0.0], orientation }
    };
    MotionPath::new(&(0..=STATES).map(state).collect::<Vec<_>>()).expect("a slow drive")
}
