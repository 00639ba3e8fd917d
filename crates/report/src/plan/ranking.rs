//! The table of candidates: whom each meets, its harm and range, and why it comes before the next.

use super::course::is_nothing;
use super::members::{self, Colours};
use super::{bdi, name, severity};
use crate::html::{chart, span};
use std::fmt::Write as _;
use trolley::{CourseRow, ExpectedRow, MetRow};

/// The table; rows of which there is nothing to tell are one line, but for the first.
pub(super) fn ranking(rows: &[(usize, &CourseRow)], body: &mut String) {
    let colours = Colours::of(rows);
    let top = rows.iter().map(|(_, row)| row.range.high().max(row.work.hi())).fold(0.0, f64::max);
    body.push_str(
        "<section><h2>The ranking</h2><div class=\"wide\"><table class=\"ranking\"><thead>\
         <tr><th>#</th><th>candidate</th><th>meets</th><th class=\"n\">harm %</th>\
         <th class=\"n\">range %</th><th>why before the next</th></tr></thead><tbody>",
    );
    let is_folded = |at: usize, row: &CourseRow| at > 0 && is_nothing(row);
    let folded: Vec<(usize, &CourseRow)> = rows
        .iter()
        .enumerate()
        .filter(|(at, (_, row))| is_folded(*at, row))
        .map(|(_, row)| *row)
        .collect();
    for (at, (place, row)) in rows.iter().enumerate() {
        if !is_folded(at, row) {
            line(*place, row, &colours, top, body);
        } else if folded.first().is_some_and(|(first, _)| first == place) {
            fold(&folded, body);
        }
    }
    body.push_str("</tbody></table></div>");
    if rows.iter().any(|(_, row)| row.expected.is_some()) {
        body.push_str(
            "<p class=\"key\">Harm is the mean over members, draws of what is known only up to \
             errors, ± its sampling error.</p>",
        );
    }
    body.push_str(
        "<p class=\"key\">#: the place under the policy. harm: the policy's \
         leading measure; the range is that of what the model does not know, the bar shows both \
         on a scale of square roots. heavy: the ego leaves its path and runs out; light: it drives \
         on.</p></section>",
    );
}

/// The line that stands for rows of which there is nothing to tell.
fn fold(folded: &[(usize, &CourseRow)], body: &mut String) {
    let places: Vec<usize> = folded.iter().map(|(place, _)| place + 1).collect();
    let (first, last) = (places[0], places[places.len() - 1]);
    let said = match places.len() {
        1 => first.to_string(),
        count if last - first + 1 == count => format!("{first}–{last}"),
        _ => String::new(),
    };
    let names: Vec<String> = folded.iter().map(|(_, row)| bdi(&row.name)).collect();
    let _w = write!(
        body,
        "<tr class=\"fold\"><td>{said}</td><td colspan=\"5\">{} more {} nobody within \
         the range: {}</td></tr>",
        folded.len(),
        if folded.len() == 1 { "touches nobody, and harms" } else { "touch nobody, and harm" },
        names.join("; ")
    );
}

fn line(place: usize, row: &CourseRow, colours: &Colours<'_>, top: f64, body: &mut String) {
    let of_members = row.expected.as_ref().map(|of| meets_in_members(of, colours));
    let mut meets: Vec<String> = row
        .contacts
        .iter()
        .map(|contact| {
            let possible = if contact.is_certain { "" } else { ", possible" };
            let (party, kind) = (bdi(&contact.party), severity(contact.severity));
            format!("{:.2}\u{a0}s {party}, {kind}{possible}", contact.time_s)
        })
        .collect();
    match row.open_from_s {
        Some(from_s) => meets.push(format!("not known after {from_s:.2}\u{a0}s")),
        None if row.expected.is_some() => {}
        None if row.touches_nobody() => meets.push("nobody".to_owned()),
        None if meets.is_empty() && row.is_stated_alone => {
            meets.push("nobody, as stated".to_owned());
        }
        None if meets.is_empty() => meets.push("nobody after the start".to_owned()),
        None => {}
    }
    let _w = write!(
        body,
        "<tr><td>{}</td><td>{}</td><td>{}</td><td class=\"n\">{}</td>\
         <td class=\"n\">{}<br>{}</td><td>{}</td></tr>",
        place + 1,
        bdi(&row.name),
        of_members.unwrap_or_else(|| meets.join("<br>")),
        members::harm(row),
        span(row.range.low(), row.range.high()),
        chart::whisker([row.work.lo(), row.work.hi()], [row.range.low(), row.range.high()], top),
        row.why.as_ref().map_or(String::new(), |why| name(why)),
    );
}

/// Whom a candidate meets in how many members.
fn meets_in_members(expected: &ExpectedRow, colours: &Colours<'_>) -> String {
    let met = |met: &MetRow| {
        let share = 100.0 * met.probability;
        let swatch = chart::swatch(colours.of_party(&met.party));
        format!(
            "{swatch} {} {share:.0}\u{a0}%, from\u{a0}{:.2}\u{a0}s",
            bdi(&met.party),
            met.from_s
        )
    };
    let mut lines: Vec<String> = expected.meets.iter().map(met).collect();
    if expected.open > 0 {
        lines.push(format!("not known in {} members", expected.open));
    } else if lines.is_empty() {
        lines.push("nobody in any member".to_owned());
    }
    lines.join("<br>")
}
