"""Content and width of the tables of a comparison."""

import io

import numpy as np
import pytest
from rich.console import Console

from prp_gym.comparison.outcome import Outcome
from prp_gym.comparison.table import (
    aggregate_table,
    condition_table,
    effort_table,
    pairwise_table,
    spread_table,
)
from prp_gym.tables import ResultTable
from tests.support.synthetic_comparison import agents, learning, record

WIDTH = 120
LONG = "operational_inverse_dynamics"
ID = "PRP-JointRegulation-v0"
SCORES = np.linspace(0.5, 0.9, 9)


def printed(table: ResultTable, width: int = WIDTH) -> str:
    target = io.StringIO()
    Console(file=target, width=width, color_system=None).print(table)
    text = target.getvalue()
    assert "…" not in text
    return text


def cells(table: ResultTable, name: str) -> list[str]:
    """Words of the only line that has a name."""
    (line,) = (line for line in printed(table).splitlines() if name in line)
    return line.split()


@pytest.fixture
def outcome() -> Outcome:
    """A condition with the longest names that there are, and with metrics of joint regulation."""
    records = [
        record("joint_pd", SCORES),
        record(LONG, SCORES + 0.05, history=learning([0.2, 0.3])),
        *agents(
            f"recurrent_ppo_residual-{LONG}",
            SCORES[None] - [[0.2], [0.1], [0.3]],
            mode=f"residual:{LONG}",
            history=learning([0.2, 0.9], steps=[10**5, 2 * 10**6]),
        ),
    ]
    for item in records:
        item["environment"] = ID
        item["episodes"]["settling_time"] = [[1.0]] * 8 + [["inf"]]
        item["episodes"]["steady_state_error"] = [[0.01, 0.0, 0.0]] * 9
    return Outcome.of(records, 0)


def test_condition_has_one_line_for_each_policy_best_first(outcome: Outcome) -> None:
    lines = printed(condition_table(outcome.conditions[0], 0)).splitlines()
    assert lines[0].strip() == f"{ID}, scenario randomized"
    rows = [line.split()[:2] for line in lines if any(f" 0.{score} " in line for score in (750, 700, 500))]
    assert rows == [[LONG, "0.750"], ["joint_pd", "0.700"], [LONG, "0.500"]]


def test_median_is_over_training_seeds_and_episodes() -> None:
    made = agents("a", np.array([[0.9, 0.8], [0.1, 0.2]]))
    line = cells(condition_table(Outcome.of(made, 0).conditions[0], 0), " a ")
    assert line[0] == "a"
    # errors of joint 1: 0.01, 0.02, 0.09, 0.08 rad, median 50 mrad; joint 2 half, joint 3 twice of it
    assert line[3:6] == ["50", "25", "100"]


def test_pairwise_comparison_takes_two_lines(outcome: Outcome) -> None:
    table = pairwise_table(outcome.pairwise_comparisons)
    lines = printed(table).splitlines()
    (controller,) = (line.split() for line in lines if " 0.750 " in line)
    (agent,) = (line.split() for line in lines if " -0.250 " in line)
    assert [controller[:2], controller[-2]] == [["JointRegulation", "randomized"], "0.750"]
    assert (agent[-8], agent[-6]) == ("0.500", "-0.250")
    assert agent[-3:] == ["0.00", "yes", "controller"]
    one, other = table.records
    assert one["environment"] == other["environment"] == ID
    assert one["best_controller_then_best_agent"] == LONG
    assert other["agent_minus_controller"] == pytest.approx(-0.25, abs=1e-12)
    assert one["better"] is None


@pytest.mark.parametrize("width", [80, 100])
def test_no_table_is_cut_off_in_a_narrow_terminal(outcome: Outcome, width: int) -> None:
    tables = (
        pairwise_table(outcome.pairwise_comparisons),
        *(spread_table(outcome.conditions), aggregate_table(outcome.aggregates)),
        *(effort_table(outcome.efforts), condition_table(outcome.conditions[0], 0)),
    )
    for table in tables:
        lines = printed(table, width).splitlines()
        assert max(map(len, lines)) <= width
        numbers = [
            row[index].text for row in table.rows for index in range(len(row)) if table.columns[index].numeric
        ]
        assert all(number in " ".join(lines) for number in numbers)


def test_spread_is_median_and_range(outcome: Outcome) -> None:
    assert cells(spread_table(outcome.conditions), "0.600")[-3:] == ["3", "0.500", "0.400-0.600"]


def test_effort_that_never_arrived_and_large_numbers_are_readable(outcome: Outcome) -> None:
    table = printed(effort_table(outcome.efforts))
    (never,) = (line for line in table.splitlines() if "never" in line)
    (reached,) = (line for line in table.splitlines() if "3 of 3" in line)
    assert " ".join(never.split()[-10:]) == "0.750 0.300 0 of 1 never never never 40 2"
    assert " ".join(reached.split()[-13:]) == "0.750 0.900 3 of 3 2 M 40 k 0.333 40 k 2"


def test_aggregate_is_shown_beside_the_best_controller_on_the_same_tasks(outcome: Outcome) -> None:
    line = cells(aggregate_table(outcome.aggregates), "best agent")
    assert (line[-4:-2], line[-1]) == (["1", "0.500"], "0.750")
