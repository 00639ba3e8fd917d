//! glTF 2.0, as JSON with side files or as one GLB file.
//!
//! Crate `gltf` parses the container and the JSON; its own validation panics on hostile files and
//! accepts out-of-range indices, so it is not used. Every number used here is checked here: each
//! index, each view's range, each accessor's type, the depth of the hierarchy, and that no node is
//! visited twice. Node transforms are applied in f64. Skins, morph targets and animations are not
//! applied: the mesh is taken as stored.

mod accessor;
mod buffers;

use super::collect::Collector;
use super::{FilePosition, ImportError, MeshDefect, Resolver};
use ::gltf::json;
use accessor::Source;
use json::mesh::{Mode, Primitive, Semantic};
use json::validation::Checked;

/// Maximum depth of the node hierarchy.
const DEPTH_MAX: usize = 256;

/// A column-major 4 × 4 matrix, as in glTF.
type Matrix = [[f64; 4]; 4];

const IDENTITY: Matrix =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

pub(super) fn read(
    bytes: &[u8],
    resolve: Resolver<'_>,
    into: &mut Collector<'_>,
) -> Result<(), ImportError> {
    let (root, blob) = buffers::parse(bytes, into)?;
    check_extensions(&root, into)?;
    note_what_is_left_out(&root, into);
    let buffers = buffers::load(&root, blob, resolve, into)?;
    let source = Source { root: &root, buffers: &buffers };
    let (mut stack, mut visited) = (start(&root, into)?, vec![false; root.nodes.len()]);
    let mut has_mesh = false;
    // Depth first, children in file order.
    while let Some(step) = stack.pop() {
        let place = || FilePosition::Element(format!("node {}", step.node));
        let Some(node) = root.nodes.get(step.node) else {
            let range = format!("the file has {} nodes", root.nodes.len());
            return Err(into.fail(place(), MeshDefect::Index { index: step.node as i64, range }));
        };
        if core::mem::replace(&mut visited[step.node], true) {
            let fault = "the node has two parents or is its own ancestor".to_owned();
            return Err(into.fail(place(), MeshDefect::Syntax(fault)));
        }
        if step.depth > DEPTH_MAX {
            let (count, max) = (step.depth as u64, DEPTH_MAX as u64);
            return Err(
                into.fail(place(), MeshDefect::TooMany { what: "nested nodes", count, max })
            );
        }
        let matrix = product(&step.matrix, &local(node));
        let mut names = step.names;
        names.extend(node.name.clone());
        if let Some(mesh) = node.mesh {
            has_mesh = true;
            add_mesh(&source, step.node, mesh.value(), &matrix, &names, into)?;
        }
        for child in node.children.iter().flatten().rev() {
            let (names, depth) = (names.clone(), step.depth + 1);
            stack.push(Step { node: child.value(), matrix, names, depth });
        }
    }
    if into.corners.is_empty() {
        let what = match (root.meshes.is_empty(), has_mesh) {
            (true, _) => ": it has no mesh",
            (_, false) => ": no node of its scene has a mesh",
            _ => ": its meshes are points or lines, or empty",
        };
        let fault = MeshDefect::Empty(what.to_owned());
        return Err(into.fail(FilePosition::Whole, fault));
    }
    Ok(())
}

/// A node to be visited.
struct Step {
    node: usize,
    /// The transform of its parent.
    matrix: Matrix,
    /// The names of its ancestors.
    names: Vec<String>,
    depth: usize,
}

/// The nodes of the default scene, else of the first one, else all nodes without a parent.
fn start(root: &json::Root, into: &Collector<'_>) -> Result<Vec<Step>, ImportError> {
    let number = root.scene.map_or(0, |scene| scene.value());
    let mut nodes: Vec<usize> = match root.scenes.get(number) {
        Some(scene) => scene.nodes.iter().map(json::Index::value).collect(),
        None if root.scene.is_some() => {
            let range = format!("the file has {} scenes", root.scenes.len());
            let fault = MeshDefect::Index { index: number as i64, range };
            return Err(into.fail(FilePosition::Element("scene".to_owned()), fault));
        }
        None => {
            let mut is_child = vec![false; root.nodes.len()];
            for child in root.nodes.iter().filter_map(|node| node.children.as_ref()).flatten() {
                if let Some(mark) = is_child.get_mut(child.value()) {
                    *mark = true;
                }
            }
            (0..root.nodes.len()).filter(|node| !is_child[*node]).collect()
        }
    };
    nodes.reverse();
    let step = |node| Step { node, matrix: IDENTITY, names: Vec::new(), depth: 1 };
    Ok(nodes.into_iter().map(step).collect())
}

/// Required extensions that do not affect positions are accepted; any other is rejected by name.
fn check_extensions(root: &json::Root, into: &Collector<'_>) -> Result<(), ImportError> {
    const HARMLESS: [&str; 3] = ["KHR_materials_", "KHR_texture_", "KHR_lights_"];
    let bad = root
        .extensions_required
        .iter()
        .find(|name| !HARMLESS.iter().any(|start| name.starts_with(start)));
    match bad {
        Some(name) if compression(name).is_some() => {
            Err(into.fail(FilePosition::Whole, MeshDefect::Compressed(compressed(name))))
        }
        Some(name) => Err(into
            .fail(FilePosition::Whole, MeshDefect::Feature(format!("required extension {name}")))),
        None => Ok(()),
    }
}

/// What compresses triangles, if an extension does.
fn compression(extension: &str) -> Option<&'static str> {
    match extension {
        "KHR_draco_mesh_compression" => Some("Draco"),
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => Some("meshopt"),
        _ => None,
    }
}

/// "Draco (KHR_draco_mesh_compression)".
fn compressed(extension: &str) -> String {
    format!("{} ({extension})", compression(extension).unwrap_or("an extension"))
}

/// Names what is met and not applied: a skin, or a compressed copy beside the triangles.
fn note_what_is_left_out(root: &json::Root, into: &mut Collector<'_>) {
    let is_skinned = |node: &&json::Node| node.skin.is_some();
    let skinned = root.nodes.iter().filter(is_skinned).count();
    if skinned > 0 {
        let nodes = if skinned == 1 { "1 node has a skin" } else { "nodes have skins" };
        let count = if skinned == 1 { String::new() } else { format!("{skinned} ") };
        into.notes.push(format!(
            "{count}{nodes}, which is not applied: the mesh is as it is stored, in its bind pose"
        ));
    }
    for name in root.extensions_used.iter().filter(|name| compression(name).is_some()) {
        let with = compressed(name);
        into.notes.push(format!("compressed with {with}, too: its plain triangles are read"));
    }
}

/// The node's own transform: its matrix, else translation · rotation · scale.
fn local(node: &json::Node) -> Matrix {
    if let Some(m) = node.matrix {
        return [0, 1, 2, 3].map(|column| [0, 1, 2, 3].map(|row| f64::from(m[4 * column + row])));
    }
    let [x, y, z, w] = node.rotation.unwrap_or_default().0.map(f64::from);
    let s = node.scale.unwrap_or([1.0; 3]).map(f64::from);
    let t = node.translation.unwrap_or([0.0; 3]).map(f64::from);
    let rotation = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
        [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
        [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
    ];
    let column =
        |i: usize| [rotation[i][0] * s[i], rotation[i][1] * s[i], rotation[i][2] * s[i], 0.0];
    [column(0), column(1), column(2), [t[0], t[1], t[2], 1.0]]
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    b.map(|column| [0, 1, 2, 3].map(|row| (0..4).fold(0.0, |sum, i| sum + a[i][row] * column[i])))
}

fn apply(m: &Matrix, p: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|row| m[0][row] * p[0] + m[1][row] * p[1] + m[2][row] * p[2] + m[3][row])
}

fn determinant(m: &Matrix) -> f64 {
    let [a, b, c, _] = m;
    a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1])
        + c[0] * (a[1] * b[2] - a[2] * b[1])
}

fn add_mesh(
    source: &Source<'_>,
    node: usize,
    number: usize,
    matrix: &Matrix,
    names: &[String],
    into: &mut Collector<'_>,
) -> Result<(), ImportError> {
    let place = FilePosition::Element(format!("node {node}"));
    let Some(mesh) = source.root.meshes.get(number) else {
        let range = format!("the file has {} meshes", source.root.meshes.len());
        return Err(into.fail(place, MeshDefect::Index { index: number as i64, range }));
    };
    let flat = determinant(matrix);
    if !(flat.abs() > 1e-18) {
        return Err(into.fail(place, MeshDefect::Singular(flat)));
    }
    let own = names.last().or(mesh.name.as_ref()).cloned();
    let own = own.unwrap_or_else(|| format!("node {node}"));
    let several = mesh.primitives.len() > 1;
    for (at, primitive) in mesh.primitives.iter().enumerate() {
        let place = || FilePosition::Element(format!("mesh {number}, primitive {at}"));
        let material = primitive
            .material
            .and_then(|material| source.root.materials.get(material.value()))
            .and_then(|material| material.name.clone());
        let name = match &material {
            Some(material) if several && *material != own => format!("{own}:{material}"),
            _ => own.clone(),
        };
        let mut aliases: Vec<String> = names.to_vec();
        aliases.extend(mesh.name.clone());
        aliases.extend(material);
        aliases.retain(|alias| *alias != name);
        let part = into.part(&name, aliases)?;
        add_primitive(source, primitive, matrix, part, &place, into)?;
    }
    Ok(())
}

fn add_primitive(
    source: &Source<'_>,
    primitive: &Primitive,
    matrix: &Matrix,
    part: u16,
    place: &dyn Fn() -> FilePosition,
    into: &mut Collector<'_>,
) -> Result<(), ImportError> {
    let fail = |into: &Collector<'_>, fault| into.fail(place(), fault);
    let mode = match primitive.mode {
        Checked::Valid(mode) => mode,
        Checked::Invalid => {
            return Err(fail(into, MeshDefect::Syntax("its mode is unknown".to_owned())));
        }
    };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        into.notes.push(format!("{}points or lines left out: they have no surface", place()));
        return Ok(());
    }
    let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
    let Some(positions) = positions else {
        into.notes.push(format!("{}left out: it has no positions", place()));
        return Ok(());
    };
    let points = source.positions(positions.value()).map_err(|fault| fail(into, fault))?;
    let points: Vec<[f32; 3]> = (0..)
        .zip(points)
        .map(|(number, point)| {
            let vertex = || match place() {
                FilePosition::Element(name) => {
                    FilePosition::Element(format!("{name}, vertex {number}"))
                }
                other => other,
            };
            let point = point.map(f64::from);
            // Zero times infinity would hide the content of the file.
            let finite = point.iter().all(|x| x.is_finite());
            into.point(if finite { apply(matrix, point) } else { point }, vertex)
        })
        .collect::<Result<_, _>>()?;
    let indices: Vec<u32> = match primitive.indices {
        Some(indices) => source.indices(indices.value()).map_err(|fault| fail(into, fault))?,
        None => (0..points.len() as u32).collect(),
    };
    if let Some(bad) = indices.iter().find(|index| **index as usize >= points.len()) {
        let range = format!("the primitive has {} vertices, from 0", points.len());
        return Err(fail(into, MeshDefect::Index { index: i64::from(*bad), range }));
    }
    for [a, b, c] in triangles(mode, &indices).map_err(|fault| fail(into, fault))? {
        into.triangle([points[a as usize], points[b as usize], points[c as usize]], part)?;
    }
    Ok(())
}

/// Triangles of a list, strip or fan, wound as the specification says (section 3.7.2.1).
fn triangles(mode: Mode, indices: &[u32]) -> Result<Vec<[u32; 3]>, MeshDefect> {
    match mode {
        Mode::Triangles => match indices.as_chunks::<3>() {
            (triangles, []) => Ok(triangles.to_vec()),
            _ => Err(MeshDefect::Syntax(format!(
                "{} indices are not whole triangles",
                indices.len()
            ))),
        },
        Mode::TriangleStrip => Ok(indices
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .collect()),
        Mode::TriangleFan => {
            let hub = indices.first().copied().unwrap_or(0);
            let rim = indices.get(1..).unwrap_or(&[]);
            Ok(rim.windows(2).map(|w| [w[0], w[1], hub]).collect())
        }
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Ok(Vec::new()),
    }
}

#[cfg(test)]
mod tests;
