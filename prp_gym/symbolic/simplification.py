"""Simpler equal expressions: rules that never change a result's bits, apart from the sign of a zero."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from prp_gym.symbolic.operations import (
    ADD,
    AND,
    DIVIDE,
    MULTIPLY,
    NEGATIVE,
    NOT,
    NOT_EQUAL,
    OR,
    SUBTRACT,
    WHERE,
    Operation,
)

if TYPE_CHECKING:
    from prp_gym.symbolic.graph import Node


def simplified(operation: Operation, arguments: tuple[Node, ...]) -> Node | float | None:
    """A simpler node or the number that equals a result; None where there is none.

    The values are finite wherever the simulation runs, so that 0·x is 0.

    Args:
        operation: operation.
        arguments: nodes on which it works.
    """
    if all(node.is_constant for node in arguments):
        return operation.evaluate(*(node.value for node in arguments))
    rule = _RULES.get(operation)
    return None if rule is None else rule(*arguments)


def _sum(a: Node, b: Node) -> Node | None:
    if a.value == 0.0:
        return b
    return a if b.value == 0.0 else None


def _difference(a: Node, b: Node) -> Node | None:
    if b.value == 0.0:
        return a
    return -b if a.value == 0.0 else None


def _product(a: Node, b: Node) -> Node | float | None:
    for factor, other in ((a, b), (b, a)):
        if factor.value == 0.0:
            return 0.0
        if factor.value == 1.0:
            return other
        if factor.value == -1.0:
            return -other
    return None


def _quotient(a: Node, b: Node) -> Node | float | None:
    if a.value == 0.0:
        return 0.0
    return a if b.value == 1.0 else None


def _negative(a: Node) -> Node | None:
    return a.arguments[0] if a.operation is NEGATIVE else None


def _boolean(a: Node) -> Node:
    """Whether a number differs from zero."""
    return a if a.is_boolean else a.graph.apply(NOT_EQUAL, a, 0.0)


def _both(a: Node, b: Node) -> Node | float | None:
    for known, other in ((a, b), (b, a)):
        if known.is_constant:
            return _boolean(other) if known.value else 0.0
    return _boolean(a) if a is b else None


def _either(a: Node, b: Node) -> Node | float | None:
    for known, other in ((a, b), (b, a)):
        if known.is_constant:
            return 1.0 if known.value else _boolean(other)
    return _boolean(a) if a is b else None


def _opposite(a: Node) -> Node | None:
    return a.arguments[0] if a.operation is NOT and a.arguments[0].is_boolean else None


def _choice(condition: Node, yes: Node, no: Node) -> Node | None:
    if condition.is_constant:
        return yes if condition.value else no
    return yes if yes is no else None


_RULES: dict[Operation, Callable[..., Node | float | None]] = {
    ADD: _sum,
    SUBTRACT: _difference,
    MULTIPLY: _product,
    DIVIDE: _quotient,
    NEGATIVE: _negative,
    AND: _both,
    OR: _either,
    NOT: _opposite,
    WHERE: _choice,
}
