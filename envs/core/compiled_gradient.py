"""`CompiledGradients`: scores of whole episodes and their derivatives by the numbers of a controller."""

import ctypes
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.core.compiled_run import CompiledPeriods
from prp_gym.envs.core.gradient_source import GradientSource
from prp_gym.robot.arrays import Array


class _Gradient(ctypes.Structure):
    """`prp_gradient` of the C code.

    Attributes:
        reverse: reverse of the controller.
        count: number of the controller's numbers.
        weight: weight of a period's reward in the score.
        score: scores.
        numbers: derivatives of each score by the controller's numbers.
        state: derivatives of each score by the controller's initial state.
    """

    _fields_: ClassVar = [
        ("reverse", ctypes.c_void_p),
        ("count", ctypes.c_long),
        ("weight", ctypes.c_double),
        *((name, ctypes.c_void_p) for name in ("score", "numbers", "state")),
    ]


class EpisodeGradients(NamedTuple):
    """Scores of N episodes and their derivatives.

    Attributes:
        score: scores (N).
        by_numbers: derivatives by the controller's numbers (N, P).
        by_state: derivatives by the controller's initial state (N, S).
        ended: see `EpisodeRecord`.
    """

    score: Array
    by_numbers: Array
    by_state: Array
    ended: NDArray[np.intp]


class CompiledGradients(CompiledPeriods):
    """Whole episodes of a loop with the derivatives of their scores; afterwards the loop cannot be used.

    Args:
        loop: Loop of N environments with the compiled engine, all of which have just been reset.

    Raises:
        UntraceableError: a task whose formulas cannot be traced.
    """

    def __init__(self, loop: Any) -> None:
        super().__init__(loop)
        self._library.prp_differentiate.argtypes = (ctypes.c_long, ctypes.c_long, *(ctypes.c_void_p,) * 2)
        self.load()

    def _make_source(self, loop: Any) -> GradientSource:
        return GradientSource(loop)

    def differentiate(self, controller: Any, observation: Array) -> EpisodeGradients:
        """Run whole episodes.

        Args:
            controller: `ReversibleController`.
            observation: Observations (N, size) after the reset of all environments.

        Returns:
            Scores and their derivatives.

        Raises:
            UntraceableError: a controller whose state is too large.
            MemoryError: not enough memory for the tape of an episode.
        """
        rows = len(observation)
        self._give_controller(controller, observation)
        score, ended = np.zeros(rows), np.zeros(rows, dtype=np.intp)
        numbers, state = (
            np.zeros((rows, controller.numbers.shape[-1])),
            np.zeros(controller.initial_state.shape),
        )
        self._set({"ended": ended})
        request = _Gradient(controller.reverse, numbers.shape[1], 1.0 / self._loop.config.horizon)
        request.score, request.numbers, request.state = (
            array.ctypes.data for array in (score, numbers, state)
        )
        address = ctypes.addressof(request)

        def run_rows(first: int, count: int, plan: Any) -> bool:
            if not self._library.prp_differentiate(first, count, plan, address):
                raise MemoryError("not enough memory for the tape of an episode")
            return True

        self._loop.physics.run(run_rows, self._loop.config.substeps, self.given.address)
        return EpisodeGradients(score, numbers, state, ended)
