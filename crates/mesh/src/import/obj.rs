//! Wavefront OBJ: a scan for names, lines and faults, then crate `tobj` for the values.
//!
//! `tobj` reports no line, starts a new model at every `o` or `g`, forgets materials whose library
//! it has not seen, and overflows on bad texture indices. So a scan of the lines comes first: it
//! records group, object and material of each face, rejects what is out of range with its line, and
//! passes on only positions and position indices.

use super::collect::Collector;
use super::{FilePosition, ImportError, MeshDefect};
use std::fmt::Write as _;
use std::io::Read as _;

/// Faces to be read, in file order.
struct Face {
    line: usize,
    part: u16,
}

/// The result of the scan.
#[derive(Default)]
struct Scan {
    /// Lines for `tobj`: every `v`, then every `f` with only absolute position indices.
    vertex_text: String,
    face_text: String,
    vertex_lines: Vec<usize>,
    faces: Vec<Face>,
    /// Greatest vertex number that a face uses (counted from 1), its line.
    greatest: (usize, usize),
    lines: usize,
    points: usize,
    free_form: usize,
}

pub(super) fn read(bytes: &[u8], into: &mut Collector<'_>) -> Result<(), ImportError> {
    let text =
        core::str::from_utf8(bytes).map_or_else(|_| String::from_utf8_lossy(bytes), Into::into);
    if text.contains('\0') {
        return Err(into.fail(
            FilePosition::Whole,
            MeshDefect::Syntax("it is not text: it contains zero bytes".into()),
        ));
    }
    let scan = scan(text.trim_start_matches('\u{feff}'), into)?;
    for (count, what) in
        [(scan.lines, "lines"), (scan.points, "points"), (scan.free_form, "free-form elements")]
    {
        if count > 0 {
            into.notes.push(format!("{count} {what} left out: they have no surface"));
        }
    }
    if scan.faces.is_empty() {
        let vertices = scan.vertex_lines.len();
        let what = match (vertices, scan.lines) {
            (0, _) if text.trim().is_empty() => ": the file is empty".to_owned(),
            (0, _) => ": no line of it is a vertex (v) or a face (f) of Wavefront OBJ".to_owned(),
            (1, 0) => ": 1 vertex without faces".to_owned(),
            (_, 0) => format!(": a point cloud of {vertices} vertices without faces"),
            (_, 1) => ": 1 line without faces".to_owned(),
            (_, lines) => format!(": {lines} lines without faces"),
        };
        return Err(into.fail(FilePosition::Whole, MeshDefect::Empty(what)));
    }
    let parsed = parse(&scan, into)?;
    let points = points(&parsed.positions, &scan.vertex_lines, into)?;
    let mut rest = parsed.indices.as_slice();
    let mut polygon = Vec::new();
    for (face, arity) in scan.faces.iter().zip(parsed.arities) {
        let Some((own, after)) = rest.split_at_checked(arity as usize) else {
            return Err(into.fail(FilePosition::Line(face.line), lost()));
        };
        rest = after;
        polygon.clear();
        for index in own {
            polygon.push(
                *points
                    .get(*index as usize)
                    .ok_or_else(|| into.fail(FilePosition::Line(face.line), lost()))?,
            );
        }
        into.polygon(&polygon, face.part, || FilePosition::Line(face.line))?;
    }
    Ok(())
}

fn lost() -> MeshDefect {
    MeshDefect::Syntax("the reader lost this face".to_owned())
}

/// The names in effect at a line.
#[derive(Default)]
struct Names {
    object: String,
    group: String,
    material: String,
    part: Option<u16>,
}

impl Names {
    /// The group if there is one, else the object, then the material if it differs; any of the
    /// names, and each word of a group with several, selects the part.
    fn part(&mut self, into: &mut Collector<'_>) -> Result<u16, ImportError> {
        if let Some(part) = self.part {
            return Ok(part);
        }
        let head = if self.group.is_empty() { &self.object } else { &self.group };
        let name = match (head.as_str(), self.material.as_str()) {
            (head, "") => head.to_owned(),
            ("", material) => material.to_owned(),
            (head, material) if head == material => head.to_owned(),
            (head, material) => format!("{head}:{material}"),
        };
        let words = self.group.split_whitespace();
        let mut aliases: Vec<String> = [&self.group, &self.object, &self.material]
            .into_iter()
            .map(String::as_str)
            .chain(words)
            .filter(|alias| !alias.is_empty() && **alias != name)
            .map(str::to_owned)
            .collect();
        aliases.dedup();
        let part = into.part(&name, aliases)?;
        self.part = Some(part);
        Ok(part)
    }
}

fn scan(text: &str, into: &mut Collector<'_>) -> Result<Scan, ImportError> {
    let mut scan = Scan::default();
    let mut names = Names::default();
    let mut joined = String::new();
    let mut first_of_joined = 0;
    for (number, line) in (1..).zip(text.lines()) {
        // A backslash at the end joins lines.
        if let Some(head) = line.strip_suffix('\\') {
            if joined.is_empty() {
                first_of_joined = number;
            }
            joined.push_str(head);
            joined.push(' ');
            continue;
        }
        if joined.is_empty() {
            scan.line(number, line, &mut names, into)?;
        } else {
            joined.push_str(line);
            let whole = core::mem::take(&mut joined);
            scan.line(first_of_joined, &whole, &mut names, into)?;
        }
    }
    let (index, line) = scan.greatest;
    if index > scan.vertex_lines.len() {
        let range = format!("the file has {} vertices", scan.vertex_lines.len());
        let fault = MeshDefect::Index { index: i64::try_from(index).unwrap_or(i64::MAX), range };
        return Err(into.fail(FilePosition::Line(line), fault));
    }
    Ok(scan)
}

impl Scan {
    fn line(
        &mut self,
        number: usize,
        line: &str,
        names: &mut Names,
        into: &mut Collector<'_>,
    ) -> Result<(), ImportError> {
        let line = line.trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        match word {
            "v" => return self.vertex(number, rest, into),
            "f" | "fo" => {
                let part = names.part(into)?;
                self.faces.push(Face { line: number, part });
                return self.face(number, rest, into);
            }
            "o" => {
                rest.clone_into(&mut names.object);
                names.group.clear();
                names.part = None;
            }
            "g" => {
                rest.clone_into(&mut names.group);
                names.part = None;
            }
            "usemtl" => {
                rest.clone_into(&mut names.material);
                names.part = None;
            }
            "l" => self.lines += 1,
            "p" => self.points += 1,
            "curv" | "curv2" | "surf" => self.free_form += 1,
            _ => {}
        }
        Ok(())
    }

    fn vertex(
        &mut self,
        number: usize,
        rest: &str,
        into: &Collector<'_>,
    ) -> Result<(), ImportError> {
        let fail =
            |fault: String| Err(into.fail(FilePosition::Line(number), MeshDefect::Syntax(fault)));
        let rest = rest.split('#').next().unwrap_or(rest);
        let words: Vec<&str> = rest.split_whitespace().collect();
        if words.len() < 3 {
            return fail(format!("a vertex has 3 coordinates, this one {}", words.len()));
        }
        // Three coordinates, a weight in a fourth place; colours follow three coordinates.
        let used = if words.len() == 4 { &words[..] } else { &words[..3] };
        self.vertex_text.push('v');
        for word in used {
            match word.parse::<f32>() {
                Ok(_) => {
                    self.vertex_text.push(' ');
                    self.vertex_text.push_str(word);
                }
                Err(_) => return fail(format!("\"{word}\" is not a number")),
            }
        }
        if used.len() == 4 && used[3].parse() == Ok(0.0_f32) {
            return fail("the vertex has weight 0".to_owned());
        }
        self.vertex_text.push('\n');
        self.vertex_lines.push(number);
        Ok(())
    }

    /// Writes the face with its indices made absolute, after checking each.
    fn face(&mut self, number: usize, rest: &str, into: &Collector<'_>) -> Result<(), ImportError> {
        let fail = |fault: MeshDefect| Err(into.fail(FilePosition::Line(number), fault));
        self.face_text.push('f');
        let mut corners = 0;
        for word in rest.split('#').next().unwrap_or(rest).split_whitespace() {
            let own = word.split('/').next().unwrap_or(word);
            let Ok(index) = own.parse::<i64>() else {
                return fail(MeshDefect::Syntax(format!("\"{word}\" is not a vertex index")));
            };
            let so_far = self.vertex_lines.len();
            let absolute = if index < 0 {
                so_far.checked_add_signed(index as isize).map(|before| before + 1)
            } else {
                usize::try_from(index).ok().filter(|index| *index > 0)
            };
            let Some(absolute) = absolute else {
                let range = match index {
                    0 => "OBJ counts vertices from 1".to_owned(),
                    _ => format!("there are {so_far} vertices before this line"),
                };
                return fail(MeshDefect::Index { index, range });
            };
            if absolute > self.greatest.0 {
                self.greatest = (absolute, number);
            }
            corners += 1;
            // Writing to a string cannot fail.
            let _written = write!(self.face_text, " {absolute}");
        }
        self.face_text.push('\n');
        if corners < 3 {
            return fail(MeshDefect::Syntax(format!(
                "a face with {corners} corners is not a surface"
            )));
        }
        Ok(())
    }
}

/// Positions in file order, corners per face, position numbers of all faces in file order.
///
/// `tobj` keeps only vertices that faces use, in the order of first use; so one polyline through
/// every vertex comes before the first face, which keeps all of them, in file order.
fn parse(scan: &Scan, into: &Collector<'_>) -> Result<Parsed, ImportError> {
    let fail = |fault: String| into.fail(FilePosition::Whole, MeshDefect::Syntax(fault));
    let vertices = scan.vertex_lines.len();
    let mut polyline = String::with_capacity(2 + vertices * 8);
    polyline.push('l');
    for index in 1..=vertices {
        // Writing to a string cannot fail.
        let _written = write!(polyline, " {index}");
    }
    polyline.push('\n');
    let [vertex_text, faces] = [&scan.vertex_text, &scan.face_text].map(String::as_bytes);
    let mut text = vertex_text.chain(polyline.as_bytes()).chain(faces);
    let options = tobj::LoadOptions::default();
    let none = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (mut models, _) = tobj::load_obj_buf(&mut text, &options, none)
        .map_err(|fault| fail(format!("tobj: {fault}")))?;
    let (Some(model), true) = (models.pop(), models.is_empty()) else {
        return Err(fail("tobj: not one model".to_owned()));
    };
    let mut mesh = model.mesh;
    if mesh.face_arities.is_empty() {
        // Three vertices and triangles alone: it leaves out that each face has three corners.
        mesh.face_arities = vec![3; scan.faces.len() + 1];
    }
    let (positions, whole) = (mesh.positions.len(), mesh.face_arities.first());
    if positions != 3 * vertices || whole.is_none_or(|n| *n as usize != vertices) {
        return Err(fail("tobj: it read other vertices than there are".to_owned()));
    }
    if mesh.face_arities.len() != scan.faces.len() + 1 || mesh.indices.len() < vertices {
        return Err(fail("tobj: it read other faces than there are".to_owned()));
    }
    mesh.face_arities.remove(0);
    mesh.indices.drain(..vertices);
    Ok(Parsed { positions: mesh.positions, arities: mesh.face_arities, indices: mesh.indices })
}

/// What `tobj` made of the file.
struct Parsed {
    positions: Vec<f32>,
    arities: Vec<u32>,
    indices: Vec<u32>,
}

/// Every vertex in the body frame; a bad one is refused with its line, used or not.
fn points(
    positions: &[f32],
    lines: &[usize],
    into: &Collector<'_>,
) -> Result<Vec<[f32; 3]>, ImportError> {
    let (chunks, _) = positions.as_chunks::<3>();
    chunks
        .iter()
        .zip(lines)
        .map(|(point, line)| into.point(point.map(f64::from), || FilePosition::Line(*line)))
        .collect()
}

#[cfg(test)]
mod tests;
