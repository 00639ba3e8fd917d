//! `trolley help` and `trolley man`: the help of commands, and pages that belong to no command.

use crate::output::Output;
use crate::print;
use clap::Command;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trolley::Failure;

pub(crate) const MAN_EXAMPLES: &str = "\
Examples:
  trolley man | head -5
  trolley man model import | head -5
  trolley man --out DIR                    a page for each command, as trolley-model-import.1";

/// Which man page to print.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct ManArgs {
    /// The command [default: the program].
    command: Vec<String>,
    /// Write the pages of all commands into this folder instead.
    #[arg(long, value_name = "DIR", conflicts_with = "command")]
    out: Option<PathBuf>,
}

/// The pages: name, what it is, text. The keys are made from the schema.
const TOPICS: [(&str, &str, &str); 8] = [
    ("tutorial", "from a mesh to a ranking in ten minutes", include_str!("../docs/tutorial.md")),
    ("keys", "every key of a scenario", ""),
    ("formats", "files that are read and written", include_str!("../docs/formats.md")),
    ("policies", "policies and curves that ship", include_str!("../docs/policies.md")),
    ("exit-codes", "what a command says by its exit code", include_str!("../docs/exit-codes.md")),
    ("schemes", "who gets which job", include_str!("../docs/schemes.md")),
    ("studies", "many scenes, swept, as tables", include_str!("../docs/studies.md")),
    ("faults", "faults that are injected", include_str!("../docs/faults.md")),
];

/// Prints a page, or the help of a command.
pub(crate) fn run(program: Command, words: &[String]) -> Result<ExitCode, Failure> {
    if let [word] = words {
        if word == "topics" {
            return print::out(&topics());
        }
        if let Some((name, _, text)) = TOPICS.iter().find(|(name, ..)| name == word) {
            let keys = (*name == "keys").then(scenario::key_reference);
            return print::out(keys.as_deref().unwrap_or(text));
        }
    }
    let mut command = command(program, words)?;
    print::out(&command.render_long_help().to_string())
}

/// Prints a man page, or writes all.
pub(crate) fn manual(
    program: Command,
    asked: &ManArgs,
    output: &Output,
) -> Result<ExitCode, Failure> {
    let Some(folder) = &asked.out else {
        return print::out_bytes(&page(command(program, &asked.command)?)?);
    };
    if !folder.is_dir() {
        let failure = Failure::input("there is no such folder").at(folder.display());
        return Err(failure.with_remedy("make it first: mkdir"));
    }
    let mut root = program;
    root.build();
    let written = write_all(folder, root)?;
    output.say(&format!("written: {written} pages in {}", folder.display()));
    Ok(ExitCode::SUCCESS)
}

/// The list of topics.
fn topics() -> String {
    let line = |(name, what, _): &(&str, &str, &str)| format!("  {name:<12}{what}");
    let lines: Vec<String> = TOPICS.iter().map(line).collect();
    format!("Topics of `trolley help`:\n{}", lines.join("\n"))
}

/// The command of these words; the program for none.
fn command(program: Command, words: &[String]) -> Result<Command, Failure> {
    let mut command = program;
    command.build();
    for word in words {
        let Some(next) = command.find_subcommand(word) else {
            let fault = format!("there is no command or topic \"{}\"", words.join(" "));
            return Err(
                Failure::setting(fault).with_remedy("see trolley --help, trolley help topics")
            );
        };
        command = next.clone();
    }
    Ok(command)
}

/// The man page of a command.
fn page(command: Command) -> Result<Vec<u8>, Failure> {
    let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
    let mut text = Vec::new();
    clap_mangen::Man::new(command).title(name).render(&mut text).map_err(print::failed)?;
    Ok(text)
}

/// Writes the man page of a command, and those of all below it; returns how many.
fn write_all(folder: &Path, command: Command) -> Result<usize, Failure> {
    let mut written = 1;
    for below in command.get_subcommands().filter(|below| !below.is_hide_set()) {
        written += write_all(folder, below.clone())?;
    }
    let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
    trolley::files::replace(&folder.join(format!("{name}.1")), &page(command)?)?;
    Ok(written)
}
