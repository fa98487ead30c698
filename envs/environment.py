"""`PRPEnv`: the Gymnasium environment, a loop of one."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, NamedTuple

import gymnasium
import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.checks import as_numbers
from prp_gym.envs.config import RENDER_MODES, EnvConfig, parse_keywords
from prp_gym.envs.data import load_task_numbers
from prp_gym.envs.info import InfoField
from prp_gym.envs.loop import EpisodeLoop, LoopState
from prp_gym.errors import (
    EpisodeError,
    InvalidValueError,
    NonFiniteError,
    RenderingError,
    ShapeError,
    UnknownNameError,
)
from prp_gym.physics.batch_simulation import Simulation
from prp_gym.physics.rendering import (
    NO_DISPLAY,
    Mark,
    OffscreenRenderer,
    WindowRenderer,
    force_arrow,
    has_display,
)
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.robot.link import Link
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.task import NoOptions, Task

_ONLY = np.array([0])
_VIEW: dict[str, Any] = {"render_mode": None, "width": 1, "height": 1, "camera": "top"}  # how one looks on


class EnvState(NamedTuple):
    """A saved environment; see `PRPEnv.get_state`."""

    loop: LoopState
    config: EnvConfig
    options: object
    generator: Mapping[str, Any]


class PRPEnv(gymnasium.Env[Array, NDArray[Any]]):
    """One robot and one task.

    Actions are torques over their limits, Box(-1, 1, (joints,), float32); observations a flat float64 vector
    that `observation_layout` splits into named fields. Subclasses name their task.

    Args:
        keywords: see `EnvConfig`, and the task's own in `options_class`.

    Raises:
        PRPError: a keyword that does not exist or a value that is not allowed; `human` without a display.
    """

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES), "render_fps": 500}  # noqa: RUF012
    task_class: ClassVar[type[Task[Any]]]
    options_class: ClassVar[type] = NoOptions

    def __init__(self, **keywords: object) -> None:
        self.options: object
        self.config, self.options = parse_keywords(keywords, self.options_class)
        modes = [mode for mode in RENDER_MODES if mode != "human" or has_display()]
        self.metadata = {"render_modes": modes, "render_fps": max(1, round(self.config.control_frequency))}
        if self.config.render_mode == "human" and not has_display():
            raise RenderingError(NO_DISPLAY)
        self.render_mode = self.config.render_mode
        self._loop = self.make_loop()
        self._info_names = tuple(field.name for field in self._loop.info_fields)
        self._renderer: OffscreenRenderer | WindowRenderer | None = None
        self.observation_space = self._loop.task.layout.space()
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (self._loop.joints,), np.float32)

    @classmethod
    def make_task(cls, config: EnvConfig, options: Any) -> Task[Any]:
        """The task; the same for single and vectorised environments."""
        numbers = load_task_numbers(cls.task_class.environment_id)
        return cls.task_class(numbers, config.load_scenario(), options, 1.0 / config.control_frequency)

    def make_loop(self, num_envs: int = 1, num_threads: int = 1) -> EpisodeLoop:
        """A new loop of environments made with this one's keywords."""
        return EpisodeLoop(self.make_task(self.config, self.options), self.config, num_envs, num_threads)

    @property
    def observation_layout(self) -> ObservationLayout:
        """Where each field lies in an observation."""
        return self._loop.task.layout

    @property
    def physics(self) -> Simulation:
        """The simulated world, with one simulation."""
        return self._loop.physics

    @property
    def task(self) -> Task[Any]:
        """What is asked of the arm."""
        return self._loop.task

    @property
    def arm(self) -> PRPArm | Link:
        """The nominal robot: the model that policies may know, whatever the plant really is."""
        return self._loop.task.model

    @property
    def truth(self) -> Array:
        """What is true now (size), laid out as `task.truth_layout`; policies see the observation."""
        return np.array(self._loop.truth[0])

    @property
    def torque_limit(self) -> Array:
        """Joint torques at action 1 (joints) [N m, N, N m]."""
        return self._loop.torque_limit.copy()

    @property
    def commanded_torque(self) -> Array:
        """Joint torques that the last action asked for, within the limits (joints) [N m, N, N m]."""
        return np.array(self._loop.commanded_torque[0])

    @property
    def applied_torque(self) -> Array:
        """Joint torques that acted in the last step, late and noisy where the scenario says so (joints)."""
        return np.array(self.physics.torque[0])

    @property
    def control_frequency(self) -> float:
        """Actions a second [Hz]."""
        return self.config.control_frequency

    @property
    def info_fields(self) -> tuple[InfoField, ...]:
        """The numbers that `step` returns in `info`, with unit and meaning."""
        return self._loop.info_fields

    @property
    def duration(self) -> float:
        """Length of an episode [s]."""
        return self.config.duration

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: of the environment's generator; the same seed gives the same bits.
            options: values that replace what is drawn, as `task.reset_options` declares them.

        Returns:
            the observation (size) and an `info` with the time [s].

        Raises:
            UnknownNameError: an option that the task does not take.
            ShapeError: an option of another shape.
            NonFiniteError: NaN or infinity in an option.
            JointLimitError: a start or goal outside the joint limits.
        """
        checked = self._checked_options(options or {})
        super().reset(seed=seed)
        observation = self._loop.reset(_ONLY, [self.np_random], checked)
        if self.render_mode == "human":
            self.render()
        return observation[0], {"time": 0.0}

    def _checked_options(self, options: Mapping[str, Any]) -> dict[str, Array]:
        if not isinstance(options, Mapping):
            raise InvalidValueError("reset options", options, "a dictionary")
        checked = {}
        for name, value in options.items():
            if name not in self.task.reset_options:
                raise UnknownNameError("reset option", name, self.task.reset_options)
            vector = as_numbers(f"reset option {name!r}", value)
            shape = self.task.reset_options[name].shape
            if vector.shape != shape:
                raise ShapeError(f"reset option {name!r}", vector.shape, f"{shape}")
            if not np.isfinite(vector).all():
                raise NonFiniteError(f"reset option {name!r}", vector.tolist())
            checked[name] = vector
        return checked

    def step(self, action: NDArray[Any]) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """One control period.

        Args:
            action: (3) torques over their limits; beyond ±1 they are clipped and counted in `info`.

        Returns:
            observation (size), reward [s], whether the simulation diverged, whether the duration is
            over, and `info`: every reward term (they sum to the reward) [s], costs and time.

        Raises:
            ShapeError: another shape.
            NonFiniteError: NaN or infinity in the action.
            EpisodeError: before the first `reset`, or after a divergence.
        """
        values = as_numbers("action", action)
        if values.shape != self.action_space.shape:
            raise ShapeError("action", values.shape, f"{self.action_space.shape}")
        step = self._loop.step(values[None])
        if self.render_mode == "human":
            self.render()
        info = dict(zip(self._info_names, step.info[0].tolist(), strict=True))
        return (
            step.observation[0],
            float(step.reward[0]),
            bool(step.terminated[0]),
            bool(step.truncated[0]),
            info,
        )

    def render(self) -> NDArray[Any] | None:
        """Draw the arm, the goal, the reference path, the surface and the contact force.

        Returns:
            (height, width, 3) uint8 in mode `rgb_array`, (height, width) float32 distances [m] in mode
            `depth_array`, None in mode `human`, which shows a window.

        Raises:
            EpisodeError: the environment was made without a `render_mode`, or was never reset.
            RenderingError: nothing can be drawn on this machine.
        """
        config, physics = self.config, self.physics
        if config.render_mode is None:
            raise EpisodeError(
                f"render() needs a render_mode at make time, one of {', '.join(RENDER_MODES)}."
            )
        self._require_started("render")
        data = physics.data()
        if config.render_mode == "human":
            if not isinstance(self._renderer, WindowRenderer):
                self._renderer = WindowRenderer(physics.model(), physics.data(), config.camera)
            self._renderer.show(physics.model(), data, self._marks())
            return None
        if not isinstance(self._renderer, OffscreenRenderer):
            self._renderer = OffscreenRenderer(physics.model(), config.width, config.height, config.camera)
        return self._renderer.draw(data, self._marks(), depth=config.render_mode == "depth_array")

    def _marks(self) -> list[Mark]:
        marks = self.task.marks(0, self.duration)
        force = self.physics.contact_force[0]
        if np.any(force):
            marks.append(force_arrow(self.physics.tip_position[0], force))
        return marks

    def close(self) -> None:
        """Free window and drawing context."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def get_state(self) -> EnvState:
        """Copy of all that determines how the environment goes on, its generator included.

        Raises:
            EpisodeError: the environment was never reset.
        """
        self._require_started("get_state")
        generator = dict(self.np_random.bit_generator.state)
        return EnvState(self._loop.get_state(), self.config, self.options, generator)

    def set_state(self, state: EnvState) -> Array:
        """Go back to a saved state, bit for bit.

        Args:
            state: from `get_state` of this environment or of one made with the same keywords.

        Returns:
            the observation (size).

        Raises:
            InvalidValueError: a state of an environment of another kind, or made with other keywords.
        """
        if type(state.loop.rest["task"]) is not type(self.task):
            found = type(state.loop.rest["task"]).__name__
            raise InvalidValueError("saved state's task", found, type(self.task).__name__)
        if (replace(state.config, **_VIEW), state.options) != (replace(self.config, **_VIEW), self.options):
            raise InvalidValueError("saved state's keywords", (state.config, state.options), f"{self.config}")
        self.np_random.bit_generator.state = dict(state.generator)
        return np.asarray(self._loop.set_state(state.loop)[0])

    def _require_started(self, method: str) -> None:
        if not self._loop.started:
            raise EpisodeError(f"{method}() needs an episode: call reset() first.")

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_renderer": None}
