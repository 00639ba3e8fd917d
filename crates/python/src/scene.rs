//! `Scene`: many bodies, and which of them touch.

use crate::arrays::{self, Poses};
use crate::batch::{answers, threads};
use crate::errors::{raise, raise_diagnostic, refuse};
use crate::mesh_body::MeshBody;
use crate::queries::refuse_count;
use numpy::PyArray2;
use pyo3::prelude::*;
use std::sync::Arc;
use trolley::Failure;
use trolley::kernel::{self, BodyView, Pose, RelativePose, Tree, Workspace};

/// Many bodies: which of them touch, wherever they stand.
///
/// Args:
///     bodies: a list of `Body`; one body may stand in it more than once.
#[pyclass(name = "Scene", module = "trolley_av", frozen)]
pub(crate) struct MeshScene {
    bodies: Vec<Arc<Tree>>,
}

#[pymethods]
impl MeshScene {
    #[new]
    fn new(py: Python<'_>, bodies: Vec<Bound<'_, MeshBody>>) -> PyResult<Self> {
        if bodies.len() > i32::MAX as usize {
            return Err(refuse(py, "bodies", "these are too many", "split the scene"));
        }
        Ok(Self { bodies: bodies.iter().map(|body| Arc::clone(&body.get().tree)).collect() })
    }

    fn __len__(&self) -> usize {
        self.bodies.len()
    }

    /// Find the pairs of bodies that touch.
    ///
    /// Args:
    ///     poses: (n, 4, 4), where each body stands in the world; rigid.
    ///     threads: how many to use; 0: one for each core.
    ///
    /// Returns:
    ///     int32[k, 2], the lesser index first, each pair once, ascending. A pair is tested at
    ///     the pose of the second in the frame of the first, as `touches` does.
    #[pyo3(signature = (poses, *, threads = 1))]
    fn pairs<'py>(
        &self,
        py: Python<'py>,
        poses: &Bound<'py, PyAny>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray2<i32>>> {
        let poses = Poses::of(py, "poses", poses)?;
        if poses.count() != self.bodies.len() {
            return Err(refuse_count(py, poses.count(), self.bodies.len()));
        }
        let poses: Result<Vec<Pose>, Failure> = (0..poses.count()).map(|k| poses.pose(k)).collect();
        let poses = poses.map_err(|failure| raise(py, &failure))?;
        let threads = self::threads(py, threads)?;
        let placed: Vec<(BodyView<'_>, Pose)> =
            self.bodies.iter().map(|tree| tree.view()).zip(poses).collect();
        let near = py.detach(|| kernel::near_pairs(&placed));
        let answer = |number: usize, workspace: &mut Workspace| {
            let (i, j) = near[number];
            let (of_i, of_j) = (&placed[i as usize], &placed[j as usize]);
            let pose = RelativePose::between(&of_i.1, &of_j.1);
            kernel::touches(of_i.0, of_j.0, &pose, workspace)
        };
        let raise = |error| raise_diagnostic(py, error);
        let found = answers(py, (near.len(), threads), Workspace::new, answer, raise)?;
        let touching = near.iter().zip(found).filter(|(_, touch)| *touch).map(|(pair, _)| *pair);
        arrays::pairs_array(py, &touching.collect::<Vec<_>>())
    }
}
