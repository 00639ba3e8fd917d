from collections.abc import Callable
from os import PathLike
from typing import Any

def plan(spec: str | PathLike[str], folder: str | PathLike[str]) -> dict[str, Any]: ...
def run_shard(folder: str | PathLike[str], shard: int) -> dict[str, Any]: ...
def status(folder: str | PathLike[str]) -> dict[str, Any]: ...
def check(
    folder: str | PathLike[str], *, redo: bool = True, ranked_every: int | None = None
) -> dict[str, Any]: ...
def run_on_ray(
    folder: str | PathLike[str],
    address: str,
    *,
    tries: int = 20,
    told: Callable[[dict[str, Any]], None] | None = None,
) -> dict[int, str]: ...
