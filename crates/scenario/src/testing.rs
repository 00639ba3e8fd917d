//! A scenario with every key there is, one to a line, for the tests of all modules.

use crate::{Scenario, ScenarioError};

/// Every key of the form stands here on a line of its own, and the whole is a valid scenario.
pub(crate) const FULL: &str = r#"schema = "trolley.scenario/1"
name = "Every key"
policy = "policies/board.toml"
curves = "curves/level3.toml"
deadline_ms = 50
ego = "car"

[engine]
workers = 2
cores = [0, 1]
coordinator_core = 3
depth = 6
scheme = "best-match-load"
alpha = 0.25
batch = 8
queue = 32
build = "sah"
leaf_size = 2
seed = 7

[parties.car]
mass_kg = 1500
responsibility = 0.5
[parties.car.generate]
shape = "sedan"
triangles = 2000
seed = 4
[[parties.car.persons]]
seat = "front-left"
[[parties.car.persons]]
seat = "rear-right"

[parties.walker]
file = "bodies/walker.trolley"
kind = "unknown"
[parties.walker.crush]
a_n_m = 40000
b_n_m2 = 500000.5

[parties.post.generate]
shape = "pole"
triangles = 500

[[candidates]]
name = "walker"
probability = 0.75
[candidates.ego]
position_m = [1, 2.5, 0]
yaw_deg = 90
pitch_deg = -1.5
roll_deg = 0.5
speed_m_s = 12
[candidates.other]
party = "walker"
position_m = [1, 5, 0]
yaw_deg = 180
pitch_deg = 1
roll_deg = 2
velocity_m_s = [-1.5, 0.25]

[[candidates]]
name = "post"
[candidates.ego]
position_m = [0, 0, 0]
velocity_m_s = [3, 4]
[candidates.other]
party = "post"
position_m = [2.4, 0, 0]
speed_m_s = 0

[parties.post]
size_m = [0.3, 0.25]
"#;

/// Reads a text that is called `f.toml`.
pub(crate) fn parse(text: &str) -> Result<Scenario, ScenarioError> {
    Scenario::parse("f.toml", text)
}

/// The lines of the full scenario that set a key: number from 1, section header, key, value.
pub(crate) fn settings() -> Vec<(usize, &'static str, &'static str, &'static str)> {
    let mut section = "";
    let mut found = Vec::new();
    for (index, line) in FULL.lines().enumerate() {
        if line.starts_with('[') {
            section = line;
        } else if let Some((key, value)) = line.split_once(" = ") {
            found.push((index + 1, section, key, value));
        }
    }
    found
}

/// The full scenario with one line replaced.
pub(crate) fn with_line(number: usize, line: &str) -> String {
    let lines: Vec<&str> =
        FULL.lines().enumerate().map(|(i, old)| if i + 1 == number { line } else { old }).collect();
    lines.join("\n")
}

/// What a person is told of an error.
pub(crate) fn told(error: impl diagnostic::Diagnostic) -> String {
    diagnostic::Failure::from(error).to_string()
}
