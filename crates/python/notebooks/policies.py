# ---
# jupyter:
#   jupytext:
#     formats: py:percent
#   kernelspec:
#     display_name: Python 3
#     name: python3
# ---

# %% [markdown]
# # One CommonRoad scene under six policies
#
# Every manoeuvre that the tyres allow becomes a candidate. Which does least harm depends on whose
# injuries count, and how they are compared: that is the policy.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import pyarrow

import trolley_av as ta

here = Path.cwd()
examples = next(folder / "config/examples" for folder in [here, *here.parents]
                if (folder / "config/examples").is_dir())
scenario = ta.Scenario.open(examples / "crossing.xml")
print(scenario)

# %%
policies = ["default", "worst-off-first", "vulnerable-first", "uninvolved-first", "precaution",
            "weighted"]
session = ta.Session(threads=2)
rankings = session.rank_under(scenario, policies)
for ranking in rankings:
    print(f"{ranking.policy:>18}: {ranking.best}, {ranking.state}")

# %% [markdown]
# Everything else is a table, with a row for each candidate in its place.

# %%
table = pyarrow.table(rankings)
print(table.select(["policy", "place", "candidate", "work_lo", "work_hi", "first_party"]).slice(0, 6))

# %%
rows = table.to_pylist()
figure, axes = plt.subplots(figsize=(8, 5))
for number, policy in enumerate(policies):
    own = [row for row in rows if row["policy"] == policy]
    axes.scatter([row["place"] for row in own], [number] * len(own),
                 c=[row["contacts"] for row in own], cmap="viridis_r", vmin=0, vmax=2)
axes.set_yticks(range(len(policies)), policies)
axes.set_xlabel("place of the candidate")
axes.set_title("number of contacts, from none (yellow) to two (violet)");

# %%
assert [ranking.policy for ranking in rankings] == policies
assert len(rows) == len(policies) * len(scenario.candidates)
