//! The tables of candidates, and the sentences below them, whether the answer is one of this
//! process or of a service.

use crate::table::{percent, table};
use report::table::Column;
use trolley::Implausible;

/// A candidate in the scene as stated.
pub(crate) struct StatedRow<'a> {
    pub(crate) name: &'a str,
    /// Whom it meets, one a line.
    pub(crate) meets: String,
    /// Its place may owe to what is hardly true.
    pub(crate) is_marked: bool,
    /// Who is worst off, and that person's risk.
    pub(crate) worst: Option<(String, f64)>,
    /// The leading measure as far as the work is done: lo, hi.
    pub(crate) work: [f64; 2],
    /// The leading measure over the model range: low, high.
    pub(crate) range: [f64; 2],
}

/// A candidate over members.
pub(crate) struct ExpectedRow<'a> {
    pub(crate) name: &'a str,
    /// Whom it meets, with what probability, and from when on (s).
    pub(crate) meets: Vec<(&'a str, f64, f64)>,
    /// How many more it meets.
    pub(crate) more: usize,
    /// As in [`StatedRow::is_marked`].
    pub(crate) is_marked: bool,
    /// How many members are not followed to their end.
    pub(crate) open: u32,
    /// As in [`StatedRow::work`].
    pub(crate) work: [f64; 2],
    /// As in [`StatedRow::range`].
    pub(crate) range: [f64; 2],
    /// How the measure is spread, if that is known.
    pub(crate) spread: Option<Spread>,
    /// The share of worlds that it wins, if they were drawn.
    pub(crate) worlds: Option<f64>,
}

/// How the leading measure is spread over members.
pub(crate) struct Spread {
    /// Sampling error of its mean.
    pub(crate) error: f64,
    /// What it is below in 5 and in 95 % of the members.
    pub(crate) outer: [f64; 2],
    /// The share of members in which the candidate is best.
    pub(crate) best: f64,
}

/// The table of candidates in the scene as stated.
pub(crate) fn stated<'a>(rows: impl Iterator<Item = StatedRow<'a>>) -> String {
    const COLUMNS: [Column; 6] = [
        Column::numbers("#"),
        Column::words("candidate", 12),
        Column::words("meets", 24),
        Column::words("worst-off person", 14).dispensable(1),
        Column::numbers("harm %"),
        Column::figures("range %").dispensable(2),
    ];
    let rows = rows.enumerate().map(|(at, row)| {
        let worst = match row.worst {
            Some((who, risk)) if risk > 0.0 => format!("{who} {:.1} %", 100.0 * risk),
            _ => "–".to_owned(),
        };
        vec![
            (at + 1).to_string(),
            row.name.to_owned(),
            row.meets + mark(row.is_marked),
            worst,
            harm(row.work),
            range(row.range),
        ]
    });
    table(&COLUMNS, &rows.collect::<Vec<_>>())
}

/// The table of candidates over members.
pub(crate) fn expected<'a>(rows: impl Iterator<Item = ExpectedRow<'a>>) -> String {
    const COLUMNS: [Column; 8] = [
        Column::numbers("#"),
        Column::words("candidate", 12),
        Column::words("meets", 24),
        Column::figures("harm %"),
        Column::figures("5–95 %").dispensable(4),
        Column::figures("range %").dispensable(2),
        Column::numbers("best in").dispensable(1),
        Column::numbers("worlds").dispensable(3),
    ];
    let rows = rows.enumerate().map(|(at, row)| {
        let harm = match &row.spread {
            Some(spread) if spread.error > 0.0 => {
                format!("{} ± {}", harm(row.work), percent(spread.error))
            }
            _ => harm(row.work),
        };
        let spread =
            |text: &dyn Fn(&Spread) -> String| row.spread.as_ref().map_or("–".into(), text);
        vec![
            (at + 1).to_string(),
            row.name.to_owned(),
            expected_meets(&row) + mark(row.is_marked),
            harm,
            spread(&|s| range(s.outer)),
            range(row.range),
            spread(&|s| share(s.best)),
            row.worlds.map_or("–".into(), share),
        ]
    });
    table(&COLUMNS, &rows.collect::<Vec<_>>())
}

/// Whether the place of a candidate may owe to what is hardly true: that of the first, and of each
/// that meets somebody of whom it is.
pub(crate) fn is_marked<'a>(
    implausible: &[Implausible],
    is_first: bool,
    mut met: impl Iterator<Item = &'a str>,
) -> bool {
    let is_doubted =
        |party: &str| implausible.iter().any(|one| one.party.as_deref() == Some(party));
    (is_first && !implausible.is_empty()) || met.any(is_doubted)
}

/// What is hardly true, one a line.
pub(crate) fn implausible(all: &[Implausible]) -> impl Iterator<Item = String> {
    all.iter().map(|one| format!("IMPLAUSIBLE: {}", one.sentence()))
}

/// The line below whom a candidate meets, if it is marked.
fn mark(is_marked: bool) -> &'static str {
    if is_marked { "\n! implausible, see below" } else { "" }
}

/// "pole 25 % from 1.32 s" for each party, one a line.
fn expected_meets(row: &ExpectedRow<'_>) -> String {
    let met = |(party, probability, from_s): &(&str, f64, f64)| {
        format!("{party} {} from {from_s:.2} s", share(*probability))
    };
    let mut lines: Vec<String> = row.meets.iter().map(met).collect();
    if row.more > 0 {
        lines.push(format!("and {} more", row.more));
    }
    if row.open > 0 {
        lines.push(format!("not known in {} members", row.open));
    } else if lines.is_empty() {
        lines.push("nobody".to_owned());
    }
    lines.join("\n")
}

fn harm([lo, hi]: [f64; 2]) -> String {
    if lo.to_bits() == hi.to_bits() { percent(hi) } else { range([lo, hi]) }
}

fn range([low, high]: [f64; 2]) -> String {
    format!("{}–{}", percent(low), percent(high))
}

/// A share of members: "25 %".
pub(crate) fn share(of: f64) -> String {
    format!("{:.0} %", 100.0 * of)
}

/// "1.62 s pedestrian, light (0.8 m/s)"; in brackets the ego's change of velocity.
pub(crate) fn contact(
    time_s: f64,
    party: &str,
    kind: &str,
    ego_m_s: f64,
    is_certain: bool,
) -> String {
    let possible = if is_certain { "" } else { ", possible" };
    format!("{time_s:.2} s {party}, {kind} ({ego_m_s:.1} m/s){possible}")
}

/// "nobody; pedestrian 0.23 m away at 1.65 s".
pub(crate) fn nobody(nearest: Option<(&str, f64, f64)>) -> String {
    match nearest {
        Some((party, gap_m, time_s)) => {
            format!("nobody; {party} {gap_m:.2} m away at {time_s:.2} s")
        }
        None => "nobody".to_owned(),
    }
}

/// "pedestrian", "bus rear left".
pub(crate) fn worst_off(party: &str, seat: Option<&str>) -> String {
    let seat = seat.map(|seat| format!(" {}", seat.replace('-', " ")));
    format!("{party}{}", seat.unwrap_or_default())
}

/// What the numbers of a table over members are. `injured` are the persons expected to be injured
/// with the first, if that is known.
pub(crate) fn members(count: u32, replaced: u32, injured: Option<f64>) -> String {
    let replaced = match replaced {
        0 => String::new(),
        1 => "; 1 draw overlapped at 0 s and was replaced".to_owned(),
        count => format!("; {count} draws overlapped at 0 s and were replaced"),
    };
    let injured = injured.map_or(String::new(), |injured| {
        format!("; with the first, {injured:.4} persons are expected to be injured")
    });
    format!(
        "Harm is the mean over {count} members: draws of what is known only up to \
         errors{injured}{replaced}."
    )
}

/// How sure the first place is, if the second is known to be worse by so much, give or take its
/// sampling error.
pub(crate) fn lead(mean: f64, error: f64) -> Option<String> {
    let close = if mean.abs() < error { ", too close to call" } else { "" };
    (error > 0.0).then(|| {
        format!(
            "The second is {:.2} % worse in the mean, give or take {:.2} %: {:.1} times it{close}.",
            100.0 * mean,
            100.0 * error,
            mean.abs() / error
        )
    })
}

/// In how many worlds the first wins. `alone` says what would have another one win.
pub(crate) fn worlds(count: u32, won: f64, alone: Option<&str>) -> String {
    let alone = alone.map_or(String::new(), |alone| format!("; {alone}"));
    format!(
        "Of {count} worlds that the model allows it wins {}: draws of restitution, friction, \
         masses and curves{alone}.",
        share(won)
    )
}

/// What the first candidates have in common: `free` touch nobody, and `hits_nobody` says that one
/// at least only parts from somebody; `None` where nothing is known of members. `least` is the
/// sentence of who comes first.
pub(crate) fn first(free: &[&str], hits_nobody: Option<bool>, least: &str) -> String {
    match free {
        [] if hits_nobody.is_none() => format!("Known is the scene as stated alone.{least}"),
        [] if hits_nobody == Some(true) => {
            format!("No way is free of contact from the start on.{least}")
        }
        [] => format!("Every way hits somebody, as far as is known.{least}"),
        free => format!("Touches nobody until the end of its way: {}.", free.join("; ")),
    }
}

/// Who comes first: the least harm only where the model cannot take another one for as good.
pub(crate) fn least(name: &str, tied: usize) -> String {
    let who = if tied > 0 { format!("First of {} tied", tied + 1) } else { "Least harm".into() };
    format!(" {who}: {name}.")
}

/// Whom the model cannot tell from the first.
pub(crate) fn tied(others: &[&str]) -> Option<String> {
    let others = (!others.is_empty()).then(|| others.join("; "))?;
    Some(format!("Ranges of the model overlap with its own: {others}."))
}

#[cfg(test)]
mod tests {
    //! What is not known is no number.
    use super::*;

    #[test]
    fn what_is_not_known_is_a_dash_and_what_is_open_is_said() {
        let row = |spread: Option<Spread>, worlds: Option<f64>, open: u32| ExpectedRow {
            is_marked: false,
            name: "brake",
            meets: vec![("pole", 0.25, 1.5)],
            more: 2,
            open,
            work: [0.5, if open > 0 { 1.0 } else { 0.5 }],
            range: [0.0, 1.0],
            spread,
            worlds,
        };
        let spread = Spread { error: 0.125, outer: [0.25, 0.75], best: 0.5 };
        let known = expected([row(Some(spread), Some(0.75), 0)].into_iter());
        for words in ["pole 25 % from 1.50 s", "and 2 more", "50.00 ± 12.50", "25.00–75.00", "75 %"]
        {
            assert!(known.contains(words), "{words}: {known}");
        }
        assert!(!known.contains('–') || known.matches(" – ").count() == 0, "{known}");
        let open = expected([row(None, None, 3)].into_iter());
        assert!(open.contains("not known in 3 members") && open.contains("50.00–100.00"), "{open}");
        assert!(!open.contains("0 %"), "{open}");
        assert_eq!(lead(0.1, 0.0), None);
        assert!(lead(0.1, 0.2).is_some_and(|said| said.contains("too close")));
    }
}
