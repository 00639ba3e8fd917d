//! How results and progress are shown.

use crate::print;
use crate::progress::Progress;

/// The output flags of all commands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Output {
    /// One JSON document on stdout and nothing else.
    pub(crate) json: bool,
    /// Show no progress, and log errors only.
    pub(crate) quiet: bool,
}

impl Output {
    /// Whether a person reads stderr.
    pub(crate) fn is_talkative(&self) -> bool {
        !self.json && !self.quiet
    }

    /// Prints a line on stderr if a person reads it.
    pub(crate) fn say(&self, line: &str) {
        if self.is_talkative() {
            print::err(line);
        }
    }

    /// Shows the progress of long work, counted in `what`.
    pub(crate) fn progress(&self, what: &'static str) -> Progress {
        Progress::new(what, self.is_talkative())
    }
}
