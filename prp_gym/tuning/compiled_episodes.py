"""Episodes of several candidates that compiled code runs, without a recording."""

import ctypes
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from prp_gym.errors import CompilerError, UntraceableError
from prp_gym.evaluation.compiled_batch import begin, runs_compiled
from prp_gym.evaluation.compiled_controller import CompiledController, CompiledControllers
from prp_gym.evaluation.rollout import Policy
from prp_gym.tasks.episode_totals import EpisodeTotals
from prp_gym.tasks.setup import COMPILED

MakeLoop = Callable[[int], Any]


def run_compiled(
    policies: Sequence[Policy], inner: Any, make_loop: MakeLoop, seeds: Sequence[int]
) -> dict[int, EpisodeTotals]:
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
    found: dict[int, EpisodeTotals] = {}
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
) -> list[EpisodeTotals]:
    """What the episodes of each controller have given; empty where compiled code cannot run them."""
    loop, _, observation = begin(make_loop, [*seeds] * len(controllers))
    try:
        totals = loop.score_episodes(CompiledControllers.of(controllers), observation)
    except UntraceableError:
        return []
    if totals is None:
        return []
    parts = [np.split(values, len(controllers)) for values in totals]
    return [EpisodeTotals(*own) for own in zip(*parts, strict=True)]
