//! The states of one path in a file of their own: comma-separated values under a header.
//!
//! ```text
//! # recorded by the planner
//! t_s, x_m, y_m, yaw_deg, vx_m_s, vy_m_s
//! 0.0, 12.0, 3.5, 180, -8, 0
//! ```
//!
//! Columns stand in any order. Lines that are blank or begin with # are skipped.

use super::GivenState;
use super::path::RowFault;
use crate::document::TextPosition;
use crate::error::{Misfit, ScenarioError};
use crate::limit::{self, Limit};
use crate::names::{choices, quoted};

/// A column: its name and its range.
type Column = (&'static str, Limit<f64>);

/// All columns, those that must be there first.
const COLUMNS: [Column; 9] = [
    ("t_s", limit::PATH_TIME_S),
    ("x_m", limit::POSITION_M),
    ("y_m", limit::POSITION_M),
    ("yaw_deg", limit::YAW_DEG),
    ("z_m", limit::POSITION_M),
    ("pitch_deg", limit::PITCH_DEG),
    ("roll_deg", limit::ROLL_DEG),
    ("vx_m_s", limit::PATH_SPEED_M_S),
    ("vy_m_s", limit::PATH_SPEED_M_S),
];

/// How many columns must be there.
const NEEDED: usize = 4;

/// Numbers of the two columns of a velocity.
const VELOCITY: [usize; 2] = [7, 8];

/// A file that was read.
pub(super) struct CsvStates<'t> {
    file: &'t str,
    /// The number in [`COLUMNS`] of each column.
    header: Vec<usize>,
    /// The lines of the states: number from 1, text.
    lines: Vec<(usize, &'t str)>,
    pub(super) rows: Vec<GivenState>,
}

impl<'t> CsvStates<'t> {
    /// Reads a file; `file` is its name in errors.
    ///
    /// # Errors
    ///
    /// The first value that is missing, no number or out of range, at its line.
    pub(super) fn parse(file: &'t str, text: &'t str) -> Result<Self, ScenarioError> {
        if text.len() > limit::CSV_BYTES_MAX {
            let fault = format!("{} bytes are too many for a path", text.len());
            let help = format!(
                "a path has at most {} states in {} bytes; is this the right file?",
                limit::CSV_ROWS.most,
                limit::CSV_BYTES_MAX
            );
            return Err(ScenarioError::new(file, TextPosition::START, fault, help));
        }
        // Spreadsheets put a mark before the first letter.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut lines = (text.lines().enumerate())
            .map(|(index, line)| (index + 1, line))
            .filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'));
        let Some((number, first)) = lines.next() else {
            let help = "the first line names the columns: t_s,x_m,y_m,yaw_deg";
            return Err(ScenarioError::new(file, TextPosition::START, "the file is empty", help));
        };
        let header = header(first).map_err(|(cell, misfit)| {
            ScenarioError::new(file, place(number, first, cell), misfit.what, misfit.remedy)
        })?;
        let mut states = Self { file, header, lines: Vec::new(), rows: Vec::new() };
        for (number, line) in lines {
            let row = states.row(line).map_err(|(cell, misfit)| {
                ScenarioError::new(file, place(number, line, cell), misfit.what, misfit.remedy)
            })?;
            states.rows.push(row);
            states.lines.push((number, line));
        }
        Ok(states)
    }

    /// One line of values; what is wrong, with the number of its cell.
    fn row(&self, line: &str) -> Result<GivenState, (usize, Misfit)> {
        if self.rows.len() == limit::CSV_ROWS.most {
            let fault = format!("there are more than {} states", limit::CSV_ROWS.most);
            return Err((0, Misfit::new("csv", fault, "leave some out: it is linear between two")));
        }
        let cells = line.split(',').count();
        if cells != self.header.len() {
            let fault = format!("{cells} values stand under {} columns", self.header.len());
            let help = "write a value for each column, with commas between them";
            return Err((cells.min(self.header.len()) - 1, Misfit::new("csv", fault, help)));
        }
        let mut values = [None; COLUMNS.len()];
        for (cell, (column, written)) in self.header.iter().zip(line.split(',')).enumerate() {
            let (name, limit) = COLUMNS[*column];
            let Ok(value) = written.trim().parse::<f64>() else {
                let fault = format!("{name} is {}, not a number", quoted(written.trim()));
                let help = format!("{name} may be {}", limit.range());
                return Err((cell, Misfit::new(name, fault, help)));
            };
            // Adding +0.0 turns −0.0 into +0.0.
            values[*column] = Some(limit.check(name, value).map_err(|m| (cell, m))? + 0.0);
        }
        let [t_s, x_m, y_m, yaw_deg, z_m, pitch_deg, roll_deg, vx_m_s, vy_m_s] =
            values.map(|value| value.unwrap_or(0.0));
        if let Err(misfit) = limit::PATH_SPEED_M_S
            .check("vx_m_s and vy_m_s", (vx_m_s * vx_m_s + vy_m_s * vy_m_s).sqrt())
        {
            return Err((self.cell("velocity_m_s"), misfit));
        }
        Ok(GivenState {
            time_s: t_s,
            position_m: [x_m, y_m, z_m],
            angles_deg: [yaw_deg, pitch_deg, roll_deg],
            velocity_m_s: values[VELOCITY[0]].is_some().then_some([vx_m_s, vy_m_s]),
        })
    }

    /// The number of the cell where what the states of a scenario call `setting` begins.
    fn cell(&self, setting: &str) -> usize {
        let column = match setting {
            "position_m" => "x_m",
            "velocity_m_s" => "vx_m_s",
            other => other,
        };
        self.header.iter().position(|known| COLUMNS[*known].0 == column).unwrap_or(0)
    }

    /// What is wrong with these states, at its line.
    pub(super) fn error(&self, RowFault { row, misfit }: RowFault) -> ScenarioError {
        let line = row.and_then(|row| self.lines.get(row));
        let place = line.map_or(TextPosition::START, |(number, line)| {
            place(*number, line, self.cell(misfit.setting))
        });
        ScenarioError::new(self.file, place, misfit.what, misfit.remedy)
    }
}

/// The columns that a line names; what is wrong, with the number of its cell.
fn header(line: &str) -> Result<Vec<usize>, (usize, Misfit)> {
    let names = COLUMNS.map(|(name, _)| name);
    let known = format!("columns: {}", names.join(", "));
    let mut header: Vec<usize> = Vec::new();
    for (cell, name) in line.split(',').map(str::trim).enumerate() {
        let Some(column) = names.iter().position(|known| *known == name) else {
            let fault = format!("column {} is not known", quoted(name));
            return Err((cell, Misfit::new("csv", fault, choices(&known, &names, name))));
        };
        if header.contains(&column) {
            let fault = format!("column {name} stands twice");
            return Err((cell, Misfit::new("csv", fault, "leave one of them out")));
        }
        header.push(column);
    }
    let mut needed = 0..NEEDED;
    let lacks_half = VELOCITY.iter().any(|column| header.contains(column));
    let mut halves = VELOCITY.into_iter().filter(|_| lacks_half);
    let missing = |column: &usize| !header.contains(column);
    if let Some(column) = needed.find(&missing).or_else(|| halves.find(&missing)) {
        let fault = format!("column {} is missing", names[column]);
        return Err((0, Misfit::new("csv", fault, known)));
    }
    Ok(header)
}

/// Where a cell begins.
fn place(number: usize, line: &str, cell: usize) -> TextPosition {
    let before = line.split(',').take(cell).map(|cell| cell.chars().count() + 1).sum::<usize>();
    let blanks = line
        .split(',')
        .nth(cell)
        .map_or(0, |cell| cell.chars().take_while(|letter| letter.is_whitespace()).count());
    TextPosition { line: number, column: before + blanks + 1 }
}

#[cfg(test)]
mod tests;
