//! Real children: what they inherit, how they end, and that none is left.

use super::*;

const SHELL: &str = "/bin/sh";

fn shell(script: &str, fds: &[(BorrowedFd<'_>, RawFd)]) -> Child {
    let args = ["-c".to_owned(), script.to_owned()];
    spawn(Spawn { program: Path::new(SHELL), args: &args, fds, core: None }).unwrap()
}

#[test]
fn a_child_says_how_it_ended() {
    let mut child = shell("exit 7", &[]);
    assert_eq!(child.wait_ms(5_000).unwrap(), Some(Exit::Code(7)));
    assert_eq!(child.try_wait().unwrap(), Some(Exit::Code(7)), "and says it again");
    child.kill().unwrap();

    let mut child = shell("kill -SEGV $$", &[]);
    let exit = child.wait_ms(5_000).unwrap().unwrap();
    assert_eq!(exit, Exit::Signal(libc::SIGSEGV));
    assert_eq!(exit.to_string(), "SIGSEGV");
}
