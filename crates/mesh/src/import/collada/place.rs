//! The transform of a scene node: the product of its transforms in file order.

use super::super::{ImportError, MeshDefect, collect::Collector};
use super::{children, line, text};
use roxmltree::Node;

/// Rows of a 4 × 4 matrix; the last is 0 0 0 1.
pub(super) type Matrix = [[f64; 4]; 4];

pub(super) const IDENTITY: Matrix =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

pub(super) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut c = [[0.0; 4]; 4];
    for (row, out) in a.iter().zip(&mut c) {
        for (column, out) in out.iter_mut().enumerate() {
            *out = (0..4).map(|i| row[i] * b[i][column]).sum();
        }
    }
    c
}

pub(super) fn apply(m: &Matrix, p: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|row| m[row][0] * p[0] + m[row][1] * p[1] + m[row][2] * p[2] + m[row][3])
}

pub(super) fn determinant(m: &Matrix) -> f64 {
    let [a, b, c, _] = m;
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// The product of a node's own transforms.
pub(super) fn local(node: Node<'_, '_>, into: &Collector<'_>) -> Result<Matrix, ImportError> {
    let mut all = IDENTITY;
    for part in children(node) {
        let one = match part.tag_name().name() {
            "matrix" => {
                let m = numbers::<16>(part, into)?;
                if m[12..] != [0.0, 0.0, 0.0, 1.0] {
                    let fault = MeshDefect::Feature("a <matrix> with perspective".to_owned());
                    return Err(into.fail(line(part), fault));
                }
                [0, 1, 2, 3].map(|row| [0, 1, 2, 3].map(|column| m[4 * row + column]))
            }
            "translate" => {
                let [x, y, z] = numbers(part, into)?;
                let mut m = IDENTITY;
                (m[0][3], m[1][3], m[2][3]) = (x, y, z);
                m
            }
            "scale" => {
                let [x, y, z] = numbers(part, into)?;
                let mut m = IDENTITY;
                (m[0][0], m[1][1], m[2][2]) = (x, y, z);
                m
            }
            "rotate" => rotation(numbers(part, into)?),
            other @ ("lookat" | "skew") => {
                let fault = MeshDefect::Feature(format!("the transform <{other}>"));
                return Err(into.fail(line(part), fault));
            }
            _ => continue,
        };
        all = product(&all, &one);
    }
    Ok(all)
}

/// Rotation about an axis by degrees (Rodrigues); a zero axis gives no rotation.
fn rotation([x, y, z, degrees]: [f64; 4]) -> Matrix {
    let length = (x * x + y * y + z * z).sqrt();
    if !(length > 0.0) {
        return IDENTITY;
    }
    let [x, y, z] = [x / length, y / length, z / length];
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let t = 1.0 - cos;
    [
        [t * x * x + cos, t * x * y - sin * z, t * x * z + sin * y, 0.0],
        [t * x * y + sin * z, t * y * y + cos, t * y * z - sin * x, 0.0],
        [t * x * z - sin * y, t * y * z + sin * x, t * z * z + cos, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

/// Exactly `N` finite numbers.
fn numbers<const N: usize>(
    node: Node<'_, '_>,
    into: &Collector<'_>,
) -> Result<[f64; N], ImportError> {
    let text = text(node);
    let mut all = [0.0; N];
    let mut words = text.split_ascii_whitespace();
    let name = node.tag_name().name();
    for value in &mut all {
        let word = words.next().unwrap_or_default();
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => *value = number,
            _ => {
                let fault = format!("<{name}> needs {N} finite numbers; {word:?} is none");
                return Err(into.fail(line(node), MeshDefect::Syntax(fault)));
            }
        }
    }
    if words.next().is_some() {
        let fault = MeshDefect::Syntax(format!("<{name}> has more than {N} numbers"));
        return Err(into.fail(line(node), fault));
    }
    Ok(all)
}
