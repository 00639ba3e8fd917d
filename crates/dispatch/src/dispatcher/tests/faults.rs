//! One fault at a time: which job is blamed, which worker is killed, and which are unaffected.

use super::*;

/// A dispatcher of several cores, all ready, with jobs assigned, and its effects.
struct Fixture {
    dispatcher: Dispatcher<BestMatchLoad>,
    work: Waves,
    said: Vec<Effect>,
    now_ns: u64,
}

impl Fixture {
    fn new(cores: u8, queues: Queues, jobs: u32) -> Self {
        let scheme = BestMatchLoad { alpha: 0.0 };
        let mut dispatcher = Dispatcher::new(scheme, queues, Cache::Unlimited, cores.into());
        dispatcher.begin(NOW);
        (0..cores).for_each(|worker| dispatcher.admit(Incarnation { worker, inc: 0 }));
        let work = Waves { left: vec![jobs], ..Waves::default() };
        let mut fixture = Self { dispatcher, work, said: Vec::new(), now_ns: 0 };
        fixture.step(Event::Poll);
        fixture
    }

    fn step(&mut self, event: Event<u16>) -> Progress {
        self.dispatcher.step(self.now_ns, event, &mut self.work, &mut self.said)
    }

    fn send_part(&mut self, from: Incarnation, job: u32, attempt: u8) -> Progress {
        let (request, job, part, last) = (NOW, JobId(job), 0, true);
        self.step(Event::Part { from, request, job, attempt, part, last, body: 0 })
    }

    /// All batches to a worker since the last call: number, jobs with attempts.
    fn sent(&mut self, worker: u8) -> Vec<(u32, Vec<(u32, u8)>)> {
        let (own, others): (Vec<_>, Vec<_>) = self
            .said
            .drain(..)
            .partition(|effect| matches!(effect, Effect::Send { to, .. } if to.worker == worker));
        self.said = others;
        let jobs = |jobs: Vec<(JobId, u8)>| jobs.iter().map(|(job, at)| (job.0, *at)).collect();
        let batch = |effect| match effect {
            Effect::Send { batch, jobs: list, .. } => Some((batch, jobs(list))),
            Effect::Kill { .. } => None,
        };
        own.into_iter().filter_map(batch).collect()
    }

    fn killed(&self) -> Vec<(Incarnation, Why)> {
        let kill = |effect: &Effect| match effect {
            Effect::Kill { who, why } => Some((*who, *why)),
            Effect::Send { .. } => None,
        };
        self.said.iter().filter_map(kill).collect()
    }
}

const FIRST: Incarnation = Incarnation { worker: 0, inc: 0 };
const SECOND: Incarnation = Incarnation { worker: 1, inc: 0 };
const QUEUES: Queues = Queues { capacity: 4, batch: 2, linger_ns: 0 };

#[test]
fn a_batch_that_was_turned_away_is_sent_again_without_blame() {
    let mut fixture = Fixture::new(1, QUEUES, 4);
    assert_eq!(fixture.sent(0), [(0, vec![(0, 0), (1, 0)]), (1, vec![(2, 0), (3, 0)])]);
    fixture.send_part(FIRST, 2, 0);
    fixture.step(Event::Answered { who: FIRST, batches: 1 });
    assert_eq!(fixture.sent(0), [(2, vec![(0, 0), (1, 0)])]);
    fixture.send_part(FIRST, 3, 0);
    fixture.step(Event::Answered { who: FIRST, batches: 2 });
    assert!(fixture.sent(0).is_empty(), "the second batch was answered in full");
    fixture.send_part(FIRST, 1, 0);
    assert_eq!(fixture.send_part(FIRST, 0, 0), Progress::Finished);
    assert_eq!((fixture.dispatcher.counts().reissued, fixture.dispatcher.counts().done), (2, 4));
}

#[test]
fn who_loses_three_messages_is_killed_once_and_its_jobs_go_to_the_others() {
    let mut fixture = Fixture::new(2, QUEUES, 8);
    fixture.sent(0);
    fixture.sent(1);
    for batches in 1..=3 {
        assert_eq!(fixture.killed(), []);
        fixture.step(Event::Answered { who: FIRST, batches });
        if batches < 3 {
            assert!(fixture.sent(0).iter().all(|(_, jobs)| jobs.len() == 2));
        }
    }
    assert_eq!(fixture.killed(), [(FIRST, Why::Forgetful)]);
    fixture.step(Event::Garbled { from: FIRST });
    assert_eq!(fixture.killed().len(), 1);
    fixture.step(Event::Lost { who: FIRST, started: None });
    for job in 0..8 {
        fixture.send_part(SECOND, job, 0);
    }
    for job in 0..8 {
        fixture.send_part(SECOND, job, 0);
    }
    assert_eq!(fixture.dispatcher.counts().done, 8);
}

#[test]
fn garbled_messages_kill_their_sender_at_the_third() {
    let mut fixture = Fixture::new(2, QUEUES, 8);
    for _ in 0..2 {
        fixture.step(Event::Garbled { from: SECOND });
    }
    assert_eq!(fixture.killed(), []);
    fixture.step(Event::Garbled { from: SECOND });
    assert_eq!(fixture.killed(), [(SECOND, Why::Garbled)]);
}

#[test]
fn a_full_queue_costs_no_attempt_and_the_core_is_tried_again_later() {
    let mut fixture = Fixture::new(1, QUEUES, 2);
    assert_eq!(fixture.sent(0), [(0, vec![(0, 0), (1, 0)])]);
    assert_eq!(fixture.step(Event::Unsent { to: FIRST, batch: 0 }), Progress::Working);
    assert!(fixture.sent(0).is_empty(), "at once would be a busy loop");
    let due_ns = fixture.dispatcher.due_ns().expect("it is tried again");
    assert!(due_ns > fixture.now_ns);
    fixture.now_ns = due_ns;
    fixture.step(Event::Poll);
    assert_eq!(fixture.sent(0), [(0, vec![(0, 0), (1, 0)])], "numbers have no gaps");
    assert_eq!(fixture.dispatcher.due_ns(), None);
}

#[test]
fn a_queue_that_stays_full_is_the_end_of_its_worker() {
    let mut fixture = Fixture::new(1, QUEUES, 2);
    let mut refusals = 0;
    while fixture.killed().is_empty() {
        assert!(refusals < 20, "for ever");
        fixture.step(Event::Unsent { to: FIRST, batch: 0 });
        refusals += 1;
        fixture.now_ns = fixture.dispatcher.due_ns().unwrap_or(fixture.now_ns);
        fixture.step(Event::Poll);
    }
    assert_eq!(fixture.killed(), [(FIRST, Why::Full)]);
}

#[test]
fn a_suspect_runs_alone_and_while_it_waits_the_others_go_on() {
    let mut fixture = Fixture::new(2, QUEUES, 12);
    assert_eq!(fixture.sent(0).concat_jobs(), [0, 2, 4, 6]);
    fixture.sent(1);
    fixture.step(Event::Lost { who: FIRST, started: Some((JobId(2), 0)) });
    let again = Incarnation { worker: 0, inc: 1 };
    fixture.step(Event::Ready(again));
    assert_eq!(fixture.sent(0), [(0, vec![(2, 1)])], "the core is empty: the suspect, and no more");
    assert_eq!(fixture.send_part(again, 2, 0), Progress::Working, "the first attempt is over");
    assert!(fixture.sent(0).is_empty());
    fixture.send_part(again, 2, 1);
    assert_eq!(fixture.sent(0).concat_jobs().len(), 4, "cleared, the core takes its share");
}

#[test]
fn a_job_that_took_two_workers_down_is_left_alone_by_the_next_request() {
    struct Named(Waves);
    impl JobSource for Named {
        type Part<'p> = u16;
        fn more(&mut self, jobs: &mut Vec<Job>) {
            self.0.more(jobs);
        }
        fn is_obsolete(&self, _: &Job) -> bool {
            false
        }
        fn fold(&mut self, job: &Job, part: u16) {
            self.0.fold(job, part);
        }
        fn close(&mut self, job: &Job, how: Closed) {
            self.0.close(job, how);
        }
        fn weight(&self, _: Section) -> u64 {
            1
        }
        fn key(&self, job: &Job) -> Option<u64> {
            Some(job.task.0.into())
        }
    }
    let scheme = BestMatchLoad { alpha: 0.0 };
    let mut dispatcher = Dispatcher::new(scheme, QUEUES, Cache::Unlimited, 1);
    let mut said = Vec::new();
    let request = |dispatcher: &mut Dispatcher<_>, number| {
        dispatcher.begin(RequestId(number));
        Named(Waves { left: vec![2], ..Waves::default() })
    };
    let mut work = request(&mut dispatcher, 1);
    for inc in 0..2 {
        let who = Incarnation { worker: 0, inc };
        dispatcher.step(5, Event::Ready(who), &mut work, &mut said);
        let started = Some((JobId(0), inc as u8));
        dispatcher.step(5, Event::Lost { who, started }, &mut work, &mut said);
    }
    assert_eq!(work.0.closed, BTreeMap::from([(0, vec![Closed::Abandoned])]));
    for (now_ns, expected) in [(1_000, 1), (61_000_000_000, 0)] {
        let mut work = request(&mut dispatcher, 2);
        dispatcher.step(now_ns, Event::Poll, &mut work, &mut said);
        assert_eq!(dispatcher.counts().abandoned, expected, "at {now_ns} ns");
    }
}

#[test]
fn when_the_time_is_up_all_is_closed_and_what_comes_later_is_fenced() {
    let mut fixture = Fixture::new(1, QUEUES, 9);
    fixture.send_part(FIRST, 0, 0);
    assert_eq!(fixture.step(Event::Expired), Progress::Finished);
    let counts = fixture.dispatcher.counts();
    assert_eq!((counts.done, counts.late, counts.jobs), (1, 8, 9));
    assert_eq!(fixture.send_part(FIRST, 1, 0), Progress::Finished);
    assert_eq!(fixture.dispatcher.counts().fence.not_leased, 1);
    // The next request: the queue still holds three jobs of this one, with a slot for one more, but
    // not for a batch.
    fixture.said.clear();
    fixture.dispatcher.begin(RequestId(8));
    fixture.work = Waves { left: vec![2], ..Waves::default() };
    fixture.step(Event::Poll);
    assert!(fixture.sent(0).is_empty(), "it would overflow");
    fixture.send_part(FIRST, 1, 0);
    assert_eq!(fixture.dispatcher.counts().fence.stale, 1);
    fixture.step(Event::Answered { who: FIRST, batches: 2 });
    assert_eq!(fixture.sent(0).concat_jobs(), [0, 1]);
}

#[test]
fn a_message_that_is_rejected_and_then_missed_is_one_fault() {
    let mut fixture = Fixture::new(2, QUEUES, 8);
    for batches in 1..=2 {
        fixture.step(Event::Garbled { from: FIRST });
        fixture.step(Event::Answered { who: FIRST, batches });
        assert_eq!(fixture.killed(), []);
    }
    fixture.step(Event::Garbled { from: FIRST });
    assert_eq!(fixture.killed(), [(FIRST, Why::Garbled)]);
}

#[test]
fn a_rejected_message_excuses_one_that_is_missed_and_no_other() {
    let mut fixture = Fixture::new(2, QUEUES, 8);
    fixture.step(Event::Garbled { from: FIRST });
    for batches in 1..=3 {
        assert_eq!(fixture.killed(), []);
        fixture.step(Event::Answered { who: FIRST, batches });
    }
    assert_eq!(fixture.killed(), [(FIRST, Why::Forgetful)]);
}

/// Found by `cargo mutants`: only queues that were full at once had been tried.
#[test]
fn a_queue_that_fills_up_opens_as_soon_as_it_drains_and_numbers_go_on() {
    for is_drained in [false, true] {
        let mut fixture = Fixture::new(1, QUEUES, 4);
        assert_eq!(fixture.dispatcher.counts().batches, 2);
        assert_eq!(fixture.sent(0).len(), 2);
        fixture.step(Event::Unsent { to: FIRST, batch: 1 });
        assert!(fixture.sent(0).is_empty());
        if is_drained {
            fixture.send_part(FIRST, 0, 0);
        } else {
            fixture.now_ns = fixture.dispatcher.due_ns().expect("it is tried again");
            fixture.step(Event::Poll);
        }
        assert_eq!(fixture.sent(0), [(1, vec![(2, 0), (3, 0)])], "drained: {is_drained}");
        assert_eq!(fixture.dispatcher.counts().batches, 3);
    }
}

/// Found by `cargo mutants`: what is turned away was hardly counted.
#[test]
fn each_message_that_is_turned_away_counts_once_under_its_reason() {
    let mut fixture = Fixture::new(1, QUEUES, 3);
    let mut part = |request, job, part, last| {
        let (job, attempt) = (JobId(job), 0);
        fixture.step(Event::Part { from: FIRST, request, job, attempt, part, last, body: part });
        fixture.dispatcher.counts()
    };
    for times in 1..=3 {
        assert_eq!(part(RequestId(6), 0, 0, true).fence.stale, times);
        assert_eq!(part(NOW, 9, 0, true).fence.not_leased, times);
        assert_eq!(part(NOW, 1, 5, false).fence.gap, times);
    }
    part(NOW, 0, 0, false);
    for times in 1..=3 {
        assert_eq!(part(NOW, 0, 0, false).fence.repeated, times);
    }
    assert_eq!(part(NOW, 0, 1, true).done, 1);
    let job = JobId(0);
    for times in 4..=6 {
        fixture.step(Event::Failed { from: FIRST, request: NOW, job, attempt: 0 });
        assert_eq!(fixture.dispatcher.counts().fence.not_leased, times);
    }
    let fence = fixture.dispatcher.counts().fence;
    assert_eq!((fence.stale, fence.gap, fence.repeated, fence.sum()), (3, 3, 3, 15));
}

#[test]
fn a_result_in_parts_is_folded_in_their_order_and_its_job_is_not_run_again() {
    let mut fixture = Fixture::new(1, QUEUES, 1);
    let job = JobId(0);
    let mut part = |part, last| {
        let (from, request, attempt) = (FIRST, NOW, 0);
        fixture.step(Event::Part { from, request, job, attempt, part, last, body: part })
    };
    (0..4).for_each(|number| assert_eq!(part(number, false), Progress::Working));
    assert_eq!(part(4, true), Progress::Finished);
    let folded = (0..5).map(|part| ((0, part), 1)).collect();
    assert_eq!(fixture.work.folded, folded);
    let counts = fixture.dispatcher.counts();
    assert_eq!((counts.reissued, counts.fence.sum()), (0, 0));
}

#[test]
fn lists_that_are_given_back_are_used_again() {
    let mut fixture = Fixture::new(1, QUEUES, 40);
    let (mut jobs_seen, mut fetch_seen) = (0, 0);
    for batches in 1..=20 {
        for effect in std::mem::take(&mut fixture.said) {
            let Effect::Send { jobs: mut list, mut fetch, .. } = effect else { continue };
            (jobs_seen, fetch_seen) = (list.capacity(), fetch.capacity());
            for (job, attempt) in list.clone() {
                fixture.send_part(FIRST, job.0, attempt);
            }
            // More than any list of its own has.
            list.reserve(500);
            fetch.reserve(500);
            fixture.dispatcher.reuse(list, fetch);
        }
        fixture.step(Event::Answered { who: FIRST, batches });
    }
    assert!(jobs_seen >= 500 && fetch_seen >= 500, "{jobs_seen} and {fetch_seen}");
}

#[test]
fn each_reason_to_kill_is_told_apart() {
    let told = [Why::Garbled, Why::Forgetful, Why::Full].map(|why| why.to_string());
    assert!(told.iter().all(|text| !text.is_empty()));
    assert_eq!(BTreeSet::from(told).len(), 3);
}

trait Jobs {
    fn concat_jobs(&self) -> Vec<u32>;
}

impl Jobs for Vec<(u32, Vec<(u32, u8)>)> {
    fn concat_jobs(&self) -> Vec<u32> {
        self.iter().flat_map(|(_, jobs)| jobs.iter().map(|(job, _)| *job)).collect()
    }
}

/// Found by `cargo mutants`: nobody had answered more than two batches without a fault.
#[test]
fn who_answers_all_is_trusted_for_ever() {
    let mut fixture = Fixture::new(1, QUEUES, 40);
    let mut progress = Progress::Working;
    for batch in 0..20 {
        for job in [2 * batch, 2 * batch + 1] {
            progress = fixture.send_part(FIRST, job, 0);
        }
        fixture.step(Event::Answered { who: FIRST, batches: batch + 1 });
        assert_eq!(fixture.killed(), [], "after batch {batch}");
    }
    assert_eq!(progress, Progress::Finished);
}

/// Found by `cargo mutants`: what was answered before counts for the number of a batch.
#[test]
fn a_batch_that_finds_a_full_queue_keeps_its_number_when_those_before_are_answered() {
    let mut fixture = Fixture::new(1, QUEUES, 4);
    assert_eq!(fixture.sent(0).len(), 2);
    fixture.send_part(FIRST, 0, 0);
    fixture.send_part(FIRST, 1, 0);
    fixture.step(Event::Answered { who: FIRST, batches: 1 });
    fixture.step(Event::Unsent { to: FIRST, batch: 1 });
    fixture.now_ns = fixture.dispatcher.due_ns().expect("it is tried again");
    fixture.step(Event::Poll);
    assert_eq!(fixture.sent(0), [(1, vec![(2, 0), (3, 0)])]);
}

/// Found by `cargo mutants`: what was answered holds no slot in the next request.
#[test]
fn only_jobs_without_a_result_hold_slots_in_the_next_request() {
    let mut fixture = Fixture::new(1, QUEUES, 4);
    fixture.send_part(FIRST, 0, 0);
    fixture.send_part(FIRST, 2, 0);
    assert_eq!(fixture.step(Event::Expired), Progress::Finished);
    fixture.said.clear();
    fixture.dispatcher.begin(RequestId(8));
    fixture.work = Waves { left: vec![2], ..Waves::default() };
    fixture.step(Event::Poll);
    assert_eq!(fixture.sent(0).concat_jobs(), [0, 1], "two slots of four are free");
}
