"""Where contact tasks put the arm, the surface and the reference: the report's values, and drawn ones."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from prp_gym.envs import PRPEnv
from prp_gym.envs.base.arm_world import check_joint_limits
from prp_gym.envs.base.contact_starts import ContactPoint, ContactStart, ContactWorld
from prp_gym.robot.arrays import Array
from tests.support.contact_episodes import (
    ARM,
    CONTACT_IDS,
    KOLMOGOROV,
    assert_force,
    depth_of,
    draw,
    environment,
    ground_truth_of,
    joint_path,
    joint_targets,
    task_of,
)
from tests.support.drawn_starts import drawn_start

SEEDS = st.integers(0, 2**32 - 1)
HOME_POSE = (0.4, -0.54, 0.15, 0.0, np.pi / 2, np.pi / 2)  # [R] 1.2: a_1, -(d̄_2 + a_3), d_0


@pytest.fixture(params=CONTACT_IDS)
def environment_id(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def reference_at(env: PRPEnv, time: float) -> Array:
    """Desired pose, velocity and acceleration (18)."""
    values: Array = env.task.reference(np.array([time]))[0, :18]
    return values


def random_point(rng: np.random.Generator) -> ContactPoint:
    joints = rng.uniform([-3.0, -0.28, -1.4], [3.0, -0.02, 1.4])
    return ContactPoint(ARM, joints, rng.choice([-1.0, 1.0], size=()))


@given(SEEDS)
def test_slide_moves_the_tip_along_the_normal_of_the_surface(seed: int) -> None:
    point = random_point(np.random.default_rng(seed))
    step = np.array([0.0, 1e-3, 0.0])
    tips = [ARM.forward_kinematics(point.joint_position + shift)[:3] for shift in (step, -step)]
    along_slide = (tips[0] - tips[1]) / 2e-3
    # the slide is straight: only roundings of 1e-16 m over a step of 1e-3 m
    np.testing.assert_allclose(point.normal, -point.side * along_slide, rtol=0, atol=1e-12)
    assert np.linalg.norm(point.normal) == pytest.approx(1.0, rel=1e-15)


@given(SEEDS)
def test_surface_passes_through_the_tip_at_first_contact(seed: int) -> None:
    point = random_point(np.random.default_rng(seed))
    tip = ARM.forward_kinematics(point.joint_position)[:3]
    assert point.offset == pytest.approx(point.normal @ tip, abs=1e-15)
    np.testing.assert_allclose(point.near(np.zeros((1, 3)))[0], point.joint_position, rtol=0, atol=1e-15)


@given(SEEDS)
def test_joint_positions_near_the_surface_lie_at_the_requested_depth(seed: int) -> None:
    rng = np.random.default_rng(seed)
    point = random_point(rng)
    offsets = rng.uniform([-0.5, -0.1, -1.0], [0.5, 0.1, 1.0], size=(4, 5, 3))
    joints = point.near(offsets)
    depth = point.offset - ARM.forward_kinematics(joints)[..., :3] @ point.normal
    # some roundings of lengths below 1 m
    np.testing.assert_allclose(depth, offsets[..., 1], rtol=0, atol=2e-15)
    np.testing.assert_allclose(joints[..., [0, 2]], (point.joint_position + offsets)[..., [0, 2]], rtol=1e-15)


@pytest.mark.parametrize("seeds", [range(200)], ids=["200 draws"])
def test_drawn_episodes_start_off_the_surface_and_keep_to_the_joint_limits(
    environment_id: str, seeds: range
) -> None:
    task = task_of(environment_id)
    gap = task.ranges["start"]
    deepest = task.ranges.get("waypoints", gap).high[1::3]
    for seed in seeds:
        start = draw(task, seed)
        depth = depth_of(start, start.joint_position)
        # roundings of lengths below 1 m
        assert gap.low[1] - 1e-14 <= depth <= gap.high[1] + 1e-14
        assert depth <= -0.01 + 1e-14
        np.testing.assert_array_equal(start.joint_velocity, 0.0)
        targets = joint_targets(start.trajectory)
        check_joint_limits(ARM, "start", start.joint_position)
        check_joint_limits(ARM, "waypoints", targets)
        check_joint_limits(ARM, "path", joint_path(start.trajectory))
        assert (depth_of(start, targets) <= max(deepest) + 1e-14).all()


def test_drawn_references_lead_into_the_surface_where_the_task_is_to_yield(environment_id: str) -> None:
    task = task_of(environment_id)
    asks_for_force = "desired_force" in task.layout.names
    for seed in range(50):
        start = draw(task, seed)
        depth = depth_of(start, joint_targets(start.trajectory)).max()
        assert depth <= 1e-14 if asks_for_force else 0.02 - 1e-14 <= depth <= 0.08 + 1e-14


def test_surface_is_drawn_on_both_sides_and_its_stiffness_log_uniformly(environment_id: str) -> None:
    task = task_of(environment_id)
    starts = [draw(task, seed) for seed in range(500)]
    shares = np.log([start.surface.stiffness[0] / 50.0 for start in starts]) / np.log(5000.0 / 50.0)
    ordered, count = np.sort(shares), len(shares)
    distance = np.abs(ordered - (np.arange(count) + 0.5) / count).max()
    assert np.sqrt(count) * distance < KOLMOGOROV
    damping = np.array([start.surface.damping[0] for start in starts])
    assert damping.min() >= 0.0
    assert damping.max() <= 10.0
    # joint 1 points along the normal or against it, as often: 500 tosses, five standard deviations
    tips = [ARM.forward_kinematics(start.joint_position)[:3] for start in starts]
    inner = [start.joint_position[0] for start in starts]
    outward = [n.surface.normal[0] @ (np.sin(q), -np.cos(q), 0.0) for n, q in zip(starts, inner, strict=True)]
    assert abs(np.mean(np.sign(outward))) < 5 / np.sqrt(count)
    assert np.isfinite(tips).all()


def test_no_tip_is_in_contact_at_the_start_of_drawn_episodes(environment_id: str) -> None:
    env = environment(environment_id)
    for seed in range(20):
        env.reset(seed=seed)
        np.testing.assert_array_equal(ground_truth_of(env)["contact_force"], 0.0)


def report(environment_id: str, **keywords: Any) -> tuple[PRPEnv, dict[str, Array], ContactStart]:
    env = environment(environment_id, scenario="report", **keywords)
    env.reset(seed=0)
    assert isinstance(env.task.parts.world, ContactWorld)
    return env, ground_truth_of(env), draw(env.task, 0)


def assert_plane(start: ContactStart, normal: tuple[float, float, float], offset: float, k: float) -> None:
    np.testing.assert_allclose(start.surface.normal, [normal], rtol=0, atol=1e-15)  # a sine of -π/2
    np.testing.assert_allclose(start.surface.offset, [offset], rtol=0, atol=1e-15)  # sums of lengths
    np.testing.assert_array_equal(start.surface.stiffness, [k])
    np.testing.assert_array_equal(start.surface.damping, [0.0])


def assert_pose(values: Array, *pose: float) -> None:
    np.testing.assert_allclose(values, pose, rtol=0, atol=1e-15)  # sums of lengths below 1 m


def pose_at(y: float) -> tuple[float, ...]:
    """The pose with the slide alone out of its home position."""
    return (0.4, y, 0.15, 0.0, np.pi / 2, np.pi / 2)


def test_report_compliance_is_the_reports() -> None:
    env, ground_truth, start = report("PRP-Compliance-v0")
    np.testing.assert_allclose(
        ground_truth["joint_position"], 0.0, rtol=0, atol=1e-16
    )  # a difference of lengths
    assert_plane(start, (0.0, -1.0, 0.0), 0.44, 50.0)
    for time in (0.0, 1.0, 5.0):
        assert_pose(reference_at(env, time)[:6], *pose_at(-0.34))
        np.testing.assert_array_equal(reference_at(env, time)[6:], 0.0)


def test_report_impedance_is_the_reports() -> None:
    env, ground_truth, start = report("PRP-Impedance-v0")
    np.testing.assert_allclose(ground_truth["joint_position"], 0.0, rtol=0, atol=1e-16)
    assert_plane(start, (0.0, -1.0, 0.0), 0.44, 50.0)
    assert_pose(reference_at(env, 0.0)[:6], *HOME_POSE)
    middle = reference_at(env, 0.5)
    assert_pose(middle[:6], *pose_at(-0.44))
    # 15/8 of the mean speed, 0.2 m in 1 s; a few roundings
    np.testing.assert_allclose(middle[6:12], [0.0, 0.375, 0.0, 0.0, 0.0, 0.0], rtol=0, atol=1e-15)
    for time in (1.0, 4.0):
        assert_pose(reference_at(env, time)[:6], *pose_at(-0.34))


def test_report_admittance_is_the_reports() -> None:
    env, ground_truth, start = report("PRP-Admittance-v0")
    np.testing.assert_allclose(ground_truth["joint_position"], 0.0, rtol=0, atol=1e-16)
    assert_plane(start, (0.0, -1.0, 0.0), 0.34, 50.0)
    for time, y in ((0.0, -0.54), (1.5, -0.29), (3.0, -0.44), (5.0, -0.44)):
        assert_pose(reference_at(env, time)[:6], *pose_at(y))
    hold, _, held = report("PRP-Admittance-v0", reference="hold")
    assert_plane(held, (0.0, -1.0, 0.0), 0.34, 50.0)
    for time, y in ((0.0, -0.54), (1.5, -0.29), (3.0, -0.29), (5.0, -0.29)):
        assert_pose(reference_at(hold, time)[:6], *pose_at(y))


def test_report_force_is_the_reports() -> None:
    env, ground_truth, start = report("PRP-Force-v0")
    np.testing.assert_allclose(ground_truth["joint_position"], 0.0, rtol=0, atol=1e-16)
    assert_plane(start, (0.0, -1.0, 0.0), 0.44, 5.0)
    np.testing.assert_allclose(ground_truth["desired_force"], [0.0, 1.0, 0.0], rtol=0, atol=1e-15)
    for time in (0.0, 2.0):
        assert_pose(reference_at(env, time)[:6], *HOME_POSE)


def test_report_force_and_position_is_the_reports_feasible_variant() -> None:
    env, ground_truth, start = report("PRP-ForcePosition-v0")
    joints = (-np.pi / 2, -0.1, -np.pi / 6)
    reach = 0.2 + 0.24 * np.cos(np.pi / 6)
    np.testing.assert_allclose(ground_truth["joint_position"], joints, rtol=0, atol=1e-15)
    assert_plane(start, (-1.0, 0.0, 0.0), reach - 0.1, 50.0)
    assert reach - 0.1 == pytest.approx(0.3078, abs=5e-5)  # as printed
    np.testing.assert_allclose(ground_truth["desired_force"], [0.5, 0.0, 0.0], rtol=0, atol=1e-15)
    for time in (0.0, 2.0):
        assert_pose(reference_at(env, time)[:6], -reach, -0.4, 0.03, -np.pi / 2, 2 * np.pi / 3, np.pi / 2)


def test_report_force_and_position_may_start_at_home_inside_the_surface_as_its_author_ran_it() -> None:
    env, ground_truth, start = report("PRP-ForcePosition-v0", start="home", surface_stiffness=1.0)
    np.testing.assert_array_equal(ground_truth["joint_position"], 0.0)
    depth = depth_of(start, np.zeros(3))
    assert depth == pytest.approx(0.7078, abs=5e-5)
    assert_force(ground_truth["contact_force"], [depth, 0.0, 0.0])
    assert_pose(reference_at(env, 0.0)[3:6], -np.pi / 2, 2 * np.pi / 3, np.pi / 2)


def test_options_do_not_change_what_else_is_drawn(environment_id: str) -> None:
    task, states = task_of(environment_id), []
    given: dict[str, Any] = {"surface_offset": 0.44, "goal": (0.0, -0.2, 0.0), "surface_stiffness": 3.0}
    target_impedance = [{}, *({name: value} for name, value in given.items() if name in task.reset_options)]
    for options in target_impedance:
        rng = np.random.default_rng(5)
        drawn_start(task, rng, options)
        states.append(rng.bit_generator.state)
    assert len(target_impedance) == (3 if environment_id == "PRP-Force-v0" else 4)
    assert states == states[:1] * len(target_impedance)


@pytest.mark.parametrize("environment_id", [name for name in CONTACT_IDS if name != "PRP-Force-v0"])
def test_goal_replaces_the_end_of_the_reference(environment_id: str) -> None:
    task, goal = task_of(environment_id), (0.5, -0.12, -0.3)
    start = draw(task, 3, goal=goal)
    # the reach along the surface comes and goes with a rounding of lengths below 1 m
    np.testing.assert_allclose(joint_targets(start.trajectory)[-1], goal, rtol=0, atol=1e-15)
    np.testing.assert_allclose(start.trajectory.goal[0, :3], goal, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(start.joint_position, draw(task, 3).joint_position)
