//! Clean systems: the smallest that Debian has, of which nothing that is tried changes a file.

use crate::aarch64::{Root, bootstrap, namespaced};
use anyhow::{Context as _, Result, bail};
use check::built::{CargoWorkspace, output};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Runs a script in a copy that lies in memory and ends with it.
///
/// Words: the clean system, the emulator or nothing, the script, packages, patience.
const TRY: &str = r#"
clean=$1 emulator=$2 script=$3 package=$4 next=$5 developers=$6 patience=$7
room=$(mktemp -d)
mount -t tmpfs -o mode=755 room "$room"
mkdir "$room/over" "$room/work" "$room/root"
mount -t overlay -o "lowerdir=$clean,upperdir=$room/over,workdir=$room/work" over "$room/root"
root=$room/root
mount -t proc proc "$root/proc"
mount -t sysfs -o ro sysfs "$root/sys"
mount --bind /dev "$root/dev"
mount -t tmpfs -o mode=1777,size=1g shm "$root/dev/shm"
mount -t tmpfs -o mode=755 run "$root/run"
mkdir "$root/packages"
cp "$script" "$root/packages/try"
cp "$package" "$root/packages/package.deb"
cp "$next" "$root/packages/next.deb"
cp "$developers" "$root/packages/developers.deb"
if [ -n "$emulator" ]; then
    ENTER
fi
chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 \
    DEBIAN_FRONTEND=noninteractive sh /packages/try /packages/package.deb /packages/next.deb \
    /packages/developers.deb "$patience" 2>&1
"#;

/// A clean system.
#[derive(Debug)]
pub(crate) struct Clean {
    /// What it is, for the page.
    pub(crate) name: String,
    folder: PathBuf,
    emulator: Option<PathBuf>,
}

impl Clean {
    /// This machine's own release, since the package needs its libc.
    pub(crate) fn amd64(workspace: &CargoWorkspace) -> Result<Self> {
        let release = fs::read_to_string("/etc/os-release").context("/etc/os-release")?;
        let field = |key: &str| {
            let line = release.lines().find_map(|line| line.strip_prefix(key));
            line.map(|value| value.trim_matches('"').to_owned())
        };
        let (id, suite) = (field("ID="), field("VERSION_CODENAME="));
        let Some(suite) = suite.filter(|_| id.as_deref() == Some("debian")) else {
            bail!("this machine is no Debian with a name: a clean one of its kind cannot be made");
        };
        let place = Root::place(workspace);
        fs::create_dir_all(&place)?;
        Self::make(&place.canonicalize()?, &suite, "amd64", None)
    }

    /// The release of the cross compiler, under its emulator.
    pub(crate) fn arm64(root: &Root) -> Result<Self> {
        Self::make(&root.place, Root::SUITE, "arm64", Some(root.emulator()))
    }

    /// Made once, in one move; found again after that.
    fn make(place: &Path, suite: &str, arch: &str, emulator: Option<PathBuf>) -> Result<Self> {
        let folder = place.join(format!("clean-{suite}-{arch}"));
        let name = format!("Debian {suite}, {arch}, `debootstrap --variant=minbase`");
        let made = Self { name, folder, emulator };
        if !made.folder.is_dir() {
            let part = place.join(format!("part-{arch}"));
            if part.exists() {
                fs::remove_dir_all(&part)?;
            }
            bootstrap(suite, Some(arch), made.emulator.as_deref(), &part)?;
            fs::rename(&part, &made.folder)?;
        }
        Ok(made)
    }

    /// Runs the script; what it says, if it ends well.
    pub(crate) fn run(
        &self,
        script: &Path,
        [package, next, developers]: [&PathBuf; 3],
        patience: u32,
    ) -> Result<String> {
        let mut command = namespaced();
        command.args(["sh", "-euc", &TRY.replace("ENTER", crate::aarch64::REGISTER), "sh"]);
        command.arg(&self.folder).arg(self.emulator.as_deref().unwrap_or(Path::new("")));
        command.args([script, package, next, developers]).arg(patience.to_string());
        let done = command.stdin(Stdio::null()).output().context("cannot start unshare")?;
        let said = String::from_utf8_lossy(&done.stdout).into_owned();
        if !done.status.success() {
            let error = String::from_utf8_lossy(&done.stderr);
            bail!("{}: {}\n{said}{error}", self.name, done.status);
        }
        Ok(said)
    }
}

/// What a package says of itself, in lines.
pub(crate) fn field(package: &Path, name: &str) -> Result<String> {
    let said = output(Command::new("dpkg-deb").arg("--field").arg(package).arg(name))?;
    Ok(said.trim().to_owned())
}
