//! One request, from the bytes of a client to its answer: checked, ranked, encoded.
//!
//! The service and its in-process counterpart share this path.

use crate::answer::lay_out;
use crate::ask::{self, Checked, Refusal};
use crate::deployment::Deployment;
use body::{BodyView, Meta, Shells};
use bvh::support::Extremes;
use coordinator::{
    Backend, BodySet, CourseRequest, RankedCourses, RequestLimits, RunError, WorkerPoolError,
    WorkerPoolReport,
};
use damage::Criteria;
use diagnostic::chain;
use protocol::public::{Ask, ModelSet, Reason, WireAnswer};
use runtime::clock;

/// Ranks requests about the bodies of a deployment. It is reused between requests: what takes long
/// to find about bodies is found once.
#[derive(Debug)]
pub(crate) struct Ranker<'s> {
    deployment: &'s Deployment,
    bodies: &'s [(Meta, BodyView<'s>)],
    model_set: ModelSet,
    /// Extreme points of each body.
    extremes: Vec<Extremes>,
    /// Shells of each body.
    shells: Vec<Shells>,
    criteria: Criteria,
    depth: u32,
}

/// An answered request, and what its stages took (ns).
pub(crate) struct Ranked {
    pub(crate) answer: WireAnswer,
    pub(crate) search_ns: u64,
    pub(crate) surveys_ns: u64,
    pub(crate) judge_ns: u64,
    /// From the beginning to the answer.
    pub(crate) lasted_ns: u64,
    /// What the workers did: one report a round.
    pub(crate) reports: Vec<WorkerPoolReport>,
}

/// Why a checked request has no answer.
pub(crate) enum Unranked {
    Refused(Refusal),
    WorkerPool(WorkerPoolError),
}

impl<'s> Ranker<'s> {
    pub(crate) fn new(
        deployment: &'s Deployment,
        bodies: &'s [(Meta, BodyView<'s>)],
        criteria: Criteria,
        depth: u32,
    ) -> Self {
        let extremes = bodies.iter().map(|(_, body)| Extremes::of(body)).collect();
        let shells = bodies.iter().map(|(_, body)| Shells::of(body.corners)).collect();
        let model_set = model_set(deployment, bodies);
        Self { deployment, bodies, model_set, extremes, shells, criteria, depth }
    }

    /// Identity of the bodies.
    pub(crate) fn model_set(&self) -> ModelSet {
        self.model_set
    }

    /// Checks every value of a request.
    pub(crate) fn check(&self, ask: &Ask) -> Result<Checked, Refusal> {
        ask::check(ask, self.deployment, (self.bodies, &self.model_set))
    }

    /// Ranks a checked request.
    pub(crate) fn rank(
        &self,
        sequence: u64,
        checked: &Checked,
        limits: RequestLimits,
        backend: &mut Backend,
    ) -> Result<Ranked, Unranked> {
        let begun_ns = clock::now_ns();
        let stage =
            BodySet { bodies: self.bodies, extremes: Some(&self.extremes), depth: self.depth };
        let request = CourseRequest {
            scenario: &checked.scenario,
            models: &checked.models,
            shells: &self.shells,
            criteria: self.criteria.clone(),
            members: checked.scenario.members(),
            worlds: scenario::Worlds::USUAL,
            history: false,
            explanation: false,
            scene: false,
        };
        let ranked = coordinator::rank_courses(&stage, &request, limits, backend);
        let RankedCourses { answer, effort, reports, .. } =
            ranked.map_err(|error| match error {
                RunError::Request(error) => unassessable(&error),
                RunError::WorkerPool(error) => Unranked::WorkerPool(error),
            })?;
        let mut answer = WireAnswer { model_set: self.model_set, ..lay_out(sequence, &answer) };
        if checked.has_unknown && answer.verdict().has_ranking() {
            answer.say("parties of unknown kind were taken as fixed, with nobody in them");
        }
        Ok(Ranked {
            answer,
            search_ns: effort.search_ns,
            surveys_ns: effort.surveys_ns,
            judge_ns: effort.assess_ns + effort.judge_ns,
            lasted_ns: clock::now_ns() - begun_ns,
            reports,
        })
    }
}

fn unassessable(error: &coordinator::RequestError) -> Unranked {
    Unranked::Refused(Refusal { reason: Reason::Unassessable, text: chain(error) })
}

/// A hash of what answers depend on: ids, kinds, masses, persons, triangles and their zones. The
/// order of the triangles in a body's tree is left out, since no answer depends on it.
fn model_set(deployment: &Deployment, bodies: &[(Meta, BodyView<'_>)]) -> ModelSet {
    let mut hasher = blake3::Hasher::new();
    for (model, (meta, body)) in deployment.models.iter().zip(bodies) {
        hasher.update(&model.id.to_le_bytes()).update(meta.kind.name().as_bytes());
        let numbers = [meta.mass_kg.unwrap_or(0.0), meta.gyration_m];
        for number in numbers.iter().chain(&meta.centre_m) {
            hasher.update(&number.to_le_bytes());
        }
        // One more than the persons, so that none and unknown differ.
        let persons = meta.occupants.as_ref().map_or(0, |persons| 1 + persons.len() as u64);
        hasher.update(&persons.to_le_bytes());
        for person in meta.occupants.iter().flatten() {
            hasher.update(&ask::seat_number(person.seat).to_le_bytes());
        }
        let mut order: Vec<usize> = (0..body.source_ids.len()).collect();
        order.sort_unstable_by_key(|at| body.source_ids[*at]);
        hasher.update(&(order.len() as u64).to_le_bytes());
        for at in order {
            hasher.update(bytemuck::bytes_of(&body.corners[at]));
            hasher.update(bytemuck::bytes_of(&body.zones[at]));
        }
    }
    *hasher.finalize().as_bytes()
}

#[cfg(test)]
mod tests {
    //! Bodies that give other answers have another identity.
    use super::*;
    use crate::ask::tests::{bodies, deployment};
    use body::{Seat, meta::Occupant};

    #[test]
    fn whoever_is_stated_to_be_inside_belongs_to_the_identity() {
        let identity = |occupants: Option<Vec<Occupant>>, mass_kg: Option<f64>| {
            let mut bodies = bodies();
            (bodies[0].0.occupants, bodies[0].0.mass_kg) = (occupants, mass_kg);
            model_set(&deployment(), &bodies)
        };
        let seat = |seat| Some(vec![Occupant { seat: Some(seat) }]);
        let all = [
            identity(None, None),
            identity(Some(Vec::new()), None),
            identity(seat(Seat::FrontLeft), None),
            identity(seat(Seat::RearLeft), None),
            identity(None, Some(1_200.0)),
        ];
        for (number, one) in all.iter().enumerate() {
            assert!(!all[..number].contains(one), "{number}");
        }
        assert_eq!(all[0], identity(None, None));
    }
}
