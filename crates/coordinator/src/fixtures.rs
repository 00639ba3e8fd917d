//! A small request shared by tests: the contacts of three candidates, and a fourth one that meets
//! nobody.

use crate::course::{CourseRequest, first_round};
use crate::request::Request;
use crate::workspace::BodySet;
use body::Shape;
use body::{Body, BodyKind, BodyView, Mesh, Meta, Shells, defaults, zones};
use bvh::BuildOptions;
use damage::{Criteria, Policy};
use geometry::Corners;
use scenario::{Scenario, Source};
use shapes::generate;

const SCENARIO: &str = r#"
schema = "trolley.scenario/2"
name = "replayed"
[parties.ego]
generate = { shape = "sedan", triangles = 900 }
[parties.person]
generate = { shape = "pedestrian", triangles = 900 }
state = { position_m = [22, -4, 0], yaw_deg = 90, speed_m_s = 0.2 }
[parties.pole]
generate = { shape = "pole", triangles = 500 }
place = { position_m = [22, 4, 0] }
[parties.suv]
generate = { shape = "suv", triangles = 900 }
state = { position_m = [28, 0.4, 0], yaw_deg = 170, speed_m_s = 1 }
[[candidates]]
name = "pole"
path = { states = [ { t_s = 0, position_m = [0, 0, 0] }, { t_s = 2, position_m = [21, 3.8, 0] } ] }
[[candidates]]
name = "suv"
state = { position_m = [0, 0, 0], speed_m_s = 12 }
[[candidates]]
name = "past"
state = { position_m = [0, 0, 0], speed_m_s = 1 }
[[candidates]]
name = "person"
path = { states = [ { t_s = 0, position_m = [0, 0, 0] }, { t_s = 2, position_m = [21, -3.8, 0] } ] }
"#;

pub(crate) fn body(shape: Shape, triangles: u32) -> Body {
    let mesh = generate(shape, triangles, 0).expect("a known size");
    let origin = defaults::Origin { name: "b", kind: shape.kind(), origin: "b", hash: "" };
    let meta = defaults::assemble(origin, &mesh);
    let zones = zones::of_mesh(&mesh, shape.kind());
    bvh::body(mesh, meta, zones, &BuildOptions::default(), &|_| {}).expect("a tree")
}

/// The shapes of random scenes.
const SHAPES: [Shape; 7] = [
    Shape::Sedan,
    Shape::Suv,
    Shape::Cyclist,
    Shape::Pedestrian,
    Shape::Truck,
    Shape::Pole,
    Shape::Wall,
];

/// A body of each shape that random scenes have.
pub(crate) fn of_all_shapes() -> Vec<Body> {
    SHAPES.map(|shape| body(shape, 600)).to_vec()
}

/// The body of each party of a random scene, as its place in [`of_all_shapes`].
pub(crate) fn models_of(scenario: &Scenario) -> Vec<usize> {
    let model = |source: &Source| match source {
        Source::Generate { shape, .. } => SHAPES.iter().position(|known| known == shape),
        Source::File(_) => None,
    };
    scenario.parties.iter().map(|party| model(&party.source).expect("known")).collect()
}

/// Passes the request and its bodies to `of`.
pub(crate) fn with<T>(of: impl FnOnce(&Request, &[(Meta, BodyView<'_>)]) -> T) -> T {
    with_policy(Policy::shipped().expect("sound"), of)
}

/// [`with`] under another policy.
pub(crate) fn with_policy<T>(
    policy: Policy,
    of: impl FnOnce(&Request, &[(Meta, BodyView<'_>)]) -> T,
) -> T {
    let bodies =
        [(Shape::Sedan, 900), (Shape::Pedestrian, 900), (Shape::Pole, 500), (Shape::Suv, 900)]
            .map(|(s, n)| body(s, n));
    let views: Vec<_> = bodies.iter().map(|body| (body.meta.clone(), body.view())).collect();
    // Parties are in the order of their names: the bodies of the scenario.
    let scenario = Scenario::parse("replayed.toml", SCENARIO).expect("sound");
    let shells: Vec<Shells> = views.iter().map(|(_, view)| Shells::of(view.corners)).collect();
    let criteria = Criteria::with_policy(policy).expect("sound");
    let stage = BodySet { bodies: &views, extremes: None, depth: 4 };
    let request = CourseRequest {
        scenario: &scenario,
        models: &[0, 1, 2, 3],
        shells: &shells,
        criteria,
        members: scenario::Members::NOMINAL,
        worlds: scenario::Worlds::USUAL,
        history: false,
        explanation: false,
        scene: false,
    };
    of(&first_round(&stage, &request), &views)
}

/// Half of the length, width and height of a car (m).
pub(crate) const HALF: [f64; 3] = [2.2, 0.9, 0.6];
/// How far ahead of the middle its mirrors are (m).
pub(crate) const AHEAD_M: f64 = 0.6;

/// The twelve triangles of a box between two corners.
pub(crate) fn cuboid(low: [f64; 3], high: [f64; 3]) -> Vec<Corners> {
    let corner =
        |k: usize| [0, 1, 2].map(|i| if k >> i & 1 == 0 { low[i] } else { high[i] } as f32);
    let faces =
        [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let halves = faces.iter().flat_map(|[p, q, r, s]| [[*p, *q, *r], [*p, *r, *s]]);
    halves.map(|corners| corners.map(corner)).collect()
}

/// A box of a car with two mirrors of 15 cm height.
pub(crate) fn mirrored(mirror_length_m: f64, thickness_m: f64) -> Body {
    let [x, y, z] = HALF;
    let mut corners = cuboid([-x, -y, 0.3], [x, y, 0.3 + 2.0 * z]);
    for side in [-1.0, 1.0] {
        let (inner, outer) = (side * y, side * (y + mirror_length_m));
        corners.extend(cuboid(
            [AHEAD_M - 0.5 * thickness_m, inner.min(outer), 1.0],
            [AHEAD_M + 0.5 * thickness_m, inner.max(outer), 1.15],
        ));
    }
    sedan_of(corners)
}

/// A car of these triangles.
pub(crate) fn sedan_of(corners: Vec<Corners>) -> Body {
    let count = corners.len();
    let mesh = Mesh {
        corners,
        source_ids: (0..count as u32).collect(),
        part_of: vec![0; count],
        parts: vec!["car".to_owned()],
        dropped: Vec::new(),
        degenerate: 0,
    };
    let kind = BodyKind::Sedan;
    let origin = defaults::Origin { name: "car", kind, origin: "car", hash: "" };
    let (meta, zones) = (defaults::assemble(origin, &mesh), zones::of_mesh(&mesh, kind));
    bvh::body(mesh, meta, zones, &bvh::BuildOptions::default(), &|_| {}).expect("a tree")
}
