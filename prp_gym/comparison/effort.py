"""What learning costs: how long until a policy is as good as the best law, and what it breaks meanwhile.

Histories are those of training or tuning, on episodes and in a scenario of their own: the score that is to
be reached is the best law's in that same scenario.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from prp_gym.comparison.statistics import best_of, score_of
from prp_gym.comparison.values import AGENT, BUDGET, CLASSICAL, Condition, Entry, History

_MINUTE = 60.0  # s


@dataclass(frozen=True)
class Reach:
    """When a history first has a score; infinite if it never does.

    Attributes:
        steps: of the environment.
        simulated_seconds: in these steps [s].
        wall_minutes: that they took [min]; NaN if not measured.
    """

    steps: float
    simulated_seconds: float
    wall_minutes: float


NEVER = Reach(np.inf, np.inf, np.inf)


def first_reach(history: History, goal: float) -> Reach:
    """When a score is reached for the first time.

    Args:
        history: of training or tuning.
        goal: the score [1].
    """
    there = np.flatnonzero(history.score >= goal)
    if not there.size:
        return NEVER
    first = int(there[0])
    steps, seconds = float(history.steps[first]), float(history.seconds[first])
    return Reach(steps, float(history.simulated_seconds[first]), seconds / _MINUTE)


@dataclass(frozen=True)
class Effort:
    """What a policy needed to be as good as the best law.

    Attributes:
        environment_id: of the environment.
        scenario: in which it was trained or tuned.
        policy: its name.
        kind: `agent` or `budget`.
        goal: the best law's score there [1].
        best: of the histories' scores, the median over training seeds of the highest [1].
        members: how many were trained, training seeds.
        reached: how many of them reached the goal.
        reach: the median over them, infinite if at least half of them never did.
        budget_seconds: of simulated time in all, the median [s].
        violations: during training in all, the median; NaN if not counted.
    """

    environment_id: str
    scenario: str
    policy: str
    kind: str
    goal: float
    best: float
    members: int
    reached: int
    reach: Reach
    budget_seconds: float
    violations: float


def learning_efforts(conditions: Sequence[Condition]) -> list[Effort]:
    """Efforts of all agents and equal-budget laws, each once.

    A policy that learned in a scenario without a law among the places has no goal and is left out.

    Args:
        conditions: with their policies.
    """
    goals = {}
    for place in conditions:
        controllers = place.of_kind(*CLASSICAL)
        if controllers:
            goals[place.environment_id, place.scenario] = score_of(best_of(controllers))
    efforts = {}
    for place in conditions:
        for entry in place.of_kind(AGENT, BUDGET):
            scenario = entry.histories[0].scenario if entry.histories else ""
            if (place.environment_id, scenario) in goals:
                goal = goals[place.environment_id, scenario]
                efforts[place.environment_id, entry.policy] = _effort(place.environment_id, entry, goal)
    return list(efforts.values())


def _effort(environment_id: str, entry: Entry, goal: float) -> Effort:
    reaches = [first_reach(history, goal) for history in entry.histories]
    medians = [
        float(np.median([getattr(reach, name) for reach in reaches]))
        for name in ("steps", "simulated_seconds", "wall_minutes")
    ]
    return Effort(
        environment_id=environment_id,
        scenario=entry.histories[0].scenario,
        policy=entry.policy,
        kind=entry.kind,
        goal=goal,
        best=float(np.median([history.score.max() for history in entry.histories])),
        members=len(reaches),
        reached=sum(reach is not NEVER for reach in reaches),
        reach=Reach(*medians),
        budget_seconds=float(np.median([history.simulated_seconds[-1] for history in entry.histories])),
        violations=float(np.median([history.violations[-1] for history in entry.histories])),
    )
