//! Tests of the checks: they detect what they should, and nothing else.

use super::*;
use crate::code::outside_tests;
use crate::pure::impurities;

#[test]
fn comments_and_literals_are_not_code() {
    let text = r####"
        unsafe_code /* unsafe /* unsafe */ unsafe */ a1 // unsafe
        "unsafe \" unsafe" b2 'u' '\'' '"' c3 b"unsafe" r#"unsafe " unsafe"# br"\" d4
        fn f<'a>(x: &'a str) e5 "two
        lines" f6 for r in r#type g7
    "####;
    let code = code(text);
    assert_eq!(code.lines().count(), text.lines().count());
    assert!(!words(&code).any(|word| word == "unsafe"), "{code}");
    for kept in ["unsafe_code", "a1", "b2", "c3", "d4", "e5", "f6", "g7"] {
        let line = |text: &str| text.lines().position(|line| line.contains(kept));
        assert!(line(&code).is_some() && line(&code) == line(text), "{kept}: {code}");
    }
    assert!(words("x; unsafe { y }").any(|word| word == "unsafe"));
    assert!(calls("x(dbg!(y))", "dbg") && !calls("my_dbg!(y); dbg(y)", "dbg"));
}

#[test]
fn what_is_there_for_tests_is_left_out() {
    let text = "a\n#[cfg(test)]\nmod tests;\nb\n#[cfg(test)]\nfn c() {\n{ c }\n}\nd\n";
    let (left, modules) = outside_tests(text);
    assert_eq!(left.split_whitespace().collect::<String>(), "a;bd");
    assert_eq!(left.lines().position(|line| line == "d"), text.lines().position(|l| l == "d"));
    assert_eq!(modules, ["tests"]);
}

#[test]
fn impurities_are_seen_however_they_are_imported() {
    let seen = |code: &str, package: &str| -> Vec<String> {
        impurities(code, package).into_iter().map(|(line, what)| format!("{line} {what}")).collect()
    };
    assert_eq!(seen("\nuse std::fs::File;", "model"), ["1 std::fs"]);
    assert_eq!(seen("let x = std::net::f();", "model"), ["0 std::net"]);
    assert_eq!(seen("std::process::ExitCode::from(1)", "model"), [""; 0]);
    assert_eq!(seen("use std::process::{ExitCode, exit};", "model"), ["0 std::process"]);
    assert_eq!(seen("use std::{\n  fmt,\n  process,\n};", "model"), ["2 std::process"]);
    assert_eq!(seen("use std::{io::{self, fs}, env};", "model"), ["0 std::env"]);
    assert_eq!(seen("a(Instant)\nSystemTime", "model"), ["0 Instant", "1 SystemTime"]);
    assert_eq!(seen("std::thread::scope(f)", "model"), ["0 std::thread"]);
    assert_eq!(seen("std::thread::scope(f)", "bvh"), [""; 0]);
    assert_eq!(seen("thread::sleep(f)", "bvh"), ["0 thread::sleep"]);
    assert_eq!(seen("use std::{fmt::{self, Debug}, io};\nnet::x(); Instantly", "model"), [""; 0]);
}

#[test]
fn circles_of_files_are_seen_however_they_are_named() {
    let circles_of = |modules: &[(&str, &str)]| {
        let modules = modules.iter().map(|(name, code)| ((*name).to_owned(), (*code).to_owned()));
        circles::circles(circles::names_in(&modules.collect())).into_iter().collect::<Vec<_>>()
    };
    let root = ("", "mod a; mod b; mod my;");
    let [a, b] = [("a", "use crate::{my, b::{X, Y}};"), ("b", "use crate::my::Z; mod c;")];
    let my = ("my", "fn crates() { mod_b; super_a::f() }");
    assert_eq!(circles_of(&[root, a, b, my, ("b::c", "use crate::my;")]), [""; 0]);
    assert_eq!(circles_of(&[root, a, b, my, ("b::c", "use super::X;")]), ["b", "b::c"]);
    assert_eq!(circles_of(&[root, a, b, my, ("b::c", "super::super::a::f()")]), ["a", "b", "b::c"]);
    assert_eq!(circles_of(&[root, a, b, ("my", "(crate::a::F)")]), ["a", "b", "my"]);
    assert_eq!(circles_of(&[root, a, b, ("my", "(crate::MAIN)")]), ["", "a", "b", "my"]);
}

#[test]
fn what_stands_behind_the_features_of_faults_is_left_out() {
    let text = "
a
#[cfg(feature = \"faults\")]
mod flaw;
#[cfg(any(test, feature = \"faults\"))]
pub use flaw::{Flaw, spoil};
#[cfg(not(feature = \"faults\"))]
b(c);
struct D {
    e: F,
    #[cfg(feature = \"faults\")]
    flaw: Option<Flaw>,
}
fn g() {
    #[cfg(feature = \"lab\")]
    if let Some(flaw) = h(i, j) {
        flaw.spoil();
    }
    k(
        l,
        #[cfg(feature = \"lab\")]
        flaw
    );
    #[cfg(feature = \"faults\")]
    fn n(flaw: &[u8], spoil: u8) -> Result<(), Flaw> {
        flaw?;
    }
    #[cfg(feature = \"faults\")]
    send(|flaw, used| { flaw; used }, \"{\")?;
    m
}
";
    let (left, modules) = crate::faults::outside_marks(text);
    assert_eq!(left.lines().count(), text.lines().count());
    assert!(!left.contains("flaw") && !left.contains("spoil"), "{left}");
    for kept in ["a", "b(c);", "e: F,", "l,", ");", "m"] {
        let line = |text: &str| text.lines().position(|line| line.trim() == kept);
        assert!(line(&left).is_some() && line(&left) == line(text), "{kept}: {left}");
    }
    assert_eq!(modules, ["flaw"]);
}

#[test]
fn names_in_prose_are_those_of_rust_files() {
    let line = "- `a` holds: `x/tests.rs`, `tests/*.rs`, y.rs and `z.toml`. `tests/kill.rs`";
    assert_eq!(rust_files_in(line), ["x/tests.rs", "tests/kill.rs"]);
}
