//! LS-DYNA keyword decks (LS-DYNA Keyword User's Manual, volume I), by a custom reader.
//!
//! Supported are nodes, shells in fixed columns or with commas, with the lines that their options
//! add, outer faces of solids and thick shells, names of parts, and included files. Elements
//! without a surface (beams, springs, masses) are counted and named; unknown elements that would
//! have one are rejected with their line. A deck states no unit: the user must. What it weighs is
//! added up (`mass.rs`) and offered.

mod card;
mod mass;

use super::collect::Collector;
use super::{FilePosition, ImportError, MeshDefect, Resolver};
use card::{Block, blocks, fields, mean, real, whole};
use mass::{Masses, Piece};
use std::collections::BTreeMap;

/// Maximum depth of included decks.
const INCLUDES_MAX: usize = 8;
/// Maximum total size of included decks (bytes).
const BYTES_MAX: usize = 1 << 30;

/// Elements without a surface.
const NO_SURFACE: [&str; 12] = [
    "BEAM",
    "DISCRETE",
    "MASS",
    "SEATBELT",
    "INERTIA",
    "PLOTEL",
    "SPH",
    "LUMPED",
    "GENERALIZED",
    "BEARING",
    "DISCRETE_SPHERE",
    "TRIM",
];

/// The six faces of a brick, outward (manual, section on solid elements).
const FACES: [[usize; 4]; 6] =
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

/// The four faces of a tetrahedron, outward; one corner is repeated.
const TETRAHEDRON: [[usize; 4]; 4] = [[0, 2, 1, 1], [0, 1, 3, 3], [1, 2, 3, 3], [2, 0, 3, 3]];

/// A face or shell: part, corners, place in the file.
struct Face {
    part: u64,
    nodes: Vec<u64>,
    place: Spot,
    /// Of a shell that states its own.
    thickness: Option<f64>,
}

/// A line of one of the decks.
#[derive(Clone, Copy)]
struct Spot {
    deck: usize,
    line: usize,
    element: u64,
}

/// Everything read so far.
#[derive(Default)]
struct Deck {
    names: Vec<String>,
    nodes: BTreeMap<u64, [f64; 3]>,
    shells: Vec<Face>,
    /// Faces of solids by their sorted corners, and the number of solids that have them.
    outer: BTreeMap<Vec<u64>, (Face, usize)>,
    /// Part and corners of each solid, for its volume.
    solids: Vec<(u64, [u64; 8])>,
    parts: BTreeMap<u64, String>,
    skipped: BTreeMap<String, usize>,
    includes: Vec<Include>,
    masses: Masses,
}

/// A deck that is to be read.
#[derive(Clone)]
struct Include {
    name: String,
    /// The deck that includes it, and the line.
    place: Spot,
}

pub(super) fn read(
    bytes: &[u8],
    resolve: Resolver<'_>,
    into: &mut Collector<'_>,
) -> Result<(), ImportError> {
    let mut deck = Deck::default();
    let mut waiting: Vec<(Include, Vec<u8>)> = Vec::new();
    deck.add("", bytes, into)?;
    let mut total = bytes.len();
    // The decks that led to each, itself last; the first has the file's own name.
    let mut ways: Vec<Vec<String>> = vec![vec![into.file_name().to_owned()]];
    let mut seen = 0;
    loop {
        while seen < deck.includes.len() {
            let include = deck.includes[seen].clone();
            let Include { name, place } = &include;
            seen += 1;
            let way = &ways[place.deck];
            if let Some(first) = way.iter().position(|before| plain(before) == plain(name)) {
                let circle = [&way[first..], std::slice::from_ref(name)].concat().join(" → ");
                return Err(deck.fail(*place, MeshDefect::IncludesItself(circle), into));
            }
            if way.len() > INCLUDES_MAX {
                let (count, max) = (way.len() as u64, INCLUDES_MAX as u64);
                let what = "decks that include decks";
                return Err(deck.fail(*place, MeshDefect::TooMany { what, count, max }, into));
            }
            let leads_out =
                name.starts_with(['/', '\\']) || name.contains("..") || name.contains(':');
            let content = if leads_out {
                Err("its name leads out of the deck's folder".to_owned())
            } else {
                resolve(name)
            };
            let content = content.map_err(|reason| {
                deck.fail(*place, MeshDefect::Include { name: name.clone(), reason }, into)
            })?;
            total += content.len();
            if total > BYTES_MAX {
                let (count, max) = (total as u64, BYTES_MAX as u64);
                return Err(into
                    .fail(FilePosition::Whole, MeshDefect::TooMany { what: "bytes", count, max }));
            }
            waiting.push((include, content));
        }
        let Some((Include { name, place }, content)) = waiting.pop() else { break };
        into.hasher.update(&content);
        ways.push([&ways[place.deck][..], std::slice::from_ref(&name)].concat());
        deck.add(&name, &content, into)?;
    }
    deck.emit(into)
}

/// The name of an included deck without what says nothing: "./b.k" is "b.k".
fn plain(name: &str) -> &str {
    name.trim_start_matches("./").trim_start_matches(".\\")
}

impl Deck {
    fn fail(&self, place: Spot, fault: MeshDefect, into: &Collector<'_>) -> ImportError {
        let at = match (self.names[place.deck].as_str(), place.element) {
            ("", 0) => FilePosition::Line(place.line),
            ("", element) => {
                FilePosition::Element(format!("line {}, element {element}", place.line))
            }
            (name, 0) => FilePosition::Element(format!("{name}, line {}", place.line)),
            (name, element) => {
                FilePosition::Element(format!("{name}, line {}, element {element}", place.line))
            }
        };
        into.fail(at, fault)
    }

    fn add(
        &mut self,
        name: &str,
        bytes: &[u8],
        into: &mut Collector<'_>,
    ) -> Result<(), ImportError> {
        let number = self.names.len();
        self.names.push(name.to_owned());
        let text = String::from_utf8_lossy(bytes);
        for block in blocks(&text) {
            let spot = |line| Spot { deck: number, line, element: 0 };
            let keyword = block.keyword.as_str();
            let refuse = |deck: &Self, what: String| {
                Err(deck.fail(spot(block.line), MeshDefect::Feature(what), into))
            };
            let (head, options) = keyword.split_once('_').unwrap_or((keyword, ""));
            match (head, options) {
                ("KEYWORD", options) if options.contains("LONG") => {
                    return refuse(self, "the long format (LONG=Y)".to_owned());
                }
                ("NODE", "") => self.nodes(&block, number, into)?,
                ("NODE", "TRANSFORM") => return refuse(self, "*NODE_TRANSFORM".to_owned()),
                ("ELEMENT", options) => self.elements(options, &block, number, into)?,
                ("PART", options) => self.part(options, &block, number, into)?,
                ("INCLUDE", "") => {
                    let include = |(line, card): &(usize, &str)| Include {
                        name: card.trim().to_owned(),
                        place: spot(*line),
                    };
                    self.includes.extend(block.cards.iter().map(include));
                }
                ("MAT", options) if !options.starts_with("ADD") => self.masses.material(&block),
                ("SECTION", "SHELL" | "SHELL_TITLE") => self.masses.section(&block),
                ("INCLUDE", "PATH" | "PATH_RELATIVE") => {}
                ("INCLUDE", _) => return refuse(self, format!("*{keyword}")),
                ("END", _) => break,
                _ => {}
            }
        }
        Ok(())
    }

    fn nodes(
        &mut self,
        block: &Block<'_>,
        deck: usize,
        into: &Collector<'_>,
    ) -> Result<(), ImportError> {
        for (line, card) in &block.cards {
            let place = Spot { deck, line: *line, element: 0 };
            let fields = fields(card, &[8, 16, 16, 16]);
            let wrong = |fault: String| self.fail(place, MeshDefect::Syntax(fault), into);
            let id = whole(fields.first()).filter(|id| *id > 0);
            let id = id.ok_or_else(|| wrong("a node without a number".to_owned()))?;
            let mut point = [0.0; 3];
            for (value, field) in point.iter_mut().zip(1..) {
                // An empty field is zero, as everywhere in a deck.
                let text = fields.get(field).copied().unwrap_or_default();
                *value = match text {
                    "" => 0.0,
                    text => real(text).ok_or_else(|| wrong(format!("{text:?} is not a number")))?,
                };
            }
            if self.nodes.contains_key(&id) {
                return Err(wrong(format!("node {id} is defined twice")));
            }
            self.nodes.insert(id, point);
        }
        Ok(())
    }

    fn elements(
        &mut self,
        options: &str,
        block: &Block<'_>,
        deck: usize,
        into: &Collector<'_>,
    ) -> Result<(), ImportError> {
        let place = Spot { deck, line: block.line, element: 0 };
        let (kind, more) = options.split_once('_').unwrap_or((options, ""));
        let words: Vec<&str> = more.split('_').filter(|word| !word.is_empty()).collect();
        match kind {
            "SHELL" => {
                // Thickness, angle and material angle share a line; offset and degrees of freedom
                // have one each.
                let shared = ["THICKNESS", "BETA", "MCID"];
                let known = [&shared[..], &["OFFSET", "DOF"]].concat();
                if let Some(word) = words.iter().find(|word| !known.contains(word)) {
                    let fault = MeshDefect::Feature(format!("*ELEMENT_SHELL with {word}"));
                    return Err(self.fail(place, fault, into));
                }
                let count = |of: &[&str]| words.iter().filter(|word| of.contains(word)).count();
                let extra = count(&shared).min(1) + count(&["OFFSET"]) + count(&["DOF"]);
                let states_thickness = count(&["THICKNESS"]) > 0;
                self.shells(block, (extra, states_thickness), deck, into)
            }
            "SOLID" | "TSHELL" => {
                let extra = match words.as_slice() {
                    [] => 0,
                    ["ORTHO"] => 2,
                    _ => {
                        let fault = MeshDefect::Feature(format!("*ELEMENT_{options}"));
                        return Err(self.fail(place, fault, into));
                    }
                };
                self.solids(block, extra, deck, into)
            }
            "MASS" => {
                self.masses.lumped(block, &words);
                *self.skipped.entry(format!("*ELEMENT_{options}")).or_default() +=
                    block.cards.len();
                Ok(())
            }
            kind if NO_SURFACE.contains(&kind) => {
                *self.skipped.entry(format!("*ELEMENT_{options}")).or_default() +=
                    block.cards.len();
                Ok(())
            }
            _ => Err(self.fail(place, MeshDefect::Feature(format!("*ELEMENT_{options}")), into)),
        }
    }

    fn shells(
        &mut self,
        block: &Block<'_>,
        (extra, states_thickness): (usize, bool),
        deck: usize,
        into: &Collector<'_>,
    ) -> Result<(), ImportError> {
        for cards in block.cards.chunks(1 + extra) {
            let (line, card) = cards[0];
            let (id, part, nodes) = self.element(card, line, deck, into)?;
            let place = Spot { deck, line, element: id };
            if cards.len() < 1 + extra {
                let fault = format!("{} more lines belong to it", 1 + extra - cards.len());
                return Err(self.fail(place, MeshDefect::Truncated(fault), into));
            }
            // The first four are corners; further ones lie in the middle of edges.
            let nodes = distinct(&nodes[..nodes.len().min(4)]);
            if nodes.len() < 3 {
                let fault = format!("a shell with {} different corners", nodes.len());
                return Err(self.fail(place, MeshDefect::Syntax(fault), into));
            }
            // Blank or zero: that of the section.
            let thickness = cards.get(1).filter(|_| states_thickness);
            let thickness = thickness.and_then(|(_, card)| mean(&fields(card, &[16; 4])));
            self.shells.push(Face { part, nodes, place, thickness });
        }
        Ok(())
    }

    fn solids(
        &mut self,
        block: &Block<'_>,
        extra: usize,
        deck: usize,
        into: &Collector<'_>,
    ) -> Result<(), ImportError> {
        let mut cards = block.cards.iter();
        while let Some((line, card)) = cards.next() {
            let (id, part, mut nodes) = self.element(card, *line, deck, into)?;
            let place = Spot { deck, line: *line, element: id };
            if nodes.is_empty() {
                // The newer form has number and part on one line, corners on the next.
                let below = cards.next().map_or("", |(_, card)| card);
                let all = fields(below, &[8; 10]);
                nodes = all.iter().filter_map(|field| whole(Some(field))).collect();
            }
            for _ in 0..extra {
                cards.next();
            }
            while nodes.last() == Some(&0) {
                nodes.pop();
            }
            let corners: [u64; 8] = match *nodes.as_slice() {
                [a, b, c, d] => [a, b, c, d, d, d, d, d],
                [a, b, c, d, e, f] => [a, b, c, d, e, e, f, f],
                [a, b, c, d, e, f, g, h, ..] => [a, b, c, d, e, f, g, h],
                _ => {
                    let fault = format!("a solid with {} corners", nodes.len());
                    return Err(self.fail(place, MeshDefect::Feature(fault), into));
                }
            };
            self.solids.push((part, corners));
            let [_, _, _, d, rest @ ..] = corners;
            // If all corners but three coincide, a tetrahedron. Others keep a brick's faces.
            let faces = if rest == [d; 4] { &TETRAHEDRON[..] } else { &FACES[..] };
            for face in faces {
                let nodes = distinct(&face.map(|corner| corners[corner]));
                if nodes.len() < 3 {
                    continue;
                }
                let mut key = nodes.clone();
                key.sort_unstable();
                let face = Face { part, nodes, place, thickness: None };
                self.outer.entry(key).or_insert((face, 0)).1 += 1;
            }
        }
        Ok(())
    }

    /// Number, part and corners of an element.
    fn element(
        &self,
        card: &str,
        line: usize,
        deck: usize,
        into: &Collector<'_>,
    ) -> Result<(u64, u64, Vec<u64>), ImportError> {
        let fields = fields(card, &[8; 10]);
        let mut numbers = Vec::with_capacity(10);
        for field in &fields {
            let place = Spot { deck, line, element: numbers.first().copied().unwrap_or(0) };
            let number = whole(Some(field)).ok_or_else(|| {
                let fault = MeshDefect::Syntax(format!("{field:?} is not a whole number"));
                self.fail(place, fault, into)
            })?;
            numbers.push(number);
        }
        match numbers.as_slice() {
            [id, part, nodes @ ..] => Ok((*id, *part, nodes.to_vec())),
            _ => {
                let place = Spot { deck, line, element: 0 };
                let fault = MeshDefect::Truncated("an element without a part".to_owned());
                Err(self.fail(place, fault, into))
            }
        }
    }

    fn part(
        &mut self,
        options: &str,
        block: &Block<'_>,
        deck: usize,
        into: &Collector<'_>,
    ) -> Result<(), ImportError> {
        // Options add lines of their own: then only the first part is certain.
        let pairs = if options.is_empty() { usize::MAX } else { 1 };
        for cards in block.cards.chunks(2).take(pairs) {
            let [(_, title), (line, card)] = cards else { continue };
            let fields = fields(card, &[10; 8]);
            let Some(id) = whole(fields.first()) else {
                let place = Spot { deck, line: *line, element: 0 };
                let fault = MeshDefect::Syntax("a part without a number".to_owned());
                return Err(self.fail(place, fault, into));
            };
            self.parts.insert(id, title.trim().to_owned());
            let number = |at: usize| whole(fields.get(at)).unwrap_or(0);
            self.masses.parts.insert(id, [number(1), number(2)]);
        }
        // The line after the first part has its centre, and then its mass.
        let id = block.cards.get(1).and_then(|(_, card)| whole(fields(card, &[10; 8]).first()));
        let stated = block.cards.get(2).filter(|_| options == "INERTIA");
        let stated = stated.and_then(|(_, card)| real(fields(card, &[10; 8]).get(3)?));
        if let Some((id, stated)) = id.zip(stated).filter(|(_, mass)| *mass > 0.0) {
            self.masses.stated.insert(id, stated);
        }
        Ok(())
    }

    /// What the deck says of its mass, in words.
    fn mass_notes(&self, into: &Collector<'_>) -> Vec<String> {
        let point = |node: &u64| self.nodes.get(node).copied();
        let shells = self.shells.iter().filter_map(|face| {
            let corners: Option<Vec<[f64; 3]>> = face.nodes.iter().map(point).collect();
            let area = mass::area(&corners?);
            Some((face.part, Piece::Shell { area, thickness: face.thickness }))
        });
        let solids = self.solids.iter().filter_map(|(part, nodes)| {
            let mut corners = [[0.0; 3]; 8];
            for (corner, node) in corners.iter_mut().zip(nodes) {
                *corner = point(node)?;
            }
            // A tetrahedron, whose last corners coincide, has bricks' faces of which some are flat.
            let faces = FACES.map(|face| face.map(|at| corners[at]));
            let volume = mass::volume(faces.iter().map(|face| &face[..]));
            Some((*part, Piece::Solid { volume }))
        });
        self.masses.weigh(shells.chain(solids)).notes(into.unit())
    }

    /// Emits everything: shells in file order, then outer faces of solids.
    fn emit(self, into: &mut Collector<'_>) -> Result<(), ImportError> {
        for (what, lines) in &self.skipped {
            into.notes.push(format!("{lines} lines of {what} left out: they have no surface"));
        }
        let weighed = self.mass_notes(into);
        into.notes.extend(weighed);
        let inner = self.outer.values().filter(|(_, solids)| *solids > 1).count();
        if inner > 0 {
            into.notes.push(format!("{inner} faces between solids left out"));
        }
        let mut outer: Vec<&Face> =
            self.outer.values().filter(|(_, solids)| *solids == 1).map(|(face, _)| face).collect();
        outer.sort_by_key(|face| (face.place.deck, face.place.line));
        if self.shells.is_empty() && outer.is_empty() {
            let fault =
                MeshDefect::Empty(format!(": {} nodes, no shells or solids", self.nodes.len()));
            return Err(into.fail(FilePosition::Whole, fault));
        }
        let mut points = Vec::with_capacity(4);
        for face in self.shells.iter().chain(outer) {
            let name = match self.parts.get(&face.part).map(String::as_str) {
                None | Some("") => format!("part {}", face.part),
                Some(title) => title.to_owned(),
            };
            let part = into.part(&name, vec![face.part.to_string()])?;
            points.clear();
            for node in &face.nodes {
                let Some(point) = self.nodes.get(node) else {
                    let index = i64::try_from(*node).unwrap_or(i64::MAX);
                    let range = "the deck has no node with this number".to_owned();
                    return Err(self.fail(face.place, MeshDefect::Index { index, range }, into));
                };
                let position = || FilePosition::Element(format!("node {node}"));
                points.push(into.point(*point, position)?);
            }
            let position = || FilePosition::Line(face.place.line);
            into.polygon(&points, part, position)?;
        }
        Ok(())
    }
}

/// Corners without repetition, in order.
fn distinct(nodes: &[u64]) -> Vec<u64> {
    let mut all: Vec<u64> = Vec::with_capacity(nodes.len());
    for node in nodes.iter().filter(|node| **node != 0) {
        if !all.contains(node) {
            all.push(*node);
        }
    }
    all
}

#[cfg(test)]
mod tests;
