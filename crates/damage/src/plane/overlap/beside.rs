//! Edges of two outlines that lie beside each other, and at which depths they may meet.

use super::super::CHORDS;
use super::{Edge, SAME_M};

/// An edge that goes further along u than this for each metre to the left runs along u.
const STEEP: f64 = 8.0;

/// A set of depths, by number.
pub(super) type Depths = u32;

const _: () = assert!(CHORDS <= Depths::BITS as usize, "each depth has a bit");

/// An edge that lies beside one of the other outline.
#[derive(Clone, Copy)]
pub(super) struct Neighbour {
    /// Its number: a body has at most [`body::outline::POINTS_MAX`].
    pub(super) number: u16,
    /// At which depths the two may be nearer along u than edges that coincide.
    pub(super) meets: Depths,
}

impl Neighbour {
    pub(super) fn may_meet(&self, depth: usize) -> bool {
        self.meets >> depth & 1 == 1
    }
}

/// What lies beside the edges of an outline.
pub(super) struct Beside {
    pub(super) neighbours: Vec<Neighbour>,
    /// By edge.
    pub(super) rows: Vec<Row>,
}

/// What lies beside an edge.
#[derive(Clone, Copy)]
pub(super) struct Row {
    /// Where its neighbours end.
    end: u32,
    /// At which depths one of them may meet it.
    pub(super) meets: Depths,
    /// At which depths its middle lies inside of the other outline, where nothing meets it.
    pub(super) is_inside: Depths,
}

fn ascending([from, to]: [f64; 2]) -> [f64; 2] {
    if from < to { [from, to] } else { [to, from] }
}

impl Edge {
    /// How far `other` is ahead of it along u where a line along u meets both, or nearly does (m):
    /// at least, and at most.
    fn gaps(&self, other: &Self) -> [f64; 2] {
        let low = self.low[1].max(other.low[1]);
        let high = self.high[1].min(other.high[1]);
        let spans = [self, other].map(|edge| edge.span(low, high));
        // What coincides may lie beyond these lines, by as much as a slope has there.
        let slack_m = 2.0 * STEEP * SAME_M;
        let [least_m, most_m] = if low <= high && self.is_across() && other.is_across() {
            // Both are straight over y, and so is the gap.
            let [[from, to], [other_from, other_to]] = spans;
            ascending([other_from - from, other_to - to])
        } else {
            let [[least, most], [other_least, other_most]] = spans.map(ascending);
            [other_least - most, other_most - least]
        };
        [least_m - slack_m, most_m + slack_m]
    }

    /// Whether it does not run along u.
    fn is_across(&self) -> bool {
        self.high[0] - self.low[0] < STEEP * (self.high[1] - self.low[1])
    }

    /// Where it is along u on two lines along u that meet it or pass it by; its ends, if it runs
    /// along u.
    fn span(&self, low: f64, high: f64) -> [f64; 2] {
        if !self.is_across() {
            return [self.low[0], self.high[0]];
        }
        let [p, q] = self.ends;
        let slope = (q[0] - p[0]) / (q[1] - p[1]);
        [low, high].map(|y| p[0] + (y.clamp(self.low[1], self.high[1]) - p[1]) * slope)
    }
}

/// The depths at which edges of A and of B may meet along u, and those at which they have passed
/// each other: both have a margin, as numbers are rounded.
fn meeting(of_a: &Edge, of_b: &Edge, step_m: f64) -> [Depths; 2] {
    let number = |travel_m: f64| travel_m / step_m.max(f64::MIN_POSITIVE) - 0.5;
    let clamp = |number: f64| number.floor().clamp(0.0, CHORDS as f64) as u32;
    let [least_m, most_m] = of_a.gaps(of_b);
    let first = clamp(number(least_m - 2.0 * SAME_M));
    let passed = clamp(number(most_m + 2.0 * SAME_M) + 2.0);
    let below = |end: u32| ((1_u64 << end) - 1) as Depths;
    [below(passed) & !below(first), below(CHORDS as u32) & !below(passed)]
}

impl Beside {
    /// For each edge of A (`side` 0) or of B (1), the others that lie beside it.
    pub(super) fn of(side: usize, edges: &[Edge], others: &[Edge], step_m: f64) -> Self {
        let mut beside = Self { neighbours: Vec::new(), rows: Vec::with_capacity(edges.len()) };
        for edge in edges {
            let [p, q] = edge.ends;
            // As of the piece that is the whole edge.
            let middle = 0.5 * (p[1] + (p[1] + (q[1] - p[1])));
            let mut row = Row { end: 0, meets: 0, is_inside: 0 };
            for (other, number) in others.iter().zip(0..=u16::MAX) {
                if other.high[1] < edge.low[1] - SAME_M || other.low[1] > edge.high[1] + SAME_M {
                    continue;
                }
                let [of_a, of_b] = if side == 0 { [edge, other] } else { [other, edge] };
                let [meets, passed] = meeting(of_a, of_b, step_m);
                beside.neighbours.push(Neighbour { number, meets });
                row.meets |= meets;
                // What is passed is crossed by a ray from A's edge against u, or from B's along u.
                let [a, b] = other.ends;
                if (a[1] > middle) != (b[1] > middle) {
                    row.is_inside ^= passed;
                }
            }
            row.end = beside.neighbours.len() as u32;
            beside.rows.push(row);
        }
        beside
    }

    pub(super) fn of_edge(&self, number: usize) -> (&[Neighbour], &Row) {
        let from = number.checked_sub(1).map_or(0, |before| self.rows[before].end);
        let row = &self.rows[number];
        (&self.neighbours[from as usize..row.end as usize], row)
    }
}
