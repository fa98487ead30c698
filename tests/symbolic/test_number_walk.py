"""The numbers that objects hold, wherever they are; all else is structure."""

import enum
import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from prp_gym.errors import UntraceableError
from prp_gym.symbolic.lifting import numbers_of, structure_of
from tests.symbolic.objects import Bounds, Filter, Holder, Line, X, result, traced

pytestmark = pytest.mark.usefixtures("nothing_known")


class Another(Holder):
    """The same of another class."""


@dataclass(frozen=True, slots=True)
class Slotted:
    rate: float


class Extended(Slotted):
    """Slots of a base, and a dictionary of its own."""


class Mode(enum.Enum):
    SLOW = 0.25
    FAST = 4.0


class Level(float, enum.Enum):
    LOW = 0.25
    HIGH = 4.0


NEVER, ALWAYS = object(), object()


WHEREVER: dict[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
    "itself": (lambda number: number, lambda target: target),
    "attribute": (lambda number: Holder(gain=number), lambda target: target.gain),
    "nested_attribute": (lambda number: Holder(a=Holder(b=number)), lambda target: target.a.b),
    "tuple": (lambda number: (1, number), lambda target: target[1]),
    "named_tuple": (lambda number: Bounds(number, 1), lambda target: target.low),
    "list": (lambda number: [[], [number]], lambda target: target[1][0]),
    "dictionary": (lambda number: {"a": {1: number}}, lambda target: target["a"][1]),
    "frozen_dataclass": (Filter, lambda target: target.rate),
    "slots": (Slotted, lambda target: target.rate),
    "slots_of_a_base": (Extended, lambda target: target.rate),
    "bound_method": (lambda number: Line(number).value, lambda target: target(1.0)),
    "array": (lambda number: np.full((2, 2), number), lambda target: target[1, 0]),
    "array_without_dimension": (np.array, lambda target: target),
    "scalar_of_numpy": (np.float64, lambda target: target),
}


@pytest.mark.parametrize("name", WHEREVER)
def test_numbers_are_inputs_wherever_they_are(name: str) -> None:
    make, read = WHEREVER[name]
    one, other = make(2.5), make(-4.0)
    lifted = traced(lambda target, x: read(target) * x, one)
    assert set(numbers_of(one)) == {2.5}
    assert lifted.fixed == {}
    assert traced(lambda target, x: read(target) * x, other) is lifted
    np.testing.assert_array_equal(result(lifted, one), 2.5 * X)
    np.testing.assert_array_equal(result(lifted, other), -4.0 * X)


def twice(x: Any) -> Any:
    return 2.0 * x


def half(x: Any) -> Any:
    return 0.5 * x


class Doubling:
    factor = 2.0


class Halving:
    factor = 0.5


STRUCTURE: dict[str, tuple[Any, Any, Callable[[Any, Any], Any]]] = {
    "whole_number": (2, 3, lambda value, x: value * x),
    "large_whole_number": (10**9, 10**9 + 1, lambda value, x: value * x),
    "boolean_and_number": (True, 1, lambda value, x: 2.0 * x if value is True else x),
    "booleans": (True, False, lambda value, x: 2.0 * x if value else x),
    "text": ("slow", "fast", lambda value, x: 2.0 * x if value == "slow" else x),
    "slice": (slice(0, 1), slice(1, 3), lambda value, x: x[value].sum() + x),
    "range": (range(1), range(2), lambda value, x: sum(x[i] for i in value) + x),
    "whole_numbers": (np.array([0, 1, 2]), np.array([2, 1, 0]), lambda value, x: x[value]),
    "integers_of_numpy": (np.int64(1), np.int64(2), lambda value, x: value * x),
    "single_precision": (np.float32(0.1), np.float32(0.2), lambda value, x: value * np.float32(0.3) * x),
    "truth_values": (X > 0.0, X < 0.0, lambda value, x: np.where(value, x, 0.0)),
    "function": (twice, half, lambda value, x: value(x)),
    "class": (Doubling, Halving, lambda value, x: value.factor * x),
    "module": (math, np, lambda value, x: 2.0 * x if value is math else x),
    "value_of_a_member": (Mode.SLOW, Mode.FAST, lambda value, x: value.value * x),
    "member_of_an_enumeration": (Mode.SLOW, Mode.FAST, lambda value, x: x if value is Mode.SLOW else -x),
    "member_that_is_a_number": (Level.LOW, Level.HIGH, lambda value, x: x if value is Level.LOW else -x),
    "object_without_attributes": (NEVER, ALWAYS, lambda value, x: x if value is ALWAYS else -x),
    "bound_methods": (Line(2.0).value, Line(2.0).shifted, lambda value, x: value(x)),
    "set": ({1}, {1, 2}, lambda value, x: len(value) * x),
    "nothing": (None, 1, lambda value, x: x if value is None else 2.0 * x),
}


@pytest.mark.parametrize("name", STRUCTURE)
def test_all_else_is_structure_and_has_functions_of_its_own(name: str) -> None:
    one, other, formula = STRUCTURE[name]
    targets = [Holder(part=value, gain=3.0) for value in (one, other)]

    def whole(target: Any, x: Any) -> Any:
        return target.gain + formula(target.part, x)

    functions = [traced(whole, target) for target in targets]
    assert functions[0] is not functions[1]
    assert structure_of(targets[0]) != structure_of(targets[1])
    for lifted, target in zip(functions, targets, strict=True):
        assert structure_of(target) == structure_of(target)
        assert traced(whole, target) is lifted
        np.testing.assert_array_equal(result(lifted, target), whole(target, X))


def test_an_object_that_is_found_twice_is_one() -> None:
    filtered = Line(2.0)
    shared, apart = Holder(a=filtered, b=filtered), Holder(a=filtered, b=Line(2.0))

    def formula(target: Any, x: Any) -> Any:
        target.a.slope = target.a.slope * 10.0
        return target.b.slope * x

    np.testing.assert_array_equal(numbers_of(shared), [2.0])
    np.testing.assert_array_equal(numbers_of(apart), [2.0, 2.0])
    assert structure_of(shared) != structure_of(apart)
    np.testing.assert_array_equal(result(traced(formula, shared), shared), 20.0 * X)
    np.testing.assert_array_equal(result(traced(formula, apart), apart), 2.0 * X)


def of_itself() -> Any:
    target = Holder(gain=2.0)
    target.again = target
    return target


def parent_and_child() -> Any:
    target = Holder(children=[Holder(gain=2.0)])
    target.children[0].parent = target
    return target.children[0]


def method_of_its_own() -> Any:
    line: Any = Line(2.0)
    line.method = line.value
    return Holder(gain=2, line=line, method=line.method)


def list_in_itself() -> Any:
    row: list[Any] = [2.0]
    row.append((row,))
    return Holder(gain=2, row=row)


@pytest.mark.parametrize("make", [of_itself, parent_and_child, method_of_its_own, list_in_itself])
def test_objects_may_lead_back_to_themselves(make: Callable[[], Any]) -> None:
    np.testing.assert_array_equal(numbers_of(make()), [2.0])
    assert structure_of(make()) == structure_of(make())
    target = make()
    np.testing.assert_array_equal(result(traced(lambda one, x: one.gain * x, target), target), 2.0 * X)


def test_what_leads_back_leads_to_the_copy() -> None:
    def changed(target: Any, x: Any) -> Any:
        target.gain = 3.0 * x[0]
        return target.again.again.gain * x

    np.testing.assert_array_equal(result(traced(changed, of_itself()), of_itself()), 3.0 * X[0] * X)


ONE, OTHER = Line(1.0), Line(2.0)
DIFFERENT: dict[str, tuple[Any, Any]] = {
    "class": (Holder(gain=2.0), Another(gain=2.0)),
    "attribute": (Holder(gain=2.0), Holder(limit=2.0)),
    "further_attribute": (Holder(gain=2.0), Holder(gain=2.0, name="")),
    "shape": (Holder(gain=np.ones(3)), Holder(gain=np.ones((1, 3)))),
    "number_and_array": (Holder(gain=2.0), Holder(gain=np.array(2.0))),
    "number_and_whole_number": (Holder(gain=2.0), Holder(gain=2)),
    "order_of_attributes": (Holder(gain=2.0, limit=1.0), Holder(limit=1.0, gain=2.0)),
    "length": (Holder(row=[2.0]), Holder(row=[2.0, 2.0])),
    "nesting_of_lists": (Holder(row=[[2.0], 2.0]), Holder(row=[[2.0, 2.0]])),
    "nesting_of_tuples": (Holder(row=((2.0,), 2.0)), Holder(row=((2.0, 2.0),))),
    "which_is_found_again": (Holder(row=[ONE, OTHER, ONE]), Holder(row=[ONE, OTHER, OTHER])),
    "container": (Holder(row=[2.0]), Holder(row=(2.0,))),
    "key": (Holder(row={"a": 2.0}), Holder(row={"b": 2.0})),
    "identity": (Holder(part=object()), Holder(part=object())),
}


@pytest.mark.parametrize("name", DIFFERENT)
def test_objects_of_another_structure_have_another_function(name: str) -> None:
    one, other = DIFFERENT[name]
    functions = [traced(lambda _, x: x + 1.0, target) for target in (one, other)]
    assert functions[0] is not functions[1]
    assert [traced(lambda _, x: x + 1.0, target) for target in (one, other)] == functions


def test_a_structure_stays_another_when_its_objects_are_gone() -> None:
    """The address of an object that is gone may be that of the next one."""
    assert len({structure_of(Holder(part=object())) for _ in range(20)}) == 20


def test_numbers_of_constants_are_no_inputs() -> None:
    def formula(target: Any, x: Any) -> Any:
        return target.gain * x + target.line.value(x)

    targets = [Holder(gain=gain, line=Line(slope)) for gain, slope in ((2.0, 3.0), (4.0, 3.0), (2.0, 5.0))]
    functions = [traced(formula, target, constants=(Line,)) for target in targets]
    assert functions[0] is functions[1]
    assert functions[0] is not functions[2]
    for lifted, target in zip(functions, targets, strict=True):
        numbers = numbers_of(target, (Line,))
        np.testing.assert_array_equal(numbers, [target.gain])
        found = lifted.function.evaluate({"x": X, "numbers": numbers})["y"]
        np.testing.assert_array_equal(found, formula(target, X))


def test_objects_of_which_no_copy_can_be_made_are_refused_by_name() -> None:
    with pytest.raises(UntraceableError, match="an object that holds a lock cannot be traced"):
        traced(lambda target, x: x, Holder(lock=threading.Lock()))
