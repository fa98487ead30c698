"""Rank correlation against values computed by hand, and physical errors of policies."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from prp_gym.comparison.audit import LEAST_CORRELATION, Audit, audit_rewards
from prp_gym.comparison.rank import average_ranks, rank_correlation, resampled_correlations
from prp_gym.comparison.task_error import physical_errors
from prp_gym.comparison.values import Entry, group_conditions
from prp_gym.errors import ShapeError
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.tasks.spec import TaskError
from tests.support.synthetic_comparison import agents, record

ROUNDING = 1e-12  # a few additions of small numbers
JOINT_ERROR = TaskError({"joint_mean_error": (0.02, 0.01, 0.042)}, "made up as that of joint tracking is")


def test_ties_share_the_mean_of_their_ranks() -> None:
    values = np.array([3.0, 1.0, 3.0, np.inf, 2.0, np.inf, 3.0])
    # sorted: 1 2 3 3 3 inf inf on ranks 0 1 (2 3 4) (5 6)
    np.testing.assert_array_equal(average_ranks(values), [3.0, 0.0, 3.0, 5.5, 1.0, 5.5, 3.0])


def test_rank_correlation_with_ties_is_that_computed_by_hand() -> None:
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


def test_rank_correlation_with_a_constant_is_undefined() -> None:
    assert np.isnan(rank_correlation(np.ones(4), np.arange(4.0)))


def test_rank_correlation_of_different_lengths_is_refused() -> None:
    with pytest.raises(ShapeError, match="y has shape"):
        rank_correlation(np.ones(4), np.ones(3))


def test_resample_without_a_correlation_is_left_out() -> None:
    x = np.array([[1.0, 2.0, 3.0], [5.0, 5.0, 5.0], [1.0, 2.0, 3.0]])
    y = np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [3.0, 2.0, 1.0]])
    np.testing.assert_allclose(resampled_correlations(x, y), [1.0, -1.0], atol=ROUNDING)


def entry(**metrics: object) -> Entry:
    plain = record("joint_pd", [0.5, 0.5, 0.5])
    return Entry.of([{**plain, "episodes": {**plain["episodes"], **metrics}}])


def test_physical_error_is_the_sum_of_absolute_shares() -> None:
    made = entry(joint_mean_error=[[0.06, 0.04, 0.0], [0.0, 0.0, -0.042], [0.0, 0.02, 0.042]])
    # 3 + 4 + 0, 0 + 0 + 1, 0 + 2 + 1
    found = physical_errors(made, JOINT_ERROR)
    np.testing.assert_allclose(found, [[7.0, 1.0, 3.0]], atol=ROUNDING)


def test_physical_error_of_several_metrics_is_their_sum_in_their_own_units() -> None:
    made = entry(force_mean_error=[[1.0]] * 3, orientation_mean_error=[[0.1]] * 3)
    task_error = TaskError({"force_mean_error": (2.0,), "orientation_mean_error": (0.05,)}, "")
    np.testing.assert_allclose(physical_errors(made, task_error), [[2.5] * 3], atol=ROUNDING)
    assert task_error.name == "force_mean_error + orientation_mean_error"


def test_episode_that_diverged_has_an_infinite_error() -> None:
    made = entry(joint_mean_error=[[None] * 3, [0.0] * 3, [None, 0.0, 0.0]])
    assert physical_errors(made, JOINT_ERROR).tolist() == [[np.inf, 0.0, np.inf]]


def audited(*records: dict[str, object]) -> Audit:
    (audit,) = audit_rewards(group_conditions(records), 0)
    return audit


def test_reward_that_ranks_policies_otherwise_than_the_error_is_flagged() -> None:
    records = [record(name, [score]) for name, score in (("a", 0.9), ("b", 0.8), ("c", 0.2))]
    audit = audited(*records)
    assert [audit.correlation.value, audit.flagged, len(audit.policies)] == pytest.approx([1.0, False, 3])
    # 0.08 of (1, 0.5, 2) in units of (0.02 rad, 0.01 m, 0.042 rad)
    assert audit.policies["c"] == pytest.approx((0.2, 0.08 * (1 / 0.02 + 0.5 / 0.01 + 2 / 0.042)))
    records[0]["episodes"]["joint_mean_error"] = [[9.0, 9.0, 9.0]]
    audit = audited(*records)
    assert [audit.correlation.value, audit.flagged] == pytest.approx([-0.5, True])
    assert audited(records[0]).flagged


def test_least_correlation_itself_is_enough() -> None:
    records = [record(name, [score]) for name, score in (("a", 0.9), ("b", 0.8), ("c", 0.2), ("d", 0.1))]
    records[0]["episodes"]["joint_mean_error"] = [[0.025, 0.0, 0.0]]
    records[1]["episodes"]["joint_mean_error"] = [[0.020, 0.0, 0.0]]
    audit = audited(*records)  # two neighbours of four exchanged: 1 - 6 * 2 / 60
    assert audit.correlation.value == pytest.approx(LEAST_CORRELATION)
    assert not audit.flagged


def test_error_of_a_policy_is_the_interquartile_mean_over_rows_and_episodes() -> None:
    errors = np.array([[[50.0], [2.0], [3.0], [4.0]], [[0.0], [2.0], [3.0], [70.0]]])
    rows = agents("a", np.array([[0.5] * 4, [0.7] * 4]))
    for row, own in zip(rows, errors, strict=True):
        row["episodes"]["joint_mean_error"] = (own * [0.02, 0.0, 0.0]).tolist()
    audit = audited(*rows, record("b", [0.1] * 4))
    assert audit.policies["a"] == pytest.approx((0.6, 3.0))  # of 0 2 2 3 3 4 50 70 the middle four


def test_interval_of_the_correlation_is_over_episodes_that_all_policies_share() -> None:
    rng = np.random.default_rng(0)
    difficulty = 0.3 * rng.random(40)  # much more than what tells the policies apart, and the same for all
    paired = [record(name, 0.6 + step - difficulty) for name, step in (("a", 0.02), ("b", 0.01), ("c", 0.0))]
    assert audited(*paired).correlation == (1.0, 1.0, 1.0)
    noisy = [record(name, 0.5 + 0.3 * rng.random(40)) for name in "abcd"]
    for item in noisy:
        error = 0.1 * rng.random((40, 1)) * [1.0, 0.0, 0.0]
        item["episodes"]["joint_mean_error"] = error.tolist()
    value, low, high = audited(*noisy).correlation
    assert -1.0 <= low < value < high <= 1.0
    assert high - low > 0.8  # chance decides the order of what does not differ


def test_condition_with_a_single_policy_has_no_correlation() -> None:
    assert np.isnan(audited(record("a", [0.4, 0.5])).correlation).all()


def test_task_without_a_physical_error_is_left_out() -> None:
    records = [
        record("a", [0.4, 0.5]),
        record("a", [0.4, 0.5], environment_id="PRP-Unknown-v0"),
        record("b", [0.3, 0.2], environment_id="PRP-Unknown-v0"),
    ]
    (audit,) = audit_rewards(group_conditions(records), 0)
    assert audit.environment_id == "PRP-JointTracking-v0"


def test_audit_names_the_error_and_its_reason() -> None:
    audit = audited(record("a", [0.4]))
    error = scoring_of("PRP-JointTracking-v0").error
    assert error is not None
    assert (audit.physical_error, audit.reason) == ("joint_mean_error", error.reason)
