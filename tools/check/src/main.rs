//! `cargo x`: what a change must pass, and the door to all other tasks.
//!
//! `cargo x check` runs here. Every other task is one of the package `trolley-tools`, which is
//! built with the library that it needs when it is asked for.

use anyhow::Result;
use std::ffi::OsString;
use std::process::ExitCode;
use trolley_check::{step, steps};

fn main() -> Result<ExitCode> {
    let words: Vec<OsString> = std::env::args_os().skip(1).collect();
    let known: Vec<_> = words.iter().map(|word| word.to_str()).collect();
    match known[..] {
        [Some("check")] => steps::run(steps::STEPS),
        [Some("check"), Some("--quick")] => steps::run(steps::quick()),
        // Also what is wrong, or asks for help: there all tasks are known.
        _ => {
            let mut tools = step::cargo();
            tools.args(["run", "--package", "trolley-tools", "--"]).args(words);
            step::pass_on(&mut tools)
        }
    }
}
