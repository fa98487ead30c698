"""Actuators: ideal ones change nothing, realistic ones add delay and noise, each from its own seed."""

from dataclasses import replace

import numpy as np
import pytest

from prp_gym.envs.base.scenarios import load_scenario
from prp_gym.envs.core.actuators import IdealActuators, RealisticActuators, make_actuators
from prp_gym.robot.arrays import Array
from prp_gym.tasks import SCENARIOS, Scenario

REALISTIC = load_scenario("realistic")
QUIET = replace(REALISTIC, torque_noise=0.0)
PROMPT = replace(REALISTIC, delay_steps=0)
LIMIT = np.array([50.0, 100.0, 10.0])  # nominal actuator limits [N m, N, N m]
LONG = 600  # steps: noise is drawn in blocks of 256


def commands(count: int, num_envs: int) -> Array:
    values: Array = np.random.default_rng(9).normal(size=(count, num_envs, 3))
    return values


def begun(scenario: Scenario, seeds: list[int]) -> RealisticActuators:
    actuators = RealisticActuators(scenario, LIMIT, len(seeds))
    actuators.begin(np.arange(len(seeds)), seeds)
    return actuators


def noise(actuators: RealisticActuators, num_envs: int, count: int) -> Array:
    """Applied torques under commands of zero (count, num_envs, 3)."""
    return np.array([actuators.apply(np.zeros((num_envs, 3))) for _ in range(count)])


def test_ideal_actuators_apply_the_command() -> None:
    actuators, command = IdealActuators(), commands(1, 4)[0]
    actuators.begin(np.arange(4), [1, 2, 3, 4])
    np.testing.assert_array_equal(actuators.apply(command), commands(1, 4)[0])


@pytest.mark.parametrize("name", SCENARIOS)
def test_scenario_chooses_the_actuators(name: str) -> None:
    scenario = load_scenario(name)
    departs = scenario.delay_steps > 0 or scenario.torque_noise > 0.0
    assert isinstance(make_actuators(scenario, LIMIT, 2), RealisticActuators if departs else IdealActuators)


@pytest.mark.parametrize("scenario", [PROMPT, QUIET], ids=["noise alone", "delay alone"])
def test_delay_or_noise_alone_make_actuators_realistic(scenario: Scenario) -> None:
    assert isinstance(make_actuators(scenario, LIMIT, 2), RealisticActuators)


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_commands_are_applied_after_the_delay_and_zero_before(delay: int) -> None:
    actuators = begun(replace(QUIET, delay_steps=delay), [1, 2])
    given = commands(20, 2)
    acting = np.array([actuators.apply(command) for command in given])
    np.testing.assert_array_equal(acting[:delay], 0.0)
    np.testing.assert_array_equal(acting[delay:], given[: 20 - delay])


def test_new_episode_empties_the_delay_line_of_its_own_environment_only() -> None:
    actuators, given = begun(QUIET, [1, 2]), commands(2, 2)
    actuators.apply(given[0])
    actuators.begin(np.array([1]), [3])
    acting = actuators.apply(given[1])
    np.testing.assert_array_equal(acting[0], given[0, 0])
    np.testing.assert_array_equal(acting[1], 0.0)


def test_noise_adds_to_the_delayed_command() -> None:
    given = commands(50, 1)
    quiet, noisy = begun(QUIET, [5]), begun(REALISTIC, [5])
    silent = begun(REALISTIC, [5])
    for command in given:
        expected = quiet.apply(command) + silent.apply(np.zeros((1, 3)))
        np.testing.assert_array_equal(noisy.apply(command), expected)


def test_noise_is_white_with_the_declared_deviation() -> None:
    count = 20_000
    values = noise(begun(REALISTIC, [11]), 1, count)[:, 0] / (REALISTIC.torque_noise * LIMIT)
    # five standard errors of the mean, the deviation and the correlation of so many normal numbers
    np.testing.assert_allclose(values.mean(axis=0), 0.0, rtol=0, atol=5 / np.sqrt(count))
    np.testing.assert_allclose(values.std(axis=0), 1.0, rtol=0, atol=5 / np.sqrt(2 * count))
    for lag in (1, 256):
        correlation = (values[lag:] * values[:-lag]).mean(axis=0)
        np.testing.assert_allclose(correlation, 0.0, rtol=0, atol=5 / np.sqrt(count - lag))


def test_same_seed_gives_the_same_noise_and_another_seed_another() -> None:
    first, again, other = (noise(begun(REALISTIC, [seed]), 1, LONG) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).all()


def test_noise_does_not_depend_on_neighbours() -> None:
    seeds = [4, 5, 6]
    together = noise(begun(REALISTIC, seeds), 3, LONG)
    for index, seed in enumerate(seeds):
        np.testing.assert_array_equal(together[:, index], noise(begun(REALISTIC, [seed]), 1, LONG)[:, 0])


@pytest.mark.parametrize("moment", [1, 255, 256, 257, 300])
def test_restart_of_one_environment_leaves_the_others_noise_alone(moment: int) -> None:
    actuators = begun(REALISTIC, [4, 5])
    before = noise(actuators, 2, moment)
    actuators.begin(np.array([1]), [6])
    after = noise(actuators, 2, LONG)
    undisturbed = noise(begun(REALISTIC, [4]), 1, moment + LONG)[:, 0]
    np.testing.assert_array_equal(np.concatenate([before, after])[:, 0], undisturbed)
    np.testing.assert_array_equal(after[:, 1], noise(begun(REALISTIC, [6]), 1, LONG)[:, 0])


def test_actuators_of_a_robot_with_one_joint_have_the_same_delay_and_relative_noise() -> None:
    actuators = RealisticActuators(REALISTIC, np.array([30.0]), 1)
    actuators.begin(np.arange(1), [3])
    acting = np.array([actuators.apply(np.array([[7.0]]))[0] for _ in range(5000)])
    assert acting.shape == (5000, 1)
    assert abs(acting[0, 0]) < 1.0  # one-step delay: noise alone, of 0.005 · 30 N m
    # five standard errors of the mean and the deviation of so many normal numbers
    assert acting[1:].mean() == pytest.approx(7.0, abs=5 * 0.15 / np.sqrt(4999))
    assert acting[1:].std() == pytest.approx(0.15, rel=5 / np.sqrt(2 * 4999))
