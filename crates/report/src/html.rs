//! The page of a decision: the verdict, the 3D view, the engineering details, and the record's
//! hashes. A single file; its content security policy forbids fetching anything.

use crate::measurement::MeasurementPage;
use crate::pack;
use crate::shot::{Shot, ShotBody};
use serde_json::json;
use std::fmt::Write as _;

mod chart;

/// three.js, cut down and minified: `vendor/README.md`.
const THREE: &str = include_str!("../vendor/three.min.js");
/// Its licence.
const THREE_LICENCE: &str = include_str!("../vendor/three.LICENSE");
const STYLE: &str = include_str!("../page/style.css");
const SCRIPT: &str = include_str!("../page/view.js");

/// The contents of a page about a decision.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DecisionPage {
    /// Name of the scenario.
    pub scenario: String,
    /// State of the answer: complete, certified, degraded, refused.
    pub state: String,
    /// Candidates, least harm first.
    pub candidates: Vec<CandidateRow>,
    /// Names of the candidates that the model cannot distinguish from the first, which is included.
    pub ties: Vec<String>,
    /// The policy.
    pub policy: String,
    /// Its board.
    pub board: String,
    /// The severity that counts: "MAIS3+".
    pub outcome: String,
    /// Number of persons at stake.
    pub persons: usize,
    /// Assumptions, missing evidence and other remarks, as sentences.
    pub remarks: Vec<String>,
    /// The chain from contact to rank, as text.
    pub explanation: String,
    /// Stages and their times (ms).
    pub stages: Vec<(String, f64)>,
    /// Jobs done, not needed, given up.
    pub jobs: [u64; 3],
    /// Jobs by candidate of the request: its name, jobs done, jobs not needed.
    pub jobs_of: Vec<(String, u64, u64)>,
    /// What each worker did; empty if the record does not say.
    pub workers: Vec<Worker>,
    /// What was known over time.
    pub moments: Vec<TimelineMoment>,
    /// Names of the candidates as moments count them.
    pub names: Vec<String>,
    /// Bytes by edge: from, to, messages, bytes.
    pub edges: Vec<(String, String, u64, u64)>,
    /// Names and values at the end: build, hashes.
    pub facts: Vec<(String, String)>,
}

/// One row of the ranking.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CandidateRow {
    /// Its name.
    pub name: String,
    /// The other party.
    pub other: String,
    /// The sides that meet: "front ↔ rear", or why none do.
    pub contact: String,
    /// Whether they touch.
    pub touches: bool,
    /// Depth of the contact (m).
    pub depth_m: Option<f64>,
    /// Change of velocity of the ego and of the other (m/s); `None`: fixed, or no contact.
    pub delta_v_m_s: [Option<f64>; 2],
    /// Harm, over the work interval, 0 to 1.
    pub work: [f64; 2],
    /// Harm, over the range of the model, 0 to 1.
    pub range: [f64; 2],
    /// Why it comes before the next.
    pub why: Option<String>,
    /// Persons: who, risk over the work interval, risk over the range.
    pub persons: Vec<(String, [f64; 2], [f64; 2])>,
}

/// What one worker did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Worker {
    /// Its name.
    pub name: String,
    /// Its jobs.
    pub spans: Vec<TimelineSpan>,
}

/// One job on a worker (ms, from the start of the first).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimelineSpan {
    /// When it began.
    pub from_ms: f64,
    /// When its result was received.
    pub to_ms: f64,
}

/// What was known at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct TimelineMoment {
    /// Time since the start of the work (ms).
    pub at_ms: f64,
    /// Jobs closed by then.
    pub jobs: u64,
    /// Work interval of each candidate of the request.
    pub work: Vec<[f64; 2]>,
}

/// Text as markup.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            c if c.is_control() && c != '\n' => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}

/// A share in percent, with as many digits as are significant.
pub(crate) fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0".to_owned(),
        p if p < 0.01 => "&lt; 0.01".to_owned(),
        p if p < 10.0 => format!("{p:.2}"),
        p => format!("{p:.1}"),
    }
}

/// A page about a decision.
#[must_use]
pub fn decision(decision: &DecisionPage, bodies: &[ShotBody], shots: &[Shot]) -> String {
    let title = title(decision);
    let mut body = String::new();
    first_screen(decision, &title, &mut body);
    view(decision, shots, &mut body);
    persons(decision, &mut body);
    work(decision, &mut body);
    let _w = write!(
        body,
        "<section><h2>From contact to rank</h2><p>Every figure that decided, with its source, to \
         be checked by hand.</p><details><summary>Show the chain</summary><pre>{}</pre></details>\
         </section>",
        escape(&decision.explanation)
    );
    facts(&decision.facts, &mut body);
    let (packed, shots) = pack::pack(bodies, shots);
    let data = json!({"bodies": packed, "shots": shots});
    page(&title, &body, Some(&data.to_string()))
}

/// A page about a measurement.
#[must_use]
pub fn measurement(measurement: &MeasurementPage) -> String {
    page(&measurement.title, &measurement.markup(), None)
}

/// A page with the 3D view of `data`, if there is any.
fn page(title: &str, body: &str, data: Option<&str>) -> String {
    let scripts = data.map_or(String::new(), |data| {
        format!(
            "{}<script>{THREE}</script>\n<script>{SCRIPT}</script>\n\
             <details class=\"licence\"><summary>three.js 0.187.0, MIT licence</summary>\
             <pre>{}</pre></details>",
            data_element(data),
            escape(THREE_LICENCE)
        )
    });
    framed(title, body, "", &scripts)
}

/// The element that holds JSON for a script.
pub(crate) fn data_element(json: &str) -> String {
    // In JSON `<` occurs in strings only; escaped, it cannot end the script element.
    let data = json.replace('<', "\\u003c");
    format!("<script type=\"application/json\" id=\"data\">{data}</script>\n")
}

/// The frame of every page, with further style, and scripts at its end.
pub(crate) fn framed(title: &str, body: &str, style: &str, scripts: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src \
         'unsafe-inline'; script-src 'unsafe-inline'; img-src data:\">\n\
         <title>{}</title>\n<style>{STYLE}{style}</style>\n</head>\n<body>\n<main>\n{body}\n\
         </main>\n{scripts}\n</body>\n</html>\n",
        escape(title)
    )
}

fn title(decision: &DecisionPage) -> String {
    match decision.candidates.first() {
        Some(first) => format!("Least harm: {}", first.name),
        None => "Nothing to rank".to_owned(),
    }
}

/// Title, how sure, why, the ranking.
fn first_screen(decision: &DecisionPage, title: &str, body: &mut String) {
    let ways = decision.candidates.len();
    let touching = decision.candidates.iter().filter(|one| one.touches).count();
    let _w = write!(
        body,
        "<header><p class=\"asked\">{}. {ways} way{} left, {touching} of them {}. Which does \
         least harm?</p><h1>{}</h1><dl class=\"verdict\">",
        escape(decision.scenario.trim_end_matches('.')),
        if ways == 1 { " is" } else { "s are" },
        if touching == 1 { "a collision" } else { "collisions" },
        escape(title)
    );
    let mut say = |term: &str, text: String| {
        let _w = write!(body, "<dt>{term}</dt><dd>{text}</dd>");
    };
    if let Some(first) = decision.candidates.first() {
        let what = if first.touches {
            let worst = first.persons.iter().max_by(|a, b| a.1[1].total_cmp(&b.1[1]));
            let worst = worst.map_or(String::new(), |(who, work, range)| {
                format!(
                    " Worst off is {}: {} % risk of a serious injury ({}; model range {} to {} %).",
                    escape(who),
                    percent(work[1]),
                    escape(&decision.outcome),
                    percent(range[0]),
                    percent(range[1])
                )
            });
            let depth = first.depth_m.map_or(String::new(), |m| format!(", {m:.2} m deep"));
            format!("{}{depth}.{worst}", escape(&first.contact))
        } else {
            "It touches nothing: not one triangle of either body, anywhere on its way.".to_owned()
        };
        say("What happens", what);
        say("How sure", sureness(decision));
        let next = decision.candidates.get(1);
        if let (Some(why), Some(next)) = (&first.why, next) {
            say(
                "Why",
                format!(
                    "Its harm is {} %, that of the next, “{}”, {} %. In the policy's terms: {}.",
                    percent(first.work[1]),
                    escape(&next.name),
                    percent(next.work[1]),
                    escape(why.trim_end_matches('.'))
                ),
            );
        }
    }
    let board = match decision.board.as_str() {
        "" => String::new(),
        board => format!(" (board: {})", escape(board)),
    };
    say(
        "Whose rule",
        format!(
            "The policy “{}”{board}. {} person{} are at stake; harm is the policy's leading \
             measure, as a rule the mean probability of a serious injury ({}) over all of them.",
            escape(&decision.policy),
            decision.persons,
            if decision.persons == 1 { "" } else { "s" },
            escape(&decision.outcome)
        ),
    );
    body.push_str("</dl>");
    for remark in &decision.remarks {
        let _w = write!(body, "<p class=\"remark\">{}</p>", escape(remark));
    }
    body.push_str("</header>");
    ranking(decision, body);
}

/// The state, and whether another candidate could win within the range of the model.
fn sureness(decision: &DecisionPage) -> String {
    let [done, cut, lost] = decision.jobs;
    let state = match decision.state.as_str() {
        "complete" => format!(
            "<b>Complete.</b> All work is done: {} jobs{}.",
            done,
            if cut > 0 { format!(", {cut} more were not needed") } else { String::new() }
        ),
        "certified" => "<b>Certified.</b> Not all work is done, but none of the rest can change \
             the winner."
            .to_owned(),
        "degraded" => {
            format!("<b>Degraded.</b> Missing work ({lost} jobs given up) could change the winner.")
        }
        other => format!("<b>{}.</b>", escape(other)),
    };
    let first = decision.candidates.first().map_or("", |first| first.name.as_str());
    let others: Vec<&str> =
        decision.ties.iter().map(String::as_str).filter(|name| *name != first).collect();
    if others.is_empty() {
        return format!(
            "{state} No value within the ranges of the model (friction, restitution, masses, \
             injury curves) puts another one first."
        );
    }
    let names: Vec<String> = others.iter().map(|name| format!("“{}”", escape(name))).collect();
    format!(
        "{state} But what the model does not know (friction, restitution, masses, injury curves) \
         could put first: {}.",
        names.join(", ")
    )
}

fn ranking(decision: &DecisionPage, body: &mut String) {
    let top = decision.candidates.iter().map(|one| one.range[1].max(one.work[1]));
    let top = top.fold(0.0, f64::max);
    body.push_str(
        "<section><h2>The ranking</h2><div class=\"wide\"><table class=\"ranking\"><thead>\
         <tr><th>#</th><th>candidate</th><th>contact</th><th class=\"n\">depth m</th>\
         <th class=\"n\">ΔV ego / other m/s</th><th class=\"n\">harm %</th>\
         <th class=\"n\">range %</th><th>harm, with its range</th></tr></thead><tbody>",
    );
    for (at, one) in decision.candidates.iter().enumerate() {
        let number = |value: Option<f64>, digits: usize| {
            value.map_or("–".to_owned(), |value| format!("{value:.digits$}"))
        };
        let _w = write!(
            body,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{} / \
             {}</td><td class=\"n\">{}</td><td class=\"n\">{}–{}</td><td>{}</td></tr>",
            at + 1,
            escape(&one.name),
            escape(&one.contact),
            number(one.depth_m, 2),
            number(one.delta_v_m_s[0], 1),
            number(one.delta_v_m_s[1], 1),
            percent(one.work[1]),
            percent(one.range[0]),
            percent(one.range[1]),
            chart::whisker(one.work, one.range, top),
        );
    }
    body.push_str(
        "</tbody></table></div><p class=\"key\">harm: the policy's leading measure; the bar is its \
         range over what the model does not know, the mark its nominal value, on a scale of square \
         roots so that small risks show. ΔV: change of velocity. ↔ sides that meet, ∥ sides that \
         slide past each other.</p></section>",
    );
}

/// The 3D view; its text remains without JavaScript.
fn view(decision: &DecisionPage, shots: &[Shot], body: &mut String) {
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
    let _names = &decision.names;
}

fn persons(decision: &DecisionPage, body: &mut String) {
    body.push_str(
        "<section><h2>Who is hurt</h2><div class=\"wide\"><table><thead><tr><th>candidate</th>\
         <th>person</th><th class=\"n\">risk %</th><th class=\"n\">range %</th></tr></thead>\
         <tbody>",
    );
    for one in &decision.candidates {
        for (who, work, range) in &one.persons {
            let _w = write!(
                body,
                "<tr><td>{}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}–{}</td></tr>",
                escape(&one.name),
                escape(who),
                percent(work[1]),
                percent(range[0]),
                percent(range[1])
            );
        }
    }
    body.push_str(
        "</tbody></table></div><p class=\"key\">Risks are statistics of populations, not \
         predictions for individuals.</p></section>",
    );
}

/// Stages, jobs, workers, intervals over time, transfer.
fn work(decision: &DecisionPage, body: &mut String) {
    body.push_str("<section><h2>How the work was done</h2><h3>Stages</h3>");
    body.push_str(&chart::stages(&decision.stages));
    body.push_str("<h3>Jobs by candidate</h3>");
    body.push_str(&chart::jobs(&decision.jobs_of));
    body.push_str("<h3>Jobs on each worker</h3>");
    if decision.workers.iter().any(|worker| !worker.spans.is_empty()) {
        body.push_str(&chart::workers(&decision.workers));
    } else {
        body.push_str(
            "<p class=\"absent\">This record does not say which worker did which job when.</p>",
        );
    }
    body.push_str("<h3>How the intervals narrowed</h3>");
    if decision.moments.len() > 1 {
        body.push_str(&chart::moments(&decision.moments, &decision.names));
    } else {
        body.push_str(
            "<p class=\"absent\">This record holds only the final intervals, not their \
             history.</p>",
        );
    }
    body.push_str("<h3>Transfer by edge</h3>");
    if decision.edges.is_empty() {
        body.push_str("<p class=\"absent\">Nothing was sent, or the record does not say.</p>");
    } else {
        body.push_str(
            "<table><thead><tr><th>from</th><th>to</th><th class=\"n\">messages</th>\
             <th class=\"n\">bytes</th></tr></thead><tbody>",
        );
        for (from, to, messages, bytes) in &decision.edges {
            let _w = write!(
                body,
                "<tr><td>{}</td><td>{}</td><td class=\"n\">{messages}</td><td class=\"n\">{bytes}\
                 </td></tr>",
                escape(from),
                escape(to)
            );
        }
        body.push_str("</tbody></table>");
    }
    body.push_str("</section>");
}

fn facts(facts: &[(String, String)], body: &mut String) {
    body.push_str("<section><h2>The record</h2><table class=\"facts\"><tbody>");
    for (name, value) in facts {
        let _w = write!(body, "<tr><th>{}</th><td>{}</td></tr>", escape(name), escape(value));
    }
    body.push_str("</tbody></table></section>");
}

#[cfg(test)]
mod tests;
