//! Bodies kept from one scenario to the next, though the set of bodies changes.
//!
//! A body is known by where it comes from, its content, its size, and how its tree is built. The
//! least recently used ones give way to new ones.

use super::loaded::BodySource;
use crate::Failure;
use crate::bodies::ModelFile;
use body::{Build, Shells, file};
use std::sync::Arc;

/// What makes two loaded bodies equal.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BodyKey {
    pub(super) source: BodySource,
    pub(super) build: Build,
    pub(super) leaf_size: u32,
}

/// A body that was loaded, and what was computed of it.
#[derive(Clone, Debug)]
pub(super) struct KeptBody {
    pub(super) file: Arc<ModelFile>,
    pub(super) shells: Arc<Shells>,
}

impl KeptBody {
    pub(super) fn of(file: ModelFile) -> Result<Self, Failure> {
        let opened = file::quick_view(file.bytes());
        let (_, view) = opened.map_err(|error| Failure::internal(diagnostic::chain(&error)))?;
        let shells = Arc::new(Shells::of(view.corners));
        Ok(Self { file: Arc::new(file), shells })
    }
}

/// Bodies up to a number of bytes.
#[derive(Debug, Default)]
pub(super) struct BodyCache {
    bytes_max: usize,
    bytes: usize,
    /// The most recently used one last.
    kept: Vec<(BodyKey, KeptBody)>,
}

impl BodyCache {
    /// Of at most so many bytes of model files; 0: it keeps none.
    pub(super) fn of_bytes(bytes_max: usize) -> Self {
        Self { bytes_max, ..Self::default() }
    }

    /// A body that is kept.
    pub(super) fn get(&mut self, key: &BodyKey) -> Option<KeptBody> {
        let number = self.kept.iter().position(|(known, _)| known == key)?;
        self.kept[number..].rotate_left(1);
        self.kept.last().map(|(_, kept)| kept.clone())
    }

    /// Keeps a body, unless it is larger than all that may be kept.
    pub(super) fn insert(&mut self, key: BodyKey, body: &KeptBody) {
        let bytes = body.file.bytes().len();
        if bytes > self.bytes_max {
            return;
        }
        let mut dropped = 0;
        while self.bytes + bytes > self.bytes_max && dropped < self.kept.len() {
            self.bytes -= self.kept[dropped].1.file.bytes().len();
            dropped += 1;
        }
        self.kept.drain(..dropped);
        self.bytes += bytes;
        self.kept.push((key, body.clone()));
    }

    /// Number of bodies, and bytes of their model files.
    pub(super) fn size(&self) -> (usize, usize) {
        (self.kept.len(), self.bytes)
    }
}

#[cfg(test)]
mod tests {
    //! The least recently used bodies give way, and no more is kept than may be.

    use super::*;
    use body::Shape;
    use bvh::BuildOptions;

    fn key(seed: u64) -> BodyKey {
        let source = BodySource::Generated { shape: Shape::Pole, triangles: 600, seed, size: None };
        BodyKey { source, build: Build::Sah, leaf_size: 4 }
    }

    #[test]
    fn the_least_recently_used_gives_way() {
        let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default()).unwrap();
        let pole = KeptBody::of(pole).unwrap();
        let bytes = pole.file.bytes().len();
        let mut cache = BodyCache::of_bytes(2 * bytes + bytes / 2);
        for seed in [0, 1] {
            cache.insert(key(seed), &pole);
        }
        assert!(cache.get(&key(0)).is_some());
        cache.insert(key(2), &pole);
        let there = [0, 1, 2].map(|seed| cache.get(&key(seed)).is_some());
        assert_eq!((there, cache.size()), ([true, false, true], (2, 2 * bytes)));
        assert!(cache.get(&BodyKey { leaf_size: 5, ..key(0) }).is_none());
        let mut none = BodyCache::of_bytes(bytes - 1);
        none.insert(key(0), &pole);
        assert_eq!(none.size(), (0, 0));
    }
}
