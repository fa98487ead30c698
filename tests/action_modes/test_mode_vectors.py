"""Many environments in a mode are single ones, bit for bit, however many, on however many threads."""

from itertools import cycle
from typing import Any

import gymnasium
import numpy as np
import pytest
from stable_baselines3.common.vec_env import DummyVecEnv

import prp_gym
from tests.support.mode_episodes import KINDS, made, random_actions
from tests.support.vector_episodes import (
    MODES,
    assert_history,
    assert_same,
    history_of,
    one_by_one,
    run_alone,
    run_together,
    together,
)

BY_TURNS = [(*each, autoreset) for each, autoreset in zip(KINDS, cycle(MODES), strict=False)]
KEYWORDS: dict[str, Any] = {"scenario": "realistic", "control_frequency": 100, "duration": 0.06}


@pytest.mark.parametrize(("environment_id", "mode", "autoreset"), BY_TURNS)
def test_steps_and_restarts_are_those_of_single_environments(
    environment_id: str, mode: str, autoreset: str
) -> None:
    keywords = {**KEYWORDS, "action_mode": mode}
    ours, theirs = (make(environment_id, autoreset, 3, **keywords) for make in (together, one_by_one))
    assert_same(ours.reset(seed=7), theirs.reset(seed=7), "reset")
    again = np.zeros(3, dtype=np.bool_)
    for count, action in enumerate(random_actions(ours, 9, share=1.2)):
        if count == 3:
            again |= [True, False, False]
        if again.any():
            seeds = [100 + count, None, 5]
            found = ours.reset(seed=seeds, options={"reset_mask": again})
            assert_same(found, theirs.reset(seed=seeds, options={"reset_mask": again}), f"reset {count}")
        outcome = ours.step(action)
        assert_same(outcome, theirs.step(action), f"step {count}")
        again = (outcome[2] | outcome[3]) & (autoreset == "Disabled")


@pytest.mark.parametrize(("num_envs", "num_threads"), [(1, 1), (7, 2), (64, 0)])
@pytest.mark.parametrize(
    ("environment_id", "mode"),
    [
        ("PRP-Adaptive-v0", "residual:adaptive"),
        ("PRP-ForcePosition-v0", "admittance"),
        ("PRP-ForcePosition-v0", "force_position"),
        ("PRP-ForcePosition-v0", "joint_position"),
        ("PRP-ForcePosition-v0", "variable_impedance"),
    ],
)
def test_environment_is_the_same_alone_and_among_any_number(
    environment_id: str, mode: str, num_envs: int, num_threads: int
) -> None:
    keywords = {**KEYWORDS, "action_mode": mode}
    env = together(environment_id, "SameStep", num_envs, num_threads=num_threads, **keywords)
    actions = random_actions(env, 8, share=1.2)
    found = run_together(env, 50, actions)
    for index in {0, num_envs // 2, num_envs - 1}:
        alone = made(environment_id, mode, **KEYWORDS)
        expected = run_alone(alone, 50 + index, actions[:, index], again=3 if index % 3 == 0 else -1)
        assert_history(history_of(found, index), expected, f"environment {index} of {num_envs}")


def test_environments_in_processes_are_ours() -> None:
    keywords = {**KEYWORDS, "action_mode": "variable_impedance"}
    name = "PRP-ForcePosition-v0"
    ours, theirs = together(name, num_envs=2, **keywords), gymnasium.make_vec(name, 2, "async", **keywords)
    try:
        assert ours.action_space == theirs.action_space
        assert_same(ours.reset(seed=7), theirs.reset(seed=7), "reset")
        for count, action in enumerate(random_actions(ours, 8)):
            assert_same(ours.step(action), theirs.step(action), f"step {count}")
    finally:
        theirs.close()


@pytest.mark.parametrize("mode", ["variable_impedance", "residual:parallel_force_position"])
def test_environments_for_stable_baselines3_are_its_own(mode: str) -> None:
    name = "PRP-ForcePosition-v0"
    ours = prp_gym.make_sb3_vec_env(name, 3, seed=4, action_mode=mode, **KEYWORDS)
    theirs = DummyVecEnv([lambda: made(name, mode, **KEYWORDS)] * 3)
    theirs.seed(4)
    assert ours.action_space == theirs.action_space
    np.testing.assert_array_equal(ours.reset(), theirs.reset())
    for action in random_actions(theirs, 3).repeat(3, axis=0):
        batch = np.tile(action, (3, 1))
        for found, expected in zip(ours.step(batch)[:3], theirs.step(batch)[:3], strict=True):
            np.testing.assert_array_equal(found, expected)


def test_views_of_many_know_the_mode() -> None:
    env = together("PRP-Impedance-v0", num_envs=2, action_mode="variable_stiffness")
    assert env.get_attr("action_mode") == ("variable_stiffness",) * 2
    assert [field.name for field in env.envs[1].action_fields] == ["pose_offset", "stiffness_factor"]
    assert env.single_action_space.shape == (10,)
