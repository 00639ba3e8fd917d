//! `cargo x gallery`: stills of the demo's crashes and of crashes between real bodies, and the page
//! that shows them.
//!
//! Everything is ranked, recorded and drawn by the program itself. The real bodies are third-party:
//! they are read in place, and only pictures of them are kept.

use anyhow::{Context as _, Result};
use check::built::{self, CargoWorkspace, write};
use check::step::cargo;
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

/// A real body: its mesh, and how to read it.
struct RealBody {
    name: &'static str,
    mesh: &'static str,
    how: &'static str,
    wheels: Option<Wheels>,
}

/// Wheels that are files of their own.
struct Wheels {
    /// Tyre and rim, around the axle, which is the y axis.
    meshes: [&'static str; 2],
    /// Where the axles are in the chassis' frame, and how high (m).
    axles_m: &'static [f64],
    height_m: f64,
    /// From the middle of the vehicle to that of a wheel (m).
    beside_m: f64,
}

impl RealBody {
    const fn plain(name: &'static str, mesh: &'static str, how: &'static str) -> Self {
        Self { name, mesh, how, wheels: None }
    }
}

/// Axles are those of the vehicles' descriptions where these have them (sedan, truck), else where
/// the arches have room for the tyre, as are heights.
const BODIES: &[RealBody] = &[
    RealBody {
        name: "sedan",
        mesh: "chrono_sedan/sedan_chassis_vis.obj",
        how: "--unit m --kind sedan",
        wheels: Some(Wheels {
            meshes: ["chrono_sedan/sedan_tire.obj", "chrono_sedan/sedan_rim.obj"],
            axles_m: &[1.388, -1.388],
            height_m: 0.09,
            beside_m: 0.79,
        }),
    },
    RealBody {
        name: "suv",
        mesh: "chrono_nissan_patrol_suv/suv_chassis.obj",
        how: "--unit m --kind suv",
        wheels: Some(Wheels {
            meshes: [
                "chrono_nissan_patrol_suv/suv_tire.obj",
                "chrono_nissan_patrol_suv/suv_rim.obj",
            ],
            axles_m: &[0.0, -3.27],
            height_m: 0.0,
            beside_m: 0.86,
        }),
    },
    RealBody {
        name: "truck",
        mesh: "chrono_man10t_truck/MAN_10t_chassis.obj",
        how: "--unit m --kind truck",
        wheels: Some(Wheels {
            meshes: ["chrono_man10t_truck/MAN_tire.obj", "chrono_man10t_truck/MAN_rim.obj"],
            axles_m: &[0.0, -1.93, -5.6, -7.0],
            height_m: -0.12,
            beside_m: 1.05,
        }),
    },
    RealBody::plain("pickup", "gazebo_pickup/pickup.dae", "--forward y --kind suv"),
    RealBody::plain("lamp-post", "gazebo_lamp_post/lamp_post.dae", "--unit 0.0762 --kind pole"),
    RealBody::plain(
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
    let workspace = CargoWorkspace::find()?;
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
        "# Gallery\n\nWritten by `cargo x gallery`. Every crash is simulated. Blue is the \
         ego, sand the other; red are\nthe triangles that intersect anywhere from first contact \
         on, shining through what hides them; the yellow\nframe is the contact patch, and a ring \
         marks it. Lines on the ground are a metre apart.\nBodies stand where the patch is \
         complete, 0.2 m after first contact.\n",
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
                 3.0) and ASAM OpenMATERIAL (MPL-2.0);\nwheels that are files of their own there \
                 are mounted at their axles. Crashes are simulated.\n";
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
    for RealBody { name, mesh, how, wheels } in BODIES {
        let mut path = models.join(mesh);
        if let Some(wheels) = wheels {
            let whole = mounted(&path, models, wheels)?;
            path = folder.join(format!("{name}.obj"));
            write(&path, &whole)?;
        }
        let mut command = Command::new(program);
        command.args(["model", "import", "--quiet"]).arg(path);
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

/// The chassis with its wheels, as one OBJ of vertices and faces.
fn mounted(chassis: &Path, models: &Path, wheels: &Wheels) -> Result<String> {
    let mut whole = String::new();
    let mut vertices = 0;
    add(&read(chassis)?, "chassis", &mut vertices, &mut whole, |at| at)?;
    let meshes = wheels.meshes.map(|mesh| read(&models.join(mesh)));
    for (axle, x) in wheels.axles_m.iter().enumerate() {
        // On the right a wheel is turned about the vertical, so that its outer face is outside.
        for (side, turn) in [("left", 1.0), ("right", -1.0)] {
            let place = |[u, v, w]: [f64; 3]| {
                [x + turn * u, turn * (wheels.beside_m + v), wheels.height_m + w]
            };
            for (part, mesh) in ["tyre", "rim"].into_iter().zip(&meshes) {
                let mesh = mesh.as_ref().map_err(|error| anyhow::anyhow!("{error}"))?;
                let name = format!("{part}-{side}-{}", axle + 1);
                add(mesh, &name, &mut vertices, &mut whole, place)?;
            }
        }
    }
    Ok(whole)
}

fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| path.display().to_string())
}

/// Adds the vertices and faces of an OBJ under a name, each vertex where `place` puts it.
/// `vertices` counts those that are there.
fn add(
    mesh: &str,
    name: &str,
    vertices: &mut usize,
    whole: &mut String,
    place: impl Fn([f64; 3]) -> [f64; 3],
) -> Result<()> {
    let before = *vertices;
    let _w = writeln!(whole, "g {name}");
    for line in mesh.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f64> =
                    words.take(3).map(str::parse).collect::<Result<_, _>>().context("a vertex")?;
                let at = <[f64; 3]>::try_from(numbers).ok().context("a vertex of three")?;
                let [x, y, z] = place(at);
                let _w = writeln!(whole, "v {x} {y} {z}");
                *vertices += 1;
            }
            Some("f") => {
                whole.push('f');
                for word in words {
                    let number = word.split('/').next().unwrap_or_default();
                    let number: i64 = number.parse().context("a face")?;
                    let own = (*vertices - before) as i64;
                    // Below zero it counts from the last vertex.
                    let number = if number < 0 { own + 1 + number } else { number };
                    let _w = write!(whole, " {}", before as i64 + number);
                }
                whole.push('\n');
            }
            _ => {}
        }
    }
    Ok(())
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
        // A place is said where there are several.
        let place = if rows.len() > 1 { format!("{}. ", at + 1) } else { String::new() };
        let _w = writeln!(page, "\n**{place}{title}**: harm {harm:.2} %");
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
