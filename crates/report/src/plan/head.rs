//! The answer in words, before everything else.

use super::{PlanPage, apart, bdi, folded, name};
use std::fmt::Write as _;
use trolley::{Answer, AnswerState, CourseRow};

/// Won in fewer of the worlds that the model allows, a candidate is not called the least harm: the
/// usual level of confidence.
const WORLDS_SURE: f64 = 0.95;

/// More of what was assumed than this is folded (characters).
const LINE_MAX: usize = 160;

/// Whether the first candidate does least harm for all that is known: nothing open can change it,
/// the model tells it from all others, and neither chance nor what the model does not know would
/// often have another one first.
pub(super) fn is_least_harm(answer: &Answer) -> bool {
    let Some(first) = answer.best() else { return false };
    // One alone is compared with nobody.
    if answer.ranking.len() == 1 {
        return false;
    }
    let is_done = matches!(answer.state, AnswerState::Complete | AnswerState::Certified);
    let is_alone = answer.tie_class.iter().all(|tied| *tied == first.name);
    is_done && is_alone && !is_close(answer) && won(answer).is_none_or(|won| won >= WORLDS_SURE)
}

/// Whether members leave the best two too close to call.
fn is_close(answer: &Answer) -> bool {
    answer.members.as_ref().and_then(|members| members.lead).is_some_and(|lead| lead.is_close())
}

/// The share of worlds that the first wins.
fn won(answer: &Answer) -> Option<f64> {
    answer.ranking.first().and_then(|row| row.expected.as_ref()?.worlds)
}

/// Whether nobody looked at any of them.
fn is_all_open(rows: &[(usize, &CourseRow)]) -> bool {
    rows.iter().all(|(_, row)| row.open_from_s == Some(0.0))
}

/// Whether two do the same harm, and may do the same.
fn is_equal(row: &CourseRow, other: &CourseRow) -> bool {
    row.work == other.work && row.range == other.range
}

/// What the answer says of the candidate that the page opens on.
pub(super) fn title(rows: &[(usize, &CourseRow)], answer: &Answer) -> String {
    let Some((_, first)) = rows.first() else { return "Nothing to rank".to_owned() };
    let first_name = &first.name;
    if answer.refusal().is_some() {
        return "No way is acceptable under the policy".to_owned();
    }
    if first.touches_nobody() {
        return format!("Touches nobody: {first_name}");
    }
    let tied = answer.tie_class.iter().filter(|tied| *tied != first_name).count();
    let equal = rows.iter().filter(|(_, row)| is_equal(row, first)).count();
    match answer.state {
        AnswerState::Refused => "Not known which way is best".to_owned(),
        AnswerState::Degraded if is_all_open(rows) => {
            format!("Nothing is known in time; first as asked: {first_name}")
        }
        AnswerState::Degraded => format!("First, as far as is known: {first_name}"),
        _ if rows.len() == 1 => format!("The only way: {first_name}"),
        _ if is_least_harm(answer) => format!("Least harm: {first_name}"),
        _ if tied > 0 && equal == tied + 1 => {
            format!("First of {equal} that do the same harm: {first_name}")
        }
        _ if tied > 0 => {
            format!("First of {} whose ranges overlap: {first_name}", tied + 1)
        }
        _ if is_close(answer) => format!("First, but too close to call: {first_name}"),
        _ => {
            let won = 100.0 * won(answer).unwrap_or_default();
            format!("First in {won:.0} % of the worlds that the model allows: {first_name}")
        }
    }
}

/// The answer in words: what was asked, what came out, how sure, why, by whose rule.
pub(super) fn head(
    page: &PlanPage<'_>,
    rows: &[(usize, &CourseRow)],
    title: &str,
    body: &mut String,
) {
    let PlanPage { scenario, answer, .. } = page;
    let count = rows.len();
    let free = rows.iter().filter(|(_, row)| row.touches_nobody()).count();
    let _w = write!(
        body,
        "<header><p class=\"asked\">{}. {count} way{} left; {}.</p><h1>{}</h1>\
         <dl class=\"verdict\">",
        bdi(scenario.trim_end_matches('.')),
        if count == 1 { " is" } else { "s are" },
        match free {
            0 if is_all_open(rows) => "of none it is known what happens".to_owned(),
            0 if rows.iter().any(|(_, row)| row.is_stated_alone) => {
                "known is the scene as stated alone".to_owned()
            }
            0 if rows.iter().any(|(_, row)| row.hits_nobody()) => {
                "none is free of contact from the start on".to_owned()
            }
            0 if count == 1 => "it hits somebody, as far as is known".to_owned(),
            0 => "each hits somebody, as far as is known".to_owned(),
            1 if count == 1 => "it touches nobody".to_owned(),
            free if free == count => "none touches anybody".to_owned(),
            1 => "1 touches nobody".to_owned(),
            free => format!("{free} touch nobody"),
        },
        bdi(title)
    );
    let mut say = |term: &str, text: String| {
        let _w = write!(body, "<dt>{term}</dt><dd>{text}</dd>");
    };
    if let Some(refusal) = answer.refusal() {
        say("What the policy says", format!("{}.", name(&refusal.sentence())));
    } else if let Some((_, first)) = rows.first() {
        say("What happens", happens(first));
    }
    let mut sure = match answer.state {
        AnswerState::Complete => "<b>Complete.</b> All work is done.",
        AnswerState::Certified => {
            "<b>Certified.</b> Not all work is done, but none of the rest can change the winner."
        }
        AnswerState::Degraded => "<b>Degraded.</b> Missing work could change the winner.",
        AnswerState::Refused => "<b>Refused.</b> No candidate has a bound.",
    }
    .to_owned();
    let first = answer.ranking.first();
    let is_first = |name: &str| first.is_some_and(|row| row.name == name);
    let ties: Vec<String> =
        answer.tie_class.iter().filter(|one| !is_first(one)).map(|one| bdi(one)).collect();
    if !ties.is_empty() {
        let tied = answer.ranking.iter().filter(|row| answer.tie_class.contains(&row.name));
        let is_same = |row: &CourseRow| first.is_some_and(|first| is_equal(row, first));
        let is_harmless = tied.clone().all(|row| row.range.high() == 0.0);
        let (begins, what) = if is_harmless {
            ("These do no harm either", "do no harm either")
        } else if tied.clone().all(is_same) {
            ("As far as is known these are the same", "are the same as far as is known")
        } else {
            let begins = "With each one's doubts at their ends these could be as good";
            (begins, "could be as good: their ranges overlap with its own")
        };
        let said = format!("{begins}: {}.", ties.join("; "));
        sure.push_str(&folded(&said, ties.len(), what));
        if is_harmless {
            // A scenario has bodies and no lanes, so a way into a field is as good as any.
            let road = " Where the road ends is not known here: the order among these is that of \
                        the request.";
            sure.push_str(road);
        }
    }
    let won = first.and_then(|row| row.expected.as_ref()?.worlds);
    // Who touches nobody in any member does no harm in any world, and one alone always wins.
    let is_free = first.is_some_and(CourseRow::touches_nobody) || rows.len() == 1;
    if let (Some(won), Some(worlds), false) = (won, &answer.worlds, is_free) {
        let _w = write!(
            sure,
            " It wins in {:.0} % of {} worlds that the model allows.",
            100.0 * won,
            worlds.count
        );
    }
    if let Some(lead) = answer.members.as_ref().and_then(|members| members.lead) {
        let _w = write!(sure, " {}", ahead(lead.mean, lead.error, lead.is_close()));
    }
    say("How sure", sure);
    if let Some(first) = first {
        if answer.refusal().is_some() {
            say("First in order", bdi(&first.name));
        } else if rows.first().is_some_and(|(place, _)| *place > 0) {
            say("First under the policy", bdi(&first.name));
        }
        if let Some(why) = &first.why {
            say("Why", format!("{}.", name(why.trim_end_matches('.'))));
        }
    }
    say(
        "Whose rule",
        format!("The policy “{}”; harm is its leading measure.", bdi(&answer.policy)),
    );
    body.push_str("</dl>");
    let implausible =
        answer.implausible.iter().map(|one| format!("Implausible: {}", one.sentence()));
    let missing = missing(&answer.missing, count);
    let notes = answer.notes.iter().filter(|note| !note.is_refusal());
    let notes = notes.map(|note| format!("Note: {}.", note.sentence()));
    for remark in implausible.chain(missing).chain(notes) {
        let _w = write!(body, "<p class=\"remark\">{}</p>", name(&remark));
    }
    assumed(&answer.assumptions, body);
    body.push_str("</header>");
}

/// By how much the first is ahead of the second, and how sure that is.
pub(super) fn ahead(mean: f64, error: f64, is_close: bool) -> String {
    if mean == 0.0 && error == 0.0 {
        return "The second is as good in every member.".to_owned();
    }
    // As many digits as tell the error.
    let [mean_points, error_points] = [100.0 * mean.abs(), 100.0 * error];
    let digits =
        if error > 0.0 { (1.0 - error_points.log10().floor()).clamp(2.0, 6.0) } else { 2.0 };
    let digits = digits as usize;
    let by = format!("{mean_points:.digits$} ± {error_points:.digits$} percentage points");
    let than = if mean < 0.0 { "less" } else { "more" };
    let chance = if is_close {
        "less than its sampling error, and may be chance".to_owned()
    } else if error > 0.0 {
        format!("{:.1} times its sampling error", mean.abs() / error)
    } else {
        "the same in every member".to_owned()
    };
    format!("In the mean over members the second has {by} {than} harm: {chance}.")
}

/// What is not known; what is the same of several ways is said once.
fn missing(texts: &[String], ways: usize) -> Vec<String> {
    let mut said: Vec<(Vec<&str>, &str)> = Vec::new();
    for text in texts {
        let (way, what) = text.split_once(": ").unwrap_or(("", text));
        match said.iter_mut().find(|(names, of)| *of == what && !names.contains(&"")) {
            Some((names, _)) if !way.is_empty() => names.push(way),
            _ => said.push((vec![way], what)),
        }
    }
    let sentence = |(names, what): (Vec<&str>, &str)| match names.as_slice() {
        [""] => format!("Not fully known: {what}."),
        [way] => format!("Not fully known: {way}: {what}."),
        names if names.len() == ways => format!("Not fully known of any way: {what}."),
        names => format!("Not fully known of {}: {what}.", names.join("; ")),
    };
    said.into_iter().map(sentence).collect()
}

/// What was assumed: in a line if it fits one, else folded, under how it begins.
fn assumed(assumptions: &[String], body: &mut String) {
    let length: usize = assumptions.iter().map(|text| text.chars().count()).sum();
    let sentences = |body: &mut String| {
        for text in assumptions {
            let _w = write!(body, "<p class=\"remark\">{}</p>", name(&format!("Assumed: {text}.")));
        }
    };
    if length <= LINE_MAX {
        return sentences(body);
    }
    let begins: Vec<String> = assumptions.iter().map(|text| bdi(beginning(text))).collect();
    let _w = write!(
        body,
        "<details class=\"assumed\"><summary>Assumed: {}</summary>",
        begins.join("; ")
    );
    sentences(body);
    body.push_str("</details>");
}

/// As far as its first colon or semicolon: what it lists comes after.
fn beginning(text: &str) -> &str {
    text.split([':', ';']).next().unwrap_or(text)
}

/// What a way comes to, in a sentence or two.
pub(super) fn happens(row: &CourseRow) -> String {
    let mut text = match (row.contacts.as_slice(), row.open_from_s) {
        ([], None) if row.is_stated_alone || (row.expected.is_some() && !row.touches_nobody()) => {
            let met = row.expected.iter().flat_map(|of| &of.meets);
            let met: Vec<String> = met
                .map(|met| format!("{} in {:.0} %", bdi(&met.party), 100.0 * met.probability))
                .collect();
            if met.is_empty() {
                "In the scene as stated it touches nobody.".to_owned()
            } else {
                format!(
                    "In the scene as stated it touches nobody. Over the members it meets {}.",
                    met.join(", ")
                )
            }
        }
        ([], None) if !row.touches_nobody() => {
            "It hits nobody, but is or may be in contact at the start: see its notes.".to_owned()
        }
        ([], None) => "It touches nobody until the end of its way: proven for every triangle and \
                       every time."
            .to_owned(),
        ([], Some(0.0)) => "It is not known what happens.".to_owned(),
        ([], Some(from_s)) => format!("After {from_s:.2} s it is not known what happens."),
        (contacts, _) => {
            let said = contacts.iter().enumerate().map(|(at, contact)| {
                let is_again = at > 0 && contacts[at - 1].party == contact.party;
                let whom = if is_again { "again".to_owned() } else { bdi(&contact.party) };
                format!("{whom} after {:.2} s", contact.time_s)
            });
            format!("It meets {}.", said.collect::<Vec<_>>().join(", then "))
        }
    };
    if let Some(near) = row.nearest.as_ref().filter(|_| row.contacts.is_empty()) {
        let _w = write!(
            text,
            " It comes nearest to {}: {} in plan at {:.2} s.",
            bdi(&near.party),
            apart(near.gap_m),
            near.time_s
        );
    }
    for other in &row.alternatives {
        let _w = write!(
            text,
            " But if {} takes path {} (probability {:.2}), it is met after {:.2} s.",
            bdi(&other.party),
            other.path,
            other.probability,
            other.time_s
        );
    }
    text
}
