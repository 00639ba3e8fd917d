//! Both searches for first contact, ready to be measured.

use super::encounter::{Encounter, Family};
use super::halving::{self, Grid};
use body::BodyView;
use geometry::{Corners, Sweep};
use trolley_bvh::query::{SweepEffort, SweepWorkspace, first_contact};
use trolley_bvh::{BuildOptions, Counters, Kernel, Tree};

/// A family with its trees.
pub(crate) struct Ready {
    pub(crate) family: Family,
    pub(crate) a: Tree,
    pub(crate) b: Tree,
}

impl Ready {
    pub(crate) fn new(family: Family) -> Self {
        let tree = |corners: &[Corners]| {
            Tree::build(corners, &BuildOptions::default()).expect("a family has triangles")
        };
        let (a, b) = (tree(&family.a), tree(&family.b));
        Self { family, a, b }
    }

    pub(crate) fn search<'r>(&'r self, encounter: &Encounter) -> Search<'r> {
        let (a, b) = (&self.a, &self.b);
        let (depths, triangles) = ([a, b].map(Tree::depth), [a, b].map(|tree| tree.ids().len()));
        Search {
            views: [a.view(), b.view()],
            workspace: SweepWorkspace::new(),
            kernel: Kernel::with_room(depths[0], depths[1], triangles[0], triangles[1]),
            grid: halving::grid(encounter, [&self.family.a, &self.family.b]),
        }
    }
}

/// Both searches, ready for one encounter.
pub(crate) struct Search<'r> {
    views: [BodyView<'r>; 2],
    workspace: SweepWorkspace,
    kernel: Kernel,
    grid: Vec<f64>,
}

impl Search<'_> {
    /// First contact, and what it took.
    pub(crate) fn first(&mut self, of: &Encounter) -> (Option<f64>, SweepEffort) {
        let [from_m, to_m] = of.travels_m;
        let sweep = Sweep::new(of.direction, from_m, to_m).expect("a motion");
        let [a, b] = self.views;
        let first = first_contact(a, b, &of.pose, &sweep, &mut self.workspace);
        let first = first.expect("a pose that is finite");
        (first.map(|witness| witness.travel_m), self.workspace.effort())
    }

    /// The same by halving.
    pub(crate) fn halving(&mut self, of: &Encounter, tried: Grid) -> (Option<f64>, Counters) {
        halving::search(&mut self.kernel, self.views, of, &self.grid, tried)
    }
}
