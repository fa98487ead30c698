"""A loop whose torques come from an inner law that the actions steer."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.action_mode import ActionMode, Memory
from prp_gym.envs.config import EnvConfig
from prp_gym.envs.core.loop import STATE, EpisodeLoop, LoopState
from prp_gym.envs.core.step import Step
from prp_gym.errors import ShapeError
from prp_gym.robot.arrays import Array
from prp_gym.tasks.task import Task


class ModeLoop(EpisodeLoop):
    """N environments in which an action holds over several periods of an inner law.

    Sensors, actuators, reward and costs work at the inner law's rate, as they do for a law on its own, so
    that both are judged alike; a step's reward and costs are the sums over its periods.

    Args:
        task: judges them, at the inner period.
        config: common keywords, with the inner rate as control frequency.
        mode: what actions mean.
        periods: inner periods in an action's.
        num_envs: N.
        num_threads: of the physics; 0 takes all cores.
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
        self._summed = np.array([field.summed for field in self.info_fields])

    def reset(
        self,
        ids: NDArray[np.intp],
        rngs: Sequence[np.random.Generator],
        options: Mapping[str, Array],
    ) -> Array:
        """Start new episodes in some environments; see `EpisodeLoop.reset`."""
        observation = super().reset(ids, rngs, options)
        self._starts[ids] = True
        self._observation[ids] = observation[ids]
        return self._observation.copy()

    def set_state(self, state: LoopState) -> Array:
        """Go back to a state; see `EpisodeLoop.set_state`."""
        super().set_state(state)
        return self._observation.copy()

    def step(self, action: Array, idle: NDArray[np.bool_] | None = None) -> Step:
        """One action's period of every environment; see `EpisodeLoop.step`.

        An environment that diverges is shown as it was in the period in which it did so.

        Args:
            action: (N, action size); beyond ±1 they are clipped.
            idle: (N) which environments only wait for their reset.
        """
        if action.shape != self._action_shape:
            raise ShapeError("action", action.shape, f"{self._action_shape}")
        waiting = np.zeros(self.num_envs, dtype=np.bool_) if idle is None else idle.copy()
        self.require_playable(waiting)
        held = self.clipped(np.where(waiting[:, None], 0.0, action))
        outcome = self._period(held, waiting)
        terminated = outcome.terminated & ~waiting
        for _ in range(self._periods - 1):
            waiting |= terminated
            if np.count_nonzero(waiting) == self.num_envs:
                break
            outcome = self._continued(outcome, held, waiting)
            terminated |= outcome.terminated & ~waiting
        return outcome._replace(observation=outcome.observation.copy(), terminated=terminated)

    def _period(self, action: Array, waiting: NDArray[np.bool_]) -> Step:
        """One period of the inner law."""
        torque, self._memory = self._mode.torque(action, self._observation, self._memory, self._starts)
        outcome = super().step(torque, waiting if np.count_nonzero(waiting) else None)
        self._starts = np.zeros_like(self._starts)
        self._observation = outcome.observation
        return outcome

    def _continued(self, before: Step, action: Array, waiting: NDArray[np.bool_]) -> Step:
        """One more period, joined with those before it; environments that wait stay as they were."""
        shown = self.ground_truth, self.commanded_torque, self.physics.torque.copy()
        after = self._period(action, waiting)
        info = np.where(self._summed, before.info + after.info, after.info)
        if not np.count_nonzero(waiting):
            return after._replace(reward=before.reward + after.reward, info=info)
        rows = waiting[:, None]
        self._observation = np.where(rows, before.observation, after.observation)
        self.ground_truth = np.where(rows, shown[0], self.ground_truth)
        self.commanded_torque = np.where(rows, shown[1], self.commanded_torque)
        self.physics.set_torque(np.where(rows, shown[2], self.physics.torque))
        return Step(
            self._observation,
            before.reward + np.where(waiting, 0.0, after.reward),
            after.terminated & ~waiting,
            np.where(waiting, before.truncated, after.truncated),
            np.where(rows, before.info, info),
        )
