"""How an episode failed: one kind of failure, or none."""

import numpy as np

from prp_gym.evaluation.response import oscillates_for_good
from prp_gym.evaluation.rollout import Rollout
from prp_gym.evaluation.scoring import Settling, settling_of
from prp_gym.robot.arrays import Array
from prp_gym.tasks.settling.directions import magnitude

FAILURES = ("diverged", "excess force", "limit cycle", "unsettled")
"""Kinds of failure; an episode has the first that applies."""

MOST_FORCE = 1.25
"""Largest allowed peak of the contact force, as a multiple of the desired force."""


def failure_shares(rollout: Rollout) -> Array:
    """100 % for the kind of failure of an episode, 0 % for the others, in the order of `FAILURES`.

    - diverged: the simulation ended early.
    - excess force: the peak of the contact force exceeds `MOST_FORCE` times the desired force; without a
      desired force, the task's bound.
    - limit cycle: a deviation from the reference oscillates to the end of the episode, beyond the task's
      tolerance; see `prp_gym.evaluation.response.oscillates_for_good`.
    - unsettled: the responses are not within the task's tolerances over the last tenth of the episode, nor,
      where the task asks for it, over the last tenth before its planned reference turns back.

    The last two need a task that declares when its responses count as settled.

    Args:
        rollout: an episode.

    Returns:
        (kinds) [%].
    """
    shares = np.zeros(len(FAILURES))
    kind = _kind(rollout)
    if kind:
        shares[FAILURES.index(kind)] = 100.0
    return shares


def _kind(rollout: Rollout) -> str:
    """The kind of failure; empty for none."""
    diverged, excess, cycle, unsettled = FAILURES
    if rollout.diverged:
        return diverged
    if _presses_too_hard(rollout):
        return excess
    criterion = settling_of(rollout)
    if criterion is None:
        return ""
    settling = Settling.of(rollout, criterion)
    if oscillates_for_good(settling.deviations, criterion.reference(rollout.fields)):
        return cycle
    return unsettled if np.isinf(settling.time) else ""


def _presses_too_hard(rollout: Rollout) -> bool:
    """Whether the contact force exceeds what the task allows."""
    force, desired = (rollout.fields.get(name) for name in ("contact_force", "desired_force"))
    if force is None or desired is None:
        return bool(np.any(rollout.info.get("cost_force_bound", 0.0)))
    return bool((magnitude(force) > MOST_FORCE * magnitude(desired)).any())
