"""`prp-gym evaluate` in parallel and in several goes: always the results of one go in one process."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Generator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import pytest
from typer.testing import CliRunner

from prp_gym.cli.main import app
from prp_gym.errors import EpisodeError, InvalidValueError
from prp_gym.runs import code, run
from prp_gym.runs.choice import ControllerChoice, GainsChoice
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.evaluation_job import EvaluationJob, list_jobs
from prp_gym.runs.floor_job import FloorJob, list_floors
from prp_gym.runs.job import JobResult, Record, run_job
from prp_gym.runs.store import JobStore
from prp_gym.runs.workers import Workers
from tests.runs.test_workers import needs_ray

RUNNER = CliRunner()
IDS = ("PRP-JointTracking-v0", "PRP-Adaptive-v0")
CONTROLLERS = ("joint_pd", "adaptive")
SCENARIOS = ("randomized", "report")
AT_50_HZ = ("--gains", "tuned_50hz", "--control-frequency", "50")
REGISTERED = Controllers()


def options_for(ids: Sequence[str]) -> list[str]:
    """Options of an evaluation on some environments."""
    return [
        *(item for environment_id in ids for item in ("--env", environment_id)),
        *(item for controller in CONTROLLERS for item in ("--baseline", controller)),
        *(item for scenario in SCENARIOS for item in ("--scenario", scenario)),
        *(*AT_50_HZ, "--episodes", "2", "--seed", "5"),
    ]


def jobs_for(ids: Sequence[str]) -> list[EvaluationJob | FloorJob]:
    """The jobs of an evaluation on some environments, in their order."""
    conditions = [(environment_id, scenario) for environment_id in ids for scenario in SCENARIOS]
    choices = [ControllerChoice(name, gains=GainsChoice("tuned_50hz")) for name in CONTROLLERS]
    return [
        *list_jobs(conditions, choices, REGISTERED, 50.0, 2, 5),
        *list_floors(conditions, 50.0, 2, 5),
    ]


OPTIONS, JOBS = options_for(IDS), jobs_for(IDS)
OPTIONS_OF_ONE, JOBS_OF_ONE = options_for(IDS[1:]), jobs_for(IDS[1:])
"""An evaluation on one environment, for tests whose processes cannot be given shorter episodes."""


def outcome(folder: Path) -> list[dict[str, Any]]:
    """All results but the measured times; nothing else is left in the folder."""
    assert [entry.name for entry in folder.iterdir()] == ["results.json"]
    content = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    rows: list[dict[str, Any]] = content["evaluations"]
    return [{name: value for name, value in row.items() if name != "compute_time_per_step"} for row in rows]


def run_here(folder: Path, *more: str, options: Sequence[str] = OPTIONS) -> tuple[str, str]:
    """Standard output and error of an evaluation in this process."""
    result = RUNNER.invoke(app, ["evaluate", "--jobs", "1", "--output", str(folder), *options, *more])
    assert result.exit_code == 0, result.output
    return result.stdout, " ".join(result.stderr.split())


def command(folder: Path, *more: str) -> list[str]:
    start = [sys.executable, "-W", "error", "-m", "prp_gym.cli.main", "evaluate"]
    return [*start, "--output", str(folder), *OPTIONS_OF_ONE, *more]


@pytest.fixture(scope="module")
def expected_of_one(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    """Results on one environment, of one go in one process."""
    folder = tmp_path_factory.mktemp("one")
    run_here(folder, options=OPTIONS_OF_ONE)
    return outcome(folder)


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Episodes of ten steps, in this process alone."""
    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=0.2))


@pytest.fixture(scope="module")
def expected_of_short(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    """Results on all environments with episodes of ten steps, of one go."""
    folder = tmp_path_factory.mktemp("whole")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gymnasium, "make", partial(gymnasium.make, duration=0.2))
        run_here(folder)
    return outcome(folder)


@pytest.fixture
def expected(short: None, expected_of_short: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Results of one go; episodes have ten steps from here on."""
    return expected_of_short


@pytest.mark.parametrize("backend", ["loky", pytest.param("ray", marks=needs_ray)])
def test_results_of_two_workers_are_those_of_one_process(
    tmp_path: Path, expected_of_one: list[dict[str, Any]], backend: str
) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "RAY_ADDRESS"}
    options = ("--jobs", "2", "--backend", backend, "--quiet")
    done = subprocess.run(command(tmp_path, *options), capture_output=True, text=True, env=environment)
    assert (done.returncode, done.stderr.strip()) == (0, "")
    assert outcome(tmp_path) == expected_of_one


def test_results_are_in_the_order_of_the_options(expected: list[dict[str, Any]]) -> None:
    assert [
        (row["environment"], row["scenario"], row["baseline"]) for row in expected if not row.get("floor")
    ] == [
        (environment_id, scenario, controller)
        for environment_id in IDS
        for scenario in SCENARIOS
        for controller in CONTROLLERS
    ]


def test_run_that_was_killed_goes_on_where_it_stopped(
    tmp_path: Path, expected_of_one: list[dict[str, Any]]
) -> None:
    process = subprocess.Popen(
        command(tmp_path, "--jobs", "2"), start_new_session=True, stdout=subprocess.DEVNULL
    )
    for _ in range(60_000):
        if list(tmp_path.glob("jobs/[!.]*.json")):
            break
        time.sleep(0.001)
    os.killpg(process.pid, signal.SIGKILL)  # its workers, too, so that none outlives the test
    assert process.wait() == -signal.SIGKILL
    left = {path.stem: path.read_bytes() for path in tmp_path.glob("jobs/[!.]*.json")}
    assert 1 <= len(left) < len(JOBS_OF_ONE)
    assert not (tmp_path / "results.json").exists()
    _, error = run_here(tmp_path, options=OPTIONS_OF_ONE)
    assert error.startswith(f"{len(left)} of {len(JOBS_OF_ONE)} jobs were finished by an interrupted run")
    content = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    for job, row in zip(JOBS_OF_ONE, content["evaluations"], strict=True):
        if job.name in left:  # measured times included, so it was not run again
            assert row == json.loads(left[job.name])["record"]
    assert outcome(tmp_path) == expected_of_one


def marked(time_of_an_action: float) -> Record:
    """The record of the first job with a time that cannot have been measured."""
    return {**run_job(REGISTERED, JOBS[0]).record, "compute_time_per_step": time_of_an_action}


def first_time(folder: Path) -> float:
    content = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return float(content["evaluations"][0]["compute_time_per_step"])


def test_finished_job_is_reused_and_the_next_run_is_a_whole_one(
    tmp_path: Path, expected: list[dict[str, Any]]
) -> None:
    JobStore(tmp_path / "jobs").keep(JOBS[0], marked(123e-6))
    output, error = run_here(tmp_path)
    assert error.startswith(f"1 of {len(JOBS)} jobs were finished by an interrupted run and are reused.")
    assert re.search(r"^ joint_pd .* 123 $", output, re.MULTILINE)
    assert first_time(tmp_path) == 123e-6
    assert outcome(tmp_path) == expected
    _, error = run_here(tmp_path)
    assert error == ""
    assert first_time(tmp_path) != 123e-6


def test_fresh_run_reuses_nothing(tmp_path: Path, expected: list[dict[str, Any]]) -> None:
    JobStore(tmp_path / "jobs").keep(JOBS[0], marked(123e-6))
    _, error = run_here(tmp_path, "--fresh")
    assert error == ""
    assert first_time(tmp_path) != 123e-6
    assert outcome(tmp_path) == expected


def test_damaged_and_foreign_files_are_told_and_their_jobs_run_again(
    tmp_path: Path, expected: list[dict[str, Any]]
) -> None:
    finished = JobStore(tmp_path / "jobs")
    finished.keep(JOBS[0], marked(123e-6))
    (tmp_path / "jobs" / f"{JOBS[1].name}.json").write_text('{"key": {"pa')
    (tmp_path / "jobs" / f"{JOBS[2].name}.json").write_text('{"evaluations": []}')
    _, error = run_here(tmp_path)
    assert error.startswith(f"1 of {len(JOBS)} jobs")
    assert error.endswith("Not reused, as damaged or of other settings or code: 2.")
    assert outcome(tmp_path) == expected


def test_changed_settings_reuse_nothing(short: None, tmp_path: Path) -> None:
    JobStore(tmp_path / "jobs").keep(JOBS[0], marked(123e-6))
    _, error = run_here(tmp_path, "--seed", "6")
    assert error.startswith(f"0 of {len(JOBS)} jobs")
    assert [row["seeds"][0] for row in outcome(tmp_path)] == [6] * len(JOBS)


@pytest.mark.parametrize(
    "stop", [EpisodeError("step before reset"), KeyboardInterrupt()], ids=["error", "interrupt"]
)
def test_what_was_finished_before_a_failure_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, expected: list[dict[str, Any]], stop: BaseException
) -> None:
    finished: list[EvaluationJob] = []

    def run_two(controllers: Controllers, job: EvaluationJob) -> JobResult:
        if len(finished) == 2:
            raise stop
        finished.append(job)
        return run_job(controllers, job)

    with monkeypatch.context() as patch:
        patch.setattr(run, "run_job", run_two)
        result = RUNNER.invoke(app, ["evaluate", "--jobs", "1", "--output", str(tmp_path), *OPTIONS])
    assert result.exit_code != 0
    assert {path.stem for path in (tmp_path / "jobs").iterdir()} == {job.name for job in finished}
    assert len(finished) == 2
    _, error = run_here(tmp_path)
    assert error.startswith(f"2 of {len(JOBS)} jobs")
    assert outcome(tmp_path) == expected


@pytest.mark.parametrize(
    ("name", "value"), [("source_digest", "0"), ("list_versions", {"numpy": "1"})], ids=["code", "versions"]
)
def test_workers_of_other_code_are_refused_and_nothing_of_theirs_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, value: Any
) -> None:
    monkeypatch.setattr(code, name, lambda: value)  # here alone: workers import their own
    result = RUNNER.invoke(app, ["evaluate", "--jobs", "2", "--output", str(tmp_path), *OPTIONS_OF_ONE])
    assert isinstance(result.exception, InvalidValueError)
    assert str(result.exception).startswith("code of a worker on ")
    assert list(tmp_path.glob("**/*.json")) == []


def in_this_process(
    _: Workers, function: Callable[[Any], Any], items: Sequence[Any]
) -> Generator[tuple[int, Any], None, None]:
    """What `Workers.run` gives, whatever the number of workers."""
    yield from ((index, function(item)) for index, item in enumerate(items))


@pytest.mark.parametrize(("jobs", "told"), [(0, True), (1, False), (2, True)])
def test_times_measured_on_a_busy_machine_are_told_to_be_so(
    short: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, jobs: int, told: bool
) -> None:
    monkeypatch.setattr(Workers, "run", in_this_process)
    options = ["--env", IDS[1], "--baseline", CONTROLLERS[0], "--scenario", "report", "--jobs", str(jobs)]
    result = RUNNER.invoke(app, ["evaluate", "--output", str(tmp_path), *options, *AT_50_HZ])
    assert result.exit_code == 0, result.output
    assert ("compute time: measured beside other work" in result.stdout) == told
