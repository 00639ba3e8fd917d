//! `trolley policy check`: checks policies and curves, and prints what they say.

use crate::output::Output;
use crate::print;
use crate::reference_args::ReferenceArgs;
use crate::table::table;
use clap::{Args, Subcommand};
use report::table::Column;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::policy::map::{MapAxis, MapRequest, MapRow, PolicyMap};
use trolley::policy::{CheckOptions, CheckedFile, CheckedRegression, Day};
use trolley::{Failure, FailureKind};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley policy check config/policies/*.toml
  trolley policy check worst-off-first config/curves/levels.toml
  trolley policy check BOARD.toml --today 2027-01-01

Refused are: unknown keys (age, sex and condition of persons by name), curves without unit or
source, non-numbers, a severer injury likelier than a milder one, weights that are
negative or do not sum to 1, ties left open, and a policy whose outcome a kind of person lacks.

A policy may say in [dossier] who signed it and until when it is valid, and in [[regression]] who
must win in which scenario. Refused are a policy whose last day is over, and one that lets another
candidate win than it says. Without a dossier it is valid, and said to be unsigned.

Exit codes: 0 all is sound, 65 something is refused.";

const MAP_EXAMPLES: &str = "\
Examples:
  trolley policy map config/scenarios/demo.toml --policies config/policies
  trolley policy map config/examples/crash.toml --policies default ego-only worst-off-first
  trolley policy map config/examples/crash.toml --policies precaution -o crash.html --y accepted \\
      --cells 3

What can be varied:
  speed         the ego's speed, as a factor on it: the same ways in less time or more
  odds          the odds of injury of everybody, as a factor on those of the curves and their ranges
  odds-outside  those of persons on foot, on bicycles and on motorcycles
  odds-inside   those of persons inside of vehicles
  accepted      the accepted risk of the policy's first precaution, a share
  tolerance     the tolerance of the policy's first comparison, a share

Every cell is a ranking without a deadline. A policy without the number varied has no picture.";

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Check policies and sets of curves, and describe them in words.
    #[command(after_help = EXAMPLES)]
    Check {
        /// Policies and sets of curves, TOML; the tables of a file tell which it is.
        #[arg(required = true)]
        files: Vec<PathBuf>,
        /// Curves in which the policies must find their outcome [default: the built-in ones].
        #[arg(long, value_name = "FILE")]
        curves: Option<PathBuf>,
        /// The day on which policies must be valid, YYYY-MM-DD [default: today, UTC].
        #[arg(long, value_name = "DAY", value_parser = day)]
        today: Option<Day>,
        #[command(flatten)]
        references: ReferenceArgs,
    },
    /// Show which candidate of a scenario wins under which policy and which curves, and where that
    /// flips as two numbers are varied.
    #[command(after_help = MAP_EXAMPLES)]
    Map(Box<MapArgs>),
}

/// The arguments of `policy map`.
#[derive(Debug, Args)]
pub(crate) struct MapArgs {
    /// Scenario, TOML.
    scenario: PathBuf,
    /// Policies, or folders of them [default: that of the scenario].
    #[arg(long, value_name = "FILE", num_args = 1..)]
    policies: Vec<PathBuf>,
    /// Sets of curves [default: those of the scenario].
    #[arg(long, value_name = "FILE", num_args = 1..)]
    curves: Vec<PathBuf>,
    /// Picture to write, by its ending: SVG, or a page with the table.
    #[arg(short, long, value_name = "OUT.svg|OUT.html")]
    out: Option<PathBuf>,
    /// What the picture varies from left to right.
    #[arg(long, value_name = "KNOB[=FROM..TO]", default_value = "speed", requires = "out")]
    x: String,
    /// What the picture varies from below.
    #[arg(long, value_name = "KNOB[=FROM..TO]", default_value = "odds-outside", requires = "out")]
    y: String,
    /// Cells of the picture from side to side, 2 to 101; each is a ranking.
    #[arg(long, value_name = "N", default_value_t = 21, requires = "out")]
    cells: usize,
    #[command(flatten)]
    references: ReferenceArgs,
}

fn day(text: &str) -> Result<Day, String> {
    Day::parse(text).ok_or_else(|| "write a day of the calendar as YYYY-MM-DD".to_owned())
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    match verb {
        Verb::Check { files, curves, today, references } => {
            let options = CheckOptions {
                curves: curves.as_deref(),
                today: *today,
                references: references.references(),
            };
            check(files, &options, output)
        }
        Verb::Map(asked) => draw_map(asked, output),
    }
}

fn check(
    files: &[PathBuf],
    options: &CheckOptions<'_>,
    output: &Output,
) -> Result<ExitCode, Failure> {
    let checked = trolley::policy::check_with(files, options)?;
    if output.json {
        #[derive(Serialize)]
        struct Document<'a> {
            schema: &'static str,
            files: &'a [CheckedFile],
        }
        let document = Document { schema: "trolley.policy-check/1", files: &checked };
        print::out(&print::json(&document)?)?;
    } else {
        for one in checked.iter().filter(|one| one.fault.is_none()) {
            let (file, kind, name) = (&one.file, one.kind, &one.name);
            let verdict = if one.is_sound() { "is sound" } else { "is refused" };
            print::out(&format!("{file}: {kind} \"{name}\" {verdict}"))?;
            for says in &one.says {
                print::text(&format!("  {says}"))?;
            }
            let kept = one.regressions.iter().filter(|regression| regression.fault.is_none());
            for regression in kept {
                print::text(&format!("  {}", as_stated(regression)))?;
            }
        }
        for one in &checked {
            let broken = one.regressions.iter().filter_map(|regression| regression.fault.as_ref());
            for fault in one.fault.iter().chain(broken) {
                print::err(&format!("error: {fault}"));
            }
        }
    }
    let is_sound = checked.iter().all(CheckedFile::is_sound);
    Ok(if is_sound { ExitCode::SUCCESS } else { FailureKind::Input.into() })
}

/// "../scenarios/small.toml: "wall" wins and "pedestrian" comes last, as stated: nobody on foot".
fn as_stated(regression: &CheckedRegression) -> String {
    let CheckedRegression { scenario, expected, reason, .. } = regression;
    let winner = match &expected.winner {
        Some(winner) => format!("\"{winner}\" wins"),
        None => "nobody wins".to_owned(),
    };
    let worst = expected.worst.as_ref().map(|worst| format!(" and \"{worst}\" comes last"));
    format!("{scenario}: {winner}{}, as stated: {reason}", worst.unwrap_or_default())
}

/// Draws who wins, as a table and as a picture.
fn draw_map(asked: &MapArgs, output: &Output) -> Result<ExitCode, Failure> {
    let MapArgs { scenario, policies, curves, out, x, y, cells, references } = asked;
    let is_page = match out.as_ref().map(|out| out.extension().and_then(|end| end.to_str())) {
        None | Some(Some("svg")) => false,
        Some(Some("html")) => true,
        Some(_) => {
            let failure = Failure::setting("a picture is an .svg or an .html");
            return Err(failure.with_remedy("write -o map.svg"));
        }
    };
    if let Some(out) = out {
        trolley::files::check(out, Some(scenario))?;
    }
    let axes = [MapAxis::parse(x)?, MapAxis::parse(y)?];
    let request = MapRequest {
        policies: policies.clone(),
        curves: curves.clone(),
        grid: out.is_some().then_some((axes, *cells)),
        references: references.references(),
    };
    let progress = output.progress("rankings");
    let map =
        trolley::policy::map::map(scenario, &request, &|done, total| progress.set(done, total))?;
    drop(progress);
    if output.json {
        #[derive(Serialize)]
        struct Document<'a> {
            schema: &'static str,
            #[serde(flatten)]
            map: &'a PolicyMap,
        }
        print::out(&print::json(&Document { schema: "trolley.policy-map/1", map: &map })?)?;
    } else {
        print::text(&winners(&map))?;
    }
    if let Some(out) = out {
        let (page, svg) = (report::policy_map::page, report::policy_map::svg);
        let picture = if is_page { page(&map) } else { svg(&map) };
        trolley::files::replace(out, picture.as_bytes())?;
        output.say(&format!("written: {}", out.display()));
    }
    Ok(ExitCode::SUCCESS)
}

/// The table of a map.
fn winners(map: &PolicyMap) -> String {
    const COLUMNS: [Column; 5] = [
        Column::words("policy", 12),
        Column::words("curves", 8).dispensable(2),
        Column::words("wins", 12),
        Column::words("comes last", 12).dispensable(1),
        Column::words("as good, within the model", 16),
    ];
    let winner = |row: &MapRow| match (&row.winner, &row.fault) {
        (Some(winner), _) => winner.clone(),
        (None, Some(_)) => "not ranked".to_owned(),
        (None, None) => "nobody".to_owned(),
    };
    let cells = |row: &MapRow| {
        vec![
            row.policy.clone(),
            row.curves.clone(),
            winner(row),
            row.last.clone().unwrap_or_default(),
            if row.tied.is_empty() { "–".to_owned() } else { row.tied.join(", ") },
        ]
    };
    let rows: Vec<Vec<String>> = map.rows.iter().map(cells).collect();
    let mut said =
        vec![format!("{}. Who wins under which policy?", map.scenario), table(&COLUMNS, &rows)];
    for row in &map.rows {
        for note in row.notes.iter().chain(&row.fault) {
            said.push(format!("{}, {}: {note}", row.policy, row.curves));
        }
    }
    said.join("\n")
}
