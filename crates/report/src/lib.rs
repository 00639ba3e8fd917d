//! Reports of results: a single HTML file that needs no network, glTF with damage as vertex
//! colours, and stills that need no browser.
//!
//! ```text
//! record ──▶ trolley: the answer, made again ──write──▶ the files that are wanted
//!                │ decision
//!                ▼
//! DecisionPage (plain values) ──▶ html    one file: text, tables, charts (SVG), 3D view (three.js)
//!      └── Shot (two bodies, hits, patch) ──▶ glb    for Blender and the like
//!                                         ├─▶ still  PNG, drawn here
//!                                         └─▶ mcap   for Foxglove, with the feature `mcap`
//! ```
//!
//! A ranking over a horizon needs no record: `plan` makes its page from the answer and the scene.
//!
//! Only `write` reads and writes files: everything else takes plain values and returns bytes.
//! Nothing is assessed here: every figure is one behind the decision. All shots are in the ego's
//! frame, in metres, x forward, z up.
//!
//! # Invariants
//!
//! - A page fetches nothing: its content security policy forbids it, and `html/tests.rs` looks for
//!   addresses. Foreign text never becomes markup: `html/tests.rs`.
//! - A still shows a triangle where it is, the nearer one before the farther: `still/tests.rs`.
//! - A .glb is well-formed, and holds each triangle with its colour: `glb/tests.rs`.

mod decision;
pub mod explain;
pub mod glb;
pub mod html;
#[cfg(feature = "mcap")]
pub mod mcap;
mod measurement;
mod pack;
pub mod plan;
mod shot;
pub mod still;
pub mod text;
mod write;

pub use html::{CandidateRow, DecisionPage, TimelineMoment, TimelineSpan, Worker};
pub use measurement::{Figure, MeasurementPage};
pub use shot::{Shot, ShotBody, ShotPatch};
pub use write::{Wanted, write};
