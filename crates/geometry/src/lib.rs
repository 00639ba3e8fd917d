//! Vectors, boxes, poses and the exact triangle–triangle test.
//!
//! Everything is in metres and radians unless a name says otherwise; frames are right-handed, x
//! forward, y left, z up. This crate knows nothing of bodies, trees or harm, and does no I/O.
//!
//! # Invariants
//!
//! - A vertex of B in A's frame is `((R₀x + R₁y) + R₂z) + t` in f64 from the stored f32, sums left
//!   to right, never fused, never rounded again ([`RelativePose::point`]). That defines the input.
//! - On that input [`triangle::intersect`] is exact: closed triangles, touching counts, coplanar
//!   overlap counts, a degenerate triangle is tested as the segment or point it is.
//! - [`patch::Pairs`] gives the same result for eight pairs at once, and [`Supports::add_all`]
//!   gives the same bits as adding point by point, with any vector instructions ([`simd`]).
//! - Rounding only ever enlarges boxes: no intersecting pair lies outside them.

pub mod aabb;

pub mod hash;
pub mod lanes;
pub mod motion;
pub mod patch;
pub mod plan;
pub mod pose;
pub mod rng;
pub mod simd;
pub mod support;
pub mod triangle;

pub use aabb::{Aabb, Bounds};

pub use glam::{DMat3, DVec2, DVec3};
pub use patch::{Patch, Posed};
pub use pose::{Pose, RelativePose};
pub use support::{Directions, Supports};
pub use triangle::Triangle;
pub use triangle::sweep::{self, Sweep};

/// A stored triangle: three corners of three coordinates, in metres, in its body's own frame.
pub type Corners = [[f32; 3]; 3];
