"""Random arms in front of surfaces, controllers by gain set, and expected torques by Pinocchio."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines import BASELINES, Baseline
from prp_gym.baselines.base.gains import load_gains
from prp_gym.robot import NOMINAL, PRPArm, RobotParameters
from tests.support.contact_plant import LIMIT, Imperfection, Recording, Wall, interface
from tests.support.pinocchio_model import PinocchioArm, per_row, random_states

Array = NDArray[np.float64]

UNLIMITED = 100.0 * LIMIT


def controller(
    name: str, gains: str, period: float = 0.002, limit: Array = LIMIT, **overrides: Any
) -> Baseline[Any]:
    """A controller with a gain set, some settings replaced."""
    values = load_gains(name, gains, "PRP-Force-v0")
    numbers = {key: values[key] for key in values if key not in ("source", "minimum_frequency")}
    made = BASELINES[name]
    settings = made.settings_class.from_mapping(name, {**numbers, **overrides})
    return made.policy(interface(period, limit), settings)


@dataclass(frozen=True, eq=False)
class Cases:
    """Arms at rest in front of surfaces perpendicular to the slide.

    Attributes:
        joint_position: Joint positions (n, 3) [rad, m, rad].
        into: Unit vectors into the surfaces (n, 3).
        wall: Surfaces.
        force: Magnitudes of the desired forces (n) [N].
    """

    joint_position: Array
    into: Array
    wall: Wall
    force: Array

    @property
    def desired(self) -> Array:
        """Desired forces f_d (n, 3) [N]."""
        return self.force[:, None] * self.into

    def pressing(self, recording: Recording) -> Array:
        """The true force (t, n) into the surfaces [N]."""
        return np.asarray(np.einsum("tnk,nk->tn", recording.force, self.into))


def slide_direction(joint_position: Array) -> Array:
    """Unit vectors along the slide (n, 3)."""
    angle = joint_position[:, 0]
    return np.stack([np.sin(angle), -np.cos(angle), np.zeros_like(angle)], axis=-1)


def random_cases(seed: int, count: int) -> Cases:
    """Stiffness 50 to 5000 N/m, force 1 to 10 N and at most 0.08 m deep, gap 1 to 4 cm; the corners first."""
    draw = np.random.default_rng(seed)
    q = draw.uniform([-2.5, -0.25, -1.2], [2.5, -0.05, 1.2], size=(count, 3))
    into = draw.choice([-1.0, 1.0], size=(count, 1)) * slide_direction(q)
    stiffness = np.exp(draw.uniform(np.log(50.0), np.log(5000.0), count))
    force = draw.uniform(1.0, 10.0, count)
    stiffness[:4], force[:4] = (5000.0, 5000.0, 50.0, 50.0), (1.0, 10.0, 1.0, 4.0)
    tip = PRPArm().forward_kinematics(q)[:, :3]
    wall = Wall.ahead(tip, into, draw.uniform(0.01, 0.04, count), stiffness)
    return Cases(q, into, wall, np.minimum(force, 0.08 * stiffness))


MASS_FACTORS = ((0.7, 0.7, 0.7), (1.3, 0.7, 1.3))
"""Factors of the link masses that controllers do not know of."""


def repeated(cases: Cases, times: int) -> Cases:
    """The same cases several times, one round after the other."""
    wall = cases.wall
    parts = (wall.stiffness, wall.normal, wall.offset, wall.damping)
    walls = Wall(*(np.concatenate([part] * times) for part in parts))
    joints, into, force = (
        np.concatenate([part] * times) for part in (cases.joint_position, cases.into, cases.force)
    )
    return Cases(joints, into, walls, force)


def poor_arms(count: int, noises: tuple[float, ...]) -> Imperfection:
    """So many arms with each noise and each of the `MASS_FACTORS`, these one round after the other.

    They have noise and bias up to 0.1 N of the force sensor, where there is noise, and a one-step actuation
    delay.
    """
    rounds = [(noise, factors) for noise in noises for factors in MASS_FACTORS]
    bias = np.random.default_rng(3).uniform(-0.1, 0.1, size=(count, 3))
    return Imperfection(
        tuple(_with_masses(factors) for _, factors in rounds for _ in range(count)),
        np.repeat([noise for noise, _ in rounds], count),
        np.concatenate([bias * (noise > 0.0) for noise, _ in rounds]),
        1,
    )


def _with_masses(factors: tuple[float, float, float]) -> RobotParameters:
    first, second, third = (factor * mass for factor, mass in zip(factors, NOMINAL.link_mass, strict=True))
    return NOMINAL.with_masses((first, second, third))


def random_observation(seed: int, count: int) -> dict[str, Array]:
    """Random fields (count, size) of arms in motion and contact, with desired motion and force."""
    q, velocity, _, force = random_states(seed, count)
    desired, desired_velocity, desired_acceleration, desired_force = random_states(seed + 1, count)
    arm = PRPArm()
    pose, rate, _ = arm.pose_motion(q, velocity, np.zeros_like(q))
    wanted = arm.pose_motion(desired, desired_velocity, desired_acceleration)
    names = ("desired_pose", "desired_velocity", "desired_acceleration")
    return {
        "joint_position": q,
        "joint_velocity": velocity,
        "end_effector_pose": pose,
        "end_effector_velocity": rate,
        "contact_force": force,
        **dict(zip(names, wanted, strict=True)),
        "desired_force": desired_force,
    }


def flat(observed: dict[str, Array]) -> Array:
    """The observation (count, size) with these fields."""
    return np.concatenate([observed[name] for name in interface().layout.names], axis=-1)


def torque_for(observed: dict[str, Array], acceleration: Array) -> Array:
    """By Pinocchio: the torque (n, 3) that accelerates the pose by (n, 6) against the contact force.

    The pose's angles are α = q_1, β = π/2 - q_3 and γ; J̇_A q̇ is a central difference of J_A q̇.
    """
    oracle = PinocchioArm()

    def jacobian(q: Array) -> Array:
        angles = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, 0.0]]
        return np.concatenate([oracle.tip_jacobian(q)[:3], angles])

    def torque(q: Array, velocity: Array, wanted: Array, force: Array) -> Array:
        after, before = jacobian(q + 1e-6 * velocity), jacobian(q - 1e-6 * velocity)
        drift = (after - before) @ velocity / 2e-6
        return oracle.inverse_dynamics(q, velocity, np.linalg.pinv(jacobian(q)) @ (wanted - drift), force)

    motion = (observed["joint_position"], observed["joint_velocity"])
    return per_row(torque, *motion, acceleration, observed["contact_force"])
