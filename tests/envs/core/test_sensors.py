"""Sensors: exact where the scenario is ideal, otherwise a force with constant bias and white noise."""

import math
from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.envs import PRPEnv
from prp_gym.envs.base.scenarios import load_scenario
from prp_gym.envs.core.actuators import RealisticActuators
from prp_gym.envs.core.sensors import IdealSensors, NoisyForceSensor, make_sensors
from prp_gym.robot.arrays import Array
from prp_gym.tasks import SCENARIOS, ObservationLayout, Scenario
from prp_gym.tasks.fields import CONTACT_FORCE, MEASURED_FIELDS

REALISTIC = load_scenario("realistic")
BIASED = replace(REALISTIC, force_noise=0.0)
NOISY = replace(REALISTIC, force_bias=0.0)
LAYOUT = ObservationLayout((*MEASURED_FIELDS, CONTACT_FORCE))
FORCE = LAYOUT.index("contact_force")
BLOCK = 256  # readings between two draws of noise
LONG = 600  # steps, more than two blocks
KOLMOGOROV = 1.95  # of sqrt(n) D, exceeded once in a thousand samples


def begun(scenario: Scenario, seeds: list[int]) -> NoisyForceSensor:
    sensors = NoisyForceSensor(scenario, FORCE, len(seeds))
    sensors.begin(np.arange(len(seeds)), seeds)
    return sensors


def errors(sensors: NoisyForceSensor, num_envs: int) -> Array:
    """Readings of a force of zero (num_envs, 3)."""
    observation = np.zeros((num_envs, LAYOUT.size))
    sensors.read(observation)
    return observation[:, FORCE]


def series(sensors: NoisyForceSensor, num_envs: int, count: int) -> Array:
    """Readings of a force of zero, one for each period (count, num_envs, 3)."""
    rows = []
    for _ in range(count):
        rows.append(errors(sensors, num_envs))
        sensors.advance()
    return np.array(rows)


def distance_from_uniform(sample: Array) -> float:
    """Kolmogorov's sqrt(n) D between a sample and the uniform distribution on [0, 1]."""
    ordered, count = np.sort(sample), len(sample)
    above = np.arange(1, count + 1) / count - ordered
    below = ordered - np.arange(count) / count
    return float(np.sqrt(count) * max(above.max(), below.max()))


def environment(environment_id: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


CONTACT_IDS = [
    name for name in prp_gym.list_envs() if "contact_force" in environment(name).observation_layout.names
]


def pressed(environment_id: str, **keywords: Any) -> PRPEnv:
    """An environment with the tip inside a soft surface, which it leaves in tenths of a second."""
    env = environment(environment_id, **keywords)
    env.reset(
        seed=4,
        options={
            "joint_position": (0.0, -0.2, 0.0),
            "surface_normal": (0.0, -1.0, 0.0),
            "surface_offset": 0.44,
            "surface_stiffness": 50.0,
        },
    )
    return env


def test_ideal_sensors_read_the_ground_truth() -> None:
    ground_truth = np.random.default_rng(0).normal(size=(3, LAYOUT.size))
    reading, sensors = ground_truth.copy(), IdealSensors()
    sensors.begin(np.arange(3), [1, 2, 3])
    sensors.advance()
    sensors.read(reading)
    np.testing.assert_array_equal(reading, ground_truth)


@pytest.mark.parametrize("name", SCENARIOS)
def test_scenario_and_observation_choose_the_sensors(name: str) -> None:
    scenario = load_scenario(name)
    departs = scenario.force_noise > 0.0 or scenario.force_bias > 0.0
    assert isinstance(make_sensors(scenario, LAYOUT, 2), NoisyForceSensor if departs else IdealSensors)
    assert isinstance(make_sensors(scenario, ObservationLayout(MEASURED_FIELDS), 2), IdealSensors)


@pytest.mark.parametrize("scenario", [BIASED, NOISY], ids=["bias alone", "noise alone"])
def test_noise_or_bias_alone_make_the_force_sensor_noisy(scenario: Scenario) -> None:
    assert isinstance(make_sensors(scenario, LAYOUT, 2), NoisyForceSensor)


def test_errors_add_to_the_force_and_to_nothing_else() -> None:
    ground_truth = np.random.default_rng(0).normal(size=(2, LAYOUT.size))
    sensors, reading = begun(REALISTIC, [1, 2]), ground_truth.copy()
    error = errors(sensors, 2)
    sensors.read(reading)
    expected = ground_truth.copy()
    expected[:, FORCE] += error
    np.testing.assert_array_equal(reading, expected)
    assert (error != 0.0).all()


def test_noise_is_white_with_the_declared_deviation() -> None:
    count = 20_000
    values = series(begun(NOISY, [11]), 1, count)[:, 0] / REALISTIC.force_noise
    # five standard errors of the mean, the deviation and the correlations of so many normal numbers
    np.testing.assert_allclose(values.mean(axis=0), 0.0, rtol=0, atol=5 / np.sqrt(count))
    np.testing.assert_allclose(values.std(axis=0), 1.0, rtol=0, atol=5 / np.sqrt(2 * count))
    for lag in (1, BLOCK):
        correlation = (values[lag:] * values[:-lag]).mean(axis=0)
        np.testing.assert_allclose(correlation, 0.0, rtol=0, atol=5 / np.sqrt(count - lag))
    between_axes = (values * np.roll(values, 1, axis=1)).mean(axis=0)
    np.testing.assert_allclose(between_axes, 0.0, rtol=0, atol=5 / np.sqrt(count))


def test_bias_is_constant_within_an_episode() -> None:
    values = series(begun(BIASED, [5, 6]), 2, LONG)
    np.testing.assert_array_equal(values, np.broadcast_to(values[0], values.shape))
    assert (values[0, 0] != values[0, 1]).all()


def test_biases_of_many_episodes_are_uniform_within_the_declared_bound() -> None:
    seeds = list(range(3000))
    values = errors(begun(BIASED, seeds), len(seeds)) / REALISTIC.force_bias
    assert np.abs(values).max() <= 1.0
    for axis in range(3):
        assert distance_from_uniform((values[:, axis] + 1.0) / 2.0) < KOLMOGOROV
    # five standard errors of the correlation of 3000 pairs of uniform numbers of variance 1/3
    correlation = (values * np.roll(values, 1, axis=1)).mean(axis=0)
    np.testing.assert_allclose(correlation, 0.0, rtol=0, atol=5 / 3 / np.sqrt(len(seeds)))


def test_same_reading_until_the_next_period() -> None:
    sensors = begun(REALISTIC, [1, 2])
    for _ in range(BLOCK + 3):
        first, again = errors(sensors, 2), errors(sensors, 2)
        np.testing.assert_array_equal(first, again)
        sensors.advance()
        assert (errors(sensors, 2) != first).all()


def test_same_seed_gives_the_same_errors_and_another_seed_others() -> None:
    first, again, other = (series(begun(REALISTIC, [seed]), 1, LONG) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).all()


def test_errors_do_not_depend_on_neighbours() -> None:
    seeds = [4, 5, 6]
    together = series(begun(REALISTIC, seeds), 3, LONG)
    for index, seed in enumerate(seeds):
        np.testing.assert_array_equal(together[:, index], series(begun(REALISTIC, [seed]), 1, LONG)[:, 0])


@pytest.mark.parametrize("moment", [1, BLOCK - 1, BLOCK, BLOCK + 1, 300])
def test_restart_of_one_environment_leaves_the_others_errors_alone(moment: int) -> None:
    sensors = begun(REALISTIC, [4, 5])
    before = series(sensors, 2, moment)
    sensors.begin(np.array([1]), [6])
    after = series(sensors, 2, LONG)
    undisturbed = series(begun(REALISTIC, [4]), 1, moment + LONG)[:, 0]
    np.testing.assert_array_equal(np.concatenate([before, after])[:, 0], undisturbed)
    np.testing.assert_array_equal(after[:, 1], series(begun(REALISTIC, [6]), 1, LONG)[:, 0])


def test_noise_of_the_force_is_not_that_of_the_torques_of_the_same_seed() -> None:
    actuators = RealisticActuators(replace(REALISTIC, delay_steps=0), np.ones(3), 1)
    actuators.begin(np.arange(1), [3])
    torque = np.array([actuators.apply(np.zeros((1, 3)))[0] for _ in range(LONG)])
    force = series(begun(NOISY, [3]), 1, LONG)[:, 0]
    drives, sensor = torque.ravel() / torque.std(), force.ravel() / force.std()
    for lag in range(13):  # random numbers that one may have drawn before the other
        for early, late in ((drives, sensor), (sensor, drives)):
            correlation = (early[: len(early) - lag] * late[lag:]).mean()
            # five standard errors of the correlation of so many samples
            assert correlation == pytest.approx(0.0, abs=5 / np.sqrt(len(early) - lag))


@pytest.mark.parametrize("scenario", [name for name in SCENARIOS if name != "realistic"])
@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_observation_is_the_ground_truth_in_ideal_scenarios(environment_id: str, scenario: str) -> None:
    env = environment(environment_id, scenario=scenario)
    observation, _ = env.reset(seed=2)
    for action in np.random.default_rng(0).uniform(-0.01, 0.01, size=(30, *env.torque_limit.shape)):
        np.testing.assert_array_equal(observation, env.ground_truth[: env.observation_layout.size])
        observation, *_ = env.step(action)


@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_only_the_contact_force_is_observed_with_errors(environment_id: str) -> None:
    env = environment(environment_id, scenario="realistic")
    observation, _ = env.reset(seed=2)
    for action in np.random.default_rng(0).uniform(-0.5, 0.5, size=(30, *env.torque_limit.shape)):
        observed = env.observation_layout.split(observation)
        true = env.task.ground_truth_layout.split(env.ground_truth)
        for name, values in observed.items():
            if name == "contact_force":
                assert (values != true[name]).all()
            else:
                np.testing.assert_array_equal(values, true[name])
        observation, *_ = env.step(action)


@pytest.mark.parametrize("environment_id", CONTACT_IDS)
def test_errors_of_the_sensor_do_not_change_the_ground_truth(environment_id: str) -> None:
    env = pressed(environment_id, scenario="realistic")
    twin = pressed(environment_id, scenario="realistic")
    state = twin._loop.get_state()
    twin._loop.set_state(state._replace(rest={**state.rest, "_sensors": IdealSensors()}))
    touched = 0
    for action in np.random.default_rng(0).uniform(-0.01, 0.01, size=(150, 3)):
        _, *results = env.step(action)
        undisturbed, *expected = twin.step(action)
        assert results == expected
        np.testing.assert_array_equal(env.ground_truth, twin.ground_truth)
        force = env.task.ground_truth_layout.split(env.ground_truth)["contact_force"]
        np.testing.assert_array_equal(force, env.physics.contact_force[0])
        np.testing.assert_array_equal(undisturbed, env.ground_truth[: env.observation_layout.size])
        touched += bool(force.any())
    assert touched > 50


class ForceReward:
    """The reward of a force task from named values, by the formula Σ w/(1 + |e/s|), step after step."""

    def __init__(self) -> None:
        self.disturbance, self.established = 0.0, False

    def __call__(self, env: PRPEnv, parts: dict[str, Array]) -> float:
        inward = parts["desired_force"] / np.linalg.norm(parts["desired_force"])
        ratio = float(parts["contact_force"] @ inward / np.linalg.norm(parts["desired_force"]))
        touching = bool(np.linalg.norm(parts["contact_force"]) > 1e-6)
        lost = self.established and not touching
        decayed = self.disturbance * math.exp(-1.0 / (5.0 * env.control_frequency))
        self.disturbance = max(decayed, 1.0 if lost else ratio - 1.0)
        self.established = touching and (self.established or ratio > 0.5)
        deviation = parts["desired_pose"] - parts["end_effector_pose"]
        along = deviation[:3] - (deviation[:3] @ inward) * inward
        errors = (
            (0.4, (1.0 - ratio if ratio <= 1.0 else 2.0 * (ratio - 1.0)) / 0.2),
            (0.25, (self.disturbance if touching else max(self.disturbance, 1.0)) / 0.1),
            (0.15, float(np.linalg.norm(along / 0.01))),
            (0.15, float(np.linalg.norm(deviation[3:5] / 0.1))),
            (0.05, float(np.linalg.norm(env.commanded_torque / [50.0, 100.0, 10.0]))),
        )
        return math.fsum(weight / (1.0 + abs(error)) for weight, error in errors)


def test_reward_is_computed_from_the_true_force_and_not_from_its_reading() -> None:
    env = pressed("PRP-Force-v0", scenario="realistic")
    from_ground_truth, from_reading = ForceReward(), ForceReward()
    for action in np.random.default_rng(0).uniform(-0.01, 0.01, size=(100, 3)):
        observation, reward, *_ = env.step(action)
        expected = from_ground_truth(env, env.task.ground_truth_layout.split(env.ground_truth))
        misled = from_reading(env, env.observation_layout.split(observation))
        # some roundings
        assert reward == pytest.approx(expected, rel=1e-12)
        assert reward != pytest.approx(misled, rel=1e-7)


def test_info_holds_the_true_force() -> None:
    env = pressed("PRP-Compliance-v0", scenario="realistic")
    _, _, _, _, info = env.step(np.zeros(3))
    # the same numbers, one root
    assert info["contact_force"] == pytest.approx(np.linalg.norm(env.physics.contact_force[0]), rel=1e-15)
