//! Looks at bodies on their ways, whose paths lie in memory that the coordinator writes.

use crate::answer::Answer;
use body::BodyView;
use bvh::{Counters, Sink as _};
use executor::encounter::{Encounters, Look, Unseen, Ways};
use executor::{NotDone, motion};
use geometry::motion::MotionPath;
use protocol::WireLook;
use protocol::result::WireSeen;
use runtime::ReadWords;

/// Paths that are kept from look to look: candidates share those of others.
const KEPT: usize = 64;

/// Looks at bodies.
pub(crate) struct Looker {
    encounters: Encounters,
    paths: ReadWords,
    /// Paths of the last looks by place and sum of their words, the latest last.
    kept: Vec<(([u32; 2], u64), MotionPath)>,
    words: Vec<u64>,
}

impl Looker {
    pub(crate) fn new(paths: ReadWords) -> Self {
        Self { encounters: Encounters::default(), paths, kept: Vec::new(), words: Vec::new() }
    }

    /// What a look shows, and the tests that it took.
    pub(crate) fn look<'b>(
        &mut self,
        wire: &WireLook,
        body: impl Fn(u32) -> Option<BodyView<'b>>,
        answer: &mut Answer<'_>,
    ) -> Result<(WireSeen, Counters), NotDone> {
        let bodies = [wire.model_a, wire.model_b].map(body);
        let [Some(a), Some(b)] = bodies else { return Err(NotDone::Unknown) };
        let keys = [0, 1].map(|side: usize| (wire.paths[side], wire.sums[side]));
        for key in keys {
            self.ensure(key, keys)?;
        }
        let path = |key| self.kept.iter().find(|(of, _)| *of == key).map(|(_, path)| path);
        let [Some(of_a), Some(of_b)] = keys.map(path) else { return Err(NotDone::Unknown) };
        let look = Look {
            ways: Ways { bodies: [a, b], paths: [of_a, of_b] },
            from_s: wire.from_s,
            end_s: wire.end_s,
            resolution_m: wire.resolution_m,
            may_touch: wire.may_touch == 1,
        };
        let mut tests = 0;
        let mut watch = |since: u64| {
            tests += since;
            answer.beat(tests)
        };
        match self.encounters.look(&look, &mut watch) {
            Ok((seen, counters)) => Ok((seen.to_wire(), counters)),
            Err(Unseen::Stopped) => Err(NotDone::Stopped),
            Err(Unseen::NoMotion) => Err(NotDone::Unknown),
        }
    }

    /// Reads a path unless it is kept; `keys` are those that are needed.
    fn ensure(&mut self, key: ([u32; 2], u64), keys: [([u32; 2], u64); 2]) -> Result<(), NotDone> {
        if self.kept.iter().any(|(of, _)| *of == key) {
            return Ok(());
        }
        let ([first, count], sum) = key;
        self.words.clear();
        let is_there = self.paths.read(first as usize, count as usize, &mut self.words);
        // Memory may be written again while a look is done whose request is over.
        if !is_there || motion::sum(&self.words) != sum {
            return Err(NotDone::Unknown);
        }
        let path = motion::read(&self.words).ok_or(NotDone::Unknown)?;
        if self.kept.len() >= KEPT {
            let oldest = self.kept.iter().position(|(of, _)| !keys.contains(of));
            oldest.map(|at| self.kept.remove(at));
        }
        self.kept.push((key, path));
        Ok(())
    }
}
