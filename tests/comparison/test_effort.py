"""When made-up learning curves reach the score of the best controller, or never do."""

import numpy as np
import pytest

from prp_gym.comparison.effort import NEVER, first_reach, learning_efforts
from prp_gym.comparison.learning_plots import common_curve
from prp_gym.comparison.values import History, group_conditions
from tests.support.synthetic_comparison import agents, learning, record

CONTROLLER = record("joint_pd", [0.8] * 4)


@pytest.mark.parametrize(
    ("scores", "steps", "simulated", "minutes"),
    [
        ([0.1, 0.5, 0.8, 0.7, 0.9], 3000.0, 60.0, 0.5),  # once there, a later fall does not count
        ([0.9, 0.1], 1000.0, 20.0, 1.0 / 6.0),
        ([0.8], 1000.0, 20.0, 1.0 / 6.0),
    ],
)
def test_first_time_at_or_above_the_goal_counts(
    scores: list[float], steps: float, simulated: float, minutes: float
) -> None:
    found = first_reach(History.of(learning(scores)), 0.8)
    assert (found.steps, found.simulated_seconds) == (steps, simulated)
    assert found.wall_minutes == pytest.approx(minutes)


def test_goal_that_is_not_reached_is_never() -> None:
    assert first_reach(History.of(learning([0.1, 0.79])), 0.8) is NEVER


def test_median_over_training_seeds_is_never_unless_most_arrive() -> None:
    records = agents("a", np.full((3, 4), 0.7))
    for item, curve in zip(records, ([0.9, 0.95], [0.5, 0.9], [0.1, 0.2]), strict=True):
        item["history"] = learning(curve)
    (effort,) = learning_efforts(group_conditions([CONTROLLER, *records]))
    assert [effort.reached, effort.members, effort.goal] == pytest.approx([2, 3, 0.8])
    assert (effort.reach.steps, effort.reach.simulated_seconds) == (2000.0, 40.0)
    assert (effort.violations, effort.budget_seconds) == (2.0, 40.0)
    assert effort.best == pytest.approx(0.9)
    records[0]["history"] = learning([0.1, 0.2])
    (effort,) = learning_efforts(group_conditions([CONTROLLER, *records]))
    assert (effort.reached, effort.reach.steps, effort.reach.wall_minutes) == (1, np.inf, np.inf)


def test_effort_is_stated_once_and_for_the_scenario_of_the_training() -> None:
    trained = {"history": learning([0.7])}
    records = [CONTROLLER, *agents("a", np.full((1, 4), 0.7), **trained)]
    records += [record("joint_pd", [0.6] * 4, scenario="realistic")]
    records += agents("a", np.full((1, 4), 0.5), scenario="realistic", **trained)
    (effort,) = learning_efforts(group_conditions(records))
    assert (effort.scenario, effort.reached) == ("randomized", 0)
    assert effort.goal == pytest.approx(0.8)


def test_training_in_a_scenario_that_is_not_compared_has_no_goal() -> None:
    records = [CONTROLLER, *agents("a", np.full((1, 4), 0.7), history=learning([0.9], scenario="report"))]
    assert learning_efforts(group_conditions(records)) == []


def test_tuned_controller_has_no_wall_time_and_no_violations() -> None:
    history = {**learning([0.5, 0.9], frequency=500.0), "seconds": [None] * 2, "violations": [None] * 2}
    (effort,) = learning_efforts(group_conditions([CONTROLLER, record("x", [0.7] * 4, history=history)]))
    assert (effort.reach.steps, effort.reach.simulated_seconds) == (2000.0, 4.0)
    assert np.isnan([effort.reach.wall_minutes, effort.violations]).all()


def test_curves_of_different_steps_meet_at_common_times() -> None:
    first = History.of(learning([0.0, 1.0], steps=[100, 300]))
    second = History.of(learning([0.5, 0.5, 0.9], steps=[50, 200, 400]))
    time, scores = common_curve([first, second])
    np.testing.assert_allclose(time, [2.0, 4.0, 6.0])
    np.testing.assert_allclose(scores, [[0.0, 0.5, 1.0], [0.5, 0.5, 0.7]])
