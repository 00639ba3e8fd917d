//! Random scenes: an ego among bodies that it may hit, from any side.

use crate::pair;
use body::{BodyKind, BodyView, Meta, Shells};
use coordinator::CourseRequest;
use damage::{Criteria, Policy};
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
pub(super) const POLICIES: [(&str, &str); 9] = [
    ("acceptable-or-brake", include_str!("../../config/policies/acceptable-or-brake.toml")),
    ("default", include_str!("../../config/policies/default.toml")),
    ("ego-only", include_str!("../../config/policies/ego-only.toml")),
    ("precaution", include_str!("../../config/policies/precaution.toml")),
    ("uninvolved-first", include_str!("../../config/policies/uninvolved-first.toml")),
    ("vulnerable-first", include_str!("../../config/policies/vulnerable-first.toml")),
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

    /// The shells of the bodies.
    pub(super) fn shells(&self) -> Result<Vec<Shells>, Failure> {
        Ok(self.bodies.views()?.iter().map(|(_, view)| Shells::of(view.corners)).collect())
    }
}

/// A built-in policy.
pub(super) fn policy(number: usize) -> Result<Policy, Failure> {
    let (name, text) = POLICIES[number % POLICIES.len()];
    Policy::parse(name, text)
        .map_err(|error| Failure::from(error).of_kind(trolley::FailureKind::Internal))
}

/// A built-in policy with the shipped curves and parameters.
pub(super) fn criteria(number: usize) -> Result<Criteria, Failure> {
    Criteria::with_policy(policy(number)?)
        .map_err(|error| Failure::from(error).of_kind(trolley::FailureKind::Internal))
}

/// A random scene among bodies of a pool: each party is one of them.
#[derive(Clone, Debug)]
pub(super) struct Scene {
    pub(super) scenario: Scenario,
    /// Party i has body `models[i]` of the pool.
    pub(super) models: Vec<usize>,
}

impl Scene {
    fn parse(text: &str, models: Vec<usize>) -> Result<Self, Failure> {
        let scenario = Scenario::parse("rng.toml", text)
            .map_err(|error| Failure::from(error).of_kind(trolley::FailureKind::Internal))?;
        Ok(Self { scenario, models })
    }

    /// What ranks it.
    pub(super) fn request<'r>(
        &'r self,
        shells: &'r [Shells],
        criteria: Criteria,
    ) -> CourseRequest<'r> {
        CourseRequest {
            scenario: &self.scenario,
            models: &self.models,
            shells,
            criteria,
            members: self.scenario.members(),
            worlds: scenario::Worlds::USUAL,
            history: false,
            explanation: false,
            scene: false,
        }
    }
}

/// How large a random scene is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// Ways of the ego.
    pub(super) candidates: usize,
    /// Parties besides the ego; `None`: up to twice as many as the pool has bodies.
    pub(super) others: Option<usize>,
    /// In how many members the candidates are followed.
    pub(super) members: u32,
    /// All others stand close around the ego's ways.
    pub(super) is_unavoidable: bool,
}

/// A random scene.
pub(super) fn scene(
    views: &[(Meta, BodyView<'_>)],
    extent: Extent,
    rng: &mut Rng,
) -> Result<Scene, Failure> {
    let Extent { candidates, others, members, is_unavoidable: unavoidable } = extent;
    let some = views.len() - 1 + rng.below(views.len() as u64) as usize;
    let count = others.unwrap_or(some);
    let mut models = vec![0];
    let mut text = head(members);
    for number in 0..count {
        let model = 1 + number % (views.len() - 1);
        models.push(model);
        let kind = views[model].0.kind;
        let wide = if unavoidable { 4.0 } else { 14.0 };
        let (x, y) = (rng.between(8.0, 38.0), rng.between(-wide, wide));
        let yaw = rng.between(-180.0, 180.0);
        let most = match kind {
            BodyKind::Pedestrian => 2.5,
            BodyKind::Cyclist => 8.0,
            _ => 14.0,
        };
        let speed = rng.between(0.0, most);
        let stands = kind.is_fixed() || rng.below(3) == 0;
        let [x, y, yaw, speed] = [x, y, yaw, speed].map(scenario::decimal);
        let motion = if stands {
            format!("place = {{ position_m = [{x}, {y}, 0], yaw_deg = {yaw} }}")
        } else {
            format!(
                "state = {{ position_m = [{x}, {y}, 0], yaw_deg = {yaw}, speed_m_s = {speed} }}"
            )
        };
        party(&mut text, number, &motion);
    }
    for number in 0..candidates {
        // From hard braking to 20 m/s, from a hard turn to the right to one to the left.
        let (speed, rate) = (rng.between(2.0, 20.0), rng.between(-25.0, 25.0));
        let [speed, rate] = [speed, rate].map(scenario::decimal);
        let _written = write!(
            text,
            "[[candidates]]\nname = \"c{number}\"\nstate = {{ position_m = [0, 0, 0], speed_m_s = \
             {speed}, yaw_rate_deg_s = {rate} }}\n"
        );
    }
    Scene::parse(&text, models)
}

/// The ego and an identical body that coincide in every triangle; another one, and the last body,
/// in the way.
pub(super) fn interpenetrating(views: &[(Meta, BodyView<'_>)]) -> Result<Scene, Failure> {
    let mut text = head(1);
    party(&mut text, 0, "state = { position_m = [0, 0, 0], speed_m_s = 5 }");
    party(&mut text, 1, "place = { position_m = [30, 0.2, 0] }");
    for (number, speed) in [15, 10, 5].into_iter().enumerate() {
        let _written = write!(
            text,
            "[[candidates]]\nname = \"c{number}\"\nstate = {{ position_m = [0, 0, 0], speed_m_s = \
             {speed} }}\n"
        );
    }
    Scene::parse(&text, vec![0, 1, views.len() - 1])
}

/// The head of a scene. The bodies themselves are passed beside it, and nobody is said to be in
/// them.
fn head(members: u32) -> String {
    format!(
        "schema = \"trolley.scenario/2\"\nname = \"rng\"\nhorizon_s = 3\nmembers = {members}\n\
         [parties.ego]\ngenerate = {{ shape = \"sedan\", triangles = 500 }}\n"
    )
}

/// A party. Names sort in the order of their numbers, behind the ego.
fn party(text: &mut String, number: usize, motion: &str) {
    let _written = write!(
        text,
        "[parties.other-{number:02}]\ngenerate = {{ shape = \"suv\", triangles = 500 }}\n{motion}\n"
    );
}
