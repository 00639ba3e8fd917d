"""Queries list what exact rational arithmetic lists, each against each."""

import threading
import time

import numpy as np
import oracle
import pytest
import shapes

import trolley_av as ta

CASES = {
    "soup": (shapes.soup(14, 0.6, 1), shapes.soup(14, 0.6, 2)),
    "lattice": (shapes.lattice(16, 3), shapes.lattice(16, 4)),
    "lattice of two": (shapes.lattice(16, 5, 2), shapes.lattice(16, 6, 2)),
    "hairs": (shapes.lattice(20, 7, 3)[:, [0, 1, 1]], shapes.lattice(16, 8, 3)),
    "itself": (shapes.lattice(14, 9), shapes.lattice(14, 9)),
    "far": (shapes.soup(24, 0.9, 10) + np.float32(4096), shapes.soup(24, 0.9, 11)),
}


def placed(name):
    """Poses at which a case is tried."""
    if name == "far":
        return [shapes.moved(4096, 4096, 4096)]
    return [np.eye(4), shapes.moved(1, 0, 0), shapes.moved(0.5, 0.5, 0), *shapes.poses(2, 0.5, 12)]


@pytest.mark.parametrize("name", CASES)
def test_pairs_are_those_of_exact_arithmetic(name):
    a, b = CASES[name]
    body_a, body_b = ta.Body(a), ta.Body(b)
    poses = placed(name)
    some = 0
    for pose in poses:
        expected = oracle.pairs(a, b, pose)
        found = ta.pairs(body_a, body_b, pose)
        assert found.dtype == np.int32 and found.shape == (len(expected), 2)
        assert found.tolist() == expected
        some += len(expected)
    assert some > 10
    touching = [bool(oracle.pairs(a, b, pose)) for pose in poses]
    assert ta.touches(body_a, body_b, np.stack(poses)).tolist() == touching


def test_many_poses_agree_with_pairs_of_each_on_any_number_of_threads():
    a, b = ta.Body(*shapes.ball()), ta.Body(*shapes.ball(radius=0.7))
    poses = shapes.poses(300, 1.4, 13)
    each = [ta.pairs(a, b, pose) for pose in poses]
    for threads in (1, 2, 3, 0):
        touching = ta.touches(a, b, poses, threads=threads)
        assert touching.dtype == bool
        assert touching.tolist() == [len(pairs) > 0 for pairs in each]
        hits = ta.hits(a, b, poses, threads=threads)
        for number, pairs in enumerate(each):
            of_a = hits.a_indices[hits.a_indptr[number]:hits.a_indptr[number + 1]]
            of_b = hits.b_indices[hits.b_indptr[number]:hits.b_indptr[number + 1]]
            assert of_a.tolist() == sorted(set(pairs[:, 0].tolist()))
            assert of_b.tolist() == sorted(set(pairs[:, 1].tolist()))
    assert 50 < sum(len(pairs) > 0 for pairs in each) < 250


def test_no_poses_have_no_answers():
    a = ta.Body(*shapes.ball())
    none = np.empty((0, 4, 4))
    assert ta.touches(a, a, none).shape == (0,)
    assert ta.hits(a, a, none).a_indptr.tolist() == [0]
    assert ta.first_contact(a, a, none, [1, 0, 0], 1.0).travel.shape == (0,)


def test_first_contact_is_where_pairs_begin():
    a, b = ta.Body(*shapes.ball(16, 24)), ta.Body(*shapes.ball(16, 24, 0.5))
    poses = np.stack([shapes.moved(3, y, z) for y in (0, 0.9, 2.0) for z in (0, 0.3)])
    found = ta.first_contact(a, b, poses, [-2, 0, 0], 10.0, threads=2)
    assert np.isnan(found.travel[4:]).all() and (found.pairs[4:] == -1).all()
    assert np.isnan(found.points[4:]).all()
    for pose, travel, pair in zip(poses[:4], found.travel, found.pairs):
        before, after = pose.copy(), pose.copy()
        before[0, 3] -= travel - 1e-7
        after[0, 3] -= travel + 1e-7
        assert not ta.touches(a, b, before)[0]
        assert ta.touches(a, b, after)[0]
        at = pose.copy()
        at[0, 3] -= travel
        moved = oracle.transformed(b.triangles[pair[1]][None], at)[0]
        fixed = a.triangles[pair[0]]
        gap = np.maximum(fixed.min(0) - moved.max(0), moved.min(0) - fixed.max(0))
        assert gap.max() < 1e-7, "the boxes of the pair touch then"
    each = ta.first_contact(a, b, poses, np.tile([-1.0, 0, 0], (6, 1)), 10.0)
    np.testing.assert_array_equal(each.travel, found.travel)
    assert ta.first_contact(a, b, poses[:1], [-1, 0, 0], 1.0).pairs.tolist() == [[-1, -1]]


def test_segments_are_a_closed_curve_on_both_surfaces():
    a, b = ta.Body(*shapes.ball(16, 24)), ta.Body(*shapes.ball(15, 23))
    pose = shapes.poses(1, 0.4, 14)[0]
    curve = ta.segments(a, b, pose)
    assert curve.points.shape == (len(curve.pairs), 2, 3) and len(curve.overlaps) == 0
    np.testing.assert_array_equal(curve.pairs, ta.pairs(a, b, pose))
    moved = oracle.transformed(b.triangles, pose)
    for ends, (i, j) in zip(curve.points, curve.pairs):
        for triangle in (a.triangles[i].astype(float), moved[j]):
            normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
            normal /= np.linalg.norm(normal)
            assert np.abs((ends - triangle[0]) @ normal).max() < 1e-9
    ends = curve.points.reshape(-1, 3)
    same = np.linalg.norm(ends[:, None] - ends[None], axis=-1) < 1e-9
    assert (same.sum(axis=1) % 2 == 0).all(), "every end is that of another segment"


def test_triangles_in_one_plane_overlap_and_have_no_segment():
    flat = ta.Body([[[0, 0, 0], [2, 0, 0], [0, 2, 0]]])
    curve = ta.segments(flat, flat, shapes.moved(0.5, 0.5, 0))
    assert len(curve.points) == 0 and curve.overlaps.tolist() == [[0, 0]]
    corner = ta.segments(flat, flat, shapes.moved(2, 0, 0))
    assert corner.pairs.tolist() == [[0, 0]]
    np.testing.assert_array_equal(corner.points, [[[2, 0, 0], [2, 0, 0]]])


def test_a_body_passes_through_itself_where_it_does():
    vertices, faces = shapes.ball()
    assert ta.self_pairs(ta.Body(vertices, faces)).shape == (0, 2)
    both = np.concatenate([vertices, vertices + [0.8, 0.1, 0.05]])
    twice = ta.Body(both, np.concatenate([faces, faces + len(vertices)]))
    single = ta.Body(vertices, faces)
    other = ta.Body(vertices + [0.8, 0.1, 0.05], faces)
    expected = ta.pairs(single, other) + [0, len(faces)]
    np.testing.assert_array_equal(ta.self_pairs(twice), expected)
    folded = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [1, 1.5, 0]]
    assert ta.self_pairs(ta.Body(folded, [[0, 1, 2], [0, 1, 3]])).tolist() == [[0, 1]]
    opened = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [1, -1.5, 0]]
    assert ta.self_pairs(ta.Body(opened, [[0, 1, 2], [1, 0, 3]])).tolist() == []


def test_a_scene_lists_the_bodies_that_touch():
    bodies = [ta.Body(*shapes.ball(6, 8, radius)) for radius in np.linspace(0.2, 0.5, 30)]
    poses = shapes.poses(30, 2.0, 15)
    expected = []
    for i in range(30):
        for j in range(i + 1, 30):
            between = np.linalg.inv(poses[i]) @ poses[j]
            between[3] = [0, 0, 0, 1]
            if ta.touches(bodies[i], bodies[j], between)[0]:
                expected.append([i, j])
    for threads in (1, 2):
        assert ta.Scene(bodies).pairs(poses, threads=threads).tolist() == expected
    assert 5 < len(expected) < 200
    assert ta.Scene([]).pairs(np.empty((0, 4, 4))).shape == (0, 2)
    with pytest.raises(ValueError, match="29 poses for 30 bodies"):
        ta.Scene(bodies).pairs(poses[:29])


def test_other_threads_of_python_run_meanwhile():
    a = ta.Body.generate("sedan", 20_000)
    poses = np.tile(np.eye(4), (400, 1, 1))
    poses[:, 0, 3] = np.linspace(3.0, 5.0, 400)
    ticks = []
    is_over = threading.Event()

    def tick():
        while not is_over.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begun = time.perf_counter()
    for _ in range(3):
        ta.hits(a, a, poses)
    ended = time.perf_counter()
    is_over.set()
    thread.join()
    during = sum(begun < time_ < ended for time_ in ticks)
    assert during > 0.05 * (ended - begun) / 0.001, f"{during} in {ended - begun} s"
