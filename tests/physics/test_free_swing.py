"""Without torques the environment is Pinocchio's arm, integrated by the same rule."""

from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.envs import PRPEnv
from tests.support.pinocchio_model import PinocchioArm

Vector3 = tuple[float, float, float]
TIMESTEP = 1e-3
DURATION = 2.0
STILL = np.zeros(3)


def environment(**keywords: Any) -> PRPEnv:
    env = gymnasium.make("PRP-JointRegulation-v0", scenario="report", duration=DURATION, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


@pytest.mark.parametrize("rate", [1000, 500, 50])
@pytest.mark.parametrize(
    ("start", "speed"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((0.3, -0.1, -0.5), (1.0, 0.3, -2.0)),
        ((-2.0, -0.25, 2.5), (-0.5, 0.1, 3.0)),
    ],
)
def test_free_swing_follows_pinocchio_under_semi_implicit_euler(
    start: Vector3, speed: Vector3, rate: int
) -> None:
    oracle, env = PinocchioArm(), environment(control_frequency=rate)
    env.reset(seed=0, options={"joint_position": start, "joint_velocity": speed})
    q, velocity = np.array(start), np.array(speed)
    layout, truncated, steps, swing = env.observation_layout, False, 0, 0.0
    while not truncated:
        for _ in range(1000 // rate):
            velocity = velocity + TIMESTEP * oracle.forward_dynamics(q, velocity, STILL, STILL)
            q = q + TIMESTEP * velocity
        observation, _, _, truncated, _ = env.step(STILL)
        parts = layout.split(observation)
        # roundings of 1e-15 a substep, carried along for 2000 substeps: measured below 1e-11
        np.testing.assert_allclose(parts["joint_position"], q, rtol=0, atol=1e-9)
        np.testing.assert_allclose(parts["joint_velocity"], velocity, rtol=0, atol=1e-9)
        tip = oracle.tip_transform(q)[:3, 3]
        np.testing.assert_allclose(parts["end_effector_pose"][:3], tip, rtol=0, atol=1e-9)
        steps += 1
        swing = max(swing, float(np.abs(q - start).max()))
    assert steps == DURATION * rate
    assert swing > 1.0  # [rad]: it did move
