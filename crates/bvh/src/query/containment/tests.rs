//! Containment equals that by winding numbers, which are sums of solid angles; and does not depend
//! on trees, poses, or the roles of the two.

use super::*;
use crate::fixtures::{any_build, options, pose, torus};
use crate::{BuildOptions, Tree};
use body::Shape;
use proptest::prelude::*;

const SAME: RelativePose =
    RelativePose { rotation: Pose::IDENTITY.rotation, translation: Pose::IDENTITY.translation };

fn moved(offset: [f64; 3]) -> RelativePose {
    RelativePose { translation: offset, ..SAME }
}

fn shells_of(trees: [&Tree; 2]) -> [Shells; 2] {
    trees.map(|tree| Shells::of(tree.corners()))
}

fn found(a: &Tree, b: &Tree, pose: &RelativePose) -> Containment {
    let shells = shells_of([a, b]);
    containment(a, b, shells.each_ref(), pose, &mut Workspace::new()).unwrap()
}

fn asked(a: &[Corners], b: &[Corners], pose: &RelativePose) -> Containment {
    let [a, b] = [a, b].map(|it| Tree::build(it, &BuildOptions::default()).unwrap());
    found(&a, &b, pose)
}

/// The faces of a cube between two corners, counter-clockwise from outside.
fn cube(low: f32, high: f32) -> Vec<Corners> {
    let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { high } else { low });
    const FACES: [[usize; 4]; 6] =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let split = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    FACES.into_iter().flat_map(split).map(|face| face.map(corner)).collect()
}

/// The solid angle of a triangle over 4π, signed (A. van Oosterom, J. Strackee, *The Solid Angle
/// of a Plane Triangle*, IEEE Transactions on Biomedical Engineering 30(2), 1983).
fn share_of_sphere(p: DVec3, corners: &Corners) -> f64 {
    let [a, b, c] = Triangle::stored(corners).0.map(|corner| corner - p);
    let [la, lb, lc] = [a, b, c].map(DVec3::length);
    let over = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    a.cross(b).dot(c).atan2(over) / std::f64::consts::TAU
}

/// How often an oriented surface goes around a point that is not on it.
fn winding_number(p: DVec3, corners: &[Corners]) -> i64 {
    let sum: f64 = corners.iter().map(|it| share_of_sphere(p, it)).sum();
    assert!((sum - sum.round()).abs() < 1e-6, "{sum} around {p}");
    sum.round() as i64
}

/// A torus with all its corners moved to points of a lattice: it is closed and oriented, and goes
/// through itself, with overlaps, folds and triangles without area.
fn crumpled() -> impl Strategy<Value = Vec<Corners>> {
    const SIDES: [usize; 2] = [4, 3];
    let point = prop::array::uniform3((-3_i8..=3).prop_map(f32::from));
    prop::collection::vec(point, SIDES[0] * SIDES[1]).prop_map(|points| {
        let corner = |i: usize, j: usize| points[i % SIDES[0] * SIDES[1] + j % SIDES[1]];
        let all = (0..SIDES[0]).flat_map(|i| (0..SIDES[1]).map(move |j| (i, j)));
        all.flat_map(|(i, j)| {
            let [a, b, c, d] =
                [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
    })
}

/// A point as a body: rays from it meet edges and corners of [`crumpled`] all the time.
fn lattice_point() -> impl Strategy<Value = [f32; 3]> {
    prop::array::uniform3((-6_i8..=6).prop_map(|x| f32::from(x) * 0.5))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn points_are_inside_where_the_surface_winds_around_them(
        shells in prop::collection::vec(crumpled(), 1..4),
        points in prop::collection::vec(lattice_point(), 12),
        (build, leaf_size) in (any_build(), 1_u32..5),
    ) {
        let a: Vec<Corners> = shells.concat();
        let tree = Tree::build(&a, &options(build, leaf_size)).unwrap();
        // Shells that happen to share an edge are one; then windings add up.
        let of_a = Shells::of(tree.corners());
        prop_assert!(of_a.is_watertight());
        for p in points {
            let point = Tree::build(&[[p; 3]], &BuildOptions::default()).unwrap();
            let found = found(&tree, &point, &SAME);
            if found == Containment::Touching {
                continue;
            }
            let p = SAME.point(p);
            let is_inside = (0..of_a.kinds().len() as u32).any(|shell| {
                let all = tree.corners().iter().zip(of_a.of_triangles());
                let own: Vec<Corners> =
                    all.filter(|(_, of)| **of == shell).map(|(corners, _)| *corners).collect();
                winding_number(p, &own) != 0
            });
            let expected = if is_inside { Containment::BInA } else { Containment::Apart };
            prop_assert_eq!(found, expected, "{}", p);
        }
    }

    /// Triangles that are turned over leave a closed surface with an inside by parity.
    #[test]
    fn a_surface_without_orientation_goes_by_parity(
        a in crumpled(), turned in prop::collection::vec(any::<bool>(), 24),
        points in prop::collection::vec(lattice_point(), 12),
    ) {
        let other: Vec<Corners> = a.iter().zip(&turned).map(|([p, q, r], turned)| {
            if *turned { [*q, *p, *r] } else { [*p, *q, *r] }
        }).collect();
        let tree = Tree::build(&other, &BuildOptions::default()).unwrap();
        prop_assume!(Shells::of(tree.corners()).kinds() == [ShellKind::Closed]);
        for p in points {
            let point = Tree::build(&[[p; 3]], &BuildOptions::default()).unwrap();
            let found = found(&tree, &point, &SAME);
            if found != Containment::Touching {
                let is_inside = winding_number(SAME.point(p), &a) % 2 != 0;
                prop_assert_eq!(found == Containment::BInA, is_inside, "{:?}", p);
            }
        }
    }

    /// A small body in a large one, at any pose; and with the roles exchanged.
    #[test]
    fn a_body_holds_what_is_well_inside(
        turned in pose(), (build, leaf_size) in (any_build(), 1_u32..5),
    ) {
        let built = options(build, leaf_size);
        let large = Tree::build(&cube(-20.0, 20.0), &built).unwrap();
        let small = Tree::build(&torus(9, 5, 0.3), &built).unwrap();
        prop_assert_eq!(found(&large, &small, &turned), Containment::BInA);
        prop_assert_eq!(found(&small, &large, &turned), Containment::AInB);
        let apart = turned.moved(DVec3::new(0.0, 0.0, 60.0));
        prop_assert_eq!(found(&large, &small, &apart), Containment::Apart);
        prop_assert_eq!(found(&small, &large, &apart), Containment::Apart);
    }
}

#[test]
fn touching_from_inside_is_touching() {
    let (large, small) = (cube(0.0, 4.0), cube(1.0, 2.0));
    assert_eq!(asked(&large, &small, &SAME), Containment::BInA);
    assert_eq!(asked(&large, &small, &moved([-1.0, 0.0, 0.0])), Containment::Touching);
    let nearly = moved([-1.0 + f64::EPSILON, 0.0, 0.0]);
    assert_eq!(asked(&large, &small, &nearly), Containment::BInA);
    let passed = moved([-2.0 - 2.0 * f64::EPSILON, 0.0, 0.0]);
    assert_eq!(asked(&large, &small, &passed), Containment::Apart);
    assert_eq!(asked(&large, &large, &SAME), Containment::Touching);
}

#[test]
fn what_an_open_box_holds_is_undecided() {
    let (mut open, small) = (cube(0.0, 4.0), cube(1.0, 2.0));
    open.remove(2);
    let in_a = Containment::Undecided { in_a: true, in_b: false };
    let in_b = Containment::Undecided { in_a: false, in_b: true };
    assert_eq!(asked(&open, &small, &SAME), in_a);
    assert_eq!(asked(&small, &open, &SAME), in_b);
    // Beside the box there is no doubt; nor in a closed shell within.
    assert_eq!(asked(&open, &small, &moved([9.0, 0.0, 0.0])), Containment::Apart);
    assert_eq!(asked(&small, &open, &moved([9.0, 0.0, 0.0])), Containment::Apart);
    let both = [open.clone(), cube(0.5, 3.0)].concat();
    assert_eq!(asked(&both, &small, &SAME), Containment::BInA);
    // An open body can be inside a closed one.
    let large = cube(-1.0, 5.0);
    assert_eq!(asked(&large, &open, &SAME), Containment::BInA);
}

/// Two closed shells that overlap: a ray from where they do crosses both, four surfaces in all or
/// two; the point is inside all the same.
#[test]
fn shells_that_overlap_do_not_cancel() {
    let moved_cube =
        |by: f32| cube(0.0, 4.0).into_iter().map(move |it| it.map(|c| c.map(|x| x + by)));
    let two: Vec<Corners> = cube(0.0, 4.0).into_iter().chain(moved_cube(1.0)).collect();
    let small = cube(2.0, 3.0);
    assert_eq!(asked(&two, &small, &SAME), Containment::BInA);
    // Only one of two shells is inside.
    let pair: Vec<Corners> = [small, cube(20.0, 21.0)].concat();
    assert_eq!(asked(&two, &pair, &SAME), Containment::BInA);
    assert_eq!(asked(&pair, &two, &SAME), Containment::AInB);
    assert_eq!(asked(&two, &pair, &moved([30.0, 0.0, 0.0])), Containment::Apart);
}

/// Boxes inside every generated body that is large enough, and a body in its own larger copy.
#[test]
fn every_generated_body_holds_what_is_inside() {
    for shape in Shape::ALL {
        let corners = shapes::generate(shape, 2_000, 0).expect("possible").corners;
        let shells = Shells::of(&corners);
        println!("{shape}: {} shells, {} open edges", shells.kinds().len(), shells.open_edges());
        assert!(shells.kinds().iter().all(|kind| *kind == ShellKind::Oriented), "{shape}");
        let a = Tree::build(&corners, &BuildOptions::default()).unwrap();
        let box_ = a.bounds();
        let [low, high] = [box_.min, box_.max].map(|p| SAME.point(p));
        let crumb = Tree::build(&cube(-0.005, 0.005), &BuildOptions::default()).unwrap();
        let shells = shells_of([&a, &crumb]);
        let mut workspace = Workspace::new();
        let mut inside = 0;
        for place in 0..1_000 {
            let share = [place / 100, place / 10 % 10, place % 10].map(|k| (k as f64 + 0.5) / 10.0);
            let p = low + (high - low) * DVec3::from_array(share);
            let pose = moved(p.to_array());
            let found = containment(&a, &crumb, shells.each_ref(), &pose, &mut workspace).unwrap();
            // The shells of a body overlap, so the windings add up.
            if found != Containment::Touching {
                let expected = winding_number(p, &corners) > 0;
                assert_eq!(found == Containment::BInA, expected, "{shape} {p}");
                assert!(expected || found == Containment::Apart, "{shape} {p} {found:?}");
                inside += i32::from(expected);
            }
        }
        println!("{shape}: holds {inside} of 1000 places of its box");
        assert!(inside > 5, "{shape}");
    }
}

#[test]
fn a_sedan_holds_a_box_and_a_box_a_sedan() {
    let sedan = shapes::generate(Shape::Sedan, 3_000, 0).expect("possible").corners;
    let at = moved([0.0, 0.0, 0.7]);
    assert_eq!(asked(&sedan, &cube(-0.1, 0.1), &at), Containment::BInA);
    assert_eq!(asked(&cube(-0.1, 0.1), &sedan, &moved([0.0, 0.0, -0.7])), Containment::AInB);
    assert_eq!(asked(&cube(-9.0, 9.0), &sedan, &SAME), Containment::BInA);
    assert_eq!(asked(&sedan, &cube(-9.0, 9.0), &SAME), Containment::AInB);
}

#[test]
fn nothing_holds_nothing() {
    let tree = Tree::build(&cube(0.0, 1.0), &BuildOptions::default()).unwrap();
    let nothing = BodyView { nodes: &[], wide: &[], wide_of: &[], corners: &[], ..tree.view() };
    let shells = [Shells::of(nothing.corners), Shells::of(tree.corners())];
    let workspace = &mut Workspace::new();
    let found = containment(nothing, tree.view(), shells.each_ref(), &SAME, workspace);
    assert_eq!(found, Ok(Containment::Apart));
    let [empty, full] = &shells;
    let found = containment(tree.view(), nothing, [full, empty], &SAME, workspace);
    assert_eq!(found, Ok(Containment::Apart));
    let beyond = moved([f64::NAN, 0.0, 0.0]);
    assert_eq!(containment(&tree, &tree, [full, full], &beyond, workspace), Err(PoseError));
}
