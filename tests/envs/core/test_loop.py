"""The episode loop: N environments together equal N environments alone, bit for bit."""

import copy
from dataclasses import fields
from importlib import import_module
from itertools import cycle
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.envs import EpisodeLoop, PRPEnv
from prp_gym.envs.core.info import COMMON_INFO
from prp_gym.envs.core.step import Step
from prp_gym.errors import EpisodeError, InvalidValueError, JointLimitError, NonFiniteError, ShapeError
from prp_gym.robot import NOMINAL
from prp_gym.robot.arrays import Array
from prp_gym.tasks import SCENARIOS

N = 4
EVERYONE = np.arange(N)
LIMIT = NOMINAL.torque_limit  # of the arm, so that random actions do not throw the arm about in any scenario
NONE: dict[str, Array] = {}
REPORTED = {field.name: index for index, field in enumerate(reversed(COMMON_INFO), start=1)}


def environment(environment_id: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


def kinds() -> list[tuple[str, dict[str, Any]]]:
    """Every reference of every task in two scenarios: with noise, and in one of the others by turns."""
    ideal = cycle(name for name in SCENARIOS if name != "realistic")
    listed: list[tuple[str, dict[str, Any]]] = []
    for environment_id in prp_gym.list_envs():
        env = environment(environment_id)
        limit = env.arm.parameters.torque_limit
        choices: list[dict[str, Any]] = [{}]
        if any(entry.name == "reference" for entry in fields(env.task_spec.entry.options)):
            references = import_module(env.task_spec.entry.options.__module__).REFERENCES
            choices = [{"reference": reference} for reference in references]
        listed += [
            (environment_id, {"scenario": name, "torque_limit": limit, **choice})
            for choice in choices
            for name in ("realistic", next(ideal))
        ]
    return listed


def kind_name(kind: tuple[str, dict[str, Any]]) -> str:
    return "-".join([kind[0], *(value for value in kind[1].values() if isinstance(value, str))])


KINDS = kinds()
TASK = "PRP-JointRegulation-v0"  # where one task stands for all


def loop_of(kind: tuple[str, dict[str, Any]], num_envs: int = N, num_threads: int = 1) -> EpisodeLoop:
    env = environment(kind[0], **kind[1])
    return EpisodeLoop(env.task, env.config, num_envs, num_threads)


def a_loop(num_envs: int = N, **keywords: Any) -> EpisodeLoop:
    return loop_of((TASK, keywords), num_envs)


def generators(seeds: Any) -> list[np.random.Generator]:
    return [np.random.default_rng(seed) for seed in seeds]


def actions(count: int, num_envs: int = N, joints: int = 3) -> Array:
    values: Array = np.random.default_rng(7).uniform(-0.1, 0.1, size=(count, num_envs, joints))
    return values


def assert_rows_equal(together: Step, alone: list[Step]) -> None:
    for values, singles in zip(together, zip(*alone, strict=True), strict=True):
        np.testing.assert_array_equal(values, np.concatenate(singles))


def numbers_of(outcome: Step, loop: EpisodeLoop) -> Array:
    """All numbers of a step and the time after it, in one row for each environment."""
    values: Array = np.column_stack([*outcome, loop.time])
    return values


@pytest.mark.parametrize("kind", KINDS, ids=kind_name)
def test_many_equal_one_by_one_across_restarts_and_refills(kind: tuple[str, dict[str, Any]]) -> None:
    together, alone = loop_of(kind), {index: loop_of(kind, 1) for index in (1, 3)}
    # blocks of noise are drawn every 256 steps, the window of references is filled every 512
    restarts = {0: [0, 1, 2, 3], 150: [1, 3], 300: [2], 513: [0, 1, 2, 3], 530: [0, 3]}
    steps = 560 if kind[1]["scenario"] == "realistic" else 200
    found, expected = [], []
    for step, action in enumerate(actions(steps, joints=together.joints)):
        ids = np.array(restarts.get(step, []), dtype=np.intp)
        if len(ids):
            seeds = 1000 * step + ids
            observation = together.reset(ids, generators(seeds), NONE)
            assert observation.shape == (N, together.task.layout.size)
            for index in set(ids.tolist()) & set(alone):
                single = alone[index].reset(np.arange(1), generators([1000 * step + index]), NONE)
                np.testing.assert_array_equal(observation[index], single[0])
        outcome = together.step(action)
        assert not outcome.terminated.any()
        found.append(numbers_of(outcome, together)[list(alone)])
        expected.append([numbers_of(loop.step(action[[i]]), loop)[0] for i, loop in alone.items()])
    np.testing.assert_array_equal(found, expected)


def test_episode_is_truncated_in_the_step_that_reaches_its_duration() -> None:
    loop = a_loop(duration=0.02)  # ten steps
    loop.reset(EVERYONE, generators(EVERYONE), NONE)
    ends = [loop.step(action).truncated.tolist() for action in actions(10)]
    assert ends == [[False] * N] * 9 + [[True] * N]


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_two_threads_give_the_bits_of_one(scenario: str) -> None:
    kind = (TASK, {"scenario": scenario, "torque_limit": LIMIT})
    one, two = loop_of(kind, 16, 1), loop_of(kind, 16, 2)
    ids = np.arange(16)
    np.testing.assert_array_equal(
        one.reset(ids, generators(ids), NONE), two.reset(ids, generators(ids), NONE)
    )
    for action in actions(300, 16):
        for values, others in zip(one.step(action), two.step(action), strict=True):
            np.testing.assert_array_equal(values, others)


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_refused_start_changes_nothing(scenario: str) -> None:
    keywords: dict[str, Any] = {"scenario": scenario, "torque_limit": LIMIT}
    loop, twin = a_loop(**keywords), a_loop(**keywords)
    for either in (loop, twin):
        either.reset(EVERYONE, generators(EVERYONE), NONE)
    for step, action in enumerate(actions(300)):
        if step in (0, 100, 260):
            with pytest.raises(JointLimitError):
                loop.reset(np.array([1, 2]), generators([8, 9]), {"goal": np.tile([0.0, 0.5, 0.0], (2, 1))})
        assert_rows_equal(loop.step(action), [twin.step(action)])


def test_stepping_before_the_first_reset_is_refused() -> None:
    with pytest.raises(EpisodeError, match=r"environments \[0, 1, 2, 3\] cannot be stepped"):
        a_loop().step(np.zeros((N, 3)))


def test_wrong_actions_are_refused_and_change_nothing() -> None:
    loop, twin = a_loop(scenario="realistic"), a_loop(scenario="realistic")
    for either in (loop, twin):
        either.reset(EVERYONE, generators(EVERYONE), NONE)
    for action in actions(20):
        with pytest.raises(ShapeError, match="action") as wrong_shape:
            loop.step(action[:3])
        assert wrong_shape.value.shape == (3, 3)
        assert wrong_shape.value.expected == "(4, 3)"
        for bad in (np.nan, np.inf, -np.inf):
            spoilt = action.copy()
            spoilt[2, 1] = bad
            with pytest.raises(NonFiniteError, match="action"):
                loop.step(spoilt)
        assert_rows_equal(loop.step(action), [twin.step(action)])


def throw(loop: EpisodeLoop, index: int) -> None:
    """Give one environment a velocity beyond the bounds of divergence."""
    position = loop.physics.joint_position[[index]].copy()
    loop.physics.reset(np.array([index]), position, np.array([[0.0, 0.0, 700.0]]))


def test_divergence_ends_one_episode_and_leaves_its_neighbours_alone() -> None:
    loop, twin = a_loop(scenario="report"), a_loop(scenario="report")
    for either in (loop, twin):
        either.reset(EVERYONE, generators(EVERYONE), NONE)
    throw(loop, 2)
    outcome, undisturbed = loop.step(np.zeros((N, 3))), twin.step(np.zeros((N, 3)))
    np.testing.assert_array_equal(outcome.terminated, [False, False, True, False])
    assert outcome.reward[2] == 0.0
    np.testing.assert_array_equal(
        outcome.info[2, [f.name.startswith("reward_") for f in loop.info_fields]], 0.0
    )
    assert loop.task.layout.space().contains(outcome.observation[2])
    others = np.array([0, 1, 3])
    for values, expected in zip(outcome, undisturbed, strict=True):
        np.testing.assert_array_equal(values[others], expected[others])


def test_diverged_environment_must_be_reset_before_any_goes_on() -> None:
    loop, fresh = a_loop(), a_loop(1)
    loop.reset(EVERYONE, generators(EVERYONE), NONE)
    throw(loop, 2)
    loop.step(np.zeros((N, 3)))
    for _ in range(2):
        with pytest.raises(EpisodeError, match=r"environments \[2\] cannot be stepped"):
            loop.step(np.zeros((N, 3)))
    loop.reset(np.array([0]), generators([5]), NONE)
    with pytest.raises(EpisodeError, match=r"environments \[2\]"):
        loop.step(np.zeros((N, 3)))
    observation = loop.reset(np.array([2]), generators([6]), NONE)
    np.testing.assert_array_equal(observation[[2]], fresh.reset(np.arange(1), generators([6]), NONE))
    outcome, expected = loop.step(np.zeros((N, 3))), fresh.step(np.zeros((1, 3)))
    np.testing.assert_array_equal(outcome.observation[[2]], expected.observation)
    np.testing.assert_array_equal(outcome.reward[[2]], expected.reward)
    assert not outcome.terminated.any()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_state_that_is_not_finite_ends_the_episode_with_a_finite_observation(
    value: float, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its warning to a file in the working directory
    loop = a_loop()
    loop.reset(EVERYONE, generators(EVERYONE), NONE)
    state = loop.physics.snapshot()
    spoilt = state.integration.copy()
    columns = np.flatnonzero((state.integration == loop.physics.joint_position[1, 0])[1])
    assert len(columns) == 1  # where joint 1 stands in MuJoCo's state
    spoilt[1, columns] = value
    loop.physics.restore(state._replace(integration=spoilt))
    outcome = loop.step(np.zeros((N, 3)))
    np.testing.assert_array_equal(outcome.terminated, [False, True, False, False])
    assert outcome.reward[1] == 0.0
    assert np.isfinite(outcome.info).all()
    assert all(loop.task.layout.space().contains(row) for row in outcome.observation)


def test_saturated_joints_are_counted_and_clipped() -> None:
    loop, twin = a_loop(), a_loop()
    for either in (loop, twin):
        either.reset(EVERYONE, generators(EVERYONE), NONE)
    action = np.array([[0.5, -0.999, 0.0], [1.0, 0.0, 0.3], [-1.0, 2.0, 0.0], [-7.0, 1e9, 1.0]])
    outcome, clipped = loop.step(action), twin.step(np.clip(action, -1.0, 1.0))
    np.testing.assert_array_equal(outcome.info[:, -REPORTED["cost_saturation"]], [0, 1, 2, 3])
    np.testing.assert_array_equal(outcome.observation, clipped.observation)
    np.testing.assert_array_equal(outcome.reward, clipped.reward)
    np.testing.assert_array_equal(loop.step(0.5 * action / 1e9).info[:, -REPORTED["cost_saturation"]], 0)


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_joints_beyond_their_stops_are_counted(scenario: str) -> None:
    loop = a_loop(scenario=scenario, torque_limit=LIMIT)
    stops = [NOMINAL.joint_upper[0], NOMINAL.joint_lower[1], NOMINAL.joint_upper[2]]
    outward = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, -0.5, 0.0], [1.0, -0.5, 1.0]])
    loop.reset(EVERYONE, generators(EVERYONE), NONE)
    middle = np.array([0.5, -0.15, np.pi / 2])
    for index, speed in enumerate(outward):
        start = {"joint_position": np.where(speed != 0.0, stops, middle)[None], "joint_velocity": speed[None]}
        loop.reset(np.array([index]), generators([index]), start)
    counted = loop.step(np.zeros((N, 3))).info[:, -REPORTED["cost_joint_stop"]]
    stopping = loop.task.scenario.joint_stops
    np.testing.assert_array_equal(counted, [0, 1, 2, 3] if stopping else [0, 0, 0, 0])


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_drawn_plant_is_the_one_that_is_simulated(scenario: str) -> None:
    loop = a_loop(scenario=scenario)
    loop.reset(EVERYONE, generators(EVERYONE), NONE)
    loop.reset(np.array([1, 2]), generators([11, 12]), NONE)
    for index, seed in enumerate([0, 11, 12, 3]):
        rng, model = np.random.default_rng(seed), loop.physics.model(index)
        loop.task.draw([rng], NONE)
        plant = loop.task.scenario.draw_plants([rng])
        links = [model.body(f"link_{link}").id for link in (1, 2, 3)]
        # one product each
        masses = plant.mass_factor[0] * NOMINAL.link_mass
        np.testing.assert_allclose(model.body_mass[links], masses, rtol=1e-15)
        np.testing.assert_array_equal(model.dof_damping, plant.viscous_friction[0])
        np.testing.assert_array_equal(model.dof_frictionloss, plant.coulomb_friction[0])


def test_torque_noise_differs_between_environments_and_between_episodes() -> None:
    loop, rngs = a_loop(scenario="realistic"), generators(EVERYONE)
    acting = []
    for _ in range(3):
        loop.reset(EVERYONE, rngs, NONE)
        loop.step(np.zeros((N, 3)))
        acting += [tuple(torque) for torque in loop.physics.torque]
    assert len(set(acting)) == len(acting)


def test_state_of_another_number_of_environments_is_refused() -> None:
    loop, other = a_loop(2), a_loop(3)
    for either in (loop, other):
        either.reset(np.arange(either.num_envs), generators(range(either.num_envs)), NONE)
    with pytest.raises(InvalidValueError, match=r"state shape is \(3, .*; allowed: \(2, "):
        loop.set_state(other.get_state())


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_saved_loop_goes_on_as_the_original(scenario: str) -> None:
    keywords: dict[str, Any] = {"scenario": scenario, "torque_limit": LIMIT}
    loop, other = a_loop(**keywords), a_loop(**keywords)
    loop.reset(EVERYONE, generators(EVERYONE), NONE)
    other.reset(EVERYONE, generators(EVERYONE + 10), NONE)
    given = actions(700)
    for action in given[:300]:
        last = loop.step(action)
        other.step(action)
    state = loop.get_state()
    kept = copy.deepcopy(state)
    future = [loop.step(action) for action in given[300:]]
    for start in (state, kept):
        np.testing.assert_array_equal(other.set_state(start), last.observation)
        for action, expected in zip(given[300:], future, strict=True):
            assert_rows_equal(other.step(action), [expected])
