//! The page: a table per scene, why the first is first, and where others would say otherwise.

use super::Ranked;
use super::cases::Alternative;
use super::picture::Picture;
use super::rivals::{self, Formula};
use serde_json::Value;
use std::fmt::Write as _;

const HEAD: &str = "\
# Alternatives from recorded traffic, ranked with real bodies

Written by `cargo x scenarios`. Poses and speeds are first contacts of an ego box that was swept
along braked and steered arcs through recorded traffic (CommonRoad); bodies are public meshes,
chosen by type and scaled to the stated length and width. Both are other people's data, and not part
of this project. Everything is ranked by the default policy, a placeholder, so the orders below are
examples of the method, not verdicts.

*boxes*: the stated rectangles overlap within 1 m of the given pose. *formula*: the harm formula of
TUM from its published coefficients, mean over one person on either side, and its rank; it takes the
whole closing speed, no lever arms, and is not zero at speed zero. *v_n*: the share of the closing
speed along the contact normal. harm: mean risk of MAIS3+ over all persons at stake in the scene.
";

struct Line<'a> {
    row: &'a Value,
    chain: &'a Value,
    alternative: &'a Alternative,
    formula: Formula,
    formula_rank: usize,
}

pub(crate) fn page(
    ranked: &[Ranked],
    pictures: &[Picture],
    folder: &str,
    machine: &[(&'static str, String)],
) -> String {
    let mut text = HEAD.to_owned();
    let mut boxes_only = 0;
    let mut differ = 0;
    let mut sections = String::new();
    for one in ranked {
        let lines = lines(one);
        let first_of_formula = lines.iter().position(|line| line.formula_rank == 1);
        differ += usize::from(lines.len() > 1 && first_of_formula != Some(0));
        boxes_only += lines.iter().filter(|line| is_boxes_only(line)).count();
        section(&mut sections, one, &lines);
    }
    let several = ranked.iter().filter(|one| one.scene.alternatives.len() > 1).count();
    let _w = writeln!(
        text,
        "\n{several} of {} scenes leave two or more alternatives. In {differ} of them the formula \
         puts another one first. {boxes_only} alternatives that boxes call a crash touch nothing.",
        ranked.len()
    );
    for picture in pictures {
        let _w = writeln!(
            text,
            "\n![{}]({folder}/{})\n\n{}",
            picture.caption, picture.file, picture.caption
        );
    }
    text.push_str(&sections);
    let facts: Vec<String> = machine.iter().map(|(key, value)| format!("{key}: {value}")).collect();
    let _w = writeln!(text, "\nMade on: {}.", facts.join("; "));
    text
}

fn is_boxes_only(line: &Line<'_>) -> bool {
    line.row["contact"]["touch"] == "no" && rivals::boxes_crash(line.alternative)
}

fn lines(one: &Ranked) -> Vec<Line<'_>> {
    let rows = one.document["answer"]["ranking"].as_array().into_iter().flatten();
    let chains = one.document["explanation"]["chains"].as_array().into_iter().flatten();
    let mut lines: Vec<Line<'_>> = rows
        .zip(chains)
        .filter_map(|(row, chain)| {
            let mut all = one.scene.alternatives.iter();
            let alternative = all.find(|a| row["name"] == a.name.as_str())?;
            let formula = rivals::formula(alternative);
            Some(Line { row, chain, alternative, formula, formula_rank: 0 })
        })
        .collect();
    let means: Vec<f64> = lines.iter().map(|line| line.formula.mean()).collect();
    for (line, mean) in lines.iter_mut().zip(&means) {
        line.formula_rank = 1 + means.iter().filter(|other| *other < mean).count();
    }
    lines
}

fn section(text: &mut String, one: &Ranked, lines: &[Line<'_>]) {
    let _w = writeln!(text, "\n## {}\n", one.scene.name);
    if one.scene.by_hand {
        text.push_str("Poses read off the recording by hand, step 55.\n\n");
    }
    if let Some(refusal) = &one.refusal {
        let _w = writeln!(text, "Refused as it is: {refusal}. With `--assume unknown=fixed`:\n");
    }
    text.push_str(
        "| # | alternative | other | contact | depth m | v_n | ΔV ego / other m/s | worst-off | \
         harm % | range % | boxes | formula % (rank) |\n\
         |--:|---|---|---|--:|--:|--:|---|--:|--:|---|--:|\n",
    );
    for (at, line) in lines.iter().enumerate() {
        let _w = writeln!(text, "{}", table_row(at + 1, line));
    }
    let answer = &one.document["answer"];
    for assumed in answer["assumptions"].as_array().into_iter().flatten() {
        let _w = writeln!(text, "\nAssumed: {}.", assumed.as_str().unwrap_or_default());
    }
    for line in lines {
        if let Some(why) = line.row["why"].as_str() {
            let _w = writeln!(text, "\n- {why}.");
        }
    }
    check_by_hand(text, lines);
    differences(text, lines);
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(0.0)
}

fn percent(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{:.2}", 100.0 * value) }
}

/// The share of the closing speed along the normal.
fn share(chain: &Value) -> f64 {
    number(&chain["normal_m_s"]) / number(&chain["closing_m_s"]).max(1e-9)
}

fn table_row(rank: usize, line: &Line<'_>) -> String {
    let (row, chain) = (line.row, line.chain);
    let touches = row["contact"]["touch"] == "yes";
    let persons = row["persons"].as_array().into_iter().flatten();
    let worst = persons.max_by(|a, b| number(&a["work"][1]).total_cmp(&number(&b["work"][1])));
    let worst = worst.filter(|_| touches).map_or("–".to_owned(), |person| {
        let seat = person["seat"].as_str().map_or(String::new(), |seat| format!(" {seat}"));
        let party = person["party"].as_str().unwrap_or_default();
        format!("{party}{seat} {} %", percent(number(&person["work"][1])))
    });
    let contact = match row["contact"]["touch"].as_str() {
        Some("yes") => row["sides"].as_str().unwrap_or_default().to_owned(),
        Some("no") if number(&row["contact"]["hull_gap_m"]) > 0.0 => {
            format!("none, {:.2} m", number(&row["contact"]["hull_gap_m"]))
        }
        Some("no") => "none".to_owned(),
        _ => match row["unevaluable"].as_str() {
            Some(why) => why.to_owned(),
            None => "unknown".to_owned(),
        },
    };
    let dv = |i: usize| number(&row["delta_v_m_s"][i]["work"][1]);
    let or_dash = |text: String| if touches { text } else { "–".to_owned() };
    format!(
        "| {rank} | {} | {} | {contact} | {} | {} | {} | {worst} | {} | {}–{} | {} | {} ({}) |",
        line.alternative.name,
        line.alternative.party,
        or_dash(format!("{:.2}", number(&row["contact"]["patch"]["depth_m"][1]))),
        or_dash(format!("{:.0} %", 100.0 * share(chain))),
        or_dash(if row["is_other_fixed"] == true {
            format!("{:.2} / –", dv(0))
        } else {
            format!("{:.2} / {:.2}", dv(0), dv(1))
        }),
        percent(number(&row["work"][1])),
        percent(number(&row["range"][0])),
        percent(number(&row["range"][1])),
        if rivals::boxes_crash(line.alternative) { "crash" } else { "none" },
        percent(line.formula.mean()),
        line.formula_rank
    )
}

/// The first alternative with a contact, in the figures that a pocket calculator needs.
fn check_by_hand(text: &mut String, lines: &[Line<'_>]) {
    let Some(line) = lines.iter().find(|line| line.row["contact"]["touch"] == "yes") else {
        return;
    };
    let chain = line.chain;
    // What is fixed to the ground has none of these.
    let both = |of: &dyn Fn(usize) -> f64| {
        let figure = |i: usize| match chain["mass_kg"][i].is_null() {
            true => "–".to_owned(),
            false => format!("{:.3}", of(i)),
        };
        format!("{} / {}", figure(0), figure(1))
    };
    let pair = |value: &Value| both(&|i| number(&value[i]));
    let arms = |axis: usize| both(&|i| number(&chain["levers_m"][i][axis]));
    let r = &chain["response"];
    let _w = writeln!(
        text,
        "\nTo check \"{}\" by hand: v_n {:.3}, v_t {:.3} m/s; m {} kg; k {} m; h {} m; q {} m; \
         e 0.1, μ 0.45: J_n {:.1}, J_t {:.1} N s, ΔV {} m/s.",
        line.alternative.name,
        number(&chain["normal_m_s"]),
        number(&chain["tangential_m_s"]),
        pair(&chain["mass_kg"]),
        pair(&chain["gyration_m"]),
        arms(0),
        arms(1),
        number(&r["normal_n_s"]),
        number(&r["tangential_n_s"]),
        pair(&r["delta_v_m_s"])
    );
    for person in chain["persons"].as_array().into_iter().flatten() {
        let _w = writeln!(
            text,
            "  {}: {:.3} {} on {}: P {:.5}, P(0) {:.5}, H {:.5}.",
            person["party"].as_str().unwrap_or_default(),
            number(&person["x_in_unit"]),
            person["unit"].as_str().unwrap_or_default(),
            person["curve"].as_str().unwrap_or_default(),
            number(&person["published"]),
            number(&person["at_rest"]),
            number(&person["harm"][1])
        );
    }
}

/// Where boxes or the formula say otherwise, and why.
fn differences(text: &mut String, lines: &[Line<'_>]) {
    for line in lines.iter().filter(|line| is_boxes_only(line)) {
        let gap = number(&line.row["contact"]["hull_gap_m"]);
        let outlines = if gap > 0.0 {
            format!("the outlines stay {gap:.2} m apart")
        } else {
            format!("the outlines overlap by {:.3} m at most, and the bodies do not", -gap)
        };
        let near = if line.row["contact"]["near_miss"] == true {
            "; that is nearer than poses are known, so the range is as if they met"
        } else {
            ""
        };
        let _w = writeln!(
            text,
            "\nBoxes call \"{}\" a crash: the corners that overlap are not body; {outlines}{near}.",
            line.alternative.name
        );
    }
    let first = lines.iter().find(|line| line.formula_rank == 1);
    let (Some(ours), Some(theirs)) = (lines.first(), first) else { return };
    if ours.alternative == theirs.alternative {
        return;
    }
    let _w = writeln!(
        text,
        "\nThe formula puts \"{}\" first ({} %, against {} % for \"{}\"): it takes {:.1} and {:.1} \
         m/s of closing speed as they are. {}",
        theirs.alternative.name,
        percent(theirs.formula.mean()),
        percent(ours.formula.mean()),
        ours.alternative.name,
        number(&theirs.chain["closing_m_s"]),
        number(&ours.chain["closing_m_s"]),
        reason(ours, theirs)
    );
}

fn reason(ours: &Line<'_>, theirs: &Line<'_>) -> String {
    if ours.row["contact"]["touch"] == "no" {
        return format!("In \"{}\" the bodies do not touch at all.", ours.alternative.name);
    }
    let counted = ours.chain["persons"].as_array().map_or(0, Vec::len);
    if counted < 2 && ours.alternative.other.speed == 0.0 {
        return format!(
            "It counts somebody with \"{}\", which stands still: here nobody is with it unless \
             that is stated.",
            ours.alternative.party
        );
    }
    let [a, b] = [ours, theirs].map(|line| share(line.chain));
    if (a - b).abs() > 0.1 {
        return format!(
            "At the contact only {:.0} % of that is across it in \"{}\", and {:.0} % in \"{}\"; \
             the rest slides.",
            100.0 * a,
            ours.alternative.name,
            100.0 * b,
            theirs.alternative.name
        );
    }
    let arm = |line: &Line<'_>| number(&line.chain["levers_m"][0][0]);
    format!(
        "Speeds across the contact are alike; lever arms ({:.2} m and {:.2} m), sides struck, and \
         who is counted on either side make the difference.",
        arm(ours),
        arm(theirs)
    )
}
