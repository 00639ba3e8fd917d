//! The risk of one person in one candidate: nominal curve over open work, and the model's range.

use super::crash::{Crash, Lever};
use super::{AssessError, Basis};
use crate::dynamics::{Pick, Response};
use crate::evidence::Touch;
use crate::harm::PersonHarm;
use crate::injury::{Rung, Speeds};
use crate::interval::{Interval, Range};
use crate::party::{Aboard, PartyError, Struck};
use body::{Seat, Zones};
use smallvec::SmallVec;

/// The range takes every side that N, widened by this, touches (degrees).
const SIDE_MARGIN_DEGREES: f64 = 10.0;
/// Zone bits from here on stand for seats.
const FIRST_SEAT_BIT: u32 = 8;

/// Whether zones hold the one beside a seat.
fn is_beside(zones: Zones, seat: Option<Seat>) -> bool {
    seat.is_some_and(|seat| zones.0 & (1 << (FIRST_SEAT_BIT + seat as u32)) != 0)
}

impl Crash<'_> {
    /// What the collision does to a person of a party (0: A, 1: B).
    pub(super) fn person(
        &self,
        party: usize,
        person: &Aboard,
        basis: &Basis<'_>,
    ) -> Result<PersonHarm, AssessError> {
        let (work, x_m_s) = self.nominal_risk(party, basis)?;
        let work = self.outward(work).below_one();
        let intrusion = is_beside(self.evidence.zones()[party], person.seat);
        let may_intrude = is_beside(self.evidence.zones_at_most()[party], person.seat);
        let possible = &self.normals.possible;
        let high = self.high(party, possible, Lever::Shortest, may_intrude, basis)?;
        let low = match self.touch {
            Touch::Yes if !self.concave => self.low(party, basis)?,
            Touch::Yes | Touch::Unknown | Touch::No => 0.0,
        };
        let at_least = match self.touch {
            Touch::Unknown => 0.0,
            Touch::No => high,
            Touch::Yes => self.high(party, &self.normals.sure, Lever::Longest, intrusion, basis)?,
        };
        let range = Range::new(low, high.max(low)).around(work);
        let nominal = self.normals.nominal.first().copied().unwrap_or(0);
        let rung = self.rung(party, self.struck(party, nominal, 0.0), basis)?;
        let curve = basis.curves.nominal(rung);
        Ok(PersonHarm {
            id: person.id,
            party,
            seat: person.seat,
            victim: rung.victim,
            curve: curve.id.clone(),
            x: rung.x,
            x_m_s,
            work,
            range,
            high_at_least: at_least.max(work.lo()).min(range.high()) + 0.0,
            intrusion,
            extrapolated: !curve.is_valid_at(x_m_s.hi()),
        })
    }

    /// The work interval of the risk of anybody in a party (0: A, 1: B).
    pub(super) fn risk(&self, party: usize, basis: &Basis<'_>) -> Result<Interval, AssessError> {
        Ok(self.outward(self.nominal_risk(party, basis)?.0).below_one())
    }

    /// Nominal risk and the speed that it is taken at (m/s), over everything that is open.
    fn nominal_risk(
        &self,
        party: usize,
        basis: &Basis<'_>,
    ) -> Result<(Interval, Interval), AssessError> {
        let mut both: Option<(Interval, Interval)> = None;
        for (&i, ends) in self.normals.nominal.iter().zip(&self.ends) {
            let rung = self.rung(party, self.struck(party, i, 0.0), basis)?;
            let speeds_at = |end: &Response| Speeds {
                delta_v: end.delta_v_m_s[party],
                normal: self.speeds(i).0,
                closing: self.approach.closing_m_s,
            };
            let [least, most] = [speeds_at(&ends[0]), speeds_at(&ends[1])];
            let risk = basis.curves.work(rung, &least, &most);
            let x = Interval::new(least.get(rung.x), most.get(rung.x));
            both = Some(both.map_or((risk, x), |(r, w)| (r.hull(risk), w.hull(x))));
        }
        let (risk, x) = both.unwrap_or_default();
        Ok((self.unless_apart(risk), self.unless_apart(x)))
    }

    /// The rung of a person of a party that is struck at a side.
    fn rung<'b>(
        &self,
        party: usize,
        side: Struck,
        basis: &Basis<'b>,
    ) -> Result<&'b Rung, AssessError> {
        let nobody = AssessError::Party(['A', 'B'][party], PartyError::PersonsInFixed);
        let victim = self.parties[party].victim(side).ok_or(nobody)?;
        Ok(basis.curves.rung(victim, basis.level)?)
    }

    /// Rungs of all sides that normals, a little widened, strike; all sides if a zone beside the
    /// person is hit.
    fn rungs<'b>(
        &self,
        party: usize,
        normals: &[usize],
        intrusion: bool,
        basis: &Basis<'b>,
    ) -> Result<SmallVec<[&'b Rung; 3]>, AssessError> {
        let margins = [-SIDE_MARGIN_DEGREES, 0.0, SIDE_MARGIN_DEGREES];
        let touched = |side: &Struck| {
            let by = |i: &usize| margins.iter().any(|m| self.struck(party, *i, *m) == *side);
            intrusion || normals.iter().any(by)
        };
        let all = [Struck::Front, Struck::Side, Struck::Rear];
        all.into_iter().filter(touched).map(|side| self.rung(party, side, basis)).collect()
    }

    /// The upper end of a person's range over some normals; 0 over none.
    fn high(
        &self,
        party: usize,
        normals: &[usize],
        lever: Lever,
        intrusion: bool,
        basis: &Basis<'_>,
    ) -> Result<f64, AssessError> {
        let delta_v = normals.iter().map(|&i| self.extreme(i, party, Pick::High, lever));
        let speeds = Speeds {
            delta_v: delta_v.fold(0.0, f64::max),
            normal: normals.iter().map(|&i| self.speeds(i).0).fold(0.0, f64::max),
            closing: if normals.is_empty() { 0.0 } else { self.approach.closing_m_s },
        };
        let rungs = self.rungs(party, normals, intrusion, basis)?;
        Ok(rungs.iter().map(|r| basis.curves.high(r, &speeds)).fold(0.0, f64::max))
    }

    /// The lower end of a person's range over all normals of N.
    fn low(&self, party: usize, basis: &Basis<'_>) -> Result<f64, AssessError> {
        let normals = &self.normals.possible;
        let delta_v = normals.iter().map(|&i| self.extreme(i, party, Pick::Low, Lever::Longest));
        let speeds = Speeds {
            delta_v: delta_v.fold(f64::INFINITY, f64::min),
            normal: normals.iter().map(|&i| self.speeds(i).0).fold(f64::INFINITY, f64::min),
            closing: self.approach.closing_m_s,
        };
        let rungs = self.rungs(party, normals, false, basis)?;
        Ok(rungs.iter().map(|r| basis.curves.low(r, &speeds)).fold(1.0, f64::min))
    }
}
