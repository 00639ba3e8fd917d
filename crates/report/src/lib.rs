//! Reports of results: a single HTML file that needs no network, glTF with damage as vertex
//! colours, and stills that need no browser.
//!
//! ```text
//! record ──▶ trolley: the answer, made again ──write──▶ the files that are wanted
//!                │ pictures
//!                ▼
//! PlanPage (plain values) ──▶ plan    one file: text, tables, the scene from above (SVG), 3D
//!      ├── document: the same as JSON, with its schema
//!      └── Shot (two bodies, hits, patch) ──▶ glb    for Blender and the like
//!                                         ├─▶ still  PNG, drawn here
//!                                         └─▶ mcap   for Foxglove, with the feature `mcap`
//! ```
//!
//! Only `write` reads and writes files: everything else takes plain values and returns bytes.
//! Nothing is assessed here: every figure is one behind the decision. All shots are in the ego's
//! frame, in metres, x forward, z up.
//!
//! # Invariants
//!
//! - A page fetches nothing: its content security policy forbids it, and `plan/tests.rs` looks for
//!   addresses. Foreign text never becomes markup: `plan/tests.rs`.
//! - A still shows a triangle where it is, the nearer one before the farther: `still/tests.rs`.
//! - A .glb is well-formed, and holds each triangle with its colour: `glb/tests.rs`.

pub mod body_text;
pub mod document;
pub mod explain;
pub mod glb;
mod html;
#[cfg(feature = "mcap")]
pub mod mcap;
mod measurement;
mod pack;
pub mod pictures;
pub mod plan;
pub mod policy_map;
mod shot;
pub mod still;
pub mod table;
pub mod text;
pub mod work;
mod write;

pub use html::{escape, framed};
pub use measurement::{Figure, MeasurementPage};
pub use shot::{Shot, ShotBody, ShotPatch};
pub use write::{Wanted, write};
