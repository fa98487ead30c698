"""Proximal policy optimisation with a recurrent network (RecurrentPPO)."""

from pathlib import Path

from prp_gym.agents.algorithms.spec import AlgorithmEntry, AlgorithmSpec, RecipeScope, register_algorithm
from prp_gym.agents.sb3.actors import read_recurrent_actor

SPEC = register_algorithm(
    AlgorithmSpec(
        name="recurrent_ppo",
        summary="on-policy: proximal policy optimisation with LSTM layers",
        entry=AlgorithmEntry("sb3_contrib", "RecurrentPPO", read_recurrent_actor),
        recipes=Path(__file__).with_suffix(".yml"),
        scope=RecipeScope(policies=("MlpLstmPolicy",)),
    )
)
