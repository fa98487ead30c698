"""The example package: installed beside the suite, it is found by every command."""

import itertools
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.support.compiler import needs_compiler

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "examples" / "prp_gym_sliding_mode"
TASK, CONTROLLER = "Example-JointRoundTrip-v0", "sliding_mode"
STEPS = 2500  # of an episode of 5 s at 500 Hz
MODULE = "prp_gym_sliding_mode"


def run(program: list[str], folder: Path, *paths: Path) -> str:
    """Standard output of a program that finds modules in some folders."""
    path = os.pathsep.join(str(item) for item in (*paths, ROOT))
    environment = {**os.environ, "PYTHONPATH": path, "COLUMNS": "160"}
    done = subprocess.run(
        [sys.executable, *program], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder into which the package is installed, from a copy that the build may write to."""
    folder = tmp_path_factory.mktemp("example")
    source = shutil.copytree(PACKAGE, folder / "source", ignore=shutil.ignore_patterns("build", "*.egg-info"))
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check"]
    run(["-m", "pip", "install", *options, "--target", str(folder / "site"), str(source)], folder)
    return folder / "site"


def command(installed: Path, folder: Path, *options: str) -> str:
    return run(["-m", "prp_gym.cli.main", *options], folder, installed)


def results(folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return content


def test_list_shows_its_task_and_its_controller(installed: Path, tmp_path: Path) -> None:
    words = command(installed, tmp_path, "list").split()
    assert {TASK, CONTROLLER} <= set(words)
    lines = [line.split() for line in command(installed, tmp_path, "list", "--matrix").splitlines()]
    rows = {line[0]: line[1:] for line in lines if {"yes", "-"} & set(line)}
    assert rows["Example-JointRoundTrip"][-1] == "yes"  # the last column is that of the last controller
    assert rows["Force"][-1] == "yes"  # its reference is a pose, whose inverse kinematics are used
    assert rows["Adaptive"][-1] == "yes"


def test_without_installation_it_is_loaded_by_name() -> None:
    listed = run(["-m", "prp_gym.cli.main", "list", "--plugin", MODULE], PACKAGE / "src")
    assert {TASK, CONTROLLER} <= set(listed.split())


def test_evaluate_runs_both_in_worker_processes(installed: Path, tmp_path: Path) -> None:
    options = (
        "--env",
        TASK,
        "--env",
        "PRP-JointTracking-v0",
        "--scenario",
        "report",
        "--jobs",
        "2",
        "--output",
        "results",
    )
    names = ("--baseline", CONTROLLER, "--baseline", "joint_pd")
    command(installed, tmp_path, "evaluate", *options, *names)
    every = results(tmp_path / "results")["evaluations"]
    rows = [row for row in every if not row.get("floor")]
    floors = {(row["environment"], row["baseline"]) for row in every if row.get("floor")}
    assert floors == set(itertools.product((TASK, "PRP-JointTracking-v0"), ("zero_torque", "hold")))
    found = {(row["environment"], row["baseline"]): row["score"]["value"] for row in rows}
    assert len(found) == 4
    for environment_id in (TASK, "PRP-JointTracking-v0"):
        assert found[environment_id, "joint_pd"] < found[environment_id, CONTROLLER] < 1.0
    assert found[TASK, CONTROLLER] > 0.98
    revisions = {row["environment"]: row["revisions"] for row in rows}
    assert revisions == {
        TASK: {"task": 1, "controller": 1},
        "PRP-JointTracking-v0": {"task": 2, "controller": 1},
    }
    (settings,) = (row["settings"] for row in rows[:1])
    assert settings["slope"] == [20.0, 20.0, 20.0]


def test_controller_runs_on_the_single_link_too(installed: Path, tmp_path: Path) -> None:
    options = ("--env", "PRP-Adaptive-v0", "--scenario", "report", "--jobs", "1", "--baseline", CONTROLLER)
    command(installed, tmp_path, "evaluate", *options, "--output", "results")
    row, *floors = results(tmp_path / "results")["evaluations"]
    assert [floor["baseline"] for floor in floors] == ["zero_torque", "hold"]
    assert row["settings"]["reaching_gain"] == [60.0]
    assert row["score"]["value"] > 0.9


def test_compare_needs_no_agents(installed: Path, tmp_path: Path) -> None:
    options = ("--env", TASK, "--scenario", "report", "--baseline", CONTROLLER, "--baseline", "joint_pd")
    output = command(installed, tmp_path, "compare", *options, "--jobs", "1", "--output", "comparison")
    content = results(tmp_path / "comparison")
    kinds = [(row["policy"], row["kind"]) for row in content["evaluations"]]
    controllers = [(CONTROLLER, "controller"), ("joint_pd", "controller")]
    assert kinds == [*controllers, ("zero_torque", "floor"), ("hold", "floor")]
    assert content["pairwise_comparisons"] == []
    assert f"{TASK}, scenario report" in output


def test_tune_searches_the_declared_space(installed: Path, tmp_path: Path) -> None:
    options = ("--env", TASK, "--scenario", "report", "--budget", str(2 * STEPS))
    command(installed, tmp_path, "tune", CONTROLLER, *options, "--output", "tuning")
    folder = tmp_path / "tuning" / f"{TASK}_{CONTROLLER}"
    result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    assert (result["trials"], result["used_steps"], result["code"]) == (2, 2 * STEPS, {})
    assert set(result["settings"]) == {"slope", "reaching_gain", "boundary_layer"}
    assert result["score"] >= result["score_of_start"] > 0.98
    journal = (folder / "study.log").read_text(encoding="utf-8")
    assert f"plugin {MODULE}" in journal
    assert "boundary_layer_joint_3" in journal


COMPILED = """
import gymnasium, json, prp_gym, prp_gym_sliding_mode
from prp_gym.evaluation.batch import _record
from prp_gym.evaluation.compiled_batch import record_compiled
periods = []
for scenario in ("report", "realistic"):
    keywords = {"engine": "compiled", "scenario": scenario, "duration": 0.3}
    env = gymnasium.make("Example-JointRoundTrip-v0", **keywords).unwrapped
    for name in ("sliding_mode", "joint_pd"):
        episodes = [run(prp_gym.make_baseline(name, env), env, (1, 2)) for run in (record_compiled, _record)]
        for one, other in zip(*episodes, strict=True):
            same = [(one.torque == other.torque).all(), (one.reward == other.reward).all()]
            same += [(values == other.fields[field]).all() for field, values in one.fields.items()]
            periods.append(len(one.reward) if all(same) else 0)
print(json.dumps(periods))
"""


@needs_compiler
def test_compiled_code_runs_its_task_and_its_controller() -> None:
    assert json.loads(run(["-c", COMPILED], PACKAGE / "src")) == [150] * 8


THEORY = """
import json, gymnasium, numpy as np, prp_gym, prp_gym_sliding_mode
env = gymnasium.make("Example-JointRoundTrip-v0")
policy = prp_gym.make_baseline("sliding_mode", env)
rng = np.random.default_rng(0)
fields = {name: 0.1 * rng.standard_normal((50, 3)) for name in (
    "joint_position", "joint_velocity", "desired_joint_position", "desired_joint_velocity",
    "desired_joint_acceleration")}
arm, settings = policy.model, policy.settings
q, v = fields["joint_position"], fields["joint_velocity"]
effort = policy.torque(fields) - arm.bias_force(q, v)
acceleration = np.linalg.solve(arm.inertia_matrix(q), effort[..., None])[..., 0]
rate = fields["desired_joint_velocity"] - v
sliding = rate + settings.slope * (fields["desired_joint_position"] - q)
change = fields["desired_joint_acceleration"] - acceleration + settings.slope * rate
reaching = -settings.reaching_gain * np.clip(sliding / settings.boundary_layer, -1, 1)
outside = int((np.abs(sliding) > settings.boundary_layer).sum())
print(json.dumps([float(np.abs(change - reaching).max()), outside]))
"""


def test_sliding_variable_obeys_its_equation_with_the_exact_model(installed: Path, tmp_path: Path) -> None:
    error, outside = json.loads(run(["-c", THEORY], tmp_path, installed))
    assert error < 1e-9  # accelerations up to 80 rad/s²
    assert 20 < outside < 150  # both parts of the saturation
