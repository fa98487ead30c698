"""What `prp-gym evaluate` runs, writes and prints."""

import json
import sys
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from typer.testing import CliRunner

from prp_gym import list_envs
from prp_gym.baselines import BASELINES, CONTROLLERS, list_baselines, make_baseline
from prp_gym.baselines.base.gains import gain_sets
from prp_gym.cli.main import app, main
from prp_gym.evaluation import METRICS, evaluate
from prp_gym.symbolic.compiler import compiles_by_default
from prp_gym.tasks.scenario import SCENARIOS

RUNNER = CliRunner()
WIDTH = 120
COMMON_SETS = sorted(set.intersection(*(set(gain_sets(controller)) for controller in BASELINES)))


@pytest.fixture(autouse=True)
def no_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Variables that make rich take a pipe for a terminal, as some build servers set them."""
    for name in ("FORCE_COLOR", "TTY_COMPATIBLE", "COLUMNS"):
        monkeypatch.delenv(name, raising=False)


def results_of(folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return content


def evaluations(content: dict[str, Any]) -> list[dict[str, Any]]:
    """The evaluations of controllers, without those of the floors."""
    return [row for row in content["evaluations"] if not row.get("floor")]


def jobs_of(content: dict[str, Any]) -> list[tuple[str, str, str]]:
    return [(row["environment"], row["scenario"], row["baseline"]) for row in evaluations(content)]


def run_evaluate(folder: Path, *options: str) -> str:
    """Standard output of a short evaluation in this process."""
    result = RUNNER.invoke(app, ["evaluate", "--jobs", "1", "--output", str(folder), *options])
    assert result.exit_code == 0, result.output
    return result.stdout


@pytest.fixture
def short_episodes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Episodes of a few steps, where many jobs are evaluated and their scores are of no concern."""
    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=0.02))


@pytest.fixture
def half_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    """Episodes that are long enough for scores that differ."""
    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=0.5))


def test_evaluate_covers_every_job_unless_told_otherwise(short_episodes: None, tmp_path: Path) -> None:
    output = run_evaluate(tmp_path, "--episodes", "1")
    expected = []
    for environment_id in list_envs():
        made = gymnasium.make(environment_id)
        controllers = list_baselines(made.get_wrapper_attr("observation_layout"))
        made.close()
        expected += [
            (environment_id, scenario, controller)
            for scenario in ("report", "randomized")
            for controller in controllers
            if compiles_by_default() or not CONTROLLERS[controller].policy.slow_without_compiler
        ]
    assert jobs_of(results_of(tmp_path)) == expected
    for environment_id, scenario, controller in expected:
        assert f"{environment_id}, scenario {scenario}" in output
        assert controller in output
    assert "…" not in output
    assert max(map(len, output.splitlines())) <= WIDTH


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_evaluate_writes_what_the_evaluator_finds(half_a_second: None, tmp_path: Path, scenario: str) -> None:
    environment_id, controller = list_envs()[0], next(iter(BASELINES))
    options = ("--env", environment_id, "--baseline", controller, "--scenario", scenario)
    run_evaluate(tmp_path, *options, "--episodes", "2", "--seed", "9", "--gains", "report")
    (row,) = evaluations(results_of(tmp_path))
    made = gymnasium.make(environment_id, scenario=scenario)
    policy = make_baseline(controller, made, "report")
    expected = evaluate(policy, made, episodes=2, seed=9)
    made.close()
    assert row["seeds"] == [rollout.seed for rollout in expected.rollouts]
    assert row["score"] == expected.score._asdict()
    assert row["episodes"]["energy"] == expected.metrics["energy"].tolist()
    assert row["settings"]["gains"] == "report"
    np.testing.assert_array_equal(row["settings"]["proportional_gain"], policy.settings.proportional_gain)


def test_evaluate_tells_what_the_results_depend_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    options = ["evaluate", "--env", list_envs()[0], "--scenario", "report", "--episodes", "1"]
    options += ["--baseline", "joint_pd", "--jobs", "1", "--output", str(tmp_path / "a b")]
    monkeypatch.setattr(sys, "argv", ["/somewhere/prp-gym", *options])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 0
    content = results_of(tmp_path / "a b")
    assert content["command"] == f"prp-gym {' '.join(options[:-1])} '{tmp_path}/a b'"
    assert {"python", "prp-gym", "gymnasium", "mujoco", "numpy"} == set(content["versions"])
    assert set(content["units"]) == set(METRICS)


def test_evaluate_prints_whole_tables_best_controller_first(half_a_second: None, tmp_path: Path) -> None:
    output = run_evaluate(tmp_path, "--env", list_envs()[0], "--scenario", "report", "--episodes", "1")
    assert "…" not in output
    assert max(map(len, output.splitlines())) <= WIDTH
    scores = {row["baseline"]: row["score"]["value"] for row in evaluations(results_of(tmp_path))}
    printed = [
        line.split()[:2] for line in output.splitlines() if line.split()[:1] and line.split()[0] in scores
    ]
    ranking = [[name, f"{scores[name]:.3f}"] for name in sorted(scores, key=lambda name: -scores[name])]
    assert printed == 2 * ranking  # the table of the scores, and that of the metrics
    assert f"results: {tmp_path / 'results.json'}" in output.replace("\n", "")


def test_evaluate_takes_an_option_several_times(short_episodes: None, tmp_path: Path) -> None:
    controllers, environments = list(BASELINES)[:-4:-1], list_envs()[:-4:-1]
    options = [item for controller in controllers for item in ("--baseline", controller)]
    options += [item for environment_id in environments for item in ("--env", environment_id)]
    options += ["--scenario", "realistic", "--scenario", "report"]
    run_evaluate(tmp_path, *options, "--episodes", "1")
    jobs = jobs_of(results_of(tmp_path))
    assert {controller for _, _, controller in jobs} == set(controllers)
    assert {environment_id for environment_id, _, _ in jobs} == set(environments)
    assert {scenario for _, scenario, _ in jobs} == {"realistic", "report"}


@pytest.mark.parametrize("gains", COMMON_SETS)
def test_evaluate_takes_every_set_that_all_controllers_have(
    short_episodes: None, tmp_path: Path, gains: str
) -> None:
    run_evaluate(
        tmp_path, "--env", list_envs()[0], "--scenario", "report", "--episodes", "1", "--gains", gains
    )
    assert {row["settings"]["gains"] for row in evaluations(results_of(tmp_path))} == {gains}


def test_evaluate_twice_gives_the_same_numbers(half_a_second: None, tmp_path: Path) -> None:
    contents, names = [], ("--baseline", "joint_pd", "--baseline", "adaptive")  # one of them is stateful
    for folder in (tmp_path / "first", tmp_path / "second"):
        run_evaluate(folder, "--env", list_envs()[0], *names, "--scenario", "randomized", "--episodes", "2")
        rows = results_of(folder)["evaluations"]
        contents.append([{k: v for k, v in row.items() if k != "compute_time_per_step"} for row in rows])
    assert contents[0] == contents[1]
