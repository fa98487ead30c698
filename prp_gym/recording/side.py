"""`Side`: one episode of a video, with the numbers so far."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.core.loop import EpisodeLoop
from prp_gym.evaluation.policy_output import check_output
from prp_gym.recording.signals import ErrorSignal, Sample, sample
from prp_gym.runs.acting_policy import ActingPolicy

_ALMOST = 1e-9  # [s]


class Side:
    """An episode that is run as far as the video has come.

    Args:
        acting: Policy and environment.
        seed: Random seed of the episode.

    Attributes:
        name: Name of the policy.
        error: Error of the task that is shown.
        samples: Numbers after every control period so far, the first from the reset.
        ended: Whether the episode is over.
    """

    def __init__(self, acting: ActingPolicy, seed: int) -> None:
        self.name = acting.name
        self._env, self._policy, self._reported = acting.env, acting.policy, acting.reported
        self._shape = tuple(self._env.action_space.shape or ())
        self._observation, _ = self._env.reset(seed=seed)
        self._loop: EpisodeLoop = self._env.get_wrapper_attr("loop")
        self._state: Any = None
        self._started = np.array([True])
        self.error = ErrorSignal.of(self._loop)
        self.samples: list[Sample] = [sample(self._loop, self.error)]
        self.ended = False

    def advance(self, time: float) -> None:
        """Run the episode up to a time since its start [s], or to its end.

        Raises:
            PolicyOutputError: the policy returns something else than a finite action and a state.
            UserCodeError: a user's code that fails.
        """
        while not self.ended and self.samples[-1].time < time - _ALMOST:
            with self._reported():
                output = self._policy.predict(self._observation, self._state, self._started, True)
                action, self._state = check_output(self._policy, output, self._shape)
            self._observation, _, terminated, truncated, _ = self._env.step(action)
            self._started = np.array([False])
            self.ended = bool(terminated or truncated)
            self.samples.append(sample(self._loop, self.error))

    def frame(self) -> NDArray[np.uint8]:
        """The frame of the present moment (height, width, 3)."""
        return np.asarray(self._env.render(), dtype=np.uint8)
