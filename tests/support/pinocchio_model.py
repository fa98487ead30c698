"""The arm built with Pinocchio's own functions from numbers written here: an oracle for the closed form.

Where Pinocchio cannot be installed, beside the lowest versions or on a new Python, tests that need it are
skipped.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.robot import ArmGeometry, RobotParameters

pin = pytest.importorskip("pinocchio")

Array = NDArray[np.float64]
Vector3 = tuple[float, float, float]

_DENSITY = 2710.0
_TIP_AXES_AT_HOME = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])


@dataclass(frozen=True)
class ArmNumbers:
    """Lengths [m], masses [kg] and central moments [kg m^2] along the world's axes at q = 0."""

    base_height: float
    first_link: float
    slide_offset: float
    third_link: float
    first_center: float
    second_center: float
    third_center: float
    masses: Vector3
    moments: tuple[Vector3, Vector3, Vector3]
    gravity: float


def _cylinder(radius: float, length: float) -> tuple[float, float, float]:
    """Mass, moment along the axis, moment across it, by Pinocchio's formula for a solid cylinder."""
    mass = _DENSITY * math.pi * radius**2 * length
    inertia = pin.Inertia.FromCylinder(mass, radius, length).inertia
    return mass, float(inertia[2, 2]), float(inertia[0, 0])


def _table() -> ArmNumbers:
    """The arm of the design document's table."""
    mass_1, along_1, across_1 = _cylinder(0.02, 0.35)
    mass_2 = _DENSITY * 0.30 * 0.03 * 0.03
    box = pin.Inertia.FromBox(mass_2, 0.03, 0.30, 0.03).inertia
    mass_3, along_3, across_3 = _cylinder(0.02, 0.24)
    return ArmNumbers(
        base_height=0.15,
        first_link=0.40,
        slide_offset=0.30,
        third_link=0.24,
        first_center=0.20,
        second_center=0.15,
        third_center=0.12,
        masses=(mass_1, mass_2, mass_3),
        moments=(
            (along_1, across_1, across_1),
            (float(box[0, 0]), float(box[1, 1]), float(box[2, 2])),
            (across_3, along_3, across_3),
        ),
        gravity=9.81,
    )


TABLE = _table()


class PinocchioArm:
    """Pinocchio's algorithms on the arm, one state at a time."""

    def __init__(self, numbers: ArmNumbers = TABLE) -> None:
        self.model = pin.Model()
        self.model.gravity.linear = np.array([0.0, 0.0, -numbers.gravity])
        slide, hinge = (
            pin.JointModelPrismaticUnaligned(np.array([0.0, -1.0, 0.0])),
            pin.JointModelRevoluteUnaligned(np.array([-1.0, 0.0, 0.0])),
        )
        origins = (
            (0.0, 0.0, numbers.base_height),
            (numbers.first_link, 0.0, 0.0),
            (0.0, -numbers.slide_offset, 0.0),
        )
        centers = (
            (numbers.first_center, 0.0, 0.0),
            (0.0, numbers.second_center - numbers.slide_offset, 0.0),
            (0.0, -numbers.third_center, 0.0),
        )
        joint = 0
        for index, kind in enumerate((pin.JointModelRZ(), slide, hinge)):
            placement = pin.SE3(np.eye(3), np.array(origins[index]))
            joint = self.model.addJoint(joint, kind, placement, f"joint_{index + 1}")
            inertia = pin.Inertia(
                numbers.masses[index], np.array(centers[index]), np.diag(numbers.moments[index])
            )
            self.model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        tip = pin.SE3(_TIP_AXES_AT_HOME, np.array([0.0, -numbers.third_link, 0.0]))
        self._tip = self.model.addFrame(pin.Frame("tip", joint, 0, tip, pin.FrameType.OP_FRAME))
        self._tip_on_link = tip
        self._data = self.model.createData()

    def tip_transform(self, q: Array) -> Array:
        """The end effector's frame in the world frame (4, 4)."""
        pin.framesForwardKinematics(self.model, self._data, q)
        return np.array(self._data.oMf[self._tip].homogeneous)

    def tip_jacobian(self, q: Array) -> Array:
        """Linear, then angular rows (6, 3), in the world's axes, of the end effector's frame."""
        frame = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        return np.array(pin.computeFrameJacobian(self.model, self._data, q, self._tip, frame))

    def inertia_matrix(self, q: Array) -> Array:
        """The composite-rigid-body inertia matrix (3, 3)."""
        upper = np.triu(pin.crba(self.model, self._data, q))
        return np.asarray(upper + np.triu(upper, 1).T)

    def inverse_dynamics(self, q: Array, velocity: Array, acceleration: Array, tip_force: Array) -> Array:
        """Torques (3), without friction; `tip_force` is that of the tip on the environment, world frame."""
        on_link = self._on_links(q, tip_force)
        return np.array(pin.rnea(self.model, self._data, q, velocity, acceleration, on_link))

    def forward_dynamics(self, q: Array, velocity: Array, torque: Array, tip_force: Array) -> Array:
        """Accelerations (3) by the articulated-body algorithm, without friction."""
        on_link = self._on_links(q, tip_force)
        return np.array(pin.aba(self.model, self._data, q, velocity, torque, on_link))

    def coriolis_force(self, q: Array, velocity: Array) -> Array:
        """C(q, q̇) q̇ (3): what the torques of a motion at constant velocity have beyond gravity's."""
        still = np.zeros(3)
        return self.inverse_dynamics(q, velocity, still, still) - self.gravity_vector(q)

    def gravity_vector(self, q: Array) -> Array:
        """Torques (3) that hold the arm still."""
        return np.array(pin.computeGeneralizedGravity(self.model, self._data, q))

    def kinetic_energy(self, q: Array, velocity: Array) -> float:
        """[J]."""
        return float(pin.computeKineticEnergy(self.model, self._data, q, velocity))

    def potential_energy(self, q: Array) -> float:
        """[J], zero with all masses on the floor."""
        return float(pin.computePotentialEnergy(self.model, self._data, q))

    def _on_links(self, q: Array, tip_force: Array) -> object:
        rotation = self.tip_transform(q)[:3, :3]
        wrench = pin.Force(-rotation.T @ tip_force, np.zeros(3))
        forces = pin.StdVec_Force()
        for _ in range(3):
            forces.append(pin.Force.Zero())
        forces.append(self._tip_on_link.act(wrench))
        return forces


def per_row(function: Callable[..., Array | float], *arguments: Array) -> Array:
    """A function of single states over the first axis of its arguments."""
    return np.array([function(*row) for row in zip(*arguments, strict=True)])


def random_arm(seed: int) -> tuple[RobotParameters, PinocchioArm]:
    """An arm without the symmetries of the nominal one, as parameters and as Pinocchio's model."""
    generator = np.random.default_rng(seed)
    lengths = [float(value) for value in generator.uniform(0.05, 0.6, size=12)]
    masses = _three(generator.uniform(0.2, 3.0, size=3))
    spread = generator.uniform(1e-3, 2e-2, size=(3, 3))  # second moments of mass, so that a solid exists
    moments = [_three(row.sum() - row) for row in spread]
    parameters = RobotParameters(
        geometry=ArmGeometry(*lengths),
        link_mass=masses,
        link_inertia=(moments[0], moments[1], moments[2]),
        gravity=3.7,
    )
    numbers = ArmNumbers(
        base_height=lengths[0],
        first_link=lengths[1],
        slide_offset=lengths[2],
        third_link=lengths[3],
        first_center=lengths[6],
        second_center=lengths[7] / 2,
        third_center=lengths[3] - lengths[11] / 2,
        masses=masses,
        moments=(moments[0], moments[1], moments[2]),
        gravity=3.7,
    )
    return parameters, PinocchioArm(numbers)


def random_states(seed: int, count: int) -> tuple[Array, Array, Array, Array]:
    """Positions (beyond the joint limits too), velocities, accelerations and tip forces, each (count, 3)."""
    generator = np.random.default_rng(seed)
    q = generator.uniform([-3.0, -0.8, -3.0], [3.0, 0.4, 3.0], size=(count, 3))
    velocity, acceleration = generator.uniform(-3.0, 3.0, size=(2, count, 3))
    return q, velocity, acceleration, generator.uniform(-20.0, 20.0, size=(count, 3))


def _three(values: Array) -> Vector3:
    first, second, third = (float(value) for value in values)
    return first, second, third
