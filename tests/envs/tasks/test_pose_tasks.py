"""Pose tasks: references and errors are those of the pose, from the report's numbers or drawn."""

from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.envs import PRPEnv
from prp_gym.envs.base.references import PoseSpaceReference
from prp_gym.envs.base.tracking_starts import STARTS
from prp_gym.errors import InvalidValueError, JointLimitError, UnknownNameError
from prp_gym.robot import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.tasks import SCENARIOS, QuinticWaypoints

REGULATION, TRACKING = "PRP-PoseRegulation-v0", "PRP-PoseTracking-v0"
ARM = PRPArm()
PI = np.pi
STEP = 1e-4  # of finite differences [s]
REPORT_WAYPOINTS = [
    (PI / 3, -0.2, PI / 3),
    (-PI / 3, -0.1, PI / 4),
    (0.0, -0.2, 0.0),
    (PI / 2, 0.0, -PI / 4),
    (PI / 3, -0.1, PI / 4),
    (0.0, 0.0, 0.0),
]


def environment(environment_id: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


def begun(environment_id: str, options: dict[str, Any] | None = None, **keywords: Any) -> PRPEnv:
    env = environment(environment_id, **keywords)
    env.reset(seed=6, options=options)
    return env


def at(env: PRPEnv, time: float) -> tuple[Array, Array, Array]:
    """Desired pose, velocity and acceleration (6 each)."""
    values = env.task.reference(np.array([time]))[0]
    return values[:6], values[6:12], values[12:18]


def pose_of(q_1: float, q_2: float, q_3: float) -> list[float]:
    """k(q), written out: lengths 0.4, 0.3, 0.24 and 0.15 m."""
    reach = q_2 + 0.3 + 0.24 * np.cos(q_3)
    return [
        reach * np.sin(q_1) + 0.4 * np.cos(q_1),
        -reach * np.cos(q_1) + 0.4 * np.sin(q_1),
        0.15 + 0.24 * np.sin(q_3),
        q_1,
        PI / 2 - q_3,
        PI / 2,
    ]


POSE_KINDS: list[tuple[str, dict[str, Any]]] = [
    (name, keywords)
    for name in prp_gym.list_envs()
    if isinstance(environment(name).task.parts.reference, PoseSpaceReference)
    for keywords in ([{"reference": "joint"}, {"reference": "pose"}] if name == TRACKING else [{}])
]


@pytest.mark.parametrize("scenario", ["report", "randomized"])
@pytest.mark.parametrize("kind", POSE_KINDS, ids=lambda kind: "-".join([kind[0], *kind[1].values()]))
def test_rates_of_the_reference_are_derivatives_of_its_pose(kind: tuple[str, Any], scenario: str) -> None:
    env = begun(kind[0], scenario=scenario, **kind[1])
    assert isinstance(env.task.parts.reference, PoseSpaceReference)
    trajectory = env.task.parts.reference.trajectory
    knots = trajectory.times[0] if isinstance(trajectory, QuinticWaypoints) else np.full(1, np.inf)
    for time in np.random.default_rng(0).uniform(0.01, 4.9, 60):
        if np.abs(knots - time).min() < 2 * STEP:
            continue  # where segments meet, the third derivative jumps
        before, now, after = at(env, time - STEP), at(env, time), at(env, time + STEP)
        # Third and fourth derivatives of a quintic of 2 rad in half a second are 1e3 and 1e4 per second, and
        # of the pose some times those: differences err by STEP²/6 of them.
        for order, tolerance in ((0, 5e-5), (1, 1e-3)):
            slope = (after[order] - before[order]) / (2 * STEP)
            np.testing.assert_allclose(now[order + 1], slope, rtol=0, atol=tolerance)


@pytest.mark.parametrize(
    "environment_id", [kind[0] for kind in POSE_KINDS if kind[1] != {"reference": "pose"}]
)
def test_references_in_joint_space_are_what_the_arm_can_do(environment_id: str) -> None:
    env = begun(environment_id)
    task = env.task
    assert isinstance(task.parts.reference, PoseSpaceReference)
    for time in np.linspace(0.0, 5.0, 23):
        q, rate, acceleration = np.split(task.parts.reference.trajectory.sample(np.array([time]))[0], 3)
        pose, velocity, second = at(env, time)
        np.testing.assert_allclose(pose, pose_of(*q), rtol=0, atol=1e-14)  # sums of lengths below 1 m
        # J_A by central differences of the formula above: errors of 1e-12 by rounding, 1e-9 by the step
        columns = [
            (np.array(pose_of(*(q + shift))) - pose_of(*(q - shift))) / 2e-4 for shift in 1e-4 * np.eye(3)
        ]
        J_A = np.array(columns).T
        np.testing.assert_allclose(velocity, J_A @ rate, rtol=0, atol=1e-7)
        drift = np.array(second) - J_A @ acceleration
        # J̇_A q̇ = d²/ds² k(q + s q̇): by second differences, in error by 1e-16/1e-8 and 1e-9 of a rate⁴
        along = [np.array(pose_of(*(q + s * rate))) for s in (-1e-4, 0.0, 1e-4)]
        curvature = (along[0] - 2 * along[1] + along[2]) / 1e-8
        np.testing.assert_allclose(drift, curvature, rtol=0, atol=1e-4)


def test_report_regulation_is_the_reports() -> None:
    env = begun(REGULATION, scenario="report")
    parts = env.task.ground_truth_layout.split(env.ground_truth)
    np.testing.assert_array_equal(parts["joint_position"], 0.0)
    np.testing.assert_array_equal(parts["joint_velocity"], 0.0)
    expected = (0.02679, -0.44641, 0.39, -1.0472, 0.0, 1.5708)  # as printed
    np.testing.assert_allclose(parts["desired_pose"], expected, rtol=0, atol=5e-6)
    for time in (0.0, 1.0, 5.0):
        np.testing.assert_allclose(at(env, time)[0], pose_of(-PI / 3, -0.1, PI / 2), rtol=0, atol=1e-15)
        np.testing.assert_array_equal(at(env, time)[1:], 0.0)


@pytest.mark.parametrize("reference", ["joint", "pose"])
def test_report_tracking_rests_at_the_poses_of_the_reports_waypoints(reference: str) -> None:
    env = begun(TRACKING, scenario="report", reference=reference)
    np.testing.assert_array_equal(env.physics.joint_position, 0.0)
    for index, waypoint in enumerate(REPORT_WAYPOINTS, start=1):
        pose, velocity, acceleration = at(env, 0.5 * index)
        np.testing.assert_allclose(pose, pose_of(*waypoint), rtol=0, atol=1e-14)  # some roundings
        np.testing.assert_array_equal([velocity, acceleration], 0.0)
    for time, waypoint in (
        (0.0, REPORT_WAYPOINTS[0]),
        (0.3, REPORT_WAYPOINTS[0]),
        (4.9, REPORT_WAYPOINTS[-1]),
    ):
        pose, velocity, acceleration = at(env, time)
        np.testing.assert_allclose(pose, pose_of(*waypoint), rtol=0, atol=1e-14)
        np.testing.assert_array_equal([velocity, acceleration], 0.0)


def test_report_tracking_as_run_differs_in_the_first_waypoint_alone() -> None:
    env = begun(TRACKING, scenario="report", waypoints="as_run")
    for index, waypoint in enumerate([(PI / 4, -0.2, PI / 3), *REPORT_WAYPOINTS[1:]], start=1):
        np.testing.assert_allclose(at(env, 0.5 * index)[0], pose_of(*waypoint), rtol=0, atol=1e-14)
    printed = begun(TRACKING, scenario="report")  # the numbers are not shared
    np.testing.assert_allclose(at(printed, 0.5)[0], pose_of(*REPORT_WAYPOINTS[0]), rtol=0, atol=1e-14)


@pytest.mark.parametrize("scenario", ["randomized", "realistic"])
def test_waypoints_as_run_are_refused_where_waypoints_are_drawn(scenario: str) -> None:
    with pytest.raises(InvalidValueError, match=r"waypoints is 'as_run'; allowed: 'printed' .*'report'"):
        environment(TRACKING, scenario=scenario, waypoints="as_run")


def test_unknown_set_of_waypoints_is_refused() -> None:
    with pytest.raises(UnknownNameError) as caught:
        environment(TRACKING, waypoints="as run")
    assert caught.value.valid == ("as_run", "printed")


def test_pose_reference_runs_straight_between_the_poses_of_the_waypoints() -> None:
    env = begun(TRACKING, scenario="report", reference="pose")
    begin, end = (np.array(pose_of(*REPORT_WAYPOINTS[index])) for index in (0, 1))
    for share in (0.1, 0.3, 0.5, 0.9):
        pose, velocity, _ = at(env, 0.5 + 0.5 * share)
        covered = 10 * share**3 - 15 * share**4 + 6 * share**5
        # some roundings of numbers below 3
        np.testing.assert_allclose(pose, begin + covered * (end - begin), rtol=0, atol=1e-14)
        speed = (30 * share**2 - 60 * share**3 + 30 * share**4) / 0.5
        np.testing.assert_allclose(velocity, speed * (end - begin), rtol=0, atol=1e-13)


def test_joint_reference_runs_straight_between_the_waypoints_of_the_joints() -> None:
    env = begun(TRACKING, scenario="report", reference="joint")
    middle = np.mean(REPORT_WAYPOINTS[:2], axis=0)
    np.testing.assert_allclose(at(env, 0.75)[0], pose_of(*middle), rtol=0, atol=1e-14)


@pytest.mark.parametrize("reference", ["joint", "pose"])
@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_start_keyword_says_where_the_reference_begins(scenario: str, start: str, reference: str) -> None:
    env = begun(TRACKING, scenario=scenario, start=start, reference=reference)
    parts = env.task.ground_truth_layout.split(env.ground_truth)
    off = np.abs(parts["desired_pose"] - parts["end_effector_pose"]).max()
    from_home = start == "home" or (start == "scenario" and scenario != "report")
    assert (off < 1e-13) == from_home  # the pose by sensors and by formulas


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("kind", [(REGULATION, {}), (TRACKING, {}), (TRACKING, {"reference": "pose"})])
def test_goal_is_a_joint_position_whose_pose_ends_the_reference(
    kind: tuple[str, dict[str, str]], scenario: str
) -> None:
    goal = (0.5, -0.12, -0.7)
    env = begun(kind[0], {"goal": goal}, scenario=scenario, **kind[1])
    np.testing.assert_allclose(at(env, 5.0)[0], pose_of(*goal), rtol=0, atol=1e-14)
    with pytest.raises(JointLimitError, match=r"goal: joint 2 is 0\.1 m"):
        env.reset(options={"goal": (0.0, 0.1, 0.0)})


@pytest.mark.parametrize("environment_id", [REGULATION, TRACKING])
def test_drawn_references_keep_to_the_joint_limits(environment_id: str) -> None:
    env = environment(environment_id)
    low, high = np.array(ARM.parameters.joint_lower), np.array(ARM.parameters.joint_upper)
    for seed in range(50):
        env.reset(seed=seed)
        samples = env.task.reference(np.linspace(0.0, 5.0, 40)[:, None])[:, 0]
        joints = ARM.joint_position_of_pose(samples[:, :6])
        assert ((joints >= low) & (joints <= high)).all()
        np.testing.assert_allclose(ARM.forward_kinematics(joints), samples[:, :6], rtol=0, atol=1e-12)


@pytest.mark.parametrize("environment_id", [REGULATION, TRACKING])
def test_errors_are_desired_minus_measured_of_tip_alpha_beta_and_the_torque(environment_id: str) -> None:
    task = environment(environment_id).task
    ground_truth = np.zeros((2, task.ground_truth_layout.size))
    parts = task.ground_truth_layout.split(ground_truth)
    parts["desired_pose"][0] = (0.5, -0.5, 0.4, 0.25, 3.0, 0.0)
    parts["end_effector_pose"][0] = (0.4, -0.3, 0.1, 0.5, 1.0, 9.0)
    torque = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    errors = task.errors(ground_truth, torque)
    expected = [[0.5 - 0.4, -0.5 + 0.3, 0.4 - 0.1], [-0.25, 2.0, 0.0], [1.0, 2.0, 3.0]]
    np.testing.assert_array_equal(errors[0], expected)
    np.testing.assert_array_equal(errors[1], [[0.0] * 3, [0.0] * 3, [4.0, 5.0, 6.0]])
    np.testing.assert_array_equal(task.errors(ground_truth[0], torque[0]), errors[0])


@pytest.mark.parametrize("environment_id", [REGULATION, TRACKING])
def test_reward_is_the_declared_kernel_of_the_pose_errors(environment_id: str) -> None:
    env = begun(environment_id)
    for action in np.random.default_rng(0).uniform(-0.5, 0.5, size=(20, 3)):
        _, reward, _, _, info = env.step(action)
        parts = env.task.ground_truth_layout.split(env.ground_truth)
        off = parts["desired_pose"] - parts["end_effector_pose"]
        terms = {
            "reward_position": 0.7 / (1.0 + np.linalg.norm(off[:3] / 0.02)),
            "reward_orientation": 0.25 / (1.0 + np.linalg.norm(off[3:5] / 0.1)),
            "reward_effort": 0.05 / (1.0 + np.linalg.norm(action)),  # torque over the nominal limits
        }
        for name, value in terms.items():
            assert info[name] == pytest.approx(value, rel=1e-12)  # some roundings
        assert reward == pytest.approx(sum(terms.values()), rel=1e-12)


@pytest.mark.parametrize(("keyword", "valid"), [("reference", ("joint", "pose")), ("start", STARTS)])
def test_unknown_reference_or_start_is_refused(keyword: str, valid: tuple[str, ...]) -> None:
    with pytest.raises(UnknownNameError, match=f"unknown {keyword} 'none'") as caught:
        environment(TRACKING, **{keyword: "none"})
    assert caught.value.valid == tuple(sorted(valid))
