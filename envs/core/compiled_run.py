"""Whole episodes of N environments in one call of compiled code."""

import ctypes
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.core.period_source import LARGEST_STATE, PeriodSource, Plan
from prp_gym.errors import UntraceableError
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.compiler import load_library


class EpisodeRecord(NamedTuple):
    """What happened in whole episodes of N environments.

    Attributes:
        ground_truth: Ground truth (N, T + 1, size).
        command: Commanded torque within the limits (N, T, joints) [N m, N, N m].
        applied: Applied torque (N, T, joints) [N m, N, N m].
        info: Values of `info` (N, T, fields).
        ended: Period (N), counted from 1, in which an environment diverged; 0 for none; negative where the
            action was not finite.
    """

    ground_truth: Array
    command: Array
    applied: Array
    info: Array
    ended: NDArray[np.intp]

    @classmethod
    def of(cls, loop: Any, periods: int) -> Self:
        """Room for episodes of a loop."""
        lead = (loop.num_envs, periods)
        return cls(
            np.empty((*lead, loop.ground_truth.shape[1])),
            np.empty((*lead, loop.joints)),
            np.empty((*lead, loop.joints)),
            np.empty((*lead, len(loop.info_fields))),
            np.zeros(loop.num_envs, dtype=np.intp),
        )


def run_episodes(loop: Any, source: PeriodSource, controller: Any, observation: Array) -> EpisodeRecord | None:
    """Run whole episodes with a compiled controller; afterwards the loop can only be reset.

    Args:
        loop: Loop of N environments with the compiled engine, all just reset.
        source: Compiled control periods of such environments.
        controller: `CompiledController`.
        observation: Observations (N, size).

    Returns:
        The episodes; None if the controller returned an action that is not finite.

    Raises:
        UntraceableError: a controller whose state is too large.
    """
    periods, parts = loop.config.horizon, loop.period_parts()
    if controller.initial_state.shape[1] > LARGEST_STATE:
        raise UntraceableError(f"a state of more than {LARGEST_STATE} numbers cannot be kept in compiled code.")
    record, present = EpisodeRecord.of(loop, periods), loop.ground_truth.copy()
    arrays = {
        **loop.physics.arrays,
        "task_numbers": source.numbers,
        "controller_numbers": controller.numbers,
        "input": np.zeros((loop.num_envs, 0)),
        "noise": parts.actuators.noise_ahead(periods),
        "reference": loop.references_ahead(periods),
        "error": parts.sensors.errors_ahead(periods),
        "clock": np.zeros(loop.num_envs),
        "memory": np.ascontiguousarray(source.rows.read(parts.owners)),
        "state": controller.initial_state.copy(),
        "action": np.zeros((loop.num_envs, loop.joints)),
        "observation": observation.copy(),
        "ground_truth": record.ground_truth,
        "command": record.command,
        "applied": record.applied,
        "info": record.info,
        "reward": np.empty((loop.num_envs, periods)),
        "ended": record.ended,
    }
    plan = Plan(controller=controller.function, world=ctypes.addressof(loop.physics.world))
    plan.rows, plan.periods, plan.record = loop.num_envs, periods, 1
    plan.state_size = controller.initial_state.shape[1]
    for name, values in arrays.items():
        setattr(plan, name, None if values is None else values.ctypes.data)
    function, address = load_library(source.text).prp_run, ctypes.byref(plan)
    loop.physics.run(
        lambda first, count: function(ctypes.c_long(first), ctypes.c_long(count), address),
        loop.config.substeps,
    )
    if (record.ended < 0).any():
        return None
    return record._replace(
        ground_truth=np.concatenate([present[:, None], record.ground_truth], axis=1)
    )
