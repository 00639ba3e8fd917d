//! Laws of the clocks: no core does two things at once, nothing is learnt before it is seen, and
//! what is done by one core takes as long as it took here.

use super::*;
use crate::looks::AskedLook;
use bvh::Counters;
use bvh::query::QueryWatch;
use executor::encounter::LookOutcome;

/// Looks in chains, each of which is asked for when the one before is learnt.
#[derive(Default)]
struct Chains {
    ready: VecDeque<usize>,
    /// By chain: looks to come, and how long those that were done took (ns).
    left: Vec<u32>,
    took_ns: Vec<u64>,
    spare: u32,
    learnt: u32,
}

/// Does nothing for so long.
fn spin(ns: u64) -> u64 {
    let begun_ns = clock::now_ns();
    while clock::now_ns() - begun_ns < ns {
        core::hint::spin_loop();
    }
    clock::now_ns() - begun_ns
}

impl LookSource for Chains {
    type Id = usize;

    fn next(&mut self) -> Option<usize> {
        spin(2_000);
        self.ready.pop_front()
    }

    fn asked(&self, _: usize) -> AskedLook<'_> {
        unreachable!("nobody else looks")
    }

    fn look(&mut self, chain: usize, _: QueryWatch<'_>) -> Option<(LookOutcome, Counters)> {
        self.took_ns[chain] += spin(20_000 * (chain as u64 + 1));
        Some((LookOutcome::Never, Counters { nb: 1, np: 0 }))
    }

    fn learn(&mut self, chain: usize, seen: Option<LookOutcome>) {
        assert!(seen.is_some());
        self.learnt += 1;
        self.left[chain] -= 1;
        if self.left[chain] > 0 {
            self.ready.push_back(chain);
        }
    }

    fn use_spare_time(&mut self) -> bool {
        let is_left = self.spare > 0;
        self.spare = self.spare.saturating_sub(1);
        spin(if is_left { 5_000 } else { 0 });
        is_left
    }
}

/// Four chains of looks on these cores: how long it took, and how long the looks of each.
fn looked(setup: VirtualSetup) -> (VirtualTime, Vec<u64>) {
    let mut cores = VirtualCores::new(setup, InProcessExecutor::with_room_for(&[]));
    let (left, took_ns) = (vec![5; 4], vec![0; 4]);
    let mut chains = Chains { ready: (0..4).collect(), left, took_ns, spare: 8, learnt: 0 };
    let effort = cores.look(&mut chains);
    cores.end();
    assert_eq!((chains.learnt, effort.jobs, effort.counters.nb), (20, 20, 20));
    (cores.time().clone(), chains.took_ns)
}

const COSTS: MessageCosts =
    MessageCosts { hand_out_ns: 700, flight_ns: 300, send_ns: 900, take_ns: 1_100, thread_ns: 0 };

#[test]
fn no_core_does_two_things_at_once_and_no_chain_overtakes_itself() {
    for workers in 1..=5 {
        for (is_shared, costs) in [(false, COSTS), (true, COSTS), (false, MessageCosts::default())]
        {
            let (time, took_ns) = looked(VirtualSetup { workers, is_shared, costs });
            let busy: u64 = time.busy_ns.iter().sum();
            let cores = workers as u64 + u64::from(!is_shared);
            assert_eq!(time.busy_ns.len(), workers);
            assert!(time.total_ns * cores >= time.coordinator_ns + busy, "{time:?}");
            assert!(time.busy_ns.iter().all(|busy_ns| *busy_ns <= time.total_ns), "{time:?}");
            assert!(took_ns.iter().all(|took_ns| *took_ns <= time.total_ns), "{time:?}");
            // Every job is somebody's, and every message costs what it costs.
            let messages = 20 * (costs.hand_out_ns + costs.take_ns + costs.send_ns);
            assert_eq!(time.coordinator_ns + busy, time.alone_ns + messages);
            assert!(time.total_ns <= time.alone_ns + messages + 40 * costs.flight_ns, "{time:?}");
        }
    }
}

#[test]
fn one_core_takes_as_long_as_it_took_here() {
    let costs = MessageCosts::default();
    let (time, _) = looked(VirtualSetup { workers: 1, is_shared: true, costs });
    assert_eq!(time.total_ns, time.alone_ns);
}

#[test]
fn who_helps_delays_the_worker_of_its_core_if_that_is_at_work() {
    let costs = MessageCosts::default();
    // With one core for both, the first worker waits for what the coordinator does itself.
    for (is_shared, delayed) in [(false, [false, true]), (true, [true, true])] {
        let setup = VirtualSetup { workers: 2, is_shared, costs };
        let mut cores = VirtualCores::new(setup, InProcessExecutor::with_room_for(&[]));
        cores.begin(clock::now_ns());
        // Both are at work for a second, the first one longer.
        let ends_ns = [1_000_000_001, 1_000_000_000];
        for (worker, end_ns) in cores.workers.iter_mut().zip(ends_ns) {
            worker.free_ns = end_ns;
            worker.sent_ns.push_back(end_ns);
        }
        let helper = cores.idle_cores().without(usize::from(!is_shared));
        assert_eq!(helper.threads(), 2);
        helper.map(&mut (), 2, |(), _| spin(50_000));
        cores.count();
        let ends = cores.workers.iter().map(|worker| (worker.free_ns, worker.sent_ns[0]));
        for (number, (free_ns, sent_ns)) in ends.enumerate() {
            assert_eq!(free_ns, sent_ns);
            let by_ns = free_ns - ends_ns[number];
            assert_eq!(by_ns >= 50_000, delayed[number], "{number}: {by_ns}");
        }
        assert!(cores.time.alone_ns >= 100_000 && cores.time.coordinator_ns < cores.time.alone_ns);
    }
}
