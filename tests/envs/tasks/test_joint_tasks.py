"""The joint-space tasks: the report's numbers, draws within the limits, and what options replace."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.envs import PRPEnv
from prp_gym.envs.base.arm_world import check_joint_limits
from prp_gym.envs.base.scenarios import load_scenario
from prp_gym.envs.base.tracking_starts import STARTS
from prp_gym.envs.tasks.joint_tracking import REFERENCES, TrackingOptions
from prp_gym.errors import JointLimitError, UnknownNameError
from prp_gym.robot import NOMINAL, PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.tasks import SCENARIOS, Constant, QuinticWaypoints
from prp_gym.tasks.parts import EpisodeStart
from prp_gym.tasks.reward import Reward
from prp_gym.tasks.setup import TaskNumbers, TaskSetup
from prp_gym.tasks.spec import TASKS, NoOptions
from prp_gym.tasks.task import Task
from tests.support.drawn_starts import drawn_start

SEEDS = st.integers(0, 2**32 - 1)
PERIOD = 0.002  # of control; nothing here depends on it [s]
LOW, HIGH = np.array(NOMINAL.joint_lower), np.array(NOMINAL.joint_upper)
GOAL, START, SPEED = np.array([1.0, -0.15, 0.5]), np.array([0.5, -0.1, -1.0]), np.array([0.3, -0.2, 2.0])
REPORT_GOAL = (np.pi / 2, -0.2, np.pi)
REPORT_WAYPOINTS = np.array(
    [
        [np.pi / 3, -0.2, np.pi / 3],
        [-np.pi / 3, -0.1, np.pi / 4],
        [0.0, -0.2, 0.0],
        [np.pi / 2, 0.0, -np.pi / 4],
        [np.pi / 3, -0.1, np.pi / 4],
        [0.0, 0.0, 0.0],
    ]
)
RANDOM = [name for name in SCENARIOS if not load_scenario(name).deterministic]


def made(environment_id: str, scenario: str, options: Any) -> Task:
    spec = TASKS.find(environment_id)
    return Task(spec, TaskSetup(TaskNumbers.read(spec.numbers), load_scenario(scenario), options, PERIOD))


def regulation(scenario: str) -> Task:
    return made("PRP-JointRegulation-v0", scenario, NoOptions())


def tracking(scenario: str, reference: str = "quintic", start: str = "scenario") -> Task:
    return made("PRP-JointTracking-v0", scenario, TrackingOptions(start, reference))


def tasks(scenario: str) -> list[Task]:
    return [regulation(scenario), *(tracking(scenario, reference) for reference in REFERENCES)]


def draw(task: Task, seed: int, **options: Array) -> EpisodeStart:
    start = drawn_start(task, seed, options)
    assert isinstance(start, EpisodeStart)
    return start


def environment(environment_id: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, scenario="report", **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


def reference_at(env: PRPEnv, time: float) -> Array:
    """Desired position, velocity and acceleration (9)."""
    values: Array = env.task.reference(np.array([time]))[0]
    return values


def within_limits(joint_position: Array) -> bool:
    return bool(((joint_position >= LOW) & (joint_position <= HIGH)).all())


def test_report_regulation_starts_at_home_at_rest_with_the_reports_goal() -> None:
    env = environment("PRP-JointRegulation-v0")
    parts = env.observation_layout.split(env.reset(seed=0)[0])
    np.testing.assert_array_equal(parts["joint_position"], 0.0)
    np.testing.assert_array_equal(parts["joint_velocity"], 0.0)
    np.testing.assert_array_equal(parts["desired_joint_position"], REPORT_GOAL)
    np.testing.assert_array_equal(parts["desired_joint_velocity"], 0.0)
    np.testing.assert_array_equal(parts["desired_joint_acceleration"], 0.0)


def test_report_tracking_holds_the_first_waypoint_and_then_rests_at_each() -> None:
    env = environment("PRP-JointTracking-v0")
    parts = env.observation_layout.split(env.reset(seed=0)[0])
    np.testing.assert_array_equal(parts["joint_position"], 0.0)
    np.testing.assert_array_equal(parts["desired_joint_position"], REPORT_WAYPOINTS[0])
    for time in (0.0, 0.2, 0.49):
        np.testing.assert_array_equal(reference_at(env, time), [*REPORT_WAYPOINTS[0], *np.zeros(6)])
    for index, waypoint in enumerate(REPORT_WAYPOINTS, start=1):
        # the last waypoint is start + (stop - start), one rounding
        np.testing.assert_allclose(
            reference_at(env, 0.5 * index), [*waypoint, *np.zeros(6)], rtol=0, atol=1e-15
        )
    np.testing.assert_allclose(reference_at(env, 4.9), np.zeros(9), rtol=0, atol=1e-15)  # likewise
    middle = reference_at(env, 0.75)
    # half way at 15/8 of the mean speed; a few roundings of numbers below 8
    np.testing.assert_allclose(middle[:3], REPORT_WAYPOINTS[:2].mean(axis=0), rtol=0, atol=1e-15)
    speed = 15 / 8 * np.diff(REPORT_WAYPOINTS[:2], axis=0)[0] / 0.5
    np.testing.assert_allclose(middle[3:6], speed, rtol=0, atol=1e-14)


def test_report_tracking_from_home_begins_at_home() -> None:
    env = environment("PRP-JointTracking-v0", start="home")
    env.reset(seed=0)
    np.testing.assert_array_equal(reference_at(env, 0.0), 0.0)
    # half way to the first waypoint; one rounding
    np.testing.assert_allclose(reference_at(env, 0.25)[:3], REPORT_WAYPOINTS[0] / 2, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(reference_at(env, 0.5)[:3], REPORT_WAYPOINTS[0])
    np.testing.assert_array_equal(reference_at(env, 2.0)[:3], REPORT_WAYPOINTS[3])


def test_report_sine_is_the_reports() -> None:
    env = environment("PRP-JointTracking-v0", reference="sine")
    np.testing.assert_array_equal(env.reset(seed=0)[0][:3], 0.0)
    for time in np.linspace(0.0, 5.0, 41):
        angle = 2 * np.pi * time
        values = reference_at(env, time)
        # roundings of angles up to 31, amplified by the rate's square 39 in the acceleration
        position = np.array(REPORT_GOAL) + 0.1 * np.sin(angle)
        np.testing.assert_allclose(values[:3], position, rtol=0, atol=1e-14)
        np.testing.assert_allclose(values[3:6], 0.2 * np.pi * np.cos(angle), rtol=0, atol=1e-13)
        np.testing.assert_allclose(values[6:], -0.4 * np.pi**2 * np.sin(angle), rtol=0, atol=1e-12)


def test_report_constant_reference_is_the_regulations_goal() -> None:
    env = environment("PRP-JointTracking-v0", reference="constant")
    env.reset(seed=0)
    np.testing.assert_array_equal(reference_at(env, 1.0), [*REPORT_GOAL, *np.zeros(6)])


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("environment_id", ["PRP-JointRegulation-v0", "PRP-JointTracking-v0"])
def test_declared_ranges_lie_within_the_joint_limits(scenario: str, environment_id: str) -> None:
    loaded = load_scenario(scenario)
    ranges = TaskNumbers.read(TASKS[environment_id].numbers).ranges[loaded.draws]
    for name in {"joint_position", "goal", "waypoints", "center"} & set(ranges):
        for corner in (ranges[name].low, ranges[name].high):
            assert within_limits(np.array(corner).reshape(-1, 3)), name
        assert (np.array(ranges[name].low) <= np.array(ranges[name].high)).all(), name
    if "center" in ranges and loaded.joint_stops:  # the report's sine turns joint 3 beyond its stop
        amplitude = np.array(ranges["amplitude"].high)
        assert within_limits(np.array(ranges["center"].low) - amplitude)
        assert within_limits(np.array(ranges["center"].high) + amplitude)


@settings(max_examples=50)
@given(SEEDS)
def test_everything_drawn_is_reachable_and_references_start_at_the_arms_position(seed: int) -> None:
    for scenario in RANDOM:
        for task in tasks(scenario):
            start = draw(task, seed)
            assert within_limits(start.joint_position)
            np.testing.assert_array_equal(start.joint_velocity, 0.0)
            values = start.trajectory.sample(np.linspace(0.0, 7.0, 100)[:, None])[:, 0]
            # the last waypoint is start + (stop - start), and a quintic rounds too
            np.testing.assert_allclose(values[:, :3].clip(LOW, HIGH), values[:, :3], rtol=0, atol=1e-14)
            if not isinstance(start.trajectory, Constant):
                np.testing.assert_array_equal(values[0, :3], start.joint_position)


@given(SEEDS)
def test_drawn_waypoints_are_an_interval_apart(seed: int) -> None:
    task = tracking("randomized")
    trajectory = draw(task, seed).trajectory
    assert isinstance(trajectory, QuinticWaypoints)
    interval = task.ranges["interval"]
    apart = np.diff(trajectory.times[0])
    # differences of sums below 6
    assert (apart >= np.array(interval.low) - 1e-14).all()
    assert (apart <= np.array(interval.high) + 1e-14).all()


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_options_do_not_change_what_else_is_drawn(scenario: str) -> None:
    for task in tasks(scenario):
        states = []
        for options in ({}, {"goal": GOAL}, {"joint_position": START}, {"joint_velocity": SPEED}):
            rng = np.random.default_rng(5)
            drawn_start(task, rng, options)
            states.append(rng.bit_generator.state)
        assert states == states[:1] * 4


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("reference", ["quintic", "constant"])
def test_goal_leaves_the_start_as_drawn(scenario: str, reference: str) -> None:
    for task in (regulation(scenario), tracking(scenario, reference)):
        drawn, given_goal = draw(task, 3), draw(task, 3, goal=GOAL)
        np.testing.assert_array_equal(given_goal.joint_position, drawn.joint_position)
        np.testing.assert_array_equal(given_goal.trajectory.goal[0], GOAL)
        assert (drawn.trajectory.goal[0] != GOAL).any()


def test_goal_replaces_the_last_waypoint_alone() -> None:
    drawn, given_goal = (draw(tracking("randomized"), 3, **goal).trajectory for goal in ({}, {"goal": GOAL}))
    assert isinstance(drawn, QuinticWaypoints)
    assert isinstance(given_goal, QuinticWaypoints)
    np.testing.assert_array_equal(given_goal.times, drawn.times)
    np.testing.assert_array_equal(given_goal.positions[:, :-1], drawn.positions[:, :-1])
    np.testing.assert_array_equal(given_goal.positions[0, -1], GOAL)


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_start_options_are_honoured(scenario: str) -> None:
    for task in tasks(scenario):
        start = draw(task, 4, joint_position=START, joint_velocity=SPEED)
        np.testing.assert_array_equal(start.joint_position, START)
        np.testing.assert_array_equal(start.joint_velocity, SPEED)
        drawn, goal_kept = draw(task, 4).trajectory.goal, start.trajectory.goal
        np.testing.assert_array_equal(goal_kept, drawn)


def test_quintic_from_home_begins_at_the_given_start() -> None:
    start = draw(tracking("randomized"), 4, joint_position=START)
    np.testing.assert_array_equal(start.trajectory.sample(np.zeros(1))[0, :3], START)


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_start_keyword_says_where_the_quintic_begins(scenario: str, start: str) -> None:
    drawn = draw(tracking(scenario, start=start), 6)
    begin = drawn.trajectory.sample(np.zeros(1))[0, :3]
    from_home = start == "home" or (start == "scenario" and scenario in RANDOM)
    assert np.array_equal(begin, drawn.joint_position) == from_home


def test_sine_about_a_goal_too_near_a_limit_is_refused() -> None:
    task = tracking("randomized", "sine")
    for goal, what in (
        (np.array([0.0, -0.001, 0.0]), "goal plus amplitude"),
        (np.array([-3.1, -0.15, 0.0]), "goal minus amplitude"),
    ):
        with pytest.raises(JointLimitError, match=what):
            draw(task, 0, goal=goal)


@pytest.mark.parametrize(("joint", "unit"), [(1, "rad"), (2, "m"), (3, "rad")])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_joint_limits_are_inclusive_and_name_the_joint(joint: int, unit: str, side: float) -> None:
    edge = np.array([0.0, -0.1, 0.0])
    edge[joint - 1] = (LOW if side < 0 else HIGH)[joint - 1]
    check_joint_limits(PRPArm(), "start", edge)
    beyond = edge.copy()
    beyond[joint - 1] += side * 1e-5
    for values in (beyond, np.array([edge, beyond])):
        with pytest.raises(JointLimitError, match=f"start: joint {joint} is") as caught:
            check_joint_limits(PRPArm(), "start", values)
        assert caught.value.joint == joint
        assert caught.value.value == beyond[joint - 1]
        assert caught.value.unit == unit


@pytest.mark.parametrize(("keyword", "valid"), [("reference", REFERENCES), ("start", STARTS)])
def test_unknown_reference_or_start_is_refused(keyword: str, valid: tuple[str, ...]) -> None:
    with pytest.raises(UnknownNameError, match=f"unknown {keyword} 'none'") as caught:
        TrackingOptions(**{keyword: "none"})
    assert caught.value.valid == tuple(sorted(valid))


def test_errors_are_desired_minus_measured_and_the_torque() -> None:
    task, rng = regulation("report"), np.random.default_rng(0)
    observation, torque = rng.normal(size=(5, task.layout.size)), rng.normal(size=(5, 3))
    parts = task.layout.split(observation)
    errors = task.errors(observation, torque)
    np.testing.assert_array_equal(errors[:, 0], parts["desired_joint_position"] - parts["joint_position"])
    np.testing.assert_array_equal(errors[:, 1], torque)
    np.testing.assert_array_equal(task.errors(observation[2], torque[2]), errors[2])


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_reward_terms_sum_to_one_and_name_a_unit_for_each_component(scenario: str) -> None:
    for task in tasks(scenario):
        terms = task.numbers.reward
        assert Reward(terms)(np.zeros((len(terms), 3))).sum() == pytest.approx(1.0, rel=1e-15)
        assert all(len(term.unit) == len(term.scale) == 3 for term in terms)
        assert [term.name for term in terms] == ["tracking", "effort"]
