"""`PRPEnv`: the Gymnasium environment, an episode loop with N = 1."""

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import PLAIN, as_numbers, random_seed
from prp_gym.envs.config import RENDER_MODES, parse_keywords
from prp_gym.envs.core.loop import EpisodeLoop
from prp_gym.envs.core.single_period import SingleStep
from prp_gym.envs.loop_environment import LoopEnvironment
from prp_gym.envs.saved_state import EnvState
from prp_gym.errors import RenderingError, ShapeError
from prp_gym.physics.rendering import NO_DISPLAY, WindowRenderer, has_display
from prp_gym.robot.arrays import Array
from prp_gym.tasks.spec import TASKS

_ONLY = np.array([0])
_ONE_VALUE = ((),)  # leading dimensions of a reset option


class PRPEnv(LoopEnvironment, gymnasium.Env[Array, NDArray[Any]]):
    """One robot and one task.

    The action space is Box(-1, 1, (size,), float32): joint torques normalised by the actuator limits, or the
    inputs of another `action_mode`. Observations are flat float64 vectors, which `observation_layout` splits
    into named fields.

    Args:
        task: Id of a registered task, such as `PRP-Force-v0`.
        keywords: Common keywords, see `EnvConfig`, and the task's own.

    Raises:
        PRPError: a keyword that does not exist, a value that is not allowed, or `human` without a display.
    """

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES), "render_fps": 500}  # noqa: RUF012

    def __init__(self, task: str, **keywords: object) -> None:
        self.task_spec = TASKS.find(task)
        self.config, self.options = parse_keywords(keywords, self.task_spec.entry.options)
        modes = [mode for mode in RENDER_MODES if mode != "human" or has_display()]
        self.metadata = {"render_modes": modes, "render_fps": self.render_fps}
        if self.config.render_mode == "human" and not has_display():
            raise RenderingError(NO_DISPLAY)
        self.render_mode = self.config.render_mode
        self._loop = self.make_loop()
        self._info_names = tuple(field.name for field in self._loop.info_fields)
        self.observation_space = self.observation_layout.space()
        self.action_space = self.make_action_space()
        self._action_shape = self.action_space.shape

    def make_loop(self, num_envs: int = 1, num_threads: int = 1) -> EpisodeLoop:
        """Make another loop of environments with the keywords of this one."""
        return self.new_loop(num_envs, num_threads)

    @property
    def ground_truth(self) -> Array:
        """Ground truth (size), laid out as `task.ground_truth_layout`; policies see the observation."""
        return self.ground_truth_of(0)

    @property
    def commanded_torque(self) -> Array:
        """Joint torques commanded by the last action, within the limits (joints) [N m, N, N m]."""
        return self.commanded_torque_of(0)

    @property
    def applied_torque(self) -> Array:
        """Joint torques applied in the last step, after actuation delay and noise (joints) [N m, N, N m]."""
        return self.applied_torque_of(0)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: Seed of the environment's generator; equal seeds give equal episodes, bit for bit.
            options: Values that replace drawn ones, as `task.reset_options` declares them.

        Returns:
            The observation (size), and an `info` with the same numbers as that of `step`: the contact force
            [N], and zero for rewards, costs and time, since nothing has happened yet.

        Raises:
            InvalidValueError: a seed that is negative or not a whole number; options that are not a
                dictionary, or values that are not numbers.
            UnknownNameError: an option that the task does not have.
            ShapeError: an option of another shape.
            NonFiniteError: NaN or infinity in an option.
            JointLimitError: a start or goal outside the joint limits.
        """
        checked = self.checked_options({} if options is None else options, _ONE_VALUE)
        super().reset(seed=None if seed is None else random_seed("seed", seed))
        observation = self._loop.reset(_ONLY, [self.np_random], checked)
        if self.render_mode == "human":
            self.render()
        return observation[0], self._info(self._loop.start_info()[0])

    def step(self, action: NDArray[Any]) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Advance by one control period.

        Args:
            action: Action (size), normalised by the bounds of its fields; values beyond ±1 are clipped, and
                saturated torques are counted in `info`.

        Returns:
            Observation (size), reward, whether the simulation diverged, whether the duration is over, and
            `info`: every reward term (their sum is the reward), costs and time.

        Raises:
            ShapeError: an action of another shape.
            NonFiniteError: NaN or infinity in the action.
            EpisodeError: a step before the first `reset`, or after a divergence.
        """
        results = None
        if type(action) is np.ndarray and action.dtype in PLAIN and action.shape == self._action_shape:
            results = self._loop.step_alone(action)
        observation, reward, terminated, truncated, numbers = results or self._checked_step(action)
        if self.render_mode is not None:
            self.record_tip()
            if self.render_mode == "human":
                self.render()
        return observation, reward, terminated, truncated, self._info(numbers)

    def _checked_step(self, action: NDArray[Any]) -> SingleStep:
        """Advance by one control period, with an action of any kind; see `step`."""
        values = as_numbers("action", action)
        if values.shape != self._action_shape:
            raise ShapeError("action", values.shape, f"{self._action_shape}")
        observation, reward, terminated, truncated, numbers = self._loop.step(values[None])
        return observation[0], reward.item(), terminated.item(), truncated.item(), numbers[0]

    def _info(self, numbers: Array) -> dict[str, Any]:
        """The `info` of the one environment, in NumPy's scalars, from its numbers (fields)."""
        return dict(zip(self._info_names, numbers))  # noqa: B905 (`strict` takes time in every step)

    def render(self) -> NDArray[Any] | None:
        """Draw the robot, its reference, the trail of the tip, the surface and the forces.

        Returns:
            Colours (height, width, 3) uint8 in mode `rgb_array`, distances (height, width) float32 [m] in
            mode `depth_array`, None in mode `human`, which shows a window.

        Raises:
            EpisodeError: the environment was made without a `render_mode`, or was never reset.
            RenderingError: this machine cannot draw.
        """
        if self.render_mode != "human":
            return self.frame(0)
        self.require_rendering()
        physics = self.physics
        if not isinstance(self._renderer, WindowRenderer):
            self._renderer = WindowRenderer(physics.model(), physics.data(), self.config.camera)
        self._renderer.show(physics.model(), physics.data(), self.overlay(0))
        return None

    def close(self) -> None:
        """Close the window and free the rendering context."""
        self.close_renderer()

    def get_state(self) -> EnvState:
        """A copy of the complete state of the environment, its generator included.

        Raises:
            EpisodeError: the environment was never reset.
        """
        return self.save((self.np_random,))

    def set_state(self, state: EnvState) -> Array:
        """Restore a saved state, bit for bit.

        Args:
            state: State from `get_state` of this environment or of one made with the same keywords.

        Returns:
            The observation (size).

        Raises:
            InvalidValueError: a state of another kind of environment, or of one made with other keywords.
        """
        return np.asarray(self.restore(state, (self.np_random,))[0])
