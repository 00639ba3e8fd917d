//! Tables for a terminal: words wrap, numbers are never broken, and columns that can be done
//! without are left out where there is no room.

use crate::text::wrap;
use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Table, Width, presets};

/// A column of a table.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    header: &'static str,
    holds: Holds,
    /// On a narrow terminal columns are left out, the greatest first; 0: never.
    dispensable: u8,
}

/// What the cells of a column hold, which says where a cell may be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Holds {
    /// Words, with room for so many characters if a cell has as many.
    Words(usize),
    /// Numbers, which are never broken, on the right or on the left.
    Right,
    Left,
}

impl Column {
    /// Words, for which this is the least convenient width.
    #[must_use]
    pub const fn words(header: &'static str, room: usize) -> Self {
        Self { header, holds: Holds::Words(room), dispensable: 0 }
    }

    /// Numbers, aligned to the right.
    #[must_use]
    pub const fn numbers(header: &'static str) -> Self {
        Self { header, holds: Holds::Right, dispensable: 0 }
    }

    /// Numbers and what belongs to them, aligned to the left.
    #[must_use]
    pub const fn figures(header: &'static str) -> Self {
        Self { header, holds: Holds::Left, dispensable: 0 }
    }

    /// May be left out on a narrow terminal, before those with a smaller number.
    #[must_use]
    pub const fn dispensable(self, dispensable: u8) -> Self {
        Self { dispensable, ..self }
    }

    /// The narrowest that it may be with these cells.
    fn least<'c>(&self, cells: impl Iterator<Item = &'c str>) -> usize {
        let length = |text: &str| text.chars().count();
        let longest_word = |text: &str| text.split_whitespace().map(length).max().unwrap_or(0);
        let longest_line = |text: &str| text.lines().map(length).max().unwrap_or(0);
        let least = |cell: &str| match self.holds {
            Holds::Words(room) => {
                longest_line(cell).min(room.max(longest_word(cell).min(2 * room)))
            }
            Holds::Right | Holds::Left => longest_line(cell),
        };
        cells.map(least).max().unwrap_or(0).max(longest_word(self.header))
    }
}

/// The lines of a table that has `width` characters at most, and below it the headers of what it
/// leaves out for that. Each row has a cell for each column; cells may have several lines.
///
/// # Panics
///
/// If a row has fewer cells than there are columns.
#[must_use]
pub fn fitted(columns: &[Column], rows: &[Vec<String>], width: usize) -> String {
    let cells = |number: usize| rows.iter().map(move |row| row[number].as_str());
    let least: Vec<usize> =
        columns.iter().enumerate().map(|(number, of)| of.least(cells(number))).collect();
    let mut kept: Vec<usize> = (0..columns.len()).collect();
    let needed = |kept: &[usize]| kept.iter().map(|number| least[*number] + 1).sum::<usize>() - 1;
    while needed(&kept) > width {
        let is_next = |number: &&usize| columns[**number].dispensable;
        let Some(next) = kept.iter().max_by_key(is_next).copied() else { break };
        if columns[next].dispensable == 0 {
            break;
        }
        kept.retain(|number| *number != next);
    }
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(u16::try_from(width).unwrap_or(u16::MAX));
    table.set_header(kept.iter().map(|number| columns[*number].header));
    for row in rows {
        table.add_row(kept.iter().map(|number| row[*number].as_str()));
    }
    for (place, column) in table.column_iter_mut().enumerate() {
        let padding = u16::from(place > 0);
        column.set_padding((padding, 0));
        let least = u16::try_from(least[kept[place]]).unwrap_or(u16::MAX);
        let least = Width::Fixed(least.saturating_add(padding));
        column.set_constraint(ColumnConstraint::LowerBoundary(least));
        if columns[kept[place]].holds == Holds::Right {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let table = table.to_string();
    let mut lines: Vec<String> = table.lines().map(|line| line.trim_end().to_owned()).collect();
    let left_out: Vec<&str> = (0..columns.len())
        .filter(|number| !kept.contains(number))
        .map(|number| columns[number].header)
        .collect();
    if !left_out.is_empty() {
        let said = format!("Left out to fit {width} columns: {}.", left_out.join(", "));
        lines.push(wrap(&said, width));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    //! A table fits, breaks no number, and says what it leaves out.
    use super::*;

    #[test]
    fn a_table_fits_and_breaks_no_number() {
        let columns = [
            Column::numbers("#"),
            Column::words("candidate", 12),
            Column::words("meets", 24).dispensable(1),
            Column::figures("range %").dispensable(2),
        ];
        let names = ["brake", "swerve left, then brake along the barrier and stop there"];
        let meets = "2.55 s oncoming, light (0.8 m/s)\n2.75 s articulated-lorry-and-trailer, heavy";
        let rows: Vec<Vec<String>> = (names.iter().enumerate())
            .map(|(number, name)| {
                let range = "12345.67–98765.43".to_owned();
                vec![number.to_string(), (*name).to_owned(), meets.to_owned(), range]
            })
            .collect();
        for width in [40, 60, 80, 120] {
            let text = fitted(&columns, &rows, width);
            let longest = text.lines().map(|line| line.chars().count()).max();
            assert!(longest.unwrap_or(0) <= width, "{width}:\n{text}");
            let ranges = text.matches("12345.67–98765.43").count();
            assert_eq!(ranges, if width < 80 { 0 } else { 2 }, "{text}");
            assert_eq!(text.contains("Left out to fit"), width < 80, "{text}");
            let words = ["candidate", "barrier", "oncoming,", "articulated-lorry-and-trailer,"];
            for word in &words[..if width < 60 { 2 } else { 4 }] {
                assert!(text.contains(word), "{word} at {width}:\n{text}");
            }
        }
    }
}
