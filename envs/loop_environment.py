"""The base of the single and the vector environment: keywords, task, loop, frames, saved states."""

import warnings
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from prp_gym.checks import as_numbers, check_finite, choice
from prp_gym.drawing.overlay import OverlayItem
from prp_gym.envs.action_mode import ActionField
from prp_gym.envs.config import RENDER_MODES, EnvConfig
from prp_gym.envs.core.info import InfoField
from prp_gym.envs.core.loop import EpisodeLoop
from prp_gym.envs.core.make_loop import make_loop
from prp_gym.envs.episode_spec import EpisodeSpec
from prp_gym.envs.frame_overlay import episode_overlay
from prp_gym.envs.saved_state import (
    EnvState,
    check_generators,
    check_like,
    check_parts,
    is_equal,
    restore_loop,
)
from prp_gym.envs.tip_history import TipHistory
from prp_gym.errors import EpisodeError, InvalidValueError, ShapeError
from prp_gym.physics.abstract_simulation import Simulation
from prp_gym.physics.rendering import OffscreenRenderer, WindowRenderer
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.robot.link import Link
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.setup import TaskNumbers, TaskSetup
from prp_gym.tasks.spec import TaskSpec
from prp_gym.tasks.task import Task

_VIEW: dict[str, Any] = {
    "render_mode": None,
    "width": 1,
    "height": 1,
    "camera": "top",
}  # keywords of rendering, which do not affect states


class LoopEnvironment:
    """N environments around one episode loop, with the keywords that they were made with."""

    config: EnvConfig
    options: object
    task_spec: TaskSpec
    spec = EpisodeSpec()
    _loop: EpisodeLoop
    _renderer: OffscreenRenderer | WindowRenderer | None = None
    _history: TipHistory | None = None

    def new_loop(self, num_envs: int, num_threads: int) -> EpisodeLoop:
        """Make another loop of N environments with these keywords."""
        return make_loop(self.make_task, self.config, num_envs, num_threads)

    def make_task(self, config: EnvConfig) -> Task:
        """Make the task at the control frequency of given keywords."""
        numbers = TaskNumbers.read(self.task_spec.numbers)
        period = 1.0 / config.control_frequency
        setup = TaskSetup(numbers, config.load_scenario(), self.options, period, config.engine)
        return Task(self.task_spec, setup)

    @property
    def loop(self) -> EpisodeLoop:
        """The episode loop, which counts time and connects physics and task."""
        return self._loop

    @property
    def observation_layout(self) -> ObservationLayout:
        """The layout of an observation, with the position of each field."""
        return self._loop.observation_layout

    @property
    def physics(self) -> Simulation:
        """The physics, with one simulation for each environment."""
        return self._loop.physics

    @property
    def task(self) -> Task:
        """The task: starts, references and errors."""
        return self._loop.task

    @property
    def arm(self) -> PRPArm | Link:
        """The nominal robot: the model that policies may use, whatever the plant of an episode is."""
        return self._loop.task.model

    @property
    def torque_limit(self) -> Array:
        """Joint torques at action 1 (joints) [N m, N, N m]."""
        return self._loop.torque_limit.copy()

    @property
    def control_frequency(self) -> float:
        """The control frequency, at which actions are taken [Hz]."""
        return self.config.control_frequency

    @property
    def info_fields(self) -> tuple[InfoField, ...]:
        """The numbers that `step` returns in `info`, with unit and meaning."""
        return self._loop.info_fields

    @property
    def duration(self) -> float:
        """Length of an episode [s]."""
        return self.config.duration

    @property
    def render_fps(self) -> int:
        """Frames per second that show the motion in real time, with one frame for each action; at least 1."""
        return max(1, round(self.config.control_frequency))

    @property
    def action_mode(self) -> str:
        """The name of the action mode."""
        return self.config.action_mode

    @property
    def action_fields(self) -> tuple[ActionField, ...]:
        """The fields of an action, with units and bounds."""
        return self._loop.action_fields

    def make_action_space(self) -> Box:
        """Make the action space of one environment: action fields normalised by their bounds."""
        return Box(-1.0, 1.0, (self._loop.action_size,), np.float32)

    def ground_truth_of(self, index: int) -> Array:
        """The ground truth of one environment (size), laid out as `task.ground_truth_layout`."""
        return np.array(self._loop.ground_truth[index])

    @property
    def truth(self) -> Array:
        """Deprecated name of `ground_truth`."""
        warnings.warn("env.truth is now env.ground_truth", DeprecationWarning, stacklevel=2)
        return np.array(getattr(self, "ground_truth"))  # noqa: B009 (of the subclasses)

    def commanded_torque_of(self, index: int) -> Array:
        """Joint torques commanded in the last step of one environment, limited (joints) [N m, N, N m]."""
        return np.array(self._loop.commanded_torque[index])

    def applied_torque_of(self, index: int) -> Array:
        """Joint torques applied in the last step of one environment (joints) [N m, N, N m]."""
        return np.array(self.physics.torque[index])

    def checked_options(
        self, options: Mapping[str, Any], leads: tuple[tuple[int, ...], ...]
    ) -> dict[str, Array]:
        """Validate reset options.

        Args:
            options: Reset options by name.
            leads: Leading dimensions that values may have: () is one value for all environments, (N) is one
                for each of them.

        Returns:
            Values (N, *shape) by name.

        Raises:
            UnknownNameError: an option that the task does not have.
            ShapeError: an option of another shape.
            NonFiniteError: NaN or infinity in an option.
            InvalidValueError: options that are not a dictionary, or values that are not numbers.
        """
        if not isinstance(options, Mapping):
            raise InvalidValueError("reset options", options, "a dictionary")
        checked = {}
        for name, value in options.items():
            choice("reset option", name, self.task.reset_options)
            values = as_numbers(f"reset option {name!r}", value)
            shape = self.task.reset_options[name].shape
            allowed = [(*lead, *shape) for lead in leads]
            if values.shape not in allowed:
                raise ShapeError(f"reset option {name!r}", values.shape, " or ".join(map(str, allowed)))
            check_finite(f"reset option {name!r}", values)
            checked[name] = np.broadcast_to(values, (self._loop.num_envs, *shape))
        return checked

    def frame(self, index: int) -> NDArray[Any]:
        """Draw one environment: colours (height, width, 3) uint8, or distances (height, width) float32 [m].

        Raises:
            EpisodeError: environments that were made without a `render_mode`, or never reset.
            RenderingError: this machine cannot draw.
        """
        config, physics = self.config, self.physics
        self.require_rendering()
        if not isinstance(self._renderer, OffscreenRenderer):
            self._renderer = OffscreenRenderer(physics.model(), config.width, config.height, config.camera)
        depth = config.render_mode == "depth_array"
        return self._renderer.draw(physics.data(index), self.overlay(index), depth=depth)

    def require_rendering(self) -> None:
        """Refuse to draw without a `render_mode` or an episode.

        Raises:
            EpisodeError: environments that were made without a `render_mode`, or never reset.
        """
        if self.config.render_mode is None:
            raise EpisodeError(
                f"render() needs a render_mode at make time, one of {', '.join(RENDER_MODES)}."
            )
        self.require_started("render")

    def overlay(self, index: int) -> list[OverlayItem]:
        """The overlay of one environment's frames: reference, trail of the tip, forces, phase of contact."""
        return episode_overlay(self._loop, self._tip_history(), index)

    def record_tip(self) -> None:
        """Record where the tips are, for the trails in later frames; environments that are drawn call it."""
        self._tip_history().record(self._loop)

    def _tip_history(self) -> TipHistory:
        if self._history is None:
            self._history = TipHistory(self._loop)
        return self._history

    def require_started(self, method: str) -> None:
        """Refuse a method that needs an episode before the first one has begun.

        Raises:
            EpisodeError: no episode has begun.
        """
        if not self._loop.started:
            raise EpisodeError(f"{method}() needs an episode: call reset() first.")

    def save(self, generators: tuple[np.random.Generator, ...]) -> EnvState:
        """A copy of the complete state of the environments, their generators included.

        Raises:
            EpisodeError: environments that were never reset.
        """
        self.require_started("get_state")
        states = tuple(dict(generator.bit_generator.state) for generator in generators)
        return EnvState(self._loop.get_state(), self.config, self.options, states)

    def restore(self, state: EnvState, generators: tuple[np.random.Generator, ...]) -> Array:
        """Restore a saved state, bit for bit.

        Args:
            state: State from `save` of these environments or of others made with the same keywords.
            generators: Generators of the environments (N), whose states are restored too.

        Returns:
            Observations (N, size).

        Raises:
            InvalidValueError: a value that is not a saved state, or a state of another kind or number of
                environments or of ones made with other keywords, or a damaged one.
            PRPError: a damaged state; nothing is changed.
        """
        self.require_same(state)
        check_like(state.loop, self._loop)
        check_generators(state.generators, generators)
        observation = restore_loop(state.loop, self._loop)
        for generator, saved in zip(generators, state.generators, strict=True):
            generator.bit_generator.state = dict(saved)
        return observation

    def require_same(self, state: EnvState) -> None:
        """Refuse the state of another task, of other keywords, or of another number of environments.

        Raises:
            InvalidValueError: such a state, or a value that is not a saved state.
        """
        check_parts(state)
        found = getattr(getattr(state.loop.rest.get("task"), "spec", None), "id", None)
        if not isinstance(found, str) or found != self.task.environment_id:
            raise InvalidValueError("saved state's task", found, self.task.environment_id)
        theirs = replace(state.config, **_VIEW), state.options
        if not is_equal(theirs, (replace(self.config, **_VIEW), self.options)):
            raise InvalidValueError("saved state's keywords", (state.config, state.options), f"{self.config}")
        waiting = state.loop.rest.get("_needs_reset")
        count = len(waiting) if isinstance(waiting, np.ndarray) and waiting.ndim else waiting
        if not isinstance(count, int) or count != self._loop.num_envs:
            raise InvalidValueError("state's number of environments", count, f"{self._loop.num_envs}")

    def close_renderer(self) -> None:
        """Close the window and free the rendering context."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_renderer": None}
