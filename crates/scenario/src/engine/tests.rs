//! Settings are replaced one by one, stay valid together, and an override obeys the file's rules.

use super::*;
use proptest::prelude::*;

fn changes() -> impl Strategy<Value = Overrides> {
    let whole = || proptest::option::of(-2_i64..70);
    let cores = proptest::option::of(proptest::collection::vec(-1_i64..1030, 0..6));
    let words =
        prop_oneof![Just("paper"), Just("seed"), Just("literal"), Just("sah"), Just("none")];
    let alpha = proptest::option::of(prop_oneof![-0.5..1.5, Just(f64::NAN), Just(-0.0)]);
    let scheme = proptest::option::of(prop_oneof![Just("best-match-load"), Just("worst")]);
    (
        (whole(), cores, whole(), whole(), scheme, alpha),
        (whole(), whole(), proptest::option::of(words), whole(), whole()),
    )
        .prop_map(|((workers, cores, coordinator_core, depth, scheme, alpha), rest)| {
            let (batch, queue, build, leaf_size, seed) = rest;
            let (scheme, build) = (scheme.map(str::to_owned), build.map(str::to_owned));
            Overrides {
                workers,
                cores,
                coordinator_core,
                depth,
                scheme,
                alpha,
                batch,
                queue,
                build,
                leaf_size,
                seed,
            }
        })
}

/// The settings, written out again.
fn as_written(engine: &EngineSettings) -> Overrides {
    let number = |n: usize| Some(i64::try_from(n).unwrap());
    Overrides {
        workers: number(engine.workers),
        cores: match &engine.cores {
            Cores::Granted => None,
            Cores::Unpinned => Some(Vec::new()),
            Cores::Listed(cores) => Some(cores.iter().map(|core| i64::from(*core)).collect()),
        },
        coordinator_core: engine.coordinator_core.map(i64::from),
        depth: Some(i64::from(engine.depth)),
        scheme: Some(engine.scheme.name().to_owned()),
        alpha: Some(engine.alpha),
        batch: number(engine.batch),
        queue: number(engine.queue),
        build: Some(names::Named::word(engine.build).to_owned()),
        leaf_size: Some(i64::from(engine.leaf_size)),
        seed: Some(i64::try_from(engine.seed).unwrap()),
    }
}

fn is_valid(engine: &EngineSettings) -> bool {
    let cores = match &engine.cores {
        Cores::Listed(cores) => {
            cores.len() == engine.workers && cores.iter().all(|core| *core <= 1023)
        }
        Cores::Granted | Cores::Unpinned => true,
    };
    cores
        && (1..=16).contains(&engine.workers)
        && (0..=20).contains(&engine.depth)
        && (0.0..=1.0).contains(&engine.alpha)
        && (1..=256).contains(&engine.batch)
        && (engine.batch..=4096).contains(&engine.queue)
        && (1..=64).contains(&engine.leaf_size)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn what_is_applied_is_valid_and_written_again_is_the_same(
        first in changes(), second in changes(),
    ) {
        let mut engine = EngineSettings::DEFAULT;
        for change in [first, second] {
            if let Ok(next) = engine.apply(&change) {
                prop_assert!(is_valid(&next), "{change:?} {next:?}");
                // Each value that was written stands there now; cores of None were kept or cut.
                let written = as_written(&next);
                prop_assert!(change.workers.is_none_or(|_| change.workers == written.workers));
                prop_assert!(change.depth.is_none_or(|_| change.depth == written.depth));
                prop_assert!(change.batch.is_none_or(|_| change.batch == written.batch));
                prop_assert!(change.queue.is_none_or(|_| change.queue == written.queue));
                let build = change.build.as_deref().and_then(Build::from_name);
                let written_build = written.build.as_deref();
                prop_assert!(build.is_none_or(|build| Some(build.name()) == written_build));
                prop_assert!(change.cores.is_none() || change.cores == written.cores);
                prop_assert!(change.seed.is_none_or(|_| change.seed == written.seed));
                prop_assert!(change.alpha.is_none_or(|_| change.alpha == written.alpha));
                prop_assert_eq!(next.apply(&written), Ok(next.clone()));
                engine = next;
            }
        }
        prop_assert_eq!(engine.apply(&Overrides::default()), Ok(engine.clone()));
    }

    #[test]
    fn what_is_refused_is_named(change in changes()) {
        if let Err(misfit) = EngineSettings::DEFAULT.apply(&change) {
            prop_assert!(!misfit.remedy.is_empty());
            prop_assert!(misfit.what.contains(misfit.setting), "{}", misfit);
        } else {
            let applied = EngineSettings::DEFAULT.apply(&change);
            prop_assert!(applied.is_ok_and(|engine| is_valid(&engine)));
        }
    }
}

#[test]
fn the_defaults_are_valid() {
    assert!(is_valid(&EngineSettings::DEFAULT));
}

#[test]
fn fewer_workers_take_the_first_of_the_listed_cores() {
    let listed = Overrides { cores: Some(vec![4, 5, 6, 7]), ..Overrides::default() };
    let engine = EngineSettings::DEFAULT.apply(&listed).unwrap();
    let with = |workers| Overrides { workers: Some(workers), ..Overrides::default() };
    assert_eq!(engine.apply(&with(2)).unwrap().cores, Cores::Listed(vec![4, 5]));
    let error = engine.apply(&with(5)).unwrap_err();
    assert_eq!(
        crate::testing::told(error),
        "cores lists 4 of them for 5 workers\n  help: list one core for each worker (a core may \
         stand twice), or none: cores = []"
    );
    let unpinned = Overrides { workers: Some(5), cores: Some(Vec::new()), ..Overrides::default() };
    assert_eq!(engine.apply(&unpinned).unwrap().cores, Cores::Unpinned);
}
