//! The alternatives of each recorded scene, and the scenario files that they become.

use super::bodies::{Bodies, Wanted};
use anyhow::{Context as _, Result};
use scenario::decimal;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A body at its predicted impact, in plan.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Placed {
    pub(crate) body: Wanted,
    /// Middle of its rectangle (m).
    pub(crate) at: [f64; 2],
    /// From x towards y (rad).
    pub(crate) yaw: f64,
    /// Along the heading (m/s).
    pub(crate) speed: f64,
}

/// One way that is left.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Alternative {
    pub(crate) name: String,
    pub(crate) ego: Placed,
    pub(crate) other: Placed,
    /// Name of the other party, and its type in the recording.
    pub(crate) party: String,
    pub(crate) kind: String,
}

/// A recorded scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scene {
    pub(crate) name: String,
    /// Where the poses come from, if not from the derived alternatives.
    pub(crate) by_hand: bool,
    pub(crate) alternatives: Vec<Alternative>,
}

impl Alternative {
    pub(crate) fn bodies(&self) -> [&Wanted; 2] {
        [&self.ego.body, &self.other.body]
    }
}

impl Placed {
    /// Velocity (m/s).
    pub(crate) fn velocity(&self) -> [f64; 2] {
        [self.speed * self.yaw.cos(), self.speed * self.yaw.sin()]
    }
}

/// All scenes of the list, and the one whose poses were read off by hand.
pub(crate) fn scenes(text: &str) -> Result<Vec<Scene>> {
    let list: BTreeMap<String, Vec<Value>> =
        serde_json::from_str(text).context("derived_alternatives.json")?;
    let mut scenes = Vec::new();
    for (file, cases) in &list {
        let name = file.trim_end_matches(".xml").to_owned();
        if name.starts_with("OSC_PedestrianCollision") {
            scenes.push(pedestrian(name));
            continue;
        }
        let read = cases.iter().map(alternative).collect::<Option<Vec<_>>>();
        let alternatives = read.with_context(|| format!("{file}: a key is missing"))?;
        scenes.push(Scene { name, by_hand: false, alternatives });
    }
    Ok(scenes)
}

fn alternative(case: &Value) -> Option<Alternative> {
    let number = |at: &Value, key: &str| at[key].as_f64();
    let (ego, other) = (&case["ego"], &case["obstacle"]);
    let placed = |at: &Value, kind: &str| {
        Some(Placed {
            body: Wanted {
                kind: kind.to_owned(),
                size: [number(at, "length")?, number(at, "width")?],
            },
            at: [number(at, "x")?, number(at, "y")?],
            yaw: number(at, "yaw")?,
            speed: number(at, "v")?,
        })
    };
    let kind = other["type"].as_str()?;
    let id = other["id"].as_str()?;
    let (brake, alat) = (number(&case["manoeuvre"], "brake")?, number(&case["manoeuvre"], "alat")?);
    let turn = match alat {
        a if a > 0.0 => format!("left {a}"),
        a if a < 0.0 => format!("right {}", -a),
        _ => "straight".to_owned(),
    };
    let pedal = if brake > 0.0 { format!("brake {brake}, ") } else { "go on, ".to_owned() };
    Some(Alternative {
        name: format!("{pedal}{turn}"),
        ego: placed(ego, "ego")?,
        other: placed(other, kind)?,
        party: format!("{kind} {id}"),
        kind: kind.to_owned(),
    })
}

/// `OSC_PedestrianCollision`: no sweep finds its pedestrian, a circle. Step 55 of the recording,
/// read off by hand: as it drives on, half a second of braking earlier, and one metre further left.
fn pedestrian(name: String) -> Scene {
    let yaw: f64 = 1.7973;
    let at = [31.59, -21.6421];
    let ego = |speed: f64, left: f64| Placed {
        body: Wanted { kind: "ego".to_owned(), size: [5.04, 2.0] },
        at: [at[0] - left * yaw.sin(), at[1] + left * yaw.cos()],
        yaw,
        speed,
    };
    let walker = Placed {
        body: Wanted { kind: "pedestrian".to_owned(), size: [0.6, 0.6] },
        at: [31.2173, -18.5939],
        yaw: 3.3639,
        speed: 1.6,
    };
    let alternative = |name: &str, ego: Placed| Alternative {
        name: name.to_owned(),
        ego,
        other: walker.clone(),
        party: "pedestrian 35".to_owned(),
        kind: "pedestrian".to_owned(),
    };
    let alternatives = vec![
        alternative("as recorded", ego(9.0, 0.0)),
        alternative("braked to 5 m/s", ego(5.0, 0.0)),
        alternative("1 m further left", ego(9.0, 1.0)),
    ];
    Scene { name, by_hand: true, alternatives }
}

impl Scene {
    pub(crate) fn has_unknown(&self) -> bool {
        self.alternatives.iter().any(|one| one.kind == "unknown")
    }

    /// The scenario file.
    pub(crate) fn text(&self, bodies: &Bodies) -> String {
        let mut text = format!("schema = \"trolley.scenario/1\"\nname = \"{}\"\n", self.name);
        let mut parties: BTreeMap<&str, &Placed> = BTreeMap::new();
        for one in &self.alternatives {
            parties.insert("ego", &one.ego);
            parties.insert(&one.party, &one.other);
        }
        for (name, placed) in parties {
            let file = bodies.file(&placed.body);
            let _w = writeln!(text, "\n[parties.\"{name}\"]\nfile = \"{file}\"");
            if placed.body.kind == "unknown" {
                let _w = writeln!(text, "kind = \"unknown\"");
            }
        }
        for one in &self.alternatives {
            let state = |placed: &Placed| {
                format!(
                    "position_m = [{}, {}, 0], yaw_deg = {}, speed_m_s = {}",
                    decimal(placed.at[0]),
                    decimal(placed.at[1]),
                    decimal(placed.yaw.to_degrees()),
                    decimal(placed.speed)
                )
            };
            let _w = writeln!(
                text,
                "\n[[candidates]]\nname = \"{}\"\nego = {{ {} }}\nother = {{ party = \"{}\", {} }}",
                one.name,
                state(&one.ego),
                one.party,
                state(&one.other)
            );
        }
        text
    }
}
