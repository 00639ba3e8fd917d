//! The composition of a shape before it is triangulated: components with names, and a size.

use super::net::Net;
use super::surface::{Cells, Pad, Surface};
use geometry::DVec3;

/// How far a pad protrudes from its surface (m): enough to be visible where the mesh is coarse.
const PAD_OUT: f64 = 0.012;
/// How far a pad reaches into its surface (m).
const PAD_IN: f64 = 0.02;

/// One closed component.
#[derive(Clone, Debug)]
pub(super) struct Component {
    /// Name of the part it belongs to.
    pub(super) part: String,
    /// Its surface.
    pub(super) surface: Surface,
    /// Minimum number of cells in each direction.
    pub(super) least: Cells,
    /// How it behaves when the shape is fitted to its size.
    pub(super) fit: Fit,
}

/// How a component behaves when the shape is stretched to its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fit {
    /// Stretched with the whole, and included in the measured size.
    Stretched,
    /// Moved with the whole, but scaled uniformly: a wheel stays round.
    Round,
    /// Stretched with the whole, but not included in the measured size: a mirror.
    Beside,
}

/// The components of a shape.
#[derive(Clone, Debug, Default)]
pub(super) struct Blueprint {
    /// In the order of the mesh.
    pub(super) components: Vec<Component>,
}

impl Blueprint {
    /// Adds a component.
    pub(super) fn add(&mut self, part: &str, surface: Surface, least: Cells) -> &mut Component {
        let fit = Fit::Stretched;
        self.components.push(Component { part: part.to_owned(), surface, least, fit });
        let last = self.components.len() - 1;
        &mut self.components[last]
    }

    /// Adds a component and its mirror image across the plane y = 0; `part` has `{}` where the side
    /// belongs.
    pub(super) fn add_pair(&mut self, part: &str, surface: &Surface, least: Cells, fit: Fit) {
        let right = surface.map(|p| DVec3::new(p.x, -p.y, p.z));
        self.add(&part.replace("{}", "left"), surface.clone(), least).fit = fit;
        self.add(&part.replace("{}", "right"), right, least).fit = fit;
    }

    /// Adds a pad on `net` that stands out by [`PAD_OUT`].
    pub(super) fn add_pad(&mut self, part: &str, net: &Net, corners: [(f64, f64); 4], round: f64) {
        let net = net.clone();
        let pad = Pad { net, corners, round, height: [PAD_OUT, PAD_IN] };
        self.add(part, Surface::Pad(pad), [1, 1, 1]);
    }

    /// Adds a pad on the left of a hull and its image on the right: columns count from the bottom
    /// middle up the left side, so the image of column t is column `end` − t.
    pub(super) fn add_pads(&mut self, part: &str, net: &Net, corners: [(f64, f64); 4], round: f64) {
        let end = net.cols.end();
        self.add_pad(&part.replace("{}", "left"), net, corners, round);
        let [a, b, c, d] = corners.map(|(s, t)| (s, end - t));
        self.add_pad(&part.replace("{}", "right"), net, [b, a, d, c], round);
    }
}
