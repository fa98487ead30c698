"""`EpisodeRecord`: whole episodes of N environments."""

from collections.abc import Mapping
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arrays import Array


class EpisodeRecord(NamedTuple):
    """What happened in whole episodes of N environments.

    Attributes:
        fields: Ground truth by field name, each (N, T + 1, size).
        command: Commanded torque within the limits (N, T, joints) [N m, N, N m].
        applied: Applied torque (N, T, joints) [N m, N, N m].
        info: Values of `info` (N, fields, T).
        ended: Period (N), counted from 1, in which an environment diverged; 0 for none; negative where the
            action was not finite.
    """

    fields: Mapping[str, Array]
    command: Array
    applied: Array
    info: Array
    ended: NDArray[np.intp]

    @classmethod
    def of(cls, loop: Any, periods: int) -> tuple[Self, dict[str, NDArray[Any]]]:
        """Room for episodes of a loop, which stands at their start.

        Returns:
            The record, and its memory by names in the plan of compiled periods.
        """
        rows, times = loop.num_envs, periods + 1
        layout = loop.task.ground_truth_layout
        every = np.empty((rows, layout.size * times))
        fields = {}
        for name, part in layout.slices.items():
            columns = every[:, part.start * times : part.stop * times]
            fields[name] = columns.reshape(rows, times, part.stop - part.start)  # a view
            fields[name][:, 0] = loop.ground_truth[:, part]
        record = cls(
            fields,
            np.empty((rows, periods, loop.joints)),
            np.empty((rows, periods, loop.joints)),
            np.empty((rows, len(loop.info_fields), periods)),
            np.zeros(rows, dtype=np.intp),
        )
        memory = {"recorded_fields": every, "recorded_command": record.command}
        memory |= {"recorded_applied": record.applied, "recorded_info": record.info, "ended": record.ended}
        return record, memory
