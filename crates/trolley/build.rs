//! Names this build by what it was made of: a hash over the lock file and every source file, in a
//! workspace of all crates, or of this crate alone where it was unpacked from a registry: there the
//! exact versions of the others follow from its own.
//!
//! Both ends of every channel must carry the same name, so that no two versions ever talk.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    let manifest = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let workspace = manifest.join("../..");
    let is_workspace = workspace.join("crates/trolley/build.rs").is_file();
    let (lock, sources) = if is_workspace {
        (workspace.join("Cargo.lock"), workspace.join("crates"))
    } else {
        (manifest.join("Cargo.lock"), manifest)
    };
    let mut files = Vec::new();
    files.extend(lock.is_file().then(|| lock.clone()));
    collect(&sources, &mut files);
    files.sort();
    let mut hasher = blake3::Hasher::new();
    for file in &files {
        hasher.update(&fs::read(file).expect("a source file that was listed a moment ago"));
    }
    println!("cargo::rustc-env=TROLLEY_BUILD={}", &hasher.finalize().to_hex()[..16]);
    println!("cargo::rerun-if-changed={}", sources.display());
    println!("cargo::rerun-if-changed={}", lock.display());
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("the sources lie here").flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|end| end == "rs" || end == "toml") {
            files.push(path);
        }
    }
}
