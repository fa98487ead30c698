"""The reference of an observation in the space that a controller needs, whichever space it is given in."""

import numpy as np

from prp_gym.baselines.base.references import JointReferences, PoseReferences
from prp_gym.robot import PRPArm
from tests.support.control_interface import oracle_drift, oracle_jacobian, oracle_pose
from tests.support.pinocchio_model import PinocchioArm, random_states

ARM, ORACLE = PRPArm(), PinocchioArm()
Q, VELOCITY, ACCELERATION, _ = random_states(1, 20)
JOINT = {
    "desired_joint_position": Q,
    "desired_joint_velocity": VELOCITY,
    "desired_joint_acceleration": ACCELERATION,
}
_STATES = list(zip(Q, VELOCITY, ACCELERATION, strict=True))
POSE = {
    "desired_pose": np.array([oracle_pose(ORACLE, q) for q in Q]),
    "desired_velocity": np.array([oracle_jacobian(ORACLE, q) @ v for q, v, _ in _STATES]),
    "desired_acceleration": np.array(
        [oracle_jacobian(ORACLE, q) @ a + oracle_drift(ORACLE, q, v) for q, v, a in _STATES]
    ),
}
DIFFERENCES = 1e-8  # the oracle differentiates its Jacobian numerically


def test_reference_is_given_as_observed_in_its_own_space() -> None:
    for found, expected in zip(JointReferences().joint(JOINT), JOINT.values(), strict=True):
        assert found is expected
    for found, expected in zip(PoseReferences(ARM).pose(POSE, ARM), POSE.values(), strict=True):
        assert found is expected


def test_joint_reference_becomes_the_motion_of_the_end_effector() -> None:
    pose = JointReferences().pose(JOINT, ARM)
    for name, expected in zip(("pose", "velocity", "acceleration"), POSE.values(), strict=True):
        np.testing.assert_allclose(getattr(pose, name), expected, atol=DIFFERENCES)


def test_pose_reference_becomes_the_motion_of_the_joints() -> None:
    joint = PoseReferences(ARM).joint(POSE)
    for name, expected in zip(("position", "velocity", "acceleration"), JOINT.values(), strict=True):
        np.testing.assert_allclose(getattr(joint, name), expected, atol=DIFFERENCES)


def test_joint_reference_survives_the_way_through_pose_space() -> None:
    there = dict(zip(POSE, JointReferences().pose(JOINT, ARM), strict=True))
    for found, expected in zip(PoseReferences(ARM).joint(there), JOINT.values(), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-11)  # condition number below 4
