"""Every declared metric on one made-up episode whose values are known beforehand."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from prp_gym.evaluation import METRICS, Metric, Rollout, episode_metrics
from prp_gym.registry import NOT_IN_THE_REPORT
from tests.support.synthetic_episodes import (
    SAMPLES,
    TIME,
    Array,
    joint_fields,
    jump,
    make_rollout,
    pose,
    reference,
)

STEPS = SAMPLES - 1


def constant(*values: float) -> Array:
    return np.tile(values, (SAMPLES, 1))


def everything(joints: int = 3) -> Rollout:
    """An episode with the fields of all tasks.

    Joints and tip jump to their goals at the first sample, the tip over 0.5 m and 0.5 rad. It stays 7 mm
    and 0.05 rad from the model. It presses with 3 N for a tenth of a second from 0.2 s on and with the
    desired 2 N thereafter, but leaves the surface at 0.6 s for one sample; it always moves along the
    force at 0.15 m/s, its reference at 0.05 m/s.
    """
    force = np.where(TIME < 0.195, 0.0, np.where(TIME < 0.295, 3.0, 2.0))
    force[60] = 0.0
    away = np.where(TIME < 0.005, 1.0, 0.0)[:, None]
    desired = pose(constant(0.4, -0.3, 0.2), constant(0.5, 1.5))
    offset = np.array([0.3, 0.0, -0.4, 0.4, -0.3, 0.0])
    tip = desired - away * offset
    fields = joint_fields(jump(1)[:, :joints], reference()[:, :joints]) | {
        "end_effector_pose": tip,
        "end_effector_velocity": constant(0.0, 0.15, 0.0, 9.0, 9.0, 9.0),
        "desired_pose": desired,
        "desired_velocity": constant(0.0, 0.05, 0.0, 0.0, 0.0, 0.0),
        "model_pose": tip + np.array([0.002, -0.003, 0.006, 0.03, 0.04, 0.0]),
        "contact_force": force[:, None] * np.array([0.0, 1.0, 0.0]),
        "desired_force": constant(0.0, 2.0, 0.0),
    }
    plain = make_rollout(fields, joints)
    return replace(plain, info={**plain.info, "cost_force_bound": (np.arange(STEPS) < 10).astype(float)})


EXPECTED = {
    "score": [0.6],
    "divergence": [0.0],
    "response_settling_time": [0.01],
    "unsettled": [0.0],
    "failure": [0.0, 100.0, 0.0, 0.0],  # 3 N where 2 N are desired
    "joint_rmse": [1.0 / np.sqrt(SAMPLES), 0.2 / np.sqrt(SAMPLES), 2.0 / np.sqrt(SAMPLES)],
    "joint_mean_error": [1.0 / SAMPLES, 0.2 / SAMPLES, 2.0 / SAMPLES],
    "joint_maximum_error": [1.0, 0.2, 2.0],
    "settling_time": [0.01],
    "overshoot": [0.0],
    "steady_state_error": [0.0, 0.0, 0.0],
    "position_rmse": [0.5 / np.sqrt(SAMPLES)],
    "position_mean_error": [0.5 / SAMPLES],
    "position_maximum_error": [0.5],
    "orientation_rmse": [0.5 / np.sqrt(SAMPLES)],
    "orientation_mean_error": [0.5 / SAMPLES],
    "orientation_maximum_error": [0.5],
    "position_settling_time": [0.01],
    "position_overshoot": [0.0],
    "position_steady_state_error": [0.0],
    "model_position_rmse": [0.007],
    "model_orientation_rmse": [0.05],
    "model_position_mean_error": [0.007],
    "model_orientation_mean_error": [0.05],
    "model_maximum_error": [0.007],
    "force_rmse": [np.sqrt((21 * 2.0**2 + 10 * 1.0**2) / SAMPLES)],
    "force_mean_error": [(21 * 2.0 + 10 * 1.0) / SAMPLES],
    "surface_mean_error": [0.5 / SAMPLES],  # the tip is off by (0.3, 0, -0.4) m, across the force along y
    "steady_state_force_error": [0.0],
    "force_settling_time": [0.61 - 0.2],
    "force_overshoot": [50.0],
    "peak_force_ratio": [150.0],
    "peak_force": [3.0],
    "contact_losses": [1.0],
    "force_violation": [10.0],
    # 0.1 m/s ahead of the reference against 10·3 N and 70·2 N for 0.01 s each, half of the last sample
    "injected_energy": [0.1 * 0.01 * (30.0 + 140.0 - 1.0)],
    "energy": [26.0],
    "excess_energy": [0.0],
    "torque_rms": [10.0, 20.0, 3.0],
    "torque_rate": [0.0, 0.0, 0.0],
    "saturation": [50.0],
    "joint_stop": [25.0 / 3.0],
}

JOINT_WISE = {name for name, values in EXPECTED.items() if len(values) == 3}
DECLARED = {"response_settling_time", "unsettled", "failure"}
"""Metrics whose fields follow from the task's settling criterion."""


def test_every_metric_of_the_report_is_expected() -> None:
    named = [name for name, metric in METRICS.items() if metric.chapter != NOT_IN_THE_REPORT]
    assert named == list(EXPECTED)  # in the order of results and pages


@pytest.mark.parametrize("metric", [METRICS[name] for name in EXPECTED], ids=lambda metric: metric.name)
def test_declared_metric_of_a_known_episode(metric: Metric) -> None:
    episode = everything()
    values = metric.values(episode)
    assert values.shape == (len(metric.units),) == (metric.components(episode),)
    # sums of a hundred numbers, the time a difference
    np.testing.assert_allclose(values, EXPECTED[metric.name], rtol=1e-10, atol=1e-10)
    np.testing.assert_array_equal(episode_metrics(episode)[metric.name], values)
    assert metric.definition
    assert metric.higher_is_better == (metric.name == "score")


def test_robot_of_one_joint_has_one_number_a_joint_and_its_own_shares() -> None:
    expected = {name: values[:1] for name, values in EXPECTED.items() if name not in DECLARED}
    expected |= {
        "energy": [10.0],
        "saturation": [50.0],
        "joint_stop": [25.0],
    }  # 10 N·m at 1 rad/s; of 1 joint
    values = episode_metrics(everything(joints=1))
    assert set(expected) <= set(values)
    for name in expected:
        np.testing.assert_allclose(values[name], expected[name], rtol=1e-10, atol=1e-10, err_msg=name)


@pytest.mark.parametrize("joints", [1, 3])
def test_after_a_divergence_only_the_outcome_counts(joints: int) -> None:
    values = episode_metrics(replace(everything(joints), diverged=True))
    np.testing.assert_array_equal(values.pop("divergence"), [100.0])
    np.testing.assert_allclose(values.pop("score"), [0.6], rtol=1e-12)
    np.testing.assert_array_equal(values.pop("failure"), [100.0, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(values.pop("response_settling_time"), [np.inf])
    np.testing.assert_array_equal(values.pop("unsettled"), [100.0])
    assert len(values) == len(METRICS) - 5
    for name, numbers in values.items():
        np.testing.assert_array_equal(numbers, np.full(joints if name in JOINT_WISE else 1, np.nan))


def test_score_counts_what_a_divergence_cut_off_as_nothing() -> None:
    values = episode_metrics(replace(everything(), diverged=True, duration=4.0))
    np.testing.assert_allclose(values["score"], [0.15], rtol=1e-12)


ALWAYS = {"score", "divergence", "failure", "torque_rms", "torque_rate"}


def test_metrics_exist_where_their_fields_and_cost_terms_exist() -> None:
    bare = make_rollout({"any": np.zeros((SAMPLES, 1))})
    assert set(episode_metrics(replace(bare, info={}))) == ALWAYS
    assert set(episode_metrics(bare)) == ALWAYS | {"saturation", "joint_stop"}


@pytest.mark.parametrize(
    "metric", [METRICS[name] for name in EXPECTED if name not in DECLARED], ids=lambda metric: metric.name
)
def test_metric_reads_what_it_requires_and_is_absent_without_any_of_it(metric: Metric) -> None:
    full = everything()
    content: dict[str, Any] = {**full.fields, **full.info}
    fields = {name: content[name] for name in metric.requires if name in full.fields}
    info = {name: content[name] for name in metric.requires if name in full.info}
    enough = replace(full, fields=fields, info=info)
    np.testing.assert_allclose(episode_metrics(enough)[metric.name], EXPECTED[metric.name], atol=1e-10)
    for missing in metric.requires:
        less = replace(
            full,
            fields={name: values for name, values in full.fields.items() if name != missing},
            info={name: values for name, values in full.info.items() if name != missing},
        )
        assert metric.name not in episode_metrics(less)


@pytest.mark.parametrize("joints", [1, 3])
def test_metrics_of_an_episode_are_those_of_each_metric_alone(joints: int) -> None:
    """What several metrics share is computed once for an episode, and changes no bit."""
    rng = np.random.default_rng(joints)
    regular = everything(joints)
    fields = {name: values + rng.normal(size=values.shape) for name, values in regular.fields.items()}
    for rollout in (regular, replace(regular, fields=fields)):
        together = episode_metrics(rollout)
        assert together.keys() == {name for name, metric in METRICS.items() if metric.exists(rollout)}
        for name, values in together.items():
            np.testing.assert_array_equal(values, METRICS[name].values(rollout), name, strict=True)


def test_number_in_info_does_not_stand_in_for_the_field_of_the_same_name() -> None:
    bare = make_rollout({"any": np.zeros((SAMPLES, 1))}, info={"contact_force": np.ones(STEPS)})
    assert "peak_force" not in episode_metrics(bare)


def test_episode_of_one_step_has_every_metric_but_the_torque_rate() -> None:
    full = everything()
    short = replace(
        full,
        **{name: getattr(full, name)[:1] for name in ("torque", "applied_torque", "reward", "compute_time")},
        fields={name: values[:2] for name, values in full.fields.items()},
        info={name: values[:1] for name, values in full.info.items()},
        duration=full.period,
    )
    values = episode_metrics(short)
    assert {name for name, numbers in values.items() if np.isnan(numbers).any()} == {"torque_rate"}
    assert {name for name, numbers in values.items() if np.isinf(numbers).any()} == {"force_settling_time"}
    np.testing.assert_allclose(values["position_rmse"], [np.sqrt(0.125)], rtol=1e-12)  # 0.5 m, then none
    np.testing.assert_array_equal(values["peak_force"], [0.0])
