//! How deep to cut, and whether to distribute at all, where a person leaves that to the program.
//!
//! ```text
//! coordinator::DryRuns: descents of each pair ──▶ simulate: what each depth would take ──▶ Plan
//! ```
//!
//! What is predicted is the work alone: processes are started before it. No answer depends on it.

use crate::args::EngineArgs;
use body::{BodyView, Meta};
use coordinator::{DEPTHS, DryCandidate, DryRuns, Request};
use trolley::Failure;
use runtime::{affinity, clock};
use scenario::{Depth, Engine, Overrides};
use serde::Serialize;
use simulate::{Costs, DryRun, Team, advise, leaf_pairs};
use std::path::Path;

/// The deepest that is chosen: the seed's best depth for its largest contact.
const DEEPEST: u32 = 12;

/// Largest file of costs (bytes).
const COSTS_BYTES_MAX: u64 = 1 << 16;

/// Most jobs of a batch that is sent in one piece.
const PIECE: i64 = 256;

/// Whether jobs are spread over the workers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Distribute {
    /// They always are.
    #[default]
    Always,
    /// Where that is predicted to be quicker than one piece on one worker.
    Auto,
}

/// What was chosen, and by which prediction.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Choice {
    /// Whether the depth was chosen; if not, it is the one that was asked for.
    pub(crate) depth_is_chosen: bool,
    pub(crate) depth: u32,
    /// Whether jobs are spread over the workers; if not, they go to one, uncut.
    pub(crate) distributed: bool,
    pub(crate) predicted_ms: f64,
    /// In one piece, on one worker.
    pub(crate) predicted_whole_ms: f64,
    /// Where the costs of each step come from.
    pub(crate) costs: String,
    /// Pairs of bodies that were run dry, and how long that and the choice took.
    pub(crate) pairs: usize,
    pub(crate) choosing_ms: f64,
}

/// The settings that the work is done with.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) engine: Engine,
    pub(crate) depth: u32,
    pub(crate) choice: Option<Choice>,
}

/// Chooses whatever is left to the program. `known` keeps dry runs from request to request.
pub(crate) fn plan(
    engine: Engine,
    options: &EngineArgs,
    request: &Request,
    bodies: &[(Meta, BodyView<'_>)],
    hashes: &[String],
    known: &mut DryRuns,
) -> Result<Plan, Failure> {
    let may_be_whole = options.distribute == Distribute::Auto;
    let asked = match engine.depth {
        Depth::At(depth) => Some(depth),
        Depth::Auto => None,
    };
    if let (Some(depth), false) = (asked, may_be_whole) {
        return match &options.costs {
            None => Ok(Plan { engine, depth, choice: None }),
            Some(path) => {
                let fault = format!("--costs {}: nothing is left to choose", path.display());
                let help = "give --depth auto or --distribute auto besides";
                Err(Failure::setting(fault).with_remedy(help))
            }
        };
    }
    if !options.transfer.is_plain() {
        let fault = "what is predicted is work on one store without limits";
        let help = "name a depth, or leave --transfer copy and --cache-bytes out";
        return Err(Failure::setting(fault).with_remedy(help));
    }
    let begun_ns = clock::now_ns();
    let costs = options.costs.as_deref().map_or(Ok(Costs::BUILT_IN), read)?;
    let queues = options.transfer.queues(&engine)?;
    let (workers, cores) = match options.in_process {
        true => (1, 1),
        false => (engine.workers, affinity::allowed_cores().len()),
    };
    let dry = dry_runs(&known.of(request, bodies, hashes), &costs);
    let depths = asked.map_or(0..=DEEPEST, |depth| depth..=depth);
    let advice = advise(&dry, &costs, &Team { workers, cores, queues }, depths)
        .ok_or_else(|| Failure::internal("no dry run"))?;
    let distributed = advice.distribute || !may_be_whole;
    let (engine, depth) =
        if distributed { (engine, advice.depth) } else { (in_one_piece(&engine)?, 0) };
    let choice = Choice {
        depth_is_chosen: asked.is_none(),
        depth,
        distributed,
        predicted_ms: if distributed { advice.predicted_ns } else { advice.whole_ns } / 1e6,
        predicted_whole_ms: advice.whole_ns / 1e6,
        costs: match &options.costs {
            None => "built in".to_owned(),
            Some(path) => path.display().to_string(),
        },
        pairs: known.len(),
        choosing_ms: (clock::now_ns() - begun_ns) as f64 / 1e6,
    };
    Ok(Plan { engine, depth, choice: Some(choice) })
}

/// All candidates at each depth of the dry runs. A probe is taken for a pose of the survey with no
/// more than one job's work: its first hit ends it.
fn dry_runs(candidates: &[DryCandidate<'_>], costs: &Costs) -> Vec<DryRun> {
    let at = |(number, depth): (usize, &u32)| {
        let none = DryRun { depth: *depth, ..DryRun::default() };
        candidates.iter().fold(none, |sum, candidate| {
            let pair = candidate.pair;
            let descent = &pair.descents[number];
            let pairs = leaf_pairs(&pair.descents, pair.levels);
            let pose = DryRun::of_descent(descent, pairs, costs);
            let probe = DryRun::of_descent(descent, 0.0, costs);
            sum.and(&pose.times(candidate.stops as f64)).and(&probe.times(candidate.probes as f64))
        })
    };
    DEPTHS.iter().enumerate().map(at).collect()
}

/// The same settings with one worker that is given all there is at once.
fn in_one_piece(engine: &Engine) -> Result<Engine, Failure> {
    let whole = Overrides {
        workers: Some(1),
        depth: Some(Depth::At(0).into()),
        batch: Some(PIECE),
        queue: Some(PIECE),
        ..Overrides::default()
    };
    engine.apply(&whole).map_err(|misfit| Failure::internal(misfit.what))
}

/// Costs that `trolley calibrate --out` wrote.
fn read(path: &Path) -> Result<Costs, Failure> {
    let wrong = |why: String| {
        let fault = format!("{}: {why}", path.display());
        Failure::input(fault).with_remedy("write it anew: trolley calibrate --out FILE")
    };
    let length = std::fs::metadata(path).map_err(|error| wrong(error.to_string()))?.len();
    if length > COSTS_BYTES_MAX {
        return Err(wrong(format!("{length} bytes are too many for costs")));
    }
    let text = std::fs::read_to_string(path).map_err(|error| wrong(error.to_string()))?;
    let costs: Costs = serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    if costs.are_sound() { Ok(costs) } else { Err(wrong("a cost is below 0".to_owned())) }
}
