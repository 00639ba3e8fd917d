//! `cargo x`: the tasks of this workspace.
//!
//! Each task starts cargo or what cargo has built. Nothing that ships depends on this program. What
//! every change must pass is in `tools/check`, whose program comes first and starts this one.

mod aarch64;
mod bench;
mod bounds;
mod compare;
mod count;
mod deb;
mod engines;
mod faults;
mod gallery;
mod inputs;
mod machine;
mod mutants;
mod needs;
mod oracle;
mod scenarios;
mod wheel;

use anyhow::Result;
use check::steps;
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Tasks of this workspace.
#[derive(Debug, Parser)]
#[command(name = "cargo x", bin_name = "cargo x")]
struct Args {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Format, clippy and docs with warnings denied, all tests, and packages: what CI runs.
    ///
    /// Stops at the first step that fails, shows its output, and exits with its exit code.
    Check {
        /// Leave out documentation and packages.
        #[arg(long)]
        quick: bool,
    },
    /// Compare the triangle test and first contact with exact rational arithmetic, on any number of
    /// pairs.
    ///
    /// Equal seeds give equal pairs. A million pairs take one core about three and a half minutes,
    /// one of them for first contact.
    Oracle {
        /// Number of pairs of triangles; `cargo x check` includes 20,000.
        #[arg(long, value_name = "N", default_value_t = 1_000_000)]
        pairs: u64,
        /// Seed of the pairs.
        #[arg(long, value_name = "S", default_value_t = 1)]
        seed: u64,
        /// Only first contact along a straight line.
        #[arg(long)]
        first_contact: bool,
    },
    /// Time the kernels with criterion: triangle tests, queries, tree builds.
    Bench {
        /// Use shorter runs, with wider margins.
        #[arg(long)]
        quick: bool,
        /// Run only benchmarks whose names contain this.
        filter: Option<String>,
    },
    /// Compute what deployments take, hold it against services at their limits, and measure what
    /// jobs cost that are made to be dear. Writes tools/results/bounds.md.
    Bounds(bounds::Options),
    /// Count the kernels' instructions with valgrind and compare them with the record.
    ///
    /// Fails if a count is more than 3 % higher. The record is tools/results/instructions.tsv.
    Count {
        /// Write the record instead.
        #[arg(long)]
        record: bool,
    },
    /// Compare the kernel with other libraries, in one interleaved run on one core.
    ///
    /// The peers are C++ drivers that are compiled here if the Debian packages are installed
    /// (libembree-dev, libfcl-dev libeigen3-dev; for the exact oracle libcgal-dev libgmp-dev
    /// libmpfr-dev), and parry3d. With --first-contact, bodies move, and ipctk is asked too if
    /// python3 has it. Fails if an answer of Trolley is wrong.
    Compare(compare::Options),
    /// Simulate a million requests with faults; stops at the first violated invariant.
    Soak {
        /// Number of worlds, of four requests each.
        #[arg(long, value_name = "N", default_value_t = 250_000)]
        worlds: u64,
        /// Seed of the first world.
        #[arg(long, value_name = "N", default_value_t = 0)]
        from: u64,
    },
    /// Explore all states of small worlds of the job protocol, and flaws that must be caught.
    Model,
    /// Try ten million corrupted messages, none of which may be accepted.
    Corrupt,
    /// Fuzz parsers and decoders with libFuzzer, guided by coverage.
    Fuzz(faults::FuzzOptions),
    /// Check rankings against exact intersection at dense steps of time.
    ///
    /// Files are scenarios, or traffic, of which scenarios are made. Fails if the search missed a
    /// contact, or invented one.
    Scenarios(scenarios::Options),
    /// Read every file of public collections, and say what was loaded, what was refused, and why.
    ///
    /// Fails if the program fell, or took more time or memory than it may.
    Inputs(inputs::Options),
    /// Build for ARM, test under an emulator, and compare with this machine.
    ///
    /// Makes a Debian root file system once, with a compiler and an emulator, in target/aarch64 or
    /// $TROLLEY_AARCH64_ROOT, as root. What is done already is not done again. The page is
    /// tools/results/aarch64.md.
    Aarch64(aarch64::Options),
    /// Make Debian packages for amd64 and arm64, and try them in clean systems.
    ///
    /// As root, with lintian and debootstrap. Each is installed, started, asked, upgraded and
    /// removed in a system that has nothing yet; arm64 under an emulator. The page is
    /// tools/results/deb.md.
    Deb(deb::Options),
    /// Write requirements, assumptions and failure modes as needs.json, for sphinx-needs.
    Needs(needs::Options),
    /// Change dispatcher and ranking in small ways, each of which a test must notice.
    ///
    /// Needs cargo-mutants. What an earlier run caught is not tried again. Fails if a change that
    /// no test notices is not explained in tools/safety/mutants.toml. The page is
    /// tools/results/mutants.md.
    Mutants(mutants::Options),
    /// Draw the crashes of the demo and of real bodies: stills, and a page that shows them.
    Gallery(gallery::Options),
    /// Build the Python package, and try it in an empty environment without cargo.
    ///
    /// Needs python3 with venv, and an index of packages for pip. CI does not run it: `cargo x
    /// check` builds the crate, this its wheel.
    Wheel(wheel::Options),
    /// Have every engine run one study, kill Ray nodes and drivers, and compare all rows.
    ///
    /// As root, with python3, an index of packages, unshare and ip: Ray runs in a network namespace
    /// of its own. The page is tools/results/study/engines.md.
    Engines(engines::Options),
}

fn main() -> Result<ExitCode> {
    match Args::parse().task {
        Task::Check { quick: false } => steps::run(steps::STEPS),
        Task::Check { quick: true } => steps::run(steps::quick()),
        Task::Oracle { pairs, seed, first_contact } => {
            let part = if first_contact { oracle::Part::FirstContact } else { oracle::Part::All };
            oracle::run(part, pairs, seed)
        }
        Task::Bench { quick, filter } => bench::run(quick, filter.as_deref()),
        Task::Count { record } => count::run(record),
        Task::Bounds(options) => bounds::run(&options),
        Task::Compare(options) => compare::run(&options),
        Task::Soak { worlds, from } => faults::soak(worlds, from),
        Task::Model => faults::model(),
        Task::Corrupt => faults::corrupt(),
        Task::Fuzz(options) => faults::fuzz(&options),
        Task::Scenarios(options) => scenarios::run(&options),
        Task::Inputs(options) => inputs::run(&options),
        Task::Aarch64(options) => aarch64::run(&options),
        Task::Deb(options) => deb::run(&options),
        Task::Needs(options) => needs::run(&options),
        Task::Mutants(options) => mutants::run(&options),
        Task::Gallery(options) => gallery::run(&options),
        Task::Wheel(options) => wheel::run(&options),
        Task::Engines(options) => engines::run(&options),
    }
}
