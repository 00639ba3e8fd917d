//! The page of a ranking: the answer in words, the scene from above with a slider over time, what
//! touches in 3D, the ranking, every contact in words, the chain of figures, and how the work was
//! done. A single file that fetches nothing.

use crate::html::{chart, data_element, escape, framed, percent, view_scripts};
use crate::pack;
use crate::shot::{Shot, ShotBody};
use crate::work::WorkDone;
use serde_json::json;
use std::fmt::Write as _;
use trolley::plan::PlanScene;
use trolley::{Answer, CourseRow, Severity};

mod course;
mod drawing;
mod head;
mod labels;
mod members;
mod ranking;
mod spread;

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
    /// What touches in 3D, and where those who meet nobody come nearest.
    pub shots: &'a [Shot],
    /// The chain from contact to rank, as text, if there is one.
    pub explanation: Option<&'a str>,
}

pub(crate) use course::in_words;

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

/// How far apart two bodies are that do not touch: never 0.
pub(crate) fn apart(gap_m: f64) -> String {
    if gap_m < 0.005 { "under 0.01 m".to_owned() } else { format!("{gap_m:.2} m") }
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

/// A sentence, or, where it lists many, a line that says how many and opens.
fn folded(text: &str, count: usize, what: &str) -> String {
    if count <= 4 {
        return format!(" {text}");
    }
    format!("<details><summary>{count} more {what}</summary>{text}</details>")
}

/// What the page says of its first candidate, and whether that does least harm for all that is
/// known.
pub(crate) fn verdict(answer: &Answer) -> (String, bool) {
    let rows = rows(answer);
    let is_first = rows.first().is_some_and(|(place, _)| *place == 0);
    (head::title(&rows, answer), is_first && head::is_least_harm(answer))
}

/// The page.
#[must_use]
pub fn page(page: &PlanPage<'_>) -> String {
    let PlanPage { answer, scene, .. } = page;
    let rows = rows(answer);
    let title = head::title(&rows, answer);
    let mut body = String::new();
    head::head(page, &rows, &title, &mut body);
    // The candidates of the scene stand in the scenario's order.
    let number = |name: &str| scene.courses.iter().position(|one| one.name == name);
    let order: Vec<(usize, &CourseRow)> =
        rows.iter().filter_map(|(_, row)| Some((number(&row.name)?, *row))).collect();
    let window = drawing::PlanWindow::of(scene);
    view(scene, &window, &order, &mut body);
    touching(page.shots, &mut body);
    ranking::ranking(&rows, &mut body);
    members::members(answer, &rows, &mut body);
    course::courses(page, &window, &rows, &mut body);
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
    // The shots of the first candidate come first.
    let place = |shot: &&Shot| rows.iter().position(|(_, row)| row.name == shot.candidate);
    let mut shots: Vec<&Shot> = page.shots.iter().collect();
    shots.sort_by_key(place);
    let (bodies, shots) = pack::pack(page.bodies, &shots, number);
    let data = json!({"scene": scene, "view": window, "bodies": bodies, "shots": shots});
    let mut scripts = format!("{}<script>{SCRIPT}</script>", data_element(&data.to_string()));
    if !page.shots.is_empty() {
        scripts.push_str(&view_scripts());
    }
    framed(&title, &body, STYLE, &scripts)
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
    body.push_str(&drawing::svg(scene, window, *shown, drawing::Use::Screen, &title));
    if !scene.members.is_empty() {
        let _w = write!(
            body,
            "<p class=\"key\">Thin lines: the paths of {} members, draws of where everybody may \
             really be and go; red dots: where these touch; small dots: where each is at the time \
             above.</p>",
            scene.members.len()
        );
    }
    body.push_str(
        "<noscript><p class=\"key\">Shown is the first candidate at the start; the other ones, and \
         other times, need JavaScript.</p></noscript><p class=\"key\"><span \
         class=\"swatch-ego\"></span> ego <span class=\"swatch-met\"></span> is met <span \
         class=\"swatch-other\"></span> is not met. Lines: where they go, a dot each second; \
         dashed: predicted, but not followed; dotted red: the run-out after a heavy contact. \
         ⊗ contact; dashed outlines: where it comes nearest, \
         and the gap there. Where a struck party goes is not \
         computed: it is shown where it was struck. Bodies outside of the picture are not \
         shown.</p></section>",
    );
}

/// The contacts in 3D; the text remains without JavaScript.
fn touching(shots: &[Shot], body: &mut String) {
    if shots.is_empty() {
        return;
    }
    body.push_str(
        "<section class=\"solid\"><h2>In 3D</h2><div id=\"tabs\" role=\"tablist\"></div>\
         <div id=\"view\"><noscript>The 3D view needs JavaScript.</noscript></div>\
         <p id=\"caption\"></p><p class=\"key\"><span class=\"ego\"></span> ego \
         <span class=\"other\"></span> the other <span class=\"hit\"></span> triangles that \
         intersect anywhere from first contact on <span class=\"patch\"></span> the contact patch, \
         which a ring marks at every scale. Shown are contacts of the manoeuvre that is chosen \
         above, and where it comes nearest if it meets nobody. The grid on the ground is of 1 m. \
         Drag to rotate, wheel to zoom, right button to pan.</p></section>",
    );
}

/// Build, times, transfer and hashes.
fn engineers(page: &PlanPage<'_>, body: &mut String) {
    let PlanPage { answer, work, .. } = page;
    body.push_str(
        "<section class=\"engineers\"><h2>For engineers</h2><details><summary>Build, times, \
         transfer and hashes</summary>",
    );
    for remark in &work.remarks {
        let _w = write!(body, "<p class=\"remark\">Note: {}.</p>", name(remark));
    }
    body.push_str("<h3>Stages</h3>");
    // Charts show hundredths.
    let (seen, unseen): (Vec<_>, Vec<_>) =
        work.stages.iter().cloned().partition(|(_, ms)| *ms >= 0.005);
    body.push_str(&chart::stages(&seen));
    if !unseen.is_empty() {
        let names: Vec<String> = unseen.iter().map(|(stage, _)| name(stage)).collect();
        let _w = write!(body, "<p>Took no time: {}.</p>", names.join(", "));
    }
    if work.workers.iter().any(|worker| !worker.spans.is_empty()) {
        body.push_str("<h3>Jobs on each worker</h3>");
        body.push_str(&chart::workers(&work.workers));
    }
    if !work.edges.is_empty() {
        body.push_str(
            "<h3>Transfer by edge</h3><table><thead><tr><th>from</th><th>to</th>\
             <th class=\"n\">messages</th><th class=\"n\">bytes</th></tr></thead><tbody>",
        );
        let is_used = |edge: &&(String, String, u64, u64)| edge.2 > 0;
        for (from, to, messages, bytes) in work.edges.iter().filter(is_used) {
            let _w = write!(
                body,
                "<tr><td>{}</td><td>{}</td><td class=\"n\">{messages}</td><td class=\"n\">{bytes}\
                 </td></tr>",
                name(from),
                name(to)
            );
        }
        body.push_str("</tbody></table>");
        let unused = work.edges.len() - work.edges.iter().filter(is_used).count();
        if unused > 0 {
            let _w = write!(body, "<p>Edges without messages: {unused}.</p>");
        }
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
