"""`SingleArray`: expressions that were rounded to single precision."""

from typing import Any, Self

from prp_gym.symbolic.array import SymbolicArray, untraceable


class SingleArray(SymbolicArray):
    """Expressions in the place of an array of float32.

    NumPy would compute with it in single precision, as generated code does not. Its elements can be chosen
    and rearranged, and it can be converted to double precision.
    """

    __slots__ = ()

    def astype(self, dtype: Any) -> SymbolicArray:
        """As that of an array."""
        return SymbolicArray(self.graph, self.nodes).astype(dtype)

    def sum(self, axis: int | None = None, keepdims: bool = False) -> Self:
        """As that of an array, which is a sum in single precision."""
        raise untraceable("a sum in single precision")

    def __setitem__(self, key: Any, value: Any) -> None:
        raise untraceable("an assignment in single precision")

    def __array_ufunc__(self, *_: Any, **__: Any) -> Any:
        raise untraceable("arithmetic in single precision")

    def __array_function__(self, function: Any, *_: Any) -> Any:
        raise untraceable(f"numpy.{function.__name__} in single precision")
