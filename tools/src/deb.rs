//! `cargo x deb`: Debian packages for amd64 and arm64, held against lintian and a clean system.

mod clean;
mod page;

use crate::aarch64::{PACKED, Program, Root, SCENARIOS, TARGET, build_here, build_program, logged};
use anyhow::{Context as _, Result, bail};
use check::built::{CargoWorkspace, output, write};
use check::step::{cargo, now};
use clap::Args;
use clean::Clean;
use page::Page;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// How large the program may be, stripped (bytes): the command fails if one is larger.
pub(crate) const PROGRAM_MOST: u64 = 12_000_000;

/// An emulator is that much slower, about.
const EMULATED: u32 = 30;

/// How much to do.
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// Only this architecture; the page says so.
    #[arg(long, value_name = "ARCH", value_parser = ["amd64", "arm64"])]
    only: Option<String>,
    /// Who answers for the packages, as `NAME <ADDRESS>` [default: git's user].
    #[arg(long, value_name = "NAME")]
    maintainer: Option<String>,
    /// Build packages and check them, but install nothing.
    #[arg(long)]
    no_install: bool,
    /// The page to write, if packages were installed.
    #[arg(long, value_name = "FILE", default_value = "tools/results/deb.md")]
    out: PathBuf,
}

/// The packages of one architecture.
#[derive(Debug)]
pub(crate) struct Packages {
    /// Debian's name of it.
    pub(crate) arch: &'static str,
    /// The service.
    pub(crate) service: PathBuf,
    /// The same with a higher version.
    next: PathBuf,
    /// The client library.
    pub(crate) developers: PathBuf,
    /// Size of the stripped program (bytes).
    pub(crate) program: u64,
    /// What lintian said, which has no error among it.
    pub(crate) lintian: String,
    /// Hashes of `answer` by scenario, which are those of the release build here.
    pub(crate) answers: Vec<(&'static str, String)>,
    /// How long it took to build and pack (s).
    pub(crate) seconds: f64,
}

/// What was tried in a clean system.
#[derive(Debug)]
pub(crate) struct Tried {
    /// Which system.
    pub(crate) system: String,
    /// What the script said.
    pub(crate) log: String,
    /// How long it took (s).
    pub(crate) seconds: f64,
}

/// Builds, packs, checks, installs, and writes the page.
pub(crate) fn run(options: &Options) -> Result<ExitCode> {
    let workspace = CargoWorkspace::find()?;
    let maker = Maker::new(&workspace, options)?;
    let wanted = |arch: &str| options.only.as_ref().is_none_or(|only| only == arch);
    let mut all = Vec::new();
    if wanted("amd64") {
        let packages = maker.amd64()?;
        let clean = (!options.no_install).then(|| Clean::amd64(&workspace)).transpose()?;
        all.push((packages, clean));
    }
    if wanted("arm64") {
        let root = Root::open(&workspace)?;
        let packages = maker.arm64(&root)?;
        let clean = (!options.no_install).then(|| Clean::arm64(&root)).transpose()?;
        all.push((packages, clean));
    }
    let script = workspace.root.join("tools/deb/try");
    let mut tried = Vec::new();
    for (packages, clean) in &all {
        tell(&format!("{}: {} bytes of program", packages.arch, packages.program))?;
        let Some(clean) = clean else { continue };
        let patience = if packages.arch == "arm64" { EMULATED } else { 1 };
        let files = [&packages.service, &packages.next, &packages.developers];
        let start = now();
        let log = clean.run(&script, files, patience)?;
        let seconds = start.elapsed().as_secs_f64();
        tell(&format!("{}: installed, asked, upgraded, removed in {seconds:.0} s", packages.arch))?;
        tried.push(Tried { system: clean.name.clone(), log, seconds });
    }
    if !options.no_install {
        let packages: Vec<&Packages> = all.iter().map(|(packages, _)| packages).collect();
        let out = workspace.root.join(&options.out);
        write(&out, &Page::new(&workspace, &packages, &tried)?.to_string())?;
        tell(&format!("written to {}", out.display()))?;
    }
    let is_small = all.iter().all(|(packages, _)| packages.program <= PROGRAM_MOST);
    Ok(if is_small { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Makes packages.
struct Maker<'w> {
    workspace: &'w CargoWorkspace,
    maintainer: String,
    /// cargo-deb.
    packer: PathBuf,
}

impl<'w> Maker<'w> {
    fn new(workspace: &'w CargoWorkspace, options: &Options) -> Result<Self> {
        let git = |key| output(Command::new("git").args(["config", key]));
        let maintainer = match &options.maintainer {
            Some(maintainer) => maintainer.clone(),
            None => format!("{} <{}>", git("user.name")?.trim(), git("user.email")?.trim()),
        };
        let tools = workspace.target.join("tools");
        let packer = tools.join("bin/cargo-deb");
        if !packer.is_file() {
            tell("installing cargo-deb: some minutes, once")?;
            let words = ["install", "cargo-deb", "--locked", "--version", "3.8.0", "--root"];
            output(cargo().args(words).arg(&tools))?;
        }
        for program in ["lintian", "dpkg-deb", "dpkg-shlibdeps", "strip"] {
            let there = Command::new("which").arg(program).output()?.status.success();
            if !there {
                bail!("there is no {program}\n  help: apt-get install lintian dpkg-dev binutils");
            }
        }
        Ok(Self { workspace, maintainer, packer })
    }

    /// Of this machine: for its own libc and every later one.
    fn amd64(&self) -> Result<Packages> {
        let start = now();
        output(cargo().arg("build").args(PACKED))?;
        let built = self.workspace.target.join("vehicle");
        self.stage(&built, &built.join("trolley"))?;
        let pack = |words: &[&str]| {
            let mut command = Command::new(&self.packer);
            command.current_dir(&self.workspace.root).args(words);
            command.env("CARGO_TARGET_DIR", &self.workspace.target);
            command
        };
        let program = built.join("trolley");
        let packed = Program { file: &program, root: None, source: &self.workspace.root };
        self.pack("amd64", start, &packed, pack)
    }

    /// Of the root file system: for its libc and every later one.
    fn arm64(&self, root: &Root) -> Result<Packages> {
        let start = now();
        let source = self.workspace.root.canonicalize()?;
        let program = build_program(root, &source, PACKED)?.program()?;
        let built = program.parent().context("a file without a folder")?;
        // Pages and completions are the same for both; this machine runs its own program faster.
        output(cargo().arg("build").args(PACKED))?;
        self.stage(built, &self.workspace.target.join("vehicle/trolley"))?;
        let packer = self.packer.canonicalize()?;
        let packer = packer.to_str().context("a path that is no UTF-8")?;
        let pack = |words: &[&str]| {
            let target = ["--target", TARGET];
            root.inside(&source, &[&[packer], words, &target].concat())
        };
        let packed = Program { file: &program, root: Some(root), source: &source };
        self.pack("arm64", start, &packed, pack)
    }

    /// What is in the packages and in no other place: pages, completions, the unit.
    fn stage(&self, built: &Path, program: &Path) -> Result<()> {
        let folder = built.join("deb");
        if folder.exists() {
            fs::remove_dir_all(&folder)?;
        }
        let man = folder.join("man");
        fs::create_dir_all(&man)?;
        output(Command::new(program).args(["man", "--out"]).arg(&man))?;
        for page in fs::read_dir(&man)? {
            // Without name and time: equal pages are equal bytes.
            output(Command::new("gzip").args(["-9", "--no-name"]).arg(page?.path()))?;
        }
        for shell in ["bash", "zsh", "fish"] {
            let text = output(Command::new(program).args(["completions", shell]))?;
            write(&folder.join(format!("trolley.{shell}")), &text)?;
        }
        let unit = self.workspace.root.join("tools/systemd/trolley.service");
        let unit = fs::read_to_string(unit)?;
        write(&folder.join("trolley.service"), &unit.replace("/usr/local/bin/", "/usr/bin/"))
    }

    fn pack(
        &self,
        arch: &'static str,
        start: std::time::Instant,
        packed: &Program<'_>,
        pack: impl Fn(&[&str]) -> Command,
    ) -> Result<Packages> {
        // In the folder that both see.
        let folder = Root::place(self.workspace).join("packages");
        fs::create_dir_all(&folder)?;
        let folder = folder.canonicalize()?;
        let make = |package: &str, revision: &str, multiarch: &str| {
            let file = folder.join(format!("{package}-{revision}-{arch}.deb"));
            let words = ["--no-build", "--fast", "--locked", "--offline", "--profile", "vehicle"];
            let words = [&words[..], &["--package", package]].concat();
            let more = ["--maintainer", &self.maintainer, "--deb-revision", revision];
            let out = ["--output", file.to_str().context("a path that is no UTF-8")?];
            let words = [&words[..], &more, &out, &["--multiarch", multiarch]].concat();
            logged(&mut pack(&words), &folder.join("pack.log"))?;
            Ok::<_, anyhow::Error>(file)
        };
        let service = make("trolley-cli", "1", "none")?;
        let next = make("trolley-cli", "2", "none")?;
        let developers = make("trolley-client-c", "1", "same")?;
        let mut lintian = Command::new("lintian");
        lintian.args(["--allow-root", "--fail-on", "error", "--tag-display-limit", "0"]);
        let said = lintian.args([&service, &developers]).output().context("lintian")?;
        let text = String::from_utf8_lossy(&said.stdout).into_owned();
        if !said.status.success() {
            bail!("lintian, {arch}:\n{text}{}", String::from_utf8_lossy(&said.stderr));
        }
        let seconds = start.elapsed().as_secs_f64();
        let program = program_size(&service)?;
        let answers = self.answers(packed)?;
        Ok(Packages { arch, service, next, developers, program, lintian: text, answers, seconds })
    }

    /// Answers of the program that is packed: other optimisations may change no byte of them.
    fn answers(&self, packed: &Program<'_>) -> Result<Vec<(&'static str, String)>> {
        let fast = build_here()?;
        let fast = Program { file: &fast, root: None, source: &self.workspace.root };
        let mut answers = Vec::new();
        for &scenario in SCENARIOS {
            let [wanted, found] = [&fast, packed].map(|it| it.answer(scenario, &["--in-process"]));
            let (wanted, found) = (wanted?.0, found?.0);
            if found != wanted {
                bail!("answer of {scenario}: {found} as packed, {wanted} of the release build");
            }
            answers.push((scenario, found));
        }
        Ok(answers)
    }
}

/// Size of the program in a package (bytes).
fn program_size(package: &Path) -> Result<u64> {
    let list = output(Command::new("dpkg-deb").arg("--contents").arg(package))?;
    let line = list.lines().find(|line| line.ends_with("/usr/bin/trolley"));
    let size = line.and_then(|line| line.split_whitespace().nth(2)?.parse().ok());
    size.with_context(|| format!("{}: no program in it", package.display()))
}

/// A line of progress.
fn tell(line: &str) -> Result<()> {
    Ok(writeln!(std::io::stderr(), "deb     {line}")?)
}
