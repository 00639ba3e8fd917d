//! `Body`: triangles with their tree.

use crate::arrays;
use crate::errors::{raise, raise_diagnostic, refuse};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::path::PathBuf;
use std::sync::Arc;
use trolley::kernel::{BuildOptions, Corners, Tree};
use trolley::model::Shape;

/// Triangles with their tree. It never changes, and any thread may use it.
///
/// ``Body(vertices, faces)`` takes (n, 3) numbers and (m, 3) indices, ``Body(triangles)`` (m, 3, 3)
/// corners, ``Body(mesh)`` what has ``vertices`` and ``faces``, such as a mesh of trimesh, or one
/// of Open3D. Arrays of any float or integer type are copied, strided or read-only ones too.
/// Triangles need not be closed, connected or oriented; one without area counts as the segment or
/// point that it is. Coordinates are stored as float32.
///
/// Refused are numbers that are not finite or beyond float32, indices out of range, masked arrays,
/// and a body without triangles.
///
/// Args:
///     vertices: metres, or any one unit.
///     faces: indices of vertices.
///     leaf_size: most triangles in a leaf of the tree; None: the usual number.
///     threads: how many build the tree; 0: one for each core.
#[pyclass(name = "Body", module = "trolley_av", frozen)]
pub(crate) struct MeshBody {
    pub(crate) tree: Arc<Tree>,
    rounding: f64,
}

#[pymethods]
impl MeshBody {
    #[new]
    #[pyo3(signature = (vertices, faces = None, *, leaf_size = None, threads = 1))]
    fn new(
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        faces: Option<&Bound<'_, PyAny>>,
        leaf_size: Option<u32>,
        threads: usize,
    ) -> PyResult<Self> {
        let given = match faces {
            Some(faces) => arrays::triangles(py, vertices, Some(faces))?,
            None => match parts(vertices)? {
                Some((vertices, faces)) => arrays::triangles(py, &vertices, Some(&faces))?,
                None => arrays::triangles(py, vertices, None)?,
            },
        };
        Self::build(py, given.corners, given.rounding, leaf_size, threads)
    }

    /// Read a mesh: STL, OBJ, PLY, glTF and others that ``trolley intersect`` reads.
    ///
    /// Coordinates are taken as they stand in the file.
    #[staticmethod]
    #[pyo3(signature = (path, *, leaf_size = None, threads = 1))]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        leaf_size: Option<u32>,
        threads: usize,
    ) -> PyResult<Self> {
        let corners = py.detach(|| trolley::kernel::read_mesh(&path));
        let corners = corners.map_err(|failure| raise(py, &failure))?;
        Self::build(py, corners, 0.0, leaf_size, threads)
    }

    /// Generate a body, such as "sedan", "pedestrian" or "pole", in metres.
    #[staticmethod]
    #[pyo3(signature = (shape, triangles, seed = 0, *, leaf_size = None, threads = 1))]
    fn generate(
        py: Python<'_>,
        shape: &str,
        triangles: u32,
        seed: u64,
        leaf_size: Option<u32>,
        threads: usize,
    ) -> PyResult<Self> {
        let Some(known) = Shape::ALL.into_iter().find(|known| known.name() == shape) else {
            let names = Shape::ALL.map(Shape::name).join(", ");
            let what = format!("\"{shape}\" is no shape");
            return Err(refuse(py, "shape", &what, &format!("one of: {names}")));
        };
        let options = BuildOptions { threads: 1, ..BuildOptions::default() };
        let body =
            py.detach(|| trolley::bodies::generate(known, triangles, seed, &options, &|_| {}));
        let body = body.map_err(|failure| raise(py, &failure))?;
        Self::build(py, in_order(&body.corners, &body.source_ids), 0.0, leaf_size, threads)
    }

    fn __len__(&self) -> usize {
        self.tree.corners().len()
    }

    fn __repr__(&self) -> String {
        format!("<trolley_av.Body of {} triangles>", self.__len__())
    }

    /// float32[m, 3, 3], the corners of the triangles as they are stored, in the order given.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let corners = in_order(self.tree.corners(), self.tree.ids());
        let flat = corners.as_flattened().as_flattened().to_vec();
        PyArray1::from_vec(py, flat).reshape([corners.len(), 3, 3])
    }

    /// float32[2, 3], the least and the greatest coordinates.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let bounds = self.tree.bounds();
        PyArray1::from_vec(py, [bounds.min, bounds.max].concat()).reshape([2, 3])
    }

    /// The greatest distance by which a vertex was moved to be stored as float32; 0: by none.
    #[getter]
    fn rounding(&self) -> f64 {
        self.rounding
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let py = slf.py();
        let triangles = slf.get().triangles(py)?;
        Ok((slf.get_type().into_any(), PyTuple::new(py, [triangles])?))
    }
}

impl MeshBody {
    fn build(
        py: Python<'_>,
        corners: Vec<Corners>,
        rounding: f64,
        leaf_size: Option<u32>,
        threads: usize,
    ) -> PyResult<Self> {
        let usual = BuildOptions::default();
        let options = BuildOptions {
            leaf_size: leaf_size.unwrap_or(usual.leaf_size),
            threads: crate::batch::threads(py, threads)?,
            ..usual
        };
        let tree = py.detach(|| Tree::build(&corners, &options));
        let tree = tree.map_err(|error| raise_diagnostic(py, error))?;
        Ok(Self { tree: Arc::new(tree), rounding })
    }
}

/// Triangles by their ids, which are all numbers below their count.
fn in_order(corners: &[Corners], ids: &[u32]) -> Vec<Corners> {
    let mut numbered: Vec<(u32, &Corners)> = ids.iter().copied().zip(corners).collect();
    numbered.sort_unstable_by_key(|(id, _)| *id);
    numbered.into_iter().map(|(_, corners)| *corners).collect()
}

/// The vertices and the faces of a mesh of trimesh, Open3D and others; `None` if it is none.
fn parts<'py>(
    mesh: &Bound<'py, PyAny>,
) -> PyResult<Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>> {
    for (vertices, faces) in [("vertices", "faces"), ("vertices", "triangles")] {
        if mesh.hasattr(vertices)? && mesh.hasattr(faces)? {
            return Ok(Some((mesh.getattr(vertices)?, mesh.getattr(faces)?)));
        }
    }
    // Open3D's meshes of tensors.
    if mesh.hasattr("vertex")? && mesh.hasattr("triangle")? {
        let vertices = mesh.getattr("vertex")?.getattr("positions")?.call_method0("numpy")?;
        let faces = mesh.getattr("triangle")?.getattr("indices")?.call_method0("numpy")?;
        return Ok(Some((vertices, faces)));
    }
    Ok(None)
}
