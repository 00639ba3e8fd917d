//! The machines of the map, each with its costs.

use scenario::Scheme;
use serde::Serialize;
use simulate::Costs;

/// A machine that is named in every table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Machine {
    /// The paper's: a quad-core of the Pentium N3540 class. Sections are copied into a memory per
    /// core, and tests are made one at a time. All its costs are constants, so what is said of it
    /// is the same wherever it is computed.
    Paper,
    /// This machine, made to copy: its kernel and messages, with the cost of a byte as a setting.
    Copying,
    /// Ours: this machine with one sealed store, of which nothing is copied.
    Sealed,
}

impl Machine {
    pub(crate) const ALL: [Self; 3] = [Self::Paper, Self::Copying, Self::Sealed];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Copying => "copying",
            Self::Sealed => "sealed",
        }
    }

    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Paper => "the paper's machine",
            Self::Copying => "this machine, copying",
            Self::Sealed => "ours (one sealed store)",
        }
    }

    /// Whether sections are copied, so that memory and the cost of a byte matter.
    pub(crate) fn copies(self) -> bool {
        self != Self::Sealed
    }
}

/// The machines as claims are judged on them: the paper runs one contact at a time.
pub(crate) const GROUPS: [(Machine, bool); 4] = [
    (Machine::Paper, true),
    (Machine::Paper, false),
    (Machine::Copying, false),
    (Machine::Sealed, false),
];

/// Cost of a byte on the paper's machine (ns): half of it the main process's, half the core's.
pub(crate) const PAPER_BYTE_NS: f64 = 0.9;
/// Cost of a byte that moves between memory and virtual memory (ns).
pub(crate) const SWAP_BYTE_NS: f64 = 25.0;

/// The costs of the paper's machine without those of bytes: [`FIGURES`] has their sources.
pub(crate) const PAPER: Costs = Costs {
    job_ns: 1_000.0,
    box_ns: 40.0,
    triangle_ns: 200.0,
    hit_ns: 100.0,
    leaves_ns: 0.0,
    send_ns: 2_000.0,
    section_byte_ns: 0.0,
    section_ns: 1_000.0,
    ship_byte_ns: 0.0,
    ship_section_ns: 1_000.0,
    task_ns: 2_000.0,
    descent_ns: 40.0,
    batch_ns: 1_000.0,
    place_ns: 500.0,
    take_ns: 1_000.0,
    fold_hit_ns: 20.0,
    flight_ns: 1_000.0,
};

/// Costs with this cost per byte, shared by both ends of a copy.
pub(crate) fn with_byte(costs: &Costs, byte_ns: f64) -> Costs {
    Costs { section_byte_ns: byte_ns / 2.0, ship_byte_ns: byte_ns / 2.0, ..*costs }
}

/// A figure of the paper's machine, its value and where it comes from.
pub(crate) const FIGURES: [[&str; 3]; 8] = [
    [
        "cores, clock",
        "4 at 2.16 to 2.66 GHz; the main process shares one of them",
        "Intel Pentium N3540 (Bay Trail-M, Silvermont): notebookcheck.net, \"Intel Pentium N3540\"",
    ],
    [
        "memory of the computer",
        "2 × 64 bit DDR3L-1333: 21.3 GB/s at most; L2 2 × 1 MB",
        "notebookinfo.de, \"Intel Pentium N3540\"; bm.hardlimit.com, \"Pentium N3540\"",
    ],
    [
        "Cb, Cp: a test of two boxes, of two triangles",
        "40 ns, 200 ns; 1 µs per job, 0.1 µs per hit",
        "the plain walk, one test at a time, as measured on a server core of 2025 (below), times \
         4: bm.hardlimit.com has one core of an N3540 at 0.62 (integers) and 0.22 (floating \
         point) of a Skylake core of 2.3 GHz",
    ],
    [
        "a byte copied",
        "0.9 ns, half at either end",
        "two copies of 3 bytes on the bus for each byte (read, read for ownership, write back) at \
         21.3 GB/s: 0.28 ns; one core reaches 0.32 of that (its memory figure over a Skylake \
         core's: bm.hardlimit.com)",
    ],
    [
        "a message",
        "batch 1 µs, job in it 0.5 µs, result sent 2 µs, taken 1 µs, on its way 1 µs; section 1 µs \
         at either end",
        "iceoryx2 as calibrated on servers (0.5, 0.3, 2 to 4, 0.4, 0.3 µs), about doubled where it \
         is integer work (0.62)",
    ],
    [
        "memory per core, M",
        "5 to 200 % of both bodies",
        "a setting of the map: the paper does not state it",
    ],
    [
        "a byte beyond M",
        "25 ns",
        "assumed: pages of 4 KiB at 100 µs each, a solid-state disk asked for one at a time",
    ],
    [
        "distribution depths, schemes",
        "0 to 16; Best, Random, Lowest Match and Best Match-Load (α = 0.5)",
        "the paper's, on our trees",
    ],
];

/// The schemes of the paper.
pub(crate) const SCHEMES: [Scheme; 4] =
    [Scheme::BestMatchLoad, Scheme::BestMatch, Scheme::RandomMatch, Scheme::LowestMatch];
