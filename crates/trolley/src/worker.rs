//! How a program plays the workers of its own engine, and whoever reads a mesh for it.

use crate::{BUILD, Failure};

/// How a worker is started: `PROGRAM worker WORD`.
const ROLE: &str = "worker";

/// Plays a worker or the reader of a mesh, and ends the process, if this process was started as
/// one; else does nothing.
///
/// An [`Engine`](crate::Engine) starts its workers from its own program, and so does whoever
/// [reads a mesh](crate::model). A program that does either calls this first.
pub fn play_worker() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let code = match args.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        [ROLE, word] if protocol::Launch::from_word(word).is_some() => match run_worker(word) {
            Ok(()) => 0,
            Err(failure) => {
                tracing::error!("{failure}");
                failure.kind().exit_code()
            }
        },
        [model, child, request] if [*model, *child] == mesh::reader::ROLE => run_reader(request),
        _ => return,
    };
    std::process::exit(code.into());
}

/// Reads a mesh for the process that started this one, within limits that hold for all of this
/// process from now on, and says with which exit code it is to end. `request` is what the other
/// wrote on the command line; stdout and stderr are channels to it.
#[must_use]
pub fn run_reader(request: &str) -> u8 {
    mesh::reader::play(request)
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
