//! Lines over depth of a sweep, on virtual cores.
//!
//! A sweep has one seed, one memory and one machine, which decide no claim of the paper: these are
//! judged on the map (`map.rs`).

use super::row::{Mode, Row};
use super::swept::Swept;
use scenario::Scheme;
use trolley::dispatch_options::TransferMode;

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
