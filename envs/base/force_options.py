"""The desired force of a force task: its keyword, its reset option and its sampler."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from prp_gym.checks import each_within, within
from prp_gym.envs.base.surface_options import SurfaceOptions
from prp_gym.envs.config import describe
from prp_gym.physics.surface import Surface
from prp_gym.robot.arrays import Array
from prp_gym.tasks.parts import ResetOption

FORCE_BOUNDS = (1e-3, 1e3)  # [N]
_FORCE_OPTION = ResetOption((), "N", "magnitude of the desired force along the surface's inward normal")


def check_force(value: object) -> float:
    """Validate a desired force, as a number [N].

    Raises:
        InvalidValueError: a value that is not a number within `FORCE_BOUNDS`.
    """
    return within("desired_force", value, FORCE_BOUNDS, _FORCE_OPTION.unit)


@dataclass(frozen=True)
class ForceOptions(SurfaceOptions):
    """Keywords of a force task: the surface and the desired force.

    Raises:
        InvalidValueError: a force outside `FORCE_BOUNDS`.
    """

    desired_force: float | None = field(
        default=None,
        metadata=describe(_FORCE_OPTION.unit, _FORCE_OPTION.description + "; drawn at every reset if None"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.desired_force is not None:
            object.__setattr__(self, "desired_force", check_force(self.desired_force))


class ForceSampler(ABC):
    """Draws the desired force of the tip on the surface for an episode.

    Attributes:
        reset_options: Values that `reset(options=...)` takes, by name.
    """

    reset_options: ClassVar[Mapping[str, ResetOption]] = {}

    @abstractmethod
    def draw(self, drawn: Mapping[str, Array], options: Mapping[str, Array], surface: Surface) -> Array:
        """The desired forces (n, 3) [N] in the world frame.

        Args:
            drawn: Values (n, size) drawn from the task's ranges, by name.
            options: Validated reset options (n, ...) by name.
            surface: Surfaces of the episodes, n planes.
        """


class NoForce(ForceSampler):
    """The sampler of tasks without a desired force."""

    def draw(self, drawn: Mapping[str, Array], options: Mapping[str, Array], surface: Surface) -> Array:
        """See `ForceSampler.draw`: always zero."""
        return np.zeros(surface.normal.shape)


class NormalForce(ForceSampler):
    """Draws a force along the inward normal that presses the surface in by `greatest_depth` at most.

    Keywords and reset options are not subject to that depth.

    Args:
        options: Keywords of the task.
    """

    reset_options: ClassVar[Mapping[str, ResetOption]] = {"desired_force": _FORCE_OPTION}

    def __init__(self, options: ForceOptions) -> None:
        self._options = options

    def draw(self, drawn: Mapping[str, Array], options: Mapping[str, Array], surface: Surface) -> Array:
        """See `ForceSampler.draw`."""
        if "desired_force" in options:
            unit = _FORCE_OPTION.unit
            magnitude = each_within("desired_force", options["desired_force"], FORCE_BOUNDS, unit)
        elif self._options.desired_force is not None:
            magnitude = np.full(len(surface.normal), self._options.desired_force)
        else:
            largest = surface.stiffness * drawn["greatest_depth"][:, 0]
            magnitude = np.minimum(drawn["desired_force"][:, 0], largest)
        force: Array = -magnitude[:, None] * surface.normal
        return force
