"""`--json` writes the results as one JSON document, `--quiet` nothing beside the results."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import pytest
from typer.testing import CliRunner, Result

from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.baselines import BASELINES
from prp_gym.cli.main import app
from prp_gym.tasks.registration import list_envs
from prp_gym.tasks.scenario import SCENARIOS

TASK = "PRP-Adaptive-v0"


def run(*command: str) -> Result:
    result = CliRunner().invoke(app, command)
    assert result.exit_code in (0, 1), result.output
    return result


def document(*command: str) -> Any:
    return json.loads(run(*command, "--json").stdout)


def test_list_has_the_names_that_it_shows() -> None:
    found = document("list")
    assert [row["id"] for row in found["environments"]] == list_envs()
    assert [row["controller"] for row in found["controllers"]] == list(BASELINES)
    assert [row["scenario"] for row in found["scenarios"]] == list(SCENARIOS)
    assert [row["algorithm"] for row in document("list", "--algorithms")["learning_algorithms"]] == list(
        ALGORITHMS
    )
    (row,) = (
        row
        for row in document("list", "--matrix")["controllers_by_environment"]
        if row["environment"] == TASK
    )
    assert "impedance" not in row["controllers"]
    assert "joint_pd" in row["controllers"]


@pytest.fixture
def short_episodes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=0.02))


@pytest.mark.parametrize("command", ["evaluate", "compare", "audit"])
def test_document_is_what_the_results_file_holds(
    command: str, tmp_path: Path, short_episodes: None, unwritten_figures: None
) -> None:
    options = ("-e", TASK, "-s", "realistic", "-n", "2", "-j", "1", "-o", str(tmp_path))
    more = ("--draws", "1") if command == "audit" else ("-b", "joint_pd", "-b", "adaptive")
    found = document(command, *options, *more)
    assert len(found.pop("tables")) >= 2
    assert found == json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert {row["environment"] for row in found["evaluations"]} == {TASK}


def test_document_of_a_search_is_its_result(tmp_path: Path, short_episodes: None) -> None:
    options = ("joint_pd", "-e", TASK, "--budget", "100", "-n", "2", "-o", str(tmp_path))
    found = document("tune", *options)
    assert [row["settings"] for row in found.pop("tables")[0]["rows"]] == ["start", "result"]
    kept = json.loads((tmp_path / f"{TASK}_joint_pd" / "result.json").read_text(encoding="utf-8"))
    assert found.items() <= kept.items()
    assert (found["environment"], found["controller"], found["trials"]) == (TASK, "joint_pd", 5)


def test_quiet_command_writes_its_tables_without_notes(tmp_path: Path, short_episodes: None) -> None:
    options = ("-e", TASK, "-b", "joint_pd", "-s", "report", "-j", "1", "-o", str(tmp_path))
    loud, quiet = run("evaluate", *options), run("evaluate", *options, "-q")
    assert "score: mean over episodes" in loud.stdout
    assert "score: mean over episodes" not in quiet.stdout
    assert "joint_pd" in quiet.stdout
    assert f"results: {tmp_path}" in quiet.stdout.replace("\n", "")
    assert quiet.stderr == ""


def test_error_leaves_standard_output_empty_also_with_json(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["evaluate", "-e", "PRP-Nowhere-v0", "--json", "-o", str(tmp_path)])
    assert result.exit_code != 0
    assert result.stdout == ""
