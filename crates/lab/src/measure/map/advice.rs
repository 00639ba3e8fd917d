//! What follows for an integrator: what placing by match pays in each region, and which fixed
//! scheme and depth lose least there.

use super::cells::{Sheets, settings};
use super::grid::{BUFFER, CORES, Grid};
use super::machine::{Machine, SCHEMES};
use super::table::Curves;
use super::verdict::{TOLERANCE, pays};
use scenario::Scheme;

/// A scheme and a depth that are chosen once for all cases of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Choice {
    pub(crate) scheme: Scheme,
    pub(crate) depth: u32,
    /// Its time over that of the best scheme and depth of each case: the geometric mean, and what a
    /// tenth of the cases exceed.
    pub(crate) mean: f64,
    pub(crate) tenth: f64,
}

/// What is said of a region.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Advice {
    pub(crate) machine: Machine,
    /// Its costs of a byte and memories, in words.
    pub(crate) region: String,
    pub(crate) cases: usize,
    /// What Best Match-Load gains over Random Match, each at its own best depth (0.1 is 10 %): a
    /// tenth of the cases have less than the first, half less than the second, nine tenths less
    /// than the third.
    pub(crate) gains: [f64; 3],
    /// Share of the cases in which it gains, or loses, beyond tolerance.
    pub(crate) pays: f64,
    pub(crate) harms: f64,
    pub(crate) choice: Choice,
    /// The default of the engine, judged likewise.
    pub(crate) default: Choice,
}

/// Bounds of a region: costs of a byte (ns), both included, and memories (percent), likewise.
type Band = ([f64; 2], [u32; 2]);

const COPYING: [Band; 6] = [
    ([0.0, 0.3], [0, 59]),
    ([0.0, 0.3], [60, 1_000]),
    ([0.9, 3.0], [0, 59]),
    ([0.9, 3.0], [60, 1_000]),
    ([10.0, 10.0], [0, 59]),
    ([10.0, 10.0], [60, 1_000]),
];

/// The advice for every region of every machine.
pub(crate) fn advice(sheets: &Sheets, grid: &Grid, default: (Scheme, u32)) -> Vec<Advice> {
    let mut all = Vec::new();
    for machine in Machine::ALL {
        if !machine.copies() {
            for (words, cores) in [
                ("Nothing copied, four cores", Some(CORES)),
                ("Nothing copied, 2 to 16 cores", None),
            ] {
                let cases = cases(sheets, grid, machine, None, cores);
                all.extend(advise(machine, words.to_owned(), &cases, default));
            }
            continue;
        }
        for band in COPYING {
            let ([low, high], [from, to]) = band;
            let memory = if from == 0 {
                format!("less than {} % of memory", to + 1)
            } else {
                format!("{from} % of memory or more")
            };
            let cost = if low == 0.0 {
                format!("A byte at {high} ns or less")
            } else if low < high {
                format!("A byte at {low} to {high} ns")
            } else {
                format!("A byte at {high} ns")
            };
            let cases = cases(sheets, grid, machine, Some(band), None);
            all.extend(advise(machine, format!("{cost}, {memory}"), &cases, default));
        }
    }
    all
}

/// The lines of every case of a band: all subjects, these cores (`None`: every number of them), the
/// usual buffer, one request of all contacts.
fn cases(
    sheets: &Sheets,
    grid: &Grid,
    machine: Machine,
    band: Option<Band>,
    cores: Option<u8>,
) -> Vec<Curves> {
    let is_in = |byte: usize, memory: Option<usize>| {
        let Some(([low, high], [from, to])) = band else { return true };
        let memory = memory.map(|memory| grid.memories[memory]);
        (low..=high).contains(&grid.bytes[byte])
            && memory.is_some_and(|memory| (from..=to).contains(&memory))
    };
    let usual = |key: &&super::table::SheetKey| {
        (key.machine, key.is_single, key.buffer) == (machine, false, BUFFER)
            && cores.is_none_or(|cores| key.cores == cores)
    };
    let mut cases = Vec::new();
    for key in sheets.keys().filter(usual) {
        for setting in settings(grid, machine) {
            if is_in(setting.byte, setting.short.map(|(_, memory)| memory)) {
                cases.push(sheets[key].curves(setting.byte, setting.short));
            }
        }
    }
    cases
}

fn advise(
    machine: Machine,
    region: String,
    cases: &[Curves],
    default: (Scheme, u32),
) -> Option<Advice> {
    let found: Vec<_> = cases.iter().filter_map(pays).collect();
    let mut gains: Vec<f64> = found.iter().map(|gain| gain.mean - 1.0).collect();
    gains.sort_by(f64::total_cmp);
    let at_share = |share: f64| gains.get(((gains.len() - 1) as f64 * share).round() as usize);
    let share = |is_so: &dyn Fn(f64, f64) -> bool| {
        let count = found.iter().filter(|gain| is_so(gain.mean - 1.0, 3.0 * gain.error())).count();
        count as f64 / found.len().max(1) as f64
    };
    let mut choices = Vec::new();
    for scheme in SCHEMES {
        let depths = cases.first()?.line(scheme).iter().map(|(depth, _)| *depth);
        choices.extend(depths.filter_map(|depth| choice(cases, scheme, depth)));
    }
    if gains.is_empty() {
        return None;
    }
    Some(Advice {
        machine,
        region,
        cases: cases.len(),
        gains: [*at_share(0.1)?, *at_share(0.5)?, *at_share(0.9)?],
        pays: share(&|gain, noise| gain > TOLERANCE.max(noise)),
        harms: share(&|gain, noise| -gain > TOLERANCE.max(noise)),
        choice: choices.into_iter().min_by(|a, b| a.mean.total_cmp(&b.mean))?,
        default: choice(cases, default.0, default.1)?,
    })
}

/// What one scheme and depth lose over all cases.
fn choice(cases: &[Curves], scheme: Scheme, depth: u32) -> Option<Choice> {
    let mut ratios = Vec::new();
    for case in cases {
        let times = case.lines.iter().flatten().map(|(_, point)| point.time_us.mean);
        let best = times.fold(f64::INFINITY, f64::min);
        ratios.push(case.at_depth(scheme, depth)?.time_us.mean / best);
    }
    ratios.sort_by(f64::total_cmp);
    let logs = ratios.iter().map(|ratio| ratio.ln()).sum::<f64>();
    let mean = (logs / ratios.len().max(1) as f64).exp();
    let tenth = *ratios.get((ratios.len().saturating_sub(1) as f64 * 0.9).round() as usize)?;
    Some(Choice { scheme, depth, mean, tenth })
}

impl Choice {
    fn words(&self) -> String {
        let Self { scheme, depth, mean, tenth } = self;
        format!(
            "{} at depth {depth} (× {mean:.2} the time of the best choice for each case, × \
             {tenth:.2} or more in a tenth)",
            scheme.name()
        )
    }
}

impl Advice {
    /// The sentence for an integrator.
    pub(crate) fn sentence(&self) -> String {
        let Self { region, gains: [_, half, most], pays, harms, choice, default, .. } = self;
        let percent = |share: &f64| format!("{:.0} %", 100.0 * share);
        let shares = format!(
            "placing by match is faster than at random in {} of the cases and slower in {}",
            percent(pays),
            percent(harms)
        );
        let scheme = if *pays < 0.1 && *harms < 0.1 {
            "the scheme does not matter".to_owned()
        } else if *pays > 2.0 * harms {
            format!(
                "{shares}, so it pays; the median gain is {}, a tenth gain {} or more",
                percent(half),
                percent(most)
            )
        } else if *harms > 2.0 * pays {
            format!("{shares}, so it does not pay")
        } else {
            format!("{shares}, so nobody can tell without knowing the case")
        };
        format!(
            "{region}: {scheme}. Take {}. The engine's default: {}.",
            choice.words(),
            default.words()
        )
    }
}

#[cfg(test)]
mod tests {
    //! A planted region: what is best in it is chosen, and its sentence says what it pays.

    use super::super::table::{Point, Spread};
    use super::*;

    fn case(best_depth: u32, random_costs: f64) -> Curves {
        let mut case = Curves { alone_us: 100.0, ..Curves::default() };
        for (line, scheme) in case.lines.iter_mut().zip(SCHEMES) {
            for depth in [2, 4, 8] {
                let off = f64::from(depth.max(best_depth) - depth.min(best_depth));
                let more = if scheme == Scheme::BestMatchLoad { 0.0 } else { random_costs };
                let time_us = Spread { mean: 50.0 + 5.0 * off + more, deviation: 0.0, count: 16 };
                line.push((depth, Point { time_us, ..Point::default() }));
            }
        }
        case
    }

    #[test]
    fn the_choice_loses_least_and_the_sentence_says_what_match_pays() {
        let default = (Scheme::BestMatchLoad, 2);
        let cases = [case(4, 10.0), case(4, 10.0), case(8, 10.0)];
        let found = advise(Machine::Copying, "R".to_owned(), &cases, default).expect("it is told");
        assert_eq!((found.choice.scheme, found.choice.depth), (Scheme::BestMatchLoad, 4));
        assert!((found.choice.tenth - 1.4).abs() < 1e-9, "{found:?}");
        let mean = (1.2_f64 * 1.2 * 1.6).cbrt();
        assert!((found.default.mean - mean).abs() < 1e-9, "{found:?}");
        assert!((found.gains[1] - 0.2).abs() < 1e-9 && found.pays > 0.999, "{found:?}");
        assert!(
            found.sentence().starts_with("R: placing by match is faster"),
            "{}",
            found.sentence()
        );
        let level = [case(4, 0.0), case(4, 0.2)];
        let found = advise(Machine::Copying, "R".to_owned(), &level, default).expect("it is told");
        assert!(found.sentence().contains("the scheme does not matter"), "{}", found.sentence());
        let worse = [case(4, -10.0), case(4, -5.0)];
        let found = advise(Machine::Copying, "R".to_owned(), &worse, default).expect("it is told");
        assert!(
            found.sentence().contains("slower in 100 %, so it does not pay"),
            "{}",
            found.sentence()
        );
        assert_ne!(found.choice.scheme, Scheme::BestMatchLoad);
    }
}
