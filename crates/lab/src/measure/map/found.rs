//! What a map found: its document.

use super::advice::Advice;
use super::cells::{Cell, Sheets};
use super::grid::Grid;
use super::machine::Machine;
use super::real::Checked;
use serde::Serialize;
use simulate::Costs;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// What a claim came to on one machine.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Finding {
    pub(crate) claim: char,
    pub(crate) machine: Machine,
    /// Whether each contact is a request of its own, as in the paper.
    pub(crate) is_single: bool,
    pub(crate) verdict: &'static str,
    pub(crate) cells: usize,
    pub(crate) holds: usize,
    pub(crate) fails: usize,
    pub(crate) open: usize,
    /// Where it holds, and where it does not, in words.
    pub(crate) regions: Vec<String>,
}

impl Finding {
    /// The machine, and whether each contact is a request.
    pub(crate) fn title(&self) -> String {
        group_title((self.machine, self.is_single))
    }
}

pub(crate) fn group_title((machine, is_single): (Machine, bool)) -> String {
    match (machine, is_single) {
        (Machine::Paper, true) => format!("{}, a contact a request", machine.title()),
        (Machine::Paper, false) => format!("{}, sixteen a request", machine.title()),
        _ => machine.title().to_owned(),
    }
}

/// How verdicts on the paper's machine change with its costs.
pub(crate) struct Variant {
    pub(crate) words: &'static str,
    pub(crate) cells: Vec<Cell>,
}

/// The map, as a document and as text.
#[derive(Serialize)]
pub struct Map {
    pub(crate) schema: &'static str,
    pub(crate) machine: String,
    pub(crate) command: String,
    pub(crate) findings: Vec<Finding>,
    pub(crate) advice: Vec<String>,
    pub(crate) checked: Vec<Checked>,
    pub(crate) costs: BTreeMap<String, Costs>,
    /// The plain walk on this machine (ns): job, box, triangle, hit.
    pub(crate) plain_costs: [f64; 4],
    #[serde(skip)]
    pub(crate) advised: Vec<Advice>,
    #[serde(skip)]
    pub(crate) variants: Vec<Variant>,
    #[serde(skip)]
    pub(crate) cells: Vec<Cell>,
    #[serde(skip)]
    pub(crate) sheets: Sheets,
    #[serde(skip)]
    pub(crate) grid: Grid,
    #[serde(skip)]
    pub(crate) out: PathBuf,
}
