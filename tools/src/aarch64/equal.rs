//! What both architectures compute: answers, models, hit sets, records, and replays of each
//! other's records.

use super::root::Root;
use anyhow::{Context as _, Result, bail};
use check::step::now;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The scenarios that are ranked, of `config/scenarios`.
pub(crate) const SCENARIOS: &[&str] = &["minimal", "wall-or-pole", "four", "small", "crossing"];

/// The scenarios that workers rank there, and whose records are replayed.
const WITH_WORKERS: &[&str] = &["minimal", "four"];

/// The bodies whose triangles are intersected: shape, number of triangles.
const BODIES: [(&str, &str); 2] = [("sedan", "20000"), ("suv", "20000")];

/// An overlap of 1 m or so, at an angle: world poses of both, as `trolley intersect` reads them.
const POSES: &str = "1 0 0 0\n0 1 0 0\n0 0 1 0\n-0.8 -0.6 0 3.8\n0.6 -0.8 0 0.4\n0 0 1 0.01\n";

/// What depends on the build and the clock in a record that was written without workers.
const OF_THE_RUN: [&str; 3] = ["build", "hash", "stages"];

/// The program for one architecture.
#[derive(Debug)]
pub(crate) struct Program<'a> {
    /// The file.
    pub(crate) file: &'a Path,
    /// Where it runs; `None`: here, without an emulator.
    pub(crate) root: Option<&'a Root>,
    /// The source, where files of `config` are.
    pub(crate) source: &'a Path,
}

/// One comparison.
#[derive(Debug)]
pub(crate) struct Row {
    /// What was computed.
    pub(crate) what: String,
    /// Hash of it here and there: BLAKE3, the first 16 digits, but for hit sets, which have their
    /// own.
    pub(crate) hashes: [String; 2],
    /// How long it took here and there (s).
    pub(crate) seconds: [f64; 2],
}

impl Row {
    /// Whether both are the same.
    pub(crate) fn is_equal(&self) -> bool {
        !self.hashes[0].is_empty() && self.hashes[0] == self.hashes[1]
    }
}

impl Program<'_> {
    /// Output of a run that succeeded, and its time (s).
    fn run(&self, words: &[&str]) -> Result<(String, f64)> {
        let file = self.file.to_str().context("a path that is no UTF-8")?;
        let mut command = match self.root {
            Some(root) => root.inside(self.source, &[&[file], words].concat()),
            None => {
                let mut command = Command::new(file);
                command.args(words).current_dir(self.source);
                command
            }
        };
        let start = now();
        let output = command.output().with_context(|| format!("cannot start {command:?}"))?;
        let seconds = start.elapsed().as_secs_f64();
        if !output.status.success() {
            let error = String::from_utf8_lossy(&output.stderr);
            bail!("trolley {}: {}\n{error}", words.join(" "), output.status);
        }
        Ok((String::from_utf8(output.stdout)?, seconds))
    }

    /// Hash of the `answer` of a ranking, byte for byte as it was written, and the time.
    pub(crate) fn answer(&self, scenario: &str, how: &[&str]) -> Result<(String, f64)> {
        let file = format!("config/scenarios/{scenario}.toml");
        let (said, seconds) = self.run(&[&["rank", &file, "--json"], how].concat())?;
        let from = said.find("\"answer\":").context("no answer")?;
        let to = said.find("\n  \"run\":").context("no run")?;
        Ok((hash(&said.as_bytes()[from..to]), seconds))
    }

    /// Hash of what a record says, but for what is of the run.
    fn record(&self, scenario: &str, folder: &Path) -> Result<(String, f64)> {
        if folder.exists() {
            fs::remove_dir_all(folder)?;
        }
        let file = format!("config/scenarios/{scenario}.toml");
        let words = ["rank", &file, "--in-process", "--json", "--record", utf8(folder)?];
        let (_, seconds) = self.run(&words)?;
        let record = folder.join("000000.record");
        let (said, _) = self.run(&["record", "show", utf8(&record)?, "--json"])?;
        let mut said: Value = serde_json::from_str(&said)?;
        let fields = said.as_object_mut().context("a record that is no table")?;
        for key in OF_THE_RUN {
            fields.remove(key).with_context(|| format!("the record has no {key}"))?;
        }
        Ok((hash(said.to_string().as_bytes()), seconds))
    }

    /// What a replay says: whether it gave the same bytes, by another build of the program.
    fn replay(&self, record: &Path) -> Result<(String, f64)> {
        let (said, seconds) = self.run(&["record", "replay", utf8(record)?, "--json"])?;
        let said: Value = serde_json::from_str(&said)?;
        let verdict = if said["same"] == true { "same bytes" } else { "OTHER BYTES" };
        let build = if said["same_build"] == true { "same build" } else { "other build" };
        Ok((format!("{verdict}, {} jobs, {build}", said["jobs"]), seconds))
    }

    /// Makes the bodies; hash of their files.
    fn models(&self, folder: &Path) -> Result<(String, f64)> {
        fs::create_dir_all(folder)?;
        let (mut bytes, mut all) = (Vec::new(), 0.0);
        for (shape, triangles) in BODIES {
            let file = folder.join(format!("{shape}.trolley"));
            let words = ["model", "generate", shape, "--triangles", triangles, "-o", utf8(&file)?];
            all += self.run(&words)?.1;
            bytes.extend(fs::read(file)?);
        }
        Ok((hash(&bytes), all))
    }

    /// Number and hash of all pairs of triangles that intersect, or of the triangles hit.
    fn hits(&self, folder: &Path, question: &str, simd: &str) -> Result<(String, f64)> {
        let bodies = BODIES.map(|(shape, _)| folder.join(format!("{shape}.trolley")));
        let poses = folder.join("poses.txt");
        fs::write(&poses, POSES)?;
        let [a, b, poses] = [&bodies[0], &bodies[1], &poses].map(|path| utf8(path));
        let flags = ["--json", "--repeat", "1", "--simd", simd, "--question", question];
        let words = [&["intersect", a?, b?, "--poses", poses?][..], &flags].concat();
        let (said, seconds) = self.run(&words)?;
        let said: Value = serde_json::from_str(&said)?;
        let field = |key: &str| said[key].as_str().map_or(said[key].to_string(), str::to_owned);
        let keys: &[&str] = match question {
            "pairs" => &["pairs", "hash"],
            _ => &["hits_a", "hash_a", "hits_b", "hash_b"],
        };
        let values: Vec<String> = keys.iter().map(|key| field(key)).collect();
        if values.contains(&"0".to_owned()) {
            bail!("the bodies do not touch: {said}");
        }
        Ok((values.join(" "), seconds))
    }
}

/// The answer of the smallest scenario, on both.
pub(crate) fn quick(here: &Program<'_>, there: &Program<'_>) -> Result<Row> {
    both("answer, minimal, in process", here, there, |program| {
        program.answer("minimal", &["--in-process"])
    })
}

/// All comparisons; files go into a folder that both see, and stay there.
pub(crate) fn all(
    here: &Program<'_>,
    there: &Program<'_>,
    place: &Path,
    mut tell: impl FnMut(&Row) -> Result<()>,
) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let mut add = |row: Result<Row>| {
        let row = row?;
        tell(&row)?;
        rows.push(row);
        Ok::<_, anyhow::Error>(())
    };
    for scenario in SCENARIOS {
        let what = format!("answer, {scenario}, in process");
        add(both(&what, here, there, |program| program.answer(scenario, &["--in-process"])))?;
    }
    for scenario in WITH_WORKERS {
        let what = format!("answer, {scenario}, two workers");
        add(both(&what, here, there, |program| program.answer(scenario, &["--workers", "2"])))?;
    }
    let folder = |program: &Program<'_>, name: &str| {
        let side = if program.root.is_some() { "there" } else { "here" };
        place.join(side).join(name)
    };
    let (shape, triangles) = BODIES[0];
    let what = format!("model files, {shape} and {}, {triangles} triangles each", BODIES[1].0);
    add(both(&what, here, there, |program| program.models(&folder(program, "models"))))?;
    for question in ["pairs", "sets"] {
        for [ours, theirs] in [["auto", "neon"], ["sse2", "neon"]] {
            let what = format!("hit {question}, vectors here {ours}, there {theirs}");
            add(both(&what, here, there, |program| {
                let simd = if program.root.is_some() { theirs } else { ours };
                program.hits(&folder(program, "models"), question, simd)
            }))?;
        }
    }
    for scenario in WITH_WORKERS {
        let name = format!("records-{scenario}");
        let what = format!("record, {scenario}, in process");
        add(both(&what, here, there, |program| program.record(scenario, &folder(program, &name))))?;
        let what = format!("replay of the other's record, {scenario}");
        add(both(&what, here, there, |program| {
            let other = if program.root.is_some() { here } else { there };
            program.replay(&folder(other, &name).join("000000.record"))
        }))?;
    }
    Ok(rows)
}

fn both(
    what: &str,
    here: &Program<'_>,
    there: &Program<'_>,
    run: impl Fn(&Program<'_>) -> Result<(String, f64)>,
) -> Result<Row> {
    let (ours, ours_s) = run(here).with_context(|| format!("{what}, here"))?;
    let (theirs, theirs_s) = run(there).with_context(|| format!("{what}, there"))?;
    Ok(Row { what: what.to_owned(), hashes: [ours, theirs], seconds: [ours_s, theirs_s] })
}

fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex()[..16].to_owned()
}

fn utf8(path: &Path) -> Result<&str> {
    path.to_str().context("a path that is no UTF-8")
}

/// Builds the program for this machine; where it is.
pub(crate) fn build_here() -> Result<PathBuf> {
    check::built::executable(check::step::cargo().arg("build").args(super::BUILD))
}
