"""`Simulation`: what every engine offers, many simulations of one robot with named measurements."""

from abc import ABC, abstractmethod
from typing import Any, ClassVar, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from prp_gym.physics.mjcf import PhysicsSettings
from prp_gym.physics.model_fields import Ids
from prp_gym.physics.surface import Surface
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import RobotParameters


class PhysicsState(NamedTuple):
    """Full state of the simulations; see `Simulation.snapshot`."""

    integration: Array
    warnings: NDArray[np.int32]
    model_fields: dict[str, Array]


class Simulation(ABC):
    """N simulations of a robot; a single environment has N = 1.

    The measured quantities are arrays with N rows, which are current after `reset` and `advance`. They change
    with the simulations, so copy values that are to be kept. The same torques give the same bits for any N
    and any number of threads.

    Attributes:
        joint_count: Number of joints, n in the shapes below; units are those of the robot's joints.
        num_simulations: Number of simulations N.
        num_threads: Number of worker threads.
        measurement_size: Number of columns of `measurement`.
    """

    joint_count: ClassVar[int]
    num_simulations: int
    num_threads: int
    measurement_size: int

    @property
    @abstractmethod
    def batch(self) -> Any:
        """MuJoCo's batch of the simulations."""

    @property
    @abstractmethod
    def timestep(self) -> float:
        """Duration of one substep [s]."""

    @property
    def measurement(self) -> Array:
        """New array (N, measurement_size): joint position (n), joint velocity (n), and further columns."""
        values = np.empty((self.num_simulations, self.measurement_size))
        self.measure(values)
        return values

    @abstractmethod
    def measure(self, out: Array) -> None:
        """Write `measurement` into an array (N, measurement_size)."""

    @property
    @abstractmethod
    def joint_position(self) -> Array:
        """Joint positions (N, n) [rad, or m for a prismatic joint]."""

    @property
    @abstractmethod
    def joint_velocity(self) -> Array:
        """Joint velocities (N, n) [rad/s, or m/s for a prismatic joint]."""

    @property
    @abstractmethod
    def tip_position(self) -> Array:
        """Tip positions (N, 3) in the world frame [m]."""

    @property
    @abstractmethod
    def contact_force(self) -> Array:
        """Forces (N, 3) of the tip on the surface, in the world frame [N]; zero without contact."""

    @property
    @abstractmethod
    def unstable(self) -> NDArray[np.bool_]:
        """Whether the simulation met a value that is not finite or huge since the last `reset` (N,)."""

    @abstractmethod
    def watch(self, bound: Array) -> None:
        """Set the bounds of the magnitudes of joint positions and velocities (2n)."""

    @property
    @abstractmethod
    def within_limits(self) -> bool:
        """Whether no joint is beyond its stop and no simulation is out of bounds.

        This is the usual case, and one check of all simulations is faster than a check of each.
        """

    @property
    @abstractmethod
    def out_of_bounds(self) -> NDArray[np.bool_]:
        """Whether a simulation exceeds the bounds set by `watch` or is `unstable` (N,)."""

    @property
    @abstractmethod
    def stop_violation(self) -> Array:
        """Negative distances (N, n) of joints beyond their stops; 0 within the limits or without stops."""

    @property
    def joints_at_stop(self) -> NDArray[np.bool_]:
        """Whether a joint is beyond its stop (N, n)."""
        touching: NDArray[np.bool_] = self.stop_violation != 0.0
        return touching

    @property
    @abstractmethod
    def torque(self) -> Array:
        """Joint torques (N, n) that act until they are set again [N m, or N for a prismatic joint]."""

    @abstractmethod
    def set_torque(self, torque: Array) -> None:
        """Set the joint torques (N, n); the caller ensures that they are finite."""

    @abstractmethod
    def advance(self, substeps: int) -> None:
        """Integrate every simulation over a number of time steps, at least 1, and update all measurements."""

    @abstractmethod
    def reset(self, ids: Ids, joint_position: Array, joint_velocity: Array) -> None:
        """Set the joint state of some simulations, without torques.

        Args:
            ids: Indices of the simulations (k).
            joint_position: (k, n) [rad, or m for a prismatic joint].
            joint_velocity: (k, n) [rad/s, or m/s for a prismatic joint].

        Raises:
            ShapeError: an argument has another shape; nothing is changed.
            NonFiniteError: the state contains NaN or infinity; nothing is changed.
        """

    @abstractmethod
    def snapshot(self) -> PhysicsState:
        """Copy of the full state of the simulations: physical state, solver's warm start, models."""

    @abstractmethod
    def restore(self, state: PhysicsState) -> None:
        """Restore a snapshot, bit for bit.

        Raises:
            InvalidValueError: the snapshot is of another number of simulations, or of another robot.
        """

    @abstractmethod
    def model(self, simulation: int = 0) -> mujoco.MjModel:
        """Copy of one simulation's model with its own field values, for rendering or analysis."""

    @abstractmethod
    def data(self, simulation: int = 0) -> mujoco.MjData:
        """Copy of one simulation's current data with all fields computed, for rendering or analysis."""


class ArmSimulation(Simulation):
    """N simulations of the arm, with or without an elastic surface.

    Attributes:
        parameters: Nominal parameters of the simulated arm.
        settings: Settings of the world.
    """

    parameters: RobotParameters
    settings: PhysicsSettings

    @property
    @abstractmethod
    def tip_velocity(self) -> Array:
        """Tip velocities (N, 3) in the world frame [m/s]."""

    @abstractmethod
    def set_surface(self, ids: Ids, surface: Surface, center: Array | None = None) -> None:
        """Set the surfaces of some simulations; they take effect at the next `reset` or `advance`.

        Args:
            ids: Indices of the simulations (n).
            surface: Surface with n planes.
            center: Points (n, 3) [m] at whose projections the patches of the unbounded planes are drawn; by
                default the tip position at home.

        Raises:
            InvalidValueError: The world was built without a surface.
            ShapeError: The surface does not have n planes.
        """

    @abstractmethod
    def set_springs(self, ids: Ids, stiffness: Array, damping: Array) -> None:
        """Set the stiffness and damping of surfaces that stay where they are, from the next `advance` on.

        Args:
            ids: Indices of the simulations (n).
            stiffness: Stiffness K (n) [N/m], above 0.
            damping: Damping D (n) [N s/m], at least 0.

        Raises:
            InvalidValueError: A simulation without a surface, a value outside its range.
            ShapeError: An argument has another shape.
        """

    @abstractmethod
    def surface(self, simulation: int = 0) -> Surface:
        """The surface of one simulation, one plane.

        Raises:
            InvalidValueError: A simulation without a surface.
        """

    @abstractmethod
    def set_dynamics(
        self, ids: Ids, mass_factor: Array, viscous_friction: Array, coulomb_friction: Array
    ) -> None:
        """Set masses and friction of some simulations; their surfaces do not change.

        Args:
            ids: Indices of the simulations (n).
            mass_factor: Factors (n, 3) of each link's mass and inertia.
            viscous_friction: Coefficients F_v of the viscous friction (n, 3) [N m s/rad, N s/m, N m s/rad].
            coulomb_friction: Coulomb friction F_s (n, 3) [N m, N, N m].

        Raises:
            ShapeError: An argument has another shape.
            InvalidValueError: A factor that is not positive, negative friction, a value that is not finite.
        """

    @abstractmethod
    def has_surface(self, simulation: int = 0) -> bool:
        """Whether the surface of one simulation was set."""

    @abstractmethod
    def dynamics(self, simulation: int = 0) -> tuple[Array, Array, Array]:
        """Mass factors, viscous and Coulomb friction (1, 3) of one simulation; see `set_dynamics`."""


class LinkSimulation(Simulation):
    """N simulations of the one-joint link."""

    @abstractmethod
    def set_parameters(
        self, ids: Ids, inertia: Array, viscous_friction: Array, gravity_moment: Array
    ) -> None:
        """Set the link parameters of some simulations; they take effect at the next `reset` or `advance`.

        Args:
            ids: Indices of the simulations (n).
            inertia: Moment of inertia I (n) [kg m^2].
            viscous_friction: Coefficient F of the viscous friction (n) [N m s/rad].
            gravity_moment: Gravity moment G (n) [N m].

        Raises:
            ShapeError: an argument has another shape; nothing is changed.
            InvalidValueError: an inertia that is not positive, negative friction or gravity moment, a
                value that is not finite; nothing is changed.
        """

    @abstractmethod
    def parameters_of(self, simulation: int) -> tuple[Array, Array, Array]:
        """Inertia, viscous friction and gravity moment (1) of one simulation; see `set_parameters`."""
