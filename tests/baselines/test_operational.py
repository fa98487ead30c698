"""Behaviour that all controllers of the arm share: batches, singular poses, random moves with tuned gains."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import (
    BASELINES,
    Baseline,
    ControlInterface,
    OperationalPDController,
    OperationalPDSettings,
)
from prp_gym.baselines.base.gains import load_gains
from prp_gym.errors import InvalidValueError, MissingFieldError
from prp_gym.robot import Link
from tests.support.control_interface import (
    LIMIT,
    LINK_INTERFACE,
    PERIOD,
    POSE_INTERFACE,
    POSE_LAYOUT,
    random_pose_observation,
    rows_of,
)
from tests.support.controller_simulation import hold, quintic, simulate
from tests.support.pinocchio_model import PinocchioArm

Array = NDArray[np.float64]

OPERATIONAL = ("operational_pd", "operational_inverse_dynamics", "compliance", "impedance")
ARM_CONTROLLERS = ("joint_pd", "joint_inverse_dynamics", "adaptive", *OPERATIONAL)
MOVERS = ("adaptive", *OPERATIONAL)


def make(name: str, gains: str = "tuned") -> Baseline[Any]:
    values = load_gains(name, gains, "PRP-PoseRegulation-v0")
    settings = {k: v for k, v in values.items() if k not in ("source", "minimum_frequency")}
    controller = BASELINES[name]
    return controller.policy(POSE_INTERFACE, controller.settings_class.from_mapping(name, settings))


@pytest.mark.parametrize("name", ARM_CONTROLLERS)
def test_batch_gives_the_torques_of_each(name: str) -> None:
    controller, given = make(name), random_pose_observation(PinocchioArm(), 1, 10)
    torques, after = controller.control(given, controller.initial_state(given))
    assert torques.shape == (10, 3)
    for index, row in enumerate(rows_of(given)):
        torque, state = controller.control(row, controller.initial_state(row))
        # batched and single matrix products may round differently: a few dozen operations of 1e-16 each
        np.testing.assert_allclose(torque, torques[index], rtol=1e-12, atol=1e-12 * np.abs(torques).max())
        for one, many in zip(state, after, strict=True):
            np.testing.assert_allclose(one, many[index], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", ARM_CONTROLLERS)
def test_leading_dimensions_may_be_several(name: str) -> None:
    controller, given = make(name), random_pose_observation(PinocchioArm(), 2, 6)
    flat, _ = controller.control(given, controller.initial_state(given))
    folded = {key: value.reshape(2, 3, -1) for key, value in given.items()}
    torque, _ = controller.control(folded, controller.initial_state(folded))
    np.testing.assert_allclose(torque.reshape(6, 3), flat, rtol=1e-12, atol=1e-12 * np.abs(flat).max())


@pytest.mark.parametrize("name", ARM_CONTROLLERS)
def test_observation_is_left_as_it_was(name: str) -> None:
    controller, given = make(name), random_pose_observation(PinocchioArm(), 3, 4)
    for values in given.values():
        values.flags.writeable = False
    controller.control(given, controller.initial_state(given))


@pytest.mark.parametrize("name", ARM_CONTROLLERS)
def test_slow_path_through_both_singular_poses_is_followed_smoothly(name: str) -> None:
    start, goal = (-0.3, -0.05, 1.0), (0.3, -0.15, 2.9)
    run = simulate(make(name), start, quintic(start, goal, 2.0), 2.2)
    q = run.joint_position[:, 0]
    reach = q[:, 1] + 0.3 + 0.24 * np.cos(q[:, 2])
    assert q[:, 2].min() < np.pi / 2 < q[:, 2].max()
    assert reach.min() < 0.0 < reach.max()
    # compliance brakes a moving reference, which lags by about K_D/K_P = 0.3 s at up to 1.8 rad/s
    assert np.abs(run.joint_error[:, 0]).max() < (0.6 if name == "compliance" else 0.1)
    assert (np.abs(np.diff(run.torque[:, 0], axis=0)) < 0.05 * LIMIT).all()


@pytest.mark.parametrize("name", MOVERS)
def test_tuned_gains_make_any_move_without_chatter(name: str) -> None:
    generator = np.random.default_rng(6)
    start, goal = generator.uniform([-2.9, -0.285, -2.9], [2.9, -0.015, 2.9], (2, 12, 3))
    run = simulate(make(name), start, hold(goal), 3.0)
    tip = np.linalg.norm(run.pose_error[..., :3], axis=-1)
    assert (tip[-1] < 5e-3).all()  # [m]
    last = run.torque[-250:]
    assert (np.abs(np.diff(last, axis=0)).max(axis=(0, 1)) < 1e-3 * LIMIT).all()


@pytest.mark.parametrize("name", OPERATIONAL)
def test_link_has_no_pose_to_control(name: str) -> None:
    controller = BASELINES[name]
    with pytest.raises(MissingFieldError, match="end_effector_pose"):
        controller.policy(LINK_INTERFACE, make(name).settings)


def test_model_that_has_no_pose_is_refused() -> None:
    interface = ControlInterface("PRP-A-v0", POSE_LAYOUT, LIMIT, PERIOD, Link())
    with pytest.raises(InvalidValueError, match="the arm: a link has no pose"):
        OperationalPDController(interface, OperationalPDSettings(1.0, 1.0))
