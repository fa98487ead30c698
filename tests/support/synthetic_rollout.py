"""Recorded episodes written down as numbers."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from prp_gym.evaluation import Rollout

Array = NDArray[np.float64]
PERIOD = 0.1


def rollout_of(fields: dict[str, ArrayLike], torque: ArrayLike | None = None) -> Rollout:
    """A rollout of T steps with some fields (T + 1, size)."""
    arrays: dict[str, Array] = {name: np.array(values, dtype=np.float64) for name, values in fields.items()}
    steps = len(next(iter(arrays.values()))) - 1
    commanded = np.zeros((steps, 3)) if torque is None else np.array(torque, dtype=np.float64)
    return Rollout(
        environment_id="PRP-Test-v0",
        scenario="report",
        seed=0,
        period=PERIOD,
        duration=steps * PERIOD,
        fields=arrays,
        torque=commanded,
        applied_torque=commanded,
        reward=np.zeros(steps),
        info={},
        diverged=False,
        compute_time=np.zeros(steps),
        torque_limit=np.array([300.0, 800.0, 150.0]),
    )
