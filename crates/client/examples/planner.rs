//! A planner in Rust: sends the request of `config/scenarios/wall-or-pole.toml` every 100 ms, and
//! prints the ranking. Arguments: number of requests (default 1), instance, folder (may be empty),
//! and in how many members of what is known only up to errors it is ranked (default: as stated).
//!
//! ```text
//! trolley serve config/deployments/minimal.toml
//! cargo run --release -p trolley-client --example planner -- 10
//! ```
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example talks to a terminal")]

use std::time::Duration;
use trolley_client::public::{
    Ask, PartyErrors, WireAnswer, WireParty, WirePath, WirePathKind, WirePathState,
};
use trolley_client::{Client, Waiting};

const NAMES: [&str; 3] = ["straight on, the wall", "to the left, the pole", "brake"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let turns: u32 = words.next().map_or(Ok(1), |word| word.parse())?;
    let instance = words.next().unwrap_or_else(|| "minimal".to_owned());
    let folder = words.next().filter(|word| !word.is_empty()).map(std::path::PathBuf::from);
    let members: u32 = words.next().map_or(Ok(1), |word| word.parse())?;
    let mut client = Client::connect(folder.as_deref(), &instance, Waiting::Spin)?;
    let mut ask = what_is_left().ok_or("the request has too many parties or candidates")?;
    ask.set_members(members, members);
    for turn in 0..turns {
        // A real planner asks again with each new view of the world; here nothing moves.
        let answer = client.ask(&ask, Duration::from_secs(1));
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

/// Three ways are left. Models by the ids of `config/deployments/minimal.toml`.
fn what_is_left() -> Option<Box<Ask>> {
    let mut ask = Ask::new(5.0);
    // What localisation and tracking say of themselves; of the wall they say nothing.
    let own = PartyErrors {
        lateral_m: Some(0.1),
        longitudinal_m: Some(0.5),
        correlation: Some(0.25),
        yaw_deg: Some(1.5),
        speed_share: Some(0.08),
    };
    let seen = PartyErrors {
        lateral_m: Some(0.4),
        longitudinal_m: Some(0.6),
        correlation: Some(0.0),
        ..PartyErrors::default()
    };
    ask.ego = ask.add_party(WireParty::of_model(1).with_errors(&own))?;
    let stands = WirePath::of_kind(WirePathKind::Place);
    let pole = WirePathState::at(0.0, [20.0, 2.9], 0.0);
    ask.add_party_on(WireParty::of_model(3).with_errors(&seen), stands, &[pole])?;
    let wall = WirePathState::at(0.0, [25.0, 0.0], 90.0);
    ask.add_party_on(WireParty::of_model(2), stands, &[wall])?;

    let now = WirePathState::at(0.0, [0.0, 0.0], 0.0).with_velocity([14.0, 0.0]);
    let straight = ask.add_path(WirePath::of_kind(WirePathKind::Onward), &[now])?;
    let through = WirePath::of_kind(WirePathKind::States);
    let state = |t_s: f64, x: f64, y: f64, yaw_deg: f64| WirePathState::at(t_s, [x, y], yaw_deg);
    let left = [
        state(0.0, 0.0, 0.0, 0.0),
        state(0.5, 7.0, 0.4, 6.0),
        state(1.0, 13.8, 1.8, 14.0),
        state(1.5, 20.4, 4.0, 20.0),
    ];
    let left = ask.add_path(through, &left)?;
    let brake = [
        state(0.0, 0.0, 0.0, 0.0),
        state(0.5, 6.3, 0.0, 0.0),
        state(1.0, 11.2, 0.0, 0.0),
        state(1.5, 14.7, 0.0, 0.0),
        state(2.0, 16.8, 0.0, 0.0),
        state(2.5, 17.5, 0.0, 0.0),
        state(2.6, 17.5, 0.0, 0.0),
    ];
    let brake = ask.add_path(through, &brake)?;
    for path in [straight, left, brake] {
        ask.add_candidate(path, &[])?;
    }
    Some(ask)
}

fn show(answer: &WireAnswer) {
    for (number, place) in answer.ranking().iter().enumerate() {
        let name = NAMES.get(place.candidate as usize).unwrap_or(&"?");
        print!("{} {name}: {:?} {:?}", number + 1, place.work[0], place.work[1]);
        if let Some(of) = place.expected() {
            let [low, middle, high] = of.quantiles;
            let figures = [of.contact, of.injured[0], of.injured[1], of.error, low, middle, high];
            for figure in figures.iter().chain(&[of.best, of.regret, of.worlds]) {
                print!(" {figure:?}");
            }
            for met in of.listed() {
                print!(" {} {:?} {:?}", met.party, met.probability, met.from_s);
            }
        }
        println!();
    }
    if let Some((lead, error)) = answer.lead() {
        println!("{} members: {lead:?} {error:?}", answer.members);
    }
}
