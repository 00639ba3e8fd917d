//! Which candidate wins a scenario under which policy and which curves, and where that flips as two
//! numbers are varied.
//!
//! Every cell of a map is a ranking of its own, of a scenario, a policy and curves in which two
//! numbers were set: nothing is interpolated. Bodies are built once.
//!
//! ```
//! use trolley::policy::map::{MapRequest, map};
//!
//! let policies = ["default", "vulnerable-first"]
//!     .map(|name| format!("../../config/policies/{name}.toml").into());
//! let request = MapRequest { policies: policies.to_vec(), ..MapRequest::default() };
//! let map = map("../../config/scenarios/small.toml".as_ref(), &request, trolley::bodies::SILENT)?;
//! for row in &map.rows {
//!     println!("{}, {}: {:?}", row.policy, row.curves, row.winner);
//! }
//! assert_eq!(map.rows.len(), 2);
//! # Ok::<(), trolley::Failure>(())
//! ```

use crate::bodies::OnProgress;
use crate::policy::{expiry, today};
use crate::texts;
use crate::{
    Answer, AnswerState, Engine, Failure, Limits, References, Scenario, SourceText, Until,
};
use damage::Note;
use serde::Serialize;
use std::path::{Path, PathBuf};

mod knob;
#[cfg(test)]
mod tests;

use knob::Varied;
pub use knob::{MapAxis, MapKnob};

/// Cells of a map at most, from side to side.
const CELLS_MAX: usize = 101;

/// What is mapped.
///
/// ```
/// use trolley::policy::map::{MapAxis, MapKnob, MapRequest};
///
/// let axes = [MapKnob::Speed, MapKnob::Odds].map(MapAxis::usual);
/// let request = MapRequest { grid: Some((axes, 11)), ..MapRequest::default() };
/// assert!(request.policies.is_empty(), "that of the scenario");
/// ```
#[derive(Clone, Debug, Default)]
pub struct MapRequest {
    /// Policies, or folders of them; none: that of the scenario.
    pub policies: Vec<PathBuf>,
    /// Sets of curves; none: those of the scenario.
    pub curves: Vec<PathBuf>,
    /// What is varied from left to right and from below, and the cells from side to side, 2 to
    /// 101; `None`: nothing.
    pub grid: Option<([MapAxis; 2], usize)>,
    /// Which files the scenario may name.
    pub references: References,
}

/// Who wins where.
///
/// ```
/// use trolley::policy::map::{MapRequest, map};
///
/// let file = "../../config/scenarios/small.toml".as_ref();
/// let map = map(file, &MapRequest::default(), trolley::bodies::SILENT)?;
/// assert_eq!((map.scenario.as_str(), map.candidates.len()), ("Small", 4));
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PolicyMap {
    /// The scenario's name.
    pub scenario: String,
    /// The candidates, in the order of the scenario.
    pub candidates: Vec<String>,
    /// What is varied from left to right and from below, if anything is.
    pub axes: Option<[MapAxis; 2]>,
    /// One row for each policy and set of curves.
    pub rows: Vec<MapRow>,
}

/// Who wins under one policy with one set of curves.
///
/// ```
/// # use trolley::policy::map::{MapRequest, map};
/// # let file = "../../config/scenarios/small.toml".as_ref();
/// # let map = map(file, &MapRequest::default(), trolley::bodies::SILENT)?;
/// let row = &map.rows[0];
/// assert_eq!((row.policy.as_str(), row.curves.as_str()), ("default", "default"));
/// assert!(row.fault.is_none() && row.cells.is_empty());
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MapRow {
    /// The policy's name.
    pub policy: String,
    /// The name of the set of curves.
    pub curves: String,
    /// The candidate that wins; `None`: nobody, or it is not known.
    pub winner: Option<String>,
    /// The candidate that comes last.
    pub last: Option<String>,
    /// Candidates that the model cannot tell from the first, without it.
    pub tied: Vec<String>,
    /// What else has to be known, in sentences.
    pub notes: Vec<String>,
    /// Why it could not be ranked.
    pub fault: Option<String>,
    /// The values of the two numbers as things are; `None`: this policy does not have both.
    pub given: Option<[f64; 2]>,
    /// Who wins in each cell: rows from below, each from left to right. Empty if nothing is varied,
    /// or this policy does not have both numbers.
    pub cells: Vec<Vec<MapCell>>,
}

/// Who wins in a cell.
///
/// ```
/// use trolley::policy::map::MapCell;
///
/// assert_ne!(MapCell::Winner(0), MapCell::Nobody);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MapCell {
    /// The candidate with this number in the scenario.
    Winner(usize),
    /// Nobody: the policy lets none be chosen.
    Nobody,
    /// It is not known: no body can move like that, or work remains open.
    Unknown,
}

/// Maps a scenario. `progress` is told of rankings done, of all.
///
/// ```
/// use trolley::policy::map::{MapAxis, MapKnob, MapRequest, map};
///
/// let axes = [MapKnob::Speed, MapKnob::OddsOutside].map(MapAxis::usual);
/// let request = MapRequest { grid: Some((axes, 3)), ..MapRequest::default() };
/// let map = map("../../config/scenarios/small.toml".as_ref(), &request, trolley::bodies::SILENT)?;
/// assert_eq!(map.rows[0].cells.concat().len(), 9);
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If a file cannot be read or is not valid, there are too few or too many cells, or no engine can
/// be built. That one policy does not go with one set of curves is no error, but
/// [`MapRow::fault`].
pub fn map(
    scenario: &Path,
    request: &MapRequest,
    progress: OnProgress<'_>,
) -> Result<PolicyMap, Failure> {
    if request.grid.is_some_and(|(_, count)| !(2..=CELLS_MAX).contains(&count)) {
        let fault = "a map has 2 to 101 cells from side to side";
        return Err(Failure::setting(fault).with_remedy("write --cells 21"));
    }
    let scenario = Scenario::open_with(scenario, request.references)?.without_deadline();
    let mut policies = Vec::new();
    for path in policy_files(&request.policies)? {
        policies.push(texts::POLICY.named_by_user(&path)?);
    }
    let mut curves = Vec::new();
    for path in &request.curves {
        curves.push(texts::CURVES.named_by_user(path)?);
    }
    let policies = if policies.is_empty() { vec![scenario.texts.policy.clone()] } else { policies };
    let curves = if curves.is_empty() { vec![scenario.texts.curves.clone()] } else { curves };
    let cells = request.grid.map_or(0, |(_, count)| count * count);
    let total = (policies.len() * curves.len() * (1 + cells)) as u64;
    let mut mapper =
        Mapper { engine: Engine::builder().in_process().build()?, progress, done: 0, total };
    let mut rows = Vec::new();
    for policy in &policies {
        for curves in &curves {
            rows.push(mapper.row(&scenario, policy, curves, request.grid)?);
        }
    }
    let candidates = scenario.parsed().candidates.iter();
    Ok(PolicyMap {
        scenario: scenario.parsed().name.clone(),
        candidates: candidates.map(|candidate| candidate.name.to_string()).collect(),
        axes: request.grid.map(|(axes, _)| axes),
        rows,
    })
}

/// The files that are named, and in folders those called *.toml, by name.
fn policy_files(named: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut all = Vec::new();
    for path in named {
        if !path.is_dir() {
            all.push(path.clone());
            continue;
        }
        let unread = |error: std::io::Error| {
            Failure::input(format!("{}: {error}", path.display()))
                .with_remedy("name policies, or folders that can be read")
        };
        let mut inside = Vec::new();
        for entry in std::fs::read_dir(path).map_err(unread)? {
            inside.push(entry.map_err(unread)?.path());
        }
        inside.retain(|file| file.extension().is_some_and(|end| end == "toml"));
        inside.sort();
        all.extend(inside);
    }
    Ok(all)
}

/// Ranks what a map is made of.
struct Mapper<'p> {
    engine: Engine,
    progress: OnProgress<'p>,
    done: u64,
    total: u64,
}

impl Mapper<'_> {
    fn ranked(&mut self, scenario: &Scenario, until: Until) -> Result<Answer, Failure> {
        let ranking = self.engine.rank(scenario, &Limits::default().until(until));
        self.done += 1;
        (self.progress)(self.done, self.total);
        Ok(ranking?.answer)
    }

    fn row(
        &mut self,
        scenario: &Scenario,
        policy: &SourceText,
        curves: &SourceText,
        grid: Option<([MapAxis; 2], usize)>,
    ) -> Result<MapRow, Failure> {
        // Each is valid alone, whether or not they go with each other.
        let policy = damage::Policy::parse(&policy.name, &policy.text)?;
        let curves = damage::Curves::parse(&curves.name, &curves.text)?;
        let mut row = MapRow {
            policy: policy.name.clone(),
            curves: curves.name.clone(),
            winner: None,
            last: None,
            tied: Vec::new(),
            notes: Vec::new(),
            fault: None,
            given: None,
            cells: Vec::new(),
        };
        let covered = curves.covers(policy.outcome).map_err(Failure::from);
        let judged = scenario.varied(scenario.parsed().clone(), policy, curves);
        let answer = match covered.and_then(|()| self.ranked(&judged, Until::Complete)) {
            Ok(answer) => answer,
            Err(failure) => {
                row.fault = Some(failure.to_string());
                return Ok(row);
            }
        };
        row.winner = answer.best().map(|best| best.name.clone());
        row.last = answer.ranking.last().map(|last| last.name.clone());
        let first = answer.ranking.first().map(|first| &first.name);
        row.tied = answer.tie_class.iter().filter(|name| Some(*name) != first).cloned().collect();
        row.notes.extend(answer.notes.iter().map(Note::sentence));
        row.notes.extend(expiry(&judged.criteria().policy, today()));
        row.notes.extend(answer.missing.iter().map(|missing| format!("not known: {missing}")));
        if let Some((axes, count)) = grid {
            let [x, y] = axes.map(|axis| axis.knob.given(&judged.criteria().policy));
            row.given = x.zip(y).map(|(x, y)| [x, y]);
            if row.given.is_some() {
                row.cells = self.cells(&judged, axes, count);
            } else {
                let names = axes.map(|axis| axis.knob.name()).join(" and ");
                row.notes.push(format!("this policy does not have {names} to vary"));
            }
        }
        Ok(row)
    }

    fn cells(
        &mut self,
        scenario: &Scenario,
        [x, y]: [MapAxis; 2],
        count: usize,
    ) -> Vec<Vec<MapCell>> {
        let mut rows = Vec::with_capacity(count);
        for up in y.values(count) {
            let cell = |right: f64| self.cell(scenario, [(x.knob, right), (y.knob, up)]);
            rows.push(x.values(count).into_iter().map(cell).collect());
        }
        rows
    }

    fn cell(&mut self, scenario: &Scenario, set: [(MapKnob, f64); 2]) -> MapCell {
        let damage::Criteria { policy, curves, .. } = scenario.criteria();
        let mut all = Varied {
            scenario: scenario.parsed().clone(),
            policy: damage::Policy::clone(policy),
            curves: damage::Curves::clone(curves),
        };
        if set.into_iter().any(|(knob, value)| knob.set(value, &mut all).is_none()) {
            self.done += 1;
            return MapCell::Unknown;
        }
        let varied = scenario.varied(all.scenario, all.policy, all.curves);
        let Ok(answer) = self.ranked(&varied, Until::Certified) else { return MapCell::Unknown };
        let candidates = &varied.parsed().candidates;
        match (answer.state, answer.best()) {
            (AnswerState::Degraded | AnswerState::Refused, _) => MapCell::Unknown,
            (_, None) => MapCell::Nobody,
            (_, Some(best)) => {
                let number = candidates.iter().position(|candidate| *candidate.name == best.name);
                number.map_or(MapCell::Unknown, MapCell::Winner)
            }
        }
    }
}
