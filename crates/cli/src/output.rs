//! How results and progress are shown.

use crate::print;
use crate::progress::Progress;

/// What a person said of it, for any command.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Output {
    /// One JSON document on stdout and nothing else.
    pub(crate) json: bool,
    /// No progress, and errors only.
    pub(crate) quiet: bool,
}

impl Output {
    /// Whether a person reads along at stderr.
    pub(crate) fn is_talkative(&self) -> bool {
        !self.json && !self.quiet
    }

    /// Says a line on stderr to a person who reads along.
    pub(crate) fn say(&self, line: &str) {
        if self.is_talkative() {
            print::err(line);
        }
    }

    /// Shows how far long work is, which is counted in `what`.
    pub(crate) fn progress(&self, what: &'static str) -> Progress {
        Progress::new(what, self.is_talkative())
    }
}
