//! The trolley binary.
fn main() {}
