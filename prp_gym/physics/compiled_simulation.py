"""`CompiledSimulation`: simulations in closed form, in code compiled from the formulas."""

import ctypes
import os
from abc import abstractmethod
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, ClassVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError
from prp_gym.physics.abstract_simulation import PhysicsState, Simulation
from prp_gym.physics.model_fields import Ids, check_states, rows_of
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.compiler import load_library

WORLD = Path(__file__).with_name("compiled_world.h").read_text(encoding="utf-8")
"""The declaration of `CompiledWorld` in C."""

_LEAST_ROWS = 64  # simulations for each thread, below which starting it takes longer than it saves
_LARGEST = 1e10  # bound of positions and velocities, beyond which MuJoCo, too, gives up


class CompiledWorld(ctypes.Structure):
    """`prp_world` of the C code: what a world has.

    Attributes:
        stops: whether the joints stop at their limits.
        friction: whether a joint has Coulomb friction.
        surface: whether there is a surface.
        substeps: number of steps of a call.
        bound: bounds of the magnitudes of joint positions, then of joint velocities.
        turns: kept angles with their sines and cosines, a row for each simulation; null where none are kept.
    """

    _fields_: ClassVar = [
        ("stops", ctypes.c_int),
        ("friction", ctypes.c_int),
        ("surface", ctypes.c_int),
        ("substeps", ctypes.c_int),
        ("bound", ctypes.c_double * 6),
        ("turns", ctypes.c_void_p),
    ]


class CompiledSimulation(Simulation):
    """N simulations of a robot in closed form.

    A step is that of MuJoCo's semi-implicit Euler integrator with its constraints at their exact minimum. It
    differs from MuJoCo's by rounding, 1e-9 at most, and by 1e-5 where joints have Coulomb friction, whose
    minimum MuJoCo approaches to a tolerance. A simulation that leaves the bounds of `watch` stays there.

    Args:
        source: C source of the simulation, with a function `prp_advance`.
        measurement_size: Number of columns of `measurement`.
        num_simulations: Number of simulations N, at least 1.
        num_threads: Number of worker threads; 0 uses all cores.

    Attributes:
        source: C source of the simulation.
        world: what the simulated world has.
        arrays: arrays of the arguments of `prp_advance` by name, which stay the same.

    Raises:
        InvalidValueError: fewer than one simulation.
        CompilerError: this machine has neither the compiled code nor a compiler.
    """

    def __init__(
        self, source: str, measurement_size: int, num_simulations: int = 1, num_threads: int = 1
    ) -> None:
        if num_simulations < 1:
            raise InvalidValueError("num_simulations", num_simulations, "at least 1")
        self.num_simulations = num_simulations
        self.num_threads = num_threads or (os.cpu_count() or 1)
        self.measurement_size = measurement_size
        self.source, self._library = source, load_library(source)
        self._function = self._library.prp_advance
        self._function.restype = ctypes.c_int
        shape = (num_simulations, self.joint_count)
        self._position, self._velocity, self._torque = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        self._measured = np.zeros((num_simulations, measurement_size))
        self._beyond, self._no_force = np.zeros(shape), np.zeros((num_simulations, 3))
        self._indices = np.arange(num_simulations, dtype=np.dtype(ctypes.c_long))
        self._lost = np.zeros(num_simulations, dtype=np.uint8)
        self._threads: ThreadPoolExecutor | None = None
        self._process = os.getpid()
        self.world = CompiledWorld()
        self.watch(np.full(2 * self.joint_count, np.inf))

    def _begin(self, plants: Array, surfaces: Array) -> None:
        """Take the addresses of the arrays, which stay the same, and measure.

        Args:
            plants: rows of plants (N, any).
            surfaces: rows of surfaces (N, any).
        """
        rows = (self._position, self._velocity, self._torque, plants, surfaces)
        names = ("position", "velocity", "torque", "plants", "surfaces", "measured", "beyond", "lost")
        values: tuple[NDArray[Any], ...] = (*rows, self._measured, self._beyond, self._lost)
        self.arrays = dict(zip(names, values, strict=True))
        self._addresses = tuple(ctypes.c_void_p(array.ctypes.data) for array in values)
        self.advance(0)

    def run(self, function: Callable[[int, int, Any], Any], substeps: int, argument: Any) -> None:
        """Advance by a compiled function that calls `prp_advance`, with the threads of the simulations.

        Args:
            function: function of the first row, the number of rows and the argument.
            substeps: number of time steps of a call of `prp_advance`.
            argument: further argument.
        """
        self.world.substeps = substeps
        if self.num_simulations < 2 * _LEAST_ROWS:
            function(0, self.num_simulations, argument)
        else:
            self._over_rows(function, argument)

    @property
    @abstractmethod
    def derivatives_source(self) -> str:
        """C source of `prp_step_reverse` and `prp_measured_reverse`, to stand after `source`."""

    @abstractmethod
    def _fields(self) -> dict[str, Array]:
        """Copies of what differs between simulations besides their state, by name."""

    @abstractmethod
    def _restore_fields(self, kept: Mapping[str, Array]) -> None:
        """Restore what `_fields` returned."""

    @abstractmethod
    def in_mujoco(self, simulation: int) -> Simulation:
        """One simulation in MuJoCo, in the same state."""

    def advance(self, substeps: int) -> None:
        """See `Simulation.advance`; no substeps measure the present state."""
        self.world.substeps = substeps
        self._over_rows(self._advance_rows)

    def _over_rows(self, function: Callable[..., Any], *more: Any) -> None:
        """Call a function of the first row, the number of rows and more for all rows."""
        workers = min(self.num_threads, max(1, self.num_simulations // _LEAST_ROWS))
        if workers == 1:
            function(0, self.num_simulations, *more)
            return
        edges = np.linspace(0, self.num_simulations, workers + 1).astype(int).tolist()
        own, *others = zip(edges[:-1], np.diff(edges).tolist(), strict=True)
        pool = self._pool(workers)
        waiting = [pool.submit(function, *part, *more) for part in others]
        function(*own, *more)
        for one in waiting:
            one.result()

    def _measure_some(self, ids: Ids) -> None:
        """Measure the present state of some simulations; the others keep their measurements."""
        rows = self._indices[ids]
        self.world.substeps = 0
        self._advance_rows(0, len(rows), ctypes.c_void_p(rows.ctypes.data))

    def _advance_rows(self, first: int, count: int, rows: ctypes.c_void_p | None = None) -> None:
        """Advance `count` simulations from `first` on, in the order of the C array `rows` if there is one."""
        self._function(
            ctypes.c_long(first), ctypes.c_long(count), rows, ctypes.byref(self.world), *self._addresses
        )

    def _pool(self, workers: int) -> ThreadPoolExecutor:
        """The worker threads; a forked process, which has none, starts its own."""
        if self._threads is None or self._process != os.getpid():
            self._threads, self._process = ThreadPoolExecutor(workers), os.getpid()
        return self._threads

    @property
    def batch(self) -> Any:
        """See `Simulation.batch`.

        Raises:
            InvalidValueError: always, since there is none.
        """
        raise InvalidValueError("engine", "compiled", "'mujoco' for what needs MuJoCo's batch")

    def measure(self, out: Array) -> None:
        """See `Simulation.measure`."""
        out[...] = self._measured

    @property
    def joint_position(self) -> Array:
        """See `Simulation.joint_position`."""
        return self._position

    @property
    def joint_velocity(self) -> Array:
        """See `Simulation.joint_velocity`."""
        return self._velocity

    @property
    def unstable(self) -> NDArray[np.bool_]:
        """See `Simulation.unstable`."""
        return self._lost.astype(np.bool_)

    def watch(self, bound: Array) -> None:
        """See `Simulation.watch`."""
        self._watched = bound
        self.world.bound[: len(bound)] = np.minimum(bound, _LARGEST).tolist()

    @property
    def within_limits(self) -> bool:
        """See `Simulation.within_limits`."""
        return not (np.count_nonzero(self._beyond) or np.count_nonzero(self._lost))

    @property
    def out_of_bounds(self) -> NDArray[np.bool_]:
        """See `Simulation.out_of_bounds`."""
        return self.unstable

    @property
    def stop_violation(self) -> Array:
        """See `Simulation.stop_violation`."""
        return self._beyond

    @property
    def torque(self) -> Array:
        """See `Simulation.torque`."""
        return self._torque

    def set_torque(self, torque: Array) -> None:
        """See `Simulation.set_torque`."""
        self._torque[:] = torque

    def reset(self, ids: Ids, joint_position: Array, joint_velocity: Array) -> None:
        """See `Simulation.reset`."""
        check_states((len(ids), self.joint_count), joint_position, joint_velocity)
        rows = rows_of(ids, self.num_simulations)
        self._position[rows], self._velocity[rows] = joint_position, joint_velocity
        self._torque[rows], self._lost[rows] = 0.0, 0
        if isinstance(rows, slice):
            self.advance(0)
        else:
            self._measure_some(rows)

    def snapshot(self) -> PhysicsState:
        """See `Simulation.snapshot`."""
        state = np.concatenate([self._position, self._velocity, self._torque], axis=-1)
        return PhysicsState(state, self._lost.astype(np.int32), self._fields())

    def restore(self, state: PhysicsState) -> None:
        """See `Simulation.restore`."""
        expected = (self.num_simulations, 3 * self.joint_count)
        if state.integration.shape != expected:
            raise InvalidValueError("snapshot's state shape", state.integration.shape, f"{expected}")
        self._restore_fields(state.model_fields)
        self._position[:], self._velocity[:], self._torque[:] = np.split(state.integration, 3, axis=-1)
        self._lost[:] = state.warnings
        self.advance(0)

    def model(self, simulation: int = 0) -> mujoco.MjModel:
        """See `Simulation.model`."""
        return self.in_mujoco(simulation).model()

    def data(self, simulation: int = 0) -> mujoco.MjData:
        """See `Simulation.data`."""
        return self.in_mujoco(simulation).data()

    @abstractmethod
    def _arguments(self) -> tuple[Any, ...]:
        """Arguments of the constructor."""

    def __getstate__(self) -> dict[str, Any]:
        return {"arguments": self._arguments(), "watched": self._watched, "snapshot": self.snapshot()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        type(self).__init__(self, *state["arguments"])
        self.watch(state["watched"])
        self.restore(state["snapshot"])
