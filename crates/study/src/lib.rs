//! Many scenes: recordings and scenarios swept over speed, offset, reaction and errors of
//! perception, each ranked under several policies and curves; answers as tables.
//!
//! ```text
//! SPEC.toml --plan--> DIR --run_shard, many processes--> DIR/shards/*/*.parquet --report--> page
//!                      │                                              │
//!                      └── inputs, policies, curves, by content   └── check: which byte is wrong
//! ```
//!
//! A study is cut into *shards* of some hundred scenes. Whoever runs one calls [`run_shard`]: this
//! crate's own children ([`run`]), a batch system with an array of jobs, or a cluster. It is
//! idempotent: a finished shard is skipped, an unfinished one leaves nothing, and its rows are the
//! same whoever ranks it, and however often. A scene that cannot be ranked is a row with the
//! reason.
//!
//! # Invariants
//!
//! - A shard's rows do not depend on who ranks it, on kills, or on the number of processes, but for
//!   a scene of which three processes died, whoever killed them, or that took longer than the study
//!   allows: `tests/study/main.rs`.
//! - A flipped byte, a truncated or a foreign shard is named, and it alone is ranked again:
//!   `tests/study/main.rs`.
//! - What a machine refuses, and a folder that is not as planned, is no row: the shard is not
//!   finished, and the next one who runs it begins anew: `tests/study/main.rs`.
//! - A row is what `trolley rank` says of its scene: `tests/study/main.rs`.

mod attempts;
mod inputs;
mod knob;
mod plan;
mod ranker;
mod report;
mod reranked;
mod rows;
mod run;
mod scene;
mod seal;
mod shard;
mod spec;
mod status;

pub use knob::SweepKnob;
pub use plan::{Plan, SceneKey, plan};
pub use report::report;
pub use reranked::{Reranked, RowFault};
pub use rows::TABLES_SCHEMA;
pub use run::{RunDone, RunOptions, run, work};
pub use scene::{WrittenScene, write_scene};
pub use shard::{Runner, ShardDone, run_shard};
pub use spec::RowSelection;
pub use status::{BrokenShard, Checked, Status, check, status};
