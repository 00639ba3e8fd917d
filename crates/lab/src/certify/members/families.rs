//! Generated families of scenes: four ways of a car that differ in place or in speed.

use geometry::rng::Rng;
use std::fmt::Write as _;

/// Makes the text of a scene.
type Family = fn(&mut Rng) -> String;

/// All families, by name.
pub(super) const FAMILIES: [(&str, Family); 12] = [
    ("a pole beside the way", pole),
    ("an oncoming car", oncoming),
    ("a car that crosses", crossing),
    ("somebody on foot who crosses", walker),
    ("wall or pole", wall_or_pole),
    ("the end of a queue", queue),
    ("a cyclist ahead", cyclist),
    ("a truck that turns in", truck),
    ("between two poles", between_poles),
    ("two on foot", two_walkers),
    ("two predicted paths", two_paths),
    ("a motorcycle from the side", motorcycle),
];

/// A scene with a car, these parties, and ways to these places at the side with these speeds.
fn scene(parties: &str, ways: [(f64, f64); 4]) -> String {
    let mut text = format!(
        "schema = \"trolley.scenario/2\"\nname = \"family\"\nhorizon_s = 4\n[parties.ego]\n\
         generate = {{ shape = \"sedan\", triangles = 1000 }}\npersons = [{{ seat = \
         \"front-left\" }}]\n{parties}"
    );
    for (number, (y, speed_m_s)) in ways.into_iter().enumerate() {
        let (near, far) = (speed_m_s, 4.0 * speed_m_s);
        // Writing to a string cannot fail.
        let _w = write!(
            text,
            "[[candidates]]\nname = \"way {number}\"\npath = {{ states = [ {{ t_s = 0, \
             position_m = [0, 0, 0] }}, {{ t_s = 1, position_m = [{near:?}, {y:?}, 0] }}, \
             {{ t_s = 4, position_m = [{far:?}, {y:?}, 0] }} ] }}\n"
        );
    }
    text
}

fn party(name: &str, shape: &str, motion: &str) -> String {
    format!("[parties.{name}]\ngenerate = {{ shape = \"{shape}\", triangles = 1000 }}\n{motion}\n")
}

fn place(x: f64, y: f64, yaw: f64) -> String {
    format!("place = {{ position_m = [{x:?}, {y:?}, 0], yaw_deg = {yaw:?} }}")
}

fn state(x: f64, y: f64, yaw: f64, speed_m_s: f64) -> String {
    format!(
        "state = {{ position_m = [{x:?}, {y:?}, 0], yaw_deg = {yaw:?}, speed_m_s = {speed_m_s:?} }}"
    )
}

/// Four places at the side, at one speed.
fn aside(rng: &mut Rng, reach: f64, speed_m_s: f64) -> [(f64, f64); 4] {
    core::array::from_fn(|_| (rng.between(-reach, reach), speed_m_s))
}

/// Four speeds, straight on.
fn speeds(rng: &mut Rng, low: f64, high: f64) -> [(f64, f64); 4] {
    core::array::from_fn(|_| (0.0, rng.between(low, high)))
}

fn pole(rng: &mut Rng) -> String {
    let at = place(rng.between(22.0, 34.0), rng.between(-0.5, 0.5), 0.0);
    let speed_m_s = rng.between(10.0, 20.0);
    scene(&party("pole", "pole", &at), aside(rng, 1.6, speed_m_s))
}

fn oncoming(rng: &mut Rng) -> String {
    let at = state(rng.between(40.0, 60.0), rng.between(0.5, 1.5), 180.0, rng.between(6.0, 14.0));
    let speed_m_s = rng.between(8.0, 15.0);
    scene(&party("oncoming", "sedan", &at), aside(rng, 1.8, speed_m_s))
}

fn crossing(rng: &mut Rng) -> String {
    let at =
        state(rng.between(22.0, 30.0), rng.between(-22.0, -16.0), 90.0, rng.between(7.0, 12.0));
    scene(&party("crossing", "suv", &at), speeds(rng, 7.0, 15.0))
}

fn walker(rng: &mut Rng) -> String {
    let at = state(rng.between(18.0, 26.0), rng.between(-4.0, -2.0), 90.0, rng.between(1.0, 2.0));
    scene(&party("walker", "pedestrian", &at), speeds(rng, 6.0, 14.0))
}

fn wall_or_pole(rng: &mut Rng) -> String {
    let wall = party("wall", "wall", &place(rng.between(26.0, 32.0), -2.0, 90.0));
    let pole = party("pole", "pole", &place(rng.between(20.0, 26.0), rng.between(1.5, 2.5), 0.0));
    let speed_m_s = rng.between(9.0, 15.0);
    scene(&(wall + &pole), aside(rng, 2.5, speed_m_s))
}

fn queue(rng: &mut Rng) -> String {
    let last = party("last", "sedan", &place(rng.between(24.0, 34.0), rng.between(-0.4, 0.4), 0.0));
    let beside = party("beside", "suv", &place(rng.between(24.0, 34.0), 3.0, 0.0));
    let speed_m_s = rng.between(8.0, 15.0);
    scene(&(last + &beside), aside(rng, 2.0, speed_m_s))
}

fn cyclist(rng: &mut Rng) -> String {
    let at = state(rng.between(14.0, 22.0), rng.between(-1.0, -0.3), 0.0, rng.between(3.0, 6.0));
    let speed_m_s = rng.between(10.0, 16.0);
    scene(&party("cyclist", "cyclist", &at), aside(rng, 1.2, speed_m_s))
}

fn truck(rng: &mut Rng) -> String {
    let at = state(rng.between(26.0, 36.0), rng.between(-9.0, -5.0), 70.0, rng.between(3.0, 6.0));
    scene(&party("truck", "truck", &at), speeds(rng, 7.0, 15.0))
}

fn between_poles(rng: &mut Rng) -> String {
    let left = party("left", "pole", &place(rng.between(22.0, 28.0), rng.between(1.1, 1.7), 0.0));
    let right =
        party("right", "pole", &place(rng.between(22.0, 28.0), rng.between(-1.7, -1.1), 0.0));
    let speed_m_s = rng.between(10.0, 18.0);
    scene(&(left + &right), aside(rng, 0.8, speed_m_s))
}

fn two_walkers(rng: &mut Rng) -> String {
    let one = state(rng.between(18.0, 24.0), rng.between(-3.5, -2.0), 90.0, rng.between(0.8, 1.6));
    let other = state(rng.between(24.0, 30.0), rng.between(2.0, 4.0), -90.0, rng.between(0.8, 1.6));
    let both = party("one", "pedestrian", &one) + &party("other", "pedestrian", &other);
    scene(&both, speeds(rng, 6.0, 13.0))
}

fn two_paths(rng: &mut Rng) -> String {
    let (x, turns) = (rng.between(38.0, 46.0), rng.between(0.2, 0.8));
    let path = |probability: f64, y: f64| {
        format!(
            "[[parties.other.paths]]\nprobability = {probability:?}\nstates = [ {{ t_s = 0, \
             position_m = [{x:?}, 3.5, 0], yaw_deg = 180 }}, {{ t_s = 2, position_m = [{:?}, \
             {y:?}, 0], yaw_deg = 180 }} ]\n",
            x - 18.0
        )
    };
    let other = party("other", "sedan", "") + &path(turns, 0.5) + &path(1.0 - turns, 3.5);
    let pole = party("pole", "pole", &place(rng.between(24.0, 30.0), rng.between(-2.2, -1.2), 0.0));
    let speed_m_s = rng.between(9.0, 14.0);
    scene(&(other + &pole), aside(rng, 1.5, speed_m_s))
}

fn motorcycle(rng: &mut Rng) -> String {
    let at = state(rng.between(20.0, 28.0), rng.between(16.0, 22.0), -90.0, rng.between(8.0, 13.0));
    scene(&party("motorcycle", "motorcycle", &at), speeds(rng, 6.0, 15.0))
}
