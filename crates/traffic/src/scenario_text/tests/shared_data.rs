//! The recordings of others, which are no part of this project, as scenarios.

use super::{WRITTEN_M, library, motion, off_m, read_back};
use crate::manoeuvre::began;
use crate::write::{moved, names};
use crate::{Manoeuvres, ReadOptions, read, scenario_text};
use std::path::{Path, PathBuf};

fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(folder);
    let entries = std::fs::read_dir(path).expect("a folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let mut files: Vec<PathBuf> =
        paths.filter(|path| path.extension().is_some_and(|end| end == ending)).collect();
    files.sort();
    files
}

/// Makes a scenario, reads it, and compares everybody with the track at recorded times. Returns
/// what there is in it; `Err`: why there is none.
fn checked(path: &Path, after_s: f64) -> Result<String, String> {
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let text = std::fs::read_to_string(path).expect("readable");
    let recording =
        read(&file, &text, &ReadOptions::default()).map_err(|error| error.to_string())?;
    let manoeuvres = Manoeuvres { after_s, ..Manoeuvres::default() };
    let made = scenario_text(&file, &recording, &manoeuvres, &library());
    let (text, notes) = made.map_err(|error| error.to_string())?;
    let read = read_back(&text);
    let began_s = began(&recording.ego, recording.ego.start.time_s + after_s).time_s;
    let mut worst_m = 0.0_f64;
    for (index, name) in names(&recording, 0..recording.others.len()) {
        if read.parties.iter().any(|party| party.name.as_str() == name) {
            let obstacle = &recording.others[index];
            let by = moved(&recording);
            worst_m = worst_m.max(off_m(motion(&read, &name), obstacle, began_s, by));
        }
    }
    assert!(worst_m < WRITTEN_M, "{file}: {worst_m}");
    Ok(format!(
        "{file} at {after_s} s: {} parties, {} candidates, {} kB, off by {:.2} mm; {notes:?}",
        read.parties.len(),
        read.candidates.len(),
        text.len() / 1000,
        1e3 * worst_m
    ))
}

#[test]
#[ignore = "needs ../shared/data: recorded traffic"]
fn every_recording_is_a_scenario_over_a_horizon() {
    let recordings = files("scenarios/commonroad", "xml");
    assert!(recordings.len() >= 7);
    for path in recordings {
        for after_s in [0.0, 0.75] {
            eprintln!("{}", checked(&path, after_s).unwrap_or_else(|error| panic!("{error}")));
        }
    }
}
