//! What descents alone show of a pose: how many jobs there would be at a depth, and how evenly the
//! work would lie in them. No triangle is looked at.

/// A descent of both trees to one depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Descent {
    /// How many levels.
    pub depth: u32,
    /// Tests of boxes that it took.
    pub nb: u64,
    /// Pairs of nodes that were left: the jobs.
    pub jobs: u64,
    /// Share of the deeper pairs that lies in the job that has most of them, 0 to 1.
    pub largest: f64,
}

impl Descent {
    /// A descent that left `jobs`, and of the same pose a deeper one that left `deepest`: nodes of
    /// A and B by their numbers in preorder, so that whatever lies below a node follows on it.
    #[must_use]
    pub fn new(depth: u32, nb: u64, jobs: &[[u32; 2]], deepest: &[[u32; 2]]) -> Self {
        // No node of a front lies below another of the same side.
        let tops = [0, 1].map(|side: usize| {
            let mut nodes: Vec<u32> = jobs.iter().map(|job| job[side]).collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes
        });
        let above = |side: usize, node: u32| {
            let after = tops[side].partition_point(|top| *top <= node);
            after.checked_sub(1).map(|at| tops[side][at])
        };
        let mut owners: Vec<_> =
            deepest.iter().map(|[a, b]| [above(0, *a), above(1, *b)]).collect();
        owners.sort_unstable();
        let most = owners.chunk_by(|a, b| a == b).map(<[_]>::len).max();
        let largest = most.map_or(1.0, |most| most as f64 / owners.len() as f64);
        Self { depth, nb, jobs: jobs.len() as u64, largest }
    }
}

#[cfg(test)]
mod tests;
