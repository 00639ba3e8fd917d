//! Finds when one mesh first touches another one as it moves along a straight line:
//! `cargo run --release -p trolley --example sweep -- A.stl B.stl X Y Z METRES`.
#![expect(clippy::print_stdout, reason = "an example talks to a terminal")]

use trolley::Failure;
use trolley::kernel::{BuildOptions, Pose, RelativePose, Sweep, SweepWorkspace, Tree};
use trolley::kernel::{first_contact, read_mesh};

fn main() -> Result<(), Failure> {
    let word = |at: usize| std::env::args().nth(at).unwrap_or_default();
    let number = |at: usize| word(at).parse().unwrap_or(f64::NAN);
    let options = BuildOptions::default();
    let a = Tree::build(&read_mesh(word(1))?, &options)?;
    let b = Tree::build(&read_mesh(word(2))?, &options)?;
    // As the bodies lie in their files, and then B moves.
    let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
    let sweep = Sweep::new([3, 4, 5].map(number).into(), 0.0, number(6))?;
    match first_contact(&a, &b, &pose, &sweep, &mut SweepWorkspace::new())? {
        None => println!("B never touches A on that way"),
        Some(first) => {
            let ([a, b], at) = (first.ids, first.travel_m);
            println!("after {at} m, triangle {a} of A meets triangle {b} of B");
        }
    }
    Ok(())
}
