"""The C source of control periods is traced once for all loops of a kind, and anew for another kind."""

from contextlib import closing
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.envs.core import period_source
from prp_gym.envs.core.period_source import PeriodSource
from prp_gym.symbolic import lifting
from tests.support.compiler import needs_compiler

pytestmark = needs_compiler

TRACKING = "PRP-PoseTracking-v0"


def loop_of(scenario: str, environment_id: str = TRACKING) -> Any:
    with closing(gymnasium.make(environment_id, scenario=scenario, engine="compiled")) as env:
        env.reset(seed=0)
        return env.unwrapped.loop  # type: ignore[attr-defined]


@pytest.mark.parametrize("scenario", ["randomized", "realistic"])
def test_a_second_loop_is_not_traced_again(scenario: str, monkeypatch: pytest.MonkeyPatch) -> None:
    first = PeriodSource(loop_of(scenario))
    loop = loop_of(scenario)

    def refuse(*_: Any, **__: Any) -> None:
        raise AssertionError

    monkeypatch.setattr(period_source, "trace", refuse)
    monkeypatch.setattr(lifting, "_trace_with", refuse)
    second = PeriodSource(loop)
    assert second.text == first.text
    assert second.references is not None
    np.testing.assert_array_equal(second.numbers, first.numbers)


class Slowed:
    """What a reference of another package may hold.

    Args:
        rate: share of the time that passes for the reference.
    """

    def __init__(self, rate: float) -> None:
        self.rate = rate


KINDS: dict[type, type] = {}


def slow_kind(own: Any) -> type:
    def sample(self: Any, time: Any, ids: Any = None) -> Any:
        return own.sample(self, time * self.slow.rate, ids)

    return KINDS.setdefault(own, type("SlowReference", (own,), {"sample": sample}))


def slowed(loop: Any, rate: float) -> Any:
    """A loop whose reference holds a number of its own, deep inside, by which it runs slower."""
    reference = loop.task.parts.reference
    reference.__class__ = slow_kind(type(reference))
    reference.slow = Slowed(rate)
    return loop


def test_references_with_other_constants_are_traced_anew() -> None:
    plain, half, third = (
        PeriodSource(loop).text
        for loop in (
            loop_of("randomized"),
            slowed(loop_of("randomized"), 0.5),
            slowed(loop_of("randomized"), 0.3125),
        )
    )
    assert len({plain, half, third}) == 3
    assert "0.5" in half.partition("prp_refer(")[2]
    assert "0.3125" in third.partition("prp_refer(")[2]


def test_every_field_is_recorded_by_itself() -> None:
    loop = loop_of("randomized", "PRP-Force-v0")
    recorded = PeriodSource(loop).text.partition("prp_record_fields(")[2].partition("}")[0]
    layout = loop.task.ground_truth_layout
    assert recorded.count("memcpy") == len(layout.names)
    for part in layout.slices.values():
        assert f"present + {part.start}, {part.stop - part.start} * sizeof" in recorded
