"""Errata of the report in its operational-space references, contact control and environment."""

import math
from itertools import pairwise

import numpy as np
import pytest

from prp_gym.physics import Physics, PhysicsSettings, Surface
from prp_gym.robot import PRPArm
from tests.support.integration import runge_kutta
from tests.support.pinocchio_model import Array, PinocchioArm

ARM, PINOCCHIO = PRPArm(), PinocchioArm()
A_1, SLIDE, A_3, HEIGHT = 0.40, 0.30, 0.24, 0.15
WALL = -0.44  # y of the plane of 11 to 14; free below
HOME, TARGET = (ARM.forward_kinematics((0.0, slide, 0.0)) for slide in (0.0, -0.2))
EXACT = 1e-12  # a few dozen operations of 1e-16 on numbers up to 100
DESIRED_MASS = np.array([1.0, 0.5, 1.0, 1.0, 1.0, 1.0])  # of 12.1, as the next two
DESIRED_DAMPING, DESIRED_STIFFNESS = 10.0, 50.0


def reference(time: float) -> tuple[Array, Array, Array]:
    """Quintic from home to the target in 1 s: pose, velocity, acceleration."""
    s, move = min(time, 1.0), TARGET - HOME
    pose = HOME + move * (s**3 * (10 - 15 * s + 6 * s**2))
    return pose, move * (30 * s**2 * (1 - s) ** 2), move * (60 * s * (1 - s) * (1 - 2 * s))


def wall_force(pose: Array, stiffness: float) -> Array:
    """h_e of an ideal plane, by the tip on it (6)."""
    force = np.zeros(6)
    force[1] = stiffness * max(0.0, pose[1] - WALL)
    return force


def impedance_residual(time: float, state: Array, stiffness: float, controller: str) -> tuple[Array, Array]:
    """q̈ under an impedance control law, and M_d x̃¨ + K_D x̃˙ + K_P x̃ - h_e, which it should make zero."""
    q, v = state
    x_d, v_d, a_d = reference(time)
    J, drift = ARM.analytical_jacobian(q), ARM.analytical_jacobian_derivative(q, v) @ v
    force = wall_force(ARM.forward_kinematics(q), stiffness)
    error, rate = x_d - ARM.forward_kinematics(q), v_d - J @ v
    # where the desired frame does not rotate, b is the desired velocity; printed without dot, with a minus
    forward = {"printed": -v_d, "without": 0 * a_d, "right": a_d}[controller]
    pull = DESIRED_DAMPING * rate + DESIRED_STIFFNESS * error - force
    y = np.linalg.pinv(J) @ (forward + pull / DESIRED_MASS - drift)
    torque = ARM.inertia_matrix(q) @ y + ARM.bias_force(q, v) + J.T @ force
    acceleration = ARM.forward_dynamics(q, v, torque, force[:3])
    return acceleration, DESIRED_MASS * (a_d - J @ acceleration - drift) + pull


def largest_residual(stiffness: float, controller: str) -> float:
    """Over the second of the reference [N, N m]."""

    def slope(time: float, state: Array) -> Array:
        return np.stack([state[1], impedance_residual(time, state, stiffness, controller)[0]])

    states = runge_kutta(slope, np.zeros((2, 3)), 4e-3, 250)
    residuals = [
        impedance_residual(4e-3 * i, state, stiffness, controller)[1] for i, state in enumerate(states)
    ]
    return float(np.abs(residuals).max())


@pytest.mark.parametrize("stiffness", [1.0, 1000.0])
def test_impedance_control_without_desired_acceleration_misses_its_own_model(stiffness: float) -> None:
    without = largest_residual(stiffness, "without")
    # M_d,y times the quintic's largest acceleration, 10/√3 of 0.2 m in 1 s; sampled every 4 ms
    assert without == pytest.approx(0.5 * 0.2 * 10 / math.sqrt(3), rel=1e-3)
    assert largest_residual(stiffness, "printed") > without
    assert largest_residual(stiffness, "right") < EXACT


def test_report_starts_where_the_tip_is_already_deep_inside_the_wall() -> None:
    text = ARM.forward_kinematics((0.0, -0.3, 0.0))
    assert text[1] == pytest.approx(-0.24, abs=EXACT)
    assert HOME[1] == pytest.approx(-0.54, abs=EXACT)  # where the figures start
    physics = Physics(settings=PhysicsSettings(surface=True, joint_stops=False), num_simulations=2)
    ids = np.arange(2)
    planes = Surface(np.full(2, 50.0), np.zeros(2), np.tile([0.0, -1.0, 0.0], (2, 1)), np.full(2, -WALL))
    physics.set_surface(ids, planes)
    physics.reset(ids, np.array([[0.0, -0.3, 0.0], [0.0, 0.0, 0.0]]), np.zeros((2, 3)))
    force = physics.contact_force[:, 1]
    # K times 0.2 m; the solver's spurious mass of 1.3e-4 kg, at accelerations of up to 10 m/s², takes 1e-3
    assert force[0] == pytest.approx(10.0, abs=5e-3)
    assert force[1] == 0.0


def report_spring(pose: Array, anchor: Array, stiffness: float) -> Array:
    """The report's environment: all six components while the tip is beyond the anchor's y."""
    contact = pose[..., 1:2] > anchor[1]
    return np.where(contact, stiffness * (pose - anchor), 0.0)


def test_report_environment_pulls_sideways_where_a_plane_does_not() -> None:
    anchor = ARM.forward_kinematics((0.0, -0.1, 0.0))
    q = np.array([-0.15, -0.25, 0.3])
    pose = ARM.forward_kinematics(q)
    assert pose[1] > WALL + 0.05
    wrench = report_spring(pose, anchor, 50.0)
    assert np.abs(wrench[[0, 2, 3, 4]]).min() > 1.0  # [N] and [N m] along and about the "plane"
    physics = Physics(settings=PhysicsSettings(surface=True, joint_stops=False))
    physics.set_surface(np.arange(1), Surface.single(50.0, (0.0, -1.0, 0.0), -WALL))
    physics.reset(np.arange(1), q[None], np.zeros((1, 3)))
    force = physics.contact_force[0]
    assert force[1] == pytest.approx(wrench[1], rel=1e-3)  # the solver's spurious mass, as above
    np.testing.assert_array_equal(force[[0, 2]], 0.0)


def test_report_environment_gives_energy_on_a_round_trip() -> None:
    # in at 0.05 m beside the anchor, along the wall to the anchor, out there: work on the environment
    anchor, sideways, depth, stiffness = np.zeros(6), 0.05, 0.02, 50.0
    corners = [(sideways, -depth), (sideways, depth), (0.0, depth), (0.0, -depth), (sideways, -depth)]
    path = np.concatenate([np.linspace(a, b, 2001) for a, b in pairwise(corners)])
    pose = np.zeros((len(path), 6))
    pose[:, :2] = path
    wrench = report_spring(pose, anchor, stiffness)
    plane = np.zeros_like(wrench)
    plane[:, 1] = stiffness * np.maximum(0.0, pose[:, 1])
    moves = np.diff(pose, axis=0)
    work = [float(((h[1:] + h[:-1]) / 2 * moves).sum()) for h in (wrench, plane)]
    # the trapezoidal rule is exact for a spring but in the step where the contact starts or ends
    assert work[0] == pytest.approx(-stiffness * sideways**2 / 2, rel=1e-3)
    assert work[1] == pytest.approx(0.0, abs=EXACT)


@pytest.mark.parametrize(("stiffness", "pressed"), [(1.0, 0.0974), (50.0, 2.1526), (1000.0, 3.6422)])
def test_printed_impedance_control_of_a_plant_in_contact_exerts_too_small_a_force(
    stiffness: float, pressed: float
) -> None:
    def push(slide: float, compensated: bool) -> float:
        """q̈_2 at rest under τ = B y + n, with or without J^T h_e, on a plant in contact."""
        q, still = np.array([0.0, slide, 0.0]), np.zeros(3)
        J, force = ARM.analytical_jacobian(q), wall_force(ARM.forward_kinematics(q), stiffness)
        pull = DESIRED_STIFFNESS * (TARGET - ARM.forward_kinematics(q)) - force
        torque = ARM.inertia_matrix(q) @ np.linalg.pinv(J) @ (pull / DESIRED_MASS) + ARM.gravity_vector(q)
        torque += J.T @ force if compensated else 0.0
        return float(PINOCCHIO.forward_dynamics(q, still, torque, force[:3])[1])

    def rest(compensated: bool) -> float:
        """The force where the push vanishes, by bisection between the plane and the target."""
        low, high = -0.2, -0.1
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if push(middle, compensated) > 0.0 else (low, middle)
        return float(wall_force(ARM.forward_kinematics((0.0, low, 0.0)), stiffness)[1])

    right = stiffness * DESIRED_STIFFNESS / (stiffness + DESIRED_STIFFNESS) * 0.1
    # the bisection ends at rounding, times a stiffness of 1000
    assert rest(compensated=True) == pytest.approx(right, abs=1e-9)
    # K_P x̃ = h_e (1 + M_d/m) with the tip's apparent mass m = m_2 + m_3
    stiffer = stiffness * (1 + 0.5 / 1.549017)
    false = stiffness * DESIRED_STIFFNESS / (stiffer + DESIRED_STIFFNESS) * 0.1
    assert rest(compensated=False) == pytest.approx(false, rel=1e-6)  # digits of the mass
    assert false == pytest.approx(pressed, abs=5.1e-5)


def test_reference_of_the_operational_inverse_dynamics_cannot_be_attained() -> None:
    joints = np.array(
        [
            [np.pi / 3, -0.2, np.pi / 3],
            [-np.pi / 3, -0.1, np.pi / 4],
            [0.0, -0.2, 0.0],
            [np.pi / 2, 0.0, -np.pi / 4],
            [np.pi / 3, -0.1, np.pi / 4],
            [0.0, 0.0, 0.0],
        ]
    )

    def misfit(pose: Array) -> Array:
        """Distance of the tip from where the angles put joint 3's slide, and from their height [m]."""
        alpha, beta = pose[..., 3], pose[..., 4]
        beside = pose[..., 0] * np.cos(alpha) + pose[..., 1] * np.sin(alpha) - A_1
        above = pose[..., 2] - HEIGHT - A_3 * np.cos(beta)
        return np.asarray(np.hypot(beside, above))

    at_waypoints = ARM.forward_kinematics(joints)
    assert np.ptp(at_waypoints[:, 0]) > 0.5  # not constant, as the text has it
    np.testing.assert_allclose(misfit(at_waypoints), 0.0, rtol=0, atol=EXACT)
    halfway = (at_waypoints[1:] + at_waypoints[:-1]) / 2  # of the quintic, component by component
    # the angles of the fourth segment happen to make its middle nearly right
    np.testing.assert_allclose(misfit(halfway), [0.265, 0.061, 0.072, 0.001, 0.096], rtol=0, atol=5e-4)
    feasible = ARM.forward_kinematics((joints[1:] + joints[:-1]) / 2)
    np.testing.assert_allclose(misfit(feasible), 0.0, rtol=0, atol=EXACT)


def steady_force(integral_gain: float, start: float, wall: float, absolute: bool) -> float:
    """Force after 8 s of M_d ẍ = -K_D ẋ + K_P (x_F - x) pressing with f_d = 1 N on K = 5."""
    stiffness, proportional = 5.0, 10.0
    origin = 0.0 if absolute else start

    def slope(_: float, state: Array) -> Array:
        x, v, total = state
        lack = 1.0 - stiffness * max(0.0, x - wall)
        target = origin + proportional * lack + integral_gain * total
        return np.array([v, (-100.0 * v + 50.0 * (target - x)) / 0.5, lack])

    last: Array = runge_kutta(slope, np.array([start, 0.0, 0.0]), 4e-3, 2000)[-1]
    return stiffness * (float(last[0]) - wall)


def test_force_error_of_figure_46_depends_on_where_the_base_frame_is() -> None:
    # what the slowest decay, 0.5 1/s of the integral, leaves after 8 s is 2 % of the start
    for shift in (0.0, 1.0):
        start, wall = HOME[1] + shift, WALL + shift
        as_run = steady_force(0.0, start, wall, absolute=True)
        assert as_run == pytest.approx((10.0 - wall) / (10.0 + 0.2), abs=1e-9)
        offset = steady_force(0.0, start, wall, absolute=False)
        assert offset == pytest.approx(5.0 * (HOME[1] + 10.0 - WALL) / 51.0, abs=1e-9)
        assert offset == pytest.approx(0.9706, abs=5e-5)
        assert steady_force(5.0, start, wall, absolute=False) == pytest.approx(1.0, abs=0.02)
    assert steady_force(0.0, HOME[1], WALL, absolute=True) == pytest.approx(1.0235, abs=5e-5)
    assert steady_force(0.0, HOME[1] + 1.0, WALL + 1.0, absolute=True) < 0.93


def test_rest_of_the_parallel_control_run_is_outside_the_joint_limits() -> None:
    desired = ARM.forward_kinematics((-np.pi / 2, -0.1, -np.pi / 6))
    wall = float(ARM.forward_kinematics((-np.pi / 2, -0.2, -np.pi / 6))[0])
    low, high = ARM.parameters.joint_lower[1], ARM.parameters.joint_upper[1]

    def slide(stiffness: float) -> float:
        """q_2 where K (x - x_e) = 0.5 N at the desired angles, from L = -p_x at α = -π/2."""
        return -(wall + 0.5 / stiffness) - SLIDE - A_3 * math.sin(desired[4])

    assert slide(1.0) == pytest.approx(-0.7, abs=EXACT)
    assert slide(1.0) < low
    pose = ARM.forward_kinematics((-np.pi / 2, slide(1.0), -np.pi / 6))
    np.testing.assert_allclose(pose[1:], desired[1:], rtol=0, atol=EXACT)
    assert pose[0] == pytest.approx(0.1922, abs=5e-5)
    assert low < slide(50.0) < high  # the variant that the arm can do
    assert HOME[0] - wall == pytest.approx(0.7078, abs=5e-5)  # how deep the run starts
