//! Ranks the manoeuvres left to an automated vehicle by the harm that each would do.
//!
//! A scenario says where everybody is, where they may go, and what the ego could do. This crate
//! answers whom each candidate meets, when and how hard, which of them does least harm, and how
//! sure that is. Bodies are triangle meshes, contacts are exact, and the policy that compares the
//! injuries is yours.
//!
//! # A first ranking
//!
//! A scenario names the parties and the candidates, which are ways of the ego. It is TOML, from
//! a file ([`Scenario::open`]) or a text ([`Scenario::parse`]). Bodies come from model files or, as
//! here, are generated.
//!
//! ```
//! use trolley::{Engine, Limits, Scenario};
//!
//! let scenario = Scenario::parse("crash.toml", r#"
//!     schema = "trolley.scenario/2"
//!     name = "Pole or pedestrian"
//!
//!     [parties]
//!     ego = { generate = { shape = "sedan", triangles = 1500 } }
//!
//!     [parties.pole]
//!     generate = { shape = "pole", triangles = 600 }
//!     place = { position_m = [12, -1.5, 0] }
//!
//!     [parties.pedestrian]
//!     generate = { shape = "pedestrian", triangles = 800 }
//!     state = { position_m = [12, -1, 0], yaw_deg = 90, speed_m_s = 1 }
//!
//!     [[candidates]]
//!     name = "straight on"
//!     state = { position_m = [0, 0, 0], speed_m_s = 9 }
//!
//!     [[candidates]]
//!     name = "swerve"
//!     state = { position_m = [0, 0, 0], velocity_m_s = [9, -1.2] }
//! "#)?;
//!
//! let mut engine = Engine::builder().in_process().build()?;
//! let ranking = engine.rank(&scenario, &Limits::default())?;
//!
//! println!("{}", ranking.answer.state.name());
//! for row in &ranking.answer.ranking {
//!     let why = row.why.as_deref().unwrap_or_default();
//!     println!("{:.3} to {:.3}  {}  {why}", row.range.low(), row.range.high(), row.name);
//! }
//! assert_eq!(ranking.best().map(|row| row.name.as_str()), Some("swerve"));
//! # Ok::<(), trolley::Failure>(())
//! ```
//!
//! # How sure is it?
//!
//! An answer has a [state](AnswerState). *Complete*: all work is done. *Certified*: work was left
//! open, but none of it can change the winner. *Degraded*: it could. Each row has two intervals:
//! [`work`](CourseRow::work) holds the value that the finished work over these members would give,
//! and [`range`](CourseRow::range) adds what the model itself does not know. A
//! [deadline](Limits::with_deadline_ms) bounds the time; what is not done by then widens `work`, or
//! leaves members out: [`Answer::members`] says how many there are, and is none where the scene is
//! ranked as stated.
//!
//! ```
//! # use trolley::{AnswerState, Engine, Limits, Scenario};
//! # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
//! # let mut engine = Engine::builder().in_process().build()?;
//! let limits = Limits::default().with_deadline_ms(20.0)?;
//! let answer = engine.rank(&scenario, &limits)?.answer;
//! for row in &answer.ranking {
//!     assert!(row.work.lo() <= row.work.hi() && row.range.low() <= row.range.high());
//!     assert!(answer.state != AnswerState::Complete || row.work.is_settled());
//! }
//! # Ok::<(), trolley::Failure>(())
//! ```
//!
//! # Your own policy
//!
//! A policy is a file that says which injuries count, and in which order they are compared. A
//! scenario names it: `policy = "strict.toml"`. [`policy::check`] says what it means in sentences;
//! [`Scenario::of_texts`] takes scenario, policy and curves without files.
//!
//! # Workers
//!
//! By default, the work is shared among worker processes. They are this program, started again:
//! call [`play_worker`] first in `main`, and it plays that part when it is due.
//!
//! ```no_run
//! # use trolley::{Engine, Failure, Limits, Scenario};
//! fn main() -> Result<(), Failure> {
//!     trolley::play_worker();
//!     let mut engine = Engine::builder().workers(4).build()?;
//!     let ranking = engine.rank(&Scenario::demo()?, &Limits::default())?;
//!     println!("{} jobs", ranking.run.jobs);
//!     Ok(())
//! }
//! ```
//!
//! # Record and replay
//!
//! A [`Record`] keeps an answer with all that it was made from. A replay gives the same bytes.
//!
//! ```
//! # use trolley::{Engine, Limits, Record, Scenario};
//! # let folder = std::env::temp_dir().join(format!("trolley-tutorial-{}", std::process::id()));
//! # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
//! # let mut engine = Engine::builder().in_process().build()?;
//! Record::prepare(&folder)?;
//! let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
//! let path = Record::write(&folder, &ranking)?;
//!
//! let record = Record::read(&path)?;
//! let replay = record.replay(&path, None, trolley::bodies::SILENT)?;
//! assert_eq!(replay.json, record.content.answer);
//! # std::fs::remove_dir_all(&folder).ok();
//! # Ok::<(), trolley::Failure>(())
//! ```
//!
//! # Your own triangles
//!
//! The module [`kernel`] finds intersecting triangles without scenario, policy or files.
//!
//! ```
//! use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace, pairs};
//!
//! let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
//! let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
//! let options = BuildOptions::default();
//! let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
//! let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
//! assert_eq!(pairs(&floor, &blade, &pose, &mut Workspace::new())?, [(0, 0)]);
//! # Ok::<(), trolley::Failure>(())
//! ```
//!
//! # Where next
//!
//! | module | what it is for |
//! |---|---|
//! | [`Scenario`], [`Engine`], [`Limits`], [`Ranking`] | from a file to an answer |
//! | [`Searched`], [`Judge`] | one search, and an answer under each of many policies |
//! | [`Record`] | an answer kept with all that it was made from, and replayed |
//! | [`kernel`] | your own triangles: trees, intersecting pairs, sets, touches |
//! | [`serve`](serve()), [`OpenDeployment`] | a service that answers planners |
//! | [`traffic`] | recorded traffic, as scenarios |
//! | [`bodies`] | bodies opened, generated, sealed |
//! | [`intersect`], [`poses`] | which triangles of two bodies intersect at one pose, with times |
//! | [`plan`] | what a picture of a ranking is drawn from |
//! | [`model`] | model files imported, generated, inspected, checked, exported |
//! | [`policy`] | policies and curves checked, who signed them, and who wins under which |
//! | [`doctor`] | what this machine has of what the service needs |
//!
//! # Invariants
//!
//! - There is one way from a scenario to an answer: what ranks once and what serves for months runs
//!   the same code (`coordinator/src/course.rs`). `tests/answers/identical.rs`.
//! - A complete answer is a pure function of bodies, scenario, policy and curves.
//!
//! The crate prints nothing and parses no command line.

mod answer;
pub mod bodies;
mod deployment;
pub mod dispatch_options;
pub mod doctor;
mod engine;
pub mod explanation;
pub mod files;
pub mod init;
pub mod intersect;
mod judge;
pub mod kernel;
mod limits;
pub mod model;
pub mod plan;
mod plausibility;
pub mod policy;
pub mod poses;
pub mod record;
mod references;
pub mod run;
mod scenario;
mod serve;
mod texts;
pub mod traffic;
mod worker;

pub use answer::{
    Answer, ContactRow, CourseRow, Doubt, ExpectedRow, FlipRow, MemberRow, MembersRow, MetRow,
    Severity, Spread, WorldsRow,
};

/// The chain from contact to rank, from [`Limits::with_explanation`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let limits = trolley::Limits::default().with_explanation();
/// let explanation = engine.rank(&scenario, &limits)?.explanation;
/// assert!(explanation.is_some_and(|it| it.chains.len() == it.names.len()));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::Explanation;

/// The risk of one person in a [`ContactRow`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let answer = engine.rank(&scenario, &trolley::Limits::default())?.answer;
/// let contacts = answer.ranking.iter().flat_map(|row| &row.contacts);
/// for person in contacts.flat_map(|contact| &contact.persons) {
///     println!("{} {}: {:.3}", person.party, person.victim, person.work.hi());
///     assert!((0.0..=1.0).contains(&person.work.hi()));
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::PersonRow;

/// The triangles hit at one pose of a [`ContactRow`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let answer = engine.rank(&scenario, &trolley::Limits::default())?.answer;
/// let contacts = || answer.ranking.iter().flat_map(|row| &row.contacts);
/// for pose in contacts().flat_map(|contact| &contact.poses) {
///     println!("after {:.3} m: {} and {} hit", pose.travel_m, pose.hits_a, pose.hits_b);
/// }
/// assert!(contacts().any(|contact| !contact.poses.is_empty()));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::PoseRow;

/// The order of the jobs, for [`Limits::with_search_order`].
///
/// ```
/// use trolley::{Limits, SearchOrder};
///
/// let limits = Limits::default().with_search_order(SearchOrder::RoundRobin);
/// assert_eq!(limits.request_limits(None).search_order.name(), "round-robin");
/// ```
pub use coordinator::SearchOrder;

/// When a ranking may stop, for [`Limits::until`].
///
/// ```
/// # use trolley::{AnswerState, Engine, Limits, Scenario, Until};
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// let limits = Limits::default().until(Until::Certified);
/// let state = engine.rank(&scenario, &limits)?.answer.state;
/// assert!(matches!(state, AnswerState::Complete | AnswerState::Certified));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use coordinator::Until;

/// The state of an [`Answer`].
///
/// ```
/// # use trolley::{AnswerState, Engine, Limits, Scenario};
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// match engine.rank(&scenario, &Limits::default())?.answer.state {
///     AnswerState::Complete | AnswerState::Certified => println!("the winner is certain"),
///     AnswerState::Degraded => println!("the winner may change"),
///     AnswerState::Refused => println!("there is no winner"),
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use damage::AnswerState;

/// A remark on the ranking of an [`Answer`]: one of them may be that nobody wins.
///
/// ```
/// # use trolley::{Engine, Limits, Note, Scenario};
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// let answer = engine.rank(&scenario, &Limits::default())?.answer;
/// for note in &answer.notes {
///     println!("Note: {}", note.sentence());
/// }
/// assert_eq!(answer.refusal().map(Note::sentence), None);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use damage::Note;

pub use deployment::OpenDeployment;

/// Errors of the crates below this one implement it, so `?` turns them into a [`Failure`].
///
/// ```
/// use trolley::{Diagnostic, kernel::{BuildOptions, Tree}};
///
/// let empty = Tree::build(&[], &BuildOptions::default());
/// assert!(empty.is_err_and(|error| error.kind() == trolley::FailureKind::Input));
/// ```
pub use diagnostic::Diagnostic;

/// The error type of this crate.
///
/// ```
/// use trolley::Scenario;
///
/// if let Err(failure) = Scenario::parse("crash.toml", "schema = 3") {
///     eprintln!("{failure}"); // crash.toml:1:10: what is wrong, and what to do about it
///     assert!(failure.what().starts_with("crash.toml:"));
/// }
/// ```
pub use diagnostic::Failure;

/// Something that a scenario states, that is allowed and hardly true: [`Answer::implausible`].
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let answer = engine.rank(&scenario, &trolley::Limits::default())?.answer;
/// let says = |one: &trolley::Implausible| one.says.clone();
/// assert_eq!(answer.implausible.iter().map(says).collect::<Vec<_>>(), [""; 0]);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[doc(no_inline)]
pub use ::scenario::Implausible;
/// The kind of a [`Failure`], which is an exit code too.
///
/// ```
/// use trolley::{Engine, FailureKind};
///
/// let refused = Engine::builder().workers(100).build();
/// let kind = refused.map(drop).map_err(|failure| failure.kind());
/// assert_eq!(kind, Err(FailureKind::Configuration));
/// assert_eq!(FailureKind::Configuration.exit_code(), 78);
/// ```
pub use diagnostic::FailureKind;
pub use engine::{Engine, EngineBuilder, Ranking, Searched, pin_coordinator, worker_cores};
pub use judge::Judge;
pub use limits::Limits;
pub use plausibility::check_plausible;

/// Settings of the engine that replace those of a scenario.
///
/// ```
/// use trolley::{Engine, Overrides};
///
/// let overrides = Overrides { depth: Some(6), ..Overrides::default() };
/// let engine = Engine::builder().overrides(overrides).in_process().build();
/// assert!(engine.is_ok());
/// ```
pub use ::scenario::Overrides;
/// How many worlds are drawn where all work is done, and which: for [`Limits::with_worlds`] and
/// [`Searched::assess`].
///
/// ```
/// use trolley::Worlds;
///
/// assert_eq!(Worlds::new(200, 0).ok(), Some(Worlds::USUAL));
/// assert!(Worlds::new(-1, 0).is_err() && Worlds::new(1_000_000, 0).is_err());
/// ```
pub use ::scenario::Worlds;
/// A request to the service, from [`OpenDeployment::ask`].
///
/// ```
/// use trolley::{OpenDeployment, Scenario};
///
/// let deployment = OpenDeployment::open("../../config/deployments/minimal.toml".as_ref(), None)?;
/// let scenario = Scenario::open("../../config/scenarios/wall-or-pole.toml")?;
/// let ask = deployment.ask(&scenario, false)?;
/// assert_eq!((ask.candidate_count, ask.party_count), (3, 3));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use protocol::public::Ask;
pub use record::Record;
pub use references::References;
pub use run::Run;

/// A program that serves may use it, so that the service can report memory taken from the heap.
///
/// ```
/// #[global_allocator]
/// static HEAP: trolley::CountingAllocator = trolley::CountingAllocator;
///
/// assert_eq!(Box::new(1), 1.into());
/// ```
pub use runtime::heap::Counting as CountingAllocator;
pub use runtime::heap::explain_aborts;
pub use scenario::Scenario;
pub use serve::{Greeting, ServeOptions, serve, supervise};

/// What the service does between requests.
///
/// ```
/// use trolley::{Idle, ServeOptions};
///
/// let options = ServeOptions { idle: Some(Idle::Spin), ..ServeOptions::default() };
/// assert_eq!(Idle::default(), Idle::Park);
/// ```
pub use service::Idle;
pub use texts::{
    SourceText, Texts, check_criteria, policy_names, read_curves, read_parameters, read_policy,
    read_text,
};
pub use worker::{play_worker, run_reader, run_worker};

/// Name of this build: its version, and a hash of its sources. Both ends of every channel carry it,
/// so that different builds never talk to each other.
///
/// ```
/// assert!(trolley::BUILD.contains('+'));
/// ```
pub const BUILD: &str = concat!(env!("CARGO_PKG_VERSION"), "+", env!("TROLLEY_BUILD"));
