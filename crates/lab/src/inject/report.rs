//! The report of a campaign: each kind of fault, how it was detected, and its outcome.

use super::kind::Kind;
use coordinator::Answer;
use protocol::Incarnation;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// Maximum delay of an answer after its deadline (ns): without real-time priority the coordinator
/// waits for a core like any process.
pub(super) const GUARD_NS: u64 = 250_000_000;

/// Maximum number of events that the report tells one by one.
const TOLD: usize = 20;

/// The outcome of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum State {
    /// Complete, and the same bytes as without faults.
    Complete,
    /// Incomplete, but the intervals hold the true values, and certified statements are true.
    Degraded,
    /// A reported error, or no answer.
    Refused,
    /// None of these.
    Wrong,
}

/// Compares an answer with that of a run without faults.
pub(super) fn judge(answer: &Answer, reference: &Answer) -> State {
    if answer == reference {
        return State::Complete;
    }
    if answer.state == damage::AnswerState::Complete {
        return State::Wrong;
    }
    let winners = [answer, reference].map(|answer| answer.ranking.first().map(|row| &row.name));
    if answer.state == damage::AnswerState::Certified && winners[0] != winners[1] {
        return State::Wrong;
    }
    let holds = answer.ranking.iter().all(|row| {
        let known = reference.ranking.iter().find(|known| known.name == row.name);
        let ([lo, hi], known) = (row.work.into(), known.map(|known| <[f64; 2]>::from(known.work)));
        known.is_some_and(|[least, most]| lo <= least && most <= hi)
    });
    match (holds && answer.ranking.len() == reference.ranking.len(), answer.state) {
        (true, damage::AnswerState::Refused) => State::Refused,
        (true, _) => State::Degraded,
        (false, _) => State::Wrong,
    }
}

/// Results for one kind of fault.
#[derive(Clone, Debug, Default)]
struct Entry {
    detect_ns: Vec<u64>,
    recover_ns: Vec<u64>,
    answers: [u64; 4],
}

/// All results.
#[derive(Clone, Debug, Default)]
pub(super) struct Report {
    seed: u64,
    entries: BTreeMap<Kind, Entry>,
    skipped: BTreeMap<Kind, (u64, &'static str)>,
    answers: [u64; 4],
    ended: BTreeSet<(u8, u32)>,
    pub(super) requests: u64,
    pub(super) restarts: u64,
    pub(super) reissued: u64,
    pub(super) fenced: u64,
    pub(super) rejected: u64,
    pub(super) slowest_ns: u64,
    pub(super) hangs: u64,
    /// The deadline of answers.
    pub(super) deadline_ms: Option<u32>,
    /// Answers after the deadline.
    pub(super) late: u64,
    false_kills: u64,
    unseen: u64,
    /// The first of both, one by one.
    told: Vec<String>,
    pub(super) missed: u64,
    pub(super) orphans: u64,
    pub(super) left_behind: u64,
    pub(super) files_grown: i64,
    pub(super) shm_grown: i64,
    pub(super) memory_grown: u64,
    pub(super) memory_leaked: bool,
    pub(super) whole_ns: Vec<u64>,
    pub(super) seconds: f64,
    pub(super) replay: String,
    /// The campaign was interrupted: the results until then stand.
    pub(crate) is_interrupted: bool,
}

impl Report {
    pub(super) fn new(seed: u64) -> Self {
        Self { seed, ..Self::default() }
    }

    /// Counts a request.
    pub(super) fn count(&mut self, state: State) {
        self.answers[state as usize] += 1;
    }

    /// Records a fault that took effect: the answer, when it was detected, when it was over.
    pub(super) fn add(&mut self, kind: Kind, state: State, detect_ns: Option<u64>, over_ns: u64) {
        let entry = self.entries.entry(kind).or_default();
        entry.detect_ns.extend(detect_ns);
        entry.recover_ns.push(over_ns);
        entry.answers[state as usize] += 1;
    }

    pub(super) fn skip(&mut self, kind: Kind, why: &'static str) {
        self.skipped.entry(kind).or_insert((0, why)).0 += 1;
    }

    /// `true` if this end is new.
    pub(super) fn note_end(&mut self, who: Incarnation) -> bool {
        self.ended.insert((who.worker, who.inc))
    }

    /// Counts a worker that was killed though no fault had struck it.
    pub(super) fn note_false_kill(&mut self, what: String) {
        self.false_kills += 1;
        self.tell(format!("healthy worker killed: {what}"));
    }

    /// Counts a fault that would have ended its worker, and that nobody noticed.
    pub(super) fn note_unseen(&mut self, what: String) {
        self.unseen += 1;
        self.tell(format!("never noticed: {what}"));
    }

    fn tell(&mut self, what: String) {
        if self.told.len() < TOLD {
            self.told.push(what);
        }
    }

    pub(super) fn document(&self) -> Injected {
        let rows: Vec<Row> = self.entries.iter().map(|(kind, entry)| row(*kind, entry)).collect();
        let leaks = self.orphans
            + self.left_behind
            + self.files_grown.max(0) as u64
            + self.shm_grown.max(0) as u64
            + u64::from(self.memory_leaked);
        let wrong = self.answers[State::Wrong as usize];
        Injected {
            schema: "trolley.injected-faults/1",
            seed: self.seed,
            is_interrupted: self.is_interrupted,
            injected: rows.iter().map(|row| row.injected).sum(),
            is_survived: wrong + self.hangs + self.false_kills + leaks == 0,
            wrong_answers: wrong,
            hangs: self.hangs,
            deadline_ms: self.deadline_ms,
            late: self.late,
            false_kills: self.false_kills,
            leaks,
            left: Left {
                descriptors: self.files_grown,
                shared_memory_files: self.shm_grown,
                memory_bytes: self.memory_grown,
                orphans: self.orphans,
                names_after_the_end: self.left_behind,
            },
            requests: self.requests,
            answers: Answers::of(self.answers),
            unseen: self.unseen,
            told: self.told.clone(),
            missed: self.missed,
            restarts: self.restarts,
            successor_ready: Times::of(&self.whole_ns),
            slowest_request_ms: self.slowest_ns as f64 / 1e6,
            jobs_reissued: self.reissued,
            parts_fenced: self.fenced,
            messages_rejected: self.rejected,
            skipped: self
                .skipped
                .iter()
                .map(|(kind, (count, why))| format!("{} × {}: {why}", count, kind.name()))
                .collect(),
            kinds: rows,
            seconds: self.seconds,
            replay: self.replay.clone(),
        }
    }
}

fn row(kind: Kind, entry: &Entry) -> Row {
    Row {
        fault: kind.name(),
        injected: entry.recover_ns.len() as u64,
        detected: entry.detect_ns.len() as u64,
        detection: Times::of(&entry.detect_ns),
        recovery: Times::of(&entry.recover_ns),
        answers: Answers::of(entry.answers),
    }
}

/// The report of a campaign.
#[derive(Clone, Debug, Serialize)]
pub struct Injected {
    schema: &'static str,
    seed: u64,
    is_interrupted: bool,
    injected: u64,
    is_survived: bool,
    wrong_answers: u64,
    hangs: u64,
    deadline_ms: Option<u32>,
    late: u64,
    false_kills: u64,
    leaks: u64,
    left: Left,
    requests: u64,
    answers: Answers,
    unseen: u64,
    told: Vec<String>,
    missed: u64,
    restarts: u64,
    successor_ready: Times,
    slowest_request_ms: f64,
    jobs_reissued: u64,
    parts_fenced: u64,
    messages_rejected: u64,
    skipped: Vec<String>,
    kinds: Vec<Row>,
    seconds: f64,
    replay: String,
}

#[derive(Clone, Debug, Serialize)]
struct Left {
    descriptors: i64,
    shared_memory_files: i64,
    memory_bytes: u64,
    orphans: u64,
    names_after_the_end: u64,
}

#[derive(Clone, Debug, Serialize)]
struct Row {
    fault: &'static str,
    injected: u64,
    detected: u64,
    detection: Times,
    recovery: Times,
    answers: Answers,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct Answers {
    complete: u64,
    degraded: u64,
    refused: u64,
    wrong: u64,
}

impl Answers {
    fn of([complete, degraded, refused, wrong]: [u64; 4]) -> Self {
        Self { complete, degraded, refused, wrong }
    }
}

/// Milliseconds; absent if there are none.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Times {
    median_ms: Option<f64>,
    p99_ms: Option<f64>,
    max_ms: Option<f64>,
}

impl Times {
    fn of(ns: &[u64]) -> Self {
        let mut sorted = ns.to_vec();
        sorted.sort_unstable();
        let percentile_ms = |share: usize| {
            let rank = (sorted.len() * share).div_ceil(100).checked_sub(1)?;
            sorted.get(rank).map(|ns| *ns as f64 / 1e6)
        };
        Self { median_ms: percentile_ms(50), p99_ms: percentile_ms(99), max_ms: percentile_ms(100) }
    }

    fn text(self) -> String {
        let text = |ms: Option<f64>| ms.map_or("–".to_owned(), |ms| format!("{ms:.1}"));
        format!("{:>8} {:>8} {:>8}", text(self.median_ms), text(self.p99_ms), text(self.max_ms))
    }
}

impl Injected {
    /// Whether there was no wrong answer, no hang and no false kill, and nothing was left behind.
    #[must_use]
    pub fn is_survived(&self) -> bool {
        self.is_survived
    }

    /// Whether the campaign was interrupted: then the results until then stand.
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        self.is_interrupted
    }

    /// The report as text.
    #[must_use]
    pub fn text(&self) -> String {
        page(self)
    }
}

fn page(document: &Injected) -> String {
    let mut text = String::new();
    let mut line = |words: String| {
        text.push_str(&words);
        text.push('\n');
    };
    line(format!(
        "{:<24} {:>8} {:>8}  {:^26}  {:^26}  {:^23}",
        "fault", "injected", "seen", "seen after, ms", "over after, ms", "C / D / R / wrong"
    ));
    let heads = format!("{:>8} {:>8} {:>8}", "median", "p99", "max");
    line(format!("{:<24} {:>8} {:>8}  {heads}  {heads}", "", "", ""));
    for row in &document.kinds {
        let Answers { complete, degraded, refused, wrong } = row.answers;
        line(format!(
            "{:<24} {:>8} {:>8}  {}  {}  {complete} / {degraded} / {refused} / {wrong}",
            row.fault,
            row.injected,
            row.detected,
            row.detection.text(),
            row.recovery.text(),
        ));
    }
    document.skipped.iter().for_each(|skipped| line(format!("not injected: {skipped}")));
    let Injected { injected, requests, wrong_answers, hangs, false_kills, .. } = document;
    line(format!(
        "\n{injected} faults in {requests} requests, {} workers replaced (ready again after, ms: \
         {}), {:.0} s",
        document.restarts,
        document.successor_ready.text().split_whitespace().collect::<Vec<_>>().join(" / "),
        document.seconds
    ));
    line(format!(
        "wrong answers {wrong_answers}, hangs {hangs} (slowest request {:.0} ms), healthy workers \
         killed {false_kills}",
        document.slowest_request_ms
    ));
    if let Some(deadline_ms) = document.deadline_ms {
        line(format!(
            "late {} of {requests} answers, each due after {deadline_ms} ms; a hang is {} ms later",
            document.late,
            GUARD_NS / 1_000_000
        ));
    }
    let left = &document.left;
    line(format!(
        "left behind {}: {:+} descriptors, {:+} files in shared memory, {:+} kB, {} orphans, {} \
         names",
        document.leaks,
        left.descriptors,
        left.shared_memory_files,
        left.memory_bytes >> 10,
        left.orphans,
        left.names_after_the_end
    ));
    line(format!("never noticed {}, could not be placed {}", document.unseen, document.missed));
    document.told.iter().for_each(|told| line(format!("  {told}")));
    line(format!("again: {}", document.replay));
    if document.is_interrupted {
        text.push_str("interrupted: the plan was not finished\n");
    }
    text
}

/// A test case for each kind of fault, for CI.
pub(super) fn junit(document: &Injected) -> String {
    let failed = |row: &Row| row.answers.wrong > 0;
    let failures = document.kinds.iter().filter(|row| failed(row)).count();
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"trolley inject\" \
         tests=\"{}\" failures=\"{}\" time=\"{:.1}\">\n",
        document.kinds.len() + 1,
        failures + usize::from(!document.is_survived),
        document.seconds
    );
    for row in &document.kinds {
        // Writing to a string cannot fail; names of faults need no escapes.
        let _written = writeln!(text, "  <testcase classname=\"faults\" name=\"{}\">", row.fault);
        if failed(row) {
            let wrong = row.answers.wrong;
            let _written = writeln!(text, "    <failure message=\"{wrong} wrong answers\"/>");
        }
        text.push_str("  </testcase>\n");
    }
    text.push_str("  <testcase classname=\"faults\" name=\"nothing left, nobody hung\">\n");
    if !document.is_survived {
        let Injected { hangs, false_kills, leaks, .. } = document;
        let _written = writeln!(
            text,
            "    <failure message=\"{hangs} hangs, {false_kills} false kills, {leaks} leaks\"/>"
        );
    }
    text.push_str("  </testcase>\n</testsuite>\n");
    text
}

#[cfg(test)]
mod tests {
    //! What a campaign fails by is told one by one, up to a bound.
    use super::*;

    #[test]
    fn a_healthy_worker_that_was_killed_is_named_and_fails_the_campaign() {
        let mut report = Report::new(1);
        assert!(report.document().is_survived());
        report.note_unseen("stop of worker 2 (process 6)".to_owned());
        assert!(report.document().is_survived(), "it is told, and fails nothing");
        for process in 0..2 * TOLD {
            report.note_false_kill(format!("worker 3 (process {process}): Ended"));
        }
        let document = report.document();
        assert!(!document.is_survived());
        let text = document.text();
        assert!(text.contains("killed 40\n") && text.contains("never noticed 1,"), "{text}");
        assert!(text.contains("  never noticed: stop of worker 2 (process 6)\n"), "{text}");
        assert_eq!(text.matches("healthy worker killed: worker 3").count(), TOLD - 1, "{text}");
    }
}
