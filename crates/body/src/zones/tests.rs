//! Every triangle lies in one third, one side and one level; seats follow their ranges.

use super::*;
use crate::testing::mesh_of;
use proptest::prelude::*;

const BOX: Aabb = Aabb { min: [-2.0, -1.0, 0.0], max: [2.0, 1.0, 1.5] };

fn at(x: f32, y: f32, z: f32, kind: BodyKind) -> u16 {
    of_triangle(&[[x, y, z]; 3], &BOX, kind).0
}

proptest! {
    #[test]
    fn each_cut_gives_exactly_one_zone(
        corners in prop::array::uniform3([-2.0_f32..=2.0, -1.0_f32..=1.0, 0.0_f32..=1.5]),
        kind in prop::sample::select(BodyKind::ALL.to_vec()),
    ) {
        let Zones(bits) = of_triangle(&corners, &BOX, kind);
        prop_assert_eq!((bits & (FRONT | MIDDLE | REAR)).count_ones(), 1);
        prop_assert_eq!((bits & (LEFT | RIGHT)).count_ones(), 1);
        prop_assert_eq!((bits & (UPPER | LOWER)).count_ones(), 1);
        let seats = kind.seats().iter().fold(0, |sum, seat| sum | seat.zone_bit());
        prop_assert_eq!(bits & !0x7f & !seats, 0, "a seat that this kind has not");
        // When mirrored, left and right are exchanged; nothing lies on the middle plane.
        let mirrored = corners.map(|[x, y, z]| [x, -y, z]);
        let y: f64 = corners.iter().map(|corner| f64::from(corner[1])).sum();
        let swapped = of_triangle(&mirrored, &BOX, kind).0;
        prop_assert!(y == 0.0 || (bits ^ swapped) & (LEFT | RIGHT) == LEFT | RIGHT);
    }
}

#[test]
fn seats_are_where_people_sit() {
    let seats = |x, y, z, kind| at(x, y, z, kind) >> 8;
    let bit = |seat: Seat| seat.zone_bit() >> 8;
    assert_eq!(seats(0.1, 0.9, 0.7, BodyKind::Sedan), bit(Seat::FrontLeft));
    assert_eq!(seats(0.1, -0.9, 0.7, BodyKind::Suv), bit(Seat::FrontRight));
    assert_eq!(seats(-0.8, 0.9, 0.7, BodyKind::Sedan), bit(Seat::RearLeft));
    assert_eq!(seats(-0.8, 0.1, 1.5, BodyKind::Sedan), bit(Seat::RearLeft) | bit(Seat::RearMiddle));
    assert_eq!(seats(1.9, 0.5, 0.7, BodyKind::Sedan), 0, "the bumper");
    assert_eq!(seats(0.1, 0.9, 0.1, BodyKind::Sedan), 0, "the sill");
    assert_eq!(seats(1.9, 0.9, 0.7, BodyKind::Truck), bit(Seat::FrontLeft));
    assert_eq!(seats(0.0, 0.0, 1.0, BodyKind::Cyclist), bit(Seat::Rider));
    let (rider, pillion) = (bit(Seat::Rider), bit(Seat::Pillion));
    assert_eq!(seats(-0.5, 0.0, 1.0, BodyKind::Motorcycle), rider | pillion);
    assert_eq!(seats(-1.2, 0.0, 1.0, BodyKind::Motorcycle), pillion);
    assert_eq!(seats(0.0, 0.0, 0.7, BodyKind::Pedestrian), 0);
}

#[test]
fn borders_and_flat_bodies_have_an_answer() {
    assert_eq!(at(2.0, 1.0, 1.5, BodyKind::Wall), FRONT | LEFT | UPPER);
    assert_eq!(at(-2.0, -1.0, 0.0, BodyKind::Wall), REAR | RIGHT | LOWER);
    assert_eq!(at(0.0, 0.0, 0.75, BodyKind::Wall), MIDDLE | RIGHT | LOWER);
    let flat = mesh_of(vec![[[1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [1.0, 0.0, 2.0]]]);
    assert_eq!(of_mesh(&flat, BodyKind::Wall), [Zones(MIDDLE | RIGHT | LOWER)]);
}
