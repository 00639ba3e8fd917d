//! From contact to harm to a ranking under a policy.
//!
//! ```text
//! Approach --plan--> Path: first contact is sought there, --survey--> poses to intersect
//! hits, open work --> Evidence --assess--> CandidateHarm --rank--> RankedCandidates  (at any time)
//! Curves::parse, Policy::parse: texts of config/curves and config/policies
//! ```
//!
//! Pure: texts and values in, values out; no file, clock or thread. Everything is in A's frame (A
//! is the ego vehicle), in SI units. Transcendental functions come from `libm`, so that all
//! machines give the same bits.
//!
//! ```
//! use trolley_damage::{Approach, Basis, CollisionParty, Curves, Encounter, Evidence, Parameters};
//! use trolley_damage::{Aboard, Meeting, PersonId, Policy, Seen, Stake};
//! use trolley_damage::{assess, heading, plan, rank};
//! use geometry::{DVec3, Directions, Supports};
//! use body::{BodyKind, Seat};
//!
//! // A box of a car drives at 15 m/s into a wall.
//! let points = |x: [f64; 2], y: f64| {
//!     let corners = [[x[0], -y], [x[0], y], [x[1], -y], [x[1], y]];
//!     corners.map(|[x, y]| DVec3::new(x, y, 0.5))
//! };
//! let speed = DVec3::new(15.0, 0.0, 0.0);
//! let directions = Directions::around(heading(speed, DVec3::X, DVec3::Z), DVec3::Z);
//! let supports = |points: [DVec3; 4]| {
//!     let mut supports = Supports::EMPTY;
//!     points.iter().for_each(|p| supports.add(&directions, *p));
//!     supports
//! };
//! let approach = Approach {
//!     closing_m_s: speed.length(),
//!     supports_a: supports(points([-2.25, 2.25], 0.9)),
//!     supports_b: supports(points([2.2, 2.5], 10.0)),
//!     directions: directions.clone(),
//! };
//! let car = CollisionParty {
//!     kind: BodyKind::Sedan,
//!     mass_kg: Some(1500.0),
//!     gyration_m: 1.26,
//!     centre_m: DVec3::ZERO,
//!     forward: DVec3::X,
//!     stiffness: None,
//!     concave: false,
//!     persons: [Aboard { id: PersonId(0), seat: Some(Seat::FrontLeft) }].into_iter().collect(),
//! };
//! let wall = CollisionParty {
//!     kind: BodyKind::Wall,
//!     mass_kg: None,
//!     persons: Default::default(),
//!     ..car.clone()
//! };
//! let meeting = plan(&approach)?;
//! let Meeting::Path(path) = &meeting else { return Err("they meet".into()) };
//!
//! // Suppose that the search found contact at the first pose, and workers these two points of it.
//! let f = path.from_m; let mut hits = Seen::NOTHING; for y in [-0.9, 0.9] {
//!     hits.patch.add(&directions, DVec3::new(2.25, y, 0.5));
//! }
//! let mut evidence = Evidence::none((f, f));
//! evidence.add_hits(f, &hits);
//!
//! let (curves, policy) = (Curves::shipped()?, Policy::shipped()?);
//! let parameters = Parameters::default();
//! let basis = Basis { curves: &curves, level: policy.outcome, parameters: &parameters };
//! let encounter = Encounter {
//!     approach: &approach,
//!     meeting: &meeting,
//!     a: &car,
//!     b: &wall,
//!     probability: 1.0,
//! };
//! let harm = assess(&encounter, &evidence, &basis)?;
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
//! - No contact is exactly 0 for everyone, and ranks like any other candidate: `assess/tests.rs`.
//! - Harm never falls when speed or the partner's mass rises: `assess/tests.rs`.
//! - A policy changes the order, never a figure: `rank/tests.rs`.
//! - Candidates that can still win are never left out: `rank/tests.rs`.
//!
//! Not modelled: rollover, falls, fire, ejection, contacts between others. Risks are statistics of
//! populations, not predictions for individuals.

pub mod approach;
pub mod assess;
pub mod contact;
pub mod course;
pub mod crush;
pub mod curve;
pub mod dynamics;
pub mod evidence;
pub mod fault;
pub mod harm;
pub mod injury;
pub mod interval;
pub mod party;
pub mod path;
pub mod policy;
pub mod rank;
pub mod rule;

#[cfg(test)]
mod scene;

pub use approach::{Approach, ApproachError, heading};
pub use assess::{AssessError, Basis, CandidateBounds, Encounter, Risk};
pub use assess::{assess, assess_in, bounds, bounds_in};
pub use contact::{Contact, ContactPatch};
pub use course::{CourseHarm, RunOut, Severity};
pub use crush::{Crush, Stiffness};
pub use curve::Level;
pub use dynamics::Parameters;
pub use evidence::{Evidence, Seen, Touch};
pub use fault::DataFileError;
pub use harm::{CandidateHarm, DeltaV, PersonHarm, Unevaluable};
pub use injury::{Curves, MissingCurve, Victim};
pub use interval::{Interval, Range};
pub use party::{Aboard, CollisionParty, PartyError, PersonId, occupants};
pub use path::{Apart, Meeting, Path, Stop, Stops, plan};
pub use policy::Policy;
pub use rank::stability::{Knob, Margin, Reserve, Stability, stability};
pub use rank::standing::{Standing, needs_high, standing, standing_in};
pub use rank::{
    AnswerState, Assessed, Ground, Note, Place, RankError, RankedCandidates, Scratch, rank, rank_in,
};
pub use rule::{Others, Rule, Stake};
