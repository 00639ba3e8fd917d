//! How many members it takes: means and orders of fewer members beside those of many.
//!
//! One ranking of many members holds those of fewer, as these are the first of the sequence. What
//! is compared is the policy's leading measure, which under the shipped policy is a mean over
//! persons, so the mean over members of it is that of the ranking.

use crate::progress::{Progress, SyncProgress};
use families::FAMILIES;
use geometry::rng::Rng;
use runtime::clock;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;
use trolley::traffic::{TrafficOptions, import};
use trolley::{Answer, Engine, Failure, Limits, References, Scenario};

mod families;

/// Numbers of members that are compared.
const COUNTS: [usize; 6] = [8, 16, 32, 64, 128, 256];
/// Stands for the number that a ranking itself comes to, which doubles where the best are close.
const BY_RULE: usize = 0;
/// How many the reference has.
const MANY: u32 = 512;
/// Candidates whose expected harms differ by less than this share are not told apart.
const APART: f64 = 0.1;
/// The number of members whose cost is measured, and whose orders are judged.
const USUAL: usize = 32;
/// Rankings of which a time is the median.
const TIMES: usize = 3;

/// What to measure.
#[derive(Clone, Debug)]
pub struct MembersOptions {
    /// Recordings and scenarios, each a family of its own.
    pub files: Vec<PathBuf>,
    /// Scenes of each generated family.
    pub scenes: u32,
    /// Seed of the generated scenes.
    pub seed: u64,
}

/// One number of members.
#[derive(Clone, Debug, Default, Serialize)]
pub struct CountRow {
    /// How many; 1: the scene as stated; 0: as many as a ranking takes.
    pub members: usize,
    /// Pairs of candidates that the reference tells apart.
    pub pairs: u32,
    /// Those of them.
    pub wrong: WrongPairs,
    /// Pairs whose order the reference knows: their difference is more than twice its own sampling
    /// error.
    pub known_pairs: u32,
    /// Those of them.
    pub known_wrong: WrongPairs,
    /// Root mean square of the relative errors of expected harm, per cent.
    pub error_percent: f64,
    /// How much more harm the chosen candidates have than the best, of that of the best, per cent.
    pub regret_percent: f64,
    /// Scenes with another winner.
    pub other_winners: u32,
    /// Those of them whose winners differ by less than the printed sampling error.
    pub within_error: u32,
}

/// Pairs of candidates that do not come out in the order of the reference.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct WrongPairs {
    /// In the other order.
    pub misordered: u32,
    /// Equal: most often, nobody is met by either.
    pub equal: u32,
}

impl WrongPairs {
    /// One pair, by how much one candidate is worse than the other by the reference, and as seen.
    fn of(truth: f64, seen: f64) -> Self {
        Self {
            misordered: u32::from(truth * seen < 0.0),
            equal: u32::from(truth != 0.0 && seen == 0.0),
        }
    }

    fn add(&mut self, other: Self) {
        self.misordered += other.misordered;
        self.equal += other.equal;
    }
}

/// One family of scenes.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FamilyRow {
    /// Its name.
    pub name: String,
    /// How many scenes were ranked.
    pub scenes: u32,
    /// Pairs that are told apart.
    pub pairs: u32,
    /// Those of them as stated, and with 32 members.
    pub wrong: [WrongPairs; 2],
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct MembersReport {
    schema: &'static str,
    seed: u64,
    many: u32,
    families: Vec<FamilyRow>,
    counts: Vec<CountRow>,
    /// How much longer 32 members take than the scene as stated: least, median, most.
    cost: [f64; 3],
    /// What worlds take, of the time of the geometry with 32 members, per cent: the median.
    worlds_percent: f64,
    /// Scenes that could not be ranked, and why.
    left_out: Vec<String>,
}

/// Expected harm by candidate.
struct Found {
    /// As stated.
    stated: Vec<f64>,
    /// By candidate and member.
    members: Vec<Vec<f64>>,
    /// How many a ranking takes.
    by_rule: usize,
    cost: f64,
    worlds: f64,
}

/// Measures. `told` is called with the scenes done.
///
/// # Errors
///
/// If a file cannot be read. A scene that cannot be ranked is left out, and named.
pub fn members(options: &MembersOptions, told: SyncProgress<'_>) -> Result<MembersReport, Failure> {
    let mut families: Vec<(String, Vec<Scenario>)> = Vec::new();
    for (number, (name, text)) in FAMILIES.into_iter().enumerate() {
        let mut rng = Rng::new(options.seed ^ ((number as u64) << 32));
        let scenes = (0..options.scenes).map(|_| Scenario::parse(name, &text(&mut rng)));
        families.push((name.to_owned(), scenes.collect::<Result<_, _>>()?));
    }
    for path in &options.files {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let scenario = if trolley::traffic::is_traffic(path) {
            let text = import(path, &TrafficOptions::default())?.text;
            Scenario::parse_with(&name, &text, References::Anywhere)?
        } else {
            Scenario::open(path)?
        };
        families.push((name, vec![scenario.assuming_unknown_is_fixed()]));
    }
    let total = families.iter().map(|(_, scenes)| scenes.len() as u64).sum();
    let bar = Progress::new(total, told);
    let mut tally = Tally::default();
    for (name, scenes) in families {
        tally.families.push(FamilyRow { name: name.clone(), ..FamilyRow::default() });
        for scenario in scenes {
            match found(&scenario) {
                Ok(found) => tally.add(&found),
                Err(failure) => tally.left_out.push(format!("{name}: {failure}")),
            }
            bar.add(1);
        }
    }
    Ok(tally.report(options.seed))
}

/// Ranks a scene as stated, with the usual number of members, and with many.
fn found(scenario: &Scenario) -> Result<Found, Failure> {
    let mut engine = Engine::builder().in_process().build()?;
    // Bodies are loaded, and what is kept of them is known, before anything is timed.
    for _ in 0..2 {
        engine.rank(scenario, &Limits::default().with_members(1, None)?)?;
    }
    let mut timed = |count: i64, times: usize| -> Result<_, Failure> {
        let limits = Limits::default().with_members(count, Some(count))?;
        let mut took_ns = Vec::with_capacity(times);
        loop {
            let begun_ns = clock::now_ns();
            let ranking = engine.rank(scenario, &limits)?;
            took_ns.push((clock::now_ns() - begun_ns) as f64);
            if took_ns.len() >= times {
                return Ok((ranking, middle(&mut took_ns)));
            }
        }
    };
    let (stated, one_ns) = timed(1, TIMES)?;
    let (usual, usual_ns) = timed(USUAL as i64, TIMES)?;
    let (many, _) = timed(i64::from(MANY), 1)?;
    let ranking = engine.rank(scenario, &Limits::default().with_members(USUAL as i64, None)?)?;
    let by_rule = ranking.answer.members.map_or(1, |members| members.count as usize);
    let stages = &usual.run.stages;
    let by_name = |answer: &Answer| {
        let mut rows: Vec<_> = answer.ranking.clone();
        rows.sort_by(|a, b| a.name.cmp(&b.name));
        rows
    };
    let harms = by_name(&many.answer).into_iter().map(|row| {
        let members = row.expected.map_or(Vec::new(), |of| of.members);
        members.into_iter().map(|member| member.harm).collect()
    });
    Ok(Found {
        stated: by_name(&stated.answer).iter().map(|row| row.work.hi()).collect(),
        members: harms.collect(),
        by_rule,
        cost: (usual_ns - stages.worlds_ms * 1e6) / one_ns,
        worlds: stages.worlds_ms / (stages.plan_ms + stages.work_ms),
    })
}

fn mean(of: &[f64]) -> f64 {
    of.iter().sum::<f64>() / of.len() as f64
}

/// The upper median, 0 of nothing; leaves them sorted.
fn middle(of: &mut [f64]) -> f64 {
    of.sort_by(f64::total_cmp);
    of.get(of.len() / 2).copied().unwrap_or(0.0)
}

/// The number of the least; the first of equals.
fn least(of: &[f64]) -> usize {
    (0..of.len()).min_by(|a, b| of[*a].total_cmp(&of[*b])).unwrap_or(0)
}

/// What scenes come to.
#[derive(Default)]
struct Tally {
    families: Vec<FamilyRow>,
    rows: Vec<CountRow>,
    /// By number of members: squares of relative errors, how many, regret, harm of the best.
    sums: Vec<(f64, u32, f64, f64)>,
    costs: Vec<f64>,
    worlds: Vec<f64>,
    left_out: Vec<String>,
}

impl Tally {
    fn add(&mut self, found: &Found) {
        if self.rows.is_empty() {
            let counts = core::iter::once(1).chain(COUNTS).chain([BY_RULE]);
            self.rows = counts.map(|members| CountRow { members, ..CountRow::default() }).collect();
            self.sums = vec![(0.0, 0, 0.0, 0.0); self.rows.len()];
        }
        self.costs.push(found.cost);
        self.worlds.push(found.worlds);
        let truth: Vec<f64> = found.members.iter().map(|all| mean(all)).collect();
        let best = least(&truth);
        let told_apart = told_apart(found, &truth);
        let Some(family) = self.families.last_mut() else { return };
        family.scenes += 1;
        for (row, sums) in self.rows.iter_mut().zip(&mut self.sums) {
            let count = if row.members == BY_RULE { found.by_rule } else { row.members };
            let seen: Vec<f64> = match count {
                1 => found.stated.clone(),
                _ => found.members.iter().map(|all| mean(&all[..count])).collect(),
            };
            let mut wrong = WrongPairs::default();
            for (i, j, is_known) in &told_apart {
                let one = WrongPairs::of(truth[*i] - truth[*j], seen[*i] - seen[*j]);
                wrong.add(one);
                if *is_known {
                    row.known_pairs += 1;
                    row.known_wrong.add(one);
                }
            }
            row.pairs += told_apart.len() as u32;
            row.wrong.add(wrong);
            match row.members {
                1 => {
                    family.pairs += told_apart.len() as u32;
                    family.wrong[0].add(wrong);
                }
                USUAL => family.wrong[1].add(wrong),
                _ => {}
            }
            for (seen, truth) in seen.iter().zip(&truth).filter(|(_, truth)| **truth > 0.0) {
                sums.0 += (seen / truth - 1.0) * (seen / truth - 1.0);
                sums.1 += 1;
            }
            let winner = least(&seen);
            sums.2 += truth[winner] - truth[best];
            sums.3 += truth[best];
            if truth[winner] > truth[best] {
                row.other_winners += 1;
                let error = if count == 1 { 0.0 } else { paired(found, [winner, best], count) };
                row.within_error += u32::from(truth[winner] - truth[best] < error);
            }
        }
    }

    fn report(mut self, seed: u64) -> MembersReport {
        for (row, (squares, count, regret, harm)) in self.rows.iter_mut().zip(&self.sums) {
            row.error_percent = 100.0 * (squares / f64::from(*count).max(1.0)).sqrt();
            row.regret_percent = if *harm > 0.0 { 100.0 * regret / harm } else { 0.0 };
        }
        let median = middle(&mut self.costs);
        let ends = [self.costs.first(), self.costs.last()].map(|end| end.copied().unwrap_or(0.0));
        MembersReport {
            schema: "trolley.certify-members/3",
            seed,
            many: MANY,
            families: self.families,
            counts: self.rows,
            cost: [ends[0], median, ends[1]],
            worlds_percent: 100.0 * middle(&mut self.worlds),
            left_out: self.left_out,
        }
    }
}

/// Pairs of candidates that differ by enough, and whether the reference knows their order.
fn told_apart(found: &Found, truth: &[f64]) -> Vec<(usize, usize, bool)> {
    let all = (0..truth.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let pair = |(i, j): (usize, usize)| {
        let apart = (truth[i] - truth[j]).abs();
        let is_known = apart > 2.0 * paired(found, [i, j], found.members[i].len());
        (apart > APART * truth[i].max(truth[j])).then_some((i, j, is_known))
    };
    all.filter_map(pair).collect()
}

/// The sampling error of the difference of two candidates, over so many members.
fn paired(found: &Found, [a, b]: [usize; 2], count: usize) -> f64 {
    let pairs = found.members[a][..count].iter().zip(&found.members[b][..count]);
    let apart: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
    let middle = mean(&apart);
    let squares: f64 = apart.iter().map(|x| (x - middle) * (x - middle)).sum();
    (squares / (count as f64 - 1.0) / count as f64).sqrt()
}

impl MembersReport {
    /// Whether, with 32 members, at most 2 % of the pairs are misordered, and in at least 95 % of
    /// the scenes a ranking that chooses its number of members has the winner of the reference, or
    /// one that differs from it by less than the sampling error.
    #[must_use]
    pub fn is_right(&self) -> bool {
        let row = |members: usize| self.counts.iter().find(|row| row.members == members);
        let scenes: u32 = self.families.iter().map(|family| family.scenes).sum();
        let (Some(usual), Some(by_rule)) = (row(USUAL), row(BY_RULE)) else { return false };
        let beyond_error = by_rule.other_winners - by_rule.within_error;
        f64::from(usual.wrong.misordered) <= 0.02 * f64::from(usual.pairs)
            && f64::from(beyond_error) <= 0.05 * f64::from(scenes)
    }

    /// The report as tables of Markdown, which read as text, too.
    #[must_use]
    pub fn text(&self) -> String {
        let scenes: u32 = self.families.iter().map(|family| family.scenes).sum();
        let mut text = format!(
            "{scenes} scenes of {} families, seed {}; truth is the mean over {} members, and pairs \
             count that differ by more than {:.0} %.\n\n",
            self.families.len(),
            self.seed,
            self.many,
            100.0 * APART
        );
        // Writing to a string cannot fail.
        let _w = writeln!(
            text,
            "| members | misordered | % | equal | % | of pairs | misordered | equal | of those in \
             known order | rms error % | regret % | other winner | within error |\n|{}",
            "--:|".repeat(13)
        );
        for row in &self.counts {
            let share = |of: u32| 100.0 * f64::from(of) / f64::from(row.pairs.max(1));
            let name = match row.members {
                1 => "as stated".to_owned(),
                BY_RULE => format!("{USUAL} or more, by the rule"),
                count => count.to_string(),
            };
            let (wrong, known) = (&row.wrong, &row.known_wrong);
            let _w = writeln!(
                text,
                "| {name} | {} | {:.1} | {} | {:.1} | {} | {} | {} | {} | {:.0} | {:.2} | {} | \
                 {} |",
                wrong.misordered,
                share(wrong.misordered),
                wrong.equal,
                share(wrong.equal),
                row.pairs,
                known.misordered,
                known.equal,
                row.known_pairs,
                row.error_percent,
                row.regret_percent,
                row.other_winners,
                row.within_error
            );
        }
        let [low, median, high] = self.cost;
        let _w = writeln!(
            text,
            "\n{USUAL} members take {median:.1} times what the scene as stated takes ({low:.1} to \
             {high:.1}), in this process. 200 worlds take {:.0} % of the time of their geometry.\n",
            self.worlds_percent
        );
        let _w = writeln!(
            text,
            "| family | scenes | pairs | misordered as stated | equal | with {USUAL} | equal |\n\
             |---|--:|--:|--:|--:|--:|--:|"
        );
        for family in &self.families {
            let [stated, usual] = &family.wrong;
            let _w = writeln!(
                text,
                "| {} | {} | {} | {} | {} | {} | {} |",
                family.name,
                family.scenes,
                family.pairs,
                stated.misordered,
                stated.equal,
                usual.misordered,
                usual.equal
            );
        }
        if !self.left_out.is_empty() {
            let _w = writeln!(text, "\nNot ranked: {}.", self.left_out.join("; "));
        }
        text
    }
}
