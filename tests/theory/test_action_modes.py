"""A constant action shifts the closed loops' equilibria and responses as their closed forms say."""

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from prp_gym.action_modes import SMOOTHING_TIME, ModeSetup, commanded, make_action_mode
from prp_gym.baselines import load_gains, make_baseline
from prp_gym.envs import PRPEnv
from prp_gym.robot import PRPArm
from prp_gym.robot.arrays import Array
from tests.support.contact_episodes import side_by_side
from tests.support.control_interface import oracle_jacobian
from tests.support.mode_episodes import environment, made
from tests.support.pinocchio_model import PinocchioArm

IMPEDANCE = make_baseline("impedance", environment("PRP-Impedance-v0")).settings
M_D, K_D, K_P = (float(getattr(IMPEDANCE, name)[0]) for name in ("inertia", "damping", "stiffness"))
FORCE = make_baseline("parallel_force_position", environment("PRP-Force-v0")).settings
INTO = np.array([0.0, -1.0, 0.0])  # the slide's direction at q_1 = 0, into the surface
TOUCH, DEEP = (0.0, -0.2, 0.0), (0.0, -0.1, 0.0)
DEPTH = 0.1  # [m] between their tips
GAP = 0.02  # [m] from the tip of TOUCH to the surface where sensors are tared
DAMPING, STIFF = 5.0, 1000.0  # [N s/m], [N/m]
SURFACE = {
    "surface_normal": -INTO,
    "surface_offset": -0.34,
    "surface_damping": DAMPING,
}  # through that of TOUCH
# the tip reaches it after tens of readings off the surface, so that taring subtracts no contact force
BELOW = {**SURFACE, "surface_offset": -0.34 - GAP}
FAR = {**SURFACE, "surface_offset": -5.0}


def action_for(env: PRPEnv, **meant: Array) -> Array:
    """The action whose fields mean the given values, and what is neutral elsewhere."""
    parts = []
    for field in env.action_fields:
        bound, value = (
            np.array(field.bound),
            np.array(meant.get(field.name, np.ones(field.size) * field.factor)),
        )
        parts.append(np.log(value) / np.log(bound) if field.factor else value / bound)
    return np.concatenate(parts)


def steady(env: PRPEnv, action: Array, **options: Any) -> dict[str, Array]:
    """Ground truth at the end of an episode with a constant action."""
    env.reset(seed=0, options=options)
    over = False
    while not over:
        *_, terminated, over, _ = env.step(action)
        assert not terminated
    parts: dict[str, Array] = env.task.ground_truth_layout.split(env.ground_truth)
    return parts


@pytest.mark.parametrize("mode", ["joint_position", "joint_inverse_dynamics"])
def test_joints_settle_the_offset_beyond_the_reference(mode: str) -> None:
    env = made("PRP-JointRegulation-v0", mode, control_frequency=20, duration=2.0)
    offset, goal = np.array([0.2, -0.04, -0.15]), (0.4, -0.2, 0.3)
    ground_truth = steady(
        env, action_for(env, joint_offset=offset), joint_position=(0.3, -0.15, 0.2), goal=goal
    )
    # gravity is compensated where the arm is, so that nothing is left but what has not yet decayed: at least
    # as exp(-28 t), ζω of the gains, for more than a second
    np.testing.assert_allclose(ground_truth["joint_position"], goal + offset, atol=1e-8)


def test_link_settles_the_offset_beyond_the_reference() -> None:
    env = made("PRP-Adaptive-v0", "joint_position", scenario="report", control_frequency=20)
    moved, given = (steady(env, np.array([share]))["joint_position"][0] for share in (0.5, 0.0))
    # the reference moves on: both lag alike, but for what gravity and inertia make of 0.15 rad in between
    assert moved - given == pytest.approx(0.15, abs=0.01)


@pytest.mark.parametrize("mode", ["operational_position", "impedance", "admittance", "force_position"])
def test_tip_settles_where_springs_towards_the_moved_pose_hold_each_other(mode: str) -> None:
    regulated = mode == "operational_position"
    name = "PRP-PoseRegulation-v0" if regulated else "PRP-Impedance-v0"
    env = made(name, mode, scenario="report", control_frequency=20, duration=4.0)
    offset = np.array([0.03, -0.02, 0.04, 0.1, -0.2])
    offset *= 0.1 if mode == "force_position" else 1.0  # whose offsets are bounded by less
    options = {"joint_position": TOUCH, "goal": DEEP} | ({} if regulated else FAR)
    ground_truth = steady(env, action_for(env, pose_offset=offset), **options)
    moved = PRPArm().forward_kinematics(np.array(DEEP)) + np.append(offset, 0.0)
    jacobian = oracle_jacobian(PinocchioArm(), ground_truth["joint_position"])
    weights = WEIGHTS[mode] * (moved - ground_truth["end_effector_pose"])
    # of the springs' pull, ten or more, what has not decayed after 3 s, as exp(-5 t) at least
    np.testing.assert_allclose(jacobian.T @ weights, 0.0, atol=1e-4 * np.abs(weights).max())
    assert (
        np.abs(moved - ground_truth["end_effector_pose"])[:5].max() > 1e-4
    )  # three joints do not come all the way


OPERATIONAL = load_gains("operational_pd", "tuned", "PRP-PoseRegulation-v0")
WEIGHTS: dict[str, Array] = {
    "operational_position": np.full(6, OPERATIONAL["proportional_gain"]),
    "impedance": IMPEDANCE.stiffness / IMPEDANCE.inertia,
    "admittance": np.ones(6),
    "force_position": np.ones(6),
}
"""The springs by mode, up to a common factor: controllers that prescribe accelerations weigh them equally."""


class Constant:
    """A policy of constant actions (N, size), one for each episode."""

    def __init__(self, actions: Array) -> None:
        self._actions = actions

    def predict(self, *_: Any, **__: Any) -> tuple[Array, None]:
        return self._actions, None


def with_actions(env: PRPEnv, actions: Sequence[Array], **options: Any) -> dict[str, Array]:
    """Ground truth (T, N, size) of episodes with the same reset options and a constant action each."""
    count = len(actions)
    values = {name: np.asarray(value, dtype=np.float64) for name, value in options.items()}
    rows = {name: np.broadcast_to(value, (count, *value.shape)) for name, value in values.items()}
    return side_by_side(Constant(np.stack(actions)), env, **rows)


def test_surface_is_pressed_with_the_springs_in_series() -> None:
    env = made(
        "PRP-Impedance-v0", "variable_stiffness", scenario="report", control_frequency=20, duration=4.0
    )
    offset, factor = np.array([[0.0, 1.0], [0.03, 1.0], [-0.04, 1.0], [0.0, 6.0], [0.03, 0.3]]).T
    actions = [
        action_for(env, pose_offset=np.append(way * INTO, np.zeros(2)), stiffness_factor=np.full(5, share))
        for way, share in zip(offset, factor, strict=True)
    ]
    surface, spring = 300.0, factor * K_P
    fields = with_actions(env, actions, **BELOW, surface_stiffness=surface, joint_position=TOUCH, goal=DEEP)
    expected = surface * spring / (surface + spring) * (DEPTH - GAP + offset)
    # MuJoCo's contact is a spring to 1e-3 of its stiffness
    np.testing.assert_allclose(fields["contact_force"][-1] @ INTO, expected, rtol=3e-3)


def test_surface_is_pressed_with_the_moved_force() -> None:
    env = made("PRP-Force-v0", "force_position", scenario="report", control_frequency=20, duration=3.0)
    offsets = np.array([0.0, 2.0, -1.5])
    actions = [action_for(env, force_offset=offset * INTO) for offset in offsets]
    surface = {**BELOW, "surface_stiffness": 500.0, "desired_force": 3.0}
    fields = with_actions(env, actions, **surface, joint_position=TOUCH)
    # the integral leaves nothing but exp(-10 t) of the approach, over two seconds
    np.testing.assert_allclose(fields["contact_force"][-1], np.outer(3.0 + offsets, INTO), atol=1e-4)


def ways(env: PRPEnv, actions: Sequence[Array], **options: Any) -> Array:
    """How far the tips have come along the slide (T, N) [m]."""
    poses = with_actions(env, actions, joint_position=TOUCH, **FAR, **options)["end_effector_pose"]
    moved: Array = (poses[..., :3] - PRPArm().forward_kinematics(TOUCH)[:3]) @ INTO
    return moved


def step_along_the_slide(env: PRPEnv, stiffness: float, damping: float) -> Array:
    """The action that moves the tip by 0.02 m, with factors of the stiffness and of the damping ratio."""
    return action_for(
        env,
        pose_offset=np.array([*(0.02 * INTO), 0.0, 0.0]),
        stiffness_factor=np.full(5, stiffness),
        damping_factor=np.full(5, damping),
    )


@pytest.fixture
def prompt(monkeypatch: pytest.MonkeyPatch) -> None:
    """Controllers that follow an action at once, so that it is a step."""
    monkeypatch.setattr(commanded, "SMOOTHING_TIME", 1e-9)


@pytest.mark.usefixtures("prompt")
def test_damping_ratio_follows_its_factor_and_not_that_of_the_stiffness() -> None:
    env = made("PRP-Impedance-v0", "variable_impedance", scenario="report", duration=3.0)
    cases = list(itertools.product((1.0, 3.0, 0.5), (0.25, 0.5)))
    moved = ways(env, [step_along_the_slide(env, *case) for case in cases], goal=TOUCH)
    np.testing.assert_allclose(moved[-1], 0.02, rtol=0.05)
    decay = np.log(moved.max(axis=0) / 0.02 - 1.0)
    ratio = -decay / np.hypot(np.pi, decay)  # of a mass, damper and spring that overshoots so far
    nominal = K_D / (2.0 * np.sqrt(K_P * M_D))
    # held over dt, a torque is dt/2 old: that takes about ω dt/2 off, 0.01 to 0.02 here
    np.testing.assert_allclose(ratio, [damping * nominal for _, damping in cases], rtol=0, atol=0.025)


@pytest.mark.usefixtures("prompt")
def test_response_is_that_much_faster_under_a_stiffness_factor() -> None:
    env = made("PRP-Impedance-v0", "variable_impedance", scenario="report", duration=1.5)
    moved = ways(env, [step_along_the_slide(env, factor, 0.25) for factor in (1.0, 4.0)], goal=TOUCH)
    peaks = 0.002 * (1 + np.argmax(moved, axis=0))
    ratio = 0.25 * K_D / (2.0 * np.sqrt(K_P * M_D))
    expected = np.pi / (np.sqrt(K_P / M_D) * np.sqrt(1.0 - ratio**2))
    # half of the period and of the peak's flat top, 1.4 periods in all
    np.testing.assert_allclose(peaks, [expected, expected / 2.0], rtol=0.0, atol=0.0028)


def test_tip_approaches_a_surface_so_many_times_as_fast() -> None:
    env = made(
        "PRP-Force-v0", "variable_force_position", scenario="report", control_frequency=20, duration=1.5
    )
    factors = np.array([0.5, 1.0, 3.0])
    actions = [action_for(env, approach_speed_factor=np.array([factor])) for factor in factors]
    moved = ways(env, actions, desired_force=0.02)
    # the inner loop lags by a constant distance once exp(-10 t) of the factor's own delay has decayed
    speed = (moved[-1] - moved[-5]) / 0.2
    # so fast that the tip can be braked while the force rises from half of 0.02 N to that, on 5 N/m
    nominal = np.sqrt(2.0 * FORCE.approach_deceleration * 0.01 / 5.0)
    np.testing.assert_allclose(speed, factors * nominal, rtol=1e-3)


def test_force_error_decays_so_many_times_as_fast() -> None:
    env = made(
        "PRP-Force-v0", "variable_force_position", scenario="report", control_frequency=20, duration=3.0
    )
    factors = np.array([0.25, 0.35, 0.5])
    actions = [action_for(env, bandwidth_factor=np.array([factor])) for factor in factors]
    surface = {**SURFACE, "surface_stiffness": STIFF, "desired_force": 3.0}
    force = with_actions(env, actions, joint_position=TOUCH, **surface)["contact_force"] @ INTO
    # on the surface from the start, taring takes readings below 2.8 σ of the sensor's noise for its bias
    np.testing.assert_allclose(force[-1], 3.0, rtol=0, atol=2.8 * 0.05)
    errors = force[-1] - force
    rate = np.log(errors[10] / errors[16]) / 0.3
    stiffness, damping = FORCE.proportional_gain[1], FORCE.derivative_gain[1]
    lag = damping / stiffness
    # the slowest root of s (1 + T s + s²/K_P) (1 + 0.2 s/ω_n) + ω_c (1 + D s/K + T s) = 0 with T = K_D/K_P
    # and K_P of the inner loop and the nominal bandwidth ω_n; a period of 0.002 s more or less makes 2 %
    inertia = (1.0 - lag * rate + rate**2 / stiffness) * (1.0 - 0.2 * rate / FORCE.bandwidth)
    lead = 1.0 - rate * (DAMPING / STIFF + lag)
    np.testing.assert_allclose(rate * inertia / lead, factors * FORCE.bandwidth, rtol=0.02)


def test_command_inputs_follow_the_action_with_their_time_constant() -> None:
    env = made("PRP-JointRegulation-v0", "joint_position")
    observation, _ = env.reset(seed=0)
    mode = make_action_mode("joint_position", ModeSetup(env.task, env.torque_limit, 0.002))
    action, starts, memory = np.array([[1.0, -0.5, 0.25]]), np.array([True]), None
    for period in range(1, 101):
        _, memory = mode.torque(action, observation[None], memory, starts)
        starts = np.array([False])
        reached = 1.0 - np.exp(-0.002 * period / SMOOTHING_TIME)
        np.testing.assert_allclose(memory[0], reached * action, rtol=1e-12)
