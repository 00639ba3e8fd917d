//! Keys are those of the RFC and of openssl; a signature holds for one key and one message.

use super::*;
use proptest::prelude::*;

/// RFC 8032, section 7.1, test 1, as `openssl genpkey` and `openssl pkey -pubout` write it.
pub(crate) const SECRET_PEM: &str = "-----BEGIN PRIVATE KEY-----\n\
    MC4CAQAwBQYDK2VwBCIEIJ1hsZ3v/VpguoRK9JLsLMREScVpezJpGXA7rAMcrn9g\n\
    -----END PRIVATE KEY-----\n";
const PUBLIC_PEM: &str = "-----BEGIN PUBLIC KEY-----\n\
    MCowBQYDK2VwAyEA11qYAYKxCrfVS/7TyWQHOg7hcvPapiMlrwIaaPcHURo=\n\
    -----END PUBLIC KEY-----\n";
const POINT: &str = "d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a";
/// Of the empty message.
const SIGNATURE: &str = "e5564300c360ac729086e2cc806e828a84877f1eb8e5d974d873e06522490155\
    5fb8821590a33bacc61e39701cf9b46bd25bf5f0595bbe24655141438e7a100b";

#[test]
fn the_key_and_the_signature_are_those_of_the_rfc() {
    let secret = SigningKey::from_pem(SECRET_PEM).expect("a key");
    assert_eq!(secret.verifying_key().to_string(), POINT);
    assert_eq!(VerifyingKey::from_pem(PUBLIC_PEM), Ok(secret.verifying_key()));
    assert_eq!(hex(&secret.sign(b"")), SIGNATURE);
    assert!(!format!("{secret:?}").contains("9d61b19d"), "a secret is never shown");
    // A line feed more or less, as editors leave it.
    assert!(SigningKey::from_pem(&format!("\n{SECRET_PEM}\n")).is_ok());
}

#[test]
fn what_is_no_key_is_refused_with_a_remedy() {
    assert_eq!(SigningKey::from_pem(PUBLIC_PEM).err(), Some(KeyError::Public));
    assert_eq!(VerifyingKey::from_pem(SECRET_PEM), Err(KeyError::Secret));
    let cut = &SECRET_PEM[..60];
    for text in ["", "hello", POINT, cut] {
        assert_eq!(SigningKey::from_pem(text).err(), Some(KeyError::NotSecret), "{text}");
    }
    for text in ["", "hello", POINT, &PUBLIC_PEM[..60]] {
        assert_eq!(VerifyingKey::from_pem(text), Err(KeyError::NotPublic), "{text}");
    }
    // The neutral point: a signature by it is one of everything.
    let mut neutral = [0; 32];
    neutral[0] = 1;
    assert_eq!(VerifyingKey::from_bytes(&neutral), Err(KeyError::NotPublic));
    for error in [KeyError::Public, KeyError::Secret, KeyError::NotSecret, KeyError::NotPublic] {
        assert!(error.remedy().is_some_and(|remedy| remedy.contains("openssl")), "{error}");
    }
}

#[test]
fn only_digits_are_taken_for_digits() {
    assert_eq!(unhex::<2>("0aF1"), Some([0x0a, 0xf1]));
    for text in ["", "0a", "0af", "0af1f", "0a+1", "0ag1", "é1f"] {
        assert_eq!(unhex::<2>(text), None, "{text}");
    }
}

proptest! {
    #[test]
    fn a_signature_is_of_its_key_and_its_message(
        seed: [u8; 32],
        message in prop::collection::vec(any::<u8>(), 1..80),
        at: prop::sample::Index,
        bit in 0..8_u8,
    ) {
        let key = SigningKey::from_seed(&seed);
        let good = key.sign(&message);
        prop_assert!(key.verifying_key().has_signed(&message, &good));
        let (mut other, mut bad) = (message.clone(), good);
        other[at.index(message.len())] ^= 1_u8 << bit;
        bad[at.index(64)] ^= 1_u8 << bit;
        prop_assert!(!key.verifying_key().has_signed(&other, &good));
        prop_assert!(!key.verifying_key().has_signed(&message, &bad));
        let mut another = seed;
        another[at.index(32)] ^= 1_u8 << bit;
        let another = SigningKey::from_seed(&another).verifying_key();
        prop_assert!(!another.has_signed(&message, &good));
    }
}
