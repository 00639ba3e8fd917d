//! Progress of long work: a bar on a terminal, a line a minute elsewhere, nothing when quiet.

use crate::args::Output;
use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::io::IsTerminal as _;
use std::sync::atomic::{AtomicU64, Ordering};

/// Nothing is shown before work has taken this long `[ns]`.
const PATIENCE_NS: u64 = 1_000_000_000;
/// Where there is no terminal, one line in this time `[ns]`.
const LINE_NS: u64 = 60_000_000_000;

/// Work of known size.
pub(crate) struct Progress {
    bar: ProgressBar,
    what: String,
    total: u64,
    done: AtomicU64,
    started_ns: u64,
    said_ns: AtomicU64,
    output: Output,
}

impl Progress {
    /// Nothing done yet of `total` things, which are called `what`.
    pub(crate) fn new(what: &str, total: u64, output: &Output) -> Self {
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
        let form = "{msg} [{bar:30}] {human_pos} of {human_len} ({rate}/s, {eta} left)";
        if let Ok(style) = ProgressStyle::with_template(form) {
            bar.set_style(style.with_key("rate", whole_rate));
        }
        bar.set_message(what.to_owned());
        let now = runtime::clock::now_ns();
        Self {
            bar,
            what: what.to_owned(),
            total,
            done: AtomicU64::new(0),
            started_ns: now,
            said_ns: AtomicU64::new(now),
            output: *output,
        }
    }

    /// Counts patience from an earlier time `[ns]`: the work began before its size was known.
    pub(crate) fn since(mut self, begun_ns: u64) -> Self {
        self.started_ns = begun_ns;
        self
    }

    /// `more` things are done.
    pub(crate) fn add(&self, more: u64) {
        let done = self.done.fetch_add(more, Ordering::Relaxed) + more;
        let now = runtime::clock::now_ns();
        if self.output.quiet || self.output.json || now - self.started_ns < PATIENCE_NS {
            return;
        }
        if std::io::stderr().is_terminal() {
            if self.bar.is_hidden() {
                self.bar.set_draw_target(ProgressDrawTarget::stderr());
            }
            self.bar.set_position(done);
            return;
        }
        let said = self.said_ns.load(Ordering::Relaxed);
        let taken = self.said_ns.compare_exchange(said, now, Ordering::Relaxed, Ordering::Relaxed);
        match taken {
            Ok(_) if now - said >= LINE_NS => {
                let percent = 100 * done / self.total.max(1);
                crate::print::err(&format!("{}: {percent} %", self.what));
            }
            Ok(_) => self.said_ns.store(said, Ordering::Relaxed),
            Err(_) => {}
        }
    }
}

/// The rate without the four digits after the point that are indicatif's habit.
fn whole_rate(state: &ProgressState, text: &mut dyn std::fmt::Write) {
    // Where the bar cannot be written, there is nobody to tell.
    let _written = write!(text, "{}", HumanCount(state.per_sec() as u64));
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
