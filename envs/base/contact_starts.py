"""Starts of contact tasks: an elastic surface perpendicular to the slide, and a path relative to it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.base.arm_world import ARM_OPTIONS, ArmWorld, arm_physics, check_joint_limits, checked_start
from prp_gym.envs.base.force_options import ForceSampler, NoForce
from prp_gym.envs.base.surface_options import SURFACE_OPTIONS, make_surface, surface_value
from prp_gym.envs.base.tracking_starts import path_from
from prp_gym.physics.abstract_simulation import Simulation
from prp_gym.physics.surface import Surface
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array, dot
from prp_gym.tasks.fields import CONTACT_FORCE, MEASURED_FIELDS
from prp_gym.tasks.parts import EpisodeStart, StartSampler
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.trajectory import Constant, QuinticWaypoints, Trajectory

ContactPath = Callable[[Array, Array, Array], Trajectory]
"""Makes a reference, one row, from the joint position before contact (3), waypoints (K, 3) [rad, m, rad] and
the intervals between them (K) [s]."""


@dataclass(frozen=True, eq=False)
class ContactPoint:
    """The point of first contact: the slide moves the tip along the surface normal into it.

    Attributes:
        arm: Nominal arm.
        joint_position: Joint position at first contact (3) [rad, m, rad].
        side: +1 if an extending slide presses on the surface, -1 if a retracting one does.
    """

    arm: PRPArm
    joint_position: Array
    side: float

    @property
    def normal(self) -> Array:
        """Unit normal of the surface, which points to its free side (3)."""
        q_1 = self.joint_position[0]
        normal: Array = -self.side * np.array([np.sin(q_1), -np.cos(q_1), 0.0])
        return normal

    @property
    def offset(self) -> float:
        """Offset of the surface along its normal [m]."""
        return float(dot(self.normal, self.arm.forward_kinematics(self.joint_position)[:3]))

    def near(self, offsets: Array) -> Array:
        """Joint positions at given depths below the surface.

        Args:
            offsets: Changes of q_1 [rad], depths below the surface [m] (negative above it) and changes of
                q_3 [rad] (..., 3).

        Returns:
            Joint positions (..., 3) [rad, m, rad].
        """
        a_1, turn = self.arm.parameters.geometry.first_link_offset, offsets[..., 0]
        q = np.broadcast_to(self.joint_position, offsets.shape).copy()
        q[..., 0] += turn
        q[..., 2] += offsets[..., 2]
        reach = self.arm.reach(self.joint_position) + self.side * offsets[..., 1] + a_1 * np.sin(turn)
        q[..., 1] += reach / np.cos(turn) - self.arm.reach(q)
        return q


@dataclass(frozen=True, eq=False)
class ContactStart(EpisodeStart):
    """The start of an episode with a surface.

    Attributes:
        surface: Surface of the episode, one plane.
        desired_force: Desired force by the tip on the surface, world frame (3) [N]; zero in tasks
            without one.
        touch: Point of first contact, for frame rendering (3) [m].
    """

    surface: Surface
    desired_force: Array
    touch: Array


class ContactWorld(ArmWorld[ContactStart]):
    """The arm and an elastic surface.

    The surface is perpendicular to the slide at the contact point, so that the arm can yield along its normal
    without rotating; keywords and reset options may give other normals.
    """

    measured_fields = (*MEASURED_FIELDS, CONTACT_FORCE)

    def __init__(self, setup: TaskSetup) -> None:
        super().__init__(setup, surface=True)

    def configure(
        self,
        physics: Simulation,
        ids: NDArray[np.intp],
        starts: Sequence[ContactStart],
        plants: Sequence[Any],
    ) -> None:
        """See `World.configure`: sets link masses, joint friction and surfaces."""
        super().configure(physics, ids, starts, plants)
        surfaces = [start.surface for start in starts]
        touches = np.stack([start.touch for start in starts])
        arm_physics(physics).set_surface(ids, Surface.concatenate(surfaces), touches)


class ContactStarts(StartSampler[ContactStart]):
    """Samples starts near a surface.

    Args:
        setup: Numbers, scenario, keywords and period of the task.
        world: The arm and the surface.
        path: Function that makes the reference of an episode.
        force: Sampler of the desired force.
        kept: Slice of the drawn waypoints through which the path leads.
    """

    def __init__(
        self,
        setup: TaskSetup,
        world: ContactWorld,
        path: ContactPath,
        force: ForceSampler | None = None,
        kept: slice = slice(None),
    ) -> None:
        self._setup = setup
        self._arm = world.arm
        self._path = path
        self._force = force or NoForce()
        self._kept = kept
        given = setup.options.surface_stiffness
        drawn = float(setup.ranges["surface_stiffness"].high[0])
        self.greatest_stiffness = drawn if given is None else given
        self.reset_options = {**ARM_OPTIONS, **SURFACE_OPTIONS, **self._force.reset_options}

    def draw(self, rng: np.random.Generator, options: Mapping[str, Array]) -> ContactStart:
        """See `StartSampler.draw`."""
        drawn = {name: bounds.draw(rng) for name, bounds in self._setup.ranges.items()}
        point = ContactPoint(self._arm, drawn["contact"], 1.0 if drawn["side"][0] > 0.0 else -1.0)
        surface = self._surface(drawn, options, point)
        empty = np.zeros(0)
        offsets = drawn.get("waypoints", empty).reshape(-1, 3)[self._kept]
        intervals = drawn.get("interval", empty)[self._kept]
        before, waypoints = point.near(drawn["start"]), point.near(offsets)
        if "goal" in options:
            check_joint_limits(self._arm, "goal", options["goal"])
            waypoints[-1] = options["goal"]
        trajectory = self._path(options.get("joint_position", before), waypoints, intervals)
        force = self._force.draw(drawn, options, surface)
        touch = self._arm.forward_kinematics(point.joint_position)[:3]
        return ContactStart(*checked_start(self._arm, before, options), trajectory, surface, force, touch)

    def _surface(
        self, drawn: Mapping[str, Array], options: Mapping[str, Array], point: ContactPoint
    ) -> Surface:
        """The surface of an episode; reset options override keywords, and keywords override drawn values."""
        requested = {n: surface_value(n, options[n]) for n in SURFACE_OPTIONS if n in options}
        values = self._setup.options.given() | requested
        springs = float(drawn["surface_stiffness"][0]), float(drawn["surface_damping"][0])
        return make_surface(values, point.normal, point.offset, *springs)


def quintic_path(start: Array, waypoints: Array, intervals: Array) -> Trajectory:
    """Quintic segments from the start through the waypoints; see `ContactPath`."""
    times, positions = path_from(start, waypoints, intervals)
    return QuinticWaypoints(times[None], positions[None])


def hold_start(start: Array, waypoints: Array, intervals: Array) -> Trajectory:
    """The initial joint position, held constant; see `ContactPath`."""
    return Constant(start[None])


def hold_end(start: Array, waypoints: Array, intervals: Array) -> Trajectory:
    """The last waypoint, held constant; see `ContactPath`."""
    return Constant(waypoints[-1:])
