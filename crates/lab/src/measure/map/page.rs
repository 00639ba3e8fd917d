//! The page of a map.

use super::cells::{Cell, Shares};
use super::found::Map;
use super::grid::{BUFFER, CORES};
use super::machine::{FIGURES, GROUPS, Machine, PAPER_BYTE_NS};
use super::pictures::as_the_paper_says;
use super::real::errors;
use super::table::contact;
use super::verdict::{CLAIMS, TOLERANCE};

/// Why each claim holds where it does, and not elsewhere: what the machines do.
const WHY: [(char, &str); 7] = [
    (
        'a',
        "A core needs a section once, so what travels is bounded by what it needs in the end. \
         With few jobs, match decides who needs what, and random match sends more. With many \
         small jobs every core needs a part of everything whoever chooses, and the schemes tie. \
         Best Match can send *more* in between: it fills the queue of the core that matches \
         first, and what is left over goes to cores that hold nothing of it.",
    ),
    (
        'b',
        "Shallow, there are fewer jobs than cores, and what is copied is whole bodies. Deep, \
         every job costs messages and its descent. Both ends cost something on every machine; \
         the end at depth 16 is only seen if bodies are small enough, or messages dear enough, \
         that splitting further costs more than it saves in copied bytes.",
    ),
    (
        'c',
        "The larger contact has more work below each pair of nodes, so messages weigh less \
         against it and it can be split further. But copied bytes push the other way: a scratch \
         needs a small part of both bodies, which only deep cuts single out, so where a byte is \
         dear the scratch wants the deeper cut.",
    ),
    (
        'd',
        "What Best Match saves is a ratio of bytes at the best depth. Larger bodies have deeper \
         best depths where copying costs, and at deep cuts the schemes tie. So the gain can \
         shrink as bodies grow.",
    ),
    (
        'e',
        "At a given depth the largest section is the same for all schemes. Best Match gathers \
         work on the cores that hold something, so at low depth its fullest core holds *more* \
         than one that is fed at random, not less. Who runs out first depends on the buffer: \
         with long queues one core is given nearly everything.",
    ),
    (
        'f',
        "A longer queue hides the time that a message takes, up to a point. Beyond it, jobs wait \
         in one core's queue while another is idle, because load counts relative to the queue, \
         and the last batches end unevenly. So speed-up falls again once the queues hold a large \
         part of all jobs. Where a byte is dear that is seen less: a longer queue leaves match \
         more choice.",
    ),
    (
        'g',
        "Less copied is time saved only where a byte is dear against a test. At the best depth \
         there are enough jobs for every core to need most sections anyway, so the schemes are \
         near each other; Best Match pays for what it saves with imbalance, which Best \
         Match-Load avoids.",
    ),
];

pub(super) fn page(map: &Map) -> String {
    let mut text = String::from("# Where each claim of the paper holds\n\n");
    let mut say = |line: &str| {
        text.push_str(line);
        text.push('\n');
    };
    opening(map, &mut say);
    say("\n## What follows for an integrator\n");
    for (advice, sentence) in map.advised.iter().zip(&map.advice) {
        say(&format!("- **{}.** {sentence}", advice.machine.title()));
    }
    say("\n![What placing by match pays](pays.svg)\n");
    figures_of_the_paper(map, &mut say);
    say("\n## The claims\n");
    for (claim, words) in CLAIMS {
        one(map, claim, words, &mut say);
    }
    by_axis(map, &mut say);
    machines(map, &mut say);
    validated(map, &mut say);
    text
}

fn opening(map: &Map, say: &mut impl FnMut(&str)) {
    let Map { command, machine, .. } = map;
    say(&format!(
        "`{command}` wrote this page, its figures and tables. {machine}\n\n\
         Wiseman and Grinberg (*The Trolley Problem Version of Autonomous Vehicles*, Open \
         Transp. J. 12, 2018) hand pairs of nodes to four cores by *Best Match*, *Random Match*, \
         *Lowest Match* or *Best Match-Load*, and judge by speed-up and by relative data \
         transfer. Their machine copies; ours does not. Here each claim is judged on three \
         machines: **the paper's**, **this machine made to copy**, and **ours**, one sealed \
         store. A *cell* is one choice of everything else: memory per core, cost of a byte, what \
         happens beyond that memory (virtual memory, or eviction), cores, buffer, bodies, \
         contact. Random match is the mean over {} seeds (four where jobs are many: their spread \
         counts all the same); the other schemes, where one request has all contacts, over eight \
         orders of them (one where jobs are many), because a scheme without a seed may be lucky \
         with one order.\n\n\
         A difference counts if it is more than {:.0} % of the larger value and more than three \
         standard errors. A claim **holds** at a cell if some difference it speaks of is there \
         and none is the other way round, **does not hold** if one is, and **nobody can tell** \
         if all are ties. A verdict on a machine is *depends* if more than one cell in fifty \
         holds and more than one does not.\n",
        map.grid.seeds,
        100.0 * TOLERANCE
    ));
    let titles = GROUPS.map(super::found::group_title).join(" | ");
    say(&format!("| | claim | {titles} |\n|---|---|---|---|---|---|"));
    for (claim, words) in CLAIMS {
        let verdict = |(machine, is_single)| {
            let is_it = |f: &&super::found::Finding| {
                (f.claim, f.machine, f.is_single) == (claim, machine, is_single)
            };
            let found = map.findings.iter().find(is_it);
            found.map_or("– (nothing is copied)".to_owned(), |found| {
                let shares = Shares { holds: found.holds, fails: found.fails, open: found.open };
                format!("**{}** {}", found.verdict, shares.percent())
            })
        };
        say(&format!("| {claim} | {words} | {} |", GROUPS.map(verdict).join(" | ")));
    }
    say("\nShares of cells: holds / does not hold / nobody can tell.");
}

fn figures_of_the_paper(map: &Map, say: &mut impl FnMut(&str)) {
    let (memory, buffer) = as_the_paper_says(map);
    say("## The paper's figures\n");
    say(&format!(
        "Speed-up and relative transfer over depth, on the paper's machine, a contact a request \
         (left), and on ours, sixteen a request (right). The paper does not state the memory of \
         a core. The one drawn, {} % of both bodies with a buffer of {buffer}, is where running \
         out of memory comes nearest to its words: the most depths at which only random or \
         lowest match run out, and the fewest at which only best match does, where that leaves \
         half of the line of best match-load. A line is cut where \
         it thrashes: waiting for virtual memory at least doubles the time.\n",
        map.grid.memories[memory]
    ));
    for contact in ["deep", "scratch"] {
        for kind in ["speed-up", "transfer"] {
            let name = |machine: Machine| format!("{kind}-{contact}-{}.png", machine.name());
            say(&format!(
                "<img src=\"{}\" width=\"49%\" alt=\"{kind}, {contact}, the paper's machine\"> \
                 <img src=\"{}\" width=\"49%\" alt=\"{kind}, {contact}, ours\">\n",
                name(Machine::Paper),
                name(Machine::Sealed)
            ));
        }
    }
}

fn one(map: &Map, claim: char, words: &str, say: &mut impl FnMut(&str)) {
    say(&format!("### ({claim}) {words}\n"));
    for finding in map.findings.iter().filter(|finding| finding.claim == claim) {
        let shares = Shares { holds: finding.holds, fails: finding.fails, open: finding.open };
        let regions = match finding.regions.as_slice() {
            [] => "No condition on the axes, nor two together, tells where.".to_owned(),
            regions => regions.join(" "),
        };
        let regions = if finding.cells < 100 { String::new() } else { format!(" {regions}") };
        say(&format!(
            "- **On {}: {}** ({} of {} cells).{regions}",
            finding.title(),
            finding.verdict,
            shares.percent(),
            finding.cells
        ));
    }
    if let Some((_, why)) = WHY.iter().find(|(known, _)| *known == claim) {
        say(&format!("\n{why}\n"));
    }
    say(&format!("![({claim}) {words}](claim-{claim}.svg)\n"));
}

/// Which cells a row of a table is about.
type Chosen = Box<dyn Fn(&Cell) -> bool>;

/// Shares by one axis at a time.
fn by_axis(map: &Map, say: &mut impl FnMut(&str)) {
    say("## By one axis at a time\n");
    say(
        "Holds / does not hold / nobody can tell, over all cells of the paper's machine that have \
         this value, whatever the other axes:\n",
    );
    let mut rows: Vec<(String, Chosen)> = Vec::new();
    for (is_single, words) in [(true, "a contact a request"), (false, "sixteen a request")] {
        let is_in = move |cell: &Cell| cell.is_single == is_single;
        rows.push((words.to_owned(), Box::new(is_in)));
    }
    for cores in map.grid.cores.clone() {
        rows.push((format!("{cores} cores"), Box::new(move |cell: &Cell| cell.cores == cores)));
    }
    for buffer in map.grid.buffers.clone() {
        let is_in = move |cell: &Cell| cell.buffer == Some(buffer);
        rows.push((format!("buffer {buffer}"), Box::new(is_in)));
    }
    for size in map.grid.sizes.clone() {
        let is_in = move |cell: &Cell| cell.size == Some(size);
        rows.push((format!("2 × {size} triangles"), Box::new(is_in)));
    }
    for is_deep in [true, false] {
        let is_in = move |cell: &Cell| cell.is_deep == Some(is_deep);
        rows.push((contact(is_deep).to_owned(), Box::new(is_in)));
    }
    for byte in map.grid.bytes.clone() {
        rows.push((
            format!("a byte at {byte} ns"),
            Box::new(move |cell: &Cell| cell.byte_ns == Some(byte)),
        ));
    }
    for memory in map.grid.memories.clone() {
        rows.push((
            format!("memory {memory} %"),
            Box::new(move |cell: &Cell| cell.memory == Some(memory)),
        ));
    }
    say(&format!(
        "| | {} |\n|---|{}",
        CLAIMS.map(|(claim, _)| claim.to_string()).join(" | "),
        "---|".repeat(CLAIMS.len())
    ));
    let line = |cells: &[Cell], is_in: &dyn Fn(&Cell) -> bool| {
        CLAIMS.map(|(claim, _)| {
            let chosen = cells.iter().filter(|cell| {
                (cell.claim, cell.machine) == (claim, Machine::Paper) && is_in(cell)
            });
            let shares = Shares::over(chosen);
            if shares.all() == 0 { "–".to_owned() } else { shares.percent() }
        })
    };
    for (words, is_in) in &rows {
        say(&format!("| {words} | {} |", line(&map.cells, is_in).join(" | ")));
    }
    say(&format!(
        "\nThe same with other costs of the paper's machine (a byte at {PAPER_BYTE_NS} ns, \
         {CORES} cores, buffer {BUFFER}, a contact a request): how far its figures, below, may \
         be wrong.\n"
    ));
    say(&format!(
        "| | {} |\n|---|{}",
        CLAIMS.map(|(claim, _)| claim.to_string()).join(" | "),
        "---|".repeat(CLAIMS.len())
    ));
    for variant in &map.variants {
        say(&format!("| {} | {} |", variant.words, line(&variant.cells, &|_| true).join(" | ")));
    }
}

fn machines(map: &Map, say: &mut impl FnMut(&str)) {
    say("\n## The machines\n\n### The paper's\n");
    say("Its costs are constants, and its traces are those of the plain walk on our trees, so \
         this part of the map is the same wherever it is computed.\n");
    say("| what | value | source |\n|---|---|---|");
    for [what, value, source] in FIGURES {
        say(&format!("| {what} | {value} | {source} |"));
    }
    let [job, cb, cp, hit] = map.plain_costs;
    say(&format!(
        "\nThe plain walk on this machine: Cb {cb:.1} ns, Cp {cp:.1} ns, {job:.0} ns per job, \
         {hit:.0} ns per hit.\n\n### This machine, copying, and ours\n\nThe walk of the engine, \
         with costs that `trolley calibrate` finds for each pair (ns). Made to copy, the costs \
         per section are as calibrated, and the cost of a byte is an axis of the map; *a byte* \
         below is what it is here. All numbers of cores are virtual; the coordinator shares the \
         core of worker 0.\n"
    ));
    say("| pair | Cb | Cp | job | hit | batch | placed | sent | taken | a byte | a section |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    for (pair, costs) in &map.costs {
        say(&format!(
            "| {pair} | {:.2} | {:.1} | {:.0} | {:.0} | {:.0} | {:.0} | {:.0} | {:.0} | {:.2} | \
            {:.0} |",
            costs.box_ns,
            costs.triangle_ns,
            costs.job_ns,
            costs.hit_ns,
            costs.batch_ns,
            costs.place_ns,
            costs.send_ns,
            costs.take_ns,
            costs.section_byte_ns + costs.ship_byte_ns,
            costs.section_ns + costs.ship_section_ns,
        ));
    }
    let limits = map.grid.cores.iter().zip(&map.grid.size_max);
    let left_out: Vec<String> = limits
        .filter(|(_, most)| map.grid.sizes.last() > Some(*most))
        .map(|(cores, most)| format!("{cores} cores have bodies of up to {most} triangles"))
        .collect();
    say(&format!(
        "\nAxes: bodies of {:?} triangles each (generated sedan and SUV), sixteen poses 0.5 m \
         (deep) or 0.01 m (scratch) inside; memory {:?} % of both bodies, and as much as is \
         needed; a byte {:?} ns; depth {:?}; the four schemes; buffers {:?}; {:?} cores. All of \
         them are crossed, each value with every other, on the paper's machine and on this one \
         made to copy; ours has neither memory nor a cost of a byte. Two parts of the product are \
         left out: {}, so claim (d), which compares sizes, has fewer; and buffers of {:?}, which \
         only claim (f) needs, have Best Match-Load alone. *Request*: all sixteen contacts are one \
         request, whose cores keep what they got; on the paper's machine also each contact by \
         itself, with empty memories. *Virtual memory*: what is needed and not among the most \
         recent M bytes comes in, what arrives when memory is full pushes out as much. A *hard \
         stop* ends a run where virtual memory begins, so claim (e) is the same for \
         both.\n\n`verdicts.csv` has every cell, a sign each, and `verdicts.parquet` the same a \
         row each; `pays.csv` and `pays.parquet` what placing by match pays. The output folder \
         has every simulated point, in `points.parquet` and as `sheets/*.csv`.",
        map.grid.sizes,
        map.grid.memories,
        map.grid.bytes,
        map.grid.depths,
        map.grid.all_buffers(),
        map.grid.cores,
        left_out.join(", "),
        map.grid.more_buffers,
    ));
}

fn validated(map: &Map, say: &mut impl FnMut(&str)) {
    say("\n## Predicted beside measured\n");
    let (Some(time), Some(bytes)) = (errors(&map.checked, 0), errors(&map.checked, 1)) else {
        return;
    };
    let exact = map.checked.iter().filter(|c| c.predicted_bytes == c.measured_bytes).count();
    say(&format!(
        "Real workers that copy (sections evicted beyond M), beside virtual ones with the costs \
         above and the kernel's of the same jobs in one process. Errors of time: {:.0} % in the \
         median, {:.0} % at worst. Bytes: {:.1} % in the median, {:.0} % at worst; exact at \
         {exact} of {} points. With one worker they follow from the order of jobs alone; with \
         two, from which of them is free first. Virtual memory, more than two cores and the \
         paper's machine have no real counterpart here.\n",
        100.0 * time[0],
        100.0 * time[1],
        100.0 * bytes[0],
        100.0 * bytes[1],
        map.checked.len()
    ));
    say("| pair | workers | scheme | depth | M % | predicted ms | measured ms | error | \
         predicted kB | measured kB | error |\n|---|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|");
    for check in &map.checked {
        let [time, bytes] = check.errors();
        say(&format!(
            "| 2 × {} {} | {} | {} | {} | {} | {:.2} | {:.2} | {:+.0} % | {} | {} | {:+.1} % |",
            check.size,
            check.contact,
            check.workers,
            check.scheme,
            check.depth,
            check.memory_percent,
            check.predicted_ms,
            check.measured_ms,
            100.0 * time,
            check.predicted_bytes / 1_000,
            check.measured_bytes / 1_000,
            100.0 * bytes
        ));
    }
}
