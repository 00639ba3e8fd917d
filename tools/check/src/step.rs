//! One run of cargo, or of what it has built: prints a line with its time on success, its whole
//! output on failure.
//!
//! The summary lines of test runners are always shown, and so are tests skipped because a tool is
//! missing, and that cargo waits for another one.

#[cfg(test)]
mod tests;

use crate::built::CargoWorkspace;
use anyhow::{Context as _, Result};
use std::ffi::OsString;
use std::io::{self, BufRead as _, BufReader, Write};
use std::process::{Command, ExitCode, ExitStatus, Output, Stdio};
use std::time::Instant;

/// What to run.
#[derive(Debug)]
pub struct CheckStep {
    /// Its name in the output.
    pub name: &'static str,
    /// What is run.
    pub program: Program,
    /// Its arguments.
    pub args: &'static [&'static str],
    /// Additional environment variables.
    pub env: &'static [(&'static str, &'static str)],
}

/// What a step runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Program {
    /// The cargo that started us.
    Cargo,
    /// An example of this name, as the tests have built it: `cargo run` would build it anew, with
    /// the features of its package alone.
    Example(&'static str),
}

/// The outcome, and all that was said.
#[derive(Debug)]
pub struct StepOutcome(ExitStatus, Vec<u8>);

impl StepOutcome {
    /// The outcome of a command whose output was kept.
    #[must_use]
    pub fn of(Output { status, mut stdout, stderr }: Output) -> Self {
        stdout.extend(stderr);
        Self(status, stdout)
    }

    /// The exit code to pass on; `None` if all was well.
    #[must_use]
    pub fn failure(&self) -> Option<ExitCode> {
        failure(self.0)
    }

    /// What it said, on both streams.
    #[must_use]
    pub fn said(&self) -> std::borrow::Cow<'_, str> {
        String::from_utf8_lossy(&self.1)
    }
}

impl CheckStep {
    /// A run of cargo.
    #[must_use]
    pub const fn cargo(name: &'static str, args: &'static [&'static str]) -> Self {
        Self { name, program: Program::Cargo, args, env: &[] }
    }

    /// A run of an example.
    #[must_use]
    pub const fn example(example: &'static str, args: &'static [&'static str]) -> Self {
        Self { name: "example", program: Program::Example(example), args, env: &[] }
    }

    /// Runs it to its end, reporting to `out`.
    ///
    /// # Errors
    ///
    /// If the program cannot be started, or `out` cannot be written.
    pub fn run(&self, out: &mut impl Write) -> Result<StepOutcome> {
        self.run_with(|_cargo| {}, out)
    }

    /// Like [`Self::run`], with what `adapt` adds to the command, which is not printed.
    fn run_with(
        &self,
        adapt: impl FnOnce(&mut Command),
        out: &mut impl Write,
    ) -> Result<StepOutcome> {
        let (program, mut command) = match self.program {
            Program::Cargo => ("cargo", cargo()),
            Program::Example(name) => {
                let built = CargoWorkspace::find()?.target.join("debug/examples").join(name);
                (name, Command::new(built))
            }
        };
        command.args(self.args).envs(self.env.iter().copied());
        adapt(&mut command);
        let line = core::iter::once(&program).chain(self.args).copied().collect::<Vec<_>>();
        let line = line.join(" ");

        write!(out, "{:<7} {line} ... ", self.name)?;
        out.flush()?;
        let start = now();
        // One pipe for both streams keeps their order.
        let (reader, writer) = io::pipe()?;
        command.stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer);
        let mut child = command.spawn().with_context(|| format!("cannot start {line}"))?;
        // It holds the last writing ends but the child's: without them, reading comes to an end.
        drop(command);

        let mut said = Vec::new();
        let (mut tests, mut has_shown) = (TestTally::default(), false);
        let mut reader = BufReader::new(reader);
        let mut from = 0;
        while reader.read_until(b'\n', &mut said)? > 0 {
            let text = String::from_utf8_lossy(&said[from..]);
            let closing = TestTally::of(&text);
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
            writeln!(out, "{:<7} {line}: {status}", self.name)?;
        }
        Ok(StepOutcome(status, said))
    }
}

/// Runs a command with the streams of this one; its exit code is ours.
///
/// # Errors
///
/// If it cannot be started.
pub fn pass_on(command: &mut Command) -> Result<ExitCode> {
    let status = command.status().with_context(|| format!("cannot start {command:?}"))?;
    Ok(failure(status).unwrap_or(ExitCode::SUCCESS))
}

/// The cargo that started us.
#[must_use]
pub fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo")))
}

/// The exit code to pass on; `None` if all was well.
fn failure(status: ExitStatus) -> Option<ExitCode> {
    // A signal has no exit code.
    let code = || status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1);
    (!status.success()).then(|| ExitCode::from(code()))
}

/// When a step begins.
#[expect(clippy::disallowed_methods, reason = "for a person to read; nothing is decided by it")]
#[must_use]
pub fn now() -> Instant {
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
pub struct TestTally {
    /// Closing lines.
    pub runners: u64,
    /// Tests that passed.
    pub passed: u64,
    /// Tests that failed.
    pub failed: u64,
    /// Tests that were left out.
    pub ignored: u64,
}

impl TestTally {
    /// What a line says, if it is a closing line:
    /// `test result: ok. 3 passed; 0 failed; 1 ignored; ...`.
    #[must_use]
    pub fn of(line: &str) -> Option<Self> {
        let (_verdict, counts) = line.strip_prefix("test result: ")?.split_once(". ")?;
        let count = |what: &str| {
            let mut counts = counts.split(';').filter_map(|part| part.trim().split_once(' '));
            counts.find(|(_, name)| *name == what)?.0.parse().ok()
        };
        let (passed, failed) = (count("passed")?, count("failed")?);
        Some(Self { runners: 1, passed, failed, ignored: count("ignored")? })
    }

    /// Adds another sum.
    pub fn add(&mut self, other: &Self) {
        self.runners += other.runners;
        self.passed += other.passed;
        self.failed += other.failed;
        self.ignored += other.ignored;
    }

    /// Whether there was no closing line.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.runners == 0
    }
}

impl std::fmt::Display for TestTally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { runners, passed, failed, ignored } = self;
        write!(f, "{runners} runners: {passed} passed, {failed} failed, {ignored} ignored")
    }
}
