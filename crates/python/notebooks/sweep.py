# ---
# jupyter:
#   jupytext:
#     formats: py:percent
#   kernelspec:
#     display_name: Python 3
#     name: python3
# ---

# %% [markdown]
# # Sweep a parameter
#
# From which speed on does it matter whether the ego swerves? A scenario is a dict; two hundred of
# them share their bodies, so each takes about as long as its ranking alone.

# %%
import matplotlib.pyplot as plt
import numpy as np
import pyarrow

import trolley_av as ta


def crash(speed):
    """A pole ahead, and a pedestrian beside it."""
    return ta.Scenario.from_dict({
        "schema": "trolley.scenario/2",
        "name": f"{speed:.2f} m/s",
        "parties": {
            "ego": {"generate": {"shape": "sedan", "triangles": 3000}},
            "pole": {"generate": {"shape": "pole", "triangles": 600},
                     "place": {"position_m": [12, -1.5, 0]}},
            "pedestrian": {"generate": {"shape": "pedestrian", "triangles": 1200},
                           "state": {"position_m": [12, 0.4, 0], "yaw_deg": 90, "speed_m_s": 1}},
        },
        "candidates": [
            {"name": "straight on", "state": {"position_m": [0, 0, 0], "speed_m_s": speed}},
            {"name": "swerve",
             "state": {"position_m": [0, 0, 0], "velocity_m_s": [speed, -0.13 * speed]}},
        ],
    })


speeds = np.linspace(3, 15, 200)
rankings = ta.Session(threads=2).rank_many([crash(speed) for speed in speeds])
table = pyarrow.table(rankings).to_pylist()

# %%
figure, axes = plt.subplots(figsize=(8, 5))
for name in ("straight on", "swerve"):
    rows = [row for row in table if row["candidate"] == name]
    own = [speeds[row["scene"]] for row in rows]
    axes.plot(own, [row["work_lo"] for row in rows], label=name)
    axes.fill_between(own, [row["range_low"] for row in rows], [row["range_high"] for row in rows],
                      alpha=0.2)
axes.set_xlabel("speed (m/s)")
axes.set_ylabel("leading measure of the policy, with the model's range")
axes.legend();

# %%
assert len(table) == 2 * len(speeds) and not rankings.failures
assert {row["state"] for row in table} == {"complete"}
