"""`make_frame`: columns of numbers as a DataFrame of pandas, which is an extra."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from prp_gym.extras import require

if TYPE_CHECKING:
    from pandas import DataFrame as DataFrame


def make_frame(columns: Mapping[str, Any], units: Mapping[str, Sequence[str]]) -> "DataFrame":
    """A data frame with one column for each component of some quantities.

    Args:
        columns: values by quantity, each (rows) or (rows, components).
        units: units of the components by quantity, as far as they are known.

    Returns:
        a frame whose columns have the names of the quantities, followed by `_1`, `_2`, ... for several
        components; `frame.attrs["units"]` has the units by column.

    Raises:
        MissingPackageError: pandas is not installed.
    """
    pandas = require("pandas")
    named: dict[str, Any] = {}
    shown: dict[str, str] = {}
    for name, values in columns.items():
        parts = components_of(name, values)
        named |= parts
        shown |= dict(zip(parts, units.get(name, ()), strict=False))
    frame: DataFrame = pandas.DataFrame(named)
    frame.attrs["units"] = shown
    return frame


def components_of(name: str, values: Any) -> dict[str, Any]:
    """The components of a quantity by the names of their columns.

    Args:
        name: name of the quantity.
        values: values (rows) or (rows, components).
    """
    if getattr(values, "ndim", 1) == 1:
        return {name: values}
    if values.shape[1] == 1:
        return {name: values[:, 0]}
    return {f"{name}_{index + 1}": column for index, column in enumerate(values.T)}
