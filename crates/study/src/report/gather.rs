//! What a page says, counted over the tables of all finished shards.
//!
//! Memory: a byte for each answer (who wins), counts, and the worst few. The measure of every
//! candidate is held for one scene at a time.

use crate::knob::SweepKnob;
use crate::plan::Plan;
use crate::seal;
use columns::{ReadColumn, read};
use runtime::InputKind;
use std::collections::BTreeMap;
use std::path::Path;
use trolley::Failure;

/// Who wins where nobody does, or nothing is known.
pub(super) const NOBODY: u8 = u8::MAX;
/// How many worst cases there are of each kind.
const WORST: usize = 6;

/// Counts of one policy with one set of curves.
#[derive(Clone, Debug, Default)]
pub(super) struct Judged {
    pub(super) answers: u64,
    pub(super) refused: u64,
    pub(super) nobody: u64,
    /// The winner touches nobody, proven.
    pub(super) free: u64,
    /// The model is sure of the first before the second.
    pub(super) certain: u64,
    /// There are candidates that the model cannot tell from the first.
    pub(super) tied: u64,
    pub(super) complete: u64,
    /// Sum of the winners' measures, and how many there are.
    pub(super) harm: (f64, u64),
    /// Sums of what members and worlds say, and how many there are.
    pub(super) best_share: (f64, u64),
    pub(super) worlds_won: (f64, u64),
    /// How often each candidate wins, by name.
    pub(super) wins: BTreeMap<String, u64>,
}

/// How a candidate fares that another policy chose: sum, greatest, and count of regrets.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Regret {
    pub(super) sum: f64,
    pub(super) most: f64,
    pub(super) count: u64,
}

/// Flips along a sweep, of one judge.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Flips {
    pub(super) flips: u64,
    pub(super) pairs: u64,
}

/// An answer that people should look at.
#[derive(Clone, Debug)]
pub(super) struct Worst {
    pub(super) row: u64,
    pub(super) judge: usize,
    pub(super) winner: Option<String>,
    /// Of what it is the worst: "harm", or "regret".
    pub(super) why: &'static str,
    pub(super) value: f64,
    /// Under which judge's measure, and whom that judge chooses.
    pub(super) other: Option<(usize, String)>,
}

/// All that a page says.
pub(super) struct Gathered {
    pub(super) scenes: u64,
    pub(super) shards: u32,
    /// Sets of curves, which vary fastest.
    curves: usize,
    /// Per judge: policies, curves varying fastest.
    pub(super) judged: Vec<Judged>,
    /// Per pair of judges: in how many scenes their winners differ.
    pub(super) differ: Vec<Vec<u64>>,
    /// Per judge and input: in how many scenes its winner is not that of the first judge.
    pub(super) differ_by_input: Vec<Vec<u64>>,
    /// Scenes per input that all judges decide.
    pub(super) scenes_by_input: Vec<u64>,
    /// Scenes in which any two judges' winners differ.
    pub(super) any_differ: u64,
    pub(super) decided: u64,
    /// Per judge of measure, and per judge that chooses.
    pub(super) regret: Vec<Vec<Regret>>,
    /// Per sweep, then judge.
    pub(super) along: Vec<Vec<Flips>>,
    /// Names of candidates by their number, per input.
    pub(super) names: Vec<Vec<String>>,
    /// The number of who wins, per row of `answers`.
    pub(super) winners: Vec<u8>,
    /// Reasons of refusals, and how often.
    pub(super) refusals: BTreeMap<String, u64>,
    worst_harm: BTreeMap<usize, Vec<Worst>>,
    worst_regret: Vec<Worst>,
}

/// A scene while it is read: its input, and per judge the winner and every candidate's measure.
struct OpenScene {
    scene: u64,
    input: usize,
    winners: Vec<Option<String>>,
    measures: Vec<BTreeMap<String, f64>>,
}

impl Gathered {
    pub(super) fn new(plan: &Plan) -> Self {
        let (judges, inputs) = (plan.answers_per_scene() as usize, plan.file().inputs.len());
        Self {
            scenes: 0,
            shards: 0,
            curves: plan.file().curves.len().max(1),
            judged: vec![Judged::default(); judges],
            differ: vec![vec![0; judges]; judges],
            differ_by_input: vec![vec![0; inputs]; judges],
            scenes_by_input: vec![0; inputs],
            any_differ: 0,
            decided: 0,
            regret: vec![vec![Regret::default(); judges]; judges],
            along: vec![vec![Flips::default(); judges]; plan.file().sweeps.len()],
            names: vec![Vec::new(); inputs],
            winners: vec![NOBODY; plan.answers() as usize],
            refusals: BTreeMap::new(),
            worst_harm: BTreeMap::new(),
            worst_regret: Vec::new(),
        }
    }

    /// Counts one finished shard.
    pub(super) fn add(&mut self, plan: &Plan, shard: u32) -> Result<(), Failure> {
        let folder = seal::folder(plan.dir(), shard);
        let mut measures = measures(&folder)?;
        let [row, input, winner, refusal, state, is_certain] = table(
            &folder,
            "answers",
            ["row", "input", "winner", "refusal", "state", "is_certain"],
        )?;
        let [is_free, tied, work_hi, best_share, worlds_won] = table(
            &folder,
            "answers",
            ["touches_nobody", "tied", "work_hi", "best_share", "worlds_won"],
        )?;
        let judges = self.judged.len() as u64;
        let mut open: Option<OpenScene> = None;
        for at in 0..row.rows() {
            let (number, input) = (whole(&row, at), whole(&input, at) as usize);
            let (scene, judge) = (number / judges, (number % judges) as usize);
            if open.as_ref().is_none_or(|open| open.scene != scene) {
                self.close(open.take());
                let judges = self.judged.len();
                open = Some(OpenScene {
                    scene,
                    input,
                    winners: vec![None; judges],
                    measures: vec![BTreeMap::new(); judges],
                });
            }
            let one = &mut self.judged[judge];
            one.answers += 1;
            if let Some(why) = refusal.text(at) {
                one.refused += 1;
                *self.refusals.entry(why.to_owned()).or_default() += 1;
                continue;
            }
            one.complete += u64::from(state.text(at) == Some("complete"));
            one.certain += u64::from(is_certain.flag(at) == Some(true));
            one.free += u64::from(is_free.flag(at) == Some(true));
            one.tied += u64::from(tied.whole(at).is_some_and(|tied| tied > 1));
            add(&mut one.best_share, best_share.real(at));
            add(&mut one.worlds_won, worlds_won.real(at));
            let Some(winner) = winner.text(at) else {
                one.nobody += 1;
                continue;
            };
            *one.wins.entry(winner.to_owned()).or_default() += 1;
            add(&mut one.harm, work_hi.real(at));
            let names = &mut self.names[input];
            let code = names.iter().position(|name| name == winner).unwrap_or_else(|| {
                names.push(winner.to_owned());
                names.len() - 1
            });
            self.winners[number as usize] = u8::try_from(code).unwrap_or(NOBODY);
            if let Some(open) = &mut open {
                open.winners[judge] = Some(winner.to_owned());
                open.measures[judge] = measures.remove(&number).unwrap_or_default();
            }
            let value = work_hi.real(at).unwrap_or(0.0);
            let worst = Worst {
                row: number,
                judge,
                winner: Some(winner.to_owned()),
                why: "harm",
                value,
                other: None,
            };
            retain_worst(self.worst_harm.entry(input).or_default(), worst, 1);
        }
        self.close(open);
        self.shards += 1;
        Ok(())
    }

    /// Counts what one scene says of several judges together.
    fn close(&mut self, open: Option<OpenScene>) {
        let Some(open) = open else { return };
        self.scenes += 1;
        let judges = self.judged.len();
        if open.winners.iter().any(Option::is_none) {
            return;
        }
        self.decided += 1;
        self.scenes_by_input[open.input] += 1;
        // Policies alone: with the first set of curves.
        let mut main = open.winners.iter().step_by(self.curves);
        self.any_differ += u64::from(main.any(|winner| *winner != open.winners[0]));
        for a in 0..judges {
            let is_main = a % self.curves == 0;
            if open.winners[a] != open.winners[0] {
                self.differ_by_input[a][open.input] += 1;
            }
            for b in 0..judges {
                self.differ[a][b] += u64::from(open.winners[a] != open.winners[b]);
                if is_main && b % self.curves == 0 {
                    self.regret(&open, a, b);
                }
            }
        }
    }

    /// What the choice of judge `b` costs under the measure of judge `a`.
    fn regret(&mut self, open: &OpenScene, a: usize, b: usize) {
        let measure = |judge: usize| {
            let winner = open.winners[judge].as_ref()?;
            open.measures[a].get(winner).copied()
        };
        let (Some(own), Some(others)) = (measure(a), measure(b)) else { return };
        let regret = others - own;
        let sum = &mut self.regret[a][b];
        sum.sum += regret;
        sum.most = sum.most.max(regret);
        sum.count += 1;
        if regret > 0.0 {
            let worst = Worst {
                row: open.scene * self.judged.len() as u64 + b as u64,
                judge: b,
                winner: open.winners[b].clone(),
                why: "regret",
                value: regret,
                other: open.winners[a].clone().map(|winner| (a, winner)),
            };
            retain_worst(&mut self.worst_regret, worst, 64);
        }
    }

    /// Counts flips between neighbours along each sweep.
    pub(super) fn finish(&mut self, plan: &Plan) {
        let judges = self.judged.len();
        let sweeps = &plan.file().sweeps;
        for (number, sweep) in sweeps.iter().enumerate() {
            let count = sweep.values.len() as u64;
            let stride: u64 =
                sweeps[number + 1..].iter().map(|it| it.values.len() as u64).product();
            for scene in 0..plan.scenes() {
                if (scene / stride) % count + 1 == count {
                    continue;
                }
                for judge in 0..judges {
                    let place = |scene: u64| scene as usize * judges + judge;
                    let here = self.winners[place(scene)];
                    let next = self.winners[place(scene + stride)];
                    if here != NOBODY && next != NOBODY {
                        let flips = &mut self.along[number][judge];
                        flips.pairs += 1;
                        flips.flips += u64::from(here != next);
                    }
                }
            }
        }
    }

    /// The worst cases: of each input the greatest harm that a policy chose, and the greatest
    /// regrets, of each pair of judges one.
    pub(super) fn worst(&self) -> Vec<Worst> {
        let mut all: Vec<Worst> = Vec::new();
        let mut harm: Vec<&Worst> = self.worst_harm.values().flatten().collect();
        harm.sort_by(|a, b| b.value.total_cmp(&a.value));
        all.extend(harm.into_iter().filter(|worst| worst.value > 0.0).take(WORST).cloned());
        let mut pairs: Vec<(usize, Option<usize>)> = Vec::new();
        for worst in &self.worst_regret {
            let pair = (worst.judge, worst.other.as_ref().map(|(judge, _)| *judge));
            if !pairs.contains(&pair) && pairs.len() < WORST {
                pairs.push(pair);
                all.push(worst.clone());
            }
        }
        all
    }

    /// The share of pairs of scenes one step apart in which the winner flips, of one judge.
    pub(super) fn flip_share(&self, plan: &Plan, knob: SweepKnob, judge: usize) -> Option<f64> {
        let number = plan.file().sweeps.iter().position(|sweep| sweep.knob == knob)?;
        let Flips { flips, pairs } = self.along[number][judge];
        (pairs > 0).then(|| flips as f64 / pairs as f64)
    }
}

/// Keeps the greatest few of a kind, the greatest first; equal ones in the order of their rows.
fn retain_worst(list: &mut Vec<Worst>, worst: Worst, most: usize) {
    if list.len() >= most && list.last().is_some_and(|last| last.value >= worst.value) {
        return;
    }
    // Of each pair of judges one is enough.
    let key = |worst: &Worst| (worst.judge, worst.other.as_ref().map(|(judge, _)| *judge));
    if worst.why == "regret" {
        let same = list.iter().position(|known| key(known) == key(&worst));
        if let Some(same) = same {
            if list[same].value >= worst.value {
                return;
            }
            list.remove(same);
        }
    }
    let place = list.partition_point(|known| known.value >= worst.value);
    list.insert(place, worst);
    list.truncate(most);
}

fn add(sum: &mut (f64, u64), value: Option<f64>) {
    if let Some(value) = value {
        sum.0 += value;
        sum.1 += 1;
    }
}

fn whole(column: &ReadColumn, row: usize) -> u64 {
    column.whole(row).and_then(|number| u64::try_from(number).ok()).unwrap_or(0)
}

/// Columns of a table of a shard.
fn table<const N: usize>(
    folder: &Path,
    name: &str,
    columns: [&str; N],
) -> Result<[ReadColumn; N], Failure> {
    let path = folder.join(format!("{name}.parquet"));
    let (file, _) = runtime::input::open(&path, InputKind::Model)?;
    read(file, columns).map_err(|failure| failure.at(path.display()))
}

/// The measure of every candidate, per row of `answers`.
fn measures(folder: &Path) -> Result<BTreeMap<u64, BTreeMap<String, f64>>, Failure> {
    let [row, candidate, work] = table(folder, "candidates", ["row", "candidate", "work_hi"])?;
    let mut all: BTreeMap<u64, BTreeMap<String, f64>> = BTreeMap::new();
    for at in 0..row.rows() {
        if let (Some(name), Some(value)) = (candidate.text(at), work.real(at)) {
            all.entry(whole(&row, at)).or_default().insert(name.to_owned(), value);
        }
    }
    Ok(all)
}
