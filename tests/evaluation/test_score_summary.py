"""A summary of scores and the tables that show it: failed episodes are visible and count."""

import json
from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from prp_gym.artifacts import to_plain
from prp_gym.evaluation import Evaluation, ScoreSummary, bootstrap_mean, worst_twentieth
from prp_gym.evaluation.results import describe_evaluation
from prp_gym.evaluation.table import Row, ranked, score_table
from tests.support.synthetic_episodes import Array
from tests.support.synthetic_rows import episode, joints


def evaluation_of(scores: Array, dead: int = 0) -> Evaluation:
    """Episodes of two steps with given scores, of which the last ones stay at 1 rad from the goal."""
    stuck = joints((1.0, 0.0, 0.0))
    rollouts = [
        episode(seed, stuck if seed >= len(scores) - dead else joints(), reward=np.full(2, score))
        for seed, score in enumerate(scores)
    ]
    return Evaluation(rollouts, 0)


def row_of(name: str, evaluation: Evaluation, **changes: object) -> Row:
    text = json.dumps(to_plain({**describe_evaluation(evaluation, name, {}), **changes}))
    return Row.of(json.loads(text))


def shown(*rows: Row) -> dict[str, list[str]]:
    """The cells of each row by its name, in the order of the table."""
    console = Console(file=StringIO(), width=105, force_terminal=False, color_system=None)
    console.print(score_table("title", rows))
    assert isinstance(console.file, StringIO)
    lines = console.file.getvalue().splitlines()
    rule = next(index for index, line in enumerate(lines) if "───" in line)
    return {line.split()[0]: line.split()[1:] for line in lines[rule + 1 :] if line.strip()}


ALIVE = np.linspace(0.96, 0.98, 20)
KILLED = np.concatenate([ALIVE[:15] + 0.02, np.full(5, 0.1)])


def test_controller_that_is_dead_in_five_of_twenty_episodes_falls_in_every_number_but_the_middle() -> None:
    rows = [
        row_of("killed", evaluation_of(KILLED, dead=5)),
        row_of("alive", evaluation_of(ALIVE)),
        row_of("mediocre", evaluation_of(np.full(20, 0.85))),
        row_of("hold", evaluation_of(np.full(20, 0.4)), floor=True),
        row_of("zero_torque", evaluation_of(np.full(20, 0.2)), floor=True),
    ]
    cells = shown(*rows)
    assert list(cells) == ["alive", "mediocre", "killed", "hold", "zero_torque"]
    killed, alive = cells["killed"], cells["alive"]
    assert alive[0] == "0.970"
    assert killed[0] == f"{KILLED.mean():.3f}" == "0.766"
    assert float(killed[2]) > 0.97  # the interquartile mean does not see the dead episodes
    assert killed[3] == "0.100"  # the worst of twenty
    assert float(killed[4]) == pytest.approx((KILLED.mean() - 0.4) / 0.6, abs=5e-4)
    assert killed[5:] == ["0", "0", "0", "25"]
    assert alive[5:] == ["0", "0", "0", "0"]
    assert cells["hold"][:2] == ["(floor)", "0.400"]
    assert cells["hold"][5] == "-"


def test_floors_are_listed_last_whatever_their_score() -> None:
    rows = [row_of("hold", evaluation_of(ALIVE), floor=True), row_of("joint_pd", evaluation_of(ALIVE / 2))]
    assert [row.baseline for row in ranked(rows)] == ["joint_pd", "hold"]
    assert rows[1].summary.skill(rows[0].score.value) < 0.0


def test_skill_is_the_share_of_what_lies_between_the_floor_and_one() -> None:
    summary = ScoreSummary.of({"score": np.full((4, 1), 0.7)}, 0)
    assert summary.skill(0.4) == pytest.approx(0.5)
    assert np.isnan(summary.skill(np.nan))
    assert np.isnan(summary.skill(1.0))


@pytest.mark.parametrize(("count", "worst"), [(1, 1), (19, 1), (20, 1), (39, 1), (40, 2), (100, 5)])
def test_worst_twentieth_is_the_mean_of_the_worst_five_percent(count: int, worst: int) -> None:
    values = np.random.default_rng(0).permutation(count).astype(float)
    assert worst_twentieth(values) == pytest.approx((worst - 1) / 2)


def test_interval_of_the_mean_covers_it_as_often_as_it_says() -> None:
    rng = np.random.default_rng(1)
    hits = 0
    for _ in range(200):
        found = bootstrap_mean(rng.normal(0.5, 0.1, 40), rng, resamples=500)
        hits += found.low <= 0.5 <= found.high
    assert 176 <= hits <= 199  # 95 % of 200 less four standard deviations of 3.1, and not all


def test_record_of_version_0_1_is_read_without_its_missing_columns() -> None:
    record = to_plain(describe_evaluation(evaluation_of(ALIVE), "joint_pd", {}))
    for name in ("interquartile_mean", "worst_twentieth", "failure"):
        del record[name]
    for name in ("failure", "response_settling_time", "unsettled", "excess_energy"):
        del record["episodes"][name], record["median"][name]
    row = Row.of(json.loads(json.dumps(record)))
    cells = shown(row)["joint_pd"]
    assert cells[0] == "0.970"
    assert cells[4:] == ["-"] * 5


def test_evaluation_is_printed_in_one_short_line() -> None:
    text = repr(evaluation_of(KILLED, dead=5))
    assert "20 episodes of PRP-JointTracking-v0" in text
    assert "score 0.766" in text
    assert "25 % unsettled" in text
    assert len(text) < 250
