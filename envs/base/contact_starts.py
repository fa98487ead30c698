"""Starts of contact tasks: an elastic surface perpendicular to the slide, and a path relative to it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.base.arm_world import ARM_OPTIONS, ArmWorld, arm_physics, check_joint_limits, checked_start
from prp_gym.envs.base.force_options import ForceSampler, NoForce
from prp_gym.envs.base.surface_options import SURFACE_OPTIONS, make_surface, surface_values
from prp_gym.envs.base.tracking_starts import path_from
from prp_gym.physics.abstract_simulation import Simulation
from prp_gym.physics.surface import Surface
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array, dot, zeros
from prp_gym.symbolic.row_function import RowFunction
from prp_gym.tasks.fields import CONTACT_FORCE, MEASURED_FIELDS
from prp_gym.tasks.parts import EpisodeStart, StartSampler
from prp_gym.tasks.ranges import Draws
from prp_gym.tasks.scenario import PlantDraw
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.trajectory import Constant, QuinticWaypoints, Trajectory

ContactPath = Callable[[Array, Array, Array], Trajectory]
"""Makes references, n rows, from the joint positions before contact (n, 3), waypoints (n, K, 3) [rad, m, rad]
and the intervals between them (n, K) [s]."""


_TURNS = np.array([1.0, 0.0, 1.0])  # the joints that turn


@dataclass(frozen=True, eq=False)
class ContactPoint:
    """Points of first contact: the slide moves the tip along the surface normal into them.

    Attributes:
        arm: Nominal arm.
        joint_position: Joint positions at first contact (..., 3) [rad, m, rad].
        side: +1 where an extending slide presses on the surface, -1 where a retracting one does (...).
    """

    arm: PRPArm
    joint_position: Array
    side: Array

    @cached_property
    def tip(self) -> Array:
        """Tip position at first contact (..., 3) [m]."""
        return self.arm.forward_kinematics(self.joint_position)[..., :3]

    @cached_property
    def normal(self) -> Array:
        """Unit normal of the surface, which points to its free side (..., 3)."""
        q_1, slide = self.joint_position[..., 0], zeros(self.joint_position.shape, self.joint_position)
        slide[..., 0], slide[..., 1] = np.sin(q_1), -np.cos(q_1)
        normal: Array = -self.side[..., None] * slide
        return normal

    @property
    def offset(self) -> Array:
        """Offset of the surface along its normal (...) [m]."""
        return dot(self.normal, self.tip)

    def near(self, offsets: Array) -> Array:
        """Joint positions at given depths below the surface.

        Args:
            offsets: Changes of q_1 [rad], depths below the surface [m] (negative above it) and changes of
                q_3 [rad] (..., K, 3).

        Returns:
            Joint positions (..., K, 3) [rad, m, rad].
        """
        a_1, turn = self.arm.parameters.geometry.first_link_offset, offsets[..., 0]
        q: Array = self.joint_position[..., None, :] + offsets * _TURNS
        reach = self.arm.reach(self.joint_position)[..., None] + self.side[..., None] * offsets[..., 1]
        q[..., 1] += (reach + a_1 * np.sin(turn)) / np.cos(turn) - self.arm.reach(q)
        return q


def contact_geometry(arm: PRPArm, contact: Array, side: Array, offsets: Array) -> Mapping[str, Array]:
    """Points of first contact, the surfaces there, and joint positions near them.

    Args:
        arm: Nominal arm.
        contact: Joint positions at first contact (n, 3) [rad, m, rad].
        side: Positive where an extending slide presses on the surface (n, 1).
        offsets: See `ContactPoint.near`, flat (n, 3K).

    Returns:
        `tip` (n, 3) [m], `normal` (n, 3), `offset` (n) [m], `targets` (n, K, 3) [rad, m, rad].
    """
    point = ContactPoint(arm, contact, np.where(side[:, 0] > 0.0, 1.0, -1.0))
    targets = point.near(offsets.reshape((len(offsets), -1, 3)))
    return {"tip": point.tip, "normal": point.normal, "offset": point.offset, "targets": targets}


@dataclass(frozen=True, eq=False)
class ContactStart(EpisodeStart):
    """The starts of n episodes with a surface.

    Attributes:
        surface: Surfaces of the episodes, n planes.
        desired_force: Desired forces by the tip on the surface, world frame (n, 3) [N]; zero in tasks
            without one.
        touch: Points of first contact, for frame rendering (n, 3) [m].
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
        self, physics: Simulation, ids: NDArray[np.intp], start: ContactStart, plants: PlantDraw | None
    ) -> None:
        """See `World.configure`: sets link masses, joint friction and surfaces."""
        super().configure(physics, ids, start, plants)
        arm_physics(physics).set_surface(ids, start.surface.normalised_again(), start.touch)


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
        self._arm = world.arm
        self._draws = Draws(setup.ranges)
        self._moved = [name for name in ("start", "waypoints") if name in setup.ranges]
        count = sum(len(setup.ranges[name].low) for name in self._moved)
        shapes = {"contact": (3,), "side": (1,), "offsets": (count,)}
        self._geometry = RowFunction("prp_contact", partial(contact_geometry, world.arm), shapes)
        self._surface = setup.options.given()
        self._path = path
        self._force = force or NoForce()
        self._kept = kept
        given = setup.options.surface_stiffness
        drawn = float(setup.ranges["surface_stiffness"].high[0])
        self.greatest_stiffness = drawn if given is None else given
        self.reset_options = {**ARM_OPTIONS, **SURFACE_OPTIONS, **self._force.reset_options}

    def draw(self, rngs: Sequence[np.random.Generator], options: Mapping[str, Array]) -> ContactStart:
        """See `StartSampler.draw`."""
        drawn = self._draws.draw(rngs)
        offsets = np.concatenate([drawn[name] for name in self._moved], axis=-1)
        point = self._geometry(contact=drawn["contact"], side=drawn["side"], offsets=offsets)
        surface = self._make_surface(drawn, options, point)
        before, waypoints = point["targets"][:, 0], point["targets"][:, 1:][:, self._kept]
        if "goal" in options:
            check_joint_limits(self._arm, "goal", options["goal"])
            waypoints[:, -1] = options["goal"]
        intervals = drawn["interval"][:, self._kept] if "interval" in drawn else np.zeros((len(rngs), 0))
        trajectory = self._path(options.get("joint_position", before), waypoints, intervals)
        force = self._force.draw(drawn, options, surface)
        start = checked_start(self._arm, before, options)
        return ContactStart(*start, trajectory, surface, force, point["tip"])

    def _make_surface(
        self, drawn: Mapping[str, Array], options: Mapping[str, Array], point: Mapping[str, Array]
    ) -> Surface:
        """The surfaces of episodes; reset options override keywords, and keywords override drawn values."""
        followed = {
            "surface_stiffness": drawn["surface_stiffness"][:, 0],
            "surface_damping": drawn["surface_damping"][:, 0],
            "surface_normal": point["normal"],
            "surface_offset": point["offset"],
        }
        requested = {n: surface_values(n, options[n]) for n in SURFACE_OPTIONS if n in options}
        return make_surface(followed, self._surface | requested)


def quintic_path(start: Array, waypoints: Array, intervals: Array) -> Trajectory:
    """Quintic segments from the start through the waypoints; see `ContactPath`."""
    return QuinticWaypoints(*path_from(start, waypoints, intervals))


def hold_start(start: Array, waypoints: Array, intervals: Array) -> Trajectory:
    """The initial joint position, held constant; see `ContactPath`."""
    return Constant(start)


def hold_end(start: Array, waypoints: Array, intervals: Array) -> Trajectory:
    """The last waypoint, held constant; see `ContactPath`."""
    return Constant(waypoints[:, -1])
