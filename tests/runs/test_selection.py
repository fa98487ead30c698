"""Which controllers a command runs if none is named."""

import pytest

from prp_gym.baselines import CONTROLLERS
from prp_gym.errors import CompilerError
from prp_gym.runs import selection
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.selection import Selection

SLOW = [name for name, spec in CONTROLLERS.items() if spec.policy.slow_without_compiler]


def names(selected: Selection) -> list[str]:
    return [choice.name for choice in selected.choices]


def without_compiled_code() -> None:
    raise CompilerError("there is none.")


def test_controller_that_is_slow_without_compiled_code_is_left_out_there_unless_it_is_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    gains = GainsChoice(TUNED)
    monkeypatch.setattr(selection, "require_compiled_code", lambda: None)
    every = Selection.of([], ["randomized"], [], gains)
    assert SLOW
    assert set(SLOW) <= set(names(every))
    assert (every.left_out, every.notes) == ((), ())
    monkeypatch.setattr(selection, "require_compiled_code", without_compiled_code)
    some = Selection.of([], ["randomized"], [], gains)
    assert names(some) == [name for name in names(every) if name not in SLOW]
    assert some.left_out == tuple(SLOW)
    assert [SLOW[0] in note for note in some.notes] == [True]
    named = Selection.of([], ["randomized"], SLOW, gains)
    assert names(named) == SLOW
    assert named.notes == ()
