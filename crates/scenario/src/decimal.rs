//! Numbers in the text of a scenario that a program writes.

/// A number as TOML has it: with a decimal point or an exponent, in the fewest digits that read
/// back as the same number.
///
/// ```
/// let written = [1.0, -0.0, 0.1, 12345.6789, 1e-7, 3e16].map(trolley_scenario::decimal);
/// assert_eq!(written, ["1.0", "-0.0", "0.1", "12345.6789", "1e-7", "3e16"]);
/// ```
#[must_use]
pub fn decimal(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e16).contains(&size) {
        return format!("{value:e}");
    }
    let text = value.to_string();
    if text.contains('.') { text } else { text + ".0" }
}

#[cfg(test)]
mod tests {
    //! What is written is read back, bit for bit.

    use super::decimal;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_number_comes_back_and_looks_like_a_float(value in any::<f64>()) {
            let written = decimal(value);
            prop_assert_eq!(written.parse::<f64>().unwrap().to_bits(), value.to_bits());
            prop_assert!(written.contains(['.', 'e']), "{}", written);
            let read: toml::Table = format!("x = {written}").parse().unwrap();
            prop_assert_eq!(read["x"].as_float().unwrap().to_bits(), value.to_bits());
        }
    }
}
