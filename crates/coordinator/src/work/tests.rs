//! Nothing slips between poses: thin mirrors of cars that pass each other meet, wherever on its way
//! the scene is written down.

use super::RankingRun;
use crate::answer::Answer;
use crate::fixtures::{AHEAD_M, HALF, mirrored as car};
use crate::request::Request;
use crate::run_in_process;
use body::{Body, BodyView, Meta};
use bvh::{Kernel, NodePair, Question, Side, Sink, Task};
use core::ops::ControlFlow;
use damage::evidence::Touch;
use damage::{Curves, Policy};
use geometry::rng::Rng;
use geometry::{DVec3, Pose, RelativePose};
use scenario::Scenario;

/// An ego that drives along x, and another car somewhere.
#[derive(Clone, Copy, Debug)]
struct Scene {
    position_m: [f64; 2],
    yaw_deg: f64,
    speeds_m_s: [f64; 2],
}

impl Scene {
    /// The same scene, written down a time earlier (s).
    fn earlier(&self, by_s: f64) -> Self {
        let turned = Pose::from_degrees(self.yaw_deg, 0.0, 0.0, [0.0; 3]).rotation;
        let [cos, sin] = [turned[0][0], turned[1][0]];
        let [ego, other] = self.speeds_m_s;
        let [x, y] = self.position_m;
        // The ego stays at the origin.
        Self { position_m: [x + by_s * (ego - other * cos), y - by_s * other * sin], ..*self }
    }

    fn answer(&self, bodies: &[(Meta, BodyView<'_>)]) -> (Answer, RelativePose, DVec3) {
        let Self { position_m: [x, y], yaw_deg, speeds_m_s: [ego, other] } = self;
        let text = format!(
            "schema = \"trolley.scenario/1\"\nname = \"pass\"\n[parties]\n\
             ego = {{ generate = {{ shape = \"sedan\", triangles = 600 }} }}\n\
             other = {{ generate = {{ shape = \"sedan\", triangles = 600 }} }}\n\
             [[candidates]]\nname = \"go on\"\n\
             ego = {{ position_m = [0, 0, 0], speed_m_s = {ego:?} }}\n\
             other = {{ party = \"other\", position_m = [{x:?}, {y:?}, 0], yaw_deg = {yaw_deg:?}, \
             speed_m_s = {other:?} }}\n"
        );
        let scenario = Scenario::parse("pass.toml", &text).unwrap();
        let (policy, curves) = (Policy::shipped().unwrap(), Curves::shipped().unwrap());
        let request = Request::new(&scenario, bodies, policy, curves).unwrap();
        let mut work = RankingRun::new(&request, bodies, 3);
        run_in_process(&mut work, bodies);
        let candidate = &request.candidates[0];
        (work.answer().unwrap(), candidate.pose, candidate.approach.directions.d[0])
    }

    /// Where the other car stands in the ego's frame at first contact; `None`: it never touches.
    fn contact(&self, bodies: &[(Meta, BodyView<'_>)]) -> Option<DVec3> {
        let (answer, pose, u) = self.answer(bodies);
        assert_eq!(answer.state, damage::AnswerState::Complete, "{self:?}");
        let contact = &answer.ranking[0].contact;
        assert_eq!(contact.touch == Touch::Yes, contact.patch.is_some());
        let first_m = contact.patch.as_ref()?.first_m;
        assert!(first_m.is_settled());
        Some(DVec3::from_array(pose.translation) - u * first_m.hi())
    }
}

fn views(body: &Body) -> [(Meta, BodyView<'_>); 2] {
    [(body.meta.clone(), body.view()), (body.meta.clone(), body.view())]
}

#[test]
fn mirrors_meet_wherever_the_pass_is_written_down() {
    let car = car(0.2, 0.02);
    let bodies = views(&car);
    for tenths in -19..=40 {
        let position_m = [0.1 * f64::from(tenths), 2.02];
        let scene = Scene { position_m, yaw_deg: 180.0, speeds_m_s: [10.0, 10.0] };
        let at = scene.contact(&bodies);
        let off = at.map(|at| (at - DVec3::new(2.0 * AHEAD_M + 0.02, 2.02, 0.0)).length());
        assert!(off.is_some_and(|off| off < 1e-6), "{scene:?}: {at:?}");
    }
}

#[test]
fn a_way_too_long_to_be_searched_stays_open() {
    let car = car(0.2, 0.02);
    let bodies = views(&car);
    // They meet behind the greatest travel that a sweep takes.
    let scene = Scene { position_m: [1e6, 0.0], yaw_deg: 0.0, speeds_m_s: [30.0, 0.0] };
    let (answer, ..) = scene.answer(&bodies);
    let row = &answer.ranking[0];
    assert_eq!(row.contact.touch, Touch::Unknown, "{row:?}");
    assert_eq!(answer.missing.len(), 1, "{:?}", answer.missing);
    // One candidate wins whatever is missing, but it is not harmless.
    assert_ne!(answer.state, damage::AnswerState::Complete);
    assert!(row.persons.iter().all(|person| person.work.hi() > 0.1), "{:?}", row.persons);
}

/// Whether the exact kernel finds a hit where the other car stands there.
fn touches(
    bodies: &[(Meta, BodyView<'_>)],
    pose: &RelativePose,
    at: DVec3,
    kernel: &mut Kernel,
) -> bool {
    struct First(bool);
    impl Sink for First {
        fn hit(&mut self, _: Side, _: u32) -> ControlFlow<()> {
            self.0 = true;
            ControlFlow::Break(())
        }
        fn beat(&mut self, _: u64) -> ControlFlow<()> {
            ControlFlow::Continue(())
        }
    }
    let pose = RelativePose { translation: at.to_array(), ..*pose };
    let (a, b) = (bodies[0].1, bodies[1].1);
    let task = Task { a, b, pose, question: Question::Touches, directions: None };
    let mut first = First(false);
    kernel.run(&task, NodePair::ROOTS, u64::MAX, &mut first);
    first.0
}

#[test]
fn thin_mirrors_meet_at_the_same_place_from_wherever_they_come() {
    let mut rng = Rng::new(31);
    let share = |rng: &mut Rng| rng.below(1 << 20) as f64 / f64::from(1 << 20);
    let mut between = |low: f64, high: f64| low + (high - low) * share(&mut rng);
    let mut found = 0;
    for number in 0..2000 {
        let (thickness_m, length_m) = (between(0.002, 0.06), between(0.1, 0.25));
        // Not so much that a tip grazes the side of the other car: rounding decides that.
        let overlap_m =
            (0.95 * length_m).min(0.0001 * f64::from(1 << (number % 11)) * between(1.0, 2.0));
        let car = car(length_m, thickness_m);
        let bodies = views(&car);
        let across_m = 2.0 * (HALF[1] + length_m) - overlap_m;
        let turned = if number % 2 == 0 { 0.0 } else { between(-6.0, 6.0) };
        let scene = Scene {
            position_m: [2.0 * AHEAD_M + thickness_m, across_m],
            yaw_deg: 180.0 + turned,
            speeds_m_s: [between(1.0, 40.0), between(0.0, 40.0)],
        };
        let closing = scene.speeds_m_s[0] + scene.speeds_m_s[1];
        // The mirrors touch at time 0 if the other car is not turned.
        let starts = [-between(0.0, 3.0), 0.0, between(0.0, 4.0)].map(|travel| travel / closing);
        let contacts = starts.map(|by_s| scene.earlier(by_s).contact(&bodies));
        let first = contacts[1];
        for at in contacts {
            let same = at.zip(first).map(|(at, first)| (at - first).length() < 1e-6);
            assert!(same.unwrap_or(at == first), "{scene:?}: {contacts:?}");
        }
        if turned == 0.0 {
            assert!(first.is_some(), "{scene:?}");
        }
        found += u32::from(first.is_some());
        // Dense poses find nothing before, and nothing at all where nothing was found.
        let (_, pose, u) = scene.answer(&bodies);
        let mut kernel = Kernel::with_room(32, 32, car.corners.len(), car.corners.len());
        let last = first.unwrap_or(DVec3::from_array(pose.translation) - u * 3.0);
        for step in 0..40 {
            let before = last + u * (1e-6 + 0.15 * f64::from(step));
            assert!(
                !touches(&bodies, &pose, before, &mut kernel),
                "{scene:?} at {before}, not before {first:?}"
            );
        }
    }
    assert!(found > 1400, "{found} of 2000 scenes, each from three places");
}
