"""The linearised robot: closed forms, MuJoCo's own step, and what is refused."""

from typing import Any

import gymnasium
import mujoco
import numpy as np
import pytest

import prp_gym
from prp_gym import make_baseline
from prp_gym.baselines.joint_pd import JointPDController
from prp_gym.errors import EpisodeError, InvalidValueError, NonFiniteError, ShapeError
from prp_gym.linearization import Linearization
from prp_gym.physics import Physics, PhysicsSettings, Surface
from prp_gym.physics.engines import in_closed_form
from prp_gym.physics.sampled_plant import SampledPlant
from prp_gym.robot import PRPArm, RobotParameters
from tests.linearization.periods import deviation
from tests.support.compiler import needs_compiler
from tests.support.differences import differences
from tests.support.pinocchio_model import Array

pytestmark = needs_compiler

H = 0.001  # duration of a time step [s]
ROW = np.zeros(1, dtype=np.intp)
NONE = np.zeros((1, 3))
SOLVED = 1e-8
"""Deviation of differences of MuJoCo's step: rounding of 1e-15 over a width of 3e-6, times stiff contacts."""


def arm(surface: Surface | None = None, viscous: Array = NONE, coulomb: Array = NONE) -> Physics:
    """One arm in MuJoCo with joint stops."""
    physics = Physics(settings=PhysicsSettings(H, True, surface is not None))
    physics.set_dynamics(ROW, np.array([[1.1, 0.9, 1.2]]), viscous, coulomb)
    if surface is not None:
        physics.set_surface(ROW, surface)
    return physics


def model_of(physics: Physics, torque: Array, substeps: int = 1) -> tuple[Array, Array, Array, Array]:
    """A, B, C, D of one arm with these torques."""
    plant = SampledPlant(in_closed_form(physics), substeps)
    _, A, B = plant.period(torque)
    return A, B, *plant.measurement()


def test_an_arm_at_rest_is_a_double_integrator_with_the_stiffness_of_its_weight() -> None:
    """At rest without friction and in balance: q̇' = q̇ + h B⁻¹(τ - ∂n/∂q q), q' = q + h q̇'."""
    env: Any = gymnasium.make("PRP-JointRegulation-v0", engine="compiled", control_frequency=1000).unwrapped
    env.reset(seed=0, options={"joint_position": np.array([0.3, -0.2, 0.7])})
    nominal, q = PRPArm(), np.array([0.3, -0.2, 0.7])
    weight = nominal.gravity_vector(q)
    model = prp_gym.linearize(env, action=weight / env.torque_limit)
    inverse = np.linalg.inv(nominal.inertia_matrix(q))
    stiffness = differences(nominal.gravity_vector, q)
    slower = np.concatenate([-H * inverse @ stiffness, np.eye(3)], axis=1)
    expected = np.concatenate([np.eye(3, 6) + H * slower, slower])
    assert deviation(model.A, expected) < 1e-9  # rounding of the differences of the weight
    assert deviation(model.B, np.concatenate([H * H * inverse, H * inverse])) < 1e-12
    assert model.state == pytest.approx(np.concatenate([q, np.zeros(3)]))
    assert model.torque == pytest.approx(weight)
    assert model.next_state == pytest.approx(model.state, abs=1e-12)


def test_contact_adds_its_stiffness_and_damping_along_the_normal() -> None:
    """h B⁻¹Jᵀ(K J q + D J q̇) with the row J of the surface, where the tip touches it without force."""
    q, stiffness, damping = np.array([[0.4, -0.1, 0.9]]), 3000.0, 12.0
    nominal, normal = PRPArm(), np.array([0.0, 0.6, 0.8])
    offset = float(normal @ nominal.forward_kinematics(q[0])[:3]) + 1e-12  # so that the tip is just below
    physics = arm(Surface.single(stiffness, (0.0, 0.6, 0.8), offset, damping))
    physics.reset(ROW, q, np.zeros((1, 3)))
    A, B, C, D = model_of(physics, np.zeros(3))
    free = arm()
    free.reset(ROW, q, np.zeros((1, 3)))
    A_free, B_free, *_ = model_of(free, np.zeros(3))
    J = normal @ nominal.geometric_jacobian(q[0])[:3]
    pull = np.outer(B_free[3:] @ J, J)
    change = np.concatenate([stiffness * pull, damping * pull], axis=1)
    # a contact of MuJoCo adds 0.13 g to the tip's mass of some kg, and stiffness falls with it
    assert A[3:] - A_free[3:] == pytest.approx(-change, rel=1e-3, abs=1e-9)
    force = np.concatenate([stiffness * np.outer(normal, J), damping * np.outer(normal, J)], axis=1)
    assert C[18:] == pytest.approx(force, rel=1e-3, abs=1e-6)
    assert np.abs(D[18:]).max() > 0.0
    assert np.abs(B - B_free).max() < 1e-3 * np.abs(B_free).max()


def worlds() -> dict[str, Physics]:
    """Arms in MuJoCo in several states of their constraints."""
    tip = PRPArm().forward_kinematics(np.array([0.4, -0.1, 0.9]))[:3]
    touched = Surface.single(2000.0, (0.0, 0.6, 0.8), float(np.array([0.0, 0.6, 0.8]) @ tip) + 0.002, 8.0)
    viscous, coulomb = np.array([[0.2, 2.0, 0.02]]), np.array([[0.3, 1.5, 0.04]])
    low, high = PRPArm().joint_limits
    moving, slow = np.array([[0.3, -0.4, 0.6]]), np.array([[1e-4, -1e-4, 1e-4]])
    inside = np.array([[0.4, -0.1, 0.9]])
    stopped = np.array([[0.4, float(high[1]) + 3e-4, float(low[2]) - 4e-4]])
    return {
        "free": _at(arm(), inside, moving),
        "viscous friction": _at(arm(None, viscous), inside, moving),
        "sliding": _at(arm(None, viscous, coulomb), inside, moving),
        "sticking": _at(arm(None, viscous, coulomb), inside, slow),
        "two stops": _at(arm(), stopped, moving),
        "two stops, friction": _at(arm(None, viscous, coulomb), stopped, slow),
        "contact": _at(arm(touched), inside, slow),
        "contact, friction": _at(arm(touched, viscous, coulomb), inside, slow),
    }


def _at(physics: Physics, q: Array, velocity: Array) -> Physics:
    physics.reset(ROW, q, velocity)
    return physics


@pytest.mark.parametrize("name", worlds())
@pytest.mark.parametrize("substeps", [1, 4])
def test_derivatives_are_those_of_mujocos_own_step(name: str, substeps: int) -> None:
    physics, torque = worlds()[name], np.array([0.1, -0.5, 0.02])
    model, data = physics.model(), physics.data()
    model.opt.tolerance, model.opt.iterations = 0.0, 1000

    def period(given: Array) -> Array:
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:], data.ctrl[:] = np.split(given, 3)
        for _ in range(substeps):
            mujoco.mj_step(model, data)
        return np.concatenate([data.qpos, data.qvel])

    A, B, *_ = model_of(physics, torque, substeps)
    at = np.concatenate([physics.joint_position[0], physics.joint_velocity[0], torque])
    assert deviation(np.concatenate([A, B], axis=1), differences(period, at)) < SOLVED


@pytest.mark.parametrize("task", ["PRP-Force-v0", "PRP-JointTracking-v0", "PRP-Adaptive-v0"])
def test_both_engines_have_the_same_linear_model(task: str) -> None:
    models: list[Linearization] = []
    for engine in ("mujoco", "compiled"):
        env: Any = gymnasium.make(task, engine=engine, scenario="realistic")
        env.reset(seed=5)
        models.append(prp_gym.linearize(env))
    for name in ("A", "B", "C", "D", "next_state"):
        first, second = (getattr(model, name) for model in models)
        assert first == pytest.approx(second, rel=1e-9, abs=1e-12)  # masses from MuJoCo's fields
    assert models[0].names == models[1].names
    assert models[0].period == 1.0 / 500.0
    assert len(models[0].measured_names) == len(models[0].C) == len(models[0].measured_units)


def test_without_an_action_the_present_torques_go_on() -> None:
    env: Any = gymnasium.make("PRP-JointTracking-v0", engine="compiled")
    env.reset(seed=0)
    env.step(np.array([0.1, -0.2, 0.3]))
    limit = env.unwrapped.torque_limit
    assert prp_gym.linearize(env).torque == pytest.approx(limit * [0.1, -0.2, 0.3])
    beyond = prp_gym.linearize(env, action=np.array([3.0, -0.5, -7.0]))
    assert beyond.torque == pytest.approx(limit * [1.0, -0.5, -1.0])


class WithPredict(JointPDController):
    """A controller with a predict of its own."""

    def predict(self, *given: Any, **named: Any) -> Any:
        return super().predict(*given, **named)


def test_what_cannot_be_linearised_is_refused() -> None:
    env: Any = gymnasium.make("PRP-JointTracking-v0", engine="compiled")
    with pytest.raises(EpisodeError, match="reset"):
        prp_gym.linearize(env)
    env.reset(seed=0)
    controller = make_baseline("joint_pd", env)
    with pytest.raises(InvalidValueError, match="whose action it is"):
        prp_gym.linearize(env, controller, action=np.zeros(3))
    with pytest.raises(InvalidValueError, match="without a controller"):
        prp_gym.linearize(env, state=(np.zeros(3),))
    with pytest.raises(ShapeError, match="action"):
        prp_gym.linearize(env, action=np.zeros(2))
    with pytest.raises(NonFiniteError, match="action"):
        prp_gym.linearize(env, action=np.full(3, np.nan))
    with pytest.raises(InvalidValueError, match="predict"):
        prp_gym.linearize(env, WithPredict(controller.interface, controller.settings))
    with pytest.raises(InvalidValueError, match="prp_gym"):
        prp_gym.linearize("PRP-JointTracking-v0")
    with pytest.raises(InvalidValueError, match="JointTracking"):
        prp_gym.linearize(env, make_baseline("joint_pd", gymnasium.make("PRP-PoseTracking-v0")))
    many: Any = gymnasium.make_vec("PRP-JointTracking-v0", 2)
    many.reset(seed=0)
    with pytest.raises(InvalidValueError, match="single"):
        prp_gym.linearize(many)
    mode: Any = gymnasium.make("PRP-JointTracking-v0", action_mode="joint_position", control_frequency=50)
    mode.reset(seed=0)
    with pytest.raises(InvalidValueError, match="action_mode"):
        prp_gym.linearize(mode)


def test_worlds_that_the_closed_form_lacks_are_refused() -> None:
    rough = Physics(settings=PhysicsSettings(H, True, True, surface_friction=0.3))
    with pytest.raises(InvalidValueError, match="surface_friction"):
        in_closed_form(rough)
    with pytest.raises(InvalidValueError, match="parameters of the arm"):
        in_closed_form(Physics(RobotParameters(viscous_friction=(1.0, 1.0, 1.0))))
    other: Any = PhysicsSettings()
    with pytest.raises(InvalidValueError, match="arm or of the link"):
        in_closed_form(other)


def test_torques_beyond_all_bounds_are_refused() -> None:
    physics = in_closed_form(arm())
    physics.watch(np.full(6, 10.0))
    with pytest.raises(InvalidValueError, match="bounds"):
        SampledPlant(physics, 4).period(np.array([0.0, 1e9, 0.0]))
