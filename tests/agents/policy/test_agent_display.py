"""What agents show of themselves: a line, a table, their training as a data frame and a figure."""

import numpy as np
import pytest

from prp_gym import list_agents, load_agent
from prp_gym.agents.policy.learned_policy import LearnedPolicy


@pytest.fixture(scope="module")
def agent() -> LearnedPolicy:
    return load_agent(next(name for name in list_agents() if "torque" in name))


def test_text_says_algorithm_mode_environment_and_scores(agent: LearnedPolicy) -> None:
    card = agent.card
    shown = repr(agent)
    assert shown.startswith(
        f"<LearnedPolicy {card.algorithm} of training seed {card.seed}, action mode torque"
    )
    assert f"for {card.environment_id} at {card.control_frequency:g} Hz" in shown
    for name, score in card.scores.items():
        assert f"{score.value:.3f} ({name})" in shown
    assert len(shown) < 300


def test_table_says_what_the_card_says(agent: LearnedPolicy) -> None:
    rows = {row["fact"]: row["value"] for row in agent.table.records}
    assert rows["training"].startswith(f"{agent.card.steps} steps")
    assert rows["training seed"] == str(agent.card.seed)
    assert any(name.startswith("score, scenario") for name in rows)
    assert "<table>" in agent._repr_html_()


def test_data_frame_is_the_learning_curve(agent: LearnedPolicy) -> None:
    pytest.importorskip("pandas")
    frame, curve = agent.to_frame(), agent.card.run.curve
    assert frame["score"].tolist() == [point.score for point in curve]
    np.testing.assert_allclose(
        frame["simulated_seconds"],
        [point.steps / agent.card.control_frequency for point in curve],
        rtol=1e-15,
    )
    assert {f"violations_{kind}" for point in curve for kind in point.violations} <= set(frame.columns)


def test_figure_is_the_learning_curve_with_its_best_score(agent: LearnedPolicy) -> None:
    (axes,) = agent.plot().axes
    (line,) = axes.get_lines()
    scores = [point.score for point in agent.card.run.curve]
    np.testing.assert_array_equal(line.get_ydata(), scores)
    assert [text.get_text() for text in axes.texts] == [f"{max(scores):.3f}"]
    assert axes.get_xlabel() == "simulated time [s]"
