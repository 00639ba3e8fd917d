"""What a type checker makes of the signatures: `mypy --strict` finds nothing here."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import trolley_av as ta


def meshes() -> NDArray[np.int32]:
    """Bodies and queries."""
    body = ta.Body(np.zeros((3, 3)), [[0, 1, 2]])
    poses = np.tile(np.eye(4), (3, 1, 1))
    touching: NDArray[np.bool_] = ta.touches(body, body, poses, threads=2)
    travel: NDArray[np.float64] = ta.first_contact(body, body, poses, [1, 0, 0], 1.0).travel
    points: NDArray[np.float64] = ta.segments(body, body).points
    indices: NDArray[np.int32] = ta.hits(body, body, poses).a_indices
    print(len(body), touching, travel, points, indices, ta.Scene([body]).pairs(poses[:1]))
    return ta.pairs(body, body)


def rankings() -> list[str | None]:
    """Scenarios and their rankings."""
    session = ta.Session(threads=2)
    scenario = ta.Scenario.open(Path("crash.toml")).with_policy("weighted")
    try:
        ranking = session.rank(scenario, members=8, explain=True)
    except ta.InputError as error:
        print(error.what, error.remedy)
        return []
    print(ranking.best, ranking.answer["ranking"], ranking.json)
    return [one.best for one in session.rank_under(scenario, ta.policy_names())]
