"""A metric that another package declares is computed, shown and documented as the suite's own are."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from docs.metrics_page import metrics_page
from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.evaluation import (
    METRICS,
    Column,
    Metric,
    MetricGroup,
    Presentation,
    episode_metrics,
    register_metric,
)
from prp_gym.evaluation.results import describe_run
from prp_gym.evaluation.table import Row, evaluation_table
from tests.support.synthetic_episodes import GOAL, joint_fields, jump, make_rollout, reference
from tests.support.synthetic_rows import summary

SWING = Metric(
    "swing",
    ("rad",),
    "range of the first joint's position",
    ("joint_position",),
    lambda rollout: float(np.ptp(rollout.fields["joint_position"][:, 0])),
    Presentation(MetricGroup("Range of motion"), Column("swing", ("mrad",), 1e3), known_as="stroke"),
)
EPISODE = make_rollout(joint_fields(jump(3), reference()))


@pytest.fixture
def swing() -> Iterator[Metric]:
    yield register_metric(SWING)
    METRICS.unregister("swing")


def test_registered_metric_is_computed_after_the_suites_own(swing: Metric) -> None:
    values = episode_metrics(EPISODE)
    assert list(METRICS)[-1] == list(values)[-1] == "swing"
    np.testing.assert_array_equal(values["swing"], [GOAL[0]])
    assert describe_run("")["units"]["swing"] == ("rad",)


def test_registered_metric_has_its_column_and_its_row_on_the_page(swing: Metric) -> None:
    score = summary(0.5, 0.4, 0.6)
    row = Row("joint_pd", 2, score, {"swing": np.array([0.0123])}, 1e-5)
    table = evaluation_table("title", [row], ["swing"])
    assert table.columns[3].label == "swing [mrad]"
    assert table.records[0]["swing"] == pytest.approx(12.3, rel=1e-12)
    assert table.rows[0][3].text == "12"
    page = metrics_page()
    assert "## Range of motion\n" in page
    assert (
        "| `swing` | rad | range of the first joint's position | stroke | lower | `joint_position` |" in page
    )


def test_metric_without_a_group_is_listed_last() -> None:
    assert (replace(SWING, presentation=Presentation()).group, SWING.chapter) == ("Other", 1000.0)
    assert max(metric.chapter for metric in METRICS.values()) <= SWING.chapter


def test_name_that_another_metric_has_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="name of metric is 'energy'"):
        register_metric(replace(SWING, name="energy"))


def test_column_of_other_components_than_the_metric_is_refused() -> None:
    with pytest.raises(InvalidValueError, match=r"column of metric 'swing' is \('mrad',\); allowed: 2"):
        replace(SWING, units=("rad", "m"))


def test_function_that_returns_other_components_than_units_is_refused() -> None:
    wrong = replace(SWING, compute=lambda rollout: np.zeros(2))
    with pytest.raises(ShapeError, match=r"metric 'swing' has shape \(2,\); expected \(1,\)"):
        wrong.values(EPISODE)
