"""Parallel force/position control: formula, steady state, all surfaces, motion across the force."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import ForceLoopSettings, ParallelForcePositionController
from prp_gym.robot import PRPArm
from tests.support.contact_cases import (
    UNLIMITED,
    controller,
    random_cases,
    random_observation,
    slide_direction,
    torque_for,
)
from tests.support.contact_plant import Wall, held, interface, simulate

Array = NDArray[np.float64]

NAME = "parallel_force_position"
ARM = PRPArm()
M_D = np.array([0.5, 0.6, 0.7, 0.8, 0.9, 1.0])
K_D = np.array([10.0, 20.0, 30.0, 40.0, 50.0, 60.0])
K_P = np.array([100.0, 200.0, 300.0, 400.0, 500.0, 600.0])


def custom(**settings: Any) -> ParallelForcePositionController:
    numbers = {"inertia": M_D, "derivative_gain": K_D, "proportional_gain": K_P, **settings}
    given = ForceLoopSettings(**{"force_gain": 0.02, "integral_gain": 0.3, **numbers})
    return ParallelForcePositionController(interface(), given)


def test_torque_and_integral_are_those_of_the_formula() -> None:
    now = random_observation(12, 20)
    displacement = np.random.default_rng(5).uniform(-0.1, 0.1, size=(20, 3))
    torque, (after,) = custom().control(now, (displacement,))
    size = np.linalg.norm(now["desired_force"], axis=1)[:, None]
    n = now["desired_force"] / size
    e = size - np.einsum("ij,ij->i", n, now["contact_force"])[:, None]
    target = now["desired_pose"].copy()
    target[:, :3] += displacement + 0.02 * e * n
    pull = K_P * (target - now["end_effector_pose"])
    pull += K_D * (now["desired_velocity"] - now["end_effector_velocity"])
    acceleration = now["desired_acceleration"] + pull / M_D
    # the oracle's J̇ is a difference quotient: 1e-9 of torques up to 1e4
    np.testing.assert_allclose(torque, torque_for(now, acceleration), rtol=1e-6, atol=1e-5)
    np.testing.assert_allclose(after, displacement + 0.002 * 0.3 * e * n, atol=1e-14)


def test_steady_state_of_the_report() -> None:
    q = np.array([[-np.pi / 2, -0.1, -np.pi / 6]])
    into = np.array([[1.0, 0.0, 0.0]])
    edge = ARM.forward_kinematics(np.array([-np.pi / 2, -0.2, -np.pi / 6]))[0]
    wall = Wall(np.array([50.0]), -into, np.array([-edge]), np.zeros(1))
    recording = simulate(controller(NAME, "report", limit=UNLIMITED), q, wall, 0.5 * into, 7.0)
    # the slow pole, K_I/K_F = 1 1/s, leaves of the 0.1 m between x_d and the wall e^-7/15 m/N: 6e-6 N
    np.testing.assert_allclose(recording.force[-1], 0.5 * into, atol=1e-4)
    np.testing.assert_allclose(recording.pose[-1, 0, :3], [edge + 0.01, -0.4, 0.03], atol=1e-5)
    np.testing.assert_allclose(recording.pose[-1, 0, 0], -0.2978, atol=1e-4)


@pytest.mark.parametrize(("force_gain", "integral_gain"), [(0.0, 0.04), (5e-4, 0.05)])
def test_fixed_gains_are_stable_up_to_routh_s_bound(force_gain: float, integral_gain: float) -> None:
    """K K_I < (K_D/M_d)(1 + K K_F), here K < 500 N/m with and without K_F."""
    inner = {"inertia": 1.0, "derivative_gain": 20.0, "proportional_gain": 400.0}
    stiffness = 20.0 / (integral_gain - 20.0 * force_gain) * np.array([0.8, 1.2])
    q = np.tile([0.4, -0.15, 0.7], (2, 1))
    into, pose = slide_direction(q), ARM.forward_kinematics(q)
    wall = Wall.ahead(pose[:, :3], into, -5.0 / stiffness, stiffness)
    gains = {"force_gain": force_gain, "integral_gain": integral_gain, **inner}
    made = controller(NAME, "report", period=0.001, limit=UNLIMITED, **gains)
    recording = simulate(made, q, wall, 5.2 * into, 2.0, held(pose))
    error = np.abs(np.einsum("tnk,nk->tn", recording.force, into) - 5.2)
    grown = error[-500:].max(axis=0) / error[500:1000].max(axis=0)
    assert grown[0] < 0.7
    assert grown[1] > 1.5


def test_tuned_settles_on_every_surface_and_holds_the_rest() -> None:
    cases = random_cases(4, 60)
    pose = ARM.forward_kinematics(cases.joint_position)
    recording = simulate(
        controller(NAME, "tuned"), cases.joint_position, cases.wall, cases.desired, 4.0, held(pose)
    )
    force = cases.pressing(recording)
    error = np.abs(force - cases.force) / cases.force
    assert (error[recording.time >= 3.5] < 0.02).all()
    assert (force.max(axis=0) < 1.2 * cases.force).all()
    moved = recording.pose[-1] - pose
    moved[:, :3] -= cases.into * np.einsum("nk,nk->n", cases.into, moved[:, :3])[:, None]
    # joints 1 and 3 hold the angles; along the wall the tip stays to what the held torque's ripple leaves
    np.testing.assert_allclose(moved, 0.0, atol=1e-4)


def test_tuned_presses_while_it_moves_across_the_force() -> None:
    q_0 = np.tile([0.5, -0.15, 0.3], (3, 1))
    stiffness, into = np.array([100.0, 700.0, 5000.0]), slide_direction(q_0)
    reach = -0.15 + 0.24 * np.cos(0.3)

    def along_the_wall(time: float) -> tuple[Array, Array, Array]:
        """Joint 3 swings, the slide keeps the reach: the tip runs up and down the wall."""
        swing, rate, change = 0.4 * np.sin(2 * time), 0.8 * np.cos(2 * time), -1.6 * np.sin(2 * time)
        s, c = np.sin(0.3 + swing), np.cos(0.3 + swing)
        q = np.array([0.5, reach - 0.24 * c, 0.3 + swing])
        velocity = np.array([0.0, 0.24 * s * rate, rate])
        acceleration = np.array([0.0, 0.24 * (c * rate**2 + s * change), change])
        return ARM.pose_motion(q, velocity, acceleration)

    wall = Wall.ahead(ARM.forward_kinematics(q_0)[:, :3], into, np.full(3, 0.01), stiffness)
    recording = simulate(controller(NAME, "tuned"), q_0, wall, 3.0 * into, 3.0, along_the_wall)
    late = recording.time >= 2.0
    force = np.einsum("tnk,nk->tn", recording.force, into)[late]
    np.testing.assert_allclose(force, 3.0, atol=0.06)
    wanted = np.array([[along_the_wall(time)[0]] * 3 for time in recording.time[late]])
    # 0.19 m/s along z, held torques: a tenth of a millimetre, where the speed covers 0.4 mm a period
    np.testing.assert_allclose(recording.pose[late][..., 2], wanted[..., 2], atol=2e-4)
    np.testing.assert_allclose(recording.pose[late][..., 3:], wanted[..., 3:], atol=2e-3)
