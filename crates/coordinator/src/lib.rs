//! The coordinator: descends trees, hands out jobs, folds results into an answer.
//!
//! ```text
//! Scenario + bodies --Request::new--> Request --Work::new--> tasks --front--> jobs
//!                                                  ^                           |  Crew::run: four
//!                                                  |  follow-up tasks          |  worker processes
//!                                                  +---------- fold <--hits----+  run_here: in
//!                                                                this process
//! Work::finish --> damage::assess, damage::rank --> Answer
//! ```
//!
//! # Invariants
//!
//! - A complete [`Answer`] is a pure function of bodies, scenario, policy and curves: it holds
//!   order-free values only, and both ways of running fill it from the same fold:
//!   `tests/identical.rs` at the top level.
//! - It never runs a triangle test itself, except in [`run_here`], and that is said in the report.
//! - Whatever ends a run, no process and no shared memory is left: `tests/kill.rs`.
//!
//! It does not know formats of files, nor how harm is computed.

mod answer;
mod bound;
mod brief;
mod case;
mod crew;
mod explain;
#[cfg(test)]
mod fixtures;
mod gather;
mod here;
mod ledger;
mod pairs;
mod replay;
mod request;
mod scene;
mod strategy;
mod terms;
mod trial;
mod work;

pub use answer::{Answer, PersonRow, PoseRow, Row, explain};
pub use brief::{Brief, BriefRow};

pub use crew::{
    Attendant, Crew, CrewError, CrewReport, Duty, Hardware, Incident, Lack, Mended, Options, Share,
    Sight, Spoiled, WorkerReport, preflight, seal,
};
pub use explain::{Chain, Explanation, PersonChain, PolicyStep, Separation};
pub use here::{Desk, run_here, run_watched};
pub use ledger::Ledger;
pub use pairs::{PairWork, PoseFound, Spent};
pub use replay::replay;
pub use request::{Candidates, Request, RequestError};
pub use scene::Scene;
pub use strategy::{Prospect, Pursuit, Strategy};
pub use terms::{Terms, Until};
pub use trial::{Chance, Flaw, Verdict, trial};
pub use work::{Certainty, Effort, Errands, PartOf, Room, Work};
