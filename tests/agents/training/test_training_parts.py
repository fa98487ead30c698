"""The parts of training: features, normaliser, counters, episodes."""

from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from prp_gym.agents.policy.features import TrackingFeatures
from prp_gym.agents.sb3.feature_vec_env import TrackingFeaturesVecEnv
from prp_gym.agents.sb3.make_vec_env import make_sb3_vec_env
from prp_gym.agents.training.model import make_learner
from prp_gym.agents.training.progress import Milestones
from prp_gym.agents.training.train import train
from prp_gym.agents.training.training_state import Violations
from prp_gym.errors import InvalidValueError
from tests.support.training_runs import assert_equal, tiny_job, tiny_recipe, trained


def test_features_are_given_also_of_the_last_step_of_an_episode() -> None:
    keywords: dict[str, Any] = {"duration": 0.06, "control_frequency": 100, "num_threads": 1}
    name = "PRP-JointTracking-v0"
    plain, wrapped = (make_sb3_vec_env(name, 3, seed=5, **keywords) for _ in range(2))
    env = TrackingFeaturesVecEnv(wrapped)
    features = TrackingFeatures(plain.get_attr("observation_layout", 0)[0])
    assert env.observation_space.shape == (features.size,)
    np.testing.assert_array_equal(env.reset(), features(np.asarray(plain.reset())).astype(np.float32))
    action = np.full((3, 3), 0.3, dtype=np.float32)
    for _ in range(7):  # episodes have six steps
        ours, theirs = env.step(action), plain.step(action)
        np.testing.assert_array_equal(ours[0], features(np.asarray(theirs[0])).astype(np.float32))
        for info, other in zip(ours[3], theirs[3], strict=True):
            assert ("terminal_observation" in info) == ("terminal_observation" in other)
            if "terminal_observation" in info:
                expected = features(other["terminal_observation"]).astype(np.float32)
                np.testing.assert_array_equal(info["terminal_observation"], expected)


def test_frozen_normalizer_is_that_of_training() -> None:
    learner, _ = trained("ppo")
    features = np.random.default_rng(0).normal(0.0, 100.0, (50, learner.normalizer.mean.size))
    # VecNormalize rounds to single precision
    np.testing.assert_array_equal(
        learner.normalizer(features).astype(np.float32), learner.env.normalize_obs(features)
    )


def test_unnormalized_features_are_left_as_they_are(tmp_path: Path) -> None:
    job = tiny_job(tmp_path / "run", more=["normalize.obs=false"])
    train(job)
    with closing(make_learner(job.recipe, 0)) as learner:
        features = 1e3 * np.ones((2, learner.normalizer.mean.size))
        np.testing.assert_array_equal(learner.normalizer(features), features)


def test_violations_are_summed_over_steps_and_environments() -> None:
    violations = Violations()
    within_limits = {"cost_joint_stop": 0.0, "TimeLimit.truncated": False}
    hit = {"cost_joint_stop": 2.0, "TimeLimit.truncated": False}
    violations.add([within_limits, hit], np.array([False, False]))
    violations.add([{**hit, "TimeLimit.truncated": True}, hit], np.array([True, True]))
    assert violations == Violations(joint_stop=6.0, force_bound=0.0, divergences=1)
    violations.add([{**within_limits, "cost_force_bound": 1.0}], np.array([False]))
    assert violations == Violations(joint_stop=6.0, force_bound=1.0, divergences=1)


def test_milestones_are_met_once_each_and_from_where_a_run_goes_on() -> None:
    milestones = Milestones(10, 0)
    assert [milestones.reached(steps) for steps in (0, 9, 10, 19, 25, 29, 50, 51)] == [
        *(False, False, True, False, True, False, True, False)
    ]
    resumed = Milestones(10, 25)
    assert [resumed.reached(steps) for steps in (25, 29, 30)] == [False, False, True]


def test_episodes_differ_between_training_seeds_and_after_a_resume() -> None:
    recipe = tiny_recipe()
    firsts = []
    for seed, resumes in ((0, 0), (0, 0), (0, 1), (1, 0)):
        with closing(make_learner(recipe, seed, resumes)) as learner:
            firsts.append(learner.env.venv.reset())
    assert_equal(firsts[0], firsts[1])
    for other in firsts[2:]:
        assert not np.any(np.all(np.isin(np.asarray(firsts[0]), np.asarray(other)), axis=1))


def test_training_seeds_begin_with_different_weights() -> None:
    first, second = (make_learner(tiny_recipe(), seed).model.policy.state_dict() for seed in (0, 1))
    assert not np.array_equal(first["action_net.weight"], second["action_net.weight"])


def test_settings_that_the_algorithm_refuses_are_refused_with_its_reason() -> None:
    with pytest.raises(InvalidValueError, match="settings of ppo"):
        make_learner(tiny_recipe(more=["batch_size=1"]), 0)
