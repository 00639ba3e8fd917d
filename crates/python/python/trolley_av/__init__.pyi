"""Signatures of the package; `help(trolley_av)` has the documentation."""

from os import PathLike
from typing import Any, Iterable, Iterator, NamedTuple, Protocol, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

BUILD: str

class TrolleyError(Exception):
    what: str
    remedy: str | None
    exit_code: int

class InputError(TrolleyError, ValueError): ...

class _Faces(Protocol):
    @property
    def vertices(self) -> Any: ...
    @property
    def faces(self) -> Any: ...

class _Triangles(Protocol):
    @property
    def vertices(self) -> Any: ...
    @property
    def triangles(self) -> Any: ...

class Body:
    """Triangles with their tree, read-only.

    ``Body(vertices, faces)``: (n, 3) numbers and (m, 3) indices. ``Body(triangles)``: (m, 3, 3)
    corners. ``Body(mesh)``: anything with ``vertices`` and ``faces``, or of Open3D. Arrays may be of
    any float or integer type, strided or read-only; they are copied. Triangles need not be closed
    or connected; one without area counts as the segment or point that it is.
    """

    def __init__(
        self,
        vertices: ArrayLike | _Faces | _Triangles,
        faces: ArrayLike | None = None,
        *,
        leaf_size: int | None = None,
        threads: int = 1,
    ) -> None: ...
    @staticmethod
    def read(
        path: str | PathLike[str], *, leaf_size: int | None = None, threads: int = 1
    ) -> Body: ...
    @staticmethod
    def generate(
        shape: str,
        triangles: int,
        seed: int = 0,
        *,
        leaf_size: int | None = None,
        threads: int = 1,
    ) -> Body: ...
    def __len__(self) -> int: ...
    @property
    def triangles(self) -> NDArray[np.float32]: ...
    @property
    def bounds(self) -> NDArray[np.float32]: ...
    @property
    def rounding(self) -> float: ...

class Scene:
    """Bodies, of which some touch."""

    def __init__(self, bodies: Sequence[Body]) -> None: ...
    def __len__(self) -> int: ...
    def pairs(self, poses: ArrayLike, *, threads: int = 1) -> NDArray[np.int32]: ...

class Hits(NamedTuple):
    a_indptr: NDArray[np.int64]
    a_indices: NDArray[np.int32]
    b_indptr: NDArray[np.int64]
    b_indices: NDArray[np.int32]

class FirstContact(NamedTuple):
    travel: NDArray[np.float64]
    pairs: NDArray[np.int32]
    points: NDArray[np.float64]

class Segments(NamedTuple):
    points: NDArray[np.float64]
    pairs: NDArray[np.int32]
    overlaps: NDArray[np.int32]

def touches(a: Body, b: Body, poses: ArrayLike, *, threads: int = 1) -> NDArray[np.bool_]: ...
def pairs(a: Body, b: Body, pose: ArrayLike | None = None) -> NDArray[np.int32]: ...
def hits(a: Body, b: Body, poses: ArrayLike, *, threads: int = 1) -> Hits: ...
def first_contact(
    a: Body,
    b: Body,
    poses: ArrayLike,
    direction: ArrayLike,
    to: float,
    *,
    start: float = 0.0,
    threads: int = 1,
) -> FirstContact: ...
def segments(a: Body, b: Body, pose: ArrayLike | None = None) -> Segments: ...
def self_pairs(body: Body) -> NDArray[np.int32]: ...
def policy_names() -> list[str]: ...
def from_commonroad(
    scenario: Any,
    planning_problems: Any,
    *,
    ego: str | None = None,
    at_s: float | None = None,
    horizon_s: float | None = None,
) -> Scenario: ...
def plot(ranking: Ranking, axes: Any = None) -> Any: ...
def assess_many(
    searched: Iterable[Searched],
    *,
    policies: Iterable[str | PathLike[str]] | None = None,
    curves: Iterable[str | PathLike[str]] | None = None,
    worlds: int | None = None,
    worlds_seed: int = 0,
    keep_going: bool = False,
    threads: int = 1,
) -> Rankings: ...
def check_policies(
    files: Iterable[str | PathLike[str]], *, curves: str | PathLike[str] | None = None
) -> list[dict[str, Any]]: ...

class Scenario:
    """A scene with its candidates, its policy and its curves, read-only."""

    @staticmethod
    def open(
        path: str | PathLike[str],
        *,
        allow_outside: bool = False,
        ego: str | None = None,
        at_s: float | None = None,
        horizon_s: float | None = None,
    ) -> Scenario: ...
    @staticmethod
    def parse(text: str, *, name: str = "scenario.toml", allow_outside: bool = False) -> Scenario: ...
    @staticmethod
    def from_dict(
        scenario: dict[str, Any], *, name: str = "scenario.toml", allow_outside: bool = False
    ) -> Scenario: ...
    def with_policy(self, policy: str | PathLike[str]) -> Scenario: ...
    def with_curves(self, curves: str | PathLike[str]) -> Scenario: ...
    def assuming_unknown_is_fixed(self) -> Scenario: ...
    @property
    def name(self) -> str: ...
    @property
    def file(self) -> str: ...
    @property
    def text(self) -> str: ...
    @property
    def policy(self) -> str: ...
    @property
    def candidates(self) -> list[str]: ...
    @property
    def parties(self) -> list[str]: ...

class Ranking:
    """A scenario, ranked."""

    @property
    def scenario(self) -> str: ...
    @property
    def policy(self) -> str: ...
    @property
    def state(self) -> str: ...
    @property
    def best(self) -> str | None: ...
    @property
    def answer(self) -> dict[str, Any]: ...
    @property
    def json(self) -> bytes: ...
    @property
    def explanation(self) -> dict[str, Any] | None: ...
    @property
    def run(self) -> dict[str, Any] | None: ...
    @property
    def curves(self) -> str: ...
    @property
    def record(self) -> PathLike[str] | None: ...

class Rankings:
    """Scenarios, ranked, in their order: a sequence, and an Arrow table of candidates."""

    def __len__(self) -> int: ...
    def __getitem__(self, index: int) -> Ranking: ...
    def __iter__(self) -> Iterator[Ranking]: ...
    @property
    def failures(self) -> list[tuple[int, str]]: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

class Searched:
    """A scene, searched: whom every candidate meets, where and how, whatever the policy."""

    @property
    def scenario(self) -> str: ...
    @property
    def candidates(self) -> list[str]: ...
    def assess(
        self,
        *,
        policy: str | PathLike[str] | None = None,
        curves: str | PathLike[str] | None = None,
        worlds: int | None = None,
        worlds_seed: int = 0,
    ) -> Ranking: ...

class Session:
    def __init__(self, *, threads: int = 1, cache_mb: int = 512) -> None: ...
    def rank(
        self,
        scenario: Scenario | str | PathLike[str],
        *,
        until: str = "complete",
        members: int | None = None,
        members_max: int | None = None,
        deadline_ms: float | None = None,
        explain: bool = False,
        record: str | PathLike[str] | None = None,
        worlds: int | None = None,
        worlds_seed: int = 0,
    ) -> Ranking: ...
    def rank_many(
        self,
        scenarios: Iterable[Scenario | str | PathLike[str]],
        *,
        until: str = "complete",
        members: int | None = None,
        members_max: int | None = None,
        deadline_ms: float | None = None,
        explain: bool = False,
        record: str | PathLike[str] | None = None,
        keep_going: bool = False,
        worlds: int | None = None,
        worlds_seed: int = 0,
    ) -> Rankings: ...
    def rank_under(
        self,
        scenario: Scenario | str | PathLike[str],
        policies: Iterable[str | PathLike[str]],
        *,
        until: str = "complete",
        members: int | None = None,
        members_max: int | None = None,
        explain: bool = False,
        keep_going: bool = False,
    ) -> Rankings: ...
    def search(
        self,
        scenario: Scenario | str | PathLike[str],
        *,
        members: int | None = None,
        members_max: int | None = None,
    ) -> Searched: ...
    def search_many(
        self,
        scenarios: Iterable[Scenario | str | PathLike[str]],
        *,
        members: int | None = None,
        members_max: int | None = None,
    ) -> list[Searched]: ...
