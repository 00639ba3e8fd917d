//! What is unpacked, and how old it is.

use super::*;
use std::time::{Duration, SystemTime};

/// An archive as cargo makes them, with a file that is older than anything that was built.
fn archive(name: &str, text: &str, into: &Path) -> Result<()> {
    let folder = into.join(name);
    fs::create_dir_all(&folder)?;
    let file = folder.join("lib.rs");
    fs::write(&file, text)?;
    let old = SystemTime::UNIX_EPOCH + Duration::from_secs(1_153_704_088);
    fs::File::options().append(true).open(&file)?.set_modified(old)?;
    let packed = Command::new("tar")
        .args(["-czf", &format!("{name}.crate"), name])
        .current_dir(into)
        .status()?;
    ensure!(packed.success(), "tar: {packed}");
    Ok(fs::remove_dir_all(folder)?)
}

#[test]
fn a_package_is_newer_than_what_was_built_of_it_before() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let (archives, to) = (folder.path().join("package"), folder.path().join("packages"));
    let built = folder.path().join("built");
    fs::write(&built, "of the package before")?;
    let built = fs::metadata(built)?.modified()?;
    for text in ["pub fn first() {}", "pub fn second() {}"] {
        archive("trolley-bvh-0.1.0", text, &archives)?;
        let packages = unpack(&archives, &to)?;
        assert_eq!(packages, [("trolley-bvh".to_owned(), "trolley-bvh-0.1.0".to_owned())]);
        let file = to.join("trolley-bvh-0.1.0/lib.rs");
        assert_eq!(fs::read_to_string(&file)?, text);
        assert!(fs::metadata(&file)?.modified()? >= built, "cargo would not compile it");
    }
    Ok(())
}
