//! The page of a measurement: tables and figures, with the command that made it.

use super::curve::best_depth;
use super::row::Mode;
use super::swept::{Check, Swept};
use scenario::Scheme;
use std::fmt::Write as _;
use trolley::dispatch_options::TransferMode;

/// The median and the greatest error of the predictions (%); `None` if nothing was predicted.
pub(crate) fn errors(checks: &[Check]) -> Option<[f64; 2]> {
    let mut errors: Vec<f64> = checks.iter().map(|check| 100.0 * check.error().abs()).collect();
    errors.sort_by(f64::total_cmp);
    Some([*errors.get(errors.len() / 2)?, *errors.last()?])
}

/// The greatest speed-up of Best Match-Load in one mode, over all depths and buffers, and where.
pub(crate) fn best(swept: &Swept, mode: Mode, workers: u8) -> Option<(f64, u32)> {
    let rows = swept.rows.iter().filter(|row| {
        (row.mode, row.workers) == (mode, workers)
            && (row.scheme, row.transfer) == (Scheme::BestMatchLoad, TransferMode::ZeroCopy)
    });
    let known = rows.filter_map(|row| Some((row.speed_up?, row.depth)));
    known.max_by(|a, b| a.0.total_cmp(&b.0))
}

pub(crate) fn page(swept: &[Swept], machine: &str, command: &str) -> String {
    let mut text = String::from("# Match schemes, depth and transfer\n\n");
    let mut say = |line: String| {
        text.push_str(&line);
        text.push('\n');
    };
    say(format!("`{command}` wrote this page, its figures, `rows.csv` and `measure.json`.\n"));
    say(format!("{machine}\n"));
    say(
        "Speed-up is the best time of the in-process kernel (no workers, its own best depth) over \
         that of the worker pool, on the same poses; the quickest repeat of each counts, because \
         other load on a machine only adds time (the tables also have medians). *Measured* is \
         this machine; the \
         quad-core columns are **simulated**: the same dispatcher on virtual cores, with costs \
         calibrated here. The error is that of all \
         speed-ups predicted for one and two workers at all depths: median, worst.\n"
            .to_owned(),
    );
    say("| pair | triangles | pairs found | alone | 1 worker | 2 workers | 4 cores, coordinator \
         on a fifth | 4 cores, five processes | error |"
        .to_owned());
    say("|---|--:|--:|--:|--:|--:|--:|--:|--:|".to_owned());
    for pair in swept {
        let best_speed_up = |mode, workers| {
            best(pair, mode, workers)
                .map_or(String::from("–"), |(value, depth)| format!("{value:.2} (d {depth})"))
        };
        say(format!(
            "| {} | {} + {} | {} | {:.2} ms | {} | {} | {} | {} | {} |",
            pair.pair,
            pair.triangles[0],
            pair.triangles[1],
            pair.pairs_found,
            pair.alone_ms,
            best_speed_up(Mode::Measured, 1),
            best_speed_up(Mode::Measured, 2),
            best_speed_up(Mode::SimulatedOwnCore, 4),
            best_speed_up(Mode::SimulatedSharedCore, 4),
            errors(&pair.checks)
                .map_or(String::from("–"), |[half, most]| format!("{half:.0} %, {most:.0} %")),
        ));
    }
    say("\nOne seed, one memory and one machine decide no claim of the paper: `trolley measure \
         --map` says where each holds."
        .to_owned());
    for pair in swept {
        one(pair, &mut say);
    }
    text
}

fn one(pair: &Swept, say: &mut impl FnMut(String)) {
    let Swept { pair: name, poses, costs, .. } = pair;
    say(format!("\n## {name}\n"));
    let depth = best_depth(pair).map_or(0, |(depth, _)| depth);
    say(format!("{poses} poses; best depth on four virtual cores: {depth}.\n"));
    for (kind, what) in [
        (
            "speed-up",
            "Simulated speed-up with four virtual cores that copy sections, as the paper's did",
        ),
        (
            "zero-copy",
            "Simulated speed-up with four virtual cores on one sealed store, and measured with two",
        ),
        ("transfer", "Simulated relative transfer with four virtual cores"),
    ] {
        say(format!("![{what}]({name}-{kind}.png)\n"));
    }
    say(format!(
        "Baseline in one process, {} threads that share each pose (kernel only, nothing folded): \
         {:.2} ms, speed-up {:.2}.\n",
        pair.threads,
        pair.threads_ms,
        pair.alone_ms / pair.threads_ms
    ));
    say("Where the time of a measured run went (Best Match-Load, ms):\n".to_owned());
    say("| workers | depth | run | speed-up | kernel, all workers | least – most of a worker | \
         descent | fold | decide | send | take |"
        .to_owned());
    say("|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|".to_owned());
    for s in &pair.shares {
        say(format!(
            "| {} | {} | {:.2} | {:.2} | {:.2} | {:.2} – {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | \
             {:.2} |",
            s.workers,
            s.depth,
            s.run_ms,
            s.speed_up,
            s.kernel_ms,
            s.worker_least_ms,
            s.worker_most_ms,
            s.descent_ms,
            s.fold_ms,
            s.decide_ms,
            s.send_ms,
            s.take_ms
        ));
    }
    copied(pair, say);
    say("\nPredicted against measured (ms):\n".to_owned());
    say("| workers | depth | predicted | measured | predicted speed-up | measured | error |"
        .to_owned());
    say("|--:|--:|--:|--:|--:|--:|--:|".to_owned());
    for check in &pair.checks {
        say(format!(
            "| {} | {} | {:.2} | {:.2} | {:.2} | {:.2} | {:+.0} % |",
            check.workers,
            check.depth,
            check.predicted_ms,
            check.measured_ms,
            check.predicted_speed_up,
            check.measured_speed_up,
            100.0 * check.error()
        ));
    }
    let mut list = String::new();
    for (what, ns) in [
        ("job", costs.job_ns),
        ("box test Cb", costs.box_ns),
        ("triangle test Cp", costs.triangle_ns),
        ("hit", costs.hit_ns),
        ("result sent", costs.send_ns),
        ("task", costs.task_ns),
        ("box test of the descent", costs.descent_ns),
        ("batch", costs.batch_ns),
        ("placement", costs.place_ns),
        ("result taken", costs.take_ns),
        ("hit folded", costs.fold_hit_ns),
    ] {
        // A String takes whatever it is given.
        let _written = write!(list, "{what} {ns:.2}, ");
    }
    say(format!("\nCosts (ns): {}.", list.trim_end_matches(", ")));
}

/// Zero-copy and copying side by side, measured with two workers on the same jobs.
fn copied(pair: &Swept, say: &mut impl FnMut(String)) {
    say("\nZero-copy against copying, two workers, Best Match-Load (ms and kB of messages):\n"
        .to_owned());
    say("| depth | zero-copy | copy | time | zero-copy | copy | bytes |".to_owned());
    say("|--:|--:|--:|--:|--:|--:|--:|".to_owned());
    let row_of = |transfer: TransferMode, depth: u32| {
        pair.rows.iter().find(|row| {
            (row.mode, row.workers, row.depth) == (Mode::Measured, 2, depth)
                && row.queue == super::calibrate::QUEUES.capacity
                && (row.scheme, row.transfer) == (Scheme::BestMatchLoad, transfer)
        })
    };
    for shares in pair.shares.iter().filter(|shares| shares.workers == 2) {
        let rows = (
            row_of(TransferMode::ZeroCopy, shares.depth),
            row_of(TransferMode::Copy, shares.depth),
        );
        let (Some(shared), Some(copy)) = rows else { continue };
        let kb = |row: &super::row::Row| row.message_bytes.map(|bytes| bytes as f64 / 1e3);
        let line = match (shared.time_ms, copy.time_ms, kb(shared), kb(copy)) {
            (Some(one), Some(two), Some(few), Some(many)) => format!(
                "{one:.2} | {two:.2} | × {:.2} | {few:.0} | {many:.0} | × {:.1}",
                two / one,
                many / few
            ),
            (Some(one), _, Some(few), _) => format!("{one:.2} | thrashed | – | {few:.0} | – | –"),
            _ => continue,
        };
        say(format!("| {} | {line} |", shares.depth));
    }
}
