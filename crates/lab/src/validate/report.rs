//! The report of a validation, as text and as a page with a figure.

use super::crash_test::{Group, Validated};
use super::ordering::Ordered;
use crate::measure::figure;
use serde::Serialize;
use std::fmt::Write as _;
use trolley::Failure;

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct ValidateReport {
    pub(super) schema: &'static str,
    /// Name of the parameters.
    pub(super) parameters: String,
    /// Crash tests, in the order of the files.
    pub tests: Vec<Validated>,
    /// The groups of tests.
    pub groups: Vec<Group>,
    /// Orderings, in the order of their names.
    pub orderings: Vec<Ordered>,
}

impl ValidateReport {
    /// Whether every group of tests lies within a bias of 10 % and an rms of 30 %, and every
    /// ordering holds.
    #[must_use]
    pub fn is_right(&self) -> bool {
        self.groups.iter().all(Group::is_within) && self.orderings.iter().all(|one| one.holds)
    }

    /// The report as text.
    #[must_use]
    pub fn text(&self) -> String {
        text(self)
    }

    /// The report as a page, Markdown, and the figure beside it (PNG), if there are crash tests.
    /// `figure` is the name by which the page links it.
    ///
    /// # Errors
    ///
    /// If the figure cannot be drawn.
    pub fn page(&self, command: &str, figure: &str) -> Result<(String, Option<Vec<u8>>), Failure> {
        page(self, command, figure)
    }
}

/// Said wherever fitted figures are shown.
const FITTED: &str = "Friction and the behaviour along barriers were fitted on tests of these \
                      groups: where each test is left out of the fit, figures are of tests that \
                      the parameter has not seen.";

fn text(report: &ValidateReport) -> String {
    let mut text = format!("Parameters \"{}\"\n", report.parameters);
    // Writing to a string cannot fail.
    if !report.tests.is_empty() {
        let _w = writeln!(text, "\nChange of velocity, m/s   measured  computed   error  left out");
        for test in &report.tests {
            let error = 100.0 * (test.computed_m_s / test.measured_m_s - 1.0);
            let left_out =
                test.left_out_m_s.map_or("–".to_owned(), |value| format!("{value:.2}"));
            let _w = writeln!(
                text,
                "{:<24} {:>9.2} {:>9.2} {error:>+6.0} % {left_out:>8}",
                test.id, test.measured_m_s, test.computed_m_s
            );
        }
        let _w = writeln!(text);
        for group in &report.groups {
            let _w = write!(
                text,
                "{}: {} tests, bias {:+.1} %, rms {:.1} %",
                group.name, group.tests, group.bias_percent, group.rms_percent
            );
            if let Some(left) = &group.left_out {
                let _w = write!(
                    text,
                    "; {} fitted on the others: bias {:+.1} %, rms {:.1} %",
                    left.parameter, left.bias_percent, left.rms_percent
                );
            }
            let _w = writeln!(text, "{}", if group.is_within() { "" } else { "  OUT OF BOUNDS" });
        }
        let _w = writeln!(text, "{FITTED}");
    }
    if !report.orderings.is_empty() {
        let held = report.orderings.iter().filter(|one| one.holds).count();
        let _w = writeln!(text, "\nOrderings: {held} of {} hold", report.orderings.len());
        for one in &report.orderings {
            let sign = if one.holds { "holds" } else { "FAILS" };
            let _w = writeln!(text, "{sign}  {:<44} {:.5} ≥ {:.5}", one.name, one.more, one.less);
        }
    }
    text
}

fn page(
    report: &ValidateReport,
    command: &str,
    figure: &str,
) -> Result<(String, Option<Vec<u8>>), Failure> {
    let mut page = String::from("# Impact and injury against crash tests and orderings\n\n");
    let _w = writeln!(
        page,
        "Written by `{command}`. Parameters \"{}\" (`config/parameters`), shipped curves. Each \
         test is a scene that the whole engine ranks; its figure is the nominal change of \
         velocity of the car.\n",
        report.parameters
    );
    let drawn = if report.tests.is_empty() { None } else { Some(drawn(report)?) };
    if drawn.is_some() {
        let _w =
            writeln!(page, "## Crash tests\n\n{FITTED}\n\n![measured and computed]({figure})\n");
        let _w = writeln!(page, "| group | tests | bias % | rms % | left out: bias % | rms % |");
        let _w = writeln!(page, "|---|---|---|---|---|---|");
        for group in &report.groups {
            let [bias, rms] = group.left_out.as_ref().map_or_else(
                || ["–".to_owned(), "–".to_owned()],
                |left| [format!("{:+.1}", left.bias_percent), format!("{:.1}", left.rms_percent)],
            );
            let _w = writeln!(
                page,
                "| {} | {} | {:+.1} | {:.1} | {bias} | {rms} |",
                group.name, group.tests, group.bias_percent, group.rms_percent
            );
        }
        let _w = writeln!(page, "\n| test | measured m/s | computed m/s | left out m/s | source |");
        let _w = writeln!(page, "|---|---|---|---|---|");
        for test in &report.tests {
            let left_out =
                test.left_out_m_s.map_or("–".to_owned(), |value| format!("{value:.2}"));
            let _w = writeln!(
                page,
                "| {} | {:.2} | {:.2} | {left_out} | {} |",
                test.id, test.measured_m_s, test.computed_m_s, test.source
            );
        }
    }
    if !report.orderings.is_empty() {
        let held = report.orderings.iter().filter(|one| one.holds).count();
        let _w = writeln!(
            page,
            "\n## Orderings\n\n{held} of {} hold. Each says what any sane model satisfies; those \
             that fail stay in this table.\n",
            report.orderings.len()
        );
        let _w = writeln!(page, "| ordering | more | at least | holds | reason | source |");
        let _w = writeln!(page, "|---|---|---|---|---|---|");
        for one in &report.orderings {
            let holds = if one.holds { "yes" } else { "**no**" };
            let _w = writeln!(
                page,
                "| {} | {:.5} | {:.5} | {holds} | {} | {} |",
                one.name, one.more, one.less, one.reason, one.source
            );
        }
    }
    Ok((page, drawn))
}

/// Computed over measured, by group.
fn drawn(report: &ValidateReport) -> Result<Vec<u8>, Failure> {
    let points = |name: &str| {
        let of = report.tests.iter().filter(|test| test.group == name);
        of.map(|test| (test.measured_m_s, test.computed_m_s)).collect()
    };
    let groups = report.groups.iter().map(|group| (group.name.clone(), points(&group.name)));
    let all = report.tests.iter().flat_map(|test| [test.measured_m_s, test.computed_m_s]);
    let most = all.fold(1.0, f64::max).ceil();
    let lines = [(1.0, "equal"), (1.3, "30 % more"), (0.7, "30 % less")]
        .map(|(factor, name)| (name, [(0.0, 0.0), (most, most * factor)]));
    figure::scatter(
        "Change of velocity: computed over measured",
        ["measured (m/s)", "computed (m/s)"],
        &groups.collect::<Vec<_>>(),
        &lines,
    )
}
