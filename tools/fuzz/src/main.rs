//! libFuzzer around one target: `fuzz --target=NAME CORPUS [libFuzzer's options]`.
#![no_main]

use fuzz::{TARGETS, Target};
use std::sync::OnceLock;

static TARGET: OnceLock<Target> = OnceLock::new();

/// The target that the command line names; the first one if it names none that there is.
fn named() -> Target {
    // libFuzzer passes options with two dashes over.
    let name = std::env::args().find_map(|arg| arg.strip_prefix("--target=").map(str::to_owned));
    let found = TARGETS.iter().find(|(known, _)| Some(*known) == name.as_deref());
    found.unwrap_or(&TARGETS[0]).1
}

libfuzzer_sys::fuzz_target!(
    init: {
        // A panic that a target catches is no end; one that it does not catch is.
        std::panic::set_hook(Box::new(|_| {}));
        TARGET.get_or_init(named);
    },
    |bytes: &[u8]| TARGET.get_or_init(named)(bytes)
);
