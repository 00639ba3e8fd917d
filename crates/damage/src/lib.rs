//! From contact to harm to a ranking under a policy.
//!
//! ```text
//! Footprint, Approach --Plane::of--> Plane; survey(Approach) --> depths to intersect
//! hits, open work --> Evidence --assess--> CandidateHarm --rank--> RankedCandidates  (at any time)
//! Parameters::parse, Curves::parse, Policy::parse: texts of config
//! ```
//!
//! Pure: texts and values in, values out; no file, clock or thread. Everything is in A's frame (A
//! is the ego vehicle), in SI units. Transcendental functions come from `libm`, so that all
//! machines give the same bits.
//!
//! ```
//! use body::{Band, BodyKind, Outlines, OwnParameters, Seat};
//! use geometry::{DVec3, Directions, Supports};
//! use trolley_damage::{Aboard, Approach, Basis, CollisionParty, Curves, Encounter, Evidence};
//! use trolley_damage::{Footprint, Front, Parameters, PersonId, Plane, Policy, Stake};
//! use trolley_damage::{assess, heading, rank};
//!
//! // The box of a car touches a wall at 15 m/s.
//! let outline = |x: [f64; 2], y: f64| Outlines {
//!     bands: vec![Band {
//!         height_m: [0.0, 1.0],
//!         rings: vec![vec![[x[1], -y], [x[1], y], [x[0], y], [x[0], -y]]],
//!     }],
//! };
//! let outlines = [outline([-2.25, 2.25], 0.9), outline([2.25, 2.55], 10.0)];
//! let velocity_m_s = DVec3::new(15.0, 0.0, 0.0);
//! let directions = Directions::around(heading(velocity_m_s, DVec3::X, DVec3::Z), DVec3::Z);
//! let supports = |outlines: &Outlines| {
//!     let mut supports = Supports::EMPTY;
//!     for [x, y] in outlines.bands[0].rings[0].iter() {
//!         supports.add(&directions, DVec3::new(*x, *y, 0.5));
//!     }
//!     supports
//! };
//! let approach = Approach {
//!     velocity_m_s,
//!     closing_m_s: velocity_m_s.length(),
//!     yaw_rad_s: [0.0; 2],
//!     supports_a: supports(&outlines[0]),
//!     supports_b: supports(&outlines[1]),
//!     directions: directions.clone(),
//! };
//! let car = CollisionParty {
//!     kind: BodyKind::Sedan,
//!     mass_kg: Some(1500.0),
//!     gyration_m: 1.26,
//!     centre_m: DVec3::ZERO,
//!     forward: DVec3::X,
//!     stiffness: None,
//!     front_m: Some(0.7),
//!     own: OwnParameters::default(),
//!     persons: [Aboard { id: PersonId(0), seat: Some(Seat::FrontLeft) }].into_iter().collect(),
//! };
//! let wall = CollisionParty {
//!     kind: BodyKind::Wall,
//!     mass_kg: None,
//!     front_m: None,
//!     persons: Default::default(),
//!     ..car.clone()
//! };
//! let footprints = outlines.each_ref().map(|of| Footprint::of(of, None, &approach));
//! let fronts = [Front::of(&car), Front::of(&wall)];
//! let [of_a, of_b] = &footprints;
//! let plane = Plane::of(&approach, [of_a, of_b], fronts, DVec3::new(2.25, 0.0, 0.5));
//!
//! let (curves, policy) = (Curves::shipped()?, Policy::shipped()?);
//! let parameters = Parameters::shipped()?;
//! let basis = Basis { curves: &curves, level: policy.outcome, parameters: &parameters };
//! let encounter =
//!     Encounter { approach: &approach, plane: Some(&plane), a: &car, b: &wall, probability: 1.0 };
//! // No job was done: the impulse does not depend on any.
//! let harm = assess(&encounter, &Evidence::none(), &basis)?;
//! assert!((harm.delta_v[0].work.hi() - 16.5).abs() < 1e-9);
//!
//! let ranking = rank(&policy, &[Stake { is_ego: true, ..Stake::default() }], &[harm])?;
//! assert_eq!(ranking.state, trolley_damage::AnswerState::Complete);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Invariants
//!
//! - An [`Interval`] is proven and only ever narrows; a [`Range`] is an expert range around it.
//!   They never mix: `assess/tests.rs`.
//! - Merging evidence twice, or in another order, changes nothing: `evidence/tests.rs`.
//! - The plane is the same, turned round, when the bodies are exchanged: `plane/tests.rs`.
//! - Harm never falls when speed or the partner's mass rises: `assess/tests.rs`.
//! - A policy changes the order, never a figure: `rank/tests/laws.rs`.
//! - Candidates that can still win are never left out: `rank/tests/laws.rs`.
//!
//! Not modelled: rollover, falls, fire, ejection, contacts between others. Risks are statistics of
//! populations, not predictions for individuals.

pub mod approach;
pub mod assess;
pub mod contact;
pub mod course;
pub mod criteria;
pub mod crush;
pub mod curve;
pub mod dynamics;
pub mod evidence;
pub mod expected;
pub mod fault;
pub mod harm;
pub mod injury;
pub mod interval;
pub mod parameters;
pub mod party;
pub mod path;
pub mod plane;
pub mod policy;
pub mod rank;
pub mod rule;
pub mod world;

#[cfg(test)]
mod scene;

pub use approach::{Approach, ApproachError, heading};
pub use assess::{AssessError, Basis, CandidateBounds, Encounter, Risk};
pub use assess::{assess, assess_in, bounds, bounds_in};
pub use contact::ContactPatch;
pub use course::{CourseHarm, RunOut, Severity};
pub use criteria::Criteria;
pub use crush::{Crush, Stiffness};
pub use curve::Level;
pub use evidence::{Evidence, Seen};
pub use fault::DataFileError;
pub use harm::{CandidateHarm, DeltaV, PersonHarm, Unevaluable};
pub use injury::{Curves, MissingCurve, Victim};
pub use interval::{Interval, Range};
pub use parameters::Parameters;
pub use party::{Aboard, CollisionParty, PartyError, PersonId};
pub use path::{Stop, Stops, survey};
pub use plane::{Footprint, Front, Plane};
pub use policy::Policy;
pub use rank::stability::{Knob, Margin, Reserve, Stability, stability};
pub use rank::standing::{Standing, needs_high, standing, standing_in};
pub use rank::{
    AnswerState, Assessed, Ground, Note, Place, RankError, RankedCandidates, Scratch, rank,
    rank_in, winners_in,
};
pub use rule::{Others, Rule, Stake};
