"""An environment among many gives the same results as alone, for any N and threads; and its seeds."""

from typing import Any

import numpy as np
import pytest

from prp_gym.envs.vector_keywords import parse_threads
from prp_gym.errors import InvalidValueError, ShapeError
from tests.support.vector_episodes import (
    IDS,
    assert_history,
    assert_same,
    history_of,
    one_by_one,
    run_alone,
    run_together,
    single,
    together,
)

MANY = 130  # the physics stores more than 128 simulations in another way
STEPS = 10  # more than two episodes
BRIEF = {"duration": 0.04, "control_frequency": 100}  # [s], [Hz]: four steps
AGAIN = 2
ALONE = (0, 1, 6, 69, 129)


def some_actions(env: Any, count: int = STEPS) -> Any:
    """Actions (steps, MANY, joints), some beyond the limits."""
    shape = (count, MANY, *env.single_action_space.shape)
    return np.random.default_rng(5).uniform(-1.2, 1.2, shape).astype(np.float32)


@pytest.mark.parametrize("environment_id", IDS)
def test_environment_gives_the_same_bits_among_any_number(environment_id: str) -> None:
    keywords: dict[str, Any] = {"scenario": "realistic", **BRIEF}  # which draws all that the others do
    env = together(environment_id, "SameStep", MANY, **keywords)
    actions = some_actions(env)
    history = run_together(env, 7, actions, AGAIN)
    ends = np.array([[outcome[3] for outcome in step] for step in history])
    assert (ends.sum(axis=0) >= 2).all()
    assert not (ends[:, 0] == ends[:, 1]).all()  # at different steps
    for count in (1, 2, 7, 70):
        fewer = run_together(
            together(environment_id, "SameStep", count, **keywords), 7, actions[:, :count], AGAIN
        )
        for index in range(count):
            where = f"{index} of {count}"
            assert_history(history_of(fewer, index), history_of(history, index), where)
    for index in ALONE:
        alone = single(environment_id, **keywords)
        again = AGAIN if index % 3 == 0 else -1
        expected = run_alone(alone, 7 + index, actions[:, index], again)
        assert_history(history_of(history, index), expected, f"{index} of {MANY}, alone")


@pytest.mark.parametrize(
    ("environment_id", "count", "steps"),
    [*((name, 9, 8) for name in IDS), ("PRP-JointTracking-v0", 130, 3), ("PRP-ForcePosition-v0", 130, 3)],
)
def test_number_of_threads_changes_no_bit(environment_id: str, count: int, steps: int) -> None:
    keywords: dict[str, Any] = {"scenario": "realistic", "num_envs": count, **BRIEF}
    runs = []
    for threads in (1, 2, 3, 0):
        env = together(environment_id, num_threads=threads, **keywords)
        assert env.physics.num_threads == threads if threads else env.physics.num_threads >= 1
        runs.append(run_together(env, list(range(count)), some_actions(env, steps)[:, :count], AGAIN))
    for run in runs[1:]:
        assert run == runs[0]


@pytest.mark.parametrize(
    "seed",
    [3, [3, 4, 5], (3, 4, 5), np.array([3, 4, 5]), np.int64(3), [np.int32(3), np.uint8(4), 5], range(3, 6)],
)
def test_seeds_of_any_form_are_those_of_single_environments(seed: Any) -> None:
    env = together("PRP-Force-v0", num_envs=3)
    observation, _ = env.reset(seed=seed)
    for index in range(3):
        expected, _ = single("PRP-Force-v0").reset(seed=3 + index)
        np.testing.assert_array_equal(observation[index], expected)
    assert env.np_random_seed == (3, 4, 5)


def test_no_seed_goes_on_with_a_generator_and_a_seed_starts_it_anew() -> None:
    ours, theirs = together("PRP-JointTracking-v0"), one_by_one("PRP-JointTracking-v0")
    seeds: list[int | None] = [1, 2, 3, 4, 5]
    first, _ = ours.reset(seed=seeds)
    np.testing.assert_array_equal(first, theirs.reset(seed=seeds)[0])
    mixed: list[int | None] = [None, 2, None, 9, None]
    second, _ = ours.reset(seed=mixed)
    np.testing.assert_array_equal(second, theirs.reset(seed=mixed)[0])
    assert [bool((old == new).all()) for old, new in zip(first, second, strict=True)] == [
        *(False, True, False),
        *(False, False),
    ]
    np.testing.assert_array_equal(ours.reset()[0], theirs.reset()[0])
    np.testing.assert_array_equal(ours.reset(seed=seeds)[0], first)


def test_seed_of_an_environment_that_is_not_reset_is_not_used() -> None:
    ours, theirs = together("PRP-Impedance-v0"), one_by_one("PRP-Impedance-v0")
    for env in (ours, theirs):
        env.reset(seed=0)
    mask = np.array([False, True, False, False, False])
    for env in (ours, theirs):
        env.reset(seed=[10, 11, 12, 13, 14], options={"reset_mask": mask})
    assert ours.np_random_seed == theirs.np_random_seed == (0, 11, 2, 3, 4)
    assert_same(ours.reset(), theirs.reset(), "reset")


def test_environments_without_seeds_differ_from_one_another_and_from_run_to_run() -> None:
    envs = [together("PRP-JointRegulation-v0"), together("PRP-JointRegulation-v0")]
    rows = np.concatenate([env.reset()[0] for env in envs])
    assert len(np.unique(rows, axis=0)) == 10
    assert len({seed for env in envs for seed in env.np_random_seed}) == 10


def test_unseeded_episodes_can_be_had_again_from_the_seeds_that_were_drawn() -> None:
    env = together("PRP-ForcePosition-v0")
    first, _ = env.reset()
    again, _ = env.reset(seed=env.np_random_seed)
    np.testing.assert_array_equal(again, first)


def test_generators_are_those_of_single_environments() -> None:
    ours, theirs = together("PRP-Adaptive-v0"), one_by_one("PRP-Adaptive-v0")
    for env in (ours, theirs):
        env.reset(seed=4)
    assert ours.np_random_seed == theirs.np_random_seed
    for mine, other in zip(ours.np_random, theirs.np_random, strict=True):
        assert mine.bit_generator.state == other.bit_generator.state
    ours.np_random[1].random()
    theirs.np_random[1].random()
    assert_same(ours.reset(), theirs.reset(), "reset")


def test_generators_that_were_never_asked_for_draw_a_seed_once() -> None:
    env = together("PRP-Adaptive-v0")
    seeds = env.np_random_seed
    assert all(isinstance(seed, int) for seed in seeds)
    assert env.np_random_seed == seeds
    first, _ = env.reset()
    np.testing.assert_array_equal(together("PRP-Adaptive-v0").reset(seed=seeds)[0], first)


@pytest.mark.parametrize(
    ("seed", "words"),
    [
        (-1, "seed is -1"),
        (1.0, "seed is 1.0"),
        (True, "seed is True"),
        ("12345", "seed is '12345'"),
        ([0, 1, 2, -3, 4], "seed of environment 3 is -3"),
        ([0, 1, 2, 3, 4.5], "seed of environment 4 is 4.5"),
        (np.linspace(0.0, 1.0, 5), "seed of environment 0 is 0.0"),
    ],
)
def test_seed_that_is_not_a_whole_number_is_refused_and_nothing_changes(seed: Any, words: str) -> None:
    env, twin = together("PRP-Force-v0"), together("PRP-Force-v0")
    for each in (env, twin):
        each.reset(seed=0)
    with pytest.raises(InvalidValueError, match=f"{words}; allowed: a whole number, at least 0"):
        env.reset(seed=seed)
    assert_same(env.reset(), twin.reset(), "reset")


@pytest.mark.parametrize("seed", [[], [1], [1] * 6, np.arange(4)])
def test_another_number_of_seeds_is_refused(seed: Any) -> None:
    with pytest.raises(ShapeError, match=r"seed has shape .*; expected one number, or \(5,\)"):
        together("PRP-Force-v0").reset(seed=seed)


@pytest.mark.parametrize(
    ("target_impedance", "num_envs", "cores", "threads"),
    [(0, 1, 8, 1), (0, 7, 8, 1), (0, 8, 8, 2), (0, 4096, 8, 8), (3, 1, 8, 3), (16, 64, 2, 16)],
)
def test_no_more_threads_are_used_than_save_time(
    target_impedance: int, num_envs: int, cores: int, threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("os.sched_getaffinity", lambda _: set(range(cores)))
    assert parse_threads(target_impedance, num_envs) == threads
