//! Base64 and percent signs, against what the standards list.

use super::*;

#[test]
fn base64_gives_the_vectors_of_rfc_4648() {
    let vectors = [
        ("", ""),
        ("Zg==", "f"),
        ("Zm8=", "fo"),
        ("Zm9v", "foo"),
        ("Zm9vYg", "foob"),
        ("Zm9vYmFy", "foobar"),
    ];
    for (text, bytes) in vectors {
        assert_eq!(from_base64(text), Some(bytes.as_bytes().to_vec()), "{text}");
    }
    assert_eq!(from_base64("Zm9vY"), None);
    assert_eq!(from_base64("Zm 9v"), None);
}

#[test]
fn percent_signs_are_decoded_or_refused() {
    assert_eq!(percent_decoded("a%20b%C3%A9.bin").as_deref(), Some("a b\u{e9}.bin"));
    for bad in ["%", "%2", "%zz", "%ff", "%+1"] {
        assert_eq!(percent_decoded(bad), None, "{bad}");
    }
}
