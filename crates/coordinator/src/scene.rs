//! What a picture of each candidate shows once the work is done: where bodies lie, what is hit.

use crate::candidate_state::SearchStage;
use crate::work::RankingRun;
use geometry::RelativePose;

/// One candidate, as a picture shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The candidate's name.
    pub name: String,
    /// Numbers of the ego's and of the other's body.
    pub models: [usize; 2],
    /// The other seen from the ego, at the pose shown: where the contact patch is complete, or,
    /// without contact, the given one.
    pub pose: RelativePose,
    /// Travel of that pose from the given one along the relative path (m).
    pub travel_m: f64,
    /// Triangles hit from first contact to e, as the bodies store them: of the ego, of the other.
    pub hits: [Vec<u32>; 2],
}

impl RankingRun<'_> {
    /// Every candidate, in the order of the request.
    #[must_use]
    pub fn scenes(&self) -> Vec<Scene> {
        let scene = |(candidate, state): (
            &crate::request::Candidate,
            &crate::candidate_state::CandidateState,
        )| {
            let travel_m = match &state.stage {
                SearchStage::Surveying { stops, .. } => {
                    let last = stops.iter().rfind(|(stop, _)| stop.patch);
                    last.map_or(0.0, |(stop, _)| stop.travel_m)
                }
                SearchStage::Settled | SearchStage::Searching { .. } => 0.0,
            };
            let u = candidate.approach.directions.d[0];
            Scene {
                name: candidate.name.to_string(),
                models: [candidate.model_a as usize, candidate.model_b as usize],
                pose: candidate.pose.moved(-u * travel_m),
                travel_m,
                hits: state.hit.triangles(),
            }
        };
        self.request().candidates.iter().zip(self.candidate_states()).map(scene).collect()
    }
}
