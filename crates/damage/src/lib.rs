//! From contact to harm to a ranking under a policy.
//!
//! ```text
//! Approach --plan--> Path --Search, survey--> poses to intersect         (before and between jobs)
//! hits, open work --> Evidence --assess--> CandidateHarm --rank--> Ranking        (at any time)
//! Curves::parse, Policy::parse: texts of config/curves and config/policies
//! ```
//!
//! Pure: texts and values in, values out; no file, clock or thread. Everything is in A's frame (A is
//! the ego vehicle), in SI units. Transcendental functions come from `libm`, so that all machines
//! give the same bits.
//!
//! # Invariants
//!
//! - A [`Work`] interval is proven and only nests; a [`Range`] is an expert range around it. They
//!   never mix: `assess/tests.rs`.
//! - Merging evidence twice, or in another order, changes nothing: `evidence/tests.rs`.
//! - No contact is exactly 0 for everybody, and ranks like any other candidate: `assess/tests.rs`.
//! - Harm never falls when speed or the partner's mass rises: `assess/tests.rs`.
//! - A policy changes the order, never a figure: `rank/tests.rs`.
//! - Candidates that can still win are never left out: `rank/tests.rs`.
//!
//! Not modelled: rollover, second impacts, falls, fire, ejection. Risks are statistics of
//! populations, not anybody's fate.

pub mod approach;
pub mod assess;
pub mod contact;
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
pub mod search;

#[cfg(test)]
mod scene;

pub use approach::{Approach, ApproachError, heading};
pub use assess::{AssessError, Basis, Encounter, assess};
pub use contact::{Contact, Patch};
pub use curve::Level;
pub use dynamics::Parameters;
pub use evidence::{Evidence, Seen, Touch};
pub use fault::Fault;
pub use harm::{CandidateHarm, DeltaV, PersonHarm, Unevaluable};
pub use injury::{Curves, MissingCurve, Victim};
pub use interval::{Range, Work};
pub use party::{Aboard, Party, PartyError, PersonId, crew};
pub use path::{Apart, Meeting, Path, Stop, plan};
pub use policy::Policy;
pub use rank::{Ground, Note, Place, RankError, Ranking, State, rank};
pub use rule::{Rule, Stake};
pub use search::{First, Search};
