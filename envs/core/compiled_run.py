"""`CompiledPeriods`: control periods of N environments in one call of compiled code."""

import ctypes
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.core.argument_checks import clip_actions
from prp_gym.envs.core.period_parts import TaskConstants
from prp_gym.envs.core.period_plan import LARGEST_STATE, PeriodPlan, Plan
from prp_gym.envs.core.period_source import PeriodSource
from prp_gym.envs.core.single_period import SingleCompiledPeriod, SingleMujocoPeriod, SinglePeriod
from prp_gym.envs.core.step import Step
from prp_gym.errors import UntraceableError
from prp_gym.physics.compiled_simulation import CompiledSimulation
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.compiler import load_library
from prp_gym.tasks.episode_record import EpisodeRecord
from prp_gym.tasks.episode_totals import EpisodeTotals

_GIVEN = ("noise", "error", "sampled")
"""What compiled code may be given for every period besides the actions."""


class CompiledPeriods:
    """The control periods of a loop in compiled code.

    Between `load` and `store` the compiled code's copy of what task and actuators keep is the present one.

    Args:
        loop: Loop of N environments with the compiled engine, all of which have been reset.

    Attributes:
        given: What the compiled code is given.
        simulates: Whether it simulates, too.
        single: The period of a single environment in one call; None where there are several environments, or
            where the period takes more than its action.

    Raises:
        UntraceableError: a task whose formulas cannot be traced.
    """

    def __init__(self, loop: Any) -> None:
        self._loop, self._source = loop, self._make_source(loop)
        self.simulates = isinstance(loop.physics, CompiledSimulation)
        if not (self.simulates or self._source.has_bits_of_numpy):
            raise UntraceableError("formulas whose bits depend on the machine are left to NumPy.")
        self._constant = TaskConstants(loop.task.parts)
        self._library = load_library(self._source.text)
        if self.simulates:
            self._library.prp_run.argtypes = (ctypes.c_long, ctypes.c_long, ctypes.c_void_p)
        config = loop.config
        plan = Plan(rows=loop.num_envs, periods=1, period=1.0 / config.control_frequency)
        self._substeps = config.substeps
        self.given = PeriodPlan(plan, {})
        self._set, self._arrays, self._address = self.given.give, self.given.arrays, self.given.address
        self._parts = loop.period_parts()
        rows, parts = loop.num_envs, self._parts
        joints = ("torque", "beyond", "action", "saturated", "command", "applied")
        columns = dict.fromkeys(joints, loop.joints)
        columns |= {"measured": loop.physics.measurement_size, "memory": self._source.rows.size}
        columns |= {"observation": loop.task.layout.size, "info": len(loop.info_fields)}
        columns |= {"reference": loop.task.layout.size - loop.physics.measurement_size}
        columns |= {"ground_truth": loop.task.ground_truth_layout.size}
        if parts.actuators.noise_ahead(0) is not None:
            columns["noise"] = loop.joints
        if parts.sensors.errors_ahead(0) is not None:
            columns["error"] = 3
        if self._source.references is not None:
            columns["reference_numbers"] = self._source.references.size
        self._set({name: np.zeros((rows, size)) for name, size in columns.items()})
        self._set({"clock": np.zeros(rows), "reward": np.zeros(rows), "ended": np.zeros(rows, dtype=np.intp)})
        self._set({"lost": np.zeros(rows, dtype=np.uint8), "task_numbers": self._source.numbers})
        self._set({"truncated": np.zeros(rows, dtype=np.bool_)})
        self._readings: ctypes.Structure | None = None
        if self.simulates:
            self.given.plan.world = ctypes.addressof(loop.physics.world)
            self._set(loop.physics.arrays)
        self._is_lost = self._arrays["lost"].view(np.bool_)

    def _make_source(self, loop: Any) -> PeriodSource:
        """The C source of these periods."""
        return PeriodSource(loop)

    def load(self) -> None:
        """Take over what the loop's parts keep, after a reset.

        Raises:
            UntraceableError: a task that has changed otherwise; nothing is taken over.
        """
        loop, arrays = self._loop, self._arrays
        self._constant.check(loop.task.parts)
        arrays["clock"][:], arrays["reference"][:] = loop.window.elapsed, loop.window.current
        arrays["ground_truth"][:], arrays["command"][:] = loop.ground_truth, loop.commanded_torque
        self._take_over()
        if self._source.references is None:
            self._set({"sampled": arrays["reference"].copy()})
        arrays["truncated"][:] = self._parts.scoring.truncated(arrays["clock"])

    def begin(self, ids: NDArray[np.intp]) -> bool:
        """Begin new episodes in some environments (n), once their parts and the physics have done so.

        Returns:
            Whether compiled code has done so; if not, NumPy has to, and nothing has changed.

        Raises:
            UntraceableError: see `load`.
        """
        loop, arrays = self._loop, self._arrays
        if not self._source.begins:
            return False
        self._constant.check(loop.task.parts)
        arrays["clock"][ids], arrays["truncated"][ids] = 0.0, False
        if not self.simulates:
            loop.physics.measure(arrays["measured"])
        self._take_over()
        self._library.prp_begin(self._address)
        return True

    def _take_over(self) -> None:
        """Take over what differs between episodes, and keep clock, reference, ground truth and command."""
        loop, arrays, source = self._loop, self._arrays, self._source
        self._parts = loop.period_parts()
        arrays["memory"][:] = source.rows.read(self._parts.owners)
        if source.references is not None:
            arrays["reference_numbers"][:] = source.references.read(loop.task.parts.reference)
            loop.window.hold(arrays["clock"], arrays["reference"])
        loop.ground_truth, loop.commanded_torque = arrays["ground_truth"], arrays["command"]
        self.single = self._single_period()

    def _single_period(self) -> SinglePeriod | None:
        """See `single`."""
        arrays, physics = self._arrays, self._loop.physics
        if len(arrays["clock"]) > 1 or not arrays.keys().isdisjoint(_GIVEN):
            return None
        common = self._library, self._address, arrays, self._substeps
        if self.simulates:
            return SingleCompiledPeriod(*common, physics.world)
        return SingleMujocoPeriod(*common, physics)

    def store(self) -> None:
        """Hand back what the loop's parts keep."""
        self._source.rows.write(self._loop.period_parts().owners, self._arrays["memory"])

    def step(self, action: Array) -> Step | None:
        """Advance by one period; the observations are the fields of the task.

        An environment that was lost before is left as it is, and its results have no meaning.

        Args:
            action: Actions (N, joints).

        Returns:
            The result; None where MuJoCo's simulations have advanced, one of them has left its bounds, maybe
            to numbers that are not finite, and NumPy has to judge the period.

        Raises:
            NonFiniteError: NaN or infinity in an action; nothing is changed.
        """
        arrays = self._arrays
        arrays["action"][...] = action
        if not self._library.prp_actions_are_finite(self._address):
            clip_actions(action)  # which refuses them by name
        if "noise" in arrays:
            self._draw("noise", self._parts.actuators.noise_ahead(1))
        if self.simulates:
            self._prepare()
            self.run(self.given)
        else:
            if not self._advance_mujoco(self._address, 0):
                self.store()
                return None
            self._prepare()
            self._library.prp_score(self._address, 0)
        return self.last_outcome()

    def _advance_mujoco(self, address: Any, k: int) -> bool:
        """Advance MuJoCo's physics by the k-th period of a plan; whether no simulation is lost."""
        physics, library = self._loop.physics, self._library
        library.prp_command(address, k)
        physics.set_torque(self._arrays["torque"])
        physics.advance(self._substeps)
        if physics.readings is not self._readings:  # at first, and in a forked process
            self._readings = physics.readings
            values = (self._arrays[name].ctypes.data for name in ("measured", "beyond"))
            self._read = ctypes.byref(self._readings), *map(ctypes.c_void_p, values)
        return bool(library.prp_read(*self._read))

    def last_outcome(self) -> Step:
        """The result of the last period."""
        return self.outcome(self._arrays["reward"], self._arrays["info"])

    def outcome(self, reward: Array, info: Array) -> Step:
        """The result of a step that compiled code has computed, with copies of its reward and `info`."""
        arrays = self._arrays
        observation, truncated = arrays["observation"].copy(), arrays["truncated"].copy()
        return Step(observation, reward.copy(), self._is_lost.copy(), truncated, info.copy())

    def _draw(self, name: str, values: Array | None) -> None:
        """Give the random numbers of the next period to the compiled code."""
        if values is not None:
            self._arrays[name][:] = values[0]

    def _prepare(self) -> None:
        """Give the sensor errors of the next period to the compiled code, and a sampled reference."""
        if "error" in self._arrays:
            self._draw("error", self._parts.sensors.errors_ahead(1))
        if self._source.references is None:
            self._loop.window.advance(self._loop.task.reference)
            self._arrays["sampled"][:] = self._loop.window.current

    def commanded(self) -> tuple[Array, NDArray[np.bool_] | None]:
        """The command and the saturation of the last period, as `EpisodeLoop.judge` takes them."""
        saturated = self._arrays["saturated"].astype(np.bool_)
        return self._arrays["command"].copy(), saturated if saturated.any() else None

    def run(self, given: PeriodPlan) -> bool:
        """Run a plan for these simulations, with their threads.

        Returns:
            False where MuJoCo's physics were not simulated to the end: an action of the controller was not
            finite, or a simulation was lost.
        """
        library, address = self._library, given.address
        if self.simulates:
            self._loop.physics.run(library.prp_run, self._substeps, address)
            return True
        for k in range(given.plan.periods):
            if not (library.prp_decide(address) and self._advance_mujoco(address, k)):
                return False
            library.prp_score(address, k)
        return True

    def drawn_ahead(self, periods: int) -> dict[str, Array]:
        """The random numbers of the next periods, which are over then, by their names in a plan."""
        drawn = {
            "noise": self._parts.actuators.noise_ahead(periods),
            "error": self._parts.sensors.errors_ahead(periods),
        }
        return {name: values for name, values in drawn.items() if values is not None}

    def run_episodes(self, controller: Any, observation: Array) -> EpisodeRecord | None:
        """Run whole episodes with a compiled controller; afterwards the loop cannot be used.

        Args:
            controller: `CompiledController`.
            observation: Observations (N, size) after the reset of all environments.

        Returns:
            The episodes; None if the controller returned an action that is not finite, or if a simulation of
            MuJoCo left its bounds.

        Raises:
            UntraceableError: a controller whose state is too large.
        """
        record, memory = EpisodeRecord.of(self._loop, self._loop.config.horizon)
        self._give_controller(controller, observation)
        self._set(memory)
        return record if self.run(self.given) and (record.ended >= 0).all() else None

    def score_episodes(self, controller: Any, observation: Array) -> EpisodeTotals | None:
        """Run whole episodes with compiled controllers, without a record; then all have to be reset.

        Args:
            controller: `CompiledController`, or `CompiledControllers` with numbers for each environment.
            observation: Observations (N, size) after the reset of all environments.

        Returns:
            What the episodes have given; None where `run` came to no end.

        Raises:
            UntraceableError: a controller whose state is too large.
        """
        rows, plan = self._loop.num_envs, self.given.plan
        totals = EpisodeTotals(np.zeros(rows), np.zeros(rows, dtype=np.intp))
        self._give_controller(controller, observation)
        self._set({"total": totals.reward, "ended": totals.ended})
        is_over = self.run(self.given)
        plan.controller, plan.periods, plan.total = None, 1, None
        return totals if is_over else None

    def _give_controller(self, controller: Any, observation: Array) -> None:
        """Let a controller act in whole episodes, all of whose random numbers and references are given."""
        loop, plan, numbers = self._loop, self.given.plan, controller.numbers
        size, periods = controller.initial_state.shape[1], loop.config.horizon
        if size > LARGEST_STATE:
            raise UntraceableError(f"a state of {size} numbers cannot be kept in compiled code.")
        if self._source.references is None:
            times = loop.window.times_ahead(periods)
            self._set({"sampled": loop.task.reference(times)})
        self._set(self.drawn_ahead(periods))
        self._set({"controller_numbers": numbers, "state": controller.initial_state.copy()})
        self._set({"observation": observation.copy()})
        plan.controller, plan.state_size, plan.periods = controller.function, size, periods
        plan.numbers_size = numbers.shape[1] if numbers.ndim == 2 else 0
