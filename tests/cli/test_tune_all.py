"""What `prp-gym tune-all` and `prp-gym ship-gains` run, write and print."""

import json
import shutil
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import pytest
from typer.testing import CliRunner

from prp_gym.baselines import CONTROLLERS
from prp_gym.cli.main import app
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.runs import search_plan
from prp_gym.runs.controllers import Controllers
from prp_gym.tuning import load_tuned_controller

RUNNER = CliRunner()
ENVIRONMENT = "PRP-Adaptive-v0"
CONTROLLERS_OF_IT = ("joint_pd", "adaptive")
STEPS = 5
BUDGET = 24 * STEPS * 5  # of five candidates


@pytest.fixture(autouse=True)
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Episodes of a few steps, and no terminal, whatever a build server says."""
    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=STEPS / 500.0))
    for name in ("FORCE_COLOR", "TTY_COMPATIBLE", "COLUMNS"):
        monkeypatch.delenv(name, raising=False)


def run(folder: Path, *options: str) -> Any:
    names = [item for name in CONTROLLERS_OF_IT for item in ("--baseline", name)]
    fixed = ["tune-all", "--env", ENVIRONMENT, *names, "--jobs", "1", "--output", str(folder)]
    return RUNNER.invoke(app, [*fixed, "--budget", str(BUDGET), *options])


def results(folder: Path) -> dict[str, dict[str, Any]]:
    """What the searches have written, but for times and the checksum over them."""
    found = {}
    for path in sorted(folder.glob("*/result.json")):
        content = json.loads(path.read_text(encoding="utf-8"))
        left_out = ("seconds", "command", "checksum")
        found[path.parent.name] = {key: value for key, value in content.items() if key not in left_out}
    return found


def test_every_intended_controller_is_searched_and_an_interrupted_run_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = run(tmp_path / "whole")
    assert whole.exit_code == 0, whole.output
    expected = results(tmp_path / "whole")
    assert set(expected) == {f"{ENVIRONMENT}_{name}" for name in CONTROLLERS_OF_IT}
    for content in expected.values():
        assert content["scenarios"] == ["realistic", "randomized"]
        assert content["budget_steps"] == BUDGET
        assert content["trials"] >= 5
        assert f"{content['validation']['score']:.4f}" in whole.stdout

    def interrupted(search: Any) -> Any:
        if search.task.controller == "adaptive":
            raise KeyboardInterrupt
        return search.run(Controllers())

    with monkeypatch.context() as patch:
        patch.setattr("prp_gym.cli.tune_all.run_or_fail", interrupted)
        assert run(tmp_path / "parts").exit_code != 0
    assert len(results(tmp_path / "parts")) == 1
    assert run(tmp_path / "parts").exit_code == 0
    assert results(tmp_path / "parts") == expected


def test_search_that_fails_does_not_stop_the_others(tmp_path: Path) -> None:
    folder = tmp_path / f"{ENVIRONMENT}_joint_pd"
    folder.mkdir()
    (folder / "study.log").write_text("damaged\n", encoding="utf-8")
    result = run(tmp_path)
    assert result.exit_code == 1
    assert "joint_pd: failed: file" in result.stderr
    assert set(results(tmp_path)) == {f"{ENVIRONMENT}_adaptive"}


def test_budget_is_the_simulated_time_of_an_agent_unless_it_is_given() -> None:
    seconds = search_plan.simulated_seconds("PRP-JointTracking-v0")
    plan = partial(search_plan.plan_search, seed=0, output=Path("x"), command="")
    combination = ("PRP-JointTracking-v0", "joint_pd")
    assert plan(combination, None, 0.5).task.budget == int(seconds * 250)
    assert plan(combination, 1001, 0.5).task.budget == 500
    assert seconds > 100.0


@pytest.mark.parametrize(
    ("options", "error"),
    [
        (("--budget-scale", "0"), InvalidValueError),
        (("--budget-scale", "nan"), InvalidValueError),
        (("--env", "PRP-Nowhere-v0"), UnknownNameError),
        (("--baseline", "joint_pid"), UnknownNameError),
        (("--jobs", "-1"), InvalidValueError),
    ],
)
def test_options_of_which_no_searches_can_be_made_are_refused(
    tmp_path: Path, options: tuple[str, ...], error: type[Exception]
) -> None:
    assert type(run(tmp_path, *options).exception) is error
    assert not list(tmp_path.iterdir())


def test_controller_that_is_not_intended_for_an_environment_is_refused(tmp_path: Path) -> None:
    options = ["--env", "PRP-JointTracking-v0", "--baseline", "impedance", "--output", str(tmp_path)]
    result = RUNNER.invoke(app, ["tune-all", *options])
    assert isinstance(result.exception, InvalidValueError)
    assert "at least one of those intended" in str(result.exception)


def test_results_are_shipped_into_data_files_and_records(tmp_path: Path) -> None:
    assert run(tmp_path / "tuning").exit_code == 0
    for name in CONTROLLERS_OF_IT:
        file = tmp_path / f"{name}.toml"
        shutil.copy(str(CONTROLLERS[name].data.file), file)
        object.__setattr__(CONTROLLERS[name].data, "file", file)
    before = {name: (tmp_path / f"{name}.toml").read_bytes() for name in CONTROLLERS_OF_IT}
    records = tmp_path / "searches"
    try:
        arguments = ["--searches", str(tmp_path / "tuning"), "--output", str(records)]
        result = RUNNER.invoke(app, ["ship-gains", *arguments])
    finally:
        for name in CONTROLLERS_OF_IT:
            module = Path(str(CONTROLLERS["impedance"].data.file)).with_name(f"{name}.toml")
            object.__setattr__(CONTROLLERS[name].data, "file", module)
    assert result.exit_code == 0, result.output
    for name in CONTROLLERS_OF_IT:
        found = load_tuned_controller(records / f"{ENVIRONMENT}_{name}.json")
        changed = (tmp_path / f"{name}.toml").read_bytes() != before[name]
        assert changed == (not found.validation.kept_start)
        told = "gains kept" if found.validation.kept_start else f"written to {name}.toml"
        assert told in result.stdout


def test_folder_without_searches_is_refused(tmp_path: Path) -> None:
    result = RUNNER.invoke(app, ["ship-gains", "--searches", str(tmp_path), "--output", str(tmp_path / "x")])
    assert isinstance(result.exception, InvalidValueError)
    assert not (tmp_path / "x").exists()
