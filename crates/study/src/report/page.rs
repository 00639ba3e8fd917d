//! The markup of a study's page: it fetches nothing, and links to records beside it alone.

use super::Recorded;
use super::figures::{in_words, of_share, percent, points, thousands};
use super::gather::{Gathered, Judged, NOBODY, Regret};
use super::maps;
use crate::knob::SweepKnob;
use crate::plan::Plan;
use crate::seal::short;
use report::{escape, framed};
use std::fmt::Write as _;
use std::path::Path;

/// Candidates listed of each policy.
const LISTED: usize = 4;
/// Inputs whose maps are drawn.
const MAPPED: usize = 12;

const STYLE: &str = ".map text{font-size:11px} .maps{display:flex;flex-wrap:wrap;gap:10px} \
    .map{max-width:100%;height:auto} .key{margin:4px 0 12px} .legend i{display:inline-block;\
    width:.9em;height:.9em;margin:0 4px 0 0;border:1px solid #888;vertical-align:-.1em} \
    .legend b{font-weight:400;display:inline-block;margin-right:12px} \
    td.zero{color:#999} td.wins{min-width:17em} .lead{font-size:1.08rem} \
    .heat td.n{min-width:4.4em} th.r{text-align:right} \
    @media screen and (max-width:800px){table{font-size:.72rem} th,td{padding:3px} \
    td.wins{min-width:11em} .heat td.n{min-width:0}}";

/// The page.
pub(super) fn page(plan: &Plan, gathered: &Gathered, worst: &[Recorded], out: &Path) -> String {
    let judges = judges(plan);
    let mut body = format!(
        "<header><p class=\"asked\">A study of {} scenes</p><h1>{}</h1></header>",
        thousands(gathered.scenes),
        escape(plan.name())
    );
    body += &lead(plan, gathered, &judges);
    let main = principal(plan);
    body += &policies(gathered, &judges, &main);
    body += &differ(gathered, &judges, &main);
    body += &where_they_differ(plan, gathered, &judges, &main);
    body += &flips(plan, gathered, &judges, &main);
    body += &other_curves(plan, gathered);
    body += &regret(gathered, &judges, &main);
    body += &worst_cases(plan, worst, &judges);
    body += &winner_maps(plan, gathered, &judges, &main);
    body += &inputs(plan, gathered);
    body += &made(plan, gathered, out);
    framed(plan.name(), &body, STYLE, "")
}

/// The name of each policy; with curves, where these are not the first set.
fn judges(plan: &Plan) -> Vec<String> {
    let file = plan.file();
    let mut all = Vec::new();
    for policy in &file.policies {
        for (number, curves) in file.curves.iter().enumerate() {
            let curves =
                if number > 0 { format!(", {}", title(&curves.name)) } else { String::new() };
            all.push(format!("{}{curves}", title(&policy.name)));
        }
    }
    all
}

/// A name, or that of a file without its folder and ending.
fn title(name: &str) -> &str {
    let name = name.rsplit('/').next().unwrap_or(name);
    name.strip_suffix(".toml").unwrap_or(name)
}

/// The judges that have the first set of curves.
fn principal(plan: &Plan) -> Vec<usize> {
    let curves = plan.file().curves.len().max(1);
    (0..plan.file().policies.len()).map(|policy| policy * curves).collect()
}

/// What another set of curves changes, policy by policy.
fn other_curves(plan: &Plan, gathered: &Gathered) -> String {
    let file = plan.file();
    let Some((first, others)) = file.curves.split_first().filter(|(_, others)| !others.is_empty())
    else {
        return String::new();
    };
    let mut text = format!(
        "<h2>What another harm model changes</h2><p>The share of scenes in which another manoeuvre \
         wins under the same policy with these curves in place of {}.</p><div class=\"wide\">\
         <table><tr><th>Curves</th>",
        escape(title(&first.name))
    );
    text += &heads(&file.policies.iter().map(|policy| title(&policy.name)).collect::<Vec<_>>());
    text += "</tr>";
    for (number, curves) in (1..).zip(others) {
        let cells = principal(plan)
            .into_iter()
            .map(|judge| cell(&percent(gathered.differ[judge][judge + number], gathered.decided)));
        let cells: String = cells.collect();
        let _w = write!(text, "<tr><td>{}</td>{cells}</tr>", escape(title(&curves.name)));
    }
    text += "</table></div>";
    text
}

fn mean(sum: (f64, u64)) -> Option<f64> {
    (sum.1 > 0).then(|| sum.0 / sum.1 as f64)
}

fn cell(text: &str) -> String {
    let class = if text == "0 %" || text == "0" { "n zero" } else { "n" };
    format!("<td class=\"{class}\">{text}</td>")
}

fn head(words: &[&str]) -> String {
    words.iter().map(|word| format!("<th>{}</th>", escape(word))).collect::<String>()
}

/// The heads of columns of numbers.
fn heads(words: &[&str]) -> String {
    words.iter().map(|word| format!("<th class=\"r\">{}</th>", escape(word))).collect::<String>()
}

fn lead(plan: &Plan, gathered: &Gathered, judges: &[String]) -> String {
    let mut text = String::new();
    let refused: u64 = gathered.judged.iter().map(|judged| judged.refused).sum();
    let answers: u64 = gathered.judged.iter().map(|judged| judged.answers).sum();
    let sets = match plan.file().curves.len() {
        1 => String::new(),
        sets => format!(" with each of {sets} sets of curves"),
    };
    let _w = write!(
        text,
        "<p class=\"lead\">{} scenes under {} policies{sets}: {} answers. In <b>{}</b> of the \
         scenes that all of them decide, at least two policies choose different manoeuvres.",
        thousands(gathered.scenes),
        plan.file().policies.len(),
        thousands(answers),
        percent(gathered.any_differ, gathered.decided)
    );
    let first = &gathered.judged[0];
    let _w = write!(
        text,
        " Under {}, the winner touches nobody in {}, and the model is sure of the first before the \
         second in {}.",
        escape(&judges[0]),
        percent(first.free, first.answers - first.refused),
        percent(first.certain, first.answers - first.refused)
    );
    if let Some(share) = gathered.flip_share(plan, SweepKnob::ErrorSigma, 0) {
        let sweep = plan.file().sweeps.iter().find(|sweep| sweep.knob == SweepKnob::ErrorSigma);
        let step = sweep.and_then(|sweep| Some(sweep.values.get(1)? - sweep.values.first()?));
        let _w = write!(
            text,
            " Where others really are {} σ further from where they are perceived, another \
             manoeuvre wins in {}.",
            maps::number(step.unwrap_or(0.0)),
            of_share(share)
        );
    }
    let refused = match refused {
        0 => "No answer was refused.".to_owned(),
        1 => "1 answer was refused.".to_owned(),
        count => format!("{} answers were refused.", thousands(count)),
    };
    let _w = write!(text, " {refused}</p>");
    if gathered.shards < plan.shards() {
        let _w = write!(
            text,
            "<p class=\"remark\">{} of {} shards are finished; the others are not on this \
             page.</p>",
            thousands(gathered.shards.into()),
            thousands(plan.shards().into())
        );
    }
    text
}

fn policies(gathered: &Gathered, judges: &[String], main: &[usize]) -> String {
    let mut text = "<h2>What each policy chooses, and how sure</h2><div class=\"wide\"><table>\
                    <tr>"
        .to_owned();
    text += &head(&["Policy"]);
    text +=
        &heads(&["touches nobody", "model is sure", "tied with others", "mean harm of the winner"]);
    // As stated nothing is drawn.
    let is_drawn = main.iter().any(|judge| gathered.judged[*judge].best_share.1 > 0);
    if is_drawn {
        text += &heads(&["best in members", "best in worlds"]);
    }
    text += &heads(&["nobody wins"]);
    text += &head(&["wins most often"]);
    text += "</tr>";
    for &judge in main {
        let (name, judged) = (&judges[judge], &gathered.judged[judge]);
        let Judged { answers, refused, .. } = judged;
        let all = answers - refused;
        let harm = mean(judged.harm).map_or("–".to_owned(), of_share);
        let share = |sum: (f64, u64)| mean(sum).map_or("–".to_owned(), of_share);
        let drawn = if is_drawn {
            cell(&share(judged.best_share)) + &cell(&share(judged.worlds_won))
        } else {
            String::new()
        };
        let mut wins: Vec<(&String, &u64)> = judged.wins.iter().collect();
        wins.sort_by_key(|(name, count)| (std::cmp::Reverse(**count), (*name).clone()));
        let wins: Vec<String> = wins
            .into_iter()
            .take(LISTED)
            .map(|(name, count)| format!("{} {}", percent(*count, all), escape(name)))
            .collect();
        let _w = write!(
            text,
            "<tr><td>{}</td>{}{}{}{}{drawn}{}<td class=\"wins\">{}</td></tr>",
            escape(name),
            cell(&percent(judged.free, all)),
            cell(&percent(judged.certain, all)),
            cell(&percent(judged.tied, all)),
            cell(&harm),
            cell(&percent(judged.nobody, all)),
            wins.join("; ")
        );
    }
    text += "</table></div><p class=\"key\">Harm is each policy's own leading measure, so columns \
             of different policies are not compared. \"Touches nobody\" is proven until the \
             horizon. \"Sure\": the ranges of the model do not overlap.</p>";
    text
}

/// The names of some judges.
fn named<'j>(judges: &'j [String], main: &[usize]) -> Vec<&'j str> {
    main.iter().map(|judge| judges[*judge].as_str()).collect()
}

fn differ(gathered: &Gathered, judges: &[String], main: &[usize]) -> String {
    let mut text = "<h2>In how many scenes two policies choose differently</h2>\
                    <div class=\"wide\"><table class=\"heat\"><tr><th></th>"
        .to_owned();
    text += &heads(&named(judges, main));
    text += "</tr>";
    for &a in main {
        let name = &judges[a];
        let cells = main.iter().map(|&b| {
            if a == b {
                cell("–")
            } else {
                cell(&percent(gathered.differ[a][b], gathered.decided))
            }
        });
        let _w = write!(text, "<tr><td>{}</td>{}</tr>", escape(name), cells.collect::<String>());
    }
    text += "</table></div>";
    text
}

fn where_they_differ(
    plan: &Plan,
    gathered: &Gathered,
    judges: &[String],
    main: &[usize],
) -> String {
    let mut text = format!(
        "<h2>Where: scenes in which a policy chooses otherwise than {}</h2><div class=\"wide\">\
         <table><tr><th>Input</th><th class=\"r\">scenes</th>",
        escape(&judges[0])
    );
    text += &heads(&named(judges, &main[1..]));
    text += "</tr>";
    for (number, input) in plan.file().inputs.iter().enumerate() {
        let all = gathered.scenes_by_input[number];
        if all == 0 {
            continue;
        }
        let cells = main[1..]
            .iter()
            .map(|judge| cell(&percent(gathered.differ_by_input[*judge][number], all)));
        let _w = write!(
            text,
            "<tr><td>{}</td>{}{}</tr>",
            escape(&input.name),
            cell(&thousands(all)),
            cells.collect::<String>()
        );
    }
    text += "</table></div>";
    text
}

fn flips(plan: &Plan, gathered: &Gathered, judges: &[String], main: &[usize]) -> String {
    let sweeps = &plan.file().sweeps;
    if sweeps.is_empty() {
        return String::new();
    }
    let mut text = "<h2>What flips the winner</h2><p>The share of neighbouring scenes, one step \
                    apart in one sweep and alike in all else, of which the winners differ.</p>\
                    <div class=\"wide\"><table><tr><th>Sweep</th><th class=\"r\">from</th>\
                    <th class=\"r\">to</th><th class=\"r\">step</th>"
        .to_owned();
    text += &heads(&named(judges, main));
    text += "</tr>";
    for (sweep, along) in sweeps.iter().zip(&gathered.along) {
        let [Some(first), Some(last), Some(second)] =
            [sweep.values.first(), sweep.values.last(), sweep.values.get(1)]
        else {
            continue;
        };
        let cells = main.iter().map(|judge| &along[*judge]);
        let cells = cells.map(|flips| cell(&percent(flips.flips, flips.pairs)));
        let _w = write!(
            text,
            "<tr><td>{}</td>{}{}{}{}</tr>",
            escape(sweep.knob.says()),
            cell(&maps::number(*first)),
            cell(&maps::number(*last)),
            cell(&maps::number(second - first)),
            cells.collect::<String>()
        );
    }
    text += "</table></div>";
    text
}

fn regret(gathered: &Gathered, judges: &[String], main: &[usize]) -> String {
    if gathered.regret.iter().flatten().all(|regret| regret.count == 0) {
        return String::new();
    }
    let mut text = "<h2>Regret: what the choice of one policy costs by the measure of another\
                    </h2><p>Mean over all scenes, and the greatest in brackets, in percentage \
                    points of the measure at the left. A choice can have less than none: a \
                    policy's first rule may rank above its leading measure.</p><div class=\"wide\">\
                    <table class=\"heat\"><tr><th>measured by \\ chosen by</th>"
        .to_owned();
    text += &heads(&named(judges, main));
    text += "</tr>";
    for &a in main {
        let name = &judges[a];
        let cells = main.iter().map(|&b| {
            let Regret { sum, most, count } = gathered.regret[a][b];
            if a == b || count == 0 {
                return cell("–");
            }
            let mean = 100.0 * sum / count as f64;
            if mean == 0.0 && most == 0.0 {
                return cell("0");
            }
            cell(&format!("{} ({})", points(mean, 4), points(100.0 * most, 2)))
        });
        let _w = write!(text, "<tr><td>{}</td>{}</tr>", escape(name), cells.collect::<String>());
    }
    text += "</table></div>";
    text
}

fn worst_cases(plan: &Plan, worst: &[Recorded], judges: &[String]) -> String {
    if worst.is_empty() {
        return String::new();
    }
    let mut text = "<h2>Worst cases</h2><p>Of each input the greatest harm that a policy accepts, \
                    and the greatest regrets between two policies; each with the record of its \
                    decision, which <code>trolley record replay</code> computes again.</p>\
                    <div class=\"wide\"><table><tr>"
        .to_owned();
    text += &head(&["Row", "Scene", "Policy", "chooses", "what is bad", "Record"]);
    text += "</tr>";
    for Recorded { worst, files } in worst {
        let Ok(key) = plan.scene(worst.row / judges.len() as u64) else { continue };
        let values = key.values.iter();
        let values = values.map(|(knob, value)| in_words(*knob, *value));
        let values: Vec<String> = values.collect();
        let bad = match &worst.other {
            None => format!("harm {}", of_share(worst.value)),
            Some((judge, winner)) => format!(
                "{:.2} percentage points more than \"{}\" by the measure of {}",
                100.0 * worst.value,
                escape(winner),
                escape(&judges[*judge])
            ),
        };
        let links = files.iter().map(|file| {
            let what = if file.ends_with(".html") { "scene" } else { "record" };
            format!("<a href=\"{}\">{what}</a> ", escape(file))
        });
        let links: String = links.collect();
        let links = if links.is_empty() { "not the same answer here".to_owned() } else { links };
        let _w = write!(
            text,
            "<tr><td class=\"n\">{}</td><td>{}<br><small>{}</small></td><td>{}</td><td>{}</td>\
             <td>{bad}</td><td>{links}</td></tr>",
            worst.row,
            escape(&plan.file().inputs[key.input].name),
            escape(&values.join(", ")),
            escape(&judges[worst.judge]),
            escape(worst.winner.as_deref().unwrap_or("nobody"))
        );
    }
    text += "</table></div>";
    text
}

fn winner_maps(plan: &Plan, gathered: &Gathered, judges: &[String], main: &[usize]) -> String {
    let Some(axes) = maps::axes(plan) else { return String::new() };
    let others = plan.file().sweeps.iter().enumerate().filter(|(number, _)| !axes.contains(number));
    let others: Vec<String> = others
        .map(|(_, sweep)| {
            let value = sweep.values[maps::given(sweep)];
            in_words(sweep.knob, value)
        })
        .collect();
    let held = if others.is_empty() { String::new() } else { format!(" at {}", others.join(", ")) };
    let mut text = format!(
        "<h2>Who wins where</h2><p>Each cell is one answer{}. White: not finished, refused, or \
         nobody wins. Inputs with one winner alone are left out.</p>",
        escape(&held)
    );
    let mut mapped = 0;
    for (number, input) in plan.file().inputs.iter().enumerate() {
        let all = |judge: usize| maps::cells(plan, gathered, (number, judge), axes);
        let cells: Vec<Vec<Vec<u8>>> = main.iter().copied().map(all).collect();
        let mut used: Vec<u8> = cells.iter().flatten().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        used.retain(|code| *code != NOBODY);
        if used.len() < 2 || mapped >= MAPPED {
            continue;
        }
        mapped += 1;
        let _w = write!(text, "<h3>{}</h3><div class=\"maps\">", escape(&input.name));
        for (name, cells) in named(judges, main).into_iter().zip(&cells) {
            text += &maps::svg(plan, name, cells, axes);
        }
        text += "</div><p class=\"key legend\">";
        for code in used {
            let name = gathered.names[number].get(usize::from(code));
            let _w = write!(
                text,
                "<b><i style=\"background:{}\"></i>{}</b>",
                maps::colour(code),
                escape(name.map_or("", String::as_str))
            );
        }
        text += "</p>";
    }
    text
}

fn inputs(plan: &Plan, gathered: &Gathered) -> String {
    let mut text = "<h2>Inputs</h2><div class=\"wide\"><table><tr>".to_owned();
    text += &head(&["Input", "kind"]);
    text += &heads(&["parties", "candidates"]);
    text += &head(&["refused"]);
    text += "</tr>";
    for input in &plan.file().inputs {
        let _w = write!(
            text,
            "<tr><td>{}</td><td>{}</td>{}{}<td>{}</td></tr>",
            escape(&input.name),
            escape(&input.kind),
            cell(&input.parties.to_string()),
            cell(&input.candidates.to_string()),
            escape(input.refusal.as_deref().unwrap_or(""))
        );
    }
    text += "</table></div>";
    if !gathered.refusals.is_empty() {
        text += "<h3>Why scenes were refused</h3><ul>";
        for (why, count) in gathered.refusals.iter().take(20) {
            let _w = write!(text, "<li>{} × {}</li>", thousands(*count), escape(why));
        }
        text += "</ul>";
    }
    text
}

fn made(plan: &Plan, gathered: &Gathered, out: &Path) -> String {
    let file = plan.file();
    let members = match file.members {
        [1, _] => "as stated (members = 1)".to_owned(),
        [count, most] => format!("{count} members, at most {most}, and {} worlds", file.worlds),
    };
    format!(
        "<h2>How this was made</h2><table class=\"facts\"><tr><td>study</td><td>{}</td></tr>\
         <tr><td>program</td><td>{}</td></tr><tr><td>scenes</td><td>{} of {}, {members}</td></tr>\
         <tr><td>page</td><td>trolley study report {} -o {}</td></tr></table>\
         <details><summary>Specification</summary><pre>{}</pre></details>",
        short(&file.id),
        escape(&file.build),
        thousands(gathered.scenes),
        thousands(plan.scenes()),
        escape(&plan.dir().display().to_string()),
        escape(&out.display().to_string()),
        escape(&file.spec)
    )
}
