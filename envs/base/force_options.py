"""The desired force of a force task: its keyword, and how it is drawn."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from prp_gym.envs.base.surface_options import SurfaceOptions
from prp_gym.envs.checks import within
from prp_gym.envs.config import describe
from prp_gym.physics.surface import Surface
from prp_gym.robot.arrays import Array
from prp_gym.tasks.parts import ResetOption

FORCE_BOUNDS = (1e-3, 1e3)  # [N]
_FORCE_OPTION = ResetOption((), "N", "force to press with, along the surface's inward normal")


def check_force(value: object) -> float:
    """A desired force as a number [N].

    Raises:
        InvalidValueError: not a number within `FORCE_BOUNDS`.
    """
    return within("desired_force", value, FORCE_BOUNDS, _FORCE_OPTION.unit)


@dataclass(frozen=True)
class ForceOptions(SurfaceOptions):
    """The surface, and the force to press with.

    Raises:
        InvalidValueError: a force outside `FORCE_BOUNDS`.
    """

    desired_force: float | None = field(
        default=None, metadata=describe(_FORCE_OPTION.unit, _FORCE_OPTION.description + "; None draws it")
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.desired_force is not None:
            object.__setattr__(self, "desired_force", check_force(self.desired_force))


class ForceSampler(ABC):
    """Draws the desired force of an episode by the tip on its surface.

    Attributes:
        reset_options: Values that `reset(options=...)` takes, by name.
    """

    reset_options: ClassVar[Mapping[str, ResetOption]] = {}

    @abstractmethod
    def draw(self, drawn: Mapping[str, Array], options: Mapping[str, Array], surface: Surface) -> Array:
        """The desired force (3) [N] in the world frame.

        Args:
            drawn: Values drawn from the task's ranges, by name.
            options: Validated reset options by name.
            surface: Surface of the episode, one plane.
        """


class NoForce(ForceSampler):
    """No force is desired."""

    def draw(self, drawn: Mapping[str, Array], options: Mapping[str, Array], surface: Surface) -> Array:
        """Zero."""
        return np.zeros(3)


class NormalForce(ForceSampler):
    """A force along the inward normal; a drawn one presses no deeper than the greatest depth.

    Args:
        options: Keywords of the task.
    """

    reset_options: ClassVar[Mapping[str, ResetOption]] = {"desired_force": _FORCE_OPTION}

    def __init__(self, options: ForceOptions) -> None:
        self._options = options

    def draw(self, drawn: Mapping[str, Array], options: Mapping[str, Array], surface: Surface) -> Array:
        """See `ForceSampler.draw`."""
        deepest = float(surface.stiffness[0]) * float(drawn["greatest_depth"][0])
        magnitude = min(float(drawn["desired_force"][0]), deepest)
        if self._options.desired_force is not None:
            magnitude = self._options.desired_force
        if "desired_force" in options:
            magnitude = check_force(options["desired_force"])
        return -magnitude * np.array(surface.normal[0])
