"""PRP-Adaptive-v0: one link of unknown inertia, friction and weight follows a trajectory."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import choice, each_within, within
from prp_gym.drawing.overlay import OverlayItem
from prp_gym.envs.base.references import path_overlay
from prp_gym.envs.base.scoring import LINK_SCORING
from prp_gym.envs.config import describe
from prp_gym.errors import InvalidValueError
from prp_gym.physics import engines
from prp_gym.physics.abstract_simulation import LinkSimulation, Simulation
from prp_gym.physics.link_mjcf import HINGE_HEIGHT, LINK_LENGTH
from prp_gym.robot.arrays import Array
from prp_gym.robot.link import NOMINAL_LINK, Link
from prp_gym.tasks.fields import LINK_FIELDS, LINK_POSITION_BOUND, LINK_REFERENCE_FIELDS, SPEED_BOUND, Field
from prp_gym.tasks.parts import (
    EpisodeStart,
    ErrorFunction,
    Reference,
    ResetOption,
    StartSampler,
    TaskParts,
    World,
)
from prp_gym.tasks.ranges import Draws
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TaskEntry, TaskSpec
from prp_gym.tasks.trajectory import Sine, SquareAcceleration, Trajectory

REFERENCES = ("sine", "square")
PLANT_OPTIONS = {
    "inertia": ResetOption((), "kg·m²", "inertia I of the plant"),
    "viscous_friction": ResetOption((), "N·m·s/rad", "viscous friction F of the plant"),
    "gravity_moment": ResetOption((), "N·m", "largest moment G of the plant's weight"),
}
_BOUNDS = {
    "reference_frequency": (0.05, 20.0),  # outside these the reference leaves its declared bounds
    "inertia": (1e-3, 1e3),
    "viscous_friction": (0.0, 1e3),
    "gravity_moment": (0.0, 1e3),
}


def _plant(name: str) -> dict[str, str]:
    option = PLANT_OPTIONS[name]
    return describe(option.unit, option.description + "; drawn at every reset if None")


@dataclass(frozen=True)
class AdaptiveOptions:
    """The task's own keywords.

    Raises:
        UnknownNameError: a reference that does not exist.
        InvalidValueError: a value that is not a number, or is out of bounds.
    """

    reference: str = field(
        default="sine",
        metadata=describe(
            "", "reference trajectory: `sine`, or `square`, an acceleration of ±1 rad/s² that changes sign"
        ),
    )
    reference_frequency: float | None = field(
        default=None,
        metadata=describe(
            "Hz", "frequency of the reference; drawn at every reset if None (1 Hz for the sine in `report`)"
        ),
    )
    inertia: float | None = field(default=None, metadata=_plant("inertia"))
    viscous_friction: float | None = field(default=None, metadata=_plant("viscous_friction"))
    gravity_moment: float | None = field(default=None, metadata=_plant("gravity_moment"))

    def __post_init__(self) -> None:
        choice("reference", self.reference, REFERENCES)
        for name, bounds in _BOUNDS.items():
            value = getattr(self, name)
            if value is not None:
                unit = next(entry.metadata["unit"] for entry in fields(self) if entry.name == name)
                object.__setattr__(self, name, within(name, value, bounds, unit))

    def plant(self) -> dict[str, float]:
        """The parameters of the plant that are not None, by name."""
        return {name: getattr(self, name) for name in PLANT_OPTIONS if getattr(self, name) is not None}


class LinkPlants(NamedTuple):
    """The links of n episodes.

    Attributes:
        inertia: Moments of inertia I (n) [kg m^2].
        viscous_friction: Coefficients F of the viscous friction (n) [N m s/rad].
        gravity_moment: Largest moments G of the weight (n) [N m].
    """

    inertia: Array
    viscous_friction: Array
    gravity_moment: Array


@dataclass(frozen=True, eq=False)
class LinkStart(EpisodeStart):
    """The starts of n episodes with plants of their own.

    Attributes:
        plant: Links of these episodes.
    """

    plant: LinkPlants


class LinkWorld(World[LinkStart]):
    """A single link whose inertia, friction and gravity moment differ from the nominal ones.

    Args:
        setup: Numbers, scenario, keywords and period of the task.
    """

    measured_fields = LINK_FIELDS

    def __init__(self, setup: TaskSetup) -> None:
        self.model = Link(NOMINAL_LINK)
        self._engine = setup.engine

    def make_physics(self, timestep: float, num_envs: int, num_threads: int) -> Simulation:
        """See `World.make_physics`."""
        return engines.make_link(self._engine, timestep, num_envs, num_threads)

    def draw_plants(self, rngs: Sequence[np.random.Generator]) -> None:
        """See `World.draw_plants`: the plants are part of the start."""

    def configure(self, physics: Simulation, ids: NDArray[np.intp], start: LinkStart, plants: None) -> None:
        """See `World.configure`."""
        if not isinstance(physics, LinkSimulation):
            raise InvalidValueError("physics", type(physics).__name__, "a LinkSimulation")
        physics.set_parameters(ids, *start.plant)


class LinkStarts(StartSampler[LinkStart]):
    """Samples starts of the link, with its reference and its plant.

    Args:
        setup: Numbers, scenario, keywords and period of the task.
    """

    reset_options: Mapping[str, ResetOption] = {
        "joint_position": ResetOption((1,), "rad", "initial joint position"),
        "joint_velocity": ResetOption((1,), "rad/s", "initial joint velocity"),
        **PLANT_OPTIONS,
    }

    def __init__(self, setup: TaskSetup) -> None:
        names = ("joint_position", "amplitude", "frequency", "square_frequency", *PLANT_OPTIONS)
        self._draws = Draws({name: setup.ranges[name] for name in names})
        self._options, self._given = setup.options, setup.options.plant()

    def draw(self, rngs: Sequence[np.random.Generator], options: Mapping[str, Array]) -> LinkStart:
        """See `StartSampler.draw`."""
        drawn = self._draws.draw(rngs)
        position = options.get("joint_position", drawn["joint_position"])
        velocity = options.get("joint_velocity", np.zeros(position.shape))
        for what, values, bound in (
            ("initial joint position", position, LINK_POSITION_BOUND),
            ("initial joint velocity", velocity, SPEED_BOUND[0]),
        ):
            beyond = np.abs(values) > bound
            if np.count_nonzero(beyond):
                raise InvalidValueError(what, values[beyond][:1].tolist(), f"within ±{bound:g}", "rad, rad/s")
        plant = LinkPlants(**{name: self._parameter(name, drawn, options) for name in PLANT_OPTIONS})
        return LinkStart(position, velocity, self._make_trajectory(drawn), plant)

    def _parameter(self, name: str, drawn: Mapping[str, Array], options: Mapping[str, Array]) -> Array:
        """One parameter of the plants (n): an option overrides a keyword, which overrides drawn values."""
        if name in options:
            return each_within(name, options[name], _BOUNDS[name], PLANT_OPTIONS[name].unit)
        values = drawn[name][:, 0]
        return np.full(len(values), self._given[name]) if name in self._given else values

    def _make_trajectory(self, drawn: Mapping[str, Array]) -> Trajectory:
        square = self._options.reference == "square"
        frequency = drawn["square_frequency" if square else "frequency"]
        if self._options.reference_frequency is not None:
            frequency = np.full(frequency.shape, self._options.reference_frequency)
        zero, rate = np.zeros(frequency.shape), 2 * np.pi * frequency
        if square:
            return SquareAcceleration(zero, np.ones(frequency.shape), rate)
        return Sine(zero, drawn["amplitude"], rate, zero)


class LinkReference(Reference):
    """Motions of the joint of the link."""

    fields: ClassVar[tuple[Field, ...]] = LINK_REFERENCE_FIELDS

    def sample(self, time: Array, ids: NDArray[np.intp] | None = None) -> Array:
        """See `Reference.sample`."""
        return self.rows(ids).sample(time)

    def overlay(self, index: int, duration: float) -> list[OverlayItem]:
        """See `Reference.overlay`."""
        trajectory = self.trajectory.rows(np.array([index]))
        return path_overlay(trajectory, _tip_path, duration)


class LinkErrors(ErrorFunction):
    """Tracking error of the link, and the effort."""

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """(..., 2, 1): tracking error [rad] and torque [N m]."""
        position, desired = ground_truth[..., 0], ground_truth[..., 2]
        return np.stack([desired - position, torque[..., 0]], axis=-1)[..., None]


def _tip_path(trajectory: Trajectory, time: Array) -> Array:
    return _tip(trajectory.sample(time)[..., 0])


def _tip(angle: Array) -> Array:
    """Tip positions (..., 3) [m] of the link at angles (...) [rad]."""
    across, down = LINK_LENGTH * np.sin(angle), LINK_LENGTH * np.cos(angle)
    return np.stack([across, np.zeros_like(across), HINGE_HEIGHT - down], axis=-1)


def compose(setup: TaskSetup) -> TaskParts:
    """Follow a trajectory with one link whose inertia, friction and weight are unknown.

    I q̈ + F q̇ + G sin q = τ, with q = 0 hanging down. Scenario `report` has I = 0.5 kg m²,
    F = 0.15 N m s/rad and G = 1.85 N m, starts hanging at rest and has the reference sin 2πt rad; the others
    draw all of these. The nominal link, which policies may use, has the report's numbers.

    Source: [R] 8.1.
    """
    return TaskParts(LinkWorld(setup), LinkStarts(setup), LinkReference(), LinkErrors())


TASK = register_task(
    TaskSpec(
        id="PRP-Adaptive-v0",
        summary="follow a trajectory with one link of unknown inertia, friction and weight",
        entry=TaskEntry(compose, AdaptiveOptions),
        numbers=Path(__file__).with_suffix(".toml"),
        scoring=LINK_SCORING,
        chapter=8.1,
        revision=2,
        released=True,
    )
)
