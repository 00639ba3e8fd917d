//! Invariants of a ruler: as many cells as requested, ascending, and lines on the edges.

use super::super::solids::{at, block};
use super::super::surface::Surface;
use super::{Along, Ruler};
use proptest::prelude::*;

proptest! {
    #[test]
    fn cells_ascend_and_their_edges_are_met(
        half in prop::array::uniform3(0.1..3.0_f64),
        cells in 1_usize..200,
    ) {
        let solid = block(at(0.0, 0.0, 0.0), at(half[0], half[1], half[2]), 0.05);
        let Surface::Tube { net, .. } = solid else { unreachable!() };
        let ruler = Ruler::new(&net, Along::Rows, 0.0, net.rows.end());
        let ends = ruler.ends(cells);
        prop_assert_eq!(ends.len(), cells + 1);
        prop_assert!(ends.windows(2).all(|pair| pair[0] < pair[1]));
        prop_assert_eq!((ends[0], ends[cells]), (0.0, net.rows.end()));
        // A block has its edges at rows 1 and 4.
        if cells >= 3 {
            prop_assert!(ends.contains(&1.0) && ends.contains(&4.0));
        }
    }
}
