"""Names of 0.1 in `prp_gym.envs`: they still work, and say what to write instead."""

from typing import Any

import numpy as np
import pytest

import prp_gym
from prp_gym import envs
from prp_gym.envs import PRPEnv, PRPVectorEnv


@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_former_environment_classes_make_the_environment_of_their_task(environment_id: str) -> None:
    stem = environment_id.removeprefix("PRP-").removesuffix("-v0")
    with pytest.warns(DeprecationWarning, match=f"PRPEnv\\('{environment_id}'\\)"):
        single: Any = getattr(envs, f"{stem}Env")
    with pytest.warns(DeprecationWarning, match="PRPVectorEnv"):
        vector: Any = getattr(envs, f"{stem}VectorEnv")
    one, many = single(duration=0.1), vector(num_envs=2, duration=0.1)
    assert isinstance(one, PRPEnv)
    assert isinstance(many, PRPVectorEnv)
    assert one.task.environment_id == many.task.environment_id == environment_id
    expected, _ = PRPEnv(environment_id, duration=0.1).reset(seed=3)
    np.testing.assert_array_equal(one.reset(seed=3)[0], expected)


def test_former_options_classes_are_those_of_the_tasks() -> None:
    with pytest.warns(DeprecationWarning, match=r"prp_gym\.envs\.tasks\.joint_tracking\.TrackingOptions"):
        options: Any = envs.TrackingOptions
    assert PRPEnv("PRP-JointTracking-v0").task_spec.entry.options is options


def test_name_that_never_existed_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'NowhereEnv'"):
        envs.NowhereEnv  # noqa: B018


def test_truth_is_the_former_name_of_the_ground_truth() -> None:
    env = PRPEnv("PRP-JointTracking-v0", duration=0.1)
    env.reset(seed=1)
    with pytest.warns(DeprecationWarning, match="ground_truth"):
        former = env.truth
    np.testing.assert_array_equal(former, env.ground_truth)
