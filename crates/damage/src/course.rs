//! The course of a candidate: what happens to the ego from one contact to the next, and the harm of
//! all contacts together.
//!
//! A contact is *light* if it changes the ego's motion little: then the ego drives on along its
//! path. A *heavy* one ends the path, and a run-out follows: straight along the velocity after the
//! impact, braked to rest, with the yaw kept. Nominal figures decide; ranges assess the contacts
//! again and never change the course. (J. Kudlich, H. Slibar: impact and run-out as separate
//! phases.) No crash test with figures of every contact was found: this is not validated.
//!
//! It does not know who is where: [`crate::assess()`] makes the harm of one contact.

use crate::assess::Risk;
use crate::harm::CandidateHarm;
use crate::interval::{Interval, Range};
use crate::party::PersonId;
use crate::rank::Assessed;
use crate::rule::Others;
use geometry::DVec3;
use schemars::JsonSchema;
use serde::Serialize;

/// From this change of the ego's velocity on contact is heavy (m/s): about what triggers the event
/// recorder of a car.
pub const HEAVY_M_S: f64 = 2.2;
/// Deceleration of a run-out (m/s²): half of gravity ...
pub const RUN_OUT_M_S2: f64 = 0.5 * 9.806_65;
/// ... within the 0.3 to 0.7 of crashed cars.
pub const RUN_OUT_RANGE_M_S2: [f64; 2] = [0.3 * 9.806_65, 0.7 * 9.806_65];
/// A longer run-out (m) is flagged: on such a way a driver would have done something.
pub const RUN_OUT_LONG_M: f64 = 30.0;
/// After a light contact the search for another one with the same party goes on from this much
/// travel after it (m), or the extent of the smaller body, if that is less.
pub const PASSED_M: f64 = 0.9;
/// Contacts within this time of each other (s) are parts of one crash.
pub const SAME_CRASH_S: f64 = 0.15;

/// How a contact changes the ego's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// Little: it drives on.
    Light,
    /// It leaves its path.
    Heavy,
}

impl Severity {
    /// By the nominal change of the ego's velocity, and whether its range crosses the threshold.
    #[must_use]
    pub fn of(harm: &CandidateHarm) -> (Self, bool) {
        let ego = &harm.delta_v[0];
        let severity = if ego.work.hi() >= HEAVY_M_S { Self::Heavy } else { Self::Light };
        (severity, ego.range.low() < HEAVY_M_S && HEAVY_M_S <= ego.range.high())
    }
}

/// The motion of the ego after a heavy contact: straight, braked to rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RunOut {
    /// Velocity after the impact, horizontal, in the world (m/s).
    pub velocity_m_s: [f64; 2],
    /// Its deceleration (m/s²), above 0.
    pub deceleration_m_s2: f64,
}

impl RunOut {
    /// From the velocity before the impact, the impulse on the ego (N s), both in the world, and
    /// the ego's mass (kg); with [`RUN_OUT_M_S2`].
    #[must_use]
    pub fn after(velocity_m_s: DVec3, impulse_n_s: DVec3, mass_kg: f64) -> Self {
        let after = velocity_m_s + impulse_n_s * (1.0 / mass_kg);
        Self { velocity_m_s: [after.x + 0.0, after.y + 0.0], deceleration_m_s2: RUN_OUT_M_S2 }
    }

    /// The same, turned to the left (degrees), with the deceleration at this share of its range.
    #[must_use]
    pub fn drawn(&self, turn_deg: f64, share: f64) -> Self {
        let (sin, cos) = libm::sincos(turn_deg.to_radians());
        let ([x, y], [least, most]) = (self.velocity_m_s, RUN_OUT_RANGE_M_S2);
        Self {
            velocity_m_s: [x * cos - y * sin, x * sin + y * cos],
            deceleration_m_s2: least + (most - least) * share,
        }
    }

    /// Speed at its begin (m/s).
    #[must_use]
    pub fn speed_m_s(&self) -> f64 {
        let [x, y] = self.velocity_m_s;
        libm::sqrt(x * x + y * y)
    }

    /// How long it lasts (s).
    #[must_use]
    pub fn lasts_s(&self) -> f64 {
        self.speed_m_s() / self.deceleration_m_s2
    }

    /// How long it is (m).
    #[must_use]
    pub fn length_m(&self) -> f64 {
        0.5 * self.speed_m_s() * self.lasts_s()
    }

    /// How far the ego has come after some time (s), in the world (m).
    #[must_use]
    pub fn travel_m(&self, after_s: f64) -> [f64; 2] {
        let t = after_s.clamp(0.0, self.lasts_s());
        let speed = self.speed_m_s();
        if speed <= 0.0 {
            return [0.0; 2];
        }
        let length = speed * t - 0.5 * self.deceleration_m_s2 * t * t;
        self.velocity_m_s.map(|v| v * (length / speed))
    }
}

/// The harm of all contacts of a candidate together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CourseHarm {
    /// Everybody who is in any contact, ascending by number.
    pub persons: Vec<Risk>,
    /// Energy lost in all contacts (J).
    pub energy_j: Interval,
    /// Persons who may be there besides those at stake, and the upper ends of the model range of
    /// those of them who are in a contact, summed.
    pub others: Others,
    /// Work is still open.
    pub is_open: bool,
    /// A contact cannot be evaluated.
    pub is_unevaluable: bool,
}

/// The probability that at least one of two independent events happens; the other one itself, to
/// the bit, where one is impossible.
fn either(p: f64, q: f64) -> f64 {
    if p == 0.0 { q } else { (p + q * (1.0 - p)).clamp(p.max(q), 1.0) }
}

impl CourseHarm {
    /// The harm of a course without contact.
    #[must_use]
    pub fn none() -> Self {
        Self::default()
    }

    /// Includes a contact. A person's risks combine as 1 − Π(1 − R), as if the contacts were
    /// independent; the model range reaches from the greatest of them to their sum.
    pub fn include(&mut self, harm: &CandidateHarm) {
        for person in &harm.persons {
            let next = Risk::of(person);
            let at = self.persons.partition_point(|risk| risk.id < next.id);
            match self.persons.get_mut(at).filter(|risk| risk.id == next.id) {
                Some(risk) => *risk = combined(risk, &next),
                None => self.persons.insert(at, next),
            }
        }
        let (before, more) = (self.energy_j, harm.energy_j);
        self.energy_j = Interval::new(before.lo() + more.lo(), before.hi() + more.hi());
        self.is_open |= harm.is_open;
        self.is_unevaluable |= harm.unevaluable.is_some();
    }

    /// Adds what a contact does to a person: exactly this risk.
    pub fn add(&mut self, id: PersonId, risk: f64) {
        let work = Interval::exactly(risk);
        let next = Risk { id, work, range: Range::new(risk, risk), high: work };
        let at = self.persons.partition_point(|risk| risk.id < id);
        match self.persons.get_mut(at).filter(|risk| risk.id == id) {
            Some(risk) => *risk = combined(risk, &next),
            None => self.persons.insert(at, next),
        }
    }

    /// Leaves open whatever else may happen to some persons, and that `energy_j` more may be lost.
    pub fn leave_open(&mut self, persons: impl Iterator<Item = PersonId>, energy_j: f64) {
        self.is_open = true;
        self.energy_j = Interval::new(self.energy_j.lo(), self.energy_j.hi() + energy_j);
        for id in persons {
            let at = self.persons.partition_point(|risk| risk.id < id);
            if self.persons.get(at).is_none_or(|risk| risk.id != id) {
                let zero = (Interval::ZERO, Range::ZERO);
                let risk = Risk { id, work: zero.0, range: zero.1, high: zero.0 };
                self.persons.insert(at, risk);
            }
            let risk = &mut self.persons[at];
            risk.work = Interval::new(risk.work.lo(), 1.0);
            risk.range = Range::new(risk.range.low(), 1.0);
            risk.high = Interval::new(risk.high.lo(), 1.0);
        }
    }

    /// Takes for possible that nobody is there whom a number names.
    pub fn suppose(&mut self, id: PersonId) {
        if let Some(risk) = self.persons.iter_mut().find(|risk| risk.id == id) {
            risk.range = Range::new(0.0, risk.range.high());
        }
    }

    /// The risk of a person, if in any contact.
    #[must_use]
    pub fn risk_of(&self, id: PersonId) -> Option<&Risk> {
        self.persons.binary_search_by_key(&id, |risk| risk.id).ok().map(|at| &self.persons[at])
    }
}

fn combined(a: &Risk, b: &Risk) -> Risk {
    let sum = |p: f64, q: f64| (p + q).min(1.0);
    let work = Interval::new(either(a.work.lo(), b.work.lo()), either(a.work.hi(), b.work.hi()));
    let (low, high) = (a.range.low().max(b.range.low()), sum(a.range.high(), b.range.high()));
    Risk {
        id: a.id,
        work,
        range: Range::new(low, high).around(work),
        high: Interval::new(sum(a.high.lo(), b.high.lo()), sum(a.high.hi(), b.high.hi())),
    }
}

impl Assessed for CourseHarm {
    fn probability(&self) -> f64 {
        1.0
    }

    fn energy_j(&self) -> Interval {
        self.energy_j
    }

    fn risks(&self) -> impl Iterator<Item = Risk> {
        self.persons.iter().copied()
    }

    fn others(&self) -> Others {
        self.others
    }

    fn is_done(&self) -> bool {
        let are_settled = self.persons.iter().all(|risk| risk.work.is_settled());
        !self.is_unevaluable && !self.is_open && are_settled && self.energy_j.is_settled()
    }

    fn is_unevaluable(&self) -> bool {
        self.is_unevaluable
    }
}

#[cfg(test)]
mod tests;
