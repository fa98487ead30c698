"""Many environments together are Gymnasium's SyncVectorEnv of single ones, bit for bit, in every mode."""

from typing import Any

import numpy as np
import pytest

from prp_gym.tasks import SCENARIOS
from tests.support.covering import by_turns
from tests.support.vector_episodes import IDS, MODES, SHORT, actions_for, assert_same, one_by_one, together

N = 5


@pytest.mark.parametrize(("environment_id", "mode", "scenario"), by_turns(IDS, MODES, SCENARIOS))
def test_steps_and_restarts_are_those_of_single_environments(
    environment_id: str, mode: str, scenario: str
) -> None:
    keywords: dict[str, Any] = {"scenario": scenario, **SHORT}
    ours, theirs = together(environment_id, mode, **keywords), one_by_one(environment_id, mode, **keywords)
    assert_same(ours.reset(seed=7), theirs.reset(seed=7), "reset")
    # some are reset on their own, so that from then on episodes end at different steps
    again = np.zeros(N, dtype=np.bool_)
    for count, action in enumerate(actions_for(ours, 25)):
        if count == 3:
            again |= [True, False, False, True, False]
        if again.any():
            seeds = [100 + count, None, None, None, 5]
            found = ours.reset(seed=seeds, options={"reset_mask": again})
            assert_same(found, theirs.reset(seed=seeds, options={"reset_mask": again}), f"reset {count}")
        outcome = ours.step(action)
        assert_same(outcome, theirs.step(action), f"step {count}")
        again = (outcome[2] | outcome[3]) & (mode == "Disabled")


@pytest.mark.parametrize("steps", [4, 1000])
@pytest.mark.parametrize("mode", MODES[:2])
def test_limit_of_steps_is_gymnasiums(mode: str, steps: int) -> None:
    keywords: dict[str, Any] = {"max_episode_steps": steps, **SHORT}
    ours, theirs = together(IDS[0], mode, **keywords), one_by_one(IDS[0], mode, **keywords)
    assert_same(ours.reset(seed=2), theirs.reset(seed=2), "reset")
    for count, action in enumerate(actions_for(ours, 15)):
        assert_same(ours.step(action), theirs.step(action), f"step {count}")
