//! How late answers are: a histogram over many requests, some of adversarial cost.

use super::figures::{Class, classes, names, percentile};
use super::requests::{self, Extent, Pool};
use crate::progress::{Progress, SyncProgress};
use bvh::support::Extremes;
use coordinator::{
    Backend, BodySet, CourseRequest, InProcessExecutor, Options, RequestLimits, Until, WorkerPool,
    rank_courses,
};
use damage::AnswerState;
use dispatch::Queues;
use geometry::rng::Rng;
use runtime::{affinity, clock};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use trolley::{BUILD, Failure};

/// What to test.
#[derive(Clone, Debug)]
pub struct DeadlineOptions {
    /// Bodies, as model files or shape:triangles; the first is the ego. A second body like the
    /// first is placed inside it. Empty: seven generated ones.
    pub bodies: Vec<String>,
    /// Number of requests.
    pub requests: u32,
    /// Deadline of each request, from its acceptance (ms).
    pub deadline_ms: f64,
    /// Seed of the random requests.
    pub seed: u64,
    /// Number of worker processes.
    pub workers: u8,
    /// Number of threads that only consume CPU time.
    pub load: usize,
    /// Maximum number of tests per job.
    pub budget: u64,
    /// When work stops.
    pub until: Until,
    /// In how many members the candidates are followed, at first.
    pub members: u32,
    /// Ways of the ego; `None`: 6 to 16.
    pub candidates: Option<usize>,
    /// Parties besides the ego; `None`: up to twice as many as there are bodies.
    pub others: Option<usize>,
}

/// How late answers were.
#[derive(Clone, Debug, Serialize)]
pub struct DeadlineReport {
    schema: &'static str,
    bodies: Vec<String>,
    requests: usize,
    deadline_ms: f64,
    workers: u8,
    cores: usize,
    load: usize,
    until: &'static str,
    /// How many ways of the ego, and parties besides it, requests have.
    candidates: String,
    others: String,
    /// Answers by state: complete, certified, degraded, refused.
    states: [u64; 4],
    /// The same by how many members the answer is of; 1: of the scene as stated.
    by_members: BTreeMap<u32, [u64; 4]>,
    /// Answers by how late they were.
    late_ms: Vec<Class>,
    /// Against the deadline: median, 99 %, 99.9 %, all.
    late: [f64; 4],
    /// Search for contacts and surveys of these: medians.
    work_ms: [f64; 2],
    /// Time from the end of the work to the answer: median, 99 %, all.
    own_ms: [f64; 3],
}

/// Upper ends of the histogram's classes (ms).
const CLASSES_MS: [f64; 10] = [0.0, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 250.0];
/// Requests of one round: made once, sent repeatedly.
const ROUND: usize = 32;

/// Runs the requests. `told` is called with the requests done.
///
/// # Errors
///
/// If a body cannot be used, workers cannot be started, or a certain winner differs from the final
/// one.
pub fn deadline(
    options: &DeadlineOptions,
    told: SyncProgress<'_>,
) -> Result<DeadlineReport, Failure> {
    let pool = Pool::load(&options.bodies)?;
    let views = pool.bodies.views()?;
    let shells = pool.shells()?;
    let mut rng = Rng::new(options.seed);
    let mut asked = Vec::new();
    while asked.len() < ROUND.min(options.requests as usize) {
        let some = 6 + rng.below(11) as usize;
        let extent = Extent {
            candidates: options.candidates.unwrap_or(some),
            others: options.others,
            members: options.members,
            is_unavoidable: false,
        };
        asked.push(requests::scene(&views, extent, &mut rng)?);
    }
    if pool.names[0] == pool.names[1] {
        // Identical bodies that coincide in every triangle.
        asked[0] = requests::interpenetrating(&views)?;
    }
    // A service has them, too.
    let extremes: Vec<Extremes> = views.iter().map(|(_, view)| Extremes::of(view)).collect();
    let stage = BodySet { bodies: &views, extremes: Some(&extremes), depth: 5 };
    let asked: Vec<CourseRequest<'_>> = asked
        .iter()
        .enumerate()
        .map(|(number, scene)| Ok(scene.request(&shells, requests::criteria(number)?)))
        .collect::<Result<_, Failure>>()?;
    let winners: Result<Vec<Option<String>>, Failure> =
        asked.iter().map(|request| winner(request, &stage)).collect();
    let winners = winners?;
    let cores = affinity::in_turn(&affinity::allowed_cores(), options.workers.into());
    let worker_pool = Options {
        queues: Queues { capacity: 8, ..Options::QUEUES },
        ..Options::new(format!("d{}", std::process::id()), BUILD, cores)
    };
    let due = Duration::from_secs_f64(options.deadline_ms / 1e3);
    let DeadlineOptions { until, budget, .. } = *options;
    let limits = RequestLimits { until, budget, ..RequestLimits::due_in(due) };
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for _ in 0..options.load {
            scope.spawn(|| {
                while !over.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        let ran = ask(
            options,
            (&asked, &winners),
            &stage,
            limits,
            Backend::Workers(Box::new(WorkerPool::start(pool.bodies.store(), &worker_pool)?)),
            told,
        );
        over.store(true, Ordering::Relaxed);
        Ok(report(options, pool.names.clone(), ran?))
    })
}

/// The winner of the finished run; `None` where finding it would take too long.
fn winner(request: &CourseRequest<'_>, stage: &BodySet<'_>) -> Result<Option<String>, Failure> {
    let most_ns = 20_000_000_000;
    let limits = RequestLimits {
        deadline_ns: Some(most_ns),
        budget: RequestLimits::BUDGET,
        ..RequestLimits::default()
    };
    let mut backend = Backend::InProcess(Box::new(InProcessExecutor::with_room_for(stage.bodies)));
    let answer = rank_courses(stage, request, limits, &mut backend)?.answer;
    let first = answer.ranking.first().map(|row| row.name.clone());
    Ok(first.filter(|_| answer.state == AnswerState::Complete))
}

/// The outcomes of the requests.
#[derive(Default)]
struct Asked {
    /// How late each answer was (ms); below 0: in time.
    late: Vec<f64>,
    /// Time of the searches for contacts, and of the surveys of these (ms).
    searches: Vec<f64>,
    surveys: Vec<f64>,
    /// Time from the end of the work to the answer (ms).
    own: Vec<f64>,
    /// Number of answers in each state.
    states: [u64; 4],
    /// The same by how many members the answer is of.
    by_members: BTreeMap<u32, [u64; 4]>,
}

fn ask(
    options: &DeadlineOptions,
    (asked, winners): (&[CourseRequest<'_>], &[Option<String>]),
    stage: &BodySet<'_>,
    limits: RequestLimits,
    mut backend: Backend,
    told: SyncProgress<'_>,
) -> Result<Asked, Failure> {
    let bar = Progress::new(options.requests.into(), told);
    let mut all = Asked::default();
    for number in 0..options.requests as usize {
        let at = number % asked.len();
        let ranked = rank_courses(stage, &asked[at], limits, &mut backend)?;
        let answer = ranked.answer;
        let took_ms = (clock::now_ns() - ranked.effort.accepted_ns) as f64 / 1e6;
        all.searches.push(ranked.effort.search_ns as f64 / 1e6);
        all.surveys.push(ranked.effort.surveys_ns as f64 / 1e6);
        all.own.push(ranked.effort.judge_ns as f64 / 1e6);
        all.late.push(took_ms - options.deadline_ms);
        all.states[answer.state as usize] += 1;
        let members = answer.members.as_ref().map_or(1, |members| members.count);
        all.by_members.entry(members).or_default()[answer.state as usize] += 1;
        let is_sure = matches!(answer.state, AnswerState::Complete | AnswerState::Certified);
        let first = answer.ranking.first().map(|row| &row.name);
        if let (true, Some(winner), Some(first)) = (is_sure, &winners[at], first)
            && winner != first
        {
            return Err(Failure::internal(format!(
                "request {number}: {first} was certain, {winner} wins"
            )));
        }
        bar.add(1);
    }
    Ok(all)
}

fn report(options: &DeadlineOptions, bodies: Vec<String>, all: Asked) -> DeadlineReport {
    let Asked { mut late, searches, surveys, mut own, states, by_members } = all;
    let some = || format!("{} to {}", bodies.len() - 1, 2 * bodies.len() - 2);
    let others = options.others.map_or_else(some, |count| count.to_string());
    DeadlineReport {
        schema: "trolley.certify-deadline/1",
        bodies,
        requests: late.len(),
        deadline_ms: options.deadline_ms,
        workers: options.workers,
        cores: affinity::allowed_cores().len(),
        load: options.load,
        until: options.until.name(),
        candidates: options.candidates.map_or("6 to 16".into(), |count| count.to_string()),
        others,
        states,
        by_members,
        late_ms: classes(&late, &CLASSES_MS),
        late: [0.5, 0.99, 0.999, 1.0].map(|share| percentile(&mut late, share)),
        work_ms: [searches, surveys].map(|mut took_ms| percentile(&mut took_ms, 0.5)),
        own_ms: [0.5, 0.99, 1.0].map(|share| percentile(&mut own, share)),
    }
}

impl DeadlineReport {
    /// The report as text.
    #[must_use]
    pub fn text(&self) -> String {
        let [complete, certified, degraded, refused] = self.states;
        let mut text = format!(
            "{} requests of {} candidates and {} others of {} bodies ({}), each due after {} ms \
             (put together {} ms before), until {}, {} workers on {} cores, {} threads of load: \
             {complete} complete, {certified} certified, {degraded} degraded, {refused} \
             refused.\n\n| later than due by (ms) | answers |\n|--:|--:|\n",
            self.requests,
            self.candidates,
            self.others,
            self.bodies.len(),
            names(&self.bodies),
            self.deadline_ms,
            RequestLimits::GUARD.as_secs_f64() * 1e3,
            self.until,
            self.workers,
            self.cores,
            self.load,
        );
        let mut least = None;
        for Class { up_to, count } in &self.late_ms {
            let class = match (least, up_to) {
                (None, _) => "in time".to_owned(),
                (Some(least), None) => format!("more than {least}"),
                (_, Some(most)) => format!("up to {most}"),
            };
            // A String takes whatever it is given.
            let _written = writeln!(text, "| {class} | {count} |");
            least = up_to.or(least);
        }
        if self.by_members.keys().any(|members| *members > 1) {
            let _written = writeln!(
                text,
                "\n| members | complete | certified | degraded | refused |\n|--:|--:|--:|--:|--:|"
            );
            for (members, [complete, certified, degraded, refused]) in &self.by_members {
                let name = if *members == 1 { "as stated".into() } else { members.to_string() };
                let _written = writeln!(
                    text,
                    "| {name} | {complete} | {certified} | {degraded} | {refused} |"
                );
            }
        }
        let ([half, p99, p999, last], [own_half, own_p99, own_most]) = (self.late, self.own_ms);
        let [search, surveys] = self.work_ms;
        let _written = writeln!(
            text,
            "\nAgainst the deadline: median {half:.2} ms, 99 % by {p99:.2} ms, 99.9 % by \
             {p999:.2} ms, the last at {last:.2} ms. In the median the search for contacts took \
             {search:.2} ms, and their surveys {surveys:.2}. From the end of the work to the \
             answer: median {own_half:.2} ms, 99 % {own_p99:.2} ms, the most {own_most:.2} ms."
        );
        text
    }
}
