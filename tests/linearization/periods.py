"""What the tests of linearisations share: periods of an environment from a state that was moved a little."""

import copy
from typing import Any

import gymnasium
import numpy as np

import prp_gym
from prp_gym import make_baseline
from prp_gym.linearization import Linearization
from tests.support.pinocchio_model import Array


def deviation(found: Array, expected: Array) -> float:
    """Largest deviation, relative to 1 + |expected|."""
    return float((np.abs(found - expected) / (1.0 + np.abs(expected))).max())


class Loop:
    """An environment and a controller some periods after the start of an episode, without torque noise.

    Args:
        environment: id of the environment.
        name: name of the controller.
        periods: number of periods before the present.
        gains: gain set of the controller.
        keywords: keywords of the environment.
    """

    def __init__(
        self, environment: str, name: str, periods: int, gains: str = "tuned", **keywords: Any
    ) -> None:
        env: Any = gymnasium.make(environment, **keywords)
        self.env: Any = env.unwrapped
        observation, _ = self.env.reset(seed=3)
        self.controller: Any = make_baseline(name, self.env, gains)
        self.policy_state: Any = None
        for _ in range(periods):
            action, self.policy_state = self.controller.predict(observation, self.policy_state)
            observation, *_ = self.env.step(action)
        self.observation = observation
        self._measured = self.env.physics.measurement[0]
        self._base = self._silent(self.env.get_state())
        split = self.controller.interface.layout.split(observation)
        self.state = self.policy_state or self.controller.initial_state(split)

    def _silent(self, state: Any) -> Any:
        """A state whose actuators have no noise."""
        actuators = state.loop.rest["_actuators"]
        if hasattr(actuators, "_deviation"):
            actuators._deviation = np.zeros_like(actuators._deviation)
        return state

    def linearized(self) -> Linearization:
        """The linear model at present."""
        return prp_gym.linearize(self.env, self.controller, state=self.policy_state)

    def next_period(self) -> Array:
        """The controller's state after a period of environment and controller."""
        self.env.set_state(self._base)
        action, after = self.controller.predict(self.observation, self.policy_state)
        self.env.step(action)
        return np.concatenate([np.zeros(0), *(part.ravel() for part in after or ())])

    def period(self, model: Linearization, z: Array) -> Array:
        """The closed loop's state after a period that begins in the state z, without rounding of actions."""
        saved, split = copy.deepcopy(self._base), self._split(model, z)
        physics, joints = saved.loop.physics.integration[0], len(self.env.torque_limit)
        physics[: 2 * joints] = split["joint"]
        if len(split["applied"]):
            physics[2 * joints :] = split["applied"]
        if len(split["commanded"]):
            saved.loop.rest["_actuators"]._pipeline[:-1, 0] = split["commanded"].reshape(-1, joints)
        self.env.set_state(saved)
        observation = self.observation.copy()
        observation[: len(self._measured)] += self.env.physics.measurement[0] - self._measured
        observed = self.controller.interface.layout.split(observation)
        state, first = [], 0
        for part in self.state:
            state.append(split["controller"][first : first + part.size].reshape(part.shape))
            first += part.size
        demand = self.controller.control(observed, tuple(state))[0] / self.controller.interface.torque_limit
        _, after = self.controller.act(observed, tuple(state))
        self.env.step(np.clip(demand, -1.0, 1.0))
        return self._joined(model, after)

    def _split(self, model: Linearization, z: Array) -> dict[str, Array]:
        """The parts of a state of the closed loop by the first word of their names."""
        words = np.array([name.partition("_")[0] for name in model.closed_loop_names])
        return {word: z[words == word] for word in ("joint", "applied", "commanded", "controller")}

    def _joined(self, model: Linearization, after: Any) -> Array:
        """The present state of the closed loop."""
        own, joints = self.env.get_state().loop, len(self.env.torque_limit)
        parts = [own.physics.integration[0][: 2 * joints]]
        if any(name.startswith("applied") for name in model.closed_loop_names):
            parts.append(own.physics.integration[0][2 * joints :])
        if any(name.startswith("commanded") for name in model.closed_loop_names):
            parts.append(own.rest["_actuators"]._pipeline[:-1, 0].ravel())
        return np.concatenate([*parts, *(part.ravel() for part in after)])
