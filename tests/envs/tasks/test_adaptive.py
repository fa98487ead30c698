"""The one-link task: its plant is the drawn or requested one, and its references have the declared shapes."""

from typing import Any

import gymnasium
import mujoco
import numpy as np
import pytest

from prp_gym.envs import EpisodeLoop, PRPEnv
from prp_gym.envs.tasks.adaptive import LinkStart, LinkWorld
from prp_gym.errors import EpisodeError, ShapeError
from prp_gym.robot.arrays import Array
from prp_gym.tasks import SCENARIOS
from prp_gym.tasks.fields import LINK_POSITION_BOUND
from tests.support.drawn_starts import drawn_start

ID = "PRP-Adaptive-v0"
PLANTS = [(0.5, 0.15, 1.85), (0.25, 0.0, 4.0), (1.0, 0.5, 0.0), (2.0, 3.0, 0.5)]  # I, F, G
STATES = [(0.3, 0.0), (1.2, -2.0), (-2.5, 4.0)]  # rad, rad/s
SUBSTEP = 0.001  # of the physics [s]
NAN, INFINITY = float("nan"), float("inf")


def environment(**keywords: Any) -> PRPEnv:
    env = gymnasium.make(ID, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


def plant_options(plant: tuple[float, float, float]) -> dict[str, float]:
    return dict(zip(("inertia", "viscous_friction", "gravity_moment"), plant, strict=True))


def draw_from(task: Any, seed: int) -> LinkStart:
    assert isinstance(task.parts.world, LinkWorld)
    start = drawn_start(task, seed, {})
    assert isinstance(start, LinkStart)
    return start


def draw(seed: int, options: dict[str, Any] | None = None, **keywords: Any) -> LinkStart:
    task = environment(**keywords).task
    start = drawn_start(task, seed, options or {})
    assert isinstance(start, LinkStart)
    return start


def acceleration(env: PRPEnv, state: tuple[float, float], torque: float, **options: Any) -> float:
    """Mean over one millisecond from a given state [rad/s²]."""
    position, velocity = state
    env.reset(seed=0, options={"joint_position": [position], "joint_velocity": [velocity], **options})
    observation, *_ = env.step(np.array([torque / env.torque_limit[0]]))
    return float(observation[1] - velocity) / SUBSTEP


def expected_acceleration(plant: tuple[float, float, float], state: tuple[float, float], tau: float) -> float:
    inertia, friction, gravity = plant
    return (tau - friction * state[1] - gravity * float(np.sin(state[0]))) / inertia


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("how", ["keywords", "options"])
def test_requested_plant_is_the_one_that_is_simulated(
    how: str, plant: tuple[float, float, float], state: tuple[float, float]
) -> None:
    given = plant_options(plant)
    env = environment(control_frequency=1000, **(given if how == "keywords" else {}))
    for torque in (0.0, 6.0):
        found = acceleration(env, state, torque, **({} if how == "keywords" else given))
        # friction is taken at the end of the millisecond: its share F/I of the acceleration changes by that
        tolerance = 2 * SUBSTEP * plant[1] / plant[0] + 1e-9
        assert found == pytest.approx(expected_acceleration(plant, state, torque), rel=tolerance, abs=1e-9)


@pytest.mark.parametrize("plant", PLANTS)
def test_steps_are_those_of_a_pendulum_of_mujocos_own(plant: tuple[float, float, float]) -> None:
    inertia, friction, gravity = plant
    mass, length = 3.0, gravity / (3.0 * 9.81)
    rest = inertia - mass * length**2
    assert rest > 0.0
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{SUBSTEP}" gravity="0 0 -9.81"/><worldbody><body>
        <joint name="j" type="hinge" axis="0 -1 0" damping="{friction}"/>
        <inertial mass="{mass}" pos="0 0 {-length!r}" diaginertia="{rest!r} {rest!r} {rest!r}"/>
        </body></worldbody><actuator><motor joint="j"/></actuator></mujoco>"""
    )
    data = mujoco.MjData(model)
    env = environment(control_frequency=500, scenario="randomized")
    env.reset(seed=0, options={"joint_position": [0.7], "joint_velocity": [-1.0], **plant_options(plant)})
    data.qpos[0], data.qvel[0] = 0.7, -1.0
    for action in np.random.default_rng(0).uniform(-1.0, 1.0, 50):
        observation, *_ = env.step(np.array([action]))
        data.ctrl[0] = action * 30.0
        mujoco.mj_step(model, data, 2)
        # the same equation of motion with the same integrator, from other masses: roundings
        np.testing.assert_allclose(observation[:2], [data.qpos[0], data.qvel[0]], rtol=0, atol=1e-10)


def test_reset_options_override_keywords_which_override_draws() -> None:
    start = draw(3, {"inertia": 0.7}, inertia=0.9, gravity_moment=1.5)
    np.testing.assert_array_equal(start.plant[::2], (0.7, 1.5))
    assert start.plant.viscous_friction == draw(3).plant.viscous_friction


def test_report_is_the_reports() -> None:
    env = environment(scenario="report")
    for seed in (0, 1):
        observation, _ = env.reset(seed=seed)
        np.testing.assert_allclose(observation, [0.0, 0.0, 0.0, 2 * np.pi, 0.0], rtol=0, atol=1e-15)
        plant = draw(seed, scenario="report").plant
        np.testing.assert_array_equal(plant, (0.5, 0.15, 1.85))
    rate = 2 * np.pi
    for time in np.linspace(0.0, 5.0, 37):
        q, velocity, second = env.task.reference(np.array([time]))[0]
        # roundings of angles up to 31, amplified by the rate's square 39
        assert q == pytest.approx(np.sin(rate * time), abs=1e-14)
        assert velocity == pytest.approx(rate * np.cos(rate * time), abs=1e-13)
        assert second == pytest.approx(-(rate**2) * np.sin(rate * time), abs=1e-12)


def test_reports_square_wave_has_unit_acceleration_and_unit_angular_frequency() -> None:
    env = environment(scenario="report", reference="square")
    env.reset(seed=0)
    for quarter, sign in enumerate((1.0, -1.0, -1.0, 1.0, 1.0)):
        for share in (0.1, 0.5, 0.9):
            q, velocity, second = env.task.reference(np.array([(quarter + share) * np.pi / 2]))[0]
            assert second == sign
            # by hand: from rest with ±1 rad/s², the speed a triangle of height π/2
            height = np.pi / 2
            ramp = {0: share, 1: 1 - share, 2: -share, 3: share - 1, 4: share}[quarter]
            assert velocity == pytest.approx(ramp * height, abs=1e-14)  # roundings
            area = {
                0: share**2 / 2,
                1: 1 - (1 - share) ** 2 / 2,
                2: 1 - share**2 / 2,
                3: (1 - share) ** 2 / 2,
                4: share**2 / 2,
            }[quarter]
            assert q == pytest.approx(area * height**2, abs=1e-14)


@pytest.mark.parametrize("reference", ["sine", "square"])
def test_reference_frequency_is_kept_or_drawn(reference: str) -> None:
    env = environment(reference=reference, reference_frequency=0.4)
    for seed in (0, 1):
        env.reset(seed=seed)
        now, later, half = (env.task.reference(np.array([t]))[0] for t in (0.3, 0.3 + 2.5, 0.3 + 1.25))
        np.testing.assert_allclose(later, now, rtol=0, atol=1e-13)  # a period of 2.5 s; roundings
        assert abs(half[2] - now[2]) > 0.1
    drawn = {
        tuple(draw(seed, reference=reference).trajectory.sample(np.full(1, 4.0))[0]) for seed in range(5)
    }
    assert len(drawn) == 5


@pytest.mark.parametrize("reference", ["sine", "square"])
def test_rates_of_the_reference_are_derivatives(reference: str) -> None:
    env, step = environment(reference=reference), 1e-5
    env.reset(seed=1)
    for time in np.random.default_rng(0).uniform(0.0, 5.0, 100):
        before, now, after = (env.task.reference(np.array([time + shift]))[0] for shift in (-step, 0.0, step))
        if before[2] * after[2] < 0.0 and reference == "square":
            continue  # where the acceleration jumps
        # rounding of 1e-16/1e-5, and 1e-10/6 of the third and fourth derivatives of at most 5³ and 5⁴
        np.testing.assert_allclose(now[1:], (after - before)[:2] / (2 * step), rtol=0, atol=1e-7)


def test_sine_starts_through_zero_with_a_drawn_amplitude() -> None:
    task = environment().task
    for seed in range(20):
        start = draw_from(task, seed)
        values = start.trajectory.sample(np.zeros(1))[0]
        assert values[0] == values[2] == 0.0
        peak = np.abs(start.trajectory.sample(np.linspace(0.0, 5.0, 2000)[:, None])[:, 0, 0]).max()
        assert 0.499 < peak <= 1.0  # a sample every 2.5 ms of a sine below 0.8 Hz


def test_draws_keep_to_their_ranges_and_fill_them() -> None:
    plants, task = [], environment().task
    for seed in range(300):
        start = draw_from(task, seed)
        plants.append(start.plant._asdict() | {"position": start.joint_position[0]})
        np.testing.assert_array_equal(start.joint_velocity, [0.0])
    for name, low, high in (
        ("inertia", 0.25, 1.0),
        ("viscous_friction", 0.0, 0.5),
        ("gravity_moment", 0.5, 4.0),
        ("position", -0.5, 0.5),
    ):
        values = np.array([plant[name] for plant in plants])
        assert values.min() >= low
        assert values.max() <= high
        # the chance that the extreme of 300 misses an end by 5 % of the range is 0.95^300 = 2e-7
        assert np.ptp(values) > 0.9 * (high - low)


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_drawn_plant_is_the_one_that_is_simulated(scenario: str) -> None:
    env = environment(scenario=scenario, control_frequency=1000)
    loop = EpisodeLoop(env.task, env.config, 3)
    seeds = [4, 5, 6]
    loop.reset(np.arange(3), [np.random.default_rng(seed) for seed in seeds], {})
    loop.reset(np.array([1]), [np.random.default_rng(9)], {})
    starts = [draw_from(env.task, seed) for seed in (4, 9, 6)]
    velocity = np.array([[0.5], [-1.0], [2.0]])
    position = np.array([[1.0], [1.5], [0.5]])
    loop.physics.reset(np.arange(3), position, velocity)
    loop.physics.set_torque(np.zeros((3, 1)))
    loop.physics.advance(1)
    for row, start in enumerate(starts):
        state = (float(position[row, 0]), float(velocity[row, 0]))
        found = (loop.physics.joint_velocity[row, 0] - state[1]) / SUBSTEP
        inertia, friction, gravity = map(float, start.plant)
        # friction at the millisecond's end: at most F/I = 2 per second of the acceleration
        assert found == pytest.approx(
            expected_acceleration((inertia, friction, gravity), state, 0.0), rel=5e-3
        )


def test_plant_is_not_observed() -> None:
    first = environment().reset(seed=0, options=plant_options(PLANTS[0]))[0]
    other = environment().reset(seed=0, options=plant_options(PLANTS[1]))[0]
    np.testing.assert_array_equal(first, other)
    env = environment()
    assert env.observation_layout.names == (
        "joint_position",
        "joint_velocity",
        "desired_joint_position",
        "desired_joint_velocity",
        "desired_joint_acceleration",
    )
    assert env.observation_layout.size == 5


def test_seed_decides_plant_and_reference() -> None:
    one, again, other = (draw(seed) for seed in (1, 1, 2))
    assert one.plant == again.plant != other.plant
    time = np.linspace(0.0, 5.0, 20)[:, None]
    np.testing.assert_array_equal(one.trajectory.sample(time), again.trajectory.sample(time))
    assert (one.trajectory.sample(time)[1:, 0, 0] != other.trajectory.sample(time)[1:, 0, 0]).all()


def test_action_is_one_torque_normalised_by_its_limit() -> None:
    env = environment()
    assert env.action_space.shape == (1,)
    np.testing.assert_array_equal(env.torque_limit, [30.0])
    env.reset(seed=0)
    *_, info = env.step(np.array([0.5]))
    np.testing.assert_array_equal(env.applied_torque, [15.0])
    assert info["cost_saturation"] == info["cost_joint_stop"] == 0.0
    *_, info = env.step(np.array([-3.0]))
    np.testing.assert_array_equal(env.commanded_torque, [-30.0])
    assert info["cost_saturation"] == 1.0
    for wrong in ((0.0, 0.0, 0.0), 0.0, ((0.0,),)):
        with pytest.raises(ShapeError, match=r"expected \(1,\)"):
            env.step(np.array(wrong))


def test_torque_has_delay_and_noise_in_the_realistic_scenario() -> None:
    env = environment(scenario="realistic")
    env.reset(seed=0)
    env.step(np.array([1.0]))
    first = env.applied_torque
    env.step(np.array([0.0]))
    # white noise of 0.005 · 30 N m: six deviations
    assert first[0] == pytest.approx(0.0, abs=0.9)
    assert env.applied_torque[0] == pytest.approx(30.0, abs=0.9)
    assert first[0] != 0.0


def test_reward_is_the_declared_kernel_of_tracking_and_effort() -> None:
    env = environment()
    env.reset(seed=0)
    for action in np.random.default_rng(0).uniform(-1.0, 1.0, 30):
        observation, reward, _, _, info = env.step(np.array([action]))
        tracking = 0.95 / (1.0 + abs(observation[2] - observation[0]) / 0.05)
        effort = 0.05 / (1.0 + abs(action))
        assert info["reward_tracking"] == pytest.approx(tracking, rel=1e-12)  # some roundings
        assert info["reward_effort"] == pytest.approx(effort, rel=1e-12)
        assert reward == pytest.approx(tracking + effort, rel=1e-12)


def test_link_beyond_its_bounds_ends_the_episode() -> None:
    env = environment()
    env.reset(seed=0, options={"joint_velocity": [500.0], "joint_position": [LINK_POSITION_BOUND - 0.1]})
    _, reward, terminated, truncated, _ = env.step(np.zeros(1))
    assert (reward, terminated, truncated) == (0.0, True, False)
    with pytest.raises(EpisodeError, match="diverged"):
        env.step(np.zeros(1))


def test_many_plants_at_once_are_those_of_one_by_one() -> None:
    env = environment(scenario="realistic")
    together = EpisodeLoop(env.task, env.config, 4)
    together.reset(np.arange(4), [np.random.default_rng(seed) for seed in range(4)], {})
    actions: Array = np.random.default_rng(0).uniform(-1.0, 1.0, size=(60, 4, 1))
    found = [together.step(action).observation for action in actions]
    for row in range(4):
        single = environment(scenario="realistic")
        alone = EpisodeLoop(single.task, single.config, 1)
        alone.reset(np.arange(1), [np.random.default_rng(row)], {})
        expected = [alone.step(action[[row]]).observation[0] for action in actions]
        np.testing.assert_array_equal(np.array(found)[:, row], expected)
