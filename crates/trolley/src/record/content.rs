//! What a record holds, from a ranking.

use super::line;
use crate::engine::{Ranking, Recorded};
use crate::run::Run;
use crate::texts::SourceText;
use crate::{BUILD, Failure};
use record::{Edge, RecordContent, RecordedSpan, RecordedStage, RecordedText, Settings};

/// The record of a ranking.
///
/// # Errors
///
/// If it was made without [`Limits::with_record`](crate::Limits::with_record).
pub(super) fn of_ranking(ranking: &Ranking) -> Result<RecordContent, Failure> {
    let Ranking { run, recorded, answer, explanation } = ranking;
    let (Some(recorded), Some(explanation)) = (recorded, explanation) else {
        let what = "a ranking without job history and explanation cannot be recorded";
        return Err(Failure::setting(what).with_remedy("rank it with Limits::with_record"));
    };
    let (answer, explanation) = (line(answer)?, line(explanation)?);
    Ok(RecordContent { answer, explanation, ..content(run, recorded) })
}

/// A record without an answer.
fn content(run: &Run, recorded: &Recorded) -> RecordContent {
    let Recorded { texts, files, unknown_is_fixed, members, history, settings: engine, bodies } =
        recorded;
    let text = |text: &SourceText| RecordedText::new(&text.name, &text.text);
    let lost = run.workers.iter().filter_map(|worker| {
        worker.lost.as_ref().map(|how| format!("worker {} was lost: {how}", worker.worker))
    });
    RecordContent {
        build: BUILD.to_owned(),
        scenario: text(&texts.scenario),
        policy: text(&texts.policy),
        curves: text(&texts.curves),
        parameters: text(&texts.parameters),
        files: files.iter().map(text).collect(),
        settings: Settings {
            mode: run.mode,
            workers: engine.workers as u32,
            depth: run.depth,
            tree: engine.build,
            leaf_size: engine.leaf_size,
            scheme: engine.scheme,
            alpha: engine.alpha,
            batch: engine.batch as u32,
            queue: engine.queue as u32,
            seed: engine.seed,
            unknown_is_fixed: *unknown_is_fixed,
            members: members.count,
            members_max: members.most,
        },
        bodies: bodies.clone(),
        rounds: history.rounds.clone(),
        until: history.until,
        search: history.search,
        open_steps: history.open_steps.clone(),
        spans: spans(run),
        edges: edges(run),
        stages: stages(run),
        faults: lost.chain(run.remarks.iter().cloned()).collect(),
        answer: String::new(),
        explanation: String::new(),
    }
}

fn stages(run: &Run) -> Vec<RecordedStage> {
    let s = &run.stages;
    let all = [
        ("load", s.load_ms),
        ("plan", s.plan_ms),
        ("start", s.start_ms),
        ("work", s.work_ms),
        ("assess", s.assess_ms),
        ("worlds", s.worlds_ms),
        ("stop", s.stop_ms),
    ];
    all.into_iter().map(|(name, ms)| RecordedStage { name: name.to_owned(), ms }).collect()
}

/// When each job ran on its worker, counted from the start of the first.
fn spans(run: &Run) -> Vec<RecordedSpan> {
    let begun = |[end, wall]: &[u64; 2]| end.saturating_sub(*wall);
    let all = || run.workers.iter().flat_map(|w| w.spans.iter().map(move |span| (w.worker, span)));
    let first = all().map(|(_, span)| begun(span)).min().unwrap_or(0);
    let span = |(worker, span): (u8, &[u64; 2])| RecordedSpan {
        worker,
        from_ns: begun(span) - first,
        to_ns: span[0] - first,
    };
    all().map(span).collect()
}

/// The messages between coordinator and workers.
fn edges(run: &Run) -> Vec<Edge> {
    let both_ways = |worker: &coordinator::WorkerReport| {
        let name = format!("worker {}", worker.worker);
        let coordinator = || "coordinator".to_owned();
        let (messages, bytes) = (worker.batches, worker.batch_bytes);
        let out = Edge { from: coordinator(), to: name.clone(), messages, bytes };
        let (messages, bytes) = (worker.results, worker.result_bytes);
        [out, Edge { from: name, to: coordinator(), messages, bytes }]
    };
    run.workers.iter().flat_map(both_ways).collect()
}
