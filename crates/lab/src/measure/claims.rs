//! The paper's claims about shape, each compared with the data.
//!
//! The paper (Wiseman and Grinberg 2018, Figures 8 and 9) publishes no numbers; these are readings
//! of its figures. They are about four cores, so they rest on the simulation: transfer is exact
//! there for its order of results, time is a prediction.

use super::row::{Mode, Row};
use super::swept::Swept;
use scenario::Scheme;
use serde::Serialize;
use trolley::dispatch_options::TransferMode;

/// Speed-ups closer than this count as equal.
const SAME: f64 = 0.02;

/// One claim and its result.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Claim {
    pub(crate) letter: char,
    pub(crate) claim: &'static str,
    /// `None`: the data is insufficient.
    pub(crate) holds: Option<bool>,
    pub(crate) data: String,
}

/// One curve: values by depth, for one scheme and way of transfer, on virtual cores.
pub(crate) fn curve<'s>(
    swept: &'s Swept,
    scheme: Scheme,
    transfer: TransferMode,
    value: impl Fn(&Row) -> Option<f64> + 's,
) -> Vec<(u32, Option<f64>)> {
    let standard = super::calibrate::QUEUES;
    let rows = swept
        .rows
        .iter()
        .filter(move |row| row.mode == Mode::SimulatedOwnCore && row.queue == standard.capacity);
    let rows = rows.filter(|row| row.scheme == scheme && row.transfer == transfer);
    rows.map(|row| (row.depth, value(row))).collect()
}

/// The depth with the greatest speed-up of Best Match-Load, and that speed-up.
pub(crate) fn best_depth(swept: &Swept) -> Option<(u32, f64)> {
    let curve = curve(swept, Scheme::BestMatchLoad, TransferMode::ZeroCopy, |row| row.speed_up);
    let known = curve.into_iter().filter_map(|(depth, value)| Some((depth, value?)));
    known.max_by(|a, b| a.1.total_cmp(&b.1))
}

fn at(swept: &Swept, scheme: Scheme, depth: u32, value: fn(&Row) -> Option<f64>) -> Option<f64> {
    let curve = curve(swept, scheme, TransferMode::ZeroCopy, value);
    curve.into_iter().find(|(known, _)| *known == depth)?.1
}

/// All claims, over all pairs; pairs of the same bodies come deep first.
pub(crate) fn claims(swept: &[Swept]) -> Vec<Claim> {
    let all = [less_travels, interior, deeper, grows, thrashes, buffer, faster].map(|of| of(swept));
    let is_swept = |scheme: &Scheme| {
        swept.iter().all(|pair| pair.rows.iter().any(|row| row.scheme == *scheme))
    };
    // Schemes left out decide nothing.
    let judged = |claim: Claim| match needed(claim.letter).iter().all(is_swept) {
        true => claim,
        false => Claim { holds: None, data: "not all schemes were swept".to_owned(), ..claim },
    };
    all.into_iter().map(judged).collect()
}

/// The schemes that a claim is about.
fn needed(letter: char) -> &'static [Scheme] {
    use Scheme::{BestMatch, BestMatchLoad, LowestMatch, RandomMatch};
    match letter {
        'a' => &[BestMatch, RandomMatch, LowestMatch],
        'd' => &[BestMatchLoad, BestMatch, RandomMatch],
        'e' | 'g' => &[BestMatchLoad, BestMatch, RandomMatch, LowestMatch],
        _ => &[BestMatchLoad],
    }
}

/// A claim that must hold for each pair.
fn each(
    letter: char,
    claim: &'static str,
    swept: &[Swept],
    of: impl Fn(&Swept) -> (bool, String),
) -> Claim {
    let found: Vec<(bool, String)> = swept.iter().map(of).collect();
    let data = swept.iter().zip(&found).map(|(pair, (_, data))| format!("{}: {data}", pair.pair));
    let data = data.collect::<Vec<_>>().join("; ");
    let holds = (!found.is_empty()).then(|| found.iter().all(|(holds, _)| *holds));
    Claim { letter, claim, holds, data }
}

/// Depths in brackets.
fn list(depths: &[u32]) -> String {
    let depths: Vec<String> = depths.iter().map(u32::to_string).collect();
    format!("[{}]", depths.join(", "))
}

fn less_travels(swept: &[Swept]) -> Claim {
    let claim = "transfer: best match ≤ random match ≤ lowest match at every depth";
    each('a', claim, swept, |pair| {
        let [best, random, lowest] = [Scheme::BestMatch, Scheme::RandomMatch, Scheme::LowestMatch]
            .map(|scheme| {
                curve(pair, scheme, TransferMode::ZeroCopy, |row| row.relative_to_models)
            });
        let all = best.iter().zip(&random).zip(&lowest);
        let bad: Vec<u32> = all
            .filter(|((best, random), lowest)| !(best.1 <= random.1 && random.1 <= lowest.1))
            .map(|((best, _), _)| best.0)
            .collect();
        let data = match bad.as_slice() {
            [] => "at every depth".to_owned(),
            bad => format!("not at depths {}", list(bad)),
        };
        (bad.is_empty(), data)
    })
}

fn interior(swept: &[Swept]) -> Claim {
    each('b', "speed-up has an interior best depth", swept, |pair| {
        let depths = curve(pair, Scheme::BestMatchLoad, TransferMode::ZeroCopy, |row| row.speed_up);
        let Some((best, speed_up)) = best_depth(pair) else { return (false, String::new()) };
        let ends = [depths.first(), depths.last()].map(|end| end.map(|(depth, _)| *depth));
        let is_interior = !ends.contains(&Some(best));
        (is_interior, format!("{speed_up:.2} at depth {best}"))
    })
}

fn deeper(swept: &[Swept]) -> Claim {
    let claim = "that depth is deeper for the pair with the larger contact";
    let (mut data, mut holds) = (Vec::new(), None);
    for [deep, scratch] in couples(swept) {
        let (Some((one, _)), Some((other, _))) = (best_depth(deep), best_depth(scratch)) else {
            continue;
        };
        holds = Some(holds.unwrap_or(true) && one > other);
        data.push(format!("{} {one}, {} {other} (the paper: 12 and 10)", deep.pair, scratch.pair));
    }
    Claim { letter: 'c', claim, holds, data: data.join("; ") }
}

/// Pairs of the same bodies: with substantial damage, and with scratches.
pub(crate) fn couples(swept: &[Swept]) -> Vec<[&Swept; 2]> {
    let couple = |deep: &'_ Swept| -> Option<usize> {
        let stem = deep.pair.strip_suffix("-deep")?;
        swept.iter().position(|other| other.pair.strip_suffix("-scratch") == Some(stem))
    };
    swept.iter().filter_map(|deep| Some([deep, &swept[couple(deep)?]])).collect()
}

fn grows(swept: &[Swept]) -> Claim {
    let claim = "best match's gain over random match grows with the model";
    let gain = |pair: &Swept| {
        let (depth, _) = best_depth(pair)?;
        let value = |scheme| at(pair, scheme, depth, |row| row.relative_to_models);
        Some(value(Scheme::RandomMatch)? / value(Scheme::BestMatch)?)
    };
    let mut gains: Vec<(usize, f64, &str)> = Vec::new();
    for pair in swept.iter().filter(|pair| pair.pair.ends_with("-deep")) {
        if let Some(gain) = gain(pair) {
            gains.push((pair.triangles.iter().sum(), gain, &pair.pair));
        }
    }
    gains.sort_by_key(|gain| gain.0);
    let data = gains.iter().map(|(_, gain, pair)| format!("{pair} × {gain:.2}"));
    let data = data.collect::<Vec<_>>().join("; ");
    let holds = (gains.len() > 1).then(|| gains.windows(2).all(|pair| pair[0].1 < pair[1].1));
    Claim { letter: 'd', claim, holds, data }
}

fn thrashes(swept: &[Swept]) -> Claim {
    let claim = "when sections are copied, only random and lowest match run out of memory, and \
                 only at low depth";
    each('e', claim, swept, |pair| {
        let mut data = Vec::new();
        let mut holds = true;
        let copying =
            [Scheme::BestMatchLoad, Scheme::BestMatch, Scheme::RandomMatch, Scheme::LowestMatch];
        for scheme in copying {
            let curve = curve(pair, scheme, TransferMode::Copy, |row| row.speed_up);
            let out: Vec<u32> =
                curve.iter().filter(|(_, value)| value.is_none()).map(|(d, _)| *d).collect();
            let is_low = curve.iter().take(out.len()).all(|(depth, _)| out.contains(depth));
            let may = matches!(scheme, Scheme::RandomMatch | Scheme::LowestMatch);
            holds &= out.is_empty() || (may && is_low && out.len() < curve.len());
            if !out.is_empty() {
                data.push(format!("{} at depths {}", scheme.name(), list(&out)));
            }
        }
        (holds, if data.is_empty() { "nobody runs out".to_owned() } else { data.join(", ") })
    })
}

fn buffer(swept: &[Swept]) -> Claim {
    let claim = "speed-up rises with the buffer, then saturates (simulated; measured with two \
                 workers in brackets)";
    each('f', claim, swept, |pair| {
        let Some((depth, _)) = best_depth(pair) else { return (false, String::new()) };
        let rows_of = |mode: Mode, workers: u8| {
            let rows = pair.rows.iter().filter(move |row| {
                (row.mode, row.workers, row.depth) == (mode, workers, depth)
                    && (row.scheme, row.transfer) == (Scheme::BestMatchLoad, TransferMode::ZeroCopy)
            });
            let mut all: Vec<(u32, f64)> =
                rows.filter_map(|row| Some((row.queue, row.speed_up?))).collect();
            all.sort_by_key(|(queue, _)| *queue);
            all
        };
        let (simulated, measured) =
            (rows_of(Mode::SimulatedOwnCore, super::sweep::CORES), rows_of(Mode::Measured, 2));
        let most = simulated.iter().map(|(_, value)| *value).fold(0.0, f64::max);
        let full = simulated.iter().position(|(_, value)| *value >= most * (1.0 - SAME));
        let full = full.unwrap_or(0);
        let rises = simulated[..=full.min(simulated.len().saturating_sub(1))]
            .windows(2)
            .all(|two| two[0].1 <= two[1].1 * (1.0 + SAME));
        let stays = simulated[full..].iter().all(|(_, value)| *value >= most * (1.0 - 3.0 * SAME));
        let data = simulated.iter().map(|(queue, value)| {
            let real = measured.iter().find(|(known, _)| known == queue);
            let real = real.map_or(String::new(), |(_, value)| format!(" ({value:.2})"));
            format!("{queue}: {value:.2}{real}")
        });
        (rises && stays && full > 0, data.collect::<Vec<_>>().join(", "))
    })
}

fn faster(swept: &[Swept]) -> Claim {
    let claim = "speed-up: best match ≥ random match ≥ lowest match at the best depth";
    each('g', claim, swept, |pair| {
        let Some((depth, _)) = best_depth(pair) else { return (false, String::new()) };
        let [best, random, lowest] = [Scheme::BestMatch, Scheme::RandomMatch, Scheme::LowestMatch]
            .map(|scheme| at(pair, scheme, depth, |row| row.speed_up).unwrap_or(f64::NAN));
        let data = format!("{best:.3}, {random:.3}, {lowest:.3} at depth {depth}");
        (best >= random && random >= lowest, data)
    })
}
