//! A planner in Rust: sends the request of `config/scenarios/minimal.toml` every 100 ms, and prints
//! the ranking. Arguments: number of requests (default 1), instance, folder.
//!
//! ```text
//! trolley serve config/deployments/minimal.toml
//! cargo run --release -p trolley-client --example planner -- 10
//! ```
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks to a terminal")]

use std::time::Duration;
use trolley_client::public::{Ask, Motion, WireAnswer, WireCandidate, WireParty};
use trolley_client::{Client, Waiting};

const NAMES: [&str; 2] = ["wall, frontal", "pole, narrow"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let turns: u32 = words.next().map_or(Ok(1), |word| word.parse())?;
    let instance = words.next().unwrap_or_else(|| "minimal".to_owned());
    let folder = words.next().map(std::path::PathBuf::from);
    let mut client = Client::connect(folder.as_deref(), &instance, Waiting::Spin)?;
    let ask = what_is_left().ok_or("the request has too many parties or candidates")?;
    for turn in 0..turns {
        // A real planner asks again with each new view of the world; here nothing moves.
        let answer = client.ask(&ask, Duration::from_millis(100));
        eprintln!("{} {}", answer.verdict().name(), answer.text());
        if turn + 1 == turns {
            show(&answer);
        }
        if turn + 1 < turns {
            let pause = rustix::time::Timespec { tv_sec: 0, tv_nsec: 100_000_000 };
            let _early = rustix::thread::nanosleep(&pause);
        }
    }
    Ok(())
}

/// Two ways are left. Models by the ids of `config/deployments/minimal.toml`.
fn what_is_left() -> Option<Ask> {
    let mut ask = Ask::new(0);
    ask.ego = ask.add_party(WireParty::of_model(1))?;
    let pole = ask.add_party(WireParty::of_model(3))?;
    let wall = ask.add_party(WireParty::of_model(2))?;
    let ego = Motion { velocity_m_s: [10.0, 0.0], ..Motion::default() };
    let motion = |x: f64, y: f64, yaw: f64| Motion {
        position_m: [x, y, 0.0],
        angles_deg: [yaw, 0.0, 0.0],
        ..Motion::default()
    };
    for (party, other) in [(wall, motion(2.55, 0.0, 90.0)), (pole, motion(2.4, 0.3, 0.0))] {
        ask.add_candidate(WireCandidate { party, spare: 0, probability: 1.0, ego, other })?;
    }
    Some(ask)
}

fn show(answer: &WireAnswer) {
    for (number, place) in answer.ranking().iter().enumerate() {
        let name = NAMES.get(place.candidate as usize).unwrap_or(&"?");
        println!("{} {name} {:?} {:?}", number + 1, place.work[0], place.work[1]);
    }
}
