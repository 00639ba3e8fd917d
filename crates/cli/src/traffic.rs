//! `trolley scenario import`, and `trolley rank FILE.xml`: traffic files as scenarios.
//!
//! Files are opened here; `traffic` reads their text, sweeps the ego's manoeuvres and writes the
//! scenario, which is then read as if a person had written it.

use crate::args::Output;
use crate::print;
use clap::{Args as ClapArgs, Subcommand};
use diagnostic::{Failure, Kind};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use traffic::{
    Catalog, DEFAULT_LIBRARY, Library, Manoeuvre, Meeting, ReadOptions, Recording, Sweep, Swept,
};

const EXAMPLES: &str = "\
Examples:
  trolley scenario import DEU_Gar-1_1_T-1.xml -o gar.toml && trolley rank gar.toml
  trolley scenario import crossing.xml --at 2.5 --brakes 0,8 --laterals=-4,0,4
  trolley scenario import cut-in.xosc --catalog VehicleCatalog.xosc

Read are CommonRoad 2018b and 2020a, and OpenSCENARIO 1.x where it states world positions. Without
-o the scenario is printed.";

/// When a recorded ego meets somebody too late for a sweep from its start, manoeuvres begin this
/// long before (s): a driver's reaction.
const BEFORE_S: f64 = 1.0;

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Make a scenario from recorded or written traffic: CommonRoad or OpenSCENARIO.
    #[command(after_help = EXAMPLES)]
    Import(ImportArgs),
}

#[derive(Debug, ClapArgs)]
pub(crate) struct ImportArgs {
    /// Traffic file, .xml or .xosc.
    file: PathBuf,
    #[command(flatten)]
    traffic: TrafficArgs,
    /// Scenario to write.
    #[arg(short, long, value_name = "OUT.toml")]
    out: Option<PathBuf>,
}

/// How a traffic file is to be understood, and which manoeuvres are tried.
#[derive(Clone, Debug, Default, ClapArgs)]
#[command(next_help_heading = "Traffic files (CommonRoad, OpenSCENARIO)")]
pub(crate) struct TrafficArgs {
    /// Which obstacle, planning problem or entity is the ego, where the file leaves that open.
    #[arg(long, value_name = "ID")]
    ego: Option<String>,
    /// Leave this obstacle out; may stand several times.
    #[arg(long, value_name = "ID")]
    without: Vec<String>,
    /// When manoeuvres begin, after the ego's start (s); until then it goes as recorded.
    #[arg(long, value_name = "S", value_parser = within::<0, 3600>)]
    at: Option<f64>,
    /// How far ahead is looked (s; default: 3).
    #[arg(long, value_name = "S", value_parser = within::<0, 60>)]
    horizon: Option<f64>,
    /// Decelerations to try (m/s²; default: 0,4,8).
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = within::<0, 20>)]
    brakes: Option<Vec<f64>>,
    /// Lateral accelerations to try, left positive (m/s²; default: -6,-3,0,3,6).
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = within::<-20, 20>,
        allow_hyphen_values = true)]
    laterals: Option<Vec<f64>>,
    /// What the tyres give in all (m/s²; default: 9).
    #[arg(long, value_name = "A", value_parser = within::<1, 20>)]
    grip: Option<f64>,
    /// Library of bodies by type (default: generated ones, config/bodies/default.toml).
    #[arg(long, value_name = "FILE")]
    bodies: Option<PathBuf>,
    /// Catalogue of OpenSCENARIO; may stand several times.
    #[arg(long, value_name = "FILE")]
    catalog: Vec<PathBuf>,
}

/// A number in a range.
fn within<const LEAST: i32, const MOST: i32>(text: &str) -> Result<f64, String> {
    let range = f64::from(LEAST)..=f64::from(MOST);
    match text.trim().parse::<f64>() {
        Ok(value) if range.contains(&value) => Ok(value + 0.0),
        _ => Err(format!("write a number, {LEAST} to {MOST}")),
    }
}

impl TrafficArgs {
    fn sweep(&self) -> Result<Sweep, Failure> {
        let usual = Sweep::default();
        let sweep = Sweep {
            brakes_m_s2: self.brakes.clone().unwrap_or(usual.brakes_m_s2),
            laterals_m_s2: self.laterals.clone().unwrap_or(usual.laterals_m_s2),
            grip_m_s2: self.grip.unwrap_or(usual.grip_m_s2),
            horizon_s: self.horizon.unwrap_or(usual.horizon_s),
            after_s: self.at.unwrap_or(usual.after_s),
            ..usual
        };
        if let Some(brake) = sweep.brakes_m_s2.iter().find(|brake| **brake > sweep.grip_m_s2) {
            let fault = format!("--brakes: {brake} m/s² is more than the tyres give");
            let help = format!("--grip is {} m/s²", sweep.grip_m_s2);
            return Err(Failure::setting(fault).with_remedy(help));
        }
        Ok(sweep)
    }

    fn library(&self) -> Result<Library, Failure> {
        let Some(path) = &self.bodies else {
            let shipped = Library::parse("config/bodies/default.toml", DEFAULT_LIBRARY);
            return shipped.map_err(Failure::internal);
        };
        let text = crate::inputs::text(path)?;
        let library = Library::parse(&path.display().to_string(), &text).map_err(|fault| {
            Failure::input(fault).with_remedy("see config/bodies/default.toml for the form")
        })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let folder = std::path::absolute(folder.join("x"))
            .ok()
            .and_then(|inside| inside.parent().map(Path::to_owned))
            .unwrap_or_else(|| folder.to_owned());
        Ok(library.with_files(|file| folder.join(file).display().to_string()))
    }
}

/// A traffic file, read and swept.
pub(crate) struct Imported {
    recording: Recording,
    swept: Swept,
    horizon_s: f64,
    notes: Vec<String>,
    /// The scenario; `None`: nobody is met.
    pub(crate) text: Option<String>,
}

/// Whether a file is traffic rather than a scenario of ours: by its name, or by its first letter.
pub(crate) fn is_traffic(path: &Path) -> bool {
    let end = path.extension().map(|end| end.to_string_lossy().to_ascii_lowercase());
    if matches!(end.as_deref(), Some("xml" | "xosc")) {
        return true;
    }
    let mut head = [0; 64];
    let read = std::fs::File::open(path).and_then(|mut file| {
        use std::io::Read as _;
        file.read(&mut head)
    });
    let head = &head[..read.unwrap_or(0)];
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    head.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'<')
}

/// The text of a traffic file or catalogue.
fn text(path: &Path) -> Result<String, Failure> {
    let wrong = |fault: String| Failure::input(format!("{}: {fault}", path.display()));
    let about = std::fs::metadata(path).map_err(|error| wrong(error.to_string()))?;
    if about.len() > traffic::TEXT_BYTES_MAX as u64 {
        let fault = format!("{} bytes are too many for a traffic file", about.len());
        return Err(wrong(fault).with_remedy("is this the right file?"));
    }
    let bytes = std::fs::read(path).map_err(|error| wrong(error.to_string()))?;
    String::from_utf8(bytes).map_err(|error| {
        let byte = error.utf8_error().valid_up_to();
        wrong(format!("not UTF-8 from byte {byte} on"))
            .with_remedy("is this the right file? save as UTF-8")
    })
}

/// Reads a traffic file, sweeps, and writes the scenario.
pub(crate) fn import(path: &Path, args: &TrafficArgs) -> Result<Imported, Failure> {
    let name = path.display().to_string();
    let mut sweep = args.sweep()?;
    let library = args.library()?;
    let source = text(path)?;
    let mut catalogs = Vec::new();
    for path in &args.catalog {
        catalogs.push((path.display().to_string(), text(path)?));
    }
    let catalogs: Vec<Catalog<'_>> =
        catalogs.iter().map(|(file, text)| Catalog { file, text }).collect();
    let options =
        ReadOptions { ego: args.ego.as_deref(), without: &args.without, catalogs: &catalogs };
    let recording = traffic::read(&name, &source, &options)?;
    let mut notes = recording.notes.clone();
    let mut swept = recording.sweep(&sweep);
    if swept.meetings.is_empty()
        && args.at.is_none()
        && let Some(meets_s) = recording.recorded_meeting_s(sweep.step_s)
    {
        sweep.after_s = (meets_s - BEFORE_S).max(0.0);
        notes.push(format!(
            "as recorded, the ego meets somebody after {meets_s:.2} s: manoeuvres begin \
             {BEFORE_S} s before; --at changes that"
        ));
        swept = recording.sweep(&sweep);
    }
    if let Some(whom) = swept.overlapped {
        let id = &recording.others[whom].id;
        let fault = format!("{name}: the ego and obstacle {id} overlap where manoeuvres begin");
        let help = format!("if it is the ego itself: --without {id}; else begin earlier: --at");
        return Err(Failure::new(Kind::Refused, fault).with_remedy(help));
    }
    let text = match swept.meetings.as_slice() {
        [] => None,
        _ => {
            let written = traffic::scenario_text(&name, &recording, &swept, &library);
            let (text, more) = written.map_err(|fault| {
                Failure::input(format!("{name}: {fault}"))
                    .with_remedy("add it to a library and name that: --bodies FILE")
            })?;
            notes.extend(more);
            Some(text)
        }
    };
    Ok(Imported { recording, swept, horizon_s: sweep.horizon_s, notes, text })
}

/// A meeting as `--json` has it.
#[derive(Serialize)]
struct MeetingRow<'a> {
    manoeuvre: String,
    after_s: f64,
    ego_m: [f64; 2],
    ego_yaw_rad: f64,
    ego_speed_m_s: f64,
    other: &'a str,
    kind: &'a str,
    other_m: [f64; 2],
    other_yaw_rad: f64,
    other_speed_m_s: f64,
}

/// What `--json` has of an import.
#[derive(Serialize)]
pub(crate) struct Document<'a> {
    schema: &'static str,
    file: String,
    name: &'a str,
    scenario: Option<&'a str>,
    meetings: Vec<MeetingRow<'a>>,
    /// Manoeuvres that meet nobody.
    free: Vec<String>,
    horizon_s: f64,
    notes: &'a [String],
}

impl Imported {
    fn row(&self, meeting: &Meeting) -> MeetingRow<'_> {
        let other = &self.recording.others[meeting.whom];
        MeetingRow {
            manoeuvre: meeting.manoeuvre.name(),
            after_s: meeting.ego.time_s - self.swept.began_s,
            ego_m: meeting.ego.place.at,
            ego_yaw_rad: meeting.ego.place.yaw,
            ego_speed_m_s: meeting.ego.speed_m_s,
            other: &other.id,
            kind: &other.kind,
            other_m: meeting.other.place.at,
            other_yaw_rad: meeting.other.place.yaw,
            other_speed_m_s: meeting.other.speed_m_s,
        }
    }

    pub(crate) fn document(&self, path: &Path) -> Document<'_> {
        Document {
            schema: "trolley.scenario-import/1",
            file: path.display().to_string(),
            name: &self.recording.name,
            scenario: self.text.as_deref(),
            meetings: self.swept.meetings.iter().map(|meeting| self.row(meeting)).collect(),
            free: self.swept.free.iter().map(Manoeuvre::name).collect(),
            horizon_s: self.horizon_s,
            notes: &self.notes,
        }
    }

    /// What was found, for people: one line for each fact.
    pub(crate) fn summary(&self) -> String {
        let (meet, free) = (self.swept.meetings.len(), self.swept.free.len());
        let mut text = format!(
            "{}: {} obstacles; {meet} of {} manoeuvres meet somebody within {} s",
            self.recording.name,
            self.recording.others.len(),
            meet + free,
            self.horizon_s
        );
        if free > 0 && meet > 0 {
            let names: Vec<String> = self.swept.free.iter().take(4).map(Manoeuvre::name).collect();
            let more = if free > 4 { "; …" } else { "" };
            let _w = write!(text, "\nfree of any: {}{more}", names.join("; "));
        }
        for note in &self.notes {
            let _w = write!(text, "\nNote: {note}.");
        }
        text
    }
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    let Verb::Import(args) = verb;
    let imported = import(&args.file, &args.traffic)?;
    if let (Some(out), Some(text)) = (&args.out, &imported.text) {
        crate::model::write::replace(out, text.as_bytes())?;
    }
    if output.json {
        return print::out(&print::json(&imported.document(&args.file))?);
    }
    if !output.quiet {
        print::err(&imported.summary());
    }
    match (&imported.text, &args.out) {
        (None, _) => {
            print::err("Nothing to rank: no scenario was written.");
            Ok(ExitCode::SUCCESS)
        }
        (Some(_), Some(out)) => {
            print::err(&format!("written: {}", out.display()));
            Ok(ExitCode::SUCCESS)
        }
        (Some(text), None) => print::out(text),
    }
}
