//! How a program plays the workers of its own engine, and the readers of its meshes.

use crate::{BUILD, Failure};

/// How a worker is started: `PROGRAM worker WORD`.
const ROLE: &str = "worker";

/// If this process was started as a worker or as the reader of a mesh, plays that part and ends the
/// process. Otherwise does nothing.
///
/// An [`Engine`](crate::Engine) starts its own program again for each worker, and so do the
/// functions that [read a mesh](crate::model). A program that uses either calls this first in
/// `main`.
///
/// ```
/// trolley::play_worker(); // the first line of `main`
/// println!("this process is not a worker");
/// ```
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

/// Reads a mesh for the process that started this one, and returns the exit code to end with.
///
/// `request` is the argument from the command line; stdout and stderr are channels to the other
/// process. The limits of the request hold for all of this process from then on.
///
/// ```
/// assert_eq!(trolley::run_reader("not a request"), 78);
/// ```
#[must_use]
pub fn run_reader(request: &str) -> u8 {
    mesh::reader::play(request)
}

/// Plays a worker until its coordinator ends it. `word` is the argument from the command line.
///
/// ```
/// assert!(trolley::run_worker("not from a coordinator").is_err());
/// ```
///
/// # Errors
///
/// If no coordinator started this process, or a channel breaks.
pub fn run_worker(word: &str) -> Result<(), Failure> {
    runtime::process::set_name("trolley-worker");
    Ok(worker::run(word, BUILD)?)
}
