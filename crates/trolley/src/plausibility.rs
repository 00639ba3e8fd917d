//! What a scenario states that is allowed and hardly true, beside its answer: for a ranking and for
//! its replay alike, so that both have the same bytes.

use crate::scenario::Scenario;
use crate::{Failure, FailureKind};
use body::{BodyView, Meta};
use coordinator::Answer;
use scenario::{Implausible, LoadedBody};

/// What is hardly true of a scenario; `models[i]` is the number of the body of party i in `views`.
pub(crate) fn of_scenario(
    parsed: &scenario::Scenario,
    views: &[(Meta, BodyView<'_>)],
    models: &[usize],
) -> Vec<Implausible> {
    let loaded = |model: &usize| {
        let (meta, view) = &views[*model];
        LoadedBody { kind: meta.kind, mass_kg: meta.mass_kg, bounds: view.bounds() }
    };
    let bodies: Vec<LoadedBody> = models.iter().map(loaded).collect();
    scenario::implausible(parsed, &bodies)
}

/// The answer with this in it, and with what is hardly true of its winner.
pub(crate) fn stated(answer: Answer, mut implausible: Vec<Implausible>) -> Answer {
    let free = answer.best().filter(|best| best.touches_nobody());
    let unmet = free.and_then(|best| {
        let nearest = best.nearest.as_ref().map(|near| (near.party.as_str(), near.gap_m));
        scenario::unmet(&best.name, nearest)
    });
    implausible.extend(unmet);
    Answer { implausible, ..answer }
}

/// Refuses an answer to a scenario that states what is hardly true.
///
/// ```
/// # let small = trolley::read_text("../../config/scenarios/small.toml".as_ref())?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// # let rank = |engine: &mut trolley::Engine, text: &str| {
/// #     let scenario = trolley::Scenario::parse("small.toml", text)?;
/// #     let ranking = engine.rank(&scenario, &trolley::Limits::default())?;
/// #     Ok::<_, trolley::Failure>((ranking, scenario))
/// # };
/// let (ranking, scenario) = rank(&mut engine, &small)?;
/// assert!(trolley::check_plausible(&scenario, &ranking.answer).is_ok());
///
/// let light = small.replace("[parties.ego]", "[parties.ego]\nmass_kg = 1.4");
/// let (ranking, scenario) = rank(&mut engine, &light)?;
/// let refused = trolley::check_plausible(&scenario, &ranking.answer).unwrap_err();
/// assert_eq!(refused.kind(), trolley::FailureKind::Refused);
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// [`FailureKind::Refused`] if [`Answer::implausible`] is not empty, with all that it holds.
pub fn check_plausible(scenario: &Scenario, answer: &Answer) -> Result<(), Failure> {
    if answer.implausible.is_empty() {
        return Ok(());
    }
    let all: Vec<&str> = answer.implausible.iter().map(|one| one.says.as_str()).collect();
    let refused = Failure::new(FailureKind::Refused, format!("hardly true: {}", all.join("; ")));
    Err(refused
        .at(scenario.file())
        .with_remedy("correct it, or rank it without --strict: the answer then says the same"))
}
