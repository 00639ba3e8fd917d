"""Meshes and poses that tests share."""

import numpy as np


def soup(count, size, seed):
    """Triangles of about this size, anywhere in a cube of length 2: float32[count, 3, 3]."""
    random = np.random.default_rng(seed)
    centres = random.uniform(-1, 1, (count, 1, 3))
    return (centres + random.uniform(-size, size, (count, 3, 3))).astype(np.float32)


def lattice(count, seed, side=4):
    """Triangles with small whole coordinates: many touch, lie in one plane, or have no area."""
    return np.random.default_rng(seed).integers(0, side, (count, 3, 3)).astype(np.float32)


def ball(rings=8, sectors=12, radius=1.0):
    """A closed ball: vertices float64[n, 3] and faces int64[m, 3]."""
    vertices = [[0, 0, radius]]
    for ring in range(1, rings):
        polar = np.pi * ring / rings
        for sector in range(sectors):
            turn = 2 * np.pi * sector / sectors
            vertices.append([
                radius * np.sin(polar) * np.cos(turn),
                radius * np.sin(polar) * np.sin(turn),
                radius * np.cos(polar),
            ])
    vertices.append([0, 0, -radius])
    last = len(vertices) - 1

    def at(ring, sector):
        return 1 + (ring - 1) * sectors + sector % sectors

    faces = []
    for sector in range(sectors):
        faces.append([0, at(1, sector), at(1, sector + 1)])
        faces.append([last, at(rings - 1, sector + 1), at(rings - 1, sector)])
        for ring in range(1, rings - 1):
            faces.append([at(ring, sector), at(ring + 1, sector), at(ring + 1, sector + 1)])
            faces.append([at(ring, sector), at(ring + 1, sector + 1), at(ring, sector + 1)])
    return np.array(vertices, float), np.array(faces)


def rotation(random):
    """A random rotation: float64[3, 3]."""
    q = random.normal(size=4)
    w, x, y, z = q / np.linalg.norm(q)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


def poses(count, reach, seed):
    """Random rigid poses: float64[count, 4, 4]."""
    random = np.random.default_rng(seed)
    all = np.tile(np.eye(4), (count, 1, 1))
    for pose in all:
        pose[:3, :3] = rotation(random)
        pose[:3, 3] = random.uniform(-reach, reach, 3)
    return all


def moved(x=0.0, y=0.0, z=0.0):
    """A pose without a turn: float64[4, 4]."""
    pose = np.eye(4)
    pose[:3, 3] = [x, y, z]
    return pose
