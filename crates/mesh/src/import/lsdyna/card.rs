//! The text of a deck: keywords, their data lines (*cards*), and the fields of these.

/// A keyword, its options, and its data lines.
pub(super) struct Block<'t> {
    /// Without the star, upper case.
    pub(super) keyword: String,
    pub(super) line: usize,
    pub(super) cards: Vec<(usize, &'t str)>,
}

/// Keywords with their data lines; comments and blank lines are dropped.
pub(super) fn blocks(text: &str) -> Vec<Block<'_>> {
    let mut blocks: Vec<Block<'_>> = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        if line.starts_with('$') {
            continue;
        }
        if let Some(keyword) = line.strip_prefix('*') {
            let keyword = keyword.trim().to_ascii_uppercase();
            // `*KEYWORD LONG=Y`: what follows a blank is also an option.
            let keyword = keyword.split_whitespace().collect::<Vec<_>>().join("_");
            blocks.push(Block { keyword, line: number, cards: Vec::new() });
        } else if let Some(block) = blocks.last_mut() {
            // A title may be blank, but is data.
            let has_title = block.keyword.starts_with("PART") || block.keyword.ends_with("_TITLE");
            if !line.trim().is_empty() || has_title {
                block.cards.push((number, line));
            }
        }
    }
    blocks
}

/// The fields of a card: between commas, else in columns of these widths, without trailing empty
/// ones.
pub(super) fn fields<'t>(card: &'t str, widths: &[usize]) -> Vec<&'t str> {
    let mut fields: Vec<&str> = if card.contains(',') {
        card.split(',').take(widths.len()).map(str::trim).collect()
    } else {
        let mut at = 0;
        widths
            .iter()
            .map(|width| {
                let end = (at + width).min(card.len());
                // Columns are bytes; a character across a column boundary is not part of a number.
                let field = card.get(at.min(card.len())..end).unwrap_or("?");
                at += width;
                field.trim()
            })
            .collect()
    };
    while fields.last().is_some_and(|field| field.is_empty()) {
        fields.pop();
    }
    fields
}

/// The mean of the numbers above zero among some fields.
pub(super) fn mean(fields: &[&str]) -> Option<f64> {
    let values = fields.iter().filter_map(|text| real(text)).filter(|value| *value > 0.0);
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// An integer; an empty field is zero.
pub(super) fn whole(field: Option<&&str>) -> Option<u64> {
    match field {
        None => None,
        Some(&"") => Some(0),
        Some(text) => text.parse().ok(),
    }
}

/// A number as Fortran writes it: the exponent may be a D, or follow without a letter.
pub(super) fn real(text: &str) -> Option<f64> {
    if let Ok(value) = text.parse() {
        return Some(value);
    }
    let text = text.replace(['d', 'D'], "e");
    if let Ok(value) = text.parse() {
        return Some(value);
    }
    let sign = text.get(1..)?.rfind(['+', '-'])? + 1;
    format!("{}e{}", &text[..sign], &text[sign..]).parse().ok()
}
