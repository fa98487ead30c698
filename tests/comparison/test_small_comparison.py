"""Comparisons that lack agents, scenarios, controllers or all policies but one have tables and plots, too."""

import io
import json
from typing import Any

import numpy as np
import pytest
from PIL import Image
from rich.console import Console

from prp_gym.comparison.learning_plots import draw_learning
from prp_gym.comparison.outcome import Outcome
from prp_gym.comparison.plots import draw_compute, draw_profiles, draw_scores
from prp_gym.comparison.table import aggregate_table, condition_table, pairwise_table
from prp_gym.figures.figure_file import figure_content
from prp_gym.tables import ResultTable
from tests.support.synthetic_comparison import agents, learning, record

UNKNOWN = "PRP-Unknown-v0"
RECORDS: dict[str, list[dict[str, Any]]] = {
    "one controller": [record("joint_pd", [0.5, 0.6])],
    "one episode": [record("joint_pd", [0.5]), record("zero_torque", [0.1], "floor")],
    "zero torque alone": [record("zero_torque", [0.1, 0.1], "floor")],
    "zero torque alone in a task without an error": [
        record("zero_torque", [0.1], "floor", environment_id=UNKNOWN)
    ],
    "agents alone": agents("ppo_torque", np.array([[0.4, 0.6], [0.5, 0.6]])),
    "no agents": [
        record("joint_pd", [0.5, 0.6]),
        record("adaptive", [0.6, 0.6], history=learning([0.3, 0.6])),
        record("zero_torque", [0.1, 0.2], "floor"),
    ],
    "no agents in a task without an error": [
        record("joint_pd", [0.5, 0.6], environment_id=UNKNOWN),
        record("zero_torque", [0.1, 0.2], "floor", environment_id=UNKNOWN),
    ],
}


def text_of(table: ResultTable) -> str:
    target = io.StringIO()
    Console(file=target, width=120, color_system=None).print(table)
    return target.getvalue()


@pytest.fixture(params=RECORDS)
def outcome(request: pytest.FixtureRequest) -> Outcome:
    return Outcome.of(RECORDS[request.param], 0)


def test_every_table_shows_what_there_is(outcome: Outcome) -> None:
    (condition,) = outcome.conditions
    shown = text_of(condition_table(condition, 0))
    assert all(entry.policy in shown for entry in condition.entries)
    families = text_of(aggregate_table(outcome.aggregates))
    assert [item.family in families for item in outcome.aggregates] == [True] * len(outcome.aggregates)
    assert outcome.pairwise_comparisons == ()
    assert "randomized" not in text_of(pairwise_table(outcome.pairwise_comparisons))


def test_findings_are_strict_json(outcome: Outcome) -> None:
    plain = json.loads(json.dumps(outcome.to_plain(), allow_nan=False))
    assert [row["policy"] for row in plain["scores"]] == [
        entry.policy for entry in outcome.conditions[0].entries
    ]


@pytest.mark.parametrize("name", ["one controller", "zero torque alone", "no agents"])
def test_every_plot_can_be_drawn(name: str) -> None:
    outcome = Outcome.of(RECORDS[name], 0)
    frames = [
        draw_profiles(outcome.aggregates),
        draw_scores(outcome.conditions, 0),
        draw_compute(outcome.conditions),
    ]
    if outcome.learned:
        frames.append(draw_learning(outcome.conditions))
    for frame in frames:
        with Image.open(io.BytesIO(figure_content(frame, ".png"))) as image:
            assert image.width >= 600
            assert len(image.convert("RGB").getcolors(2**24) or []) > 1  # not blank
