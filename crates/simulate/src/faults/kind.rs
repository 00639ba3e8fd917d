//! What can go wrong, by name.

use core::fmt;

macro_rules! faults {
    ($($(#[doc = $doc:literal])* $name:ident = $text:literal;)*) => {
        /// A kind of fault.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum SimulatedFault {
            $($(#[doc = $doc])* $name,)*
        }

        impl SimulatedFault {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// Its name on the command line.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }
        }
    };
}

faults! {
    /// A worker dies in a job.
    Crash = "crash";
    /// A worker dies between two jobs.
    CrashIdle = "crash-idle";
    /// A worker burns CPU time forever.
    Hang = "hang";
    /// A worker is stopped and never continued.
    Stop = "stop";
    /// A worker gets a tenth of its core.
    Slow = "slow";
    /// A worker waits long for its core, but is healthy.
    Starve = "starve";
    /// A job crashes every worker that starts it.
    Poison = "poison";
    /// A job fails, and its worker lives.
    Nack = "nack";
    /// A successor dies before it greets.
    ExitedAtStart = "still-born";
    /// A batch never arrives.
    LoseBatch = "lose-batch";
    /// A result never arrives.
    LoseResult = "lose-result";
    /// A batch arrives twice.
    RepeatBatch = "repeat-batch";
    /// A result arrives twice.
    RepeatResult = "repeat-result";
    /// A batch arrives late, behind others.
    DelayBatch = "delay-batch";
    /// A result arrives late, behind others.
    DelayResult = "delay-result";
    /// A result arrives after its sender's death, or in another request.
    Zombie = "zombie";
    /// A batch is corrupted in transit.
    GarbleBatch = "garble-batch";
    /// A result is corrupted in transit.
    GarbleResult = "garble-result";
    /// A queue refuses a batch.
    Full = "full";
    /// The deadline comes early.
    Deadline = "deadline";
}

impl SimulatedFault {
    /// The fault of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|fault| fault.name() == name)
    }
}

impl fmt::Display for SimulatedFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A set of kinds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults(u32);

impl Faults {
    /// None.
    pub const NONE: Self = Self(0);
    /// All.
    pub const ALL: Self = Self((1 << SimulatedFault::ALL.len()) - 1);

    /// The set with one kind added.
    #[must_use]
    pub fn with(self, fault: SimulatedFault) -> Self {
        Self(self.0 | 1 << fault as u32)
    }

    /// The set with one kind removed.
    #[must_use]
    pub fn without(self, fault: SimulatedFault) -> Self {
        Self(self.0 & !(1 << fault as u32))
    }

    /// Whether it holds this one.
    #[must_use]
    pub fn has(self, fault: SimulatedFault) -> bool {
        self.0 >> fault as u32 & 1 == 1
    }

    /// Its members.
    pub fn iter(self) -> impl Iterator<Item = SimulatedFault> {
        SimulatedFault::ALL.iter().copied().filter(move |fault| self.has(*fault))
    }
}
