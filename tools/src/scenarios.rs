//! `cargo x scenarios`: rankings checked by exact intersection at dense steps of time.
//!
//! The check knows nothing of the search: it moves both bodies along their paths, step by step, and
//! asks at each pose whether any triangles intersect. After a heavy contact it moves the ego by the
//! formula of the run-out, from what the answer says of its begin. Then
//!
//! - a contact of the answer is *confirmed* if bodies touch at a step within two steps after it;
//! - one that is *shorter than the step* must touch within a microsecond at which it is sought;
//! - one that was not decided is *possible*, and flagged in the answer;
//! - anything else that either of both finds alone is an error: *missed* or *invented*.
//!
//! Scenes are ranked as stated, without members.

use crate::machine;
use anyhow::{Context as _, Result, bail};
use bvh::query::{Workspace, touches};
use geometry::motion::MotionPath;
use geometry::{DVec3, Pose, RelativePose};
use scenario::Candidate;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trolley::bodies::{Bodies, SILENT};
use trolley::traffic::{TrafficOptions, import, is_traffic};
use trolley::{ContactRow, CourseRow, Engine, Limits, References, Scenario, Severity};

/// Deceleration of a run-out (m/s²).
const RUN_OUT_M_S2: f64 = 0.5 * 9.806_65;
/// After a light contact the search goes on from this much travel on, at most (m).
const PASSED_M: f64 = 0.9;
/// How far along its way a body may be met otherwise on the chords of a run-out (m): they are
/// within 0.3 mm of it, and a body that grazes is met earlier or later by a multiple of that.
const CHORD_M: f64 = 0.005;
/// How finely contacts that are shorter than a step are sought (s).
const FINE_S: f64 = 1e-6;

/// What to check.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Scenarios (TOML), CommonRoad files, or traces of simulators.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Step of time (ms).
    #[arg(long, default_value_t = 1.0, value_name = "MS")]
    step_ms: f64,
    /// The page to write.
    #[arg(long, value_name = "FILE.md")]
    out: Option<PathBuf>,
}

/// What was found in one file.
#[derive(Debug, Default)]
struct Tally {
    candidates: usize,
    free: usize,
    contacts: usize,
    confirmed: usize,
    short: usize,
    possible: usize,
    light_first: usize,
    at_start: usize,
    poses: u64,
    errors: Vec<String>,
}

pub(crate) fn run(options: &Options) -> Result<ExitCode> {
    if !(options.step_ms >= 0.01 && options.step_ms <= 1000.0) {
        bail!("--step-ms is {}: it may be 0.01 to 1000", options.step_ms);
    }
    let mut page = format!(
        "# Rankings beside exact intersection every {} ms\n\n\
         Written by `cargo x scenarios FILE… --out PAGE` over the files below. *Confirmed*: bodies \
         intersect at a step within two steps after the contact. *Short*: they do so only between \
         steps, which was checked to 1 µs. *Possible*: not decided within the resolution, and \
         flagged. *Missed*: intersection that the ranking does not know. *Invented*: a contact \
         without intersection.\n\n",
        options.step_ms
    );
    let root = std::env::current_dir()?;
    let machine = options.out.as_ref().map(|_| machine::describe(&root)).transpose()?;
    for (name, value) in machine.unwrap_or_default() {
        let _w = writeln!(page, "- {name}: {value}");
    }
    page += "\n| file | ways | touch nobody | contacts | confirmed | short | possible | missed or \
             invented | exact poses | search ms |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    let mut courses = String::new();
    let mut errors = 0;
    let mut out = std::io::stdout();
    for path in &options.files {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let (tally, rows, search_ms) =
            check(path, options.step_ms * 1e-3).with_context(|| path.display().to_string())?;
        let Tally { candidates, free, contacts, confirmed, short, possible, poses, .. } = tally;
        let _w = writeln!(
            out,
            "{name}: {candidates} ways, {free} touch nobody, {contacts} contacts: {confirmed} \
             confirmed, {short} shorter than a step, {possible} possible, {} after a light first \
             touch, {} at the start, {} errors; {poses} exact poses",
            tally.light_first,
            tally.at_start,
            tally.errors.len()
        );
        for error in &tally.errors {
            let _w = writeln!(out, "  ERROR: {error}");
        }
        errors += tally.errors.len();
        let _w = writeln!(
            page,
            "| {name} | {candidates} | {free} | {contacts} | {confirmed} | {short} | {possible} \
             | {} | {poses} | {search_ms:.1} |",
            tally.errors.len()
        );
        let _w = write!(courses, "\n## {name}\n\n| # | manoeuvre | meets |\n|--:|---|---|\n{rows}");
    }
    if let Some(out) = &options.out {
        std::fs::write(out, page + &courses)?;
        let _w = writeln!(std::io::stdout(), "written: {}", out.display());
    }
    Ok(if errors == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Ranks a file and checks the answer; returns the rows of the page, too.
fn check(path: &Path, step_s: f64) -> Result<(Tally, String, f64)> {
    let name = path.display().to_string();
    let text = if is_traffic(path) {
        import(path, &TrafficOptions::default())?.text
    } else {
        trolley::read_text(path)?
    };
    let scenario = Scenario::parse_with(&name, &text, References::Anywhere)?;
    let scenario = scenario.assuming_unknown_is_fixed();
    let mut engine = Engine::builder().in_process().build()?;
    // The exact check is of the scene as stated: members go other ways.
    let ranking = engine.rank(&scenario, &Limits::default().with_members(1, None)?)?;
    let bodies = Bodies::of_scenario(&scenario, SILENT)?;
    let mut tally = Tally::default();
    let mut rows = String::new();
    let mut workspace = Workspace::new();
    let parsed = scenario.parsed();
    for (place, row) in ranking.answer.ranking.iter().enumerate() {
        let candidate = parsed.candidates.iter().find(|candidate| *candidate.name == *row.name);
        let candidate = candidate.context("a candidate of the answer is not in the scenario")?;
        tally.candidates += 1;
        tally.free += usize::from(row.touches_nobody());
        let all: Vec<String> = row.contacts.iter().map(met).collect();
        let all = if all.is_empty() { "nobody".to_owned() } else { all.join("; ") };
        let _w = writeln!(rows, "| {} | {} | {all} |", place + 1, row.name);
        let way = Way { row, candidate };
        for (number, party) in parsed.parties.iter().enumerate() {
            if number == parsed.ego.0 {
                continue;
            }
            let reaction = candidate.reactions.iter().find(|reaction| reaction.party.0 == number);
            let likeliest = party
                .predictions
                .iter()
                .reduce(|most, next| if next.probability > most.probability { next } else { most });
            let predicted = likeliest.map(|prediction| &prediction.motion.path);
            let other = reaction.map(|reaction| &reaction.motion.path).or(predicted);
            let other = other.context("a party without a motion")?;
            let views = bodies.views()?;
            let views = [&views[parsed.ego.0].1, &views[number].1];
            let mut touch = |time_s: f64, before_s: f64| -> Result<bool> {
                let ego = way.pose_at(time_s, before_s);
                let pose = RelativePose::between(&ego, &other.pose_at(time_s));
                if is_far(views, &pose) {
                    return Ok(false);
                }
                tally.poses += 1;
                Ok(touches(*views[0], *views[1], &pose, &mut workspace)?)
            };
            let mut touching = Vec::new();
            let steps = (way.end_s() / step_s).floor() as u32;
            for step in 0..=steps {
                let time_s = f64::from(step) * step_s;
                if touch(time_s, time_s)? {
                    touching.push(time_s);
                }
            }
            let contacts = row.contacts.iter().filter(|contact| *contact.party == *party.name);
            let contacts: Vec<&ContactRow> = contacts.collect();
            let verdicts = judge(row, &party.name, &contacts, &touching, step_s, &mut touch)?;
            verdicts.into_iter().for_each(|verdict| tally.count(verdict));
        }
    }
    Ok((tally, rows, ranking.run.stages.plan_ms))
}

/// What became of a contact, or of a time at which bodies touch.
enum Verdict {
    Confirmed,
    Short,
    Possible,
    AtStart,
    /// Bodies touch a little before the contact that counts, or after it, in the same crash.
    SameCrash,
    Error(String),
}

impl Tally {
    fn count(&mut self, verdict: Verdict) {
        self.contacts += usize::from(!matches!(verdict, Verdict::SameCrash | Verdict::Error(_)));
        match verdict {
            Verdict::Confirmed => self.confirmed += 1,
            Verdict::Short => self.short += 1,
            Verdict::Possible => self.possible += 1,
            Verdict::AtStart => self.at_start += 1,
            Verdict::SameCrash => self.light_first += 1,
            Verdict::Error(error) => self.errors.push(error),
        }
    }
}

/// Compares the contacts of an answer with the times at which bodies touch, ascending.
fn judge(
    row: &CourseRow,
    party: &str,
    contacts: &[&ContactRow],
    touching: &[f64],
    step_s: f64,
    touch: &mut dyn FnMut(f64, f64) -> Result<bool>,
) -> Result<Vec<Verdict>> {
    let mut verdicts = Vec::new();
    for contact in contacts {
        let at_s = contact.time_s;
        let soon = |time_s: &&f64| at_s - FINE_S <= **time_s && **time_s <= at_s + 2.0 * step_s;
        verdicts.push(if contact.is_at_start {
            Verdict::AtStart
        } else if touching.iter().any(|time_s| soon(&time_s)) {
            Verdict::Confirmed
        } else if !contact.is_certain {
            Verdict::Possible
        } else {
            let steps = (2.0 * step_s / FINE_S) as u32;
            // A heavy contact changes the way at once, but it took place before that.
            let mut found = false;
            for step in 0..=steps {
                let time_s = at_s - 10.0 * FINE_S + f64::from(step) * FINE_S;
                found = found || touch(time_s, at_s)?;
            }
            if found {
                Verdict::Short
            } else {
                let name = &row.name;
                Verdict::Error(format!("{name}: contact with {party} at {at_s} s is invented"))
            }
        });
    }
    let heavy = contacts.iter().find(|contact| contact.severity == Severity::Heavy);
    let until_s = heavy.map_or(f64::INFINITY, |contact| contact.time_s);
    let is_passed = row.remarks.iter().any(|remark| {
        remark.contains(&format!("in contact with \"{party}\" at the start, and they part"))
    });
    let mut before_s = f64::NEG_INFINITY;
    for time_s in touching {
        let gap_s = time_s - before_s;
        let begins = gap_s > 1.5 * step_s;
        before_s = *time_s;
        if !begins || *time_s > until_s {
            continue;
        }
        let passing_s =
            |contact: &ContactRow| PASSED_M / contact.closing_m_s.max(0.01) + 2.0 * step_s;
        // What the answer calls the first contact lies after the last time at which nothing
        // touches, within the resolution; and it moves the ego along chords of the run-out.
        let is_known = contacts.iter().any(|contact| {
            let rough_s = if row.run_outs.is_empty() { 0.0 } else { CHORD_M };
            let rough_s = rough_s / contact.closing_m_s.max(0.01);
            contact.excluded_before_s - rough_s - FINE_S <= *time_s
                && *time_s <= contact.time_s + 2.0 * step_s
        });
        let is_near = contacts.iter().any(|contact| {
            let (first_s, later_s) = (contact.first_touch_s, time_s - contact.time_s);
            let is_first = first_s - FINE_S <= *time_s && *time_s <= contact.time_s;
            // Bodies that touch have parted once they are apart for as long as they take to pass.
            let is_same = later_s >= 0.0 && gap_s <= passing_s(contact);
            is_first || is_same || (0.0..=passing_s(contact)).contains(&later_s)
        });
        if is_known || (is_passed && *time_s < 0.2) {
            continue;
        }
        verdicts.push(if is_near {
            Verdict::SameCrash
        } else {
            let name = &row.name;
            Verdict::Error(format!("{name}: {party} touches at {time_s} s, which is missed"))
        });
    }
    Ok(verdicts)
}

/// The way of the ego in one candidate.
struct Way<'w> {
    row: &'w CourseRow,
    candidate: &'w Candidate,
}

impl Way<'_> {
    /// Until when contacts are looked for (s).
    fn end_s(&self) -> f64 {
        let planned: &MotionPath = &self.candidate.ego.path;
        self.row.at_horizon.as_ref().map_or(planned.to_s(), |end| end.time_s)
    }

    /// Where the ego is at a time, after the heavy contacts before another time (s): on its planned
    /// path, and from each heavy contact on braked to rest, straight.
    fn pose_at(&self, time_s: f64, before_s: f64) -> Pose {
        let planned = &self.candidate.ego.path;
        let legs: Vec<_> = self.row.run_outs.iter().filter(|out| out.from_s < before_s).collect();
        let Some(first) = legs.first() else { return planned.pose_at(time_s) };
        let mut pose = planned.pose_at(first.from_s);
        for (number, leg) in legs.iter().enumerate() {
            let to_s = legs.get(number + 1).map_or(time_s, |next| next.from_s);
            let [vx, vy] = leg.velocity_m_s;
            let speed = vx.hypot(vy);
            if speed > 0.0 {
                let after_s = (to_s - leg.from_s).min(speed / RUN_OUT_M_S2);
                let share = after_s - RUN_OUT_M_S2 * after_s * after_s / (2.0 * speed);
                pose.translation[0] += vx * share;
                pose.translation[1] += vy * share;
            }
        }
        pose
    }
}

/// Whether balls around the origins that hold both bodies are apart.
fn is_far(bodies: [&body::BodyView<'_>; 2], pose: &RelativePose) -> bool {
    let radius = |view: &body::BodyView<'_>| {
        let bounds = view.bounds();
        let far = |axis: usize| f64::from(bounds.min[axis].abs().max(bounds.max[axis].abs()));
        DVec3::new(far(0), far(1), far(2)).length()
    };
    let apart = DVec3::from(pose.translation).length();
    apart > (radius(bodies[0]) + radius(bodies[1])) * 1.000_001
}

/// "1.70 s car 399, heavy".
fn met(contact: &ContactRow) -> String {
    let kind = match contact.severity {
        Severity::Light => "light",
        Severity::Heavy => "heavy",
    };
    format!("{:.3} s {}, {kind}", contact.time_s, contact.party)
}
