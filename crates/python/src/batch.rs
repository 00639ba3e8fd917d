//! One query for each of many poses, on several threads, with Python's lock released.

use crate::errors::refuse;
use pyo3::prelude::*;
use std::num::NonZero;
use std::sync::{Mutex, PoisonError};

/// Most threads of a call.
const THREADS_MAX: usize = 256;

/// Queries that a thread takes at a time: some microseconds each, at least.
const CHUNK: usize = 32;

/// Queries of a thread between two looks for signals, such as Ctrl-C.
const BLOCK: usize = 8_192;

/// The number of threads that a caller wants; 0: one for each core that this process may use.
pub(crate) fn threads(py: Python<'_>, asked: usize) -> PyResult<usize> {
    match asked {
        0 => Ok(std::thread::available_parallelism().map_or(1, NonZero::get)),
        1..=THREADS_MAX => Ok(asked),
        _ => {
            let what = format!("{asked} is more than {THREADS_MAX}");
            Err(refuse(py, "threads", &what, "give 1 or more, or 0 for all cores"))
        }
    }
}

/// Calls `answer` for every number below `count` and returns what it says, in order. Each thread
/// has a scratch of its own. The first error, in order of the numbers, ends it all.
pub(crate) fn answers<S: Send, T: Send, E: Send>(
    py: Python<'_>,
    (count, threads): (usize, usize),
    scratch: impl Fn() -> S + Sync,
    answer: impl Fn(usize, &mut S) -> Result<T, E> + Sync,
    raise: impl Fn(E) -> PyErr,
) -> PyResult<Vec<T>> {
    let mut all = Vec::with_capacity(count);
    let mut own = scratch();
    let block = BLOCK.saturating_mul(threads);
    for begin in (0..count).step_by(block) {
        py.check_signals()?;
        let end = count.min(begin + block);
        let helpers = threads.min((end - begin).div_ceil(CHUNK));
        if helpers <= 1 {
            let block = py.detach(|| -> Result<Vec<T>, E> {
                (begin..end).map(|number| answer(number, &mut own)).collect()
            });
            all.extend(block.map_err(&raise)?);
            continue;
        }
        let block = py.detach(|| shared(begin..end, helpers, (&scratch, &mut own), &answer));
        all.extend(block.map_err(&raise)?);
    }
    Ok(all)
}

fn shared<S, T: Send, E: Send>(
    numbers: std::ops::Range<usize>,
    helpers: usize,
    (scratch, own): (&(impl Fn() -> S + Sync), &mut S),
    answer: &(impl Fn(usize, &mut S) -> Result<T, E> + Sync),
) -> Result<Vec<T>, E> {
    let chunks: Vec<usize> = numbers.clone().step_by(CHUNK).collect();
    let mut found: Vec<Option<Result<Vec<T>, E>>> = chunks.iter().map(|_| None).collect();
    let open = Mutex::new(chunks.iter().zip(&mut found));
    let work = |scratch: &mut S| {
        loop {
            let next = open.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some((first, place)) = next else { break };
            let chunk = *first..numbers.end.min(first + CHUNK);
            *place = Some(chunk.map(|number| answer(number, scratch)).collect());
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..helpers {
            scope.spawn(|| work(&mut scratch()));
        }
        // The caller works as well: one thread less to start.
        work(own);
    });
    let mut all = Vec::with_capacity(numbers.len());
    for chunk in found.into_iter().flatten() {
        all.extend(chunk?);
    }
    Ok(all)
}
