"""`Plants`: masses and friction of N arms, as the closed form takes them."""

import ctypes
from collections.abc import Mapping

import numpy as np

from prp_gym.physics.compiled_arm_source import PLANT, PLANT_SIZE
from prp_gym.physics.model_fields import Ids, check_dynamics
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import NOMINAL

_DYNAMICS = "dynamics"


class Plants:
    """The plants of N simulations of the nominal arm with other masses and friction.

    Args:
        count: Number of simulations N.
        library: Compiled code of `arm_source`.

    Attributes:
        rows: Plants (N, `PLANT_SIZE`), with the columns of `PLANT`.
    """

    def __init__(self, count: int, library: ctypes.CDLL) -> None:
        self._function = library.prp_set_plants
        self._function.restype = None
        self._indices = np.arange(count, dtype=np.dtype(ctypes.c_long))
        self.rows = np.zeros((count, PLANT_SIZE))
        self._dynamics = np.zeros((count, 9))  # mass factors, viscous and Coulomb friction
        nominal = np.ones(3), np.array(NOMINAL.viscous_friction), np.array(NOMINAL.coulomb_friction)
        self.set(np.arange(count), *(np.tile(value, (count, 1)) for value in nominal))

    @property
    def have_coulomb_friction(self) -> bool:
        """Whether a joint of any simulation has Coulomb friction."""
        return bool(np.count_nonzero(self.rows[:, PLANT["coulomb_friction"]]))

    def set(self, ids: Ids, mass_factor: Array, viscous_friction: Array, coulomb_friction: Array) -> None:
        """See `ArmSimulation.set_dynamics`."""
        check_dynamics(ids, mass_factor, viscous_friction, coulomb_friction)
        self._dynamics[ids] = np.concatenate([mass_factor, viscous_friction, coulomb_friction], axis=-1)
        indices = self._indices[ids]
        addresses = (ctypes.c_void_p(array.ctypes.data) for array in (indices, self._dynamics, self.rows))
        self._function(ctypes.c_long(len(indices)), *addresses)

    def dynamics(self, simulation: int) -> tuple[Array, Array, Array]:
        """Mass factors, viscous and Coulomb friction (1, 3) of one simulation."""
        factor, viscous, coulomb = np.split(self._dynamics[simulation : simulation + 1], 3, axis=-1)
        return factor, viscous, coulomb

    def copy(self) -> dict[str, Array]:
        """The plants, by name."""
        return {_DYNAMICS: self._dynamics.copy()}

    def restore(self, kept: Mapping[str, Array]) -> None:
        """Restore what `copy` returned."""
        self.set(np.arange(len(self.rows)), *np.split(kept[_DYNAMICS], 3, axis=-1))
