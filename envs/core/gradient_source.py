"""The C source of whole episodes and the derivatives of their scores."""

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from prp_gym.envs.core.period_source import PeriodSource
from prp_gym.symbolic.c_source import c_function
from prp_gym.symbolic.derivatives import transposed
from prp_gym.symbolic.function import SymbolicFunction

_HAND_WRITTEN = Path(__file__).with_name("compiled_gradient.c")

_GRADIENT = """
typedef void (*prp_controller_reverse)(
    const double *observation, const double *state, const double *input, const double *numbers,
    const double *d_action, const double *d_after, double *d_observation, double *d_state, double *d_numbers);
typedef struct {
    prp_controller_reverse reverse;
    long count;
    double weight, *score, *numbers, *state;
} prp_gradient;
"""


class GradientSource(PeriodSource):
    """Compiled episodes with the derivatives of their scores; see `PeriodSource`.

    Args:
        loop: loop of environments with the compiled engine, all of which have been reset.
    """

    def __init__(self, loop: Any) -> None:
        self._derivatives = loop.physics.derivatives_source
        super().__init__(loop)

    def _source(self, physics: str, functions: Sequence[SymbolicFunction]) -> str:
        reverse = [
            _reversed(self.judge, ("observation", "reward", "after"), ("measured", "command", "memory")),
            _reversed(self.actuate, ("command", "torque", "after"), ("action", "memory")),
        ]
        text = super()._source(f"#include <stdlib.h>\n{physics}\n{self._derivatives}", functions)
        hand_written = _HAND_WRITTEN.read_text(encoding="utf-8")
        return "\n".join([text, _GRADIENT, *map(c_function, reverse), hand_written])


@lru_cache(maxsize=64)
def _reversed(
    function: SymbolicFunction, results: tuple[str, ...], wanted: tuple[str, ...]
) -> SymbolicFunction:
    """The reverse of a function, for some of its results."""
    part = SymbolicFunction(
        function.name, function.inputs, {name: function.outputs[name] for name in results}
    )
    return transposed(part, f"{function.name}_reverse", wanted)
