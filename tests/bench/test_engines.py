"""The comparison of the engines: what every program measures, and the ratios of the table."""

import pytest

from bench.engines import Comparison, Program, comparisons, measure, row_of
from bench.rounds import FREE, REACHER
from prp_gym.tasks.setup import COMPILED, MUJOCO
from tests.support.compiler import needs_compiler


@needs_compiler
@pytest.mark.parametrize(
    "program",
    [
        Program("single", REACHER, "", ""),
        Program("single", FREE, COMPILED),
        Program("bare", FREE),
        Program("held", FREE, MUJOCO),
    ],
)
def test_every_kind_of_program_has_a_rate(program: Program) -> None:
    assert measure(program, 0.001) > 0.0


def test_ratio_is_the_median_over_the_rounds() -> None:
    one, other = Program("vector", FREE, COMPILED), Program("vector", FREE)
    rates = {one: [30.0, 20.0, 64.0], other: [2.0, 2.0, 2.0]}
    row = row_of(Comparison("step", one, other, 16.0), rates)
    assert (row["ratio"], row["range"], row["result"]) == ("15.0", "10.0 to 32.0", "missed")


def test_programs_of_a_comparison_differ_in_what_is_compared() -> None:
    found = list(comparisons())
    assert {one.program.kind for one in found} == {"single", "vector", "evaluate", "held", "gradient"}
    assert all(one.program != one.reference for one in found)
