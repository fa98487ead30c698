"""A task that another package declares is evaluated and compared, and left out of the audit."""

import json
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import pytest
from typer.testing import CliRunner

from prp_gym import list_agents, register_task
from prp_gym.cli.main import app
from prp_gym.tasks.presets import learning_id
from prp_gym.tasks.spec import TASKS, TaskScoring

ID = "Test-NewTask-v0"
RUNNER = CliRunner()


@pytest.fixture(autouse=True)
def new_task(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A joint-space task without a physical error and without agents, of revision 4; short episodes."""
    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=0.1))
    register_task(replace(TASKS["PRP-JointTracking-v0"], id=ID, scoring=TaskScoring(("energy",)), revision=4))
    yield
    TASKS.unregister(ID)
    del gymnasium.registry[ID], gymnasium.registry[learning_id(ID)]


def run(command: str, folder: Path, *options: str) -> tuple[dict[str, Any], str]:
    common = ("--env", ID, "--episodes", "2", "--jobs", "1", "--output", str(folder))
    result = RUNNER.invoke(app, [command, *common, *options])
    assert result.exit_code == 0, result.output
    return json.loads((folder / "results.json").read_text(encoding="utf-8")), result.stdout


def test_new_task_is_compared_without_agents(tmp_path: Path) -> None:
    assert list_agents(ID) == []
    content, output = run("compare", tmp_path, "--scenario", "randomized")
    kinds = {row["kind"] for row in content["evaluations"]}
    assert kinds == {"controller", "floor"}
    assert content["pairwise_comparisons"] == content["efforts"] == []
    assert {row["revisions"]["task"] for row in content["evaluations"]} == {4}
    assert f"{ID}, scenario randomized" in output
    assert not (tmp_path / "learning.png").exists()


def test_new_task_is_compared_with_one_controller_alone(unwritten_figures: None, tmp_path: Path) -> None:
    content, _ = run("compare", tmp_path, "--scenario", "report", "--baseline", "adaptive")
    assert [row["policy"] for row in content["evaluations"]] == ["adaptive", "zero_torque", "hold"]


def test_new_task_without_criteria_is_run_but_left_out_of_the_audit(tmp_path: Path) -> None:
    content, _ = run("audit", tmp_path, "--scenario", "randomized")
    assert {row["kind"] for row in content["evaluations"]} == {"controller", "varied"}
    assert {row["environment"] for row in content["evaluations"]} == {ID}
    assert content["audits"] == []


def test_new_task_is_evaluated_with_its_columns_and_revision(tmp_path: Path) -> None:
    content, output = run("evaluate", tmp_path, "--scenario", "randomized", "--baseline", "joint_pd")
    (row,) = (row for row in content["evaluations"] if not row.get("floor"))
    assert (row["environment"], row["revisions"]) == (ID, {"task": 4, "controller": 1})
    assert "energy" in output
    assert "RMSE" not in output


def test_new_task_is_listed() -> None:
    assert ID in RUNNER.invoke(app, ["list"]).stdout.split()
