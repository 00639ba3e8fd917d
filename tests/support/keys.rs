//! Keys as openssl writes them, for tests that sign: not secret, and of no other use.

use super::Place;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;

/// RFC 8032, section 7.1, test 1.
const SECRET: &str = "-----BEGIN PRIVATE KEY-----\n\
    MC4CAQAwBQYDK2VwBCIEIJ1hsZ3v/VpguoRK9JLsLMREScVpezJpGXA7rAMcrn9g\n\
    -----END PRIVATE KEY-----\n";
const PUBLIC: &str = "-----BEGIN PUBLIC KEY-----\n\
    MCowBQYDK2VwAyEA11qYAYKxCrfVS/7TyWQHOg7hcvPapiMlrwIaaPcHURo=\n\
    -----END PUBLIC KEY-----\n";
/// Another one, for a forger.
const OTHER_SECRET: &str = "-----BEGIN PRIVATE KEY-----\n\
    MC4CAQAwBQYDK2VwBCIEIC7T3wFSQmpuzGfML5oN7XiWFM9VrOIHFtRBjro6hJku\n\
    -----END PRIVATE KEY-----\n";
const OTHER_PUBLIC: &str = "-----BEGIN PUBLIC KEY-----\n\
    MCowBQYDK2VwAyEAmMIU6CiRJiVnQBs5q7ygw6sKBXgrNFqnrM2gOu+F2RE=\n\
    -----END PUBLIC KEY-----\n";

/// Files of two pairs of keys.
pub(crate) struct Keys {
    pub(crate) secret: PathBuf,
    pub(crate) public: PathBuf,
    pub(crate) other_secret: PathBuf,
    pub(crate) other_public: PathBuf,
}

impl Keys {
    pub(crate) fn new(place: &Place) -> Self {
        let keys = Self {
            secret: place.write("key.pem", SECRET),
            public: place.write("key.pub", PUBLIC),
            other_secret: place.write("other.pem", OTHER_SECRET),
            other_public: place.write("other.pub", OTHER_PUBLIC),
        };
        for secret in [&keys.secret, &keys.other_secret] {
            std::fs::set_permissions(secret, PermissionsExt::from_mode(0o600)).unwrap();
        }
        keys
    }
}
