//! A model file of a generated body.

use super::{Facts, open};
use crate::{Failure, FailureKind, bodies, files};
use body::{Shape, file};
use bvh::BuildOptions;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

/// Makes a model file of a shape that the program generates itself.
#[derive(Clone, Debug)]
pub struct Generate {
    /// What to generate.
    pub shape: Shape,
    /// How finely, [`TRIANGLES_MIN`](super::TRIANGLES_MIN) to
    /// [`TRIANGLES_MAX`](super::TRIANGLES_MAX); an odd number gives one triangle less.
    pub triangles: u32,
    /// Varies size and proportions by a few per cent; 0 is the nominal body.
    pub seed: u64,
    /// The tree that it gets.
    pub tree: BuildOptions,
    /// The model file to write.
    pub out: PathBuf,
}

/// A model file of a generated body.
#[derive(Clone, Debug, Serialize)]
pub struct Generated {
    schema: &'static str,
    /// The model file.
    pub file: String,
    /// What is in it.
    pub body: Facts,
}

impl Generate {
    /// Generates the body, and writes the model file. Several threads tell `progress`.
    ///
    /// # Errors
    ///
    /// If a body of this shape cannot have so many triangles, or the model file cannot be written;
    /// what was in its place is still there.
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
