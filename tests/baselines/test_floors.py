"""The floors: policies that do nothing, or hold the start pose, on every task."""

import gymnasium
import numpy as np
import pytest

from prp_gym import list_envs
from prp_gym.baselines import CONTROLLERS
from prp_gym.baselines.floors import FLOORS
from prp_gym.evaluation import record_episode
from prp_gym.runs.floor_job import list_floors

TIP = 0.01  # m, rad: an arm that is held moves less, whatever its mass errors; a fallen one far more


def test_floors_are_no_controllers() -> None:
    assert list(FLOORS) == ["zero_torque", "hold"]
    assert set(FLOORS).isdisjoint(CONTROLLERS)


@pytest.mark.parametrize("environment_id", list_envs())
def test_torques_of_zero_torque_are_zero(environment_id: str) -> None:
    env = gymnasium.make(environment_id, duration=0.1)
    rollout = record_episode(FLOORS["zero_torque"].make(env), env, 0)
    env.close()
    np.testing.assert_array_equal(rollout.torque, 0.0)


@pytest.mark.parametrize("frequency", [50.0, 500.0])
@pytest.mark.parametrize("environment_id", ["PRP-JointRegulation-v0", "PRP-PoseTracking-v0", "PRP-Force-v0"])
def test_hold_keeps_the_start_pose_with_model_errors_and_delay(environment_id: str, frequency: float) -> None:
    env = gymnasium.make(environment_id, scenario="realistic", control_frequency=frequency, duration=2.0)
    rollout = record_episode(FLOORS["hold"].make(env), env, 3)
    env.close()
    joints = rollout.fields["joint_position"]
    limit = TIP if frequency == 500.0 else 0.3  # the bandwidth is lower by a factor of eight, and squared
    assert np.abs(joints - joints[0]).max() < limit
    assert np.abs(rollout.fields["joint_velocity"][-1]).max() < 0.2  # rad/s, m/s: torque noise moves joint 3


def test_every_condition_has_both_floors() -> None:
    jobs = list_floors([(environment_id, "report") for environment_id in list_envs()], 500.0, 20, 0)
    assert len(jobs) == len({job.name for job in jobs}) == 2 * len(list_envs())
    assert {job.episodes for job in jobs} == {1}  # a deterministic scenario
