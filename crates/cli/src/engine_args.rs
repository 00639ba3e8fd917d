//! Flags that configure the engine.

use clap::Args;
use scenario::{EngineSettings, Overrides};
use trolley::Failure;

/// Engine settings; each overrides the scenario's. None changes a complete answer.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct EngineArgs {
    /// Number of worker processes, 1 to 16.
    #[arg(long, value_name = "N")]
    workers: Option<i64>,
    /// Core of each worker, as 0,1,2,3; "none" disables pinning.
    #[arg(long, value_name = "LIST")]
    cores: Option<String>,
    /// Distribution depth: how many levels of both trees the coordinator descends itself.
    #[arg(long, value_name = "D")]
    depth: Option<i64>,
    /// How trees are built: paper, literal or sah.
    #[arg(long)]
    build: Option<String>,
    /// Maximum number of triangles in a leaf.
    #[arg(long, value_name = "N")]
    leaf_size: Option<i64>,
    /// Jobs per message.
    #[arg(long, value_name = "N")]
    batch: Option<i64>,
    /// Maximum number of jobs in flight to one worker.
    #[arg(long, value_name = "N")]
    queue: Option<i64>,
    /// Seed of all random choices.
    #[arg(long, value_name = "N")]
    seed: Option<i64>,
    /// Name of this instance in shared memory: 1 to 12 of a-z, 0-9 and -.
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: Option<String>,
    /// Run all jobs in this process, without workers (for comparison).
    #[arg(long)]
    pub(crate) in_process: bool,
}

impl EngineArgs {
    /// Whether the settings fit those of a scenario; what does not is said by the names of flags.
    pub(crate) fn check(&self, settings: &EngineSettings) -> Result<(), Failure> {
        let Err(misfit) = settings.apply(&self.overrides()?) else { return Ok(()) };
        let key = misfit.setting;
        let flag = format!("--{}", key.replace('_', "-"));
        let named = |text: &str| {
            let text = text.replace(&format!("{key} = []"), &format!("{flag} none"));
            let words = text.split(' ').map(|word| if word == key { flag.as_str() } else { word });
            words.collect::<Vec<_>>().join(" ")
        };
        Err(Failure::setting(named(&misfit.what)).with_remedy(named(&misfit.remedy)))
    }

    /// The settings that override the scenario's.
    pub(crate) fn overrides(&self) -> Result<Overrides, Failure> {
        let cores = match self.cores.as_deref() {
            None => None,
            Some("none") => Some(Vec::new()),
            Some(list) => {
                let cores: Result<Vec<i64>, _> =
                    list.split(',').map(|core| core.trim().parse()).collect();
                Some(cores.map_err(|_not_a_number| {
                    Failure::setting(format!("--cores {list}: not a list of core numbers"))
                        .with_remedy("write --cores 0,1,2,3, or --cores none")
                })?)
            }
        };
        Ok(Overrides {
            workers: self.workers,
            cores,
            depth: self.depth,
            batch: self.batch,
            queue: self.queue,
            build: self.build.clone(),
            leaf_size: self.leaf_size,
            seed: self.seed,
            ..Overrides::default()
        })
    }
}
