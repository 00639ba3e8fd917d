"""Rankings are those of the program, byte for byte, whatever is kept and by however many engines."""

import json
import multiprocessing
import os
import pickle

import numpy as np
import pytest

import trolley_av as ta

SCENARIOS = ["scenarios/small.toml", "scenarios/crossing.toml", "scenarios/minimal.toml",
             "examples/crash.toml", "examples/crossing.xml", "scenarios/wall-or-pole.toml"]

CRASH = {
    "schema": "trolley.scenario/2",
    "name": "Pole or pedestrian",
    "parties": {
        "ego": {"generate": {"shape": "sedan", "triangles": np.int64(1500)}},
        "pole": {
            "generate": {"shape": "pole", "triangles": 600},
            "place": {"position_m": np.array([12, -1.5, 0])},
        },
        "pedestrian": {
            "generate": {"shape": "pedestrian", "triangles": 800},
            "state": {"position_m": [12, -1, 0], "yaw_deg": 90, "speed_m_s": 1},
        },
    },
    "candidates": [
        {"name": "straight on", "state": {"position_m": [0, 0, 0], "speed_m_s": 9}},
        {"name": "swerve", "state": {"position_m": [0, 0, 0], "velocity_m_s": [9, -1.2]}},
    ],
}


def test_answers_are_those_of_the_program(config, program):
    paths = [config / name for name in SCENARIOS]
    expected = [program(path) for path in paths]
    for threads in (1, 2):
        session = ta.Session(threads=threads)
        for _ in range(2):
            rankings = session.rank_many(paths)
            assert [ranking.json for ranking in rankings] == expected


def test_answers_with_members_are_those_of_the_program(config, program):
    path = config / "scenarios/small.toml"
    expected = program(path, "--members", "8")
    assert ta.Session().rank(path, members=8).json == expected


def test_a_cache_without_room_changes_no_answer(config):
    paths = [config / name for name in SCENARIOS]
    kept, bare = ta.Session(cache_mb=64), ta.Session(cache_mb=0)
    assert [one.json for one in kept.rank_many(paths + paths)] == [
        one.json for one in bare.rank_many(paths + paths)
    ]


def test_a_dict_is_a_scenario():
    scenario = ta.Scenario.from_dict(CRASH)
    assert scenario.candidates == ["straight on", "swerve"]
    assert sorted(scenario.parties) == ["ego", "pedestrian", "pole"]
    ranking = ta.Session().rank(scenario)
    assert (ranking.best, ranking.state, ranking.policy) == ("swerve", "complete", "default")
    assert ranking.answer == json.loads(ranking.json)
    assert [row["name"] for row in ranking.answer["ranking"]] == ["swerve", "straight on"]
    assert ranking.explanation is None and ranking.record is None
    assert ranking.run["workers"] == []
    again = ta.Scenario.parse(scenario.text)
    assert ta.Session().rank(again).json == ranking.json


@pytest.mark.parametrize("change, says", [
    ({"schema": 3}, "schema"),
    ({"name": None}, "remedy: a scenario has strings"),
    ({"horizon_s": float("nan")}, "nan is not finite"),
    ({2: 1}, "the key 2 is no string"),
    ({"candidates": object()}, "object has no place in a scenario"),
    ({"no_such_key": 1}, "no_such_key"),
])
def test_what_is_no_scenario_is_refused(change, says):
    with pytest.raises(ta.InputError, match=says):
        ta.Scenario.from_dict({**CRASH, **change})


def test_refusals_name_place_and_remedy(config):
    with pytest.raises(ta.InputError, match="crash.toml:1:10") as caught:
        ta.Scenario.parse("schema = 3", name="crash.toml")
    assert caught.value.remedy and caught.value.exit_code == 65
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.remedy) == (str(caught.value), caught.value.remedy)
    with pytest.raises(ta.InputError, match="no-such-file"):
        ta.Session().rank("no-such-file.toml")
    small = config / "scenarios/small.toml"
    with pytest.raises(ta.InputError, match='until: "soon"'):
        ta.Session().rank(small, until="soon")
    with pytest.raises(ta.InputError, match="deadline-ms is -1"):
        ta.Session().rank(small, deadline_ms=-1)
    with pytest.raises(ta.InputError, match="recorded traffic"):
        ta.Scenario.open(small, at_s=1.0)
    with pytest.raises(ta.InputError, match="no policy of the name"):
        ta.Session().rank_under(small, ["no-such-policy"])
    with pytest.raises(ta.InputError, match="threads: 0 is not 1 to 64"):
        ta.Session(threads=0)


def test_one_that_cannot_be_ranked_may_stay_behind():
    unknown = json.loads(json.dumps(CRASH, default=lambda value: value.tolist()))
    unknown["parties"]["pole"]["kind"] = "unknown"
    scenarios = [ta.Scenario.from_dict(one) for one in (CRASH, unknown, CRASH)]
    session = ta.Session(threads=2)
    with pytest.raises(ta.InputError, match=r"scenarios\[1\].*unknown kind"):
        session.rank_many(scenarios)
    rankings = session.rank_many(scenarios, keep_going=True)
    assert [number for number, _ in rankings.failures] == [1]
    assert rankings[0].json == rankings[2].json == rankings[-1].json
    with pytest.raises(ta.InputError):
        rankings[1]
    with pytest.raises(IndexError):
        rankings[3]
    fixed = scenarios[1].assuming_unknown_is_fixed()
    assert session.rank(fixed).answer["assumptions"]


def test_a_scenario_is_ranked_under_every_policy(config):
    scenario = ta.Scenario.open(config / "scenarios/small.toml")
    names = ta.policy_names()
    assert "worst-off-first" in names and len(names) == 9
    session = ta.Session(threads=2)
    rankings = session.rank_under(scenario, names)
    assert [ranking.policy for ranking in rankings] == names
    for name, ranking in zip(names, rankings):
        assert session.rank(scenario.with_policy(name)).json == ranking.json
    path = config / "policies/weighted.toml"
    assert session.rank_under(scenario, [path])[0].policy == "weighted"


def test_an_assessment_is_a_fresh_ranking(config, tmp_path):
    paths = [config / name for name in SCENARIOS]
    shipped = (config / "curves/default.toml").read_text()
    own = shipped.replace('name = "default"', 'name = "own"').replace("a = -6.9774", "a = -5.5")
    assert own != shipped
    (tmp_path / "own.toml").write_text(own)
    curves = [config / "curves/default.toml", tmp_path / "own.toml"]
    names = ta.policy_names()
    session = ta.Session(threads=2)
    scenarios = [ta.Scenario.open(path) for path in paths]
    searched = session.search_many(scenarios, members=1)
    assessed = ta.assess_many(searched, policies=names, curves=curves, threads=2)
    fresh = [scenario.with_policy(name).with_curves(set_of_curves) for scenario in scenarios
             for name in names for set_of_curves in curves]
    ranked = session.rank_many(fresh, members=1)
    assert [one.json for one in assessed] == [one.json for one in ranked]
    assert [one.curves for one in assessed] == [one.curves for one in ranked]
    assert all(one.run is None and one.explanation is None for one in assessed)
    uncovered = config / "curves/levels.toml"
    with pytest.raises(ta.InputError, match=r"assessments\[0\].*no curve for cyclist"):
        ta.assess_many(searched, curves=[uncovered])
    assert len(ta.assess_many(searched, curves=[uncovered], keep_going=True).failures) >= 1
    one = searched[0].assess(policy="worst-off-first", curves=curves[1])
    assert one.json == session.rank(
        scenarios[0].with_policy("worst-off-first").with_curves(curves[1]), members=1).json


def test_members_and_worlds_are_assessed_as_they_are_ranked(config):
    scenario = ta.Scenario.open(config / "scenarios/crossing.toml")
    session = ta.Session()
    searched = session.search(scenario, members=3, members_max=6)
    for name in ta.policy_names():
        for worlds, seed in ((None, 0), (0, 0), (20, 5)):
            asked = {"worlds": worlds, "worlds_seed": seed}
            ranked = session.rank(scenario.with_policy(name), members=3, members_max=6, **asked)
            assert searched.assess(policy=name, **asked).json == ranked.json
    with pytest.raises(ta.InputError, match="worlds"):
        searched.assess(worlds=-1)
    with pytest.raises(ta.InputError, match="another|no policy"):
        searched.assess(policy="no-such-policy")
    with pytest.raises(ta.InputError, match="record"):
        session.rank(scenario, members=3, worlds=5, record="records")


def test_assessments_are_a_table(config):
    arrow = pytest.importorskip("pyarrow")
    session = ta.Session()
    searched = session.search_many([config / "scenarios/small.toml", ta.Scenario.from_dict(CRASH)],
                                   members=1)
    rows = arrow.table(ta.assess_many(searched, policies=["default", "ego-only"])).to_pylist()
    listed = [(row["scene"], row["policy"], row["curves"]) for row in rows if row["place"] == 1]
    assert listed == [(0, "default", "default"), (0, "ego-only", "default"),
                      (1, "default", "default"), (1, "ego-only", "default")]
    assert arrow.table(ta.assess_many([])).num_rows == 0


def test_rankings_are_a_table(config):
    arrow = pytest.importorskip("pyarrow")
    session = ta.Session()
    rankings = session.rank_many([config / "scenarios/small.toml", ta.Scenario.from_dict(CRASH)])
    table = arrow.table(rankings)
    assert table.num_rows == 6
    rows = table.to_pylist()
    listed = [(row["scene"], row["place"], row["candidate"]) for row in rows]
    expected = [(scene, place, row["name"]) for scene, ranking in enumerate(rankings)
                for place, row in enumerate(ranking.answer["ranking"], 1)]
    assert listed == expected
    answers = [row for ranking in rankings for row in ranking.answer["ranking"]]
    for row, answer in zip(rows, answers):
        assert [row["work_lo"], row["work_hi"]] == answer["work"]
        assert row["contacts"] == len(answer["contacts"]) and row["why"] == answer["why"]
        first = answer["contacts"][0] if answer["contacts"] else None
        assert row["first_party"] == (first and first["party"])
        assert row["first_contact_s"] == (first and first["time_s"])
        assert row["is_best"] == (row["place"] == 1)
    assert arrow.table(rankings).equals(table), "it can be read again"
    assert arrow.table(session.rank_many([])).num_rows == 0


def test_explained_and_recorded(config, tmp_path):
    session = ta.Session()
    path = config / "scenarios/small.toml"
    ranking = session.rank(path, explain=True)
    assert set(ranking.explanation["names"]) == set(ta.Scenario.open(path).candidates)
    recorded = session.rank(path, record=tmp_path / "records")
    assert os.path.exists(recorded.record) and recorded.json == ranking.json
    assert session.rank(path, record=tmp_path / "records").record != recorded.record


def test_a_deadline_leaves_bounds(config):
    ranking = ta.Session().rank(config / "scenarios/small.toml", deadline_ms=0.01)
    assert ranking.state in ("degraded", "refused", "certified", "complete")
    assert len(ranking.answer["ranking"]) == 4


def test_policies_are_checked(config, tmp_path):
    wrong = tmp_path / "wrong.toml"
    wrong.write_text("schema = 3\n")
    good, bad = ta.check_policies([config / "policies/weighted.toml", wrong])
    assert good["fault"] is None and good["name"] == "weighted" and good["says"]
    assert "wrong.toml" in bad["fault"]


def _rank_in_child(session, pipe):
    try:
        session.rank(ta.Scenario.from_dict(CRASH))
        pipe.send("ranked")
    except ta.TrolleyError as error:
        pipe.send(str(error))


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_session_does_not_survive_a_fork_and_says_so():
    session = ta.Session()
    session.rank(ta.Scenario.from_dict(CRASH))
    ours, theirs = multiprocessing.Pipe()
    context = multiprocessing.get_context("fork")
    child = context.Process(target=_rank_in_child, args=(session, theirs))
    child.start()
    assert ours.poll(20)
    assert "does not survive a fork" in ours.recv()
    child.join(20)


def test_every_name_has_a_signature_and_documentation():
    stub = os.path.join(os.path.dirname(ta.__file__), "__init__.pyi")
    text = open(stub, encoding="utf-8").read()
    for name in ta.__all__:
        assert getattr(ta, name).__doc__, name
        assert f"class {name}" in text or f"def {name}" in text or f"{name}: " in text, name
    assert os.path.exists(os.path.join(os.path.dirname(ta.__file__), "py.typed"))
    for owner in (ta.Body, ta.Scene, ta.Scenario, ta.Ranking, ta.Rankings, ta.Searched, ta.Session):
        for name in dir(owner):
            assert name.startswith("_") or f"def {name}(" in text, f"{owner.__name__}.{name}"
            assert name.startswith("_") or getattr(owner, name).__doc__, f"{owner.__name__}.{name}"


def test_commonroad_in_memory_is_that_of_its_file(config, tmp_path):
    reader = pytest.importorskip("commonroad.common.file_reader")
    text = (config / "examples/crossing.xml").read_text()
    # commonroad-io reads no file without these.
    place = "<geoNameId>-999</geoNameId><gpsLatitude>999</gpsLatitude>"
    place += "<gpsLongitude>999</gpsLongitude>"
    at = text.index("<staticObstacle")
    head = f"<location>{place}</location><scenarioTags><urban/></scenarioTags>"
    tagged = tmp_path / "tagged.xml"
    tagged.write_text(text[:at] + head + text[at:])
    scenario, problems = reader.CommonRoadFileReader(str(tagged)).open()
    made = ta.from_commonroad(scenario, problems)
    stated = ta.Scenario.open(tagged)
    assert made.candidates == stated.candidates and made.parties == stated.parties
    session = ta.Session()
    ranked = [session.rank(one, members=1).answer["ranking"] for one in (made, stated)]
    assert ranked[0] == ranked[1]


def test_a_ranking_is_drawn_in_its_order(config):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    ranking = ta.Session().rank(config / "scenarios/small.toml", members=1)
    axes = ta.plot(ranking)
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names == [row["name"] for row in ranking.answer["ranking"]]
    ends = [patch.get_x() + patch.get_width() for patch in axes.patches]
    highs = [100 * row["range"][1] for row in ranking.answer["ranking"]]
    assert ends == pytest.approx(highs)
    assert ta.plot(ranking, axes) is axes
