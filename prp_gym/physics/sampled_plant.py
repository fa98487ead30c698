"""`SampledPlant`: one simulation over a control period with constant torques, and its exact derivatives."""

import ctypes
from typing import Any

import numpy as np

from prp_gym.errors import InvalidValueError
from prp_gym.physics.compiled_simulation import CompiledSimulation
from prp_gym.physics.derivatives_source import linearization_source
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.compiler import load_library


class SampledPlant:
    """The first of some simulations, as it is now; it does not advance.

    Args:
        physics: simulations in closed form with n joints.
        substeps: number of time steps in a control period, at least 1.

    Attributes:
        state: joint position and velocity (2n) in the units of the joints, and these per second.
        torque: joint torques (n) that act at present [N m, or N for a prismatic joint].

    Raises:
        CompilerError: this machine has neither the compiled code nor a compiler.
    """

    def __init__(self, physics: CompiledSimulation, substeps: int) -> None:
        own = linearization_source(physics.joint_count, physics.measurement_size)
        library = load_library("\n".join([physics.source, physics.derivatives_source, own]))
        self._period: Any = library.prp_linearize
        self._measurement: Any = library.prp_linearize_measurement
        self._measurement.restype = None
        self._physics, self._substeps, self._joints = physics, substeps, physics.joint_count
        arrays = physics.arrays
        self.state = np.concatenate([arrays["position"][0], arrays["velocity"][0]])
        self.torque = arrays["torque"][0].copy()

    def period(self, torque: Array) -> tuple[Array, Array, Array]:
        """The state after a period with these torques (n), and its derivatives.

        Args:
            torque: joint torques (n) [N m, or N for a prismatic joint].

        Returns:
            the state after the period (2n), and its derivatives A (2n, 2n) by the state now and B (2n, n) by
            the torques.

        Raises:
            InvalidValueError: torques with which the simulation leaves its bounds.
        """
        joints, state = self._joints, self.state.copy()
        position, velocity, applied = state[:joints], state[joints:], np.array(torque, dtype=np.float64)
        found = np.empty((2 * joints, 3 * joints))
        world = self._physics.world
        world.substeps = self._substeps
        inside = self._period(ctypes.byref(world), *self._addresses(position, velocity, applied, found))
        if not inside:
            raise InvalidValueError(
                "torque", applied.tolist(), "torques that keep the simulation in its bounds"
            )
        return state, found[:, : 2 * joints], found[:, 2 * joints :]

    def measurement(self) -> tuple[Array, Array]:
        """Derivatives of the measurement now.

        Returns:
            C (m, 2n) by the state, and D (m, n) by the torques that act at present.
        """
        joints, width = self._joints, self._physics.measurement_size
        state, torque = self.state.copy(), self.torque.copy()
        found = np.empty((width, 3 * joints))
        *given, result = self._addresses(state[:joints], state[joints:], torque, found)
        self._measurement(ctypes.byref(self._physics.world), *given, ctypes.c_int(width), result)
        return found[:, : 2 * joints], found[:, 2 * joints :]

    def _addresses(
        self, position: Array, velocity: Array, torque: Array, found: Array
    ) -> list[ctypes.c_void_p]:
        """Arguments of the compiled functions: these arrays, which must stay, around plant and surface."""
        plant, surface = self._physics.arrays["plants"], self._physics.arrays["surfaces"]
        arrays = (position, velocity, torque, plant, surface, found)
        return [ctypes.c_void_p(array.ctypes.data) for array in arrays]
