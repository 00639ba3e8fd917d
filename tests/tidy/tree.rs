//! The source tree: files, crates, and the dependencies in their manifests. Read-only.

use std::fs;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// The repository.
pub(crate) fn root() -> PathBuf {
    let cli = Path::new(env!("CARGO_MANIFEST_DIR"));
    cli.ancestors().nth(2).expect("cli lies two folders below the root").to_owned()
}

/// A file of text.
pub(crate) struct Text {
    /// Its path from the root.
    pub(crate) path: String,
    /// Its content.
    pub(crate) text: String,
}

impl Text {
    /// Reads a file of the repository.
    pub(crate) fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let root = root();
        let path = path.strip_prefix(&root).expect("a path below the root");
        Self { path: path.display().to_string(), text }
    }

    /// `line` is counted from 0.
    pub(crate) fn fault(&self, line: usize, what: &str) -> String {
        format!("{}:{}: {what}", self.path, line + 1)
    }
}

/// All Rust files below a folder of the repository, in order of their paths.
pub(crate) fn sources(folder: &Path) -> Vec<Text> {
    let (mut folders, mut files) = (vec![folder.to_owned()], Vec::new());
    while let Some(folder) = folders.pop() {
        for path in entries(&folder) {
            if path.is_dir() && !path.ends_with("target") {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    files.iter().map(|path| Text::read(path)).collect()
}

/// All Rust files of this project.
pub(crate) fn all_sources() -> Vec<Text> {
    let files: Vec<Text> =
        ["crates", "tests", "tools"].iter().flat_map(|at| sources(&root().join(at))).collect();
    assert!(files.len() > 100, "only {} files: is this the right place?", files.len());
    files
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    paths
}

/// What the names of our packages begin with, but for the library itself.
const PREFIX: &str = "trolley-";

/// A package of this workspace.
pub(crate) struct Package {
    /// Its folder, by which the others here name it.
    pub(crate) name: String,
    /// Where it lies.
    pub(crate) folder: PathBuf,
    /// Its manifest.
    pub(crate) manifest: Text,
    table: Table,
}

/// All packages of this workspace.
pub(crate) fn packages() -> Vec<Package> {
    let mut folders = entries(&root().join("crates"));
    folders.extend(["tools/check", "tools"].map(|folder| root().join(folder)));
    let packages: Vec<Package> = folders.into_iter().map(Package::read).collect();
    assert!(packages.len() > 10, "only {} packages: is this the right place?", packages.len());
    packages
}

/// A table of the workspace's manifest.
pub(crate) fn workspace_dependencies() -> Table {
    let manifest = Text::read(&root().join("Cargo.toml"));
    let table: Table = manifest.text.parse().expect("cargo has read it");
    let dependencies = table["workspace"]["dependencies"].as_table();
    dependencies.expect("a table of dependencies").clone()
}

impl Package {
    fn read(folder: PathBuf) -> Self {
        let manifest = Text::read(&folder.join("Cargo.toml"));
        let table: Table =
            manifest.text.parse().unwrap_or_else(|e| panic!("{}: {e}", manifest.path));
        let name = folder.file_name().expect("a folder").to_string_lossy().into_owned();
        Self { name, folder, manifest, table }
    }

    /// A value of its manifest.
    pub(crate) fn value(&self, path: &[&str]) -> Option<&Value> {
        let (first, rest) = path.split_first()?;
        rest.iter().try_fold(self.table.get(*first)?, |value, key| value.get(key))
    }

    /// The name that a registry knows it by.
    pub(crate) fn published_as(&self) -> String {
        if self.name == "trolley" { self.name.clone() } else { format!("{PREFIX}{}", self.name) }
    }

    /// All that it uses, for whatever purpose: folders of ours, names of others' packages, and the
    /// lines that say so.
    pub(crate) fn uses(&self) -> Vec<(String, usize)> {
        self.uses_as(&["dependencies", "dev-dependencies", "build-dependencies"])
    }

    /// The dependencies in some tables only: of its program, its tests, its build.
    pub(crate) fn uses_as(&self, kinds: &[&str]) -> Vec<(String, usize)> {
        let everywhere = workspace_dependencies();
        let for_targets = self.table.get("target").and_then(Value::as_table);
        let tables = for_targets.into_iter().flat_map(Table::values).filter_map(Value::as_table);
        let mut uses = Vec::new();
        for table in std::iter::once(&self.table).chain(tables) {
            let kinds = kinds.iter().filter_map(|kind| table.get(*kind)?.as_table());
            for (key, entry) in kinds.flatten() {
                let renamed = |entry: &Value| Some(entry.get("package")?.as_str()?.to_owned());
                let name = renamed(entry).or_else(|| renamed(everywhere.get(key)?));
                let name = name.unwrap_or_else(|| key.clone());
                let folder = name.strip_prefix(PREFIX).unwrap_or(&name).to_owned();
                uses.push((folder, self.line_of(key)));
            }
        }
        uses
    }

    /// What every build of it uses: not what is there for its tests.
    pub(crate) fn built_with(&self) -> impl Iterator<Item = (&String, &Value)> {
        let for_targets = self.table.get("target").and_then(Value::as_table);
        let tables = for_targets.into_iter().flat_map(Table::values).filter_map(Value::as_table);
        std::iter::once(&self.table)
            .chain(tables)
            .flat_map(|table| ["dependencies", "build-dependencies"].map(|kind| table.get(kind)))
            .filter_map(|kind| kind?.as_table())
            .flatten()
    }

    /// The line of the manifest that names a dependency.
    fn line_of(&self, key: &str) -> usize {
        let names = |line: &str| {
            let inline =
                line.strip_prefix(key).is_some_and(|rest| rest.starts_with([' ', '.', '=']));
            inline || line.ends_with(&format!("dependencies.{key}]"))
        };
        self.manifest.text.lines().position(|line| names(line.trim())).unwrap_or(0)
    }
}
