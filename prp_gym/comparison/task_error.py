"""The physical error of a policy in every episode, against which the reward of a task is audited.

Every task error is a mean over time of absolute errors (IAE over the duration). It counts how large an error
is as well as how long it lasts, in proportion to both, so that its only scales are those that bring lengths,
angles and forces to one unit. A root mean square would be dominated by one impact, or by the initial distance
to the goal, which is the same for all policies; a median would leave out whatever takes less than half of the
time, as contact may; an error after the transient would leave out the transient, which matters most in
regulation.
"""

import numpy as np

from prp_gym.comparison.values import Entry
from prp_gym.robot.arrays import Array
from prp_gym.tasks.spec import TaskError


def physical_errors(entry: Entry, task_error: TaskError) -> Array:
    """A policy's physical error in every episode; infinite where the simulation diverged.

    Args:
        entry: a policy under a condition.
        task_error: physical error that the task of the environment declares.

    Returns:
        (rows, evaluation seeds) [1], the sum of the metrics over their scales.
    """
    shares = [
        (np.abs(entry.metrics[name]) / np.array(scale)).sum(-1) for name, scale in task_error.parts.items()
    ]
    error: Array = np.sum(shares, axis=0)
    return np.where(np.isnan(error), np.inf, error)
