//! Members are the same everywhere, spread as they should be, and move bodies as documented.

use super::*;
use geometry::DVec3;

const SCENE: &str = r#"
schema = "trolley.scenario/2"
name = "members"
members = 32
[parties.ego]
generate = { shape = "sedan", triangles = 600 }
errors = { lateral_m = 0.5, longitudinal_m = 1, correlation = 0.8, yaw_deg = 3, speed_share = 0.2 }
[parties.car]
generate = { shape = "sedan", triangles = 600 }
paths = [
    { probability = 0.25, states = [ { t_s = 0, position_m = [30, 0, 0], yaw_deg = 180 },
        { t_s = 2, position_m = [10, 0, 0], yaw_deg = 180 },
        { t_s = 4, position_m = [5, 3, 0], yaw_deg = 90 } ] },
    { probability = 0.75, states = [ { t_s = 0, position_m = [30, 0, 0], yaw_deg = 180,
        velocity_m_s = [-10, 0] } ] },
]
[[candidates]]
name = "turn"
state = { position_m = [1, 2, 0], yaw_deg = 90, speed_m_s = 10, yaw_rate_deg_s = 20 }
"#;

fn scene() -> Scenario {
    Scenario::parse("members.toml", SCENE).unwrap_or_else(|error| panic!("{error}"))
}

/// Party 0 is the car, party 1 the ego.
fn draws(count: u32) -> Vec<MemberDraw> {
    let scene = scene();
    let sequence = MemberSequence::new(&scene);
    (0..count).map(|number| sequence.draw(number)).collect()
}

#[test]
fn draws_have_the_spread_that_is_stated() {
    let draws = draws(4096);
    let mean = |of: &dyn Fn(&MemberDraw) -> f64| draws.iter().map(of).sum::<f64>() / 4096.0;
    let ego = |draw: &MemberDraw| draw.parties[1];
    let lateral = |draw: &MemberDraw| ego(draw).lateral_m;
    let along = |draw: &MemberDraw| ego(draw).longitudinal_m;
    for (of, deviation) in [
        (&lateral as &dyn Fn(&MemberDraw) -> f64, 0.5),
        (&along, 1.0),
        (&|draw| ego(draw).yaw_deg, 3.0),
        (&|draw| libm::log(ego(draw).speed_factor), 0.2),
        (&|draw| libm::log(draw.parties[0].speed_factor), 0.1),
        (&|draw| draw.parties[0].lateral_m, 0.2),
        (&|draw| draw.run_out_turn_deg, 9.0),
    ] {
        let square = mean(&|draw| of(draw) * of(draw));
        assert!(mean(of).abs() < 0.01 * deviation, "{deviation}: {}", mean(of));
        assert!((square.sqrt() / deviation - 1.0).abs() < 0.02, "{deviation}: {}", square.sqrt());
    }
    let together = mean(&|draw| lateral(draw) * along(draw)) / 0.5;
    assert!((together - 0.8).abs() < 0.02, "{together}");
    let first = draws.iter().filter(|draw| draw.parties[0].choice < 0.25).count();
    assert!((1022..=1026).contains(&first), "{first} of 4096 take the first path");
    assert!(draws.iter().all(|draw| (0.0..1.0).contains(&draw.run_out_share)));
}

/// Any power of two of them is stratified in every coordinate: as many below the median as above.
#[test]
fn a_few_members_are_spread_evenly() {
    for count in [2, 8, 32, 128] {
        let draws = draws(count);
        for of in [
            &|draw: &MemberDraw| draw.parties[1].lateral_m,
            &|draw: &MemberDraw| draw.parties[1].yaw_deg,
            &|draw: &MemberDraw| draw.parties[0].choice - 0.5,
            &|draw: &MemberDraw| draw.run_out_share - 0.5,
        ] as [&dyn Fn(&MemberDraw) -> f64; 4]
        {
            let below = draws.iter().filter(|draw| of(draw) < 0.0).count();
            assert_eq!(below, count as usize / 2);
        }
    }
}

/// They do not change unnoticed: answers depend on them.
#[test]
fn draws_are_pinned() {
    let draw = &draws(6)[5];
    let bits: Vec<u64> = draw.parties.iter().map(|draw| draw.lateral_m.to_bits()).collect();
    assert_eq!(bits, PINNED);
}

const PINNED: [u64; 2] = [4_595_990_069_254_484_868, 4_592_739_444_308_628_821];

#[test]
fn a_faster_body_goes_the_same_way_sooner() {
    let scene = scene();
    let draw = PartyDraw { speed_factor: 1.25, ..PartyDraw::NOMINAL };
    let paths = &scene.parties[0].predictions;
    for motion in [&paths[0].motion, &paths[1].motion, &scene.candidates[0].ego] {
        let faster = motion.drawn(&draw, scene.horizon_s).expect("a path");
        assert_eq!((faster.from_s(), faster.to_s()), (0.0, scene.horizon_s));
        for k in 0..=80 {
            let time_s = 0.05 * f64::from(k);
            if 1.25 * time_s > scene.horizon_s {
                break;
            }
            let (now, then) = (faster.state_at(time_s), motion.path.state_at(1.25 * time_s));
            let off = DVec3::from(now.position_m) - DVec3::from(then.position_m);
            assert!(off.length() < 2e-3, "{time_s}: {off}");
            assert!(now.orientation.angle_to(&then.orientation) < 1e-2, "{time_s}");
        }
    }
    let faster = paths[1].motion.drawn(&draw, scene.horizon_s).expect("a path");
    let end = faster.state_at(scene.horizon_s).position_m[0];
    assert!((end - (30.0 - 12.5 * scene.horizon_s)).abs() < 1e-9, "{end}");
    let nominal = paths[0].motion.drawn(&PartyDraw::NOMINAL, scene.horizon_s).expect("a path");
    assert_eq!(nominal, paths[0].motion.path);
}

#[test]
fn an_offset_is_in_the_bodys_own_frame() {
    let scene = scene();
    let draw =
        PartyDraw { longitudinal_m: 0.5, lateral_m: 0.25, yaw_deg: 90.0, ..PartyDraw::NOMINAL };
    // It goes along y at first: forward is y, left is -x.
    let path = scene.candidates[0].ego.drawn(&draw, scene.horizon_s).expect("a path");
    let state = path.state_at(0.0);
    let off = DVec3::from(state.position_m) - DVec3::new(0.75, 2.5, 0.0);
    assert!(off.length() < 1e-12, "{state:?}");
    let turned = geometry::motion::Orientation::from_degrees(180.0, 0.0, 0.0);
    assert!(state.orientation.angle_to(&turned) < 1e-9);
    assert_eq!(draw.of_fixed().yaw_deg, 0.0);
}

#[test]
fn numbers_of_members_are_checked() {
    let sound = |count, most| Members::new(count, most).map(|of| (of.count, of.most)).ok();
    assert_eq!(sound(1, None), Some((1, 1)));
    assert_eq!(sound(32, None), Some((32, 128)));
    assert_eq!(sound(200, None), Some((200, 200)));
    assert_eq!(sound(32, Some(64)), Some((32, 64)));
    for (count, most) in [(0, None), (1025, None), (32, Some(16)), (1, Some(2)), (2, Some(4096))] {
        assert_eq!(sound(count, most), None, "{count} {most:?}");
    }
    for (from, to, place) in [
        ("members = 32", "members = 0", "members.toml:4"),
        ("members = 32", "members = 2.5", "members.toml:4"),
        ("members = 32", "members = 32\nmembers_max = 4", "members.toml:5"),
        ("lateral_m = 0.5", "lateral_m = -0.5", "members.toml:7"),
        ("lateral_m = 0.5", "lateral_m = nan", "members.toml:7"),
        ("correlation = 0.8", "correlation = 1.1", "members.toml:7"),
        ("yaw_deg = 3", "sigma_deg = 3", "members.toml:7"),
        ("speed_share = 0.2", "speed_share = 0.6", "members.toml:7"),
    ] {
        let error = Scenario::parse("members.toml", &SCENE.replace(from, to)).expect_err(to);
        assert!(error.to_string().starts_with(place), "{to}: {error}");
    }
}
