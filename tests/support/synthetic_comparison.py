"""Records of a comparison that never ran: realistic in size, and with known differences."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def learning(
    scores: Sequence[float], steps: Sequence[int] = (), scenario: str = "randomized", frequency: float = 50.0
) -> dict[str, Any]:
    """A history with a point every 1000 steps and 10 s, and a violation more at each."""
    count = len(scores)
    return {
        "scenario": scenario,
        "control_frequency": frequency,
        "steps": list(steps) or [1000 * (index + 1) for index in range(count)],
        "seconds": [10.0 * (index + 1) for index in range(count)],
        "score": list(scores),
        "violations": [float(index + 1) for index in range(count)],
    }


def record(
    policy: str,
    scores: Sequence[float] | Array,
    kind: str = "controller",
    environment_id: str = "PRP-JointTracking-v0",
    scenario: str = "randomized",
    **changes: Any,
) -> dict[str, Any]:
    """A policy's record; its joint error is 0.1 times what its score lacks to 1."""
    values = np.asarray(scores, dtype=np.float64)
    error = 0.1 * (1.0 - values)[:, None]
    metrics: Mapping[str, Array] = {
        "score": values[:, None],
        "divergence": np.zeros((len(values), 1)),
        "joint_rmse": error * [1.0, 0.5, 2.0],
        "joint_mean_error": error * [1.0, 0.5, 2.0],
        "energy": 20.0 + error,
    }
    plain = {
        "environment": environment_id,
        "scenario": scenario,
        "baseline": policy,
        "policy": policy,
        "kind": kind,
        "mode": "torque",
        "training_seed": -1,
        "history": {},
        "settings": {},
        "control_period": 0.002,
        "duration": 5.0,
        "seeds": list(range(len(values))),
        "episodes": {name: metric.tolist() for name, metric in metrics.items()},
        "compute_time_per_step": 1e-4,
    }
    return {**plain, **changes}


def agents(policy: str, scores: Array, **changes: Any) -> list[dict[str, Any]]:
    """Records of an agent group, one a row of scores."""
    return [
        record(policy, row, "agent", **{"training_seed": index, "history": learning([row.mean()]), **changes})
        for index, row in enumerate(scores)
    ]
