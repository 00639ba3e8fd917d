//! The course of one candidate: the ego's way, whom it has met, and whom it meets next.
//!
//! ```text
//! planned path --first contacts with everybody--> the earliest --assess-> light: the path goes on
//!                          ^                                             heavy: a run-out, and the
//!                          +------------- what may come after ------------- way is searched anew
//! ```
//!
//! After a light contact with a party the bodies usually overlap for a while: the ego drives past
//! or over it. A later contact with that party counts once they were apart. As long as they touch,
//! the contact is assessed again and again, after [`PASSED_M`] of travel or sooner, and where it is
//! heavy, that is the contact: so a first touch of a mirror does not hide a crash.

use super::member::Member;
use body::{BodyView, Meta, Shells};
use damage::course::{PASSED_M, RunOut};
use executor::encounter::{Encounters, Look, LookOutcome, Nested, Touching, Ways};
use geometry::Pose;
use geometry::motion::{MotionPath, State};
use scenario::{Candidate, Motion, Scenario};
use std::sync::Arc;

/// How often a run-out has a state (s): its speed falls so little that it is within 0.3 mm of the
/// path.
const RUN_OUT_STEP_S: f64 = 0.02;
/// Least and greatest step with which bodies that still touch are looked at again (s).
const STEP_MIN_S: f64 = 0.01;
const STEP_MAX_S: f64 = 0.1;

/// What is known of a party on this way.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Ahead {
    /// From this time on (s) nothing is known. `still`: they touched before, and may still do.
    Unknown { from_s: f64, still: Option<Still> },
    /// It is met next.
    Contact(NextContact),
    /// It is not met on this way.
    Clear,
    /// It was struck heavily, or is the ego: it is not met again on any way.
    Done,
    /// The search gave up: from this time on (s) everything is open.
    Open { from_s: f64 },
}

/// Bodies that have touched, and may still do.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Still {
    /// How long they take to pass each other (s).
    step_s: f64,
    /// What a look at them is: [`Begin::AtStart`] as long as they part from the start.
    look: Begin,
}

/// How a contact came to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Begin {
    /// The bodies were apart before.
    Touched,
    /// They touch at time 0, or have touched since then and parted so far.
    AtStart,
    /// They have touched before and not parted: the contact is assessed once more.
    Again,
}

/// A contact that comes next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NextContact {
    pub(crate) party: usize,
    pub(crate) begin: Begin,
    pub(crate) touching: Touching,
}

/// Bodies and motions of a request.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scenery<'s> {
    pub(crate) scenario: &'s Scenario,
    pub(crate) bodies: &'s [(Meta, BodyView<'s>)],
    /// Party i has body `models[i]`.
    pub(crate) models: &'s [usize],
    /// The shells of each body.
    pub(crate) shells: &'s [Shells],
}

impl<'s> Scenery<'s> {
    pub(crate) fn body(&self, party: usize) -> &'s (Meta, BodyView<'s>) {
        &self.bodies[self.models[party]]
    }

    /// The ego and a party on two paths.
    pub(crate) fn ways<'p>(&self, party: usize, paths: [&'p MotionPath; 2]) -> Ways<'p>
    where
        's: 'p,
    {
        let models = [self.scenario.ego.0, party].map(|party| self.models[party]);
        Ways { bodies: models.map(|model| self.bodies[model].1), paths }
    }

    /// The shells of the ego and of a party.
    pub(crate) fn shells_of(&self, party: usize) -> [&'s Shells; 2] {
        [self.scenario.ego.0, party].map(|party| &self.shells[self.models[party]])
    }

    /// The bodies of the ego and of a party: their numbers in the store.
    pub(crate) fn numbers(&self, party: usize) -> [u32; 2] {
        [self.scenario.ego.0, party].map(|party| self.models[party] as u32)
    }

    /// How a party moves in a candidate: as it reacts, or as is most probable.
    pub(crate) fn motion(&self, candidate: &'s Candidate, party: usize) -> &'s Motion {
        let reacts = candidate.reactions.iter().find(|reaction| reaction.party.0 == party);
        reacts.map_or_else(|| self.likeliest(party).1, |reaction| &reaction.motion)
    }

    /// The most probable of the predicted motions, the first of equals, and its number.
    pub(crate) fn likeliest(&self, party: usize) -> (usize, &'s Motion) {
        let all = self.scenario.parties[party].predictions.iter().enumerate();
        let most = all.reduce(
            |most, next| {
                if next.1.probability > most.1.probability { next } else { most }
            },
        );
        let (number, prediction) = most.expect("every party but the ego has a prediction");
        (number, &prediction.motion)
    }

    /// Everybody but the ego.
    pub(crate) fn others(&self) -> impl Iterator<Item = usize> + use<> {
        let ego = self.scenario.ego.0;
        (0..self.scenario.parties.len()).filter(move |party| *party != ego)
    }
}

/// The part of a way after a heavy contact.
#[derive(Clone, Debug)]
pub(crate) struct Leg {
    /// When it begins (s).
    pub(crate) from_s: f64,
    pub(crate) run_out: RunOut,
    /// Its path; `None`: it begins where the way ends.
    path: Option<MotionPath>,
}

/// The way of one candidate.
#[derive(Clone, Debug)]
pub(crate) struct Way<'s> {
    scenery: Scenery<'s>,
    member: Arc<Member<'s>>,
    /// Number of the candidate.
    candidate: usize,
    /// Where the ego went after heavy contacts, in the order of time.
    pub(crate) run_outs: Vec<Leg>,
    /// Until when contacts are looked for (s).
    pub(crate) end_s: f64,
    /// Per party.
    ahead: Vec<Ahead>,
    /// Per party: after a light contact, from when on (s) they may be apart again.
    passing: Vec<Option<(f64, Still)>>,
    /// The first time (s) from which on it is left open what happens, if it is.
    pub(crate) open_from_s: Option<f64>,
    /// Parties that were touched at the start and part.
    pub(crate) passed_at_start: Vec<usize>,
    /// Parties that may lie inside the ego at the start, or the ego inside them: no answer.
    pub(crate) undecided_at_start: Vec<usize>,
    /// Parties that still touch at the end of the way.
    pub(crate) touching_at_end: Vec<usize>,
}

impl<'s> Way<'s> {
    /// The way of a candidate, by its number, in a member.
    pub(crate) fn new(scenery: Scenery<'s>, member: Arc<Member<'s>>, candidate: usize) -> Self {
        let start = Ahead::Unknown { from_s: 0.0, still: None };
        let mut ahead = vec![start; scenery.scenario.parties.len()];
        ahead[scenery.scenario.ego.0] = Ahead::Done;
        Self {
            scenery,
            member,
            candidate,
            run_outs: Vec::new(),
            end_s: scenery.scenario.horizon_s,
            passing: vec![None; ahead.len()],
            ahead,
            open_from_s: None,
            passed_at_start: Vec::new(),
            undecided_at_start: Vec::new(),
            touching_at_end: Vec::new(),
        }
    }

    /// Where the ego goes now: as planned, or on its last run-out.
    pub(crate) fn ego_path(&self) -> &MotionPath {
        let last = self.run_outs.last().and_then(|leg| leg.path.as_ref());
        last.unwrap_or_else(|| self.planned())
    }

    /// Where the ego goes if nothing happens.
    fn planned(&self) -> &MotionPath {
        self.member.ego(self.candidate)
    }

    /// The member in which it is followed.
    pub(crate) fn member(&self) -> &Member<'s> {
        &self.member
    }

    /// What a heavy contact lets the ego do.
    pub(crate) fn run_out(&self, usual: RunOut) -> RunOut {
        self.member.run_out(usual)
    }

    /// Where the ego is at a time (s), wherever it went before.
    pub(crate) fn ego_at(&self, time_s: f64) -> Pose {
        let mut legs = self.run_outs.iter().rev().filter(|leg| leg.from_s <= time_s);
        let path = legs.find_map(|leg| leg.path.as_ref());
        path.unwrap_or_else(|| self.planned()).pose_at(time_s)
    }

    /// The ways of the ego and of a party.
    pub(crate) fn ways(&self, party: usize) -> Ways<'_> {
        let candidate = &self.scenery.scenario.candidates[self.candidate];
        let path = self.member.other((self.candidate, candidate), party);
        self.scenery.ways(party, [self.ego_path(), path])
    }

    /// Settles what takes no look: what lies behind the end of the way, and who lies inside whom at
    /// the start.
    pub(crate) fn prepare(&mut self, encounters: &mut Encounters) {
        for party in 0..self.ahead.len() {
            let Ahead::Unknown { from_s, still } = self.ahead[party] else { continue };
            if from_s >= self.end_s {
                if still.is_some() {
                    self.touching_at_end.push(party);
                }
                self.ahead[party] = Ahead::Clear;
            } else if from_s <= 0.0 && still.is_none() && self.run_outs.is_empty() {
                match self.member.nested(&self.scenery, party, encounters) {
                    Nested::No => {}
                    Nested::Yes(touching) => {
                        let begin = Begin::AtStart;
                        self.ahead[party] = Ahead::Contact(NextContact { party, begin, touching });
                    }
                    Nested::Undecided if self.undecided_at_start.contains(&party) => {}
                    Nested::Undecided => self.undecided_at_start.push(party),
                }
            }
        }
    }

    /// Whether looks are needed to know what comes next.
    pub(crate) fn needs_looks(&self) -> bool {
        let is_unknown = |ahead: &Ahead| matches!(ahead, Ahead::Unknown { .. });
        self.open_from_s.is_none() && self.ahead.iter().any(is_unknown)
    }

    /// The looks that are needed, and at whom.
    pub(crate) fn looks(&self) -> impl Iterator<Item = (usize, Look<'_>)> {
        let is_unknown = |party: &usize| matches!(self.ahead[*party], Ahead::Unknown { .. });
        (0..self.ahead.len()).filter(is_unknown).map(|party| (party, self.look(party)))
    }

    /// The look at a party of which nothing is known from some time on.
    ///
    /// # Panics
    ///
    /// All that is needed of it is known.
    pub(crate) fn look(&self, party: usize) -> Look<'_> {
        let Ahead::Unknown { from_s, still } = self.ahead[party] else {
            panic!("nobody asks for a look at what is known")
        };
        Look {
            ways: self.ways(party),
            from_s,
            end_s: self.end_s,
            resolution_m: self.scenery.scenario.resolution_m,
            may_touch: still.is_some(),
        }
    }

    /// Takes what a look at a party showed; `None`: it was not done.
    pub(crate) fn learn(
        &mut self,
        party: usize,
        seen: Option<LookOutcome>,
        encounters: &mut Encounters,
    ) {
        let Ahead::Unknown { from_s, still } = self.ahead[party] else { return };
        let contact = |begin, touching| Ahead::Contact(NextContact { party, begin, touching });
        self.ahead[party] = match (seen, still) {
            (None, _) => Ahead::Open { from_s },
            (Some(LookOutcome::Never), _) => Ahead::Clear,
            (Some(LookOutcome::Contact(touching)), _) => {
                let is_at_start = touching.time_s <= 0.0 && self.run_outs.is_empty();
                contact(if is_at_start { Begin::AtStart } else { Begin::Touched }, touching)
            }
            (Some(LookOutcome::Still(touching)), still) => {
                contact(still.map_or(Begin::Again, |still| still.look), touching)
            }
            (Some(LookOutcome::Hidden), still) => {
                let (ways, shells) = (self.ways(party), self.scenery.shells_of(party));
                let nested = encounters.hidden(&ways, shells, from_s);
                match still.filter(|_| matches!(nested, Nested::Yes(_))) {
                    // Inside, without a triangle that touches, there is nothing to assess.
                    Some(still) => {
                        Ahead::Unknown { from_s: from_s + still.step_s, still: Some(still) }
                    }
                    None => Ahead::Unknown { from_s, still: None },
                }
            }
        };
    }

    /// The contact that comes next; `None` at the end of the way, or if what comes next is open or
    /// needs a look.
    pub(crate) fn next(&mut self) -> Option<NextContact> {
        if self.open_from_s.is_some() {
            return None;
        }
        let mut next: Option<NextContact> = None;
        let mut open_s = f64::INFINITY;
        for ahead in &self.ahead {
            match ahead {
                Ahead::Contact(meeting) => {
                    let is_earlier =
                        |next: NextContact| meeting.touching.time_s < next.touching.time_s;
                    if next.is_none_or(is_earlier) {
                        next = Some(*meeting);
                    }
                }
                Ahead::Open { from_s } => open_s = open_s.min(*from_s),
                Ahead::Unknown { .. } => return None,
                Ahead::Clear | Ahead::Done => {}
            }
        }
        // What is open may come first.
        if next.is_none_or(|next| next.touching.time_s >= open_s) && open_s.is_finite() {
            self.open_from_s = Some(open_s);
            return None;
        }
        next
    }

    /// Whether all is known until the end of the way.
    pub(crate) fn is_at_end(&self) -> bool {
        self.ahead.iter().all(|ahead| matches!(ahead, Ahead::Clear | Ahead::Done))
    }

    /// Leaves open whatever is not known.
    pub(crate) fn give_up(&mut self) {
        self.open_from_s = self.unknown_from_s();
    }

    /// The first time (s) from which on something is not known; `None` at the end of the way.
    pub(crate) fn unknown_from_s(&self) -> Option<f64> {
        let from_s = |ahead: &Ahead| match ahead {
            Ahead::Unknown { from_s, .. } | Ahead::Open { from_s } => Some(*from_s),
            Ahead::Contact(meeting) => Some(meeting.touching.time_s),
            Ahead::Clear | Ahead::Done => None,
        };
        self.ahead.iter().filter_map(from_s).min_by(f64::total_cmp)
    }

    /// Whether a light contact with a party may still give way to a heavy one of the same crash.
    pub(crate) fn may_give_way(&self, party: usize) -> bool {
        self.passing[party].is_some_and(|(_, still)| still.look == Begin::Again)
    }

    /// How long bodies take to pass each other, given their closing speed (m/s) and the extent of
    /// the smaller one along it (m).
    fn step_s(closing_m_s: f64, extent_m: f64) -> f64 {
        // Slow bodies may become faster before they have passed.
        (extent_m.min(PASSED_M) / closing_m_s).clamp(STEP_MIN_S, STEP_MAX_S)
    }

    /// Goes on after a light contact.
    pub(crate) fn pass(&mut self, meeting: &NextContact, closing_m_s: f64, extent_m: f64) {
        let step_s = Self::step_s(closing_m_s, extent_m);
        self.go_on(meeting, Still { step_s, look: Begin::Again });
    }

    /// Goes on after bodies that touched at the start and part.
    pub(crate) fn let_part(&mut self, meeting: &NextContact, closing_m_s: f64, extent_m: f64) {
        let step_s = Self::step_s(closing_m_s, extent_m);
        self.go_on(meeting, Still { step_s, look: Begin::AtStart });
        if meeting.touching.time_s <= 0.0 {
            self.passed_at_start.push(meeting.party);
        }
    }

    fn go_on(&mut self, meeting: &NextContact, still: Still) {
        let from_s = meeting.touching.time_s + still.step_s;
        self.passing[meeting.party] = Some((from_s, still));
        self.ahead[meeting.party] = Ahead::Unknown { from_s, still: Some(still) };
    }

    /// Leaves the planned path after a heavy contact: from there on everybody else may be met.
    pub(crate) fn leave(&mut self, meeting: &NextContact, run_out: RunOut) {
        let at_s = meeting.touching.time_s;
        self.end_s = self.scenery.scenario.horizon_s.min(at_s + run_out.lasts_s());
        let start = self.ego_path().state_at(at_s);
        self.ahead[meeting.party] = Ahead::Done;
        self.touching_at_end.clear();
        for (ahead, passing) in self.ahead.iter_mut().zip(&self.passing) {
            if *ahead != Ahead::Done {
                let (from_s, still) =
                    passing.map_or((at_s, None), |(from_s, still)| (from_s.max(at_s), Some(still)));
                *ahead = Ahead::Unknown { from_s, still };
            }
        }
        let path = run_out_path(&start, &run_out, self.end_s);
        if path.is_none() {
            // It stays where it is, at the end of its way.
            self.end_s = at_s;
        }
        self.run_outs.push(Leg { from_s: at_s, run_out, path });
    }
}

/// The path of a run-out until a time (s); `None` if there is no time left.
fn run_out_path(start: &State, run_out: &RunOut, end_s: f64) -> Option<MotionPath> {
    let begin_s = start.time_s;
    let steps = ((end_s - begin_s) / RUN_OUT_STEP_S).ceil();
    if !(steps >= 1.0) {
        return None;
    }
    let state = |k: usize| {
        let time_s = (begin_s + k as f64 * RUN_OUT_STEP_S).min(end_s);
        let [x, y] = run_out.travel_m(time_s - begin_s);
        let [p, q, z] = start.position_m;
        State { time_s, position_m: [p + x, q + y, z], orientation: start.orientation }
    };
    let mut states: Vec<State> = (0..=steps as usize).map(state).collect();
    states.dedup_by(|next, before| next.time_s <= before.time_s);
    MotionPath::new(&states).ok()
}
