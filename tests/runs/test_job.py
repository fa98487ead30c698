"""Jobs: which there are, and what running one gives."""

import json
import pickle
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import gymnasium
import pytest

from prp_gym import list_envs
from prp_gym.artifacts import list_versions
from prp_gym.baselines import BASELINES, list_baselines, make_baseline
from prp_gym.errors import InvalidValueError, MissingFieldError, UnknownNameError
from prp_gym.evaluation import evaluate
from prp_gym.runs import code
from prp_gym.runs.choice import ControllerChoice, GainsChoice
from prp_gym.runs.code import running_code, source_digest
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.evaluation_job import EvaluationJob, list_jobs
from prp_gym.runs.job import JobResult, run_job
from prp_gym.tasks.spec import TASKS

REPORT = ("PRP-JointTracking-v0", "report")
RANDOMIZED = ("PRP-JointTracking-v0", "randomized")
REGISTERED = Controllers()
SLOW = ControllerChoice("joint_pd", gains=GainsChoice("tuned_50hz"))
JOB = EvaluationJob(*RANDOMIZED, SLOW, 50.0, 2, 7)


def test_job_gives_what_the_evaluator_gives() -> None:
    env = gymnasium.make(JOB.environment_id, scenario="randomized", control_frequency=50.0)
    expected = evaluate(make_baseline("joint_pd", env, "tuned_50hz"), env, episodes=2, seed=7)
    env.close()
    record = run_job(REGISTERED, JOB).record
    assert record["score"] == expected.score._asdict()
    assert record["seeds"] == [7, 8]
    assert record["episodes"]["energy"] == expected.metrics["energy"].tolist()
    assert record["revisions"] == {"task": TASKS[JOB.environment_id].revision, "controller": 1}
    assert (record["settings"]["gains"], record["control_period"]) == ("tuned_50hz", 0.02)


def test_record_is_strict_json_to_the_last_bit() -> None:
    record = run_job(REGISTERED, JOB).record
    assert json.loads(json.dumps(record, allow_nan=False)) == record


def test_job_and_its_record_survive_the_way_between_processes() -> None:
    assert pickle.loads(pickle.dumps(JOB)) == JOB
    result = run_job(REGISTERED, JOB)
    assert pickle.loads(pickle.dumps(result)) == result


def test_jobs_are_the_controllers_that_can_run_in_the_order_of_the_conditions() -> None:
    conditions = [(environment_id, "randomized") for environment_id in reversed(list_envs())]
    choices = [ControllerChoice(name) for name in BASELINES]
    jobs = list_jobs(conditions, choices, REGISTERED, 500.0, 3, 4)
    expected = []
    for environment_id, scenario in conditions:
        env = gymnasium.make(environment_id)
        controllers = list_baselines(env.get_wrapper_attr("observation_layout"))
        env.close()
        expected += [
            EvaluationJob(environment_id, scenario, ControllerChoice(controller), 500.0, 3, 4)
            for controller in controllers
        ]
    assert jobs == expected
    assert len({job.name for job in jobs}) == len(jobs)


def test_deterministic_scenario_is_run_once() -> None:
    jobs = list_jobs([REPORT, RANDOMIZED], [ControllerChoice("joint_pd")], REGISTERED, 500.0, 5, 0)
    assert [job.episodes for job in jobs] == [1, 5]


def test_gains_that_cannot_be_used_are_refused_before_anything_is_run() -> None:
    with pytest.raises(InvalidValueError, match="control_frequency is 50"):
        list_jobs([REPORT], [ControllerChoice("joint_pd")], REGISTERED, 50.0, 1, 0)
    with pytest.raises(UnknownNameError, match="unknown gain set of controller 'joint_pd'"):
        list_jobs([REPORT], [replace(SLOW, gains=GainsChoice("nothing"))], REGISTERED, 500.0, 1, 0)


def test_controller_that_lacks_what_it_reads_is_refused() -> None:
    with pytest.raises(MissingFieldError, match="'impedance'"):
        run_job(REGISTERED, replace(JOB, controller=ControllerChoice("impedance")))


def test_code_that_made_a_record_stands_beside_it() -> None:
    result = run_job(REGISTERED, JOB)
    assert result.code == running_code() == {**list_versions(), "sources": source_digest()}
    result.check_code()


@pytest.mark.parametrize("change", [{"sources": "0" * 64}, {"numpy": "1.0"}, {"more": "1.0"}], ids=str)
def test_record_of_other_code_is_refused_with_what_differs(change: dict[str, str]) -> None:
    running = running_code()
    own = {name: running.get(name) for name in change}
    with pytest.raises(InvalidValueError) as caught:
        JobResult({}, running | change, "node7").check_code()
    assert (caught.value.what, caught.value.value) == ("code of a worker on node7", change)
    assert caught.value.allowed == f"that of this process, which is {own}"
    with pytest.raises(InvalidValueError, match=r"on node7 is .'numpy': None.; allowed"):
        JobResult(
            {}, {name: version for name, version in running.items() if name != "numpy"}, "node7"
        ).check_code()


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of a module, a data file and something else, as the one whose digest is taken."""
    (tmp_path / "inner").mkdir()
    for name in ("__init__.py", "inner/data.toml", "notes.txt"):
        (tmp_path / name).write_text("x = 1")
    made = SimpleNamespace(__name__="package", __file__=str(tmp_path / "__init__.py"))
    monkeypatch.setattr(code, "_SOURCES", (made,))
    return tmp_path


@pytest.mark.parametrize("name", ["__init__.py", "inner/data.toml", "new.py", "inner/loop.c", "world.h"])
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


def test_digest_covers_every_package_that_a_result_depends_on() -> None:
    folders = {Path(source.__file__ or "").resolve().parent for source in code._SOURCES}
    assert {folder.name for folder in folders} == {"prp_gym", "envs", "baselines", "agents"}
