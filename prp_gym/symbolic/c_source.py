"""C code of symbolic functions: straight-line arithmetic that needs the mathematical library alone."""

from collections.abc import Iterable, Iterator
from functools import lru_cache

from prp_gym.symbolic.function import SymbolicFunction
from prp_gym.symbolic.graph import Node
from prp_gym.symbolic.operations import C_FUNCTIONS

PREAMBLE = f"#include <math.h>\n\n{C_FUNCTIONS}"
"""What stands once before the functions of a file."""


@lru_cache(maxsize=256)
def c_function(function: SymbolicFunction, linkage: str = "static inline") -> str:
    """A C function that computes a symbolic function, with the same operations in the same order.

    Its arguments are pointers to the inputs' and then to the outputs' components; none may overlap an output.

    Args:
        function: symbolic function.
        linkage: what stands before `void`.
    """
    arguments = [f"const double *restrict {name}" for name in function.inputs]
    arguments += [f"double *restrict {name}" for name in function.outputs]
    lines = "".join(c_statements(function))
    return f"{linkage} void {function.name}(\n    {_comma(arguments)})\n{{\n{lines}}}\n"


def _comma(parts: Iterable[str]) -> str:
    return ",\n    ".join(parts)


def c_statements(function: SymbolicFunction) -> Iterator[str]:
    """The C statements, line by line, that compute a symbolic function.

    They read the arrays that are named as the inputs, and at the end write those named as the outputs.

    Args:
        function: symbolic function.
    """
    names: dict[Node, str] = {}
    for node in function.nodes():
        if node.is_input:
            names[node] = node.name
        elif node.operation is None:
            names[node] = c_literal(node.value)
        else:
            names[node] = f"t{node.index}"
            kind = "int" if node.is_boolean else "double"
            text = node.operation.text.format(*(names[argument] for argument in node.arguments))
            yield f"    const {kind} {names[node]} = {text};\n"
    for name, array in function.outputs.items():
        for position, node in enumerate(array.flat()):
            yield f"    {name}[{position}] = {names[node]};\n"


def c_literal(value: float) -> str:
    """The C text of a number with all digits."""
    if value != value or abs(value) == float("inf"):
        return "NAN" if value != value else ("INFINITY" if value > 0.0 else "(-INFINITY)")
    return repr(value) if value >= 0.0 and not str(value).startswith("-") else f"({value!r})"
