"""Work in several processes: the same results, one by one as they come, and nothing left behind."""

import json
import os
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from typing import NoReturn

import pytest

from prp_gym import extras
from prp_gym.errors import InvalidValueError, MissingPackageError, UnknownNameError, UnreachableError
from prp_gym.runs.workers import Workers

HOW = [Workers(1), Workers(2)]
needs_ray = pytest.mark.skipif(find_spec("ray") is None, reason="the extra `ray` is not installed")


def square(number: float) -> float:
    return number * number


def process(_: int) -> tuple[int, str]:
    time.sleep(0.01)  # so that one worker alone does not take all
    return os.getpid(), os.environ.get("OMP_NUM_THREADS", "")


def refuse(number: float) -> NoReturn:
    raise UnreachableError((number, 0.0, 0.0), 0.5, ("too far",))


def wait_for(file: Path) -> Path:
    """A file that is there before another item's result was taken, or after it."""
    for _ in range(3000):
        if file.exists():
            return file
        time.sleep(0.01)
    raise TimeoutError(file)


@pytest.mark.parametrize("workers", [*HOW, Workers(0)], ids=str)
def test_every_item_is_done_once_and_known_by_its_index(workers: Workers) -> None:
    items = [0.1 * index for index in range(9)]
    done = list(workers.run(square, items))
    assert sorted(done) == [(index, item * item) for index, item in enumerate(items)]


@pytest.mark.parametrize("workers", HOW, ids=str)
def test_nothing_to_do_is_done_at_once(workers: Workers) -> None:
    assert list(workers.run(square, [])) == []


@pytest.mark.parametrize(("workers", "items"), [(Workers(1), 3), (Workers(2), 1)])
def test_one_job_is_done_in_this_process(workers: Workers, items: int) -> None:
    assert {own for _, (own, _) in workers.run(process, range(items))} == {os.getpid()}


def test_processes_have_one_thread_and_are_gone_in_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "5")
    found = [result for _, result in Workers(2).run(process, range(30))]
    others = {own for own, _ in found}
    assert len(others - {os.getpid()}) == 2
    assert {threads for _, threads in found} == {"1"}
    for own in others:
        with pytest.raises(ProcessLookupError):
            os.kill(own, 0)


def check_results_come_at_once(workers: Workers, folder: Path) -> None:
    """The first item is finished only after the second one's result was taken."""
    late, early = folder / "late", folder / "early"
    early.touch()
    done = workers.run(wait_for, [late, early])
    assert next(done) == (1, early)
    late.touch()
    assert list(done) == [(0, late)]


def test_result_is_there_before_an_earlier_item_is_finished(tmp_path: Path) -> None:
    check_results_come_at_once(Workers(2), tmp_path)


@pytest.mark.parametrize("workers", HOW, ids=str)
def test_results_that_nobody_waits_for_are_given_up_without_a_warning(workers: Workers) -> None:
    done = workers.run(process, range(30))
    next(done)
    done.close()
    assert list(done) == []


@pytest.mark.parametrize("workers", HOW, ids=str)
def test_error_of_a_worker_arrives_as_it_was_raised(workers: Workers) -> None:
    with pytest.raises(UnreachableError) as caught:
        list(workers.run(refuse, [0.25, 0.25]))
    assert str(caught.value) == str(UnreachableError((0.25, 0.0, 0.0), 0.5, ("too far",)))
    assert caught.value.position == (0.25, 0.0, 0.0)


def test_backend_that_does_not_exist_is_refused() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown backend 'lokky'\. Did you mean 'loky'"):
        Workers(2, "lokky")


def test_negative_number_of_jobs_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="jobs is -1; allowed: at least 1, or 0"):
        Workers(-1)


def test_ray_that_is_not_installed_is_told_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda _: None)
    assert Workers(2, "loky").backend == "loky"
    with pytest.raises(MissingPackageError, match=r"ray is not installed; .*pip install 'prp-gym\[ray\]'"):
        Workers(2, "ray")


ON_A_CLUSTER = """
import json, os, socket, sys
from pathlib import Path
from prp_gym.errors import InvalidValueError, UnreachableError
from prp_gym.runs.workers import Workers
from tests.runs.test_workers import check_results_come_at_once, refuse, square

with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    os.environ["RAY_ADDRESS"] = f"127.0.0.1:{free.getsockname()[1]}"
try:
    list(Workers(2, "ray").run(square, [1.0, 2.0]))
except InvalidValueError as error:
    assert error.what == "RAY_ADDRESS", error
else:
    raise SystemExit("a cluster that does not answer was used")
del os.environ["RAY_ADDRESS"]

import ray
messages = []
ray.init(address="local", num_cpus=2, include_dashboard=False, log_to_driver=False, logging_level="ERROR")
items = [0.1 * index for index in range(9)]
assert sorted(Workers(0, "ray").run(square, items)) == list(enumerate(x * x for x in items))
for jobs, kind, function in ((2, UnreachableError, refuse), (3, InvalidValueError, square)):
    try:
        list(Workers(jobs, "ray").run(function, [0.25, 0.25, 0.25]))
    except kind as error:
        messages.append(str(error))
    else:
        raise SystemExit(f"{function} was not refused")
check_results_come_at_once(Workers(2, "ray"), Path(sys.argv[1]))
given_up = Workers(2, "ray").run(square, items)
next(given_up)
given_up.close()
assert ray.is_initialized()
ray.shutdown()
Path(sys.argv[1], "messages.json").write_text(json.dumps(messages))
"""


@needs_ray
def test_cluster_that_was_there_is_used_and_stays_and_its_results_and_errors_arrive(tmp_path: Path) -> None:
    root = str(Path(__file__).resolve().parents[2])  # where the workers, too, find this module
    environment = {name: value for name, value in os.environ.items() if name != "RAY_ADDRESS"}
    environment["PYTHONPATH"] = os.pathsep.join([root, environment.get("PYTHONPATH", "")])
    environment["RAY_USAGE_STATS_ENABLED"] = "0"
    command = [sys.executable, "-W", "error", "-c", ON_A_CLUSTER, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    messages = json.loads((tmp_path / "messages.json").read_text())  # Ray may print of workers that it stops
    assert messages == [
        str(UnreachableError((0.25, 0.0, 0.0), 0.5, ("too far",))),
        "jobs is 3; allowed: at most 2, the CPUs of the Ray cluster.",
    ]
