//! What a map varies: the ego's speed, the odds of injury, and the numbers of a policy.

use crate::Failure;
use damage::injury::Victim;
use damage::policy::{Composition, Step};
use damage::{Curves, Policy};
use scenario::{GivenMotion, live};
use serde::Serialize;

/// A number that is varied.
///
/// ```
/// use trolley::policy::map::MapKnob;
///
/// for knob in MapKnob::ALL {
///     println!("{}: {}", knob.name(), knob.says());
/// }
/// assert_eq!(MapKnob::ALL.len(), 6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MapKnob {
    /// The ego's speed: a factor on it, on the same ways.
    Speed,
    /// A factor on the odds of injury of everybody.
    Odds,
    /// A factor on the odds of injury of those outside of vehicles.
    OddsOutside,
    /// A factor on the odds of injury of those inside of vehicles.
    OddsInside,
    /// The accepted risk of the policy's first precaution.
    Accepted,
    /// The tolerance of the policy's first comparison.
    Tolerance,
}

impl MapKnob {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Speed,
        Self::Odds,
        Self::OddsOutside,
        Self::OddsInside,
        Self::Accepted,
        Self::Tolerance,
    ];

    /// Returns the name, as a command line writes it.
    ///
    /// ```
    /// assert_eq!(trolley::policy::map::MapKnob::OddsOutside.name(), "odds-outside");
    /// ```
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Odds => "odds",
            Self::OddsOutside => "odds-outside",
            Self::OddsInside => "odds-inside",
            Self::Accepted => "accepted",
            Self::Tolerance => "tolerance",
        }
    }

    /// Returns what it is, with its unit, as an axis says it.
    ///
    /// ```
    /// assert_eq!(trolley::policy::map::MapKnob::Speed.says(), "speed of the ego, × as given");
    /// ```
    #[must_use]
    pub fn says(self) -> &'static str {
        match self {
            Self::Speed => "speed of the ego, × as given",
            Self::Odds => "odds of injury, × as in the curves",
            Self::OddsOutside => "odds of injury outside, × as in the curves",
            Self::OddsInside => "odds of injury inside, × as in the curves",
            Self::Accepted => "accepted risk, %",
            Self::Tolerance => "tolerance of the first rule, % points",
        }
    }

    /// Returns whether it is a factor, whose axis is logarithmic and which is 1 as things are.
    ///
    /// ```
    /// use trolley::policy::map::MapKnob;
    ///
    /// assert!(MapKnob::Odds.is_odds() && !MapKnob::Accepted.is_odds());
    /// ```
    #[must_use]
    pub fn is_odds(self) -> bool {
        matches!(self, Self::Odds | Self::OddsOutside | Self::OddsInside)
    }

    /// Its usual range, and the range in which it makes sense.
    fn ranges(self) -> [[f64; 2]; 2] {
        match self {
            Self::Speed => [[0.7, 1.3], [0.1, 3.0]],
            Self::Odds | Self::OddsOutside | Self::OddsInside => [[0.1, 10.0], [1e-3, 1e3]],
            Self::Accepted => [[0.0, 0.3], [0.0, 1.0]],
            Self::Tolerance => [[0.0, 0.05], [0.0, 1.0]],
        }
    }

    /// Its value as things are; `None`: a policy has none.
    pub(super) fn given(self, policy: &Policy) -> Option<f64> {
        match self {
            Self::Speed | Self::Odds | Self::OddsOutside | Self::OddsInside => Some(1.0),
            Self::Accepted => policy.levels.iter().find_map(|step| match step {
                Step::Accept { at_most, .. } => Some(*at_most),
                Step::Least { .. } => None,
            }),
            Self::Tolerance => match &policy.composition {
                Composition::Weighted { tolerance, .. } | Composition::Leximin { tolerance } => {
                    Some(*tolerance)
                }
                Composition::Lexicographic => policy.levels.iter().find_map(|step| match step {
                    Step::Least { tolerance, .. } => Some(*tolerance),
                    Step::Accept { .. } => None,
                }),
            },
        }
    }

    /// Sets it in a scenario, a policy and curves; `None`: no body can do that.
    pub(super) fn set(self, value: f64, all: &mut Varied) -> Option<()> {
        let is_outside = |victim: Victim| {
            matches!(victim, Victim::Pedestrian | Victim::Cyclist | Victim::Motorcyclist)
        };
        match self {
            Self::Speed => return all.faster(value),
            Self::Odds => all.curves = all.curves.with_odds(value, |_| true),
            Self::OddsOutside => all.curves = all.curves.with_odds(value, is_outside),
            Self::OddsInside => {
                all.curves = all.curves.with_odds(value, |victim| !is_outside(victim));
            }
            Self::Accepted => {
                let accepts = all.policy.levels.iter_mut().find_map(|step| match step {
                    Step::Accept { at_most, .. } => Some(at_most),
                    Step::Least { .. } => None,
                });
                *accepts? = value;
            }
            Self::Tolerance => {
                let levels = &mut all.policy.levels;
                let tolerance = match &mut all.policy.composition {
                    Composition::Weighted { tolerance, .. }
                    | Composition::Leximin { tolerance } => Some(tolerance),
                    Composition::Lexicographic => levels.iter_mut().find_map(|step| match step {
                        Step::Least { tolerance, .. } => Some(tolerance),
                        Step::Accept { .. } => None,
                    }),
                };
                *tolerance? = value;
            }
        }
        Some(())
    }
}

/// What is varied.
pub(super) struct Varied {
    pub(super) scenario: scenario::Scenario,
    pub(super) policy: Policy,
    pub(super) curves: Curves,
}

impl Varied {
    /// Lets the ego go the same ways so many times as fast: times shrink, and speeds grow.
    fn faster(&mut self, times: f64) -> Option<()> {
        let horizon_s = self.scenario.horizon_s;
        for candidate in &mut self.scenario.candidates {
            let mut given = candidate.ego.given.clone();
            match &mut given {
                GivenMotion::Place { .. } => {}
                GivenMotion::Onward { velocity_m_s, yaw_rate_deg_s, .. } => {
                    *velocity_m_s = velocity_m_s.map(|speed| speed * times);
                    *yaw_rate_deg_s *= times;
                }
                GivenMotion::States(states) => {
                    for state in states {
                        state.time_s /= times;
                        let faster = |velocity: [f64; 2]| velocity.map(|speed| speed * times);
                        state.velocity_m_s = state.velocity_m_s.map(faster);
                    }
                }
            }
            candidate.ego = live::motion(given, horizon_s, candidate.ego.place).ok()?;
        }
        Some(())
    }
}

/// An axis of a map: what is varied, and from where to where.
///
/// ```
/// use trolley::policy::map::{MapAxis, MapKnob};
///
/// let axis = MapAxis::parse("speed=0.8..1.2")?;
/// assert_eq!((axis.knob, axis.from, axis.to), (MapKnob::Speed, 0.8, 1.2));
/// assert!(MapAxis::parse("odds").is_ok() && MapAxis::parse("odds=2..1").is_err());
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MapAxis {
    /// What is varied.
    pub knob: MapKnob,
    /// Its least value: a factor or a share.
    pub from: f64,
    /// Its greatest value.
    pub to: f64,
}

impl MapAxis {
    /// Returns this knob over its usual range.
    ///
    /// ```
    /// use trolley::policy::map::{MapAxis, MapKnob};
    ///
    /// let axis = MapAxis::usual(MapKnob::Speed);
    /// assert_eq!((axis.from, axis.to), (0.7, 1.3));
    /// ```
    #[must_use]
    pub fn usual(knob: MapKnob) -> Self {
        let [[from, to], _] = knob.ranges();
        Self { knob, from, to }
    }

    /// Reads "KNOB" or "KNOB=FROM..TO".
    ///
    /// ```
    /// use trolley::policy::map::MapAxis;
    ///
    /// assert!(MapAxis::parse("accepted=0..0.2").is_ok());
    /// assert!(MapAxis::parse("weather").is_err());
    /// ```
    ///
    /// # Errors
    ///
    /// If there is no such knob, or the range is none or leads out of where it makes sense.
    pub fn parse(text: &str) -> Result<Self, Failure> {
        let (name, range) = text.split_once('=').map_or((text, None), |(a, b)| (a, Some(b)));
        let names = MapKnob::ALL.map(MapKnob::name).join(", ");
        let knob = MapKnob::ALL.into_iter().find(|knob| knob.name() == name).ok_or_else(|| {
            let fault = format!("\"{name}\" cannot be varied");
            Failure::setting(fault).with_remedy(format!("name one of: {names}"))
        })?;
        let Some(range) = range else { return Ok(Self::usual(knob)) };
        let ends: Option<Vec<f64>> = range.split("..").map(|end| end.trim().parse().ok()).collect();
        let [_, [least, most]] = knob.ranges();
        match ends.as_deref() {
            Some([from, to]) if least <= *from && from < to && *to <= most => {
                Ok(Self { knob, from: *from, to: *to })
            }
            _ => {
                let fault = format!("\"{range}\" is no range of {name}");
                let remedy = format!("write {name}=FROM..TO, from {least} to {most}");
                Err(Failure::setting(fault).with_remedy(remedy))
            }
        }
    }

    /// Returns so many values from end to end: evenly spaced, those of odds by their logarithm.
    ///
    /// ```
    /// use trolley::policy::map::MapAxis;
    ///
    /// assert_eq!(MapAxis::parse("accepted=0..0.5")?.values(3), [0.0, 0.25, 0.5]);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn values(&self, count: usize) -> Vec<f64> {
        let last = count.saturating_sub(1).max(1) as f64;
        let value = |k: usize| {
            let share = k as f64 / last;
            if k + 1 == count {
                self.to
            } else if self.knob.is_odds() {
                self.from * libm::pow(self.to / self.from, share)
            } else {
                self.from + share * (self.to - self.from)
            }
        };
        (0..count).map(value).collect()
    }

    /// Returns where a value lies from end to end, from 0 to 1.
    ///
    /// ```
    /// use trolley::policy::map::MapAxis;
    ///
    /// assert!((MapAxis::parse("odds=0.1..10")?.share(1.0) - 0.5).abs() < 1e-12);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn share(&self, value: f64) -> f64 {
        if self.knob.is_odds() {
            libm::log(value / self.from) / libm::log(self.to / self.from)
        } else {
            (value - self.from) / (self.to - self.from)
        }
    }
}
