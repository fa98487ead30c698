"""`CompiledMode`: one step of an action mode, several periods of its inner controller, in compiled code."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.action_mode import ActionField, ActionMode, Memory
from prp_gym.envs.core.argument_checks import clip_actions
from prp_gym.envs.core.compiled_run import CompiledPeriods
from prp_gym.envs.core.period_plan import LARGEST_STATE
from prp_gym.envs.core.period_source import CONSTANTS
from prp_gym.envs.core.step import Step
from prp_gym.errors import UntraceableError
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.array import untraceable
from prp_gym.symbolic.compiled_method import CompiledMethod, of_arguments_alone
from prp_gym.symbolic.lifting import structure_of
from prp_gym.symbolic.nested_rows import NestedRows
from prp_gym.tasks.task import Task

_CONSTANTS = (*CONSTANTS, ActionField, Task)


class CompiledMode:
    """The step of an action mode in one call of compiled code, with the bits of the loop over its periods.

    The state of the compiled controller is the mode's memory, then whether an episode starts; its input is
    the action, which stays the same in all periods.

    Args:
        loop: Loop of N environments with the compiled engine, whose mode has been called before.
        mode: Action mode.
        periods: Compiled periods of the loop.
        shares: Factors of each number of `info` in the result of a step, then that of the reward.
        added: Whether such a result is the sum over the periods, for each number of `info`.
        count: Number of periods of a step.

    Attributes:
        periods: Compiled periods of the loop.

    Raises:
        UntraceableError: a mode that uses more than arithmetic on arrays, that keeps anything but its memory
            or a memory of something else than arrays, or that refers to the task.
        CompilerError: no compiler.
    """

    def __init__(
        self,
        loop: Any,
        mode: ActionMode,
        periods: CompiledPeriods,
        shares: Array,
        added: NDArray[np.bool_],
        count: int,
    ) -> None:
        self._loop, self._mode, self.periods, self._count = loop, mode, periods, count
        self._rows = NestedRows(loop.memory, loop.num_envs)
        self._method = self._compiled()
        rows, columns = loop.num_envs, self._rows.size + 1
        if columns > LARGEST_STATE:
            raise UntraceableError(f"a memory of {columns} numbers cannot be kept in compiled code.")
        self._given = periods.given.copy()
        give, plan = self._given.give, self._given.plan
        give({"shares": shares, "added": added.astype(np.float64), "state": np.zeros((rows, columns))})
        give({"step_info": np.zeros((rows, len(loop.info_fields))), "step_reward": np.zeros(rows)})
        give({"input": np.zeros((rows, loop.action_size)), "waiting": np.zeros(rows, dtype=np.bool_)})
        ahead = [name for name in ("noise", "error", "sampled") if name in periods.given.arrays]
        give({name: np.zeros((count, *periods.given.arrays[name].shape)) for name in ahead})
        give({"controller_numbers": self._method.numbers})
        plan.controller, plan.state_size, plan.input_size = self._method.function, columns, loop.action_size
        plan.periods = count
        self._arrays = self._given.arrays

    def _compiled(self) -> CompiledMethod:
        """The compiled controller of the mode."""
        loop, mode = self._loop, self._mode
        structure = structure_of(mode, _CONSTANTS)
        if any(isinstance(part, tuple) and part and _is_task(part[0]) for part in structure):
            raise untraceable(f"{type(mode).__name__}, which refers to the task of a running episode,")
        shapes = {
            "observation": (1, loop.task.layout.size),
            "state": (1, self._rows.size + 1),
            "input": (1, loop.action_size),
        }
        kind = "torque", self._rows.structure, loop.joints
        return CompiledMethod("prp_mode_torque", self._torque, mode, shapes, _CONSTANTS, kind)

    def _torque(self, mode: Any, observation: Any, state: Any, input: Any) -> dict[str, Any]:  # noqa: A002
        """The traced formula."""

        def call() -> list[Any]:
            memory, starts = self._rows.write(state[:, :-1]), state[:, -1] != 0.0
            torque, after = mode.torque(input.copy(), observation.copy(), memory, starts)
            return [torque, self._rows.read(after, 1)]

        torque, kept = of_arguments_alone(mode, call, observation)
        if torque.shape != (1, self._loop.joints):
            raise untraceable(f"torques of shape {torque.shape}")
        after = np.concatenate([kept, np.zeros((1, 1))], axis=1)
        return {"action": torque.astype(np.float64), "after": after}

    def load(self, memory: Memory) -> bool:
        """Take over the memory of the mode; whether it is one that the compiled code holds."""
        if not self._rows.fit(memory, self._loop.num_envs):
            return False
        self._arrays["state"][:, :-1] = self._rows.read(memory, self._loop.num_envs)
        return True

    def memory(self) -> Memory:
        """The memory of the mode."""
        return self._rows.write(self._arrays["state"][:, :-1])

    def step(
        self, action: Array, observation: Array, starts: NDArray[np.bool_], waiting: NDArray[np.bool_]
    ) -> Step:
        """Advance by the periods of an action; see `CompiledPeriods.step`.

        Args:
            action: Actions (N, action size) within ±1.
            observation: Fields of the task (N, size) as the sensors read them now.
            starts: Whether an episode starts (N).
            waiting: Environments (N) that are left as they are, and whose results have no meaning.

        Raises:
            NonFiniteError: NaN or infinity in the torques of the inner controller.
        """
        loop, arrays = self._loop, self._arrays
        arrays["input"][:], arrays["observation"][:] = action, observation
        arrays["state"][:, -1], arrays["waiting"][:] = starts, waiting
        for name, values in self.periods.drawn_ahead(self._count).items():
            arrays[name][:] = values
        if "sampled" in arrays:
            for row in arrays["sampled"]:
                loop.window.advance(loop.task.reference)
                row[:] = loop.window.current
        self.periods.run(self._given)
        if np.count_nonzero(arrays["ended"] < 0):
            clip_actions(arrays["action"])  # which refuses them by name
        return self.periods.outcome(arrays["step_reward"], arrays["step_info"])


def _is_task(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, Task)
