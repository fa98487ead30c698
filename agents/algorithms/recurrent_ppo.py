"""Proximal policy optimisation with a recurrent network (RecurrentPPO)."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from prp_gym.agents.algorithms.spec import AlgorithmEntry, AlgorithmSpec, RecipeScope, register_algorithm
from prp_gym.agents.sb3.actors import read_recurrent_actor
from prp_gym.errors import InvalidValueError

_SIZE = 128  # of the algorithm's own `n_steps` and `batch_size`


def check_batches(settings: Mapping[str, Any], n_envs: int) -> None:
    """Refuse batches of one sample, whose normalised advantage is NaN.

    Raises:
        InvalidValueError: a batch size that leaves a batch of one sample.
    """
    samples, size = settings.get("n_steps", _SIZE) * n_envs, settings.get("batch_size", _SIZE)
    if settings.get("normalize_advantage", True) and 1 in (size, samples, samples % size):
        allowed = f"a number that splits n_steps * n_envs, {samples}, into batches of 2 or more"
        raise InvalidValueError("batch_size", size, allowed)


SPEC = register_algorithm(
    AlgorithmSpec(
        name="recurrent_ppo",
        summary="on-policy: proximal policy optimisation with LSTM layers",
        entry=AlgorithmEntry("sb3_contrib", "RecurrentPPO", read_recurrent_actor),
        recipes=Path(__file__).with_suffix(".yml"),
        scope=RecipeScope(policies=("MlpLstmPolicy",), check=check_batches),
    )
)
