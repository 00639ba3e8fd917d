//! The table of a ranking: whom each manoeuvre meets, when, in which order, what it
//! does to whom, and what else has to be known.

use crate::ranking_table::{self, StatedRow, share};
use crate::table::{circumstances, kept, percent};
use trolley::{Answer, AnswerState, ContactRow, CourseRow, Note, Run, Severity, WorldsRow};

/// The ranking as text: a table between sentences.
pub(crate) fn ranking(name: &str, answer: &Answer, run: &Run) -> String {
    let rows = match answer.members {
        None => stated(answer),
        Some(_) => expected(answer),
    };
    let head = format!("{}. Which does least harm?", name.trim_end_matches('.'));
    format!("{head}\n{}\n\n{}\n\n{}", circumstances(run), rows, verdict(answer, run))
}

/// The table of candidates in the scene as stated.
fn stated(answer: &Answer) -> String {
    ranking_table::stated(answer.ranking.iter().map(|row| {
        let worst = row.persons.iter().max_by(|a, b| a.work.hi().total_cmp(&b.work.hi()));
        StatedRow {
            name: &row.name,
            meets: meets(row),
            is_marked: is_marked(answer, row),
            worst: worst.map(|who| (ranking_table::worst_off(&who.party, who.seat), who.work.hi())),
            work: row.work.into(),
            range: row.range.into(),
        }
    }))
}

/// The table of candidates over members.
fn expected(answer: &Answer) -> String {
    let rows = answer.ranking.iter().filter_map(|row| row.expected.as_ref().map(|of| (row, of)));
    ranking_table::expected(rows.map(|(row, of)| ranking_table::ExpectedRow {
        name: &row.name,
        meets:
            of.meets.iter().map(|met| (met.party.as_str(), met.probability, met.from_s)).collect(),
        more: 0,
        is_marked: is_marked(answer, row),
        open: of.open,
        work: row.work.into(),
        range: row.range.into(),
        spread: of.spread.as_ref().map(|spread| ranking_table::Spread {
            error: spread.error,
            outer: [spread.quantiles[0], spread.quantiles[2]],
            best: spread.best,
        }),
        worlds: of.worlds,
    }))
}

/// What the numbers of the table are.
fn members(answer: &Answer) -> Option<String> {
    let of = answer.members.as_ref()?;
    let first = answer.ranking.first().and_then(|row| row.expected.as_ref());
    let injured = first.filter(|of| of.spread.is_some()).map(|of| of.injured.hi());
    Some(ranking_table::members(of.count, of.replaced, injured))
}

/// "1.62 s pedestrian, light" for each contact, one a line; or how near the ego comes to whom.
fn meets(row: &CourseRow) -> String {
    let mut lines: Vec<String> = row.contacts.iter().map(contact).collect();
    lines.extend(row.parts_from.iter().map(|party| format!("0.00 s {party}, they part")));
    lines.extend(row.maybe_inside.iter().map(|party| format!("0.00 s {party}? not decided")));
    if let Some(from_s) = row.open_from_s {
        lines.push(format!("not known after {from_s:.2} s"));
    } else if lines.is_empty() {
        let nearest = row.nearest.as_ref();
        let nearest = nearest.map(|near| (near.party.as_str(), near.gap_m, near.time_s));
        lines.push(ranking_table::nobody(nearest));
    }
    lines.join("\n")
}

/// As [`ranking_table::is_marked`].
fn is_marked(answer: &Answer, row: &CourseRow) -> bool {
    let is_first = answer.ranking.first().is_some_and(|first| first.name == row.name);
    let expected = row.expected.iter().flat_map(|of| &of.meets).map(|met| &*met.party);
    let met = row.contacts.iter().map(|contact| &*contact.party).chain(expected);
    ranking_table::is_marked(&answer.implausible, is_first, met)
}

fn contact(contact: &ContactRow) -> String {
    let ego = contact.delta_v_m_s[0].work.hi();
    let kind = severity(contact.severity);
    ranking_table::contact(contact.time_s, &contact.party, kind, ego, contact.is_certain)
}

fn verdict(answer: &Answer, run: &Run) -> String {
    let Some(first) = answer.ranking.first() else { return String::new() };
    let mut lines = Vec::new();
    let state = match answer.state {
        AnswerState::Complete => "COMPLETE: all work is done",
        AnswerState::Certified => "CERTIFIED: no open work can change the winner",
        AnswerState::Degraded if answer.members.is_some_and(|members| members.is_late) => {
            "DEGRADED: more members could change the winner"
        }
        AnswerState::Degraded => "DEGRADED: open work could change the winner",
        AnswerState::Refused => "REFUSED: no candidate has a bound",
    };
    let took = format!(
        "{state} ({:.1} ms for contacts, {} jobs in {:.1} ms; policy \"{}\")",
        run.stages.plan_ms, run.jobs, run.stages.work_ms, answer.policy
    );
    let free: Vec<&str> =
        answer.ranking.iter().filter(|row| row.touches_nobody()).map(|row| &*row.name).collect();
    let refusal = answer.refusal().map(Note::sentence);
    lines.extend(refusal.as_ref().map(|refusal| format!("NO WINNER: {refusal}.")));
    let tied = answer.tie_class.iter().filter(|name| **name != first.name);
    let tied: Vec<&str> = tied.map(String::as_str).collect();
    let least = refusal.is_none().then(|| ranking_table::least(&first.name, tied.len()));
    let hits_nobody = answer.ranking.iter().any(CourseRow::hits_nobody);
    let hits_nobody = (!first.is_stated_alone).then_some(hits_nobody);
    lines.push(ranking_table::first(&free, hits_nobody, &least.unwrap_or_default()));
    if refusal.is_none() && !free.is_empty() && !first.touches_nobody() {
        lines.push(format!("First under the policy: {}.", first.name));
    }
    lines.extend(ranking_table::implausible(&answer.implausible));
    lines.push(format!("{took}."));
    lines.extend(members(answer));
    lines.extend(lead(answer));
    lines.extend(worlds(answer));
    let notes = answer.notes.iter().filter(|note| !note.is_refusal());
    lines.extend(notes.map(|note| format!("Note: {}.", note.sentence())));
    lines.extend(run.deadline.as_ref().map(kept));
    lines.extend(first.why.iter().map(|why| format!("Why: {why}.")));
    lines.extend(ranking_table::tied(&tied));
    for other in &first.alternatives {
        lines.push(format!(
            "But if {} takes path {} (probability {:.2}), it is met after {:.2} s.",
            other.party, other.path, other.probability, other.time_s
        ));
    }
    lines.extend(ahead(first));
    lines.extend(answer.assumptions.iter().map(|assumed| format!("Assumed: {assumed}.")));
    if !answer.missing.is_empty() {
        lines.push(format!("Not fully known: {}.", answer.missing.join("; ")));
    }
    lines.extend(run.remarks.iter().map(|remark| format!("Note: {remark}.")));
    for worker in run.workers.iter().filter(|worker| worker.lost.is_some()) {
        let how = worker.lost.as_deref().unwrap_or_default();
        lines.push(format!("Note: worker {} was lost ({how}).", worker.worker));
    }
    lines.join("\n") + "\n"
}

/// How sure the first place is.
fn lead(answer: &Answer) -> Option<String> {
    let lead = answer.members.as_ref()?.lead?;
    ranking_table::lead(lead.mean, lead.error)
}

/// In how many worlds the first wins, if it can touch anybody, and what would turn that.
fn worlds(answer: &Answer) -> Option<String> {
    let WorldsRow { count, flips } = answer.worlds.as_ref()?;
    let first = answer.ranking.first().filter(|row| !row.touches_nobody())?;
    let won = first.expected.as_ref()?.worlds?;
    let alone: Vec<String> =
        flips.iter().map(|flip| format!("{} in {}", flip.doubt.name(), share(flip.lost))).collect();
    let alone = match alone.as_slice() {
        [] => "nothing alone has another one win".to_owned(),
        some => format!("alone, another one wins by {}", some.join(", by ")),
    };
    Some(ranking_table::worlds(*count, won, Some(&alone)))
}

/// What is ahead of the ego at the end of its way.
fn ahead(row: &CourseRow) -> Option<String> {
    let end = row.at_horizon.as_ref()?;
    let (party, after_s) = end.next_contact.as_ref()?;
    Some(format!(
        "At the end of its way, after {:.2} s, it goes {:.1} m/s and would meet {party} \
         {after_s:.1} s later if nobody did anything.",
        end.time_s, end.speed_m_s
    ))
}

/// The course of every candidate, contact by contact.
pub(crate) fn courses(answer: &Answer) -> String {
    let mut lines = Vec::new();
    for (at, row) in answer.ranking.iter().enumerate() {
        lines.push(format!("\n{}. {}", at + 1, row.name));
        for contact in &row.contacts {
            lines.extend(contact_lines(contact));
        }
        if row.touches_nobody() {
            lines.push("   Touches nobody: proven for every triangle and every time.".to_owned());
        }
        if let Some(from_s) = row.open_from_s {
            lines.push(format!("   After {from_s:.3} s nothing is known: anything may happen."));
        }
        for run_out in &row.run_outs {
            let [x, y] = run_out.velocity_m_s;
            lines.push(format!(
                "   Run-out from {:.3} s at {:.1} m/s ({x:.1}, {y:.1}), {:.1} m until it stands",
                run_out.from_s,
                x.hypot(y),
                run_out.length_m
            ));
        }
        for person in &row.persons {
            lines.push(format!(
                "   {}: risk {} %, range {}–{} %",
                who(&person.party, person.seat),
                percent(person.work.hi()),
                percent(person.range.low()),
                percent(person.range.high())
            ));
        }
        if let Some(near) = &row.nearest {
            lines.push(format!(
                "   Comes nearest to {}: {:.2} m in plan at {:.2} s",
                near.party, near.gap_m, near.time_s
            ));
        }
        for other in &row.alternatives {
            lines.push(format!(
                "   If {} takes path {} (probability {:.2}): met after {:.3} s",
                other.party, other.path, other.probability, other.time_s
            ));
        }
        lines.extend(ahead(row).map(|ahead| format!("   {ahead}")));
        lines.extend(row.remarks.iter().map(|remark| format!("   Note: {remark}")));
        lines.extend(row.why.iter().map(|why| format!("   Before the next: {why}")));
    }
    lines.join("\n") + "\n"
}

fn contact_lines(contact: &ContactRow) -> Vec<String> {
    let [ego, other] = &contact.delta_v_m_s;
    let other = if contact.is_other_fixed {
        "fixed".to_owned()
    } else {
        format!("{:.2} ({:.2}–{:.2}) m/s", other.work.hi(), other.range.low(), other.range.high())
    };
    let parts = |parts: &[String]| {
        if parts.is_empty() { "–".to_owned() } else { parts.join(", ") }
    };
    let mut lines = vec![
        format!(
            "   {:.6} s {}: {}, {}; triangles {} and {}",
            contact.time_s,
            contact.party,
            contact.sides,
            severity(contact.severity),
            contact.triangles[0],
            contact.triangles[1]
        ),
        format!(
            "      closing {:.2} m/s, ΔV ego {:.2} ({:.2}–{:.2}) m/s, other {other}",
            contact.closing_m_s,
            ego.work.hi(),
            ego.range.low(),
            ego.range.high()
        ),
        format!(
            "      {} and {} triangles hit; parts {} and {}",
            contact.hits[0],
            contact.hits[1],
            parts(&contact.parts[0]),
            parts(&contact.parts[1])
        ),
    ];
    if contact.first_touch_s < contact.time_s {
        lines.push(format!(
            "      they first touched after {:.6} s, lightly, and did not part",
            contact.first_touch_s
        ));
    }
    for person in &contact.persons {
        lines.push(format!(
            "      {}: {} % by {}",
            who(&person.party, person.seat),
            percent(person.work.hi()),
            person.curve
        ));
    }
    lines
}

fn severity(severity: Severity) -> &'static str {
    match severity {
        Severity::Light => "light",
        Severity::Heavy => "heavy",
    }
}

/// "bus, rear-left", "pedestrian".
fn who(party: &str, seat: Option<&str>) -> String {
    seat.map_or_else(|| party.to_owned(), |seat| format!("{party}, {seat}"))
}
