//! The claims of the paper, each judged at one cell of the map.
//!
//! A difference counts if it is more than [`TOLERANCE`] of the larger value and more than three
//! standard errors; less is a tie, and ties neither support a claim nor refute it. So there are
//! three verdicts: a claim holds, it does not, or nobody can tell.

use super::machine::SCHEMES;
use super::table::{Curve, Curves, Point, Spread};
use scenario::Scheme;
use serde::Serialize;
use std::cmp::Ordering;

/// Values closer than this share of the larger one are equal.
pub(crate) const TOLERANCE: f64 = 0.03;

/// What can be said of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Verdict {
    Holds,
    Fails,
    Open,
}

impl Verdict {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "does not hold",
            Self::Open => "nobody can tell",
        }
    }
}

/// A claim's letter, and what it says.
pub(crate) const CLAIMS: [(char, &str); 7] = [
    ('a', "transfer: best match ≤ random match ≤ lowest match at every depth"),
    ('b', "speed-up has an interior best depth"),
    ('c', "that depth is deeper for the larger contact"),
    ('d', "best match's gain over random match grows with the model"),
    ('e', "only random and lowest match run out of memory, and only at low depth"),
    ('f', "speed-up rises with the buffer, then saturates"),
    ('g', "speed-up: best match ≥ random match ≥ lowest match at the best depth"),
];

/// Compares two values: equal unless the difference is beyond tolerance and noise.
pub(crate) fn compare(a: &Spread, b: &Spread) -> Ordering {
    let noise = 3.0 * a.error().hypot(b.error());
    let least = (TOLERANCE * a.mean.max(b.mean)).max(noise);
    match b.mean - a.mean {
        gap if gap > least => Ordering::Less,
        gap if gap < -least => Ordering::Greater,
        _ => Ordering::Equal,
    }
}

/// The verdict on `a ≤ b` at several places: one beyond doubt refutes it, ties alone say nothing.
fn ordered(found: impl IntoIterator<Item = Ordering>) -> Verdict {
    let mut verdict = Verdict::Open;
    for order in found {
        match order {
            Ordering::Greater => return Verdict::Fails,
            Ordering::Less => verdict = Verdict::Holds,
            Ordering::Equal => {}
        }
    }
    verdict
}

/// The depths whose time is that of the best one, within tolerance and noise; the best first.
pub(crate) fn best_depths(line: &Curve) -> Option<(u32, Vec<u32>)> {
    let (best, point) = line.iter().min_by(|a, b| a.1.time_us.mean.total_cmp(&b.1.time_us.mean))?;
    let ties = line.iter().filter(|(_, p)| compare(&point.time_us, &p.time_us) == Ordering::Equal);
    Some((*best, ties.map(|(depth, _)| *depth).collect()))
}

/// The depth at which Best Match-Load is the fastest.
pub(crate) fn best_depth(curves: &Curves) -> Option<u32> {
    best_depths(curves.line(Scheme::BestMatchLoad)).map(|(depth, _)| depth)
}

/// (a) at one cell: over all depths.
pub(crate) fn less_travels(curves: &Curves) -> Verdict {
    let [best, random, lowest] = [Scheme::BestMatch, Scheme::RandomMatch, Scheme::LowestMatch]
        .map(|scheme| curves.line(scheme));
    let mut found = Vec::new();
    for ((best, random), lowest) in best.iter().zip(random).zip(lowest) {
        found.push(compare(&best.1.moved, &random.1.moved));
        found.push(compare(&random.1.moved, &lowest.1.moved));
    }
    ordered(found)
}

/// (b) at one cell: the ends are slower than some depth between them.
pub(crate) fn interior(curves: &Curves) -> Verdict {
    let line = curves.line(Scheme::BestMatchLoad);
    let (Some((_, ties)), Some(first), Some(last)) = (best_depths(line), line.first(), line.last())
    else {
        return Verdict::Open;
    };
    let is_end = |depth: &u32| [first.0, last.0].contains(depth);
    match (ties.iter().any(is_end), ties.iter().all(is_end)) {
        (false, _) => Verdict::Holds,
        (true, true) => Verdict::Fails,
        (true, false) => Verdict::Open,
    }
}

/// (c) for the two contacts of the same bodies.
pub(crate) fn deeper(deep: &Curves, scratch: &Curves) -> Verdict {
    let ties = |curves: &Curves| best_depths(curves.line(Scheme::BestMatchLoad)).map(|b| b.1);
    let (Some(deep), Some(scratch)) = (ties(deep), ties(scratch)) else { return Verdict::Open };
    let ends = |ties: &[u32]| (ties.iter().min().copied(), ties.iter().max().copied());
    let ((low, high), (other_low, other_high)) = (ends(&deep), ends(&scratch));
    if low > other_high {
        Verdict::Holds
    } else if high <= other_low {
        Verdict::Fails
    } else {
        Verdict::Open
    }
}

/// What Best Match saves: the bytes of Random Match over its own, at the best depth.
pub(crate) fn gain(curves: &Curves) -> Option<Spread> {
    let depth = best_depth(curves)?;
    let best = curves.at_depth(Scheme::BestMatch, depth)?.moved;
    let random = curves.at_depth(Scheme::RandomMatch, depth)?.moved;
    let deviation = random.deviation / best.mean;
    Some(Spread { mean: random.mean / best.mean, deviation, count: random.count })
}

/// (d) for bodies of increasing size.
pub(crate) fn grows(curves: &[Curves]) -> Verdict {
    let gains: Option<Vec<Spread>> = curves.iter().map(gain).collect();
    let Some(gains) = gains else { return Verdict::Open };
    ordered(gains.windows(2).map(|pair| compare(&pair[0], &pair[1])))
}

/// Whether most runs of a point would have gone beyond the memory of a core.
pub(crate) fn is_out(point: &Point) -> bool {
    point.out > 0.5
}

/// (e) at one cell: which schemes run out, and where. At depth 0 each job needs both bodies whole,
/// whoever gets it, so that depth is left out.
pub(crate) fn runs_out(curves: &Curves) -> Verdict {
    let out: Vec<Vec<bool>> = SCHEMES
        .iter()
        .map(|scheme| {
            let line = curves.line(*scheme).iter().filter(|(depth, _)| *depth > 0);
            line.map(|(_, point)| is_out(point)).collect()
        })
        .collect();
    if out.iter().flatten().all(|is_out| !is_out) {
        return Verdict::Open;
    }
    let is_sound = |(scheme, out): (&Scheme, &Vec<bool>)| match scheme {
        Scheme::RandomMatch | Scheme::LowestMatch => {
            let low = out.iter().take_while(|is_out| **is_out).count();
            low < out.len() && out[low..].iter().all(|is_out| !is_out)
        }
        _ => out.iter().all(|is_out| !is_out),
    };
    let sound = SCHEMES.iter().zip(&out).all(is_sound);
    if sound { Verdict::Holds } else { Verdict::Fails }
}

/// (f) for buffers of increasing size, all at the depth that is best with the usual one.
pub(crate) fn saturates(curves: &[Curves], depth: u32) -> Verdict {
    let speeds: Option<Vec<f64>> = curves
        .iter()
        .map(|curves| Some(1.0 / curves.at_depth(Scheme::BestMatchLoad, depth)?.time_us.mean))
        .collect();
    let Some(speeds) = speeds.filter(|speeds| speeds.len() > 2) else { return Verdict::Open };
    let most = speeds.iter().copied().fold(0.0, f64::max);
    let least = speeds.iter().copied().fold(f64::INFINITY, f64::min);
    if least >= most * (1.0 - TOLERANCE) {
        return Verdict::Open;
    }
    let full = speeds.iter().position(|speed| *speed >= most * (1.0 - TOLERANCE)).unwrap_or(0);
    let rises = speeds[..=full].windows(2).all(|two| two[0] <= two[1] * (1.0 + TOLERANCE));
    let stays = speeds[full..].iter().all(|speed| *speed >= most * (1.0 - 2.0 * TOLERANCE));
    if full > 0 && rises && stays { Verdict::Holds } else { Verdict::Fails }
}

/// (g) at one cell: at the best depth.
pub(crate) fn faster(curves: &Curves) -> Verdict {
    let Some(depth) = best_depth(curves) else { return Verdict::Open };
    let times = [Scheme::BestMatch, Scheme::RandomMatch, Scheme::LowestMatch]
        .map(|scheme| curves.at_depth(scheme, depth).map(|point| point.time_us));
    let [Some(best), Some(random), Some(lowest)] = times else { return Verdict::Open };
    ordered([compare(&best, &random), compare(&random, &lowest)])
}

/// What placing by match pays: the time of Random Match over that of Best Match-Load, each at its
/// own best depth.
pub(crate) fn pays(curves: &Curves) -> Option<Spread> {
    let fastest = |scheme| {
        let line = curves.line(scheme);
        let times = line.iter().map(|(_, point)| point.time_us);
        times.min_by(|a, b| a.mean.total_cmp(&b.mean))
    };
    let (best, random) = (fastest(Scheme::BestMatchLoad)?, fastest(Scheme::RandomMatch)?);
    let deviation = random.deviation / best.mean;
    Some(Spread { mean: random.mean / best.mean, deviation, count: random.count })
}

#[cfg(test)]
mod tests;
