"""Twin delayed deep deterministic policy gradient (TD3)."""

from pathlib import Path

from prp_gym.agents.algorithms.spec import AlgorithmEntry, AlgorithmSpec, RecipeScope, register_algorithm
from prp_gym.agents.sb3.actors import read_deterministic_actor

SPEC = register_algorithm(
    AlgorithmSpec(
        name="td3",
        summary="off-policy: twin delayed deep deterministic policy gradient",
        entry=AlgorithmEntry("stable_baselines3", "TD3", read_deterministic_actor),
        recipes=Path(__file__).with_suffix(".yml"),
        scope=RecipeScope(replay_buffer=True),
    )
)
