"""Truncated quantile critics (TQC)."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from prp_gym.agents.algorithms.spec import AlgorithmEntry, AlgorithmSpec, RecipeScope, register_algorithm
from prp_gym.agents.sb3.actors import read_squashed_actor
from prp_gym.errors import InvalidValueError

_QUANTILES, _DROPPED = 25, 2  # of the algorithm's own settings


def check_quantiles(settings: Mapping[str, Any], n_envs: int) -> None:
    """Refuse settings that drop every quantile of the critics, which would make all weights NaN.

    Raises:
        InvalidValueError: as many dropped quantiles as there are, or more.
    """
    quantiles = settings.get("policy_kwargs", {}).get("n_quantiles", _QUANTILES)
    dropped = settings.get("top_quantiles_to_drop_per_net", _DROPPED)
    if dropped >= quantiles:
        raise InvalidValueError(
            "top_quantiles_to_drop_per_net", dropped, f"less than n_quantiles, {quantiles}"
        )


SPEC = register_algorithm(
    AlgorithmSpec(
        name="tqc",
        summary="off-policy: truncated quantile critics",
        entry=AlgorithmEntry("sb3_contrib", "TQC", read_squashed_actor),
        recipes=Path(__file__).with_suffix(".yml"),
        scope=RecipeScope(replay_buffer=True, check=check_quantiles),
    )
)
