//! PLY, ASCII and binary, by crate `ply-rs-bw`.
//!
//! Header lines that begin with no known keyword are skipped and noted: real files contain them (an
//! exporter's signature without "comment"). Counts are checked against the file size before
//! anything is allocated for them.

use super::collect::{Collector, TRIANGLES_MAX};
use super::{FilePosition, ImportError, MeshDefect};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Header, Property, PropertyAccess, PropertyAccessResult};
use std::io::{Cursor, Read as _};

pub(super) fn read(bytes: &[u8], into: &mut Collector<'_>) -> Result<(), ImportError> {
    let (header, body_at, left_out) = split_header(bytes, into)?;
    into.notes.extend(left_out.iter().map(|line| format!("header line {line} left out")));
    let mut reader = Reader::new(Cursor::new(header).chain(&bytes[body_at..]));
    let any = Parser::<Skipped>::new();
    let header = any.read_header(&mut reader).map_err(|fault| refuse(&fault, 0, into))?;
    check_counts(&header, bytes.len(), into)?;
    let mut points: Vec<[f32; 3]> = Vec::new();
    // Faces may stand before the vertices that they name.
    let mut faces: Vec<Face> = Vec::new();
    let part = into.part("", Vec::new())?;
    let left_out = left_out.len();
    for (name, element) in &header.elements {
        let late = |fault: ParseError, into: &Collector<'_>| refuse(&fault, left_out, into);
        match name.as_str() {
            "vertex" => {
                let vertices = Parser::<Vertex>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(|fault| late(fault, into))?;
                points =
                    (0..).zip(vertices).map(|v| v.1.place(v.0, into)).collect::<Result<_, _>>()?;
            }
            "face" => {
                faces = Parser::<Face>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(|fault| late(fault, into))?;
            }
            "tristrips" => {
                return Err(
                    into.fail(FilePosition::Whole, MeshDefect::Feature("element tristrips".into()))
                );
            }
            _ => {
                any.read_payload_for_element(&mut reader, element, &header)
                    .map_err(|fault| late(fault, into))?;
                if element.count > 0 {
                    into.notes.push(format!("{} elements \"{name}\" left out", element.count));
                }
            }
        }
    }
    if faces.is_empty() {
        let what = match points.len() {
            0 => ": neither vertices nor faces".to_owned(),
            1 => ": 1 vertex without faces".to_owned(),
            count => format!(": {count} vertices without faces"),
        };
        let fault = MeshDefect::Empty(what);
        return Err(into.fail(FilePosition::Whole, fault));
    }
    add(&faces, &points, part, into)
}

/// Maximum number of lines of a header.
const HEADER_LINES_MAX: usize = 10_000;

/// Keywords of header lines.
const WORDS: [&[u8]; 7] =
    [b"ply", b"format", b"comment", b"obj_info", b"element", b"property", b"end_header"];

/// Splits off the header: without unknown lines, with the offset of the data and the numbers of
/// those lines.
fn split_header(
    bytes: &[u8],
    into: &Collector<'_>,
) -> Result<(Vec<u8>, usize, Vec<usize>), ImportError> {
    let fail = |place, fault| Err(into.fail(place, fault));
    if bytes.is_empty() {
        return fail(FilePosition::Whole, MeshDefect::Empty(": the file is empty".to_owned()));
    }
    if !bytes.starts_with(b"ply") {
        let fault = "a PLY file begins with \"ply\"".to_owned();
        return fail(FilePosition::Line(1), MeshDefect::Syntax(fault));
    }
    let (mut header, mut at, mut left_out) = (Vec::new(), 0, Vec::new());
    for number in 1..HEADER_LINES_MAX {
        let rest = &bytes[at..];
        // Lines end with \n, \r\n, or a lone \r.
        let Some(end) = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')) else {
            break;
        };
        let width = if rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
        let line = &rest[..end];
        at += end + width;
        let word = line.split(|byte| byte.is_ascii_whitespace()).next().unwrap_or(line);
        if WORDS.contains(&word) {
            header.extend_from_slice(line.trim_ascii_end());
            header.push(b'\n');
        } else if !line.trim_ascii().is_empty() {
            left_out.push(number);
        }
        if word == b"end_header" {
            return Ok((header, at, left_out));
        }
    }
    fail(
        FilePosition::Whole,
        MeshDefect::Truncated("the header has no line \"end_header\"".to_owned()),
    )
}

fn refuse(fault: &ParseError, left_out: usize, into: &Collector<'_>) -> ImportError {
    let place =
        fault.line().map_or(FilePosition::Whole, |line| FilePosition::Line(line + left_out));
    let text = fault.to_string();
    let kept: Vec<&str> = text.split_whitespace().take(40).collect();
    let text = kept.join(" ");
    // The crate's message repeats the line at its start.
    let text = match text.split_once(": ") {
        Some((head, rest)) if head.starts_with("Line ") => rest.to_owned(),
        _ => text,
    };
    // A sentence of its own there, a part of one here.
    let mut rest = text.trim_end_matches('.').chars();
    let first = rest.next().map_or(String::new(), |c| c.to_lowercase().collect());
    let text = first + rest.as_str();
    if fault.kind() == std::io::ErrorKind::UnexpectedEof {
        into.fail(place, MeshDefect::Truncated(text))
    } else {
        into.fail(place, MeshDefect::Syntax(text))
    }
}

/// Every element takes at least one byte, so counts beyond the file's length are wrong.
fn check_counts(header: &Header, bytes: usize, into: &Collector<'_>) -> Result<(), ImportError> {
    let fail = |fault| Err(into.fail(FilePosition::Whole, fault));
    for name in ["vertex", "face"] {
        let Some(element) = header.elements.get(name) else {
            return fail(match name {
                "face" => MeshDefect::Empty(": the header has no element \"face\"".to_owned()),
                _ => MeshDefect::Syntax("the header has no element \"vertex\"".to_owned()),
            });
        };
        let max = TRIANGLES_MAX * 3;
        if element.count > max {
            let (count, max) = (element.count as u64, max as u64);
            let what = if name == "vertex" { "vertices" } else { "faces" };
            return fail(MeshDefect::TooMany { what, count, max });
        }
    }
    if let Some(element) = header.elements.values().find(|element| element.count > bytes) {
        let fault =
            format!("it states {} elements \"{}\" in {bytes} bytes", element.count, element.name);
        return fail(MeshDefect::Truncated(fault));
    }
    check_properties(&header.elements["vertex"], &["x", "y", "z"], into)?;
    if header.elements["face"].count > 0 {
        let list = ["vertex_indices", "vertex_index"];
        let known = &header.elements["face"].properties;
        if !list.iter().any(|name| known.contains_key(*name)) {
            let fault = "element face has no property list vertex_indices";
            return fail(MeshDefect::Syntax(fault.to_owned()));
        }
    }
    Ok(())
}

fn check_properties(
    element: &ElementDef,
    names: &[&str],
    into: &Collector<'_>,
) -> Result<(), ImportError> {
    match names.iter().find(|name| !element.properties.contains_key(**name)) {
        Some(name) => {
            let fault = format!("element {} has no property {name}", element.name);
            Err(into.fail(FilePosition::Whole, MeshDefect::Syntax(fault)))
        }
        None => Ok(()),
    }
}

fn add(
    faces: &[Face],
    points: &[[f32; 3]],
    part: u16,
    into: &mut Collector<'_>,
) -> Result<(), ImportError> {
    let mut polygon = Vec::new();
    for (number, face) in faces.iter().enumerate() {
        let place = || FilePosition::Element(format!("face {number}"));
        polygon.clear();
        for index in &face.corners {
            let point = usize::try_from(*index).ok().and_then(|index| points.get(index));
            let Some(point) = point else {
                let range = format!("the file has {} vertices, from 0", points.len());
                return Err(into.fail(place(), MeshDefect::Index { index: *index, range }));
            };
            polygon.push(*point);
        }
        into.polygon(&polygon, part, place)?;
    }
    Ok(())
}

struct Vertex {
    point: [f64; 3],
}

impl Vertex {
    fn place(&self, number: usize, into: &Collector<'_>) -> Result<[f32; 3], ImportError> {
        into.point(self.point, || FilePosition::Element(format!("vertex {number}")))
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        // A coordinate that no property sets must not look valid.
        Self { point: [f64::NAN; 3] }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let Some(axis) = ["x", "y", "z"].iter().position(|axis| *axis == name) else {
            return PropertyAccessResult::Ignored;
        };
        self.point[axis] = match value {
            Property::Float(x) => f64::from(x),
            Property::Double(x) => x,
            Property::Char(x) => f64::from(x),
            Property::UChar(x) => f64::from(x),
            Property::Short(x) => f64::from(x),
            Property::UShort(x) => f64::from(x),
            Property::Int(x) => f64::from(x),
            Property::UInt(x) => f64::from(x),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

#[derive(Default)]
struct Face {
    corners: Vec<i64>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if name != "vertex_indices" && name != "vertex_index" {
            return PropertyAccessResult::Ignored;
        }
        fn wide<T: Into<i64>>(list: Vec<T>) -> Vec<i64> {
            list.into_iter().map(Into::into).collect()
        }
        self.corners = match value {
            Property::ListChar(list) => wide(list),
            Property::ListUChar(list) => wide(list),
            Property::ListShort(list) => wide(list),
            Property::ListUShort(list) => wide(list),
            Property::ListInt(list) => wide(list),
            Property::ListUInt(list) => wide(list),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element whose values are not needed.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

#[cfg(test)]
mod tests;
