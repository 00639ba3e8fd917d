//! The plan of a study: what is ranked, in which order, in which shards; and its folder.
//!
//! ```text
//! DIR/plan.json               axes, inputs, counts; its hash is the study's id
//! DIR/inputs/0000/            a scene as given: scenario.toml and the files that it names
//! DIR/inputs.parquet          the same as a table
//! DIR/judges/                 policies, curves and parameters, each a text
//! DIR/shards/000000/          a finished shard: three tables and a seal
//! DIR/attempts/               who began which shard, and which scenes processes died of
//! DIR/tmp/                    what is being written
//! ```
//!
//! A folder is whole: it can be copied to another machine, and names nothing outside of it.

use crate::inputs::{self, Input};
use crate::knob::SweepKnob;
use crate::rows;
use crate::spec::{Placed, RowSelection, SCHEMA, StudySpec};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use trolley::files::{self, InputKind};
use trolley::{BUILD, Failure, FailureKind, SourceText, Worlds};

/// Most scenes of a study.
const SCENES_MAX: u64 = 1_000_000_000;

/// A study that was planned.
#[derive(Clone, Debug)]
pub struct Plan {
    dir: PathBuf,
    file: PlanFile,
    judges: Judges,
}

/// `plan.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlanFile {
    pub(crate) schema: String,
    /// Hash of all that follows.
    pub(crate) id: String,
    pub(crate) build: String,
    pub(crate) name: String,
    pub(crate) spec: String,
    pub(crate) members: [i64; 2],
    pub(crate) worlds: i64,
    pub(crate) scene_limit_s: f64,
    pub(crate) scenes_per_shard: u32,
    pub(crate) candidates: RowSelection,
    pub(crate) persons: RowSelection,
    pub(crate) policies: Vec<Judge>,
    pub(crate) curves: Vec<Judge>,
    pub(crate) parameters: Vec<Judge>,
    pub(crate) sweeps: Vec<Sweep>,
    pub(crate) inputs: Vec<Input>,
    pub(crate) scenes: u64,
}

/// A policy, a set of curves or of parameters.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Judge {
    /// As the specification names it.
    pub(crate) name: String,
    /// In the folder of the study.
    pub(crate) file: String,
    pub(crate) hash: String,
}

/// What is swept, and over which values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Sweep {
    pub(crate) knob: SweepKnob,
    pub(crate) values: Vec<f64>,
}

/// The texts of policies, curves and parameters.
#[derive(Clone, Debug, Default)]
pub(crate) struct Judges {
    pub(crate) policies: Vec<SourceText>,
    pub(crate) curves: Vec<SourceText>,
    pub(crate) parameters: Vec<SourceText>,
}

/// One scene of a study: an input, parameters, and a value of each sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneKey {
    /// Its number.
    pub scene: u64,
    /// Number of the input.
    pub input: usize,
    /// Number of the parameters.
    pub parameters: usize,
    /// The value of each sweep, in the order of the plan.
    pub values: Vec<(SweepKnob, f64)>,
}

/// Plans a study, and writes its folder. The same specification, inputs and build give the same
/// plan; where it is there already, nothing is done.
///
/// # Errors
///
/// If the specification or a file that it names is at fault, the folder holds another study, or it
/// cannot be written. That a recording gives no scene is no error, but an input with a refusal.
pub fn plan(spec: &Path, dir: &Path) -> Result<Plan, Failure> {
    let read = StudySpec::open(spec)?;
    let folder = spec.parent().unwrap_or(Path::new(""));
    let mut judges = Judges::default();
    let mut named = [Vec::new(), Vec::new(), Vec::new()];
    for (kind, list) in [&read.policies, &read.curves, &read.parameters].into_iter().enumerate() {
        for (number, written) in list.iter().enumerate() {
            let text = judge(kind, folder, written)?;
            named[kind].push(Judge {
                name: written.text.clone(),
                file: format!("judges/{}-{number:02}.toml", KINDS[kind]),
                hash: hash(text.text.as_bytes()),
            });
            judges.of_kind(kind).push(text);
        }
    }
    check_judges(&judges, &read)?;
    let (inputs, texts) = inputs::gather(&read.sources, folder)?;
    let [policies, curves, parameters] = named;
    let sweeps: Vec<Sweep> =
        read.sweeps.into_iter().map(|(knob, values)| Sweep { knob, values }).collect();
    let counts = sweeps.iter().map(|sweep| sweep.values.len() as u64);
    let counts = counts.chain([inputs.len() as u64, parameters.len() as u64]);
    let scenes = counts.fold(1_u64, u64::saturating_mul);
    if scenes > SCENES_MAX {
        let what = format!("{}: {scenes} scenes are more than {SCENES_MAX}", spec.display());
        return Err(Failure::input(what).with_remedy("give the sweeps fewer values"));
    }
    let mut file = PlanFile {
        schema: SCHEMA.to_owned(),
        id: String::new(),
        build: BUILD.to_owned(),
        name: read.name,
        spec: read.text,
        members: read.members,
        worlds: read.worlds,
        scene_limit_s: read.scene_limit_s,
        scenes_per_shard: read.scenes_per_shard,
        candidates: read.candidates,
        persons: read.persons,
        policies,
        curves,
        parameters,
        sweeps,
        inputs,
        scenes,
    };
    file.id = file.hash();
    let plan = Plan { dir: dir.to_owned(), file, judges };
    plan.write(&texts)?;
    Ok(plan)
}

const KINDS: [&str; 3] = ["policy", "curves", "parameters"];

impl Judges {
    fn of_kind(&mut self, kind: usize) -> &mut Vec<SourceText> {
        match kind {
            0 => &mut self.policies,
            1 => &mut self.curves,
            _ => &mut self.parameters,
        }
    }
}

/// The text that a specification names: a file beside it, or one that ships.
fn judge(kind: usize, folder: &Path, written: &Placed) -> Result<SourceText, Failure> {
    let path = folder.join(&written.text);
    let path = if path.is_file() { path } else { PathBuf::from(&written.text) };
    let read = [trolley::read_policy, trolley::read_curves, trolley::read_parameters];
    read[kind](&path).map_err(|failure| failure.at(&written.place))
}

/// Refuses what cannot be judged together, before anything is ranked.
fn check_judges(judges: &Judges, spec: &StudySpec) -> Result<(), Failure> {
    for (policy, named) in judges.policies.iter().zip(&spec.policies) {
        for (curves, of_curves) in judges.curves.iter().zip(&spec.curves) {
            for parameters in &judges.parameters {
                trolley::check_criteria([policy, curves, parameters]).map_err(|failure| {
                    let both = format!("policy \"{}\", curves \"{}\"", named.text, of_curves.text);
                    failure.at(both).at(&of_curves.place)
                })?;
            }
        }
    }
    Ok(())
}

/// BLAKE3, in hexadecimal digits.
pub(crate) fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

impl PlanFile {
    /// The hash of all but the id.
    fn hash(&self) -> String {
        let nameless = Self { id: String::new(), ..self.clone() };
        hash(serde_json::to_string(&nameless).unwrap_or_default().as_bytes())
    }
}

impl Plan {
    /// Opens the folder of a study.
    ///
    /// # Errors
    ///
    /// If there is no plan in it, or one that was changed.
    pub fn open(dir: &Path) -> Result<Self, Failure> {
        let path = dir.join("plan.json");
        let text = files::text(&path, InputKind::Scenario)
            .map_err(|failure| failure.with_remedy("name the folder that `study plan` wrote"))?;
        let broken = |what: &str| {
            Failure::input(what)
                .at(path.display())
                .with_remedy("plan the study again, in another folder")
        };
        let file: PlanFile = serde_json::from_str(&text)
            .map_err(|error| broken(&format!("it is no plan of this version: {error}")))?;
        if file.schema != SCHEMA || file.hash() != file.id {
            return Err(broken("it was changed, or is of another version"));
        }
        let mut judges = Judges::default();
        for (kind, list) in [&file.policies, &file.curves, &file.parameters].into_iter().enumerate()
        {
            for judge in list {
                let text = read(dir, &judge.file, &judge.hash)?;
                judges.of_kind(kind).push(SourceText { name: judge.file.clone(), text });
            }
        }
        Ok(Self { dir: dir.to_owned(), file, judges })
    }

    /// The folder.
    #[must_use]
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// The hash of specification, inputs and build.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.file.id
    }

    /// What people call the study.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.file.name
    }

    /// The number of scenes.
    #[must_use]
    pub fn scenes(&self) -> u64 {
        self.file.scenes
    }

    /// The number of answers to each scene: one for each policy with each set of curves.
    #[must_use]
    pub fn answers_per_scene(&self) -> u64 {
        (self.file.policies.len() * self.file.curves.len()) as u64
    }

    /// The number of answers, which is that of rows of the table `answers`.
    #[must_use]
    pub fn answers(&self) -> u64 {
        self.scenes() * self.answers_per_scene()
    }

    /// The number of shards.
    #[must_use]
    pub fn shards(&self) -> u32 {
        let shards = self.scenes().div_ceil(self.file.scenes_per_shard.into());
        u32::try_from(shards).unwrap_or(u32::MAX)
    }

    /// The inputs: their names, and why one gives no scene.
    pub fn inputs(&self) -> impl Iterator<Item = (&str, Option<&str>)> {
        self.file.inputs.iter().map(|input| (input.name.as_str(), input.refusal.as_deref()))
    }

    /// The scenes of a shard.
    ///
    /// # Errors
    ///
    /// If there is no such shard.
    pub fn scenes_of(&self, shard: u32) -> Result<std::ops::Range<u64>, Failure> {
        if shard >= self.shards() {
            let what = format!("there is no shard {shard}");
            let help = format!("shards are 0 to {}", self.shards().saturating_sub(1));
            return Err(Failure::setting(what).with_remedy(help));
        }
        let per_shard = u64::from(self.file.scenes_per_shard);
        let begin = per_shard * u64::from(shard);
        Ok(begin..self.scenes().min(begin + per_shard))
    }

    /// What a scene is made of: inputs vary slowest, the last sweep fastest, so that scenes of one
    /// shard have the same bodies.
    ///
    /// # Errors
    ///
    /// If there is no such scene.
    pub fn scene(&self, scene: u64) -> Result<SceneKey, Failure> {
        if scene >= self.scenes() {
            let what = format!("there is no scene {scene}");
            let help = format!("scenes are 0 to {}", self.scenes().saturating_sub(1));
            return Err(Failure::setting(what).with_remedy(help));
        }
        let mut rest = scene;
        let mut digit = |count: usize| {
            let count = count.max(1) as u64;
            let digit = rest % count;
            rest /= count;
            // Below a count that is a usize.
            digit as usize
        };
        let mut values: Vec<(SweepKnob, f64)> = Vec::new();
        for sweep in self.file.sweeps.iter().rev() {
            values.insert(0, (sweep.knob, sweep.values[digit(sweep.values.len())]));
        }
        let parameters = digit(self.file.parameters.len());
        let input = digit(self.file.inputs.len());
        Ok(SceneKey { scene, input, parameters, values })
    }

    /// The worlds of every answer, where there are members.
    pub(crate) fn worlds(&self) -> Worlds {
        Worlds::new(self.file.worlds, 0).unwrap_or(Worlds::USUAL)
    }

    /// How long one scene may take (s), by the clock.
    pub(crate) fn scene_limit_s(&self) -> f64 {
        self.file.scene_limit_s
    }

    pub(crate) fn file(&self) -> &PlanFile {
        &self.file
    }

    /// Policy and curves of an answer to a scene: curves vary fastest.
    pub(crate) fn judges_of(&self, answer: u64) -> (usize, usize) {
        let curves = self.file.curves.len().max(1) as u64;
        // Both are below counts that are a usize.
        ((answer / curves) as usize, (answer % curves) as usize)
    }

    pub(crate) fn judges(&self) -> &Judges {
        &self.judges
    }

    /// Refuses to rank with another build than planned: rows of one study are of one program.
    pub(crate) fn check_build(&self) -> Result<(), Failure> {
        if self.file.build == BUILD {
            return Ok(());
        }
        let what =
            format!("the study was planned by build {}, and this is {BUILD}", self.file.build);
        let help = "run it with the program that planned it, or plan it again in another folder";
        Err(Failure::new(FailureKind::Skew, what).at(self.dir.display()).with_remedy(help))
    }

    /// Writes the folder, the plan itself last.
    fn write(&self, texts: &[inputs::InputTexts]) -> Result<(), Failure> {
        let target = self.dir.join("plan.json");
        if target.exists() {
            let known = Self::open(&self.dir)?;
            if known.id() == self.id() {
                return Ok(());
            }
            let what = "it holds another study: specification, inputs or program differ";
            let help = "name another folder, or remove this one";
            return Err(Failure::setting(what).at(self.dir.display()).with_remedy(help));
        }
        for folder in ["inputs", "judges", "shards", "attempts", "tmp"] {
            make(&self.dir.join(folder))?;
        }
        let lists = [&self.file.policies, &self.file.curves, &self.file.parameters];
        let sources = [&self.judges.policies, &self.judges.curves, &self.judges.parameters];
        for (judges, sources) in lists.into_iter().zip(sources) {
            for (judge, source) in judges.iter().zip(sources) {
                files::replace(&self.dir.join(&judge.file), source.text.as_bytes())?;
            }
        }
        for (input, texts) in self.file.inputs.iter().zip(texts) {
            input.write(&self.dir, texts)?;
        }
        let table = rows::inputs(&self.file.inputs).parquet()?;
        files::replace(&self.dir.join("inputs.parquet"), &table)?;
        let text = serde_json::to_string_pretty(&self.file);
        let text = text.map_err(|error| Failure::internal(error.to_string()))?;
        files::replace(&target, text.as_bytes())
    }
}

/// Makes a folder, if it is not there.
pub(crate) fn make(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| {
        Failure::new(FailureKind::System, error.to_string())
            .at(folder.display())
            .with_remedy("name a folder that can be written to")
    })
}

/// A text of the study's folder, if it is still what was planned.
pub(crate) fn read(dir: &Path, file: &str, hashed: &str) -> Result<String, Failure> {
    let path = dir.join(file);
    let text = files::text(&path, InputKind::Scenario)?;
    check(&path, text.as_bytes(), hashed)?;
    Ok(text)
}

/// Refuses a file that is not what was planned.
pub(crate) fn check(path: &Path, bytes: &[u8], hashed: &str) -> Result<(), Failure> {
    if hash(bytes) == hashed {
        return Ok(());
    }
    let what = "it is not what was planned";
    let help = "plan the study again in another folder, or put the file back";
    Err(Failure::input(what).at(path.display()).with_remedy(help))
}
