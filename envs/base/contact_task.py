"""What the contact tasks share: an elastic surface across the slide's way, and a reference pose."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.base.arm_task import ARM_OPTIONS, arm_world, check_joint_limits
from prp_gym.envs.base.pose_task import PoseReferenceTask
from prp_gym.envs.checks import shaped, within
from prp_gym.envs.config import describe
from prp_gym.physics.batch_simulation import Simulation
from prp_gym.physics.surface import Surface
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import CONTACT_FORCE, MEASURED_FIELDS
from prp_gym.tasks.scenario import PlantDraw, Scenario
from prp_gym.tasks.task import ResetOption, TaskNumbers
from prp_gym.tasks.trajectory import Trajectory
from prp_gym.tasks.trajectory_task import TrajectoryStart

SURFACE_OPTIONS = {
    "surface_stiffness": ResetOption((), "N/m", "stiffness K of the surface"),
    "surface_damping": ResetOption((), "N·s/m", "damping D of the surface"),
    "surface_normal": ResetOption((3,), "", "normal of the surface in the world frame, to the free side"),
    "surface_offset": ResetOption((), "m", "unit normal · p of the surface's points p"),
}

SURFACE_BOUNDS = {
    "surface_stiffness": (1e-3, 1e5),
    "surface_damping": (0.0, 1e3),
    "surface_offset": (-5.0, 5.0),
}
"""What a surface may be; forces then stay within the bounds of their observation."""


def _surface(name: str) -> dict[str, str]:
    option = SURFACE_OPTIONS[name]
    return describe(option.unit, option.description + "; None draws it")


@dataclass(frozen=True)
class SurfaceOptions:
    """The surface of every episode; what is None is drawn, or follows from the drawn place of contact.

    Raises:
        InvalidValueError: a value that is not a number or outside `SURFACE_BOUNDS`, a zero normal.
        ShapeError: a normal without three components.
    """

    surface_stiffness: float | None = field(default=None, metadata=_surface("surface_stiffness"))
    surface_damping: float | None = field(default=None, metadata=_surface("surface_damping"))
    surface_normal: tuple[float, float, float] | None = field(
        default=None, metadata=_surface("surface_normal")
    )
    surface_offset: float | None = field(default=None, metadata=_surface("surface_offset"))

    def __post_init__(self) -> None:
        for name, value in self.given().items():
            plain = tuple(value.tolist()) if value.ndim else float(value)
            object.__setattr__(self, name, plain)
        make_surface(self.given(), np.array([0.0, 0.0, 1.0]), 0.0)

    def given(self) -> dict[str, Array]:
        """What is not None, by name."""
        names = [entry.name for entry in fields(SurfaceOptions)]
        values = {name: getattr(self, name) for name in names}
        return {n: surface_value(n, value) for n, value in values.items() if value is not None}


def surface_value(name: str, value: object) -> Array:
    """A value of the surface, as a keyword or reset option gives it.

    Raises:
        InvalidValueError: not numbers, or outside `SURFACE_BOUNDS`.
        ShapeError: another shape than is declared.
    """
    option = SURFACE_OPTIONS[name]
    if name in SURFACE_BOUNDS:
        return np.array(within(name, value, SURFACE_BOUNDS[name], option.unit))
    return shaped(name, value, option.shape, option.unit)


def make_surface(
    values: Mapping[str, Array], normal: Array, offset: float, stiffness: float = 1.0, damping: float = 0.0
) -> Surface:
    """One surface from what is given by name, and defaults for the rest."""
    direction = values.get("surface_normal", normal)
    return Surface(
        np.atleast_1d(values.get("surface_stiffness", stiffness)),
        np.atleast_1d(values.get("surface_damping", damping)),
        np.atleast_2d(direction),
        np.atleast_1d(values.get("surface_offset", offset)),
    )


@dataclass(frozen=True, eq=False)
class ContactPoint:
    """Where the tip meets the surface: the slide moves the tip straight into it.

    Attributes:
        arm: the nominal arm.
        joint_position: at the first touch (3) [rad, m, rad].
        side: +1 if an extending slide presses on the surface, -1 if a retracting one does.
    """

    arm: PRPArm
    joint_position: Array
    side: float

    @property
    def normal(self) -> Array:
        """Of the surface, to the free side (3)."""
        q_1 = self.joint_position[0]
        normal: Array = -self.side * np.array([np.sin(q_1), -np.cos(q_1), 0.0])
        return normal

    @property
    def offset(self) -> float:
        """Of the surface along its normal [m]."""
        return float(self.normal @ self.arm.forward_kinematics(self.joint_position)[:3])

    def near(self, offsets: Array) -> Array:
        """Joint positions at given depths below the surface.

        Args:
            offsets: (..., 3) change of q_1 [rad], depth [m] (negative: off the surface), change of q_3 [rad].

        Returns:
            (..., 3) [rad, m, rad].
        """
        a_1, turn = self.arm.parameters.geometry.first_link_offset, offsets[..., 0]
        q = np.broadcast_to(self.joint_position, offsets.shape).copy()
        q[..., 0] += turn
        q[..., 2] += offsets[..., 2]
        reach = self.arm.reach(self.joint_position) + self.side * offsets[..., 1] + a_1 * np.sin(turn)
        q[..., 1] += reach / np.cos(turn) - self.arm.reach(q)
        return q


@dataclass(frozen=True, eq=False)
class ContactStart(TrajectoryStart):
    """A start with its reference and its surface.

    Attributes:
        surface: one plane.
        desired_force: (3) by the tip on the surface, world frame [N]; zero where none is asked for.
        touch: (3) where the tip meets the surface, for the picture [m].
    """

    surface: Surface
    desired_force: Array
    touch: Array


class ContactTask(PoseReferenceTask[ContactStart]):
    """A task with an elastic surface that the slide presses on.

    The surface lies across the slide's direction at the place of contact, so that the arm can give way
    along its normal without turning; other normals may be given.
    """

    measured_fields = (*MEASURED_FIELDS, CONTACT_FORCE)
    reset_options: ClassVar = {**ARM_OPTIONS, **SURFACE_OPTIONS}
    surface = True

    def __init__(self, numbers: TaskNumbers, scenario: Scenario, options: Any, period: float) -> None:
        super().__init__(numbers, scenario, options, period)
        self._force = self.layout.index("contact_force")

    @abstractmethod
    def draw_reference(self, start: Array, waypoints: Array, intervals: Array) -> Trajectory:
        """The reference of one episode.

        Args:
            start: (3) joint position before the contact [rad, m, rad].
            waypoints: (K, 3) joint positions [rad, m, rad].
            intervals: (K) between them [s].

        Returns:
            one row.
        """

    def way(self, waypoints: Array, intervals: Array) -> tuple[Array, Array]:
        """The waypoints (K, 3) and intervals (K) that the reference takes, of those that were drawn."""
        return waypoints, intervals

    def draw(self, rng: np.random.Generator, options: Mapping[str, Array]) -> ContactStart:
        """See `Task.draw`."""
        drawn = {name: bounds.draw(rng) for name, bounds in self.ranges.items()}
        place = ContactPoint(self.arm, drawn["contact"], 1.0 if drawn["side"][0] > 0.0 else -1.0)
        target_impedance = {n: surface_value(n, options[n]) for n in SURFACE_OPTIONS if n in options}
        values = self.options.given() | target_impedance
        springs = float(drawn["surface_stiffness"][0]), float(drawn["surface_damping"][0])
        surface = make_surface(values, place.normal, place.offset, *springs)
        nowhere = np.zeros(0)
        offsets = drawn.get("waypoints", nowhere).reshape(-1, 3)
        offsets, intervals = self.way(offsets, drawn.get("interval", nowhere))
        before, waypoints = place.near(drawn["start"]), place.near(offsets)
        if "goal" in options:
            check_joint_limits(self.arm, "goal", options["goal"])
            waypoints[-1] = options["goal"]
        trajectory = self.draw_reference(options.get("joint_position", before), waypoints, intervals)
        force = self.desired_force(drawn, options, surface)
        touch = self.arm.forward_kinematics(place.joint_position)[:3]
        return ContactStart(*self.checked_start(before, options), trajectory, surface, force, touch)

    def desired_force(
        self, drawn: Mapping[str, Array], options: Mapping[str, Array], surface: Surface
    ) -> Array:
        """The desired force (3) [N] by the tip on a surface (one plane); none unless a task asks for one."""
        return np.zeros(3)

    def place(
        self,
        physics: Simulation,
        ids: NDArray[np.intp],
        starts: Sequence[ContactStart],
        plants: Sequence[PlantDraw],
    ) -> None:
        """See `Task.place`: masses, friction and surfaces."""
        super().place(physics, ids, starts, plants)
        surfaces = [start.surface for start in starts]
        touches = np.stack([start.touch for start in starts])
        arm_world(physics).set_surface(ids, Surface.concatenate(surfaces), touches)
