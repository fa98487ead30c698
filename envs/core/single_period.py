"""`SinglePeriod`: the control period of a single environment in compiled code, in few calls."""

import ctypes
from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import partial
from typing import Any

from numpy.typing import NDArray

from prp_gym.physics.batch_simulation import BatchSimulation
from prp_gym.physics.compiled_simulation import CompiledWorld
from prp_gym.robot.arrays import Array

SingleStep = tuple[Array, float, bool, bool, Array]
"""The results of a step of a single environment: observation, a new array (size), reward, whether the
simulation diverged, whether the duration of the episode is over, and the values of the info fields (number of
fields), which the next step may overwrite."""

LOST = 2
"""Flag of a period in which the simulation was lost."""

_TRUNCATED = 4  # flag of the last period of an episode


class SinglePeriod(ABC):
    """Advances a single environment by one control period.

    What takes the time of such a step is not the simulation but the calls around it, so that there are few.

    Args:
        arrays: Arrays to which the plan points, by name.
        substeps: Number of time steps in a control period.
    """

    def __init__(self, arrays: Mapping[str, NDArray[Any]], substeps: int) -> None:
        self._substeps = substeps
        self._action, self._observation = arrays["action"][0], arrays["observation"][0]
        self._reward, self._info = arrays["reward"], arrays["info"][0]

    @abstractmethod
    def advance(self, action: NDArray[Any]) -> int:
        """Advance by one period.

        Args:
            action: Action (joints).

        Returns:
            Flags of the period; 0 for an action that is not finite, after which nothing has changed.
        """

    def results(self, flags: int) -> SingleStep:
        """The results of a period with these flags, in which the simulation was not lost."""
        return self._observation.copy(), self._reward.item(), False, flags & _TRUNCATED != 0, self._info


class SingleCompiledPeriod(SinglePeriod):
    """The period with the compiled engine; see `SinglePeriod`.

    Args:
        library: Compiled code of the periods.
        address: Address of their plan.
        arrays: Arrays to which the plan points, by name.
        substeps: Number of time steps in a control period.
        world: World of the simulation.
    """

    def __init__(
        self,
        library: ctypes.CDLL,
        address: Any,
        arrays: Mapping[str, NDArray[Any]],
        substeps: int,
        world: CompiledWorld,
    ) -> None:
        super().__init__(arrays, substeps)
        self._run, self._world = partial(library.prp_run_one, address), world

    def advance(self, action: NDArray[Any]) -> int:
        """See `SinglePeriod.advance`."""
        self._action[...] = action
        self._world.substeps = self._substeps
        flags: int = self._run()
        return flags


class SingleMujocoPeriod(SinglePeriod):
    """The period with MuJoCo's physics; see `SinglePeriod`.

    Args:
        library: Compiled code of the periods.
        address: Address of their plan.
        arrays: Arrays to which the plan points, by name.
        substeps: Number of time steps in a control period.
        physics: The simulation.
    """

    def __init__(
        self,
        library: ctypes.CDLL,
        address: Any,
        arrays: Mapping[str, NDArray[Any]],
        substeps: int,
        physics: BatchSimulation,
    ) -> None:
        super().__init__(arrays, substeps)
        self._command = partial(library.prp_command_one, address)
        self._judge, self._address = library.prp_score_one, address
        self._physics, self._torque = physics, arrays["torque"]
        self._readings: ctypes.Structure | None = None

    def advance(self, action: NDArray[Any]) -> int:
        """See `SinglePeriod.advance`."""
        physics = self._physics
        self._action[...] = action
        if not self._command():
            return 0
        physics.set_torque(self._torque)
        physics.advance(self._substeps)
        if physics.readings is not self._readings:  # at first, and in a forked process
            self._readings = physics.readings
            self._score = partial(self._judge, self._address, ctypes.byref(self._readings))
        flags: int = self._score()
        return flags
