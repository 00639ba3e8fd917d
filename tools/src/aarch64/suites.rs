//! What is tested there: built once, run one after the other, and not again while nothing changed.

mod pure_crates;

use super::root::{Root, TARGET};
use anyhow::{Context as _, Result, bail};
use check::step::{TestTally, now};
use pure_crates::PURE;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::fs;
use std::path::{Path, PathBuf};

/// Tests of the whole program: target, and the module of it that runs. A run may be broken off:
/// first is what no comparison with this machine shows.
const WHOLE: &[(&str, &str)] = &[
    ("processes", "kill::"),
    ("answers", "identical::"),
    ("processes", "serve::"),
    ("answers", "oracle::"),
    ("answers", "record::"),
    ("files", "intersect::"),
];

/// No suite takes longer than this (s): an emulator that hangs would take for ever.
const LONGEST_S: u32 = 3_600;

/// How many times as long tests wait for others, and programs that are told to end may take.
const PATIENCE: u32 = 20;

/// One test program with a filter.
#[derive(Debug)]
pub(crate) struct Suite {
    /// What it is called on the page.
    pub(crate) name: String,
    program: PathBuf,
    /// Where cargo would start it.
    folder: PathBuf,
    filter: Option<&'static str>,
    /// One test at a time: whoever does not end soon after a signal is ended by force, and under an
    /// emulator soon is long only for who has a core.
    is_alone: bool,
    env: Vec<String>,
}

/// How a suite ended.
#[derive(Clone, Debug)]
pub(crate) struct Ended {
    /// What it is called on the page.
    pub(crate) name: String,
    /// What it counted.
    pub(crate) tally: TestTally,
    /// How long it took on the wall (s).
    pub(crate) seconds: f64,
    /// Names of tests that failed, and `ended early` if there is no closing line.
    pub(crate) failed: Vec<String>,
}

/// What was built for the target.
#[derive(Debug)]
pub(crate) struct Built {
    /// The program, if it was asked for.
    trolley: Option<PathBuf>,
    /// Test programs by package folder and target.
    tests: BTreeMap<(String, String), PathBuf>,
}

/// How the service and its client library are built for tests: optimised for speed everywhere.
pub(crate) const BUILD: &[&str] = &without_laboratory("--release");

/// How they are built for packages: small, but for what a request goes through.
pub(crate) const PACKED: &[&str] = &without_laboratory("--profile=vehicle");

const fn without_laboratory(profile: &str) -> [&str; 5] {
    let packages = ["--package=trolley-cli", "--package=trolley-client-c"];
    [profile, "--locked", "--no-default-features", packages[0], packages[1]]
}

/// Builds the service and its client library for the target, one way or the other.
pub(crate) fn build_program(root: &Root, source: &Path, how: &[&str]) -> Result<Built> {
    build(root, source, &[&["cargo", "build"], how].concat(), how == PACKED)
}

impl Built {
    /// Where the program is.
    pub(crate) fn program(&self) -> Result<PathBuf> {
        self.trolley.clone().context("cargo made no program")
    }
}

/// Builds the program, the tests of it as a whole, and the exact oracle.
pub(crate) fn build_whole(root: &Root, source: &Path) -> Result<Built> {
    let mut words = vec!["cargo", "test", "--no-run", "--package=trolley-geometry"];
    for target in ["oracle", "answers", "files", "processes"] {
        words.extend(["--test", target]);
    }
    build(root, source, &[&words, BUILD].concat(), false)
}

/// Builds the unit tests of pure crates, beside what was built.
pub(crate) fn build_units(root: &Root, source: &Path, built: &mut Built) -> Result<()> {
    let packages: Vec<String> =
        PURE.iter().map(|name| format!("--package=trolley-{name}")).collect();
    let mut words = vec!["cargo", "test", "--no-run", "--lib", "--release", "--locked"];
    words.extend(packages.iter().map(String::as_str));
    let units = build(root, source, &words, false)?;
    built.tests.extend(units.tests);
    Ok(())
}

fn build(root: &Root, source: &Path, words: &[&str], ships: bool) -> Result<Built> {
    let how = ["--target", TARGET, "--message-format=json-render-diagnostics"];
    // `runtime/src/guard.rs` reads it.
    let slowness = (!ships).then(|| format!("TROLLEY_SLOWNESS={PATIENCE}"));
    let words: Vec<&str> = slowness.as_deref().into_iter().chain([words, &how].concat()).collect();
    let said = check::built::output(&mut root.inside(source, &words))?;
    let (mut trolley, mut tests) = (None, BTreeMap::new());
    for message in said.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok()) {
        let Some(program) = message["executable"].as_str().map(PathBuf::from) else { continue };
        let target = message["target"]["name"].as_str().unwrap_or_default().to_owned();
        let manifest = Path::new(message["manifest_path"].as_str().unwrap_or_default());
        let folder = manifest.parent().and_then(Path::file_name).unwrap_or_default();
        if message["profile"]["test"] == true {
            tests.insert((folder.to_string_lossy().into_owned(), target), program);
        } else if target == "trolley" {
            trolley = Some(program);
        }
    }
    Ok(Built { trolley, tests })
}

/// Which suites to run; shown, what they are.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Which {
    /// The program as a whole, and the exact oracle on so many pairs.
    Whole(u64),
    /// The unit tests of pure crates.
    Units,
}

impl Display for Which {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Whole(_) => "tests of the whole program, and the exact oracle",
            Self::Units => "unit tests of the pure crates",
        })
    }
}

/// The suites, in their order, from what was built.
pub(crate) fn suites(source: &Path, built: &Built, which: Which) -> Result<Vec<Suite>> {
    let suite = |folder: &str, target: &str, filter: Option<&'static str>| {
        let key = (folder.to_owned(), target.to_owned());
        let program = built.tests.get(&key).with_context(|| format!("{folder}: no {target}"))?;
        Ok::<_, anyhow::Error>(Suite {
            name: filter.map_or(format!("{folder}, unit tests"), |filter| {
                format!("{target}, {}", filter.trim_end_matches("::"))
            }),
            program: program.clone(),
            folder: source.join("crates").join(folder),
            filter,
            is_alone: target == "processes",
            env: vec![format!("TROLLEY_TEST_PATIENCE={PATIENCE}")],
        })
    };
    let mut suites = Vec::new();
    match which {
        Which::Units => {
            for folder in PURE {
                suites.push(suite(folder, &format!("trolley_{folder}"), None)?);
            }
        }
        Which::Whole(pairs) => {
            for (target, filter) in WHOLE {
                suites.push(suite("cli", target, Some(filter))?);
            }
            let mut oracle = suite("geometry", "oracle", None)?;
            oracle.name = format!("exact oracle, {pairs} pairs of triangles");
            oracle.env.extend([format!("ORACLE_PAIRS={pairs}"), "ORACLE_SEED=1".to_owned()]);
            suites.push(oracle);
        }
    }
    Ok(suites)
}

impl Suite {
    /// Runs it, unless the same bytes were run with the same words before: then that run counts.
    pub(crate) fn run(&self, root: &Root) -> Result<Ended> {
        let log = root.place.join("suites").join(format!("{}.log", self.key()?));
        if let Ok(said) = fs::read_to_string(&log)
            && let Some((seconds, said)) = said.split_once(" s\n")
        {
            return Ok(self.ended(seconds.parse()?, said));
        }
        let limit = LONGEST_S.to_string();
        let mut words: Vec<&str> = self.env.iter().map(String::as_str).collect();
        words.extend(["timeout", "--kill-after=10", &limit]);
        words.push(self.program.to_str().context("a path that is no UTF-8")?);
        words.extend(self.filter);
        if self.is_alone {
            words.push("--test-threads=1");
        }
        let start = now();
        let output = root.inside(&self.folder, &words).output().context("cannot start unshare")?;
        let seconds = start.elapsed().as_secs_f64();
        let said = String::from_utf8_lossy(&output.stdout);
        let more = String::from_utf8_lossy(&output.stderr);
        let ended = self.ended(seconds, &said);
        let folder = log.parent().context("a file without a folder")?;
        fs::create_dir_all(folder)?;
        if ended.failed.is_empty() && output.status.success() {
            fs::write(&log, format!("{seconds:.1} s\n{said}{more}"))?;
        } else {
            fs::write(log.with_extension("failed"), format!("{}\n{said}{more}", self.name))?;
        }
        if ended.tally.is_empty() && output.status.success() {
            bail!("{}: ran no test\n{more}", self.name);
        }
        Ok(ended)
    }

    /// What decides how it ends: the programs, and what they are told.
    fn key(&self) -> Result<String> {
        let mut hash = blake3::Hasher::new();
        hash.update(&fs::read(&self.program)?);
        // Tests of the whole program start it.
        if let Some(folder) = self.program.parent().and_then(Path::parent)
            && self.filter.is_some()
        {
            hash.update(&fs::read(folder.join("trolley"))?);
        }
        hash.update(self.filter.unwrap_or_default().as_bytes());
        for pair in &self.env {
            hash.update(pair.as_bytes());
        }
        Ok(hash.finalize().to_hex()[..16].to_owned())
    }

    fn ended(&self, seconds: f64, said: &str) -> Ended {
        let mut tally = TestTally::default();
        said.lines().filter_map(TestTally::of).for_each(|closing| tally.add(&closing));
        // `test NAME ... FAILED`; output of another test may stand between.
        let name = |line: &str| {
            let (name, _) = line.strip_prefix("test ")?.split_once(" ... ")?;
            line.ends_with("FAILED").then(|| name.to_owned())
        };
        let mut failed: Vec<String> = said.lines().filter_map(name).collect();
        if tally.is_empty() {
            failed.push("ended early".into());
        }
        Ended { name: self.name.clone(), tally, seconds, failed }
    }
}
