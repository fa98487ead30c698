"""The scalar operations of expression graphs: each one's function of NumPy, C text and derivative."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from prp_gym.symbolic.graph import Node

Adjoint = Callable[..., "tuple[Node | float, ...]"]
"""From the derivative of a quantity by a result, that result and the arguments: its derivatives by these."""


@dataclass(frozen=True, eq=False)
class Operation:
    """One operation on scalars.

    Attributes:
        name: name of the operation.
        ufunc: function of NumPy with the same result, bit for bit.
        text: C expression, with `{0}`, `{1}`, ... for the arguments.
        adjoint: derivatives; None for an operation whose derivative is zero wherever it exists.
        boolean: whether the result is a truth value.
        scalar: function of `math` where NumPy's last bit depends on the kind of CPU; None elsewhere.
        commutes: whether the order of the two arguments is irrelevant.
        exact: whether every machine and library rounds the result alike, as IEEE 754 demands.
    """

    name: str
    ufunc: np.ufunc | Callable[..., Any]
    text: str
    adjoint: Adjoint | None = None
    boolean: bool = False
    scalar: Callable[..., float] | None = None
    commutes: bool = False
    exact: bool = True

    def evaluate(self, *values: float) -> float:
        """The result of numbers."""
        if self.scalar is not None:
            try:
                return self.scalar(*values)
            except (ValueError, OverflowError):
                pass  # NaN or infinity, of which every library has the same
        with np.errstate(all="ignore"):
            return float(self.ufunc(*values))

    def of_arrays(self, *values: Any) -> Any:
        """The results of arrays that broadcast, element by element."""
        if self is WHERE:
            return np.where(*values)
        if self.scalar is not None:
            return np.vectorize(self.evaluate, otypes=[np.float64])(*values)
        with np.errstate(all="ignore"):
            return self.ufunc(*values)


def _apply(operation: Operation, node: Node, *others: Node | float) -> Node:
    return node.graph.apply(operation, node, *others)


def _choose(condition: Node, yes: Node | float, no: Node | float) -> Node:
    return condition.graph.apply(WHERE, condition, yes, no)


def _power(g: Node, y: Node, a: Node, b: Node) -> tuple[Node, Node]:
    return g * b * _apply(POWER, a, b - 1.0), g * y * _apply(LOGARITHM, a)


def _arc_tangent(g: Node, _: Node, y: Node, x: Node) -> tuple[Node, Node]:
    square = x * x + y * y
    return g * x / square, -(g * y) / square


ADD: Operation = Operation("add", np.add, "{0} + {1}", lambda g, _, a, b: (g, g), commutes=True)
SUBTRACT: Operation = Operation("subtract", np.subtract, "{0} - {1}", lambda g, _, a, b: (g, -g))
MULTIPLY: Operation = Operation(
    "multiply", np.multiply, "{0} * {1}", lambda g, _, a, b: (g * b, g * a), commutes=True
)
DIVIDE: Operation = Operation(
    "divide", np.divide, "(double){0} / {1}", lambda g, y, a, b: (g / b, -(g * y) / b)
)
NEGATIVE: Operation = Operation("negative", np.negative, "-{0}", lambda g, _, a: (-g,))
SINE: Operation = Operation("sin", np.sin, "sin({0})", lambda g, _, a: (g * _apply(COSINE, a),), exact=False)
COSINE: Operation = Operation(
    "cos", np.cos, "cos({0})", lambda g, _, a: (-(g * _apply(SINE, a)),), exact=False
)
SQUARE_ROOT: Operation = Operation(
    "sqrt",
    np.sqrt,
    "sqrt({0})",
    # at zero, where a length has no derivative, zero stands between those of its two sides
    lambda g, y, a: (_choose(_apply(GREATER, y, 0.0), g / (y + y), 0.0),),
)
EXPONENTIAL: Operation = Operation(
    "exp", np.exp, "exp({0})", lambda g, y, a: (g * y,), scalar=math.exp, exact=False
)
LOGARITHM: Operation = Operation(
    "log", np.log, "log({0})", lambda g, _, a: (g / a,), scalar=math.log, exact=False
)
POWER: Operation = Operation(
    "power",
    np.float_power,  # not numpy.power, whose last bits formulas with ** have in NumPy
    "pow({0}, {1})",
    _power,
    scalar=math.pow,
    exact=False,
)
ARC_TANGENT: Operation = Operation(
    "arctan2", np.arctan2, "atan2({0}, {1})", _arc_tangent, scalar=math.atan2, exact=False
)
ABSOLUTE: Operation = Operation("absolute", np.absolute, "fabs({0})", lambda g, _, a: (g * _apply(SIGN, a),))
COPY_SIGN: Operation = Operation(
    "copysign",
    np.copysign,
    "copysign({0}, {1})",
    lambda g, _, a, b: (g * _apply(SIGN, a) * _apply(SIGN, b), 0.0),
)
SIGN: Operation = Operation("sign", np.sign, "({0} != {0} ? {0} : (double)(({0} > 0.0) - ({0} < 0.0)))")
FLOOR: Operation = Operation("floor", np.floor, "floor({0})")
ROUND: Operation = Operation("rint", np.rint, "rint({0})")
SINGLE: Operation = Operation(
    "single",
    lambda value: np.float64(np.float32(value)),
    "(double)(float){0}",
    lambda g, _, a: (g,),  # of the number that is rounded
)
REMAINDER: Operation = Operation(
    "remainder",
    np.remainder,
    "prp_remainder({0}, {1})",
    lambda g, _, a, b: (g, -(g * _apply(FLOOR, a / b))),
)
MINIMUM: Operation = Operation(
    "minimum",
    np.minimum,
    "({0} < {1} || {0} != {0} ? {0} : {1})",
    lambda g, _, a, b: (_choose(_apply(LESS, a, b), g, 0.0), _choose(_apply(LESS, a, b), 0.0, g)),
    commutes=True,
)
MAXIMUM: Operation = Operation(
    "maximum",
    np.maximum,
    "({0} > {1} || {0} != {0} ? {0} : {1})",
    lambda g, _, a, b: (_choose(_apply(GREATER, a, b), g, 0.0), _choose(_apply(GREATER, a, b), 0.0, g)),
    commutes=True,
)
LESS: Operation = Operation("less", np.less, "{0} < {1}", boolean=True)
LESS_EQUAL: Operation = Operation("less_equal", np.less_equal, "{0} <= {1}", boolean=True)
GREATER: Operation = Operation("greater", np.greater, "{0} > {1}", boolean=True)
GREATER_EQUAL: Operation = Operation("greater_equal", np.greater_equal, "{0} >= {1}", boolean=True)
EQUAL: Operation = Operation("equal", np.equal, "{0} == {1}", boolean=True, commutes=True)
NOT_EQUAL: Operation = Operation("not_equal", np.not_equal, "{0} != {1}", boolean=True, commutes=True)
AND: Operation = Operation("logical_and", np.logical_and, "{0} && {1}", boolean=True, commutes=True)
OR: Operation = Operation("logical_or", np.logical_or, "{0} || {1}", boolean=True, commutes=True)
NOT: Operation = Operation("logical_not", np.logical_not, "!{0}", boolean=True)
WHERE: Operation = Operation(
    "where",
    lambda condition, yes, no: yes if condition else no,
    "{0} ? {1} : {2}",
    lambda g, _, condition, yes, no: (0.0, _choose(condition, g, 0.0), _choose(condition, 0.0, g)),
)

OPERATIONS = tuple(value for value in globals().values() if isinstance(value, Operation))

C_FUNCTIONS = """\
static inline double prp_remainder(double a, double b)
{
    const double rest = fmod(a, b);
    return rest != 0.0 && (rest < 0.0) != (b < 0.0) ? rest + b : rest;
}
"""
"""C functions that the texts above call and the mathematical library lacks."""
