//! From the form of a file to values: every rule that a scenario must obey, with the place of each.
//!
//! Rules stand in the order of the file's tables; the first that is broken ends the reading. Each
//! fault carries the path of keys to what is wrong; [`Document`] turns it into line and column.

use crate::document::{Document, Objection, Path, TextPosition};
use crate::engine::EngineSettings;
use crate::error::{Misfit, ScenarioError};
use crate::explain::explain;
use crate::limit::{self, Limit, Show};
use crate::names::{self, choices, quoted};
use crate::raw::{self, Table};
use crate::rules;
use crate::scenario::{Candidate, FileRef, Occupants, Party, PartyIndex, SCHEMA, Scenario, Source};
use body::{BodyKind, Fit, Seat, meta::Occupant};
use std::time::Duration;
use toml::de::DeValue;

mod collision;

/// A broken rule and the path to what breaks it.
struct Fault {
    path: Path,
    misfit: Misfit,
}

/// Adds the position of a misfit.
trait At<T> {
    fn at(self, path: &Path) -> Result<T, Fault>;
}

impl<T> At<T> for Result<T, Misfit> {
    fn at(self, path: &Path) -> Result<T, Fault> {
        self.map_err(|misfit| Fault { path: path.clone(), misfit })
    }
}

/// Reads and checks a scenario.
pub(crate) fn scenario(file: &str, text: &str) -> Result<Scenario, ScenarioError> {
    let objected = |objection: Objection| {
        let (fault, help) = explain(&objection);
        ScenarioError::new(file, objection.place, fault, help)
    };
    let document = Document::parse(text).map_err(objected)?;
    let broken = |Fault { path, misfit }| {
        ScenarioError::new(file, document.place(&path), misfit.what, misfit.remedy)
    };
    // The version comes first: a newer form may have keys that this one does not know.
    version(&document).map_err(broken)?;
    let raw = document.read::<raw::Scenario>().map_err(objected)?;
    Checker { document: &document }.scenario(raw).map_err(broken)
}

/// Whether the text declares the known schema version.
fn version(document: &Document<'_>) -> Result<(), Fault> {
    let path = Path::default().key("schema");
    let fault = match document.value(&path).map(DeValue::as_str) {
        Some(Some(SCHEMA)) => return Ok(()),
        Some(Some(other)) => format!("schema {} is not known", quoted(other)),
        Some(None) => "schema is not text".to_owned(),
        None => "schema is missing".to_owned(),
    };
    Err(Misfit::new("schema", fault, format!("this version reads schema = {SCHEMA:?}"))).at(&path)
}

struct Checker<'d> {
    document: &'d Document<'d>,
}

impl Checker<'_> {
    fn scenario(&self, raw: raw::Scenario) -> Result<Scenario, Fault> {
        let root = Path::default();
        name("name", &raw.name).at(&root.key("name"))?;
        let policy = raw.policy.map(|path| self.file_ref("policy", path, &root)).transpose()?;
        let curves = raw.curves.map(|path| self.file_ref("curves", path, &root)).transpose()?;
        let deadline = (raw.deadline_ms.map(deadline).transpose()).at(&root.key("deadline_ms"))?;
        let engine = EngineSettings::DEFAULT.apply(&raw.engine.0).or_else(|misfit| {
            let path = root.key("engine").key(misfit.setting);
            Err(misfit).at(&path)
        })?;
        let parties = self.parties(raw.parties)?;
        let ego = self.ego(raw.ego, &parties)?;
        let candidates = self.candidates(raw.candidates.unwrap_or_default(), &parties, ego)?;
        let name = raw.name;
        Ok(Scenario { name, policy, curves, deadline, engine, ego, parties, candidates })
    }

    fn place(&self, path: &Path) -> TextPosition {
        self.document.place(path)
    }

    fn file_ref(&self, key: &'static str, path: String, parent: &Path) -> Result<FileRef, Fault> {
        let written = parent.key(key);
        if !limit::PATH_BYTES.holds(path.len()) || path.contains('\0') {
            let fault = format!("{key} {} is not a path", quoted(&path));
            let help = format!("{key} is the path of a file, {}", limit::PATH_BYTES.range());
            return Err(Misfit::new(key, fault, help)).at(&written);
        }
        Ok(FileRef { path, place: self.place(&written) })
    }

    fn parties(
        &self,
        raw: std::collections::BTreeMap<String, Table<raw::Party>>,
    ) -> Result<Vec<Party>, Fault> {
        let path = Path::default().key("parties");
        if !limit::PARTIES.holds(raw.len()) {
            let fault = format!("{} parties are defined", raw.len());
            let help = "define the ego and at least one other party, at most 17 in all";
            return Err(Misfit::new("parties", fault, help)).at(&path);
        }
        raw.into_iter().map(|(key, party)| self.party(key, party, &path)).collect()
    }

    fn party(&self, key: String, raw: Table<raw::Party>, parent: &Path) -> Result<Party, Fault> {
        let path = parent.key(&key);
        let Table(raw) = raw;
        name("the name of a party", &key).at(&path)?;
        let source = match (raw.file, raw.generate) {
            (Some(file), None) => Source::File(self.file_ref("file", file, &path)?),
            (None, Some(Table(generate))) => generated(&generate, &path.key("generate"))?,
            (both, _) => {
                let count = if both.is_some() { "both file and" } else { "neither file nor" };
                let fault = format!("party {} has {count} generate", quoted(&key));
                let help = "write file = \"….trolley\", or generate = { shape = \"sedan\", \
                            triangles = 20000 }";
                return Err(Misfit::new("file", fault, help)).at(&path);
            }
        };
        if raw.kind.as_ref().is_some_and(|kind| kind != "unknown") {
            let fault = format!("kind {} is not an input", quoted(&raw.kind.unwrap_or_default()));
            let help = "a body knows its kind; write kind = \"unknown\" if nobody knows it";
            return Err(Misfit::new("kind", fault, help)).at(&path.key("kind"));
        }
        let is_unknown = raw.kind.is_some();
        let size = raw.size_m.map(|size| fit(&size, &path.key("size_m"))).transpose()?;
        let mass_kg = number(raw.mass_kg, "mass_kg", limit::MASS_KG, &path)?;
        let responsibility = number(raw.responsibility, "responsibility", limit::SHARE, &path)?;
        let kind = match source {
            Source::Generate { shape, .. } => Some(shape.kind()),
            Source::File(_) => None,
        };
        if let Some(kind) = kind {
            rules::mass_fits(kind, mass_kg).at(&path.key("mass_kg"))?;
        }
        let persons = raw.persons.map(|list| list_persons(&list, kind, &path)).transpose()?;
        if is_unknown && (mass_kg.is_some() || persons.is_some()) {
            let fault = "a party of unknown kind has neither mass nor persons";
            let help = "leave mass_kg and persons out, or kind = \"unknown\"";
            return Err(Misfit::new("kind", fault, help)).at(&path.key("kind"));
        }
        let crush = raw.crush.map(|Table(crush)| stiffness(&crush, &path.key("crush")));
        Ok(Party {
            place: self.place(&path),
            name: key.into(),
            source,
            size,
            mass_kg,
            persons,
            responsibility: responsibility.unwrap_or(0.0),
            is_unknown,
            crush: crush.transpose()?,
        })
    }

    fn ego(&self, written: Option<String>, parties: &[Party]) -> Result<PartyIndex, Fault> {
        let root = Path::default();
        let path = root.key(if written.is_some() { "ego" } else { "parties" });
        let key = written.as_deref().unwrap_or("ego");
        let Some(index) = parties.iter().position(|party| party.name == key) else {
            let misfit =
                undefined("ego", key, parties, "ego = \"…\" says which one is the vehicle");
            return Err(misfit).at(&path);
        };
        if parties[index].is_unknown {
            let help = "leave kind out: the ego knows what it is";
            return Err(Misfit::new("ego", "the ego is of unknown kind", help)).at(&path);
        }
        if let Source::Generate { shape, .. } = parties[index].source {
            rules::ego_fits(shape.kind()).at(&path)?;
        }
        Ok(PartyIndex(index))
    }

    fn candidates(
        &self,
        raw: Vec<Table<raw::Candidate>>,
        parties: &[Party],
        ego: PartyIndex,
    ) -> Result<Vec<Candidate>, Fault> {
        let path = Path::default().key("candidates");
        if !limit::CANDIDATES.holds(raw.len()) {
            let (fault, help) = match raw.len() {
                0 => ("no candidates: there is nothing to rank".to_owned(), "add [[candidates]]"),
                n => (format!("{n} candidates are too many"), "a request ranks at most 16"),
            };
            return Err(Misfit::new("candidates", fault, help)).at(&path);
        }
        let mut checked: Vec<Candidate> = Vec::with_capacity(raw.len());
        for (index, Table(candidate)) in raw.into_iter().enumerate() {
            let path = path.index(index);
            if let Some(twin) = checked.iter().find(|twin| twin.name == candidate.name) {
                let fault = format!("two candidates are called {}", quoted(&twin.name));
                let help = format!("the first stands at {}; give one another name", twin.place);
                return Err(Misfit::new("name", fault, help)).at(&path.key("name"));
            }
            let place = self.place(&path);
            checked.push(collision::candidate(candidate, &path, place, parties, ego)?);
        }
        Ok(checked)
    }
}

/// A generated body.
fn generated(raw: &raw::Generate, path: &Path) -> Result<Source, Fault> {
    let shape = names::meaning("shape", &raw.shape).at(&path.key("shape"))?;
    let triangles = limit::TRIANGLES.whole("triangles", raw.triangles).at(&path.key("triangles"))?;
    let seed = limit::SEED.whole("seed", raw.seed.unwrap_or(0)).at(&path.key("seed"))?;
    Ok(Source::Generate { shape, triangles, seed })
}

/// One to three sides.
fn fit(written: &[f64], path: &Path) -> Result<Fit, Fault> {
    if let Some(index) = written.iter().position(|side| !limit::SIZE_M.holds(*side)) {
        let fault = format!("size_m[{index}] is {}", written[index].show());
        let help = format!("each of size_m may be {}", limit::SIZE_M.range());
        return Err(Misfit::new("size_m", fault, help)).at(&path.index(index));
    }
    match *written {
        [longest] => Ok(Fit::Longest(longest)),
        [length, width] => Ok(Fit::Plan([length, width])),
        [length, width, height] => Ok(Fit::Whole([length, width, height])),
        _ => {
            let fault = format!("size_m has {} numbers", written.len());
            let help = "write size_m = [length, width], or [length, width, height]";
            Err(Misfit::new("size_m", fault, help)).at(path)
        }
    }
}

/// A and B of a body.
fn stiffness(raw: &raw::Crush, path: &Path) -> Result<[f64; 2], Fault> {
    let a = limit::CRUSH_A.check("a_n_m", raw.a_n_m).at(&path.key("a_n_m"))?;
    let b = limit::CRUSH_B.check("b_n_m2", raw.b_n_m2).at(&path.key("b_n_m2"))?;
    Ok([a + 0.0, b])
}

/// Persons by their seats, in a body of this kind if that is known.
fn list_persons(
    raw: &[Table<raw::Person>],
    kind: Option<BodyKind>,
    parent: &Path,
) -> Result<Occupants, Fault> {
    let path = parent.key("persons");
    if raw.len() > limit::PERSONS_MAX {
        let fault = format!("{} persons are too many", raw.len());
        let help = format!("a party holds at most {} persons", limit::PERSONS_MAX);
        return Err(Misfit::new("persons", fault, help)).at(&path);
    }
    let mut persons = Occupants::new();
    for (index, Table(person)) in raw.iter().enumerate() {
        let path = path.index(index).key("seat");
        let meaning = |seat: &String| names::meaning::<Seat>("seat", seat);
        let seat = person.seat.as_ref().map(meaning).transpose().at(&path)?;
        let person = Occupant { seat };
        rules::person_fits(kind, person, &persons).at(&path)?;
        persons.push(person);
    }
    Ok(persons)
}

/// A number that may be left out.
fn number(
    written: Option<f64>,
    setting: &'static str,
    limit: Limit<f64>,
    parent: &Path,
) -> Result<Option<f64>, Fault> {
    // Adding +0.0 turns −0.0 into +0.0, so that equal scenarios are equal in every bit.
    let checked = written.map(|value| limit.check(setting, value).map(|value| value + 0.0));
    checked.transpose().at(&parent.key(setting))
}

fn deadline(ms: f64) -> Result<Duration, Misfit> {
    let ms = limit::DEADLINE_MS.check("deadline_ms", ms)?;
    Ok(Duration::from_secs_f64(ms / 1000.0))
}

/// A name goes into tables, on terminals: short, and nothing that moves a cursor.
fn name(setting: &'static str, written: &str) -> Result<(), Misfit> {
    let length = written.chars().count();
    let misfit = |fault: String| {
        let help = format!("a name has {}, visible ones at both ends", limit::NAME_CHARS.range());
        Err(Misfit::new(setting, fault, help))
    };
    if !limit::NAME_CHARS.holds(length) {
        return misfit(format!("{setting} has {} characters", length.show()));
    }
    if written.trim() != written || written.chars().any(char::is_control) {
        return misfit(format!(
            "{setting} {} has blank ends or control characters",
            quoted(written)
        ));
    }
    Ok(())
}

/// A party that is not there, and which there are.
fn undefined(setting: &'static str, written: &str, parties: &[Party], help: &str) -> Misfit {
    let known: Vec<&str> = parties.iter().map(|party| party.name.as_str()).collect();
    let list = format!("parties defined here: {}", known.join(", "));
    let list = if help.is_empty() { list } else { format!("{help}; {list}") };
    let fault = format!("party {} is not defined", quoted(written));
    Misfit::new(setting, fault, choices(&list, &known, written))
}

#[cfg(test)]
mod tests;
