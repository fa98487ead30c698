"""Reference trajectories: rates are derivatives, waypoints are rests, many at once equal one by one."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array
from prp_gym.tasks import Constant, QuinticWaypoints, Sine, SquareAcceleration, Trajectory

SEEDS = st.integers(0, 2**32 - 1)
SHORTEST = 0.3  # of the random segments [s]
STEP = 1e-5  # of finite differences [s]
# A move of 6 over the shortest segment has a third derivative of at most 60*6/0.3^3 = 1.3e4 and a fourth
# of at most 360*6/0.3^4 = 2.7e5; central differences err by STEP^2/6 of them: 2e-7 and 5e-6.
VELOCITY_TOLERANCE, ACCELERATION_TOLERANCE = 1e-6, 1e-5


def quintics(rng: np.random.Generator, count: int = 3, waypoints: int = 4) -> QuinticWaypoints:
    times = np.cumsum(rng.uniform(SHORTEST, 1.0, size=(count, waypoints)), axis=1)
    return QuinticWaypoints(times, rng.uniform(-3.0, 3.0, size=(count, waypoints, 3)))


def sines(rng: np.random.Generator, count: int = 3) -> Sine:
    center, phase = rng.uniform(-3.0, 3.0, size=(2, count, 3))
    return Sine(
        center,
        rng.uniform(0.1, 1.0, size=(count, 3)),
        rng.uniform(1.0, 7.0, size=(count, 3)),
        phase,
    )


def constants(rng: np.random.Generator, count: int = 3) -> Constant:
    return Constant(rng.uniform(-3.0, 3.0, size=(count, 3)))


def squares(rng: np.random.Generator, count: int = 3) -> SquareAcceleration:
    start = rng.uniform(-3.0, 3.0, size=(count, 3))
    return SquareAcceleration(
        start, rng.uniform(0.5, 2.0, size=(count, 3)), rng.uniform(1.0, 7.0, size=(count, 3))
    )


KINDS: dict[str, Callable[[np.random.Generator, int], Trajectory]] = {
    "square": squares,
    "quintic": quintics,
    "sine": sines,
    "constant": constants,
}


@pytest.fixture(params=list(KINDS))
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def assert_rates_are_derivatives(trajectory: Trajectory, time: Array) -> None:
    before, now, after = (trajectory.sample(time + shift) for shift in (-STEP, 0.0, STEP))
    slope = (after - before) / (2 * STEP)
    np.testing.assert_allclose(now[..., 3:6], slope[..., 0:3], rtol=0, atol=VELOCITY_TOLERANCE)
    np.testing.assert_allclose(now[..., 6:9], slope[..., 3:6], rtol=0, atol=ACCELERATION_TOLERANCE)


@given(SEEDS)
def test_quintics_rates_are_derivatives_within_segments(seed: int) -> None:
    rng = np.random.default_rng(seed)
    trajectory = quintics(rng)
    # away from the waypoints, where the third derivative jumps and differences err by more
    share = rng.uniform(0.01, 0.99, size=(5, 3))
    for segment in range(3):
        begin, end = trajectory.times[:, segment], trajectory.times[:, segment + 1]
        assert_rates_are_derivatives(trajectory, begin + share * (end - begin))


@given(SEEDS)
def test_sines_rates_are_derivatives(seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert_rates_are_derivatives(sines(rng), rng.uniform(0.0, 5.0, size=(5, 3)))


@given(SEEDS)
def test_quintic_rests_exactly_at_every_waypoint(seed: int) -> None:
    trajectory = quintics(np.random.default_rng(seed))
    for waypoint in range(4):
        values = trajectory.sample(trajectory.times[:, waypoint])
        # the last waypoint is start + (stop - start): one rounding of numbers below 6
        np.testing.assert_allclose(values[:, :3], trajectory.positions[:, waypoint], rtol=0, atol=1e-15)
        np.testing.assert_array_equal(values[:, 3:], 0.0)


@given(SEEDS)
def test_quintic_is_continuous_up_to_the_acceleration(seed: int) -> None:
    trajectory = quintics(np.random.default_rng(seed))
    nearly = 1e-9
    for waypoint in range(4):
        left = trajectory.sample(trajectory.times[:, waypoint] - nearly)
        right = trajectory.sample(trajectory.times[:, waypoint] + nearly)
        # within 2e-9 s the acceleration changes by the third derivative of at most 1.3e4 times that: 3e-5
        np.testing.assert_allclose(left, right, rtol=0, atol=1e-4)


@given(SEEDS, st.floats(0.0, 100.0))
def test_quintic_holds_its_ends_before_and_after(seed: int, away: float) -> None:
    trajectory = quintics(np.random.default_rng(seed))
    before = trajectory.sample(trajectory.times[:, 0] - away)
    after = trajectory.sample(trajectory.times[:, -1] + away)
    np.testing.assert_array_equal(before[:, :3], trajectory.positions[:, 0])
    np.testing.assert_array_equal(before[:, 3:], 0.0)
    # start + (stop - start): one rounding of numbers below 6
    np.testing.assert_allclose(after[:, :3], trajectory.positions[:, -1], rtol=0, atol=1e-15)
    np.testing.assert_array_equal(after[:, 3:], 0.0)


@given(SEEDS)
def test_quintic_stays_between_neighbouring_waypoints(seed: int) -> None:
    rng = np.random.default_rng(seed)
    trajectory = quintics(rng)
    for segment in range(3):
        begin, end = trajectory.times[:, segment], trajectory.times[:, segment + 1]
        values = trajectory.sample(begin + rng.uniform(size=(20, 3)) * (end - begin))[..., :3]
        ends = trajectory.positions[:, segment : segment + 2]
        # rounding of numbers below 6
        assert (values >= ends.min(axis=1) - 1e-14).all()
        assert (values <= ends.max(axis=1) + 1e-14).all()


def test_quintic_passes_half_way_with_the_known_top_speed() -> None:
    trajectory = QuinticWaypoints(np.array([[1.0, 3.0]]), np.array([[[0.0, 0.0, 0.0], [1.0, -0.2, 4.0]]]))
    position, velocity, acceleration = np.split(trajectory.sample(np.array([2.0]))[0], 3)
    np.testing.assert_array_equal(position, [0.5, -0.1, 2.0])
    # 15/8 of the mean speed; powers of two and 15 are exact, 0.2 is not
    np.testing.assert_allclose(velocity, 15 / 16 * np.array([1.0, -0.2, 4.0]), rtol=1e-15)
    np.testing.assert_array_equal(acceleration, 0.0)


def test_sine_is_the_formula() -> None:
    center, amplitude = np.array([[1.0, -0.2, 3.0]]), np.array([[0.1, 0.05, 0.3]])
    rate, phase = np.array([[2.0, 3.0, 4.0]]), np.array([[0.0, 0.5, -0.5]])
    values = Sine(center, amplitude, rate, phase).sample(np.array([0.7]))[0]
    angle = rate[0] * 0.7 + phase[0]
    # the same operations on numbers below 5: a rounding or two
    np.testing.assert_allclose(values[:3], center[0] + amplitude[0] * np.sin(angle), rtol=0, atol=1e-15)
    np.testing.assert_allclose(values[3:6], amplitude[0] * rate[0] * np.cos(angle), rtol=0, atol=1e-15)
    np.testing.assert_allclose(values[6:], -amplitude[0] * rate[0] ** 2 * np.sin(angle), rtol=0, atol=4e-15)


@given(SEEDS)
def test_acceleration_of_the_square_wave_has_its_magnitude_and_the_sign_of_a_cosine(seed: int) -> None:
    rng = np.random.default_rng(seed)
    trajectory, time = squares(rng), rng.uniform(0.0, 9.0, size=(20, 3))
    acceleration = trajectory.sample(time)[..., 6:]
    cosine = np.cos(trajectory.angular_frequency * time[..., None])
    clear = np.abs(cosine) > 1e-9  # where rounding does not decide the sign
    expected = np.sign(cosine) * trajectory.magnitude
    np.testing.assert_array_equal(acceleration[clear], expected[clear])


@given(SEEDS)
def test_square_wave_integrated_by_hand_is_its_velocity_and_position(seed: int) -> None:
    trajectory = squares(np.random.default_rng(seed), 1)
    step = 1e-4
    time: Array = step * np.arange(30_001, dtype=np.float64)
    values = trajectory.sample(time[:, None])[:, 0]
    middle = trajectory.sample((time[:-1] + step / 2)[:, None])[:, 0]
    velocity = np.cumsum(np.vstack([np.zeros(3), middle[:, 6:] * step]), axis=0)
    # each of at most 3 · 7 · 2/(2π) + 1 = 8 jumps by at most 4 falls anywhere in its step: 2e-4 each
    np.testing.assert_allclose(values[:, 3:6], velocity, rtol=0, atol=2e-3)
    position = trajectory.start[0] + np.cumsum(np.vstack([np.zeros(3), middle[:, 3:6] * step]), axis=0)
    # midpoints are exact but for steps with a jump: 8 times 4 · (1e-4)²
    np.testing.assert_allclose(values[:, :3], position, rtol=0, atol=1e-6)


@given(SEEDS)
def test_square_wave_is_continuous_up_to_the_velocity_and_periodic(seed: int) -> None:
    trajectory = squares(np.random.default_rng(seed))
    for column in range(3):
        quarter = np.pi / 2 / trajectory.angular_frequency[:, column]
        for count in range(1, 9):
            left, right = (trajectory.sample(count * quarter + shift) for shift in (-1e-9, 1e-9))
            # 2e-9 s at speeds up to 2 · π/2 and accelerations up to 2
            np.testing.assert_allclose(left[:, :6], right[:, :6], rtol=0, atol=1e-8)
        again = trajectory.sample(4 * quarter)[:, [column, 3 + column]]
        # a whole period: back at the start, at rest
        np.testing.assert_allclose(again[:, 0], trajectory.start[:, column], rtol=0, atol=1e-12)
        np.testing.assert_allclose(again[:, 1], 0.0, rtol=0, atol=1e-12)


def test_square_wave_moves_about_its_goal() -> None:
    trajectory = squares(np.random.default_rng(8), 1)
    positions = trajectory.sample(np.linspace(0.0, 20.0, 200_001)[:, None])[:, 0, :3]
    # between the ends of the motion; a sample every 0.1 ms misses an end by at most 2 · (0.05 ms)²/2
    middle = (positions.min(axis=0) + positions.max(axis=0)) / 2
    np.testing.assert_allclose(trajectory.goal[0], middle, rtol=0, atol=1e-8)


def test_motions_of_any_number_of_components_are_those_of_each() -> None:
    rng = np.random.default_rng(9)
    times = np.cumsum(rng.uniform(SHORTEST, 1.0, size=(2, 4)), axis=1)
    positions, moments = rng.uniform(-3.0, 3.0, size=(2, 4, 6)), rng.uniform(0.0, 4.0, size=(7, 2))
    together = QuinticWaypoints(times, positions).sample(moments)
    assert together.shape == (7, 2, 18)
    for component in range(6):
        alone = QuinticWaypoints(times, positions[..., [component]]).sample(moments)
        np.testing.assert_array_equal(together[..., component::6], alone)
    pose = Constant(positions[:, 0]).sample(moments)
    np.testing.assert_array_equal(pose[..., :6], np.broadcast_to(positions[:, 0], (7, 2, 6)))
    np.testing.assert_array_equal(pose[..., 6:], np.zeros((7, 2, 12)))


@given(SEEDS)
def test_quintics_of_six_components_have_rates_that_are_derivatives(seed: int) -> None:
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(SHORTEST, 1.0, size=(2, 3)), axis=1)
    trajectory = QuinticWaypoints(times, rng.uniform(-3.0, 3.0, size=(2, 3, 6)))
    time = times[:, 0] + rng.uniform(0.01, 0.99, size=2) * (times[:, 1] - times[:, 0])
    before, now, after = (trajectory.sample(time + shift) for shift in (-STEP, 0.0, STEP))
    slope = (after - before) / (2 * STEP)
    np.testing.assert_allclose(now[:, 6:12], slope[:, :6], rtol=0, atol=VELOCITY_TOLERANCE)
    np.testing.assert_allclose(now[:, 12:], slope[:, 6:12], rtol=0, atol=ACCELERATION_TOLERANCE)


def test_constant_never_moves() -> None:
    trajectory = constants(np.random.default_rng(0))
    values = trajectory.sample(np.random.default_rng(1).uniform(0.0, 1e3, size=(7, 3)))
    np.testing.assert_array_equal(values[..., :3], np.broadcast_to(trajectory.position, (7, 3, 3)))
    np.testing.assert_array_equal(values[..., 3:], 0.0)


def test_many_trajectories_at_many_times_equal_one_at_one_time(kind: str) -> None:
    rng = np.random.default_rng(2)
    trajectory = KINDS[kind](rng, 4)
    time = rng.uniform(-0.5, 5.0, size=(6, 4))
    values = trajectory.sample(time)
    assert values.shape == (6, 4, 9)
    for row in range(4):
        single = trajectory.rows(np.array([row]))
        for moment in range(6):
            np.testing.assert_array_equal(single.sample(time[moment, row : row + 1])[0], values[moment, row])


def test_rows_and_assign_move_whole_trajectories(kind: str) -> None:
    rng = np.random.default_rng(3)
    trajectory, other = KINDS[kind](rng, 4), KINDS[kind](rng, 2)
    time = rng.uniform(0.0, 4.0, size=(5, 4))
    taken = trajectory.rows(np.array([2, 0, 1, 3]))
    np.testing.assert_array_equal(
        taken.sample(time), trajectory.sample(time[:, [1, 2, 0, 3]])[:, [2, 0, 1, 3]]
    )
    ids = np.array([3, 1])
    taken.assign(ids, other)
    np.testing.assert_array_equal(taken.sample(time)[:, ids], other.sample(time[:, ids]))
    for row, source in ((0, 2), (2, 1)):
        alone = trajectory.rows(np.array([source]))
        np.testing.assert_array_equal(taken.sample(time)[:, [row]], alone.sample(time[:, [row]]))
    np.testing.assert_array_equal(taken.goal[ids], other.goal)


def test_rows_are_copies() -> None:
    trajectory = Constant(np.array([[1.0, 2.0, 3.0]]))
    taken = trajectory.rows(np.array([0]))
    taken.assign(np.array([0]), Constant(np.zeros((1, 3))))
    np.testing.assert_array_equal(trajectory.position, [[1.0, 2.0, 3.0]])


def test_goal_is_position_centre_or_last_waypoint() -> None:
    rng = np.random.default_rng(4)
    constant, sine, quintic = constants(rng), sines(rng), quintics(rng)
    np.testing.assert_array_equal(constant.goal, constant.position)
    np.testing.assert_array_equal(sine.goal, sine.center)
    np.testing.assert_array_equal(quintic.goal, quintic.positions[:, -1])


def test_constant_references_are_recognised() -> None:
    rng = np.random.default_rng(5)
    moving = (sines(rng), quintics(rng), squares(rng))
    assert not any(trajectory.is_constant for trajectory in moving)
    still_sine = sines(rng)
    still_sine.amplitude[:] = 0.0
    still_square = squares(rng)
    still_square.magnitude[:] = 0.0
    same_waypoint = quintics(rng)
    same_waypoint.positions[:] = same_waypoint.positions[:, :1]
    assert all(
        trajectory.is_constant for trajectory in (constants(rng), still_sine, still_square, same_waypoint)
    )


@pytest.mark.parametrize(
    ("times", "positions"),
    [((1, 1), (1, 1, 3)), ((1, 3), (1, 2, 3)), ((1, 2), (1, 2)), ((2, 2), (1, 2, 3))],
)
def test_quintic_refuses_waypoints_of_the_wrong_shape(
    times: tuple[int, int], positions: tuple[int, ...]
) -> None:
    increasing = np.cumsum(np.ones(times), axis=-1)
    with pytest.raises(InvalidValueError, match="waypoints' shape") as caught:
        QuinticWaypoints(increasing, np.zeros(positions))
    assert caught.value.value == positions


@pytest.mark.parametrize("last", [0.5, 1.0, 1.0 + 1e-12])
def test_quintic_refuses_times_that_do_not_increase(last: float) -> None:
    with pytest.raises(InvalidValueError, match="strictly increasing") as caught:
        QuinticWaypoints(np.array([[0.0, 1.0, last]]), np.zeros((1, 3, 3)))
    assert caught.value.unit == "s"
