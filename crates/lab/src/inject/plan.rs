//! A fault plan: which faults, how often, against which scenario.

use super::kind::Kind;
use geometry::rng::Rng;
use keys::Twice;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trolley::Failure;
use trolley::files::{self, InputKind};

/// The plan as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    schema: String,
    /// Beside the plan.
    scenario: PathBuf,
    /// Beside the plan: what clients of a service ask.
    asked: PathBuf,
    workers: u8,
    depth: u32,
    at_once: u8,
    /// Deadline of each answer (ms).
    deadline_ms: Option<u32>,
    faults: BTreeMap<String, u32>,
}

#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) scenario: PathBuf,
    /// What clients of a service ask.
    pub(crate) asked: PathBuf,
    pub(crate) workers: u8,
    pub(crate) depth: u32,
    /// Maximum number of faults in one request.
    pub(crate) at_once: u8,
    /// Deadline of each answer (ms); without one, all work is done, however long it takes.
    pub(crate) deadline_ms: Option<u32>,
    faults: Vec<(Kind, u32)>,
}

const SCHEMA: &str = "trolley.faults/1";
const MOST: u32 = 1_000_000;

impl Plan {
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        Self::parse(path, &files::text(path, InputKind::Plan)?)
    }

    fn parse(path: &Path, text: &str) -> Result<Self, Failure> {
        let name = path.display();
        let written: Written = toml::from_str(text).map_err(|error| {
            let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            let line = before.matches('\n').count() + 1;
            if let Some(twice) = Twice::in_toml(text, &error) {
                let fault = format!("{name}:{line}: {}", twice.what());
                return Failure::input(fault).with_remedy(Twice::REMEDY);
            }
            let fault = error.message().replace('\n', ", ");
            Failure::input(format!("{name}:{line}: {fault}"))
                .with_remedy("config/faults/campaign.toml has every key")
        })?;
        let refuse = |fault: String, help: String| {
            Err(Failure::input(format!("{name}: {fault}")).with_remedy(help))
        };
        if written.schema != SCHEMA {
            let fault = format!("schema \"{}\" is not known", written.schema);
            return refuse(fault, format!("write schema = \"{SCHEMA}\""));
        }
        let (workers, at_once) = (written.workers, written.at_once);
        if !(1..=16).contains(&workers) || !(1..=workers).contains(&at_once) {
            let fault = format!("workers = {workers}, at_once = {at_once}");
            return refuse(fault, "workers: 1 to 16; at_once: 1 to workers".to_owned());
        }
        if !(1..=24).contains(&written.depth) {
            return refuse(format!("depth = {}", written.depth), "depth: 1 to 24".to_owned());
        }
        let deadline_ms = written.deadline_ms;
        if deadline_ms.is_some_and(|ms| !(5..=60_000).contains(&ms)) {
            let fault = format!("deadline_ms = {}", deadline_ms.unwrap_or(0));
            return refuse(fault, "deadline_ms: 5 to 60000, or leave it out".to_owned());
        }
        let mut faults = Vec::new();
        for (fault, count) in &written.faults {
            let Some(kind) = Kind::from_name(fault) else {
                let help = format!("expected one of: {}", Kind::names());
                return refuse(format!("unknown fault \"{fault}\""), help);
            };
            if *count > MOST {
                return refuse(format!("{fault} = {count}"), format!("at most {MOST}"));
            }
            faults.push((kind, *count));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let [scenario, asked] = [written.scenario, written.asked].map(|path| folder.join(path));
        Ok(Self { scenario, asked, workers, depth: written.depth, at_once, deadline_ms, faults })
    }

    /// All faults, in an order that follows from the seed.
    pub(crate) fn shuffled(&self, seed: u64) -> Vec<Kind> {
        let mut all: Vec<Kind> = self
            .faults
            .iter()
            .flat_map(|(kind, count)| std::iter::repeat_n(*kind, *count as usize))
            .collect();
        let mut rng = Rng::new(seed);
        for at in (1..all.len()).rev() {
            all.swap(at, rng.below(at as u64 + 1) as usize);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    //! The shipped plans parse; faults in a plan are reported.
    use super::*;

    #[test]
    fn the_shipped_plans_are_read_and_name_every_kind() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/faults");
        for entry in std::fs::read_dir(&folder).unwrap() {
            let plan = Plan::read(&entry.unwrap().path()).unwrap();
            assert!(plan.scenario.is_file() && plan.asked.is_file());
            assert_eq!(plan.shuffled(3), plan.shuffled(3));
        }
        let campaign = Plan::read(&folder.join("campaign.toml")).unwrap();
        let all = campaign.shuffled(1);
        for kind in Kind::ALL {
            assert!(all.contains(kind), "{kind:?}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let good = "schema = \"trolley.faults/1\"\nscenario = \"s\"\nasked = \"a\"\n\
                    workers = 2\ndepth = 4\n\
                    at_once = 1\n[faults]\nkill = 3\n";
        let parse = |text: &str| Plan::parse(Path::new("p.toml"), text);
        assert_eq!(parse(good).unwrap().shuffled(1), [Kind::Kill; 3]);
        for (from, to, said) in [
            ("kill =", "kil =", "kil"),
            ("kill = 3", "kill = 3000000", "3000000"),
            ("at_once = 1", "at_once = 3", "at_once"),
            ("depth = 4", "depth = 4\ndeadline_ms = 0", "deadline_ms"),
            ("depth = 4", "depth = 400", "depth"),
            ("faults/1", "faults/2", "schema"),
            ("workers", "worker", "worker"),
        ] {
            let failure = parse(&good.replace(from, to)).unwrap_err();
            assert!(failure.what().contains(said), "{failure}");
        }
    }
}
