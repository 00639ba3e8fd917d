//! A decision record and its replayed answer as plain values: the contents of a page, and a shot of
//! each candidate.

use crate::explain;
use crate::html::{CandidateRow, DecisionPage, TimelineMoment, TimelineSpan, Worker};
use crate::shot::{Shot, ShotBody, ShotPatch};
use std::collections::BTreeMap;
use trolley::record::{Link, RecordContent, RecordedEnd, Replay, hex};
use trolley::{Failure, PersonRow, Record, Row, Touch};

/// The bodies, by number as the candidates name them.
pub(crate) fn bodies(made: &Replay) -> Result<Vec<ShotBody>, Failure> {
    let views = made.bodies.views()?;
    let parties = made.scenario.parsed().parties.iter().zip(&views);
    let bodies = parties.map(|(party, (_, view))| ShotBody {
        name: party.name.to_string(),
        corners: view.corners.to_vec(),
    });
    Ok(bodies.collect())
}

/// Every candidate in the order of the ranking.
pub(crate) fn shots(made: &Replay) -> Vec<Shot> {
    let shot = |row: &Row| {
        let scene = made.scenes.iter().find(|scene| scene.name == row.name)?;
        let patch = row.contact.patch.as_ref().map(|patch| ShotPatch {
            centre_m: patch.centre_m,
            normal: patch.normal,
            size_m: [patch.width_m.hi(), patch.height_m.hi()],
        });
        let hits: usize = scene.hits.iter().map(Vec::len).sum();
        let caption = match patch {
            Some(patch) => format!(
                "{}: {}. {hits} triangles intersect from first contact on; the patch is {:.2} m \
                 wide and {:.2} m high. Bodies as they lie when it is complete.",
                row.name, row.sides, patch.size_m[0], patch.size_m[1]
            ),
            None => format!("{}: nothing touches. Bodies as they lie at the given pose.", row.name),
        };
        Some(Shot {
            name: row.name.clone(),
            bodies: scene.models,
            rotation: scene.pose.rotation,
            translation: scene.pose.translation,
            hits: scene.hits.clone(),
            patch,
            caption,
        })
    };
    made.answer.ranking.iter().filter_map(shot).collect()
}

fn who(person: &PersonRow) -> String {
    match person.seat {
        Some("front-left") => format!("{} driver", person.party),
        Some(seat) => format!("{} {}", person.party, seat.replace('-', " ")),
        None => person.party.clone(),
    }
}

fn candidate(row: &Row) -> CandidateRow {
    let touches = row.contact.touch == Touch::Yes;
    let contact = match row.contact.touch {
        Touch::Yes => row.sides.clone(),
        Touch::No if row.contact.hull_gap_m > 0.0 => {
            format!("none: {:.2} m apart", row.contact.hull_gap_m)
        }
        Touch::No => "none".to_owned(),
        Touch::Unknown => "unknown".to_owned(),
    };
    let [ego, other] = row.delta_v_m_s.map(|delta| touches.then(|| delta.work.hi()));
    let person = |person: &PersonRow| {
        let (work, range) = (person.work, person.range);
        (who(person), [work.lo(), work.hi()], [range.low(), range.high()])
    };
    CandidateRow {
        name: row.name.clone(),
        other: row.other.clone(),
        contact,
        touches,
        depth_m: row.contact.patch.as_ref().map(|patch| patch.depth_m.hi()),
        delta_v_m_s: [ego, if row.is_other_fixed { None } else { other }],
        work: [row.work.lo(), row.work.hi()],
        range: [row.range.low(), row.range.high()],
        why: row.why.clone(),
        persons: row.persons.iter().map(person).collect(),
    }
}

/// The contents of the page of a replayed record.
pub(crate) fn decision(made: &Replay, record: &Record) -> DecisionPage {
    let Record { content: record, link, .. } = record;
    let Replay { answer, explanation, .. } = made;
    let count = |end: RecordedEnd| record.jobs.iter().filter(|job| job.end == end).count() as u64;
    let mut jobs_of: BTreeMap<u32, (u64, u64)> = BTreeMap::new();
    for job in &record.jobs {
        let Some(place) = record.places.get(job.place as usize) else { continue };
        let (done, not) = jobs_of.entry(place.candidate).or_default();
        match job.end {
            RecordedEnd::Done => *done += 1,
            RecordedEnd::Cut | RecordedEnd::Abandoned => *not += 1,
        }
    }
    let name = |number: u32| explanation.names.get(number as usize).cloned().unwrap_or_default();
    let mut workers: BTreeMap<u8, Vec<TimelineSpan>> = BTreeMap::new();
    for span in &record.spans {
        let (from_ms, to_ms) = (span.from_ns as f64 / 1e6, span.to_ns as f64 / 1e6);
        workers.entry(span.worker).or_default().push(TimelineSpan { from_ms, to_ms });
    }
    let missing = answer.missing.iter().map(|name| format!("Not fully known: {name}."));
    let assumed = answer.assumptions.iter().map(|text| format!("Assumed: {text}."));
    let near = answer.ranking.iter().filter(|row| row.contact.near_miss);
    let near = near.map(|row| format!("Near miss, closer than poses are known: {}.", row.name));
    let faults = record.faults.iter().map(|fault| format!("Note: {fault}."));
    DecisionPage {
        scenario: made.scenario.parsed().name.clone(),
        state: answer.state.name().to_owned(),
        candidates: answer.ranking.iter().map(candidate).collect(),
        ties: answer.tie_class.clone(),
        policy: explanation.policy.clone(),
        board: explanation.board.clone(),
        outcome: explanation.outcome.to_uppercase(),
        persons: explanation.persons,
        remarks: missing.chain(assumed).chain(near).chain(faults).collect(),
        explanation: explain::text(explanation),
        stages: record.stages.iter().map(|stage| (stage.name.clone(), stage.ms)).collect(),
        jobs: [count(RecordedEnd::Done), count(RecordedEnd::Cut), count(RecordedEnd::Abandoned)],
        jobs_of: jobs_of.into_iter().map(|(of, (done, not))| (name(of), done, not)).collect(),
        workers: workers
            .into_iter()
            .map(|(worker, spans)| Worker { name: format!("worker {worker}"), spans })
            .collect(),
        moments: record
            .moments
            .iter()
            .map(|moment| TimelineMoment {
                at_ms: moment.at_ns as f64 / 1e6,
                jobs: moment.jobs,
                work: moment.work.clone(),
            })
            .collect(),
        names: explanation.names.clone(),
        edges: record
            .edges
            .iter()
            .map(|edge| (edge.from.clone(), edge.to.clone(), edge.messages, edge.bytes))
            .collect(),
        facts: facts(record, link),
    }
}

fn facts(record: &RecordContent, link: &Link) -> Vec<(String, String)> {
    let fact = |name: &str, value: String| (name.to_owned(), value);
    let s = &record.settings;
    let mut facts = vec![
        fact("record", format!("{} of its chain, {}", link.number, hex(&link.hash))),
        fact("after", hex(&link.previous)),
        fact("build", record.build.clone()),
        fact("scenario", format!("{} {}", record.scenario.name, record.scenario.hash)),
        fact("policy", format!("{} {}", record.policy.name, record.policy.hash)),
        fact("curves", format!("{} {}", record.curves.name, record.curves.hash)),
        fact(
            "settings",
            format!(
                "{}, {} workers, depth {}, tree {}, {}, batch {}, queue {}, seed {}",
                s.mode.name(),
                s.workers,
                s.depth,
                s.tree.name(),
                s.scheme.name(),
                s.batch,
                s.queue,
                s.seed
            ),
        ),
    ];
    let body = |body: &trolley::record::RecordedBody| {
        fact(&format!("body {}", body.party), body.hash.clone())
    };
    facts.extend(record.bodies.iter().map(body));
    facts
}
