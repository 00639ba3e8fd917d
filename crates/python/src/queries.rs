//! The queries of two bodies: for one pose, or for many.

use crate::arrays::{self, Poses};
use crate::batch::{answers, threads};
use crate::errors::{raise, raise_diagnostic, refuse};
use crate::mesh_body::MeshBody;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use trolley::Failure;
use trolley::kernel::{self, HitSets, Sweep, SweepWorkspace, Witness, Workspace};

/// Find at which poses two bodies touch.
///
/// Args:
///     a, b: bodies.
///     poses: (N, 4, 4), the poses of b in a's frame, rigid: R | t in rows, 0 0 0 1 below. Also
///         (4, 4) for one, or (N, 3, 4).
///     threads: how many to use; 0: one for each core.
///
/// Returns:
///     bool[N].
#[pyfunction]
#[pyo3(signature = (a, b, poses, *, threads = 1))]
pub(crate) fn touches<'py>(
    py: Python<'py>,
    a: &Bound<'py, MeshBody>,
    b: &Bound<'py, MeshBody>,
    poses: &Bound<'py, PyAny>,
    threads: usize,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let poses = Poses::of(py, "poses", poses)?;
    let threads = self::threads(py, threads)?;
    let (a, b) = (&*a.get().tree, &*b.get().tree);
    let answer = |number: usize, workspace: &mut Workspace| -> Result<bool, Failure> {
        Ok(kernel::touches(a, b, &poses.relative(number)?, workspace)?)
    };
    let raise = |failure: Failure| raise(py, &failure);
    let found = answers(py, (poses.count(), threads), Workspace::new, answer, raise)?;
    Ok(PyArray1::from_vec(py, found))
}

/// Find all pairs of triangles of two bodies that intersect.
///
/// Args:
///     a, b: bodies.
///     pose: (4, 4), the pose of b in a's frame; None: they share a frame.
///
/// Returns:
///     int32[k, 2], indices of triangles of a and of b, each pair once, ascending.
#[pyfunction]
#[pyo3(signature = (a, b, pose = None))]
pub(crate) fn pairs<'py>(
    py: Python<'py>,
    a: &Bound<'py, MeshBody>,
    b: &Bound<'py, MeshBody>,
    pose: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray2<i32>>> {
    let pose = arrays::one_pose(py, "pose", pose)?;
    let (a, b) = (&*a.get().tree, &*b.get().tree);
    let found = py.detach(|| kernel::pairs(a, b, &pose, &mut Workspace::new()));
    arrays::pairs_array(py, &found.map_err(|error| raise_diagnostic(py, error))?)
}

/// Rows of indices, one for each pose.
type Rows<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i32>>);

/// The triangles of each body that are hit, at each pose.
#[pyfunction]
#[pyo3(signature = (a, b, poses, *, threads = 1))]
pub(crate) fn hits<'py>(
    py: Python<'py>,
    a: &Bound<'py, MeshBody>,
    b: &Bound<'py, MeshBody>,
    poses: &Bound<'py, PyAny>,
    threads: usize,
) -> PyResult<(Rows<'py>, Rows<'py>)> {
    let poses = Poses::of(py, "poses", poses)?;
    let threads = self::threads(py, threads)?;
    let (a, b) = (&*a.get().tree, &*b.get().tree);
    let answer = |number: usize, workspace: &mut Workspace| -> Result<HitSets, Failure> {
        Ok(kernel::sets(a, b, &poses.relative(number)?, workspace)?)
    };
    let raise = |failure: Failure| raise(py, &failure);
    let found = answers(py, (poses.count(), threads), Workspace::new, answer, raise)?;
    let rows = |ids: fn(&HitSets) -> &Vec<u32>| {
        let mut ends = vec![0_i64];
        let mut all = Vec::new();
        for hits in &found {
            all.extend(ids(hits).iter().map(|id| id.cast_signed()));
            ends.push(all.len() as i64);
        }
        (PyArray1::from_vec(py, ends), PyArray1::from_vec(py, all))
    };
    Ok((rows(|hits| &hits.of_a), rows(|hits| &hits.of_b)))
}

/// Travels, pairs and points of first contacts.
type FirstContacts<'py> =
    (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<i32>>, Bound<'py, PyArray2<f64>>);

/// When a body that moves along a straight line first touches the other one, from each pose.
#[pyfunction]
pub(crate) fn first_contact<'py>(
    py: Python<'py>,
    a: &Bound<'py, MeshBody>,
    b: &Bound<'py, MeshBody>,
    poses: &Bound<'py, PyAny>,
    direction: &Bound<'py, PyAny>,
    travel: [f64; 2],
    threads: usize,
) -> PyResult<FirstContacts<'py>> {
    let poses = Poses::of(py, "poses", poses)?;
    let threads = self::threads(py, threads)?;
    let directions = arrays::directions(py, direction, poses.count())?;
    let [start, to] = travel;
    let sweep = |direction: &[f64; 3]| Sweep::new((*direction).into(), start, to);
    let sweeps: Result<Vec<Sweep>, _> = directions.iter().map(sweep).collect();
    let sweeps = sweeps.map_err(|error| raise_diagnostic(py, error))?;
    let (a, b) = (&*a.get().tree, &*b.get().tree);
    let answer = |number: usize, workspace: &mut SweepWorkspace| {
        let pose = poses.relative(number)?;
        Ok(kernel::first_contact(a, b, &pose, &sweeps[number], workspace)?)
    };
    let raise = |failure: Failure| raise(py, &failure);
    let found = answers(py, (poses.count(), threads), SweepWorkspace::new, answer, raise)?;
    let travel = |first: &Option<Witness>| first.map_or(f64::NAN, |first| first.travel_m);
    let ids = |first: &Option<Witness>| first.map_or([-1; 2], |of| of.ids.map(u32::cast_signed));
    let point = |first: &Option<Witness>| first.map_or([f64::NAN; 3], |of| of.point.to_array());
    let count = found.len();
    Ok((
        PyArray1::from_vec(py, found.iter().map(travel).collect()),
        PyArray1::from_vec(py, found.iter().flat_map(ids).collect()).reshape([count, 2])?,
        PyArray1::from_vec(py, found.iter().flat_map(point).collect()).reshape([count, 3])?,
    ))
}

/// Ends of segments, their pairs, and pairs that overlap in one plane.
type Curve<'py> = (Bound<'py, PyArray3<f64>>, Bound<'py, PyArray2<i32>>, Bound<'py, PyArray2<i32>>);

/// The segments in which two bodies cross.
#[pyfunction]
#[pyo3(signature = (a, b, pose = None))]
pub(crate) fn segments<'py>(
    py: Python<'py>,
    a: &Bound<'py, MeshBody>,
    b: &Bound<'py, MeshBody>,
    pose: Option<&Bound<'py, PyAny>>,
) -> PyResult<Curve<'py>> {
    let pose = arrays::one_pose(py, "pose", pose)?;
    let (a, b) = (&*a.get().tree, &*b.get().tree);
    let found = py.detach(|| kernel::contacts(a, b, &pose, &mut Workspace::new()));
    let found = found.map_err(|error| raise_diagnostic(py, error))?;
    let (mut ends, mut crossing, mut flat) = (Vec::new(), Vec::new(), Vec::new());
    for contact in &found {
        let pair = (contact.ids[0], contact.ids[1]);
        match contact.points.points() {
            [from, .., to] if contact.points.points().len() == 2 => {
                ends.extend(from.to_array().into_iter().chain(to.to_array()));
                crossing.push(pair);
            }
            [point] => {
                ends.extend(point.to_array().into_iter().chain(point.to_array()));
                crossing.push(pair);
            }
            _ => flat.push(pair),
        }
    }
    let ends = PyArray1::from_vec(py, ends).reshape([crossing.len(), 2, 3])?;
    Ok((ends, arrays::pairs_array(py, &crossing)?, arrays::pairs_array(py, &flat)?))
}

/// Find the pairs of triangles in which a body passes through itself.
///
/// Neighbours that have only corners or an edge of both in common are no pair; neighbours that are
/// folded upon each other are one. Corners are the same if their coordinates are.
///
/// Returns:
///     int32[k, 2], the lesser index first, each pair once, ascending.
#[pyfunction]
pub(crate) fn self_pairs<'py>(
    py: Python<'py>,
    body: &Bound<'py, MeshBody>,
) -> PyResult<Bound<'py, PyArray2<i32>>> {
    let tree = &*body.get().tree;
    let found = py.detach(|| kernel::self_pairs(tree, &mut Workspace::new()));
    arrays::pairs_array(py, &found.map_err(|error| raise_diagnostic(py, error))?)
}

/// The refusal of a number of poses that is not that of the bodies.
pub(crate) fn refuse_count(py: Python<'_>, poses: usize, bodies: usize) -> PyErr {
    let what = format!("these are {poses} poses for {bodies} bodies");
    refuse(py, "poses", &what, "give one pose in the world for each body, in their order")
}
