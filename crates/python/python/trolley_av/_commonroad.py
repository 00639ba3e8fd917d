"""Scenarios of objects of commonroad-io."""

import pathlib as _pathlib
import tempfile as _tempfile
import warnings as _warnings

from ._core import Scenario
from ._errors import InputError

# Decimals that keep a coordinate of a map, of up to 10⁷ m, as a float64 has it.
_DECIMALS = 15


def from_commonroad(scenario, planning_problems, *, ego=None, at_s=None, horizon_s=None):
    """Make a scenario of a CommonRoad scenario that is in memory, as of its file.

    Args:
        scenario: a `commonroad.scenario.scenario.Scenario`.
        planning_problems: its `commonroad.planning.planning_problem.PlanningProblemSet`.
        ego: the name of the ego; None: the one of the planning problem.
        at_s: when the manoeuvres begin (s); None: 1 s before it meets somebody.
        horizon_s: how far manoeuvres go (s).

    Returns:
        `Scenario`.
    """
    try:
        from commonroad.common.file_writer import CommonRoadFileWriter, OverwriteExistingFile
        from commonroad.common.util import FileFormat
    except ImportError as error:
        raise InputError(
            f"scenario: commonroad-io cannot be imported: {error}",
            "install it (pip install commonroad-io), or open the file: Scenario.open(path)",
            78,
        ) from error
    writer = CommonRoadFileWriter(
        scenario, planning_problems, author="", affiliation="", source="", tags=set(),
        decimal_precision=_DECIMALS, file_format=FileFormat.XML,
    )
    with _tempfile.TemporaryDirectory() as folder:
        path = _pathlib.Path(folder) / f"{scenario.scenario_id}.xml"
        with _warnings.catch_warnings():
            # Lanelets without a type are none of its business.
            _warnings.simplefilter("ignore")
            writer.write_to_file(str(path), OverwriteExistingFile.ALWAYS)
        return Scenario.open(path, ego=ego, at_s=at_s, horizon_s=horizon_s)
