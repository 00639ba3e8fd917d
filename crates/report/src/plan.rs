//! The page of a ranking: the answer in words, the scene from above with a slider over time, every
//! contact in words and in 3D, the chain of figures, and how the work was done. A single file that
//! fetches nothing.

use crate::html::{chart, data_element, escape, framed, percent, view_scripts};
use crate::pack;
use crate::shot::{Shot, ShotBody};
use crate::work::WorkDone;
use ranking::ranking;
use serde_json::json;
use std::fmt::Write as _;
use trolley::{Answer, AnswerState, ContactRow, CourseRow, PlanScene, Severity};

mod drawing;
mod ranking;

const STYLE: &str = include_str!("../page/plan.css");
const SCRIPT: &str = include_str!("../page/plan.js");

/// The contents of a page about a ranking.
#[derive(Clone, Copy, Debug)]
pub struct PlanPage<'a> {
    /// Name of the scenario.
    pub scenario: &'a str,
    /// The answer.
    pub answer: &'a Answer,
    /// How the work was done.
    pub work: &'a WorkDone,
    /// Who is where and when.
    pub scene: &'a PlanScene,
    /// The bodies, by number as `shots` name them.
    pub bodies: &'a [ShotBody],
    /// The contacts in 3D.
    pub shots: &'a [Shot],
    /// The chain from contact to rank, as text, if there is one.
    pub explanation: Option<&'a str>,
}

/// Text as markup, without characters that change the direction of what follows.
fn name(text: &str) -> String {
    // Marks, embeddings and isolates of the Unicode Bidirectional Algorithm.
    const TURNS: [core::ops::RangeInclusive<char>; 3] =
        ['\u{200e}'..='\u{200f}', '\u{202a}'..='\u{202e}', '\u{2066}'..='\u{2069}'];
    let is_turn = |c: char| TURNS.iter().any(|turns| turns.contains(&c));
    escape(&text.chars().map(|c| if is_turn(c) { '\u{fffd}' } else { c }).collect::<String>())
}

/// A name within a sentence: its direction is its own.
fn bdi(text: &str) -> String {
    format!("<bdi>{}</bdi>", name(text))
}

/// At most so many letters.
fn cut(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most - 1).chain(['…']).collect()
}

/// The rows in the order of the page: those that touch nobody first, each with its place.
fn rows(answer: &Answer) -> Vec<(usize, &CourseRow)> {
    let mut rows: Vec<_> = answer.ranking.iter().enumerate().collect();
    rows.sort_by_key(|(_, row)| !row.touches_nobody());
    rows
}

/// The page.
#[must_use]
pub fn page(page: &PlanPage<'_>) -> String {
    let PlanPage { answer, scene, .. } = page;
    let rows = rows(answer);
    let title = title(&rows, answer);
    let mut body = String::new();
    head(page, &rows, &title, &mut body);
    ranking(&rows, &mut body);
    // The candidates of the scene stand in the scenario's order.
    let number = |row: &CourseRow| scene.courses.iter().position(|one| one.name == row.name);
    let order: Vec<(usize, &CourseRow)> =
        rows.iter().filter_map(|(_, row)| Some((number(row)?, *row))).collect();
    let window = drawing::PlanWindow::of(scene);
    view(scene, &window, &order, &mut body);
    for (_, row) in &rows {
        course(row, &mut body);
    }
    touching(page.shots, &mut body);
    if let Some(explanation) = page.explanation {
        let _w = write!(
            body,
            "<section><h2>From contact to rank</h2><p>Every figure that decided, with its source, \
             to be checked by hand.</p><details><summary>Show the chain</summary><pre>{}</pre>\
             </details></section>",
            name(explanation)
        );
    }
    engineers(page, &mut body);
    let (bodies, shots) = pack::pack(page.bodies, page.shots);
    let data = json!({"scene": scene, "view": window, "bodies": bodies, "shots": shots});
    let mut scripts = format!("{}<script>{SCRIPT}</script>", data_element(&data.to_string()));
    if !page.shots.is_empty() {
        scripts.push_str(&view_scripts());
    }
    framed(&title, &body, STYLE, &scripts)
}

fn title(rows: &[(usize, &CourseRow)], answer: &Answer) -> String {
    let Some((_, first)) = rows.first() else { return "Nothing to rank".to_owned() };
    if answer.refusal().is_some() {
        return "No way is acceptable under the policy".to_owned();
    }
    if first.touches_nobody() {
        return format!("Touches nobody: {}", first.name);
    }
    match answer.state {
        AnswerState::Complete | AnswerState::Certified => format!("Least harm: {}", first.name),
        AnswerState::Degraded => format!("Least harm, as far as is known: {}", first.name),
        AnswerState::Refused => "Not known which does least harm".to_owned(),
    }
}

fn head(page: &PlanPage<'_>, rows: &[(usize, &CourseRow)], title: &str, body: &mut String) {
    let PlanPage { scenario, answer, work, .. } = page;
    let count = rows.len();
    let free = rows.iter().filter(|(_, row)| row.touches_nobody()).count();
    let _w = write!(
        body,
        "<header><p class=\"asked\">{}. {count} way{} left; {}.</p><h1>{}</h1>\
         <dl class=\"verdict\">",
        bdi(scenario.trim_end_matches('.')),
        if count == 1 { " is" } else { "s are" },
        match free {
            0 if rows.iter().any(|(_, row)| row.hits_nobody()) => {
                "none is free of contact from the start on".to_owned()
            }
            0 => "each hits somebody, as far as is known".to_owned(),
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
        let _w = write!(sure, " Within the range of the model as good: {}.", ties.join(", "));
    }
    let won = first.and_then(|row| row.expected.as_ref()?.worlds);
    if let (Some(won), Some(worlds)) = (won, &answer.worlds) {
        let _w = write!(
            sure,
            " It wins in {:.0} % of {} worlds that the model allows.",
            100.0 * won,
            worlds.count
        );
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
    let missing = answer.missing.iter().map(|text| format!("Not fully known: {text}."));
    let assumed = answer.assumptions.iter().map(|text| format!("Assumed: {text}."));
    let remarks = work.remarks.iter().map(|text| format!("Note: {text}."));
    let notes = answer.notes.iter().filter(|note| !note.is_refusal());
    let notes = notes.map(|note| format!("Note: {}.", note.sentence()));
    for remark in implausible.chain(missing).chain(assumed).chain(notes).chain(remarks) {
        let _w = write!(body, "<p class=\"remark\">{}</p>", name(&remark));
    }
    body.push_str("</header>");
}

/// What a way comes to, in a sentence or two.
fn happens(row: &CourseRow) -> String {
    let mut text = match (row.contacts.as_slice(), row.open_from_s) {
        ([], None) if row.expected.is_some() && !row.touches_nobody() => {
            "In the scene as stated it touches nobody.".to_owned()
        }
        ([], None) if !row.touches_nobody() => {
            "It hits nobody, but is or may be in contact at the start: see its notes.".to_owned()
        }
        ([], None) => "It touches nobody until the end of its way: proven for every triangle and \
                       every time."
            .to_owned(),
        ([], Some(from_s)) => format!("After {from_s:.2} s it is not known what happens."),
        (contacts, _) => {
            let said = contacts
                .iter()
                .map(|contact| format!("{} after {:.2} s", bdi(&contact.party), contact.time_s));
            format!("It meets {}.", said.collect::<Vec<_>>().join(", then "))
        }
    };
    if let Some(near) = row.nearest.as_ref().filter(|_| row.contacts.is_empty()) {
        let _w = write!(
            text,
            " It comes nearest to {}: {:.2} m in plan at {:.2} s.",
            bdi(&near.party),
            near.gap_m,
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

/// A share, or its bounds if work is open.
fn share(low: f64, high: f64) -> String {
    if low == high { percent(high) } else { format!("{}–{}", percent(low), percent(high)) }
}

fn severity(severity: Severity) -> &'static str {
    match severity {
        Severity::Light => "light",
        Severity::Heavy => "heavy",
    }
}

fn view(
    scene: &PlanScene,
    window: &drawing::PlanWindow,
    order: &[(usize, &CourseRow)],
    body: &mut String,
) {
    let Some((shown, first)) = order.first() else { return };
    let _w = write!(
        body,
        "<section><h2>From above</h2><div id=\"controls\" class=\"controls\" hidden>\
         <label>manoeuvre <select id=\"course\" autocomplete=\"off\">"
    );
    for (at, (k, row)) in order.iter().enumerate() {
        let selected = if at == 0 { " selected" } else { "" };
        let _w =
            write!(body, "<option value=\"{k}\"{selected}>{}</option>", name(&cut(&row.name, 60)));
    }
    let _w = write!(
        body,
        "</select></label><label class=\"time\">time <input id=\"time\" type=\"range\" min=\"0\" \
         max=\"{:.2}\" step=\"0.05\" value=\"0\" autocomplete=\"off\"><output id=\"now\">0.00 \
         s</output></label></div>",
        // The last step reaches the end: bodies stay where their tracks end.
        (scene.horizon_s / 0.05 - 1e-6).ceil() * 0.05
    );
    let title = format!("The scene from above at the start, with the way of: {}", first.name);
    body.push_str(&drawing::svg(scene, window, *shown, &title));
    body.push_str(
        "<noscript><p class=\"key\">Shown is the first candidate at the start; the other ones, and \
         other times, need JavaScript.</p></noscript><p class=\"key\"><span \
         class=\"swatch-ego\"></span> ego <span class=\"swatch-met\"></span> is met <span \
         class=\"swatch-other\"></span> is not met. Lines: where they go, a dot each second; \
         dashed: predicted, but not followed; dotted red: the run-out after a heavy contact. \
         ⊗ contact. Where a struck party goes is not computed: it is shown where it was struck. \
         Bodies outside of the picture are not shown.</p></section>",
    );
}

/// Every contact of a candidate.
fn course(row: &CourseRow, body: &mut String) {
    let _w = write!(body, "<section><h2>{}</h2><p>{}</p>", bdi(&row.name), happens(row));
    for one in &row.contacts {
        contact(one, body);
    }
    for run_out in &row.run_outs {
        let [x, y] = run_out.velocity_m_s;
        let _w = write!(
            body,
            "<p>Run-out from {:.2} s at {:.1} m/s: {:.1} m until it stands.</p>",
            run_out.from_s,
            x.hypot(y),
            run_out.length_m
        );
    }
    if row.contacts.len() > 1 {
        let said = row.persons.iter().map(|one| {
            let (work, range) = (one.work, one.range);
            let risk = share(work.lo(), work.hi());
            let range = format!("{}–{}", percent(range.low()), percent(range.high()));
            format!("{}: {risk} % ({range} %)", who(&one.party, one.seat))
        });
        let said: Vec<String> = said.collect();
        let _w = write!(body, "<p>All contacts together: {}.</p>", said.join("; "));
    }
    for remark in &row.remarks {
        let _w = write!(body, "<p class=\"remark\">Note: {}.</p>", name(remark));
    }
    body.push_str("</section>");
}

/// "bus, rear left", "pedestrian".
fn who(party: &str, seat: Option<&str>) -> String {
    let seat = seat.map(|seat| format!(", {}", seat.replace('-', " ")));
    format!("{}{}", bdi(party), seat.unwrap_or_default())
}

fn contact(contact: &ContactRow, body: &mut String) {
    let _w = write!(
        body,
        "<div class=\"contact\"><p><b>{:.2} s: {}</b>, {}{}; {}</p>",
        contact.time_s,
        bdi(&contact.party),
        severity(contact.severity),
        if contact.is_certain { "" } else { ", possible" },
        name(&contact.sides)
    );
    if contact.unevaluable.is_some() {
        body.push_str("<p>It cannot be evaluated: what comes of it is not known.</p>");
    }
    let delta = |side: usize| {
        let delta = &contact.delta_v_m_s[side];
        let (low, high) = (delta.range.low(), delta.range.high());
        format!("{:.1} m/s ({low:.1}–{high:.1})", delta.work.hi())
    };
    let other = if contact.is_other_fixed { "fixed".to_owned() } else { delta(1) };
    let _w = write!(
        body,
        "<p>Closing {:.1} m/s; ΔV ego {}, other {other}.</p>",
        contact.closing_m_s,
        delta(0)
    );
    for person in &contact.persons {
        let _w = write!(
            body,
            "<p>{}: {} % risk, model range {}–{} %{}.</p>",
            who(&person.party, person.seat),
            share(person.work.lo(), person.work.hi()),
            percent(person.range.low()),
            percent(person.range.high()),
            if person.extrapolated { ", beyond the speeds of the curve's sample" } else { "" }
        );
    }
    let parts = |side: usize| match contact.parts[side].as_slice() {
        [] => "–".to_owned(),
        parts => name(&parts.join(", ")),
    };
    let mut curves: Vec<&str> = contact.persons.iter().map(|one| one.curve.as_str()).collect();
    curves.sort_unstable();
    curves.dedup();
    let _w = write!(
        body,
        "<details><summary>Details</summary><p>Touches at {:.6} s, first in this crash at {:.6} s; \
         nothing touches before {:.6} s. Triangles {} and {} touch first. Until the contact is \
         complete {} triangles of the ego and {} of the other are hit; parts: {} and {}. Energy \
         lost: {:.1} to {:.1} kJ. Curves: {}.</p></details></div>",
        contact.time_s,
        contact.first_touch_s,
        contact.excluded_before_s,
        contact.triangles[0],
        contact.triangles[1],
        contact.hits[0],
        contact.hits[1],
        parts(0),
        parts(1),
        1e-3 * contact.energy_j.lo(),
        1e-3 * contact.energy_j.hi(),
        if curves.is_empty() { "–".to_owned() } else { name(&curves.join(", ")) }
    );
}

/// The contacts in 3D; the text remains without JavaScript.
fn touching(shots: &[Shot], body: &mut String) {
    if shots.is_empty() {
        return;
    }
    body.push_str(
        "<section><h2>What touches</h2><div id=\"tabs\" role=\"tablist\"></div>\
         <div id=\"view\"><noscript>The 3D view needs JavaScript.</noscript></div>\
         <p id=\"caption\"></p><p class=\"key\"><span class=\"ego\"></span> ego \
         <span class=\"other\"></span> the other <span class=\"hit\"></span> triangles that \
         intersect anywhere from first contact on <span class=\"patch\"></span> the contact patch. \
         Drag to rotate, wheel to zoom, right button to pan.</p></section>",
    );
}

/// Build, times, transfer and hashes.
fn engineers(page: &PlanPage<'_>, body: &mut String) {
    let PlanPage { answer, work, .. } = page;
    body.push_str(
        "<section><h2>For engineers</h2><details><summary>Build, times, transfer and hashes\
         </summary><h3>Stages</h3>",
    );
    body.push_str(&chart::stages(&work.stages));
    if work.workers.iter().any(|worker| !worker.spans.is_empty()) {
        body.push_str("<h3>Jobs on each worker</h3>");
        body.push_str(&chart::workers(&work.workers));
    }
    if !work.edges.is_empty() {
        body.push_str(
            "<h3>Transfer by edge</h3><table><thead><tr><th>from</th><th>to</th>\
             <th class=\"n\">messages</th><th class=\"n\">bytes</th></tr></thead><tbody>",
        );
        for (from, to, messages, bytes) in &work.edges {
            let _w = write!(
                body,
                "<tr><td>{}</td><td>{}</td><td class=\"n\">{messages}</td><td class=\"n\">{bytes}\
                 </td></tr>",
                name(from),
                name(to)
            );
        }
        body.push_str("</tbody></table>");
    }
    body.push_str("<h3>Facts</h3><table class=\"facts\"><tbody>");
    let mut fact = |term: &str, text: &str| {
        let _w = write!(body, "<tr><th>{}</th><td>{}</td></tr>", name(term), name(text));
    };
    for (term, text) in &work.facts {
        fact(term, text);
    }
    for row in &answer.ranking {
        for contact in &row.contacts {
            let term = format!("{}, {:.2} s {}", row.name, contact.time_s, contact.party);
            fact(&term, &format!("{} {}", contact.hashes[0], contact.hashes[1]));
        }
    }
    body.push_str(
        "</tbody></table><p class=\"key\">Hashes of contacts are of the sets of hit triangles: of \
         the ego, of the other.</p></details><p class=\"key\">Risks are statistics of populations, \
         not predictions for individuals.</p></section>",
    );
}

#[cfg(test)]
mod tests;
