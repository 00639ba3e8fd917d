#!/usr/bin/env python3
"""A driver for ipctk's collision-free step (tight inclusion), in the manner of `sweeps.hpp`.

Bodies of more than 25,000 triangles together take it minutes: they are left out.
"""

import json
import sys
import time

import ipctk
import numpy as np

RUNS, ENOUGH_S, TRIANGLES_MAX = 3, 3.0, 25_000


def read_stl(path):
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")])
    with open(path, "rb") as file:
        file.seek(84)
        corners = np.frombuffer(file.read(), dtype=record)["corners"].astype(float)
    points, numbers = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return points, numbers.reshape(-1, 3)


def main():
    ipctk.set_num_threads(1)
    folder, limit_s = sys.argv[1], float(sys.argv[3]) if len(sys.argv) > 3 else float("inf")
    (a, faces_a), (b, faces_b) = (read_stl(f"{folder}/{name}.stl") for name in "ab")
    if len(faces_a) + len(faces_b) > TRIANGLES_MAX:
        return
    faces = np.vstack([faces_a, faces_b + len(a)])
    edges = ipctk.edges(faces)
    spent_s = 0.0
    for line in open(f"{folder}/sweeps.txt", encoding="utf-8"):
        if spent_s >= limit_s:
            break
        name, *words = line.split()
        n = np.array(words, dtype=float)
        placed = b @ n[:9].reshape(3, 3).T + n[9:12]
        direction, (start, end) = n[12:15], n[15:17]
        begin = np.vstack([a, placed + start * direction])
        goal = np.vstack([a, placed + end * direction])
        mesh = ipctk.CollisionMesh(begin, edges, faces)
        # Only A with B: within a body nothing moves.
        mesh.can_collide = ipctk.make_vertex_patches_filter(np.repeat([0, 1], [len(a), len(b)]))
        times = []
        while len(times) < RUNS and sum(times) < ENOUGH_S:
            begun = time.perf_counter()
            step = ipctk.compute_collision_free_stepsize(mesh, begin, goal)
            times.append(time.perf_counter() - begun)
        spent_s += sum(times)
        travel = None if step >= 1.0 else start + step * (end - start)
        times.sort()
        print(
            json.dumps(
                {
                    "peer": "ipctk",
                    "name": name,
                    "first_contact_m": travel,
                    "query_ms": 1e3 * times[len(times) // 2],
                }
            ),
            flush=True,
        )


main()
