//! Members: what a planner knows only up to errors, drawn.
//!
//! A *member* is one draw of where everybody may really be: per party a constant offset in its own
//! frame, a constant factor on its speed, and one of its predicted motions. Member m is point m of
//! a scrambled Sobol sequence of a fixed seed (B. Burley, *Practical Hash-based Owen Scrambling*,
//! JCGT 9(4), 2020), so members are the same for all candidates, on every machine, and those of a
//! smaller number are the first of a larger one.
//!
//! The sequence's first coordinates are laid along the directions in which contacts change most.
//!
//! Offsets are normal. The factor on speed is log-normal, so that nobody drives backwards. The
//! predicted motion is the one in whose share of \[0, 1) a coordinate lies: stratified by
//! probability.

use crate::error::Misfit;
use crate::limit;
use crate::scenario::{Motion, Party, Scenario, path};
use directions::Directions;
use geometry::motion::{MotionPath, PathError};

mod directions;
mod normal;
#[cfg(test)]
mod tests;

/// How many members there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Members {
    /// At first; 1: the scene as stated, nothing is drawn.
    pub count: u32,
    /// At most, where they are doubled because the best two are too close to call.
    pub most: u32,
}

/// Standard deviations of what is known of a party.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// To its left (m).
    pub lateral_m: f64,
    /// Along its x axis (m).
    pub longitudinal_m: f64,
    /// Correlation of the two, -1 to 1.
    pub correlation: f64,
    /// Yaw (degrees).
    pub yaw_deg: f64,
    /// Share of its speed.
    pub speed_share: f64,
}

/// What is drawn of one party.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartyDraw {
    /// Offset along its x axis (m).
    pub longitudinal_m: f64,
    /// Offset to its left (m).
    pub lateral_m: f64,
    /// Offset of its yaw (degrees).
    pub yaw_deg: f64,
    /// Factor on its speed, above 0.
    pub speed_factor: f64,
    /// Which predicted motion it takes, as a share of their probabilities: in [0, 1).
    pub choice: f64,
}

/// A member.
#[derive(Clone, Debug, PartialEq)]
pub struct MemberDraw {
    /// Per party of the scenario.
    pub parties: Vec<PartyDraw>,
    /// How the velocity after a heavy contact is turned, to the left (degrees).
    pub run_out_turn_deg: f64,
    /// How hard a run-out is braked, as a share of the way from the least to the most: in [0, 1).
    pub run_out_share: f64,
}

/// Standard deviation of the direction of a run-out (degrees): -4.8 to 10.4 in MASH crash tests.
const RUN_OUT_TURN_DEG: f64 = 9.0;

/// Coordinates of a point: those of the ego, then as many of each other party, then the run-out.
const OF_EGO: u32 = 4;
const OF_OTHER: u32 = 5;
/// Those of them that are normal: lateral offset, speed, longitudinal offset, yaw of the ego;
/// speed, lateral offset, longitudinal offset, yaw of another party. Its choice is not.
const EGO_NORMALS: usize = OF_EGO as usize;
const OF_OTHER_NORMALS: usize = OF_OTHER as usize - 1;
const RUN_OUT: u32 = OF_EGO + OF_OTHER * (limit::PARTIES.most as u32 - 1);

impl Members {
    /// The scene as stated.
    pub const NOMINAL: Self = Self { count: 1, most: 1 };

    /// Where nothing is said: 32, at most 128. What they cost and how often they order two
    /// candidates wrongly is measured in `tools/results/members.md`.
    pub const USUAL: Self = Self { count: 32, most: 128 };

    /// More are never drawn.
    pub const LIMIT: u32 = limit::MEMBERS.most as u32;

    /// How many are the most where nothing is said.
    #[must_use]
    pub fn usual_most(count: u32) -> u32 {
        if count == 1 { 1 } else { count.max(128) }
    }

    /// So many members, and at most so many; `None`: [`Members::usual_most`].
    ///
    /// # Errors
    ///
    /// If there are none, more than 1,024, or fewer at most than at first.
    pub fn new(count: i64, most: Option<i64>) -> Result<Self, Misfit> {
        let count = limit::MEMBERS.whole::<u32>("members", count)?;
        let Some(most) = most else { return Ok(Self { count, most: Self::usual_most(count) }) };
        let most = limit::MEMBERS.whole::<u32>("members_max", most)?;
        if count == 1 && most > 1 {
            let fault = "members_max is written, and nothing is drawn".to_owned();
            return Err(Misfit::new("members_max", fault, "write members = 2 or more, too"));
        }
        if most < count {
            let fault = format!("members_max is {most}, and members is {count}");
            return Err(Misfit::new("members_max", fault, "write at least as many as members"));
        }
        Ok(Self { count, most })
    }

    /// Whether nothing is drawn.
    #[must_use]
    pub fn is_nominal(&self) -> bool {
        self.count == 1
    }
}

impl Errors {
    /// Where nothing is stated of a party: what trackers and localisation reach (our assumption).
    #[must_use]
    pub fn usual(is_ego: bool) -> Self {
        Self {
            lateral_m: 0.2,
            longitudinal_m: 0.3,
            correlation: 0.0,
            yaw_deg: 2.0,
            speed_share: if is_ego { 0.05 } else { 0.1 },
        }
    }
}

impl PartyDraw {
    /// The party as stated.
    pub const NOMINAL: Self =
        Self { longitudinal_m: 0.0, lateral_m: 0.0, yaw_deg: 0.0, speed_factor: 1.0, choice: 0.0 };

    /// The same of what is fixed to the ground: it stands as stated, somewhere else.
    #[must_use]
    pub fn of_fixed(self) -> Self {
        Self { yaw_deg: 0.0, speed_factor: 1.0, ..self }
    }

    fn of(errors: &Errors, [lateral, speed, long, yaw]: [f64; 4], choice: f64) -> Self {
        let own = (1.0 - errors.correlation * errors.correlation).max(0.0).sqrt();
        let ahead = errors.correlation * lateral + own * long;
        Self {
            lateral_m: errors.lateral_m * lateral + 0.0,
            longitudinal_m: errors.longitudinal_m * ahead + 0.0,
            yaw_deg: errors.yaw_deg * yaw + 0.0,
            speed_factor: libm::exp(errors.speed_share * speed),
            choice,
        }
    }
}

/// The seed of the sequence.
const SEED: u32 = 2018;

/// The seed of the usual sequence of worlds.
const WORLD_SEED: u32 = 34;

/// How many worlds are drawn where all work is done, and which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Worlds {
    /// How many; 0: none, and an answer says nothing of them.
    pub count: u32,
    /// Which sequence they are points of.
    pub seed: u32,
}

impl Worlds {
    /// Where nothing is said.
    pub const USUAL: Self = Self { count: 200, seed: 0 };

    /// So many worlds of this sequence.
    ///
    /// # Errors
    ///
    /// If `count` is not within 0 and 10,000.
    pub fn new(count: i64, seed: u32) -> Result<Self, Misfit> {
        Ok(Self { count: limit::WORLDS.whole::<u32>("worlds", count)?, seed })
    }

    /// A coordinate of point `number`, in \[0, 1): another sequence than that of members, so that
    /// worlds and members have nothing to do with each other.
    #[must_use]
    pub fn coordinate(&self, number: u32, dimension: u32) -> f64 {
        let seed = WORLD_SEED.wrapping_add(self.seed);
        f64::from(sobol_burley::sample(number, dimension, seed))
    }
}

/// The members of a scene.
#[derive(Clone, Debug)]
pub struct MemberSequence<'s> {
    scenario: &'s Scenario,
    directions: Directions,
}

impl<'s> MemberSequence<'s> {
    /// The sequence of a scene: a pure function of it.
    #[must_use]
    pub fn new(scenario: &'s Scenario) -> Self {
        Self { scenario, directions: Directions::new(scenario) }
    }

    /// Point `number` of the sequence, as a member.
    #[must_use]
    pub fn draw(&self, number: u32) -> MemberDraw {
        let coordinate = |dimension: u32| f64::from(sobol_burley::sample(number, dimension, SEED));
        let Scenario { parties, ego, .. } = self.scenario;
        let of_others = (0..parties.len() as u32 - 1).map(|other| OF_EGO + OF_OTHER * other);
        let dimensions = (0..OF_EGO).chain(of_others.flat_map(|first| first..first + OF_OTHER - 1));
        let mut normals: Vec<f64> =
            dimensions.map(|dimension| normal::quantile(coordinate(dimension))).collect();
        self.directions.apply(&mut normals);
        let mut others = normals[EGO_NORMALS..].chunks_exact(OF_OTHER_NORMALS);
        let mut choices = (0..).map(|other| coordinate(OF_EGO + OF_OTHER * other + OF_OTHER - 1));
        let draw = |(index, party): (usize, &Party)| {
            if index == ego.0 {
                let [lateral, speed, long, yaw] = [0, 1, 2, 3].map(|of| normals[of]);
                return PartyDraw::of(&party.errors, [lateral, speed, long, yaw], 0.0);
            }
            match (others.next(), choices.next()) {
                (Some(&[speed, lateral, long, yaw]), Some(choice)) => {
                    PartyDraw::of(&party.errors, [lateral, speed, long, yaw], choice)
                }
                _ => PartyDraw::NOMINAL,
            }
        };
        MemberDraw {
            parties: parties.iter().enumerate().map(draw).collect(),
            run_out_turn_deg: RUN_OUT_TURN_DEG * normal::quantile(coordinate(RUN_OUT)) + 0.0,
            run_out_share: coordinate(RUN_OUT + 1),
        }
    }
}

impl Motion {
    /// The path of the motion with a draw: faster or slower from time 0 on, and moved and turned in
    /// the body's frame, wherever it is.
    ///
    /// # Errors
    ///
    /// If it leads too far, or too fast, for a path.
    pub fn drawn(&self, draw: &PartyDraw, horizon_s: f64) -> Result<MotionPath, PathError> {
        let path = path::faster(self, draw.speed_factor, horizon_s)?;
        if [draw.longitudinal_m, draw.lateral_m, draw.yaw_deg] == [0.0; 3] {
            return Ok(path);
        }
        path.offset([draw.longitudinal_m, draw.lateral_m], draw.yaw_deg)
    }
}
