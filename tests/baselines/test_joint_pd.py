"""Joint-space PD: torques against the formula, gravity modes, and dissipated energy."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import JointPDController, JointPDSettings
from prp_gym.baselines.joint_pd import GRAVITY_MODES
from prp_gym.errors import UnknownNameError
from prp_gym.robot import NOMINAL, Link, PRPArm, RobotParameters
from tests.support.control_interface import INTERFACE, LINK_INTERFACE, POSE_INTERFACE
from tests.support.pinocchio_model import PinocchioArm, per_row, random_arm, random_states

Array = NDArray[np.float64]

K_P, K_D = np.array([50.0, 500.0, 40.0]), np.array([15.0, 150.0, 5.0])
ROUNDING = 1e-12  # torques up to 1e3, a dozen operations of 1e-16 each
# where each mode takes gravity at, from (actual, desired) positions
GRAVITY_AT: dict[str, Callable[[PinocchioArm, Array, Array], Array]] = {
    "current": lambda arm, q, desired: per_row(arm.gravity_vector, q),
    "desired": lambda arm, q, desired: per_row(arm.gravity_vector, desired),
    "none": lambda arm, q, desired: np.zeros_like(q),
}


def controller(**settings: Any) -> JointPDController:
    return JointPDController(
        INTERFACE, JointPDSettings(**{"proportional_gain": K_P, "derivative_gain": K_D, **settings})
    )


def observed(seed: int, count: int) -> dict[str, Array]:
    """Random measurements and references, (count, 3) each."""
    q, velocity, _, _ = random_states(seed, count)
    desired, desired_velocity, _, _ = random_states(seed + 1, count)
    return {
        "joint_position": q,
        "joint_velocity": velocity,
        "desired_joint_position": desired,
        "desired_joint_velocity": desired_velocity,
        "desired_joint_acceleration": np.zeros_like(q),
    }


def test_every_mode_is_tested() -> None:
    assert set(GRAVITY_AT) == set(GRAVITY_MODES)


@pytest.mark.parametrize(
    ("model", "oracle"), [(NOMINAL, PinocchioArm()), random_arm(8)], ids=["nominal", "another"]
)
@pytest.mark.parametrize("gravity", GRAVITY_MODES)
def test_torque_is_gravity_and_springs_and_dampers(
    gravity: str, model: RobotParameters, oracle: PinocchioArm
) -> None:
    given = observed(1, 50)
    q, desired = given["joint_position"], given["desired_joint_position"]
    springs = K_P * (desired - q)
    dampers = K_D * (given["desired_joint_velocity"] - given["joint_velocity"])
    expected = GRAVITY_AT[gravity](oracle, q, desired) + springs + dampers
    torque = controller(gravity=gravity, model=model).torque(given)
    np.testing.assert_allclose(torque, expected, rtol=ROUNDING, atol=ROUNDING)


def test_gravity_modes_differ_away_from_the_goal_and_agree_but_for_none_at_it() -> None:
    given = observed(2, 20)
    current, desired, none = (
        controller(gravity=mode).torque(given) for mode in ("current", "desired", "none")
    )
    assert (current != desired)[:, 2].all()
    assert (current != none)[:, 2].all()
    at_goal = {**given, "desired_joint_position": given["joint_position"]}
    np.testing.assert_array_equal(controller(gravity="desired").torque(at_goal), controller().torque(at_goal))


def test_gravity_is_current_and_the_model_nominal_unless_named() -> None:
    settings = JointPDSettings(K_P, K_D)
    assert (settings.gravity, settings.model) == ("current", None)
    assert controller().model == PRPArm(NOMINAL)


def test_one_number_stands_for_all_joints() -> None:
    given = observed(3, 5)
    same = controller(proportional_gain=[7.0] * 3, derivative_gain=[2.0] * 3).torque(given)
    np.testing.assert_array_equal(controller(proportional_gain=7, derivative_gain=2.0).torque(given), same)


@pytest.mark.parametrize("mode", ["curent", "g(q)", "", None, 1, True])
def test_unknown_gravity_mode_lists_the_valid_ones(mode: Any) -> None:
    with pytest.raises(UnknownNameError, match="Valid: current, desired, none") as caught:
        controller(gravity=mode)
    assert caught.value.kind == "gravity"


def test_misspelt_gravity_mode_gets_the_nearest_name() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean 'current'"):
        controller(gravity="curent")


def test_arm_at_rest_at_its_goal_stays_there() -> None:
    arm = PinocchioArm()
    q, *_ = random_states(4, 20)
    still = np.zeros_like(q)
    for mode in ("current", "desired"):
        torque = controller(gravity=mode).torque(
            {
                "joint_position": q,
                "joint_velocity": still,
                "desired_joint_position": q,
                "desired_joint_velocity": still,
                "desired_joint_acceleration": still,
            }
        )
        acceleration = per_row(arm.forward_dynamics, q, still, torque, still)
        # rounding of torques of order 1, over a least inertia of 0.0095
        np.testing.assert_allclose(acceleration, 0.0, atol=1e-12)


def test_only_the_dampers_take_energy_out() -> None:
    """d/dt (½ q̇ᵀBq̇ + ½ q̃ᵀK_P q̃) = -q̇ᵀK_D q̇ for a constant reference and g(q)."""
    arm, h = PinocchioArm(), 1e-6
    given = observed(5, 20) | {"desired_joint_velocity": np.zeros((20, 3))}
    q, velocity, goal = given["joint_position"], given["joint_velocity"], given["desired_joint_position"]
    acceleration = per_row(arm.forward_dynamics, q, velocity, controller().torque(given), np.zeros_like(q))

    def stored(step: float) -> Array:
        """Kinetic energy and the springs', a step later on the motion's second-order expansion."""
        later = q + step * velocity + step**2 / 2 * acceleration
        kinetic = per_row(arm.kinetic_energy, later, velocity + step * acceleration)
        springs: Array = 0.5 * np.sum(K_P * (goal - later) ** 2, axis=1)
        return kinetic + springs

    rate = (stored(h) - stored(-h)) / (2 * h)
    # central differences over 1e-6 s: 1e-12 of rounding in energies up to 1e4 J, and the third derivative,
    # accelerations reaching 1e4 rad/s²
    np.testing.assert_allclose(rate, -np.sum(K_D * velocity**2, axis=1), rtol=1e-6, atol=1e-4)


def test_reference_may_come_from_operational_space() -> None:
    given, names = observed(6, 20), ("desired_pose", "desired_velocity", "desired_acceleration")
    motion = PRPArm().pose_motion(
        *(given[f"desired_joint_{name}"] for name in ("position", "velocity", "acceleration"))
    )
    moved = given | dict(zip(names, motion, strict=True))
    torque = JointPDController(POSE_INTERFACE, JointPDSettings(K_P, K_D)).torque(moved)
    # there and back through the kinematics, whose condition number is below 4, times gains of 500
    np.testing.assert_allclose(torque, controller().torque(given), rtol=1e-10, atol=1e-9)


def test_link_is_controlled_by_the_same_controller() -> None:
    pendulum = JointPDController(LINK_INTERFACE, JointPDSettings(7.0, 2.0))
    torque = pendulum.torque(pendulum.interface.layout.split([0.3, -0.5, 0.6, 0.7, 0.0]))
    assert torque == pytest.approx(1.85 * np.sin(0.3) + 7.0 * 0.3 + 2.0 * 1.2, rel=1e-13)
    assert pendulum.model == Link()
