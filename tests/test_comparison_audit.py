"""Rank correlation against values worked out by hand, and what is taken for the physical error."""

import gymnasium
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from prp_gym import list_envs
from prp_gym.compared_pairs import ZeroPolicy
from prp_gym.comparison.audit import (
    GAUGES,
    Gauge,
    audit_rewards,
    average_ranks,
    physical_error,
    rank_correlation,
)
from prp_gym.comparison.values import Entry, group_places
from prp_gym.errors import ShapeError
from prp_gym.evaluation import METRICS, evaluate
from tests.made_up_comparison import record

ROUNDING = 1e-12  # a few additions of small numbers


def test_ties_share_the_mean_of_their_ranks() -> None:
    values = np.array([3.0, 1.0, 3.0, np.inf, 2.0, np.inf, 3.0])
    # sorted: 1 2 3 3 3 inf inf on ranks 0 1 (2 3 4) (5 6)
    np.testing.assert_array_equal(average_ranks(values), [3.0, 0.0, 3.0, 5.5, 1.0, 5.5, 3.0])


def test_rank_correlation_with_ties_is_that_worked_out_by_hand() -> None:
    # ranks of x less their mean: -1.5 0 0 1.5; of y: -1.5 -0.5 0.5 1.5; products 4.5, squares 4.5 and 5
    found = rank_correlation(np.array([1.0, 2.0, 2.0, 4.0]), np.array([0.0, 1.0, 2.0, 9.0]))
    assert found == pytest.approx(4.5 / np.sqrt(4.5 * 5.0), abs=ROUNDING)


def test_rank_correlation_without_ties_is_the_formula_of_squared_differences() -> None:
    x, y = np.array([106.0, 100.0, 86.0, 101.0, 99.0]), np.array([7.0, 27.0, 2.0, 50.0, 28.0])
    # ranks of x: 4 2 0 3 1, of y: 1 2 0 4 3; squared differences 9 + 0 + 0 + 1 + 4 = 14
    assert rank_correlation(x, y) == pytest.approx(1.0 - 6.0 * 14.0 / (5.0 * 24.0), abs=ROUNDING)


@given(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=20, unique=True))
def test_rank_correlation_of_a_monotonic_change_is_one(values: list[float]) -> None:
    x = np.array(values)
    order = np.argsort(np.argsort(x)).astype(np.float64)
    assert rank_correlation(x, order**3) == pytest.approx(1.0, abs=ROUNDING)
    assert rank_correlation(x, -order) == pytest.approx(-1.0, abs=ROUNDING)


def test_rank_correlation_with_a_constant_is_none() -> None:
    assert np.isnan(rank_correlation(np.ones(4), np.arange(4.0)))


def test_rank_correlation_of_different_lengths_is_refused() -> None:
    with pytest.raises(ShapeError, match="y has shape"):
        rank_correlation(np.ones(4), np.ones(3))


def entry(**metrics: object) -> Entry:
    plain = record("joint_pd", [0.5, 0.5, 0.5])
    return Entry.of([{**plain, "episodes": {**plain["episodes"], **metrics}}])


def test_physical_error_is_the_median_of_the_norm_in_units_of_the_scales() -> None:
    made = entry(joint_rmse=[[0.06, 0.04, 0.0], [0.0, 0.0, 0.042], [0.0, 0.02, 0.0]])
    # norms of (3, 4, 0), (0, 0, 1), (0, 2, 0)
    assert physical_error(made, GAUGES["PRP-JointTracking-v0"]) == pytest.approx((2.0, 0.0), abs=ROUNDING)


def test_metric_of_one_joint_takes_the_first_scale() -> None:
    made = entry(joint_rmse=[[0.3], [0.3], [0.3]])
    assert physical_error(made, Gauge({"joint_rmse": (0.1, 9.0, 9.0)}, "", {}))[0] == pytest.approx(3.0)


def test_episode_that_diverged_has_an_infinite_error() -> None:
    made = entry(joint_rmse=[[None] * 3, [None] * 3, [0.0] * 3])
    assert physical_error(made, GAUGES["PRP-JointTracking-v0"])[0] == np.inf


def regulating(policy: str, score: float, settling: object, error: float) -> dict[str, object]:
    plain = record(policy, [score], environment_id="PRP-JointRegulation-v0")
    metrics = {"settling_time": [[settling]], "steady_state_error": [[error, 0.0, 0.0]]}
    return {**plain, "episodes": {**plain["episodes"], **metrics}}


def test_policies_that_never_settle_are_ordered_by_their_steady_error() -> None:
    records = [
        regulating("a", 0.9, 0.5, 0.3),
        regulating("b", 0.7, 0.6, 0.0),
        regulating("c", 0.5, "inf", 0.1),
        regulating("d", 0.1, "inf", 0.4),
    ]
    (audit,) = audit_rewards(group_places(records))
    assert [audit.correlation, audit.flagged] == pytest.approx([1.0, False])
    assert audit.policies["d"] == pytest.approx((0.1, np.inf, 20.0))
    records[2]["episodes"]["steady_state_error"] = [[0.5, 0.0, 0.0]]  # type: ignore[index]
    (audit,) = audit_rewards(group_places(records))
    assert audit.correlation == pytest.approx(0.8)  # two neighbours of four exchanged: 1 - 6 * 2 / 60
    assert not audit.flagged


def test_reward_that_orders_otherwise_than_the_error_is_flagged() -> None:
    records = [record(name, [score]) for name, score in (("a", 0.9), ("b", 0.8), ("c", 0.2))]
    (audit,) = audit_rewards(group_places(records))
    assert [audit.correlation, audit.flagged, len(audit.policies)] == pytest.approx([1.0, False, 3])
    records[0]["episodes"]["joint_rmse"] = [[9.0, 9.0, 9.0]]
    (audit,) = audit_rewards(group_places(records))
    assert [audit.correlation, audit.flagged] == pytest.approx([-0.5, True])
    (alone,) = audit_rewards(group_places(records[:1]))
    assert alone.flagged


def test_every_environment_has_a_gauge_of_metrics_that_it_has() -> None:
    assert set(GAUGES) == set(list_envs())
    units = {metric.name: metric.units for metric in METRICS}
    for environment_id, gauge in GAUGES.items():
        env = gymnasium.make(environment_id, duration=0.1)
        found = evaluate(ZeroPolicy(env.action_space.shape[0]), env, 1).metrics  # type: ignore[index]
        env.close()
        for name, scale in (*gauge.parts.items(), *gauge.ties.items()):
            assert name in found
            assert len(scale) in (1, len(units[name]))
            assert found[name].shape[1] == len(scale) or environment_id == "PRP-Adaptive-v0"
        assert gauge.reason
