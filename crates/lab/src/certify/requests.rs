//! Random requests: an ego among bodies that it may hit, from any side.

use crate::pair;
use body::{BodyKind, BodyView, Meta};
use coordinator::Request;
use damage::{Curves, Policy};
use geometry::rng::Rng;
use scenario::Scenario;
use std::fmt::Write as _;
use trolley::Failure;
use trolley::bodies::Bodies;

/// Default bodies: the first is the ego.
const BODIES: [&str; 7] = [
    "sedan:20000",
    "suv:16000",
    "pedestrian:6000",
    "cyclist:8000",
    "truck:20000",
    "pole:2000",
    "wall:2000",
];

/// The built-in policies.
pub(super) const POLICIES: [(&str, &str); 6] = [
    ("default", include_str!("../../config/policies/default.toml")),
    ("ego-only", include_str!("../../config/policies/ego-only.toml")),
    ("precaution", include_str!("../../config/policies/precaution.toml")),
    ("weighted", include_str!("../../config/policies/weighted.toml")),
    ("worst-case-averse", include_str!("../../config/policies/worst-case-averse.toml")),
    ("worst-off-first", include_str!("../../config/policies/worst-off-first.toml")),
];

/// Sealed bodies; the first is the ego's.
pub(super) struct Pool {
    pub(super) bodies: Bodies,
    pub(super) names: Vec<String>,
}

impl Pool {
    /// Loads or generates bodies, named as for `trolley measure`.
    pub(super) fn load(named: &[String]) -> Result<Self, Failure> {
        let names: Vec<String> = match named {
            [] => BODIES.map(str::to_owned).to_vec(),
            named => named.to_vec(),
        };
        if !(2..=17).contains(&names.len()) {
            let fault = format!("{} bodies are named with --body", names.len());
            return Err(Failure::setting(fault).with_remedy("name 2 to 17, the ego first"));
        }
        let bodies = names.iter().map(|name| pair::body(name)).collect::<Result<_, _>>()?;
        Ok(Self { bodies: Bodies::seal(bodies)?, names })
    }
}

/// A built-in policy.
pub(super) fn policy(number: usize) -> Result<Policy, Failure> {
    let (name, text) = POLICIES[number % POLICIES.len()];
    Policy::parse(name, text)
        .map_err(|error| Failure::from(error).of_kind(trolley::FailureKind::Internal))
}

/// A request of so many candidates between bodies of a pool, in their order; they stand to the side
/// by up to so many times what their boxes take. `None` if the random request would be refused.
pub(super) fn request(
    views: &[(Meta, BodyView<'_>)],
    way: (usize, f64),
    rng: &mut Rng,
    policy: Policy,
) -> Result<Option<Request>, Failure> {
    let text = scenario(views, way, rng);
    let parsed = Scenario::parse("rng.toml", &text)?;
    Ok(Request::new(&parsed, views, policy, curves()?).ok())
}

fn curves() -> Result<Curves, Failure> {
    Curves::shipped().map_err(|error| Failure::from(error).of_kind(trolley::FailureKind::Internal))
}

/// A request from its scenario.
pub(super) fn parse(
    text: &str,
    views: &[(Meta, BodyView<'_>)],
    policy: Policy,
) -> Result<Request, Failure> {
    Ok(Request::new(&Scenario::parse("rng.toml", text)?, views, policy, curves()?)?)
}

/// The ego and an identical body that coincide in every triangle; also a way past everything and
/// one into the last body.
pub(super) fn interpenetrating(views: &[(Meta, BodyView<'_>)]) -> String {
    let mut text = parties(views.len());
    let ways = [(1, 0.0, 0.0, 5.0), (views.len() - 1, 3.0, 0.2, 0.0), (1, 0.0, 6.0, 5.0)];
    for (number, (other, x, y, speed)) in ways.into_iter().enumerate() {
        candidate(&mut text, number, 15.0, (other, [x, y], 0.0, speed));
    }
    text
}

/// The scenario. Party names sort in the order of the bodies.
pub(super) fn scenario(
    views: &[(Meta, BodyView<'_>)],
    (candidates, miss): (usize, f64),
    rng: &mut Rng,
) -> String {
    let mut text = parties(views.len());
    let half = |body: &BodyView<'_>, axis: usize| {
        let bounds = body.bounds();
        0.5 * f64::from(bounds.max[axis] - bounds.min[axis])
    };
    let (_, ego) = &views[0];
    for number in 0..candidates {
        let other = 1 + rng.below(views.len() as u64 - 1) as usize;
        let (meta, body) = &views[other];
        let is_fixed = matches!(meta.kind, BodyKind::Wall | BodyKind::Pole | BodyKind::Building);
        let most = match meta.kind {
            _ if is_fixed => 0.0,
            BodyKind::Pedestrian => 2.5,
            BodyKind::Cyclist => 8.0,
            _ => 16.0,
        };
        let speed = rng.between(0.0, most);
        let yaw = rng.between(-180.0, 180.0);
        let (own, across) = (half(body, 0), half(body, 1));
        let (sin, cos) = (yaw.to_radians().sin().abs(), yaw.to_radians().cos().abs());
        let reach = own * cos + across * sin;
        let x = half(ego, 0) + rng.between(0.3, 1.0) * reach;
        let wide = half(ego, 1) + own * sin + across * cos;
        let y = rng.between(-miss, miss) * wide;
        let ego_speed = rng.between(2.0, 20.0);
        candidate(&mut text, number, ego_speed, (other, [x, y], yaw, speed));
    }
    text
}

/// The head of a scenario. The bodies themselves are passed beside it.
fn parties(count: usize) -> String {
    let mut text = "schema = \"trolley.scenario/1\"\nname = \"rng\"\n[parties]\n".to_owned();
    for number in 0..count {
        let _written = writeln!(
            text,
            "{} = {{ generate = {{ shape = \"sedan\", triangles = 500 }} }}",
            party(number)
        );
    }
    text
}

/// A candidate: the ego's speed, and which other party stands where, turned how, at which speed.
fn candidate(
    text: &mut String,
    number: usize,
    ego_speed: f64,
    (other, [x, y], yaw, speed): (usize, [f64; 2], f64, f64),
) {
    let [ego_speed, x, y, yaw, speed] = [ego_speed, x, y, yaw, speed].map(scenario::decimal);
    let _written = write!(
        text,
        "[[candidates]]\nname = \"c{number}\"\n\
         ego = {{ position_m = [0, 0, 0], speed_m_s = {ego_speed} }}\n\
         other = {{ party = \"{}\", position_m = [{x}, {y}, 0], yaw_deg = {yaw}, \
         speed_m_s = {speed} }}\n",
        party(other)
    );
}

fn party(number: usize) -> String {
    if number == 0 { "ego".to_owned() } else { format!("other-{number:02}") }
}
