//! Progress of long work: a bar on a terminal, a line a minute elsewhere, nothing when quiet.

use crate::print;
use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::io::IsTerminal as _;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Nothing is shown before work has taken this long.
const PATIENCE: Duration = Duration::from_secs(1);
/// Where there is no terminal, one line in this time.
const LINE: Duration = Duration::from_secs(60);

/// Long work, and how it is shown.
pub(crate) struct Progress {
    bar: ProgressBar,
    what: &'static str,
    is_shown: bool,
    begun: Instant,
    said: Mutex<Instant>,
}

impl Progress {
    /// Nothing done yet of things that are called `what`.
    #[expect(clippy::disallowed_methods, reason = "for a person to read; nothing is decided by it")]
    pub(crate) fn new(what: &'static str, is_shown: bool) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        let form = "{msg} [{bar:30}] {human_pos} of {human_len} ({rate}/s, {eta} left)";
        if let Ok(style) = ProgressStyle::with_template(form) {
            bar.set_style(style.with_key("rate", whole_rate));
        }
        bar.set_message(what);
        let now = Instant::now();
        Self { bar, what, is_shown, begun: now, said: Mutex::new(now) }
    }

    /// So many of so many are done.
    pub(crate) fn set(&self, done: u64, total: u64) {
        if !self.is_shown || self.begun.elapsed() < PATIENCE {
            return;
        }
        if std::io::stderr().is_terminal() {
            if self.bar.is_hidden() {
                self.bar.set_draw_target(ProgressDrawTarget::stderr());
            }
            self.bar.set_length(total);
            self.bar.set_position(done);
            return;
        }
        let Ok(mut said) = self.said.try_lock() else { return };
        if said.elapsed() >= LINE {
            let since = said.elapsed();
            *said += since;
            print::err(&format!("{}: {} %", self.what, 100 * done / total.max(1)));
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
