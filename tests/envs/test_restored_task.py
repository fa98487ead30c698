"""A restored environment continues with the task of the saved one, including its state."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.envs import PRPEnv
from prp_gym.envs.base.motion_errors import JointErrors
from prp_gym.robot.arrays import Array
from prp_gym.tasks.parts import TaskParts
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TASKS, TaskEntry

REGULATION = TASKS["PRP-JointRegulation-v0"]


class RestlessErrors(JointErrors):
    """Errors whose weight depends on the start of the episode."""

    def begin(self, ids: NDArray[np.intp], start: Any) -> None:
        self.weight = 1.0 + abs(float(start.joint_position[0, 0]))

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        return self.weight * super().errors(ground_truth, torque)


def compose(setup: TaskSetup) -> TaskParts:
    """Regulation with an error function that has a state."""
    parts = REGULATION.entry.compose(setup)
    return replace(parts, errors=RestlessErrors(REGULATION_LAYOUT))


REGULATION_LAYOUT = PRPEnv(REGULATION.id).task.layout


def test_restored_environment_has_the_errors_of_the_restored_task(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = replace(REGULATION, id="PRP-Restless-v0", entry=TaskEntry(compose))
    monkeypatch.setitem(TASKS._specs, spec.id, spec)
    env, other = PRPEnv(spec.id), PRPEnv(spec.id)
    env.reset(seed=0)
    other.reset(seed=1)
    other.set_state(env.get_state())
    action = np.zeros(3, dtype=np.float32)
    assert other.step(action)[1] == env.step(action)[1]
