"""`Session`: an environment and its policy, stepped, paused and changed while it runs."""

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import choice, random_seed, within
from prp_gym.envs.base.surface_options import SURFACE_OPTIONS, surface_value
from prp_gym.errors import EpisodeError, InvalidValueError
from prp_gym.evaluation.policy_output import check_output
from prp_gym.evaluation.rollout import Policy
from prp_gym.physics.simulation import Physics
from prp_gym.robot.arrays import Array
from prp_gym.tuning.search_space import Parameter
from prp_gym.viewing.acting_disturbance import ActingDisturbance
from prp_gym.viewing.disturbance import Disturbance
from prp_gym.viewing.policy_source import PolicySource
from prp_gym.viewing.signal_window import SignalWindow
from prp_gym.viewing.signals import Signals

SPRINGS = tuple(name for name in SURFACE_OPTIONS if name in ("surface_stiffness", "surface_damping"))
"""The values of the surface that may be changed while an episode runs."""

_ROW = np.array([0])
_Made = tuple[gymnasium.Env[Any, Any], Policy, tuple[Parameter, ...]]


class Session:
    """An environment with its policy. Whatever a method refuses leaves the session as it is.

    Args:
        source: source of the environment and the policy.
        scenario: scenario of the episodes.
        seed: random seed of the first episode.
        seconds: length of the window of recorded signals [s].

    Attributes:
        scenario: scenario of the episodes.
        seed: random seed of the current episode.
        running: whether `advance` lets time go on.
        over: whether the episode is over.
        diverged: whether the episode ended since the simulation diverged.
        total_reward: sum of the rewards of the episode [1].
        changed: whether settings, surface or disturbance were changed during the episode.

    Raises:
        PRPError: an environment or policy that cannot be made.
    """

    scenario: str
    seed: int
    over: bool
    diverged: bool
    total_reward: float
    changed: bool
    _source: PolicySource
    _env: gymnasium.Env[Any, Any]
    _policy: Policy
    _parameters: tuple[Parameter, ...]
    _factors: dict[str, float]
    _window: SignalWindow
    _observation: Array
    _state: Any
    _start: NDArray[np.bool_]
    _disturbance: ActingDisturbance

    def __init__(self, source: PolicySource, scenario: str, seed: int = 0, seconds: float = 5.0) -> None:
        self._seconds = seconds
        self._springs: dict[str, float] = {}
        self.running = True
        self._take(source, scenario, {}, self._make(source, scenario, {}))
        self.reset(random_seed("seed", seed))

    @property
    def source(self) -> PolicySource:
        """The source of the environment and the policy."""
        return self._source

    @property
    def env(self) -> gymnasium.Env[Any, Any]:
        """The environment."""
        return self._env

    @property
    def inner(self) -> Any:
        """The environment without its wrappers."""
        return self._env.unwrapped

    @property
    def policy(self) -> Policy:
        """The policy with its present settings."""
        return self._policy

    @property
    def policy_state(self) -> Any:
        """The state that the policy returned last; None at the start of an episode."""
        return self._state

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Factors on the settings of the policy."""
        return self._parameters

    @property
    def factors(self) -> dict[str, float]:
        """The present factors by the names of `parameters`."""
        return {parameter.name: self._factors.get(parameter.name, 1.0) for parameter in self._parameters}

    @property
    def period(self) -> float:
        """Time between actions [s]."""
        return 1.0 / float(self.inner.control_frequency)

    @property
    def time(self) -> float:
        """Time since the start of the episode [s]."""
        return float(self.inner.loop.time[0])

    @property
    def signals(self) -> Signals:
        """What the environment did over the last seconds."""
        return self._window.signals()

    @property
    def has_surface(self) -> bool:
        """Whether the environment has an elastic surface."""
        physics = self.inner.physics
        return isinstance(physics, Physics) and physics.settings.surface

    @property
    def surface(self) -> dict[str, float]:
        """Stiffness [N/m] and damping [N s/m] of the surface by the names of `SPRINGS`; empty without one."""
        if not self.has_surface:
            return {}
        surface = self.inner.physics.surface()
        return dict(zip(SPRINGS, (float(surface.stiffness[0]), float(surface.damping[0])), strict=True))

    def step(self) -> bool:
        """Take one action, whether or not time is running.

        Returns:
            whether the episode goes on; after its end there are no steps.

        Raises:
            PolicyOutputError: the policy returns something else than a finite action and a state.
            UserCodeError: a user's code that fails.
        """
        if self.over:
            return False
        self._window.disturb(self._disturbance.apply())
        shape = tuple(self._env.action_space.shape or ())
        with self._source.reported(self._env):
            output = self._policy.predict(
                self._observation, self._state, episode_start=self._start, deterministic=True
            )
            action, self._state = check_output(self._policy, output, shape)
        self._observation, reward, terminated, truncated, _ = self._env.step(action)
        self.total_reward += float(reward)
        self._start, self.diverged = np.array([False]), bool(terminated)
        self.over = bool(terminated or truncated)
        return not self.over

    def advance(self, steps: int) -> int:
        """Take several actions if time is running, up to the end of the episode.

        Returns:
            the number of actions that were taken.
        """
        taken = 0
        while self.running and not self.over and taken < steps:
            self.step()
            taken += 1
        return taken

    def pause(self) -> None:
        """Stop time."""
        self.running = False

    def resume(self) -> None:
        """Let time go on."""
        self.running = True

    def reset(self, seed: int) -> None:
        """Start the episode of a seed, with the springs of the surface that were set.

        Raises:
            InvalidValueError: a seed that is negative or not a whole number.
        """
        self._observation, _ = self._env.reset(seed=random_seed("seed", seed), options=dict(self._springs))
        self.seed = int(seed)
        self._state, self._start = None, np.array([True])
        self.over = self.diverged = False
        self.changed = False
        self.total_reward = 0.0
        self._disturbance.end()
        self._window.disturb(np.zeros(self.inner.loop.joints))
        self._window.begin()

    def set_factor(self, name: str, value: float) -> None:
        """Set a factor on settings of the policy; the policy goes on from its state.

        Raises:
            UnknownNameError: a name that is not among `parameters`.
            PRPError: a factor that is not within its range, or a setting that the policy refuses.
        """
        choice("setting", name, [parameter.name for parameter in self._parameters])
        parameter = next(item for item in self._parameters if item.name == name)
        factor = within(f"factor of {name}", value, (parameter.low, parameter.high), "1")
        factors = {**self._factors, name: factor}
        self._policy = self._source.make_policy(self._env, factors)
        self._factors = factors
        self.changed = True

    def set_surface(self, name: str, value: float) -> None:
        """Set the stiffness or the damping of the surface, also for the following episodes.

        Args:
            name: one of `SPRINGS`.
            value: stiffness [N/m] or damping [N s/m].

        Raises:
            UnknownNameError: another name.
            InvalidValueError: a value out of bounds, or an environment without a surface.
        """
        choice("value of the surface", name, SPRINGS)
        if not self.has_surface:
            raise InvalidValueError(name, value, "nothing: this environment has no surface")
        springs = {**self.surface, name: float(surface_value(name, value))}
        self.inner.physics.set_springs(_ROW, *(np.array([springs[item]]) for item in SPRINGS))
        self._springs[name] = springs[name]
        self.changed = True

    def release_surface(self) -> None:
        """Draw the springs of the surface again in the following episodes, as the task declares."""
        self._springs.clear()

    def choose_scenario(self, scenario: str) -> None:
        """Start the episode of the same seed in another scenario.

        Raises:
            PRPError: a scenario that does not exist, or with which the policy cannot run.
        """
        self._replace(self._source, scenario, self._factors)

    def choose_source(self, source: PolicySource) -> None:
        """Start the episode of the same seed with another policy.

        Raises:
            PRPError: an environment or policy that cannot be made.
        """
        self._replace(source, self.scenario, {})

    def disturb(self, disturbance: Disturbance) -> None:
        """Let a disturbance act from now on, in place of one that is still acting.

        Raises:
            InvalidValueError: a disturbance that does not fit the robot.
            EpisodeError: the episode is over.
        """
        if self.over:
            raise EpisodeError("a disturbance needs an episode that is not over: reset first.")
        self._disturbance.start(disturbance)
        self.changed = True

    def close(self) -> None:
        """Free what the environment holds."""
        self._env.close()

    def _make(self, source: PolicySource, scenario: str, factors: Mapping[str, float]) -> _Made:
        """An environment with a policy and its parameters.

        Raises:
            PRPError: one of them cannot be made.
        """
        env = source.make_env(scenario)
        try:
            return env, source.make_policy(env, factors), source.parameters(env)
        except BaseException:
            env.close()
            raise

    def _replace(self, source: PolicySource, scenario: str, factors: Mapping[str, float]) -> None:
        """Take another environment and policy once both are made, and start the episode of the same seed."""
        made = self._make(source, scenario, factors)
        self._env.close()
        self._take(source, scenario, factors, made)
        self.reset(self.seed)

    def _take(self, source: PolicySource, scenario: str, factors: Mapping[str, float], made: _Made) -> None:
        self._source, self.scenario, self._factors = source, scenario, dict(factors)
        self._env, self._policy, self._parameters = made
        loop = self.inner.loop
        self._window = SignalWindow(loop, self._seconds)
        self._disturbance = ActingDisturbance(self.inner)
        loop.listen(self._window.take)
        known = self.inner.task.reset_options
        self._springs = {name: value for name, value in self._springs.items() if name in known}
