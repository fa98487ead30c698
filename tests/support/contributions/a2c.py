"""Advantage actor-critic (A2C)."""

from pathlib import Path

from prp_gym.agents.algorithms.spec import AlgorithmEntry, AlgorithmSpec, register_algorithm
from prp_gym.agents.sb3.actors import read_gaussian_actor

SPEC = register_algorithm(
    AlgorithmSpec(
        name="a2c",
        summary="on-policy: advantage actor-critic",
        entry=AlgorithmEntry("stable_baselines3", "A2C", read_gaussian_actor),
        recipes=Path(__file__).with_suffix(".yml"),
    )
)
