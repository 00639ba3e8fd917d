//! `cargo x gallery`: stills of the demo's crashes and of crashes between real bodies, and the page
//! that shows them.
//!
//! Everything is ranked, recorded and drawn by the program itself. The real bodies are third-party:
//! they are read in place, and only pictures of them are kept.

use crate::built::{self, Workspace, write};
use crate::step::cargo;
use anyhow::{Context as _, Result};
use serde_json::Value;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// What to draw, and where to.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// The data: a folder with models. Without it only the demo is drawn.
    #[arg(long, value_name = "DIR", default_value = "../shared/data")]
    data: PathBuf,
    /// The page to write; pictures are written into a folder of its name beside it.
    #[arg(long, value_name = "FILE", default_value = "tools/results/gallery.md")]
    out: PathBuf,
    /// A program that is built already, instead of a new one.
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
}

/// Real bodies: name, mesh, how to read it.
const BODIES: &[(&str, &str, &str)] = &[
    ("sedan", "chrono_sedan/sedan_chassis_vis.obj", "--unit m --kind sedan"),
    ("suv", "chrono_nissan_patrol_suv/suv_chassis.obj", "--unit m --kind suv"),
    ("truck", "chrono_man10t_truck/MAN_10t_chassis.obj", "--unit m --kind truck"),
    ("pickup", "gazebo_pickup/pickup.dae", "--forward y --kind suv"),
    ("lamp-post", "gazebo_lamp_post/lamp_post.dae", "--unit 0.0762 --kind pole"),
    (
        "person",
        "openmaterial_human/human_example.gltf",
        "--unit m --up y --forward x --kind pedestrian",
    ),
];

/// Crashes of the sedan: name, whom, where and how fast, the ego's speed (m/s).
const CRASHES: &[(&str, &str, &str, u32)] = &[
    ("rear-end the SUV", "suv", "position_m = [4.75, 0.3, 0], speed_m_s = 4", 15),
    ("side of the truck", "truck", "position_m = [3.4, 1, 0], yaw_deg = 90, speed_m_s = 6", 14),
    ("oncoming pick-up", "pickup", "position_m = [5, 0.7, 0], yaw_deg = 180, speed_m_s = 12", 13),
    ("lamp post", "lamp-post", "position_m = [2.3, 0.2, 0], speed_m_s = 0", 13),
    ("person", "person", "position_m = [2.5, 0.3, 0], yaw_deg = 90, speed_m_s = 1.4", 11),
];

pub(crate) fn run(options: &Options) -> Result<ExitCode> {
    let workspace = Workspace::find()?;
    let program = match &options.program {
        Some(program) => program.clone(),
        None => {
            let build = &["build", "--release", "--package", "trolley-cli", "--bin", "trolley"];
            built::executable(cargo().args(build))?
        }
    };
    let folder = workspace.target.join("gallery");
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    std::fs::create_dir_all(&folder)?;
    let out = workspace.root.join(&options.out);
    let beside = out.with_extension("");
    std::fs::create_dir_all(&beside)?;
    let mut page = String::from(
        "# Gallery\n\nWritten by `cargo x gallery`. Blue is the ego, sand the other; red are the \
         triangles that intersect\nanywhere from first contact on, shining through what hides \
         them; the yellow frame is the contact patch.\nBodies stand where the patch is complete, \
         0.2 m after first contact.\n",
    );
    let demo = folder.join("demo");
    let mut command = Command::new(&program);
    let record = command.args(["demo", "--in-process", "--quiet", "--record"]).arg(&demo);
    built::output(record)?;
    page += "\n## The demo: generated bodies\n";
    show(&program, &demo, None, &beside, "demo", &mut page)?;
    let models = workspace.root.join(&options.data).join("models");
    if models.is_dir() {
        let scenario = real(&program, &models, &folder)?;
        let records = folder.join("real");
        let mut command = Command::new(&program);
        command.args(["rank", "--in-process", "--quiet"]).arg(&scenario);
        built::output(command.arg("--record").arg(&records))?;
        page += "\n## Real bodies\n\nMeshes of Project Chrono (BSD-3-Clause), Open Robotics (CC BY \
                 3.0) and ASAM OpenMATERIAL (MPL-2.0);\nwheels are files of their own there and \
                 not shown.\n";
        show(&program, &records, Some(&folder), &beside, "real", &mut page)?;
    }
    write(&out, &page)?;
    writeln!(std::io::stdout(), "{}", out.display())?;
    Ok(ExitCode::SUCCESS)
}

/// Imports the bodies and writes the scenario of their crashes.
fn real(program: &Path, models: &Path, folder: &Path) -> Result<PathBuf> {
    let mut text = String::from("schema = \"trolley.scenario/1\"\nname = \"Real bodies\"\n");
    text += "ego = \"sedan\"\n";
    for (name, mesh, how) in BODIES {
        let mut command = Command::new(program);
        command.args(["model", "import", "--quiet"]).arg(models.join(mesh));
        command.args(how.split(' ')).arg("-o").arg(folder.join(format!("{name}.trolley")));
        built::output(&mut command)?;
        let _w = writeln!(text, "[parties.{name}]\nfile = \"{name}.trolley\"");
    }
    for (name, whom, state, speed) in CRASHES {
        let _w = writeln!(
            text,
            "[[candidates]]\nname = \"{name}\"\nego = {{ position_m = [0, 0, 0], speed_m_s = \
             {speed} }}\nother = {{ party = \"{whom}\", {state} }}"
        );
    }
    let path = folder.join("real.toml");
    write(&path, &text)?;
    Ok(path)
}

/// Draws every candidate of a record, least harm first, and adds them to the page.
fn show(
    program: &Path,
    records: &Path,
    models: Option<&Path>,
    beside: &Path,
    prefix: &str,
    page: &mut String,
) -> Result<()> {
    let record = records.join("000000.record");
    let stills = records.join("stills");
    let mut command = Command::new(program);
    command.args(["report", "--quiet"]).arg(&record).arg("--png").arg(&stills);
    if let Some(models) = models {
        command.arg("--models").arg(models);
    }
    built::output(&mut command)?;
    let mut command = Command::new(program);
    let said = built::output(command.args(["record", "show", "--json"]).arg(&record))?;
    let document: Value = serde_json::from_str(&said)?;
    let rows = document["answer"]["ranking"].as_array().context("a ranking")?;
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(&stills)?.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?;
    files.sort();
    for (at, row) in rows.iter().enumerate() {
        let own = |file: &&PathBuf| {
            let name = file.file_name().map(|name| name.to_string_lossy().into_owned());
            name.is_some_and(|name| {
                name.starts_with(&format!("{}-", at + 1)) && name.ends_with("-corner.png")
            })
        };
        let Some(file) = files.iter().find(own) else { continue };
        let name = format!("{prefix}-{}.png", at + 1);
        std::fs::copy(file, beside.join(&name))?;
        let title = row["name"].as_str().unwrap_or_default();
        let sides = row["sides"].as_str().filter(|sides| !sides.is_empty());
        let harm = 100.0 * row["work"][1].as_f64().unwrap_or_default();
        let folder = beside.file_name().map(|name| name.to_string_lossy().into_owned());
        let folder = folder.unwrap_or_default();
        let _w = writeln!(
            page,
            "\n**{}. {title}**: {}, harm {harm:.2} %\n\n![{title}]({folder}/{name})",
            at + 1,
            sides.unwrap_or("touches nothing")
        );
    }
    Ok(())
}
