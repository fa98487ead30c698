"""Helpers for tests of the contact tasks: environments, their episodes, their surfaces."""

from typing import Any

import gymnasium
import numpy as np

import prp_gym
from prp_gym.envs import PRPEnv
from prp_gym.envs.base.contact_starts import ContactStart, ContactWorld
from prp_gym.envs.tasks.force_position import ReachWaypoints
from prp_gym.evaluation.rollout import Policy
from prp_gym.robot import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.tasks import Constant, QuinticWaypoints, Trajectory
from prp_gym.tasks.task import Task
from tests.support.drawn_starts import drawn_start

ARM = PRPArm()
KOLMOGOROV = 1.95  # of sqrt(n) D, exceeded once in a thousand samples


def environment(environment_id: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


CONTACT_IDS = [
    name for name in prp_gym.list_envs() if "contact_force" in environment(name).observation_layout.names
]


def task_of(environment_id: str, scenario: str = "randomized", **keywords: Any) -> Task:
    task = environment(environment_id, scenario=scenario, **keywords).task
    assert isinstance(task.parts.world, ContactWorld)
    return task


def draw(task: Task, seed: int, **options: Any) -> ContactStart:
    start = drawn_start(task, seed, options)
    assert isinstance(start, ContactStart)
    return start


def ground_truth_of(env: PRPEnv) -> dict[str, Array]:
    parts: dict[str, Array] = env.task.ground_truth_layout.split(env.ground_truth)
    return parts


def joint_targets(trajectory: Trajectory) -> Array:
    """Joint positions through which a reference leads (K, 3)."""
    if isinstance(trajectory, Constant):
        return trajectory.position
    assert isinstance(trajectory, (QuinticWaypoints, ReachWaypoints))
    targets: Array = trajectory.sample(trajectory.times.T)[:, 0, :3]
    return targets


def joint_path(trajectory: Trajectory) -> Array:
    """Joint positions (100, 3) along a reference, over the longest episode's 5 s."""
    path: Array = trajectory.sample(np.linspace(0.0, 5.0, 100)[:, None])[:, 0, :3]
    return path


def depth_of(start: ContactStart, joint_position: Array) -> Array:
    """Depth (...) [m] of the tip below a start's surface, by forward kinematics along the normal."""
    tip = ARM.forward_kinematics(joint_position)[..., :3]
    depth: Array = start.surface.offset[0] - tip @ start.surface.normal[0]
    return depth


def side_by_side(policy: Policy, env: PRPEnv, **options: Array) -> dict[str, Array]:
    """Ground truth (T, N, size) by field, of episodes whose reset options have one value for each (N, ...).

    An episode's first sample is that after its first period.
    """
    count = len(next(iter(options.values())))
    loop, rngs = env.make_loop(count), [np.random.default_rng(0) for _ in range(count)]
    observation = loop.reset(np.arange(count), rngs, options)
    state, starts, samples = None, np.ones(count, dtype=np.bool_), []
    for _ in range(env.config.horizon):
        action, state = policy.predict(observation, state, episode_start=starts)
        step = loop.step(np.asarray(action, dtype=np.float64))
        assert not step.terminated.any()
        observation, starts = step.observation, np.zeros(count, dtype=np.bool_)
        samples.append(loop.ground_truth.copy())
    parts: dict[str, Array] = env.task.ground_truth_layout.split(np.array(samples))
    return parts


def assert_force(found: Array, expected: object, rtol: float = 3e-3, atol: float = 5e-3) -> None:
    """Compare contact forces [N] in motion, up to the 0.13 g that the solver adds to the tip.

    Free links accelerate at some 20 m/s² under gravity and, in a surface, at force over the least mass of the
    tip, 0.07 kg: 2e-3 of the force.
    """
    np.testing.assert_allclose(found, np.asarray(expected, dtype=np.float64), rtol=rtol, atol=atol)
