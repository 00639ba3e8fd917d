//! Figures of a study's page in words.

use super::maps;
use crate::knob::SweepKnob;

/// With a comma before every third digit from the end.
pub(super) fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A share in percent.
pub(super) fn percent(part: u64, all: u64) -> String {
    if all == 0 { "–".to_owned() } else { of_share(part as f64 / all as f64) }
}

/// A share in percent, with as many digits as are significant.
pub(super) fn of_share(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0 %".to_owned(),
        p if p < 0.01 => "&lt; 0.01 %".to_owned(),
        p if p < 10.0 => format!("{p:.2} %"),
        p => format!("{p:.1} %"),
    }
}

/// A number of percentage points; what is no more than half of the last digit is not 0.
pub(super) fn points(value: f64, digits: usize) -> String {
    let said = format!("{:.digits$}", value.abs());
    let sign = if value < 0.0 { "−" } else { "" };
    match said.parse::<f64>() {
        _ if value == 0.0 => "0".to_owned(),
        Ok(0.0) => format!("{} 0", if value < 0.0 { "&lt;" } else { "&gt;" }),
        _ => format!("{sign}{said}"),
    }
}

/// The value of a knob in words: "reaction later 1.2 s".
pub(super) fn in_words(knob: SweepKnob, value: f64) -> String {
    let (what, unit) = knob.says().rsplit_once(", ").unwrap_or((knob.says(), ""));
    format!("{what} {} {unit}", maps::number(value)).trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    //! Numbers of the page say what they are.

    use super::*;

    #[test]
    fn zeros_are_zeros_and_nothing_else_is() {
        let cases = [
            (0.0, 4, "0"),
            (0.000_02, 4, "&gt; 0"),
            (-0.000_02, 4, "&lt; 0"),
            (-0.0003, 4, "−0.0003"),
            (88.23, 2, "88.23"),
        ];
        for (value, digits, expected) in cases {
            assert_eq!(points(value, digits), expected);
        }
    }

    #[test]
    fn a_value_stands_before_its_unit() {
        assert_eq!(in_words(SweepKnob::Reaction, 1.2), "reaction later 1.2 s");
        assert_eq!(in_words(SweepKnob::Offset, -0.6), "ego further left −0.6 m");
    }
}
