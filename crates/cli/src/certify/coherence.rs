//! What it saves to begin a descent where the last one ended: along crush paths, from request to
//! request, and along a trajectory.

use super::requests::{self, Pool};
use super::wrong;
use crate::args::Output;
use crate::failure::{Code, Failure};
use crate::progress::Progress;
use body::{BodyView, Meta};
use bvh::{Counters, Cut, NodePair, front};
use coordinator::{Chance, Cuts, Request, Terms, Work, run_in_process};
use geometry::{Pose, RelativePose};
use runtime::clock;
use std::fmt::Write as _;
use std::path::PathBuf;

/// What is asked.
#[derive(Debug, clap::Args)]
pub(crate) struct CoherenceArgs {
    /// Bodies, as files or shape:triangles; the first is the ego [default: seven generated ones].
    #[arg(long, value_name = "BODY")]
    body: Vec<String>,
    /// Requests of chance.
    #[arg(long, value_name = "N", default_value_t = 24)]
    requests: u32,
    /// Which requests.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Distribution depths.
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "5,8,12")]
    depth: Vec<u32>,
    /// Poses of the second body in the ego's frame, a line each: x and y (m), yaw (degrees).
    #[arg(long, value_name = "FILE")]
    trajectory: Option<PathBuf>,
}

/// Tests and times of descents, from the roots and from the last cut.
#[derive(Clone, Copy, Debug, Default)]
struct Saved {
    cold: (Counters, u64),
    warm: (Counters, u64),
    jobs: Counters,
}

/// How often times are measured: the least counts.
const REPEATS: usize = 5;

pub(crate) fn run(args: &CoherenceArgs, output: &Output) -> Result<String, Failure> {
    let pool = Pool::load(&args.body)?;
    let views = pool.views()?;
    let bar = Progress::new("requests", u64::from(args.requests) * args.depth.len() as u64, output);
    let mut text = String::from(
        "| way | depth | tests from the roots | from the last cut | saved | time saved | of all \
         tests |\n|---|--:|--:|--:|--:|--:|--:|\n",
    );
    for &depth in &args.depth {
        let mut chance = Chance::new(args.seed);
        let (mut paths, mut again) = (Saved::default(), Saved::default());
        for number in 0..args.requests {
            let candidates = 6 + chance.below(11) as usize;
            let policy = requests::policy(number as usize)?;
            let way = (candidates, 1.1);
            bar.add(1);
            let Some(request) = requests::request(&views, way, &mut chance, policy)? else {
                continue;
            };
            along_paths(&request, &views, depth, (&mut paths, &mut again))?;
        }
        say(&mut text, "crush paths", depth, &paths);
        say(&mut text, "the same request again", depth, &again);
        if let Some(path) = &args.trajectory {
            let poses = trajectory(path)?;
            let saved = along(&poses, &views, depth)?;
            say(&mut text, &format!("trajectory of {} poses", poses.len()), depth, &saved);
        }
    }
    let _written = writeln!(
        text,
        "\n{} requests of 6 to 16 candidates between {} bodies ({}). Answers from cuts are those \
         from the roots, bit for bit.",
        args.requests,
        pool.names.len(),
        super::names(&pool.names),
    );
    Ok(text)
}

fn say(text: &mut String, way: &str, depth: u32, saved: &Saved) {
    let (cold, warm) = (saved.cold.0.tests() as f64, saved.warm.0.tests() as f64);
    let all = cold + saved.jobs.tests() as f64;
    let share =
        |part: f64, whole: f64| if whole > 0.0 { 100.0 * (1.0 - part / whole) } else { 0.0 };
    let _written = writeln!(
        text,
        "| {way} | {depth} | {cold} | {warm} | {:.0} % | {:.0} % | {:.1} % |",
        share(warm, cold),
        share(saved.warm.1 as f64, saved.cold.1 as f64),
        100.0 * (cold - warm) / all.max(1.0),
    );
}

/// A request from the roots, from its own last cuts, and again from those of the run before.
fn along_paths(
    request: &Request,
    views: &[(Meta, BodyView<'_>)],
    depth: u32,
    (paths, again): (&mut Saved, &mut Saved),
) -> Result<(), Failure> {
    let cold = Terms { is_cold: true, ..Terms::default() };
    let ran = |terms: Terms, cuts: Cuts| {
        let mut work = Work::new(request, views, depth).with_terms(terms).with_cuts(cuts);
        run_in_process(&mut work, views);
        Ok::<_, Failure>((work.answer()?, work.effort(), work.poses(), work.into_cuts()))
    };
    let (answer, effort, poses, _) = ran(cold, Cuts::default())?;
    let (warm_answer, warm_effort, _, cuts) = ran(Terms::default(), Cuts::default())?;
    let (again_answer, again_effort, _, _) = ran(Terms::default(), cuts)?;
    if answer != warm_answer || answer != again_answer {
        return Err(wrong("an answer from a cut is not that from the roots".to_owned()));
    }
    for (saved, warm) in [(&mut *paths, warm_effort), (&mut *again, again_effort)] {
        saved.cold.0.add(&effort.descent);
        saved.warm.0.add(&warm.descent);
        saved.jobs.add(&effort.jobs);
    }
    // Times: the same descents, alone.
    let mut times = [[u64::MAX; REPEATS]; 3];
    for round in 0..REPEATS {
        let mut kept: Vec<Cut> = vec![Cut::new(); poses.len()];
        for (way, time) in times.iter_mut().enumerate() {
            let begun_ns = clock::thread_cpu_ns();
            for (number, (models, of_case)) in poses.iter().enumerate() {
                let [a, b] = models.map(|model| &views[model as usize].1);
                for pose in of_case {
                    descend(way == 0, &mut kept[number], (a, b), pose, depth);
                }
            }
            time[round] = clock::thread_cpu_ns() - begun_ns;
        }
    }
    let [cold_ns, warm_ns, again_ns] = times.map(|of| of.into_iter().min().unwrap_or(0));
    paths.cold.1 += cold_ns;
    paths.warm.1 += warm_ns;
    again.cold.1 += cold_ns;
    again.warm.1 += again_ns;
    Ok(())
}

fn descend(
    is_cold: bool,
    cut: &mut Cut,
    bodies: (&BodyView<'_>, &BodyView<'_>),
    pose: &RelativePose,
    depth: u32,
) -> (Vec<NodePair>, Counters) {
    let (mut pairs, mut counters) = (Vec::new(), Counters::default());
    if is_cold {
        front(bodies.0, bodies.1, pose, depth, &mut pairs, &mut counters);
    } else {
        cut.front(bodies, pose, depth, &mut pairs, &mut counters);
    }
    (pairs, counters)
}

fn trajectory(path: &std::path::Path) -> Result<Vec<RelativePose>, Failure> {
    let text = crate::inputs::text(path)?;
    let pose = |(number, line): (usize, &str)| {
        let numbers: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        match numbers.as_deref() {
            Ok([x, y, yaw]) if [x, y, yaw].iter().all(|v| v.abs() < 1e6) => {
                let placed = Pose::from_degrees(yaw % 360.0, 0.0, 0.0, [*x, *y, 0.0]);
                Ok(RelativePose::between(&Pose::IDENTITY, &placed))
            }
            _ => {
                let fault = format!("{}:{}: not three numbers", path.display(), number + 1);
                Err(Failure::new(Code::Input, fault).help("x y yaw: metres and degrees"))
            }
        }
    };
    text.lines().enumerate().map(pose).collect()
}

/// The second body along a trajectory beside the first.
fn along(
    poses: &[RelativePose],
    views: &[(Meta, BodyView<'_>)],
    depth: u32,
) -> Result<Saved, Failure> {
    let bodies = (&views[0].1, &views[1].1);
    let mut saved = Saved { cold: (Counters::default(), u64::MAX), ..Saved::default() };
    saved.warm.1 = u64::MAX;
    for _ in 0..REPEATS {
        let mut found = [Vec::new(), Vec::new()];
        for (way, found) in found.iter_mut().enumerate() {
            let (mut cut, mut all) = (Cut::new(), Counters::default());
            let begun_ns = clock::thread_cpu_ns();
            for pose in poses {
                let (pairs, counters) = descend(way == 0, &mut cut, bodies, pose, depth);
                all.add(&counters);
                found.push(pairs);
            }
            let took_ns = clock::thread_cpu_ns() - begun_ns;
            let of = if way == 0 { &mut saved.cold } else { &mut saved.warm };
            *of = (all, of.1.min(took_ns));
        }
        if found[0] != found[1] {
            return Err(wrong("a cut found other pairs than the roots".to_owned()));
        }
    }
    Ok(saved)
}
