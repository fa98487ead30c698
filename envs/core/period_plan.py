"""What compiled control periods are given: a structure of the C code, with the arrays to which it points."""

import ctypes
from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

LARGEST_STATE = 256
"""Largest number of components of a controller's state."""

_ARRAYS = (
    *("position", "velocity", "torque", "plants", "surfaces", "measured", "beyond"),
    *("task_numbers", "reference_numbers", "controller_numbers", "input"),
    *("noise", "error", "sampled", "reference"),
    *("clock", "memory", "state", "action", "saturated", "observation"),
    *("ground_truth", "command", "applied", "info", "reward", "total"),
    *("recorded_fields", "recorded_command", "recorded_applied", "recorded_info"),
    *("shares", "added", "step_info", "step_reward"),
)
_OTHERS = ("controller", "world", "lost", "waiting", "ended", "truncated")
_COUNTS = ("rows", "periods", "state_size", "input_size", "numbers_size")


class Plan(ctypes.Structure):
    """`prp_plan` of the C code: the arrays of N environments, and what is to be done.

    Attributes:
        controller: function that chooses the actions; null where they are given.
        world: world of the simulations.
        lost: whether an environment was lost, see `prp_advance`.
        waiting: whether an environment is left as it is; null for none.
        ended: see `prp_run`.
        truncated: whether the duration of the episode is over.
        rows: number of environments.
        periods: number of periods.
        state_size: size of the controller's state.
        input_size: size of an environment's input to the controller.
        numbers_size: distance between the controller's numbers of two environments, 0 if they share them.
        period: control period [s].
        position: arrays of the simulations, to `beyond`; see `prp_advance`.
        task_numbers: numbers of the task.
        reference_numbers: numbers of each environment's reference.
        controller_numbers: numbers of the controller.
        input: input of the controller, which stays the same in all periods.
        noise: torque noise of every period; null without any.
        error: error of the force sensor in every period; null without any.
        sampled: reference of every period; null where it is computed.
        reference: present reference.
        clock: control periods since the start of each episode.
        memory: what task and actuators keep from one period to the next.
        state: state of the controller.
        action: actions.
        saturated: whether an action is at a limit of its actuator, 0 or 1.
        observation: observations.
        ground_truth: ground truth of the last period.
        command: torque command of the last period.
        applied: applied torques of the last period.
        info: `info` of the last period.
        reward: reward of the last period.
        total: sum of each environment's rewards, to which every period adds its own; null for none.
        recorded_fields: fields of the ground truth at the start and after every period; see `EpisodeRecord`,
            as for the other recorded arrays, all of which are null where nothing is recorded.
        recorded_command: torque commands.
        recorded_applied: applied torques.
        recorded_info: numbers of `info`.
        shares: factors of each number of `info`, then that of the reward, in the results of a step over all
            periods; null where these are not computed.
        added: whether such a result is the sum over the periods, 0 or 1, for each number of `info`; the
            others are those of the last period.
        step_info: `info` of such a step.
        step_reward: reward of such a step.
    """

    _fields_: ClassVar = [
        *((name, ctypes.c_void_p) for name in _OTHERS),
        *((name, ctypes.c_long) for name in _COUNTS),
        ("period", ctypes.c_double),
        *((name, ctypes.c_void_p) for name in _ARRAYS),
    ]


PLAN = f"""
typedef void (*prp_controller)(
    const double *observation, const double *state, const double *input, const double *numbers,
    double *action, double *after);
typedef struct {{
    prp_controller controller;
    const prp_world *world;
    unsigned char *lost;
    const unsigned char *waiting;
    long *ended;
    unsigned char *truncated;
    long {", ".join(_COUNTS)};
    double period;
    double {", ".join(f"*{name}" for name in _ARRAYS)};
}} prp_plan;
"""
"""`Plan` in C."""


class PeriodPlan:
    """A plan, and the arrays to which it points.

    Args:
        plan: the plan.
        arrays: arrays to which it points already, by name.

    Attributes:
        plan: the plan.
        arrays: arrays by name.
        address: what functions of the C code take.
    """

    def __init__(self, plan: Plan, arrays: Mapping[str, NDArray[Any]]) -> None:
        self.plan, self.arrays = plan, dict(arrays)
        self.address = ctypes.byref(plan)

    def give(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Give arrays by name to the compiled code, and keep them."""
        for name, values in arrays.items():
            self.arrays[name] = np.ascontiguousarray(values)
            setattr(self.plan, name, self.arrays[name].ctypes.data)

    def copy(self) -> Self:
        """Another plan for the same arrays."""
        return type(self)(Plan.from_buffer_copy(self.plan), self.arrays)
