"""`prp-gym plot`: one run as a figure."""

import xml.etree.ElementTree as ElementTree
from functools import partial
from pathlib import Path

import gymnasium
import pytest
from PIL import Image
from typer.testing import CliRunner

from prp_gym import evaluate, list_agents, make_baseline
from prp_gym.cli.main import app
from prp_gym.errors import InvalidValueError, UnknownNameError

RUNNER = CliRunner()
ADAPTIVE = "PRP-Adaptive-v0"


@pytest.fixture(autouse=True)
def short_episodes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Episodes that end soon after the first touch."""
    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=1.0))


def texts(figure: Path) -> str:
    """The text of an SVG."""
    return " ".join("".join(ElementTree.parse(figure).getroot().itertext()).split())


def test_figure_shows_the_episode_that_evaluate_runs(tmp_path: Path) -> None:
    target = tmp_path / "mine" / "force.svg"
    options = ["--baseline", "parallel_force_position", "--scenario", "realistic", "--seed", "7"]
    result = RUNNER.invoke(
        app, ["plot", "PRP-Force-v0", *options, "--gains", "report", "--output", str(target)]
    )
    assert result.exit_code == 0, result.output
    assert f"figure: {target}" in result.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]
    assert [path.name for path in target.parent.iterdir()] == ["force.svg"]
    with gymnasium.make("PRP-Force-v0", scenario="realistic") as env:
        found = evaluate(make_baseline("parallel_force_position", env, "report"), env, episodes=1, seed=7)
    shown = texts(target)
    assert "PRP-Force-v0, scenario realistic, seed 7, parallel_force_position (report)" in shown
    assert f"mean reward {found.rollouts[0].score:.3f}" in shown
    for part in ("tip position", "contact force", "[mrad]", "reference", "actuator limit", "tip in contact"):
        assert part in shown


def test_default_is_a_folder_of_its_own_and_a_controller_that_is_meant_for_the_task(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for _ in range(2):
        result = RUNNER.invoke(app, ["plot", ADAPTIVE, "--name", "first"])
        assert result.exit_code == 0, result.output
    figures = sorted(Path("results/plot").glob("*_first/figure.png"))
    assert len(figures) == 2
    assert str(Path("results/plot/latest/figure.png").resolve()) in [str(path.resolve()) for path in figures]
    with Image.open(figures[0]) as image:
        assert image.size[0] == 1000


def test_setting_stands_in_the_title(tmp_path: Path) -> None:
    target = tmp_path / "a.svg"
    options = ["--baseline", "joint_pd", "--set", "proportional_gain=50", "--output", str(target)]
    assert RUNNER.invoke(app, ["plot", ADAPTIVE, *options]).exit_code == 0
    assert "joint_pd (tuned, proportional_gain=50)" in texts(target)


def test_agent_is_drawn_in_its_own_environment(tmp_path: Path) -> None:
    name = list_agents(ADAPTIVE)[0]
    target = tmp_path / "a.pdf"
    result = RUNNER.invoke(app, ["plot", ADAPTIVE, "--agent", name, "--output", str(target)])
    assert result.exit_code == 0, result.output
    assert target.read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        (["PRP-Forces-v0"], UnknownNameError, "Did you mean 'PRP-Force-v0'"),
        ([ADAPTIVE, "--scenario", "realistc"], UnknownNameError, "Did you mean 'realistic'"),
        ([ADAPTIVE, "--baseline", "joint_pid"], UnknownNameError, "Did you mean 'joint_pd'"),
        ([ADAPTIVE, "--output", "a.jpg"], InvalidValueError, r"ends in \.png, \.svg, \.pdf"),
        ([ADAPTIVE, "--baseline", "joint_pd", "--agent", "x"], InvalidValueError, "one of the two"),
        ([ADAPTIVE, "--agent", "x", "--set", "a=1"], InvalidValueError, "--set is .*not with --agent"),
        (
            ["PRP-Force-v0", "--agent", list_agents(ADAPTIVE)[0]],
            InvalidValueError,
            "agent is .*; allowed: one that was trained on PRP-Force-v0",
        ),
        ([ADAPTIVE, "--seed", "-1"], InvalidValueError, "seed is -1"),
    ],
)
def test_what_cannot_be_drawn_is_refused_before_anything_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[str], error: type[Exception], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(error, match=message):
        RUNNER.invoke(app, ["plot", *options], catch_exceptions=False)
    assert not list(tmp_path.iterdir())
