//! What members say of each candidate: a strip of its harm in all of them.

use super::{bdi, share};
use crate::html::{chart, percent, span};
use std::fmt::Write as _;
use trolley::{Answer, CourseRow, ExpectedRow, MemberRow};

/// The parties that are met first in some member, each of which has one colour on the page.
pub(super) struct Colours<'a>(Vec<&'a str>);

impl<'a> Colours<'a> {
    /// Those who are met first most often have colours of their own.
    pub(super) fn of(rows: &[(usize, &'a CourseRow)]) -> Self {
        let mut counts: Vec<(&str, usize)> = Vec::new();
        for of in rows.iter().filter_map(|(_, row)| row.expected.as_ref()) {
            for met in of.members.iter().filter_map(|member| of.meets.get(member.first?)) {
                match counts.iter_mut().find(|(party, _)| *party == met.party) {
                    Some((_, count)) => *count += 1,
                    None => counts.push((&met.party, 1)),
                }
            }
        }
        counts.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
        Self(counts.into_iter().map(|(party, _)| party).collect())
    }

    /// The colour of a party; that of all others, if it has none of its own.
    pub(super) fn of_party(&self, party: &str) -> &'static str {
        chart::colour_of(self.0.iter().position(|one| *one == party))
    }
}

/// The leading measure, with its sampling error where it is a mean.
pub(super) fn harm(row: &CourseRow) -> String {
    let harm = share(row.work.lo(), row.work.hi());
    let spread = row.expected.as_ref().and_then(|of| of.spread);
    match spread.filter(|spread| spread.error > 0.0) {
        Some(spread) => format!("{harm} ± {}", percent(spread.error)),
        None => harm,
    }
}

/// A share of members or worlds in whole percents; neither none nor all is said where it is not so.
pub(super) fn of_all(share: f64) -> String {
    match share {
        share if 0.0 < share && share < 0.005 => "&lt; 1 %".to_owned(),
        share if (0.995..1.0).contains(&share) => "&gt; 99 %".to_owned(),
        share => format!("{:.0} %", 100.0 * share),
    }
}

/// A strip for each candidate that harms anybody in some member, and one line about the others.
pub(super) fn members(answer: &Answer, rows: &[(usize, &CourseRow)], body: &mut String) {
    let Some(members) = &answer.members else { return };
    let known: Vec<(&CourseRow, &ExpectedRow)> = rows
        .iter()
        .filter_map(|(_, row)| Some((*row, row.expected.as_ref()?)))
        .filter(|(_, of)| !of.members.is_empty())
        .collect();
    if known.is_empty() {
        return;
    }
    let harms = known.iter().flat_map(|(_, of)| &of.members).map(|member| member.harm);
    let top = harms.fold(0.0, f64::max);
    let colours = Colours::of(rows);
    let is_harmless = |of: &ExpectedRow| of.members.iter().all(|member| member.harm == 0.0);
    body.push_str("<section><h2>Member by member</h2>");
    // Nothing to explain where there is no strip.
    if !known.iter().all(|(_, of)| is_harmless(of)) {
        let _w = write!(
            body,
            "<p class=\"key\">Harm in each of {} members, draws of where everybody may really be \
             and go, ascending, on a scale of square roots that all candidates share, in the \
             colour of who is met first. The line is the mean; regret: how much more harm than \
             the best one does, in the mean. Pictures and contacts are of the scene as stated.</p>\
             {}",
            members.count,
            legend(&colours)
        );
    }
    for (row, of) in known.iter().filter(|(_, of)| !is_harmless(of)) {
        strip(row, of, &colours, (top, rows.len() == 1), body);
    }
    let harmless: Vec<String> =
        known.iter().filter(|(_, of)| is_harmless(of)).map(|(row, _)| bdi(&row.name)).collect();
    if !harmless.is_empty() {
        let _w = write!(body, "<p>No harm in any member: {}.</p>", harmless.join("; "));
    }
    body.push_str("</section>");
}

fn legend(colours: &Colours<'_>) -> String {
    let own = chart::OWN_COLOURS;
    let mut said: Vec<String> = colours
        .0
        .iter()
        .take(own)
        .map(|party| format!("<b>{} {}</b>", chart::swatch(colours.of_party(party)), bdi(party)))
        .collect();
    if colours.0.len() > own {
        let rest = colours.0.len() - own;
        let what = if rest == 1 { "other" } else { "others" };
        said.push(format!("<b>{} {rest} {what}</b>", chart::swatch(chart::colour_of(None))));
    }
    said.push(format!("<b>{} nobody</b>", chart::swatch(chart::NOBODY)));
    format!("<p class=\"key legend\">{}</p>", said.join(" "))
}

/// A strip under `top`; one that is alone is compared with nobody.
fn strip(
    row: &CourseRow,
    of: &ExpectedRow,
    colours: &Colours<'_>,
    (top, is_alone): (f64, bool),
    body: &mut String,
) {
    let mut said = vec![format!("harm {} %", harm(row))];
    if let Some(spread) = of.spread {
        let [low, _, high] = spread.quantiles;
        said.push(format!("5–95 %: {} %", span(low, high)));
        if spread.best > 0.0 && !is_alone {
            said.push(format!("best in {}", of_all(spread.best)));
        }
        if spread.regret > 0.0 {
            said.push(format!("regret {} %", percent(spread.regret)));
        }
    }
    if let Some(worlds) = of.worlds.filter(|worlds| *worlds > 0.0 && !is_alone) {
        said.push(format!("wins in {} of worlds", of_all(worlds)));
    }
    let harmless = of.members.iter().filter(|member| member.harm == 0.0).count();
    if harmless > 0 {
        said.push(format!("no harm in {harmless} of {} members", of.members.len()));
    }
    let colour = |member: &MemberRow| match member.first {
        None => chart::NOBODY,
        Some(met) => of.meets.get(met).map_or(chart::NOBODY, |met| colours.of_party(&met.party)),
    };
    let bars: Vec<(f64, &str)> =
        of.members.iter().map(|member| (member.harm, colour(member))).collect();
    let title = format!("{}: harm in each member, ascending", row.name);
    let _w = write!(
        body,
        "<figure class=\"members\"><figcaption><b>{}</b>: {}</figcaption>{}</figure>",
        bdi(&row.name),
        said.join("; "),
        chart::strip(&bars, row.work.hi(), top, &super::name(&title))
    );
}
