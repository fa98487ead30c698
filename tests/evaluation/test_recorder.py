"""One recorder for all: what it writes down is what the environment showed at the torques' period."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import RescaleAction

from prp_gym.envs import PRPEnv
from prp_gym.evaluation.batch import record_episodes
from prp_gym.evaluation.episode import record_episode
from tests.support.mode_episodes import made
from tests.support.synthetic_mode import NEVER, WILD, violent_in
from tests.support.vector_episodes import assert_same, single

RATE, PERIODS = 50, 10


class Script:
    """A policy of given actions, one after the other, whatever it sees.

    Args:
        actions: (count, size); the last one holds.
    """

    def __init__(self, actions: Any) -> None:
        self._actions = np.asarray(actions, dtype=np.float32)

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        index = 0 if state is None else int(state)
        action = self._actions[min(index, len(self._actions) - 1)]
        lead = np.shape(observation)[:-1]
        return np.broadcast_to(action, (*lead, len(action))), index + 1


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """MuJoCo writes warnings of diverging simulations to a file in the working directory."""
    monkeypatch.chdir(tmp_path)


def watched(env: PRPEnv, actions: Any, seed: int) -> dict[str, Any]:
    """What an environment at 500 Hz showed while each action held for its period."""
    env.reset(seed=seed)
    seen: dict[str, list[Any]] = {"ground_truth": [env.ground_truth], "torque": [], "applied": [], "info": []}
    for action in np.repeat(actions, PERIODS, axis=0):
        _, _, terminated, truncated, info = env.step(action)
        seen["ground_truth"].append(env.ground_truth)
        seen["torque"].append(env.commanded_torque)
        seen["applied"].append(env.applied_torque)
        seen["info"].append(info)
        if terminated or truncated:
            break
    return seen


def test_every_period_of_the_torques_is_recorded() -> None:
    keywords: dict[str, Any] = {"scenario": "realistic", "duration": 0.1}
    env = made("PRP-ForcePosition-v0", "force_position", control_frequency=RATE, **keywords)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (5, 8)).astype(np.float32)
    seen = watched(made("PRP-ForcePosition-v0", "force_position", **keywords), actions, 9)
    for rollout in (record_episode(Script(actions), env, 9), record_episodes(Script(actions), env, [9])[0]):
        assert rollout.period == 0.002
        assert rollout.duration == pytest.approx(0.1)
        np.testing.assert_allclose(rollout.time[-1], 0.1, rtol=1e-12)  # a count times a period
        fields = env.task.ground_truth_layout.split(np.array(seen["ground_truth"]))
        assert_same(dict(rollout.fields), fields, "fields")
        assert_same(rollout.torque, np.array(seen["torque"]), "torque")
        assert_same(rollout.applied_torque, np.array(seen["applied"]), "applied torque")
        for name, values in rollout.info.items():
            assert_same(values, np.array([info[name] for info in seen["info"]]), name)
        assert len(rollout.compute_time) >= 1


@pytest.mark.usefixtures("late_mode")
@pytest.mark.parametrize("delay", [0, 1])
def test_episode_that_diverges_within_a_period_is_recorded_up_to_there(delay: int) -> None:
    scenario = ("randomized", "realistic")[delay]
    env = single("PRP-ForcePosition-v0", **WILD, scenario=scenario, control_frequency=RATE, duration=0.1)
    script = Script([[NEVER, 1.0], [violent_in(13), 1.0]])
    alone = record_episode(script, env, 2)
    together = record_episodes(script, env, [2, 3])
    for rollout in (alone, *together):
        assert rollout.diverged
        assert len(rollout.reward) == len(rollout.torque) == 13 + delay
        assert rollout.reward[-1] == 0.0
        assert (rollout.reward[:-1] > 0.0).all()
        assert all(len(values) == 14 + delay for values in rollout.fields.values())
    assert_same(together[0].torque, alone.torque, "torque")
    assert_same(dict(together[0].fields), dict(alone.fields), "fields")


def test_recording_leaves_nothing_behind() -> None:
    env = made("PRP-Impedance-v0", "impedance", control_frequency=RATE, duration=0.1)
    script = Script([[0.5] * 5])
    first = record_episode(script, env, 1)
    env.reset(seed=5)
    for _ in range(5):
        env.step(np.zeros(5))  # nobody listens: a recorder that did would be full
    env.step(np.zeros(5))
    assert_same(record_episode(script, env, 1).torque, first.torque, "torque")


def test_wrappers_of_actions_are_passed_through() -> None:
    env = made("PRP-Impedance-v0", "impedance", control_frequency=RATE, duration=0.1)
    low, high = np.full(5, -2.0, dtype=np.float32), np.full(5, 2.0, dtype=np.float32)
    wrapped: gymnasium.Env[Any, Any] = RescaleAction(env, low, high)
    found = record_episode(Script([[1.0] * 5]), wrapped, 1)
    assert_same(found.torque, record_episode(Script([[0.5] * 5]), env, 1).torque, "torque")
