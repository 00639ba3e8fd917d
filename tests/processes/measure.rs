//! A whole measurement of small bodies: its tables, figures and page agree; costs are written as
//! printed; and bad input is refused before anything is measured.

use crate::support::{self, Place, json, text, trolley, ways};
use std::path::Path;

const PAIRS: [&str; 2] = ["sedan:3000,suv:3000,deep", "sedan:3000,suv:3000,scratch"];

#[test]
fn a_measurement_writes_tables_figures_and_a_page_that_fit_together() {
    let place = Place::new();
    let out = place.path().join("results");
    let mut command = trolley();
    command.args(["measure", "--quick", "--out"]).arg(&out);
    for pair in PAIRS {
        command.args(["--pair", pair]);
    }
    let output = command.output().expect("it can be started");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(out.join(name)).expect(name);
    let table = read("rows.csv");
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().expect("a line of names").split(',').collect();
    let column = |name: &str| names.iter().position(|known| *known == name).expect(name);
    let (mut rows, mut measured, mut by_depth) = (0, 0, std::collections::BTreeMap::new());
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields.len(), names.len(), "{line}");
        let field = |name: &str| fields[column(name)];
        // A run that thrashed has a reason and no figures; any other, the reverse.
        assert_eq!(field("thrashed").is_empty(), !field("speed_up").is_empty(), "{line}");
        let is_counted = field("mode") == "measured" && field("thrashed").is_empty();
        assert_eq!(is_counted, !field("message_bytes").is_empty(), "{line}");
        if field("thrashed").is_empty() {
            // However many workers, one depth has the same jobs.
            let jobs = by_depth.entry((field("pair"), field("depth"))).or_insert(field("jobs"));
            assert_eq!(*jobs, field("jobs"), "{line}");
            let share: f64 = field("relative_to_unshared").parse().expect("a number");
            assert!(share > 0.0 && share <= 1.0, "{line}");
        }
        rows += 1;
        measured += u32::from(field("mode") == "measured");
    }
    assert!(rows > 100 && measured > 40, "{rows} rows, {measured} measured");
    let page = read("README.md");
    assert!(page.contains("decide no claim of the paper"), "{page}");
    let figures: Vec<&str> =
        page.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    assert_eq!(figures.len(), 6, "{figures:?}");
    for figure in figures {
        let png = std::fs::read(out.join(figure)).expect(figure);
        assert!(png.starts_with(b"\x89PNG") && png.len() > 5_000, "{figure}");
        let svg = read(&figure.replace(".png", ".svg"));
        assert!(svg.contains("best-match-load") && svg.contains("distribution depth"), "{figure}");
    }
    let document: serde_json::Value =
        serde_json::from_str(&read("measure.json")).expect("it is JSON");
    assert_eq!(document["pairs"].as_array().map(Vec::len), Some(2));
    assert_eq!(document["schema"], "trolley.measure/1");
}

#[test]
fn one_ranking_is_measured_with_settings_that_no_decision_needs() {
    let place = Place::new();
    // So short that no way has a second contact.
    let ways = ways(2000).replacen("horizon_s = 3", "horizon_s = 1.3", 1);
    let path = place.write("ways.toml", &ways);
    let path = path.to_str().expect("a path of letters");
    let log = place.path().join("log.csv");
    let run = |args: &[&str]| {
        let output = support::run(args);
        assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
        json(&output)
    };
    let plain = run(&["rank", path, "--json", "--in-process"]);
    let dispatch_options = ["--scheme", "lowest-match", "--cache-bytes", "90000", "--linger", "20"];
    let asked = ["--depth", "6", "--workers", "2", "--search-order", "deciding", "--job-log"];
    let log_path = log.to_str().expect("a path of letters");
    let all =
        [&["measure", "--scenario", path, "--json"], &dispatch_options[..], &asked, &[log_path]];
    let document = run(&all.concat());
    assert_eq!(document["schema"], "trolley.measure-rank/1");
    assert_eq!(document["answer"], plain["answer"]);
    let counter = |key: &str| document["run"][key].as_u64().expect(key);
    assert!(
        counter("section_bytes") < counter("section_bytes_unshared")
            && counter("sections_evicted") > 0
    );
    let log = std::fs::read_to_string(log).expect("the log");
    let assigned = log.lines().filter(|line| line.starts_with("assigned")).count() as u64;
    // All contacts of this scenario are one round, and so is the log.
    assert_eq!(assigned, counter("jobs") - counter("jobs_cut") + counter("jobs_reissued"));
}

/// Whatever cores there are, the answer is one; nobody is faster than all cores together.
#[test]
fn a_ranking_is_simulated_on_cores_that_there_are_not() {
    let place = Place::new();
    let path = place.write("ways.toml", &ways(2000));
    let mut command = trolley();
    command.args(["measure", "--virtual-cores", "--members", "4", "--json"]);
    let output = command.arg("--scenario").arg(path).output().expect("it can be started");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let document = json(&output);
    assert_eq!(document["schema"], "trolley.measure-virtual/3");
    let rows = document["rows"].as_array().unwrap();
    let cores: Vec<_> = rows.iter().map(|row| row["cores"].as_u64().unwrap()).collect();
    assert_eq!(cores, [2, 2, 4, 5]);
    for row in rows {
        let number = |key: &str| row[key].as_f64().unwrap();
        let simulated = row["simulated"][1].as_f64().unwrap();
        assert!(simulated > 0.0 && simulated <= number("cores"), "{row}");
        assert!(number("coordinator") <= 1.0 && number("busy") <= 1.0, "{row}");
    }
    // What cores do by themselves is known where workers are measured on them.
    let is_measured = rows.iter().any(|row| row["measured"].is_number());
    assert_eq!(document["cores"].as_u64() > Some(0), is_measured, "{document}");
    assert_eq!(document["at_once"].as_f64().is_some_and(|gain| gain > 0.0), is_measured);
    let costs = document["costs_ns"].as_array().unwrap();
    assert!(costs.iter().all(|cost| cost.as_u64().unwrap() > 0), "{costs:?}");
    refused(&["--virtual-cores", "--out", "x"], 2, "--out");
    let path = place.path().join("ways.toml");
    let scenario = ["--scenario", path.to_str().expect("a path of letters"), "--virtual-cores"];
    for limit in [["--deadline-ms", "50"], ["--until", "certified"]] {
        refused(&[&scenario[..], &limit].concat(), 78, "has no deadline, no early end");
    }
    let of_processes = ["--workers", "--instance", "--linger"];
    let of_memory = ["--job-log", "--cache-bytes", "--memory-budget"];
    for unused in [of_processes, of_memory].concat() {
        refused(&[&scenario[..], &[unused, "2"]].concat(), 2, unused);
    }
}

#[test]
fn a_sweep_may_be_about_one_scheme_and_one_way_of_transfer() {
    let place = Place::new();
    let out = place.path().join("results");
    let log = place.path().join("log.csv");
    let mut command = trolley();
    command.args(["measure", "--quick", "--pair", PAIRS[0], "--scheme", "best-match-load"]);
    command.args(["--cache-bytes", "99999999", "--linger", "10", "--job-log"]).arg(&log);
    let output = command.arg("--out").arg(&out).output().expect("it can be started");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let rows = std::fs::read_to_string(out.join("rows.csv")).expect("rows.csv");
    assert!(rows.lines().skip(1).all(|row| row.contains(",best-match-load,")), "{rows}");
    assert!(!rows.contains(",measured,copy,") && rows.contains(",measured,zero-copy,"), "{rows}");
    assert!(text(&output.stdout).contains("4 virtual cores"), "{}", text(&output.stdout));
    let log = std::fs::read_to_string(log).expect("the log");
    assert!(log.lines().filter(|line| line.starts_with("assigned,")).count() > 10, "{log}");
}

/// The rows of a Parquet file, as CSV has them: text, whole numbers, and reals with their decimals.
fn parquet_rows(path: &Path, decimals: &[(&str, usize)]) -> Vec<Vec<String>> {
    use parquet::file::reader::SerializedFileReader;
    use parquet::record::Field;
    let file = std::fs::File::open(path).expect("it is there");
    let reader = SerializedFileReader::new(file).expect("it is Parquet");
    let field = |(name, field): (&String, &Field)| match field {
        Field::Null => String::new(),
        Field::Str(word) => word.clone(),
        Field::Long(number) => number.to_string(),
        Field::Double(number) => {
            let known = decimals.iter().find(|(known, _)| known == name);
            let (_, decimals) = known.expect(name);
            format!("{number:.decimals$}")
        }
        other => panic!("{name}: {other:?}"),
    };
    reader
        .into_iter()
        .map(|row| row.expect("a row").get_column_iter().map(field).collect())
        .collect()
}

/// Parquet and CSV of a map say the same: verdicts, gains, and every point of every sheet.
fn tables_agree(out: &Path, verdicts: &str) {
    let (memories, bytes) = ([20, 60], ["0.0", "0.9"]);
    let mut by_hand = Vec::new();
    for line in verdicts.lines().skip(2) {
        let (head, signs) = line.rsplit_once(',').expect("signs");
        let head: Vec<&str> = head.split(',').collect();
        let is_copied = head[1] != "sealed";
        for (group, memory) in signs.split(' ').zip(memories) {
            for (sign, byte) in group.chars().zip(bytes) {
                let word = match sign {
                    '+' => "holds",
                    '-' => "does not hold",
                    _ => "nobody can tell",
                };
                let mut row: Vec<String> = head.iter().map(|field| (*field).to_owned()).collect();
                row.push(if is_copied { memory.to_string() } else { String::new() });
                row.push(if is_copied { byte.to_owned() } else { String::new() });
                row.push(word.to_owned());
                by_hand.push(row);
            }
        }
    }
    let mut found = parquet_rows(&out.join("verdicts.parquet"), &[("byte_ns", 1)]);
    by_hand.sort();
    found.sort();
    assert_eq!(found, by_hand);
    // The product is full: every value of every axis with every other; but the largest bodies have
    // four cores alone.
    let transfer = found.iter().filter(|row| row[0] == "a" && row[1] == "copying").count();
    let (sizes_by_cores, contacts, beyond) = (2 * 2 + 1, 2, 2);
    assert_eq!(transfer, sizes_by_cores * contacts * beyond * memories.len() * bytes.len());

    let decimals = [
        ("byte_ns", 1),
        ("best_match_load_over_random", 4),
        ("standard_error", 4),
        ("speed_up", 3),
    ];
    let pays = std::fs::read_to_string(out.join("pays.csv")).expect("pays.csv");
    let csv: Vec<Vec<String>> =
        pays.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect();
    assert_eq!(parquet_rows(&out.join("pays.parquet"), &decimals), csv);

    // A point of a sheet by its values, and by where it lies.
    let decimals = [
        ("byte_ns", 1),
        ("time_us", 1),
        ("time_sd", 1),
        ("moved", 4),
        ("moved_sd", 4),
        ("swapped", 4),
        ("out", 3),
        ("peak", 4),
        ("alone_us", 1),
    ];
    let points = parquet_rows(&out.join("points.parquet"), &decimals);
    let mut sheets = 0;
    let mut in_sheets = Vec::new();
    for entry in std::fs::read_dir(out.join("sheets")).expect("sheets") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|end| end != "csv") {
            continue;
        }
        sheets += 1;
        for line in std::fs::read_to_string(&path).expect("a sheet").lines().skip(3) {
            let fields: Vec<&str> = line.split(',').collect();
            in_sheets.push(fields[5..].join(","));
        }
    }
    let mut in_points: Vec<String> = points.iter().map(|row| row[11..19].join(",")).collect();
    in_points.sort();
    in_sheets.sort();
    assert!(sheets > 20 && in_points == in_sheets, "{sheets} sheets");
}

#[test]
fn a_map_judges_every_claim_on_every_machine_and_goes_on_where_it_was() {
    let place = Place::new();
    let out = place.path().join("map");
    let run = || {
        let output = trolley().args(["measure", "--map", "--quick", "--out"]).arg(&out).output();
        let output = output.expect("it can be started");
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let said = run();
    let read = |name: &str| std::fs::read_to_string(out.join(name)).expect(name);
    let page = read("README.md");
    for letter in 'a'..='g' {
        assert!(page.contains(&format!("\n| {letter} | ")), "claim {letter} is not there");
        assert!(page.contains(&format!("](claim-{letter}.svg)")), "no picture of {letter}");
        assert!(read(&format!("claim-{letter}.svg")).contains("ns a byte"), "{letter}");
    }
    for figure in page.split("src=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
        let png = std::fs::read(out.join(figure)).expect(figure);
        assert!(png.starts_with(b"\x89PNG") && png.len() > 5_000, "{figure}");
    }
    let document: serde_json::Value = serde_json::from_str(&read("map.json")).expect("it is JSON");
    assert_eq!(document["schema"], "trolley.map/1");
    let checked = document["checked"].as_array().expect("points");
    assert!(checked.len() >= 10, "{checked:?}");
    for point in checked.iter().filter(|point| point["workers"] == 1) {
        assert_eq!(point["predicted_bytes"], point["measured_bytes"], "{point}");
    }
    // Every cell once, and no verdict but three.
    let verdicts = read("verdicts.csv");
    let rows: Vec<&str> = verdicts.lines().skip(2).collect();
    assert!(rows.len() > 100, "{} rows", rows.len());
    for row in &rows {
        let signs = row.rsplit(',').next().expect("a field");
        assert!(!signs.is_empty() && signs.chars().all(|sign| "+-. ".contains(sign)), "{row}");
    }
    assert!(said.contains("(e) only random and lowest match run out"), "{said}");
    tables_agree(&out, &verdicts);
    // What an interrupted map has is not made again; what it lacks, or was torn, is.
    let sheet = out.join("sheets/paper-1000-deep-sixteen-4-cores-buffer-16.csv");
    let whole = std::fs::read_to_string(&sheet).expect("a sheet");
    std::fs::write(&sheet, &whole[..whole.len() / 2]).expect("it can be written");
    let kept = out.join("sheets/sealed-1000-deep-sixteen-4-cores-buffer-16.csv");
    let before = std::fs::metadata(&kept).expect("a sheet").modified().expect("a time");
    run();
    assert_eq!(std::fs::read_to_string(&sheet).expect("a sheet"), whole);
    let after = std::fs::metadata(&kept).expect("a sheet").modified().expect("a time");
    assert_eq!(before, after, "it was made again");
    assert_eq!(read("verdicts.csv"), verdicts);
}

fn refused(args: &[&str], code: i32, says: &str) {
    let output = trolley().arg("measure").args(args).output().expect("it can be started");
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {error}");
    assert!(error.contains(says), "{args:?}: {error}");
}

#[test]
fn bad_input_is_refused_with_its_reason() {
    let place = Place::new();
    let out = place.path().to_str().expect("a path of letters");
    let file = place.write("a-file", "not a folder");
    let below = file.join("results");
    refused(&["--out", below.to_str().expect("a path")], 71, "a-file");
    refused(&["--map"], 2, "--out");
    refused(&["--map", "--out", out, "--pair", PAIRS[0]], 2, "--pair");
    refused(&["--map", "--out", out, "--seed", "4"], 78, "leave --seed out");
    refused(&["--map", "--out", below.to_str().expect("a path")], 71, "a-file");
    refused(&["--out", out, "--alpha", "1.5"], 78, "--alpha may be 0 to 1");
    refused(&["--out", out, "--alpha", "nan"], 78, "--alpha may be 0 to 1");
    refused(&["--out", out, "--workers", "2"], 78, "--scenario FILE");
    refused(&["--out", out, "--search-order", "deciding"], 78, "--scenario FILE");
    refused(&["--out", out, "--memory-budget", "9"], 78, "--transfer copy");
    refused(&["--out", out, "--linger", "20000"], 78, "--linger may be");
    refused(&["--out", out, "--scheme", "worst-match"], 2, "round-robin");
    refused(&["--scenario", "no.toml", "--scheme", "best-match,round-robin"], 78, "one scheme");
    refused(&["--scenario", "no.toml", "--out", out], 2, "--out");
    refused(&["--out", out, "--pair", "one,two"], 2, "A,B,POSES");
    refused(&["--out", out, "--pair", "no.trolley,sedan:900,deep"], 65, "no.trolley");
    refused(&["--out", out, "--pair", "sedan:9,sedan:900,deep"], 65, "triangles");
    refused(&["--out", out, "--pair", "sedan:900,sedan:900,no.txt"], 65, "no.txt");
    let bent = place.write("bent.txt", "1 0 0 0\n0 1 0 0\n0 0 2 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n");
    let pair = format!("sedan:900,sedan:900,{}", bent.display());
    refused(&["--out", out, "--pair", &pair], 65, "not rigid");
    assert!(Path::new(out).join("README.md").metadata().is_err(), "nothing was measured");
}

#[test]
fn calibrated_costs_are_printed_and_written() {
    let place = Place::new();
    let costs = place.path().join("costs.json");
    let mut command = trolley();
    command.args(["calibrate", "--pair", "sedan:900,suv:900,deep", "--repeat", "1", "--out"]);
    let output = command.arg(&costs).output().expect("it can be started");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let written = std::fs::read_to_string(&costs).expect("costs.json");
    assert_eq!(written.trim(), text(&output.stdout).trim());
    let costs: serde_json::Value = serde_json::from_str(&written).expect("it is JSON");
    let costs = costs.as_object().expect("a table");
    let is_time = |ns: &serde_json::Value| ns.as_f64().is_some_and(|ns| ns >= 0.0);
    assert!(costs.len() == 17 && costs.values().all(is_time), "{written}");
    let below = place.path().join("costs.json/again.json");
    let mut command = trolley();
    let output = command.args(["calibrate", "--out"]).arg(&below).output().expect("it starts");
    assert_eq!(output.status.code(), Some(71), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("costs.json/again.json"));
}

#[test]
fn how_early_a_winner_is_certain_is_measured_whatever_chance_makes() {
    let output = trolley()
        .args(["certify", "share", "--requests", "3", "--depth", "3", "-q"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("| certified |"), "{}", text(&output.stdout));
}
