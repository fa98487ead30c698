"""Proximal policy optimisation (PPO)."""

from pathlib import Path

from prp_gym.agents.algorithms.spec import AlgorithmEntry, AlgorithmSpec, register_algorithm
from prp_gym.agents.sb3.actors import read_gaussian_actor

SPEC = register_algorithm(
    AlgorithmSpec(
        name="ppo",
        summary="on-policy: proximal policy optimisation",
        entry=AlgorithmEntry("stable_baselines3", "PPO", read_gaussian_actor),
        recipes=Path(__file__).with_suffix(".yml"),
    )
)
