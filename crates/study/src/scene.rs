//! One scene: from the input and the values of the sweeps to a scenario's text, and to a scenario.

use crate::inputs::Input;
use crate::plan::{self, Plan, SceneKey, make};
use std::path::{Path, PathBuf};
use toml::{Table, Value};
use trolley::files::{self, InputKind};
use trolley::{Failure, FailureKind, References, Scenario, SourceText, Texts};

/// Keys of a scenario that the study decides, or that would have an answer depend on the clock.
const DECIDED: [&str; 6] =
    ["policy", "curves", "parameters", "members", "members_max", "deadline_ms"];

/// Scenes of one plan; the input of the last one stays in memory.
pub(crate) struct Scenes<'p> {
    plan: &'p Plan,
    input: Option<(usize, Result<Base, Failure>)>,
}

/// An input that was read.
struct Base {
    table: Table,
    files: Vec<SourceText>,
}

impl<'p> Scenes<'p> {
    pub(crate) fn new(plan: &'p Plan) -> Self {
        Self { plan, input: None }
    }

    /// The text of a scene, as a scenario file has it.
    pub(crate) fn text(&mut self, key: &SceneKey) -> Result<String, Failure> {
        let [members, most] = self.plan.file().members;
        let base = self.base(key.input)?;
        let mut table = base.table.clone();
        for (knob, value) in &key.values {
            knob.set(*value, &mut table).map_err(|fault| {
                let what = format!("{} = {value}: {fault}", knob.name());
                Failure::new(FailureKind::Refused, what)
            })?;
        }
        table.insert("members".to_owned(), Value::Integer(members));
        if members > 1 {
            table.insert("members_max".to_owned(), Value::Integer(most));
        }
        toml::to_string(&table).map_err(|error| Failure::internal(error.to_string()))
    }

    /// The scene, judged by the first policy and the first set of curves.
    pub(crate) fn scenario(&mut self, key: &SceneKey) -> Result<Scenario, Failure> {
        let text = self.text(key)?;
        let (plan, input) = (self.plan, &self.plan.file().inputs[key.input]);
        let judges = plan.judges();
        let name = plan.dir().join(input.folder()).join("scenario.toml");
        let texts = Texts {
            scenario: SourceText { name: name.display().to_string(), text },
            policy: judges.policies[0].clone(),
            curves: judges.curves[0].clone(),
            parameters: judges.parameters[key.parameters].clone(),
        };
        let files = self.base(key.input)?.files.clone();
        let scenario = Scenario::of_texts(texts, files)?.with_references(References::Inside);
        Ok(if input.unknown_is_fixed { scenario.assuming_unknown_is_fixed() } else { scenario })
    }

    fn base(&mut self, number: usize) -> Result<&Base, Failure> {
        if self.input.as_ref().is_none_or(|(known, _)| *known != number) {
            let input = &self.plan.file().inputs[number];
            self.input = Some((number, Base::read(self.plan.dir(), input)));
        }
        match &self.input {
            Some((_, Ok(base))) => Ok(base),
            Some((_, Err(failure))) => Err(failure.clone()),
            None => Err(Failure::internal("no input was read")),
        }
    }
}

impl Base {
    fn read(dir: &Path, input: &Input) -> Result<Self, Failure> {
        if let Some(refusal) = &input.refusal {
            return Err(Failure::new(FailureKind::Refused, refusal.clone()));
        }
        let folder = dir.join(input.folder());
        // That its files are not as planned says something of this folder, and nothing of a scene.
        let mut texts =
            Self::texts(dir, input).map_err(|failure| failure.of_kind(FailureKind::System))?;
        if texts.is_empty() {
            return Err(Failure::input("it has no scenario").at(folder.display()));
        }
        let text = texts.remove(0).text;
        let mut table: Table =
            toml::from_str(&text).map_err(|error| Failure::input(error.message()))?;
        for key in DECIDED {
            table.remove(key);
        }
        Ok(Self { table, files: texts })
    }

    /// The texts of an input, if they and its bodies are what was planned.
    fn texts(dir: &Path, input: &Input) -> Result<Vec<SourceText>, Failure> {
        let mut texts = Vec::new();
        for file in &input.files {
            let name = format!("{}/{}", input.folder(), file.name);
            if file.is_model {
                let bytes = files::bytes(&dir.join(&name), InputKind::Model)?;
                plan::check(&dir.join(&name), &bytes, &file.hash)?;
                continue;
            }
            let text = plan::read(dir, &name, &file.hash)?;
            texts.push(SourceText { name: file.name.clone(), text });
        }
        Ok(texts)
    }
}

/// A row of a study, as files that `trolley rank` takes.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct WrittenScene {
    /// The scenario.
    pub scenario: PathBuf,
    /// Whether parties of unknown kind are taken as fixed: `--assume unknown=fixed`.
    pub unknown_is_fixed: bool,
    /// How many worlds its answer is to have.
    pub worlds: u32,
}

impl WrittenScene {
    /// Returns the command that ranks it as the study does.
    #[must_use]
    pub fn command(&self) -> String {
        let assume = if self.unknown_is_fixed { " --assume unknown=fixed" } else { "" };
        let usual = trolley::Worlds::USUAL.count;
        let worlds = (self.worlds != usual).then(|| format!(" --worlds {}", self.worlds));
        let worlds = worlds.unwrap_or_default();
        format!("trolley rank {}{assume}{worlds}", self.scenario.display())
    }
}

/// Writes the scene of a row of the table `answers` into a folder, with its policy, its curves, its
/// parameters and what it names, so that anybody can rank it.
///
/// # Errors
///
/// If there is no such row, its input gives no scene, or the folder cannot be written.
pub fn write_scene(plan: &Plan, row: u64, folder: &Path) -> Result<WrittenScene, Failure> {
    let per_scene = plan.answers_per_scene();
    if row >= plan.answers() {
        let what = format!("there is no row {row}");
        let help = format!("rows are 0 to {}", plan.answers().saturating_sub(1));
        return Err(Failure::setting(what).with_remedy(help));
    }
    let key = plan.scene(row / per_scene)?;
    let (policy, curves) = plan.judges_of(row % per_scene);
    let judges = plan.judges();
    let mut scenes = Scenes::new(plan);
    let text = scenes.text(&key)?;
    let mut table: Table =
        toml::from_str(&text).map_err(|error| Failure::internal(error.message()))?;
    make(folder)?;
    for (name, source) in [
        ("policy", &judges.policies[policy]),
        ("curves", &judges.curves[curves]),
        ("parameters", &judges.parameters[key.parameters]),
    ] {
        let file = format!("{name}.toml");
        table.insert(name.to_owned(), Value::String(file.clone()));
        files::replace(&folder.join(file), source.text.as_bytes())?;
    }
    let input = &plan.file().inputs[key.input];
    for file in input.files.iter().skip(1) {
        let from = plan.dir().join(input.folder()).join(&file.name);
        let target = folder.join(&file.name);
        make(target.parent().unwrap_or(folder))?;
        files::replace(&target, &files::bytes(&from, InputKind::Model)?)?;
    }
    let scenario = folder.join("scenario.toml");
    let text = toml::to_string(&table).map_err(|error| Failure::internal(error.to_string()))?;
    files::replace(&scenario, text.as_bytes())?;
    let worlds = plan.worlds().count;
    Ok(WrittenScene { scenario, unknown_is_fixed: input.unknown_is_fixed, worlds })
}
