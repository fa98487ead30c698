"""`score_gradient`: the derivatives of a controller's score by its settings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import seeding
from numpy.typing import NDArray

from prp_gym.baselines.base.settings import Settings
from prp_gym.envs.action_mode import TORQUE
from prp_gym.envs.core.compiled_gradient import CompiledGradients, EpisodeGradients
from prp_gym.envs.core.make_loop import make_loop
from prp_gym.errors import InvalidValueError, NonFiniteError, UntraceableError
from prp_gym.evaluation.compiled_controller import CONSTANTS, ControllerFormula
from prp_gym.gradients.reversible_controller import ReversibleController
from prp_gym.gradients.settings_derivative import by_settings
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.lifting import numbers_of
from prp_gym.tasks.setup import COMPILED


@dataclass(frozen=True, eq=False)
class ScoreGradient:
    """Scores of episodes and the derivatives of their mean.

    Attributes:
        seeds: seeds of the episodes (N).
        scores: score of each episode (N).
        by_setting: derivatives of the mean score by the controller's settings, by name, each of the shape of
            the setting [1 / unit of the setting]; empty for a controller without declared settings.
        by_number: derivatives of the mean score by all numbers that the controller keeps (P), in the order of
            `prp_gym.symbolic.lifting.numbers_of`.
        diverged: which episodes (N) ended in a divergence, up to which their scores are differentiated.
    """

    seeds: tuple[int, ...]
    scores: Array
    by_setting: Mapping[str, Array]
    by_number: Array
    diverged: NDArray[np.bool_]

    @property
    def score(self) -> float:
        """The mean score."""
        return float(self.scores.mean())


def score_gradient(env: gymnasium.Env[Any, Any], controller: Any, seeds: Sequence[int]) -> ScoreGradient:
    """The exact derivatives of a controller's mean score by its settings, through contact.

    Whole episodes are simulated with the compiled engine and differentiated by reverse accumulation: through
    the reward, sensors, joint stops, Coulomb friction, contact, actuators and the controller with its state.
    Where a formula has a switch (a limit, a first touch), the derivative is that of the branch that was
    taken; the score as a function of the settings may jump there, of which no derivative tells. Actions are
    not rounded to single precision, which moves scores by about 1e-7.

    Args:
        env: environment of this suite with joint torques as actions, wrapped or not, of either engine.
        controller: controller for this environment, whose formulas can be traced.
        seeds: seeds of the episodes, at least one.

    Returns:
        scores and derivatives.

    Raises:
        InvalidValueError: no seeds; an environment with another action mode.
        UntraceableError: a task or controller whose formulas cannot be traced.
        NonFiniteError: an action that is not finite.
        CompilerError: no compiler.

    Source: Griewank 2008, 3.2.
    """
    if not len(seeds):
        raise InvalidValueError("seeds", "[]", "at least one")
    found, reversible = _differentiated(env.unwrapped, controller, seeds)
    if (found.ended < 0).any():
        raise NonFiniteError("action", found.ended)
    return ScoreGradient(
        tuple(int(seed) for seed in seeds),
        found.score,
        _by_setting(controller, reversible, found),
        found.by_numbers.mean(axis=0),
        found.ended > 0,
    )


def _differentiated(
    inner: Any, controller: Any, seeds: Sequence[int]
) -> tuple[EpisodeGradients, ReversibleController]:
    """The episodes of some seeds with their derivatives, and the controller in compiled code."""
    if inner.action_mode != TORQUE:
        raise InvalidValueError(
            "action_mode", inner.action_mode, f"{TORQUE!r}, for a controller's derivatives"
        )
    if not getattr(type(controller), "compiled", False):
        raise UntraceableError(f"{type(controller).__name__} computes its actions in its own predict method.")
    loop = make_loop(inner.make_task, replace(inner.config, engine=COMPILED), len(seeds), num_threads=0)
    rngs = [seeding.np_random(int(seed))[0] for seed in seeds]
    observation = loop.reset(np.arange(len(seeds)), rngs, {})
    reversible = ReversibleController(controller, observation)
    return CompiledGradients(loop).run(reversible, observation), reversible


def _by_setting(
    controller: Any, reversible: ReversibleController, found: EpisodeGradients
) -> dict[str, Array]:
    """The derivatives of the mean score by the settings, through numbers and initial state."""
    if not isinstance(getattr(controller, "settings", None), Settings):
        return {}
    observation = reversible.first_observation
    observed = controller.interface.layout.split(observation)
    rows, formula = len(observation), ControllerFormula(controller, observation)

    def read(other: Any) -> Array:
        state = formula.row(other.initial_state(observed), rows)
        return np.concatenate([numbers_of(other, CONSTANTS), state.ravel()])

    weights = np.concatenate([found.by_numbers.mean(axis=0), found.by_state.ravel() / rows])
    derivatives = by_settings(controller, read)
    return {
        name: (derivative @ weights).reshape(np.shape(getattr(controller.settings, name)))
        for name, derivative in derivatives.items()
    }
