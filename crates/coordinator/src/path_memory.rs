//! The memory that workers read paths from.

use executor::motion;
use geometry::motion::MotionPath;
use protocol::launch;
use runtime::WrittenWords;
use smallvec::SmallVec;
use std::collections::BTreeMap;

/// Where a path lies in memory, its length (words), and the sum over its words.
pub(crate) type Place = ([u32; 2], u64);

/// The memory that workers read paths from.
pub(crate) struct PathMemory<'r> {
    memory: &'r WrittenWords,
    /// Words that are taken.
    pub(crate) used: usize,
    /// Paths there: all of them live as long as the search, so their addresses tell them apart.
    places: BTreeMap<*const MotionPath, Place>,
    scratch: Vec<u64>,
}

impl<'r> PathMemory<'r> {
    /// Nothing lies there yet.
    pub(crate) fn over(memory: &'r WrittenWords) -> Self {
        Self { memory, used: 0, places: BTreeMap::new(), scratch: Vec::new() }
    }

    /// Where two paths lie, written unless they are there; `None`: there is no room.
    pub(crate) fn place(&mut self, paths: [&MotionPath; 2]) -> Option<[Place; 2]> {
        let key = |path: &MotionPath| core::ptr::from_ref(path);
        self.scratch.clear();
        let mut fresh: SmallVec<[(*const MotionPath, Place); 2]> = SmallVec::new();
        for path in paths {
            if self.places.contains_key(&key(path)) || fresh.iter().any(|(at, _)| *at == key(path))
            {
                continue;
            }
            let first = self.scratch.len();
            motion::write(path, &mut self.scratch);
            let words = &self.scratch[first..];
            let place = [(self.used + first) as u32, words.len() as u32];
            fresh.push((key(path), (place, motion::sum(words))));
        }
        if self.used + self.scratch.len() > launch::PATHS_WORDS {
            return None;
        }
        self.memory.write(self.used, &self.scratch);
        self.used += self.scratch.len();
        self.places.extend(fresh);
        let [a, b] = paths.map(|path| self.places.get(&key(path)).copied());
        Some([a?, b?])
    }

    /// Forgets what is there: nobody reads it any more.
    pub(crate) fn clear(&mut self) {
        self.used = 0;
        self.places.clear();
    }
}
