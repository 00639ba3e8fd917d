//! Inputs: recordings and scenarios, read once when a study is planned, and kept in its folder.

use crate::plan::{hash, make};
use crate::spec::{Placed, Recordings, Source, SourceKind};
use serde::{Deserialize, Serialize};
use std::path::{Component, Path, PathBuf};
use trolley::files::{self, InputKind};
use trolley::traffic::{self, TrafficOptions};
use trolley::{Failure, References, Scenario};

/// Most inputs of a study.
const INPUTS_MAX: usize = 100_000;

/// A scene as given, before any sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Input {
    /// The name of its file, and the time at which a recording is entered.
    pub(crate) name: String,
    /// "recording" or "scenario".
    pub(crate) kind: String,
    /// The moment of a recording at which manoeuvres begin (s), if the specification says so.
    pub(crate) at_s: Option<f64>,
    /// Hash of the file that was read.
    pub(crate) source_hash: String,
    /// The files in the folder of the input: the scenario first, then what it names.
    pub(crate) files: Vec<InputFile>,
    /// Parties of unknown kind are taken as fixed to the ground.
    pub(crate) unknown_is_fixed: bool,
    /// Why there is no scene.
    pub(crate) refusal: Option<String>,
    pub(crate) parties: u32,
    pub(crate) candidates: u32,
    /// Its number, of which its folder is named.
    pub(crate) number: u32,
}

/// A file of an input.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct InputFile {
    pub(crate) name: String,
    pub(crate) hash: String,
    /// Whether it is a model file, which the engine opens itself.
    pub(crate) is_model: bool,
}

/// The bytes of an input's files.
pub(crate) type InputTexts = Vec<Vec<u8>>;

/// Reads all inputs, in the order of the specification and of their names.
pub(crate) fn gather(
    sources: &[Source],
    folder: &Path,
) -> Result<(Vec<Input>, Vec<InputTexts>), Failure> {
    let (mut inputs, mut texts): (Vec<Input>, Vec<InputTexts>) = (Vec::new(), Vec::new());
    for source in sources {
        for path in found(&source.files, folder)? {
            match &source.kind {
                SourceKind::Scenarios => {
                    let (input, bytes) = scenario(&path, source.unknown_is_fixed)?;
                    inputs.push(input);
                    texts.push(bytes);
                }
                SourceKind::Recordings(recordings) => {
                    let options = options(recordings, folder);
                    let moments = recordings.at_s.iter().copied().map(Some);
                    let moments: Vec<Option<f64>> = moments.collect();
                    let moments = if moments.is_empty() { vec![None] } else { moments };
                    for at_s in moments {
                        let options = TrafficOptions { at_s, ..options.clone() };
                        let (input, bytes) = recording(&path, &options, source.unknown_is_fixed)?;
                        inputs.push(input);
                        texts.push(bytes);
                    }
                }
            }
            if inputs.len() > INPUTS_MAX {
                let what = format!("more than {INPUTS_MAX} inputs");
                let help = "study them in several parts";
                return Err(Failure::input(what).at(path.display()).with_remedy(help));
            }
        }
    }
    for (number, input) in (0..).zip(&mut inputs) {
        input.number = number;
    }
    Ok((inputs, texts))
}

/// The files of patterns, each once, in the order of their names.
fn found(patterns: &[Placed], folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut all: Vec<PathBuf> = Vec::new();
    for Placed { text, place } in patterns {
        let pattern = glob::Pattern::escape(&folder.display().to_string());
        let pattern = Path::new(&pattern).join(text);
        let refused = |what: String| {
            Failure::input(what)
                .at(place)
                .with_remedy("name files, with * and ? as a shell has them, beside this file")
        };
        let paths = glob::glob(&pattern.display().to_string())
            .map_err(|error| refused(format!("\"{text}\" is no pattern: {error}")))?;
        let before = all.len();
        for path in paths {
            let path = path.map_err(|error| refused(error.to_string()))?;
            if path.is_file() && !all.contains(&path) {
                all.push(path);
            }
        }
        if all.len() == before {
            return Err(refused(format!("there is no file \"{text}\"")));
        }
    }
    Ok(all)
}

fn options(recordings: &Recordings, folder: &Path) -> TrafficOptions {
    TrafficOptions {
        horizon_s: recordings.horizon_s,
        brakes_m_s2: recordings.brakes_m_s2.clone(),
        laterals_m_s2: recordings.laterals_m_s2.clone(),
        grip_m_s2: recordings.grip_m_s2,
        bodies: recordings.bodies.as_ref().map(|bodies| folder.join(&bodies.text)),
        references: References::Anywhere,
        ..TrafficOptions::default()
    }
}

/// The name of a file without its folder.
fn title(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// A message without the folder that its file lies in, so that a study has one id everywhere.
fn placeless(failure: &Failure, path: &Path) -> String {
    failure.what().replace(&path.display().to_string(), &title(path))
}

fn recording(
    path: &Path,
    options: &TrafficOptions,
    unknown_is_fixed: bool,
) -> Result<(Input, InputTexts), Failure> {
    let read = files::bytes(path, InputKind::Trace)?;
    let name =
        options.at_s.map_or_else(|| title(path), |at_s| format!("{} @ {at_s} s", title(path)));
    let mut input = Input {
        name,
        kind: "recording".to_owned(),
        at_s: options.at_s,
        source_hash: hash(&read),
        files: Vec::new(),
        unknown_is_fixed,
        refusal: None,
        parties: 0,
        candidates: 0,
        number: 0,
    };
    let imported = traffic::import(path, options).and_then(|imported| {
        let text = imported.text.replace(&path.display().to_string(), &title(path));
        let scenario = Scenario::parse_with("scenario.toml", &text, References::Anywhere)?;
        Ok((text, scenario))
    });
    match imported {
        Ok((text, scenario)) => {
            let bodies = input.taken(&scenario, Path::new(""), text.into_bytes())?;
            Ok((input, bodies))
        }
        Err(failure) => {
            input.refusal = Some(placeless(&failure, path));
            Ok((input, Vec::new()))
        }
    }
}

fn scenario(path: &Path, unknown_is_fixed: bool) -> Result<(Input, InputTexts), Failure> {
    let text = files::text(path, InputKind::Scenario)?;
    let mut input = Input {
        name: title(path),
        kind: "scenario".to_owned(),
        at_s: None,
        source_hash: hash(text.as_bytes()),
        files: Vec::new(),
        unknown_is_fixed,
        refusal: None,
        parties: 0,
        candidates: 0,
        number: 0,
    };
    match Scenario::open(path) {
        Ok(scenario) => {
            let folder = path.parent().unwrap_or(Path::new(""));
            let texts = input.taken(&scenario, folder, text.into_bytes())?;
            Ok((input, texts))
        }
        Err(failure) => {
            input.refusal = Some(placeless(&failure, path));
            Ok((input, Vec::new()))
        }
    }
}

impl Input {
    /// Takes the scenario and the files that it names, but for what judges it.
    fn taken(
        &mut self,
        scenario: &Scenario,
        folder: &Path,
        text: Vec<u8>,
    ) -> Result<InputTexts, Failure> {
        let parsed = scenario.parsed();
        self.parties = u32::try_from(parsed.parties.len()).unwrap_or(u32::MAX);
        self.candidates = u32::try_from(parsed.candidates.len()).unwrap_or(u32::MAX);
        let mut texts = vec![text];
        let name = "scenario.toml".to_owned();
        self.files.push(InputFile { name, hash: hash(&texts[0]), is_model: false });
        for (named, kind) in scenario.named_files() {
            if self.files.iter().any(|known| known.name == named) {
                continue;
            }
            let is_inside =
                |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
            if !Path::new(&named).components().all(is_inside) || named == "scenario.toml" {
                let what = format!("{}: it names \"{named}\"", self.name);
                let help = "a study keeps what a scenario names: put it into its folder, under \
                            another name than scenario.toml";
                return Err(Failure::input(what).with_remedy(help));
            }
            let bytes = files::bytes(&folder.join(&named), kind)?;
            let is_model = kind == InputKind::Model;
            self.files.push(InputFile { name: named, hash: hash(&bytes), is_model });
            texts.push(bytes);
        }
        Ok(texts)
    }

    /// Its folder, in that of the study.
    pub(crate) fn folder(&self) -> String {
        format!("inputs/{:04}", self.number)
    }

    pub(crate) fn write(&self, dir: &Path, texts: &InputTexts) -> Result<(), Failure> {
        let folder = dir.join(self.folder());
        for (file, bytes) in self.files.iter().zip(texts) {
            let target = folder.join(&file.name);
            make(target.parent().unwrap_or(&folder))?;
            files::replace(&target, bytes)?;
        }
        Ok(())
    }
}
