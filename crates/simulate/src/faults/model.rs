//! All states of small worlds, by stateright: the same dispatcher, with faults that may strike at
//! any moment, each a given number of times.
//!
//! `cargo x model` runs the large ones and prints how many states there are.

use core::hash::{Hash, Hasher};
use dispatch::{
    BestMatchLoad, Cache, Closed, Dispatcher, DispatcherFlaw, Effect, Event, Job, JobSource,
    Progress, Queues,
};
use protocol::{Incarnation, JobId, RequestId, Section, TaskId};
use stateright::{Checker, Model, Property};

const REQUEST: RequestId = RequestId(1);

/// How often each fault may strike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Budget {
    crashes: u8,
    hangs: u8,
    losses: u8,
    repeats: u8,
    garbles: u8,
    spawns: u8,
}

const NONE: Budget = Budget { crashes: 0, hangs: 0, losses: 0, repeats: 0, garbles: 0, spawns: 0 };

/// A small world.
#[derive(Clone, Debug)]
struct Small {
    jobs: u32,
    workers: u8,
    batch: u32,
    /// A job that crashes every worker that starts it.
    poison: Option<u32>,
    budget: Budget,
    flaw: Option<DispatcherFlaw>,
}

/// Each job finds a bit of its own.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct Sums {
    left: u32,
    sum: Vec<u8>,
    closed: Vec<Vec<u8>>,
}

impl JobSource for Sums {
    type Part<'p> = ();

    fn more(&mut self, jobs: &mut Vec<Job>) {
        for node in 0..std::mem::take(&mut self.left) {
            let section = Section { model: 0, node };
            jobs.push(Job { task: TaskId(0), a: section, b: section });
        }
    }
    fn is_obsolete(&self, _: &Job) -> bool {
        false
    }
    fn fold(&mut self, job: &Job, (): ()) {
        self.sum[job.a.node as usize] += 1;
    }
    fn close(&mut self, job: &Job, how: Closed) {
        self.closed[job.a.node as usize].push(how as u8);
    }
    fn weight(&self, _: Section) -> u64 {
        1
    }
}

/// The dispatcher, compared and hashed by the state that decides.
#[derive(Clone, Debug)]
struct Judge(Dispatcher<BestMatchLoad>);

impl PartialEq for Judge {
    fn eq(&self, other: &Self) -> bool {
        self.0.essence() == other.0.essence()
    }
}
impl Eq for Judge {}
impl Hash for Judge {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.essence().hash(state);
    }
}

type Held = (JobId, u8);

/// A worker: what it has, what it has started, how many batches were sent to it, and how many of
/// them it has answered.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Actor {
    who: Incarnation,
    is_alive: bool,
    is_hung: bool,
    batches: Vec<(u32, Vec<Held>)>,
    started: Option<Held>,
    sent: u32,
    answered: u32,
}

impl Actor {
    fn new(who: Incarnation) -> Self {
        let (batches, started) = (Vec::new(), None);
        Self { who, is_alive: true, is_hung: false, batches, started, sent: 0, answered: 0 }
    }

    /// Whether it makes no progress although batches are unanswered: then it is detected and
    /// killed.
    fn is_silent(&self) -> bool {
        let is_idle = self.started.is_none() && self.batches.is_empty();
        self.is_hung || is_idle && self.answered < self.sent
    }
}

/// A message to the coordinator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Mail {
    Part(Incarnation, JobId, u8),
    Garbled(Incarnation),
    Answered(Incarnation, u32),
    Lost(Incarnation, Option<Held>),
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct State {
    judge: Judge,
    work: Sums,
    actors: Vec<Actor>,
    /// In order per sender, as channels are; a repeated one comes at any time.
    mail: Vec<Mail>,
    stray: Vec<Mail>,
    budget: Budget,
    progress: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Action {
    Start(usize),
    Finish(usize),
    Crash(usize),
    Hang(usize),
    Reap(usize),
    Respawn(usize),
    Deliver(usize),
    Lose(usize),
    Repeat(usize),
    Garble(usize),
    Stray(usize),
    LoseBatch(usize),
    GarbleBatch(usize),
}

impl State {
    fn step(&mut self, event: Event<()>) {
        let mut effects = Vec::new();
        let progress = self.judge.0.step(0, event, &mut self.work, &mut effects);
        self.progress = u8::from(progress == Progress::Finished);
        for effect in effects {
            match effect {
                Effect::Send { to, batch, jobs, .. } => {
                    let actor = &mut self.actors[usize::from(to.worker)];
                    if actor.who == to && actor.is_alive {
                        actor.sent = batch + 1;
                        actor.batches.push((batch, jobs));
                    }
                }
                Effect::Kill { who, .. } => {
                    let actor = &self.actors[usize::from(who.worker)];
                    if actor.who == who && actor.is_alive {
                        self.die(usize::from(who.worker));
                    }
                }
            }
        }
    }

    fn die(&mut self, number: usize) {
        let actor = &mut self.actors[number];
        actor.is_alive = false;
        actor.batches.clear();
        let lost = Mail::Lost(actor.who, actor.started);
        self.mail.push(lost);
    }

    /// Whether a message is the oldest of its sender.
    fn is_first(&self, at: usize) -> bool {
        let sender = |mail: &Mail| match mail {
            Mail::Part(who, ..)
            | Mail::Garbled(who)
            | Mail::Answered(who, _)
            | Mail::Lost(who, _) => *who,
        };
        !self.mail[..at].iter().any(|mail| sender(mail) == sender(&self.mail[at]))
    }

    fn hear(&mut self, mail: Mail) {
        self.step(match mail {
            Mail::Part(from, job, attempt) => {
                Event::Part { from, request: REQUEST, job, attempt, part: 0, last: true, body: () }
            }
            Mail::Garbled(from) => Event::Garbled { from },
            Mail::Answered(who, batches) => Event::Answered { who, batches },
            Mail::Lost(who, started) => Event::Lost { who, started },
        });
    }

    /// The current batch is done, or was rejected.
    fn answer(&mut self, number: usize, batches: u32) {
        let actor = &mut self.actors[number];
        actor.batches.remove(0);
        actor.answered = actor.answered.max(batches);
        let mail = Mail::Answered(actor.who, actor.answered);
        self.mail.push(mail);
    }
}

impl Model for Small {
    type State = State;
    type Action = Action;

    fn init_states(&self) -> Vec<State> {
        let queues = Queues { capacity: 2 * self.batch, batch: self.batch, linger_ns: 0 };
        let scheme = BestMatchLoad { alpha: 0.0 };
        let mut dispatcher = Dispatcher::new(scheme, queues, Cache::Unlimited, self.workers.into());
        dispatcher.corrupt(self.flaw);
        dispatcher.begin(REQUEST);
        let lives = (0..self.workers).map(|worker| Incarnation { worker, inc: 0 });
        lives.clone().for_each(|who| dispatcher.admit(who));
        let jobs = self.jobs as usize;
        let mut state = State {
            judge: Judge(dispatcher),
            work: Sums { left: self.jobs, sum: vec![0; jobs], closed: vec![Vec::new(); jobs] },
            actors: lives.map(Actor::new).collect(),
            mail: Vec::new(),
            stray: Vec::new(),
            budget: self.budget,
            progress: 0,
        };
        state.step(Event::Poll);
        vec![state]
    }

    fn actions(&self, state: &State, actions: &mut Vec<Action>) {
        let budget = &state.budget;
        for (number, actor) in state.actors.iter().enumerate() {
            if !actor.is_alive {
                let is_noticed =
                    !state.mail.iter().any(|m| matches!(m, Mail::Lost(w, _) if *w == actor.who));
                if budget.spawns > 0 && is_noticed {
                    actions.push(Action::Respawn(number));
                }
                continue;
            }
            if actor.is_silent() {
                actions.push(Action::Reap(number));
            }
            if actor.is_hung {
                continue;
            }
            if actor.started.is_some() {
                actions.push(Action::Finish(number));
            } else if !actor.batches.is_empty() {
                actions.push(Action::Start(number));
                if budget.losses > 0 {
                    actions.push(Action::LoseBatch(number));
                }
                if budget.garbles > 0 {
                    actions.push(Action::GarbleBatch(number));
                }
            }
            if budget.crashes > 0 {
                actions.push(Action::Crash(number));
            }
            if budget.hangs > 0 && actor.started.is_some() {
                actions.push(Action::Hang(number));
            }
        }
        for at in 0..state.mail.len() {
            if !state.is_first(at) {
                continue;
            }
            actions.push(Action::Deliver(at));
            if let Mail::Part(..) = state.mail[at] {
                if budget.losses > 0 {
                    actions.push(Action::Lose(at));
                }
                if budget.repeats > 0 {
                    actions.push(Action::Repeat(at));
                }
                if budget.garbles > 0 {
                    actions.push(Action::Garble(at));
                }
            }
        }
        actions.extend((0..state.stray.len()).map(Action::Stray));
    }

    fn next_state(&self, state: &State, action: Action) -> Option<State> {
        let mut next = state.clone();
        match action {
            Action::Start(number) => {
                let actor = &mut next.actors[number];
                let batch = actor.batches.first_mut()?;
                if batch.1.is_empty() {
                    let answered = batch.0 + 1;
                    next.answer(number, answered);
                    return Some(next);
                }
                let held = batch.1.remove(0);
                actor.started = Some(held);
                if self.poison == Some(held.0.0) {
                    next.die(number);
                }
            }
            Action::Finish(number) => {
                let actor = &mut next.actors[number];
                let (job, attempt) = actor.started.take()?;
                let mail = Mail::Part(actor.who, job, attempt);
                next.mail.push(mail);
            }
            Action::Crash(number) => {
                next.budget.crashes -= 1;
                next.die(number);
            }
            Action::Hang(number) => {
                next.budget.hangs -= 1;
                next.actors[number].is_hung = true;
            }
            Action::Reap(number) => next.die(number),
            Action::Respawn(number) => {
                next.budget.spawns -= 1;
                let who = next.actors[number].who;
                let who = Incarnation { inc: who.inc + 1, ..who };
                next.actors[number] = Actor::new(who);
                next.step(Event::Ready(who));
            }
            Action::Deliver(at) => {
                let mail = next.mail.remove(at);
                next.hear(mail);
            }
            Action::Lose(at) => {
                next.budget.losses -= 1;
                next.mail.remove(at);
            }
            Action::Repeat(at) => {
                next.budget.repeats -= 1;
                let mail = next.mail[at];
                next.stray.push(mail);
            }
            Action::Garble(at) => {
                next.budget.garbles -= 1;
                if let Mail::Part(who, ..) = next.mail[at] {
                    next.mail[at] = Mail::Garbled(who);
                }
            }
            Action::Stray(at) => {
                let mail = next.stray.remove(at);
                next.hear(mail);
            }
            Action::LoseBatch(number) => {
                next.budget.losses -= 1;
                next.actors[number].batches.remove(0);
            }
            Action::GarbleBatch(number) => {
                next.budget.garbles -= 1;
                let answered = next.actors[number].answered + 1;
                next.answer(number, answered);
            }
        }
        Some(next)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::always("counted once", |_, state: &State| {
                state.work.sum.iter().all(|sum| *sum <= 1)
                    && state.work.closed.iter().all(|closed| closed.len() <= 1)
            }),
            Property::always("done is found", |_, state: &State| {
                let pairs = state.work.sum.iter().zip(&state.work.closed);
                pairs
                    .into_iter()
                    .all(|(sum, closed)| closed.first() != Some(&(Closed::Done as u8)) || *sum == 1)
            }),
            Property::always("poison takes two", |model: &Self, state: &State| {
                let by_chance = model.budget.crashes + model.budget.hangs + model.budget.losses;
                let deaths: u32 = state.actors.iter().map(|actor| actor.who.inc).sum();
                let deaths = deaths + state.actors.iter().filter(|a| !a.is_alive).count() as u32;
                let distrusted = u32::from(model.budget.losses + model.budget.garbles) / 3;
                deaths <= 2 + u32::from(by_chance) + distrusted
            }),
            Property::always("no job is lost", |model: &Self, state: &State| {
                let mut actions = Vec::new();
                model.actions(state, &mut actions);
                let is_alive = state.actors.iter().any(|actor| actor.is_alive);
                !actions.is_empty() || state.progress == 1 || !is_alive
            }),
        ]
    }
}

/// Explores all states: how many there are, and which property fails first after how many steps.
fn check(name: &str, model: Small) -> (usize, Option<&'static str>) {
    let checker = model.checker().threads(2).spawn_bfs().join();
    let states = checker.unique_state_count();
    let found = checker.discoveries();
    let failed = found.keys().next().copied();
    let steps =
        failed.and_then(|name| found.get(name)).map(|path| path.clone().into_actions().len());
    println!("{name}: {states} states, {failed:?} after {steps:?} steps");
    (states, failed)
}

const SMALL: Small =
    Small { jobs: 2, workers: 2, batch: 1, poison: None, budget: NONE, flaw: None };

#[test]
fn small_worlds_keep_the_laws_in_every_state() {
    let one = Budget { crashes: 1, spawns: 1, ..NONE };
    for (name, model) in [
        ("crash", Small { budget: one, ..SMALL }),
        ("crash, loss, repeat", Small { budget: Budget { losses: 1, repeats: 1, ..one }, ..SMALL }),
        ("hang, garble", Small { budget: Budget { hangs: 1, garbles: 1, ..one }, ..SMALL }),
        ("poison", Small { poison: Some(1), budget: Budget { spawns: 2, ..NONE }, ..SMALL }),
    ] {
        assert_eq!(check(name, model).1, None, "{name}");
    }
}

#[test]
fn in_small_worlds_mistakes_are_caught() {
    let budget = Budget { crashes: 1, spawns: 1, repeats: 1, ..NONE };
    for flaw in DispatcherFlaw::ALL {
        let (states, failed) =
            check(&format!("{flaw:?}"), Small { flaw: Some(flaw), budget, ..SMALL });
        assert!(failed.is_some() && states > 0, "{flaw:?} was not caught");
    }
}

#[test]
#[ignore = "minutes: cargo x model"]
fn larger_worlds_keep_the_laws_in_every_state() {
    let two = Budget { crashes: 2, spawns: 2, ..NONE };
    for (name, model) in [
        ("2 jobs, 2 crashes", Small { budget: two, ..SMALL }),
        ("3 jobs, crash", Small { jobs: 3, budget: Budget { crashes: 1, ..two }, ..SMALL }),
        (
            // A lost batch, and a rejected one after it: its worker counts one too few.
            "3 jobs, crash, loss, garble",
            Small { jobs: 3, budget: Budget { crashes: 1, losses: 1, garbles: 1, ..two }, ..SMALL },
        ),
        (
            "2 jobs, 2 crashes, hang, loss, repeat",
            Small { budget: Budget { hangs: 1, losses: 1, repeats: 1, ..two }, ..SMALL },
        ),
        (
            "3 jobs, crash, 2 losses, 2 garbles, repeat",
            Small {
                jobs: 3,
                budget: Budget { crashes: 1, losses: 2, garbles: 2, repeats: 1, ..two },
                ..SMALL
            },
        ),
        (
            "3 jobs, poison, crash",
            Small { jobs: 3, poison: Some(1), budget: Budget { crashes: 1, ..two }, ..SMALL },
        ),
        (
            "4 jobs in batches of 2, crash, loss",
            Small { jobs: 4, batch: 2, budget: Budget { losses: 1, crashes: 1, ..two }, ..SMALL },
        ),
    ] {
        assert_eq!(check(name, model).1, None, "{name}");
    }
}
