//! Progress of long work: a bar on a terminal, a line a minute elsewhere, nothing when quiet.

use crate::print;
use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::io::IsTerminal as _;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Delay before anything is shown.
const PATIENCE: Duration = Duration::from_secs(1);
/// Interval between lines where there is no terminal.
const LINE: Duration = Duration::from_secs(60);

/// Long work, and the display of its progress.
pub(crate) struct Progress {
    bar: ProgressBar,
    what: &'static str,
    is_shown: bool,
    begun: Instant,
    said: Mutex<Instant>,
}

impl Progress {
    /// Starts at 0; the things counted are called `what`.
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

    /// Sets the progress to `done` of `total`.
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

/// The rate, without indicatif's four decimal places.
fn whole_rate(state: &ProgressState, text: &mut dyn std::fmt::Write) {
    // If the bar cannot be written, there is nowhere to report it.
    let _written = write!(text, "{}", HumanCount(state.per_sec() as u64));
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
