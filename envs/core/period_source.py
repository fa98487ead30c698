"""The C source of control periods: actuators, sensors, errors and reward, traced, around the physics."""

import ctypes
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from prp_gym.envs.core.argument_checks import limit_actions
from prp_gym.envs.core.period_parts import PeriodParts, ReferenceRows
from prp_gym.errors import UntraceableError
from prp_gym.physics.compiled_simulation import WORLD, CompiledSimulation
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import zeros
from prp_gym.robot.link import Link
from prp_gym.symbolic.c_source import PREAMBLE, c_function
from prp_gym.symbolic.function import SymbolicFunction, trace
from prp_gym.symbolic.lifting import numbers_of, trace_method
from prp_gym.symbolic.state_arrays import StateRows, attributes
from prp_gym.tasks.fields import ObservationLayout

CONSTANTS = (PRPArm, Link, ObservationLayout)
"""Classes of objects whose numbers are constants of compiled code."""

LARGEST_STATE = 256
"""Largest number of components of a controller's state."""

CONTROLLER = ctypes.CFUNCTYPE(None, *(ctypes.c_void_p,) * 6)
"""A compiled controller: observation, state, input and numbers -> action and state."""

_ARRAYS = (
    *("position", "velocity", "torque", "plants", "surfaces", "measured", "beyond"),
    *("task_numbers", "reference_numbers", "controller_numbers", "input"),
    *("noise", "error", "sampled", "reference"),
    *("clock", "memory", "state", "action", "saturated", "observation"),
    *("ground_truth", "command", "applied", "info", "reward", "total"),
)
_COUNTS = ("rows", "periods", "record", "state_size", "input_size", "numbers_size")
_HAND_WRITTEN = Path(__file__).with_name("compiled_period.c")


class Plan(ctypes.Structure):
    """`prp_plan` of the C code: the arrays of N environments, and what is to be done.

    Attributes:
        controller: function that chooses the actions; null where they are given.
        world: world of the simulations.
        lost: whether an environment was lost, see `prp_advance`.
        ended: see `prp_run`.
        rows: number of environments.
        periods: number of periods.
        record: whether every period is recorded.
        state_size: size of the controller's state.
        input_size: size of an environment's input to the controller.
        numbers_size: distance between the controller's numbers of two environments, 0 if they share them.
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
        ground_truth: recorded ground truth, of every period in the rows of an environment.
        command: recorded torque command.
        applied: recorded applied torques.
        info: recorded `info`.
        reward: recorded reward.
        total: sum of each environment's rewards, to which every period adds its own; null for none.
    """

    _fields_: ClassVar = [
        *((name, ctypes.c_void_p) for name in ("controller", "world", "lost", "ended")),
        *((name, ctypes.c_long) for name in _COUNTS),
        *((name, ctypes.c_void_p) for name in _ARRAYS),
    ]


def _plan_text() -> str:
    """`Plan` in C."""
    arrays = ", ".join(f"*{name}" for name in _ARRAYS)
    return f"""
typedef void (*prp_controller)(
    const double *observation, const double *state, const double *input, const double *numbers,
    double *action, double *after);
typedef struct {{
    prp_controller controller;
    const prp_world *world;
    unsigned char *lost;
    long *ended;
    long {", ".join(_COUNTS)};
    double {arrays};
}} prp_plan;
"""


class PeriodSource:
    """Compiled control periods of a task in certain conditions.

    Args:
        loop: loop of such environments, all of which have been reset.

    Attributes:
        numbers: numbers of the task (P).
        rows: rows of what task and actuators keep from one period to the next.
        references: rows of the references; None where these are sampled ahead: with MuJoCo's physics, and
            where they cannot be traced.
        is_exact: whether every machine gives the bits of NumPy.
        actuate: from actions to torques.
        judge: from the measurement to ground present, observation, reward and `info`.
        text: C source with the functions `prp_command` and `prp_score`, and with `prp_run` if the physics is
            compiled, too.

    Raises:
        UntraceableError: errors that use more than arithmetic on arrays, or keep undeclared values.
    """

    def __init__(self, loop: Any) -> None:
        task, measured = loop.task, loop.physics.measurement_size
        self._parts = loop.period_parts().formulas()
        self._period = 1.0 / loop.config.control_frequency
        self.rows = StateRows(loop.period_parts().owners)
        self._sizes = {
            "joints": loop.joints,
            "measured": measured,
            "reference": task.layout.size - measured,
            "observed": task.layout.size,
            "ground_truth": task.ground_truth_layout.size,
            "info": len(loop.info_fields),
            "memory": self.rows.size,
            "largest_state": LARGEST_STATE,
            "physics": int(isinstance(loop.physics, CompiledSimulation)),
        }
        self._kind = tuple(self._sizes.items()), tuple(map(repr, self.rows.arrays))
        self.numbers = numbers_of(self._parts, CONSTANTS)
        self.references: ReferenceRows | None = None
        self.actuate, self.judge = self._traced_actuators(), self._traced_judge()
        functions = [self.actuate, self.judge]
        if self._sizes["physics"]:
            functions += self._traced_reference(task)
        self._sizes["reference_numbers"] = self.references.size if self.references else 0
        self.is_exact = all(function.is_exact for function in functions)
        physics = loop.physics.source if self._sizes["physics"] else f"{PREAMBLE}\n{WORLD}"
        self.text = self._source(physics, functions)

    def _source(self, physics: str, functions: Sequence[SymbolicFunction]) -> str:
        sizes = "".join(f"#define PRP_{name.upper()} {size}\n" for name, size in self._sizes.items())
        loop = _HAND_WRITTEN.read_text(encoding="utf-8")
        return "\n".join(
            ["#include <string.h>", physics, sizes, _plan_text(), *map(c_function, functions), loop]
        )

    def _traced_reference(self, task: Any) -> list[SymbolicFunction]:
        """From time to reference, where it can be traced and branches on none of its numbers."""
        with suppress(UntraceableError):
            rows = ReferenceRows(task.parts.reference)

            def refer(clock: Any, row: Any) -> Mapping[str, Any]:
                return {"reference": rows.formula(row).sample(clock * self._period)}

            function = trace("prp_refer", refer, {"clock": (1,), "row": (1, rows.size)})
            self.references = rows
            return [function]
        return []

    def _traced_actuators(self) -> SymbolicFunction:
        """From actions to torques."""
        joints = self._sizes["joints"]

        def actuate(parts: PeriodParts, action: Any, noise: Any, memory: Any) -> Mapping[str, Any]:
            with self._kept(parts, memory) as kept:
                within, saturated = limit_actions(action, np.ones((1, joints)))
                command = within * parts.torque_limit
                torque = parts.actuators.transmit(command, noise)
            flags: Any = saturated
            results = {"command": command, "torque": torque, "saturated": flags.astype(np.float64)}
            return {**results, "after": kept()}

        shapes = {"action": (1, joints), "noise": (1, joints), "memory": (1, self.rows.size)}
        return trace_method("prp_actuate", actuate, self._parts, shapes, CONSTANTS, self._kind).function

    def _traced_judge(self) -> SymbolicFunction:
        """From the measurement to ground present, observation, reward and `info`."""
        sizes = self._sizes

        def judge(parts: PeriodParts, memory: Any, **given: Any) -> Mapping[str, Any]:
            present = zeros((1, sizes["ground_truth"]), memory)
            present[:, : sizes["measured"]] = given["measured"]
            present[:, sizes["measured"] : sizes["observed"]] = given["reference"]
            with self._kept(parts, memory) as kept:
                parts.errors.advance(present)
                parts.errors.complete(present)
            errors = parts.errors.errors(present, given["command"])
            reward, info = parts.scoring(errors, present, given["saturated"], given["clock"], given["beyond"])
            parts.scoring.zero_reward(reward, info, given["ended"] != 0.0)
            observation = present[:, : sizes["observed"]].copy()
            parts.sensors.disturb(observation, given["error"])
            results = {"ground_truth": present, "observation": observation, "reward": reward, "info": info}
            return {**results, "after": kept()}

        joints: tuple[int, ...] = (1, sizes["joints"])
        shapes: dict[str, tuple[int, ...]] = {
            "measured": (1, sizes["measured"]),
            "reference": (1, sizes["reference"]),
        }
        shapes |= {"command": joints, "saturated": joints, "clock": (1,), "beyond": joints, "ended": (1,)}
        shapes |= {"error": (1, 3), "memory": (1, sizes["memory"])}
        return trace_method("prp_judge", judge, self._parts, shapes, CONSTANTS, self._kind).function

    @contextmanager
    def _kept(self, parts: PeriodParts, memory: Any) -> Iterator[Callable[[], Any]]:
        """Give parts what they keep, yield a reader of it, and refuse any other change of them."""
        self.rows.write(parts.owners, memory)
        before = [attributes(owner) for owner in parts.owners]
        yield lambda: self.rows.read(parts.owners)
        self.rows.require_unchanged(parts.owners, before)
