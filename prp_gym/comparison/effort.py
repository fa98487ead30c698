"""Learning effort: training or tuning until a policy is as good as the best controller, and its violations.

Histories are those of training or tuning: means over episodes of their own scenario. The score to be reached
is the same measure of the best controller, its mean over the evaluation episodes of that scenario; both
estimate the expected score.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from prp_gym.comparison.statistics import best_of, score_of
from prp_gym.comparison.values import AGENT, CONTROLLER, Condition, Entry, History

_MINUTE = 60.0  # s


@dataclass(frozen=True)
class Reach:
    """When a history first reaches a score; infinite if it never does.

    Attributes:
        steps: number of environment steps.
        simulated_seconds: simulated time of these steps [s].
        wall_minutes: wall time of these steps [min]; NaN if it was not measured.
    """

    steps: float
    simulated_seconds: float
    wall_minutes: float


NEVER = Reach(np.inf, np.inf, np.inf)


def first_reach(history: History, goal: float) -> Reach:
    """When a score is reached for the first time.

    Args:
        history: score in the course of training or tuning.
        goal: score to be reached [1].
    """
    there = np.flatnonzero(history.score >= goal)
    if not there.size:
        return NEVER
    first = int(there[0])
    steps, seconds = float(history.steps[first]), float(history.seconds[first])
    return Reach(steps, float(history.simulated_seconds[first]), seconds / _MINUTE)


@dataclass(frozen=True)
class Effort:
    """How much training or tuning a policy needed to be as good as the best controller.

    Attributes:
        environment_id: id of the environment.
        scenario: scenario in which the policy was trained or tuned.
        policy: name of the policy.
        kind: kind of the policy, `agent` or `controller`.
        goal: mean score of the best controller in that scenario [1].
        best: median over training seeds of the highest score of each history [1].
        members: number of training seeds.
        reached: number of training seeds that reached the goal.
        reach: effort until the goal was reached, the median over the training seeds; infinite if at least
            half of them never reached it.
        budget_seconds: median of the total simulated time [s].
        violations: median of the total number of violations during training; NaN if they were not counted.
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
    """Learning efforts of all agents and tuned controllers, each once for every scenario of its training.

    A policy that learned in a scenario for which no controller is compared has no goal and is left out.

    Args:
        conditions: environments and scenarios with their policies.
    """
    goals = {}
    for condition in conditions:
        controllers = condition.of_kind(CONTROLLER)
        if controllers:
            goals[condition.environment_id, condition.scenario] = score_of(best_of(controllers))
    efforts = {}
    for condition in conditions:
        for entry in condition.of_kind(AGENT, CONTROLLER):
            scenario = entry.histories[0].scenario if entry.histories else ""
            if (condition.environment_id, scenario) in goals:
                goal = goals[condition.environment_id, scenario]
                efforts[condition.environment_id, scenario, entry.policy] = _effort(
                    condition.environment_id, entry, goal
                )
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
