"""`SinglePeriod`: the control period of a single environment with the compiled engine, in few calls."""

from collections.abc import Mapping
from functools import partial
from typing import Any

from numpy.typing import NDArray

from prp_gym.physics.compiled_simulation import CompiledWorld
from prp_gym.robot.arrays import Array

SingleStep = tuple[Array, float, bool, bool, Array]
"""The results of a step of a single environment: observation, a new array (size), reward, whether the
simulation diverged, whether the duration of the episode is over, and the values of the info fields (number of
fields), which the next step may overwrite."""

_LOST, _TRUNCATED = 2, 4  # flags of `prp_run_one`


class SinglePeriod:
    """Advances a single environment by one control period.

    What takes the time of such a step is not the simulation but the calls around it, so that there are few.

    Args:
        function: Compiled function `prp_run_one`.
        address: Address of its plan.
        arrays: Arrays to which the plan points, by name.
        world: World of the simulation.
        substeps: Number of time steps in a control period.
    """

    def __init__(
        self,
        function: Any,
        address: Any,
        arrays: Mapping[str, NDArray[Any]],
        world: CompiledWorld,
        substeps: int,
    ) -> None:
        self._run = partial(function, address)
        self._world, self._substeps = world, substeps
        self._action, self._observation = arrays["action"][0], arrays["observation"][0]
        self._reward, self._info = arrays["reward"], arrays["info"][0]

    def step(self, action: NDArray[Any]) -> SingleStep | None:
        """Advance by one period.

        Args:
            action: Action (joints).

        Returns:
            The results; None for an action that is not finite, after which nothing has changed.
        """
        self._action[...] = action
        self._world.substeps = self._substeps
        flags = self._run()
        if not flags:
            return None
        lost, truncated = flags & _LOST != 0, flags & _TRUNCATED != 0
        return self._observation.copy(), self._reward.item(), lost, truncated, self._info
