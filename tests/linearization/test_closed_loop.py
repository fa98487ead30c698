"""The linearised closed loop against differences of environment and controller, and its next state."""

from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym import controller, make_baseline
from prp_gym.errors import ShapeError, UntraceableError
from tests.linearization.periods import Loop, deviation
from tests.support.compiler import needs_compiler
from tests.support.differences import differences

pytestmark = needs_compiler

ROUNDING = 4e-8
"""Largest deviation of difference quotients from the derivatives: see `test_arm_derivatives`."""

RANDOMIZED: dict[str, Any] = {"scenario": "randomized"}
REALISTIC: dict[str, Any] = {"scenario": "realistic"}
SLOW: dict[str, Any] = {**RANDOMIZED, "control_frequency": 100, "gains": "tuned_50hz"}
LOOPS: dict[str, tuple[str, str, int, dict[str, Any]]] = {
    "integral action, delay": ("PRP-JointTracking-v0", "joint_inverse_dynamics", 100, REALISTIC),
    "no state, no delay": ("PRP-JointTracking-v0", "joint_pd", 100, RANDOMIZED),
    "contact, force read": ("PRP-Force-v0", "parallel_force_position", 700, RANDOMIZED),
    "contact, friction, force read": ("PRP-Force-v0", "force_inner_position", 700, REALISTIC),
    "contact": ("PRP-Compliance-v0", "compliance", 700, REALISTIC),
    "contact, impedance, force read": ("PRP-Impedance-v0", "impedance", 700, RANDOMIZED),
    "integral action": ("PRP-PoseRegulation-v0", "time_optimal", 20, RANDOMIZED),
    "saturated": ("PRP-JointRegulation-v0", "joint_pd", 0, RANDOMIZED),
    "integral action, saturated": ("PRP-PoseRegulation-v0", "time_optimal", 0, RANDOMIZED),
    "ten substeps": ("PRP-JointTracking-v0", "joint_pd", 20, SLOW),
    "one joint": ("PRP-Adaptive-v0", "joint_pd", 500, RANDOMIZED),
}


@pytest.mark.parametrize("name", LOOPS)
def test_derivatives_of_the_closed_loop(name: str) -> None:
    environment, policy, periods, keywords = LOOPS[name]
    loop = Loop(environment, policy, periods, engine="compiled", **keywords)
    model = loop.linearized()
    assert model.A_cl is not None
    assert model.closed_loop_state is not None
    assert model.A_cl.shape == (len(model.closed_loop_names),) * 2 == (len(model.closed_loop_units),) * 2
    expected = differences(lambda z: loop.period(model, z), model.closed_loop_state)
    assert deviation(model.A_cl, expected) < ROUNDING
    touching = "contact" in name
    assert bool(np.count_nonzero(loop.env.physics.contact_force)) == touching
    saturated = np.abs(model.torque) >= loop.env.torque_limit * (1.0 - 1e-7)
    assert saturated.any() == ("saturated" in name)
    starts = {each.partition("_")[0] for each in model.closed_loop_names}
    assert ("applied" in starts) == ("force read" in name)
    assert ("commanded" in starts) == (keywords["scenario"] == "realistic")


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("engine", ["compiled", "mujoco"])
def test_the_next_state_is_that_of_the_environment(name: str, engine: str) -> None:
    environment, policy, periods, keywords = LOOPS[name]
    loop = Loop(environment, policy, periods, engine=engine, **keywords)
    model = loop.linearized()
    assert model.next_closed_loop_state is not None
    joints, after = len(loop.env.torque_limit), loop.next_period()
    solved = 1e-5 if engine == "mujoco" else 1e-12  # MuJoCo's solver stops at a tolerance
    state = np.concatenate([loop.env.physics.joint_position[0], loop.env.physics.joint_velocity[0]])
    assert deviation(model.next_state, state) < solved
    assert loop.env.applied_torque == pytest.approx(model.torque, rel=1e-12)
    assert (model.next_closed_loop_state[: 2 * joints] == model.next_state).all()
    own = model.next_closed_loop_state[len(model.next_closed_loop_state) - len(after) :]
    assert own == pytest.approx(after, rel=1e-12, abs=1e-15)


def test_the_environment_is_left_as_it_is() -> None:
    loops = [Loop("PRP-Force-v0", "force_inner_position", 300, engine="compiled") for _ in range(2)]
    model = loops[0].linearized()
    assert model.A_cl is not None
    for _ in range(20):
        outcomes = []
        for loop in loops:
            action, loop.policy_state = loop.controller.predict(loop.observation, loop.policy_state)
            loop.observation, reward, *_ = loop.env.step(action)
            outcomes.append((loop.observation.tobytes(), reward))
        assert outcomes[0] == outcomes[1]


def test_eigenvalues_tell_a_stable_loop_from_a_robot_without_one() -> None:
    loop = Loop("PRP-JointRegulation-v0", "joint_pd", 1500, engine="compiled", scenario="randomized")
    model, free = loop.linearized(), prp_gym.linearize(loop.env)
    assert model.A_cl is not None
    assert np.abs(np.linalg.eigvals(model.A_cl)).max() < 1.0
    assert free.A_cl is None
    assert np.abs(np.linalg.eigvals(free.A)).max() > 1.0 - 1e-6  # joint 1 turns freely


def test_inverse_dynamics_leaves_a_double_integrator_in_each_joint() -> None:
    """With the exact model at every time step: v' = v - h (K_P x + K_D v), x' = x + h v', in any pose."""
    keywords: dict[str, Any] = {**RANDOMIZED, "control_frequency": 1000, "gains": "fast"}
    loop = Loop("PRP-JointTracking-v0", "joint_inverse_dynamics", 300, engine="compiled", **keywords)
    model, h, stiffness, damping = loop.linearized(), 0.001, 500.0, 35.0
    one = np.array([[1.0 - h * h * stiffness, h - h * h * damping], [-h * stiffness, 1.0 - h * damping]])
    assert model.A_cl is not None
    # a torque rounded to single precision accelerates by 1e-7 of the intended, which depends on the pose
    assert model.A_cl == pytest.approx(np.kron(one, np.eye(3)), abs=1e-7)


@controller
def springs(joint_position: Any, desired_joint_position: Any, *, gain: float = 60.0) -> Any:
    """A function as a controller."""
    return gain * (desired_joint_position - joint_position)


@controller
def branching(joint_position: Any) -> Any:
    """A function that cannot be traced."""
    return joint_position if joint_position.sum() > 0.0 else -joint_position


def test_a_function_as_a_controller_closes_the_loop_with_its_gain() -> None:
    env = gymnasium.make("PRP-JointTracking-v0", scenario="randomized", torque_limit=None)
    env.reset(seed=2)
    model = prp_gym.linearize(env, make_baseline(springs, env, gain=25.0))
    assert model.A_cl is not None
    assert model.A_cl == pytest.approx(model.A - 25.0 * model.B @ np.eye(3, 6), rel=1e-12, abs=1e-15)
    assert len(model.closed_loop_names) == 6


def test_a_controller_or_a_state_of_another_kind_is_refused() -> None:
    env = gymnasium.make("PRP-JointTracking-v0", scenario="randomized")
    env.reset(seed=2)
    with pytest.raises(UntraceableError, match="branch"):
        prp_gym.linearize(env, make_baseline(branching, env))
    with pytest.raises(ShapeError, match="state"):
        prp_gym.linearize(env, make_baseline("adaptive", env), state=(np.zeros(2),))
