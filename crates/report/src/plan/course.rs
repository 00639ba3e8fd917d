//! The candidates one by one: every contact in words and as a still.

use super::head::happens;
use super::{PlanPage, bdi, drawing, name, severity, share};
use crate::html::span;
use crate::pack::base64;
use crate::shot::Shot;
use crate::still::{self, Camera};
use std::fmt::Write as _;
use trolley::{ContactRow, CourseRow, PersonRow};

/// Pixels of a still on a page.
const STILL: [usize; 2] = [480, 320];

/// Whether there is nothing to tell of a candidate but that it touches nobody.
pub(super) fn is_nothing(row: &CourseRow) -> bool {
    row.touches_nobody()
        && row.range.high() == 0.0
        && row.work.hi() == 0.0
        && row.alternatives.is_empty()
}

/// All candidates in the order of the page. Of those after the first of which there is nothing to
/// tell, one line says so.
pub(super) fn courses(
    page: &PlanPage<'_>,
    window: &drawing::PlanWindow,
    rows: &[(usize, &CourseRow)],
    body: &mut String,
) {
    let is_folded = |at: usize, row: &CourseRow| at > 0 && is_nothing(row);
    for (at, (_, row)) in rows.iter().enumerate().filter(|(at, (_, row))| !is_folded(*at, row)) {
        course(page, window, at == 0, row, body);
    }
    let folded: Vec<&CourseRow> = rows
        .iter()
        .enumerate()
        .filter(|(at, (_, row))| is_folded(*at, row))
        .map(|(_, (_, row))| *row)
        .collect();
    if folded.is_empty() {
        return;
    }
    let names: Vec<String> = folded.iter().map(|row| bdi(&row.name)).collect();
    let _w = write!(
        body,
        "<section class=\"course\"><h2>{} more touch{} nobody</h2><details><summary>{}</summary>",
        folded.len(),
        if folded.len() == 1 { "es" } else { "" },
        names.join("; ")
    );
    for row in folded {
        let _w = write!(body, "<p><b>{}.</b> {}</p>", bdi(&row.name), happens(row));
        remarks(row, body);
    }
    body.push_str("</details></section>");
}

/// What else is known, each remark once: contacts may have the same.
fn remarks(row: &CourseRow, body: &mut String) {
    let is_new = |at: usize, remark: &String| !row.remarks[..at].contains(remark);
    for (_, remark) in row.remarks.iter().enumerate().filter(|(at, one)| is_new(*at, one)) {
        let _w = write!(body, "<p class=\"remark\">Note: {}.</p>", name(remark));
    }
}

/// A candidate.
fn course(
    page: &PlanPage<'_>,
    window: &drawing::PlanWindow,
    is_first: bool,
    row: &CourseRow,
    body: &mut String,
) {
    let _w = write!(
        body,
        "<section class=\"course\"><h2>{}</h2><p>{}</p>",
        bdi(&row.name),
        happens(row)
    );
    // On paper every candidate has its drawing; that of the first stands above.
    let number = page.scene.courses.iter().position(|course| course.name == row.name);
    if let Some(number) = number.filter(|_| !is_first) {
        let title = format!("The scene from above at the start, with the way of: {}", row.name);
        let drawn = drawing::svg(page.scene, window, number, drawing::Use::Paper, &title);
        let _w = write!(body, "<div class=\"paper\">{drawn}</div>");
    }
    let own = |shot: &&Shot| shot.candidate == row.name;
    if row.contacts.is_empty() {
        let mut nearest = page.shots.iter().filter(own).filter(|shot| !shot.is_contact());
        if let Some(still) = nearest.next().and_then(|shot| still(page, shot)) {
            let _w = write!(body, "<div class=\"nearest\">{still}</div>");
        }
    }
    let mut shots = page.shots.iter().filter(own).filter(|shot| shot.is_contact());
    for one in &row.contacts {
        let still = shots.next().and_then(|shot| still(page, shot));
        contact(one, still.as_deref(), body);
    }
    for run_out in &row.run_outs {
        let [x, y] = run_out.velocity_m_s;
        let _w = write!(
            body,
            "<p>Run-out from {:.2} s at {:.1} m/s: {} until it stands.</p>",
            run_out.from_s,
            x.hypot(y),
            if run_out.length_m < 0.05 {
                "under 0.1 m".to_owned()
            } else {
                format!("{:.1} m", run_out.length_m)
            }
        );
    }
    if row.contacts.len() > 1 {
        all_contacts(row, body);
    }
    remarks(row, body);
    body.push_str("</section>");
}

/// A shot as a picture in the page.
fn still(page: &PlanPage<'_>, shot: &Shot) -> Option<String> {
    let png = still::still(shot, page.bodies, Camera::Corner, STILL).ok()?;
    Some(format!(
        "<img class=\"still\" width=\"{}\" height=\"{}\" alt=\"{}\" \
         src=\"data:image/png;base64,{}\">",
        STILL[0],
        STILL[1],
        name(&shot.caption),
        base64(&png)
    ))
}

/// Everybody's risk over all contacts: of members these are means, and contacts are of the scene as
/// stated.
fn all_contacts(row: &CourseRow, body: &mut String) {
    let (harmed, unharmed): (Vec<_>, Vec<_>) =
        row.persons.iter().partition(|one| one.work.hi() > 0.0 || one.range.high() > 0.0);
    let of = if row.expected.is_some() { ", in the mean over members" } else { "" };
    let _w = write!(body, "<div class=\"together\"><p><b>All contacts together{of}</b></p>");
    for one in &harmed {
        let [work, range] = [[one.work.lo(), one.work.hi()], [one.range.low(), one.range.high()]];
        risk(who(&one.party, one.seat), work, range, "", body);
    }
    others(unharmed.len(), harmed.is_empty(), body);
    body.push_str("</div>");
}

/// A person's risk, and what the model does not know of it.
fn risk(who: String, work: [f64; 2], range: [f64; 2], remark: &str, body: &mut String) {
    let _w = write!(
        body,
        "<p>{who}: {} % risk, model range {} %{remark}.</p>",
        share(work[0], work[1]),
        span(range[0], range[1])
    );
}

/// The line about persons without any risk.
fn others(count: usize, is_all: bool, body: &mut String) {
    if let Some(line) = nobody_else(count, is_all) {
        let (first, rest) = line.split_at(1);
        let _w = write!(body, "<p>{}{rest}.</p>", first.to_uppercase());
    }
}

/// The line that stands for persons without any risk.
fn nobody_else(count: usize, is_all: bool) -> Option<String> {
    match (count, is_all) {
        (0, _) => None,
        (1, true) => Some("nobody is at risk (1 person)".to_owned()),
        (count, true) => Some(format!("nobody is at risk ({count} persons)")),
        (1, false) => Some("1 more person is at no risk".to_owned()),
        (count, false) => Some(format!("{count} more persons are at no risk")),
    }
}

/// "bus, rear left", "pedestrian".
fn who(party: &str, seat: Option<&str>) -> String {
    let seat = seat.map(|seat| format!(", {}", seat.replace('-', " ")));
    format!("{}{}", bdi(party), seat.unwrap_or_default())
}

/// Which sides meet, without signs: "front against rear", "left along wall".
pub(crate) fn in_words(sides: &str) -> String {
    sides.replace('↔', "against").replace('∥', "along")
}

fn contact(contact: &ContactRow, still: Option<&str>, body: &mut String) {
    let _w = write!(
        body,
        "<div class=\"contact\">{}<p><b>{:.2} s: {}</b>, {}{}; {}</p>",
        still.unwrap_or_default(),
        contact.time_s,
        bdi(&contact.party),
        severity(contact.severity),
        if contact.is_certain { "" } else { ", possible" },
        name(&in_words(&contact.sides))
    );
    if contact.unevaluable.is_some() {
        body.push_str("<p>It cannot be evaluated: what comes of it is not known.</p>");
    }
    let delta = |side: usize| {
        let delta = &contact.delta_v_m_s[side];
        let (low, high) = (delta.range.low(), delta.range.high());
        match high {
            0.0 => "none".to_owned(),
            high if high < 0.05 => "below 0.05 m/s".to_owned(),
            high => format!("{:.1} m/s ({low:.1}–{high:.1})", delta.work.hi()),
        }
    };
    let other = if contact.is_other_fixed { "fixed".to_owned() } else { delta(1) };
    let _w = write!(
        body,
        "<p>Closing {:.1} m/s; ΔV ego {}, other {other}.</p>",
        contact.closing_m_s,
        delta(0)
    );
    let is_harmed = |one: &&PersonRow| one.work.hi() > 0.0 || one.range.high() > 0.0;
    let (harmed, unharmed): (Vec<_>, Vec<_>) = contact.persons.iter().partition(is_harmed);
    for person in &harmed {
        let beyond =
            if person.extrapolated { ", beyond the speeds of the curve's sample" } else { "" };
        let work = [person.work.lo(), person.work.hi()];
        let range = [person.range.low(), person.range.high()];
        risk(who(&person.party, person.seat), work, range, beyond, body);
    }
    others(unharmed.len(), harmed.is_empty(), body);
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
