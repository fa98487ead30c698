"""`PRPArm` as a whole: any leading dimensions, shapes that are refused, operational space, the regressor."""

import dataclasses
import inspect
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.errors import ShapeError
from prp_gym.robot import NOMINAL, PRPArm
from tests.support.pinocchio_model import Array, PinocchioArm, per_row, random_arm, random_states

PROPERTY = settings(max_examples=50, deadline=None, derandomize=True)
NUMBERS = st.floats(-5.0, 5.0)
TRIPLES = st.tuples(NUMBERS, NUMBERS, NUMBERS)
VISCOUS, COULOMB = (0.5, 2.0, 0.1), (0.3, 1.5, 0.05)
ARM = PRPArm(dataclasses.replace(NOMINAL, viscous_friction=VISCOUS, coulomb_friction=COULOMB))
FRICTIONLESS = PRPArm()
ROUNDING = 1e-12  # forces up to about 100, a few dozen operations of 1e-16 each
SINGULAR = np.array(
    [[0.7, -0.1, np.pi / 2], [0.7, -0.1, -np.pi / 2], [0.3, -0.3, np.pi / 2], [0.3, -0.54, 0.0]]
)

# the arguments of every public method, in order, as rows of `arguments_of`
METHODS: dict[str, tuple[str, ...]] = {
    "forward_kinematics": ("q",),
    "reach": ("q",),
    "transforms": ("q",),
    "analytical_jacobian": ("q",),
    "geometric_jacobian": ("q",),
    "analytical_jacobian_derivative": ("q", "velocity"),
    "euler_rate_map": ("q",),
    "inverse_kinematics_branches": ("point",),
    "inverse_kinematics": ("point", "q"),
    "inertia_matrix": ("q",),
    "coriolis_matrix": ("q", "velocity"),
    "gravity_vector": ("q",),
    "friction_force": ("velocity",),
    "bias_force": ("q", "velocity"),
    "forward_dynamics": ("q", "velocity", "torque", "force"),
    "kinetic_energy": ("q", "velocity"),
    "potential_energy": ("q",),
    "inverse_dynamics": ("q", "velocity", "acceleration", "force"),
    "operational_space_dynamics": ("q", "velocity"),
    "regressor": ("q", "velocity", "reference_velocity", "acceleration"),
    "pose_motion": ("q", "velocity", "acceleration"),
    "joint_position_of_pose": ("pose",),
    "joint_motion": ("pose", "pose_velocity", "pose_acceleration"),
}
ARRAYS_OUT = {
    "inverse_kinematics_branches": 2,
    "operational_space_dynamics": 3,
    "pose_motion": 3,
    "joint_motion": 3,
}
SIZES = {"pose": 6, "pose_velocity": 6, "pose_acceleration": 6}  # of arguments that are not joint vectors


def arguments_of(method: str, leading: tuple[int, ...]) -> list[Array]:
    """Random arguments of a method with the given leading dimensions."""
    generator = np.random.default_rng(len(method))

    def draw(low: Any, high: Any) -> Array:
        return generator.uniform(low, high, size=(*leading, 3))

    q = draw(NOMINAL.joint_lower, NOMINAL.joint_upper)
    pool = {name: draw(-3.0, 3.0) for name in ("velocity", "acceleration", "reference_velocity")}
    pool |= {"torque": draw(-10.0, 10.0), "force": draw(-20.0, 20.0)}
    pool |= {"q": q, "point": ARM.forward_kinematics(q)[..., :3]}
    motion = ARM.pose_motion(q, pool["velocity"], pool["acceleration"])
    pool |= dict(zip(SIZES, motion, strict=True))
    return [pool[name] for name in METHODS[method]]


def call(method: str, arguments: list[Array]) -> tuple[Array, ...]:
    """What a method returns, always as a tuple of arrays."""
    result: Any = getattr(ARM, method)(*arguments)
    return tuple(result) if isinstance(result, tuple) else (result,)


def test_table_of_methods_names_every_public_method() -> None:
    public = {name for name, _ in inspect.getmembers(PRPArm, inspect.isfunction) if not name.startswith("_")}
    assert public == set(METHODS) | {"parameter_vector"}


@pytest.mark.parametrize("leading", [(), (5,), (2, 3)])
@pytest.mark.parametrize("method", METHODS)
def test_batch_equals_a_loop_over_single_states(method: str, leading: tuple[int, ...]) -> None:
    arguments = arguments_of(method, leading)
    together = call(method, arguments)
    assert len(together) == ARRAYS_OUT.get(method, 1)
    single = [call(method, [item[index] for item in arguments]) for index in np.ndindex(leading)]
    for position, batch in enumerate(together):
        looped = np.array([result[position] for result in single]).reshape(batch.shape)
        assert batch.shape[: len(leading)] == leading
        # vectorised and scalar sines and matrix products may round differently; J_A⁺ makes more of it where
        # L and C_3 are both small, by its norm squared, some 100
        rounding = 1e-11 if method == "joint_motion" else 1e-13
        np.testing.assert_allclose(batch, looped, rtol=rounding, atol=rounding)


@pytest.mark.parametrize("method", [name for name in METHODS if len(METHODS[name]) > 1])
def test_single_argument_is_broadcast_against_a_batch(method: str) -> None:
    arguments = arguments_of(method, (5,))
    # one point for many seeds is a test of its own in test_inverse_kinematics.py
    for position in range(1 if method == "inverse_kinematics" else 0, len(arguments)):
        mixed = [item[0] if index == position else item for index, item in enumerate(arguments)]
        full = [np.broadcast_to(item, (5, item.shape[-1])) for item in mixed]
        for result, expected in zip(call(method, mixed), call(method, full), strict=True):
            rounding = 1e-11 if method == "joint_motion" else 1e-13
            np.testing.assert_allclose(result, expected, rtol=rounding, atol=rounding)


@pytest.mark.parametrize("method", METHODS)
def test_arguments_are_left_unchanged(method: str) -> None:
    arguments = arguments_of(method, (4,))
    copies = [item.copy() for item in arguments]
    for item in arguments:
        item.flags.writeable = False
    first = call(method, arguments)
    for result in first:
        result[...] = 0.0  # the caller owns the result
    for item, copy in zip(arguments, copies, strict=True):
        np.testing.assert_array_equal(item, copy)


@pytest.mark.parametrize("shape", [(), (2,), (3, 4), (0,)])
@pytest.mark.parametrize("method", METHODS)
def test_wrong_shape_of_any_argument_is_refused_by_name(method: str, shape: tuple[int, ...]) -> None:
    names = list(inspect.signature(getattr(ARM, method)).parameters)
    for position, name in enumerate(names):
        arguments = arguments_of(method, ())
        arguments[position] = np.zeros(shape)
        with pytest.raises(ShapeError, match=name) as caught:
            call(method, arguments)
        assert caught.value.shape == shape
        assert caught.value.expected == f"(..., {SIZES.get(METHODS[method][position], 3)})"


def test_lists_of_integers_are_taken_as_numbers() -> None:
    np.testing.assert_array_equal(
        ARM.inertia_matrix([0, 0, 1]), ARM.inertia_matrix(np.array([0.0, 0.0, 1.0]))
    )


def test_contact_force_is_zero_by_default() -> None:
    q, velocity, torque, _ = random_states(0, 5)
    still = np.zeros(3)
    for method in (ARM.forward_dynamics, ARM.inverse_dynamics):
        free = method(q, velocity, torque)
        np.testing.assert_array_equal(free, method(q, velocity, torque, still))


def test_operational_space_dynamics_is_that_of_the_joints_pushed_through_the_jacobian() -> None:
    q, velocity, acceleration, _ = random_states(1, 100)
    for parameters, oracle in ((NOMINAL, PinocchioArm()), random_arm(0), random_arm(1)):
        arm = PRPArm(parameters)
        J_A, rate = arm.analytical_jacobian(q), arm.analytical_jacobian_derivative(q, velocity)
        pose_acceleration = J_A @ acceleration[..., None] + rate @ velocity[..., None]
        torque = per_row(oracle.inverse_dynamics, q, velocity, acceleration, np.zeros((100, 3)))
        model = arm.operational_space_dynamics(q, velocity)
        force = (model.inertia @ pose_acceleration)[..., 0] + model.coriolis_force + model.gravity_force
        pushed = (np.linalg.pinv(J_A).mT @ torque[..., None])[..., 0]
        np.testing.assert_allclose(force, pushed, rtol=0, atol=ROUNDING)
        # and back: J_A^T J_A^{+T} = 1 because J_A has full column rank
        np.testing.assert_allclose((J_A.mT @ force[..., None])[..., 0], torque, rtol=0, atol=ROUNDING)


def test_operational_inertia_is_symmetric_of_rank_3_and_keeps_the_kinetic_energy() -> None:
    random, velocity, _, _ = random_states(2, 100)
    q = np.concatenate([random[:96], SINGULAR])
    B_A = ARM.operational_space_dynamics(q, velocity).inertia
    np.testing.assert_allclose(B_A, B_A.mT, rtol=0, atol=ROUNDING)
    assert (np.linalg.matrix_rank(B_A) == 3).all()
    pose_velocity = ARM.analytical_jacobian(q) @ velocity[..., None]
    energy = 0.5 * (pose_velocity.mT @ B_A @ pose_velocity)[..., 0, 0]
    np.testing.assert_allclose(energy, ARM.kinetic_energy(q, velocity), rtol=0, atol=ROUNDING)


def test_operational_space_leaves_friction_out() -> None:
    q, velocity, _, _ = random_states(3, 20)
    for with_friction, without in zip(
        ARM.operational_space_dynamics(q, velocity),
        FRICTIONLESS.operational_space_dynamics(q, velocity),
        strict=True,
    ):
        np.testing.assert_array_equal(with_friction, without)


def test_regressor_times_parameters_is_the_model_along_a_reference_of_its_own() -> None:
    q, velocity, acceleration, _ = random_states(4, 100)
    reference = np.random.default_rng(5).uniform(-3.0, 3.0, size=(100, 3))
    for parameters in (NOMINAL, random_arm(0)[0], random_arm(1)[0]):
        arm = PRPArm(dataclasses.replace(parameters, viscous_friction=VISCOUS, coulomb_friction=COULOMB))
        expected = (
            (arm.inertia_matrix(q) @ acceleration[..., None])[..., 0]
            + (arm.coriolis_matrix(q, velocity) @ reference[..., None])[..., 0]
            + np.array(VISCOUS) * reference
            + np.array(COULOMB) * np.sign(reference)
            + arm.gravity_vector(q)
        )
        found = arm.regressor(q, velocity, reference, acceleration) @ arm.parameter_vector()
        np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


def test_regressor_along_the_motion_itself_gives_pinocchios_torques() -> None:
    q, velocity, acceleration, _ = random_states(6, 50)
    found = FRICTIONLESS.regressor(q, velocity, velocity, acceleration) @ FRICTIONLESS.parameter_vector()
    expected = per_row(PinocchioArm().inverse_dynamics, q, velocity, acceleration, np.zeros((50, 3)))
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


def test_regressor_does_not_know_masses_inertias_or_friction() -> None:
    arguments = arguments_of("regressor", (5,))
    other = PRPArm(NOMINAL.scaled((0.5, 2.0, 3.0)))
    np.testing.assert_array_equal(other.regressor(*arguments), ARM.regressor(*arguments))
    assert not np.allclose(other.parameter_vector(), ARM.parameter_vector())


def test_regressor_has_no_column_that_others_replace() -> None:
    Y = ARM.regressor(*arguments_of("regressor", (50,)))
    assert Y.shape == (50, 3, 12)
    assert np.linalg.matrix_rank(Y.reshape(150, 12)) == 12


@PROPERTY
@given(joints=TRIPLES, speeds=TRIPLES, reference=TRIPLES, factor=st.floats(0.1, 5.0))
def test_regressor_without_gravity_and_friction_is_linear_in_the_reference(
    joints: tuple[float, ...], speeds: tuple[float, ...], reference: tuple[float, ...], factor: float
) -> None:
    arm = PRPArm(dataclasses.replace(NOMINAL, gravity=0.0))
    r = np.array(reference)
    once = arm.regressor(joints, speeds, r, 2 * r)[:, :9]
    scaled = arm.regressor(joints, speeds, factor * r, 2 * factor * r)[:, :9]
    # entries up to 5 * 50 * 5 before they are scaled
    np.testing.assert_allclose(scaled, factor * once, rtol=1e-12, atol=10 * ROUNDING)


def test_parameter_vector_holds_base_parameters_then_frictions() -> None:
    (m_1, m_2, m_3), moments = NOMINAL.link_mass, NOMINAL.link_inertia
    first = (
        m_1 * 0.2**2 + moments[0][2] + (m_2 + m_3) * 0.4**2 + moments[1][2] + m_2 * 0.15**2 + moments[2][1]
    )
    spread = m_3 * 0.12**2 + moments[2][2] - moments[2][1]
    base = [first, m_2 + m_3, m_2 * 0.15, m_3 * 0.12, spread, m_3 * 0.12**2 + moments[2][0]]
    expected = [*base, *VISCOUS, *COULOMB]
    np.testing.assert_allclose(ARM.parameter_vector(), expected, rtol=1e-14)
