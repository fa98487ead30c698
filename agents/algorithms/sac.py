"""Soft actor-critic (SAC)."""

from pathlib import Path

from prp_gym.agents.algorithms.spec import AlgorithmEntry, AlgorithmSpec, RecipeScope, register_algorithm
from prp_gym.agents.sb3.actors import read_squashed_actor

SPEC = register_algorithm(
    AlgorithmSpec(
        name="sac",
        summary="off-policy: soft actor-critic",
        entry=AlgorithmEntry("stable_baselines3", "SAC", read_squashed_actor),
        recipes=Path(__file__).with_suffix(".yml"),
        scope=RecipeScope(replay_buffer=True),
    )
)
