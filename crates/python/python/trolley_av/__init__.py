"""Exact intersection of triangle meshes, and the ranking of manoeuvres by the harm that they do.

Meshes of anybody::

    a = trolley_av.Body(vertices, faces)         # (n, 3) and (m, 3); or a mesh of trimesh, Open3D
    trolley_av.touches(a, b, poses)              # bool[N], for poses of b in a's frame, (N, 4, 4)
    trolley_av.pairs(a, b, pose)                 # int32[k, 2], sorted
    trolley_av.segments(a, b, pose).points       # float64[k, 2, 3]: the curve in which they cross

Scenarios::

    session = trolley_av.Session()
    ranking = session.rank(trolley_av.Scenario.open("crash.toml"))
    ranking.best, ranking.answer["ranking"]

What is exact: coordinates are stored as float32 (`Body.rounding` says by how much they moved), and
transformed in float64 as ``((R0 x + R1 y) + R2 z) + t``. On the coordinates that this gives, every
answer is exact: two triangles are a pair if and only if they have a point in common, touching
included. Lengths are in metres, or in any one unit: nothing depends on it but the names.

What is refused raises `InputError`, which is a `ValueError`: it names the argument, the place in it
and a remedy. Nothing that was given is changed or kept.
"""

import json as _json
from typing import NamedTuple as _NamedTuple

import numpy as _numpy

from . import _core
from ._core import (
    BUILD,
    Body,
    Ranking,
    Rankings,
    Scenario,
    Scene,
    Searched,
    pairs,
    policy_names,
    self_pairs,
    touches,
)
from ._commonroad import from_commonroad
from ._errors import InputError, TrolleyError
from ._plot import plot

__all__ = [
    "BUILD", "Body", "FirstContact", "Hits", "InputError", "Ranking", "Rankings", "Scenario",
    "Scene", "Searched", "Segments", "Session", "TrolleyError", "assess_many", "check_policies",
    "first_contact", "from_commonroad", "hits", "pairs", "plot", "policy_names", "segments", "self_pairs", "touches",
]


class Hits(_NamedTuple):
    """Triangles that are hit, at each of N poses, in the form of compressed sparse rows.

    At pose i, the triangles of A are ``a_indices[a_indptr[i]:a_indptr[i + 1]]``, ascending.

    Attributes:
        a_indptr: int64[N + 1].
        a_indices: int32[...], triangles of A that intersect any of B.
        b_indptr: int64[N + 1].
        b_indices: int32[...], triangles of B that intersect any of A.
    """

    a_indptr: _numpy.ndarray
    a_indices: _numpy.ndarray
    b_indptr: _numpy.ndarray
    b_indices: _numpy.ndarray


class FirstContact(_NamedTuple):
    """When a body first touches another one, from each of N poses.

    Attributes:
        travel: float64[N], the first travel at which they touch (m); NaN if they never do.
        pairs: int32[N, 2], the triangles of A and B that touch then; -1 if they never do.
        points: float64[N, 3], where, in A's frame (m), rounded; NaN if they never do.
    """

    travel: _numpy.ndarray
    pairs: _numpy.ndarray
    points: _numpy.ndarray


class Segments(_NamedTuple):
    """The curve in which two bodies cross, as segments in no order along it.

    Attributes:
        points: float64[k, 2, 3], the two ends of each segment, in A's frame (m). Both are equal
            where two triangles touch in a point. Which edges an end lies on is exact; its
            coordinates are rounded.
        pairs: int32[k, 2], the triangles of each segment.
        overlaps: int32[m, 2], pairs of triangles that overlap in one plane, and have no segment.
    """

    points: _numpy.ndarray
    pairs: _numpy.ndarray
    overlaps: _numpy.ndarray


def hits(a, b, poses, *, threads=1):
    """Find the triangles of each body that intersect the other one, at each pose.

    Args:
        a, b: bodies.
        poses: (N, 4, 4), the poses of b in a's frame.
        threads: how many to use; 0: one for each core.

    Returns:
        `Hits`.
    """
    (a_indptr, a_indices), (b_indptr, b_indices) = _core.hits(a, b, poses, threads=threads)
    return Hits(a_indptr, a_indices, b_indptr, b_indices)


def first_contact(a, b, poses, direction, to, *, start=0.0, threads=1):
    """Find when b, which moves along a straight line from each pose, first touches a.

    The travel is that of all pairs of triangles, exact but for 1 nm.

    Args:
        a, b: bodies.
        poses: (N, 4, 4), where b is at travel 0, in a's frame.
        direction: (3,) or (N, 3), where b moves, in a's frame; of any length but 0.
        to: the last travel (m).
        start: the first travel (m), which may be negative.
        threads: how many to use; 0: one for each core.

    Returns:
        `FirstContact`.
    """
    found = _core.first_contact(a, b, poses, direction, [start, to], threads)
    return FirstContact(*found)


def segments(a, b, pose=None):
    """Find the segments in which the triangles of two bodies cross.

    Args:
        a, b: bodies.
        pose: (4, 4), the pose of b in a's frame; None: they share a frame.

    Returns:
        `Segments`.
    """
    return Segments(*_core.segments(a, b, pose))


def check_policies(files, *, curves=None):
    """Check policies and sets of curves, as ``trolley policy check`` does.

    Args:
        files: paths, or names of policies that ship.
        curves: the path of a set of curves to check policies with; None: those that ship.

    Returns:
        A list of dicts: ``file``, ``kind``, ``name``, ``says`` (what it means, in sentences),
        ``fault`` (what is wrong with it, or None) and ``regressions``.
    """
    return _json.loads(_core.check_policies(list(files), curves=curves))


def assess_many(searched, *, policies=None, curves=None, worlds=None, worlds_seed=0,
                keep_going=False, threads=1):
    """Assess scenes that were searched, under every policy with every set of curves.

    No geometry is needed for that: of the members that a search followed, harm is computed anew.
    Each answer is that of `Session.rank` of the scenario with this policy and these curves, and
    without a deadline, byte for byte.

    Args:
        searched: `Searched` objects, from `Session.search` or `Session.search_many`.
        policies: paths, or names of policies that ship; None: that of each scenario.
        curves: paths of sets of curves; None: those of each scenario.
        worlds: number of worlds to draw where all work is done; 0: none; None: 200.
        worlds_seed: which sequence they are points of.
        keep_going: whether scenes that cannot be assessed are reported in ``Rankings.failures``
            instead of raised.
        threads: how many to use; 0: one for each core.

    Returns:
        `Rankings`: of the first scene, its policies in their order, each with all curves; then of
        the next one. The column ``scene`` of the table is the number of the scene.
    """
    listed = [None if given is None else list(given) for given in (policies, curves)]
    asked = {"policies": listed[0], "curves": listed[1], "worlds": worlds,
             "worlds_seed": worlds_seed}
    return _core.assess_many(list(searched), asked, keep_going, threads)


class Session:
    """Engines that rank scenarios, and keep the bodies that these have in common.

    Loading bodies is most of the work of a single ranking: scenarios that name the same bodies, in
    the same size, share them. Answers do not depend on what is kept, nor on threads.

    A session may be used by several threads, one call after the other. It does not survive a fork.

    Args:
        threads: number of engines, each in a thread of its own.
        cache_mb: how many megabytes of bodies they keep, all together.
    """

    def __init__(self, *, threads=1, cache_mb=512):
        self._core = _core.Session(threads=threads, cache_mb=cache_mb)

    def rank(self, scenario, *, until="complete", members=None, members_max=None,
             deadline_ms=None, explain=False, record=None, worlds=None, worlds_seed=0):
        """Rank a scenario.

        Args:
            scenario: a `Scenario`, or the path of one.
            until: "complete", or "ordered" or "certified" to stop as soon as that is sure.
            members: number of members to draw from what the scenario does not know; None: as the
                scenario says.
            members_max: draw up to so many while the winner is close.
            deadline_ms: stop then, with bounds for what is open (ms).
            explain: keep every figure from contact to rank.
            record: a folder, to which a decision record is added.
            worlds: number of worlds to draw where all work is done; 0: none; None: 200. Only
                members are drawn worlds of.
            worlds_seed: which sequence they are points of.

        Returns:
            `Ranking`. An incomplete answer is no exception: see its ``state``.
        """
        return self._ranked([scenario], None, False, until, members, members_max, deadline_ms,
                            explain, record, worlds, worlds_seed)[0]

    def rank_many(self, scenarios, *, until="complete", members=None, members_max=None,
                  deadline_ms=None, explain=False, record=None, keep_going=False, worlds=None,
                  worlds_seed=0):
        """Rank scenarios, on all engines, and return the rankings in the order of the scenarios.

        Args:
            scenarios: `Scenario` objects or paths.
            keep_going: whether scenarios that cannot be ranked are reported in
                ``Rankings.failures`` instead of raised.

        All else as in `rank`.

        Returns:
            `Rankings`: a sequence, and an Arrow table of candidates.
        """
        return self._ranked(scenarios, None, keep_going, until, members, members_max, deadline_ms,
                            explain, record, worlds, worlds_seed)

    def rank_under(self, scenario, policies, *, until="complete", members=None, members_max=None,
                   explain=False, keep_going=False):
        """Rank a scenario under several policies, in their order.

        Bodies are loaded once; contacts are found anew for each policy. `search` and `assess_many`
        find them once.

        Args:
            scenario: a `Scenario`, or the path of one.
            policies: paths, or names of policies that ship.

        All else as in `rank_many`.

        Returns:
            `Rankings`.
        """
        policies = list(policies)
        return self._ranked([scenario], policies, keep_going, until, members, members_max, None,
                            explain, None, None, 0)

    def search(self, scenario, *, members=None, members_max=None):
        """Search a scenario once for all that any policy and any curves may ask of it.

        As many members are followed as may be drawn at most, as some policy may find its best two
        too close to call: with 32 members that is 128 unless `members_max` says otherwise. A
        deadline that the scenario states does not count.

        Args:
            scenario: a `Scenario`, or the path of one.
            members, members_max: as in `rank`.

        Returns:
            `Searched`, to be assessed under many policies, curves and worlds.
        """
        return self.search_many([scenario], members=members, members_max=members_max)[0]

    def search_many(self, scenarios, *, members=None, members_max=None):
        """Search scenarios, on all engines, and return them in their order.

        Args:
            scenarios: `Scenario` objects or paths.
            members, members_max: as in `rank`.

        Returns:
            A list of `Searched`.
        """
        return self._core.searched(_opened(scenarios), members, members_max)

    def _ranked(self, scenarios, policies, keep_going, until, members, members_max, deadline_ms,
                explain, record, worlds, worlds_seed):
        wanted = {
            "until": until, "members": members, "members_max": members_max,
            "deadline_ms": deadline_ms, "explain": explain, "record": record, "worlds": worlds,
            "worlds_seed": worlds_seed,
        }
        return self._core.ranked(_opened(scenarios), policies, wanted, keep_going)


def _opened(scenarios):
    return [one if isinstance(one, Scenario) else Scenario.open(one) for one in scenarios]
