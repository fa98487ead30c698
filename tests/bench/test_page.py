"""Goals, tables, page and figure of the benchmark, from synthetic results."""

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from bench import figures, goals, plot, report
from bench.engines import HEADING
from bench.rounds import CONTACT, FREE, REACHER, Label, find, ratios
from bench.sheets import Sheet, sheets
from prp_gym.errors import UnknownNameError
from prp_gym.physics import batch_simulation
from tests.support.synthetic_bench import make_results, row


def fast(label: Label) -> float:
    """A suite that reaches everything."""
    ours = label.environment != REACHER and not label.kind.startswith("bare")
    loops = {"sync": 0.1, "async": 0.01, "dummy": 0.1}
    return 1000.0 * loops.get(label.kind, 1.0) if ours else 500.0


def slow(label: Label) -> float:
    """A suite that is half as fast as everything else, and slower yet where there are many."""
    ours = label.environment != REACHER and not label.kind.startswith("bare")
    return (500.0 if label.num_envs < 1024 else 100.0) if ours else 1000.0


def test_ratio_is_taken_in_each_round() -> None:
    one, other = Label("single", FREE, 500.0), Label("bare", FREE, 500.0)
    rows = [{**row(one, 1.0), "rates": [2.0, 30.0, 5.0]}, {**row(other, 1.0), "rates": [1.0, 10.0, 5.0]}]
    np.testing.assert_array_equal(ratios(rows, one, other), [2.0, 3.0, 1.0])


def test_contender_that_was_not_measured_is_an_error_not_another_ones_figure() -> None:
    label = Label("single", FREE, 500.0, clock=True)
    with pytest.raises(UnknownNameError):
        find([row(label, 1.0)], Label("single", FREE, 500.0, clock=False))


def test_goals_are_reached_by_a_fast_suite_and_missed_by_a_slow_one() -> None:
    assert {goal.met for goal in goals.goals(make_results(fast))} == {True}
    assert {goal.met for goal in goals.goals(make_results(slow, evaluate_seconds=200.0))} == {False}


def test_goals_have_the_figures_that_were_measured() -> None:
    found = {(goal.what, goal.how): goal for goal in goals.goals(make_results(slow, evaluate_seconds=200.0))}
    single = found["single environment at 500 Hz against Reacher-v5", goals.AS_SHIPPED]
    assert (single.target, single.reached, single.at_least) == (1.3, 0.5, True)
    growth = [goal for goal in found.values() if goal.key == "growth"]
    assert [goal.reached for goal in growth] == [pytest.approx(400.0)] * 2  # % from 500/s to 100/s; rounding
    assert next(goal for goal in found.values() if goal.key == "evaluate").reached == 200.0
    assert {goal.key for goal in found.values()} == {
        *("single", "single_bare", "vector_bare", "vector_sync", "growth", "training", "evaluate")
    }


def test_as_shipped_peers_read_the_clock_and_the_suite_does_not() -> None:
    def clocked(label: Label) -> float:
        return 10.0 if label.clock else 1000.0

    found = {(goal.what, goal.how): goal.reached for goal in goals.goals(make_results(clocked))}
    for what, how in found:
        if (what, goals.WITHOUT_CLOCK) in found and how == goals.AS_SHIPPED:
            assert found[what, how] == pytest.approx(100.0)  # rounding
            assert found[what, goals.WITHOUT_CLOCK] == 1.0


def test_parts_that_were_not_measured_have_no_goals() -> None:
    results = make_results(fast)
    assert goals.goals({"single": results["single"]}) == goals.goals(results)[:4]


def _table(text: str, what: str) -> list[str]:
    """Cells of the page's first line that holds some words."""
    line = next(line for line in text.splitlines() if what in line and line.startswith("|"))
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_page_says_what_was_missed_and_what_limits_it() -> None:
    text = report.page(make_results(slow))
    assert _table(text, "single environment at 500 Hz")[1:] == [
        *("as shipped", "at least 1.3", "0.50", "", "missed")
    ]
    assert _table(text, "`make evaluate`")[-1] == "met"
    assert (
        "**Missed: single environment at 500 Hz against Reacher-v5 (as shipped and clock off for both)."
        in text
    )
    assert "Every goal is met." not in text
    assert "$" not in text


def _limit(text: str, what: str) -> str:
    """What the page says about a goal that was missed."""
    return next(line for line in text.splitlines() if line.startswith(f"**Missed: {what}"))


def test_limits_are_explained_by_the_condition_that_each_goal_is_about() -> None:
    text = report.page(make_results(slow, evaluate_seconds=200.0))
    single = _limit(text, "single environment at 500 Hz")
    assert "a step takes 13.8 µs. Its two substeps of physics take 2.3 µs" in single
    assert "observation take 4.6 µs" in single
    assert "on arrays of 64 rows they take 130.6 µs per environment" in single
    assert "the physics takes 1.4 µs" in _limit(text, "single environment at 50 Hz")
    many = _limit(text, "vector environment, N = 256")
    assert "the physics on all cores takes 256.1 µs, the task 512.2 µs and the wrapper 768.3 µs" in many
    assert "1024.1 µs, 2048.2 µs and 3072.3 µs" in many
    sync = _limit(text, "vector environment, N = 64")
    assert "the physics on all cores 65.0 µs (on one core 65.3 µs), the task 130.0 µs" in sync
    growth = _limit(text, "growth")
    assert "at 500 Hz as follows: physics 65.00 to 4097.00 µs, task 130.00 to 8194.00 µs" in growth
    assert "at 50 Hz: physics 64.10 to 4096.10 µs" in growth
    assert "took 200 s on 2 cores" in _limit(text, "`make evaluate`")


def test_training_is_limited_by_what_is_not_the_environment() -> None:
    text = _limit(report.page(make_results(slow)), "PPO")
    assert "the networks take 50 % of the time, the policy 15 %, the library's other work 5 %" in text
    assert "training would be 0.71 and 0.71 times as fast" in text  # 500/s over 1000/s, without 30 %


def test_gain_without_the_clock_is_that_of_the_peer() -> None:
    def clocked(label: Label) -> float:
        peer = label.environment == REACHER or label.kind.startswith("bare")
        return (1000.0 if label.clock else 1250.0) if peer else 100.0

    text = report.page(make_results(clocked))
    assert "Without the clock Reacher-v5 is 1.25 times as fast" in _limit(text, "single environment at 500")
    assert "Without the clock the bare loop is 1.25 times as fast" in _limit(
        text, "single environment at 50 Hz"
    )


def test_quick_runs_have_the_figures_of_the_goals_that_they_have() -> None:
    results = make_results(slow)
    results["costs"]["steps"] = [row for row in results["costs"]["steps"] if row["num_envs"] == 1]
    found = figures.numbers(results)
    assert "n1_500_task" in found
    assert not {name for name in found if name.startswith(("n64", "growth"))}


def test_page_says_up_to_where_environments_keep_simulation_data() -> None:
    assert batch_simulation._PERSISTENT_UP_TO == figures.KEPT_UP_TO
    text = report.page(make_results(fast))
    assert "Up to N = 128 every environment keeps an `MjData` of its own, about 346 KiB each" in text
    assert "at N = 4096 an environment takes 4.5 KiB" in " ".join(text.split())


def test_page_of_a_fast_suite_names_no_limits() -> None:
    text = report.page(make_results(fast))
    assert "Every goal is met." in text
    assert "missed" not in text.split(HEADING)[0].lower()


def test_page_says_why_a_peer_is_missing() -> None:
    text = report.page(make_results(fast))
    assert _table(text, "FetchReach-v4")[:4] == ["single environment", "FetchReach-v4", "25 Hz", "20"]
    assert "not measured: its installation failed: no wheel" in _table(text, "PandaReach-v3")


def test_page_shows_the_versions_of_peers_and_those_beside_them() -> None:
    rows = next(sheet for sheet in sheets(make_results(fast)) if sheet.name == "peers").rows
    assert [(row[1], row[-1]) for row in rows] == [
        ("FetchReach-v4", "mujoco 3.3.7, gymnasium-robotics 1.4.2"),
        (REACHER, "mujoco 1.0, gymnasium 1.0, numpy 1.0"),
        ("PandaReach-v3", ""),
    ]


def test_page_names_machine_and_versions() -> None:
    text = report.page(make_results(fast))
    assert "Abacus, 2 cores, Linux x86_64, load average 0.10, 0.20, 0.30 at the start; python 1.0" in text


def test_every_row_of_a_table_has_a_cell_a_column() -> None:
    found = sheets(make_results(slow))
    assert {len(row) - len(sheet.headers) for sheet in found for row in sheet.rows} == {0}
    assert (
        len(found) == 1 + 1 + 5 + 1 + 1 + 2 + 1 + 1
    )  # goals, single, conditions, peers, training, costs, memory, shares


def test_vector_tables_show_the_clock_as_it_is_shipped_first() -> None:
    def clocked(label: Label) -> float:
        return 1000.0 if label.clock else 2000.0

    tables: list[Sheet] = [sheet for sheet in sheets(make_results(clocked)) if sheet.name == "vector"]
    cells = {row[0]: row for sheet in tables if FREE in sheet.title for row in sheet.rows}
    assert "1,800 (900)" in cells["native, all cores"]  # the median is 0.9 of a rate
    assert "900 (1,800)" in cells["bare mj_step on all cores"]
    reacher = next(sheet for sheet in tables if REACHER in sheet.title)
    assert "900 (1,800)" in reacher.rows[0]


def test_shares_are_of_the_bare_loop_of_the_same_condition() -> None:
    def rate(label: Label) -> float:
        return {"bare": 100.0, "bare_all_cores": 150.0, "single": 50.0}.get(label.kind, 120.0)

    table = next(sheet for sheet in sheets(make_results(rate)) if sheet.name == "shares")
    complete = {row[3:] for row in table.rows if row[:2] != (CONTACT, "500 Hz")}
    assert complete == {("0.50", *["0.80"] * 6, "1.50")}
    assert {row[-2] for row in table.rows if row[:2] == (CONTACT, "500 Hz")} == {"-"}
    assert [row[:3] for row in table.rows[:2]] == [
        (FREE, "500 Hz", goals.AS_SHIPPED),
        (FREE, "500 Hz", goals.WITHOUT_CLOCK),
    ]


def test_figure_is_drawn_and_written_beside_the_page(tmp_path: Path) -> None:
    results = make_results(fast)
    report.write_page(results, tmp_path)
    assert (tmp_path / "performance.md").read_text(encoding="utf-8") == report.page(results)
    written = (tmp_path / "images" / "throughput.png").read_bytes()
    pixels = np.asarray(Image.open(io.BytesIO(written)))
    assert pixels.shape[:2] == (550, 1100)
    other = np.asarray(Image.open(io.BytesIO(plot.draw(make_results(slow)["vector"]))))
    assert (pixels != other).any()
