//! What each step costs, and how the kernel's costs follow from timed jobs.
//!
//! The kernel's part is the paper's model T = Nb·Cb + Np·Cp, plus a cost per job and per hit: a
//! vectorised traversal has a fixed cost that the paper's does not have.

use serde::{Deserialize, Serialize};

/// Costs in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Costs {
    /// Worker: per job, whatever its contents.
    pub job_ns: f64,
    /// Worker: per test of two boxes (the paper's Cb).
    pub box_ns: f64,
    /// Worker: per test of two triangles (the paper's Cp).
    pub triangle_ns: f64,
    /// Worker: per hit.
    pub hit_ns: f64,
    /// Worker: per pair of leaves whose boxes overlap, all tests and hits of a job taken together.
    pub leaves_ns: f64,
    /// Worker: per result message.
    pub send_ns: f64,
    /// Worker that copies: per logical byte of a section that it did not hold.
    pub section_byte_ns: f64,
    /// Worker that copies: per section that it did not hold, whatever its size.
    pub section_ns: f64,
    /// Coordinator whose workers copy: per logical byte of a section that it ships.
    pub ship_byte_ns: f64,
    /// Coordinator whose workers copy: per section that it ships, whatever its size.
    pub ship_section_ns: f64,
    /// Coordinator: per task, before its traversal.
    pub task_ns: f64,
    /// Coordinator: per test of two boxes of a traversal.
    pub descent_ns: f64,
    /// Coordinator: per batch sent.
    pub batch_ns: f64,
    /// Coordinator: per job in it, with its placement.
    pub place_ns: f64,
    /// Coordinator: per result message taken.
    pub take_ns: f64,
    /// Coordinator: per hit folded.
    pub fold_hit_ns: f64,
    /// From the end of sending to the start of taking.
    pub flight_ns: f64,
}

impl Costs {
    /// The kernel's time for a job (ns).
    #[must_use]
    pub fn kernel_ns(&self, nb: u64, np: u64, hits: u64) -> f64 {
        self.job_ns
            + self.box_ns * nb as f64
            + self.triangle_ns * np as f64
            + self.hit_ns * hits as f64
    }
}

/// A timed job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Tests of boxes.
    pub nb: u64,
    /// Tests of triangles.
    pub np: u64,
    /// Hits.
    pub hits: u64,
    /// Its time (ns).
    pub ns: f64,
}

const TERMS: usize = 4;

/// The costs per byte and per section that explain best how long sections took to copy: each sample
/// has bytes, sections and time (ns). Least squares of relative errors, over costs that are not
/// negative. Zero without samples.
#[must_use]
pub fn fit_copies(samples: &[[f64; 3]]) -> [f64; 2] {
    // Over both, over bytes alone, over sections alone: the best of those without negative costs.
    let candidates = [[true, true], [true, false], [false, true]].map(|used| copies(samples, used));
    let error = |costs: &[f64; 2]| -> f64 {
        let relative = |[bytes, sections, ns]: &[f64; 3]| {
            let ns = ns.max(1.0);
            ((costs[0] * bytes + costs[1] * sections - ns) / ns).powi(2)
        };
        samples.iter().map(relative).sum()
    };
    let sound = candidates.into_iter().filter(|costs| costs.iter().all(|cost| *cost >= 0.0));
    sound.min_by(|a, b| error(a).total_cmp(&error(b))).unwrap_or_default()
}

/// The normal equations of two terms, of which only some are used.
fn copies(samples: &[[f64; 3]], used: [bool; 2]) -> [f64; 2] {
    let [mut xx, mut xy, mut yy, mut xt, mut yt] = [0.0; 5];
    for [bytes, sections, ns] in samples {
        let weight = 1.0 / ns.max(1.0);
        let (x, y) = (
            bytes * weight * f64::from(u8::from(used[0])),
            sections * weight * f64::from(u8::from(used[1])),
        );
        let t = ns * weight;
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        (xt, yt) = (xt + x * t, yt + y * t);
    }
    let over = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
    match used {
        [true, true] => {
            let whole = xx * yy - xy * xy;
            [over(xt * yy - yt * xy, whole), over(yt * xx - xt * xy, whole)]
        }
        _ => [over(xt, xx), over(yt, yy)],
    }
}

/// The kernel's costs that explain the samples best: job, box, triangle, hit.
///
/// Least squares of relative errors, over costs that are not negative: terms that come out negative
/// are left out, one after the other (Lawson and Hanson, *Solving Least Squares Problems*, 1974,
/// give the exact method; four terms do not need it). All zero without samples.
#[must_use]
pub fn fit(samples: &[Sample]) -> [f64; TERMS] {
    let mut used = [true; TERMS];
    loop {
        let costs = solve(samples, used);
        let negative = (0..TERMS).filter(|term| costs[*term] < 0.0);
        let Some(worst) = negative.min_by(|a, b| costs[*a].total_cmp(&costs[*b])) else {
            return costs;
        };
        used[worst] = false;
    }
}

/// Normal equations by Gaussian elimination with pivoting; a term that the samples do not determine
/// is 0.
fn solve(samples: &[Sample], used: [bool; TERMS]) -> [f64; TERMS] {
    // A microsecond: below it, clock and caches dominate the time, not the work.
    const FLOOR_NS: f64 = 1_000.0;
    let mut rows = [[0.0_f64; TERMS + 1]; TERMS];
    for sample in samples {
        let terms = [1.0, sample.nb as f64, sample.np as f64, sample.hits as f64];
        let weight = 1.0 / (sample.ns + FLOOR_NS);
        let weight = weight * weight;
        for i in 0..TERMS {
            for j in 0..TERMS {
                rows[i][j] += weight * terms[i] * terms[j];
            }
            rows[i][TERMS] += weight * terms[i] * sample.ns;
        }
    }
    let mut pivots = [None; TERMS];
    for column in (0..TERMS).filter(|column| used[*column]) {
        let free = (0..TERMS).filter(|row| used[*row] && !pivots.contains(&Some(*row)));
        let size = |row: &usize| rows[*row][column].abs();
        let Some(pivot) = free.max_by(|a, b| size(a).total_cmp(&size(b))) else { continue };
        if rows[pivot][column].abs() < 1e-12 {
            continue;
        }
        pivots[column] = Some(pivot);
        let by = rows[pivot];
        for (_, row) in rows.iter_mut().enumerate().filter(|(number, _)| *number != pivot) {
            let factor = row[column] / by[column];
            row.iter_mut().zip(by).for_each(|(value, by)| *value -= factor * by);
        }
    }
    let mut costs = [0.0; TERMS];
    for column in 0..TERMS {
        if let Some(pivot) = pivots[column] {
            costs[column] = rows[pivot][TERMS] / rows[pivot][column];
        }
    }
    costs
}

#[cfg(test)]
mod tests;
