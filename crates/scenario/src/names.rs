//! Words that a scenario may use for a thing, and what to say to another word.

use crate::engine::Scheme;
use crate::error::Misfit;
use model::{Build, Kind, Seat};

/// The allowed words of one setting with their meaning.
pub(crate) type Words<T> = [(&'static str, T)];

/// Shapes that can be generated. A building comes from a file only.
pub(crate) const SHAPES: &Words<Kind> = &[
    ("sedan", Kind::Sedan),
    ("suv", Kind::Suv),
    ("truck", Kind::Truck),
    ("bus", Kind::Bus),
    ("motorcycle", Kind::Motorcycle),
    ("cyclist", Kind::Cyclist),
    ("pedestrian", Kind::Pedestrian),
    ("wall", Kind::Wall),
    ("pole", Kind::Pole),
];

/// Seats.
pub(crate) const SEATS: &Words<Seat> = &[
    ("front-left", Seat::FrontLeft),
    ("front-right", Seat::FrontRight),
    ("rear-left", Seat::RearLeft),
    ("rear-middle", Seat::RearMiddle),
    ("rear-right", Seat::RearRight),
    ("rider", Seat::Rider),
];

/// Ways to build a tree.
pub(crate) const BUILDS: &Words<Build> =
    &[("seed", Build::Seed), ("literal", Build::Literal), ("sah", Build::Sah)];

/// Match schemes.
pub(crate) const SCHEMES: &Words<Scheme> = &[("best-match-load", Scheme::BestMatchLoad)];

/// The meaning of a word, or what the words are.
pub(crate) fn meaning<T: Copy>(
    words: &Words<T>,
    setting: &'static str,
    word: &str,
) -> Result<T, Misfit> {
    let found = words.iter().find(|(known, _)| *known == word);
    found.map(|(_, meaning)| *meaning).ok_or_else(|| {
        let known: Vec<&str> = words.iter().map(|(known, _)| *known).collect();
        let fault = format!("{setting} {} is not known", quoted(word));
        Misfit::new(
            setting,
            fault,
            choices(&format!("known here: {}", known.join(", ")), &known, word),
        )
    })
}

/// The word for a meaning; "?" for one that has no word.
pub(crate) fn word<T: Copy + PartialEq>(words: &Words<T>, meaning: T) -> &'static str {
    words.iter().find(|(_, known)| *known == meaning).map_or("?", |(word, _)| word)
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

/// What there is, and which of it was probably meant.
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
    // Names are at most 60 characters long; comparing more of a wrong one helps nobody.
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
