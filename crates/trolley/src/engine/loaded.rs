//! The bodies of a scenario, loaded and kept: with what was computed of them, and the workers that
//! map them.

use super::EngineBuilder;
use super::body_cache::{BodyCache, BodyKey, KeptBody};
use crate::Failure;
use crate::bodies::{Bodies, ModelFile, OnProgress, PartyBody};
use crate::files::InputKind;
use body::{BodyKind, Fit, Shape, Shells, file};
use bvh::support::Extremes;
use coordinator::Backend;
use runtime::FileMap;
use scenario::{EngineSettings as Settings, FileRef, ScenarioError, Source};
use std::path::PathBuf;

/// What is kept from one scenario to the next.
#[derive(Debug)]
pub(super) struct Loaded {
    pub(super) settings: Settings,
    pub(super) sources: Vec<BodySource>,
    pub(super) bodies: Bodies,
    /// Kept from the second request about the same bodies on: for one they take longer than the
    /// trees.
    pub(super) extremes: Option<Vec<Extremes>>,
    pub(super) shells: Vec<Shells>,
    pub(super) backend: Option<Backend>,
}

/// Where a party's body comes from; equal ones are equal bodies.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum BodySource {
    Generated { shape: Shape, triangles: u32, seed: u64, size: Option<Fit> },
    File { path: PathBuf, hash: String, size: Option<Fit> },
}

/// What bodies are loaded for.
pub(super) struct Subject<'s> {
    pub(super) file: &'s str,
    pub(super) bodies: Vec<PartyBody<'s>>,
    /// The path of a model file.
    pub(super) find: &'s dyn Fn(&FileRef) -> PathBuf,
    /// Whether the bodies can play their parts, by their kinds.
    pub(super) check_kinds: &'s dyn Fn(&[BodyKind]) -> Result<(), ScenarioError>,
}

impl Loaded {
    /// What runs jobs: kept from the last request, or started.
    pub(super) fn ready(
        &mut self,
        builder: &EngineBuilder,
        settings: &Settings,
        deadline_ns: Option<u64>,
    ) -> Result<Backend, Failure> {
        let Some(mut backend) = self.backend.take() else {
            return builder.backend(settings, &self.bodies, deadline_ns);
        };
        // Replace lost workers.
        let mended = backend.worker_pool_mut().map(|pool| pool.mend(self.bodies.store()));
        mended.transpose()?;
        Ok(backend)
    }
}

/// The bodies of a scenario: the kept ones if they are the same, else those of the cache, and for
/// the rest newly loaded ones.
pub(super) fn loaded<'l>(
    kept: &'l mut Option<Loaded>,
    cache: &mut BodyCache,
    subject: &Subject<'_>,
    settings: &Settings,
    progress: OnProgress<'_>,
) -> Result<&'l mut Loaded, Failure> {
    let sources = sources(subject);
    let is_same = kept
        .as_ref()
        .is_some_and(|kept| kept.settings == *settings && sources.as_ref() == Some(&kept.sources));
    if is_same && let Some(kept) = kept {
        let views = kept.bodies.views()?;
        // The bodies are the same, but they may play other parts.
        let kinds: Vec<BodyKind> = views.iter().map(|(meta, _)| meta.kind).collect();
        (subject.check_kinds)(&kinds)?;
        let extremes_of_all = || views.iter().map(|(_, body)| Extremes::new(body)).collect();
        kept.extremes.get_or_insert_with(extremes_of_all);
    } else {
        // Stop the old workers first: the machine may have no room for more.
        *kept = None;
        let bodies = gathered(cache, subject, settings, sources.as_deref(), progress)?;
        let files: Vec<&ModelFile> = bodies.iter().map(|body| &*body.file).collect();
        (subject.check_kinds)(&files.iter().map(|file| file.kind()).collect::<Vec<_>>())?;
        *kept = Some(Loaded {
            settings: settings.clone(),
            sources: sources.unwrap_or_default(),
            bodies: Bodies::seal_copies(&files)?,
            extremes: None,
            shells: bodies.iter().map(|body| Shells::clone(&body.shells)).collect(),
            backend: None,
        });
    }
    kept.as_mut().ok_or_else(|| Failure::internal("no bodies"))
}

/// The bodies of a scenario in their order, from the cache as far as it has them.
fn gathered(
    cache: &mut BodyCache,
    subject: &Subject<'_>,
    settings: &Settings,
    sources: Option<&[BodySource]>,
    progress: OnProgress<'_>,
) -> Result<Vec<KeptBody>, Failure> {
    let (build, leaf_size) = (settings.build, settings.leaf_size);
    let key = |source: &BodySource| BodyKey { source: source.clone(), build, leaf_size };
    let keys = sources.map(|sources| sources.iter().map(key).collect::<Vec<_>>());
    let known = |number: usize| keys.as_ref().and_then(|keys| cache.get(&keys[number]));
    let mut bodies: Vec<Option<KeptBody>> = (0..subject.bodies.len()).map(known).collect();
    let is_missing = |number: &usize| bodies[*number].is_none();
    let missing: Vec<usize> = (0..bodies.len()).filter(is_missing).collect();
    let parties: Vec<PartyBody<'_>> =
        missing.iter().map(|number| subject.bodies[*number]).collect();
    let find = |_: usize, reference: &FileRef| (subject.find)(reference);
    let files = Bodies::of_parties(&parties, settings, subject.file, &find, progress)?;
    for (number, file) in missing.into_iter().zip(files) {
        let body = KeptBody::of(file)?;
        if let Some(keys) = &keys {
            cache.insert(keys[number].clone(), &body);
        }
        bodies[number] = Some(body);
    }
    Ok(bodies.into_iter().flatten().collect())
}

/// Where the bodies come from; `None` if a file cannot be read.
fn sources(subject: &Subject<'_>) -> Option<Vec<BodySource>> {
    let source_of = |party: &PartyBody<'_>| {
        let size = party.size;
        Some(match party.source {
            Source::Generate { shape, triangles, seed } => {
                BodySource::Generated { shape: *shape, triangles: *triangles, seed: *seed, size }
            }
            Source::File(reference) => {
                let path = (subject.find)(reference);
                let hash = file::content_hash(FileMap::open(&path, InputKind::Model).ok()?.bytes())
                    .ok()?;
                BodySource::File { path, hash, size }
            }
        })
    };
    subject.bodies.iter().map(source_of).collect()
}
