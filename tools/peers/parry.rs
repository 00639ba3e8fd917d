//! A driver for parry3d, in the manner of `case.hpp`: `Bvh::leaf_pairs` finds the candidates, our
//! exact triangle test decides them.
//!
//! Its trees are f32 and know no pose, so a box of B is turned into A's frame at each test, as
//! parry's own mesh intersection does, and loosened by what f32 may have lost.

mod common;

use anyhow::{Context as _, Result, bail};
use common::{ms_since, now, pose32, read_stl};
use geometry::{Corners, DVec3, Pose, RelativePose, Triangle, hash, triangle};
use parry3d::bounding_volume::{Aabb, BoundingVolume as _};
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use std::hint::black_box;
use std::path::{Path, PathBuf};

struct Options {
    folder: PathBuf,
    repeat: usize,
    cold: bool,
    moving: bool,
}

fn main() -> Result<()> {
    let options = options()?;
    let folder = &options.folder;
    let (a, b) = (read_stl(&folder.join("a.stl"))?, read_stl(&folder.join("b.stl"))?);
    let worlds = read_poses(&folder.join("pose.txt"))?;

    let start = now();
    let (tree_a, tree_b) = (tree(&a), tree(&b));
    let build_ms = ms_since(start);

    let mut pairs = Vec::new();
    let mut np = 0_u64;
    let (mut posings, mut queries) = (Vec::new(), Vec::new());
    // One run to warm up.
    for turn in (0..=options.repeat).rev() {
        let start = now();
        let [world_a, mut world_b] = worlds;
        if options.moving {
            // The same places as those of `case.hpp`.
            world_b.translation[0] += 0.001 * (((turn + 4) % 9) as f64 - 4.0);
        }
        let pose = RelativePose::between(&world_a, &world_b);
        let posed = pose32(&pose)?;
        // Coordinates of either body in A's frame go through a few roundings of f32.
        let reach = |tree: &Bvh| tree.root_aabb().maxs.abs().max(tree.root_aabb().mins.abs());
        let size = (reach(&tree_a) + reach(&tree_b) + posed.translation.abs()).element_sum();
        let slack = 8.0 * f32::EPSILON * size;
        let posing_ms = ms_since(start);

        if options.cold {
            flush_caches();
        }
        let start = now();
        pairs.clear();
        np = 0;
        let near = |x: &BvhNode, y: &BvhNode| {
            x.aabb().intersects(&y.aabb().transform_by(&posed).loosened(slack))
        };
        for (i, j) in tree_a.leaf_pairs(&tree_b, near) {
            np += 1;
            let (p, q) = (wide(&a[i as usize]), pose.triangle(&b[j as usize]));
            if triangle::intersect(&p, &q) {
                pairs.push((i, j));
            }
        }
        if turn < options.repeat {
            posings.push(posing_ms);
            queries.push(ms_since(start));
        }
    }
    let [pose_ms, query_ms] = [posings, queries].map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });

    let case = folder.file_name().context("the case has no name")?.to_string_lossy();
    let hash = pairs.iter().fold(0_u64, |sum, (i, j)| sum.wrapping_add(hash::pair_term(*i, *j)));
    let line = serde_json::json!({
        "peer": "parry", "case": case,
        "build_ms": build_ms, "pose_ms": pose_ms, "query_ms": query_ms,
        "pairs": pairs.len(), "hash": format!("{hash:016x}"), "nb": 0, "np": np,
    });
    #[expect(clippy::print_stdout, reason = "this line is what the driver is for")]
    {
        println!("{line}");
    }
    Ok(())
}

fn options() -> Result<Options> {
    let mut options = Options { folder: PathBuf::new(), repeat: 9, cold: false, moving: false };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--cold" => options.cold = true,
            "--moving" => options.moving = true,
            "--repeat" => {
                let count = words.next().context("--repeat needs a count")?;
                options.repeat = count.parse().with_context(|| format!("--repeat {count}"))?;
            }
            _ => options.folder = word.into(),
        }
    }
    if options.repeat == 0 {
        bail!("--repeat needs a count of at least 1");
    }
    Ok(options)
}

/// The world poses of A and B.
fn read_poses(path: &Path) -> Result<[Pose; 2]> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let numbers: Vec<f64> =
        text.split_whitespace().map(str::parse).collect::<Result<_, _>>().context("pose.txt")?;
    if numbers.len() != 24 {
        bail!("{}: {} numbers, not 24", path.display(), numbers.len());
    }
    Ok([0, 12].map(|from| Pose {
        rotation: std::array::from_fn(|i| std::array::from_fn(|j| numbers[from + 4 * i + j])),
        translation: std::array::from_fn(|i| numbers[from + 4 * i + 3]),
    }))
}

fn tree(triangles: &[Corners]) -> Bvh {
    let box_of = |corners: &Corners| {
        let [p, q, r] = corners.map(Vector::from_array);
        Aabb::new(p.min(q).min(r), p.max(q).max(r))
    };
    Bvh::from_iter(BvhBuildStrategy::Binned, triangles.iter().map(box_of).enumerate())
}

fn wide(corners: &Corners) -> Triangle {
    Triangle(corners.map(|corner| DVec3::from_array(corner.map(f64::from))))
}

/// Pushes everything else out of the caches, by writing to 64 MiB.
fn flush_caches() {
    let mut large = vec![0_u64; (64 << 20) / size_of::<u64>()];
    large.iter_mut().step_by(8).for_each(|word| *word += 1);
    black_box(&large);
}
