"""`Recorder`: fields, torques and rewards of N episodes, recorded period by period."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from prp_gym.evaluation.rollout import Rollout
from prp_gym.robot.arrays import Array
from prp_gym.tasks.episode_record import EpisodeRecord


class Recorder:
    """Episodes of N environments that start together.

    The recorded periods are those for which torques are set. With an inner controller there are more of them
    than actions, so that episodes of different action modes can be compared.

    Args:
        env: an environment of this suite, without wrappers.
        loop: control loop of N environments, all just reset.
    """

    def __init__(self, env: Any, loop: Any) -> None:
        self._env, self._loop, self._record = env, loop, EpisodeRecord.of(loop, 0)[0]

    def take_episodes(self, record: EpisodeRecord) -> None:
        """Take whole episodes that compiled code has run.

        Args:
            record: record of the loop; the rollouts share its memory.
        """
        self._record = record

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Record every period that the loop simulates in the context."""
        periods = _Periods(self._loop)
        self._loop.listen(periods.take)
        try:
            yield
        finally:
            self._loop.listen(None)
            self._record = periods.record()

    def rollout(self, row: int, seed: int, compute_time: Array) -> Rollout:
        """The episode of one environment.

        Args:
            row: row of the environment in the loop.
            seed: random seed with which the environment was reset.
            compute_time: compute times of the policy for one action each [s].
        """
        inner, loop, record = self._env, self._loop, self._record
        diverged = bool(record.ended[row] > 0)
        end = int(record.ended[row]) if diverged else record.command.shape[1]
        names = [field.name for field in loop.info_fields]
        info = dict(zip(names, record.info[row, :, :end], strict=True))
        rewards = [values for name, values in info.items() if name.startswith("reward_")]
        return Rollout(
            environment_id=inner.task.environment_id,
            scenario=inner.task.scenario.name,
            seed=seed,
            period=1.0 / loop.config.control_frequency,
            duration=float(inner.duration),
            fields={name: values[row, : end + 1] for name, values in record.fields.items()},
            torque=record.command[row, :end],
            applied_torque=record.applied[row, :end],
            reward=np.sum(rewards, axis=0),
            info=info,
            diverged=diverged,
            compute_time=compute_time,
            torque_limit=np.array(inner.torque_limit),
            engine=inner.config.engine,
        )


class _Periods:
    """The periods of a loop of N environments, all just reset, with time along the first axis.

    Args:
        loop: control loop.
    """

    def __init__(self, loop: Any) -> None:
        rows, joints, horizon = loop.num_envs, loop.joints, loop.config.horizon
        self._loop, self._count = loop, 0
        self._ground_truth = np.empty((horizon + 1, *loop.ground_truth.shape))
        self._torque = np.empty((horizon, rows, joints))
        self._applied = np.empty((horizon, rows, joints))
        self._info = np.empty((horizon, rows, len(loop.info_fields)))
        self._ended = np.zeros(rows, dtype=np.intp)
        self._ground_truth[0] = loop.ground_truth

    def take(self, step: Any) -> None:
        """Record one period; periods after a divergence belong to no episode."""
        index, loop = self._count, self._loop
        self._ground_truth[index + 1] = loop.ground_truth
        self._torque[index] = loop.commanded_torque
        self._applied[index] = loop.physics.torque
        self._info[index] = step.info
        self._count += 1
        self._ended[step.terminated & (self._ended == 0)] = self._count

    def record(self) -> EpisodeRecord:
        """The periods that were recorded, as episodes."""
        ground_truth, info = self._ground_truth[: self._count + 1], self._info[: self._count]
        fields = self._loop.task.ground_truth_layout.split(ground_truth)
        return EpisodeRecord(
            {name: _by_episodes(values) for name, values in fields.items()},
            _by_episodes(self._torque[: self._count]),
            _by_episodes(self._applied[: self._count]),
            np.ascontiguousarray(np.moveaxis(info, 0, -1)),
            self._ended,
        )


def _by_episodes(values: Array) -> Array:
    """Values (T, N, size) of all periods in the order (N, T, size)."""
    return np.ascontiguousarray(values.swapaxes(0, 1))
