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

/// A crash of the sedan, in the moment when the sedan's origin is that of the world.
struct Crash {
    name: &'static str,
    whom: &'static str,
    /// Where the other one stands then (m).
    at_m: [f64; 2],
    yaw_deg: f64,
    /// How fast the other one and the sedan go (m/s).
    speeds_m_s: [f64; 2],
}

const CRASHES: &[Crash] = &[
    Crash {
        name: "rear-end the SUV",
        whom: "suv",
        at_m: [4.75, 0.3],
        yaw_deg: 0.0,
        speeds_m_s: [4.0, 15.0],
    },
    Crash {
        name: "side of the truck",
        whom: "truck",
        at_m: [3.4, 1.0],
        yaw_deg: 90.0,
        speeds_m_s: [6.0, 14.0],
    },
    Crash {
        name: "oncoming pick-up",
        whom: "pickup",
        at_m: [5.0, 0.7],
        yaw_deg: 180.0,
        speeds_m_s: [12.0, 13.0],
    },
    Crash {
        name: "lamp post",
        whom: "lamp-post",
        at_m: [2.3, 0.2],
        yaw_deg: 0.0,
        speeds_m_s: [0.0, 13.0],
    },
    Crash {
        name: "person",
        whom: "person",
        at_m: [2.5, 0.3],
        yaw_deg: 90.0,
        speeds_m_s: [1.4, 11.0],
    },
];
/// How long before that moment a scene begins (s).
const BEFORE_S: f64 = 0.5;

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
        let scenes = real(&program, &models, &folder)?;
        page += "\n## Real bodies\n\nMeshes of Project Chrono (BSD-3-Clause), Open Robotics (CC BY \
                 3.0) and ASAM OpenMATERIAL (MPL-2.0);\nwheels are files of their own there and \
                 not shown.\n";
        for (number, scene) in scenes.iter().enumerate() {
            let records = scene.with_extension("records");
            let mut command = Command::new(&program);
            command.args(["rank", "--in-process", "--quiet"]).arg(scene);
            built::output(command.arg("--record").arg(&records))?;
            let prefix = format!("real-{}", number + 1);
            show(&program, &records, Some(&folder), &beside, &prefix, &mut page)?;
        }
    }
    write(&out, &page)?;
    writeln!(std::io::stdout(), "{}", out.display())?;
    Ok(ExitCode::SUCCESS)
}

/// Imports the bodies and writes a scenario for each crash.
fn real(program: &Path, models: &Path, folder: &Path) -> Result<Vec<PathBuf>> {
    for (name, mesh, how) in BODIES {
        let mut command = Command::new(program);
        command.args(["model", "import", "--quiet"]).arg(models.join(mesh));
        command.args(how.split(' ')).arg("-o").arg(folder.join(format!("{name}.trolley")));
        built::output(&mut command)?;
    }
    let scene = |(number, crash): (usize, &Crash)| {
        let Crash { name, whom, at_m: [x, y], yaw_deg, speeds_m_s: [speed, ego_speed] } = crash;
        let (sin, cos) = f64::to_radians(*yaw_deg).sin_cos();
        let (x, y) = (x - BEFORE_S * speed * cos, y - BEFORE_S * speed * sin);
        let motion = if *speed > 0.0 {
            format!(
                "state = {{ position_m = [{x:.3}, {y:.3}, 0], yaw_deg = {yaw_deg}, speed_m_s = \
                 {speed} }}"
            )
        } else {
            format!("place = {{ position_m = [{x:.3}, {y:.3}, 0], yaw_deg = {yaw_deg} }}")
        };
        let text = format!(
            "schema = \"{}\"\nname = \"{name}\"\nego = \"sedan\"\nhorizon_s = 1.5\n\n\
             [parties.sedan]\nfile = \"sedan.trolley\"\n\n\
             [parties.{whom}]\nfile = \"{whom}.trolley\"\n{motion}\n\n\
             [[candidates]]\nname = \"{name}\"\nstate = {{ position_m = [{:.3}, 0, 0], \
             speed_m_s = {ego_speed} }}\n",
            scenario::SCHEMA,
            -BEFORE_S * ego_speed
        );
        let path = folder.join(format!("real-{}.toml", number + 1));
        write(&path, &text)?;
        Ok(path)
    };
    CRASHES.iter().enumerate().map(scene).collect()
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
    // Numbers have no leading zeros: by name, "10-…" would come before "2-…".
    let number = |file: &Path| -> Option<u32> {
        file.file_name()?.to_str()?.split('-').next()?.parse().ok()
    };
    files.retain(|file| file.to_string_lossy().ends_with("-corner.png"));
    files.sort_by_key(|file| number(file));
    let mut corners = files.iter();
    let folder = beside.file_name().map(|name| name.to_string_lossy().into_owned());
    let folder = folder.unwrap_or_default();
    let mut drawn = 0;
    for (at, row) in rows.iter().enumerate() {
        let title = row["name"].as_str().unwrap_or_default();
        let harm = 100.0 * row["work"][1].as_f64().unwrap_or_default();
        let contacts = row["contacts"].as_array().map_or(&[][..], Vec::as_slice);
        let _w = writeln!(page, "\n**{}. {title}**: harm {harm:.2} %", at + 1);
        if contacts.is_empty() {
            let _w = writeln!(page, "\nTouches nobody.");
        }
        for contact in contacts {
            drawn += 1;
            let file = corners.find(|file| number(file) == Some(drawn));
            let file = file.with_context(|| format!("no still of contact {drawn}"))?;
            let name = format!("{prefix}-{drawn}.png");
            std::fs::copy(file, beside.join(&name))?;
            let said = format!(
                "{}, {:.2} s, {}",
                contact["party"].as_str().unwrap_or_default(),
                contact["time_s"].as_f64().unwrap_or_default(),
                contact["severity"].as_str().unwrap_or_default()
            );
            let _w = writeln!(page, "\n{said}:\n\n![{title}: {said}]({folder}/{name})");
        }
    }
    Ok(())
}
