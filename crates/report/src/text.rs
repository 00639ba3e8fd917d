//! Text that fits a terminal.

/// Width that all text fits.
pub const COLUMNS: u16 = 100;

/// Breaks a line at spaces so that it fits; continuation lines are indented by two columns.
#[must_use]
pub fn wrap(line: &str) -> String {
    let words = line.trim_start();
    let indent = line.len() - words.len();
    let mut text = " ".repeat(indent);
    let mut column = indent;
    for (number, word) in words.split(' ').enumerate() {
        let width = word.chars().count();
        if number > 0 && column + 1 + width > usize::from(COLUMNS) {
            text.push('\n');
            text.push_str(&" ".repeat(indent + 2));
            column = indent + 2;
        } else if number > 0 {
            text.push(' ');
            column += 1;
        }
        text.push_str(word);
        column += width;
    }
    text
}
