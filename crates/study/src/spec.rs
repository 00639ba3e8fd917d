//! The file that says what to study, read and checked: every fault with its place and a remedy.

use crate::knob::SweepKnob;
use keys::Twice;
use serde::Deserialize;
use std::path::Path;
use toml::Spanned;
use trolley::files::{self, InputKind};
use trolley::{Failure, Worlds};

/// Name and version of the form.
pub(crate) const SCHEMA: &str = "trolley.study/1";

/// Most values of a sweep.
const VALUES_MAX: usize = 10_000;
/// Most scenes of a shard: their rows are held in memory until they are written.
const SHARD_MAX: i64 = 5_000;
/// Scenes of a shard where nothing is said: some seconds of work.
const SHARD: i64 = 500;
/// Longest time that a scene may take (s), and that where nothing is said.
const SCENE_S: [f64; 2] = [3_600.0, 600.0];
/// Characters of a name at most.
const NAME_MAX: usize = 60;

const KEYS: &str = "a study has schema, name, policies, [[recordings]] or [[scenarios]], and may \
                    have curves, parameters, members, members_max, worlds, scene_limit_s, \
                    scenes_per_shard, candidates, persons and [sweep.NAME]: trolley help studies";

/// Of what there are rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RowSelection {
    /// Of every candidate.
    All,
    /// Of the candidate that comes first.
    First,
    /// Of none.
    None,
}

/// A specification that was read: syntax, names and ranges are right, no file was opened but it.
pub(crate) struct StudySpec {
    pub(crate) text: String,
    pub(crate) name: String,
    pub(crate) members: [i64; 2],
    pub(crate) worlds: i64,
    pub(crate) scene_limit_s: f64,
    pub(crate) scenes_per_shard: u32,
    pub(crate) candidates: RowSelection,
    pub(crate) persons: RowSelection,
    pub(crate) policies: Vec<Placed>,
    pub(crate) curves: Vec<Placed>,
    pub(crate) parameters: Vec<Placed>,
    pub(crate) sources: Vec<Source>,
    pub(crate) sweeps: Vec<(SweepKnob, Vec<f64>)>,
}

/// A text of the specification, and where it stands: "study.toml:4:13".
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    pub(crate) text: String,
    pub(crate) place: String,
}

/// Files of one kind, and how they are read.
pub(crate) struct Source {
    pub(crate) files: Vec<Placed>,
    pub(crate) unknown_is_fixed: bool,
    pub(crate) kind: SourceKind,
}

/// Recordings or scenarios.
pub(crate) enum SourceKind {
    Recordings(Box<Recordings>),
    Scenarios,
}

/// How recordings become scenes.
pub(crate) struct Recordings {
    pub(crate) at_s: Vec<f64>,
    pub(crate) horizon_s: Option<f64>,
    pub(crate) brakes_m_s2: Option<Vec<f64>>,
    pub(crate) laterals_m_s2: Option<Vec<f64>>,
    pub(crate) grip_m_s2: Option<f64>,
    pub(crate) bodies: Option<Placed>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    schema: Spanned<String>,
    name: Spanned<String>,
    members: Option<Spanned<i64>>,
    members_max: Option<Spanned<i64>>,
    worlds: Option<Spanned<i64>>,
    scene_limit_s: Option<Spanned<f64>>,
    scenes_per_shard: Option<Spanned<i64>>,
    candidates: Option<RowSelection>,
    persons: Option<RowSelection>,
    policies: Spanned<Vec<Spanned<String>>>,
    curves: Option<Spanned<Vec<Spanned<String>>>>,
    parameters: Option<Spanned<Vec<Spanned<String>>>>,
    #[serde(default)]
    recordings: Vec<Spanned<RecordingsFile>>,
    #[serde(default)]
    scenarios: Vec<Spanned<ScenariosFile>>,
    #[serde(default)]
    sweep: SweepFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RecordingsFile {
    files: Spanned<Vec<Spanned<String>>>,
    at_s: Option<Spanned<RangeFile>>,
    horizon_s: Option<Spanned<f64>>,
    brakes_m_s2: Option<Vec<f64>>,
    laterals_m_s2: Option<Vec<f64>>,
    grip_m_s2: Option<f64>,
    bodies: Option<Spanned<String>>,
    assume: Option<Assume>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScenariosFile {
    files: Spanned<Vec<Spanned<String>>>,
    assume: Option<Assume>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
enum Assume {
    #[serde(rename = "unknown=fixed")]
    UnknownFixed,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepFile {
    speed: Option<Spanned<RangeFile>>,
    offset_m: Option<Spanned<RangeFile>>,
    reaction_s: Option<Spanned<RangeFile>>,
    error_sigma: Option<Spanned<RangeFile>>,
    errors: Option<Spanned<RangeFile>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RangeFile {
    from: Option<f64>,
    to: Option<f64>,
    count: Option<i64>,
    values: Option<Vec<f64>>,
}

/// The text of a specification, for places in it.
struct Reader<'t> {
    file: &'t str,
    text: &'t str,
}

impl StudySpec {
    pub(crate) fn open(path: &Path) -> Result<Self, Failure> {
        Self::parse(&path.display().to_string(), files::text(path, InputKind::Plan)?)
    }

    pub(crate) fn parse(file: &str, text: String) -> Result<Self, Failure> {
        let reader = Reader { file, text: &text };
        let read: File = toml::from_str(&text).map_err(|error| {
            let begin = error.span().map_or(0, |span| span.start);
            match Twice::in_toml(&text, &error) {
                Some(twice) => reader.refused(begin, &twice.what(), Twice::REMEDY),
                None => reader.refused(begin, error.message(), KEYS),
            }
        })?;
        reader.one_of("schema", &read.schema, SCHEMA)?;
        let name = read.name.get_ref();
        let length = name.chars().count();
        if !(1..=NAME_MAX).contains(&length) || name.trim() != name {
            let what = format!("name has {length} characters, or blank ends");
            let help = format!("write 1 to {NAME_MAX} characters");
            return Err(reader.refused(read.name.span().start, &what, &help));
        }
        let count = read.members.as_ref().map_or(1, |members| *members.get_ref());
        let most = read.members_max.as_ref().map_or(count, |most| *most.get_ref());
        if let Err(failure) = trolley::Limits::members_of(count, Some(most)) {
            let written = read.members_max.as_ref().or(read.members.as_ref());
            let begin = written.map_or(0, |written| written.span().start);
            return Err(reader.refused(begin, failure.what(), "members may be 1 to 1024"));
        }
        let worlds =
            read.worlds.as_ref().map_or(i64::from(Worlds::USUAL.count), |it| *it.get_ref());
        if let Err(misfit) = Worlds::new(worlds, 0) {
            let begin = read.worlds.as_ref().map_or(0, |worlds| worlds.span().start);
            return Err(reader.refused(begin, &misfit.what, &misfit.remedy));
        }
        let scenes_per_shard = match &read.scenes_per_shard {
            None => SHARD,
            Some(written) if (1..=SHARD_MAX).contains(written.get_ref()) => *written.get_ref(),
            Some(written) => {
                let what = format!("scenes_per_shard is {}", written.get_ref());
                let help = format!("scenes_per_shard may be 1 to {SHARD_MAX}");
                return Err(reader.refused(written.span().start, &what, &help));
            }
        };
        let [longest_s, usual_s] = SCENE_S;
        let scene_limit_s = match &read.scene_limit_s {
            None => usual_s,
            Some(written) if (0.001..=longest_s).contains(written.get_ref()) => *written.get_ref(),
            Some(written) => {
                let what = format!("scene_limit_s is {}", written.get_ref());
                let help = format!("scene_limit_s may be 0.001 to {longest_s}");
                return Err(reader.refused(written.span().start, &what, &help));
            }
        };
        let usual = || vec![Placed { text: "default".to_owned(), place: file.to_owned() }];
        let named = |list: Option<&Spanned<Vec<Spanned<String>>>>, key: &str| match list {
            None => Ok(usual()),
            Some(list) => reader.list(list, key),
        };
        let mut sources = Vec::new();
        for written in &read.recordings {
            sources.push(reader.recordings(written.get_ref())?);
        }
        for written in &read.scenarios {
            let ScenariosFile { files, assume } = written.get_ref();
            sources.push(Source {
                files: reader.list(files, "files")?,
                unknown_is_fixed: assume.is_some(),
                kind: SourceKind::Scenarios,
            });
        }
        if sources.is_empty() {
            return Err(reader.refused(0, "there is nothing to study", KEYS));
        }
        let spec = Self {
            name: name.clone(),
            members: [count, most],
            worlds,
            scene_limit_s,
            // Checked above.
            scenes_per_shard: u32::try_from(scenes_per_shard).unwrap_or(1),
            candidates: read.candidates.unwrap_or(RowSelection::All),
            persons: read.persons.unwrap_or(RowSelection::All),
            policies: reader.list(&read.policies, "policies")?,
            curves: named(read.curves.as_ref(), "curves")?,
            parameters: named(read.parameters.as_ref(), "parameters")?,
            sources,
            sweeps: reader.sweeps(&read.sweep)?,
            text: String::new(),
        };
        Ok(Self { text, ..spec })
    }
}

impl Reader<'_> {
    /// "study.toml:4:13", of a byte of the text.
    fn place(&self, begin: usize) -> String {
        let before = self.text.get(..begin).unwrap_or(self.text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        format!("{}:{line}:{column}", self.file)
    }

    fn refused(&self, begin: usize, what: &str, help: &str) -> Failure {
        Failure::input(what.trim_end()).at(self.place(begin)).with_remedy(help)
    }

    fn one_of(&self, key: &str, written: &Spanned<String>, known: &str) -> Result<(), Failure> {
        if written.get_ref() == known {
            return Ok(());
        }
        let what = format!("{key} is \"{}\"", written.get_ref());
        let help = format!("this version reads {key} = \"{known}\"");
        Err(self.refused(written.span().start, &what, &help))
    }

    /// A list of texts, none empty, none twice.
    fn list(
        &self,
        list: &Spanned<Vec<Spanned<String>>>,
        key: &str,
    ) -> Result<Vec<Placed>, Failure> {
        if list.get_ref().is_empty() {
            let help = format!("name at least one, or leave {key} out where it may be");
            return Err(self.refused(list.span().start, &format!("{key} is empty"), &help));
        }
        let mut all: Vec<Placed> = Vec::new();
        for written in list.get_ref() {
            let begin = written.span().start;
            if let Some(first) = all.iter().find(|known| known.text == *written.get_ref()) {
                let what = format!("{key} names \"{}\" twice", first.text);
                let help = format!("it stands at {} already", first.place);
                return Err(self.refused(begin, &what, &help));
            }
            all.push(Placed { text: written.get_ref().clone(), place: self.place(begin) });
        }
        Ok(all)
    }

    fn recordings(&self, written: &RecordingsFile) -> Result<Source, Failure> {
        let at_s = match &written.at_s {
            None => Vec::new(),
            Some(range) => self.values(range, "at_s", [0.0, 3600.0])?,
        };
        if let Some(horizon_s) = &written.horizon_s
            && !(*horizon_s.get_ref() > 0.0 && *horizon_s.get_ref() <= 30.0)
        {
            let what = format!("horizon_s is {}", horizon_s.get_ref());
            let help = "horizon_s may be above 0 and up to 30";
            return Err(self.refused(horizon_s.span().start, &what, help));
        }
        let bodies = written.bodies.as_ref().map(|bodies| Placed {
            text: bodies.get_ref().clone(),
            place: self.place(bodies.span().start),
        });
        Ok(Source {
            files: self.list(&written.files, "files")?,
            unknown_is_fixed: written.assume.is_some(),
            kind: SourceKind::Recordings(Box::new(Recordings {
                at_s,
                horizon_s: written.horizon_s.as_ref().map(|horizon_s| *horizon_s.get_ref()),
                brakes_m_s2: written.brakes_m_s2.clone(),
                laterals_m_s2: written.laterals_m_s2.clone(),
                grip_m_s2: written.grip_m_s2,
                bodies,
            })),
        })
    }

    fn sweeps(&self, written: &SweepFile) -> Result<Vec<(SweepKnob, Vec<f64>)>, Failure> {
        let SweepFile { speed, offset_m, reaction_s, error_sigma, errors } = written;
        let all = [speed, offset_m, reaction_s, error_sigma, errors];
        let mut sweeps = Vec::new();
        for (knob, range) in SweepKnob::ALL.into_iter().zip(all) {
            if let Some(range) = range {
                sweeps.push((knob, self.values(range, knob.name(), knob.limits())?));
            }
        }
        Ok(sweeps)
    }

    /// The values of a range: evenly from end to end, or as they are listed.
    fn values(
        &self,
        range: &Spanned<RangeFile>,
        key: &str,
        [least, most]: [f64; 2],
    ) -> Result<Vec<f64>, Failure> {
        let begin = range.span().start;
        let form = format!("write {key} = {{ from, to, count }} or {{ values = [...] }}");
        let values = match range.get_ref() {
            RangeFile { from: None, to: None, count: None, values: Some(values) } => values.clone(),
            RangeFile { from: Some(from), to: Some(to), count: Some(count), values: None } => {
                let count = usize::try_from(*count).unwrap_or(0);
                if !(1..=VALUES_MAX).contains(&count) || (count == 1 && from != to) {
                    let what = format!("{key} has {count} values from {from} to {to}");
                    let help = format!("count may be 2 to {VALUES_MAX}, or 1 where from is to");
                    return Err(self.refused(begin, &what, &help));
                }
                let last = count.saturating_sub(1).max(1) as f64;
                let value = |k: usize| {
                    if k + 1 == count { *to } else { from + (to - from) * k as f64 / last }
                };
                (0..count).map(value).collect()
            }
            _ => return Err(self.refused(begin, &format!("{key} is no range"), &form)),
        };
        if values.is_empty() || values.len() > VALUES_MAX {
            let what = format!("{key} has {} values", values.len());
            let help = format!("1 to {VALUES_MAX} are possible");
            return Err(self.refused(begin, &what, &help));
        }
        for (number, value) in values.iter().enumerate() {
            if !(least..=most).contains(value) {
                let what = format!("{key} has the value {value}");
                let help = format!("{key} may be {least} to {most}");
                return Err(self.refused(begin, &what, &help));
            }
            if values[..number].contains(value) {
                let what = format!("{key} has the value {value} twice");
                return Err(self.refused(begin, &what, "leave one out"));
            }
        }
        // Adding +0.0 turns -0.0 into +0.0.
        Ok(values.into_iter().map(|value| value + 0.0).collect())
    }
}

#[cfg(test)]
mod tests;
