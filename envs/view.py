"""A view of one environment of a vector environment."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import EpisodeError
from prp_gym.robot.arrays import Array

if TYPE_CHECKING:
    import gymnasium

    from prp_gym.envs.vector import PRPVectorEnv

_SHARED = frozenset(
    (
        "action_fields",
        "action_mode",
        "arm",
        "config",
        "control_frequency",
        "duration",
        "info_fields",
        "metadata",
        "observation_layout",
        "options",
        "render_mode",
        "spec",
        "task",
        "torque_limit",
    )
)
"""Attributes that all environments of a vector environment share."""


class EnvironmentView:
    """One environment of a vector environment, with the attributes of a single one.

    Shared attributes (spaces, task, limits, ...) are those of the vector environment, which alone can reset
    and step its environments. Users may add attributes of their own.

    Args:
        together: Vector environment.
        index: Index of this environment.
    """

    def __init__(self, together: "PRPVectorEnv", index: int) -> None:
        self._together = together
        self.index = index

    @property
    def unwrapped(self) -> "EnvironmentView":
        """The view itself."""
        return self

    @property
    def ground_truth(self) -> Array:
        """Ground truth (size), laid out as `task.ground_truth_layout`."""
        return self._together.ground_truth_of(self.index)

    @property
    def commanded_torque(self) -> Array:
        """Joint torques commanded by the last action, within the limits (joints) [N m, N, N m]."""
        return self._together.commanded_torque_of(self.index)

    @property
    def applied_torque(self) -> Array:
        """Joint torques applied in the last step (joints) [N m, N, N m]."""
        return self._together.applied_torque_of(self.index)

    @property
    def np_random(self) -> np.random.Generator:
        """The generator of this environment."""
        return self._together.generators[self.index]

    @property
    def np_random_seed(self) -> int | None:
        """The seed of that generator."""
        return self._together.generators.seed_of(self.index)

    @property
    def observation_space(self) -> "gymnasium.Space[Any]":
        """The observation space of one environment."""
        return self._together.single_observation_space

    @property
    def action_space(self) -> "gymnasium.Space[Any]":
        """The action space of one environment."""
        return self._together.single_action_space

    def render(self) -> NDArray[Any]:
        """Draw a frame of this environment; see `PRPEnv.render`."""
        return self._together.frame(self.index)

    def reset(self, **_: object) -> None:
        """Refused: environments are reset through their vector environment."""
        raise EpisodeError(
            "one of many environments cannot be reset by itself: call the vector environment's"
            " reset(options={'reset_mask': ...})."
        )

    def step(self, _: object) -> None:
        """Refused: environments are stepped through their vector environment."""
        raise EpisodeError(
            "one of many environments cannot be stepped by itself: call the vector environment's step."
        )

    def close(self) -> None:
        """Do nothing: a view owns no resources."""

    def get_wrapper_attr(self, name: str) -> Any:
        """An attribute by its name; there are no wrappers."""
        return getattr(self, name)

    def has_wrapper_attr(self, name: str) -> bool:
        """Whether there is such an attribute."""
        return hasattr(self, name)

    def set_wrapper_attr(self, name: str, value: Any, *, force: bool = True) -> bool:
        """Set an attribute by its name, a new one if forced; returns whether it was set."""
        if force or hasattr(self, name):
            setattr(self, name, value)
            return True
        return False

    def __setattr__(self, name: str, value: Any) -> None:
        if name in _SHARED:
            raise AttributeError(f"{name!r} is shared by all environments and cannot be set for one of them")
        super().__setattr__(name, value)

    def __getattr__(self, name: str) -> Any:
        if name not in _SHARED:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        return getattr(self._together, name)
