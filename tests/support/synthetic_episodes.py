"""Motions and episodes written down as numbers, whose metrics are known beforehand."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.evaluation import Rollout

Array = NDArray[np.float64]

PERIOD = 0.01
SAMPLES = 101
TIME: Array = np.arange(SAMPLES, dtype=np.float64) * PERIOD
GOAL = np.array([1.0, -0.2, 2.0])
ROUNDING = 1e-12  # sums of a few hundred numbers up to 100


def reference(goal: Array = GOAL) -> Array:
    return np.tile(goal, (SAMPLES, 1))


def jump(sample: int, goal: Array = GOAL, residue: float = 0.0) -> Array:
    """At home before a sample; from it on at the goal but for a share of the step."""
    actual = np.zeros((SAMPLES, 3))
    actual[sample:] = goal * (1.0 - residue)
    return actual


def random_motions(seed: int, *leading: int) -> tuple[Array, Array]:
    """Motions that approach constant goals, (..., SAMPLES, 3)."""
    rng = np.random.default_rng(seed)
    goal = rng.uniform(-2.0, 2.0, size=(*leading, 1, 3))
    rate = rng.uniform(2.0, 20.0, size=(*leading, 1, 3))
    wiggle = rng.uniform(-0.1, 0.1, size=(*leading, 1, 3)) * np.sin(9.0 * TIME)[:, None]
    decay = np.exp(-rate * TIME[:, None])
    return goal * (1.0 - decay) + wiggle * decay, np.broadcast_to(goal, (*leading, SAMPLES, 3)).copy()


def make_rollout(fields: Mapping[str, Array], joints: int = 3, **changes: Any) -> Rollout:
    """An episode with given fields, constant torques and a score of 0.6.

    Joints are saturated 0, 1, 2, 3, 0, ... at a time, and the first quarter of a second meets one stop.
    """
    steps = len(next(iter(fields.values()))) - 1
    torque = np.tile([10.0, -20.0, 3.0][:joints], (steps, 1))
    content: dict[str, Any] = {
        "environment_id": "PRP-JointTracking-v0",
        "scenario": "randomized",
        "seed": 0,
        "period": PERIOD,
        "duration": steps * PERIOD,
        "fields": fields,
        "torque": torque,
        "applied_torque": torque,
        "reward": np.full(steps, 0.6),
        "info": {
            "cost_saturation": np.arange(steps) % (joints + 1),
            "cost_joint_stop": (np.arange(steps) < 25).astype(float),
        },
        "diverged": False,
        "compute_time": np.full(steps, 1e-5),
        "torque_limit": np.array([300.0, 800.0, 150.0])[:joints],
    }
    return Rollout(**{**content, **changes})


def joint_fields(actual: Array, desired: Array) -> dict[str, Array]:
    """What a joint task records; the joints turn at 1 rad/s, -0.5 m/s, 2 rad/s whatever the positions."""
    speed = np.tile([1.0, -0.5, 2.0][: actual.shape[-1]], (len(actual), 1))
    return {"joint_position": actual, "joint_velocity": speed, "desired_joint_position": desired}


def pose(position: Array, angles: Array) -> Array:
    """(T, 3) [m] and (T, 2) [rad] -> (T, 6), γ constant."""
    return np.concatenate([position, angles, np.full((len(position), 1), np.pi / 2)], axis=-1)


def assert_batch_equals_loop(function: Callable[..., NDArray[Any]], *arrays: Array) -> None:
    """A function of arrays (2, 4, ...) gives for all at once what it gives one by one."""
    together = function(*arrays)
    assert together.shape[:2] == (2, 4)
    for index in np.ndindex(2, 4):
        # sums over other strides may round differently
        alone = function(*(array[index] for array in arrays))
        np.testing.assert_allclose(together[index], alone, rtol=ROUNDING, atol=ROUNDING)
