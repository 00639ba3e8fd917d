//! Trials of the bounds of courses: the work on a request is stopped anywhere, and what is then
//! said is checked against the finished work.
//!
//! The search is stopped at one of its looks, and looks and jobs of surveys are lost. What must
//! hold then: the finished harm, risks and energy lie in their intervals; before the time from
//! which on a candidate is open, everybody is known whom the finished work finds; and who is
//! certified to win wins. An answer over fewer members, as there was no time for more, is held
//! against the finished work on as many.
//!
//! [`CourseFlaw`] makes answers wrong on purpose: a trial must notice it. All of this is compiled
//! only with the feature `faults` and in the tests of this crate.

use super::history::{SearchClock, Surveyor};
use super::selection::CourseOrder;
use super::{Answer, CourseRequest, CourseRow, follow};
use crate::in_process::InProcessExecutor;
use crate::request::RequestError;
use crate::request_limits::Until;
use crate::workspace::{BodySet, RunError};
use damage::{AnswerState, Interval};
use geometry::rng::Rng;
use scenario::Members;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt::Write as _;

/// A deliberate flaw in what is said of courses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CourseFlaw {
    /// Nobody is taken to be harmed by what is open.
    ForgetsOpen,
    /// An open candidate is taken to be finished.
    EndsEarly,
}

impl CourseFlaw {
    /// All flaws.
    pub const ALL: [Self; 2] = [Self::ForgetsOpen, Self::EndsEarly];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ForgetsOpen => "forgets-open",
            Self::EndsEarly => "ends-early",
        }
    }
}

/// What a trial found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TrialResult {
    /// Number of inspections.
    pub stops: u64,
    /// Inspections of scenes with members.
    pub over_members: u64,
    /// Inspections at which the winner was certain and work was open.
    pub certified: u64,
    /// Answers over fewer members, as there was no time for more.
    pub late: u64,
    /// Those of them with open work.
    pub late_open: u64,
    /// Intervals checked against the finished run.
    pub intervals: u64,
    /// Intervals of nonzero width.
    pub open_intervals: u64,
    /// What did not hold, in words.
    pub violations: Vec<String>,
}

/// Orders in which members are followed: the race in every other trial.
const ORDERS: [CourseOrder; 4] =
    [CourseOrder::Race, CourseOrder::Sequential, CourseOrder::Race, CourseOrder::RoundRobin];

/// Most violations that are kept.
const VIOLATIONS_MAX: usize = 1_000_000;

impl TrialResult {
    /// Adds what another trial found.
    pub fn add(&mut self, other: Self) {
        self.stops += other.stops;
        self.over_members += other.over_members;
        self.certified += other.certified;
        self.late += other.late;
        self.late_open += other.late_open;
        self.intervals += other.intervals;
        self.open_intervals += other.open_intervals;
        self.violations.extend(other.violations);
        self.violations.truncate(VIOLATIONS_MAX);
    }
}

/// Ranks a request, then stops the same work `stops` times, and checks what is said.
///
/// # Errors
///
/// If a contact cannot be assessed.
pub fn trial_courses(
    stage: &BodySet<'_>,
    request: &CourseRequest<'_>,
    (seed, stops): (u64, u64),
    flaw: Option<CourseFlaw>,
) -> Result<TrialResult, RunError> {
    let mut rng = Rng::new(seed);
    let never = SearchClock::trial(None);
    let worked = |request: &CourseRequest<'_>,
                  (until, order): (Until, CourseOrder),
                  clock: &SearchClock,
                  (loses, seed): (u64, u64)| {
        let executor = Box::new(InProcessExecutor::with_room_for(stage.bodies));
        let mut surveyor = Surveyor::Lossy { executor, rng: Rng::new(seed), loses };
        follow((stage, request), (until, order), clock, &mut surveyor).map(|ranked| ranked.answer)
    };
    let to_the_end = (Until::Complete, CourseOrder::Race);
    let mut result = TrialResult::default();
    let end = match worked(request, to_the_end, &never, (0, 0)) {
        // Bodies stand so close that nearly all draws overlap: there is nothing to try.
        Err(RunError::Request(RequestError::Overlap { .. })) => return Ok(result),
        end => end?,
    };
    let mut ends = BTreeMap::from([(count_of(&end), end.clone())]);
    for _ in 0..stops {
        let point = rng.below(never.points() + 1);
        // Most surveys are whole, so that courses go on after them.
        let loses = [0, 0, 0, 100, 10, 1][rng.below(6) as usize];
        let over_at = (rng.below(5) > 0).then_some(point);
        let clock = SearchClock::trial(over_at);
        let until = [Until::Complete, Until::Ordered, Until::Certified][rng.below(3) as usize];
        let seed = rng.below(u64::MAX);
        let order = ORDERS[(seed % ORDERS.len() as u64) as usize];
        let mut now = worked(request, (until, order), &clock, (loses, seed))?;
        if let Some(flaw) = flaw {
            corrupt(&mut now, flaw);
        }
        result.stops += 1;
        result.over_members += u64::from(!request.members.is_nominal());
        check_state(&now, &end, &mut result);
        if now.state == AnswerState::Refused {
            continue;
        }
        let end = match ends.entry(count_of(&now)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(none) => {
                let count = none.key().unwrap_or(1);
                let request =
                    CourseRequest { members: Members { count, most: count }, ..request.clone() };
                let always = SearchClock::until(None);
                none.insert(worked(&request, to_the_end, &always, (0, 0))?)
            }
        };
        check_figures(&now, end, &mut result);
        if now.members.is_some_and(|members| members.is_late) {
            check_late(&now, end, loses == 0, &mut result);
        }
    }
    Ok(result)
}

/// How many members an answer is of; `None`: it is of the scene as stated.
fn count_of(answer: &Answer) -> Option<u32> {
    answer.members.map(|members| members.count)
}

fn corrupt(answer: &mut Answer, flaw: CourseFlaw) {
    for row in answer.ranking.iter_mut().filter(|row| row.open_from_s.is_some()) {
        match flaw {
            CourseFlaw::ForgetsOpen => {
                let least = |interval: Interval| Interval::new(interval.lo(), interval.lo());
                row.work = least(row.work);
                for person in &mut row.persons {
                    person.work = least(person.work);
                }
            }
            CourseFlaw::EndsEarly => row.open_from_s = None,
        }
    }
}

/// Checks the state of an answer against that of the finished work.
fn check_state(now: &Answer, end: &Answer, result: &mut TrialResult) {
    match now.state {
        AnswerState::Complete if now != end => {
            result.violations.push(format!("complete, and not as finished: {now:?}"));
        }
        AnswerState::Certified => {
            result.certified += 1;
            let [by, of] = [now, end].map(count_of);
            if by != of {
                result.violations.push(format!("certified with {by:?} members, in the end {of:?}"));
            }
            // Nobody, where the policy lets none be chosen.
            let [wins, won] = [now, end].map(|answer| answer.best().map(|row| &row.name));
            if wins != won {
                result.violations.push(format!("{wins:?} is certified, in the end {won:?} wins"));
            }
        }
        _ => {}
    }
}

/// Checks an answer over fewer members against the finished work on as many: unless work was lost,
/// or a contact has no figures, so that what was followed before was not finished either, it is
/// known who wins.
fn check_late(now: &Answer, end: &Answer, is_all_done: bool, result: &mut TrialResult) {
    let open = |row: &CourseRow| row.expected.as_ref().is_some_and(|expected| expected.open > 0);
    result.late += 1;
    result.late_open += u64::from(now.ranking.iter().any(open));
    let [first, winner] = [now, end].map(|answer| &answer.ranking[0].name);
    let has_figures = |row: &CourseRow| row.open_from_s.is_none() && !open(row);
    if is_all_done && end.ranking.iter().all(has_figures) && first != winner {
        let count = count_of(now);
        let what = format!("{first} is first of {count:?} members, in the end {winner} is");
        result.violations.push(what);
    }
}

/// Checks the figures of an answer against those of the finished work on as many members.
pub(super) fn check_figures(now: &Answer, end: &Answer, result: &mut TrialResult) {
    for row in &now.ranking {
        match end.ranking.iter().find(|finished| finished.name == row.name) {
            Some(finished) => hold(row, finished, result),
            None => result.violations.push(format!("{} is not in the end", row.name)),
        }
    }
}

/// Whether what is said of a candidate holds what the finished work says.
fn hold(row: &CourseRow, end: &CourseRow, result: &mut TrialResult) {
    let TrialResult { intervals, open_intervals, violations, .. } = result;
    let mut holds = |what: &str, seen: Interval, end: Interval| {
        *intervals += 1;
        *open_intervals += u64::from(!seen.is_settled());
        // Of what cannot be evaluated nothing is known in the end either.
        if end.is_settled() && !(seen.lo() <= end.hi() && end.hi() <= seen.hi()) {
            violations.push(format!("{}: {what} is {:?}, not in {seen:?}", row.name, end.hi()));
        }
    };
    holds("harm", row.work, end.work);
    holds("energy", row.energy_j, end.energy_j);
    for person in &end.persons {
        let same = row.persons.iter().filter(|seen| {
            (seen.party.as_str(), seen.seat) == (person.party.as_str(), person.seat)
        });
        let mut count = 0;
        for seen in same {
            count += 1;
            let what = format!("the risk of {} {:?}", person.party, person.seat);
            holds(&what, seen.work, person.work);
            let high = person.range.high();
            let most = Interval::new(0.0, seen.range.high());
            holds("the upper end of its range", most, Interval::new(high, high));
        }
        if count == 0 {
            holds("the risk of one who is not listed", Interval::ZERO, person.work);
        }
    }
    let until_s = row.open_from_s.unwrap_or(f64::INFINITY);
    for contact in end.contacts.iter().filter(|contact| contact.first_touch_s < until_s) {
        if !row.contacts.iter().any(|known| known.party == contact.party) {
            let (party, at_s) = (&contact.party, contact.first_touch_s);
            let what = format!("{}: {party} is met after {at_s} s, which was not said", row.name);
            violations.push(what);
        }
    }
}

/// A random scene as the text of a scenario, three in four with members, of generated bodies: 2 to
/// 4 ways of a car among 2 to 5 parties, which move, turn, stand or overlap it at the start; some
/// ways begin with a touch.
#[must_use]
pub fn random_courses(rng: &mut Rng) -> String {
    const SHAPES: [&str; 7] = ["sedan", "suv", "cyclist", "pedestrian", "truck", "pole", "wall"];
    let mut between = |least: f64, most: f64| rng.between(least, most);
    let ego = "generate = { shape = \"sedan\", triangles = 600 }";
    let members = match between(0.0, 3.99) as u32 {
        0 => "members = 1\n".to_owned(),
        _ => {
            let count = between(2.0, 7.99) as u32;
            format!("members = {count}\nmembers_max = {}\n", count * between(1.0, 3.99) as u32)
        }
    };
    let mut text = format!(
        "schema = \"trolley.scenario/2\"\nname = \"random\"\nhorizon_s = 3\n{members}\
         [parties.ego]\n{ego}\n"
    );
    let parties = between(2.0, 5.99) as usize;
    for number in 0..parties {
        let shape = SHAPES[between(0.0, 6.999) as usize];
        let (x, y) = (between(-6.0, 24.0), between(-4.0, 4.0));
        let yaw = [0.0, 180.0, 90.0, between(-180.0, 180.0)][between(0.0, 3.999) as usize];
        let is_fixed = matches!(shape, "pole" | "wall");
        let kind = if is_fixed || between(0.0, 1.0) < 0.3 {
            format!("place = {{ position_m = [{x:?}, {y:?}, 0], yaw_deg = {yaw:?} }}")
        } else {
            let speed = between(0.0, 14.0);
            let rate = if between(0.0, 1.0) < 0.5 { 0.0 } else { between(-25.0, 25.0) };
            format!(
                "state = {{ position_m = [{x:?}, {y:?}, 0], yaw_deg = {yaw:?}, \
                 speed_m_s = {speed:?}, yaw_rate_deg_s = {rate:?} }}"
            )
        };
        // Writing to a string cannot fail.
        let _written = write!(
            text,
            "[parties.p{number}]\ngenerate = {{ shape = \"{shape}\", triangles = 600 }}\n{kind}\n"
        );
    }
    let has_queue = between(0.0, 1.0) < 0.4;
    if has_queue {
        let x = between(4.6, 5.2);
        let _written =
            write!(text, "[parties.queue]\n{ego}\nplace = {{ position_m = [{x:?}, 0, 0] }}\n");
    }
    for number in 0..between(2.0, 4.99) as usize {
        let way = if has_queue && between(0.0, 1.0) < 0.6 {
            let (slow, fast) = (between(0.3, 1.2), between(0.5, 12.0));
            format!(
                "path = {{ states = [ {{ t_s = 0, position_m = [0, 0, 0] }}, \
                 {{ t_s = 1, position_m = [{slow:?}, 0, 0] }}, \
                 {{ t_s = 2, position_m = [{:?}, 0, 0] }} ] }}",
                slow + fast
            )
        } else {
            let speed = between(0.0, 18.0);
            let rate = if number == 0 { 0.0 } else { between(-30.0, 30.0) };
            format!(
                "state = {{ position_m = [0, 0, 0], speed_m_s = {speed:?}, \
                 yaw_rate_deg_s = {rate:?} }}"
            )
        };
        let _written = write!(text, "[[candidates]]\nname = \"way {number}\"\n{way}\n");
    }
    text
}

#[cfg(test)]
mod tests;
