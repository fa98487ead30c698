"""Truncated quantile critics (TQC)."""

from pathlib import Path

from prp_gym.agents.algorithms.spec import AlgorithmEntry, AlgorithmSpec, RecipeScope, register_algorithm
from prp_gym.agents.sb3.actors import read_squashed_actor

SPEC = register_algorithm(
    AlgorithmSpec(
        name="tqc",
        summary="off-policy: truncated quantile critics",
        entry=AlgorithmEntry("sb3_contrib", "TQC", read_squashed_actor),
        recipes=Path(__file__).with_suffix(".yml"),
        scope=RecipeScope(replay_buffer=True),
    )
)
