//! Generating model files.

use super::{Facts, open};
use crate::{Failure, FailureKind, bodies, files};
use body::{Shape, file};
use bvh::BuildOptions;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

/// Generates a body of a built-in shape, and writes its model file.
///
/// ```
/// # let folder = std::env::temp_dir().join(format!("trolley-generate-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// use trolley::model::{self, Build, Generate, Shape};
///
/// let out = folder.join("suv.trolley");
/// let tree = model::tree(Build::Paper, 4);
/// let suv = Generate { shape: Shape::Suv, triangles: 1500, seed: 0, tree, out };
/// suv.run(&|_, _| {})?;
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct Generate {
    /// The shape.
    pub shape: Shape,
    /// Number of triangles, [`TRIANGLES_MIN`](super::TRIANGLES_MIN) to
    /// [`TRIANGLES_MAX`](super::TRIANGLES_MAX); an odd number gives one less.
    pub triangles: u32,
    /// Seed that varies size and proportions by a few per cent; 0 is the nominal body.
    pub seed: u64,
    /// How its tree is built.
    pub tree: BuildOptions,
    /// The model file to write.
    pub out: PathBuf,
}

/// The result of [`Generate::run`].
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-generated-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// let generated = pole.run(&|_, _| {})?;
/// println!("{}: {}", generated.file, generated.body.sentence);
/// assert_eq!(generated.body.triangles, 600);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct Generated {
    schema: &'static str,
    /// The model file.
    pub file: String,
    /// What is in it.
    pub body: Facts,
}

impl Generate {
    /// Generates the body, and writes the model file. Several threads call `progress`.
    ///
    /// ```
    /// # use trolley::model::{self, Generate, Shape};
    /// # let folder = std::env::temp_dir();
    /// # let folder = folder.join(format!("trolley-generate-run-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let out = folder.join("pole.trolley");
    /// # let tree = model::tree(model::Build::Paper, 4);
    /// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
    /// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
    /// pole.run(&|done, total| eprintln!("{done} of {total} triangles"))?;
    /// assert!(model::open::is_model(&out));
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If `triangles` is out of range for the shape, or the model file cannot be written; an
    /// existing file is then left as it was.
    pub fn run(&self, progress: &(dyn Fn(u64, u64) + Sync)) -> Result<Generated, Failure> {
        files::check(&self.out, None)?;
        let done = AtomicU64::new(0);
        let told = |more: u64| {
            let before = done.fetch_add(more, Ordering::Relaxed);
            progress(before + more, u64::from(self.triangles));
        };
        let body = bodies::generate(self.shape, self.triangles, self.seed, &self.tree, &told)?;
        let bytes = file::encode(&body)
            .map_err(|error| Failure::from(error).of_kind(FailureKind::Internal))?;
        drop(body);
        let bytes = file::Aligned::copy_of(&bytes);
        let (meta, view) = open::view(&self.out, bytes.bytes())?;
        let body = Facts::new(meta, &view, bytes.bytes())?;
        files::replace(&self.out, bytes.bytes())?;
        let file = self.out.display().to_string();
        Ok(Generated { schema: "trolley.model-generate/1", file, body })
    }
}
