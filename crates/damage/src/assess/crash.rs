//! The dynamics of one candidate, nominal and with parameters at the ends of their ranges.

use super::Encounter;
use crate::approach::{Approach, UP};
use crate::contact::ContactPatch;
use crate::crush::Crush;
use crate::dynamics::{Impact, ImpactBody, Response, Surface};
use crate::harm::{CandidateHarm, DeltaV};
use crate::interval::{Interval, Range};
use crate::parameters::{PairParameters, Parameters, Pick, factor};
use crate::party::{CollisionParty, Struck};
use crate::plane::{LongFace, Plane, PlaneOrigin};
use body::OwnParameters;
use geometry::DVec3;

/// Which values of the parameters, for one of the two parties.
#[derive(Clone, Copy, Debug)]
pub(super) struct Picks {
    friction: Pick,
    gyration: Pick,
    normal: Pick,
    /// Restitution, masses and speed: within the factors of occupants' curves, so nominal there.
    rest: Pick,
    /// Whose ΔV is sought: its own mass goes to the opposite end.
    party: usize,
}

/// What may be drawn of both parties: it takes the place of what they state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drawn {
    /// Masses (kg); `None` if fixed to the ground.
    pub(crate) mass_kg: [Option<f64>; 2],
    /// What is known of their impacts.
    pub(crate) own: [OwnParameters; 2],
}

impl Drawn {
    /// What the parties of an encounter state.
    pub(super) fn stated(encounter: &Encounter<'_>) -> Self {
        let parties = [encounter.a, encounter.b];
        Self { mass_kg: parties.map(|party| party.mass_kg), own: parties.map(|party| party.own) }
    }
}

/// Everything that the figures of one candidate are computed from.
pub(super) struct Crash<'a> {
    pub(super) approach: &'a Approach,
    pub(super) plane: &'a Plane,
    /// Who collides; their masses are `mass_kg`.
    pub(super) parties: [&'a CollisionParty; 2],
    /// Masses (kg); `None` if fixed to the ground.
    pub(super) mass_kg: [Option<f64>; 2],
    /// The side of each party that the normal strikes.
    pub(super) struck: [Struck; 2],
    /// Known of every contact: speeds and normals.
    parameters: &'a Parameters,
    pair: PairParameters,
    /// Velocity of A against B at the point of contact (m/s).
    velocity_m_s: DVec3,
    pub(super) nominal: Response,
}

impl Picks {
    pub(super) fn nominal(party: usize) -> Self {
        let pick = Pick::Nominal;
        Self { friction: pick, gyration: pick, normal: pick, rest: pick, party }
    }

    /// All values of what is sampled, with the rest at one end.
    fn sampled(rest: Pick, party: usize) -> impl Iterator<Item = Self> {
        Pick::ALL.into_iter().flat_map(move |friction| {
            Pick::ALL.into_iter().flat_map(move |gyration| {
                Pick::ALL.into_iter().map(move |normal| Self {
                    friction,
                    gyration,
                    normal,
                    rest,
                    party,
                })
            })
        })
    }
}

impl<'a> Crash<'a> {
    pub(super) fn new(
        encounter: &Encounter<'a>,
        plane: &'a Plane,
        parameters: &'a Parameters,
        drawn: &Drawn,
    ) -> Self {
        let Encounter { approach, a, b, .. } = *encounter;
        let parties = [a, b];
        let mut crash = Self {
            approach,
            plane,
            parties,
            mass_kg: drawn.mass_kg,
            struck: [0, 1]
                .map(|p| side_struck(plane, parties[p], p, approach.directions.d[UP], 0.0)),
            parameters,
            pair: parameters.of_pair(drawn.own.each_ref()),
            velocity_m_s: plane.velocity_m_s(approach),
            nominal: Response::default(),
        };
        crash.nominal = crash.respond(Picks::nominal(0));
        crash
    }

    fn up(&self) -> DVec3 {
        self.approach.directions.d[UP]
    }

    /// The normal, turned to an end of its range, and the direction to its left.
    fn axes(&self, pick: Pick) -> [DVec3; 2] {
        // A long flat face leaves no doubt about its normal.
        let degrees = match pick {
            Pick::Nominal => 0.0,
            _ if self.long_face().is_some() => 0.0,
            Pick::Low => -self.parameters.normal_degrees,
            Pick::High => self.parameters.normal_degrees,
        };
        let (n, up) = (self.plane.normal, self.up());
        let left = up.cross(n);
        if degrees == 0.0 {
            return [n, left];
        }
        let (sin, cos) = libm::sincos(f64::to_radians(degrees));
        let n = n * cos + left * sin;
        [n, up.cross(n)]
    }

    /// The long flat face along which the other slides, if one is struck.
    fn long_face(&self) -> Option<LongFace> {
        let left = self.up().cross(self.plane.normal);
        self.plane.faces[usize::from(self.velocity_m_s.dot(left) < 0.0)]
    }

    pub(super) fn long_face_of(&self) -> Option<usize> {
        self.long_face().map(|face| face.of)
    }

    /// What they meet with.
    fn surface(&self, picks: Picks) -> Surface {
        let pair = &self.pair;
        if self.long_face().is_some() {
            return Surface::Redirecting {
                restitution: picks.rest.of(&pair.face_restitution),
                restitution_more: pair.face_restitution_more,
                tangential_share: pair.face_tangential_share,
            };
        }
        let friction = if self.plane.is_flat { &pair.flat_friction } else { &pair.friction };
        Surface::Coupled {
            restitution: picks.rest.of(&pair.restitution),
            friction: picks.friction.of(friction),
        }
    }

    /// The impact; `None` where no impulse is exchanged.
    fn impact(&self, picks: Picks) -> Option<Impact> {
        if matches!(self.plane.origin, PlaneOrigin::Graze | PlaneOrigin::WeakPart) {
            return None;
        }
        let axes = self.axes(picks.normal);
        let speed = factor(self.parameters.speed_share, picks.rest);
        let in_plane = |v: DVec3| axes.map(|axis| v.dot(axis));
        let sides = [0, 1].map(|p| {
            let (party, mass_kg) = (self.parties[p], self.mass_kg[p]);
            // ΔV falls with the own mass and rises with the partner's.
            let mass = match (picks.rest, p == picks.party) {
                (Pick::Nominal, _) => Pick::Nominal,
                (Pick::Low, true) | (Pick::High, false) => Pick::High,
                (Pick::Low, false) | (Pick::High, true) => Pick::Low,
            };
            let mass = factor(self.pair.mass_share[p], mass);
            let gyration = factor(self.pair.gyration_share[p], picks.gyration);
            ImpactBody {
                inverse_mass: mass_kg.map_or(0.0, |m| 1.0 / (m * mass)),
                // A fixed body does not turn; its gyration may be anything, even 0.
                gyration_m: mass_kg.map_or(1.0, |_| party.gyration_m * gyration),
                arm_m: in_plane(self.plane.arms_m[p]),
            }
        });
        let velocity_m_s = in_plane(self.velocity_m_s).map(|v| v * speed);
        Some(Impact { velocity_m_s, surface: self.surface(picks), sides })
    }

    fn respond(&self, picks: Picks) -> Response {
        self.impact(picks).map_or_else(Response::default, |impact| impact.respond())
    }

    /// v_n at the point of contact with the normal at one end of its range (m/s), at least 0. Who
    /// is struck by a weak part feels all of the speed there.
    pub(super) fn normal_m_s(&self, normal: Pick) -> f64 {
        match self.plane.origin {
            PlaneOrigin::Graze => 0.0,
            PlaneOrigin::WeakPart => self.contact_m_s(),
            PlaneOrigin::Chord | PlaneOrigin::Motion => {
                self.velocity_m_s.dot(self.axes(normal)[0]).max(0.0)
            }
        }
    }

    /// The speed at the point of contact (m/s).
    pub(super) fn contact_m_s(&self) -> f64 {
        if self.plane.origin == PlaneOrigin::Graze { 0.0 } else { self.velocity_m_s.length() }
    }

    /// ΔV of a party (m/s) with friction, gyration and normal sampled: the least and the greatest.
    /// With the rest nominal: the factors on occupants' ΔV hold it already.
    pub(super) fn sampled(&self, party: usize) -> [f64; 2] {
        self.extremes(Picks::sampled(Pick::Nominal, party))
    }

    fn extremes(&self, picks: impl Iterator<Item = Picks>) -> [f64; 2] {
        picks.fold([f64::INFINITY, 0.0], |[least, most]: [f64; 2], picks| {
            let delta_v = self.respond(picks).delta_v_m_s[picks.party];
            [least.min(delta_v), most.max(delta_v)]
        })
    }

    fn delta_v_range(&self, party: usize) -> Range {
        let [low, _] = self.extremes(Picks::sampled(Pick::Low, party));
        let [_, high] = self.extremes(Picks::sampled(Pick::High, party));
        Range::new(low.min(high), high)
    }

    /// Fills in all that is known of a contact.
    pub(super) fn describe(&self, harm: &mut CandidateHarm, patch: &ContactPatch) {
        let response = self.nominal;
        harm.delta_v = [0, 1].map(|p| {
            let work = Interval::exactly(response.delta_v_m_s[p]);
            DeltaV { work, range: self.delta_v_range(p).around(work) }
        });
        harm.energy_j = Interval::exactly(response.energy_j);
        let [n, left] = self.axes(Pick::Nominal);
        harm.normal_m_s = self.normal_m_s(Pick::Nominal) + 0.0;
        harm.tangential_m_s = self.velocity_m_s.dot(left) + 0.0;
        harm.response = response;
        harm.arms_m = self.plane.arms_m.map(|arm| [arm.dot(n) + 0.0, arm.dot(left) + 0.0]);
        harm.surface = match self.surface(Picks::nominal(0)) {
            Surface::Coupled { restitution, friction } => [restitution, friction],
            Surface::Redirecting { restitution, tangential_share, .. } => {
                let plain = response.normal_n_s * self.inverse_masses();
                let e =
                    if harm.normal_m_s > 0.0 { plain / harm.normal_m_s - 1.0 } else { restitution };
                [e, tangential_share]
            }
        };
        for p in 0..2 {
            harm.yaw_rad_s[p][1] += response.delta_yaw_rad_s[p];
        }
        let stiffness_if_mobile = |p: usize| self.mass_kg[p].map(|_| self.parties[p].stiffness);
        let plastic = 1.0 - self.pair.restitution.nominal;
        let energy_j = 0.5 * plastic * harm.normal_m_s * response.normal_n_s;
        harm.crush = Crush::of(
            [0, 1].map(stiffness_if_mobile),
            energy_j,
            patch.width_m.hi(),
            Interval::exactly(patch.depth_m),
        );
        let from = n * response.normal_n_s + left * response.tangential_n_s;
        harm.impulse_n_s = from.to_array().map(|x| x + 0.0);
        harm.force_degrees = [
            self.parties[0].bearing(from, self.up()) + 0.0,
            self.parties[1].bearing(-from, self.up()) + 0.0,
        ];
    }

    fn inverse_masses(&self) -> f64 {
        self.mass_kg.iter().flatten().map(|m| 1.0 / m).sum()
    }

    /// The energy that no impact of these bodies can exceed (J): all that they have about their
    /// common centre of mass, of their turning, too.
    pub(super) fn energy_at_most(&self) -> f64 {
        let Approach { closing_m_s, yaw_rad_s, .. } = self.approach;
        let of_turning = |p: usize| {
            let speed_m_s = self.parties[p].gyration_m * yaw_rad_s[p];
            self.mass_kg[p].map_or(0.0, |mass_kg| 0.5 * mass_kg * speed_m_s * speed_m_s)
        };
        let of_centres = 0.5 * closing_m_s * closing_m_s / self.inverse_masses();
        of_centres + of_turning(0) + of_turning(1)
    }

    /// The side of a party that the normal strikes, turned by some degrees.
    pub(super) fn struck_if_turned(&self, party: usize, turned_degrees: f64) -> Struck {
        side_struck(self.plane, self.parties[party], party, self.up(), turned_degrees)
    }
}

/// The side of a party (0: A, 1: B) that the normal of a plane strikes, turned by some degrees;
/// `up` is the vertical.
fn side_struck(
    plane: &Plane,
    party: &CollisionParty,
    number: usize,
    up: DVec3,
    turned_degrees: f64,
) -> Struck {
    let from = if number == 0 { plane.normal } else { -plane.normal };
    Struck::at(party.bearing(from, up) + turned_degrees)
}
