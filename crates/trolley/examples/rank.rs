//! Ranks a scenario file: `cargo run --release -p trolley --example rank -- SCENARIO.toml`.
#![expect(clippy::print_stdout, reason = "an example talks to a terminal")]

use trolley::{Engine, Failure, Limits, Scenario};

fn main() -> Result<(), Failure> {
    trolley::play_worker(); // workers are this program, started again
    let path = std::env::args().nth(1).unwrap_or("config/scenarios/minimal.toml".to_owned());
    let scenario = Scenario::open(path)?;
    let mut engine = Engine::builder().workers(2).build()?;
    let ranking = engine.rank(&scenario, &Limits::default())?;
    for row in &ranking.answer.ranking {
        println!("{:.4} to {:.4}  {}", row.range.low(), row.range.high(), row.name);
    }
    println!("least harm: {}", ranking.best().map_or("nobody can tell", |best| &best.name));
    Ok(())
}
