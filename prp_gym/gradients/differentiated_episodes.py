"""`DifferentiatedEpisodes`: scores of episodes, and how they change with a controller to first order."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np

from prp_gym.envs.action_mode import TORQUE
from prp_gym.envs.core.compiled_gradient import CompiledGradients
from prp_gym.envs.core.make_loop import make_loop
from prp_gym.errors import InvalidValueError, NonFiniteError, PRPError, UntraceableError
from prp_gym.evaluation.compiled_batch import begin
from prp_gym.evaluation.compiled_controller import CONSTANTS, ControllerFormula
from prp_gym.gradients.reversible_controller import ReversibleController
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.lifting import numbers_of, structure_of
from prp_gym.tasks.setup import COMPILED


class DifferentiatedEpisodes:
    """Episodes of a controller, one for each seed, with the derivatives of their scores.

    Args:
        env: environment of this suite with joint torques as actions, wrapped or not, of either engine.
        controller: controller for this environment, whose formulas can be traced.
        seeds: seeds of the episodes, at least one.

    Attributes:
        scores: score of each episode (N).
        ended: control period (N), counted from 1, in which an episode diverged; 0 for none.
        by_number: derivatives of the mean score by the numbers that the controller keeps (P).

    Raises:
        InvalidValueError: no seeds; an environment with another action mode.
        UntraceableError: a task or controller whose formulas cannot be traced.
        NonFiniteError: an action that is not finite.
        CompilerError: no compiler.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], controller: Any, seeds: Sequence[int]) -> None:
        inner: Any = env.unwrapped
        _check(inner, controller, seeds)
        config = replace(inner.config, engine=COMPILED)
        loop, _, self._observation = begin(
            lambda count: make_loop(inner.make_task, config, count, num_threads=0), seeds
        )
        found = CompiledGradients(loop).differentiate(
            ReversibleController(controller, self._observation), self._observation
        )
        if (found.ended < 0).any():
            raise NonFiniteError("action of the periods", (-found.ended[found.ended < 0]).tolist())
        self.scores, self.ended = found.score, found.ended
        self.by_number: Array = found.by_numbers.mean(axis=0)
        self._by_numbers, self._by_state = found.by_numbers, found.by_state
        self._formula = ControllerFormula(controller, self._observation)

    def differences(self, more: Any, less: Any) -> Array | None:
        """The differences of the scores of two controllers nearby, to first order.

        Args:
            more: a controller with the numbers and the initial state that the scores are differentiated by.
            less: another one.

        Returns:
            the difference in each episode (N); None for controllers of another structure than each other,
            such as one with an integral action and one without.
        """
        if structure_of(more, CONSTANTS) != structure_of(less, CONSTANTS):
            return None
        (numbers, state), (numbers_less, state_less) = self._read(more), self._read(less)
        equal = numbers == numbers_less  # infinite ones among them
        change = np.where(equal, 0.0, numbers - np.where(equal, 0.0, numbers_less))
        found: Array = self._by_numbers @ change + (self._by_state * (state - state_less)).sum(axis=1)
        return found

    def derivatives(self, make: Callable[[float], Any], step: float) -> Array | None:
        """The derivatives of the scores along a change of the controller, by differences of what it keeps.

        A controller computes what it keeps from its settings once, when it is made. These formulas are smooth
        and have no noise, so that differences give their derivatives to about eight digits; where one side is
        refused they are one-sided.

        Args:
            make: makes the controller at a distance along the change, 0 for the present one; it may raise a
                `PRPError` for others.
            step: distance of the differences, whose error is of the order of its square, relative to the
                scale of the change, and 1e-16 over it.

        Returns:
            the derivative in each episode (N); None where there is none: both sides are refused, or have
            another structure, see `differences`.
        """
        here = make(0.0)

        def change(distance: float) -> Array | None:
            try:
                return self.differences(make(distance), here)
            except PRPError:
                return None

        above, below = change(step), change(-step)
        if above is not None and below is not None:
            return (above - below) / (2.0 * step)
        for once, direction in ((above, 1.0), (below, -1.0)):
            twice = change(2.0 * direction * step)
            if once is not None and twice is not None:
                return direction * (4.0 * once - twice) / (2.0 * step)
        return None

    def _read(self, controller: Any) -> tuple[Array, Array]:
        """The numbers of a controller (P), and its state in the first period of each episode (N, S)."""
        observed = controller.interface.layout.split(self._observation)
        state = self._formula.row(controller.initial_state(observed), len(self._observation))
        return numbers_of(controller, CONSTANTS), state


def _check(inner: Any, controller: Any, seeds: Sequence[int]) -> None:
    """Refuse what has no derivatives."""
    if not len(seeds):
        raise InvalidValueError("seeds", "[]", "at least one")
    if inner.action_mode != TORQUE:
        raise InvalidValueError(
            "action_mode", inner.action_mode, f"{TORQUE!r}, for a controller's derivatives"
        )
    if not getattr(type(controller), "compiled", False):
        raise UntraceableError(f"{type(controller).__name__} computes its actions in its own predict method.")
