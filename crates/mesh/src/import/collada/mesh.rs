//! Meshes: positions by source and accessor, then the polygons that index them.

use super::super::{FilePosition, ImportError, MeshDefect, collect::Collector};
use super::place::{Matrix, apply};
use super::{Library, child, children, line, named, text};
use roxmltree::Node;

/// Adds the mesh of a geometry, placed by a matrix. `instance` binds its materials.
pub(super) fn add<'d>(
    geometry: Node<'d, 'd>,
    instance: Node<'d, 'd>,
    library: &Library<'d>,
    matrix: &Matrix,
    names: &[&str],
    into: &mut Collector<'_>,
) -> Result<(), ImportError> {
    let Some(mesh) = child(geometry, "mesh") else {
        let what = children(geometry)
            .find(|part| ["convex_mesh", "spline", "brep"].contains(&part.tag_name().name()));
        let what = what.map_or("nothing", |part| part.tag_name().name());
        let fault = MeshDefect::Feature(format!("a geometry of <{what}>"));
        return Err(into.fail(line(geometry), fault));
    };
    let label = geometry.attribute("name").or(geometry.attribute("id")).unwrap_or_default();
    let own = names.last().copied().unwrap_or(label);
    let mut points: Option<(&str, Vec<[f32; 3]>)> = None;
    for part in children(mesh) {
        let kind = part.tag_name().name();
        match kind {
            "triangles" | "polylist" | "tristrips" | "trifans" | "polygons" => {}
            "lines" | "linestrips" => {
                into.notes.push(format!("<{kind}> of \"{label}\" left out: no surface"));
                continue;
            }
            _ => continue,
        }
        let inputs = Inputs::of(part, into)?;
        let vertices = library.find(inputs.vertex, "source", "vertices", into)?;
        let id = vertices.attribute("id").unwrap_or_default();
        if points.as_ref().is_none_or(|(known, _)| *known != id) {
            points = Some((id, positions(vertices, library, matrix, into)?));
        }
        let points = points.as_ref().map_or(&[][..], |(_, points)| points);
        let material = part.attribute("material").unwrap_or_default();
        let bound = bound(instance, material, library);
        let name = match material {
            "" => own.to_owned(),
            material if material == own => own.to_owned(),
            material => format!("{own}:{}", bound.unwrap_or(material)),
        };
        let aliases = names.iter().copied().chain([label, material]).chain(bound);
        let mut aliases: Vec<String> = aliases
            .filter(|alias| !alias.is_empty() && *alias != name)
            .map(str::to_owned)
            .collect();
        aliases.dedup();
        let number = into.part(&name, aliases)?;
        polygons(part, &inputs, points, number, into)?;
    }
    Ok(())
}

/// The name of the material that an instance binds to a symbol.
fn bound<'d>(instance: Node<'d, 'd>, symbol: &str, library: &Library<'d>) -> Option<&'d str> {
    let all = child(child(instance, "bind_material")?, "technique_common")?;
    let one =
        named(all, "instance_material").find(|one| one.attribute("symbol") == Some(symbol))?;
    library.by_id.get(one.attribute("target")?.strip_prefix('#')?)?.attribute("name")
}

/// The position of the vertex in an index tuple.
struct Inputs<'d> {
    vertex: Node<'d, 'd>,
    offset: usize,
    stride: usize,
}

impl<'d> Inputs<'d> {
    fn of(part: Node<'d, 'd>, into: &Collector<'_>) -> Result<Self, ImportError> {
        let (mut vertex, mut stride) = (None, 0);
        for input in named(part, "input") {
            let offset = match input.attribute("offset").unwrap_or("0").trim().parse::<usize>() {
                Ok(offset) if offset < 64 => offset,
                _ => return Err(into.fail(line(input), MeshDefect::Syntax("a bad offset".into()))),
            };
            stride = stride.max(offset + 1);
            if input.attribute("semantic") == Some("VERTEX") {
                vertex = Some((input, offset));
            }
        }
        match vertex {
            Some((vertex, offset)) => Ok(Self { vertex, offset, stride }),
            None => {
                let fault = MeshDefect::Syntax("it has no <input semantic=\"VERTEX\">".to_owned());
                Err(into.fail(line(part), fault))
            }
        }
    }
}

/// The positions of a `<vertices>` element, transformed.
fn positions<'d>(
    vertices: Node<'d, 'd>,
    library: &Library<'d>,
    matrix: &Matrix,
    into: &Collector<'_>,
) -> Result<Vec<[f32; 3]>, ImportError> {
    let fail = |node, fault: String| into.fail(line(node), MeshDefect::Syntax(fault));
    let input = named(vertices, "input").find(|i| i.attribute("semantic") == Some("POSITION"));
    let input = input.ok_or_else(|| fail(vertices, "it has no positions".to_owned()))?;
    let source = library.find(input, "source", "source", into)?;
    let accessor = child(source, "technique_common").and_then(|common| child(common, "accessor"));
    let accessor = accessor.ok_or_else(|| fail(source, "it has no <accessor>".to_owned()))?;
    let array = library.find(accessor, "source", "float_array", into)?;
    let number = |name: &str, usual: usize| -> Result<usize, ImportError> {
        match accessor.attribute(name) {
            None => Ok(usual),
            Some(text) => text
                .trim()
                .parse()
                .map_err(|_error| fail(accessor, format!("{name}={text:?} is not a count"))),
        }
    };
    let (count, stride, offset) = (number("count", 0)?, number("stride", 1)?, number("offset", 0)?);
    let axes: Vec<Option<&str>> =
        named(accessor, "param").map(|param| param.attribute("name")).collect();
    let axis = |name: &str, usual: usize| {
        axes.iter().position(|axis| *axis == Some(name)).unwrap_or(usual)
    };
    let axes = [axis("X", 0), axis("Y", 1), axis("Z", 2)];
    if axes.iter().any(|axis| *axis >= stride) || stride > 64 {
        return Err(fail(accessor, format!("positions with a stride of {stride}")));
    }
    let text = text(array);
    let mut values = Vec::new();
    for word in text.split_ascii_whitespace() {
        // Infinities and NaN are rejected where they are used as a position, with the vertex.
        let value = word.parse::<f64>();
        values.push(value.map_err(|_error| fail(array, format!("{word:?} is not a number")))?);
    }
    let needs = count.checked_mul(stride).and_then(|n| n.checked_add(offset));
    if needs.is_none_or(|needs| needs > values.len()) {
        let fault = format!("{count} vertices are stated, {} numbers listed", values.len());
        return Err(into.fail(line(accessor), MeshDefect::Truncated(fault)));
    }
    let id = vertices.attribute("id").unwrap_or_default();
    (0..count)
        .map(|vertex| {
            let point = axes.map(|axis| values[offset + vertex * stride + axis]);
            let finite = point.iter().all(|x| x.is_finite());
            // Zero times infinity would hide the content of the file.
            let point = if finite { apply(matrix, point) } else { point };
            into.point(point, || FilePosition::Element(format!("vertex {vertex} of \"{id}\"")))
        })
        .collect()
}

/// The integers of a list.
fn indices(node: Node<'_, '_>, into: &Collector<'_>) -> Result<Vec<usize>, ImportError> {
    let read = |word: &str| {
        word.parse().map_err(|_error| {
            let fault = format!("{word:?} is not an index");
            into.fail(line(node), MeshDefect::Syntax(fault))
        })
    };
    text(node).split_ascii_whitespace().map(read).collect()
}

fn polygons(
    part: Node<'_, '_>,
    inputs: &Inputs<'_>,
    points: &[[f32; 3]],
    number: u16,
    into: &mut Collector<'_>,
) -> Result<(), ImportError> {
    let kind = part.tag_name().name();
    if let Some(hole) = child(part, "ph") {
        return Err(into.fail(line(hole), MeshDefect::Feature("a polygon with holes".to_owned())));
    }
    let mut faces = 0;
    let mut corners: Vec<[f32; 3]> = Vec::new();
    for list in named(part, "p") {
        let all = indices(list, into)?;
        if all.len() % inputs.stride != 0 {
            let fault = format!("{} indices are not whole corners", all.len());
            return Err(into.fail(line(list), MeshDefect::Truncated(fault)));
        }
        let mut own = Vec::with_capacity(all.len() / inputs.stride);
        for corner in all.chunks(inputs.stride) {
            let index = corner[inputs.offset];
            let Some(point) = points.get(index) else {
                let range = format!("the mesh has {} vertices, from 0", points.len());
                let index = i64::try_from(index).unwrap_or(i64::MAX);
                return Err(into.fail(line(list), MeshDefect::Index { index, range }));
            };
            own.push(*point);
        }
        match kind {
            "triangles" => {
                if own.len() % 3 != 0 {
                    let fault = format!("{} corners are not whole triangles", own.len());
                    return Err(into.fail(line(list), MeshDefect::Truncated(fault)));
                }
                faces += own.len() / 3;
                for triangle in own.chunks(3) {
                    into.triangle([triangle[0], triangle[1], triangle[2]], number)?;
                }
            }
            "polylist" => {
                let counts = child(part, "vcount").map(|counts| indices(counts, into));
                let counts = counts.transpose()?.unwrap_or_default();
                faces += counts.len();
                let mut rest = own.as_slice();
                for count in counts {
                    let Some((polygon, after)) = rest.split_at_checked(count) else {
                        let fault = "<vcount> asks for more corners than <p> lists".to_owned();
                        return Err(into.fail(line(list), MeshDefect::Truncated(fault)));
                    };
                    rest = after;
                    into.polygon(polygon, number, || line(list))?;
                }
            }
            "tristrips" => {
                faces += 1;
                for (n, w) in own.windows(3).enumerate() {
                    let triangle = if n % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
                    into.triangle(triangle, number)?;
                }
            }
            "trifans" => {
                faces += 1;
                for w in own.get(1..).unwrap_or_default().windows(2) {
                    into.triangle([own[0], w[0], w[1]], number)?;
                }
            }
            _ => {
                faces += 1;
                corners.clone_from(&own);
                into.polygon(&corners, number, || line(list))?;
            }
        }
    }
    let stated = part.attribute("count").and_then(|count| count.trim().parse::<usize>().ok());
    if stated.is_some_and(|stated| stated != faces) {
        let fault = format!("<{kind}> states {} and lists {faces}", stated.unwrap_or_default());
        return Err(into.fail(line(part), MeshDefect::Truncated(fault)));
    }
    Ok(())
}
