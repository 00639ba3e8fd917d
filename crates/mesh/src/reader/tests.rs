//! However a child ends, its end is a sentence that names the file and a remedy.

use super::*;

fn request() -> ReadRequest {
    ReadRequest {
        file: "car.obj".to_owned(),
        as_it_stands: false,
        unit_m: None,
        up: None,
        forward: None,
        only: Vec::new(),
        kind: None,
        name: None,
        tree: None,
        threads: 1,
        heap_bytes: 0,
        memory_bytes: 2048 * MB,
        cpu_s: 120,
    }
}

#[test]
fn every_end_names_the_file_what_happened_and_a_remedy() {
    let ends = [
        (
            Some(Exit::Signal(24)),
            "",
            "stopped after 120 s of CPU time",
            diagnostic::FailureKind::Input,
        ),
        (Some(Exit::Signal(11)), "", "crashed (SIGSEGV)", diagnostic::FailureKind::Input),
        (Some(Exit::Signal(9)), "", "crashed (SIGKILL)", diagnostic::FailureKind::Input),
        (
            Some(Exit::Signal(6)),
            "memory allocation of 9 bytes failed",
            "more than 2048 MB of memory",
            diagnostic::FailureKind::Input,
        ),
        (
            Some(Exit::Signal(6)),
            "thread 'main' has overflowed its stack",
            "ran out of stack",
            diagnostic::FailureKind::Input,
        ),
        (Some(Exit::Code(101)), "oh", "gave up (exit code 101) oh", diagnostic::FailureKind::Input),
        (
            Some(Exit::Code(71)),
            "error: cannot limit 'address space'",
            "cannot limit 'address space'",
            diagnostic::FailureKind::System,
        ),
        (None, "", "did not end", diagnostic::FailureKind::Input),
    ];
    for (exit, last_words, says, code) in ends {
        let failure = request().ended(exit, last_words);
        assert!(failure.what().starts_with("car.obj: "), "{failure}");
        assert!(failure.what().contains(says) && failure.remedy().is_some(), "{failure}");
        assert_eq!(failure.kind(), code, "{failure}");
    }
}

/// What `hear` makes of bytes that a child wrote before it ended.
fn heard(bytes: &[u8]) -> Option<(ChildMessage, file::Aligned)> {
    let (words, mut says) = io::pipe().expect("a pipe");
    io::Write::write_all(&mut says, bytes).expect("room");
    drop(says);
    hear(words, 2048, &|_, _| {})
}

#[test]
fn a_child_that_ends_in_mid_sentence_has_said_nothing() {
    let refused = br#"{"Refused":{"what":"car.obj: bent","remedy":null}}"#;
    assert!(matches!(heard(refused), Some((ChildMessage::Refused { .. }, _))));
    for cut in [0, 1, 20, refused.len() - 1] {
        assert!(heard(&refused[..cut]).is_none());
    }
    let report = Report {
        format: "OBJ".to_owned(),
        unit_m: 1.0,
        stated: None,
        up: "+z".to_owned(),
        forward: "+x".to_owned(),
        triangles_in_file: 1,
        triangles_selected: 1,
        triangles: 1,
        duplicates_dropped: 0,
        degenerate_kept: 0,
        shells: 1,
        open_edges: 3,
        size_m: [1.0; 3],
        sentence: String::new(),
        doubts: Vec::new(),
        notes: Vec::new(),
        side_file: None,
    };
    let mut word = ChildMessage::Read { report: Box::new(report), build_ns: 5, model_bytes: 4 };
    let mut bytes = serde_json::to_vec(&word).expect("plain data");
    bytes.extend(b"\nabcd");
    let (_, model) = heard(&bytes).expect("whole");
    assert_eq!(model.bytes(), b"abcd");
    assert!(heard(&bytes[..bytes.len() - 1]).is_none());
    // More than a child may have is not even asked for.
    if let ChildMessage::Read { model_bytes, .. } = &mut word {
        *model_bytes = u64::MAX;
    }
    let mut bytes = serde_json::to_vec(&word).expect("plain data");
    bytes.extend(b"\nabcd");
    assert!(heard(&bytes).is_none());
}
