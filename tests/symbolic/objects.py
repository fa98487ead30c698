"""What tests of functions of objects share: objects of some kinds, and formulas of them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from prp_gym.symbolic.lifting import LiftedFunction, numbers_of, trace_method
from tests.symbolic.compilation import Array

X = np.array([0.75, -1.5, 2.0])


class Holder:
    """Attributes of any name."""

    def __init__(self, **attributes: Any) -> None:
        vars(self).update(attributes)

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

        def __setattr__(self, name: str, value: Any) -> None: ...


class Bounds(NamedTuple):
    low: float
    high: float


@dataclass(frozen=True)
class Filter:
    rate: float
    order: int = 2


class Line:
    def __init__(self, slope: float) -> None:
        self.slope = slope

    def value(self, x: Any) -> Any:
        return self.slope * x

    def shifted(self, x: Any) -> Any:
        return self.slope + x


def traced(
    formula: Callable[[Any, Any], Any],
    target: Any,
    kind: Any = "kind",
    constants: tuple[type, ...] = (),
) -> LiftedFunction:
    """A formula of objects and x (3)."""
    return trace_method(
        "formula", lambda parts, x: {"y": formula(parts, x)}, target, {"x": X.shape}, constants, kind
    )


def result(lifted: LiftedFunction, target: Any, x: Array = X) -> Array:
    """The result for some objects, none of whose numbers may be among the constants of others."""
    numbers = numbers_of(target)
    assert lifted.serves(numbers)
    return lifted.function.evaluate({"x": x, "numbers": numbers})["y"]
