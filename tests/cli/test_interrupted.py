"""Commands that are interrupted, or find another command in their folder."""

import itertools
import os
import re
import signal
import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import pytest
from typer.testing import CliRunner

from prp_gym.agents.training.checkpoint import write_checkpoint
from prp_gym.agents.training.run_folder import RunFolder
from prp_gym.cli.main import app, main
from prp_gym.errors import FolderInUseError
from prp_gym.processes.folder_lock import FolderLock
from prp_gym.runs.store import JobStore
from prp_gym.tuning.stored_study import StoredStudy

ENVIRONMENT, CONTROLLER = "PRP-Adaptive-v0", "joint_pd"
TUNED = f"{ENVIRONMENT}_{CONTROLLER}"
TRAINED = Path(ENVIRONMENT, "ppo_torque", "seed_1")
WRITE = "prp_gym.agents.training.progress.write_checkpoint"
EVALUATE = (
    *("evaluate", "--env", ENVIRONMENT, "--baseline", CONTROLLER, "--baseline", "adaptive"),
    *("--scenario", "randomized", "--episodes", "1", "--jobs", "1"),
)
TRAIN = (
    *("train", ENVIRONMENT, "--seeds", "2", "--jobs", "1", "--eval-every", "128", "--eval-episodes", "1"),
    *("--set", "n_timesteps=512", "--set", "n_envs=4", "--set", "n_steps=32", "--set", "batch_size=64"),
    *("--set", "env_kwargs.control_frequency=50", "--set", "env_kwargs.duration=1", "--no-tensorboard"),
    *("--action-mode", "torque"),
)
TUNE = ("tune", CONTROLLER, "--env", ENVIRONMENT, "--budget", "20000", "--episodes", "1")
COMPARE = ("compare", *EVALUATE[1:])
REPRODUCE = ("reproduce", "--figure", "12")


@pytest.mark.parametrize(
    ("command", "folder"),
    [(EVALUATE, ""), (COMPARE, ""), (TUNE, TUNED), (TRAIN, TRAINED), (REPRODUCE, "")],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_second_command_in_a_folder_is_refused_and_changes_nothing(
    tmp_path: Path, command: tuple[str, ...], folder: str
) -> None:
    with ExitStack() as stack:
        if command is TRAIN:
            stack.enter_context(RunFolder(tmp_path / folder).reserve())
        else:
            stack.enter_context(FolderLock(tmp_path / folder).hold())
        before = sorted(tmp_path.rglob("*"))
        result = CliRunner().invoke(app, [*command, "--output", str(tmp_path)])
        assert isinstance(result.exception, FolderInUseError), result.output
        assert f"is in use by process {os.getpid()} on " in str(result.exception)
        assert "--fresh" not in str(result.exception)
        assert sorted(tmp_path.rglob("*")) == before


def then_signal(function: Callable[..., Any], number: signal.Signals, calls: int = 1) -> Callable[..., Any]:
    """A function of which some calls succeed, after the last of which this process gets a signal."""
    count = itertools.count(1)

    def call(*arguments: Any, **keywords: Any) -> Any:
        result = function(*arguments, **keywords)
        if next(count) == calls:
            os.kill(os.getpid(), number)
        return result

    return call


def run_until_exit(command: tuple[str, ...], folder: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setattr(sys, "argv", ["prp-gym", *command, "--output", str(folder)])
    with pytest.raises(SystemExit) as ended:
        main()
    return ended.value.code


def test_interrupted_evaluation_says_how_many_jobs_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(JobStore, "keep", then_signal(JobStore.keep, signal.SIGTERM))
        assert run_until_exit(EVALUATE, tmp_path, monkeypatch) == 143
    told = " ".join(capsys.readouterr().err.split())
    assert "interrupted: 1 of 4 jobs are kept in" in told  # two controllers, two floors
    assert "the same command goes on from there" in told
    assert [path.name for path in tmp_path.iterdir()] == ["jobs"]
    again = CliRunner().invoke(app, [*EVALUATE, "--output", str(tmp_path)])
    assert again.exit_code == 0, again.output
    assert [path.name for path in tmp_path.iterdir()] == ["results.json"]


def test_interrupted_training_says_at_which_step_it_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)  # `nohup` makes its processes ignore it
    with monkeypatch.context() as patch:
        patch.setattr(WRITE, then_signal(write_checkpoint, signal.SIGHUP))
        assert run_until_exit(TRAIN, tmp_path, monkeypatch) == 129
    signal.signal(signal.SIGHUP, before)
    told = " ".join(capsys.readouterr().err.split())
    assert "PRP-Adaptive-v0 ppo_torque seed 0 is kept at step 128" in told
    assert "the same command without --fresh goes on" in told
    assert not list(tmp_path.rglob(".*lock"))
    assert [path.name for path in (tmp_path / TRAINED).parent.iterdir()] == ["seed_0"]


def test_interrupted_search_says_how_many_steps_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(StoredStudy, "record", then_signal(StoredStudy.record, signal.SIGTERM))
        assert run_until_exit(TUNE, tmp_path, monkeypatch) == 143
    told = " ".join(capsys.readouterr().err.split())
    assert "interrupted: 5000 steps of the budget are kept in" in told
    assert "the same command goes on there" in told
    assert [path.name for path in (tmp_path / TUNED).iterdir()] == ["study.log"]


AUDIT = ("audit", "--env", ENVIRONMENT, "--episodes", "1", "--draws", "1", "--jobs", "1")
TUNE_ALL = ("tune-all", "-e", ENVIRONMENT, "-b", CONTROLLER, "--budget", "60000", "--jobs", "1")


@pytest.mark.parametrize(
    ("command", "function", "kept"),
    [
        (COMPARE, "prp_gym.runs.store.JobStore.keep", r"1 of \d+ jobs are kept in"),
        (AUDIT, "prp_gym.runs.store.JobStore.keep", r"1 of \d+ jobs are kept in"),
        (
            TUNE_ALL,
            "prp_gym.tuning.stored_study.StoredStudy.record",
            r"\d+ steps of the budget are kept in .*; the searches are kept in .*; the same command goes on",
        ),
        (
            (*REPRODUCE, "--figure", "13"),
            "prp_gym.cli.reproduce.judge",
            "1 of 2 figures are kept in .*; the same command starts over",
        ),
        (REPRODUCE, "prp_gym.cli.reproduce.record_run", "nothing new had to be kept"),
    ],
    ids=["compare", "audit", "tune-all", "reproduce", "reproduce-before-a-figure"],
)
def test_interrupted_command_says_what_is_kept(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: tuple[str, ...],
    function: str,
    kept: str,
) -> None:
    calls = 2 if "figures" in kept else 1
    with monkeypatch.context() as patch:
        patch.setattr(function, then_signal(resolve_name(function), signal.SIGTERM, calls))
        assert run_until_exit(command, tmp_path, monkeypatch) == 143
    told = " ".join(capsys.readouterr().err.split())
    assert re.search(f"interrupted: .*{kept}", told)
