//! What README, `docs`, `--help` and the pages of results show is pasted, in order, into a copy of
//! what a clone has: it runs, names files that exist, and leaves nothing that git would track.
//!
//! Commands with a word in capitals (`FILE.xml`, `DIR`) show a form and are not pasted. Those that
//! measure for minutes are parsed, and the files that they name are looked for.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{instance, signal, text, wait_for};
use rustix::process::Signal;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// What begins a command that takes long, and is only parsed.
const LONG: &[&str] = &[
    "trolley measure --quick",
    "trolley measure --pair",
    "trolley measure --map",
    "trolley certify",
    "trolley simulate faults",
    "trolley inject",
    "trolley validate config/orderings --page",
    "trolley policy check config/policies/*.toml",
    "trolley rank crash.toml --members",
    "trolley study plan tools/study/fleet.toml",
    "trolley study run studies/fleet",
    "trolley study report studies/fleet",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// A copy of what commands read, under git, with instances of its own.
struct Clone {
    folder: tempfile::TempDir,
}

impl Clone {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let parts = [
            "config",
            "docs",
            "tests/data",
            "crates/trolley/examples/data",
            "tools/results/measure",
            "README.md",
            ".gitignore",
        ];
        for part in parts {
            copy(&root().join(part), &folder.path().join(part));
        }
        let deployments = folder.path().join("config/deployments");
        for entry in std::fs::read_dir(deployments).unwrap() {
            let path = entry.unwrap().path();
            let lines = std::fs::read_to_string(&path).unwrap();
            let own = format!("instance = \"{}\"", instance());
            let named = |line: &str| line.starts_with("instance = ");
            let lines =
                lines.lines().map(|line| if named(line) { own.clone() } else { line.into() });
            std::fs::write(&path, lines.collect::<Vec<String>>().join("\n")).unwrap();
        }
        let made = Self { folder };
        let staged = made.shell("git init -q . && git add -A");
        assert!(staged.status.success(), "{}", text(&staged.stderr));
        made
    }

    /// Runs a script as a person would paste it, with the program in the path.
    fn shell(&self, script: &str) -> Output {
        let program = Path::new(env!("CARGO_BIN_EXE_trolley")).parent().unwrap();
        let path = std::env::var_os("PATH").unwrap();
        let mut paths = vec![program.to_owned()];
        paths.extend(std::env::split_paths(&path));
        let mut child = Command::new("bash");
        child.args(["-euo", "pipefail", "-c", script]).current_dir(self.folder.path());
        child.env("PATH", std::env::join_paths(paths).unwrap()).stdin(Stdio::null());
        child.output().unwrap()
    }

    /// Pastes commands, in order, and checks that each ends well.
    fn paste(&self, commands: &[String]) {
        let mut before = String::new();
        let mut pasted = 0;
        for command in commands.iter().filter(|command| !has_placeholder(command)) {
            if command.contains("D=") || command.starts_with("export ") {
                before = format!("{before}{command}\n");
                continue;
            }
            let Some(command) = as_program(command) else {
                self.assert_files(&format!("{before}{command}"));
                continue;
            };
            if LONG.iter().any(|begin| command.starts_with(begin)) {
                self.assert_parsed(&command);
                continue;
            }
            let ran = self.shell(&format!("{before}{command}"));
            let (out, error) = (text(&ran.stdout), text(&ran.stderr));
            assert!(ran.status.success(), "$ {command}\n{out}{error}");
            pasted += 1;
        }
        assert!(pasted > 0, "nothing to paste: {commands:?}");
        self.assert_clean();
    }

    /// Checks that a command has no fault but the flag that is added to it.
    fn assert_parsed(&self, command: &str) {
        self.assert_files(command);
        let command = command.split(" #").next().unwrap().trim_end_matches(['&', ' ']);
        let ran = self.shell(&format!("{command} --no-such-flag"));
        let error = text(&ran.stderr);
        assert_eq!(ran.status.code(), Some(2), "$ {command}\n{error}");
        assert!(error.contains("'--no-such-flag'"), "$ {command}\n{error}");
    }

    /// Checks that the files exist that a command names below folders of the checkout.
    fn assert_files(&self, command: &str) {
        let folders = ["config/", "tests/", "tools/", "crates/", "docs/"];
        let words = command.split(|c: char| c.is_whitespace() || "=,".contains(c));
        let outputs = ["--page", "--out", "-o"];
        let mut before = "";
        for word in words {
            let is_input = !outputs.contains(&before) && !word.contains('*');
            before = word;
            if is_input && folders.iter().any(|folder| word.starts_with(folder)) {
                assert!(root().join(word).exists(), "there is no {word}: {command}");
            }
        }
    }

    /// Checks that git would track nothing of what was written.
    fn assert_clean(&self) {
        let status =
            self.shell("git status --porcelain --untracked-files=all | grep -v '^A ' || true");
        assert_eq!(text(&status.stdout), "", "git does not ignore these");
    }
}

fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        std::fs::create_dir_all(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap() {
            let entry = entry.unwrap();
            copy(&entry.path(), &to.join(entry.file_name()));
        }
    } else {
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(from, to).unwrap();
    }
}

/// Whether a command shows a form: a word of it is a name in capitals.
fn has_placeholder(command: &str) -> bool {
    let command = command.split(" #").next().unwrap_or_default();
    let words = command.split(|c: char| !(c.is_alphanumeric() || "_$-".contains(c)));
    let is_one = |word: &str| word.chars().next().is_some_and(|c| c.is_ascii_uppercase());
    let capitals = |word: &str| word.chars().all(|c| c.is_ascii_uppercase() || c == '_');
    command.starts_with("trolley") && words.into_iter().any(|word| is_one(word) && capitals(word))
}

/// A command of the program, if it is one: one of cargo that runs it is, too.
fn as_program(command: &str) -> Option<String> {
    let own = command.replace("cargo run --release -- ", "trolley ");
    let is_shell = ["sed ", "openssl "].iter().any(|begin| own.starts_with(begin));
    (own.starts_with("trolley ") || is_shell).then_some(own)
}

/// The commands of the blocks of a page that are meant for a shell.
fn of_page(page: &str) -> Vec<String> {
    let mut commands = Vec::new();
    let mut is_shell = false;
    for line in page.lines() {
        if line.starts_with("```") {
            is_shell = line == "```sh";
        } else if is_shell {
            commands.push(line.to_owned());
        }
    }
    joined(commands)
}

/// The examples in the help of a command, without what is said beside them.
fn of_help(command: &str) -> Vec<String> {
    let program = Command::new(env!("CARGO_BIN_EXE_trolley"))
        .args(command.split_whitespace())
        .arg("--help")
        .output()
        .unwrap();
    assert!(program.status.success(), "{command}: {}", text(&program.stderr));
    let help = text(&program.stdout);
    let examples = help.lines().skip_while(|line| !line.starts_with("Example"));
    let lines = examples.filter_map(|line| line.strip_prefix("  "));
    let alone = |line: &str| {
        let line = line.trim_start();
        line.split("  ").next().unwrap_or_default().to_owned()
    };
    let first = ["trolley ", "openssl ", "D="];
    let mut commands = Vec::new();
    for line in joined(lines.map(alone).collect()) {
        if first.iter().any(|first| line.starts_with(first)) {
            commands.push(line);
        }
    }
    commands
}

/// The commands within the sentences of a page, between backticks, which may go over lines.
fn inline(page: &str) -> Vec<String> {
    let mut prose = String::new();
    let mut is_block = false;
    for line in page.lines() {
        if line.starts_with("```") {
            is_block = !is_block;
        } else if !is_block {
            prose += line;
            // Between two paragraphs no code goes on.
            prose.push(if line.is_empty() { '\n' } else { ' ' });
        }
    }
    let paragraphs = prose.lines().flat_map(|paragraph| paragraph.split('`').skip(1).step_by(2));
    let is_one = |code: &&str| code.starts_with("cargo x ") || as_program(code).is_some();
    paragraphs.filter(is_one).map(str::to_owned).collect()
}

/// Checks that `cargo x` has a task, and its flags: the names of its types and fields.
fn assert_task(line: &str) {
    let mut source = String::new();
    let mut folders = vec![root().join("tools/src")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                source += &std::fs::read_to_string(&path).unwrap();
            }
        }
    }
    let mut words = line.split_whitespace();
    let task = words.next().unwrap();
    let variant = task[..1].to_uppercase() + &task[1..];
    let is_there =
        [",", "(", " {"].iter().any(|end| source.contains(&format!("    {variant}{end}")));
    assert!(is_there, "no task {task}: cargo x {line}");
    for flag in words.filter_map(|word| word.strip_prefix("--")) {
        let field = format!("{}: ", flag.replace('-', "_"));
        assert!(source.contains(&field), "no flag --{flag}: cargo x {line}");
    }
}

/// Regression: commands in sentences were not looked at, and named flags that were gone.
#[test]
fn commands_in_sentences_are_found() {
    let page = "See `trolley\nrank a.toml`, `x` and\n\n```sh\ntrolley no\n```\n`cargo x check`.\n";
    assert_eq!(inline(page), ["trolley rank a.toml", "cargo x check"]);
    let refused = std::panic::catch_unwind(|| assert_task("compare --no-such-flag"));
    assert!(refused.is_err());
}

/// Lines that end in a backslash, joined with the next.
fn joined(lines: Vec<String>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for line in lines {
        match all.last_mut().and_then(|last| last.strip_suffix('\\').map(str::to_owned)) {
            Some(begin) => *all.last_mut().unwrap() = begin + line.trim_start(),
            None if !line.trim().is_empty() => all.push(line),
            None => {}
        }
    }
    all
}

/// Pastes the examples of some commands, each into one and the same clone.
fn paste_help(commands: &[&str]) {
    let clone = Clone::new();
    for command in commands {
        let examples = of_help(command);
        assert!(!examples.is_empty(), "{command} has no examples");
        clone.paste(&examples);
    }
}

#[test]
fn the_help_of_rank_scenario_and_init() {
    paste_help(&["", "rank", "scenario import"]);
    paste_help(&["init"]);
}

#[test]
fn the_help_of_policies() {
    paste_help(&["policy check", "policy map"]);
}

#[test]
fn the_help_of_bodies() {
    paste_help(&["model import", "model info", "model check", "model generate", "model export"]);
    paste_help(&["intersect", "man"]);
}

#[test]
fn the_help_of_records_and_reports() {
    paste_help(&["record show", "report"]);
}

#[test]
fn the_help_of_the_laboratory() {
    paste_help(&["measure", "validate"]);
    let clone = Clone::new();
    for command in ["certify", "simulate faults", "inject"] {
        for example in of_help(command).iter().filter(|example| !has_placeholder(example)) {
            clone.assert_parsed(example);
        }
    }
}

#[test]
fn the_tutorial() {
    Clone::new()
        .paste(&of_page(&std::fs::read_to_string(root().join("docs/tutorial.md")).unwrap()));
}

#[test]
fn the_readme_but_for_its_service() {
    let page = std::fs::read_to_string(root().join("README.md")).unwrap();
    let service = ["trolley serve", "trolley query", "trolley top", "kill %1", "export "];
    let mut commands = of_page(&page);
    commands.retain(|command| {
        let is_build = command.starts_with("cargo ") && !command.contains(" run ");
        !is_build && !service.iter().any(|begin| command.starts_with(begin))
    });
    commands.retain(|command| !command.starts_with("trolley doctor"));
    Clone::new().paste(&commands);
}

/// A service that is started in the background is queried in the very next line.
#[test]
fn the_service_of_readme_and_help() {
    let page = std::fs::read_to_string(root().join("README.md")).unwrap();
    let of_service = ["trolley serve", "trolley query", "trolley top", "kill %1"];
    let mut script: Vec<String> = of_page(&page);
    script.retain(|command| of_service.iter().any(|begin| command.starts_with(begin)));
    assert_eq!(script.len(), 4, "{script:?}");
    assert!(script[0].ends_with('&') && script[3].starts_with("kill"), "{script:?}");
    for command in ["query", "top"] {
        let examples = of_help(command);
        let examples = examples.iter().filter(|example| !has_placeholder(example));
        for example in examples {
            let is_endless = example.starts_with("trolley top") && !example.contains("--times");
            let more = if is_endless { " --times 1" } else { "" };
            script.insert(1, format!("{example}{more}"));
        }
    }
    // Those of help come before their page's, so the first is one that waits.
    let first = script.iter().position(|line| line.contains("--wait")).unwrap();
    script.swap(1, first);
    script.push("wait %1 || true".to_owned());
    let clone = Clone::new();
    let ran = clone.shell(&script.join("\n"));
    let (out, error) = (text(&ran.stdout), text(&ran.stderr));
    assert!(ran.status.success(), "{script:#?}\n{out}{error}");
    clone.assert_clean();
}

#[test]
fn pages_of_results_name_files_and_flags_that_exist() {
    let clone = Clone::new();
    let mut count = 0;
    let mut folders = vec![root().join("tools/results")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "md") {
                let page = std::fs::read_to_string(&path).unwrap();
                let mut commands = of_page(&page);
                commands.extend(inline(&page));
                for command in &commands {
                    if let Some(task) = command.strip_prefix("cargo x ") {
                        assert_task(task);
                    } else if let Some(command) = as_program(command) {
                        clone.assert_parsed(&command);
                    }
                    count += 1;
                }
            }
        }
    }
    assert!(count > 5, "{count} commands");
}

#[test]
fn what_the_demo_says_comes_next() {
    let clone = Clone::new();
    let demo = clone.shell("trolley demo --in-process");
    let said = text(&demo.stderr);
    let next: Vec<String> =
        said.lines().filter_map(|line| line.strip_prefix("Next: ")).map(str::to_owned).collect();
    assert!(!next.is_empty(), "{said}");
    clone.paste(&next);
}

/// Pages that list what there is list all of it, and the program prints them.
#[test]
fn pages_name_every_code_scheme_fault_and_policy() {
    let page = |topic: &str| {
        let printed = Command::new(env!("CARGO_BIN_EXE_trolley")).args(["help", topic]).output();
        let printed = text(&printed.unwrap().stdout);
        let file = root().join(format!("docs/{topic}.md"));
        assert!(printed == std::fs::read_to_string(file).unwrap(), "trolley help {topic}");
        printed
    };
    let codes = page("exit-codes");
    for code in [0, 1, 2, 3, 4, 65, 69, 70, 71, 75, 76, 77, 78, 130] {
        assert!(codes.contains(&format!("\n| {code} |")), "exit code {code}");
    }
    let schemes = page("schemes");
    for scheme in scenario::Scheme::ALL {
        assert!(schemes.contains(&format!("`{}`", scheme.name())), "{scheme:?}");
    }
    let faults = page("faults");
    let plan = std::fs::read_to_string(root().join("config/faults/campaign.toml")).unwrap();
    let plan: toml::Table = plan.parse().unwrap();
    for kind in plan["faults"].as_table().unwrap().keys() {
        assert!(faults.contains(&format!("`{kind}`")), "{kind}");
    }
    let policies = page("policies");
    for entry in std::fs::read_dir(root().join("config/policies")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        assert!(trolley::policy_names().any(|known| known == name), "{name} does not ship");
        assert!(policies.contains(&format!("`{name}`")), "{name}");
    }
    for topic in ["tutorial", "keys", "formats"] {
        page(topic);
    }
}

/// A page that nobody reads ends `top`.
#[test]
fn top_ends_with_its_reader() {
    let clone = Clone::new();
    let mut service = Command::new(env!("CARGO_BIN_EXE_trolley"))
        .args(["serve", "config/deployments/minimal.toml", "--quiet"])
        .current_dir(clone.folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let query =
        "trolley query config/deployments/minimal.toml config/scenarios/minimal.toml --wait";
    // On a machine that has other work, too: this is about the reader of `top`.
    let asked = clone.shell(&format!("{query} --deadline-ms 20000"));
    let read = clone.shell("timeout 10 trolley top config/deployments/minimal.toml | head -1");
    signal(service.id(), Signal::TERM);
    let ended = wait_for(5_000, || service.try_wait().unwrap());
    assert!(asked.status.success(), "{}", text(&asked.stderr));
    assert!(read.status.success(), "{} {}", text(&read.stdout), text(&read.stderr));
    assert!(ended.is_some(), "the service still runs");
}
