"""The comparison of the engines: what every program measures, and the ratios of the table."""

import json
from pathlib import Path

import pytest

from bench.engine_programs import Program, measure
from bench.engines import STORED, Comparison, cells, comparisons, row_of, section, write_section
from bench.rounds import FREE, REACHER
from prp_gym.tasks.setup import COMPILED, MUJOCO
from tests.support.compiler import needs_compiler

ROOT = Path(__file__).parents[2]


@needs_compiler
@pytest.mark.parametrize(
    "program",
    [
        Program("single", REACHER, "", ""),
        Program("single", FREE, COMPILED),
        Program("single", REACHER, "", "", without_clock=True),
        Program("reset", FREE),
        Program("vector", FREE, COMPILED, all_cores=True),
        Program("bare", FREE),
        Program("held", FREE, MUJOCO),
    ],
)
def test_every_kind_of_program_has_a_rate(program: Program) -> None:
    assert measure(program, 0.001) > 0.0


def test_ratio_is_the_median_over_the_rounds() -> None:
    one, other = Program("vector", FREE, COMPILED), Program("vector", FREE)
    rates = {one: [30.0, 20.0, 64.0], other: [2.0, 2.0, 2.0]}
    shown = cells(row_of(Comparison("step", one, other, 16.0), rates))
    assert shown == ("step", FREE, "randomized", "15.0", "10.0 to 32.0", "at least 16", "missed")
    assert cells(row_of(Comparison("step", one, other, 15.0), rates))[-1] == "met"
    assert cells(row_of(Comparison("step", one, other, 0.0), rates))[-2:] == ("-", "-")


def test_programs_of_a_comparison_differ_in_what_is_compared() -> None:
    found = list(comparisons())
    kinds = {"single", "reset", "vector", "evaluate", "held", "gradient"}
    assert {one.program.kind for one in found} == kinds
    assert all(one.program != one.reference for one in found)


def test_section_of_the_page_is_that_of_the_stored_results(tmp_path: Path) -> None:
    results, page = json.loads(STORED.read_text(encoding="utf-8")), tmp_path / "page.md"
    written = (ROOT / "docs" / "performance.md").read_text(encoding="utf-8")
    assert written.endswith(section(results))
    page.write_text(written.replace(" met |", " unknown |"), encoding="utf-8")
    results["rows"][0]["what"] = "a step of another kind"
    write_section(results, page)
    found = page.read_text(encoding="utf-8")
    assert found.endswith(section(results))
    assert "| a step of another kind |" in found


def test_stored_results_are_those_of_all_comparisons() -> None:
    rows = json.loads(STORED.read_text(encoding="utf-8"))["rows"]
    stored = [(row["what"], row["environment"], row["scenario"], row["goal"]) for row in rows]
    assert stored == [
        (one.what, one.program.environment, one.program.scenario, one.goal) for one in comparisons()
    ]
