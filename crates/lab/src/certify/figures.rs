//! Statistics over many requests: medians, percentiles, histograms; and names for tables.

use serde::Serialize;
use std::path::Path;

/// Number of values in a class of a histogram: above the end of the previous class, up to its own.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Class {
    /// `None`: no end.
    pub(super) up_to: Option<f64>,
    pub(super) count: usize,
}

/// A histogram of classes with these ends, and one without.
pub(super) fn classes(figures: &[f64], ends: &[f64]) -> Vec<Class> {
    let mut least = f64::NEG_INFINITY;
    let class_up_to = |up_to: Option<f64>| {
        let most = up_to.unwrap_or(f64::INFINITY);
        let count = figures.iter().filter(|figure| **figure > least && **figure <= most).count();
        least = most;
        Class { up_to, count }
    };
    ends.iter().copied().map(Some).chain([None]).map(class_up_to).collect()
}

/// Names of bodies without their folders.
pub(super) fn names(all: &[String]) -> String {
    let name = |text: &String| {
        let file = Path::new(text).file_stem().unwrap_or_default();
        file.to_string_lossy().into_owned()
    };
    all.iter().map(name).collect::<Vec<_>>().join(", ")
}

/// The median; NaN if there are no values.
pub(super) fn median(figures: &mut [f64]) -> f64 {
    percentile(figures, 0.5)
}

/// The value below which this share of all values lies.
pub(super) fn percentile(figures: &mut [f64], share: f64) -> f64 {
    figures.sort_by(f64::total_cmp);
    let at = ((figures.len() as f64 * share) as usize).min(figures.len().saturating_sub(1));
    figures.get(at).copied().unwrap_or(f64::NAN)
}
