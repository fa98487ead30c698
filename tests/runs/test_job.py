"""Pairs: which there are, and what playing one gives."""

import json
import pickle
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import gymnasium
import pytest

from prp_gym import list_envs
from prp_gym.baselines import BASELINES, list_baselines, make_baseline
from prp_gym.errors import InvalidValueError, MissingFieldError, UnknownNameError
from prp_gym.evaluation import evaluate
from prp_gym.evaluation.results import list_versions
from prp_gym.runs import job as pairs
from prp_gym.runs.job import EvaluationJob, JobResult, list_jobs, run_job, running_code, source_digest

REPORT = ("PRP-JointTracking-v0", "report")
RANDOMIZED = ("PRP-JointTracking-v0", "randomized")
PAIR = EvaluationJob(*RANDOMIZED, "joint_pd", "tuned_50hz", 50.0, 2, 7)


def test_pair_is_played_as_the_evaluator_plays_it() -> None:
    env = gymnasium.make(PAIR.environment_id, scenario="randomized", control_frequency=50.0)
    expected = evaluate(make_baseline("joint_pd", env, "tuned_50hz"), env, episodes=2, seed=7)
    env.close()
    record = run_job(PAIR).record
    assert record["score"] == expected.score._asdict()
    assert record["seeds"] == [7, 8]
    assert record["episodes"]["energy"] == expected.metrics["energy"].tolist()
    assert (record["settings"]["gains"], record["control_period"]) == ("tuned_50hz", 0.02)


def test_record_is_strict_json_to_the_last_bit() -> None:
    record = run_job(PAIR).record
    assert json.loads(json.dumps(record, allow_nan=False)) == record


def test_pair_and_its_record_survive_the_way_between_processes() -> None:
    assert pickle.loads(pickle.dumps(PAIR)) == PAIR
    played = run_job(PAIR)
    assert pickle.loads(pickle.dumps(played)) == played


def test_pairs_are_the_laws_that_can_run_in_the_order_of_the_places() -> None:
    conditions = [(environment_id, "randomized") for environment_id in reversed(list_envs())]
    pairs = list_jobs(conditions, list(BASELINES), "tuned", 500.0, 3, 4)
    expected = []
    for environment_id, scenario in conditions:
        env = gymnasium.make(environment_id)
        controllers = list_baselines(env.get_wrapper_attr("observation_layout"))
        env.close()
        expected += [
            EvaluationJob(environment_id, scenario, controller, "tuned", 500.0, 3, 4)
            for controller in controllers
        ]
    assert pairs == expected
    assert len({pair.name for pair in pairs}) == len(pairs)


def test_deterministic_scenario_is_played_once() -> None:
    pairs = list_jobs([REPORT, RANDOMIZED], ["joint_pd"], "tuned", 500.0, 5, 0)
    assert [pair.episodes for pair in pairs] == [1, 5]


def test_gains_that_cannot_be_used_are_refused_before_anything_is_played() -> None:
    with pytest.raises(InvalidValueError, match="control_frequency is 50"):
        list_jobs([REPORT], ["joint_pd"], "tuned", 50.0, 1, 0)
    with pytest.raises(UnknownNameError, match="unknown gain set of controller 'joint_pd'"):
        list_jobs([REPORT], ["joint_pd"], "nothing", 500.0, 1, 0)


def test_law_that_lacks_what_it_reads_is_refused_where_it_is_played() -> None:
    with pytest.raises(MissingFieldError, match="controller 'impedance'"):
        run_job(replace(PAIR, controller="impedance"))


def test_code_that_played_is_told_with_the_record() -> None:
    played = run_job(PAIR)
    assert played.code == running_code() == {**list_versions(), "sources": source_digest()}
    played.check_code()


@pytest.mark.parametrize("change", [{"sources": "0" * 64}, {"numpy": "1.0"}, {"more": "1.0"}], ids=str)
def test_record_of_other_code_is_refused_with_what_differs(change: dict[str, str]) -> None:
    code = running_code()
    own = {name: code.get(name) for name in change}
    with pytest.raises(InvalidValueError) as caught:
        JobResult({}, code | change, "node7").check_code()
    assert (caught.value.what, caught.value.value) == ("code of a worker on node7", change)
    assert caught.value.allowed == f"that of this process, which is {own}"
    with pytest.raises(InvalidValueError, match=r"on node7 is .'numpy': None.; allowed"):
        JobResult(
            {}, {name: version for name, version in code.items() if name != "numpy"}, "node7"
        ).check_code()


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of a module, a data file and something else, as the one whose digest is taken."""
    (tmp_path / "inner").mkdir()
    for name in ("__init__.py", "inner/data.toml", "notes.txt"):
        (tmp_path / name).write_text("x = 1")
    made = SimpleNamespace(__name__="package", __file__=str(tmp_path / "__init__.py"))
    monkeypatch.setattr(pairs, "_SOURCES", (made,))
    return tmp_path


@pytest.mark.parametrize("name", ["__init__.py", "inner/data.toml", "new.py"])
def test_digest_changes_with_code_and_data(package: Path, name: str) -> None:
    before = source_digest.__wrapped__()
    assert source_digest.__wrapped__() == before
    (package / name).write_text("x = 2")
    assert source_digest.__wrapped__() != before


def test_digest_changes_with_a_files_name_and_not_with_other_files(package: Path) -> None:
    before = source_digest.__wrapped__()
    (package / "notes.txt").write_text("y")
    assert source_digest.__wrapped__() == before
    (package / "inner" / "data.toml").rename(package / "inner" / "other.toml")
    assert source_digest.__wrapped__() != before


def test_digest_is_over_every_part_that_a_result_depends_on() -> None:
    folders = {Path(source.__file__ or "").resolve().parent for source in pairs._SOURCES}
    assert {folder.name for folder in folders} == {"prp_gym", "envs", "baselines", "agents"}
