//! Invariants of the status line: the started job is read as written, or not at all.

use super::*;
use proptest::prelude::*;

proptest! {
    #[test]
    fn the_started_job_comes_back_and_no_other_request_s(
        worker in 0_u8..16, inc in any::<u32>(), job in any::<u32>(), attempt in any::<u8>(),
        number in any::<u64>(),
    ) {
        let (from, request) = (Incarnation { worker, inc }, RequestId(number));
        let word = started(from, request, JobId(job), attempt);
        prop_assert_eq!(read_started(word, from, request), Some((JobId(job), attempt)));
        let next = Incarnation { inc: inc.wrapping_add(1), ..from };
        prop_assert_eq!(read_started(word, next, request), None);
        prop_assert_eq!(read_started(word, from, RequestId(number.wrapping_add(1))), None);
        prop_assert_eq!(read_started(0, from, request), None);
    }
}
