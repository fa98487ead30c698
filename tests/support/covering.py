"""Few combinations of two things that show what the many show: a rule instead of the full product."""

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Sequence
from typing import TypeVar

First = TypeVar("First", bound=Hashable)
Second = TypeVar("Second", bound=Hashable)
Third = TypeVar("Third")


def one_of_each(
    combinations: Iterable[tuple[First, Second]], kind: Callable[[tuple[First, Second]], Hashable]
) -> list[tuple[First, Second]]:
    """A combination of every kind, in their given order, with members as various as a greedy choice finds.

    Kinds with few combinations choose before the others, each the one whose members were chosen least.

    Args:
        combinations: all that are possible.
        kind: what a combination shows; others of the same kind show nothing more.
    """
    possible = list(combinations)
    kinds = sorted(_grouped(possible, kind).values(), key=len)
    return _chosen(possible, kinds)


def covering(
    combinations: Iterable[tuple[First, Second]], kind: Callable[[tuple[First, Second]], Hashable]
) -> list[tuple[First, Second]]:
    """As `one_of_each`, and every first and every second member at least once."""
    possible = list(combinations)
    kinds = sorted(_grouped(possible, kind).values(), key=len)
    members = {**_grouped(possible, _first), **_grouped(possible, _second)}
    return _chosen(possible, [*kinds, *members.values()])


def by_turns(
    rows: Iterable[First], columns: Iterable[Second], choices: Sequence[Third]
) -> list[tuple[First, Second, Third]]:
    """Every row with every column, and one of the choices each, so that every column has all of them.

    Args:
        rows: first members; at least as many as there are choices.
        columns: second members, with which each row is combined.
        choices: third members; each combination takes the next one.
    """
    return [
        (first, second, choices[(row + column) % len(choices)])
        for row, first in enumerate(rows)
        for column, second in enumerate(columns)
    ]


def _chosen(
    possible: list[tuple[First, Second]], groups: list[list[tuple[First, Second]]]
) -> list[tuple[First, Second]]:
    chosen: set[tuple[First, Second]] = set()
    count = Counter[tuple[int, Hashable]]()
    for group in groups:
        if chosen.isdisjoint(group):
            best = min(group, key=lambda each: (count[_first(each)], count[_second(each)]))
            chosen.add(best)
            count.update((_first(best), _second(best)))
    return [each for each in possible if each in chosen]


def _grouped(
    combinations: list[tuple[First, Second]], key: Callable[[tuple[First, Second]], Hashable]
) -> dict[Hashable, list[tuple[First, Second]]]:
    groups: dict[Hashable, list[tuple[First, Second]]] = {}
    for each in combinations:
        groups.setdefault(key(each), []).append(each)
    return groups


def _first(combination: tuple[Hashable, Hashable]) -> tuple[int, Hashable]:
    return 1, combination[0]


def _second(combination: tuple[Hashable, Hashable]) -> tuple[int, Hashable]:
    return 2, combination[1]
