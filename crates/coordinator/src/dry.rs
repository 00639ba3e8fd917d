//! Dry runs: descents alone, at a few depths of one pose, by which a cost model chooses the depth.
//!
//! The pose is the deepest that a survey can have. Where first contact is nobody knows yet: the
//! survey is taken to begin where the hulls meet. A dry run is kept per pair of bodies, however
//! many candidates or requests have it.

use crate::request::Request;
use body::{BodyView, Meta};
use bvh::{Counters, front};
use damage::Meeting;
use dispatch::Descent;
use geometry::RelativePose;
use std::collections::BTreeMap;

/// Depths of a dry run, ascending; the first is the work in one piece. By the last two the pairs of
/// leaves are reckoned: from less deep ones they came out four times too many, and to count them
/// takes half as long as the work itself.
pub const DEPTHS: [u32; 6] = [0, 2, 4, 6, 8, 12];

/// What is known of a pair of bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct DryPair {
    /// Descents to each of [`DEPTHS`].
    pub descents: Vec<Descent>,
    /// Levels at which the leaves of both trees are, in the mean.
    pub levels: f64,
}

/// A candidate, as far as it can be known without a job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DryCandidate<'d> {
    /// The pair at its deepest pose.
    pub pair: &'d DryPair,
    /// Poses at which contact is sought.
    pub probes: usize,
    /// Poses of the survey.
    pub stops: usize,
}

/// Dry runs by the hashes of both bodies.
#[derive(Debug, Default)]
pub struct DryRuns {
    pairs: BTreeMap<[String; 2], DryPair>,
}

impl DryRuns {
    /// How many pairs are known.
    #[must_use]
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Whether no pair is known.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Runs a request dry, as far as its pairs are not known yet. `hashes` are those of `bodies`.
    /// Candidates whose hulls never meet have no work.
    ///
    /// # Panics
    ///
    /// If there are fewer bodies or hashes than the request's parties.
    pub fn of(
        &mut self,
        request: &Request,
        bodies: &[(Meta, BodyView<'_>)],
        hashes: &[String],
    ) -> Vec<DryCandidate<'_>> {
        let mut met = Vec::new();
        for candidate in &request.candidates {
            let Meeting::Path(path) = &candidate.meeting else { continue };
            let stops = path.survey(path.first_m());
            let Some(deepest) = stops.last() else { continue };
            let of = [candidate.model_a, candidate.model_b].map(|model| model as usize);
            let key = of.map(|body| hashes[body].clone());
            let [a, b] = of.map(|body| &bodies[body].1);
            let u = candidate.approach.directions.d[0];
            let pose = candidate.pose.moved(-u * deepest.travel_m);
            self.pairs.entry(key.clone()).or_insert_with(|| DryPair::new(a, b, &pose));
            met.push((key, path.travels.len(), stops.len()));
        }
        let known = |(key, probes, stops): (_, usize, usize)| {
            Some(DryCandidate { pair: self.pairs.get(&key)?, probes, stops })
        };
        met.into_iter().filter_map(known).collect()
    }
}

impl DryPair {
    /// Descends at one pose.
    #[must_use]
    pub fn new(a: &BodyView<'_>, b: &BodyView<'_>, pose: &RelativePose) -> Self {
        let runs = DEPTHS.map(|depth| {
            let (mut pairs, mut counters) = (Vec::new(), Counters::default());
            front(a, b, pose, depth, &mut pairs, &mut counters);
            let pairs: Vec<_> = pairs.into_iter().map(|pair| [pair.a, pair.b]).collect();
            (depth, counters.nb, pairs)
        });
        let deepest = &runs[DEPTHS.len() - 1].2;
        let descents =
            runs.iter().map(|(depth, nb, jobs)| Descent::new(*depth, *nb, jobs, deepest));
        // A binary tree has one node less than twice its leaves.
        let levels = |body: &BodyView<'_>| (body.nodes.len().div_ceil(2).max(1) as f64).log2();
        Self { descents: descents.collect(), levels: f64::midpoint(levels(a), levels(b)) }
    }
}

#[cfg(test)]
mod tests;
