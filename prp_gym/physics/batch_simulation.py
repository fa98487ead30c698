"""`BatchSimulation`: many simulations of one robot on MuJoCo's native batch."""

from abc import abstractmethod
from typing import Any, ClassVar

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError
from prp_gym.physics.abstract_simulation import PhysicsState, Simulation
from prp_gym.physics.batch_readings import BatchReadings
from prp_gym.physics.clock import stop_clock_once
from prp_gym.physics.lost_batch import LostBatch, rebuild_after_fork
from prp_gym.physics.model_fields import Ids, ModelFields, check_states, rows_of
from prp_gym.physics.sensor_layout import NO_COLUMNS, SensorLayout
from prp_gym.robot.arrays import Array

_BAD_STATE = slice(int(mujoco.mjtWarning.mjWARN_BADQPOS), int(mujoco.mjtWarning.mjWARN_BADQACC) + 1)
_NO_WARNING = 1000  # initial value of MuJoCo's counters: at a count of 0 it prints a line and writes a file
_PERSISTENT_UP_TO = 128  # simulations: more of them, with one MjData each, exceed the caches


class BatchSimulation(Simulation):
    """N simulations of a robot on MuJoCo's native batch; a single environment has N = 1.

    The measured quantities are read-only arrays with N rows, which are current after `reset` and `advance`.
    They change with the simulations, so copy values that are to be kept. The same torques give the same
    bits for any N and any number of threads. A forked process goes on with a copy of the simulations.

    Args:
        num_simulations: Number of simulations N, at least 1.
        num_threads: Number of worker threads; 0 uses all cores.

    Attributes:
        joint_count: Number of joints, n in the shapes below; units are those of the robot's joints.
        measurement_size: Number of columns of `measurement`.
        readings: Arrays of the batch that compiled code reads, another structure after a fork.

    Raises:
        InvalidValueError: fewer than one simulation.
    """

    joint_count: ClassVar[int]
    _constructor_attributes: ClassVar[tuple[str, ...]]
    """Names of a subclass's constructor arguments besides the numbers of simulations and threads."""

    def __init__(self, num_simulations: int, num_threads: int) -> None:
        if num_simulations < 1:
            raise InvalidValueError("num_simulations", num_simulations, "at least 1")
        self.num_simulations = num_simulations
        self.num_threads = num_threads
        self._watched = np.full(2 * self.joint_count, np.inf)
        self._build()

    @abstractmethod
    def _compile(self) -> mujoco.MjModel:
        """Compile the MuJoCo model."""

    @abstractmethod
    def _sensor_layout(self) -> SensorLayout:
        """Layout of the model's sensors."""

    @abstractmethod
    def _make_fields(self, batch: Batch) -> ModelFields:
        """Make the fields of the model that may differ between simulations."""

    def _build(self) -> None:
        stop_clock_once()
        model, layout, count = self._compile(), self._sensor_layout(), self.num_simulations
        self._batch = Batch(model, count, self.num_threads, persistent=count <= _PERSISTENT_UP_TO)
        self._position: Array = self._batch.bind("qpos")
        self._velocity: Array = self._batch.bind("qvel")
        self._torque: Array = self._batch.bind("ctrl")
        self._applied: Array = self._torque.view()
        self._applied.flags.writeable = False
        self._sensors: Array = self._batch.bind("sensordata")
        self.measurement_size = len(layout.gain)
        self._measured = self._sensors[:, : self.measurement_size]
        self._gain, self._offset = np.tile(layout.gain, (count, 1)), np.tile(layout.offset, (count, 1))
        self._joint_position: Array = self._sensors[:, : self.joint_count]
        self._joint_velocity: Array = self._sensors[:, self.joint_count : 2 * self.joint_count]
        self._tip_position: Array = self._sensors[:, layout.tip_position]
        self._contact_force = self._view_of(layout.contact_force, 3)
        self._stop_violation = self._view_of(layout.stop_violation, self.joint_count)
        self._fields = self._make_fields(self._batch)
        if self._batch.nthread > 1:
            rebuild_after_fork(self)
        stages = mujoco.mjtStage
        in_contact = layout.contact_force != NO_COLUMNS
        self._stage = int(stages.mjSTAGE_ACC if in_contact else stages.mjSTAGE_VEL)
        self._timestep = float(model.opt.timestep)
        self._batch.reset(stage=int(stages.mjSTAGE_NONE))
        self._state_at_home = np.array(self._batch.state[0])
        self._batch.forward(stage=self._stage)
        self._guard(layout)

    def _guard(self, layout: SensorLayout) -> None:
        """Set the thresholds of `within_limits`."""
        self._threshold = np.full(self._sensors.shape, np.inf)
        self._threshold[:, layout.stop_violation] = 0.0
        self._threshold[:, : 2 * self.joint_count] = self._watched
        self._warnings = self._batch.warning[:, _BAD_STATE, 1]  # numbers of warnings
        self._no_warning = np.full_like(self._warnings, _NO_WARNING)
        self._warnings[:] = _NO_WARNING
        self._warnings_at_home = self._batch.warning[0].copy()
        self._without_warning = self._warnings.tobytes()
        arrays = {"sensors": self._sensors, "gain": self._gain, "offset": self._offset}
        arrays |= {"bound": self._threshold, "warnings": self._warnings}
        stop = -1 if layout.stop_violation == NO_COLUMNS else layout.stop_violation.start
        numbers = {"joints": self.joint_count, "first_stop": stop, "no_warning": _NO_WARNING}
        self.readings = BatchReadings.of(arrays, **numbers)

    def _view_of(self, columns: slice, width: int) -> Array:
        """View of the sensors' columns, or zeros if the world has no such sensors."""
        if columns != NO_COLUMNS:
            view: Array = self._sensors[:, columns]
            return view
        nothing = np.zeros((self.num_simulations, width))
        nothing.flags.writeable = False
        return nothing

    @property
    def batch(self) -> Any:
        """MuJoCo's batch of the simulations."""
        return self._batch

    @property
    def timestep(self) -> float:
        """Duration of one substep [s]."""
        return self._timestep

    def measure(self, out: Array) -> None:
        """Write `measurement` into an array (N, measurement_size)."""
        np.multiply(self._measured, self._gain, out=out)
        np.add(out, self._offset, out=out)

    @property
    def joint_position(self) -> Array:
        """Joint positions (N, n) [rad, or m for a prismatic joint]."""
        return self._joint_position

    @property
    def joint_velocity(self) -> Array:
        """Joint velocities (N, n) [rad/s, or m/s for a prismatic joint]."""
        return self._joint_velocity

    @property
    def tip_position(self) -> Array:
        """Tip positions (N, 3) in the world frame [m]."""
        return self._tip_position

    @property
    def contact_force(self) -> Array:
        """Forces (N, 3) of the tip on the surface, in the world frame [N]; zero without contact."""
        return self._contact_force

    @property
    def unstable(self) -> NDArray[np.bool_]:
        """Whether MuJoCo met a value that is not finite or huge since the last `reset` (N,).

        MuJoCo then resets the simulation to its home position, at rest and without torques.
        """
        flags: NDArray[np.bool_] = np.logical_or.reduce(self._warnings != self._no_warning, axis=1)
        return flags

    def watch(self, bound: Array) -> None:
        """Set the bounds of the magnitudes of joint positions and velocities (2n)."""
        self._watched = bound
        self._threshold[:, : 2 * self.joint_count] = bound

    @property
    def within_limits(self) -> bool:
        """Whether no joint is beyond its stop and no simulation is out of bounds.

        This is the usual case, and one check of all simulations is faster than a check of each.
        """
        beyond = np.abs(self._sensors) > self._threshold
        return not np.count_nonzero(beyond) and self._warnings.tobytes() == self._without_warning

    @property
    def out_of_bounds(self) -> NDArray[np.bool_]:
        """Whether a simulation exceeds the bounds set by `watch` or is `unstable` (N,)."""
        joints = np.s_[:, : 2 * self.joint_count]
        beyond = np.abs(self._sensors[joints]) > self._threshold[joints]
        if np.count_nonzero(beyond) or np.count_nonzero(self._warnings != self._no_warning):
            flags: NDArray[np.bool_] = np.logical_or.reduce(beyond, axis=1) | self.unstable
            return flags
        return np.zeros(self.num_simulations, dtype=np.bool_)

    @property
    def stop_violation(self) -> Array:
        """Negative distances (N, n) of joints beyond their stops; 0 within the limits or without stops."""
        return self._stop_violation

    @property
    def torque(self) -> Array:
        """Joint torques (N, n) that act until they are set again [N m, or N for a prismatic joint]."""
        return self._applied

    def set_torque(self, torque: Array) -> None:
        """Set the joint torques (N, n); the caller ensures that they are finite."""
        self._torque[:] = torque

    def advance(self, substeps: int) -> None:
        """Integrate every simulation over a number of time steps, at least 1, and update all measurements."""
        self._batch.step(nstep=substeps, stage=self._stage)

    def reset(self, ids: Ids, joint_position: Array, joint_velocity: Array) -> None:
        """Reset the solver and set the joint state of some simulations.

        Args:
            ids: Indices of the simulations (k).
            joint_position: (k, n) [rad, or m for a prismatic joint].
            joint_velocity: (k, n) [rad/s, or m/s for a prismatic joint].

        Raises:
            ShapeError: an argument has another shape; nothing is changed.
            NonFiniteError: the state contains NaN or infinity; nothing is changed.
        """
        check_states((len(ids), self.joint_count), joint_position, joint_velocity)
        rows = rows_of(ids, self.num_simulations)
        self._batch.state[rows] = self._state_at_home
        self._batch.warning[rows] = self._warnings_at_home
        self._position[rows] = joint_position
        self._velocity[rows] = joint_velocity
        self._batch.forward(None if isinstance(rows, slice) else rows, stage=self._stage)

    def snapshot(self) -> PhysicsState:
        """Copy of the full state of the simulations: physical state, solver's warm start, models."""
        return PhysicsState(np.array(self._batch.state), self._batch.warning.copy(), self._fields.copy())

    def restore(self, state: PhysicsState) -> None:
        """Restore a snapshot, bit for bit.

        Raises:
            InvalidValueError: the snapshot is of another number of simulations, or of another robot.
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
        """Copy of one simulation's model with its own field values, for rendering or analysis."""
        return self._batch.get_model(simulation)

    def data(self, simulation: int = 0) -> mujoco.MjData:
        """Copy of one simulation's current data with all fields computed, for rendering or analysis.

        The counters of MuJoCo's warnings about bad states start from 1000, since MuJoCo writes to a file at
        the first warning.
        """
        data = self._batch.get_data(simulation)
        mujoco.mj_forward(self._batch.get_model(simulation), data)
        return data

    def use_batch(self, batch: Batch | LostBatch) -> None:
        """Use another batch for all calls; the measured quantities stay those of the former one."""
        self._batch = self._fields.batch = batch

    def rebuild(self, inherited: Batch) -> Batch:
        """Build the batch anew, in the state of one that a forked process has without its threads."""
        fields = self._fields
        self.use_batch(inherited)
        state = self.snapshot()
        self._build()
        self.restore(state)
        fields.batch = self._batch  # for a caller that is about to use it
        return self._batch

    def __getstate__(self) -> dict[str, Any]:
        names = (*self._constructor_attributes, "num_simulations", "num_threads", "_watched")
        return {name: getattr(self, name) for name in names} | {"snapshot": self.snapshot()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        snapshot = state.pop("snapshot")
        self.__dict__.update(state)
        self._build()
        self.restore(snapshot)
