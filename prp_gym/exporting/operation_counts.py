"""How many operations of which kind a call of generated code executes."""

from collections import Counter
from collections.abc import Mapping

from prp_gym.symbolic import operations as op
from prp_gym.symbolic.function import SymbolicFunction
from prp_gym.symbolic.operations import Operation

KINDS: Mapping[str, tuple[Operation, ...]] = {
    "additions and subtractions": (op.ADD, op.SUBTRACT, op.NEGATIVE),
    "multiplications": (op.MULTIPLY,),
    "divisions": (op.DIVIDE,),
    "sqrt": (op.SQUARE_ROOT,),
    "sin and cos": (op.SINE, op.COSINE),
    "exp, log, pow, atan2, fmod": (op.EXPONENTIAL, op.LOGARITHM, op.POWER, op.ARC_TANGENT, op.REMAINDER),
    "fabs, copysign, floor, rint, float": (op.ABSOLUTE, op.COPY_SIGN, op.FLOOR, op.ROUND, op.SINGLE),
    "comparisons": (op.LESS, op.LESS_EQUAL, op.GREATER, op.GREATER_EQUAL, op.EQUAL, op.NOT_EQUAL),
    "and, or, not": (op.AND, op.OR, op.NOT),
    "choices (a ? b : c)": (op.WHERE, op.MINIMUM, op.MAXIMUM, op.SIGN),
}
"""The operations of generated code by what they cost, in words."""

_KIND_OF = {operation: kind for kind, group in KINDS.items() for operation in group}


def count_operations(function: SymbolicFunction) -> dict[str, int]:
    """How often a call of a function executes the operations of each kind.

    Every call executes all of them, except for the parts of a choice that a compiler turns into a branch.

    Args:
        function: symbolic function.
    """
    found = Counter(_KIND_OF[node.operation] for node in function.nodes() if node.operation is not None)
    return {kind: found[kind] for kind in KINDS}
