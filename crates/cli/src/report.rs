//! `trolley report`: a decision record or a measurement as one HTML file; candidates as .glb and
//! PNG.
//!
//! A record holds no hit sets, so the request is made again from it, as `record replay` does; if
//! the answer is not the recorded one, no page is written.

use crate::output::Output;
use crate::record::{self, replay};
use crate::{explain, print};
use ::record::{End, Record};
use clap::Args as ClapArgs;
use clap::builder::NonEmptyStringValueParser;
use coordinator::{Answer, Explanation, PersonRow, Row, Scene};
use damage::evidence::Touch;
use report::still::Camera;
use report::{Body, Candidate, Decision, Figure, Measurement, Moment, Patch, Shot, Span, Worker};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trolley::files;
use trolley::{Failure, Kind};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley demo --record decisions && trolley report decisions/000000.record --out demo.html
  trolley report decisions/000000.record --models bodies --out crash.html --glb meshes --png stills
  trolley report tools/results/measure --out measure.html

The page is one file: it opens from disk without a network.";

/// Pixels of a still.
const STILL: [usize; 2] = [1200, 800];
/// Longest file of a measurement that goes into a page.
const FILE_MAX: u64 = 16 << 20;

#[derive(Debug, ClapArgs)]
pub(crate) struct ReportArgs {
    /// A decision record, or a folder that `trolley measure --out` wrote.
    source: PathBuf,
    /// Page to write.
    #[arg(short, long, value_name = "FILE.html")]
    out: Option<PathBuf>,
    /// Folder with the model files that the record names; they are found by their hash.
    #[arg(long, value_name = "DIR")]
    models: Option<PathBuf>,
    /// Write each candidate into this folder as .glb, damage as vertex colours.
    #[arg(long, value_name = "DIR")]
    glb: Option<PathBuf>,
    /// Write two stills of each candidate into this folder: from a corner, and from above.
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,
    /// Write the candidates into this file as MCAP, for Foxglove and Lichtblick.
    #[cfg(feature = "mcap")]
    #[arg(long, value_name = "FILE.mcap")]
    mcap: Option<PathBuf>,
    /// Only this candidate's .glb and stills; may stand several times.
    #[arg(long, value_name = "NAME", value_parser = NonEmptyStringValueParser::new())]
    candidate: Vec<String>,
}

impl ReportArgs {
    /// Whether pictures of this candidate are asked for.
    fn wants(&self, shot: &Shot) -> bool {
        self.candidate.is_empty() || self.candidate.contains(&shot.name)
    }

    /// The MCAP file to write, of builds that can.
    fn mcap(&self) -> Option<&Path> {
        #[cfg(feature = "mcap")]
        return self.mcap.as_deref();
        #[cfg(not(feature = "mcap"))]
        None
    }
}

pub(crate) fn run(args: &ReportArgs, output: &Output) -> Result<ExitCode, Failure> {
    if args.out.is_none() && args.glb.is_none() && args.png.is_none() && args.mcap().is_none() {
        let fault = "nothing to write";
        return Err(
            Failure::setting(fault).with_remedy("add --out FILE.html, --glb DIR or --png DIR")
        );
    }
    if args.source.is_dir() {
        return measurement(args, output);
    }
    let (record, link) = record::read(&args.source)?;
    let path = args.source.as_path();
    let made = replay::with(path, &record, args.models.as_deref(), output, |again| {
        let answer = again.work.answer()?;
        let text = print::line(&answer)?;
        if text != record.answer {
            let fault = format!("{}: made again, the answer is another", path.display());
            return Err(Failure::new(Kind::Skew, fault).with_remedy(
                "make the report with the build that recorded it; see record replay",
            ));
        }
        let parties = again.scenario.parties.iter().zip(again.views);
        let bodies = parties.map(|(party, (_, view))| Body {
            name: party.name.to_string(),
            corners: view.corners.to_vec(),
        });
        Ok(Made {
            name: again.scenario.name.clone(),
            bodies: bodies.collect(),
            scenes: again.work.scenes(),
            explanation: again.work.explanation()?,
            answer,
        })
    })?;
    let shots = shots(&made);
    if let Some(name) = args.candidate.iter().find(|name| !shots.iter().any(|s| s.name == **name)) {
        let names: Vec<&str> = shots.iter().map(|shot| shot.name.as_str()).collect();
        return Err(Failure::input(format!("there is no candidate \"{name}\""))
            .with_remedy(format!("candidates here: {}", names.join(", "))));
    }
    let mut written = Vec::new();
    if let Some(out) = &args.out {
        let mut decision = decision(&made, &record);
        decision.facts = facts(&record, &link);
        let page = report::html::decision(&decision, &made.bodies, &shots);
        write::replace(out, page.as_bytes())?;
        written.push(out.clone());
    }
    #[cfg(feature = "mcap")]
    if let Some(path) = args.mcap() {
        let shots: Vec<&Shot> = shots.iter().filter(|shot| args.wants(shot)).collect();
        let file = report::mcap::mcap(&shots, &made.bodies)?;
        write::replace(path, &file)?;
        written.push(path.to_owned());
    }
    for (at, shot) in shots.iter().enumerate().filter(|(_, shot)| args.wants(shot)) {
        let stem = format!("{}-{}", at + 1, plain(&shot.name));
        picture(args, &stem, shot, &made.bodies, &mut written)?;
    }
    said(&written, output)
}

/// Writes the model and the stills of one candidate, as far as they are asked for.
fn picture(
    args: &ReportArgs,
    stem: &str,
    shot: &Shot,
    bodies: &[Body],
    written: &mut Vec<PathBuf>,
) -> Result<(), Failure> {
    if let Some(folder) = folder(args.glb.as_deref())? {
        let file = folder.join(format!("{stem}.glb"));
        write::replace(&file, &report::glb::glb(shot, bodies))?;
        written.push(file);
    }
    if let Some(folder) = folder(args.png.as_deref())? {
        for (camera, from) in [(Camera::Corner, "corner"), (Camera::Above, "above")] {
            let file = folder.join(format!("{stem}-{from}.png"));
            let still = report::still::still(shot, bodies, camera, STILL)?;
            write::replace(&file, &still)?;
            written.push(file);
        }
    }
    Ok(())
}

/// What was made again.
struct Made {
    name: String,
    bodies: Vec<Body>,
    scenes: Vec<Scene>,
    explanation: Explanation,
    answer: Answer,
}

fn said(written: &[PathBuf], output: &Output) -> Result<ExitCode, Failure> {
    if output.json {
        let files: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
        let document = serde_json::json!({"schema": "trolley.report/1", "files": files});
        return print::out(&print::json(&document)?);
    }
    if output.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    let lines: Vec<String> =
        written.iter().map(|path| format!("written: {}", path.display())).collect();
    print::out(&lines.join("\n"))
}

fn folder(path: Option<&Path>) -> Result<Option<&Path>, Failure> {
    let Some(path) = path else { return Ok(None) };
    std::fs::create_dir_all(path)
        .map_err(|error| Failure::new(Kind::System, format!("{}: {error}", path.display())))?;
    Ok(Some(path))
}

/// A name as part of a file's.
fn plain(name: &str) -> String {
    let word = |c: char| if c.is_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    let dashed: String = name.chars().map(word).collect();
    let words: Vec<&str> = dashed.split('-').filter(|word| !word.is_empty()).collect();
    words.join("-")
}

/// Every candidate in the order of the ranking.
fn shots(made: &Made) -> Vec<Shot> {
    let shot = |row: &Row| {
        let scene = made.scenes.iter().find(|scene| scene.name == row.name)?;
        let patch = row.contact.patch.as_ref().map(|patch| Patch {
            centre_m: patch.centre_m,
            normal: patch.normal,
            size_m: [patch.width_m.hi(), patch.height_m.hi()],
        });
        let hits: usize = scene.hits.iter().map(Vec::len).sum();
        let caption = match patch {
            Some(patch) => format!(
                "{}: {}. {hits} triangles intersect from first contact on; the patch is {:.2} m \
                 wide and {:.2} m high. Bodies as they lie when it is complete.",
                row.name, row.sides, patch.size_m[0], patch.size_m[1]
            ),
            None => format!("{}: nothing touches. Bodies as they lie at the given pose.", row.name),
        };
        Some(Shot {
            name: row.name.clone(),
            bodies: scene.models,
            rotation: scene.pose.rotation,
            translation: scene.pose.translation,
            hits: scene.hits.clone(),
            patch,
            caption,
        })
    };
    made.answer.ranking.iter().filter_map(shot).collect()
}

fn who(person: &PersonRow) -> String {
    match person.seat {
        Some("front-left") => format!("{} driver", person.party),
        Some(seat) => format!("{} {}", person.party, seat.replace('-', " ")),
        None => person.party.clone(),
    }
}

fn candidate(row: &Row) -> Candidate {
    let touches = row.contact.touch == Touch::Yes;
    let contact = match row.contact.touch {
        Touch::Yes => row.sides.clone(),
        Touch::No if row.contact.hull_gap_m > 0.0 => {
            format!("none: {:.2} m apart", row.contact.hull_gap_m)
        }
        Touch::No => "none".to_owned(),
        Touch::Unknown => "unknown".to_owned(),
    };
    let [ego, other] = row.delta_v_m_s.map(|delta| touches.then(|| delta.work.hi()));
    let person = |person: &PersonRow| {
        let (work, range) = (person.work, person.range);
        (who(person), [work.lo(), work.hi()], [range.low(), range.high()])
    };
    Candidate {
        name: row.name.clone(),
        other: row.other.clone(),
        contact,
        touches,
        depth_m: row.contact.patch.as_ref().map(|patch| patch.depth_m.hi()),
        delta_v_m_s: [ego, if row.is_other_fixed { None } else { other }],
        work: [row.work.lo(), row.work.hi()],
        range: [row.range.low(), row.range.high()],
        why: row.why.clone(),
        persons: row.persons.iter().map(person).collect(),
    }
}

fn decision(made: &Made, record: &Record) -> Decision {
    let Made { answer, explanation, .. } = made;
    let count = |end: End| record.jobs.iter().filter(|job| job.end == end).count() as u64;
    let mut jobs_of: BTreeMap<u32, (u64, u64)> = BTreeMap::new();
    for job in &record.jobs {
        let Some(place) = record.places.get(job.place as usize) else { continue };
        let (done, not) = jobs_of.entry(place.candidate).or_default();
        match job.end {
            End::Done => *done += 1,
            End::Cut | End::Abandoned => *not += 1,
        }
    }
    let name = |number: u32| explanation.names.get(number as usize).cloned().unwrap_or_default();
    let mut workers: BTreeMap<u8, Vec<Span>> = BTreeMap::new();
    for span in &record.spans {
        let (from_ms, to_ms) = (span.from_ns as f64 / 1e6, span.to_ns as f64 / 1e6);
        workers.entry(span.worker).or_default().push(Span { from_ms, to_ms });
    }
    let missing = answer.missing.iter().map(|name| format!("Not fully known: {name}."));
    let assumed = answer.assumptions.iter().map(|text| format!("Assumed: {text}."));
    let near = answer.ranking.iter().filter(|row| row.contact.near_miss);
    let near = near.map(|row| format!("Near miss, closer than poses are known: {}.", row.name));
    let faults = record.faults.iter().map(|fault| format!("Note: {fault}."));
    Decision {
        scenario: made.name.clone(),
        state: answer.state.name().to_owned(),
        candidates: answer.ranking.iter().map(candidate).collect(),
        ties: answer.tie_class.clone(),
        policy: explanation.policy.clone(),
        board: explanation.board.clone(),
        outcome: explanation.outcome.to_uppercase(),
        persons: explanation.persons,
        remarks: missing.chain(assumed).chain(near).chain(faults).collect(),
        explanation: explain::text(explanation),
        stages: record.stages.iter().map(|stage| (stage.name.clone(), stage.ms)).collect(),
        jobs: [count(End::Done), count(End::Cut), count(End::Abandoned)],
        jobs_of: jobs_of.into_iter().map(|(of, (done, not))| (name(of), done, not)).collect(),
        workers: workers
            .into_iter()
            .map(|(worker, spans)| Worker { name: format!("worker {worker}"), spans })
            .collect(),
        moments: record
            .moments
            .iter()
            .map(|moment| Moment {
                at_ms: moment.at_ns as f64 / 1e6,
                jobs: moment.jobs,
                work: moment.work.clone(),
            })
            .collect(),
        names: explanation.names.clone(),
        edges: record
            .edges
            .iter()
            .map(|edge| (edge.from.clone(), edge.to.clone(), edge.messages, edge.bytes))
            .collect(),
        facts: Vec::new(),
    }
}

fn facts(record: &Record, link: &::record::Link) -> Vec<(String, String)> {
    let fact = |name: &str, value: String| (name.to_owned(), value);
    let s = &record.settings;
    let mut facts = vec![
        fact("record", format!("{} of its chain, {}", link.number, record::hex(&link.hash))),
        fact("after", record::hex(&link.previous)),
        fact("build", record.build.clone()),
        fact("scenario", format!("{} {}", record.scenario.name, record.scenario.hash)),
        fact("policy", format!("{} {}", record.policy.name, record.policy.hash)),
        fact("curves", format!("{} {}", record.curves.name, record.curves.hash)),
        fact(
            "settings",
            format!(
                "{}, {} workers, depth {}, tree {}, {}, batch {}, queue {}, seed {}",
                s.mode.name(),
                s.workers,
                s.depth,
                s.tree.name(),
                s.scheme.name(),
                s.batch,
                s.queue,
                s.seed
            ),
        ),
    ];
    let body = |body: &::record::Body| fact(&format!("body {}", body.party), body.hash.clone());
    facts.extend(record.bodies.iter().map(body));
    facts
}

/// A folder of `trolley measure`: its page, with the figures inside.
fn measurement(args: &ReportArgs, output: &Output) -> Result<ExitCode, Failure> {
    let Some(out) = &args.out else {
        let fault = "a measurement has no bodies to show";
        return Err(Failure::setting(fault).with_remedy("add --out FILE.html"));
    };
    let wrong = |path: &Path, error: &dyn std::fmt::Display| {
        Failure::input(format!("{}: {error}", path.display()))
            .with_remedy("give a folder that `trolley measure --out` wrote")
    };
    let page = args.source.join("README.md");
    let text = std::fs::read_to_string(&page).map_err(|error| wrong(&page, &error))?;
    let mut figures = Vec::new();
    let entries = std::fs::read_dir(&args.source).map_err(|error| wrong(&args.source, &error))?;
    for entry in entries {
        let path = entry.map_err(|error| wrong(&args.source, &error))?.path();
        let about = std::fs::metadata(&path).map_err(|error| wrong(&path, &error))?;
        if path.extension().is_none_or(|end| end != "png") || about.len() > FILE_MAX {
            continue;
        }
        let png = std::fs::read(&path).map_err(|error| wrong(&path, &error))?;
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        figures.push(Figure { name: name.unwrap_or_default(), png });
    }
    let title = text.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or("Measurement");
    let made = Measurement { title: title.to_owned(), text: text.clone(), figures };
    write::replace(out, report::html::measurement(&made).as_bytes())?;
    said(std::slice::from_ref(out), output)
}
