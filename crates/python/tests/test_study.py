"""Shards of a study are run by one function, and have the same rows whoever calls it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import trolley_av as ta
from trolley_av import study

SPEC = """\
schema = "trolley.study/1"
name = "two speeds"
members = 1
policies = ["default", "worst-off-first"]
scenes_per_shard = 2
[[scenarios]]
files = ["scene.toml"]
[sweep.speed]
values = [0.5, 0.8, 0.9, 1.0, 1.2]
"""


@pytest.fixture()
def planned(config, tmp_path):
    """Returns a function that plans the study in a new folder."""
    (tmp_path / "scene.toml").write_text((config / "scenarios/wall-or-pole.toml").read_text())
    (tmp_path / "spec.toml").write_text(SPEC)

    def folder(name):
        told = study.plan(tmp_path / "spec.toml", tmp_path / name)
        assert (told["shards"], told["scenes"], told["finished"]) == (3, 5, 0)
        return tmp_path / name

    return folder


def run(*arguments):
    command = [sys.executable, "-m", "trolley_av.study", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_every_way_to_run_shards_gives_the_same_rows(planned):
    one = planned("one")
    done = [study.run_shard(one, shard) for shard in range(3)]
    assert [shard["rows"][0] for shard in done] == [4, 4, 2]
    assert not any(shard["was_finished"] or shard["refused"] for shard in done)
    assert study.run_shard(one, 1) == {**done[1], "was_finished": True}
    expected = study.status(one)
    assert (expected["finished"], expected["attempts"]) == (3, 3)
    assert expected["rows_hash"]

    whole, shared = planned("whole"), planned("shared")
    assert run(whole).returncode == 0
    for index in range(2):
        assert run(shared, "--shard", index, "--of", 2).returncode == 0
    for folder in (whole, shared):
        assert study.status(folder)["rows_hash"] == expected["rows_hash"]
    again = run(whole)
    assert again.returncode == 0 and study.status(whole)["attempts"] == 3


def test_a_row_is_the_ranking_of_its_scene(planned, config):
    parquet = pytest.importorskip("pyarrow.parquet")
    folder = planned("rows")
    study.run_shard(folder, 1)
    rows = parquet.read_table(folder / "shards/000001/answers.parquet").to_pylist()
    given = [row for row in rows if row["speed"] == 1.0]
    scenario = ta.Scenario.open(config / "scenarios/wall-or-pole.toml")
    rankings = ta.Session().rank_under(scenario, ["default", "worst-off-first"], members=1)
    assert [row["winner"] for row in given] == [ranking.best for ranking in rankings]
    assert [row["work_hi"] for row in given] == [
        ranking.answer["ranking"][0]["work"][1] for ranking in rankings]


def test_what_is_damaged_is_named_and_ranked_again(planned):
    folder = planned("damaged")
    assert run(folder).returncode == 0
    rows_hash = study.status(folder)["rows_hash"]
    file = folder / "shards/000002/answers.parquet"
    flipped = bytearray(file.read_bytes())
    flipped[100] ^= 1
    file.write_bytes(flipped)
    named = study.check(folder, redo=False)
    assert [broken["shard"] for broken in named["broken"]] == [2] and named["sound"] == 2
    assert study.check(folder)["broken"][0]["is_redone"]
    assert study.check(folder)["sound"] == 3 and study.status(folder)["rows_hash"] == rows_hash


def test_a_store_holds_the_same_study(planned, tmp_path):
    pytest.importorskip("fsspec")
    expected = planned("local")
    for shard in range(3):
        study.run_shard(expected, shard)
    rows_hash = study.status(expected)["rows_hash"]
    url = f"file://{tmp_path}/store"
    told = study.plan(tmp_path / "spec.toml", url)
    assert (told["shards"], told["finished"]) == (3, 0)
    assert run(url, "--shard", 1).returncode == 0
    assert study.run_shard(url, 1)["was_finished"]
    assert study.status(url)["finished"] == 1
    again = study.plan(tmp_path / "spec.toml", url)
    assert again["finished"] == 1, "it is there already"
    assert run(url).returncode == 0
    assert study.status(url)["rows_hash"] == rows_hash
    # Without its seal, a shard does not count; damaged ones are ranked again and put back.
    (tmp_path / "store/shards/000000/seal.json").unlink()
    file = tmp_path / "store/shards/000002/persons.parquet"
    file.write_bytes(file.read_bytes()[:-1])
    assert [broken["shard"] for broken in study.check(url, redo=False)["broken"]] == [0, 2]
    assert not study.run_shard(url, 2)["was_finished"]
    study.check(url)
    assert study.check(url)["sound"] == 3 and study.status(url)["rows_hash"] == rows_hash
    with pytest.raises(ta.InputError, match="holds no study"):
        study.status(f"file://{tmp_path}/nothing")


def test_what_is_asked_wrongly_is_refused_with_words(planned, tmp_path):
    folder = planned("refused")
    with pytest.raises(ta.TrolleyError):
        study.run_shard(folder, 3)
    with pytest.raises(ta.TrolleyError):
        study.status(tmp_path / "no-such-study")
    wrong = run(folder, "--shard", 3)
    assert wrong.returncode == 64 and "shards 0 to 2" in wrong.stderr
    assert run(folder, "--of", 3).returncode == 2
    assert "Traceback" not in run(tmp_path / "no-such-study").stderr


def test_ray_is_asked_for_with_a_remedy_where_it_is_missing(planned):
    try:
        import ray  # noqa: F401
    except ImportError:
        found = run(planned("ray"), "--ray", "127.0.0.1:1")
        assert found.returncode == 78 and "trolley-av[ray]" in found.stderr


def test_recipes_name_what_there_is():
    recipes = Path(__file__).resolve().parents[3] / "tools/study"
    slurm = (recipes / "slurm.sh").read_text()
    environment = {**os.environ, "SLURM_ARRAY_TASK_ID": "0", "SLURM_ARRAY_TASK_COUNT": "2",
                   "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    assert "--shard" in slurm
    said = subprocess.run(["sh", str(recipes / "slurm.sh"), "no-such-study"], env=environment,
                          capture_output=True, text=True, check=False)
    assert said.returncode not in (0, 2) and "no-such-study" in said.stderr
