"""Estimates, verdicts and families of policies, on made-up scores."""

import numpy as np
import pytest

from prp_gym.comparison.outcome import Outcome
from prp_gym.comparison.statistics import (
    BEST_AGENT,
    BEST_CONTROLLER,
    BEST_FLOOR,
    aggregate_tasks,
    compare_best,
    estimate_score,
    summarise,
    training_spread,
)
from prp_gym.comparison.table import condition_scores
from prp_gym.comparison.values import FLOOR, Entry, group_conditions
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation import bootstrap_crossed, bootstrap_mean, bootstrap_tasks
from prp_gym.evaluation.statistics import Estimate, mean
from tests.comparison.test_small_comparison import text_of
from tests.support.synthetic_comparison import Array, agents, record

EPISODES = np.linspace(0.3, 0.9, 20)  # hard and easy ones


def pairwise(controller: Array, agent: Array) -> tuple[Estimate, bool, str, float]:
    records = [
        record("joint_pd", controller),
        *agents("ppo_torque", agent),
        record("hold", controller + 1.0, "floor"),
    ]
    (found,) = compare_best(group_conditions(records), 0)
    assert (found.controller, found.agent) == ("joint_pd", "ppo_torque")
    return found.difference, found.apart, found.verdict, found.probability


def test_paired_difference_decides_where_the_intervals_overlap() -> None:
    difference, apart, verdict, probability = pairwise(EPISODES, EPISODES[None] + [[0.01], [0.012]])
    assert 0.0 < difference.low < difference.value < difference.high
    assert (apart, verdict, probability) == (False, "agent", 1.0)


def test_worse_agent_loses() -> None:
    difference, apart, verdict, probability = pairwise(EPISODES, EPISODES[None] - [[0.3], [0.28]])
    assert difference.high < 0.0
    assert (apart, verdict, probability) == (True, "controller", 0.0)


def test_difference_that_may_be_none_is_undecided() -> None:
    change = np.where(np.arange(20) % 2, 0.05, -0.05)
    difference, apart, verdict, probability = pairwise(EPISODES, (EPISODES + change)[None])
    assert difference.low < 0.0 < difference.high
    assert (apart, verdict, probability) == (False, "-", 0.5)


def test_training_seeds_that_disagree_leave_it_undecided() -> None:
    better_and_worse = np.stack([EPISODES + 0.05, EPISODES + 0.04, EPISODES - 0.2])
    difference, _, verdict, probability = pairwise(EPISODES, better_and_worse)
    assert difference.low < 0.0 < difference.high
    assert verdict == "-"
    assert probability == pytest.approx(2 / 3)


def test_best_controller_is_compared_with_the_best_agent_where_there_is_one() -> None:
    controllers = [record("joint_pd", EPISODES), record("adaptive", EPISODES + 0.05)]
    assert compare_best(group_conditions(controllers), 0) == []
    others = [*agents("a", EPISODES[None]), *agents("b", EPISODES[None] + 0.01)]
    found = compare_best(group_conditions([*controllers, *others]), 0)
    assert [(pairwise.controller, pairwise.agent) for pairwise in found] == [
        ("adaptive", "b"),
    ]


def test_agents_are_resampled_over_training_seeds_and_controllers_over_episodes() -> None:
    scores = EPISODES[None] + [[0.0], [0.3]]
    controller, agent = Entry.of([record("joint_pd", EPISODES)]), Entry.of(agents("a", scores))
    rng = np.random.default_rng
    assert estimate_score(controller, 3) == bootstrap_mean(EPISODES, rng(3))
    assert estimate_score(agent, 3) == bootstrap_crossed(scores, rng(3), statistic=mean)
    assert summarise(agent, 3).interquartile_mean == bootstrap_crossed(scores, rng(3))


def test_controller_that_is_dead_in_five_of_twenty_episodes_falls_behind_in_every_table() -> None:
    alive = np.linspace(0.90, 0.92, 20)
    killed = np.concatenate([alive[:15] + 0.05, np.full(5, 0.1)])
    records = [record("killed", killed), record("alive", alive), record("hold", np.full(20, 0.4), "floor")]
    outcome = Outcome.of([*records, *agents("agent", np.full((1, 20), 0.8))], 0)
    (condition,) = outcome.conditions
    text = text_of(condition_scores(condition, 0)).splitlines()
    rows = {line.split()[0]: line.split()[1:] for line in text if line.split() and line.split()[0] in NAMED}
    assert list(rows) == ["alive", "agent", "killed", "hold"]
    assert rows["killed"][0] == "0.743"
    assert rows["killed"][2:4] == ["0.955", "0.100"]  # the middle half does not see what the worst shows
    assert float(rows["killed"][4]) == pytest.approx((killed.mean() - 0.4) / 0.6, abs=5e-4)
    (pairwise,) = outcome.pairwise_comparisons
    assert pairwise.controller == "alive"
    (best,) = (item for item in outcome.aggregates if item.family == "best controller")
    assert best.score.value == pytest.approx(alive.mean())
    (plain,) = (row for row in outcome.to_plain()["scores"] if row["policy"] == "killed")
    assert plain["score"]["value"] == pytest.approx(killed.mean())
    assert plain["skill"] == pytest.approx((killed.mean() - 0.4) / 0.6)


NAMED = ("alive", "agent", "killed", "hold")


def test_spread_is_over_training_seeds() -> None:
    spread = training_spread(Entry.of(agents("a", np.array([[0.1] * 4, [0.5] * 4, [0.2] * 4]))))
    assert (spread.median, spread.low, spread.high) == pytest.approx((0.2, 0.1, 0.5))


def test_policies_of_different_episodes_are_refused() -> None:
    records = [record("joint_pd", EPISODES), record("adaptive", EPISODES, seeds=list(range(1, 21)))]
    with pytest.raises(InvalidValueError, match="evaluation seeds of adaptive"):
        group_conditions(records)


def test_records_of_a_group_are_one_policy_in_the_order_of_the_conditions() -> None:
    conditions = group_conditions(
        [record("joint_pd", EPISODES, scenario="realistic"), *agents("a", np.stack([EPISODES, EPISODES / 2]))]
    )
    assert [condition.scenario for condition in conditions] == ["realistic", "randomized"]
    (agent,) = conditions[1].entries
    assert agent.training_seeds == (0, 1)
    np.testing.assert_array_equal(agent.scores, [EPISODES, EPISODES / 2])
    assert agent.metrics["joint_rmse"].shape == (2, 20, 3)


def test_families_are_the_best_of_each_kind_on_each_of_their_tasks() -> None:
    first, second = "PRP-JointTracking-v0", "PRP-Adaptive-v0"
    records = []
    for environment_id, shift in ((first, 0.0), (second, -0.2)):
        records += [
            record(controller, EPISODES + shift, environment_id=environment_id)
            for controller in ("joint_pd", "x")
        ]
        records[-1]["episodes"]["score"] = [[0.95 + shift]] * 20
        records += agents("a", EPISODES[None] + shift, environment_id=environment_id)
    records += agents("b", np.full((2, 20), 0.5), environment_id=first, mode="impedance")
    for name, level in (("hold", 0.3), ("zero_torque", 0.1)):
        records.append({**record(name, np.full(20, level), environment_id=first), "kind": FLOOR})
    found = {item.family: item for item in aggregate_tasks(group_conditions(records), 0)}
    assert list(found) == [
        BEST_CONTROLLER,
        BEST_AGENT,
        BEST_FLOOR,
        "agent, torque",
        "agent, impedance",
    ]
    assert found[BEST_FLOOR].score.value == pytest.approx(0.3)
    assert (found[BEST_CONTROLLER].tasks, found["agent, impedance"].tasks) == (2, 1)
    assert found[BEST_CONTROLLER].score.value == pytest.approx((0.95 + 0.75) / 2)
    assert found["agent, impedance"].reference.value == pytest.approx(0.95)
    profile = found[BEST_CONTROLLER].profile
    assert profile.value[profile.thresholds < 0.74].min() == 1.0
    assert profile.value[(profile.thresholds > 0.76) & (profile.thresholds < 0.94)] == pytest.approx(0.5)


def test_bootstrap_over_tasks_weighs_tasks_and_not_scores() -> None:
    rng = np.random.default_rng(0)
    scores = {"a": np.full((5, 30), 0.2), "b": np.full((1, 2), 0.8)}
    assert bootstrap_tasks(scores, rng) == pytest.approx((0.5, 0.5, 0.5))


def test_bootstrap_over_one_task_is_the_crossed_one() -> None:
    scores = np.random.default_rng(1).uniform(size=(3, 12))
    rng = np.random.default_rng
    assert bootstrap_tasks({"a": scores}, rng(5)) == bootstrap_crossed(scores, rng(5))


def test_interval_over_independent_tasks_is_narrower_by_the_root_of_their_number() -> None:
    scores = np.random.default_rng(1).normal(size=(1, 100))
    one = bootstrap_tasks({"a": scores}, np.random.default_rng(2))
    three = bootstrap_tasks(dict.fromkeys("abc", scores), np.random.default_rng(2))
    # three tasks: none is cut off; widths of percentile intervals of 2000 resamples vary by a few percent
    assert (three.high - three.low) * np.sqrt(3.0) == pytest.approx(one.high - one.low, rel=0.15)


def test_bootstrap_without_tasks_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="number of tasks"):
        bootstrap_tasks({}, np.random.default_rng(0))
