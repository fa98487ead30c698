"""The episode loop of N environments: it counts control periods and connects physics, sensors and task.

It is vectorised over N; a single environment is a loop with N = 1.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.action_mode import ActionField, torque_field
from prp_gym.envs.base.error_observation import ErrorObservation
from prp_gym.envs.config import ERRORS, SUBSTEPS_PER_SECOND, EnvConfig
from prp_gym.envs.core.actuators import make_actuators
from prp_gym.envs.core.argument_checks import check_ids, limit_actions
from prp_gym.envs.core.compiled_loop import CompiledLoop
from prp_gym.envs.core.period_parts import PeriodParts
from prp_gym.envs.core.reference_window import ReferenceWindow
from prp_gym.envs.core.sensors import make_sensors
from prp_gym.envs.core.step import Step
from prp_gym.envs.core.step_scoring import StepScoring
from prp_gym.errors import ShapeError
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.compiler import compiles_by_default
from prp_gym.tasks.episode_record import EpisodeRecord
from prp_gym.tasks.episode_totals import EpisodeTotals
from prp_gym.tasks.setup import COMPILED
from prp_gym.tasks.task import Task

_LARGEST_SEED = 2**63


class EpisodeLoop(CompiledLoop):
    """N environments of one task, stepped together.

    Args:
        task: Task of the environments.
        config: Common keywords.
        num_envs: Number of environments N.
        num_threads: Number of threads of the physics; 0 takes all cores.

    Attributes:
        torque_limit: Joint torques at action 1 (joints) [N m, N, N m].
        commanded_torque: Torques commanded in the last step, within the limits (N, joints) [N m, N, N m].
        ground_truth: Ground truth (N, task.ground_truth_layout.size), which the sensors read.
            It may change in place, like the commanded torques, so copy what is to be kept.
        info_fields: Columns of a step's `info`.
        observation_layout: Layout of the observations.
        action_fields: Parts of an action.
    """

    def __init__(self, task: Task, config: EnvConfig, num_envs: int = 1, num_threads: int = 1) -> None:
        self.task = task
        self.config = config
        self.num_envs = num_envs
        nominal = task.model.parameters.torque_limit
        self.torque_limit = config.limits(nominal)
        self.joints = len(nominal)
        self.action_fields: tuple[ActionField, ...] = (torque_field(self.torque_limit),)
        self.physics = task.make_physics(1.0 / SUBSTEPS_PER_SECOND, num_envs, num_threads)
        self._scoring = StepScoring(task, config.control_frequency, config.horizon)
        self.info_fields = self._scoring.info_fields
        self._actuators = make_actuators(task.scenario, np.array(nominal), num_envs)
        self._sensors = make_sensors(task.scenario, task.layout, num_envs)
        self.commanded_torque = np.zeros((num_envs, self.joints))
        self.ground_truth = np.zeros((num_envs, task.ground_truth_layout.size))
        self._window = ReferenceWindow(num_envs, 1.0 / config.control_frequency, config.horizon)
        self._needs_reset: NDArray[np.bool_] = np.ones(num_envs, dtype=np.bool_)
        self._all_ready = False
        self._limit = np.tile(self.torque_limit, (num_envs, 1))
        bound = np.array([bound for item in task.measured_fields[:2] for bound in item.high])
        self.physics.watch(bound)
        self._full = np.ones_like(self._limit)
        self._substeps = config.substeps
        self._may_compile = config.engine == COMPILED or compiles_by_default()
        self._errors = ErrorObservation(task.layout, task.model) if config.observation == ERRORS else None
        self.observation_layout = task.layout if self._errors is None else self._errors.layout
        self._lay_out()

    def _lay_out(self) -> None:
        """Find the columns of the ground truth that are measured, given by the reference, and observed."""
        layout, measured = self.task.layout, self.physics.measurement_size
        self._space = layout.space()
        self._shape = self.ground_truth.shape
        self._measured = np.s_[:, :measured]
        self._referenced = np.s_[:, measured : layout.size]
        self._observed = np.s_[:, : layout.size]
        self._all_observed = layout.size == self.task.ground_truth_layout.size

    def reset(
        self,
        ids: NDArray[np.intp],
        rngs: Sequence[np.random.Generator],
        options: Mapping[str, Array],
    ) -> Array:
        """Start new episodes in some environments; the first call must cover all of them.

        If a start is refused, the running episodes are unchanged, but the generators have advanced.

        Args:
            ids: Environments to reset (n), in rising order.
            rngs: Generators of these environments (n).
            options: Validated reset options by name, with one value for each of them (n, ...).

        Returns:
            Observations of all environments (N, size).

        Raises:
            InvalidValueError: ids out of order or out of range, or a first call for some environments only.
            PRPError: a start or goal that the task refuses.
        """
        check_ids(ids, self.num_envs, started=self.started)
        self._store()
        start, plants = self.task.draw(rngs, options), self.task.draw_plants(rngs)
        seeds = [int(rng.integers(_LARGEST_SEED)) for rng in rngs]
        self.task.configure(self.physics, ids, start, plants)
        self.task.begin(ids, start)
        self._actuators.begin(ids, seeds)
        self._sensors.begin(ids, seeds)
        self.physics.reset(ids, start.joint_position, start.joint_velocity)
        self._needs_reset[ids] = False
        self._all_ready = not np.count_nonzero(self._needs_reset)
        if not self._begin_compiled(ids):
            self._window.begin(ids, self.task.reference)
            self.ground_truth = self._measure()
            self.task.complete(self.ground_truth)
            self.load()
        return self._viewed(self._begun(ids))

    def _restored(self) -> Array:
        """See `CompiledLoop`."""
        return self._viewed(self._observe())

    def _begun(self, ids: NDArray[np.intp]) -> Array:
        """The fields of the task as the sensors read them, after some environments have begun an episode."""
        return self._observe()

    def step(self, action: Array, idle: NDArray[np.bool_] | None = None) -> Step:
        """Advance every environment by one control period.

        Args:
            action: Torques normalised by the actuator limits (N, joints); values beyond ±1 are clipped.
            idle: Mask (N) of environments that only wait for their reset, diverged or not: their actions are
                ignored and their results have no meaning. None stands for no environment.

        Returns:
            Observations, rewards and `info` after the step.

        Raises:
            ShapeError: an action of another shape.
            NonFiniteError: NaN or infinity in the action; the state is unchanged.
            EpisodeError: an environment that was never reset, or has diverged.
        """
        outcome = self._advance(action, idle)
        if self._errors is None:
            return outcome
        return outcome._replace(observation=self._errors(outcome.observation))

    def _advance(self, action: Array, idle: NDArray[np.bool_] | None = None) -> Step:
        """Advance by one control period, see `step`; the observations are the fields of the task."""
        if action.shape != self._limit.shape:
            raise ShapeError("action", action.shape, f"{self._limit.shape}")
        if idle is not None:
            action = np.where(idle[:, None], 0.0, action)
        if not self._all_ready:
            self.require_ready(np.zeros_like(self._needs_reset) if idle is None else idle)
        if self._compiled is not None:
            outcome = self._compiled.step(action)
            return self._watched(outcome) if outcome else self.judge(*self._compiled.commanded())
        action, saturated = limit_actions(action, self._full)
        command = action * self._limit
        self.physics.set_torque(self._actuators.apply(command))
        self.physics.advance(self._substeps)
        return self.judge(command, saturated)

    def judge(self, command: Array, saturated: NDArray[np.bool_] | None) -> Step:
        """See `CompiledLoop`."""
        self.commanded_torque = command
        self._window.advance(self.task.reference)
        self._sensors.advance()
        ground_truth = self._measure()
        self.task.advance(ground_truth)
        self.task.complete(ground_truth)
        self.ground_truth = ground_truth
        elapsed, within_limits = self._window.elapsed, self.physics.within_limits
        violation = None if within_limits else self.physics.stop_violation
        errors = self.task.errors(ground_truth, command)
        reward, info = self._scoring(errors, ground_truth, saturated, elapsed, violation)
        truncated = self._scoring.truncated(elapsed)
        terminated = np.zeros(self.num_envs, dtype=np.bool_) if within_limits else self.physics.out_of_bounds
        self._stop(terminated)
        if not self._all_ready:
            self._scoring.zero_reward(reward, info, terminated)
            truncated &= ~terminated
        outcome = Step(self._observe(), reward, terminated, truncated, info)
        self._on_period(outcome)
        if self._compiled is not None:
            self._compiled.load()
        return outcome

    def start_info(self) -> Array:
        """The `info` (N, fields) of environments at the start of an episode."""
        return self._scoring.at_start(self.ground_truth)

    def _measure(self) -> Array:
        """The present ground truth, a new array in which the task has yet to write the unobserved fields."""
        ground_truth = np.empty(self._shape)
        self.physics.measure(ground_truth[self._measured])
        ground_truth[self._referenced] = self._window.current
        return ground_truth

    def _viewed(self, fields: Array) -> Array:
        """Observations (N, size) from the fields of the task as the sensors read them."""
        return fields if self._errors is None else self._errors(fields)

    def _observe(self) -> Array:
        """The sensors' reading of the ground truth, a new array; clipped to its bounds after a divergence."""
        observed = self.ground_truth if self._all_observed else self.ground_truth[self._observed]
        observation: Array = observed.copy()
        self._sensors.read(observation)
        if not self._all_ready:
            which = self._needs_reset
            observation[which] = np.clip(observation[which], self._space.low, self._space.high)
        return observation

    @property
    def observation(self) -> Array:
        """The fields of the task as the sensors read them at present (N, task.layout.size), a new array."""
        return self._observe()

    def period_parts(self) -> PeriodParts:
        """See `CompiledLoop`."""
        parts = (self._actuators, self._sensors, self._scoring)
        return PeriodParts(self.task.parts.errors, *parts, self.torque_limit)

    @property
    def window(self) -> ReferenceWindow:
        """The episodes' clocks and present references."""
        return self._window

    def run_episodes(self, controller: Any, observation: Array) -> EpisodeRecord | None:
        """Run whole episodes with a compiled controller; see `CompiledPeriods.run_episodes`.

        Args:
            controller: `CompiledController`.
            observation: Observations (N, size).
        """
        return None if self._compiled is None else self._compiled.run_episodes(controller, observation)

    def score_episodes(self, controller: Any, observation: Array) -> EpisodeTotals | None:
        """Run whole episodes with compiled controllers; see `CompiledPeriods.score_episodes`.

        Args:
            controller: `CompiledController` or `CompiledControllers`.
            observation: Observations (N, size).

        Returns:
            What they have given; None where the task's formulas are not in compiled code.
        """
        return None if self._compiled is None else self._compiled.score_episodes(controller, observation)

    @property
    def action_size(self) -> int:
        """Number of components of one environment's action."""
        return sum(field.size for field in self.action_fields)

    @property
    def started(self) -> bool:
        """Whether every environment has been reset at least once."""
        return self._window.started

    @property
    def time(self) -> Array:
        """Time since the start of each episode (N) [s]."""
        seconds: Array = self._window.elapsed / self.config.control_frequency
        return seconds
