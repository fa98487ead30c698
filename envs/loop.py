"""The loop: it counts time for N environments at once and asks physics and task for the rest.

Everything here is written once over N; a single environment is a loop of one.
"""

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.actuators import make_actuators
from prp_gym.envs.config import SUBSTEPS_PER_SECOND, EnvConfig
from prp_gym.envs.reference_window import ReferenceWindow
from prp_gym.errors import EpisodeError, InvalidValueError, NonFiniteError, ShapeError
from prp_gym.physics.mjcf import PhysicsSettings
from prp_gym.physics.simulation import MEASUREMENT_SIZE, Physics, PhysicsState
from prp_gym.robot.arrays import Array, all_true
from prp_gym.tasks.fields import POSITION_BOUND, SPEED_BOUND
from prp_gym.tasks.reward import Reward
from prp_gym.tasks.scenario import PlantDraw
from prp_gym.tasks.task import Task

_STATE_BOUND = np.array([*POSITION_BOUND, *SPEED_BOUND])
_LARGEST_SEED = 2**63


@dataclass(frozen=True)
class InfoField:
    """One number of `info`: its name, unit and meaning."""

    name: str
    unit: str
    description: str


COMMON_INFO = (
    InfoField("cost_joint_stop", "joints", "joints beyond a stop"),
    InfoField("cost_saturation", "joints", "joints whose action is at or beyond the actuator limit"),
    InfoField("time", "s", "since the start of the episode"),
)


class Step(NamedTuple):
    """What one step of N environments returned.

    Attributes:
        observation: (N, size), new.
        reward: (N) [s].
        terminated: (N), diverged.
        truncated: (N), the episode's duration is over.
        info: (N, number of info fields).
    """

    observation: Array
    reward: Array
    terminated: NDArray[np.bool_]
    truncated: NDArray[np.bool_]
    info: Array


def _count(values: NDArray[Any]) -> NDArray[Any] | int:
    """How many values in each row (N, 3) are not zero; mostly none."""
    if not np.count_nonzero(values):
        return 0
    counts: NDArray[np.intp] = np.count_nonzero(values, axis=1)
    return counts


class LoopState(NamedTuple):
    """All that determines how a loop goes on."""

    physics: PhysicsState
    rest: dict[str, Any]


class EpisodeLoop:
    """N environments of one task, stepped together.

    Args:
        task: judges them.
        config: common keywords.
        num_envs: N.
        num_threads: of the physics; 0 takes all cores.

    Attributes:
        torque_limit: joint torques at action 1 (3) [N m, N, N m].
        commanded_torque: of the last step, within the limits (N, 3) [N m, N, N m].
        info_fields: the columns of a step's `info`.
    """

    def __init__(self, task: Task[Any], config: EnvConfig, num_envs: int = 1, num_threads: int = 1) -> None:
        self.task = task
        self.config = config
        self.num_envs = num_envs
        self.torque_limit = np.array(config.limits())
        scenario = task.scenario
        settings = PhysicsSettings(1.0 / SUBSTEPS_PER_SECOND, scenario.joint_stops)
        self.physics = Physics(task.arm.parameters, settings, num_envs, num_threads)
        self.reward = Reward(task.numbers.reward, 1.0 / config.control_frequency)
        terms = [InfoField(f"reward_{t.name}", "s", f"reward from {t.name}") for t in self.reward.terms]
        self.info_fields = (*terms, *COMMON_INFO)
        self._ideal_plant = scenario.ideal_plant
        self._actuators = make_actuators(scenario, num_envs)
        self.commanded_torque = np.zeros((num_envs, 3))
        self._window = ReferenceWindow(num_envs, 1.0 / config.control_frequency, config.horizon)
        self._unplayable: NDArray[np.bool_] = np.ones(num_envs, dtype=np.bool_)
        self._playable = False
        self._limit = np.tile(self.torque_limit, (num_envs, 1))
        self._bound = np.tile(_STATE_BOUND, (num_envs, 1))
        self._horizon, self._substeps = config.horizon, config.substeps
        self._frequency = float(config.control_frequency)
        self._space = task.layout.space()

    def reset(
        self,
        ids: NDArray[np.intp],
        rngs: Sequence[np.random.Generator],
        options: Mapping[str, Array],
    ) -> Array:
        """Start new episodes in some environments; the first call must cover all of them.

        If a start is refused, the episodes that run go on as they were; the generators have moved on.

        Args:
            ids: (n) the environments, in rising order.
            rngs: (n) their own generators.
            options: validated reset options, the same for all.

        Returns:
            (N, size) observations of all environments.

        Raises:
            InvalidValueError: ids out of order or out of range; a first call for some only.
            PRPError: a start or goal that the task refuses.
        """
        self._check_ids(ids)
        starts, plants, seeds = [], [], []
        for rng in rngs:
            starts.append(self.task.draw(rng, options))
            if not self._ideal_plant:
                plants.append(self.task.scenario.draw_plant(rng))
            seeds.append(int(rng.integers(_LARGEST_SEED)))
        self._set_plants(ids, plants)
        self.task.begin(ids, starts)
        self._actuators.begin(ids, seeds)
        self.physics.reset(
            ids,
            np.stack([start.joint_position for start in starts]),
            np.stack([start.joint_velocity for start in starts]),
        )
        self._window.begin(ids, self.task.reference)
        self._unplayable[ids] = False
        self._playable = not self._unplayable.any()
        return self._observe()

    def _check_ids(self, ids: NDArray[np.intp]) -> None:
        rising = len(ids) > 0 and ids[0] >= 0 and ids[-1] < self.num_envs and (np.diff(ids) > 0).all()
        if not rising:
            raise InvalidValueError("ids", ids.tolist(), f"rising, from 0 to {self.num_envs - 1}")
        if not self.started and len(ids) < self.num_envs:
            raise InvalidValueError("ids of the first reset", ids.tolist(), "all environments")

    def _set_plants(self, ids: NDArray[np.intp], plants: Sequence[PlantDraw]) -> None:
        if self._ideal_plant:
            return
        self.physics.set_dynamics(
            ids,
            np.stack([plant.mass_factor for plant in plants]),
            np.stack([plant.viscous_friction for plant in plants]),
            np.stack([plant.coulomb_friction for plant in plants]),
        )

    def step(self, action: Array) -> Step:
        """One control period of every environment.

        Args:
            action: (N, 3) torques over their limits; beyond ±1 they are clipped and counted.

        Returns:
            observations and judgement after the step.

        Raises:
            ShapeError: another shape.
            NonFiniteError: NaN or infinity in the action; nothing was changed.
            EpisodeError: an environment that was not reset, or has diverged.
        """
        if not self._playable:
            raise EpisodeError(self._why_not_playable())
        if action.shape != (self.num_envs, 3):
            raise ShapeError("action", action.shape, f"({self.num_envs}, 3)")
        saturated: NDArray[Any] | int = 0
        inside = np.abs(action) < 1.0
        if not all_true(inside):
            if not np.isfinite(action).all():
                raise NonFiniteError("action", action.tolist())
            action = np.clip(action, -1.0, 1.0)
            saturated = _count(~inside)
        command = action * self._limit
        self.commanded_torque = command
        self.physics.set_torque(self._actuators.apply(command))
        self.physics.advance(self._substeps)
        self._window.advance(self.task.reference)
        return self._judge(command, saturated)

    def _judge(self, command: Array, saturated: NDArray[Any] | int) -> Step:
        elapsed = self._window.elapsed
        observation = self._observe()
        contributions = self.reward(self.task.errors(observation, command))
        terms = contributions.shape[1]
        info = np.empty((self.num_envs, terms + len(COMMON_INFO)))
        info[:, :terms] = contributions
        info[:, terms] = _count(self.physics.stop_violation)
        info[:, terms + 1] = saturated
        info[:, terms + 2] = elapsed / self._frequency
        truncated = elapsed >= self._horizon
        outside = np.abs(observation[:, :6]) > self._bound
        if not (np.count_nonzero(outside) or self.physics.any_unstable):
            terminated = np.zeros(self.num_envs, dtype=np.bool_)
            return Step(observation, np.add.reduce(contributions, axis=1), terminated, truncated, info)
        diverged = np.logical_or.reduce(outside, axis=1) | self.physics.unstable
        return self._diverged(observation, diverged, truncated, info, terms)

    def _diverged(
        self,
        observation: Array,
        terminated: NDArray[np.bool_],
        truncated: NDArray[np.bool_],
        info: Array,
        terms: int,
    ) -> Step:
        """A step in which some environments left the declared bounds: no reward, a bounded observation."""
        self._unplayable |= terminated
        self._playable = False
        info[terminated, :terms] = 0.0
        low, high = self._space.low, self._space.high
        bounded = np.clip(observation, low, high)
        observation = np.where(terminated[:, None], bounded, observation)
        reward = np.add.reduce(info[:, :terms], axis=1)
        return Step(observation, reward, terminated, truncated & ~terminated, info)

    def _observe(self) -> Array:
        observation = np.empty((self.num_envs, self.task.layout.size))
        self.physics.measure(observation[:, :MEASUREMENT_SIZE])
        observation[:, MEASUREMENT_SIZE:] = self._window.current
        return observation

    def _why_not_playable(self) -> str:
        which = np.flatnonzero(self._unplayable).tolist()
        return f"environments {which} cannot be stepped: never reset, or diverged; call reset first."

    @property
    def started(self) -> bool:
        """Whether every environment has been reset at least once."""
        return self._window.started

    @property
    def time(self) -> Array:
        """(N) since the start of each episode [s]."""
        seconds: Array = self._window.elapsed / self._frequency
        return seconds

    def get_state(self) -> LoopState:
        """Copy of all that determines how the environments go on."""
        return LoopState(self.physics.snapshot(), copy.deepcopy(self._rest()))

    def set_state(self, state: LoopState) -> Array:
        """Go back to a state of this loop or of one made with the same keywords.

        Returns:
            (N, size) observations.

        Raises:
            InvalidValueError: a state of another number of environments.
        """
        if len(state.rest["_unplayable"]) != self.num_envs:
            raise InvalidValueError(
                "state's number of environments", len(state.rest["_unplayable"]), f"{self.num_envs}"
            )
        self.physics.restore(state.physics)
        self.__dict__.update(copy.deepcopy(state.rest))
        return self._observe()

    def _rest(self) -> dict[str, Any]:
        names = ("task", "commanded_torque", "_actuators", "_window", "_unplayable", "_playable")
        return {name: getattr(self, name) for name in names}
