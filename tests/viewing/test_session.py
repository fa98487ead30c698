"""Time, settings, surface, scenario and disturbance of a session change as in fresh environments."""

from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.baselines import CONTROLLERS, make_baseline
from prp_gym.errors import EpisodeError, InvalidValueError, PRPError, UnknownNameError
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import apply_transposed
from prp_gym.tuning.search_space import SearchSpace
from prp_gym.viewing.agent_source import AgentSource
from prp_gym.viewing.disturbance import Disturbance
from prp_gym.viewing.inner_controller_source import InnerControllerSource
from prp_gym.viewing.session import Session
from tests.support.viewing_sessions import SEED, controller_session, controller_source

FORCE, CONTROLLER = "PRP-Force-v0", "parallel_force_position"
BEFORE, AFTER = 60, 40
"""Actions before and after a change: with 120 ms the tip is in contact."""


def run(env: Any, policy: Any, observation: Any, state: Any, steps: int, start: bool = False) -> Any:
    """Act for some steps; returns the last observation and the state of the policy."""
    for index in range(steps):
        first = np.array([start and index == 0])
        action, state = policy.predict(observation, state, episode_start=first, deterministic=True)
        observation, *_ = env.step(action)
    return observation, state


def fresh(steps: int, scenario: str = "randomized") -> Any:
    """An environment of Gymnasium and its controller after some steps, without any session."""
    env = gymnasium.make(FORCE, scenario=scenario)
    observation, _ = env.reset(seed=SEED)
    policy = make_baseline(CONTROLLER, env)
    return env, policy, *run(env, policy, observation, None, steps, start=True)


def test_reset_with_a_seed_gives_the_episode_of_gymnasium() -> None:
    session = controller_session(FORCE, CONTROLLER)
    session.advance(BEFORE)
    session.reset(SEED)
    session.advance(BEFORE)
    env, *_ = fresh(BEFORE)
    assert (session.inner.ground_truth == env.unwrapped.ground_truth).all()
    assert session.time == pytest.approx(BEFORE * 0.002)
    session.reset(SEED + 1)
    assert not (session.inner.ground_truth == fresh(0)[0].unwrapped.ground_truth).all()


def test_pause_stops_time_and_a_single_step_takes_one_action() -> None:
    session = controller_session(FORCE, CONTROLLER)
    session.pause()
    before = session.inner.ground_truth
    assert session.advance(10) == 0
    assert session.time == 0.0
    assert (session.inner.ground_truth == before).all()
    assert session.step()
    assert session.time == session.period
    session.resume()
    assert session.advance(10) == 10


def test_changed_factor_moves_as_a_fresh_environment_with_those_gains_from_the_same_state() -> None:
    session = controller_session(FORCE, CONTROLLER)
    session.advance(BEFORE)
    session.set_factor("force_bandwidth", 0.5)
    session.advance(AFTER)
    env, policy, observation, state = fresh(BEFORE)
    changed = make_baseline(CONTROLLER, env, bandwidth=0.5 * policy.settings.bandwidth)
    run(env, changed, observation, state, AFTER)
    assert (session.inner.ground_truth == env.unwrapped.ground_truth).all()
    run(env, policy, observation, state, AFTER)
    assert session.factors["force_bandwidth"] == 0.5
    assert session.changed


def test_sliders_are_the_declared_search_space() -> None:
    session = controller_session(FORCE, CONTROLLER)
    space = SearchSpace.of(CONTROLLERS[CONTROLLER], session.policy.settings)  # type: ignore[attr-defined]
    assert session.parameters == space.parameters


@pytest.mark.parametrize("value", [0.01, 100.0, float("nan"), "x"])
def test_refused_factor_changes_nothing(value: Any) -> None:
    session = controller_session(FORCE, CONTROLLER)
    policy, factors = session.policy, session.factors
    with pytest.raises(PRPError):
        session.set_factor("force_bandwidth", value)
    with pytest.raises(UnknownNameError):
        session.set_factor("stiffness", 1.0)
    assert (session.policy, session.factors, session.changed) == (policy, factors, False)


def test_surface_changes_while_the_episode_runs_and_stays_changed_after_a_reset() -> None:
    session = controller_session(FORCE, CONTROLLER)
    session.advance(BEFORE)
    tip = session.inner.physics.tip_position[0].copy()
    plane = session.inner.physics.surface()
    session.set_surface("surface_stiffness", 123.0)
    session.set_surface("surface_damping", 4.0)
    session.advance(400)
    assert session.surface == {"surface_stiffness": 123.0, "surface_damping": 4.0}
    moved = session.inner.physics.tip_position[0]
    force = session.inner.physics.contact_force[0]
    depth = plane.offset[0] - plane.normal[0] @ moved
    assert -force @ plane.normal[0] == pytest.approx(123.0 * depth, rel=1e-3)  # at rest, without damping
    assert np.linalg.norm(moved - tip) > 0.01  # a soft surface yields by centimetres
    session.reset(SEED)
    options = {"surface_stiffness": 123.0, "surface_damping": 4.0}
    env = gymnasium.make(FORCE)
    observation, _ = env.reset(seed=SEED, options=options)
    assert session.surface == options
    assert (session.inner.ground_truth[: len(observation)] == observation).all()
    session.release_surface()
    session.reset(SEED)
    assert session.surface["surface_stiffness"] == fresh(0)[0].unwrapped.physics.surface().stiffness[0]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("surface_stiffness", 0.0),
        ("surface_stiffness", 1e9),
        ("surface_damping", -1.0),
        ("surface_offset", 0.0),
    ],
)
def test_refused_surface_changes_nothing(name: str, value: float) -> None:
    session = controller_session(FORCE, CONTROLLER)
    before = session.surface
    with pytest.raises(PRPError):
        session.set_surface(name, value)
    assert session.surface == before


def test_free_space_has_no_surface() -> None:
    session = controller_session("PRP-JointRegulation-v0", "joint_pd")
    assert not session.has_surface
    assert session.surface == {}
    with pytest.raises(InvalidValueError, match="no surface"):
        session.set_surface("surface_stiffness", 100.0)


def test_another_scenario_starts_its_episode_of_the_same_seed() -> None:
    session = controller_session(FORCE, CONTROLLER)
    session.set_factor("force_bandwidth", 2.0)
    session.choose_scenario("realistic")
    session.advance(BEFORE)
    assert session.inner.task.scenario.name == "realistic"
    assert session.factors["force_bandwidth"] == 2.0
    with pytest.raises(UnknownNameError):
        session.choose_scenario("reelistic")
    assert session.time == pytest.approx(BEFORE * 0.002)
    assert session.scenario == "realistic"


def test_another_controller_starts_the_episode_of_the_same_seed() -> None:
    session = controller_session(FORCE, CONTROLLER)
    session.advance(BEFORE)
    session.choose_source(controller_source(FORCE, "force_inner_position", "report"))
    assert (session.time, session.seed) == (0.0, SEED)
    assert type(session.policy).__name__ == "ForceInnerPositionController"
    with pytest.raises(InvalidValueError, match="unstable"):
        session.choose_source(controller_source(FORCE, CONTROLLER, frequency=50.0))
    assert session.source.name == "force_inner_position"
    assert session.advance(5) == 5


def test_signals_are_those_of_the_environment() -> None:
    session = controller_session(FORCE, CONTROLLER)
    rows, torques = [session.inner.ground_truth], [np.zeros(3)]
    for _ in range(BEFORE):
        session.step()
        rows.append(session.inner.ground_truth)
        torques.append(session.inner.commanded_torque)
    signals, layout = session.signals, session.inner.task.ground_truth_layout
    assert signals.time == pytest.approx(np.arange(BEFORE + 1) * 0.002)
    for name, values in layout.split(np.array(rows)).items():
        assert (signals.fields[name] == values).all(), name
    assert (signals.torque == np.array(torques)).all()
    assert (signals.torque_limit == session.inner.torque_limit).all()


def test_window_keeps_the_last_seconds_in_order() -> None:
    session = Session(controller_source("PRP-JointRegulation-v0", "joint_pd"), "report", SEED, seconds=0.05)
    session.advance(40)
    signals = session.signals
    assert signals.time == pytest.approx(np.arange(15, 41) * 0.002)
    assert (signals.fields["joint_position"][-1] == session.inner.physics.joint_position[0]).all()


def test_force_on_the_tip_acts_as_the_torques_of_the_transposed_jacobian() -> None:
    session = controller_session("PRP-PoseRegulation-v0", "operational_pd", "report", "report")
    session.advance(5)
    q = session.inner.physics.joint_position[0].copy()
    state = session.inner.get_state()
    force = (3.0, -2.0, 1.0)
    session.disturb(Disturbance(0.004, force))
    session.advance(3)
    expected = apply_transposed(PRPArm().analytical_jacobian(q)[:3], np.array(force))
    assert session.signals.disturbance[-3] == pytest.approx(expected, abs=1e-12)
    assert session.signals.disturbance[-2].any()  # 2 periods of 2 ms
    assert not session.signals.disturbance[-1].any()
    pushed = session.inner.ground_truth
    env = gymnasium.make("PRP-PoseRegulation-v0", scenario="report")
    env.reset(seed=0)
    inner: Any = env.unwrapped
    inner.set_state(state)
    policy = make_baseline("operational_pd", env, "report")
    run(env, policy, inner.loop.ground_truth[0], None, 3)
    assert np.abs(pushed - inner.ground_truth).max() > 1e-4


def test_joint_torques_deflect_a_pd_controller_by_torque_over_gain() -> None:
    session = controller_session("PRP-JointRegulation-v0", "joint_pd", scenario="report")
    session.advance(1000)
    session.disturb(Disturbance(2.5, torque=(1.0, 2.0, 0.5)))
    session.advance(1000)
    gain = session.policy.settings.proportional_gain  # type: ignore[attr-defined]
    fields = session.signals.fields
    error = (fields["desired_joint_position"] - fields["joint_position"])[-1]
    assert error == pytest.approx(-np.array([1.0, 2.0, 0.5]) / gain, rel=1e-2)  # a rest of the motion


def test_reset_ends_a_disturbance() -> None:
    session = controller_session("PRP-JointRegulation-v0", "joint_pd", scenario="report")
    session.disturb(Disturbance(2.0, torque=(5.0, 0.0, 0.0)))
    session.advance(50)
    session.reset(SEED)
    session.advance(50)
    other = controller_session("PRP-JointRegulation-v0", "joint_pd", scenario="report")
    other.advance(50)
    assert (session.inner.ground_truth == other.inner.ground_truth).all()


@pytest.mark.parametrize("duration", [0.0, -1.0, 1e3, float("nan")])
def test_disturbance_needs_a_duration(duration: float) -> None:
    with pytest.raises(InvalidValueError, match="duration"):
        Disturbance(duration, (1.0, 0.0, 0.0))


def test_disturbance_that_does_not_fit_the_robot_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="N"):
        Disturbance(1.0, (1e6, 0.0, 0.0))
    link = controller_session("PRP-Adaptive-v0", "adaptive")
    with pytest.raises(InvalidValueError, match="torques alone"):
        link.disturb(Disturbance(1.0, (1.0, 0.0, 0.0)))
    with pytest.raises(InvalidValueError, match="each joint"):
        link.disturb(Disturbance(1.0, torque=(1.0, 0.0, 0.0)))
    assert not link.changed
    link.disturb(Disturbance(0.02, torque=(1.0,)))
    link.advance(11)
    assert (link.signals.disturbance[1:, 0] == [1.0] * 10 + [0.0]).all()


def test_episode_ends_with_its_duration() -> None:
    session = controller_session("PRP-JointRegulation-v0", "joint_pd", "tuned_50hz", frequency=50.0)
    assert session.advance(10_000) == 250
    assert session.over
    assert not session.diverged
    assert not session.step()
    assert 0.0 < session.total_reward < 250.0
    with pytest.raises(EpisodeError, match="reset"):
        session.disturb(Disturbance(1.0, (1.0, 0.0, 0.0)))
    session.reset(SEED)
    assert not session.over


def test_agent_acts_in_the_environment_of_its_training() -> None:
    source = AgentSource("PRP-Force-v0/ppo_variable_force_position", FORCE)
    session = Session(source, "randomized", SEED)
    session.advance(5)
    env = source.make_env("randomized")
    observation, _ = env.reset(seed=SEED)
    policy = source.make_policy(env, {})
    run(env, policy, observation, None, 5, start=True)
    assert (session.inner.ground_truth == env.unwrapped.ground_truth).all()  # type: ignore[attr-defined]
    inner_periods = round(5 * 500 / session.inner.control_frequency)
    assert len(session.signals.time) == inner_periods + 1  # those of the inner controller
    assert session.parameters == ()


def test_agent_of_another_environment_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="environment of agent"):
        AgentSource("PRP-Force-v0/ppo_variable_force_position", "PRP-Impedance-v0")


def test_zero_actions_leave_the_inner_controller_as_it_is() -> None:
    session = Session(InnerControllerSource("PRP-Impedance-v0", "admittance", 50.0), "report", SEED)
    session.advance(20)
    env = gymnasium.make("PRP-Impedance-v0", scenario="report")
    observation, _ = env.reset(seed=SEED)
    run(env, make_baseline("admittance", env), observation, None, 200, start=True)
    assert (session.inner.ground_truth == env.unwrapped.ground_truth).all()  # type: ignore[attr-defined]
