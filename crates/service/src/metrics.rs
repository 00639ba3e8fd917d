//! Health as a Prometheus text file.
//!
//! Names follow the conventions of Prometheus: a prefix, base units, `_total` for counters.

use protocol::public::{Condition, Health, LatencyStage, WireState};
use std::fmt::Write as _;

/// The text.
#[must_use]
pub(crate) fn text(health: &Health, instance: &str) -> String {
    let mut text = String::new();
    let mut family = |name: &str, kind: &str, help: &str, rows: &[(String, f64)]| {
        // Writing to a string cannot fail.
        let _ok = write!(text, "# HELP trolley_{name} {help}\n# TYPE trolley_{name} {kind}\n");
        for (labels, value) in rows {
            let comma = if labels.is_empty() { "" } else { "," };
            let _ok =
                writeln!(text, "trolley_{name}{{instance=\"{instance}\"{comma}{labels}}} {value}");
        }
    };
    let plain = |value: f64| vec![(String::new(), value)];
    let seconds = |ns: u64| ns as f64 / 1e9;
    let ready = health.condition == Condition::Ready as u32;
    family(
        "ready",
        "gauge",
        "1 if the service answers with all of its workers.",
        &plain(f64::from(u8::from(ready))),
    );
    let up = health.at_ns.saturating_sub(health.since_ns);
    family("up_seconds", "gauge", "Time since the service started.", &plain(seconds(up)));
    let answers: Vec<_> = WireState::ALL
        .iter()
        .zip(health.answers)
        .map(|(verdict, count)| (format!("verdict=\"{}\"", verdict.name()), count as f64))
        .collect();
    family("answers_total", "counter", "Answers by verdict.", &answers);
    for (name, kind, help, value) in [
        ("withdrawn_total", "counter", "Requests whose client was gone.", health.withdrawn),
        ("workers_lost_total", "counter", "Workers lost.", health.lost),
        ("page_faults_total", "counter", "Page faults within requests.", health.faults),
        ("messages_total", "counter", "Messages to and from workers.", health.messages),
        ("message_bytes_total", "counter", "Bytes of these messages.", health.message_bytes),
        ("allocations", "gauge", "Heap allocations of the last request.", health.allocations),
        ("workers", "gauge", "Workers alive.", u64::from(health.alive)),
        ("waiting", "gauge", "Waiting requests.", u64::from(health.waiting)),
        ("clients", "gauge", "Clients connected.", u64::from(health.clients)),
    ] {
        family(name, kind, help, &plain(value as f64));
    }
    let mut latency = Vec::new();
    for (stage, row) in LatencyStage::ALL.iter().zip(health.latency_ns) {
        for (quantile, ns) in ["0.5", "0.99", "0.999", "1"].iter().zip(row) {
            let labels = format!("stage=\"{}\",quantile=\"{quantile}\"", stage.name());
            latency.push((labels, seconds(ns)));
        }
    }
    family("latency_seconds", "gauge", "Time per stage since the start.", &latency);
    let per_worker = |value: fn(&protocol::public::WorkerHealth) -> f64| -> Vec<(String, f64)> {
        let rows = health.each.iter().enumerate().filter(|(_, row)| row.pid != 0);
        rows.map(|(number, row)| (format!("worker=\"{number}\""), value(row))).collect()
    };
    family("worker_jobs_total", "counter", "Jobs done.", &per_worker(|row| row.jobs as f64));
    family(
        "worker_busy_seconds_total",
        "counter",
        "Time spent on these jobs.",
        &per_worker(|row| row.busy_ns as f64 / 1e9),
    );
    family(
        "worker_replaced_total",
        "counter",
        "Processes replaced.",
        &per_worker(|row| row.replaced as f64),
    );
    text
}

#[cfg(test)]
mod tests {
    //! Every line is a comment or a name with labels and a number.
    use super::*;

    #[test]
    fn each_line_has_the_form_that_prometheus_reads() {
        let mut health: Health = bytemuck::Zeroable::zeroed();
        health.answers[0] = 17;
        health.each[1].pid = 5;
        health.latency_ns[4][1] = 2_000_000;
        let text = text(&health, "demo");
        assert!(
            text.contains("trolley_answers_total{instance=\"demo\",verdict=\"complete\"} 17\n")
        );
        assert!(text.contains("stage=\"total\",quantile=\"0.99\"} 0.002\n"), "{text}");
        assert!(text.contains("trolley_worker_jobs_total{instance=\"demo\",worker=\"1\"} 0\n"));
        for line in text.lines().filter(|line| !line.starts_with("# ")) {
            let (name, value) = line.rsplit_once(' ').expect("a name and a number");
            assert!(name.starts_with("trolley_") && name.ends_with('}'), "{line}");
            assert!(value.parse::<f64>().is_ok_and(f64::is_finite), "{line}");
        }
    }
}
