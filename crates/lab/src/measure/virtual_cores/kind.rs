//! One way to rank: alone, with workers, or as if on cores that there are not.

use coordinator::VirtualTime;
use trolley::{Answer, Engine, EngineBuilder, Failure, Limits, Run, Scenario};

/// One way to rank, and what came of it in each turn (ns).
pub(super) struct Kind {
    engine: Engine,
    pub(super) took_ns: Vec<f64>,
    pub(super) times: Vec<VirtualTime>,
}

impl Kind {
    pub(super) fn of(builder: EngineBuilder) -> Result<Self, Failure> {
        let engine = builder.build()?;
        Ok(Self { engine, took_ns: Vec::new(), times: Vec::new() })
    }

    pub(super) fn rank(&mut self, scenario: &Scenario, limits: &Limits) -> Result<Answer, Failure> {
        let ranking = self.engine.rank(scenario, limits)?;
        let Run { stages, .. } = &ranking.run;
        let ms = stages.plan_ms + stages.work_ms + stages.assess_ms + stages.worlds_ms;
        self.took_ns.push(1e6 * ms);
        self.times.extend(self.engine.virtual_time().cloned());
        Ok(ranking.answer)
    }

    /// Forgets what was measured before anything was warm.
    pub(super) fn forget(&mut self) {
        self.took_ns.clear();
        self.times.clear();
    }
}
