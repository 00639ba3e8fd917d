//! Invariants of names and levels, whatever the processor.

use super::*;

#[test]
fn every_name_is_read_back() {
    for simd in Simd::ALL {
        assert_eq!(simd.to_string().parse(), Ok(simd));
    }
    let unknown = "AVX2".parse::<Simd>().unwrap_err().to_string();
    assert_eq!(unknown, "\"AVX2\" is none of auto, avx512, avx2, sse4, sse2, neon");
}

#[test]
fn a_level_is_what_was_asked_for_or_an_error_that_says_what_there_is() {
    let widest = name(Simd::Auto.level().unwrap());
    for simd in &Simd::ALL[1..] {
        match simd.level() {
            Ok(level) => assert_eq!(name(level), simd.name()),
            Err(error) => {
                let text = error.to_string();
                for part in [simd.name(), widest, "--simd auto"] {
                    assert!(text.contains(part), "{text} lacks {part}");
                }
            }
        }
    }
    let names: Vec<_> = levels().map(name).collect();
    assert_eq!(names[0], widest);
    assert!(names.iter().enumerate().all(|(i, n)| !names[..i].contains(n)), "{names:?}");
}
