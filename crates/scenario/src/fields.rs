//! Checks of the values that both forms have: each with its place, in SI units.

use crate::document::{Document, Path, TextPosition};
use crate::engine::{EngineSettings, Overrides};
use crate::error::Misfit;
use crate::fault::{At, Fault};
use crate::limit::{self, Limit, Show};
use crate::names::{self, choices, quoted};
use crate::raw::{self, Table};
use crate::rules;
use crate::scenario::{FileRef, PartyIndex, Source};
use body::{BodyKind, Fit};
use geometry::Pose;
use std::time::Duration;

/// What stands above the first table, and the engine's.
pub(crate) struct Head {
    pub(crate) policy: Option<FileRef>,
    pub(crate) curves: Option<FileRef>,
    pub(crate) parameters: Option<FileRef>,
    pub(crate) deadline: Option<Duration>,
    pub(crate) engine: EngineSettings,
}

impl Head {
    pub(crate) fn new(
        document: &Document<'_>,
        name_written: &str,
        [policy, curves, parameters]: [Option<String>; 3],
        deadline_ms: Option<f64>,
        engine: &Overrides,
    ) -> Result<Self, Fault> {
        let root = Path::default();
        name("name", name_written).at(&root.key("name"))?;
        let named = |key: &'static str, path: Option<String>| {
            path.map(|path| file_ref(document, key, path, &root)).transpose()
        };
        let (policy, curves) = (named("policy", policy)?, named("curves", curves)?);
        let parameters = named("parameters", parameters)?;
        let deadline = deadline_ms.map(deadline).transpose().at(&root.key("deadline_ms"))?;
        let engine = EngineSettings::DEFAULT.apply(engine).or_else(|misfit| {
            let path = root.key("engine").key(misfit.setting);
            Err(misfit).at(&path)
        })?;
        Ok(Self { policy, curves, parameters, deadline, engine })
    }
}

/// What a party says of its body, as written.
pub(crate) struct WrittenBody {
    pub(crate) file: Option<String>,
    pub(crate) generate: Option<Table<raw::Generate>>,
    pub(crate) kind: Option<String>,
    pub(crate) size_m: Option<Vec<f64>>,
    pub(crate) mass_kg: Option<f64>,
    pub(crate) responsibility: Option<f64>,
    pub(crate) crush: Option<Table<raw::Crush>>,
}

/// The same, checked.
pub(crate) struct PartyBody {
    pub(crate) place: TextPosition,
    pub(crate) source: Source,
    pub(crate) is_unknown: bool,
    pub(crate) size: Option<Fit>,
    pub(crate) mass_kg: Option<f64>,
    pub(crate) responsibility: f64,
    pub(crate) crush: Option<[f64; 2]>,
}

impl PartyBody {
    /// The body of the party whose table is at `path`.
    pub(crate) fn new(
        document: &Document<'_>,
        key: &str,
        raw: WrittenBody,
        path: &Path,
    ) -> Result<Self, Fault> {
        name("the name of a party", key).at(path)?;
        let source = match (raw.file, raw.generate) {
            (Some(file), None) => Source::File(file_ref(document, "file", file, path)?),
            (None, Some(Table(generate))) => generated(&generate, &path.key("generate"))?,
            (both, _) => {
                let count = if both.is_some() { "both file and" } else { "neither file nor" };
                let fault = format!("party {} has {count} generate", quoted(key));
                let help = "write file = \"….trolley\", or generate = { shape = \"sedan\", \
                            triangles = 20000 }";
                return Err(Misfit::new("file", fault, help)).at(path);
            }
        };
        if raw.kind.as_ref().is_some_and(|kind| kind != "unknown") {
            let fault = format!("kind {} is not an input", quoted(&raw.kind.unwrap_or_default()));
            let help = "a body knows its kind; write kind = \"unknown\" if nobody knows it";
            return Err(Misfit::new("kind", fault, help)).at(&path.key("kind"));
        }
        let size = raw.size_m.map(|size| fit(&size, &path.key("size_m"))).transpose()?;
        let mass_kg = number(raw.mass_kg, "mass_kg", limit::MASS_KG, path)?;
        let responsibility = number(raw.responsibility, "responsibility", limit::SHARE, path)?;
        if let Some(kind) = source.kind() {
            rules::mass_fits(kind, mass_kg).at(&path.key("mass_kg"))?;
        }
        let crush = raw.crush.map(|Table(crush)| stiffness(&crush, &path.key("crush")));
        Ok(Self {
            place: document.place(path),
            source,
            is_unknown: raw.kind.is_some(),
            size,
            mass_kg,
            responsibility: responsibility.unwrap_or(0.0),
            crush: crush.transpose()?,
        })
    }

    /// Whether a party of unknown kind leaves out what only a known one has; `has_persons`: it says
    /// who is inside.
    pub(crate) fn check_unknown(&self, has_persons: bool, path: &Path) -> Result<(), Fault> {
        if self.is_unknown && (self.mass_kg.is_some() || has_persons) {
            let fault = "a party of unknown kind has neither mass nor persons";
            let help = "leave mass_kg and persons out, or kind = \"unknown\"";
            return Err(Misfit::new("kind", fault, help)).at(&path.key("kind"));
        }
        Ok(())
    }
}

impl Source {
    /// The kind of a generated body; that of a file is known when it is open.
    pub(crate) fn kind(&self) -> Option<BodyKind> {
        match self {
            Self::Generate { shape, .. } => Some(shape.kind()),
            Self::File(_) => None,
        }
    }
}

/// A path of a file, and where it is written.
pub(crate) fn file_ref(
    document: &Document<'_>,
    key: &'static str,
    path: String,
    parent: &Path,
) -> Result<FileRef, Fault> {
    let written = parent.key(key);
    if !limit::PATH_BYTES.holds(path.len()) || path.contains('\0') {
        let fault = format!("{key} {} is not a path", quoted(&path));
        let help = format!("{key} is the path of a file, {}", limit::PATH_BYTES.range());
        return Err(Misfit::new(key, fault, help)).at(&written);
    }
    Ok(FileRef { path, place: document.place(&written) })
}

/// Whether so many parties may be defined.
pub(crate) fn count_parties(count: usize, limit: Limit<usize>) -> Result<(), Fault> {
    if !limit.holds(count) {
        let fault = format!("{count} parties are defined");
        let help =
            format!("define the ego and at least one other party, at most {} in all", limit.most);
        return Err(Misfit::new("parties", fault, help)).at(&Path::default().key("parties"));
    }
    Ok(())
}

/// The party that is the automated vehicle; `parties`: name, source, and whether its kind is
/// unknown.
pub(crate) fn ego<'p>(
    written: Option<&str>,
    parties: impl Iterator<Item = (&'p str, &'p Source, bool)> + Clone,
) -> Result<PartyIndex, Fault> {
    let path = Path::default().key(if written.is_some() { "ego" } else { "parties" });
    let key = written.unwrap_or("ego");
    let found = parties.clone().enumerate().find(|(_, (name, ..))| *name == key);
    let Some((index, (_, source, is_unknown))) = found else {
        let known: Vec<&str> = parties.map(|(name, ..)| name).collect();
        let misfit = undefined("ego", key, &known, "ego = \"…\" says which one is the vehicle");
        return Err(misfit).at(&path);
    };
    if is_unknown {
        let help = "leave kind out: the ego knows what it is";
        return Err(Misfit::new("ego", "the ego is of unknown kind", help)).at(&path);
    }
    if let Some(kind) = source.kind() {
        rules::ego_fits(kind).at(&path)?;
    }
    Ok(PartyIndex(index))
}

/// Whether there may be so many candidates.
pub(crate) fn count_candidates(count: usize) -> Result<(), Fault> {
    if limit::CANDIDATES.holds(count) {
        return Ok(());
    }
    let (fault, help) = match count {
        0 => ("no candidates: there is nothing to rank".to_owned(), "add [[candidates]]"),
        n => (format!("{n} candidates are too many"), "a request ranks at most 16"),
    };
    Err(Misfit::new("candidates", fault, help)).at(&Path::default().key("candidates"))
}

/// Whether a candidate's name is not that of one before; `before`: names and places.
pub(crate) fn is_new<'c>(
    written: &str,
    mut before: impl Iterator<Item = (&'c str, TextPosition)>,
    path: &Path,
) -> Result<(), Fault> {
    let Some((_, place)) = before.find(|(name, _)| *name == written) else { return Ok(()) };
    let fault = format!("two candidates are called {}", quoted(written));
    let help = format!("the first stands at {place}; give one another name");
    Err(Misfit::new("name", fault, help)).at(&path.key("name"))
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

/// A number that may be left out.
pub(crate) fn number(
    written: Option<f64>,
    setting: &'static str,
    limit: Limit<f64>,
    parent: &Path,
) -> Result<Option<f64>, Fault> {
    // Adding +0.0 turns −0.0 into +0.0, so that equal scenarios are equal in every bit.
    let checked = written.map(|value| limit.check(setting, value).map(|value| value + 0.0));
    checked.transpose().at(&parent.key(setting))
}

/// A list of so many numbers, each within the limit.
pub(crate) fn numbers<const N: usize>(
    written: &[f64],
    setting: &'static str,
    limit: Limit<f64>,
    parent: &Path,
) -> Result<[f64; N], Fault> {
    let path = parent.key(setting);
    let Ok(numbers) = <[f64; N]>::try_from(written) else {
        let axes = ["x", "y", "z"].get(..N).unwrap_or_default().join(", ");
        let fault = format!("{setting} has {} numbers", written.len());
        return Err(Misfit::new(setting, fault, format!("write {setting} = [{axes}]"))).at(&path);
    };
    if let Some(index) = numbers.iter().position(|value| !limit.holds(*value)) {
        let fault = format!("{setting}[{index}] is {}", numbers[index].show());
        let help = format!("each of {setting} may be {}", limit.range());
        return Err(Misfit::new(setting, fault, help)).at(&path.index(index));
    }
    // Adding +0.0 turns −0.0 into +0.0.
    Ok(numbers.map(|value| value + 0.0))
}

/// Yaw, pitch and roll (degrees), 0 where nothing is written.
pub(crate) fn angles(
    [yaw_deg, pitch_deg, roll_deg]: [Option<f64>; 3],
    path: &Path,
) -> Result<[f64; 3], Fault> {
    Ok([
        number(yaw_deg, "yaw_deg", limit::YAW_DEG, path)?.unwrap_or(0.0),
        number(pitch_deg, "pitch_deg", limit::PITCH_DEG, path)?.unwrap_or(0.0),
        number(roll_deg, "roll_deg", limit::ROLL_DEG, path)?.unwrap_or(0.0),
    ])
}

/// A velocity in the ground plane of the world (m/s), written as one, or as a speed along the
/// heading: exactly one of the two.
pub(crate) fn velocity(
    speed_m_s: Option<f64>,
    velocity_m_s: Option<&[f64]>,
    yaw_deg: f64,
    limit: Limit<f64>,
    path: &Path,
) -> Result<[f64; 2], Fault> {
    let speed_m_s = number(speed_m_s, "speed_m_s", limit, path)?;
    match (speed_m_s, velocity_m_s) {
        (Some(speed_m_s), None) => {
            // Impact is reckoned in the ground plane, so the heading is the yaw alone.
            let heading = Pose::from_degrees(yaw_deg, 0.0, 0.0, [0.0; 3]).rotation;
            Ok([speed_m_s * heading[0][0] + 0.0, speed_m_s * heading[1][0] + 0.0])
        }
        (None, Some(velocity_m_s)) => plane_velocity(velocity_m_s, limit, path),
        (both, _) => {
            let count = if both.is_some() { "both speed_m_s and" } else { "neither speed_m_s nor" };
            let fault = format!("the state has {count} velocity_m_s");
            let help =
                "write speed_m_s = … along the heading, or velocity_m_s = [x, y] in the world";
            Err(Misfit::new("speed_m_s", fault, help)).at(path)
        }
    }
}

/// A velocity in the ground plane of the world (m/s), no faster than the limit.
pub(crate) fn plane_velocity(
    written: &[f64],
    limit: Limit<f64>,
    path: &Path,
) -> Result<[f64; 2], Fault> {
    let [x, y] = numbers(written, "velocity_m_s", limit, path)?;
    let speed_m_s = (x * x + y * y).sqrt();
    limit.check("velocity_m_s", speed_m_s).at(&path.key("velocity_m_s"))?;
    Ok([x, y])
}

fn deadline(ms: f64) -> Result<Duration, Misfit> {
    let ms = limit::DEADLINE_MS.check("deadline_ms", ms)?;
    Ok(Duration::from_secs_f64(ms / 1000.0))
}

/// A name goes into tables, on terminals: short, and nothing that moves a cursor.
pub(crate) fn name(setting: &'static str, written: &str) -> Result<(), Misfit> {
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
pub(crate) fn undefined(
    setting: &'static str,
    written: &str,
    known: &[&str],
    help: &str,
) -> Misfit {
    let list = format!("parties defined here: {}", known.join(", "));
    let list = if help.is_empty() { list } else { format!("{help}; {list}") };
    let fault = format!("party {} is not defined", quoted(written));
    Misfit::new(setting, fault, choices(&list, known, written))
}
