"""Arrays that objects keep from one period to the next: as rows and back, and nothing else is kept."""

import copy
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
import pytest

from prp_gym.errors import UntraceableError
from prp_gym.symbolic.array import SymbolicArray
from prp_gym.symbolic.function import trace
from prp_gym.symbolic.lifting import trace_method
from prp_gym.symbolic.state_arrays import StateRows, attributes, require_same
from tests.symbolic.compilation import Array
from tests.symbolic.objects import Holder

COUNT = 4


class Model:
    """Keeps arrays with the environments along several axes.

    Args:
        count: number of environments N.
    """

    state_arrays: ClassVar[Mapping[str, int]] = {"motion": 1, "number": 0, "matrix": 2, "touching": 0}

    def __init__(self, count: int) -> None:
        generator = np.random.default_rng(count)
        self.motion = generator.normal(size=(2, count, 3))
        self.number = generator.normal(size=count)
        self.matrix = generator.normal(size=(2, 2, count))
        self.touching = generator.normal(size=(count, 2)) > 0.0


class Filter:
    """Keeps one array, and has another one that stays."""

    state_arrays: ClassVar[Mapping[str, int]] = {"level": 0}

    def __init__(self, count: int) -> None:
        self.level = np.arange(count, dtype=np.float64)[:, None]
        self.rate = np.array([0.5])


class Stateless:
    state_arrays: ClassVar[Mapping[str, int]] = {}


def owners(count: int = COUNT) -> Any:
    return Model(count), Stateless(), Filter(count)


SIZE = 2 * 3 + 1 + 2 * 2 + 2 + 1


def parts(row: Any) -> dict[str, Any]:
    """What a row holds, by the names of the arrays."""
    names = {"motion": (2, 3), "number": (), "matrix": (2, 2), "touching": (2,), "level": (1,)}
    last, found = 0, {}
    for name, shape in names.items():
        first, last = last, last + int(np.prod(shape))
        found[name] = row[first:last].reshape(shape)
    assert last == len(row)
    return found


def test_a_row_holds_the_arrays_of_one_environment() -> None:
    kept = owners()
    model, _, low = kept
    rows = StateRows(kept)
    assert rows.size == SIZE
    values: Array = rows.read(kept)
    assert values.shape == (COUNT, SIZE)
    for index, row in enumerate(values):
        found = parts(row)
        np.testing.assert_array_equal(found["motion"], model.motion[:, index])
        np.testing.assert_array_equal(found["number"], model.number[index])
        np.testing.assert_array_equal(found["matrix"], model.matrix[..., index])
        np.testing.assert_array_equal(found["touching"], model.touching[index])
        np.testing.assert_array_equal(found["level"], low.level[index])


@pytest.mark.parametrize("count", [1, COUNT])
def test_arrays_are_restored_from_rows(count: int) -> None:
    kept, others = owners(count), owners(count)
    rows = StateRows(owners(1))  # the shapes are those of one environment, whatever their number
    values = rows.read(kept)
    others[0].motion[:], others[0].touching[:], others[2].level[:] = 0.0, False, 0.0
    rows.write(others, values)
    for one, other in zip(kept, others, strict=True):
        for name in one.state_arrays:
            found = getattr(other, name)
            np.testing.assert_array_equal(found, getattr(one, name))
            assert found.dtype == getattr(one, name).dtype
    np.testing.assert_array_equal(rows.read(others), values)


def test_restored_arrays_may_be_overwritten() -> None:
    kept = owners()
    rows = StateRows(kept)
    values = rows.read(kept)
    rows.write(kept, values)
    before = values.copy()
    kept[0].motion[:], kept[2].level[:] = 7.0, 8.0
    np.testing.assert_array_equal(values, before)


def test_symbolic_arrays_make_the_same_round_trip() -> None:
    rows = StateRows(owners())

    def formula(row: Any) -> dict[str, Any]:
        own = owners(1)
        rows.write(own, row)
        model, _, low = own
        arrays = {"motion": model.motion, "number": model.number, "matrix": model.matrix}
        kept = {**arrays, "touching": model.touching, "level": low.level}
        for name, array in kept.items():
            assert isinstance(array, SymbolicArray), name
        assert all(node.is_boolean for node in kept["touching"].flat())
        doubled = {name: array if name == "touching" else 2.0 * array for name, array in kept.items()}
        model.number = model.number + 1.0
        model.touching = ~model.touching
        return {**doubled, "after": rows.read(own)}

    function = trace("round_trip", formula, {"row": (1, SIZE)})
    for row in rows.read(owners()):
        found = function.evaluate({"row": row[None]})
        expected = parts(row)
        for name, array in expected.items():
            axis = {"motion": 1, "matrix": 2}.get(name, 0)
            factor = 1.0 if name == "touching" else 2.0
            np.testing.assert_array_equal(found[name], np.expand_dims(factor * array, axis), err_msg=name)
        after = parts(found["after"][0])
        np.testing.assert_array_equal(after["number"], expected["number"] + 1.0)
        np.testing.assert_array_equal(after["touching"], 1.0 - expected["touching"])
        for name in ("motion", "matrix", "level"):
            np.testing.assert_array_equal(after[name], expected[name])


def test_objects_without_arrays_have_rows_without_columns() -> None:
    rows = StateRows([Stateless()])
    assert (rows.size, rows.arrays) == (0, [])
    assert rows.read([Stateless()]).shape == (1, 0)
    rows.write([Stateless()], np.zeros((COUNT, 0)))


def period(change: Callable[[Any, Any], None]) -> None:
    """Trace a period that changes an owner's attributes, some of which are declared."""
    owner = Keeper()
    rows = StateRows([owner])

    def formula(target: Any, x: Any) -> dict[str, Any]:
        rows.write([target], x)
        before = [attributes(target)]
        change(target, x)
        rows.require_unchanged([target], before)
        return {"after": rows.read([target])}

    trace_method("period", formula, owner, {"x": (1, rows.size)})


class Keeper:
    """Declares one of its attributes."""

    state_arrays: ClassVar[Mapping[str, int]] = {"level": 0}

    def __init__(self) -> None:
        self.level = np.zeros((1, 2))
        self.number, self.count, self.flag, self.name = 1.5, 3, False, "slow"
        self.gains, self.indices, self.mask = np.ones(2), np.arange(2), np.ones(2, dtype=bool)
        self.row, self.table, self.chosen = [1.0, [2.0]], {"a": 1.0}, {1, 2}
        self.nothing = None
        self.helper = Holder(level=0.0, owner=self)
        self.generator = np.random.default_rng(0)
        self.method = self.scaled

    def scaled(self, x: Any) -> Any:
        return self.gains * x


def in_place(name: str, key: Any, value: Any) -> Callable[[Any, Any], None]:
    return lambda target, _: getattr(target, name).__setitem__(key, value)


CHANGES: dict[str, tuple[str, Callable[[Any, Any], None]]] = {
    "number": ("number", lambda t, x: setattr(t, "number", t.number + 1.0)),
    "number_to_data": ("number", lambda t, x: setattr(t, "number", x[0, 0])),
    "number_to_a_known_one": ("number", lambda t, x: setattr(t, "number", 2.5)),
    "whole_number": ("count", lambda t, x: setattr(t, "count", t.count + 1)),
    "boolean": ("flag", lambda t, x: setattr(t, "flag", True)),
    "text": ("name", lambda t, x: setattr(t, "name", "fast")),
    "nothing_to_data": ("nothing", lambda t, x: setattr(t, "nothing", x)),
    "array_rebound": ("gains", lambda t, x: setattr(t, "gains", t.gains * 2.0)),
    "array_in_place": ("gains", lambda t, x: t.gains.__setitem__(0, x[0, 0])),
    "array_by_operator": ("gains", lambda t, x: t.gains.__iadd__(1.0)),
    "whole_numbers_in_place": ("indices", in_place("indices", 0, 5)),
    "truth_values_in_place": ("mask", in_place("mask", 0, False)),
    "list_in_place": ("row", in_place("row", 0, 3.0)),
    "list_longer": ("row", lambda t, x: t.row.append(x)),
    "list_in_a_list": ("row", lambda t, x: t.row[1].append(1)),
    "dictionary_in_place": ("table", in_place("table", "a", 2.0)),
    "dictionary_longer": ("table", in_place("table", "b", 2.0)),
    "set_in_place": ("chosen", lambda t, x: t.chosen.add(5)),
    "attribute_of_a_helper": ("helper", lambda t, x: setattr(t.helper, "level", x[0, 0])),
    "new_attribute_of_a_helper": ("helper", lambda t, x: setattr(t.helper, "other", 1)),
    "random_numbers": ("generator", lambda t, x: t.generator.normal()),
    "new": ("new", lambda t, x: setattr(t, "new", x)),
    "deleted": ("nothing", lambda t, x: delattr(t, "nothing")),
}


@pytest.mark.parametrize("name", CHANGES)
def test_what_is_kept_without_a_declaration_is_refused_by_name(name: str) -> None:
    attribute, change = CHANGES[name]
    with pytest.raises(
        UntraceableError, match=f"^Keeper keeps '{attribute}' from one call to the next, which"
    ):
        period(change)


ALLOWED: dict[str, Callable[[Any, Any], None]] = {
    "nothing": lambda t, x: None,
    "declared_rebound": lambda t, x: setattr(t, "level", 2.0 * t.level + x),
    "declared_in_place": lambda t, x: t.level.__setitem__((0, 1), x[0, 0]),
    "declared_through_a_helper": lambda t, x: setattr(t.helper.owner, "level", x),
    "read": lambda t, x: t.helper.level * t.gains[t.indices] + sum(t.chosen),
    "equal": lambda t, x: setattr(t, "gains", t.gains.copy()),
    "equal_number": lambda t, x: setattr(t, "count", 3),
}


@pytest.mark.parametrize("name", ALLOWED)
def test_declared_arrays_and_what_stays_the_same_are_accepted(name: str) -> None:
    period(ALLOWED[name])


def test_each_owner_declares_for_itself() -> None:
    """The name of another object's array gives no leave to keep it."""
    kept = owners(1)
    rows = StateRows(kept)
    before = [attributes(owner) for owner in kept]
    kept[0].motion[:] = 7.0
    kept[2].level[:] = 7.0
    rows.require_unchanged(kept, before)
    kept[2].motion = np.zeros(1)
    with pytest.raises(UntraceableError, match="Filter keeps 'motion'"):
        rows.require_unchanged(kept, before)


def test_numbers_are_compared_by_their_bits() -> None:
    owner = Holder(gain=np.array([np.nan, 0.0]), limit=np.nan)
    before = attributes(owner)
    owner.gain = copy.deepcopy(owner.gain)
    require_same(owner, before)
    owner.gain[1] = -0.0
    with pytest.raises(UntraceableError, match="Holder keeps 'gain'"):
        require_same(owner, before)
    require_same(owner, before, declared={"gain"})
