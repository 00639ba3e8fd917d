//! Words that a scenario may use for a thing, and what to say to another word.

use crate::engine::Scheme;
use crate::error::Misfit;
use body::{Build, Seat, Shape};

/// A thing that a scenario calls by a word.
pub(crate) trait Named: Copy + Sized + 'static {
    /// All values, in the order in which messages list them.
    const ALL: &'static [Self];

    /// The word.
    fn word(self) -> &'static str;

    /// What a word means.
    fn from_word(word: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|thing| thing.word() == word)
    }
}

impl Named for Shape {
    const ALL: &'static [Self] = &Shape::ALL;

    fn word(self) -> &'static str {
        self.name()
    }
}

impl Named for Seat {
    const ALL: &'static [Self] = &Seat::ALL;

    fn word(self) -> &'static str {
        self.name()
    }
}

impl Named for Build {
    const ALL: &'static [Self] = &Build::ALL;

    fn word(self) -> &'static str {
        self.name()
    }

    fn from_word(word: &str) -> Option<Self> {
        Self::from_name(word)
    }
}

impl Named for Scheme {
    const ALL: &'static [Self] = &Scheme::ALL;

    fn word(self) -> &'static str {
        self.name()
    }
}

/// All words for one kind of thing.
pub(crate) fn all<T: Named>() -> Vec<&'static str> {
    T::ALL.iter().map(|thing| thing.word()).collect()
}

/// The value of a word, or an error that lists all words.
pub(crate) fn meaning<T: Named>(setting: &'static str, word: &str) -> Result<T, Misfit> {
    T::from_word(word).ok_or_else(|| {
        let known = all::<T>();
        let list = format!("known here: {}", known.join(", "));
        let fault = format!("{setting} {} is not known", quoted(word));
        Misfit::new(setting, fault, choices(&list, &known, word))
    })
}

/// A name from the file between quotes: control characters escaped, long ones cut.
pub(crate) fn quoted(name: &str) -> String {
    const SHOWN: usize = 40;
    if name.chars().nth(SHOWN).is_none() {
        return format!("{name:?}");
    }
    let head: String = name.chars().take(SHOWN).collect();
    format!("{:?}", head + "…")
}

/// The known words, and the one that was probably meant.
pub(crate) fn choices(list: &str, known: &[&str], written: &str) -> String {
    match nearest(known, written) {
        Some(name) => format!("{list}.  Did you mean {name:?}?"),
        None => list.to_owned(),
    }
}

/// The known name nearest to what was written, if it is near: a third of its letters may differ.
fn nearest<'k>(known: &[&'k str], written: &str) -> Option<&'k str> {
    let near = known.iter().map(|name| (distance(name, written), *name));
    let (steps, name) = near.min_by_key(|(steps, _)| *steps)?;
    let allowed = 1.max(name.chars().count() / 3);
    (steps <= allowed).then_some(name)
}

/// How many letters must be inserted, dropped, changed or swapped with a neighbour, case ignored:
/// optimal string alignment (Boytsov, ACM J. Exp. Algorithmics 16, 2011, section 2).
fn distance(a: &str, b: &str) -> usize {
    // Names are at most 60 characters long; comparing more of a wrong one is useless.
    let letters = |s: &str| -> Vec<char> {
        s.chars().take(64).map(|letter| letter.to_ascii_lowercase()).collect()
    };
    let (a, b) = (letters(a), letters(b));
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            rows[i][j] = if i == 0 || j == 0 {
                i + j
            } else {
                let change = usize::from(a[i - 1] != b[j - 1]);
                let swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
                let plain =
                    (rows[i - 1][j] + 1).min(rows[i][j - 1] + 1).min(rows[i - 1][j - 1] + change);
                if swapped { plain.min(rows[i - 2][j - 2] + 1) } else { plain }
            };
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests;
