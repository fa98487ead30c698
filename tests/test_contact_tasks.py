"""Contact tasks: where the surface is, that it pushes back as declared, and what may be asked of it."""

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import prp_gym
from prp_gym.envs import PRPEnv
from prp_gym.envs.arm_task import check_joint_limits
from prp_gym.envs.contact_task import ContactPlace, ContactStart, ContactTask
from prp_gym.errors import InvalidValueError, JointLimitError, NonFiniteError, PRPError, ShapeError
from prp_gym.robot import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.tasks import Constant, QuinticWaypoints, Trajectory

ARM = PRPArm()
SEEDS = st.integers(0, 2**32 - 1)
HOME_POSE = (0.4, -0.54, 0.15, 0.0, np.pi / 2, np.pi / 2)  # [R] 1.2: a_1, -(d̄_2 + a_3), d_0
KOLMOGOROV = 1.95  # of sqrt(n) D, exceeded once in a thousand samples
PLANE = {"surface_normal": (0.0, -1.0, 0.0), "surface_offset": 0.44}
PRESSED = {"joint_position": (0.0, -0.15, 0.0), **PLANE}  # tip at y = -0.39 m: 0.05 m deep
NAN, INFINITY = float("nan"), float("inf")
# The solver adds 0.13 g to the tip; free links accelerate at up to some 20 m/s² under gravity and, in a
# decimetre of a surface, at force over the least mass of the tip, 0.07 kg: 2e-3 of the force.
SPURIOUS = {"rtol": 3e-3, "atol": 5e-3}


def environment(environment_id: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


CONTACT_IDS = [
    name for name in prp_gym.list_envs() if "contact_force" in environment(name).observation_layout.names
]


@pytest.fixture(params=CONTACT_IDS)
def environment_id(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def task_of(environment_id: str, scenario: str = "randomized", **keywords: Any) -> ContactTask:
    task = environment(environment_id, scenario=scenario, **keywords).task
    assert isinstance(task, ContactTask)
    return task


def draw(task: ContactTask, seed: int, **options: Any) -> ContactStart:
    given = {name: np.array(value, dtype=np.float64) for name, value in options.items()}
    start = task.draw(np.random.default_rng(seed), given)
    assert isinstance(start, ContactStart)
    return start


def truth_of(env: PRPEnv) -> dict[str, Array]:
    parts: dict[str, Array] = env.task.truth_layout.split(env.truth)
    return parts


def begun(environment_id: str, options: Mapping[str, Any], **keywords: Any) -> dict[str, Array]:
    """What is true at the start of an episode, by name."""
    env = environment(environment_id, **keywords)
    env.reset(seed=0, options=dict(options))
    return truth_of(env)


def reference_at(env: PRPEnv, time: float) -> Array:
    """Desired pose, velocity and acceleration (18)."""
    values: Array = env.task.reference(np.array([time]))[0, :18]
    return values


def joint_targets(trajectory: Trajectory) -> Array:
    """(K, 3) the joint positions through which a reference leads."""
    if isinstance(trajectory, QuinticWaypoints):
        return trajectory.positions[0]
    assert isinstance(trajectory, Constant)
    return trajectory.position


def depth_of(start: ContactStart, joint_position: Array) -> Array:
    """Depth (...) [m] of the tip below a start's surface, by forward kinematics along the normal."""
    tip = ARM.forward_kinematics(joint_position)[..., :3]
    return start.surface.offset[0] - tip @ start.surface.normal[0]


def random_place(rng: np.random.Generator) -> ContactPlace:
    joints = rng.uniform([-3.0, -0.28, -1.4], [3.0, -0.02, 1.4])
    return ContactPlace(ARM, joints, float(rng.choice([-1.0, 1.0])))


@given(SEEDS)
def test_slide_moves_the_tip_straight_into_the_surface(seed: int) -> None:
    place = random_place(np.random.default_rng(seed))
    step = np.array([0.0, 1e-3, 0.0])
    tips = [ARM.forward_kinematics(place.joint_position + shift)[:3] for shift in (step, -step)]
    along_slide = (tips[0] - tips[1]) / 2e-3
    # the slide is straight: only roundings of 1e-16 m over a step of 1e-3 m
    np.testing.assert_allclose(place.normal, -place.side * along_slide, rtol=0, atol=1e-12)
    assert np.linalg.norm(place.normal) == pytest.approx(1.0, rel=1e-15)


@given(SEEDS)
def test_surface_passes_through_the_tip_at_the_first_touch(seed: int) -> None:
    place = random_place(np.random.default_rng(seed))
    tip = ARM.forward_kinematics(place.joint_position)[:3]
    assert place.offset == pytest.approx(place.normal @ tip, abs=1e-15)
    np.testing.assert_allclose(place.near(np.zeros(3)), place.joint_position, rtol=0, atol=1e-15)


@given(SEEDS)
def test_joint_positions_near_the_surface_lie_at_the_asked_depth(seed: int) -> None:
    rng = np.random.default_rng(seed)
    place = random_place(rng)
    offsets = rng.uniform([-0.5, -0.1, -1.0], [0.5, 0.1, 1.0], size=(4, 5, 3))
    joints = place.near(offsets)
    depth = place.offset - ARM.forward_kinematics(joints)[..., :3] @ place.normal
    # some roundings of lengths below 1 m
    np.testing.assert_allclose(depth, offsets[..., 1], rtol=0, atol=2e-15)
    np.testing.assert_allclose(joints[..., [0, 2]], (place.joint_position + offsets)[..., [0, 2]], rtol=1e-15)


@pytest.mark.parametrize("seeds", [range(200)], ids=["200 draws"])
def test_drawn_episodes_start_off_the_surface_and_keep_to_the_joint_limits(
    environment_id: str, seeds: range
) -> None:
    task = task_of(environment_id)
    gap = task.ranges["start"]
    deepest = task.ranges["waypoints"].high[1::3]
    for seed in seeds:
        start = draw(task, seed)
        depth = depth_of(start, start.joint_position)
        # roundings of lengths below 1 m
        assert gap.low[1] - 1e-14 <= depth <= gap.high[1] + 1e-14
        assert depth <= -0.01 + 1e-14
        np.testing.assert_array_equal(start.joint_velocity, 0.0)
        targets = joint_targets(start.trajectory)
        check_joint_limits(ARM, "start", start.joint_position)
        check_joint_limits(ARM, "waypoints", targets)  # quintics stay between their waypoints
        assert (depth_of(start, targets) <= max(deepest) + 1e-14).all()


def test_drawn_references_lead_into_the_surface_where_the_task_is_to_give_way(environment_id: str) -> None:
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


def test_nothing_touches_at_the_start_of_drawn_episodes(environment_id: str) -> None:
    env = environment(environment_id)
    for seed in range(20):
        env.reset(seed=seed)
        np.testing.assert_array_equal(truth_of(env)["contact_force"], 0.0)


def report(environment_id: str, **keywords: Any) -> tuple[PRPEnv, dict[str, Array], ContactStart]:
    env = environment(environment_id, scenario="report", **keywords)
    env.reset(seed=0)
    assert isinstance(env.task, ContactTask)
    return env, truth_of(env), draw(env.task, 0)


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
    env, truth, start = report("PRP-Compliance-v0")
    np.testing.assert_allclose(truth["joint_position"], 0.0, rtol=0, atol=1e-16)  # a difference of lengths
    assert_plane(start, (0.0, -1.0, 0.0), 0.44, 50.0)
    for time in (0.0, 1.0, 5.0):
        assert_pose(reference_at(env, time)[:6], *pose_at(-0.34))
        np.testing.assert_array_equal(reference_at(env, time)[6:], 0.0)


def test_report_impedance_is_the_reports() -> None:
    env, truth, start = report("PRP-Impedance-v0")
    np.testing.assert_allclose(truth["joint_position"], 0.0, rtol=0, atol=1e-16)
    assert_plane(start, (0.0, -1.0, 0.0), 0.44, 50.0)
    assert_pose(reference_at(env, 0.0)[:6], *HOME_POSE)
    middle = reference_at(env, 0.5)
    assert_pose(middle[:6], *pose_at(-0.44))
    # 15/8 of the mean speed, 0.2 m in 1 s; a few roundings
    np.testing.assert_allclose(middle[6:12], [0.0, 0.375, 0.0, 0.0, 0.0, 0.0], rtol=0, atol=1e-15)
    for time in (1.0, 4.0):
        assert_pose(reference_at(env, time)[:6], *pose_at(-0.34))


def test_report_admittance_is_the_reports() -> None:
    env, truth, start = report("PRP-Admittance-v0")
    np.testing.assert_allclose(truth["joint_position"], 0.0, rtol=0, atol=1e-16)
    assert_plane(start, (0.0, -1.0, 0.0), 0.34, 50.0)
    for time, y in ((0.0, -0.54), (1.5, -0.29), (3.0, -0.44), (5.0, -0.44)):
        assert_pose(reference_at(env, time)[:6], *pose_at(y))
    hold, _, held = report("PRP-Admittance-v0", reference="hold")
    assert_plane(held, (0.0, -1.0, 0.0), 0.34, 50.0)
    for time, y in ((0.0, -0.54), (1.5, -0.29), (3.0, -0.29), (5.0, -0.29)):
        assert_pose(reference_at(hold, time)[:6], *pose_at(y))


def test_report_force_is_the_reports() -> None:
    env, truth, start = report("PRP-Force-v0")
    np.testing.assert_allclose(truth["joint_position"], 0.0, rtol=0, atol=1e-16)
    assert_plane(start, (0.0, -1.0, 0.0), 0.44, 5.0)
    np.testing.assert_allclose(truth["desired_force"], [0.0, 1.0, 0.0], rtol=0, atol=1e-15)
    for time in (0.0, 2.0):
        assert_pose(reference_at(env, time)[:6], *HOME_POSE)


def test_report_force_and_position_is_the_reports_feasible_variant() -> None:
    env, truth, start = report("PRP-ForcePosition-v0")
    joints = (-np.pi / 2, -0.1, -np.pi / 6)
    reach = 0.2 + 0.24 * np.cos(np.pi / 6)
    np.testing.assert_allclose(truth["joint_position"], joints, rtol=0, atol=1e-15)
    assert_plane(start, (-1.0, 0.0, 0.0), reach - 0.1, 50.0)
    assert reach - 0.1 == pytest.approx(0.3078, abs=5e-5)  # as printed
    np.testing.assert_allclose(truth["desired_force"], [0.5, 0.0, 0.0], rtol=0, atol=1e-15)
    for time in (0.0, 2.0):
        assert_pose(reference_at(env, time)[:6], -reach, -0.4, 0.03, -np.pi / 2, 2 * np.pi / 3, np.pi / 2)


def test_report_force_and_position_may_start_at_home_inside_the_surface_as_it_was_run() -> None:
    env, truth, start = report("PRP-ForcePosition-v0", start="home", surface_stiffness=1.0)
    np.testing.assert_array_equal(truth["joint_position"], 0.0)
    depth = depth_of(start, np.zeros(3))
    assert depth == pytest.approx(0.7078, abs=5e-5)
    np.testing.assert_allclose(truth["contact_force"], [depth, 0.0, 0.0], **SPURIOUS)
    assert_pose(reference_at(env, 0.0)[3:6], -np.pi / 2, 2 * np.pi / 3, np.pi / 2)


def test_keywords_of_the_surface_take_effect(environment_id: str) -> None:
    keywords = {"surface_stiffness": 200.0, "surface_damping": 3.0, **PLANE}
    options = {"joint_position": (0.0, -0.15, 0.0), "joint_velocity": (0.0, -0.1, 0.0)}
    truth = begun(environment_id, options, **keywords)
    # 0.05 m deep and going deeper at 0.1 m/s; by the tip on the surface, along +y
    expected = [0.0, 200.0 * 0.05 + 3.0 * 0.1, 0.0]
    np.testing.assert_allclose(truth["contact_force"], expected, **SPURIOUS)


def test_reset_options_of_the_surface_take_effect_and_override_keywords(environment_id: str) -> None:
    keywords = {"surface_stiffness": 200.0, "surface_damping": 3.0, **PLANE}
    options = {
        "joint_position": (0.0, -0.15, 0.0),
        "joint_velocity": (0.0, -0.1, 0.0),
        "surface_stiffness": 100.0,
        "surface_damping": 5.0,
        "surface_normal": (-1.0, 0.0, 0.0),
        "surface_offset": -0.37,
    }
    truth = begun(environment_id, options, **keywords)
    # x = 0.4 m is 0.03 m behind the plane x = 0.37; the slide moves along it
    np.testing.assert_allclose(truth["contact_force"], [3.0, 0.0, 0.0], **SPURIOUS)
    env = environment(environment_id, **keywords)
    env.reset(seed=0, options=options)
    env.reset(seed=0, options={"joint_position": (0.0, -0.15, 0.0)})
    # options are of one episode
    np.testing.assert_allclose(truth_of(env)["contact_force"], [0.0, 10.0, 0.0], **SPURIOUS)


@pytest.mark.parametrize("seed", range(6))
def test_any_plane_pushes_back_along_its_normal_with_stiffness_times_depth(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q = rng.uniform([-3.0, -0.28, -1.4], [3.0, -0.02, 1.4])
    normal, depth = rng.normal(size=3), rng.uniform(0.02, 0.1)
    unit = normal / np.linalg.norm(normal)
    options = {
        "joint_position": q,
        "surface_normal": normal,
        "surface_offset": unit @ ARM.forward_kinematics(q)[:3] + depth,
        "surface_stiffness": 300.0,
        "surface_damping": 0.0,
    }
    truth = begun("PRP-Compliance-v0", options)
    np.testing.assert_allclose(truth["contact_force"], -unit * 300.0 * depth, rtol=3e-3, atol=0.06)
    away = options | {"surface_offset": options["surface_offset"] - depth - 1e-3}
    np.testing.assert_array_equal(begun("PRP-Compliance-v0", away)["contact_force"], 0.0)


def test_static_press_feels_stiffness_times_depth(environment_id: str) -> None:
    env = environment(environment_id, surface_stiffness=400.0, surface_damping=20.0, duration=2.0, **PLANE)
    env.reset(seed=0, options={"joint_position": (0.0, -0.1, 0.0)})
    stiffness, damping = np.array([2000.0, 0.0, 20.0]), np.array([60.0, 20.0, 1.0])
    for _ in range(1000):
        q, velocity = env.physics.joint_position[0], env.physics.joint_velocity[0]
        torque = ARM.gravity_vector(q) - stiffness * q - damping * velocity - np.array([0.0, 8.0, 0.0])
        _, _, _, truncated, info = env.step(torque / env.torque_limit)
    assert truncated
    parts = truth_of(env)
    depth = ARM.forward_kinematics(parts["joint_position"])[1] + 0.44
    # at rest to 1e-7 of the force; 8 N pull the slide in, turned by what joint 1 yields, 2e-3 rad
    np.testing.assert_allclose(parts["contact_force"], [0.0, 400.0 * depth, 0.0], rtol=1e-6, atol=1e-9)
    assert parts["contact_force"][1] == pytest.approx(8.0, rel=1e-4)
    assert info["contact_force"] == pytest.approx(8.0, rel=1e-4)


def test_info_tells_the_force_and_whether_it_is_beyond_its_bound(environment_id: str) -> None:
    env = environment(environment_id)
    for stiffness, beyond in ((900.0, 0.0), (1100.0, 1.0), (0.5, 0.0)):
        env.reset(seed=0, options={**PRESSED, "surface_stiffness": stiffness, "surface_damping": 0.0})
        *_, info = env.step(np.zeros(3))
        # 0.05 m deep, out by millimetres within 2 ms at most: 45 N, 55 N and less than 1 N
        assert info["contact_force"] == pytest.approx(0.05 * stiffness, rel=0.05)
        force = np.linalg.norm(truth_of(env)["contact_force"])
        assert info["contact_force"] == pytest.approx(force, rel=1e-15)  # one root
        assert info["cost_force_bound"] == beyond
    assert env.task.numbers.constants["force_bound"] == 50.0
    units = {field.name: field.unit for field in env.info_fields}
    assert units["contact_force"] == "N"


def test_tip_off_the_surface_feels_nothing_and_costs_nothing(environment_id: str) -> None:
    env = environment(environment_id)
    env.reset(seed=0, options={**PRESSED, "surface_offset": 0.38, "surface_stiffness": 5000.0})
    *_, info = env.step(np.zeros(3))
    assert info["contact_force"] == info["cost_force_bound"] == 0.0
    np.testing.assert_array_equal(truth_of(env)["contact_force"], 0.0)


def test_drawn_surface_of_each_environment_is_its_own() -> None:
    task = task_of("PRP-Impedance-v0")
    physics = task.make_physics(0.001, 3, 1)
    starts = [draw(task, seed) for seed in range(3)]
    plants = [task.draw_plant(np.random.default_rng(0)) for _ in starts]
    inside = [start.joint_position for start in starts]
    task.place(physics, np.arange(3), starts, plants)
    # every tip 0.02 m inside its own surface along the slide, whose direction is the normal's
    for start, q in zip(starts, inside, strict=True):
        slide = start.surface.normal[0] @ (np.sin(q[0]), -np.cos(q[0]), 0.0)
        q[1] -= (0.02 - depth_of(start, q)) / slide
    physics.reset(np.arange(3), np.array(inside), np.zeros((3, 3)))
    for row, start in enumerate(starts):
        expected = -start.surface.normal[0] * start.surface.stiffness[0] * 0.02
        np.testing.assert_allclose(physics.contact_force[row], expected, rtol=3e-3, atol=5e-3)


@pytest.mark.parametrize(
    ("name", "value", "kind", "message"),
    [
        ("surface_stiffness", 0.0, InvalidValueError, r"surface stiffness is 0.0 N/m; allowed: above 0 and"),
        ("surface_stiffness", -5.0, InvalidValueError, r"surface stiffness is -5.0 N/m; allowed: above 0"),
        ("surface_stiffness", NAN, InvalidValueError, r"surface stiffness is nan N/m"),
        ("surface_stiffness", INFINITY, InvalidValueError, r"surface stiffness is inf N/m"),
        ("surface_stiffness", "stiff", InvalidValueError, r"surface_stiffness is 'stiff' N/m; allowed: a num"),
        ("surface_stiffness", (1.0, 2.0), ShapeError, r"surface_stiffness has shape \(2,\); expected \(\)"),
        ("surface_damping", -0.1, InvalidValueError, r"surface damping is -0.1 N·s/m; allowed: at least 0"),
        ("surface_damping", INFINITY, InvalidValueError, r"surface damping is inf N·s/m"),
        ("surface_normal", (0, 0, 0), InvalidValueError, r"surface normal is \[0.0, 0.0, 0.0\]; allowed: a v"),
        ("surface_normal", (0, NAN, 1), InvalidValueError, r"surface normal is \[0.0, nan, 1.0\]"),
        ("surface_normal", (0, 1), ShapeError, r"surface_normal has shape \(2,\); expected \(3,\)"),
        ("surface_offset", NAN, InvalidValueError, r"surface offset is nan m; allowed: a finite number"),
        ("surface_offset", (0.1,), ShapeError, r"surface_offset has shape \(1,\); expected \(\)"),
    ],
)
def test_impossible_surface_is_refused_as_keyword(
    environment_id: str, name: str, value: Any, kind: type[PRPError], message: str
) -> None:
    with pytest.raises(kind, match=message):
        gymnasium.make(environment_id, **{name: value})


@pytest.mark.parametrize(
    ("name", "value", "kind", "message"),
    [
        ("surface_stiffness", 0.0, InvalidValueError, r"surface stiffness is 0.0 N/m; allowed: above 0 and"),
        ("surface_stiffness", NAN, NonFiniteError, "reset option 'surface_stiffness' is nan"),
        ("surface_stiffness", "stiff", InvalidValueError, "reset option 'surface_stiffness' is 'stiff'"),
        ("surface_stiffness", (1.0, 2.0), ShapeError, r"reset option 'surface_stiffness' has shape \(2,\)"),
        ("surface_damping", -0.1, InvalidValueError, r"surface damping is -0.1 N·s/m; allowed: at least 0"),
        ("surface_normal", (0, 0, 0), InvalidValueError, "surface normal is .*a vector of positive length"),
        ("surface_normal", (0, 1), ShapeError, r"reset option 'surface_normal' has shape \(2,\)"),
        ("surface_offset", INFINITY, NonFiniteError, "reset option 'surface_offset' is inf"),
        ("goal", (0.0, 0.1, 0.0), JointLimitError, "goal: joint 2 is 0.1 m; allowed: -0.3 to 0 m"),
        ("joint_position", (0.0, -0.4, 0.0), JointLimitError, "initial joint position: joint 2 is -0.4 m"),
        ("joint_velocity", (0.0, 101.0, 0.0), InvalidValueError, "initial joint velocity"),
    ],
)
def test_impossible_reset_option_is_refused_and_the_episode_goes_on(
    environment_id: str, name: str, value: Any, kind: type[PRPError], message: str
) -> None:
    env, twin = (environment(environment_id, scenario="realistic") for _ in range(2))
    options = {**PRESSED, "surface_stiffness": 100.0}
    for either in (env, twin):
        either.reset(seed=0, options=options)
        either.step(np.zeros(3))
    with pytest.raises(kind, match=message):
        env.reset(options={name: value})
    for _ in range(5):
        np.testing.assert_array_equal(env.step(np.zeros(3))[0], twin.step(np.zeros(3))[0])
        np.testing.assert_array_equal(env.truth, twin.truth)


def test_options_do_not_change_what_else_is_drawn(environment_id: str) -> None:
    task, states = task_of(environment_id), []
    for options in ({}, PRESSED, {"goal": (0.0, -0.2, 0.0)}, {"surface_stiffness": 3.0}):
        rng = np.random.default_rng(5)
        task.draw(rng, {name: np.array(value) for name, value in options.items()})
        states.append(rng.bit_generator.state)
    assert states == states[:1] * 4


@pytest.mark.parametrize("environment_id", [name for name in CONTACT_IDS if name != "PRP-Force-v0"])
def test_goal_replaces_the_end_of_the_reference(environment_id: str) -> None:
    task, goal = task_of(environment_id), (0.5, -0.12, -0.3)
    start = draw(task, 3, goal=goal)
    np.testing.assert_array_equal(joint_targets(start.trajectory)[-1], goal)
    np.testing.assert_array_equal(start.joint_position, draw(task, 3).joint_position)


def test_initial_joint_state_is_the_one_asked_for(environment_id: str) -> None:
    position, velocity = (0.3, -0.2, 0.1), (0.1, -0.2, 0.3)
    truth = begun(environment_id, {"joint_position": position, "joint_velocity": velocity})
    np.testing.assert_array_equal(truth["joint_position"], position)
    np.testing.assert_array_equal(truth["joint_velocity"], velocity)
