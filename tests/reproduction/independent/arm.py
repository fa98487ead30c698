"""The arm by Pinocchio, from the numbers of the report's arm written here."""

import math
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Array = NDArray[np.float64]

DENSITY = 2710.0  # kg/m^3
GRAVITY = 9.81  # m/s^2
_AXES = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class TipMotion(NamedTuple):
    """The end effector at a state of the arm.

    Attributes:
        pose: tip position and ZXZ Euler angles (6) [m, m, m, rad, rad, rad].
        jacobian: Jacobian J of the pose (6, 3).
        drift: the product of J's time derivative and the joint velocity (6), per second squared.
    """

    pose: Array
    jacobian: Array
    drift: Array


class ReportArm:
    """Cylinder, box, cylinder; a hinge about z, a slide along -y, a hinge about -x.

    Args:
        masses: link masses (3) [kg]; those of solid aluminium by default.
    """

    def __init__(self, masses: tuple[float, ...] = ()) -> None:
        self.model = pin.Model()
        self.model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
        joints = (
            pin.JointModelRZ(),
            pin.JointModelPrismaticUnaligned(np.array([0.0, -1.0, 0.0])),
            pin.JointModelRevoluteUnaligned(np.array([-1.0, 0.0, 0.0])),
        )
        origins = ((0.0, 0.0, 0.15), (0.4, -0.3, 0.0), (0.0, 0.0, 0.0))
        parent = 0
        for index, (joint, origin, solid) in enumerate(zip(joints, origins, _solids(masses), strict=True)):
            at = pin.SE3(np.eye(3), np.array(origin))
            parent = self.model.addJoint(parent, joint, at, f"joint_{index + 1}")
            self.model.appendBodyToJoint(parent, solid, pin.SE3.Identity())
        tip = pin.SE3(np.eye(3), np.array([0.0, -0.24, 0.0]))
        frame = pin.Frame("tip", parent, 0, tip, pin.FrameType.OP_FRAME)
        self._tip = self.model.addFrame(frame)
        self._data: Any = self.model.createData()

    def inertia(self, q: Array) -> Array:
        """The inertia matrix (3, 3)."""
        upper = np.triu(pin.crba(self.model, self._data, q))
        return np.asarray(upper + np.triu(upper, 1).T)

    def bias(self, q: Array, v: Array) -> Array:
        """Coriolis, centrifugal and gravity torques (3)."""
        return np.array(pin.nonLinearEffects(self.model, self._data, q, v))

    def gravity(self, q: Array) -> Array:
        """Gravity torques (3)."""
        return np.array(pin.computeGeneralizedGravity(self.model, self._data, q))

    def tip(self, q: Array, v: Array) -> TipMotion:
        """The end effector at a state."""
        pin.forwardKinematics(self.model, self._data, q, v, np.zeros(3))
        pin.computeJointJacobians(self.model, self._data, q)
        pin.updateFramePlacements(self.model, self._data)
        position = np.array(self._data.oMf[self._tip].translation)
        angles = np.array([q[0], math.pi / 2 - q[2], math.pi / 2])
        jacobian = np.zeros((6, 3))
        jacobian[:3] = pin.getFrameJacobian(self.model, self._data, self._tip, _AXES)[:3]
        jacobian[3, 0], jacobian[4, 2] = 1.0, -1.0
        drift = np.zeros(6)
        drift[:3] = pin.getFrameClassicalAcceleration(self.model, self._data, self._tip, _AXES).linear
        return TipMotion(np.concatenate([position, angles]), jacobian, drift)


def _solids(masses: tuple[float, ...]) -> list[Any]:
    """The links about their joints' frames, at q = 0 parallel to the world's."""
    m_1, m_2, m_3 = masses or (
        DENSITY * math.pi * 0.02**2 * 0.35,
        DENSITY * 0.3 * 0.03 * 0.03,
        DENSITY * math.pi * 0.02**2 * 0.24,
    )
    along_x = pin.SE3(pin.utils.rotate("y", math.pi / 2), np.array([0.2, 0.0, 0.0]))
    along_y = pin.SE3(pin.utils.rotate("x", math.pi / 2), np.array([0.0, -0.12, 0.0]))
    outwards = pin.SE3(np.eye(3), np.array([0.0, 0.15, 0.0]))
    return [
        along_x.act(pin.Inertia.FromCylinder(m_1, 0.02, 0.35)),
        outwards.act(pin.Inertia.FromBox(m_2, 0.03, 0.3, 0.03)),
        along_y.act(pin.Inertia.FromCylinder(m_3, 0.02, 0.24)),
    ]
