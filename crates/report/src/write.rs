//! From a decision record or a measurement to files: a page, meshes, stills.
//!
//! A record holds no hit sets, so its request is replayed, as by `trolley record replay`; if the
//! answer is not the recorded one, nothing is written.

use crate::pictures::{all_shots, bodies};
use crate::plan::{self, PlanPage};
use crate::shot::{Shot, ShotBody};
use crate::still::Camera;
use crate::text::COLUMNS;
use crate::work::WorkDone;
use crate::{Figure, MeasurementPage, document, explain, glb, html, still};
use std::path::{Path, PathBuf};
use trolley::bodies::OnProgress;
use trolley::files::InputKind;
use trolley::{Failure, FailureKind, Record, files};

/// Pixels of a still.
const STILL: [usize; 2] = [1200, 800];
/// Where a measurement is found.
const FOLDER: &str = "give a folder that `trolley measure --out` wrote";

/// What to write.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// The page.
    pub page: Option<PathBuf>,
    /// What the page shows, as JSON.
    pub json: Option<PathBuf>,
    /// Folder for each contact as .glb, damage as vertex colours.
    pub glb: Option<PathBuf>,
    /// Folder for two stills of each contact: from a corner, and from above.
    pub stills: Option<PathBuf>,
    /// All contacts as one MCAP file.
    #[cfg(feature = "mcap")]
    pub mcap: Option<PathBuf>,
    /// Names of the candidates to write pictures of; empty: all.
    pub candidates: Vec<String>,
}

impl Wanted {
    /// Whether pictures of this candidate are wanted.
    fn shows(&self, shot: &Shot) -> bool {
        self.candidates.is_empty() || self.candidates.contains(&shot.candidate)
    }

    /// The MCAP file to write, in builds with the feature `mcap`.
    fn mcap(&self) -> Option<&Path> {
        #[cfg(feature = "mcap")]
        return self.mcap.as_deref();
        #[cfg(not(feature = "mcap"))]
        None
    }

    fn is_nothing(&self) -> bool {
        let others = [&self.page, &self.json, &self.glb, &self.stills];
        others.iter().all(|path| path.is_none()) && self.mcap().is_none()
    }
}

/// Renders a decision record, or a folder that `trolley measure --out` wrote; returns the files
/// written. `models` is the folder of the record's model files, which are found by their hash.
///
/// # Errors
///
/// If nothing is to be written, the source cannot be read, the replay fails or gives another
/// answer, a candidate does not exist, or a file cannot be written.
pub fn write(
    source: &Path,
    models: Option<&Path>,
    wanted: &Wanted,
    progress: OnProgress<'_>,
) -> Result<Vec<PathBuf>, Failure> {
    if wanted.is_nothing() {
        let fault = "nothing to write";
        return Err(
            Failure::setting(fault).with_remedy("add --out FILE.html, --glb DIR or --png DIR")
        );
    }
    if source.is_dir() {
        return of_measurement(source, wanted);
    }
    of_record(source, models, wanted, progress)
}

fn of_record(
    path: &Path,
    models: Option<&Path>,
    wanted: &Wanted,
    progress: OnProgress<'_>,
) -> Result<Vec<PathBuf>, Failure> {
    // Fail before the replay, not after it, if a file cannot be written.
    let files = wanted.page.iter().chain(&wanted.json).map(PathBuf::as_path);
    for target in files.chain(wanted.mcap()) {
        files::check(target, Some(path))?;
    }
    let record = Record::read(path)?;
    let made = record.replay(path, models, progress)?;
    if made.json != record.content.answer {
        let fault = "the replayed answer differs from the recorded one";
        return Err(Failure::new(FailureKind::Skew, fault)
            .at(path.display())
            .with_remedy("make the report with the build that recorded it; see record replay"));
    }
    let (bodies, all) = (bodies(&made.bodies)?, all_shots(&made.scene, &made.answer));
    let ranking = &made.answer.ranking;
    let is_there = |name: &&String| ranking.iter().any(|row| row.name == **name);
    if let Some(name) = wanted.candidates.iter().find(|name| !is_there(name)) {
        let names: Vec<&str> = ranking.iter().map(|row| row.name.as_str()).collect();
        return Err(Failure::input(format!("there is no candidate \"{name}\""))
            .with_remedy(format!("candidates here: {}", names.join(", "))));
    }
    let mut written = Vec::new();
    if wanted.page.is_some() || wanted.json.is_some() {
        let explanation = made.explanation.as_ref();
        let explanation = explanation.map(|of| explain::text(of, COLUMNS));
        let work = WorkDone::of_record(&record);
        let page = PlanPage {
            scenario: &made.scenario.parsed().name,
            answer: &made.answer,
            work: &work,
            scene: &made.scene,
            bodies: &bodies,
            shots: &all,
            explanation: explanation.as_deref(),
        };
        if let Some(file) = &wanted.page {
            files::replace(file, plan::page(&page).as_bytes())?;
            written.push(file.clone());
        }
        if let Some(file) = &wanted.json {
            files::replace(file, document::document(&page)?.as_bytes())?;
            written.push(file.clone());
        }
    }
    // Pictures are of contacts.
    let shots: Vec<&Shot> = all.iter().filter(|shot| shot.is_contact()).collect();
    #[cfg(feature = "mcap")]
    if let Some(path) = wanted.mcap() {
        let shots: Vec<&Shot> = shots.iter().copied().filter(|shot| wanted.shows(shot)).collect();
        let file = crate::mcap::mcap(&shots, &bodies, &made.scene)?;
        files::replace(path, &file)?;
        written.push(path.to_owned());
    }
    for (at, shot) in shots.iter().enumerate().filter(|(_, shot)| wanted.shows(shot)) {
        let stem = format!("{}-{}", at + 1, plain(&shot.name));
        picture(wanted, &stem, shot, &bodies, &mut written)?;
    }
    Ok(written)
}

/// Writes the model and the stills of one contact, as requested.
fn picture(
    wanted: &Wanted,
    stem: &str,
    shot: &Shot,
    bodies: &[ShotBody],
    written: &mut Vec<PathBuf>,
) -> Result<(), Failure> {
    if let Some(folder) = folder(wanted.glb.as_deref())? {
        let file = folder.join(format!("{stem}.glb"));
        files::replace(&file, &glb::glb(shot, bodies))?;
        written.push(file);
    }
    if let Some(folder) = folder(wanted.stills.as_deref())? {
        for (camera, from) in [(Camera::Corner, "corner"), (Camera::Above, "above")] {
            let file = folder.join(format!("{stem}-{from}.png"));
            let still = still::still(shot, bodies, camera, STILL)?;
            files::replace(&file, &still)?;
            written.push(file);
        }
    }
    Ok(())
}

fn folder(path: Option<&Path>) -> Result<Option<&Path>, Failure> {
    let Some(path) = path else { return Ok(None) };
    std::fs::create_dir_all(path).map_err(|error| {
        Failure::new(FailureKind::System, format!("{}: {error}", path.display()))
            .with_remedy("name a folder that you may write to")
    })?;
    Ok(Some(path))
}

/// A name as part of a file name.
fn plain(name: &str) -> String {
    let word = |c: char| if c.is_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    let dashed: String = name.chars().map(word).collect();
    let words: Vec<&str> = dashed.split('-').filter(|word| !word.is_empty()).collect();
    words.join("-")
}

/// A folder of `trolley measure`: its page, with the figures inside.
fn of_measurement(source: &Path, wanted: &Wanted) -> Result<Vec<PathBuf>, Failure> {
    if wanted.json.is_some() {
        let fault = "a measurement has no document: its folder holds measure.json";
        return Err(Failure::setting(fault).with_remedy("leave --report-json out"));
    }
    let Some(out) = &wanted.page else {
        let fault = "a measurement has no bodies to show";
        return Err(Failure::setting(fault).with_remedy("add --out FILE.html"));
    };
    let wrong = |path: &Path, error: &dyn std::fmt::Display| {
        Failure::input(format!("{}: {error}", path.display())).with_remedy(FOLDER)
    };
    let page = source.join("README.md");
    let text = files::text(&page, InputKind::Measurement)
        .map_err(|error| Failure::input(error.what()).with_remedy(FOLDER))?;
    let mut figures = Vec::new();
    let entries = std::fs::read_dir(source).map_err(|error| wrong(source, &error))?;
    for entry in entries {
        let path = entry.map_err(|error| wrong(source, &error))?.path();
        if path.extension().is_none_or(|end| end != "png") {
            continue;
        }
        let png = files::bytes(&path, InputKind::Measurement)?;
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        figures.push(Figure { name: name.unwrap_or_default(), png });
    }
    let title = text.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or("Measurement");
    let made = MeasurementPage { title: title.to_owned(), text: text.clone(), figures };
    files::replace(out, html::measurement(&made).as_bytes())?;
    Ok(vec![out.clone()])
}
