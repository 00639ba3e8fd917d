//! COLLADA 1.4 and 1.5 (Barnes, Finch: COLLADA Digital Asset Schema Release 1.4.1, 2008), by a
//! custom reader based on `roxmltree`, whose time and memory our crate `xml` bounds.
//!
//! Supported are the visual scene's nodes with their matrices, translations, rotations and scales,
//! instanced nodes and geometries, and in a mesh triangles, polylists, polygons without holes,
//! strips and fans. Materials are parts. Unit and up axis are taken from the file, unless the user
//! overrides them. Lights, cameras and lines have no surface; skins, splines and everything else
//! that would have one are rejected by name. Transforms are products in f64, and the unit also
//! scales translations.

use super::collect::Collector;
use super::{Axis, FilePosition, ImportError, LengthUnit, MeshDefect, StatedFrame};
use roxmltree::{Document, Node};
use std::borrow::Cow;
use std::collections::BTreeMap;
use xml::XmlError;

mod mesh;
mod place;

use place::Matrix;

/// Maximum number of nodes of the XML tree: 72 bytes each.
const XML_NODES_MAX: u32 = 8_000_000;
/// Maximum depth of scene nodes.
const DEPTH_MAX: usize = 256;
/// Maximum number of visited scene nodes: instanced nodes can multiply.
const VISITS_MAX: usize = 1_000_000;

/// A parsed file.
pub(super) struct Collada<'t> {
    document: Document<'t>,
}

/// Parses the text.
pub(super) fn parse<'t>(file: &str, bytes: &'t [u8]) -> Result<Collada<'t>, ImportError> {
    let fail = |place, fault| ImportError::new(file, place, fault);
    let text = core::str::from_utf8(bytes).map_err(|error| {
        let fault = format!("not UTF-8 from byte {} on", error.valid_up_to());
        fail(FilePosition::Whole, MeshDefect::Syntax(fault))
    })?;
    let document = xml::parse(text, XML_NODES_MAX).map_err(|error| {
        let line = FilePosition::Line(error.position().0 as usize);
        match error {
            XmlError::Declaration { .. } => {
                fail(line, MeshDefect::Feature("a document type declaration".to_owned()))
            }
            _ => fail(line, MeshDefect::Syntax(error.to_string())),
        }
    })?;
    let root = document.root_element().tag_name().name();
    if root != "COLLADA" {
        let fault = MeshDefect::Syntax(format!("its first element is <{root}>, not <COLLADA>"));
        return Err(fail(FilePosition::Whole, fault));
    }
    Ok(Collada { document })
}

impl Collada<'_> {
    /// Unit and up axis; by default a metre and y up, as in the specification.
    pub(super) fn asset(&self, file: &str) -> Result<StatedFrame, ImportError> {
        let root = self.document.root_element();
        let asset = child(root, "asset");
        let unit = match asset.and_then(|asset| child(asset, "unit")) {
            Some(unit) => {
                let text = unit.attribute("meter").unwrap_or("1.0");
                text.trim().parse().map_err(|_error| {
                    let fault = format!("<unit meter={text:?}> is not a length");
                    ImportError::new(file, line(unit), MeshDefect::Syntax(fault))
                })?
            }
            None => LengthUnit::METRE,
        };
        let up = match asset.and_then(|asset| child(asset, "up_axis")) {
            Some(axis) => match axis.text().unwrap_or_default().trim() {
                "X_UP" => Axis::X,
                "Y_UP" => Axis::Y,
                "Z_UP" => Axis::Z,
                other => {
                    let fault = MeshDefect::Syntax(format!("<up_axis> is {other:?}"));
                    return Err(ImportError::new(file, line(axis), fault));
                }
            },
            None => Axis::Y,
        };
        Ok(StatedFrame { unit, up })
    }
}

/// The first child element with this name.
fn child<'d>(node: Node<'d, 'd>, name: &str) -> Option<Node<'d, 'd>> {
    children(node).find(|child| child.tag_name().name() == name)
}

fn children<'d>(node: Node<'d, 'd>) -> impl Iterator<Item = Node<'d, 'd>> {
    node.children().filter(Node::is_element)
}

fn named<'d, 'n>(
    node: Node<'d, 'd>,
    name: &'n str,
) -> impl Iterator<Item = Node<'d, 'd>> + use<'d, 'n> {
    children(node).filter(move |child| child.tag_name().name() == name)
}

/// All text of an element, which comments may split.
fn text<'d>(node: Node<'d, 'd>) -> Cow<'d, str> {
    let mut parts = node.children().filter(Node::is_text).filter_map(|part| part.text());
    let first = parts.next().unwrap_or_default();
    match parts.next() {
        None => Cow::Borrowed(first),
        Some(second) => [first, second].into_iter().chain(parts).collect::<String>().into(),
    }
}

fn line(node: Node<'_, '_>) -> FilePosition {
    FilePosition::Line(node.document().text_pos_at(node.range().start).row as usize)
}

/// Elements that can be referenced by id.
struct Library<'d> {
    by_id: BTreeMap<&'d str, Node<'d, 'd>>,
}

impl<'d> Library<'d> {
    fn of(root: Node<'d, 'd>) -> Self {
        let kinds =
            ["geometry", "node", "visual_scene", "material", "source", "vertices", "float_array"];
        let known = root
            .descendants()
            .filter(|node| node.is_element() && kinds.contains(&node.tag_name().name()));
        Self { by_id: known.filter_map(|node| Some((node.attribute("id")?, node))).collect() }
    }

    /// The element of this kind that an attribute like `url="#id"` of a node references.
    fn find(
        &self,
        node: Node<'d, 'd>,
        attribute: &str,
        kind: &str,
        into: &Collector<'_>,
    ) -> Result<Node<'d, 'd>, ImportError> {
        let url = node.attribute(attribute).unwrap_or_default();
        let Some(id) = url.strip_prefix('#') else {
            let fault = format!("{attribute}={url:?}, a reference to another file,");
            return Err(into.fail(line(node), MeshDefect::Feature(fault)));
        };
        match self.by_id.get(id) {
            Some(found) if found.tag_name().name() == kind => Ok(*found),
            _ => {
                let fault = MeshDefect::Syntax(format!("there is no <{kind}> with id {id:?}"));
                Err(into.fail(line(node), fault))
            }
        }
    }
}

/// A node to be visited.
struct Step<'d> {
    node: Node<'d, 'd>,
    /// The transform of its parent.
    matrix: Matrix,
    /// The names of its ancestors.
    names: Vec<&'d str>,
    depth: usize,
}

pub(super) fn read(file: &Collada<'_>, into: &mut Collector<'_>) -> Result<(), ImportError> {
    let root = file.document.root_element();
    let library = Library::of(root);
    let scene = scene(root, &library, into)?;
    let step = |node| Step { node, matrix: place::IDENTITY, names: Vec::new(), depth: 1 };
    let mut stack: Vec<Step<'_>> = named(scene, "node").map(step).collect();
    stack.reverse();
    let mut visits = 0;
    // Depth first, in the order of the file.
    while let Some(Step { node, matrix, mut names, depth }) = stack.pop() {
        visits += 1;
        for (count, max, what) in
            [(depth, DEPTH_MAX, "nested nodes"), (visits, VISITS_MAX, "instanced nodes")]
        {
            if count > max {
                let (count, max) = (count as u64, max as u64);
                return Err(into.fail(line(node), MeshDefect::TooMany { what, count, max }));
            }
        }
        let matrix = place::product(&matrix, &place::local(node, into)?);
        names.extend(node.attribute("name").or(node.attribute("id")));
        let mut below = Vec::new();
        for part in children(node) {
            match part.tag_name().name() {
                "node" => below.push(part),
                "instance_node" => below.push(library.find(part, "url", "node", into)?),
                "instance_geometry" => {
                    let flat = place::determinant(&matrix);
                    if !(flat.abs() > 1e-18) {
                        return Err(into.fail(line(node), MeshDefect::Singular(flat)));
                    }
                    let geometry = library.find(part, "url", "geometry", into)?;
                    mesh::add(geometry, part, &library, &matrix, &names, into)?;
                }
                other @ "instance_controller" => {
                    let fault = MeshDefect::Feature(format!("<{other}> (a skin or morph)"));
                    return Err(into.fail(line(part), fault));
                }
                _ => {}
            }
        }
        for node in below.into_iter().rev() {
            stack.push(Step { node, matrix, names: names.clone(), depth: depth + 1 });
        }
    }
    if into.corners.is_empty() {
        return Err(
            into.fail(FilePosition::Whole, MeshDefect::Empty(": its scene has no mesh".to_owned()))
        );
    }
    Ok(())
}

/// The scene that the file instantiates, else its first.
fn scene<'d>(
    root: Node<'d, 'd>,
    library: &Library<'d>,
    into: &Collector<'_>,
) -> Result<Node<'d, 'd>, ImportError> {
    let shown = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    if let Some(shown) = shown {
        return library.find(shown, "url", "visual_scene", into);
    }
    let first = child(root, "library_visual_scenes").and_then(|all| child(all, "visual_scene"));
    first.ok_or_else(|| {
        into.fail(FilePosition::Whole, MeshDefect::Empty(": it has no <visual_scene>".to_owned()))
    })
}

#[cfg(test)]
mod tests;
