"""What evaluations and episodes show of themselves: a line, a small table, a data frame, a figure."""

import sys
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import gymnasium
import numpy as np
import pytest

from prp_gym.errors import InvalidValueError, MissingPackageError
from prp_gym.evaluation import Evaluation, Rollout, evaluate
from prp_gym.evaluation.quantities import UNITS
from tests.support.synthetic_rows import KINDS, episode

LONGEST_LINE = 300


@pytest.fixture(scope="module")
def evaluation() -> Evaluation:
    return Evaluation([episode(seed) for seed in (3, 4)], 3)


def texts(html: str, tag: str) -> list[str]:
    return ["".join(cell.itertext()) for cell in ElementTree.fromstring(html).iter(tag)]


def test_text_of_a_real_evaluation_is_one_short_line() -> None:
    with gymnasium.make("PRP-Adaptive-v0", duration=0.1) as env:
        from prp_gym import make_baseline

        real = evaluate(make_baseline("joint_pd", env), env, episodes=2)
    for shown in (repr(real), str(real), repr(real.rollouts[0]), str(real.rollouts[0])):
        assert len(shown) < LONGEST_LINE
        assert "\n" not in shown
        assert "PRP-Adaptive-v0, scenario randomized" in shown
        assert "score 0." in shown


def test_text_of_an_episode_says_how_long_it_was_and_whether_it_diverged(evaluation: Evaluation) -> None:
    assert repr(evaluation.rollouts[0]) == (
        "<Rollout of 2 periods (0.02 s) of PRP-JointTracking-v0, scenario randomized, seed 3: score 0.500>"
    )
    assert repr(episode(diverged=True)).endswith("score 0.500, diverged>")


def test_score_of_an_episode_is_over_the_planned_periods() -> None:
    assert replace(episode(), duration=0.04).score == 0.25


def test_table_of_an_evaluation_has_scores_failures_and_the_metrics_of_the_task(
    evaluation: Evaluation,
) -> None:
    rows = {row["quantity"]: row for row in evaluation.table.records}
    assert rows["score"]["value"] == 0.5
    assert rows["score, 95 % interval"]["value"] == [0.5, 0.5]
    assert rows["failed: unsettled"]["value"] in (0.0, 100.0)
    assert rows["median joint RMSE"]["unit"] == "mrad, mm"
    np.testing.assert_allclose(
        rows["median joint RMSE"]["value"], 1e3 * evaluation.median["joint_rmse"], rtol=1e-12
    )


def test_notebook_shows_a_small_table(evaluation: Evaluation) -> None:
    html = evaluation._repr_html_()
    assert len(html) < 10_000
    assert texts(html, "caption") == ["2 episodes of PRP-JointTracking-v0, scenario randomized"]
    assert texts(html, "th") == ["quantity", "value", "unit"]
    assert texts(html, "td")[:3] == ["score", "0.500", "1"]
    assert "seed" in texts(evaluation.rollouts[0]._repr_html_(), "td")


def test_data_frame_of_an_evaluation_has_a_row_for_each_episode(evaluation: Evaluation) -> None:
    pytest.importorskip("pandas")
    frame = evaluation.to_frame()
    assert frame["seed"].tolist() == [3, 4]
    assert frame["score"].tolist() == [0.5, 0.5]
    np.testing.assert_array_equal(frame["joint_rmse_2"], evaluation.metrics["joint_rmse"][:, 1])
    assert frame.attrs["units"]["joint_rmse_2"] == "m"
    assert "energy" in frame  # one component has no number


def test_data_frame_of_an_episode_has_a_row_for_each_time() -> None:
    pytest.importorskip("pandas")
    rollout = episode(fields=KINDS["force"])
    frame = rollout.to_frame()
    assert frame["time"].tolist() == pytest.approx([0.0, 0.01, 0.02])
    np.testing.assert_array_equal(frame["contact_force_1"], rollout.fields["contact_force"][:, 0])
    assert frame["reward"].tolist()[:2] == [0.5, 0.5]
    assert np.isnan(frame["reward"].iloc[-1])
    assert np.isnan(frame["info_cost_saturation"].iloc[-1])
    assert frame.attrs["units"]["contact_force_1"] == "N"
    assert frame.attrs["units"]["torque_2"] == "N"


def test_every_field_of_the_recorded_tasks_has_units() -> None:
    recorded = {name for fields in KINDS.values() for name in fields}
    assert recorded <= set(UNITS)


def test_missing_pandas_is_named_with_its_install_line(
    evaluation: Evaluation, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(
        MissingPackageError, match=r"pandas is not installed; .* pip install 'prp-gym\[pandas\]'"
    ):
        evaluation.to_frame()


def test_figure_is_of_the_episode_that_is_asked_for(evaluation: Evaluation) -> None:
    assert "seed 4" in evaluation.plot(episode=1).get_suptitle()
    assert "seed 3, joint_pd: mean reward 0.500" in evaluation.plot(policy="joint_pd").get_suptitle()
    with pytest.raises(
        InvalidValueError, match="episode is 2; allowed: a whole number, at least 0, at most 1"
    ):
        evaluation.plot(episode=2)


def test_rollout_has_the_torque_limit_of_its_environment() -> None:
    with gymnasium.make("PRP-JointTracking-v0", duration=0.02, torque_limit=[30.0, 60.0, 7.0]) as env:
        from prp_gym import make_baseline

        (rollout,) = evaluate(make_baseline("joint_pd", env), env, episodes=1).rollouts
    assert isinstance(rollout, Rollout)
    np.testing.assert_array_equal(rollout.torque_limit, [30.0, 60.0, 7.0])
