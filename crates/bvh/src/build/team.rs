//! Work that several threads share. What comes out does not depend on who did it.

use std::panic::resume_unwind;
use std::thread;

/// Does every task, each in a thread of its own, the last one in this thread; returns what each
/// gave, in order.
pub(super) fn each<T: Send, R: Send>(mut tasks: Vec<T>, run: impl Fn(T) -> R + Sync) -> Vec<R> {
    let Some(last) = tasks.pop() else { return Vec::new() };
    let run = &run;
    thread::scope(|scope| {
        let others: Vec<_> = tasks.into_iter().map(|task| scope.spawn(move || run(task))).collect();
        let last = run(last);
        let mut done: Vec<R> =
            others.into_iter().map(|t| t.join().unwrap_or_else(|e| resume_unwind(e))).collect();
        done.push(last);
        done
    })
}

/// Does every task: each in a thread of its own, or one after the other if there is one thread.
pub(super) fn all<T: Send, R: Send, const N: usize>(
    tasks: [T; N],
    threads: usize,
    run: impl Fn(T) -> R + Sync,
) -> [R; N] {
    if threads < 2 {
        return tasks.map(run);
    }
    let run = &run;
    thread::scope(|scope| {
        let started = tasks.map(|task| scope.spawn(move || run(task)));
        started.map(|t| t.join().unwrap_or_else(|e| resume_unwind(e)))
    })
}

/// Does every task, in so many threads; each takes an equal number of neighbours.
pub(super) fn deal<T: Send>(mut tasks: Vec<T>, threads: usize, run: impl Fn(T) + Sync) {
    let share = tasks.len().div_ceil(threads.max(1)).max(1);
    let mut shares = Vec::new();
    while tasks.len() > share {
        shares.push(tasks.split_off(tasks.len() - share));
    }
    shares.push(tasks);
    each(shares, |share| share.into_iter().for_each(&run));
}

/// How many of `count` things each of `threads` threads gets, at most.
pub(super) fn share(count: usize, threads: usize) -> usize {
    count.div_ceil(threads.max(1)).max(1)
}
