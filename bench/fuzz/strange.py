"""Values that no user means, shared by all classes of cases."""

import decimal
import fractions
import random
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

NAN, INFINITY = float("nan"), float("inf")


class Hostile:
    """An object all of whose methods raise errors of their own."""

    __hash__ = None  # type: ignore[assignment]

    def _refuse(self, *_: object) -> Any:
        raise RuntimeError("a hostile object")

    __repr__ = __str__ = __eq__ = __len__ = __bool__ = __float__ = __iter__ = __array__ = _refuse


def _endless() -> list[Any]:
    endless: list[Any] = []
    endless.append(endless)
    return endless


def _deep(depth: int) -> list[Any]:
    value: list[Any] = []
    for _ in range(depth):
        value = [value]
    return value


NUMBERS: tuple[Any, ...] = (
    *(0, 1, -1, 2, 3, 7, 100, 10**400, -(10**400), 10**6000, 2**31, 2**53 + 1, 2**63, 2**64, 2**128),
    *(0.0, -0.0, 0.5, 1.0, -1.5, 1e3, 1e6, 1e9, 1e12, 1e30, 1e150, 1e308, -1e308, 5e-324, 1e-300, 1e-9),
    *(NAN, INFINITY, -INFINITY, np.float16(2), np.float32("inf"), np.float64(0.5), np.int8(-1)),
    *(np.uint64(2**64 - 1), np.longdouble("1e4000"), np.longdouble("nan"), np.bool_(True), True, False),
    *(1j, complex(NAN, 1), decimal.Decimal("0.5"), fractions.Fraction(1, 3)),
)
TEXTS: tuple[Any, ...] = (
    *("", " ", "a", "nan", "1.0", "None", "\0", "../..", "é\u202e", "x" * 10**5, "-1", "os:system"),
    *("torque", "report", "realistic", "rgb_array", "top", "sine", "home", "tuned", "joint_pd", "NextStep"),
    *(np.str_("torque"), b"torque", b"", bytearray(b"torque"), Path("torque")),
)
ARRAYS: tuple[Any, ...] = (
    *(np.zeros(0), np.zeros(1), np.zeros(3), np.ones(6), np.zeros((3, 3)), np.zeros((1, 3)), np.array(0.5)),
    *(np.zeros((2, 3)), np.zeros((0, 3)), np.full(3, NAN), np.full(3, INFINITY), np.full(3, 1e308)),
    *(np.full(3, 5e-324), np.full((2, 3), NAN), np.zeros(3, dtype=np.float32), np.ones(3, dtype=np.int64)),
    *(np.ones(3, dtype=bool), np.ones(2, dtype=bool), np.zeros(3, dtype=complex), np.zeros(10**4)),
    *(np.array("torque"), np.array(["torque"]), np.array(["a", "b"]), np.array([None, 1], dtype=object)),
    *(np.array([10**400, 1, 2], dtype=object), np.full(3, np.longdouble("1e4000")), np.zeros((3,) * 9)),
    *(
        np.datetime64("2020-01-01"),
        np.timedelta64(1),
        np.zeros(3, dtype=[("x", float)]),
        np.ma.MaskedArray(np.zeros(3), True),
    ),
)
CONTAINERS: tuple[Any, ...] = (
    *([], (), {}, set(), [[]], [1, 2, 3], (0.1, 0.2, 0.3), [0.1] * 6, (1.0,), [NAN] * 3, [1, [2, 3]]),
    *(["a", "b", "c"], [None] * 3, [True] * 3, {"a": 1}, {1: 2}, {None: None}, {"joint_position": [0, 0, 0]}),
    *(
        frozenset((1, 2)),
        range(3),
        range(10**12),
        memoryview(b"abc"),
        _endless(),
        _deep(500),
    ),
    *({"reset_mask": [True]}, [1e308] * 3, [1j] * 3, [10**400] * 3, [np.zeros(3)] * 3),
)
OBJECTS: tuple[Any, ...] = (None, object(), int, Ellipsis, NotImplemented, print, slice(3), Hostile(), np)

POOL = (*NUMBERS, *TEXTS, *ARRAYS, *CONTAINERS, *OBJECTS)

_SPECIAL = tuple(number for number in NUMBERS if isinstance(number, float))
_SEEDS = st.integers(0, 2**40)


def _number(rng: random.Random) -> float:
    """A special number, one of any magnitude, or a usual one."""
    way = rng.randrange(4)
    if way == 0:
        return float(rng.choice(_SPECIAL))
    if way == 1:
        return float(rng.choice((-1, 1)) * 10.0 ** rng.uniform(-320, 308))
    return rng.uniform(-2.0, 2.0)


def _value(seed: int) -> Any:
    """The value of a seed: one of the pool, a number, a text, a list or a vector."""
    rng = random.Random(seed)
    way = rng.randrange(10)
    if way < 5:
        return POOL[rng.randrange(len(POOL))]
    if way == 5:
        return _number(rng)
    if way == 6:
        return rng.randrange(-300, 300)
    if way == 7:
        return [POOL[rng.randrange(len(POOL))] for _ in range(rng.randrange(4))]
    numbers = [_number(rng) for _ in range(rng.choice((1, 3, 3, 6)))]
    return numbers if way == 8 else np.array(numbers)


STRANGE: st.SearchStrategy[Any] = _SEEDS.map(_value)
"""Any value: strange ones, and plain numbers and vectors. One draw gives it, since draws take the time."""

FLOATS: st.SearchStrategy[float] = _SEEDS.map(lambda seed: _number(random.Random(seed)))
"""Floating-point numbers of all magnitudes, NaN and infinity among them."""

VECTORS: st.SearchStrategy[Any] = _SEEDS.map(
    lambda seed: np.array([_number(rng) for rng in [random.Random(seed)] for _ in range(3)])
)
"""Vectors of three such numbers."""


def mostly(likely: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    """A likely value three times of four, else a strange one."""
    return st.one_of(likely, likely, likely, STRANGE)


def named(names: Sequence[str], values: st.SearchStrategy[Any]) -> st.SearchStrategy[dict[str, Any]]:
    """Up to two values by names."""
    one = st.tuples(st.sampled_from(names), values).map(lambda item: {item[0]: item[1]})
    return st.one_of(one, st.tuples(one, one).map(lambda both: {**both[0], **both[1]}))


def replaced(size: int) -> st.SearchStrategy[dict[int, float]]:
    """Components of a vector, by index, that strange numbers replace."""

    def parts(seed: int) -> dict[int, float]:
        rng = random.Random(seed)
        return {rng.randrange(size): _number(rng) for _ in range(rng.choice((0, 1, 1, 2, 3)))}

    return _SEEDS.map(parts)
