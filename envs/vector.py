"""`PRPVectorEnv`: N environments of one task, stepped together on MuJoCo's native threads."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from prp_gym.checks import as_numbers, whole
from prp_gym.envs.core.step import Step
from prp_gym.envs.generators import Generators, Seeds
from prp_gym.envs.loop_environment import LoopEnvironment
from prp_gym.envs.saved_state import VectorState
from prp_gym.envs.vector_info import (
    RESET_MASK,
    Mask,
    checked_ended,
    checked_mask,
    final_info,
    masked_info,
)
from prp_gym.envs.vector_keywords import (
    FRAME_MODES,
    MOST_ENVIRONMENTS,
    parse_config,
    parse_mode,
    parse_threads,
)
from prp_gym.envs.view import EnvironmentView
from prp_gym.errors import EpisodeError, InvalidValueError, ShapeError
from prp_gym.robot.arrays import Array
from prp_gym.tasks.spec import TASKS

Steps = tuple[Array, Array, Mask, Mask, dict[str, Any]]


class PRPVectorEnv(LoopEnvironment, gymnasium.vector.VectorEnv[Array, NDArray[Any], NDArray[Any]]):
    """N environments of one task.

    Environment i gives the same results, bit for bit, as a single environment with the same seed and actions,
    whatever N and the number of threads. Observations, rewards and `info` are new arrays at every step. Up to
    128 simulations take a third of a megabyte of memory each; larger numbers share the memory of the threads.

    Args:
        task: Id of a registered task, such as `PRP-Force-v0`.
        num_envs: Number of environments N.
        num_threads: Number of threads of the physics; 0 takes all cores, at least four environments on each.
        autoreset_mode: When an environment is reset after the end of its episode: in the next step
            (`NextStep`), in the same step (`SameStep`; the last observation is `info["final_obs"]`), or when
            `reset` is called with `options={"reset_mask": ...}` (`Disabled`).
        max_episode_steps: Largest number of steps in an episode, as with Gymnasium's `TimeLimit`; None leaves
            the `duration` alone.
        keywords: Keywords of the single environment, the same for every environment.

    Attributes:
        autoreset_mode: When an environment is reset after the end of its episode.
        generators: Random generators of the environments.

    Raises:
        PRPError: a keyword that does not exist or a value that is not allowed.
    """

    def __init__(
        self,
        task: str,
        num_envs: int = 1,
        num_threads: int = 0,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        max_episode_steps: int | None = None,
        **keywords: object,
    ) -> None:
        self.task_spec = TASKS.find(task)
        own_options = self.task_spec.entry.options
        self.config, self.options = parse_config(keywords, own_options, max_episode_steps)
        self.num_envs = whole("num_envs", num_envs, 1, MOST_ENVIRONMENTS)
        threads = parse_threads(num_threads, self.num_envs)
        self.autoreset_mode = parse_mode(autoreset_mode)
        self._loop = self.new_loop(self.num_envs, threads)
        self._names = tuple(field.name for field in self._loop.info_fields)
        self.generators = Generators(self.num_envs)
        self._ended = np.zeros(self.num_envs, dtype=np.bool_)
        self._describe()

    def _describe(self) -> None:
        """Set the attributes that Gymnasium expects."""
        self.metadata = {
            "render_modes": list(FRAME_MODES),
            "render_fps": self.render_fps,
            "autoreset_mode": self.autoreset_mode,
        }
        self.render_mode = self.config.render_mode
        self.single_observation_space = self.observation_layout.space()
        self.single_action_space = self.make_action_space()
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)

    @cached_property
    def envs(self) -> tuple[EnvironmentView, ...]:
        """Views of the single environments (N)."""
        return tuple(EnvironmentView(self, index) for index in range(self.num_envs))

    @property
    def ground_truth(self) -> Array:
        """Ground truth (N, size), laid out as `task.ground_truth_layout`; policies see the observation."""
        return self._loop.ground_truth.copy()

    @property
    def commanded_torque(self) -> Array:
        """Joint torques commanded by the last actions, limited (N, joints) [N m, N, N m]."""
        return self._loop.commanded_torque.copy()

    @property
    def applied_torque(self) -> Array:
        """Joint torques applied in the last step (N, joints) [N m, N, N m]."""
        return np.array(self.physics.torque)

    @property  # type: ignore[misc]
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """The generators of the environments (N)."""
        return self.generators.all

    @property
    def np_random_seed(self) -> tuple[int | None, ...]:  # type: ignore[override]
        """The seeds of the generators (N)."""
        return self.generators.seeds

    def reset(
        self, *, seed: Seeds = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start new episodes in all environments, or in some.

        Args:
            seed: Seed of the generators: from one number, environment i takes `seed + i`; otherwise one for
                each environment; None leaves a generator as it is.
            options: Values that replace drawn ones, as `task.reset_options` declares them, one for all
                environments or one for each (N, ...); and `reset_mask` (N), the environments to reset, all by
                default. The others continue their episodes.

        Returns:
            Observations (N, size), and an `info` with the numbers of `step` for the environments that are
            reset: the contact force [N], and zero for rewards, costs and time.

        Raises:
            UnknownNameError: an option that the task does not have.
            ShapeError: an option or seeds of another shape.
            NonFiniteError: NaN or infinity in an option.
            InvalidValueError: a value that is not a mask, or a mask without an environment that was never
                reset; options that are not a dictionary; a seed that is negative or not a whole number.
            JointLimitError: a start or goal outside the joint limits.
        """
        if not isinstance(options, Mapping | None):
            raise InvalidValueError("reset options", options, "a dictionary")
        requested = dict(options or {})
        everyone = np.ones(self.num_envs, dtype=np.bool_)
        mask = checked_mask(requested.pop(RESET_MASK, everyone), self.num_envs, self._loop.started)
        checked = self.checked_options(requested, ((), (self.num_envs,)))
        seeds = self.generators.own_seeds(seed)
        for index in np.flatnonzero(mask):
            if seeds[index] is not None:
                self.generators.seed(int(index), seeds[index])
        observation = self._begin(mask, checked)
        self._ended[mask] = False
        return observation, masked_info(self._names, self._loop.start_info(), mask)

    def _begin(self, mask: Mask, options: Mapping[str, Array]) -> Array:
        """Start new episodes in some environments; returns the observations of all."""
        ids = np.flatnonzero(mask)
        generators = [self.generators[int(index)] for index in ids]
        return self._loop.reset(ids, generators, {name: values[ids] for name, values in options.items()})

    def step(self, actions: NDArray[Any]) -> Steps:
        """Advance every environment by one control period.

        Args:
            actions: Actions (N, size), normalised by the bounds of their fields; values beyond ±1 are
                clipped, and saturated torques are counted in `info`. Actions of environments that are reset
                in this step are ignored.

        Returns:
            Observations (N, size), rewards (N), whether each simulation diverged (N), whether each
            duration is over (N), and `info`: for each number of a single one, an array and a mask (N).

        Raises:
            ShapeError: actions of another shape.
            NonFiniteError: NaN or infinity in an action.
            EpisodeError: a step before the first `reset`, or, without autoreset, after an episode's end.
        """
        values = as_numbers("actions", actions)
        if values.shape != self.action_space.shape:
            raise ShapeError("actions", values.shape, f"{self.action_space.shape}")
        steps = self._advance(values)
        if self.render_mode is not None:
            self.record_tip()
        return steps

    def _advance(self, values: Array) -> Steps:
        """A step, with the resets that the mode of autoreset asks for."""
        ended = self._ended
        waiting = bool(np.count_nonzero(ended))
        if waiting and self.autoreset_mode is AutoresetMode.DISABLED:
            which = np.flatnonzero(ended).tolist()
            raise EpisodeError(f"the episodes of environments {which} have ended: reset them (reset_mask).")
        if self.autoreset_mode is AutoresetMode.SAME_STEP:
            return self._same_step(self._loop.step(values))
        if waiting:
            return self._next_step(values, ended)
        return self._finished(self._loop.step(values))

    def _finished(self, step: Step) -> Steps:
        """The results of a step, after which no environment is reset."""
        self._ended = step.terminated | step.truncated
        return step.observation, step.reward, step.terminated, step.truncated, self._info(step.info)

    def _info(self, values: Array) -> dict[str, Any]:
        """The `info` of all environments from their numbers (N, fields)."""
        return masked_info(self._names, values, np.ones(self.num_envs, dtype=np.bool_))

    def _next_step(self, values: Array, begins: Mask) -> Steps:
        """A step in which some environments are reset."""
        if begins.all():
            observation, zero = self._begin(begins, {}), np.zeros(self.num_envs)
            return self._finished(Step(observation, zero, ~begins, ~begins, self._loop.start_info()))
        step = self._loop.step(values, begins)
        return self._finished(
            Step(
                self._begin(begins, {}),
                np.where(begins, 0.0, step.reward),
                step.terminated & ~begins,
                step.truncated & ~begins,
                np.where(begins[:, None], self._loop.start_info(), step.info),
            )
        )

    def _same_step(self, step: Step) -> Steps:
        """A step after which the environments whose episodes ended are reset."""
        ended = step.terminated | step.truncated
        if not np.count_nonzero(ended):
            return step.observation, step.reward, step.terminated, step.truncated, self._info(step.info)
        final = final_info(self._names, step.info, step.observation, ended)
        observation = self._begin(ended, {})
        info = self._info(np.where(ended[:, None], self._loop.start_info(), step.info))
        return observation, step.reward, step.terminated, step.truncated, info | final

    def render(self) -> tuple[NDArray[Any], ...]:
        """Draw a frame of every environment; see `PRPEnv.render`."""
        return tuple(self.frame(index) for index in range(self.num_envs))

    def call(self, name: str, *arguments: Any, **keywords: Any) -> tuple[Any, ...]:
        """An attribute of every environment, or its result where it is a method."""
        found = [view.get_wrapper_attr(name) for view in self.envs]
        return tuple(item(*arguments, **keywords) if callable(item) else item for item in found)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of every environment."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of every environment, to one value or, from a list or tuple, to one each.

        Raises:
            ShapeError: a number of values other than N.
        """
        each = values if isinstance(values, (list, tuple)) else [values] * self.num_envs
        if len(each) != self.num_envs:
            raise ShapeError(f"values of {name!r}", (len(each),), f"one, or ({self.num_envs},)")
        for view, value in zip(self.envs, each, strict=True):
            view.set_wrapper_attr(name, value)

    def close_extras(self, **_: Any) -> None:
        """Free the rendering context."""
        self.close_renderer()

    def get_state(self) -> VectorState:
        """A copy of the complete state of the environments, their generators included.

        Raises:
            EpisodeError: environments that were never reset.
        """
        return VectorState(self.save(self.np_random), self._ended.copy())

    def set_state(self, state: VectorState) -> Array:
        """Restore a saved state, bit for bit.

        Args:
            state: State from `get_state` of these environments or of others made with the same keywords.

        Returns:
            Observations (N, size).

        Raises:
            InvalidValueError: a value that is not a saved state, or a state of another kind or number of
                environments or of ones made with other keywords; environments that wait for their reset in
                mode `SameStep`, where none waits.
        """
        if not isinstance(state, VectorState):
            raise InvalidValueError(
                "saved state", type(state).__name__, "a VectorState, from get_state of such an environment"
            )
        self.require_same(state.environments)
        ended = checked_ended(state.ended, self.num_envs, self.autoreset_mode)
        observation = self.restore(state.environments, self.np_random)
        self._ended = ended.copy()
        return observation
