//! Which files a file may name.
//!
//! A scenario, a deployment or a library of bodies may come from a stranger: it names files of its
//! own folder, and of folders in that, unless its user allows others. Links and `..` are followed
//! before this is decided. What a user names on the command line is the user's own.

use crate::Failure;
use std::path::{Component, Path, PathBuf};

/// Which files a scenario or a deployment may name.
///
/// ```
/// use trolley::{References, Scenario};
///
/// let small = trolley::read_text("../../config/scenarios/small.toml".as_ref())?;
/// let text = format!("policy = \"../policies/weighted.toml\"\n{small}");
/// let name = "../../config/scenarios/weighted.toml";
/// assert!(Scenario::parse(name, &text).is_err());
/// assert!(Scenario::parse_with(name, &text, References::Anywhere).is_ok());
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum References {
    /// Those in the folder of the file that names them, or in folders of it.
    #[default]
    Inside,
    /// All that can be read.
    Anywhere,
}

impl References {
    /// Refuses a path that leads out of the folder of `file`, which names it. `place` is where:
    /// the file with line or key.
    pub(crate) fn check(self, file: &Path, place: &str, written: &Path) -> Result<(), Failure> {
        let folder = folder(file);
        let resolved = resolved(&folder.join(written));
        if self == Self::Anywhere || resolved.starts_with(self::resolved(&folder)) {
            return Ok(());
        }
        let what = format!("\"{}\" leads out of the folder of this file", written.display());
        Err(Failure::input(what).at(place).with_remedy(format!(
            "move it into {}, or allow files elsewhere: --allow-outside",
            folder.display()
        )))
    }
}

/// The path of a file that another file names: relative to the folder of that.
pub(crate) fn beside(file: &Path, written: &Path) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(written)
}

fn folder(file: &Path) -> PathBuf {
    match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// A path without links and `..`. What does not exist has no links.
fn resolved(path: &Path) -> PathBuf {
    let there = path.ancestors().find_map(|part| Some((part, part.canonicalize().ok()?)));
    let (mut whole, rest) = match there {
        Some((part, whole)) => (whole, path.strip_prefix(part).unwrap_or(Path::new(""))),
        None => (std::path::absolute("").unwrap_or_default(), path),
    };
    for part in rest.components() {
        match part {
            Component::ParentDir => drop(whole.pop()),
            Component::CurDir => {}
            other => whole.push(other),
        }
    }
    whole
}

#[cfg(test)]
mod tests {
    //! Links and `..` are followed; what does not exist is judged by its name.
    use super::*;

    #[test]
    fn a_path_is_judged_by_where_it_leads() {
        let place = tempfile::tempdir().unwrap();
        let root = place.path().canonicalize().unwrap();
        std::fs::create_dir_all(root.join("own/in")).unwrap();
        for (to, link) in [("..", "own/up"), ("in", "own/down"), ("/", "own/root")] {
            std::os::unix::fs::symlink(to, root.join(link)).unwrap();
        }
        std::fs::write(root.join("own/in/file"), "").unwrap();
        std::fs::write(root.join("file"), "").unwrap();
        let file = root.join("own/scenario.toml");
        let check = |path: &str| References::Inside.check(&file, "p", Path::new(path)).is_ok();
        let absolute = |path: &str| root.join(path).display().to_string();
        for inside in [
            "in/file",
            "in/../in/file",
            "down/file",
            "in/none",
            "none/../in/file",
            "up/own/in/file",
            "../own/in/file",
            ".",
            &absolute("own/in/file"),
            &absolute("own/none"),
        ] {
            assert!(check(inside), "{inside}");
        }
        for outside in [
            "..",
            "../file",
            "../none",
            "up/file",
            "up/none",
            "none/../../file",
            // Through the link, `..` leads to what is above its target.
            "down/../../file",
            "root/etc/passwd",
            "/etc/passwd",
            "../own-not/file",
            &absolute("file"),
        ] {
            assert!(!check(outside), "{outside}");
            let anywhere = References::Anywhere.check(&file, "p", Path::new(outside));
            assert!(anywhere.is_ok(), "{outside}");
        }
    }

    #[test]
    fn a_file_without_a_folder_is_in_the_current_one() {
        let check = |path: &str| References::Inside.check("a.toml".as_ref(), "p", path.as_ref());
        assert!(check("Cargo.toml").is_ok());
        assert!(check("src/lib.rs").is_ok());
        let failure = check("../record/Cargo.toml").unwrap_err();
        assert!(failure.what().starts_with("p: \"../record/Cargo.toml\" leads out"), "{failure}");
        assert!(failure.remedy().is_some_and(|help| help.contains("--allow-outside")));
    }
}
