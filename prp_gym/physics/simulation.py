"""`Physics`: many simulations of the arm at once, which answer named questions."""

from typing import Any, NamedTuple

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, NonFiniteError
from prp_gym.physics.mjcf import PhysicsSettings, compile_model
from prp_gym.physics.model_fields import Ids, ModelFields, check_rows
from prp_gym.physics.surface import Surface
from prp_gym.robot.arrays import Array
from prp_gym.robot.kinematics import Kinematics
from prp_gym.robot.parameters import NOMINAL, RobotParameters

# From the 18 sensor values to joint state, pose and pose rate: α = q_1, β = π/2 - q_3, γ = π/2.
_MEASUREMENT_GAIN = np.array([1.0] * 6 + [1.0] * 4 + [-1.0, 0.0] + [1.0] * 4 + [-1.0, 0.0])
_MEASUREMENT_OFFSET = np.array([0.0] * 10 + [np.pi / 2, np.pi / 2] + [0.0] * 6)
MEASUREMENT_SIZE = 18

_BAD_STATE = slice(int(mujoco.mjtWarning.mjWARN_BADQPOS), int(mujoco.mjtWarning.mjWARN_BADQACC) + 1)
_PERSISTENT_UP_TO = 128  # simulations: beyond it one MjData each no longer fits the caches and is slower


class PhysicsState(NamedTuple):
    """All that determines how the simulations go on; see `Physics.snapshot`."""

    integration: Array
    warnings: NDArray[np.int32]
    model_fields: dict[str, Array]


class Physics:
    """N simulations of the arm on MuJoCo's native batch; a single environment has N = 1.

    Answers are read-only arrays with N rows that are current after `reset` and `advance`; they change
    with the simulations, so copy what is to be kept. The same
    torques give the same bits for any N and any number of threads.

    Args:
        parameters: the arm that is simulated (the plant).
        settings: the world.
        num_simulations: N, at least 1.
        num_threads: worker threads; 0 takes all cores.

    Raises:
        InvalidValueError: fewer than one simulation.
    """

    def __init__(
        self,
        parameters: RobotParameters = NOMINAL,
        settings: PhysicsSettings | None = None,
        num_simulations: int = 1,
        num_threads: int = 1,
    ) -> None:
        if num_simulations < 1:
            raise InvalidValueError("num_simulations", num_simulations, "at least 1")
        self.parameters = parameters
        self.settings = PhysicsSettings() if settings is None else settings
        self.num_simulations = num_simulations
        self.num_threads = num_threads
        self._build()

    def _build(self) -> None:
        model = compile_model(self.parameters, self.settings)
        count = self.num_simulations
        self._batch = Batch(model, count, self.num_threads, persistent=count <= _PERSISTENT_UP_TO)
        self._position: Array = self._batch.bind("qpos")
        self._velocity: Array = self._batch.bind("qvel")
        self._torque: Array = self._batch.bind("ctrl")
        self._applied: Array = self._torque.view()
        self._applied.flags.writeable = False
        self._sensors: Array = self._batch.bind("sensordata")
        stages = mujoco.mjtStage
        stage = stages.mjSTAGE_ACC if self.settings.surface else stages.mjSTAGE_VEL
        self._stage = int(stage)
        after_stops = MEASUREMENT_SIZE + (3 if self.settings.joint_stops else 0)
        self._kinematic_sensors = self._sensors[:, :MEASUREMENT_SIZE]
        self._stop_sensors = self._sensors[:, MEASUREMENT_SIZE:after_stops]
        self._gain = np.tile(_MEASUREMENT_GAIN, (count, 1))
        self._offset = np.tile(_MEASUREMENT_OFFSET, (count, 1))
        self._force_sensors = self._sensors[:, after_stops : after_stops + 3]
        self._warnings = self._batch.warning[:, _BAD_STATE, 1]  # how often
        nothing = np.zeros((count, 3))
        nothing.flags.writeable = False
        if not self.settings.joint_stops:
            self._stop_sensors = nothing
        if not self.settings.surface:
            self._force_sensors = nothing
        self._home_tip = Kinematics(self.parameters).forward_kinematics(np.zeros(3))[:3]
        self._fields = ModelFields(self._batch)
        self._batch.reset(stage=self._stage)

    @property
    def timestep(self) -> float:
        """Duration of one substep [s]."""
        return self.settings.timestep

    @property
    def measurement(self) -> Array:
        """(N, 18), new: joint position (3), joint velocity (3), pose (6), pose rate (6); SPEC units."""
        values = np.empty((self.num_simulations, MEASUREMENT_SIZE))
        self.measure(values)
        return values

    def measure(self, out: Array) -> None:
        """Write `measurement` into an array (N, 18)."""
        np.multiply(self._kinematic_sensors, self._gain, out=out)
        np.add(out, self._offset, out=out)

    @property
    def joint_position(self) -> Array:
        """(N, 3) [rad, m, rad]."""
        return self._sensors[:, 0:3]

    @property
    def joint_velocity(self) -> Array:
        """(N, 3) [rad/s, m/s, rad/s]."""
        return self._sensors[:, 3:6]

    @property
    def tip_position(self) -> Array:
        """(N, 3) in the world frame [m]."""
        return self._sensors[:, 6:9]

    @property
    def tip_velocity(self) -> Array:
        """(N, 3) in the world frame [m/s]."""
        return self._sensors[:, 12:15]

    @property
    def unstable(self) -> NDArray[np.bool_]:
        """(N,), whether MuJoCo met a value that is not finite, or huge, since the last `reset`.

        MuJoCo then puts the simulation back to its home position, at rest and without torques.
        """
        flags: NDArray[np.bool_] = np.logical_or.reduce(self._warnings != 0, axis=1)
        return flags

    @property
    def any_unstable(self) -> bool:
        """Whether any simulation is `unstable`; faster than asking for each."""
        return bool(np.count_nonzero(self._warnings))

    @property
    def stop_violation(self) -> Array:
        """(N, 3) how far joints are beyond their stops, negative; 0 within [rad, m, rad]."""
        violation: Array = self._stop_sensors
        return violation

    @property
    def joints_at_stop(self) -> NDArray[np.bool_]:
        """(N, 3), whether a joint is beyond its stop."""
        touching: NDArray[np.bool_] = self._stop_sensors != 0.0
        return touching

    @property
    def contact_force(self) -> Array:
        """(N, 3) force by the tip on the surface, world frame [N]; zero without contact or surface."""
        force: Array = self._force_sensors
        return force

    @property
    def torque(self) -> Array:
        """(N, 3) joint torques that act until they are set anew [N m, N, N m]."""
        return self._applied

    def set_torque(self, torque: Array) -> None:
        """Joint torques that act from now on (N, 3) [N m, N, N m]; the caller vouches for finite values."""
        self._torque[:] = torque

    def advance(self, substeps: int) -> None:
        """Integrate every simulation over a number of time steps, at least 1; all answers are current."""
        self._batch.step(nstep=substeps, stage=self._stage)

    def reset(self, ids: Ids, joint_position: Array, joint_velocity: Array) -> None:
        """Put some simulations at rest in the solver and at a given joint state.

        Args:
            ids: (n) the simulations.
            joint_position: (n, 3) [rad, m, rad].
            joint_velocity: (n, 3) [rad/s, m/s, rad/s].

        Raises:
            ShapeError: another shape; nothing was changed.
            NonFiniteError: NaN or infinity in the state; nothing was changed.
        """
        for what, values in (("joint_position", joint_position), ("joint_velocity", joint_velocity)):
            check_rows(what, values, (len(ids), 3))
            if not np.isfinite(values).all():
                raise NonFiniteError(what, np.asarray(values).tolist())
        self._batch.reset(ids, stage=int(mujoco.mjtStage.mjSTAGE_NONE))
        self._position[ids] = joint_position
        self._velocity[ids] = joint_velocity
        self._batch.forward(ids, stage=self._stage)

    def set_surface(self, ids: Ids, surface: Surface) -> None:
        """Give some simulations their own surface; takes effect at the next `reset` or `advance`.

        Args:
            ids: (n) the simulations.
            surface: n planes.

        Raises:
            InvalidValueError: the world was built without a surface.
            ShapeError: not n planes.
        """
        if not self.settings.surface:
            raise InvalidValueError("surface", "given", "nothing: this world was built without a surface")
        self._fields.set_surface(ids, surface, self._home_tip)

    def set_dynamics(
        self, ids: Ids, mass_factor: Array, viscous_friction: Array, coulomb_friction: Array
    ) -> None:
        """Give some simulations their own masses and friction; their surfaces stay as they are.

        Args:
            ids: (n) the simulations.
            mass_factor: (n, 3) factors on each link's mass and inertia.
            viscous_friction: F_v (n, 3) [N m s/rad, N s/m, N m s/rad].
            coulomb_friction: F_s (n, 3) [N m, N, N m].

        Raises:
            ShapeError: another shape.
            InvalidValueError: a factor that is not positive, negative friction, a value that is not finite.
        """
        self._fields.set_dynamics(ids, mass_factor, viscous_friction, coulomb_friction)

    def snapshot(self) -> PhysicsState:
        """Copy of all that determines how the simulations go on: state, solver's warm start, models."""
        return PhysicsState(np.array(self._batch.state), self._batch.warning.copy(), self._fields.copy())

    def restore(self, state: PhysicsState) -> None:
        """Go back to a snapshot, bit for bit.

        Raises:
            InvalidValueError: the snapshot is of another number of simulations.
        """
        if state.integration.shape != self._batch.state.shape:
            raise InvalidValueError(
                "snapshot's state shape", state.integration.shape, f"{self._batch.state.shape}"
            )
        self._fields.restore(state.model_fields)
        self._batch.state[:] = state.integration
        self._batch.forward(stage=self._stage)
        self._batch.state[:] = state.integration
        self._batch.warning[:] = state.warnings

    def model(self, simulation: int = 0) -> mujoco.MjModel:
        """A copy of one simulation's model, with its own masses and surface, for rendering or study."""
        return self._batch.get_model(simulation)

    def data(self, simulation: int = 0) -> mujoco.MjData:
        """A copy of one simulation's current data, all fields computed, for rendering or study."""
        data = self._batch.get_data(simulation)
        mujoco.mj_forward(self._batch.get_model(simulation), data)
        return data

    def __getstate__(self) -> dict[str, Any]:
        names = ("parameters", "settings", "num_simulations", "num_threads")
        return {name: getattr(self, name) for name in names} | {"snapshot": self.snapshot()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        snapshot = state.pop("snapshot")
        self.__dict__.update(state)
        self._build()
        self.restore(snapshot)
