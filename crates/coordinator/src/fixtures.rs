//! A small request shared by tests: three crashes and one candidate that passes by. Where the hulls
//! of the person and the car first meet, none of their boxes do: such a pose has no jobs.

use crate::request::Request;
use body::Shape;
use body::{Body, BodyView, Meta, defaults, zones};
use bvh::BuildOptions;
use damage::{Curves, Policy};
use scenario::Scenario;
use shapes::generate;

const SCENARIO: &str = r#"
schema = "trolley.scenario/1"
name = "replayed"
[parties]
ego = { generate = { shape = "sedan", triangles = 900 } }
pole = { generate = { shape = "pole", triangles = 500 } }
suv = { generate = { shape = "suv", triangles = 900 } }
person = { generate = { shape = "pedestrian", triangles = 900 } }
[[candidates]]
name = "pole"
ego = { position_m = [0, 0, 0], speed_m_s = 9 }
other = { party = "pole", position_m = [2.4, 0.3, 0], speed_m_s = 0 }
[[candidates]]
name = "suv"
ego = { position_m = [0, 0, 0], speed_m_s = 12 }
other = { party = "suv", position_m = [4.6, 0.4, 0], yaw_deg = 170, speed_m_s = 4 }
[[candidates]]
name = "past"
ego = { position_m = [0, 0, 0], speed_m_s = 12 }
other = { party = "suv", position_m = [4.6, 3.5, 0], speed_m_s = 4 }
[[candidates]]
name = "person"
ego = { position_m = [0, 0, 0], speed_m_s = 12 }
other = { party = "person", position_m = [2.5, 0.35, 0], yaw_deg = 90, speed_m_s = 1.4 }
"#;

fn body(shape: Shape, triangles: u32) -> Body {
    let mesh = generate(shape, triangles, 0).expect("a known size");
    let origin = defaults::Origin { name: "b", kind: shape.kind(), origin: "b", hash: "" };
    let meta = defaults::assemble(origin, &mesh);
    let zones = zones::of_mesh(&mesh, shape.kind());
    bvh::body(mesh, meta, zones, &BuildOptions::default(), &|_| {}).expect("a tree")
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
        [(Shape::Sedan, 900), (Shape::Pole, 500), (Shape::Suv, 900), (Shape::Pedestrian, 900)]
            .map(|(s, n)| body(s, n));
    let views: Vec<_> = bodies.iter().map(|body| (body.meta.clone(), body.view())).collect();
    let scenario = Scenario::parse("replayed.toml", SCENARIO).expect("sound");
    let curves = Curves::shipped().expect("sound");
    let request = Request::new(&scenario, &views, policy, curves).expect("sound");
    of(&request, &views)
}
