//! Who is at stake in a scenario over a horizon: one fixed list for all candidates.
//!
//! Persons are there whether their party moves or not. Where nothing is said, those that are usual
//! for its kind are at stake, and both *nobody* and *full* lie within the model range: see
//! [`usual`].

use crate::request::{Person, Persons};
use body::{BodyKind, BodyView, Meta, Seat};
use damage::party::{Seats, is_fixed, is_vulnerable};
use damage::rule::Stake;
use damage::{Aboard, CourseHarm, PersonId};
use scenario::{Occupancy, Scenario};
use std::ops::Range;

/// Persons of a bus of which nothing is said: the driver and nine passengers, a usual load in
/// between the rush hours (our assumption).
const BUS_USUAL: usize = 10;
/// Persons of a full bus (our assumption).
const BUS_FULL: u32 = 50;

/// Everybody at stake.
#[derive(Clone, Debug)]
pub(crate) struct People {
    pub(crate) list: Persons,
    /// Per party: its persons in the list.
    aboard: Vec<Range<usize>>,
    /// Parties of which nobody said who is in them, and how many more than the usual may be.
    supposed: Vec<(usize, u32)>,
}

/// Who is usually with a body of which nothing is said, and how many it can hold. Cars, trucks and
/// two-wheelers have a driver or rider (our assumption), a pedestrian is one person.
fn usual(kind: BodyKind) -> (Seats, u32) {
    let alone = |seat| core::iter::once(Some(seat)).collect();
    match kind {
        BodyKind::Sedan | BodyKind::Suv => (alone(Seat::FrontLeft), 5),
        BodyKind::Truck => (alone(Seat::FrontLeft), 2),
        BodyKind::Bus => {
            let driver = core::iter::once(Some(Seat::FrontLeft));
            (driver.chain(core::iter::repeat_n(None, BUS_USUAL - 1)).collect(), BUS_FULL)
        }
        BodyKind::Motorcycle | BodyKind::Cyclist => (alone(Seat::Rider), 2),
        BodyKind::Pedestrian => (core::iter::once(None).collect(), 1),
        BodyKind::Wall | BodyKind::Pole | BodyKind::Building => (Seats::new(), 0),
    }
}

impl People {
    /// `body` gives the body of a party.
    pub(crate) fn of<'b>(
        scenario: &Scenario,
        body: &impl Fn(usize) -> &'b (Meta, BodyView<'b>),
    ) -> Self {
        let mut people = Self { list: Persons::new(), aboard: Vec::new(), supposed: Vec::new() };
        for (number, party) in scenario.parties.iter().enumerate() {
            let meta = &body(number).0;
            let is_somebody = !party.is_unknown && !is_fixed(meta.kind);
            let seats: Seats = match &party.occupancy {
                _ if !is_somebody => Seats::new(),
                Occupancy::Empty => Seats::new(),
                Occupancy::Stated(groups) => groups
                    .iter()
                    .flat_map(|group| core::iter::repeat_n(group.seat, group.count as usize))
                    .collect(),
                Occupancy::Default => match &meta.occupants {
                    Some(occupants) => occupants.iter().map(|occupant| occupant.seat).collect(),
                    None => {
                        let (seats, full) = usual(meta.kind);
                        // A pedestrian is somebody for sure.
                        if meta.kind != BodyKind::Pedestrian {
                            people.supposed.push((number, full - seats.len() as u32));
                        }
                        seats
                    }
                },
            };
            let is_ego = number == scenario.ego.0;
            let is_vulnerable = is_vulnerable(meta.kind);
            let stake = Stake { is_ego, is_vulnerable, responsibility: party.responsibility };
            let first = people.list.len();
            let person = |seat| Person { party: party.name.clone(), seat, stake };
            people.list.extend(seats.into_iter().map(person));
            people.aboard.push(first..people.list.len());
        }
        people
    }

    /// What everybody has at stake.
    pub(crate) fn stakes(&self) -> Vec<Stake> {
        self.list.iter().map(|person| person.stake).collect()
    }

    /// The persons of a party.
    pub(crate) fn aboard(&self, party: usize) -> impl Iterator<Item = Aboard> {
        let seat = |id: usize| Aboard { id: PersonId(id), seat: self.list[id].seat };
        self.aboard[party].clone().map(seat)
    }

    /// Everybody.
    pub(crate) fn all(&self) -> impl Iterator<Item = PersonId> {
        (0..self.list.len()).map(PersonId)
    }

    /// Lets the model range reach from nobody to everybody who fits in, where nobody said who is
    /// there: any more run the greatest risk of those at stake there.
    pub(crate) fn suppose(&self, harm: &mut CourseHarm) {
        for (party, more) in &self.supposed {
            let ids = self.aboard[*party].clone().map(PersonId);
            let highs = ids.clone().filter_map(|id| harm.risk_of(id)).map(|r| r.range.high());
            let high = highs.fold(0.0, f64::max);
            if let Some(first) = self.list.get(self.aboard[*party].start) {
                harm.others.add(&first.stake, *more, high);
            }
            ids.for_each(|id| harm.suppose(id));
        }
    }

    /// A sentence about the parties of which nobody said who is in them, if there are any.
    pub(crate) fn assumptions(&self, scenario: &Scenario) -> Option<String> {
        let parties = self.supposed.iter().map(|(party, more)| {
            let count = self.aboard[*party].len();
            let name = &scenario.parties[*party].name;
            format!("\"{name}\" {count} of {}", count + *more as usize)
        });
        let parties: Vec<String> = parties.collect();
        (!parties.is_empty()).then(|| {
            format!(
                "nothing is said about who is in these; the usual number is assumed, and anything \
                 from nobody to full is within the range: {}",
                parties.join(", ")
            )
        })
    }
}
