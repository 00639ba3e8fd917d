//! The table of candidates: whom each meets, its harm and range, and what members say.

use super::{bdi, name, severity, share};
use crate::html::{chart, percent};
use std::fmt::Write as _;
use trolley::{CourseRow, ExpectedRow, MemberRow, MetRow};

pub(super) fn ranking(rows: &[(usize, &CourseRow)], body: &mut String) {
    let all = || rows.iter().filter_map(|(_, row)| row.expected.as_ref());
    // A party has one colour in all candidates.
    let mut parties: Vec<&str> = all().flat_map(|of| &of.meets).map(|met| &*met.party).collect();
    parties.sort_unstable();
    parties.dedup();
    let top_of_members =
        all().flat_map(|of| &of.members).map(|member| member.harm).fold(0.0, f64::max);
    let top = rows.iter().map(|(_, row)| row.range.high().max(row.work.hi())).fold(0.0, f64::max);
    body.push_str(
        "<section><h2>The ranking</h2><div class=\"wide\"><table class=\"ranking\"><thead>\
         <tr><th>#</th><th>candidate</th><th>meets</th><th class=\"n\">harm %</th>\
         <th class=\"n\">range %</th><th>why before the next</th></tr></thead><tbody>",
    );
    for (place, row) in rows {
        let of_members = row.expected.as_ref().map(|of| members(of, &parties, top_of_members));
        let mut meets: Vec<String> = row
            .contacts
            .iter()
            .map(|contact| {
                let possible = if contact.is_certain { "" } else { ", possible" };
                let (party, kind) = (bdi(&contact.party), severity(contact.severity));
                format!("{:.2} s {party}, {kind}{possible}", contact.time_s)
            })
            .collect();
        match row.open_from_s {
            Some(from_s) => meets.push(format!("not known after {from_s:.2} s")),
            None if row.expected.is_some() => {}
            None if row.touches_nobody() => meets.push("nobody".to_owned()),
            None if meets.is_empty() => meets.push("nobody after the start".to_owned()),
            None => {}
        }
        let _w = write!(
            body,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td class=\"n\">{}</td>\
             <td class=\"n\">{}–{}<br>{}</td><td>{}</td></tr>",
            place + 1,
            bdi(&row.name),
            of_members.unwrap_or_else(|| meets.join("<br>")),
            harm(row),
            percent(row.range.low()),
            percent(row.range.high()),
            chart::whisker(
                [row.work.lo(), row.work.hi()],
                [row.range.low(), row.range.high()],
                top
            ),
            row.why.as_ref().map_or("–".to_owned(), |why| name(why)),
        );
    }
    body.push_str("</tbody></table></div>");
    if all().next().is_some() {
        body.push_str(
            "<p class=\"key\">Harm is the mean over members, draws of what is known only up to \
             errors, ± its sampling error. Bars: harm in each member, ascending, on a scale of \
             square roots, in the colour of who is met first. Pictures and contacts below are of \
             the scene as stated.</p>",
        );
    }
    body.push_str(
        "<p class=\"key\">#: the place under the policy. harm: the policy's \
         leading measure; the range is that of what the model does not know, the bar shows both \
         on a scale of square roots. heavy: the ego leaves its path and runs out; light: it drives \
         on.</p></section>",
    );
}

/// The leading measure, with its sampling error where it is a mean.
fn harm(row: &CourseRow) -> String {
    let harm = share(row.work.lo(), row.work.hi());
    let spread = row.expected.as_ref().and_then(|of| of.spread);
    match spread.filter(|spread| spread.error > 0.0) {
        Some(spread) => format!("{harm} ± {}", percent(spread.error)),
        None => harm,
    }
}

/// Whom a candidate meets in how many members, in how many it is best, and its strip.
fn members(expected: &ExpectedRow, parties: &[&str], top: f64) -> String {
    let number = |met: &MetRow| parties.iter().position(|party| *party == met.party);
    let met = |met: &MetRow| {
        let share = 100.0 * met.probability;
        let colour = number(met).map_or(String::new(), chart::swatch);
        format!("{colour} {} {share:.0} %, from {:.2} s", bdi(&met.party), met.from_s)
    };
    let mut lines: Vec<String> = expected.meets.iter().map(met).collect();
    if expected.open > 0 {
        lines.push(format!("not known in {} members", expected.open));
    } else if lines.is_empty() {
        lines.push("nobody in any member".to_owned());
    }
    lines.extend(expected.spread.map(|spread| {
        format!("best in {:.0} %, regret {} %", 100.0 * spread.best, percent(spread.regret))
    }));
    let first = |member: &MemberRow| member.first.and_then(|met| number(expected.meets.get(met)?));
    let strip: Vec<(f64, Option<usize>)> =
        expected.members.iter().map(|member| (member.harm, first(member))).collect();
    if !strip.is_empty() {
        lines.push(chart::strip(&strip, top, "Harm in each member, ascending"));
    }
    lines.join("<br>")
}
