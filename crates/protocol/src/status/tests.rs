//! Laws of the status line: who works on what is read as it was written, or not at all.

use super::*;
use proptest::prelude::*;

proptest! {
    #[test]
    fn the_started_job_comes_back(
        worker in 0_u8..16, inc in any::<u32>(), job in any::<u32>(), attempt in any::<u8>(),
    ) {
        let from = Incarnation { worker, inc };
        let word = started(from, JobId(job), attempt);
        prop_assert_eq!(read_started(word, from), Some((JobId(job), attempt)));
        let next = Incarnation { inc: inc.wrapping_add(1), ..from };
        prop_assert_eq!(read_started(word, next), None);
        prop_assert_eq!(read_started(0, from), None);
    }
}
