//! Lists which triangles of two mesh files intersect, as the bodies lie in their files:
//! `cargo run --release -p trolley --example pairs -- A.stl B.stl`.
#![expect(clippy::print_stdout, reason = "an example talks to a terminal")]

use trolley::Failure;
use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace, pairs, read_mesh};

fn main() -> Result<(), Failure> {
    let [a, b] = [1, 2].map(|at| std::env::args().nth(at).unwrap_or_default());
    let options = BuildOptions::default();
    let a = Tree::build(&read_mesh(a)?, &options)?;
    let b = Tree::build(&read_mesh(b)?, &options)?;
    let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
    for (a, b) in pairs(&a, &b, &pose, &mut Workspace::new())? {
        println!("triangle {a} of A meets triangle {b} of B");
    }
    Ok(())
}
