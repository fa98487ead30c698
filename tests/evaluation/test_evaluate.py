"""`evaluate`: which episodes are run, and what is said about them."""

from collections.abc import Iterator
from dataclasses import fields
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import RecordEpisodeStatistics

from prp_gym import evaluate, list_envs
from prp_gym.baselines import list_baselines, make_baseline
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation import METRICS, Evaluation, Rollout, bootstrap_interquartile_mean, record_episode
from prp_gym.evaluation.evaluate import episodes_to_run
from prp_gym.tasks.scenario import SCENARIOS

Env = gymnasium.Env[Any, Any]
DURATION = 0.05


def make(environment_id: str, scenario: str) -> Env:
    return gymnasium.make(environment_id, scenario=scenario, duration=DURATION)


def any_controller(env: Env) -> Any:
    return make_baseline(list_baselines(env.get_wrapper_attr("observation_layout"))[0], env)


@pytest.fixture(params=list_envs())
def env(request: pytest.FixtureRequest) -> Iterator[Env]:
    made = make(request.param, "randomized")
    yield made
    made.close()


@pytest.fixture(params=list_envs())
def deterministic(request: pytest.FixtureRequest) -> Iterator[Env]:
    made = make(request.param, "report")
    yield made
    made.close()


def starts(evaluation: Evaluation) -> list[list[float]]:
    """What a policy cannot change: ground truth at the start, by episode."""
    return [[*np.concatenate([values[0] for values in r.fields.values()])] for r in evaluation.rollouts]


def assert_same(first: Rollout, second: Rollout) -> None:
    """Equal bits, but for the time that the policy took."""
    for entry in fields(Rollout):
        one, other = getattr(first, entry.name), getattr(second, entry.name)
        if isinstance(one, dict):
            assert set(one) == set(other)
            for name, values in one.items():
                np.testing.assert_array_equal(values, other[name])
        elif entry.name != "compute_time":
            np.testing.assert_array_equal(one, other)


def test_episodes_have_consecutive_seeds(env: Env) -> None:
    evaluation = evaluate(any_controller(env), env, episodes=4, seed=10)
    assert [rollout.seed for rollout in evaluation.rollouts] == [10, 11, 12, 13]
    assert evaluation.seed == 10
    for rollout in evaluation.rollouts:
        assert_same(rollout, record_episode(any_controller(env), env, rollout.seed))


def test_every_controller_meets_the_same_episodes(env: Env) -> None:
    names = list_baselines(env.get_wrapper_attr("observation_layout"))
    evaluations = [evaluate(make_baseline(name, env), env, episodes=3, seed=5) for name in names]
    assert len(evaluations) > 1
    assert all(starts(evaluation) == starts(evaluations[0]) for evaluation in evaluations)
    assert len({tuple(start) for start in starts(evaluations[0])}) == 3
    torques = {b"".join(r.torque.tobytes() for r in evaluation.rollouts) for evaluation in evaluations}
    assert len(torques) == len(evaluations)


def test_longer_evaluation_begins_with_the_shorter_one(env: Env) -> None:
    short, long = (evaluate(any_controller(env), env, episodes=count, seed=3) for count in (2, 4))
    for first, second in zip(short.rollouts, long.rollouts[:2], strict=True):
        assert_same(first, second)


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("environment_id", list_envs())
def test_same_seeds_give_the_same_results_in_another_environment(environment_id: str, scenario: str) -> None:
    evaluations = []
    for _ in range(2):
        made = make(environment_id, scenario)
        evaluations.append(evaluate(any_controller(made), made, episodes=3, seed=8))
        made.close()
    first, second = evaluations
    for one, other in zip(first.rollouts, second.rollouts, strict=True):
        assert_same(one, other)
    assert first.score == second.score
    assert set(first.metrics) == set(second.metrics)
    for name, values in first.metrics.items():
        np.testing.assert_array_equal(values, second.metrics[name])


def test_deterministic_scenario_is_run_once(deterministic: Env) -> None:
    calls: list[int] = []
    evaluation = evaluate(any_controller(deterministic), deterministic, 5, 2, lambda: calls.append(1))
    assert [rollout.seed for rollout in evaluation.rollouts] == [2]
    assert len(calls) == episodes_to_run(deterministic, 5) == 1
    assert evaluation.score.low == evaluation.score.value == evaluation.score.high


def test_caller_is_told_of_every_episode(env: Env) -> None:
    calls: list[int] = []
    evaluate(any_controller(env), env, episodes=4, seed=0, on_episode=lambda: calls.append(1))
    assert len(calls) == episodes_to_run(env, 4) == 4


def test_metrics_are_stacked_over_the_episodes(env: Env) -> None:
    evaluation = evaluate(any_controller(env), env, episodes=3, seed=0)
    rollout = evaluation.rollouts[0]
    sizes = {metric.name: metric.components(rollout) for metric in METRICS.values() if metric.exists(rollout)}
    assert {name: values.shape for name, values in evaluation.metrics.items()} == {
        name: (3, size) for name, size in sizes.items()
    }
    scores = [rollout.reward.sum() / rollout.planned_periods for rollout in evaluation.rollouts]
    np.testing.assert_array_equal(evaluation.metrics["score"][:, 0], scores)
    assert ((evaluation.metrics["score"] > 0.0) & (evaluation.metrics["score"] <= 1.0)).all()


def test_score_is_the_mean_with_its_interval(env: Env) -> None:
    evaluation = evaluate(any_controller(env), env, episodes=12, seed=3)
    scores = evaluation.metrics["score"][:, 0]
    assert evaluation.score.value == pytest.approx(scores.mean(), rel=1e-14)
    assert evaluation.summary.interquartile_mean == bootstrap_interquartile_mean(
        scores, np.random.default_rng(3)
    )
    assert evaluation.score.low < evaluation.score.value < evaluation.score.high


def test_environments_are_evaluated_through_wrappers(env: Env) -> None:
    wrapped = evaluate(any_controller(env), RecordEpisodeStatistics(env), episodes=2, seed=1)
    for one, other in zip(
        evaluate(any_controller(env), env, episodes=2, seed=1).rollouts, wrapped.rollouts, strict=True
    ):
        assert_same(one, other)


def fabricated(*positions: float, still: bool = True) -> Evaluation:
    """Episodes of two steps whose first joint ends at given positions, goal 1."""
    episodes = []
    for seed, position in enumerate(positions):
        actual = np.zeros((3, 3))
        actual[1:, 0] = position
        desired = np.array([[1.0, 0.0, 0.0]] * 3)
        desired[0, 1] = 0.0 if still else 0.1 + seed
        episode = Rollout(
            "PRP-JointTracking-v0",
            "randomized",
            seed,
            0.01,
            0.02,
            {"joint_position": actual, "joint_velocity": np.zeros((3, 3)), "desired_joint_position": desired},
            np.zeros((2, 3)),
            np.zeros((2, 3)),
            np.full(2, 0.005),
            {"cost_saturation": np.zeros(2), "cost_joint_stop": np.zeros(2)},
            False,
            np.full(2, 1e-5 * (seed + 1)),
            np.full(3, 100.0),
        )
        episodes.append(episode)
    return Evaluation(episodes, 0)


def test_median_is_that_of_the_episodes_that_have_a_value() -> None:
    assert fabricated(0.5, 1.1, 1.5).median["overshoot"] == pytest.approx([10.0], rel=1e-12)
    mixed = Evaluation([*fabricated(1.1, 1.3).rollouts, *fabricated(1.9, still=False).rollouts], 0)
    assert np.isnan(mixed.metrics["overshoot"][2, 0])
    assert mixed.median["overshoot"] == pytest.approx([20.0], rel=1e-12)
    assert np.isnan(fabricated(1.1, 1.3, still=False).median["overshoot"]).all()


def test_median_settling_time_is_infinite_if_most_episodes_never_settle() -> None:
    np.testing.assert_array_equal(fabricated(0.5, 0.5, 1.0).median["settling_time"], [np.inf])
    np.testing.assert_array_equal(fabricated(0.5, 1.0, 1.0).median["settling_time"], [0.01])


def test_compute_time_is_the_median_over_all_steps() -> None:
    assert fabricated(1.0, 1.0, 1.0).compute_time == pytest.approx(2e-5, rel=1e-12)


@pytest.mark.parametrize("episodes", [0, -1])
def test_fewer_than_one_episode_is_refused(deterministic: Env, episodes: int) -> None:
    with pytest.raises(
        InvalidValueError, match=f"episodes is {episodes}; allowed: a whole number, at least 1"
    ):
        evaluate(any_controller(deterministic), deterministic, episodes=episodes)


def test_negative_seed_is_refused(env: Env) -> None:
    with pytest.raises(InvalidValueError, match="seed is -1; allowed: a whole number, at least 0"):
        evaluate(any_controller(env), env, seed=-1)


def test_environment_of_another_suite_is_refused(env: Env) -> None:
    foreign = gymnasium.make("CartPole-v1")
    with pytest.raises(InvalidValueError, match="an environment of prp_gym"):
        evaluate(any_controller(env), foreign)
    foreign.close()
