//! The zones of a body to which a triangle belongs, determined by its centroid.
//!
//! The body's box is cut into thirds along x and halves along y and z; seats cover ranges of it, an
//! assumption `[A]` stated in [`seat_range`]. The centroid decides, so a triangle that spans
//! several zones belongs to one of each cut. Bits are those of [`Zones`].

use crate::{BodyKind, Mesh, Seat, Zones};
use geometry::{Aabb, Corners};

/// The front third of the body.
pub const FRONT: u16 = 1;
/// The middle third.
pub const MIDDLE: u16 = 1 << 1;
/// The rear third.
pub const REAR: u16 = 1 << 2;
/// The left half.
pub const LEFT: u16 = 1 << 3;
/// The right half, including the middle plane.
pub const RIGHT: u16 = 1 << 4;
/// The upper half.
pub const UPPER: u16 = 1 << 5;
/// The lower half, including the middle plane.
pub const LOWER: u16 = 1 << 6;

/// Names of the bits 0 to 6.
pub const NAMES: [&str; 7] = ["front", "middle", "rear", "left", "right", "upper", "lower"];

/// Zones of every triangle of a mesh, in its order.
#[must_use]
pub fn of_mesh(mesh: &Mesh, kind: BodyKind) -> Vec<Zones> {
    let bounds = mesh.bounds();
    mesh.corners.iter().map(|corners| of_triangle(corners, &bounds, kind)).collect()
}

/// Zones of one triangle of a body with this box.
#[must_use]
pub fn of_triangle(corners: &Corners, bounds: &Aabb, kind: BodyKind) -> Zones {
    let [x, y, z] = [0, 1, 2].map(|axis| share(corners, bounds, axis));
    let third = if x > 2.0 / 3.0 {
        FRONT
    } else if x >= 1.0 / 3.0 {
        MIDDLE
    } else {
        REAR
    };
    let side = if y > 0.5 { LEFT } else { RIGHT };
    let level = if z > 0.5 { UPPER } else { LOWER };
    let inside = |range: [f64; 2], share: f64| (range[0]..=range[1]).contains(&share);
    let seats = kind.seats().iter().filter(|seat| {
        let [along, across, up] = seat_range(kind, **seat);
        inside(along, x) && inside(across, y) && inside(up, z)
    });
    Zones(seats.fold(third | side | level, |bits, seat| bits | seat.zone_bit()))
}

/// The position of the centroid within the box: 0 at the least, 1 at the greatest coordinate. A box
/// without extent gives 0.5.
fn share(corners: &Corners, bounds: &Aabb, axis: usize) -> f64 {
    let [a, b, c] = corners.map(|corner| f64::from(corner[axis]));
    let (min, max) = (f64::from(bounds.min[axis]), f64::from(bounds.max[axis]));
    if max > min { ((a + b + c) / 3.0 - min) / (max - min) } else { 0.5 }
}

/// The part of the body beside a seat, as fractions of its box along x (0 rear, 1 front), y (0
/// right, 1 left) and z (0 bottom, 1 top) `[A]`.
///
/// Cars: the doors of the row and the roof above it, without the sill; the middle rear seat adjoins
/// the body only behind and above. Trucks and buses: the cabin. Riders: everything between the
/// wheels and above their axles. Pillion riders: the same further back, since they sit on the rear
/// wheel; a model file from before this seat has no triangle beside it.
#[must_use]
pub fn seat_range(kind: BodyKind, seat: Seat) -> [[f64; 2]; 3] {
    let height = [0.2, 1.0];
    let row = match (kind, seat) {
        (BodyKind::Truck, _) => [0.75, 1.0],
        (BodyKind::Bus, Seat::FrontLeft | Seat::FrontRight) => [0.85, 1.0],
        (BodyKind::Bus, _) => [0.0, 0.85],
        (_, Seat::FrontLeft | Seat::FrontRight) => [0.42, 0.62],
        (_, Seat::RearLeft | Seat::RearMiddle | Seat::RearRight) => [0.22, 0.42],
        (_, Seat::Rider) => return [[0.25, 0.75], [0.0, 1.0], [0.4, 1.0]],
        (_, Seat::Pillion) => return [[0.1, 0.45], [0.0, 1.0], [0.4, 1.0]],
    };
    match seat {
        Seat::FrontLeft | Seat::RearLeft => [row, [0.5, 1.0], height],
        Seat::FrontRight | Seat::RearRight => [row, [0.0, 0.5], height],
        Seat::RearMiddle => [row, [1.0 / 3.0, 2.0 / 3.0], height],
        Seat::Rider | Seat::Pillion => [row, [0.0, 1.0], height],
    }
}

#[cfg(test)]
mod tests;
