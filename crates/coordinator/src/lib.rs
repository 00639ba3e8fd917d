//! The coordinator: descends trees, hands out jobs, folds results into an answer.
//!
//! ```text
//! CourseRequest ── rank_courses ──▶ ways ── first contacts ──▶ a round: the next one of each way
//!                     ▲ ways beyond them                           │ SurveyRun: tasks, jobs
//!                     │                                            ▼
//!                     └─ damage::assess ◀── evidence ◀── fold ◀── hits: WorkerPool::run,
//!                                                                 or run_in_process, one by one
//! no contact is left, or none matters ──▶ damage::rank ──▶ Answer
//! ```
//!
//! # Invariants
//!
//! - A complete [`Answer`] is a pure function of bodies, scenario, policy and curves: it holds
//!   order-free values only, and both backends fill it from the same fold:
//!   `tests/answers/identical.rs` at the top level.
//! - Where there are workers it runs no survey. It looks at bodies itself if that is the only look
//!   to do, or bodies are copied; and it tests whether one lies inside another, or draws overlap.
//! - However a run ends, no process and no shared memory is left: `tests/processes/kill.rs`.
//!
//! It does not know file formats, nor how harm is computed.

mod answer;
mod bound;
mod candidate_state;
mod course;
mod explain;
mod extent;
#[cfg(test)]
mod fixtures;
mod gather;
mod idle_cores;
mod in_process;
mod job_history;
mod looks;
mod pairs;
mod path_memory;
mod replay;
mod request;
mod request_limits;
mod strategy;
#[cfg(test)]
mod trial;
mod virtual_cores;
mod work;
mod worker_pool;
mod workspace;

pub use answer::{PersonRow, PoseRow};

pub use course::{
    Alternative, Answer, AssessmentError, AtHorizon, CombinedRisk, ContactRow, ContactScene,
    ContactStep, CourseChain, CourseEffort, CourseHistory, CourseOrder, CoursePersonRow,
    CourseRequest, CourseRow, EncounterEffort, ExpectedRow, Explanation, FlipRow, MemberRow,
    MembersRow, MetRow, NearestRow, PlanContact, PlanCourse, PlanMember, PlanMemberCourse,
    PlanNearest, PlanParty, PlanPath, PlanPoint, PlanSample, PlanScene, RankedCourses, RunOutRow,
    SearchedCourses, WorldsRow, rank_courses, rank_courses_in, replay_courses, search_courses,
};
#[cfg(any(test, feature = "faults"))]
pub use course::{CourseFlaw, TrialResult, random_courses, trial_courses};
pub use explain::{ContactChain, PersonChain, PolicyStep, Separation};
pub use extent::RequestExtent;
pub use idle_cores::HELPER_STACK_BYTES;
pub use in_process::{InProcessExecutor, run_in_process, run_watched};
pub use pairs::{PairWork, PoseFound, Spent};
pub use request::RequestError;
pub use request_limits::{RequestLimits, Until};
pub use strategy::{Prospect, SearchOrder, Strategy};
pub use virtual_cores::{MessageCosts, VirtualCores, VirtualSetup, VirtualTime};
pub use work::{Effort, PartOf, TaskSource};
#[cfg(feature = "faults")]
pub use worker_pool::Corruption;
pub use worker_pool::{
    Duty, FILES, FILES_PER_WORKER, Hardware, IdleHook, Incident, Mended, MissingRequirement,
    Observation, Options, WorkerPool, WorkerPoolError, WorkerPoolReport, WorkerReport, link_sizes,
    preflight, seal,
};
pub use workspace::{Backend, BodySet, RunError};
