"""Episodes of several candidates that compiled code runs, without a recording."""

import ctypes
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import CompilerError, UntraceableError
from prp_gym.evaluation.compiled_batch import begin, runs_compiled
from prp_gym.evaluation.compiled_controller import CompiledController, CompiledControllers
from prp_gym.evaluation.rollout import Policy
from prp_gym.robot.arrays import Array
from prp_gym.tasks.setup import COMPILED

MakeLoop = Callable[[int], Any]


class CompiledTotals(NamedTuple):
    """What the episodes of a candidate have given.

    Attributes:
        reward: sum of the rewards (episodes), up to the end of the episode [1].
        ended: control period (episodes), counted from 1, in which an episode diverged; 0 for none.
    """

    reward: Array
    ended: NDArray[np.intp]


def run_compiled(
    policies: Sequence[Policy], inner: Any, make_loop: MakeLoop, seeds: Sequence[int]
) -> dict[int, CompiledTotals]:
    """Whole episodes of those policies that compiled code can run.

    The gains of a controller are inputs of its compiled function: candidates that differ by their gains alone
    share it, and run in one call.

    Args:
        policies: candidates.
        inner: environment of this suite, without wrappers.
        make_loop: function that gives a loop of so many environments.
        seeds: seeds of the episodes of each of them.

    Returns:
        what the episodes have given, by the index of the policy; nothing for a policy that NumPy has to run:
        where the engine is not the compiled one, where its formulas cannot be traced or not be compiled, or
        where one of its actions was not finite.
    """
    fitting = [index for index, policy in enumerate(policies) if runs_compiled(policy, inner)]
    if not fitting or inner.config.engine != COMPILED:
        return {}
    _, _, observation = begin(make_loop, seeds)
    groups: dict[int, dict[int, CompiledController]] = {}
    found: dict[int, CompiledTotals] = {}
    for index in fitting:
        try:
            controller = CompiledController(policies[index], observation)
        except (UntraceableError, CompilerError):
            continue
        groups.setdefault(_address(controller.function), {})[index] = controller
    for group in groups.values():
        for index, totals in zip(group, _run_group(list(group.values()), make_loop, seeds), strict=False):
            if (totals.ended >= 0).all():
                found[index] = totals
    return found


def _address(function: ctypes.c_void_p) -> int:
    return function.value or 0


def _run_group(
    controllers: Sequence[CompiledController], make_loop: MakeLoop, seeds: Sequence[int]
) -> list[CompiledTotals]:
    """What the episodes of each controller have given; empty where compiled code cannot run them."""
    loop, _, observation = begin(make_loop, [*seeds] * len(controllers))
    try:
        totals = loop.score_episodes(CompiledControllers.of(controllers), observation)
    except UntraceableError:
        return []
    if totals is None:
        return []
    parts = [np.split(values, len(controllers)) for values in totals]
    return [CompiledTotals(*own) for own in zip(*parts, strict=True)]
