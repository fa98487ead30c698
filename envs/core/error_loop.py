"""An episode loop whose observations are errors and states of order 1."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.base.error_observation import ErrorObservation
from prp_gym.envs.core.loop import EpisodeLoop, LoopState
from prp_gym.envs.core.step import Step
from prp_gym.robot.arrays import Array


class ErrorLoop(EpisodeLoop):
    """N environments whose observations are those of `ErrorObservation`."""

    def _lay_out(self) -> None:
        """See `EpisodeLoop`."""
        super()._lay_out()
        self._errors = ErrorObservation(self.task.layout, self.task.model)
        self.observation_layout = self._errors.layout

    def reset(
        self,
        ids: NDArray[np.intp],
        rngs: Sequence[np.random.Generator],
        options: Mapping[str, Array],
    ) -> Array:
        """See `EpisodeLoop.reset`."""
        return self._errors(super().reset(ids, rngs, options))

    def step(self, action: Array, idle: NDArray[np.bool_] | None = None) -> Step:
        """See `EpisodeLoop.step`."""
        outcome = super().step(action, idle)
        return outcome._replace(observation=self._errors(outcome.observation))

    def set_state(self, state: LoopState) -> Array:
        """See `EpisodeLoop.set_state`."""
        return self._errors(super().set_state(state))
