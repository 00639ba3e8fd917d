//! Duplicates against a quadratic oracle, selection, and sizes.

use super::*;
use body::testing::mesh_of;
use proptest::prelude::*;

/// Few positions, so that triangles meet often; both zeros are among them.
fn corners() -> impl Strategy<Value = Corners> {
    let coordinate = prop::sample::select(vec![-0.0_f32, 0.0, 1.0]);
    let point = (coordinate.clone(), coordinate).prop_map(|(x, y)| [x, y, 0.5]);
    [point.clone(), point.clone(), point]
}

fn is_same(a: &Corners, b: &Corners) -> bool {
    const ORDERS: [[usize; 3]; 6] =
        [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    ORDERS.iter().any(|order| (0..3).all(|i| a[i] == b[order[i]]))
}

proptest! {
    #[test]
    fn exactly_the_later_ones_of_equal_triangles_go(
        corners in prop::collection::vec(corners(), 1..30),
    ) {
        let mut mesh = mesh_of(corners.clone());
        mesh.source_ids.iter_mut().for_each(|id| *id = *id * 3 + 1);
        let all = mesh.clone();
        drop_duplicates(&mut mesh);
        let earlier = |at: usize| (0..at).find(|first| is_same(&corners[*first], &corners[at]));
        let kept: Vec<usize> = (0..corners.len()).filter(|at| earlier(*at).is_none()).collect();
        let dropped: Vec<(u32, u32)> = (0..corners.len())
            .filter_map(|at| earlier(at).map(|first| (all.source_ids[at], all.source_ids[first])))
            .collect();
        prop_assert_eq!(&mesh.dropped, &dropped);
        let expected: Vec<u32> = kept.iter().map(|at| all.source_ids[*at]).collect();
        prop_assert_eq!(&mesh.source_ids, &expected);
        prop_assert_eq!(mesh.corners, kept.iter().map(|at| corners[*at]).collect::<Vec<_>>());
    }
}

fn part(name: &str, aliases: &[&str]) -> Part {
    Part { name: name.into(), aliases: aliases.iter().map(|alias| (*alias).into()).collect() }
}

#[test]
fn selected_parts_keep_their_ids_and_unused_names_go() {
    let mut mesh = mesh_of(body::testing::strip(4));
    mesh.part_of = vec![2, 0, 1, 2];
    mesh.parts = ["a", "b", "c"].map(String::from).to_vec();
    let parts = [part("a", &["x"]), part("b", &[]), part("c", &["x"])];
    select(&mut mesh, &parts, &["x".into()]).expect("there");
    compact_parts(&mut mesh);
    assert_eq!((&*mesh.source_ids, &*mesh.part_of), (&[0, 1, 3][..], &[1, 0, 1][..]));
    assert_eq!(mesh.parts, ["a", "c"]);
    let fault = select(&mut mesh, &parts, &["x".into(), "d".into()]).expect_err("not there");
    assert_eq!(
        fault.to_string(),
        "no part is named \"d\"; the names are \"a\", \"b\", \"c\", \"x\""
    );
}

#[test]
fn a_car_in_the_wrong_unit_is_named_with_the_right_one() {
    let car = [4.5, 1.8, 1.4];
    for (unit, metres) in LengthUnit::NAMED {
        // Written in `unit`, read in metres.
        let outcome = check_size(car.map(|x| x / metres), Some(BodyKind::Sedan), LengthUnit::METRE);
        match outcome {
            Ok(()) => assert_eq!(unit, "m"),
            Err(MeshDefect::Size { unit: found, .. }) => assert_eq!(found, Some(unit)),
            Err(other) => panic!("{other}"),
        }
    }
    // Written in metres, read in millimetres.
    let fault =
        check_size(car.map(|x| x * 0.001), Some(BodyKind::Suv), "mm".parse().expect("a unit"));
    assert!(matches!(fault, Err(MeshDefect::Size { unit: Some("m"), .. })), "{fault:?}");
    let fault = check_size([4500.0, 1800.0, 1400.0], Some(BodyKind::Sedan), LengthUnit::METRE)
        .expect_err("long");
    let words = "4500.00 × 1800.00 × 1400.00 m is not a plausible sedan: its greatest length \
                 should be 1 to 30 m";
    assert_eq!(fault.to_string(), words);
}
