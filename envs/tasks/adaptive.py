"""PRP-Adaptive-v0: one link of unknown inertia, friction and weight follows a trajectory."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.checks import within
from prp_gym.envs.config import describe
from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.vector import PRPVectorEnv
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.physics.batch_simulation import Simulation
from prp_gym.physics.link_mjcf import HINGE_HEIGHT, LINK_LENGTH
from prp_gym.physics.link_simulation import LinkPhysics
from prp_gym.physics.rendering import GOAL_COLOR, PATH_COLOR, Ball, OverlayItem, Path
from prp_gym.robot.arrays import Array
from prp_gym.robot.link import NOMINAL_LINK, Link, LinkParameters
from prp_gym.tasks.fields import LINK_FIELDS, LINK_POSITION_BOUND, LINK_REFERENCE_FIELDS, SPEED_BOUND
from prp_gym.tasks.scenario import Scenario
from prp_gym.tasks.task import ResetOption, TaskNumbers
from prp_gym.tasks.trajectory import Sine, SquareAcceleration, Trajectory
from prp_gym.tasks.trajectory_task import TrajectoryStart, TrajectoryTask

REFERENCES = ("sine", "square")
PLANT_OPTIONS = {
    "inertia": ResetOption((), "kg·m²", "inertia I of the plant"),
    "viscous_friction": ResetOption((), "N·m·s/rad", "viscous friction F of the plant"),
    "gravity_moment": ResetOption((), "N·m", "largest moment G of the plant's weight"),
}
_PATH_POINTS = 120
_BOUNDS = {
    "reference_frequency": (0.05, 20.0),  # beyond these a reference leaves the observation's declared bounds
    "inertia": (1e-3, 1e3),
    "viscous_friction": (0.0, 1e3),
    "gravity_moment": (0.0, 1e3),
}


def _plant(name: str) -> dict[str, str]:
    option = PLANT_OPTIONS[name]
    return describe(option.unit, option.description + "; None draws it")


@dataclass(frozen=True)
class AdaptiveOptions:
    """Keywords of the task beside the common ones.

    Raises:
        UnknownNameError: a reference that does not exist.
        InvalidValueError: a number that is none or out of bounds.
    """

    reference: str = field(
        default="sine",
        metadata=describe("", "`sine`, or `square`: an acceleration of ±1 rad/s² that changes sign"),
    )
    reference_frequency: float | None = field(
        default=None, metadata=describe("Hz", "of the reference; None draws it (1 Hz in `report`)")
    )
    inertia: float | None = field(default=None, metadata=_plant("inertia"))
    viscous_friction: float | None = field(default=None, metadata=_plant("viscous_friction"))
    gravity_moment: float | None = field(default=None, metadata=_plant("gravity_moment"))

    def __post_init__(self) -> None:
        if self.reference not in REFERENCES:
            raise UnknownNameError("reference", self.reference, REFERENCES)
        for name, bounds in _BOUNDS.items():
            value = getattr(self, name)
            if value is not None:
                unit = next(entry.metadata["unit"] for entry in fields(self) if entry.name == name)
                object.__setattr__(self, name, within(name, value, bounds, unit))

    def plant(self) -> dict[str, float]:
        """The plant's numbers that are not None, by name."""
        return {name: getattr(self, name) for name in PLANT_OPTIONS if getattr(self, name) is not None}


def make_link(numbers: Mapping[str, float]) -> LinkParameters:
    """The nominal link with some of its numbers replaced."""
    return LinkParameters(
        numbers.get("inertia", NOMINAL_LINK.inertia),
        numbers.get("viscous_friction", NOMINAL_LINK.viscous_friction),
        numbers.get("gravity_moment", NOMINAL_LINK.gravity_moment),
    )


@dataclass(frozen=True, eq=False)
class LinkStart(TrajectoryStart):
    """A start with its reference and its plant.

    Attributes:
        plant: the link that is to be moved.
    """

    plant: LinkParameters


class AdaptiveTracking(TrajectoryTask[LinkStart]):
    """Follow q_d(t) with a link whose I, F and G no policy knows. Source: [R] 8.1."""

    environment_id = "PRP-Adaptive-v0"
    measured_fields = LINK_FIELDS
    reference_fields = LINK_REFERENCE_FIELDS
    reset_options: ClassVar = {
        "joint_position": ResetOption((1,), "rad", "initial joint position"),
        "joint_velocity": ResetOption((1,), "rad/s", "initial joint velocity"),
        **PLANT_OPTIONS,
    }

    def __init__(self, numbers: TaskNumbers, scenario: Scenario, options: Any, period: float) -> None:
        super().__init__(numbers, scenario, options, period)
        self.model = Link(NOMINAL_LINK)

    def make_physics(self, timestep: float, num_envs: int, num_threads: int) -> Simulation:
        """See `Task.make_physics`."""
        return LinkPhysics(NOMINAL_LINK, timestep, num_envs, num_threads)

    def draw(self, rng: np.random.Generator, options: Mapping[str, Array]) -> LinkStart:
        """See `Task.draw`."""
        names = ("joint_position", "amplitude", "frequency", "square_frequency", *PLANT_OPTIONS)
        drawn = {name: self.ranges[name].draw(rng) for name in names}
        numbers = {name: float(drawn[name][0]) for name in PLANT_OPTIONS}
        given = {
            name: within(name, options[name], _BOUNDS[name], option.unit)
            for name, option in PLANT_OPTIONS.items()
            if name in options
        }
        position = options.get("joint_position", drawn["joint_position"])
        velocity = options.get("joint_velocity", np.zeros(1))
        for what, value, bound in (
            ("initial joint position", position, LINK_POSITION_BOUND),
            ("initial joint velocity", velocity, SPEED_BOUND[0]),
        ):
            if abs(value[0]) > bound:
                raise InvalidValueError(what, value.tolist(), f"within ±{bound:g}", "rad, rad/s")
        plant = make_link(numbers | self.options.plant() | given)
        return LinkStart(position, velocity, self._draw_trajectory(drawn), plant)

    def _draw_trajectory(self, drawn: Mapping[str, Array]) -> Trajectory:
        square = self.options.reference == "square"
        frequency = drawn["square_frequency" if square else "frequency"]
        if self.options.reference_frequency is not None:
            frequency = np.array([self.options.reference_frequency])
        rate = 2 * np.pi * frequency[None]
        if square:
            return SquareAcceleration(np.zeros((1, 1)), np.ones((1, 1)), rate)
        return Sine(np.zeros((1, 1)), drawn["amplitude"][None], rate, np.zeros((1, 1)))

    def draw_plant(self, rng: np.random.Generator) -> None:
        """See `Task.draw_plant`: the plant is part of the start."""

    def place(
        self, physics: Simulation, ids: NDArray[np.intp], starts: Sequence[LinkStart], plants: Sequence[Any]
    ) -> None:
        """See `Task.place`."""
        if not isinstance(physics, LinkPhysics):
            raise InvalidValueError("physics", type(physics).__name__, "the link's, a LinkPhysics")
        links = [start.plant for start in starts]
        physics.set_parameters(
            ids,
            np.array([link.inertia for link in links]),
            np.array([link.viscous_friction for link in links]),
            np.array([link.gravity_moment for link in links]),
        )

    def reference(self, time: Array, ids: NDArray[np.intp] | None = None) -> Array:
        """See `Task.reference`."""
        return self.rows(ids).sample(time)

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """(..., 2, 1): tracking error [rad] and torque [N m]."""
        position, desired = ground_truth[..., 0], ground_truth[..., 2]
        return np.stack([desired - position, torque[..., 0]], axis=-1)[..., None]

    def overlay(self, index: int, duration: float) -> list[OverlayItem]:
        """Where the tip should be now and then: the ends and the path of the reference."""
        trajectory = self.trajectory.rows(np.array([index]))
        time = np.linspace(0.0, duration, _PATH_POINTS)[:, None]
        path = _tip(trajectory.sample(time)[:, 0, 0])
        return [Ball(_tip(trajectory.goal[0, 0]), 0.025, GOAL_COLOR), Path(path, 2.0, PATH_COLOR)]


def _tip(angle: Array) -> Array:
    """Tip positions (..., 3) [m] of the link at angles (...) [rad]."""
    across, down = LINK_LENGTH * np.sin(angle), LINK_LENGTH * np.cos(angle)
    return np.stack([across, np.zeros_like(across), HINGE_HEIGHT - down], axis=-1)


class AdaptiveEnv(PRPEnv):
    """Follow a trajectory with one link whose inertia, friction and weight are unknown.

    I q̈ + F q̇ + G sin q = τ, with q = 0 hanging down. Scenario `report` has I = 0.5 kg m²,
    F = 0.15 N m s/rad and G = 1.85 N m, starts hanging at rest and asks for sin 2πt rad; the others draw all
    of these. The nominal link, which policies may know, has the report's numbers.
    """

    task_class = AdaptiveTracking
    options_class = AdaptiveOptions


class AdaptiveVectorEnv(PRPVectorEnv):
    """Many of `AdaptiveEnv`, stepped together."""

    environment_class = AdaptiveEnv
