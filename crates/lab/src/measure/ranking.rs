//! One ranking of a scenario with experimental dispatch: the answer, which does not depend on it,
//! and the effort.

use crate::progress::SyncProgress;
use scenario::Overrides;
use serde::Serialize;
use std::path::PathBuf;
use trolley::dispatch_options::{DispatchOptions, log_csv};
use trolley::{Answer, Engine, Failure, Limits, References, Run, Scenario, files};

/// What to rank, and how.
#[derive(Clone, Debug, Default)]
pub struct RankOptions {
    /// Scenario, TOML.
    pub scenario: PathBuf,
    /// Which files the scenario may name.
    pub references: References,
    /// Engine settings that override the scenario's.
    pub overrides: Overrides,
    /// How jobs reach the workers.
    pub dispatch_options: DispatchOptions,
    /// When to stop, and which candidate's job is sent next.
    pub limits: Limits,
    /// Name of the instance in shared memory, if not chosen by the program.
    pub instance: Option<String>,
    /// Whether all jobs run in this process.
    pub in_process: bool,
    /// Where to write the job log.
    pub job_log: Option<PathBuf>,
}

/// A ranking, and its effort.
#[derive(Clone, Debug, Serialize)]
pub struct RankedRun {
    schema: &'static str,
    answer: Answer,
    run: Run,
}

impl RankedRun {
    /// The effort as text, one line for each kind.
    #[must_use]
    pub fn text(&self) -> String {
        let Run { stages, jobs, nb, np, messages, message_bytes, .. } = &self.run;
        let Run { scheme, depth, section_bytes, section_bytes_unshared, .. } = &self.run;
        format!(
            "{}: work {:.2} ms, {} of {jobs} jobs at depth {depth}, {nb} tests of boxes and {np} \
             of triangles\n{messages} messages of {message_bytes} bytes in all\n{section_bytes} \
             bytes of sections, {section_bytes_unshared} if none were ever held; {} sections made \
             room",
            scheme.name(),
            stages.work_ms,
            jobs - self.run.jobs_cut,
            self.run.sections_evicted
        )
    }
}

/// Ranks a scenario once. `told` is called with the triangles built.
///
/// # Errors
///
/// If the scenario cannot be ranked with these settings, or the file cannot be written.
pub fn rank(options: &RankOptions, told: SyncProgress<'_>) -> Result<RankedRun, Failure> {
    // Fail before the work, not after it, if the file cannot be written.
    options.job_log.as_deref().map(|path| files::check(path, None)).transpose()?;
    let scenario = Scenario::open_with(&options.scenario, options.references)?;
    let dispatch_options =
        DispatchOptions { log: options.job_log.is_some(), ..options.dispatch_options };
    let mut builder =
        Engine::builder().overrides(options.overrides.clone()).dispatch_options(dispatch_options);
    if let Some(instance) = &options.instance {
        builder = builder.instance(instance);
    }
    if options.in_process {
        builder = builder.in_process();
    }
    let mut engine = builder.build()?;
    let mut ranking = engine.rank_telling(&scenario, &options.limits, told)?;
    if let Some(path) = &options.job_log {
        files::replace(path, log_csv(engine.job_log()).as_bytes())?;
    }
    ranking.run.stages.stop_ms = engine.stop_workers();
    Ok(RankedRun { schema: "trolley.measure-rank/1", answer: ranking.answer, run: ranking.run })
}
