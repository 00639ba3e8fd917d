//! What all pages have in common: a frame whose content security policy forbids fetching anything,
//! text as markup, the 3D view; and the page of a measurement.

use crate::measurement::MeasurementPage;

pub(crate) mod chart;

/// three.js, cut down and minified: `vendor/README.md`.
const THREE: &str = include_str!("../vendor/three.min.js");
/// Its licence.
const THREE_LICENCE: &str = include_str!("../vendor/three.LICENSE");
const STYLE: &str = include_str!("../page/style.css");
const SCRIPT: &str = include_str!("../page/view.js");

/// Text as markup.
#[must_use]
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            c if c.is_control() && c != '\n' => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}

/// A share in percent, with as many digits as are significant.
pub(crate) fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0".to_owned(),
        p if p < 0.01 => "&lt; 0.01".to_owned(),
        p if p < 10.0 => format!("{p:.2}"),
        p => format!("{p:.1}"),
    }
}

/// A range in percent, of which only one end is said where both are the same.
pub(crate) fn span(low: f64, high: f64) -> String {
    let [low, high] = [low, high].map(percent);
    if low == high { high } else { format!("{low}–{high}") }
}

/// Markup in which a number stays on a line with its unit, its error, and what it is below.
fn glued(markup: &str) -> String {
    const UNITS: [&str; 12] =
        ["%", "m/s²", "m/s", "ms", "mm", "kJ", "kg", "s", "m", "±", "σ", "× as given"];
    let mut out = String::with_capacity(markup.len());
    let mut rest = markup;
    let is_digit = |c: char| c.is_ascii_digit();
    while let Some((before, after)) = rest.split_once(' ') {
        let is_unit = |unit: &&str| {
            let next = after.strip_prefix(*unit);
            next.is_some_and(|next| !next.starts_with(|c: char| c.is_alphanumeric() || c == '='))
        };
        let is_sign = before.ends_with('±')
            || (before.ends_with("&lt;") || before.ends_with("&gt;"))
                && after.starts_with(is_digit);
        let is_one = before.ends_with(is_digit) && UNITS.iter().any(is_unit) || is_sign;
        out.push_str(before);
        out.push(if is_one { '\u{a0}' } else { ' ' });
        rest = after;
    }
    out + rest
}

/// A page about a measurement.
pub(crate) fn measurement(measurement: &MeasurementPage) -> String {
    framed(&measurement.title, &measurement.markup(), "", "")
}

/// The scripts of the 3D view, whose data is in the page already.
pub(crate) fn view_scripts() -> String {
    format!(
        "<script>{THREE}</script>\n<script>{SCRIPT}</script>\n<details class=\"licence\">\
         <summary>three.js 0.187.0, MIT licence</summary><pre>{}</pre></details>",
        escape(THREE_LICENCE)
    )
}

/// The element that holds JSON for a script.
pub(crate) fn data_element(json: &str) -> String {
    // In JSON `<` occurs in strings only; escaped, it cannot end the script element.
    let data = json.replace('<', "\\u003c");
    format!("<script type=\"application/json\" id=\"data\">{data}</script>\n")
}

/// The frame of every page, with further style, and scripts at its end.
#[must_use]
pub fn framed(title: &str, body: &str, style: &str, scripts: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src \
         'unsafe-inline'; script-src 'unsafe-inline'; img-src data:\">\n\
         <title>{}</title>\n<style>{STYLE}{style}</style>\n</head>\n<body>\n<main>\n{}\n\
         </main>\n{scripts}\n</body>\n</html>\n",
        escape(title),
        glued(body)
    )
}

#[cfg(test)]
mod tests {
    //! A number and its unit are not parted, and nothing else is changed.

    use super::*;

    #[test]
    fn a_number_stays_with_its_unit() {
        let cases = [
            ("0.76 % worse", "0.76\u{a0}% worse"),
            (
                "after 2.31 s, 3 m; 5 m/s (1 m/s²)",
                "after 2.31\u{a0}s, 3\u{a0}m; 5\u{a0}m/s (1\u{a0}m/s²)",
            ),
            ("0.51 ± 0.03 %", "0.51\u{a0}±\u{a0}0.03\u{a0}%"),
            ("0 % against &lt; 0.01 %", "0\u{a0}% against &lt;\u{a0}0.01\u{a0}%"),
            ("3 ways, 2 suvs, 1 map", "3 ways, 2 suvs, 1 map"),
            ("2 σ, 1.3 × as given, 3 × why", "2\u{a0}σ, 1.3\u{a0}× as given, 3 × why"),
            ("<line x1=\"1 2\" s=\"3\"/>", "<line x1=\"1 2\" s=\"3\"/>"),
        ];
        for (markup, expected) in cases {
            assert_eq!(glued(markup), expected);
        }
    }

    #[test]
    fn a_range_without_width_is_one_number() {
        let cases = [(0.0, 0.0, "0"), (1e-6, 2e-6, "&lt; 0.01"), (0.0, 0.01, "0–1.00")];
        for (low, high, expected) in cases {
            assert_eq!(span(low, high), expected);
        }
    }
}
