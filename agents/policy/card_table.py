"""The card of an agent as a table, and its training as columns of numbers."""

from collections.abc import Iterator

import numpy as np

from prp_gym.agents.policy.agent_card import AgentCard
from prp_gym.robot.arrays import Array
from prp_gym.tables import ResultTable
from prp_gym.tables.column import prose_column, text_column


def card_table(card: AgentCard) -> ResultTable:
    """What an agent is, in a few lines.

    Args:
        card: description of the agent.
    """
    title = f"agent for {card.environment_id}"
    return ResultTable.of(title, (text_column("fact"), prose_column("value")), _facts(card))


def _facts(card: AgentCard) -> Iterator[tuple[str, str]]:
    yield "algorithm", card.algorithm
    yield "action mode", card.action_mode
    yield "control frequency", f"{card.control_frequency:g} Hz"
    yield "engine of the training", card.engine
    yield "training seed", f"{card.seed}"
    yield "training", f"{card.steps} steps, {card.run.seconds / 60.0:.1f} minutes"
    yield "network", " - ".join(map(str, _layers(card)))
    for name, score in card.scores.items():
        interval = f"95 % interval {score.low:.3f}-{score.high:.3f}"
        yield f"score, scenario {name}", f"{score.value:.3f}, {interval}, {score.episodes} episodes"


def _layers(card: AgentCard) -> tuple[int, ...]:
    network = card.network
    return (network.inputs, *network.memory, *network.hidden, network.outputs)


def learning_columns(card: AgentCard) -> dict[str, Array]:
    """The evaluations of a training as columns of numbers, each (evaluations).

    Args:
        card: description of the agent.

    Returns:
        `steps`, `seconds` of training and `simulated_seconds` [s], `score` [1], and `violations_<kind>`.
    """
    curve = card.run.curve
    kinds = dict.fromkeys(kind for point in curve for kind in point.violations)
    steps = np.array([point.steps for point in curve], dtype=np.float64)
    return {
        "steps": steps,
        "seconds": np.array([point.seconds for point in curve], dtype=np.float64),
        "simulated_seconds": steps / card.control_frequency,
        "score": np.array([point.score for point in curve], dtype=np.float64),
        **{
            f"violations_{kind}": np.array([point.violations.get(kind, 0.0) for point in curve])
            for kind in kinds
        },
    }
