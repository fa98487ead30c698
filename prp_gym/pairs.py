"""What is evaluated: a law on an environment in a scenario, played in whichever process."""

from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import gymnasium

from prp_gym.baselines import list_baselines, make_baseline
from prp_gym.evaluation.evaluate import episodes_to_play, evaluate
from prp_gym.evaluation.results import describe_evaluation, to_plain

Record = dict[str, Any]
"""An evaluation as the results file holds it."""


@dataclass(frozen=True)
class Pair:
    """A law on an environment, and all that its evaluation depends on.

    Attributes:
        environment_id: for `gymnasium.make`.
        scenario: of the environment.
        law: a baseline.
        gains: gain set of the law.
        control_frequency: actions a second [Hz].
        episodes: that are played, 1 in a deterministic scenario.
        seed: of the first episode.
    """

    environment_id: str
    scenario: str
    law: str
    gains: str
    control_frequency: float
    episodes: int
    seed: int

    @property
    def name(self) -> str:
        """Unlike that of every other pair of the same evaluation."""
        return f"{self.environment_id}_{self.scenario}_{self.law}"


def play_pair(pair: Pair) -> Record:
    """The record of a pair, which is the same wherever it is played but for the law's compute time."""
    with closing(_environment(pair.environment_id, pair.scenario, pair.control_frequency)) as env:
        policy = make_baseline(pair.law, env, pair.gains)
        evaluation = evaluate(policy, env, pair.episodes, pair.seed)
        settings = {"gains": pair.gains, **vars(policy.settings)}
        record: Record = to_plain(describe_evaluation(evaluation, pair.law, settings))
        return record


def list_pairs(
    places: Iterable[tuple[str, str]],
    laws: Sequence[str],
    gains: str,
    control_frequency: float,
    episodes: int,
    seed: int,
) -> list[Pair]:
    """The laws that can run on each environment, tried out before anything is played.

    Args:
        places: environment ids and scenarios.
        laws: baselines.
        gains: gain set of the laws.
        control_frequency: actions a second [Hz].
        episodes: of each pair, where they are not all the same.
        seed: of the first episode.

    Raises:
        UnknownNameError: a gain set that one of the laws lacks.
        InvalidValueError: a control frequency at which the gains of one of the laws are unstable.
    """
    pairs = []
    for environment_id, scenario in places:
        with closing(_environment(environment_id, scenario, control_frequency)) as env:
            eligible = list_baselines(env.get_wrapper_attr("observation_layout"))
            count = episodes_to_play(env, episodes)
            for law in (name for name in laws if name in eligible):
                make_baseline(law, env, gains)
                pairs.append(Pair(environment_id, scenario, law, gains, control_frequency, count, seed))
    return pairs


def _environment(environment_id: str, scenario: str, control_frequency: float) -> gymnasium.Env[Any, Any]:
    return gymnasium.make(environment_id, scenario=scenario, control_frequency=control_frequency)
