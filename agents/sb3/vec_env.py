"""`SB3VecEnv`: a `PRPVectorEnv` with the interface of Stable-Baselines3's `VecEnv`."""

import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.vec_env.base_vec_env import VecEnv, VecEnvStepReturn

from prp_gym.envs.vector import PRPVectorEnv
from prp_gym.envs.view import EnvironmentView
from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot.arrays import Array

Indices = int | Iterable[int] | None

_TRUNCATED = "TimeLimit.truncated"
_ONE_VALUE = ((),)


class SB3VecEnv(VecEnv):
    """N environments stepped together, with Stable-Baselines3's interface.

    The results are bit for bit those of `DummyVecEnv` with N single environments: rewards are float32; where
    an episode ends, the next one starts within the same step, and `info` is that of the last step, with its
    observation as `terminal_observation`. Every step returns new observations and infos.

    Args:
        together: vector environment, made with `autoreset_mode="SameStep"`.

    Attributes:
        together: vector environment.
        spec: specification with which Gymnasium made the vector environment; None if it did not.

    Raises:
        InvalidValueError: another autoreset mode.
    """

    actions: NDArray[Any]

    def __init__(self, together: PRPVectorEnv) -> None:
        mode, wanted = together.autoreset_mode, AutoresetMode.SAME_STEP
        if mode is not wanted:
            raise InvalidValueError("autoreset_mode", mode.value, f"{wanted.value} for Stable-Baselines3")
        self.together = together
        self.spec = together.spec
        self._names = tuple(field.name for field in together.info_fields)
        self._began = False
        super().__init__(together.num_envs, together.single_observation_space, together.single_action_space)
        self.metadata = {name: together.metadata[name] for name in ("render_modes", "render_fps")}

    def reset(self) -> Array:
        """Start an episode in every environment, with the seeds and options set since the last reset.

        Returns:
            the observations (N, size).

        Raises:
            ShapeError: another number of options than environments, or an option of another shape.
            UnknownNameError: an option that the task does not take.
            NonFiniteError: NaN or infinity in an option.
            JointLimitError: a start or goal outside the joint limits.
        """
        if len(self._options) != self.num_envs:
            raise ShapeError("options", (len(self._options),), f"one dictionary, or ({self.num_envs},)")
        each = [self.together.checked_options(options or {}, _ONE_VALUE) for options in self._options]
        observation = self._begin(each)
        self.reset_infos = self._rows(self.together.loop.start_info().T)
        self._reset_seeds()
        self._reset_options()
        return observation

    def _begin(self, each: Sequence[Mapping[str, Array]]) -> Array:
        """Start the episodes, those with the same options together, and return all observations."""
        groups: dict[tuple[str, ...], list[int]] = {}
        for index, options in enumerate(each):
            groups.setdefault(tuple(sorted(options)), []).append(index)
        if len(groups) > 1 and not self._began:  # the first reset must include every environment
            self.together.reset(seed=self._seeds)
        self._began = True
        for names, members in groups.items():
            mask = np.zeros(self.num_envs, dtype=np.bool_)
            mask[members] = True
            given = [each[index if mask[index] else members[0]] for index in range(self.num_envs)]
            values = {name: np.stack([options[name][0] for options in given]) for name in names}
            observation, _ = self.together.reset(seed=self._seeds, options={**values, "reset_mask": mask})
        return observation

    def step_async(self, actions: NDArray[Any]) -> None:
        """Store the actions (N, size), normalised by their bounds, for `step_wait`."""
        self.actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Advance one control period with the actions of `step_async`.

        Returns:
            observations (N, size), those of the new episode where one ended; rewards (N), float32;
            whether an episode ended (N); and one `info` for each environment.

        Raises:
            ShapeError: actions of another shape.
            NonFiniteError: NaN or infinity in an action.
            EpisodeError: before the first `reset`.
        """
        observation, reward, terminated, truncated, info = self.together.step(self.actions)
        done = terminated | truncated
        infos = self._rows([self._numbers(info, name, done) for name in self._names])
        for own, was_truncated in zip(infos, truncated.tolist(), strict=True):
            own[_TRUNCATED] = was_truncated  # an episode that diverged is not truncated
        for index in np.flatnonzero(done):
            infos[index]["terminal_observation"] = info["final_obs"][index]
            self.reset_infos[index] = {name: info[name][index] for name in self._names}
        return observation, reward.astype(np.float32), done, infos

    def _rows(self, columns: Iterable[Array]) -> list[dict[str, Any]]:
        """One `info` for each environment from the values of each number, (N) each."""
        return [dict(zip(self._names, row, strict=True)) for row in zip(*columns, strict=True)]

    @staticmethod
    def _numbers(info: Mapping[str, Any], name: str, done: NDArray[np.bool_]) -> Array:
        """A value of `info` for the step just taken (N), also where an episode ended with it."""
        values: Array = info[name]
        return np.where(done, info["final_info"][name], values) if "final_info" in info else values

    def close(self) -> None:
        """Free the rendering context."""
        self.together.close()

    def get_images(self) -> Sequence[NDArray[Any] | None]:
        """One rendered frame for each environment; None without `render_mode="rgb_array"`."""
        if self.render_mode != "rgb_array":
            warnings.warn(f"frames need render_mode='rgb_array'; it is {self.render_mode!r}", stacklevel=2)
            return [None] * self.num_envs
        return self.together.render()

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """An attribute of the selected environments, by default of all; see `EnvironmentView`."""
        return [view.get_wrapper_attr(attr_name) for view in self._views(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Set an attribute of the selected environments, by default of all, to one value."""
        for view in self._views(indices):
            view.set_wrapper_attr(attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: Indices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Results of a method of the selected environments, by default of all; see `EnvironmentView`."""
        found = [view.get_wrapper_attr(method_name) for view in self._views(indices)]
        return [method(*method_args, **method_kwargs) for method in found]

    def env_is_wrapped(
        self, wrapper_class: type[gymnasium.Wrapper[Any, Any, Any, Any]], indices: Indices = None
    ) -> list[bool]:
        """False for every environment: single environments in a vector environment have no wrappers."""
        return [False for _ in self._views(indices)]

    def _views(self, indices: Indices) -> list[EnvironmentView]:
        return [self.together.envs[index] for index in self._get_indices(indices)]
