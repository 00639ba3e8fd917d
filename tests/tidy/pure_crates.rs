//! Crates that compute and nothing else: held by `tests/tidy.rs`, tested on ARM by `cargo x aarch64`.

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
