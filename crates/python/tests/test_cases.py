"""Pairs on real meshes and on the cases that all kernels are compared on are the exact ones."""

import json

import numpy as np
import oracle
import pytest
import shapes

import trolley_av as ta

# Side by side, turned, and one through the other: rotation about z (degrees), position (m).
MEETINGS = [(0, 0, 0, 0), (12, 0.4, 0.2, 0.05), (90, 1.1, -0.3, 0), (171, -0.7, 0.5, 0.1)]

# Meshes of others, below `models`.
SHARED = [
    ("gazebo_pickup/pickup.dae", "gazebo_lamp_post/lamp_post.dae"),
    ("osrf_prius/hybrid_body.obj", "gazebo_hatchback/hatchback.obj"),
    ("chrono_sedan/sedan_chassis_vis.obj", "chrono_nissan_patrol_suv/suv_chassis.obj"),
    ("makehuman_base/base.obj", "chrono_man10t_truck/MAN_10t_chassis.obj"),
]


def pose_of(degrees, x, y, z):
    """A turn about the vertical, then a way: float64[4, 4]."""
    turn = np.radians(degrees)
    pose = shapes.moved(x, y, z)
    pose[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    return pose


def in_size(path):
    """The triangles of a mesh about its middle, four metres long, some on a grid of millimetres."""
    triangles = ta.Body.read(path).triangles.astype(float)
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    scaled = (triangles - (low + high) / 2) * (4 / (high - low).max())
    scaled[::3] = np.round(scaled[::3], 3)
    return scaled.astype(np.float32)


def compare(first, second):
    """Compares every meeting of two meshes with exact arithmetic; returns how many pairs it found."""
    a, b = in_size(first), in_size(second)
    body_a, body_b = ta.Body(a), ta.Body(b)
    # Of large meshes some triangles: exact arithmetic takes its time.
    every = len(a) // 1000 + 1
    some = 0
    for meeting in MEETINGS:
        pose = pose_of(*meeting)
        expected = oracle.pairs(a, b, pose, every)
        found = ta.pairs(body_a, body_b, pose)
        assert found[found[:, 0] % every == 0].tolist() == expected
        assert ta.touches(body_a, body_b, pose).tolist() == [len(found) > 0]
        some += len(expected)
    return some


def test_real_meshes_meet_where_exact_arithmetic_says(root):
    data = root / "tests/data"
    assert compare(data / "hatchback.obj", data / "jersey_barrier.dae") > 100
    assert compare(data / "hatchback.obj", data / "hatchback.obj") > 1000


@pytest.mark.parametrize(("first", "second"), SHARED, ids=lambda path: path.split("/")[0])
def test_meshes_of_others_meet_where_exact_arithmetic_says(root, first, second):
    models = root.parent / "shared/data/models"
    if not models.is_dir():
        pytest.skip("needs ../shared/data")
    assert compare(models / first, models / second) > 20


def world_poses(path):
    """The poses of A and of B: twice three rows (R | t)."""
    numbers = [float(word) for word in path.read_text().split()]
    return [[numbers[12 * k + 4 * row:12 * k + 4 * row + 4] for row in range(3)] for k in range(2)]


def relative(of_a, of_b):
    """The pose of B in the frame of A, each sum from the left: float64[4, 4]."""
    pose = np.eye(4)
    way = [of_b[row][3] - of_a[row][3] for row in range(3)]
    for i in range(3):
        column = [of_a[row][i] for row in range(3)]
        for j in range(3):
            x, y, z = (column[row] * of_b[row][j] for row in range(3))
            pose[i, j] = x + y + z
        x, y, z = (column[row] * way[row] for row in range(3))
        pose[i, 3] = x + y + z
    return pose


def hash_of(pairs):
    """The sum of splitmix64 of all pairs, as the drivers in tools/peers form it."""
    x = (pairs[:, 0].astype(np.uint64) << np.uint64(32)) | pairs[:, 1].astype(np.uint64)
    x += np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return f"{int((x ^ (x >> np.uint64(31))).sum(dtype=np.uint64)):016x}"


def test_cases_have_the_pairs_that_the_exact_oracle_recorded(root, case):
    lines = (root / "tools/results/compare.jsonl").read_text().splitlines()
    records = (json.loads(line) for line in lines)
    exact = next(r["exact"] for r in records if r.get("case") == case.name and "exact" in r)
    pose = relative(*world_poses(case / "pose.txt"))
    a, b = ta.Body.read(case / "a.stl"), ta.Body.read(case / "b.stl")
    pairs = ta.pairs(a, b, pose)
    assert (len(pairs), hash_of(pairs)) == (exact["pairs"], exact["hash"])
    hits = ta.hits(a, b, pose)
    assert (len(hits.a_indices), len(hits.b_indices)) == (exact["hits_a"], exact["hits_b"])
    assert ta.touches(a, b, pose).tolist() == [exact["pairs"] > 0]
