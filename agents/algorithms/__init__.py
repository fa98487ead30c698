"""The learning algorithms: one declaration a file, beside the recipes of the algorithm."""

from prp_gym.agents.algorithms.spec import (
    ALGORITHMS,
    AlgorithmEntry,
    AlgorithmSpec,
    RecipeScope,
    register_algorithm,
)

__all__ = ["ALGORITHMS", "AlgorithmEntry", "AlgorithmSpec", "RecipeScope", "register_algorithm"]
