//! What states of a trajectory leave open, from the other states.

use crate::recording::TimedState;

/// Who moves less than this between two states says nothing of its heading (m).
const MOVES_M: f64 = 0.01;

/// Speeds from one place to the next.
pub(super) fn speeds_from_places(track: &mut [TimedState]) {
    for index in 0..track.len() {
        let (a, b) = if index + 1 < track.len() { (index, index + 1) } else { (index - 1, index) };
        let (p, q) = (track[a], track[b]);
        let apart = libm::hypot(q.place.at[0] - p.place.at[0], q.place.at[1] - p.place.at[1]);
        track[index].speed_m_s = apart / (q.time_s - p.time_s);
    }
}

/// Headings from one place to the next where they are missing; what stands keeps the one before.
/// Returns whether there is any to begin with.
pub(super) fn headings_from_places(track: &mut [TimedState], missing: &[bool]) -> bool {
    let course = |index: usize| {
        let next = if index + 1 < track.len() { index } else { index - 1 };
        let (p, q) = (track[next].place.at, track[next + 1].place.at);
        let [x, y] = [q[0] - p[0], q[1] - p[1]];
        (libm::hypot(x, y) > MOVES_M).then(|| libm::atan2(y, x))
    };
    let stated = |index: usize| (!missing[index]).then(|| track[index].place.yaw);
    let known: Vec<Option<f64>> =
        (0..track.len()).map(|index| stated(index).or_else(|| course(index))).collect();
    let Some(mut yaw) = known.iter().flatten().next().copied() else { return false };
    for (state, known) in track.iter_mut().zip(known) {
        yaw = known.unwrap_or(yaw);
        state.place.yaw = yaw;
    }
    true
}

/// Where somebody is a while after a state, who goes straight on (s).
pub(super) fn straight_on(state: &TimedState, after_s: f64) -> TimedState {
    let velocity = state.velocity_m_s();
    let mut next = *state;
    next.time_s += after_s;
    next.place.at = [0, 1].map(|axis| state.place.at[axis] + velocity[axis] * after_s);
    next
}
