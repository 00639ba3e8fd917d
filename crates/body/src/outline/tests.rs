//! Outlines of prisms are their outlines; cuts of faces, gaps, cavities and weak parts do not
//! change them.

use super::*;
use geometry::Corners;

fn mesh(corners: Vec<Corners>) -> Mesh {
    let count = corners.len();
    Mesh {
        corners,
        source_ids: (0..count as u32).collect(),
        part_of: vec![0; count],
        parts: vec!["body".to_owned()],
        dropped: Vec::new(),
        degenerate: 0,
    }
}

/// The faces of an upright prism over a convex outline, its sides cut into `cuts` strips each way.
fn prism(
    outline: &[[f64; 2]],
    [low, high]: [f64; 2],
    cuts: usize,
    with_lids: bool,
) -> Vec<Corners> {
    let corner_at = |[x, y]: [f64; 2], z: f64| [x as f32, y as f32, z as f32];
    let mut corners = Vec::new();
    for (k, p) in outline.iter().enumerate() {
        let q = outline[(k + 1) % outline.len()];
        let along = |i: usize| {
            let s = i as f64 / cuts as f64;
            [p[0] + s * (q[0] - p[0]), p[1] + s * (q[1] - p[1])]
        };
        let up = |j: usize| low + (high - low) * j as f64 / cuts as f64;
        for i in 0..cuts {
            for j in 0..cuts {
                let [a, b] = [along(i), along(i + 1)];
                let [c, d] = [up(j), up(j + 1)];
                corners.push([corner_at(a, c), corner_at(b, c), corner_at(b, d)]);
                corners.push([corner_at(a, c), corner_at(b, d), corner_at(a, d)]);
            }
        }
        if with_lids && k + 1 < outline.len() && k > 0 {
            for z in [low, high] {
                corners.push([corner_at(outline[0], z), corner_at(*p, z), corner_at(q, z)]);
            }
        }
    }
    corners
}

fn area(ring: &Ring) -> f64 {
    let cross = |k: usize| {
        let (p, q) = (ring[k], ring[(k + 1) % ring.len()]);
        p[0] * q[1] - q[0] * p[1]
    };
    0.5 * (0..ring.len()).map(cross).sum::<f64>()
}

const CAR: [[f64; 2]; 4] = [[2.0, -0.9], [2.0, 0.9], [-2.5, 0.9], [-2.5, -0.9]];

fn areas(outlines: &Outlines) -> Vec<f64> {
    outlines.bands.iter().map(|band| band.rings.iter().map(area).sum()).collect()
}

#[test]
fn threads_that_share_the_bands_change_nothing() {
    // A roof that leans: what lies between sections is missed by them.
    let mut corners = prism(&CAR, [0.0, 1.5], 8, true);
    for point in corners.iter_mut().flatten() {
        point[2] *= 1.0 + 0.2 * point[0];
    }
    for kind in [BodyKind::Sedan, BodyKind::Wall] {
        let alone = Outlines::of(&mesh(corners.clone()), kind);
        assert!(alone.bands.len() > 5, "{} bands", alone.bands.len());
        for threads in 1..4 {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let shared = pool.install(|| Outlines::of(&mesh(corners.clone()), kind));
            assert_eq!(shared, alone, "{threads} threads");
        }
    }
}

#[test]
fn a_prism_has_its_own_outline_in_every_band() {
    let outlines = Outlines::of(&mesh(prism(&CAR, [0.2, 1.5], 1, true)), BodyKind::Sedan);
    assert_eq!(outlines.bands.len(), 7);
    assert!((outlines.bands[0].height_m[0] - 0.2).abs() < 1e-6);
    assert!((outlines.bands[6].height_m[1] - 1.5).abs() < 1e-6);
    for band in &outlines.bands {
        assert_eq!((band.rings.len(), band.rings[0].len()), (1, 4), "{:?}", band.rings);
        assert!((area(&band.rings[0]) - 4.5 * 1.8).abs() < 1e-5);
    }
    outlines.check().expect("sound");
    let [length, width] = outlines.size_m().expect("rings");
    assert!((length - 4.5).abs() < 1e-5 && (width - 1.8).abs() < 1e-5);
}

#[test]
fn cutting_flat_faces_changes_nothing() {
    let turned = CAR.map(|[x, y]| [0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y]);
    let coarse = Outlines::of(&mesh(prism(&turned, [0.0, 1.5], 1, true)), BodyKind::Sedan);
    for cuts in [3, 7] {
        let fine = Outlines::of(&mesh(prism(&turned, [0.0, 1.5], cuts, true)), BodyKind::Sedan);
        assert_eq!(fine.bands.len(), coarse.bands.len());
        for (fine, coarse) in areas(&fine).iter().zip(areas(&coarse)) {
            assert!((fine - coarse).abs() < 1e-4, "{fine} {coarse}");
        }
    }
}

#[test]
fn open_cut_and_inside_out_surfaces_have_the_outline_of_the_whole() {
    let whole = prism(&CAR, [0.0, 1.5], 4, true);
    let open = prism(&CAR, [0.0, 1.5], 4, false);
    let reversed = whole.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    // A body with another one inside it, and one whose panels are 4 cm apart.
    let mut nested = whole.clone();
    nested.extend(prism(&CAR.map(|p| p.map(|x| 0.5 * x)), [0.1, 1.4], 1, true));
    let mut parted = Vec::new();
    for (k, p) in CAR.iter().enumerate() {
        let q = CAR[(k + 1) % 4];
        let mix = |s: f64| [p[0] + s * (q[0] - p[0]), p[1] + s * (q[1] - p[1])];
        let panel = [mix(0.01), mix(0.99)];
        let corner_at = |[x, y]: [f64; 2], z: f64| [x as f32, y as f32, z as f32];
        parted.push([corner_at(panel[0], 0.0), corner_at(panel[1], 0.0), corner_at(panel[1], 1.5)]);
        parted.push([corner_at(panel[0], 0.0), corner_at(panel[1], 1.5), corner_at(panel[0], 1.5)]);
    }
    for (name, corners) in
        [("open", open), ("reversed", reversed), ("nested", nested), ("parted", parted)]
    {
        let outlines = Outlines::of(&mesh(corners), BodyKind::Sedan);
        assert_eq!(outlines.bands.len(), 8, "{name}");
        for area in areas(&outlines) {
            assert!((area - 8.1).abs() < 0.03, "{name}: {area}");
        }
    }
}

/// Sections of one wall that differ by a micrometre: their union had thousands of points, and took
/// a second.
#[test]
fn the_union_of_lines_that_nearly_coincide_is_one_of_them() {
    let grid = region::Grid::over(&[[[12.0, 2.0, 0.0]; 3]]);
    let turned = CAR.map(|[x, y]| [0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y]);
    let section = |number: i32| {
        let side = |k: usize| {
            let (p, q) = (turned[k], turned[(k + 1) % 4]);
            (0..20).map(move |i| {
                // Cuts of the faces lie elsewhere in every section.
                let share = (f64::from(i) + f64::from(number % 5) * 0.2).min(19.5) / 20.0;
                let share = if i == 0 { 0.0 } else { share };
                [p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])]
            })
        };
        let off = 1e-6 * f64::from((number * 7) % 3 - 1);
        (0..4).flat_map(side).map(|[x, y]| grid.cell(x + off, y - off)).collect()
    };
    let region = region::Region::union((0..24).map(section).collect(), &grid);
    let rings = region.rings(&grid, 0.0);
    assert_eq!(rings.iter().map(Vec::len).collect::<Vec<_>>(), [4]);
    assert!((area(&rings[0]) - 8.1).abs() < 1e-4);
}

#[test]
fn mirrors_are_weak_by_their_width_or_by_their_name() {
    let mut corners = prism(&CAR, [0.2, 1.5], 1, true);
    let body = corners.len();
    // As wide as an arm, and as wide as a door.
    let mirror = |width: f64| [[0.6, 0.8], [0.6, 1.15], [0.6 - width, 1.15], [0.6 - width, 0.8]];
    corners.extend(prism(&mirror(0.2), [0.9, 1.1], 1, true));
    let narrow = mesh(corners.clone());
    let width = |mesh: &Mesh, kind| Outlines::of(mesh, kind).size_m().expect("rings")[1];
    assert!((width(&narrow, BodyKind::Sedan) - 1.8).abs() < 1e-4);
    assert!((width(&narrow, BodyKind::Building) - 2.05).abs() < 1e-4);
    corners.truncate(body);
    corners.extend(prism(&mirror(0.6), [0.9, 1.1], 1, true));
    let mut wide = mesh(corners);
    assert!((width(&wide, BodyKind::Sedan) - 2.05).abs() < 1e-4);
    wide.parts.push("Left_Mirror.001".to_owned());
    wide.part_of[body..].fill(1);
    assert!((width(&wide, BodyKind::Sedan) - 1.8).abs() < 1e-4);
}

#[test]
fn a_plate_between_two_sections_is_not_missed() {
    let mut corners = prism(&CAR, [0.2, 1.5], 1, true);
    let plate = [[-2.5, -0.9], [-2.5, 0.9], [-4.0, 0.9], [-4.0, -0.9]];
    corners.extend(prism(&plate, [0.60, 0.603], 1, true));
    let outlines = Outlines::of(&mesh(corners), BodyKind::Truck);
    let longest = areas(&outlines).into_iter().fold(0.0, f64::max);
    assert!((longest - 6.0 * 1.8).abs() < 1e-3, "{longest}");
}

#[test]
fn bodies_without_an_inside_have_outlines() {
    let sheet = vec![
        [[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [8.0, 0.0, 2.0]],
        [[0.0, 0.0, 0.0], [8.0, 0.0, 2.0], [0.0, 0.0, 2.0]],
    ];
    let outlines = Outlines::of(&mesh(sheet), BodyKind::Wall);
    let [length, width] = outlines.size_m().expect("rings");
    assert!((length - 8.0).abs() < 0.01 && width < 0.01, "{length} {width}");
    let point = vec![[[1.0, 1.0, 0.0]; 3]];
    assert!(Outlines::of(&mesh(point), BodyKind::Pole).check().is_ok());
}

#[test]
fn the_front_is_where_a_leaning_edge_meets_it() {
    // A bonnet at 0.7 m that rises to 0.9 m over a metre, a windscreen from there to 1.4 m.
    let profile = [[2.0, 0.3], [2.0, 0.7], [1.0, 0.9], [0.0, 1.4], [-2.0, 1.4], [-2.0, 0.3]];
    let corner_at = |[x, z]: [f64; 2], y: f32| [x as f32, y, z as f32 - 0.3];
    let corners = (0..6)
        .flat_map(|k| {
            let (p, q) = (profile[k], profile[(k + 1) % 6]);
            [
                [corner_at(p, -0.9), corner_at(q, -0.9), corner_at(q, 0.9)],
                [corner_at(p, -0.9), corner_at(q, 0.9), corner_at(p, 0.9)],
            ]
        })
        .collect();
    let height = front_height_m(&mesh(corners)).expect("a front");
    assert!((height - 0.4).abs() < 1e-5, "{height}");
    let truck = prism(&CAR, [0.0, 3.0], 1, true);
    assert!((front_height_m(&mesh(truck)).expect("a front") - 1.24).abs() < 1e-5);
}
