//! The dynamics of one candidate at any end of what is open and of what the model leaves open.

use crate::approach::{Approach, UP, cosine, opposite};
use crate::contact::{Normals, PerNormal, Places, across, describe, levers};
use crate::crush::Crush;
use crate::dynamics::{Impact, ImpactBody, Parameters, Pick, Response, factor};
use crate::evidence::{Evidence, Touch};
use crate::harm::{CandidateHarm, DeltaV};
use crate::interval::{Interval, Range};
use crate::party::{CollisionParty, Struck};
use geometry::Supports;

/// Which end of an interval of lever arms.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Lever {
    Longest,
    Shortest,
    /// No lever arm: the worst case where no patch is known.
    Zero,
}

/// Which ends of the parameters, for one of the two parties.
#[derive(Clone, Copy)]
struct Picks {
    /// Friction and gyration.
    model: Pick,
    /// Restitution, masses and speed: within the factors of occupants' curves, so nominal there.
    rest: Pick,
    lever: Lever,
    /// Whose ΔV is sought: its own mass goes to the opposite end.
    party: usize,
}

/// Everything that the figures of one candidate are computed from.
pub(super) struct Crash<'a> {
    pub(super) approach: &'a Approach,
    pub(super) evidence: &'a Evidence,
    pub(super) parties: [&'a CollisionParty; 2],
    pub(super) parameters: &'a Parameters,
    pub(super) normals: Normals,
    pub(super) places: Places,
    pub(super) reach: Supports,
    pub(super) touch: Touch,
    pub(super) concave: bool,
    /// Per nominal normal: with nominal parameters, and arms at the end that does least, and most.
    pub(super) ends: PerNormal<[Response; 2]>,
}

/// Above what rounding does to a figure on the way from hits to harm, far below any difference that
/// ranks. Evaluated at two ends, a function that rises in exact arithmetic may fall by an ulp.
const FIGURE_ROUNDING: f64 = 1e-12;

impl<'a> Crash<'a> {
    /// The figures at both ends of what is open.
    pub(super) fn with_ends(self) -> Self {
        let ends = [Lever::Longest, Lever::Shortest];
        let both_ends = |&i: &usize| ends.map(|lever| self.nominal(i, lever));
        Self { ends: self.normals.nominal.iter().map(both_ends).collect(), ..self }
    }

    /// This crash if the bodies turn out not to touch: a near miss, taken as a contact where poses
    /// off by their error would have made one.
    pub(super) fn missed(&self) -> Crash<'a> {
        let raise = self.parameters.pose_error_m;
        let places = Places::missed(self.approach, raise);
        let r = places.patch_end;
        let normals = if self.concave {
            Normals::head_on()
        } else {
            Normals::between(self.approach, r.lo(), r.hi(), raise)
        };
        let reach = self.approach.reach(places.first.lo(), r.hi());
        let crash =
            Crash { normals, places, reach, touch: Touch::No, ends: PerNormal::new(), ..*self };
        crash.with_ends()
    }

    /// A work interval, moved out by what rounding may do to its ends while the patch is open.
    pub(super) fn outward(&self, work: Interval) -> Interval {
        if self.touch == Touch::No || !self.evidence.is_patch_open() {
            return work;
        }
        let moved = |end: f64, by: f64| (end + by * (1.0 + end.abs())).max(0.0);
        Interval::new(moved(work.lo(), -FIGURE_ROUNDING), moved(work.hi(), FIGURE_ROUNDING))
    }
}

impl Crash<'_> {
    /// v_n and v_t of normal `i` (m/s).
    pub(super) fn speeds(&self, i: usize) -> (f64, f64) {
        let v = self.approach.closing_m_s;
        ((v * cosine(i)).max(0.0), (v * cosine(across(i))).abs())
    }

    fn respond(&self, i: usize, picks: Picks) -> Response {
        let Parameters { restitution, friction, .. } = self.parameters;
        let (v_n, v_t) = self.speeds(i);
        let speed = factor(self.parameters.speed_share, picks.rest);
        let arms =
            levers(self.approach, self.evidence, &self.reach, self.places.middle, self.parties, i);
        let arm = |lever: Interval| match picks.lever {
            Lever::Longest => lever.hi(),
            Lever::Shortest => lever.lo(),
            Lever::Zero => 0.0,
        };
        let sides = [0, 1].map(|p| {
            let party = self.parties[p];
            // ΔV falls with the own mass and rises with the partner's.
            let mass = match (picks.rest, p == picks.party) {
                (Pick::Nominal, _) => Pick::Nominal,
                (Pick::Low, true) | (Pick::High, false) => Pick::High,
                (Pick::Low, false) | (Pick::High, true) => Pick::Low,
            };
            let mass = factor(self.parameters.mass_share, mass);
            let gyration = factor(self.parameters.gyration_share, picks.model);
            ImpactBody {
                inverse_mass: party.mass_kg.map_or(0.0, |m| 1.0 / (m * mass)),
                // A fixed body does not turn; its gyration may be anything, even 0.
                gyration_m: party.mass_kg.map_or(1.0, |_| party.gyration_m * gyration),
                across_m: arm(arms[p][0]),
                along_m: arm(arms[p][1]),
            }
        });
        let impact = Impact {
            normal_m_s: v_n * speed,
            tangential_m_s: v_t * speed,
            restitution: restitution.pick(picks.rest),
            friction: friction.pick(picks.model),
            sides,
        };
        impact.respond()
    }

    /// The longest or shortest arms that are possible; none where there is no patch to measure.
    fn lever(&self, known: Lever) -> Lever {
        if self.touch == Touch::No { Lever::Zero } else { known }
    }

    /// Nominal parameters, with the arms at one end of what is open.
    pub(super) fn nominal(&self, i: usize, lever: Lever) -> Response {
        let picks =
            Picks { model: Pick::Nominal, rest: Pick::Nominal, lever: self.lever(lever), party: 0 };
        self.respond(i, picks)
    }

    /// ΔV of a party (m/s) with friction and gyration at one end. The rest stays nominal: the
    /// factors on occupants' ΔV hold it already.
    pub(super) fn extreme(&self, i: usize, party: usize, model: Pick, lever: Lever) -> f64 {
        let picks = Picks { model, rest: Pick::Nominal, lever: self.lever(lever), party };
        self.respond(i, picks).delta_v_m_s[party]
    }

    pub(super) fn delta_v_range(&self, party: usize) -> Range {
        let over = |end: Pick, lever: Lever, from: f64, pick: fn(f64, f64) -> f64| {
            let picks = Picks { model: end, rest: end, lever: self.lever(lever), party };
            let all = self.normals.possible.iter();
            all.map(|&i| self.respond(i, picks).delta_v_m_s[party]).fold(from, pick)
        };
        let high = over(Pick::High, Lever::Shortest, 0.0, f64::max);
        let low = over(Pick::Low, Lever::Longest, high, f64::min);
        let is_certain = self.touch == Touch::Yes && !self.concave;
        Range::new(if is_certain { low } else { 0.0 }, high)
    }

    /// An interval over all normals that may be nominal, from 0 if there may be no contact.
    fn over_nominal(&self, of: impl Fn(usize) -> Interval) -> Interval {
        let all = self.normals.nominal.iter().map(|&i| of(i));
        let hull = all.reduce(Interval::hull).unwrap_or(Interval::ZERO);
        self.unless_apart(hull)
    }

    /// A figure of the response with nominal parameters, over everything that is open.
    fn over_ends(&self, of: fn(&Response) -> f64) -> Interval {
        let all = self.ends.iter().map(|ends| Interval::new(of(&ends[0]), of(&ends[1])));
        let hull = all.reduce(Interval::hull).unwrap_or(Interval::ZERO);
        self.outward(self.unless_apart(hull))
    }

    /// Kinetic energy lost (J), over everything that is open.
    pub(super) fn energy(&self) -> Interval {
        self.over_ends(|response| response.energy_j)
    }

    pub(super) fn unless_apart(&self, work: Interval) -> Interval {
        match self.touch {
            Touch::No => Interval::ZERO,
            Touch::Unknown => work.hull(Interval::ZERO),
            Touch::Yes => work,
        }
    }

    /// Fills in all that is known of a contact.
    pub(super) fn describe(&self, harm: &mut CandidateHarm) {
        let delta_v = [
            self.over_ends(|response| response.delta_v_m_s[0]),
            self.over_ends(|response| response.delta_v_m_s[1]),
        ];
        harm.delta_v = [0, 1]
            .map(|p| DeltaV { work: delta_v[p], range: self.delta_v_range(p).around(delta_v[p]) });
        harm.energy_j = self.energy();
        harm.normal_m_s = self.over_nominal(|i| Interval::exactly(self.speeds(i).0));
        harm.tangential_m_s = self.over_nominal(|i| Interval::exactly(self.speeds(i).1));
        harm.contact.patch =
            describe(self.approach, self.evidence, &self.reach, &self.places, &self.normals);
        let (Some(&i), Some(ends)) = (self.normals.nominal.first(), self.ends.first()) else {
            return;
        };
        harm.response = ends[1];
        let arms =
            levers(self.approach, self.evidence, &self.reach, self.places.middle, self.parties, i);
        harm.levers_m = arms.map(|arms| arms.map(Interval::lo));
        harm.crush = harm.contact.patch.as_ref().and_then(|patch| {
            let stiffness_if_mobile =
                |party: &CollisionParty| party.mass_kg.map(|_| party.stiffness);
            let plastic = 1.0 - self.parameters.restitution.nominal;
            let energy_j = 0.5 * plastic * self.speeds(i).0 * harm.response.normal_n_s;
            Crush::of(
                self.parties.map(stiffness_if_mobile),
                energy_j,
                patch.width_m.hi(),
                patch.depth_m,
            )
        });
        let d = &self.approach.directions.d;
        let slides = if cosine(across(i)) < 0.0 { -1.0 } else { 1.0 };
        let from = d[i] * harm.response.normal_n_s
            + d[across(i)] * (slides * harm.response.tangential_n_s);
        harm.impulse_n_s = from.to_array().map(|x| x + 0.0);
        harm.force_degrees = [
            self.parties[0].bearing(from, d[UP]) + 0.0,
            self.parties[1].bearing(-from, d[UP]) + 0.0,
        ];
    }

    /// The energy that no impact of these masses can exceed (J).
    pub(super) fn energy_at_most(&self) -> f64 {
        let inverse: f64 = self.parties.iter().filter_map(|p| p.mass_kg).map(|m| 1.0 / m).sum();
        0.5 * self.approach.closing_m_s * self.approach.closing_m_s / inverse
    }

    /// The side of a party that normal `i` strikes, turned by some degrees.
    pub(super) fn struck(&self, party: usize, i: usize, turned: f64) -> Struck {
        let d = &self.approach.directions.d;
        let from = d[if party == 0 { i } else { opposite(i) }];
        Struck::at(self.parties[party].bearing(from, d[UP]) + turned)
    }
}
