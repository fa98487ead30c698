"""`--format` and the folders of runs, as the commands have them."""

import csv
import io
import json
import re
import signal
import sys
from functools import partial
from pathlib import Path

import gymnasium
import pytest
from typer.testing import CliRunner, Result

from prp_gym.baselines import BASELINES
from prp_gym.cli.main import app, main
from prp_gym.errors import UnknownNameError
from prp_gym.runs.result_folder import latest_folder
from prp_gym.runs.store import JobStore
from tests.cli.test_interrupted import CONTROLLER, ENVIRONMENT, EVALUATE, then_signal

RUNNER = CliRunner()


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder; episodes are short."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=0.2))
    return tmp_path


def invoke(*options: str) -> Result:
    result = RUNNER.invoke(app, options)
    assert result.exit_code == 0, result.output
    return result


def test_json_on_standard_output_is_all_tables_with_the_numbers_of_the_results_file() -> None:
    result = invoke(*EVALUATE, "--format", "json")
    scores, medians = json.loads(result.stdout)["tables"]
    assert scores["title"] == f"{ENVIRONMENT}, scenario randomized: scores"
    assert scores["rows"][0]["controller"] in ("joint_pd", "adaptive")
    records = json.loads((latest_folder("evaluate") / "results.json").read_text())["evaluations"]
    written = {record["baseline"]: record["score"]["value"] for record in records}
    shown = {row["controller"].removesuffix(" (floor)"): row["score"] for row in scores["rows"]}
    assert shown == written
    energy = {record["baseline"]: record["median"]["energy"][0] for record in records}
    found = {row["controller"].removesuffix(" (floor)"): row["energy"] for row in medians["rows"]}
    assert found == energy
    assert "worst twentieth" in result.stderr
    assert "results.json" in result.stderr


def test_list_has_every_form() -> None:
    rows = list(csv.reader(io.StringIO(invoke("list", "--metrics", "--format", "csv").stdout, newline="")))
    assert rows[0] == ["metric", "units", "definition"]
    assert "energy" in [row[0] for row in rows]
    matrix = json.loads(invoke("list", "--matrix", "--format", "json").stdout)["tables"][0]
    assert len(matrix["columns"]) == 1 + len(BASELINES)
    row = next(row for row in matrix["rows"] if row["environment"] == ENVIRONMENT)
    assert (row["joint_pd"], row["impedance"]) == (True, False)
    assert r"\begin{tabular}{llll}" in invoke("list", "--modes", "--format", "latex").stdout
    assert invoke("list", "--algorithms", "--format", "md").stdout.startswith(
        "**learning algorithms**\n\n| alg"
    )


def test_form_that_does_not_exist_is_refused_before_anything_runs(here: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"unknown --format 'jsno'\. Did you mean 'json'"):
        RUNNER.invoke(app, [*EVALUATE, "--format", "jsno"], catch_exceptions=False)
    assert not list(here.iterdir())


def test_every_run_has_a_folder_and_latest_is_the_last() -> None:
    for name in ("first", "second"):
        invoke(*EVALUATE, "--name", name)
    folders = [path for path in Path("results/evaluate").iterdir() if path.name != "latest"]
    assert sorted(path.name.rpartition("_")[2] for path in folders) == ["first", "second"]
    assert all(re.match(r"\d{4}-\d\d-\d\d_\d\d-\d\d-\d\d_", path.name) for path in folders)
    assert latest_folder("evaluate").resolve().name.endswith("_second")
    for path in folders:
        assert sorted(item.name for item in path.iterdir()) == ["results.json", "run.json"]


def test_interrupted_run_goes_on_in_its_folder_and_a_finished_one_is_left_alone(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(JobStore, "keep", then_signal(JobStore.keep, signal.SIGTERM))
        patch.setattr(sys, "argv", ["prp-gym", *EVALUATE])
        with pytest.raises(SystemExit) as ended:
            main()
    assert ended.value.code == 143
    assert "1 of 4 jobs are kept in results/evaluate/" in " ".join(capsys.readouterr().err.split())
    (begun,) = (path for path in Path("results/evaluate").iterdir() if path.name != "latest")
    assert [path.name for path in (begun / "jobs").iterdir()]
    again = invoke(*EVALUATE)
    assert "1 of 4 jobs were finished by an interrupted run" in " ".join(again.stderr.split())
    assert sorted(path.name for path in begun.iterdir()) == ["results.json", "run.json"]
    before = (begun / "results.json").read_bytes()
    invoke(*EVALUATE)
    assert (begun / "results.json").read_bytes() == before
    assert len(list(Path("results/evaluate").iterdir())) == 3  # two runs, and latest


def test_fresh_run_leaves_the_unfinished_one_alone() -> None:
    other = (
        "evaluate",
        "--env",
        ENVIRONMENT,
        "--baseline",
        CONTROLLER,
        "--scenario",
        "report",
        "--jobs",
        "1",
    )
    begun = Path("results/evaluate/2026-01-01_00-00-00")
    begun.mkdir(parents=True)
    invoke(*other, "--fresh")
    assert not list(begun.iterdir())
    assert (latest_folder("evaluate") / "results.json").exists()
