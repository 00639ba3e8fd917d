//! A Debian root file system with a cross compiler and an emulator, and commands inside of it.
//!
//! Each command has a mount and a process namespace of its own: mounts, the emulator's registration
//! with the kernel and all processes end with it, however it ends, and nobody else sees them.

use anyhow::{Context as _, Result, bail};
use check::built::{CargoWorkspace, output};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What is installed: compiler, the target's libraries, linker, emulator.
const PACKAGES: &[&str] = &[
    "rustc",
    "cargo",
    "libstd-rust-dev:arm64",
    "gcc",
    "gcc-aarch64-linux-gnu",
    "libc6-dev",
    "libc6-dev:arm64",
    "libgcc-s1:arm64",
    "dpkg-dev",
    "qemu-user",
];

/// The target.
pub(crate) const TARGET: &str = "aarch64-unknown-linux-gnu";

/// Registers `$emulator` with the kernel, as long as the shell runs that does this. `$root` is
/// where the system is mounted, or nothing.
///
/// The kernel opens the emulator at once (flag F), so that it is found from inside any root.
pub(crate) const REGISTER: &str = r#"
binfmt=$root/proc/sys/fs/binfmt_misc
mount -t binfmt_misc binfmt_misc "$binfmt"
name=trolley-aarch64-$(cat /proc/sys/kernel/random/uuid)
magic='\x7fELF\x02\x01\x01\x00\x00\x00\x00\x00\x00\x00\x00\x00\x02\x00\xb7\x00'
mask='\xff\xff\xff\xff\xff\xff\xff\x00\xff\xff\xff\xff\xff\xff\xff\xff\xfe\xff\xff\xff'
printf ':%s:M:0:%s:%s:%s:OCF' "$name" "$magic" "$mask" "$emulator" > "$binfmt/register"
trap 'echo -1 > "$binfmt/$name"' EXIT
"#;

/// Mounts what a system needs, and runs a command in it. Words: root, source, place, cargo's home,
/// emulator, working folder, then the command.
const INSIDE: &str = r#"
root=$1 source=$2 place=$3 home=$4 emulator=$5 work=$6; shift 6
mount -t proc proc "$root/proc"
mount -t sysfs -o ro sysfs "$root/sys"
mount --bind /dev "$root/dev"
mount -t tmpfs -o mode=1777,size=2g shm "$root/dev/shm"
mkdir -p "$root/$source" "$root/$place" "$root/$home/registry"
mount --bind "$source" "$root/$source"
mount -o remount,bind,ro "$root/$source"
mount --bind "$place" "$root/$place"
mount --bind "$home/registry" "$root/$home/registry"
if [ -x "$emulator" ]; then
    REGISTER
fi
chroot "$root" /usr/bin/env --chdir="$work" "$@"
"#;

/// The root file system and what is built in it, in one folder.
#[derive(Debug)]
pub(crate) struct Root {
    /// The folder of everything that is kept from one run to the next.
    pub(crate) place: PathBuf,
    source: PathBuf,
    /// Cargo's home, whose registry is shared: nothing is downloaded twice.
    home: PathBuf,
    /// Held while we run: two at a time would take the emulator away from each other.
    _lock: File,
}

impl Root {
    /// The release of Debian: the first whose compiler is new enough.
    pub(crate) const SUITE: &str = "forky";

    /// Where it is: `$TROLLEY_AARCH64_ROOT`, or in the target folder.
    pub(crate) fn place(workspace: &CargoWorkspace) -> PathBuf {
        let named = std::env::var_os("TROLLEY_AARCH64_ROOT").filter(|name| !name.is_empty());
        named.map_or_else(|| workspace.target.join("aarch64"), PathBuf::from)
    }

    /// Whether it was made, whole.
    pub(crate) fn is_made(place: &Path) -> bool {
        place.join("ready").is_file()
    }

    /// Makes it, or what an earlier run left undone.
    pub(crate) fn open(workspace: &CargoWorkspace) -> Result<Self> {
        if !rustix::process::geteuid().is_root() {
            bail!("a root file system is made and entered as root alone\n  help: sudo");
        }
        let place = Self::place(workspace);
        fs::create_dir_all(&place).with_context(|| place.display().to_string())?;
        let place = place.canonicalize()?;
        let lock = File::create(place.join("lock"))?;
        if lock.try_lock().is_err() {
            bail!("{}: another run is at work there", place.display());
        }
        let source = workspace.root.canonicalize()?;
        let home = home().context("neither CARGO_HOME nor HOME is set")?;
        let root = Self { place, source, home, _lock: lock };
        if !Self::is_made(&root.place) {
            root.bootstrap()?;
            root.install()?;
            fs::write(root.place.join("ready"), Self::SUITE)?;
        }
        root.check_compiler(workspace)?;
        Ok(root)
    }

    fn path(&self) -> PathBuf {
        self.place.join("root")
    }

    /// The emulator, as this machine's own program.
    pub(crate) fn emulator(&self) -> PathBuf {
        self.path().join("usr/bin/qemu-aarch64")
    }

    /// What cargo builds there.
    fn built(&self) -> PathBuf {
        self.place.join("built")
    }

    /// The smallest system, in one move: a root of half the files is never taken for one.
    fn bootstrap(&self) -> Result<()> {
        if self.path().is_dir() {
            return Ok(());
        }
        let part = self.place.join("part");
        if part.exists() {
            fs::remove_dir_all(&part).with_context(|| part.display().to_string())?;
        }
        bootstrap(Self::SUITE, None, None, &part)?;
        Ok(fs::rename(&part, self.path())?)
    }

    /// Compiler, linker and emulator. A mirror may be a frozen copy, whose lists have expired; they
    /// are signed all the same.
    fn install(&self) -> Result<()> {
        let line = format!(
            "dpkg --add-architecture arm64 && \
             apt-get -q -o Acquire::Check-Valid-Until=false update && \
             apt-get -q -y --no-install-recommends install {}",
            PACKAGES.join(" ")
        );
        let mut command = self.inside(Path::new("/"), &["sh", "-c", &line]);
        logged(&mut command, &self.place.join("install.log"))
    }

    fn check_compiler(&self, workspace: &CargoWorkspace) -> Result<()> {
        let manifest = fs::read_to_string(workspace.root.join("Cargo.toml"))?;
        let line = manifest.lines().find_map(|line| line.strip_prefix("rust-version = "));
        let wanted = version(line.context("Cargo.toml has no rust-version")?);
        let said = self.says(&["rustc", "--version"])?;
        if version(&said) < wanted {
            bail!("the compiler there is too old: {said}\n  help: remove {}", self.place.display());
        }
        Ok(())
    }

    /// A command that sees the root as `/`, source and cargo's registry at their own paths, and a
    /// `/dev/shm` of its own. It has no variables but those that cargo needs.
    pub(crate) fn inside(&self, work: &Path, words: &[&str]) -> Command {
        let mut command = namespaced();
        command.args(["sh", "-euc", &INSIDE.replace("REGISTER", REGISTER), "sh"]);
        command.args([&self.path(), &self.source, &self.place, &self.home, &self.emulator()]);
        command.arg(work);
        command.args(["-i", "HOME=/root", "PATH=/usr/sbin:/usr/bin:/sbin:/bin", "LC_ALL=C.UTF-8"]);
        command.args(["DEBIAN_FRONTEND=noninteractive", "CARGO_INCREMENTAL=0"]);
        command.args(["CARGO_PROFILE_RELEASE_DEBUG=0", "CARGO_NET_OFFLINE=true"]);
        command.arg(format!("CARGO_HOME={}", self.home.display()));
        command.arg(format!("CARGO_TARGET_DIR={}", self.built().display()));
        command.arg("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc");
        command.args(words).stdin(Stdio::null());
        command
    }

    /// What a short command says, without the end of its line.
    pub(crate) fn says(&self, words: &[&str]) -> Result<String> {
        Ok(output(&mut self.inside(Path::new("/"), words))?.trim().to_owned())
    }
}

/// `debootstrap`, of this architecture or of one that the emulator runs, into a new folder.
///
/// A release that this debootstrap does not know is made as unstable is.
pub(crate) fn bootstrap(
    suite: &str,
    arch: Option<&str>,
    emulator: Option<&Path>,
    folder: &Path,
) -> Result<()> {
    let scripts = Path::new("/usr/share/debootstrap/scripts");
    let Ok(true) = scripts.join("sid").try_exists() else {
        bail!("there is no debootstrap\n  help: apt-get install debootstrap");
    };
    let known = scripts.join(suite);
    let script = if known.exists() { known } else { scripts.join("sid") };
    let register = emulator.map_or("", |_| REGISTER);
    let line = format!("root= emulator=$1; shift\n{register}\ndebootstrap \"$@\"");
    let mut command = namespaced();
    command.args(["--mount-proc", "sh", "-euc", &line, "sh"]);
    command.arg(emulator.unwrap_or(Path::new(""))).arg("--variant=minbase");
    command.args(arch.map(|arch| format!("--arch={arch}")));
    // No mirror: debootstrap's own.
    command.arg(suite).arg(folder).arg("").arg(script);
    logged(&mut command, &folder.with_extension("log"))
}

/// `unshare` with namespaces for mounts and processes; all of these end with it.
pub(crate) fn namespaced() -> Command {
    let mut command = Command::new("unshare");
    command.args(["--mount", "--propagation", "private", "--pid", "--fork", "--kill-child"]);
    command
}

/// Runs a command whose output goes into a file, which an error names.
pub(crate) fn logged(command: &mut Command, log: &Path) -> Result<()> {
    let file = File::create(log).with_context(|| log.display().to_string())?;
    let status = command.stdin(Stdio::null()).stdout(file.try_clone()?).stderr(file).status();
    let status = status.with_context(|| format!("cannot start {command:?}"))?;
    if !status.success() {
        bail!("{status}: see {}", log.display());
    }
    Ok(())
}

/// Cargo's home.
fn home() -> Option<PathBuf> {
    let named = std::env::var_os("CARGO_HOME").filter(|name| !name.is_empty()).map(PathBuf::from);
    named.or_else(|| std::env::home_dir().map(|home| home.join(".cargo")))
}

/// Major and minor number of the first version in a text.
fn version(text: &str) -> Option<(u32, u32)> {
    let from = text.find(|letter: char| letter.is_ascii_digit())?;
    let mut numbers = text[from..].split(|letter: char| !letter.is_ascii_digit());
    Some((numbers.next()?.parse().ok()?, numbers.next()?.parse().ok()?))
}
