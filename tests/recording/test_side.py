"""The episodes of a video: what a policy returns is checked, as everywhere else."""

from contextlib import closing
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.errors import PolicyOutputError
from prp_gym.recording.side import Side
from prp_gym.runs.acting_policy import ActingPolicy


class Broken:
    """A policy that returns NaN."""

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        return np.full(3, np.nan), None


def test_action_with_nan_is_refused_by_the_name_of_its_policy() -> None:
    with closing(gymnasium.make("PRP-JointTracking-v0")) as env:
        side = Side(ActingPolicy("broken", env, Broken()), 0)
        with pytest.raises(PolicyOutputError, match="predict of Broken returned an action with NaN"):
            side.advance(0.1)
        assert len(side.samples) == 1
