//! Arrays of Python, checked and copied: triangles, poses, directions.

use crate::errors::{raise, refuse};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trolley::kernel::{Corners, Pose, RelativePose};
use trolley::{Failure, poses};

/// An array of numbers, copied in the order of C.
pub(crate) struct Numbers<T> {
    pub(crate) shape: Vec<usize>,
    pub(crate) values: Vec<T>,
}

/// Anything as an array of f64. Refuses what has no numbers, and what masks some.
pub(crate) fn floats(
    py: Python<'_>,
    name: &str,
    given: &Bound<'_, PyAny>,
) -> PyResult<Numbers<f64>> {
    let (array, kind) = array(py, name, given)?;
    if !matches!(kind, 'f' | 'i' | 'u') {
        let what = format!("an array of kind '{kind}' has no real numbers");
        return Err(refuse(py, name, &what, "give floats or integers: numpy.asarray(..., float)"));
    }
    numbers(py, &array, "float64")
}

/// Anything as an array of i64, of which 2⁶³ and more become negative.
pub(crate) fn integers(
    py: Python<'_>,
    name: &str,
    given: &Bound<'_, PyAny>,
) -> PyResult<Numbers<i64>> {
    let (array, kind) = array(py, name, given)?;
    if !matches!(kind, 'i' | 'u') {
        let what = format!("an array of kind '{kind}' has no integers");
        return Err(refuse(
            py,
            name,
            &what,
            "indices are integers: numpy.asarray(..., numpy.int64)",
        ));
    }
    numbers(py, &array, "int64")
}

/// `numpy.asarray`, and the kind of its numbers.
fn array<'py>(
    py: Python<'py>,
    name: &str,
    given: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyAny>, char)> {
    let numpy = py.import("numpy")?;
    if given.is_instance(&numpy.getattr("ma")?.getattr("MaskedArray")?)? {
        let remedy = "fill or drop what is masked: array.filled(...), array.compressed()";
        return Err(refuse(py, name, "a masked array would lose its mask", remedy));
    }
    let array = numpy.call_method1("asarray", (given,)).map_err(|error| {
        refuse(
            py,
            name,
            &format!("it is no array: {error}"),
            "give a numpy array, or lists of one length",
        )
    })?;
    let kind: char = array.getattr("dtype")?.getattr("kind")?.extract()?;
    Ok((array, kind))
}

/// A copy of an array in native order, aligned and without gaps.
fn numbers<'py, T: numpy::Element + Copy>(
    py: Python<'py>,
    array: &Bound<'py, PyAny>,
    dtype: &str,
) -> PyResult<Numbers<T>> {
    let options = PyDict::new(py);
    options.set_item("dtype", dtype)?;
    options.set_item("requirements", ["C", "A"])?;
    // numpy warns where a number of a longer type becomes infinite; that is refused later.
    let numpy = py.import("numpy")?;
    let silent = PyDict::new(py);
    silent.set_item("over", "ignore")?;
    silent.set_item("invalid", "ignore")?;
    let context = numpy.call_method("errstate", (), Some(&silent))?;
    context.call_method0("__enter__")?;
    let plain = numpy.call_method("require", (array,), Some(&options));
    context.call_method1("__exit__", (py.None(), py.None(), py.None()))?;
    let plain: PyReadonlyArrayDyn<'py, T> = plain?.extract()?;
    let values = plain.as_slice()?.to_vec();
    Ok(Numbers { shape: plain.shape().to_vec(), values })
}

/// A shape as Python writes it.
fn shape_name(shape: &[usize]) -> String {
    let numbers: Vec<String> = shape.iter().map(ToString::to_string).collect();
    format!("({}{})", numbers.join(", "), if shape.len() == 1 { "," } else { "" })
}

/// Corners as they are stored, f32, and the greatest distance by which one was rounded.
pub(crate) struct StoredTriangles {
    pub(crate) corners: Vec<Corners>,
    pub(crate) rounding: f64,
}

/// A number of `name` as it is stored.
fn stored(py: Python<'_>, place: &dyn Fn() -> String, value: f64) -> PyResult<f32> {
    let stored = value as f32;
    if !value.is_finite() {
        let remedy = "drop or mend what is not finite: numpy.isfinite finds it";
        return Err(refuse(py, &place(), &format!("{value} is not finite"), remedy));
    }
    if !stored.is_finite() {
        let what = format!("{value:e} is beyond the greatest float32, 3.4e38");
        return Err(refuse(py, &place(), &what, "use a larger unit"));
    }
    Ok(stored)
}

/// Triangles from vertices and faces, or from corners of shape (m, 3, 3) without faces.
pub(crate) fn triangles(
    py: Python<'_>,
    vertices: &Bound<'_, PyAny>,
    faces: Option<&Bound<'_, PyAny>>,
) -> PyResult<StoredTriangles> {
    let Some(faces) = faces else { return corners(py, vertices) };
    let vertices = floats(py, "vertices", vertices)?;
    let &[count, 3] = &vertices.shape[..] else {
        let what = format!("the shape is {}, not (n, 3)", shape_name(&vertices.shape));
        return Err(refuse(py, "vertices", &what, "give one row of x, y, z for each vertex"));
    };
    let (points, _) = vertices.values.as_chunks::<3>();
    let mut rounded = Vec::with_capacity(count);
    let mut rounding = 0.0_f64;
    for (row, point) in points.iter().enumerate() {
        let mut to = [0.0_f32; 3];
        for (axis, value) in point.iter().enumerate() {
            to[axis] = stored(py, &|| format!("vertices[{row}, {axis}]"), *value)?;
        }
        rounding = rounding.max(moved(point, &to));
        rounded.push(to);
    }
    let faces = integers(py, "faces", faces)?;
    let &[_, 3] = &faces.shape[..] else {
        let what = format!("the shape is {}, not (m, 3)", shape_name(&faces.shape));
        let remedy = "give three indices for each face: split quads and polygons first";
        return Err(refuse(py, "faces", &what, remedy));
    };
    let (rows, _) = faces.values.as_chunks::<3>();
    let mut corners = Vec::with_capacity(rows.len());
    for (row, face) in rows.iter().enumerate() {
        let mut three = [[0.0; 3]; 3];
        for (column, index) in face.iter().enumerate() {
            let vertex = usize::try_from(*index).ok().and_then(|index| rounded.get(index));
            three[column] = *vertex.ok_or_else(|| {
                let what = format!("{index} is no vertex: there are {count}");
                let place = format!("faces[{row}, {column}]");
                refuse(py, &place, &what, "indices begin at 0 and end before their number")
            })?;
        }
        corners.push(three);
    }
    if corners.is_empty() {
        return Err(empty(py, "faces"));
    }
    Ok(StoredTriangles { corners, rounding })
}

fn corners(py: Python<'_>, given: &Bound<'_, PyAny>) -> PyResult<StoredTriangles> {
    let given = floats(py, "vertices", given)?;
    let &[_, 3, 3] = &given.shape[..] else {
        let what =
            format!("without faces, the shape is {}, not (m, 3, 3)", shape_name(&given.shape));
        return Err(refuse(
            py,
            "vertices",
            &what,
            "give faces too, or the corners of each triangle",
        ));
    };
    let (points, _) = given.values.as_chunks::<3>();
    let mut rounding = 0.0_f64;
    let mut flat = Vec::with_capacity(points.len());
    for (number, point) in points.iter().enumerate() {
        let mut to = [0.0_f32; 3];
        for (axis, value) in point.iter().enumerate() {
            let place = || format!("vertices[{}, {}, {axis}]", number / 3, number % 3);
            to[axis] = stored(py, &place, *value)?;
        }
        rounding = rounding.max(moved(point, &to));
        flat.push(to);
    }
    let (corners, _) = flat.as_chunks::<3>();
    if corners.is_empty() {
        return Err(empty(py, "vertices"));
    }
    Ok(StoredTriangles { corners: corners.to_vec(), rounding })
}

fn empty(py: Python<'_>, name: &str) -> PyErr {
    refuse(py, name, "the body has no triangles", "give at least one: was the mesh loaded whole?")
}

fn moved(from: &[f64; 3], to: &[f32; 3]) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|axis| from[axis] - f64::from(to[axis]));
    x.hypot(y).hypot(z)
}

/// Poses of shape (4, 4), (n, 4, 4) or (n, 3, 4), each of which is checked when it is taken: on the
/// thread that needs it.
pub(crate) struct Poses<'n> {
    name: &'n str,
    values: Vec<f64>,
    /// Of each matrix.
    rows: usize,
    is_single: bool,
}

impl<'n> Poses<'n> {
    pub(crate) fn of(py: Python<'_>, name: &'n str, given: &Bound<'_, PyAny>) -> PyResult<Self> {
        let given = floats(py, name, given)?;
        let rows = match given.shape[..] {
            [4, 4] | [_, 4, 4] => 4,
            [_, 3, 4] => 3,
            _ => {
                let what = format!(
                    "the shape is {}, not (n, 4, 4), (4, 4) or (n, 3, 4)",
                    shape_name(&given.shape)
                );
                return Err(refuse(py, name, &what, "give R | t in rows, and 0 0 0 1 below"));
            }
        };
        let is_single = given.shape.len() == 2;
        Ok(Self { name, values: given.values, rows, is_single })
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.values.len() / (4 * self.rows)
    }

    /// One of them, below their number: finite and rigid, or a refusal that names its place.
    pub(crate) fn pose(&self, number: usize) -> Result<Pose, Failure> {
        let matrix = &self.values[4 * self.rows * number..][..4 * self.rows];
        let place = || match self.is_single {
            true => self.name.to_owned(),
            false => format!("{}[{number}]", self.name),
        };
        if self.rows == 4 && matrix[12..] != [0.0, 0.0, 0.0, 1.0] {
            let what = format!("{}: the last row is {:?}, not 0 0 0 1", place(), &matrix[12..]);
            let remedy = "give R | t in rows: a transposed matrix has t in its last row";
            return Err(Failure::input(what).with_remedy(remedy));
        }
        let pose = Pose {
            rotation: [0, 1, 2].map(|i| [0, 1, 2].map(|j| matrix[4 * i + j])),
            translation: [0, 1, 2].map(|i| matrix[4 * i + 3]),
        };
        poses::check(&pose).map_err(|failure| failure.at(place()))?;
        Ok(pose)
    }

    /// One of them, as a pose of B in A's frame.
    pub(crate) fn relative(&self, number: usize) -> Result<RelativePose, Failure> {
        let Pose { rotation, translation } = self.pose(number)?;
        Ok(RelativePose { rotation, translation })
    }
}

/// One pose of B in A's frame.
pub(crate) fn one_pose(
    py: Python<'_>,
    name: &str,
    given: Option<&Bound<'_, PyAny>>,
) -> PyResult<RelativePose> {
    let Some(given) = given else {
        return Ok(RelativePose {
            rotation: Pose::IDENTITY.rotation,
            translation: Pose::IDENTITY.translation,
        });
    };
    let all = Poses::of(py, name, given)?;
    if all.count() != 1 {
        let what = format!("these are {} poses, not one", all.count());
        return Err(refuse(
            py,
            name,
            &what,
            "call this once for each pose, or ask touches or hits",
        ));
    }
    all.relative(0).map_err(|failure| raise(py, &failure))
}

/// Directions of shape (3,), for all, or (n, 3).
pub(crate) fn directions(
    py: Python<'_>,
    given: &Bound<'_, PyAny>,
    count: usize,
) -> PyResult<Vec<[f64; 3]>> {
    let given = floats(py, "direction", given)?;
    let (rows, _) = given.values.as_chunks::<3>();
    match given.shape[..] {
        [3] => Ok(vec![rows[0]; count]),
        [n, 3] if n == count => Ok(rows.to_vec()),
        _ => {
            let what =
                format!("the shape is {}, not (3,) or ({count}, 3)", shape_name(&given.shape));
            Err(refuse(py, "direction", &what, "give one for all poses, or one for each"))
        }
    }
}

/// An array of pairs, of shape (k, 2).
pub(crate) fn pairs_array<'py>(
    py: Python<'py>,
    pairs: &[(u32, u32)],
) -> PyResult<Bound<'py, PyArray2<i32>>> {
    let flat: Vec<i32> =
        pairs.iter().flat_map(|pair| [pair.0.cast_signed(), pair.1.cast_signed()]).collect();
    PyArray1::from_vec(py, flat).reshape([pairs.len(), 2])
}
