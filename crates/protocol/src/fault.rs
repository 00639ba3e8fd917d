//! Fault commands: how faults are injected into a worker from within.
//!
//! The coordinator writes a command into the worker's line of the status page; the worker executes
//! it once, when it starts a job, and only if it was started with [`crate::Launch::obeys`]. All of
//! this is behind the feature `faults`: a build without it can neither send nor read a command.
//!
//! ```text
//! word: sequence (16 bits) | fault (8) | jobs to do before (8) | argument (32)
//! ```

/// The fault to inject.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum InjectedFault {
    /// End with SIGABRT.
    Abort = 1,
    /// End with SIGSEGV.
    Segfault = 2,
    /// Overflow the stack.
    Overflow = 3,
    /// Allocate until no memory is left.
    Exhaust = 4,
    /// Panic in the job, and survive.
    Panic = 5,
    /// Use CPU time without end.
    Hang = 6,
    /// Block without end, using no CPU time.
    Stall = 7,
    /// Flip the bit of this number (modulo the length) in the next result, after sealing.
    Garble = 8,
    /// State a wrong length in the next result, after sealing.
    Lie = 9,
    /// Claim in the next result, correctly sealed, to be another worker.
    Masquerade = 10,
    /// Send the next last part of a result twice.
    Repeat = 11,
    /// Never send the next last part of a result.
    Withhold = 12,
    /// Keep a message loaned, so that none is left.
    HoldLoan = 13,
    /// Abort whenever the job with this number is started.
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

/// A fault command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultCommand {
    /// Distinguishes it from the previous one; not 0.
    pub sequence: u16,
    /// The fault to inject.
    pub fault: InjectedFault,
    /// Number of jobs to complete normally first.
    pub after: u8,
    /// A bit or a job number, if the fault needs one.
    pub argument: u32,
}

impl FaultCommand {
    /// Encodes the command for the status page.
    #[must_use]
    pub fn to_word(self) -> u64 {
        u64::from(self.sequence) << 48
            | u64::from(self.fault as u8) << 40
            | u64::from(self.after) << 32
            | u64::from(self.argument)
    }

    /// Decodes the word; `None` if it is not a command.
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
    //! A word decodes to what was encoded.
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
