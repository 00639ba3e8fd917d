//! Crates that compute and do nothing else: `tests/tidy.rs` holds that; `cargo x aarch64` tests
//! them.

/// Crates without I/O, clock, waiting and processes, but for the modules that `tests/tidy/pure.rs`
/// names; from the bottom up.
pub(crate) const PURE: &[&str] = &[
    "diagnostic",
    "geometry",
    "protocol",
    "xml",
    "keys",
    "body",
    "shapes",
    "bvh",
    "damage",
    "scenario",
    "record",
    "dispatch",
    "executor",
    "traffic",
    "mesh",
    "simulate",
];
