"""The common keywords of `gymnasium.make`, as one validated value."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Self, TypeVar

import numpy as np

from prp_gym.checks import as_numbers, choice, shaped
from prp_gym.envs.action_mode import INNER_FREQUENCY, TORQUE, check_action_mode
from prp_gym.envs.base.scenarios import load_scenario
from prp_gym.errors import InvalidValueError, UnknownKeywordError
from prp_gym.physics.rendering import check_view
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import TORQUE_UNITS
from prp_gym.tasks.scenario import Scenario
from prp_gym.tasks.setup import ENGINES, MUJOCO

SUBSTEPS_PER_SECOND = 1000
_LEAST_RATE = 1e-3  # Hz
_LONGEST = 1e6  # s
_LEAST_TORQUE = 1e-6  # N m, N, N m
RENDER_MODES = ("human", "rgb_array", "depth_array")
UNLIMITED_TORQUE = 1e6
"""What `torque_limit=None` stands for [N m, N, N m]: more than any controller asks for, yet finite."""

FIELDS, ERRORS = "fields", "errors"
OBSERVATIONS = (FIELDS, ERRORS)
"""What an environment observes: the fields of its task, or errors and states of order 1."""

OptionsT = TypeVar("OptionsT")


_TORQUE_LIMITS = "'scenario', None, a number or one number for each joint"

TorqueLimit = float | tuple[float, ...] | str | None


def describe(unit: str, description: str) -> dict[str, str]:
    """Metadata of a keyword, from which the documentation's tables are made."""
    return {"unit": unit, "description": description}


@dataclass(frozen=True)
class EnvConfig:
    """The keywords that every environment takes; see each field's metadata for unit and meaning.

    Raises:
        UnknownNameError: a scenario, action mode, kind of observation, render mode or camera that does not
            exist.
        InvalidValueError: a control frequency that does not divide the substep rate, a duration that is
            not a whole number of control periods, a torque limit or frame size that is not positive.
    """

    scenario: str = field(
        default="randomized",
        metadata=describe("", "conditions of the episodes: `report`, `randomized` or `realistic`"),
    )
    control_frequency: float = field(
        default=500,
        metadata=describe(
            "Hz", "frequency of actions; must divide 1000, and 500 in action modes other than `torque`"
        ),
    )
    duration: float = field(
        default=5.0, metadata=describe("s", "duration of an episode; a whole number of control periods")
    )
    action_mode: str = field(
        default=TORQUE,
        metadata=describe(
            "", "what an action means; `torque`: joint torques normalised by the actuator limits"
        ),
    )
    observation: str = field(
        default=FIELDS,
        metadata=describe(
            "",
            "what is observed: `fields`, in their units, or `errors`, of order 1, for learning",
        ),
    )
    torque_limit: TorqueLimit = field(
        default="scenario",
        metadata=describe(
            "N·m, N, N·m",
            "actuator limits: `scenario` for those of the scenario, one number or one for each joint, None"
            " for no limit",
        ),
    )
    engine: str = field(
        default=MUJOCO,
        metadata=describe(
            "",
            "what simulates the robot: `mujoco`, the reference, or `compiled`, its steps in closed form in"
            " code compiled from the formulas",
        ),
    )
    render_mode: str | None = field(
        default=None, metadata=describe("", "kind of frames: `human`, `rgb_array`, `depth_array` or None")
    )
    width: int = field(default=480, metadata=describe("pixel", "width of frames"))
    height: int = field(default=480, metadata=describe("pixel", "height of frames"))
    camera: str = field(
        default="task",
        metadata=describe("", "camera: `task`, which frames what matters, `contact`, `overview` or `top`"),
    )

    def __post_init__(self) -> None:
        load_scenario(self.scenario)
        check_action_mode(self.action_mode)
        choice("observation", self.observation, OBSERVATIONS)
        choice("engine", self.engine, ENGINES)
        if self.render_mode is not None:
            choice("render_mode", self.render_mode, RENDER_MODES)
        self._check_numbers()
        check_view(self.width, self.height, self.camera)
        self._check_times()
        self._make_plain()

    def _check_numbers(self) -> None:
        for name, unit in (("control_frequency", "Hz"), ("duration", "s")):
            object.__setattr__(self, name, float(shaped(name, getattr(self, name), (), unit)))

    def _check_times(self) -> None:
        rate = self.control_frequency
        divides = _LEAST_RATE <= rate <= SUBSTEPS_PER_SECOND and _is_whole(SUBSTEPS_PER_SECOND / rate)
        if not divides:
            raise InvalidValueError("control_frequency", rate, f"a divisor of {SUBSTEPS_PER_SECOND}", "Hz")
        if self.action_mode != TORQUE and not _is_whole(INNER_FREQUENCY / rate):
            allowed = f"a divisor of {INNER_FREQUENCY:g}, the frequency inside mode {self.action_mode!r}"
            raise InvalidValueError("control_frequency", rate, allowed, "Hz")
        steps = self.duration * rate
        if not (0.0 < self.duration <= _LONGEST and steps > 0.5 and _is_whole(steps)):
            allowed = f"a positive whole number of control periods of {1 / rate:g} s, up to {_LONGEST:g} s"
            raise InvalidValueError("duration", self.duration, allowed, "s")

    @property
    def substeps(self) -> int:
        """Number of time steps of the physics in a control period."""
        return round(SUBSTEPS_PER_SECOND / self.control_frequency)

    @property
    def periods(self) -> int:
        """Periods of the controller inside the action mode in a control period; 1 without one."""
        return round(self.inner.control_frequency / self.control_frequency)

    @property
    def inner(self) -> Self:
        """The same at the control frequency inside the action mode; as it is in mode `torque`."""
        return self if self.action_mode == TORQUE else replace(self, control_frequency=INNER_FREQUENCY)

    @property
    def horizon(self) -> int:
        """Number of control periods in an episode."""
        return round(self.duration * self.control_frequency)

    def at_most(self, steps: int) -> Self:
        """The same keywords with episodes of at most a number of control periods."""
        return replace(self, duration=min(self.horizon, steps) / self.control_frequency)

    def load_scenario(self) -> Scenario:
        """Load the scenario that the keyword names."""
        return load_scenario(self.scenario)

    def _make_plain(self) -> None:
        """Convert to Python numbers, so that equal keywords compare equal."""
        object.__setattr__(self, "torque_limit", _plain_limit(self.torque_limit))
        for name in ("width", "height"):
            object.__setattr__(self, name, int(getattr(self, name)))

    def limits(self, nominal: tuple[float, ...]) -> Array:
        """Actuator limits (joints) [N m, N, N m].

        Args:
            nominal: Nominal actuator limits of the robot (joints) [N m, N, N m].

        Raises:
            InvalidValueError: neither one number nor as many as the robot has joints.
        """
        if self.torque_limit == "scenario":
            return self.load_scenario().torque_limit_factor * np.array(nominal)
        limit = UNLIMITED_TORQUE if self.torque_limit is None else self.torque_limit
        try:
            return np.broadcast_to(np.asarray(limit, dtype=float), len(nominal)).copy()
        except ValueError:
            allowed = f"one number or {len(nominal)}"
            raise InvalidValueError("torque_limit", limit, allowed, ", ".join(TORQUE_UNITS)) from None


def _plain_limit(limit: TorqueLimit) -> TorqueLimit:
    """Convert a torque limit to Python numbers.

    Raises:
        InvalidValueError: a limit that is neither `scenario` nor None nor numbers above 0.
    """
    if limit is None or (isinstance(limit, str) and limit == "scenario"):
        return limit
    unit = ", ".join(TORQUE_UNITS)
    try:
        values = as_numbers("torque_limit", limit)
    except InvalidValueError:
        raise InvalidValueError("torque_limit", limit, _TORQUE_LIMITS, unit) from None
    if values.ndim > 1 or values.size == 0:
        raise InvalidValueError("torque_limit", limit, _TORQUE_LIMITS, unit)
    if not ((values >= _LEAST_TORQUE) & (values <= UNLIMITED_TORQUE)).all():
        allowed = f"{_LEAST_TORQUE:g} to {UNLIMITED_TORQUE:g}, or None"
        raise InvalidValueError("torque_limit", limit, allowed, unit)
    return float(values) if values.ndim == 0 else tuple(values.tolist())


def _is_whole(value: float) -> bool:
    return math.isclose(value, round(value), rel_tol=1e-9)


def parse_keywords(
    keywords: Mapping[str, object], options_class: type[OptionsT], others: frozenset[str] = frozenset()
) -> tuple[EnvConfig, OptionsT]:
    """Split keywords into the common ones and the task's own.

    Args:
        keywords: Keywords given to `gymnasium.make`.
        options_class: Dataclass of the task's own keywords.
        others: Further keywords, which the message about an unknown one lists.

    Returns:
        The common keywords and the task's own.

    Raises:
        UnknownKeywordError: a keyword that does not exist.
    """
    common = {entry.name for entry in fields(EnvConfig)}
    own = {entry.name for entry in fields(options_class)}  # type: ignore[arg-type]
    for name in keywords:
        if name not in common | own:
            raise UnknownKeywordError("the environment", name, common | own | others)
    config = EnvConfig(**{name: value for name, value in keywords.items() if name in common})  # type: ignore[arg-type]
    return config, options_class(**{name: value for name, value in keywords.items() if name in own})
