"""`score_gradient`: the derivatives of a controller's score by its settings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from prp_gym.gradients.differentiated_episodes import DifferentiatedEpisodes
from prp_gym.gradients.settings_derivative import by_settings
from prp_gym.robot.arrays import Array


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
        diverged: mask (N) of episodes that ended in a divergence, up to which scores are differentiated.
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
    episodes = DifferentiatedEpisodes(env, controller, seeds)
    declared = getattr(controller, "settings", None) is not None
    return ScoreGradient(
        tuple(int(seed) for seed in seeds),
        episodes.scores,
        by_settings(episodes, controller) if declared else {},
        episodes.by_number,
        episodes.ended > 0,
    )
