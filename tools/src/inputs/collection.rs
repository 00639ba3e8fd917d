//! A public collection: a folder, what it is called, and the files in it that somebody might try.

use anyhow::{Context as _, Result};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// So much of a file says what it is.
const HEAD_BYTES: u64 = 4096;

/// What a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Sort {
    /// A surface: made a model.
    Mesh,
    /// CommonRoad: made a scenario.
    Recording,
    /// What a simulator wrote: made a scenario.
    Trace,
    /// OpenSCENARIO: says what is to happen, and is to be refused with the way to go.
    Script,
    /// XML, CSV and protobuf of other programs, and solutions of planners: to be refused.
    Other,
}

impl Sort {
    /// All of them.
    pub(super) const ALL: [Self; 5] =
        [Self::Mesh, Self::Recording, Self::Trace, Self::Script, Self::Other];

    /// By the ending of a file's name, and of XML and CSV by its beginning.
    fn of(path: &Path) -> Option<Self> {
        let begins = |with: &str| {
            let mut head = Vec::new();
            let file = std::fs::File::open(path).ok();
            let _length = file.map(|file| file.take(HEAD_BYTES).read_to_end(&mut head));
            String::from_utf8_lossy(&head).contains(with)
        };
        let name = path.file_name()?.to_str()?.to_ascii_lowercase();
        let name = name.strip_suffix(".gz").unwrap_or(&name);
        let ending = name.rsplit_once('.')?.1;
        Some(match ending {
            "obj" | "stl" | "ply" | "gltf" | "glb" | "dae" | "k" | "key" | "dyn" | "off"
            | "3mf" => Self::Mesh,
            "xml" if begins("<commonRoad ") => Self::Recording,
            "osi" | "mcap" => Self::Trace,
            "csv" if begins("Index [-]") => Self::Trace,
            "xml" | "csv" | "pb" => Self::Other,
            "xosc" => Self::Script,
            _ => return None,
        })
    }

    /// As it is called on the page.
    pub(super) fn plural(self) -> &'static str {
        match self {
            Self::Mesh => "meshes",
            Self::Recording => "recordings",
            Self::Trace => "traces",
            Self::Script => "scripts",
            Self::Other => "files of other forms",
        }
    }
}

/// A folder of files.
#[derive(Debug)]
pub(super) struct Collection {
    pub(super) root: PathBuf,
    /// "OWNER/NAME" of its repository, or the name of the folder.
    pub(super) name: String,
    /// The commit, if it is a checkout.
    pub(super) commit: Option<String>,
    /// Paths in it, by name, and what they are.
    pub(super) files: Vec<(PathBuf, Sort)>,
}

impl Collection {
    pub(super) fn find(folder: &Path) -> Result<Self> {
        let root = folder.canonicalize().with_context(|| folder.display().to_string())?;
        let name = root.file_name().context("a folder without a name")?.to_string_lossy();
        let name = name.replacen('+', "/", 1);
        let commit = if root.join(".git").exists() {
            let mut git = Command::new("git");
            git.arg("-C").arg(&root).args(["rev-parse", "--short=10", "HEAD"]);
            let said = git.stderr(Stdio::null()).output().context("git")?;
            Some(String::from_utf8(said.stdout)?.trim().to_owned())
        } else {
            None
        };
        let mut files = Vec::new();
        let mut folders = vec![root.clone()];
        while let Some(folder) = folders.pop() {
            for entry in folder.read_dir()? {
                let entry = entry?;
                let kind = entry.file_type()?;
                if kind.is_dir() && entry.file_name() != ".git" {
                    folders.push(entry.path());
                } else if let Some(sort) = Sort::of(&entry.path()).filter(|_| kind.is_file()) {
                    files.push((entry.path().strip_prefix(&root)?.to_owned(), sort));
                }
            }
        }
        files.sort();
        Ok(Self { name, commit, files, root })
    }
}
