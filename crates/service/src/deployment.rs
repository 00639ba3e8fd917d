//! The deployment file: models, workers, folders, and the resources that the service may use.
//!
//! Every missing value has its default here, with its reason; unknown keys are refused, with their
//! line. No file is opened: paths are returned as written.

mod group;

pub use group::ClientGroup;

use body::Shape;
use diagnostic::{Diagnostic, FailureKind};
use keys::Twice;
use scenario::{EngineSettings, Members, Overrides};
use serde::Deserialize;
use std::borrow::Cow;
use std::path::PathBuf;

/// Name and version of the format, the value of the key `schema`.
pub const SCHEMA: &str = "trolley.deployment/1";

/// Longer texts are refused unread: 64 models need 10 kB.
pub const TEXT_BYTES_MAX: usize = 1 << 20;
/// Maximum number of models in a deployment.
const MODELS_MAX: usize = 64;
/// Maximum number of decisions in a file; it ends before if it is half as long as what is read.
const PER_FILE_MAX: u32 = 100_000;
/// Maximum number of waiting requests: one per client.
const QUEUE_MAX: usize = protocol::public::CLIENTS_MAX;

/// The settings of a service. Always valid: made by [`Deployment::parse`].
#[derive(Clone, Debug, PartialEq)]
pub struct Deployment {
    /// Name of the instance: part of every shared name.
    pub instance: String,
    /// Folder of the service's root; on a tmpfs.
    pub folder: Option<PathBuf>,
    /// Whose members may be clients, besides the service's own user.
    pub group: Option<ClientGroup>,
    /// Bodies that requests may name, in the file's order.
    pub models: Vec<Model>,
    /// Policy file; `None`: the built-in one.
    pub policy: Option<PathBuf>,
    /// Injury risk curves; `None`: the built-in ones.
    pub curves: Option<PathBuf>,
    /// Parameters of contact and dynamics; `None`: the built-in ones.
    pub parameters: Option<PathBuf>,
    /// Workers, cores, depth, batches.
    pub engine: EngineSettings,
    /// In how many members requests that do not say it are followed.
    pub members: Members,
    /// In how many members a request may ask to be followed at most: what it takes from the heap
    /// grows with them.
    pub members_limit: u32,
    /// Requests that may wait; more are answered *busy*.
    pub queue: usize,
    /// What the service does while it is idle.
    pub idle: Idle,
    /// Priorities and memory.
    pub realtime: Realtime,
    /// How often lost workers are replaced.
    pub restarts: RestartLimits,
    /// Where a Prometheus text file is written, and how often (s).
    pub metrics: Option<Metrics>,
    /// Where decisions are kept.
    pub decisions: Option<Decisions>,
}

/// A body that requests may name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Model {
    /// Its number in requests.
    pub id: u32,
    /// Its name in messages.
    pub name: String,
    /// Where its triangles come from.
    pub source: ModelSource,
}

/// Where a model's triangles come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModelSource {
    /// A model file.
    File(PathBuf),
    /// The built-in generator.
    Generate {
        /// Its shape.
        shape: Shape,
        /// How many triangles.
        triangles: u32,
        /// Seed of its small variations.
        seed: u64,
    },
}

/// What the service does while it is idle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Idle {
    /// Sleep until a client rings: costs a few microseconds, but occupies no core.
    #[default]
    Park,
    /// Poll continuously: needs a core of its own.
    Spin,
}

/// Priorities and memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Realtime {
    /// Whether to refuse to start without them.
    pub require: bool,
    /// Whether memory is locked in place.
    pub lock_memory: bool,
    /// SCHED_FIFO priority of the coordinator; 0: none.
    pub priority: i32,
    /// SCHED_FIFO priority of the workers; 0: none. Below the coordinator's, which shares a core.
    pub worker_priority: i32,
    /// Heap to touch in advance (MiB).
    pub heap_mib: usize,
}

impl Default for Realtime {
    fn default() -> Self {
        // Interrupt threads have 50: workers are below, the coordinator above. 64 MiB were more
        // than pairs at impact of bodies of a million triangles took; over a horizon that is not
        // measured.
        Self { require: false, lock_memory: true, priority: 60, worker_priority: 40, heap_mib: 64 }
    }
}

/// Maximum numbers of worker deaths within a time; beyond them a lost worker is not replaced until
/// some of the deaths are older.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RestartLimits {
    /// On one core, within 10 s.
    pub core_in_10_s: u32,
    /// On all cores, within 60 s.
    pub all_in_60_s: u32,
}

impl Default for RestartLimits {
    fn default() -> Self {
        Self { core_in_10_s: 5, all_in_60_s: 10 }
    }
}

/// A Prometheus text file.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Metrics {
    /// Its path; the folder must exist.
    pub file: PathBuf,
    /// How often (s), 1 to 3600.
    #[serde(default = "one")]
    pub every_s: u64,
}

fn one() -> u64 {
    1
}

/// Where decisions are kept.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Decisions {
    /// The folder.
    pub folder: PathBuf,
    /// Requests per file, at most 100,000: longer files are not read.
    #[serde(default = "ten_thousand")]
    pub per_file: u32,
    /// Number of files to keep; the oldest is deleted.
    #[serde(default = "sixteen")]
    pub files: u32,
}

fn ten_thousand() -> u32 {
    10_000
}

fn sixteen() -> u32 {
    16
}

/// An invalid deployment: file, place and fault, in that order, and separately the remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}{place}: {what}")]
pub struct DeploymentError {
    file: String,
    place: String,
    what: String,
    remedy: String,
}

impl Diagnostic for DeploymentError {
    fn kind(&self) -> FailureKind {
        FailureKind::Configuration
    }

    fn place(&self) -> Option<String> {
        Some(format!("{}{}", self.file, self.place))
    }

    fn what(&self) -> String {
        self.what.clone()
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some(self.remedy.as_str().into())
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    schema: String,
    instance: String,
    folder: Option<String>,
    group: Option<toml::Value>,
    policy: Option<PathBuf>,
    curves: Option<PathBuf>,
    parameters: Option<PathBuf>,
    members: Option<i64>,
    members_max: Option<i64>,
    members_limit: Option<i64>,
    queue: Option<i64>,
    #[serde(default)]
    idle: Idle,
    #[serde(default)]
    engine: Overrides,
    #[serde(default)]
    realtime: Realtime,
    #[serde(default)]
    restarts: RestartLimits,
    metrics: Option<Metrics>,
    decisions: Option<Decisions>,
    #[serde(default)]
    models: Vec<RawModel>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawModel {
    id: u32,
    name: String,
    model: Option<PathBuf>,
    generate: Option<RawGenerate>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawGenerate {
    shape: String,
    triangles: u32,
    #[serde(default)]
    seed: u64,
}

impl Deployment {
    /// Reads a deployment. `file` is its name in errors.
    ///
    /// # Errors
    ///
    /// The first fault found, with its place and remedy.
    pub fn parse(file: &str, text: &str) -> Result<Self, DeploymentError> {
        let broken = |place: String, what: String, remedy: &str| DeploymentError {
            file: file.to_owned(),
            place,
            what,
            remedy: remedy.to_owned(),
        };
        if text.len() > TEXT_BYTES_MAX {
            let fault = format!("{} bytes are too many for a deployment", text.len());
            return Err(broken(String::new(), fault, "is this the right file?"));
        }
        let raw: Raw = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            if let Some(twice) = Twice::in_toml(text, &error) {
                return broken(place_of(text, at), twice.what(), Twice::REMEDY);
            }
            // Keys of another file are no slips of this one.
            if let Some((at, other)) = other_schema(text) {
                let fault = format!("schema {other:?} is not that of a deployment");
                let help = format!("is it the right file? a deployment has schema = {SCHEMA:?}");
                return broken(place_of(text, at), fault, &help);
            }
            let fault = error.message().replace('\n', " ");
            broken(place_of(text, at), fault, "config/deployments/quad-core.toml has every key")
        })?;
        check(raw).map_err(|(key, fault, help)| {
            let at = place_of_key(text, key);
            broken(place_of(text, at), fault, &help)
        })
    }

    /// The number of the group of clients, if there is one. `file` is the deployment's name in
    /// errors.
    ///
    /// # Errors
    ///
    /// If there is no such group, or this user is not in it, and so cannot share files with it.
    pub fn group_id(&self, file: &str) -> Result<Option<u32>, DeploymentError> {
        let found = self.group.as_ref().map(ClientGroup::find).transpose();
        found.map_err(|(key, what, remedy)| DeploymentError {
            file: file.to_owned(),
            place: format!(": {key}"),
            what,
            remedy,
        })
    }

    /// The number in [`Deployment::models`] of the model with this id.
    #[must_use]
    pub fn model(&self, id: u32) -> Option<usize> {
        self.models.iter().position(|model| model.id == id)
    }
}

/// The schema of another kind of file, and where it is written.
fn other_schema(text: &str) -> Option<(usize, String)> {
    let table: toml::Table = toml::from_str(text).ok()?;
    let schema = table.get("schema")?.as_str().filter(|schema| *schema != SCHEMA)?;
    Some((place_of_key(text, "schema"), schema.to_owned()))
}

/// Line and column of a byte, from 1.
fn place_of(text: &str, at: usize) -> String {
    let before = text.get(..at).unwrap_or_default();
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
    format!(":{line}:{column}")
}

/// Where a key is written, or else its name.
fn place_of_key(text: &str, key: &str) -> usize {
    let is_written = |at: &usize| {
        let before = text[..*at].rsplit('\n').next().unwrap_or_default();
        let after = text[at + key.len()..].trim_start_matches([' ', '\t']);
        before.trim().is_empty() && after.starts_with('=')
    };
    let mut named = text.match_indices(key).map(|(at, _)| at);
    named.find(is_written).or_else(|| text.find(key)).unwrap_or(0)
}

/// The key at fault, the fault, the remedy.
type Misfit = (&'static str, String, String);

fn check(raw: Raw) -> Result<Deployment, Misfit> {
    let wrong = |key, fault: String, help: &str| Err((key, fault, help.to_owned()));
    if raw.schema != SCHEMA {
        let fault = format!("schema {:?} is not known", raw.schema);
        return Err(("schema", fault, format!("write schema = {SCHEMA:?}")));
    }
    let folder = raw.folder.map(PathBuf::from);
    if let Err(error) = transport::Address::new(folder.as_deref(), &raw.instance) {
        return wrong("instance", error.to_string(), "the root of iceoryx2 has at most 49 bytes");
    }
    let group = raw.group.map(|written| ClientGroup::of(&written)).transpose()?;
    let queue = usize::try_from(raw.queue.unwrap_or(QUEUE_MAX as i64)).unwrap_or(0);
    if !(1..=QUEUE_MAX).contains(&queue) {
        let help = "queue may be 1 to 16: a client asks one thing at a time";
        return wrong("queue", "queue is out of range".to_owned(), help);
    }
    let members =
        Members::new(raw.members.unwrap_or(i64::from(Members::USUAL.count)), raw.members_max)
            .map_err(|misfit| (misfit.setting, misfit.what, misfit.remedy))?;
    let members_limit = raw.members_limit.unwrap_or(Members::LIMIT.into());
    if !(i64::from(members.most)..=Members::LIMIT.into()).contains(&members_limit) {
        let fault = format!("members_limit is {members_limit}");
        let help = format!("members_limit may be members_max ({}) to 1024", members.most);
        return wrong("members_limit", fault, &help);
    }
    let engine = EngineSettings::DEFAULT
        .apply(&raw.engine)
        .map_err(|misfit| (misfit.setting, misfit.what, misfit.remedy))?;
    for (key, priority) in
        [("priority", raw.realtime.priority), ("worker_priority", raw.realtime.worker_priority)]
    {
        if !(0..=99).contains(&priority) {
            let help = "a SCHED_FIFO priority is 1 to 99; 0: none";
            return wrong(key, format!("{key} is {priority}"), help);
        }
    }
    if raw.realtime.heap_mib > 4096 {
        let help = "heap_mib may be 0 to 4096";
        return wrong("heap_mib", format!("heap_mib is {}", raw.realtime.heap_mib), help);
    }
    let RestartLimits { core_in_10_s, all_in_60_s } = raw.restarts;
    if core_in_10_s == 0 || all_in_60_s == 0 {
        let help = "one restart at least: core_in_10_s = 5, all_in_60_s = 10 are the defaults";
        return wrong("restarts", "no worker would ever be replaced".to_owned(), help);
    }
    if raw.metrics.as_ref().is_some_and(|metrics| !(1..=3600).contains(&metrics.every_s)) {
        return wrong("every_s", "every_s is out of range".to_owned(), "every_s may be 1 to 3600");
    }
    let kept = |decisions: &Decisions| {
        (1..=PER_FILE_MAX).contains(&decisions.per_file) && decisions.files >= 2
    };
    if !raw.decisions.as_ref().is_none_or(kept) {
        let help = "per_file may be 1 to 100000, files is at least 2";
        return wrong("decisions", "per_file or files is out of range".to_owned(), help);
    }
    Ok(Deployment {
        instance: raw.instance,
        folder,
        group,
        models: models(raw.models)?,
        policy: raw.policy,
        curves: raw.curves,
        parameters: raw.parameters,
        engine,
        members,
        members_limit: members_limit as u32,
        queue,
        idle: raw.idle,
        realtime: raw.realtime,
        restarts: raw.restarts,
        metrics: raw.metrics,
        decisions: raw.decisions,
    })
}

fn models(raw: Vec<RawModel>) -> Result<Vec<Model>, Misfit> {
    if raw.is_empty() || raw.len() > MODELS_MAX {
        let fault = format!("{} models", raw.len());
        return Err(("models", fault, format!("a deployment names 1 to {MODELS_MAX} [[models]]")));
    }
    let mut models: Vec<Model> = Vec::with_capacity(raw.len());
    for RawModel { id, name, model, generate } in raw {
        let twin = models.iter().find(|known| known.id == id || known.name == name);
        if let Some(twin) = twin {
            let fault = format!("model {id} {name:?} has the id or the name of {:?}", twin.name);
            return Err(("models", fault, "give each an id and a name of its own".to_owned()));
        }
        let source = match (model, generate) {
            (Some(path), None) => ModelSource::File(path),
            (None, Some(RawGenerate { shape, triangles, seed })) => {
                let known = Shape::ALL.into_iter().find(|known| known.name() == shape);
                let Some(shape) = known else {
                    let names: Vec<&str> = Shape::ALL.iter().map(|shape| shape.name()).collect();
                    let fault = format!("shape {shape:?} is not known");
                    return Err(("shape", fault, format!("shapes: {}", names.join(", "))));
                };
                if !(500..=1_000_000).contains(&triangles) {
                    let fault = format!("triangles is {triangles}");
                    let help = "triangles may be 500 to 1000000";
                    return Err(("triangles", fault, help.to_owned()));
                }
                ModelSource::Generate { shape, triangles, seed }
            }
            _ => {
                let fault = format!("model {name:?} has not exactly one of model and generate");
                let help = "write model = \"file.trolley\", or generate = { shape = …, … }";
                return Err(("models", fault, help.to_owned()));
            }
        };
        models.push(Model { id, name, source });
    }
    Ok(models)
}

#[cfg(test)]
mod tests;
