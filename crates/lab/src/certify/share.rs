//! After what share of the work the winner, or the order, is certain.

use super::figures::{median, names, percentile};
use super::requests::{self, Extent, Pool};
use crate::progress::{Progress, SyncProgress};
use coordinator::{
    Backend, BodySet, CourseEffort, CourseOrder, CourseRequest, InProcessExecutor, RequestError,
    RequestLimits, RunError, Until, rank_courses_in,
};
use geometry::rng::Rng;
use runtime::clock;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;
use trolley::{AnswerState, Failure, files};

/// What to test.
#[derive(Clone, Debug)]
pub struct ShareOptions {
    /// Bodies, as model files or shape:triangles; the first is the ego. Empty: seven generated
    /// ones.
    pub bodies: Vec<String>,
    /// Number of scenes, of 6 to 16 candidates each.
    pub requests: u32,
    /// Seed of the random scenes.
    pub seed: u64,
    /// Only scenes in which every candidate meets somebody.
    pub unavoidable: bool,
    /// In how many members candidates are followed at first; 1: in the scene as stated alone.
    pub members: u32,
    /// Distribution depth.
    pub depth: u32,
    /// File to write the table to as well.
    pub out: Option<PathBuf>,
}

/// After what share of the work winners and orders were certain.
#[derive(Clone, Debug, Serialize)]
pub struct ShareReport {
    schema: &'static str,
    bodies: Vec<String>,
    requests: usize,
    unavoidable: bool,
    members: u32,
    depth: u32,
    /// Median tests and time of a complete run.
    whole_tests: f64,
    whole_ms: f64,
    rows: Vec<Row>,
}

/// What was asked for; shares are relative to a complete run.
#[derive(Clone, Debug, Serialize)]
struct Row {
    until: &'static str,
    median_share: f64,
    p90_share: f64,
    worst_share: f64,
    /// Scenes in which work ended before all of it was done.
    early: usize,
    /// Scenes in which it ended before any contact was surveyed.
    unsurveyed: usize,
    median_time: f64,
}

/// Random scenes to try for each that is wanted.
const TRIES: u64 = 1_000;

/// One scene, as far as was asked for.
#[derive(Clone)]
struct Ran {
    winner: Option<String>,
    order: Vec<String>,
    state: AnswerState,
    /// Candidates that are known to touch nobody.
    free: usize,
    tests: f64,
    effort: CourseEffort,
    ns: f64,
}

fn run(
    stage: &BodySet<'_>,
    request: &CourseRequest<'_>,
    (until, order): (Until, CourseOrder),
    backend: &mut Backend,
) -> Result<Ran, RunError> {
    let limits = RequestLimits { until, ..RequestLimits::default() };
    let begun_ns = clock::now_ns();
    let ranked = rank_courses_in(order, (stage, request), limits, backend)?;
    let ns = (clock::now_ns() - begun_ns) as f64;
    let (answer, effort) = (ranked.answer, ranked.effort);
    let surveys = effort.surveys.descent.tests() + effort.surveys.jobs.tests();
    Ok(Ran {
        winner: answer.best().map(|row| row.name.clone()),
        order: answer.ranking.iter().map(|row| row.name.clone()).collect(),
        state: answer.state,
        free: answer.ranking.iter().filter(|row| row.touches_nobody()).count(),
        tests: (effort.search.nb + effort.search.np + surveys) as f64,
        effort,
        ns,
    })
}

/// Ranks scenes to their end, until the order is certain, and until the winner is. `told` is called
/// with the scenes done.
///
/// # Errors
///
/// If a body cannot be used, the file cannot be written, or what was certain is not so in the end.
pub fn share(options: &ShareOptions, told: SyncProgress<'_>) -> Result<ShareReport, Failure> {
    // Fail before the work, not after it, if the file cannot be written.
    options.out.as_deref().map(|path| files::check(path, None)).transpose()?;
    let pool = Pool::load(&options.bodies)?;
    let (views, shells) = (pool.bodies.views()?, pool.shells()?);
    let stage = BodySet { bodies: &views, extremes: None, depth: options.depth };
    let mut backend = Backend::InProcess(Box::new(InProcessExecutor::with_room_for(&views)));
    let bar = Progress::new(u64::from(options.requests), told);
    let mut rng = Rng::new(options.seed);
    let mut asked = vec![
        ("ordered", Until::Ordered, CourseOrder::Race),
        ("certified", Until::Certified, CourseOrder::Race),
    ];
    if options.members > 1 {
        asked.push((
            "certified, candidate by candidate",
            Until::Certified,
            CourseOrder::Sequential,
        ));
        asked.push(("certified, member by member", Until::Certified, CourseOrder::RoundRobin));
    }
    let (mut wholes, mut rans) = (Vec::new(), vec![Vec::new(); asked.len()]);
    let mut tried = 0;
    while wholes.len() < options.requests as usize {
        tried += 1;
        if tried > TRIES * u64::from(options.requests) {
            let what = "hardly any random scene among these bodies can be ranked";
            return Err(Failure::input(what).with_remedy("name other bodies: --body"));
        }
        let candidates = 6 + rng.below(11) as usize;
        let scene = requests::scene(
            &views,
            Extent {
                candidates,
                others: None,
                members: options.members,
                is_unavoidable: options.unavoidable,
            },
            &mut rng,
        )?;
        let number = wholes.len();
        let request = scene.request(&shells, requests::criteria(number)?);
        let whole = match run(&stage, &request, (Until::Complete, CourseOrder::Race), &mut backend)
        {
            // Bodies stand so close that nearly all draws overlap.
            Err(RunError::Request(RequestError::Overlap { .. })) => continue,
            whole => whole?,
        };
        // What cannot be evaluated has no complete answer, so none can be early.
        if whole.state != AnswerState::Complete || options.unavoidable && whole.free > 0 {
            continue;
        }
        for (&(name, until, order), rans) in asked.iter().zip(&mut rans) {
            let early = run(&stage, &request, (until, order), &mut backend)?;
            let is_same = match until {
                Until::Ordered => early.order == whole.order,
                Until::Certified | Until::Complete => early.winner == whole.winner,
            };
            if !is_same || early.state == AnswerState::Degraded {
                let what = format!(
                    "scene {number}: {name} gives {:?}, in the end it is {:?}",
                    early.order, whole.order
                );
                return Err(Failure::internal(what));
            }
            rans.push(early);
        }
        wholes.push(whole);
        bar.add(1);
    }
    let rows = asked.iter().zip(&rans).map(|(&(name, ..), rans)| row(name, rans, &wholes));
    let rows: Vec<Row> = rows.collect();
    let mut tests: Vec<f64> = wholes.iter().map(|whole| whole.tests).collect();
    let mut ms: Vec<f64> = wholes.iter().map(|whole| whole.ns / 1e6).collect();
    let report = ShareReport {
        schema: "trolley.certify-share/3",
        bodies: pool.names,
        requests: wholes.len(),
        unavoidable: options.unavoidable,
        members: options.members,
        depth: options.depth,
        whole_tests: median(&mut tests),
        whole_ms: median(&mut ms),
        rows,
    };
    if let Some(path) = &options.out {
        files::replace(path, report.text().as_bytes())?;
    }
    Ok(report)
}

fn row(until: &'static str, rans: &[Ran], wholes: &[Ran]) -> Row {
    let ratio = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 1.0 };
    let pairs = || rans.iter().zip(wholes);
    let mut shares: Vec<f64> = pairs().map(|(ran, whole)| ratio(ran.tests, whole.tests)).collect();
    let mut times: Vec<f64> = pairs().map(|(ran, whole)| ratio(ran.ns, whole.ns)).collect();
    Row {
        until,
        median_share: median(&mut shares),
        p90_share: percentile(&mut shares, 0.9),
        worst_share: percentile(&mut shares, 1.0),
        early: rans.iter().filter(|ran| ran.effort.spared > 0).count(),
        unsurveyed: pairs()
            .filter(|(ran, whole)| ran.effort.rounds == 0 && whole.effort.rounds > 0)
            .count(),
        median_time: median(&mut times),
    }
}

impl ShareReport {
    /// The report as text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::from(
            "| until | median share | p90 | worst | ended early | before any survey | median time \
             |\n|---|--:|--:|--:|--:|--:|--:|\n",
        );
        for row in &self.rows {
            // A String takes whatever it is given.
            let _written = writeln!(
                text,
                "| {} | {:.1} % | {:.1} % | {:.1} % | {} of {} | {} | {:.1} % |",
                row.until,
                100.0 * row.median_share,
                100.0 * row.p90_share,
                100.0 * row.worst_share,
                row.early,
                self.requests,
                row.unsurveyed,
                100.0 * row.median_time,
            );
        }
        let _written = writeln!(
            text,
            "\n{} scenes of 6 to 16 candidates{}{} among {} bodies ({}), policies in turn, depth \
             {}. Working all of it out takes {:.2} million tests and {:.1} ms in the median.",
            self.requests,
            if self.unavoidable { ", all of which meet somebody," } else { "" },
            match self.members {
                1 => String::new(),
                count => format!(" in {count} members and more where that is too close to call,"),
            },
            self.bodies.len(),
            names(&self.bodies),
            self.depth,
            self.whole_tests / 1e6,
            self.whole_ms,
        );
        text
    }
}
