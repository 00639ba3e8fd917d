//! Invariants of the batch: it survives a round trip, and hostile counts are rejected.

use super::*;
use proptest::prelude::*;

fn a_task(number: u32) -> WireTask {
    WireTask { task: number, question: WireQuestion::Pairs as u32, ..WireTask::zeroed() }
}

proptest! {
    #[test]
    fn reads_what_was_written(jobs in prop::collection::vec(0_u32..3, 0..30)) {
        let tasks = [a_task(4), a_task(5), a_task(6)];
        let job_of = |&task| WireJob { task, job: 70 + task, ..WireJob::zeroed() };
        let jobs: Vec<WireJob> = jobs.iter().map(job_of).collect();
        let mut words = vec![9; 3];
        write_batch(&mut words, &tasks, &jobs);
        prop_assert_eq!(words.len(), batch_words(3, jobs.len()));
        prop_assert_eq!(read_batch(&words), Some((&tasks[..], &jobs[..])));
    }

    #[test]
    fn no_words_make_it_panic(words in prop::collection::vec(any::<u64>(), 0..60)) {
        let _ = read_batch(&words);
    }
}

#[test]
fn a_job_of_a_task_that_is_not_there_is_refused() {
    let mut words = Vec::new();
    write_batch(&mut words, &[a_task(0)], &[WireJob { task: 1, ..WireJob::zeroed() }]);
    assert_eq!(read_batch(&words), None);
    assert_eq!(read_batch(&[]), None);
    assert_eq!(read_batch(&[u64::MAX]), None);
}
