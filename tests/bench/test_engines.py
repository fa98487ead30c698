"""The comparison of the engines: what every program measures, and the ratios of the table."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from bench.engine_programs import FORCE, Measured, Program, measure
from bench.engine_training import PARTS
from bench.engines import (
    STORED,
    Comparison,
    cells,
    comparisons,
    row_of,
    section,
    training_row,
    trainings,
    write_section,
)
from bench.rounds import CONTACT, FREE, REACHER
from prp_gym.agents.training.recipes import Recipe
from prp_gym.agents.training.shipped import ShippedGroup
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
    assert measure(program, 0.001).rate > 0.0


@needs_compiler
@pytest.mark.parametrize("engine", [MUJOCO, COMPILED])
def test_training_has_shares_of_its_time(engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    shipped = ShippedGroup.recipe

    def small(group: ShippedGroup) -> Recipe:
        recipe = shipped(group)
        return replace(recipe, n_envs=4, settings={**recipe.settings, "n_steps": 8, "batch_size": 16})

    monkeypatch.setattr(ShippedGroup, "recipe", small)
    found = measure(Program("training", FORCE, engine, "realistic"), 0.001)
    assert found.rate > 0.0
    parts = set(PARTS) - ({"inner controller"} if engine == COMPILED else set())
    assert set(found.shares) == parts
    assert sum(found.shares.values()) == pytest.approx(1.0)
    assert all(0.0 < share < 1.0 for share in found.shares.values())


def test_row_of_a_training_has_the_medians_of_rates_and_shares() -> None:
    program, *_ = trainings(CONTACT)
    given = [
        Measured(rate, {"environment": share, "other": 1.0 - share})
        for rate, share in ((2.0, 0.2), (9.0, 0.5), (3.0, 0.4))
    ]
    assert training_row(program, given) == {
        "environment": CONTACT,
        "engine": "MuJoCo and NumPy",
        "rate": 3.0,
        "shares": {"environment": 0.4, "other": 0.6},
    }


def test_ratio_is_the_median_over_the_rounds() -> None:
    one, other = Program("vector", FREE, COMPILED), Program("vector", FREE)
    rates = {one: [30.0, 20.0, 64.0], other: [2.0, 2.0, 2.0]}
    measured = {program: [Measured(rate, {}) for rate in own] for program, own in rates.items()}
    shown = cells(row_of(Comparison("step", one, other, 16.0), measured))
    assert shown == ("step", FREE, "randomized", "15.0", "10.0 to 32.0", "at least 16", "missed")
    assert cells(row_of(Comparison("step", one, other, 15.0), measured))[-1] == "met"
    assert cells(row_of(Comparison("step", one, other, 0.0), measured))[-2:] == ("-", "-")


def test_programs_of_a_comparison_differ_in_what_is_compared() -> None:
    found = list(comparisons())
    kinds = {"single", "reset", "vector", "evaluate", "held", "gradient", "training"}
    assert {one.program.kind for one in found} == kinds
    assert all(one.program != one.reference for one in found)


def test_section_of_the_page_is_that_of_the_stored_results(tmp_path: Path) -> None:
    results, page = json.loads(STORED.read_text(encoding="utf-8")), tmp_path / "page.md"
    written = (ROOT / "docs" / "performance.md").read_text(encoding="utf-8")
    assert written.endswith(section(results))
    page.write_text(written.replace(" met |", " unknown |"), encoding="utf-8")
    results["rows"][0]["what"] = "a step of another kind"
    results["training"][0]["rate"] = 123.4
    write_section(results, page)
    found = page.read_text(encoding="utf-8")
    assert found.endswith(section(results))
    assert "| a step of another kind |" in found
    assert "| MuJoCo and NumPy | 123 |" in found


def test_stored_results_are_those_of_all_comparisons() -> None:
    rows = json.loads(STORED.read_text(encoding="utf-8"))["rows"]
    stored = [(row["what"], row["environment"], row["scenario"], row["goal"]) for row in rows]
    assert stored == [
        (one.what, one.program.environment, one.program.scenario, one.goal) for one in comparisons()
    ]
