//! Text that fits a terminal.

/// Width of a line of prose where nothing is known of the terminal, and at most.
pub const COLUMNS: usize = 100;

/// Breaks a line at spaces so that it has `columns` characters at most; continuation lines are
/// indented by two more than the line. A word that is longer stays whole.
#[must_use]
pub fn wrap(line: &str, columns: usize) -> String {
    broken(line, columns, indent(line) + 2)
}

/// Breaks every line that is longer than `columns` characters, at spaces. What goes on stands below
/// the value of a line like "label   value", else two columns further in than its line. A word that
/// is longer stays whole: a number, a path, a hash.
///
/// ```
/// let said = "cores    2 granted: [0, 1]\nswap     none";
/// let folded = "cores    2 granted:\n         [0, 1]\nswap     none";
/// assert_eq!(trolley_report::text::fold(said, 20), folded);
/// ```
#[must_use]
pub fn fold(text: &str, columns: usize) -> String {
    let folded = |line: &str| {
        let value = value(line).filter(|column| *column <= columns / 2);
        broken(line, columns, value.unwrap_or(indent(line) + 2))
    };
    text.split('\n').map(folded).collect::<Vec<_>>().join("\n")
}

/// How far a line is indented.
fn indent(line: &str) -> usize {
    line.len() - line.trim_start_matches(' ').len()
}

/// The column in which the value of a line begins: after the last two spaces or more among its
/// labels, which are a word each.
fn value(line: &str) -> Option<usize> {
    let mut value = None;
    let mut column = indent(line);
    let mut rest = &line[column..];
    while let Some((label, after)) = rest.split_once("  ") {
        let spaces = 2 + indent(after);
        // A sentence with a gap in it is no label.
        if label.contains(": ") || label.chars().count() > 20 {
            break;
        }
        column += label.chars().count() + spaces;
        value = Some(column);
        rest = after.trim_start_matches(' ');
    }
    value
}

/// A line, and what of it goes on with this indent.
fn broken(line: &str, columns: usize, goes_on: usize) -> String {
    if line.chars().count() <= columns {
        return line.to_owned();
    }
    let start = indent(line);
    let mut text = " ".repeat(start);
    let mut column = start;
    let mut begins = true;
    for word in line[start..].split(' ') {
        let width = word.chars().count();
        if !begins && column + 1 + width > columns {
            text.truncate(text.trim_end_matches(' ').len());
            text.push('\n');
            text.push_str(&" ".repeat(goes_on));
            column = goes_on;
            begins = true;
        }
        // The gap between two columns of a table is no beginning of a line.
        if begins && word.is_empty() {
            continue;
        }
        if !begins {
            text.push(' ');
            column += 1;
        }
        text.push_str(word);
        column += width;
        begins = false;
    }
    text
}

#[cfg(test)]
mod tests {
    //! Lines fit, and no word is lost, cut or moved.
    use super::*;

    const LINES: &[&str] = &[
        "  triangles   2,000, 12 duplicates dropped, 4 of zero area kept, and so on and on and on",
        "note     governor         the kernel does not say what clocks it has, nor when it does",
        "                          → nothing to do here: a virtual machine, or firmware decides",
        "Every way hits somebody, as far as is known. Least harm: brake, swerve left, and stop.",
        "      1.5      22.5     333.5    4444.5   55555.5  666666.5  7777777.5 88888888.5",
        "short",
        "",
    ];

    #[test]
    fn every_line_fits_and_keeps_its_words() {
        for columns in [40, 60, 80] {
            for line in LINES {
                for text in [fold(line, columns), wrap(line, columns)] {
                    let words = |text: &str| {
                        text.split_whitespace().map(str::to_owned).collect::<Vec<String>>()
                    };
                    assert_eq!(words(&text), words(line));
                    let longest = text.lines().map(|line| line.chars().count()).max();
                    assert!(longest.unwrap_or(0) <= columns, "{columns}: {text}");
                    assert!(text.lines().all(|line| !line.ends_with(' ')), "{text:?}");
                }
            }
        }
    }

    #[test]
    fn what_goes_on_stands_below_its_value() {
        for line in &LINES[..3] {
            let folded = fold(line, 60);
            let lines: Vec<&str> = folded.lines().collect();
            let starts: Vec<usize> = lines.iter().map(|line| indent(line)).collect();
            let value = value(line).unwrap_or(indent(line) + 2);
            assert!(starts.len() > 1 && starts[1..].iter().all(|at| *at == value), "{folded}");
        }
    }

    #[test]
    fn a_word_that_is_longer_stays_whole() {
        let hash = "0123456789abcdef".repeat(4);
        let line = format!("  source      blake3 {hash}");
        assert!(fold(&line, 60).contains(&hash));
    }
}
