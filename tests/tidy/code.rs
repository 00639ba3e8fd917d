//! Source text without what is not code, and without what is only there for tests.
//!
//! Not a parser of Rust: it knows comments, literals and braces, and keeps the line of everything.

/// `text` with comments, strings and characters blanked.
pub(crate) fn code(text: &str) -> String {
    let text: Vec<char> = text.chars().collect();
    let mut code = String::with_capacity(text.len());
    let mut at = 0;
    while at < text.len() {
        let end = literal_or_comment(&text, at).unwrap_or(at);
        code.extend(text[at..end].iter().map(|c| if *c == '\n' { '\n' } else { ' ' }));
        if end == at {
            code.push(text[at]);
        }
        at = end.max(at + 1);
    }
    code
}

/// Where what begins at `at` ends, if it is a literal or a comment.
fn literal_or_comment(text: &[char], at: usize) -> Option<usize> {
    let here = |offset: usize| text.get(at + offset).copied().unwrap_or('\n');
    match (here(0), here(1)) {
        ('/', '/') => Some(find(text, at, &['\n'])),
        ('/', '*') => Some(block_comment(text, at)),
        ('"', _) => Some(string(text, at + 1)),
        ('\'', '\\') => Some(find(text, at + 3, &['\'']) + 1),
        // Without the second quote it is a lifetime.
        ('\'', _) => (here(2) == '\'').then_some(at + 3),
        ('r', _) | ('b' | 'c', 'r') if at == 0 || !in_word(text[at - 1]) => raw_string(text, at),
        _ => None,
    }
    .map(|end| end.min(text.len()))
}

/// Where `what` next stands, or the end.
fn find(text: &[char], from: usize, what: &[char]) -> usize {
    let rest = text.get(from..).unwrap_or_default();
    rest.windows(what.len()).position(|part| part == what).map_or(text.len(), |at| from + at)
}

fn block_comment(text: &[char], at: usize) -> usize {
    let (mut depth, mut end) = (1, at + 2);
    while depth > 0 && end < text.len() {
        let step = match text[end..] {
            ['/', '*', ..] => 1,
            ['*', '/', ..] => -1,
            _ => 0,
        };
        depth += step;
        end += if step == 0 { 1 } else { 2 };
    }
    end
}

fn string(text: &[char], mut at: usize) -> usize {
    while at < text.len() && text[at] != '"' {
        at += if text[at] == '\\' { 2 } else { 1 };
    }
    at + 1
}

fn raw_string(text: &[char], at: usize) -> Option<usize> {
    let hashes_at = at + if text[at] == 'r' { 1 } else { 2 };
    let hashes = text.get(hashes_at..)?.iter().take_while(|c| **c == '#').count();
    let quote = hashes_at + hashes;
    if text.get(quote) != Some(&'"') {
        return None;
    }
    let mut end = vec!['#'; hashes + 1];
    end[0] = '"';
    Some(find(text, quote + 1, &end) + end.len())
}

/// Whether a character can be part of a name.
pub(crate) fn in_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The names, keywords and numbers of a line of code.
pub(crate) fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split(|c| !in_word(c)).filter(|word| !word.is_empty())
}

/// Whether a line of code calls a macro.
pub(crate) fn calls(line: &str, name: &str) -> bool {
    let call = format!("{name}!");
    line.match_indices(&call).any(|(at, _)| !line[..at].ends_with(in_word))
}

/// What is left of code once everything behind `#[cfg(test)]` is blanked, and the modules among
/// that which have a file of their own.
pub(crate) fn outside_tests(code: &str) -> (String, Vec<String>) {
    const MARK: &str = "#[cfg(test)]";
    let (mut left, mut modules) = (String::new(), Vec::new());
    let mut rest = code;
    while let Some((before, item)) = rest.split_once(MARK) {
        left.push_str(before);
        let start = item.find(['{', ';']).unwrap_or(item.len());
        let len = if item[start..].starts_with('{') {
            start + braces(&item[start..])
        } else {
            let mut names = words(&item[..start]).skip_while(|word| *word != "mod");
            modules.extend(names.nth(1).map(str::to_owned));
            start
        };
        left.extend(item[..len].matches('\n'));
        rest = &item[len..];
    }
    left.push_str(rest);
    (left, modules)
}

/// The length of what stands in braces, from the first to the one that closes it.
pub(crate) fn braces(code: &str) -> usize {
    let mut depth = 0;
    for (at, c) in code.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at + 1;
        }
    }
    code.len()
}
