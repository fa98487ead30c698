"""Files of finished jobs: reused by the code that made them alone, and never when damaged."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, NoReturn

import pytest

from prp_gym.runs import store
from prp_gym.runs.choice import ControllerChoice, GainsChoice
from prp_gym.runs.code import running_code
from prp_gym.runs.evaluation_job import EvaluationJob
from prp_gym.runs.store import JobStore

SLOW = GainsChoice("tuned_50hz")
CONTROLLER = ControllerChoice("joint_pd", gains=SLOW)
JOB = EvaluationJob("PRP-JointTracking-v0", "randomized", CONTROLLER, 50.0, 2, 7)
OTHER = replace(JOB, controller=ControllerChoice("adaptive", gains=SLOW))
RECORD = {"score": {"value": 1 / 3, "low": 0.1, "high": 0.5}, "median": {"settling_time": ["inf", None]}}


def only_file(folder: Path) -> Path:
    (path,) = folder.iterdir()
    return path


def test_kept_record_is_found_again_as_it_was(tmp_path: Path) -> None:
    JobStore(tmp_path / "jobs").keep(JOB, RECORD)
    assert JobStore(tmp_path / "jobs").find([JOB, OTHER]) == ({JOB: RECORD}, [])
    assert only_file(tmp_path / "jobs").name == "PRP-JointTracking-v0_randomized_joint_pd.json"


def test_nothing_is_found_where_nothing_is(tmp_path: Path) -> None:
    assert JobStore(tmp_path / "jobs").find([JOB]) == ({}, [])
    assert list(tmp_path.iterdir()) == []


CHANGES: list[dict[str, Any]] = [
    {"controller": replace(CONTROLLER, gains=GainsChoice("report"))},
    {"controller": replace(CONTROLLER, gains=replace(SLOW, settings=(("stiffness", "200"),)))},
    {"controller": replace(CONTROLLER, gains=replace(SLOW, toml="stiffness = 200"))},
    {"control_frequency": 100.0},
    {"episodes": 3},
    {"seed": 8},
    {"engine": "compiled"},
]


@pytest.mark.parametrize("change", CHANGES, ids=str)
def test_record_of_other_settings_is_not_reused(tmp_path: Path, change: dict[str, Any]) -> None:
    finished = JobStore(tmp_path)
    finished.keep(JOB, RECORD)
    assert finished.find([replace(JOB, **change)]) == ({}, [only_file(tmp_path)])


def test_record_that_was_kept_before_there_were_engines_is_mujocos(tmp_path: Path) -> None:
    finished = JobStore(tmp_path)
    finished.keep(JOB, RECORD)
    job = json.loads(only_file(tmp_path).read_text())["key"]["job"]
    assert set(job) == {field.name for field in fields(JOB)} - {"engine"}
    assert finished.find([JOB]) == ({JOB: RECORD}, [])


OTHERS = [OTHER, replace(JOB, scenario="report"), replace(JOB, environment_id="PRP-Adaptive-v0")]


@pytest.mark.parametrize("other", OTHERS, ids=str)
def test_file_under_another_jobs_name_is_not_reused(tmp_path: Path, other: EvaluationJob) -> None:
    finished = JobStore(tmp_path)
    finished.keep(other, RECORD)
    path = only_file(tmp_path).rename(tmp_path / f"{JOB.name}.json")
    assert finished.find([JOB]) == ({}, [path])


@pytest.mark.parametrize("change", [{"sources": "0" * 64}, {"numpy": "1"}], ids=str)
def test_record_of_other_code_or_versions_is_not_reused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: dict[str, str]
) -> None:
    finished = JobStore(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(store, "running_code", lambda: running_code() | change)
        finished.keep(JOB, RECORD)
        assert finished.find([JOB]) == ({JOB: RECORD}, [])
    assert finished.find([JOB]) == ({}, [only_file(tmp_path)])


def other_number(text: bytes) -> bytes:
    content = json.loads(text)
    content["record"]["score"]["low"] = 0.2
    return json.dumps(content).encode()


def without_record(text: bytes) -> bytes:
    return json.dumps({"key": json.loads(text)["key"]}).encode()


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda _: b"",
    "truncated": lambda text: text[: len(text) // 2],
    "number": other_number,
    "no record": without_record,
    "not a mapping": lambda _: b"[1, 2]",
    "number alone": lambda _: b"3",
    "not text": lambda _: b"\xff\xfe\x00\x01",
    "endless": lambda _: b"[" * 100_000,
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_or_foreign_file_is_not_reused(tmp_path: Path, damage: str) -> None:
    finished = JobStore(tmp_path)
    finished.keep(JOB, RECORD)
    path = only_file(tmp_path)
    path.write_bytes(DAMAGES[damage](path.read_bytes()))
    assert finished.find([JOB]) == ({}, [path])
    finished.keep(JOB, RECORD)
    assert finished.find([JOB]) == ({JOB: RECORD}, [])


def test_folder_in_the_place_of_a_file_is_not_reused(tmp_path: Path) -> None:
    occupied = tmp_path / f"{JOB.name}.json"
    occupied.mkdir()
    assert JobStore(tmp_path).find([JOB]) == ({}, [occupied])


def half_written(folder: Path, process: int) -> Path:
    """What a process leaves of the first job's file when it is killed as it writes."""
    path = folder / f".{JOB.name}.json.{process}.part"
    path.write_text("{")
    return path


def dead_process() -> int:
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


@pytest.mark.parametrize("process", [dead_process, os.getpid], ids=["dead", "own"])
def test_files_are_removed_with_what_a_kill_left_half_written(
    tmp_path: Path, process: Callable[[], int]
) -> None:
    finished = JobStore(tmp_path / "jobs")
    for job in (JOB, OTHER):
        finished.keep(job, RECORD)
    half_written(tmp_path / "jobs", process())
    finished.remove([JOB])
    assert only_file(tmp_path / "jobs").stem == OTHER.name
    finished.remove([JOB, OTHER])
    assert list(tmp_path.iterdir()) == []


def test_what_another_run_is_writing_stays(tmp_path: Path) -> None:
    part = half_written(tmp_path, os.getppid())
    JobStore(tmp_path).remove([JOB])
    assert only_file(tmp_path) == part


def test_what_somebody_elses_process_is_writing_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def forbid(process: int, signal: int) -> NoReturn:
        raise PermissionError(process, signal)

    part = half_written(tmp_path, os.getppid())
    monkeypatch.setattr(os, "kill", forbid)
    JobStore(tmp_path).remove([JOB])
    assert only_file(tmp_path) == part


def test_file_that_another_run_removes_at_the_same_time_is_no_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def take(path: Path) -> bool:
        path.unlink()
        return True

    finished = JobStore(tmp_path / "jobs")
    finished.keep(JOB, RECORD)
    monkeypatch.setattr(Path, "is_file", take)
    finished.remove([JOB])
    monkeypatch.undo()
    finished.remove([JOB])  # the folder, too, is gone
    assert list(tmp_path.iterdir()) == []


def test_what_is_somebody_elses_stays(tmp_path: Path) -> None:
    finished = JobStore(tmp_path / "jobs")
    finished.keep(JOB, RECORD)
    mine = tmp_path / "jobs" / "mine.json"
    mine.write_text("mine")
    finished.remove([JOB])
    assert only_file(tmp_path / "jobs") == mine
