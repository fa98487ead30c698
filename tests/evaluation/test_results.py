"""Results of evaluations: what the file says of a run and of each evaluation."""

import json
import os
import platform
import shlex
from importlib.metadata import version
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym import list_envs
from prp_gym.artifacts import to_plain
from prp_gym.baselines import list_baselines, make_baseline
from prp_gym.evaluation import METRICS, evaluate
from prp_gym.evaluation.results import SCHEMA, describe_evaluation, describe_run
from tests.core.test_artifacts import strict


def described(environment_id: str, scenario: str) -> tuple[Any, Any]:
    """A short evaluation, and how it is described after a way through a file's text."""
    env = gymnasium.make(environment_id, scenario=scenario, duration=0.1)
    controller = list_baselines(env.get_wrapper_attr("observation_layout"))[0]
    policy = make_baseline(controller, env, "report")
    evaluation = evaluate(policy, env, episodes=3, seed=4)
    env.close()
    content = describe_evaluation(evaluation, controller, {"gains": "report", **vars(policy.settings)})
    return evaluation, strict(json.dumps(to_plain(content), allow_nan=False))


def test_run_is_described_by_versions_machine_command_and_units() -> None:
    command = shlex.join(["prp-gym", "evaluate", "--output", "a b"])
    run = strict(json.dumps(to_plain(describe_run(command)), allow_nan=False))
    assert run["schema"] == SCHEMA
    assert run["command"] == command
    packages = {name: version(name) for name in ("prp-gym", "gymnasium", "mujoco", "numpy")}
    assert run["versions"] == {"python": platform.python_version(), **packages}
    machine = {"system": platform.system(), "architecture": platform.machine(), "cores": os.cpu_count()}
    assert run["machine"] == machine
    assert run["units"] == {metric.name: list(metric.units) for metric in METRICS.values()}


@pytest.mark.parametrize("environment_id", list_envs())
def test_evaluation_is_described_so_that_it_can_be_repeated(environment_id: str) -> None:
    evaluation, content = described(environment_id, "randomized")
    first = evaluation.rollouts[0]
    assert (content["environment"], content["scenario"]) == (environment_id, "randomized")
    assert content["seeds"] == [4, 5, 6]
    assert (content["control_period"], content["duration"]) == (first.period, first.duration)
    assert content["settings"]["gains"] == "report"
    env = gymnasium.make(environment_id)
    repeated = make_baseline(content["baseline"], env, content["settings"]["gains"])
    env.close()
    assert {"gains", *vars(repeated.settings)} == set(content["settings"])
    for name, value in vars(repeated.settings).items():
        assert content["settings"][name] == to_plain(value)


@pytest.mark.parametrize("scenario", ["report", "randomized"])
@pytest.mark.parametrize("environment_id", list_envs())
def test_numbers_of_an_evaluation_are_those_of_its_episodes(environment_id: str, scenario: str) -> None:
    evaluation, content = described(environment_id, scenario)
    count = len(evaluation.rollouts)
    assert len(content["seeds"]) == count
    assert content["score"] == evaluation.score._asdict()
    assert set(content["score"]) == {"value", "low", "high"}
    assert content["compute_time_per_step"] == evaluation.compute_time > 0.0
    assert set(content["episodes"]) == set(content["median"]) == set(evaluation.metrics)
    for name, values in evaluation.metrics.items():
        assert content["episodes"][name] == to_plain(values)
        assert np.shape(content["episodes"][name]) == values.shape
        assert content["median"][name] == to_plain(evaluation.median[name])
