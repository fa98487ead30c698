"""`PRPVectorEnv`: many environments of one task, stepped together on MuJoCo's native threads."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from prp_gym.envs.checks import as_numbers, whole
from prp_gym.envs.config import RENDER_MODES, parse_keywords
from prp_gym.envs.core.step import Step
from prp_gym.envs.generators import Generators, Seeds
from prp_gym.envs.loop_environment import EnvState, LoopEnvironment
from prp_gym.envs.vector_info import RESET_MASK, Mask, checked_mask, final_info, start_info, step_info
from prp_gym.envs.vector_keywords import OWN_KEYWORDS, parse_mode, parse_threads
from prp_gym.envs.view import EnvironmentView
from prp_gym.errors import EpisodeError, InvalidValueError, ShapeError
from prp_gym.robot.arrays import Array
from prp_gym.tasks.spec import TASKS

Steps = tuple[Array, Array, Mask, Mask, dict[str, Any]]


class VectorState(NamedTuple):
    """Saved environments, and which of them wait for their reset; see `PRPVectorEnv.get_state`."""

    environments: EnvState
    ended: Mask


class PRPVectorEnv(LoopEnvironment, gymnasium.vector.VectorEnv[Array, NDArray[Any], NDArray[Any]]):
    """N environments of one task.

    Environment i gives, bit for bit, what an environment of its own with the same seed and actions gives,
    whatever N and the number of threads. Observations, rewards and `info` are new arrays at every step.
    Up to 128 simulations keep a third of a megabyte each; more of them share what the threads need.

    Args:
        task: Id of a registered task, such as `PRP-Force-v0`.
        num_envs: N.
        num_threads: that step the physics; 0 takes all cores, one for four environments at most.
        autoreset_mode: when an episode that ended begins anew: with the next step (`NextStep`), within the
            same step (`SameStep`, the last observation is `info["final_obs"]`), or when `reset` is called
            with `options={"reset_mask": ...}` (`Disabled`).
        max_episode_steps: after which an episode is over at the latest, as Gymnasium's `TimeLimit` ends it;
            None for the `duration` alone.
        keywords: those of the single environment; every environment has the same.

    Attributes:
        generators: of the environments.

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
        self.config, self.options = parse_keywords(keywords, self.task_spec.entry.options, OWN_KEYWORDS)
        if max_episode_steps is not None:
            self.config = self.config.at_most(whole("max_episode_steps", max_episode_steps, 1))
        if self.config.render_mode == "human":
            modes = ", ".join(mode for mode in RENDER_MODES if mode != "human")
            raise InvalidValueError("render_mode of many environments", "human", f"{modes} or None")
        self.num_envs = whole("num_envs", num_envs, 1)
        threads = parse_threads(num_threads, self.num_envs)
        self._mode = parse_mode(autoreset_mode)
        self._loop = self.new_loop(self.num_envs, threads)
        self._names = tuple(field.name for field in self._loop.info_fields)
        self.generators = Generators(self.num_envs)
        self._ended = np.zeros(self.num_envs, dtype=np.bool_)
        self._describe()

    def _describe(self) -> None:
        """Gymnasium's attributes."""
        modes = [mode for mode in RENDER_MODES if mode != "human"]
        self.metadata = {"render_modes": modes, "render_fps": self.render_fps, "autoreset_mode": self._mode}
        self.render_mode = self.config.render_mode
        self.single_observation_space = self._loop.task.layout.space()
        self.single_action_space = self.make_action_space()
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)

    @cached_property
    def envs(self) -> tuple[EnvironmentView, ...]:
        """The environments one by one (N), to look at."""
        return tuple(EnvironmentView(self, index) for index in range(self.num_envs))

    @property
    def ground_truth(self) -> Array:
        """Ground truth (N, size), laid out as `task.ground_truth_layout`; policies see the observation."""
        return self._loop.ground_truth.copy()

    @property
    def commanded_torque(self) -> Array:
        """Joint torques that the last actions asked for, within the limits (N, joints) [N m, N, N m]."""
        return self._loop.commanded_torque.copy()

    @property
    def applied_torque(self) -> Array:
        """Joint torques that acted in the last step (N, joints) [N m, N, N m]."""
        return np.array(self.physics.torque)

    @property  # type: ignore[misc]
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """The environments' own generators (N)."""
        return self.generators.all

    @property
    def np_random_seed(self) -> tuple[int | None, ...]:  # type: ignore[override]
        """The seeds of the environments' generators (N)."""
        return self.generators.seeds

    def reset(
        self, *, seed: Seeds = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start an episode in every environment, or in some.

        Args:
            seed: of the generators: one number gives environment i the seed `seed + i`; or one an
                environment; None leaves a generator as it is.
            options: values that replace what is drawn, as `task.reset_options` declares them, one for
                all environments or one an environment (N, ...); and `reset_mask` (N), which environments to
                reset, all by default. The others go on as they were.

        Returns:
            the observations (N, size) and an `info` with the time [s].

        Raises:
            UnknownNameError: an option that the task does not take.
            ShapeError: an option or seeds of another shape.
            NonFiniteError: NaN or infinity in an option.
            InvalidValueError: a mask that is none, or that leaves out what was never reset; options that
                are no dictionary; a seed that is no whole number, or negative.
            JointLimitError: a start or goal outside the joint limits.
        """
        if not isinstance(options, Mapping | None):
            raise InvalidValueError("reset options", options, "a dictionary")
        target_impedance = dict(options or {})
        everyone = np.ones(self.num_envs, dtype=np.bool_)
        mask = checked_mask(target_impedance.pop(RESET_MASK, everyone), self.num_envs, self._loop.started)
        checked = self.checked_options(target_impedance, ((), (self.num_envs,)))
        seeds = self.generators.own_seeds(seed)
        for index in np.flatnonzero(mask):
            if seeds[index] is not None:
                self.generators.seed(int(index), seeds[index])
        observation = self._begin(mask, checked)
        self._ended[mask] = False
        return observation, start_info(mask)

    def _begin(self, mask: Mask, options: Mapping[str, Array]) -> Array:
        """Start episodes; the observations of all."""
        ids = np.flatnonzero(mask)
        generators = [self.generators[int(index)] for index in ids]
        return self._loop.reset(ids, generators, {name: values[ids] for name, values in options.items()})

    def step(self, actions: NDArray[Any]) -> Steps:
        """One control period of every environment.

        Args:
            actions: (N, size) their parts over their bounds; what is beyond ±1 is clipped, and torques that
                are so are counted in `info`. Those of environments that begin anew with this step do not
                count.

        Returns:
            observations (N, size), rewards (N) [s], whether a simulation diverged (N), whether a duration is
            over (N), and `info`: as a single environment's, an array (N) and a mask (N) a number.

        Raises:
            ShapeError: another shape.
            NonFiniteError: NaN or infinity in an action.
            EpisodeError: before the first `reset`; with autoreset disabled, after the end of an episode.
        """
        values = as_numbers("actions", actions)
        if values.shape != self.action_space.shape:
            raise ShapeError("actions", values.shape, f"{self.action_space.shape}")
        ended = self._ended
        waiting = bool(np.count_nonzero(ended))
        if waiting and self._mode is AutoresetMode.DISABLED:
            which = np.flatnonzero(ended).tolist()
            raise EpisodeError(f"the episodes of environments {which} have ended: reset them (reset_mask).")
        if self._mode is AutoresetMode.SAME_STEP:
            return self._same_step(self._loop.step(values))
        if waiting:
            return self._next_step(values, ended)
        return self._finished(self._loop.step(values), ~ended)

    def _finished(self, step: Step, stepped: Mask) -> Steps:
        """A step of some environments, after which nothing begins anew."""
        self._ended = step.terminated | step.truncated
        info = step_info(self._names, step.info, stepped)
        return step.observation, step.reward, step.terminated, step.truncated, info

    def _next_step(self, values: Array, begins: Mask) -> Steps:
        """A step in which some environments begin anew."""
        if begins.all():
            observation, nothing = self._begin(begins, {}), np.zeros(self.num_envs)
            self._ended = np.zeros_like(begins)
            return observation, nothing, ~begins, ~begins, start_info(begins)
        step = self._loop.step(values, begins)
        step = Step(
            self._begin(begins, {}),
            np.where(begins, 0.0, step.reward),
            step.terminated & ~begins,
            step.truncated & ~begins,
            step.info,
        )
        outcome = self._finished(step, ~begins)
        outcome[-1]["_time"] |= begins
        return outcome

    def _same_step(self, step: Step) -> Steps:
        """A step after which episodes that ended begin anew."""
        ended = step.terminated | step.truncated
        stepped = ~ended
        info = step_info(self._names, step.info, stepped)
        if stepped.all():
            return step.observation, step.reward, step.terminated, step.truncated, info
        info |= final_info(self._names, step.info, step.observation, ended)
        if "time" in info:
            info["_time"] |= ended
        else:
            info |= start_info(ended)
        return self._begin(ended, {}), step.reward, step.terminated, step.truncated, info

    def render(self) -> tuple[NDArray[Any], ...]:
        """A picture of every environment; see `PRPEnv.render`."""
        return tuple(self.frame(index) for index in range(self.num_envs))

    def call(self, name: str, *arguments: Any, **keywords: Any) -> tuple[Any, ...]:
        """An attribute of every environment, or what it returns where it is a method."""
        found = [view.get_wrapper_attr(name) for view in self.envs]
        return tuple(item(*arguments, **keywords) if callable(item) else item for item in found)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of every environment."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of every environment, to one value or, from a list or tuple, to one each.

        Raises:
            ShapeError: another number of values.
        """
        each = values if isinstance(values, (list, tuple)) else [values] * self.num_envs
        if len(each) != self.num_envs:
            raise ShapeError(f"values of {name!r}", (len(each),), f"one, or ({self.num_envs},)")
        for view, value in zip(self.envs, each, strict=True):
            view.set_wrapper_attr(name, value)

    def close_extras(self, **_: Any) -> None:
        """Free the drawing context."""
        self.close_renderer()

    def get_state(self) -> VectorState:
        """Copy of all that determines how the environments go on, their generators included.

        Raises:
            EpisodeError: never reset.
        """
        return VectorState(self.save(self.np_random), self._ended.copy())

    def set_state(self, state: VectorState) -> Array:
        """Go back to a saved state, bit for bit.

        Args:
            state: from `get_state` of these environments or of such made with the same keywords.

        Returns:
            the observations (N, size).

        Raises:
            InvalidValueError: no state of environments, one of environments of another kind or number, or
                made with other keywords; environments that wait for their reset where that is made in the
                same step.
        """
        if not isinstance(state, VectorState):
            raise InvalidValueError("saved state", type(state).__name__, "what get_state returned here")
        if self._mode is AutoresetMode.SAME_STEP and state.ended.any():
            which = np.flatnonzero(state.ended).tolist()
            raise InvalidValueError("saved state's ended environments", which, "none with SameStep autoreset")
        observation = self.restore(state.environments, self.np_random)
        self._ended = state.ended.copy()
        return observation
