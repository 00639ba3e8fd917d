//! Bodies for tests: upright prisms over convex outlines, whose hits are computed by hand.
//!
//! Two prisms' surfaces cross where their outlines cross, over the height that they share. That is
//! the oracle: it knows nothing of triangles, trees or the code under test.

use crate::approach::{Approach, heading};
use crate::assess::{AssessError, Basis, Encounter, assess};
use crate::curve::Level;
use crate::evidence::{Evidence, Seen};
use crate::harm::CandidateHarm;
use crate::injury::Curves;
use crate::parameters::Parameters;
use crate::party::{Aboard, CollisionParty, PersonId};
use crate::path::survey;
use crate::plane::{Footprint, Front, Plane};
use body::{Band, BodyKind, Outlines, OwnParameters, Seat, Zones};
use geometry::{DVec3, Directions, Supports};

/// An upright prism over a convex outline, metres.
#[derive(Clone, Debug)]
pub(crate) struct Prism {
    pub(crate) outline: Vec<[f64; 2]>,
    pub(crate) height: [f64; 2],
}

impl Prism {
    pub(crate) fn over(outline: &[[f64; 2]]) -> Self {
        Self { outline: outline.to_vec(), height: [0.0, 1.5] }
    }

    /// A box of a length and width, turned by some degrees about its centre.
    pub(crate) fn cuboid(length: f64, width: f64, centre: [f64; 2], degrees: f64) -> Self {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        let corner = |x: f64, y: f64| {
            let (x, y) = (0.5 * x * length, 0.5 * y * width);
            [x * cos - y * sin + centre[0], x * sin + y * cos + centre[1]]
        };
        Self::over(&[corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0)])
    }

    /// A round body.
    pub(crate) fn round(radius: f64, centre: [f64; 2]) -> Self {
        let corner = |k: u32| {
            let (sin, cos) = libm::sincos(f64::from(k) * core::f64::consts::TAU / 64.0);
            [centre[0] + radius * cos, centre[1] + radius * sin]
        };
        Self::over(&(0..64).map(corner).collect::<Vec<_>>())
    }

    pub(crate) fn moved(&self, by: [f64; 2]) -> Self {
        let outline = self.outline.iter().map(|p| [p[0] + by[0], p[1] + by[1]]).collect();
        Self { outline, height: self.height }
    }

    pub(crate) fn points(&self) -> Vec<DVec3> {
        let vertical_edge = |p: &[f64; 2]| self.height.map(|z| DVec3::new(p[0], p[1], z));
        self.outline.iter().flat_map(vertical_edge).collect()
    }

    pub(crate) fn supports(&self, directions: &Directions) -> Supports {
        let mut supports = Supports::EMPTY;
        self.points().iter().for_each(|p| supports.add(directions, *p));
        supports
    }

    /// Where two surfaces cross; empty if they do not.
    pub(crate) fn crossings(&self, other: &Self) -> Vec<DVec3> {
        let shared = [self.height[0].max(other.height[0]), self.height[1].min(other.height[1])];
        if shared[0] > shared[1] {
            return Vec::new();
        }
        let mut points = Vec::new();
        for a in edges(&self.outline) {
            for b in edges(&other.outline) {
                points.extend(crossing(a, b));
            }
        }
        points.iter().flat_map(|p| shared.map(|z| DVec3::new(p[0], p[1], z))).collect()
    }
}

type Edge = [[f64; 2]; 2];

fn edges(outline: &[[f64; 2]]) -> impl Iterator<Item = Edge> {
    (0..outline.len()).map(|i| [outline[i], outline[(i + 1) % outline.len()]])
}

/// The point where two edges that are not parallel cross.
fn crossing([p, q]: Edge, [r, s]: Edge) -> Option<[f64; 2]> {
    let (d, e) = ([q[0] - p[0], q[1] - p[1]], [s[0] - r[0], s[1] - r[1]]);
    let cross = d[0] * e[1] - d[1] * e[0];
    if cross.abs() < 1e-12 {
        return None;
    }
    let w = [r[0] - p[0], r[1] - p[1]];
    let (t, u) = ((w[0] * e[1] - w[1] * e[0]) / cross, (w[0] * d[1] - w[1] * d[0]) / cross);
    let inside = |x: f64| (0.0..=1.0).contains(&x);
    (inside(t) && inside(u)).then(|| [p[0] + t * d[0], p[1] + t * d[1]])
}

/// A whole candidate: bodies, speeds, parties.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) a: Prism,
    pub(crate) b: Prism,
    pub(crate) velocity: [f64; 2],
    pub(crate) yaw_rad_s: [f64; 2],
    pub(crate) party_a: CollisionParty,
    pub(crate) party_b: CollisionParty,
}

/// A scene at the moment of first contact.
#[derive(Clone, Debug)]
pub(crate) struct Touching {
    pub(crate) scene: Scene,
    pub(crate) approach: Approach,
    pub(crate) plane: Plane,
}

/// A vehicle with one driver, at the middle of its prism.
pub(crate) fn car(person: usize, mass_kg: f64, centre: [f64; 2], degrees: f64) -> CollisionParty {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    CollisionParty {
        kind: BodyKind::Sedan,
        mass_kg: Some(mass_kg),
        gyration_m: 1.26,
        centre_m: DVec3::new(centre[0], centre[1], 0.5),
        forward: DVec3::new(cos, sin, 0.0),
        stiffness: None,
        front_m: Some(0.7),
        own: OwnParameters::default(),
        persons: [Aboard { id: PersonId(person), seat: Some(Seat::FrontLeft) }]
            .into_iter()
            .collect(),
    }
}

/// A person on foot.
pub(crate) fn walker(person: usize, centre: [f64; 2]) -> CollisionParty {
    CollisionParty {
        kind: BodyKind::Pedestrian,
        mass_kg: Some(75.0),
        gyration_m: 0.2,
        centre_m: DVec3::new(centre[0], centre[1], 0.9),
        forward: DVec3::X,
        stiffness: None,
        front_m: None,
        own: OwnParameters::default(),
        persons: [Aboard { id: PersonId(person), seat: None }].into_iter().collect(),
    }
}

/// A wall or pole.
pub(crate) fn fixed(kind: BodyKind, centre: [f64; 2]) -> CollisionParty {
    CollisionParty {
        kind,
        mass_kg: None,
        gyration_m: 0.0,
        centre_m: DVec3::new(centre[0], centre[1], 0.5),
        forward: DVec3::X,
        stiffness: None,
        front_m: None,
        own: OwnParameters::default(),
        persons: Default::default(),
    }
}

/// Two cars that meet head on at 20 m/s, `across` off each other's middle.
pub(crate) fn head_on(across: f64) -> Scene {
    let at = [4.4, across];
    Scene {
        a: Prism::cuboid(4.5, 1.8, [0.0, 0.0], 0.0),
        b: Prism::cuboid(4.5, 1.7, at, 180.0),
        velocity: [20.0, 0.0],
        yaw_rad_s: [0.0; 2],
        party_a: car(0, 1200.0, [0.0, 0.0], 0.0),
        party_b: car(1, 1800.0, at, 180.0),
    }
}

impl Touching {
    /// Evidence with all work done.
    pub(crate) fn evidence(&self) -> Evidence {
        let mut evidence = Evidence::none();
        for stop in survey(&self.approach) {
            let mut seen = Seen { zones_a: Zones(1), zones_b: Zones(1), ..Seen::NOTHING };
            for point in self.scene.hits(stop.travel_m, &self.approach) {
                if stop.patch {
                    seen.patch.add(&self.approach.directions, point);
                }
            }
            evidence.add_hits(stop.travel_m, &seen);
        }
        evidence
    }

    pub(crate) fn harm_by(&self, evidence: &Evidence) -> Result<CandidateHarm, AssessError> {
        let curves = Curves::shipped().expect("the shipped curves are sound");
        let parameters = Parameters::shipped().expect("the shipped parameters are sound");
        let basis = Basis { curves: &curves, level: Level::Mais3, parameters: &parameters };
        assess(&self.encounter(), evidence, &basis)
    }

    pub(crate) fn encounter(&self) -> Encounter<'_> {
        let Self { scene: Scene { party_a: a, party_b: b, .. }, approach, plane } = self;
        Encounter { approach, plane: Some(plane), a, b, probability: 1.0 }
    }
}

impl Prism {
    pub(crate) fn outlines(&self) -> Outlines {
        Outlines { bands: vec![Band { height_m: self.height, rings: vec![self.outline.clone()] }] }
    }
}

impl Scene {
    pub(crate) fn approach(&self) -> Approach {
        let v = DVec3::new(self.velocity[0], self.velocity[1], 0.0);
        let between = self.party_b.centre_m - self.party_a.centre_m;
        let directions = Directions::around(heading(v, between, DVec3::Z), DVec3::Z);
        Approach {
            velocity_m_s: v,
            closing_m_s: v.length(),
            yaw_rad_s: self.yaw_rad_s,
            supports_a: self.a.supports(&directions),
            supports_b: self.b.supports(&directions),
            directions,
        }
    }

    /// B after some travel.
    pub(crate) fn b_at(&self, travel_m: f64, approach: &Approach) -> Prism {
        let u = approach.directions.d[0];
        self.b.moved([-u.x * travel_m, -u.y * travel_m])
    }

    /// Crossings at a travel.
    pub(crate) fn hits(&self, travel_m: f64, approach: &Approach) -> Vec<DVec3> {
        self.a.crossings(&self.b_at(travel_m, approach))
    }

    /// First contact within 12 m either way, by small steps and halving to 1 µm: the travel, and
    /// where they touch.
    fn first(&self, approach: &Approach) -> Option<(f64, DVec3)> {
        let hit = |s: f64| self.hits(s, approach).first().copied();
        let mut apart = -12.0;
        while apart < 12.0 {
            let mut touching = apart + 0.02;
            if let Some(mut point) = hit(touching) {
                while touching - apart > 1e-6 {
                    let middle = 0.5 * (apart + touching);
                    match hit(middle) {
                        Some(p) => (touching, point) = (middle, p),
                        None => apart = middle,
                    }
                }
                return Some((touching, point));
            }
            apart = touching;
        }
        None
    }

    /// This scene at the moment of first contact; `None` if they pass each other.
    pub(crate) fn touching(&self) -> Option<Touching> {
        let approach = self.approach();
        let (travel_m, point) = self.first(&approach)?;
        let u = approach.directions.d[0];
        let mut scene = self.clone();
        scene.b = self.b_at(travel_m, &approach);
        scene.party_b.centre_m -= u * travel_m;
        let approach = scene.approach();
        let outlines = [scene.a.outlines(), scene.b.outlines()];
        let [a, b] = outlines.each_ref().map(|of| Footprint::of(of, None, &approach));
        let fronts = [Front::of(&scene.party_a), Front::of(&scene.party_b)];
        let plane = Plane::of(&approach, [&a, &b], fronts, point);
        Some(Touching { scene, approach, plane })
    }

    /// The harm, all work done, of bodies that meet.
    pub(crate) fn harm(&self) -> Result<CandidateHarm, AssessError> {
        match self.touching() {
            Some(touching) => touching.harm_by(&touching.evidence()),
            // What is refused is refused whether they meet or not.
            None => {
                let approach = self.approach();
                let (a, b) = (&self.party_a, &self.party_b);
                let centres = [a.centre_m, b.centre_m];
                let plane = Plane::across_motion(&approach, centres);
                let touching = Touching { scene: self.clone(), approach, plane };
                touching.harm_by(&Evidence::none())
            }
        }
    }

    /// This candidate seen from the other party, in its frame.
    pub(crate) fn swapped(&self) -> Self {
        Self {
            a: self.b.clone(),
            b: self.a.clone(),
            velocity: [-self.velocity[0], -self.velocity[1]],
            yaw_rad_s: [self.yaw_rad_s[1], self.yaw_rad_s[0]],
            party_a: self.party_b.clone(),
            party_b: self.party_a.clone(),
        }
    }

    /// This candidate, turned and moved as a whole.
    pub(crate) fn displaced(&self, degrees: f64, by: [f64; 2]) -> Self {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        let turn = |p: [f64; 2]| [p[0] * cos - p[1] * sin, p[0] * sin + p[1] * cos];
        let prism = |p: &Prism| {
            let outline = p.outline.iter().map(|q| turn(*q)).collect();
            Prism { outline, height: p.height }.moved(by)
        };
        let party = |p: &CollisionParty| {
            let vector = |v: DVec3, by: [f64; 2]| {
                let [x, y] = turn([v.x, v.y]);
                DVec3::new(x + by[0], y + by[1], v.z)
            };
            CollisionParty {
                centre_m: vector(p.centre_m, by),
                forward: vector(p.forward, [0.0; 2]),
                ..p.clone()
            }
        };
        Self {
            a: prism(&self.a),
            b: prism(&self.b),
            velocity: turn(self.velocity),
            yaw_rad_s: self.yaw_rad_s,
            party_a: party(&self.party_a),
            party_b: party(&self.party_b),
        }
    }
}
