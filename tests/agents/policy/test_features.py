"""What a network sees: the observation, and the errors of what is measured against what is desired."""

import numpy as np
import pytest

import prp_gym
from prp_gym.agents.policy.features import TrackingFeatures
from tests.support.synthetic_agents import layout_of, observations

DESIRED = {
    "joint_position": "desired_joint_position",
    "joint_velocity": "desired_joint_velocity",
    "end_effector_pose": "desired_pose",
    "end_effector_velocity": "desired_velocity",
    "contact_force": "desired_force",
}


@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_errors_are_desired_less_measured_behind_the_observation(environment_id: str) -> None:
    layout = layout_of(environment_id)
    features, observation = TrackingFeatures(layout), observations(5, environment_id=environment_id)
    found, parts = features(observation), layout.split(observation)
    assert found.shape == (5, features.size)
    np.testing.assert_array_equal(found[:, : layout.size], observation)
    assert features.names[: len(layout.names)] == layout.names
    errors = features.names[len(layout.names) :]
    assert {name.removesuffix("_error") for name in errors} == {
        measured for measured, desired in DESIRED.items() if {measured, desired} <= set(layout.names)
    }
    expected = [parts[DESIRED[m]] - parts[m] for m in (name.removesuffix("_error") for name in errors)]
    np.testing.assert_array_equal(found[:, layout.size :], np.concatenate(expected, axis=-1))
