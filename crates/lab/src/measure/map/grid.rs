//! The axes of the map, and the sheets that it consists of.

use super::machine::{GROUPS, PAPER_BYTE_NS};
use super::table::{SheetKey, Subject};

/// The axes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grid {
    /// Triangles of each body.
    pub(crate) sizes: Vec<u32>,
    /// Contacts that real workers run and that are not simulated: simulations of so many jobs take
    /// longer than all others together.
    pub(crate) larger: Vec<Subject>,
    /// Memory per core (percent of both bodies).
    pub(crate) memories: Vec<u32>,
    /// Cost of a byte (ns).
    pub(crate) bytes: Vec<f64>,
    pub(crate) depths: Vec<u32>,
    pub(crate) cores: Vec<u8>,
    /// Up to which size bodies are crossed with each of these numbers of cores: an hour of many
    /// cores and many jobs would say little more.
    pub(crate) size_max: Vec<u32>,
    /// Buffers with all schemes.
    pub(crate) buffers: Vec<u32>,
    /// Buffers with Best Match-Load alone: what the claim about buffers needs besides.
    pub(crate) more_buffers: Vec<u32>,
    /// Seeds of random match.
    pub(crate) seeds: u64,
}

/// Cores of the paper's machine.
pub(crate) const CORES: u8 = 4;
/// The buffer of all sheets that are not about buffers.
pub(crate) const BUFFER: u32 = 16;

impl Grid {
    pub(crate) fn full() -> Self {
        Self {
            sizes: vec![10_000, 100_000],
            larger: vec![Subject { size: 1_000_000, is_deep: true }],
            memories: vec![5, 20, 40, 60, 100, 200],
            bytes: vec![0.0, 0.3, PAPER_BYTE_NS, 3.0, 10.0],
            depths: vec![0, 1, 2, 4, 6, 8, 10, 12, 16],
            cores: vec![2, CORES, 16],
            size_max: vec![u32::MAX, u32::MAX, 10_000],
            buffers: vec![4, 16, 64],
            more_buffers: vec![1, 256],
            seeds: 16,
        }
    }

    /// Seconds instead of minutes: small bodies, and few values of each axis; still sixteen seeds.
    pub(crate) fn quick() -> Self {
        Self {
            sizes: vec![500, 1_000, 2_000],
            larger: Vec::new(),
            memories: vec![20, 60],
            bytes: vec![0.0, PAPER_BYTE_NS],
            depths: vec![0, 2, 4],
            cores: vec![2, CORES],
            size_max: vec![1_000, u32::MAX],
            buffers: vec![BUFFER],
            more_buffers: vec![1, 64],
            seeds: 16,
        }
    }

    /// All subjects: sizes and contacts.
    pub(crate) fn subjects(&self) -> Vec<Subject> {
        let pair = |size: &u32| [true, false].map(|is_deep| Subject { size: *size, is_deep });
        self.sizes.iter().flat_map(pair).collect()
    }

    /// The buffers, in order.
    pub(crate) fn all_buffers(&self) -> Vec<u32> {
        let mut all = [&self.buffers[..], &self.more_buffers[..]].concat();
        all.sort_unstable();
        all
    }

    /// Whether a sheet is about Best Match-Load alone.
    pub(crate) fn is_light(&self, key: &SheetKey) -> bool {
        !self.buffers.contains(&key.buffer)
    }

    /// The numbers of cores with which a subject is crossed.
    fn cores_of(&self, subject: Subject) -> impl Iterator<Item = u8> {
        let all = self.cores.iter().zip(&self.size_max);
        all.filter(move |(_, most)| subject.size <= **most).map(|(cores, _)| *cores)
    }

    /// The sheets: every number of cores with every buffer, on every machine; on the paper's also
    /// with each contact a request of its own.
    pub(crate) fn sheets(&self, subject: Subject) -> Vec<SheetKey> {
        let mut sheets = Vec::new();
        for (machine, is_single) in GROUPS {
            for cores in self.cores_of(subject) {
                let key = |buffer| SheetKey { machine, subject, is_single, cores, buffer };
                sheets.extend(self.all_buffers().into_iter().map(key));
            }
        }
        sheets
    }

    /// What a sheet of these axes was made from, apart from traces and costs.
    pub(crate) fn made_from(&self) -> String {
        let Self { memories, bytes, depths, seeds, .. } = self;
        format!("memories {memories:?} bytes {bytes:?} depths {depths:?} seeds {seeds}")
    }
}
