//! The steps that a change must pass, and what runs them: cargo, step by step.
//!
//! It uses none of the crates that it checks, so that `cargo x check` begins half a minute after an
//! empty clone was made, instead of building the library once more for itself.

pub mod built;
pub mod packages;
pub mod safety;
pub mod step;
pub mod steps;
