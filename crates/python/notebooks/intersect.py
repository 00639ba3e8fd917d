# ---
# jupyter:
#   jupytext:
#     formats: py:percent
#   kernelspec:
#     display_name: Python 3
#     name: python3
# ---

# %% [markdown]
# # Intersect two meshes
#
# Two cars of 20,000 triangles each, one turned by 30° and pushed into the other's side. Which
# triangles intersect, and along which curve? Instead of generated cars, give `Body` your own
# vertices and faces, or a mesh of trimesh or Open3D.

# %%
import matplotlib.pyplot as plt
import numpy as np

import trolley_av as ta

a = ta.Body.generate("sedan", 20_000)
b = ta.Body.generate("suv", 20_000)


def pose(x, y, yaw):
    """The pose of b in a's frame."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]])


into_side = pose(1.0, 2.2, np.radians(-60))
pairs = ta.pairs(a, b, into_side)
print(f"{len(pairs)} pairs of triangles, of {len(a) * len(b):,}")

# %% [markdown]
# The segments make up closed curves, on both surfaces.

# %%
curve = ta.segments(a, b, into_side)
figure = plt.figure(figsize=(7, 5))
axes = figure.add_subplot(projection="3d")
for ends in curve.points:
    axes.plot(*ends.T, color="tab:red", linewidth=1)
corners = a.triangles.reshape(-1, 3)[::40]
axes.scatter(*corners.T, s=0.2, color="grey")
axes.set_aspect("equal")
axes.set_xlabel("x (m)")
axes.set_ylabel("y (m)")
axes.set_title("where the two bodies cross");

# %% [markdown]
# How near may the second car pass? One call for a thousand poses.

# %%
sides = np.linspace(0.5, 4.0, 1_000)
poses = np.stack([pose(1.0, y, np.radians(-60)) for y in sides])
touching = ta.touches(a, b, poses, threads=0)
print(f"they touch until b is {sides[touching][-1]:.3f} m to the side")
first = ta.first_contact(a, b, pose(1.0, 4.0, np.radians(-60)), [0, -1, 0], 4.0)
print(f"moving sideways from 4 m, b first touches a after {first.travel[0]:.6f} m, at {first.points[0]}")

# %%
assert len(curve.overlaps) == 0 and len(curve.points) == len(pairs) > 100
assert abs(4.0 - first.travel[0] - sides[touching][-1]) < 0.004
