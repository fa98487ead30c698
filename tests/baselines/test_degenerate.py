"""Degenerate policies do what their names say, and see no more than the observation."""

from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.baselines.degenerate import DEGENERATE
from prp_gym.envs import PRPEnv

FORCE = {"surface_stiffness": 1000.0, "surface_damping": 0.0, "desired_force": 5.0}
WALL = {
    "joint_position": (0.0, -0.08, 0.0),
    "surface_normal": (0.0, -1.0, 0.0),
    "surface_offset": 0.44,
}  # 2 cm from the tip


def run(
    name: str, environment_id: str, options: dict[str, Any], **keywords: Any
) -> tuple[PRPEnv, list[float]]:
    """The environment at the end of an episode, and the contact force at every step [N]."""
    env = gymnasium.make(environment_id, **keywords)
    policy, (observation, info) = DEGENERATE[name].make(env), env.reset(seed=3, options=options)
    state, forces, done = None, [], False
    while not done:
        action, state = policy.predict(observation, state)
        observation, _, terminated, truncated, info = env.step(action)
        forces.append(info.get("contact_force", 0.0))
        done = terminated or truncated
    inner: Any = env.unwrapped
    return inner, forces


def test_maximum_torque_drives_every_actuator_at_its_limit() -> None:
    env = gymnasium.make("PRP-JointTracking-v0")
    observation, _ = env.reset(seed=0)
    action, _ = DEGENERATE["maximum_torque"].make(env).predict(observation)
    np.testing.assert_array_equal(action, np.ones(3, dtype=np.float32))
    env.close()


def test_press_the_stop_ends_with_the_slide_on_its_stop() -> None:
    env, _ = run("press_the_stop", "PRP-PoseRegulation-v0", {}, duration=2.0)
    slide = env.task.ground_truth_layout.split(env.ground_truth)["joint_position"][1]
    # the stop is a stiff spring: 100 N sink less than 2 mm into it
    assert slide == pytest.approx(-0.3, abs=2e-3)


def test_hover_touches_the_surface_once_and_stays_close_to_it() -> None:
    env, forces = run("hover", "PRP-Force-v0", WALL, duration=5.0, **FORCE)
    assert 0.0 < max(forces) < 2.0
    assert max(forces[-1000:]) == 0.0
    tip = env.task.ground_truth_layout.split(env.ground_truth)["end_effector_pose"][:3]
    height = -tip[1] - 0.44
    assert 0.0 < height < 4e-3  # it retreats by 2 mm


def test_hover_is_for_force_tasks_alone() -> None:
    def missing(environment_id: str) -> list[str]:
        env: Any = gymnasium.make(environment_id).unwrapped
        return DEGENERATE["hover"].policy.missing_fields(env.observation_layout)

    assert missing("PRP-Impedance-v0") == ["desired_force"]
    assert missing("PRP-Force-v0") == []
