"""`CompiledPeriods`: control periods of N environments in one call of compiled code."""

import ctypes
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.core.argument_checks import limit_actions
from prp_gym.envs.core.episode_record import EpisodeRecord
from prp_gym.envs.core.period_source import LARGEST_STATE, PeriodSource, Plan
from prp_gym.envs.core.step import Step
from prp_gym.errors import UntraceableError
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.compiler import load_library


class CompiledPeriods:
    """The control periods of a loop in compiled code.

    Between `load` and `store` the compiled code's copy of what task and actuators keep is the present one.

    Args:
        loop: Loop of N environments with the compiled engine, all of which have been reset.

    Raises:
        UntraceableError: a task whose formulas cannot be traced.
    """

    def __init__(self, loop: Any) -> None:
        self._loop = loop
        self._source = PeriodSource(loop)
        self._largest = np.ones((loop.num_envs, loop.joints))
        self._function = load_library(self._source.text).prp_run
        self._plan = Plan(world=ctypes.addressof(loop.physics.world), rows=loop.num_envs, periods=1)
        self._address, self._arrays = ctypes.byref(self._plan), dict[str, NDArray[Any]]()
        rows, layout = loop.num_envs, loop.task.layout
        columns = {"action": loop.joints, "command": loop.joints, "applied": loop.joints}
        columns |= {"memory": self._source.rows.size}
        parts = loop.period_parts()
        if parts.actuators.noise_ahead(0) is not None:
            columns["noise"] = loop.joints
        if parts.sensors.errors_ahead(0) is not None:
            columns["error"] = 3
        columns |= {"observation": layout.size, "reference": layout.size - loop.physics.measurement_size}
        columns |= {"info": len(loop.info_fields), "ground_truth": loop.task.ground_truth_layout.size}
        if self._source.references is not None:
            columns["reference_numbers"] = self._source.references.size
        self._set({name: np.zeros((rows, size)) for name, size in columns.items()})
        self._set({"clock": np.zeros(rows), "reward": np.zeros(rows), "ended": np.zeros(rows, dtype=np.intp)})
        self._set({**loop.physics.arrays, "task_numbers": self._source.numbers})

    def _set(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Give arrays to the compiled code, and keep them."""
        for name, values in arrays.items():
            self._arrays[name] = np.ascontiguousarray(values)
            setattr(self._plan, name, self._arrays[name].ctypes.data)

    def load(self) -> None:
        """Take over what the loop's parts keep, after a reset or a restored state."""
        loop, arrays, references = self._loop, self._arrays, self._source.references
        arrays["memory"][:] = self._source.rows.read(loop.period_parts().owners)
        arrays["clock"][:], arrays["reference"][:] = loop.window.elapsed, loop.window.current
        arrays["ground_truth"][:] = loop.ground_truth
        if references is None:
            self._set({"sampled": arrays["reference"]})
        else:
            arrays["reference_numbers"][:] = references.read(loop.task.parts.reference)
            loop.window.hold(arrays["clock"], arrays["reference"])

    def store(self) -> None:
        """Hand back what the loop's parts keep."""
        self._source.rows.write(self._loop.period_parts().owners, self._arrays["memory"])

    def step(self, action: Array) -> Step:
        """Advance by one period; the observations are the fields of the task.

        An environment that was lost before is left as it is, and its results have no meaning.

        Args:
            action: Actions (N, joints).

        Raises:
            NonFiniteError: NaN or infinity in an action; nothing is changed.
        """
        loop, arrays, parts = self._loop, self._arrays, self._loop.period_parts()
        limit_actions(action, self._largest)
        if self._source.references is None:
            loop.window.advance(loop.task.reference)
            arrays["sampled"][:] = loop.window.current
        arrays["action"][:] = action
        for name, values in (
            ("noise", parts.actuators.noise_ahead(1)),
            ("error", parts.sensors.errors_ahead(1)),
        ):
            if values is not None:
                arrays[name][:] = values[0]
        self._run()
        loop.ground_truth, loop.commanded_torque = arrays["ground_truth"].copy(), arrays["command"].copy()
        observation, reward = arrays["observation"].copy(), arrays["reward"].copy()
        truncated = arrays["clock"] >= loop.config.horizon
        return Step(observation, reward, np.zeros_like(truncated), truncated, arrays["info"].copy())

    def _run(self) -> None:
        plan, function = self._address, self._function
        self._loop.physics.run(
            lambda first, count: function(ctypes.c_long(first), ctypes.c_long(count), plan),
            self._loop.config.substeps,
        )

    def run_episodes(self, controller: Any, observation: Array) -> EpisodeRecord | None:
        """Run whole episodes with a compiled controller; afterwards the loop cannot be used.

        Args:
            controller: `CompiledController`.
            observation: Observations (N, size) after the reset of all environments.

        Returns:
            The episodes; None if the controller returned an action that is not finite.

        Raises:
            UntraceableError: a controller whose state is too large.
        """
        loop, plan, parts = self._loop, self._plan, self._loop.period_parts()
        size, periods = controller.initial_state.shape[1], loop.config.horizon
        if size > LARGEST_STATE:
            raise UntraceableError(f"a state of {size} numbers cannot be kept in compiled code.")
        record = EpisodeRecord.of(loop, periods)
        if self._source.references is None:
            times = loop.window.times_ahead(periods)
            self._set({"sampled": np.ascontiguousarray(loop.task.reference(times))})
        for name, values in (
            ("noise", parts.actuators.noise_ahead(periods)),
            ("error", parts.sensors.errors_ahead(periods)),
        ):
            if values is not None:
                self._set({name: np.ascontiguousarray(values)})
        self._set({"controller_numbers": controller.numbers, "state": controller.initial_state.copy()})
        self._set({"ground_truth": record.ground_truth, "command": record.command, "info": record.info})
        self._set({"applied": record.applied, "reward": np.empty(record.info.shape[:2])})
        self._set({"observation": observation.copy(), "ended": record.ended})
        plan.controller, plan.state_size, plan.periods, plan.record = controller.function, size, periods, 1
        self._run()
        start = loop.ground_truth[:, None]
        if (record.ended < 0).any():
            return None
        return record._replace(ground_truth=np.concatenate([start, record.ground_truth], axis=1))
