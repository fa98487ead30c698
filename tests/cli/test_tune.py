"""What `prp-gym tune` runs, writes and prints."""

import json
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import pytest
from typer.testing import CliRunner

import prp_gym
from prp_gym.baselines import make_baseline
from prp_gym.cli.main import app
from prp_gym.errors import InvalidValueError, MissingFieldError, PRPError, UnknownNameError
from prp_gym.evaluation import evaluate
from prp_gym.runs import search
from prp_gym.tuning import load_tuned_controller

RUNNER = CliRunner()
ENVIRONMENT, CONTROLLER = "PRP-JointRegulation-v0", "joint_pd"
STEPS = 10
OPTIONS = ["--env", ENVIRONMENT, "--episodes", "2", "--seed", "3", "--scenario", "randomized"]


@pytest.fixture(autouse=True)
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Episodes of a few steps, and no terminal, whatever a build server says."""
    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=STEPS / 500.0))
    for name in ("FORCE_COLOR", "TTY_COMPATIBLE", "COLUMNS"):
        monkeypatch.delenv(name, raising=False)


def run(folder: Path, *options: str) -> Any:
    return RUNNER.invoke(app, ["tune", CONTROLLER, *OPTIONS, "--output", str(folder), *options])


def content(folder: Path) -> dict[str, Any]:
    path = folder / f"{ENVIRONMENT}_{CONTROLLER}" / "result.json"
    read: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return {name: value for name, value in read.items() if name not in ("seconds", "command")}


def test_result_says_what_was_spent_and_what_was_found(tmp_path: Path) -> None:
    result = run(tmp_path, "--budget", "109")
    assert result.exit_code == 0, result.output
    controller = load_tuned_controller(tmp_path / f"{ENVIRONMENT}_{CONTROLLER}" / "result.json")
    assert (controller.environment, controller.controller, controller.scenarios) == (
        ENVIRONMENT,
        CONTROLLER,
        ("randomized",),
    )
    assert (controller.budget_steps, controller.used_steps, controller.trials, controller.episodes) == (
        109,
        100,
        5,
        2,
    )
    assert controller.simulated_seconds == pytest.approx(0.2)
    assert controller.history[-1] == (100, controller.score)
    assert {"python", "mujoco", "optuna"} <= set(controller.versions)
    env = gymnasium.make(ENVIRONMENT)
    policies = controller.make(env), make_baseline(CONTROLLER, env)
    # the scores of the evaluator, but for sums in another order: on training and on validation episodes
    for seed, episodes, scores, tolerance in (
        (4_000_000, 2, (controller.score, controller.score_of_start), 1e-3),  # before settings were rounded
        (500_000_000, 100, (controller.validation.score, controller.validation.score_of_start), 1e-12),
    ):
        for policy, score in zip(policies, scores, strict=True):
            mean = evaluate(policy, env, episodes, seed).metrics["score"].mean()
            assert score == pytest.approx(mean, rel=tolerance)
    env.close()
    for score in (
        controller.score,
        controller.score_of_start,
        controller.validation.score,
        controller.validation.score_of_start,
    ):
        assert f"{score:.4f}" in result.stdout
    assert "5 trials, 100 of 109 steps" in result.stdout


@pytest.mark.parametrize("option", [(), ("--resume",)], ids=["default", "resume"])
def test_same_command_takes_over_the_trials_of_the_search(tmp_path: Path, option: tuple[str, ...]) -> None:
    assert run(tmp_path, "--budget", "100").exit_code == 0
    before = content(tmp_path)
    resumed = run(tmp_path, "--budget", "100", *option)
    assert resumed.exit_code == 0
    assert "5 trials with 100 steps were finished by an interrupted run." in resumed.stderr
    assert content(tmp_path) == before


def test_fresh_search_takes_over_nothing_whatever_there_was(tmp_path: Path) -> None:
    assert run(tmp_path, "--budget", "120").exit_code == 0
    refused = run(tmp_path, "--budget", "100")
    assert "--fresh removes it and starts over" in str(refused.exception)
    fresh = run(tmp_path, "--budget", "100", "--fresh")
    assert fresh.exit_code == 0
    assert "were finished by an interrupted run" not in fresh.stderr
    assert (content(tmp_path)["budget_steps"], content(tmp_path)["trials"]) == (100, 5)


@pytest.mark.parametrize("other", [("--budget", "120"), ("--budget", "100", "--scenario", "realistic")])
def test_search_with_other_options_is_not_resumed(tmp_path: Path, other: tuple[str, ...]) -> None:
    assert run(tmp_path, "--budget", "100").exit_code == 0
    assert isinstance(run(tmp_path, *other, "--resume").exception, InvalidValueError)


def test_search_of_other_code_is_not_resumed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert run(tmp_path, "--budget", "100").exit_code == 0
    monkeypatch.setattr(search, "running_code", lambda: {"sources": "0"})
    assert isinstance(run(tmp_path, "--budget", "100", "--resume").exception, InvalidValueError)


@dataclass(frozen=True)
class Card:
    steps: int
    control_frequency: float


@dataclass(frozen=True)
class Agent:
    card: Card


@pytest.mark.parametrize(
    ("steps", "rate", "budget"),
    [(10, 50.0, 100), (33, 100.0, 165), (20, 500.0, 20), (41, 1000.0, 20), (10, 62.5, 80)],
)
def test_budget_like_an_agent_s_is_its_simulated_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, steps: int, rate: float, budget: int
) -> None:
    monkeypatch.setattr(prp_gym, "load_agent", {"some/agent": Agent(Card(steps, rate))}.get, raising=False)
    result = run(tmp_path, "--like", "some/agent")
    assert result.exit_code == 0, result.output
    assert content(tmp_path)["budget_steps"] == budget


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ([CONTROLLER, "--env", ENVIRONMENT], InvalidValueError),
        ([CONTROLLER, "--env", ENVIRONMENT, "--budget", "100", "--like", "some/agent"], InvalidValueError),
        ([CONTROLLER, "--env", ENVIRONMENT, "--budget", "0"], InvalidValueError),
        ([CONTROLLER, "--env", ENVIRONMENT, "--budget", "199"], InvalidValueError),  # 20 episodes of 10 steps
        ([CONTROLLER, "--env", ENVIRONMENT, "--budget", "100", "--episodes", "0"], InvalidValueError),
        (
            [CONTROLLER, "--env", ENVIRONMENT, "--budget", "200", "--control-frequency", "3"],
            InvalidValueError,
        ),
        ([CONTROLLER, "--env", "PRP-Nowhere-v0", "--budget", "200"], UnknownNameError),
        (["joint_pid", "--env", ENVIRONMENT, "--budget", "200"], UnknownNameError),
        (
            [CONTROLLER, "--env", ENVIRONMENT, "--budget", "200", "--scenario", "windy"],
            UnknownNameError,
        ),
        (["admittance", "--env", ENVIRONMENT, "--budget", "200"], MissingFieldError),
        (["--env", ENVIRONMENT, "--budget", "200"], InvalidValueError),
        ([CONTROLLER, "--baseline", CONTROLLER, "--env", ENVIRONMENT, "--budget", "200"], InvalidValueError),
    ],
)
def test_options_of_which_no_search_can_be_made_are_refused(
    tmp_path: Path, arguments: list[str], error: type[PRPError]
) -> None:
    result = RUNNER.invoke(app, ["tune", *arguments, "--output", str(tmp_path)])
    assert type(result.exception) is error, result.output
    assert not list(tmp_path.glob("**/*.json"))


def test_controller_may_be_named_by_an_option_as_in_the_other_commands(tmp_path: Path) -> None:
    assert run(tmp_path / "argument", "--budget", "60").exit_code == 0
    options = [
        "tune",
        "--baseline",
        CONTROLLER,
        *OPTIONS,
        "--budget",
        "60",
        "--output",
        str(tmp_path / "option"),
    ]
    assert RUNNER.invoke(app, options).exit_code == 0
    found, expected = (content(tmp_path / name) for name in ("option", "argument"))
    assert found | {"checksum": ""} == expected | {"checksum": ""}  # which is over the compute times, too


def test_deterministic_scenario_beside_another_is_one_episode(tmp_path: Path) -> None:
    assert run(tmp_path, "--budget", "40", "--scenario", "report").exit_code == 0
    result = content(tmp_path)
    assert (result["trials"], result["used_steps"]) == (2, 40)
    assert (result["episodes"], result["validation"]["episodes"]) == (2, 51)


def test_slow_rate_starts_from_the_gains_for_it(tmp_path: Path) -> None:
    assert run(tmp_path, "--budget", "2", "--control-frequency", "50").exit_code == 0
    env = gymnasium.make(ENVIRONMENT, control_frequency=50.0)
    controller = load_tuned_controller(tmp_path / f"{ENVIRONMENT}_{CONTROLLER}" / "result.json")
    expected = make_baseline(CONTROLLER, env, "tuned_50hz").settings.proportional_gain
    assert controller.trials == 1  # of two episodes of a step
    assert controller.make(env).settings.proportional_gain.tolist() == expected.tolist()
    env.close()
