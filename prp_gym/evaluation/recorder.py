"""`Recorder`: fields, torques and rewards of N episodes, recorded period by period."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from prp_gym.evaluation.rollout import Rollout
from prp_gym.robot.arrays import Array


class Recorder:
    """Episodes of N environments that start together; time along the first axis.

    The recorded periods are those for which torques are set. With an inner controller there are more of them
    than actions, so that episodes of different action modes can be compared.

    Args:
        env: an environment of this suite, without wrappers.
        loop: control loop of N environments, all just reset.
    """

    def __init__(self, env: Any, loop: Any) -> None:
        rows, joints, horizon = loop.num_envs, loop.joints, loop.config.horizon
        self._env, self._loop = env, loop
        self._ground_truth = np.empty((horizon + 1, *loop.ground_truth.shape))
        self._torque = np.empty((horizon, rows, joints))
        self._applied = np.empty((horizon, rows, joints))
        self._info = np.empty((horizon, rows, len(loop.info_fields)))
        self._count = 0
        self._ended = np.full(rows, -1)
        self._ground_truth[0] = loop.ground_truth

    def take_episodes(self, record: Any) -> None:
        """Take whole episodes that compiled code has run.

        Args:
            record: `EpisodeRecord` of the loop.
        """
        self._ground_truth, self._torque, self._applied, self._info = (
            np.swapaxes(values, 0, 1)
            for values in (record.ground_truth, record.command, record.applied, record.info)
        )
        self._count = len(self._torque)
        self._ended = np.where(record.ended > 0, record.ended, -1)

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Record every period that the loop simulates in the context."""
        self._loop.listen(self._take)
        try:
            yield
        finally:
            self._loop.listen(None)

    def _take(self, step: Any) -> None:
        """Record one period; periods after a divergence belong to no episode."""
        index, loop = self._count, self._loop
        self._ground_truth[index + 1] = loop.ground_truth
        self._torque[index] = loop.commanded_torque
        self._applied[index] = loop.physics.torque
        self._info[index] = step.info
        self._count += 1
        self._ended[step.terminated & (self._ended < 0)] = self._count

    def rollout(self, row: int, seed: int, compute_time: Array) -> Rollout:
        """The episode of one environment.

        Args:
            row: row of the environment in the loop.
            seed: random seed with which the environment was reset.
            compute_time: compute times of the policy for one action each [s].
        """
        inner, loop, diverged = self._env, self._loop, bool(self._ended[row] >= 0)
        steps = slice(0, int(self._ended[row]) if diverged else self._count)
        info = {
            field.name: self._info[steps, row, column].copy() for column, field in enumerate(loop.info_fields)
        }
        rewards = [values for name, values in info.items() if name.startswith("reward_")]
        return Rollout(
            environment_id=inner.task.environment_id,
            scenario=inner.task.scenario.name,
            seed=seed,
            period=1.0 / loop.config.control_frequency,
            duration=float(inner.duration),
            fields=inner.task.ground_truth_layout.split(self._ground_truth[: steps.stop + 1, row].copy()),
            torque=self._torque[steps, row].copy(),
            applied_torque=self._applied[steps, row].copy(),
            reward=np.sum(rewards, axis=0),
            info=info,
            diverged=diverged,
            compute_time=compute_time,
            torque_limit=np.array(inner.torque_limit),
            engine=inner.config.engine,
        )
