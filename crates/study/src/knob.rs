//! What a sweep varies, each as a change of a scenario's text: so that what a study ranks is a
//! scenario that anybody can write out and rank.
//!
//! Values are SI units; angles in the text are degrees. Nothing is changed where a value is that of
//! the scene as given ([`SweepKnob::given`]).

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

mod motion;

use motion::{number, real};

/// What is swept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SweepKnob {
    /// The ego's speed: a factor on it, on the same ways.
    Speed,
    /// How far the ego is to its left of where it is given (m), on all its ways.
    #[serde(rename = "offset_m")]
    Offset,
    /// How much later the ego begins each way (s): until then it goes straight on as it moves at 0,
    /// and the way begins where it is then.
    #[serde(rename = "reaction_s")]
    Reaction,
    /// Where the others really are: so many of their stated standard deviations ahead, to their
    /// left, and faster than they are perceived.
    ErrorSigma,
    /// How well everybody is known: a factor on all standard deviations, of which members are
    /// drawn.
    Errors,
}

/// Standard deviations where a party states none: [`scenario::Errors::usual`].
const ERRORS: [&str; 4] = ["lateral_m", "longitudinal_m", "yaw_deg", "speed_share"];
/// The greatest that a scenario may state.
const ERRORS_MAX: [f64; 4] = [10.0, 10.0, 90.0, 0.5];

/// The horizon where a scenario states none (s).
const HORIZON_S: f64 = 5.0;

impl SweepKnob {
    /// All, in the order of [`SweepKnob`]'s variants.
    pub const ALL: [Self; 5] =
        [Self::Speed, Self::Offset, Self::Reaction, Self::ErrorSigma, Self::Errors];

    /// Returns the name, as a specification and the tables write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Offset => "offset_m",
            Self::Reaction => "reaction_s",
            Self::ErrorSigma => "error_sigma",
            Self::Errors => "errors",
        }
    }

    /// Returns what it is, with its unit, as an axis says it.
    #[must_use]
    pub fn says(self) -> &'static str {
        match self {
            Self::Speed => "speed of the ego, × as given",
            Self::Offset => "ego further left, m",
            Self::Reaction => "reaction later, s",
            Self::ErrorSigma => "others elsewhere than perceived, σ",
            Self::Errors => "errors of perception, × as stated",
        }
    }

    /// Returns the value of the scene as given.
    #[must_use]
    pub fn given(self) -> f64 {
        match self {
            Self::Speed | Self::Errors => 1.0,
            Self::Offset | Self::Reaction | Self::ErrorSigma => 0.0,
        }
    }

    /// The range in which it makes sense.
    pub(crate) fn limits(self) -> [f64; 2] {
        match self {
            Self::Speed => [0.1, 3.0],
            Self::Offset => [-50.0, 50.0],
            Self::Reaction => [0.0, 10.0],
            Self::ErrorSigma => [-5.0, 5.0],
            Self::Errors => [0.0, 10.0],
        }
    }

    /// Changes a scenario; an error says what in it cannot be changed so.
    pub(crate) fn set(self, value: f64, scenario: &mut Table) -> Result<(), String> {
        if value == self.given() {
            return Ok(());
        }
        match self {
            Self::Speed => each_way(scenario, |way| motion::faster(way, value)),
            Self::Offset => each_way(scenario, |way| {
                let yaw_rad = motion::begin(way)?.yaw_rad;
                motion::moved(way, [-value * libm::sin(yaw_rad), value * libm::cos(yaw_rad)])
            }),
            Self::Reaction => {
                let horizon_s = scenario.get("horizon_s").and_then(number).unwrap_or(HORIZON_S);
                each_way(scenario, |way| motion::later(way, value, horizon_s))
            }
            Self::ErrorSigma => elsewhere(scenario, value),
            Self::Errors => {
                let ego = ego(scenario);
                for (name, party) in parties(scenario) {
                    let stated = errors(party, *name == ego);
                    let stated = stated.map(|sigma| sigma * value);
                    let capped = [0, 1, 2, 3].map(|k| stated[k].min(ERRORS_MAX[k]));
                    let table = party.entry("errors").or_insert_with(|| Table::new().into());
                    let table = table.as_table_mut().ok_or("errors is no table")?;
                    for (key, sigma) in ERRORS.into_iter().zip(capped) {
                        table.insert(key.to_owned(), real(sigma));
                    }
                }
                Ok(())
            }
        }
    }
}

/// The name of the ego.
fn ego(scenario: &Table) -> String {
    scenario.get("ego").and_then(Value::as_str).unwrap_or("ego").to_owned()
}

/// All parties that are tables.
fn parties(scenario: &mut Table) -> impl Iterator<Item = (&String, &mut Table)> {
    let parties = scenario.get_mut("parties").and_then(Value::as_table_mut);
    parties.into_iter().flatten().filter_map(|(name, party)| Some((name, party.as_table_mut()?)))
}

/// Changes every way of the ego.
fn each_way(
    scenario: &mut Table,
    change: impl Fn(&mut Table) -> Result<(), String>,
) -> Result<(), String> {
    let candidates = scenario.get_mut("candidates").and_then(Value::as_array_mut);
    for candidate in candidates.into_iter().flatten().filter_map(Value::as_table_mut) {
        let name = candidate.get("name").and_then(Value::as_str).unwrap_or("").to_owned();
        change(candidate).map_err(|fault| format!("candidate \"{name}\": {fault}"))?;
    }
    Ok(())
}

/// Standard deviations of a party, in the order of [`ERRORS`].
fn errors(party: &Table, is_ego: bool) -> [f64; 4] {
    let usual = scenario::Errors::usual(is_ego);
    let usual = [usual.lateral_m, usual.longitudinal_m, usual.yaw_deg, usual.speed_share];
    let stated = party.get("errors").and_then(Value::as_table);
    let stated = |key: &str| stated.and_then(|table| number(table.get(key)?));
    [0, 1, 2, 3].map(|k| stated(ERRORS[k]).unwrap_or(usual[k]))
}

/// Puts everybody but the ego elsewhere, and lets them go faster.
fn elsewhere(scenario: &mut Table, sigmas: f64) -> Result<(), String> {
    let ego = ego(scenario);
    let mut shifts: Vec<(String, Shift)> = Vec::new();
    for (name, party) in parties(scenario) {
        if *name == ego {
            continue;
        }
        let [lateral_m, longitudinal_m, _, speed_share] = errors(party, false);
        let mut shift = Shift {
            ahead_m: sigmas * longitudinal_m,
            left_m: sigmas * lateral_m,
            speed: libm::exp(sigmas * speed_share),
        };
        // A fixed object has no speed, and a member no other one either.
        if party.contains_key("place") {
            shift.speed = 1.0;
        }
        let failed = |fault: String| format!("party \"{name}\": {fault}");
        match party.get_mut("paths").and_then(Value::as_array_mut) {
            None => shift.apply(party).map_err(failed)?,
            Some(paths) => {
                for path in paths.iter_mut().filter_map(Value::as_table_mut) {
                    shift.apply(path).map_err(failed)?;
                }
            }
        }
        shifts.push((name.clone(), shift));
    }
    each_way(scenario, |candidate| {
        let reactions = candidate.get_mut("reactions").and_then(Value::as_table_mut);
        for (party, motion) in reactions.into_iter().flatten() {
            let shift = shifts.iter().find(|(name, _)| name == party);
            if let (Some((_, shift)), Some(motion)) = (shift, motion.as_table_mut()) {
                shift.apply(motion).map_err(|fault| format!("party \"{party}\": {fault}"))?;
            }
        }
        Ok(())
    })
}

/// How one party differs from what is perceived.
struct Shift {
    ahead_m: f64,
    left_m: f64,
    speed: f64,
}

impl Shift {
    /// Applies it to a table that holds a motion: a place, a state, or states.
    fn apply(&self, motion: &mut Table) -> Result<(), String> {
        let yaw_rad = motion::begin(motion)?.yaw_rad;
        let (sin, cos) = (libm::sin(yaw_rad), libm::cos(yaw_rad));
        let by = [self.ahead_m * cos - self.left_m * sin, self.ahead_m * sin + self.left_m * cos];
        motion::moved(motion, by)?;
        if self.speed == 1.0 { Ok(()) } else { motion::faster(motion, self.speed) }
    }
}

#[cfg(test)]
mod tests;
