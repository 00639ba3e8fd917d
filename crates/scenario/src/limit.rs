//! The ranges of all numbers in a scenario, each with its reason, in one place.
//!
//! Parser and JSON Schema read the same constants, so they cannot disagree. Both ends are allowed.

use crate::error::Misfit;

/// A closed range of values and its unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limit<T> {
    pub(crate) least: T,
    pub(crate) most: T,
    /// With a leading space, or empty.
    pub(crate) unit: &'static str,
}

const fn limit<T: Copy>(least: T, most: T, unit: &'static str) -> Limit<T> {
    Limit { least, most, unit }
}

/// A microsecond to an hour: no message is faster, and no caller waits longer.
pub(crate) const DEADLINE_MS: Limit<f64> = limit(0.001, 3_600_000.0, " ms");
/// A f32 mesh 1,000 km from the origin still fits an f64 pose to a nanometre; beyond lies a wrong
/// unit.
pub(crate) const POSITION_M: Limit<f64> = limit(-1e6, 1e6, " m");
/// One turn either way.
pub(crate) const YAW_DEG: Limit<f64> = limit(-360.0, 360.0, "°");
/// Beyond 90° a pitch is another yaw and roll.
pub(crate) const PITCH_DEG: Limit<f64> = limit(-90.0, 90.0, "°");
/// Half a turn either way: on its roof.
pub(crate) const ROLL_DEG: Limit<f64> = limit(-180.0, 180.0, "°");
/// A hand to the longest train at a platform: beyond lies a wrong unit.
pub(crate) const SIZE_M: Limit<f64> = limit(0.05, 500.0, " m");
/// A toy to a goods train: beyond lies a wrong unit.
pub(crate) const MASS_KG: Limit<f64> = limit(0.1, 1e6, " kg");
/// From paper to a locomotive; published cars have 20,000 to 100,000.
pub(crate) const CRUSH_A: Limit<f64> = limit(0.0, 1e8, " N/m");
/// Published cars have 200,000 to 2,000,000; below 1,000 crush would be longer than any body.
pub(crate) const CRUSH_B: Limit<f64> = limit(1e3, 1e10, " N/m²");
/// A probability.
pub(crate) const SHARE: Limit<f64> = limit(0.0, 1.0, "");
/// What the generator can shape (500) and what a model may hold (1,000,000).
pub(crate) const TRIANGLES: Limit<i64> = limit(500, 1_000_000, "");
/// TOML's whole numbers end at 2⁶³ − 1.
pub(crate) const SEED: Limit<i64> = limit(0, i64::MAX, "");
/// Four for a quad-core computer; 16 bounds status page and pools.
pub(crate) const WORKERS: Limit<i64> = limit(1, 16, "");
/// The size of the kernel's `cpu_set_t`.
pub(crate) const CORE: Limit<i64> = limit(0, 1023, "");
/// A front at depth 20 has up to 4²⁰ pairs on paper; real bodies end long before.
pub(crate) const DEPTH: Limit<i64> = limit(0, 20, "");
/// 256 jobs of 32 bytes are 8 KiB: two pages per message.
pub(crate) const BATCH: Limit<i64> = limit(1, 256, "");
/// Jobs on their way to one worker: bounds its pool of messages.
pub(crate) const QUEUE: Limit<i64> = limit(1, 4096, "");
/// Larger leaves test nearly every pair of triangles by hand.
pub(crate) const LEAF_SIZE: Limit<i64> = limit(1, 64, "");
/// How many candidates a request may hold.
pub(crate) const CANDIDATES: Limit<usize> = limit(1, 16, "");
/// One is the scene as stated; a thousand are more than any planner has time for.
pub(crate) const MEMBERS: Limit<i64> = limit(1, 1024, "");
/// A share of ten thousand worlds is known to half a hundredth.
pub(crate) const WORLDS: Limit<i64> = limit(0, 10_000, "");
/// Exact, to as far as a street is wide: who knows less does not know where it is.
pub(crate) const ERROR_M: Limit<f64> = limit(0.0, 10.0, " m");
/// A quarter turn: who knows less does not know which way it goes.
pub(crate) const ERROR_YAW_DEG: Limit<f64> = limit(0.0, 90.0, "°");
/// From exact to unknown.
pub(crate) const ERROR_SPEED_SHARE: Limit<f64> = limit(0.0, 0.5, "");
/// A correlation.
pub(crate) const CORRELATION: Limit<f64> = limit(-1.0, 1.0, "");
/// What fits a line of a table, in characters.
pub(crate) const NAME_CHARS: Limit<usize> = limit(1, 60, " characters");
/// The longest path that the kernel opens, in bytes.
pub(crate) const PATH_BYTES: Limit<usize> = limit(1, 4095, " bytes");

/// A millisecond, in which nothing happens, to the longest motion that is searched:
/// [`geometry::motion::SPAN_MAX`].
pub(crate) const HORIZON_S: Limit<f64> = limit(0.001, 30.0, " s");
/// Ten times the rounding of a body's corners to the width of a hand: what is further apart than
/// that is no contact.
pub(crate) const RESOLUTION_M: Limit<f64> = limit(1e-5, 0.1, " m");
/// The ego and 32 others: as many as a tracker follows in a dense street.
pub(crate) const PARTIES: Limit<usize> = limit(2, 33, "");
/// Motions that are expected of one party: go on, turn, stop.
pub(crate) const PREDICTIONS: Limit<usize> = limit(1, 3, "");
/// How far the sum of their probabilities may be off 1: four digits of three thirds are not.
pub(crate) const PROBABILITY_SUM_OFF: f64 = 1e-6;
/// States of a path in the scenario itself: a state each half second of the longest horizon.
pub(crate) const PATH_STATES: Limit<usize> = limit(1, 64, "");
/// States of a path in a file of its own: 136 a second for 30 seconds.
pub(crate) const CSV_ROWS: Limit<usize> = limit(1, 4096, "");
/// Longer files of a path are refused unread: 4096 rows of 256 bytes.
pub(crate) const CSV_BYTES_MAX: usize = 1 << 20;
/// An hour either way: a time of day or milliseconds are beyond.
pub(crate) const PATH_TIME_S: Limit<f64> = limit(-3600.0, 3600.0, " s");
/// The least time from one state of a path to the next (s): what is closer is one time, rounded.
pub(crate) const PATH_STEP_S: f64 = 1e-5;
/// A state this close to 0 or to the horizon (s) is taken to be there: times in files are sums of
/// rounded steps. At the greatest speed it makes 0.1 mm. A tenth of [`PATH_STEP_S`], so that no two
/// states come together.
pub(crate) const PATH_SNAP_S: f64 = 1e-6;
/// 360 km/h: faster than a road vehicle that anybody predicts. Beyond, times or positions are
/// wrong, and a body jumps.
pub(crate) const PATH_SPEED_M_S: Limit<f64> = limit(-100.0, 100.0, " m/s");
/// Two turns a second: a car that spins on ice makes one.
pub(crate) const TURN_RATE_DEG_S: Limit<f64> = limit(-720.0, 720.0, "°/s");
/// Ten times what tyres can: speed times yaw rate beyond it has a wrong unit (m/s²). It bounds the
/// pieces of a circle: 3,355 over the longest horizon.
pub(crate) const LATERAL_M_S2: f64 = 100.0;
/// How far a state's velocity may be off that of a piece beside it, whatever the piece (m/s): the
/// noise of a tracker.
pub(crate) const VELOCITY_OFF_M_S: f64 = 5.0;
/// And how much more for each second of the piece (m/s²): twice what the best tyres can.
pub(crate) const VELOCITY_OFF_M_S2: f64 = 20.0;
/// How far the poses at which the motions of one body begin may be apart (m): a digit of a writer
/// who rounds.
pub(crate) const NOW_OFF_M: f64 = 0.001;
/// And how much they may differ in orientation (degrees).
pub(crate) const NOW_OFF_DEG: f64 = 0.1;
/// Persons of a party: as many as a bus has places.
pub(crate) const OCCUPANTS: Limit<i64> = limit(1, 90, "");
/// Persons of a scenario in all: a full bus, and two to each of the others twice over.
pub(crate) const SCENARIO_OCCUPANTS_MAX: u32 = 256;

impl<T: Copy + PartialOrd + Show> Limit<T> {
    /// Whether the value lies within; NaN does not.
    pub(crate) fn holds(&self, value: T) -> bool {
        self.least <= value && value <= self.most
    }

    /// "0 to 20", with the unit.
    pub(crate) fn range(&self) -> String {
        format!("{} to {}{}", self.least.show(), self.most.show(), self.unit)
    }

    /// The value, if it lies within.
    pub(crate) fn check(&self, setting: &'static str, value: T) -> Result<T, Misfit> {
        if self.holds(value) { Ok(value) } else { Err(self.misfit(setting, value)) }
    }

    fn misfit(&self, setting: &'static str, value: T) -> Misfit {
        let fault = format!("{setting} is {}", value.show());
        Misfit::new(setting, fault, format!("{setting} may be {}", self.range()))
    }
}

impl Limit<i64> {
    /// The value as another type of whole number, if it lies within and fits.
    pub(crate) fn whole<T: TryFrom<i64>>(
        &self,
        setting: &'static str,
        value: i64,
    ) -> Result<T, Misfit> {
        T::try_from(self.check(setting, value)?).ok().ok_or_else(|| self.misfit(setting, value))
    }
}

/// A number as a person would write it.
pub(crate) trait Show {
    fn show(&self) -> String;
}

impl Show for f64 {
    fn show(&self) -> String {
        let size = self.abs();
        let plain = size == 0.0 || (1e-4..1e15).contains(&size) || !self.is_finite();
        if plain { format!("{self}") } else { format!("{self:e}") }
    }
}

impl Show for i64 {
    fn show(&self) -> String {
        self.to_string()
    }
}

impl Show for usize {
    fn show(&self) -> String {
        self.to_string()
    }
}
