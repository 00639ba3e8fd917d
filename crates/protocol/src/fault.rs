//! Orders to misbehave: how faults are injected into a worker from within.
//!
//! The coordinator writes an command into the worker's line of the status page; the worker obeys it
//! once, when it starts a job, and only if it was started with [`crate::Launch::obeys`]. All of it
//! is behind the feature `faults`: a build without it can neither give nor read an command.
//!
//! ```text
//! word: sequence (16 bits) | fault (8) | jobs to do before (8) | argument (32)
//! ```

/// What a worker is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum InjectedFault {
    /// End with SIGABRT.
    Abort = 1,
    /// End with SIGSEGV.
    Segfault = 2,
    /// Overflow the stack.
    Overflow = 3,
    /// Allocate until there is no memory left for it.
    Exhaust = 4,
    /// Panic in the job, and live.
    Panic = 5,
    /// Burn CPU time for ever.
    Hang = 6,
    /// Stand still for ever, without CPU time.
    Stall = 7,
    /// Flip the bit of this number (modulo its length) in the next result, after it was sealed.
    Garble = 8,
    /// State a wrong length in the next result, after it was sealed.
    Lie = 9,
    /// Say in the next result, soundly sealed, to be another worker.
    Masquerade = 10,
    /// Send the next last part of a result twice.
    Repeat = 11,
    /// Never send the next last part of a result.
    Withhold = 12,
    /// Keep a message open, so that there is none left.
    HoldLoan = 13,
    /// Abort whenever the job of this number is started.
    Poison = 14,
    /// End with exit code 1.
    Quit = 15,
}

impl InjectedFault {
    /// All of them.
    pub const ALL: [Self; 15] = [
        Self::Abort,
        Self::Segfault,
        Self::Overflow,
        Self::Exhaust,
        Self::Panic,
        Self::Hang,
        Self::Stall,
        Self::Garble,
        Self::Lie,
        Self::Masquerade,
        Self::Repeat,
        Self::Withhold,
        Self::HoldLoan,
        Self::Poison,
        Self::Quit,
    ];
}

/// An command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultCommand {
    /// Tells it from the one before it; not 0.
    pub sequence: u16,
    /// What to do.
    pub fault: InjectedFault,
    /// How many jobs to do properly before.
    pub after: u8,
    /// A bit or a job, where the fault needs one.
    pub argument: u32,
}

impl FaultCommand {
    /// As it stands on the status page.
    #[must_use]
    pub fn to_word(self) -> u64 {
        u64::from(self.sequence) << 48
            | u64::from(self.fault as u8) << 40
            | u64::from(self.after) << 32
            | u64::from(self.argument)
    }

    /// Reads the word; `None` if it is no command.
    #[must_use]
    pub fn from_word(word: u64) -> Option<Self> {
        let number = (word >> 40 & 0xff) as u8;
        let fault = InjectedFault::ALL.into_iter().find(|fault| *fault as u8 == number)?;
        Some(Self {
            sequence: (word >> 48) as u16,
            fault,
            after: (word >> 32 & 0xff) as u8,
            argument: (word & 0xffff_ffff) as u32,
        })
    }
}

#[cfg(test)]
mod tests {
    //! The word is read as it was written.
    use super::*;

    #[test]
    fn every_order_comes_back_and_zero_is_none() {
        for fault in InjectedFault::ALL {
            let command =
                FaultCommand { sequence: 0xfeed, fault, after: 200, argument: 0xdead_beef };
            assert_eq!(FaultCommand::from_word(command.to_word()), Some(command));
        }
        assert_eq!(FaultCommand::from_word(0), None);
        assert_eq!(FaultCommand::from_word(u64::MAX), None);
    }
}
