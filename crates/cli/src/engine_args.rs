//! How an engine is to work, as a person asks for it.

use clap::Args;
use scenario::Overrides;
use trolley::Failure;

/// Settings of the engine; each overrides the scenario's. None changes a complete answer.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct EngineArgs {
    /// Worker processes, 1 to 16.
    #[arg(long, value_name = "N")]
    workers: Option<i64>,
    /// Core of each worker, as 0,1,2,3; "none": no pinning.
    #[arg(long, value_name = "LIST")]
    cores: Option<String>,
    /// Distribution depth: levels of both trees that the coordinator descends itself.
    #[arg(long, value_name = "D")]
    depth: Option<i64>,
    /// How trees are built: seed, literal or sah.
    #[arg(long)]
    build: Option<String>,
    /// Triangles in a leaf at most.
    #[arg(long, value_name = "N")]
    leaf_size: Option<i64>,
    /// Jobs per message.
    #[arg(long, value_name = "N")]
    batch: Option<i64>,
    /// Jobs on their way to one worker at most.
    #[arg(long, value_name = "N")]
    queue: Option<i64>,
    /// Seed of every choice that is called random.
    #[arg(long, value_name = "N")]
    seed: Option<i64>,
    /// Name of this instance in shared memory: 1 to 12 of a-z, 0-9 and -.
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: Option<String>,
    /// Run all jobs in this process, without workers: for comparison.
    #[arg(long)]
    pub(crate) in_process: bool,
}

impl EngineArgs {
    /// What takes the place of the scenario's settings.
    pub(crate) fn overrides(&self) -> Result<Overrides, Failure> {
        let cores = match self.cores.as_deref() {
            None => None,
            Some("none") => Some(Vec::new()),
            Some(list) => {
                let cores: Result<Vec<i64>, _> =
                    list.split(',').map(|core| core.trim().parse()).collect();
                Some(cores.map_err(|error| {
                    Failure::setting(format!("--cores {list}: {error}"))
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
