//! How B comes towards A at the moment of first contact: velocities, and the bodies' extents.
//!
//! Everything is in A's frame, in metres. B moves at constant relative velocity, without turning:
//! at travel s it stands `u·s` before its given place, so s grows with time and with depth, and s =
//! 0 is first contact. Extents are supports along the 72 directions of [`geometry::Directions`]:
//! nothing here depends on a mesh or a job.

use geometry::{DVec3, Directions, Supports};
use std::sync::LazyLock;

/// Number of horizontal directions; direction `i` stands `5°·i` from u.
pub const HORIZONTAL: usize = 72;
/// Quarter of a turn, in directions.
pub const QUARTER: usize = HORIZONTAL / 4;
/// The direction upwards, and the one after it downwards.
pub const UP: usize = HORIZONTAL;
/// Below this closing speed u leads from A's centre to B's (m/s).
pub const STANDSTILL_M_S: f64 = 0.1;

/// What rounding may move a point of contact, or a support, by at most (m): far above it, for
/// bodies within 1000 km, and far below anything that matters.
pub const ROUNDING_M: f64 = 1e-7;

/// Two bodies and their relative motion, in A's frame, at the given pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Approach {
    /// The directions around u, the unit vector of the horizontal relative velocity v_A − v_B.
    pub directions: Directions,
    /// Horizontal v_A − v_B of the centres of mass (m/s).
    pub velocity_m_s: DVec3,
    /// Its length (m/s).
    pub closing_m_s: f64,
    /// Yaw rates of A and of B (rad/s), positive to the left.
    pub yaw_rad_s: [f64; 2],
    /// Supports of the whole body A.
    pub supports_a: Supports,
    /// Supports of the whole body B at the given pose, in A's frame.
    pub supports_b: Supports,
}

/// An approach that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ApproachError {
    /// A velocity or a yaw rate is not finite.
    #[error("closing speed or yaw rate is not a finite number: check both motions")]
    Speed,
    /// A body has no points, or points at infinity.
    #[error("body {0} has no finite extent: check its model and its pose")]
    Extent(char),
}

/// How many steps of 5° direction `i` stands away from u, at most 36.
#[must_use]
pub fn turn(i: usize) -> usize {
    let i = i % HORIZONTAL;
    i.min(HORIZONTAL - i)
}

/// The cosine of the angle between u and direction `i`, the same bits on both sides of u, and exact
/// at the quarters.
#[must_use]
pub fn cosine(i: usize) -> f64 {
    /// Indexed by [`turn`]: bounds need all of them after every result.
    static COSINES: LazyLock<[f64; HORIZONTAL / 2 + 1]> = LazyLock::new(|| {
        core::array::from_fn(|t| match t {
            QUARTER => 0.0,
            t if t > QUARTER => -cosine_of_acute(2 * QUARTER - t),
            t => cosine_of_acute(t),
        })
    });
    COSINES[turn(i)]
}

/// The cosine of `5°·t` for t below [`QUARTER`].
fn cosine_of_acute(t: usize) -> f64 {
    libm::cos((5.0 * t as f64).to_radians())
}

/// The direction that u-relative direction `i` opposes.
#[must_use]
pub fn opposite(i: usize) -> usize {
    (i + HORIZONTAL / 2) % HORIZONTAL
}

/// The horizontal direction in which B is met, as a unit vector in A's frame.
///
/// That of `relative_velocity` (v_A − v_B, A's frame), or, below [`STANDSTILL_M_S`], of
/// `centre_to_centre` (from A's to B's); `up` is the world's vertical in A's frame. Where both are
/// vertical or not finite, any horizontal direction.
#[must_use]
pub fn heading(relative_velocity: DVec3, centre_to_centre: DVec3, up: DVec3) -> DVec3 {
    let level = |v: DVec3| v - up * v.dot(up);
    let v = level(relative_velocity);
    let chosen = if v.length() < STANDSTILL_M_S { level(centre_to_centre) } else { v };
    let unit = chosen * (1.0 / chosen.length());
    if unit.is_finite() {
        return unit;
    }
    let side = level(if up.x.abs() < 0.5 { DVec3::X } else { DVec3::Y });
    side * (1.0 / side.length())
}

impl Approach {
    /// Checks what everything below relies on.
    ///
    /// # Errors
    ///
    /// If the speed or a support is not finite, the speed is negative, or a body has no points.
    pub fn check(&self) -> Result<(), ApproachError> {
        let is_sound = self.closing_m_s >= 0.0 && self.closing_m_s.is_finite();
        let is_finite =
            self.velocity_m_s.is_finite() && self.yaw_rad_s.iter().all(|rate| rate.is_finite());
        if !(is_sound && is_finite) {
            return Err(ApproachError::Speed);
        }
        for (body, supports) in [('A', &self.supports_a), ('B', &self.supports_b)] {
            if !supports.0.iter().all(|s| s.is_finite()) {
                return Err(ApproachError::Extent(body));
            }
        }
        Ok(())
    }

    /// How far (m) the hulls overlap along horizontal direction `i` after `travel_m`; negative if
    /// they are apart. It is `max over A of x·d − min over B of x·d`.
    #[must_use]
    pub fn penetration(&self, i: usize, travel_m: f64) -> f64 {
        self.supports_a.0[i] + self.supports_b.0[opposite(i)] + travel_m * cosine(i)
    }

    /// Extent of the smaller body along u (m).
    #[must_use]
    pub fn smaller_extent(&self) -> f64 {
        let extent = |s: &Supports| s.0[0] + s.0[opposite(0)];
        extent(&self.supports_a).min(extent(&self.supports_b))
    }

    /// Whether bodies that overlap at the given pose come further into each other, instead of
    /// parting: along the direction in which their hulls overlap least. At a standstill neither.
    #[must_use]
    pub fn is_closing(&self) -> bool {
        let least = (0..HORIZONTAL).min_by(|i, j| {
            let depth = |i: usize| self.penetration(i, 0.0);
            depth(*i).total_cmp(&depth(*j)).then(turn(*i).cmp(&turn(*j)))
        });
        self.closing_m_s > 0.0 && least.is_some_and(|i| turn(i) < QUARTER)
    }

    /// The extent of the smaller body along u (m), at most `most_m`.
    #[must_use]
    pub fn extent_up_to(&self, most_m: f64) -> f64 {
        self.smaller_extent().min(most_m)
    }

    /// Supports of everything that contact between travels `from` and `to` could reach, as
    /// [`crate::Evidence`] holds it: no further out than A, and no further out than B, but for
    /// [`ROUNDING_M`].
    #[must_use]
    pub fn reach(&self, from_m: f64, to_m: f64) -> Supports {
        let mut reach = Supports::EMPTY;
        for (i, support) in reach.0.iter_mut().enumerate() {
            let shift = |s: f64| if i < HORIZONTAL { 0.5 * s * cosine(i) } else { 0.0 };
            let a = self.supports_a.0[i] + shift(from_m).max(shift(to_m));
            let b = self.supports_b.0[i] - shift(from_m).min(shift(to_m));
            *support = a.min(b) + ROUNDING_M;
        }
        reach
    }

    /// Supports of everything that contact at one travel could reach, in A's frame at that pose.
    #[must_use]
    pub fn reach_at(&self, travel_m: f64) -> Supports {
        let mut reach = Supports::EMPTY;
        for (i, support) in reach.0.iter_mut().enumerate() {
            let moved = if i < HORIZONTAL { travel_m * cosine(i) } else { 0.0 };
            *support = self.supports_a.0[i].min(self.supports_b.0[i] - moved) + ROUNDING_M;
        }
        reach
    }
}

#[cfg(test)]
mod tests;
