//! One run of cargo: prints a line with its time on success, its whole output on failure.
//!
//! The summary lines of test runners are always shown, and so are tests skipped because a tool is
//! missing, and that cargo waits for another one.

#[cfg(test)]
mod tests;

use anyhow::{Context as _, Result};
use std::ffi::OsString;
use std::io::{self, BufRead as _, BufReader, Write};
use std::process::{Command, ExitCode, ExitStatus, Output, Stdio};
use std::time::Instant;

/// What to run.
#[derive(Debug)]
pub(crate) struct Step {
    /// Its name in the output.
    pub(crate) name: &'static str,
    /// Arguments of cargo.
    pub(crate) args: &'static [&'static str],
    /// Additional environment variables.
    pub(crate) env: &'static [(&'static str, &'static str)],
}

/// The outcome, and all that was said.
#[derive(Debug)]
pub(crate) struct Outcome(ExitStatus, Vec<u8>);

impl Outcome {
    /// The outcome of a command whose output was kept.
    pub(crate) fn of(Output { status, mut stdout, stderr }: Output) -> Self {
        stdout.extend(stderr);
        Self(status, stdout)
    }

    /// The exit code to pass on; `None` if all was well.
    pub(crate) fn failure(&self) -> Option<ExitCode> {
        // A signal has no exit code.
        let code = || self.0.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1);
        (!self.0.success()).then(|| ExitCode::from(code()))
    }

    /// What it said, on both streams.
    pub(crate) fn said(&self) -> std::borrow::Cow<'_, str> {
        String::from_utf8_lossy(&self.1)
    }
}

impl Step {
    /// Runs it to its end, reporting to `out`.
    pub(crate) fn run(&self, out: &mut impl Write) -> Result<Outcome> {
        self.run_with(|_cargo| {}, out)
    }

    /// Like [`Self::run`], with what `adapt` adds to the command, which is not printed.
    fn run_with(&self, adapt: impl FnOnce(&mut Command), out: &mut impl Write) -> Result<Outcome> {
        let mut command = cargo();
        command.args(self.args).envs(self.env.iter().copied());
        adapt(&mut command);
        let line = self.args.join(" ");

        write!(out, "{:<7} cargo {line} ... ", self.name)?;
        out.flush()?;
        let start = now();
        // One pipe for both streams keeps their order.
        let (reader, writer) = io::pipe()?;
        command.stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer);
        let mut child = command.spawn().with_context(|| format!("cannot start cargo {line}"))?;
        // It holds the last writing ends but the child's: without them, reading comes to an end.
        drop(command);

        let mut said = Vec::new();
        let (mut tests, mut has_shown) = (Tally::default(), false);
        let mut reader = BufReader::new(reader);
        let mut from = 0;
        while reader.read_until(b'\n', &mut said)? > 0 {
            let text = String::from_utf8_lossy(&said[from..]);
            let closing = Tally::of(&text);
            let shown = if closing.is_some() { Some(&*text) } else { skipped(&text) };
            let waits = waits(&text);
            let shown = shown.or(waits.as_deref());
            if let Some(shown) = shown {
                let before = if std::mem::replace(&mut has_shown, true) { "" } else { "\n" };
                write!(out, "{before}{shown}")?;
            }
            tests.add(&closing.unwrap_or_default());
            from = said.len();
        }
        let status = child.wait()?;

        let seconds = start.elapsed().as_secs_f64();
        if tests.runners > 0 {
            write!(out, "{:<7} {tests} ... ", self.name)?;
        } else if has_shown {
            write!(out, "{:<7} ", self.name)?;
        }
        writeln!(out, "{} {seconds:.1} s", if status.success() { "ok" } else { "FAILED" })?;
        if !status.success() {
            out.write_all(&said)?;
            writeln!(out, "{:<7} cargo {line}: {status}", self.name)?;
        }
        Ok(Outcome(status, said))
    }
}

/// The cargo that started us.
pub(crate) fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo")))
}

#[expect(clippy::disallowed_methods, reason = "for a person to read; nothing is decided by it")]
pub(crate) fn now() -> Instant {
    Instant::now()
}

/// What to say when cargo waits for a lock that another cargo holds: its line is the only sign.
fn waits(line: &str) -> Option<String> {
    let lock = line.trim().strip_prefix("Blocking waiting for file lock on ")?;
    Some(format!(
        "        waits for another cargo, which holds the lock of the {lock}; ends when that does\n"
    ))
}

/// What a line says that a test has left out; it may begin with that of another test.
fn skipped(line: &str) -> Option<&str> {
    line.find("SKIPPED: ").map(|at| &line[at..])
}

/// Sums over the closing lines of test runners.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    /// Closing lines.
    pub(crate) runners: u64,
    /// Tests that passed.
    pub(crate) passed: u64,
    /// Tests that failed.
    pub(crate) failed: u64,
    /// Tests that were left out.
    pub(crate) ignored: u64,
}

impl Tally {
    /// What a line says, if it is a closing line:
    /// `test result: ok. 3 passed; 0 failed; 1 ignored; ...`.
    pub(crate) fn of(line: &str) -> Option<Self> {
        let (_verdict, counts) = line.strip_prefix("test result: ")?.split_once(". ")?;
        let count = |what: &str| {
            let mut counts = counts.split(';').filter_map(|part| part.trim().split_once(' '));
            counts.find(|(_, name)| *name == what)?.0.parse().ok()
        };
        let (passed, failed) = (count("passed")?, count("failed")?);
        Some(Self { runners: 1, passed, failed, ignored: count("ignored")? })
    }

    /// Adds another sum.
    pub(crate) fn add(&mut self, other: &Self) {
        self.runners += other.runners;
        self.passed += other.passed;
        self.failed += other.failed;
        self.ignored += other.ignored;
    }

    /// Whether there was no closing line.
    pub(crate) fn is_empty(&self) -> bool {
        self.runners == 0
    }
}

impl std::fmt::Display for Tally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { runners, passed, failed, ignored } = self;
        write!(f, "{runners} runners: {passed} passed, {failed} failed, {ignored} ignored")
    }
}
