"""`make learn-check`: what it trains, what it stores, and what the documentation shows of it."""

import json
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from bench import learn_check
from bench.learn_check import STEPS, Training, goal_text
from docs import learning_page
from prp_gym.errors import UnknownNameError
from prp_gym.tasks.spec import TASKS

TASK = "PRP-Adaptive-v0"


def row(task: str, algorithm: str, after: float, zero: float = 0.1) -> dict[str, Any]:
    numbers = {"steps": STEPS[algorithm], "revision": TASKS[task].revision, "seconds": 1.0}
    scores = {"zero_torque": zero, "before": 0.05, "after": after}
    return {"task": task, "algorithm": algorithm, **numbers, **scores}


def test_training_scores_both_policies_and_zero_torque(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(learn_check, "_EPISODES", 1)
    found = Training(TASK, "SAC", 105).run()
    assert (found["task"], found["algorithm"], found["steps"]) == (TASK, "SAC", 105)
    assert all(0.0 < found[name] < 1.0 for name in ("zero_torque", "before", "after"))
    assert found["before"] != found["zero_torque"]


def test_results_of_this_revision_are_kept_and_the_others_trained(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    results = tmp_path / "results.json"
    trained: list[tuple[str, str]] = []
    monkeypatch.setattr(learn_check, "RESULTS", results)

    def run(training: Training) -> dict[str, Any]:
        trained.append((training.task_id, training.algorithm))
        return row(training.task_id, training.algorithm, 0.3)

    monkeypatch.setattr(Training, "run", run)
    old = {**row(TASK, "SAC", 0.9), "revision": 0}
    results.write_text(json.dumps({"runs": [old, row("PRP-Force-v0", "PPO", 0.25)]}), encoding="utf-8")
    app = typer.Typer()
    app.command()(learn_check.check)
    given = [TASK, "PRP-Force-v0", "--resume", "--jobs", "1"]
    outcome = CliRunner().invoke(app, given)
    assert outcome.exit_code == 0, outcome.output
    assert trained == [(TASK, "PPO"), (TASK, "SAC"), ("PRP-Force-v0", "SAC")]
    stored = {(run["task"], run["algorithm"]): run["after"] for run in learn_check.read_results()["runs"]}
    assert stored["PRP-Force-v0", "PPO"] == 0.25
    assert stored[TASK, "SAC"] == 0.3
    assert "at least 0.15 above zero torque on 2 of 2 tasks" in " ".join(outcome.output.split())
    refused = CliRunner().invoke(app, ["PRP-Forse-v0"])
    assert isinstance(refused.exception, UnknownNameError)


def test_goals_count_the_tasks_that_reach_them() -> None:
    rows = [row(TASK, "PPO", 0.41), row("PRP-Force-v0", "PPO", 0.3), row("PRP-Impedance-v0", "PPO", 0.11)]
    first, second = goal_text([*rows, row("PRP-Force-v0", "SAC", 0.9)])
    assert "0.3 above zero torque on 1 of 3 tasks" in first
    assert "0.15 above zero torque on 2 of 3 tasks" in second


def test_page_shows_every_result_and_the_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    runs = [row(TASK, "PPO", 0.41), row("PRP-Force-v0", "PPO", 0.05), row(TASK, "SAC", 0.2)]
    monkeypatch.setattr(learning_page, "read_results", lambda: {"runs": runs})
    page = learning_page.learning_page()
    assert "| PRP-Adaptive-v0 | 0.100 | 0.050 | 0.410 | +0.310 | 0.050 | 0.200 | +0.100 |" in page
    assert "| PRP-Force-v0 | 0.100 | 0.050 | 0.050 | -0.050 | - | - | - |" in page
    assert page.startswith("# Learned agents")
