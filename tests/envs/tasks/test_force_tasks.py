"""Force tasks: the desired force, its errors, and where episodes start."""

from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.envs import PRPEnv
from prp_gym.envs.base.contact_starts import ContactStart
from prp_gym.envs.base.force_errors import ForceErrors
from prp_gym.envs.base.force_options import FORCE_BOUNDS
from prp_gym.envs.tasks.force_position import ReachWaypoints
from prp_gym.errors import InvalidValueError, NonFiniteError, PRPError, ShapeError, UnknownNameError
from prp_gym.robot import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.tasks import Constant
from prp_gym.tasks.task import Task
from tests.support.contact_episodes import joint_path, joint_targets
from tests.support.drawn_starts import drawn_start

FORCE, FORCE_POSITION = "PRP-Force-v0", "PRP-ForcePosition-v0"
IDS = (FORCE, FORCE_POSITION)
DEEPEST = {FORCE: 0.06, FORCE_POSITION: 0.05}  # largest indentation by a drawn force [m]
ARM = PRPArm()
NAN = float("nan")


def environment(environment_id: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


def task_of(environment_id: str, **keywords: Any) -> Task:
    task = environment(environment_id, **keywords).task
    assert isinstance(task.parts.errors, ForceErrors)
    return task


def draw(task: Task, seed: int, **options: Any) -> ContactStart:
    start = drawn_start(task, seed, options)
    assert isinstance(start, ContactStart)
    return start


@pytest.fixture(params=IDS)
def environment_id(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_desired_force_points_into_the_surface_and_is_drawn_between_1_and_10_newtons(
    environment_id: str,
) -> None:
    task = task_of(environment_id)
    magnitudes = []
    for seed in range(200):
        start = draw(task, seed, surface_stiffness=5000.0)
        magnitude = np.linalg.norm(start.desired_force)
        # one product of three
        np.testing.assert_allclose(
            start.desired_force, -magnitude * start.surface.normal[0], rtol=0, atol=1e-14
        )
        magnitudes.append(magnitude)
    assert min(magnitudes) >= 1.0 - 1e-14
    assert max(magnitudes) <= 10.0 + 1e-14
    # the mean of 200 uniform numbers on [1, 10]: five standard deviations of 9/sqrt(12·200)
    assert np.mean(magnitudes) == pytest.approx(5.5, abs=5 * 9 / np.sqrt(12 * 200))


def test_drawn_force_presses_no_deeper_than_the_task_allows(environment_id: str) -> None:
    task, deepest = task_of(environment_id), DEEPEST[environment_id]
    assert task.ranges["greatest_depth"].high[0] == deepest
    capped = 0
    for seed in range(100):
        free = np.linalg.norm(draw(task, seed, surface_stiffness=5000.0).desired_force)
        soft = np.linalg.norm(draw(task, seed, surface_stiffness=80.0).desired_force)
        assert soft == pytest.approx(min(free, 80.0 * deepest), rel=1e-14)  # a root of three squares
        capped += bool(free > 80.0 * deepest)
    assert 20 < capped < 90


def test_drawn_force_is_reached_within_the_slide_range(environment_id: str) -> None:
    task = task_of(environment_id)
    lower, upper = ARM.parameters.joint_lower[1], ARM.parameters.joint_upper[1]
    for seed in range(100):
        start = draw(task, seed)
        depth = np.linalg.norm(start.desired_force) / start.surface.stiffness[0]
        path = joint_path(start.trajectory) if environment_id == FORCE_POSITION else start.trajectory.goal
        for q in path:
            tip = ARM.forward_kinematics(q)[:3]
            missing = tip @ start.surface.normal[0] - start.surface.offset[0] + depth
            # the slide moves the tip along its own direction (S_1, -C_1, 0)
            along = -start.surface.normal[0] @ (np.sin(q[0]), -np.cos(q[0]), 0.0)
            assert lower <= q[1] + missing / along <= upper


def test_requested_force_is_neither_drawn_nor_limited(environment_id: str) -> None:
    soft = {"surface_stiffness": 50.0}
    by_keyword, both = task_of(environment_id, desired_force=7), task_of(environment_id, desired_force=7.0)
    for start, expected in (
        (draw(by_keyword, 1, **soft), 7.0),
        (draw(both, 1, desired_force=8.5, **soft), 8.5),
        (draw(task_of(environment_id), 1, desired_force=9.0, **soft), 9.0),
    ):
        expected_force = -expected * start.surface.normal[0]
        np.testing.assert_array_equal(start.desired_force, expected_force)


def test_desired_force_is_observed_and_constant_in_the_world(environment_id: str) -> None:
    env = environment(environment_id)
    observation, _ = env.reset(
        seed=0,
        options={"surface_normal": (3.0, 0.0, 4.0), "surface_offset": -1.0, "desired_force": 5.0},
    )
    for _ in range(30):
        force = env.observation_layout.split(observation)["desired_force"]
        np.testing.assert_allclose(force, [-3.0, 0.0, -4.0], rtol=0, atol=1e-14)  # a root and products
        observation, *_ = env.step(np.full(3, 0.1))


def test_each_of_many_environments_keeps_its_own_force(environment_id: str) -> None:
    task = task_of(environment_id)
    first, second = (task.draw([np.random.default_rng(s) for s in seeds], {}) for seeds in (range(3), [3]))
    task.begin(np.arange(3), first)
    task.begin(np.array([1]), second)
    expected = np.array([draw(task, seed).desired_force for seed in (0, 3, 2)])
    everyone = task.reference(np.zeros((5, 3)))
    assert everyone.shape == (5, 3, 21)
    np.testing.assert_array_equal(everyone[..., 18:], np.broadcast_to(expected, (5, 3, 3)))
    some = task.reference(np.zeros((5, 2)), np.array([0, 2]))
    np.testing.assert_array_equal(some[..., 18:], np.broadcast_to(expected[[0, 2]], (5, 2, 3)))


def row_of(environment_id: str, **values: Any) -> Array:
    task = task_of(environment_id)
    row = np.zeros(task.ground_truth_layout.size)
    for name, value in values.items():
        row[task.ground_truth_layout.index(name)] = value
    return row


def test_errors_are_the_force_along_the_normal_the_tip_along_the_surface_and_the_angles(
    environment_id: str,
) -> None:
    pose = {
        "desired_pose": (0.5, 0.4, 0.3, 1.0, 2.0, 3.0),
        "end_effector_pose": (0.4, 0.2, 0.0, 0.5, 2.5, 0.0),
    }
    torque = np.array([1.0, -2.0, 3.0])
    rows = [
        row_of(environment_id, force_error=(0.75, 0.0), desired_force=(0.0, 2.0, 0.0), **pose),
        row_of(environment_id, force_error=(-1.0, 0.5), desired_force=(0.0, 0.0, -4.0), **pose),
        row_of(environment_id, force_error=(1.0, 1.0), desired_force=(3.0, 4.0, 0.0), **pose),
    ]
    # deviation (0.1, 0.2, 0.3) m less its part along the force: nothing, y, z, (0.6, 0.8, 0) · 0.22
    deviations = [(0.1, 0.0, 0.3), (0.1, 0.2, 0.0), (0.1 - 0.132, 0.2 - 0.176, 0.3)]
    errors = task_of(environment_id).errors(np.array(rows), np.tile(torque, (3, 1)))
    assert errors.shape == (3, 5, 3)
    for found, force, deviation in zip(
        errors, ((0.75, 0.0), (-1.0, 0.5), (1.0, 1.0)), deviations, strict=True
    ):
        expected = [(force[0], 0.0, 0.0), (force[1], 0.0, 0.0), deviation, (0.5, -0.5, 0.0), torque]
        np.testing.assert_allclose(
            found, np.array(expected), rtol=0, atol=1e-15
        )  # roundings of numbers below 1
    np.testing.assert_array_equal(task_of(environment_id).errors(rows[2], torque), errors[2])


def test_regulation_of_force_holds_the_pose_of_its_start() -> None:
    for scenario in ("report", "randomized"):
        env = environment(FORCE, scenario=scenario)
        for options in ({}, {"joint_position": (0.3, -0.2, 0.1)}):
            env.reset(seed=0, options=options)
            parts = env.task.ground_truth_layout.split(env.ground_truth)
            # the pose by sensors and by formulas
            np.testing.assert_allclose(parts["desired_pose"], parts["end_effector_pose"], rtol=0, atol=1e-14)
            later = env.task.reference(np.array([3.0]))[0]
            np.testing.assert_array_equal(later[:6], parts["desired_pose"])
            np.testing.assert_array_equal(later[6:18], 0.0)
        assert isinstance(draw(task_of(FORCE, scenario=scenario), 0).trajectory, Constant)


def test_pressing_along_the_surface_starts_on_its_reference_and_goes_to_and_fro_2_cm_off_the_surface() -> (
    None
):
    task = task_of(FORCE_POSITION)
    for seed in range(50):
        start = draw(task, seed)
        assert isinstance(start.trajectory, ReachWaypoints)
        waypoints, path = joint_targets(start.trajectory), joint_path(start.trajectory)
        # roundings of lengths below 1 m and of angles up to pi
        np.testing.assert_allclose(waypoints[0], start.joint_position, rtol=0, atol=1e-15)
        np.testing.assert_allclose(waypoints[-1], start.joint_position, rtol=0, atol=1e-14)
        np.testing.assert_array_equal(path[:, 0], waypoints[0, 0])
        heights = ARM.forward_kinematics(path)[:, :3] @ start.surface.normal[0]
        np.testing.assert_allclose(heights - start.surface.offset[0], 0.02, rtol=0, atol=1e-14)
        turns = path[:, 2] - start.joint_position[2]
        assert 0.0 < np.abs(turns).max() <= 0.3


def test_start_at_home_leaves_the_reference_as_it_is() -> None:
    home = draw(task_of(FORCE_POSITION, scenario="report", start="home"), 3)
    goal = draw(task_of(FORCE_POSITION, scenario="report"), 3)
    np.testing.assert_array_equal(home.joint_position, 0.0)
    np.testing.assert_array_equal(home.joint_velocity, 0.0)
    time = np.linspace(0.0, 5.0, 11)[:, None]
    np.testing.assert_array_equal(home.trajectory.sample(time), goal.trajectory.sample(time))
    np.testing.assert_array_equal(home.surface.offset, goal.surface.offset)
    np.testing.assert_array_equal(home.desired_force, goal.desired_force)


@pytest.mark.parametrize("scenario", ["randomized", "realistic"])
def test_start_at_home_is_refused_where_the_surface_is_drawn(scenario: str) -> None:
    with pytest.raises(
        InvalidValueError, match=r"start is 'home'; allowed: 'goal' in this scenario: .*scenario 'report'"
    ):
        gymnasium.make(FORCE_POSITION, scenario=scenario, start="home")


def test_requested_joint_position_overrides_the_start_at_home() -> None:
    position = (0.2, -0.1, 0.3)
    start = draw(task_of(FORCE_POSITION, scenario="report", start="home"), 3, joint_position=position)
    np.testing.assert_array_equal(start.joint_position, position)


@pytest.mark.parametrize(
    ("value", "kind", "message"),
    [
        (0.0, InvalidValueError, r"desired_force is 0\.0 N; allowed: 0\.001 to 1000\."),
        (-1.0, InvalidValueError, r"desired_force is -1\.0 N; allowed: 0\.001 to 1000\."),
        (1001, InvalidValueError, r"desired_force is 1001\.0 N; allowed: 0\.001 to 1000\."),
        (NAN, InvalidValueError, r"desired_force is nan N; allowed: 0\.001 to 1000\."),
        (float("inf"), InvalidValueError, r"desired_force is inf N; allowed: 0\.001 to 1000\."),
        ("hard", InvalidValueError, "desired_force is 'hard' N; allowed: a number"),
        (True, InvalidValueError, "desired_force is True N; allowed: a number"),
        ((1.0, 2.0), ShapeError, r"desired_force has shape \(2,\); expected \(\)"),
    ],
)
def test_impossible_force_is_refused_as_keyword(
    environment_id: str, value: Any, kind: type[PRPError], message: str
) -> None:
    with pytest.raises(kind, match=message):
        gymnasium.make(environment_id, desired_force=value)


@pytest.mark.parametrize("value", FORCE_BOUNDS)
def test_force_at_the_end_of_its_bounds_is_taken(environment_id: str, value: float) -> None:
    for start in (
        draw(task_of(environment_id, desired_force=value), 0),
        draw(task_of(environment_id), 0, desired_force=value),
    ):
        assert np.linalg.norm(start.desired_force) == pytest.approx(value, rel=1e-15)  # a unit normal


@pytest.mark.parametrize(
    ("value", "kind", "message"),
    [
        (0.0, InvalidValueError, r"desired_force is 0\.0 N; allowed: 0\.001 to 1000\."),
        (1000.5, InvalidValueError, r"desired_force is 1000\.5 N; allowed: 0\.001 to 1000\."),
        (True, InvalidValueError, "reset option 'desired_force' is True"),
        (-2.0, InvalidValueError, "desired_force is -2.0 N"),
        (NAN, NonFiniteError, "reset option 'desired_force' is nan"),
        ((0.0, 1.0, 0.0), ShapeError, r"reset option 'desired_force' has shape \(3,\); expected \(\)"),
        ("hard", InvalidValueError, "reset option 'desired_force' is 'hard'"),
    ],
)
def test_impossible_force_is_refused_as_reset_option(
    environment_id: str, value: Any, kind: type[PRPError], message: str
) -> None:
    with pytest.raises(kind, match=message):
        environment(environment_id).reset(seed=0, options={"desired_force": value})


def test_unknown_start_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="unknown start 'away'") as caught:
        gymnasium.make(FORCE_POSITION, start="away")
    assert caught.value.valid == ("goal", "home")


class Contact:
    """A force task of one environment under a given contact force, with 2 N desired along y."""

    def __init__(self, environment_id: str) -> None:
        self.task = task_of(environment_id)
        self.begin()

    def begin(self) -> None:
        """Begin an episode."""
        self.task.begin(np.arange(1), self.task.draw([np.random.default_rng(0)], {}))

    def step(self, force: float) -> tuple[float, float]:
        """Relative force error and disturbance of the contact after a step."""
        layout = self.task.ground_truth_layout
        row = np.zeros((1, layout.size))
        row[0, layout.index("desired_force")] = (0.0, 2.0, 0.0)
        row[0, layout.index("contact_force")] = (0.0, force, 0.0)
        self.task.advance(row)
        self.task.complete(row)
        error, disturbance = row[0, layout.index("force_error")].tolist()
        return error, disturbance


def test_excess_force_counts_twice_and_missing_force_once(environment_id: str) -> None:
    contact = Contact(environment_id)
    assert contact.step(1.5)[0] == pytest.approx(0.25)
    assert contact.step(2.5)[0] == pytest.approx(-0.5)


def test_impact_fades_with_the_time_constant(environment_id: str) -> None:
    contact = Contact(environment_id)
    assert contact.step(2.0)[1] == 0.0
    assert contact.step(3.0)[1] == pytest.approx(0.5)
    steps = round(5.0 / contact.task.period)  # one time constant
    after = [contact.step(2.0)[1] for _ in range(steps)][-1]
    # the product of `steps` roundings
    assert after == pytest.approx(0.5 / np.e, rel=1e-12)


def test_without_contact_and_after_its_loss_the_disturbance_is_one(environment_id: str) -> None:
    contact = Contact(environment_id)
    assert contact.step(0.0) == (1.0, 1.0)
    assert contact.step(0.9)[1] == 0.0  # it was never lost
    assert contact.step(0.0)[1] == 1.0
    assert contact.step(2.0)[1] == 0.0  # it had not been established
    assert contact.step(0.0)[1] == 1.0
    assert contact.step(2.0)[1] == pytest.approx(np.exp(-contact.task.period / 5.0))
    contact.begin()
    assert contact.step(2.0)[1] == 0.0
