"""The sweep of gains tries what it says."""

from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from bench import sweep_gains
from prp_gym.baselines import BASELINES
from prp_gym.errors import UnknownNameError


def test_inverse_dynamics_gains_are_those_of_the_oscillator() -> None:
    gains = sweep_gains.CANDIDATES["joint_inverse_dynamics"](10.0, 0.7, np.ones(3))
    roots = np.roots([1.0, *(np.ravel(gains[name])[0] for name in ("derivative_gain", "proportional_gain"))])
    np.testing.assert_allclose(np.abs(roots), 10.0, rtol=1e-12)  # rounding
    np.testing.assert_allclose(-roots.real / np.abs(roots), 0.7, rtol=1e-12)


def test_mean_inertia_lies_between_the_extremes_over_the_joint_range() -> None:
    arm = prp_gym.PRPArm()
    grid = np.stack(np.meshgrid([0.0], np.linspace(-0.3, 0.0, 31), np.linspace(-np.pi, np.pi, 61)), axis=-1)
    diagonal = np.einsum("...ii->...i", arm.inertia_matrix(grid)).reshape(-1, 3)
    mean = sweep_gains.mean_inertia()
    assert diagonal[:, 0].min() < mean[0] < diagonal[:, 0].max()
    np.testing.assert_allclose(mean[1:], diagonal[0, 1:], rtol=1e-12)  # constant over the range


def test_sweep_orders_candidates_and_drops_those_that_chatter(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep_gains, "FREQUENCIES", (8.0, 20.0, 400.0))
    monkeypatch.setattr(sweep_gains, "DAMPING_RATIOS", (1.0,))
    monkeypatch.setattr(sweep_gains, "EPISODES", 2)
    monkeypatch.setattr(sweep_gains, "SCENARIOS", ("realistic",))
    results = sweep_gains.sweep("joint_inverse_dynamics", "JointTracking", 500.0)
    # at 400 rad/s the derivative gain times the control period is 1.6: with an actuation delay it oscillates
    assert {frequency for _, frequency, _ in results} == {8.0, 20.0}
    assert [score for score, *_ in results] == sorted((score for score, *_ in results), reverse=True)


def test_force_loop_is_a_twelfth_as_fast_as_the_position_loop_inside() -> None:
    for controller in ("force_inner_position", "parallel_force_position"):
        gains = sweep_gains.CANDIDATES[controller](120.0, 1.0, np.ones(3))
        assert gains == {"proportional_gain": 14400.0, "derivative_gain": 240.0, "bandwidth": 10.0}
        assert sweep_gains.RATES[controller] == (500.0,)


def test_controller_that_has_nothing_to_sweep_is_refused_before_any_sweep(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def never(*arguments: object) -> None:
        raise AssertionError("swept")

    monkeypatch.setattr(sweep_gains, "sweep", never)
    with pytest.raises(UnknownNameError) as caught:
        sweep_gains.main(["admittance", "impedance"])
    assert "controller to sweep 'impedance'" in str(caught.value)
    assert caught.value.valid == tuple(sorted(sweep_gains.TASKS))


def test_every_swept_controller_has_candidates_and_gains_to_start_from() -> None:
    assert set(sweep_gains.CANDIDATES) == set(sweep_gains.TASKS)
    for controller, conditions in sweep_gains.TASKS.items():
        for task in conditions:
            env = gymnasium.make(f"PRP-{task}-v0")
            settings: dict[str, Any] = dict(
                sweep_gains.CANDIDATES[controller](10.0, 0.7, sweep_gains.inertia_of(controller, task))
            )
            assert type(prp_gym.make_baseline(controller, env, **settings)) is BASELINES[controller].policy
