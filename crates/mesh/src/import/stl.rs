//! STL, binary and ASCII, by crate `stl_io`.
//!
//! `stl_io` reads the first `solid` of an ASCII file and silently drops the rest. So the text is
//! split at `solid` lines, whose names are the parts, and anything outside a solid is an error.

use super::collect::Collector;
use super::{FilePosition, ImportError, MeshDefect, format};
use std::io::Cursor;

pub(super) fn read(bytes: &[u8], into: &mut Collector<'_>) -> Result<(), ImportError> {
    let is_text = !bytes[..bytes.len().min(1024)].contains(&0);
    let begins =
        bytes.trim_ascii_start().get(..5).is_some_and(|b| b.eq_ignore_ascii_case(b"solid"));
    if is_text && begins && !format::is_binary_stl(bytes) {
        ascii(bytes, into)
    } else {
        binary(bytes, into)
    }
}

fn binary(bytes: &[u8], into: &mut Collector<'_>) -> Result<(), ImportError> {
    let whole = |into: &Collector<'_>, fault| into.fail(FilePosition::Whole, fault);
    let Some(count) = format::stated_triangles(bytes) else {
        let fault = match bytes.len() {
            0 => MeshDefect::Empty(": the file is empty".to_owned()),
            n => MeshDefect::Truncated(format!("a binary STL has at least 84 bytes, this one {n}")),
        };
        return Err(whole(into, fault));
    };
    let (stated, found) = (84 + 50 * u64::from(count), bytes.len() as u64);
    if found < stated {
        let fault = format!("it states {count} triangles, {stated} bytes, but has {found} bytes");
        return Err(whole(into, MeshDefect::Truncated(fault)));
    }
    if found > stated {
        into.notes.push(format!("{} bytes after the last triangle left out", found - stated));
    }
    if count == 0 {
        return Err(whole(into, MeshDefect::Empty(": it states 0 triangles".to_owned())));
    }
    let part = into.part("", Vec::new())?;
    // The crate treats a file as ASCII if its header begins like one; the length has already
    // decided.
    let mut plain = vec![0_u8; 80];
    plain.extend_from_slice(&bytes[80..]);
    let mut source = Cursor::new(plain);
    let facets = stl_io::create_stl_reader(&mut source)
        .map_err(|fault| whole(into, MeshDefect::Syntax(fault.to_string())))?;
    for (number, facet) in facets.enumerate() {
        let place = || FilePosition::Element(format!("triangle {number}"));
        let facet =
            facet.map_err(|fault| into.fail(place(), MeshDefect::Syntax(fault.to_string())))?;
        add(&facet, part, place, into)?;
    }
    Ok(())
}

fn add(
    facet: &stl_io::Triangle,
    part: u16,
    place: impl Fn() -> FilePosition,
    into: &mut Collector<'_>,
) -> Result<(), ImportError> {
    let [a, b, c] = facet.vertices.map(|vertex| vertex.0.map(f64::from));
    let corners = [into.point(a, &place)?, into.point(b, &place)?, into.point(c, &place)?];
    into.triangle(corners, part)
}

/// The lines of one solid, without its `solid` line.
struct Solid {
    name: String,
    /// Line number of each line below.
    lines: Vec<usize>,
    text: String,
    closed: bool,
}

fn ascii(bytes: &[u8], into: &mut Collector<'_>) -> Result<(), ImportError> {
    let text = String::from_utf8_lossy(bytes);
    let mut solids: Vec<Solid> = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let trimmed = line.trim();
        let word = trimmed.split_whitespace().next().unwrap_or("").to_ascii_lowercase();
        match (word.as_str(), solids.last_mut().filter(|solid| !solid.closed)) {
            ("", _) => {}
            ("solid", Some(_)) => {
                let fault = "a solid begins before the one before it ends".to_owned();
                return Err(into.fail(FilePosition::Line(number), MeshDefect::Syntax(fault)));
            }
            ("solid", None) => {
                let name = trimmed[5..].trim().to_owned();
                solids.push(Solid { name, lines: vec![], text: String::new(), closed: false });
            }
            (_, Some(solid)) => {
                solid.closed = word == "endsolid";
                solid.lines.push(number);
                solid.text.push_str(&trimmed.to_ascii_lowercase());
                solid.text.push('\n');
            }
            (_, None) => {
                let fault = format!("\"{word}\" stands outside of a solid");
                return Err(into.fail(FilePosition::Line(number), MeshDefect::Syntax(fault)));
            }
        }
    }
    let number = solids.len();
    for solid in &solids {
        solid.read(into)?;
    }
    if into.corners.is_empty() {
        let what = match number {
            1 => ": its solid is empty".to_owned(),
            number => format!(": its {number} solids are empty"),
        };
        let fault = MeshDefect::Empty(what);
        return Err(into.fail(FilePosition::Whole, fault));
    }
    Ok(())
}

/// Lines of one facet: facet, outer loop, three vertices, endloop, endfacet.
const FACET_LINES: usize = 7;

impl Solid {
    fn read(&self, into: &mut Collector<'_>) -> Result<(), ImportError> {
        if !self.closed {
            let fault = format!("the file ends inside solid \"{}\"", self.name);
            return Err(into.fail(FilePosition::Whole, MeshDefect::Truncated(fault)));
        }
        if self.lines.len() == 1 {
            into.notes.push(format!("solid \"{}\" is empty", self.name));
            return Ok(());
        }
        let part = into.part(&self.name, Vec::new())?;
        let mut source = Cursor::new(format!("solid part\n{}", self.text).into_bytes());
        let facets = stl_io::create_stl_reader(&mut source).map_err(|fault| {
            into.fail(FilePosition::Whole, MeshDefect::Syntax(fault.to_string()))
        })?;
        // Any fault ends the loop: every facet before it took its seven lines.
        for (number, facet) in facets.enumerate() {
            let line = self.lines.get(number * FACET_LINES).or(self.lines.last()).copied();
            let place = || FilePosition::Line(line.unwrap_or(1));
            let facet = facet.map_err(|fault| {
                into.fail(
                    place(),
                    MeshDefect::Syntax(format!("in the facet that begins here: {fault}")),
                )
            })?;
            add(&facet, part, place, into)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
