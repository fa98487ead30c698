"""The command `prp-gym`: its lists, its help, its programs, and its way of refusing."""

import re
import subprocess
import sys
from pathlib import Path

import gymnasium
import pytest
from typer.testing import CliRunner

from prp_gym import list_envs
from prp_gym.action_modes import ACTION_MODES
from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.baselines import BASELINES, list_baselines
from prp_gym.baselines.base.gains import gain_sets
from prp_gym.cli.main import app, main
from prp_gym.evaluation.metrics import METRICS
from prp_gym.tasks.scenario import SCENARIOS
from prp_gym.tasks.spec import TASKS
from tests.cli.test_evaluate_output import COMMON_SETS, WIDTH, results_of
from tests.support.controller_episodes import controllers_of

RUNNER = CliRunner()


@pytest.fixture(autouse=True)
def no_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Variables that make rich take a pipe for a terminal, as some build servers set them."""
    for name in ("FORCE_COLOR", "TTY_COMPATIBLE", "COLUMNS"):
        monkeypatch.delenv(name, raising=False)


def plain(text: str) -> str:
    """A text without a terminal's colours."""
    return re.sub(r"\x1b\[[0-9;]*m", "", text)


def refusal(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *options: str) -> str:
    """What the command says on standard error as it ends with exit code 2, on one line."""
    monkeypatch.setattr(sys, "argv", ["prp-gym", *options])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 2
    output, error = capsys.readouterr()
    assert "Traceback" not in output + error
    return " ".join(error.split())


def test_list_of_modes_names_them_all_with_their_inner_controllers() -> None:
    result = RUNNER.invoke(app, ["list", "--modes"])
    assert result.exit_code == 0
    rows = [line.split() for line in plain(result.output).splitlines() if line.strip()]
    found = {
        row[0]: row[1] for row in rows if row[0] in ACTION_MODES and row[1] in BASELINES
    }  # not folded lines
    assert found == {n: spec.entry.controller for n, spec in ACTION_MODES.items() if not spec.is_family}
    assert "residual:<controller>" in result.output


def test_list_of_algorithms_names_them_all_with_their_classes() -> None:
    result = RUNNER.invoke(app, ["list", "--algorithms"])
    assert result.exit_code == 0
    rows = [line.split() for line in plain(result.output).splitlines() if line.strip()]
    found = {row[0]: row[-1] for row in rows if row[0] in ALGORITHMS}
    assert found == {n: f"{s.entry.package}.{s.entry.class_name}" for n, s in ALGORITHMS.items()}


def test_list_of_metrics_names_them_all_with_their_definitions() -> None:
    result = RUNNER.invoke(app, ["list", "--metrics"])
    assert result.exit_code == 0
    lines = plain(result.output).splitlines()
    starts = [(number, line.split()[0]) for number, line in enumerate(lines) if line[1:2].strip()]
    words = set(result.output.split())
    assert [name for _, name in starts if name in METRICS] == list(METRICS)
    assert all(set(metric.definition.split()) <= words for metric in METRICS.values())


WRONG_NAMES = [
    ("--env", "PRP-JointTracking-v1", "unknown environment", list_envs()),
    ("--baseline", "joint_pdd", "unknown baseline", list(BASELINES)),
    ("--scenario", "reprot", "unknown scenario", list(SCENARIOS)),
    ("--gains", "tunde", "unknown gain set", COMMON_SETS),
    ("--backend", "lokky", "unknown backend", ["loky", "ray"]),
]


@pytest.mark.parametrize(("option", "name", "message", "valid"), WRONG_NAMES)
def test_wrong_name_is_refused_with_the_valid_ones(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    option: str,
    name: str,
    message: str,
    valid: list[str],
) -> None:
    error = refusal(capsys, monkeypatch, "evaluate", option, name, "--output", str(tmp_path / "results"))
    assert error.startswith(f"error: {message}")
    assert f"'{name}'. Did you mean '" in error
    listed = set(re.split(r"[ ,.]+", error.split("Valid:")[1]))
    assert set(valid) <= listed
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("--episodes", "-1", "error: episodes is -1; allowed: a whole number, at least 1, at most 1000000."),
        ("--episodes", "0", "error: episodes is 0; allowed: a whole number, at least 1, at most 1000000."),
        ("--seed", "-3", "error: seed is -3; allowed: a whole number, at least 0, of at most 128 bits."),
        ("--jobs", "-1", "error: jobs is -1; allowed: at least 1, or 0 for as many as there are cores."),
    ],
)
def test_number_that_is_not_allowed_is_refused(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    option: str,
    value: str,
    message: str,
) -> None:
    error = refusal(capsys, monkeypatch, "evaluate", option, value, "--output", str(tmp_path / "results"))
    assert error.endswith(message)
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        (["evaluate", "--episodes", "two"], "integer"),
        (["evaluate", "--nothing"], "--nothing"),
        (["eval"], "eval"),
        (["list", "--all"], "--all"),
    ],
)
def test_command_line_that_cannot_be_read_is_refused(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, options: list[str], fault: str
) -> None:
    error = plain(refusal(capsys, monkeypatch, *options))
    assert "Usage: " in error
    assert "--help" in error
    assert fault in error.split("Error")[1]


def test_list_shows_every_environment_controller_scenario_and_gain_set() -> None:
    result = RUNNER.invoke(app, ["list"])
    assert result.exit_code == 0
    assert "…" not in result.stdout
    assert max(map(len, result.stdout.splitlines())) <= WIDTH
    words = re.split(r"[\s,│┃]+", result.stdout)
    shown = [
        *list_envs(),
        *BASELINES,
        *SCENARIOS,
        *(name for controller in BASELINES for name in gain_sets(controller)),
    ]
    assert set(shown) <= set(words)
    for summary in (
        *(entry.summary for entry in TASKS.values()),
        *(controller.summary for controller in BASELINES.values()),
    ):
        assert set(re.split(r"[\s,]+", summary)) <= set(words)  # a long one takes several lines


def test_list_tells_which_controller_runs_where_and_why_not() -> None:
    output = RUNNER.invoke(app, ["list", "--matrix"]).stdout
    assert "…" not in output
    assert max(map(len, output.splitlines())) <= WIDTH
    for controller in BASELINES:  # a name's parts stand below each other
        assert set(controller.split("_")) <= set(output.replace("_", " ").split())
    rows: dict[str, list[str]] = {}
    for first, *cells in (line.split() for line in output.splitlines() if line.strip()):
        if {"yes", "-"} >= set(cells):  # further controllers stand in a second table
            rows[first] = [*rows.get(first, []), *cells]
    for environment_id in list_envs():
        made = gymnasium.make(environment_id)
        layout = made.get_wrapper_attr("observation_layout")
        made.close()
        eligible = list_baselines(layout)
        overlay = ["yes" if controller in eligible else "-" for controller in BASELINES]
        assert rows[environment_id.removeprefix("PRP-").removesuffix("-v0")] == overlay
        for controller in BASELINES:
            for field in BASELINES[controller].missing_fields(layout):
                (reason,) = re.findall(rf"{field}: read by (.*?)(?:\n\w+:|\Z)", output, re.DOTALL)
                assert controller in reason
                assert environment_id in reason


def test_help_names_every_command_and_option() -> None:
    assert all(name in RUNNER.invoke(app, ["--help"]).output for name in ("evaluate", "list"))
    text = plain(RUNNER.invoke(app, ["evaluate", "--help"]).output)
    options = (
        "--env",
        "--baseline",
        "--scenario",
        "--episodes",
        "--seed",
        "--gains",
        "--output",
        "--jobs",
        "--backend",
        "--fresh",
    )
    assert [option for option in options if option not in text] == []


COMMAND = [str(Path(sys.executable).with_name("prp-gym"))]
MODULE = [sys.executable, "-m", "prp_gym.cli.main"]
SMALLEST = min(list_envs(), key=lambda name: len(controllers_of(name)))
"""The environment with the fewest controllers."""
AT_50_HZ = ("--gains", "tuned_50hz", "--control-frequency", "50")
RUN_AT_50_HZ = [name for name in controllers_of(SMALLEST) if "tuned_50hz" in gain_sets(name)]


@pytest.mark.parametrize("program", [COMMAND, MODULE], ids=["command", "module"])
def test_program_evaluates_and_keeps_progress_off_standard_output(tmp_path: Path, program: list[str]) -> None:
    options = ["evaluate", "--env", SMALLEST, "--scenario", "report", "--jobs", "1", *AT_50_HZ]
    options += [word for name in RUN_AT_50_HZ for word in ("--baseline", name)]
    done = subprocess.run(
        [*program, *options], cwd=tmp_path, capture_output=True, text=True, encoding="utf-8", check=True
    )
    assert [controller for controller in RUN_AT_50_HZ if controller not in done.stdout] == []
    assert done.stdout.startswith(f"{SMALLEST}, scenario report")
    assert (
        results_of(tmp_path / "results" / "evaluate" / "latest")["command"] == f"prp-gym {' '.join(options)}"
    )


def test_program_refuses_with_exit_code_two_and_no_traceback(tmp_path: Path) -> None:
    options = ["evaluate", "--env", "PRP-Nothing-v0"]
    done = subprocess.run(
        [*COMMAND, *options], cwd=tmp_path, capture_output=True, text=True, encoding="utf-8"
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert "Traceback" not in done.stderr
    assert all(environment_id in done.stderr for environment_id in list_envs())
    assert list(tmp_path.iterdir()) == []


def test_folder_that_cannot_be_written_is_refused_before_anything_is_run(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def never(*_: object) -> None:
        raise AssertionError("run")

    monkeypatch.setattr("prp_gym.runs.run.run_job", never)
    blocked = tmp_path / "file"
    blocked.write_text("mine")
    jobs = ("--env", list_envs()[0], "--baseline", "joint_pd", "--scenario", "report", "--jobs", "1")
    options = (*jobs, "--output", str(blocked))
    assert refusal(capsys, monkeypatch, "evaluate", *options).startswith(
        f"error: cannot write to '{blocked}'"
    )
    assert blocked.read_text() == "mine"
