"""`scoring_of`: how policies on a task are shown in tables and audited, and when its responses settle."""

from typing import NamedTuple

from prp_gym.evaluation.response import time_settled
from prp_gym.evaluation.rollout import Rollout
from prp_gym.robot.arrays import Array
from prp_gym.robot.shared import shared
from prp_gym.tasks.settling.criterion import SettlingCriterion
from prp_gym.tasks.spec import TASKS, TaskScoring


def scoring_of(environment_id: str) -> TaskScoring:
    """Columns of the tables and physical error of a task, as its declaration states them.

    Args:
        environment_id: id of an environment, declared or not.

    Returns:
        the declared scoring; one without columns and error where the task is not declared.
    """
    return TASKS[environment_id].scoring if environment_id in TASKS else TaskScoring()


def settling_of(rollout: Rollout) -> SettlingCriterion | None:
    """When the responses of an episode count as settled, as its task declares it.

    Args:
        rollout: an episode.

    Returns:
        the criterion; None for a task without one, or for an episode without the fields that it needs.
    """
    criterion = scoring_of(rollout.environment_id).settling
    if criterion is None or not set(criterion.requires) <= set(rollout.fields):
        return None
    return criterion


class Settling(NamedTuple):
    """How the responses of an episode settle.

    Attributes:
        deviations: groups of components (T, any size) in units of their tolerances [1].
        time: when all of them come within their tolerances for good [s]; infinite if they do not.
    """

    deviations: tuple[Array, ...]
    time: float

    @classmethod
    def of(cls, rollout: Rollout, criterion: SettlingCriterion) -> "Settling":
        """How the responses of an episode settle, for all of its metrics."""
        return _settling(rollout, criterion)


@shared
def _settling(rollout: Rollout, criterion: SettlingCriterion) -> Settling:
    """See `Settling.of`."""
    deviations = criterion.deviations(rollout.fields)
    reversals = criterion.reversals(rollout.fields)
    return Settling(deviations, time_settled(rollout.time, deviations, reversals))
