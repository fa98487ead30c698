"""`ReversibleController`: a controller as a compiled function, and the reverse of that function."""

import ctypes
from typing import Any, ClassVar

from prp_gym.errors import UntraceableError
from prp_gym.evaluation.compiled_controller import CompiledController
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.derivatives import transposed, unrounded
from prp_gym.symbolic.function import SymbolicFunction
from prp_gym.symbolic.lifting import LiftedFunction

_SMOOTH, _REVERSE = "prp_controller_smooth", "prp_controller_reverse"


class ReversibleController(CompiledController):
    """A controller as a compiled function without rounding of its actions, and its reverse.

    Args:
        controller: controller with the methods `initial_state` and `act` of a baseline.
        observation: first observations (N, size).

    Attributes:
        reverse: address of the reverse of the function.

    Raises:
        UntraceableError: a controller that uses more than arithmetic on arrays, keeps anything but its
            state, or converts a number that it keeps to a Python number.
        CompilerError: no compiler.
    """

    decides_branches: ClassVar[bool] = True

    def __init__(self, controller: Any, observation: Array) -> None:
        super().__init__(controller, observation)
        self.reverse = ctypes.cast(self._library[_REVERSE], ctypes.c_void_p)

    def _functions(self, traced: LiftedFunction) -> tuple[SymbolicFunction, ...]:
        if traced.fixed:
            lost = "converts a number that it keeps to a Python number, which has no derivative"
            raise UntraceableError(f"the controller {lost}.")
        smooth = unrounded(traced.function, _SMOOTH)
        return smooth, transposed(smooth, _REVERSE, ("observation", "state", "numbers"))
