"""The keywords of `gymnasium.make`, as one validated value."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TypeVar

import numpy as np

from prp_gym.envs.data import load_scenario
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.physics.rendering import check_view
from prp_gym.robot.parameters import NOMINAL, TORQUE_UNITS, Vector3
from prp_gym.tasks.scenario import Scenario

SUBSTEPS_PER_SECOND = 1000
_LEAST_RATE = 1e-3  # Hz
ACTION_MODES = ("torque",)
RENDER_MODES = ("human", "rgb_array", "depth_array")
UNLIMITED_TORQUE = 1e6
"""What `torque_limit=None` stands for [N m, N, N m]: more than any law asks for, yet finite."""

OptionsT = TypeVar("OptionsT")


_TORQUE_LIMITS = "'scenario', None, a number or three numbers"

TorqueLimit = float | tuple[float, float, float] | str | None


def describe(unit: str, description: str) -> dict[str, str]:
    """Metadata of a keyword, from which the documentation's tables are made."""
    return {"unit": unit, "description": description}


@dataclass(frozen=True)
class EnvConfig:
    """The keywords that every environment takes; see each field's metadata for unit and meaning.

    Raises:
        UnknownNameError: a scenario, action mode, render mode or camera that does not exist.
        InvalidValueError: a control frequency that does not divide the substep rate, a duration that is
            not a whole number of control periods, a torque limit or picture size that is not positive.
    """

    scenario: str = field(
        default="randomized", metadata=describe("", "`report`, `randomized` or `realistic`")
    )
    control_frequency: float = field(default=500, metadata=describe("Hz", "of actions; must divide 1000"))
    duration: float = field(
        default=5.0, metadata=describe("s", "of an episode; a whole number of control periods")
    )
    action_mode: str = field(
        default="torque", metadata=describe("", "what an action means; `torque`: joint torques over limits")
    )
    torque_limit: TorqueLimit = field(
        default="scenario",
        metadata=describe(
            "N·m, N, N·m",
            "actuator limits: `scenario` takes the scenario's, a number or three set them, None lifts them",
        ),
    )
    render_mode: str | None = field(
        default=None, metadata=describe("", "`human`, `rgb_array`, `depth_array` or None")
    )
    width: int = field(default=480, metadata=describe("pixel", "of pictures"))
    height: int = field(default=480, metadata=describe("pixel", "of pictures"))
    camera: str = field(default="overview", metadata=describe("", "`overview` or `top`"))

    def __post_init__(self) -> None:
        load_scenario(self.scenario)
        if self.action_mode not in ACTION_MODES:
            raise UnknownNameError("action_mode", self.action_mode, ACTION_MODES)
        if self.render_mode is not None and self.render_mode not in RENDER_MODES:
            raise UnknownNameError("render_mode", self.render_mode, RENDER_MODES)
        self._check_numbers()
        check_view(self.width, self.height, self.camera)
        self._check_times()
        self._make_plain()

    def _check_numbers(self) -> None:
        for name in ("control_frequency", "duration"):
            if not isinstance(getattr(self, name), (int, float, np.number)):
                raise InvalidValueError(name, getattr(self, name), "a number")
        for name in ("width", "height"):
            if not isinstance(getattr(self, name), (int, np.integer)):
                raise InvalidValueError(name, getattr(self, name), "a whole number", "pixels")

    def _check_times(self) -> None:
        rate = self.control_frequency
        divides = _LEAST_RATE <= rate <= SUBSTEPS_PER_SECOND and _is_whole(SUBSTEPS_PER_SECOND / rate)
        if not divides:
            raise InvalidValueError("control_frequency", rate, f"a divisor of {SUBSTEPS_PER_SECOND}", "Hz")
        steps = self.duration * rate
        if not (math.isfinite(steps) and steps > 0.5 and _is_whole(steps)):
            allowed = f"a positive whole number of control periods of {1 / rate:g} s"
            raise InvalidValueError("duration", self.duration, allowed, "s")

    @property
    def substeps(self) -> int:
        """Time steps of the physics in a control period."""
        return round(SUBSTEPS_PER_SECOND / self.control_frequency)

    @property
    def horizon(self) -> int:
        """Control periods in an episode."""
        return round(self.duration * self.control_frequency)

    def load_scenario(self) -> Scenario:
        """The scenario by its name."""
        return load_scenario(self.scenario)

    def _make_plain(self) -> None:
        """Python numbers throughout, so that equal keywords make equal values."""
        limits = self.limits()
        if self.torque_limit is not None and not isinstance(self.torque_limit, str):
            object.__setattr__(self, "torque_limit", limits)
        for name in ("control_frequency", "duration"):
            object.__setattr__(self, name, float(getattr(self, name)))

    def limits(self) -> Vector3:
        """Actuator limits (3) [N m, N, N m]."""
        limit = self.torque_limit
        if isinstance(limit, str):
            if limit != "scenario":
                raise InvalidValueError("torque_limit", limit, _TORQUE_LIMITS)
            factor = self.load_scenario().torque_limit_factor
            return _vector([factor * nominal for nominal in NOMINAL.torque_limit])
        try:
            values = np.broadcast_to(np.asarray(UNLIMITED_TORQUE if limit is None else limit, dtype=float), 3)
        except (TypeError, ValueError):
            raise InvalidValueError("torque_limit", limit, _TORQUE_LIMITS) from None
        if not ((values > 0.0) & (values <= UNLIMITED_TORQUE)).all():
            allowed = f"above 0 and at most {UNLIMITED_TORQUE:g}, or None"
            raise InvalidValueError("torque_limit", limit, allowed, ", ".join(TORQUE_UNITS))
        return _vector(values.tolist())


def _vector(values: list[float]) -> Vector3:
    first, second, third = values
    return first, second, third


def _is_whole(value: float) -> bool:
    return math.isclose(value, round(value), rel_tol=1e-9)


def parse_keywords(
    keywords: Mapping[str, object], options_class: type[OptionsT]
) -> tuple[EnvConfig, OptionsT]:
    """Sort keywords into the common ones and the task's own.

    Args:
        keywords: as given to `gymnasium.make`.
        options_class: dataclass of the task's own keywords.

    Returns:
        the common keywords and the task's.

    Raises:
        UnknownNameError: a keyword that neither knows.
    """
    common = {entry.name for entry in fields(EnvConfig)}
    own = {entry.name for entry in fields(options_class)}  # type: ignore[arg-type]
    for name in keywords:
        if name not in common | own:
            raise UnknownNameError("environment keyword", name, common | own)
    config = EnvConfig(**{name: value for name, value in keywords.items() if name in common})  # type: ignore[arg-type]
    return config, options_class(**{name: value for name, value in keywords.items() if name in own})
