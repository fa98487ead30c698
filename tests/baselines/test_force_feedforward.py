"""Feed-forward force control: against Newton-Euler's and the closed forms of a mass with a damper."""

from dataclasses import replace

import numpy as np
import pytest

from prp_gym.robot import PRPArm
from tests.support.contact_cases import controller, random_cases, random_observation, repeated
from tests.support.contact_plant import Wall, simulate
from tests.support.control_interface import column_space_of, pose_acceleration
from tests.support.pinocchio_model import PinocchioArm

NAME = "force_feedforward"
ARM = PRPArm()


def test_arm_accelerates_as_the_motion_control_asks_across_the_force() -> None:
    """By Pinocchio: under the applied force as contact force a = P(...) remains, without a part along n."""
    observed = random_observation(4, 5)
    chosen = controller(NAME, "tuned")
    torque, state = chosen.control(observed, ())
    assert state == ()
    oracle = PinocchioArm()
    settings = chosen.settings
    n = observed["desired_force"] / np.linalg.norm(observed["desired_force"], axis=-1, keepdims=True)
    rate = np.einsum("nk,nk->n", n, observed["end_effector_velocity"][:, :3])[:, None]
    applied = observed["desired_force"] - settings.approach_damping * rate * n
    expected = (
        observed["desired_acceleration"]
        + settings.derivative_gain * (observed["desired_velocity"] - observed["end_effector_velocity"])
        + settings.proportional_gain * (observed["desired_pose"] - observed["end_effector_pose"])
    )
    expected[:, :3] -= np.einsum("nk,nk->n", n, expected[:, :3])[:, None] * n
    found = pose_acceleration(oracle, observed, torque, applied)
    # accelerations up to 1e5, of which the joints realise the part in the columns of J_A
    difference = column_space_of(oracle, observed, found - expected)
    np.testing.assert_allclose(difference, 0.0, atol=1e-3)


def test_force_at_rest_is_the_desired_one_though_none_is_measured() -> None:
    cases = repeated(random_cases(6, 4), 2)
    wall = replace(cases.wall, stiffness=np.repeat([300.0, 1000.0], 4), damping=np.full(8, 5.0))
    recording = simulate(controller(NAME, "tuned"), cases.joint_position, wall, 3.0 * cases.into, 3.0)
    # (d + D)/m of about 20 1/s and m of about 1.5 kg: exp(-10 · 2) after the touch
    np.testing.assert_allclose(recording.force[-1], 3.0 * cases.into, atol=0.02)


@pytest.mark.parametrize(("share", "stable"), [(0.9, True), (1.1, False)])
def test_held_damping_is_stable_up_to_twice_the_mass_over_the_period(share: float, stable: bool) -> None:
    """v ← (1 - d dt/m) v of a mass m: |1 - d dt/m| < 1 for d dt < 2 m."""
    q = np.array([[0.3, -0.1, 0.4]])
    into = np.array([[np.sin(0.3), -np.cos(0.3), 0.0]])
    jacobian = ARM.analytical_jacobian(q)[0, :3]
    axis = into[0] @ jacobian
    mobility = axis @ np.linalg.solve(ARM.inertia_matrix(q)[0], axis)
    chosen = controller(NAME, "tuned", approach_damping=share * 2.0 / (mobility * 0.002))
    wall = Wall.ahead(ARM.forward_kinematics(q)[:, :3], into, np.full(1, 1.0), np.full(1, 50.0))
    recording = simulate(chosen, q, wall, 1.0 * into, 0.1)
    speed = np.abs(np.diff(np.einsum("tnk,nk->tn", recording.pose[..., :3], into), axis=0))
    assert (speed[-1] < 1e-4).all() == stable
