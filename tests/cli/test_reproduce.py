"""The command `prp-gym reproduce`: figures, tables, results, and its exit code."""

import csv
import json
import re
import subprocess
import sys
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from rich.cells import cell_len
from typer.testing import CliRunner

import prp_gym.cli.reproduce as command_module
from prp_gym.cli.main import app, main
from prp_gym.reproduction import load_catalogue
from prp_gym.reproduction.catalogue import Catalogue, read_catalogue
from prp_gym.reproduction.experiment import ExperimentRun
from prp_gym.reproduction.figures import COLORS
from prp_gym.reproduction.run import RecordedRun, record_run

RUNNER = CliRunner()
CATALOGUE = load_catalogue()
FIGURES = (5, 6, 7, 8, 13)
NAMES = [f"figure_{number:02d}" for number in FIGURES]
QUESTIONS = ("6.1", "6.2", "6.3", "6.4")
COUNT = sum(len(CATALOGUE.experiments[number].checks) for number in FIGURES)
CHAPTER = files("prp_gym.reproduction").joinpath("joint_pd.toml").read_text(encoding="utf-8")


@pytest.fixture(autouse=True)
def no_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Variables that make rich take a pipe for a terminal, as some build servers set them."""
    for name in ("FORCE_COLOR", "TTY_COMPATIBLE", "COLUMNS"):
        monkeypatch.delenv(name, raising=False)


def reproduce(folder: Path, *figures: int) -> tuple[int, str]:
    """Exit code and standard output of the command."""
    chosen = [word for number in figures for word in ("--figure", str(number))]
    result = RUNNER.invoke(app, ["reproduce", *chosen, "--output", str(folder)])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.exit_code, result.stdout


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, int, str]:
    """Folder, exit code and output of figures 5 to 8 and 13."""
    folder = tmp_path_factory.mktemp("reproduction") / "new"
    return folder, *reproduce(folder, *FIGURES)


def summary_of(folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return content


def test_reproduction_writes_an_image_and_a_data_file_for_each_figure(
    reproduced: tuple[Path, int, str],
) -> None:
    folder, code, _ = reproduced
    assert code == 0
    expected = {f"{name}.{suffix}" for name in NAMES for suffix in ("png", "csv")}
    assert {path.name for path in folder.iterdir()} == expected | {"index.md", "summary.json"}


@pytest.mark.parametrize("name", NAMES)
def test_figure_is_legible_and_not_empty(reproduced: tuple[Path, int, str], name: str) -> None:
    with Image.open(reproduced[0] / f"{name}.png") as frame:
        assert frame.size == (1000, 700)
        pixels = np.asarray(frame.convert("RGB"), dtype=np.int64)
    first = [int(COLORS[0][at : at + 2], 16) for at in (1, 3, 5)]  # the subject's colour
    blue = (np.abs(pixels - first) < 10).all(axis=-1)
    assert blue.sum() > 500
    border = np.concatenate([pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]])
    assert (border == 255).all()  # nothing is cut off at the edge


def test_data_are_those_of_the_recorded_run(reproduced: tuple[Path, int, str]) -> None:
    with (reproduced[0] / "figure_06.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert header == [
        "time [s]",
        *(
            f"joint_position_{index} [{unit}] {label}"
            for index, unit in ((1, "rad"), (2, "m"), (3, "rad"))
            for label in ("without g", "with g(q)", "reference")
        ),
        "joint_error_3 [rad] without g",
        "joint_error_3 [rad] with g(q)",
    ]
    values = np.array(rows, dtype=np.float64)
    assert values.shape == (3001, len(header))  # until 3 s, at 1000 Hz
    np.testing.assert_allclose(values[:, 0], np.arange(3001) * 1e-3, atol=1e-9)
    fields = record_run(CATALOGUE.runs["pd_without_gravity"]).rollout.fields
    # nine digits are written
    np.testing.assert_allclose(values[:, 4], fields["joint_position"][:3001, 1], rtol=1e-8, atol=1e-12)
    error = fields["desired_joint_position"] - fields["joint_position"]
    np.testing.assert_allclose(values[:, 10], error[:3001, 2], rtol=1e-8, atol=1e-12)


def test_summary_holds_every_check_with_its_numbers(reproduced: tuple[Path, int, str]) -> None:
    content = summary_of(reproduced[0])
    checks = [check for number in FIGURES for check in CATALOGUE.experiments[number].checks]
    assert [row["name"] for row in content["checks"]] == [check.name for check in checks]
    for row in content["checks"]:
        assert row["verdict"] == "pass"
        for measured, predicted, tolerance in zip(
            row["measured"], row["predicted"], row["tolerance"], strict=True
        ):
            assert abs(measured - predicted) <= tolerance
    sag = next(row for row in content["checks"] if row["name"] == "pd_sag")
    assert sag["measured"][2] == pytest.approx(-0.01924, abs=1e-5)  # the printed digits
    assert (sag["figure"], sag["question"], sag["run"]) == (6, "6.2", "pd_without_gravity")
    assert set(content["versions"]) == {"python", "prp-gym", "gymnasium", "mujoco", "numpy", "matplotlib"}
    assert set(content["answers"]) == set(QUESTIONS)


def test_summary_describes_the_recorded_runs(reproduced: tuple[Path, int, str]) -> None:
    runs = summary_of(reproduced[0])["runs"]
    needed = {name for number in FIGURES for name in CATALOGUE.experiments[number].runs}
    assert set(runs) == needed
    row = runs["pd_without_gravity"]
    assert (row["environment"], row["baseline"], row["gains"]) == (
        "PRP-JointRegulation-v0",
        "joint_pd",
        "figures",
    )
    assert (row["scenario"], row["seed"], row["diverged"]) == ("report", 0, False)
    assert row["settings"]["proportional_gain"] == [50.0, 500.0, 50.0]
    assert row["settings"]["gravity"] == "none"
    assert row["keywords"]["control_frequency"] == 1000.0


def test_index_shows_each_figure_with_its_checks_and_explanation(reproduced: tuple[Path, int, str]) -> None:
    text = (reproduced[0] / "index.md").read_text(encoding="utf-8")
    assert re.findall(r"^## Figure (\d+):", text, re.MULTILINE) == [str(number) for number in FIGURES]
    assert f"{len(FIGURES)} figures, {COUNT} checks: {COUNT} pass, 0 explained, 0 FAIL." in text
    for number, name in zip(FIGURES, NAMES, strict=True):
        experiment = CATALOGUE.experiments[number]
        assert f"![Figure {number}]({name}.png)" in text
        assert experiment.reading in text
        assert experiment.explanation in text
        for check in experiment.checks:
            assert check.what.replace("|", "\\|") in text
    assert "-0.01924)" in text
    assert "a second simulation, with Pinocchio" in text
    assert "Overshoot: 100 exp(-πζ/√(1 - ζ²))" in text
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {8}  # seven cells in every line


def test_terminal_shows_verdicts_and_answers(reproduced: tuple[Path, int, str]) -> None:
    folder, _, output = reproduced
    assert max(map(cell_len, output.splitlines())) <= 120
    assert "…" not in output
    assert output.count(" pass ") == COUNT
    assert "[rad, m]" not in output  # a unit for each of three numbers
    assert all(question in output for question in QUESTIONS)
    first_lines = [line.split()[0] for line in output.splitlines() if re.match(r" *\d+ +\d+\.\d ", line)]
    assert first_lines == [str(number) for number in FIGURES]  # once, beside its first check
    assert str(folder / "index.md") in output.replace("\n", "")


def test_same_figure_twice_is_the_same_to_the_bit(reproduced: tuple[Path, int, str], tmp_path: Path) -> None:
    assert reproduce(tmp_path, 13)[0] == 0
    for suffix in ("png", "csv"):
        again = (tmp_path / f"figure_13.{suffix}").read_bytes()
        assert again == (reproduced[0] / f"figure_13.{suffix}").read_bytes()
    rows = [row for row in summary_of(reproduced[0])["checks"] if row["figure"] == 13]
    assert summary_of(tmp_path)["checks"] == rows
    assert summary_of(tmp_path)["answers"] == {}  # 7.1 needs figure 11 too


EXPLANATION = "the other end of the turn"


def broken(bound: float) -> Catalogue:
    """Figure 6 with a prediction that the arm does not meet by 0.038 rad, explained up to a bound, if any."""
    wrong = CHAPTER.replace("-0.019239165]", "0.019239165]")
    assert wrong != CHAPTER
    named = 'name = "pd_sag"\n'
    explained = f'explanation = "{EXPLANATION}"\nexplained_tolerance = {bound}\n' if bound else ""
    return read_catalogue([wrong.replace(named, f"{named}{explained}")])


def recorded_once(run: ExperimentRun, known: dict[str, RecordedRun] = {}) -> RecordedRun:  # noqa: B006
    """The recording of a run, which is simulated the first time."""
    if run.name not in known:
        known[run.name] = record_run(run)
    return known[run.name]


@pytest.mark.parametrize(
    ("bound", "code", "word"), [(0.0, 1, "FAIL"), (0.03, 1, "FAIL"), (0.05, 0, "explained")]
)
def test_exit_code_is_one_for_a_failure_that_nothing_explains(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, bound: float, code: int, word: str
) -> None:
    monkeypatch.setattr(command_module, "load_catalogue", lambda: broken(bound))
    monkeypatch.setattr(command_module, "record_run", recorded_once)
    found, output = reproduce(tmp_path, 6)
    assert found == code
    assert word in output
    (row,) = summary_of(tmp_path)["checks"]
    assert (row["verdict"], row["explanation"]) == (word, EXPLANATION if bound else "")
    assert row["explained_tolerance"] == ([bound] if bound else [])
    text = (tmp_path / "index.md").read_text(encoding="utf-8")
    assert f"| {word} |" in text
    # the figure's own, and the check's where it holds
    assert text.count("**Explanation.**") == (2 if word == "explained" else 1)
    assert (f"up to 0.05 [rad, m, rad]: {EXPLANATION}" in text) == (word == "explained")


def test_figure_that_does_not_exist_ends_with_code_two_and_the_list(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    options = ["reproduce", "--figure", "5", "--figure", "9", "--output", str(tmp_path / "none")]
    monkeypatch.setattr(sys, "argv", ["prp-gym", *options])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 2
    error = capsys.readouterr().err
    assert "unknown figure '09'" in error
    assert "05, 06, 07, 08, 11" in error
    assert list(tmp_path.iterdir()) == []


def test_folder_that_cannot_be_written_is_refused_before_anything_is_simulated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(run: object) -> None:
        raise AssertionError("simulated")

    monkeypatch.setattr(command_module, "record_run", never)
    blocked = tmp_path / "file"
    blocked.write_text("mine")
    result = RUNNER.invoke(app, ["reproduce", "--figure", "5", "--output", str(blocked)])
    assert type(result.exception).__name__ == "OutputError"
    assert blocked.read_text() == "mine"


def test_package_stays_light_until_a_figure_is_drawn() -> None:
    code = "import sys, prp_gym, prp_gym.cli.main; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
