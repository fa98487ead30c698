"""An episode loop whose torques come from an inner controller that receives the actions."""

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.action_mode import ActionMode, Memory
from prp_gym.envs.config import EnvConfig
from prp_gym.envs.core.argument_checks import clip_actions
from prp_gym.envs.core.compiled_mode import CompiledMode
from prp_gym.envs.core.info import AVERAGED, LAST
from prp_gym.envs.core.loop import EpisodeLoop
from prp_gym.envs.core.loop_state import STATE
from prp_gym.envs.core.single_period import SingleStep
from prp_gym.envs.core.step import Step
from prp_gym.errors import CompilerError, ShapeError, UntraceableError
from prp_gym.robot.arrays import Array
from prp_gym.tasks.task import Task


class ModeLoop(EpisodeLoop):
    """N environments in which an action is held over several control periods of an inner controller.

    Sensors, actuators, reward and costs run at the inner control frequency, as they do for a controller
    on its own, so that both are scored alike. The reward of a step is the mean over its periods, where those
    after a divergence count as 0, and its costs are the sums.

    Args:
        task: Task of the environments, at the inner control period.
        config: Common keywords, with the inner control frequency.
        mode: Action mode, which turns actions into joint torques.
        periods: Number of inner control periods over which an action is held.
        num_envs: Number of environments N.
        num_threads: Number of threads of the physics; 0 takes all cores.
    """

    state_names = (*STATE, "_observation", "_memory", "_starts")

    def __init__(
        self,
        task: Task,
        config: EnvConfig,
        mode: ActionMode,
        periods: int,
        num_envs: int = 1,
        num_threads: int = 1,
    ) -> None:
        super().__init__(task, config, num_envs, num_threads)
        self._mode = mode
        self._periods = periods
        self.action_fields = mode.fields
        self._action_shape = (num_envs, self.action_size)
        self._observation = np.zeros((num_envs, task.layout.size))
        self._memory: Memory = None
        self._starts: NDArray[np.bool_] = np.ones(num_envs, dtype=np.bool_)
        rules = [field.over_periods for field in self.info_fields]
        self._added = np.array([rule != LAST for rule in rules])
        self._share = 1.0 / periods
        self._shares = np.where([rule == AVERAGED for rule in rules], self._share, 1.0)
        self._code: CompiledMode | None = None
        self._code_keeps_memory, self._may_compile_mode, self._was_called = False, True, False

    def _begun(self, ids: NDArray[np.intp]) -> Array:
        """See `EpisodeLoop`."""
        self._starts[ids] = True
        self._observation[ids] = super()._begun(ids)[ids]
        return self._observation.copy()

    def _restored(self) -> Array:
        """See `EpisodeLoop`."""
        self._code, self._code_keeps_memory = None, False
        return self._viewed(self._observation.copy())

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_code": None}

    def _store(self) -> None:
        """See `EpisodeLoop`."""
        super()._store()
        self._take_memory()

    def _take_memory(self) -> None:
        """Take back the memory of the mode from compiled code."""
        if self._code is not None and self._code_keeps_memory:
            self._memory, self._code_keeps_memory = self._code.memory(), False

    @property
    def memory(self) -> Memory:
        """What the mode has returned last for itself; None before its first call."""
        return self._memory

    def _compiled_step(self) -> CompiledMode | None:
        """The step in compiled code, once the mode has been called; None where it cannot be compiled.

        A listener has to be called in every period, which NumPy goes through.
        """
        periods = self._compiled if self._may_compile_mode and self._was_called else None
        if periods is None or not periods.simulates or self.has_listener:
            return None
        if self._code_keeps_memory:
            return self._code
        try:
            if self._code is None or self._code.periods is not periods:
                totals = np.append(self._shares, self._share), self._added
                self._code = CompiledMode(self, self._mode, periods, *totals, self._periods)
        except (UntraceableError, CompilerError):  # a mode of another package, which NumPy computes
            self._may_compile_mode = False
            return None
        return self._code if self._code.load(self._memory) else None

    def step_alone(self, action: NDArray[Any]) -> SingleStep | None:
        """See `EpisodeLoop`: never."""
        return None

    def _advance(self, action: Array, idle: NDArray[np.bool_] | None = None) -> Step:
        """Advance every environment by the period of one action; see `EpisodeLoop`.

        The results of an environment that diverges are those of the period in which it does so.

        Args:
            action: Actions (N, action size); values beyond ±1 are clipped.
            idle: Mask (N) of environments that only wait for their reset.
        """
        if action.shape != self._action_shape:
            raise ShapeError("action", action.shape, f"{self._action_shape}")
        waiting = np.zeros(self.num_envs, dtype=np.bool_) if idle is None else idle.copy()
        self.require_ready(waiting)
        held = clip_actions(np.where(waiting[:, None], 0.0, action))
        code = self._compiled_step()
        return self._in_numpy(held, waiting) if code is None else self._in_code(code, held, waiting)

    def _in_code(self, code: CompiledMode, held: Array, waiting: NDArray[np.bool_]) -> Step:
        """Advance by the periods of an action in compiled code; environments that wait stay as they are."""
        self._code_keeps_memory = True
        outcome = self._watched(code.step(held, self._observation, self._starts, waiting))
        self._observation, self._starts = outcome.observation, np.zeros_like(self._starts)
        return outcome._replace(
            observation=outcome.observation.copy(), terminated=outcome.terminated & ~waiting
        )

    def _in_numpy(self, held: Array, waiting: NDArray[np.bool_]) -> Step:
        """Advance by the periods of an action, one after the other."""
        self._take_memory()
        self._was_called = True
        outcome = self._period(held, waiting)
        terminated = outcome.terminated & ~waiting
        for _ in range(self._periods - 1):
            waiting |= terminated
            if np.count_nonzero(waiting) == self.num_envs:
                break
            outcome = self._continued(outcome, held, waiting)
            terminated |= outcome.terminated & ~waiting
        return outcome._replace(observation=outcome.observation.copy(), terminated=terminated)

    def inner_time(self) -> float:
        """How long the inner controller computes for one action of the first environment [s].

        Measured now, apart from a step: for one period, as at the start of an episode, times the periods
        over which an action is held.
        """
        action = np.zeros((1, self.action_size))
        observation, start = self._observation[:1], np.ones(1, dtype=np.bool_)
        before = time.perf_counter()
        self._mode.torque(action, observation, None, start)
        return self._periods * (time.perf_counter() - before)

    def _period(self, action: Array, waiting: NDArray[np.bool_]) -> Step:
        """Advance by one period of the inner controller; its reward counts by its share of the step."""
        torque, self._memory = self._mode.torque(action, self._observation, self._memory, self._starts)
        outcome = super()._advance(torque, waiting if np.count_nonzero(waiting) else None)
        self._starts = np.zeros_like(self._starts)
        self._observation = outcome.observation
        return outcome._replace(reward=outcome.reward * self._share, info=outcome.info * self._shares)

    def _continued(self, before: Step, action: Array, waiting: NDArray[np.bool_]) -> Step:
        """Advance by one more period and add its results; environments that wait keep theirs."""
        kept = self.ground_truth.copy(), self.commanded_torque.copy(), self.physics.torque.copy()
        after = self._period(action, waiting)
        info = np.where(self._added, before.info + after.info, after.info)
        if not np.count_nonzero(waiting):
            return after._replace(reward=before.reward + after.reward, info=info)
        rows = waiting[:, None]
        self._observation = np.where(rows, before.observation, after.observation)
        self.ground_truth[waiting], self.commanded_torque[waiting] = kept[0][waiting], kept[1][waiting]
        self.physics.set_torque(np.where(rows, kept[2], self.physics.torque))
        return Step(
            self._observation,
            before.reward + np.where(waiting, 0.0, after.reward),
            after.terminated & ~waiting,
            np.where(waiting, before.truncated, after.truncated),
            np.where(rows, before.info, info),
        )
