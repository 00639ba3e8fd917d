//! How a program plays the workers of its own engine.

use crate::{BUILD, Failure};

/// How a worker is started: `PROGRAM worker WORD`.
const ROLE: &str = "worker";

/// Plays a worker, and ends the process, if this process was started as one; else does nothing.
///
/// An [`Engine`](crate::Engine) starts its workers from its own program. A program with an engine
/// that has workers calls this first.
pub fn play_worker() {
    let mut args = std::env::args().skip(1);
    let (Some(role), Some(word), None) = (args.next(), args.next(), args.next()) else { return };
    if role != ROLE || protocol::Launch::from_word(&word).is_none() {
        return;
    }
    let code = match run_worker(&word) {
        Ok(()) => 0,
        Err(failure) => {
            tracing::error!("{failure}");
            failure.kind().exit_code()
        }
    };
    std::process::exit(code.into());
}

/// Plays a worker to its end. `word` is what a coordinator wrote on the command line.
///
/// # Errors
///
/// If no coordinator started this process, or its channels break.
pub fn run_worker(word: &str) -> Result<(), Failure> {
    runtime::process::set_name("trolley-worker");
    Ok(worker::run(word, BUILD)?)
}
