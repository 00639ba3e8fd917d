//! Which of several unavoidable collisions does least harm, and how sure that is: the library.
//!
//! ```no_run
//! use trolley::{Engine, Limits, Scenario};
//!
//! # fn main() -> Result<(), trolley::Failure> {
//! trolley::play_worker(); // workers are this program, started again
//! let scenario = Scenario::open("crash.toml")?;
//! let mut engine = Engine::builder().workers(4).build()?;
//! let ranking = engine.rank(&scenario, &Limits::default())?;
//! if let Some(best) = ranking.best() {
//!     println!("least harm: {} ({})", best.name, ranking.answer.state.name());
//! }
//! # Ok(())
//! # }
//! ```
//!
//! | module | what it is for |
//! |---|---|
//! | [`Scenario`], [`Engine`], [`Limits`], [`Ranking`] | from a file to an answer |
//! | [`RecordContent`] | an answer kept with all that it was made from, and made again |
//! | [`kernel`] | anybody's triangles: trees, intersecting pairs, sets, touches |
//! | [`serve`](serve()), [`OpenDeployment`] | a service that answers planners |
//! | [`traffic`] | recorded traffic, as scenarios |
//! | [`bodies`] | bodies opened, generated, sealed |
//! | [`intersect`], [`poses`] | which triangles of two bodies intersect at one pose, with times |
//! | [`model`] | model files made of meshes and shapes, looked at, checked, exported |
//! | [`policy`] | policies and curves: would they be accepted, and what do they say |
//! | [`doctor`] | what this machine has of what the service needs |
//!
//! # Invariants
//!
//! - There is one way from a scenario to an answer: what ranks once and what serves for months runs
//!   the same code (`coordinator/src/workspace.rs`). `tests/answers/identical.rs`.
//! - A complete answer is a pure function of bodies, scenario, policy and curves.
//!
//! It prints nothing and parses no command line.

pub mod bodies;
mod deployment;
pub mod dispatch_options;
pub mod doctor;
mod engine;
pub mod files;
pub mod intersect;
pub mod kernel;
mod limits;
pub mod model;
pub mod policy;
pub mod poses;
pub mod record;
pub mod run;
mod scenario;
mod serve;
pub mod traffic;
mod worker;

pub use coordinator::{Answer, Explanation, PersonRow, PoseRow, Row, Scene, SearchOrder, Until};
pub use damage::{AnswerState, Touch};
pub use deployment::OpenDeployment;
pub use diagnostic::{Diagnostic, Failure, FailureKind};
pub use engine::{Engine, EngineBuilder, Ranking, pin_coordinator, worker_cores};
pub use limits::Limits;
pub use protocol::public::Ask;
pub use record::Record;
pub use run::Run;
pub use runtime::heap::Counting as CountingAllocator;
pub use scenario::{Scenario, SourceText, Texts, read_text};
pub use serve::{Greeting, ServeOptions, serve};
pub use service::Idle;
pub use worker::{play_worker, run_reader, run_worker};

/// What an [`Explanation`] is made of.
pub mod explanation {
    pub use coordinator::{Derivation, PersonChain, PolicyStep, Separation};
    pub use damage::curve::CurveUnit;
    pub use damage::{Knob, Margin, Reserve, Stability};
}

/// Name of this build, by a hash of what it was made of: both ends of every channel carry it, so
/// that no two versions ever talk.
pub const BUILD: &str = concat!(env!("CARGO_PKG_VERSION"), "+", env!("TROLLEY_BUILD"));
