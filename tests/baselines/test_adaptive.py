"""Adaptive control of the arm and of the link: torques, adaptation, and robustness to link-mass errors."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import (
    AdaptiveController,
    AdaptiveSettings,
    JointInverseDynamicsController,
    JointInverseDynamicsSettings,
)
from prp_gym.baselines.base.gains import load_gains
from prp_gym.errors import InvalidValueError
from prp_gym.robot import NOMINAL, Link, LinkParameters, PRPArm, RobotParameters
from tests.support.adaptive_gains import SOFT
from tests.support.control_interface import INTERFACE, LINK_INTERFACE, PERIOD
from tests.support.controller_simulation import Motion, Run, simulate
from tests.support.pinocchio_model import PinocchioArm, random_arm, random_states

Array = NDArray[np.float64]

LAMBDA, K_D = np.array([20.0, 15.0, 10.0]), np.array([15.0, 40.0, 0.5])
GAMMA = np.arange(1.0, 13.0)
ROUNDING = 1e-10  # torques up to 1e5, a few dozen operations of 1e-16 each
MODELS = {"nominal": (NOMINAL, PinocchioArm()), "another": random_arm(15)}


def controller(**settings: Any) -> AdaptiveController:
    chosen = {"reference_gain": LAMBDA, "damping_gain": K_D, "adaptation_gain": GAMMA, **settings}
    return AdaptiveController(INTERFACE, AdaptiveSettings(**chosen))


def tuned(environment_id: str, **settings: Any) -> AdaptiveSettings:
    values = load_gains("adaptive", "tuned", environment_id) | settings
    return AdaptiveSettings(
        **{key: value for key, value in values.items() if key not in ("source", "minimum_frequency")}
    )


def observed(seed: int, count: int) -> dict[str, Array]:
    """Random measurements and references, (count, 3) each."""
    q, velocity, _, _ = random_states(seed, count)
    desired, desired_velocity, desired_acceleration, _ = random_states(seed + 1, count)
    return {
        "joint_position": q,
        "joint_velocity": velocity,
        "desired_joint_position": desired,
        "desired_joint_velocity": desired_velocity,
        "desired_joint_acceleration": desired_acceleration,
    }


def references(given: dict[str, Array]) -> tuple[Array, Array, Array]:
    """q̇_r, q̈_r and σ."""
    error = given["desired_joint_position"] - given["joint_position"]
    rate = given["desired_joint_velocity"] - given["joint_velocity"]
    velocity = given["desired_joint_velocity"] + LAMBDA * error
    acceleration = given["desired_joint_acceleration"] + LAMBDA * rate
    return velocity, acceleration, velocity - given["joint_velocity"]


@pytest.mark.parametrize(("model", "oracle"), MODELS.values(), ids=MODELS)
def test_first_torque_is_the_model_s_along_the_sliding_reference(
    model: RobotParameters, oracle: PinocchioArm
) -> None:
    rough = replace(model, viscous_friction=(0.5, 2.0, 0.1), coulomb_friction=(0.3, 1.5, 0.05))
    given = observed(1, 40)
    policy = controller(model=rough)
    torque, _ = policy.control(given, policy.initial_state(given))
    velocity, acceleration, sliding_variable = references(given)
    for row in range(40):
        q, v, w = given["joint_position"][row], given["joint_velocity"][row], velocity[row]
        inertial = oracle.inertia_matrix(q) @ acceleration[row]
        # C(q, v) w is the symmetric bilinear form of which C(q, v) v is the quadratic one
        coriolis = [oracle.coriolis_force(q, part) for part in (v + w, v, w)]
        friction = np.array([0.5, 2.0, 0.1]) * w + np.array([0.3, 1.5, 0.05]) * np.sign(w)
        expected = inertial + (coriolis[0] - coriolis[1] - coriolis[2]) / 2 + oracle.gravity_vector(q)
        expected = expected + friction + K_D * sliding_variable[row]
        np.testing.assert_allclose(torque[row], expected, rtol=ROUNDING, atol=ROUNDING)


def test_estimate_moves_along_the_torque_s_gradient_times_the_sliding_variable() -> None:
    given = observed(2, 20)
    policy = controller(upper_share=1e9, margin=1e9, lower_share=0.0)
    (estimate,) = policy.initial_state(given)
    estimate = 1e6 + estimate  # away from the bounds
    torque, (after,) = policy.control(given, (estimate,))
    sliding_variable = references(given)[2]
    for index in range(12):
        more, _ = policy.control(given, (estimate + 100.0 * np.eye(12)[index],))
        power = np.sum((more - torque) / 100.0 * sliding_variable, axis=1)
        # differences of torques of up to 1e9 N m, over 100, times a sliding variable of up to 1e2
        rate = (after - estimate)[:, index] / PERIOD
        np.testing.assert_allclose(rate, GAMMA[index] * power, rtol=1e-4, atol=1e-2)


def test_link_s_torque_and_adaptation_follow_the_formula() -> None:
    model = LinkParameters(inertia=0.4, viscous_friction=0.2, gravity_moment=1.5)
    settings = AdaptiveSettings(20.0, 5.0, [0.1, 0.2, 0.3], model=model, upper_share=100.0, lower_share=0.0)
    policy = AdaptiveController(LINK_INTERFACE, settings)
    observation = np.array([0.3, -0.5, 0.6, 0.7, -2.0])
    torque, (after,) = policy.control(
        policy.interface.layout.split(observation), (np.array([0.4, 0.2, 1.5]),)
    )
    w, a = 0.7 + 20.0 * 0.3, -2.0 + 20.0 * 1.2
    sliding_variable = w + 0.5
    assert torque == pytest.approx(0.4 * a + 0.2 * w + 1.5 * np.sin(0.3) + 5.0 * sliding_variable, rel=1e-13)
    change = PERIOD * sliding_variable * np.array([0.1 * a, 0.2 * w, 0.3 * np.sin(0.3)])
    np.testing.assert_allclose(after, np.array([0.4, 0.2, 1.5]) + change, rtol=1e-13)


def test_estimates_start_at_the_parameters_of_the_controller_s_model() -> None:
    inaccurate = NOMINAL.with_masses((1.5, 0.5, 0.9))
    given = observed(3, 4)
    (estimate,) = controller(model=inaccurate).initial_state(given)
    np.testing.assert_array_equal(estimate, np.tile(PRPArm(inaccurate).parameter_vector(), (4, 1)))
    _, state = controller(model=inaccurate).predict(np.zeros(INTERFACE.layout.size))
    assert state is not None
    assert state[0].shape == (12,)


def test_estimates_stay_within_their_bounds() -> None:
    margin = np.linspace(0.0, 1.0, 12)
    policy = controller(lower_share=0.5, upper_share=1.5, margin=margin, adaptation_gain=1e9)
    own = PRPArm().parameter_vector()
    lower, upper = 0.5 * own, 1.5 * own + margin
    given = observed(4, 200)
    _, (after,) = policy.control(given, policy.initial_state(given))
    assert (after >= lower).all()
    assert (after <= upper).all()
    base = after[:, :6]  # Coulomb's and viscous friction only rise at first
    assert (base == lower[:6]).any(axis=0).all()
    assert (base == upper[:6]).any(axis=0).all()
    assert (after[:, 6:] == upper[6:]).any(axis=0).all()


@pytest.mark.parametrize(("name", "value"), [("lower_share", 1.01), ("upper_share", 0.99)])
def test_bounds_that_exclude_the_model_itself_are_refused(name: str, value: float) -> None:
    with pytest.raises(InvalidValueError, match=f"{name} is"):
        controller(**{name: value})


def test_estimates_stand_still_while_an_actuator_is_at_its_limit() -> None:
    policy = AdaptiveController(INTERFACE, tuned("PRP-JointTracking-v0", **SOFT))
    observation = np.zeros((2, INTERFACE.layout.size))
    index = INTERFACE.layout.index("desired_joint_position")
    observation[:, index] = [[1.0, -0.1, 0.1], [0.05, -0.01, 0.1]]
    _, state = policy.predict(observation, None)
    action, after = policy.predict(observation, state)
    assert state is not None
    assert after is not None
    np.testing.assert_array_equal((np.abs(action) == 1.0).any(axis=1), [True, False])
    np.testing.assert_array_equal(after[0][0], state[0][0])
    assert (after[0][1] != state[0][1]).any()


def loop(time: float) -> Motion:
    """A reference of a period of 2 s that always moves."""
    frequency, center, amplitude = np.pi * np.array([1.0, 1.0, 2.0]), np.array([0.0, -0.15, 0.3]), np.ones(3)
    amplitude = amplitude * [1.0, 0.1, 1.0]
    sine, cosine = np.sin(frequency * time), np.cos(frequency * time)
    motion = (center + amplitude * sine, amplitude * frequency * cosine, -amplitude * frequency**2 * sine)
    return motion[0][None], motion[1][None], motion[2][None]


MASS_FACTORS = ((0.7, 0.7, 0.7), (1.3, 1.3, 1.3), (0.7, 1.3, 1.3), (1.3, 0.7, 0.7), (0.7, 0.7, 1.3))
"""Masses of the controller's links over the actual ones."""


def last_errors(run: Run) -> Array:
    """Root mean squares (n) of the tips' errors over the last period [m]."""
    last = run.pose_error[-round(2.0 / PERIOD) :, :, :3]
    errors: Array = np.sqrt(np.mean(np.sum(last**2, axis=-1), axis=0))
    return errors


def test_adaptation_reduces_the_error_due_to_link_mass_errors_tenfold() -> None:
    """The controller's model is the nominal one, so that one controller runs all plants side by side."""
    plants = [NOMINAL.scaled([1.0 / factor for factor in factors]) for factors in MASS_FACTORS]
    starts = np.repeat(loop(0.0)[0], len(plants), axis=0)
    adaptive = AdaptiveController(INTERFACE, tuned("PRP-JointTracking-v0", **SOFT))
    adapted = simulate(adaptive, starts, loop, 10.0, plants)
    sized = adaptive.settings
    # the same feedback: with the right model σ˙ = -K_D/B σ makes K_P = Λ K_D/B, K_D = Λ + K_D/B
    damping = sized.damping_gain / np.diagonal(PRPArm().inertia_matrix(loop(0.0)[0][0]))
    gains = sized.reference_gain * damping, sized.reference_gain + damping
    computed = JointInverseDynamicsController(INTERFACE, JointInverseDynamicsSettings(*gains))
    fixed = last_errors(simulate(computed, starts, loop, 4.0, plants))
    assert (last_errors(adapted) < 0.1 * fixed).all()
    assert (fixed > 2e-3).all()  # [m]: without adaptation the error is not small


def link_errors(settings: AdaptiveSettings, plant: Link, duration: float) -> tuple[Array, Array]:
    """Tracking errors along sin 2πt [rad], and the last estimate."""
    policy, w = AdaptiveController(LINK_INTERFACE, settings), 2 * np.pi
    q, velocity, state, errors = np.zeros(1), np.array([w]), None, []
    for step in range(round(duration / PERIOD)):
        t = step * PERIOD
        desired = [np.sin(w * t), w * np.cos(w * t), -(w**2) * np.sin(w * t)]
        errors.append(desired[0] - q[0])
        action, state = policy.predict(np.concatenate([q, velocity, desired]), state)
        for _ in range(2):
            velocity = velocity + 1e-3 * plant.forward_dynamics(q, velocity, 30.0 * action.astype(np.float64))
            q = q + 1e-3 * velocity
    assert state is not None
    return np.array(errors), state[0]


@pytest.mark.parametrize("factors", [(0.5, 0.5, 0.5), (1.5, 1.5, 1.5), (0.7, 1.3, 1.5), (1.3, 0.5, 0.7)])
def test_link_follows_its_reference_despite_parameter_errors(factors: tuple[float, float, float]) -> None:
    actual = LinkParameters()
    model = LinkParameters(
        inertia=factors[0] * actual.inertia,
        viscous_friction=factors[1] * actual.viscous_friction,
        gravity_moment=factors[2] * actual.gravity_moment,
    )
    settings = tuned("PRP-Adaptive-v0", model=model)
    adapted, estimate = link_errors(settings, Link(actual), 10.0)
    still = replace(settings, adaptation_gain=0.0)
    fixed, _ = link_errors(still, Link(actual), 3.0)
    exact, _ = link_errors(replace(still, model=actual), Link(actual), 3.0)
    # torques held for 2 ms leave 1.1 mrad even with exact parameters; the rest is due to parameter errors
    assert np.abs(adapted[-500:]).max() < np.abs(exact[-500:]).max() < 1.1e-3
    left, without = (np.abs(errors - exact[-500:]).max() for errors in (adapted[-500:], fixed[-500:]))
    assert left < 0.1 * without
    assert abs(estimate[0] - actual.inertia) < 0.05  # the one parameter that this reference excites well


def test_report_s_gains_follow_the_link_and_hardly_learn() -> None:
    values = load_gains("adaptive", "report", "PRP-Adaptive-v0")
    del values["source"]
    initial = LinkParameters(0.49, 0.14, 1.84)
    errors, estimate = link_errors(AdaptiveSettings(**values, model=initial), Link(), 4.0)
    assert np.abs(errors[-500:]).max() < 5e-4  # K_P = ΛK_D = 8000 N m/rad
    np.testing.assert_allclose(estimate, [0.49, 0.14, 1.84], atol=0.02)
