"""`Training`: PPO with a recipe that ships, as a program of `make bench-engines`."""

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from bench.part_times import Function, PartTimes, shares
from prp_gym.tasks.setup import COMPILED

INNER = "inner controller"
PARTS = ("environment", INNER, "policy", "update", "other")
"""Parts of the time of a training; with the compiled engine the inner controller is in the environment."""

_FEW = {
    "n_steps": 8,
    "batch_size": 64,
}  # of eight environments, at the first use of compiled code and PyTorch


class Training:
    """Rollouts with their updates, of the action mode and the size that the recipe names.

    Args:
        environment: environment id, whose first group of agents that ship is trained.
        engine: engine of the environments.
    """

    def __init__(self, environment: str, engine: str) -> None:
        from prp_gym.agents.training.model import make_learner
        from prp_gym.agents.training.shipped import read_groups

        group = next(item for item in read_groups() if item.environment == environment)
        recipe = group.recipe().with_engine(engine)
        few = make_learner(replace(recipe, n_envs=8, settings={**recipe.settings, **_FEW}), seed=0)
        few.model.learn(64)
        few.close()
        learner: Any = make_learner(recipe, seed=0)
        self._model = learner.model
        self._steps = recipe.n_envs * self._model.n_steps
        self._times, self._total = PartTimes(time.process_time), 0.0
        self._times.count("environment", learner.env, "step")
        self._times.count("policy", self._model.policy, "forward")
        self._times.count("update", self._model, "train")
        if engine != COMPILED:
            loop = learner.env.unwrapped.together.loop
            loop._mode = _TimedMode(loop._mode.fields, self._times.timed(INNER, loop._mode.torque))

    def __call__(self) -> float:
        """Run one rollout and its update; the number of steps of all environments."""
        start = time.process_time()
        self._model.learn(self._steps, reset_num_timesteps=False)
        self._total += time.process_time() - start
        return float(self._steps)

    @property
    def shares(self) -> Mapping[str, float]:
        """Shares of the parts in the time of all rollouts and updates so far."""
        own = dict(self._times.seconds)
        own["environment"] -= own.get(INNER, 0.0)
        return shares(own, self._total)


class _TimedMode:
    """An action mode whose calls are timed.

    Args:
        fields: parts of the action.
        torque: timed method of the action mode.
    """

    def __init__(self, fields: Any, torque: Function) -> None:
        self.fields, self.torque = fields, torque
