//! What esmini writes with `--csv_logger`: a line for each moment, with the same columns for every
//! entity, `#1 World_Position_X [m]`, `#2 …`. Read by their names, so that the order and what else
//! there is do not matter.
//!
//! The position is that of an entity's reference point; `bb_x`, `bb_y` lead from there to the
//! middle of its box, in its own frame. What an entity is, the file does not say: its size decides.

use crate::ReadOptions;
use crate::error::{TrafficError, TrafficPlace};
use crate::outline::Placed;
use crate::recording::Recording;
use crate::trace::{Fault, Seen, Tracks, kind_by_size, listed, whole};

/// Columns, at most: 30 for each of a few hundred entities.
const COLUMNS_MAX: usize = 20_000;
/// Lines before the one with the names of the columns, at most.
const HEAD_MAX: usize = 50;

/// Where an entity's values stand.
struct Columns {
    name: usize,
    /// x, y, z, heading; length, width, height; the middle of its box in x, y, z.
    numbers: [usize; 10],
    velocity: Option<[usize; 2]>,
}

/// Reads the text of such a file.
pub(crate) fn read(
    file: &str,
    text: &str,
    options: &ReadOptions<'_>,
) -> Result<Recording, TrafficError> {
    let at_line = |line: usize, (what, remedy): Fault| TrafficError {
        file: file.to_owned(),
        place: TrafficPlace::Line { line: line as u32 + 1, column: 1 },
        what,
        remedy,
    };
    let mut lines = text.lines().enumerate();
    let head = lines.by_ref().take(HEAD_MAX).find(|(_, line)| line.trim().starts_with("Index"));
    let Some((number, head)) = head else {
        let fault = "no line of names, which begins with \"Index [-], TimeStamp [s]\"";
        let remedy = "is this the right file? It is written by esmini with --csv_logger FILE.csv";
        return Err(whole(file, (fault.to_owned(), remedy.to_owned())));
    };
    // A line ends with a comma, or does not.
    let head = head.trim().trim_end_matches(',');
    let names: Vec<&str> = head.split(',').map(str::trim).collect();
    let (time, entities) = columns(&names).map_err(|fault| at_line(number, fault))?;
    let mut tracks = Tracks::default();
    let mut ids: Vec<String> = Vec::new();
    for (number, line) in lines {
        if line.trim().is_empty() {
            continue;
        }
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let failed = |fault: Fault| at_line(number, fault);
        if fields.len() < names.len() {
            let fault = format!("{} values for {} columns", fields.len(), names.len());
            let remedy = "the file ends within a line, or is damaged: write it again".to_owned();
            return Err(failed((fault, remedy)));
        }
        let number = |column: usize| value(&names, &fields, column);
        tracks.begin(number(time).map_err(failed)?).map_err(failed)?;
        for entity in &entities {
            // Who is not there any more has no name.
            let id = fields[entity.name];
            if id.is_empty() {
                continue;
            }
            let seen = seen(entity, number).map_err(failed)?;
            tracks.add(id, seen).map_err(failed)?;
            if !ids.iter().any(|known| known == id) {
                ids.push(id.to_owned());
            }
        }
    }
    if tracks.is_empty() {
        let fault = "it has names of columns, and no moment".to_owned();
        return Err(whole(file, (fault, "let esmini run, then rank what it wrote".to_owned())));
    }
    let ego = match options.ego {
        Some(asked) => asked,
        None => ids.iter().find(|id| id.eq_ignore_ascii_case("ego")).ok_or_else(|| {
            let known = listed(ids.iter().map(String::as_str));
            let fault = "no entity is called Ego".to_owned();
            whole(file, (fault, format!("name it: --ego NAME. Entities here: {known}")))
        })?,
    };
    tracks.recording("esmini", ego, options).map_err(|fault| whole(file, fault))
}

/// The column of the time, and those of every entity.
fn columns(names: &[&str]) -> Result<(usize, Vec<Columns>), Fault> {
    if names.len() > COLUMNS_MAX {
        let fault = format!("{} columns", names.len());
        return Err((fault, format!("at most {COLUMNS_MAX} are read")));
    }
    // Units, which stand behind the names, have changed their spelling.
    let plain: Vec<&str> =
        names.iter().map(|name| name.split('[').next().unwrap_or_default().trim()).collect();
    let find = |name: &str| plain.iter().position(|known| *known == name);
    let need = |name: &str| {
        find(name).ok_or_else(|| {
            let fault = format!("the column {name:?} is missing");
            (fault, "it is written by esmini with --csv_logger FILE.csv".to_owned())
        })
    };
    let time = need("TimeStamp")?;
    let mut entities = Vec::new();
    for name in &plain {
        // Versions before 2.20 misspell it.
        let entity = name
            .strip_suffix("Entity_Name")
            .or_else(|| name.strip_suffix("Entitity_Name"))
            .filter(|entity| entity.starts_with('#'));
        let Some(entity) = entity else { continue };
        let mut numbers = [0; 10];
        for (slot, key) in numbers.iter_mut().zip(KEYS) {
            *slot = need(&format!("{entity}{key}"))?;
        }
        let along = ["Vel_X", "Vel_Y"].map(|key| find(&format!("{entity}{key}")));
        let velocity = if let [Some(x), Some(y)] = along { Some([x, y]) } else { None };
        entities.push(Columns { name: need(name)?, numbers, velocity });
    }
    if entities.is_empty() {
        let fault = "no column is called \"#1 Entity_Name [-]\"".to_owned();
        return Err((fault, "it is written by esmini with --csv_logger FILE.csv".to_owned()));
    }
    Ok((time, entities))
}

const KEYS: [&str; 10] = [
    "World_Position_X",
    "World_Position_Y",
    "World_Position_Z",
    "World_Heading_Angle",
    "bb_length",
    "bb_width",
    "bb_height",
    "bb_x",
    "bb_y",
    "bb_z",
];

/// A finite number of this line.
fn value(names: &[&str], fields: &[&str], column: usize) -> Result<f64, Fault> {
    let text = fields[column];
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => {
            let shown: String = text.chars().take(40).collect();
            let fault = format!("{}: {shown:?} is not a finite number", names[column]);
            Err((fault, "the file is damaged, or the simulation failed there".to_owned()))
        }
    }
}

fn seen(columns: &Columns, number: impl Fn(usize) -> Result<f64, Fault>) -> Result<Seen, Fault> {
    let mut numbers = [0.0; 10];
    for (slot, column) in numbers.iter_mut().zip(columns.numbers) {
        *slot = number(column)?;
    }
    let [x, y, z, yaw, length, width, height, mid_x, mid_y, mid_z] = numbers;
    let reference = Placed { at: [x, y], yaw };
    let size_m = [length, width, height];
    let velocity_m_s = match columns.velocity {
        Some([x, y]) => Some([number(x)?, number(y)?]),
        None => None,
    };
    Ok(Seen {
        kind: kind_by_size(size_m),
        is_guessed: true,
        is_fixed: false,
        size_m,
        place: Placed { at: reference.point([mid_x, mid_y]), yaw },
        bottom_m: z + mid_z - 0.5 * height,
        velocity_m_s,
    })
}

#[cfg(test)]
mod tests;
