//! Flipped bits in the requests and answers of a service, while they are on their way.

use super::kind::Kind;
use super::report::{Report, State};
use super::serving::{REPEAT_MS, Serving, files_below};
use coordinator::Answer;
use geometry::rng::Rng;
use protocol::public::{VERSION, WireAnswer};
use runtime::clock;
use std::fs::OpenOptions;
use std::os::unix::fs::FileExt as _;
use std::path::Path;
use trolley::Failure;

/// Requests of the client whose messages are struck.
const REQUESTS: u32 = 100;
/// Pause between two strikes (ns): some requests pass unharmed.
const PAUSE_NS: u64 = 2_000_000;
/// Flips bits in what a service and its client send to each other. The client is told nothing
/// wrong: a request or an answer that was changed is a refusal. The next service answers, and
/// leaves nothing.
pub(super) fn flip(
    serving: &mut Serving,
    mut rng: Rng,
    reference: &Answer,
    report: &mut Report,
) -> Result<(), Failure> {
    if !serving.starts(reference, report)? {
        return Ok(());
    }
    // What is lost costs the client its deadline: with this one it ends in time, whatever comes.
    let mut asking = serving.ask_again_and_again(REQUESTS, REPEAT_MS)?;
    let struck_ns = clock::now_ns();
    let is_message = |path: &std::path::PathBuf| path.extension().is_some_and(|end| end == "data");
    // Its requests end it, or `document` does.
    let end_ns = struck_ns + 60_000_000_000;
    while asking.wait_ms(0)?.is_none() && clock::now_ns() < end_ns {
        for path in files_below(&serving.folder()).iter().filter(|path| is_message(path)) {
            flip_message(path, &mut rng);
        }
        clock::nap_ns(PAUSE_NS);
    }
    let (exit, document) = asking.document()?;
    report.hangs += u64::from(exit.is_none());
    report.requests += u64::from(REQUESTS);
    let mut worst = match document {
        Some(document) if document["wrong"] != 0 => State::Wrong,
        Some(document) if document["answers"][0] == REQUESTS => State::Complete,
        // It ended with a code before there was anything to print.
        _ => State::Refused,
    };
    report.count(worst);
    let seen_ns = serving.ended()?.map(|_| clock::now_ns() - struck_ns);
    if !serving.starts_again(reference, report)? {
        report.count(State::Wrong);
        worst = State::Wrong;
    }
    report.add(Kind::FlipPublic, worst, seen_ns, clock::now_ns() - struck_ns);
    Ok(())
}

/// Flips a bit of one of the messages in a file: of a request, or of an answer, whose first word is
/// the version of its layout. What else is in the file belongs to iceoryx2: see `flip-management`.
fn flip_message(path: &Path, rng: &mut Rng) {
    let Ok(file) = OpenOptions::new().read(true).write(true).open(path) else { return };
    let Ok(bytes) = std::fs::read(path) else { return };
    let version = VERSION.to_le_bytes();
    // Then flags or a verdict, and a number that is hardly 0.
    let is_message = |at: &usize| {
        let head = &bytes[*at..*at + 16];
        head[..4] == version && head[4] <= 5 && head[5..8] == [0; 3] && head[8..16] != [0; 8]
    };
    let heads = (0..bytes.len().saturating_sub(size_of::<WireAnswer>())).step_by(8);
    let heads: Vec<usize> = heads.filter(is_message).collect();
    let Some(head) = heads.get(rng.below(heads.len().max(1) as u64) as usize) else { return };
    let at = (head + rng.below(size_of::<WireAnswer>() as u64) as usize) as u64;
    let mut byte = [0];
    if file.read_at(&mut byte, at).is_ok_and(|read| read == 1) {
        byte[0] ^= 1 << rng.below(8);
        let _gone = file.write_at(&byte, at);
    }
}
