"""One environment: its named parts, its options, its frames, its saved states, and what it refuses."""

import copy
import itertools
import pickle
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.envs import EnvConfig, PRPEnv
from prp_gym.errors import (
    EpisodeError,
    InvalidValueError,
    JointLimitError,
    NonFiniteError,
    PRPError,
    RenderingError,
    ShapeError,
    UnknownNameError,
)
from prp_gym.physics import LinkPhysics, Physics
from prp_gym.robot import NOMINAL, PRPArm
from prp_gym.robot.link import NOMINAL_LINK, Link
from prp_gym.tasks import Task
from prp_gym.tasks.fields import POSITION_BOUND, SPEED_BOUND

ENVIRONMENT_IDS = prp_gym.list_envs()
REGULATION, TRACKING = "PRP-JointRegulation-v0", "PRP-JointTracking-v0"
STILL = np.zeros(3)
NAN = np.nan


def made(environment_id: str = REGULATION, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """MuJoCo writes warnings of diverging simulations to a file in the working directory."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(params=ENVIRONMENT_IDS)
def environment_id(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_public_attributes_are_those_of_the_design_document(environment_id: str) -> None:
    env = made(environment_id, control_frequency=100, duration=2.0)
    assert isinstance(env.task, Task)
    assert env.task.environment_id == environment_id
    one_joint = env.action_space.shape == (1,)
    assert isinstance(env.physics, LinkPhysics if one_joint else Physics)
    assert env.physics.num_simulations == 1
    assert env.arm == (Link(NOMINAL_LINK) if one_joint else PRPArm(NOMINAL))
    assert env.control_frequency == 100
    assert env.duration == 2.0
    np.testing.assert_array_equal(env.torque_limit, env.arm.parameters.torque_limit)
    observation, _ = env.reset(seed=0)
    assert set(env.observation_layout.split(observation)) == set(env.observation_layout.names)
    assert env.observation_space == env.observation_layout.space()


def test_torque_limit_is_a_copy() -> None:
    env = made()
    env.torque_limit[:] = 0.0
    np.testing.assert_array_equal(env.torque_limit, NOMINAL.torque_limit)


def test_action_is_torque_normalised_by_its_limit() -> None:
    env = made(torque_limit=(2.0, 3.0, 4.0))
    env.reset(seed=0)
    env.step(np.array([0.5, -1.0, 0.25]))
    np.testing.assert_array_equal(env.physics.torque, [[1.0, -3.0, 1.0]])


def test_actions_of_single_precision_and_lists_are_the_same_as_doubles() -> None:
    outcomes = []
    for action in (np.array([0.5, -0.25, 1.0], dtype=np.float32), [0.5, -0.25, 1], np.array([0.5, -0.25, 1])):
        env = made()
        env.reset(seed=0)
        outcomes.append(env.step(action)[0])  # type: ignore[arg-type]
    np.testing.assert_array_equal(outcomes[0], outcomes[1])
    np.testing.assert_array_equal(outcomes[0], outcomes[2])


def test_observations_are_new_arrays_and_the_environments_own_are_out_of_reach() -> None:
    env, twin = made(), made()
    observation, info = env.reset(seed=0)
    twin.reset(seed=0)
    observation[:] = NAN
    info["time"] = NAN
    for _ in range(5):
        observation, *_, info = env.step(STILL)
        expected, *_, expected_info = twin.step(STILL)
        np.testing.assert_array_equal(observation, expected)
        assert info == expected_info
        observation[:] = NAN


def test_mean_reward_at_constant_error_does_not_depend_on_the_control_frequency() -> None:
    returns = []
    for rate in (50, 500, 1000):
        env = made(control_frequency=rate, duration=1.0)
        # the third link upright: a zero torque keeps it there
        env.reset(seed=0, options={"joint_position": (0.3, -0.1, np.pi / 2), "goal": (0.4, -0.11, 1.5)})
        steps = [env.step(STILL) for _ in range(rate)]
        returns.append(sum(step[1] for step in steps) / rate)
        assert steps[-1][3]
        # an unstable balance: a rounding of 1e-16 grows e^7.8 = 2400-fold in a second
        np.testing.assert_allclose(steps[-1][0][:3], [0.3, -0.1, np.pi / 2], rtol=0, atol=1e-11)
    # the same, over a scale of 0.02 m and less
    np.testing.assert_allclose(returns, returns[0], rtol=1e-8)
    assert 0.1 < returns[0] < 0.9


def test_episode_may_be_continued_beyond_its_duration() -> None:
    env = made(duration=0.01)
    env.reset(seed=0)
    flags = [env.step(STILL)[2:4] for _ in range(7)]
    assert flags == [(False, False)] * 4 + [(False, True)] * 3


@pytest.mark.parametrize(
    ("options", "kind", "message"),
    [
        ({"gaol": STILL}, UnknownNameError, "unknown reset option 'gaol'. Did you mean 'goal'?"),
        ({"goal": np.zeros(2)}, ShapeError, r"reset option 'goal' has shape \(2,\); expected \(3,\)"),
        ({"joint_position": np.zeros((1, 3))}, ShapeError, r"'joint_position' has shape \(1, 3\)"),
        ({"joint_velocity": 0.5}, ShapeError, r"'joint_velocity' has shape \(\)"),
        ({"goal": (0.0, NAN, 0.0)}, NonFiniteError, "reset option 'goal' is .*nan"),
        ({"joint_position": (np.inf, 0.0, 0.0)}, NonFiniteError, "reset option 'joint_position' is .*inf"),
        ({"joint_velocity": (0.0, 0.0, -np.inf)}, NonFiniteError, "reset option 'joint_velocity' is .*-inf"),
        ({"goal": (0.0, 0.001, 0.0)}, JointLimitError, "goal: joint 2 is 0.001 m; allowed: -0.3 to 0 m"),
        ({"joint_position": (0, 0, 3.2)}, JointLimitError, "initial joint position: joint 3 is 3.2 rad"),
        ({"joint_velocity": (0, -1e3, 0)}, InvalidValueError, "initial joint velocity is .*-1000.0"),
    ],
)
def test_wrong_reset_option_is_refused_and_the_episode_goes_on(
    options: dict[str, Any], kind: type[PRPError], message: str
) -> None:
    env, twin = made(scenario="realistic"), made(scenario="realistic")
    for either in (env, twin):
        either.reset(seed=0)
        either.step(STILL)
    with pytest.raises(kind, match=message):
        env.reset(options=options)
    for _ in range(5):
        np.testing.assert_array_equal(env.step(STILL)[0], twin.step(STILL)[0])


def test_reset_option_error_keeps_its_facts() -> None:
    with pytest.raises(JointLimitError) as outside:
        made().reset(options={"goal": (0.0, 0.0, -3.5)})
    assert (outside.value.joint, outside.value.value, outside.value.unit) == (3, -3.5, "rad")
    assert outside.value.limits == (-np.pi, np.pi)
    with pytest.raises(UnknownNameError) as unknown:
        made().reset(options={"gaol": STILL})
    assert unknown.value.valid == tuple(sorted(PRPEnv("PRP-JointRegulation-v0").task.reset_options))


@pytest.mark.parametrize(
    ("action", "kind", "message"),
    [
        ((NAN, 0.0, 0.0), NonFiniteError, "action is .*nan"),
        ((0.0, np.inf, 0.0), NonFiniteError, "action is .*inf"),
        ((0.0, 0.0, -np.inf), NonFiniteError, "action is .*-inf"),
        ((0.0, 0.0), ShapeError, r"action has shape \(2,\); expected \(3,\)"),
        (((0.0, 0.0, 0.0),), ShapeError, r"action has shape \(1, 3\)"),
        (0.0, ShapeError, r"action has shape \(\)"),
    ],
)
def test_wrong_action_is_refused_and_changes_nothing(action: Any, kind: type[PRPError], message: str) -> None:
    env, twin = made(scenario="realistic"), made(scenario="realistic")
    for either in (env, twin):
        either.reset(seed=0)
    for _ in range(3):
        with pytest.raises(kind, match=message):
            env.step(np.array(action))
        np.testing.assert_array_equal(env.step(STILL)[0], twin.step(STILL)[0])


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_first_observation_is_in_its_space_for_every_extreme_start(environment_id: str, side: float) -> None:
    env = made(environment_id)
    ranges = list(zip(NOMINAL.joint_lower, NOMINAL.joint_upper, strict=True))
    if env.action_space.shape == (1,):
        ranges = [(-POSITION_BOUND[0], POSITION_BOUND[0])]  # the link has no stops
    for corner in itertools.product(*ranges):
        options = {"joint_position": corner, "joint_velocity": side * np.array(SPEED_BOUND[: len(corner)])}
        observation, _ = env.reset(options=options)
        parts = env.observation_layout.split(observation)
        np.testing.assert_array_equal(parts["joint_position"], corner)
        np.testing.assert_array_equal(parts["joint_velocity"], options["joint_velocity"])
        assert env.observation_space.contains(observation)


def test_step_before_the_first_reset_is_refused() -> None:
    with pytest.raises(EpisodeError, match="call reset first"):
        made().step(STILL)


def test_divergence_ends_the_episode_with_no_reward_and_a_bounded_observation() -> None:
    env = made(torque_limit=None)
    env.reset(seed=0)
    observation, reward, terminated, truncated, info = env.step(np.ones(3))
    assert (terminated, truncated, reward) == (True, False, 0.0)
    assert env.observation_space.contains(observation)
    assert {value for name, value in info.items() if name.startswith("reward_")} == {0.0}
    with pytest.raises(EpisodeError, match="diverged"):
        env.step(STILL)
    fresh, _ = made(torque_limit=None).reset(seed=1)
    np.testing.assert_array_equal(env.reset(seed=1)[0], fresh)
    assert not env.step(STILL)[2]


def test_divergence_in_the_last_step_is_no_truncation() -> None:
    env = made(torque_limit=None, duration=0.002)
    env.reset(seed=0)
    assert env.step(np.ones(3))[2:4] == (True, False)
    env.reset(seed=0)
    assert env.step(STILL)[2:4] == (False, True)


def test_state_saved_before_a_divergence_can_be_restored() -> None:
    env, twin = (made(torque_limit=None, control_frequency=50) for _ in range(2))
    env.reset(seed=0)
    twin.reset(seed=0)
    state = env.get_state()
    assert env.step(np.ones(3))[2]  # so violently that MuJoCo resets the simulation by itself
    env.set_state(state)
    for _ in range(5):
        outcome, expected = env.step(STILL), twin.step(STILL)
        np.testing.assert_array_equal(outcome[0], expected[0])
        assert outcome[1:] == expected[1:]


def test_rendering_before_the_first_reset_is_refused() -> None:
    with pytest.raises(EpisodeError, match="reset"):
        made(render_mode="rgb_array").render()


def test_rendering_without_a_render_mode_is_refused() -> None:
    env = made()
    env.reset(seed=0)
    with pytest.raises(EpisodeError, match="needs a render_mode at make time"):
        env.render()


def test_window_without_a_display_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert "human" not in made().metadata["render_modes"]
    with pytest.raises(RenderingError, match="no display"):
        PRPEnv("PRP-JointRegulation-v0", render_mode="human")
    monkeypatch.setenv("DISPLAY", ":0")
    assert "human" in made().metadata["render_modes"]


def test_metadata_belong_to_the_instance() -> None:
    slow, fast = made(control_frequency=50), made(control_frequency=1000)
    assert (slow.metadata["render_fps"], fast.metadata["render_fps"]) == (50, 1000)


def test_state_of_another_tasks_environment_is_refused_and_changes_nothing() -> None:
    env, other = made(REGULATION), made(TRACKING)
    env.reset(seed=0)
    other.reset(seed=0)
    before = pickle.dumps(env.get_state())
    with pytest.raises(InvalidValueError, match="saved state's task is 'PRP-JointTracking-v0'") as caught:
        env.set_state(other.get_state())
    assert caught.value.allowed == "PRP-JointRegulation-v0"
    assert pickle.dumps(env.get_state()) == before


def test_closing_twice_or_without_frames_is_harmless_and_the_physics_continue() -> None:
    env = made()
    env.reset(seed=0)
    env.close()
    env.close()
    assert np.isfinite(env.step(STILL)[0]).all()


def test_environment_never_reset_can_be_copied() -> None:
    env = made()
    for clone in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert clone.config == EnvConfig()
        np.testing.assert_array_equal(clone.reset(seed=3)[0], made().reset(seed=3)[0])
