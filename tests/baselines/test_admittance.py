"""Admittance control: its formula, the report's steady forces, the rendered model, stiff surfaces."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import AdmittanceController, AdmittanceSettings
from prp_gym.errors import InvalidValueError
from prp_gym.robot import PRPArm
from tests.support.contact_cases import (
    UNLIMITED,
    Cases,
    controller,
    flat,
    poor_arms,
    random_cases,
    random_observation,
    repeated,
    slide_direction,
    torque_for,
)
from tests.support.contact_plant import Reference, Wall, interface, simulate

Array = NDArray[np.float64]

NAME = "admittance"
ARM = PRPArm()
M_T = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
K_DT = np.array([10.0, 20.0, 30.0, 40.0, 50.0, 60.0])
K_PT = np.array([100.0, 200.0, 300.0, 400.0, 500.0, 0.0])
K_P = np.array([50.0, 60.0, 70.0, 80.0, 90.0, 100.0])
K_D = np.array([10.0, 11.0, 12.0, 13.0, 14.0, 15.0])
K_I = np.array([5.0, 4.0, 3.0, 2.0, 1.0, 6.0])
PERIOD = 0.002


def custom(**settings: Any) -> AdmittanceController:
    target = {"inertia": M_T, "damping": K_DT, "stiffness": K_PT}
    given = {**target, "proportional_gain": K_P, "derivative_gain": K_D, "integral_gain": K_I}
    return AdmittanceController(interface(), AdmittanceSettings(**{**given, **settings}))


def push(pose: Array, motion: Array, seconds: float) -> Reference:
    """A quintic from a pose (n, 6) along `motion` (n, 6), then rest."""

    def at(time: float) -> tuple[Array, Array, Array]:
        s, going = min(time / seconds, 1.0), float(time < seconds)
        rate = (30 * s**2 - 60 * s**3 + 30 * s**4) / seconds
        change = (60 * s - 180 * s**2 + 120 * s**3) / seconds**2
        return (
            pose + (10 * s**3 - 15 * s**4 + 6 * s**5) * motion,
            going * rate * motion,
            going * change * motion,
        )

    return at


def pushing(cases: Cases, depth: float) -> Reference:
    """Into the surfaces of the cases: `depth` [m] behind them, in 1.5 s."""
    pose = ARM.forward_kinematics(cases.joint_position)
    gap = np.einsum("nk,nk->n", cases.wall.normal, pose[:, :3]) - cases.wall.offset
    return push(pose, np.concatenate([cases.into, 0.0 * cases.into], axis=1) * (gap + depth)[:, None], 1.5)


def test_torque_is_that_of_the_formula() -> None:
    now = random_observation(13, 20)
    integral, z, rate = np.random.default_rng(6).uniform(-0.2, 0.2, size=(3, 20, 6))
    torque, after = custom().control(now, (integral, z, rate))
    force = np.concatenate([now["contact_force"], np.zeros((20, 3))], axis=1)
    change = (force - K_DT * rate - K_PT * z) / M_T
    acceleration = now["desired_acceleration"] - change
    acceleration += K_D * (now["desired_velocity"] - rate - now["end_effector_velocity"])
    error = now["desired_pose"] - z - now["end_effector_pose"]
    acceleration += K_P * error + integral
    # the oracle's J̇ is a difference quotient: 1e-9 of torques up to 1e3
    np.testing.assert_allclose(torque, torque_for(now, acceleration), rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(after[0], integral + PERIOD * K_I * error, rtol=1e-12)


def test_compliant_frame_obeys_its_differential_equation() -> None:
    now = random_observation(14, 4)
    z, rate = np.random.default_rng(7).uniform(-0.2, 0.2, size=(2, 4, 6))
    _, (_, after, rate_after) = custom().control(now, (np.zeros(z.shape), z, rate))
    force = np.concatenate([now["contact_force"], np.zeros((4, 3))], axis=1)
    step = 0.002 / 20000
    for _ in range(20000):  # the explicit Euler method with tiny steps
        z, rate = z + step * rate, rate + step * (force - K_DT * rate - K_PT * z) / M_T
    # its error: half a step times |z̈| up to 50, and |z⃛| up to 2000, over the period
    np.testing.assert_allclose(after, z, atol=1e-8)
    np.testing.assert_allclose(rate_after, rate, atol=1e-6)


def test_pseudoinverse_damping_is_used() -> None:
    now = random_observation(15, 3)
    plain, _ = custom().control(now, custom().initial_state(now))
    damped, _ = custom(pseudoinverse_damping=0.3).control(now, custom().initial_state(now))
    assert np.abs(plain - damped).min() > 1e-3


def test_steady_force_of_the_report() -> None:
    """k(0, -.25, 0) is 0.05 m behind the plane y = -0.34: f = K K_Pt/(K + K_Pt) 0.05 m."""
    stiffness = np.array([1.0, 25.0, 50.0, 1000.0])
    home, up = np.zeros((4, 3)), np.tile([0.0, 1.0, 0.0], (4, 1))
    wall = Wall(stiffness, -up, np.full(4, 0.34), np.zeros(4))
    reference = push(ARM.forward_kinematics(home), np.tile([0.0, 0.25, 0.0, 0.0, 0.0, 0.0], (4, 1)), 1.5)
    recording = simulate(controller(NAME, "report", limit=UNLIMITED), home, wall, 0.0 * up, 5.0, reference)
    # the target's slowest mode, 2.8 1/s, has decayed to e^-10
    expected = (0.0476, 0.5556, 0.7143, 0.9804)
    np.testing.assert_allclose(recording.force[-1, :, 1], expected, atol=1e-4)
    np.testing.assert_allclose(recording.force[-1, :, [0, 2]], 0.0, atol=1e-6)


def test_tuned_renders_its_target_on_every_surface() -> None:
    cases = random_cases(5, 40)
    chosen, reference = controller(NAME, "tuned"), pushing(cases, 0.06)
    recording = simulate(chosen, cases.joint_position, cases.wall, 0.0 * cases.into, 5.0, reference)
    stiffness = cases.wall.stiffness
    np.testing.assert_allclose(
        cases.pressing(recording)[-1], 0.06 * 20.0 * stiffness / (20.0 + stiffness), rtol=5e-3
    )
    # the tip against the target driven by the measured force, by Euler's method between the measurements
    value, rate, worst = np.zeros((2, 40, 3))[0], np.zeros((40, 3)), 0.0
    for index, time in enumerate(recording.time[:-1]):
        wanted = reference(float(time))[0][:, :3] - value
        worst = max(worst, float(np.abs(recording.pose[index, :, :3] - wanted).max()))
        for share in np.arange(0.05, 1.0, 0.1):
            force = (1.0 - share) * recording.force[index] + share * recording.force[index + 1]
            rate = rate + 2e-4 * (force - 10.0 * rate - 20.0 * value)
            value = value + 2e-4 * rate
    # the controller holds each force for a period, a mean delay of half a period:
    # the tip moves at up to 0.1 m/s, with 11 N on impact
    assert worst < 5e-4


def test_tuned_tolerates_model_errors_sensor_errors_and_a_one_step_actuation_delay() -> None:
    """For both `MASS_FACTORS`, with noise and without, side by side."""
    cases = repeated(random_cases(6, 30), 4)
    arms, path, still = poor_arms(30, (0.05, 0.0)), pushing(cases, 0.06), 0.0 * cases.into
    recording = simulate(controller(NAME, "tuned"), cases.joint_position, cases.wall, still, 8.0, path, arms)
    force, time, noisy = cases.pressing(recording), recording.time, arms.noise > 0.0
    stiffness = cases.wall.stiffness[noisy]
    static = 0.06 * 20.0 * stiffness / (20.0 + stiffness)
    settled = force[(time >= 3.5) & (time < 4.0)][:, noisy]
    # the bias, 0.1 N of 1.2 N, gives way too; the noise, 0.05 N, goes into the torques
    np.testing.assert_allclose(settled.mean(axis=0), static, atol=0.12)
    # with a link 30 % too heavy in the model and another as much too light the loop rings at 10 Hz on the
    # stiffest surfaces: it triples the noise at most, and without noise dies out, to 1 mN after 8 s
    assert settled.std(axis=0).max() < 0.15
    assert force[time >= 7.5][:, ~noisy].std(axis=0).max() < 2e-3


def test_held_force_takes_damping_from_the_target() -> None:
    """K dt/2 off K_Dt = 10: harmless at 3000 N/m, too much at 20 kN/m, there also at half the period not."""
    stiffness = np.array([3000.0, 20000.0])
    q = np.tile([0.3, -0.15, 0.0], (2, 1))
    into, pose = slide_direction(q), ARM.forward_kinematics(q)
    wall = Wall.ahead(pose[:, :3], into, np.full(2, -1e-4), stiffness)
    deep = pose + 0.3 * np.concatenate([into, 0.0 * into], axis=1)
    for period, rings in ((0.002, True), (0.001, False)):
        reference = push(deep, 0.0 * deep, 1.0)
        recording = simulate(controller(NAME, "tuned", period=period), q, wall, 0.0 * into, 3.0, reference)
        late = np.einsum("tnk,nk->tn", recording.force, into)[recording.time >= 2.5]
        ripple = late.max(axis=0) - late.min(axis=0)
        assert ripple[0] < 0.1
        assert (ripple[1] > 1.0) == rings


def test_batch_equals_the_single_controller_in_every_row() -> None:
    chosen, first, second = custom(), random_observation(3, 5), random_observation(21, 5)
    _, states = chosen.control(first, chosen.initial_state(first))
    torque, after = chosen.control(second, states)
    for row in range(5):
        one = {key: value[row] for key, value in first.items()}
        _, state = chosen.control(one, chosen.initial_state(one))
        alone, state = chosen.control({key: value[row] for key, value in second.items()}, state)
        # torques up to 1e3, a few dozen operations whose order differs
        np.testing.assert_allclose(alone, torque[row], rtol=1e-12, atol=1e-10)
        for single, whole in zip(state, after, strict=True):
            np.testing.assert_allclose(single, whole[row], rtol=1e-12, atol=1e-15)


def test_compliant_frame_starts_anew_with_an_episode() -> None:
    chosen, observation = custom(), flat(random_observation(4, 3))
    _, state = chosen.predict(flat(random_observation(8, 3)))
    starts = np.array([False, True, False])
    _, after = chosen.predict(observation, state, starts)
    _, kept = chosen.predict(observation, state)
    _, fresh = chosen.predict(observation)
    assert after is not None
    assert kept is not None
    assert fresh is not None
    for mixed, old, new in zip(after, kept, fresh, strict=True):
        np.testing.assert_array_equal(mixed, np.where(starts[:, None], new, old))
        assert not np.array_equal(old[1], new[1])


def test_postures_where_the_tip_s_position_is_singular_are_passed() -> None:
    # q_3 = ±π/2, and there L = 0 with q_2 = -0.3
    q = np.array([[0.3, -0.1, np.pi / 2], [0.3, -0.1, -np.pi / 2], [0.3, -0.3, np.pi / 2]])
    into, pose = slide_direction(q), ARM.forward_kinematics(q)
    wall = Wall.ahead(pose[:, :3], into, np.full(3, 0.01), np.full(3, 1000.0))
    motion = np.concatenate([0.06 * into, 0.0 * into], axis=1)
    recording = simulate(controller(NAME, "tuned"), q, wall, 0.0 * into, 2.5, push(pose, motion, 0.8))
    np.testing.assert_allclose(recording.force[-1], 0.05 * 1000.0 / 51.0 * into, atol=0.02)
    np.testing.assert_allclose(recording.joint_position[-1, :, 2], q[:, 2], atol=1e-3)


@pytest.mark.parametrize("name", ["inertia", "damping", "stiffness"])
def test_wrong_target_is_refused(name: str) -> None:
    with pytest.raises(InvalidValueError, match=name):
        custom(**{name: -1.0})


def test_target_without_inertia_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="inertia"):
        custom(inertia=0.0)
