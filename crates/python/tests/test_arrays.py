"""Every kind of array is taken as it is, or refused with its place and a remedy."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest
import shapes

import trolley_av as ta

VERTICES = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]
FACES = [[0, 1, 2], [0, 1, 3]]
REAL = ["f2", "f4", "f8", ">f4", ">f8", "g", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", ">i4"]
WHOLE = ["i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", ">i8", ">u2"]
EXPECTED = np.array(VERTICES, np.float32)[np.array(FACES)]


@pytest.mark.parametrize("dtype", REAL)
def test_vertices_of_any_type(dtype):
    body = ta.Body(np.array(VERTICES, dtype), FACES)
    np.testing.assert_array_equal(body.triangles, EXPECTED)
    assert body.rounding == 0


@pytest.mark.parametrize("dtype", WHOLE)
def test_faces_of_any_type(dtype):
    np.testing.assert_array_equal(ta.Body(VERTICES, np.array(FACES, dtype)).triangles, EXPECTED)


def test_strides_orders_and_flags():
    vertices, faces = np.array(VERTICES, float), np.array(FACES)
    wide = np.zeros((8, 6))
    wide[::2, ::2] = vertices
    upward = vertices[::-1].copy()
    packed = np.zeros(4, dtype=[("name", "u1"), ("at", "f8", 3)])
    packed["at"] = vertices
    fixed = vertices.copy()
    fixed.flags.writeable = False
    for given in (wide[::2, ::2], upward[::-1], np.asfortranarray(vertices), packed["at"], fixed,
                  np.broadcast_to(vertices, (2, 4, 3))[1]):
        np.testing.assert_array_equal(ta.Body(given, faces).triangles, EXPECTED)
    np.testing.assert_array_equal(ta.Body(vertices, np.asfortranarray(faces)).triangles, EXPECTED)
    np.testing.assert_array_equal(ta.Body(vertices, faces[:, ::-1][:, ::-1]).triangles, EXPECTED)
    np.testing.assert_array_equal(ta.Body(EXPECTED).triangles, EXPECTED)
    np.testing.assert_array_equal(ta.Body(EXPECTED.astype(">f8")).triangles, EXPECTED)


def test_what_is_given_is_neither_kept_nor_changed():
    vertices, faces = np.array(VERTICES, np.float32), np.array(FACES)
    body = ta.Body(vertices, faces)
    vertices[:] = 7
    faces[:] = 0
    np.testing.assert_array_equal(body.triangles, EXPECTED)
    body.triangles[:] = 0
    np.testing.assert_array_equal(body.triangles, EXPECTED)


def test_objects_with_vertices_and_faces():
    mesh = SimpleNamespace(vertices=np.array(VERTICES), faces=np.array(FACES))
    np.testing.assert_array_equal(ta.Body(mesh).triangles, EXPECTED)
    legacy = SimpleNamespace(vertices=VERTICES, triangles=FACES)
    np.testing.assert_array_equal(ta.Body(legacy).triangles, EXPECTED)


def test_meshes_of_trimesh():
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box()
    np.testing.assert_array_equal(ta.Body(box).triangles, box.triangles.astype(np.float32))


def test_meshes_of_open3d():
    open3d = pytest.importorskip("open3d")
    ball = open3d.geometry.TriangleMesh.create_sphere()
    assert len(ta.Body(ball)) == len(ball.triangles)
    tensor = open3d.t.geometry.TriangleMesh.from_legacy(ball)
    np.testing.assert_array_equal(ta.Body(tensor).triangles, ta.Body(ball).triangles)


def test_rounding_says_how_far_vertices_moved():
    vertices = np.array(VERTICES, float)
    vertices[1, 0] = 1e6 + 0.01
    body = ta.Body(vertices, FACES)
    assert body.rounding == abs(1e6 + 0.01 - float(np.float32(1e6 + 0.01))) > 0


def test_a_body_survives_pickling():
    body = ta.Body(*shapes.ball())
    again = pickle.loads(pickle.dumps(body))
    np.testing.assert_array_equal(again.triangles, body.triangles)
    np.testing.assert_array_equal(again.bounds, body.bounds)
    assert again.bounds.shape == (2, 3)


def bad_vertices(value, row=2, axis=1):
    vertices = np.array(VERTICES, float)
    vertices[row, axis] = value
    return vertices


@pytest.mark.parametrize("vertices, faces, says", [
    (bad_vertices(np.nan), FACES, r"vertices\[2, 1\]: NaN is not finite"),
    (bad_vertices(-np.inf), FACES, r"vertices\[2, 1\]: -inf is not finite"),
    (bad_vertices(1e39), FACES, r"vertices\[2, 1\]: 1e39 is beyond the greatest float32"),
    (np.zeros((4, 2)), FACES, r"vertices: the shape is \(4, 2\), not \(n, 3\)"),
    (np.zeros(12), FACES, r"vertices: the shape is \(12,\), not \(n, 3\)"),
    (np.zeros((2, 2, 3)), None, r"without faces, the shape is \(2, 2, 3\), not \(m, 3, 3\)"),
    (np.full((2, 3, 3), np.nan), None, r"vertices\[0, 0, 0\]: NaN is not finite"),
    (np.zeros((0, 3, 3)), None, "vertices: the body has no triangles"),
    (VERTICES, np.zeros((0, 3), int), "faces: the body has no triangles"),
    (np.zeros((0, 3)), [[0, 0, 0]], r"faces\[0, 0\]: 0 is no vertex: there are 0"),
    (VERTICES, [[0, 1, 2, 3]], r"faces: the shape is \(1, 4\), not \(m, 3\)"),
    (VERTICES, [[0, 1, 2], [0, 4, 1]], r"faces\[1, 1\]: 4 is no vertex: there are 4"),
    (VERTICES, [[0, 1, -1]], r"faces\[0, 2\]: -1 is no vertex"),
    (VERTICES, np.array([[0, 1, 2**64 - 1]], np.uint64), r"faces\[0, 2\]: -1 is no vertex"),
    (VERTICES, np.array(FACES, float), "faces: an array of kind 'f' has no integers"),
    (VERTICES, np.array(FACES, bool), "faces: an array of kind 'b' has no integers"),
    (np.array(VERTICES, complex), FACES, "vertices: an array of kind 'c' has no real numbers"),
    (np.array(VERTICES, object), FACES, "vertices: an array of kind 'O' has no real numbers"),
    ([["a", "b", "c"]], FACES, "vertices: an array of kind 'U' has no real numbers"),
    ([[0, 1], [2]], FACES, "vertices: it is no array"),
    (np.ma.masked_equal(VERTICES, 4), FACES, "a masked array would lose its mask"),
    (None, FACES, "vertices: an array of kind 'O'"),
])
def test_what_is_no_body_is_refused(vertices, faces, says):
    with pytest.raises(ta.InputError, match=says) as caught:
        ta.Body(vertices, faces)
    assert caught.value.remedy and isinstance(caught.value, ValueError)


def bent(row, column, value):
    pose = np.eye(4)
    pose[row, column] = value
    return np.stack([np.eye(4), pose])


@pytest.mark.parametrize("poses, says", [
    (bent(0, 0, np.nan), r"poses\[1\]: NaN is not finite"),
    (bent(0, 3, np.inf), r"poses\[1\]: inf is not finite"),
    (bent(1, 3, 2e9), r"poses\[1\]: 2000000000 m is beyond 1e9 m"),
    (bent(0, 0, 1.001), r"poses\[1\]: the rotation is not rigid: RᵀR differs"),
    (bent(2, 2, -1.0), r"poses\[1\]: the rotation mirrors the body"),
    (bent(3, 0, 0.5), r"poses\[1\]: the last row is"),
    (bent(3, 3, 2.0), r"poses\[1\]: the last row is"),
    (2 * np.eye(4), r"poses: the last row is"),
    (np.eye(3), r"poses: the shape is \(3, 3\), not \(n, 4, 4\)"),
    (np.zeros((2, 2, 4, 4)), "poses: the shape is"),
    (np.eye(4, dtype=complex), "poses: an array of kind 'c'"),
])
def test_what_is_no_pose_is_refused(poses, says):
    body = ta.Body(VERTICES, FACES)
    for query in (ta.touches, ta.hits):
        with pytest.raises(ta.InputError, match=says) as caught:
            query(body, body, poses)
        assert caught.value.remedy


def test_poses_of_any_type_and_order():
    body = ta.Body(VERTICES, FACES)
    for dtype in REAL:
        assert ta.touches(body, body, np.eye(4, dtype=dtype)).tolist() == [True]
    poses = shapes.poses(7, 2.0, 3)
    expected = ta.touches(body, body, poses)
    for given in (np.asfortranarray(poses), poses[:, :3], poses[::-1].copy()[::-1],
                  poses.tolist(), poses.astype(">f8")):
        np.testing.assert_array_equal(ta.touches(body, body, given), expected)
    single = poses.astype(np.float32)
    assert ta.touches(body, body, single).shape == (7,), "rotations of float32 are rigid enough"


def test_other_arguments_are_refused():
    body = ta.Body(VERTICES, FACES)
    with pytest.raises(ta.InputError, match="these are 2 poses, not one"):
        ta.pairs(body, body, np.stack([np.eye(4)] * 2))
    with pytest.raises(ta.InputError, match="threads: 1000 is more than 256"):
        ta.touches(body, body, np.eye(4), threads=1000)
    with pytest.raises(ta.InputError, match="direction"):
        ta.first_contact(body, body, np.eye(4), [0, 0, 0], 1.0)
    with pytest.raises(ta.InputError):
        ta.first_contact(body, body, np.eye(4), [1, 0, 0], np.nan)
    with pytest.raises(ta.InputError, match=r"direction: the shape is \(2,\)"):
        ta.first_contact(body, body, np.eye(4), [1, 0], 1.0)
    with pytest.raises(ta.InputError, match="leaf size"):
        ta.Body(VERTICES, FACES, leaf_size=0)
    with pytest.raises(ta.InputError, match='"cube" is no shape'):
        ta.Body.generate("cube", 100)
    with pytest.raises(ta.InputError, match="no-such-file"):
        ta.Body.read("no-such-file.stl")
    with pytest.raises(TypeError):
        ta.touches(body, "body", np.eye(4))
