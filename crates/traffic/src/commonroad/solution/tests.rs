//! Solutions by hand, for every vehicle model, and each of their faults.

use crate::{NamedText, ReadOptions, Recording, TrafficError, read};

/// Two planning problems that begin at different places.
const SCENE: &str = "<commonRoad commonRoadVersion='2020a' timeStepSize='0.1' \
    benchmarkID='ZAM_Two-1_1_T-1'>\
    <planningProblem id='7'><initialState><position><point><x>1</x><y>2</y></point></position>\
    <orientation><exact>0</exact></orientation><time><exact>0</exact></time>\
    <velocity><exact>10</exact></velocity></initialState></planningProblem>\
    <planningProblem id='8'><initialState><position><point><x>50</x><y>2</y></point></position>\
    <orientation><exact>0</exact></orientation><time><exact>0</exact></time>\
    <velocity><exact>5</exact></velocity></initialState></planningProblem></commonRoad>";

/// Of a kinematic single-track model for the first, of a point mass for the second.
const SOLUTION: &str = "<CommonRoadSolution \
    benchmark_id='[KS3,PM1]:[SM1,SM1]:ZAM_Two-1_1_T-1:2020a'>
<ksTrajectory planningProblem='7'>
<ksState><x>1</x><y>2</y><steeringAngle>0</steeringAngle><velocity>10</velocity>\
<orientation>0</orientation><time>0</time></ksState>
<ksState><x>2</x><y>2</y><steeringAngle>0</steeringAngle><velocity>10</velocity>\
<orientation>6.3831853</orientation><time>1</time></ksState>
</ksTrajectory>
<pmTrajectory planningProblem='8'>
<pmState><x>50</x><y>2</y><xVelocity>3</xVelocity><yVelocity>4</yVelocity><time>0</time></pmState>
<pmState><x>50.2</x><y>2.3</y><xVelocity>0</xVelocity><yVelocity>0</yVelocity><time>1</time>\
</pmState>
</pmTrajectory>
</CommonRoadSolution>";

fn solved(ego: Option<&str>, text: &str) -> Result<Recording, TrafficError> {
    let solutions = [NamedText { file: "found/by mine.v2.xml", text }];
    read("s.xml", SCENE, &ReadOptions { ego, solutions: &solutions, ..ReadOptions::default() })
}

#[test]
fn each_planning_problem_has_its_own_trajectory() {
    let first = solved(None, SOLUTION).expect("valid");
    let [planned] = first.planned.as_slice() else { panic!("one") };
    assert_eq!((planned.name.as_str(), planned.went.len()), ("by mine.v2", 2));
    assert_eq!(planned.went[1].place.at, [2.0, 2.0]);
    assert!((planned.went[1].place.yaw - 0.1).abs() < 1e-6 && planned.went[1].time_s == 0.1);
    assert_eq!(first.ego.outline.map(|outline| outline.size()), Some([4.569, 1.844]));
    assert!(first.notes[0].contains("the first, 7, is taken as the ego"), "{:?}", first.notes);

    let second = solved(Some("8"), SOLUTION).expect("valid");
    assert_eq!(second.ego.start.place.at, [50.0, 2.0]);
    let [start, end] = second.planned[0].went.as_slice() else { panic!("two") };
    assert_eq!((start.speed_m_s, end.speed_m_s), (5.0, 0.0));
    // Where a point mass stands it looks as before.
    assert!((start.place.yaw - libm::atan2(4.0, 3.0)).abs() < 1e-12);
    assert_eq!(end.place.yaw, start.place.yaw);
    assert_eq!(second.ego.outline.map(|outline| outline.size()), Some([4.298, 1.674]));
}

#[test]
fn a_body_that_slips_goes_where_it_slips() {
    let with = |more: &str| {
        let text = SOLUTION.replacen("<velocity>10</velocity>", more, 1);
        solved(None, &text).expect("valid").planned[0].went[0].velocity_m_s()
    };
    let near = |[x, y]: [f64; 2], expected: [f64; 2]| {
        assert!((x - expected[0]).abs() < 1e-9 && (y - expected[1]).abs() < 1e-9, "{x}, {y}");
    };
    near(with("<velocity>10</velocity><slipAngle>0</slipAngle>"), [10.0, 0.0]);
    let (sin, cos) = (libm::sin(0.2), libm::cos(0.2));
    near(with("<velocity>10</velocity><slipAngle>0.2</slipAngle>"), [10.0 * cos, 10.0 * sin]);
    near(with("<velocity>9</velocity><yVelocity>1</yVelocity>"), [9.0, 1.0]);
}

/// What is replaced, by what, the line of the fault, and its text.
const WRONG: &[(&str, &str, u32, &str)] = &[
    ("<CommonRoadSolution", "<commonRoad", 10, "not readable as XML"),
    (":[SM1,SM1]:ZAM_Two-1_1_T-1:2020a", "", 1, "names no scenario"),
    ("ZAM_Two", "USA_US101", 1, "it solves \"USA_US101-1_1_T-1\", not \"ZAM_Two-1_1_T-1\""),
    ("planningProblem='7'", "planningProblem='9'", 1, "no trajectory for planning problem \"7\""),
    ("ksTrajectory", "ksInputVector", 2, "inputs say how to steer"),
    ("<x>1</x>", "", 3, "<x> is missing"),
    ("<x>1</x>", "<x>NaN</x>", 3, "is not a finite number"),
    ("<velocity>10</velocity>", "<velocity>200</velocity>", 3, "velocity is 200 m/s"),
    ("<time>1</time>", "<time>0</time>", 4, "its time is not after"),
    ("<time>0</time>", "<time>0.5</time>", 3, "it begins at 0.05 s, the ego at 0 s"),
];

#[test]
fn every_fault_is_reported_with_its_line() {
    for (old, new, line, fault) in WRONG {
        assert!(SOLUTION.contains(old), "{old}");
        let text = if old.contains("Trajectory") {
            SOLUTION.replace(old, new)
        } else {
            SOLUTION.replacen(old, new, 1)
        };
        let error = solved(None, &text).expect_err(old);
        assert_eq!(error.place.line(), *line, "{error}");
        assert!(error.to_string().contains(fault), "{error}");
        assert_eq!(error.file, "found/by mine.v2.xml");
        assert!(!error.remedy.is_empty());
    }
    let other = solved(None, SCENE).expect_err("no solution");
    assert!(other.to_string().contains("not <CommonRoadSolution>"), "{other}");
}

/// A single state would be an ego that stands there for ever.
#[test]
fn one_state_is_no_way() {
    let from = SOLUTION.find("<ksState><x>2</x>").expect("the second state");
    let to = SOLUTION.find("</ksTrajectory>").expect("the end");
    let text = format!("{}{}", &SOLUTION[..from], &SOLUTION[to..]);
    let error = solved(None, &text).expect_err("one state");
    assert!(error.to_string().contains("fewer than two states"), "{error}");
}

/// Of an ego that is an obstacle no planning problem says where it starts.
#[test]
fn an_obstacle_has_no_solution() {
    let obstacle = "<dynamicObstacle id='3'><type>car</type><shape><rectangle><length>4</length>\
        <width>2</width></rectangle></shape><initialState><position><point><x>9</x><y>9</y></point>\
        </position><orientation><exact>0</exact></orientation><time><exact>0</exact></time>\
        <velocity><exact>1</exact></velocity></initialState><trajectory><state><position><point>\
        <x>10</x><y>9</y></point></position><orientation><exact>0</exact></orientation><time>\
        <exact>10</exact></time></state></trajectory></dynamicObstacle>";
    let scene = SCENE.replacen("<planningProblem", &format!("{obstacle}<planningProblem"), 1);
    let solutions = [NamedText { file: "mine.xml", text: SOLUTION }];
    let read_as = |ego: Option<&str>| {
        read("s.xml", &scene, &ReadOptions { ego, solutions: &solutions, ..ReadOptions::default() })
    };
    assert_eq!(read_as(Some("7")).expect("a problem").planned.len(), 1);
    let error = read_as(Some("3")).expect_err("an obstacle");
    assert!(error.to_string().contains("the ego is an obstacle"), "{error}");
}

/// Whose size is taken for another one's is said.
#[test]
fn solutions_of_other_vehicles_are_noted() {
    let truck = SOLUTION.replacen("KS3", "KS4", 1);
    let noted = |files: [(&str, &str); 2]| {
        let solutions = files.map(|(file, text)| NamedText { file, text });
        let options = ReadOptions { solutions: &solutions, ..ReadOptions::default() };
        read("s.xml", SCENE, &options).expect("valid").notes[1..].to_vec()
    };
    let small = SOLUTION.replacen("KS3", "KS1", 1);
    assert_eq!(noted([("a.xml", SOLUTION), ("b.xml", SOLUTION)]), Vec::<String>::new());
    let notes = noted([("a.xml", SOLUTION), ("b.xml", &small)]);
    assert!(notes.len() == 1 && notes[0].contains("\"b\" is of a vehicle of 4.298"), "{notes:?}");
    let notes = noted([("a.xml", &truck), ("b.xml", SOLUTION)]);
    assert!(notes.len() == 1 && notes[0].contains("\"a\" is of a vehicle of unknown"), "{notes:?}");
}

#[test]
fn two_solutions_have_two_names() {
    let one = NamedText { file: "a/x.xml", text: SOLUTION };
    let two = NamedText { file: "b/x.xml", text: SOLUTION };
    let options = ReadOptions { solutions: &[one, two], ..ReadOptions::default() };
    let error = read("s.xml", SCENE, &options).expect_err("twins");
    assert!(error.to_string().contains("two solutions are called \"x\""), "{error}");
}
