"""`shared`: pure functions that are computed once while many quantities follow from the same arrays."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any, ParamSpec, TypeVar

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class _Scope(threading.local):
    """What is known in the present thread; nothing outside of `sharing`."""

    known: dict[tuple[Any, ...], tuple[Any, Any]] | None = None


_SCOPE = _Scope()


@contextmanager
def sharing() -> Iterator[None]:
    """Compute a shared function once for the same arguments, in the context and in this thread.

    Its arguments, which are told apart by identity, and its results must not change in the context.
    """
    before, _SCOPE.known = _SCOPE.known, {}
    try:
        yield
    finally:
        _SCOPE.known = before


def shared(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """A pure function whose results are kept in the context of `sharing`, and nowhere else."""

    @wraps(function)
    def once(*arguments: Arguments.args, **more: Arguments.kwargs) -> Result:
        known = _SCOPE.known
        if known is None or more:
            return function(*arguments, **more)
        key = function, *map(id, arguments)
        found = known.get(key)
        if found is None:  # the arguments are kept, so that no identity is used twice
            found = known[key] = arguments, function(*arguments, **more)
        result: Result = found[1]
        return result

    return once
