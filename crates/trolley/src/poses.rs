//! The world poses of two bodies, read from a text.
//!
//! The text has six rows of four numbers, R | t: three for A, then three for B. Empty lines and
//! everything after a `#` are ignored. Poses that were read are finite and rigid.
//!
//! ```
//! let text = "
//!     1 0 0 0
//!     0 1 0 0
//!     0 0 1 0
//!     0 -1 0 2.5    # B, turned left, 2.5 m ahead
//!     1 0 0 0
//!     0 0 1 0
//! ";
//! let [a, b] = trolley::poses::parse("poses.txt", text.as_bytes())?;
//! assert_eq!(b.translation, [2.5, 0.0, 0.0]);
//! # Ok::<(), trolley::Failure>(())
//! ```

use crate::Failure;
use crate::files::{self, InputKind};
use std::path::Path;

/// The pose of a body in the world.
///
/// ```
/// use trolley::poses::Pose;
///
/// let turned = Pose::from_degrees(90.0, 0.0, 0.0, [2.5, 0.0, 0.0]);
/// assert_eq!(turned.translation, [2.5, 0.0, 0.0]);
/// ```
pub use geometry::Pose;

/// Greatest length of a file, in bytes: 24 numbers and comments.
///
/// ```
/// let long = " ".repeat(trolley::poses::BYTES_MAX + 1); // refused when read from a file
/// # assert_eq!(long.len(), 65_537);
/// ```
pub const BYTES_MAX: usize = 64 << 10;

/// How far RᵀR may be from the identity in any entry: seven decimals are good enough.
const BEND_MAX: f64 = 1e-6;

/// The remedy for a rotation that is not rigid.
const RIGID: &str = "R turns and does nothing else: columns of length 1, at right angles, \
                     right-handed, seven decimals or more";

/// Greatest coordinate of a position (m): f64 still tells a tenth of a micrometre there.
const POSITION_MAX_M: f64 = 1e9;

/// Rows of a pose.
const ROWS: usize = 3;

/// Where in a file; both from 1, columns in characters.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    line: usize,
    column: usize,
}

/// Four numbers and where they begin.
#[derive(Debug, Default)]
struct Row {
    numbers: [f64; 4],
    place: Place,
}

/// Why a text was refused, and where.
type Refusal = (Place, String);

/// Reads the poses of A and B from a file.
///
/// ```
/// # let folder = std::env::temp_dir().join(format!("trolley-poses-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let path = folder.join("poses.txt");
/// let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n".repeat(2);
/// trolley::files::replace(&path, text.as_bytes())?;
/// let [a, b] = trolley::poses::read(&path)?;
/// assert_eq!(a, b);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If the file cannot be read or is too long, or its text is not valid: see [`parse`].
pub fn read(path: &Path) -> Result<[Pose; 2], Failure> {
    parse(&path.display().to_string(), &files::bytes(path, InputKind::Poses)?)
}

/// Reads the poses of A and B from a text; `file` is its name in messages.
///
/// ```
/// let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n".repeat(2);
/// let [a, b] = trolley::poses::parse("poses.txt", text.as_bytes())?;
/// assert_eq!(a, trolley::poses::Pose::IDENTITY);
///
/// assert!(trolley::poses::parse("poses.txt", b"1 0 0").is_err());
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If it is not six rows of four finite numbers, or a rotation is not rigid.
pub fn parse(file: &str, bytes: &[u8]) -> Result<[Pose; 2], Failure> {
    let refuse = |(place, what): Refusal| {
        let Place { line, column } = place;
        Failure::input(format!("{file}:{line}:{column}: {what}")).with_remedy(
            "write six lines of four numbers, R | t in metres: three for A, three for B",
        )
    };
    let rows = text(bytes).and_then(rows).map_err(refuse)?;
    let (of_a, of_b) = rows.split_at(ROWS);
    let pose = |name, rows: &[Row]| {
        let pose = Pose {
            rotation: [0, 1, 2].map(|i| [0, 1, 2].map(|j| rows[i].numbers[j])),
            translation: [0, 1, 2].map(|i| rows[i].numbers[3]),
        };
        bend(&pose.rotation).map_or(Ok(pose), |bend| {
            let refusal = (rows[0].place, format!("the rotation of {name} {bend}"));
            Err(refuse(refusal).with_remedy(RIGID))
        })
    };
    Ok([pose("A", of_a)?, pose("B", of_b)?])
}

fn text(bytes: &[u8]) -> Result<&str, Refusal> {
    std::str::from_utf8(bytes).map_err(|error| {
        let before = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
        (end_of(&before), "this is not UTF-8 text".to_owned())
    })
}

/// The six rows of two poses.
fn rows(text: &str) -> Result<Vec<Row>, Refusal> {
    let mut rows = Vec::new();
    for (line, content) in (1..).zip(text.lines()) {
        let content = content.split('#').next().unwrap_or_default();
        if content.trim().is_empty() {
            continue;
        }
        let row = row(line, content)?;
        if rows.len() == 2 * ROWS {
            return Err((row.place, "this is a seventh row, two poses have six".to_owned()));
        }
        rows.push(row);
    }
    if rows.len() < 2 * ROWS {
        let what = format!("the text ends after {} of the six rows of two poses", rows.len());
        return Err((end_of(text), what));
    }
    Ok(rows)
}

/// The row that a line holds, which is not blank.
fn row(line: usize, content: &str) -> Result<Row, Refusal> {
    let mut row = Row::default();
    let mut count = 0;
    for (column, word) in words(content) {
        let place = Place { line, column };
        if count == 0 {
            row.place = place;
        }
        let Some(number) = row.numbers.get_mut(count) else {
            return Err((place, format!("\"{word}\" is a fifth number, a row has four")));
        };
        let Ok(value) = word.parse::<f64>() else {
            return Err((place, format!("\"{word}\" is no number")));
        };
        if !value.is_finite() {
            return Err((place, format!("{word} is not finite")));
        }
        count += 1;
        if count == 4 && value.abs() > POSITION_MAX_M {
            return Err((place, format!("{word} m is beyond {POSITION_MAX_M:e} m")));
        }
        *number = value;
    }
    if count < row.numbers.len() {
        let column = content.trim_end().chars().count() + 1;
        return Err((
            Place { line, column },
            format!("the row ends after {count} of four numbers"),
        ));
    }
    Ok(row)
}

/// The words of a line, each with the column of its first character.
fn words(line: &str) -> impl Iterator<Item = (usize, &str)> {
    line.split_whitespace().map(|word| {
        let before = word.as_ptr() as usize - line.as_ptr() as usize;
        (line[..before].chars().count() + 1, word)
    })
}

/// The place behind the last character.
fn end_of(text: &str) -> Place {
    let last = text.rsplit('\n').next().unwrap_or_default();
    Place { line: text.matches('\n').count() + 1, column: last.chars().count() + 1 }
}

/// Refuses a pose that a text could not state: with a number that is not finite, a position beyond
/// 10⁹ m, or a rotation that is not rigid: an entry of RᵀR differs from the identity by more than
/// 10⁻⁶, or it mirrors.
///
/// ```
/// use trolley::poses::{Pose, check};
///
/// assert!(check(&Pose::from_degrees(30.0, 0.0, 0.0, [1.0, 2.0, 3.0])).is_ok());
/// let far = Pose { translation: [1e10, 0.0, 0.0], ..Pose::IDENTITY };
/// assert!(check(&far).is_err_and(|failure| failure.remedy().is_some()));
/// ```
///
/// # Errors
///
/// It says what is wrong, and the remedy; the caller knows the place.
pub fn check(pose: &Pose) -> Result<(), Failure> {
    let refuse = |what: String, remedy: &str| Err(Failure::input(what).with_remedy(remedy));
    let numbers = pose.rotation.as_flattened().iter().chain(&pose.translation);
    if let Some(number) = numbers.copied().find(|number| !number.is_finite()) {
        return refuse(format!("{number} is not finite"), "check where the pose comes from");
    }
    if let Some(far) = pose.translation.iter().find(|metres| metres.abs() > POSITION_MAX_M) {
        return refuse(format!("{far} m is beyond {POSITION_MAX_M:e} m"), "move the origin nearer");
    }
    bend(&pose.rotation).map_or(Ok(()), |bend| refuse(format!("the rotation {bend}"), RIGID))
}

/// What is wrong with a rotation, if anything is.
fn bend(rotation: &[[f64; 3]; 3]) -> Option<String> {
    let [x, y, z] = [0, 1, 2].map(|j| rotation.map(|row| row[j]));
    let dot = |u: [f64; 3], v: [f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let columns = [x, y, z];
    let mut most = 0.0_f64;
    for i in 0..3 {
        for j in 0..3 {
            let identity = if i == j { 1.0 } else { 0.0 };
            most = most.max((dot(columns[i], columns[j]) - identity).abs());
        }
    }
    let cross = [y[1] * z[2] - y[2] * z[1], y[2] * z[0] - y[0] * z[2], y[0] * z[1] - y[1] * z[0]];
    // Entries are finite, but their products need not be.
    if !(most <= BEND_MAX) {
        Some(format!("is not rigid: RᵀR differs from the identity by {most:.1e}"))
    } else if dot(x, cross) < 0.0 {
        Some("mirrors the body: its determinant is -1".to_owned())
    } else {
        None
    }
}

#[cfg(test)]
mod tests;
