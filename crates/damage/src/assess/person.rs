//! The risk of one person in one candidate: nominal curve, and the model's range.

use super::crash::Crash;
use super::{AssessError, Basis};
use crate::evidence::Evidence;
use crate::harm::PersonHarm;
use crate::injury::{Rung, Speeds, Victim};
use crate::interval::{Interval, Range};
use crate::parameters::Pick;
use crate::party::{Aboard, PartyError, PersonId, Struck, throw_share};
use body::{Seat, Zones};
use smallvec::SmallVec;

/// The range takes every side that the normal, turned by this either way, touches (degrees).
const SIDE_MARGIN_DEGREES: f64 = 10.0;

/// Whether zones hold the one beside a seat.
fn is_beside(zones: Zones, seat: Option<Seat>) -> bool {
    seat.is_some_and(|seat| zones.0 & seat.zone_bit() != 0)
}

impl Crash<'_> {
    /// What the collision does to a person of a party (0: A, 1: B).
    pub(super) fn person(
        &self,
        party: usize,
        person: &Aboard,
        evidence: &Evidence,
        basis: &Basis<'_>,
    ) -> Result<PersonHarm, AssessError> {
        let rung = self.rung(party, person.seat, self.struck[party], basis)?;
        let speeds = self.nominal_speeds(party);
        let x_m_s = speeds.get(rung.x);
        let work = Interval::exactly(basis.curves.risk(rung, &speeds)).below_one();
        let intrusion = is_beside(evidence.zones()[party], person.seat);
        let may_intrude = is_beside(evidence.zones_at_most()[party], person.seat);
        let [least, most] = self.extreme_speeds(party);
        let high = |intrusion: bool| -> Result<f64, AssessError> {
            let rungs = self.rungs(party, person.seat, intrusion, basis)?;
            Ok(rungs.iter().map(|r| basis.curves.high(r, &most)).fold(0.0, f64::max))
        };
        let rungs = self.rungs(party, person.seat, false, basis)?;
        let low = rungs.iter().map(|r| basis.curves.low(r, &least)).fold(1.0, f64::min);
        let (at_least, at_most) = (high(intrusion)?, high(may_intrude)?);
        let range = Range::new(low, at_most.max(low)).around(work);
        let curve = basis.curves.nominal(rung);
        Ok(PersonHarm {
            id: person.id,
            party,
            seat: person.seat,
            victim: rung.victim,
            curve: curve.id.clone(),
            x: rung.x,
            x_m_s: Interval::exactly(x_m_s),
            front_m: speeds.front_m,
            work,
            range,
            high_at_least: at_least.max(work.lo()).min(range.high()) + 0.0,
            intrusion,
            extrapolated: !curve.is_valid_at(x_m_s),
        })
    }

    /// The nominal risk of everybody in both parties.
    pub(super) fn risks(
        &self,
        basis: &Basis<'_>,
        mut take: impl FnMut(PersonId, Interval),
    ) -> Result<(), AssessError> {
        for (number, party) in self.parties.into_iter().enumerate() {
            if party.persons.is_empty() {
                continue;
            }
            let speeds = self.nominal_speeds(number);
            // Who is struck alike in one party has one risk.
            let mut known = [None; Victim::ALL.len()];
            for person in &party.persons {
                let victim = self.victim(number, person.seat, self.struck[number])?;
                let risk = match known[victim as usize] {
                    Some(risk) => risk,
                    None => {
                        let rung = basis.curves.rung(victim, basis.level)?;
                        Interval::exactly(basis.curves.risk(rung, &speeds)).below_one()
                    }
                };
                known[victim as usize] = Some(risk);
                take(person.id, risk);
            }
        }
        Ok(())
    }

    /// How a person of a party is struck.
    fn speeds(&self, party: usize, delta_v: f64, normal: f64) -> Speeds {
        let (own, other) = (self.parties[party], self.parties[1 - party]);
        let share = throw_share(own.kind, self.mass_kg[1 - party]);
        let is_front = self.struck[1 - party] == Struck::Front;
        Speeds {
            delta_v,
            normal: normal * share,
            closing: self.contact_m_s() * share,
            front_m: other.front_m.filter(|_| is_front).unwrap_or(0.0),
        }
    }

    fn nominal_speeds(&self, party: usize) -> Speeds {
        let delta_v = self.nominal.delta_v_m_s[party];
        self.speeds(party, delta_v, self.normal_m_s(Pick::Nominal))
    }

    /// The least and the greatest that a person of a party may feel.
    fn extreme_speeds(&self, party: usize) -> [Speeds; 2] {
        let [least, most] = self.sampled(party);
        let normals = Pick::ALL.map(|pick| self.normal_m_s(pick));
        let slowest = normals.into_iter().fold(f64::INFINITY, f64::min);
        let fastest = normals.into_iter().fold(0.0, f64::max);
        [self.speeds(party, least, slowest), self.speeds(party, most, fastest)]
    }

    /// The rung of a person of a party that is struck at a side.
    fn rung<'b>(
        &self,
        party: usize,
        seat: Option<Seat>,
        side: Struck,
        basis: &Basis<'b>,
    ) -> Result<&'b Rung, AssessError> {
        Ok(basis.curves.rung(self.victim(party, seat, side)?, basis.level)?)
    }

    /// What kind of victim a person of a party is that is struck at a side.
    fn victim(
        &self,
        party: usize,
        seat: Option<Seat>,
        side: Struck,
    ) -> Result<Victim, AssessError> {
        let nobody = AssessError::Party(['A', 'B'][party], PartyError::PersonsInFixed);
        self.parties[party].victim(side, seat).ok_or(nobody)
    }

    /// Rungs of all sides that the normal, turned a little, strikes; all sides if a zone beside the
    /// person is hit.
    fn rungs<'b>(
        &self,
        party: usize,
        seat: Option<Seat>,
        intrusion: bool,
        basis: &Basis<'b>,
    ) -> Result<SmallVec<[&'b Rung; 4]>, AssessError> {
        let turned = [-SIDE_MARGIN_DEGREES, SIDE_MARGIN_DEGREES]
            .map(|margin| self.struck_if_turned(party, margin));
        let touched =
            |side: &Struck| intrusion || self.struck[party] == *side || turned.contains(side);
        let sides = Struck::ALL.into_iter().filter(touched);
        sides.map(|side| self.rung(party, seat, side, basis)).collect()
    }
}
