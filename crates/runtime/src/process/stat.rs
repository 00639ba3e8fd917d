//! What the kernel reports of a process: its state and the CPU time it has used.

use crate::clock;
use std::fs;

/// A snapshot of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProcStat {
    /// R running or runnable, S sleeping, D in the kernel, T stopped, Z dead but not reaped, ...
    pub state: char,
    /// CPU time of all its threads \[ns\].
    pub cpu_ns: u64,
}

/// Looks at a process; `None` if there is none.
///
/// The number of a process that was not reaped yet cannot be anybody else's, so ask this about
/// children before they are reaped.
#[must_use]
pub fn stat(pid: u32) -> Option<ProcStat> {
    let text = fs::read(format!("/proc/{pid}/stat")).ok()?;
    Some(ProcStat { state: parse_state(&text)?, cpu_ns: clock::cpu_ns_of(pid).unwrap_or(0) })
}

/// The state is behind the program's name, which may itself hold brackets and spaces.
fn parse_state(text: &[u8]) -> Option<char> {
    let close = text.iter().rposition(|byte| *byte == b')')?;
    match text.get(close + 1..close + 3)? {
        [b' ', state] => Some(char::from(*state)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::parse_state;

    #[test]
    fn a_name_full_of_brackets_does_not_hide_the_state() {
        assert_eq!(parse_state(b"7 (a) R (b)) T 1 7 7 0 -1"), Some('T'));
        assert_eq!(parse_state(b"7 (sh) S 1"), Some('S'));
        assert_eq!(parse_state(b"7 (sh)"), None);
        assert_eq!(parse_state(b""), None);
    }
}
